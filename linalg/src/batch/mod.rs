//! Many small modal analyses at once: the lowest elastic modes of K(θ) φ = λ M(θ) φ for a batch of θ.
//!
//! An optimiser asks for thousands of candidates of one model. Their matrices have the same pattern, so eight of them
//! are solved side by side in the lanes of vector registers (structure of arrays: one `lane` number holds the same
//! entry of eight matrices). Everything that depends on the model alone is decided once, in [`BatchModel::new`]. Two batches go
//! through QL together, where a row waits for a division.
//!
//! ```text
//! once      mirror symmetry -> two families of shapes;  supports instead of rigid-body modes;  order, envelope, lists
//! a batch   assemble -> K + a M = L Lᵀ -> C = L⁻¹ M L⁻ᵀ -> Householder: T -> QL -> Sturm counts -> secant where there is no QL
//!           -> inverse iteration -> back to the sensors -> merge the families
//! ```
//!
//! C is the *inverse* problem, θ = 1/(λ + a): the wanted modes are its largest eigenvalues and come out with full relative
//! accuracy however stiff the top of the spectrum is; massless dofs need no special case (θ = 0). C is rounded by ε of its
//! largest θ, which is much beside the last wanted one where these span a wide range. There a = 4 √(λ_1 λ_n) leaves both ends accurate;
//! elsewhere a = 0, and K keeps its zeros.
//!
//! Checks, always on: pivots of K and of Rᵀ M R, no negative eigenvalue of C (M ≥ 0), a Sturm count that says how many
//! modes each family contributes before any is computed, and the residual of every eigenpair. A lane that fails one is
//! redone alone by [`lowest_modes`](super::lowest_modes) and says so in its [`Outcome`].
//!
//! A lane never learns who its companions are: no branch depends on a value, and a lane that has converged is frozen.
//! So the bits of a result do not depend on the grouping of the candidates or on the number of threads. They can differ
//! between processors with and without fused multiply-add.
//!
//! Sources: G. H. Golub, C. F. Van Loan, Matrix Computations, 4th ed., 2013; B. N. Parlett, The Symmetric Eigenvalue
//! Problem, 1998; W. Barth, R. S. Martin, J. H. Wilkinson, Numer. Math. 9, 1967. Start reading at [`BatchModel`].

// A kernel runs with the instructions of the function it is inlined into; without the attribute it would run without them.
#![allow(clippy::inline_always)]

mod assemble;
mod cholesky;
mod dispatch;
mod inverse_iteration;
mod lane;
mod mirror;
mod pencil;
mod plan;
mod reference;
mod results;
mod solve;
mod sturm;
#[cfg(test)]
mod tests;
mod tridiagonal;
mod values;
#[cfg(target_arch = "x86_64")]
mod wide;

pub use mirror::{Mirror, detect_mirror};
pub use pencil::{AffineEntry, AffinePencil};
pub use results::{BatchModes, Cause, Outcome};

use dispatch::{AnyBuffers, Level};
use lane::{LANES, Lane};
use solve::{Lapse, Plan};

use super::{DMatrix, LinalgError};

/// Number of candidates that are solved together; a multiple of it wastes no lane, and one of half of it hardly anything.
pub const BATCH: usize = 2 * LANES;

