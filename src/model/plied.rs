//! The numbers that describe the plies of a section, and what they give, at the nominal values of all parameters.

use super::laminate::Ply;
use super::plate::{PLATE, plate};
use super::spec::{LaminateSpec, SectionValue};
use super::{Model, ParametricModel};
use crate::units::{Scalar, Unit};

/// The plies of a section of shells.
pub struct Plied {
    /// Numbers of its description by their paths below `laminate`, SI: `materials.carbon.E1`, `plies[0].angle`.
    pub numbers: Vec<(String, f64)>,
    /// What they give, by property of the shell.
    pub rigidities: Vec<(&'static str, f64)>,
}

/// The plies of a section; none where it has no laminate, or one that is wrong.
pub fn plied(model: &Model, section: &str) -> Option<Plied> {
    let section = model.spec().sections.get(section)?;
    let laminate = section.values().find_map(|v| match v {
        SectionValue::Shape(shape) => shape.laminate.as_ref(),
        SectionValue::Scalar(_) => None,
    })?;
    let mut numbers = Vec::new();
    let materials = numbers_of_materials(model, laminate, &mut numbers)?;
    let mut plies = Vec::new();
    for (i, ply) in laminate.plies.iter().enumerate() {
        let at = match &ply.material {
            Some(name) => laminate.materials.get_index_of(name)?,
            None => 0,
        };
        let (angle, thickness) = (value(model, &ply.angle, "rad")?, value(model, &ply.thickness, "m")?);
        numbers.push((format!("plies[{i}].angle"), angle));
        numbers.push((format!("plies[{i}].thickness"), thickness));
        plies.push(Ply { angle, thickness, ..*materials.get(at)? });
    }
    if laminate.symmetric {
        let upper: Vec<Ply> = plies.iter().rev().copied().collect();
        plies.extend(upper);
    }
    Some(Plied { numbers, rigidities: PLATE.into_iter().zip(plate(&plies)).collect() })
}

/// Materials as plies of no thickness.
fn numbers_of_materials(model: &Model, laminate: &LaminateSpec, out: &mut Vec<(String, f64)>) -> Option<Vec<Ply>> {
    let mut materials = Vec::new();
    for (name, m) in &laminate.materials {
        let mut of = |key: &str, s: &Scalar, unit: &str| {
            let v = value(model, s, unit)?;
            out.push((format!("materials.{name}.{key}"), v));
            Some(v)
        };
        let density = of("density", &m.density, "kg/m3")?;
        let mut ply =
            Ply { e1: 0.0, e2: 0.0, g12: 0.0, nu12: 0.0, g13: 0.0, g23: 0.0, density, angle: 0.0, thickness: 0.0 };
        if let (Some(e), Some(nu)) = (&m.e, &m.nu) {
            let (e, nu) = (of("E", e, "Pa")?, of("nu", nu, "1")?);
            let g = e / (2.0 * (1.0 + nu));
            (ply.e1, ply.e2, ply.nu12, ply.g12, ply.g13, ply.g23) = (e, e, nu, g, g, g);
        } else {
            (ply.e1, ply.e2) = (of("E1", m.e1.as_ref()?, "Pa")?, of("E2", m.e2.as_ref()?, "Pa")?);
            (ply.nu12, ply.g12) = (of("nu12", m.nu12.as_ref()?, "1")?, of("G12", m.g12.as_ref()?, "Pa")?);
            ply.g13 = m.g13.as_ref().map_or(Some(ply.g12), |g| of("G13", g, "Pa"))?;
            ply.g23 = m.g23.as_ref().map_or(Some(ply.g12), |g| of("G23", g, "Pa"))?;
        }
        materials.push(ply);
    }
    Some(materials)
}

/// A scalar of the file at the nominal values.
fn value(model: &Model, s: &Scalar, unit: &str) -> Option<f64> {
    let parameters = model.parameters();
    let dimension = |name: &str| {
        let unit = &parameters.get(parameters.index_of(name)?).unit;
        Unit::parse(unit).ok().filter(|_| !unit.is_empty()).map(|u| u.dimension)
    };
    let (constant, terms) = s.affine_in(unit, &dimension).ok()?;
    let theta = parameters.nominal();
    terms.iter().try_fold(constant, |sum, (name, factor)| Some(sum + factor * theta[parameters.index_of(name)?]))
}
