//! Plates and shells.

use super::flat::{ShellSection, elastic, lumped, non_structural};
use super::importer::{Importer, Values};
use super::materials::{density, isotropic};
use super::{CardRule, laminates, read, refused, sandwiches, used};
use crate::coord::Coord;
use crate::imported::Bound;
use crate::listed::round_above;
use crate::motions::angle_from_global;
use crate::patches::{self, Patch};
use crate::system::Quantity as Q;
use crate::text::{computed, map};
use crate::writer::Block;
use retune::deck::{Card, DeckError};
use retune::linalg::vector3::{cross, minus, unit};

pub(super) const CARDS: &[CardRule] = &[
    read("CQUAD4", "shells", shell),
    read("CTRIA3", "shells", shell),
    read("CQUADR", "shells", shell),
    read("CTRIAR", "shells", shell),
    read("CQUAD8", "shells", quadratic),
    read("CTRIA6", "shells", quadratic),
    used("PSHELL", "shells"),
    used("PCOMP", "shells"),
    used("PCOMPG", "shells"),
    refused("CQUAD", "hyperelastic plane elements are not read"),
    refused("CTRIAX", "axisymmetric elements are not read"),
    refused("CTRIAX6", "axisymmetric elements are not read"),
    refused("CQUADX", "axisymmetric elements are not read"),
    refused("CONEAX", "axisymmetric elements are not read"),
    refused("PLPLANE", "hyperelastic plane elements are not read"),
];

fn shell<'a>(importer: &mut Importer<'a>, card: &Card<'a>) -> Result<(), DeckError> {
    let count = if card.name().starts_with("CQUAD") { 4 } else { 3 };
    let first = 12;
    let plain: Patch = if count == 4 { &[("shell4", &[0, 1, 2, 3])] } else { &[("shell3", &[0, 1, 2])] };
    write(importer, card, count, (plain, count), [4 + count, 5 + count, first])
}

/// CQUAD8 and CTRIA6: a patch on all of their grids, one flat shell where those of the edges are left out.
fn quadratic<'a>(importer: &mut Importer<'a>, card: &Card<'a>) -> Result<(), DeckError> {
    let corners = if card.name() == "CQUAD8" { 4 } else { 3 };
    let given = (0..corners).filter(|i| !matches!(card.text(4 + corners + i), "" | "0")).count();
    // Quadrilaterals have their thicknesses before the direction of the material, triangles behind it.
    let fields = if corners == 4 { [16, 17, 12] } else { [10, 11, 12] };
    let (patch, count): (Patch, usize) = match (corners, given) {
        (4, 4) => (patches::QUADRILATERAL, 8),
        (3, 3) => (patches::TRIANGLE, 6),
        (4, 0) => (&[("shell4", &[0, 1, 2, 3])], 4),
        (3, 0) => (&[("shell3", &[0, 1, 2])], 3),
        // A side without its grid is straight.
        _ => return some_edges(importer, card, corners, fields),
    };
    importer.report.approximate(patches::DIFFERS);
    write(importer, card, corners, (patch, count), fields)
}

impl Importer<'_> {
    /// The node in the middle of a shell of eight grids, which the deck has not: its number is above those of all grids.
    fn middle_of(&mut self, card: &Card<'_>, at: [f64; 3]) -> Result<String, DeckError> {
        let above = match self.above {
            Some(above) => above,
            None => round_above(self.grids.keys().max().map_or(0, |n| u64::from(*n))).unwrap_or_default(),
        };
        self.above = Some(above);
        let name = format!("n{}", above + u64::from(card.id_at(2, "EID")?));
        let place = self.lengths(at);
        self.out.node(&name, &place, Some(at), patches::CENTRE);
        Ok(name)
    }
}

/// A fan of triangles around the first edge that has a grid: from there every other corner and edge is in sight.
fn some_edges<'a>(
    importer: &mut Importer<'a>,
    card: &Card<'a>,
    corners: usize,
    fields: [usize; 3],
) -> Result<(), DeckError> {
    let has = |i: usize| !matches!(card.text(4 + corners + i), "" | "0");
    let ring: Vec<usize> = (0..corners).flat_map(|i| std::iter::once(i).chain(has(i).then_some(corners + i))).collect();
    let first = ring.iter().position(|i| *i >= corners).unwrap_or(0);
    let n = ring.len();
    let around = |k: usize| ring[(first + k) % n];
    let fan: Vec<[usize; 3]> = (1..n - 1).map(|k| [around(0), around(k), around(k + 1)]).collect();
    let patch: Vec<(&str, &[usize])> = fan.iter().map(|t| ("shell3", &t[..])).collect();
    importer.report.approximate(patches::DIFFERS);
    write(importer, card, corners, (&patch, 2 * corners), fields)
}

