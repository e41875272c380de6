//! What `check` says of the boundaries of meshes and of thicknesses: each mistake made on purpose, and a sound mesh beside it.

use super::written_mesh::Written;
use super::{Model, Registry, Soundness, lint, load_in};

const SECTIONS: &str = "sections:\n  thin: {E: 70 GPa, nu: 0.33, density: 2700 kg/m3, thickness: 2 mm}\n  \
                        solid: {E: 70 GPa, nu: 0.33, density: 2700 kg/m3}\n";

fn model(mesh: &Written, parts: &str, more: &str) -> Model {
    let text = format!(
        "retune: 1\nname: sheets\n{SECTIONS}mesh: {{file: a.msh, units: m, patches: 0, parts: {{{parts}}}}}\n{more}"
    );
    let bytes = mesh.text();
    let mut files = |_: &str| Ok(bytes.clone().into_bytes());
    load_in(&text, None, &Registry::builtin(), &mut files).unwrap_or_else(|p| panic!("{p:#?}")).0
}

fn said(s: &Soundness) -> Vec<String> {
    let all = s.warnings.iter().chain(&s.errors).map(|p| format!("{}: {}", p.path, p.message));
    // A few elements are coarse, and that is told too.
    all.filter(|t| !t.contains("the mesh is coarse")).collect()
}

const X: [f64; 3] = [0.4, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 0.2, 0.0];

#[test]
fn a_sheet_has_one_rim() {
    let mut mesh = Written::new();
    mesh.sheet("skin", [0.0; 3], [X, Y], [8, 4]);
    let s = lint(&model(&mesh, "skin: {section: thin}", "")).unwrap();
    let [rim] = &s.free_edges[..] else { panic!("{:?}", s.free_edges) };
    assert_eq!((rim.part.as_str(), rim.n_edges, rim.n_lines, rim.n_tied), ("skin", 24, 1, 0));
    assert!((rim.length - 1.2).abs() < 1e-12);
    assert!(!said(&s).iter().any(|t| t.contains("free edge") || t.contains("hole")), "{:?}", said(&s));
}

/// Six sheets whose nodes are merged enclose a volume: no edge is free.
#[test]
fn a_closed_skin_has_no_free_edge() {
    let (x, y, z, o) = ([0.2, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.2], [0.0; 3]);
    let mut mesh = Written::new();
    mesh.sheet("floor", o, [y, x], [3, 3]).sheet("roof", z, [x, y], [3, 3]).sheet("a", o, [x, z], [3, 3]);
    mesh.sheet("b", y, [z, x], [3, 3]).sheet("c", o, [z, y], [3, 3]).sheet("d", x, [y, z], [3, 3]).merged();
    let parts = "floor: {section: thin}, roof: {section: thin}, a: {section: thin}, b: {section: thin}, c: {section: thin}, d: {section: thin}";
    let s = lint(&model(&mesh, parts, "")).unwrap();
    assert!(s.free_edges.iter().all(|f| f.n_edges == 0), "{:?}", s.free_edges);
    assert_eq!(said(&s), [""; 0]);
}

/// Two sheets side by side with a node each where they meet; merged, they are one.
#[test]
fn edges_that_lie_on_each_other_are_told() {
    let mut mesh = Written::new();
    mesh.sheet("left", [0.0; 3], [X, Y], [8, 4]).sheet("right", X, [X, Y], [8, 4]);
    let parts = "left: {section: thin}, right: {section: thin}";
    let all = said(&lint(&model(&mesh, parts, "")).unwrap());
    let seam = "mesh.parts.left: 4 free edges lie on those of `right`, of `e29` and `e33` first, and their nodes are not joined";
    assert!(all.iter().any(|t| t.starts_with(seam)), "{all:?}");
    assert!(!all.iter().any(|t| t.contains("pairs of nodes")), "the nodes are told twice: {all:?}");
    let s = lint(&model(mesh.merged(), parts, "")).unwrap();
    assert_eq!(said(&s), [""; 0]);
    assert_eq!(s.free_edges.iter().map(|f| f.n_edges).collect::<Vec<_>>(), [20, 20]);
}

