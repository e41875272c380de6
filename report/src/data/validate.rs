//! Whether the parts of a report fit together.

use super::{Carrier, Diagnosis, Floats, Levels, Live, LiveMatrix, Place, ReportData, SCHEMA, Structure};

/// Why data are not a report.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// The data are of another version.
    #[error("report data of schema {found}; this program reads and draws schema {SCHEMA}")]
    Schema {
        /// The version in the data.
        found: u32,
    },
    /// A list has the wrong length.
    #[error("`{field}` has {found} values; expected {expected} ({rule})")]
    Length {
        /// Path of the list.
        field: String,
        /// Its length.
        found: usize,
        /// The right length.
        expected: usize,
        /// Why.
        rule: &'static str,
    },
    /// An index points outside its list.
    #[error("`{field}` is {index}, but `{list}` has {len} entries, counted from 0")]
    Index {
        /// Path of the index.
        field: String,
        /// Its value.
        index: usize,
        /// The list it points into.
        list: &'static str,
        /// Length of that list.
        len: usize,
    },
    /// The data could not be written as JSON.
    #[error("the report's data cannot be written as JSON")]
    Json {
        /// What serde said.
        reason: String,
    },
}

fn length(field: String, found: usize, expected: usize, rule: &'static str) -> Result<(), ReportError> {
    if found == expected { Ok(()) } else { Err(ReportError::Length { field, found, expected, rule }) }
}

fn index(field: impl Fn() -> String, index: usize, list: &'static str, len: usize) -> Result<(), ReportError> {
    if index < len { Ok(()) } else { Err(ReportError::Index { field: field(), index, list, len }) }
}

fn shape(field: String, values: Option<&Floats>, expected: usize, rule: &'static str) -> Result<(), ReportError> {
    values.map_or(Ok(()), |v| length(field, v.len(), expected, rule))
}

fn levels(field: String, values: Option<&Levels>, expected: usize, rule: &'static str) -> Result<(), ReportError> {
    values.map_or(Ok(()), |v| length(field, v.0.len(), expected, rule))
}

impl ReportData {
    /// Checks the version, the length of every array and every index.
    ///
    /// The page also draws data that fail this check (it leaves out what does not fit); a program that fills
    /// [`ReportData`] should never fail it.
    pub fn validate(&self) -> Result<(), ReportError> {
        if self.schema != SCHEMA {
            return Err(ReportError::Schema { found: self.schema });
        }
        let empty = Structure::default();
        let s = self.structure.as_ref().unwrap_or(&empty);
        validate_structure(s)?;
        self.validate_modes(s)?;
        self.validate_comparison(s)?;
        if let Some(frfs) = &self.frfs {
            let lines = frfs.frequency_hz.len();
            for (i, c) in frfs.channels.iter().enumerate() {
                let path = |part: &str| format!("frfs.channels[{i}].{part}");
                for (part, spectrum) in [("measured", &c.measured), ("model", &c.model), ("before", &c.before)] {
                    let found = spectrum.as_ref().map_or(lines, |h| h.0.len());
                    length(path(part), found, lines, "one a frequency line")?;
                }
                shape(path("coherence"), c.coherence.as_ref(), lines, "one a frequency line")?;
                for (part, list) in [("frac", &c.frac), ("frac_before", &c.frac_before)] {
                    if !list.is_empty() {
                        length(path(part), list.len(), frfs.bands.len(), "one a band")?;
                    }
                }
                for (part, k) in [("sensor", c.sensor), ("exciter", c.exciter)] {
                    if let Some(k) = k {
                        index(|| path(part), k, "structure.sensors", s.sensors.len())?;
                    }
                }
            }
            for (part, list) in [("fdac", &frfs.fdac), ("fdac_before", &frfs.fdac_before)] {
                for (i, m) in list.iter().enumerate() {
                    matrix(&format!("frfs.{part}[{i}]"), m)?;
                }
            }
        }
        if let Some(found) = &self.identification {
            for (k, values) in found.cmif.iter().enumerate() {
                length(format!("identification.cmif[{k}]"), values.len(), found.frequency_hz.len(), "one a line")?;
            }
            for (k, d) in found.diagrams.iter().enumerate() {
                let lists = [
                    ("damping", d.damping.len()),
                    ("order", d.order.len()),
                    ("mark", d.mark.len()),
                    ("column", d.column.len()),
                ];
                for (part, n) in lists {
                    length(format!("identification.diagrams[{k}].{part}"), n, d.hz.len(), "one a pole")?;
                }
            }
        }
        if let Some(posterior) = &self.posterior {
            let (n, samples) = (posterior.parameters.len(), posterior.parameters.first().map_or(0, |p| p.values.len()));
            for (k, p) in posterior.parameters.iter().enumerate() {
                let path = |part: &str| format!("posterior.parameters[{k}].{part}");
                length(path("values"), p.values.len(), samples, "as many as the first parameter has")?;
                length(path("correlations"), p.correlations.len(), n, "one a parameter")?;
            }
        }
        if let Some(update) = &self.update {
            for (i, h) in update.histories.iter().enumerate() {
                let field = format!("update.histories[{i}].best_cost");
                length(field, h.best_cost.len(), h.evaluations.len(), "one an entry of `evaluations`")?;
            }
            if let Some(m) = &update.correlation {
                matrix("update.correlation", m)?;
            }
            for (i, m) in update.sensitivities.iter().enumerate() {
                matrix(&format!("update.sensitivities[{i}]"), m)?;
            }
        }
        if let Some(steps) = &self.steps {
            for (i, step) in steps.steps.iter().enumerate().filter(|(_, step)| !step.per_mode.is_empty()) {
                let field = format!("steps.steps[{i}].per_mode");
                length(field, step.per_mode.len(), steps.mode_labels.len(), "one a mode label")?;
            }
            for (i, step) in steps.steps.iter().enumerate().filter(|(_, step)| !step.held_out_per_mode.is_empty()) {
                let field = format!("steps.steps[{i}].held_out_per_mode");
                length(field, step.held_out_per_mode.len(), steps.mode_labels.len(), "one a mode label")?;
            }
        }
        for live in &self.live {
            validate_live(live, live.structure.as_ref().unwrap_or(s))?;
        }
        if let Some(l) = &self.localization {
            for (part, list) in [("elements", &l.elements), ("groups", &l.groups)] {
                for (i, suspect) in list.iter().enumerate() {
                    place(&format!("localization.{part}[{i}].place"), &suspect.place, s)?;
                }
            }
        }
        if let Some(d) = &self.diagnosis {
            validate_diagnosis("diagnosis", d, s)?;
        }
        for (i, d) in self.earlier_diagnoses.iter().enumerate() {
            validate_diagnosis(&format!("earlier_diagnoses[{i}]"), d, s)?;
        }
        Ok(())
    }

