//! Shells of plies, from a model file to matrices.

use super::{Model, ParametricModel, Registry, load};
use crate::linalg::DMatrix;
use crate::modal::{SolveOptions, solve};

/// A clamped plate of 4 x 3 shells with a section.
fn plate(section: &str, parameters: &str) -> String {
    let mut text = format!("retune: 1\nname: plate\nparameters: {{{parameters}}}\nnodes:\n");
    for i in 0..=4 {
        for j in 0..=3 {
            text += &format!("  n{i}{j}: [{}, {}, 0]\n", 0.1 * f64::from(i), 0.08 * f64::from(j));
        }
    }
    text += &format!("sections: {{skin: {{{section}}}}}\nelements:\n");
    for i in 0..4 {
        for j in 0..3 {
            let (a, b) = (i + 1, j + 1);
            text +=
                &format!("  e{i}{j}: {{type: shell4, nodes: [n{i}{j}, n{a}{j}, n{a}{b}, n{i}{b}], section: skin}}\n");
        }
    }
    text + "supports: {root: {nodes: [n00, n01, n02, n03]}}\n"
}

fn model(text: &str) -> Model {
    load(text, &Registry::builtin()).unwrap_or_else(|p| panic!("{p:#?}")).0
}

fn frequencies(model: &Model, theta: &[f64]) -> Vec<f64> {
    let system = model.assemble(theta).unwrap();
    let modes = solve(
        &system.stiffness,
        &system.mass,
        &DMatrix::zeros(system.stiffness.nrows(), 0),
        SolveOptions { n_elastic: 6, shift: None },
    )
    .unwrap();
    (0..6).map(|i| modes.frequency_hz(i)).collect()
}

const CARBON: &str = "E1: 130 GPa, E2: 9 GPa, nu12: 0.3, G12: 5 GPa, G13: 5 GPa, G23: 3 GPa, density: 1600";

fn laminate(plies: &str) -> String {
    format!("shape: {{laminate: {{materials: {{carbon: {{{CARBON}}}}}, plies: [{plies}]}}}}")
}

/// Four plies of one angle are the orthotropic plate turned by it; so are two of them that lie once more above.
#[test]
fn plies_of_one_angle_are_the_turned_plate() {
    let whole = model(&plate(&format!("{CARBON}, thickness: 2 mm, angle: 30 deg"), ""));
    let exact = frequencies(&whole, &[]);
    let ply = "{angle: 30 deg, thickness: 0.5 mm}";
    let four = laminate(&[ply; 4].join(", "));
    let half = laminate(&[ply; 2].join(", ")).replace("]}}", "], symmetric: true}}");
    // The laminate itself may be turned too.
    let turned = laminate("{angle: 10 deg, thickness: 2 mm}") + ", angle: 20 deg";
    for section in [four, half, turned] {
        let found = frequencies(&model(&plate(&section, "")), &[]);
        assert!(found.iter().zip(&exact).all(|(f, e)| (f / e - 1.0).abs() < 1e-9), "{section}: {found:?} {exact:?}");
    }
}

/// Angles and thicknesses of plies, and a modulus: the slopes of K and M are those of differences.
#[test]
fn numbers_of_plies_are_parameters() {
    let section = laminate("{angle: a, thickness: t}, {angle: -a, thickness: 0.4 mm}, {angle: 90 deg, thickness: t}")
        .replace("E1: 130 GPa", "E1: E");
    let parameters = "a: {value: 30 deg, bounds: [20 deg, 40 deg]}, t: {value: 0.5 mm, bounds: [0.4 mm, 0.6 mm]}, E: {value: 130 GPa, bounds: [100 GPa, 150 GPa]}";
    let model = model(&plate(&section, parameters));
    let theta = model.parameters().nominal();
    for j in 0..3 {
        let slope = model.assemble_derivative(&theta, j).unwrap();
        let at = |s: f64| {
            let mut theta = theta.clone();
            theta[j] *= 1.0 + s;
            model.assemble(&theta).unwrap()
        };
        let (up, down, width) = (at(1e-4), at(-1e-4), 2e-4 * theta[j]);
        for (exact, high, low) in [(slope.stiffness, up.stiffness, down.stiffness), (slope.mass, up.mass, down.mass)] {
            let by_difference = (high - low) / width;
            assert!((&exact - &by_difference).amax() <= 1e-5 * exact.amax(), "{j}");
        }
        assert!(frequencies(&model, &theta)[0] > 0.0);
    }
    let mut other = theta.clone();
    other[0] *= 1.2;
    assert!((frequencies(&model, &other)[0] / frequencies(&model, &theta)[0] - 1.0).abs() > 0.01);
}

/// Plies that all grow alike keep their plate a polynomial, as a solid one is.
#[test]
fn plies_of_one_thickness_are_a_polynomial_of_it() {
    let section = laminate("{angle: 30 deg, thickness: t}, {angle: 0, thickness: t}, {angle: -30 deg, thickness: t}");
    let model = model(&plate(&section, "t: {value: 0.5 mm, bounds: [0.4 mm, 0.6 mm]}"));
    assert!(model.affine().is_some());
}

/// Cross-ply strips under cylindrical bending, two plies: D - B²/A, the published softening of coupling (Jones, section 5.3.3).
#[test]
fn coupling_softens_the_plate() {
    let of = |plies: &str| frequencies(&model(&plate(&laminate(plies), "")), &[])[0];
    let coupled = of("{angle: 0, thickness: 1 mm}, {angle: 90 deg, thickness: 1 mm}");
    let ply = crate::model::laminate::Ply {
        e1: 130e9,
        e2: 9e9,
        g12: 5e9,
        nu12: 0.3,
        g13: 5e9,
        g23: 3e9,
        density: 1600.0,
        angle: 0.0,
        thickness: 1e-3,
    };
    let (abd, _) =
        crate::model::laminate::sums(&[ply, crate::model::laminate::Ply { angle: 90f64.to_radians(), ..ply }]);
    let softened = abd[(3, 3)] - abd[(0, 3)].powi(2) / abd[(0, 0)];
    // The same bending stiffness without coupling: the lowest mode of the clamped plate bends along x.
    let plain = of("{angle: 0, thickness: 0.5 mm}, {angle: 90 deg, thickness: 1 mm}, {angle: 0, thickness: 0.5 mm}");
    let symmetric = {
        let thin = crate::model::laminate::Ply { thickness: 0.5e-3, ..ply };
        let middle = crate::model::laminate::Ply { angle: 90f64.to_radians(), ..ply };
        crate::model::laminate::sums(&[thin, middle, thin]).0[(3, 3)]
    };
    let expected = (softened / symmetric).sqrt();
    assert!((coupled / plain / expected - 1.0).abs() < 0.02, "{} {expected}", coupled / plain);
}

/// What is wrong in a lay-up is said where it stands.
#[test]
fn mistakes_in_plies_have_their_places() {
    for (section, expected) in [
        (laminate("{angle: 0, thickness: -1 mm}"), "above zero"),
        (laminate("{angle: 45, thickness: 1 mm}"), "45 deg"),
        (laminate("{angle: 0, thickness: 1 mm, material: glass}"), "no material `glass`"),
        (laminate("{angle: 0, thickness: 1 mm}") + ", thickness: 2 mm", "the same thing twice"),
        ("A11: 1 MN/m".to_string(), "go together"),
    ] {
        let problems = load(&plate(&section, ""), &Registry::builtin()).unwrap_err();
        assert!(problems.iter().any(|p| p.message.contains(expected)), "{section}: {problems:#?}");
    }
}
