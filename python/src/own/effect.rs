//! An effect that is a Python object.

use super::{Failure, all_forever, forever};
use crate::error::Wrong;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use retune::effect::{About, Belongs, Effect, Location, LocationKind, PartKind, Patch, PatchError, Structure};
use retune::element::Dof;
use retune::yaml::Problem;

/// Where it could act, and what it adds to a file, are functions of Python, which take the GIL for each call.
#[derive(Debug)]
pub(crate) struct PythonEffect {
    name: &'static str,
    about: About,
    belongs_to: Belongs,
    needs_sensors: bool,
    /// (structure) -> (kind, names, direction) of each place.
    locations: Py<PyAny>,
    /// (structure, kind, names, direction) -> edits, as JSON.
    patch: Py<PyAny>,
    pub(crate) failure: Failure,
}

/// An effect of the user's.
#[pyclass(frozen, module = "retune._core")]
pub(crate) struct OwnEffect(pub(crate) &'static PythonEffect);

#[pymethods]
impl OwnEffect {
    /// * `texts` - name, summary, signature, formulation
    #[new]
    #[pyo3(signature = (texts, confusable, references, belongs_to, needs_sensors, locations, patch))]
    fn new(
        texts: [String; 4],
        confusable: Vec<String>,
        references: Vec<String>,
        belongs_to: &str,
        needs_sensors: bool,
        locations: Py<PyAny>,
        patch: Py<PyAny>,
    ) -> PyResult<Self> {
        let belongs_to = match belongs_to {
            "structure" => Belongs::Structure,
            "support" => Belongs::Support,
            "rig" => Belongs::Rig,
            other => {
                let text = format!("effect `{}`: belongs_to is `{other}`; it is structure, support or rig", texts[0]);
                return Err(Wrong::text(text).into());
            }
        };
        let failure = Failure::new(&texts[0]);
        let [name, summary, signature, formulation] = texts.map(forever);
        let (confusable, references) = (all_forever(confusable), all_forever(references));
        let about = About { summary, signature, formulation, confusable, references };
        let effect = PythonEffect { name, about, belongs_to, needs_sensors, locations, patch, failure };
        Ok(Self(Box::leak(Box::new(effect))))
    }
}

/// What Python sees of a structure.
fn seen<'py>(py: Python<'py>, structure: &Structure<'_>) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    let model = structure.model();
    let moving = |n: usize| Dof::ALL.into_iter().filter(move |&d| structure.node_moves(n, d)).map(Dof::name);
    let node = |n: usize| {
        let dofs: Vec<&str> = moving(n).collect();
        (structure.node_name(n).to_string(), model.geometry().positions[n], dofs, structure.is_supported(n))
    };
    out.set_item("nodes", (0..structure.n_nodes()).map(node).collect::<Vec<_>>())?;
    let parts = structure.parts();
    let part = |p: &retune::effect::Part| {
        let kind = match p.kind {
            PartKind::Element => "element",
            PartKind::Chain | PartKind::Line | PartKind::Span | PartKind::Cut => "chain",
            PartKind::Group => "group",
            PartKind::Mass => "mass",
        };
        let mut nodes: Vec<String> = Vec::new();
        for n in p.elements.iter().flat_map(|&e| model.elements()[e].joined().into_owned()) {
            if n < structure.n_nodes() && !nodes.iter().any(|known| known == structure.node_name(n)) {
                nodes.push(structure.node_name(n).to_string());
            }
        }
        (p.name.clone(), kind, nodes, p.is_member, p.partner.map(|k| parts[k].name.clone()))
    };
    out.set_item("parts", parts.iter().map(part).collect::<Vec<_>>())?;
    out.set_item("total_mass", structure.total_mass())?;
    out.set_item("extent", structure.extent())?;
    out.set_item("omega2", structure.omega2())?;
    let context = structure.context();
    out.set_item("sensors", context.sensors.iter().map(|s| s.node.clone()).collect::<Vec<_>>())?;
    out.set_item("frequencies", context.frequencies_hz.clone())?;
    Ok(out)
}

fn kind_of(word: &str) -> PyResult<LocationKind> {
    Ok(match word {
        "node" => LocationKind::Node,
        "element" => LocationKind::Element,
        "chain" => LocationKind::Chain,
        "group" => LocationKind::Group,
        "mass" => LocationKind::Mass,
        "pair" => LocationKind::Pair,
        "end" => LocationKind::End,
        "whole" => LocationKind::Whole,
        other => {
            let text = format!(
                "the kind of a location is `{other}`; it is node, element, chain, group, mass, pair, end or whole"
            );
            return Err(Wrong::text(text).into());
        }
    })
}

fn word_of(kind: LocationKind) -> &'static str {
    match kind {
        LocationKind::Node => "node",
        LocationKind::Element => "element",
        LocationKind::Chain => "chain",
        LocationKind::Group => "group",
        LocationKind::Mass => "mass",
        LocationKind::Pair => "pair",
        LocationKind::End => "end",
        LocationKind::Whole => "whole",
    }
}

impl Effect for PythonEffect {
    fn name(&self) -> &'static str {
        self.name
    }

    fn about(&self) -> About {
        self.about
    }

    fn belongs_to(&self) -> Belongs {
        self.belongs_to
    }

    fn needs_sensors(&self) -> bool {
        self.needs_sensors
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        Python::attach(|py| {
            let ask = || {
                let found = self.locations.call1(py, (seen(py, structure)?,))?;
                let rows: Vec<(String, Vec<String>, Option<String>)> = found.extract(py)?;
                let one = |(kind, names, direction): (String, Vec<String>, Option<String>)| {
                    let at = Location::new(kind_of(&kind)?, names);
                    Ok(direction.iter().fold(at, |at, d| at.along(d)))
                };
                rows.into_iter().map(one).collect::<PyResult<Vec<_>>>()
            };
            self.failure.caught(py, ask()).unwrap_or_default()
        })
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let made = Python::attach(|py| {
            let ask = || {
                let place = (word_of(at.kind), at.names.clone(), at.direction.clone());
                let text: String = self.patch.call1(py, (seen(py, structure)?, place))?.extract(py)?;
                let wrong = |e| Wrong::text(format!("what it adds at {at} is not an entry of a model file: {e}"));
                Ok(serde_json::from_str::<Patch>(&text).map_err(wrong)?)
            };
            self.failure.caught(py, ask())
        });
        // What was raised is raised once more when the work returns.
        let refused = || vec![Problem::error("", format!("{}: its entries at {at} cannot be made", self.name))];
        made.ok_or_else(|| PatchError::Refused(refused()))
    }
}
