//! What the data can say about the parameters: ranks, combinations, collinearity, information.
//!
//! Everything comes from one Jacobian J = ∂r/∂x of residuals in standard deviations with respect to parameters scaled
//! to their intervals: then singular values say how many standard deviations the data move when a parameter
//! combination crosses its interval.

use super::CorrelationError;
use crate::linalg::{DMatrix, DVector, Svd, thin_svd};
use std::fmt;

/// Singular values below this share of the largest are rounding noise: no data of this kind can ever tell.
const STRUCTURAL: f64 = 1e-11;

/// Squared share of a parameter in the null space below which it counts as untouched by it. Null vectors of a gap of
/// 1e4 carry errors of 1e-4 in amplitude, 1e-8 in the square; a share of 1e-6 is safely above.
const UNTOUCHED: f64 = 1e-6;

/// Coefficients below this share of the leading one are not printed.
const NEGLIGIBLE: f64 = 1e-3;

/// Rank and combinations of a set of parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Identifiability {
    /// Names of the parameters.
    pub names: Vec<String>,
    /// Singular values of J, descending.
    pub singular_values: DVector<f64>,
    /// Number of singular values above the threshold: that many combinations are seen.
    pub rank: usize,
    /// Number of singular values above rounding level: what perfect data of this kind could see.
    pub structural_rank: usize,
    /// Orthonormal directions that the data do not see, as columns, (n_par x (n_par - rank)).
    pub null_space: DMatrix<f64>,
    /// Sets of parameters that cannot be told apart, and the combinations through which they act.
    pub groups: Vec<CoupledGroup>,
    /// Parameters that each act by themselves.
    pub identifiable: Vec<usize>,
}

/// Parameters that act only through fewer combinations.
#[derive(Debug, Clone, PartialEq)]
pub struct CoupledGroup {
    /// Parameters of the group, ascending.
    pub parameters: Vec<usize>,
    /// The combinations that the data see, one a row, (rank x members); coefficients of the unscaled parameters.
    /// Each row leads with a 1 at a parameter that no other row contains.
    pub combinations: DMatrix<f64>,
}

/// Finds the combinations of parameters that the data see.
///
/// ```text
/// J = U Σ Vᵀ,  rank = #{σ_k > threshold σ_1},  N = null directions,  P = N Nᵀ
/// i and j are coupled when P_ij ≠ 0; a group is what such links connect
/// ```
///
/// * `jacobian` - ∂r/∂x, (n_data x n_par), unitless
/// * `names` - of the parameters, (n_par)
/// * `widths` - dθ/dx, the length of each parameter's interval, to express combinations in θ; all 1 if `None`
/// * `threshold` - relative, for example 1e-4
///
/// A group of g parameters with d null directions acts through g - d numbers; groups are the smallest sets that the null
/// space connects, so no combination crosses two of them. When the data are few the null space connects nearly all
/// parameters; [`Identifiability::structural_rank`] tells what better data of the same kind could see. Local: true at the
/// point where J was taken.
///
/// # Source
/// Groups as connected components of the matroid of columns: J. Oxley, Matroid Theory, 2011, chapter 4. Rank and null
/// space in updating: M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995.
pub fn identifiability(
    jacobian: &DMatrix<f64>,
    names: &[String],
    widths: Option<&[f64]>,
    threshold: f64,
) -> Result<Identifiability, CorrelationError> {
    let n = jacobian.ncols();
    for (what, length) in [("names", names.len()), ("interval widths", widths.map_or(n, <[f64]>::len))] {
        if length != n {
            let expected = format!("{n} of them, one a parameter");
            return Err(CorrelationError::Shape { what, rows: length, columns: 1, expected });
        }
    }
    if !(0.0..1.0).contains(&threshold) {
        let expected = "at least 0 and below 1";
        return Err(CorrelationError::Range { what: "rank threshold", value: threshold, expected });
    }
    let svd = complete_svd(jacobian)?;
    let rank = svd.rank(threshold);
    let null_space = svd.right.columns(rank, n - rank).into_owned();
    let projector = &null_space * null_space.transpose();
    let mut group_of: Vec<Option<usize>> = (0..n).map(|i| (projector[(i, i)] > UNTOUCHED).then_some(i)).collect();
    for i in 0..n {
        for j in i + 1..n {
            let (Some(a), Some(b)) = (group_of[i], group_of[j]) else { continue };
            // |P_ij| ≤ √(P_ii P_jj): compared with that bound the link does not depend on the scale of the parameters.
            let bound = (projector[(i, i)] * projector[(j, j)]).sqrt();
            if a != b && projector[(i, j)].abs() > UNTOUCHED.sqrt() * bound {
                group_of.iter_mut().filter(|g| **g == Some(b)).for_each(|g| *g = Some(a));
            }
        }
    }
    let mut groups = Vec::new();
    for label in 0..n {
        let parameters: Vec<usize> = (0..n).filter(|&i| group_of[i] == Some(label)).collect();
        if parameters.is_empty() {
            continue;
        }
        let local = thin_svd(&null_space.select_rows(&parameters))?;
        // Directions of the null space that live in this group have singular value 1, others 0.
        let n_null = local.values.iter().filter(|s| **s > 0.5).count();
        let basis = complete_svd(&null_space.select_rows(&parameters).transpose())?;
        let seen = basis.right.columns(n_null, parameters.len() - n_null).transpose();
        let mut combinations = reduced_rows(seen);
        if let Some(widths) = widths {
            in_physical_units(&mut combinations, &parameters, widths);
        }
        groups.push(CoupledGroup { parameters, combinations });
    }
    Ok(Identifiability {
        names: names.to_vec(),
        rank,
        structural_rank: svd.rank(STRUCTURAL),
        null_space,
        groups,
        identifiable: (0..n).filter(|&i| group_of[i].is_none()).collect(),
        singular_values: svd.values,
    })
}

