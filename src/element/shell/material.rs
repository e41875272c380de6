//! Properties of a shell and what they make of it: rigidities of a section of unit width.

use super::super::meshed::{Given, given};
use super::super::{Dof, Domain, ElementError, ElementInput, Lack, Property, value};
use crate::linalg::DMatrix;

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
    Property::new(
        "A11",
        "N/m",
        Domain::Positive,
        "rigidity of plies: force by strain along the first direction of the laminate",
    ),
    Property::new("A12", "N/m", Domain::Any, "the same, between the first direction and the second"),
    Property::new("A16", "N/m", Domain::Any, "the same, between the first direction and shear"),
    Property::new("A22", "N/m", Domain::Positive, "the same, along the second direction"),
    Property::new("A26", "N/m", Domain::Any, "the same, between the second direction and shear"),
    Property::new("A66", "N/m", Domain::Positive, "the same, in shear"),
    Property::new(
        "B11",
        "N",
        Domain::Any,
        "rigidity of plies: force by curvature, and moment by strain, about the mid-surface; 0 when absent",
    ),
    Property::new("B12", "N", Domain::Any, "the same, between the first direction and the second"),
    Property::new("B16", "N", Domain::Any, "the same, between the first direction and shear or twist"),
    Property::new("B22", "N", Domain::Any, "the same, along the second direction"),
    Property::new("B26", "N", Domain::Any, "the same, between the second direction and shear or twist"),
    Property::new("B66", "N", Domain::Any, "the same, between shear and twist"),
    Property::new("D11", "N m", Domain::Positive, "rigidity of plies: moment by curvature along the first direction"),
    Property::new("D12", "N m", Domain::Any, "the same, between the first direction and the second"),
    Property::new("D16", "N m", Domain::Any, "the same, between the first direction and twist"),
    Property::new("D22", "N m", Domain::Positive, "the same, along the second direction"),
    Property::new("D26", "N m", Domain::Any, "the same, between the second direction and twist"),
    Property::new("D66", "N m", Domain::Positive, "the same, in twist"),
    Property::new("S55", "N/m", Domain::Positive, "rigidity of plies: transverse shear along the first direction"),
    Property::new("S45", "N/m", Domain::Any, "the same, between both directions; 0 when absent"),
    Property::new("S44", "N/m", Domain::Positive, "the same, along the second direction"),
    Property::new("areal_mass", "kg/m2", Domain::NonNegative, "mass of plies by area"),
    Property::new(
        "areal_moment",
        "kg/m",
        Domain::Any,
        "first moment of the mass of plies about the mid-surface, by area, along the normal; 0 when absent",
    ),
    Property::new(
        "areal_inertia",
        "kg",
        Domain::NonNegative,
        "second moment of the mass of plies about the mid-surface, by area; 0 when absent",
    ),
    Property::new(
        "mass_per_area",
        "kg/m2",
        Domain::Any,
        "non-structural mass, in the mid-surface; below zero where there is less mass than the density gives",
    ),
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
    Property::new(
        "N11",
        "N/m",
        Domain::Any,
        "preload: force by width along the material's first direction, tension positive",
    ),
    Property::new("N22", "N/m", Domain::Any, "preload across the first direction, tension positive"),
    Property::new("N12", "N/m", Domain::Any, "preload: shear force by width in these axes"),
];

/// Properties that are preloads.
pub(super) const PRELOADS: &[&str] = &["N11", "N22", "N12"];

/// Rigidities of a section in the axes of the plane, rows xx yy xy with engineering shear strain.
#[derive(Debug, Clone, Copy)]
pub(super) struct Section {
    /// Membrane, N/m.
    pub(super) membrane: [[f64; 3]; 3],
    /// Bending, N m.
    pub(super) bending: [[f64; 3]; 3],
    /// Between them, N, where there is any.
    pub(super) coupling: Option<[[f64; 3]; 3]>,
    /// Transverse shear xz, yz, N/m.
    pub(super) shear: [[f64; 2]; 2],
    /// Against drilling, N/m: the membrane's own shear rigidity, in the mean over all directions.
    pub(super) drilling: f64,
    /// The plate's twisting rigidity, in the mean over all directions, N m.
    pub(super) twisting: f64,
    /// (A12/A11)² of the mean over all directions, Poisson's ratio squared.
    pub(super) poisson2: f64,
}

