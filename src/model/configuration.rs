//! Variants of one structure: other boundary conditions by name, and hidden changes by an overlay.

use super::loose::{drop_loose, member_number};
use super::spec::{ConfigurationSpec, ModelSpec, Named};
use super::superelement::have_same_source;
use crate::catalogue::did_you_mean;
use crate::yaml::{self, Problem, child};
use serde_json::Value;
use std::collections::HashSet;

impl ModelSpec {
    /// The structure under other boundary conditions: what `without` names is gone, with the masses, springs and links that hang
    /// on nothing else; the supports, springs, masses and overrides of the configuration are there.
    ///
    /// Parameters, nodes and sections stay, so θ means the same in every configuration. When something that may carry mass is
    /// taken away or put there, the targets of mass properties are dropped: they hold for the base model.
    ///
    /// * `name` - a key of `configurations`
    ///
    /// # Errors
    /// An unknown configuration; a name in `without` that is nowhere; an addition whose name is taken.
    pub fn configured(&self, name: &str) -> Result<ModelSpec, Problem> {
        let Some(configuration) = self.configurations.get(name) else {
            let known = self.configurations.keys().map(String::as_str);
            let suggestion = did_you_mean(name, known.clone());
            let list: Vec<&str> = known.collect();
            let list = if list.is_empty() { "none".to_string() } else { list.join(", ") };
            let text = format!("the model has no configuration `{name}` (it has: {list}){suggestion}");
            return Err(Problem::error("configurations", text));
        };
        let mut base = self.clone();
        base.configurations.clear();
        base.with_configuration(name, configuration)
    }

    /// * `self` - the base model
    fn with_configuration(&self, name: &str, configuration: &ConfigurationSpec) -> Result<ModelSpec, Problem> {
        let path = child("configurations", name);
        let mut spec = self.clone();
        spec.name = format!("{}, {name}", self.name);
        let mut changes_mass = !configuration.masses.is_empty();
        for (i, gone) in configuration.without.iter().enumerate() {
            let carries_mass = spec.remove(gone).ok_or_else(|| {
                let suggestion = did_you_mean(gone, self.removable());
                let text = format!(
                    "`{gone}` is not a support, spring, bushing, mass, rigid link, constraint, beam, bar, element, superelement or override{suggestion}"
                );
                Problem::error(format!("{path}.without[{i}]"), text)
            })?;
            changes_mass |= carries_mass;
        }
        let ConfigurationSpec { supports, springs, masses, overrides, .. } = configuration;
        if !configuration.without.is_empty() {
            changes_mass |= drop_loose(&mut spec, self);
        }
        add(&mut spec.supports, supports, &child(&path, "supports"))?;
        add(&mut spec.springs, springs, &child(&path, "springs"))?;
        add(&mut spec.masses, masses, &child(&path, "masses"))?;
        add(&mut spec.overrides, overrides, &child(&path, "overrides"))?;
        if changes_mass {
            spec.targets = None;
        }
        Ok(spec)
    }

    /// The model with a partial model file laid over it: maps are merged key by key, anything else is replaced.
    ///
    /// A hidden effect of a virtual test is such a file: `masses: {ballast: {node: n8, mass: 50 g}}`.
    ///
    /// * `patch` - text of the partial file
    ///
    /// # Errors
    /// YAML that is not well formed; a merged model that is not a model.
    pub fn overlaid(&self, patch: &str) -> Result<ModelSpec, Vec<Problem>> {
        let (patch, map) = yaml::read::<Value>(patch)?;
        if !patch.is_object() {
            return Err(vec![Problem::error("", "a patch is a map with keys of a model file")]);
        }
        let failed =
            |e: serde_json::Error| vec![Problem::error("", format_args!("the patched model is not a model: {e}"))];
        let mut whole = serde_json::to_value(self).map_err(failed)?;
        merge(&mut whole, patch);
        // A mistake of the whole is shown where the patch makes it.
        let (mut spec, _) = yaml::read::<ModelSpec>(&yaml::write(&whole))
            .map_err(|problems| map.place(problems.into_iter().map(|p| Problem { location: None, ..p }).collect()))?;
        // What was read from files stays, where the patch names the same.
        if let (Some(entry), Some(own)) = (&mut spec.mesh, &self.mesh)
            && (&entry.file, &entry.units) == (&own.file, &own.units)
        {
            entry.loaded = own.loaded.clone();
        }
        for (name, entry) in &mut spec.superelements {
            if let Some(own) = self.superelements.get(name).filter(|own| have_same_source(own, entry)) {
                entry.loaded = own.loaded.clone();
            }
        }
        Ok(spec)
    }

