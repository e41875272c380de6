//! Coordinate criteria: which sensors disagree, over all pairs of modes.
//!
//! The columns of both sets are paired: column r of one belongs to column r of the other. A mode that a sensor did not
//! measure (NaN) is left out for that sensor.

use super::mac::unit_scale;
use super::{ShapeScalar, modal_scale_factor};
use crate::linalg::DMatrix;

/// Coordinate modal assurance criterion.
///
/// ```text
///             (Σ_r |φ_a[i,r] φ_x[i,r]|)²
/// COMAC[i] = ──────────────────────────────     i = sensor, r = mode pair
///            Σ_r |φ_a[i,r]|²  Σ_r |φ_x[i,r]|²
/// ```
///
/// * `phi_a`, `phi_x` - paired shapes, (n_sensor x n_pairs)
///
/// In [0, 1], `None` for a sensor that does not move in one of the sets. It uses magnitudes, so it cannot see a sensor
/// of wrong sign or a uniformly wrong gain, and unlike scales of the modes weight them unlike; see [`scaled_comac`] and
/// [`enhanced_comac`]. With one pair it is always 1.
///
/// # Panics
/// If the shapes of the matrices differ.
///
/// # Source
/// N. A. J. Lieven, D. J. Ewins, Spatial correlation of mode shapes, the coordinate modal assurance criterion (COMAC),
/// Proc. 6th IMAC, 1988, 690-695.
pub fn comac<T: ShapeScalar>(phi_a: &DMatrix<T>, phi_x: &DMatrix<T>) -> Vec<Option<f64>> {
    assert_eq!(phi_a.shape(), phi_x.shape(), "paired shapes at the same sensors");
    (0..phi_a.nrows())
        .map(|i| {
            let (mut cross, mut norm_a, mut norm_x) = (0.0, 0.0, 0.0);
            let scale = |phi: &DMatrix<T>| unit_scale(phi.row(i).iter().copied());
            let (scale_a, scale_x) = (scale(phi_a), scale(phi_x));
            for (&a, &x) in phi_a.row(i).iter().zip(phi_x.row(i).iter()) {
                if a.is_measured() && x.is_measured() {
                    let (a, x) = (a.scale(scale_a), x.scale(scale_x));
                    cross += a.modulus() * x.modulus();
                    norm_a += a.modulus_squared();
                    norm_x += x.modulus_squared();
                }
            }
            let is_moving = norm_a > 0.0 && norm_x > 0.0;
            is_moving.then(|| (cross / norm_a.sqrt() / norm_x.sqrt()).powi(2).min(1.0))
        })
        .collect()
}

/// COMAC of shapes of equal weight: every experimental shape has unit length, every analytical one is brought to it by
/// its modal scale factor.
///
/// ```text
/// φ̂_x = φ_x/‖φ_x‖,   φ̂_a = MSF φ_a with MSF = φ_aᴴ φ̂_x / φ_aᴴ φ_a;   then COMAC of φ̂_a, φ̂_x
/// ```
///
/// The result does not depend on how any mode is scaled. A pair of badly matched shapes has a small φ̂_a and so counts
/// little in the analytical sum. Values and limits otherwise as [`comac`].
///
/// # Panics
/// If the shapes of the matrices differ.
///
/// # Source
/// E. Balmès et al., Structural Dynamics Toolbox, user's guide, `ii_mac` (scaled COMAC, COMACS).
pub fn scaled_comac<T: ShapeScalar>(phi_a: &DMatrix<T>, phi_x: &DMatrix<T>) -> Vec<Option<f64>> {
    let (a, x) = to_common_scale(phi_a, phi_x, |a, x| modal_scale_factor(a, x));
    comac(&a, &x)
}

/// Enhanced COMAC: mean difference of shapes of unit length and common sign or phase.
///
/// ```text
///              Σ_r |φ̂_a[i,r] - φ̂_x[i,r]|
/// eCOMAC[i] = ───────────────────────────     both of unit length, φ̂_a turned to the phase of φ̂_x
///                     2 n_pairs
/// ```
///
/// * `phi_a`, `phi_x` - paired shapes, (n_sensor x n_pairs)
///
/// 0 is perfect, larger is worse (at most 1); `None` for a sensor without any measured pair. It sees wrong signs and
/// gains. A sensor at large motion shows larger values for the same relative error, and one very bad sensor raises all
/// others a little through the common scale.
///
/// # Panics
/// If the shapes of the matrices differ.
///
/// # Source
/// D. L. Hunt, Application of an enhanced coordinate modal assurance criterion, Proc. 10th IMAC, 1992, 66-71.
pub fn enhanced_comac<T: ShapeScalar>(phi_a: &DMatrix<T>, phi_x: &DMatrix<T>) -> Vec<Option<f64>> {
    let (a, x) = to_common_scale(phi_a, phi_x, |a, x| {
        let factor = modal_scale_factor(a, x);
        let norm = common_norm(a, x);
        let modulus = factor.modulus();
        if modulus > 0.0 && norm > 0.0 { factor.unscale(modulus).unscale(norm) } else { T::zero() }
    });
    (0..a.nrows())
        .map(|i| {
            let differences: Vec<f64> = a
                .row(i)
                .iter()
                .zip(x.row(i).iter())
                .filter(|(a, x)| a.is_measured() && x.is_measured())
                .map(|(&a, &x)| (a - x).modulus())
                .collect();
            let count = differences.len();
            (count > 0).then(|| differences.iter().sum::<f64>() / (2.0 * count as f64))
        })
        .collect()
}