impl Section {
    /// Forces and moments by the strains of membrane and bending.
    pub(super) fn whole(&self) -> [[f64; 6]; 6] {
        std::array::from_fn(|i| {
            std::array::from_fn(|j| match (i / 3, j / 3) {
                (0, 0) => self.membrane[i][j],
                (1, 1) => self.bending[i - 3][j - 3],
                _ => self.coupling.map_or(0.0, |c| c[i % 3][j % 3]),
            })
        })
    }
}

/// Stiffness of a unit of volume in the material's axes: plane stress, and transverse shear along and across.
struct Material {
    plane: [[f64; 3]; 3],
    along: f64,
    across: f64,
    drilling: f64,
}

/// The shear stiffness in the plane, in the mean over all directions: it does not depend on the axes in which plies are described.
fn mean_shear(m: &[[f64; 3]; 3]) -> f64 {
    (m[0][0] + m[1][1] - 2.0 * m[0][1] + 4.0 * m[2][2]) / 8.0
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
            Ok(Some(Material { plane, along: g, across: g, drilling: g }))
        }
        Given::Orthotropic([e1, e2, nu12, g12, g13, g23]) => {
            let rest = 1.0 - nu12 * nu12 * e2 / e1;
            if rest <= 0.0 {
                let expected = "so small that every stress stores energy: nu12² < E1/E2";
                return Err(ElementError::OutOfDomain { name: "nu12", value: nu12, expected });
            }
            let coupling = nu12 * e2 / rest;
            let plane = [[e1 / rest, coupling, 0.0], [coupling, e2 / rest, 0.0], [0.0, 0.0, g12]];
            Ok(Some(Material { plane, along: g13, across: g23, drilling: mean_shear(&plane) }))
        }
    }
}

/// Rigidities of plies in the axes of the laminate.
struct Plies {
    membrane: [[f64; 3]; 3],
    coupling: [[f64; 3]; 3],
    bending: [[f64; 3]; 3],
    shear: [[f64; 2]; 2],
}

/// Properties of which plies are the other way to say it.
const OF_ONE_MATERIAL: [&str; 12] =
    ["E", "nu", "E1", "E2", "nu12", "G12", "G13", "G23", "thickness", "density", "bending_factor", "shear_factor"];

/// The value of a property by its name.
fn by_name(input: &ElementInput<'_>, name: &str) -> Option<f64> {
    PROPERTIES.iter().position(|p| p.name == name).and_then(|i| input.values.get(i).copied().flatten())
}

