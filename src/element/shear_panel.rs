//! The `shear_panel` element. Equations, limits and sources: `shear_panel.md`, the documentation of [`ShearPanel`].

use super::direction::unit;
use super::{Axes, Dof, Domain, Element, ElementError, ElementInput, Lack, Property, Sample, value};
use crate::linalg::vector3::{Vector3, cross, dot, minus};
use crate::linalg::{DVector, SymMatrix};

#[doc = include_str!("shear_panel.md")]
#[derive(Debug, Clone, Copy)]
pub struct ShearPanel;

const PROPERTIES: &[Property] = &[
    Property::new("G", "Pa", Domain::Positive, "shear modulus"),
    Property::new("nu", "1", Domain::Any, "Poisson's ratio, above -1 and at most 0.5; 0 when absent"),
    Property::new("thickness", "m", Domain::Positive, "thickness"),
    Property::new("density", "kg/m3", Domain::NonNegative, "density; no mass of its own when absent"),
    Property::new("mass_per_area", "kg/m2", Domain::NonNegative, "non-structural mass"),
    Property::new(
        "lumping",
        "1",
        Domain::Fraction,
        "0 for the consistent mass (when absent), 1 for one lumped at the nodes, a mean of both between",
    ),
];

/// Signs of the natural coordinates of the corners.
const CORNERS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

/// The corners in the plane of the diagonals, and the weights of the projective map onto them.
struct Flat {
    at: [[f64; 2]; 4],
    weight: [f64; 4],
    diagonals: [Vector3; 2],
}

impl Flat {
    fn new(points: &[Vector3]) -> Result<Self, ElementError> {
        let diagonals = [minus(points[2], points[0]), minus(points[3], points[1])];
        let normal = unit(cross(diagonals[0], diagonals[1]))?;
        let x = unit(diagonals[0])?;
        let y = cross(normal, x);
        let at = [0, 1, 2, 3].map(|i: usize| [dot(points[i], x), dot(points[i], y)]);
        // Where the diagonals cross, as fractions of each: the square's crossing is (1 : 1) of both, weights shift it.
        let [p, q] = diagonals.map(|d| [dot(d, x), dot(d, y)]);
        let det = p[0] * q[1] - p[1] * q[0];
        let from = [at[1][0] - at[0][0], at[1][1] - at[0][1]];
        let s = (from[0] * q[1] - from[1] * q[0]) / det;
        let t = (from[0] * p[1] - from[1] * p[0]) / det;
        let is_convex = |v: f64| v > 1e-6 && v < 1.0 - 1e-6;
        if !(is_convex(s) && is_convex(t)) {
            return Err(ElementError::Inverted);
        }
        // w1 (1-s) ... : the image of the centre divides each diagonal by its weights, w3/(w1 + w3) = s and w4/(w2 + w4) = t.
        // One centre for both: w1 + w3 = w2 + w4.
        Ok(Self { at, weight: [1.0 - s, 1.0 - t, s, t].map(|w| 2.0 * w), diagonals })
    }

    /// Map, its derivatives by ξ and η, and w, at a point of the square.
    fn map(&self, [x, y]: [f64; 2]) -> ([[f64; 2]; 2], f64) {
        let n = CORNERS.map(|[a, b]| 0.25 * (1.0 + a * x) * (1.0 + b * y));
        let dn = CORNERS.map(|[a, b]| [0.25 * a * (1.0 + b * y), 0.25 * b * (1.0 + a * x)]);
        let sum = |of: &dyn Fn(usize) -> f64| (0..4).map(|i| of(i) * self.weight[i]).sum::<f64>();
        let w = sum(&|i| n[i]);
        let slopes = [0, 1].map(|k: usize| sum(&|i| dn[i][k]));
        let d = [0, 1].map(|axis: usize| {
            let r = sum(&|i| n[i] * self.at[i][axis]) / w;
            [0, 1].map(|k: usize| (sum(&|i| dn[i][k] * self.at[i][axis]) - r * slopes[k]) / w)
        });
        (d, w)
    }

    /// Nodal forces of the unit state.
    fn forces(&self) -> DVector<f64> {
        let mut g = DVector::zeros(24);
        for (k, (from, to, sign)) in [(0, 2, 1.0), (1, 3, -1.0)].into_iter().enumerate() {
            let w = 0.5 * sign * self.weight[from] * self.weight[to];
            for (i, d) in self.diagonals[k].into_iter().enumerate() {
                g[6 * to + i] += w * d;
                g[6 * from + i] -= w * d;
            }
        }
        g
    }

