//! The `pyramid5` element: five nodes. Equations, limits and sources: `pyramid5.md`, the documentation of [`Pyramid5`].

use super::dual::Dual;
use super::{Enrichment, Family, Lazy, rules, solid};

/// Round the base, then the apex.
pub(super) const NODES: [[f64; 3]; 5] =
    [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// What is not rational at the apex is taken just below it: 1 - ζ, at least 1e-12.
pub(super) fn below_apex(z: Dual) -> Dual {
    let below = 1.0 - z;
    if below.value < 1e-12 { Dual { value: 1e-12, ..below } } else { below }
}

/// N = (s + ξ ξ_i)(s + η η_i)/(4 s) with s = 1 - ζ, and ζ.
pub(super) fn shape([x, y, z]: [Dual; 3]) -> Vec<Dual> {
    let s = below_apex(z);
    let base = NODES[..4].iter().map(|p| (s + x * p[0]) * (s + y * p[1]) * 0.25 / s);
    base.chain([z]).collect()
}

static FAMILY: Lazy = Lazy::new(|| Family::new(shape, rules::pyramid(2), rules::pyramid(3), Enrichment::None));

solid!(
    Pyramid5,
    "pyramid5",
    5,
    "A pyramid of five nodes: joins bricks to tetrahedra, stiff in bending.",
    "pyramid5.md",
    4.0 / 3.0
);
