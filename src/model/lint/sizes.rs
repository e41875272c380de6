//! Sizes that do not fit the rest of a structure: most are a unit that is missing or wrong.

use super::list;
use crate::element::Axes;
use crate::model::compile::Model;
use crate::model::dependence::interior_point;
use crate::model::geometry::extent;
use crate::model::value::quantity;
use crate::model::{ParametricModel, PlacedElement};
use crate::yaml::{Problem, child};
use std::collections::HashMap;

/// How many times farther than the others, from the middle of all, some nodes lie that are worth a remark: those that a member reaches
/// which is [`SLENDER`], and those that no member of known depth reaches.
const FAR_AND_SLENDER: f64 = 10.0;
const FAR: f64 = 100.0;
/// Length over depth that no single member has.
const SLENDER: f64 = 1_000.0;
/// Length over depth that no structure has.
const TOO_SLENDER: f64 = 1e4;
/// Below this part of what a disc of the same area has, Iy + Iz belong to another area.
const TOO_COMPACT: f64 = 0.1;
/// Depths and offsets beyond this part of the structure's size belong to another one.
const TOO_DEEP: f64 = 5.0;

/// All of them.
pub(super) fn sizes(model: &Model) -> Vec<Problem> {
    let mut out: Vec<Problem> = whole(model).into_iter().collect();
    let far = outlying(model);
    // Nodes that lie far off make any section look thin.
    if far.is_none() {
        out.extend(depths(model));
    }
    out.extend(far);
    out.extend(areas(model));
    out.extend(offsets(model));
    out
}

fn whole(model: &Model) -> Option<Problem> {
    let size = model.geometry().size();
    let is_odd = size > 1000.0 || (size > 0.0 && size < 1e-3);
    is_odd.then(|| {
        Problem::warning(
            "nodes",
            format_args!("the structure is {} long: are the nodes in metres?", quantity(size, "m")),
        )
    })
}

/// A few nodes that lie many times farther out than the others.
fn outlying(model: &Model) -> Option<Problem> {
    let geometry = model.geometry();
    // Inner nodes of subdivided members stand behind those of the file.
    let n = model.spec().nodes.len();
    let positions = &geometry.positions[..n];
    if n < 3 {
        return None;
    }
    let middle: [f64; 3] = std::array::from_fn(|axis| {
        let mut all: Vec<f64> = positions.iter().map(|p| p[axis]).collect();
        all.sort_by(f64::total_cmp);
        all[n / 2]
    });
    let off = |i: usize| (0..3).map(|axis| (positions[i][axis] - middle[axis]).abs()).fold(0.0, f64::max);
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| off(a).total_cmp(&off(b)).then(a.cmp(&b)));
    let ratio = |k: usize| off(order[k]) / off(order[k - 1]);
    let gap = (n.div_ceil(2).max(2)..n).filter(|&k| off(order[k - 1]) > 0.0);
    let gap = gap.max_by(|&a, &b| ratio(a).total_cmp(&ratio(b)))?;
    let (near, far) = order.split_at(gap);
    let mut is_far = vec![false; n];
    for &i in far {
        is_far[i] = true;
    }
    if ratio(gap) < FAR_AND_SLENDER {
        return None;
    }
    let reaching = members(model).into_values().filter(|m| m.touches(&is_far)).map(|m| m.slenderness);
    let is_odd = reaching.reduce(f64::max).map_or(ratio(gap) >= FAR, |slenderness| slenderness > SLENDER);
    if !is_odd {
        return None;
    }
    let near: Vec<[f64; 3]> = near.iter().map(|&i| positions[i]).collect();
    let mut far = far.to_vec();
    far.sort_unstable();
    let names: Vec<String> = far.iter().map(|&i| geometry.names[i].clone()).collect();
    let verb = if names.len() == 1 { "lies" } else { "lie" };
    Some(Problem::warning(
        child("nodes", &names[0]),
        format_args!(
            "{} {verb} {} m away from the others, which lie within {} m: is a unit missing or wrong, as in `600` for `600 mm`?",
            list(&names),
            short(off(order[gap])),
            short(extent(&near))
        ),
    ))
}

