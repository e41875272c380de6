//! The parts of a comparison on the flagship and on cases with known answers.

use super::*;
use retune::correlation::{BUILTIN_PROFILES, find_profile, observation_matrix};
use retune::data::{FrfQuantity, Measured, Origin, StaticLoad, StaticReading, StaticTest};
use retune::linalg::{Complex, DMatrix};
use retune::modal::{SolveOptions, solve};
use retune::model::Matrices;
use retune::objective::{Comparison, starting_point, static_readings};
use retune::update::{
    FunctionsOptions, MassReduction, ModelFunctions, SensitivityOptions, TwinFrfOptions, assess, compare_functions,
    frf_sensitivities, judge, load_profile, orthogonality, pretest, sensitivities, sensor_agreement, slip_of_unit,
    slips_of_modes, slips_of_readings, twin_frfs,
};

/// The eight inertial parameters of the centre body act through four numbers (mass, first and second moments and roll
/// inertia, once the aircraft is weighed): it must say so in words, and say nothing of the sort about the wing.
#[test]
fn the_centre_body_acts_through_four_numbers() {
    let (model, test) = (model("bff.yaml"), gvt());
    let found = sensitivities(&model, &test, SensitivityOptions { n_modes: 6 }).unwrap();
    // A free structure may be scaled as a whole: one more combination is hidden until it is weighed.
    assert_eq!(found.identifiability.unwrap().rank, 14);
    let seen = found.weighed.unwrap();
    assert_eq!((seen.rank, seen.names.len(), seen.groups.len()), (15, 19, 1), "{seen}");
    let group = &seen.groups[0];
    let mut names: Vec<&str> = group.parameters.iter().map(|&p| seen.names[p].as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, ["Ix1", "Ix4_9", "Iz1", "m1", "m2", "m3", "m4_9", "mu_fuselage"]);
    assert_eq!(group.combinations.nrows(), 4);
    assert!(seen.to_string().contains("these 8 parameters act only through 4 numbers"), "{seen}");
    // What determines nothing by itself has no standard deviation; the spar has one.
    let of = |name: &str| found.information.iter().find(|i| i.name == name).unwrap();
    assert!(of("m1").sd.is_none() && of("m1").sd_alone.is_some() && of("E_wing").sd.is_some());
}

