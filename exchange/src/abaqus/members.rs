//! Beams and trusses.

use super::elastic::Material;
use super::importer::{Importer, Solver, Values};
use super::kinds::Family;
use super::profile::{self, Profile};
use crate::system::Quantity as Q;
use crate::text::{computed, direction, map};
use crate::writer::Block;
use retune::deck::{DeckError, Keyword};
use retune::linalg::vector3::{cross, dot, minus, plus, unit};

/// A section of beams with its material and direction.
struct BeamSection {
    profile: Profile,
    e: f64,
    nu: Option<f64>,
    g: Option<f64>,
    density: Option<f64>,
    /// Where the moduli come from, if not from the section itself.
    material: Option<Material>,
    /// Direction of the first axis of the section.
    n1: [f64; 3],
    /// Shear stiffness along axes 1 and 2, where it is given.
    shear: Option<[f64; 2]>,
    shear_centre: Option<[f64; 2]>,
    /// Data lines of sizes.
    n_lines: usize,
}

fn read(importer: &Importer<'_>, k: &Keyword<'_>, instance: u32) -> Result<BeamSection, DeckError> {
    for offset in ["OFFSET1", "OFFSET2"] {
        if k.parameter(offset).is_some_and(|v| v.parse() != Ok(0.0)) {
            return Err(k.error(format_args!("{offset} is not read; give CENTROID of a BEAM GENERAL SECTION")));
        }
    }
    let shape: String = k.label("SECTION").unwrap_or_else(|| "GENERAL".to_string()).split_whitespace().collect();
    let line = k.needs_line(0, "the sizes of the section")?;
    let profile = profile::read(k, &shape, &line)?;
    let n_lines = profile::n_lines(&shape, &line)?;
    let n1 = match k.line(n_lines).filter(|l| !l.is_empty()) {
        Some(line) => line.vector(0, "n1")?,
        None => [0.0, 0.0, -1.0],
    };
    let n1 = importer.all.instances[instance as usize].turn(n1);
    let has_material = k.name() == "BEAMSECTION" || k.parameter("MATERIAL").is_some();
    let mut out = if has_material {
        let material = importer.material(k)?;
        let [e, nu] = material.isotropic(k)?;
        BeamSection {
            profile,
            e,
            nu: Some(nu),
            g: None,
            density: material.density,
            material: Some(material),
            n1,
            shear: None,
            shear_centre: profile.shear_centre,
            n_lines,
        }
    } else {
        let line = k.needs_line(n_lines + 1, "E and G")?;
        let (e, g) = (line.real(0, "E")?, line.real_or(1, "G", 0.0)?);
        if e <= 0.0 || g < 0.0 {
            return Err(line.error(Some((usize::from(e > 0.0), "modulus")), "it must be above zero"));
        }
        let density = match k.parameter("DENSITY").map(str::parse::<f64>) {
            None => None,
            Some(Ok(rho)) if rho >= 0.0 && rho.is_finite() => Some(rho).filter(|r| *r > 0.0),
            Some(_) => return Err(k.error("DENSITY must be a number, zero or above")),
        };
        let shear_centre = profile.shear_centre;
        BeamSection {
            profile,
            e,
            nu: None,
            g: Some(g),
            density,
            material: None,
            n1,
            shear: None,
            shear_centre,
            n_lines,
        }
    };
    // What belongs to a section stands right below it.
    let count = importer.deck.keywords().len();
    for index in k.index() + 1..count {
        let sub = importer.deck.keyword(index);
        match sub.name() {
            "TRANSVERSESHEARSTIFFNESS" | "TRANSVERSESHEAR" => {
                let line = sub.needs_line(0, "K23 and K13")?;
                let (k23, k13) = (line.real(0, "K23")?, line.real_or(1, "K13", 0.0)?);
                let k13 = if k13 == 0.0 { k23 } else { k13 };
                if k23 <= 0.0 || k13 <= 0.0 {
                    return Err(line.error(Some((0, "K23")), "it must be above zero"));
                }
                out.shear = Some([k13, k23]);
            }
            "CENTROID" => {
                let line = sub.needs_line(0, "x1 and x2")?;
                out.profile.centroid = [line.real_or(0, "x1", 0.0)?, line.real_or(1, "x2", 0.0)?];
            }
            "SHEARCENTER" => {
                let line = sub.needs_line(0, "x1 and x2")?;
                out.shear_centre = Some([line.real_or(0, "x1", 0.0)?, line.real_or(1, "x2", 0.0)?]);
            }
            _ => break,
        }
    }
    Ok(out)
}