/// Whether the section is one of plies, by rigidities and masses by area.
fn is_of_plies(input: &ElementInput<'_>) -> Option<&'static str> {
    let is_of_plies = |p: &Property| p.name.starts_with(['A', 'B', 'D', 'S']) || p.name.starts_with("areal_");
    PROPERTIES.iter().zip(input.values).find(|(p, v)| v.is_some() && is_of_plies(p)).map(|(p, _)| p.name)
}

/// The rigidities of plies; `None` where masses alone are given, or a material.
fn plies(input: &ElementInput<'_>) -> Result<Option<Plies>, ElementError> {
    let Some(first) = is_of_plies(input) else { return Ok(None) };
    if let Some(second) = OF_ONE_MATERIAL.into_iter().find(|name| by_name(input, name).is_some()) {
        return Err(ElementError::Redundant { first, second });
    }
    if first.starts_with("areal_") {
        return Ok(None);
    }
    const NEEDED: &str = "rigidities of plies go together: A11, A12, A22, A66, D11, D12, D22, D66, S44 and S55";
    let needed = |name: &'static str| by_name(input, name).ok_or(ElementError::Missing { name, why: NEEDED });
    let other = |name: &str| by_name(input, name).unwrap_or(0.0);
    let full = |[xx, xy, xs, yy, ys, ss]: [f64; 6]| [[xx, xy, xs], [xy, yy, ys], [xs, ys, ss]];
    let plies = Plies {
        membrane: full([needed("A11")?, needed("A12")?, other("A16"), needed("A22")?, other("A26"), needed("A66")?]),
        coupling: full(["B11", "B12", "B16", "B22", "B26", "B66"].map(other)),
        bending: full([needed("D11")?, needed("D12")?, other("D16"), needed("D22")?, other("D26"), needed("D66")?]),
        shear: [[needed("S55")?, other("S45")], [other("S45"), needed("S44")?]],
    };
    let whole = DMatrix::from_fn(6, 6, |i, j| match (i / 3, j / 3) {
        (0, 0) => plies.membrane[i][j],
        (1, 1) => plies.bending[i - 3][j - 3],
        _ => plies.coupling[i % 3][j % 3],
    });
    // In one unit: N/m.
    let scale = |i: usize| if i < 3 { 1.0 } else { (whole[(0, 0)] / whole[(3, 3)]).sqrt() };
    let scaled = DMatrix::from_fn(6, 6, |i, j| whole[(i, j)] * scale(i) * scale(j));
    let expected = "so that every strain and curvature stores energy: [A B; B D] must be positive definite";
    if scaled.cholesky().is_none() {
        return Err(ElementError::OutOfDomain { name: "A11", value: plies.membrane[0][0], expected });
    }
    let [[xz, mixed], [_, yz]] = plies.shear;
    if xz * yz <= mixed * mixed {
        let expected = "so that every transverse shear stores energy: S45² < S44 S55";
        return Err(ElementError::OutOfDomain { name: "S45", value: mixed, expected });
    }
    Ok(Some(plies))
}

/// Rigidities in the plane's axes; `None` where the input says nothing of stiffness.
///
/// * `material_angle` - from the plane's x axis to the direction that `angle` counts from, rad
pub(super) fn section(input: &ElementInput<'_>, material_angle: f64) -> Result<Option<Section>, ElementError> {
    let angle = material_angle + value!(input, angle).unwrap_or(0.0);
    let (s, c) = angle.sin_cos();
    // Strains in the material's axes from those of the plane.
    let t = [[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2.0 * c * s, 2.0 * c * s, c * c - s * s]];
    let turned = |m: [[f64; 3]; 3]| -> [[f64; 3]; 3] {
        std::array::from_fn(|i| {
            std::array::from_fn(|j| (0..9).map(|k| t[k / 3][i] * m[k / 3][k % 3] * t[k % 3][j]).sum())
        })
    };
    let turned_shear = |[[along, mixed], [_, across]]: [[f64; 2]; 2]| {
        let both = (along - across) * c * s + mixed * (c * c - s * s);
        [
            [along * c * c + across * s * s - 2.0 * mixed * c * s, both],
            [both, along * s * s + across * c * c + 2.0 * mixed * c * s],
        ]
    };
    if let Some(plies) = plies(input)? {
        let is_coupled = plies.coupling.iter().flatten().any(|b| *b != 0.0);
        return Ok(Some(Section {
            membrane: turned(plies.membrane),
            bending: turned(plies.bending),
            coupling: is_coupled.then(|| turned(plies.coupling)),
            shear: turned_shear(plies.shear),
            drilling: mean_shear(&plies.membrane),
            twisting: mean_shear(&plies.bending),
            poisson2: poisson2(&plies.membrane),
        }));
    }
    if is_of_plies(input).is_some() {
        return Ok(None);
    }
    let thickness = thickness(input)?;
    let Some(m) = material(input)? else { return Ok(None) };
    let plane = turned(m.plane);
    let bending = value!(input, bending_factor).unwrap_or(1.0) * thickness.powi(3) / 12.0;
    let transverse = value!(input, shear_factor).unwrap_or(5.0 / 6.0) * thickness;
    Ok(Some(Section {
        membrane: plane.map(|row| row.map(|v| v * thickness)),
        bending: plane.map(|row| row.map(|v| v * bending)),
        coupling: None,
        shear: turned_shear([[m.along, 0.0], [0.0, m.across]]).map(|row| row.map(|v| v * transverse)),
        drilling: m.drilling * thickness,
        twisting: m.drilling * bending,
        poisson2: poisson2(&m.plane),
    }))
}

/// The square of Poisson's ratio, of directed material that of its mean over all directions.
fn poisson2(m: &[[f64; 3]; 3]) -> f64 {
    let normal = 3.0 * (m[0][0] + m[1][1]) + 2.0 * m[0][1] + 4.0 * m[2][2];
    let across = m[0][0] + m[1][1] + 6.0 * m[0][1] - 4.0 * m[2][2];
    (across / normal).powi(2)
}

/// The forces by width of the preload in the plane's axes, N/m; `None` where there is none.
///
/// * `material_angle` - as of [`section`]
pub(super) fn preload(input: &ElementInput<'_>, material_angle: f64) -> Option<[[f64; 2]; 2]> {
    let given = [value!(input, N11), value!(input, N22), value!(input, N12)];
    if given.iter().all(Option::is_none) {
        return None;
    }
    let [along, across, shear] = given.map(|n| n.unwrap_or(0.0));
    let (s, c) = (material_angle + value!(input, angle).unwrap_or(0.0)).sin_cos();
    let xx = along * c * c + across * s * s - 2.0 * shear * c * s;
    let yy = along * s * s + across * c * c + 2.0 * shear * c * s;
    let xy = (along - across) * c * s + shear * (c * c - s * s);
    Some([[xx, xy], [xy, yy]])
}

/// Forces by width xx, yy, xy of the plane's axes in those of the material: the inverse of what [`preload`] does.
///
/// * `material_angle` - as of [`section`]
pub(super) fn to_material([xx, yy, xy]: [f64; 3], input: &ElementInput<'_>, material_angle: f64) -> [f64; 3] {
    let (s, c) = (material_angle + value!(input, angle).unwrap_or(0.0)).sin_cos();
    [
        xx * c * c + yy * s * s + 2.0 * xy * c * s,
        xx * s * s + yy * c * c - 2.0 * xy * c * s,
        (yy - xx) * c * s + xy * (c * c - s * s),
    ]
}

/// The thickness; of plies that of the solid plate of their membrane and bending rigidities: t² = 12 (D11 + D22)/(A11 + A22).
pub(super) fn thickness(input: &ElementInput<'_>) -> Result<f64, ElementError> {
    let both = |a, b| Some(by_name(input, a)? + by_name(input, b)?);
    if let (Some(d), Some(a)) = (both("D11", "D22"), both("A11", "A22")) {
        return Ok((12.0 * d / a).sqrt());
    }
    value!(input, thickness).ok_or(ElementError::Missing {
        name: "thickness",
        why: "a shell needs its thickness, or the rigidities of plies",
    })
}

/// Mass by area: itself, kg/m², its first moment along the normal, kg/m, and its second, kg; about the mid-surface.
pub(super) fn mass_of(input: &ElementInput<'_>) -> Result<[f64; 3], ElementError> {
    let beside = value!(input, mass_per_area).unwrap_or(0.0);
    let with = |own: f64| {
        let expected = "no more below zero than the shell has mass";
        let less = ElementError::OutOfDomain { name: "mass_per_area", value: beside, expected };
        if own + beside < 0.0 { Err(less) } else { Ok(own + beside) }
    };
    if is_of_plies(input).is_some() {
        let [own, moment, inertia] =
            ["areal_mass", "areal_moment", "areal_inertia"].map(|name| by_name(input, name).unwrap_or(0.0));
        if moment * moment > own * inertia * (1.0 + 1e-9) {
            let expected = "within what the mass can have: areal_moment² at most areal_mass areal_inertia";
            return Err(ElementError::OutOfDomain { name: "areal_moment", value: moment, expected });
        }
        return Ok([with(own)?, moment, inertia]);
    }
    let thickness = thickness(input)?;
    let density = value!(input, density).unwrap_or(0.0);
    Ok([with(density * thickness)?, 0.0, density * thickness.powi(3) / 12.0])
}

/// Share of the mass that is lumped at the nodes.
pub(super) fn lumping(input: &ElementInput<'_>) -> f64 {
    value!(input, lumping).unwrap_or(0.0)
}

/// Distance from the nodes to the mid-surface along the normal, m.
pub(super) fn offset(input: &ElementInput<'_>) -> f64 {
    value!(input, offset).unwrap_or(0.0)
}

/// Refuses a material that could not be, for what needs no stiffness.
pub(super) fn check(input: &ElementInput<'_>) -> Result<(), ElementError> {
    if plies(input)?.is_some() || is_of_plies(input).is_some() { Ok(()) } else { material(input).map(|_| ()) }
}

/// A shell of which no stiffness is given is mass alone and resists nothing.
pub(super) fn lacks(input: &ElementInput<'_>) -> Vec<Lack> {
    let is_stiff = || !matches!(plies(input), Ok(None)) || !matches!(material(input), Ok(None));
    if input.values.len() != PROPERTIES.len() || is_stiff() {
        return Vec::new();
    }
    Dof::ALL.map(|dof| Lack { dof, property: "E" }).to_vec()
}
