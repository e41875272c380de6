//! Models whose mesh stays in its file.

use super::{Model, ParametricModel, Registry, load, load_in};
use crate::linalg::DMatrix;
use crate::modal::{SolveOptions, solve};
use crate::yaml::Problem;
use std::fmt::Write;

/// A plate of nx x ny quadrilaterals in mm as MSH 4.1: the surface `skin`, its edge at x = 0 `root`, its corner `tip`.
pub(super) fn plate([nx, ny]: [usize; 2], [a, b]: [f64; 2]) -> String {
    let id = |i: usize, j: usize| 1 + i * (ny + 1) + j;
    let (nodes, cells) = ((nx + 1) * (ny + 1), nx * ny);
    let mut text = format!(
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n0 3 \"tip\"\n1 1 \"root\"\n2 2 \"skin\"\n$EndPhysicalNames\n\
         $Entities\n1 1 1 0\n1 {a} {b} 0 1 3\n1 0 0 0 0 {b} 0 1 1 0\n1 0 0 0 {a} {b} 0 1 2 0\n$EndEntities\n$Nodes\n1 {nodes} 1 {nodes}\n2 1 0 {nodes}\n"
    );
    (1..=nodes).for_each(|n| writeln!(text, "{n}").unwrap());
    for i in 0..=nx {
        for j in 0..=ny {
            writeln!(text, "{} {} 0", a * i as f64 / nx as f64, b * j as f64 / ny as f64).unwrap();
        }
    }
    let total = cells + ny + 1;
    write!(text, "$EndNodes\n$Elements\n3 {total} 1 {total}\n0 1 15 1\n1 {nodes}\n1 1 1 {ny}\n").unwrap();
    (0..ny).for_each(|j| writeln!(text, "{} {} {}", 2 + j, id(0, j), id(0, j + 1)).unwrap());
    writeln!(text, "2 1 3 {cells}").unwrap();
    for i in 0..nx {
        for j in 0..ny {
            let corners = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)].map(|n| n.to_string());
            writeln!(text, "{} {}", 2 + ny + i * ny + j, corners.join(" ")).unwrap();
        }
    }
    text + "$EndElements\n"
}

const SKIN: &str = "sections: {alu: {E: 70 GPa, nu: 0.33, density: 2700 kg/m3, thickness: 2 mm}}\n";

fn read(rest: &str, mesh: &str) -> Result<(Model, Vec<Problem>), Vec<Problem>> {
    let text = format!("retune: 1\nname: plate\n{SKIN}{rest}");
    let mut files = |file: &str| {
        if file == "plate.msh" { Ok(mesh.as_bytes().to_vec()) } else { Err(std::io::ErrorKind::NotFound.into()) }
    };
    load_in(&text, None, &Registry::builtin(), &mut files).map(|(model, problems, _)| (model, problems))
}

fn model(rest: &str) -> Model {
    read(rest, &plate([8, 4], [400.0, 200.0])).unwrap_or_else(|p| panic!("{p:#?}")).0
}

fn frequencies(model: &Model) -> Vec<f64> {
    let system = model.assemble(&model.parameters().nominal()).unwrap();
    let none = DMatrix::zeros(system.stiffness.nrows(), 0);
    let modes = solve(&system.stiffness, &system.mass, &none, SolveOptions { n_elastic: 5, shift: None }).unwrap();
    (0..5).map(|i| modes.frequency_hz(i)).collect()
}

const MESH: &str = "mesh: {file: plate.msh, units: mm, parts: {skin: {section: alu}}}\n";

/// The same plate written out node by node has the same matrices, and so the same frequencies, to the last bits.
#[test]
fn a_mesh_is_what_its_nodes_and_elements_would_be() {
    let by_mesh =
        model(&format!("{MESH}supports: {{clamp: {{nodes: [root]}}}}\nmasses: {{tip: {{node: tip, mass: 50 g}}}}\n"));
    let mut text = format!("retune: 1\nname: plate\n{SKIN}nodes:\n");
    let id = |i: usize, j: usize| 1 + i * 5 + j;
    for i in 0..=8 {
        for j in 0..=4 {
            writeln!(text, "  n{}: [{}, {}, 0]", id(i, j), 0.05 * i as f64, 0.05 * j as f64).unwrap();
        }
    }
    text += "elements:\n";
    for i in 0..8 {
        for j in 0..4 {
            let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
            writeln!(text, "  e{}: {{type: shell4, nodes: [n{a}, n{b}, n{c}, n{d}], section: alu}}", 6 + i * 4 + j)
                .unwrap();
        }
    }
    text += "supports: {clamp: {nodes: [n1, n2, n3, n4, n5]}}\nmasses: {tip: {node: n45, mass: 50 g}}\n";
    let (written, ..) = load(&text, &Registry::builtin()).unwrap();
    let (own, other) = (frequencies(&by_mesh), frequencies(&written));
    assert!(own.iter().zip(&other).all(|(a, b)| (a / b - 1.0).abs() < 1e-10), "{own:?} {other:?}");
    assert_eq!(by_mesh.dof_map().n_dof(), 6 * 40);
    assert_eq!(by_mesh.element_set("skin").unwrap().len(), 32);
}

