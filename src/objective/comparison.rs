//! A model and a test made comparable: sensors as rows, real test shapes, which modes to compute, and what is predicted of them.

mod sensor_rows;

use super::EvalError;
use super::close_modes::{Closeness, DOUBLE, Measured, clusters, seen, turn};
use super::damped::Damped;
use super::followed::Followed;
use super::prediction::{Prediction, PredictionDerivative};
use super::real_shapes::real_shapes;
use super::recent::Recent;
use super::responses::FrfRows;
use super::spaces::{spaces, turn_space};
use super::starting_point::starting_point;
use super::static_loads::loads;
use crate::correlation::{
    CorrelationError, ModeList, PairedModes, PairingOptions, Plan, hide_unseen, mac_matrix, observation_matrix,
    pair_alike_modes, varying_sensors,
};
use crate::data::{Standing, TestData, TestMode, family_of_label};
use crate::linalg::DMatrix;
use crate::modal::{ModeDerivative, Modes};
use crate::model::{MOST_DENSE_DOFS, Matrices, ModalSolver, ModelError, ParametricModel, family, symmetry_index};
use crate::once::Once;
use std::borrow::Cow;
use std::sync::Arc;

/// A model and a test, made comparable: sensors as rows, real test shapes, the modes to compute.
#[derive(Debug)]
pub struct Comparison<'a> {
    model: &'a dyn ParametricModel,
    test: &'a TestData,
    sensors: DMatrix<f64>,
    /// Sensors whose rows depend on θ.
    varying: Vec<usize>,
    solver: Arc<ModalSolver>,
    n_elastic: usize,
    /// Real test shapes as columns, NaN where not measured; a mode without a shape is all NaN.
    shapes: DMatrix<f64>,
    /// Reciprocals of their standard deviations; 1 of a shape that has none.
    weights: DMatrix<f64>,
    frequencies: Vec<f64>,
    families: Vec<Option<String>>,
    /// Test modes that are one space.
    spaces: Vec<Vec<usize>>,
    pairing: PairingOptions,
    /// What is settled about the test modes.
    plans: Vec<Plan>,
    /// Loads of the static tests as columns, (n_dof x n_tests).
    loads: DMatrix<f64>,
    /// Whether the model has dashpots.
    has_dashpots: bool,
    responses: Option<FrfRows>,
    /// What modes of the model are followed by.
    followed: Followed,
    recent: Recent,
}

impl<'a> Comparison<'a> {
    /// Makes a model and a test comparable.
    ///
    /// Errors: a sensor sits where the model has nothing; the model has no modes at its estimates.
    pub fn new(
        model: &'a dyn ParametricModel,
        test: &'a TestData,
        pairing: PairingOptions,
    ) -> Result<Self, CorrelationError> {
        Self::sharing(model, test, pairing, None)
    }

    /// The same with the solver of a comparison of a like model, if it [serves](ModalSolver::serves) this one too.
    pub fn sharing(
        model: &'a dyn ParametricModel,
        test: &'a TestData,
        pairing: PairingOptions,
        solver: Option<Arc<ModalSolver>>,
    ) -> Result<Self, CorrelationError> {
        let sensors = observation_matrix(model, &test.sensors)?;
        let varying = varying_sensors(model, &test.sensors, &starting_point(model));
        Self::observed(model, test, pairing, solver, (sensors, varying))
    }

