//! A model of few dofs in the place of a large one, for all values within the bounds of the parameters.
//!
//! ```text
//! q ≈ V y,    K_r(θ) = Vᵀ K(θ) V,    M_r and C_r alike
//! ```
//!
//! V spans rigid-body motions, modes and their derivatives at a few sampled θ. Every term of [`AffinePart`] is projected once, so
//! that a prediction costs nothing that grows with the large model. Each sample is taken where the estimated error of a
//! frequency is largest among random points of the bounds, until it is small at all of them:
//!
//! ```text
//! r = (K - λ M) V y,    δλ ≈ |r|² / α · (λ_m + a)/(λ_m - λ),    δf/f = δλ / 2λ
//! ```
//!
//! with |r|² = rᵀ X⁻¹ r, X = K + aM at the estimates, α the least eigenvalue of K_r(θ) + a M_r(θ) against X_r, and λ_m the next
//! eigenvalue of the reduced model above 1.5 λ. It is an estimate, not a bound: α and λ_m are those of the reduced model. |r|² is a
//! quadratic form of the coefficients of the terms times y, whose matrix is found once.
//!
//! # Source
//! L. Machiels, Y. Maday, I. B. Oliveira, A. T. Patera, D. V. Rovas, Output bounds for reduced-basis approximations of symmetric
//! positive definite eigenvalue problems, C. R. Acad. Sci. Paris I 331, 2000. The search for samples: K. Veroy, C. Prud'homme,
//! D. V. Rovas, A. T. Patera, A posteriori error bounds for reduced-basis approximation of parametrized noncoercive and
//! nonlinear elliptic partial differential equations, AIAA 2003-3847.

mod residual;
mod span;
#[cfg(test)]
mod tests;

use self::residual::Residual;
use self::span::Span;
use super::affine::Affine;
use super::assembly::{AffineMass, AffinePart, Basis, add_basis, symmetrise};
use super::character::ModeCharacter;
use super::dependence::{hold, interior_point};
use super::dof_map::DofMap;
use super::entry::{Entry, lower_entries};
use super::mass_properties::MassProperties;
use super::parameter::ParameterSet;
use super::system::System;
use super::{Matrices, ModalSolver, ModelError, ParametricModel, PointMotion, Targets};
use crate::linalg::sparse::{PencilFactor, SparseSym};
use crate::linalg::{DMatrix, DVector};
use crate::modal::{self, Modes, SolveOptions};
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;
use std::sync::Arc;

/// How to reduce a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReducedOptions {
    /// Elastic modes that are to be right.
    pub n_modes: usize,
    /// Largest estimated relative error of a frequency.
    pub tolerance: f64,
    /// Most dofs.
    pub most: usize,
    /// Random points of the bounds at which the error is looked at.
    pub n_candidates: usize,
    /// Seed of these points.
    pub seed: u64,
}

impl Default for ReducedOptions {
    fn default() -> Self {
        Self { n_modes: 10, tolerance: 1e-4, most: 110, n_candidates: 100, seed: 1 }
    }
}

/// What is known of a model that is to be reduced, and what beside its modes is asked of it.
#[derive(Debug, Clone, Copy, Default)]
pub struct Asked<'a> {
    /// Vectors of a model that is nearly this one, (n_dof x any number).
    pub known: Option<&'a DMatrix<f64>>,
    /// Values of parameters, by name, at which all samples are taken.
    pub held: &'a [(String, f64)],
    /// Loads to which the model shall answer, statically and at frequencies among those of its modes, (n_dof x any number).
    pub loads: Option<&'a DMatrix<f64>>,
}

/// A model of few dofs in the place of a large one.
#[derive(Debug)]
pub struct ReducedModel<'a> {
    full: &'a dyn ParametricModel,
    /// V, (n_dof x n_reduced).
    basis: DMatrix<f64>,
    affine: AffinePart,
    dofs: DofMap,
    mirror: Option<Vec<(usize, f64)>>,
    is_damped: bool,
    residual: Residual,
    n_modes: usize,
    samples: Vec<Vec<f64>>,
    accuracy: f64,
}

/// What is added to a span below this X norm, of vectors of unit norm, is within what is left of the tolerance: the error of a
/// frequency is the square of that of a shape.
fn negligible(tolerance: f64) -> f64 {
    0.1 * tolerance.sqrt()
}

impl<'a> ReducedModel<'a> {
    /// Reduces a model.
    ///
    /// Where the dofs do not suffice, [`Self::accuracy`] stays above the tolerance.
    ///
    /// # Errors
    /// [`ModelError::NotPolynomial`]; those of a solution of the model.
    pub fn new(full: &'a dyn ParametricModel, options: ReducedOptions) -> Result<Self, ModelError> {
        Self::near(full, options, &Asked::default())
    }

