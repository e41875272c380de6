//! Coordinate systems of decks: rectangular, cylindrical, spherical.

use retune::linalg::vector3::{dot, minus, plus};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Rectangular,
    Cylindrical,
    Spherical,
}

/// A coordinate system in basic coordinates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Coord {
    pub kind: Kind,
    pub origin: [f64; 3],
    pub axes: [[f64; 3]; 3],
}

pub(crate) const GLOBAL_COORD: Coord =
    Coord { kind: Kind::Rectangular, origin: [0.0; 3], axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] };

impl Coord {
    /// Basic coordinates of a point; angles are degrees.
    pub(crate) fn to_basic(self, [a, b, c]: [f64; 3]) -> [f64; 3] {
        let local = match self.kind {
            Kind::Rectangular => [a, b, c],
            Kind::Cylindrical => {
                let (sin, cos) = b.to_radians().sin_cos();
                [a * cos, a * sin, c]
            }
            Kind::Spherical => {
                let ((st, ct), (sp, cp)) = (b.to_radians().sin_cos(), c.to_radians().sin_cos());
                [a * st * cp, a * st * sp, a * ct]
            }
        };
        (0..3).fold(self.origin, |sum, i| plus(sum, local[i], self.axes[i]))
    }

    /// Directions of its coordinates at a point, as rows.
    pub(crate) fn axes_at(self, point: [f64; 3]) -> [[f64; 3]; 3] {
        let d = minus(point, self.origin);
        let [x, y, z] = self.axes.map(|a| dot(a, d));
        let of = |v: [f64; 3]| (0..3).fold([0.0; 3], |sum, i| plus(sum, v[i], self.axes[i]));
        let rho = x.hypot(y);
        // On the axis the first direction is that of the angle zero.
        let (cos, sin) = if rho > 1e-12 * (rho + z.abs()).max(1e-300) { (x / rho, y / rho) } else { (1.0, 0.0) };
        match self.kind {
            Kind::Rectangular => self.axes,
            Kind::Cylindrical => [of([cos, sin, 0.0]), of([-sin, cos, 0.0]), self.axes[2]],
            Kind::Spherical => {
                let r = rho.hypot(z);
                let (ct, st) = if r > 0.0 { (z / r, rho / r) } else { (1.0, 0.0) };
                [of([st * cos, st * sin, ct]), of([ct * cos, ct * sin, -st]), of([-sin, cos, 0.0])]
            }
        }
    }
}
