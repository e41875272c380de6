//! The model that a page computes with.
//!
//! [`StandIn`] has the model on a basis of rigid motions, modes and their derivatives within the bounds of the parameters, and the static shapes
//! under the forces of each hypothesis. Of a small model the basis is complete, and what the page computes differs from what this library
//! computes by rounding alone. Either way both are solved at random points of the sliders, and the largest differences go with the page.

mod fault;
mod rows;
mod several;

pub use several::{Tested, add_live, add_live_of_learning, live_tests};

use super::build::{Case, typical_damping};
use super::data::{
    Doubles, Floats, Live, LiveAccuracy, LiveHypothesis, LiveMatrix, LivePairing, LiveParameter, LivePlan,
    LiveSymmetry, LiveTerm, LiveTestMode, LiveVersion, Named,
};
use fault::TriedFault;
use rand::{RngExt, SeedableRng};
use retune::correlation::{PairBy, Plan, hide_unseen, mac_matrix, observation_matrix};
use retune::data::TestData;
use retune::effect::{Candidate, Context, Effects, Structure};
use retune::linalg::{DMatrix, symmetric_eigen};
use retune::modal::{Modes, SolveOptions};
use retune::model::{
    Additions, Basis, Change, Entry, Model, ModelError, Parameter, ParametricModel, ReducedOptions, StandIn,
    solve_modes,
};
use retune::objective::{Comparison, starting_point};
use retune::update::{HowToPair, UpdateError, compared, freed, paired_test};
use retune_diagnosis::{HypothesisResult, Kind, sensor_loads};
use rows::rows_of;
use std::ops::Range;
use std::sync::Arc;

/// Up to this many dofs the basis is complete.
const COMPLETE: usize = 90;
/// Models of more dofs are not reduced for a page: some fifty solutions of one of 15 000 dofs take 14 s, and they grow with its dofs.
const LARGEST: usize = 30_000;
/// Most dofs of the basis of a larger model, without the shapes of hypotheses.
const MOST: usize = 60;
/// Points at which the error of the basis of a larger model is looked at.
const CANDIDATES: usize = 40;
/// Largest estimated relative error of a frequency, of a model whose basis is to be complete and of a larger one.
const TOLERANCE: [f64; 2] = [1e-13, 1e-6];
/// Most effects with a switch, and most faults.
const HYPOTHESES: usize = 10;
const FAULTS: usize = 6;
/// Random points at which the basis is held against the model, of a small one and of a larger one; and for each hypothesis.
const POINTS: [usize; 3] = [24, 8, 3];
/// A hypothesis with which one of as many modes as the test has is off by more than this part of its frequency has no switch.
const USABLE: f64 = 0.01;
/// λ below this part of the shift is that of a rigid-body motion, as on the page (`web/src/live/model.ts`).
const RIGID: f64 = 1e-9;
/// A slider of a size reaches so many times as far as what is expected or estimated.
const REACH: f64 = 3.0;

