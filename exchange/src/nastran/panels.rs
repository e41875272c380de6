//! Shear panels: CSHEAR and PSHEAR.

use super::flat::{lumped, non_structural};
use super::importer::{Importer, Values};
use super::materials::{density, isotropic};
use super::{CardRule, read, used};
use crate::system::Quantity as Q;
use crate::text::map;
use crate::writer::Block;
use retune::deck::{Card, DeckError};
use retune::linalg::vector3::{cross, dot, minus};

pub(super) const CARDS: &[CardRule] = &[read("CSHEAR", "shear panels", panel), used("PSHEAR", "shear panels")];

fn panel<'a>(importer: &mut Importer<'a>, card: &Card<'a>) -> Result<(), DeckError> {
    let property = importer.property(card, 3, &["PSHEAR"])?;
    let mut grids = Vec::new();
    for i in 0..4 {
        grids.push(importer.grid(card, 4 + i, "G")?);
    }
    let thickness = property.real(4, "T")?;
    if thickness.is_nan() || thickness <= 0.0 {
        return Err(property.error(Some((4, "T")), "the thickness must be above zero"));
    }
    let material = importer.material(&property, 3, &["MAT1"])?;
    let section = importer.section(&property, "panel", |importer| {
        let mut values = Values::default();
        shear_modulus(importer, &material, &mut values)?;
        importer.put(&mut values, ("thickness", "thickness"), (&property, 4, "T"), thickness, (Q::Length, 1.0));
        density(importer, &material, &mut values)?;
        let nsm = property.real_or(5, "NSM", 0.0)?;
        if nsm < 0.0 {
            return Err(property.error(Some((5, "NSM")), "it must not be negative"));
        }
        non_structural(importer, &mut values, (&property, 5), nsm);
        lumped(importer, &mut values);
        Ok(values)
    })?;
    let factors = [property.real_or(6, "F1", 0.0)?, property.real_or(7, "F2", 0.0)?];
    for (factor, at) in factors.into_iter().zip([(6, "F1"), (7, "F2")]) {
        if factor.is_nan() || factor < 0.0 {
            return Err(property.error(Some(at), "it must not be negative"));
        }
    }
    let points: Vec<[f64; 3]> = grids.iter().map(|g| g.1.position).collect();
    let name = |i: usize| grids[i].0.as_str();
    let both = (property, section);
    let is_one = factors == [0.0; 2];
    let mut part = 0;
    let mut number = || {
        part += 1;
        (!is_one).then_some(part - 1)
    };
    let mut values = Values::default();
    values.items.push(("type".into(), "shear_panel".into()));
    values.items.push(("nodes".into(), format!("[{}, {}, {}, {}]", name(0), name(1), name(2), name(3))));
    values.items.push(("section".into(), both.1.clone()));
    let (property, section) = (&both.0, both.1.as_str());
    importer.part(Block::Elements, card, values, (Some(property), Some(section)), number())?;
    // What the panel carries along its edges: rods at each side of a pair, 12 and 34 or 23 and 41.
    let length = |[i, j]: [usize; 2]| {
        let d = minus(points[j], points[i]);
        dot(d, d).sqrt()
    };
    let normal = cross(minus(points[2], points[0]), minus(points[3], points[1]));
    let area = 0.5 * dot(normal, normal).sqrt();
    for (factor, sides) in factors.into_iter().zip([[[0, 1], [2, 3]], [[1, 2], [3, 0]]]) {
        if factor == 0.0 {
            continue;
        }
        // Up to 1.01 it is the share of the panel that is effective, above a width in thicknesses.
        let width = if factor <= 1.01 {
            factor * area / (length(sides[0]) + length(sides[1]))
        } else {
            0.5 * factor * thickness
        };
        if factor > 1.01 && importer.is_designed(property, 4) {
            return Err(property.error(
                Some((4, "T")),
                "a thickness that design variables move gives edges whose areas go with its square; give F1 and F2 up to 1.01",
            ));
        }
        for side in sides {
            let mut own = Values::default();
            let modulus = isotropic(&material)?.e;
            let modulus = modulus.ok_or_else(|| material.error(Some((3, "E")), "edges of a panel need E"))?;
            if material.is_blank(3) {
                own.items.push(("E".into(), importer.stress(modulus)));
            } else {
                importer.put(&mut own, ("E", "E"), (&material, 3, "E"), modulus, (Q::Stress, 1.0));
            }
            importer.put(&mut own, ("A", "A"), (property, 4, "T"), thickness, (Q::Area, width));
            let mut values = Values::default();
            values.items.push(("type".into(), "bar".into()));
            values.items.push(("nodes".into(), format!("[{}, {}]", name(side[0]), name(side[1]))));
            values.items.push(("properties".into(), map(&own.items)));
            values.bounds = own.bounds;
            importer.part(Block::Elements, card, values, (Some(property), None), number())?;
        }
    }
    Ok(())
}

/// G of a material, from its own field or that of E.
fn shear_modulus(importer: &Importer<'_>, material: &Card<'_>, values: &mut Values) -> Result<(), DeckError> {
    let m = isotropic(material)?;
    let g = m.g.ok_or_else(|| material.error(Some((4, "G")), "a shear panel needs G, or E and NU"))?;
    match (m.g_is_given, m.e, m.nu) {
        (false, Some(e), Some(nu)) => {
            let factor = 1.0 / (2.0 * (1.0 + nu));
            importer.put(values, ("G", "G"), (material, 3, "E"), e, (Q::Stress, factor));
        }
        _ => importer.put(values, ("G", "G"), (material, 4, "G"), g, (Q::Stress, 1.0)),
    }
    if let Some(nu) = m.nu.filter(|nu| *nu > -1.0 && *nu <= 0.5) {
        if material.is_blank(5) {
            values.items.push(("nu".into(), crate::text::computed(nu)));
        } else {
            importer.put(values, ("nu", "nu"), (material, 5, "NU"), nu, (Q::Number, 1.0));
        }
    }
    Ok(())
}
