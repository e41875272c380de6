//! PSHELL whose membrane, bending, shear and coupling are of different materials: rigidities by their sums.
//!
//! ```text
//! A = Q1 t      D = Q2 (12I/t³) t³/12      S = G3 (ts/t) t      B = Q4 t²      Q: plane stress of MID1, MID2, MID4; G: transverse shear of MID3
//! ```
//!
//! Source: MSC Nastran Quick Reference Guide, PSHELL. The solver's B has the opposite sign of curvature to that of this house's shells.

use super::flat::{ShellSection, lumped, non_structural, numbers};
use super::importer::{Importer, Space, Values};
use super::materials::{density_of, isotropic};
use crate::system::Quantity as Q;
use crate::text::computed;
use retune::deck::{Card, DeckError};

/// Share of the membrane's bending that one without any has.
const NEXT_TO_NOTHING: f64 = 1e-6;

/// The section of a property of several materials; none of one that a material and factors describe.
pub(super) fn section<'a>(importer: &mut Importer<'a>, property: &Card<'a>) -> Result<Option<ShellSection>, DeckError> {
    let fields = [(3, "MID1"), (5, "MID2"), (7, "MID3"), (12, "MID4")];
    let mut materials: Vec<Option<Card<'a>>> = Vec::new();
    for (field, name) in fields {
        let is_none = property.is_blank(field) || (field == 5 && property.text(5) == "-1");
        if is_none {
            materials.push(None);
            continue;
        }
        let id = property.id_at(field, name)?;
        let found = importer.find(Space::Material, id);
        let found =
            found.ok_or_else(|| property.error(Some((field, name)), format_args!("there is no material {id}")))?;
        if !matches!(found.name(), "MAT1" | "MAT2" | "MAT8") {
            let text = format!("material {id} is a {}, and MAT1, MAT2 or MAT8 is expected", found.name());
            return Err(property.error(Some((field, name)), text));
        }
        materials.push(Some(found));
    }
    let [given, bending, shear, coupling] = &materials[..] else { return Ok(None) };
    // A plate that only bends does not move in its plane: nothing holds it there, and AUTOSPC does.
    let Some(membrane) = given.as_ref().or(bending.as_ref()) else {
        return Err(property.error(Some((3, "MID1")), "a shell needs a membrane (MID1) or bends (MID2)"));
    };
    let own = membrane.id();
    let is_own = |m: &Option<Card<'a>>| m.as_ref().is_none_or(|m| m.id() == own);
    let isotropic_all = materials.iter().flatten().all(|m| m.name() == "MAT1");
    // Isotropic ones are ratios of a plate that stays designable.
    let is_one = is_own(bending) && is_own(shear);
    // A sheet that couples stretching with shear has no moduli.
    let mut is_skew = false;
    for material in materials.iter().flatten().filter(|m| m.name() == "MAT2") {
        is_skew |= material.real_or(5, "G13", 0.0)? != 0.0 || material.real_or(7, "G23", 0.0)? != 0.0;
    }
    if given.is_some() && coupling.is_none() && !is_skew && (is_one || isotropic_all) {
        return Ok(None);
    }
    let thickness = property.real(4, "T")?;
    if thickness.is_nan() || thickness <= 0.0 {
        return Err(property.error(Some((4, "T")), "the thickness must be above zero"));
    }
    let inertia = property.real_or(6, "12I/T**3", 1.0)?;
    let share = property.real_or(8, "TS/T", 5.0 / 6.0)?;
    for (value, at) in [(inertia, (6, "12I/T**3")), (share, (8, "TS/T"))] {
        if value.is_nan() || value <= 0.0 {
            return Err(property.error(Some(at), "it must be above zero"));
        }
    }
    let name = importer.section(property, "shell", |importer| {
        let metre = importer.options.system.factor(Q::Length);
        let (t, stress) = (thickness * metre, importer.options.system.factor(Q::Stress));
        let plane = plane_stress(membrane)?;
        let mut values = Values::default();
        let mut put = |letter: &str, q: [f64; 6], factor: f64, unit: &str| {
            for (index, v) in ["11", "12", "16", "22", "26", "66"].into_iter().zip(q) {
                values.items.push((format!("{letter}{index}"), format!("{} {unit}", computed(v * factor * stress))));
            }
        };
        put("A", plane, t, "N/m");
        match bending {
            Some(material) => put("D", plane_stress(material)?, inertia * t.powi(3) / 12.0, "N m"),
            None => put("D", plane, NEXT_TO_NOTHING * t.powi(3) / 12.0, "N m"),
        }
        if let Some(material) = coupling {
            put("B", plane_stress(material)?, -t * t, "N");
        }
        let [along, across] = match shear {
            Some(material) => transverse(material)?,
            None => transverse(membrane)?,
        };
        for (key, g) in [("S55", along), ("S44", across)] {
            values.items.push((key.into(), format!("{} N/m", computed(g * stress * share * t))));
        }
        // Mass is of the membrane's material; where there is none, of the plate's.
        let rho = density_of(membrane)?.unwrap_or(0.0) * importer.wtmass * importer.options.system.factor(Q::Density);
        values.items.push(("areal_mass".into(), format!("{} kg/m2", computed(rho * t))));
        let nsm = property.real_or(9, "NSM", 0.0)?;
        if nsm < 0.0 {
            return Err(property.error(Some((9, "NSM")), "it must not be negative"));
        }
        non_structural(importer, &mut values, (property, 9), nsm);
        lumped(importer, &mut values);
        if given.is_none() {
            importer.report.approximate(
                "plates without membrane (MID1 empty) have that of MID2, in place of AUTOSPC, which holds them in their plane",
            );
        }
        if bending.is_none() {
            importer.report.approximate("shells without bending (MID2 empty) have a millionth of it");
        }
        if shear.is_none() {
            importer.report.approximate(
                "shells without transverse shear (MID3 empty) have the 5/6 of a solid plate: softer by (t/length)²",
            );
        }
        importer.report.note("shells of several materials stand by their rigidities; no parameter moves these");
        Ok(values)
    })?;
    let offset = String::new();
    Ok(Some(ShellSection { name, is_directed: true, ply_angle: 0.0, offset, thickness: Some(thickness) }))
}

