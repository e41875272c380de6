//! Arrays of all kinds, written as MATLAB and NumPy would hold them.

use super::*;
use crate::data::FrfQuantity;
use crate::data::convert::{UnitSystem, UnitsFrom};
use crate::data::npy::{Array, Values};
use crate::units::FrequencyUnit;

fn real(name: &str, shape: &[usize], values: &[f64]) -> Variable {
    Variable {
        name: name.into(),
        array: Array { shape: shape.to_vec(), values: Values::Real(values.to_vec()) },
        is_matlab: true,
    }
}

/// Functions whose value at an index of the lines-first order tells the index.
fn complex(name: &str, shape: &[usize]) -> Variable {
    let n: usize = shape.iter().product();
    let values = (0..n).map(|k| Complex::new(k as f64, 1.0)).collect();
    Variable {
        name: name.into(),
        array: Array { shape: shape.to_vec(), values: Values::Complex(values) },
        is_matlab: true,
    }
}

fn options(roles: &str) -> MeasurementOptions {
    let mut options = MeasurementOptions { variables: Roles::parse(roles).unwrap(), ..MeasurementOptions::default() };
    options.frf.units = UnitsFrom::System(UnitSystem::from_name("SI").unwrap());
    options.frf.quantity = Some(FrfQuantity::Accelerance);
    options
}

fn read(variables: Vec<Variable>, roles: &str) -> Result<Option<Found>, MeasurementError> {
    Workspace { variables, others: Vec::new() }.read(&options(roles))
}

fn functions(variables: Vec<Variable>, roles: &str) -> FrfSet {
    read(variables, roles).unwrap().unwrap().functions.unwrap()
}

fn refusal(variables: Vec<Variable>, roles: &str) -> String {
    read(variables, roles).unwrap_err().to_string()
}

const F: [f64; 3] = [1.0, 2.0, 3.0];

#[test]
fn vectors_and_axes_of_any_orientation_are_one_reading() {
    for shape in [&[3][..], &[1, 3], &[3, 1]] {
        let set = functions(vec![real("f", shape, &F), complex("H", &[3, 2])], "");
        assert_eq!((set.n_lines(), set.responses.len(), set.at(2, 0, 1).re), (3, 2, 5.0));
    }
    // Transposed: (responses x lines).
    let set = functions(vec![real("f", &[3], &F), complex("H", &[2, 3])], "");
    assert_eq!((set.responses.len(), set.at(2, 0, 1).re), (2, 5.0));
    // One reference or one response leaves nothing open.
    for shape in [&[3, 1, 2][..], &[3, 2, 1], &[1, 2, 3]] {
        let set = functions(vec![real("f", &[3], &F), complex("H", shape)], "");
        assert_eq!((set.references.len(), set.responses.len()), (1, 2), "{shape:?}");
    }
    let set = functions(vec![real("f", &[3], &F), complex("H", &[3, 2])], "functions=H:lines-references");
    assert_eq!((set.references.len(), set.responses.len()), (2, 1));
    assert_eq!(functions(vec![real("f", &[3], &F), complex("H", &[3])], "").responses.len(), 1);
}

#[test]
fn references_and_responses_are_asked_for_where_programs_differ() {
    let list = || vec![real("f", &[3], &F), complex("H", &[3, 2, 4])];
    assert!(refusal(list(), "").contains("functions=H:lines-responses-references"));
    let set = functions(list(), "functions=H:lines-responses-references");
    // Line 1, response 1 of two, reference 3 of four.
    assert_eq!((set.responses.len(), set.references.len(), set.at(1, 3, 1).re), (2, 4, 15.0));
    let set = functions(list(), "functions=H:references-responses");
    assert_eq!((set.responses.len(), set.references.len(), set.at(1, 1, 3).re), (4, 2, 15.0));
    let mut numpy = list();
    numpy[1].is_matlab = false;
    let found = read(numpy, "").unwrap().unwrap();
    assert_eq!(found.functions.unwrap().references.len(), 2);
    assert!(found.notes.iter().any(|n| n.contains("(lines x references x responses)")), "{:?}", found.notes);
    let last = functions(vec![real("f", &[3], &F), complex("H", &[2, 4, 3])], "functions=H:responses-references");
    assert_eq!((last.responses.len(), last.references.len(), last.at(2, 3, 1).re), (2, 4, 23.0));
}

