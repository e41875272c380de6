//! Flat shells of three and four nodes: membrane with drilling rotations, bending and transverse shear.
//!
//! `plane` has what one point of the mean plane says (strains from the dofs of the plane), `kernel` integrates it and carries it to the
//! nodes (warp, offset), `material` reads the properties. Equations, limits and sources that both share: `shell.md`.

mod kernel;
mod material;
mod plane;
mod shell3;
mod shell4;
#[cfg(test)]
mod tests;

pub use shell3::Shell3;
pub use shell4::Shell4;

use super::{Dof, ElementInput, Sample};

/// A shell resists all motions of its nodes.
const ALL: &[Dof] = &Dof::ALL;

type Input<'a> = ElementInput<'a>;

/// Samples of both elements: isotropic and plane; orthotropic, warped where there are four nodes, off its nodes.
fn samples(flat: &[[f64; 3]], area: f64, warped: &[[f64; 3]], warped_area: f64) -> Vec<Sample> {
    let isotropic = vec![("E", 70e9), ("nu", 0.33), ("thickness", 2e-3), ("density", 2700.0)];
    let orthotropic = vec![
        ("E1", 130e9),
        ("E2", 9e9),
        ("nu12", 0.3),
        ("G12", 5e9),
        ("G13", 5e9),
        ("G23", 3e9),
        ("angle", 0.4),
        ("thickness", 4e-3),
        ("density", 1600.0),
        ("mass_per_area", 1.5),
        ("offset", 3e-3),
        ("bending_factor", 1.2),
        ("shear_factor", 0.7),
        ("lumping", 0.3),
    ];
    vec![
        Sample { points: flat.to_vec(), given: isotropic, mass: 2700.0 * 2e-3 * area, free: true },
        Sample { points: warped.to_vec(), given: orthotropic, mass: (1600.0 * 4e-3 + 1.5) * warped_area, free: true },
    ]
}

/// A shell element, from the functions of its plane.
macro_rules! shell {
    ($type:ident, $name:literal, $nodes:literal, $summary:literal, $text:literal) => {
        crate::element::meshed::meshed!(
            $type,
            $name,
            [super::ALL; $nodes],
            $summary,
            [$text, "shell.md"],
            PLANE,
            samples()
        );
    };
}
use shell;
