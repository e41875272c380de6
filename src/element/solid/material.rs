//! The material of a solid: isotropic, or orthotropic along the element's axes.

use super::super::meshed::{Given, given};
use super::super::{Dof, Domain, ElementError, ElementInput, Lack, Property, value};

/// Properties of every solid.
pub(super) const PROPERTIES: &[Property] = &[
    Property::new("E", "Pa", Domain::Positive, "Young's modulus of an isotropic material"),
    Property::new("nu", "1", Domain::Any, "Poisson's ratio of an isotropic material, above -1 and below 0.5"),
    Property::new("E1", "Pa", Domain::Positive, "Young's modulus along x of the element's axes, orthotropic"),
    Property::new("E2", "Pa", Domain::Positive, "Young's modulus along y, orthotropic"),
    Property::new("E3", "Pa", Domain::Positive, "Young's modulus along z, orthotropic"),
    Property::new("nu12", "1", Domain::Any, "strain along y by stress along x, orthotropic: nu21 = nu12 E2/E1"),
    Property::new("nu13", "1", Domain::Any, "strain along z by stress along x, orthotropic"),
    Property::new("nu23", "1", Domain::Any, "strain along z by stress along y, orthotropic"),
    Property::new("G12", "Pa", Domain::Positive, "shear modulus in the x-y plane, orthotropic"),
    Property::new("G13", "Pa", Domain::Positive, "shear modulus in the x-z plane, orthotropic"),
    Property::new("G23", "Pa", Domain::Positive, "shear modulus in the y-z plane, orthotropic"),
    Property::new("density", "kg/m3", Domain::NonNegative, "density; no mass when absent"),
    Property::new(
        "lumping",
        "1",
        Domain::Fraction,
        "0 for the consistent mass (when absent), 1 for one lumped at the nodes, a mean of both between",
    ),
    Property::new("S11", "Pa", Domain::Any, "preload: stress along x of the element's axes, tension positive"),
    Property::new("S22", "Pa", Domain::Any, "preload: stress along y"),
    Property::new("S33", "Pa", Domain::Any, "preload: stress along z"),
    Property::new("S12", "Pa", Domain::Any, "preload: shear stress in the x-y plane"),
    Property::new("S23", "Pa", Domain::Any, "preload: shear stress in the y-z plane"),
    Property::new("S13", "Pa", Domain::Any, "preload: shear stress in the x-z plane"),
];

/// Properties that are preloads.
pub(super) const PRELOADS: &[&str] = &["S11", "S22", "S33", "S12", "S23", "S13"];

