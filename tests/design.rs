//! Shear panels of decks, and design variables by equations.

use retune::deck::Deck;
use retune::modal::SolveOptions;
use retune::model::{Model, ParametricModel, Registry, load, solve_modes};
use retune_exchange::{ImportOptions, Imported, Solver, compare_results, export, import, read_results, system_by_name};
use std::f64::consts::TAU;
use std::path::Path;

fn deck_of(text: &str) -> Deck {
    Deck::read(Path::new("deck.bdf"), &mut |_| Ok(text.as_bytes().to_vec())).unwrap()
}

fn options() -> ImportOptions {
    ImportOptions {
        system: system_by_name("si").unwrap(),
        subcase: None,
        parameter_per_property: false,
        solver: Solver::default(),
    }
}

fn imported(text: &str) -> Imported {
    import(&deck_of(text), options()).unwrap_or_else(|e| panic!("{}", e[0]))
}

fn refusal(text: &str) -> String {
    import(&deck_of(text), options()).map(|i| i.text).unwrap_err()[0].to_string()
}

fn model_of(text: &str) -> Model {
    load(text, &Registry::builtin()).unwrap_or_else(|p| panic!("{}\n{text}", p[0].message)).0
}

fn model(text: &str) -> Model {
    model_of(&imported(text).text)
}

fn frequencies(model: &Model, theta: &[f64], n: usize) -> Vec<f64> {
    let modes = solve_modes(model, theta, SolveOptions { n_elastic: n, shift: None }).unwrap();
    modes.elastic().map(|i| modes.frequency_hz(i)).collect()
}

#[track_caller]
fn near(a: f64, b: f64, part: f64) {
    assert!((a / b - 1.0).abs() < part, "{a} is not {b} within {part:e}");
}

/// A bay of two rods and a panel, 0.5 m by 0.2 m, held at two corners; a mass on each of the others, which move along y alone.
fn bay(pshear: &str) -> String {
    format!(
        "CEND\nSPC=1\nBEGIN BULK\nGRID,1\nGRID,2,,.5\nGRID,3,,.5,.2\nGRID,4,,0.,.2\nMAT1,1,7.+10,,.3\nCSHEAR,9,5,1,2,3,4\n{pshear}\
         CONM2,11,2,,3.\nCONM2,12,3,,3.\nSPC1,1,123456,1,4\nSPC1,1,13456,2,3\nENDDATA\n"
    )
}

/// The free side slides along y: k = G t b/a on the masses of both corners; what the edges carry beside resists their distance, E A/b each side.
#[test]
fn a_panel_shears_and_its_edges_stretch() {
    let (a, b, t): (f64, f64, f64) = (0.5, 0.2, 1e-3);
    let shear = 7e10 / 2.6 * t * b / a;
    // Nothing but the panel leaves their distance free.
    let found = frequencies(&model(&bay("PSHEAR,5,1,.001\n")), &[], 2);
    near(found[1], (shear / 6.0).sqrt() / TAU, 1e-9);
    for (card, area) in [
        ("PSHEAR,5,1,.001,,,1.\n", 0.5 * t * a),
        ("PSHEAR,5,1,.001,,,.4\n", 0.2 * t * a),
        ("PSHEAR,5,1,.001,,,30.\n", 15.0 * t * t),
    ] {
        let found = frequencies(&model(&bay(card)), &[], 2);
        near(found[0], (shear / 6.0).sqrt() / TAU, 1e-9);
        // Both masses against the rod between them.
        near(found[1], (2.0 * 7e10 * area / b / 3.0).sqrt() / TAU, 1e-9);
    }
    let heavy = model(&bay("PSHEAR,5,1,.001,5.\n"));
    near(heavy.mass_properties(&[]).unwrap().unwrap().mass, 6.0 + 5.0 * a * b, 1e-9);
    for (card, message) in [
        ("PSHEAR,5,1,0.\n", "PSHEAR 5, field 4 (T): the thickness must be above zero"),
        ("PSHEAR,5,1,.001,,-1.\n", "field 6 (F1): it must not be negative"),
        ("PSHEAR,5,2,.001\n", "field 3 (MID): there is no material 2"),
        ("PSHELL,5,1,.001\n", "and PSHEAR is expected"),
    ] {
        let found = refusal(&bay(card));
        assert!(found.contains(message), "{found}");
    }
}