#[test]
fn real_and_imaginary_parts_are_put_together() {
    let parts = |re: &str, im: &str| {
        vec![real("f", &[3], &F), real(re, &[3, 1], &[1.0, 2.0, 3.0]), real(im, &[3, 1], &[4.0, 5.0, 6.0])]
    };
    for (re, im) in [("Hre", "Him"), ("H_real", "H_imag"), ("data.re", "data.im")] {
        assert_eq!(functions(parts(re, im), "").at(2, 0, 0), Complex::new(3.0, 6.0), "{re}");
    }
    assert_eq!(functions(parts("A", "B"), "functions=A+B").at(2, 0, 0), Complex::new(3.0, 6.0));
    assert!(refusal(parts("A", "B"), "functions=A").contains("REAL+IMAGINARY"));
}

#[test]
fn amplitude_and_phase_are_put_together() {
    let h = Complex::from_polar(2.0, 2.5);
    let parts = |amplitude: &str, phase: &str, one: f64| {
        let phases = [0.0, -0.1, 2.5].map(|p| p * one);
        vec![real("f", &[3], &F), real(amplitude, &[3, 1], &[1.0, 1.0, 2.0]), real(phase, &[3, 1], &phases)]
    };
    let degree = 180.0 / std::f64::consts::PI;
    for (amplitude, phase, one, roles) in [
        ("FRF_abs", "FRF_phase", 1.0, ""),
        ("FRF_abs", "FRF_phase", 1.0, "functions=FRF_abs+FRF_phase"),
        ("H_mag", "H_phase_deg", degree, ""),
        ("H_mag", "H_ang", degree, ""),
    ] {
        let set = functions(parts(amplitude, phase, one), roles);
        assert!((set.at(2, 0, 0) - h).norm() < 1e-12, "{amplitude} {phase}");
    }
    // 25 is not a phase of one unit rather than of the other, and amplitudes in dB are none.
    assert!(refusal(parts("H_mag", "H_phase", 10.0), "").contains("does not say its unit"));
    let mut decibel = parts("H_mag", "H_phase", 1.0);
    decibel[1] = real("H_mag", &[3, 1], &[-20.0, 3.0, 1.0]);
    assert!(refusal(decibel, "").contains("dB"));
}

#[test]
fn vectors_of_one_function_each_are_taken_together_by_their_numbers() {
    let vector = |name: &str, k: f64| Variable {
        name: name.into(),
        array: Array { shape: vec![3, 1], values: Values::Complex(vec![Complex::new(k, 0.0); 3]) },
        is_matlab: true,
    };
    let list = |names: &[(&str, f64)]| {
        let mut all = vec![real("f", &[3], &F)];
        all.extend(names.iter().map(|(n, k)| vector(n, *k)));
        all
    };
    let found = read(list(&[("H31", 3.0), ("H11", 1.0), ("H21", 2.0)]), "").unwrap().unwrap();
    let set = found.functions.unwrap();
    assert_eq!(
        (set.references.len(), (0..3).map(|o| set.at(0, 0, o).re).collect::<Vec<_>>()),
        (1, vec![1.0, 2.0, 3.0])
    );
    assert!(found.notes.iter().any(|n| n.contains("`H11`, `H21`, `H31` are taken together")), "{:?}", found.notes);
    let set = functions(list(&[("H_1_1", 11.0), ("H_1_2", 12.0), ("H_2_1", 21.0), ("H_2_2", 22.0)]), "");
    assert_eq!((set.at(0, 1, 0).re, set.at(0, 0, 1).re), (12.0, 21.0));
    // One named by the user, or a table with a hole, is not stacked.
    assert_eq!(functions(list(&[("H11", 1.0), ("H21", 2.0)]), "functions=H11").responses.len(), 1);
    assert!(
        refusal(list(&[("H11", 1.0), ("H21", 2.0), ("H22", 3.0)]), "")
            .contains("several variables may be the functions")
    );
}

