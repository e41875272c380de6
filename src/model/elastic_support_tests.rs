//! Supports that give against the same structures on explicit springs.

use super::{Model, ParametricModel, Registry, load, solve_modes};
use crate::element::Dof;
use crate::linalg::{DMatrix, DVector};
use crate::modal::{Modes, SolveOptions};

/// A beam of two spans, and what holds it in the middle.
fn bridge(subdivide: usize, middle: &str) -> Model {
    let text = format!(
        "retune: 1\nname: two spans\nactive_dofs: [ux, uz, ry]\n\
         parameters:\n  E: {{value: 200 GPa, bounds: [150 GPa, 250 GPa]}}\n  c: {{value: 4e-8 m/N, bounds: [0 m/N, 1e-6 m/N]}}\n\
         nodes:\n  a: [0, 0, 0]\n  m: [4, 0, 0]\n  b: [10, 0, 0]\n  under: [4.3, 0, -0.5]\n\
         sections:\n  deck: {{E: E, G: 80 GPa, A: 0.02 m2, Iy: 1e-4 m4, Iz: 1e-4 m4, J: 2e-4 m4, density: 7850 kg/m3}}\n\
         beams:\n  left: {{nodes: [a, m], section: deck, subdivide: {subdivide}}}\n  right: {{nodes: [m, b], section: deck, subdivide: {subdivide}}}\n\
         masses:\n  lump: {{node: m, mass: 40 kg}}\n{middle}"
    );
    load(&text, &Registry::builtin()).unwrap_or_else(|p| panic!("{p:?}\n{text}")).0
}

const ENDS: &str = "supports:\n  ends: {nodes: [a, b], fixed: [ux, uz]}\n";
const ARM: &str = "rigid_links:\n  arm: {master: m, slaves: [under]}\n";

fn modes(model: &Model, theta: &[f64]) -> Modes {
    solve_modes(model, theta, SolveOptions { n_elastic: 5, shift: None }).unwrap()
}

/// The same structure with a support that gives, with a spring in its place, and with a support that is rigid.
fn three(subdivide: usize, node: &str, spring: f64) -> [Model; 3] {
    let link = if node == "under" { ARM } else { "" };
    [
        format!("{link}{ENDS}  pier: {{node: {node}, fixed: [uz], compliance: {{uz: c}}}}\n"),
        format!("{link}{ENDS}springs:\n  pier: {{node: {node}, k: {{uz: {spring:e} N/m}}}}\n"),
        format!("{link}{ENDS}  pier: {{node: {node}, fixed: [uz]}}\n"),
    ]
    .map(|middle| bridge(subdivide, &middle))
}

#[test]
fn a_support_that_gives_is_one_on_a_spring() {
    for (node, c) in [("m", 1e-8), ("m", 4e-8), ("m", 1e-6), ("under", 4e-8)] {
        let [gives, stands, rigid] = three(12, node, 1.0 / c);
        let theta = [200e9, c];
        let (f, exact, held) = (modes(&gives, &theta), modes(&stands, &theta), modes(&rigid, &theta));
        for i in 0..5 {
            let error = f.lambda[i] / exact.lambda[i] - 1.0;
            // The inertia of the node follows statically: upper bounds. ω² M_ss/(K_ss + 1/c) of the lump is 0.02 in the fifth mode.
            let most = if i < 3 { 2e-4 } else { 2e-3 };
            assert!((-1e-9..most).contains(&error), "{node} {c} mode {i}: {error}");
        }
        assert!(held.lambda[0] / exact.lambda[0] > 1.02, "{node} {c}: the spring is of no account");
        // What stands on the pier moves with it.
        let index = gives.dof_map().node("m").unwrap();
        let motion = gives.node_at(index, &theta).unwrap().unwrap();
        let at =
            |rows: &[(usize, f64)], modes: &Modes| rows.iter().map(|(r, f)| f * modes.shapes[(*r, 0)]).sum::<f64>();
        let slope = |model: &Model, m: &Modes| at(model.dof_map().express(0, Dof::Ry), m);
        let own = at(&motion.rows[2], &f) / slope(&gives, &f);
        let reference = at(stands.dof_map().express(index, Dof::Uz), &exact) / slope(&stands, &exact);
        assert!((own / reference - 1.0).abs() < 1e-3, "{node} {c}: {own} {reference}");
    }
}

