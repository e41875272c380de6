//! Properties of a shell and what they make of it: rigidities of a section of unit width.

use super::super::meshed::{Given, given};
use super::super::{Dof, Domain, ElementError, ElementInput, Lack, Property, value};

/// Properties of every shell.
pub(super) const PROPERTIES: &[Property] = &[
    Property::new("E", "Pa", Domain::Positive, "Young's modulus of an isotropic material"),
    Property::new("nu", "1", Domain::Any, "Poisson's ratio of an isotropic material, above -1 and below 0.5"),
    Property::new("E1", "Pa", Domain::Positive, "Young's modulus along the material's first direction, orthotropic"),
    Property::new("E2", "Pa", Domain::Positive, "Young's modulus across it in the plane, orthotropic"),
    Property::new("nu12", "1", Domain::Any, "strain across by stress along, orthotropic: nu21 = nu12 E2/E1"),
    Property::new("G12", "Pa", Domain::Positive, "shear modulus in the plane, orthotropic"),
    Property::new("G13", "Pa", Domain::Positive, "transverse shear modulus along, orthotropic"),
    Property::new("G23", "Pa", Domain::Positive, "transverse shear modulus across, orthotropic"),
    Property::new(
        "angle",
        "rad",
        Domain::Any,
        "from the x axis of the element's axes, projected onto the shell, to the material's first direction, about the normal",
    ),
    Property::new("thickness", "m", Domain::Positive, "thickness"),
    Property::new("density", "kg/m3", Domain::NonNegative, "density; no mass of its own when absent"),
    Property::new("mass_per_area", "kg/m2", Domain::NonNegative, "non-structural mass, in the mid-surface"),
    Property::new("offset", "m", Domain::Any, "from the nodes to the mid-surface, along the normal"),
    Property::new(
        "bending_factor",
        "1",
        Domain::Positive,
        "bending stiffness over that of a solid plate, 12 I/t³; 1 when absent",
    ),
    Property::new(
        "shear_factor",
        "1",
        Domain::Positive,
        "transverse shear stiffness over G t; 5/6 when absent, the value of a solid plate",
    ),
    Property::new(
        "lumping",
        "1",
        Domain::Fraction,
        "0 for the consistent mass (when absent), 1 for one lumped at the nodes, a mean of both between",
    ),
];

/// Rigidities of a section in the axes of the plane, rows xx yy xy with engineering shear strain.
#[derive(Debug, Clone, Copy)]
pub(super) struct Section {
    /// Membrane, N/m.
    pub(super) membrane: [[f64; 3]; 3],
    /// Bending, N m.
    pub(super) bending: [[f64; 3]; 3],
    /// Transverse shear xz, yz, N/m.
    pub(super) shear: [[f64; 2]; 2],
    /// Against drilling, N/m: the membrane's own shear rigidity.
    pub(super) drilling: f64,
}

/// Stiffness of a unit of volume in the material's axes: plane stress, and transverse shear along and across.
struct Material {
    plane: [[f64; 3]; 3],
    along: f64,
    across: f64,
}

const ORTHOTROPIC: &str = "an orthotropic shell needs E1, E2, nu12, G12, G13 and G23";
const ISOTROPIC: &str = "an isotropic shell needs `E` and `nu`";

