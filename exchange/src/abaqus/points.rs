//! Masses, springs and dashpots.

use super::importer::Importer;
use super::kinds::{Family, Joined};
use super::scopes::At;
use crate::system::Quantity as Q;
use crate::text::{exact, map, with_unit};
use crate::writer::Block;
use retune::deck::{DataLine, DeckError, Keyword};
use retune::element::Dof;

/// Writes the masses of a MASS.
pub(super) fn masses(importer: &mut Importer<'_>, k: &Keyword<'_>, elements: &[At]) -> Result<(), DeckError> {
    if k.label("TYPE").is_some_and(|t| t != "ISOTROPIC") || k.parameter("ORIENTATION").is_some() {
        return Err(k.error("masses that differ by direction are not read; give an isotropic one"));
    }
    let line = k.needs_line(0, "the mass")?;
    let mass = line.real(0, "mass")?;
    if mass < 0.0 {
        return Err(line.error(Some((0, "mass")), "it must not be negative"));
    }
    importer.bind("mass", (k.index(), 0, 0), Q::Mass);
    for at in elements {
        let node = importer.node_names(*at).remove(0);
        let value = map(&[("node", node), ("mass", importer.with(mass, Q::Mass))]);
        importer.element(Block::Masses, *at, 0, &value);
    }
    Ok(())
}

/// Writes the inertias of a ROTARY INERTIA.
pub(super) fn inertias(
    importer: &mut Importer<'_>,
    k: &Keyword<'_>,
    instance: u32,
    elements: &[At],
) -> Result<(), DeckError> {
    let line = k.needs_line(0, "the inertias I11, I22, I33, I12, I13, I23")?;
    let mut values = Vec::new();
    for (i, axes) in ["xx", "yy", "zz", "xy", "xz", "yz"].into_iter().enumerate() {
        let value = line.real_or(i, "inertia", 0.0)?;
        if value < 0.0 && i < 3 {
            return Err(line.error(Some((i, "inertia")), "it must not be negative"));
        }
        // The deck's products are entries of the tensor, -∫ x y dm.
        let value = if i < 3 { value } else { -value };
        if value != 0.0 {
            values.push((axes, importer.with(value, Q::Inertia)));
            importer.bind_inertia(axes, (k.index(), 0, i), if i < 3 { 1.0 } else { -1.0 });
        }
    }
    if values.is_empty() {
        return Err(line.error(Some((0, "inertia")), "an inertia above zero is expected"));
    }
    let orientation = match k.label("ORIENTATION") {
        Some(name) => Some(importer.orientation(k, instance, &name)?),
        None => None,
    };
    for at in elements {
        let node = importer.node_names(*at).remove(0);
        let mut items = vec![("node", node), ("inertia", map(&values))];
        if let Some(o) = &orientation {
            let at = importer.centre(*at);
            items.push(("frame", importer.frame_at(o, at)));
        }
        importer.element(Block::Masses, *at, 0, &map(&items));
    }
    Ok(())
}

/// A dof of a spring, from 1 to 6, as its place in [`Dof::ALL`].
fn dof(line: &DataLine<'_>, i: usize) -> Result<usize, DeckError> {
    match line.id(i, "dof")? {
        d @ 1..=6 => Ok(d as usize - 1),
        _ => Err(line.error(Some((i, "dof")), "a dof from 1 to 6 is expected")),
    }
}

fn quantity(dof: usize, is_damping: bool) -> Q {
    match (dof >= 3, is_damping) {
        (false, false) => Q::Stiffness,
        (true, false) => Q::RotationalStiffness,
        (false, true) => Q::Damping,
        (true, true) => Q::RotationalDamping,
    }
}

