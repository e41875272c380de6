//! Which measured modes are of the structure, and which modes of the model they are: decided before a fit.
//!
//! A fit that pairs at every point can be dragged by a mode that is not of the structure, and one that starts far pairs wrongly. So
//! the pairs are inferred ([`crate::correlation`], `inference`) while the parameters move by Gauss-Newton steps, first with much model
//! form, which lets far pairs be made, then with less:
//!
//! ```text
//! τ = 0.1, 0.025, 0.006, 0 with k = 8, 4, 2, 1, two steps each;  then τ and k by their evidence, until the pairs stay
//! ```
//!
//! What comes out is a set of measured modes. The fit itself is plain least squares of that set: among what is of the structure it pairs
//! anew at every point, and what is not costs nothing and pulls nothing.

mod gates;
mod partner;
mod standing;

pub(crate) use self::gates::why_unpaired;
use self::gates::{Gates, Told};
use self::partner::{names, resolve};
use super::comparison::Comparison;
use super::prediction::Prediction;
use super::scaling::Scaling;
use crate::correlation::{
    CorrelationError, Form, Label, Level, MeasuredMode, Modelled, Pairings, best, level, marginals,
};
use crate::data::{Standing, TestData};
use crate::linalg::{DMatrix, DVector};
use crate::model::ModeLabel;
use std::sync::Arc;

/// Model form of the steps, with the factor of the noise of shapes.
const STEPS: [Level; 4] = [level(3, 3), level(2, 2), level(1, 1), level(0, 0)];
/// The same for a second try, slower.
const SLOW_STEPS: [Level; 6] = [level(4, 3), level(3, 3), level(3, 2), level(2, 2), level(1, 1), level(0, 0)];
/// Rounds with estimated model form, at most.
const ROUNDS: usize = 4;
/// A step that loses a pair is halved down to this share.
const SHORTEST: f64 = 0.1;
/// Longest step, in prior standard deviations.
const LONGEST: f64 = 1.2;
/// A parameter moves by this share of its interval, or of its value where that is less, before a test has told anything.
const SPREAD_OF_INTERVAL: f64 = 0.5;
const SPREAD_OF_VALUE: f64 = 0.3;
/// Modes of the model up to this factor beyond the measured band may be partners, where frequencies tell and the user gives no window.
const BEYOND: f64 = 2.5;
/// Fewest modes of a test that a fit may leave it, as a share: where more have no partner, the model is wrong as a whole and all stay.
/// Frequencies alone say less: a wrong form of the model misses some of them as a foreign mode would be missed. Of them those that stay must
/// be more than the parameters, by this number at least, to confirm the model.
const FEWEST: f64 = 0.5;
const SPARE: usize = 3;
/// Probabilities of a sure pair, and of a sure foreign mode to be of the structure.
const SURE: f64 = 0.9;
const SURELY_NOT: f64 = 0.01;

/// How pairs are decided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deciding {
    /// Smallest MAC of a pair.
    pub min_mac: f64,
    /// g of the relative frequency window, as in [`crate::correlation::PairingOptions`].
    pub frequency_window: f64,
    /// Share of frequencies that may be noted wrongly: such a mode is of the structure by its shape alone. Zero for a plain fit, which it
    /// would pull; above zero where that is a hypothesis.
    pub misread: f64,
    /// Whether parameters move; otherwise the pairs are those at the estimates.
    pub moves: bool,
}

impl Default for Deciding {
    fn default() -> Self {
        Self { min_mac: 0.0, frequency_window: f64::INFINITY, misread: 0.0, moves: true }
    }
}

/// What was decided.
#[derive(Debug, Clone)]
pub struct Decision {
    /// Where the parameters have come, in the unit box.
    pub x: DVector<f64>,
    /// The standing of every mode of every test.
    pub standings: Vec<Vec<Standing>>,
}

impl Decision {
    /// A test with its modes as decided.
    pub fn applied(&self, k: usize, test: &TestData) -> TestData {
        let mut out = test.clone();
        out.modes.iter_mut().zip(&self.standings[k]).for_each(|(m, s)| m.standing = s.clone());
        out
    }
}

