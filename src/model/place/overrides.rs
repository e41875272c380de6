//! Groups, and changes of single elements or groups against their sections.

use super::Placer;
use crate::catalogue::did_you_mean;
use crate::model::inside::why_none;
use crate::model::spec::OverrideSpec;
use crate::model::value::{Affine, Value};
use crate::yaml::child;
use std::collections::BTreeSet;
use std::sync::Arc;

impl Placer<'_> {
    pub(super) fn groups(&mut self) {
        for (name, members) in &self.spec.groups {
            let path = child("groups", name);
            if !self.claim(name, &path) {
                continue;
            }
            let mut all = Vec::new();
            let mut stretches: Vec<Vec<usize>> = Vec::new();
            for (i, member) in members.iter().enumerate() {
                match self.set(member) {
                    Some(set) if member != name => {
                        all.extend(set);
                        stretches.extend(self.stretches(member));
                    }
                    _ => {
                        let suggestion = self.suggestion(member);
                        self.error(
                            format!("{path}[{i}]"),
                            format_args!("`{member}` is not an element, chain, mass or earlier group{suggestion}"),
                        );
                    }
                }
            }
            all.sort_unstable();
            all.dedup();
            self.sets.insert(name.clone(), all);
            self.stretches.insert(name.clone(), stretches);
        }
    }

    pub(super) fn overrides(&mut self) {
        for (name, change) in &self.spec.overrides {
            let path = child("overrides", name);
            let targets: Vec<(String, &str)> = if change.of.is_empty() {
                vec![(path.clone(), name)]
            } else {
                change.of.iter().enumerate().map(|(i, n)| (format!("{path}.of[{i}]"), n.as_str())).collect()
            };
            let (mut sets, mut names) = (Vec::new(), Vec::new());
            for (at, target) in targets {
                if let Some(set) = self.set(target) {
                    sets.push(set);
                    names.push(target);
                } else {
                    let suggestion = self.suggestion(target);
                    let hint = if change.of.is_empty() { "; or name what it changes with `of: [...]`" } else { "" };
                    self.error(
                        at,
                        format_args!("`{target}` is not an element, chain, mass or group{suggestion}{hint}"),
                    );
                }
            }
            let mut elements: Vec<usize> = sets.iter().flatten().copied().collect();
            elements.sort_unstable();
            elements.dedup();
            if !elements.is_empty() {
                self.override_properties(change, &path, &names, &elements);
                self.override_factors(change, &path, &elements);
                self.taper(change, &path, &sets);
            }
        }
    }

    /// What may have been meant by a name that nothing has, as the end of a sentence.
    fn suggestion(&self, name: &str) -> String {
        why_none(&self.sets, name)
            .map_or_else(|| did_you_mean(name, self.sets.keys().map(String::as_str)), |why| format!("; {why}"))
    }

    /// Whether any of the elements has the property; if not, an error.
    pub(super) fn any_has(&mut self, elements: &[usize], property: &str, path: &str) -> bool {
        let known = || elements.iter().flat_map(|&e| self.elements[e].kind.properties()).map(|p| p.name);
        if !known().any(|name| name == property) {
            let known: BTreeSet<&str> = known().collect();
            let suggestion = did_you_mean(property, known);
            self.error(path, format_args!("these elements have no property `{property}`{suggestion}"));
            return false;
        }
        true
    }

    pub(super) fn override_properties(
        &mut self,
        change: &OverrideSpec,
        path: &str,
        names: &[&str],
        elements: &[usize],
    ) {
        for (what, given) in [("set", &change.set), ("scale", &change.scale), ("add", &change.add)] {
            for (property, scalar) in given {
                let path = format!("{path}.{what}.{property}");
                if !self.any_has(elements, property, &path) {
                    continue;
                }
                // Elements of one type have one unit.
                let mut last: Option<(&str, Affine)> = None;
                for e in self.acted_on(names, elements, property) {
                    let kind = self.elements[e].kind;
                    let Some(i) = kind.properties().iter().position(|p| p.name == property) else { continue };
                    let unit = if what == "scale" { "1" } else { kind.properties()[i].unit };
                    let before = self.problems.len();
                    let known = last.as_ref().filter(|last| last.0 == unit).map(|last| last.1.clone());
                    let Some(affine) = known.or_else(|| self.affine(scalar, unit, &path)) else {
                        self.problems.truncate(before + 1);
                        break;
                    };
                    last = Some((unit, affine.clone()));
                    match (what, &mut Arc::make_mut(&mut self.elements[e].values)[i]) {
                        ("set", value) => *value = Some(Value::of(affine)),
                        // What is absent counts as zero, which every property with that meaning has as its default.
                        ("add", value) => value.get_or_insert(Value::constant(0.0)).addends.push(affine),
                        (_, Some(value)) => value.factors.push(affine),
                        (_, None) => self.error(
                            &path,
                            format_args!("element `{}` has no `{property}` to scale", self.elements[e].name.clone()),
                        ),
                    }
                }
            }
        }
    }

    pub(super) fn override_factors(&mut self, change: &OverrideSpec, path: &str, elements: &[usize]) {
        for (word, unit, given) in [
            ("stiffness", "1", &change.stiffness),
            ("mass", "1", &change.mass),
            ("stiffness_damping", "s", &change.stiffness_damping),
            ("mass_damping", "1/s", &change.mass_damping),
        ] {
            let Some(given) = given else { continue };
            let Some(affine) = self.affine(given, unit, &child(path, word)) else { continue };
            for &e in elements {
                let element = &mut self.elements[e];
                match word {
                    "stiffness" => element.stiffness_factor.get_or_insert_default().factors.push(affine.clone()),
                    "mass" => element.mass_factor.get_or_insert_default().factors.push(affine.clone()),
                    "stiffness_damping" => add_to(&mut element.stiffness_damping, affine.clone()),
                    _ => add_to(&mut element.mass_damping, affine.clone()),
                }
            }
        }
    }

    /// Factors 1 + t s at the middle of each element, s from -1 at the start of each named chain to +1 at its end.
    pub(super) fn taper(&mut self, change: &OverrideSpec, path: &str, sets: &[Vec<usize>]) {
        for (what, scalar) in &change.taper {
            let path = format!("{path}.taper.{what}");
            let whole = matches!(what.as_str(), "stiffness" | "mass");
            if !whole && !self.any_has(&sets.concat(), what, &path) {
                continue;
            }
            let Some(slope) = self.affine(scalar, "1", &path) else { continue };
            for set in sets {
                let span = |e: usize| {
                    self.elements[e].points.get(1).map_or(0.0, |p| crate::model::geometry::dot(*p, *p).sqrt())
                };
                let lengths: Vec<f64> = set.iter().map(|&e| span(e)).collect();
                let total: f64 = lengths.iter().sum();
                if total <= 0.0 {
                    self.error(&path, "a taper needs a chain of beams or bars");
                    continue;
                }
                let mut before = 0.0;
                for (&e, length) in set.iter().zip(lengths) {
                    let s = (2.0 * before + length) / total - 1.0;
                    before += length;
                    let factor = Affine {
                        constant: 1.0 + s * slope.constant,
                        terms: slope.terms.iter().map(|(i, f)| (*i, s * f)).collect(),
                    };
                    let element = &mut self.elements[e];
                    let property = element.kind.properties().iter().position(|p| p.name == what);
                    match (what.as_str(), property) {
                        ("stiffness", _) => element.stiffness_factor.get_or_insert_default().factors.push(factor),
                        ("mass", _) => element.mass_factor.get_or_insert_default().factors.push(factor),
                        (_, Some(i)) => {
                            if let Some(value) = &mut Arc::make_mut(&mut element.values)[i] {
                                value.factors.push(factor);
                            } else {
                                let name = element.name.clone();
                                self.error(&path, format_args!("element `{name}` has no `{what}` to taper"));
                            }
                        }
                        _ => {}
                    }
                }
            }
        }
    }
}

/// Adds to a value that is zero where it is absent.
fn add_to(value: &mut Option<Value>, affine: Affine) {
    value.get_or_insert(Value::constant(0.0)).addends.push(affine);
}