/// * `patch` - what the card becomes, and the number of its grids
/// * `fields` - of the direction of the material, the offset, the first thickness at a corner
fn write<'a>(
    importer: &mut Importer<'a>,
    card: &Card<'a>,
    corners: usize,
    (patch, n_grids): (&[(&str, &[usize])], usize),
    [theta, offset, first]: [usize; 3],
) -> Result<(), DeckError> {
    let property = importer.property(card, 3, &["PSHELL", "PCOMP", "PCOMPG"])?;
    let is_used = |i: usize| patch.iter().any(|p| p.1.contains(&i));
    let mut grids = Vec::new();
    for i in 0..n_grids {
        // What no part of the patch has is not there.
        grids.push(importer.grid(card, if is_used(i) { 4 + i } else { 4 }, "G")?);
    }
    let section = section(importer, &property)?;
    let mut points: Vec<[f64; 3]> = grids.iter().map(|g| g.1.position).collect();
    let mut names: Vec<String> = grids.into_iter().map(|g| g.0).collect();
    if is_used(n_grids) {
        let middle = patches::centre(&points);
        names.push(importer.middle_of(card, middle)?);
        points.push(middle);
    }
    let normal_of = |at: &[usize]| {
        let p: Vec<[f64; 3]> = at.iter().map(|i| points[*i]).collect();
        let normal = match p.len() {
            4 => cross(minus(p[2], p[0]), minus(p[3], p[1])),
            _ => cross(minus(p[1], p[0]), minus(p[2], p[0])),
        };
        unit(normal).ok_or_else(|| card.error(None, "its grids span no area"))
    };
    let zoffs = card.real_or(offset, "ZOFFS", 0.0)?;
    // A plate that is thicker at one corner has the mean thickness, and so its mass.
    let (mut mean, mut has_corners) = (0.0, false);
    for n in first..first + corners {
        let stated = card.optional_real(n, "T")?;
        has_corners |= stated.is_some();
        let is_factor = corners == n_grids && card.integer_or(first - 1, "TFLAG", 0)? != 0;
        let own = section.thickness.unwrap_or(0.0);
        let t = stated.map_or(own, |t| if is_factor { t * own } else { t });
        if t < 0.0 {
            return Err(card.error(Some((n, "T")), "a thickness must not be negative"));
        }
        mean += t / corners as f64;
    }
    let differs = has_corners && mean > 0.0 && section.thickness.is_some_and(|own| (own - mean).abs() > 1e-12 * mean);
    let is_own = differs && !importer.is_designed(&property, 4);
    if differs && !is_own {
        importer
            .report
            .approximate("thicknesses at the corners of shells are left out where the property's is designed");
    } else if is_own {
        importer.report.approximate("shells with thicknesses of their own at their corners have the mean of them");
    } else if has_corners && section.thickness.is_none() {
        importer.report.approximate("thicknesses at the corners of laminates are left out: the plies' hold");
    }
    for (part, (kind, at)) in patch.iter().enumerate() {
        let normal = normal_of(at)?;
        let mut values = Values::default();
        values.items.push(("type".into(), (*kind).into()));
        let nodes: Vec<&str> = at.iter().map(|i| names[*i].as_str()).collect();
        values.items.push(("nodes".into(), format!("[{}]", nodes.join(", "))));
        values.items.push(("section".into(), section.name.clone()));
        let mut own = Vec::new();
        if section.is_directed {
            let base = card.text(theta);
            let side = angle_from_global(normal, minus(points[1], points[0]));
            let degree = 1_f64.to_radians();
            // A THETA may stand in the place of an MCID.
            let (property, shift) = ("angle".to_string(), side + section.ply_angle);
            values.bounds.push(Bound { property, card: card.id(), field: theta, name: "THETA", factor: degree, shift });
            let angle = if base.is_empty() || base.contains('.') {
                side + card.real_or(theta, "THETA", 0.0)?.to_radians()
            } else {
                let (_, coord): (u32, Coord) = importer.coord(card, theta, "MCID")?;
                angle_from_global(normal, coord.axes_at(points[0])[0])
            };
            own.push(("angle".to_string(), format!("{} rad", computed(angle + section.ply_angle))));
        }
        if is_own {
            own.push(("thickness".to_string(), importer.length(mean)));
            // No one field holds it.
            let property = "thickness".to_string();
            values.bounds.push(Bound { property, card: card.id(), field: 0, name: "T", factor: 1.0, shift: 0.0 });
        }
        if zoffs != 0.0 {
            let beside = match (section.offset.as_str(), zoffs < 0.0) {
                ("", _) => importer.length(zoffs),
                (own, true) => format!("{own} - {}", importer.length(-zoffs)),
                (own, false) => format!("{own} + {}", importer.length(zoffs)),
            };
            own.push(("offset".to_string(), beside));
        }
        if !own.is_empty() {
            values.items.push(("properties".into(), map(&own)));
        }
        let of = (patch.len() > 1).then_some(part);
        importer.part(Block::Elements, card, values, (Some(&property), Some(&section.name)), of)?;
    }
    Ok(())
}

