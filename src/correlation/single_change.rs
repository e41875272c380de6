//! One change at a time: which element's stiffness, changed alone, would explain most of the disagreement.
//!
//! Sharper than an energy where one thing is wrong, since each element answers with its own pattern over all sensors and
//! frequencies; blind to what no element's stiffness can do.

use super::CorrelationError;
use super::statistics::Gaussian;
use super::union::union_probability;
use crate::linalg::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, Normal};

/// One element, changed alone.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct SingleChange {
    /// Name of the element (or group).
    pub name: String,
    /// Relative change of its stiffness that fits best: -0.2 says that the structure has 20 % less than the model. It stays within ±1:
    /// less than no stiffness there is not, and far beyond twice of it the linear estimate says nothing.
    pub change: f64,
    /// Whether the change stands at ±1, and the linear estimate beyond.
    pub is_limited: bool,
    /// Its standard deviation from the noise of the test.
    pub sd: f64,
    /// change/sd: a standard normal number under noise alone.
    pub z: f64,
    /// Probability that noise alone gives a z as large, for this element.
    pub p_value: f64,
    /// Share of chi-squared that the change takes away.
    pub share: f64,
}

/// Elements ranked by how much they explain.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct SingleChanges {
    /// The elements, best explanation first; those without any effect on the data are left out.
    pub changes: Vec<SingleChange>,
    /// Probability that noise alone gives the largest |z| of all elements.
    pub p_family: f64,
    /// Chi-squared of the residuals that were explained.
    pub chi_squared: f64,
}

/// The best single change, element by element.
///
/// ```text
/// r(δ) = r + d δ,    δ = -dᵀr/dᵀd,    σ_δ = 1/‖d‖,    z = δ/σ_δ,    χ² falls by z² - (z - δ'/σ_δ)²
/// ```
///
/// with δ' = δ within ±1.
///
/// * `residuals` - (model - test)/σ, free scales taken out, (n_data)
/// * `effects` - ∂r/∂δ of each element as columns, δ relative, (n_data x n_elements)
///
/// Under noise alone each z is standard normal; `p_family` is the probability of the largest |z|, by seeded draws of noise
/// on the same columns to a standard error of a tenth of itself, or the bound n p (Bonferroni) where that is below 1e-4.
/// Linear: a change of 20 % is seen a little too small or too large, in the right place. A ranking, not a proof: elements
/// whose columns are nearly parallel cannot be told apart (equal shares say so).
///
/// # Source
/// Score test with one degree of freedom; for damage by sensitivities: M. I. Friswell, J. E. T. Penny, D. A. L. Wilson,
/// Using vibration data and statistical measures to locate damage in structures, Modal Analysis 9 (1994) 239-254.
pub fn single_changes(
    residuals: &DVector<f64>,
    effects: &DMatrix<f64>,
    names: &[String],
) -> Result<SingleChanges, CorrelationError> {
    let n = effects.ncols();
    if effects.nrows() != residuals.len() || names.len() != n {
        let expected = format!("{} rows and a column for each of {} names", residuals.len(), names.len());
        return Err(CorrelationError::Shape { what: "effects", rows: effects.nrows(), columns: n, expected });
    }
    let chi_squared = residuals.norm_squared();
    let norms: Vec<f64> = effects.column_iter().map(|d| d.norm()).collect();
    // Effects below a millionth of the largest are rounding noise.
    let floor = 1e-6 * norms.iter().copied().fold(0.0, f64::max);
    let seen: Vec<usize> = (0..n).filter(|&e| norms[e] > floor).collect();
    let mut units = effects.select_columns(&seen);
    for (mut column, &e) in units.column_iter_mut().zip(&seen) {
        column.unscale_mut(norms[e]);
    }
    let scores = -units.tr_mul(residuals);
    let normal = Normal::standard();
    let mut changes: Vec<SingleChange> = seen
        .iter()
        .zip(scores.iter())
        .map(|(&e, &z)| {
            let free = z / norms[e];
            let change = free.clamp(-1.0, 1.0);
            let falls = z * z - (z - change * norms[e]).powi(2);
            SingleChange {
                name: names[e].clone(),
                change,
                is_limited: change != free,
                sd: 1.0 / norms[e],
                z,
                p_value: (2.0 * normal.sf(z.abs())).min(1.0),
                share: if chi_squared > 0.0 { falls / chi_squared } else { 0.0 },
            }
        })
        .collect();
    changes.sort_by(|a, b| b.z.abs().total_cmp(&a.z.abs()));
    let p_family = changes.first().map_or(1.0, |best| family(best, &units));
    changes.sort_by(|a, b| b.share.total_cmp(&a.share));
    Ok(SingleChanges { changes, p_family, chi_squared })
}

