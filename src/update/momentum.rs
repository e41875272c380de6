//! Sensors against a model, without a fit: does the shape of every mode lie where the model's motions and the noise allow it?
//!
//! **Momentum.** An elastic shape φ of a free structure is orthogonal in M to its rigid-body motions, for momentum and angular momentum of a free
//! vibration vanish whatever the stiffness:
//!
//! ```text
//! Φ_rᵀ M φ = 0
//! ```
//! A measured shape y has no entries between the sensors, so it is expanded in the motions of the model, φ = Φ_r a + Φ_e b. With M-orthonormal modes
//! a is the momentum itself. The flexible part is the one of smallest dynamic residual: mode j of the model takes part in a measured mode at ω
//! with a prior standard deviation of
//!
//! ```text
//! A c_j,   c_j = min(1, 2 τ √(λ_j ω²) / |λ_j - ω²|)
//! y ~ N(0, V),   V = (k σ)² + A² Σ c_j² (S φ_j)(S φ_j)ᵀ + (ρ A)² S Φ_r Φ_rᵀ Sᵀ
//! ```
//! A is the amplitude of the shape, τ the error of the model's stiffness, k a factor on the stated noise, ρ² = (1 %)² + (τ/2)² what a suspension at
//! a tenth of the frequency and an error of the masses as large as that of the stiffness leave. τ and k are the likeliest of a grid, common to all shapes; nothing is fitted. A shape that is not of the structure
//! (likelier as noise of its own size) does not count.
//!
//! The momentum that the data require is a = (RᵀW⁻¹R)⁻¹RᵀW⁻¹y, R = S Φ_r, W = V without its last term, and χ² = aᵀ(cov a + ρ²A²)⁻¹a
//! has as many degrees of freedom as the sensors see rigid-body motions.
//!
//! **Which sensor.** A fault is an edit of the entries of all shapes at once: a sensor or a group of sensors on one body turned over, two
//! exchanged, one scaled, one that says nothing. The edit that raises the likelihood most, by more than the number of edits tried and shapes that
//! depend on each other allow, is named with the momentum before and after; others nearly as likely are named with it. The likelihood contains the
//! momentum, and the shapes of the model besides: so the search serves supported structures too, where no momentum is conserved.
//!
//! **The structure itself.** A mass, a spring or a body on a spring that the model lacks at a sensor's point acts on it as a force of unknown size in
//! each mode, and moves the shape by the model's receptance there, of which the modes that V already mixes give no more than they lack:
//!
//! ```text
//! h = Σ (1 - c_j²) S φ_j φ_j(k) / (λ_j - ω²) - S Φ_r Φ_r(k)ᵀ / ω²,   V + g² h hᵀ
//! ```
//! with g such that the largest entry of g h is three times the root mean square of the shape. It has one unknown in each mode, as a sensor that says
//! nothing has; but a fault is in one entry, and a force moves the neighbours too. Where it is nearly as likely as a fault, no sensor is accused.
//!
//! Sources: L. Meirovitch, Analytical Methods in Vibrations, 1967, section 5-9 (orthogonality to rigid-body modes); the prior over modes is the
//! first-order perturbation of modes by a change of stiffness (R. L. Fox, M. P. Kapoor, AIAA J. 6, 1968).

mod density;
mod words;

use self::density::{
    Density, ERRORS, FACTORS, Motions, NOTHING, Shape, WIDE, columns, densities, density, rigid_share, shape,
};
use crate::correlation::{CorrelationError, observation_matrix_at};
use crate::data::{Place, Sensor, TestMode};
use crate::identify::health::Finding;
use crate::linalg::{DMatrix, DVector};
use crate::modal::SolveOptions;
use crate::model::{Model, ParametricModel, solve_modes};
use std::collections::BTreeMap;

/// Odds that a mode is not of the structure.
const FOREIGN: f64 = 0.03;
/// Factor on log-likelihood ratios, for shapes whose errors depend on each other; see `identify::health`.
const TEMPER: f64 = 0.5;
/// Chance of a false alarm in one search.
const ALPHA: f64 = 0.01;
/// Log-likelihood by which another edit may fall short and still be named beside the best one: odds of 20.
const RIVAL: f64 = 3.0;
/// A gain within this factor of 1 is calibration and no fault.
const LEAST_GAIN: f64 = 1.3;
/// Level of the test of momentum.
const MOMENTUM_LEVEL: f64 = 1e-4;