/// Experimental columns of unit length and analytical columns times `factor(φ_a, unit φ_x)`; lengths over the sensors
/// that both have.
fn to_common_scale<T: ShapeScalar>(
    phi_a: &DMatrix<T>,
    phi_x: &DMatrix<T>,
    factor: impl Fn(&[T], &[T]) -> T,
) -> (DMatrix<T>, DMatrix<T>) {
    assert_eq!(phi_a.shape(), phi_x.shape(), "paired shapes at the same sensors");
    let (mut a, mut x) = (phi_a.clone(), phi_x.clone());
    for r in 0..a.ncols() {
        let norm = common_norm(x.column(r).as_slice(), a.column(r).as_slice());
        if norm > 0.0 {
            x.column_mut(r).apply(|v| *v = v.unscale(norm));
        }
        let scale = factor(a.column(r).as_slice(), x.column(r).as_slice());
        a.column_mut(r).apply(|v| *v *= scale);
    }
    (a, x)
}

/// ‖v‖ over the entries measured in both.
fn common_norm<T: ShapeScalar>(v: &[T], other: &[T]) -> f64 {
    let common = v.iter().zip(other).filter(|(a, b)| a.is_measured() && b.is_measured());
    let scale = unit_scale(v.iter().copied());
    common.map(|(a, _)| a.scale(scale).modulus_squared()).sum::<f64>().sqrt() / scale
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Sensor 1 by hand: (1*2 + 2*1)²/((1+4)(4+1)) = 16/25.
    #[test]
    fn comac_by_hand() {
        let a = DMatrix::from_row_slice(3, 2, &[1.0, 1.0, 1.0, 2.0, 0.0, 0.0]);
        let x = DMatrix::from_row_slice(3, 2, &[-3.0, 3.0, 2.0, -1.0, 1.0, 1.0]);
        let values = comac(&a, &x);
        assert!((values[0].unwrap() - 1.0).abs() < 1e-15); // blind to the sign
        assert!((values[1].unwrap() - 16.0 / 25.0).abs() < 1e-15);
        assert_eq!(values[2], None);
    }

    /// Unit shapes (0.6, 0.8) with the second sensor reversed: MSF = 0.36 - 0.64 < 0 turns φ_a, so the first sensor
    /// differs by 2 * 0.6 and the second by 0; turned by the larger part. Halved: 0.6 and 0.
    #[test]
    fn enhanced_comac_by_hand() {
        let a = DMatrix::from_column_slice(2, 1, &[6.0, 8.0]);
        let x = DMatrix::from_column_slice(2, 1, &[0.3, -0.4]);
        let values = enhanced_comac(&a, &x);
        assert!((values[0].unwrap() - 0.6).abs() < 1e-15);
        assert!(values[1].unwrap() < 1e-15);
    }

    #[test]
    fn a_reversed_sensor_stands_out_in_the_enhanced_criterion_only() {
        let a = DMatrix::from_fn(9, 3, |i, j| (0.3 * (i + 1) as f64 * (j + 1) as f64).sin());
        let mut x = &a * 2.0;
        x.row_mut(4).neg_mut();
        assert!(comac(&a, &x).iter().all(|v| (v.unwrap() - 1.0).abs() < 1e-14));
        let enhanced: Vec<f64> = enhanced_comac(&a, &x).into_iter().flatten().collect();
        let worst = (0..9).max_by(|&i, &j| enhanced[i].total_cmp(&enhanced[j]));
        assert_eq!(worst, Some(4));
    }

    #[test]
    fn unmeasured_modes_are_left_out() {
        let a = DMatrix::from_fn(4, 3, |i, j| 1.0 + (i * (j + 1)) as f64);
        let mut x = a.clone();
        x[(0, 1)] = f64::NAN;
        x.row_mut(3).fill(f64::NAN);
        for values in [comac(&a, &x), scaled_comac(&a, &x)] {
            assert!((values[0].unwrap() - 1.0).abs() < 1e-14);
            assert_eq!(values[3], None);
        }
        let enhanced = enhanced_comac(&a, &x);
        assert!(enhanced[0].unwrap() < 1e-15 && enhanced[3].is_none());
    }

    proptest! {
        #[test]
        fn scaled_criteria_do_not_depend_on_the_scale_of_modes(
            values in prop::collection::vec(-1.0..1.0f64, 30), scales in prop::collection::vec(0.01..100.0f64, 3)
        ) {
            let a = DMatrix::from_fn(5, 3, |i, j| values[3 * i + j]);
            let x = DMatrix::from_fn(5, 3, |i, j| values[15 + 3 * i + j]);
            let rescaled = DMatrix::from_fn(5, 3, |i, j| x[(i, j)] * scales[j] * if j == 1 { -1.0 } else { 1.0 });
            for criterion in [scaled_comac::<f64>, enhanced_comac::<f64>] {
                for (one, other) in criterion(&a, &x).iter().zip(criterion(&a, &rescaled)) {
                    let (one, other) = (one.unwrap(), other.unwrap());
                    prop_assert!((one - other).abs() < 1e-9 && (0.0..=1.0).contains(&one));
                }
            }
        }
    }
}