    /// ∫ of f(D, w, J) J dξ dη, by four points a side.
    fn integral(&self, f: impl Fn([[f64; 2]; 2], f64, f64, [f64; 2]) -> f64) -> f64 {
        const LINE: [(f64, f64); 4] = [
            (-0.861_136_311_594_052_6, 0.347_854_845_137_453_9),
            (-0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
            (0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
            (0.861_136_311_594_052_6, 0.347_854_845_137_453_9),
        ];
        let mut sum = 0.0;
        for (x, a) in LINE {
            for (y, b) in LINE {
                let (d, w) = self.map([x, y]);
                let j = d[0][0] * d[1][1] - d[0][1] * d[1][0];
                sum += a * b * j * f(d, w, j, [x, y]);
            }
        }
        sum
    }
}

fn read(input: &ElementInput<'_>) -> Result<(Option<f64>, f64), ElementError> {
    input.check(&ShearPanel)?;
    let nu = value!(input, nu).unwrap_or(0.0);
    if !(nu > -1.0 && nu <= 0.5) {
        return Err(ElementError::OutOfDomain { name: "nu", value: nu, expected: "above -1 and at most 0.5" });
    }
    Ok((value!(input, G), nu))
}

fn thickness(input: &ElementInput<'_>) -> Result<f64, ElementError> {
    value!(input, thickness).ok_or(ElementError::Missing { name: "thickness", why: "a panel needs its thickness" })
}

impl Element for ShearPanel {
    fn name(&self) -> &'static str {
        "shear_panel"
    }

    fn summary(&self) -> &'static str {
        "A panel of four nodes that carries shear alone, between members along its edges."
    }