    /// Takes one entry away; whether it may have carried mass, or `None` when there is none of that name.
    fn remove(&mut self, name: &str) -> Option<bool> {
        let was_massless = self.supports.shift_remove(name).is_some()
            || self.springs.shift_remove(name).is_some()
            || self.bushings.shift_remove(name).is_some()
            || self.node_offsets.shift_remove(name).is_some()
            || self.rigid_links.shift_remove(name).is_some()
            || self.weighted_links.shift_remove(name).is_some()
            || self.ties.shift_remove(name).is_some()
            || self.constraints.shift_remove(name).is_some();
        if was_massless {
            self.forget(|n| (n != name).then(|| n.to_string()));
            return Some(false);
        }
        let had_mass = self.masses.shift_remove(name).is_some()
            || self.beams.shift_remove(name).is_some()
            || self.bars.shift_remove(name).is_some()
            || self.superelements.shift_remove(name).is_some()
            || self.elements.shift_remove(name).is_some();
        if had_mass {
            self.forget(|n| (n != name && member_number(n, name).is_none()).then(|| n.to_string()));
            return Some(true);
        }
        self.overrides.shift_remove(name).map(|_| true)
    }

    /// Renames what overrides and groups name, and takes out what has no name any more.
    pub(super) fn forget(&mut self, rename: impl Fn(&str) -> Option<String>) {
        let overrides = std::mem::take(&mut self.overrides);
        for (name, mut entry) in overrides {
            if entry.of.is_empty() {
                if let Some(name) = rename(&name) {
                    self.overrides.insert(name, entry);
                }
                continue;
            }
            entry.of = entry.of.iter().filter_map(|n| rename(n)).collect();
            if !entry.of.is_empty() {
                self.overrides.insert(name, entry);
            }
        }
        for members in self.groups.values_mut() {
            *members = members.iter().filter_map(|n| rename(n)).collect();
        }
        self.groups.retain(|_, members| !members.is_empty());
    }

    fn removable(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        names.extend(self.supports.keys().map(String::as_str));
        names.extend(self.springs.keys().map(String::as_str));
        names.extend(self.bushings.keys().map(String::as_str));
        names.extend(self.node_offsets.keys().map(String::as_str));
        names.extend(self.rigid_links.keys().map(String::as_str));
        names.extend(self.weighted_links.keys().map(String::as_str));
        names.extend(self.ties.keys().map(String::as_str));
        names.extend(self.constraints.keys().map(String::as_str));
        names.extend(self.masses.keys().map(String::as_str));
        names.extend(self.beams.keys().map(String::as_str));
        names.extend(self.bars.keys().map(String::as_str));
        names.extend(self.elements.keys().map(String::as_str));
        names.extend(self.superelements.keys().map(String::as_str));
        names.extend(self.overrides.keys().map(String::as_str));
        names
    }
}

