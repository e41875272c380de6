//! Laminates of shells: the data lines of a COMPOSITE section.

use super::elastic::Material;
use super::importer::{Importer, Values, word};
use super::scopes::At;
use crate::motions::angle_from_global;
use crate::system::Quantity as Q;
use crate::text::{computed, list, map};
use retune::deck::{DataLine, DeckError, Keyword, label};
use retune::linalg::vector3::{cross, minus, unit};
use std::f64::consts::{PI, TAU};

/// How the first direction of a ply lies.
#[derive(Debug, Clone, PartialEq)]
enum Turn {
    /// From that of the section, degrees.
    By(f64),
    /// Along an ORIENTATION of this name.
    Along(String),
}

#[derive(Debug, Clone, PartialEq)]
struct PlyOf {
    material: String,
    thickness: f64,
    turn: Turn,
    /// Its data line.
    line: usize,
}

/// The plies of a section, from the side opposite to the normal.
pub(super) struct LayUp {
    plies: Vec<PlyOf>,
    /// Of a symmetric laminate one half is given.
    symmetric: bool,
}

/// A direction, and how far the material is turned from it, rad.
type Direction = ([f64; 3], f64);

/// A thickness, which must be above zero.
pub(super) fn thickness(line: &DataLine<'_>, i: usize) -> Result<f64, DeckError> {
    let t = line.real(i, "thickness")?;
    if t > 0.0 { Ok(t) } else { Err(line.error(Some((i, "thickness")), "it must be above zero")) }
}

/// The normal of three or four corners.
pub(super) fn normal(p: &[[f64; 3]]) -> Option<[f64; 3]> {
    unit(match p.len() {
        4 => cross(minus(p[2], p[0]), minus(p[3], p[1])),
        _ => cross(minus(p[1], p[0]), minus(p[2], p[0])),
    })
}

/// Where the material lies without an ORIENTATION: global x, or z where x is within 0.1 degrees of the normal.
pub(super) fn default_direction(normal: [f64; 3]) -> [f64; 3] {
    if normal[0].abs() < 0.1_f64.to_radians().cos() { [1.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] }
}

/// A name for a kind of section with its own angles of plies.
pub(super) fn variant(kind: &str, angles: &[f64]) -> String {
    angles.iter().fold(kind.to_string(), |name, a| format!("{name} {a:.9}"))
}

/// Reads thickness, points (which do not matter), material, angle or orientation of each ply.
pub(super) fn read(k: &Keyword<'_>) -> Result<LayUp, DeckError> {
    let mut plies = Vec::new();
    for (i, line) in k.lines().enumerate().filter(|l| !l.1.is_empty()) {
        let turn = match line.text(3) {
            "" => Turn::By(0.0),
            text if text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) => {
                Turn::By(line.real(3, "angle")?)
            }
            text => Turn::Along(label(text)),
        };
        plies.push(PlyOf { material: label(line.text(2)), thickness: thickness(&line, 0)?, turn, line: i });
    }
    if plies.is_empty() {
        return Err(k.error("it has no plies"));
    }
    Ok(LayUp { plies, symmetric: k.parameter("SYMMETRIC").is_some() })
}

impl LayUp {
    pub(super) fn thickness(&self) -> f64 {
        let given: f64 = self.plies.iter().map(|p| p.thickness).sum();
        if self.symmetric { 2.0 * given } else { given }
    }

    /// The material and the angle, rad, where all plies have the same: they make one plate.
    pub(super) fn one(&self, importer: &Importer<'_>, k: &Keyword<'_>) -> Result<Option<(Material, f64)>, DeckError> {
        let first = &self.plies[0];
        let mut is_one = true;
        for ply in &self.plies {
            importer.material_of(k, &ply.material)?;
            is_one &= ply.material == first.material;
        }
        let material = importer.material_of(k, &first.material)?;
        let is_isotropic = material.elastic.is_some_and(|e| e.is_isotropic());
        Ok(match first.turn {
            _ if !is_one => None,
            _ if is_isotropic => Some((material, 0.0)),
            Turn::By(angle) if self.plies.iter().all(|p| p.turn == first.turn) => Some((material, angle.to_radians())),
            _ => None,
        })
    }