/// Four cells beside three: the inner nodes of either side stand on edges of the other, until they are tied.
#[test]
fn meshes_that_do_not_match_are_told_until_they_are_tied() {
    let mut mesh = Written::new();
    mesh.sheet("left", [0.0; 3], [X, Y], [8, 4]).sheet("right", X, [X, Y], [8, 3]);
    let parts = "left: {section: thin}, right: {section: thin}";
    let all = said(&lint(&model(&mesh, parts, "")).unwrap());
    for expected in [
        "left: 3 nodes of its free edges, `n42` first, stand on free edges of `right`",
        "right: 2 nodes of its free edges",
    ] {
        assert!(all.iter().any(|t| t.contains(expected)), "{all:?}");
    }
    let tied = "ties: {seam: {nodes: [n41, n42, n43, n44, n45], to: [right]}}\n";
    let s = lint(&model(&mesh, parts, tied)).unwrap();
    assert!(!said(&s).iter().any(|t| t.contains("free edge")), "{:?}", said(&s));
    assert_eq!(s.free_edges[0].n_tied, 4);
}

#[test]
fn holes_and_elements_that_stand_twice_are_told() {
    let mut mesh = Written::new();
    mesh.sheet("skin", [0.0; 3], [X, Y], [8, 4]);
    let removed = mesh.groups[0].2.remove(9);
    let all = said(&lint(&model(&mesh, "skin: {section: thin}", "")).unwrap());
    assert!(
        all.iter().any(|t| t.contains("1 hole no larger than an element, between `n12` and `n13` first")),
        "{all:?}"
    );
    mesh.groups[0].2.extend([removed.clone(), removed]);
    let all = said(&lint(&model(&mesh, "skin: {section: thin}", "")).unwrap());
    assert!(all.iter().any(|t| t.contains("1 element of it stands")), "{all:?}");
    assert!(!all.iter().any(|t| t.contains("hole")), "{all:?}");
}

/// Two bricks of eight cells each; the faces where they meet have nodes of their own.
#[test]
fn faces_that_lie_on_each_other_are_told() {
    let mut mesh = Written::new();
    for (name, start) in [("low", 0.0), ("high", 0.2)] {
        let id: Vec<usize> = (0..27)
            .map(|k: usize| {
                let [i, j, l] = [k / 9, k / 3 % 3, k % 3].map(|v| 0.1 * v as f64);
                mesh.node([i, j, start + l])
            })
            .collect();
        let at = |i: usize, j: usize, l: usize| id[9 * i + 3 * j + l];
        let cell = |i: usize, j: usize, l: usize| {
            let ring = |l: usize| vec![at(i, j, l), at(i + 1, j, l), at(i + 1, j + 1, l), at(i, j + 1, l)];
            [ring(l), ring(l + 1)].concat()
        };
        mesh.groups.push((name, 5, (0..8).map(|k| cell(k / 4, k / 2 % 2, k % 2)).collect()));
    }
    let parts = "low: {section: solid}, high: {section: solid}";
    let all = said(&lint(&model(&mesh, parts, "")).unwrap());
    assert!(all.iter().any(|t| t.starts_with("mesh.parts.low: 4 free faces lie on those of `high`")), "{all:?}");
    assert!(!said(&lint(&model(mesh.merged(), parts, "")).unwrap()).iter().any(|t| t.contains("face")));
}