#[test]
fn components_may_be_an_axis_of_functions_and_are_asked_for_among_modes() {
    let list = || vec![real("f", &[4], &[1.0, 2.0, 3.0, 4.0]), complex("H", &[4, 2, 3])];
    assert!(refusal(list(), "").contains("functions=H:lines-points-components"));
    let set = functions(list(), "functions=H:lines-points-components");
    // Line 1, point 2, component y.
    assert_eq!((set.responses.len(), set.at(1, 0, 4).re), (6, 10.0));
    assert_eq!((set.responses[4].name.as_str(), set.responses[4].direction), ("p2", Some([0.0, 1.0, 0.0])));
    // Three modes with three components at each of four points.
    let values: Vec<f64> = (0..36).map(f64::from).collect();
    let list = || vec![real("freq", &[3], &F), real("phi", &[4, 3, 3], &values)];
    let text = refusal(list(), "");
    assert!(
        text.contains("shapes=phi:points-components-modes") && text.contains("shapes=phi:points-modes-components"),
        "{text}"
    );
    let first = |roles: &str| {
        let modes = read(list(), roles).unwrap().unwrap().modes.unwrap();
        modes.modes[1].2.iter().take(4).map(|v| v.re).collect::<Vec<_>>()
    };
    assert_eq!(first("shapes=phi:points-components-modes"), [1.0, 4.0, 7.0, 10.0]);
    assert_eq!(first("shapes=phi:points-modes-components"), [3.0, 4.0, 5.0, 12.0]);
}

#[test]
fn frequencies_are_in_the_unit_of_their_name_or_asked_about() {
    use std::f64::consts::TAU;
    for (name, one) in [("f", 1.0), ("omega", 1.0 / TAU), ("freq_rpm", 1.0 / 60.0), ("f_kHz", 1e3)] {
        let set = functions(vec![real(name, &[3], &F), complex("H", &[3, 2])], "");
        assert_eq!(set.frequencies_hz, F.map(|f| f * one), "{name}");
    }
    let list = || vec![real("axis1", &[3], &F), complex("H", &[3, 2])];
    assert!(refusal(list(), "").contains("frequency-unit"));
    let mut stated = options("");
    stated.frf.frequency_unit = FrequencyUnit::of_label("rad/s");
    let found = Workspace { variables: list(), others: Vec::new() }.read(&stated).unwrap().unwrap();
    assert_eq!(found.functions.unwrap().frequencies_hz, F.map(|f| f / TAU));
    // Beside one another in two units: those in Hz.
    let list = vec![real("omega", &[3], &F.map(|f| f * TAU)), real("freq", &[3], &F), complex("H", &[3, 2])];
    assert_eq!(functions(list, "").frequencies_hz, F);
}

#[test]
fn coherence_and_modes_may_stand_beside_functions() {
    let list = vec![
        real("f", &[3], &F),
        complex("H", &[3, 2]),
        real("coherence", &[3, 2], &[1.0, 0.9, 0.8, 0.7, 0.6, 0.5]),
        real("fn", &[1, 2], &[1.5, 2.5]),
        real("phi", &[2, 2], &[1.0, 2.0, 3.0, -4.0]),
        real("zeta_percent", &[2], &[1.0, 2.0]),
        real("n", &[1, 1], &[2.0]),
    ];
    let found = read(list, "").unwrap().unwrap();
    let set = found.functions.unwrap();
    assert_eq!((set.n_lines(), set.coherence.unwrap()[3]), (3, 0.7));
    let modes = found.modes.unwrap().modes;
    assert_eq!((modes[1].0, modes[1].1), (2.5, Some(0.02)));
    // Columns, with a note as the matrix is square.
    assert_eq!(modes[1].2.iter().map(|v| v.re).collect::<Vec<_>>(), [2.0, -4.0]);
    assert!(found.notes.iter().any(|n| n.contains("columns are taken for modes")), "{:?}", found.notes);
    assert!(found.notes.iter().any(|n| n == "left out: `n`"), "{:?}", found.notes);
}

