//! Connectors: what their type joins becomes links, and the elasticity of what is left free a bushing.
//!
//! Components of relative motion are along the axes of the orientation at the first node: 1 to 3 displacements, 4 to 6 rotations. Source: Abaqus
//! Analysis User's Guide, connector element library.

use super::importer::Importer;
use super::scopes::At;
use crate::system::Quantity as Q;
use crate::text::map;
use crate::writer::Block;
use retune::deck::{DeckError, Keyword};
use retune::element::Dof;
use retune::linalg::vector3::{minus, unit};

/// A type of connection: components that it holds, and whether it measures along the line between its nodes alone.
struct Connection {
    name: &'static str,
    held: [bool; 6],
    is_axial: bool,
}

const fn held(name: &'static str, held: [u8; 6]) -> Connection {
    let [a, b, c, d, e, f] = held;
    Connection { name, held: [a == 1, b == 1, c == 1, d == 1, e == 1, f == 1], is_axial: false }
}

/// Types that are read; one that is put together is the sum of its parts.
const CONNECTIONS: &[Connection] = &[
    held("CARTESIAN", [0, 0, 0, 0, 0, 0]),
    held("PROJECTIONCARTESIAN", [0, 0, 0, 0, 0, 0]),
    held("JOIN", [1, 1, 1, 0, 0, 0]),
    held("SLOT", [0, 1, 1, 0, 0, 0]),
    held("SLIDE-PLANE", [1, 0, 0, 0, 0, 0]),
    Connection { name: "AXIAL", held: [false; 6], is_axial: true },
    held("CARDAN", [0, 0, 0, 0, 0, 0]),
    held("EULER", [0, 0, 0, 0, 0, 0]),
    held("ROTATION", [0, 0, 0, 0, 0, 0]),
    held("FLEXION-TORSION", [0, 0, 0, 0, 0, 0]),
    held("PROJECTIONFLEXION-TORSION", [0, 0, 0, 0, 0, 0]),
    held("ALIGN", [0, 0, 0, 1, 1, 1]),
    held("REVOLUTE", [0, 0, 0, 0, 1, 1]),
    held("UNIVERSAL", [0, 0, 0, 0, 1, 0]),
    held("BUSHING", [0, 0, 0, 0, 0, 0]),
    held("BEAM", [1, 1, 1, 1, 1, 1]),
    held("WELD", [1, 1, 1, 1, 1, 1]),
    held("HINGE", [1, 1, 1, 0, 1, 1]),
    held("UJOINT", [1, 1, 1, 0, 1, 0]),
    held("TRANSLATOR", [0, 1, 1, 1, 1, 1]),
    held("CYLINDRICAL", [0, 1, 1, 0, 1, 1]),
    held("PLANAR", [1, 0, 0, 0, 1, 1]),
];