/// A thickness that a design variable moves, with the edges it carries, and back into the deck.
#[test]
fn the_thickness_of_a_panel_is_designed() {
    let designed = bay("PSHEAR,5,1,.001,,,.8\nDESVAR,1,WEB,1.,.5,2.\nDVPREL1,1,PSHEAR,5,T,,,,\n,1,.001\n");
    let own = model(&designed);
    for t in [1.0, 1.7] {
        let expected = frequencies(&model(&bay(&format!("PSHEAR,5,1,{:.4},,,.8\n", t * 1e-3))), &[], 2);
        for (f, e) in frequencies(&own, &[t], 2).into_iter().zip(expected) {
            near(f, e, 1e-9);
        }
    }
    let plain = bay("PSHEAR,5,1,.001,,,.8\n");
    let text = imported(&plain).text.replace("imported:", "overrides: {pshear_5: {stiffness: 1.1}}\nimported:");
    let out = export(&deck_of(&plain), &model_of(&text)).unwrap();
    assert!(out.files[0].contains("MAT1,1,7.7+10,,.3\n"), "{}", out.files[0]);
}

/// Fields by equations that are sums: constants of DTABLE, several statements; others are refused with the reason.
#[test]
fn fields_follow_equations_that_are_sums() {
    let deck = |equation: &str| {
        format!(
            "CEND\nSPC=1\nBEGIN BULK\nGRID,1\nGRID,2,,1.\nMAT1,1,2.+11,8.+10\nCBAR,1,7,1,2,0.,0.,1.\nPBAR,7,1,1.-3,4.-8,9.-8,1.-7\nCONM2,3,2,,2.\n\
             DESVAR,1,X,4.,1.,9.\nDESVAR,2,Y,2.,1.,9.\nDTABLE,SCALE,1.-8\nDVPREL2,1,PBAR,7,I1,,,10\n,DESVAR,1,2,,,,,,\n,DTABLE,SCALE\n{equation}SPC1,1,123456,1\nENDDATA\n"
        )
    };
    // I1 is (4 + 2/2) 1e-8 m4, in plane 1, in which y is z of the deck; the other plane is stiffer.
    let tip = |i: f64| (3.0 * 2e11 * i / 2.0).sqrt() / TAU;
    for equation in ["DEQATN  10      F(A,B,C)=C*(A+0.5*B)\n", "DEQATN  10      F(A,B,C)=A+0.5*B;\n        G=F*C\n"] {
        let own = model(&deck(equation));
        near(frequencies(&own, &own.parameters().nominal(), 1)[0], tip(5e-8), 1e-9);
        let x = own.parameters().index_of("x_1").unwrap();
        let mut theta = own.parameters().nominal();
        theta[x] = 6.0;
        near(frequencies(&own, &theta, 1)[0], tip(7e-8), 1e-9);
    }
    for (equation, message) in [
        (
            "DEQATN  10      F(A,B,C)=A*B*C\n",
            "DVPREL2 1, field 8 (EQID): DEQATN 10 is not a sum of its variables: it multiplies its arguments",
        ),
        ("DEQATN  10      F(A,B)=A+B\n", "DEQATN 10 has 2 arguments, and the card gives 3"),
        ("DEQATN  11      F(A,B,C)=A\n", "there is no DEQATN 10"),
    ] {
        let found = refusal(&deck(equation));
        assert!(found.contains(message), "{found}");
    }
}

