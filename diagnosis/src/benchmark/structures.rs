//! The structures of the benchmark, each with its sensors and its resolved modes.

use super::Plan;
use crate::error::{DiagnosisError, unsolvable};
use crate::problem::mesh::{FINER, build, mesh_errors, modes, refined, seen};
use retune::correlation::{effective_independence, observation_matrix};
use retune::data::{Place, Sensor};
use retune::element::Dof;
use retune::linalg::DMatrix;
use retune::linalg::vector3::{minus, unit};
use retune::model::spec::ModelSpec;
use retune::model::{AXES, GLOBAL, Model, ParametricModel, Registry, extent, load};
use retune::update::node_sensors;

/// Name and model file.
pub const STRUCTURES: &[(&str, &str)] = &[
    ("cantilever", retune::samples::CANTILEVER),
    ("free-beam", retune::samples::FREE_BEAM),
    ("flying-wing", retune::samples::FLYING_WING),
    ("aeroplane", retune::samples::AEROPLANE),
    ("frame", retune::samples::FRAME),
    ("wing-on-springs", retune::samples::WING_ON_SPRINGS),
];

/// Modes of a test, at least: a model whose mesh resolves fewer is refined until it resolves so many.
const LEAST_MODES: usize = 6;
/// How often a mesh is halved for that, at most.
const HALVINGS: usize = 2;
/// Arms of sensors, over the size of the structure.
const ARM: f64 = 0.05;
/// An arm stands across a member if the cosine between them is less.
const ACROSS: f64 = std::f64::consts::FRAC_1_SQRT_2;
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
        let mut model = build(spec, read.registry())?;
        let theta = model.parameters().nominal();
        let least = LEAST_MODES.min(plan.modes);
        let mut fine = refined(&model, &theta, FINER)?;
        let mut resolved = n_resolved(&model, &fine, &theta, plan)?;
        for _ in 0..HALVINGS {
            if resolved >= least {
                break;
            }
            model = refined(&model, &theta, 2)?;
            fine = refined(&model, &theta, FINER)?;
            resolved = n_resolved(&model, &fine, &theta, plan)?;
        }
        let resolved = resolved.max(least);
        let coarse = modes(&model, &theta, resolved)?;
        let places = places(&model);
        let rows = observation_matrix(&model, &places)?;
        let shapes = seen(&rows, &coarse, resolved);
        let n_modes = shapes.len();
        let n_sensors = plan.sensors.clamp(n_modes.min(places.len()), places.len());
        let choice = effective_independence(&DMatrix::from_columns(&shapes), n_sensors)?;
        let sensors = choice.kept.iter().map(|&i| places[i].clone()).collect();
        Ok(Self { name: name.to_string(), model, fine: fine.spec().clone(), sensors, n_modes })
    }
}

/// How many of the lowest modes the mesh resolves.
fn n_resolved(model: &Model, fine: &Model, theta: &[f64], plan: &Plan) -> Result<usize, DiagnosisError> {
    let errors = mesh_errors(model, fine, theta, plan.modes)?;
    Ok(errors.iter().take_while(|e| e.abs() < RESOLVED * plan.frequency_noise).count())
}

/// Where a test may measure: on the nodes of the file and, where they turn, on arms across their members, as at the edges of a wing.
fn places(model: &Model) -> Vec<Sensor> {
    let (dofs, geometry) = (model.dof_map(), model.geometry());
    let in_file = &model.spec().nodes;
    let nodes = node_sensors(model);
    let nodes =
        nodes.into_iter().filter(|s| matches!(&s.place, Place::Node { node, .. } if in_file.contains_key(node)));
    let mut out: Vec<Sensor> = nodes.collect();
    let arm = ARM * extent(&geometry.positions);
    for (n, node) in dofs.node_names().iter().enumerate().filter(|(_, name)| in_file.contains_key(*name)) {
        let members = || model.elements().iter().filter(|e| e.nodes.len() == 2 && e.nodes.contains(&n));
        let runs_along = |axis: usize| {
            members().any(|e| {
                let [a, b] = [e.nodes[0], e.nodes[1]].map(|i| geometry.positions[i]);
                unit(minus(b, a)).is_some_and(|along| along[axis].abs() > ACROSS)
            })
        };
        for axis in (0..3).filter(|&axis| !runs_along(axis)) {
            let moves = |read: usize| !dofs.express(n, Dof::ALL[read]).is_empty();
            for read in (0..3).filter(|&read| read != axis && moves(read)) {
                let turns = !dofs.express(n, Dof::ALL[3 + (3 - axis - read)]).is_empty();
                for (k, side) in [1.0, -1.0].into_iter().enumerate().filter(|_| turns) {
                    out.push(Sensor {
                        name: format!("{node}.{}.{}{}", Dof::ALL[read], AXES[axis], k + 1),
                        place: Place::Node { node: node.clone(), position: None },
                        direction: GLOBAL[read],
                        offset: Some(GLOBAL[axis].map(|v| side * arm * v)),
                        is_rotation: false,
                        mass: None,
                    });
                }
            }
        }
    }
    out
}
