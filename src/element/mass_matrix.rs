//! The `mass_matrix` element. Axes, limits and sources: `mass_matrix.md`, the documentation of [`MassMatrix`].

use super::{Axes, Dof, Domain, Element, ElementError, ElementInput, Property, Sample};
use crate::linalg::{DMatrix, SymMatrix, symmetric_eigen};

#[doc = include_str!("mass_matrix.md")]
#[derive(Debug, Clone, Copy)]
pub struct MassMatrix;

/// The lower triangle, row by row.
const PROPERTIES: &[Property] = &[
    Property::new("m_ux_ux", "kg", Domain::NonNegative, "entry of ux"),
    Property::new("m_ux_uy", "kg", Domain::Any, "entry of ux and uy"),
    Property::new("m_uy_uy", "kg", Domain::NonNegative, "entry of uy"),
    Property::new("m_ux_uz", "kg", Domain::Any, "entry of ux and uz"),
    Property::new("m_uy_uz", "kg", Domain::Any, "entry of uy and uz"),
    Property::new("m_uz_uz", "kg", Domain::NonNegative, "entry of uz"),
    Property::new("m_ux_rx", "kg m", Domain::Any, "entry of ux and rx"),
    Property::new("m_uy_rx", "kg m", Domain::Any, "entry of uy and rx"),
    Property::new("m_uz_rx", "kg m", Domain::Any, "entry of uz and rx"),
    Property::new("m_rx_rx", "kg m2", Domain::NonNegative, "entry of rx"),
    Property::new("m_ux_ry", "kg m", Domain::Any, "entry of ux and ry"),
    Property::new("m_uy_ry", "kg m", Domain::Any, "entry of uy and ry"),
    Property::new("m_uz_ry", "kg m", Domain::Any, "entry of uz and ry"),
    Property::new("m_rx_ry", "kg m2", Domain::Any, "entry of rx and ry"),
    Property::new("m_ry_ry", "kg m2", Domain::NonNegative, "entry of ry"),
    Property::new("m_ux_rz", "kg m", Domain::Any, "entry of ux and rz"),
    Property::new("m_uy_rz", "kg m", Domain::Any, "entry of uy and rz"),
    Property::new("m_uz_rz", "kg m", Domain::Any, "entry of uz and rz"),
    Property::new("m_rx_rz", "kg m2", Domain::Any, "entry of rx and rz"),
    Property::new("m_ry_rz", "kg m2", Domain::Any, "entry of ry and rz"),
    Property::new("m_rz_rz", "kg m2", Domain::NonNegative, "entry of rz"),
];

/// Eigenvalues of the matrix scaled to unit diagonal may be below zero by this much, rounding of the numbers of a file.
const ROUNDING: f64 = 1e-9;

/// Refuses a matrix with a negative eigenvalue, and names the entry that is the largest for its diagonal.
fn check(m: &SymMatrix) -> Result<(), ElementError> {
    let scale: Vec<f64> = (0..6).map(|i| m.get(i, i).sqrt()).collect();
    let scaled = |i: usize, j: usize| match scale[i] * scale[j] {
        0.0 => {
            if m.get(i, j) == 0.0 {
                0.0
            } else {
                2.0
            }
        }
        s => m.get(i, j) / s,
    };
    let pairs = || (0..6).flat_map(|i| (0..i).map(move |j| (i, j)));
    let Some((i, j)) = pairs().max_by(|a, b| scaled(a.0, a.1).abs().total_cmp(&scaled(b.0, b.1).abs())) else {
        return Ok(());
    };
    let unit = DMatrix::from_fn(6, 6, |i, j| if i == j { f64::from(u8::from(scale[i] > 0.0)) } else { scaled(i, j) });
    let lowest = symmetric_eigen(&unit).map_or(f64::NAN, |e| e.values.min());
    if lowest >= -ROUNDING {
        return Ok(());
    }
    let expected = "such that no eigenvalue of the matrix is negative";
    Err(ElementError::OutOfDomain { name: PROPERTIES[i * (i + 1) / 2 + j].name, value: m.get(i, j), expected })
}