/// Why a batch model cannot be made, or a batch not be solved.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BatchError {
    /// An entry lies outside the lower triangle.
    #[error("{matrix} entry ({row}, {col}) is outside the lower triangle of {n} rows; give each pair once, row >= col")]
    EntryOutside {
        /// "stiffness" or "mass".
        matrix: &'static str,
        /// Its row.
        row: usize,
        /// Its column.
        col: usize,
        /// Number of dofs.
        n: usize,
    },
    /// An entry names a parameter that does not exist.
    #[error("a {matrix} entry uses parameter {parameter}, but there are only {n_parameters}")]
    UnknownParameter {
        /// "stiffness" or "mass".
        matrix: &'static str,
        /// The index.
        parameter: usize,
        /// Number of parameters.
        n_parameters: usize,
    },
    /// A coefficient is NaN or infinite.
    #[error("the coefficient of {matrix} entry ({row}, {col}) is not finite")]
    NotFinite {
        /// "stiffness" or "mass".
        matrix: &'static str,
        /// Its row.
        row: usize,
        /// Its column.
        col: usize,
    },
    /// The model is too large for a dense kernel.
    #[error("the model has {n} dofs; the dense batch kernel takes at most {limit}, use the sparse path")]
    TooLarge {
        /// Number of dofs.
        n: usize,
        /// The limit.
        limit: usize,
    },
    /// A matrix or vector has the wrong size.
    #[error("{what}: {found} given, {expected} expected")]
    Size {
        /// What has the wrong size.
        what: &'static str,
        /// Its size.
        found: usize,
        /// The right one.
        expected: usize,
    },
    /// A rigid-body mode stores strain energy.
    #[error(
        "the rigid-body modes are not free of force: relative violation {violation:.1e} at dof {dof}; leave out the motions that supports or springs resist"
    )]
    NotRigid {
        /// |K_j R| over the sum of the absolute values of its terms.
        violation: f64,
        /// The dof.
        dof: usize,
    },
    /// The rigid-body modes are linearly dependent, or move only dofs without stiffness.
    #[error("{given} rigid-body modes are given, but only {independent} of them are independent")]
    DependentRigidModes {
        /// Number of columns.
        given: usize,
        /// Their rank.
        independent: usize,
    },
    /// The mirror has the wrong size.
    #[error("the mirror has {dofs} partners and {signs} signs for {n} dofs")]
    MirrorSize {
        /// Length of the permutation.
        dofs: usize,
        /// Length of the signs.
        signs: usize,
        /// Number of dofs.
        n: usize,
    },
    /// The mirror applied twice is not the identity.
    #[error("mirror: the partner of the partner of dof {dof} is not itself, or its sign is not +1 or -1 for both")]
    MirrorNotInvolution {
        /// The dof.
        dof: usize,
    },
    /// The model is not symmetric about the mirror.
    #[error("the model is not symmetric about the mirror; test it with `detect_mirror` first")]
    NotSymmetric,
    /// More modes are asked for than there are.
    #[error("{asked} elastic modes are asked for; the model has {available}")]
    TooManyModes {
        /// Number asked for.
        asked: usize,
        /// Number of dofs less that of rigid-body modes.
        available: usize,
    },
    /// The nominal model has no modes.
    #[error("the model has no elastic modes at its nominal parameters")]
    Nominal(#[source] LinalgError),
    /// K is singular beyond the rigid-body modes.
    #[error("at its nominal parameters the model has more motions without strain energy than the {rigid} given")]
    Mechanism {
        /// Number of given rigid-body modes.
        rigid: usize,
    },
    /// The workspace was made for another model.
    #[error("the workspace was made for another model")]
    ForeignWorkspace,
}

/// A model, compiled for batches of candidates.
#[derive(Debug, Clone)]
pub struct BatchModel {
    pencil: AffinePencil,
    rigid: usize,
    sensors: DMatrix<f64>,
    plan: Plan,
    /// Shift of the reference path, rad²/s².
    shift: f64,
    /// What a workspace must share.
    identity: Vec<usize>,
}

/// What [`BatchModel::new`] needs beside the matrices.
#[derive(Debug, Clone, PartialEq)]
pub struct BatchOptions {
    /// How many elastic modes, from the lowest one on.
    pub n_modes: usize,
    /// Exact null space of K(θ) for every θ (n x r, r may be 0): the rigid-body motions.
    pub rigid: DMatrix<f64>,
    /// A signed permutation that leaves all K_j, M_j unchanged, see [`detect_mirror`].
    pub mirror: Option<Mirror>,
    /// Observation rows (n_sensors x n): shapes come out as `sensors * φ`; `None` gives them at all n dofs.
    pub sensors: Option<DMatrix<f64>>,
    /// Vectors at the sensor rows (n_sensors x any number) whose products with every shape are wanted, see
    /// [`BatchModes::products`].
    pub references: Option<DMatrix<f64>>,
    /// Whether the shapes themselves are wanted; products alone take less time.
    pub shapes: bool,
}

