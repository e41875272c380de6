use super::*;
use crate::modal::accelerance;
use crate::model::{Model, Registry, load};

const TEXT: &str = "
retune: 1
name: beam
active_dofs: [uz, ry]
nodes: {a: [0, 0, 0], b: [1, 0, 0], c: [2, 0, 0], d: [3, 0, 0], e: [4, 0, 0]}
sections: {s: {E: 70 GPa, Iy: 4.1667e-9 m4, mass_per_length: 1.35 kg/m}}
beams: {span: {chain: [a, b, c, d, e], section: s}}
supports: {left: {node: a}}
";

fn model() -> Model {
    load(TEXT, &Registry::builtin()).unwrap().0
}

fn frf_options(n_averages: usize) -> TwinFrfOptions {
    TwinFrfOptions {
        lines_hz: (1..=400).map(|k| 0.1 * f64::from(k)).collect(),
        exciters: vec!["e".to_string()],
        quantity: FrfQuantity::Accelerance,
        force_noise: 0.0,
        response_noise: 0.0,
        n_averages,
    }
}

fn modes_with(options: &TwinOptions) -> TestData {
    let model = model();
    twin_modes(&model, &[], &node_sensors(&model), options, "test").unwrap()
}

/// A force at a node of a mode, or along a direction that nothing moves in, is not where the force acts.
#[test]
fn the_force_acts_where_it_drives_every_mode_of_the_band() {
    let model =
        load(&TEXT.replace("[uz, ry]", "[ux, uz, ry]").replace("Iy: 4", "A: 1e-4 m2, Iy: 4"), &Registry::builtin())
            .unwrap()
            .0;
    let sensors = node_sensors(&model);
    assert!(sensors[0].name.ends_with("ux"), "{}", sensors[0].name);
    // Three bending modes: the tip moves in all of them.
    let best = driving_sensor(&model, &[], &sensors, (0.1, 15.0)).unwrap();
    assert_eq!(sensors[best].name, "e.uz");
    assert_eq!(driving_sensor(&model, &[], &sensors, (0.001, 0.002)).unwrap(), 0, "no mode there");
}

#[test]
fn noise_has_the_stated_size_and_seeds_repeat() {
    let noise = TwinOptions { n_modes: 4, frequency_noise: 0.003, shape_noise: 0.02, ..TwinOptions::default() };
    let exact = modes_with(&TwinOptions { n_modes: 4, ..TwinOptions::default() });
    assert_eq!(modes_with(&noise), modes_with(&noise));
    let n_seeds = 200;
    let (mut f, mut s, mut count) = (0.0, 0.0, 0.0);
    for seed in 0..n_seeds {
        let noisy = modes_with(&TwinOptions { seed, ..noise.clone() });
        for (a, b) in noisy.modes.iter().zip(&exact.modes) {
            assert_eq!(a.frequency_hz.sd, 0.003 * b.frequency_hz.value);
            f += ((a.frequency_hz.value / b.frequency_hz.value - 1.0) / 0.003).powi(2);
            let (x, y) = (a.shape.as_ref().unwrap(), b.shape.as_ref().unwrap());
            s += (x - y).norm_squared() / 0.02_f64.powi(2);
            count += x.len() as f64;
        }
    }
    // A mean of n squares of standard normal numbers is 1 ± √(2/n); four standard deviations.
    let n = (n_seeds * 4) as f64;
    assert!((f / n - 1.0).abs() < 4.0 * (2.0 / n).sqrt(), "{}", f / n);
    assert!((s / count - 1.0).abs() < 4.0 * (2.0 / count).sqrt(), "{}", s / count);
    assert_ne!(modes_with(&noise).modes, modes_with(&TwinOptions { seed: 1, ..noise.clone() }).modes);
    assert!(exact.modes.iter().all(|m| m.origin.word() == "synthetic" && m.frequency_hz.sd_is_default));
}

#[test]
fn faults_act_on_the_reading() {
    let exact = modes_with(&TwinOptions::default());
    let names: Vec<&str> = exact.sensors.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, ["b", "c", "d", "e"]);
    let with =
        |fault: &str| modes_with(&TwinOptions { faults: vec![fault.parse().unwrap()], ..TwinOptions::default() });
    // Scales differ, so entries are compared relative to the last sensor, which no fault below touches.
    let ratio = |t: &TestData, k: usize| {
        let s = t.modes[1].shape.as_ref().unwrap();
        s[k].re / s[3].re
    };
    assert!((ratio(&with("sensor-sign@b"), 0) + ratio(&exact, 0)).abs() < 1e-12);
    assert!((ratio(&with("sensor-gain@c=1.5"), 1) - 1.5 * ratio(&exact, 1)).abs() < 1e-12);
    assert!((ratio(&with("sensor-swap@b+c"), 0) - ratio(&exact, 1)).abs() < 1e-12);
    assert!(ratio(&with("sensor-dead@d"), 2).abs() < 1e-12);
    assert!(ratio(&with("sensor-axis@d.x"), 2).abs() < 1e-12);
    let model = model();
    let refused = |fault: &str| {
        let options = TwinOptions { faults: vec![fault.parse()?], ..TwinOptions::default() };
        twin_modes(&model, &[], &node_sensors(&model), &options, "").map(|_| ())
    };
    for (wrong, said) in [
        ("sensor-sing@b", "did you mean `sensor-sign`?"),
        ("sensor-sign@bb", "did you mean `b`?"),
        ("sensor-sign", "it can be at b, c, d, e"),
        ("sensor-sign@b=2", "it has no number"),
        ("sensor-gain@b", "it needs a factor"),
        ("sensor-gain@b=x", "stands a number"),
        ("sensor-axis@b.w", "it can be at"),
        ("mode-frequency@mode 90=1.1", "cannot be at `mode 90`"),
    ] {
        let error = refused(wrong).unwrap_err().to_string();
        assert!(error.contains(said), "{wrong}: {error}");
    }
}

