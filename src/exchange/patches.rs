//! Shells of eight and six nodes as patches of flat shells on the same nodes: corners first, then the middles of the edges from the first on.

use crate::model::{cross, dot, minus, plus, unit};

/// A patch: type and indices of nodes of each of its shells.
pub(super) type Patch = &'static [(&'static str, &'static [usize])];

/// Four triangles at the corners and a quadrilateral between the middles.
pub(super) const QUADRILATERAL: Patch = &[
    ("shell4", &[4, 5, 6, 7]),
    ("shell3", &[0, 4, 7]),
    ("shell3", &[1, 5, 4]),
    ("shell3", &[2, 6, 5]),
    ("shell3", &[3, 7, 6]),
];

/// Triangles alone, the middle parted from the second edge to the fourth, or from the first to the third.
const PARTED: [Patch; 2] = [
    &[
        ("shell3", &[0, 4, 7]),
        ("shell3", &[1, 5, 4]),
        ("shell3", &[2, 6, 5]),
        ("shell3", &[3, 7, 6]),
        ("shell3", &[4, 5, 7]),
        ("shell3", &[5, 6, 7]),
    ],
    &[
        ("shell3", &[0, 4, 7]),
        ("shell3", &[1, 5, 4]),
        ("shell3", &[2, 6, 5]),
        ("shell3", &[3, 7, 6]),
        ("shell3", &[4, 5, 6]),
        ("shell3", &[4, 6, 7]),
    ],
];

/// How far the middles of two opposite edges may stand off the others, over the distance between them, for a plane patch.
const PLANE: f64 = 1e-3;

/// The patch of eight nodes: a quadrilateral between the middles of the edges where they lie in a plane. On a curved surface that one would stand across
/// the curvature, which its straight edges cannot follow: triangles alone, parted along the diagonal that lies nearer to the surface.
///
/// Of a panel of 8 x 6 elements on a cylinder (sides 0.4 and 0.3 m, radius 0.3 m, 3 mm) the first frequency is 1 % above the converged one so, and 7 % with
/// the quadrilateral.
pub(super) fn quadrilateral(points: &[[f64; 3]]) -> Patch {
    let &[a, b, c, d, ab, bc, cd, da] = points else { return QUADRILATERAL };
    let middle = |p: [f64; 3], q| plus(p.map(|v| 0.5 * v), 0.5, q);
    let (along, across) = (minus(bc, da), minus(cd, ab));
    let between = minus(middle(bc, da), middle(ab, cd));
    let Some(normal) = unit(cross(along, across)) else { return QUADRILATERAL };
    let length = dot(along, along).max(dot(across, across)).sqrt();
    if dot(between, normal).abs() <= PLANE * length {
        return QUADRILATERAL;
    }
    // The middle of the serendipity surface: half of the sum of the middles less a quarter of that of the corners.
    let centre: [f64; 3] =
        std::array::from_fn(|i| 0.5 * (ab[i] + bc[i] + cd[i] + da[i]) - 0.25 * (a[i] + b[i] + c[i] + d[i]));
    let off = |p, q| {
        let away = minus(middle(p, q), centre);
        dot(away, away)
    };
    PARTED[usize::from(off(ab, cd) < off(bc, da))]
}

/// Four triangles.
pub(super) const TRIANGLE: Patch =
    &[("shell3", &[0, 3, 5]), ("shell3", &[3, 1, 4]), ("shell3", &[5, 4, 2]), ("shell3", &[3, 4, 5])];

/// What that approximates, for reports.
pub(super) const DIFFERS: &str =
    "shells of eight and six nodes are a patch of flat shells on the same nodes: they need a finer mesh";

#[cfg(test)]
mod tests {
    use super::*;

    /// The eight nodes of a square of two by two on a surface.
    fn on(height: impl Fn(f64, f64) -> f64) -> Vec<[f64; 3]> {
        let at = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]];
        at.map(|[x, y]| [x, y, height(x, y)]).to_vec()
    }

    /// Edges of every triangle and quadrilateral, each once from either side but for the outer ones.
    #[test]
    fn patches_close() {
        for patch in [QUADRILATERAL, PARTED[0], PARTED[1], TRIANGLE] {
            let mut edges: Vec<[usize; 2]> = Vec::new();
            for (_, nodes) in patch {
                edges.extend((0..nodes.len()).map(|i| [nodes[i], nodes[(i + 1) % nodes.len()]]));
            }
            let outer = edges.iter().filter(|[a, b]| !edges.contains(&[*b, *a])).count();
            assert_eq!(outer, if patch == TRIANGLE { 6 } else { 8 }, "{patch:?}");
            assert!((0..edges.len()).all(|i| !edges[i + 1..].contains(&edges[i])), "{patch:?}");
        }
    }

    #[test]
    fn on_a_curved_surface_the_middle_is_parted_along_it() {
        assert_eq!(quadrilateral(&on(|x, y| 0.3 * x - 0.1 * y)), QUADRILATERAL);
        // A cylinder along y is straight from the first edge to the third, one along x from the second to the fourth.
        assert_eq!(quadrilateral(&on(|x, _| 0.1 * x * x)), PARTED[1]);
        assert_eq!(quadrilateral(&on(|_, y| -0.1 * y * y)), PARTED[0]);
        // A sphere has no such line, and its middles lie in a plane.
        assert_eq!(quadrilateral(&on(|x, y| 0.1 * (x * x + y * y))), QUADRILATERAL);
    }
}
