//! Modes of a model, dense or sparse as its size asks.

use super::system::{SparseSystem, System};
use super::{DofMap, MOST_DENSE_DOFS, ModelError, ParametricModel};
use crate::linalg::sparse::{SparsePlan, SparseSym};
use crate::linalg::{DMatrix, DVector, LinalgError, ShiftedPencil};
use crate::modal::{self, Effort, MatrixDerivative, ModeDerivative, Modes, Neighbour, SolveOptions};
use std::borrow::Cow;
use std::sync::Arc;

/// From this number of dofs on the sparse path is used. Both give the same modes; `docs/sparse.md` has what a diagnosis takes by
/// each.
const SPARSE_FROM: usize = 120;

/// Below this number of dofs a model that the sparse path refuses is solved by the dense one.
const DENSE_BELOW: usize = 800;
/// Below this number of dofs full matrices, as those of a stand-in, are solved by the dense path.
const FULL_BELOW: usize = 260;
/// Part of the entries of a matrix that makes it full: elimination would fill the rest.
const FULL: f64 = 0.25;
/// From so many dofs on a factorisation for each mode costs more than steps across the modes.
const ONE_FACTOR_FROM: usize = 20_000;

/// K, M and C of a model at one θ.
#[derive(Debug, Clone)]
pub enum Matrices {
    /// Dense.
    Dense(System),
    /// Sparse.
    Sparse(SparseSystem),
}

impl Matrices {
    /// As dense matrices.
    ///
    /// # Errors
    /// [`ModelError::TooLarge`] above [`MOST_DENSE_DOFS`] dofs.
    pub fn dense(&self) -> Result<Cow<'_, System>, ModelError> {
        let sparse = match self {
            Self::Dense(system) => return Ok(Cow::Borrowed(system)),
            Self::Sparse(system) => system,
        };
        let n_dof = sparse.stiffness.n();
        if n_dof > MOST_DENSE_DOFS {
            return Err(ModelError::TooLarge { n_dof, most: MOST_DENSE_DOFS });
        }
        Ok(Cow::Owned(System {
            stiffness: sparse.stiffness.to_dense(),
            mass: sparse.mass.to_dense(),
            damping: sparse.damping.as_ref().map(SparseSym::to_dense),
        }))
    }

    /// As sparse matrices.
    pub(super) fn sparse(&self) -> Cow<'_, SparseSystem> {
        match self {
            Self::Dense(system) => Cow::Owned(SparseSystem::from(system)),
            Self::Sparse(system) => Cow::Borrowed(system),
        }
    }

    /// ∂K/∂θ_j, ∂M/∂θ_j, ∂C/∂θ_j, dense or sparse as these are.
    pub fn derivative(&self, model: &dyn ParametricModel, theta: &[f64], j: usize) -> Result<Self, ModelError> {
        match self {
            Self::Dense(_) => model.assemble_derivative(theta, j).map(Self::Dense),
            Self::Sparse(_) => model.assemble_sparse_derivative(theta, j).map(Self::Sparse),
        }
    }

    /// The same for several parameters.
    pub fn derivatives(
        &self,
        model: &dyn ParametricModel,
        theta: &[f64],
        parameters: &[usize],
    ) -> Result<Vec<Self>, ModelError> {
        parameters.iter().map(|&j| self.derivative(model, theta, j)).collect()
    }

    /// ∂λ = φᵀ (∂K - λ ∂M) φ, where these are ∂K and ∂M and φ has unit modal mass.
    pub fn eigenvalue_derivative(&self, lambda: f64, shape: &DVector<f64>) -> f64 {
        match self {
            Self::Dense(s) => {
                let slope = MatrixDerivative { stiffness: &s.stiffness, mass: &s.mass };
                modal::eigenvalue_derivative(lambda, shape, &slope)
            }
            Self::Sparse(s) => {
                let phi = DMatrix::from_columns(std::slice::from_ref(shape));
                phi.dot(&(s.stiffness.mul(&phi) - s.mass.mul(&phi) * lambda))
            }
        }
    }

    /// K x, (n x k).
    pub fn stiffness_times(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        match self {
            Self::Dense(system) => &system.stiffness * x,
            Self::Sparse(system) => system.stiffness.mul(x),
        }
    }

    /// M x, (n x k).
    pub fn mass_times(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        match self {
            Self::Dense(system) => &system.mass * x,
            Self::Sparse(system) => system.mass.mul(x),
        }
    }

    /// C x, (n x k); `None` without dashpots.
    pub fn damping_times(&self, x: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        match self {
            Self::Dense(system) => system.damping.as_ref().map(|c| c * x),
            Self::Sparse(system) => system.damping.as_ref().map(|c| c.mul(x)),
        }
    }
}

