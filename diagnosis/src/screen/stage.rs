//! The base fit with its screening: all that is known before any hypothesis is refitted.

use super::adjoint::{Answers, screen};
use super::effects::{Directions, Score, Screened, Seen, screen_again};
use super::noise::{Scatter, best_scores, p_value, scatter};
use super::robust::{robust_fits, when_corrected};
use super::traces::{FaultScore, Trace, faults_at, traces};
use crate::effort::Effort;
use crate::error::DiagnosisError;
use crate::problem::evidence::goodness_of_fit;
use crate::problem::fit::{Fit, evaluate, project};
use crate::problem::race::fit;
use crate::problem::scene::{Scene, box_starts};
use crate::settings::Settings;
use crate::thresholds::{LN_WIDER, REMAINDER};
use retune::correlation::{CorrelationError, Transducer, transducers};
use retune::data::Sensor;
use retune::effect::{
    Candidate, Configured, Context, Effects, Location, SensorLoad, Structure, candidates_at_place, candidates_in,
    candidates_on_wider_places,
};
use retune::fault::PlacedFault;
use retune::linalg::{DMatrix, DVector};
use retune::model::Model;
use std::borrow::Borrow;
use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A scene, fitted and screened.
#[derive(Clone)]
pub(crate) struct Stage {
    pub(crate) scene: Scene,
    pub(crate) fit: Fit,
    /// 1/√s2.
    pub(crate) weight: f64,
    pub(crate) q: DMatrix<f64>,
    pub(crate) screened: Arc<Vec<Screened>>,
    /// Their projected columns.
    pub(crate) directions: Arc<Directions>,
    /// Effects by descending score, or in turns of two such lists, see [`ranked`].
    pub(crate) effects: Vec<Score>,
    pub(crate) faults: Vec<PlacedFault>,
    /// Faults by descending score.
    pub(crate) fault_scores: Vec<FaultScore>,
    /// Where fits lie that a bad channel could not pull aside.
    pub(crate) robust: Vec<DVector<f64>>,
    /// What this fit says of the scatter, in units of the weight.
    pub(crate) scatter: Scatter,
    /// P(best score >= observed).
    pub(crate) p_value: f64,
    /// The projected residual.
    pub(crate) residual: DVector<f64>,
    /// What the sensors answer at its fit.
    pub(crate) answers: Arc<Answers>,
    /// How it was asked for.
    pub(crate) settings: Settings,
    /// Hypotheses that were fitted from here, in full or with a few steps.
    pub(crate) fitted: Arc<AtomicUsize>,
}

impl Stage {
    /// A stage on top of this one, which need not evaluate again what this has seen.
    ///
    /// * `start` - of its fit
    pub(crate) fn with_on_top(
        &self,
        scene: Scene,
        start: &DVector<f64>,
        weight: f64,
        settings: &Settings,
    ) -> Result<Self, DiagnosisError> {
        self.answers.forget();
        let seen = Seen { screened: &self.screened, fit: &self.fit, weight: self.weight };
        stage_of(scene, (std::slice::from_ref(start), None), weight, settings, Some(&seen))
    }

    /// How much is tried.
    pub(crate) fn effort(&self) -> &Effort {
        &self.settings.effort
    }

    /// Counts a hypothesis that is fitted, if there is time for it.
    pub(crate) fn may_fit(&self) -> bool {
        let may = !self.settings.until.is_over();
        self.fitted.fetch_add(usize::from(may), Ordering::Relaxed);
        may
    }

