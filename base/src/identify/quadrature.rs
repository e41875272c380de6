//! Quadrature picking: shapes from imaginary parts at known natural frequencies, corrected for neighbouring modes.
//!
//! At the natural frequency of mode i the imaginary part at a sensor is the sum of what all modes give there:
//!
//! ```text
//! v_i = Σ_j W_ij q_j,   q_j = imaginary part of mode j alone at its own frequency,   r = f_i/f_j
//!
//! receptance   W_ij = (2ζ_j)² r  / ((1 - r²)² + (2ζ_j r)²)       displacement over force; equation (3) as printed
//! accelerance  W_ij = (2ζ_j)² r³ / ((1 - r²)² + (2ζ_j r)²)       acceleration over force
//! hysteretic   W_ij = (2ζ_j)²    / ((1 - r²)² + (2ζ_j)²)         structural damping, loss factor 2ζ_j
//! raw          W = I
//! ```
//! so that the shapes, as rows, are W⁻¹ times the imaginary parts. The printed equation has the weights of receptance. Used on accelerance it is slightly wrong; on the
//! shapes of a swept flying wing it costs 3e-4 of MAC where the right weight costs 5e-7.
//!
//! Sources: A. Gupta, C. P. Moreno, H. Pfifer, G. J. Balas, Updating a finite element based structural model of a small
//! flexible aircraft, AIAA SciTech, 2015, equation (3); C. V. Stahle, W. R. Forlifer, Ground vibration testing of complex
//! structures, 1958, for the hysteretic form.

use super::IdentifyError;
use super::layout::check_layout;
use crate::data::{FrfQuantity, FrfSet};
use retune_linalg::{Complex, DMatrix};
use std::f64::consts::TAU;

/// The weights of the correction for neighbouring modes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum QuadratureForm {
    /// No correction.
    Raw,
    /// Equation (3) as printed: exact for receptance with viscous damping.
    Receptance,
    /// With r³: exact for accelerance with viscous damping.
    Accelerance,
    /// Exact for receptance with structural damping.
    Hysteretic,
}

/// Shapes by quadrature picking.
#[derive(Debug, Clone, PartialEq)]
pub struct QuadratureShapes {
    /// Imaginary part of each mode alone at its frequency (responses x modes), in the unit of the FRF.
    pub shapes: DMatrix<f64>,
    /// W (modes x modes).
    pub matrix: DMatrix<f64>,
    /// Condition number of W: noise of the imaginary parts grows by up to this factor.
    pub condition: f64,
}

/// The matrix W of the correction (modes x modes): row i, the frequency; column j, the mode that contributes.
///
/// * `frequencies_hz` - natural frequencies
/// * `damping_ratios` - one per mode
///
/// # Errors
/// Lists of different length; frequencies or damping ratios that are not positive.
pub fn quadrature_matrix(
    frequencies_hz: &[f64],
    damping_ratios: &[f64],
    form: QuadratureForm,
) -> Result<DMatrix<f64>, IdentifyError> {
    let n = frequencies_hz.len();
    if damping_ratios.len() != n {
        let what = "the list of damping ratios";
        return Err(IdentifyError::Length { what, expected: n, found: damping_ratios.len() });
    }
    for (what, list) in [("frequency", frequencies_hz), ("damping ratio", damping_ratios)] {
        if let Some(index) = list.iter().position(|x| !(x.is_finite() && *x > 0.0)) {
            return Err(IdentifyError::NotPositive { what, index, value: list[index] });
        }
    }
    Ok(DMatrix::from_fn(n, n, |i, j| {
        let r = frequencies_hz[i] / frequencies_hz[j];
        let two_zeta = 2.0 * damping_ratios[j];
        let detuning = (1.0 - r * r).powi(2);
        let viscous = detuning + (two_zeta * r).powi(2);
        match form {
            QuadratureForm::Raw => f64::from(u8::from(i == j)),
            QuadratureForm::Receptance => two_zeta * two_zeta * r / viscous,
            QuadratureForm::Accelerance => two_zeta * two_zeta * r.powi(3) / viscous,
            QuadratureForm::Hysteretic => two_zeta * two_zeta / (detuning + two_zeta * two_zeta),
        }
    }))
}

