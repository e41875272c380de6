//! Groups that no file declares.

use super::super::*;
use crate::model::{Registry, load};

/// Two storeys of one bay by one bay, with braces in the faces across y; one foot hangs, so that no part has a mirror image.
fn tower(more: &str) -> String {
    let nodes: Vec<String> = (0..3)
        .flat_map(|z| [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(x, y)| format!("  p{x}{y}{z}: [{x}, {y}, {z}]")))
        .collect();
    let beam = |name: String, a: String, b: String, section: &str| {
        format!("  {name}: {{nodes: [{a}, {b}], section: {section}}}")
    };
    let mut beams = Vec::new();
    for z in 1..3 {
        for (k, (x, y)) in [(0, 0), (1, 0), (1, 1), (0, 1)].into_iter().enumerate() {
            beams.push(beam(format!("column{z}{k}"), format!("p{x}{y}{}", z - 1), format!("p{x}{y}{z}"), "column"));
        }
        for y in 0..2 {
            beams.push(beam(format!("brace{z}{y}"), format!("p0{y}{}", z - 1), format!("p1{y}{z}"), "brace"));
        }
    }
    format!(
        "retune: 1\nname: tower\nnodes:\n{}\nsections:\n  column: {{E: 200 GPa, nu: 0.3, density: 7800 kg/m3, shape: {{box: {{width: 60 mm, \
         height: 60 mm, wall: 4 mm}}}}}}\n  brace: {{E: 200 GPa, nu: 0.3, density: 7800 kg/m3, shape: {{box: {{width: 30 mm, height: 30 mm, \
         wall: 3 mm}}}}}}\nbeams:\n{}\nsupports: {{feet: {{nodes: [p000, p100, p110]}}}}\n{more}",
        nodes.join("\n"),
        beams.join("\n")
    )
}

fn groups(text: &str) -> Vec<(String, Vec<String>)> {
    let (model, _, _) = load(text, &Registry::builtin()).unwrap();
    let context = Context::default();
    let structure = Structure::new(&model, &context);
    let list = structure.parts().iter().filter(|p| p.kind == PartKind::Group);
    list.map(|p| (p.name.clone(), p.of.clone())).collect()
}

#[test]
fn a_frame_shows_its_storeys_and_faces() {
    let found = groups(&tower(""));
    let of =
        |name: &str| found.iter().find(|g| g.0 == name).map(|g| g.1.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!(of("brace.all"), Some(vec!["brace10", "brace11", "brace20", "brace21"]));
    assert_eq!(of("brace.z1-2"), Some(vec!["brace10", "brace11"]));
    assert_eq!(of("brace.y2"), Some(vec!["brace11", "brace21"]));
    assert_eq!(of("column.z2-3").map(|c| c.len()), Some(4));
    assert_eq!(of("column.x1").map(|c| c.len()), Some(4));
    // All braces stand between the two levels along x: that is one place, not two.
    assert_eq!(of("brace.x1-2"), None);
}

#[test]
fn what_the_file_declares_keeps_its_name() {
    let found = groups(&tower("groups: {lower_braces: [brace10, brace11], brace.y2: [column10, brace10]}"));
    let names: Vec<&str> = found.iter().map(|g| g.0.as_str()).collect();
    assert!(names.contains(&"lower_braces") && !names.contains(&"brace.z1-2"), "{names:?}");
    assert_eq!(found.iter().find(|g| g.0 == "brace.y2").map(|g| g.1.len()), Some(1), "the file's own group");
}

#[test]
fn a_line_of_nodes_has_no_levels() {
    let nodes: Vec<String> = (0..8).map(|i| format!("n{i}: [{i}, 0, 0]")).collect();
    let beams: Vec<String> = (0..7).map(|i| format!("  b{i}: {{nodes: [n{i}, n{}], section: s}}", i + 1)).collect();
    let text = format!(
        "retune: 1\nname: line\nnodes: {{{}}}\nsections: {{s: {{EIy: 1 N m2, mass_per_length: 1 kg/m}}}}\nactive_dofs: [uz, ry]\nbeams:\n{}\n\
         supports: {{a: {{node: n0}}}}\n",
        nodes.join(", "),
        beams.join("\n")
    );
    assert_eq!(groups(&text), Vec::new());
}

/// Mounts of one stiffness are a group without a declaration, and give sideways together; a foundation rocks about both axes at once.
#[test]
fn springs_that_are_alike_are_one_place() {
    let springs = "springs:\n  mount_l: {node: p001, k: {ux: 2 kN/m, uy: 2 kN/m, uz: 5 kN/m}}\n  mount_r: {node: p101, k: {ux: 2 kN/m, uy: 2 kN/m, uz: 5 kN/m}}\n  \
                   tie: {node: p012, k: {uz: 1 kN/m}}\n  soil: {node: p010, k: {ux: 9 kN/m, rx: 4 N m/rad, ry: 4 N m/rad, rz: 1 N m/rad}}\n";
    let text = tower(springs);
    let found = groups(&text);
    let mounts = found.iter().find(|g| g.0 == "mount.all").unwrap_or_else(|| panic!("{found:?}"));
    assert_eq!(mounts.1, ["mount_l", "mount_r"]);
    let (model, _, _) = load(&text, &Registry::builtin()).unwrap();
    let ids: Vec<String> =
        candidates(&model, &Effects::builtin(), Context::nothing()).iter().map(Candidate::id).collect();
    let has = |id: &str| ids.iter().any(|known| known == id);
    for id in ["mount.all", "mount.all.ux_uy", "mount_l.ux_uy", "mount_l.uz", "soil.rx_ry"] {
        assert!(has(&format!("stiffness-change@{id}")), "{id}: {ids:?}");
    }
    for id in ["mount_l.ux_uz", "soil.rx_ry_rz", "tie.uz"] {
        assert!(!has(&format!("stiffness-change@{id}")), "{id}");
    }
    // 1 + p of the two directions and of no other.
    let structure = Structure::new(&model, Context::nothing());
    let candidate = Effects::builtin().candidate(&structure, "stiffness-change@soil.rx_ry").unwrap();
    let changed = candidate.build(&model, &Registry::builtin()).unwrap();
    let theta = changed.theta(structure.theta(), &[-0.75]);
    let e = changed.model.element_set("soil").unwrap()[0];
    let k = changed.model.element_matrices(e, &theta).unwrap().stiffness;
    for (dof, expected) in [(0, 9000.0), (3, 1.0), (4, 1.0), (5, 1.0)] {
        assert!((k.get(dof, dof) - expected).abs() < 1e-9, "{dof}: {}", k.get(dof, dof));
    }
}
