//! Materials.

use super::importer::{Importer, Values};
use super::{CardRule, refused, used};
use crate::deck::{Card, DeckError};
use crate::exchange::system::Quantity;

pub(super) const CARDS: &[CardRule] = &[
    used("MAT1", "materials"),
    used("MAT8", "materials"),
    used("MAT2", "materials"),
    used("MAT9", "materials"),
    super::left_out("MATT1", "temperature"),
    super::left_out("MATT2", "temperature"),
    super::left_out("MATT8", "temperature"),
    super::left_out("MATT9", "temperature"),
    super::left_out("MAT4", "heat"),
    super::left_out("MAT5", "heat"),
    super::left_out("MATS1", "nonlinear material"),
    super::left_out("CREEP", "nonlinear material"),
    super::left_out("MATF", "failure"),
    refused("MAT3", "materials of axisymmetric elements are not read"),
    refused("MAT10", "fluids are not read"),
    refused("MATHP", "hyperelastic materials are not read"),
];

/// E, G and nu of an isotropic material, completed as the solver does.
#[derive(Debug, Clone, Copy)]
pub(super) struct Isotropic {
    pub e: Option<f64>,
    pub g: Option<f64>,
    pub nu: Option<f64>,
    /// Whether G is a field of its own or follows from E and nu.
    pub g_is_given: bool,
}

/// Reads MAT1.
pub(super) fn isotropic(card: &Card<'_>) -> Result<Isotropic, DeckError> {
    let (e, g, nu) = (card.optional_real(3, "E")?, card.optional_real(4, "G")?, card.optional_real(5, "NU")?);
    for (value, field, name) in [(e, 3, "E"), (g, 4, "G")] {
        if value.is_some_and(|v| v < 0.0) {
            return Err(card.error(Some((field, name)), "it must not be negative"));
        }
    }
    let (e, g_is_given) = (e.filter(|v| *v > 0.0), g.is_some());
    let g = g.filter(|v| *v > 0.0);
    Ok(match (e, g, nu) {
        (Some(e), None, Some(nu)) if !g_is_given => {
            Isotropic { e: Some(e), g: Some(e / (2.0 * (1.0 + nu))), nu: Some(nu), g_is_given }
        }
        (Some(e), Some(g), None) => Isotropic { e: Some(e), g: Some(g), nu: Some(e / (2.0 * g) - 1.0), g_is_given },
        (None, Some(g), Some(nu)) => Isotropic { e: Some(2.0 * g * (1.0 + nu)), g: Some(g), nu: Some(nu), g_is_given },
        _ => Isotropic { e, g, nu, g_is_given },
    })
}

/// E, and G or nu, of a material for members; whether there is an E, and a G.
pub(super) fn for_members(
    importer: &Importer<'_>,
    card: &Card<'_>,
    values: &mut Values,
) -> Result<(bool, bool), DeckError> {
    let m = isotropic(card)?;
    let stress = (Quantity::Stress, 1.0);
    if let Some(e) = m.e {
        if card.is_blank(3) {
            values.items.push(("E".into(), importer.stress(e)));
        } else {
            importer.put(values, ("E", "E"), (card, 3, "E"), e, stress);
        }
    }
    if let Some(g) = m.g {
        if m.g_is_given {
            importer.put(values, ("G", "G"), (card, 4, "G"), g, stress);
        } else if let Some(nu) = m.nu {
            importer.put(values, ("nu", "nu"), (card, 5, "NU"), nu, (Quantity::Number, 1.0));
        }
    }
    Ok((m.e.is_some(), m.g.is_some()))
}

/// The density of a material.
pub(super) fn density(importer: &Importer<'_>, card: &Card<'_>, values: &mut Values) -> Result<Option<f64>, DeckError> {
    let (field, name) = match card.name() {
        "MAT8" | "MAT2" => (9, "RHO"),
        _ => (6, "RHO"),
    };
    let Some(rho) = card.optional_real(field, name)?.filter(|r| *r != 0.0) else { return Ok(None) };
    if rho < 0.0 {
        return Err(card.error(Some((field, name)), "it must not be negative"));
    }
    importer.put(values, ("density", "density"), (card, field, name), rho, (Quantity::Density, importer.wtmass));
    Ok(Some(rho))
}

impl Importer<'_> {
    /// A computed stress, with its unit.
    pub(super) fn stress(&self, value: f64) -> String {
        crate::exchange::writer::with_unit(&crate::exchange::writer::computed(value), self.unit(Quantity::Stress))
    }
}
