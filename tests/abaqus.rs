//! Decks of Abaqus and CalculiX become models.
//!
//! Small decks against closed forms and against models that say the same otherwise; CalculiX itself on the same decks where `ccx` is
//! installed, and a real bridge where its folder is there (`RETUNE_DATA`, or `../shared/data` beside this package): tests skip with a message
//! otherwise.

use retune::deck::KeywordDeck;
use retune::exchange::{
    Agreement, ImportOptions, Imported, KEYWORDS, Solver, compare_results, import_keywords, read_results,
    system_by_name,
};
use retune::modal::SolveOptions;
use retune::model::{Model, ParametricModel, Registry, load, solve_modes};
use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

fn options(solver: Solver) -> ImportOptions {
    ImportOptions { system: system_by_name("si").unwrap(), subcase: None, parameter_per_property: false, solver }
}

fn deck_of(text: &str) -> KeywordDeck {
    KeywordDeck::read(Path::new("deck.inp"), &mut |_| Ok(text.as_bytes().to_vec())).unwrap_or_else(|e| panic!("{e}"))
}

fn imported(text: &str, solver: Solver) -> Imported {
    import_keywords(&deck_of(text), options(solver)).unwrap_or_else(|e| panic!("{}", e[0]))
}

fn model_of(imported: &Imported) -> Model {
    load(&imported.text, &Registry::builtin()).unwrap_or_else(|p| panic!("{}\n{}", p[0].message, imported.text)).0
}

fn model(text: &str) -> Model {
    model_of(&imported(text, Solver::Abaqus))
}

fn refusal(text: &str) -> String {
    let deck = match KeywordDeck::read(Path::new("deck.inp"), &mut |_| Ok(text.as_bytes().to_vec())) {
        Ok(deck) => deck,
        Err(e) => return e.to_string(),
    };
    match import_keywords(&deck, options(Solver::Abaqus)) {
        Ok(imported) => panic!("it was read\n{}", imported.text),
        Err(errors) => errors[0].to_string(),
    }
}

/// Elastic frequencies, Hz, and the number of rigid-body modes.
fn frequencies(model: &Model, n: usize) -> (Vec<f64>, usize) {
    let modes = solve_modes(model, &model.parameters().nominal(), SolveOptions { n_elastic: n, shift: None }).unwrap();
    (modes.elastic().map(|i| modes.frequency_hz(i)).collect(), modes.n_rigid)
}

fn near(a: f64, b: f64, part: f64) {
    assert!((a / b - 1.0).abs() < part, "{a} is not {b} within {part:e}");
}

const MATERIAL: &str = "*MATERIAL, NAME=steel\n*ELASTIC\n2e11, 0.3\n*DENSITY\n7800.\n";

/// A straight beam of `n` elements along x, clamped at x = 0.
fn cantilever(kind: &str, n: usize, length: f64, section: &str) -> String {
    let mut text = "*NODE\n".to_string();
    for i in 0..=n {
        let _ = writeln!(text, "{}, {}, 0., 0.", i + 1, length * i as f64 / n as f64);
    }
    let _ = writeln!(text, "*ELEMENT, TYPE={kind}, ELSET=beam");
    for i in 1..=n {
        let _ = writeln!(text, "{i}, {i}, {}", i + 1);
    }
    text + section + MATERIAL + "*BOUNDARY\n1, ENCASTRE\n"
}

/// β₁L = 1.8751, f = (β₁L)²/(2π L²) √(EI/ρA): R. D. Blevins, Formulas for Natural Frequency and Mode Shape, 1979, table 8-1. The section is
/// 20 wide along n1 and 10 high along n2: n1 is along y by the second data line.
#[test]
fn a_beam_bends_in_the_planes_of_its_section() {
    let section = "*BEAM SECTION, ELSET=beam, MATERIAL=steel, SECTION=RECT\n0.02, 0.01\n0., 1., 0.\n";
    let (f, n_rigid) = frequencies(&model(&cantilever("B33", 20, 1.0, section)), 2);
    let closed = |h: f64| 1.875_104_068_711_961_f64.powi(2) / TAU * (2e11 * h * h / 12.0 / 7800.0).sqrt();
    assert_eq!(n_rigid, 0);
    // Hermite's elements err by (βl)⁴/720 of the frequency squared at the most.
    near(f[0], closed(0.01), 1e-6);
    near(f[1], closed(0.02), 1e-6);
    // The default n1 is -z: the section then stands upright.
    let upright = section.replace("0., 1., 0.\n", "");
    let text = cantilever("B33", 20, 1.0, &upright);
    let shown = imported(&text, Solver::Abaqus).text;
    assert!(shown.contains("orientation: [0, 1, 0]"), "{shown}");
}