    fn theory(&self) -> &'static str {
        include_str!("shear_panel.md")
    }

    fn nodes(&self) -> &'static [&'static [Dof]] {
        const TRANSLATIONS: &[Dof] = &[Dof::Ux, Dof::Uy, Dof::Uz];
        &[TRANSLATIONS; 4]
    }

    fn properties(&self) -> &'static [Property] {
        PROPERTIES
    }

    fn axes(&self) -> Axes {
        Axes::Given
    }

    fn stiffness(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        let (g, nu) = read(input)?;
        let flat = Flat::new(input.points)?;
        let mut k = SymMatrix::zeros(24);
        let Some(g) = g else { return Ok(k) };
        let z = flat.integral(|d, w, j, _| {
            let of = |a: usize, b: usize| w * w / j * (d[a][0] * d[b][1] + d[a][1] * d[b][0]);
            let (xx, yy, xy) = (of(0, 0), of(1, 1), of(0, 1));
            let e = 2.0 * g * (1.0 + nu);
            (xx * xx + yy * yy - 2.0 * nu * xx * yy) / e + xy * xy / g
        }) / thickness(input)?;
        let force = flat.forces();
        for i in 0..24 {
            for j in 0..=i {
                k.add(i, j, force[i] * force[j] / z);
            }
        }
        Ok(k)
    }

    fn mass(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        read(input)?;
        let flat = Flat::new(input.points)?;
        let mut m = SymMatrix::zeros(24);
        let own = match value!(input, density) {
            Some(rho) => rho * thickness(input)?,
            None => 0.0,
        };
        let by_area = own + value!(input, mass_per_area).unwrap_or(0.0);
        let lumping = value!(input, lumping).unwrap_or(0.0);
        // Functions of the corners, on the bilinear map.
        let bilinear = Flat { weight: [1.0; 4], ..flat };
        let shape = |[x, y]: [f64; 2], i: usize| 0.25 * (1.0 + CORNERS[i][0] * x) * (1.0 + CORNERS[i][1] * y);
        for i in 0..4 {
            let share = bilinear.integral(|_, _, _, at| shape(at, i));
            for j in 0..=i {
                let both = bilinear.integral(|_, _, _, at| shape(at, i) * shape(at, j));
                let lumped = if i == j { lumping * share } else { 0.0 };
                for d in 0..3 {
                    m.add(6 * i + d, 6 * j + d, by_area * ((1.0 - lumping) * both + lumped));
                }
            }
        }
        Ok(m)
    }

    fn is_scalar(&self) -> bool {
        true
    }

    fn lacks(&self, _: &ElementInput<'_>) -> Vec<Lack> {
        Vec::new()
    }

    fn samples(&self) -> Vec<Sample> {
        let plane = vec![[0.0; 3], [0.4, 0.05, 0.0], [0.35, 0.3, 0.0], [-0.05, 0.25, 0.0]];
        let area = 0.5 * (0.35 * 0.2 + 0.45 * 0.3);
        let given = vec![("G", 27e9), ("nu", 0.33), ("thickness", 1e-3), ("density", 2700.0), ("mass_per_area", 0.4)];
        let warped = vec![[0.0; 3], [0.4, 0.0, -0.02], [0.4, 0.3, 0.0], [0.0, 0.3, -0.02]];
        let bare = vec![("G", 5e9), ("thickness", 2e-3), ("density", 1600.0), ("lumping", 0.4)];
        vec![
            Sample { points: plane, given, mass: (2.7 + 0.4) * area, free: true },
            Sample { points: warped, given: bare, mass: 3.2 * 0.12, free: true },
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::DMatrix;

    fn stiffness(points: &[Vector3]) -> DMatrix<f64> {
        let values = [Some(26e9), Some(0.3), Some(1e-3), None, None, None];
        let k = ShearPanel.stiffness(&ElementInput { points, values: &values }).unwrap();
        DMatrix::from_fn(24, 24, |i, j| k.get(i, j))
    }

    /// The one eigenvalue: |g|²/Z.
    fn flexibility(points: &[Vector3]) -> f64 {
        let flat = Flat::new(points).unwrap();
        flat.forces().norm_squared() / stiffness(points).trace()
    }

    /// Mean shear strain γ = (Δu/b + Δv/a)/2 + ... of a rectangle: a unit of γ costs ½ G t a b.
    #[test]
    fn a_rectangle_shears_by_g_t() {
        let (a, b) = (0.5, 0.2);
        let k = stiffness(&[[0.0; 3], [a, 0.0, 0.0], [a, b, 0.0], [0.0, b, 0.0]]);
        let mut u = DVector::zeros(24);
        let gamma = 1e-3;
        (u[12], u[18]) = (gamma * b, gamma * b);
        let energy = 0.5 * (u.transpose() * &k * &u)[(0, 0)];
        assert!((energy / (0.5 * 26e9 * 1e-3 * a * b * gamma * gamma) - 1.0).abs() < 1e-12);
        let mut stretch = DVector::zeros(24);
        (stretch[6], stretch[12]) = (1e-3, 1e-3);
        assert!((&k * stretch).amax() < 1e-6 * k.amax() * 1e-3);
    }

    /// Garvey's parallelogram, Z = A/(G t) (1 + 2 tan²θ/(1 + ν)), and trapezoid,
    /// Z = p1 p2/(p3 p4) A/(G t) (1 + 2/(3 (1 + ν)) (s² + s c + c²)) for the shear flow of the first side (NASA SP-221, 5.3).
    #[test]
    fn skew_panels_are_garveys() {
        let (g, t, nu) = (26e9, 1e-3, 0.3);
        for skew in [0.0, 0.1, 0.3] {
            let (a, b) = (0.5, 0.2);
            let points = [[0.0; 3], [a, 0.0, 0.0], [a + skew, b, 0.0], [skew, b, 0.0]];
            let tangent = skew / b;
            let exact = a * b / (g * t) * (1.0 + 2.0 * tangent * tangent / (1.0 + nu));
            assert!((flexibility(&points) / exact - 1.0).abs() < 1e-12, "{skew}");
        }
        // Sides 12 and 34 are parallel; the others meet at height yp above the first, at xp.
        let (x2, x4, x3, y): (f64, f64, f64, f64) = (0.5, 0.1, 0.35, 0.2);
        let points = [[0.0; 3], [x2, 0.0, 0.0], [x3, y, 0.0], [x4, y, 0.0]];
        let yp = x2 * y / (x4 - (x3 - x2));
        let xp = yp * x4 / y;
        let (s, c) = ((x2 - xp) / yp, -xp / yp);
        let area = 0.5 * y * (x2 + x3 - x4);
        let [p1, p3] = [yp, yp - y];
        let exact = (p1 / p3).powi(2) * area / (g * t) * (1.0 + 2.0 / (3.0 * (1.0 + nu)) * (s * s + s * c + c * c));
        // That of the flow of the first side: its force over its length is that of the unit state times w1 w2.
        let w = Flat::new(&points).unwrap().weight;
        let own = flexibility(&points) / (w[0] * w[1]).powi(2);
        assert!((own / exact - 1.0).abs() < 1e-5, "{own} {exact}");
    }

    #[test]
    fn a_corner_that_is_none_is_refused() {
        let values = [Some(26e9), None, Some(1e-3), None, None, None];
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.2, 0.2, 0.0], [0.0, 1.0, 0.0]];
        let input = ElementInput { points: &points, values: &values };
        assert!(ShearPanel.stiffness(&input).is_err());
    }
}
