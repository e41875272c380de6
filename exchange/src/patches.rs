//! Shells of eight and six nodes as patches of flat shells on the same nodes: corners first, then the middles of the edges from the first on.

/// A patch: type and indices of nodes of each of its shells.
pub(super) type Patch = &'static [(&'static str, &'static [usize])];

/// Four quadrilaterals around a node in the middle, which is behind the eight. Between the middles of the edges alone a quadrilateral would stand across
/// the curvature of a surface, which its straight edges cannot follow, and triangles beside it are poor in their plane.
pub(super) const QUADRILATERAL: Patch =
    &[("shell4", &[0, 4, 8, 7]), ("shell4", &[4, 1, 5, 8]), ("shell4", &[8, 5, 2, 6]), ("shell4", &[7, 8, 6, 3])];

/// Four triangles.
pub(super) const TRIANGLE: Patch =
    &[("shell3", &[0, 3, 5]), ("shell3", &[3, 1, 4]), ("shell3", &[5, 4, 2]), ("shell3", &[3, 4, 5])];

/// What that approximates, for reports.
pub(super) const DIFFERS: &str =
    "shells of eight and six nodes are a patch of four flat shells each: equal to the solver's as the mesh gets finer";

/// What stands behind the node in the middle of a patch.
pub(super) const CENTRE: &str = "middle of a shell of eight nodes";

/// The middle of the serendipity surface through eight nodes: half of the sum of the middles of the edges less a quarter of that of the corners.
pub(super) fn centre(points: &[[f64; 3]]) -> [f64; 3] {
    let sum = |of: &[[f64; 3]], i: usize| of.iter().map(|p| p[i]).sum::<f64>();
    std::array::from_fn(|i| 0.5 * sum(&points[4..8], i) - 0.25 * sum(&points[..4], i))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Edges of every shell are those of another the other way round, but for the outer ones.
    #[test]
    fn patches_close() {
        for (patch, outer) in [(QUADRILATERAL, 8), (TRIANGLE, 6)] {
            let mut edges: Vec<[usize; 2]> = Vec::new();
            for (_, nodes) in patch {
                edges.extend((0..nodes.len()).map(|i| [nodes[i], nodes[(i + 1) % nodes.len()]]));
            }
            assert_eq!(edges.iter().filter(|[a, b]| !edges.contains(&[*b, *a])).count(), outer, "{patch:?}");
            assert!((0..edges.len()).all(|i| !edges[i + 1..].contains(&edges[i])), "{patch:?}");
        }
    }

    /// On any surface of second order the middle lies on it.
    #[test]
    fn the_middle_is_on_the_surface() {
        let height = |x: f64, y: f64| 0.3 + 0.1 * x - 0.2 * y + 0.4 * x * x + 0.7 * x * y - 0.5 * y * y;
        let at = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]];
        let [x, y, z] = centre(&at.map(|[x, y]| [x, y, height(x, y)]));
        assert!(x.abs() < 1e-15 && y.abs() < 1e-15 && (z - 0.3).abs() < 1e-15, "{x} {y} {z}");
    }
}
