//! The frequency that tells what is soft, stiff or slow on a structure.

use super::{Part, PartKind, Structure};
use crate::element::Dof;
use crate::modal::SolveOptions;
use crate::model::{ParametricModel, solve_modes};
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

    /// λ of the lowest mode that strains members more than springs, among the first few; else of the lowest: what a soft suspension
    /// does says nothing of the structure.
    fn lowest_elastic(&self) -> Option<f64> {
        /// Modes of a suspension, and a few more.
        const FEW: usize = 9;
        let lowest = |n_elastic: usize| {
            let modes = solve_modes(self.model, &self.theta, SolveOptions { n_elastic, shift: None }).ok()?;
            let kinds = self.model.characters(&self.theta, &modes.shapes, modes.n_rigid).ok().flatten()?;
            let is_of_members = |&i: &usize| kinds[i].springs < 0.5;
            Some((modes.elastic().next()?, modes.elastic().find(is_of_members), modes.lambda))
        };
        let (first, of_members, lambda) = lowest(1)?;
        let (found, lambda) = match of_members {
            Some(i) => (i, lambda),
            None => lowest(FEW).map_or((first, lambda), |(first, other, all)| (other.unwrap_or(first), all)),
        };
        Some(lambda[found]).filter(|l| *l > 0.0 && l.is_finite())
    }

    pub(super) fn characteristic_omega2(&self) -> f64 {
        if let Some(omega2) = self.lowest_elastic() {
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