/// The rigid-body momentum that a measured shape requires.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ShapeMomentum {
    /// Index of the test mode.
    pub test_mode: usize,
    /// Share of rigid-body motion in the expanded shape, |a|²/(|a|² + |b|²), as measured.
    pub share: f64,
    /// The same after the changes that were accepted.
    pub share_after: f64,
    /// The share that noise, errors of the model and a suspension make expect.
    pub expected_share: f64,
    /// χ² of the momentum, before anything was changed.
    pub chi_squared: f64,
    /// The same after the changes that were accepted.
    pub chi_squared_after: f64,
    /// Its degrees of freedom: rigid-body motions that the sensors see.
    pub degrees_of_freedom: usize,
}

/// What would put the entries of all shapes right.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(rename_all = "kebab-case", tag = "change")]
pub enum SensorChange {
    /// These sensors are turned over: one, or a group on one body.
    Turn {
        /// Their indices.
        sensors: Vec<usize>,
    },
    /// Two sensors are exchanged.
    Swap {
        /// Their indices.
        sensors: [usize; 2],
    },
    /// One sensor is multiplied.
    Scale {
        /// Its index.
        sensor: usize,
        /// By what.
        factor: f64,
    },
    /// One sensor reads nothing but noise.
    Dead {
        /// Its index.
        sensor: usize,
    },
    /// One sensor says nothing of the structure.
    Drop {
        /// Its index.
        sensor: usize,
    },
    /// No fault: the structure differs from the model where this sensor is.
    Structure {
        /// Its index.
        sensor: usize,
    },
}

impl SensorChange {
    /// Indices of the sensors that it is about.
    pub fn touches(&self) -> Vec<usize> {
        match self {
            Self::Turn { sensors } => sensors.clone(),
            Self::Swap { sensors } => sensors.to_vec(),
            Self::Scale { sensor, .. } | Self::Dead { sensor } | Self::Drop { sensor } | Self::Structure { sensor } => {
                vec![*sensor]
            }
        }
    }
}

/// The check of a test's sensors against a model.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct SensorCheck {
    /// Per shape that counts; empty for a supported structure.
    pub momentum: Vec<ShapeMomentum>,
    /// Accepted changes, each with its tempered log-likelihood ratio.
    pub changes: Vec<(SensorChange, f64)>,
    /// Indices of the test modes whose shapes fit nothing of the model.
    pub foreign: Vec<usize>,
    /// Indices of sensors whose wrong sign would not be seen.
    pub undecided: Vec<usize>,
    /// Probability of so much momentum by chance, before and after the changes.
    pub chance: [f64; 2],
    /// The same in words.
    #[serde(skip)]
    pub findings: Vec<Finding>,
}

impl SensorCheck {
    /// Indices of the sensors that the accepted changes accuse, ascending.
    pub fn contradicted(&self) -> Vec<usize> {
        let faults = self.changes.iter().filter(|(change, _)| !matches!(change, SensorChange::Structure { .. }));
        let mut out: Vec<usize> = faults.flat_map(|(change, _)| change.touches()).collect();
        out.sort_unstable();
        out.dedup();
        out
    }
}

/// Checks the sensors of a test against a model at θ.
///
/// * `modes` - by ascending frequency; those without a shape do not count
/// * `n_suspension` - how many of the lowest are rigid-body modes on the suspension, which have momentum and do not count
///
/// # Errors
/// A sensor without place in the model; a model without modes.
pub fn check_sensors_by_model(
    model: &dyn ParametricModel,
    theta: &[f64],
    sensors: &[Sensor],
    modes: &[TestMode],
    n_suspension: usize,
) -> Result<SensorCheck, CorrelationError> {
    let observed = observation_matrix_at(model, sensors, theta)?;
    check_observed(model, theta, &observed, sensors, modes, n_suspension)
}