/// Why a page cannot compute.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NotLive {
    /// Sensors move with the parameters in a way that one matrix does not hold.
    #[error("the rows of {n} sensors depend on the parameters, as of a sensor in an element with a flexible end")]
    MovingSensors {
        /// How many.
        n: usize,
    },
    /// There is nothing to move.
    #[error("the model has neither a parameter with bounds nor a hypothesis to switch on")]
    NothingMoves,
    /// Its reduction would take minutes.
    #[error(
        "the model has {n_dof} dofs, and a page computes with at most {LARGEST}: its reduction would take minutes; a coarser mesh of the same structure is live"
    )]
    TooLarge {
        /// Number of dofs.
        n_dof: usize,
    },
    /// The model.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The comparison.
    #[error(transparent)]
    Comparison(#[from] UpdateError),
    /// The sensors.
    #[error(transparent)]
    Sensors(#[from] retune::correlation::CorrelationError),
}

/// The model of a case as a page computes with it.
///
/// * `how` - how modes are paired
/// * `first` - an earlier version of the model, whose values the sliders mark
/// * `hypotheses` - of a diagnosis, the most probable first; the first ten effects and the first six faults of the test can be switched on
///
/// # Errors
/// The matrices are not polynomials of the parameters; sensors depend on them; nothing can be moved; the model has no modes.
pub fn live(
    case: Case<'_>,
    how: &HowToPair,
    first: Option<&Model>,
    hypotheses: &[HypothesisResult],
) -> Result<Live, NotLive> {
    live_with(case, how, first, (case.model, hypotheses))
}

/// [`live`] with hypotheses about places of another configuration of the model.
fn live_with(
    case: Case<'_>,
    how: &HowToPair,
    first: Option<&Model>,
    (places, hypotheses): (&Model, &[HypothesisResult]),
) -> Result<Live, NotLive> {
    let Case { model, test, assessment } = case;
    let theta = &assessment.theta;
    let n_dof = model.dof_map().n_dof();
    if n_dof > LARGEST {
        return Err(NotLive::TooLarge { n_dof });
    }
    let paired = freed(&paired_test(model, Some(theta), test, how)?.test);
    let comparison = compared(model, &paired, how)?;
    if !comparison.varying_sensors().is_empty() {
        return Err(NotLive::MovingSensors { n: comparison.varying_sensors().len() });
    }
    let shared = Arc::new(model.clone());
    let n_elastic = comparison.n_elastic();
    let is_small = n_dof <= COMPLETE;
    let n_modes = if is_small { n_dof } else { comparison.n_elastic() };
    let options = ReducedOptions {
        n_modes,
        tolerance: TOLERANCE[usize::from(!is_small)],
        most: if is_small { n_dof } else { MOST },
        // All modes at one θ span everything: nothing is left to look for elsewhere.
        n_candidates: if is_small { 0 } else { CANDIDATES },
        ..ReducedOptions::default()
    };
    let mut stand_in = StandIn::reduced(&shared, options, None, &[], None)?;
    let alone = stand_in.clone();
    let mut parameters: Vec<LiveParameter> =
        model.parameters().iter().zip(theta).map(|(p, value)| of_model(p, *value, first)).collect();
    let own = parameters.clone();
    let (tried, mut left_out) = tried(&shared, places, test, hypotheses)?;
    let mut switches = Vec::new();
    for (k, t) in tried.iter().enumerate() {
        let sizes: Vec<LiveParameter> = t.sizes.iter().enumerate().map(|(k, p)| t.slider(k, p)).collect();
        let points = random(&[own.clone(), sizes.clone()].concat(), POINTS[2], 1 + k as u64);
        let held = t.accuracy(&alone, &comparison, &points);
        let (accuracy, with) = match held.and_then(|a| Ok((a, stand_in.with(&t.change, &t.sizes, &t.typical)?))) {
            Ok((a, _)) if a.points == 0 => {
                let why = "the structure has no stable modes where its size was tried";
                left_out.push((t.result.id.clone(), why.into()));
                continue;
            }
            Ok((a, _)) if a.worst(comparison.test().modes.len()) > USABLE => {
                let off = 100.0 * a.worst(comparison.test().modes.len());
                left_out
                    .push((t.result.id.clone(), format!("on these coordinates its frequencies are off by {off:.2} %")));
                continue;
            }
            Ok(found) => found,
            Err(e) => {
                left_out.push((t.result.id.clone(), e.to_string()));
                continue;
            }
        };
        stand_in = with;
        switches.push(LiveHypothesis {
            id: t.result.id.clone(),
            kind: t.result.name.clone(),
            sizes: (parameters.len()..parameters.len() + sizes.len()).collect(),
            estimates: t.estimates(),
            probability: t.result.probability,
            alters: t.change.altered().collect(),
            accuracy,
            test: None,
        });
        parameters.extend(sizes);
    }
    let Some(affine) = stand_in.affine() else { return Err(ModelError::NotPolynomial.into()) };
    for result in hypotheses.iter().filter(|h| h.kind == Kind::Fault).take(FAULTS) {
        let switch = TriedFault::new(model, comparison.test(), result)
            .and_then(|t| Ok((t.edit(model, &stand_in, comparison.test())?, t)));
        match switch {
            Ok((edit, t)) => {
                let sizes = parameters.len()..parameters.len() + usize::from(t.number.is_some());
                switches.push(LiveHypothesis {
                    id: t.result.id.clone(),
                    kind: t.result.name.clone(),
                    sizes: sizes.clone().collect(),
                    estimates: sizes.map(|_| t.estimate).collect(),
                    probability: t.result.probability,
                    alters: Vec::new(),
                    // The model stays as it is.
                    accuracy: LiveAccuracy { points: 0, frequency: vec![0.0; n_elastic], mac: vec![0.0; n_elastic] },
                    test: Some(edit),
                });
                parameters.extend(t.number.iter().map(|p| of_model(p, p.value, None)));
            }
            Err(why) => left_out.push((result.id.clone(), why)),
        }
    }
    if switches.is_empty() && parameters.iter().all(|p| p.range[0] >= p.range[1]) {
        return Err(NotLive::NothingMoves);
    }
    let n = stand_in.dof_map().n_dof();
    let term = |powers: Vec<(usize, i32)>, basis: &Basis| {
        let of = |list: &[Entry]| (!list.is_empty()).then(|| packed(n, list));
        let (stiffness, mass) = (of(&basis.stiffness), of(&basis.mass));
        (stiffness.is_some() || mass.is_some()).then_some(LiveTerm { powers, stiffness, mass })
    };
    let terms = term(Vec::new(), &affine.constant)
        .into_iter()
        .chain(affine.parameters.iter().enumerate().filter_map(|(j, b)| term(vec![(j, 1)], b)))
        .chain(affine.products.iter().filter_map(|(m, b)| term(m.powers.clone(), b)))
        .collect();
    let sensors = stand_in.observed(&rows_of(&observation_matrix(model, &test.sensors)?));
    let points = random(&own, POINTS[usize::from(!is_small)], 0);
    let accuracy = compare(&alone, &comparison, &points)?;
    let left_out = left_out.into_iter().map(|(id, why)| Named::new(id, why)).collect();
    let shapes = stand_in.expanded(&DMatrix::identity(n, n));
    let (displacement, rotation) = nodal(model, &shapes);
    let of_modes: f64 = assessment.misfit_per_mode.iter().sum();
    Ok(Live {
        test_name: String::new(),
        configuration: None,
        structure: None,
        n,
        is_complete: alone.dof_map().n_dof() == n_dof,
        n_rigid: stand_in.n_rigid(),
        shift: stand_in.shift(),
        n_elastic: comparison.n_elastic(),
        versions: first.map(|m| version("first version", m, &parameters)).into_iter().collect(),
        parameters,
        hypotheses: switches,
        left_out,
        terms,
        sensors: by_rows(&sensors),
        symmetry: model.mirror().map(|mirror| symmetry(mirror, &shapes)),
        displacement,
        rotation,
        test: test_modes(&comparison, &stand_in),
        damping: typical_damping(test),
        pairing: pairing(&comparison),
        n_data: assessment.misfit.n_data,
        not_computed: (assessment.misfit.chi_squared - of_modes).max(0.0),
        accuracy,
    })
}

/// Lets the sliders be set to named versions of the model, the oldest first.
pub fn add_versions(live: &mut Live, versions: &[(&str, &Model)]) {
    live.versions = versions.iter().map(|(name, model)| version(name, model, &live.parameters)).collect();
}

fn version(name: &str, model: &Model, parameters: &[LiveParameter]) -> LiveVersion {
    let own = model.parameters();
    let value = |(k, p): (usize, &LiveParameter)| {
        let value = own.get(own.index_of(&p.name)?).value.clamp(p.range[0], p.range[1]);
        (value != p.value).then_some((k, value))
    };
    LiveVersion { name: name.into(), values: parameters.iter().enumerate().filter_map(value).collect() }
}

fn of_model(p: &Parameter, value: f64, first: Option<&Model>) -> LiveParameter {
    let before = first.and_then(|m| Some(m.parameters().get(m.parameters().index_of(&p.name)?).value));
    LiveParameter {
        name: p.name.clone(),
        unit: p.unit.clone(),
        unit_factor: p.unit_factor,
        value,
        initial: before.filter(|b| *b != value),
        // A value outside its bounds is within reach of its slider all the same.
        range: p.bounds.map_or([value; 2], |[low, high]| [low.min(value), high.max(value)]),
        description: p.description.clone(),
    }
}

/// A hypothesis as a change of the model.
struct Tried<'a> {
    result: &'a HypothesisResult,
    candidate: Candidate,
    change: Arc<Change>,
    sizes: Vec<Parameter>,
    typical: Vec<f64>,
}

