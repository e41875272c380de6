//! Members that lie end to end: one beam in several entries is one place.

use super::super::*;
use crate::linalg::DMatrix;
use crate::model::{Model, ParametricModel, Registry, load};

const PROPERTIES: &str = "properties: {EIy: 10 N m2, EIz: 20 N m2, GJ: 6 N m2, EA: 1 MN, mass_per_length: 2 kg/m, polar_inertia_per_length: 0.003 kg m}";

/// A beam of six elements along x, pinned at one end and on a body at the other.
fn straight(beams: &str, groups: &str) -> String {
    format!(
        "retune: 1\nname: test\nnodes:\n  n0: [0, 0, 0]\n  n1: [0.2, 0, 0]\n  n2: [0.3, 0, 0]\n  n3: [0.55, 0, 0]\n  \
         n4: [0.7, 0, 0]\n  n5: [0.8, 0, 0]\n  n6: [1, 0, 0]\nbeams:\n{beams}\nmasses:\n  \
         tip: {{node: n6, mass: 0.5 kg, inertia: {{xx: 0.01 kg m2, yy: 0.02 kg m2, zz: 0.02 kg m2}}}}\n{groups}\n\
         supports: {{a: {{node: n0, fixed: [ux, uy, uz, rx]}}}}\n"
    )
}

fn in_one() -> String {
    straight(&format!("  b: {{chain: [n0, n1, n2, n3, n4, n5, n6], {PROPERTIES}}}"), "")
}

fn in_pieces(groups: &str) -> String {
    let piece = |name: &str, nodes: &str| format!("  {name}: {{{nodes}, {PROPERTIES}}}");
    let pieces = [
        piece("p", "chain: [n0, n1, n2]"),
        piece("q", "nodes: [n2, n3]"),
        piece("r", "pairs: [[n4, n5], [n3, n4]]"),
        piece("s", "chain: [n5, n6]"),
    ];
    straight(&pieces.join("\n"), groups)
}

fn model(text: &str) -> Model {
    load(text, &Registry::builtin()).unwrap().0
}

/// Parts that are several members of the file.
fn lines(text: &str) -> Vec<String> {
    let (model, context) = (model(text), Context::default());
    let structure = Structure::new(&model, &context);
    structure.parts().iter().filter(|p| p.kind == PartKind::Line).map(|p| p.name.clone()).collect()
}

/// K, M and C with an effect at its typical size, and that size.
fn matrices(text: &str, id: &str) -> Option<([DMatrix<f64>; 3], Vec<f64>)> {
    let (model, context) = (model(text), Context::default());
    let structure = Structure::new(&model, &context);
    let candidate = Effects::builtin().candidate(&structure, id).ok()?;
    let patched = candidate.build(&model, &Registry::builtin()).unwrap();
    let system = patched.model.assemble(&patched.theta(structure.theta(), &patched.typical)).unwrap();
    let damping = system.damping.as_ref().map_or_else(|| &system.stiffness * 0.0, Clone::clone);
    Some(([system.stiffness, system.mass, damping], patched.typical))
}

