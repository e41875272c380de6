//! Coordinates that are parameters: at every θ the model is the one that stands there.

use super::{Model, ParametricModel, PointMotion, Registry, load, solve_modes};
use crate::linalg::DMatrix;
use crate::modal::{Modes, SolveOptions};
use crate::yaml::Severity;

const VALUES: [(&str, f64); 4] = [("reach", 0.8), ("height", 0.5), ("aside", 0.4), ("arm", 0.15)];

/// A swept frame: a node that moves in two directions, one beside it, one between, a mirror image, the slave of a rigid link, and a stay.
fn frame(values: &[(&str, f64)], is_free: bool) -> Model {
    // A pin to a node that moves would make rigid motions depend on θ.
    let [pin, pinned] = if is_free {
        ["", ""]
    } else {
        [", pin: {master: tip, slaves: [store], dofs: [ux, uy, uz]}", "pinned: {node: store, mass: 0.5 kg}, "]
    };
    let supports = if is_free { "" } else { "supports: {root: {node: root}}\n" };
    let parameters = values.iter().map(|(name, v)| format!("{name}: {{value: {v} m, bounds: [0.05 m, 3 m]}}"));
    let text = format!(
        "retune: 1\nname: moved\nsymmetry: {{normal: y}}\nparameters: {{{}}}\nframes: {{turned: {{rotate: {{z: 30 deg}}}}}}\n\
         lines: {{spar: {{from: [0, 0, 0], direction: +x}}}}\n\
         nodes:\n  root: [0, 0, 0]\n  knee: [reach, 0, 0.2*height + 0.1 m]\n  tip: {{from: knee, offset: [0.3, aside, -0.05]}}\n  \
         left: {{mirror: tip}}\n  half: {{between: [knee, tip], fraction: 0.25}}\n  far: {{line: spar, at: 2*reach}}\n  \
         post: {{frame: turned, at: [0.1, 0, height]}}\n  body: {{from: knee, offset: [arm, 0.02, 0.3]}}\n  store: {{from: tip, offset: [0.1, 0, 0]}}\n\
         sections: {{s: {{EA: 1e6 N, GJ: 60 N m2, EIy: 100 N m2, EIz: 300 N m2, mass_per_length: 1 kg/m, polar_inertia_per_length: 0.01 kg m}}}}\n\
         beams:\n  stem: {{nodes: [root, knee], section: s, subdivide: 3}}\n  right: {{chain: [knee, half, tip], section: s, orientation: [1, 0, 1]}}\n  \
         left: {{nodes: [knee, left], section: s}}\n  boom: {{nodes: [knee, far], section: s, offsets: [[0, 0, 0.05], [0, 0, 0.05]]}}\n  \
         strut: {{nodes: [body, post], section: s}}\n\
         bars: {{stay: {{nodes: [root, tip], properties: {{EA: 2e4 N, mass_per_length: 0.1 kg/m}}}}}}\n\
         masses: {{{pinned}lump: {{node: body, mass: 2 kg, inertia: {{xx: 0.1 kg m2, yy: 0.2 kg m2, zz: 0.3 kg m2}}, offset: [0.01, 0.02, 0.03]}}}}\n\
         springs: {{ground: {{node: tip, k: {{uz: 500 N/m}}}}}}\n\
         rigid_links: {{arm: {{master: knee, slaves: [body]}}{pin}}}\n{supports}",
        parameters.collect::<Vec<_>>().join(", ")
    );
    load(&text, &Registry::builtin()).unwrap_or_else(|p| panic!("{}", p[0].render("f"))).0
}

fn close(a: &DMatrix<f64>, b: &DMatrix<f64>, part: f64) -> bool {
    (a - b).amax() <= part * b.amax()
}

const ELSEWHERE: [f64; 4] = [1.1, 0.9, 0.25, 0.4];

fn there(is_free: bool) -> Model {
    let names = VALUES.map(|(name, _)| name);
    frame(&names.into_iter().zip(ELSEWHERE).collect::<Vec<_>>(), is_free)
}

fn modes(model: &Model) -> Modes {
    solve_modes(model, &ELSEWHERE, SolveOptions { n_elastic: 8, shift: None }).unwrap()
}