/// Frequencies, masses and functions by differences of whole solutions.
#[test]
fn sensitivities_agree_with_differences() {
    let model = model("frame.yaml");
    let test = TestData {
        sensors: sensors("frame.yaml", &model),
        ..twin(&model, &sensors("frame.yaml", &model), 5, (0.01, 0.01), 0)
    };
    let found = sensitivities(&model, &test, SensitivityOptions { n_modes: 5 }).unwrap();
    let theta = starting_point(&model);
    let rigid = model.dof_map().rigid_motions();
    let modes_at = |theta: &[f64]| {
        let s = model.assemble(theta).unwrap();
        solve(&s.stiffness, &s.mass, &rigid, SolveOptions { n_elastic: model.dof_map().n_dof(), shift: None }).unwrap()
    };
    for (k, name) in found.names.iter().enumerate() {
        let j = model.parameters().index_of(name).unwrap();
        let p = model.parameters().get(j);
        // Truncation about 1e-8 and rounding (1e-12 of the solution) over the step.
        let step = 1e-4 * (p.bounds.unwrap()[1] - p.bounds.unwrap()[0]);
        let shifted = |sign: f64| {
            let mut t = theta.clone();
            t[j] += sign * step;
            t
        };
        let (above, below) = (shifted(1.0), shifted(-1.0));
        let (fa, fb) = (modes_at(&above).frequencies_hz(), modes_at(&below).frequencies_hz());
        for m in 0..5 {
            let slope = (fa[m] - fb[m]) / (2.0 * step) * p.unit_factor;
            let size = found.modes[m].frequency_hz / found.widths[k];
            let error = (found.frequency[(m, k)] - slope).abs() / size;
            assert!(error < 1e-7, "{name} mode {m}: {error:e}, {} {slope}", found.frequency[(m, k)]);
        }
        let mass = |t: &[f64]| model.mass_properties(t).unwrap().unwrap().mass;
        let slope = (mass(&above) - mass(&below)) / (2.0 * step) * p.unit_factor;
        assert!((found.mass[(0, k)] - slope).abs() < 1e-6 * (1.0 + slope.abs()), "{name}");
    }
    // Functions: the damping matrix is held, so the reference inverts Z with that of the base.
    let base = modes_at(&theta);
    let s = observation_matrix(&model, &test.sensors).unwrap();
    let exciter = s.rows(3, 1).into_owned();
    let (f, zeta) = (1.1 * found.modes[1].frequency_hz, 0.02);
    let omega = std::f64::consts::TAU * f;
    let system = model.assemble(&theta).unwrap();
    let weights: Vec<f64> = base.lambda.iter().map(|l| 2.0 * zeta * l.max(0.0).sqrt()).collect();
    let m_phi = &system.mass * &base.shapes;
    let damping = &m_phi * DMatrix::from_diagonal(&nalgebra::DVector::from_vec(weights)) * m_phi.transpose();
    let receptance = |theta: &[f64]| {
        let t = model.assemble(theta).unwrap();
        let z = DMatrix::from_fn(t.mass.nrows(), t.mass.ncols(), |i, j| {
            Complex::new(t.stiffness[(i, j)] - omega * omega * t.mass[(i, j)], omega * damping[(i, j)])
        });
        s.map(Complex::from) * z.lu().solve(&exciter.transpose().map(Complex::from)).unwrap()
    };
    let (read, driven) = (&s * &base.shapes, &exciter * &base.shapes);
    let solved = (&Matrices::Dense(system.clone()), &base);
    let relative = frf_sensitivities(&model, solved, (&read, &driven), &[f], zeta).unwrap().relative;
    let size = receptance(&theta).norm();
    for (k, name) in found.names.iter().enumerate() {
        let j = model.parameters().index_of(name).unwrap();
        let [lower, upper] = model.parameters().get(j).bounds.unwrap();
        let step = 1e-5 * (upper - lower);
        let at = |sign: f64| {
            let mut t = theta.clone();
            t[j] += sign * step;
            receptance(&t)
        };
        let expected = (at(1.0) - at(-1.0)).norm() / (2.0 * step) * (upper - lower) / size;
        // Central differences with a step of 1e-5: 1e-9 of truncation, 1e-10 of rounding near resonance.
        assert!((relative[k][0] / expected - 1.0).abs() < 1e-5, "{name}: {} {expected}", relative[k][0]);
    }
}

