//! Where model and test disagree: energy of the expansion's residual by element, against what noise alone would give.
//!
//! An element of wrong stiffness leaves a residual force on its own dofs; the displacement r that this force causes
//! strains mainly that element. So the strain energy of r, element by element, points at the place. It points at
//! *stiffness or mass errors in the model at hand*: parameters that would absorb the error in a fit are not projected out,
//! and a wrong base model shows up everywhere.

use super::chi_square_sum::ChiSquareSum;
use super::statistics::Gaussian;
use super::union::union_probability;
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
/// elements is as large, which knows how elements share their noise: seeded draws from the mixture of the noises that lift
/// one element (see `union`), to a standard error of a tenth of itself; below 0.001 the sum of the elements' own
/// probabilities is taken as it is.
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
    // For each mode and element the map from standard noise to √w Lᵀ r.
    let mut maps: Vec<Vec<DMatrix<f64>>> = vec![Vec::with_capacity(elements.len()); modes.len()];
    let mut energies = Vec::with_capacity(elements.len());
    let mut first = vec![0; modes.len()];
    for element in elements {
        let factor = element.factor()?;
        let (mut energy, mut strain) = (0.0, 0.0);
        let (mut directions, mut rows) = (Vec::new(), Vec::with_capacity(modes.len()));
        for (at, mode) in modes.iter().enumerate() {
            element.check(mode.expanded.residual.len())?;
            energy += mode.weight * element.quadratic(mode.expanded.residual.as_slice());
            strain += mode.weight * element.quadratic(mode.expanded.shape.as_slice());
            let map = factor.tr_mul(&mode.noise_at(&element.dofs)) * mode.weight.max(0.0).sqrt();
            // AᵀA has the eigenvalues λ of A Aᵀ, and the eigenvectors Aᵀu/√λ.
            let gram = symmetric_eigen(&(&map * map.transpose()))?;
            for (lambda, u) in gram.values.iter().zip(gram.vectors.column_iter()) {
                if *lambda > 1e-12 * gram.values.amax() && *lambda > 0.0 {
                    directions.push((at, *lambda, map.tr_mul(&u) / lambda.sqrt()));
                }
            }
            rows.push((first[at], map.nrows()));
            first[at] += map.nrows();
            maps[at].push(map);
        }
        let noise = ChiSquareSum::new(directions.iter().map(|d| d.1).collect());
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
        energies.push(Energy { noise, directions, rows });
    }
    let largest = scored.iter().map(|s| s.0).fold(f64::NEG_INFINITY, f64::max);
    let p_family = if scored.is_empty() { 1.0 } else { family(largest, energies, &maps) };
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    Ok(Localization { places: scored.into_iter().map(|(_, place)| place).collect(), p_family })
}

/// The distribution of one element's energy under noise.
struct Energy {
    noise: ChiSquareSum,
    /// (mode, eigenvalue, eigenvector) of every direction of the noise that reaches the element.
    directions: Vec<(usize, f64, DVector<f64>)>,
    /// First row of the element in the stacked maps of each mode, and its rows there.
    rows: Vec<(usize, usize)>,
}

/// All elements under each other.
struct Family {
    elements: Vec<Energy>,
    /// For each mode: maps from standard noise to √w Lᵀ r of all elements.
    maps: Vec<DMatrix<f64>>,
    /// The energy that each element must reach, and the probability that it does.
    events: Vec<(f64, f64)>,
}

/// The probability that noise gives the largest score, see [`localize`].
fn family(largest: f64, elements: Vec<Energy>, maps: &[Vec<DMatrix<f64>>]) -> f64 {
    /// Below this bound the decision is clear.
    const CLEAR: f64 = 1e-3;
    let stack = |maps: &Vec<DMatrix<f64>>| {
        let mut all = DMatrix::zeros(maps.iter().map(DMatrix::nrows).sum(), maps.first().map_or(0, DMatrix::ncols));
        let mut first = 0;
        for map in maps {
            all.rows_mut(first, map.nrows()).copy_from(map);
            first += map.nrows();
        }
        all
    };
    // An element without noise reaches nothing.
    let event = |e: &Energy| {
        let (mean, sd) = (e.noise.mean(), e.noise.variance().sqrt());
        let level = mean + sd * largest;
        if sd > 0.0 { (level, e.noise.tail(level)) } else { (f64::INFINITY, 0.0) }
    };
    let events: Vec<(f64, f64)> = elements.iter().map(event).collect();
    let bound: f64 = events.iter().map(|e| e.1).sum();
    if bound < CLEAR {
        return bound;
    }
    let family = Family { elements, maps: maps.iter().map(stack).collect(), events };
    union_probability(&family.events.iter().map(|e| e.1).collect::<Vec<_>>(), |e, gaussian| family.reached(e, gaussian))
}

impl Family {
    /// How many elements reach their energies in a draw of the noise in which element `e` does.
    fn reached(&self, e: usize, gaussian: &mut Gaussian) -> usize {
        let mut noise: Vec<DVector<f64>> =
            self.maps.iter().map(|m| DVector::from_fn(m.ncols(), |_, _| gaussian.next())).collect();
        let chosen = &self.elements[e];
        let weights: Vec<f64> = chosen.directions.iter().map(|d| d.1).collect();
        let along = above(&weights, self.events[e].0, chosen.noise.tilt(self.events[e].0), gaussian);
        for ((mode, _, v), z) in chosen.directions.iter().zip(along) {
            let now = v.dot(&noise[*mode]);
            noise[*mode].axpy(z - now, v, 1.0);
        }
        let responses: Vec<DVector<f64>> = self.maps.iter().zip(&noise).map(|(m, x)| m * x).collect();
        let count = (0..self.elements.len())
            .filter(|&k| {
                let energy: f64 = responses
                    .iter()
                    .zip(&self.elements[k].rows)
                    .map(|(r, &(first, rows))| r.rows(first, rows).norm_squared())
                    .sum();
                // Element e does by construction, but for rounding.
                k == e || energy >= self.events[k].0
            })
            .count();
        count.max(1)
    }
}

/// Standard normal z with Σ λ z² ≥ `level`, exactly: drawn with variances 1/(1 - 2 λ t) and taken with probability
/// exp(-t (Σ λ z² - level)).
fn above(weights: &[f64], level: f64, tilt: f64, gaussian: &mut Gaussian) -> Vec<f64> {
    let tilt = tilt.max(0.0);
    loop {
        let z: Vec<f64> = weights.iter().map(|w| gaussian.next() / (1.0 - 2.0 * w * tilt).sqrt()).collect();
        let energy: f64 = weights.iter().zip(&z).map(|(w, z)| w * z * z).sum();
        if energy >= level && gaussian.uniform() <= (-tilt * (energy - level)).exp() {
            return z;
        }
    }
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
