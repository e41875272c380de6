//! Faults of the measurement as switches: what the test would be without them, as functions of their numbers.

use super::super::data::{Doubles, LiveEntries, LiveTestEdit};
use super::rows::rows_of;
use retune::correlation::{CorrelationError, observation_matrix, sensor_position};
use retune::data::TestData;
use retune::fault::{Bench, Faults, Number, PlacedFault, SingleTest};
use retune::linalg::{DMatrix, DVector};
use retune::model::{Model, Parameter, StandIn};
use retune::objective::real_shapes;
use retune_diagnosis::HypothesisResult;

/// What the forms below leave at numbers that they were not fitted to, relatively, is rounding.
const ROUNDING: f64 = 1e-9;
/// A slider of a factor reaches from this part of it to its inverse; of an angle, to this many degrees.
const LEAST_FACTOR: f64 = 0.1;
const MOST_DEGREES: f64 = 45.0;

/// A fault with its number, if it has one.
pub(super) struct TriedFault<'a> {
    pub(super) result: &'a HypothesisResult,
    placed: PlacedFault,
    /// The number as a parameter of the page; at its value the test is unchanged.
    pub(super) number: Option<Parameter>,
    /// What the diagnosis estimates it to be, SI.
    pub(super) estimate: f64,
}

impl<'a> TriedFault<'a> {
    pub(super) fn new(model: &Model, test: &TestData, result: &'a HypothesisResult) -> Result<Self, String> {
        let tests = SingleTest::new(test);
        let positions = test.sensors.iter().map(|s| sensor_position(model, s)).collect::<Result<Vec<_>, _>>().ok();
        let geometry = model.geometry();
        let nodes = geometry.names.iter().cloned().zip(geometry.positions.iter().copied());
        let nodes = nodes.take(model.spec().nodes.len()).collect();
        let bench = Bench { tests: &tests, positions, nodes };
        let placed = PlacedFault::of_id(&result.id, &Faults::builtin(), &bench).map_err(|e| e.to_string())?;
        let kind = placed.number();
        let told = result.estimates.first();
        let estimate = told.map_or_else(
            || kind.neutral(),
            |e| match (kind, e.unit.as_str()) {
                (Number::Angle { .. }, "deg") => e.value.to_radians(),
                (Number::Frequency { .. }, _) => {
                    let mode = placed.at.modes().first().copied().unwrap_or_default();
                    test.modes.get(mode).map_or(1.0, |m| m.frequency_hz.value / e.value)
                }
                _ => e.value,
            },
        );
        let bounds = match kind {
            Number::None | Number::Silence | Number::Mixture => None,
            Number::Angle { .. } => Some([-MOST_DEGREES.to_radians(), MOST_DEGREES.to_radians()]),
            // A negative gain is a sign too: the slider stays on its side of zero.
            Number::Factor { .. } if estimate < 0.0 => Some([-LEAST_FACTOR.recip(), -LEAST_FACTOR]),
            Number::Factor { .. } => Some([LEAST_FACTOR, LEAST_FACTOR.recip()]),
            Number::Frequency { .. } => Some([0.5, 2.0]),
            Number::Scatter => Some([1.0, LEAST_FACTOR.recip()]),
        };
        let name = match kind {
            Number::Angle { .. } => "angle",
            Number::Scatter => "factor on the noise",
            Number::Frequency { .. } => "factor on the frequency",
            _ => "gain",
        };
        let number = bounds.map(|[low, high]| Parameter {
            name: format!("{}.{name}", result.id),
            unit: if matches!(kind, Number::Angle { .. }) { "deg".into() } else { String::new() },
            unit_factor: if matches!(kind, Number::Angle { .. }) { 1_f64.to_radians() } else { 1.0 },
            value: kind.neutral(),
            bounds: Some([low.min(estimate), high.max(estimate)]),
            prior_sd: None,
            description: String::new(),
        });
        Ok(Self { result, placed, number, estimate })
    }

    /// The forms that its number enters by.
    fn forms(&self, g: f64) -> [f64; 3] {
        match self.placed.number() {
            Number::Angle { .. } => [1.0, g.cos(), g.sin()],
            Number::None | Number::Silence | Number::Mixture => [1.0, 0.0, 0.0],
            _ => [1.0, g, g.recip()],
        }
    }

    /// Numbers at which the forms are fitted, and others at which they are held against the truth.
    fn samples(&self) -> Vec<f64> {
        let Some([low, high]) = self.number.as_ref().and_then(|p| p.bounds) else { return vec![self.estimate] };
        [0.1, 0.45, 0.9, 0.3, 0.7].map(|t| low + t * (high - low)).to_vec()
    }