/// Functions of the model itself agree; a model that is 4 % too stiff everywhere is too high by 2 %, and FDAC says so.
#[test]
fn functions_of_the_same_model_agree_and_a_stiff_model_is_shifted() {
    let model = model("frame.yaml");
    let sensors = sensors("frame.yaml", &model);
    let theta = starting_point(&model);
    let stiff: Vec<f64> = theta.iter().enumerate().map(|(j, v)| if j < 2 { 1.04 * v } else { *v }).collect();
    let test = twin(&model, &sensors, 4, (0.001, 0.01), 1);
    let last = 1.2 * test.modes[3].frequency_hz.value;
    let options = TwinFrfOptions {
        lines_hz: (1..=800).map(|k| last * f64::from(k) / 800.0).collect(),
        exciters: vec![sensors[4].name.clone()],
        quantity: FrfQuantity::Accelerance,
        force_noise: 0.0,
        response_noise: 0.0,
        n_averages: 1,
    };
    let set = twin_frfs(&model, &theta, &sensors, &TwinOptions::default(), &options).unwrap();
    let comparison = Comparison::new(&model, &test, OPEN).unwrap();
    let settings = FunctionsOptions { damping: Some(0.01), ..FunctionsOptions::default() };
    let same = compare_functions(&comparison, &assess(&comparison, &theta).unwrap(), &set, &settings).unwrap();
    assert_eq!((same.bands.len(), same.channels.len()), (4, sensors.len()));
    assert!(same.bands.iter().all(|b| b.csac.unwrap() > 1.0 - 1e-9 && b.csf.unwrap() > 1.0 - 1e-9), "{:?}", same.bands);
    assert!(same.bands.iter().all(|b| b.misfit.chi_squared < 1e-6));
    assert_eq!(same.channels.iter().filter(|c| c.is_driving_point).count(), 1);
    assert!((same.shifts[0].ratio - 1.0).abs() < 1e-12);
    let high = compare_functions(&comparison, &assess(&comparison, &stiff).unwrap(), &set, &settings).unwrap();
    // √1.04; the machine's mass is the same.
    assert!((high.shifts[0].ratio - 1.04_f64.sqrt()).abs() < 0.002, "{:?}", high.shifts[0].ratio);
    assert!(high.shifts[0].fdac > high.shifts[0].fdac_unshifted);
    assert!(high.bands.iter().all(|b| b.csf < Some(1.0 - 1e-5) && b.misfit.p_value < 1e-6), "{:?}", high.bands);
    // Channels are known by their names only.
    let mut strange = set.clone();
    strange.responses[2].name = "stranger".to_string();
    let rest = compare_functions(&comparison, &assess(&comparison, &theta).unwrap(), &strange, &settings).unwrap();
    assert_eq!((rest.left_out.as_slice(), rest.channels.len()), (&["stranger".to_string()][..], sensors.len() - 1));
    strange.responses.iter_mut().for_each(|c| c.name = "stranger".to_string());
    let error = compare_functions(&comparison, &assess(&comparison, &theta).unwrap(), &strange, &settings).unwrap_err();
    assert!(error.to_string().contains("stranger"), "{error}");

    // Line by line with structural damping, beside the sum of all modes: -ω² Σ φ φ / (λ (1 + i η) - ω²).
    let eta = 0.03;
    let system = model.assemble(&theta).unwrap();
    let n = model.dof_map().n_dof();
    let modes = solve(
        &system.stiffness,
        &system.mass,
        &model.dof_map().rigid_motions(),
        SolveOptions { n_elastic: n, shift: None },
    )
    .unwrap();
    let seen = observation_matrix(&model, &sensors).unwrap() * &modes.shapes;
    let mut damped = set.clone();
    for (line, hz) in set.frequencies_hz.iter().enumerate() {
        let square = (std::f64::consts::TAU * hz).powi(2);
        for response in 0..sensors.len() {
            let of_mode = |r: usize| {
                let lambda = modes.lambda[r];
                -square * seen[(response, r)] * seen[(4, r)] / Complex::new(lambda - square, lambda * eta)
            };
            damped.h[set.index(line, 0, response)] = (0..modes.len()).map(of_mode).sum();
        }
    }
    let bands_hz = vec![[0.3 * last, 0.4 * last], [0.6 * last, 0.9 * last]];
    let settings = FunctionsOptions { loss_factor: Some(eta), bands_hz, ..FunctionsOptions::default() };
    let same = compare_functions(&comparison, &assess(&comparison, &theta).unwrap(), &damped, &settings).unwrap();
    assert_eq!(same.model, ModelFunctions::Direct { is_damped: false, loss_factor: eta });
    assert_eq!(same.bands.len(), 2);
    let functions = same.channels.iter().map(|c| (c.amplitude_rms_db, c.misfit.n_data));
    assert!(functions.clone().all(|(rms, n_data)| rms < 1e-6 && n_data == functions.clone().next().unwrap().1));
    assert!(same.bands.iter().all(|b| b.misfit.chi_squared < 1e-9), "{:?}", same.bands);
}

