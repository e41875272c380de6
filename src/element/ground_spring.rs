//! The `ground_spring` element. Sketch, axes, equations, limits and sources: `ground_spring.md`, the documentation of [`GroundSpring`].

use super::joint::{Half, JOINT, joint_matrix};
use super::{Axes, Dof, Element, ElementError, ElementInput, Property, Sample};
use crate::linalg::SymMatrix;

#[doc = include_str!("ground_spring.md")]
#[derive(Debug, Clone, Copy)]
pub struct GroundSpring;

/// The springs or the dashpots of the node against the ground.
fn joint(input: &ElementInput<'_>, half: Half) -> Result<SymMatrix, ElementError> {
    input.check(&GroundSpring)?;
    let stretch = std::array::from_fn(|d| (0..6).map(|j| f64::from(u8::from(j == d))).collect());
    joint_matrix(input, &stretch, half)
}

impl Element for GroundSpring {
    fn name(&self) -> &'static str {
        "ground_spring"
    }

    fn summary(&self) -> &'static str {
        "Six springs and dashpots from one node to the ground: flexible supports and suspensions."
    }

    fn theory(&self) -> &'static str {
        include_str!("ground_spring.md")
    }

    fn nodes(&self) -> &'static [&'static [Dof]] {
        &[&Dof::ALL]
    }

    fn properties(&self) -> &'static [Property] {
        &JOINT
    }

    fn axes(&self) -> Axes {
        Axes::Given
    }

    fn stiffness(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        joint(input, Half::Stiffness)
    }

    fn mass(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        input.check(self)?;
        Ok(SymMatrix::zeros(6))
    }

    fn damping(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        joint(input, Half::Damping)
    }

    fn samples(&self) -> Vec<Sample> {
        let given = JOINT.iter().zip([150.0, 160.0, 170.0, 15.0, 16.0, 17.0, 1.0, 2.0, 3.0, 0.1, 0.2, 0.3]);
        vec![Sample {
            points: vec![[0.0; 3]],
            given: given.map(|(p, v)| (p.name, v)).collect(),
            mass: 0.0,
            free: false,
        }]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each spring and each dashpot stands on its own dof, and an absent one is zero.
    #[test]
    fn springs_and_dashpots_are_diagonal() {
        let mut values = [None; 12];
        (values[2], values[4], values[11]) = (Some(150.0), Some(15.0), Some(0.5));
        let input = ElementInput { points: &[[0.0; 3]], values: &values };
        let k = GroundSpring.stiffness(&input).unwrap();
        let c = GroundSpring.damping(&input).unwrap();
        for i in 0..6 {
            for j in 0..6 {
                let expected = [(2, 150.0), (4, 15.0)].iter().find(|(d, _)| i == j && *d == i).map_or(0.0, |(_, k)| *k);
                assert_eq!(k.get(i, j), expected);
                assert_eq!(c.get(i, j), if (i, j) == (5, 5) { 0.5 } else { 0.0 });
            }
        }
    }
}