    /// What it does to the test: the entries that change, each by three coefficients.
    ///
    /// # Errors
    /// In words: it changes nothing that the page compares, or not in these forms.
    pub(super) fn edit(&self, model: &Model, stand_in: &StandIn, test: &TestData) -> Result<LiveTestEdit, String> {
        let n_modes = test.modes.len();
        let at = |test: &TestData| -> Result<Arrays, CorrelationError> { Arrays::new(model, stand_in, test) };
        let words = |e: CorrelationError| e.to_string();
        let before = at(test).map_err(words)?;
        let numbers = self.samples();
        let mut after = Vec::with_capacity(numbers.len());
        for &g in &numbers {
            let without = self.placed.taken_out_of(test, g);
            if without.modes.len() != n_modes || without.sensors.len() != test.sensors.len() {
                return Err("it changes the number of modes or sensors".into());
            }
            after.push(at(&without).map_err(words)?);
        }
        let spaces = |test: &TestData| test.modes.iter().map(|m| m.space.clone()).collect::<Vec<_>>();
        let without = self.placed.taken_out_of(test, self.estimate);
        let new_spaces = if spaces(&without) == spaces(test) { Vec::new() } else { spaces(&without) };
        let entries = |part: usize| self.entries(&before.0[part], &numbers, &after, part);
        let edit = LiveTestEdit {
            is_angle: matches!(self.placed.number(), Number::Angle { .. }),
            frequency: entries(0)?,
            frequency_sd: entries(1)?,
            shape: entries(2)?,
            shape_sd: entries(3)?,
            sensors: entries(4)?,
            spaces: new_spaces,
            remedy: self.result.patch.clone(),
        };
        let changed = [&edit.frequency, &edit.frequency_sd, &edit.shape, &edit.shape_sd, &edit.sensors];
        if changed.iter().all(|e| e.at.is_empty()) && edit.spaces.is_empty() {
            return Err("it is in frequency responses or static readings, which the page does not compare".into());
        }
        Ok(edit)
    }

    fn entries(&self, before: &[f64], numbers: &[f64], after: &[Arrays], part: usize) -> Result<LiveEntries, String> {
        let same = |a: f64, b: f64| a == b || (a.is_nan() && b.is_nan());
        let (mut out, mut values) = (LiveEntries::default(), Vec::new());
        let size = before.iter().copied().filter(|v| v.is_finite()).map(f64::abs).fold(0.0, f64::max);
        for (k, &old) in before.iter().enumerate() {
            let new: Vec<f64> = after.iter().map(|a| a.0[part][k]).collect();
            if new.iter().all(|v| same(*v, old)) {
                continue;
            }
            let coefficients = if new.iter().all(|v| v.is_nan()) {
                [f64::NAN, 0.0, 0.0]
            } else if new.len() < 3 {
                [new[0], 0.0, 0.0]
            } else {
                let rows = DMatrix::from_fn(3, 3, |i, j| self.forms(numbers[i])[j]);
                let found =
                    rows.lu().solve(&DVector::from_column_slice(&new[..3])).ok_or("its forms depend on each other")?;
                [found[0], found[1], found[2]]
            };
            for (&g, &v) in numbers.iter().zip(&new) {
                let told: f64 = self.forms(g).iter().zip(coefficients).map(|(a, b)| a * b).sum();
                if !same(told, v) && (told - v).abs().is_nan() || (told - v).abs() > ROUNDING * size.max(v.abs()) {
                    return Err("its number enters in another way than as a factor or an angle".into());
                }
            }
            out.at.push(k);
            values.extend(coefficients);
        }
        out.values = Doubles(values);
        Ok(out)
    }
}

/// What the page compares with: frequencies and their standard deviations, shapes and theirs by modes, sensors on coordinates by rows.
struct Arrays([Vec<f64>; 5]);

impl Arrays {
    fn new(model: &Model, stand_in: &StandIn, test: &TestData) -> Result<Self, CorrelationError> {
        let n = test.sensors.len();
        let mut real = real_shapes(test);
        for (j, _) in test.modes.iter().enumerate().filter(|(_, m)| m.standing.is_aside()) {
            real.column_mut(j).fill(f64::NAN);
        }
        let shapes = real.iter().copied().collect();
        let mut sd = Vec::new();
        for m in &test.modes {
            match &m.shape_sd {
                Some(own) => sd.extend(own.iter().copied()),
                None => sd.extend(std::iter::repeat_n(f64::NAN, n)),
            }
        }
        let rows = stand_in.observed(&rows_of(&observation_matrix(model, &test.sensors)?));
        Ok(Self([
            test.modes.iter().map(|m| m.frequency_hz.value).collect(),
            test.modes.iter().map(|m| m.frequency_hz.sd).collect(),
            shapes,
            sd,
            rows.row_iter().flat_map(|r| r.iter().copied().collect::<Vec<_>>()).collect(),
        ]))
    }
}
