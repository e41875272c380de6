//! A structure against its tests: the least-squares problem with its priors, its optimum, and what a screening needs of it.
//!
//! ```text
//! Φ(x) = ½ |w r(x)|² + ½ Σ ((x_j - c_j)/s_j)²,    H = JᵀJ of the same rows,    w = 1/√s2 on measured rows
//! ```
//!
//! Every free parameter has a [`Prior`].
//!
//! Several tests stand one after the other: their modes are one list, their sensors another, and a shape is not measured at the
//! sensors of other tests. The model of each is the same file in the configuration that was tested.
//!
//! The priors keep the problem regular where data cannot tell parameters apart, and they are what an evidence needs.

use super::changes::Changes;
use super::prior::Prior;
use super::work::Counters;
use crate::error::DiagnosisError;
use crate::thresholds::{STAND_IN_ERROR, WEAK_PRIOR};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use retune::correlation::{CorrelationError, observation_matrix, sensor_position};
use retune::data::{Joined, Sensor, TestData, joined};
use retune::effect::{Candidate, NewParameter, Patch, PatchError};
use retune::element::Dof;
use retune::fault::{Bench, PlacedFault, Tests};
use retune::linalg::{DMatrix, DVector};
use retune::model::spec::ModelSpec;
use retune::model::{MOST_DENSE_DOFS, ModalSolver, Model, ModelError, ParametricModel, ReducedOptions, StandIn};
use retune::objective::{Comparison, Scaling, is_damped, loads_of};
use retune::once::Once;
use retune::optim::Draw;
use retune::update::{HowToPair, as_given};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Models of more dofs are stood in for. At 120 and 130 dofs a diagnosis on stand-ins takes half the time of one on the model itself, at 300 a fortieth;
/// below, the digits of the model are worth more than the time.
const LARGE: usize = 100;

/// Estimated relative error of a frequency of a stand-in, at least: for exact data a basis would grow without end.
const LEAST_ERROR: f64 = 1e-7;

/// Values of functions that a search compares, at most, where fewer lines still tell of every mode.
const MOST_VALUES: usize = 5_000;

/// A test with the model in the configuration that was tested, and where its modes and sensors stand among those of all.
#[derive(Debug, Clone)]
pub(crate) struct Case {
    pub(crate) model: Arc<Model>,
    pub(crate) test: Arc<TestData>,
    pub(crate) first_mode: usize,
    pub(crate) sensors: Vec<usize>,
    /// What is solved in the place of a large model, with the changes that the scene has made to it.
    pub(crate) stand_in: Option<Arc<StandIn>>,
    /// What solves the model, once it has been compared.
    solver: Arc<Once<Arc<ModalSolver>>>,
    /// The same of the model that this one was made from: most changes leave the dofs as they are.
    like: Option<Arc<ModalSolver>>,
}

impl Case {
    fn new(model: Arc<Model>, test: Arc<TestData>, first_mode: usize, sensors: Vec<usize>) -> Self {
        Self { model, test, first_mode, sensors, stand_in: None, solver: Arc::default(), like: None }
    }

    /// The same test with another model.
    fn with_model(&self, model: Arc<Model>) -> Self {
        let like = self.solver.get().or(self.like.as_ref()).cloned();
        Self { like, ..Self::new(model, self.test.clone(), self.first_mode, self.sensors.clone()) }
    }

    /// The same test and model with a change of its stand-in.
    pub(super) fn with_stand_in(&self, stand_in: StandIn) -> Self {
        Self { stand_in: Some(Arc::new(stand_in)), ..self.with_model(self.model.clone()) }
    }

    /// What is solved: the model, or what stands in for it.
    pub(crate) fn solved(&self) -> &dyn ParametricModel {
        match &self.stand_in {
            Some(stand_in) => &**stand_in,
            None => &*self.model,
        }
    }

