//! A measured mode that is not of the structure, or one that is missing, must not move a right model.
//!
//! A few modes on each structure by default; 200 each with `RETUNE_SLOW=1`.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use retune::data::{Partner, Standing, TestData, TestMode};
use retune::model::{Model, ParametricModel, Registry, load};
use retune::objective::starting_point;
use retune::optim::Draw;
use retune::update::{
    Controls, HowToPair, Settings, TwinOptions, Update, assess, compared, node_sensors, paired_test, twin_modes, update,
};
use retune_diagnosis::benchmark::{STRUCTURES, foreign_mode};

/// Noise that the tests state and have.
const FREQUENCY: f64 = 0.003;
const SHAPE: f64 = 0.02;

fn n_each() -> u64 {
    if std::env::var("RETUNE_SLOW").as_deref() == Ok("1") { 200 } else { 2 }
}

fn model(text: &str) -> Model {
    // A twin with other masses is not as heavy as the file says that its structure is.
    let text = text.split("\n\n").filter(|part| !part.starts_with("targets:")).collect::<Vec<_>>().join("\n\n");
    load(&text, &Registry::builtin()).expect("a model of the repository").0
}

/// A twin of a model whose parameters are some percent off.
fn twin(model: &Model, n_modes: usize, seed: u64) -> TestData {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut theta = starting_point(model);
    for (value, p) in theta.iter_mut().zip(model.parameters().iter()) {
        if let Some([lower, upper]) = p.bounds {
            let moved = *value * (1.0 + 0.08 * (2.0 * rng.unit() - 1.0));
            *value = moved.clamp(lower + 0.02 * (upper - lower), upper - 0.02 * (upper - lower));
        }
    }
    let options = TwinOptions {
        n_modes,
        frequency_noise: FREQUENCY,
        shape_noise: SHAPE,
        damping: Some(0.0),
        seed,
        ..TwinOptions::default()
    };
    twin_modes(model, &theta, &node_sensors(model), &options, "a twin").expect("a twin")
}

/// A mode of no structure.
fn foreign(test: &TestData, seed: u64) -> TestMode {
    foreign_mode(test, &mut ChaCha8Rng::seed_from_u64(seed + 7_000), FREQUENCY, SHAPE)
}

/// With one mode more, in its place.
fn with(test: &TestData, mode: TestMode) -> (TestData, usize) {
    let mut out = test.clone();
    let at = out.modes.partition_point(|m| m.frequency_hz.value < mode.frequency_hz.value);
    out.modes.insert(at, mode);
    (out, at)
}

fn probable() -> Settings {
    Settings { pairing: HowToPair::probable(), ..Settings::default() }
}

fn fitted(model: &Model, test: &TestData) -> Update {
    update(model, test, &probable(), Controls::default()).expect("a fit")
}

/// Largest change of an estimate, in standard deviations of the fit without it.
fn pull(without: &Update, other: &Update) -> (f64, String) {
    let mut most = (0.0, String::new());
    for p in &without.uncertainty.parameters {
        let value = |u: &Update| u.parameters.iter().find(|q| q.name == p.name).map(|q| q.after);
        if let (Some(sd), Some(a), Some(b)) = (p.sd, value(without), value(other))
            && (a - b).abs() / sd > most.0
        {
            most = ((a - b).abs() / sd, p.name.clone());
        }
    }
    most
}

