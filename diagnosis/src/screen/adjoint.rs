//! The screening of a large model: what every placed change would do to the modes at the sensors, to first order, from a few solutions.
//!
//! ```text
//! f_i = Σ_e B_eᵀ (Δk_e - λ_i Δm_e) B_e φ_i                     the force of a change on mode i: local
//! δλ_i = φ_i · f_i,    δ(s·φ_i) = -z_is · f_i - ½ (φ_iᵀ ΔM φ_i) s·φ_i
//! (K - λ_i M) z_is = s  across the modes,    z_is += Σ_j φ_j (s·φ_j)/(λ_j - λ_i)   over the other modes, far ones and rigid ones
//! ```
//!
//! z belongs to a mode and a sensor; a change takes products of its own few rows. Modes so close to i that they are turned to the test are left out of
//! the sum, as a turn among them is free; others nearer than 2 % stand as if they were 2 % apart, since a change of any size turns them by a right
//! angle at most. Coordinates that a change brings are condensed at λ_i, so that a body on a spring acts as it does at that
//! frequency. All columns are slopes: a change of the typical size may be far from linear, and only a refit tells.
//!
//! # Source
//! R. L. Fox, M. P. Kapoor, Rates of change of eigenvalues and eigenvectors, AIAA Journal 6(12), 1968; R. B. Nelson, Simplified calculation of
//! eigenvector derivatives, AIAA Journal 14(9), 1976, in its adjoint form.

use super::effects::{Column, Screened, evaluate_anew, screen as screen_each, steps, worth_more};
use crate::error::DiagnosisError;
use crate::listener::Listener;
use crate::problem::fit::Fit;
use crate::problem::prior::Prior;
use crate::problem::rows::Posed;
use crate::problem::scene::{Case, Scene};
use crate::settings::Settings;
use crate::thresholds::SMALL_STEP;
use rayon::prelude::*;
use retune::correlation::{CorrelationError, observation_rows};
use retune::data::{Place, Sensor};
use retune::effect::Candidate;
use retune::element::Dof;
use retune::linalg::sparse::{IndefinitePencil, SparsePlan};
use retune::linalg::vector3::cross;
use retune::linalg::{DMatrix, DVector, LinalgError, SymMatrix, tall_take, tall_tr_mul};
use retune::model::{Change, ChangeAt, MassProperties, Model, ModelError, ParametricModel, StandIn, Targets};
use retune::objective::{Answering, Answers as LoadAnswers, Comparison, Prediction};
use std::sync::{Arc, Mutex, PoisonError};

/// Where (K - σM) is factored instead of at λ, as a share of λ beside it: the matrix is regular there, and what lies across the modes differs by
/// about this share of it.
const BESIDE: f64 = 1e-3;
/// Modes whose frequencies are nearer than this share are taken to be so far apart.
const CLOSE: f64 = 0.02;
/// Shapes and frequencies are moved by this share at most, and the columns are scaled back: they are slopes.
const MOVED: f64 = 1e-3;

/// What the sensors answer at one point of the parameters, kept for effects that are looked at later from there.
#[derive(Default)]
pub(crate) struct Answers(Mutex<Option<Known>>);

/// A point, and what the sensors of every case answer there.
type Known = (Vec<f64>, Arc<Vec<Adjoint>>);

impl Answers {
    /// Those at a point; of another point they are forgotten.
    fn at(
        &self,
        theta: &[f64],
        solve: impl FnOnce() -> Result<Vec<Adjoint>, DiagnosisError>,
    ) -> Result<Arc<Vec<Adjoint>>, DiagnosisError> {
        let known = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, answers)) = known().as_ref().filter(|(at, _)| at == theta) {
            return Ok(answers.clone());
        }
        self.forget();
        let solved = Arc::new(solve()?);
        *known() = Some((theta.to_vec(), solved.clone()));
        Ok(solved)
    }

    /// Of 10⁶ dofs they take gigabytes.
    pub(crate) fn forget(&self) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