impl Tried<'_> {
    /// Its sizes as the diagnosis has estimated them; as an engineer would expect them where it has not.
    fn estimates(&self) -> Vec<f64> {
        let of = |(p, typical): (&Parameter, &f64)| {
            let own = self.result.estimates.iter().find(|e| e.parameter == p.name);
            own.map_or(*typical, |e| e.value)
        };
        self.sizes.iter().zip(&self.typical).map(of).collect()
    }

    fn slider(&self, k: usize, p: &Parameter) -> LiveParameter {
        let (neutral, estimate) = (p.value, self.estimates()[k]);
        let reach = REACH * (self.typical[k] - neutral).abs().max((estimate - neutral).abs());
        let [low, high] = p.bounds.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        LiveParameter {
            name: p.name.clone(),
            unit: if p.unit == "1" { String::new() } else { p.unit.clone() },
            unit_factor: p.unit_factor,
            value: neutral,
            initial: None,
            range: [(neutral - reach).max(low), (neutral + reach).min(high)],
            description: p.description.clone(),
        }
    }

    /// How right the basis is with it alone; the points have its sizes last.
    fn accuracy(&self, alone: &StandIn, base: &Comparison<'_>, points: &[Vec<f64>]) -> Result<LiveAccuracy, NotLive> {
        let stand_in = alone.with(&self.change, &self.sizes, &self.typical)?;
        match self.candidate.build(alone.model(), alone.model().registry()) {
            Ok(patched) => {
                let whole = Comparison::new(&patched.model, base.test(), *base.pairing())?;
                compare(&stand_in, &whole, points)
            }
            Err(e) => Err(ModelError::External(e.to_string()).into()),
        }
    }
}

