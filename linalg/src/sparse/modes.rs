//! The lowest modes of a sparse pencil, counted so that none is missing.

use super::basis::{Block, scattered};
use super::factor::{Factor, FactorError};
use super::kernel::{Row, WIDTH};
use super::lanczos::{Lanczos, Ritz};
use super::matrix::SparseSym;
use super::plan::{Ordered, SparsePlan};
use super::shifted::solve_shifted;
use crate::{DMatrix, DVector, LinalgError};

/// How to solve a sparse pencil.
#[derive(Debug, Clone, PartialEq)]
pub struct SparseOptions {
    /// Number of modes wanted besides those that are known.
    pub n_modes: usize,
    /// The shift a > 0, rad²/s²: near the first λ wanted, from ten times above to 10⁴ times below; found when absent.
    pub shift: Option<f64>,
    /// Largest |(K + aM)⁻¹ M x - θ x| / θ in the mass norm. λ + a is wrong by no more than this part, usually by its square.
    pub tolerance: f64,
    /// Whether to count the modes below the highest one found by the inertia of K - σM: one more factorisation.
    pub count: bool,
    /// Steps before the first look at what has converged, where a look costs more than a step: about what a neighbour took.
    pub first_look: usize,
}

impl Default for SparseOptions {
    fn default() -> Self {
        Self { n_modes: 10, shift: None, tolerance: 1e-10, count: true, first_look: 0 }
    }
}

/// Modes of a sparse pencil, and what they cost.
#[derive(Debug, Clone)]
pub struct SparseModes {
    /// λ = ω², ascending, rad²/s².
    pub values: DVector<f64>,
    /// Φ with Φᵀ M Φ = I, M-orthogonal to the known modes, (n x modes).
    pub vectors: DMatrix<f64>,
    /// The shift that was used.
    pub shift: f64,
    /// Largest |(K + aM)⁻¹ M x - θ x| / θ of the modes.
    pub residual: f64,
    /// How often [`SparseModes`] solved for a block of eight right-hand sides.
    pub block_solves: usize,
    /// Steps until the modes had converged first.
    pub steps: usize,
    /// How many factorisations it took, the count included.
    pub factorisations: usize,
    /// σ of the count, below which there are exactly `below` modes; `None` if nothing was counted.
    pub count: Option<(f64, usize)>,
}

/// The lowest modes of K φ = λ M φ that are not among those known, by shift-invert block Lanczos.
///
/// * `plan` - of a pattern that covers `k` and `m`; it serves every candidate of an update
/// * `k`, `m` - symmetric, positive semidefinite (n x n)
/// * `known` - M-orthonormal modes with λ = 0 that are known, as the rigid-body modes are from geometry (n x known)
/// * `start` - shapes to begin with, such as the modes of a neighbouring candidate (n x any number)
///
/// Fewer modes come out where the rank of M allows no more, and none where none is wanted: the matrices are factored all the
/// same, so that what has no answer is told. The same input gives the same bits.
///
/// # Errors
/// [`LinalgError::NotPositiveDefinite`] if K + aM is not; [`LinalgError::MissedModes`] if the count finds more modes than
/// the iteration, even after further searches; [`LinalgError::NoConvergence`] if it finds fewer, or if a value is not that of its vector; [`LinalgError::NotFinite`]; [`LinalgError::OutOfMemory`].
///
/// # Panics
/// If sizes differ, or the plan's pattern does not cover the matrices.
///
/// # Source
/// R. G. Grimes, J. G. Lewis, H. D. Simon, A shifted block Lanczos algorithm for solving sparse symmetric generalized
/// eigenproblems, SIAM J. Matrix Anal. Appl. 15(1), 1994.
pub fn lowest_sparse_modes(
    plan: &SparsePlan,
    k: &SparseSym,
    m: &SparseSym,
    known: &DMatrix<f64>,
    start: Option<&DMatrix<f64>>,
    options: &SparseOptions,
) -> Result<SparseModes, LinalgError> {
    for (matrix, a) in [("stiffness", k), ("mass", m)] {
        // Products of two entries must not overflow either.
        if let Some((row, ..)) = a.entries().find(|e| e.2.is_nan() || e.2.abs() > 1e150) {
            return Err(LinalgError::NotFinite { matrix, row });
        }
    }
    let pencil = plan.pencil(k, m);
    let search = Search { plan, pencil, options };
    let known = search.blocks(known);
    let mut found = search.run(known.0, known.1, start)?;
    // An iteration that has used up the motions with mass finds rounding beyond them, and there is no gap to count in.
    let is_sound = || -> Result<bool, LinalgError> {
        if found.count.is_some() && are_quotients(k, m, &found, &found.vectors) {
            return Ok(true);
        }
        let vectors = without_massless(plan, k, m, &found)?;
        let are_modes = || -> bool { found.count.is_some() || are_each_a_mode(k, m, &found, &vectors) };
        Ok(are_quotients(k, m, &found, &vectors) && are_modes())
    };
    if options.count && !is_sound()? {
        return Err(LinalgError::NoConvergence { size: plan.n() });
    }
    found.values.as_mut_slice().iter_mut().for_each(|v| *v = if v.is_finite() { *v } else { f64::MAX });
    Ok(found)
}

