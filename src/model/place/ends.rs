//! Properties of the ends of members: those of its first and its last element.

use super::{Entry, Placer};
use crate::element::Dof;
use crate::model::inside::stretch;
use crate::model::spec::ReleasesSpec;
use crate::model::value::Value;
use std::sync::Arc;

/// Which end of an element a property is of: `end1_compliance_ry` of the first.
fn side(property: &str) -> Option<usize> {
    ["end1_", "end2_"].iter().position(|prefix| property.starts_with(prefix))
}

impl Placer<'_> {
    /// Makes the ends of an entry pass on no force or moment in some directions: infinite compliances.
    pub(super) fn release(&mut self, entry: &mut Entry<'_>, releases: &ReleasesSpec, path: &str) {
        for (end, dofs) in [("end1", &releases.end1), ("end2", &releases.end2)] {
            for &dof in dofs {
                let dof = Dof::from(dof);
                let name = format!("{end}_compliance_{dof}");
                match entry.kind.properties().iter().position(|p| p.name == name) {
                    None => {
                        self.error(
                            format!("{path}.{end}"),
                            format_args!("a {} has no end that holds {dof}", entry.kind.name()),
                        );
                    }
                    Some(i) if entry.values[i].is_some() => {
                        self.error(
                            format!("{path}.{end}"),
                            format_args!("{dof} is released, and `{name}` is given too"),
                        );
                    }
                    Some(i) => Arc::make_mut(&mut entry.values)[i] = Some(Value::constant(f64::INFINITY)),
                }
            }
        }
    }

    /// Takes the properties of ends away from the elements of a member that are not at its ends.
    pub(super) fn keep_ends(&mut self, name: &str) {
        for stretch in self.stretches(name) {
            for &e in &stretch {
                let element = &mut self.elements[e];
                for (property, value) in element.kind.properties().iter().zip(Arc::make_mut(&mut element.values)) {
                    if side(property.name).is_some_and(|side| Self::end(&stretch, side) != Some(e)) {
                        *value = None;
                    }
                }
            }
        }
    }

    /// Which of the elements of some names a change of a property acts on: all, or those at the ends of the named members.
    ///
    /// * `elements` - all elements of the names
    pub(super) fn acted_on(&self, names: &[&str], elements: &[usize], property: &str) -> Vec<usize> {
        let Some(side) = side(property) else { return elements.to_vec() };
        let stretches = names.iter().flat_map(|name| self.stretches(name));
        let mut ends: Vec<usize> = stretches.filter_map(|stretch| Self::end(&stretch, side)).collect();
        ends.sort_unstable();
        ends.dedup();
        ends
    }

    /// The stretches of a member, a part or a group; each element for itself of anything else.
    pub(super) fn stretches(&self, name: &str) -> Vec<Vec<usize>> {
        let each = || self.sets.get(name).into_iter().flatten().map(|&e| vec![e]).collect();
        let inside = || stretch(&self.sets, &self.elements, name).map(|inside| vec![inside.to_vec()]);
        self.stretches.get(name).cloned().or_else(inside).unwrap_or_else(each)
    }

    fn end(stretch: &[usize], side: usize) -> Option<usize> {
        if side == 0 { stretch.first().copied() } else { stretch.last().copied() }
    }
}