/// What a large model's first solution leaves for the others.
#[derive(Debug)]
struct Solved {
    plan: Arc<SparsePlan>,
    elastic: DMatrix<f64>,
    steps: usize,
}

/// What all solutions of one model share: rigid motions, the shift, and for a large model the elimination order and
/// the modes at the first θ, which every later solution starts from.
///
/// Solutions depend on θ only, not on those before: any number of threads may use it.
#[derive(Debug)]
pub struct ModalSolver {
    dof_map: DofMap,
    rigid_motions: DMatrix<f64>,
    shift: f64,
    is_damped: bool,
    sparse: Option<Solved>,
}

impl ModalSolver {
    /// For solutions near θ.
    ///
    /// * `n_elastic` - about how many elastic modes will be asked for
    ///
    /// # Errors
    /// As [`solve_modes`].
    pub fn new(model: &dyn ParametricModel, theta: &[f64], n_elastic: usize) -> Result<Self, ModelError> {
        Self::first(model, theta, n_elastic).map_err(|e| explained(model, theta, e))
    }

    fn first(model: &dyn ParametricModel, theta: &[f64], n_elastic: usize) -> Result<Self, ModelError> {
        let rigid_motions = model.dof_map().rigid_motions();
        let n_dof = model.dof_map().n_dof();
        if n_dof >= SPARSE_FROM {
            let system = model.assemble_sparse(theta)?;
            if n_dof >= FULL_BELOW || !is_full(&system) {
                match Self::sparse(model, &system, n_elastic, rigid_motions.clone()) {
                    Err(e) if n_dof < DENSE_BELOW && !is_unstable(&e) => {}
                    solver => return solver,
                }
            }
        }
        let system = model.assemble(theta)?;
        let shift = modal::typical_shift(&system.stiffness, &system.mass, &rigid_motions)?;
        let is_damped = system.damping.is_some();
        Ok(Self { dof_map: model.dof_map().clone(), rigid_motions, shift, is_damped, sparse: None })
    }

    /// Whether a model has the dofs of the model that this was made for: then it solves that model too.
    pub fn serves(&self, model: &dyn ParametricModel) -> bool {
        self.dof_map == *model.dof_map()
    }

    /// With an elimination order and the modes at a θ.
    fn sparse(
        model: &dyn ParametricModel,
        system: &SparseSystem,
        n_elastic: usize,
        rigid_motions: DMatrix<f64>,
    ) -> Result<Self, ModelError> {
        let plan = Arc::new(plan(model, system)?);
        let options = SolveOptions { n_elastic, shift: None };
        let (modes, Effort { shift, steps }) =
            modal::solve_sparse(&plan, &system.stiffness, &system.mass, &rigid_motions, options, None)?;
        let elastic = modes.shapes.columns(modes.n_rigid, modes.len() - modes.n_rigid).into_owned();
        let (dof_map, is_damped) = (model.dof_map().clone(), system.damping.is_some());
        Ok(Self { dof_map, rigid_motions, shift, is_damped, sparse: Some(Solved { plan, elastic, steps }) })
    }

    /// Matrices and modes at θ.
    pub fn solve(
        &self,
        model: &dyn ParametricModel,
        theta: &[f64],
        n_elastic: usize,
    ) -> Result<(Matrices, Modes), ModelError> {
        let options = SolveOptions { n_elastic, shift: Some(self.shift) };
        if let Some(solved) = &self.sparse {
            let solved = self.solve_sparse(model, theta, options, solved);
            if !is_for_dense(model, solved.as_ref().map(|(_, modes)| modes), n_elastic) {
                return solved;
            }
        }
        let system = model.assemble(theta)?;
        let modes = modal::solve(&system.stiffness, &system.mass, &self.rigid_motions, options)?;
        Ok((Matrices::Dense(system), modes))
    }

