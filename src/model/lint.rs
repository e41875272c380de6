//! What an engineer would want to be told about a model that can be built.

mod boundary;
mod drilling;
mod idle_links;
mod mesh;
mod sizes;
mod stability;
mod symmetry;

pub use boundary::FreeEdges;

use super::compile::Model;
use super::dependence::interior_point;
use super::geometry::Near;
use super::joined::Joined;
use super::mesh_error::MeshError;
use super::value::quantity;
use super::{ModelError, ParametricModel};
use crate::catalogue::counted;
use crate::element::Dof;
use crate::linalg::sparse::SparseSym;
use crate::modal::{ModalError, SolveOptions};
use crate::units::Unit;
use crate::yaml::{Problem, child};
use std::collections::{HashMap, HashSet};

/// The state of a model at its estimates, for `check`.
#[derive(Debug, Clone)]
pub struct Soundness {
    /// Doubtful things, with their paths.
    pub warnings: Vec<Problem>,
    /// Things that make the model useless, with their paths.
    pub errors: Vec<Problem>,
    /// Number of rigid-body modes.
    pub n_rigid_body_modes: usize,
    /// Number of mechanisms: motions without stiffness that are not rigid-body motions.
    pub n_mechanisms: usize,
    /// How many times its preload the structure bears at the estimates; `None` without a preload, or where it bears any.
    pub buckling_factor: Option<f64>,
    /// Free edges of the shells of each part of a mesh.
    pub free_edges: Vec<FreeEdges>,
    /// What the mesh of shells and solids does to the frequencies of the first modes.
    pub mesh_errors: Vec<MeshError>,
}

/// Modes whose error by the mesh is estimated.
const FIRST_MODES: usize = 6;
/// Moments of inertia are stated to three digits: less of a difference is one of rounding.
const ROUNDED: f64 = 0.01;

/// Looks for mechanisms, empty and massless dofs, dangling and duplicate nodes, bad conditioning, parameters without
/// effect, values that look wrong by powers of ten.
pub fn lint(model: &Model) -> Result<Soundness, ModelError> {
    let mut s = Soundness {
        warnings: Vec::new(),
        errors: Vec::new(),
        n_rigid_body_modes: 0,
        n_mechanisms: 0,
        buckling_factor: None,
        free_edges: Vec::new(),
        mesh_errors: Vec::new(),
    };
    nodes(model, &mut s);
    s.warnings.extend(mesh::mesh(model));
    s.warnings.extend(idle_links::idle_links(model, &interior_point(model.parameters())));
    magnitudes(model, &mut s);
    parameters(model, &mut s)?;
    motion(model, &mut s)?;
    stability::stability(model, &mut s)?;
    s.warnings.extend(symmetry::symmetry(model)?);
    targets(model, &mut s)?;
    Ok(s)
}

/// What makes every result doubtful and shows before anything is solved: sizes that no structure has, parts that hang on nothing.
pub fn doubts(model: &Model) -> Vec<Problem> {
    let warned = apart(model).map(|p| Problem::warning(p.path, p.message));
    sizes::sizes(model).into_iter().chain(warned).collect()
}