/// An interval of ω² is one of a frequency.
#[test]
fn eigenvalues_are_asked_for_as_frequencies() {
    let deck = "SOL 200\nCEND\nDESSUB=4\nBEGIN BULK\nGRID,1,,,,,,23456\nCONM2,3,1,,2.\nCELAS2,4,1000.,1,1\nDESVAR,1,X,1.,.5,2.\nDRESP1,1,EIG,EIGN,,,1\nDCONSTR,4,1,400.,900.\nENDDATA\n";
    let test = imported(deck).test.unwrap();
    // 20 and 30 rad/s; the one dof is held by a spring, so that the first mode is an elastic one.
    assert!(test.contains("frequency: 3.9788735773 Hz, frequency_sd: 0.795774715459 Hz, pair_with: 1"), "{test}");
}

/// Matrices of OUTPUT4, as text: two masses on springs, k = 300, 100, m = 2, 1: the same frequencies as the deck.
#[test]
fn matrices_prove_a_model() {
    let deck = "CEND\nBEGIN BULK\nGRID,1,,,,,,23456\nGRID,2,,1.,,,,23456\nCONM2,11,1,,2.\nCONM2,12,2,,1.\nCELAS2,1,300.,1,1\nCELAS2,2,100.,1,1,2,1\nENDDATA\n";
    let matrix = |name: &str, [a, b, c]: [f64; 3]| {
        format!(
            "       2       2       6       2{name:<8}1P,3E23.16\n       1       1       2\n{a:23.16E}{b:23.16E}\n       2       1       2\n{b:23.16E}{c:23.16E}\n       3       1       1\n{:23.16E}\n",
            1.0
        )
    };
    let text = matrix("KAA", [400.0, -100.0, 100.0]) + &matrix("MAA", [2.0, 0.0, 1.0]);
    let found = read_results(text.as_bytes()).unwrap();
    assert_eq!(found.kind, "op4");
    let agreement = compare_results(&model(deck), &found, 5).unwrap();
    assert!(agreement.modes.len() == 2 && agreement.holds(1e-9, 1.0), "{agreement:?}");
    let wrong = read_results(text.replace("MAA", "BAA").as_bytes()).unwrap_err().to_string();
    assert!(wrong.contains("it holds KAA, BAA; a stiffness and a mass of one set"), "{wrong}");
}

/// Two masses in a row on springs k1 = 300 x and 100 lbf/in, of 2 and 1 lb; the second moves along the second axis of its own coordinates.
fn two_masses(extra: &str, method: &str) -> String {
    format!(
        "SOL 200\nCEND\nDESSUB=4\nMETHOD=7\nBEGIN BULK\nPARAM,WTMASS,.00259\n{method}\nCORD2R,5,,0.,0.,0.,0.,0.,1.\n,0.,-1.,0.\nGRID,1,,,,,,23456\nGRID,2,,1.,,,5,13456\n\
         CONM2,11,1,,2.\nCONM2,12,2,,1.\nCELAS2,1,300.,1,1\nCELAS2,2,100.,1,1,2,2\nDESVAR,1,X,1.,.2,5.\nDVCREL1,1,CELAS2,1,K,,,,\n,1,300.\n{extra}ENDDATA\n"
    )
}

/// Displacements of the first mode of unit generalised mass, of masses in slinch, and their ratio: from the quadratic equation.
fn first_shape(x: f64) -> [f64; 2] {
    let (m1, m2, k1, k2) = (2.0 * 0.00259, 0.00259, 300.0 * x, 100.0_f64);
    // (k1 + k2 - λ m1)(k2 - λ m2) = k2².
    let (a, b, c) = (m1 * m2, -(m1 * k2 + m2 * (k1 + k2)), k1 * k2);
    let lambda = (-b - (b * b - 4.0 * a * c).sqrt()) / (2.0 * a);
    let ratio = k2 / (k2 - lambda * m2);
    let u = 1.0 / (m1 + m2 * ratio * ratio).sqrt();
    [u, u * ratio]
}

fn in_pounds(text: &str) -> Imported {
    let options = ImportOptions { system: system_by_name("in-lbf-s").unwrap(), ..options() };
    import(&deck_of(text), options).unwrap_or_else(|e| panic!("{}", e[0]))
}