    /// Angles of the plies of an element from the first direction of its section, rad, to nine decimals.
    ///
    /// * `base` - the direction of the section; the default one where there is none
    pub(super) fn angles(
        &self,
        importer: &Importer<'_>,
        k: &Keyword<'_>,
        (instance, at): (u32, At),
        base: Option<Direction>,
    ) -> Result<Vec<f64>, DeckError> {
        let corners = if matches!(importer.kind(at).nodes, 3 | 6) { 3 } else { 4 };
        let points = importer.points(at);
        let normal = normal(&points[..corners]).ok_or_else(|| importer.at_element(at, "its nodes span no area"))?;
        let (direction, more) = base.unwrap_or_else(|| (default_direction(normal), 0.0));
        let zero = angle_from_global(normal, direction) + more;
        let mut out = Vec::with_capacity(self.plies.len());
        for ply in &self.plies {
            let angle = match &ply.turn {
                Turn::By(degrees) => degrees.to_radians(),
                Turn::Along(name) => {
                    let o = importer.orientation(k, instance, name)?;
                    let (along, more) = o.on_shell(importer.centre(at), importer.options.solver);
                    let turned = angle_from_global(normal, along) + more - zero;
                    let whole = (turned + PI).rem_euclid(TAU) - PI;
                    // Where it lies is a matter of rounding there.
                    let decimals = (whole * 1e9).round() / 1e9;
                    if decimals <= -PI { decimals + TAU } else { decimals }
                }
            };
            out.push(angle);
        }
        Ok(out)
    }

    /// Writes the shape of the section.
    ///
    /// * `angles` - of the plies, rad
    /// * `has_mass` - whether the densities of the materials count
    pub(super) fn write(
        &self,
        importer: &Importer<'_>,
        k: &Keyword<'_>,
        angles: &[f64],
        has_mass: bool,
        values: &mut Values,
    ) -> Result<(), DeckError> {
        let mut words: Vec<(&str, String)> = Vec::new();
        let mut materials = Vec::new();
        for ply in &self.plies {
            if words.iter().any(|w| w.0 == ply.material) {
                continue;
            }
            let plain = word(&ply.material, "material");
            let is_taken = |w: &str| words.iter().any(|known| known.1 == w);
            let own = (2..=self.plies.len() + 1).map(|n| format!("{plain}_{n}")).find(|w| !is_taken(w));
            let word = own.filter(|_| is_taken(&plain)).unwrap_or(plain);
            let mut material = importer.material_of(k, &ply.material)?;
            if !has_mass {
                (material.density, material.density_at) = (None, None);
            }
            let mut items: Values = Vec::new();
            importer.below(&format!("materials.{word}"), || importer.elastic(k, &material, true, &mut items))?;
            if !items.iter().any(|i| i.0 == "density") {
                items.push(("density".into(), "0".into()));
            }
            materials.push((word.clone(), map(&items)));
            words.push((&ply.material, word));
        }
        let mut plies = Vec::new();
        for (i, (ply, angle)) in self.plies.iter().zip(angles).enumerate() {
            let shown = match ply.turn {
                Turn::By(degrees) => {
                    if k.line(ply.line).is_some_and(|l| !l.text(3).is_empty()) {
                        importer.bind(&format!("plies[{i}].angle"), (k.index(), ply.line, 3), Q::Angle);
                    }
                    importer.with(degrees, Q::Angle)
                }
                Turn::Along(_) => format!("{} rad", computed(*angle)),
            };
            importer.bind(&format!("plies[{i}].thickness"), (k.index(), ply.line, 0), Q::Length);
            let mut items = vec![("angle", shown), ("thickness", importer.with(ply.thickness, Q::Length))];
            if words.len() > 1 {
                let own = words.iter().find(|w| w.0 == ply.material).map_or_else(String::new, |w| w.1.clone());
                items.push(("material", own));
            }
            plies.push(map(&items));
        }
        let mut laminate = vec![("materials", map(&materials)), ("plies", list(&plies))];
        if self.symmetric {
            laminate.push(("symmetric", "true".to_string()));
        }
        values.push(("shape".into(), format!("{{laminate: {}}}", map(&laminate))));
        Ok(())
    }
}
