//! Where model and test disagree: energy of the expansion's residual by element, against what noise alone would give.
//!
//! An element of wrong stiffness leaves a residual force on its own dofs; the displacement r that this force causes
//! strains mainly that element. So the strain energy of r, element by element, points at the place. It points at
//! *stiffness or mass errors in the model at hand*: parameters that would absorb the error in a fit are not projected out,
//! and a wrong base model shows up everywhere.

use super::chi_square_sum::ChiSquareSum;
use super::statistics::Gaussian;
use super::{CorrelationError, ExpandedShape, ShapeScalar};
use crate::linalg::{DMatrix, DVector, LinalgError, symmetric_eigen};
use indexmap::IndexMap;

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

    /// L with L Lᵀ = A, (n_e x rank).
    fn factor(&self) -> Result<DMatrix<f64>, LinalgError> {
        let eigen = symmetric_eigen(&self.matrix)?;
        // Eigenvalues at rounding level belong to rigid motions.
        let floor = 1e-12 * eigen.values.amax();
        let kept: Vec<usize> = (0..eigen.values.len()).filter(|&i| eigen.values[i] > floor).collect();
        let mut factor = eigen.vectors.select_columns(&kept);
        for (mut column, &i) in factor.column_iter_mut().zip(&kept) {
            column *= eigen.values[i].sqrt();
        }
        Ok(factor)
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

/// One mode of the test, expanded, with its noise.
#[derive(Debug, Clone, Copy)]
pub struct ExpandedMode<'a> {
    /// The expansion.
    pub expanded: &'a ExpandedShape,
    /// Standard deviations of the test shape, (n_sensor).
    pub sd: &'a DVector<f64>,
    /// Weight of this mode in the sums, 1/J: 1/(ω² modal mass) makes modes equal.
    pub weight: f64,
    /// Standard deviation of the measured ω², rad²/s²: 2 ω² times the relative one of the frequency; 0 if it is exact.
    pub omega_squared_sd: f64,
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
    /// Probability that noise alone lifts any place as far above its noise as the highest one here.
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
/// E_e = Σ_modes w rᵀ K_e r,     noise alone: r = R ε + (∂r/∂ω²) ε_ω,   ε ~ N(0, diag σ²), R = ∂r/∂y
/// E_e ~ Σ_i λ_i χ²_1,   λ: eigenvalues of w Lᵀ C L over the modes,  K_e = L Lᵀ,  C = R diag(σ²) Rᵀ + σ_ω² ∂r ∂rᵀ
/// mean = Σ λ,  variance = 2 Σ λ²,   score = (E - mean)/√variance
/// ```
///
/// * `modes` - expanded modes of the test
/// * `elements` - stiffness contributions, by element, or by group after [`group_matrices`]
///
/// Sorted by the score. The p-value of an element is that of the weighted sum of chi-squares by saddlepoint, good to a
/// few per cent of itself, far out at worst 17 % too large. `p_family` is the probability that the largest score of all
/// elements is as large, by seeded draws of the noise through the same maps, so that it knows how elements share their
/// noise: 1000, or fewer once 20 of them reach it. A bound n p (Bonferroni) below 0.001 is taken as it is, and so is a
/// smaller bound where fewer than ten draws reach it.
/// All is exact to first order in the noise for a right model.
///
/// What it cannot tell: stiffness from mass errors, or errors where no mode strains; an error spread over the structure
/// spreads the energy.
///
/// # Source
/// Error energies: Ladevèze, Nedjar, Reynier 1994 (see [`super::Expander`]). Saddlepoint tail: D. Kuonen, Saddlepoint
/// approximations for distributions of quadratic forms in normal variables, Biometrika 86 (1999) 929-935.
pub fn localize(modes: &[ExpandedMode<'_>], elements: &[ElementMatrix]) -> Result<Localization, CorrelationError> {
    let mut scored = Vec::with_capacity(elements.len());
    // For each element and mode the map from standard noise to √w Lᵀ r.
    let mut maps: Vec<Vec<DMatrix<f64>>> = Vec::with_capacity(elements.len());
    let mut scales = Vec::with_capacity(elements.len());
    for element in elements {
        let factor = element.factor()?;
        let (mut energy, mut strain) = (0.0, 0.0);
        let mut weights = Vec::new();
        let mut element_maps = Vec::with_capacity(modes.len());
        for mode in modes {
            element.check(mode.expanded.residual.len())?;
            energy += mode.weight * element.quadratic(mode.expanded.residual.as_slice());
            strain += mode.weight * element.quadratic(mode.expanded.shape.as_slice());
            let map = factor.tr_mul(&mode.noise_at(&element.dofs)) * mode.weight.max(0.0).sqrt();
            let gram = if map.nrows() <= map.ncols() { &map * map.transpose() } else { map.tr_mul(&map) };
            weights.extend(symmetric_eigen(&gram)?.values.iter().copied());
            element_maps.push(map);
        }
        let noise = ChiSquareSum::new(weights);
        let (mean, deviation) = (noise.mean(), noise.variance().sqrt());
        let relative_energy = if strain > 0.0 { energy / strain } else { 0.0 };
        let score = if deviation > 0.0 { (energy - mean) / deviation } else { 0.0 };
        let place = Place {
            name: element.name.clone(),
            energy,
            relative_energy,
            noise_mean: mean,
            noise_quantile: noise.quantile(0.95),
            p_value: noise.tail(energy),
        };
        scored.push((score, place));
        maps.push(element_maps);
        scales.push((mean, deviation));
    }
    let largest = scored.iter().map(|s| s.0).fold(f64::NEG_INFINITY, f64::max);
    let smallest = scored.iter().map(|s| s.1.p_value).fold(1.0, f64::min);
    let p_family = family(largest, smallest, &maps, &scales);
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    Ok(Localization { places: scored.into_iter().map(|(_, place)| place).collect(), p_family })
}

/// The probability that noise gives the largest score, see [`localize`].
fn family(largest: f64, smallest: f64, maps: &[Vec<DMatrix<f64>>], scales: &[(f64, f64)]) -> f64 {
    /// Draws in batches; 1000 leave a standard error of 0.003 at 0.01, where decisions are made.
    const BATCH: usize = 100;
    const BATCHES: usize = 10;
    /// This many draws above the largest score say plainly that it is noise.
    const PLAIN: usize = 20;
    /// Below this bound the decision is clear, and draws could not resolve it.
    const CLEAR: f64 = 1e-3;
    let bound = (maps.len() as f64 * smallest).min(1.0);
    if bound < CLEAR || maps.is_empty() {
        return bound;
    }
    // All elements under each other, mode by mode.
    let stacked: Vec<DMatrix<f64>> = (0..maps[0].len())
        .map(|mode| {
            let rows = maps.iter().map(|m| m[mode].nrows()).sum();
            let mut all = DMatrix::zeros(rows, maps[0][mode].ncols());
            let mut first = 0;
            for element in maps {
                all.rows_mut(first, element[mode].nrows()).copy_from(&element[mode]);
                first += element[mode].nrows();
            }
            all
        })
        .collect();
    let mut gaussian = Gaussian::new(0);
    let (mut count, mut draws) = (0, 0);
    while draws < BATCH * BATCHES && count < PLAIN {
        let mut energies = DMatrix::<f64>::zeros(maps.len(), BATCH);
        for (mode, all) in stacked.iter().enumerate() {
            let noise = DMatrix::from_fn(all.ncols(), BATCH, |_, _| gaussian.next());
            let response = all * noise;
            for (draw, column) in response.column_iter().enumerate() {
                let mut first = 0;
                for (e, element) in maps.iter().enumerate() {
                    let rank = element[mode].nrows();
                    energies[(e, draw)] += column.rows(first, rank).norm_squared();
                    first += rank;
                }
            }
        }
        let reaches = |draw: &usize| {
            let stands =
                |(e, &(mean, sd)): (usize, &(f64, f64))| sd > 0.0 && (energies[(e, *draw)] - mean) / sd >= largest;
            scales.iter().enumerate().any(stands)
        };
        count += (0..BATCH).filter(reaches).count();
        draws += BATCH;
    }
    let drawn = (count + 1) as f64 / (draws + 1) as f64;
    if count < 10 { drawn.min(bound) } else { drawn }
}

impl ExpandedMode<'_> {
    /// Columns of the noise of r at some dofs: one a sensor, and one for the frequency.
    fn noise_at(&self, dofs: &[usize]) -> DMatrix<f64> {
        let (r, by_frequency) = (&self.expanded.residual_sensitivity, &self.expanded.frequency_sensitivity);
        DMatrix::from_fn(dofs.len(), r.ncols() + 1, |i, j| {
            if j == r.ncols() {
                return by_frequency[dofs[i]] * self.omega_squared_sd;
            }
            // Unmeasured sensors have zero columns, and may have no standard deviation.
            let rate = r[(dofs[i], j)];
            if rate == 0.0 { 0.0 } else { rate * self.sd[j] }
        })
    }
}

#[cfg(test)]
mod tests;
