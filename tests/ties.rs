//! Surface ties: nodes that follow shells and solids of another mesh.

use retune::effect::{Effects, Structure};
use retune::element::Dof;
use retune::linalg::{DMatrix, DVector};
use retune::modal::SolveOptions;
use retune::model::{Model, ParametricModel, Registry, load, solve_modes};
use retune::yaml::Problem;
use std::fmt::Write;

/// Blocks of cells in one model file: nodes `a0`, `a1`, ..., elements of group `a`.
#[derive(Default)]
struct Parts {
    nodes: String,
    elements: String,
    groups: String,
}

impl Parts {
    /// Corners `from` and `to`, cells along x, y, z; none along z makes shells. Returns the names of its nodes by their indices.
    fn block(
        &mut self,
        name: &str,
        cells: [usize; 3],
        from: [f64; 3],
        to: [f64; 3],
    ) -> impl Fn(usize, usize, usize) -> String + use<> {
        let [nx, ny, nz] = cells;
        let id = move |i: usize, j: usize, k: usize| (i * (ny + 1) + j) * (nz + 1) + k;
        let at = |c: usize, i: usize| {
            from[c] + if cells[c] == 0 { 0.0 } else { (to[c] - from[c]) * i as f64 / cells[c] as f64 }
        };
        for i in 0..=nx {
            for j in 0..=ny {
                for k in 0..=nz {
                    writeln!(self.nodes, "  {name}{}: [{}, {}, {}]", id(i, j, k), at(0, i), at(1, j), at(2, k))
                        .unwrap();
                }
            }
        }
        let mut members = Vec::new();
        for i in 0..nx {
            for j in 0..ny {
                let face = |k: usize| [id(i, j, k), id(i + 1, j, k), id(i + 1, j + 1, k), id(i, j + 1, k)];
                for k in 0..nz.max(1) {
                    let corners = if nz == 0 { face(0).to_vec() } else { [face(k), face(k + 1)].concat() };
                    let nodes: Vec<String> = corners.iter().map(|n| format!("{name}{n}")).collect();
                    let kind = if nz == 0 { "shell4" } else { "hex8" };
                    let element = format!("{name}_{}", members.len());
                    writeln!(
                        self.elements,
                        "  {element}: {{type: {kind}, nodes: [{}], section: {kind}}}",
                        nodes.join(", ")
                    )
                    .unwrap();
                    members.push(element);
                }
            }
        }
        writeln!(self.groups, "  {name}: [{}]", members.join(", ")).unwrap();
        let name = name.to_string();
        move |i, j, k| format!("{name}{}", id(i, j, k))
    }

    fn read(&self, nu: f64, rest: &str) -> Result<Model, Vec<Problem>> {
        let text = format!(
            "retune: 1\nname: tied\nnodes:\n{}sections:\n  shell4: {{E: 70e9, nu: {nu}, density: 2700, thickness: 0.01}}\n  hex8: {{E: 70e9, nu: {nu}, density: 2700}}\nelements:\n{}groups:\n{}{rest}",
            self.nodes, self.elements, self.groups
        );
        load(&text, &Registry::builtin()).map(|l| l.0)
    }

    fn model(&self, nu: f64, rest: &str) -> Model {
        self.read(nu, rest).unwrap_or_else(|p| panic!("{p:#?}"))
    }

    fn error(&self, rest: &str) -> String {
        let problems = self.read(0.3, rest).expect_err("the file is wrong");
        problems.iter().map(|p| format!("{}: {}", p.path, p.message)).collect::<Vec<_>>().join("\n")
    }
}

fn pull(model: &Model, nodes: &[(String, f64)], dof: Dof) -> DVector<f64> {
    let system = model.assemble(&model.parameters().nominal()).unwrap();
    let mut load = DVector::zeros(system.stiffness.nrows());
    for (node, force) in nodes {
        for &(row, factor) in model.dof_map().express(model.dof_map().node(node).unwrap(), dof) {
            load[row] += force * factor;
        }
    }
    DMatrix::cholesky(system.stiffness).unwrap().solve(&load)
}

fn moved(model: &Model, u: &DVector<f64>, node: &str, dof: Dof) -> f64 {
    let dofs = model.dof_map();
    dofs.express(dofs.node(node).unwrap(), dof).iter().map(|&(row, f)| f * u[row]).sum()
}