/// Shapes at the responses from the imaginary parts at the natural frequencies, for one reference.
///
/// Values between lines are interpolated linearly in the complex FRF. Mobility, whose resonances show in the real part,
/// is turned into accelerance first; receptance and accelerance are taken as they are.
///
/// * `reference` - index of the reference
/// * `frequencies_hz`, `damping_ratios` - of the modes
///
/// # Errors
/// Frequencies outside the lines, lists of different length, two modes so close that W is singular.
pub fn quadrature_shapes(
    frfs: &FrfSet,
    reference: usize,
    frequencies_hz: &[f64],
    damping_ratios: &[f64],
    form: QuadratureForm,
) -> Result<QuadratureShapes, IdentifyError> {
    check_layout(frfs)?;
    if reference >= frfs.references.len() {
        let (what, found) = ("the list of references", frfs.references.len());
        return Err(IdentifyError::Length { what, expected: reference + 1, found });
    }
    let matrix = quadrature_matrix(frequencies_hz, damping_ratios, form)?;
    let lines = &frfs.frequencies_hz;
    let mut v = DMatrix::zeros(frfs.responses.len(), frequencies_hz.len());
    for (j, &f) in frequencies_hz.iter().enumerate() {
        let above = lines.partition_point(|x| *x < f);
        if above >= lines.len() || (above == 0 && lines[0] > f) {
            let (low, high) = (lines.first().copied().unwrap_or(0.0), lines.last().copied().unwrap_or(0.0));
            return Err(IdentifyError::OutsideLines { frequency: f, low, high });
        }
        let below = above.saturating_sub(1);
        let t = if above == below { 0.0 } else { (f - lines[below]) / (lines[above] - lines[below]) };
        for o in 0..frfs.responses.len() {
            let h = frfs.at(below, reference, o) * (1.0 - t) + frfs.at(above, reference, o) * t;
            let turned = if frfs.quantity == FrfQuantity::Mobility { h * Complex::new(0.0, TAU * f) } else { h };
            v[(o, j)] = turned.im;
        }
    }
    let condition = condition(&matrix);
    // 1/ε of single precision: beyond it nothing of a measurement is left.
    let inverse = matrix.clone().try_inverse().filter(|_| condition < 1e7);
    let inverse = inverse.ok_or(IdentifyError::Singular { what: "equations of quadrature picking" })?;
    Ok(QuadratureShapes { shapes: v * inverse.transpose(), matrix, condition })
}

fn condition(matrix: &DMatrix<f64>) -> f64 {
    let s = matrix.singular_values();
    if s.is_empty() { 1.0 } else { s.max() / s.min() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_form_has_ones_on_the_diagonal() {
        for form in
            [QuadratureForm::Raw, QuadratureForm::Receptance, QuadratureForm::Accelerance, QuadratureForm::Hysteretic]
        {
            let w = quadrature_matrix(&[3.0, 5.0], &[0.02, 0.03], form).unwrap();
            assert!((w[(0, 0)] - 1.0).abs() < 1e-12 && (w[(1, 1)] - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn bad_lists_are_named() {
        let e = quadrature_matrix(&[3.0, 5.0], &[0.02], QuadratureForm::Raw).unwrap_err();
        assert_eq!(e.to_string(), "the list of damping ratios has 1 entries, expected 2");
        let e = quadrature_matrix(&[3.0, -5.0], &[0.02, 0.1], QuadratureForm::Raw).unwrap_err();
        assert_eq!(e.to_string(), "frequency 1 is -5; it must be positive and finite");
    }
}