impl BatchModel {
    /// Compiles a model.
    ///
    /// * `pencil` - K(θ) and M(θ), affine
    /// * `nominal` - a θ inside the bounds; it decides the scale, the supports and the shift, never the result
    /// * `options` - modes, rigid-body motions, mirror, sensors
    ///
    /// # Errors
    /// Sizes that do not fit, rigid motions that store strain energy, a mirror that is none, a nominal model that has
    /// no modes.
    pub fn new(pencil: AffinePencil, nominal: &[f64], options: BatchOptions) -> Result<Self, BatchError> {
        let n = pencil.n;
        if n > MAX_DOFS {
            return Err(BatchError::TooLarge { n, limit: MAX_DOFS });
        }
        pencil.check()?;
        let size = |what, found, expected| {
            if found == expected { Ok(()) } else { Err(BatchError::Size { what, found, expected }) }
        };
        size("nominal parameters", nominal.len(), pencil.n_parameters)?;
        let rigid = options.rigid;
        size("rows of the rigid-body modes", rigid.nrows(), n)?;
        let sensors = options.sensors.unwrap_or_else(|| DMatrix::identity(n, n));
        size("columns of the sensor matrix", sensors.ncols(), n)?;
        if let Some(references) = &options.references {
            size("rows of the references", references.nrows(), sensors.nrows())?;
        }
        let available = n.saturating_sub(rigid.ncols());
        if options.n_modes == 0 || options.n_modes > available {
            return Err(BatchError::TooManyModes { asked: options.n_modes, available });
        }
        let (violation, dof) = pencil.rigid_violation(&rigid);
        if violation.is_nan() || violation > RIGID_TOLERANCE {
            return Err(BatchError::NotRigid { violation, dof });
        }
        if let Some(mirror) = &options.mirror
            && !detect_mirror(&pencil, mirror)?
        {
            return Err(BatchError::NotSymmetric);
        }
        let (k, m) = pencil.assemble(nominal);
        let scale = reference::nominal_scale(&k, &m, rigid.ncols(), options.n_modes)?;
        let shift = if scale.last > WIDE_SPECTRUM * scale.first { UPPER_END * scale.shift } else { 0.0 };
        let stiffness: Vec<f64> = k.diagonal().iter().copied().collect();
        // A power of four brings the largest 1/λ near one; its root is exact too.
        let mass_scale = 4.0_f64.powi((0.5 * (scale.first + shift).log2()).round() as i32);
        let references = options.references.map(|r| r.transpose().as_slice().to_vec());
        let seen = (&sensors, references.as_deref());
        let compile = |family| plan::compile(&pencil, family, &rigid, &stiffness, mass_scale, seen, shift > 0.0);
        let blocks: Vec<_> = mirror::families(n, options.mirror.as_ref()).iter().map(compile).collect();
        let independent = blocks.iter().map(|b| b.r).sum();
        if independent != rigid.ncols() {
            return Err(BatchError::DependentRigidModes { given: rigid.ncols(), independent });
        }
        let blocks: Vec<_> = blocks.into_iter().filter(|b| b.m > 0).collect();
        let largest = blocks.iter().map(|b| b.m).max().unwrap_or(0);
        let plan = Plan {
            n_modes: options.n_modes,
            n_parameters: pencil.n_parameters,
            n_rows: sensors.nrows(),
            references,
            with_shapes: options.shapes,
            shift,
            mass_scale,
            start: start_values(largest + 32),
            blocks,
        };
        let identity = identity(&plan);
        Ok(Self { rigid: rigid.ncols(), shift: scale.shift, pencil, sensors, plan, identity })
    }