/// The vectors x as (λ + a)(K + aM)⁻¹ M x, for motions without mass have no part in the iteration; zero where λ is not finite.
fn without_massless(
    plan: &SparsePlan,
    k: &SparseSym,
    m: &SparseSym,
    found: &SparseModes,
) -> Result<DMatrix<f64>, LinalgError> {
    let mut vectors = solve_shifted(plan, k, m, found.shift, &m.mul(&found.vectors))?;
    for (mut x, value) in vectors.column_iter_mut().zip(found.values.iter()) {
        if value.is_finite() { x *= value + found.shift } else { x.fill(0.0) }
    }
    Ok(vectors)
}

/// Whether each λ is the quotient xᵀKx / xᵀMx of its vector, up to the tolerance of the iteration and the rounding of K: the iteration knows its vectors
/// by their coefficients alone, and what it takes for a mode by mistake shows here.
fn are_quotients(k: &SparseSym, m: &SparseSym, found: &SparseModes, x: &DMatrix<f64>) -> bool {
    /// Far above rounding and the tolerance of the iteration, squared, and far below what a test can measure.
    const OFF: f64 = 1e-6;
    let (kx, mx) = (k.mul(x), m.mul(x));
    (0..found.values.len()).filter(|&j| found.values[j].is_finite()).all(|j| {
        let own = x.column(j);
        let quotient = own.dot(&kx.column(j)) / own.dot(&mx.column(j));
        let off = (quotient - found.values[j]).abs() - OFF * (found.values[j] + found.shift).abs();
        off <= 0.0 || {
            let size = x.columns(j, 1).abs();
            off <= 8.0 * f64::EPSILON * size.dot(&k.abs().mul(&size))
        }
    })
}

/// Whether each of what was found satisfies K x = λ M x, as far as it has a finite λ.
fn are_each_a_mode(k: &SparseSym, m: &SparseSym, found: &SparseModes, vectors: &DMatrix<f64>) -> bool {
    /// Far above rounding and the tolerance of the iteration, far below what is none.
    const OFF: f64 = 1e-7;
    let finite: Vec<usize> = (0..found.values.len()).filter(|&j| found.values[j].is_finite()).collect();
    if finite.is_empty() {
        return true;
    }
    let values = DVector::from_iterator(finite.len(), finite.iter().map(|&j| found.values[j]));
    backward_error(k, m, &values, &vectors.select_columns(&finite)) < OFF
}

/// Blocks beside the wanted modes before the iteration restarts: as many steps as it usually takes, for a restart costs more than a few.
const ROOM: usize = 12;