/// A member between two nodes of the file.
struct Member {
    nodes: Vec<usize>,
    /// Length over depth.
    slenderness: f64,
}

impl Member {
    /// Whether it goes from the nodes marked to the others.
    fn touches(&self, marked: &[bool]) -> bool {
        let of_file = || self.nodes.iter().filter_map(|&n| marked.get(n));
        of_file().any(|m| *m) && of_file().any(|m| !*m)
    }
}

/// Members by name: the parts of a subdivided one together.
fn members(model: &Model) -> HashMap<&str, Member> {
    let theta = interior_point(model.parameters());
    let mut all: HashMap<&str, Member> = HashMap::new();
    for e in model.elements() {
        let Some([depth, _]) = depth(e, &theta) else { continue };
        let name = e.name.split_once('/').map_or(e.name.as_str(), |(whole, _)| whole);
        let member = all.entry(name).or_insert(Member { nodes: Vec::new(), slenderness: 0.0 });
        member.nodes.extend(&e.nodes);
        member.slenderness += e.points.get(1).map_or(0.0, |p| p[0].hypot(p[1]).hypot(p[2])) / depth;
    }
    all
}

/// A property of an element where it has one above zero.
fn property(e: &PlacedElement, theta: &[f64], name: &str) -> Option<f64> {
    let i = e.kind.properties().iter().position(|p| p.name == name)?;
    e.values[i].as_ref().map(|v| v.at(theta)).filter(|v| *v > 0.0)
}

/// Smaller and larger depth of a solid section of the same area and second moments: √(12 I/A).
fn depth(e: &PlacedElement, theta: &[f64]) -> Option<[f64; 2]> {
    let get = |name: &str| property(e, theta, name);
    let of = |moment: &str, area: &str| Some((12.0 * get(moment)? / get(area)?).sqrt());
    let both = [of("Iy", "A").or_else(|| of("EIy", "EA")), of("Iz", "A").or_else(|| of("EIz", "EA"))];
    let known: Vec<f64> = both.into_iter().flatten().collect();
    let least = known.iter().copied().reduce(f64::min)?;
    Some([least, known.iter().copied().fold(least, f64::max)])
}

/// Sections that are far too thin or far too deep for the structure.
fn depths(model: &Model) -> Vec<Problem> {
    let theta = interior_point(model.parameters());
    let size = model.geometry().size();
    if size <= 0.0 {
        return Vec::new();
    }
    let known: Vec<(&PlacedElement, [f64; 2])> =
        model.elements().iter().filter_map(|e| depth(e, &theta).map(|d| (e, d))).collect();
    let mut out = Vec::new();
    let deepest = known.iter().map(|(_, d)| d[1]).fold(0.0, f64::max);
    if deepest > 0.0 && size > TOO_SLENDER * deepest {
        out.push(Problem::warning(
            "nodes",
            format_args!(
                "the structure spans {} m, {} times the depth of its deepest section ({} m): are nodes and sections in the same unit? A number without a unit is in metres",
                short(size),
                grouped(size / deepest),
                short(deepest)
            ),
        ));
    }
    let mut said: Vec<String> = Vec::new();
    for (e, [_, depth]) in known {
        let path = e.section.as_ref().map_or(e.path.clone(), |n| child("sections", n));
        if depth > TOO_DEEP * size && !said.contains(&path) {
            out.push(Problem::warning(
                &path,
                format_args!(
                    "this section is as deep as {} m, and the whole structure is {} m long: is a unit missing or wrong?",
                    short(depth),
                    short(size)
                ),
            ));
            said.push(path);
        }
    }
    out
}

