//! The `hex20_reduced` element: eight points. Equations, limits and sources: `hex20_reduced.md`, the documentation of [`Hex20Reduced`].

use super::hex20::{NODES, shape};
use super::rules::Rule;
use super::{Enrichment, Family, Lazy, rules, solid};

/// What of stiffness and mass is taken at 27 points, so that the patterns which eight do not see are held and have mass.
const HELD: f64 = 1e-4;

fn points() -> Rule {
    let scaled = |rule: Rule, factor: f64| rule.into_iter().map(move |(at, weight)| (at, factor * weight));
    scaled(rules::cube(2), 1.0 - HELD).chain(scaled(rules::cube(3), HELD)).collect()
}

static FAMILY: Lazy = Lazy::new(|| Family::new(shape, points(), points(), Enrichment::None));

solid!(
    Hex20Reduced,
    "hex20_reduced",
    20,
    "A quadratic brick of twenty nodes integrated at eight points: what decks call C3D20R.",
    "hex20_reduced.md",
    8.0
);
