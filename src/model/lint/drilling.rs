//! Bodies on shells that turn about the normal: what holds them there is a device of the elements and no plate's.

use super::{FIRST_MODES, mesh};
use crate::element::Dof;
use crate::linalg::SymMatrix;
use crate::linalg::sparse::SparseSym;
use crate::modal::Modes;
use crate::model::ParametricModel;
use crate::model::compile::Model;
use crate::model::geometry::{Vector, cross, dot, minus, unit};
use crate::model::placed_element::PlacedElement;
use crate::model::system::SparseSystem;
use crate::yaml::Problem;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::f64::consts::TAU;

/// Cosine of the angle between the normals of shells that meet flat: at a fold each holds the other's.
const FLAT: f64 = 0.97;

/// Bodies with inertia about the normal of the shells at their node, and nothing else there, that turn below the first modes or among them.
///
/// Alone it would turn at f = √(nᵀK n / nᵀM n) / 2π with n in the rotations of the node.
pub(super) fn drilling(model: &Model, theta: &[f64], system: &SparseSystem, modes: &Modes) -> Vec<Problem> {
    let mut at: BTreeMap<usize, (Vec<&PlacedElement>, Vec<&PlacedElement>)> = BTreeMap::new();
    let mut held: HashMap<usize, Vec<Vector>> = HashMap::new();
    for (i, e) in model.elements().iter().enumerate().filter(|(_, e)| e.joined().len() == 1 && e.nodes.len() == 1) {
        let Ok(matrices) = model.element_matrices(i, theta) else { continue };
        let motion = model.element_motion(i);
        let turns = |of: &SymMatrix| -> Vec<Vector> {
            let loaded = motion.loads(of);
            (0..3).filter(|&a| loaded.get(3 + a) == Some(&true)).map(|a| e.axes[a]).collect()
        };
        held.entry(e.nodes[0]).or_default().extend(turns(&matrices.stiffness));
        if !turns(&matrices.mass).is_empty() {
            at.entry(e.nodes[0]).or_default().0.push(e);
        }
    }
    for e in model.elements().iter().filter(|e| e.joined().len() > 1) {
        for n in e.joined().iter() {
            if let Some((_, others)) = at.get_mut(n) {
                others.push(e);
            }
        }
    }
    let highest = modes.elastic().skip(modes.n_mechanism).take(FIRST_MODES).map(|r| modes.lambda[r]).next_back();
    let Some(highest) = highest else { return Vec::new() };
    let bodies = at.into_iter().filter_map(|(node, (bodies, others))| {
        let normal = common_normal(&others)?;
        // What a spring to the ground holds does not hang on the plate.
        if held[&node].iter().any(|&axis| dot(axis, normal).abs() > 0.1) {
            return None;
        }
        let rows: Vec<usize> =
            [Dof::Rx, Dof::Ry, Dof::Rz].into_iter().map(|dof| alone(model, node, dof)).collect::<Option<_>>()?;
        Some((node, bodies, normal, rows))
    });
    let bodies: Vec<_> = bodies.collect();
    let (stiffness, mass) = (near(&system.stiffness, &bodies), near(&system.mass, &bodies));
    let along = |of: &HashMap<(usize, usize), f64>, rows: &[usize], n: Vector| -> f64 {
        let value = |i: usize, j: usize| of.get(&(rows[i].max(rows[j]), rows[i].min(rows[j]))).copied().unwrap_or(0.0);
        (0..3).flat_map(|i| (0..3).map(move |j| (i, j))).map(|(i, j)| n[i] * n[j] * value(i, j)).sum()
    };
    let mut out = Vec::new();
    for (node, bodies, normal, rows) in &bodies {
        let (k, m) = (along(&stiffness, rows, *normal), along(&mass, rows, *normal));
        if m <= 0.0 || k <= 0.0 || k / m > highest {
            continue;
        }
        let hz = (k / m).sqrt() / TAU;
        out.push(Problem::warning(
            &bodies[0].path,
            format_args!(
                "`{}` turns about the normal of the shells at `{}` on their drilling stiffness alone, at some {hz:.3} Hz, and no plate holds a body so softly: give it a footprint, by a rigid or weighted link to the nodes that it stands on",
                bodies[0].name,
                model.geometry().names[*node]
            ),
        ));
    }
    out
}

/// Body, normal and rows at a node.
type Body<'a> = (usize, Vec<&'a PlacedElement>, Vector, Vec<usize>);

/// Entries of a matrix among the rows of bodies.
fn near(a: &SparseSym, bodies: &[Body<'_>]) -> HashMap<(usize, usize), f64> {
    let rows: HashSet<usize> = bodies.iter().flat_map(|b| b.3.iter().copied()).collect();
    let mut found = HashMap::new();
    for (i, j, v) in a.entries().filter(|(i, j, _)| rows.contains(i) && rows.contains(j)) {
        *found.entry((i.max(j), i.min(j))).or_insert(0.0) += v;
    }
    found
}

/// The row that is a dof of a node and nothing else.
fn alone(model: &Model, node: usize, dof: Dof) -> Option<usize> {
    match model.dof_map().express(node, dof) {
        [(row, factor)] if (factor - 1.0).abs() < 1e-9 => Some(*row),
        _ => None,
    }
}

/// The normal of elements that are all shells and meet flat.
fn common_normal(elements: &[&PlacedElement]) -> Option<Vector> {
    let normals: Option<Vec<Vector>> =
        elements.iter().map(|e| mesh::is_surface(e).then(|| normal(e)).flatten()).collect();
    let normals = normals?;
    let first = *normals.first()?;
    normals.iter().all(|n| dot(*n, first).abs() > FLAT).then_some(first)
}

fn normal(e: &PlacedElement) -> Option<Vector> {
    let p = &e.points;
    let (a, b) =
        if p.len() == 3 { (minus(p[1], p[0]), minus(p[2], p[0])) } else { (minus(p[2], p[0]), minus(p[3], p[1])) };
    unit(cross(a, b))
}