    /// The observation matrix of sensors on the rows of what is solved.
    ///
    /// # Errors
    /// A sensor without a place on the model.
    pub(crate) fn observe(&self, sensors: &[Sensor]) -> Result<DMatrix<f64>, CorrelationError> {
        observation_matrix(self.solved(), sensors)
    }

    /// A dof of a node of the file as a sum of rows of what is solved.
    pub(crate) fn rows_of(&self, node: &str, dof: Dof) -> Option<Vec<(usize, f64)>> {
        let dofs = self.solved().dofs_of_nodes();
        let rows = dofs.express(dofs.node(node)?, dof).to_vec();
        Some(match &self.stand_in {
            Some(stand_in) => stand_in.observed(&[rows]).row(0).iter().copied().enumerate().collect(),
            None => rows,
        })
    }

    /// Model and test made comparable, paired with open gates, by shapes where there are any.
    pub(crate) fn comparison(&self, how: &HowToPair) -> Result<Comparison<'_>, CorrelationError> {
        let known = self.solver.get().or(self.like.as_ref()).cloned();
        let rule = how.rule(&self.test);
        let made = Comparison::sharing(self.solved(), &self.test, rule, known)?;
        self.solver.get_or_find(|| made.solver().clone());
        Ok(made)
    }

    /// Numbers of its modes.
    pub(crate) fn modes(&self) -> std::ops::Range<usize> {
        self.first_mode..self.first_mode + self.test.modes.len()
    }
}

/// The effects that are screened for what made modes that look foreign, by their ids.
#[derive(Debug, Default)]
pub(crate) struct Sought {
    /// Those that make modes of such shapes at some size, with the share of the shape that they explain.
    pub(crate) shown: BTreeMap<String, f64>,
    /// Those of which that cannot be told.
    pub(crate) possible: BTreeSet<String>,
}

impl Sought {
    pub(crate) fn contains(&self, id: &str) -> bool {
        self.shown.contains_key(id) || self.possible.contains(id)
    }
}

/// A structure and its tests, with the sizes that effects have brought into the model.
#[derive(Debug, Clone)]
pub(crate) struct Scene {
    /// The model file with all its configurations.
    pub(crate) file: Arc<ModelSpec>,
    pub(crate) cases: Vec<Case>,
    /// The modes and sensors of all tests.
    pub(crate) test: Arc<TestData>,
    pub(crate) added: Vec<NewParameter>,
    /// Whether the model as it was given has damping: then ratios are compared, also with effects that bring none.
    pub(crate) is_damped: bool,
    /// How modes are paired.
    pub(crate) how: HowToPair,
    /// The effects that are screened; none for all.
    pub(super) only: Option<Arc<Sought>>,
    /// Sensors that the motions of the model contradict, whatever its stiffness.
    pub(super) contradicted: Arc<Vec<usize>>,
    /// Models of more dofs are stood in for.
    pub(super) large: usize,
    /// Changes that were made to stand-ins and not to the file.
    pub(super) patches: Vec<Patch>,
    /// The same, placed, where models are large.
    pub(super) changes: Arc<Changes>,
    /// Of this scene and all that are made from it.
    pub(crate) work: Arc<Counters>,
}

impl Scene {
    /// A model without any effect, and its tests, each in the configuration that it names; a model that has no configurations is
    /// taken as it is.
    ///
    /// Errors: no test; a configuration that cannot be built.
    pub(crate) fn new(model: &Model, tests: &[&TestData]) -> Result<Self, DiagnosisError> {
        let of = |test: &TestData| match configuration(model.spec(), test) {
            Some(_) => in_configuration(model.spec(), test, model),
            None => Ok(model.clone()),
        };
        let models = shared(tests, |t| configuration(model.spec(), t).map(str::to_string), |t| of(t))?;
        if models.is_empty() {
            return Err(DiagnosisError::NoData);
        }
        let is_damped = models.iter().any(|m| is_damped(&**m));
        let tests = tests.iter().map(|&t| Arc::new(with_telling_lines(t))).collect();
        Self::of(Arc::new(model.spec().clone()), models, tests, Vec::new(), is_damped).with_stand_ins(&[], &[])
    }

