//! Frequencies and components of mode shapes that an optimisation asks for, as a test file.

use super::names::node;
use crate::report::ImportReport;
use crate::text::{computed, direction};
use retune::deck::Deck;
use retune::modal::SolveOptions;
use retune::model::{Model, ParametricModel, lint, solve_modes};
use std::collections::BTreeMap;

/// A component of a grid, along its own displacement axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct At {
    pub grid: u32,
    /// 0 to 5.
    pub component: usize,
}

impl At {
    /// The sensor that reads it: `n12_t3`, `n12_r1`.
    fn sensor(self) -> String {
        format!("{}_{}{}", node(self.grid), if self.component < 3 { 't' } else { 'r' }, self.component % 3 + 1)
    }
}

/// A component of an eigenvector that is asked for, SI: of unit modal mass, or relative to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Component {
    pub mode: u32,
    pub at: At,
    pub relative_to: Option<At>,
    pub value: f64,
    pub half: f64,
}

/// What is asked for, modes by the solver's numbers.
#[derive(Debug, Clone, Default)]
pub(super) struct Asked {
    /// Value and half-width, Hz.
    pub frequencies: BTreeMap<u32, (f64, f64)>,
    pub components: Vec<Component>,
    /// Directions of the displacements of the grids of the components, in global axes.
    pub axes: BTreeMap<u32, [[f64; 3]; 3]>,
}

/// A frequency that nobody asks for is that of the model, with so many times itself as standard deviation: it says nothing.
const UNASKED: f64 = 1e3;

/// A test file with what is asked for, in the order of the modes; none where there is nothing.
///
/// * `model` - as the deck gives it, at its estimates: its motions without frequency are the solver's first modes
pub(super) fn test(deck: &Deck, asked: &Asked, model: Option<&Model>, report: &mut ImportReport) -> Option<String> {
    let sound = model.and_then(|model| lint(model).ok());
    let n_free = sound.map_or(0, |s| s.n_rigid_body_modes + s.n_mechanisms) as u32;
    let mut components: Vec<&Component> = Vec::new();
    for c in &asked.components {
        if c.mode > n_free {
            components.push(c);
        } else {
            report.note(format!(
                "the component {} of mode {} is left out: the mode is a motion without frequency, whose shape is any of its kind",
                c.at.sensor(),
                c.mode
            ));
        }
    }
    let unasked = components.iter().map(|c| c.mode).filter(|m| !asked.frequencies.contains_key(m)).max();
    let own = unasked.and_then(|most| {
        let model = model?;
        let options = SolveOptions { n_elastic: (most - n_free) as usize, shift: None };
        let modes = solve_modes(model, &model.parameters().nominal(), options).ok()?;
        Some(modes.elastic().map(|i| modes.frequency_hz(i)).collect::<Vec<f64>>())
    });
    let own_hz = |mode: u32| own.as_ref()?.get((mode - n_free - 1) as usize).copied();
    components.retain(|c| {
        let has_frequency = asked.frequencies.contains_key(&c.mode) || own_hz(c.mode).is_some();
        if !has_frequency {
            report.note(format!("the component {} is left out: the model has no mode {}", c.at.sensor(), c.mode));
        }
        has_frequency
    });
    let mut modes: Vec<u32> = asked.frequencies.keys().copied().chain(components.iter().map(|c| c.mode)).collect();
    modes.sort_unstable();
    modes.dedup();
    if modes.is_empty() {
        return None;
    }
    let file = deck.sources()[0].path().file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let file = crate::text::clean(&file).replace(['"', '\\'], "");
    let mut text = format!(
        "# What the optimisation of {file} asks for: goals of its objective, and the middles of its intervals with half of their width.\n\
         retune_test: 1\nname: \"targets of {file}\"\nsources:\n  deck: {{kind: measured, text: \"as DRESP1, DCONSTR and DESOBJ of {file} ask for; the deck does not say who measured them\"}}\n"
    );
    let mut sensors: BTreeMap<String, At> = BTreeMap::new();
    for at in components.iter().flat_map(|c| std::iter::once(c.at).chain(c.relative_to)) {
        sensors.insert(at.sensor(), at);
    }
    if !sensors.is_empty() {
        text.push_str("sensors:\n");
    }
    for (name, at) in &sensors {
        let Some(axes) = asked.axes.get(&at.grid) else { continue };
        let (along, kind) = (direction(axes[at.component % 3]), if at.component < 3 { "" } else { ", rotation: true" });
        text.push_str(&format!("  {name}: {{node: {}, direction: {along}{kind}}}\n", node(at.grid)));
    }
    text.push_str("modes:\n");
    for mode in modes {
        // Modes of a test are paired with elastic ones.
        let partner =
            mode.checked_sub(n_free).filter(|n| *n > 0).map_or_else(String::new, |n| format!("pair_with: {n}, "));
        let (value, half) = match asked.frequencies.get(&mode) {
            Some(known) => *known,
            None => {
                text.push_str("  # Nothing is asked of this frequency: it is that of the model, with a deviation that says nothing.\n");
                own_hz(mode).map_or((1.0, UNASKED), |hz| (hz, UNASKED * hz))
            }
        };
        text.push_str(&format!(
            "  - {{frequency: {} Hz, frequency_sd: {} Hz, {partner}source: deck",
            computed(value),
            computed(half)
        ));
        let own: Vec<String> = components.iter().filter(|c| c.mode == mode).map(|c| entry(c)).collect();
        if !own.is_empty() {
            text.push_str(&format!(",\n     components: [{}]", own.join(", ")));
        }
        text.push_str("}\n");
    }
    Some(text)
}

fn entry(c: &Component) -> String {
    let relative = c.relative_to.map_or_else(String::new, |r| format!("relative_to: {}, ", r.sensor()));
    format!("{{sensor: {}, {relative}value: {}, sd: {}}}", c.at.sensor(), computed(c.value), computed(c.half))
}
