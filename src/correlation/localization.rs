//! Where model and test disagree: energy of the expansion's residual by element, against what noise alone would give.
//!
//! An element of wrong stiffness leaves a residual force on its own dofs; the displacement r that this force causes
//! strains mainly that element. So the strain energy of r, element by element, points at the place. It points at
//! *stiffness or mass errors in the model at hand*: parameters that would absorb the error in a fit are not projected out,
//! and a wrong base model shows up everywhere.

use super::{CorrelationError, ExpandedShape, ShapeScalar};
use crate::linalg::{DMatrix, DVector};
use indexmap::IndexMap;
use statrs::distribution::{ContinuousCDF, Gamma};

/// An element's share of a global matrix.
#[derive(Debug, Clone, PartialEq)]
pub struct ElementMatrix {
    /// Name of the element.
    pub name: String,
    /// Group it belongs to, for sums.
    pub group: Option<String>,
    /// Its global dofs, (n_e).
    pub dofs: Vec<usize>,
    /// Its stiffness or mass in these dofs, symmetric, (n_e x n_e).
    pub matrix: DMatrix<f64>,
}

impl ElementMatrix {
    /// uᴴ A_e u of this element.
    fn quadratic<T: ShapeScalar>(&self, u: &[T]) -> f64 {
        let local = DMatrix::from_fn(self.dofs.len(), 1, |i, _| u[self.dofs[i]]);
        local.dotc(&(self.matrix.map(T::from_real) * &local)).real()
    }

    fn check(&self, n_dof: usize) -> Result<(), CorrelationError> {
        let n = self.dofs.len();
        let is_fit = self.matrix.shape() == (n, n) && self.dofs.iter().all(|&d| d < n_dof);
        if is_fit {
            return Ok(());
        }
        let (rows, columns) = self.matrix.shape();
        let expected = format!("{n} x {n} for its dofs, each below {n_dof}");
        Err(CorrelationError::Shape { what: "element matrix", rows, columns, expected })
    }
}

/// Energy of a shape in every element.
///
/// ```text
/// E_e = ½ factor φᴴ A_e φ     strain energy: A = K, factor 1;  kinetic energy: A = M, factor ω²
/// ```
///
/// * `shape` - at all dofs, (n)
/// * `elements` - stiffness or mass contributions
///
/// J in the scale of the shape. For a mode of the model the strain and the kinetic sums are equal. Sums by group:
/// [`by_group`]. A large share says that the frequency depends on that element: df/f = ½ share dE/E.
pub fn element_energies<T: ShapeScalar>(
    shape: &DVector<T>,
    elements: &[ElementMatrix],
    factor: f64,
) -> Result<Vec<f64>, CorrelationError> {
    let energy = |e: &ElementMatrix| e.check(shape.len()).map(|()| 0.5 * factor * e.quadratic(shape.as_slice()));
    elements.iter().map(energy).collect()
}

/// Values added up by group, in the order in which groups appear; elements without a group stand under their own name.
pub fn by_group(elements: &[ElementMatrix], values: &[f64]) -> IndexMap<String, f64> {
    let mut sums = IndexMap::new();
    for (element, value) in elements.iter().zip(values) {
        *sums.entry(element.group.clone().unwrap_or_else(|| element.name.clone())).or_insert(0.0) += value;
    }
    sums
}

/// One matrix a group: the contributions of its elements, added up; elements without a group stay by themselves.
///
/// For [`localize`] by group, in the order in which groups appear.
///
/// # Panics
/// If an element's matrix does not have the size of its dofs.
pub fn group_matrices(elements: &[ElementMatrix]) -> Vec<ElementMatrix> {
    let mut members: IndexMap<&str, Vec<&ElementMatrix>> = IndexMap::new();
    for element in elements {
        members.entry(element.group.as_deref().unwrap_or(&element.name)).or_default().push(element);
    }
    let add_up = |(name, members): (&str, Vec<&ElementMatrix>)| {
        let mut dofs: Vec<usize> = members.iter().flat_map(|e| e.dofs.iter().copied()).collect();
        dofs.sort_unstable();
        dofs.dedup();
        let mut matrix = DMatrix::zeros(dofs.len(), dofs.len());
        for element in members {
            let place: Vec<usize> = element.dofs.iter().map(|d| dofs.partition_point(|x| x < d)).collect();
            for (i, &row) in place.iter().enumerate() {
                for (j, &column) in place.iter().enumerate() {
                    matrix[(row, column)] += element.matrix[(i, j)];
                }
            }
        }
        ElementMatrix { name: name.to_owned(), group: None, dofs, matrix }
    };
    members.into_iter().map(add_up).collect()
}

/// Residual force of a shape at all dofs.
///
/// ```text
/// f = (K - ω² M) u     N in the scale of the shape, (n)
/// ```
///
/// Zero for a mode of the model; with measured ω and an expanded shape it stands where K or M is wrong. Raw forces are
/// dominated by stiff dofs and by noise; [`localize`] weighs them.
///
/// # Panics
/// If the sizes differ.
pub fn residual_force(k: &DMatrix<f64>, m: &DMatrix<f64>, omega_squared: f64, shape: &DVector<f64>) -> DVector<f64> {
    k * shape - (m * shape) * omega_squared
}

