//! Solids.

use super::importer::{Importer, Values};
use super::materials::{density, isotropic, orthotropic};
use super::{CardRule, read, refused, used};
use crate::system::Quantity as Q;
use crate::text::{computed, with_unit};
use crate::writer::Block;
use retune::deck::{Card, DeckError};
use retune::element::Dof;
use retune::mesh::nastran::order_of_edges;

pub(super) const CARDS: &[CardRule] = &[
    read("CTETRA", "solids", solid),
    read("CPENTA", "solids", solid),
    read("CHEXA", "solids", solid),
    read("CPYRAM", "solids", solid),
    used("PSOLID", "solids"),
    refused("PLSOLID", "hyperelastic solids are not read"),
    refused("PCOMPS", "laminated solids are not read"),
];

/// Nodes in the order of retune, as indices of the deck's order; those of edges of hexahedra and wedges stand otherwise.
fn order(name: &str, nodes: usize) -> Option<(&'static str, Vec<usize>)> {
    let plain = |kind, n| Some((kind, (0..n).collect()));
    match (name, nodes) {
        ("CTETRA", 4) => plain("tet4", 4),
        ("CTETRA", 10) => plain("tet10", 10),
        ("CPYRAM", 5) => plain("pyramid5", 5),
        ("CPYRAM", 13) => plain("pyramid13", 13),
        ("CPENTA", 6) => plain("wedge6", 6),
        ("CPENTA", 15) => Some(("wedge15", order_of_edges(3))),
        ("CHEXA", 8) => plain("hex8", 8),
        ("CHEXA", 20) => Some(("hex20", order_of_edges(4))),
        _ => None,
    }
}

/// Corners of a card, and of each edge the corners, from 0, in the order of its grids.
fn edges(name: &str) -> (usize, &'static [[usize; 2]]) {
    match name {
        "CTETRA" => (4, &[[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]]),
        "CPYRAM" => (5, &[[0, 1], [1, 2], [2, 3], [3, 0], [0, 4], [1, 4], [2, 4], [3, 4]]),
        "CPENTA" => (6, &[[0, 1], [1, 2], [2, 0], [0, 3], [1, 4], [2, 5], [3, 4], [4, 5], [5, 3]]),
        _ => (8, &[[0, 1], [1, 2], [2, 3], [3, 0], [0, 4], [1, 5], [2, 6], [3, 7], [4, 5], [5, 6], [6, 7], [7, 4]]),
    }
}

/// Names and places of a card's nodes. Where some edges have a grid and others not, these have a node that moves as the mean of both corners:
/// the functions of the element without it.
fn nodes(importer: &mut Importer<'_>, card: &Card<'_>) -> Result<(Vec<String>, Vec<[f64; 3]>), DeckError> {
    let (corners, edges) = edges(card.name());
    let (mut grids, mut points) = (Vec::new(), Vec::new());
    for n in 0..corners {
        let (name, grid) = importer.grid(card, 4 + n, "G")?;
        grids.push(name);
        points.push(grid.position);
    }
    let is_given = |n: usize| !matches!(card.text(4 + n), "" | "0");
    if let Some(beyond) = (corners + edges.len()..=card.len().saturating_sub(4)).find(|n| is_given(*n)) {
        let text = format!("a {} has at most {} grids", card.name(), corners + edges.len());
        return Err(card.error(Some((4 + beyond, "G")), text));
    }
    if !(corners..corners + edges.len()).any(is_given) {
        return Ok((grids, points));
    }
    for (i, ends) in edges.iter().enumerate() {
        let (name, at) = if is_given(corners + i) {
            let (name, grid) = importer.grid(card, 4 + corners + i, "G")?;
            (name, grid.position)
        } else {
            let at = std::array::from_fn(|k| 0.5 * (points[ends[0]][k] + points[ends[1]][k]));
            (importer.middle([&grids[ends[0]], &grids[ends[1]]], at), at)
        };
        grids.push(name);
        points.push(at);
    }
    Ok((grids, points))
}