/// Frequencies in rad/s, written as Hz, are a common factor in every pair; right ones are not, nor is a test of few modes.
#[test]
fn a_slip_of_the_unit_of_frequencies_is_seen() {
    let model = model("frame.yaml");
    let sensors = sensors("frame.yaml", &model);
    let mut test = twin(&model, &sensors, 4, (0.003, 0.02), 1);
    assert_eq!(slip_of_unit(&model, &test).unwrap(), None);
    for mode in &mut test.modes {
        mode.frequency_hz.value *= std::f64::consts::TAU;
    }
    assert!(slip_of_unit(&model, &test).unwrap().unwrap().contains("are they rad/s, written as Hz?"));
    test.modes.truncate(2);
    assert_eq!(slip_of_unit(&model, &test).unwrap(), None);
}

/// One frequency in kHz, written as Hz, is told with the mode whose shape it has; two of four that differ tell nothing.
#[test]
fn a_slip_of_the_unit_of_one_frequency_is_seen() {
    let model = model("frame.yaml");
    let sensors = sensors("frame.yaml", &model);
    let mut test = twin(&model, &sensors, 4, (0.003, 0.02), 1);
    assert_eq!(slips_of_modes(&model, &test).unwrap(), Vec::<String>::new());
    test.modes[2].frequency_hz.value /= 1000.0;
    let found = slips_of_modes(&model, &test).unwrap();
    assert!(
        matches!(&found[..], [one] if one.starts_with("mode 3 has the shape") && one.contains("is it kHz")),
        "{found:?}"
    );
    assert_eq!(slip_of_unit(&model, &test).unwrap(), None);
    test.modes[1].frequency_hz.value /= 1000.0;
    assert_eq!(slips_of_modes(&model, &test).unwrap(), Vec::<String>::new());
}

/// Static readings in mm, written as m, are a common factor between two units; right ones are not.
#[test]
fn a_slip_of_the_unit_of_readings_is_seen() {
    let model = model("frame.yaml");
    let sensors = sensors("frame.yaml", &model);
    let mut test = twin(&model, &sensors, 4, (0.003, 0.02), 1);
    let load = StaticLoad {
        place: sensors[0].place.clone(),
        offset: None,
        direction: sensors[0].direction,
        is_moment: false,
        value: 10.0,
    };
    let reading =
        |value: f64| StaticReading { sensor: 0, measured: Measured { value, sd: 1e-6, sd_is_default: false } };
    let origin = Origin::Measured("bench".to_string());
    test.static_tests =
        vec![StaticTest { name: "pull".to_string(), loads: vec![load], readings: vec![reading(1.0)], origin }];
    let predicted = {
        let comparison = Comparison::new(&model, &test, PairingOptions::default()).unwrap();
        static_readings(&comparison, &comparison.predict(&model.parameters().nominal()).unwrap())[0]
    };
    for (factor, question) in
        [(1.05, None), (1000.0, Some("are they mm, written as m")), (25.4, Some("are they mm, written as in"))]
    {
        test.static_tests[0].readings = vec![reading(factor * predicted)];
        let found = slips_of_readings(&model, &test).unwrap();
        assert_eq!(
            found.first().map(|text| text.contains(question.unwrap_or("no"))),
            question.map(|_| true),
            "{found:?}"
        );
    }
}

/// With the mass at all dofs the model's own modes are orthogonal to rounding, and so is a noise-free test; every
/// reduction that exists agrees on the low modes of the frame.
#[test]
fn orthogonality_of_a_right_model() {
    let model = model("frame.yaml");
    let sensors = sensors("frame.yaml", &model);
    let test = twin(&model, &sensors, 3, (0.001, 1e-9), 0);
    let comparison = Comparison::new(&model, &test, OPEN).unwrap();
    let a = assess(&comparison, &starting_point(&model)).unwrap();
    for (reduction, tolerance) in [
        (MassReduction::Auto, 0.02),
        (MassReduction::Guyan, 0.02),
        (MassReduction::Irs, 0.01),
        (MassReduction::Serep, 1e-6),
    ] {
        let o = orthogonality(&comparison, &a, reduction).unwrap().unwrap();
        assert!(o.cross_off_diagonal() < tolerance && o.auto_off_diagonal() < tolerance, "{reduction:?} {o:?}");
        assert!((0..3).all(|k| (o.cross[k][k] - 1.0).abs() < 1e-6), "{reduction:?} {o:?}");
        assert!(o.own_error < tolerance);
    }
    let error = orthogonality(&comparison, &a, MassReduction::Full).unwrap_err().to_string();
    assert!(error.contains("do not see all"), "{error}");
}

