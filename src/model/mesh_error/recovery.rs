//! Strains at nodes, from those in the elements around them.

use super::Strained;
use crate::linalg::{DMatrix, symmetric_eigen};
use crate::model::compile::Model;
use crate::model::geometry::{GLOBAL, Vector, cross, dot, minus, plus, unit};
use rayon::prelude::*;
use std::collections::HashMap;

/// Shells whose normals make less than this angle are of one surface: cos 35°.
const SMOOTH: f64 = 0.819;
/// Weight of the slopes of a fit against its samples: directions in which these do not differ have none.
const RIDGE: f64 = 1e-4;

/// Samples by term of a polynomial of second order, below which one of first order is fitted.
const ENOUGH: usize = 2;

/// Elements around a node between which strains are continuous: (index among the strained, node of the element).
type Patch = Vec<(usize, usize)>;

/// Strains at the nodes of each element, by node and mode, in the axes of the element.
pub(super) fn recover(model: &Model, all: &[Strained], n_modes: usize) -> Vec<Vec<Vec<[f64; 6]>>> {
    let fitted: Vec<(Patch, Vec<Vec<[f64; 6]>>)> = patches(model, all)
        .into_par_iter()
        .map(|patch| {
            let values = fit(model, all, &patch, n_modes);
            (patch, values)
        })
        .collect();
    let nodes = |e: &Strained| model.elements()[e.element].nodes.len();
    let mut out: Vec<Vec<Vec<[f64; 6]>>> = all.iter().map(|e| vec![Vec::new(); nodes(e)]).collect();
    for (patch, values) in fitted {
        for ((e, k), value) in patch.into_iter().zip(values) {
            out[e][k] = value;
        }
    }
    out
}

