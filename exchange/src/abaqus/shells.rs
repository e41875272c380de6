//! Shells.

use super::elastic::Material;
use super::importer::{Importer, Solver, Values};
use super::layers;
use crate::motions::angle_from_global;
use crate::patches;
use crate::system::Quantity as Q;
use crate::text::computed;
use retune::deck::{DeckError, Keyword};
use retune::linalg::vector3::{plus, unit};

/// What a section of shells says.
struct Layer {
    material: Layers,
    thickness: f64,
    /// From the nodes to the mid-surface.
    offset: f64,
    /// Mass by area that stands in place of the material's, in the deck's unit.
    mass_per_area: Option<f64>,
}

enum Layers {
    /// One material, its first direction turned from that of the orientation by an angle, rad.
    One(Box<Material>, f64),
    Plies(layers::LayUp),
}

impl Layers {
    fn is_directed(&self) -> bool {
        match self {
            Layers::One(material, _) => material.elastic.is_some_and(|e| !e.is_isotropic()),
            Layers::Plies(_) => true,
        }
    }
}

fn layer(importer: &mut Importer<'_>, k: &Keyword<'_>) -> Result<Layer, DeckError> {
    let unread = ["NODALTHICKNESS", "SHELLTHICKNESS", "USER", "BENDINGONLY", "MEMBRANEONLY"];
    if let Some(name) = unread.into_iter().find(|p| k.parameter(p).is_some()) {
        return Err(
            k.error(format_args!("its parameter {name} is not read; give thickness and material on the section"))
        );
    }
    let (material, thickness) = if k.parameter("COMPOSITE").is_some() {
        let lay_up = layers::read(k)?;
        let thickness = lay_up.thickness();
        match lay_up.one(importer, k)? {
            Some((material, angle)) => (Layers::One(Box::new(material), angle), thickness),
            None => (Layers::Plies(lay_up), thickness),
        }
    } else {
        let material = importer.material(k)?;
        let line = k.needs_line(0, "the thickness")?;
        (Layers::One(Box::new(material), 0.0), layers::thickness(&line, 0)?)
    };
    let mut out = Layer { material, thickness, offset: 0.0, mass_per_area: None };
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
            Ok(v) if v >= 0.0 && v.is_finite() => out.mass_per_area = Some(v),
            _ => return Err(k.error("DENSITY must be a number, zero or above")),
        }
    }
    Ok(out)
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
    let is_directed = layer.material.is_directed();
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
        let centre = importer.centre(*at);
        let base = orientation.as_ref().map(|o| o.on_shell(centre, importer.options.solver));
        let turned = match &layer.material {
            Layers::Plies(lay_up) => lay_up.angles(importer, k, (instance, *at), base)?,
            Layers::One(..) => Vec::new(),
        };
        let kind_of = if is_lumped { "shell_lumped" } else { "shell" };
        let section = importer.section(k, &layers::variant(kind_of, &turned), |importer| {
            let mut values: Values = Vec::new();
            match &layer.material {
                Layers::One(material, _) => {
                    let mut own = **material;
                    if layer.mass_per_area.is_some() {
                        (own.density, own.density_at) = (None, None);
                    }
                    importer.elastic(k, &own, true, &mut values)?;
                    values.push(("thickness".into(), importer.computed(layer.thickness, Q::Length)));
                    if k.parameter("COMPOSITE").is_none() {
                        importer.bind("thickness", (k.index(), 0, 0), Q::Length);
                    }
                    let by_volume = layer.mass_per_area.map(|m| m / layer.thickness).filter(|rho| *rho > 0.0);
                    values.extend(by_volume.map(|rho| ("density".into(), importer.computed(rho, Q::Density))));
                }
                Layers::Plies(lay_up) => {
                    lay_up.write(importer, k, &turned, layer.mass_per_area.is_none(), &mut values)?;
                    let by_area = layer.mass_per_area.filter(|m| *m > 0.0);
                    values.extend(by_area.map(|m| ("mass_per_area".into(), importer.computed(m, Q::MassPerArea))));
                }
            }
            if layer.offset != 0.0 {
                values.push(("offset".into(), importer.computed(layer.offset, Q::Length)));
            }
            if is_lumped {
                values.push(("lumping".into(), "1".into()));
            }
            Ok(values)
        })?;
        let (mut names, mut points) = (importer.node_names(*at), importer.points(*at));
        if kind.nodes == 8 {
            let middle = patches::centre(&points);
            names.push(importer.middle(*at, middle));
            points.push(middle);
        }
        for (part, (element, order)) in kind.becomes.iter().enumerate() {
            let nodes: Vec<&str> = order.iter().map(|i| names[*i].as_str()).collect();
            let mut values = vec![
                ("type".to_string(), (*element).to_string()),
                ("nodes".to_string(), format!("[{}]", nodes.join(", "))),
                ("section".to_string(), section.clone()),
            ];
            let corners: Vec<[f64; 3]> = order.iter().map(|i| points[*i]).collect();
            let Some(normal) = layers::normal(&corners) else {
                return Err(importer.at_element(*at, "its nodes span no area"));
            };
            if is_directed {
                let (direction, more) = base.unwrap_or_else(|| (layers::default_direction(normal), 0.0));
                let along = plus(direction, -retune::linalg::vector3::dot(direction, normal), normal);
                if unit(along).is_none_or(|_| retune::linalg::vector3::dot(along, along) < 1e-12) {
                    return Err(
                        importer.at_element(*at, "its ORIENTATION has the material's direction along the normal")
                    );
                }
                let own = if let Layers::One(_, angle) = &layer.material { *angle } else { 0.0 };
                let angle = angle_from_global(normal, direction) + more + own;
                values.push(("properties".to_string(), format!("{{angle: {} rad}}", computed(angle))));
            }
            importer.listed(*at, part, &values);
        }
        importer.differs(kind);
    }
    Ok(())
}