    /// Reduces a model with what is known about it; samples are taken where that does not suffice.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn near(
        full: &'a dyn ParametricModel,
        options: ReducedOptions,
        &Asked { known, held, loads }: &Asked<'_>,
    ) -> Result<Self, ModelError> {
        let terms = full.affine().ok_or(ModelError::NotPolynomial)?;
        let start = interior_point(full.parameters());
        let solver = ModalSolver::new(full, &start, options.n_modes)?;
        let (_, modes) = solver.solve(full, &start, options.n_modes)?;
        let shift = modes.lambda.iter().copied().find(|l| *l > 0.0).unwrap_or(1.0);
        let mut span = Span::new(full, &start, shift)?;
        span.add_rigid(&modes.shapes.columns(0, modes.n_rigid).into_owned());
        let n_rigid = span.len();
        let mut reduced = Self {
            full,
            basis: DMatrix::zeros(0, 0),
            affine: AffinePart::default(),
            dofs: full.dof_map().clone(),
            mirror: None,
            is_damped: terms.bases().any(|b| !b.damping.is_empty()),
            residual: Residual::new(full, terms, &start, shift, n_rigid)?,
            n_modes: options.n_modes,
            samples: Vec::new(),
            accuracy: f64::INFINITY,
        };
        let mut points = candidates(full, &start, options);
        points.insert(0, start.clone());
        for point in &mut points {
            hold(full.parameters(), held, point);
        }
        let mut next = Some(start.clone());
        if let Some(known) = known {
            let answers = answers(full, &start, loads, (&span, &reduced.residual), options.tolerance)?;
            for vectors in [&span.of_unit_norm(&modes.shapes), &answers, &span.of_unit_norm(known)] {
                let room = options.most.saturating_sub(span.len());
                span.add_best(vectors, negligible(options.tolerance), room);
            }
            reduced.project(&span, n_rigid)?;
            next = reduced.worst(&points).filter(|_| reduced.accuracy > options.tolerance);
        }
        while let Some(sample) = next.take() {
            let shapes = snapshot(full, &solver, &sample, options.n_modes, (&span, reduced.residual.factor()))?;
            let answers = answers(full, &sample, loads, (&span, &reduced.residual), options.tolerance)?;
            let mut added = 0;
            for vectors in [&shapes, &answers] {
                let room = options.most.saturating_sub(span.len());
                added += span.add_best(vectors, negligible(options.tolerance), room);
            }
            reduced.samples.push(sample);
            reduced.project(&span, n_rigid)?;
            next = reduced.worst(&points).filter(|_| reduced.accuracy > options.tolerance && added > 0);
        }
        Ok(reduced)
    }

    /// The point with the largest error, which becomes the accuracy.
    fn worst(&mut self, points: &[Vec<f64>]) -> Option<Vec<f64>> {
        // Where there are no modes, nothing is approximated.
        let error = |theta: &Vec<f64>| self.frequency_errors(theta).map_or(0.0, |e| e.into_iter().fold(0.0, f64::max));
        let errors: Vec<f64> = points.par_iter().map(error).collect();
        let worst = (0..errors.len()).reduce(|a, b| if errors[b] > errors[a] { b } else { a })?;
        self.accuracy = errors[worst];
        Some(points[worst].clone())
    }

    /// Largest estimated relative error of a frequency at the points that were looked at.
    pub fn accuracy(&self) -> f64 {
        self.accuracy
    }

    /// The θ whose modes and derivatives of modes it is made of.
    pub fn samples(&self) -> &[Vec<f64>] {
        &self.samples
    }

    /// a of X = K + aM, in which the basis is orthonormal.
    pub fn shift(&self) -> f64 {
        self.residual.shift()
    }

    /// The factor of X.
    pub(super) fn factor(&self) -> &Arc<PencilFactor> {
        self.residual.factor()
    }

    /// V: dofs of the full model from those of this one, q = V y, (n_dof x n_reduced).
    pub fn basis(&self) -> &DMatrix<f64> {
        &self.basis
    }

    /// Estimated relative errors of the lowest elastic frequencies at θ.
    ///
    /// # Errors
    /// No modes at this θ.
    pub fn frequency_errors(&self, theta: &[f64]) -> Result<Vec<f64>, ModelError> {
        let system = self.assemble(theta)?;
        let modes = self.modes(&system)?;
        let factors: Vec<f64> = self.affine.at(theta).map(|term| term.1).collect();
        Ok(self.residual.frequency_errors(&factors, &system, &modes, self.n_modes).map_err(modal::ModalError::from)?)
    }

    fn modes(&self, system: &System) -> Result<Modes, ModelError> {
        let shift = Some(self.residual.shift());
        let options = SolveOptions { n_elastic: self.dofs.n_dof(), shift };
        Ok(modal::solve(&system.stiffness, &system.mass, &self.dofs.rigid_motions(), options)?)
    }

    /// The terms on the vectors of a span.
    fn project(&mut self, span: &Span<'_>, n_rigid: usize) -> Result<(), ModelError> {
        let Some(terms) = self.full.affine() else { return Err(ModelError::NotPolynomial) };
        let n = self.full.dof_map().n_dof();
        let v = span.vectors();
        self.residual.extend(&v);
        let damping = |list: &[Entry]| -> Vec<Entry> {
            if list.is_empty() {
                return Vec::new();
            }
            let a = SparseSym::from_triplets(n, list.iter().map(Entry::triplet));
            lower_entries(&a.on_basis(&v, n_rigid))
        };
        let mut reduced: Vec<Basis> =
            terms.bases().map(|b| Basis { damping: damping(&b.damping), ..Basis::default() }).collect();
        for (term, is_mass, projected) in self.residual.on_basis(&v) {
            let of = &mut reduced[term];
            *if is_mass { &mut of.mass } else { &mut of.stiffness } = lower_entries(&projected);
        }
        let mut reduced = reduced.into_iter();
        let mut next = || reduced.next().unwrap_or_default();
        self.affine = AffinePart {
            constant: next(),
            parameters: terms.parameters.iter().map(|_| next()).collect(),
            products: terms.products.iter().map(|(monomial, _)| (monomial.clone(), next())).collect(),
        };
        self.mirror = span.signs().map(|signs| signs.into_iter().enumerate().collect());
        self.dofs = self.full.dof_map().on_basis(&v, &span.coordinates_of_rigid_motions(n_rigid));
        self.basis = v;
        Ok(())
    }
}