#[test]
fn thicknesses_of_other_units_are_told() {
    let mut mesh = Written::new();
    mesh.sheet("left", [0.0; 3], [X, Y], [8, 4]).sheet("right", X, [X, Y], [8, 4]).merged();
    let of = |thickness: &str| {
        let right =
            format!("left: {{section: thin}}, right: {{section: thin, properties: {{thickness: {thickness}}}}}");
        said(&lint(&model(&mesh, &right, "")).unwrap())
    };
    assert!(of("2").iter().any(|t| t.contains("m thick and cover")), "{:?}", of("2"));
    assert!(of("2").iter().any(|t| t.contains("in one unit?")), "{:?}", of("2"));
    assert!(of("2e-6").iter().any(|t| t.contains("their thickness: are `units`")), "{:?}", of("2e-6"));
    assert_eq!(of("6 mm"), [""; 0]);
}

/// Anchors of two guys at one place need no joint where both are held; where one of them moves, nothing joins them.
#[test]
fn held_nodes_at_one_place_need_no_joint() {
    let said_of = |supports: &str| {
        let file = format!(
            "retune: 1\nname: mast\nnodes: {{foot: [0, 0, 0], top: [0, 0, 4], a: [3, 0, 0], b: [3, 0, 0]}}\n\
             sections: {{pipe: {{E: 210 GPa, nu: 0.3, density: 7850 kg/m3, shape: {{tube: {{diameter: 60 mm, wall: 3 mm}}}}}}}}\n\
             elements:\n  mast: {{type: beam, nodes: [foot, top], section: pipe, orientation: [1, 0, 0]}}\n  \
             one: {{type: beam, nodes: [a, top], section: pipe}}\n  two: {{type: beam, nodes: [b, top], section: pipe}}\n\
             supports: {supports}\n"
        );
        let mut files = |_: &str| Err(std::io::Error::other("none"));
        let loaded = load_in(&file, None, &Registry::builtin(), &mut files);
        said(&lint(&loaded.unwrap_or_else(|p| panic!("{p:#?}")).0).unwrap())
    };
    let joins = |said: &[String]| said.iter().any(|t| t.contains("nothing joins them"));
    assert!(!joins(&said_of("{held: {nodes: [foot, a, b]}}")));
    assert!(joins(&said_of("{held: {nodes: [foot, a]}, hinge: {node: b, fixed: [ux, uy, uz]}}")));
}

/// A box on one node of a plate turns on its drilling stiffness, among the first modes; on a footprint it does not, nor where its inertia is small.
#[test]
fn a_body_on_one_node_of_a_shell_hangs_on_drilling_alone() {
    let mut mesh = Written::new();
    mesh.sheet("skin", [0.0; 3], [X, Y], [8, 4]);
    let said_of = |inertia: &str, more: &str| {
        let masses = format!("masses: {{box: {{node: n, mass: 0.2 kg, inertia: {{zz: {inertia}}}}}}}");
        let points = "nodes: {n: {nearest: [0.2 m, 0.1 m, 0 m]}, a: {nearest: [0.25 m, 0.1 m, 0 m]}, b: {nearest: [0.2 m, 0.15 m, 0 m]}}";
        said(&lint(&model(&mesh, "skin: {section: thin}", &format!("{points}\n{masses}\n{more}"))).unwrap())
    };
    let hangs = |said: &[String]| said.iter().any(|t| t.starts_with("masses.box: `box` turns about the normal"));
    let said = said_of("0.05 kg m2", "");
    assert!(hangs(&said), "{said:?}");
    assert!(!hangs(&said_of("1e-9 kg m2", "")));
    assert!(!hangs(&said_of("0.05 kg m2", "rigid_links: {foot: {master: n, slaves: [a, b]}}")));
    // Springs to the ground: along the plate they hold no turn, about the normal they do, and they are no bodies.
    let spring = |of: &str| format!("springs: {{soil: {{node: n, {of}}}}}");
    assert!(hangs(&said_of("0.05 kg m2", &spring("k: {ux: 10 N/m}"))));
    assert!(!hangs(&said_of("0.05 kg m2", &spring("k: {rz: 10 N m/rad}"))));
}
