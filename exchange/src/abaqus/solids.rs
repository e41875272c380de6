//! Solids.

use super::importer::{Importer, Solver};
use super::kinds::Family;
use retune::deck::{DeckError, Keyword};

/// Writes the solids of a SOLID SECTION.
pub(super) fn section(
    importer: &mut Importer<'_>,
    k: &Keyword<'_>,
    instance: u32,
    elements: &[super::scopes::At],
) -> Result<(), DeckError> {
    if k.parameter("COMPOSITE").is_some() {
        return Err(k.error("laminated solids are not read; give one SOLID SECTION a layer of elements"));
    }
    let material = importer.material(k)?;
    let is_directed = material.elastic.is_some_and(|e| !e.is_isotropic());
    let orientation = match k.label("ORIENTATION").filter(|_| is_directed) {
        Some(name) => Some(importer.orientation(k, instance, &name)?),
        None => None,
    };
    if let Some(o) = orientation.as_ref().filter(|o| o.angle != 0.0 && o.axis != 3) {
        return Err(importer
            .deck
            .keyword(o.keyword)
            .error("an additional rotation of solids about axis 3 is read, about others not"));
    }
    for at in elements {
        let kind = importer.kind(*at);
        debug_assert!(kind.family == Family::Solid);
        // First-order elements of Abaqus have their mass at the nodes.
        let is_lumped = kind.is_first_order && importer.options.solver == Solver::Abaqus;
        let section = importer.section(k, if is_lumped { "solid_lumped" } else { "solid" }, |importer| {
            let mut values = Vec::new();
            importer.elastic(k, &material, false, &mut values)?;
            if is_lumped {
                values.push(("lumping".into(), "1".into()));
            }
            Ok(values)
        })?;
        let (element, order) = kind.becomes[0];
        let names = importer.node_names(*at);
        let nodes: Vec<&str> = order.iter().map(|i| names[*i].as_str()).collect();
        let mut values = vec![
            ("type".to_string(), element.to_string()),
            ("nodes".to_string(), format!("[{}]", nodes.join(", "))),
            ("section".to_string(), section),
        ];
        if let Some(o) = &orientation {
            let centre = importer.centre(*at);
            values.push(("frame".to_string(), importer.frame_at(o, centre)));
        }
        importer.differs(kind);
        importer.listed(*at, 0, &values);
    }
    Ok(())
}