/// Fits twins of every structure as they are and disturbed: no estimate moves by a standard deviation.
///
/// * `disturb` - a twin with something wrong in it, from its seed, and where
/// * `missed` - of the twin, where, and both fits: what else is wrong with the second
fn pulls_nothing(
    disturb: impl Fn(&TestData, u64) -> (TestData, usize),
    missed: impl Fn(&TestData, usize, [&Update; 2]) -> Option<String>,
) {
    let mut wrong = Vec::new();
    for (name, text) in STRUCTURES {
        let model = model(text);
        for seed in 0..n_each() {
            let test = twin(&model, 7, seed);
            let clean = fitted(&model, &test);
            let (disturbed, at) = disturb(&test, seed);
            let found = fitted(&model, &disturbed);
            let (most, which) = pull(&clean, &found);
            if most > 1.0 {
                wrong.push(format!("{name}, seed {seed}: {which} moves by {most:.1} standard deviations"));
            }
            wrong.extend(missed(&test, at, [&clean, &found]).map(|what| format!("{name}, seed {seed}: {what}")));
        }
    }
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn one_arbitrary_mode_more_pulls_nothing() {
    pulls_nothing(
        |test, seed| with(test, foreign(test, seed)),
        |_, at, [_, found]| {
            let unpaired: Vec<usize> = found.after.unpaired_test.iter().map(|u| u.mode).collect();
            let is_missed = unpaired != [at] || found.after.unpaired_test[0].foreign.is_none_or(|p| p < 0.5);
            is_missed.then(|| format!("{at} is foreign, not {:?}", found.after.unpaired_test))
        },
    );
}

/// One sensor turned over, the one that reads most: its readings take no part, it is named, and no estimate moves by a standard deviation.
#[test]
fn a_sensor_that_is_turned_over_pulls_nothing() {
    let turned = |test: &TestData, _: u64| {
        let reads = |s: usize| test.modes.iter().filter_map(|m| m.shape.as_ref()).map(|y| y[s].norm_sqr()).sum::<f64>();
        let turned = (0..test.sensors.len()).max_by(|&a, &b| reads(a).total_cmp(&reads(b))).expect("sensors");
        let mut faulty = test.clone();
        for shape in faulty.modes.iter_mut().filter_map(|m| m.shape.as_mut()) {
            shape[turned] = -shape[turned];
        }
        (faulty, turned)
    };
    pulls_nothing(turned, |test, at, [clean, found]| {
        let name = &test.sensors[at].name;
        let is_missed = found.left_out != [[name.clone()]] || !clean.left_out.concat().is_empty();
        is_missed.then(|| format!("{name} is turned, not {:?}", found.left_out))
    });
}

/// One mode less tells less: estimates move by what the mode told, which is noise of the size that the fit without it states (its
/// standard deviations, three and a half for the largest of all parameters and structures), and no pair changes.
#[test]
fn one_mode_less_pairs_the_others_as_before() {
    for (name, text) in STRUCTURES {
        let model = model(text);
        for seed in 0..n_each() {
            let test = twin(&model, 7, seed);
            let clean = fitted(&model, &test);
            let out = seed as usize % test.modes.len();
            let mut less = test.clone();
            less.modes.remove(out);
            let found = fitted(&model, &less);
            assert!(found.after.unpaired_test.is_empty(), "{name}, seed {seed}: {:?}", found.after.unpaired_test);
            // By name: torsion of the free beam, which no sensor sees, may come to lie on either side of a mode.
            let partner =
                |u: &Update, hz: f64| u.after.pairs.iter().find(|p| p.test_hz == hz).map(|p| p.model_label.clone());
            for m in &less.modes {
                let hz = m.frequency_hz.value;
                assert_eq!(partner(&found, hz), partner(&clean, hz), "{name}, seed {seed}: {hz} Hz");
            }
            let (most, which) = pull(&found, &clean);
            assert!(most < 3.5, "{name}, seed {seed}: {which} moves by {most} standard deviations");
        }
    }
}

fn frame() -> Model {
    model(STRUCTURES.iter().find(|s| s.0 == "frame").expect("the frame").1)
}

/// The mode of 78.8 Hz with a shape of its own: it was paired with 447 Hz and dragged the first mode from 18.60 to 14.53 Hz.
#[test]
fn a_foreign_mode_of_the_frame_drags_nothing() {
    let model = frame();
    for seed in 0..4 {
        let test = twin(&model, 6, seed);
        let mut mode = foreign(&test, seed);
        (mode.frequency_hz.value, mode.frequency_hz.sd) = (78.8, FREQUENCY * 78.8);
        let (more, _) = with(&test, mode);
        let (clean, found) = (fitted(&model, &test), fitted(&model, &more));
        let (a, b) = (clean.after.pairs[0].model_hz, found.after.pairs[0].model_hz);
        assert!((a / b - 1.0).abs() < 1e-4, "{a} Hz, with the foreign mode {b} Hz");
        assert_eq!(found.after.unpaired_test.len(), 1);
        let reason = found.after.unpaired_test[0].reason.clone().unwrap_or_default();
        assert!(reason.contains("foreign with probability") && reason.contains("its largest MAC is"), "{reason}");
    }
}

/// A mode known by its frequency alone finds its partner among modes with shapes.
#[test]
fn a_mode_without_a_shape_is_paired_by_frequency() {
    for (name, text) in STRUCTURES {
        let model = model(text);
        let test = twin(&model, 7, 3);
        let clean = fitted(&model, &test);
        for out in [1, 4] {
            let mut half = test.clone();
            (half.modes[out].shape, half.modes[out].shape_sd) = (None, None);
            let found = fitted(&model, &half);
            let of = |u: &Update| u.after.pairs.iter().map(|p| (p.test_mode, p.model_mode)).collect::<Vec<_>>();
            assert_eq!(of(&found), of(&clean), "{name}, without the shape of mode {}", out + 1);
            assert!(found.after.misfit.p_value > 1e-3, "{name}: {}", found.after.misfit);
        }
    }
}

/// Labels that are all wrong do not pair a mode that has a shape.
#[test]
fn wrong_labels_lose_to_shapes() {
    let model = model(STRUCTURES.iter().find(|s| s.0 == "aeroplane").expect("the aeroplane").1);
    let test = twin(&model, 7, 5);
    let clean = fitted(&model, &test);
    let mut wrong = test.clone();
    let labels: Vec<_> = test.modes.iter().map(|m| m.label.clone()).collect();
    let n = labels.len();
    for (i, mode) in wrong.modes.iter_mut().enumerate() {
        mode.label.clone_from(&labels[(i + 1) % n]);
    }
    let found = fitted(&model, &wrong);
    let of = |u: &Update| u.after.pairs.iter().map(|p| (p.test_mode, p.model_mode)).collect::<Vec<_>>();
    assert_eq!(of(&found), of(&clean));
}

/// Two symmetry labels of eight force nothing: frequencies without shapes stay with their neighbours.
#[test]
fn a_few_symmetry_labels_force_no_pair() {
    let model = model(STRUCTURES.iter().find(|s| s.0 == "aeroplane").expect("the aeroplane").1);
    let mut test = twin(&model, 8, 2);
    for (i, mode) in test.modes.iter_mut().enumerate() {
        (mode.shape, mode.shape_sd) = (None, None);
        mode.label =
            [None, Some("Anti"), None, None, Some("symmetric")][i.min(4)].filter(|_| i < 5).map(str::to_string);
    }
    let paired = paired_test(&model, None, &test, &HowToPair::probable()).unwrap();
    let comparison = compared(&model, &paired.test, &HowToPair::probable()).unwrap();
    let found = assess(&comparison, &starting_point(&model)).unwrap();
    assert!(!found.pairs.is_empty());
    for p in &found.pairs {
        assert!(p.error_percent.abs() < 40.0, "{} Hz with {} Hz", p.test_hz, p.model_hz);
    }
}

/// The user's word stands above all, and what it names must exist.
#[test]
fn the_users_word_pairs() {
    let model = frame();
    let mut test = twin(&model, 6, 1);
    test.modes[2].standing = Standing::With(Partner::Number(4));
    test.modes[3].standing = Standing::Unused;
    test.modes[4].standing = Standing::Foreign;
    let found = fitted(&model, &test);
    assert!(found.after.pairs.iter().any(|p| (p.test_mode, p.model_mode) == (2, 3)));
    let unpaired: Vec<usize> = found.after.unpaired_test.iter().map(|u| u.mode).collect();
    assert!(unpaired.contains(&3) && unpaired.contains(&4), "{unpaired:?}");
    test.modes[2].standing = Standing::With(Partner::Number(400));
    let error = update(&model, &test, &probable(), Controls::default()).unwrap_err().to_string();
    assert!(error.contains("400 is not a mode of the model"), "{error}");
}

/// Gates tell what they keep out, and how to open them.
#[test]
fn gates_say_what_they_keep_out() {
    let model = frame();
    let mut test = twin(&model, 6, 1);
    let hz = 1.5 * test.modes[5].frequency_hz.value;
    (test.modes[5].frequency_hz.value, test.modes[5].frequency_hz.sd) = (hz, FREQUENCY * hz);
    let how = HowToPair { frequency_window: Some(0.3), ..HowToPair::probable() };
    let paired = paired_test(&model, None, &test, &how).unwrap();
    let comparison = compared(&model, &paired.test, &how).unwrap();
    let found = assess(&comparison, &starting_point(&model)).unwrap();
    let reason = found.unpaired_test[0].reason.clone().unwrap_or_default();
    assert!(reason.contains("outside the frequency window") && reason.contains("`--frequency-window`"), "{reason}");
}

/// A limit of the user stays one in a fit, however many modes it puts aside, and a mode that is foreign anyway keeps its probability.
#[test]
fn a_narrow_window_of_the_user_wins_in_a_fit() {
    let model = frame();
    let test = twin(&model, 6, 1);
    let (more, at) = with(&test, foreign(&test, 1));
    let narrow =
        Settings { pairing: HowToPair { frequency_window: Some(1e-5), ..HowToPair::probable() }, ..probable() };
    let settled = update(&model, &more, &narrow, Controls::default());
    let reasons: Vec<String> = match settled {
        Ok(found) => found.after.unpaired_test.iter().map(|u| u.reason.clone().unwrap_or_default()).collect(),
        Err(e) => vec![e.to_string()],
    };
    assert!(reasons.iter().any(|r| r.contains("the frequency window of 0.001 %")), "{reasons:?}");
    let wide = Settings { pairing: HowToPair { min_mac: Some(0.5), ..HowToPair::probable() }, ..probable() };
    let found = update(&model, &more, &wide, Controls::default()).unwrap().after;
    assert_eq!(found.unpaired_test.len(), 1);
    let lost = &found.unpaired_test[0];
    assert_eq!(lost.mode, at);
    assert!(lost.foreign.is_some_and(|p| p > 0.9), "{lost:?}");
    assert!(!lost.reason.as_deref().unwrap_or_default().contains("--min-mac"), "{lost:?}");
    // What takes no part has its MAC all the same.
    let largest = found.mac.column(at).max();
    assert!(largest > 0.0 && lost.best.is_some_and(|b| b.1 == largest), "{lost:?}");
}

/// A partner that the user gives to the wrong mode is used, and its own mode says where it went.
#[test]
fn a_wrong_partner_of_the_user_is_told() {
    let model = frame();
    let mut test = twin(&model, 6, 1);
    let (more, at) = with(&test, foreign(&test, 1));
    test = more;
    test.modes[at].standing = Standing::With(Partner::Number(1));
    let found = fitted(&model, &test).after;
    let forced = found.pairs.iter().find(|p| p.test_mode == at).unwrap();
    assert!(forced.by_user && forced.probability.is_some_and(|p| p < 0.01), "{forced:?}");
    assert!(forced.doubt().is_some_and(|d| d.contains("`pair_with`") && d.contains("MAC")));
    let lost = found.unpaired_test.iter().find(|u| u.mode != at).unwrap();
    let reason = lost.reason.clone().unwrap_or_default();
    assert!(lost.foreign.is_none() && reason.contains("which `pair_with` gives to test mode"), "{reason}");
    assert!(found.pairs.iter().all(|p| p.test_mode == at || p.doubt().is_none()));
}

/// A model that has not been updated may be off by a factor, and not by a hundred where the shapes are hardly alike.
#[test]
fn a_comparison_pairs_no_mode_at_an_absurd_distance() {
    for (name, text) in STRUCTURES {
        let model = model(text);
        for seed in 0..4 {
            let test = twin(&model, 6, seed);
            let mut mode = foreign(&test, 40 + seed);
            let hz = mode.frequency_hz.value / 60.0;
            (mode.frequency_hz.value, mode.frequency_hz.sd) = (hz, FREQUENCY * hz);
            let (more, at) = with(&test, mode);
            let paired = paired_test(&model, None, &more, &HowToPair::probable()).unwrap();
            let comparison = compared(&model, &paired.test, &HowToPair::probable()).unwrap();
            let found = assess(&comparison, &starting_point(&model)).unwrap();
            let lost: Vec<usize> = found.unpaired_test.iter().map(|u| u.mode).collect();
            assert_eq!(lost, [at], "{name}, seed {seed}");
        }
    }
}