    fn of(
        file: Arc<ModelSpec>,
        models: Vec<Arc<Model>>,
        tests: Vec<Arc<TestData>>,
        added: Vec<NewParameter>,
        is_damped: bool,
    ) -> Self {
        let list: Vec<&TestData> = tests.iter().map(|t| &**t).collect();
        let Joined { test, first_mode, sensors } = joined(&list);
        let cases = models
            .into_iter()
            .zip(tests)
            .zip(first_mode.into_iter().zip(sensors))
            .map(|((model, test), (first_mode, sensors))| Case::new(model, test, first_mode, sensors))
            .collect();
        Self {
            file,
            cases,
            test: Arc::new(test),
            added,
            is_damped,
            how: HowToPair::default(),
            only: None,
            contradicted: Arc::default(),
            large: LARGE,
            patches: Vec::new(),
            changes: Arc::default(),
            work: Arc::default(),
        }
    }

    /// Dofs of the largest of its models.
    pub(crate) fn most_dofs(&self) -> usize {
        self.cases.iter().map(|c| c.model.dof_map().n_dof()).max().unwrap_or(0)
    }

    /// Whether matrices of one of its models are never held in full, and every stand-in takes seconds.
    pub(crate) fn is_huge(&self) -> bool {
        self.most_dofs() > MOST_DENSE_DOFS
    }

    /// Whether stand-ins are solved.
    pub(crate) fn is_large(&self) -> bool {
        self.cases.iter().any(|c| c.stand_in.is_some())
    }

    /// The same with stand-ins for models of more dofs than these.
    #[cfg(test)]
    pub(crate) fn large_from(mut self, dofs: usize) -> Result<Self, DiagnosisError> {
        self.large = dofs;
        self.cases.iter_mut().for_each(|case| *case = case.with_model(case.model.clone()));
        self.with_stand_ins(&[], &[])
    }

    /// With stand-ins for models that are large.
    ///
    /// * `before` - cases of models that these were made from, in the same order, with theirs
    /// * `sizes` - values of parameters near which they are to be right
    fn with_stand_ins(mut self, before: &[Case], sizes: &[(String, f64)]) -> Result<Self, DiagnosisError> {
        let largest = self.most_dofs();
        if largest <= self.large {
            return Ok(self);
        }
        // A tenth of what is told of the frequencies, where that is less.
        let told = self.test.modes.iter().map(|m| m.frequency_hz.sd / m.frequency_hz.value);
        let tolerance = told.map(|sd| 0.1 * sd).fold(STAND_IN_ERROR, f64::min).max(LEAST_ERROR);
        let failed = |e: ModelError| CorrelationError::Model(e.to_string());
        let n_modes = 2 * self.cases.iter().map(|c| c.test.modes.len()).max().unwrap_or(0) + 4;
        let mut made: Vec<StandIn> = Vec::new();
        let of_cases: Vec<_> = self.cases.iter().map(|c| (c.model.clone(), c.test.clone())).collect();
        for (k, case) in self.cases.iter_mut().enumerate() {
            let known = made.iter().find(|s| Arc::ptr_eq(s.model(), &case.model)).cloned();
            let stand_in = match known {
                Some(known) => known,
                None => {
                    let options = ReducedOptions { n_modes, tolerance, ..ReducedOptions::default() };
                    let like = before.get(k).and_then(|c| c.stand_in.as_deref());
                    let tests = of_cases.iter().filter(|(model, _)| Arc::ptr_eq(model, &case.model));
                    let loads = tests.map(|(model, test)| loads_of(&**model, test)).collect::<Result<Vec<_>, _>>()?;
                    let loads: Vec<_> = loads.iter().flat_map(|l| l.column_iter()).collect();
                    let loads = if loads.is_empty() { None } else { Some(DMatrix::from_columns(&loads)) };
                    StandIn::reduced(&case.model, options, like, sizes, loads.as_ref()).map_err(failed)?
                }
            };
            made.push(stand_in.clone());
            *case = case.with_stand_in(stand_in);
        }
        Ok(self)
    }