fn section<'a>(importer: &mut Importer<'a>, property: &Card<'a>) -> Result<ShellSection, DeckError> {
    if property.name() != "PSHELL" {
        return laminates::section(importer, property);
    }
    let thickness = property.optional_real(4, "T")?;
    let at = |importer: &Importer<'a>| importer.material(property, 3, &["MAT1", "MAT8", "MAT2"]);
    if let Some(other) = sandwiches::section(importer, property)? {
        return Ok(other);
    }
    let material = at(importer)?;
    let name = importer.section(property, "shell", |importer| {
        let t = property.real(4, "T")?;
        if t <= 0.0 {
            return Err(property.error(Some((4, "T")), "the thickness must be above zero"));
        }
        let mid1 = property.id_at(3, "MID1")?;
        let mut values = Values::default();
        elastic(importer, &material, &mut values)?;
        importer.put(&mut values, ("thickness", "thickness"), (property, 4, "T"), t, (Q::Length, 1.0));
        // Another material bends or shears as the plate's own times the ratio of the moduli: the face sheets and the core of a sandwich.
        let of =
            |importer: &mut Importer<'a>, field: usize, name: &'static str| -> Result<Option<[f64; 2]>, DeckError> {
                let Some(other) = property.optional_id(field, name)? else { return Ok(None) };
                if other == mid1 {
                    return Ok(Some([1.0; 2]));
                }
                let ratio = importer.ratio(mid1, other);
                let text = "another material is read where both are isotropic (MAT1)";
                ratio.map(Some).ok_or_else(|| property.error(Some((field, name)), text))
            };
        let membrane_only = property.text(5) == "-1" || property.is_blank(5);
        let bending = if membrane_only { None } else { of(importer, 5, "MID2")? };
        match bending {
            Some([plate, _]) => {
                let factor = property.real_or(6, "12I/T**3", 1.0)?;
                if factor <= 0.0 {
                    return Err(property.error(Some((6, "12I/T**3")), "it must be above zero"));
                }
                if plate != 1.0 {
                    values.items.push(("bending_factor".into(), computed(factor * plate)));
                } else if factor != 1.0 {
                    let from = (property, 6, "12I/T**3");
                    importer.put(&mut values, ("bending_factor", "bending_factor"), from, factor, (Q::Number, 1.0));
                }
            }
            None => {
                // A membrane: what bends it is next to nothing.
                values.items.push(("bending_factor".into(), "1e-6".into()));
                importer.report.approximate("shells without bending (MID2 empty) have a millionth of it");
            }
        }
        match of(importer, 7, "MID3")? {
            None => importer.report.approximate(
                "shells without transverse shear (MID3 empty) have the 5/6 of a solid plate: softer by (t/length)²",
            ),
            Some([_, shear]) => {
                let factor = property.real_or(8, "TS/T", 5.0 / 6.0)?;
                if factor <= 0.0 {
                    return Err(property.error(Some((8, "TS/T")), "it must be above zero"));
                }
                if shear != 1.0 {
                    values.items.push(("shear_factor".into(), computed(factor * shear)));
                } else if !property.is_blank(8) {
                    let from = (property, 8, "TS/T");
                    importer.put(&mut values, ("shear_factor", "shear_factor"), from, factor, (Q::Number, 1.0));
                }
            }
        }
        density(importer, &material, &mut values)?;
        let nsm = property.real_or(9, "NSM", 0.0)?;
        if nsm < 0.0 {
            return Err(property.error(Some((9, "NSM")), "it must not be negative"));
        }
        non_structural(importer, &mut values, (property, 9), nsm);
        lumped(importer, &mut values);
        Ok(values)
    })?;
    let is_directed = material.name() != "MAT1";
    Ok(ShellSection { name, is_directed, ply_angle: 0.0, offset: String::new(), thickness })
}

impl Importer<'_> {
    /// Plate modulus E/(1 - nu²) and shear modulus of a material over those of another, both isotropic.
    fn ratio(&mut self, one: u32, other: u32) -> Option<[f64; 2]> {
        let find = |id| {
            let card = self.find(super::importer::Space::Material, id).filter(|m| m.name() == "MAT1")?;
            let m = isotropic(&card).ok()?;
            let (e, g) = (m.e?, m.g?);
            Some((e, g, m.nu.unwrap_or(e / (2.0 * g) - 1.0)))
        };
        let ((e1, g1, nu1), (e2, g2, nu2)) = (find(one)?, find(other)?);
        if (nu1 - nu2).abs() > 1e-3 {
            self.report.approximate("shells whose materials differ in Poisson's ratio bend with that of the membrane");
        }
        let plate = |e: f64, nu: f64| e / (1.0 - nu * nu);
        let ratio = [plate(e2, nu2) / plate(e1, nu1), g2 / g1];
        ratio.iter().all(|r| r.is_finite() && *r > 0.0).then_some(ratio)
    }
}
