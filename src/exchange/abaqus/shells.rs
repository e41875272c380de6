//! Shells.

use super::elastic::Material;
use super::importer::{Importer, Solver, Values};
use crate::deck::{DataLine, DeckError, Keyword};
use crate::exchange::motions::angle_from_global;
use crate::exchange::system::Quantity as Q;
use crate::exchange::writer::{Block, computed, map};
use crate::model::{cross, minus, plus, unit};

/// What a section of shells says beside its material.
struct Layer {
    material: Material,
    thickness: f64,
    /// From the nodes to the mid-surface.
    offset: f64,
    /// Of the material's first direction from that of the orientation, rad.
    angle: f64,
}

fn thickness(line: &DataLine<'_>, i: usize) -> Result<f64, DeckError> {
    let t = line.real(i, "thickness")?;
    if t > 0.0 { Ok(t) } else { Err(line.error(Some((i, "thickness")), "it must be above zero")) }
}

fn layer(importer: &mut Importer<'_>, k: &Keyword<'_>) -> Result<Layer, DeckError> {
    let unread = ["NODALTHICKNESS", "SHELLTHICKNESS", "USER", "BENDINGONLY", "MEMBRANEONLY"];
    if let Some(name) = unread.into_iter().find(|p| k.parameter(p).is_some()) {
        return Err(
            k.error(format_args!("its parameter {name} is not read; give thickness and material on the section"))
        );
    }
    let mut out = if k.parameter("COMPOSITE").is_some() {
        laminate(importer, k)?
    } else {
        let material = importer.material(k)?;
        let line = k.needs_line(0, "the thickness")?;
        Layer { material, thickness: thickness(&line, 0)?, offset: 0.0, angle: 0.0 }
    };
    // The deck's offset goes from the mid-surface to the nodes, in thicknesses.
    out.offset = match k.label("OFFSET").as_deref() {
        None => 0.0,
        Some("SPOS") => -0.5 * out.thickness,
        Some("SNEG") => 0.5 * out.thickness,
        Some(text) => match text.parse::<f64>() {
            Ok(v) if v.is_finite() => -v * out.thickness,
            _ => {
                return Err(
                    k.error(format_args!("OFFSET is `{text}`; SPOS, SNEG or a number of thicknesses is expected"))
                );
            }
        },
    };
    if let Some(text) = k.parameter("DENSITY") {
        match text.parse::<f64>() {
            // Of a general section it is a mass by area.
            Ok(v) if v >= 0.0 && v.is_finite() => {
                out.material.density = Some(v / out.thickness).filter(|v| *v > 0.0);
                out.material.density_at = None;
            }
            _ => return Err(k.error("DENSITY must be a number, zero or above")),
        }
    }
    Ok(out)
}

/// A laminate is read where its plies make one plate: all of one material and angle.
fn laminate(importer: &mut Importer<'_>, k: &Keyword<'_>) -> Result<Layer, DeckError> {
    let mut plies: Vec<(String, f64, f64)> = Vec::new();
    for line in k.lines().filter(|l| !l.is_empty()) {
        // Thickness, points, material, angle or orientation.
        let angle = match line.text(3) {
            "" => 0.0,
            _ => line.real(3, "angle").map_err(|_| {
                line.error(Some((3, "angle")), "an angle in degrees is expected; orientations of plies are not read")
            })?,
        };
        plies.push((crate::deck::label(line.text(2)), thickness(&line, 0)?, angle));
    }
    let Some((name, _, angle)) = plies.first().cloned() else { return Err(k.error("it has no plies")) };
    let material = importer.material_of(k, &name)?;
    let is_one =
        plies.iter().all(|p| p.0 == name && (p.2 == angle || material.elastic.is_some_and(|e| e.is_isotropic())));
    if !is_one {
        return Err(
            k.error("a laminate of several materials or angles is not read; give one with equivalent constants")
        );
    }
    // Of a symmetric laminate one half is given.
    let twice = if k.parameter("SYMMETRIC").is_some() { 2.0 } else { 1.0 };
    let total = twice * plies.iter().map(|p| p.1).sum::<f64>();
    Ok(Layer { material, thickness: total, offset: 0.0, angle: angle.to_radians() })
}

