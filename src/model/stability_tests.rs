//! Columns under preload against Euler's loads.

use super::{Model, ModelError, ParametricModel, Registry, lint, load, solve_modes};
use crate::modal::{ModalError, SolveOptions};
use std::f64::consts::PI;

/// A column of 1 m and EI = 100 N m² under an axial force.
fn column(force: &str, parts: usize, supports: &str) -> Model {
    let text = format!(
        "retune: 1\nname: c\nactive_dofs: [uz, ry]\nparameters: {{P: {{value: -500 N, bounds: [-1200 N, 0 N]}}}}\n\
         sections: {{s: {{EIy: 100 N m2, mass_per_length: 1 kg/m, axial_force: {force}}}}}\n\
         nodes: {{a: [0, 0, 0], b: [1 m, 0, 0]}}\nbeams: {{ab: {{nodes: [a, b], section: s, subdivide: {parts}}}}}\n{supports}"
    );
    load(&text, &Registry::builtin()).unwrap_or_else(|p| panic!("{}", p[0].render("f"))).0
}

const PINNED: &str = "supports: {p: {nodes: [a, b], fixed: [uz]}}\n";
const CLAMPED: &str = "supports: {p: {node: a}}\n";

fn modes(model: &Model) -> Result<Vec<f64>, ModelError> {
    let theta = model.parameters().nominal();
    solve_modes(model, &theta, SolveOptions { n_elastic: 6, shift: None }).map(|m| m.frequencies_hz())
}

/// Euler: π² EI/L² pinned, π² EI/4L² clamped and free; by the dense path (16 dofs) and by the sparse one (200).
#[test]
fn a_buckled_column_has_its_critical_load_and_no_modes() {
    for (supports, euler) in [(PINNED, PI * PI * 100.0), (CLAMPED, PI * PI * 25.0)] {
        for parts in [8, 100] {
            for times in [1.02, 1.2159, 3.0, 30.0] {
                let force = format!("{} N", -times * euler);
                let model = column(&force, parts, supports);
                let error = modes(&model).unwrap_err();
                let ModelError::Buckled(critical, n) = &error else { panic!("{error}") };
                let borne = critical.factor * critical.value;
                // The error of the cubic element in a buckling load is of the fourth power of its length: 3.3e-5 with eight.
                assert!((borne / -euler - 1.0).abs() < 5e-5, "{parts} parts, {times}: {borne} against {euler}");
                // Loads of the higher forms: n² times the first pinned, (2n - 1)² times clamped.
                let forms = (1..20).map(|k| if supports == PINNED { k * k } else { (2 * k - 1) * (2 * k - 1) });
                let expected = forms.filter(|f| f64::from(*f) < times).count();
                assert_eq!(*n, expected, "{parts} parts, {times}");
                let first = format!("`axial_force` of element `ab/0..{}`", 1.0 / parts as f64);
                assert!(error.to_string().contains(&first), "{error}");
            }
            let model = column(&format!("{} N", -0.9 * euler), parts, supports);
            let found = modes(&model).unwrap();
            assert_eq!(found.len(), 6);
            assert!(found.iter().all(|f| *f > 0.0));
            let critical = model.critical_preload(&model.parameters().nominal()).unwrap().unwrap();
            assert!((critical.factor - 1.0 / 0.9).abs() < 5e-5, "{}", critical.factor);
        }
    }
}

/// f² = f0² (1 - P/P_cr) for the pinned column: 91.2 % of the load leaves 29.7 % of the frequency, and makes of an error e of P_cr one of
/// 5.2 e, 1.7e-4 of the 3.3e-5 of eight elements.
#[test]
fn a_column_short_of_buckling_keeps_its_frequency() {
    let f0 = PI / 2.0 * 10.0;
    let model = column("-900 N", 8, PINNED);
    let exact = f0 * (1.0 - 900.0 / (PI * PI * 100.0)).sqrt();
    assert!((modes(&model).unwrap()[0] / exact - 1.0).abs() < 2e-4);
}

#[test]
fn tension_and_no_preload_have_no_critical_load() {
    for force in ["1200 N", "0 N"] {
        let model = column(force, 8, PINNED);
        assert_eq!(model.critical_preload(&model.parameters().nominal()).unwrap(), None);
    }
}

/// A free column under compression without its counterpart turns away from it: a motion that nothing else resists.
#[test]
fn an_unbalanced_preload_of_a_free_structure_is_told() {
    let error = modes(&column("-100 N", 8, "")).unwrap_err();
    assert!(error.to_string().contains("balance the compression"), "{error}");
}

/// The bound of -1200 N lies beyond the -987 N at which the column buckles; one of -950 N does not.
#[test]
fn a_bound_beyond_buckling_is_remarked_on() {
    let remarks = |model: &Model| {
        let s = lint(model).unwrap();
        assert!(s.errors.is_empty());
        s.warnings.into_iter().filter(|p| p.path == "parameters.P.bounds").map(|p| p.message).collect::<Vec<_>>()
    };
    let model = column("P", 8, PINNED);
    let said = remarks(&model);
    assert!(said.len() == 1 && said[0].contains("buckles where `P` is -987.0 N"), "{said:?}");
    assert_eq!(remarks(&column("0.79 * P", 8, PINNED)), [""; 0]);
}

/// A negative stiffness that is not a preload is no buckling load, and no modes either.
#[test]
fn a_negative_stiffness_is_unstable() {
    let k = nalgebra::dmatrix![2.0, -1.0; -1.0, 0.2];
    let m = nalgebra::DMatrix::identity(2, 2);
    let motions = nalgebra::DMatrix::zeros(2, 6);
    let options = SolveOptions { n_elastic: 2, shift: None };
    assert_eq!(crate::modal::solve(&k, &m, &motions, options).unwrap_err(), ModalError::Unstable { n: 1 });
}
