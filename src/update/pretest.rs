//! Before a test: target modes, sensors, exciters, and what one more sensor would tell.

use super::{ModeName, UpdateError, name_modes, spread_sensors};
use crate::catalogue::Choice;
use crate::correlation::{
    CorrelationError, DrivingPoint, Gain, SensorChoice, effective_independence, effective_masses,
    kinetic_energy_shares, observation_rows, rank_driving_points, rank_next_measurements, read_rows,
    sensors_by_auto_mac, sensors_by_kinetic_energy,
};
use crate::data::Sensor;
use crate::linalg::DMatrix;
use crate::model::{ModalSolver, ParametricModel};
use crate::objective::{EvalError, Scaling};

/// What is planned.
#[derive(Debug, Clone, PartialEq)]
pub struct PretestOptions {
    /// Elastic target modes; six when absent, or as many as there are places for sensors.
    pub n_modes: Option<usize>,
    /// Sensors to choose; when absent twice the target modes, or as many as there are places.
    pub n_sensors: Option<usize>,
    /// Standard deviation of a shape entry, of the largest entry.
    pub shape_noise: f64,
    /// Relative standard deviation of a frequency.
    pub frequency_noise: f64,
}

/// Target modes where nobody says how many.
const USUAL_MODES: usize = 6;

/// A target mode.
#[derive(Debug, Clone, PartialEq)]
pub struct TargetMode {
    /// Its name and frequency.
    pub mode: ModeName,
    /// Share of the mass (inertia about the origin) that it moves with the base along x, y, z (about x, y, z); zeros for a
    /// free structure.
    pub effective_mass: [f64; 6],
    /// The candidate with the largest kinetic energy, and its share.
    pub liveliest: Option<(usize, f64)>,
}

/// A plan of a test.
#[derive(Debug, Clone, PartialEq)]
pub struct Pretest {
    /// The target modes.
    pub modes: Vec<TargetMode>,
    /// Places where a sensor or an exciter may stand: every translation of every node, or of nodes that are spread evenly over a mesh.
    pub candidates: Vec<Sensor>,
    /// How many nodes these are at, and how many move.
    pub nodes: [usize; 2],
    /// Effective independence.
    pub by_independence: SensorChoice,
    /// By autoMAC.
    pub by_auto_mac: SensorChoice,
    /// By kinetic energy.
    pub by_kinetic_energy: SensorChoice,
    /// Largest MAC between two target modes at the sensors of a given test, and how many of these there are.
    pub given: Option<(f64, usize)>,
    /// Exciter places, best first: for all modes together, then for each symmetry family.
    pub exciters: Vec<(String, Vec<DrivingPoint>)>,
    /// What one more sensor at each candidate would tell of the parameters, best first; empty without bounded parameters.
    pub next: Vec<Gain>,
    /// Names of those parameters.
    pub parameters: Vec<String>,
}

/// A way to choose sensors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Placement {
    /// Effective independence: modal coordinates come out with the least noise.
    EffectiveIndependence,
    /// So that the modes can be told apart by MAC.
    AutoMac,
    /// Where the modes have most kinetic energy.
    KineticEnergy,
}

crate::catalogue::choice! { Placement, "way to choose sensors";
    EffectiveIndependence "effective-independence" "Modal coordinates come out with the least noise",
    AutoMac "auto-mac" "So that the modes can be told apart by MAC",
    KineticEnergy "kinetic-energy" "Where the modes have most kinetic energy",
}

impl Placement {
    /// Its name in the field.
    pub fn name(self) -> &'static str {
        match self {
            Self::EffectiveIndependence => "effective independence",
            Self::AutoMac => "autoMAC",
            Self::KineticEnergy => "kinetic energy",
        }
    }
}

impl Pretest {
    /// The choice of one way, or of each in the order in which they are told: the name of the way, and the choice.
    pub fn choices(&self, by: Option<Placement>) -> Vec<(&'static str, &SensorChoice)> {
        let one = |way| match way {
            Placement::EffectiveIndependence => &self.by_independence,
            Placement::AutoMac => &self.by_auto_mac,
            Placement::KineticEnergy => &self.by_kinetic_energy,
        };
        let ways = Placement::ALL.iter().map(|(way, ..)| *way).filter(|way| by.is_none_or(|by| by == *way));
        ways.map(|way| (way.name(), one(way))).collect()
    }
}