/// Nodes by number, by place, by both their names; frames and springs on them.
#[test]
fn nodes_of_a_mesh_have_names() {
    let text = format!(
        "{MESH}nodes:\n  corner: {{mesh: 45}}\n  middle: {{nearest: [201 mm, 99 mm, 1 mm]}}\n  hub: [0.5 m, 0.2 m, 0]\n\
         springs: {{stay: {{nodes: [n45, hub], k: {{uz: 1 kN/m}}}}}}\nmasses: {{lump: {{node: middle, mass: 10 g}}, other: {{node: n23, mass: 1 g}}}}\n\
         rigid_links: {{beam: {{master: hub, slaves: [tip]}}}}\nsupports: {{clamp: {{nodes: [root]}}}}\n"
    )
    .replace("springs: {stay: {nodes: [n45, hub], k: {uz: 1 kN/m}}}\n", "");
    let model = model(&text);
    let g = model.geometry();
    assert_eq!(g.node("corner"), g.node("n45"));
    assert_eq!(g.positions[g.node("corner").unwrap()], [0.4, 0.2, 0.0]);
    assert_eq!(g.node("middle"), g.node("n23"));
    // The list of the link has the one name that is written.
    assert_eq!(model.spec().rigid_links["beam"].slaves, ["corner"]);
    assert_eq!(model.spec().supports["clamp"].nodes.as_ref().unwrap().len(), 5);
}

/// Patches share out a part, each in one piece; elements of them can be changed by their names.
#[test]
fn patches_share_out_a_part() {
    let text = MESH.replace("units: mm", "units: mm, patches: 6");
    let clamped = format!("{text}supports: {{clamp: {{nodes: [root]}}}}\n");
    let before = model(&clamped);
    assert_eq!(before.patches(), ["skin.p1", "skin.p2", "skin.p3", "skin.p4", "skin.p5", "skin.p6"]);
    let mut all: Vec<usize> = before.patches().iter().flat_map(|p| before.element_set(p).unwrap()).copied().collect();
    all.sort_unstable();
    assert_eq!(all, before.element_set("skin").unwrap());
    assert!(before.patches().iter().all(|p| (2..=12).contains(&before.element_set(p).unwrap().len())));
    let cut = model(&format!("{clamped}overrides: {{cut: {{of: [skin.p1, e30], stiffness: 0.1}}}}\n"));
    assert!(frequencies(&cut)[0] < 0.999 * frequencies(&before)[0]);
}

/// Shells that a file lists one by one have sites, parts and patches as those of a mesh file; few of them are places node by node.
#[test]
fn many_listed_shells_are_a_mesh() {
    let listed = |n: usize| {
        let mut text = format!("retune: 1\nname: listed\n{SKIN}nodes:\n");
        let all = || (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j)));
        all().for_each(|(i, j)| writeln!(text, "  n{i}_{j}: [{}, {}, 0]", 0.1 * i as f64, 0.1 * j as f64).unwrap());
        text += "elements:\n";
        let cells = || (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        for (i, j) in cells() {
            let (k, l) = (i + 1, j + 1);
            let nodes = format!("n{i}_{j}, n{k}_{j}, n{k}_{l}, n{i}_{l}");
            writeln!(text, "  s{i}_{j}: {{type: shell4, nodes: [{nodes}], section: alu}}").unwrap();
        }
        text += "masses: {store: {node: n5_3, mass: 1 kg}}\nsupports: {clamp: {node: n0_0}}\ngroups:\n";
        for (name, is_left) in [("left", true), ("right", false)] {
            let own: Vec<String> =
                cells().filter(|c| (c.0 < n / 2) == is_left).map(|(i, j)| format!("s{i}_{j}")).collect();
            writeln!(text, "  {name}: [{}]", own.join(", ")).unwrap();
        }
        text += "  corner: [s0_0, s0_1]\n";
        load(&text, &Registry::builtin()).unwrap_or_else(|p| panic!("{p:#?}")).0
    };
    let (many, few) = (listed(12), listed(6));
    assert_eq!(many.mesh_parts(), ["left", "right"]);
    assert_eq!(many.patches().len(), 36, "{:?}", many.patches());
    let sites = |m: &Model| (0..m.n_named_nodes()).filter(|&n| m.is_site(n)).count();
    assert!(many.is_site(many.geometry().node("n5_3").unwrap()) && (100..=101).contains(&sites(&many)));
    assert_eq!((sites(&few), few.patches().len()), (49, 0));
}

