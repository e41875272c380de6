//! Axial forces of beams when the whole structure is accelerated.

use super::Structure;
use crate::element::Dof;
use crate::linalg::DMatrix;
use crate::linalg::sparse::{SparsePlan, solve_shifted};
use crate::model::ParametricModel;

/// Sag of the structure under ten times its weight per unit of its size: one that sags more hangs on nothing, or is not a structure.
const MOST_SAG: f64 = 1.0;

/// Elements with their axial forces.
pub(super) type Forces = Vec<(usize, f64)>;

impl Structure<'_> {
    /// Axial force of every beam that stretches, tension positive, per unit of a global axis's body acceleration, N s²/m.
    ///
    /// ```text
    /// K u = M r,   N = EA/L (u₂ - u₁)        r: the unit translation along the axis, of supported nodes too
    /// ```
    ///
    /// None for a structure that is free to move along the axis.
    pub(in crate::effect) fn forces_of_acceleration(&self, axis: usize) -> Option<&[(usize, f64)]> {
        self.forces[axis].get_or_find(|| self.solve_for_forces(axis)).as_deref()
    }

    fn solve_for_forces(&self, axis: usize) -> Option<Forces> {
        let beams: Vec<usize> =
            (0..self.model.elements().len()).filter(|&e| self.is_beam(e) && self.strains(e, Dof::Ux)).collect();
        if beams.is_empty() {
            return None;
        }
        let system = self.model.assemble_sparse(&self.theta).ok()?;
        let (k, m) = (&system.stiffness, &system.mass);
        let r = self.model.dof_map().rigid_motions().columns(axis, 1).into_owned();
        if r.amax() == 0.0 {
            return None;
        }
        let load: DMatrix<f64> = self.model.weight(std::array::from_fn(|i| f64::from(i == axis)), &self.theta).ok()?;
        let plan = SparsePlan::new(k, m, &(0..k.n()).collect::<Vec<_>>()).ok()?;
        let u = solve_shifted(&plan, k, m, 0.0, &load).ok()?;
        let size = self.extent();
        if !u.iter().all(|v| v.is_finite()) || u.amax() * 100.0 > MOST_SAG * size {
            return None;
        }
        // K has an inverse, and not only by rounding.
        if (k.mul(&u) - &load).amax() > 1e-6 * load.amax() {
            return None;
        }
        let force = |e: usize| {
            let own = self.model.element_displacements(e, u.as_slice());
            let stiffness = self.model.element_matrices(e, &self.theta).ok()?.stiffness;
            let of_end = |i: usize| -> f64 { own.iter().enumerate().map(|(j, u)| stiffness.get(i, j) * u).sum() };
            Some((e, 0.5 * (of_end(6) - of_end(0))))
        };
        let forces: Forces = beams.into_iter().filter_map(force).filter(|(_, f)| f.is_finite()).collect();
        forces.iter().any(|(_, f)| *f != 0.0).then_some(forces)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::Context;
    use crate::model::{Registry, load};

    /// A column of any number of elements carries half of its own mass in its middle, whichever end is held.
    #[test]
    fn a_column_carries_half_of_itself() {
        for (n, base) in [(1, "a"), (1, "b"), (4, "a")] {
            let text = format!(
                "retune: 1\nname: column\nnodes: {{a: [0, 0, 0], b: [0, 0, 2]}}\nsections: {{s: {{EA: 1 GN, EIy: 1 MN m2, EIz: 1 MN m2, GJ: 1 MN m2, mass_per_length: 3 kg/m}}}}\nbeams: {{c: {{nodes: [a, b], section: s, subdivide: {n}}}}}\nsupports: {{base: {{node: {base}}}}}\n"
            );
            let (model, ..) = load(&text, &Registry::builtin()).unwrap();
            let context = Context::default();
            let structure = Structure::new(&model, &context);
            let forces = structure.forces_of_acceleration(2).expect("it carries itself");
            let mean = forces.iter().map(|f| f.1).sum::<f64>() / f64::from(n);
            let expected = if base == "a" { 3.0 } else { -3.0 };
            assert!((mean - expected).abs() < 1e-9, "{n} {base}: {mean}");
        }
    }
}