/// The hypotheses of a diagnosis that are changes of matrices, and why others are none.
type TriedAndNot<'a> = (Vec<Tried<'a>>, Vec<(String, String)>);

fn tried<'a>(
    model: &Arc<Model>,
    places: &Model,
    test: &TestData,
    hypotheses: &'a [HypothesisResult],
) -> Result<TriedAndNot<'a>, NotLive> {
    let context = Context { sensors: sensor_loads(places, &test.sensors)?, ..Context::default() };
    let structure = Structure::new(places, &context);
    let (mut found, mut left_out) = (Vec::new(), Vec::new());
    for result in hypotheses.iter().filter(|h| h.kind == Kind::Effect).take(HYPOTHESES) {
        match one(model, &structure, result) {
            Ok(tried) => found.push(tried),
            Err(why) => left_out.push((result.id.clone(), why)),
        }
    }
    Ok((found, left_out))
}

fn one<'a>(model: &Arc<Model>, structure: &Structure<'_>, result: &'a HypothesisResult) -> Result<Tried<'a>, String> {
    let candidate = Effects::builtin().candidate(structure, &result.id).map_err(|e| e.to_string())?;
    let mut longer = model.spec().clone();
    candidate.patch.add_to(&mut longer).map_err(|e| e.to_string())?;
    let additions = Additions::new(model, &longer, model.registry());
    let change = Arc::new(candidate.change(&additions).ok_or("it changes more than the matrices of elements")?);
    let (sizes, typical) = (candidate.sizes(), candidate.typical());
    if !change.is_polynomial(&sizes) {
        return Err("its matrices are not polynomials of its size".into());
    }
    let theta = starting_point(&**model);
    if !change.at(&theta, &typical).is_ok_and(|at| at.acts()) {
        return Err("it acts on damping alone, and the modes here are undamped".into());
    }
    Ok(Tried { result, candidate, change, sizes, typical })
}