    /// Number of elastic modes per candidate.
    pub fn n_modes(&self) -> usize {
        self.plan.n_modes
    }

    /// Number of sensor rows per shape; n without sensors.
    pub fn n_rows(&self) -> usize {
        self.plan.n_rows
    }

    /// The pencil the model was made from.
    pub fn pencil(&self) -> &AffinePencil {
        &self.pencil
    }

    /// Solves all candidates, [`BATCH`] at a time; the results stay in the workspace.
    ///
    /// * `thetas` - any number of candidates, each with one value per parameter
    /// * `workspace` - one per thread; nothing is allocated as long as there are no more candidates than it was made
    ///   for and none falls back to the reference path
    ///
    /// The result of a candidate does not depend on the other ones.
    ///
    /// # Errors
    /// A θ of the wrong length or a workspace of another model. A candidate without modes is not an error, see [`Outcome`].
    pub fn solve<'w>(&self, thetas: &[&[f64]], workspace: &'w mut Workspace) -> Result<&'w BatchModes, BatchError> {
        self.run(thetas, workspace, true)
    }

    /// Like [`solve`](Self::solve), for callers with a reference path of their own: a candidate whose result the kernel
    /// does not guarantee is left, see [`Outcome::Left`]. Then nothing is allocated whatever happens.
    ///
    /// # Errors
    /// Those of [`solve`](Self::solve).
    pub fn attempt<'w>(&self, thetas: &[&[f64]], workspace: &'w mut Workspace) -> Result<&'w BatchModes, BatchError> {
        self.run(thetas, workspace, false)
    }

    fn run<'w>(
        &self,
        thetas: &[&[f64]],
        workspace: &'w mut Workspace,
        redo: bool,
    ) -> Result<&'w BatchModes, BatchError> {
        if workspace.identity != self.identity {
            return Err(BatchError::ForeignWorkspace);
        }
        for theta in thetas {
            if theta.len() != self.plan.n_parameters {
                let (found, expected) = (theta.len(), self.plan.n_parameters);
                return Err(BatchError::Size { what: "values of a candidate", found, expected });
            }
        }
        workspace.modes.reset(thetas.len());
        for (k, candidates) in thetas.chunks(BATCH).enumerate() {
            match &mut workspace.buffers {
                #[cfg(target_arch = "x86_64")]
                AnyBuffers::Wide(buffers) => load(candidates, buffers),
                #[cfg(target_arch = "x86_64")]
                AnyBuffers::Fused(buffers) => load(candidates, buffers),
                AnyBuffers::Plain(buffers) => load(candidates, buffers),
            }
            workspace.buffers.solve(&self.plan, candidates.len().div_ceil(LANES));
            let modes = &mut workspace.modes;
            match &workspace.buffers {
                #[cfg(target_arch = "x86_64")]
                AnyBuffers::Wide(buffers) => self.unload(buffers, candidates, k * BATCH, redo, modes),
                #[cfg(target_arch = "x86_64")]
                AnyBuffers::Fused(buffers) => self.unload(buffers, candidates, k * BATCH, redo, modes),
                AnyBuffers::Plain(buffers) => self.unload(buffers, candidates, k * BATCH, redo, modes),
            }
        }
        Ok(&workspace.modes)
    }

    /// Copies the lanes into the results; redoes or leaves the lanes without one.
    fn unload<L: Lane>(
        &self,
        batches: &[solve::Buffers<L>; 2],
        candidates: &[&[f64]],
        first: usize,
        redo: bool,
        modes: &mut BatchModes,
    ) {
        for (k, theta) in candidates.iter().enumerate() {
            let (buffers, lane) = (&batches[k / LANES], k % LANES);
            match buffers.lapses[lane] {
                None => {
                    let chosen = buffers.chosen[lane][..self.plan.n_modes].iter();
                    let width = self.plan.width();
                    for (j, &(lambda, block, column)) in chosen.enumerate() {
                        let (value, shape) = modes.slot(first + k, j);
                        *value = lambda;
                        let copy = |out: &mut [f64], lanes: &[L]| {
                            // Without sensors nothing is observed.
                            let own = lanes.get(column..).unwrap_or_default().iter().step_by(width);
                            out.iter_mut().zip(own).for_each(|(x, lanes)| *x = lanes.array()[lane]);
                        };
                        copy(shape, &buffers.blocks[block].observed);
                        copy(modes.products_mut(first + k, j), &buffers.blocks[block].products);
                        modes.set_parity(first + k, j, self.plan.blocks[block].parity);
                    }
                }
                Some(lapse) if redo => self.solve_alone(theta, lapse.into(), first + k, modes),
                Some(lapse) => modes.blank(first + k, Outcome::Left(lapse.into())),
            }
        }
    }
}