/// Random points of the bounds; parameters without bounds stay at their values.
fn candidates(full: &dyn ParametricModel, start: &[f64], options: ReducedOptions) -> Vec<Vec<f64>> {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(options.seed);
    let parameters = full.parameters();
    let mut point = || {
        let value = |(p, value): (&super::Parameter, &f64)| match p.bounds {
            Some([lower, upper]) => lower + (upper - lower) * rng.random::<f64>(),
            None => *value,
        };
        parameters.iter().zip(start).map(value).collect()
    };
    let n = if parameters.free().is_empty() { 0 } else { options.n_candidates };
    (0..n).map(|_| point()).collect()
}

/// What may be left of the forces of derivatives.
const FEW_DIGITS: f64 = 1e-3;

/// Modes at θ and what their derivatives, times half the interval of each parameter, have across them, in units of the X norm of the modes.
///
/// The derivatives need few digits: the error that a basis leaves is estimated by itself, and another sample is taken where it is too large.
fn snapshot(
    full: &dyn ParametricModel,
    solver: &ModalSolver,
    theta: &[f64],
    n_modes: usize,
    (span, factor): (&Span<'_>, &PencilFactor),
) -> Result<DMatrix<f64>, ModelError> {
    let (matrices, modes) = solver.solve(full, theta, n_modes)?;
    let free = full.parameters().free();
    let slopes = matrices.derivatives(full, theta, &free)?;
    let (matrices, slopes) = (matrices.sparse(), slopes.iter().map(Matrices::sparse).collect::<Vec<_>>());
    let slopes: Vec<_> = slopes.iter().map(|s| (&s.stiffness, &s.mass)).collect();
    let half = |&p: &usize| full.parameters().get(p).bounds.map_or(0.0, |[lower, upper]| 0.5 * (upper - lower));
    let half: Vec<f64> = free.iter().map(half).collect();
    let (pencil, elastic) = ((&matrices.stiffness, &matrices.mass), modes.elastic().collect::<Vec<_>>());
    let mut columns: Vec<DVector<f64>> = Vec::new();
    modal::derivatives_across_modes(factor, pencil, &modes, &elastic, &slopes, FEW_DIGITS, |across| {
        let shape = modes.shapes.column(across.mode).into_owned();
        let norm = span.norm(&shape);
        columns.push(shape / norm);
        columns.extend(across.shapes.column_iter().zip(&half).map(|(d, half)| d * (half / norm)));
        Ok(())
    })?;
    Ok(if columns.is_empty() { DMatrix::zeros(full.dof_map().n_dof(), 0) } else { DMatrix::from_columns(&columns) })
}

/// Static answers a = X(θ)⁻¹ F to loads, and their derivatives -X⁻¹ ∂X a times half the interval of each parameter, in units of the X norm of the answers;
/// of such a length that what is negligible of a span is [`ANSWERED`] of them.
fn answers(
    full: &dyn ParametricModel,
    theta: &[f64],
    loads: Option<&DMatrix<f64>>,
    (span, residual): (&Span<'_>, &Residual),
    tolerance: f64,
) -> Result<DMatrix<f64>, ModelError> {
    let Some(loads) = loads.filter(|loads| loads.ncols() > 0) else {
        return Ok(DMatrix::zeros(full.dof_map().n_dof(), 0));
    };
    let system = full.assemble_sparse(theta)?;
    let shift = residual.shift();
    let factor = PencilFactor::new(residual.factor().plan().clone(), &system.stiffness, &system.mass, shift);
    let factor = factor.map_err(modal::ModalError::from)?;
    let answers = span.of_unit_norm(&factor.solve(loads));
    let mut columns: Vec<DVector<f64>> = answers.column_iter().map(nalgebra::Matrix::into_owned).collect();
    for p in full.parameters().free() {
        let Some([lower, upper]) = full.parameters().get(p).bounds else { continue };
        let slope = full.assemble_sparse_derivative(theta, p)?;
        let force = slope.stiffness.mul(&answers) + slope.mass.mul(&answers) * shift;
        columns.extend(factor.solve(&force).column_iter().map(|d| d * (0.5 * (upper - lower))));
    }
    Ok(DMatrix::from_columns(&columns) * (negligible(tolerance) / ANSWERED))
}

/// What may be missing of a static answer, as a share: the error of a response is the square of it.
const ANSWERED: f64 = 0.005;

impl ReducedModel<'_> {
    fn on_basis(&self, motion: &PointMotion) -> PointMotion {
        let on_basis = |row: &Vec<(usize, f64)>| -> Vec<(usize, f64)> {
            let value = |j: usize| row.iter().map(|&(i, f)| f * self.basis[(i, j)]).sum();
            if row.is_empty() { Vec::new() } else { (0..self.basis.ncols()).map(|j| (j, value(j))).collect() }
        };
        PointMotion { rows: motion.rows.each_ref().map(on_basis), position: motion.position }
    }
}

impl ParametricModel for ReducedModel<'_> {
    fn parameters(&self) -> &ParameterSet {
        self.full.parameters()
    }

    fn dof_map(&self) -> &DofMap {
        &self.dofs
    }

    fn assemble(&self, theta: &[f64]) -> Result<System, ModelError> {
        let mut system = System::zeros(self.dofs.n_dof(), self.is_damped);
        self.assemble_into(theta, &mut system)?;
        Ok(system)
    }

    fn assemble_into(&self, theta: &[f64], system: &mut System) -> Result<(), ModelError> {
        let expected = self.parameters().len();
        if theta.len() != expected {
            return Err(ModelError::WrongLength { expected, given: theta.len() });
        }
        system.clear();
        for (basis, factor) in self.affine.at(theta) {
            add_basis(system, basis, factor);
        }
        symmetrise(system);
        Ok(())
    }

    fn assemble_derivative(&self, theta: &[f64], j: usize) -> Result<System, ModelError> {
        let mut system = System::zeros(self.dofs.n_dof(), self.is_damped);
        for (basis, factor) in self.affine.derivative(theta, j) {
            add_basis(&mut system, basis, factor);
        }
        symmetrise(&mut system);
        Ok(system)
    }

    fn mass_properties(&self, theta: &[f64]) -> Result<Option<MassProperties>, ModelError> {
        self.full.mass_properties(theta)
    }

    fn mass_properties_beside(&self, theta: &[f64], others: &[(usize, f64)]) -> Vec<Option<MassProperties>> {
        self.full.mass_properties_beside(theta, others)
    }

    fn point(&self, element: &str, fraction: f64) -> Result<Option<PointMotion>, ModelError> {
        Ok(self.full.point(element, fraction)?.map(|m| self.on_basis(&m)))
    }

    fn point_near(&self, element: &str, place: [f64; 3]) -> Result<Option<PointMotion>, ModelError> {
        Ok(self.full.point_near(element, place)?.map(|m| self.on_basis(&m)))
    }

    fn element_names(&self) -> Vec<&str> {
        self.full.element_names()
    }

    fn modal_damping(&self) -> Option<&Affine> {
        self.full.modal_damping()
    }

    fn mirror(&self) -> Option<&[(usize, f64)]> {
        self.mirror.as_deref()
    }

    fn characters(
        &self,
        theta: &[f64],
        shapes: &DMatrix<f64>,
        n_rigid: usize,
    ) -> Result<Option<Vec<ModeCharacter>>, ModelError> {
        self.full.characters(theta, &(&self.basis * shapes), n_rigid)
    }

    fn targets(&self) -> Targets {
        self.full.targets()
    }

    fn has_mass_of(&self, j: usize) -> bool {
        self.full.has_mass_of(j)
    }

    fn affine_mass(&self) -> Option<&AffineMass> {
        self.full.affine_mass()
    }

    fn affine(&self) -> Option<&AffinePart> {
        Some(&self.affine)
    }
}