/// The modes of a case, and what a force on the structure does to them at the sensors.
struct Adjoint {
    prediction: Arc<Prediction>,
    /// Paired modes: elastic mode, λ, shape on the rows.
    modes: Vec<(usize, f64, DVector<f64>)>,
    /// zᵀ of each, (n_sensors x n_dof).
    answers: Vec<DMatrix<f64>>,
    /// Damping ratios by dashpots of all elastic modes; empty where the model has no damping.
    ratios: Vec<f64>,
    /// Parameters of the model.
    theta: Vec<f64>,
    /// Rᵀ M R of the six rigid motions, where something is compared with it.
    mass: Option<SymMatrix>,
    mounted: Vec<Mounted>,
    /// Static tests and functions, and what is solved for them.
    answering: Option<(Answering, Arc<StandIn>)>,
}

/// Candidates times dofs from which slopes choose who is evaluated: an imported aircraft of 400 dofs has 9 000 candidates, and every evaluation of
/// them takes minutes.
const MANY: usize = 1_500_000;
/// How many times as many are evaluated then as on top of another stage, where columns of the same sizes are known.
const WIDER: usize = 4;

/// [`super::effects::screen`], of a large model by its adjoint solutions; of a small one with very many candidates by them first, and by evaluations of
/// those that then score best, of the best of every kind, and of those that have no slope.
pub(crate) fn screen(
    scene: &Scene,
    fit: &Fit,
    weight: f64,
    candidates: Vec<Candidate>,
    settings: &Settings,
    answers: &Answers,
) -> Result<Vec<Screened>, DiagnosisError> {
    if scene.is_large() {
        return screen_large(scene, fit, weight, candidates, &settings.listener, answers);
    }
    let of_modes = !scene.is_damped && !scene.cases.iter().any(|c| c.test.has_more_than_modes());
    if !of_modes || scene.most_dofs() * candidates.len() < MANY {
        return Ok(screen_each(scene, fit, weight, candidates, settings));
    }
    slopes_first(scene, fit, weight, candidates, settings)
}

/// Slopes of all candidates, and evaluations of those that they put first and of those that have none.
pub(crate) fn slopes_first(
    scene: &Scene,
    fit: &Fit,
    weight: f64,
    candidates: Vec<Candidate>,
    settings: &Settings,
) -> Result<Vec<Screened>, DiagnosisError> {
    let mut known = screen_large(scene, fit, weight, candidates, &settings.listener, &Answers::default())?;
    let effort = &settings.effort;
    let mut anew = worth_more(&known, fit, &fit.basis()?, WIDER * effort.anew, WIDER * effort.anew_of_a_kind);
    anew.extend((0..known.len()).filter(|&i| known[i].columns.is_empty()));
    evaluate_anew(scene, fit, weight, &mut known, anew, settings);
    Ok(known)
}

