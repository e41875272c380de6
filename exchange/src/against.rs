//! A model against what a solver computed of the deck that it was made of.

use super::results::{ResultMass, ResultMode, SolverResults};
use super::system::{Quantity, System, system_by_name};
use retune::element::Dof;
use retune::linalg::DMatrix;
use retune::linalg::vector3::{dot, minus};
use retune::modal::SolveOptions;
use retune::model::{Model, ModelError, ParametricModel, solve_modes};
use std::collections::HashMap;

/// Mass properties side by side, in the deck's units.
#[derive(Debug, Clone, PartialEq)]
pub struct MassAgreement {
    /// The grid about which the masses are taken; the origin where it is zero.
    pub reference: u32,
    /// Rigid mass of the solver and of the model, six by six.
    pub solver: [[f64; 6]; 6],
    /// That of the model.
    pub model: [[f64; 6]; 6],
    /// Largest difference, relative to the mass, to mass times the radius of gyration, and to the largest moment of inertia.
    pub worst: f64,
}

/// One elastic mode of the solver and the model's mode of the same rank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeAgreement {
    /// Number of the solver's mode.
    pub number: i64,
    /// Frequency of the solver, Hz.
    pub solver_hz: f64,
    /// Frequency of the model, Hz.
    pub model_hz: f64,
    /// MAC of the displacements of all grids, of their rotations where nothing else moves; of modes at one frequency, with the nearest of their span. `None` without a shape.
    pub mac: Option<f64>,
}

impl ModeAgreement {
    /// Model over solver less one.
    pub fn relative(&self) -> f64 {
        self.model_hz / self.solver_hz - 1.0
    }
}

/// A model held against one file of results.
#[derive(Debug, Clone, PartialEq)]
pub struct Agreement {
    /// Mass properties, where the file and the model have them.
    pub mass: Option<MassAgreement>,
    /// Rigid-body modes of solver and model; `None` where the file leaves them out.
    pub n_rigid: (Option<usize>, usize),
    /// Elastic modes, ascending.
    pub modes: Vec<ModeAgreement>,
    /// What could not be compared, and why.
    pub notes: Vec<String>,
}

impl Agreement {
    /// Whether masses agree within 1e-5, frequencies within a part, and every MAC is at least so much; never where nothing was compared.
    pub fn holds(&self, frequency: f64, mac: f64) -> bool {
        let is_compared = !self.modes.is_empty() || (self.mass.is_some() && self.n_rigid.0.is_none());
        is_compared
            && self.mass.as_ref().is_none_or(|m| m.worst < 1e-5)
            && self.modes.iter().all(|m| m.relative().abs() <= frequency && m.mac.is_none_or(|v| v >= mac))
    }
}

/// Frequencies nearer than this to each other belong to one cluster, whose shapes are a matter of choice.
const CLUSTER: f64 = 1e-4;

/// Displacements below this part of the rotations, times the size of the structure, are rounding: a shape of torsion about a straight line has
/// rotations alone.
const ALL_ROTATION: f64 = 1e-4;

/// An eigenvalue below this, (rad/s)², 0.2 mHz, is none of a structure.
const NO_FREQUENCY: f64 = 1e-6;