#[test]
fn shapes_are_read_in_either_orientation_and_with_components() {
    let shape = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
    let modes = |list: Vec<Variable>, roles: &str| read(list, roles).unwrap().unwrap().modes.unwrap();
    let freq = || real("freq", &[2, 1], &[10.0, 20.0]);
    let of = |t: &ModeTable, k: usize| t.modes[k].2.iter().map(|v| v.re).collect::<Vec<_>>();
    assert_eq!(of(&modes(vec![freq(), real("phi", &[3, 2], &shape)], ""), 1), [2.0, 4.0, 6.0]);
    assert_eq!(of(&modes(vec![freq(), real("phi", &[2, 3], &shape)], ""), 1), [4.0, 5.0, 6.0]);
    let square = || vec![freq(), real("phi", &[2, 2], &shape[..4])];
    assert_eq!(of(&modes(square(), "shapes=phi:modes-points"), 1), [3.0, 4.0]);
    assert_eq!(of(&modes(square(), "shapes=phi:points-modes"), 1), [2.0, 4.0]);
    // (points x 3 x modes) with four points.
    let values: Vec<f64> = (0..24).map(f64::from).collect();
    let table = modes(vec![freq(), real("mode_shapes", &[4, 3, 2], &values)], "");
    assert!(table.has_components);
    assert_eq!((of(&table, 1)[..4].to_vec(), table.points.len()), (vec![1.0, 3.0, 5.0, 7.0], 4));
    // Labels of points, and names that only the user knows.
    let list = vec![real("x", &[2], &[10.0, 20.0]), real("V", &[3, 2], &shape), real("nodes", &[3], &[4.0, 7.0, 9.0])];
    assert!(read(list.clone(), "").unwrap().is_none());
    let error = read(list.clone(), "frequency=x,shapes=V").unwrap_err().to_string();
    assert!(error.contains("frequency-unit"), "{error}");
    let mut stated = options("frequency=x,shapes=V");
    stated.frf.frequency_unit = FrequencyUnit::of_label("Hz");
    let found = Workspace { variables: list, others: Vec::new() }.read(&stated).unwrap().unwrap();
    assert_eq!(found.modes.unwrap().points, ["4", "7", "9"]);
}

#[test]
fn poles_give_frequencies_and_damping_once_for_each_pair() {
    let (w, z) = (std::f64::consts::TAU * 10.0, 0.02_f64);
    let pole = Complex::new(-z * w, w * (1.0 - z * z).sqrt());
    let values = Values::Complex(vec![pole, pole.conj()]);
    let poles = Variable { name: "lambda".into(), array: Array { shape: vec![2, 1], values }, is_matlab: true };
    let list = vec![poles, complex("psi", &[3, 2])];
    let modes = read(list, "").unwrap().unwrap().modes.unwrap().modes;
    assert_eq!(modes.len(), 1);
    assert!((modes[0].0 / 10.0 - 1.0).abs() < 1e-12 && (modes[0].1.unwrap() / z - 1.0).abs() < 1e-12);
    // A pole that grows keeps its sign: the checks of the modes tell of it.
    let growing = Values::Complex(vec![Complex::new(z * w, w), Complex::new(-z * w, 2.0 * w)]);
    let poles = Variable { name: "poles".into(), array: Array { shape: vec![2, 1], values: growing }, is_matlab: true };
    let modes = read(vec![poles, complex("psi", &[3, 2])], "").unwrap().unwrap().modes.unwrap().modes;
    assert!(modes[0].1.unwrap() < -0.019 && modes[1].1.unwrap() > 0.0);
    // Real eigenvalues may be many things: only when they are named.
    let list = || vec![real("lambda", &[2], &[w * w, 4.0 * w * w]), real("psi", &[3, 2], &[1.0; 6])];
    assert!(read(list(), "").unwrap().is_none());
    let modes = read(list(), "eigenvalues=lambda").unwrap().unwrap().modes.unwrap().modes;
    assert!((modes[1].0 / 20.0 - 1.0).abs() < 1e-12);
}

