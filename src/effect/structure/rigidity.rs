//! How stiff and how heavy beams are, as effects take it for their typical sizes.

use super::{Part, Structure};
use crate::model::ParametricModel;

/// Mean rigidities of the beams of a part at the estimates, weighted by length; zero where absent.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Rigidity {
    /// Sum of lengths, m.
    pub length: f64,
    /// Axial rigidity, N.
    pub ea: f64,
    /// Torsional rigidity, N m².
    pub gj: f64,
    /// Bending rigidity about y and about z, N m².
    pub ei: [f64; 2],
    /// Mass per length, kg/m.
    pub mass: f64,
}

impl Structure<'_> {
    /// Mean rigidities of the beams among these elements.
    pub fn rigidity(&self, elements: &[usize]) -> Rigidity {
        self.rigidity_at(elements, &self.theta)
    }

    fn rigidity_at(&self, elements: &[usize], theta: &[f64]) -> Rigidity {
        let mut r = Rigidity::default();
        for &e in elements.iter().filter(|e| self.is_beam(**e)) {
            let element = &self.model.elements()[e];
            let get = |name: &str| {
                let i = element.kind.properties().iter().position(|p| p.name == name)?;
                element.values[i].as_ref().map(|v| v.at(theta))
            };
            let product =
                |direct: &str, a: &str, b: &str| get(direct).or_else(|| Some(get(a)? * get(b)?)).unwrap_or(0.0);
            let l = self.length(e);
            let factor = element.stiffness_factor.as_ref().map_or(1.0, |f| f.at(theta));
            r.length += l;
            r.ea += factor * l * product("EA", "E", "A");
            let isotropic = || Some(get("E")? / (2.0 * (1.0 + get("nu")?)) * get("J")?);
            let gj = get("GJ").or_else(|| Some(get("G")? * get("J")?)).or_else(isotropic);
            r.gj += factor * l * gj.unwrap_or(0.0);
            r.ei[0] += factor * l * product("EIy", "E", "Iy");
            r.ei[1] += factor * l * product("EIz", "E", "Iz");
            r.mass += l * (product("mass_per_length", "density", "A") + get("added_mass_per_length").unwrap_or(0.0));
        }
        if r.length > 0.0 {
            let l = r.length;
            r = Rigidity { length: l, ea: r.ea / l, gj: r.gj / l, ei: r.ei.map(|ei| ei / l), mass: r.mass / l };
        }
        r
    }

    /// Mean axial force that the file states of the beams among these elements, tension positive, N.
    pub(in crate::effect) fn axial_force(&self, elements: &[usize]) -> f64 {
        let (mut sum, mut length) = (0.0, 0.0);
        for &e in elements.iter().filter(|e| self.is_beam(**e)) {
            sum += self.length(e) * self.property(e, "axial_force").unwrap_or(0.0);
            length += self.length(e);
        }
        if length > 0.0 { sum / length } else { 0.0 }
    }

    /// Width of a thin plate with the radius of gyration of the sections of these beams: c = √12 r, mean square over their length, m;
    /// none where no section has one.
    pub(in crate::effect) fn section_width(&self, elements: &[usize]) -> Option<f64> {
        let (mut square, mut length) = (0.0, 0.0);
        for &e in elements.iter().filter(|e| self.is_beam(**e)) {
            let get = |name: &str| self.property(e, name);
            let mass = || get("mass_per_length").or_else(|| Some(get("density")? * get("A")?));
            let by_inertia = || Some(get("polar_inertia_per_length")? / mass()?);
            let by_shape = || Some((get("Iy")? + get("Iz")?) / get("A")?);
            let Some(r2) = by_inertia().or_else(by_shape).filter(|r2| *r2 > 0.0 && r2.is_finite()) else { continue };
            square += 12.0 * r2 * self.length(e);
            length += self.length(e);
        }
        (length > 0.0).then(|| (square / length).sqrt())
    }

    /// The least √(EI GJ) of any element of a part with the parameters at their estimates, all at their lower or all at
    /// their upper bounds, for bending about y and about z.
    pub(in crate::effect) fn least_coupling(&self, part: &Part) -> [f64; 2] {
        let corner = |i: usize| -> Vec<f64> {
            let parameters = self.model.parameters();
            parameters.iter().zip(&self.theta).map(|(p, now)| p.bounds.map_or(*now, |b| b[i])).collect()
        };
        let mut least = [f64::MAX; 2];
        for theta in [self.theta.clone(), corner(0), corner(1)] {
            for &e in &part.elements {
                let r = self.rigidity_at(&[e], &theta);
                for (l, ei) in least.iter_mut().zip(r.ei) {
                    *l = l.min((ei * r.gj).max(0.0).sqrt());
                }
            }
        }
        least
    }
}