    /// Places the changes of effects at once where models are large: one by one each would take a placing of the whole file.
    pub(crate) fn place<'a>(&self, effects: impl Iterator<Item = &'a Score>) {
        if self.scene.is_large() {
            let these: Vec<Candidate> = effects.map(|s| self.screened[s.index].candidate.clone()).collect();
            self.scene.place(&these);
        }
    }

    /// The id of a screened effect.
    pub(crate) fn id(&self, score: &Score) -> String {
        self.screened[score.index].candidate.id()
    }

    /// Effects at wider places than those of the file.
    ///
    /// * `near` - nodes, elements, members, spans or ends that they have to touch; none for all places
    pub(crate) fn wider_candidates(
        &self,
        near: Option<&[String]>,
        is_wanted: impl Fn(&Candidate) -> bool,
    ) -> Vec<Candidate> {
        let all = in_configurations(&self.scene, &self.settings.places, &[], |tested| {
            candidates_on_wider_places(tested, &self.settings.effects, near)
        });
        all.into_iter().filter(is_wanted).map(|c| Candidate { of_place: LN_WIDER, ..c }).collect()
    }

    /// An effect at places of a mesh about one of its own that nobody has tried yet, see [`Structure::finer`]. They share its evidence, see
    /// [`Structure::ln_between`].
    ///
    /// * `structures` - those of [`Self::structures`]
    pub(crate) fn finer_candidates(
        &self,
        structures: &[Structure<'_>],
        about: &Candidate,
        round: u32,
    ) -> Vec<Candidate> {
        let found = structures.iter().map(|s| s.finer(&about.location, round));
        let further = found.into_iter().find(|f| !f.is_empty()).unwrap_or_default();
        if further.is_empty() {
            return Vec::new();
        }
        self.between_candidates(structures, about, &further)
    }

    /// An effect at these places between those that every search tries, see [`Self::finer_candidates`].
    pub(crate) fn between_candidates(
        &self,
        structures: &[Structure<'_>],
        about: &Candidate,
        further: &[String],
    ) -> Vec<Candidate> {
        let of_place = |at: &Location| -structures.first().map_or(0.0, |s| s.ln_between(at));
        let all = self.candidates_at(about, further);
        all.into_iter().map(|c| Candidate { of_place: of_place(&c.location), ..c }).collect()
    }

    /// An effect at these places, and what it becomes at a limit of its sizes: a body on a stiff spring is a point mass.
    pub(crate) fn candidates_at(&self, about: &Candidate, further: &[String]) -> Vec<Candidate> {
        let only = self.limits(about).with(about.effect);
        let mut all =
            in_configurations(&self.scene, &self.settings.places, further, |tested| candidates_in(tested, &only));
        let is_like = |c: &Candidate| {
            let is_same = c.effect.name() == about.effect.name();
            if is_same {
                c.location.is_like(&about.location)
            } else {
                c.location.names.len() == about.location.names.len()
            }
        };
        all.retain(|c| is_like(c) && c.location.names.iter().any(|n| further.contains(n)));
        all
    }

    /// What an effect becomes at a limit of its sizes, at its own place.
    pub(crate) fn limit_candidates(&self, of: &Candidate) -> Vec<Candidate> {
        self.effects_at(of, &self.limits(of))
    }

    /// All other effects at the place of one.
    pub(crate) fn other_candidates(&self, than: &Candidate) -> Vec<Candidate> {
        let mut all = self.effects_at(than, &self.settings.effects);
        all.retain(|c| c.effect.name() != than.effect.name());
        all
    }

    /// These effects at the place of one, with the evidence that it pays for that.
    fn effects_at(&self, of: &Candidate, effects: &Effects) -> Vec<Candidate> {
        let names = &of.location.names;
        let there = in_configurations(&self.scene, &[], names, |tested| candidates_at_place(tested, effects, names));
        let is_there = |c: &Candidate| c.location.configuration == of.location.configuration;
        there.into_iter().filter(is_there).map(|c| Candidate { of_place: of.of_place, ..c }).collect()
    }

    fn limits(&self, of: &Candidate) -> Effects {
        let limits = of.effect.becomes().iter().filter_map(|name| self.settings.effects.find(name));
        limits.fold(Effects::none(), Effects::with)
    }

    /// The structures of its tests, as effects see them.
    pub(crate) fn structures(&self) -> Vec<Structure<'_>> {
        self.scene.cases.iter().map(|case| Structure::new(&case.model, Context::nothing())).collect()
    }

    /// The same with these effects, at places that others do not have, instead of its own.
    pub(crate) fn on_wider(&self, placed: Vec<Candidate>) -> Result<Stage, DiagnosisError> {
        self.clone().screening(placed)
    }

    /// This stage with a hypothesis, where that has brought it; its effects are those of this one.
    pub(crate) fn at(&self, scene: Scene, fit: Fit) -> Result<Stage, DiagnosisError> {
        let q = fit.basis()?;
        let residual = project(&q, &fit.r);
        Ok(Stage { scene, fit, q, residual, answers: Arc::default(), ..self.clone() })
    }

    /// The same effects as they are seen from another point of the base.
    pub(crate) fn seen_from(&self, x: &DVector<f64>) -> Result<Stage, DiagnosisError> {
        let fit = evaluate(&self.scene, x.clone(), self.weight)?;
        let q = fit.basis()?;
        let residual = project(&q, &fit.r);
        let placed = self.screened.iter().map(|s| s.candidate.clone()).collect();
        Stage { fit, q, residual, answers: Arc::default(), ..self.clone() }.screening(placed)
    }

    /// This stage with these effects instead of its own, screened at its fit.
    fn screening(mut self, placed: Vec<Candidate>) -> Result<Stage, DiagnosisError> {
        self.screened = Arc::new(screen(&self.scene, &self.fit, self.weight, placed, &self.settings, &self.answers)?);
        self.directions = Arc::new(Directions::new(&self.screened, &self.q, self.fit.r.len()));
        self.effects = ranked(&self.scene, &self.screened, &self.directions, &self.residual);
        Ok(self)
    }

    /// How many times the stated standard deviations the noise is taken to be.
    pub(crate) fn noise_factor(&self) -> f64 {
        1.0 / self.weight
    }
}

