//! Laminates: PCOMP and PCOMPG as plies of a section.

use super::flat::{ShellSection, elastic, lumped, non_structural, numbers};
use super::importer::{Importer, Space, Values};
use super::materials::{density, density_of};
use crate::imported::Bound;
use crate::system::Quantity as Q;
use crate::text::{computed, list, map};
use retune::deck::{Card, DeckError};
use retune::model::{Ply, sums};

/// A ply of a card, and the fields that are its own.
#[derive(Debug, Clone, Copy, PartialEq)]
struct PlyOf {
    mid: u32,
    thickness: f64,
    /// Degrees.
    theta: f64,
    /// Field of the thickness; that of the angle stands behind it.
    field: usize,
}

/// What LAM makes of the plies.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    /// They lie as given, or are the lower half.
    Stacked { symmetric: bool },
    /// All over the thickness, without an order.
    Smeared,
    /// The membrane alone.
    Membrane,
}

fn kind(property: &Card<'_>) -> Result<Kind, DeckError> {
    let at = Some((9, "LAM"));
    Ok(match property.text(9).to_uppercase().as_str() {
        "" => Kind::Stacked { symmetric: false },
        "SYM" if property.name() == "PCOMP" => Kind::Stacked { symmetric: true },
        "SMEAR" => Kind::Smeared,
        "MEM" => Kind::Membrane,
        "BEND" => return Err(property.error(at, "a laminate that bends and has no membrane is not read")),
        "SMCORE" => {
            return Err(property.error(at, "faces smeared about a core are not read; give the plies in their order"));
        }
        other => {
            let text = format!("`{}` where SYM, MEM, BEND, SMEAR, SMCORE or nothing is expected", other.escape_debug());
            return Err(property.error(at, text));
        }
    })
}

/// The plies; material and thickness of the one before hold where fields are empty.
fn plies(property: &Card<'_>) -> Result<Vec<PlyOf>, DeckError> {
    // A line has two plies of four fields, or one with a number of its own in front.
    let (first, stride) = if property.name() == "PCOMP" { (10, 4) } else { (11, 8) };
    let mut plies: Vec<PlyOf> = Vec::new();
    for n in (first..=property.len()).step_by(stride) {
        if (n..n + 3).all(|k| property.is_blank(k)) {
            continue;
        }
        let last = plies.last().copied();
        let mid = match (property.optional_id(n, "MID")?, last) {
            (None, Some(last)) => last.mid,
            (mid, _) => mid.map_or_else(|| property.id_at(n, "MID"), Ok)?,
        };
        let thickness = match (property.optional_real(n + 1, "T")?, last) {
            (None, Some(last)) => last.thickness,
            (t, _) => t.map_or_else(|| property.real(n + 1, "T"), Ok)?,
        };
        if thickness.is_nan() || thickness <= 0.0 {
            return Err(property.error(Some((n + 1, "T")), "the thickness must be above zero"));
        }
        let theta = property.real_or(n + 2, "THETA", 0.0)?;
        plies.push(PlyOf { mid, thickness, theta, field: n + 1 });
    }
    if plies.is_empty() { Err(property.error(Some((first, "MID")), "it has no plies")) } else { Ok(plies) }
}