/// Eight dense matrices of this size fill 64 MB: far above it, a sparse solver is faster anyway.
const MAX_DOFS: usize = 1000;

/// Ratio of the last wanted λ to the first from which on K is shifted: M-orthogonality errs by about ε times it, and 1e-13 is promised.
const WIDE_SPECTRUM: f64 = 1e3;

/// The shift over √(λ_1 λ_n): what it takes from the accuracy of λ_1, some ε a/λ_1, is never missed, what it gives to M-orthogonality is.
const UPPER_END: f64 = 4.0;

/// Largest relative force of a rigid motion: rounding of coordinates in the assembly, far below any spring.
const RIGID_TOLERANCE: f64 = 1e-8;

fn load<L: Lane>(candidates: &[&[f64]], batches: &mut [solve::Buffers<L>; 2]) {
    for (candidates, buffers) in candidates.chunks(LANES).zip(batches) {
        for lane in 0..LANES {
            // Lanes without a candidate repeat the last one.
            if let Some(theta) = candidates.get(lane).or(candidates.last()) {
                for (p, &value) in buffers.parameters.iter_mut().zip(*theta) {
                    p.array_mut()[lane] = value;
                }
            }
        }
    }
}

/// Fixed numbers in ±[0.5, 1] without a pattern: a Weyl sequence of the golden ratio.
fn start_values(count: usize) -> Vec<f64> {
    let golden = 0.618_033_988_749_894_9;
    let at = |i: usize| {
        let t = (golden * (i + 1) as f64).fract() - 0.5;
        t + 0.5_f64.copysign(t)
    };
    (0..count).map(at).collect()
}

/// What a workspace must share with a model: the sizes of everything.
fn identity(plan: &Plan) -> Vec<usize> {
    let sizes = plan.blocks.iter().flat_map(|b| [b.m, b.r, b.envelope.len()]);
    let shapes = usize::from(plan.with_shapes);
    [plan.n_modes, plan.n_parameters, plan.n_rows, plan.n_products(), shapes].into_iter().chain(sizes).collect()
}

/// The memory of one thread.
pub struct Workspace {
    buffers: AnyBuffers,
    modes: BatchModes,
    identity: Vec<usize>,
}

impl Workspace {
    /// Memory for `candidates` candidates a call of this model; more are possible and grow it.
    pub fn new(model: &BatchModel, candidates: usize) -> Self {
        Self::with_level(model, candidates, dispatch::level())
    }

    fn with_level(model: &BatchModel, candidates: usize, level: Level) -> Self {
        Self {
            buffers: AnyBuffers::new(&model.plan, level),
            modes: BatchModes::new(&model.plan, candidates),
            identity: model.identity.clone(),
        }
    }
}

impl std::fmt::Debug for Workspace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Workspace").field("sizes", &self.identity).finish_non_exhaustive()
    }
}

impl From<Lapse> for Cause {
    fn from(lapse: Lapse) -> Self {
        match lapse {
            Lapse::Stiffness => Self::Stiffness,
            Lapse::Mass => Self::Mass,
            Lapse::Count => Self::Count,
            Lapse::Residual => Self::Residual,
        }
    }
}