/// Items of a section of beams: of its material, and of constants given directly along principal axes.
fn bind(importer: &Importer<'_>, k: &Keyword<'_>, s: &BeamSection) {
    match &s.material {
        Some(material) => {
            if let Some(at) = material.elastic_at {
                importer.bind("E", (at, 0, 0), Q::Stress);
                importer.bind("nu", (at, 0, 1), Q::Number);
            }
            importer.bind_density(material);
        }
        None => {
            importer.bind("E", (k.index(), s.n_lines + 1, 0), Q::Stress);
            importer.bind("G", (k.index(), s.n_lines + 1, 1), Q::Stress);
        }
    }
    let is_general = k.label("SECTION").is_none_or(|s| s == "GENERAL");
    if is_general && s.profile.turn() == 0.0 {
        for (key, item, q) in
            [("A", 0, Q::Area), ("Iy", 1, Q::SecondMoment), ("Iz", 3, Q::SecondMoment), ("J", 4, Q::SecondMoment)]
        {
            importer.bind(key, (k.index(), 0, item), q);
        }
    }
}

/// Properties of a section of beams, in its principal axes.
fn values(importer: &Importer<'_>, s: &BeamSection, is_shear_flexible: bool, is_lumped: bool) -> Values {
    let p = s.profile.principal();
    let put = |key: &str, value: f64, q: Q| (key.to_string(), importer.computed(value, q));
    let mut out = vec![("E".to_string(), importer.with(s.e, Q::Stress))];
    let has_torsion = p.j > 0.0 && s.g != Some(0.0);
    match (s.nu, s.g) {
        (Some(nu), _) => out.push(("nu".to_string(), importer.with(nu, Q::Number))),
        (None, Some(g)) if g > 0.0 => out.push(("G".to_string(), importer.with(g, Q::Stress))),
        _ => {}
    }
    out.push(put("A", p.area, Q::Area));
    out.push(put("Iy", p.i11, Q::SecondMoment));
    out.push(put("Iz", p.i22, Q::SecondMoment));
    out.push(if has_torsion { put("J", p.j, Q::SecondMoment) } else { ("GJ".to_string(), "0 N m2".to_string()) });
    if is_shear_flexible {
        match s.shear {
            Some(k) => {
                let newton = importer.options.system.factor(Q::Stress) * importer.options.system.factor(Q::Area);
                for (key, k) in [("shear_compliance_y", k[0]), ("shear_compliance_z", k[1])] {
                    out.push((key.to_string(), format!("{} 1/N", computed(1.0 / (k * newton)))));
                }
            }
            None if s.g != Some(0.0) => {
                for key in ["kappa_y", "kappa_z"] {
                    out.push((key.to_string(), computed(p.shear)));
                }
            }
            None => {}
        }
    }
    if let Some(rho) = s.density {
        out.push(("density".to_string(), importer.with(rho, Q::Density)));
        if is_shear_flexible {
            // Timoshenko's beam turns with its section.
            out.push(put("rotary_inertia_y", rho * p.i11, Q::InertiaPerLength));
            out.push(put("rotary_inertia_z", rho * p.i22, Q::InertiaPerLength));
        }
    }
    if p.centroid != [0.0; 2] {
        let size = p.area.sqrt();
        for (keys, v) in [
            (["neutral_axis_y", "mass_offset_y", "shear_centre_y"], p.centroid[0]),
            (["neutral_axis_z", "mass_offset_z", "shear_centre_z"], p.centroid[1]),
        ] {
            // Shear acts through the centroid, unless the deck says where.
            let keys = if s.shear_centre.is_some() { &keys[..2] } else { &keys[..] };
            if v.abs() > 1e-12 * size {
                out.extend(keys.iter().map(|key| put(key, v, Q::Length)));
            }
        }
    }
    if let Some([a, b]) = s.shear_centre {
        let (sin, cos) = s.profile.turn().sin_cos();
        for (key, v) in [("shear_centre_y", a * cos + b * sin), ("shear_centre_z", b * cos - a * sin)] {
            if v != 0.0 {
                out.push(put(key, v, Q::Length));
            }
        }
    }
    if is_lumped {
        out.push(("lumping".to_string(), "1".to_string()));
    }
    out
}

