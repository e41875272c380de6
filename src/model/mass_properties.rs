//! Total mass, centre of gravity and inertia.

use super::dof_map::rigid_motion;
use crate::linalg::SymMatrix;

/// Mass properties of the whole structure, supports or not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassProperties {
    /// Total mass, kg.
    pub mass: f64,
    /// Centre of gravity, global, m.
    pub cg: [f64; 3],
    /// Inertia tensor about the centre of gravity, global axes, kg m²: moments on the diagonal, -∫ x y dm beside it.
    pub inertia: [[f64; 3]; 3],
}

impl MassProperties {
    /// From the 6 x 6 mass matrix of rigid motions about the origin, Rᵀ M R.
    ///
    /// ```text
    /// Rᵀ M R = [  m I    -m ĉ ]     ĉ: cross-product matrix of the centre of gravity c
    ///          [  m ĉ     J_o ]     J_o: inertia about the origin
    /// ```
    pub fn from_rigid_mass(rigid: &SymMatrix) -> Self {
        let mass = (rigid.get(0, 0) + rigid.get(1, 1) + rigid.get(2, 2)) / 3.0;
        // Entry (rotation about x, displacement along z) = m c_y, and so on round.
        let cg = if mass > 0.0 {
            [
                0.5 * (rigid.get(5, 1) - rigid.get(4, 2)) / mass,
                0.5 * (rigid.get(3, 2) - rigid.get(5, 0)) / mass,
                0.5 * (rigid.get(4, 0) - rigid.get(3, 1)) / mass,
            ]
        } else {
            [0.0; 3]
        };
        let mut inertia = [[0.0; 3]; 3];
        let square: f64 = cg.iter().map(|c| c * c).sum();
        for i in 0..3 {
            for j in 0..3 {
                let steiner = mass * (if i == j { square } else { 0.0 } - cg[i] * cg[j]);
                inertia[i][j] = rigid.get(3 + i, 3 + j) - steiner;
            }
        }
        Self { mass, cg, inertia }
    }

    /// The same, if it is the mass of a body: entries that act along some axes only have neither one mass nor a centre of gravity.
    pub fn of_a_body(rigid: &SymMatrix) -> Option<Self> {
        const ROUNDING: f64 = 1e-9;
        let own = [0, 1, 2].map(|i| rigid.get(i, i));
        let size = own.iter().copied().fold(0.0, f64::max);
        let is_one = own.iter().all(|m| (m - own[0]).abs() <= ROUNDING * size);
        is_one.then(|| Self::from_rigid_mass(rigid))
    }

    /// Moment of inertia about an axis through a point, parallel to global axis `axis`, kg m².
    pub fn moment_about(&self, axis: usize, point: [f64; 3]) -> f64 {
        let square: f64 = (0..3).filter(|i| *i != axis).map(|i| (self.cg[i] - point[i]).powi(2)).sum();
        self.inertia[axis][axis] + self.mass * square
    }
}

/// Adds Rᵀ m R of one element to the 6 x 6 mass matrix of rigid motions, times `factor`.
///
/// * `mass` - its mass matrix in its axes, (6 nodes) x (6 nodes)
/// * `axes`, `positions` - its axes and the global positions of its nodes
pub(super) fn add_rigid_mass(
    rigid: &mut SymMatrix,
    factor: f64,
    mass: &SymMatrix,
    axes: &[[f64; 3]; 3],
    positions: &[[f64; 3]],
) {
    if mass.is_zero() {
        return;
    }
    let n = mass.n();
    let motions: [Vec<f64>; 6] = std::array::from_fn(|motion| {
        let mut r = Vec::with_capacity(n);
        for p in positions {
            let u = rigid_motion(*p, motion);
            for half in [&u[..3], &u[3..]] {
                for a in axes {
                    r.push(a[0] * half[0] + a[1] * half[1] + a[2] * half[2]);
                }
            }
        }
        r
    });
    let mut momentum = vec![0.0; n];
    for j in 0..6 {
        mass.multiply(&motions[j], &mut momentum);
        for (i, motion) in motions.iter().enumerate().skip(j) {
            let sum: f64 = motion.iter().zip(&momentum).map(|(a, b)| a * b).sum();
            rigid.add(i, j, factor * sum);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::model::{ParametricModel, Registry, load};

    fn properties(mass: &str) -> Option<super::MassProperties> {
        let text = format!(
            "retune: 1\nname: rod\nnodes: {{a: [0, 0, 0], b: [2, 0, 0]}}\nbeams: {{r: {{nodes: [a, b], properties: {{EA: 1e6, GJ: 1, EIy: 1, EIz: 1, mass_per_length: 3 kg/m}}}}}}\n\
             supports: {{left: {{node: a}}}}\nelements: {{s: {{type: mass_matrix, nodes: [b], {mass}}}}}\n"
        );
        let model = load(&text, &Registry::builtin()).unwrap_or_else(|e| panic!("{e:?}")).0;
        model.mass_properties(&model.parameters().nominal()).unwrap()
    }

    /// 6 kg of a rod at 1 m and 4 kg at 2 m; a mass of two directions only is not a body's.
    #[test]
    fn what_differs_by_axis_is_no_body() {
        let body = properties("properties: {m_ux_ux: 4, m_uy_uy: 4, m_uz_uz: 4}").unwrap();
        assert!((body.mass - 10.0).abs() < 1e-12 && (body.cg[0] - 1.4).abs() < 1e-12, "{body:?}");
        assert_eq!(properties("properties: {m_ux_ux: 4, m_uy_uy: 4}"), None);
    }
}