fn frequencies(model: &Model, n: usize) -> Vec<f64> {
    let options = SolveOptions { n_elastic: n, shift: None };
    let found = solve_modes(model, &model.parameters().nominal(), options).unwrap();
    found.elastic().map(|i| found.frequency_hz(i)).collect()
}

/// Two bars of solids whose faces have 2 x 2 and 4 x 4 cells, pulled: the finer face follows the coarser without a gap, and stress and stretch are uniform, F L/(E A).
#[test]
fn a_tied_bar_stretches_as_one() {
    let (length, side, force) = (1.0, 0.2, 1e6);
    let stretch = force * length / (70e9 * side * side);
    let soft = 4e8;
    for (k, more) in [("", 0.0), (", k: {ux: 4e8}", force / (25.0 * soft))] {
        let mut parts = Parts::default();
        let a = parts.block("a", [2, 2, 2], [0.0; 3], [0.5, side, side]);
        let b = parts.block("b", [2, 4, 4], [0.5, 0.0, 0.0], [1.0, side, side]);
        let list = |f: &dyn Fn(usize, usize) -> String, n: usize| {
            (0..=n).flat_map(|j| (0..=n).map(move |k| (j, k))).map(|(j, k)| f(j, k)).collect::<Vec<_>>()
        };
        let root = list(&|j, k| a(0, j, k), 2).join(", ");
        let face = list(&|j, k| b(0, j, k), 4).join(", ");
        let rest =
            format!("ties: {{joint: {{nodes: [{face}], to: [a]{k}}}}}\nsupports: {{root: {{nodes: [{root}]}}}}\n");
        let model = parts.model(0.0, &rest);
        let share = |i: usize| if i == 0 || i == 4 { 1.0 } else { 2.0 };
        let forces: Vec<(String, f64)> = (0..=4)
            .flat_map(|j| (0..=4).map(move |k| (j, k)))
            .map(|(j, k)| (b(2, j, k), force * share(j) * share(k) / 64.0))
            .collect();
        let u = pull(&model, &forces, Dof::Ux);
        let found: Vec<f64> = list(&|j, k| b(2, j, k), 4).iter().map(|n| moved(&model, &u, n, Dof::Ux)).collect();
        if more == 0.0 {
            assert!(found.iter().all(|f| (f / stretch - 1.0).abs() < 1e-9), "{found:?} {stretch}");
        } else {
            // Springs of equal stiffness at nodes of unequal shares: their mean by the forces is as stiff as the work of the forces says.
            let mean = forces.iter().zip(&found).map(|((_, f), u)| f * u).sum::<f64>() / force;
            assert!((mean - stretch) / more > 0.99 && (mean - stretch) / more < 1.3, "{mean} {stretch} {more}");
            let context = retune::effect::Context::default();
            let structure = Structure::new(&model, &context);
            let effects = Effects::builtin();
            let places = effects.find("stiffness-change").unwrap().locations(&structure);
            assert!(places.iter().any(|l| l.place() == "joint"), "the springs of a tie are a place");
        }
    }
}