#[test]
fn a_beam_in_pieces_takes_every_effect_of_the_whole() {
    let (one, pieces) = (in_one(), in_pieces(""));
    assert_eq!(lines(&pieces), ["p..s"]);
    let (whole, context) = (model(&one), Context::default());
    let mut n = 0;
    for candidate in candidates(&whole, &Effects::builtin(), &context) {
        if candidate.location.names != ["b"] {
            continue;
        }
        let id = candidate.id();
        let (expected, size) = matrices(&one, &id).unwrap();
        let (found, its_size) =
            matrices(&pieces, &id.replace("@b", "@p..s")).unwrap_or_else(|| panic!("{id} has no place"));
        assert_eq!(size, its_size, "{id}");
        for (a, b) in expected.iter().zip(&found) {
            let scale = a.abs().max().max(1e-300);
            assert!((a - b).abs().max() <= 2e-5 * scale, "{id}: {:e}", (a - b).abs().max() / scale);
        }
        n += 1;
    }
    assert!(n >= 15, "{n}");
    let failures = conformance::check(&Effects::builtin(), &pieces, &Registry::builtin(), &Context::default());
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// A change on a span is the sum of the changes of its elements; entries of the file and their order do not matter.
#[test]
fn a_span_is_its_elements_together() {
    let (one, pieces) = (in_one(), in_pieces(""));
    let names = |text: &str| -> Vec<String> {
        let (model, context) = (model(text), Context::default());
        Structure::new(&model, &context).spans().iter().map(|p| p.name.clone()).collect()
    };
    // Two, three and four of six elements.
    assert_eq!(names(&one).len(), 5 + 4 + 3);
    let in_pieces = names(&pieces);
    assert!(["p.2..q", "q..r.2", "r.1..s.1"].iter().all(|n| in_pieces.iter().any(|name| name == n)), "{in_pieces:?}");
    assert!(!in_pieces.iter().any(|n| n == "p.1..p.2"), "the whole of p has a name: {in_pieces:?}");
    let model = model(&one);
    let context = Context::default();
    let near = ["b.3".to_string()];
    let base = Configured { name: None, model: &model, context: &context };
    let found = candidates_on_wider_places(&[base], &Effects::builtin(), Some(&near));
    let ids: Vec<String> = found.iter().map(Candidate::id).collect();
    assert!(ids.contains(&"distributed-mass@b.2..b.4".to_string()), "{ids:?}");
    assert!(!ids.iter().any(|id| id.contains("@b.4..b.5")), "{ids:?}");
    let neutral = {
        let structure = Structure::new(&model, &context);
        model.assemble(structure.theta()).unwrap().stiffness
    };
    let mut n = 0;
    for c in found.iter().filter(|c| c.effect.name().ends_with("stiffness-change")) {
        let id = c.id();
        let ([whole, ..], size) = matrices(&one, &id).unwrap();
        let [first, last] = c.location.names[0].split_once("..").map(<[&str; 2]>::from).unwrap();
        let number = |name: &str| name.trim_start_matches("b.").parse::<usize>().unwrap();
        let each = (number(first)..=number(last)).map(|k| {
            let ([alone, ..], its) = matrices(&one, &id.replace(&c.location.names[0], &format!("b.{k}"))).unwrap();
            assert_eq!(its, size, "{id}");
            alone - &neutral
        });
        let sum = each.fold(neutral.clone(), |sum, one| sum + one);
        assert!((&whole - sum).abs().max() <= 1e-12 * whole.abs().max(), "{id}");
        n += 1;
    }
    assert!(n >= 30, "{n}");
}

/// A run of any length is a place by its name, and runs of several lengths are looked for about one that is known.
#[test]
fn a_run_of_any_length_is_a_place() {
    let (text, context) = (in_one(), Context::default());
    let model = model(&text);
    let structure = Structure::new(&model, &context);
    let run = Effects::builtin().candidate(&structure, "stiffness-change@b.1..b.5").unwrap();
    assert_eq!(structure.elements_of(&run.location.names[0]).len(), 5);
    assert!(Effects::builtin().candidate(&structure, "stiffness-change@b.5..b.1").is_err());
    let about = structure.finer(&structure.part("b.2..b.5").map(|_| run.location.clone()).unwrap(), 1);
    assert!(about.contains(&"b.2..b.6".to_string()) && !about.iter().any(|n| n == "b.1..b.5"), "{about:?}");
    // Six are the whole beam, and four a span of every search.
    assert!(!about.iter().any(|n| n == "b.1..b.6" || n == "b.2..b.5"), "{about:?}");
}

/// An end that gives about both axes of bending is that which gives about one, and then about the other.
#[test]
fn an_end_gives_about_both_axes() {
    let clamped = in_one().replace("fixed: [ux, uy, uz, rx]", "fixed: [ux, uy, uz, rx, ry, rz]");
    let id = "root-flexibility@b.1:n0.bending";
    let ([both, ..], sizes) = matrices(&clamped, id).unwrap();
    assert_eq!(sizes.len(), 2);
    let one = model(&clamped);
    let context = Context::default();
    let structure = Structure::new(&one, &context);
    let about = |text: &str, dof: &str| {
        let (model, context) = (model(text), Context::default());
        let candidate =
            Effects::builtin().candidate(&Structure::new(&model, &context), &format!("root-flexibility@b.1:n0.{dof}"));
        candidate.unwrap().build(&model, &Registry::builtin()).unwrap()
    };
    let first = about(&clamped, "ry");
    let spec = first.model.spec().clone();
    let again = {
        let (model, context) = (Model::new(spec, &Registry::builtin()).unwrap().0, Context::default());
        let structure = Structure::new(&model, &context);
        let candidate = Effects::builtin().candidate(&structure, "root-flexibility@b.1:n0.rz").unwrap();
        candidate.build(&model, &Registry::builtin()).unwrap()
    };
    let theta = [structure.theta(), &sizes].concat();
    let expected = again.model.assemble(&theta).unwrap().stiffness;
    assert!((&both - &expected).abs().max() <= 1e-12 * expected.abs().max());
    let rigid = one.assemble(structure.theta()).unwrap().stiffness;
    assert!((&both - rigid).abs().max() > 1e-6 * expected.abs().max(), "it gives");
}

/// A body that lacks moments of inertia about several axes is one that lacks the first, then the next; springs along several axes alike.
#[test]
fn a_node_has_several_axes() {
    let text = in_one();
    let bare = model(&text);
    let context = Context::default();
    let system = bare.assemble(Structure::new(&bare, &context).theta()).unwrap();
    let cases = [
        ("ground-spring", ["ux", "uy", "uz"], 0, &system.stiffness),
        ("point-rotary-inertia", ["rx", "ry", "rz"], 1, &system.mass),
    ];
    for (effect, axes, which, neutral) in cases {
        let (all, sizes) = matrices(&text, &format!("{effect}@n3.all_axes")).unwrap();
        assert_eq!(sizes.len(), 3, "{effect}");
        let sum = axes.iter().zip(&sizes).fold(neutral.clone(), |sum, (axis, size)| {
            let (one, its) = matrices(&text, &format!("{effect}@n3.{axis}")).unwrap();
            assert_eq!(its, [*size], "{effect} {axis}");
            assert!((&one[which] - neutral).abs().max() > 0.0, "{effect} {axis} does something");
            sum + &one[which] - neutral
        });
        assert!((&all[which] - &sum).abs().max() <= 1e-12 * sum.abs().max(), "{effect}");
    }
}

#[test]
fn a_line_with_a_name_is_called_by_it() {
    let named = in_pieces("groups: {spar: [r, s, q, p], half: [q, r], loose: [p, s]}");
    assert_eq!(lines(&named), [""; 0]);
    let (model, context) = (model(&named), Context::default());
    let structure = Structure::new(&model, &context);
    let member = |name: &str| structure.part(name).unwrap().is_member;
    assert!(member("spar") && member("half") && !member("loose"));
    assert!(Effects::builtin().candidate(&structure, "axial-preload@spar").is_ok());
    assert!(Effects::builtin().candidate(&structure, "axial-preload@loose").is_err());
    assert!(Effects::builtin().candidate(&structure, "taper@spar.ry").is_ok());
}

#[test]
fn a_line_ends_at_corners_branches_clamps_and_rigid_bodies() {
    let with = |more: &str| {
        format!(
            "retune: 1\nname: test\nnodes: {{a: [0, 0, 0], b: [1, 0, 0], c: [2, 0.2, 0], d: [2, 1, 0], e: [1, 0, 1]}}\nbeams:\n  \
             ab: {{nodes: [a, b], {PROPERTIES}}}\n  bc: {{nodes: [b, c], {PROPERTIES}}}\n  cd: {{nodes: [c, d], {PROPERTIES}}}\n{more}"
        )
    };
    assert_eq!(lines(&with("supports: {a: {node: a}}")), ["ab..bc"]);
    assert_eq!(lines(&with("supports: {b: {node: b}}")), [""; 0]);
    let branch = format!("  be: {{nodes: [b, e], {PROPERTIES}}}\nsupports: {{a: {{node: a}}}}");
    assert_eq!(lines(&with(&branch)), [""; 0]);
    let link = format!(
        "  ed: {{nodes: [e, d], {PROPERTIES}}}\nrigid_links: {{b: {{master: b, slaves: [e]}}}}\nsupports: {{a: {{node: a}}}}"
    );
    assert_eq!(lines(&with(&link)), [""; 0]);
}

#[test]
fn two_sides_that_meet_are_a_pair_and_no_line() {
    let text = format!(
        "retune: 1\nname: test\nsymmetry: {{normal: y}}\nnodes: {{l: [0, 1, 0], c: [0, 0, 0], r: [0, -1, 0]}}\nbeams:\n  \
         left: {{nodes: [c, l], {PROPERTIES}}}\n  right: {{nodes: [c, r], {PROPERTIES}}}\n"
    );
    assert_eq!(lines(&text), [""; 0]);
}

/// A portal whose columns are held at mid-height, and its lintel; a column buckles between storeys, what has a free end as a cantilever.
#[test]
fn what_holds_a_member_bounds_its_compression() {
    let text = format!(
        "retune: 1\nname: test\nnodes: {{a0: [0, 0, 0], a1: [0, 0, 1], a2: [0, 0, 4], b0: [2, 0, 0], b1: [2, 0, 1], b2: [2, 0, 4], c: [0, 0, 5]}}\nbeams:\n  \
         left: {{chain: [a0, a1, a2], subdivide: 2, {PROPERTIES}}}\n  right: {{chain: [b0, b1, b2], {PROPERTIES}}}\n  lintel: {{nodes: [a1, b1], {PROPERTIES}}}\n  \
         roof: {{nodes: [a2, b2], {PROPERTIES}}}\n  mast: {{nodes: [a2, c], subdivide: 3, {PROPERTIES}}}\n\
         supports: {{a: {{node: a0}}, b: {{node: b0}}}}\n"
    );
    let (model, context) = (model(&text), Context::default());
    let structure = Structure::new(&model, &context);
    let bounds = |place: &str| {
        let id = format!("axial-preload@{place}");
        Effects::builtin().candidate(&structure, &id).unwrap().parameters[0].bounds
    };
    let euler = |length: f64| std::f64::consts::PI.powi(2) * 10.0 / (length * length);
    for (place, least) in [("left", -4.0 * euler(3.0)), ("lintel", -4.0 * euler(2.0)), ("mast", -0.25 * euler(1.0))] {
        let lower = bounds(place)[0];
        assert!((lower / least - 1.0).abs() < 0.01, "{place}: {lower} against {least}");
    }
}

/// Of a long member halves and quarters are places beside runs of a few elements.
#[test]
fn a_long_member_has_halves_and_quarters() {
    let nodes: Vec<String> = (0..=24).map(|i| format!("n{i}: [{} m, 0, 0]", f64::from(i) / 24.0)).collect();
    let chain: Vec<String> = (0..=24).map(|i| format!("n{i}")).collect();
    let text = format!(
        "retune: 1\nname: test\nnodes: {{{}}}\nbeams: {{b: {{chain: [{}], {PROPERTIES}}}}}\nsupports: {{a: {{node: n0}}}}\n",
        nodes.join(", "),
        chain.join(", ")
    );
    let (model, context) = (model(&text), Context::default());
    let structure = Structure::new(&model, &context);
    let names: Vec<&str> = structure.spans().iter().map(|s| s.name.as_str()).collect();
    for name in ["b.1..b.12", "b.13..b.24", "b.1..b.6", "b.7..b.12", "b.13..b.18", "b.19..b.24", "b.5..b.8"] {
        assert!(names.contains(&name), "{name}: {names:?}");
    }
    assert_eq!(names.len(), 23 + 22 + 21 + 2 + 4);
}

/// Two masses at the ends of a free beam of two members: without one of them the beam falls apart.
#[test]
fn a_mass_holds_nothing() {
    let text = format!(
        "retune: 1\nname: test\nnodes: {{a: [0, 0, 0], b: [1, 0, 0], c: [1, 1, 0]}}\nbeams:\n  p: {{nodes: [a, b], {PROPERTIES}}}\n  \
         q: {{nodes: [b, c], {PROPERTIES}}}\nmasses: {{m: {{node: a, mass: 1 kg}}, n: {{node: c, mass: 2 kg}}}}\n"
    );
    let context = Context::default();
    let all = candidates(&model(&text), &Effects::builtin(), &context);
    let absent: Vec<String> = all.iter().filter(|c| c.effect.name() == "absent-member").map(Candidate::id).collect();
    assert!(absent.is_empty() && !all.is_empty(), "{absent:?}");
}