    /// The same tests and another file, with the sizes that effects have brought into it.
    ///
    /// Errors: the file is not a model in one of the configurations.
    pub(crate) fn with_file(&self, file: ModelSpec, added: Vec<NewParameter>) -> Result<Self, DiagnosisError> {
        self.with_file_near(file, added, &[])
    }

    /// The same; what stands in for a large model is made for sizes near these alone.
    pub(super) fn with_file_near(
        &self,
        file: ModelSpec,
        added: Vec<NewParameter>,
        sizes: &[(String, f64)],
    ) -> Result<Self, DiagnosisError> {
        let tests: Vec<&TestData> = self.cases.iter().map(|c| &*c.test).collect();
        let key = |t: &TestData| configuration(&file, t).map(str::to_string);
        let beside = |t: &TestData| self.cases.iter().find(|c| key(&c.test) == key(t)).unwrap_or(&self.cases[0]);
        let models = shared(&tests, key, |t| in_configuration(&file, t, &beside(t).model))?;
        let cases = self.cases.iter().zip(models).map(|(case, model)| case.with_model(model)).collect();
        let (patches, changes) = (Vec::new(), Arc::default());
        Self { file: Arc::new(file), cases, added, patches, changes, ..self.clone() }.with_stand_ins(&self.cases, sizes)
    }

    /// The same with other tests of the same modes.
    fn with_tests(&self, tests: Vec<Arc<TestData>>) -> Self {
        let models = self.cases.iter().map(|c| c.model.clone()).collect();
        let mut scene = Self::of(self.file.clone(), models, tests, self.added.clone(), self.is_damped);
        for (new, case) in scene.cases.iter_mut().zip(&self.cases) {
            (new.solver, new.like) = (case.solver.clone(), case.like.clone());
            new.stand_in.clone_from(&case.stand_in);
        }
        (scene.how, scene.large) = (self.how, self.large);
        (scene.only, scene.contradicted) = (self.only.clone(), self.contradicted.clone());
        (scene.patches, scene.changes) = (self.patches.clone(), self.changes.clone());
        scene.work = self.work.clone();
        scene
    }

    /// The same with other standings of the modes.
    pub(crate) fn with_modes(&self, tests: Vec<TestData>) -> Self {
        self.with_tests(tests.into_iter().map(Arc::new).collect())
    }

    /// The same where these effects alone are screened; none for all.
    pub(crate) fn with_only(mut self, sought: Option<Sought>) -> Self {
        self.only = sought.map(Arc::new);
        self
    }

    /// The effects that are screened; none for all.
    pub(crate) fn only(&self) -> Option<&Sought> {
        self.only.as_deref()
    }

    /// The same with the sensors of every test that the motions of the model contradict.
    pub(crate) fn with_contradicted(mut self, sensors: &[Vec<usize>]) -> Self {
        let of = |(case, own): (&Case, &Vec<usize>)| own.iter().map(|&s| case.sensors[s]).collect::<Vec<_>>();
        self.contradicted = Arc::new(self.cases.iter().zip(sensors).flat_map(of).collect());
        self
    }

    /// Names of the sensors that the motions of the model contradict.
    pub(crate) fn contradicted(&self) -> Vec<&str> {
        self.contradicted.iter().map(|&s| self.test.sensors[s].name.as_str()).collect()
    }

    /// The same with modes that stand as the user says, whatever was found.
    pub(crate) fn as_given(&self) -> Self {
        self.with_tests(self.cases.iter().map(|c| Arc::new(as_given(&c.test))).collect())
    }

