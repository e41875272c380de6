//! The first mode of a model that says something of its members.

use super::dependence::interior_point;
use super::{Model, ParametricModel, solve_modes};
use crate::modal::SolveOptions;

/// Modes of a suspension and of bodies on mounts, and a few more.
const FEW: usize = 30;

impl Model {
    /// λ = ω² of the lowest mode that strains members more than springs, among the first few, at the estimates moved into their bounds; else of
    /// the lowest: what a soft suspension does says nothing of the structure. `None` of a model without modes.
    ///
    /// It is solved for once.
    pub fn first_straining_lambda(&self) -> Option<f64> {
        *self.first_straining.get_or_find(|| self.find_first_straining())
    }

    fn find_first_straining(&self) -> Option<f64> {
        let theta = interior_point(self.parameters());
        let lowest = |n_elastic: usize| {
            let modes = solve_modes(self, &theta, SolveOptions { n_elastic, shift: None }).ok()?;
            let kinds = self.characters(&theta, &modes.shapes, modes.n_rigid).ok().flatten()?;
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
}

#[cfg(test)]
mod tests {
    use crate::model::{Registry, load};

    /// A beam on soft springs that carries bodies on mounts has more than nine modes of springs before its own.
    #[test]
    fn the_first_mode_of_members_is_found_behind_suspension_and_mounts() {
        let text = |mounts: &str| {
            format!(
                "
retune: 1
name: beam with bodies on mounts
nodes: {{a: [0, 0, 0], b: [1 m, 0, 0], c: [2 m, 0, 0], p: [0.5 m, 0, 0], q: [1.5 m, 0, 0], r: [1 m, 0, 0]}}
sections: {{s: {{E: 210 GPa, nu: 0.3, density: 7850 kg/m3, shape: {{box: {{width: 60 mm, height: 60 mm, wall: 4 mm}}}}}}}}
beams: {{x: {{nodes: [a, b], section: s, subdivide: 2}}, y: {{nodes: [b, c], section: s, subdivide: 2}}}}
springs:
  left: {{node: a, k: {{ux: 100 N/m, uy: 100 N/m, uz: 100 N/m, rx: 10 N m/rad}}}}
  right: {{node: c, k: {{ux: 100 N/m, uy: 100 N/m, uz: 100 N/m}}}}
{mounts}"
            )
        };
        let mount = |name: &str| {
            format!(
                "  m_{name}: {{nodes: [b, {name}], k: {{ux: 2000 N/m, uy: 2000 N/m, uz: 2000 N/m, rx: 20 N m/rad, ry: 20 N m/rad, rz: 20 N m/rad}}}}\n"
            )
        };
        let bodies = "masses: {bodies: {nodes: [p, q, r], mass: 1 kg, inertia: {xx: 0.01 kg m2, yy: 0.01 kg m2, zz: 0.01 kg m2}}}\n";
        let mounts = ["p", "q", "r"].map(mount).concat() + bodies;
        let first = |text: &str| {
            let model = load(text, &Registry::builtin()).unwrap_or_else(|p| panic!("{p:?}")).0;
            model.first_straining_lambda().unwrap().sqrt() / std::f64::consts::TAU
        };
        let bare = text("").replace(", p: [0.5 m, 0, 0], q: [1.5 m, 0, 0], r: [1 m, 0, 0]", "");
        let (alone, with) = (first(&bare), first(&text(&mounts)));
        assert!((with / alone - 1.0).abs() < 0.3, "{with} Hz beside {alone} Hz");
    }
}