/// The decomposition with a full square V also when there are fewer rows than columns: rows of zeros change nothing.
fn complete_svd(a: &DMatrix<f64>) -> Result<Svd, CorrelationError> {
    let (rows, columns) = a.shape();
    Ok(if rows < columns { thin_svd(&a.clone().resize_vertically(columns, 0.0))? } else { thin_svd(a)? })
}

/// Row-reduced echelon form with complete pivoting: an equivalent set of rows, each with a leading 1 of its own.
fn reduced_rows(mut a: DMatrix<f64>) -> DMatrix<f64> {
    let (rows, columns) = a.shape();
    let mut pivots = Vec::new();
    for r in 0..rows {
        let mut best = (r, 0);
        for i in r..rows {
            for j in (0..columns).filter(|j| !pivots.contains(j)) {
                if pivots.contains(&best.1) || a[(i, j)].abs() > a[best].abs() * (1.0 + 1e-9) {
                    best = (i, j);
                }
            }
        }
        let pivot = a[best];
        if pivot == 0.0 {
            return a.rows(0, r).into_owned();
        }
        a.swap_rows(r, best.0);
        a.row_mut(r).unscale_mut(pivot);
        let lead = a.row(r).into_owned();
        for i in (0..rows).filter(|&i| i != r) {
            let factor = a[(i, best.1)];
            let reduced = a.row(i) - &lead * factor;
            a.set_row(i, &reduced);
        }
        pivots.push(best.1);
    }
    // Rows in the order of their leading parameter.
    let mut order: Vec<usize> = (0..rows).collect();
    order.sort_by_key(|&r| pivots[r]);
    a.select_rows(&order)
}

/// Coefficients of x become coefficients of θ = lower + width x, each row led by a 1 again; negligible ones become 0.
fn in_physical_units(combinations: &mut DMatrix<f64>, parameters: &[usize], widths: &[f64]) {
    let n_rows = combinations.nrows();
    for r in 0..n_rows {
        let largest = combinations.row(r).abs().max();
        let is_lead = |combinations: &DMatrix<f64>, k: usize| {
            combinations[(r, k)] == 1.0 && (0..n_rows).all(|q| q == r || combinations[(q, k)] == 0.0)
        };
        let lead = (0..parameters.len()).find(|&k| is_lead(combinations, k)).unwrap_or(0);
        for k in 0..parameters.len() {
            let is_negligible = combinations[(r, k)].abs() < NEGLIGIBLE * largest;
            let ratio = widths[parameters[lead]] / widths[parameters[k]];
            combinations[(r, k)] = if is_negligible { 0.0 } else { combinations[(r, k)] * ratio };
        }
    }
}