/// What is wrong is said where it stands, with what the mesh has.
#[test]
fn mistakes_about_a_mesh_have_their_places() {
    let mesh = plate([8, 4], [400.0, 200.0]);
    let support = "supports: {clamp: {nodes: [root]}}\n";
    for (from, to, path, expected) in [
        ("skin: {section", "skim: {section", "mesh.parts.skim", "did you mean `skin`"),
        ("units: mm", "units: kg", "mesh.units", "not a unit of length"),
        ("plate.msh", "plat.msh", "mesh.file", "cannot be read"),
        ("skin: {section: alu}", "skin: {section: alu, type: hex8}", "mesh.parts.skin.type", "not an element for"),
        ("skin: {section: alu}", "skin: {section: alu}, tip: {section: alu}", "mesh.parts.tip", "points"),
        ("units: mm", "units: mm, sha256: abc", "mesh.sha256", "another file"),
        ("skin: {section: alu}", "skin: {section: al}", "mesh.parts.skin.section", "did you mean `alu`"),
        ("}}}\n", "}}}\nnodes: {a: {mesh: 99}}\n", "nodes.a.mesh", "no node 99"),
        ("}}}\n", "}}}\nnodes: {n7: [0, 0, 0]}\n", "nodes.n7", "another name"),
        ("}}}\n", "}}}\nnodes: {a: {mesh: 4}, b: {mesh: 4}}\n", "nodes.b", "same node"),
    ] {
        let text = MESH.replacen(from, to, 1) + support;
        assert!(text.contains(to));
        let problems = read(&text, &mesh).unwrap_err();
        let found = problems.iter().any(|p| p.path == path && p.message.contains(expected));
        assert!(found, "{to}: {problems:#?}");
    }
    let problems = read(&format!("{MESH}supports: {{clamp: {{nodes: [rot]}}}}\n"), &mesh).unwrap_err();
    assert!(problems.iter().any(|p| p.message.contains("`rot` is not defined")), "{problems:#?}");
    let problems = read(&format!("{MESH}{support}"), &mesh[..mesh.len() / 2]).unwrap_err();
    assert!(problems.iter().any(|p| p.message.contains("`plate.msh`: line")), "{problems:#?}");
}

/// A thick plate, clamped at one side and held in its plane, of quadrilaterals or of patches of four triangles around a quadrilateral.
fn plate_in_its_plane(n: [usize; 2], patches: bool) -> Model {
    let mut text = String::from("retune: 1\nname: plate\n");
    text += SKIN;
    let (mut nodes, mut elements) = (String::new(), String::new());
    let corner = |i: usize, j: usize| i % 2 == 1 && j % 2 == 1;
    for i in 0..=2 * n[0] {
        for j in 0..=2 * n[1] {
            if !(patches && corner(i, j)) {
                writeln!(nodes, "  n{i}_{j}: [{} mm, {} mm, 0 mm]", 200 * i / n[0], 150 * j / n[1]).unwrap();
            }
        }
    }
    let mut add = |kind: &str, at: &[[usize; 2]]| {
        let names: Vec<String> = at.iter().map(|[i, j]| format!("n{i}_{j}")).collect();
        let count = elements.lines().count();
        writeln!(elements, "  e{count}: {{type: {kind}, nodes: [{}], section: alu}}", names.join(", ")).unwrap();
    };
    for i in (0..2 * n[0]).step_by(2) {
        for j in (0..2 * n[1]).step_by(2) {
            if patches {
                let [a, b, c, d] = [[i + 1, j], [i + 2, j + 1], [i + 1, j + 2], [i, j + 1]];
                add("shell4", &[a, b, c, d]);
                add("shell3", &[[i, j], a, d]);
                add("shell3", &[[i + 2, j], b, a]);
                add("shell3", &[[i + 2, j + 2], c, b]);
                add("shell3", &[[i, j + 2], d, c]);
            } else {
                for [i, j] in [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]] {
                    add("shell4", &[[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]]);
                }
            }
        }
    }
    write!(text, "nodes:\n{nodes}elements:\n{elements}supports:\n").unwrap();
    for i in 0..=2 * n[0] {
        for j in 0..=2 * n[1] {
            let fixed = if i == 0 { "[ux, uy, uz, rx, ry, rz]" } else { "[uz, rx, ry]" };
            if !(patches && corner(i, j)) {
                writeln!(text, "  s{i}_{j}: {{node: n{i}_{j}, fixed: {fixed}}}").unwrap();
            }
        }
    }
    load(&text, &Registry::builtin()).unwrap_or_else(|p| panic!("{p:#?}")).0
}