/// The same with the observation matrix, (n_sensor x n_dof).
pub(super) fn check_observed(
    model: &dyn ParametricModel,
    theta: &[f64],
    observed: &DMatrix<f64>,
    sensors: &[Sensor],
    modes: &[TestMode],
    n_suspension: usize,
) -> Result<SensorCheck, CorrelationError> {
    let failed = |e: &dyn std::fmt::Display| CorrelationError::Model(e.to_string());
    let n_elastic = (3 * modes.len() + 20).min(model.dof_map().n_dof());
    let found = solve_modes(model, theta, SolveOptions { n_elastic, shift: None }).map_err(|e| failed(&e))?;
    let rigid = observed * found.shapes.columns(0, found.n_rigid);
    let elastic = observed * found.shapes.columns(found.n_rigid, found.len() - found.n_rigid);
    let lambda: Vec<f64> = found.elastic().map(|r| found.lambda[r]).collect();
    let mut shapes: Vec<Shape> =
        modes.iter().enumerate().skip(n_suspension).filter_map(|(k, m)| shape(k, m, &elastic, &lambda)).collect();
    let motions = Motions { rigid, elastic, lambda };
    for s in &mut shapes {
        s.densities = densities(s, &motions);
    }
    Ok(Check {
        sensors,
        modes,
        motions: &motions,
        groups: model.of_file().map_or_else(Vec::new, |m| groups(m, sensors)),
        shapes,
    }
    .run())
}

/// Sensors on one body, where it has two or more and not all of them: a chain or an element, its nodes included.
fn groups(model: &Model, sensors: &[Sensor]) -> Vec<Vec<usize>> {
    let entry = |name: &str| name.split('.').next().unwrap_or(name).to_string();
    let mut of_node: BTreeMap<usize, String> = BTreeMap::new();
    for e in model.elements() {
        for node in e.joined().iter() {
            of_node.entry(*node).or_insert_with(|| entry(&e.name));
        }
    }
    let mut bodies: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for (i, s) in sensors.iter().enumerate() {
        let body = match &s.place {
            Place::Element { element, .. } => Some(entry(element)),
            Place::Node { node, .. } => model.geometry().node(node).and_then(|n| of_node.get(&n).cloned()),
        };
        if let Some(body) = body {
            bodies.entry(body).or_default().push(i);
        }
    }
    let mut list: Vec<Vec<usize>> =
        bodies.into_values().filter(|g| g.len() >= 2 && 2 * g.len() <= sensors.len()).collect();
    list.sort();
    list.dedup();
    list
}

struct Check<'a> {
    sensors: &'a [Sensor],
    modes: &'a [TestMode],
    motions: &'a Motions,
    groups: Vec<Vec<usize>>,
    shapes: Vec<Shape>,
}

/// The quadratic forms of all shapes at one point of the grid.
struct State<'a> {
    density: Vec<&'a Density>,
    x: Vec<DVector<f64>>,
    form: Vec<f64>,
}

