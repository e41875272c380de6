//! The frequency that tells what is soft, stiff or slow on a structure.

use super::{Part, PartKind, Structure};
use crate::element::Dof;
use std::f64::consts::PI;

/// Arm of a moment, as a share of the size of the structure: a fiftieth of the stiffness that it makes against turning is about a fifth of EI/L of
/// a beam on two supports.
const ARM: f64 = 0.25;

impl Structure<'_> {
    /// M ω² against a displacement, N/m, and M ω² (L/4)² against a rotation, N m/rad: what is far softer or stiffer does not matter.
    pub fn generalised_stiffness(&self, dof: Dof) -> f64 {
        let arm = if dof.is_rotation() { ARM * self.extent() } else { 1.0 };
        self.total_mass() * self.omega2() * arm * arm
    }

    pub(super) fn characteristic_omega2(&self) -> f64 {
        if let Some(omega2) = self.model.first_straining_lambda() {
            return omega2;
        }
        let chains = self.parts.iter().filter(|p| {
            matches!(p.kind, PartKind::Chain | PartKind::Element) && p.elements.iter().any(|&e| self.deforms(e))
        });
        let bending = |p: &Part| {
            let r = self.rigidity(&p.elements);
            let lumps: f64 = self
                .lumps_on(&p.elements)
                .iter()
                .flat_map(|l| &l.elements)
                .filter_map(|&m| self.property(m, "mass"))
                .sum();
            let bends = |dof| p.elements.iter().any(|&e| self.strains(e, dof));
            let ei = match (bends(Dof::Ry), bends(Dof::Rz)) {
                (true, true) => r.ei[0].min(r.ei[1]),
                (true, false) => r.ei[0],
                (false, true) => r.ei[1],
                (false, false) => 0.0,
            };
            let mass = r.mass * r.length + lumps;
            // A cantilever of mass m: ω² = 1.8751⁴ EI / (m L³).
            (ei > 0.0 && mass > 0.0).then(|| 12.362 * ei / (mass * r.length.powi(3)))
        };
        if let Some(omega2) = chains.filter_map(bending).min_by(f64::total_cmp) {
            return omega2;
        }
        // No bending anywhere: the softest translation of the springs under the total mass.
        let softest = self
            .model
            .elements()
            .iter()
            .enumerate()
            .filter(|(i, _)| self.stiff[*i])
            .filter_map(|(i, _)| self.model.element_matrices(i, &self.theta).ok())
            .flat_map(|m| (0..3).map(move |d| m.stiffness.get(d, d)).filter(|k| *k > 0.0))
            .min_by(f64::total_cmp);
        match softest {
            Some(k) if self.total_mass > 0.0 => k / self.total_mass,
            // Nothing is known: 1 Hz.
            _ => 4.0 * PI * PI,
        }
    }
}