/// Plans a test of a model at its estimates, moved into their bounds.
///
/// * `given` - sensors that there are already; the next sensor is judged beside them, else beside those of effective
///   independence
///
/// The information of a next sensor is that of Lindley and Papadimitriou (see
/// [`rank_next_measurements`](crate::correlation::rank_next_measurements)): a reading in every target mode, in the scale
/// that the other sensors give the shape, with a uniform prior over each interval (width/√12) or the prior of the file.
///
/// Errors: the model has no modes; a choice of fewer sensors than modes, or of more than there are places.
pub fn pretest(
    model: &dyn ParametricModel,
    given: &[Sensor],
    options: &PretestOptions,
) -> Result<Pretest, UpdateError> {
    let theta = crate::objective::starting_point(model);
    let failed = |e: &dyn std::fmt::Display| UpdateError::Start(EvalError::Unsolvable { reason: e.to_string() });
    let rigid = model.dof_map().rigid_motions();
    let (candidates, nodes) = spread_sensors(model);
    // A default is what the model has room for; what is asked for is refused where it has not.
    let n_modes = options.n_modes.unwrap_or_else(|| USUAL_MODES.min(candidates.len()));
    let count = |most: usize, why: &str| CorrelationError::Count {
        what: "number of target modes",
        value: n_modes,
        expected: format!("at most {most}, {why}"),
    };
    if n_modes > candidates.len() {
        return Err(count(
            candidates.len(),
            "as there are places for sensors: fewer sensors than modes cannot tell them apart",
        )
        .into());
    }
    let n_dof = model.dof_map().n_dof();
    let solver = ModalSolver::new(model, &theta, n_modes.min(n_dof)).map_err(|e| failed(&e))?;
    let lowest = |n: usize| solver.solve(model, &theta, n.min(n_dof)).map_err(|e| failed(&e));
    let (mut matrices, mut modes) = lowest(n_modes)?;
    if modes.n_mechanism > 0 {
        // Mechanisms are not targets.
        (matrices, modes) = lowest(n_modes + modes.n_mechanism)?;
    }
    let named = name_modes(model, &theta, &modes).map_err(|e| failed(&e))?;
    let targets: Vec<usize> = modes.elastic().skip(modes.n_mechanism).collect();
    if options.n_modes.is_some_and(|n| n > targets.len()) {
        return Err(count(targets.len(), "as the model has elastic modes").into());
    }
    let shapes = modes.shapes.select_columns(&targets);
    let s = observation_rows(model, &candidates)?;
    let phi = read_rows(&s, &shapes);

    let inertia = matrices.mass_times(&shapes);
    let masses = effective_masses(&shapes, &inertia, &rigid);
    let whole = rigid.tr_mul(&matrices.mass_times(&rigid)).diagonal();
    let shares = candidate_energies(&s, &kinetic_energy_shares(&shapes, &inertia));
    let target = |(k, &i): (usize, &usize)| {
        let column = shares.column(k);
        let liveliest = (0..column.len()).max_by(|&a, &b| column[a].total_cmp(&column[b]).then(b.cmp(&a)));
        TargetMode {
            mode: named[i].clone(),
            effective_mass: [0, 1, 2, 3, 4, 5].map(|d| if whole[d] > 0.0 { masses[(k, d)] / whole[d] } else { 0.0 }),
            liveliest: liveliest.map(|c| (c, column[c])),
        }
    };
    let target_modes: Vec<TargetMode> = targets.iter().enumerate().map(target).collect();

    let n = options.n_sensors.unwrap_or_else(|| (2 * targets.len()).min(candidates.len()));
    let by_independence = effective_independence(&phi, n)?;
    let rows_given = observation_rows(model, given)?;
    let observed = read_rows(&rows_given, &shapes);
    let given_choice = (!given.is_empty()).then(|| {
        let mac = crate::correlation::auto_mac(&observed);
        let off = (0..mac.nrows()).flat_map(|i| (0..i).map(move |j| (i, j))).map(|at| mac[at]).fold(0.0, f64::max);
        (off, given.len())
    });

    let omega_squared: Vec<f64> = targets.iter().map(|&i| modes.lambda[i]).collect();
    let mut exciters = vec![("all modes".to_string(), rank_driving_points(&phi, &omega_squared))];
    for family in ["symmetric", "antisymmetric"] {
        let members: Vec<usize> = (0..targets.len()).filter(|&k| named[targets[k]].family == Some(family)).collect();
        if !members.is_empty() && members.len() < targets.len() {
            let squares: Vec<f64> = members.iter().map(|&k| omega_squared[k]).collect();
            exciters.push((format!("{family} modes"), rank_driving_points(&phi.select_columns(&members), &squares)));
        }
    }

    let scaling = Scaling::new(model);
    let names = scaling.free().iter().map(|&i| model.parameters().get(i).name.clone()).collect();
    let mut next = Vec::new();
    if !scaling.is_empty() {
        let slopes = matrices.derivatives(model, &theta, scaling.free()).map_err(|e| failed(&e))?;
        let derivatives = solver.differentiate(model, &matrices, &slopes, &modes, &targets).map_err(|e| failed(&e))?;
        let kept: Vec<_> = by_independence.kept.iter().map(|&c| s[c].clone()).collect();
        let rows_present = if given.is_empty() { &kept } else { &rows_given };
        let present = read_rows(rows_present, &shapes);
        let mut jacobian: Vec<nalgebra::RowDVector<f64>> = Vec::new();
        let mut gains = vec![DMatrix::zeros(0, scaling.len()); candidates.len()];
        for (k, d) in derivatives.iter().enumerate() {
            let (own, lambda) = (present.column(k), modes.lambda[targets[k]]);
            let Some(d) = d else { continue };
            let by_width = |j: usize| scaling.width()[j];
            // ln f = ½ ln λ + constant.
            let relative = |j: usize| d.lambda[j] / (2.0 * lambda) * by_width(j) / options.frequency_noise;
            jacobian.push(nalgebra::RowDVector::from_fn(scaling.len(), |_, j| relative(j)));
            let size = own.norm_squared();
            let sd = options.shape_noise * phi.column(k).amax().max(own.amax());
            if size == 0.0 || sd == 0.0 {
                continue;
            }
            let (d_present, d_candidates) = (read_rows(rows_present, &d.shape), read_rows(&s, &d.shape));
            let stretch: Vec<f64> = (0..scaling.len()).map(|j| own.dot(&d_present.column(j)) / size).collect();
            for row in 0..d_present.nrows() {
                jacobian.push(nalgebra::RowDVector::from_fn(scaling.len(), |_, j| {
                    (d_present[(row, j)] - own[row] * stretch[j]) * by_width(j) / sd
                }));
            }
            for (c, gain) in gains.iter_mut().enumerate() {
                let at = gain.nrows();
                *gain = std::mem::replace(gain, DMatrix::zeros(0, 0)).insert_row(at, 0.0);
                for j in 0..scaling.len() {
                    gain[(at, j)] = (d_candidates[(c, j)] - phi[(c, k)] * stretch[j]) * by_width(j) / sd;
                }
            }
        }
        let jacobian =
            if jacobian.is_empty() { DMatrix::zeros(0, scaling.len()) } else { DMatrix::from_rows(&jacobian) };
        let prior: Vec<f64> = scaling
            .free()
            .iter()
            .zip(scaling.width())
            .map(|(&i, width)| model.parameters().get(i).prior_sd.map_or(1.0 / 12.0_f64.sqrt(), |sd| sd / width))
            .collect();
        next = rank_next_measurements(&jacobian, &prior, &gains)?;
    }
    Ok(Pretest {
        modes: target_modes,
        by_auto_mac: sensors_by_auto_mac(&phi, &[], n)?,
        by_kinetic_energy: sensors_by_kinetic_energy(&phi, &shares, n),
        by_independence,
        candidates,
        nodes,
        given: given_choice,
        exciters,
        next,
        parameters: names,
    })
}

/// Kinetic energy of the dofs that a candidate reads, (candidates x modes): candidates on one dof of their own only.
///
/// * `s` - the rows of the candidates
/// * `shares` - of every dof, (n_dof x modes)
fn candidate_energies(s: &[Vec<(usize, f64)>], shares: &DMatrix<f64>) -> DMatrix<f64> {
    // A slave of a rigid link reads several dofs; each dof's energy goes to candidates in proportion to what they see.
    let mut seen = vec![0.0; shares.nrows()];
    s.iter().flatten().for_each(|&(dof, factor)| seen[dof] += factor * factor);
    DMatrix::from_fn(s.len(), shares.ncols(), |c, r| {
        let seen_by = s[c].iter().filter(|&&(dof, _)| seen[dof] > 0.0);
        seen_by.map(|&(dof, factor)| factor * factor / seen[dof] * shares[(dof, r)]).sum()
    })
}