/// Checks what the configurations of a file take away and put there; their elements are checked when one is built.
pub(super) fn check(spec: &ModelSpec, problems: &mut Vec<Problem>) {
    if spec.configurations.is_empty() {
        return;
    }
    let removable: HashSet<&str> = spec.removable().into_iter().collect();
    let mut base = spec.clone();
    base.configurations.clear();
    for (name, configuration) in &spec.configurations {
        let ConfigurationSpec { without, supports, springs, masses, overrides, .. } = configuration;
        let distinct: HashSet<&String> = without.iter().collect();
        let is_known = distinct.len() == without.len() && without.iter().all(|n| removable.contains(n.as_str()));
        // With what is taken away go the overrides of it: of several names one may be gone already.
        let is_known = is_known && (without.len() < 2 || !without.iter().any(|n| spec.overrides.contains_key(n)));
        let is_new = !supports.keys().any(|n| spec.supports.contains_key(n))
            && !springs.keys().any(|n| spec.springs.contains_key(n))
            && !masses.keys().any(|n| spec.masses.contains_key(n))
            && !overrides.keys().any(|n| spec.overrides.contains_key(n));
        // Names that are there to be taken away, and others that are free, need no copy of the model to be right.
        if !(is_known && is_new) {
            problems.extend(base.with_configuration(name, configuration).err());
        }
    }
}

fn add<T: Clone>(to: &mut Named<T>, from: &Named<T>, path: &str) -> Result<(), Problem> {
    for (name, entry) in from {
        if to.contains_key(name) {
            let text = "the model has one of this name; take it away under `without`, or choose another name";
            return Err(Problem::error(child(path, name), text));
        }
        to.insert(name.clone(), entry.clone());
    }
    Ok(())
}

