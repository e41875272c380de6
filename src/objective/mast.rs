//! A mast with double modes, for tests.

use crate::correlation::{PairBy, PairingOptions};
use crate::data::{Sensor, read_test};

/// Of round section, with a mass at its tip.
pub(super) const MAST: &str = "
retune: 1
name: mast
parameters:
  E: {value: 205 GPa, bounds: [170 GPa, 230 GPa]}
  tip: {value: 2 kg, bounds: [1 kg, 4 kg]}
nodes: {n0: [0, 0, 0], n1: [0, 0, 0.5], n2: [0, 0, 1], n3: [0, 0, 1.5], n4: [0, 0, 2]}
sections: {tube: {E: E, nu: 0.3, density: 7850 kg/m3, shape: {tube: {diameter: 50 mm, wall: 3 mm}}}}
beams: {mast: {chain: [n0, n1, n2, n3, n4], section: tube, subdivide: 2}}
masses: {tip: {node: n4, mass: tip}}
supports: {base: {node: n0}}
";

/// Two directions at each of its nodes.
pub(super) fn sensors() -> Vec<Sensor> {
    let sensors: String =
        (1..=4).flat_map(|k| ["x", "y"].map(|d| format!("  s{k}{d}: {{node: n{k}, direction: +{d}}}\n"))).collect();
    let text = format!(
        "retune_test: 1\nname: t\nsources: {{s: {{kind: synthetic, text: made up}}}}\nsensors:\n{sensors}modes: []\n"
    );
    read_test(&text).unwrap().0.sensors
}

/// Pairs by shapes, with open gates.
pub(super) const OPEN: PairingOptions =
    PairingOptions { by: PairBy::Mac, min_mac: 0.0, frequency_window: f64::INFINITY, same_family_only: true };
