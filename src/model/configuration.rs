//! Other boundary conditions of the same structure: `configurations` of the file, as the test file names them.

use super::spec::{ConfigurationSpec, ModelSpec};
use crate::catalogue::did_you_mean;
use crate::yaml::{Problem, child};

impl ModelSpec {
    /// The file in one of its configurations: what that takes away is gone, what it puts there is there.
    ///
    /// `None` if there is no such configuration.
    pub fn in_configuration(&self, name: &str) -> Option<ModelSpec> {
        let change = self.configurations.get(name)?;
        let mut spec = self.clone();
        spec.configurations.clear();
        for gone in &change.without {
            spec.supports.shift_remove(gone);
            spec.springs.shift_remove(gone);
            spec.bushings.shift_remove(gone);
            spec.masses.shift_remove(gone);
            spec.rigid_links.shift_remove(gone);
            spec.constraints.shift_remove(gone);
            spec.beams.shift_remove(gone);
            spec.bars.shift_remove(gone);
            spec.elements.shift_remove(gone);
            spec.overrides.shift_remove(gone);
            spec.groups.values_mut().for_each(|members| members.retain(|m| m != gone));
        }
        spec.supports.extend(change.supports.clone());
        spec.springs.extend(change.springs.clone());
        spec.masses.extend(change.masses.clone());
        Some(spec)
    }

    /// "; did you mean `x`?" among the configurations, or nothing.
    pub fn nearest_configuration(&self, name: &str) -> String {
        did_you_mean(name, self.configurations.keys().map(String::as_str))
    }
}

/// Checks what configurations name; their elements are checked when one is built.
pub(super) fn check(spec: &ModelSpec, problems: &mut Vec<Problem>) {
    let rooms = |name: &String| {
        spec.supports.contains_key(name)
            || spec.springs.contains_key(name)
            || spec.bushings.contains_key(name)
            || spec.masses.contains_key(name)
            || spec.rigid_links.contains_key(name)
            || spec.constraints.contains_key(name)
            || spec.beams.contains_key(name)
            || spec.bars.contains_key(name)
            || spec.elements.contains_key(name)
    };
    for (name, configuration) in &spec.configurations {
        let path = child("configurations", name);
        for (i, gone) in configuration.without.iter().enumerate() {
            if !rooms(gone) {
                let known = spec.supports.keys().chain(spec.springs.keys()).chain(spec.bushings.keys());
                let known =
                    known.chain(spec.masses.keys()).chain(spec.rigid_links.keys()).chain(spec.constraints.keys());
                let known = known.chain(spec.beams.keys()).chain(spec.bars.keys()).chain(spec.elements.keys());
                let suggestion = did_you_mean(gone, known.map(String::as_str));
                problems.push(Problem::error(
                    format!("{path}.without[{i}]"),
                    format_args!("`{gone}` is no support, spring, mass, link, constraint or element{suggestion}"),
                ));
            }
        }
        taken(spec, configuration, &path, problems);
    }
}

/// A name that stands already must be taken away before it is used again.
fn taken(spec: &ModelSpec, configuration: &ConfigurationSpec, path: &str, problems: &mut Vec<Problem>) {
    let stands = |exists: bool, name: &String| exists && !configuration.without.contains(name);
    let names = (configuration.supports.keys().map(|n| ("supports", n, spec.supports.contains_key(n))))
        .chain(configuration.springs.keys().map(|n| ("springs", n, spec.springs.contains_key(n))))
        .chain(configuration.masses.keys().map(|n| ("masses", n, spec.masses.contains_key(n))));
    for (room, name, exists) in names {
        if stands(exists, name) {
            problems.push(Problem::error(
                format!("{path}.{room}.{name}"),
                format_args!("`{name}` is there already; name it under `without` to replace it"),
            ));
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::model::{Model, ModelSpec, ParametricModel, Registry};

    const TEXT: &str = "\
retune: 1
name: bench and free flight
active_dofs: [uz, ry]
nodes: {a: [0, 0, 0], b: [1, 0, 0]}
beams: {beam: {nodes: [a, b], properties: {EIy: 1, mass_per_length: 1}}}
supports: {clamp: {node: a}}
configurations:
  free: {without: [clamp], masses: {ballast: {node: b, mass: 2 kg}}}
  wrong: {without: [clmap], supports: {clamp: {node: b}}}
";

    #[test]
    fn a_configuration_takes_away_and_adds() {
        let text: String = TEXT.lines().filter(|l| !l.contains("wrong")).map(|l| format!("{l}\n")).collect();
        let spec: ModelSpec = crate::yaml::read(&text).unwrap().0;
        let free = spec.in_configuration("free").unwrap();
        let (bench, _) = Model::new(spec.clone(), &Registry::builtin()).unwrap();
        let (free, _) = Model::new(free, &Registry::builtin()).unwrap();
        assert_eq!((bench.dof_map().n_dof(), free.dof_map().n_dof()), (2, 4));
        let mass = |m: &Model| m.mass_properties(&[]).unwrap().unwrap().mass;
        assert!((mass(&bench) - 1.0).abs() < 1e-14 && (mass(&free) - 3.0).abs() < 1e-14);
        assert_eq!(spec.in_configuration("fre"), None);
        assert_eq!(spec.nearest_configuration("fre"), "; did you mean `free`?");
    }

    #[test]
    fn what_a_configuration_names_must_be_there() {
        let problems = crate::model::load(TEXT, &Registry::builtin()).unwrap_err();
        let said: Vec<String> = problems.iter().map(|p| p.render("f")).collect();
        assert_eq!(
            said,
            [
                "f:9:21: error: configurations.wrong.without[0]: `clmap` is no support, spring, mass, link, constraint or element; did you mean `clamp`?",
                "f:9:40: error: configurations.wrong.supports.clamp: `clamp` is there already; name it under `without` to replace it",
            ]
        );
    }
}