/// Q11, Q12, Q16, Q22, Q26, Q66 in the deck's unit; of MAT2 as it stands.
fn plane_stress(material: &Card<'_>) -> Result<[f64; 6], DeckError> {
    if material.name() == "MAT2" {
        let fields = [(3, "G11"), (4, "G12"), (5, "G13"), (6, "G22"), (7, "G23"), (8, "G33")];
        let mut out = [0.0; 6];
        for (slot, (field, name)) in out.iter_mut().zip(fields) {
            *slot = material.real_or(field, name, 0.0)?;
        }
        return Ok(out);
    }
    let [e1, e2, nu12, g12, ..] = numbers(material)?;
    let rest = 1.0 - nu12 * nu12 * e2 / e1;
    if rest.is_nan() || rest <= 0.0 {
        return Err(material.error(None, "its constants are those of no material: not every stress stores energy"));
    }
    Ok([e1 / rest, nu12 * e2 / rest, 0.0, e2 / rest, 0.0, g12])
}

/// Transverse shear moduli along and across, in the deck's unit; of MAT2 its first two stiffnesses, as the solver reads them for MID3.
fn transverse(material: &Card<'_>) -> Result<[f64; 2], DeckError> {
    let [along, across] = match material.name() {
        "MAT2" => [material.real_or(3, "G11", 0.0)?, material.real_or(6, "G22", 0.0)?],
        "MAT1" => {
            let g = isotropic(material)?.g.unwrap_or(0.0);
            [g, g]
        }
        _ => {
            let [.., g13, g23] = numbers(material)?;
            [g13, g23]
        }
    };
    if along > 0.0 && across > 0.0 {
        Ok([along, across])
    } else {
        Err(material.error(None, "its transverse shear moduli must be above zero"))
    }
}