/// Holds a model against the results of a solver, mode by mode.
///
/// * `most` - elastic modes to compare
///
/// # Errors
/// The model has no modes.
pub fn compare_results(model: &Model, results: &SolverResults, most: usize) -> Result<Agreement, ModelError> {
    let theta = model.parameters().nominal();
    let mut notes = results.notes.clone();
    let imported = model.spec().imported.as_ref();
    let system = imported.and_then(|i| system_by_name(&i.units));
    let wtmass = imported.and_then(|i| i.wtmass).unwrap_or(1.0);
    let mass = match (&results.mass, system) {
        (Some(mass), Some(system)) => masses(model, &theta, mass, system, wtmass, &mut notes)?,
        (Some(_), None) => {
            notes.push(
                "masses are not compared: the model file does not say which units its deck has (`imported`)"
                    .to_string(),
            );
            None
        }
        (None, _) => None,
    };
    let (mut n_rigid, mut modes) = ((None, 0), Vec::new());
    if !results.modes.is_empty() {
        let known = results.modes.len().min(most + 12);
        let own = solve_modes(model, &theta, SolveOptions { n_elastic: known, shift: None })?;
        let mut first = own.n_rigid + own.n_mechanism;
        // Eigenvalues of rigid-body modes are rounding.
        let lowest = own.lambda.iter().skip(first).copied().next().unwrap_or(0.0);
        let is_rigid = |lambda: f64| lambda < (1e-6 * lowest).max(NO_FREQUENCY);
        // Massless dofs have eigenvalues without bound of either sign.
        let rigid = results.modes.iter().filter(|m| is_rigid(m.eigenvalue.abs())).count();
        n_rigid = (Some(rigid).filter(|_| results.kind != "punch"), first);
        // What a SUPORT names has no frequency for the solver, whatever weak springs hold it.
        let bottom = results.modes.iter().find(|m| !is_rigid(m.eigenvalue)).map_or(0.0, ResultMode::frequency_hz);
        let slow = (first..rigid.min(own.len())).take_while(|&i| own.frequency_hz(i) < 0.05 * bottom).count();
        if slow > 0 {
            let hz = own.frequency_hz(first + slow - 1);
            notes.push(format!("{slow} modes of the model up to {hz:.2e} Hz, on weak springs, are rigid-body modes of the solver (SUPORT)"));
            first += slow;
        }
        let shapes = Shapes::new(model);
        let elastic: Vec<_> = results.modes.iter().filter(|m| !is_rigid(m.eigenvalue)).collect();
        if !elastic.iter().any(|m| !m.shape.is_empty()) {
            notes.push("the file has no shapes".to_string());
        }
        for (i, mode) in elastic.iter().enumerate().take(most.min(own.len() - first)) {
            let rank = first + i;
            let hz = own.frequency_hz(rank);
            let near: Vec<usize> =
                (first..own.len()).filter(|&k| (own.frequency_hz(k) / hz - 1.0).abs() < CLUSTER).collect();
            let mac = (!mode.shape.is_empty()).then(|| {
                let span: Vec<_> =
                    near.iter().map(|&k| model.dof_map().expand(&own.shapes.column(k).into_owned())).collect();
                shapes.mac(&mode.shape, &span)
            });
            modes.push(ModeAgreement {
                number: mode.number,
                solver_hz: mode.frequency_hz(),
                model_hz: hz,
                mac: mac.flatten(),
            });
        }
    }
    Ok(Agreement { mass, n_rigid, modes, notes })
}

fn masses(
    model: &Model,
    theta: &[f64],
    solver: &ResultMass,
    system: &System,
    wtmass: f64,
    notes: &mut Vec<String>,
) -> Result<Option<MassAgreement>, ModelError> {
    let Some(own) = model.mass_properties(theta)? else { return Ok(None) };
    let at = match solver.reference {
        0 => [0.0; 3],
        id => match model.geometry().node(&format!("n{id}")) {
            Some(node) => model.geometry().positions[node],
            None => {
                notes.push(format!(
                    "masses are not compared: the model has no node n{id}, about which the solver took them"
                ));
                return Ok(None);
            }
        },
    };
    let c = minus(own.cg, at);
    let mut rigid = [[0.0; 6]; 6];
    for i in 0..3 {
        rigid[i][i] = own.mass;
        for j in 0..3 {
            let steiner = own.mass * (if i == j { dot(c, c) } else { 0.0 } - c[i] * c[j]);
            rigid[3 + i][3 + j] = own.inertia[i][j] + steiner;
        }
        // Displacements of the centre by rotations about the point: θ × c.
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        for (row, column, value) in [(i, 3 + j, c[k]), (i, 3 + k, -c[j])] {
            rigid[row][column] = own.mass * value;
            rigid[column][row] = own.mass * value;
        }
    }
    let (m, l) = (system.factor(Quantity::Mass) * wtmass, system.factor(Quantity::Length));
    for (i, row) in rigid.iter_mut().enumerate() {
        for (j, v) in row.iter_mut().enumerate() {
            *v /= m * l.powi(i32::from(i >= 3) + i32::from(j >= 3));
        }
    }
    let s = &solver.rigid;
    let inertia = (3..6).map(|i| s[i][i].abs()).fold(0.0, f64::max);
    let mass = s[0][0].abs().max(f64::MIN_POSITIVE);
    let gyration = (inertia * mass).sqrt().max(f64::MIN_POSITIVE);
    let worst = (0..36)
        .map(|k| {
            let (i, j) = (k / 6, k % 6);
            let size = [mass, gyration, inertia.max(f64::MIN_POSITIVE)][usize::from(i >= 3) + usize::from(j >= 3)];
            (rigid[i][j] - s[i][j]).abs() / size
        })
        .fold(0.0, f64::max);
    Ok(Some(MassAgreement { reference: solver.reference, solver: *s, model: rigid, worst }))
}