/// Decides which modes of some tests of one structure have which partners.
///
/// * `comparisons` - of the tests, all with the same parameters
/// * `start` - the estimates, in the unit box
///
/// # Errors
/// The model cannot be solved at its estimates; `pair_with` names a mode that the model does not have, or one mode twice.
pub fn decide(
    comparisons: &[Comparison<'_>],
    start: &DVector<f64>,
    options: Deciding,
) -> Result<Decision, CorrelationError> {
    let Some(first) = comparisons.first() else { return Ok(Decision { x: start.clone(), standings: Vec::new() }) };
    let scaling = Scaling::new(first.model());
    let theta = scaling.theta(start);
    let sides = comparisons.iter().map(|c| Side::new(c, &theta)).collect::<Result<Vec<_>, _>>()?;
    if sides.iter().all(|s| s.open.is_empty()) {
        let given = |s: &Side<'_>| s.comparison.test().modes.iter().map(|m| m.standing.clone()).collect();
        return Ok(Decision { x: start.clone(), standings: sides.iter().map(given).collect() });
    }
    let inference = Inference { sides, scaling: &scaling, start, sd: spreads(first, &scaling), options };
    let unsolvable = |e: super::EvalError| CorrelationError::Model(e.to_string());
    if !options.moves || scaling.is_empty() {
        let found = inference.settled(start.clone(), inference.prior()).map_err(unsolvable)?;
        return Ok(inference.decision(&found, !options.moves));
    }
    let mut found = inference.annealed(&STEPS, true).map_err(unsolvable)?;
    if !found.is_sure() {
        // Labels may lead astray, and a slower way may lead elsewhere.
        if let Ok(other) = inference.annealed(&SLOW_STEPS, false)
            && other.score > found.score
        {
            found = other;
        }
    }
    Ok(inference.decision(&found, false))
}

/// The same by the rule of the comparisons instead of inference: what the gates leave without a partner at the start is aside, and the
/// partners that the user names are fixed.
///
/// # Errors
/// As [`decide`].
pub fn decide_by_rule(
    comparisons: &[Comparison<'_>],
    start: &DVector<f64>,
    gates: Deciding,
) -> Result<Decision, CorrelationError> {
    let mut standings = Vec::with_capacity(comparisons.len());
    for c in comparisons {
        let theta = Scaling::new(c.model()).theta(start);
        let p = c.predict(&theta).map_err(|e| CorrelationError::Model(e.to_string()))?;
        let side = Side::new(c, &theta)?;
        let mut own: Vec<Standing> = c.test().modes.iter().map(|m| m.standing.clone()).collect();
        for (&i, given) in side.open.iter().zip(&side.given) {
            if let Some(model_mode) = *given {
                own[i] = Standing::Found {
                    model_mode,
                    rank: 0,
                    family: None,
                    is_fixed: true,
                    probability: 1.0,
                    by_user: true,
                    reference: None,
                };
                continue;
            }
            let Some(pair) = p.pairs.pairs.iter().find(|q| q.experimental == i) else { continue };
            let what = Gates { min_mac: gates.min_mac, window: gates.frequency_window };
            if let Some(gate) = what.closed(c, &p, i, pair.analytical) {
                own[i] = Standing::Aside {
                    foreign: None,
                    reason: gate.reason(&what, c, &p, i, pair.analytical, Told::default()),
                };
            }
        }
        standings.push(own);
    }
    Ok(Decision { x: start.clone(), standings })
}

/// Prior standard deviation of every free parameter, in the unit box.
fn spreads(comparison: &Comparison<'_>, scaling: &Scaling) -> DVector<f64> {
    let parameters = comparison.model().parameters();
    let sd = |k: usize| {
        let p = parameters.get(scaling.free()[k]);
        let width = scaling.width()[k];
        let by_value = SPREAD_OF_VALUE * p.value.abs() / width;
        let own = if by_value > 0.0 { by_value.min(SPREAD_OF_INTERVAL) } else { SPREAD_OF_INTERVAL };
        p.prior_sd.map_or(own, |sd| own.min(sd / width)).max(1e-6)
    };
    DVector::from_fn(scaling.len(), |k, _| sd(k))
}

/// One test.
struct Side<'a> {
    comparison: &'a Comparison<'a>,
    /// Test modes that are to be paired.
    open: Vec<usize>,
    labels: Vec<Option<Label>>,
    /// Partners that are given, of each of them, and whether it was the user.
    given: Vec<Option<usize>>,
    by_user: Vec<bool>,
    needs_names: bool,
}

impl<'a> Side<'a> {
    fn new(comparison: &'a Comparison<'a>, theta: &[f64]) -> Result<Self, CorrelationError> {
        let modes = &comparison.test().modes;
        let open: Vec<usize> = (0..modes.len()).filter(|&i| !modes[i].standing.is_aside()).collect();
        let labels: Vec<Option<Label>> = open.iter().map(|&i| modes[i].label.as_deref().map(Label::read)).collect();
        let needs_names = labels.iter().any(Option::is_some);
        let by_user = open.iter().map(|&i| modes[i].standing.is_named()).collect();
        let mut given = Vec::with_capacity(open.len());
        for &i in &open {
            let found = match &modes[i].standing {
                Standing::With(partner) => resolve(comparison, theta, i, partner)?,
                Standing::Found { reference: Some(_), is_fixed: true, .. } => continued(comparison, theta, i)?,
                Standing::Found { model_mode, is_fixed: true, .. } => *model_mode,
                _ => {
                    given.push(None);
                    continue;
                }
            };
            if let Some(other) = given.iter().position(|g| *g == Some(found)) {
                return Err(CorrelationError::Partner {
                    mode: i + 1,
                    reason: format!(
                        "mode {} of the model is the partner of test mode {} already; a mode has one partner",
                        found + 1,
                        open[other] + 1
                    ),
                });
            }
            given.push(Some(found));
        }
        Ok(Self { comparison, open, labels, given, by_user, needs_names })
    }
}

/// The mode of the model at θ that continues the one that a test mode is followed by.
fn continued(comparison: &Comparison<'_>, theta: &[f64], mode: usize) -> Result<usize, CorrelationError> {
    let p = comparison.predict(theta).map_err(|e| CorrelationError::Model(e.to_string()))?;
    let likeness = comparison.likeness(&p);
    let best = (0..likeness.nrows()).max_by(|&a, &b| likeness[(a, mode)].total_cmp(&likeness[(b, mode)]));
    Ok(best.unwrap_or(0))
}

/// What is seen of one test at a point.
struct Look {
    prediction: Arc<Prediction>,
    /// Modes of the model that may be partners, by index among the elastic ones.
    modes: Vec<usize>,
    names: Option<Vec<ModeLabel>>,
    pairings: Pairings,
}

/// Where the inference has come.
struct Found {
    x: DVector<f64>,
    score: f64,
    sides: Vec<FoundSide>,
}

struct FoundSide {
    look: Look,
    /// Model form of all pairs.
    level: Level,
    /// Partners of the open modes, by position in [`Look::modes`], with the model form of each.
    pairs: Vec<Option<(usize, Form)>>,
    /// P of every pair.
    p: DMatrix<f64>,
    /// L of the given partner of every open mode, by what is measured alone.
    of_given: Vec<Option<f64>>,
    /// The likeliest pair of every open mode, with its L, among those that only a limit or a given partner forbids.
    forbidden: Vec<Option<(usize, f64)>>,
}

impl FoundSide {
    fn partners(&self) -> Vec<Option<usize>> {
        self.pairs.iter().map(|p| p.map(|(a, _)| a)).collect()
    }

    fn foreign(&self, row: usize) -> f64 {
        (1.0 - self.p.row(row).sum()).clamp(0.0, 1.0)
    }
}

impl Found {
    fn is_sure(&self) -> bool {
        let is_sure = |side: &FoundSide| {
            let decided = side.pairs.iter().enumerate().all(|(i, a)| match a {
                Some((a, _)) => side.p[(i, *a)] > SURE,
                None => side.foreign(i) > 1.0 - SURELY_NOT,
            });
            let paired = side.pairs.iter().flatten().count();
            side.level.is_none() && decided && 2 * paired >= side.pairs.len()
        };
        self.sides.iter().all(is_sure)
    }
}

struct Inference<'a> {
    sides: Vec<Side<'a>>,
    scaling: &'a Scaling,
    start: &'a DVector<f64>,
    sd: DVector<f64>,
    options: Deciding,
}