/// Components of eigenvectors of unit generalised mass (the default), of those scaled to a point, and ratios by DRESP2: the update finds the
/// stiffness whose closed form gave them.
#[test]
fn components_of_eigenvectors_are_targets_of_an_update() {
    use retune::data::read_test;
    use retune::update::{Controls, Settings, update};
    let truth = 1.7;
    let [u1, u2] = first_shape(truth);
    let interval = |v: f64| format!("{:.8},{:.8}", v * 0.999, v * 1.001);
    let disp = "DRESP1,1,U1,DISP,,,1,1,1\nDRESP1,2,U2,DISP,,,2,1,2\n";
    let cases = [
        (format!("{disp}DCONSTR,4,1,{}\n", interval(u1)), "EIGRL,7,,,2"),
        // The sign of a shape is any.
        (
            format!(
                "{disp}DCONSTR,4,2,{}\n",
                "-LOW,-HIGH"
                    .replace("LOW", &format!("{:.8}", u2 * 1.001))
                    .replace("HIGH", &format!("{:.8}", u2 * 0.999))
            ),
            "EIGRL,7,,,2,,,,MASS",
        ),
        (format!("{disp}DCONSTR,4,2,{}\n", interval(u2 / u1)), "EIGR,7,LAN,,,,2\n,POINT,1,1"),
        (
            format!("{disp}DRESP2,3,R,9\n,DRESP1,2,1\nDEQATN  9       F(A,B)=A/B\nDCONSTR,4,3,{}\n", interval(u2 / u1)),
            "EIGRL,7,,,2,,,,MAX",
        ),
    ];
    for (extra, method) in cases {
        let imported = in_pounds(&two_masses(&extra, method));
        let text = imported.test.as_ref().unwrap_or_else(|| panic!("{}", imported.report));
        let test = read_test(text).map_err(|p| format!("{}\n{text}", p[0])).unwrap().0;
        let model = model_of(&imported.text);
        let found = update(&model, &test, &Settings::default(), Controls::default()).unwrap();
        near(found.parameters[0].after, truth, 1e-5);
    }
}

/// What is not a target says so by name: an eigenvector scaled to its largest component, a motion without frequency, a component that is one.
#[test]
fn components_that_cannot_be_targets_are_named() {
    let disp = "DRESP1,1,U1,DISP,,,1,1,1\nDCONSTR,4,1,1.,2.\n";
    let note = |deck: &str| {
        let imported = in_pounds(deck);
        assert!(imported.test.is_none());
        imported.report.to_string()
    };
    for (method, expected) in [
        (
            "EIGRL,7,,,2,,,,MAX",
            "component 1 of grid 1 in the eigenvector of mode 1 is not a target: eigenvectors are scaled to their largest component (EIGRL 7, NORM MAX)",
        ),
        ("EIGR,7,LAN,,,,2\n,POINT,1,1", "is not a target: it is one by itself"),
    ] {
        let found = note(&two_masses(disp, method));
        assert!(found.contains(expected), "{found}");
    }
    let free = two_masses(disp, "EIGRL,7,,,2")
        .replace("CELAS2,1,300.,1,1\n", "CELAS2,1,300.,1,1,3,1\nCONM2,13,3,,1.\nGRID,3,,-1.,,,,23456\n");
    let found = note(&free);
    assert!(
        found.contains("the component n1_t1 of mode 1 is left out: the mode is a motion without frequency"),
        "{found}"
    );
    let wrong = two_masses(disp, "EIGRL,7,,,2,,,,MAS");
    let options = ImportOptions { system: system_by_name("in-lbf-s").unwrap(), ..options() };
    let found = import(&deck_of(&wrong), options).unwrap_err()[0].to_string();
    assert!(found.contains("EIGRL 7, field 9 (NORM): `MAS` where MASS, MAX is expected"), "{found}");
}