/// The entries of a matrix as few numbers as they may be.
fn packed(n: usize, list: &[Entry]) -> LiveMatrix {
    let mut lower = vec![0.0; n * (n + 1) / 2];
    let mut whole = DMatrix::zeros(n, n);
    for e in list {
        let (row, column) = e.place();
        lower[row * (row + 1) / 2 + column] += e.value;
        whole[(row, column)] += e.value;
        if row != column {
            whole[(column, row)] += e.value;
        }
    }
    // Of an element or a mass few directions count; what is left out is rounding of the matrix itself.
    const ROUNDING: f64 = 1e-15;
    let Ok(eigen) = symmetric_eigen(&whole) else { return LiveMatrix::Lower(Doubles(lower)) };
    let least = ROUNDING * eigen.values.amax();
    let kept: Vec<usize> = (0..n).filter(|&k| eigen.values[k].abs() > least).collect();
    if kept.len() * (n + 1) >= lower.len() {
        return LiveMatrix::Lower(Doubles(lower));
    }
    // A coordinate that the matrix does not touch stays untouched to the last bit.
    let touched: Vec<bool> = (0..n).map(|i| whole.row(i).amax() > 0.0).collect();
    let mut sum = Vec::with_capacity(kept.len() * (n + 1));
    for k in kept {
        sum.push(eigen.values[k]);
        sum.extend((0..n).map(|i| if touched[i] { eigen.vectors[(i, k)] } else { 0.0 }));
    }
    LiveMatrix::Sum(Doubles(sum))
}

fn by_rows(a: &DMatrix<f64>) -> Doubles {
    Doubles(a.row_iter().flat_map(|row| row.iter().copied().collect::<Vec<_>>()).collect())
}

fn lower(a: &DMatrix<f64>) -> Doubles {
    Doubles((0..a.nrows()).flat_map(|i| (0..=i).map(move |j| (i, j))).map(|at| a[at]).collect())
}

fn symmetry(mirror: &[(usize, f64)], v: &DMatrix<f64>) -> LiveSymmetry {
    let image = DMatrix::from_fn(v.nrows(), v.ncols(), |row, c| mirror[row].1 * v[(mirror[row].0, c)]);
    let both = v.tr_mul(&image);
    LiveSymmetry { mirror: lower(&((&both + both.transpose()) * 0.5)), gram: lower(&v.tr_mul(v)) }
}

/// Above this many nodes beams are drawn straight between them, to keep the page small.
const LARGEST_WITH_ROTATIONS: usize = 500;

/// Motions of the nodes by coordinates.
fn nodal(model: &Model, v: &DMatrix<f64>) -> (Floats, Option<Floats>) {
    let dofs = model.dof_map();
    let all: Vec<DMatrix<f64>> = v.column_iter().map(|c| dofs.expand(&c.into_owned())).collect();
    let part = |from: usize| {
        Floats::from_f64(all.iter().flat_map(|a| {
            (0..a.nrows()).flat_map(move |node| (from..from + 3).map(move |d| (node, d))).map(|at| a[at])
        }))
    };
    (part(0), (dofs.n_nodes() <= LARGEST_WITH_ROTATIONS).then(|| part(3)))
}

fn test_modes(comparison: &Comparison<'_>, stand_in: &StandIn) -> Vec<LiveTestMode> {
    let test = comparison.test();
    let followed = comparison.followed_modes();
    let mode = |(i, m): (usize, &retune::data::TestMode)| {
        let own = followed.iter().find(|f| f.0 == i);
        let on_coordinates = |row: &[f64]| {
            let row = DMatrix::from_row_slice(1, row.len(), row);
            by_rows(&stand_in.observed(&rows_of(&row)))
        };
        LiveTestMode {
            label: m.label.clone().unwrap_or_else(|| format!("mode {}", i + 1)),
            frequency_hz: m.frequency_hz.value,
            frequency_sd: m.frequency_hz.sd,
            shape: Doubles(match m.shape {
                Some(_) => comparison.shapes().column(i).iter().copied().collect(),
                None => Vec::new(),
            }),
            damping: m.damping_ratio.map(|d| d.value),
            shape_sd: Doubles(m.shape_sd.iter().flat_map(|s| s.iter().copied()).collect()),
            family: comparison.families()[i].clone(),
            space: m.space.clone().filter(|_| !comparison.is_aside(i)),
            plan: match comparison.plans()[i] {
                Plan::Free => LivePlan::Free,
                Plan::Aside => LivePlan::Aside,
                Plan::Fixed(k) => LivePlan::Fixed(k),
                Plan::Ranked(k) => LivePlan::Ranked(k),
            },
            followed: own.map(|f| on_coordinates(&f.2)).unwrap_or_default(),
            followed_alone: own.is_some_and(|f| f.1),
        }
    };
    test.modes.iter().enumerate().map(mode).collect()
}

