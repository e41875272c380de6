//! Quadratures over the parents of solids: points in natural coordinates with their weights.

/// Points and weights.
pub(super) type Rule = Vec<([f64; 3], f64)>;

/// Gauss's abscissae and weights on [-1, 1]; exact to degree 2n - 1.
///
/// M. Abramowitz, I. A. Stegun, Handbook of Mathematical Functions, 1964, table 25.4.
fn gauss(n: usize) -> Vec<(f64, f64)> {
    match n {
        1 => vec![(0.0, 2.0)],
        2 => {
            let x = 1.0 / 3.0_f64.sqrt();
            vec![(-x, 1.0), (x, 1.0)]
        }
        _ => {
            let x = 0.6_f64.sqrt();
            vec![(-x, 5.0 / 9.0), (0.0, 8.0 / 9.0), (x, 5.0 / 9.0)]
        }
    }
}

/// n³ points on the cube [-1, 1]³.
pub(super) fn cube(n: usize) -> Rule {
    let line = gauss(n);
    let mut rule = Vec::with_capacity(n * n * n);
    for &(x, a) in &line {
        for &(y, b) in &line {
            rule.extend(line.iter().map(|&(z, c)| ([x, y, z], a * b * c)));
        }
    }
    rule
}

/// Points on the triangle x, y ≥ 0, x + y ≤ 1, of area 1/2: 3 points (degree 2) or 7 points (degree 5).
///
/// G. R. Cowper, Gaussian quadrature formulas for triangles, Int. J. Numer. Meth. Engng 7 (1973) 405-408.
pub(super) fn triangle(points: usize) -> Vec<([f64; 2], f64)> {
    let three = |a: f64, w: f64| {
        let b = 1.0 - 2.0 * a;
        [([a, a], 0.5 * w), ([b, a], 0.5 * w), ([a, b], 0.5 * w)]
    };
    if points == 3 {
        return three(1.0 / 6.0, 1.0 / 3.0).to_vec();
    }
    let root = 15.0_f64.sqrt();
    let mut rule = vec![([1.0 / 3.0; 2], 0.5 * 0.225)];
    rule.extend(three((6.0 - root) / 21.0, (155.0 - root) / 1200.0));
    rule.extend(three((6.0 + root) / 21.0, (155.0 + root) / 1200.0));
    rule
}

/// Triangles times lines: 0 ≤ x, y, x + y ≤ 1, -1 ≤ z ≤ 1.
pub(super) fn wedge(of_triangle: usize, of_line: usize) -> Rule {
    let line = gauss(of_line);
    let product = |([x, y], a): ([f64; 2], f64)| line.iter().map(move |&(z, c)| ([x, y, z], a * c)).collect::<Vec<_>>();
    triangle(of_triangle).into_iter().flat_map(product).collect()
}

/// Points on the tetrahedron x, y, z ≥ 0, x + y + z ≤ 1, of volume 1/6: 1 point (degree 1), 4 points (degree 2) or 15 points
/// (degree 5).
///
/// P. Keast, Moderate-degree tetrahedral quadrature formulas, Comput. Meth. Appl. Mech. Engng 55 (1986) 339-348.
pub(super) fn tetrahedron(points: usize) -> Rule {
    let four = |a: f64, w: f64| {
        let b = 1.0 - 3.0 * a;
        [[a, a, a], [b, a, a], [a, b, a], [a, a, b]].map(|x| (x, w / 6.0))
    };
    match points {
        1 => vec![([0.25; 3], 1.0 / 6.0)],
        4 => four((5.0 - 5.0_f64.sqrt()) / 20.0, 0.25).to_vec(),
        _ => {
            let root = 15.0_f64.sqrt();
            let mut rule = vec![([0.25; 3], 16.0 / 135.0 / 6.0)];
            rule.extend(four((7.0 - root) / 34.0, (2665.0 + 14.0 * root) / 37800.0));
            rule.extend(four((7.0 + root) / 34.0, (2665.0 - 14.0 * root) / 37800.0));
            let (a, b) = ((5.0 - root) / 20.0, (5.0 + root) / 20.0);
            let six = [[a, a, b], [a, b, a], [b, a, a], [a, b, b], [b, a, b], [b, b, a]];
            rule.extend(six.map(|x| (x, 10.0 / 189.0 / 6.0)));
            rule
        }
    }
}

/// Points on the pyramid |x|, |y| ≤ 1 - z, 0 ≤ z ≤ 1, of volume 4/3: those of a cube, drawn together towards the apex; exact where
/// the integrand in (x/(1-z), y/(1-z), z) times (1-z)² has a degree below 2n in each.
pub(super) fn pyramid(n: usize) -> Rule {
    let on_pyramid = |([a, b, c], w): ([f64; 3], f64)| {
        let z = 0.5 * (1.0 + c);
        let s = 1.0 - z;
        ([a * s, b * s, z], 0.5 * w * s * s)
    };
    cube(n).into_iter().map(on_pyramid).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn integral(rule: &Rule, powers: [i32; 3]) -> f64 {
        rule.iter().map(|(x, w)| w * (0..3).map(|i| x[i].powi(powers[i])).product::<f64>()).sum()
    }

    fn factorial(n: i32) -> f64 {
        (1..=n).map(f64::from).product()
    }

    /// ∫ xᵃ yᵇ zᶜ over the tetrahedron is a! b! c!/(a + b + c + 3)!, over the triangle a! b!/(a + b + 2)!.
    #[test]
    fn simplices_are_exact_to_their_degree() {
        for (points, degree) in [(1, 1), (4, 2), (15, 5)] {
            for [a, b, c] in powers(degree) {
                let exact = factorial(a) * factorial(b) * factorial(c) / factorial(a + b + c + 3);
                let error = integral(&tetrahedron(points), [a, b, c]) / exact - 1.0;
                assert!(error.abs() < 1e-12, "{points} points, {a}{b}{c}: {error:e}");
            }
        }
        for (points, degree) in [(3, 2), (7, 5)] {
            for [a, b, c] in powers(degree).into_iter().filter(|p| p[2] == 0) {
                let exact = 2.0 * factorial(a) * factorial(b) / factorial(a + b + 2);
                let error = integral(&wedge(points, 2), [a, b, c]) / exact - 1.0;
                assert!(error.abs() < 1e-12, "{points} points, {a}{b}: {error:e}");
            }
        }
    }

    /// ∫ z^c over the pyramid is 4 ∫ z^c (1-z)² dz = 8 c!/(c + 3)!; ∫ x² is 4/3 ∫ (1-z)⁴ dz = 4/15.
    #[test]
    fn the_pyramid_is_exact() {
        for c in 0..4 {
            let exact = 8.0 * factorial(c) / factorial(c + 3);
            assert!((integral(&pyramid(3), [0, 0, c]) / exact - 1.0).abs() < 1e-12);
        }
        assert!((integral(&pyramid(3), [2, 0, 0]) - 4.0 / 15.0).abs() < 1e-14);
    }

    fn powers(degree: i32) -> Vec<[i32; 3]> {
        let all = (0..=degree).flat_map(|a| (0..=degree).flat_map(move |b| (0..=degree).map(move |c| [a, b, c])));
        all.filter(|p| p.iter().sum::<i32>() <= degree).collect()
    }
}