struct Search<'a> {
    plan: &'a SparsePlan,
    pencil: Ordered,
    options: &'a SparseOptions,
}

impl Search<'_> {
    /// Vectors in the order of the rows, as blocks in the order of elimination, and their number.
    fn blocks(&self, vectors: &DMatrix<f64>) -> (Vec<Block>, usize) {
        let count = vectors.ncols();
        let blocks = (0..count)
            .step_by(WIDTH)
            .map(|first| {
                let row = |&i: &usize| -> Row {
                    std::array::from_fn(|l| if first + l < count { vectors[(i, first + l)] } else { 0.0 })
                };
                self.plan.order.iter().map(row).collect()
            })
            .collect();
        (blocks, count)
    }

    /// K + aM factored.
    fn factor(&self, shift: f64, values: Vec<f64>) -> Result<Factor<'_>, LinalgError> {
        let shifted = self.pencil.shifted(shift);
        if let Some(place) = (0..shifted.n()).find(|&i| shifted.diagonal(i) <= 0.0) {
            return Err(LinalgError::NotPositiveDefinite { row: self.plan.order[place], shift });
        }
        self.plan.structure.cholesky(&shifted, values).map_err(|e| match e {
            FactorError::Pivot(place) => LinalgError::NotPositiveDefinite { row: self.plan.order[place], shift },
            FactorError::Memory => LinalgError::OutOfMemory,
        })
    }

    fn run(&self, known: Vec<Block>, n_known: usize, start: Option<&DMatrix<f64>>) -> Result<SparseModes, LinalgError> {
        let n = self.plan.n();
        let mut factorisations = 0;
        let mut block_solves = 0;
        let mut shift = self.options.shift.map_or_else(|| first_shift(&self.pencil), |s| s.max(f64::MIN_POSITIVE));
        let mut values = self.plan.structure.values()?;
        let mut block = start.map(|s| self.mixed(s));
        let mut factored = None;
        if self.options.shift.is_none() {
            for _ in 0..6 {
                let factor = self.factor(shift, values)?;
                factorisations += 1;
                let mut trial = Lanczos::new(&self.pencil.mass, factor, &known, block.take(), 4, 1);
                for _ in 0..2 {
                    trial.step(0)?;
                }
                block_solves += trial.steps() + 1;
                let ritz = trial.ritz()?;
                let first = ritz.theta.iter().map(|t| 1.0 / t - shift).find(|v| *v > 1e-9 * shift && v.is_finite());
                let better = first.filter(|first| !(0.1..1e4).contains(&(first / shift)));
                block = trial.vectors(&ritz, WIDTH).pop();
                let factor = trial.into_factor();
                let Some(first) = better else {
                    factored = Some(factor);
                    values = Vec::new();
                    break;
                };
                values = factor.into_values();
                shift = first;
            }
        }
        let mut locked = known;
        let mut found: Vec<(f64, Vec<f64>)> = Vec::new();
        let mut residual = 0.0f64;
        let mut first_steps = 0;
        let mut count = None;
        for attempt in 0..4 {
            let factor = match factored.take() {
                Some(factor) => factor,
                None => {
                    factorisations += 1;
                    self.factor(shift, values)?
                }
            };
            let wanted = if attempt == 0 { self.options.n_modes } else { WIDTH };
            let most = (wanted + ROOM * WIDTH).div_ceil(WIDTH);
            let mut lanczos =
                Lanczos::new(&self.pencil.mass, factor, &locked, block.take(), most, 10 + 10 * attempt as u64);
            let (ritz, certain) = self.converge(&mut lanczos, wanted, shift)?;
            block_solves += lanczos.steps() + 1;
            if attempt == 0 {
                first_steps = lanczos.steps();
            }
            let n_found = certain.as_ref().map_or(wanted.min(ritz.theta.len()), |c| c.0);
            let usable = ritz.theta.iter().take(n_found).take_while(|t| **t > 1e-13 * ritz.theta[0]).count();
            let vectors = lanczos.vectors(&ritz, usable);
            for j in 0..usable {
                let vector = vectors[j / WIDTH].iter().map(|row| row[j % WIDTH]).collect();
                found.push((1.0 / ritz.theta[j] - shift, vector));
                residual = residual.max(ritz.residual[j] / ritz.theta[j]);
            }
            values = lanczos.into_factor().into_values();
            found.sort_by(|a, b| a.0.total_cmp(&b.0));
            let Some((_, sigma)) = certain.filter(|_| self.options.count) else { break };
            // Only what lies below the first σ has been searched.
            let sigma = count.map_or(sigma, |(s, _)| s);
            let expected = n_known + found.iter().filter(|f| f.0 < sigma).count();
            let factor = self.plan.structure.indefinite(&self.pencil.shifted(-sigma), values)?;
            let below = factor.negative().ok_or(LinalgError::NoConvergence { size: n })?;
            values = factor.into_values();
            factorisations += 1;
            count = Some((sigma, below));
            if below < expected {
                return Err(LinalgError::NoConvergence { size: n });
            }
            if below == expected {
                break;
            }
            if attempt == 3 {
                return Err(LinalgError::MissedModes { found: expected, counted: below, below: sigma });
            }
            locked.extend(vectors);
        }
        found.truncate(self.options.n_modes);
        let mut vectors = DMatrix::zeros(n, found.len());
        for (j, (_, vector)) in found.iter().enumerate() {
            let mut column = vectors.column_mut(j);
            for (place, value) in vector.iter().enumerate() {
                column[self.plan.order[place]] = *value;
            }
        }
        let values = DVector::from_iterator(found.len(), found.iter().map(|f| f.0));
        Ok(SparseModes { values, vectors, shift, residual, block_solves, steps: first_steps, factorisations, count })
    }

    /// One block whose vectors are mixtures of the given ones, so that the first steps find all of them again.
    fn mixed(&self, vectors: &DMatrix<f64>) -> Block {
        let (blocks, _) = self.blocks(vectors);
        let mut sum = vec![[0.0; WIDTH]; self.plan.n()];
        for (b, block) in blocks.iter().enumerate() {
            let weights: [Row; WIDTH] =
                std::array::from_fn(|k| std::array::from_fn(|l| scattered(((b * WIDTH + k) * WIDTH + l) as u64)));
            super::kernel::subtract(&mut sum, &[block], &[weights]);
        }
        sum
    }

    /// Iterates until the wanted modes have converged and, if they are to be counted, until there is a gap above them to
    /// count in: the number of modes below the gap, and its middle.
    fn converge(
        &self,
        lanczos: &mut Lanczos<'_, '_>,
        wanted: usize,
        shift: f64,
    ) -> Result<(Ritz, Option<(usize, f64)>), LinalgError> {
        const MOST_STEPS: usize = 400;
        /// Decades by which a step brings the residuals down, about; where a look at them costs more than a step, it waits.
        const DECADES: f64 = 2.0;
        let mut wait = 0_usize;
        loop {
            lanczos.step(wanted + WIDTH)?;
            let size = lanczos.dimension();
            let is_complete = lanczos.is_complete() || size >= self.plan.n() + WIDTH;
            let look_is_dear = self.plan.factor_len() < size.pow(3);
            let is_early = look_is_dear && lanczos.steps() < self.options.first_look;
            if (size < wanted + WIDTH || wait > 0 || is_early) && !is_complete {
                wait = wait.saturating_sub(1);
                continue;
            }
            let ritz = lanczos.ritz()?;
            if is_complete {
                return Ok((ritz, None));
            }
            let worst = (0..wanted).map(|j| ritz.residual[j] / ritz.theta[j]).fold(0.0, f64::max);
            let steps = ((worst / self.options.tolerance).log10() / DECADES).ceil() as usize;
            wait = if look_is_dear { steps.saturating_sub(1) } else { 0 };
            let is_good = |j: usize, tolerance: f64| ritz.residual[j] <= tolerance * ritz.theta[j];
            if (0..wanted).all(|j| is_good(j, self.options.tolerance)) {
                if !self.options.count {
                    return Ok((ritz, None));
                }
                if let Some(gap) = gap(&ritz, wanted, shift, self.options.tolerance.max(1e-8)) {
                    return Ok((ritz, Some(gap)));
                }
            }
            if lanczos.steps() > MOST_STEPS {
                return Err(LinalgError::NoConvergence { size: self.plan.n() });
            }
        }
    }
}