/// Triangles bend at their edges in their plane and quadrilaterals do not: side by side they converge, as they do alone.
#[test]
fn triangles_among_quadrilaterals_converge_in_their_plane() {
    let exact = frequencies(&plate_in_its_plane([10, 6], false));
    let errors = |n: [usize; 2]| -> Vec<f64> {
        let found = frequencies(&plate_in_its_plane(n, true));
        exact.iter().zip(found).map(|(exact, f)| (f / exact - 1.0).abs()).collect()
    };
    let (coarse, fine) = (errors([4, 3]), errors([8, 6]));
    for mode in 0..3 {
        assert!(fine[mode] < 0.02 && fine[mode] < 0.5 * coarse[mode], "mode {mode}: {coarse:?}, {fine:?}");
    }
}

/// E, ρ and t of a plate are in four products, whatever their bounds, and its matrices are the sums of them at any θ.
#[test]
fn a_plate_has_as_many_terms_as_its_theory() {
    for share in [0.5, 0.05, 1e-3] {
        let bounds = |v: f64| format!("{{value: {v}, bounds: [{}, {}]}}", v * (1.0 - share), v * (1.0 + 1.3 * share));
        let text = format!(
            "{MESH}supports: {{clamp: {{nodes: [root]}}}}\nparameters: {{E: {}, rho: {}, t: {}}}\n",
            bounds(70e9),
            bounds(2700.0),
            bounds(2e-3)
        );
        let text = format!(
            "retune: 1\nname: plate\nsections: {{alu: {{E: E, nu: 0.33, density: rho, thickness: t}}}}\n{text}"
        );
        let mesh = plate([8, 4], [400.0, 200.0]);
        let mut files = |_: &str| Ok(mesh.as_bytes().to_vec());
        let (model, ..) = load_in(&text, None, &Registry::builtin(), &mut files).unwrap();
        let affine = model.affine().expect("polynomials");
        let powers: Vec<_> = affine.products.iter().map(|(m, _)| m.powers.clone()).collect();
        assert_eq!(powers, [vec![(0, 1), (2, 1)], vec![(0, 1), (2, 3)], vec![(1, 1), (2, 1)], vec![(1, 1), (2, 3)]]);
        assert!(affine.constant.stiffness.is_empty() && affine.parameters.iter().all(|p| p.mass.is_empty()));
        let theta = [70e9 * (1.0 + share), 2700.0 * (1.0 - 0.3 * share), 2e-3 * (1.0 + 0.7 * share)];
        let system = model.assemble(&theta).unwrap();
        let (elements, connections) = model.elements_and_connections();
        let mut sum = super::system::System::zeros(system.stiffness.nrows(), false);
        for (element, connection) in elements.iter().zip(connections) {
            let own = super::dependence::element_matrices(element, &theta).unwrap();
            super::assembly::add_element(&mut sum, connection, &own);
        }
        super::assembly::symmetrise(&mut sum);
        for (a, b) in [(&system.stiffness, &sum.stiffness), (&system.mass, &sum.mass)] {
            for i in 0..a.nrows() {
                for j in 0..a.ncols() {
                    let size = (b[(i, i)] * b[(j, j)]).sqrt();
                    assert!(
                        (a[(i, j)] - b[(i, j)]).abs() <= 1e-12 * size,
                        "{share}: {i} {j} {} {}",
                        a[(i, j)],
                        b[(i, j)]
                    );
                }
            }
        }
    }
}
