//! The properties of a beam, and what they amount to.

use super::super::bar::{completing, mass_per_length, rigidity};
use super::super::{Dof, Domain, ElementError, ElementInput, Lack, Property, Sample, property_index, value};
use super::Beam;

/// One bending plane: its displacement dof, its rotation dof, and the sign of the rotation in the slope.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plane {
    pub displacement: usize,
    pub rotation: usize,
    pub slope: f64,
}

const fn positive(name: &'static str, unit: &'static str, description: &'static str) -> Property {
    Property::new(name, unit, Domain::Positive, description)
}

const fn non_negative(name: &'static str, unit: &'static str, description: &'static str) -> Property {
    Property::new(name, unit, Domain::NonNegative, description)
}

const fn compliance(name: &'static str, unit: &'static str, description: &'static str) -> Property {
    Property::new(name, unit, Domain::Compliance, description)
}

const fn any(name: &'static str, unit: &'static str, description: &'static str) -> Property {
    Property::new(name, unit, Domain::Any, description)
}

pub(super) const PROPERTIES: &[Property] = &[
    positive("E", "Pa", "Young's modulus"),
    positive("G", "Pa", "shear modulus"),
    any("nu", "1", "Poisson's ratio, instead of `G`: G = E/(2 (1 + nu))"),
    positive("A", "m2", "cross-section area"),
    positive("Iy", "m4", "second moment of area about y: bending in the x-z plane, displacement uz"),
    positive("Iz", "m4", "second moment of area about z: bending in the x-y plane, displacement uy"),
    positive("J", "m4", "torsion constant"),
    non_negative("EA", "N", "axial rigidity, instead of `E` and `A`"),
    non_negative("EIy", "N m2", "bending rigidity about y, instead of `E` and `Iy`"),
    non_negative("EIz", "N m2", "bending rigidity about z, instead of `E` and `Iz`"),
    non_negative("GJ", "N m2", "torsional rigidity, instead of `G` and `J`"),
    positive("kappa_y", "1", "shear correction factor along y: shear rigidity kappa G A; absent: no shear deformation"),
    positive("kappa_z", "1", "shear correction factor along z: shear rigidity kappa G A; absent: no shear deformation"),
    non_negative("shear_compliance_y", "1/N", "1/(kappa G A) along y, instead of `kappa_y` (default 0: none)"),
    non_negative("shear_compliance_z", "1/N", "1/(kappa G A) along z, instead of `kappa_z` (default 0: none)"),
    non_negative("mass_per_length", "kg/m", "mass per length"),
    non_negative("density", "kg/m3", "density, instead of `mass_per_length`; needs `A`"),
    non_negative(
        "polar_inertia_per_length",
        "kg m",
        "twist inertia per length about the mass axis (default: density (Iy + Iz), or 0 without density)",
    ),
    non_negative("rotary_inertia_y", "kg m", "rotary inertia of the section about y, per length (default 0)"),
    non_negative("rotary_inertia_z", "kg m", "rotary inertia of the section about z, per length (default 0)"),
    any(
        "added_mass_per_length",
        "kg/m",
        "mass per length beside that of the section, on the mass axis, below zero where there is less (default 0)",
    ),
    non_negative(
        "air_mass_y",
        "kg/m",
        "mass per length of the air or water moved along y: inertia without weight (default 0)",
    ),
    non_negative(
        "air_mass_z",
        "kg/m",
        "mass per length of the air or water moved along z: inertia without weight (default 0)",
    ),
    any("mass_offset_y", "m", "y of the mass axis from the node line (default 0)"),
    any("mass_offset_z", "m", "z of the mass axis from the node line (default 0)"),
    any("shear_centre_y", "m", "y of the elastic axis from the node line (default 0)"),
    any("shear_centre_z", "m", "z of the elastic axis from the node line (default 0)"),
    any("neutral_axis_y", "m", "y of the axis that tension stretches, from the node line (default: the elastic axis)"),
    any("neutral_axis_z", "m", "z of the axis that tension stretches, from the node line (default: the elastic axis)"),
    any("bend_twist_y", "N m2", "coupling rigidity between curvature about y and twist rate (default 0)"),
    any("bend_twist_z", "N m2", "coupling rigidity between curvature about z and twist rate (default 0)"),
    Property::new(
        "lumping",
        "1",
        Domain::Fraction,
        "0 for the consistent mass (when absent), 1 for one lumped at both ends, a mean of both between",
    ),
    Property::new("lumping_along", "1", Domain::Fraction, "the same of motion along x alone (default: `lumping`)"),
    any("axial_force", "N", "preload, tension positive: geometric stiffness (default 0)"),
    non_negative("end1_rigid_length", "m", "length at node 1 that does not deform: the depth of a joint (default 0)"),
    non_negative("end2_rigid_length", "m", "length at node 2 that does not deform: the depth of a joint (default 0)"),
    compliance("end1_compliance_ux", "m/N", "flexibility of the joint at node 1 along x (default 0: rigid)"),
    compliance("end1_compliance_uy", "m/N", "flexibility of the joint at node 1 along y (default 0: rigid)"),
    compliance("end1_compliance_uz", "m/N", "flexibility of the joint at node 1 along z (default 0: rigid)"),
    compliance("end1_compliance_rx", "rad/(N m)", "flexibility of the joint at node 1 about x (default 0: rigid)"),
    compliance("end1_compliance_ry", "rad/(N m)", "flexibility of the joint at node 1 about y (default 0: rigid)"),
    compliance("end1_compliance_rz", "rad/(N m)", "flexibility of the joint at node 1 about z (default 0: rigid)"),
    compliance("end2_compliance_ux", "m/N", "flexibility of the joint at node 2 along x (default 0: rigid)"),
    compliance("end2_compliance_uy", "m/N", "flexibility of the joint at node 2 along y (default 0: rigid)"),
    compliance("end2_compliance_uz", "m/N", "flexibility of the joint at node 2 along z (default 0: rigid)"),
    compliance("end2_compliance_rx", "rad/(N m)", "flexibility of the joint at node 2 about x (default 0: rigid)"),
    compliance("end2_compliance_ry", "rad/(N m)", "flexibility of the joint at node 2 about y (default 0: rigid)"),
    compliance("end2_compliance_rz", "rad/(N m)", "flexibility of the joint at node 2 about z (default 0: rigid)"),
    compliance(
        "end1_hinge_compliance",
        "rad/(N m)",
        "flexibility of the joint at node 1 about one axis of any direction, which `end1_hinge_x`, `_y` and `_z` give (default 0: rigid)",
    ),
    any("end1_hinge_x", "1", "x of that axis, of any length (default 0)"),
    any("end1_hinge_y", "1", "y of it (default 0)"),
    any("end1_hinge_z", "1", "z of it (default 0)"),
    compliance(
        "end2_hinge_compliance",
        "rad/(N m)",
        "the same at node 2, about `end2_hinge_x`, `_y` and `_z` (default 0: rigid)",
    ),
    any("end2_hinge_x", "1", "x of that axis, of any length (default 0)"),
    any("end2_hinge_y", "1", "y of it (default 0)"),
    any("end2_hinge_z", "1", "z of it (default 0)"),
];