#[test]
fn statics_are_exact_in_any_mesh() {
    for node in ["m", "under"] {
        let [gives, stands, _] = three(2, node, 1.0 / 4e-8);
        let theta = [200e9, 4e-8];
        // 1 kN down in the middle of the right span.
        let deflection = |model: &Model| {
            let dofs = model.dof_map();
            let row = |n: &str| dofs.express(dofs.node(n).unwrap(), Dof::Uz)[0].0;
            let (loaded, read) = (row("right/0.5"), row("left/0.5"));
            let mut force = DVector::zeros(dofs.n_dof());
            force[loaded] = -1e3;
            let q = model.assemble(&theta).unwrap().stiffness.lu().solve(&force).unwrap();
            [q[loaded], q[read]]
        };
        for (own, exact) in deflection(&gives).into_iter().zip(deflection(&stands)) {
            assert!((own / exact - 1.0).abs() < 1e-10, "{own} {exact}");
        }
    }
}

#[test]
fn without_compliance_it_is_the_rigid_support_to_the_bit() {
    for node in ["m", "under"] {
        let [gives, _, rigid] = three(3, node, 1.0);
        assert_eq!(gives.assemble(&[200e9, 0.0]).unwrap(), rigid.assemble(&[200e9, 0.0]).unwrap());
        assert_eq!(gives.mass_properties(&[200e9, 0.0]).unwrap(), rigid.mass_properties(&[200e9, 0.0]).unwrap());
    }
}

#[test]
fn derivatives_are_those_of_the_matrices() {
    let two = format!("{ENDS}  pier: {{node: m, fixed: [uz, ry], compliance: {{uz: c, ry: 0.3*c}}}}\n")
        .replace("0.3*c", "2e-7 rad/(N m)");
    let two = bridge(2, &two);
    let [one, ..] = three(2, "under", 1.0);
    for model in [one, two] {
        for (theta, j, step) in [([200e9, 3e-8], 0, 1e5), ([200e9, 3e-8], 1, 1e-13), ([180e9, 0.0], 1, 1e-13)] {
            let at = |s: f64| {
                let mut theta = theta;
                theta[j] += s * step;
                model.assemble(&theta).unwrap()
            };
            let (above, below, slope) = (at(1.0), at(-1.0), model.assemble_derivative(&theta, j).unwrap());
            let agree = |a: &DMatrix<f64>, b: &DMatrix<f64>, slope: &DMatrix<f64>| {
                let difference = (a - b) / (2.0 * step);
                let size = difference.amax().max(a.amax() / theta[0]);
                assert!((&difference - slope).amax() < 2e-5 * size, "{theta:?} {j}: {difference} {slope}");
            };
            agree(&above.stiffness, &below.stiffness, &slope.stiffness);
            agree(&above.mass, &below.mass, &slope.mass);
            let sparse = model.assemble_sparse_derivative(&theta, j).unwrap();
            assert!((sparse.stiffness.to_dense() - &slope.stiffness).amax() <= 1e-12 * slope.stiffness.amax());
        }
    }
}

