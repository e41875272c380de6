//! Isoparametric solids: one kernel, one file of shape functions per element.
//!
//! An element is a [`Family`]: its nodes in natural coordinates, its shape functions with their derivatives at the points of two
//! quadratures (stiffness, mass), computed once. Equations, properties, limits and sources that all share: `solid.md`.

mod dual;
mod hex20;
mod hex20_reduced;
mod hex8;
mod hex8_reduced;
mod kernel;
mod material;
mod pyramid13;
mod pyramid5;
mod rules;
mod strains;
#[cfg(test)]
mod tests;
mod tet10;
mod tet4;
mod wedge15;
mod wedge6;

pub use hex8::Hex8;
pub use hex8_reduced::Hex8Reduced;
pub use hex20::Hex20;
pub use hex20_reduced::Hex20Reduced;
pub use pyramid5::Pyramid5;
pub use pyramid13::Pyramid13;
pub use tet4::Tet4;
pub use tet10::Tet10;
pub use wedge6::Wedge6;
pub use wedge15::Wedge15;

use super::{Dof, ElementInput, Sample};
use dual::Dual;
use rules::Rule;
use std::sync::LazyLock;

/// Displacements: a solid resists no rotation of its nodes.
const TRANSLATIONS: &[Dof] = &[Dof::Ux, Dof::Uy, Dof::Uz];

/// What the stiffness has beside that of its shape functions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Enrichment {
    None,
    /// Three incompatible modes 1 - ξ², condensed.
    IncompatibleModes,
    /// The stiffness of the four hourglass patterns that one point does not see.
    Hourglass,
}

/// Shape functions and their natural derivatives at a point of a rule.
#[derive(Debug, Clone)]
struct At {
    /// Natural coordinates.
    xi: [f64; 3],
    /// Weight of the rule.
    weight: f64,
    /// N of every node.
    n: Vec<f64>,
    /// ∂N/∂ξ of every node.
    d: Vec<[f64; 3]>,
}

/// Shape functions of one element, tabulated.
struct Family {
    shape: fn([Dual; 3]) -> Vec<Dual>,
    stiffness: Vec<At>,
    mass: Vec<At>,
    enrichment: Enrichment,
}

impl Family {
    /// Tabulates shape functions at the points of two rules.
    fn new(shape: fn([Dual; 3]) -> Vec<Dual>, stiffness: Rule, mass: Rule, enrichment: Enrichment) -> Self {
        let table = |rule: Rule| rule.into_iter().map(|(xi, weight)| At::new(shape, xi, weight)).collect();
        Self { shape, stiffness: table(stiffness), mass: table(mass), enrichment }
    }
}

impl At {
    fn new(shape: fn([Dual; 3]) -> Vec<Dual>, xi: [f64; 3], weight: f64) -> Self {
        let values = shape(std::array::from_fn(|i| Dual::variable(xi[i], i)));
        Self { xi, weight, n: values.iter().map(|v| v.value).collect(), d: values.iter().map(|v| v.slope).collect() }
    }
}

/// A parent element stretched and sheared by the same affine map for every family, as a sample of isotropic material; for elements
/// with nodes on edges these stay in the middle.
fn sample(nodes: &[[f64; 3]], parent_volume: f64) -> [Sample; 3] {
    // Columns of the map: x = A ξ, det A = 0.2 · 0.15 · 0.1.
    let map = |p: [f64; 3]| [0.2 * p[0] + 0.05 * p[1], 0.15 * p[1] + 0.02 * p[2], 0.1 * p[2]];
    let origin = map(nodes[0]);
    let points: Vec<[f64; 3]> = nodes.iter().map(|p| std::array::from_fn(|i| map(*p)[i] - origin[i])).collect();
    let volume = 0.2 * 0.15 * 0.1 * parent_volume;
    let isotropic = vec![("E", 70e9), ("nu", 0.33), ("density", 2700.0), ("lumping", 0.5)];
    let orthotropic = vec![
        ("E1", 130e9),
        ("E2", 9e9),
        ("E3", 8e9),
        ("nu12", 0.3),
        ("nu13", 0.28),
        ("nu23", 0.4),
        ("G12", 5e9),
        ("G13", 4.5e9),
        ("G23", 3e9),
        ("density", 1600.0),
    ];
    let mut preloaded = isotropic.clone();
    preloaded.extend([("S11", 4e6), ("S22", 2e6), ("S33", 1e6), ("S12", -1e6), ("S23", 0.5e6), ("S13", 0.3e6)]);
    [
        Sample { points: points.clone(), given: preloaded, mass: 2700.0 * volume, free: false },
        Sample { points: points.clone(), given: isotropic, mass: 2700.0 * volume, free: true },
        Sample { points, given: orthotropic, mass: 1600.0 * volume, free: true },
    ]
}

/// A solid element, from its family.
macro_rules! solid {
    ($type:ident, $name:literal, $nodes:literal, $summary:literal, $text:literal, $volume:expr) => {
        crate::element::meshed::meshed!(
            pub $type,
            $name,
            [super::TRANSLATIONS; $nodes],
            $summary,
            [$text, "solid.md"],
            FAMILY,
            super::sample(&NODES, $volume).to_vec()
        );
    };
}
use solid;

/// Shape functions of a family at a natural point, for tests.
#[cfg(test)]
fn values(shape: fn([Dual; 3]) -> Vec<Dual>, xi: [f64; 3]) -> Vec<f64> {
    At::new(shape, xi, 1.0).n
}

type Lazy = LazyLock<Family>;
type Input<'a> = ElementInput<'a>;
