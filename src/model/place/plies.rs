//! Laminates: their plies read and checked, as functions of θ.

use super::Placer;
use super::shape::Shaped;
use crate::catalogue::did_you_mean;
use crate::element::{Domain, Element};
use crate::model::lay_up::{Constants, LayUp, PlyOf, Rigidity};
use crate::model::spec::{LaminateSpec, PlyMaterialSpec, PlySpec};
use crate::model::value::{Affine, Value};
use crate::units::Scalar;
use crate::yaml::{Problem, child};
use std::f64::consts::PI;
use std::sync::Arc;

/// Plies of a laminate, at most.
const MOST_PLIES: usize = 10_000;

/// Below these shares of what they stand beside, the coupling of a strip and the offset of its mass are rounding.
const NOTHING: f64 = 1e-12;

/// Elastic constants and density of a material of plies.
type PlyMaterial = (Constants, Affine);

impl Placer<'_> {
    /// What plies give an element: the rigidities of a plate where its type has such, else those of a strip.
    pub(super) fn laminate(&mut self, kind: &'static dyn Element, s: &LaminateSpec, path: &str) -> Option<Shaped> {
        let before = self.problems.len();
        let has = |name: &str| kind.properties().iter().any(|p| p.name == name);
        let is_plate = has("A11");
        let width = s.width.as_ref().filter(|_| !is_plate);
        if width.is_none() && !is_plate {
            self.error(path, format_args!("a {} of plies is a strip, and needs its `width`", kind.name()));
        }
        let width = width.and_then(|w| self.number(w, "m", Domain::Positive, &child(path, "width")));
        if s.plies.is_empty() || s.plies.len() > MOST_PLIES {
            self.error(child(path, "plies"), format_args!("a laminate has between 1 and {MOST_PLIES} plies"));
            return None;
        }
        let materials: Vec<(&str, Option<PlyMaterial>)> = s
            .materials
            .iter()
            .map(|(name, m)| (name.as_str(), self.ply_material(m, &child(&child(path, "materials"), name))))
            .collect();
        let mut plies = Vec::with_capacity(s.plies.len());
        for (i, ply) in s.plies.iter().enumerate() {
            plies.extend(self.ply(ply, &materials, &format!("{path}.plies[{i}]")));
        }
        if s.symmetric {
            let upper: Vec<_> = plies.iter().rev().cloned().collect();
            plies.extend(upper);
        }
        if self.problems.len() > before {
            return None;
        }
        let lay_up = LayUp::new(width, plies);
        let found = lay_up.found(&self.parameters.nominal()).map_err(|why| self.error(path, why)).ok()?;
        if lay_up.is_constant() {
            let of = |name: &str| lay_up.names().iter().position(|n| *n == name).map_or(0.0, |i| found[i]);
            let is_noise = |name: &str, value: f64| match name {
                "bend_twist_y" => value.abs() <= NOTHING * (of("EIy") * of("GJ")).sqrt(),
                "mass_offset_z" => value.abs() <= NOTHING * (of("EIy") / of("EA")).sqrt(),
                _ => false,
            };
            let kept = lay_up.names().iter().copied().zip(found.iter().copied()).filter(|(n, v)| !is_noise(n, *v));
            return Some(Shaped::constants(kept));
        }
        let lay_up = Arc::new(lay_up);
        let value = |which: usize| {
            let rigidity = Some(Rigidity::new(Arc::clone(&lay_up), which));
            Value { rigidity, ..Value::constant(1.0) }
        };
        let properties = lay_up.names().iter().enumerate().map(|(which, name)| (*name, value(which))).collect();
        Some(Shaped { properties, turn: 0.0 })
    }

    /// A scalar as a function of θ, within a domain.
    fn number(&mut self, s: &Scalar, unit: &str, domain: Domain, path: &str) -> Option<Affine> {
        let affine = self.affine(s, unit, path)?;
        let name = path.rsplit('.').next().unwrap_or(path);
        self.domain(&affine, domain, name, unit, path);
        Some(affine)
    }

    /// Elastic constants and density.
    fn ply_material(&mut self, m: &PlyMaterialSpec, path: &str) -> Option<PlyMaterial> {
        let at = |key: &str| child(path, key);
        let density = self.number(&m.density, "kg/m3", Domain::NonNegative, &at("density"));
        let isotropic = [("E", &m.e), ("nu", &m.nu)];
        let along = [("E1", &m.e1), ("E2", &m.e2), ("nu12", &m.nu12), ("G12", &m.g12)];
        let transverse = [("G13", &m.g13), ("G23", &m.g23)];
        let is_isotropic = isotropic.iter().any(|p| p.1.is_some());
        if let Some((key, _)) = along.iter().chain(&transverse).find(|p| is_isotropic && p.1.is_some()) {
            self.error(
                at(key),
                "an isotropic material has `E` and `nu` alone, one with fibres `E1`, `E2`, `nu12` and `G12`",
            );
            return None;
        }
        let needed = if is_isotropic { &isotropic[..] } else { &along[..] };
        if let Some((key, _)) = needed.iter().find(|p| p.1.is_none()) {
            let text = "a material of plies needs `E` and `nu`, or `E1`, `E2`, `nu12` and `G12`";
            self.error(path, format_args!("`{key}` is missing: {text}"));
            return None;
        }
        let theta = self.parameters.nominal();
        let mut modulus = |s: &Option<Scalar>, key: &str| self.number(s.as_ref()?, "Pa", Domain::Positive, &at(key));
        if is_isotropic {
            let e = modulus(&m.e, "E");
            let nu = self.number(m.nu.as_ref()?, "1", Domain::Any, &at("nu"))?;
            let now = nu.at(&theta);
            if !(now > -1.0 && now < 0.5) {
                self.error(at("nu"), format_args!("Poisson's ratio is {now}, and lies above -1 and below 0.5"));
            }
            return Some((Constants::Isotropic([e?, nu]), density?));
        }
        let [e1, e2, g12] = [(&m.e1, "E1"), (&m.e2, "E2"), (&m.g12, "G12")].map(|(s, key)| modulus(s, key));
        let [g13, g23] = transverse.map(|(key, s)| if s.is_some() { modulus(s, key) } else { g12.clone() });
        let nu12 = m.nu12.as_ref().and_then(|s| self.number(s, "1", Domain::Any, &at("nu12")));
        let (e1, e2, nu12) = (e1?, e2?, nu12?);
        let [along, across, nu] = [&e1, &e2, &nu12].map(|a| a.at(&theta));
        if along > 0.0 && across > 0.0 && nu * nu >= along / across {
            let text = m.nu12.as_ref().map_or("", Scalar::text);
            self.error(
                at("nu12"),
                format_args!("`{text}` is too large: nu12² must be below E1/E2, or the material gives energy"),
            );
        }
        Some((Constants::Orthotropic([e1, e2, g12?, nu12, g13?, g23?]), density?))
    }

    fn ply(&mut self, ply: &PlySpec, materials: &[(&str, Option<PlyMaterial>)], path: &str) -> Option<PlyOf> {
        let thickness = self.number(&ply.thickness, "m", Domain::Positive, &child(path, "thickness"));
        let angle = self.number(&ply.angle, "rad", Domain::Any, &child(path, "angle"));
        let now = angle.as_ref().map_or(0.0, |a| a.at(&self.parameters.nominal()));
        if now.abs() > PI {
            let text = ply.angle.text();
            self.error(
                child(path, "angle"),
                format_args!("`{text}` is {:.0} degrees, and fibres lie within half a turn; a number alone is in radians, so write `{text} deg` if degrees are meant", now.to_degrees()),
            );
        }
        let material = match (&ply.material, materials) {
            (Some(name), _) => {
                let found = materials.iter().find(|m| m.0 == name);
                if found.is_none() {
                    let suggestion = did_you_mean(name, materials.iter().map(|m| m.0));
                    self.error(child(path, "material"), format_args!("there is no material `{name}`{suggestion}"));
                }
                found
            }
            (None, [only]) => Some(only),
            (None, _) => {
                let text = "the laminate has several materials or none; name that of the ply by `material`";
                self.problems.push(Problem::error(path, text));
                None
            }
        };
        let (constants, density) = material?.1.clone()?;
        Some(PlyOf { constants, sizes: [density, angle?, thickness?] })
    }
}