fn pairing(comparison: &Comparison<'_>) -> LivePairing {
    let p = comparison.pairing();
    let by = match p.by {
        PairBy::Mac => "mac",
        PairBy::NearMac => "near-mac",
        PairBy::Order => "order",
        PairBy::Label => "label",
    };
    LivePairing {
        by: by.into(),
        min_mac: p.min_mac,
        frequency_window: p.frequency_window.is_finite().then_some(p.frequency_window),
        same_family_only: p.same_family_only,
    }
}

/// Random points of some sliders.
fn random(sliders: &[LiveParameter], n: usize, stream: u64) -> Vec<Vec<f64>> {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(35);
    rng.set_stream(stream);
    let mut value = |p: &LiveParameter| p.range[0] + (p.range[1] - p.range[0]) * rng.random::<f64>();
    (0..n).map(|_| sliders.iter().map(&mut value).collect()).collect()
}

/// The largest differences between a model and what stands in for it, at those of some points where the model has modes.
fn compare(stand_in: &StandIn, comparison: &Comparison<'_>, points: &[Vec<f64>]) -> Result<LiveAccuracy, NotLive> {
    let on_basis =
        stand_in.observed(&rows_of(&observation_matrix(stand_in.model().as_ref(), &comparison.test().sensors)?));
    let n_elastic = comparison.n_elastic();
    let mut out = LiveAccuracy { points: 0, frequency: vec![0.0; n_elastic], mac: vec![0.0; n_elastic] };
    let shown = |modes: &Modes, elastic: Range<usize>, sensors: &DMatrix<f64>| {
        let hz: Vec<f64> = elastic.clone().map(|i| modes.frequency_hz(i)).collect();
        let mut at = sensors * modes.shapes.columns(elastic.start, elastic.len());
        hide_unseen(&mut at);
        (hz, mac_matrix(&at, comparison.shapes()))
    };
    let options = SolveOptions { n_elastic, shift: Some(stand_in.shift()) };
    for theta in points {
        // Where the structure is not stable there is nothing to hold against.
        let Ok((_, whole)) = comparison.solve(theta) else { continue };
        let few = solve_modes(stand_in, theta, options)?;
        // The page tells rigid-body motions by a λ of rounding.
        let is_rigid = |i: &usize| few.lambda[*i] < RIGID * stand_in.shift();
        let rigid = (0..few.len().min(stand_in.n_rigid())).take_while(is_rigid).count();
        let (f, mac) = shown(&whole, whole.elastic(), comparison.sensors());
        let (g, near) = shown(&few, rigid..few.len(), &on_basis);
        out.points += 1;
        for i in 0..n_elastic.min(f.len()) {
            let off = if i < g.len() { ((g[i] - f[i]).abs() / f[i].max(f64::MIN_POSITIVE)).min(1.0) } else { 1.0 };
            out.frequency[i] = out.frequency[i].max(off);
            // A double mode has the shapes that the solver chose.
            let apart = |k: usize| k >= f.len() || (f[k] - f[i]).abs() > 1e-4 * f[i];
            if i < g.len() && apart(i + 1) && (i == 0 || apart(i - 1)) {
                let off = (0..mac.ncols()).map(|j| (mac[(i, j)] - near[(i, j)]).abs()).filter(|d| d.is_finite());
                out.mac[i] = off.fold(out.mac[i], f64::max);
            }
        }
    }
    Ok(out)
}