/// The section of a laminate, made when it is first asked for.
pub(super) fn section<'a>(importer: &mut Importer<'a>, property: &Card<'a>) -> Result<ShellSection, DeckError> {
    let (kind, plies) = (kind(property)?, plies(property)?);
    let mut materials: Vec<(u32, Card<'a>)> = Vec::new();
    for ply in &plies {
        if !materials.iter().any(|m| m.0 == ply.mid) {
            let at = Some((ply.field - 1, "MID"));
            let found = importer.find(Space::Material, ply.mid);
            let found = found.ok_or_else(|| property.error(at, format_args!("there is no material {}", ply.mid)))?;
            if !matches!(found.name(), "MAT1" | "MAT2" | "MAT8") {
                let text = format!("material {} is a {}, and MAT1, MAT2 or MAT8 is expected", ply.mid, found.name());
                return Err(property.error(at, text));
            }
            materials.push((ply.mid, found));
        }
    }
    let is_isotropic = materials.iter().all(|m| m.1.name() == "MAT1");
    let is_designed = plies.iter().any(|p| [p.field, p.field + 1].iter().any(|f| importer.is_designed(property, *f)));
    let is_one = materials.len() == 1
        && (is_isotropic || plies.iter().all(|p| p.theta == plies[0].theta))
        && (plies.len() == 1 || !is_designed);
    let twice = if kind == (Kind::Stacked { symmetric: true }) { 2.0 } else { 1.0 };
    let total = twice * plies.iter().map(|p| p.thickness).sum::<f64>();
    let offset = offset(importer, property, &plies, twice)?;
    // One plate, not one of plies: of one material and angle.
    let is_plain = is_one && matches!(kind, Kind::Stacked { .. });
    let name = importer.section(property, "shell", |importer| {
        let mut values = Values::default();
        if is_plain {
            elastic(importer, &materials[0].1, &mut values)?;
            match &plies[..] {
                [only] => importer.put(
                    &mut values,
                    ("thickness", "thickness"),
                    (property, only.field, "T"),
                    only.thickness,
                    (Q::Length, twice),
                ),
                _ => values.items.push(("thickness".into(), importer.length(total))),
            }
            density(importer, &materials[0].1, &mut values)?;
        } else if let Kind::Stacked { symmetric } = kind {
            stacked(importer, (property, &plies, symmetric), &materials, &mut values)?;
        } else {
            smeared(importer, &plies, &materials, kind, &mut values)?;
        }
        let nsm = property.real_or(4, "NSM", 0.0)?;
        non_structural(importer, &mut values, (property, 4), nsm);
        if !offset.is_empty() {
            values.items.push(("offset".into(), offset.clone()));
        }
        lumped(importer, &mut values);
        Ok(values)
    })?;
    // Plies of a plain plate are turned on the elements.
    let ply_angle = if is_plain { plies[0].theta.to_radians() } else { 0.0 };
    let is_directed = !is_isotropic;
    Ok(ShellSection { name, is_directed, ply_angle, offset, thickness: Some(total) })
}

/// From the grids to the mid-surface: Z0 goes to the lower side.
fn offset(importer: &Importer<'_>, property: &Card<'_>, plies: &[PlyOf], twice: f64) -> Result<String, DeckError> {
    let Some(z0) = property.optional_real(3, "Z0")? else { return Ok(String::new()) };
    let mut parts = vec![((property, 3), z0, 1.0)];
    parts.extend(plies.iter().map(|p| ((property, p.field), p.thickness, 0.5 * twice)));
    let sum: f64 = parts.iter().map(|p| p.1 * p.2).sum();
    let size: f64 = plies.iter().map(|p| p.thickness).sum();
    if sum.abs() < 1e-12 * size && !parts.iter().any(|p| importer.is_designed(property, p.0.1)) {
        return Ok(String::new());
    }
    Ok(importer.sum(&parts, Q::Length))
}