    /// The same model with another test of the same sensors.
    pub(crate) fn with_test<'b>(&self, test: &'b TestData) -> Result<Comparison<'b>, CorrelationError>
    where
        'a: 'b,
    {
        let observed = (self.sensors.clone(), self.varying.clone());
        Comparison::observed(self.model, test, self.pairing, Some(self.solver.clone()), observed)
    }

    /// * `sensors` - the observation matrix, and the sensors whose rows depend on θ
    fn observed(
        model: &'a dyn ParametricModel,
        test: &'a TestData,
        pairing: PairingOptions,
        solver: Option<Arc<ModalSolver>>,
        (sensors, varying): (DMatrix<f64>, Vec<usize>),
    ) -> Result<Self, CorrelationError> {
        let failed = |e: ModelError| CorrelationError::Model(e.to_string());
        let start = starting_point(model);
        // Twice the measured modes and some more: partners may sit higher, and unmeasured modes lie between.
        let n_elastic = 2 * test.modes.len() + 4;
        let (solver, has_dashpots) = match solver.filter(|s| s.serves(model)) {
            Some(solver) => {
                let system = model.assemble_sparse(&start).map_err(failed)?;
                (solver, system.damping.is_some())
            }
            None => {
                let solver = ModalSolver::new(model, &start, n_elastic).map_err(failed)?;
                let has_dashpots = solver.is_damped();
                (Arc::new(solver), has_dashpots)
            }
        };
        let mut shapes = real_shapes(test);
        // What is aside turns no mode of the model to itself and is compared with none.
        let aside = test.modes.iter().enumerate().filter(|(_, m)| m.standing.is_aside());
        let aside: Vec<usize> = aside.map(|(j, _)| j).collect();
        for &j in &aside {
            shapes.column_mut(j).fill(f64::NAN);
        }
        let frequencies: Vec<f64> = test.modes.iter().map(|m| m.frequency_hz.value).collect();
        let families = test.modes.iter().map(family_of).collect();
        let plans = test.modes.iter().map(plan_of).collect();
        let responses = FrfRows::new(model, test)?;
        let n_dof = model.dof_map().n_dof();
        if responses.is_some() && n_dof > MOST_DENSE_DOFS {
            return Err(CorrelationError::Model(format!(
                "a fit to frequency responses needs dense matrices of at most {MOST_DENSE_DOFS} dofs, and the model has {n_dof}: subdivide less, or leave them out of the test file"
            )));
        }
        let loads = loads(model, test, &solver)?;
        Ok(Self {
            model,
            test,
            sensors,
            varying,
            solver,
            n_elastic,
            weights: weights(test, &shapes),
            shapes,
            frequencies,
            families,
            spaces: spaces(test),
            pairing,
            plans,
            loads,
            has_dashpots,
            responses,
            followed: Followed::new(model, test),
            recent: Recent::new(n_dof),
        })
    }

    /// The model.
    pub fn model(&self) -> &'a dyn ParametricModel {
        self.model
    }

    /// The test.
    pub fn test(&self) -> &'a TestData {
        self.test
    }

    /// The observation matrix, (n_sensor x n_dof); rows that depend on θ in the middle of the bounds.
    pub fn sensors(&self) -> &DMatrix<f64> {
        &self.sensors
    }

    /// Real test shapes as columns, NaN where not measured.
    pub fn shapes(&self) -> &DMatrix<f64> {
        &self.shapes
    }

    /// MAC with the shapes of all test modes, those that take part in nothing too: rows elastic modes, columns test modes.
    pub fn mac_of_all(&self, p: &Prediction) -> DMatrix<f64> {
        mac_with(&p.at_sensors, &real_shapes(self.test))
    }

    /// Whether any test mode has a shape.
    pub fn has_shapes(&self) -> bool {
        self.test.modes.iter().any(|m| m.shape.is_some())
    }

    /// Frequencies of the test modes, Hz.
    pub(super) fn frequencies(&self) -> &[f64] {
        &self.frequencies
    }

    /// Symmetry of the test modes, as far as their labels tell it.
    pub fn families(&self) -> &[Option<String>] {
        &self.families
    }

    /// What is settled about the test modes before they are paired.
    pub fn plans(&self) -> &[Plan] {
        &self.plans
    }

    /// Whether a test mode takes part in nothing: it is foreign, or left out.
    pub fn is_aside(&self, test_mode: usize) -> bool {
        self.plans[test_mode] == Plan::Aside
    }

    /// Loads of the static tests as columns, (n_dof x n_tests).
    pub fn loads(&self) -> &DMatrix<f64> {
        &self.loads
    }

    /// Whether the model has damping, so that it predicts ratios.
    pub fn is_damped(&self) -> bool {
        self.has_dashpots || self.model.modal_damping().is_some()
    }

    /// Whether it has dashpots, which may couple modes.
    pub(super) fn has_dashpots(&self) -> bool {
        self.has_dashpots
    }

    /// The frequency responses that a fit uses, when there are any.
    pub(super) fn responses(&self) -> Option<&FrfRows> {
        self.responses.as_ref()
    }

    /// What solves the model, for comparisons of like models.
    pub fn solver(&self) -> &Arc<ModalSolver> {
        &self.solver
    }

    /// The modes of the model that are followed: the test mode, whether nothing else tells its partner, and (M φ)ᵀ on the rows of the model.
    pub fn followed_modes(&self) -> Vec<(usize, bool, Vec<f64>)> {
        self.followed.list()
    }

    /// Number of elastic modes that a prediction has, at most.
    pub fn n_elastic(&self) -> usize {
        self.n_elastic
    }

    /// Sensors whose rows depend on θ.
    pub fn varying_sensors(&self) -> &[usize] {
        &self.varying
    }

    /// What modes of the model are followed by.
    pub(super) fn followed(&self) -> &Followed {
        &self.followed
    }

    /// How much every elastic mode of a prediction is taken for the partner of every test mode, in [0, 1], (n_elastic x n_test): the MAC, and
    /// where a mode is followed how far it continues what is followed.
    pub(super) fn likeness(&self, p: &Prediction) -> DMatrix<f64> {
        self.followed.likeness(&p.mac, &p.modes).unwrap_or_else(|| p.mac.clone())
    }

    /// K, M, C and the modes at θ.
    pub fn solve(&self, theta: &[f64]) -> Result<(Matrices, Modes), EvalError> {
        let solved = self.solver.solve(self.model, theta, self.n_elastic);
        solved.map_err(|e| EvalError::Unsolvable { reason: e.to_string() })
    }

    /// [`Self::predict`] at a θ of which another comparison of the same model has [solved](Self::solve) the modes.
    pub fn predict_solved(&self, theta: &[f64], solved: &(Matrices, Modes)) -> Result<(), EvalError> {
        self.recent.get_or_make(theta, || self.predict_of(theta, solved.0.clone(), solved.1.clone())).map(|_| ())
    }

    /// How modes are paired.
    pub fn pairing(&self) -> &PairingOptions {
        &self.pairing
    }

    /// The prediction at θ; the last ones are remembered, since a search asks for the cost of a point and then for its derivatives.
    pub fn predict(&self, theta: &[f64]) -> Result<Arc<Prediction>, EvalError> {
        self.recent.get_or_make(theta, || self.predict_anew(theta))
    }

    /// The same, found anew and not remembered: for one that is kept, so that the matrices of a large model are there once.
    pub fn predict_anew(&self, theta: &[f64]) -> Result<Prediction, EvalError> {
        let (matrices, modes) = self.solve(theta)?;
        self.predict_of(theta, matrices, modes)
    }

    fn predict_of(&self, theta: &[f64], matrices: Matrices, mut modes: Modes) -> Result<Prediction, EvalError> {
        let elastic = modes.elastic();
        let undamped: Vec<f64> = elastic.clone().map(|i| modes.frequency_hz(i)).collect();
        let mut damped = Damped::new(&matrices, &modes);
        let sensors = self.sensors_at(theta)?;
        let read = |modes: &Modes| &*sensors * modes.shapes.columns(elastic.start, elastic.len());
        let listed = |modes: &Modes, damped: Option<&Damped>| {
            let (mut frequencies_hz, mut at_sensors) = (undamped.clone(), read(modes));
            damped.inspect(|damped| damped.put(&sensors, &mut frequencies_hz, &mut at_sensors));
            hide_unseen(&mut at_sensors);
            let mac = mac_with(&at_sensors, &self.shapes);
            (frequencies_hz, at_sensors, mac)
        };
        let mut families = self.families_of(&modes);
        let mut clusters = clusters(&undamped, self.closeness(), |a, b| families[a] == families[b]);
        if self.has_shapes() && !clusters.is_empty() {
            let at_sensors = read(&modes);
            clusters = seen(clusters, &at_sensors);
            for cluster in &clusters {
                turn(&mut modes, cluster, &at_sensors, self.measured(None));
            }
            families = self.families_of(&modes);
        }
        if let Some(damped) = &mut damped {
            damped.leave(&clusters);
        }
        let (mut frequencies_hz, mut at_sensors, mut mac) = listed(&modes, damped.as_ref());
        let mut pairs = self.pair(&mac, &modes, &frequencies_hz, &families);
        let mut turns = Vec::new();
        for space in &self.spaces {
            let partner = |&m: &usize| pairs.pairs.iter().find(|p| p.experimental == m).map(|p| p.analytical);
            let mut partners: Vec<usize> = space.iter().filter_map(partner).collect();
            // What is close enough to be one space in any case stays with it.
            let is_shared = |cluster: &Vec<usize>| cluster.iter().any(|k| partners.contains(k));
            let shared: Vec<usize> = clusters.iter().filter(|c| is_shared(c)).flatten().copied().collect();
            partners.extend(shared);
            partners.sort_unstable();
            partners.dedup();
            let measured = self.measured(Some(space));
            let Some(turn) = turn_space(&mut modes, partners, &at_sensors, measured) else { continue };
            clusters.retain(|c| !c.iter().any(|k| turn.cluster.contains(k)));
            clusters.push(turn.cluster.clone());
            turns.push(turn);
        }
        if !turns.is_empty() {
            families = self.families_of(&modes);
            if let Some(damped) = &mut damped {
                damped.leave(&clusters);
            }
            (frequencies_hz, at_sensors, mac) = listed(&modes, damped.as_ref());
            pairs = self.pair(&mac, &modes, &frequencies_hz, &families);
        }
        let mass_properties =
            self.model.mass_properties(theta).map_err(|e| EvalError::Unsolvable { reason: e.to_string() })?;
        let sensors = match sensors {
            Cow::Borrowed(_) => None,
            Cow::Owned(sensors) => Some(sensors),
        };
        Ok(Prediction {
            matrices,
            modes,
            frequencies_hz,
            at_sensors,
            sensors,
            families,
            clusters,
            turns,
            mac,
            pairs,
            mass_properties,
            damped,
            ratios: None,
            responses: Once::new(),
            readings: None,
        })
    }

    /// Pairs of elastic modes with test modes.
    fn pair(
        &self,
        mac: &DMatrix<f64>,
        modes: &Modes,
        frequencies_hz: &[f64],
        families: &[Option<String>],
    ) -> PairedModes {
        let likeness = self.followed.likeness(mac, modes);
        pair_alike_modes(
            mac,
            likeness.as_ref().unwrap_or(mac),
            &ModeList { frequencies_hz, labels: &[], families },
            &ModeList { frequencies_hz: &self.frequencies, labels: &[], families: &self.families },
            &self.pairing,
            &self.plans,
        )
    }

    /// The test shapes, or some of them, to which those of the model are turned.
    pub(super) fn measured<'b>(&'b self, only: Option<&'b [usize]>) -> Measured<'b> {
        Measured { shapes: &self.shapes, weights: &self.weights, only }
    }

    /// Whether modes of the test are one space, as it says.
    pub(super) fn has_spaces(&self) -> bool {
        !self.spaces.is_empty()
    }

    /// Which modes of the model are turned to the test.
    pub(super) fn closeness(&self) -> Closeness {
        Closeness::new(&self.frequencies, self.has_shapes())
    }

    /// The symmetry of every elastic mode.
    fn families_of(&self, modes: &Modes) -> Vec<Option<String>> {
        let of = |mode: usize| {
            let entry = |row| modes.shapes[(row, mode)];
            let index = match (self.model.mirror(), self.model.stand_in()) {
                (Some(mirror), _) => Some(symmetry_index(mirror, entry)),
                (None, Some(stand_in)) => stand_in.symmetry_index(entry),
                (None, None) => None,
            };
            index.and_then(family).map(str::to_string)
        };
        modes.elastic().map(of).collect()
    }

    /// Derivatives of the paired modes of a prediction with respect to the parameters `free`.
    pub fn differentiate(
        &self,
        theta: &[f64],
        prediction: &Prediction,
        free: &[usize],
    ) -> Result<PredictionDerivative, EvalError> {
        let paired: Vec<usize> = prediction.pairs.pairs.iter().map(|p| p.analytical).collect();
        let derivative = self.differentiate_modes(theta, prediction, free, &paired)?;
        match paired.iter().find(|&&mode| derivative.modes[mode].is_none()) {
            Some(mode) => Err(EvalError::Unsolvable {
                reason: format!("mode {} is double and has no shape derivative", mode + 1),
            }),
            None => Ok(derivative),
        }
    }

    /// Derivatives of some elastic modes of a prediction; none for a double one.
    pub(super) fn differentiate_modes(
        &self,
        theta: &[f64],
        prediction: &Prediction,
        free: &[usize],
        wanted: &[usize],
    ) -> Result<PredictionDerivative, EvalError> {
        let failed = |e: ModelError| EvalError::Unsolvable { reason: e.to_string() };
        let of_matrices = prediction.matrices.derivatives(self.model, theta, free).map_err(failed)?;
        let of_modes = self.derivatives_of_modes(prediction, &of_matrices, wanted).map_err(failed)?;
        let sensors = self.sensors_at(theta)?;
        let slopes = if self.varying.is_empty() { Vec::new() } else { self.slopes_of_rows(theta, free)? };
        let mut modes = vec![None; prediction.frequencies_hz.len()];
        for (&mode, d) in wanted.iter().zip(of_modes) {
            let lambda = prediction.modes.lambda[prediction.modes.n_rigid + mode];
            let Some(d) = d else { continue };
            // f = √λ / 2π, so ∂f = ∂λ f / 2λ.
            let f = prediction.frequencies_hz[mode];
            let mut at_sensors = &*sensors * &d.shape;
            let phi = prediction.modes.shapes.column(prediction.modes.n_rigid + mode);
            for (j, slope) in slopes.iter().enumerate() {
                let own = slope * phi;
                self.varying.iter().zip(own.iter()).for_each(|(&i, v)| at_sensors[(i, j)] += v);
            }
            let undamped = (d.lambda * (f / (2.0 * lambda)), at_sensors);
            let damped = prediction.damped.as_ref();
            modes[mode] = Some(
                damped
                    .and_then(|c| c.beside(mode, &sensors, &of_matrices, (&d.shape, &undamped.1)))
                    .unwrap_or(undamped),
            );
        }
        Ok(PredictionDerivative { modes })
    }

    /// Derivatives of some elastic modes, without what dashpots couple; `None` for a double one.
    ///
    /// * `slopes` - derivatives of the matrices
    pub(super) fn derivatives_of_modes(
        &self,
        prediction: &Prediction,
        slopes: &[Matrices],
        modes: &[usize],
    ) -> Result<Vec<Option<ModeDerivative>>, ModelError> {
        let p = prediction;
        let of = |elastic: &[usize]| -> Vec<usize> { elastic.iter().map(|i| p.modes.n_rigid + i).collect() };
        let gap = |a: usize, b: usize| (p.frequencies_hz[a] - p.frequencies_hz[b]).abs();
        // Modes of different symmetry may cross, and a double one may lie outside the band: beside its twin each has a derivative.
        let twin = |mode: usize| {
            let others = (0..p.frequencies_hz.len()).filter(|&k| k != mode);
            others.min_by(|&a, &b| gap(a, mode).total_cmp(&gap(b, mode)))
        };
        let beside = |mode: usize, twin: usize| (of(&[mode, twin]), 0);
        let place = |mode: usize| {
            let own = |cluster: &Vec<usize>| Some((of(cluster), cluster.iter().position(|&k| k == mode)?));
            let double = || twin(mode).filter(|&t| gap(t, mode) < DOUBLE * p.frequencies_hz[mode]);
            p.clusters.iter().find_map(own).or_else(|| double().map(|t| beside(mode, t)))
        };
        let places: Vec<Option<(Vec<usize>, usize)>> = modes.iter().map(|&mode| place(mode)).collect();
        let alone: Vec<usize> = modes.iter().zip(&places).filter(|(_, p)| p.is_none()).map(|(&mode, _)| mode).collect();
        let together: Vec<(Vec<usize>, usize)> = places.iter().flatten().cloned().collect();
        let mut alone = self.solver.differentiate(self.model, &p.matrices, slopes, &p.modes, &of(&alone))?.into_iter();
        let in_clusters = |of: &[(Vec<usize>, usize)]| {
            self.solver.differentiate_in_clusters(self.model, &p.matrices, slopes, &p.modes, of)
        };
        let mut together = in_clusters(&together)?.into_iter();
        let next = |place: &Option<_>| if place.is_some() { together.next() } else { alone.next() };
        let mut all: Vec<Option<ModeDerivative>> = places.iter().map(next).map(Option::flatten).collect();
        // Those of a space have their slopes as they were before they were turned.
        for turn in &p.turns {
            let before = turn.undone(&p.modes);
            let each: Vec<(Vec<usize>, usize)> = (0..turn.cluster.len()).map(|k| (of(&turn.cluster), k)).collect();
            let found = self.solver.differentiate_in_clusters(self.model, &p.matrices, slopes, &before, &each)?;
            let Some(found) = found.into_iter().collect::<Option<Vec<_>>>() else { continue };
            for (&mode, derivative) in turn.cluster.iter().zip(turn.derivatives(&found)) {
                if let Some(k) = modes.iter().position(|&m| m == mode) {
                    all[k] = Some(derivative);
                }
            }
        }
        for (&mode, derivative) in modes.iter().zip(&mut all).filter(|(_, d)| d.is_none()) {
            let Some(twin) = twin(mode) else { continue };
            *derivative = in_clusters(&[beside(mode, twin)])?.pop().flatten();
        }
        Ok(all)
    }
}