/// The probability of the largest |z| under noise.
fn family(best: &SingleChange, units: &DMatrix<f64>) -> f64 {
    /// Below this bound the decision is clear.
    const CLEAR: f64 = 1e-4;
    let bound = units.ncols() as f64 * best.p_value;
    if bound < CLEAR {
        return bound;
    }
    let (normal, level) = (Normal::standard(), best.z.abs());
    let tail = normal.sf(level);
    let draw = |e: usize, gaussian: &mut Gaussian| {
        let mut noise = DVector::from_fn(units.nrows(), |_, _| gaussian.next());
        // The component along the column of this element, drawn from its tail.
        let beyond = -normal.inverse_cdf(tail * gaussian.uniform());
        let signed = if gaussian.uniform() < 0.5 { -beyond } else { beyond };
        let along = units.column(e).dot(&noise);
        noise.axpy(signed - along, &units.column(e), 1.0);
        noise
    };
    let rows = units.transpose();
    union_probability(&vec![best.p_value; units.ncols()], level, draw, |batch| {
        let noise = DMatrix::from_fn(units.nrows(), batch.len(), |i, j| batch[j].1[i]);
        let z = &rows * noise;
        // The drawn element is there by construction, but for rounding.
        let happened =
            |e: usize, draw: usize| (0..units.ncols()).filter(|&k| k == e || z[(k, draw)].abs() >= level).count();
        batch.iter().enumerate().map(|(draw, (e, _))| happened(*e, draw)).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(n: usize) -> Vec<String> {
        (0..n).map(|i| format!("e{i}")).collect()
    }

    /// By hand: d = (2, 0) and (0, 1), r = (1, -0.3): δ = -1/2 and 0.3, z = -1 and 0.3, shares 1/1.09 and 0.09/1.09.
    #[test]
    fn the_change_by_hand() {
        let effects = DMatrix::from_row_slice(2, 3, &[2.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        let found = single_changes(&nalgebra::dvector![1.0, -0.3], &effects, &names(3)).unwrap();
        let best = &found.changes[0];
        assert_eq!((best.name.as_str(), best.change, best.sd, best.z), ("e0", -0.5, 0.5, -1.0));
        assert!((best.share - 1.0 / 1.09).abs() < 1e-15 && (best.p_value - 0.317_310_507_862_914).abs() < 1e-10);
        assert_eq!((found.changes.len(), found.changes[1].change), (2, 0.3));
        assert!(single_changes(&nalgebra::dvector![1.0], &effects, &names(3)).is_err());
    }

    /// Less than no stiffness there is not: δ = -86 becomes -1, which takes away 86² - 85² of 86² + 3², and δ = 3 becomes 1, 9 - 4 of it;
    /// z and its probability stay those of the linear estimate.
    #[test]
    fn a_change_beyond_all_of_the_stiffness_is_not_followed() {
        let effects = DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, 1.0]);
        let found = single_changes(&nalgebra::dvector![86.0, -3.0], &effects, &names(2)).unwrap();
        let (best, second) = (&found.changes[0], &found.changes[1]);
        let chi_squared = 86.0_f64.powi(2) + 9.0;
        assert_eq!((best.change, best.is_limited, best.z), (-1.0, true, -86.0));
        assert!((best.share - (86.0_f64.powi(2) - 85.0_f64.powi(2)) / chi_squared).abs() < 1e-15);
        assert_eq!((second.change, second.is_limited, second.z), (1.0, true, 3.0));
        assert!((second.share - 5.0 / chi_squared).abs() < 1e-15);
    }

    /// The largest of 20 independent |z| has P = 1 - (1 - p)^20; of 20 equal columns it has P = p.
    #[test]
    fn the_family_knows_how_its_members_depend() {
        let z = 2.5;
        let p = 2.0 * Normal::standard().sf(z);
        let mut r = DVector::zeros(20);
        r[3] = z;
        let apart = single_changes(&r, &DMatrix::identity(20, 20), &names(20)).unwrap().p_family;
        let exact = 1.0 - (1.0 - p).powi(20);
        assert!((apart / exact - 1.0).abs() < 0.3, "{apart} {exact}"); // three standard errors of a tenth
        let same = DMatrix::from_fn(20, 20, |i, _| if i == 3 { 1.0 } else { 0.0 });
        let together = single_changes(&r, &same, &names(20)).unwrap().p_family;
        assert!((together / p - 1.0).abs() < 1e-12, "{together} {p}");
    }
}
