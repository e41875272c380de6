//! Solids.

use super::importer::{Importer, Values};
use super::materials::{density, isotropic};
use super::{CardRule, read, refused, used};
use crate::deck::{Card, DeckError};
use crate::exchange::system::Quantity as Q;
use crate::exchange::writer::{Block, computed};

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
    let mut grids = Vec::new();
    for n in 4..=card.len() {
        if !card.is_blank(n) {
            grids.push(importer.grid(card, n, "G")?.0);
        }
    }
    let Some((kind, order)) = order(card.name(), grids.len()) else {
        let text = format!(
            "{} grids are given; all of the corners, or all with those of every edge, are expected",
            grids.len()
        );
        return Err(card.error(Some((4, "G1")), text));
    };
    let cordm = property.integer_or(4, "CORDM", 0)?;
    let section = importer.section(&property, "solid", |importer| {
        let material = importer.material(&property, 3, &["MAT1", "MAT9"])?;
        let mut values = Values::default();
        if material.name() != "MAT1" {
            return Err(material.error(None, "anisotropic solids are not read; give MAT1"));
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
        density(importer, &material, &mut values)?;
        if !importer.coupled {
            values.items.push(("lumping".into(), "1".into()));
        }
        importer
            .report
            .note("shells and solids are retune's own: equal to the deck's as the mesh gets finer, not to the digits");
        Ok(values)
    })?;
    let _ = cordm; // the axes of an isotropic material are any
    let mut values = Values::default();
    values.items.push(("type".into(), kind.into()));
    let nodes: Vec<&str> = order.into_iter().map(|i| grids[i].as_str()).collect();
    values.items.push(("nodes".into(), format!("[{}]", nodes.join(", "))));
    values.items.push(("section".into(), section.clone()));
    importer.element(Block::Elements, card, values, Some(&property), Some(&section)).map(|_| ())
}