/// Writes the springs of a SPRING, or the dashpots of a DASHPOT.
pub(super) fn springs(
    importer: &mut Importer<'_>,
    k: &Keyword<'_>,
    instance: u32,
    elements: &[At],
) -> Result<(), DeckError> {
    let is_damping = k.name() == "DASHPOT";
    let key = if is_damping { "c" } else { "k" };
    if k.parameter("NONLINEAR").is_some() {
        return Err(
            k.error("a nonlinear spring has no one stiffness; give the tangent at which the structure vibrates")
        );
    }
    if k.parameter("COMPLEXSTIFFNESS").is_some() {
        return Err(k.error("a complex stiffness is not read; give its real part as a SPRING"));
    }
    // The first line has the dofs; springs along their own line may leave it out.
    let head = k.needs_line(0, "the dofs, or an empty line")?;
    let line = match k.line(1) {
        Some(line) => line,
        None => head.clone(),
    };
    let value = line.real(0, "stiffness")?;
    if value < 0.0 {
        return Err(line.error(Some((0, "stiffness")), "it must not be negative"));
    }
    importer.only_first(k, 2);
    let value_at = (k.index(), usize::from(k.n_lines() > 1), 0);
    let orientation = match k.label("ORIENTATION") {
        Some(name) => Some(importer.orientation(k, instance, &name)?),
        None => None,
    };
    for at in elements {
        let (kind, names) = (importer.kind(*at), importer.node_names(*at));
        let nodes = importer.nodes_of(*at);
        let (Family::Spring(joined) | Family::Dashpot(joined)) = kind.family else { continue };
        if joined != Joined::Line && k.n_lines() < 2 {
            return Err(k.error("its first data line has the dofs, its second the stiffness; one of them is missing"));
        }
        match joined {
            Joined::Line => {
                if retune::linalg::vector3::unit(retune::linalg::vector3::minus(
                    importer.position(nodes[1]),
                    importer.position(nodes[0]),
                ))
                .is_none()
                {
                    return Err(
                        importer.at_element(*at, "its nodes are at the same place, so it has no line; give a SPRING2")
                    );
                }
                let spring = importer.with(value, quantity(0, is_damping));
                importer.bind(key, value_at, quantity(0, is_damping));
                let value = map(&[("nodes", format!("[{}]", names.join(", "))), (key, format!("{{axial: {spring}}}"))]);
                importer.element(Block::Springs, *at, 0, &value);
            }
            Joined::Ground => {
                let d = dof(&head, 0)?;
                let spring = importer.with(value, quantity(d, is_damping));
                importer.bind(&format!("{key}_{}", Dof::ALL[d]), value_at, quantity(d, is_damping));
                let mut items = vec![("node", names[0].clone()), (key, format!("{{{}: {spring}}}", Dof::ALL[d]))];
                let frame = match &orientation {
                    Some(o) => {
                        let point = importer.position(nodes[0]);
                        Some(importer.frame_at(o, point))
                    }
                    None => importer.frame_of_node(nodes[0]),
                };
                items.extend(frame.map(|f| ("frame", f)));
                importer.element(Block::Springs, *at, 0, &map(&items));
            }
            Joined::Dofs => {
                let dofs = [dof(&head, 0)?, if head.len() > 1 { dof(&head, 1)? } else { dof(&head, 0)? }];
                if (dofs[0] >= 3) != (dofs[1] >= 3) {
                    importer.report.note(
                        "springs between a displacement and a rotation count radians as the deck's unit of length",
                    );
                }
                importer.bind(key, value_at, quantity(0, is_damping));
                let mut properties = vec![(key.to_string(), importer.with(value, quantity(0, is_damping)))];
                for (prefix, sign, node, d) in [("a", -1.0, nodes[0], dofs[0]), ("b", 1.0, nodes[1], dofs[1])] {
                    let mut placed = importer.placed(node);
                    if let Some(o) = &orientation {
                        placed.axes = o.turned_at(placed.position);
                    }
                    for (dof, factor) in placed.component(d) {
                        let unit = if dof.is_rotation() { importer.unit(Q::Length) } else { "" };
                        properties.push((format!("{prefix}_{dof}"), with_unit(&exact(sign * factor), unit)));
                    }
                }
                let items = [
                    ("type", "scalar_spring".to_string()),
                    ("nodes", format!("[{}]", names.join(", "))),
                    ("properties", map(&properties)),
                ];
                importer.listed(*at, 0, &items.map(|(key, value)| (key.to_string(), value)));
            }
        }
    }
    Ok(())
}