impl Check<'_> {
    fn run(mut self) -> SensorCheck {
        let n = self.sensors.len();
        let original: Vec<(DVector<f64>, DVector<f64>)> =
            self.shapes.iter().map(|s| (s.y.clone(), s.noise.clone())).collect();
        let n_edits = 5 * n + n * n.saturating_sub(1) / 2 + self.groups.len();
        let threshold = (n_edits.max(1) as f64 / ALPHA).ln();
        let mut changes: Vec<(SensorChange, f64)> = Vec::new();
        let mut rivals: Vec<Vec<SensorChange>> = Vec::new();
        let mut dropped: Vec<usize> = Vec::new();
        while !self.shapes.is_empty() && changes.len() < n.div_ceil(4) {
            let ranked = self.ranked(&dropped, threshold - TEMPER * RIVAL);
            let Some((_, evidence)) = ranked.first() else { break };
            if *evidence <= threshold {
                break;
            }
            // Nothing is accused where the structure may as well be what differs.
            let as_well = |(edit, e): &&(SensorChange, f64)| {
                matches!(edit, SensorChange::Structure { .. }) && *e > evidence - TEMPER * RIVAL
            };
            let (best, evidence) = ranked.iter().find(as_well).unwrap_or(&ranked[0]).clone();
            let own = best.touches();
            let near = ranked.iter().skip(1).take_while(|(_, e)| *e > evidence - TEMPER * RIVAL);
            let mut others: Vec<SensorChange> = Vec::new();
            for (edit, _) in near.filter(|(e, _)| e.touches().iter().all(|k| !own.contains(k))) {
                if others.iter().all(|o| o.touches() != edit.touches()) {
                    others.push(edit.clone());
                }
            }
            self.apply(&best, &mut dropped);
            changes.push((best, evidence));
            rivals.push(others);
        }
        let undecided = self.undecided(&dropped, threshold);
        let at = self.best_point();
        let is_foreign: Vec<bool> = self.shapes.iter().map(|s| Self::is_foreign(s, at)).collect();
        let foreign: Vec<usize> =
            self.shapes.iter().zip(&is_foreign).filter(|(_, f)| **f).map(|(s, _)| s.test_mode).collect();
        let mut momentum = Vec::new();
        for ((s, before), _) in self.shapes.iter().zip(&original).zip(&is_foreign).filter(|(_, f)| !**f) {
            momentum.extend(self.momentum(s, before, at));
        }
        let total = |of: fn(&ShapeMomentum) -> f64| {
            let dof: usize = momentum.iter().map(|m| m.degrees_of_freedom).sum();
            // Errors of the masses are the same in all shapes: half of the sum, as in the search.
            if dof == 0 { 1.0 } else { chance(TEMPER * momentum.iter().map(of).sum::<f64>(), dof) }
        };
        let chance = [total(|m| m.chi_squared), total(|m| m.chi_squared_after)];
        let mut check = SensorCheck { momentum, changes, foreign, undecided, chance, findings: Vec::new() };
        check.findings = self.findings(&check, &rivals, threshold);
        check
    }

    fn state(&self, point: usize) -> State<'_> {
        let density: Vec<&Density> = self.shapes.iter().map(|s| &s.densities[point]).collect();
        let x: Vec<DVector<f64>> = self.shapes.iter().zip(&density).map(|(s, d)| d.times_vector(&s.y)).collect();
        let form = self.shapes.iter().zip(&x).map(|(s, x)| s.y.dot(x)).collect();
        State { density, x, form }
    }

    /// ln of the mixture of the model's density and one that knows nothing.
    fn mixture(shape: &Shape, form: f64, log_det: f64) -> f64 {
        let of_model = (1.0 - FOREIGN).ln() - 0.5 * (form + log_det);
        let of_none = FOREIGN.ln() + shape.of_none();
        let top = of_model.max(of_none);
        top + ((of_model - top).exp() + (of_none - top).exp()).ln()
    }

    fn is_foreign(shape: &Shape, point: usize) -> bool {
        let d = &shape.densities[point];
        let form = shape.y.dot(&d.times_vector(&shape.y));
        FOREIGN.ln() + shape.of_none() > (1.0 - FOREIGN).ln() - 0.5 * (form + d.log_det)
    }

    fn total(&self, state: &State<'_>, change: impl Fn(usize) -> (f64, f64)) -> f64 {
        (0..self.shapes.len())
            .map(|m| {
                let (form, log_det) = change(m);
                Self::mixture(&self.shapes[m], state.form[m] + form, state.density[m].log_det + log_det)
            })
            .sum()
    }

    fn best_point(&self) -> usize {
        let value = |p: usize| self.total(&self.state(p), |_| (0.0, 0.0));
        (0..ERRORS.len() * FACTORS.len()).max_by(|a, b| value(*a).total_cmp(&value(*b))).unwrap_or(0)
    }

    /// All edits by their tempered log-likelihood ratio, best first; exchanges only where that may exceed `least`.
    ///
    /// Exchanges are as many as pairs of sensors. The log-likelihood of a shape is no steeper than that of the model alone, so an exchange
    /// raises it by no more than half of what it takes off the quadratic forms that it lowers, and a bound of that is had from norms: most are
    /// left out by it.
    fn ranked(&self, dropped: &[usize], least: f64) -> Vec<(SensorChange, f64)> {
        let n = self.sensors.len();
        let m = self.shapes.len();
        let states: Vec<State<'_>> = (0..ERRORS.len() * FACTORS.len()).map(|point| self.state(point)).collect();
        let totals: Vec<f64> = states.iter().map(|state| self.total(state, |_| (0.0, 0.0))).collect();
        let now = totals.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut best: BTreeMap<usize, (SensorChange, f64)> = BTreeMap::new();
        let mut note = |at: usize, edit: SensorChange, value: f64| match best.get_mut(&at) {
            Some(known) if known.1 >= value => {}
            Some(known) => *known = (edit, value),
            None => drop(best.insert(at, (edit, value))),
        };
        let all: Vec<usize> = (0..n).collect();
        let mut forces: Vec<DMatrix<f64>> = Vec::new();
        for (point, (state, total)) in states.iter().zip(&totals).enumerate() {
            // The points of one error follow each other.
            if point % FACTORS.len() == 0 {
                forces = self.shapes.iter().map(|s| s.forces(&all, point / FACTORS.len(), self.motions)).collect();
            }
            let of_forces: Vec<(Vec<f64>, DVector<f64>)> =
                (0..m).map(|m| (state.density[m].forms(&forces[m]), forces[m].tr_mul(&state.x[m]))).collect();
            let y = |m: usize, k: usize| self.shapes[m].y[k];
            let v = |m: usize, i: usize, j: usize| state.density[m].at(i, j);
            let mut at = 0;
            for k in (0..n).filter(|k| !dropped.contains(k)) {
                let scaled = |m: usize, s: f64| {
                    let d = (s - 1.0) * y(m, k);
                    2.0 * d * state.x[m][k] + d * d * v(m, k, k)
                };
                note(5 * k, SensorChange::Turn { sensors: vec![k] }, self.total(state, |m| (scaled(m, -1.0), 0.0)));
                let (mut slope, mut curve) = (0.0, 0.0);
                for m in 0..m {
                    slope += y(m, k) * state.x[m][k];
                    curve += y(m, k).powi(2) * v(m, k, k);
                }
                let factor = if curve > 0.0 { 1.0 - slope / curve } else { 1.0 };
                let is_gain = factor.abs() > 1e-3 && !(1.0 / LEAST_GAIN..LEAST_GAIN).contains(&factor.abs());
                if is_gain {
                    // The entries are those of a density stretched by 1/s; s itself is estimated.
                    let value = self.total(state, |m| (scaled(m, factor), 0.0)) + m as f64 * factor.abs().ln()
                        - 0.5 * ((m * n).max(1) as f64).ln();
                    note(5 * k + 1, SensorChange::Scale { sensor: k, factor }, value);
                }
                let free = |m: usize| {
                    let wide = (WIDE * self.shapes[m].rms).powi(2);
                    let own = v(m, k, k);
                    (-state.x[m][k].powi(2) * wide / (1.0 + wide * own), (1.0 + wide * own).ln())
                };
                note(5 * k + 2, SensorChange::Drop { sensor: k }, self.total(state, free));
                // Noise about zero in its place: the others alone, and the entry by its own noise.
                let factor = FACTORS[point % FACTORS.len()];
                let dead = |m: usize| {
                    let (own, noise) = (v(m, k, k), factor * self.shapes[m].noise[k]);
                    ((y(m, k) / noise).powi(2) - state.x[m][k].powi(2) / own, own.ln() + 2.0 * noise.ln())
                };
                note(5 * k + 3, SensorChange::Dead { sensor: k }, self.total(state, dead));
                let force = |m: usize| {
                    let (own, along) = (of_forces[m].0[k], of_forces[m].1[k]);
                    (-along.powi(2) / (1.0 + own), own.ln_1p())
                };
                note(5 * k + 4, SensorChange::Structure { sensor: k }, self.total(state, force));
            }
            at += 5 * n;
            for k in 0..n {
                for l in 0..k {
                    let form = |m: usize, between: f64| {
                        let d = y(m, l) - y(m, k);
                        2.0 * d * (state.x[m][k] - state.x[m][l]) + d * d * between
                    };
                    let most = |m: usize| (-0.5 * form(m, state.density[m].least_between(k, l))).max(0.0);
                    let change = |m: usize| (form(m, v(m, k, k) + v(m, l, l) - 2.0 * v(m, k, l)), 0.0);
                    let may_be_best = TEMPER * (total + (0..m).map(most).sum::<f64>() - now) > least;
                    if may_be_best && !dropped.contains(&k) && !dropped.contains(&l) {
                        note(at, SensorChange::Swap { sensors: [l, k] }, self.total(state, change));
                    }
                    at += 1;
                }
            }
            for group in &self.groups {
                let change = |m: usize| {
                    let slope: f64 = group.iter().map(|&i| y(m, i) * state.x[m][i]).sum();
                    (4.0 * (state.density[m].form_of(&self.shapes[m].y, group) - slope), 0.0)
                };
                note(at, SensorChange::Turn { sensors: group.clone() }, self.total(state, change));
                at += 1;
            }
        }
        let mut ranked: Vec<(SensorChange, f64)> =
            best.into_values().map(|(e, value)| (e, TEMPER * (value - now))).filter(|e| e.1.is_finite()).collect();
        ranked.sort_by(|a, b| b.1.total_cmp(&a.1));
        ranked
    }

    fn apply(&mut self, edit: &SensorChange, dropped: &mut Vec<usize>) {
        for s in &mut self.shapes {
            match edit {
                SensorChange::Turn { sensors } => sensors.iter().for_each(|&k| s.y[k] = -s.y[k]),
                SensorChange::Swap { sensors: [k, l] } => s.y.swap_rows(*k, *l),
                SensorChange::Scale { sensor, factor } => s.y[*sensor] *= factor,
                SensorChange::Dead { sensor } | SensorChange::Drop { sensor } => {
                    s.y[*sensor] = 0.0;
                    s.noise[*sensor] = NOTHING * s.rms;
                    s.densities = densities(s, self.motions);
                }
                SensorChange::Structure { sensor } => {
                    s.forces.push(*sensor);
                    s.densities = densities(s, self.motions);
                }
            }
        }
        if let SensorChange::Dead { sensor } | SensorChange::Drop { sensor } | SensorChange::Structure { sensor } = edit
        {
            dropped.push(*sensor);
        }
    }

    /// Sensors whose wrong sign would not be seen.
    fn undecided(&self, dropped: &[usize], threshold: f64) -> Vec<usize> {
        let n = self.sensors.len();
        if self.shapes.is_empty() {
            return (0..n).collect();
        }
        let (mut now, mut turned) = (f64::NEG_INFINITY, vec![f64::NEG_INFINITY; n]);
        for point in 0..ERRORS.len() * FACTORS.len() {
            let state = self.state(point);
            now = now.max(self.total(&state, |_| (0.0, 0.0)));
            for (k, value) in turned.iter_mut().enumerate() {
                let change = |m: usize| {
                    let d = -2.0 * self.shapes[m].y[k];
                    (2.0 * d * state.x[m][k] + d * d * state.density[m].own(k), 0.0)
                };
                *value = value.max(self.total(&state, change));
            }
        }
        (0..n).filter(|k| !dropped.contains(k) && TEMPER * (now - turned[*k]) <= threshold).collect()
    }

    /// The momentum of a shape, before (entries and noise) and after the changes, with the noise and the errors of point `at`.
    fn momentum(&self, s: &Shape, before: &(DVector<f64>, DVector<f64>), at: usize) -> Option<ShapeMomentum> {
        if self.motions.rigid.ncols() == 0 {
            return None;
        }
        let (share, factor) = (&s.shares[at / FACTORS.len()], FACTORS[at % FACTORS.len()]);
        let columns = columns(s, share, &self.motions.elastic, None);
        let allowed = (rigid_share(ERRORS[at / FACTORS.len()]) * s.amplitude).powi(2);
        // χ², its degrees of freedom, the share of rigid-body motion and its expectation.
        let seen = |y: &DVector<f64>, noise: &DVector<f64>| {
            let density = density(noise, factor, &columns);
            let weighted = density.times(&self.motions.rigid);
            let svd = self.motions.rigid.tr_mul(&weighted).svd(true, false);
            let u = svd.u?;
            let largest = svd.singular_values.max();
            let right = weighted.tr_mul(y);
            let (mut chi_squared, mut dof, mut size, mut variance) = (0.0, 0, 0.0, 0.0);
            let mut motion = DVector::zeros(self.motions.rigid.ncols());
            for j in (0..svd.singular_values.len()).filter(|&j| svd.singular_values[j] > 1e-9 * largest) {
                let value = u.column(j).dot(&right) / svd.singular_values[j];
                let own = 1.0 / svd.singular_values[j] + allowed;
                chi_squared += value * value / own;
                size += value * value;
                variance += own;
                dof += 1;
                motion += u.column(j) * value;
            }
            let flexible = columns.tr_mul(&density.times_vector(&(y - &self.motions.rigid * motion)));
            let b: f64 = (0..flexible.len()).map(|j| (flexible[j] * share[j] * s.amplitude).powi(2)).sum();
            Some((chi_squared, dof, size / (size + b), variance / (variance + b)))
        };
        let (chi_squared, _, share_before, expected_share) = seen(&before.0, &before.1)?;
        let (chi_squared_after, degrees_of_freedom, share_after, _) = seen(&s.y, &s.noise)?;
        Some(ShapeMomentum {
            test_mode: s.test_mode,
            share: share_before,
            share_after,
            expected_share,
            chi_squared,
            chi_squared_after,
            degrees_of_freedom,
        })
    }
}

/// Chance that χ² of so many degrees of freedom is exceeded.
fn chance(chi_squared: f64, dof: usize) -> f64 {
    use statrs::distribution::{ChiSquared, ContinuousCDF};
    ChiSquared::new(dof as f64).map_or(1.0, |d| d.sf(chi_squared))
}

#[cfg(test)]
mod tests;
