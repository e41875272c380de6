//! The `scalar_spring` element. Equations, axes, limits and sources: `scalar_spring.md`, the documentation of [`ScalarSpring`].

use super::{Axes, Dof, Domain, Element, ElementError, ElementInput, Property, Sample, property_index, value};
use crate::linalg::SymMatrix;

#[doc = include_str!("scalar_spring.md")]
#[derive(Debug, Clone, Copy)]
pub struct ScalarSpring;

const PROPERTIES: &[Property] = &[
    Property::new("k", "N/m", Domain::NonNegative, "stiffness against δ"),
    Property::new("c", "N s/m", Domain::NonNegative, "dashpot against the rate of δ"),
    Property::new("m", "kg", Domain::NonNegative, "inertance: force by the acceleration of δ"),
    Property::new("a_ux", "1", Domain::Any, "factor of ux at node 1 (default 0)"),
    Property::new("a_uy", "1", Domain::Any, "factor of uy at node 1 (default 0)"),
    Property::new("a_uz", "1", Domain::Any, "factor of uz at node 1 (default 0)"),
    Property::new("a_rx", "m", Domain::Any, "factor of rx at node 1 (default 0)"),
    Property::new("a_ry", "m", Domain::Any, "factor of ry at node 1 (default 0)"),
    Property::new("a_rz", "m", Domain::Any, "factor of rz at node 1 (default 0)"),
    Property::new("b_ux", "1", Domain::Any, "factor of ux at node 2 (default 0)"),
    Property::new("b_uy", "1", Domain::Any, "factor of uy at node 2 (default 0)"),
    Property::new("b_uz", "1", Domain::Any, "factor of uz at node 2 (default 0)"),
    Property::new("b_rx", "m", Domain::Any, "factor of rx at node 2 (default 0)"),
    Property::new("b_ry", "m", Domain::Any, "factor of ry at node 2 (default 0)"),
    Property::new("b_rz", "m", Domain::Any, "factor of rz at node 2 (default 0)"),
];

/// The first of the twelve factors, which stand in the order of the dofs.
const FACTORS: usize = property_index(PROPERTIES, "a_ux");

/// `size` times the square of δ; of an input that was checked.
fn square(input: &ElementInput<'_>, size: Option<f64>) -> Result<SymMatrix, ElementError> {
    let row: [f64; 12] = std::array::from_fn(|d| input.values[FACTORS + d].unwrap_or(0.0));
    if row.iter().all(|f| *f == 0.0) {
        return Err(ElementError::Missing {
            name: "a_ux",
            why: "without a factor other than zero nothing is stretched",
        });
    }
    let mut k = SymMatrix::zeros(12);
    k.add_outer(size.unwrap_or(0.0), &row);
    Ok(k)
}

impl Element for ScalarSpring {
    fn name(&self) -> &'static str {
        "scalar_spring"
    }

    fn summary(&self) -> &'static str {
        "A spring, a dashpot and an inerter between one combination of dofs of a node and one of another, without arms."
    }

    fn theory(&self) -> &'static str {
        include_str!("scalar_spring.md")
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
        input.check(self)?;
        square(input, value!(input, k))
    }

    fn mass(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        input.check(self)?;
        square(input, value!(input, m))
    }

    fn damping(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        input.check(self)?;
        square(input, value!(input, c))
    }

    fn is_scalar(&self) -> bool {
        true
    }

    fn samples(&self) -> Vec<Sample> {
        let given = vec![
            ("k", 2e4),
            ("c", 30.0),
            ("m", 0.4),
            ("a_ux", -1.0),
            ("a_uy", 0.2),
            ("a_uz", 0.3),
            ("a_rx", 0.1),
            ("a_ry", -0.2),
            ("a_rz", 0.05),
            ("b_ux", 0.9),
            ("b_uy", 0.1),
            ("b_uz", -0.4),
            ("b_rx", 0.15),
            ("b_ry", 0.3),
            ("b_rz", -0.25),
        ];
        vec![Sample { points: vec![[0.0; 3], [0.7, 0.1, 0.0]], given, mass: 0.0, free: false }]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Between two dofs of one direction it is the two by two matrix of every textbook, and nothing else.
    #[test]
    fn between_two_dofs_it_is_k_times_one_and_minus_one() {
        let mut values = vec![None; PROPERTIES.len()];
        (values[0], values[FACTORS + 2], values[FACTORS + 8]) = (Some(50.0), Some(-1.0), Some(1.0));
        let k =
            ScalarSpring.stiffness(&ElementInput { points: &[[0.0; 3], [1.0, 0.0, 0.0]], values: &values }).unwrap();
        for (i, j) in (0..12).flat_map(|i| (0..12).map(move |j| (i, j))) {
            let expected = match (i, j) {
                (2, 2) | (8, 8) => 50.0,
                (2, 8) | (8, 2) => -50.0,
                _ => 0.0,
            };
            assert_eq!(k.get(i, j), expected, "{i} {j}");
        }
    }
}