    fn solve_sparse(
        &self,
        model: &dyn ParametricModel,
        theta: &[f64],
        options: SolveOptions,
        solved: &Solved,
    ) -> Result<(Matrices, Modes), ModelError> {
        let system = model.assemble_sparse(theta)?;
        let (k, m) = (&system.stiffness, &system.mass);
        let near = Neighbour { shapes: &solved.elastic, steps: solved.steps };
        let own = if covers(&solved.plan, &system) { None } else { Some(Arc::new(plan(model, &system)?)) };
        let plan = own.as_ref().unwrap_or(&solved.plan);
        let solved = modal::solve_sparse(plan, k, m, &self.rigid_motions, options, Some(near));
        // Shapes and shift of a neighbour that is far away may leave a value that is not a mode's: it is looked at from nothing.
        let (modes, _) = match solved {
            Err(modal::ModalError::Unstable { .. } | modal::ModalError::Linalg(LinalgError::NoConvergence { .. })) => {
                let afresh = SolveOptions { shift: None, ..options };
                modal::solve_sparse(plan, k, m, &self.rigid_motions, afresh, None)?
            }
            solved => solved?,
        };
        Ok((Matrices::Sparse(system), modes))
    }

    /// Whether the model that this was made for has dashpots.
    pub fn is_damped(&self) -> bool {
        self.is_damped
    }

    /// Derivatives of some modes with respect to as many parameters as there are `slopes`; `None` where λ is double.
    ///
    /// * `matrices`, `modes` - of [`Self::solve`] at one θ
    /// * `slopes` - of [`Matrices::derivative`] at the same θ
    /// * `of` - indices into `modes`
    pub fn differentiate(
        &self,
        model: &dyn ParametricModel,
        matrices: &Matrices,
        slopes: &[Matrices],
        modes: &Modes,
        of: &[usize],
    ) -> Result<Vec<Option<ModeDerivative>>, ModelError> {
        match matrices {
            Matrices::Sparse(system) if modes.shapes.nrows() >= ONE_FACTOR_FROM => {
                let slopes: Vec<Cow<'_, SparseSystem>> = slopes.iter().map(Matrices::sparse).collect();
                let slopes: Vec<_> = slopes.iter().map(|s| (&s.stiffness, &s.mass)).collect();
                let pencil = (&system.stiffness, &system.mass);
                let plan = self.plan_for(model, system)?;
                Ok(modal::mode_derivatives_sparse(&plan, pencil, self.shift, modes, of, &slopes)?)
            }
            _ => {
                let alone: Vec<(Vec<usize>, usize)> = of.iter().map(|&i| (vec![i], 0)).collect();
                self.differentiate_in_clusters(model, matrices, slopes, modes, &alone)
            }
        }
    }

    /// Derivatives of modes of clusters of (nearly) equal λ.
    ///
    /// * `matrices`, `modes` - of [`Self::solve`] at one θ, shapes in any basis of the cluster
    /// * `slopes` - of [`Matrices::derivative`] at the same θ
    /// * `of` - the cluster of each mode and its number there: indices into `modes`, and one into the cluster
    pub fn differentiate_in_clusters(
        &self,
        model: &dyn ParametricModel,
        matrices: &Matrices,
        slopes: &[Matrices],
        modes: &Modes,
        of: &[(Vec<usize>, usize)],
    ) -> Result<Vec<Option<ModeDerivative>>, ModelError> {
        if of.is_empty() {
            return Ok(Vec::new());
        }
        let shapes = |cluster: &[usize]| modes.shapes.select_columns(cluster);
        let lambda = |(cluster, own): &(Vec<usize>, usize)| modes.lambda[cluster[*own]];
        match matrices {
            Matrices::Dense(system) => {
                let basis = match &modes.basis {
                    Some(basis) => basis.clone(),
                    None => Arc::new(
                        ShiftedPencil::new(&system.stiffness, &system.mass, self.shift)
                            .map_err(modal::ModalError::from)?,
                    ),
                };
                let slopes = slopes.iter().map(Matrices::dense).collect::<Result<Vec<_>, _>>()?;
                let slopes: Vec<MatrixDerivative<'_>> =
                    slopes.iter().map(|s| MatrixDerivative { stiffness: &s.stiffness, mass: &s.mass }).collect();
                Ok(modal::derivatives_on_basis(&basis, (&modes.lambda, &modes.shapes), of, &slopes))
            }
            Matrices::Sparse(system) => {
                let slopes: Vec<Cow<'_, SparseSystem>> = slopes.iter().map(Matrices::sparse).collect();
                let slopes: Vec<_> = slopes.iter().map(|s| (&s.stiffness, &s.mass)).collect();
                let plan = self.plan_for(model, system)?;
                let pencil = (&system.stiffness, &system.mass);
                let derivative = |of: &(Vec<usize>, usize)| {
                    modal::mode_derivative_sparse(&plan, pencil, lambda(of), &shapes(&of.0), of.1, &slopes)
                };
                Ok(of.iter().map(derivative).collect::<Result<Vec<_>, _>>()?)
            }
        }
    }