/// A pipe with masses lumped: the total mass is ρ A L, and the twist of a shaft with a disc is √(GJ/(L I))/2π.
#[test]
fn masses_springs_and_rotary_inertias_are_their_closed_forms() {
    let text = "*NODE\n1, 0., 0., 0.\n2, 2., 0., 0.\n3, 2., 1., 0.\n*ELEMENT, TYPE=B31, ELSET=shaft\n1, 1, 2\n*ELEMENT, TYPE=ROTARYI, ELSET=disc\n2, 2\n\
        *ELEMENT, TYPE=MASS, ELSET=m\n3, 3\n*ELEMENT, TYPE=SPRING1, ELSET=k1\n4, 3\n*ELEMENT, TYPE=SPRINGA, ELSET=ka\n5, 2, 3\n\
        *ELEMENT, TYPE=SPRING2, ELSET=k2\n6, 2, 3\n\
        *BEAM SECTION, ELSET=shaft, MATERIAL=soft, SECTION=PIPE\n0.05, 0.01\n0., 0., 1.\n*MATERIAL, NAME=soft\n*ELASTIC\n2e11, 0.3\n\
        *ROTARY INERTIA, ELSET=disc\n3., 1., 1.\n*MASS, ELSET=m\n5.\n*SPRING, ELSET=k1\n1,\n2000.\n*SPRING, ELSET=ka\n\n3000.\n\
        *SPRING, ELSET=k2\n3, 3\n4000.\n*BOUNDARY\n1, ENCASTRE\n2, 1, 3\n2, 5, 6\n3, 4, 6\n";
    let (f, _) = frequencies(&model(text), 4);
    let j = PI / 2.0 * (0.05_f64.powi(4) - 0.04_f64.powi(4));
    let shaft = (2e11 / 2.6 * j / 2.0 / 3.0).sqrt() / TAU;
    let mut expected = vec![shaft];
    expected.extend([2000.0, 3000.0, 4000.0].map(|k| (k / 5.0_f64).sqrt() / TAU));
    expected.sort_by(f64::total_cmp);
    assert_eq!(f.len(), 4);
    for (a, b) in f.into_iter().zip(expected) {
        near(a, b, 1e-9);
    }
}

/// A bar of two elements, lumped and consistent: ω = √(k/m) of the chain by hand.
#[test]
fn trusses_have_the_mass_of_their_solver() {
    let text = format!(
        "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=T3D2, ELSET=bar\n1, 1, 2\n*SOLID SECTION, ELSET=bar, MATERIAL=steel\n1e-4\n{MATERIAL}*BOUNDARY\n1, 1, 3\n2, 2, 3\n"
    );
    let (k, m) = (2e11 * 1e-4, 7800.0 * 1e-4);
    for (solver, share) in [(Solver::Abaqus, 2.0), (Solver::CalculiX, 3.0)] {
        let (f, _) = frequencies(&model_of(&imported(&text, solver)), 1);
        near(f[0], (k / (m / share) as f64).sqrt() / TAU, 1e-9);
    }
}

/// Constants of a section of unequal flanges, in the axes of the deck, by parts.
#[test]
fn an_i_section_has_the_constants_of_its_parts() {
    let section =
        "*BEAM SECTION, ELSET=beam, MATERIAL=steel, SECTION=I\n0., 0.1, 0.08, 0.06, 0.01, 0.008, 0.006\n0., 1., 0.\n";
    let text = imported(&cantilever("B31", 2, 1.0, section), Solver::Abaqus).text;
    let parts = [(0.08, 0.01, 0.005), (0.006, 0.082, 0.051), (0.06, 0.008, 0.096)];
    let area: f64 = parts.iter().map(|p| p.0 * p.1).sum();
    let centre = parts.iter().map(|p| p.0 * p.1 * p.2).sum::<f64>() / area;
    let about_1: f64 = parts.iter().map(|p| p.0 * p.1 * (p.1 * p.1 / 12.0 + (p.2 - centre).powi(2))).sum();
    let about_2: f64 = parts.iter().map(|p| p.1 * f64::powi(p.0, 3) / 12.0).sum();
    let value = |key: &str| -> f64 {
        let at = text.find(&format!(" {key}: ")).unwrap_or_else(|| panic!("no {key} in\n{text}"));
        text[at + key.len() + 3..].split([' ', ',', '}']).next().unwrap().parse().unwrap()
    };
    for (key, expected) in
        [("A", area), ("Iy", about_1), ("Iz", about_2), ("neutral_axis_z", centre), ("mass_offset_z", centre)]
    {
        near(value(key), expected, 1e-11);
    }
}