#[test]
fn functions_without_noise_are_the_synthesis_of_all_modes() {
    let model = model();
    let sensors = node_sensors(&model);
    let set = twin_frfs(&model, &[], &sensors, &TwinOptions::default(), &frf_options(1)).unwrap();
    let modes = modes(&model, &[], MOST_MODES).unwrap();
    let rows = crate::correlation::observation_matrix(&model, &sensors).unwrap();
    let force = rows.rows(3, 1).into_owned();
    let damping = ModalDamping::uniform(modes.len(), 0.01);
    assert_eq!(set.h, accelerance(&modes, &damping, &rows, &force, &set.frequencies_hz));
    assert_eq!((set.n_lines(), set.responses.len(), set.coherence), (400, 4, None));
}

/// A dashpot c = β k beside a spring k is damping in proportion to stiffness: ζ = β ω / 2 in each mode; a ratio that is given takes its place.
#[test]
fn modes_have_the_damping_of_the_model() {
    let beta = 2e-4;
    let text = "
retune: 1
name: chain
active_dofs: [ux]
nodes: {a: [0, 0, 0], b: [1, 0, 0], c: [2, 0, 0]}
masses: {m1: {node: b, mass: 2 kg}, m2: {node: c, mass: 3 kg}}
springs: {s1: {nodes: [a, b], k: {ux: 5e4 N/m}, c: {ux: 10 N s/m}}, s2: {nodes: [b, c], k: {ux: 8e4 N/m}, c: {ux: 16 N s/m}}}
supports: {wall: {node: a}}
";
    let model = load(text, &Registry::builtin()).unwrap().0;
    let sensors = node_sensors(&model);
    let test = twin_modes(&model, &[], &sensors, &TwinOptions::default(), "test").unwrap();
    assert_eq!(test.modes.len(), 2);
    for mode in &test.modes {
        let expected = 0.5 * beta * std::f64::consts::TAU * mode.frequency_hz.value;
        let found = mode.damping_ratio.as_ref().unwrap().value;
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
    }
    let given = TwinOptions { damping: Some(0.03), ..TwinOptions::default() };
    let test = twin_modes(&model, &[], &sensors, &given, "test").unwrap();
    assert!(test.modes.iter().all(|m| m.damping_ratio.as_ref().unwrap().value == 0.03));
    // The functions have it too: at the second resonance the last mass answers by the modal sum with these ratios.
    let found = modes(&model, &[], MOST_MODES).unwrap();
    let ratios = found.lambda.iter().map(|l| 0.5 * beta * l.sqrt()).collect();
    let rows = crate::correlation::observation_matrix(&model, &sensors).unwrap();
    let frf = TwinFrfOptions { exciters: vec![sensors[0].name.clone()], ..frf_options(1) };
    let set = twin_frfs(&model, &[], &sensors, &TwinOptions::default(), &frf).unwrap();
    let force = rows.rows(0, 1).into_owned();
    let expected = accelerance(&found, &ModalDamping { ratios }, &rows, &force, &set.frequencies_hz);
    assert!(set.h.iter().zip(&expected).all(|(a, b)| (a - b).norm() < 1e-9 * b.norm()));
}

#[test]
fn estimates_have_the_variance_and_bias_of_theory() {
    let model = model();
    let sensors = node_sensors(&model);
    let options = TwinOptions::default();
    let n = 8_usize;
    let exact = twin_frfs(&model, &[], &sensors, &options, &frf_options(1)).unwrap();
    let response = TwinFrfOptions { response_noise: 0.05, ..frf_options(n) };
    let noisy = twin_frfs(&model, &[], &sensors, &options, &response).unwrap();
    assert_eq!(noisy, twin_frfs(&model, &[], &sensors, &options, &response).unwrap());
    // E|H_1 - H|² = ε² rms² E[1/Σ|F|²] = ε² rms²/(n - 1), for Σ|F|² is gamma distributed with shape n.
    for k in 0..4 {
        let lines = 0..exact.n_lines();
        let rms2 = lines.clone().map(|l| exact.at(l, 0, k).norm_sqr()).sum::<f64>() / 400.0;
        let error2 = lines.map(|l| (noisy.at(l, 0, k) - exact.at(l, 0, k)).norm_sqr()).sum::<f64>() / 400.0;
        let ratio = error2 / (0.05_f64.powi(2) * rms2 / (n as f64 - 1.0));
        // The relative variance of |.|²/... per line is below 2 for n = 8: 400 lines give 0.07; four standard deviations.
        assert!((ratio - 1.0).abs() < 0.28, "{ratio}");
    }
    // Noise of the force alone: E[H_1] = H/(1 + ε_f²).
    let force = TwinFrfOptions { force_noise: 0.5, ..frf_options(200) };
    let biased = twin_frfs(&model, &[], &sensors, &options, &force).unwrap();
    let ratios: Complex<f64> = (0..400).map(|l| biased.at(l, 0, 3) / exact.at(l, 0, 3)).sum::<Complex<f64>>() / 400.0;
    // One line scatters by about ε_f/√n = 0.035, the mean of 400 by 0.0018.
    assert!((ratios - Complex::new(0.8, 0.0)).norm() < 0.008, "{ratios}");
    assert!(biased.coherence.unwrap().iter().all(|c| (0.5..0.95).contains(c)));
}