/// The first of the twelve end compliances, which stand in the order of the dofs.
const END_COMPLIANCE: usize = property_index(PROPERTIES, "end1_compliance_ux");

/// The first of the four properties of a hinge at either end.
const HINGE: [usize; 2] =
    [property_index(PROPERTIES, "end1_hinge_compliance"), property_index(PROPERTIES, "end2_hinge_compliance")];

/// Everything a beam's matrices are made of. Pairs per bending plane are in the order of `PLANES`: uy first, then uz.
#[derive(Debug, Clone)]
pub(super) struct Section {
    /// Of what deforms, m.
    pub length: f64,
    /// Lengths at both ends that do not, m.
    pub rigid: [f64; 2],
    /// Axial and torsional rigidity, N and N m²; zero where not given.
    pub ea: f64,
    pub gj: f64,
    /// Bending rigidity EIz, EIy, N m²; zero where not given.
    pub ei: [f64; 2],
    /// Shear compliance along y, along z, 1/N.
    pub shear_compliance: [f64; 2],
    /// Coupling rigidity of curvature about z, about y with the twist rate, N m².
    pub bend_twist: [f64; 2],
    /// Tension, N.
    pub axial_force: f64,
    /// Inertia per length against ux uy uz rx ry rz of the mass axis, kg/m and kg m.
    pub inertia: [f64; 6],
    /// Inertia per length of the surrounding fluid against uy and uz of the mass axis, kg/m.
    pub air: [f64; 2],
    /// (y, z) of the elastic axis and of the mass axis from the node line, m.
    pub shear_centre: [f64; 2],
    pub mass_offset: [f64; 2],
    /// (y, z) of the axis that tension stretches, from the elastic axis, m.
    pub neutral_axis: [f64; 2],
    /// Share of the mass that is lumped at the ends, against ux uy uz rx ry rz.
    pub lumping: [f64; 6],
    /// Of the twelve dofs, m/N and rad/(N m).
    pub end_compliance: [f64; 12],
    /// Compliance of a joint about one axis at either end, rad/(N m), and the unit vector of the axis.
    pub hinges: [Option<(f64, [f64; 3])>; 2],
}