fn material(input: &ElementInput<'_>) -> Result<Option<Material>, ElementError> {
    let orthotropic = [
        ("E1", value!(input, E1)),
        ("E2", value!(input, E2)),
        ("nu12", value!(input, nu12)),
        ("G12", value!(input, G12)),
        ("G13", value!(input, G13)),
        ("G23", value!(input, G23)),
    ];
    match given([value!(input, E), value!(input, nu)], orthotropic, [ISOTROPIC, ORTHOTROPIC])? {
        Given::Nothing => Ok(None),
        Given::Isotropic([e, nu]) => {
            let (a, g) = (e / (1.0 - nu * nu), e / (2.0 * (1.0 + nu)));
            let plane = [[a, nu * a, 0.0], [nu * a, a, 0.0], [0.0, 0.0, g]];
            Ok(Some(Material { plane, along: g, across: g }))
        }
        Given::Orthotropic([e1, e2, nu12, g12, g13, g23]) => {
            let rest = 1.0 - nu12 * nu12 * e2 / e1;
            if rest <= 0.0 {
                let expected = "so small that every stress stores energy: nu12² < E1/E2";
                return Err(ElementError::OutOfDomain { name: "nu12", value: nu12, expected });
            }
            let coupling = nu12 * e2 / rest;
            let plane = [[e1 / rest, coupling, 0.0], [coupling, e2 / rest, 0.0], [0.0, 0.0, g12]];
            Ok(Some(Material { plane, along: g13, across: g23 }))
        }
    }
}

/// Rigidities in the plane's axes; `None` where the input says nothing of stiffness.
///
/// * `material_angle` - from the plane's x axis to the direction that `angle` counts from, rad
pub(super) fn section(input: &ElementInput<'_>, material_angle: f64) -> Result<Option<Section>, ElementError> {
    let thickness = thickness(input)?;
    let Some(m) = material(input)? else { return Ok(None) };
    let angle = material_angle + value!(input, angle).unwrap_or(0.0);
    let (s, c) = angle.sin_cos();
    // Strains in the material's axes from those of the plane.
    let t = [[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2.0 * c * s, 2.0 * c * s, c * c - s * s]];
    let turned: [[f64; 3]; 3] = std::array::from_fn(|i| {
        std::array::from_fn(|j| (0..9).map(|k| t[k / 3][i] * m.plane[k / 3][k % 3] * t[k % 3][j]).sum())
    });
    let shear = [
        [m.along * c * c + m.across * s * s, (m.along - m.across) * c * s],
        [(m.along - m.across) * c * s, m.along * s * s + m.across * c * c],
    ];
    let bending = value!(input, bending_factor).unwrap_or(1.0) * thickness.powi(3) / 12.0;
    let transverse = value!(input, shear_factor).unwrap_or(5.0 / 6.0) * thickness;
    Ok(Some(Section {
        membrane: turned.map(|row| row.map(|v| v * thickness)),
        bending: turned.map(|row| row.map(|v| v * bending)),
        shear: shear.map(|row| row.map(|v| v * transverse)),
        drilling: m.plane[2][2] * thickness,
    }))
}

pub(super) fn thickness(input: &ElementInput<'_>) -> Result<f64, ElementError> {
    value!(input, thickness).ok_or(ElementError::Missing { name: "thickness", why: "a shell needs its thickness" })
}

/// Mass per area, kg/m²; rotary inertia per area, kg; share of lumping.
pub(super) fn mass_of(input: &ElementInput<'_>) -> Result<[f64; 3], ElementError> {
    let thickness = thickness(input)?;
    let density = value!(input, density).unwrap_or(0.0);
    let beside = value!(input, mass_per_area).unwrap_or(0.0);
    Ok([density * thickness + beside, density * thickness.powi(3) / 12.0, value!(input, lumping).unwrap_or(0.0)])
}

/// Distance from the nodes to the mid-surface along the normal, m.
pub(super) fn offset(input: &ElementInput<'_>) -> f64 {
    value!(input, offset).unwrap_or(0.0)
}

/// Refuses a material that could not be, for what needs no stiffness.
pub(super) fn check(input: &ElementInput<'_>) -> Result<(), ElementError> {
    material(input).map(|_| ())
}

/// A shell of which no stiffness is given is mass alone and resists nothing.
pub(super) fn lacks(input: &ElementInput<'_>) -> Vec<Lack> {
    if input.values.len() != PROPERTIES.len() || !matches!(material(input), Ok(None)) {
        return Vec::new();
    }
    Dof::ALL.map(|dof| Lack { dof, property: "E" }).to_vec()
}