impl Element for MassMatrix {
    fn name(&self) -> &'static str {
        "mass_matrix"
    }

    fn summary(&self) -> &'static str {
        "A mass on one node by its six by six matrix: a mass in one direction, a rotor, a condensed part."
    }

    fn theory(&self) -> &'static str {
        include_str!("mass_matrix.md")
    }

    fn nodes(&self) -> &'static [&'static [Dof]] {
        &[&Dof::ALL]
    }

    fn properties(&self) -> &'static [Property] {
        PROPERTIES
    }

    fn axes(&self) -> Axes {
        Axes::Given
    }

    fn stiffness(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        input.check(self)?;
        Ok(SymMatrix::zeros(6))
    }

    fn mass(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        input.check(self)?;
        let lower: Vec<f64> = input.values.iter().map(|v| v.unwrap_or(0.0)).collect();
        let m = SymMatrix::from_lower(6, &lower);
        check(&m)?;
        Ok(m)
    }

    fn is_scalar(&self) -> bool {
        true
    }

    fn samples(&self) -> Vec<Sample> {
        let given = vec![
            ("m_ux_ux", 1.0),
            ("m_ux_uy", -0.6),
            ("m_uy_uy", 2.32),
            ("m_ux_uz", -0.4),
            ("m_uy_uz", -0.18),
            ("m_uz_uz", 2.81),
            ("m_ux_rx", -0.9),
            ("m_uy_rx", -0.72),
            ("m_uz_rx", 2.07),
            ("m_rx_rx", 3.43),
            ("m_ux_ry", 0.6),
            ("m_uy_ry", -1.2),
            ("m_uz_ry", -1.18),
            ("m_rx_ry", 0.27),
            ("m_ry_ry", 3.46),
            ("m_ux_rz", 0.1),
            ("m_uy_rz", 0.36),
            ("m_uz_rz", 1.31),
            ("m_rx_rz", -0.45),
            ("m_ry_rz", -1.92),
            ("m_rz_rz", 4.7),
        ];
        vec![Sample { points: vec![[0.0; 3]], given, mass: 0.0, free: true }]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mass_of(given: &[(&'static str, f64)]) -> Result<SymMatrix, ElementError> {
        let sample = Sample { points: vec![[0.0; 3]], given: given.to_vec(), mass: 0.0, free: true };
        let values = sample.values(PROPERTIES)?;
        MassMatrix.mass(&ElementInput { points: &sample.points, values: &values })
    }

    /// The matrix of a body off its node, written out, is the one that `point_mass` computes.
    #[test]
    fn the_matrix_of_a_body_is_that_of_a_point_mass() {
        let values = [Some(2.0), Some(0.3), None, None, None, None, None, None, Some(0.1), None];
        let body = super::super::PointMass.mass(&ElementInput { points: &[[0.0; 3]], values: &values }).unwrap();
        let given: Vec<(&'static str, f64)> =
            PROPERTIES.iter().map(|p| p.name).zip(body.lower().iter().copied()).collect();
        assert_eq!(mass_of(&given).unwrap().lower(), body.lower());
    }

    #[test]
    fn negative_energy_is_refused_by_the_entry_that_makes_it() {
        let one = [("m_ux_ux", 1.0), ("m_uy_uy", 4.0)];
        assert!(mass_of(&[one[0], one[1], ("m_ux_uy", 2.0)]).is_ok());
        let wrong = mass_of(&[one[0], one[1], ("m_ux_uy", 2.1)]).unwrap_err();
        assert!(matches!(wrong, ElementError::OutOfDomain { name: "m_ux_uy", .. }), "{wrong}");
        assert!(mass_of(&[one[0], ("m_ux_rz", 0.1)]).is_err());
    }
}