#[test]
fn nothing_is_taken_because_it_fits() {
    let list = vec![real("nrb", &[1, 1], &[6.0]), real("selist", &[1, 2], &[0.0, 100.0])];
    assert!(read(list.clone(), "").unwrap().is_none());
    let text = Workspace { variables: list, others: vec!["note".into()] }.question().to_string();
    assert!(text.contains("nrb (1 x 1), selist (1 x 2), note (no array of numbers)"), "{text}");
    let two =
        vec![real("freq", &[2], &[1.0, 2.0]), real("phi_a", &[3, 2], &[1.0; 6]), real("phi_b", &[3, 2], &[1.0; 6])];
    assert!(refusal(two, "").contains("frequency=freq,shapes=phi_b"));
    let wrong = vec![real("freq", &[2], &[1.0, 2.0]), real("V", &[3, 4], &[1.0; 12])];
    assert!(refusal(wrong, "shapes=V").contains("no axis of it has the length of freq (2)"));
    let list = vec![real("freq", &[2], &[1.0, f64::NAN]), real("phi", &[3, 2], &[1.0; 6])];
    assert!(refusal(list, "").contains("value 2 is NaN"));
    assert!(refusal(vec![real("freq", &[1], &[1.0])], "shapes=pih").contains("no such variable"));
}

#[test]
fn roles_are_parsed_or_refused_with_the_nearest() {
    assert!(Roles::parse("shape=V").unwrap_err().contains("did you mean `shapes`?"));
    assert!(Roles::parse("V").unwrap_err().contains("role=name"));
    assert!(Roles::parse("shapes=V,shapes=W").unwrap_err().contains("twice"));
    let roles = Roles::parse(" frequency = f , functions = a:b:lines-responses ").unwrap();
    assert_eq!((roles.list[1].name.as_str(), roles.list[1].axes.len()), ("a:b", 2));
}

#[test]
fn structures_and_cells_come_apart() {
    use crate::data::mat::Value;
    let number = |v: f64| Value::Real { dims: vec![1, 1], values: vec![v] };
    let vector = |v: [f64; 3]| Value::Real { dims: vec![3, 1], values: v.to_vec() };
    let modes = Value::Structure {
        dims: vec![1, 2],
        fields: vec![
            ("freq".into(), vec![number(5.0), number(9.0)]),
            ("shape".into(), vec![vector([1.0, 2.0, 3.0]), vector([4.0, 5.0, 6.0])]),
            ("label".into(), vec![Value::Text("a".into()), Value::Text("b".into())]),
        ],
    };
    let held = of_matlab(vec![("modes".into(), modes), ("note".into(), Value::Text("x".into()))]);
    assert_eq!(held.others, ["modes.label", "note"]);
    let names: Vec<String> = held.variables.iter().map(Variable::label).collect();
    assert_eq!(names, ["modes.freq (1 x 1 x 2)", "modes.shape (3 x 1 x 2)"]);
    let table = held.read(&options("")).unwrap().unwrap().modes.unwrap();
    assert_eq!(table.modes[1].2.iter().map(|v| v.re).collect::<Vec<_>>(), [4.0, 5.0, 6.0]);
    let cell = Value::Cell { dims: vec![1, 2], values: vec![vector([1.0; 3]), number(2.0)] };
    assert_eq!(of_matlab(vec![("c".into(), cell)]).others, ["c"]);
}