/// Held at its root and free, where rigid motions do not depend on where nodes stand.
#[test]
fn at_every_theta_the_model_is_the_one_that_stands_there() {
    for is_free in [false, true] {
        let (here, there) = (frame(&VALUES, is_free), there(is_free));
        let (moved, built) = (modes(&here), modes(&there));
        assert_eq!((moved.n_rigid, moved.len()), (built.n_rigid, built.len()));
        // The spring to ground holds one of six.
        assert_eq!(moved.n_rigid, if is_free { 5 } else { 0 });
        for k in moved.n_rigid..moved.len() {
            let (a, b) = (moved.lambda[k], built.lambda[k]);
            assert!((a - b).abs() < 1e-9 * b, "{is_free}, mode {k}: {a} against {b}");
        }
        let still = solve_modes(&here, &VALUES.map(|v| v.1), SolveOptions { n_elastic: 8, shift: None }).unwrap();
        assert!((still.lambda[moved.n_rigid] / moved.lambda[moved.n_rigid] - 1.0).abs() > 0.01);
        let [moved, built] = [&here, &there].map(|m| m.mass_properties(&ELSEWHERE).unwrap().unwrap());
        // The dofs of a node that moves stand for the point at the estimates: its mass is there by a rigid arm.
        assert!((moved.mass - built.mass).abs() < 1e-12 * built.mass);
        for i in 0..3 {
            assert!((moved.cg[i] - built.cg[i]).abs() < 1e-9, "{:?} {:?}", moved.cg, built.cg);
            for j in 0..3 {
                assert!((moved.inertia[i][j] - built.inertia[i][j]).abs() < 1e-9);
            }
        }
        let [dense, sparse] = [
            here.assemble(&ELSEWHERE).unwrap().stiffness,
            here.assemble_sparse(&ELSEWHERE).unwrap().stiffness.to_dense(),
        ];
        assert!(close(&sparse, &dense, 1e-12));
    }
}

/// What is measured: at nodes, on an arm, inside a member.
#[test]
fn points_move_with_what_they_sit_on() {
    let (here, there) = (frame(&VALUES, false), there(false));
    let (moved, built) = (modes(&here), modes(&there));
    let same = |a: &PointMotion, b: &PointMotion, name: &str| {
        let motion = |p: &PointMotion, m: &Modes, k: usize, i: usize| -> f64 {
            p.rows[i].iter().map(|&(row, f)| f * m.shapes[(row, k)]).sum()
        };
        assert!(
            (0..3).all(|i| (a.position[i] - b.position[i]).abs() < 1e-9),
            "{name}: {:?} {:?}",
            a.position,
            b.position
        );
        for k in 0..moved.len() {
            for i in 0..6 {
                let (x, y) = (motion(a, &moved, k, i).abs(), motion(b, &built, k, i).abs());
                assert!((x - y).abs() < 1e-6 * (1.0 + y), "{name}, mode {k}, dof {i}: {x} {y}");
            }
        }
    };
    for node in ["knee", "tip", "left", "half", "far", "post", "body", "store", "stem/0.3333"] {
        let of = |m: &Model| {
            let index = m.geometry().node(node).unwrap_or_else(|| panic!("{node}"));
            m.node_at(index, &ELSEWHERE).unwrap().unwrap_or_else(|| panic!("{node}"))
        };
        same(&of(&here), &of(&there), node);
    }
    assert!(here.node_at(here.geometry().node("root").unwrap(), &ELSEWHERE).unwrap().is_none());
    for element in ["stem", "right.2", "left", "boom", "strut"] {
        let of = |m: &Model| m.point_at(element, 0.4, &ELSEWHERE).unwrap().unwrap();
        same(&of(&here), &of(&there), element);
    }
}

