//! The `point_mass` element. Sketch, axes, equations, limits and sources: `point_mass.md`, the documentation of [`PointMass`].

use super::{Axes, Dof, Domain, Element, ElementError, ElementInput, Property, Sample, value};
use crate::linalg::SymMatrix;

#[doc = include_str!("point_mass.md")]
#[derive(Debug, Clone, Copy)]
pub struct PointMass;

const PROPERTIES: &[Property] = &[
    Property::new("mass", "kg", Domain::NonNegative, "mass"),
    Property::new("inertia_xx", "kg m2", Domain::NonNegative, "moment of inertia about x through the cg"),
    Property::new("inertia_yy", "kg m2", Domain::NonNegative, "moment of inertia about y through the cg"),
    Property::new("inertia_zz", "kg m2", Domain::NonNegative, "moment of inertia about z through the cg"),
    Property::new("inertia_xy", "kg m2", Domain::Any, "product of inertia, integral of x y dm about the cg"),
    Property::new("inertia_xz", "kg m2", Domain::Any, "product of inertia, integral of x z dm about the cg"),
    Property::new("inertia_yz", "kg m2", Domain::Any, "product of inertia, integral of y z dm about the cg"),
    Property::new("offset_x", "m", Domain::Any, "x from the node to the centre of gravity"),
    Property::new("offset_y", "m", Domain::Any, "y from the node to the centre of gravity"),
    Property::new("offset_z", "m", Domain::Any, "z from the node to the centre of gravity"),
];

/// Six numbers of an inertia tensor: moments xx, yy, zz and products xy, xz, yz.
struct Inertia {
    moments: [f64; 3],
    products: [f64; 3],
}

impl Inertia {
    /// Positive semidefinite: every 2 x 2 principal minor and the determinant are not negative.
    ///
    /// The moments are compared after scaling to unit diagonal, so the tolerance is rounding: 16 machine epsilons.
    fn check(&self) -> Result<(), ElementError> {
        let rounding = 16.0 * f64::EPSILON;
        let [xx, yy, zz] = self.moments;
        let expected = "at most the square root of the product of its two moments of inertia, in magnitude";
        let named = [("inertia_xy", xx, yy), ("inertia_xz", xx, zz), ("inertia_yz", yy, zz)];
        let mut cosines = [0.0; 3];
        for (((name, a, b), product), cosine) in named.into_iter().zip(self.products).zip(&mut cosines) {
            if product != 0.0 {
                *cosine = product / (a.sqrt() * b.sqrt());
                if !cosine.is_finite() || cosine.abs() > 1.0 + rounding {
                    return Err(ElementError::OutOfDomain { name, value: product, expected });
                }
            }
        }
        let [p, q, r] = cosines;
        // det [1 -p -q; -p 1 -r; -q -r 1]
        if 1.0 - p * p - q * q - r * r - 2.0 * p * q * r < -rounding {
            return Err(ElementError::OutOfDomain {
                name: "inertia_yz",
                value: self.products[2],
                expected: "such that, with `inertia_xy` and `inertia_xz`, no principal moment of inertia is negative",
            });
        }
        Ok(())
    }
}