/// Candidates times dofs from which a stage on top of another takes over what that has seen, where its modes are hardly others: to place all of them on
/// another file, and to solve for the sensors, takes a minute there.
const VAST: usize = 100_000_000;

fn is_vast(scene: &Scene, candidates: usize) -> bool {
    scene.is_large() && scene.most_dofs() * candidates > VAST
}

/// Fits and screens a scene.
///
/// * `starts` - starts of the fit beside the estimates and points of the box
/// * `weight` - 1/√s2
pub(crate) fn stage(
    scene: Scene,
    starts: &[DVector<f64>],
    weight: f64,
    settings: &Settings,
) -> Result<Stage, DiagnosisError> {
    stage_of(scene, (starts, None), weight, settings, None)
}

/// The same with one more start: where the parameters came while the pairs were decided.
pub(crate) fn stage_begun(
    scene: Scene,
    starts: &[DVector<f64>],
    begun: Option<&DVector<f64>>,
    weight: f64,
    settings: &Settings,
) -> Result<Stage, DiagnosisError> {
    stage_of(scene, (starts, begun), weight, settings, None)
}

/// * `seen` - of a stage that this one stands on
fn stage_of(
    scene: Scene,
    (starts, begun): (&[DVector<f64>], Option<&DVector<f64>>),
    weight: f64,
    settings: &Settings,
    seen: Option<&Seen<'_>>,
) -> Result<Stage, DiagnosisError> {
    let scene = scene.in_full(starts.first())?;
    let answers = Arc::new(Answers::default());
    let mut all = starts.to_vec();
    all.push(scene.start());
    if starts.is_empty() {
        all.extend(box_starts(&scene, settings.effort.box_starts, settings.seed));
    }
    all.extend(begun.cloned());
    settings.listener.say("fitting the model as it is");
    let base = fit(&scene, &all, weight)?;
    let placed = placed(&scene, settings);
    let q = base.basis()?;
    let screened = match seen {
        Some(seen) if !scene.is_large() => screen_again(&scene, &base, &q, weight, placed, seen, settings),
        _ => {
            let near = seen.filter(|seen| is_vast(&scene, placed.len()) && seen.is_near(&base));
            let carried = match near {
                Some(seen) => seen.carried(&scene, &base, weight, placed),
                None => Err(placed),
            };
            match carried {
                Ok((known, _)) => known,
                Err(placed) => screen(&scene, &base, weight, placed, settings, &answers)?,
            }
        }
    };
    let directions = Directions::new(&screened, &q, base.r.len());
    let scatter = scatter(&scene, &base, &q, &directions, settings.seed);
    let residual = project(&q, &base.r);
    let effects = ranked(&scene, &screened, &directions, &residual);
    settings.listener.say("screening faults of the measurement");
    let list = faults_at(&scene, &base, &settings.faults);
    let seen: Vec<(usize, Trace)> = traces(&scene, &base, weight, &list, &settings.until)
        .into_iter()
        .enumerate()
        .filter_map(|(i, t)| t.map(|t| (i, t.projected(&q))))
        .collect();
    let mut fault_scores: Vec<FaultScore> = seen
        .iter()
        .map(|(index, t)| FaultScore {
            index: *index,
            t: t.score(&residual),
            number: t.number(&residual, list[*index].number().neutral()),
            robust: None,
        })
        .collect();
    // A gross fault has pulled the fit aside; at a fit that it could not pull, its trace is whole.
    let others = if !list.is_empty() && !settings.until.is_over() && goodness_of_fit(&base, &q) < REMAINDER {
        robust_fits(&scene, &base, weight, &settings.effort)?
    } else {
        Vec::new()
    };
    let mut take = |found: FaultScore| match fault_scores.iter_mut().find(|f| f.index == found.index) {
        Some(f) if found.t > f.t => *f = found,
        Some(_) => {}
        None => fault_scores.push(found),
    };
    for (k, other) in others.iter().enumerate() {
        let excess = 2.0 * (other.phi - base.phi);
        for (index, trace) in traces(&scene, other, weight, &list, &settings.until).into_iter().enumerate() {
            let Some(trace) = trace else { continue };
            let t = (trace.score(&other.r) - excess).max(0.0);
            take(FaultScore {
                index,
                t,
                number: trace.number(&other.r, list[index].number().neutral()),
                robust: Some(k),
            });
        }
    }
    if !others.is_empty() {
        for (index, t) in when_corrected(&scene, &base, weight, &list) {
            take(FaultScore { t, ..FaultScore::unscored(index) });
        }
    }
    fault_scores.sort_by(|a, b| b.t.total_cmp(&a.t).then(a.index.cmp(&b.index)));
    settings.listener.say("simulating what noise alone would give");
    let null_traces: Vec<Trace> = seen.into_iter().map(|(_, t)| t).collect();
    let draws = best_scores(&base, &q, &directions, &null_traces, settings.seed.wrapping_add(1));
    let best = highest(&effects).max(fault_scores.first().map_or(0.0, |f| f.t));
    let p = p_value(&draws, best);
    Ok(Stage {
        scene,
        fit: base,
        weight,
        q,
        screened: Arc::new(screened),
        directions: Arc::new(directions),
        effects,
        faults: list,
        fault_scores,
        robust: others.into_iter().map(|f| f.x).collect(),
        scatter,
        p_value: p,
        residual,
        answers,
        settings: settings.clone(),
        fitted: Arc::default(),
    })
}

