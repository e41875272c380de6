//! The `spring` element. Sketch, axes, equations, limits and sources: `spring.md`, the documentation of [`Spring`].

use super::bar::{along_line, straight_line};
use super::{Axes, Dof, Domain, Element, ElementError, ElementInput, Property, Sample, value};
use crate::linalg::SymMatrix;

#[doc = include_str!("spring.md")]
#[derive(Debug, Clone, Copy)]
pub struct Spring;

const PROPERTIES: &[Property] = &[
    Property::new("k", "N/m", Domain::NonNegative, "stiffness along the line between the nodes"),
    Property::new("c", "N s/m", Domain::NonNegative, "dashpot along the line between the nodes"),
];

/// The length, m, of a spring that is well described.
fn checked(input: &ElementInput<'_>) -> Result<f64, ElementError> {
    input.check(&Spring)?;
    let length = input.positive_length()?;
    if value!(input, k).is_none() && value!(input, c).is_none() {
        return Err(ElementError::Missing {
            name: "k",
            why: "give `k` or `c`, zero if it is to be updated from zero; other directions are a `bushing`",
        });
    }
    Ok(length)
}

impl Element for Spring {
    fn name(&self) -> &'static str {
        "spring"
    }

    fn summary(&self) -> &'static str {
        "A spring and a dashpot along the line between two nodes: struts, cables, bungees."
    }

    fn theory(&self) -> &'static str {
        include_str!("spring.md")
    }

    fn nodes(&self) -> &'static [&'static [Dof]] {
        &[&[Dof::Ux, Dof::Uy, Dof::Uz], &[Dof::Ux, Dof::Uy, Dof::Uz]]
    }

    fn properties(&self) -> &'static [Property] {
        PROPERTIES
    }

    fn axes(&self) -> Axes {
        Axes::AlongNodes
    }

    fn stiffness(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        checked(input)?;
        Ok(along_line(value!(input, k).unwrap_or(0.0)))
    }

    fn mass(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        checked(input)?;
        Ok(SymMatrix::zeros(12))
    }

    fn damping(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        checked(input)?;
        Ok(along_line(value!(input, c).unwrap_or(0.0)))
    }

    fn interpolate(&self, input: &ElementInput<'_>, xi: f64) -> Result<[[f64; 12]; 6], ElementError> {
        Ok(straight_line(checked(input)?, xi))
    }

    fn samples(&self) -> Vec<Sample> {
        vec![Sample {
            points: vec![[0.0; 3], [0.7, 0.0, 0.0]],
            given: vec![("k", 2e4), ("c", 30.0)],
            mass: 0.0,
            free: true,
        }]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spring_between_coincident_nodes_names_the_bushing() {
        let input = ElementInput { points: &[[0.0; 3]; 2], values: &[Some(1.0), None] };
        assert_eq!(
            Spring.stiffness(&input).unwrap_err().to_string(),
            "its nodes are at the same place, so it has no length and no axis; a `bushing` joins such nodes"
        );
    }
}