/// The first gap above the wanted modes: how many modes lie below it, and its middle.
fn gap(ritz: &Ritz, wanted: usize, shift: f64, tolerance: f64) -> Option<(usize, f64)> {
    // Where none is wanted the count still needs one below its gap.
    for j in wanted.max(1)..ritz.theta.len().saturating_sub(1) {
        let (low, high) = (ritz.theta[j - 1] - ritz.residual[j - 1], ritz.theta[j] + ritz.residual[j]);
        // In λ + a = 1/θ: a part of 10⁻³ is far above rounding of the count, and most spectra have it soon.
        if low > 0.0 && high < low * (1.0 - 1e-3) {
            let below = 1.0 / low - shift;
            let above = 1.0 / high - shift;
            return Some((j, 0.5 * (below + above)));
        }
        if ritz.residual[j] > tolerance * ritz.theta[j] {
            return None;
        }
    }
    None
}

/// A guess of the first λ from the mesh: the least ratio of stiffness to mass of a dof belongs to a wave as short as
/// the mesh; that of a bent structure as long as `d` elements is lower by about d⁴.
fn first_shift(pencil: &Ordered) -> f64 {
    let n = pencil.mass.n();
    let ratios = (0..n).map(|i| (pencil.stiffness.diagonal(i), pencil.mass.diagonal(i)));
    let least = ratios.filter(|(k, m)| *k > 0.0 && *m > 0.0).map(|(k, m)| k / m).fold(f64::INFINITY, f64::min);
    if !least.is_finite() {
        return 1.0;
    }
    let length = longest_path(&pencil.stiffness) as f64;
    10.0 * least / length.powi(4)
}

