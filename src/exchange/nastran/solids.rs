//! Solids.

use super::importer::{Importer, Values};
use super::materials::{density, isotropic, orthotropic};
use super::{CardRule, read, refused, used};
use crate::deck::{Card, DeckError};
use crate::exchange::system::Quantity as Q;
use crate::exchange::text::{computed, with_unit};
use crate::exchange::writer::Block;

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
        ("CPENTA", 15) => Some(("wedge15", (0..9).chain(12..15).chain(9..12).collect())),
        ("CHEXA", 8) => plain("hex8", 8),
        ("CHEXA", 20) => Some(("hex20", (0..12).chain(16..20).chain(12..16).collect())),
        _ => None,
    }
}

fn solid<'a>(importer: &mut Importer<'a>, card: &Card<'a>) -> Result<(), DeckError> {
    let property = importer.property(card, 3, &["PSOLID"])?;
    let (mut grids, mut points) = (Vec::new(), Vec::new());
    for n in 4..=card.len() {
        if !card.is_blank(n) {
            let (name, grid) = importer.grid(card, n, "G")?;
            grids.push(name);
            points.push(grid.position);
        }
    }
    let Some((kind, order)) = order(card.name(), grids.len()) else {
        let text = format!(
            "{} grids are given; all of the corners, or all with those of every edge, are expected",
            grids.len()
        );
        return Err(card.error(Some((4, "G1")), text));
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