    /// With a fault taken out of the data.
    ///
    /// * `number` - that of the fault
    pub(crate) fn corrected(&self, fault: &PlacedFault, number: f64) -> Self {
        let correct = |(k, case): (usize, &Case)| match fault.within(self, k) {
            Some(own) => Arc::new(own.taken_out_of(&case.test, number)),
            None => case.test.clone(),
        };
        self.with_tests(self.cases.iter().enumerate().map(correct).collect())
    }

    /// The tests, and where things stand in them.
    pub(crate) fn bench(&self) -> Bench<'_> {
        // Nodes stand at the same places in every configuration.
        let geometry = self.model().geometry();
        let nodes = geometry.names.iter().cloned().zip(geometry.positions.iter().copied());
        let nodes = nodes.take(self.model().spec().nodes.len()).collect();
        Bench { tests: self, positions: self.sensor_positions().ok(), nodes }
    }

    /// With factors on the standard deviations of every sensor's readings.
    pub(crate) fn weighed(&self, factor: &[f64]) -> Self {
        let weigh = |case: &Case| {
            let mut test = (*case.test).clone();
            for sd in test.modes.iter_mut().filter_map(|m| m.shape_sd.as_mut()) {
                sd.iter_mut().zip(&case.sensors).for_each(|(v, &s)| *v *= factor[s]);
            }
            Arc::new(test)
        };
        self.with_tests(self.cases.iter().map(weigh).collect())
    }

    /// The model of the first test, without the changes that were made to its stand-in.
    pub(crate) fn model(&self) -> &Model {
        &self.cases[0].model
    }

    /// What is solved in the first test: in all it has the same parameters.
    pub(crate) fn solved(&self) -> &dyn ParametricModel {
        self.cases[0].solved()
    }

    /// The first test that has a sensor.
    pub(crate) fn case_of_sensor(&self, sensor: usize) -> &Case {
        self.cases.iter().find(|c| c.sensors.contains(&sensor)).unwrap_or(&self.cases[0])
    }

    /// The configuration of the file in which a test was made.
    pub(crate) fn configuration<'a>(&self, case: &'a Case) -> Option<&'a str> {
        configuration(&self.file, &case.test)
    }

    /// Where the sensors sit, m.
    pub(crate) fn sensor_positions(&self) -> Result<Vec<[f64; 3]>, CorrelationError> {
        let at = |(s, sensor)| sensor_position(&*self.case_of_sensor(s).model, sensor);
        self.test.sensors.iter().enumerate().map(at).collect()
    }

    /// Models and tests made comparable, in the order of the tests.
    pub(crate) fn comparisons(&self) -> Result<Vec<Comparison<'_>>, DiagnosisError> {
        Ok(self.cases.iter().map(|c| c.comparison(&self.how)).collect::<Result<_, _>>()?)
    }

    /// Whether frequency responses enter a fit.
    pub(crate) fn has_functions(&self) -> bool {
        self.cases.iter().any(|c| c.test.frfs.is_some() && c.test.frf_fit.is_some())
    }

    /// Whether the data tell of an effect. One that damps and does nothing else is told by ratios and functions: what dashpots that couple modes make of
    /// their frequencies any other effect can do too. Without either it is read afterwards.
    pub(crate) fn tells_of(&self, candidate: &Candidate) -> bool {
        self.is_damped || self.has_functions() || !candidate.effect.damps()
    }

    /// The same tests without their frequency responses.
    pub(crate) fn without_functions(&self) -> Self {
        let mut scene = self.clone();
        for case in &mut scene.cases {
            case.test = Arc::new(case.test.without_functions());
        }
        scene
    }

    /// The estimates of the model, moved into their bounds, in the unit box.
    pub(crate) fn start(&self) -> DVector<f64> {
        Scaling::new(self.solved()).x(&retune::objective::starting_point(self.solved()))
    }

    /// The prior of each free parameter.
    pub(crate) fn priors(&self) -> Vec<Prior> {
        let parameters = self.solved().parameters();
        let centre = self.start();
        let free = parameters.free();
        free.iter()
            .enumerate()
            .map(|(k, &i)| {
                let p = parameters.get(i);
                let [lower, upper] = p.bounds.unwrap_or([0.0, 1.0]);
                let width = upper - lower;
                if let Some(new) = self.added.iter().find(|a| a.name == p.name) {
                    return Prior::of_size(new, [lower, upper]);
                }
                match p.prior_sd {
                    Some(sd) => Prior::gaussian((p.value - lower) / width, sd / width),
                    None => Prior::gaussian(centre[k], WEAK_PRIOR),
                }
            })
            .collect()
    }

    /// ln of the normalisers of the priors of sizes that an effect has brought, see [`Prior::ln_height`].
    pub(crate) fn ln_size_priors(&self, sizes: &[NewParameter]) -> f64 {
        let parameters = self.solved().parameters();
        let (free, priors) = (parameters.free(), self.priors());
        sizes
            .iter()
            .filter_map(|new| {
                let k = free.iter().position(|&i| parameters.get(i).name == new.name)?;
                let sides = if new.one_sided() { std::f64::consts::LN_2 } else { 0.0 };
                Some(priors[k].ln_height() + sides)
            })
            .sum()
    }
}

