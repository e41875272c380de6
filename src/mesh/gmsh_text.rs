//! Meshes written as MSH files of gmsh, version 4.1, as text.

use super::cell::{Mesh, Shape};
use super::gmsh::{kind_of, order_of};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

/// The text of an MSH file that [`read`](super::read) reads as the same mesh, its cells ordered by their sets.
///
/// Each set becomes a physical group, one for each dimension of its cells; cells that are in the same sets, and are of one shape, stand together in an
/// entity. Coordinates have as many digits as give them back.
///
/// * `mesh` - the names of its sets in one line without quotation marks
pub fn write_gmsh(mesh: &Mesh) -> String {
    let mut sets_of: Vec<Vec<usize>> = vec![Vec::new(); mesh.cells.len()];
    for (s, set) in mesh.sets.iter().enumerate() {
        set.cells.iter().for_each(|&c| sets_of[c].push(s));
    }
    let mut entities: BTreeMap<(usize, Vec<usize>), BTreeMap<Shape, Vec<usize>>> = BTreeMap::new();
    for (c, sets) in sets_of.into_iter().enumerate() {
        let shape = mesh.cells[c].shape;
        entities.entry((shape.dimension(), sets)).or_default().entry(shape).or_default().push(c);
    }
    let mut out = String::from("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n");
    let groups: BTreeSet<(usize, usize)> =
        entities.keys().flat_map(|(dimension, sets)| sets.iter().map(|&s| (*dimension, s))).collect();
    let _ = writeln!(out, "$PhysicalNames\n{}", groups.len());
    for (dimension, s) in groups {
        let _ = writeln!(out, "{dimension} {} \"{}\"", s + 1, mesh.sets[s].name);
    }
    out.push_str("$EndPhysicalNames\n$Entities\n");
    let of = |d: usize| entities.keys().filter(|e| e.0 == d).count();
    let _ = writeln!(out, "{} {} {} {}", of(0), of(1), of(2), of(3));
    let [low, high] = bounds(mesh);
    for (e, (dimension, sets)) in entities.keys().enumerate() {
        let _ = write!(out, "{} {} {} {}", e + 1, low[0], low[1], low[2]);
        if *dimension > 0 {
            let _ = write!(out, " {} {} {}", high[0], high[1], high[2]);
        }
        let _ = write!(out, " {}", sets.len());
        for s in sets {
            let _ = write!(out, " {}", s + 1);
        }
        out.push_str(if *dimension > 0 { " 0\n" } else { "\n" });
    }
    let ids = || mesh.nodes.iter().map(|n| n.id);
    let (least, most, n) = (ids().min().unwrap_or(0), ids().max().unwrap_or(0), mesh.nodes.len());
    // Nodes belong to an entity; which one says nothing here.
    let (dimension, first) = entities.keys().next().map_or((0, 0), |e| (e.0, 1));
    let _ = writeln!(out, "$EndEntities\n$Nodes\n1 {n} {least} {most}\n{dimension} {first} 0 {n}");
    for id in ids() {
        let _ = writeln!(out, "{id}");
    }
    for node in &mesh.nodes {
        let [x, y, z] = node.at;
        let _ = writeln!(out, "{x} {y} {z}");
    }
    let ids = || mesh.cells.iter().map(|c| c.id);
    let (least, most, n) = (ids().min().unwrap_or(0), ids().max().unwrap_or(0), mesh.cells.len());
    let blocks: usize = entities.values().map(BTreeMap::len).sum();
    let _ = writeln!(out, "$EndNodes\n$Elements\n{blocks} {n} {least} {most}");
    for (e, ((dimension, _), shapes)) in entities.iter().enumerate() {
        for (shape, cells) in shapes {
            let _ = writeln!(out, "{dimension} {} {} {}", e + 1, kind_of(*shape), cells.len());
            for &c in cells {
                let _ = write!(out, "{}", mesh.cells[c].id);
                let own = mesh.nodes_of(c);
                for k in order_of(*shape, own.len()) {
                    let _ = write!(out, " {}", mesh.nodes[own[k]].id);
                }
                out.push('\n');
            }
        }
    }
    out + "$EndElements\n"
}

fn bounds(mesh: &Mesh) -> [[f64; 3]; 2] {
    let Some(first) = mesh.nodes.first() else { return [[0.0; 3]; 2] };
    mesh.nodes.iter().fold([first.at; 2], |[low, high], n| {
        [std::array::from_fn(|i| low[i].min(n.at[i])), std::array::from_fn(|i| high[i].max(n.at[i]))]
    })
}
