//! Flat shells of three and four nodes: membrane with drilling rotations, bending and transverse shear.
//!
//! `plane` has what one point of the mean plane says (strains from the dofs of the plane), `kernel` integrates it and carries it to the
//! nodes (warp, offset), `material` reads the properties. Equations, limits and sources that both share: `shell.md`.

mod kernel;
mod material;
mod plane;
mod shell3;
mod shell4;
mod strains;
#[cfg(test)]
mod tests;

pub use shell3::Shell3;
pub use shell4::Shell4;

use super::{Dof, ElementInput, Sample};

/// A shell resists all motions of its nodes.
const ALL: &[Dof] = &Dof::ALL;

type Input<'a> = ElementInput<'a>;

/// Samples of both elements: isotropic and plane; orthotropic, warped where there are four nodes, off its nodes; of plies that couple
/// stretching with bending.
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
    // [0/90/30] of carbon and epoxy, 1 mm each, on a heavier ply below.
    let plies = vec![
        ("A11", 251e6),
        ("A12", 40e6),
        ("A16", 35e6),
        ("A22", 158e6),
        ("A26", 11e6),
        ("A66", 40e6),
        ("B11", -15e3),
        ("B12", 6e3),
        ("B16", 17e3),
        ("B22", 2e3),
        ("B26", 5e3),
        ("B66", 6e3),
        ("D11", 240.0),
        ("D12", 30.0),
        ("D16", 36.0),
        ("D22", 90.0),
        ("D26", 12.0),
        ("D66", 32.0),
        ("S55", 10e6),
        ("S45", 0.5e6),
        ("S44", 9e6),
        ("areal_mass", 5.5),
        ("areal_moment", -1.2e-3),
        ("areal_inertia", 4.6e-6),
        ("angle", 0.3),
    ];
    let mut preloaded = isotropic.clone();
    preloaded.extend([("N11", 4e3), ("N22", 2e3), ("N12", -1e3), ("angle", 0.3)]);
    vec![
        Sample { points: flat.to_vec(), given: preloaded, mass: 2700.0 * 2e-3 * area, free: false },
        Sample { points: warped.to_vec(), given: plies, mass: 5.5 * warped_area, free: true },
        Sample { points: flat.to_vec(), given: isotropic, mass: 2700.0 * 2e-3 * area, free: true },
        Sample { points: warped.to_vec(), given: orthotropic, mass: (1600.0 * 4e-3 + 1.5) * warped_area, free: true },
    ]
}

/// A shell element, from the functions of its plane.
macro_rules! shell {
    ($vis:vis $type:ident, $name:literal, $nodes:literal, $summary:literal, $text:literal, $plane:expr $(, $own:item)?) => {
        crate::element::meshed::meshed!(
            $vis $type,
            $name,
            [super::ALL; $nodes],
            $summary,
            [$text, "shell.md"],
            $plane,
            samples()
            $(, $own)?
        );
    };
}
use shell;
