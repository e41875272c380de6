//! Closed forms of cross-sections.
//!
//! Source: W. C. Young, R. G. Budynas, Roark's Formulas for Stress and Strain, 2002, tables A.1 and 10.1; S. P. Timoshenko, J. N. Goodier,
//! Theory of Elasticity, 1970, article 109, for torsion of a rectangle.

use std::f64::consts::PI;

/// Torsion constant of a solid rectangle, to rounding.
pub(crate) fn rectangle_j(width: f64, height: f64) -> f64 {
    let (a, b) = (width.max(height), width.min(height));
    let sum: f64 = (0..40).map(|i| f64::from(2 * i + 1)).map(|n| (n * PI * a / (2.0 * b)).tanh() / n.powi(5)).sum();
    a * b.powi(3) / 3.0 * (1.0 - 192.0 * b / (PI.powi(5) * a) * sum)
}

/// Parts of a section: (width along z, height along y, y of its middle, z of its middle), negative widths for holes.
pub(crate) fn composed(parts: &[[f64; 4]]) -> [f64; 3] {
    let area = parts.iter().map(|p| p[0] * p[1]).sum();
    let [y, z] = centroid(parts);
    let i1 = parts.iter().map(|p| p[0] * p[1] * (p[1] * p[1] / 12.0 + (p[2] - y).powi(2))).sum();
    let i2 = parts.iter().map(|p| p[0] * p[1] * (p[0] * p[0] / 12.0 + (p[3] - z).powi(2))).sum();
    [area, i1, i2]
}

/// The centroid of parts, (y, z).
pub(crate) fn centroid(parts: &[[f64; 4]]) -> [f64; 2] {
    let area: f64 = parts.iter().map(|p| p[0] * p[1]).sum();
    [2, 3].map(|i| parts.iter().map(|p| p[0] * p[1] * p[i]).sum::<f64>() / area)
}

/// The product of inertia of parts about their centroid, the integral of y z.
pub(crate) fn product(parts: &[[f64; 4]]) -> f64 {
    let [y, z] = centroid(parts);
    parts.iter().map(|p| p[0] * p[1] * (p[2] - y) * (p[3] - z)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of two rectangles, whose own are zero, it is m1 m2 / (m1 + m2) dy dz.
    #[test]
    fn the_product_of_an_angle_is_that_of_its_legs() {
        // Legs of 4 x 1 and 1 x 3; their middles are (y, z) = (0.5, 2) and (2.5, 0.5).
        let parts = [[4.0, 1.0, 0.5, 2.0], [1.0, 3.0, 2.5, 0.5]];
        assert!((product(&parts) + 12.0 / 7.0 * 3.0).abs() < 1e-14);
    }

    /// a b³ times 0.1406 for a square, 0.229 for two to one, 0.291 for five to one (Timoshenko and Goodier, table 7).
    #[test]
    fn torsion_of_a_rectangle_is_that_of_the_tables() {
        for (ratio, factor) in [(1.0, 0.1406), (2.0, 0.229), (5.0, 0.291)] {
            assert!((rectangle_j(ratio, 1.0) / ratio - factor).abs() < 5e-4, "{ratio}");
        }
    }

    #[test]
    fn composed_sections_are_about_their_centre() {
        let [area, i1, i2] = composed(&[[2.0, 1.0, 0.5, 0.0], [2.0, 1.0, 1.5, 0.0]]);
        assert!(
            (area - 4.0).abs() < 1e-15
                && (i1 - 2.0 * 8.0 / 12.0).abs() < 1e-15
                && (i2 - 2.0 * 8.0 / 12.0).abs() < 1e-15
        );
    }
}