/// One mode of the test, expanded, with the noise of its shape.
#[derive(Debug, Clone, Copy)]
pub struct ExpandedMode<'a> {
    /// The expansion.
    pub expanded: &'a ExpandedShape,
    /// Standard deviations of the test shape, (n_sensor).
    pub sd: &'a DVector<f64>,
    /// Weight of this mode in the sums, 1/J: 1/(ω² modal mass) makes modes equal.
    pub weight: f64,
}

/// How much disagreement sits in one element.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Place {
    /// Name of the element (or group).
    pub name: String,
    /// Σ_modes weight rᵀ K_e r: energy of the model error there, relative.
    pub energy: f64,
    /// The same over the strain energy of the shapes there: about the square of the relative stiffness error.
    pub relative_energy: f64,
    /// Mean of `energy` under noise alone.
    pub noise_mean: f64,
    /// 95 % quantile of `energy` under noise alone.
    pub noise_quantile: f64,
    /// Probability that noise alone gives this energy or more, in this element.
    pub p_value: f64,
}

/// Places ranked by how far they stand above noise.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Localization {
    /// Places, the most suspicious first.
    pub places: Vec<Place>,
    /// Probability that noise alone gives any place a p-value as low as the lowest here.
    pub p_family: f64,
}

impl Localization {
    /// Whether anything stands out of the noise at a significance, for example 0.01.
    pub fn stands_out(&self, significance: f64) -> bool {
        self.p_family < significance
    }
}

/// Ranks elements by the energy of the residual displacement, against noise.
///
/// ```text
/// E_e = Σ_modes w rᵀ K_e r,     noise alone: r = R ε, ε ~ N(0, diag σ²), R = ∂r/∂y
/// mean = Σ w tr(K_e C),  variance = Σ 2 w² tr((K_e C)²),  C = R diag(σ²) Rᵀ;   gamma distribution of these moments
/// p_family = 1 - (1 - p_min)^n
/// ```
///
/// * `modes` - expanded modes of the test
/// * `elements` - stiffness contributions, by element, or by group after [`group_matrices`]
///
/// Sorted by (energy - mean)/√variance. Under noise alone the mean and variance are exact for a right model whose
/// measured frequencies are exact; the gamma shape is an approximation (good to a few per cent at 0.95, rough in the far
/// tail); p_family treats elements as independent, which errs on the side of "nothing stands out".
///
/// What it cannot tell: stiffness from mass errors, or errors where no mode strains; an error spread over the structure
/// spreads the energy.
///
/// # Source
/// Error energies: Ladevèze, Nedjar, Reynier 1994 (see [`super::Expander`]). Moments of a quadratic form: S. R. Searle,
/// Linear Models, 1971, section 2.5; gamma approximation: F. E. Satterthwaite, Biometrics Bulletin 2 (1946) 110-114.
pub fn localize(modes: &[ExpandedMode<'_>], elements: &[ElementMatrix]) -> Result<Localization, CorrelationError> {
    let mut scored = Vec::with_capacity(elements.len());
    for element in elements {
        let (mut energy, mut strain, mut mean, mut variance) = (0.0, 0.0, 0.0, 0.0);
        for mode in modes {
            element.check(mode.expanded.residual.len())?;
            energy += mode.weight * element.quadratic(mode.expanded.residual.as_slice());
            strain += mode.weight * element.quadratic(mode.expanded.shape.as_slice());
            // Columns R_i σ_i at the element's dofs; unmeasured sensors have zero columns.
            let r = &mode.expanded.residual_sensitivity;
            let noise = DMatrix::from_fn(element.dofs.len(), r.ncols(), |i, j| {
                let rate = r[(element.dofs[i], j)];
                if rate == 0.0 { 0.0 } else { rate * mode.sd[j] }
            });
            let product = &element.matrix * (&noise * noise.transpose());
            mean += mode.weight * product.trace();
            variance += 2.0 * (mode.weight * mode.weight) * product.component_mul(&product.transpose()).sum();
        }
        let (p_value, noise_quantile) = gamma_tail(energy, mean, variance);
        let relative_energy = if strain > 0.0 { energy / strain } else { 0.0 };
        let score = if variance > 0.0 { (energy - mean) / variance.sqrt() } else { 0.0 };
        let place =
            Place { name: element.name.clone(), energy, relative_energy, noise_mean: mean, noise_quantile, p_value };
        scored.push((score, place));
    }
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    let places: Vec<Place> = scored.into_iter().map(|(_, place)| place).collect();
    let smallest = places.iter().map(|p| p.p_value).fold(1.0, f64::min);
    // 1 - (1 - p)^n without cancellation.
    let p_family = if smallest < 1.0 { -(places.len() as f64 * (-smallest).ln_1p()).exp_m1() } else { 1.0 };
    Ok(Localization { places, p_family })
}

/// P(X ≥ value) and the 95 % quantile of a gamma distribution with this mean and variance.
fn gamma_tail(value: f64, mean: f64, variance: f64) -> (f64, f64) {
    let is_random = mean > 0.0 && variance > 0.0;
    let gamma = is_random.then(|| Gamma::new(mean * mean / variance, mean / variance).ok()).flatten();
    match gamma {
        Some(gamma) => (gamma.sf(value), gamma.inverse_cdf(0.95)),
        None if value > 0.0 => (0.0, 0.0),
        None => (1.0, 0.0),
    }
}

#[cfg(test)]
mod tests;