    fn validate_modes(&self, s: &Structure) -> Result<(), ReportError> {
        const NODAL: &str = "three a node";
        const SENSOR: &str = "one a sensor";
        let (nodal, sensors) = (3 * s.nodes.len(), s.sensors.len());
        for (i, m) in self.modes.model.iter().enumerate() {
            let path = |part: &str| format!("modes.model[{i}].{part}");
            if !m.displacement.is_empty() {
                length(path("displacement"), m.displacement.len(), nodal, NODAL)?;
            }
            levels(path("displacement_levels"), m.displacement_levels.as_ref(), nodal, NODAL)?;
            shape(path("displacement_imag"), m.displacement_imag.as_ref(), nodal, NODAL)?;
            shape(path("rotation"), m.rotation.as_ref(), nodal, NODAL)?;
            shape(path("at_sensors"), m.at_sensors.as_ref(), sensors, SENSOR)?;
            shape(path("at_sensors_imag"), m.at_sensors_imag.as_ref(), sensors, SENSOR)?;
        }
        for (i, m) in self.modes.test.iter().enumerate() {
            let path = |part: &str| format!("modes.test[{i}].{part}");
            shape(path("at_sensors"), m.at_sensors.as_ref(), sensors, SENSOR)?;
            shape(path("at_sensors_imag"), m.at_sensors_imag.as_ref(), sensors, SENSOR)?;
            shape(path("expanded"), m.expanded.as_ref(), nodal, NODAL)?;
            levels(path("expanded_levels"), m.expanded_levels.as_ref(), nodal, NODAL)?;
        }
        Ok(())
    }

