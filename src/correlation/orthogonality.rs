//! Orthogonality of shapes in a mass matrix reduced to the sensors.
//!
//! The mass comes from [`crate::modal::reduction`]; the reduction's own error shows in the result, so look at the
//! auto-orthogonality of the model's own modes first: what they miss, no test can reach.

use super::{CorrelationError, ShapeScalar};
use crate::linalg::DMatrix;

/// Generalised mass of two sets of shapes.
///
/// ```text
/// Φ_aᴴ M Φ_x     (n_a x n_x), kg times the units of both shapes
/// ```
///
/// * `phi_a`, `phi_x` - shapes at the sensors (or at all dofs), complete, (n x n_a), (n x n_x)
/// * `mass` - symmetric mass matrix of the same rows, (n x n)
pub fn generalized_mass<T: ShapeScalar>(
    phi_a: &DMatrix<T>,
    mass: &DMatrix<f64>,
    phi_x: &DMatrix<T>,
) -> Result<DMatrix<T>, CorrelationError> {
    let n = mass.nrows();
    for (set, phi) in [("analytical", phi_a), ("experimental", phi_x)] {
        if phi.nrows() != n || mass.ncols() != n {
            return Err(CorrelationError::Shape {
                what: set,
                rows: phi.nrows(),
                columns: phi.ncols(),
                expected: format!("as many rows as the {} x {} mass matrix", n, mass.ncols()),
            });
        }
        if let Some(mode) = (0..phi.ncols()).find(|&j| phi.column(j).iter().any(|v| !v.is_measured())) {
            return Err(CorrelationError::IncompleteShape { set, mode });
        }
    }
    Ok(phi_a.adjoint() * (mass.map(T::from_real) * phi_x))
}

/// Auto-orthogonality: generalised mass of a set scaled to a unit diagonal.
///
/// ```text
/// O[i,j] = φ_iᴴ M φ_j / √(φ_iᴴ M φ_i · φ_jᴴ M φ_j)     (n x n), unit diagonal, moduli at most 1
/// ```
///
/// Identity for the modes of a structure with this mass. Test practice asks for moduli off the diagonal below 0.1 (see
/// the criteria profiles). Cannot tell whether the test shapes or the reduced mass are at fault. A shape without mass
/// gives zeros.
pub fn auto_orthogonality<T: ShapeScalar>(
    phi: &DMatrix<T>,
    mass: &DMatrix<f64>,
) -> Result<DMatrix<T>, CorrelationError> {
    cross_orthogonality(phi, mass, phi)
}

/// Cross-orthogonality of analytical with experimental shapes, each scaled to unit modal mass.
///
/// ```text
/// XOR[i,j] = φ_a[i]ᴴ M φ_x[j] / √(φ_a[i]ᴴ M φ_a[i] · φ_x[j]ᴴ M φ_x[j])     (n_a x n_x)
/// ```
///
/// * `phi_a`, `phi_x` - complete shapes at the sensors
/// * `mass` - mass reduced to the sensors
///
/// Moduli in [0, 1]; the sign or phase is that between the shapes as given. Its squared modulus is the mass-weighted MAC.
/// Weighs motion by the mass that moves, so it says more about forces than the MAC, and inherits the reduction's error.
///
/// # Source
/// D. J. Ewins, Modal Testing: Theory, Practice and Application, 2nd edition 2000, section 6.3.
pub fn cross_orthogonality<T: ShapeScalar>(
    phi_a: &DMatrix<T>,
    mass: &DMatrix<f64>,
    phi_x: &DMatrix<T>,
) -> Result<DMatrix<T>, CorrelationError> {
    let mut cross = generalized_mass(phi_a, mass, phi_x)?;
    let (scale_a, scale_x) = (unit_mass_scales(phi_a, mass), unit_mass_scales(phi_x, mass));
    for i in 0..cross.nrows() {
        for j in 0..cross.ncols() {
            cross[(i, j)] = cross[(i, j)].scale(scale_a[i]).scale(scale_x[j]);
        }
    }
    Ok(cross)
}

/// 1/√(φᴴ M φ) of every column, 0 where there is no mass.
fn unit_mass_scales<T: ShapeScalar>(phi: &DMatrix<T>, mass: &DMatrix<f64>) -> Vec<f64> {
    let weighted = mass.map(T::from_real) * phi;
    (0..phi.ncols())
        .map(|j| {
            let modal_mass = phi.column(j).dotc(&weighted.column(j)).real();
            if modal_mass > 0.0 { 1.0 / modal_mass.sqrt() } else { 0.0 }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlation::mac::tests::peer_shapes;
    use crate::correlation::weighted_mac_matrix;
    use crate::linalg::Complex;

    fn peer_mass() -> DMatrix<f64> {
        DMatrix::from_fn(6, 6, |i, j| match i.abs_diff(j) {
            0 => (i + 1) as f64,
            1 => 0.3,
            _ => 0.0,
        })
    }

    /// sdynpy 0.23.0, `sdynpy_correlation.orthog(A, M, X)`, on the shapes of the MAC tests.
    #[test]
    fn peer_gives_the_same_generalised_mass() {
        let (a, x) = peer_shapes();
        #[rustfmt::skip]
        let expected = DMatrix::from_row_slice(3, 2, &[
            16.956121444383754,  -8.553368750439212,
            1.186046330081436,   13.294997063546433,
            -0.8991848060413657,  2.63130501680213,
        ]);
        assert!((generalized_mass(&a, &peer_mass(), &x).unwrap() - expected).abs().max() < 1e-13);
    }

    #[test]
    fn squared_cross_orthogonality_is_the_weighted_mac() {
        let (a, x) = peer_shapes();
        let xor = cross_orthogonality(&a, &peer_mass(), &x).unwrap();
        let wmac = weighted_mac_matrix(&a, &x, &peer_mass());
        assert!((xor.component_mul(&xor) - wmac).abs().max() < 1e-14);
        let turned = x.map(|v| Complex::from_polar(2.0, 1.0) * v);
        let complex = cross_orthogonality(&crate::correlation::to_complex(&a), &peer_mass(), &turned).unwrap();
        assert!((complex.map(Complex::norm) - xor.abs()).abs().max() < 1e-14);
    }

    #[test]
    fn unusable_shapes_are_named() {
        let (a, mut x) = peer_shapes();
        x[(3, 1)] = f64::NAN;
        let error = cross_orthogonality(&a, &peer_mass(), &x).unwrap_err();
        assert_eq!(
            error.to_string(),
            "experimental mode 1 (from 0) is not measured at every sensor; leave that sensor out of the mass, or the mode out of the set"
        );
        let small = DMatrix::identity(5, 5);
        assert!(matches!(cross_orthogonality(&a, &small, &a), Err(CorrelationError::Shape { .. })));
    }
}
