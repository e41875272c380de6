//! A solid trapezoid: closed moments, and Saint-Venant's torsion constant.

use retune::linalg::{DMatrix, DVector};

/// Area, height of the centroid above the bottom, ∫ y² dA and ∫ x² dA about the centroid.
///
/// * `a`, `c` - widths of the bottom and of the top; `b` - height
///
/// Source: W. C. Young, R. G. Budynas, Roark's Formulas for Stress and Strain, 2002, table A.1.
pub(super) fn moments([a, b, c]: [f64; 3]) -> [f64; 4] {
    let sum = a + c;
    [
        0.5 * sum * b,
        b * (a + 2.0 * c) / (3.0 * sum),
        b.powi(3) * (a * a + 4.0 * a * c + c * c) / (36.0 * sum),
        b * sum * (a * a + c * c) / 48.0,
    ]
}

/// Functions along the width (even ones alone, by symmetry) and along the height.
const ACROSS: usize = 9;
const UP: usize = 16;
/// Gauss points each way: exact for the polynomials.
const POINTS: usize = 28;

/// Saint-Venant's torsion constant, J = 2 ∫ φ dA with ∇²φ = -2 and φ = 0 on the boundary.
///
/// ```text
/// x = w(η) ξ,  y = b η,  w = (a (1 - η) + c η)/2,    φ = Σ q_ij (1 - ξ²) η (1 - η) P_2i(ξ) P_j(2η - 1)
/// K q = 2 f,   J = 4 fᵀ K⁻¹ f
/// ```
///
/// From below; 1e-7 of a square and of a triangle of three equal sides, 1e-5 where one side is ten times another.
pub(super) fn torsion([a, b, c]: [f64; 3]) -> f64 {
    let n = ACROSS * UP;
    let (mut stiffness, mut load) = (DMatrix::zeros(n, n), DVector::zeros(n));
    let rule = gauss(POINTS);
    for (u, wu) in &rule {
        let (eta, w_eta) = (0.5 * (1.0 + u), 0.5 * wu);
        let half = 0.5 * (a * (1.0 - eta) + c * eta);
        let slope = 0.5 * (c - a);
        for (xi, w_xi) in &rule {
            let weight = w_eta * w_xi * half * b;
            let (mut values, mut dx, mut dy) = (DVector::zeros(n), DVector::zeros(n), DVector::zeros(n));
            let (px, py) = (legendre(*xi, 2 * ACROSS), legendre(*u, UP));
            let (bubble_x, bubble_y) = (1.0 - xi * xi, eta * (1.0 - eta));
            for i in 0..ACROSS {
                let (p, dp) = px[2 * i];
                let (f, df) = (bubble_x * p, bubble_x * dp - 2.0 * xi * p);
                for (j, (q, dq)) in py.iter().enumerate().take(UP) {
                    // dP/dη is twice that by 2η - 1.
                    let (g, dg) = (bubble_y * q, bubble_y * 2.0 * dq + (1.0 - 2.0 * eta) * q);
                    let k = i * UP + j;
                    values[k] = f * g;
                    dx[k] = df * g / half;
                    dy[k] = (f * dg - slope / half * xi * df * g) / b;
                }
            }
            load.axpy(weight, &values, 1.0);
            stiffness.ger(weight, &dx, &dx, 1.0);
            stiffness.ger(weight, &dy, &dy, 1.0);
        }
    }
    let solved = stiffness.cholesky().map(|k| k.solve(&load));
    solved.map_or(0.0, |q| 4.0 * load.dot(&q))
}

/// Legendre's polynomials of degrees 0 to `n` with their derivatives.
fn legendre(x: f64, n: usize) -> Vec<(f64, f64)> {
    let mut out = vec![(1.0, 0.0), (x, 1.0)];
    for k in 2..=n {
        let ((p, d), (q, e)) = (out[k - 1], out[k - 2]);
        let m = k as f64;
        out.push((((2.0 * m - 1.0) * x * p - (m - 1.0) * q) / m, ((2.0 * m - 1.0) * (p + x * d) - (m - 1.0) * e) / m));
    }
    out
}

/// Points and weights of Gauss on [-1, 1], by Newton's method from Chebyshev's points.
fn gauss(n: usize) -> Vec<(f64, f64)> {
    let root = |i: usize| {
        let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        for _ in 0..8 {
            let (p, d) = legendre(x, n)[n];
            x -= p / d;
        }
        let d = legendre(x, n)[n].1;
        (x, 2.0 / ((1.0 - x * x) * d * d))
    };
    (0..n).map(root).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::rectangle_j;

    /// Rectangles by Saint-Venant's series; the triangle of equal sides, a⁴ √3/80 (Roark, table 10.1).
    #[test]
    fn torsion_is_that_of_the_closed_forms() {
        for (ratio, bound) in [(1.0, 1e-7), (3.0, 1e-6), (10.0, 1e-5), (0.1, 1e-5)] {
            let (found, exact) = (torsion([ratio, 1.0, ratio]), rectangle_j(ratio, 1.0));
            assert!((found / exact - 1.0).abs() < bound, "{ratio}: {found} is not {exact}");
        }
        let root = 3.0_f64.sqrt();
        for top in [1e-6, 1e-9] {
            let found = torsion([1.0, 0.5 * root, top]);
            assert!((found / (root / 80.0) - 1.0).abs() < 1e-5, "{found} is not {}", root / 80.0);
        }
    }

    /// Moments by a fine sum over the area.
    #[test]
    fn moments_are_those_of_a_fine_sum() {
        let (a, b, c) = (0.05, 0.03, 0.02);
        let [area, height, i1, i2] = moments([a, b, c]);
        let n = 2000;
        let mut sums = [0.0; 4];
        for k in 0..n {
            let eta = (f64::from(k) + 0.5) / f64::from(n);
            let (w, y) = (a + (c - a) * eta, b * eta);
            let strip = w * b / f64::from(n);
            for (sum, v) in sums.iter_mut().zip([1.0, y, (y - height).powi(2), w * w / 12.0]) {
                *sum += v * strip;
            }
        }
        for (found, sum) in [area, height * area, i1, i2].into_iter().zip(sums) {
            assert!((found / sum - 1.0).abs() < 1e-6, "{found} is not {sum}");
        }
    }
}