/// The joint about an axis of any direction at an end.
fn hinge(input: &ElementInput<'_>, end: usize) -> Result<Option<(f64, [f64; 3])>, ElementError> {
    let first = HINGE[end];
    let Some(compliance) = input.values[first].filter(|c| *c != 0.0) else { return Ok(None) };
    let axis = [1, 2, 3].map(|k| input.values[first + k].unwrap_or(0.0));
    let length = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
    let refused =
        |expected| Err(ElementError::OutOfDomain { name: PROPERTIES[first].name, value: compliance, expected });
    if !(length > 0.0 && length.is_finite()) {
        return refused("an axis beside it: `hinge_x`, `hinge_y` and `hinge_z` of this end");
    }
    if (3..6).any(|d| input.values[END_COMPLIANCE + 6 * end + d].is_some_and(|c| c != 0.0)) {
        return refused("no flexibility about x, y or z beside it at this end");
    }
    Ok(Some((compliance, axis.map(|x| x / length))))
}

/// The four rigidities as given, `None` where not: EA, GJ, EIz, EIy.
fn rigidities(input: &ElementInput<'_>) -> Result<[Option<f64>; 4], ElementError> {
    let (e, g) = (value!(input, E), shear_modulus(input)?);
    Ok([
        rigidity(e, ("A", value!(input, A)), ("EA", value!(input, EA)))?,
        rigidity(g, ("J", value!(input, J)), ("GJ", value!(input, GJ)))?,
        rigidity(e, ("Iz", value!(input, Iz)), ("EIz", value!(input, EIz)))?,
        rigidity(e, ("Iy", value!(input, Iy)), ("EIy", value!(input, EIy)))?,
    ])
}

/// G, or that of an isotropic material.
fn shear_modulus(input: &ElementInput<'_>) -> Result<Option<f64>, ElementError> {
    let (g, Some(nu)) = (value!(input, G), value!(input, nu)) else { return Ok(value!(input, G)) };
    if g.is_some() {
        return Err(ElementError::Redundant { first: "G", second: "nu" });
    }
    if !(nu > -1.0 && nu <= 0.5) {
        return Err(ElementError::OutOfDomain { name: "nu", value: nu, expected: "above -1 and at most 0.5" });
    }
    let why = "the shear modulus is E/(2 (1 + nu)); or give `G`";
    let e = value!(input, E).ok_or(ElementError::Missing { name: "E", why })?;
    Ok(Some(e / (2.0 * (1.0 + nu))))
}

