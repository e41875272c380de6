//! What properties of shells share: elastic constants of their materials, mass beside the material, lumping.

use super::importer::{Importer, Values};
use super::materials::{isotropic, sheet};
use crate::system::Quantity as Q;
use crate::text::computed;
use retune::deck::{Card, DeckError};

/// The section that a property became.
pub(super) struct ShellSection {
    pub name: String,
    /// Whether its material has a direction.
    pub is_directed: bool,
    /// Of the plies, from the direction of the element, rad.
    pub ply_angle: f64,
    /// What it says of the way from the grids to the mid-surface; empty where that is none.
    pub offset: String,
    pub thickness: Option<f64>,
}

/// E1, E2, nu12, G12, G13, G23 of a material, in the deck's units.
pub(super) fn numbers(material: &Card<'_>) -> Result<[f64; 6], DeckError> {
    Ok(match material.name() {
        "MAT1" => {
            let m = isotropic(material)?;
            let (Some(e), Some(g)) = (m.e, m.g) else {
                return Err(material.error(Some((3, "E")), "a shell needs two of E, G and NU"));
            };
            [e, e, m.nu.unwrap_or(e / (2.0 * g) - 1.0), g, g, g]
        }
        "MAT8" => {
            let g12 = material.real(6, "G12")?;
            let other = |n, name| Ok(material.optional_real(n, name)?.filter(|g| *g > 0.0).unwrap_or(g12));
            let (e1, e2) = (material.real(3, "E1")?, material.real(4, "E2")?);
            [e1, e2, material.real_or(5, "NU12", 0.0)?, g12, other(7, "G1Z")?, other(8, "G2Z")?]
        }
        _ => {
            let [e1, e2, nu12, g12] = sheet(material)?;
            [e1, e2, nu12, g12, g12, g12]
        }
    })
}

/// Mass that carries no load, where there is any.
pub(super) fn non_structural(
    importer: &mut Importer<'_>,
    values: &mut Values,
    (property, field): (&Card<'_>, usize),
    nsm: f64,
) {
    if nsm > 0.0 {
        let scale = (Q::MassPerArea, importer.wtmass);
        importer.put(values, ("mass_per_area", "mass_per_area"), (property, field, "NSM"), nsm, scale);
    }
}

/// Whether masses are lumped.
pub(super) fn lumped(importer: &mut Importer<'_>, values: &mut Values) {
    if !importer.coupled {
        values.items.push(("lumping".into(), "1".into()));
    }
    importer
        .report
        .note("shells and solids are retune's own: equal to the deck's as the mesh gets finer, not to the digits");
}

/// Elastic constants of a shell's material.
pub(super) fn elastic(importer: &mut Importer<'_>, material: &Card<'_>, values: &mut Values) -> Result<(), DeckError> {
    let stress = (Q::Stress, 1.0);
    match material.name() {
        "MAT1" => {
            let m = isotropic(material)?;
            let (Some(e), Some(g)) = (m.e, m.g) else {
                return Err(material.error(Some((3, "E")), "a shell needs two of E, G and NU"));
            };
            let nu = m.nu.unwrap_or(e / (2.0 * g) - 1.0);
            // Three constants that contradict each other are kept as the solver keeps them.
            if (g / (e / (2.0 * (1.0 + nu))) - 1.0).abs() > 1e-3 {
                values.items.push(("E1".into(), importer.stress(e)));
                values.items.push(("E2".into(), importer.stress(e)));
                values.items.push(("nu12".into(), computed(nu)));
                for key in ["G12", "G13", "G23"] {
                    values.items.push((key.into(), importer.stress(g)));
                }
                return Ok(());
            }
            if material.is_blank(3) {
                values.items.push(("E".into(), importer.stress(e)));
            } else {
                importer.put(values, ("E", "E"), (material, 3, "E"), e, stress);
            }
            if material.is_blank(5) {
                values.items.push(("nu".into(), computed(nu)));
            } else {
                importer.put(values, ("nu", "nu"), (material, 5, "NU"), nu, (Q::Number, 1.0));
            }
        }
        "MAT8" => {
            let real = |n: usize, name| material.real(n, name);
            let (e1, e2, nu12) = (real(3, "E1")?, real(4, "E2")?, material.real_or(5, "NU12", 0.0)?);
            let g12 = real(6, "G12")?;
            importer.put(values, ("E1", "E1"), (material, 3, "E1"), e1, stress);
            importer.put(values, ("E2", "E2"), (material, 4, "E2"), e2, stress);
            importer.put(values, ("nu12", "nu12"), (material, 5, "NU12"), nu12, (Q::Number, 1.0));
            importer.put(values, ("G12", "G12"), (material, 6, "G12"), g12, stress);
            for (n, key, name) in [(7, "G13", "G1Z"), (8, "G23", "G2Z")] {
                match material.optional_real(n, name)?.filter(|g| *g > 0.0) {
                    Some(g) => importer.put(values, (key, key), (material, n, name), g, stress),
                    None => {
                        importer.report.approximate("MAT8 without transverse shear moduli have G12 there");
                        values.items.push((key.into(), importer.stress(g12)));
                    }
                }
            }
        }
        _ => {
            let [e1, e2, nu12, g12] = sheet(material)?;
            for (key, value) in [("E1", e1), ("E2", e2)] {
                values.items.push((key.into(), importer.stress(value)));
            }
            values.items.push(("nu12".into(), computed(nu12)));
            for key in ["G12", "G13", "G23"] {
                values.items.push((key.into(), importer.stress(g12)));
            }
            importer.report.approximate("shells of MAT2 have its G33 as transverse shear moduli");
        }
    }
    Ok(())
}