fn screen_large(
    scene: &Scene,
    fit: &Fit,
    weight: f64,
    candidates: Vec<Candidate>,
    listener: &Listener,
    answers: &Answers,
) -> Result<Vec<Screened>, DiagnosisError> {
    listener.say("placing effects");
    scene.place(&candidates);
    let comparisons = scene.comparisons()?;
    let priors = vec![Prior::NONE; scene.solved().parameters().free().len()];
    let posed = Posed::new(scene, &comparisons, priors, weight);
    let adjoints = answers.at(&fit.theta, || {
        listener.say("solving for the sensors");
        let of = |(case, comparison): (&Case, &Comparison<'_>)| Adjoint::new(case, comparison, &fit.theta);
        scene.cases.iter().zip(&comparisons).map(of).collect()
    })?;
    let work = listener.work("screening effects", candidates.len());
    let screened = |candidate: Candidate| {
        let changes: Vec<Option<Arc<Change>>> = scene.cases.iter().map(|c| scene.change(c, &candidate)).collect();
        let columns = steps(&candidate)
            .into_iter()
            .filter(|(values, _)| scene.tells_of(&candidate) && is_slope(&candidate, values))
            .filter_map(|(values, one_sided)| {
                let delta = column(&posed, fit, &adjoints, &changes, &values)?;
                Some(Column { delta, one_sided, values })
            })
            .collect();
        work.step();
        Screened { candidate, columns }
    };
    Ok(candidates.into_par_iter().map(screened).collect())
}

/// Whether a step is one that a slope needs: the small one, or one of a grid.
fn is_slope(candidate: &Candidate, values: &[f64]) -> bool {
    let parameters = &candidate.parameters;
    let is_small = |(p, v): (&retune::effect::NewParameter, &f64)| {
        (v - p.neutral).abs() <= 1.5 * SMALL_STEP * (p.typical - p.neutral).abs()
    };
    parameters.iter().any(|p| !p.grid.is_empty()) || parameters.iter().zip(values).all(is_small)
}

/// Δr of a change of these sizes, to first order; `None` where it is none of the elements or leaves no number.
fn column(
    posed: &Posed<'_>,
    fit: &Fit,
    adjoints: &[Adjoint],
    changes: &[Option<Arc<Change>>],
    values: &[f64],
) -> Option<DVector<f64>> {
    let moves: Vec<Moved> = adjoints
        .iter()
        .zip(changes)
        .map(|(adjoint, change)| adjoint.moved(change.as_ref()?, values))
        .collect::<Option<_>>()?;
    let largest = moves.iter().map(|m| m.largest).fold(0.0, f64::max);
    if !largest.is_finite() {
        return None;
    }
    let share = if largest > MOVED { MOVED / largest } else { 1.0 };
    let predictions: Vec<Box<Prediction>> =
        adjoints.iter().zip(&moves).map(|(adjoint, moved)| Box::new(adjoint.at(moved, share))).collect();
    let r = posed.rows_of(&fit.theta, &predictions).ok()?;
    let cut = fit.rows.measured + fit.rows.targets;
    let mut delta = DVector::zeros(fit.r.len());
    for i in 0..cut {
        // A target that is met is not a datum; how far an effect may push it is decided by the refit.
        let inactive = i >= fit.rows.measured && fit.r[i] == 0.0;
        delta[i] = if inactive { 0.0 } else { (r[i] - fit.r[i]) / share };
    }
    delta.iter().all(|v| v.is_finite()).then_some(delta)
}

/// What a change does to the modes.
struct Moved {
    /// Relative change of the frequency of each paired mode.
    frequencies: Vec<f64>,
    /// Change of its shape at the sensors.
    shapes: Vec<DVector<f64>>,
    /// Change of its damping ratio by dashpots, without what the change of the shape brings.
    ratios: Vec<f64>,
    /// The largest of all, relative.
    largest: f64,
    /// Rᵀ ΔM R of the six rigid motions.
    mass: Option<SymMatrix>,
    /// Changes of static readings and functions, as those of sensors on nodes that stay where they are.
    answers: Option<LoadAnswers>,
}

/// A sensor that stands on a node and moves with it.
struct Mounted {
    sensor: usize,
    node: usize,
    direction: [f64; 3],
    /// The rotations of the node, on the rows of the model.
    rotations: [Vec<(usize, f64)>; 3],
}

impl Mounted {
    fn new(model: &Model, sensor: usize, of: &Sensor) -> Option<Self> {
        let Place::Node { node, position: None } = &of.place else { return None };
        let dofs = model.dof_map();
        let node = dofs.node(node).filter(|_| !of.is_rotation)?;
        let rotations = [Dof::Rx, Dof::Ry, Dof::Rz].map(|dof| dofs.express(node, dof).to_vec());
        Some(Self { sensor, node, direction: of.direction, rotations })
    }
}

impl Adjoint {
    fn new(case: &Case, comparison: &Comparison<'_>, theta: &[f64]) -> Result<Self, DiagnosisError> {
        let failed = |e: ModelError| DiagnosisError::from(CorrelationError::Model(e.to_string()));
        let prediction = comparison.predict(theta)?;
        let model = &*case.model;
        let (all, theta) = (theta, theta[..model.parameters().len()].to_vec());
        let system = model.assemble_sparse(&theta).map_err(failed)?;
        let own;
        let (shapes, plan) = match &case.stand_in {
            Some(stand_in) => (stand_in.expanded(&prediction.modes.shapes), stand_in.plan()),
            None => {
                let node: Vec<usize> = model.dof_map().rows().iter().map(|r| r.0).collect();
                own = SparsePlan::new(&system.stiffness, &system.mass, &node).map_err(|e| singular(&e))?;
                (prediction.modes.shapes.clone(), &own)
            }
        };
        let n_modes = case.test.modes.len();
        let paired: Vec<usize> = (0..n_modes).filter_map(|m| prediction.partner(m)).collect();
        let rows = observation_rows(model, &case.test.sensors)?;
        // Across all modes that are known; the same for every mode.
        let mut forces: DMatrix<f64> = DMatrix::zeros(shapes.nrows(), rows.len());
        for (s, row) in rows.iter().enumerate() {
            for &(i, factor) in row {
                forces[(i, s)] += factor;
            }
        }
        let read = tall_tr_mul(&shapes, &forces);
        let m_shapes = system.mass.mul(&shapes);
        tall_take(&mut forces, &m_shapes, &read);
        let pencil = IndefinitePencil::new(plan, &system.stiffness, &system.mass);
        let known = Across { pencil, shapes: &shapes, m_shapes, forces, read };
        let solve = |&elastic: &usize| known.answers(&prediction, elastic);
        let answers = paired.par_iter().map(solve).collect::<Result<Vec<_>, _>>()?;
        let first = prediction.modes.n_rigid;
        let mode = |&a: &usize| (a, prediction.modes.lambda[first + a], shapes.column(first + a).into_owned());
        let modes = paired.iter().map(mode).collect();
        let is_weighed = !case.test.mass_properties.is_empty() || model.targets() != Targets::default();
        let mass = (is_weighed && prediction.mass_properties.is_some()).then(|| model.rigid_mass(&theta));
        let mass = mass.transpose().map_err(failed)?;
        let n_elastic = prediction.frequencies_hz.len();
        let ratios = if comparison.is_damped() {
            (0..n_elastic).map(|elastic| prediction.ratio_by_dashpots(elastic)).collect()
        } else {
            Vec::new()
        };
        let mounted = case.test.sensors.iter().enumerate().filter_map(|(i, s)| Mounted::new(model, i, s)).collect();
        let answering = case.stand_in.clone().and_then(|s| Some((Answering::new(comparison, all, &prediction)?, s)));
        Ok(Self { prediction, modes, answers, ratios, theta, mass, mounted, answering })
    }

    /// What a change of these sizes does, to first order.
    fn moved(&self, change: &Change, sizes: &[f64]) -> Option<Moved> {
        let local = Local(change.at(&self.theta, sizes).ok()?);
        let carried = self.carried(change, sizes);
        let (mut frequencies, mut shapes, mut largest) = (Vec::new(), Vec::new(), 0.0_f64);
        for ((elastic, lambda, phi), answers) in self.modes.iter().zip(&self.answers) {
            let (force, growth) = local.force(*lambda, phi)?;
            let slope: f64 = local.0.old_rows().iter().zip(force.iter()).map(|(&row, f)| phi[row] * f).sum();
            let now = self.prediction.at_sensors.column(*elastic);
            let mut shape = now * (-0.5 * growth);
            for (&row, f) in local.0.old_rows().iter().zip(force.iter()) {
                shape.axpy(-f, &answers.column(row), 1.0);
            }
            for (sensor, terms) in &carried {
                shape[*sensor] += terms.iter().map(|&(row, factor)| factor * phi[row]).sum::<f64>();
            }
            let relative = 0.5 * slope / lambda;
            let size = now.amax();
            largest = largest.max(relative.abs()).max(if size > 0.0 { shape.amax() / size } else { 0.0 });
            frequencies.push(relative);
            shapes.push(shape);
        }
        let mass = self.mass.as_ref().and_then(|_| change.rigid_mass(&self.theta, sizes).ok());
        let ratios = self.ratios_moved(change, sizes, &frequencies)?;
        let answers = match &self.answering {
            Some((answering, stand_in)) => {
                let (moved, share) = local.answers(answering, stand_in)?;
                largest = largest.max(share);
                Some(moved)
            }
            None => None,
        };
        Some(Moved { frequencies, shapes, ratios, largest, mass, answers })
    }

    /// φᵀΔCφ/2ω - ζ δω/ω of the paired modes.
    ///
    /// * `frequencies` - δω/ω
    fn ratios_moved(&self, change: &Change, sizes: &[f64], frequencies: &[f64]) -> Option<Vec<f64>> {
        if self.ratios.is_empty() || self.modes.is_empty() {
            return Some(Vec::new());
        }
        let shapes: Vec<DVector<f64>> = self.modes.iter().map(|(_, _, phi)| phi.clone()).collect();
        let work = change.damping_of(&self.theta, sizes, &DMatrix::from_columns(&shapes)).ok()?;
        let of = |((elastic, lambda, _), (work, moved)): (&(usize, f64, _), (f64, &f64))| {
            work / (2.0 * lambda.sqrt()) - self.ratios[*elastic] * moved
        };
        Some(self.modes.iter().zip(work.into_iter().zip(frequencies)).map(of).collect())
    }

    /// What sensors read more of the modes, as sums over the rows, as they stand on nodes that a change moves:
    ///
    /// ```text
    /// d · (θ × a),    a: from where the dofs of the node are to where it is
    /// ```
    fn carried(&self, change: &Change, sizes: &[f64]) -> Vec<(usize, Vec<(usize, f64)>)> {
        let mut carried = Vec::new();
        for (node, beside) in
            change.moved_nodes().filter_map(|n| Some((n, change.displacement(n, &self.theta, sizes)?[1])))
        {
            for mounted in self.mounted.iter().filter(|m| m.node == node) {
                // d · (θ × a) = θ · (a × d)
                let about = cross(beside, mounted.direction);
                let of = |(list, lever): (&Vec<(usize, f64)>, f64)| -> Vec<(usize, f64)> {
                    list.iter().map(|&(row, factor)| (row, lever * factor)).collect()
                };
                carried.push((mounted.sensor, mounted.rotations.iter().zip(about).flat_map(of).collect()));
            }
        }
        carried
    }

    /// The prediction with a share of what a change does.
    fn at(&self, moved: &Moved, share: f64) -> Prediction {
        let mut frequencies = self.prediction.frequencies_hz.clone();
        let mut at_sensors = self.prediction.at_sensors.clone();
        let mut ratios = self.ratios.clone();
        for (k, (elastic, ..)) in self.modes.iter().enumerate() {
            frequencies[*elastic] *= 1.0 + share * moved.frequencies[k];
            if let (Some(ratio), Some(more)) = (ratios.get_mut(*elastic), moved.ratios.get(k)) {
                *ratio += share * more;
            }
            let mut column = at_sensors.column_mut(*elastic);
            column.axpy(share, &moved.shapes[k], 1.0);
        }
        let mass = self.mass.as_ref().map(|base| {
            let mut all = base.clone();
            moved.mass.iter().for_each(|more| all.add_scaled(share, more));
            MassProperties::from_rigid_mass(&all)
        });
        let answers = self.answering.as_ref().zip(moved.answers.as_ref()).map(|((answering, _), moved)| {
            let mut all = answering.answers();
            all.responses.iter_mut().zip(&moved.responses).for_each(|(h, more)| *h += more * share);
            all.readings.iter_mut().zip(&moved.readings).for_each(|(r, more)| *r += more * share);
            all
        });
        self.prediction.moved(frequencies, at_sensors, ratios, mass, answers)
    }
}

fn singular(e: &LinalgError) -> DiagnosisError {
    CorrelationError::Model(e.to_string()).into()
}

/// What the solutions of all modes share.
struct Across<'a> {
    pencil: IndefinitePencil<'a>,
    /// The modes that are known, rigid ones first, and M times them.
    shapes: &'a DMatrix<f64>,
    m_shapes: DMatrix<f64>,
    /// Unit forces at the sensors across these modes, (n_dof x n_sensors), and what the sensors read of the modes.
    forces: DMatrix<f64>,
    read: DMatrix<f64>,
}

