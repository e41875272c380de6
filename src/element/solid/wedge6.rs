//! The `wedge6` element: six nodes. Equations, limits and sources: `wedge6.md`, the documentation of [`Wedge6`].

use super::dual::Dual;
use super::{Enrichment, Family, Lazy, rules, solid};

/// The lower triangle, then the upper one.
pub(super) const NODES: [[f64; 3]; 6] =
    [[0.0, 0.0, -1.0], [1.0, 0.0, -1.0], [0.0, 1.0, -1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];

/// N = L (1 ∓ ζ)/2 with the area coordinates L = 1 - ξ - η, ξ, η.
pub(super) fn shape([x, y, z]: [Dual; 3]) -> Vec<Dual> {
    let l = [1.0 - x - y, x, y];
    let lower = l.map(|l| l * (1.0 - z) * 0.5);
    [lower, l.map(|l| l * (z + 1.0) * 0.5)].concat()
}

static FAMILY: Lazy = Lazy::new(|| Family::new(shape, rules::wedge(3, 2), rules::wedge(3, 2), Enrichment::None));

solid!(Wedge6, "wedge6", 6, "A wedge of six nodes: fills between bricks, stiff in bending.", "wedge6.md", 1.0);