/// The elements around each node, those of one surface and one material together.
fn patches(model: &Model, all: &[Strained]) -> Vec<Patch> {
    // How many members and shells meet at an edge: beside a third one strains jump.
    let mut on_edge: HashMap<[usize; 2], usize> = HashMap::new();
    let shells = all.iter().filter(|e| e.plane.is_some()).map(|e| &model.elements()[e.element].nodes);
    for nodes in model.elements().iter().map(|e| &e.nodes).filter(|n| n.len() == 2).chain(shells) {
        for k in 0..if nodes.len() == 2 { 1 } else { nodes.len() } {
            let (a, b) = (nodes[k], nodes[(k + 1) % nodes.len()]);
            *on_edge.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
    }
    let mut at: Vec<Patch> = vec![Vec::new(); model.geometry().names.len()];
    for (i, e) in all.iter().enumerate() {
        for (k, &node) in model.elements()[e.element].nodes.iter().enumerate() {
            at[node].push((i, k));
        }
    }
    let mut out = Vec::new();
    for (node, around) in at.into_iter().enumerate() {
        let mut group: Vec<usize> = (0..around.len()).collect();
        for a in 0..around.len() {
            for b in 0..a {
                if group[a] != group[b] && is_one(model, all, &on_edge, node, [around[a], around[b]]) {
                    let (kept, gone) = (group[b], group[a]);
                    group.iter_mut().filter(|g| **g == gone).for_each(|g| *g = kept);
                }
            }
        }
        let mut groups: Vec<usize> = group.clone();
        groups.sort_unstable();
        groups.dedup();
        for g in groups {
            out.push(around.iter().zip(&group).filter(|(_, own)| **own == g).map(|(e, _)| *e).collect());
        }
    }
    out
}

/// Whether strains are continuous from one element to another at a node of both.
fn is_one(
    model: &Model,
    all: &[Strained],
    on_edge: &HashMap<[usize; 2], usize>,
    node: usize,
    [(a, _), (b, _)]: [(usize, usize); 2],
) -> bool {
    let (a, b) = (&all[a], &all[b]);
    if a.class != b.class {
        return false;
    }
    let (Some(p), Some(q)) = (a.normal(), b.normal()) else { return a.plane.is_none() == b.plane.is_none() };
    let nodes = |e: &Strained| &model.elements()[e.element].nodes;
    let neighbours = |e: &Strained| {
        let nodes = nodes(e);
        let k = nodes.iter().position(|n| *n == node).unwrap_or(0);
        [nodes[(k + 1) % nodes.len()], nodes[(k + nodes.len() - 1) % nodes.len()]]
    };
    let shares = |n: &usize| nodes(b).contains(n) && on_edge.get(&[node.min(*n), node.max(*n)]) == Some(&2);
    dot(p, q) > SMOOTH && neighbours(a).iter().any(shares)
}

/// ε* at the node of a patch, by element of it and mode, in the axes of each.
fn fit(model: &Model, all: &[Strained], patch: &Patch, n_modes: usize) -> Vec<Vec<[f64; 6]>> {
    let Some(&(first, k)) = patch.first() else { return Vec::new() };
    let node = model.elements()[all[first].element].nodes[k];
    let origin = model.geometry().positions[node];
    let frame = common_plane(all, patch);
    let turns: Vec<f64> =
        patch.iter().map(|&(e, _)| frame.map_or(0.0, |[x, _, normal]| all[e].turned_from(x, normal))).collect();
    let samples: Vec<(Vector, usize, usize)> = patch
        .iter()
        .enumerate()
        .flat_map(|(i, &(e, _))| {
            let points = all[e].points.iter().enumerate().filter(|(_, p)| p.is_sample);
            points.map(move |(j, p)| (minus(p.at, origin), i, j))
        })
        .collect();
    let n_samples = samples.len() as f64;
    // Powers count from the middle of the samples: of directions in which these stand in two places they say a slope and no more.
    let middle = samples.iter().fold([0.0; 3], |sum, s| plus(sum, 1.0 / n_samples, s.0));
    let axes: Vec<Vector> = frame.map_or_else(|| GLOBAL.to_vec(), |[x, y, _]| vec![x, y]);
    let scaled = spreads(model, all, patch, &axes);
    let n_quadratic = (axes.len() + 1) * (axes.len() + 2) / 2;
    let quadratic = samples.len() >= ENOUGH * n_quadratic && patch.iter().all(|&(e, _)| all[e].order > 1);
    let basis = |d: Vector| -> Vec<f64> {
        let local: Vec<f64> = scaled.iter().map(|axis| dot(minus(d, middle), *axis)).collect();
        let mut terms = vec![1.0];
        terms.extend(&local);
        if quadratic {
            for a in 0..local.len() {
                for b in a..local.len() {
                    terms.push(local[a] * local[b]);
                }
            }
        }
        terms
    };
    let rows: Vec<Vec<f64>> = samples.iter().map(|s| basis(s.0)).collect();
    let n = rows[0].len();
    let mut normal: DMatrix<f64> = DMatrix::zeros(n, n);
    let mut right: DMatrix<f64> = DMatrix::zeros(n, 6 * n_modes);
    for (row, &(_, i, j)) in rows.iter().zip(&samples) {
        let strains = &all[patch[i].0].points[j].strains;
        for a in 0..n {
            for b in 0..n {
                normal[(a, b)] += row[a] * row[b];
            }
            for (k, strain) in strains.iter().enumerate() {
                let there = turned(strain, -turns[i], frame.is_some());
                for (c, value) in there.into_iter().enumerate() {
                    right[(a, 6 * k + c)] += row[a] * value;
                }
            }
        }
    }
    for a in 1..n {
        normal[(a, a)] += RIDGE * n_samples;
    }
    // Sums of squares beside a ridge, and the constant of as many samples.
    let fitted = normal.cholesky().map_or_else(|| DMatrix::zeros(n, 6 * n_modes), |c| c.solve(&right));
    let at_node = basis([0.0; 3]);
    let value = |k: usize| -> [f64; 6] {
        std::array::from_fn(|c| at_node.iter().enumerate().map(|(a, term)| term * fitted[(a, 6 * k + c)]).sum())
    };
    turns.iter().map(|&t| (0..n_modes).map(|k| turned(&value(k), t, frame.is_some())).collect()).collect()
}

/// Principal axes of the nodes of a patch, each over the spread of the nodes along it: long and flat elements count alike in every direction.
///
/// * `axes` - directions that count
fn spreads(model: &Model, all: &[Strained], patch: &Patch, axes: &[Vector]) -> Vec<Vector> {
    let nodes: Vec<Vector> = patch
        .iter()
        .flat_map(|&(e, _)| &model.elements()[all[e].element].nodes)
        .map(|&n| model.geometry().positions[n])
        .collect();
    let n = nodes.len() as f64;
    let middle = nodes.iter().fold([0.0; 3], |sum, p| plus(sum, 1.0 / n, *p));
    let along = |p: &Vector, k: usize| dot(minus(*p, middle), axes[k]);
    let of = |i: usize, j: usize| nodes.iter().map(|p| along(p, i) * along(p, j)).sum::<f64>() / n;
    let Ok(principal) = symmetric_eigen(&DMatrix::from_fn(axes.len(), axes.len(), of)) else { return axes.to_vec() };
    let axis = |k: usize| {
        let spread = principal.values[k].max(f64::MIN_POSITIVE).sqrt();
        (0..axes.len()).fold([0.0; 3], |sum, i| plus(sum, principal.vectors[(i, k)] / spread, axes[i]))
    };
    (0..axes.len()).map(axis).collect()
}

/// Axes of the mean plane of the shells of a patch; `None` of solids.
fn common_plane(all: &[Strained], patch: &Patch) -> Option<[Vector; 3]> {
    let normals = patch.iter().map(|&(e, _)| all[e].normal()).collect::<Option<Vec<_>>>()?;
    let normal = unit(normals.into_iter().fold([0.0; 3], |sum, n| plus(sum, 1.0, n)))?;
    let own = all[patch[0].0].plane?[0];
    let x = unit(plus(own, -dot(own, normal), normal))?;
    Some([x, cross(normal, x), normal])
}

/// Strains and curvatures of a plane in axes that are turned about its normal by an angle; those of a solid as they are.
fn turned(strain: &[f64; 6], angle: f64, is_plane: bool) -> [f64; 6] {
    if !is_plane || angle == 0.0 {
        return *strain;
    }
    let (s, c) = angle.sin_cos();
    let of = |xx: f64, yy: f64, xy: f64| {
        [
            xx * c * c + yy * s * s + xy * c * s,
            xx * s * s + yy * c * c - xy * c * s,
            2.0 * (yy - xx) * c * s + xy * (c * c - s * s),
        ]
    };
    let [a, b, d, e, f, g] = *strain;
    let (membrane, bending) = (of(a, b, d), of(e, f, g));
    [membrane[0], membrane[1], membrane[2], bending[0], bending[1], bending[2]]
}