impl Across<'_> {
    /// zᵀ of one mode, (n_sensors x n_dof).
    fn answers(&self, prediction: &Prediction, elastic: usize) -> Result<DMatrix<f64>, DiagnosisError> {
        let Self { pencil, shapes, m_shapes, forces, read } = self;
        let modes = &prediction.modes;
        let own = modes.n_rigid + elastic;
        let lambda = modes.lambda[own];
        let sigma = lambda * (1.0 - BESIDE);
        let mut z = pencil.solve(-sigma, forces).map_err(|e| singular(&e))?;
        let along = tall_tr_mul(m_shapes, &z);
        tall_take(&mut z, shapes, &along);
        let cluster = prediction.clusters.iter().find(|c| c.contains(&elastic)).map_or(&[][..], Vec::as_slice);
        let is_turned = |j: usize| cluster.iter().any(|mode| modes.n_rigid + mode == j);
        for (j, phi) in shapes.column_iter().enumerate() {
            if j == own || is_turned(j) {
                continue;
            }
            let (gap, least) = (modes.lambda[j] - lambda, 2.0 * CLOSE * lambda);
            let gap = if gap.abs() < least { least.copysign(gap) } else { gap };
            z.ger(1.0 / gap, &phi, &read.row(j).transpose(), 1.0);
        }
        Ok(z.transpose())
    }
}