/// The stress of the preload in the element's axes, Pa; `None` where there is none.
pub(super) fn preload(input: &ElementInput<'_>) -> Option<[[f64; 3]; 3]> {
    let given = [
        value!(input, S11),
        value!(input, S22),
        value!(input, S33),
        value!(input, S12),
        value!(input, S23),
        value!(input, S13),
    ];
    if given.iter().all(Option::is_none) {
        return None;
    }
    let [xx, yy, zz, xy, yz, xz] = given.map(|s| s.unwrap_or(0.0));
    Some([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
}

/// Elasticity, rows and columns xx yy zz xy yz zx with engineering shear strains, Pa.
pub(super) type Elasticity = [[f64; 6]; 6];

const ISOTROPIC: &str = "an isotropic solid needs `E` and `nu`";
const ORTHOTROPIC: &str = "an orthotropic solid needs E1, E2, E3, nu12, nu13, nu23, G12, G13 and G23";

/// The elasticity of an input; `None` where it says nothing of stiffness: then the element is mass alone.
pub(super) fn elasticity(input: &ElementInput<'_>) -> Result<Option<Elasticity>, ElementError> {
    let orthotropic = [
        ("E1", value!(input, E1)),
        ("E2", value!(input, E2)),
        ("E3", value!(input, E3)),
        ("nu12", value!(input, nu12)),
        ("nu13", value!(input, nu13)),
        ("nu23", value!(input, nu23)),
        ("G12", value!(input, G12)),
        ("G13", value!(input, G13)),
        ("G23", value!(input, G23)),
    ];
    match given([value!(input, E), value!(input, nu)], orthotropic, [ISOTROPIC, ORTHOTROPIC])? {
        Given::Nothing => Ok(None),
        Given::Isotropic([e, nu]) => Ok(Some(isotropic_of(e, nu))),
        Given::Orthotropic(all) => orthotropic_of(all).map(Some),
    }
}

fn isotropic_of(e: f64, nu: f64) -> Elasticity {
    let shear = e / (2.0 * (1.0 + nu));
    let lambda = e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
    let mut d = [[0.0; 6]; 6];
    for i in 0..3 {
        for j in 0..3 {
            d[i][j] = lambda;
        }
        d[i][i] = lambda + 2.0 * shear;
        d[3 + i][3 + i] = shear;
    }
    d
}

/// The inverse of the compliance [1/E_i, -ν_ij/E_i], refused where it stores no energy.
fn orthotropic_of([e1, e2, e3, nu12, nu13, nu23, g12, g13, g23]: [f64; 9]) -> Result<Elasticity, ElementError> {
    let (nu21, nu31, nu32) = (nu12 * e2 / e1, nu13 * e3 / e1, nu23 * e3 / e2);
    let definite = 1.0 - nu12 * nu21 - nu23 * nu32 - nu13 * nu31 - 2.0 * nu21 * nu32 * nu13;
    for (name, value, product) in
        [("nu12", nu12, nu12 * nu21), ("nu13", nu13, nu13 * nu31), ("nu23", nu23, nu23 * nu32)]
    {
        if !(product < 1.0 && definite > 0.0) {
            let expected = "so small that every stress stores energy: nu_ij² < E_i/E_j, and 1 - nu12 nu21 - nu23 nu32 - \
                            nu13 nu31 - 2 nu21 nu32 nu13 > 0";
            return Err(ElementError::OutOfDomain { name, value, expected });
        }
    }
    let mut d = [[0.0; 6]; 6];
    d[0][0] = e1 * (1.0 - nu23 * nu32) / definite;
    d[1][1] = e2 * (1.0 - nu13 * nu31) / definite;
    d[2][2] = e3 * (1.0 - nu12 * nu21) / definite;
    d[0][1] = e1 * (nu21 + nu31 * nu23) / definite;
    d[0][2] = e1 * (nu31 + nu21 * nu32) / definite;
    d[1][2] = e2 * (nu32 + nu12 * nu31) / definite;
    for (i, j) in [(0, 1), (0, 2), (1, 2)] {
        d[j][i] = d[i][j];
    }
    (d[3][3], d[4][4], d[5][5]) = (g12, g23, g13);
    Ok(d)
}

/// Density, kg/m³, and the share of lumping.
pub(super) fn mass_of(input: &ElementInput<'_>) -> (f64, f64) {
    (value!(input, density).unwrap_or(0.0), value!(input, lumping).unwrap_or(0.0))
}

/// A solid of which no stiffness is given is mass alone and resists nothing.
pub(super) fn lacks(input: &ElementInput<'_>) -> Vec<Lack> {
    if input.values.len() != PROPERTIES.len() || !matches!(elasticity(input), Ok(None)) {
        return Vec::new();
    }
    [Dof::Ux, Dof::Uy, Dof::Uz].map(|dof| Lack { dof, property: "E" }).to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An isotropic material given as an orthotropic one is the same; the compliance is that of the definition.
    #[test]
    fn orthotropic_contains_isotropic() {
        let (e, nu) = (70e9, 0.3);
        let g = e / (2.0 * (1.0 + nu));
        let (a, b) = (isotropic_of(e, nu), orthotropic_of([e, e, e, nu, nu, nu, g, g, g]).unwrap());
        for i in 0..6 {
            for j in 0..6 {
                assert!((a[i][j] - b[i][j]).abs() < 1e-12 * e, "{i}{j}");
            }
        }
        let d = orthotropic_of([130e9, 9e9, 8e9, 0.3, 0.28, 0.4, 5e9, 4.5e9, 3e9]).unwrap();
        // Uniaxial stress along x: strains 1/E1, -nu12/E1, -nu13/E1.
        let strain = [1.0 / 130e9, -0.3 / 130e9, -0.28 / 130e9];
        let stress: Vec<f64> = (0..3).map(|i| (0..3).map(|j| d[i][j] * strain[j]).sum()).collect();
        assert!((stress[0] - 1.0).abs() < 1e-12 && stress[1].abs() < 1e-12 && stress[2].abs() < 1e-12);
    }

    #[test]
    fn impossible_materials_are_refused() {
        let isotropic = |nu| given([Some(1.0), Some(nu)], [("E1", None)], [ISOTROPIC, ORTHOTROPIC]);
        assert!(isotropic(0.5).is_err() && isotropic(-1.0).is_err() && isotropic(0.4999).is_ok());
        assert!(orthotropic_of([1.0, 10.0, 1.0, 0.5, 0.0, 0.0, 1.0, 1.0, 1.0]).is_err());
    }
}