    /// The elimination order of the first solution, or one of its own where these matrices have entries elsewhere.
    pub(super) fn plan_for(
        &self,
        model: &dyn ParametricModel,
        system: &SparseSystem,
    ) -> Result<Arc<SparsePlan>, ModelError> {
        match &self.sparse {
            Some(solved) if covers(&solved.plan, system) => Ok(solved.plan.clone()),
            _ => Ok(Arc::new(plan(model, system)?)),
        }
    }
}

/// Whether a small model is to be solved by dense matrices after all: the iteration has failed, or has fewer modes than were asked for; then there are
/// no more, or it has used up the motions with mass before it found them.
fn is_for_dense(model: &dyn ParametricModel, solved: Result<&Modes, &ModelError>, n_elastic: usize) -> bool {
    model.dof_map().n_dof() < DENSE_BELOW
        && solved.map_or_else(|e| !is_unstable(e), |modes| modes.elastic().len() < n_elastic)
}

/// A structure that is not stable has no modes, whatever the matrices are stored as.
fn is_unstable(error: &ModelError) -> bool {
    matches!(error, ModelError::Modal(modal::ModalError::Unstable { .. }))
}

fn is_full(system: &SparseSystem) -> bool {
    let n = system.stiffness.n();
    let entries = system.stiffness.len().max(system.mass.len());
    entries as f64 > FULL * (n * (n + 1) / 2) as f64
}

fn covers(plan: &SparsePlan, system: &SparseSystem) -> bool {
    plan.covers(&system.stiffness) && plan.covers(&system.mass)
}

pub(super) fn plan(model: &dyn ParametricModel, system: &SparseSystem) -> Result<SparsePlan, ModelError> {
    let node: Vec<usize> = model.dof_map().rows().iter().map(|r| r.0).collect();
    Ok(SparsePlan::new(&system.stiffness, &system.mass, &node).map_err(modal::ModalError::from)?)
}

/// The modes of a model at one θ, dense or sparse as its size asks.
///
/// # Errors
/// [`ModelError::Buckled`] where a preload makes the structure unstable, [`modal::ModalError::Unstable`] where something else does;
/// the others of the solution.
pub fn solve_modes(model: &dyn ParametricModel, theta: &[f64], options: SolveOptions) -> Result<Modes, ModelError> {
    solved(model, theta, options).map_err(|e| explained(model, theta, e))
}

/// An instability with the preload that causes it.
fn explained(model: &dyn ParametricModel, theta: &[f64], error: ModelError) -> ModelError {
    let ModelError::Modal(modal::ModalError::Unstable { n }) = error else { return error };
    match model.critical_preload(theta) {
        Ok(Some(critical)) if critical.factor <= 1.0 => ModelError::Buckled(critical, n),
        _ => error,
    }
}

fn solved(model: &dyn ParametricModel, theta: &[f64], options: SolveOptions) -> Result<Modes, ModelError> {
    let motions = model.dof_map().rigid_motions();
    if model.dof_map().n_dof() >= SPARSE_FROM {
        let system = model.assemble_sparse(theta)?;
        let plan = plan(model, &system)?;
        let solved = modal::solve_sparse(&plan, &system.stiffness, &system.mass, &motions, options, None);
        let solved = solved.map(|(modes, _)| modes).map_err(ModelError::from);
        if !is_for_dense(model, solved.as_ref(), options.n_elastic) {
            return solved;
        }
    }
    let system = model.assemble(theta)?;
    Ok(modal::solve(&system.stiffness, &system.mass, &motions, options)?)
}
