//! Materials.

use super::importer::{Importer, Values};
use super::{CardRule, refused, used};
use crate::system::Quantity;
use retune::deck::{Card, DeckError};
use retune::linalg::DMatrix;

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
    used("MAT11", "materials"),
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

/// E1, E2, nu12 and G12 of a sheet by its stiffnesses in plane stress (MAT2).
///
/// Q11 = E1/(1 - ν12 ν21), Q22 = E2/(1 - ν12 ν21), Q12 = ν12 Q22, Q33 = G12 (Jones, Mechanics of Composite Materials, 2.61).
///
/// # Errors
/// Stiffnesses that couple stretching with shear, or that store no energy.
pub(super) fn sheet(card: &Card<'_>) -> Result<[f64; 4], DeckError> {
    for (field, name) in [(5, "G13"), (7, "G23")] {
        if card.real_or(field, name, 0.0)? != 0.0 {
            return Err(card.error(
                Some((field, name)),
                "a sheet that couples stretching with shear is not read; give its constants along its own axes",
            ));
        }
    }
    let (q11, q12, q22, q33) =
        (card.real(3, "G11")?, card.real_or(4, "G12", 0.0)?, card.real(6, "G22")?, card.real(8, "G33")?);
    if !(q11 > 0.0 && q22 > 0.0 && q33 > 0.0 && q12 * q12 < q11 * q22) {
        return Err(
            card.error(Some((3, "G11")), "its stiffnesses are those of no material: not every stress stores energy")
        );
    }
    let rest = 1.0 - q12 * q12 / (q11 * q22);
    Ok([q11 * rest, q22 * rest, q12 / q22, q33])
}

/// Elastic constants of a directed solid: E1 E2 E3, ν12 ν13 ν23, G12 G13 G23.
pub(super) type Orthotropic = [f64; 9];

/// MAT9 by the inverse of its stiffnesses, MAT11 as it stands.
///
/// # Errors
/// Stiffnesses that couple stretching with shear, or shears with each other; that store no energy.
pub(super) fn orthotropic(card: &Card<'_>) -> Result<Orthotropic, DeckError> {
    const NO_MATERIAL: &str = "its constants are those of no material: not every stress stores energy";
    if card.name() == "MAT11" {
        // MID, E1, E2, E3, NU12, NU13, NU23, G12, then G13, G23, RHO on the next line.
        let mut out = [0.0; 9];
        for (i, name) in ["E1", "E2", "E3", "NU12", "NU13", "NU23", "G12"].into_iter().enumerate() {
            out[i] = card.real_or(3 + i, name, 0.0)?;
        }
        (out[7], out[8]) = (card.real(10, "G13")?, card.real(11, "G23")?);
        let is_sound = [0, 1, 2, 6, 7, 8].iter().all(|i| out[*i] > 0.0);
        return if is_sound { Ok(out) } else { Err(card.error(Some((3, "E1")), NO_MATERIAL)) };
    }
    // The upper triangle, row by row; shears are xy, yz, zx.
    let mut g = [[0.0; 6]; 6];
    let mut field = 3;
    for i in 0..6 {
        for j in i..6 {
            g[i][j] = card.real_or(field, "G", 0.0)?;
            g[j][i] = g[i][j];
            let is_coupling = j >= 3 && i != j;
            if is_coupling && g[i][j] != 0.0 {
                return Err(card.error(
                    Some((field, "G")),
                    "a solid that couples stretching with shear is not read; give its constants along its own axes",
                ));
            }
            field += 1;
        }
    }
    let d = DMatrix::from_fn(3, 3, |i, j| g[i][j]);
    let s = d.try_inverse().filter(|s| (0..3).all(|i| s[(i, i)] > 0.0 && s[(i, i)].is_finite()));
    let s = s.filter(|_| (3..6).all(|i| g[i][i] > 0.0));
    let s = s.ok_or_else(|| card.error(Some((3, "G11")), NO_MATERIAL))?;
    let e: [f64; 3] = std::array::from_fn(|i| 1.0 / s[(i, i)]);
    let nu = |i: usize, j: usize| -s[(i, j)] * e[i];
    Ok([e[0], e[1], e[2], nu(0, 1), nu(0, 2), nu(1, 2), g[3][3], g[5][5], g[4][4]])
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

/// The field of a density.
fn density_field(card: &Card<'_>) -> usize {
    match card.name() {
        "MAT8" | "MAT2" => 9,
        "MAT9" => 24,
        "MAT11" => 12,
        _ => 6,
    }
}

/// The density of a material, in the deck's unit.
pub(super) fn density_of(card: &Card<'_>) -> Result<Option<f64>, DeckError> {
    let at = (density_field(card), "RHO");
    let Some(rho) = card.optional_real(at.0, at.1)?.filter(|r| *r != 0.0) else { return Ok(None) };
    if rho < 0.0 { Err(card.error(Some(at), "it must not be negative")) } else { Ok(Some(rho)) }
}

/// Puts the density of a material under an entry.
pub(super) fn density(importer: &Importer<'_>, card: &Card<'_>, values: &mut Values) -> Result<Option<f64>, DeckError> {
    let Some(rho) = density_of(card)? else { return Ok(None) };
    let from = (card, density_field(card), "RHO");
    importer.put(values, ("density", "density"), from, rho, (Quantity::Density, importer.wtmass));
    Ok(Some(rho))
}

impl Importer<'_> {
    /// A computed stress, with its unit.
    pub(super) fn stress(&self, value: f64) -> String {
        crate::text::with_unit(&crate::text::computed(value), self.unit(Quantity::Stress))
    }
}