    fn validate_comparison(&self, s: &Structure) -> Result<(), ReportError> {
        let Some(c) = &self.comparison else { return Ok(()) };
        let (n_model, n_test) = (self.modes.model.len(), self.modes.test.len());
        for (i, pair) in c.pairs.iter().enumerate() {
            if let Some(k) = pair.test_mode {
                index(|| format!("comparison.pairs[{i}].test_mode"), k, "modes.test", n_test)?;
            }
            if let Some(k) = pair.model_mode {
                index(|| format!("comparison.pairs[{i}].model_mode"), k, "modes.model", n_model)?;
            }
        }
        for &k in &c.unpaired_test {
            index(|| "comparison.unpaired_test".into(), k, "modes.test", n_test)?;
        }
        if !c.unpaired_reasons.is_empty() {
            let (found, expected) = (c.unpaired_reasons.len(), c.unpaired_test.len());
            length("comparison.unpaired_reasons".into(), found, expected, "one a test mode without a partner")?;
        }
        for &k in &c.unpaired_model {
            index(|| "comparison.unpaired_model".into(), k, "modes.model", n_model)?;
        }
        for (name, m) in [
            ("comparison.mac", &c.mac),
            ("comparison.mac_before", &c.mac_before),
            ("comparison.cross_orthogonality", &c.cross_orthogonality),
            ("comparison.auto_orthogonality", &c.auto_orthogonality),
        ] {
            if let Some(m) = m {
                matrix(name, m)?;
            }
        }
        for (name, values) in [("comparison.comac", &c.comac), ("comparison.comac_before", &c.comac_before)] {
            shape(name.into(), values.as_ref(), s.sensors.len(), "one a sensor")?;
        }
        Ok(())
    }
}

fn validate_structure(s: &Structure) -> Result<(), ReportError> {
    const NODES: &str = "structure.nodes";
    let n = s.nodes.len();
    for (i, e) in s.elements.iter().enumerate() {
        for &k in &e.nodes {
            index(|| format!("structure.elements[{i}].nodes"), k, NODES, n)?;
        }
        if let Some(k) = e.property_set {
            let field = || format!("structure.elements[{i}].property_set");
            index(field, k, "structure.property_sets", s.property_sets.len())?;
        }
    }
    for (i, link) in s.rigid_links.iter().enumerate() {
        for &k in link.slaves.iter().chain([&link.master]) {
            index(|| format!("structure.rigid_links[{i}]"), k, NODES, n)?;
        }
    }
    for (i, mass) in s.masses.iter().enumerate() {
        index(|| format!("structure.masses[{i}].node"), mass.node, NODES, n)?;
    }
    for (i, support) in s.supports.iter().enumerate() {
        index(|| format!("structure.supports[{i}].node"), support.node, NODES, n)?;
    }
    for (i, line) in s.trace_lines.iter().enumerate() {
        for &k in line {
            index(|| format!("structure.trace_lines[{i}]"), k, "structure.sensors", s.sensors.len())?;
        }
    }
    for (i, field) in s.fields.iter().enumerate() {
        let (expected, rule) = match field.on {
            Carrier::Elements => (s.elements.len(), "one an element"),
            Carrier::Nodes => (n, "one a node"),
            Carrier::Sensors => (s.sensors.len(), "one a sensor"),
        };
        length(format!("structure.fields[{i}].values"), field.values.len(), expected, rule)?;
    }
    Ok(())
}

fn validate_diagnosis(path: &str, d: &Diagnosis, s: &Structure) -> Result<(), ReportError> {
    for (i, h) in d.hypotheses.iter().enumerate() {
        place(&format!("{path}.hypotheses[{i}].place"), &h.place, s)?;
    }
    for (i, law) in d.damping.iter().flat_map(|d| &d.laws).enumerate() {
        place(&format!("{path}.damping.laws[{i}].place"), &law.place, s)?;
    }
    for (i, m) in d.next_measurements.iter().enumerate() {
        if let Some(p) = &m.place {
            place(&format!("{path}.next_measurements[{i}].place"), p, s)?;
        }
    }
    d.remainder_place.as_ref().map_or(Ok(()), |p| place(&format!("{path}.remainder_place"), p, s))
}