impl Identifiability {
    /// The combinations of a group in words: "Ix1 + 2 Ix4_9".
    pub fn combinations_in_words(&self, group: &CoupledGroup) -> Vec<String> {
        let in_words = |row: nalgebra::RowDVector<f64>| {
            let mut text = String::new();
            let largest = row.abs().max();
            for (coefficient, &parameter) in row.iter().zip(&group.parameters) {
                // Unscaled coefficients carry units, so nothing but an exact zero is left out of them here.
                if *coefficient == 0.0 || coefficient.abs() < 1e-9 * largest {
                    continue;
                }
                let sign = match (text.is_empty(), *coefficient < 0.0) {
                    (true, false) => "",
                    (true, true) => "-",
                    (false, false) => " + ",
                    (false, true) => " - ",
                };
                text += sign;
                let magnitude = coefficient.abs();
                if (magnitude - 1.0).abs() > 5e-4 {
                    text += &three_figures(magnitude);
                    text.push(' ');
                }
                text += &self.names[parameter];
            }
            text
        };
        group.combinations.row_iter().map(|row| in_words(row.into_owned())).collect()
    }
}

/// A positive number with three figures.
fn three_figures(value: f64) -> String {
    let exponent = value.log10().floor();
    if (-3.0..4.0).contains(&exponent) {
        let text = format!("{value:.*}", (2.0 - exponent).max(0.0) as usize);
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else {
        format!("{value:.2e}")
    }
}

impl fmt::Display for Identifiability {
    /// A sentence for the rank, and one for each group.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the data determine {} of {} combinations of parameters", self.rank, self.names.len())?;
        for group in &self.groups {
            let names: Vec<&str> = group.parameters.iter().map(|&i| self.names[i].as_str()).collect();
            let count = group.combinations.nrows();
            if count == 0 {
                write!(f, "\n{} {} no effect", names.join(", "), if names.len() == 1 { "has" } else { "have each" })?;
            } else {
                let through = if count == 1 { "one number".to_owned() } else { format!("{count} numbers") };
                write!(f, "\nthese {} parameters act only through {through}: ", names.len())?;
                write!(f, "{}\n  {}", names.join(", "), self.combinations_in_words(group).join("\n  "))?;
            }
        }
        Ok(())
    }
}

/// Two or more parameters whose effects on the data are nearly parallel.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct CollinearGroup {
    /// The parameters, ascending.
    pub parameters: Vec<usize>,
    /// Smallest |cosine| among the links that hold the group together.
    pub cosine: f64,
}

/// Groups of parameters with nearly parallel columns.
///
/// ```text
/// cos_ij = |J_iᵀ J_j| / (‖J_i‖ ‖J_j‖) ≥ threshold links i and j
/// ```
///
/// * `threshold` - for example 0.95
///
/// Sees pairs only: three parameters may depend on each other with no two of them parallel; [`identifiability`] sees that.
///
/// # Source
/// D. A. Belsley, E. Kuh, R. E. Welsch, Regression Diagnostics, 1980.
pub fn collinear_groups(jacobian: &DMatrix<f64>, threshold: f64) -> Vec<CollinearGroup> {
    let n = jacobian.ncols();
    let cosine = |i: usize, j: usize| {
        let (a, b) = (jacobian.column(i), jacobian.column(j));
        let norms = a.norm() * b.norm();
        if norms > 0.0 { a.dot(&b).abs() / norms } else { 0.0 }
    };
    let mut group_of: Vec<usize> = (0..n).collect();
    let mut links = Vec::new();
    for i in 0..n {
        for j in i + 1..n {
            let value = cosine(i, j);
            if value >= threshold && value > 0.0 {
                links.push((i, value));
                let (a, b) = (group_of[i], group_of[j]);
                group_of.iter_mut().filter(|g| **g == b).for_each(|g| *g = a);
            }
        }
    }
    let members = |label: usize| (0..n).filter(|&i| group_of[i] == label).collect::<Vec<_>>();
    (0..n)
        .map(|label| (label, members(label)))
        .filter(|(_, parameters)| parameters.len() > 1)
        .map(|(label, parameters)| {
            let held = links.iter().filter(|(i, _)| group_of[*i] == label).map(|(_, value)| *value);
            CollinearGroup { parameters, cosine: held.fold(1.0, f64::min) }
        })
        .collect()
}

/// What the data say about one parameter.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Information {
    /// Standard deviation of x if all other parameters were known; infinite without any effect.
    pub sd_alone: f64,
    /// Standard deviation of x with all others free; `None` when the data do not determine it.
    pub sd: Option<f64>,
    /// (sd_alone/sd)²: the share of the parameter's information that does not drown in the others; 0 if undetermined.
    pub share: f64,
}