fn nodes(model: &Model, s: &mut Soundness) {
    let geometry = model.geometry();
    let spec = model.spec();
    let mut used = vec![false; geometry.names.len()];
    for e in model.elements() {
        e.joined().iter().for_each(|&n| used[n] = true);
    }
    let named = |name: &String| geometry.node(name);
    for link in spec.rigid_links.values() {
        std::iter::once(&link.master).chain(&link.slaves).filter_map(named).for_each(|n| used[n] = true);
    }
    for link in spec.weighted_links.values() {
        link.nodes().filter_map(named).for_each(|n| used[n] = true);
    }
    spec.ties.values().flat_map(|t| &t.nodes).filter_map(named).for_each(|n| used[n] = true);
    for c in spec.constraints.values() {
        c.terms.iter().filter_map(|t| named(&t.node)).for_each(|n| used[n] = true);
    }
    // Points that a superelement recovers follow from its dofs.
    let follows =
        |i: usize| i >= spec.nodes.len() && Dof::ALL.iter().any(|d| !model.dof_map().express(i, *d).is_empty());
    for (i, name) in geometry.names.iter().enumerate() {
        if !used[i] && !follows(i) && !mesh::is_of_mesh(model, i) {
            s.warnings.push(Problem::warning(
                child("nodes", name),
                format_args!("node `{name}` is used by no element and no link"),
            ));
        }
    }
    let mut joined: HashSet<[usize; 2]> = HashSet::new();
    model.elements().iter().filter(|e| e.nodes.len() > 1).for_each(|e| {
        joined.extend([[e.nodes[0], e.nodes[1]], [e.nodes[1], e.nodes[0]]]);
    });
    let mut links_of: HashMap<usize, Vec<usize>> = HashMap::new();
    for (i, link) in spec.rigid_links.values().enumerate() {
        let all = std::iter::once(&link.master).chain(&link.slaves).filter_map(named);
        all.for_each(|n| links_of.entry(n).or_default().push(i));
    }
    let none = Vec::new();
    let links = |n: usize| links_of.get(&n).unwrap_or(&none);
    let is_held = |n: usize| Dof::ALL.into_iter().all(|dof| model.dof_map().express(n, dof).is_empty());
    let are_coordinates = |a: usize, b: usize| geometry.is_coordinate(a) || geometry.is_coordinate(b);
    let tied: HashMap<usize, Vec<usize>> = {
        let nodes = spec.ties.values().flat_map(|t| &t.nodes).filter_map(named);
        nodes.map(|n| (n, model.dof_map().led_by(n))).collect()
    };
    let follows = |a: usize, b: usize| tied.get(&a).is_some_and(|led| led.contains(&b));
    let are_joined = |a: usize, b: usize| {
        let by_link = links(a).iter().any(|l| links(b).contains(l));
        let are_led = follows(a, b) || follows(b, a);
        are_coordinates(a, b) || joined.contains(&[a, b]) || by_link || are_led || is_held(a) && is_held(b)
    };
    let near = 1e-6 * geometry.size();
    let grid = Near::new(&geometry.positions, near);
    let mut of_mesh = Vec::new();
    for second in 0..geometry.names.len() {
        let beside = grid.within(geometry.positions[second], near);
        let first = beside.into_iter().take_while(|&first| first < second).find(|&first| !are_joined(first, second));
        if let Some(first) = first.filter(|_| mesh::is_of_mesh(model, second)) {
            of_mesh.push([first, second]);
        } else if let Some(first) = first {
            s.warnings.push(Problem::warning(
                child("nodes", &geometry.names[second]),
                format_args!(
                    "nodes `{}` and `{}` are at the same place and nothing joins them",
                    geometry.names[first], geometry.names[second]
                ),
            ));
        }
    }
    let boundary = boundary::boundary(model, &of_mesh);
    of_mesh.retain(|pair| !pair.iter().all(|n| boundary.told.contains(n)));
    s.free_edges = boundary.free;
    s.warnings.extend(boundary.problems);
    s.warnings.extend(mesh::at_one_place(model, &of_mesh));
}

/// Properties far outside what structures are made of. The ranges are wide: from soft foam to diamond, from balsa to osmium.
fn magnitudes(model: &Model, s: &mut Soundness) {
    const RANGES: &[(&str, &str, f64, f64)] =
        &[("E", "Pa", 1e6, 1.3e12), ("G", "Pa", 1e5, 6e11), ("density", "kg/m3", 20.0, 23_000.0)];
    let theta = interior_point(model.parameters());
    let mut seen: Vec<(String, &str)> = Vec::new();
    for e in model.elements() {
        let path = e.section.as_ref().map_or(e.path.clone(), |n| child("sections", n));
        let mut values = Vec::new();
        for (property, value) in e.kind.properties().iter().zip(e.values.iter()) {
            let Some(value) = value.as_ref().map(|v| v.at(&theta)) else { continue };
            values.push((property.name, value));
            for &(name, unit, low, high) in RANGES {
                let key = (path.clone(), name);
                if property.name == name && value != 0.0 && !(low..=high).contains(&value) && !seen.contains(&key) {
                    s.warnings.push(Problem::warning(
                        child(&path, name),
                        format_args!("`{name}` is {}; no structural material is below {low:.0e} or above {high:.0e} {unit}: is the unit right?", quantity(value, unit)),
                    ));
                    seen.push(key);
                }
            }
        }
        let get = |name: &str| values.iter().find(|v| v.0 == name).map(|v| v.1);
        if let (Some(xx), Some(yy), Some(zz)) = (get("inertia_xx"), get("inertia_yy"), get("inertia_zz")) {
            // ∫ (y² + z²) + ∫ (x² + z²) is never below ∫ (x² + y²); equal for a plane body.
            for (name, one, sum) in [("xx", xx, yy + zz), ("yy", yy, xx + zz), ("zz", zz, xx + yy)] {
                if one > sum * (1.0 + ROUNDED) {
                    s.warnings.push(Problem::warning(
                        format!("{path}.inertia.{name}"),
                        format_args!(
                            "the inertia {name} of `{}` is {}, more than the sum {} of the other two: no body has that",
                            e.name,
                            quantity(one, "kg m2"),
                            quantity(sum, "kg m2")
                        ),
                    ));
                }
            }
        }
        if let (Some(e), Some(g)) = (get("E"), get("G")) {
            let key = (path.clone(), "E/G");
            // Isotropic: E/G = 2(1+ν) is 2 to 3. Composites and effective values reach 100 and more: only a note.
            if !seen.contains(&key) && (e / g > 100.0 || e / g < 0.5) {
                let ratio = if e / g < 0.1 { format!("{:.1e}", e / g) } else { format!("{:.3}", e / g) };
                s.warnings.push(Problem::warning(
                    child(&path, "G"),
                    format_args!("E/G is {ratio}; an isotropic material has 2 to 3 (an effective G on a polar moment J explains a large ratio)"),
                ));
                seen.push(key);
            }
        }
    }
    s.warnings.extend(sizes::sizes(model));
    for p in model.parameters().iter() {
        if let Some([lower, upper]) = p.bounds
            && lower > 0.0
            && upper / lower > 1e4
        {
            s.warnings.push(Problem::warning(
                format!("parameters.{}.bounds", p.name),
                format_args!("the bounds span a factor of {:.0e}: is a unit missing on one of them?", upper / lower),
            ));
        }
        if !p.unit.is_empty() && Unit::parse(&p.unit).is_err() {
            s.warnings.push(Problem::warning(format!("parameters.{}.unit", p.name), "it cannot be read"));
        }
    }
}