/// A change on the rows that it touches.
struct Local<'a>(ChangeAt<'a>);

impl Local<'_> {
    /// What it does to static readings and functions, and the largest share of one of them.
    fn answers(&self, answering: &Answering, stand_in: &StandIn) -> Option<(LoadAnswers, f64)> {
        let (size, old) = (self.0.rows().len(), self.0.old_rows());
        let rows: Vec<Vec<(usize, f64)>> = old.iter().map(|&row| vec![(row, 1.0)]).collect();
        let times = |x: &DMatrix<f64>| {
            let [stiffness, mass] = self.0.times(x);
            [stiffness, mass, self.0.damping_times(x)]
        };
        let moved = answering.moved(&stand_in.observed(&rows), size - old.len(), &times)?;
        let before = answering.answers();
        let of_functions = moved.responses.iter().zip(&before.responses).map(|(more, h)| more.norm() / h.norm());
        let of_readings = moved.readings.iter().zip(&before.readings).map(|(more, r)| (more / r).abs());
        let largest = of_functions.chain(of_readings).filter(|share| share.is_finite()).fold(0.0, f64::max);
        Some((moved, largest))
    }

    /// ΔK x and ΔM x.
    fn times(&self, x: &DVector<f64>) -> [DVector<f64>; 2] {
        let x = DMatrix::from_column_slice(x.len(), 1, x.as_slice());
        self.0.times(&x).map(|force| force.map_or_else(|| DVector::zeros(x.nrows()), |f| f.column(0).into_owned()))
    }

    /// (ΔK - λ ΔM) φ with new coordinates condensed, and φᵀ ΔM φ.
    fn force(&self, lambda: f64, phi: &DVector<f64>) -> Option<(DVector<f64>, f64)> {
        let (rows, old) = (self.0.rows(), self.0.old_rows().len());
        let size = rows.len();
        let mut motion = DVector::from_fn(size, |i, _| if i < old { phi[rows[i]] } else { 0.0 });
        let [mut k_phi, mut m_phi] = self.times(&motion);
        if size > old {
            let mut inner = DMatrix::zeros(size - old, size - old);
            for c in old..size {
                let unit = DVector::from_fn(size, |i, _| f64::from(u8::from(i == c)));
                let [k, m] = self.times(&unit);
                inner.set_column(c - old, &(k - m * lambda).rows(old, size - old));
            }
            let drive = (&k_phi - &m_phi * lambda).rows(old, size - old).into_owned();
            let answer = inner.lu().solve(&drive)?;
            motion.rows_mut(old, size - old).copy_from(&-answer);
            [k_phi, m_phi] = self.times(&motion);
        }
        let growth = motion.dot(&m_phi);
        Some(((k_phi - m_phi * lambda).rows(0, old).into_owned(), growth))
    }
}
