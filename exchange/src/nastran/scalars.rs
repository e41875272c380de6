//! Scalar points: coordinates without a place.
//!
//! One becomes a node that is a coordinate (`ux` alone, which no rigid motion moves), drawn where the first grid stands. A point that only
//! elements name exists by that, as for the solver; one that no element names is left out.

use super::importer::{Importer, Space};
use super::{CardRule, used};
use crate::system::Quantity;
use crate::text::{exact, with_unit};
use crate::writer::Block;
use retune::deck::{Card, DeckError};
use retune::element::Dof;

pub(super) const CARDS: &[CardRule] = &[used("SPOINT", "scalar points")];

/// One end of a scalar element or a term of a constraint: a node, and what moves there along global axes.
pub(super) struct End {
    pub node: String,
    /// The component from 0; of a scalar point its only one.
    pub component: usize,
    pub terms: Vec<(Dof, f64)>,
    /// The grid; none for a scalar point.
    pub grid: Option<super::importer::Grid>,
}

impl Importer<'_> {
    /// Notes the scalar points of a card, ahead of its turn.
    pub(super) fn expect_scalar_points(&mut self, card: &Card<'_>) -> Result<(), DeckError> {
        let ids = match card.name() {
            "SPOINT" => card.ids_from(2, "ID")?,
            // CELAS3, CELAS4, CMASS3, CMASS4: S1 and S2, zero for the ground.
            _ => [4, 5]
                .into_iter()
                .filter(|n| card.text(*n) != "0")
                .filter_map(|n| card.optional_id(n, "S").transpose())
                .collect::<Result<_, _>>()?,
        };
        self.scalars.extend(ids.into_iter().map(|id| (id, false)));
        Ok(())
    }

    /// Refuses numbers that a grid has too.
    pub(super) fn check_scalar_points(&self) -> Result<(), DeckError> {
        match self.scalars.keys().find_map(|id| self.find(Space::Grid, *id)) {
            Some(grid) => Err(grid.error(Some((2, "ID")), "a scalar point has this number too")),
            None => Ok(()),
        }
    }

    /// Whether a number is that of a scalar point.
    pub(super) fn is_scalar_point(&self, id: u32) -> bool {
        self.scalars.contains_key(&id)
    }

    /// The node of a scalar point, written when it is first named.
    pub(super) fn scalar_point(&mut self, id: u32) -> String {
        let name = format!("s{id}");
        if self.scalars.insert(id, true) != Some(true) {
            let unit = self.unit(Quantity::Length);
            let first = self.grids.iter().min_by_key(|g| g.0).map_or([0.0; 3], |g| g.1.position);
            let at = first.map(|x| with_unit(&exact(x), unit)).join(", ");
            self.out.node(&name, &format!("{{coordinate: [{at}]}}"), None, "scalar point");
        }
        name
    }

    /// An end in a field: a component of a grid, or a scalar point; none for the ground.
    ///
    /// * `component` - the field of the component; none where only scalar points may stand
    pub(super) fn end(
        &mut self,
        card: &Card<'_>,
        (field, component): (usize, Option<usize>),
        name: &'static str,
    ) -> Result<Option<End>, DeckError> {
        if matches!(card.text(field), "" | "0") {
            return Ok(None);
        }
        let id = card.id_at(field, name)?;
        if self.is_scalar_point(id) {
            if let Some(n) = component.filter(|n| !matches!(card.text(*n), "" | "0" | "1")) {
                return Err(card.error(Some((n, "C")), "a scalar point has no component; leave the field empty"));
            }
            return Ok(Some(End {
                node: self.scalar_point(id),
                component: 0,
                terms: vec![(Dof::Ux, 1.0)],
                grid: None,
            }));
        }
        let (node, grid) = self.grid_of(card, field, name, id)?;
        let Some(n) = component else {
            return Err(card.error(Some((field, name)), format_args!("a scalar point is expected, and {id} is a GRID")));
        };
        let flags = card.components(n, "C")?;
        let mut set = (0..6).filter(|c| flags[*c]);
        let (Some(component), None) = (set.next(), set.next()) else {
            return Err(card.error(Some((n, "C")), "one component, 1 to 6, is expected at a grid"));
        };
        Ok(Some(End { node, component, terms: self.component(&grid, component), grid: Some(grid) }))
    }

    /// Holds a scalar point.
    pub(super) fn hold_scalar_point(&mut self, name: &str, id: u32) {
        let node = self.scalar_point(id);
        let name = self.names.unique(&format!("{name}_{node}"));
        self.entry(Block::Supports, &name, &format!("{{node: {node}, fixed: [ux]}}"), "");
    }
}