fn parameters(model: &Model, s: &mut Soundness) -> Result<(), ModelError> {
    let theta = interior_point(model.parameters());
    let damps_modes = |j: usize| model.modal_damping().is_some_and(|zeta| zeta.slope(j) != 0.0);
    for j in model.parameters().free().into_iter().filter(|&j| !damps_modes(j)) {
        let d = model.assemble_sparse_derivative(&theta, j)?;
        let matrices = [Some(d.stiffness), Some(d.mass), d.damping];
        let zero = matrices.iter().flatten().all(|a| a.entries().all(|e| e.2 == 0.0));
        if zero {
            let p = model.parameters().get(j);
            let named = model.elements().iter().any(|e| e.depends_on(j));
            let why = if named { "what it acts on is supported, rigid or inactive" } else { "no property names it" };
            s.warnings.push(Problem::warning(
                format!("parameters.{}", p.name),
                format_args!("`{}` changes nothing: {why}", p.name),
            ));
        }
    }
    Ok(())
}

fn motion(model: &Model, s: &mut Soundness) -> Result<(), ModelError> {
    let theta = interior_point(model.parameters());
    let dofs = model.dof_map();
    let n = dofs.n_dof();
    if n == 0 {
        return Ok(());
    }
    let system = model.assemble_sparse(&theta)?;
    let diagonal = |a: &SparseSym| (0..n).map(|i| a.diagonal(i)).collect::<Vec<f64>>();
    let (k, m) = (&diagonal(&system.stiffness), &diagonal(&system.mass));
    let stiffest = (0..n).map(|i| k[i]).fold(0.0, f64::max);
    let empty: Vec<usize> = (0..n).filter(|&i| m[i] <= 0.0 && k[i] <= 1e-14 * stiffest).collect();
    for &row in &empty {
        s.errors.push(Problem::error(row_path(model, row), format_args!("`{}` has neither stiffness nor mass, so nothing determines its motion; support it, or leave that dof out of `active_dofs`", dofs.row_name(row))));
    }
    let of_shells = mesh::nodes_of_shells(model);
    // No mass belongs to the turning of a shell about its normal, nor to any where its mass is lumped.
    let by_design = |i: usize| dofs.rows()[i].1.is_rotation() && of_shells.contains(&dofs.rows()[i].0);
    let massless: Vec<String> =
        (0..n).filter(|&i| m[i] <= 0.0 && !empty.contains(&i) && !by_design(i)).map(|i| dofs.row_name(i)).collect();
    if !massless.is_empty() {
        let verbs = if massless.len() == 1 { "has no mass; it is" } else { "have no mass; they are" };
        s.warnings.push(Problem::warning(
            "",
            format_args!("{} {verbs} condensed exactly: {}", counted(massless.len(), "dof"), list(&massless)),
        ));
    }
    if !empty.is_empty() {
        return Ok(());
    }
    let c = system.damping.as_ref().map_or_else(Vec::new, diagonal);
    for (name, diagonal) in [("stiffness", k), ("mass", m), ("damping", &c)] {
        if let Some(row) = diagonal.iter().position(|v| *v < 0.0) {
            s.errors.push(Problem::error(
                row_path(model, row),
                format_args!("the {name} of `{}` is negative", dofs.row_name(row)),
            ));
            return Ok(());
        }
    }
    conditioning(model, k, s);
    let apart = apart(model);
    match super::solve_modes(model, &theta, SolveOptions { n_elastic: 12, shift: None }) {
        Ok(modes) => {
            s.n_rigid_body_modes = modes.n_rigid;
            s.n_mechanisms = modes.n_mechanism;
            let first: Vec<usize> = modes.elastic().skip(modes.n_mechanism).take(FIRST_MODES).collect();
            s.mesh_errors = model.mesh_errors(&theta, &modes, &first)?;
            s.warnings.extend(mesh::coarse(model, &modes, &s.mesh_errors));
            s.warnings.extend(drilling::drilling(model, &theta, &system, &modes));
            s.warnings.extend(lost_digits(modes.elastic().map(|r| modes.lambda[r]).next(), k, m));
            // What moves without stiffness is the part that hangs on nothing.
            if let Some(apart) = apart {
                s.errors.push(apart);
                return Ok(());
            }
            for i in 0..modes.n_mechanism {
                let shape = modes.shapes.column(modes.n_rigid + i);
                let mut order: Vec<usize> = (0..n).collect();
                order.sort_by(|&a, &b| shape[b].abs().total_cmp(&shape[a].abs()).then(a.cmp(&b)));
                let names: Vec<String> = order.iter().take(3).map(|&r| dofs.row_name(r)).collect();
                s.warnings.push(Problem::warning(
                    row_path(model, order[0]),
                    format_args!("a mechanism: the structure can move without stiffness, mostly in {}; a member, a stiffness or a support is missing there", list(&names)),
                ));
            }
            if !model.spec().supports.is_empty() && modes.n_rigid > 0 {
                // How much a row moves in all of them together: the same for any basis of these motions. What differs by
                // rounding counts as equal.
                let motion: Vec<f64> =
                    (0..n).map(|row| modes.shapes.row(row).columns(0, modes.n_rigid).norm_squared()).collect();
                let largest = motion.iter().copied().fold(0.0, f64::max);
                let rank = |row: usize| (1e6 * motion[row] / largest).round();
                let mut order: Vec<usize> = (0..n).collect();
                order.sort_by(|&a, &b| rank(b).total_cmp(&rank(a)).then(a.cmp(&b)));
                let names: Vec<String> = order.iter().take(3).map(|&r| dofs.row_name(r)).collect();
                s.warnings.push(Problem::warning(
                    row_path(model, order[0]),
                    format_args!(
                        "the structure is supported and still has {} without stiffness, mostly in {}",
                        counted(modes.n_rigid, "motion"),
                        list(&names)
                    ),
                ));
            }
            let possible = possible_rigid_modes(model);
            if model.spec().supports.is_empty() && modes.n_rigid > possible {
                s.warnings.push(Problem::warning(
                    "",
                    format_args!("{} rigid-body modes; a free structure with these dofs has {possible}", modes.n_rigid),
                ));
            }
        }
        Err(ModelError::Modal(ModalError::Linalg(crate::linalg::LinalgError::NotPositiveDefinite { row, .. }))) => {
            s.errors.push(Problem::error(row_path(model, row), format_args!("the motion of `{}` is not determined: it, or a combination of dofs with it, has neither stiffness nor mass", dofs.row_name(row))));
        }
        Err(e @ ModelError::Buckled(..)) => {
            let place = if let ModelError::Buckled(c, _) = &e { child(&c.path, c.property) } else { String::new() };
            s.errors.push(Problem::error(place, e));
        }
        // Bodies that fly alone look like rounding to a solver that expects one.
        Err(e) => s.errors.push(apart.unwrap_or_else(|| Problem::error("", e))),
    }
    Ok(())
}