/// Where a structure moves as a rigid body, what is held in part or does not turn cannot be moved: its rigid motions would.
#[test]
fn a_pin_of_a_free_structure_has_a_fixed_place() {
    let text = |supports: &str| {
        format!(
            "retune: 1\nname: m\nparameters: {{x: {{value: 1 m, bounds: [0.5 m, 2 m]}}}}\nnodes: {{a: [0, 0, 0], b: [x, 0, 0], c: [2, 0, 0]}}\n\
             sections: {{s: {{EA: 1e6 N, GJ: 60 N m2, EIy: 100 N m2, EIz: 100 N m2, mass_per_length: 1 kg/m, polar_inertia_per_length: 1 kg m}}}}\n\
             beams: {{m: {{chain: [a, b, c], section: s}}}}\n{supports}"
        )
    };
    let pinned = load(&text("supports: {p: {node: b, fixed: [ux, uy, uz]}}\n"), &Registry::builtin()).unwrap_err();
    assert!(pinned.iter().any(|p| p.path == "nodes.b" && p.message.contains("rigid body")), "{pinned:?}");
    load(&text("supports: {p: {node: b, fixed: [ux, uy, uz]}, q: {node: a}}\n"), &Registry::builtin()).unwrap();
    load(&text(""), &Registry::builtin()).unwrap();
}

#[test]
fn the_slopes_are_those_of_differences() {
    let model = frame(&VALUES, false);
    for j in 0..VALUES.len() {
        let at = |step: f64| {
            let mut theta = ELSEWHERE;
            theta[j] += step;
            model.assemble(&theta).unwrap()
        };
        let (slope, h) = (model.assemble_derivative(&ELSEWHERE, j).unwrap(), 1e-4);
        let difference = (at(h).stiffness - at(-h).stiffness) / (2.0 * h);
        assert!(close(&slope.stiffness, &difference, 1e-5), "{j}");
    }
}

#[test]
fn what_has_fixed_arms_refuses_a_node_that_moves() {
    let refused = |more: &str, path: &str, says: &str| {
        let text = format!(
            "retune: 1\nname: m\nparameters: {{x: {{value: 1 m, bounds: [0.5 m, 2 m]}}}}\nnodes: {{a: [0, 0, 0], b: [x, 0, 0], c: [2, 0, 0]}}\n\
             sections: {{s: {{EA: 1e6 N, GJ: 60 N m2, EIy: 100 N m2, EIz: 100 N m2, mass_per_length: 1 kg/m, polar_inertia_per_length: 1 kg m}}}}\n\
             beams: {{m: {{chain: [a, b], section: s}}, n: {{nodes: [b, c], section: s}}}}\n{more}"
        );
        let problems = load(&text, &Registry::builtin()).map_or_else(|p| p, |loaded| loaded.1);
        let found = problems.iter().find(|p| p.severity == Severity::Error && p.path == path);
        let found = found.unwrap_or_else(|| panic!("{path}: {problems:?}"));
        assert!(found.message.contains(says), "{}", found.message);
    };
    refused("rigid_links: {l: {master: a, slaves: [b], dofs: [ux, uy, rz]}}\n", "rigid_links.l", "link all six");
    refused("weighted_links: {w: {node: b, of: [{nodes: [a, c]}]}}\n", "weighted_links.w", "fixed arms");
    refused(
        "rigid_links: {l: {master: c, slaves: [b]}}\nsupports: {p: {node: b, fixed: [uz]}}\n",
        "supports.p",
        "hold, link or constrain the master instead",
    );
    refused(
        "rigid_links: {l: {master: c, slaves: [b]}, pin: {master: b, slaves: [a], dofs: [ux, uy, uz]}}\n",
        "rigid_links.pin",
        "move alike",
    );
}