/// About the greatest distance between two rows of a matrix, in steps from row to coupled row.
fn longest_path(a: &SparseSym) -> usize {
    let n = a.n();
    let mut neighbours = vec![Vec::new(); n];
    for (i, j, value) in a.entries() {
        if i != j && value != 0.0 {
            neighbours[i].push(j);
            neighbours[j].push(i);
        }
    }
    let mut farthest = 0;
    let mut longest = 0;
    for _ in 0..2 {
        let mut distance = vec![usize::MAX; n];
        let mut queue = std::collections::VecDeque::from([farthest]);
        distance[farthest] = 0;
        while let Some(i) = queue.pop_front() {
            farthest = i;
            longest = longest.max(distance[i]);
            for &j in &neighbours[i] {
                if distance[j] == usize::MAX {
                    distance[j] = distance[i] + 1;
                    queue.push_back(j);
                }
            }
        }
    }
    longest.max(1)
}

/// Largest |Kx - λMx| of M-normalised modes over |K||x|, entry by entry in the maximum norm.
pub fn backward_error(k: &SparseSym, m: &SparseSym, values: &DVector<f64>, vectors: &DMatrix<f64>) -> f64 {
    let (kx, mx) = (k.mul(vectors), m.mul(vectors));
    let size = k.abs().mul(&vectors.abs());
    (0..values.len())
        .map(|j| {
            let residual = (kx.column(j) - mx.column(j) * values[j]).amax();
            residual / size.column(j).amax().max(f64::MIN_POSITIVE)
        })
        .fold(0.0, f64::max)
}