/// Parts that nothing joins to the rest.
fn apart(model: &Model) -> Option<Problem> {
    let bodies = Joined::new(model, &[]).apart();
    let first = *bodies.first()?.first()?;
    let names: Vec<String> = bodies.concat().iter().map(|&n| model.geometry().names[n].clone()).collect();
    let what = if bodies.len() == 1 { "a part hangs".to_string() } else { format!("{} parts hang", bodies.len()) };
    Some(Problem::error(
        child("nodes", &model.geometry().names[first]),
        format_args!("{what} on nothing: no element, rigid link or support joins {} to the rest", list(&names)),
    ))
}

fn possible_rigid_modes(model: &Model) -> usize {
    let mut active = [false; 6];
    for &(_, dof) in model.dof_map().rows().iter().filter(|(node, _)| !model.dof_map().is_coordinate(*node)) {
        active[dof as usize] = true;
    }
    // Rotations follow from displacements across the axis where rotations are not dofs themselves.
    let rotation = |d: usize| active[3 + d] || (active[(d + 1) % 3] && active[(d + 2) % 3]);
    (0..3).filter(|d| active[*d]).count() + (0..3).filter(|d| rotation(*d)).count()
}

/// Stiffness ratios that cost digits: with 16 digits, a ratio of 1e12 leaves 4 in the low modes.
fn conditioning(model: &Model, k: &[f64], s: &mut Soundness) {
    let dofs = model.dof_map();
    for rotation in [false, true] {
        let mut rows: Vec<usize> =
            (0..k.len()).filter(|&i| dofs.rows()[i].1.is_rotation() == rotation && k[i] > 0.0).collect();
        rows.sort_by(|&a, &b| k[a].total_cmp(&k[b]));
        let (Some(&soft), Some(&stiff)) = (rows.first(), rows.last()) else { continue };
        let ratio = k[stiff] / k[soft];
        if ratio > 1e9 {
            s.warnings.push(Problem::warning(
                row_path(model, stiff),
                format_args!("`{}` is {ratio:.0e} times stiffer than `{}`: the low modes lose digits; make very stiff parts `rigid_links`", dofs.row_name(stiff), dofs.row_name(soft)),
            ));
        }
    }
}

