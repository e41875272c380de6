//! The `hex8_reduced` element: one point and hourglass stiffness. Equations, limits and sources: `hex8_reduced.md`, the documentation
//! of [`Hex8Reduced`].

use super::hex8::{NODES, shape};
use super::{Enrichment, Family, Lazy, rules, solid};

static FAMILY: Lazy = Lazy::new(|| Family::new(shape, rules::cube(1), rules::cube(2), Enrichment::Hourglass));

solid!(
    Hex8Reduced,
    "hex8_reduced",
    8,
    "A brick of eight nodes integrated at one point, with hourglass stiffness: what decks call C3D8R.",
    "hex8_reduced.md",
    8.0
);