impl Importer<'_> {
    /// The node in the middle of an edge without a grid, the mean of its ends, written when it is first named.
    fn middle(&mut self, ends: [&String; 2], at: [f64; 3]) -> String {
        let [a, b] = if ends[0] <= ends[1] { ends } else { [ends[1], ends[0]] };
        let name = format!("mid_{a}_{b}");
        if self.middles.insert(name.clone()) {
            let place = self.lengths(at);
            self.out.node(&name, &place, Some(at), "edge without a grid");
            for dof in [Dof::Ux, Dof::Uy, Dof::Uz] {
                let terms = vec![(name.clone(), dof, 1.0), (a.clone(), dof, -0.5), (b.clone(), dof, -0.5)];
                self.constraint(&format!("{name}_{dof}"), terms);
            }
        }
        name
    }
}

fn solid<'a>(importer: &mut Importer<'a>, card: &Card<'a>) -> Result<(), DeckError> {
    let property = importer.property(card, 3, &["PSOLID"])?;
    let (grids, points) = nodes(importer, card)?;
    let Some((kind, order)) = order(card.name(), grids.len()) else {
        return Err(
            card.error(Some((4, "G1")), format_args!("{} grids are given; all corners are expected", grids.len()))
        );
    };
    let material = importer.material(&property, 3, &["MAT1", "MAT9", "MAT11"])?;
    let is_directed = material.name() != "MAT1";
    let section = importer.section(&property, "solid", |importer| {
        let mut values = Values::default();
        if is_directed {
            directed(importer, &material, &mut values)?;
            return Ok(values);
        }
        let m = isotropic(&material)?;
        let (Some(e), Some(g)) = (m.e, m.g) else {
            return Err(material.error(Some((3, "E")), "a solid needs two of E, G and NU"));
        };
        let nu = m.nu.unwrap_or(e / (2.0 * g) - 1.0);
        if (g / (e / (2.0 * (1.0 + nu))) - 1.0).abs() > 1e-3 {
            importer.report.approximate("solids whose E, G and NU contradict each other have E and NU");
        }
        if material.is_blank(3) {
            values.items.push(("E".into(), importer.stress(e)));
        } else {
            importer.put(&mut values, ("E", "E"), (&material, 3, "E"), e, (Q::Stress, 1.0));
        }
        if material.is_blank(5) {
            values.items.push(("nu".into(), computed(nu)));
        } else {
            importer.put(&mut values, ("nu", "nu"), (&material, 5, "NU"), nu, (Q::Number, 1.0));
        }
        finish(importer, &material, &mut values)?;
        Ok(values)
    })?;
    let mut values = Values::default();
    values.items.push(("type".into(), kind.into()));
    let nodes: Vec<&str> = order.into_iter().map(|i| grids[i].as_str()).collect();
    values.items.push(("nodes".into(), format!("[{}]", nodes.join(", "))));
    values.items.push(("section".into(), section.clone()));
    if is_directed {
        // The axes of an isotropic material are any.
        if property.text(4) == "-1" {
            return Err(property.error(
                Some((4, "CORDM")),
                "a material along the axes of each element is not read; name a coordinate system",
            ));
        }
        let (cordm, coord) = importer.coord(&property, 4, "CORDM")?;
        let n = points.len() as f64;
        let centre: [f64; 3] = std::array::from_fn(|i| points.iter().map(|p| p[i]).sum::<f64>() / n);
        values.items.extend(importer.frame(cordm, &coord, centre).map(|f| ("frame".to_string(), f)));
    }
    importer.element(Block::Elements, card, values, Some(&property), Some(&section)).map(|_| ())
}

/// Constants of a directed solid.
fn directed(importer: &mut Importer<'_>, material: &Card<'_>, values: &mut Values) -> Result<(), DeckError> {
    const NAMES: [&str; 9] = ["E1", "E2", "E3", "nu12", "nu13", "nu23", "G12", "G13", "G23"];
    for (i, (key, value)) in NAMES.into_iter().zip(orthotropic(material)?).enumerate() {
        let of = if (3..6).contains(&i) { Q::Number } else { Q::Stress };
        if material.name() == "MAT11" {
            importer.put(values, (key, key), (material, 3 + i, key), value, (of, 1.0));
        } else {
            values.items.push((key.into(), with_unit(&computed(value), importer.unit(of))));
        }
    }
    finish(importer, material, values)
}

/// Density and lumping.
fn finish(importer: &mut Importer<'_>, material: &Card<'_>, values: &mut Values) -> Result<(), DeckError> {
    density(importer, material, values)?;
    if !importer.coupled {
        values.items.push(("lumping".into(), "1".into()));
    }
    importer
        .report
        .note("shells and solids are retune's own: equal to the deck's as the mesh gets finer, not to the digits");
    Ok(())
}