fn merge(to: &mut Value, from: Value) {
    match (to, from) {
        (Value::Object(to), Value::Object(from)) => {
            for (key, value) in from {
                match to.get_mut(&key) {
                    Some(there) => merge(there, value),
                    None => {
                        to.insert(key, value);
                    }
                }
            }
        }
        (to, from) => *to = from,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modal::{SolveOptions, solve};
    use crate::model::{Model, ParametricModel, Registry, load_configuration};

    const TEXT: &str = "
retune: 1
name: beam
active_dofs: [uz, ry]
parameters: {EI: {value: 1.0, bounds: [0.5, 2.0]}}
nodes: {a: [0, 0, 0], b: [0.5, 0, 0], c: [1, 0, 0]}
beams:
  span: {chain: [a, b, c], properties: {E: EI, Iy: 1, mass_per_length: 1}, subdivide: 8}
supports: {left: {node: a}}
masses: {tip: {node: c, mass: 1.0}}
targets: {total_mass: {value: 2 kg, tolerance: 1 kg}}
configurations:
  bare: {without: [tip]}
  free: {without: [left, tip]}
  pinned: {without: [left, tip], supports: {ends: {nodes: [a, c], fixed: [uz]}}}
";

    /// With configurations that cannot be built.
    fn with_wrong(entry: &str) -> String {
        format!("{TEXT}  {entry}\n")
    }

    fn first_hz(configuration: Option<&str>) -> f64 {
        let (model, _, _) = load_configuration(TEXT, configuration, &Registry::builtin()).unwrap();
        let system = model.assemble(&model.parameters().nominal()).unwrap();
        let options = SolveOptions { n_elastic: 1, shift: None };
        let modes = solve(&system.stiffness, &system.mass, &model.dof_map().rigid_motions(), options).unwrap();
        modes.frequency_hz(modes.n_rigid)
    }

    /// βL of the first mode: clamped 1.8751041, free 4.7300407, pinned π; f = (βL)²/2π for EI = m = L = 1.
    #[test]
    fn supports_are_changed_and_masses_taken_away() {
        for (name, beta) in [("bare", 1.875_104_068_7), ("free", 4.730_040_744_9), ("pinned", std::f64::consts::PI)] {
            let exact = beta * beta / std::f64::consts::TAU;
            // 16 cubic elements: relative error of the order of (βL/16)⁴/720.
            assert!((first_hz(Some(name)) / exact - 1.0).abs() < 2.0e-5, "{name}: {}", first_hz(Some(name)));
        }
        assert!(first_hz(None) < 0.6 * first_hz(Some("bare")));
    }

    #[test]
    fn unknown_and_taken_names_are_refused_with_the_nearest() {
        let problems = load_configuration(TEXT, Some("fre"), &Registry::builtin()).unwrap_err();
        assert!(problems[0].message.contains("did you mean `free`"), "{}", problems[0].message);
        let text = with_wrong("wrong: {without: [tipp]}");
        let problems = load_configuration(&text, Some("wrong"), &Registry::builtin()).unwrap_err();
        assert!(problems[0].message.contains("did you mean `tip`"), "{}", problems[0].message);
        assert!(problems[0].location.is_some());
        let text = with_wrong("twice: {supports: {left: {node: c}}}");
        let problems = crate::model::load(&text, &Registry::builtin()).unwrap_err();
        assert!(problems[0].message.contains("without"), "{}", problems[0].message);
    }

    #[test]
    fn targets_hold_for_the_base_model_only() {
        let (spec, _) = yaml::read::<ModelSpec>(TEXT).unwrap();
        assert!(spec.configured("bare").unwrap().targets.is_none());
        assert!(spec.targets.is_some());
    }

    #[test]
    fn an_overlay_adds_and_replaces() {
        let (spec, _) = yaml::read::<ModelSpec>(TEXT).unwrap();
        let patched = spec.overlaid("masses: {tip: {mass: 3.0}, middle: {node: b, mass: 0.5}}").unwrap();
        assert_eq!(patched.masses.len(), 2);
        assert_eq!(patched.masses["tip"].node.as_deref(), Some("c"));
        assert!(Model::new(patched, &Registry::builtin()).is_ok());
        assert!(spec.overlaid("masses: {tip: {masss: 3.0}}").is_err());
        assert!(spec.overlaid("[1]").is_err());
    }

    /// Two wings on a body; on the bench the right one is not there, with what hangs on it and on nothing else.
    #[test]
    fn what_hangs_on_nothing_goes_with_the_part_that_held_it() {
        let text = "
retune: 1
name: wings
active_dofs: [uz, rx]
nodes: {c: [0, 0, 0], l: [0, -1, 0], r: [0, 1, 0], store: [0, 1, 0], pod: [0, 1.2, 0]}
beams:
  left: {nodes: [c, l], properties: {E: 1, Iy: 1, mass_per_length: 1}}
  right: {nodes: [c, r], properties: {E: 1, Iy: 1, mass_per_length: 1}}
masses:
  tips: {nodes: [r, l], mass: 1}
  store: {node: store, mass: 0.1}
  pod: {node: pod, mass: 0.2}
springs: {strut: {nodes: [r, store], k: {uz: 1}}, cord: {node: r, k: {uz: 1}}}
rigid_links: {pylon: {master: r, slaves: [pod]}}
overrides:
  right: {stiffness: 2}
  heavy: {of: [tips.1, tips.2], mass: 2}
  tips.1: {mass: 3}
groups: {all: [left, right, tips.1, tips.2], gone: [right, store]}
configurations:
  bench: {without: [right], supports: {held: {node: c}}}
";
        let (spec, _) = yaml::read::<ModelSpec>(text).unwrap();
        let bench = spec.configured("bench").unwrap();
        assert_eq!(bench.masses.keys().collect::<Vec<_>>(), ["tips"]);
        assert_eq!(bench.masses["tips"].nodes.as_deref().unwrap(), ["l"]);
        assert!(bench.springs.is_empty() && bench.rigid_links.is_empty());
        assert_eq!(bench.overrides.keys().collect::<Vec<_>>(), ["heavy"]);
        assert_eq!(bench.overrides["heavy"].of, ["tips.1"]);
        assert_eq!(bench.groups.keys().collect::<Vec<_>>(), ["all"]);
        assert_eq!(bench.groups["all"], ["left", "tips.1"]);
        let (model, _) = Model::new(bench, &Registry::builtin()).unwrap();
        let system = model.assemble(&model.parameters().nominal()).unwrap();
        let options = SolveOptions { n_elastic: 2, shift: None };
        let modes = solve(&system.stiffness, &system.mass, &model.dof_map().rigid_motions(), options).unwrap();
        assert_eq!((modes.n_rigid, modes.n_mechanism), (0, 0));
    }
}