/// Two plates beside each other with unlike meshes are one plate; a skin that stands 20 mm above another moves with it as a rigid body exactly.
#[test]
fn tied_plates_are_one_plate() {
    let whole = |n: usize| {
        let mut parts = Parts::default();
        let a = parts.block("a", [12 * n, 6 * n, 0], [0.0; 3], [1.2, 0.6, 0.0]);
        let root: Vec<String> = (0..=6 * n).map(|j| a(0, j, 0)).collect();
        frequencies(&parts.model(0.3, &format!("supports: {{root: {{nodes: [{}]}}}}\n", root.join(", "))), 6)
    };
    let (coarse, fine) = (whole(1), whole(3));
    let mut parts = Parts::default();
    let a = parts.block("a", [6, 6, 0], [0.0; 3], [0.6, 0.6, 0.0]);
    let b = parts.block("b", [7, 8, 0], [0.6, 0.0, 0.0], [1.2, 0.6, 0.0]);
    let list = |f: &dyn Fn(usize) -> String, n: usize| (0..=n).map(f).collect::<Vec<_>>().join(", ");
    let (root, edge) = (list(&|j| a(0, j, 0), 6), list(&|j| b(0, j, 0), 8));
    let supports = format!("supports: {{root: {{nodes: [{root}]}}}}\n");
    let tied = frequencies(&parts.model(0.3, &format!("ties: {{seam: {{nodes: [{edge}], to: [a]}}}}\n{supports}")), 6);
    // No further from the fine mesh than the one that is as coarse.
    for ((t, c), f) in tied.iter().zip(&coarse).zip(&fine) {
        assert!((t / f - 1.0).abs() < (c / f - 1.0).abs() + 1e-3, "{tied:?} {coarse:?} {fine:?}");
    }
    // A hinge is softer, and without the rotations of the edge the plate can fold.
    let hinged = frequencies(
        &parts.model(0.3, &format!("ties: {{seam: {{nodes: [{edge}], to: [a], rotations: false}}}}\n{supports}")),
        1,
    );
    assert!(hinged[0] < 0.3 * tied[0], "{hinged:?} {tied:?}");

    let mut parts = Parts::default();
    let _ = parts.block("a", [4, 4, 0], [0.0; 3], [0.4, 0.4, 0.0]);
    let b = parts.block("b", [3, 3, 0], [0.05, 0.05, 0.02], [0.35, 0.35, 0.02]);
    let nodes: Vec<String> = (0..=3).flat_map(|i| (0..=3).map(move |j| (i, j))).map(|(i, j)| b(i, j, 0)).collect();
    let model =
        parts.model(0.3, &format!("ties: {{glue: {{nodes: [{}], to: [a], within: 25 mm}}}}\n", nodes.join(", ")));
    let dofs = model.dof_map();
    let rigid = dofs.rigid_motions();
    for node in &nodes {
        let node = dofs.node(node).unwrap();
        for motion in 0..6 {
            let expected = retune::model::rigid_motion(dofs.positions()[node], motion);
            for dof in Dof::ALL {
                let found: f64 = dofs.express(node, dof).iter().map(|(row, f)| f * rigid[(*row, motion)]).sum();
                assert!((found - expected[dof as usize]).abs() < 1e-12, "{dof} {motion}: {found}");
            }
        }
    }
    // Glued on, the second plate stiffens the first as one of twice the depth and more: D grows by the distance between both.
    let alone = {
        let mut parts = Parts::default();
        let _ = parts.block("a", [4, 4, 0], [0.0; 3], [0.4, 0.4, 0.0]);
        frequencies(&parts.model(0.3, ""), 1)[0]
    };
    assert!(frequencies(&model, 1)[0] > 1.3 * alone);
}

/// What cannot be tied is refused, with the name of what is wrong.
#[test]
fn what_cannot_be_tied_is_said() {
    let mut parts = Parts::default();
    let _ = parts.block("a", [1, 1, 0], [0.0; 3], [0.4, 0.4, 0.0]);
    let _ = parts.block("b", [1, 1, 0], [0.5, 0.0, 0.0], [0.9, 0.4, 0.0]);
    let cases = [
        ("ties: {t: {nodes: [b0], to: [a]}}\n", "stand too far"),
        ("ties: {t: {nodes: [b0], to: [c]}}\n", "no part, group or element `c`"),
        ("ties: {t: {nodes: [b9], to: [a]}}\n", "`b9`"),
        ("ties: {t: {nodes: [], to: [a]}}\n", "needs nodes that follow"),
        ("ties: {t: {nodes: [b0], to: []}}\n", "needs what its nodes follow"),
        ("ties: {t: {nodes: [b0], to: [a], within: 0 m}}\n", "above zero"),
        ("ties: {t: {nodes: [b0], to: [a], within: 1 kg}}\n", "kg"),
        ("ties: {t: {nodes: [b0], to: [a], within: 1 m, k: {uu: 3}}}\n", "unknown direction `uu`"),
        (
            "ties: {t: {nodes: [b0], to: [a], within: 1 m}, s: {nodes: [b0], to: [a], within: 1 m}}\n",
            "follows in tie `t` already",
        ),
        (
            "bars: {c: {nodes: [a0, b0], properties: {E: 1e9, A: 1e-4}}}\nties: {t: {nodes: [b1], to: [c], within: 1 m}}\n",
            "nodes follow shells and solids",
        ),
    ];
    for (rest, expected) in cases {
        let found = parts.error(rest);
        assert!(found.contains(expected), "{rest}\n{found}");
    }
}
