#![doc = include_str!("ground_spring.md")]

use super::joint::{Half, JOINT, joint_matrix};
use super::{Axes, Dof, Element, ElementError, ElementInput, Property, Sample};
use crate::linalg::SymMatrix;

/// A joint of six springs and dashpots from one node to the ground.
#[derive(Debug, Clone, Copy)]
pub struct GroundSpring;

impl GroundSpring {
    fn joint(&self, input: &ElementInput<'_>, half: Half) -> Result<SymMatrix, ElementError> {
        input.check(self)?;
        let stretch = std::array::from_fn(|d| (0..6).map(|j| f64::from(u8::from(j == d))).collect());
        joint_matrix(input, &stretch, half)
    }
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
        self.joint(input, Half::Stiffness)
    }

    fn mass(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        input.check(self)?;
        Ok(SymMatrix::zeros(6))
    }

    fn damping(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        self.joint(input, Half::Damping)
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
