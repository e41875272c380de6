//! The contract of every element of the catalogue, and that the contract notices what it is meant to notice.

use super::conformance::{Breach, check};
use super::*;

#[test]
fn every_element_conforms() {
    for element in ELEMENTS {
        if let Err(breaches) = check(*element) {
            let lines: Vec<String> = breaches.iter().map(Breach::to_string).collect();
            panic!("{}:\n{}", element.name(), lines.join("\n"));
        }
    }
}

#[test]
fn names_are_unique_and_sorted() {
    assert!(ELEMENTS.is_sorted_by(|a, b| a.name() < b.name()));
    assert_eq!(by_name("beam").map(Element::name), Some("beam"));
    assert!(by_name("shell").is_none());
}

/// A spring across the line between two nodes, with one flaw at a time.
#[derive(Debug)]
enum Flawed {
    GroundsRotation,
    WrongUnit,
    WrongMass,
    NegativeEnergy,
    IdleProperty,
    AcceptsAnything,
}

impl Element for Flawed {
    fn name(&self) -> &'static str {
        "flawed"
    }
    fn summary(&self) -> &'static str {
        "One flaw."
    }
    fn theory(&self) -> &'static str {
        "None."
    }
    fn nodes(&self) -> &'static [&'static [Dof]] {
        &[&[Dof::Ux, Dof::Uy, Dof::Uz], &[Dof::Ux, Dof::Uy, Dof::Uz]]
    }
    fn properties(&self) -> &'static [Property] {
        const RIGHT: &[Property] = &[Property::new("k", "N/m", Domain::Positive, "stiffness")];
        const WRONG: &[Property] = &[Property::new("k", "N", Domain::Positive, "stiffness")];
        if matches!(self, Flawed::WrongUnit) { WRONG } else { RIGHT }
    }
    fn axes(&self) -> Axes {
        Axes::AlongNodes
    }
    fn stiffness(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        if !matches!(self, Flawed::AcceptsAnything) {
            input.check(self)?;
        }
        let k = input.values.first().copied().flatten().unwrap_or(1.0);
        let k = if k.is_finite() { k } else { 1.0 };
        let d = usize::from(matches!(self, Flawed::GroundsRotation));
        let mut matrix = SymMatrix::zeros(12);
        let factor = match self {
            Flawed::NegativeEnergy => -k,
            Flawed::IdleProperty => 5.0,
            _ => k,
        };
        for (i, j, sign) in [(d, d, 1.0), (6 + d, d, -1.0), (6 + d, 6 + d, 1.0)] {
            matrix.add(i, j, sign * factor);
        }
        Ok(matrix)
    }
    fn mass(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        if !matches!(self, Flawed::AcceptsAnything) {
            input.check(self)?;
        }
        Ok(SymMatrix::zeros(12))
    }
    fn samples(&self) -> Vec<Sample> {
        let mass = if matches!(self, Flawed::WrongMass) { 1.0 } else { 0.0 };
        vec![Sample { points: vec![[0.0; 3], [2.0, 0.0, 0.0]], given: vec![("k", 3.0)], mass, free: true }]
    }
}

#[test]
fn each_flaw_breaks_its_rule() {
    for (flaw, rule) in [
        (Flawed::GroundsRotation, "rigid motion"),
        (Flawed::WrongUnit, "units"),
        (Flawed::WrongMass, "mass"),
        (Flawed::NegativeEnergy, "definiteness"),
        (Flawed::IdleProperty, "properties"),
        (Flawed::AcceptsAnything, "refusals"),
    ] {
        let breaches = check(&flaw).unwrap_err();
        assert!(breaches.iter().any(|b| b.rule == rule), "{flaw:?}: {breaches:?}");
    }
}

/// Extreme numbers end in matrices or in an error, never in a panic: every property of every element, alone and with the
/// first sample around it, with nodes at ordinary, coincident and extreme places.
#[test]
fn no_input_panics() {
    let numbers = [0.0, -0.0, 5e-324, 1e-308, 1e-30, 1.0, -1.0, 1e30, f64::MAX, f64::INFINITY, f64::NAN];
    for element in ELEMENTS {
        let properties = element.properties();
        let count = element.nodes().len();
        let around = element.samples()[0].values(properties).unwrap();
        for start in [vec![None; properties.len()], around] {
            for (i, number) in (0..properties.len()).flat_map(|i| numbers.iter().map(move |n| (i, *n))) {
                let mut values = start.clone();
                values[i] = Some(number);
                for x in [0.5, 0.0, 1e-200, 1e200, f64::NAN] {
                    let line = [[0.0; 3], [x, 0.0, 0.0]];
                    let points: Vec<[f64; 3]> = match count {
                        1 | 2 => line[..count].to_vec(),
                        // The element itself, at extreme sizes.
                        _ => element.samples()[0].points.iter().map(|p| p.map(|v| 2.0 * x * v)).collect(),
                    };
                    let input = ElementInput { points: &points, values: &values };
                    let _ = (element.stiffness(&input), element.mass(&input), element.damping(&input));
                    let _ = (element.interpolate(&input, 0.3), element.lacks(&input));
                }
            }
        }
        for values in [&[][..], &[Some(1.0); 60]] {
            let input = ElementInput { points: &[], values };
            assert!(element.stiffness(&input).is_err() && element.interpolate(&input, 0.5).is_err() || count == 1);
            assert_eq!(element.lacks(&input), []);
        }
    }
}