/// The highest score of effects in any order.
pub(crate) fn highest(effects: &[Score]) -> f64 {
    effects.iter().fold(0.0, |most, s| most.max(s.t))
}

/// Effects by descending score. Where a mode waits for a partner, which the screening cannot see coming, those that bring one of its shape, the
/// most like first, and those that may take turns, so that neither crowds the other out of what is fitted.
fn ranked(scene: &Scene, screened: &[Screened], directions: &Directions, residual: &DVector<f64>) -> Vec<Score> {
    let all = directions.rank(residual);
    let Some(sought) = scene.only() else { return all };
    let (mut shown, mut others) = (Vec::new(), Vec::new());
    for s in all {
        match sought.shown.get(&screened[s.index].candidate.id()) {
            Some(&share) => shown.push((share, s)),
            None => others.push(s),
        }
    }
    shown.sort_by(|a, b| b.0.total_cmp(&a.0));
    in_turns(shown.into_iter().map(|(_, s)| s), others)
}

/// The next of one ranking and the next of another, in turns, each effect once.
pub(crate) fn in_turns<S: Borrow<Score>>(
    first: impl IntoIterator<Item = S>,
    second: impl IntoIterator<Item = S>,
) -> Vec<S> {
    let (mut first, mut second) = (first.into_iter(), second.into_iter());
    let mut known = BTreeSet::new();
    let mut out = Vec::new();
    loop {
        let mut is_new = |s: &S| known.insert(s.borrow().index);
        let both = [first.find(&mut is_new), second.find(&mut is_new)];
        if both.iter().all(Option::is_none) {
            return out;
        }
        out.extend(both.into_iter().flatten());
    }
}

