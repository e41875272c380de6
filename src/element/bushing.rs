//! The `bushing` element. Sketch, axes, equations, limits and sources: `bushing.md`, the documentation of [`Bushing`].

use super::joint::{Half, JOINT, joint_matrix};
use super::{Axes, Dof, Domain, Element, ElementError, ElementInput, Property, Sample, value};
use crate::linalg::SymMatrix;

#[doc = include_str!("bushing.md")]
#[derive(Debug, Clone, Copy)]
pub struct Bushing;

const PROPERTIES: &[Property] = &{
    let location =
        Property::new("location", "1", Domain::Fraction, "centre, as a fraction from node 1 to node 2 (default 0.5)");
    let mut all = [location; 13];
    let mut i = 0;
    while i < JOINT.len() {
        all[i] = JOINT[i];
        i += 1;
    }
    all
};

/// The springs or the dashpots between the ends of the two arms.
fn joint(input: &ElementInput<'_>, half: Half) -> Result<SymMatrix, ElementError> {
    input.check(&Bushing)?;
    let s = value!(input, location).unwrap_or(0.5);
    let d = input.points[1];
    let near = arm(d.map(|x| s * x));
    let far = arm(d.map(|x| (s - 1.0) * x));
    let stretch = std::array::from_fn(|i| {
        let first = near[i].iter().map(|x| -x);
        first.chain(far[i].iter().copied()).collect()
    });
    joint_matrix(input, &stretch, half)
}

/// Motion of the end of a rigid arm `r` from the six dofs of its node: `u + θ × r` and `θ`.
fn arm([x, y, z]: [f64; 3]) -> [[f64; 6]; 6] {
    [
        [1.0, 0.0, 0.0, 0.0, z, -y],
        [0.0, 1.0, 0.0, -z, 0.0, x],
        [0.0, 0.0, 1.0, y, -x, 0.0],
        [0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
    ]
}

impl Element for Bushing {
    fn name(&self) -> &'static str {
        "bushing"
    }

    fn summary(&self) -> &'static str {
        "Six springs and dashpots between two nodes, at the same place or apart: joints and flexible fittings."
    }

    fn theory(&self) -> &'static str {
        include_str!("bushing.md")
    }

    fn nodes(&self) -> &'static [&'static [Dof]] {
        &[&Dof::ALL, &Dof::ALL]
    }

    fn properties(&self) -> &'static [Property] {
        PROPERTIES
    }

    fn axes(&self) -> Axes {
        Axes::Given
    }

    fn stiffness(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        joint(input, Half::Stiffness)
    }

    fn mass(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        input.check(self)?;
        Ok(SymMatrix::zeros(12))
    }

    fn damping(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        joint(input, Half::Damping)
    }

    /// Each arm moves rigidly with its node; the centre belongs to the first.
    fn interpolate(&self, input: &ElementInput<'_>, xi: f64) -> Result<[[f64; 12]; 6], ElementError> {
        input.check(self)?;
        let from_second = xi > value!(input, location).unwrap_or(0.5);
        let (first, from) = if from_second { (6, xi - 1.0) } else { (0, xi) };
        let mut rows = [[0.0; 12]; 6];
        for (row, arm) in rows.iter_mut().zip(arm(input.points[1].map(|x| from * x))) {
            row[first..first + 6].copy_from_slice(&arm);
        }
        Ok(rows)
    }

    fn samples(&self) -> Vec<Sample> {
        let joint = || JOINT.iter().zip([2e5, 3e5, 4e5, 50.0, 60.0, 70.0, 1.0, 2.0, 3.0, 0.1, 0.2, 0.3]);
        let given = || joint().map(|(p, v)| (p.name, v)).collect::<Vec<_>>();
        let apart = [given(), vec![("location", 0.3)]].concat();
        vec![
            Sample { points: vec![[0.0; 3]; 2], given: given(), mass: 0.0, free: true },
            Sample { points: vec![[0.0; 3], [0.2, -0.1, 0.05]], given: apart, mass: 0.0, free: true },
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pure rotation of node 2 against node 1, about the centre, is resisted by the rotational spring alone.
    #[test]
    fn turning_about_the_centre_does_not_stretch_the_translations() {
        let mut values = vec![None; PROPERTIES.len()];
        (values[0], values[1], values[5], values[12]) = (Some(1e6), Some(1e7), Some(40.0), Some(0.25));
        let input = ElementInput { points: &[[0.0; 3], [0.4, 0.0, 0.0]], values: &values };
        let k = Bushing.stiffness(&input).unwrap().to_dense();
        // Centre at x = 0.1: node 2 lies 0.3 ahead of it, so turning by 1 rad moves it 0.3 in y.
        let mut q = crate::linalg::DVector::zeros(12);
        (q[7], q[11]) = (0.3, 1.0);
        let f = &k * &q;
        assert!((q.dot(&f) - 40.0).abs() < 1e-9, "{}", q.dot(&f));
    }

    #[test]
    fn an_empty_joint_is_refused() {
        let input = ElementInput { points: &[[0.0; 3]; 2], values: &[None; 13] };
        assert!(matches!(Bushing.stiffness(&input), Err(ElementError::Missing { name: "k_ux", .. })));
    }
}
