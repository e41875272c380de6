//! The limits that a user sets, and why a mode has no partner, in words.

use crate::objective::comparison::Comparison;
use crate::objective::prediction::Prediction;

/// A probability as people read it.
pub(super) fn probability(p: f64) -> String {
    if p > 0.999 { "above 0.999".into() } else { format!("{p:.3}") }
}

/// How a sentence speaks of a mode of the model.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Told<'a> {
    /// Its name.
    pub(super) name: Option<&'a str>,
    /// Whether the parameters have moved from the estimates, and with them its frequency.
    pub(super) fitted: bool,
}

impl Told<'_> {
    fn at(self, f: f64) -> String {
        if self.fitted { format!("{} in the fitted model", hz(f)) } else { hz(f) }
    }

    /// The mode in a sentence.
    pub(super) fn called(self, p: &Prediction, a: usize) -> String {
        let f = self.at(p.frequencies_hz[a]);
        self.name.map_or_else(
            || {
                if self.fitted {
                    format!("mode {} at {f}", a + 1)
                } else {
                    format!("mode {} of the model at {f}", a + 1)
                }
            },
            |name| format!("`{name}` at {f}"),
        )
    }
}

/// A number with four digits at least.
fn plain(v: f64) -> String {
    let digits = (3 - v.abs().max(1e-12).log10().floor() as i32).clamp(0, 6) as usize;
    let text = format!("{v:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
}

fn hz(f: f64) -> String {
    format!("{} Hz", plain(f))
}

/// The limits of a user.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Gates {
    pub(super) min_mac: f64,
    pub(super) window: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Gate {
    /// The frequency window.
    Window,
    /// The smallest MAC.
    Mac,
}

impl Gates {
    /// Whether there are none.
    pub(super) fn is_open(self) -> bool {
        self.min_mac <= 0.0 && self.window == f64::INFINITY
    }

    /// Which of them a pair does not pass.
    pub(super) fn closed(self, c: &Comparison<'_>, p: &Prediction, test_mode: usize, a: usize) -> Option<Gate> {
        let mode = &c.test().modes[test_mode];
        let (f_a, f_x) = (p.frequencies_hz[a], mode.frequency_hz.value);
        if f_a.max(f_x) > (1.0 + self.window) * f_a.min(f_x) {
            return Some(Gate::Window);
        }
        (mode.shape.is_some() && p.mac[(a, test_mode)] < self.min_mac).then_some(Gate::Mac)
    }
}

impl Gate {
    pub(super) fn reason(
        self,
        gates: &Gates,
        c: &Comparison<'_>,
        p: &Prediction,
        test_mode: usize,
        a: usize,
        told: Told<'_>,
    ) -> String {
        let f = c.test().modes[test_mode].frequency_hz.value;
        match self {
            Self::Window => format!(
                "outside the frequency window of {} %: {} against {}; `--frequency-window` widens it",
                plain(100.0 * gates.window),
                hz(f),
                told.at(p.frequencies_hz[a])
            ),
            Self::Mac => format!(
                "its largest MAC is {:.2}, with {}, below {}; `--min-mac` lowers the limit",
                p.mac[(a, test_mode)],
                told.called(p, a),
                gates.min_mac
            ),
        }
    }
}

/// Why the rule and the gates of a comparison leave a measured mode without a partner, where nothing else tells.
pub(crate) fn why_unpaired(c: &Comparison<'_>, p: &Prediction, test_mode: usize) -> String {
    let mode = &c.test().modes[test_mode];
    let f = mode.frequency_hz.value;
    let likeness = |a: usize| match &mode.shape {
        Some(_) => p.mac[(a, test_mode)],
        None => -(p.frequencies_hz[a] / f).ln().abs(),
    };
    let n = p.frequencies_hz.len();
    let Some(a) = (0..n).max_by(|&a, &b| likeness(a).total_cmp(&likeness(b))) else {
        return "the model has no mode to compare with".into();
    };
    let gates = Gates { min_mac: c.pairing().min_mac, window: c.pairing().frequency_window };
    if let Some(gate) = gates.closed(c, p, test_mode, a) {
        return gate.reason(&gates, c, p, test_mode, a, Told::default());
    }
    match p.pairs.pairs.iter().find(|q| q.analytical == a) {
        Some(q) => format!("{} is the partner of test mode {}", Told::default().called(p, a), q.experimental + 1),
        None if mode.shape.is_none() && c.has_shapes() => {
            "it has no shape, and this rule pairs by shapes; `--pairing probable` uses frequency and label too".into()
        }
        None => format!("{} is of another symmetry than its label tells", Told::default().called(p, a)),
    }
}