/// What carries the sensors of a test, for effects of their mass.
///
/// # Errors
/// A sensor names a node or element that the model does not have.
pub fn sensor_loads(model: &Model, sensors: &[Sensor]) -> Result<Vec<SensorLoad>, CorrelationError> {
    let load = |t: Transducer| t.shares.into_iter().map(move |(node, share)| SensorLoad { node, share, arm: t.arm });
    Ok(transducers(model, sensors)?.into_iter().flat_map(load).collect())
}

/// Every effect at every place of the structure, in the configurations that were tested.
pub(crate) fn placed(scene: &Scene, settings: &Settings) -> Vec<Candidate> {
    let mut all =
        in_configurations(scene, &settings.places, &settings.places, |tested| candidates_in(tested, &settings.effects));
    if let Some(only) = scene.only() {
        all.retain(|c| only.contains(&c.id()));
    }
    all
}

/// What `list` finds on the configurations that were tested, as far as it has one of the places; of none, everything.
///
/// * `further` - places of a mesh beside those at which effects are always looked for
fn in_configurations(
    scene: &Scene,
    places: &[String],
    further: &[String],
    list: impl Fn(&[Configured<'_>]) -> Vec<Candidate>,
) -> Vec<Candidate> {
    let mut configurations: Vec<(Option<&str>, &Model, Context)> = Vec::new();
    for case in &scene.cases {
        // The scene was built with these sensors, so each has its place.
        let sensors = sensor_loads(&case.model, &case.test.sensors).unwrap_or_default();
        let frequencies_hz: Vec<f64> = case.test.modes.iter().map(|m| m.frequency_hz.value).collect();
        match configurations.iter_mut().find(|c| c.0 == scene.configuration(case)) {
            Some((_, _, known)) => {
                let new: Vec<SensorLoad> = sensors.into_iter().filter(|s| !known.sensors.contains(s)).collect();
                known.sensors.extend(new);
                known.frequencies_hz.extend(frequencies_hz);
            }
            None => {
                let here = scene.configuration(case).and_then(|name| scene.file.configurations.get(name));
                let own_masses = here.map_or_else(Vec::new, |c| c.masses.keys().cloned().collect());
                let further = further.to_vec();
                let context = Context { sensors, frequencies_hz, own_masses, further };
                configurations.push((scene.configuration(case), &case.model, context));
            }
        }
    }
    let tested: Vec<Configured<'_>> =
        configurations.iter().map(|(name, model, context)| Configured { name: *name, model, context }).collect();
    let mut found = list(&tested);
    if !places.is_empty() {
        let structures: Vec<Structure<'_>> = tested.iter().map(|c| Structure::new(c.model, c.context)).collect();
        found.retain(|c| structures.iter().any(|s| s.touches(&c.location, places)));
    }
    found
}