/// Writes the beams of a BEAM SECTION.
pub(super) fn beams(
    importer: &mut Importer<'_>,
    k: &Keyword<'_>,
    instance: u32,
    elements: &[super::scopes::At],
) -> Result<(), DeckError> {
    let beam = read(importer, k, instance)?;
    if k.label("SECTION").as_deref() == Some("L") {
        importer.report.note("nodes of beams of the section L lie where the middle lines of its legs meet");
    }
    if beam.profile.is_nearly_open {
        importer.report.approximate(
            "a BOX with a wall below a twentieth of another twists as an open section, and is read as closed",
        );
    }
    if importer.options.solver == Solver::CalculiX {
        importer
            .report
            .approximate("CalculiX expands beams into solids; retune's are beams with the constants of their section");
    }
    for at in elements {
        let kind = importer.kind(*at);
        debug_assert!(kind.family == Family::Beam);
        let is_shear_flexible = !kind.name.starts_with("B33");
        let is_consistent = k.label("LUMPED").is_some_and(|l| l == "NO");
        let is_lumped = kind.is_first_order && !is_consistent && importer.options.solver == Solver::Abaqus;
        let variant = match (is_shear_flexible, is_lumped) {
            (true, true) => "beam_lumped",
            (true, false) => "beam",
            (false, true) => "beam_slender_lumped",
            (false, false) => "beam_slender",
        };
        let section = importer.section(k, variant, |importer| {
            bind(importer, k, &beam);
            Ok(values(importer, &beam, is_shear_flexible, is_lumped))
        })?;
        let (names, points) = (importer.node_names(*at), importer.points(*at));
        for (part, (_, order)) in kind.becomes.iter().enumerate() {
            let along = minus(points[order[1]], points[order[0]]);
            let Some(x) = unit(along) else {
                return Err(importer.at_element(*at, "its ends are at the same place, so it has no length"));
            };
            let near = unit(beam.n1).unwrap_or_default();
            let y = plus(near, -dot(near, x), x);
            let y = match unit(y).filter(|_| dot(y, y) > 1e-12) {
                Some(y) => y,
                None if beam.profile.is_round => {
                    let i = (0..3).min_by(|a, b| x[*a].abs().total_cmp(&x[*b].abs())).unwrap_or(0);
                    cross(x, retune::model::GLOBAL[i])
                }
                None => {
                    let text = "the direction n1 of its section is along the element itself; give it in the second data line of the section";
                    return Err(importer.at_element(*at, text));
                }
            };
            let z = cross(x, y);
            let (sin, cos) = beam.profile.turn().sin_cos();
            // z turned about x with the principal axes.
            let z = plus(z.map(|v| v * cos), -sin, y);
            let values = [
                ("nodes", format!("[{}, {}]", names[order[0]], names[order[1]])),
                ("section", section.clone()),
                ("orientation", direction(z)),
            ];
            importer.element(Block::Beams, *at, part, &map(&values));
        }
        importer.differs(kind);
    }
    Ok(())
}

/// Writes the trusses of a SOLID SECTION.
pub(super) fn trusses(
    importer: &mut Importer<'_>,
    k: &Keyword<'_>,
    elements: &[super::scopes::At],
) -> Result<(), DeckError> {
    let material = importer.material(k)?;
    let [e, _] = material.isotropic(k)?;
    // The area is one where it is not given.
    let area = match k.line(0).filter(|l| !l.is_empty()) {
        Some(line) => {
            let a = line.real(0, "area")?;
            if a <= 0.0 {
                return Err(line.error(Some((0, "area")), "it must be above zero"));
            }
            a
        }
        None => 1.0,
    };
    for at in elements {
        let kind = importer.kind(*at);
        let is_lumped = kind.is_first_order && importer.options.solver == Solver::Abaqus;
        let variant = if is_lumped { "truss_lumped" } else { "truss" };
        let section = importer.section(k, variant, |importer| {
            if let Some(at) = material.elastic_at {
                importer.bind("E", (at, 0, 0), Q::Stress);
            }
            importer.bind("A", (k.index(), 0, 0), Q::Area);
            importer.bind_density(&material);
            let mut values =
                vec![("E".to_string(), importer.with(e, Q::Stress)), ("A".to_string(), importer.with(area, Q::Area))];
            values.extend(material.density.map(|rho| ("density".to_string(), importer.with(rho, Q::Density))));
            if is_lumped {
                values.push(("lumping".to_string(), "1".to_string()));
            }
            Ok(values)
        })?;
        let (names, points) = (importer.node_names(*at), importer.points(*at));
        for (part, (_, order)) in kind.becomes.iter().enumerate() {
            if unit(minus(points[order[1]], points[order[0]])).is_none() {
                return Err(importer.at_element(*at, "its ends are at the same place, so it has no length"));
            }
            let nodes = format!("[{}, {}]", names[order[0]], names[order[1]]);
            importer.element(Block::Bars, *at, part, &map(&[("nodes", nodes), ("section", section.clone())]));
        }
        importer.differs(kind);
    }
    Ok(())
}