/// Reciprocals of the standard deviations of test shapes.
fn weights(test: &TestData, shapes: &DMatrix<f64>) -> DMatrix<f64> {
    let sd = |i: usize, j: usize| test.modes[j].shape_sd.as_ref().map_or(1.0, |sd| sd[i]);
    DMatrix::from_fn(shapes.nrows(), shapes.ncols(), |i, j| sd(i, j).recip())
}

/// The symmetry of a test mode: as its label tells, unless the pairing has found that it is wrong.
fn family_of(mode: &TestMode) -> Option<String> {
    match &mode.standing {
        Standing::Found { family: Some(family), .. } => Some(family.clone()),
        _ => mode.label.as_deref().and_then(family_of_label).map(str::to_string),
    }
}

/// What the standing of a test mode settles.
fn plan_of(mode: &TestMode) -> Plan {
    match &mode.standing {
        standing if standing.is_aside() => Plan::Aside,
        Standing::Found { reference: Some(_), .. } => Plan::Free,
        Standing::Found { model_mode, is_fixed: true, .. } => Plan::Fixed(*model_mode),
        Standing::Found { rank, .. } if mode.shape.is_none() => Plan::Ranked(*rank),
        _ => Plan::Free,
    }
}

/// MAC of shapes at the sensors with measured ones; zero where there is none.
fn mac_with(at_sensors: &DMatrix<f64>, measured: &DMatrix<f64>) -> DMatrix<f64> {
    mac_matrix(at_sensors, measured).map(|v| if v.is_nan() { 0.0 } else { v })
}