/// Areas that are too large for the second moments beside them: of all shapes of one area a disc has the least Iy + Iz, A²/2π.
fn areas(model: &Model) -> Vec<Problem> {
    let theta = interior_point(model.parameters());
    let mut out: Vec<Problem> = Vec::new();
    for e in model.elements() {
        let get = |name: &str| property(e, &theta, name);
        let (Some(area), Some(iy), Some(iz)) = (get("A"), get("Iy"), get("Iz")) else { continue };
        let least = area * area / (2.0 * std::f64::consts::PI);
        let path = child(&e.section.as_ref().map_or(e.path.clone(), |n| child("sections", n)), "A");
        if iy + iz < TOO_COMPACT * least && !out.iter().any(|p| p.path == path) {
            out.push(Problem::warning(
                &path,
                format_args!(
                    "Iy + Iz is {:.3e} m4, and a section of {} m2 has at least A^2/2pi = {least:.3e} m4: is a unit missing or wrong, as in `28` for `28 cm2`?",
                    iy + iz,
                    short(area),
                ),
            ));
        }
    }
    out
}

/// Offsets of masses and of section axes that leave the structure.
fn offsets(model: &Model) -> Vec<Problem> {
    const OFFSETS: [&str; 7] =
        ["offset_x", "offset_y", "offset_z", "mass_offset_y", "mass_offset_z", "shear_centre_y", "shear_centre_z"];
    let theta = interior_point(model.parameters());
    let size = model.geometry().size();
    let mut out: Vec<Problem> = Vec::new();
    for e in model.elements().iter().filter(|_| size > 0.0) {
        for (property, value) in e.kind.properties().iter().zip(e.values.iter()) {
            let Some(value) = value.as_ref().map(|v| v.at(&theta)) else { continue };
            if !OFFSETS.contains(&property.name) || value.abs() <= TOO_DEEP * size {
                continue;
            }
            let owner = e.section.as_ref().filter(|_| e.kind.axes() == Axes::AlongNodes);
            let path = owner.map_or(e.path.clone(), |n| child("sections", n));
            let path = child(&path, &property.name.replacen("offset_", "offset.", usize::from(owner.is_none())));
            if !out.iter().any(|p| p.path == path) {
                out.push(Problem::warning(
                    path,
                    format_args!(
                        "`{}` of `{}` is {} m, and the whole structure is {} m long: is a unit missing or wrong?",
                        property.name,
                        e.name,
                        short(value),
                        short(size)
                    ),
                ));
            }
        }
    }
    out
}

/// Three significant digits.
fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".to_string();
    }
    let decimals = (2.0 - value.abs().log10().floor()).clamp(0.0, 12.0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
}