/// 1/(kappa G A), 1/N, from the correction factor or directly; zero when neither is given.
fn shear_compliance(
    input: &ElementInput<'_>,
    (factor_name, factor): (&'static str, Option<f64>),
    (name, direct): (&'static str, Option<f64>),
) -> Result<f64, ElementError> {
    let why = "the shear rigidity is kappa G A; or give `shear_compliance_y`, `shear_compliance_z`";
    match (factor, direct) {
        (Some(_), Some(_)) => Err(ElementError::Redundant { first: factor_name, second: name }),
        (None, direct) => Ok(direct.unwrap_or(0.0)),
        (Some(factor), None) => match (shear_modulus(input)?, value!(input, A)) {
            (Some(g), Some(area)) => Ok(1.0 / (factor * g * area)),
            (None, _) => Err(ElementError::Missing { name: "G", why }),
            (_, None) => Err(ElementError::Missing { name: "A", why }),
        },
    }
}

/// Refuses a coupling without the rigidities it couples, and one that makes the section indefinite:
/// Ky²/(EIy GJ) + Kz²/(EIz GJ) must be below one.
fn check_coupling(coupling: [f64; 2], ei: [Option<f64>; 2], gj: Option<f64>) -> Result<(), ElementError> {
    let mut sum = 0.0;
    let why = "the bend-twist coupling needs bending and torsional rigidity";
    for (p, (name, rigidity)) in [("bend_twist_z", "EIz"), ("bend_twist_y", "EIy")].into_iter().enumerate() {
        if coupling[p] == 0.0 {
            continue;
        }
        let gj = gj.ok_or(ElementError::Missing { name: "GJ", why })?;
        let ei = ei[p].ok_or(ElementError::Missing { name: rigidity, why })?;
        sum += (coupling[p] / ei) * (coupling[p] / gj);
        if sum.is_nan() || sum >= 1.0 {
            return Err(ElementError::OutOfDomain {
                name,
                value: coupling[p],
                expected: "so small that bend_twist_y²/(EIy GJ) + bend_twist_z²/(EIz GJ) is below 1",
            });
        }
    }
    Ok(())
}

impl Section {
    /// From property values; refuses contradictions and what cannot be computed.
    pub(super) fn read(input: &ElementInput<'_>) -> Result<Self, ElementError> {
        input.check(&Beam)?;
        let whole = input.positive_length()?;
        let rigid = [value!(input, end1_rigid_length), value!(input, end2_rigid_length)].map(|v| v.unwrap_or(0.0));
        let length = whole - rigid[0] - rigid[1];
        if length <= 1e-6 * whole {
            let longer = usize::from(rigid[1] > rigid[0]);
            let name = ["end1_rigid_length", "end2_rigid_length"][longer];
            let expected = "so short that some of the element between its rigid ends is left to deform";
            return Err(ElementError::OutOfDomain { name, value: rigid[longer], expected });
        }
        let [ea, gj, eiz, eiy] = rigidities(input)?;
        let bend_twist = [value!(input, bend_twist_z), value!(input, bend_twist_y)].map(|v| v.unwrap_or(0.0));
        check_coupling(bend_twist, [eiz, eiy], gj)?;

        let density = value!(input, density);
        let added = value!(input, added_mass_per_length).unwrap_or(0.0);
        let mass = mass_per_length(value!(input, mass_per_length), density, value!(input, A))? + added;
        if mass < 0.0 {
            let expected = "no more below zero than the section has mass";
            return Err(ElementError::OutOfDomain { name: "added_mass_per_length", value: added, expected });
        }
        let air = [value!(input, air_mass_y), value!(input, air_mass_z)].map(|v| v.unwrap_or(0.0));
        let section_inertia = value!(input, Iy).unwrap_or(0.0) + value!(input, Iz).unwrap_or(0.0);
        let polar = value!(input, polar_inertia_per_length).unwrap_or(density.unwrap_or(0.0) * section_inertia);
        let rotary = [value!(input, rotary_inertia_y), value!(input, rotary_inertia_z)].map(|v| v.unwrap_or(0.0));
        let lumped = value!(input, lumping).unwrap_or(0.0);
        let mut lumping = [lumped; 6];
        lumping[0] = value!(input, lumping_along).unwrap_or(lumped);
        let pair = |y: Option<f64>, z: Option<f64>| [y.unwrap_or(0.0), z.unwrap_or(0.0)];
        let shear_centre = pair(value!(input, shear_centre_y), value!(input, shear_centre_z));
        let from_centre = |axis: Option<f64>, centre: f64| axis.map_or(0.0, |at| at - centre);

        let section = Self {
            length,
            rigid,
            ea: ea.unwrap_or(0.0),
            gj: gj.unwrap_or(0.0),
            ei: [eiz.unwrap_or(0.0), eiy.unwrap_or(0.0)],
            shear_compliance: [
                shear_compliance(
                    input,
                    ("kappa_y", value!(input, kappa_y)),
                    ("shear_compliance_y", value!(input, shear_compliance_y)),
                )?,
                shear_compliance(
                    input,
                    ("kappa_z", value!(input, kappa_z)),
                    ("shear_compliance_z", value!(input, shear_compliance_z)),
                )?,
            ],
            bend_twist,
            axial_force: value!(input, axial_force).unwrap_or(0.0),
            inertia: [mass, mass, mass, polar, rotary[0], rotary[1]],
            air,
            shear_centre,
            neutral_axis: [
                from_centre(value!(input, neutral_axis_y), shear_centre[0]),
                from_centre(value!(input, neutral_axis_z), shear_centre[1]),
            ],
            lumping,
            mass_offset: pair(value!(input, mass_offset_y), value!(input, mass_offset_z)),
            end_compliance: std::array::from_fn(|d| input.values[END_COMPLIANCE + d].unwrap_or(0.0)),
            hinges: [hinge(input, 0)?, hinge(input, 1)?],
        };
        for p in 0..2 {
            let phi = section.phi(p);
            if !phi.is_finite() {
                let name = ["shear_compliance_y", "shear_compliance_z"][p];
                let expected = "so small that 12 EI/(L² kappa G A) is a number";
                return Err(ElementError::OutOfDomain { name, value: section.shear_compliance[p], expected });
            }
        }
        Ok(section)
    }

    /// From node to node, m.
    pub(super) fn span(&self) -> f64 {
        self.length + self.rigid[0] + self.rigid[1]
    }

    /// Φ = 12 EI c / L² of plane `p`: bending flexibility against shear flexibility.
    pub(super) fn phi(&self, p: usize) -> f64 {
        12.0 * self.ei[p] * self.shear_compliance[p] / (self.length * self.length)
    }
}

/// Mechanisms without stiffness of a beam that has some, and a twist inertia that the density alone does not give.
pub(super) fn lacks(input: &ElementInput<'_>) -> Vec<Lack> {
    let Ok([ea, gj, eiz, eiy]) = input.check(&Beam).and_then(|()| rigidities(input)) else { return Vec::new() };
    let e = ("E", value!(input, E));
    let g = ("G", shear_modulus(input).unwrap_or(None));
    let mut lacks = Vec::new();
    let mut lack = |dofs: &[Dof], property| lacks.extend(dofs.iter().map(|&dof| Lack { dof, property }));
    let massive_only = [e.1, g.1, ea, gj, eiz, eiy].iter().all(Option::is_none);
    if !massive_only {
        if ea.is_none() {
            lack(&[Dof::Ux], completing(e, ("A", value!(input, A)), "EA"));
        }
        if gj.is_none() {
            lack(&[Dof::Rx], completing(g, ("J", value!(input, J)), "GJ"));
        }
        if eiz.is_none() {
            lack(&[Dof::Uy, Dof::Rz], completing(e, ("Iz", value!(input, Iz)), "EIz"));
        }
        if eiy.is_none() {
            lack(&[Dof::Uz, Dof::Ry], completing(e, ("Iy", value!(input, Iy)), "EIy"));
        }
    }
    let incomplete = value!(input, Iy).is_none() || value!(input, Iz).is_none();
    if value!(input, density).is_some() && value!(input, polar_inertia_per_length).is_none() && incomplete {
        lack(&[Dof::Rx], "polar_inertia_per_length");
    }
    lacks
}

/// An aluminium tube by its dimensions; a composite spar by its rigidities, with every coupling; the same under tension.
pub(super) fn samples() -> Vec<Sample> {
    let points = || vec![[0.0; 3], [0.6, 0.0, 0.0]];
    let tube = vec![
        ("E", 70e9),
        ("G", 27e9),
        ("A", 3e-4),
        ("Iy", 4e-8),
        ("Iz", 9e-8),
        ("J", 7e-8),
        ("density", 2700.0),
        ("kappa_y", 0.5),
        ("kappa_z", 0.6),
    ];
    let mut spar = vec![
        ("EA", 8e6),
        ("EIy", 900.0),
        ("EIz", 5000.0),
        ("GJ", 700.0),
        ("mass_per_length", 0.6),
        ("added_mass_per_length", 0.1),
        ("air_mass_y", 0.02),
        ("air_mass_z", 0.3),
        ("polar_inertia_per_length", 4e-4),
        ("rotary_inertia_y", 1e-4),
        ("rotary_inertia_z", 3e-4),
        ("shear_compliance_y", 1e-6),
        ("shear_compliance_z", 2e-6),
        ("mass_offset_y", 0.02),
        ("mass_offset_z", -0.01),
        ("shear_centre_y", -0.03),
        ("shear_centre_z", 0.005),
        ("neutral_axis_y", 0.01),
        ("neutral_axis_z", -0.02),
        ("lumping", 0.4),
        ("lumping_along", 0.7),
        ("end1_rigid_length", 0.05),
        ("end2_rigid_length", 0.02),
        ("bend_twist_y", 200.0),
        ("bend_twist_z", -300.0),
    ];
    let hinges = [
        ("end1_hinge_compliance", 3e-4),
        ("end1_hinge_x", 0.6),
        ("end1_hinge_y", 0.2),
        ("end1_hinge_z", 0.8),
        ("end2_hinge_compliance", 5e-4),
        ("end2_hinge_x", 0.1),
        ("end2_hinge_y", 0.5),
        ("end2_hinge_z", -0.7),
    ];
    let hinged = [spar.as_slice(), &hinges].concat();
    let joints = [2e-7, 3e-7, 4e-7, 1e-4, 2e-4, 3e-4, 1e-7, 5e-7, 6e-7, 4e-4, 5e-4, 6e-4];
    spar.extend(PROPERTIES[END_COMPLIANCE..].iter().zip(joints).map(|(p, c)| (p.name, c)));
    let tensioned = [spar.clone(), vec![("axial_force", 400.0)]].concat();
    let isotropic = tube.iter().map(|&(n, v)| if n == "G" { ("nu", 0.3) } else { (n, v) }).collect();
    vec![
        Sample { points: points(), given: isotropic, mass: 2700.0 * 3e-4 * 0.6, free: true },
        Sample { points: points(), given: tube, mass: 2700.0 * 3e-4 * 0.6, free: true },
        Sample { points: points(), given: spar, mass: 0.7 * 0.6, free: true },
        Sample { points: points(), given: hinged, mass: 0.7 * 0.6, free: true },
        Sample { points: points(), given: tensioned, mass: 0.7 * 0.6, free: false },
    ]
}