/// Information of the data, and of the prior if given, on each parameter.
///
/// ```text
/// sd_alone = 1/‖J_j‖,   sd² = [(JᵀJ + diag(1/prior²))⁻¹]_jj = Σ_k V_jk²/σ_k²
/// ```
///
/// * `jacobian` - ∂r/∂x, residuals in standard deviations
/// * `prior_sd` - standard deviation of each x before the data; `None` for no prior
/// * `threshold` - relative singular value that counts as seen; a prior usually needs 0
///
/// Linear: true for small changes. Standard deviations above about 0.3 of an interval say that bounds or prior rule.
///
/// # Source
/// G. A. F. Seber, C. J. Wild, Nonlinear Regression, 1989, section 2.1.
pub fn information(
    jacobian: &DMatrix<f64>,
    prior_sd: Option<&[f64]>,
    threshold: f64,
) -> Result<Vec<Information>, CorrelationError> {
    let stacked = with_prior(jacobian, prior_sd)?;
    let svd = complete_svd(&stacked)?;
    let rank = svd.rank(threshold.max(STRUCTURAL));
    let n = jacobian.ncols();
    Ok((0..n)
        .map(|j| {
            let sd_alone = 1.0 / stacked.column(j).norm();
            let unseen: f64 = (rank..n).map(|k| svd.right[(j, k)].powi(2)).sum();
            let variance: f64 = (0..rank).map(|k| (svd.right[(j, k)] / svd.values[k]).powi(2)).sum();
            let sd = (unseen <= UNTOUCHED).then(|| variance.sqrt());
            Information { sd_alone, sd, share: sd.map_or(0.0, |sd| (sd_alone / sd).powi(2).min(1.0)) }
        })
        .collect())
}

/// Covariance of the parameters that data and prior leave, (n_par x n_par).
///
/// ```text
/// (JᵀJ + diag(1/prior²))⁻¹     in the directions that are seen, zero in the others
/// ```
///
/// Arguments as [`information`]. Where [`Information::sd`] is `None` the entries are lower bounds and mean nothing else.
pub fn covariance(
    jacobian: &DMatrix<f64>,
    prior_sd: Option<&[f64]>,
    threshold: f64,
) -> Result<DMatrix<f64>, CorrelationError> {
    let svd = complete_svd(&with_prior(jacobian, prior_sd)?)?;
    let rank = svd.rank(threshold.max(STRUCTURAL));
    let mut scaled = svd.right.columns(0, rank).into_owned();
    for k in 0..rank {
        scaled.column_mut(k).unscale_mut(svd.values[k]);
    }
    Ok(&scaled * scaled.transpose())
}

/// Correlations of a covariance matrix; zero where a variance is zero, one on the diagonal.
pub fn correlations(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    let sd: Vec<f64> = covariance.diagonal().iter().map(|v| v.max(0.0).sqrt()).collect();
    DMatrix::from_fn(covariance.nrows(), covariance.ncols(), |i, j| {
        let scale = sd[i] * sd[j];
        match (i == j, scale > 0.0) {
            (true, _) => 1.0,
            (false, true) => (covariance[(i, j)] / scale).clamp(-1.0, 1.0),
            (false, false) => 0.0,
        }
    })
}

/// J over diag(1/prior_sd).
fn with_prior(jacobian: &DMatrix<f64>, prior_sd: Option<&[f64]>) -> Result<DMatrix<f64>, CorrelationError> {
    let Some(prior) = prior_sd else { return Ok(jacobian.clone()) };
    let (rows, n) = jacobian.shape();
    if prior.len() != n {
        let expected = format!("{n} of them, one a parameter");
        return Err(CorrelationError::Shape {
            what: "prior standard deviations",
            rows: prior.len(),
            columns: 1,
            expected,
        });
    }
    if let Some(&value) = prior.iter().find(|v| v.is_nan() || **v <= 0.0) {
        let what = "prior standard deviation";
        return Err(CorrelationError::Range { what, value, expected: "positive" });
    }
    let mut stacked = jacobian.clone().resize_vertically(rows + n, 0.0);
    for (j, sd) in prior.iter().enumerate() {
        stacked[(rows + j, j)] = 1.0 / sd;
    }
    Ok(stacked)
}

#[cfg(test)]
mod tests;