/// A reversed sensor is the one that stands out and the first that MACCO takes away.
#[test]
fn a_reversed_sensor_is_named() {
    let (truth, mut test) = (model("bff_truth.yaml"), gvt());
    for mode in &mut test.modes {
        if let Some(shape) = &mut mode.shape {
            shape[10] = -shape[10];
        }
    }
    let comparison = Comparison::new(&truth, &test, OPEN).unwrap();
    let a = assess(&comparison, &starting_point(&truth)).unwrap();
    let report = sensor_agreement(&comparison, &a, 3).unwrap().unwrap();
    assert_eq!(report.removals[0].sensor, 10);
    let worst = report.sensors.iter().max_by(|a, b| a.misfit.chi_squared.total_cmp(&b.misfit.chi_squared)).unwrap();
    assert_eq!(worst.sensor, test.sensors[10].name);
    assert!(report.sensors[10].enhanced_comac > report.sensors[0].enhanced_comac);
}

/// The truth passes its own test, with a probability that says so; the initial model fails.
#[test]
fn a_profile_passes_the_truth_and_fails_the_guess() {
    let profile = find_profile("common-practice", &[]).unwrap();
    let test = gvt();
    let judged = |file: &str| {
        let model = model(file);
        let comparison = Comparison::new(&model, &test, OPEN).unwrap();
        judge(&comparison, &assess(&comparison, &model.parameters().nominal()).unwrap(), None, &profile)
    };
    let (truth, guess) = (judged("bff_truth.yaml"), judged("bff.yaml"));
    assert!(truth.passed && truth.probability > 0.99, "{truth:?}");
    assert!(!guess.passed && guess.probability < 1e-6, "{guess:?}");
    assert!(load_profile(Some(BUILTIN_PROFILES), None).unwrap_err().to_string().contains("several"));
    assert_eq!(load_profile(Some(BUILTIN_PROFILES), Some("same-shape")).unwrap().name, "same-shape");
}

/// Effective independence keeps what it is asked for and tells modes apart; a held frame's effective masses stay below
/// the whole; a sensor where there is one already tells less than the best.
#[test]
fn a_test_is_planned() {
    let model = model("frame.yaml");
    let options = retune::update::PretestOptions {
        n_modes: Some(4),
        n_sensors: Some(8),
        shape_noise: 0.02,
        frequency_noise: 0.005,
    };
    let many = retune::update::PretestOptions { n_modes: Some(10_000), ..options.clone() };
    let refused = pretest(&model, &[], &many).unwrap_err().to_string();
    assert!(refused.contains("number of target modes is 10000; it must be at most"), "{refused}");
    let plan = pretest(&model, &[], &options).unwrap();
    assert_eq!((plan.by_independence.kept.len(), plan.modes.len()), (8, 4));
    assert!(plan.by_auto_mac.largest_off_diagonal < 0.2);
    for d in 0..3 {
        let sum: f64 = plan.modes.iter().map(|m| m.effective_mass[d]).sum();
        assert!((0.0..=1.0 + 1e-9).contains(&sum), "{d} {sum}");
    }
    // The sway mode moves most of the mass sideways.
    assert!(plan.modes[0].effective_mass[0] > 0.7, "{:?}", plan.modes[0]);
    assert!(plan.next.windows(2).all(|w| w[0].nats >= w[1].nats) && plan.next[0].nats > 0.0);
    let best = plan.next[0].candidate;
    let mut given: Vec<Sensor> = plan.by_independence.kept.iter().map(|&c| plan.candidates[c].clone()).collect();
    given.push(plan.candidates[best].clone());
    let more = pretest(&model, &given, &options).unwrap();
    let again = more.next.iter().find(|g| g.candidate == best).unwrap();
    assert!(again.nats < plan.next[0].nats, "{} {}", again.nats, plan.next[0].nats);
}
