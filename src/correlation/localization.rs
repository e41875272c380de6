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
use crate::linalg::{DMatrix, DVector, LinalgError, symmetric_eigen, symmetric_values};
use indexmap::IndexMap;
use std::ops::Range;

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
    /// Its group, or itself where it is in none.
    pub fn group_name(&self) -> &str {
        self.group.as_deref().unwrap_or(&self.name)
    }

    /// uᴴ A_e u of this element.
    fn quadratic<T: ShapeScalar>(&self, u: &[T]) -> f64 {
        let force = |row: usize| {
            self.dofs.iter().enumerate().fold(T::zero(), |sum, (j, &d)| sum + u[d].scale(self.matrix[(row, j)]))
        };
        self.dofs.iter().enumerate().map(|(i, &d)| (u[d].conjugate() * force(i)).real()).sum()
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
        *sums.entry(element.group_name().to_owned()).or_insert(0.0) += value;
    }
    sums
}

/// Numbers of the elements of every group, in the order in which groups appear.
fn members(elements: &[ElementMatrix]) -> IndexMap<&str, Vec<usize>> {
    let mut members: IndexMap<&str, Vec<usize>> = IndexMap::new();
    for (e, element) in elements.iter().enumerate() {
        members.entry(element.group_name()).or_default().push(e);
    }
    members
}

/// One matrix a group: the contributions of its elements, added up; elements without a group stay by themselves.
///
/// For [`localize`] by group, in the order in which groups appear.
///
/// # Panics
/// If an element's matrix does not have the size of its dofs.
pub fn group_matrices(elements: &[ElementMatrix]) -> Vec<ElementMatrix> {
    let add_up = |(name, members): (&str, Vec<usize>)| {
        let mut dofs: Vec<usize> = members.iter().flat_map(|&e| elements[e].dofs.iter().copied()).collect();
        dofs.sort_unstable();
        dofs.dedup();
        let mut matrix = DMatrix::zeros(dofs.len(), dofs.len());
        for element in members.into_iter().map(|e| &elements[e]) {
            let place: Vec<usize> = element.dofs.iter().map(|d| dofs.partition_point(|x| x < d)).collect();
            for (i, &row) in place.iter().enumerate() {
                for (j, &column) in place.iter().enumerate() {
                    matrix[(row, column)] += element.matrix[(i, j)];
                }
            }
        }
        ElementMatrix { name: name.to_owned(), group: None, dofs, matrix }
    };
    members(elements).into_iter().map(add_up).collect()
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
/// * `elements` - stiffness contributions
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
    let noise = Noise::new(modes, elements)?;
    noise.rank((0..elements.len()).map(|e| (elements[e].name.clone(), vec![e])).collect())
}