/// Plies one above the other.
fn stacked<'a>(
    importer: &mut Importer<'a>,
    (property, plies, symmetric): (&Card<'a>, &[PlyOf], bool),
    materials: &[(u32, Card<'a>)],
    values: &mut Values,
) -> Result<(), DeckError> {
    let word = |(mid, card): &(u32, Card<'a>)| format!("{}_{mid}", card.name().to_lowercase());
    let mut of_materials = Vec::new();
    for material in materials {
        let mut own = Values::default();
        elastic(importer, &material.1, &mut own)?;
        if density(importer, &material.1, &mut own)?.is_none() {
            own.items.push(("density".into(), "0".into()));
        }
        let word = word(material);
        let renamed = |b: Bound| Bound { property: format!("materials.{word}.{}", b.property), ..b };
        values.bounds.extend(own.bounds.into_iter().map(renamed));
        of_materials.push((word, map(&own.items)));
    }
    let mut all = Vec::new();
    for (i, ply) in plies.iter().enumerate() {
        let mut own = Values::default();
        let (angle, thickness) = (format!("plies[{i}].angle"), format!("plies[{i}].thickness"));
        importer.put(&mut own, ("angle", &angle), (property, ply.field + 1, "THETA"), ply.theta, (Q::Angle, 1.0));
        importer.put(&mut own, ("thickness", &thickness), (property, ply.field, "T"), ply.thickness, (Q::Length, 1.0));
        if let Some(material) = materials.iter().find(|m| m.0 == ply.mid).filter(|_| materials.len() > 1) {
            own.items.push(("material".into(), word(material)));
        }
        values.bounds.extend(own.bounds);
        all.push(map(&own.items));
    }
    let mut laminate = vec![("materials", map(&of_materials)), ("plies", list(&all))];
    if symmetric {
        laminate.push(("symmetric", "true".to_string()));
    }
    values.items.push(("shape".into(), format!("{{laminate: {}}}", map(&laminate))));
    Ok(())
}

/// Plies without an order: A = Σ Q̄ t, D = A t²/12, no coupling.
fn smeared(
    importer: &mut Importer<'_>,
    plies: &[PlyOf],
    materials: &[(u32, Card<'_>)],
    kind: Kind,
    values: &mut Values,
) -> Result<(), DeckError> {
    let stress = importer.options.system.factor(Q::Stress);
    let mut all = Vec::new();
    for ply in plies {
        let Some((_, card)) = materials.iter().find(|m| m.0 == ply.mid) else { continue };
        let [e1, e2, nu12, g12, g13, g23] = numbers(card)?.map(|v| v * stress);
        all.push(Ply {
            e1,
            e2,
            nu12: nu12 / stress,
            g12,
            g13,
            g23,
            density: density_of(card)?.unwrap_or(0.0) * importer.wtmass * importer.options.system.factor(Q::Density),
            angle: ply.theta.to_radians(),
            thickness: ply.thickness * importer.options.system.factor(Q::Length),
        });
    }
    let (abd, [mass, ..]) = sums(&all);
    let total: f64 = all.iter().map(|p| p.thickness).sum();
    let bends = if kind == Kind::Membrane { 1e-6 } else { 1.0 } * total * total / 12.0;
    let entries = [("11", 0, 0), ("12", 0, 1), ("16", 0, 2), ("22", 1, 1), ("26", 1, 2), ("66", 2, 2)];
    for (letter, factor, unit) in [("A", 1.0, "N/m"), ("D", bends, "N m")] {
        for (index, i, j) in entries {
            values.items.push((format!("{letter}{index}"), format!("{} {unit}", computed(abd[(i, j)] * factor))));
        }
    }
    let mut shear = [0.0; 3];
    for ply in &all {
        let (s, c) = ply.angle.sin_cos();
        let of = [ply.g13 * c * c + ply.g23 * s * s, (ply.g13 - ply.g23) * c * s, ply.g13 * s * s + ply.g23 * c * c];
        shear.iter_mut().zip(of).for_each(|(sum, g)| *sum += 5.0 / 6.0 * g * ply.thickness);
    }
    for (key, value) in ["S55", "S45", "S44"].into_iter().zip(shear) {
        values.items.push((key.into(), format!("{} N/m", computed(value))));
    }
    values.items.push(("areal_mass".into(), format!("{} kg/m2", computed(mass))));
    values.items.push(("areal_inertia".into(), format!("{} kg", computed(mass * total * total / 12.0))));
    importer.report.approximate(if kind == Kind::Membrane {
        "laminates without bending (LAM MEM) have a millionth of it"
    } else {
        "smeared laminates (LAM SMEAR) have 5/6 of the transverse shear of their plies, where the solver has none"
    });
    Ok(())
}
