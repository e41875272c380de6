//! The structures of the benchmark, each with its sensors and its resolved modes.

use super::Plan;
use crate::correlation::effective_independence;
use crate::data::Sensor;
use crate::diagnosis::DiagnosisError;
use crate::diagnosis::mesh::{build, mesh_errors, modes, refined, seen, unsolvable};
use crate::linalg::DMatrix;
use crate::model::spec::ModelSpec;
use crate::model::{Model, ParametricModel, Registry, load};
use crate::update::node_sensors;

/// Name and model file.
pub const STRUCTURES: &[(&str, &str)] = &[
    ("cantilever", include_str!("../../../models/cantilever.yaml")),
    ("free-beam", include_str!("../../../models/free_beam.yaml")),
    ("flying-wing", include_str!("../../../models/bff.yaml")),
    ("aeroplane", include_str!("../../../models/garteur.yaml")),
    ("frame", include_str!("../../../models/frame.yaml")),
    ("wing-on-springs", include_str!("../../../models/wing_on_spring.yaml")),
];

/// Sensors of a test.
const SENSORS: usize = 28;
/// Modes of a test, at most and at least.
const MODES: std::ops::RangeInclusive<usize> = 5..=8;
/// A mode is resolved where the coarse mesh errs by less than this share of the noise of its frequency.
const RESOLVED: f64 = 1.0 / 3.0;

/// A structure with its test.
#[derive(Debug)]
pub struct Specimen {
    /// Its name.
    pub name: String,
    /// The model that is diagnosed.
    pub model: Model,
    /// The same on a finer mesh.
    pub(super) fine: ModelSpec,
    /// Where the twin is measured.
    pub sensors: Vec<Sensor>,
    /// How many elastic modes are measured.
    pub n_modes: usize,
}

impl Specimen {
    /// Reads a model, refines it, and chooses modes and sensors.
    ///
    /// What the real structure weighs is dropped from the file: a twin has its own mass.
    pub fn new(name: &str, text: &str, plan: &Plan) -> Result<Self, DiagnosisError> {
        let (read, ..) = load(text, &Registry::builtin()).map_err(|p| unsolvable(&p[0]))?;
        let mut spec = read.spec().clone();
        spec.targets = None;
        let model = build(spec)?;
        let theta = model.parameters().nominal();
        let fine = refined(&model, &theta)?;
        let errors = mesh_errors(&model, &fine, &theta, *MODES.end())?;
        let resolved =
            errors.iter().take_while(|e| e.abs() < RESOLVED * plan.frequency_noise).count().max(*MODES.start());
        let coarse = modes(&model, &theta, resolved)?;
        let file_nodes = &model.spec().nodes;
        let places: Vec<Sensor> = node_sensors(&model)
            .into_iter()
            .filter(|s| matches!(&s.place, crate::data::Place::Node { node, .. } if file_nodes.contains_key(node)))
            .collect();
        let rows = crate::correlation::observation_matrix(&model, &places)?;
        let shapes = seen(&rows, &coarse, resolved);
        let n_modes = shapes.len();
        let choice = effective_independence(&DMatrix::from_columns(&shapes), SENSORS.min(places.len()))?;
        let sensors = choice.kept.iter().map(|&i| places[i].clone()).collect();
        Ok(Self { name: name.to_string(), model, fine: fine.spec().clone(), sensors, n_modes })
    }
}