/// `100,000`
fn grouped(value: f64) -> String {
    let digits = format!("{value:.0}");
    let mut out = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(c);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Registry, load};

    fn said(text: &str) -> Vec<String> {
        sizes(&load(text, &Registry::builtin()).unwrap().0)
            .into_iter()
            .map(|p| format!("{}: {}", p.path, p.message))
            .collect()
    }

    /// A metre in five nodes with a tip that the caller places, a section of 10 mm by 50 mm.
    fn cantilever(tip: &str, more: &str) -> String {
        format!(
            "retune: 1\nname: c\nsections:\n  s: {{E: 70 GPa, nu: 0.3, density: 2700 kg/m3, shape: {{rectangle: {{width: 50 mm, height: 10 mm}}}}}}\n\
             nodes: {{a: [0, 0, 0], b: [0.2, 0, 0], c: [0.4, 0, 0], d: [0.5, 0, 0], e: [{tip}, 0, 0]}}\n\
             beams: {{m: {{chain: [a, b, c, d, e], section: s{more}}}}}\nsupports: {{root: {{node: a}}}}\n"
        )
    }

    #[test]
    fn a_size_is_said_without_powers_of_ten() {
        let text = "retune: 1\nname: c\nnodes: {a: [0, 0, 0], b: [5000, 0, 0]}\n\
                    beams: {m: {nodes: [a, b], properties: {EA: 1e6, EIy: 10, EIz: 10, GJ: 10, mass_per_length: 1}}}\nsupports: {r: {node: a}}\n";
        assert!(
            said(text).iter().any(|s| s == "nodes: the structure is 5000 m long: are the nodes in metres?"),
            "{:?}",
            said(text)
        );
    }

    #[test]
    fn a_node_without_its_unit_is_found_and_one_with_it_is_not() {
        for more in ["", ", subdivide: 4"] {
            assert_eq!(said(&cantilever("600 mm", more)), [""; 0]);
            let all = said(&cantilever("600", more));
            assert_eq!(all.len(), 1, "{all:?}");
            assert!(
                all[0].starts_with("nodes.e: `e` lies 600 m away from the others, which lie within 0.5 m"),
                "{all:?}"
            );
        }
        // 20 times as far as the rest, and 2 000 depths long.
        assert_eq!(said(&cantilever("20", "")).len(), 1);
        assert_eq!(said(&cantilever("1.5", "")), [""; 0]);
    }

    /// A nacelle of a metre on a tower of 80 m, two nodes of which are of the tower.
    #[test]
    fn a_tower_below_many_nodes_of_its_head_is_no_mistake() {
        let head: Vec<String> = (0..20).map(|i| format!("h{i}: [{}, 0, 0]", 0.05 * f64::from(i))).collect();
        let chain: Vec<String> = (0..20).map(|i| format!("h{i}")).collect();
        let text = format!(
            "retune: 1\nname: t\nsections:\n  s: {{E: 210 GPa, nu: 0.3, density: 7850 kg/m3, shape: {{tube: {{diameter: 4 m, wall: 30 mm}}}}}}\n\
             nodes: {{{}, base: [0, 0, -80]}}\nbeams: {{head: {{chain: [{}], section: s}}, tower: {{nodes: [base, h0], section: s}}}}\n\
             supports: {{root: {{node: base}}}}\n",
            head.join(", "),
            chain.join(", ")
        );
        assert_eq!(said(&text), [""; 0]);
    }

    #[test]
    fn sections_and_offsets_of_another_unit_are_found() {
        let deep = cantilever("0.6", "").replace("width: 50 mm, height: 10 mm", "width: 50, height: 10");
        assert!(said(&deep)[0].starts_with("sections.s: this section is as deep as 50 m"), "{:?}", said(&deep));
        let off = cantilever("0.6", "") + "masses: {m1: {node: e, mass: 1 kg, offset: [0, 30, 0]}}\n";
        assert!(said(&off)[0].starts_with("masses.m1.offset.y: `offset_y` of `m1` is 30 m"), "{:?}", said(&off));
    }

    #[test]
    fn an_area_without_its_unit_is_found_by_the_second_moments() {
        let text = |area: &str| {
            format!(
                "retune: 1\nname: c\nsections:\n  s: {{E: 210 GPa, nu: 0.3, density: 7850 kg/m3, A: {area}, Iy: 1943 cm4, Iz: 142.4 cm4, J: 6.98 cm4}}\n\
                 nodes: {{a: [0, 0, 0], b: [3, 0, 0]}}\nbeams: {{m: {{nodes: [a, b], section: s, subdivide: 3}}}}\nsupports: {{root: {{node: a}}}}\n"
            )
        };
        assert_eq!(said(&text("28.48 cm2")), Vec::<String>::new());
        let found = said(&text("28.48"));
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].starts_with("sections.s.A: Iy + Iz is 2.085e-5 m4, and a section of 28.5 m2"), "{found:?}");
        assert_eq!(said(&text("28.48 mm2")), Vec::<String>::new(), "thin walls may be anywhere");
    }

    #[test]
    fn a_span_of_thousands_of_depths_is_told() {
        let text = "retune: 1\nname: mixed\nsections:\n  s: {E: 70 GPa, nu: 0.3, density: 2700 kg/m3, shape: {rectangle: {width: 50 mm, height: 10 mm}}}\n\
                    nodes: {a: [0, 0, 0], b: [1000, 0, 0]}\nbeams: {ab: {nodes: [a, b], section: s, subdivide: 8}}\nsupports: {c: {node: a}}\n";
        let all = said(text);
        assert!(all.iter().any(|p| p.contains("20,000 times the depth of its deepest section (0.05 m)")), "{all:?}");
        assert_eq!(said(&text.replace("1000,", "1000 mm,")), [""; 0]);
    }
}
