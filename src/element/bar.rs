//! The `bar` element. Sketch, axes, equations, limits and sources: `bar.md`, the documentation of [`Bar`].

use super::{Axes, Dof, Domain, Element, ElementError, ElementInput, Lack, Property, Sample, value};
use crate::linalg::SymMatrix;

#[doc = include_str!("bar.md")]
#[derive(Debug, Clone, Copy)]
pub struct Bar;

const PROPERTIES: &[Property] = &[
    Property::new("E", "Pa", Domain::Positive, "Young's modulus"),
    Property::new("A", "m2", Domain::Positive, "cross-section area"),
    Property::new("EA", "N", Domain::Positive, "axial rigidity, instead of `E` and `A`"),
    Property::new("mass_per_length", "kg/m", Domain::NonNegative, "mass per length"),
    Property::new("density", "kg/m3", Domain::NonNegative, "density, instead of `mass_per_length`; needs `A`"),
    Property::new(
        "lumping",
        "1",
        Domain::Fraction,
        "0 for the consistent mass (when absent), 1 for one lumped at both ends, a mean of both between",
    ),
];

/// A rigidity given directly or as the product of a modulus and a section constant; `None` unless one way is complete.
pub(super) fn rigidity(
    modulus: Option<f64>,
    (section_name, section): (&'static str, Option<f64>),
    (name, direct): (&'static str, Option<f64>),
) -> Result<Option<f64>, ElementError> {
    match (modulus, section, direct) {
        (Some(_), Some(_), Some(_)) => Err(ElementError::Redundant { first: section_name, second: name }),
        (_, _, Some(rigidity)) => Ok(Some(rigidity)),
        (Some(modulus), Some(section), None) => Ok(Some(modulus * section)),
        _ => Ok(None),
    }
}

/// The property that completes a rigidity of which not both factors are given.
pub(super) fn completing(
    (modulus_name, modulus): (&'static str, Option<f64>),
    (section_name, section): (&'static str, Option<f64>),
    rigidity_name: &'static str,
) -> &'static str {
    match (modulus, section) {
        (Some(_), None) => section_name,
        (None, Some(_)) => modulus_name,
        _ => rigidity_name,
    }
}

/// Mass per length, kg/m, from itself or from density and area; zero when neither is given.
pub(super) fn mass_per_length(
    direct: Option<f64>,
    density: Option<f64>,
    area: Option<f64>,
) -> Result<f64, ElementError> {
    match (direct, density, area) {
        (Some(_), Some(_), _) => Err(ElementError::Redundant { first: "mass_per_length", second: "density" }),
        (Some(mass), None, _) => Ok(mass),
        (None, Some(density), Some(area)) => Ok(density * area),
        (None, Some(_), None) => Err(ElementError::Missing {
            name: "A",
            why: "`density` becomes mass per length by the cross-section area; or give `mass_per_length`",
        }),
        (None, None, _) => Ok(0.0),
    }
}

/// `k [1 -1; -1 1]` on (ux1, ux2): the only elongation that a line element knows.
pub(super) fn along_line(k: f64) -> SymMatrix {
    let mut matrix = SymMatrix::zeros(12);
    for (i, j, sign) in [(0, 0, 1.0), (6, 0, -1.0), (6, 6, 1.0)] {
        matrix.add(i, j, sign * k);
    }
    matrix
}

/// Motion of the straight line between two hinges: it turns with the chord, `ry = -Δuz/L` and `rz = Δuy/L`; the
/// rotation about the line, which it does not resist, is linear.
pub(super) fn straight_line(length: f64, xi: f64) -> [[f64; 12]; 6] {
    let mut rows = [[0.0; 12]; 6];
    for d in [0, 1, 2, 3] {
        (rows[d][d], rows[d][6 + d]) = (1.0 - xi, xi);
    }
    (rows[4][2], rows[4][8]) = (1.0 / length, -1.0 / length);
    (rows[5][1], rows[5][7]) = (-1.0 / length, 1.0 / length);
    rows
}

/// What the values say: axial rigidity (`None`: not given), mass per length, length.
fn read(input: &ElementInput<'_>) -> Result<(Option<f64>, f64, f64), ElementError> {
    input.check(&Bar)?;
    let area = value!(input, A);
    let ea = rigidity(value!(input, E), ("A", area), ("EA", value!(input, EA)))?;
    let mass = mass_per_length(value!(input, mass_per_length), value!(input, density), area)?;
    Ok((ea, mass, input.positive_length()?))
}

impl Element for Bar {
    fn name(&self) -> &'static str {
        "bar"
    }

    fn summary(&self) -> &'static str {
        "A straight member that carries axial force only: struts, rods, truss members."
    }

    fn theory(&self) -> &'static str {
        include_str!("bar.md")
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
        let (ea, _, length) = read(input)?;
        Ok(along_line(ea.unwrap_or(0.0) / length))
    }

    fn mass(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        let (_, mass_per_length, length) = read(input)?;
        let sixth = mass_per_length * length / 6.0;
        let lumping = value!(input, lumping).unwrap_or(0.0);
        let (own, other) = (2.0 + lumping, 1.0 - lumping);
        let mut m = SymMatrix::zeros(12);
        for d in 0..3 {
            for (i, j, weight) in [(d, d, own), (6 + d, d, other), (6 + d, 6 + d, own)] {
                m.add(i, j, weight * sixth);
            }
        }
        Ok(m)
    }

    fn interpolate(&self, input: &ElementInput<'_>, xi: f64) -> Result<[[f64; 12]; 6], ElementError> {
        let (_, _, length) = read(input)?;
        Ok(straight_line(length, xi))
    }

    fn lacks(&self, input: &ElementInput<'_>) -> Vec<Lack> {
        let Ok((None, ..)) = read(input) else { return Vec::new() };
        let (e, a) = (value!(input, E), value!(input, A));
        if e.is_none() {
            return Vec::new();
        }
        vec![Lack { dof: Dof::Ux, property: completing(("E", e), ("A", a), "EA") }]
    }

    fn samples(&self) -> Vec<Sample> {
        let points = || vec![[0.0; 3], [0.8, 0.0, 0.0]];
        let steel = vec![("E", 210e9), ("A", 1e-4), ("density", 7850.0)];
        let cable = vec![("EA", 2e6), ("mass_per_length", 0.4), ("lumping", 0.3)];
        vec![
            Sample { points: points(), given: steel, mass: 7850.0 * 1e-4 * 0.8, free: true },
            Sample { points: points(), given: cable, mass: 0.4 * 0.8, free: true },
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn input(values: &[Option<f64>]) -> ElementInput<'_> {
        ElementInput { points: &[[0.0; 3], [0.5, 0.0, 0.0]], values }
    }

    /// EA/L along the line and nothing across; m L/3 and m L/6 in every direction: K.-J. Bathe, Finite Element Procedures.
    #[test]
    fn bathe_truss_element() {
        let values = [Some(2e11), Some(1e-4), None, Some(1.2), None, None];
        let (k, m) = (Bar.stiffness(&input(&values)).unwrap(), Bar.mass(&input(&values)).unwrap());
        assert_eq!((k.get(0, 0), k.get(0, 6), k.get(6, 6)), (4e7, -4e7, 4e7));
        for d in 0..3 {
            assert!((m.get(d, d) - 0.2).abs() < 1e-15 && (m.get(d, 6 + d) - 0.1).abs() < 1e-15);
            assert!(d == 0 || k.get(d, d) == 0.0);
        }
    }

    /// Half of the mass at each end, in every direction; between the two the mean, with the same mass in every rigid translation.
    #[test]
    fn a_lumped_bar_has_half_of_its_mass_at_each_end() {
        for (lumping, own, other) in [(1.0, 0.3, 0.0), (0.5, 0.25, 0.05)] {
            let values = [Some(2e11), Some(1e-4), None, Some(1.2), None, Some(lumping)];
            let m = Bar.mass(&input(&values)).unwrap();
            for d in 0..3 {
                assert!((m.get(d, d) - own).abs() < 1e-15 && (m.get(6 + d, 6 + d) - own).abs() < 1e-15);
                assert!((m.get(d, 6 + d) - other).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn what_a_bar_lacks_is_named() {
        assert_eq!(
            Bar.lacks(&input(&[Some(2e11), None, None, None, None, None])),
            [Lack { dof: Dof::Ux, property: "A" }]
        );
        assert_eq!(Bar.lacks(&input(&[None, Some(1e-4), None, None, Some(7800.0), None])), []);
        assert_eq!(
            Bar.mass(&input(&[None, None, Some(1e6), None, Some(7800.0), None])).unwrap_err().to_string(),
            "property `A` is missing: `density` becomes mass per length by the cross-section area; or give \
             `mass_per_length`"
        );
    }
}