impl Inference<'_> {
    /// The inverse covariance of the parameters before the test.
    fn prior(&self) -> DMatrix<f64> {
        DMatrix::from_diagonal(&self.sd.map(|s| 1.0 / (s * s)))
    }

    /// C^½ of an inverse covariance.
    fn spread(&self, inverse: &DMatrix<f64>) -> DMatrix<f64> {
        let n = self.sd.len();
        let covariance = inverse.clone().cholesky().map(|c| c.inverse());
        let factor = covariance.and_then(nalgebra::Cholesky::new).map(|c| c.l());
        factor.unwrap_or_else(|| DMatrix::from_diagonal(&self.sd)).resize(n, n, 0.0)
    }

    fn looks(&self, x: &DVector<f64>, with_labels: bool) -> Result<Vec<Look>, super::EvalError> {
        self.sides.iter().map(|side| self.look(side, x, with_labels)).collect()
    }

    fn look(&self, side: &Side<'_>, x: &DVector<f64>, with_labels: bool) -> Result<Look, super::EvalError> {
        let c = side.comparison;
        let theta = self.scaling.theta(x);
        let prediction = c.predict(&theta)?;
        let test = c.test();
        let measured_hz = side.open.iter().map(|&i| test.modes[i].frequency_hz.value);
        let (low, high) = measured_hz.fold((f64::INFINITY, 0.0_f64), |(l, h), f| (l.min(f), h.max(f)));
        let everywhere = self.options.misread > 0.0 || self.options.frequency_window.is_finite();
        let is_near = |a: usize| {
            let f = prediction.frequencies_hz[a];
            everywhere || (f > low / BEYOND && f < high * BEYOND) || side.given.contains(&Some(a))
        };
        let modes: Vec<usize> = (0..prediction.frequencies_hz.len()).filter(|&a| is_near(a)).collect();
        let names = if with_labels && side.needs_names { names(c, &theta, &prediction) } else { None };
        let free = self.scaling.free();
        let derivative =
            if free.is_empty() { None } else { Some(c.differentiate_modes(&theta, &prediction, free, &modes)?) };
        let n_sensors = prediction.at_sensors.nrows();
        let width = self.scaling.width();
        let modelled: Vec<Modelled> = modes
            .iter()
            .map(|&a| {
                let f = prediction.frequencies_hz[a];
                let (mut d_ln_f, mut d_shape) = (DVector::zeros(free.len()), DMatrix::zeros(n_sensors, free.len()));
                if let Some((df, d_phi)) = derivative.as_ref().and_then(|d| d.modes[a].as_ref()) {
                    for (j, w) in width.iter().enumerate() {
                        d_ln_f[j] = df[j] * w / f;
                        d_shape.set_column(j, &(d_phi.column(j) * *w));
                    }
                }
                let label = names.as_ref().map(|n| Label::read(&n[a].long));
                let shape = prediction.at_sensors.column(a).into_owned();
                Modelled { frequency: f, shape, d_ln_f, d_shape, label }
            })
            .collect();
        let shapes: Vec<Option<Vec<f64>>> = side
            .open
            .iter()
            .map(|&i| test.modes[i].shape.is_some().then(|| c.shapes().column(i).iter().copied().collect()))
            .collect();
        let measured: Vec<MeasuredMode<'_>> = side
            .open
            .iter()
            .enumerate()
            .map(|(k, &i)| MeasuredMode {
                frequency: (test.modes[i].frequency_hz.value, test.modes[i].frequency_hz.sd),
                shape: shapes[k].as_deref(),
                shape_sd: test.modes[i].shape_sd.as_ref().map(DVector::as_slice),
                label: side.labels[k].as_ref(),
            })
            .collect();
        let given: Vec<Option<usize>> =
            side.given.iter().map(|g| g.and_then(|g| modes.iter().position(|&a| a == g))).collect();
        let gates = self.gates();
        let is_allowed = |k: usize, at: usize| gates.closed(c, &prediction, side.open[k], modes[at]).is_none();
        let pairings = Pairings::new(&measured, &modelled, is_allowed, given, free.len());
        Ok(Look { prediction, modes, names, pairings })
    }

    fn gates(&self) -> Gates {
        Gates { min_mac: self.options.min_mac, window: self.options.frequency_window }
    }

    /// Gauss-Newton from the estimates, with less and less model form, then with that of largest evidence.
    ///
    /// A step that would lose a pair is shortened, if that keeps it: a compliance is far from linear, and a whole step may lose the mode that it
    /// was to explain.
    fn annealed(&self, steps: &[Level], with_labels: bool) -> Result<Found, super::EvalError> {
        let mut x = self.start.clone();
        let mut inverse = self.prior();
        let mut looks = self.looks(&x, with_labels)?;
        for &level in steps {
            for _ in 0..2 {
                let spread = self.spread(&inverse);
                let misread = self.options.misread;
                let parts = looks.iter().map(|l| {
                    let seen = l.pairings.seen(Some(&spread), misread);
                    let pairs = seen.with_forms(&best(&seen.ln_odds(level)), level);
                    l.pairings.normal_equations(&pairs, misread)
                });
                let Some((moved, h)) = self.step_of(&x, parts) else { continue };
                let fewest = self.n_pairs(&looks, &spread, level);
                let mut whole = None;
                let mut share = 1.0;
                let shorter = loop {
                    let tried = &x + (&moved - &x) * share;
                    match self.looks(&tried, with_labels) {
                        Ok(there) if self.n_pairs(&there, &spread, level) >= fewest => break Some((tried, there)),
                        Ok(there) => _ = whole.get_or_insert((tried, there)),
                        Err(_) => {}
                    }
                    share *= 0.5;
                    if share < SHORTEST {
                        break None;
                    }
                };
                // Where the model cannot be solved the way ends; what is known at the estimates counts.
                let Some(next) = shorter.or(whole) else {
                    return self.settled(self.start.clone(), self.prior());
                };
                (x, looks) = next;
                inverse = h;
            }
        }
        self.settled(x, inverse)
    }

    /// Number of pairs that are made at a point.
    fn n_pairs(&self, looks: &[Look], spread: &DMatrix<f64>, level: Level) -> usize {
        let of = |l: &Look| {
            let seen = l.pairings.seen(Some(spread), self.options.misread);
            best(&seen.ln_odds(level)).iter().flatten().count()
        };
        looks.iter().map(of).sum()
    }

    /// A step with the pairs and the model form that were found.
    fn step(&self, found: &Found) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let parts = found.sides.iter().map(|s| s.look.pairings.normal_equations(&s.pairs, self.options.misread));
        self.step_of(&found.x, parts)
    }

    /// One step, and the inverse covariance of the parameters there; none where the equations are singular.
    fn step_of(
        &self,
        x: &DVector<f64>,
        parts: impl Iterator<Item = (DMatrix<f64>, DVector<f64>)>,
    ) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let prior = self.prior();
        let (mut h, mut g) = (prior.clone(), prior * (self.start - x));
        for (own_h, own_g) in parts {
            h += own_h;
            g += own_g;
        }
        let mut dx = h.clone().cholesky()?.solve(&g);
        let longest = dx.iter().zip(self.sd.iter()).map(|(d, s)| (d / s).abs()).fold(0.0, f64::max);
        if longest > LONGEST {
            dx *= LONGEST / longest;
        }
        let moved = (x + dx).map(|v| v.clamp(0.0, 1.0));
        moved.iter().all(|v| v.is_finite()).then_some((moved, h))
    }

    /// Model form by its evidence, pairs and steps with it until they stay.
    fn settled(&self, mut x: DVector<f64>, mut inverse: DMatrix<f64>) -> Result<Found, super::EvalError> {
        let mut rounds = if self.options.moves && !self.sd.is_empty() { ROUNDS } else { 0 };
        let mut before: Option<Vec<Vec<Option<usize>>>> = None;
        loop {
            let looks = match self.looks(&x, true) {
                Err(_) if x != *self.start => {
                    x.copy_from(self.start);
                    self.looks(&x, true)?
                }
                looks => looks?,
            };
            let found = self.judged(x.clone(), looks, &inverse);
            if rounds == 0 {
                return Ok(found);
            }
            rounds -= 1;
            let pairs: Vec<_> = found.sides.iter().map(FoundSide::partners).collect();
            let Some((moved, h)) = self.step(&found) else { return Ok(found) };
            let far = (&moved - &x).iter().zip(self.sd.iter()).map(|(d, s)| (d / s).abs()).fold(0.0, f64::max);
            if before.as_ref() == Some(&pairs) && far < 1e-3 {
                // One more look with the covariance of these pairs.
                rounds = 0;
            }
            (x, inverse) = (moved, h);
            before = Some(pairs);
        }
    }

    /// Pairs, their probabilities and the model form at a point.
    fn judged(&self, x: DVector<f64>, looks: Vec<Look>, inverse: &DMatrix<f64>) -> Found {
        let spread = self.options.moves.then(|| self.spread(inverse));
        let away = (&x - self.start).component_div(&self.sd);
        let mut score = -0.5 * away.norm_squared();
        let sides = looks
            .into_iter()
            .map(|look| {
                let seen = look.pairings.seen(spread.as_ref(), self.options.misread);
                let (level, own) = seen.level();
                score += own;
                let odds = seen.ln_odds(level);
                let pairs = seen.with_forms(&best(&odds), level);
                let n = odds.nrows();
                let of_given = (0..n).map(|i| seen.ln_odds_of_given(i, level)).collect();
                let forbidden = (0..n).map(|i| seen.likeliest_forbidden(i, level)).collect();
                FoundSide { level, pairs, p: marginals(&odds), of_given, forbidden, look }
            })
            .collect();
        Found { x, score, sides }
    }

    fn decision(&self, found: &Found, is_fixed: bool) -> Decision {
        let mut any = false;
        let mut one = |(side, at): (&Side<'_>, &FoundSide)| {
            let mut out = self.standings(side, at, is_fixed);
            let kept = side.open.iter().filter(|&&i| !out[i].is_aside()).count();
            // What a limit of the user puts aside stays there.
            let is_inferred = |s: &Standing| matches!(s, Standing::Aside { foreign: Some(_), .. });
            let inferred = out.iter().filter(|s| is_inferred(s)).count();
            let spare = if side.comparison.has_shapes() { 0 } else { self.scaling.len() + SPARE };
            let fewest = (FEWEST * (kept + inferred) as f64).max(spare as f64);
            if self.options.moves && (kept as f64) < fewest {
                let modes = side.comparison.test().modes.iter();
                out.iter_mut()
                    .zip(modes)
                    .filter(|(s, _)| !matches!(s, Standing::Aside { foreign: None, .. }))
                    // What a name has paired is followed all the same.
                    .filter(|(s, _)| !s.is_followed())
                    .for_each(|(s, mode)| *s = mode.standing.clone());
                return out;
            }
            any |= kept > 0;
            out
        };
        let standings = self.sides.iter().zip(&found.sides).map(&mut one).collect();
        let x = if any { found.x.clone() } else { self.start.clone() };
        Decision { x, standings }
    }
}