/// Writes the connectors of a CONNECTOR SECTION.
pub(super) fn section(
    importer: &mut Importer<'_>,
    k: &Keyword<'_>,
    instance: u32,
    elements: &[At],
) -> Result<(), DeckError> {
    let line = k.needs_line(0, "the type of connection")?;
    let (mut flags, mut is_axial, mut is_in_the_middle) = ([false; 6], false, false);
    for i in 0..line.len() {
        let name: String = line.text(i).to_uppercase().split_whitespace().collect();
        let Some(found) = CONNECTIONS.iter().find(|c| c.name == name) else {
            let suggestion = retune::catalogue::did_you_mean(&name, CONNECTIONS.iter().map(|c| c.name));
            return Err(line
                .error(Some((i, "type")), format_args!("connections of the type `{name}` are not read{suggestion}")));
        };
        for c in 0..6 {
            flags[c] |= found.held[c];
        }
        is_axial |= found.is_axial;
        is_in_the_middle |= matches!(found.name, "BUSHING" | "PROJECTIONCARTESIAN");
    }
    let elastic = elasticity(importer, k, &mut flags)?;
    let orientation = match k.line(1).map(|l| retune::deck::label(l.text(0))).filter(|n| !n.is_empty()) {
        Some(name) => Some(importer.orientation(k, instance, &name)?),
        None => None,
    };
    if is_axial && let Some((_, _, at)) = elastic.iter().find(|e| e.0 != 0) {
        return Err(importer.deck.keyword(*at).error("AXIAL has component 1 alone"));
    }
    for at in elements {
        let nodes = importer.nodes_of(*at);
        let (a, b) = (importer.position(nodes[0]), importer.position(nodes[1]));
        let names = importer.node_names(*at).join(", ");
        let is_apart = unit(minus(b, a)).is_some();
        if flags != [false; 6] {
            let axes = orientation.as_ref().map(|o| o.turned_at(a));
            let id = importer.id_of(*at);
            importer.link(&format!("connector_{id}"), nodes[0], &nodes[1..], flags, axes);
        }
        if elastic.is_empty() {
            continue;
        }
        if is_axial {
            if !is_apart {
                return Err(importer.at_element(*at, "its nodes are at the same place, so it has no line"));
            }
            let (_, k, keyword) = elastic[0];
            importer.bind("k", (keyword, 0, 0), Q::Stiffness);
            let spring = format!("{{axial: {}}}", importer.with(k, Q::Stiffness));
            importer.element(Block::Springs, *at, 0, &map(&[("nodes", format!("[{names}]")), ("k", spring)]));
            continue;
        }
        let mut stiffness = Vec::new();
        for &(component, value, keyword) in &elastic {
            let dof = Dof::ALL[component];
            let of = if dof.is_rotation() { Q::RotationalStiffness } else { Q::Stiffness };
            importer.bind(&format!("k_{dof}"), (keyword, 0, 0), of);
            stiffness.push((dof.name(), importer.with(value, of)));
        }
        let mut items = vec![("nodes", format!("[{names}]")), ("k", map(&stiffness))];
        if is_apart && !is_in_the_middle {
            // The displacement of the second node in the axes that turn with the first.
            items.push(("location", "1".to_string()));
        }
        if let Some(o) = &orientation {
            items.push(("frame", importer.frame_at(o, a)));
        }
        importer.element(Block::Bushings, *at, 0, &map(&items));
    }
    Ok(())
}

/// Stiffnesses of a behavior: component from 0, value, keyword; what it says to be rigid is held.
fn elasticity(
    importer: &Importer<'_>,
    k: &Keyword<'_>,
    held: &mut [bool; 6],
) -> Result<Vec<(usize, f64, usize)>, DeckError> {
    let Some(name) = k.label("BEHAVIOR") else { return Ok(Vec::new()) };
    let behaviors = &importer.all.behaviors;
    let Some(keywords) = behaviors.get(&name) else {
        let suggestion = retune::catalogue::did_you_mean(&name, behaviors.keys().map(String::as_str));
        return Err(k.error(format_args!("there is no connector behavior `{name}`{suggestion}")));
    };
    let mut out: Vec<(usize, f64, usize)> = Vec::new();
    for index in keywords {
        let own = importer.deck.keyword(*index);
        if own.name() != "CONNECTORELASTICITY" {
            continue;
        }
        if own.parameter("NONLINEAR").is_some() {
            return Err(own.error(
                "a nonlinear connector has no one stiffness; give the tangent at which the structure vibrates",
            ));
        }
        let components: Vec<usize> = match own.parameter("COMPONENT").map(str::parse::<usize>) {
            Some(Ok(c @ 1..=6)) => vec![c - 1],
            Some(_) => return Err(own.error("COMPONENT must be a number from 1 to 6")),
            // All that are free; of stiffnesses that would be a matrix.
            None if own.parameter("RIGID").is_some() && own.n_lines() == 0 => (0..6).collect(),
            None => return Err(own.error("stiffnesses that couple components are not read; give one COMPONENT each")),
        };
        if own.parameter("RIGID").is_some() {
            for c in components {
                held[c] = true;
            }
            continue;
        }
        let line = own.needs_line(0, "the stiffness")?;
        let value = line.real(0, "stiffness")?;
        if value < 0.0 {
            return Err(line.error(Some((0, "stiffness")), "it must not be negative"));
        }
        let component = components[0];
        if held[component] {
            return Err(own.error(format_args!("component {} is held by the type of the connector", component + 1)));
        }
        if out.iter().any(|o| o.0 == component) {
            return Err(own.error(format_args!("component {} has a stiffness already", component + 1)));
        }
        if value > 0.0 {
            out.push((component, value, *index));
        }
    }
    out.sort_by_key(|o| o.0);
    Ok(out)
}