fn validate_live(live: &Live, s: &Structure) -> Result<(), ReportError> {
    let (n, n_sensors, nodal) = (live.n, s.sensors.len(), 3 * s.nodes.len());
    let triangle = n * (n + 1) / 2;
    let parameter = |field: &dyn Fn() -> String, k: usize| index(field, k, "live.parameters", live.parameters.len());
    for (i, term) in live.terms.iter().enumerate() {
        for &(k, _) in &term.powers {
            parameter(&|| format!("live.terms[{i}].powers"), k)?;
        }
        for (part, m) in [("stiffness", &term.stiffness), ("mass", &term.mass)] {
            let field = || format!("live.terms[{i}].{part}");
            match m {
                Some(LiveMatrix::Lower(v)) => {
                    length(field(), v.len(), triangle, "the rows of a lower triangle")?;
                }
                Some(LiveMatrix::Sum(v)) => {
                    length(field(), v.len() % (n + 1), 0, "a number and a vector, again and again")?;
                }
                None => {}
            }
        }
    }
    for (i, version) in live.versions.iter().enumerate() {
        for (k, _) in &version.values {
            parameter(&|| format!("live.versions[{i}].values"), *k)?;
        }
    }
    for (i, h) in live.hypotheses.iter().enumerate() {
        for &k in &h.sizes {
            parameter(&|| format!("live.hypotheses[{i}].sizes"), k)?;
        }
        if let Some(edit) = &h.test {
            let n_shapes = live.test.len() * n_sensors;
            let parts = [
                ("frequency", &edit.frequency, live.test.len()),
                ("frequency_sd", &edit.frequency_sd, live.test.len()),
                ("shape", &edit.shape, n_shapes),
                ("shape_sd", &edit.shape_sd, n_shapes),
                ("sensors", &edit.sensors, n_sensors * n),
            ];
            for (part, entries, len) in parts {
                let field = || format!("live.hypotheses[{i}].test.{part}");
                length(field(), entries.values.len(), 3 * entries.at.len(), "three an entry")?;
                for &k in &entries.at {
                    index(field, k, "the array that it changes", len)?;
                }
            }
        }
        length(format!("live.hypotheses[{i}].estimates"), h.estimates.len(), h.sizes.len(), "one a size")?;
    }
    length("live.sensors".into(), live.sensors.len(), n_sensors * n, "one a sensor and coordinate")?;
    for (part, values) in [("displacement", Some(&live.displacement)), ("rotation", live.rotation.as_ref())] {
        shape(format!("live.{part}"), values, nodal * n, "three a node and coordinate")?;
    }
    if let Some(m) = &live.symmetry {
        for (part, v) in [("mirror", &m.mirror), ("gram", &m.gram)] {
            length(format!("live.symmetry.{part}"), v.len(), triangle, "the rows of a lower triangle")?;
        }
    }
    for (i, mode) in live.test.iter().enumerate() {
        for (part, v, expected) in [
            ("shape", &mode.shape, n_sensors),
            ("shape_sd", &mode.shape_sd, n_sensors),
            ("followed", &mode.followed, n),
        ] {
            if !v.is_empty() {
                length(format!("live.test[{i}].{part}"), v.len(), expected, "one a sensor, or a coordinate")?;
            }
        }
    }
    Ok(())
}

fn matrix(field: &str, m: &super::LabelledMatrix) -> Result<(), ReportError> {
    length(format!("{field}.values"), m.values.len(), m.rows.len(), "one a row name")?;
    for (i, row) in m.values.iter().enumerate() {
        length(format!("{field}.values[{i}]"), row.len(), m.columns.len(), "one a column name")?;
    }
    Ok(())
}

fn place(field: &str, p: &Place, s: &Structure) -> Result<(), ReportError> {
    let lists = [
        ("nodes", &p.nodes, "structure.nodes", s.nodes.len()),
        ("elements", &p.elements, "structure.elements", s.elements.len()),
        ("sensors", &p.sensors, "structure.sensors", s.sensors.len()),
    ];
    for (part, list, target, len) in lists {
        for &k in list {
            index(|| format!("{field}.{part}"), k, target, len)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::{Element, Hypothesis, ModelMode, Node};
    use super::*;

    #[test]
    fn empty_data_are_a_report() {
        assert_eq!(ReportData::default().validate(), Ok(()));
    }

    #[test]
    fn what_does_not_fit_is_named() {
        let node = Node { name: "n1".into(), position: [0.0; 3] };
        let element = Element { nodes: vec![0, 7], ..Element::default() };
        let structure = Structure { nodes: vec![node], elements: vec![element], ..Structure::default() };
        let mut data = ReportData { structure: Some(structure), ..ReportData::default() };
        assert_eq!(
            data.validate().unwrap_err().to_string(),
            "`structure.elements[0].nodes` is 7, but `structure.nodes` has 1 entries, counted from 0"
        );
        data.structure.as_mut().unwrap().elements.clear();
        data.modes.model.push(ModelMode { displacement: Floats(vec![0.0; 2]), ..ModelMode::default() });
        assert_eq!(
            data.validate().unwrap_err().to_string(),
            "`modes.model[0].displacement` has 2 values; expected 3 (three a node)"
        );
        data.modes.model.clear();
        let place = Place { sensors: vec![0], ..Place::default() };
        let hypotheses = vec![Hypothesis { place, ..Hypothesis::default() }];
        data.diagnosis = Some(super::super::Diagnosis { hypotheses, ..Default::default() });
        assert!(data.validate().unwrap_err().to_string().contains("structure.sensors"));
        data.schema = 9;
        assert!(data.validate().unwrap_err().to_string().contains("schema 9"));
    }
}