/// Shapes of a model at grids, along the displacement axes of these.
struct Shapes {
    /// Node of a grid, and the axes of its displacements as rows.
    grids: HashMap<u32, (usize, [[f64; 3]; 3])>,
    /// Size of the structure, m.
    size: f64,
}

impl Shapes {
    fn new(model: &Model) -> Self {
        let geometry = model.geometry();
        let mut axes: HashMap<&str, [[f64; 3]; 3]> = HashMap::new();
        for (frame, nodes) in model.spec().imported.iter().flat_map(|i| &i.displacement_frames) {
            if let Some(f) = geometry.frames.get(frame) {
                axes.extend(nodes.iter().map(|n| (n.as_str(), f.axes)));
            }
        }
        let of = |(node, name): (usize, &String)| {
            let id = name.strip_prefix('n')?.parse().ok()?;
            Some((id, (node, axes.get(name.as_str()).copied().unwrap_or(retune::model::GLOBAL))))
        };
        Self { grids: geometry.names.iter().enumerate().filter_map(of).collect(), size: geometry.size() }
    }

    /// MAC of a solver's shape with the nearest shape in the span of some of the model.
    fn mac(&self, solver: &std::collections::BTreeMap<u32, [f64; 6]>, span: &[DMatrix<f64>]) -> Option<f64> {
        let largest = |shape: &DMatrix<f64>, first: usize| shape.columns(first, 3).amax();
        let turns_alone = |shape: &DMatrix<f64>| largest(shape, 0) < ALL_ROTATION * self.size * largest(shape, 3);
        let (first, of_motion) = if !span.is_empty() && span.iter().all(turns_alone) {
            (3, [Dof::Rx, Dof::Ry, Dof::Rz])
        } else {
            (0, [Dof::Ux, Dof::Uy, Dof::Uz])
        };
        let mut theirs: Vec<f64> = Vec::new();
        let mut ours: Vec<Vec<f64>> = vec![Vec::new(); span.len()];
        for (grid, shape) in solver {
            let Some((node, axes)) = self.grids.get(grid) else { continue };
            theirs.extend(&shape[first..first + 3]);
            for (own, list) in span.iter().zip(&mut ours) {
                let moved = of_motion.map(|d| own[(*node, d as usize)]);
                list.extend(axes.iter().map(|a| dot(*a, moved)));
            }
        }
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let size = product(&theirs, &theirs);
        if size == 0.0 || ours.is_empty() {
            return None;
        }
        // Of one shape it is the ordinary MAC; of several the part of the shape that lies in their span.
        let k = ours.len();
        let gram = DMatrix::from_fn(k, k, |i, j| product(&ours[i], &ours[j]));
        let along = DMatrix::from_fn(k, 1, |i, _| product(&ours[i], &theirs));
        let solved = gram.clone().lu().solve(&along)?;
        Some((along.transpose() * solved)[(0, 0)] / size)
    }
}