/// A foot on a rigid link, pinned to the ground, and a body that turns with the tip of a free boom: both move as what carries them does.
#[test]
fn what_a_link_carries_moves_with_it() {
    let at = |x: f64, rest: &str| {
        let text = format!(
            "retune: 1\nname: m\nparameters: {{x: {{value: {x} m, bounds: [0.5 m, 2 m]}}}}\n\
             nodes: {{a: [0, 0, 0], b: [x, 0, 0], c: [2.5, 0.3, 0], foot: {{from: b, offset: [0, 0.1, -0.2]}}, store: {{from: b, offset: [0, 0, 0.1]}}}}\n\
             sections: {{s: {{EA: 1e6 N, GJ: 60 N m2, EIy: 100 N m2, EIz: 100 N m2, mass_per_length: 1 kg/m, polar_inertia_per_length: 1 kg m}}}}\n\
             beams: {{m: {{chain: [a, b, c], section: s}}}}\n{rest}"
        );
        load(&text, &Registry::builtin()).unwrap_or_else(|p| panic!("{}", p[0])).0
    };
    let pinned = "rigid_links: {l: {master: b, slaves: [foot]}}\nsupports: {p: {node: foot, fixed: [ux, uy, uz]}, q: {node: a, fixed: [uy, uz, rx]}}\n";
    let hung = "rigid_links: {l: {master: b, slaves: [store], dofs: [ux, uy, rx, ry, rz]}}\n\
                masses: {body: {node: store, mass: 1 kg}}\nsprings: {s: {nodes: [b, store], k: {uz: 2 kN/m}}}\n";
    for rest in [pinned, hung] {
        let options = SolveOptions { n_elastic: 5, shift: None };
        let [moved, built] = [at(0.9, rest), at(1.3, rest)].map(|m| solve_modes(&m, &[1.3], options).unwrap());
        assert_eq!(moved.n_rigid, built.n_rigid, "{rest}");
        for k in moved.n_rigid..moved.len() {
            let (a, b) = (moved.lambda[k], built.lambda[k]);
            assert!((a - b).abs() < 1e-9 * b, "{rest}: mode {k}: {a} against {b}");
        }
    }
}

/// No element of a free structure is strained by a rigid motion, wherever its nodes stand.
#[test]
fn rigid_motions_strain_no_element() {
    let model = frame(&VALUES, true);
    let motions = model.dof_map().rigid_motions();
    for (e, element) in model.elements().iter().enumerate().filter(|(_, e)| e.nodes.len() == 2) {
        let connection = model.element_motion(e);
        let rows = motions.select_rows(&connection.rows);
        for theta in [VALUES.map(|v| v.1), ELSEWHERE] {
            let k = connection.reduce(&model.element_matrices(e, &theta).unwrap().stiffness);
            let (force, size) = (&k * &rows, k.abs() * rows.abs());
            for j in 0..6 {
                let (force, size) = (force.column(j).amax(), size.column(j).amax());
                assert!(force <= 1e-11 * size, "{}, motion {j}: {force:e} of {size:e}", element.name);
            }
        }
    }
}

/// A mast of lumped masses, whose rotations have none: what moves gives some of them one by its arm.
#[test]
fn massless_rotations_of_a_moved_node_bring_no_mode() {
    let text = "retune: 1\nname: mast\nparameters: {x: {value: 0 m, bounds: [-1 m, 1 m]}}\nnodes: {foot: [0, 0, 0], knee: [0, 0, 4], tip: [0.3, x, 8], side: [3, 0, 4]}\n\
                sections: {s: {E: 31 GPa, nu: 0.2, A: 0.2, Iy: 4e-3, Iz: 2.7e-3, J: 5.5e-3, mass_per_length: 500, lumping: 1}}\n\
                beams: {low: {nodes: [foot, knee], section: s, subdivide: 6}, up: {nodes: [knee, tip], section: s, subdivide: 7}, arm: {nodes: [knee, side], section: s, subdivide: 7}}\n\
                springs: {f: {node: foot, k: {ux: 2e9, uy: 2e9, uz: 3.5e8, rx: 1.6e8, ry: 1.6e8, rz: 8e7}}}\n";
    let model = load(text, &Registry::builtin()).unwrap_or_else(|p| panic!("{}", p[0])).0;
    assert!(model.dof_map().n_dof() >= 120);
    let solver = super::ModalSolver::new(&model, &[0.0], 34).unwrap();
    for x in [-1.0, -0.66, -0.2, -0.05, 0.01, 0.1, 0.3, 0.7, 1.0] {
        let (_, found) = solver.solve(&model, &[x], 34).unwrap();
        let system = model.assemble(&[x]).unwrap();
        let options = SolveOptions { n_elastic: 34, shift: None };
        let dense =
            crate::modal::solve(&system.stiffness, &system.mass, &DMatrix::zeros(model.dof_map().n_dof(), 6), options)
                .unwrap();
        for k in 0..34 {
            let (a, b) = (found.lambda[k], dense.lambda[k]);
            assert!((a - b).abs() < 1e-6 * b, "{x}, mode {k}: {a} against {b}");
        }
    }
}