/// Writes the shells of a SHELL SECTION.
pub(super) fn section(
    importer: &mut Importer<'_>,
    k: &Keyword<'_>,
    instance: u32,
    elements: &[super::scopes::At],
) -> Result<(), DeckError> {
    let layer = layer(importer, k)?;
    if let Some(below) = importer.deck.keywords().nth(k.index() + 1).filter(|b| b.name().starts_with("TRANSVERSESHEAR"))
    {
        let text = format!("*{} of shells is left out: they have the 5/6 G t of a solid plate", below.name());
        importer.report.approximate(text);
    }
    let is_directed = layer.material.elastic.is_some_and(|e| !e.is_isotropic());
    let orientation = match k.label("ORIENTATION").filter(|_| is_directed) {
        Some(name) => Some(importer.orientation(k, instance, &name)?),
        None => None,
    };
    if importer.options.solver == Solver::CalculiX {
        importer.report.approximate("CalculiX expands shells into solids; retune's have six dofs a node");
    }
    for at in elements {
        let kind = importer.kind(*at);
        let is_lumped = kind.is_first_order && importer.options.solver == Solver::Abaqus;
        let section = importer.section(k, if is_lumped { "shell_lumped" } else { "shell" }, |importer| {
            let mut values: Values = Vec::new();
            importer.elastic(k, &layer.material, true, &mut values)?;
            values.push(("thickness".into(), importer.computed(layer.thickness, Q::Length)));
            if k.parameter("COMPOSITE").is_none() {
                importer.bind("thickness", (k.index(), 0, 0), Q::Length);
            }
            if layer.offset != 0.0 {
                values.push(("offset".into(), importer.computed(layer.offset, Q::Length)));
            }
            if is_lumped {
                values.push(("lumping".into(), "1".into()));
            }
            Ok(values)
        })?;
        let (names, points) = (importer.node_names(*at), importer.points(*at));
        for (part, (element, order)) in kind.becomes.iter().enumerate() {
            let nodes: Vec<&str> = order.iter().map(|i| names[*i].as_str()).collect();
            let mut values = vec![
                ("type".to_string(), (*element).to_string()),
                ("nodes".to_string(), format!("[{}]", nodes.join(", "))),
                ("section".to_string(), section.clone()),
            ];
            let corners: Vec<[f64; 3]> = order.iter().map(|i| points[*i]).collect();
            let normal = match corners.len() {
                4 => cross(minus(corners[2], corners[0]), minus(corners[3], corners[1])),
                _ => cross(minus(corners[1], corners[0]), minus(corners[2], corners[0])),
            };
            let Some(normal) = unit(normal) else {
                return Err(importer.at_element(*at, "its nodes span no area"));
            };
            if is_directed {
                let is_expanded = importer.options.solver == Solver::CalculiX;
                let direction = match &orientation {
                    // CalculiX makes solids of shells, whose first direction is that of the orientation; measured with its version 2.20.
                    Some(o) if is_expanded => o.turned_at(importer.centre(*at))[0],
                    // The axis behind the one about which it turns is projected onto the shell.
                    Some(o) => o.axes_at(importer.centre(*at))[o.axis % 3],
                    // Global x, or z where x is within 0.1 degrees of the normal.
                    None if normal[0].abs() < 0.1_f64.to_radians().cos() => [1.0, 0.0, 0.0],
                    None => [0.0, 0.0, 1.0],
                };
                let along = plus(direction, -crate::model::dot(direction, normal), normal);
                if unit(along).is_none_or(|_| crate::model::dot(along, along) < 1e-12) {
                    return Err(
                        importer.at_element(*at, "its ORIENTATION has the material's direction along the normal")
                    );
                }
                let more = orientation.as_ref().filter(|_| !is_expanded).map_or(0.0, |o| o.angle) + layer.angle;
                let angle = angle_from_global(normal, direction) + more;
                values.push(("properties".to_string(), format!("{{angle: {} rad}}", computed(angle))));
            }
            importer.element(Block::Elements, *at, part, &map(&values));
        }
        importer.differs(kind);
    }
    Ok(())
}
