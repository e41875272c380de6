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