/// A cantilever that carries a beam across a rigid arm, which gives about y by c.
fn carried(subdivide: usize, joint: &str) -> Model {
    let text = format!(
        "retune: 1\nname: saddle\nactive_dofs: [ux, uz, ry]\n\
         parameters:\n  c: {{value: 4e-6 rad/(N m), bounds: [0 rad/(N m), 1e-4 rad/(N m)]}}\n\
         nodes: {{a: [0, 0, 0], m: [2, 0, 0], d: [1.5, 0, 0.3], s: [2.3, 0, 0.3], e: [3.2, 0, 0.3], p: {{from: s, offset: [0 m, 0 m, 0 m]}}}}\n\
         sections:\n  deck: {{E: 200 GPa, G: 80 GPa, A: 0.002 m2, Iy: 1e-6 m4, Iz: 1e-6 m4, J: 2e-6 m4, density: 7850 kg/m3}}\n\
         beams:\n  base: {{nodes: [a, m], section: deck, subdivide: {subdivide}}}\n  across: {{chain: [d, s, e], section: deck, subdivide: {subdivide}}}\n\
         supports: {{clamp: {{node: a}}}}\n{joint}"
    );
    load(&text, &Registry::builtin()).unwrap_or_else(|p| panic!("{p:?}\n{text}")).0
}

/// A link that gives where a member goes on is a pin with a spring: exact in statics, and in modes but for the inertia of the node. Without compliance it is
/// the rigid link to the bit, and what another entry says of it counts as its own.
#[test]
fn a_link_that_gives_is_one_on_a_spring() {
    let of_itself = "rigid_links: {saddle: {master: m, slaves: [s], compliance: {ry: c}}}\n";
    let of_another = "rigid_links: {saddle: {master: m, slaves: [s]}, gives: {master: m, slaves: [s], dofs: [], compliance: {ry: c}}}\n";
    let rigid = carried(10, "rigid_links: {saddle: {master: m, slaves: [s]}}\n");
    for c in [1e-6, 4e-6, 1e-4] {
        let spring = format!(
            "rigid_links: {{arm: {{master: m, slaves: [p]}}, pin: {{master: p, slaves: [s], dofs: [ux, uz]}}}}\n\
             springs: {{hinge: {{nodes: [p, s], k: {{ry: {:e} N m/rad}}}}}}\n",
            1.0 / c
        );
        let (gives, stands) = (carried(10, of_itself), carried(10, &spring));
        let (own, exact) = (modes(&gives, &[c]), modes(&stands, &[c]));
        for i in 0..5 {
            let error = own.lambda[i] / exact.lambda[i] - 1.0;
            assert!((-1e-9..1e-3).contains(&error), "{c} mode {i}: {error}");
        }
        assert!(modes(&rigid, &[c]).lambda[0] / exact.lambda[0] > 1.001, "{c}: the spring is of no account");
        let bent = |model: &Model| {
            let dofs = model.dof_map();
            let row = |n: &str| dofs.express(dofs.node(n).unwrap(), Dof::Uz)[0].0;
            let mut force = DVector::zeros(dofs.n_dof());
            force[row("e")] = -1e3;
            let q = model.assemble(&[c]).unwrap().stiffness.lu().solve(&force).unwrap();
            [q[row("e")], q[row("d")], q[row("m")]]
        };
        for (own, exact) in bent(&gives).into_iter().zip(bent(&stands)) {
            assert!((own / exact - 1.0).abs() < 1e-10, "{c}: {own} {exact}");
        }
        assert_eq!(gives.assemble(&[c]).unwrap(), carried(10, of_another).assemble(&[c]).unwrap());
    }
    assert_eq!(carried(10, of_itself).assemble(&[0.0]).unwrap(), rigid.assemble(&[0.0]).unwrap());
}

#[test]
fn a_link_that_gives_and_carries_a_mass_alone_is_told() {
    let gives = "rigid_links:\n  arm: {master: m, slaves: [under], compliance: {uz: c}}\n";
    let told = |more: &str| {
        let found = super::lint::lint(&bridge(2, &format!("{more}{gives}{ENDS}"))).unwrap().warnings;
        found.iter().any(|p| p.path == "rigid_links.arm.compliance")
    };
    assert!(told("  box: {node: under, mass: 5 kg}\n"));
    assert!(!told("  box: {node: under, mass: 5 kg}\nsprings:\n  stay: {node: under, k: {ux: 1e5 N/m}}\n"));
}