/// Digits that are lost between the ends of a spectrum: a frequency is known to ε (f_high/f_low)²/2 of itself at best, at the low end as at the
/// high one, where the two are found from one factorisation.
///
/// * `lowest` - λ of the first elastic mode
fn lost_digits(lowest: Option<f64>, k: &[f64], m: &[f64]) -> Option<Problem> {
    /// Relative error that no test would see.
    const UNSEEN: f64 = 1e-5;
    let lowest = lowest.filter(|l| *l > 0.0)?;
    // Rayleigh's quotient of one dof is below the highest λ.
    // What is left of zero by rounding is not a mass.
    let least = 1e-15 * m.iter().copied().fold(0.0, f64::max);
    let highest = k.iter().zip(m).filter(|(_, m)| **m > least).map(|(k, m)| k / m).fold(0.0, f64::max);
    let error = 0.5 * f64::EPSILON * highest / lowest;
    let hz = |lambda: f64| quantity(lambda.sqrt() / std::f64::consts::TAU, "Hz");
    let wrong = if error < 0.1 {
        format!("may be wrong by {error:.0e} of themselves")
    } else {
        "may be nothing but rounding".into()
    };
    (error > UNSEEN).then(|| {
        Problem::warning(
            "",
            format_args!(
                "the modes lie between {} and {} or more, so far apart that frequencies {wrong}; make very stiff parts \
                 `rigid_links`, or give light ones their mass",
                hz(lowest),
                hz(highest)
            ),
        )
    })
}

fn targets(model: &Model, s: &mut Soundness) -> Result<(), ModelError> {
    let theta = model.parameters().nominal();
    let Some(p) = model.mass_properties(&theta)? else { return Ok(()) };
    let t = model.targets();
    let mut check = |path: String, unit: &str, value: f64, target: Option<super::Target>| {
        if let Some(t) = target
            && (value - t.value).abs() > t.tolerance
        {
            s.warnings.push(Problem::warning(
                path,
                format_args!("the model has {value:.4} {unit}, outside {} ± {} {unit}", t.value, t.tolerance),
            ));
        }
    };
    check("targets.total_mass".to_string(), "kg", p.mass, t.mass);
    for i in 0..3 {
        check(format!("targets.cg.{}", ["x", "y", "z"][i]), "m", p.cg[i], t.cg[i]);
        check(format!("targets.inertia.{}", ["xx", "yy", "zz"][i]), "kg m2", p.inertia[i][i], t.inertia[i]);
    }
    Ok(())
}

/// The path of the node whose dof a row is.
fn row_path(model: &Model, row: usize) -> String {
    let (node, _): (usize, Dof) = model.dof_map().rows()[row];
    child("nodes", &model.geometry().names[node])
}

/// "`a`, `b` and 3 more"
fn list(names: &[String]) -> String {
    const SHOWN: usize = 4;
    let shown: Vec<String> = names.iter().take(SHOWN).map(|n| format!("`{n}`")).collect();
    let more = names.len().saturating_sub(SHOWN);
    shown.join(", ") + &if more > 0 { format!(" and {more} more") } else { String::new() }
}