impl Tests for Scene {
    fn all(&self) -> &TestData {
        &self.test
    }

    fn count(&self) -> usize {
        self.cases.len()
    }

    fn test(&self, test: usize) -> &TestData {
        &self.cases[test].test
    }

    fn modes_of(&self, test: usize) -> std::ops::Range<usize> {
        self.cases[test].modes()
    }

    fn sensors_of(&self, test: usize) -> &[usize] {
        &self.cases[test].sensors
    }
}

/// A test with the lines of its functions that tell most: a search fits thousands of hypotheses to them.
fn with_telling_lines(test: &TestData) -> TestData {
    let (Some(set), Some(fit)) = (&test.frfs, &test.frf_fit) else { return test.clone() };
    TestData { frf_fit: Some(fit.with_telling_lines(set, &test.modes, MOST_VALUES)), ..test.clone() }
}

/// The configuration of a file in which a test was made.
pub(super) fn configuration<'a>(file: &ModelSpec, test: &'a TestData) -> Option<&'a str> {
    test.configuration.as_deref().filter(|_| !file.configurations.is_empty())
}

/// The model of a file in the configuration of a test.
///
/// * `beside` - a model that has most of its elements
pub(super) fn in_configuration(file: &ModelSpec, test: &TestData, beside: &Model) -> Result<Model, DiagnosisError> {
    let spec = match configuration(file, test) {
        Some(name) => file.configured(name).map_err(|p| PatchError::Refused(vec![p]))?,
        None => file.clone(),
    };
    Ok(Model::new_beside(spec, beside.registry(), beside).map_err(PatchError::Refused)?.0)
}

/// The models of tests, one for all that were made in the same configuration.
fn shared<E>(
    tests: &[&TestData],
    configuration: impl Fn(&TestData) -> Option<String>,
    model: impl Fn(&TestData) -> Result<Model, E>,
) -> Result<Vec<Arc<Model>>, E> {
    let mut made: Vec<(Option<String>, Arc<Model>)> = Vec::new();
    let mut out = Vec::with_capacity(tests.len());
    for test in tests {
        let key = configuration(test);
        if let Some((_, known)) = made.iter().find(|(k, _)| *k == key) {
            out.push(known.clone());
            continue;
        }
        let new = Arc::new(model(test)?);
        made.push((key, new.clone()));
        out.push(new);
    }
    Ok(out)
}

/// Points of the box around which a fit may start: drawn in the middle half, where models can usually be solved.
pub(crate) fn box_starts(scene: &Scene, count: usize, seed: u64) -> Vec<DVector<f64>> {
    let n = scene.start().len();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(u64::MAX);
    (0..count).map(|_| DVector::from_fn(n, |_, _| 0.25 + 0.5 * rng.unit())).collect()
}
