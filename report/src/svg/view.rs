//! From where a structure is seen: obliquely, as on the page, or straight from above.

use super::super::data::Structure;

/// Azimuth and elevation of the oblique view, rad: 69 degrees beside the axis that runs across, 36 degrees above.
const BESIDE: f64 = -1.2;
const ABOVE: f64 = 0.62;

/// A direction of sight and what of the structure it covers.
pub(super) struct View {
    axes: [usize; 3],
    azimuth: f64,
    elevation: f64,
    /// Whether all nodes lie in the plane that is seen from above.
    pub(super) flat: bool,
}

impl View {
    /// The oblique view; the longer horizontal extent runs across.
    pub(super) fn oblique(s: &Structure) -> Self {
        let up = s.up.unwrap_or(2).min(2);
        let axes = [(up + 1) % 3, (up + 2) % 3, up];
        let extent = axes.map(|k| {
            let all = || s.nodes.iter().map(|n| n.position[k]).filter(|v| v.is_finite());
            (all().fold(f64::MIN, f64::max) - all().fold(f64::MAX, f64::min)).max(0.0)
        });
        let turned = if extent[1] > extent[0] { std::f64::consts::FRAC_PI_2 } else { 0.0 };
        let flat = extent[2] <= 1e-3 * extent[0].max(extent[1]);
        Self { axes, azimuth: BESIDE + turned, elevation: ABOVE, flat }
    }

    /// Straight from above where the structure is flat, else obliquely.
    pub(super) fn plan(s: &Structure) -> Self {
        let oblique = Self::oblique(s);
        if !oblique.flat {
            return oblique;
        }
        let quarter = std::f64::consts::FRAC_PI_2;
        // The longer extent across: from behind the first axis, or from behind the second.
        let azimuth = if oblique.azimuth > 0.0 { 0.0 } else { -quarter };
        Self { azimuth, elevation: quarter, ..oblique }
    }

    /// Where a point is on paper, x to the right and y down.
    pub(super) fn at(&self, p: [f64; 3]) -> [f64; 2] {
        let (side, ahead) = self.azimuth.sin_cos();
        let (sin, cos) = self.elevation.sin_cos();
        let [x, y, z] = self.axes.map(|k| p[k]);
        [-side * x + ahead * y, -(z * cos - sin * (ahead * x + side * y))]
    }

    /// By how much a length along the upward axis is shortened.
    pub(super) fn upright(&self) -> f64 {
        self.elevation.cos()
    }

    /// Global axes with their directions on paper.
    pub(super) fn axes(&self) -> [(&'static str, [f64; 2]); 3] {
        let unit = |k: usize| std::array::from_fn(|c| f64::from(u8::from(c == k)));
        [("x", self.at(unit(0))), ("y", self.at(unit(1))), ("z", self.at(unit(2)))]
    }
}

/// Smallest and largest value of one coordinate.
pub(super) fn ends(points: &[[f64; 2]], k: usize) -> (f64, f64) {
    let finite = points.iter().map(|p| p[k]).filter(|v| v.is_finite());
    let (low, high) = finite.fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
    if low <= high { (low, high) } else { (0.0, 0.0) }
}

#[cfg(test)]
mod tests {
    use super::super::super::data::Node;
    use super::*;

    fn of(points: &[[f64; 3]]) -> Structure {
        let node = |p: &[f64; 3]| Node { name: String::new(), position: *p };
        Structure { nodes: points.iter().map(node).collect(), ..Structure::default() }
    }

    #[test]
    fn the_longer_extent_runs_across_and_flat_structures_are_seen_from_above() {
        for (points, across) in [([[0.0; 3], [3.0, 1.0, 0.0]], 0), ([[0.0; 3], [1.0, 3.0, 0.0]], 1)] {
            let s = of(&points);
            let plan = View::plan(&s);
            let unit: [f64; 3] = std::array::from_fn(|c| f64::from(u8::from(c == across)));
            let [x, y] = plan.at(unit);
            assert!((x - 1.0).abs() < 1e-12 && y.abs() < 1e-12 && plan.flat);
            // Right-handed: z points at the reader, so the other axis is found by turning against the clock.
            let other = plan.at([1.0 - unit[0], 1.0 - unit[1], 0.0]);
            assert!((other[1].abs() - 1.0).abs() < 1e-12);
            assert!(if across == 0 { other[1] < 0.0 } else { other[1] > 0.0 });
            let [x, y] = View::oblique(&s).at(unit);
            assert!(x > 0.9 && y.abs() < 0.4);
        }
        assert!(!View::plan(&of(&[[0.0; 3], [3.0, 1.0, 1.0]])).flat);
    }
}