impl Element for PointMass {
    fn name(&self) -> &'static str {
        "point_mass"
    }

    fn summary(&self) -> &'static str {
        "A rigid body on one node: mass, inertia tensor about its centre of gravity, and offset."
    }

    fn theory(&self) -> &'static str {
        include_str!("point_mass.md")
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
        let mass = value!(input, mass).unwrap_or(0.0);
        let inertia = Inertia {
            moments: [value!(input, inertia_xx), value!(input, inertia_yy), value!(input, inertia_zz)]
                .map(|v| v.unwrap_or(0.0)),
            products: [value!(input, inertia_xy), value!(input, inertia_xz), value!(input, inertia_yz)]
                .map(|v| v.unwrap_or(0.0)),
        };
        inertia.check()?;
        let [x, y, z] =
            [value!(input, offset_x), value!(input, offset_y), value!(input, offset_z)].map(|v| v.unwrap_or(0.0));
        let ([xx, yy, zz], [xy, xz, yz]) = (inertia.moments, inertia.products);
        #[rustfmt::skip]
        let lower = [
            mass,
            0.0,       mass,
            0.0,       0.0,       mass,
            0.0,      -mass * z,  mass * y,  xx + mass * (y * y + z * z),
            mass * z,  0.0,      -mass * x, -xy - mass * x * y,           yy + mass * (x * x + z * z),
           -mass * y,  mass * x,  0.0,      -xz - mass * x * z,          -yz - mass * y * z,           zz + mass * (x * x + y * y),
        ];
        Ok(SymMatrix::from_lower(6, &lower))
    }

    fn samples(&self) -> Vec<Sample> {
        let body = vec![
            ("mass", 1.2),
            ("inertia_xx", 0.02),
            ("inertia_yy", 0.03),
            ("inertia_zz", 0.04),
            ("inertia_xy", 0.004),
            ("inertia_xz", -0.003),
            ("inertia_yz", 0.005),
            ("offset_x", 0.1),
            ("offset_y", -0.2),
            ("offset_z", 0.3),
        ];
        let sample = |given, mass| Sample { points: vec![[0.0; 3]], given, mass, free: true };
        vec![sample(body, 1.2), sample(vec![("inertia_yy", 0.006)], 0.0)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::DMatrix;

    fn mass_of(given: &[(&'static str, f64)]) -> Result<DMatrix<f64>, ElementError> {
        let sample = Sample { points: vec![[0.0; 3]], given: given.to_vec(), mass: 0.0, free: true };
        let values = sample.values(PROPERTIES)?;
        Ok(PointMass.mass(&ElementInput { points: &sample.points, values: &values })?.to_dense())
    }

    /// A body of four particles, its cg and inertia by their definitions (sums), against the sum of the kinetic
    /// energies of the particles about the node.
    #[test]
    fn a_cloud_of_particles_and_its_rigid_body_have_the_same_matrix() {
        let particles =
            [(0.5, [0.1, 0.2, -0.3]), (0.25, [-0.4, 0.1, 0.2]), (1.0, [0.3, -0.2, 0.1]), (0.75, [0.0, 0.4, 0.5])];
        let mut sum = DMatrix::zeros(6, 6);
        let mass: f64 = particles.iter().map(|(m, _)| m).sum();
        let mut cg = [0.0; 3];
        for (m, [x, y, z]) in particles {
            sum += mass_of(&[("mass", m), ("offset_x", x), ("offset_y", y), ("offset_z", z)]).unwrap();
            for (c, p) in cg.iter_mut().zip([x, y, z]) {
                *c += m * p / mass;
            }
        }
        let moment =
            |i: usize, j: usize| -> f64 { particles.iter().map(|(m, p)| m * (p[i] - cg[i]) * (p[j] - cg[j])).sum() };
        let body = mass_of(&[
            ("mass", mass),
            ("inertia_xx", moment(1, 1) + moment(2, 2)),
            ("inertia_yy", moment(0, 0) + moment(2, 2)),
            ("inertia_zz", moment(0, 0) + moment(1, 1)),
            ("inertia_xy", moment(0, 1)),
            ("inertia_xz", moment(0, 2)),
            ("inertia_yz", moment(1, 2)),
            ("offset_x", cg[0]),
            ("offset_y", cg[1]),
            ("offset_z", cg[2]),
        ])
        .unwrap();
        assert!((&sum - &body).abs().max() < 1e-14, "{sum}{body}");
    }

    #[test]
    fn an_impossible_product_is_named_and_a_limiting_one_passes() {
        let error = mass_of(&[("inertia_xx", 1.0), ("inertia_yy", 1.0), ("inertia_xy", 1.1)]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "property `inertia_xy` is 1.1; it must be at most the square root of the product of its two moments of \
             inertia, in magnitude"
        );
        assert!(mass_of(&[("inertia_xx", 1.0), ("inertia_xz", 1e-9)]).is_err());
        assert!(mass_of(&[("inertia_xx", 3.0), ("inertia_yy", 3.0), ("inertia_xy", 3.0)]).is_ok());
        let all = |s: f64| {
            let moments = [("inertia_xx", 1.0), ("inertia_yy", 1.0), ("inertia_zz", 1.0)];
            let products = [("inertia_xy", s), ("inertia_xz", s), ("inertia_yz", s)];
            mass_of(&[moments, products].concat())
        };
        // Eigenvalues of J are 1 + s, 1 + s, 1 - 2 s.
        assert!(all(0.5).is_ok());
        assert!(matches!(all(0.51), Err(ElementError::OutOfDomain { name: "inertia_yz", .. })));
    }
}
