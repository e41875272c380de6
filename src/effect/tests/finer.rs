//! Places of a mesh between those that every search tries.

use super::cuts::strip;
use super::*;
use crate::effect::{Edit, Location, LocationKind};
use crate::model::load_in;
use crate::model::written_mesh::Written;
use crate::model::{Model, ParametricModel};

/// A plate of 20 by 10 squares, clamped along one side: more nodes than are tried.
fn plate() -> Model {
    clamped_from(1)
}

/// The same, clamped from one of the eleven nodes of that side on.
fn clamped_from(first: usize) -> Model {
    let mut mesh = Written::new();
    mesh.sheet("skin", [0.0; 3], [[2.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [20, 10]);
    let clamped: Vec<String> = (first..=11).map(|n| format!("n{n}")).collect();
    let text = format!(
        "retune: 1\nname: plate\nmesh: {{file: a.msh, units: m, parts: {{skin: {{section: sheet}}}}}}\n\
         sections: {{sheet: {{E: 70 GPa, nu: 0.3, density: 2700, thickness: 5 mm}}}}\nsupports: {{clamp: {{nodes: [{}]}}}}\n",
        clamped.join(", ")
    );
    let mut files = |_: &str| Ok(mesh.text().into_bytes());
    load_in(&text, None, &Registry::builtin(), &mut files).unwrap_or_else(|p| panic!("{p:#?}")).0
}

/// A node that no search tries is a place by name; so is a patch about an element: that and those that touch it, the nearest first.
#[test]
fn any_node_and_any_patch_is_a_place() {
    let model = plate();
    let structure = Structure::new(&model, Context::nothing());
    let other = (0..model.n_named_nodes())
        .find(|&n| !model.is_site(n) && model.geometry().positions[n][0] > 0.5)
        .map(|n| model.geometry().names[n].clone());
    let id = format!("point-mass@{}", other.unwrap());
    assert!(!candidates(&model, &Effects::builtin(), Context::nothing()).iter().any(|c| c.id() == id));
    let found = Effects::builtin().candidate(&structure, &id).unwrap();
    assert_eq!(found.id(), id);
    assert!(found.build(&model, &Registry::builtin()).is_ok());
    // Elements are counted across, ten in a row: the five nearest to e95 are in a cross.
    let patch = Effects::builtin().candidate(&structure, "thickness-change@e95~5").unwrap();
    let of = patch.patch.edits.iter().find_map(|e| match e {
        Edit::AddOverride { entry, .. } => Some(entry.of.clone()),
        _ => None,
    });
    assert_eq!(of.unwrap(), ["e85", "e94", "e95", "e96", "e105"]);
    for refused in ["point-mass@n9999", "thickness-change@e95~201", "thickness-change@e999~5", "thickness-change@e95~x"]
    {
        assert!(Effects::builtin().candidate(&structure, refused).is_err(), "{refused}");
    }
}

/// What is looked at about a node is no further away than half as far again as the next that is tried, and nearer with every round; about a patch
/// there are patches of several sizes.
#[test]
fn what_is_finer_comes_nearer() {
    let model = plate();
    let structure = Structure::new(&model, Context::nothing());
    let node =
        (0..model.n_named_nodes()).find(|&n| model.is_site(n) && model.geometry().positions[n][0] > 1.0).unwrap();
    let at = |n: usize| model.geometry().positions[n];
    let name = |n: usize| vec![model.geometry().names[n].clone()];
    let reach = |round: u32| -> f64 {
        let far = structure.finer(&Location::new(LocationKind::Node, name(node)), round).into_iter();
        let far = far.map(|n| at(model.geometry().node(&n).unwrap()));
        far.map(|p| (p[0] - at(node)[0]).hypot(p[1] - at(node)[1])).fold(0.0, f64::max)
    };
    assert!(reach(0) > 0.0 && reach(0) < 0.5, "{}", reach(0));
    assert!(reach(1) < 0.5 * reach(0), "{} {}", reach(0), reach(1));
    let patch = model.patches()[3].clone();
    let finer = structure.finer(&Location::new(LocationKind::Group, vec![patch]), 0);
    let sizes: std::collections::BTreeSet<&str> =
        finer.iter().filter_map(|n| n.split_once('~')).map(|(_, n)| n).collect();
    assert!(sizes.len() >= 4 && finer.len() >= 20, "{finer:?}");
}

/// A patch on one side of a symmetric structure comes with that on the other.
#[test]
fn patches_have_mirror_images() {
    let model = strip(false);
    let context = Context { further: vec!["e4~2".to_string()], ..Context::default() };
    let structure = Structure::new(&model, &context);
    let part = structure.part("e4~2").unwrap();
    let image = &structure.parts()[part.partner.unwrap()];
    assert_eq!((image.name.as_str(), image.elements.len()), ("e6~2", 2));
    assert!(Effects::builtin().candidate(&structure, "stiffness-change@e4~2+e6~2").is_ok());
}

/// A region of any shape is a place by its name, also of one piece alone, which has the name of no cut; what is about it touches it.
#[test]
fn a_region_is_a_place() {
    let model = plate();
    let structure = Structure::new(&model, Context::nothing());
    // Ten in a row: three of one row, two of the next, one of the one after it.
    let elements = [31, 32, 33, 42, 43, 53];
    let name = structure.region_name(&elements).unwrap();
    assert_eq!(name, "e32..e34,e43..e44,e54");
    for elements in [&elements[..], &[31, 32, 33], &[31, 32]] {
        let id = format!("thickness-change@{}", structure.region_name(elements).unwrap());
        let found = Effects::builtin().candidate(&structure, &id).unwrap();
        let of = found.patch.edits.iter().find_map(|e| match e {
            Edit::AddOverride { entry, .. } => Some(entry.of.clone()),
            _ => None,
        });
        let names: Vec<String> = elements.iter().map(|e| format!("e{}", e + 1)).collect();
        assert_eq!(of.unwrap(), names, "{id}");
        assert!(found.build(&model, &Registry::builtin()).is_ok(), "{id}");
    }
    let about = structure.neighbourhood(&name).unwrap();
    assert_eq!(about.inside, elements);
    // e33 (0-based 32) is beside 22, 31, 33 and 42; 52 is beside 42, 51, 53 and 62.
    let touched = |e: usize| {
        let all: Vec<usize> = about.inside.iter().chain(&about.outside).copied().collect();
        let k = all.iter().position(|&other| other == e).unwrap();
        let mut touched: Vec<usize> = about.touching[k].iter().map(|&k| all[k]).collect();
        touched.sort_unstable();
        touched
    };
    assert_eq!(touched(32), [22, 31, 33, 42]);
    assert_eq!(touched(52), [42, 51, 53, 62]);
    // A side more along the edge has its price: a row of four has ten, a square of four has eight.
    let ln = |elements: &[usize]| {
        let at = Location::new(LocationKind::Group, vec![structure.region_name(elements).unwrap()]);
        structure.ln_between(&at)
    };
    let difference = ln(&[31, 32, 33, 34]) - ln(&[31, 32, 41, 42]);
    assert!((difference - 2.0 * crate::effect::LN_OF_A_SIDE).abs() < 1e-12, "{difference}");
    for refused in ["thickness-change@e32..e999,e4", "thickness-change@e32,", "thickness-change@,"] {
        assert!(Effects::builtin().candidate(&structure, refused).is_err(), "{refused}");
    }
}

/// A stretch of a clamp is a place by name, and several are tried without one; as its compliance grows the plate is as if those nodes were free.
#[test]
fn a_clamp_may_be_open_along_a_stretch() {
    let model = plate();
    let ids: Vec<String> =
        candidates(&model, &Effects::builtin(), Context::nothing()).iter().map(Candidate::id).collect();
    let stretches: Vec<&String> = ids.iter().filter(|id| id.starts_with("root-flexibility@clamp~")).collect();
    assert!(stretches.len() >= 10, "{stretches:?}");
    let structure = Structure::new(&model, Context::nothing());
    let open = Effects::builtin().candidate(&structure, "root-flexibility@clamp~n1~4").unwrap();
    let built = open.build(&model, &Registry::builtin()).unwrap();
    let first = |model: &Model, theta: &[f64]| {
        let system = model.assemble(theta).unwrap();
        let options = crate::modal::SolveOptions { n_elastic: 4, shift: None };
        let modes = crate::modal::solve(&system.stiffness, &system.mass, &model.dof_map().rigid_motions(), options);
        modes.unwrap().lambda.iter().map(|l| l.sqrt()).collect::<Vec<_>>()
    };
    let closed = first(&model, structure.theta());
    let none = first(&built.model, &built.theta(structure.theta(), &[0.0]));
    let wide = first(&built.model, &built.theta(structure.theta(), &[1e4]));
    let free = first(&clamped_from(5), &[]);
    for k in 0..4 {
        assert!((none[k] / closed[k] - 1.0).abs() < 1e-9, "{k}: {} {}", none[k], closed[k]);
        assert!((wide[k] / free[k] - 1.0).abs() < 1e-3, "{k}: {} {}, closed {}", wide[k], free[k], closed[k]);
    }
    assert!(free[0] < 0.97 * closed[0]);
    for refused in ["clamp~n1~11", "clamp~n1~0", "clamp~n200~3", "clamp~n1", "lost~n1~3"] {
        let id = format!("root-flexibility@{refused}");
        assert!(Effects::builtin().candidate(&structure, &id).is_err(), "{refused}");
    }
    let finer = structure.finer(&Location::new(LocationKind::Group, vec!["clamp~n1~5".to_string()]), 0);
    assert!(finer.iter().any(|n| n == "clamp~n3~4" || n == "clamp~n3~5"), "{finer:?}");
}
