//! Cuts of meshes: runs of shells from free edges.

use super::*;
use crate::model::load_in;
use crate::model::written_mesh::Written;
use crate::model::{Model, ParametricModel};
use std::collections::BTreeSet;

/// A strip of 0.6 m by 0.3 m in squares of 0.1 m, clamped where it begins; its elements are counted across, then along.
pub(super) fn strip(in_triangles: bool) -> Model {
    let mut mesh = Written::new();
    mesh.sheet("skin", [0.0; 3], [[0.6, 0.0, 0.0], [0.0, 0.3, 0.0]], [6, 3]);
    if in_triangles {
        let (_, kind, cells) = &mut mesh.groups[0];
        *kind = 2;
        *cells = cells.iter().flat_map(|c| [vec![c[0], c[1], c[2]], vec![c[0], c[2], c[3]]]).collect();
    }
    let text = "retune: 1\nname: strip\nmesh: {file: a.msh, units: m, parts: {skin: {section: sheet}}}\n\
                sections: {sheet: {E: 70 GPa, nu: 0.3, density: 2700, thickness: 1 mm}}\n\
                supports: {clamp: {nodes: [n1, n2, n3, n4]}}\n";
    let mut files = |_: &str| Ok(mesh.text().into_bytes());
    load_in(text, None, &Registry::builtin(), &mut files).unwrap_or_else(|p| panic!("{p:#?}")).0
}

fn cuts(model: &Model) -> Vec<(String, Vec<usize>)> {
    let context = Context::default();
    let structure = Structure::new(model, &context);
    let all = structure.spans().iter().filter(|p| p.kind == PartKind::Cut);
    all.map(|p| (p.name.clone(), p.elements.clone())).collect()
}

/// Every row from both sides, in every length; along the strip from its free end only, for the other is clamped.
#[test]
fn cuts_begin_at_free_edges_and_follow_the_mesh() {
    let all = cuts(&strip(false));
    let names: BTreeSet<&str> = all.iter().map(|(name, _)| name.as_str()).collect();
    for row in 0..6 {
        let at = |k: usize| 3 * row + k;
        for name in
            [format!("e{}..e{}", at(1), at(2)), format!("e{}..e{}", at(3), at(2)), format!("e{}..e{}", at(1), at(3))]
        {
            assert!(names.contains(name.as_str()), "{name} in {names:?}");
        }
    }
    assert!(names.contains("e17..e8") && !names.contains("e2..e5"), "{names:?}");
    // One side of each row and its end in one, two and three; the other in one and two; lines of six from the free end, whose first stands already
    // but for that in the middle.
    assert_eq!(all.len(), 6 * (3 + 2) + 3 * 5 + 1, "{names:?}");
}

/// Triangles straight on: all of a cut across stand in the row in which it begins.
#[test]
fn cuts_through_triangles_are_straight() {
    let model = strip(true);
    let row = |e: usize| {
        let at = &model.geometry().positions;
        let x: f64 = model.elements()[e].nodes.iter().map(|&n| at[n][0] / 3.0).sum();
        (x / 0.1) as usize
    };
    let all = cuts(&model);
    let through: Vec<_> =
        all.iter().filter(|(_, elements)| elements.iter().all(|&e| row(e) == row(elements[0]))).collect();
    assert!((0..6).all(|r| through.iter().any(|(_, e)| e.len() == 6 && row(e[0]) == r)), "{all:?}");
}

/// A cut is the sum of its elements, is a place where places are wider, and is found by its name.
#[test]
fn a_cut_is_softer() {
    let (model, context) = (strip(false), Context::default());
    let structure = Structure::new(&model, &context);
    let soft = Effects::builtin().candidate(&structure, "cut@e7..e8").unwrap();
    let text = soft.patch.to_yaml();
    assert!(text.contains("of: [e7, e8]") && text.contains("stiffness:"), "{text}");
    let patched = soft.build(&model, &Registry::builtin()).unwrap();
    let stiffness = |loss: f64| patched.model.assemble(&patched.theta(&[], &[loss])).unwrap().stiffness;
    let base = model.assemble(&[]).unwrap().stiffness;
    assert!((stiffness(0.0) - &base).amax() <= 1e-14 * base.amax());
    // Half of the loss takes half of what the whole takes, and nothing becomes stiffer.
    let [half, most] = [0.4, 0.8].map(|loss| &base - stiffness(loss));
    assert!(half.amax() > 0.01 * base.amax() && (&most - &half * 2.0).amax() < 1e-12 * base.amax());
    assert!(half.symmetric_eigen().eigenvalues.min() > -1e-9 * base.amax());
    let ids = |all: Vec<Candidate>| all.iter().map(Candidate::id).collect::<Vec<_>>();
    let usual = ids(candidates(&model, &Effects::builtin(), &context));
    assert!(!usual.iter().any(|id| id.contains("e7..e8")));
    let base = Configured { name: None, model: &model, context: &context };
    let near = ["e7".to_string()];
    let wider = ids(candidates_on_wider_places(&[base], &Effects::builtin(), Some(&near)));
    assert!(wider.contains(&"cut@e7..e8".to_string()), "{wider:?}");
    let is_of_cut = |id: &String| id.starts_with("thickness-change") && id.contains("..");
    assert!(!wider.iter().any(|id| id.contains("e10..e11") || is_of_cut(id)), "{wider:?}");
}