/// [`localize`] by element, and by group: the energy of a group is that of its elements together.
///
/// Groups come from the elements as in [`by_group`]. What both need of the noise is found once.
pub fn localize_with_groups(
    modes: &[ExpandedMode<'_>],
    elements: &[ElementMatrix],
) -> Result<(Localization, Localization), CorrelationError> {
    let noise = Noise::new(modes, elements)?;
    let by_element = noise.rank((0..elements.len()).map(|e| (elements[e].name.clone(), vec![e])).collect())?;
    Ok((by_element, noise.rank(members(elements).into_iter().map(|(name, of)| (name.to_owned(), of)).collect())?))
}

/// What the residual is in every element, and what noise does to it.
struct Noise {
    /// Σ_modes w rᵀ K_e r of every element.
    energies: Vec<f64>,
    /// The same of the shapes.
    strains: Vec<f64>,
    /// For each mode the maps from standard noise to √w Lᵀ r of all elements, one column a row of Lᵀ: their transpose.
    maps: Vec<DMatrix<f64>>,
    /// The columns of each element in `maps`, the same for all modes.
    columns: Vec<Range<usize>>,
}

impl Noise {
    fn new(modes: &[ExpandedMode<'_>], elements: &[ElementMatrix]) -> Result<Self, CorrelationError> {
        let factors = elements.iter().map(ElementMatrix::factor).collect::<Result<Vec<_>, _>>()?;
        let mut columns = Vec::with_capacity(elements.len());
        let mut last = 0;
        for factor in &factors {
            columns.push(last..last + factor.ncols());
            last += factor.ncols();
        }
        let (mut energies, mut strains) = (vec![0.0; elements.len()], vec![0.0; elements.len()]);
        let mut maps = Vec::with_capacity(modes.len());
        for mode in modes {
            let noise = mode.noise();
            let root = mode.weight.max(0.0).sqrt();
            let mut map = DMatrix::zeros(noise.nrows(), last);
            for (e, element) in elements.iter().enumerate() {
                element.check(mode.expanded.residual.len())?;
                energies[e] += mode.weight * element.quadratic(mode.expanded.residual.as_slice());
                strains[e] += mode.weight * element.quadratic(mode.expanded.shape.as_slice());
                for (column, l) in columns[e].clone().zip(factors[e].column_iter()) {
                    let mut column = map.column_mut(column);
                    for (&dof, l) in element.dofs.iter().zip(l.iter()).filter(|(_, l)| **l != 0.0) {
                        column.axpy(l * root, &noise.column(dof), 1.0);
                    }
                }
            }
            maps.push(map);
        }
        Ok(Self { energies, strains, maps, columns })
    }

    /// Ranks places, each with its name and its elements.
    fn rank(&self, places: Vec<(String, Vec<usize>)>) -> Result<Localization, CorrelationError> {
        let mut ranked = Vec::with_capacity(places.len());
        let mut noises = Vec::with_capacity(places.len());
        for (name, members) in &places {
            let sum = |values: &[f64]| members.iter().map(|&e| values[e]).sum::<f64>();
            let (energy, strain) = (sum(&self.energies), sum(&self.strains));
            let mut weights = Vec::new();
            for mode in 0..self.maps.len() {
                weights.extend(kept(symmetric_values(&Gram::new(self.block(mode, members)).matrix)?.as_slice()));
            }
            let noise = ChiSquareSum::new(weights);
            let (mean, deviation) = (noise.mean(), noise.standard_deviation());
            let place = Place {
                name: name.clone(),
                energy,
                relative_energy: if strain > 0.0 { energy / strain } else { 0.0 },
                noise_mean: mean,
                noise_quantile: noise.quantile_95(),
                p_value: noise.tail(energy),
            };
            ranked.push((if deviation > 0.0 { (energy - mean) / deviation } else { 0.0 }, place));
            noises.push(noise);
        }
        let largest = ranked.iter().map(|s| s.0).fold(f64::NEG_INFINITY, f64::max);
        let members: Vec<Vec<usize>> = places.into_iter().map(|p| p.1).collect();
        let p_family = if ranked.is_empty() { 1.0 } else { self.family(largest, &noises, &members)? };
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
        Ok(Localization { places: ranked.into_iter().map(|(_, place)| place).collect(), p_family })
    }

    /// The columns of some elements in the map of a mode, side by side.
    fn block(&self, mode: usize, members: &[usize]) -> DMatrix<f64> {
        let map = &self.maps[mode];
        let mut block = DMatrix::zeros(map.nrows(), members.iter().map(|&e| self.columns[e].len()).sum());
        let mut first = 0;
        for &e in members {
            let columns = self.columns[e].clone();
            block.columns_mut(first, columns.len()).copy_from(&map.columns(columns.start, columns.len()));
            first += columns.len();
        }
        block
    }

    /// The probability that noise gives the largest score, see [`localize`].
    fn family(&self, largest: f64, noises: &[ChiSquareSum], places: &[Vec<usize>]) -> Result<f64, LinalgError> {
        /// Below this bound the decision is clear.
        const CLEAR: f64 = 1e-3;
        // The energy that each place must reach, and the probability that it does; one without noise reaches nothing.
        let event = |noise: &ChiSquareSum| {
            let (mean, sd) = (noise.mean(), noise.standard_deviation());
            let level = mean + sd * largest;
            if sd > 0.0 { (level, noise.tail(level)) } else { (f64::INFINITY, 0.0) }
        };
        let events: Vec<(f64, f64)> = noises.iter().map(event).collect();
        let bound: f64 = events.iter().map(|e| e.1).sum();
        if bound < CLEAR {
            return Ok(bound);
        }
        let mut lifts: Vec<Option<Lift>> = places.iter().map(|_| None).collect();
        let mut failed = None;
        let draw = |e: usize, gaussian: &mut Gaussian| {
            let mut noise: Vec<DVector<f64>> =
                self.maps.iter().map(|m| DVector::from_fn(m.nrows(), |_, _| gaussian.next())).collect();
            if lifts[e].is_none() {
                match self.lift(&places[e], events[e].0, &noises[e]) {
                    Ok(lift) => lifts[e] = Some(lift),
                    Err(error) => failed = Some(error),
                }
            }
            if let Some(lift) = &lifts[e] {
                for ((mode, v), z) in lift.directions.iter().zip(above(&lift.weights, lift.level, lift.tilt, gaussian))
                {
                    let now = v.dot(&noise[*mode]);
                    noise[*mode].axpy(z - now, v, 1.0);
                }
            }
            noise
        };
        let p = union_probability(&events.iter().map(|e| e.1).collect::<Vec<_>>(), largest, draw, |batch| {
            let energies = self.energies_of(batch);
            let reached = |k: usize, draw: usize| {
                let energy: f64 = places[k].iter().map(|&e| energies[(draw, e)]).sum();
                energy >= events[k].0
            };
            // The drawn place does by construction, but for rounding.
            let happened = |e: usize, draw: usize| (0..places.len()).filter(|&k| k == e || reached(k, draw)).count();
            batch.iter().enumerate().map(|(draw, (e, _))| happened(*e, draw)).collect()
        });
        failed.map_or(Ok(p), Err)
    }

    /// Energy of every element in draws of the noise, (n_draws x n_elements).
    fn energies_of(&self, draws: &[(usize, Vec<DVector<f64>>)]) -> DMatrix<f64> {
        let mut energies = DMatrix::zeros(draws.len(), self.columns.len());
        for (mode, map) in self.maps.iter().enumerate() {
            let noise = DMatrix::from_fn(draws.len(), map.nrows(), |draw, i| draws[draw].1[mode][i]);
            let responses = noise * map;
            for (mut energy, columns) in energies.column_iter_mut().zip(&self.columns) {
                for response in responses.columns(columns.start, columns.len()).column_iter() {
                    energy.zip_apply(&response, |sum, r| *sum += r * r);
                }
            }
        }
        energies
    }

    /// How to draw noise that lifts a place to a level.
    fn lift(&self, members: &[usize], level: f64, noise: &ChiSquareSum) -> Result<Lift, LinalgError> {
        let (mut weights, mut directions) = (Vec::new(), Vec::new());
        for mode in 0..self.maps.len() {
            let gram = Gram::new(self.block(mode, members));
            let eigen = symmetric_eigen(&gram.matrix)?;
            let n = kept(eigen.values.as_slice()).count();
            for (lambda, u) in eigen.values.iter().zip(eigen.vectors.column_iter()).skip(eigen.values.len() - n) {
                weights.push(*lambda);
                directions.push((mode, gram.direction(*lambda, u.into_owned())));
            }
        }
        Ok(Lift { level, tilt: noise.tilt(level), weights, directions })
    }
}

/// The eigenvalues that are not rounding beside the largest, of ascending ones.
fn kept(values: &[f64]) -> impl Iterator<Item = f64> {
    let floor = 1e-12 * values.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    values.iter().copied().filter(move |v| *v > floor && *v > 0.0)
}

/// AᵀA or AAᵀ, the smaller one: both have the same eigenvalues beside zero.
struct Gram {
    /// A, (noises x rows).
    block: DMatrix<f64>,
    matrix: DMatrix<f64>,
    is_of_noise: bool,
}

impl Gram {
    fn new(block: DMatrix<f64>) -> Self {
        let is_of_noise = block.ncols() > block.nrows();
        let matrix = if is_of_noise { &block * block.transpose() } else { block.tr_mul(&block) };
        Self { block, matrix, is_of_noise }
    }

    /// The unit direction in the space of the noise that belongs to an eigenvector of the matrix.
    fn direction(&self, lambda: f64, u: DVector<f64>) -> DVector<f64> {
        if self.is_of_noise { u } else { &self.block * u / lambda.sqrt() }
    }
}

/// How noise is drawn that gives one place an energy or more.
struct Lift {
    level: f64,
    /// See [`ChiSquareSum::tilt`].
    tilt: f64,
    /// The eigenvalue of every direction.
    weights: Vec<f64>,
    /// (mode, unit vector) of every direction of the noise that reaches the place.
    directions: Vec<(usize, DVector<f64>)>,
}

/// Standard normal z with Σ λ z² ≥ `level`, exactly: drawn with variances 1/(1 - 2 λ t) and taken with probability
/// exp(-t (Σ λ z² - level)).
///
/// Where weights and level lie so far apart that rounding lets no draw through, the last one is stretched to the level: there the energy of
/// all that reach it is the level itself, but for digits that are not there.
fn above(weights: &[f64], level: f64, tilt: f64, gaussian: &mut Gaussian) -> Vec<f64> {
    /// With the right tilt one of some ten draws is taken.
    const TRIES: usize = 10_000;
    let tilt = tilt.max(0.0);
    let mut last = (vec![0.0; weights.len()], 0.0);
    for _ in 0..TRIES {
        let z: Vec<f64> = weights.iter().map(|w| gaussian.next() / (1.0 - 2.0 * w * tilt).sqrt()).collect();
        let energy: f64 = weights.iter().zip(&z).map(|(w, z)| w * z * z).sum();
        if energy >= level && gaussian.uniform() <= (-tilt * (energy - level)).exp() {
            return z;
        }
        last = (z, energy);
    }
    let (z, energy) = last;
    let stretch = (level / energy).sqrt();
    if stretch.is_finite() { z.into_iter().map(|z| z * stretch).collect() } else { z }
}

impl ExpandedMode<'_> {
    /// The noise of r at every dof as a column: one row a sensor, and one for the frequency.
    fn noise(&self) -> DMatrix<f64> {
        let (r, by_frequency) = (&self.expanded.residual_sensitivity, &self.expanded.frequency_sensitivity);
        let (n_dofs, n_sensors) = r.shape();
        let mut noise = DMatrix::zeros(n_sensors + 1, n_dofs);
        for j in 0..n_sensors {
            for i in 0..n_dofs {
                // Unmeasured sensors have zero columns, and may have no standard deviation.
                let rate = r[(i, j)];
                if rate != 0.0 {
                    noise[(j, i)] = rate * self.sd[j];
                }
            }
        }
        for (i, rate) in by_frequency.iter().enumerate() {
            noise[(n_sensors, i)] = rate * self.omega_squared_sd;
        }
        noise
    }
}

#[cfg(test)]
mod tests;
