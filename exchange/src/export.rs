//! What was learnt, back into the deck: the fields whose values changed, and nothing else.
//!
//! Not the text of the model file is compared but the models: the deck is imported once more, and every element of the updated model is
//! held against its own as it was, so that it does not matter by which parameters, overrides or effects a value came about. A value has
//! its field on the card of the element, of its property or of its material. Where a card serves elements that no longer agree, a copy
//! with a new number is added and those that changed refer to it. What was added to the model becomes cards in one block; what has no card
//! is refused by name.

mod added;
mod cards;
mod held;
mod keyed;

pub use keyed::export_keywords;

use super::imported::{Bound, ImportOptions, Imported, Origins, Solver};
use super::nastran::import;
use super::system::{Quantity, System, system_by_name};
use retune::catalogue::counted;
use retune::deck::{CardId, Changes, Deck, DeckError};
use retune::linalg::vector3::{dot, plus};
use retune::model::{Model, ParametricModel, PlacedElement, Registry};
use std::collections::{BTreeMap, HashMap};

/// A deck with what was learnt in it.
#[derive(Debug, Clone)]
pub struct Exported {
    /// The text of every file of the deck, in the order of [`Deck::sources`].
    pub files: Vec<String>,
    /// What changed, one line each: card, field, old and new value.
    pub changes: Vec<String>,
    /// Cards that were added.
    pub added: Vec<String>,
    /// Largest relative difference between a value of the model and the digits that its field holds.
    pub rounding: f64,
}

/// Why a model has no deck.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The model was not imported.
    #[error(
        "the model file has no `imported` block: it was not made by `retune import`, so nothing says which card a value belongs to"
    )]
    NotImported,
    /// The deck does not give the model that it was imported as.
    #[error("the deck gives no model any more: {0}")]
    Deck(DeckError),
    /// The imported text is not a model.
    #[error("the deck gives a model with mistakes: {0}")]
    Model(String),
    /// What has no card, each with the reason.
    #[error("{}", .0.join("\n"))]
    Refused(Vec<String>),
}

/// A heading above the cards that are added.
pub(super) const HEADING: &str = "$ --- added by retune ---";

/// Writes the values of an updated model into the deck that it was imported from.
///
/// # Errors
/// A model of another origin; changes that no card can hold, all of them by name.
pub fn export(deck: &Deck, updated: &Model) -> Result<Exported, ExportError> {
    let spec = updated.spec();
    let imported = spec.imported.as_ref().ok_or(ExportError::NotImported)?;
    let system = system_by_name(&imported.units).ok_or_else(|| {
        ExportError::Refused(vec![format!("imported.units: `{}` is not a system of units", imported.units)])
    })?;
    let options = ImportOptions::again(imported, system, Solver::default());
    let (base, before) = model_of(deck, options)?;
    let mut work = Work {
        deck,
        system,
        origins: &before.origins,
        next: before.origins.largest,
        changes: Changes::default(),
        told: Vec::new(),
        refused: Vec::new(),
        wanted: BTreeMap::new(),
        rewritten: Vec::new(),
        rounding: 0.0,
    };
    work.refused = held::structure(base.spec(), spec);
    work.variables(&base, updated);
    work.elements(&base, updated);
    work.write();
    added::write(&mut work, &base, updated);
    if !work.refused.is_empty() {
        return Err(ExportError::Refused(work.refused));
    }
    let files = work.changes.apply(deck, HEADING);
    Ok(Exported { files, changes: work.told, added: work.changes.added().to_vec(), rounding: work.rounding })
}

fn model_of(deck: &Deck, options: ImportOptions) -> Result<(Model, Imported), ExportError> {
    let imported = import(deck, options).map_err(|e| ExportError::Deck(e[0].clone()))?;
    match imported.load(&Registry::builtin()) {
        Ok((model, ..)) => Ok((model, imported)),
        Err(problems) => Err(ExportError::Model(problems.first().map_or_else(String::new, |p| p.message.clone()))),
    }
}

/// What an element wants of the fields that it depends on.
#[derive(Debug, Clone)]
pub(super) struct Wish {
    pub element: String,
    /// Value in the deck's unit; the old one where it did not change.
    pub value: f64,
    pub is_new: bool,
}

pub(super) struct Work<'a> {
    pub deck: &'a Deck,
    pub system: &'static System,
    pub origins: &'a Origins,
    /// The largest number of the deck.
    pub next: u32,
    pub changes: Changes,
    pub told: Vec<String>,
    pub refused: Vec<String>,
    /// Card and field -> what its elements want.
    pub wanted: BTreeMap<(CardId, usize), (&'static str, Vec<Wish>)>,
    /// Elements whose whole property is written anew, with their new values.
    pub rewritten: Vec<(String, Vec<(String, f64)>)>,
    pub rounding: f64,
}

impl Work<'_> {
    fn refuse(&mut self, what: String) {
        if !self.refused.contains(&what) {
            self.refused.push(what);
        }
    }

    fn elements(&mut self, base: &Model, updated: &Model) {
        let (theta0, theta) = (base.parameters().nominal(), updated.parameters().nominal());
        let now: HashMap<&str, &PlacedElement> = updated.elements().iter().map(|e| (e.name.as_str(), e)).collect();
        let size = base.geometry().size();
        for (i, name) in base.geometry().names.iter().enumerate() {
            let old = base.geometry().positions[i];
            match updated.geometry().node(name).map(|n| updated.geometry().positions[n]) {
                None => self.refuse(format!("nodes.{name}: it was taken out, and export does not delete cards")),
                Some(new) if (0..3).any(|k| (new[k] - old[k]).abs() > 1e-10 * size) => self.moved(name, new),
                Some(_) => {}
            }
        }
        for element in base.elements() {
            let Some(new) = now.get(element.name.as_str()) else {
                self.refuse(format!("{}: it was taken out or divided, and export does not delete cards", element.path));
                continue;
            };
            let turn = held::turned(element, new);
            if let Some(why) = held::is_other(base, updated, element, new, turn.is_some()) {
                self.refuse(why);
                continue;
            }
            if held::is_damped(new) {
                self.refuse(format!("{}: damping of an element has no field on its cards", new.path));
            }
            if let Some(turn) = turn {
                self.turn(element, turn);
            }
            self.values((base, element), (updated, new), [&theta0, &theta]);
        }
    }

    /// A bar that was turned about its own axis gets another vector in its first plane, in the place of a grid where it had one.
    fn turn(&mut self, element: &PlacedElement, turn: f64) {
        let refuse = |work: &mut Self, why: &str| {
            work.refuse(format!("{}: it was turned about itself, and {why}", element.path));
        };
        let Some(origin) = self.origins.elements.get(&element.name) else { return };
        let (Some(card), Some(plane)) = (origin.card, &origin.plane) else {
            return refuse(self, "its card has no vector for that");
        };
        if plane.turns_offsets {
            return refuse(self, "its offsets stand in its own axes (OFFT), which would turn them; edit the card");
        }
        let (sin, cos) = turn.sin_cos();
        let [_, y, z] = plane.axes;
        let toward = plus(y.map(|v| v * cos), sin, z);
        for (k, name) in ["X1", "X2", "X3"].into_iter().enumerate() {
            let component = dot(plane.of_vector[k], toward);
            // What rounding leaves of a right angle.
            self.put((card, 6 + k, name), if component.abs() < 1e-15 { 0.0 } else { component });
        }
    }

    /// Design variables of the deck take the values of their parameters.
    fn variables(&mut self, base: &Model, updated: &Model) {
        let mut names: Vec<(&String, CardId)> = self.origins.variables.iter().map(|(n, c)| (n, *c)).collect();
        names.sort_by_key(|n| n.1);
        for (name, card) in names {
            let of = |m: &Model| m.parameters().index_of(name).map(|i| m.parameters().nominal()[i]);
            match (of(base), of(updated)) {
                (Some(old), Some(new)) if (old - new).abs() > held::SAME * old.abs().max(new.abs()) => {
                    self.put((card, 4, "XINIT"), new);
                }
                (Some(_), None) => {
                    self.refuse(format!("parameters.{name}: it was taken out, and the deck's design variable stays"));
                }
                _ => {}
            }
        }
    }

    fn moved(&mut self, name: &str, position: [f64; 3]) {
        let Some(&card) = self.origins.grids.get(name) else { return };
        let read = self.deck.card(card);
        if !matches!(read.text(3), "" | "0") {
            self.refuse(format!(
                "nodes.{name}: it moved, and its GRID stands in a coordinate system of its own; edit the card"
            ));
            return;
        }
        let metre = self.system.factor(Quantity::Length);
        for (k, label) in ["X1", "X2", "X3"].into_iter().enumerate() {
            let value = position[k] / metre;
            let old = read.real_or(4 + k, label, 0.0).unwrap_or(0.0);
            if (value - old).abs() > 1e-10 * (value.abs() + old.abs()) {
                self.put((card, 4 + k, label), value);
            }
        }
    }

    /// The new values of one element, with the factors on its whole stiffness and mass in them.
    fn values(
        &mut self,
        (base, old): (&Model, &PlacedElement),
        (updated, new): (&Model, &PlacedElement),
        [theta0, theta]: [&[f64]; 2],
    ) {
        let properties = old.kind.properties();
        let wanted = held::wanted(old, new, theta0, theta);
        let plies = match held::plies((base, old), (updated, new)) {
            Ok(plies) => plies,
            Err(why) => {
                self.refuse(why);
                return;
            }
        };
        let Some(origin) = self.origins.elements.get(&old.name) else {
            self.refuse(format!("{}: nothing says which card it comes from", new.path));
            return;
        };
        // Each value by its name, as it was and as it should be.
        let of_shell = |name: &str| plies.is_some() && held::is_of_plies(name);
        let mut all: Vec<(&str, Option<f64>, Option<f64>)> =
            wanted.iter().map(|w| (properties[w.0].name, w.1, w.2)).filter(|w| !of_shell(w.0)).collect();
        if let (Some(plies), Some(property)) = (&plies, origin.property) {
            let grown: f64 = plies.iter().filter(|p| p.0.ends_with(".thickness")).map(|p| p.2 - p.1).sum();
            self.offset(property, grown, &mut all, &old.name);
            all.extend(plies.iter().map(|(name, before, after)| (name.as_str(), Some(*before), Some(*after))));
        }
        let section = origin.section.as_ref().and_then(|s| self.origins.sections.get(s));
        let bounds: Vec<&Bound> = origin.bounds.iter().chain(section.into_iter().flatten()).collect();
        let bound_of = |name: &str| bounds.iter().find(|b| b.property == name).copied().filter(|b| b.field > 0);
        let is_changed = |w: &(&str, Option<f64>, Option<f64>)| !held::is_same(w.1, w.2);
        let changed: Vec<&str> = all.iter().filter(|w| is_changed(w)).map(|w| w.0).collect();
        // A Poisson's ratio that gives G stands for it: E alone carries a factor.
        let unbound: Vec<&str> = changed.iter().copied().filter(|name| bound_of(name).is_none()).collect();
        if !unbound.is_empty() {
            let whole: Vec<(String, f64)> = all.iter().filter_map(|w| w.2.map(|v| (w.0.to_string(), v))).collect();
            if cards::can_rewrite(self.deck, origin, &unbound) {
                self.rewritten.push((old.name.clone(), whole));
            } else {
                self.refuse(format!(
                    "{}: `{}` has no field on the cards of {}",
                    new.path,
                    unbound.join("`, `"),
                    old.name
                ));
            }
            return;
        }
        for (name, before, after) in &all {
            let Some(bound) = bound_of(name) else { continue };
            let is_new = changed.contains(name);
            let value = if is_new { after.unwrap_or(0.0) } else { before.unwrap_or(0.0) };
            let value = (value - bound.shift) / bound.factor;
            let wish = Wish { element: old.name.clone(), value, is_new };
            self.wanted.entry((bound.card, bound.field)).or_insert((bound.name, Vec::new())).1.push(wish);
        }
    }

    /// The offset of a laminate follows from the field of its lower side, Z0, and half of its thickness.
    ///
    /// * `grown` - by how much the plies that are given are thicker together, m
    fn offset(&mut self, property: CardId, grown: f64, all: &mut Vec<(&str, Option<f64>, Option<f64>)>, element: &str) {
        let Some(at) = all.iter().position(|w| w.0 == "offset") else { return };
        let (_, before, after) = all.remove(at);
        let card = self.deck.card(property);
        let metre = self.system.factor(Quantity::Length);
        let (before, after) = (before.unwrap_or(0.0), after.unwrap_or(0.0));
        let twice = if card.text(9).eq_ignore_ascii_case("SYM") { 2.0 } else { 1.0 };
        let z0 = card.optional_real(3, "Z0").ok().flatten();
        // An empty field is half of the thickness, whatever that is.
        let moved = after - before - z0.map_or(0.0, |_| 0.5 * twice * grown);
        let size = before.abs().max(after.abs()).max(grown.abs());
        if moved.abs() <= 1e-11 * size && !grown.is_nan() {
            return;
        }
        if let Some(z0) = z0 {
            let wish = Wish { element: element.to_string(), value: z0 + moved / metre, is_new: true };
            self.wanted.entry((property, 3)).or_insert(("Z0", Vec::new())).1.push(wish);
        } else {
            all.push(("offset", Some(before), Some(after)));
        }
    }

    /// Writes a number into a field and tells of it.
    pub(super) fn put(&mut self, (card, field, name): (CardId, usize, &'static str), value: f64) {
        let read = self.deck.card(card);
        let old = read.text(field).to_string();
        match self.changes.real(self.deck, (card, field, name), value) {
            Ok(text) => {
                self.rounded(value, &text);
                let (file, line) = read.place();
                let old = if old.is_empty() { "empty".to_string() } else { old };
                self.told.push(format!("{file}:{line}: {} {}, {name}: {old} -> {text}", read.name(), read.text(2)));
            }
            Err(e) => self.refuse(e.to_string()),
        }
    }

    pub(super) fn rounded(&mut self, value: f64, text: &str) {
        let written = retune::deck::parse_real(text).unwrap_or(0.0);
        if value != 0.0 {
            self.rounding = self.rounding.max((written / value - 1.0).abs());
        }
    }

    pub(super) fn number(&mut self) -> u32 {
        self.next += 1;
        self.next
    }
}

impl Exported {
    /// One line of what was done.
    pub fn summary(&self) -> String {
        let changes = counted(self.changes.len(), "change");
        if self.added.is_empty() {
            return changes;
        }
        // Lines of cards go on behind a star, and keywords begin with one.
        let is_keyed = self.added.iter().any(|l| l.starts_with("**"));
        let begins = |l: &&String| {
            if is_keyed { l.starts_with('*') && !l.starts_with("**") } else { !l.starts_with(['*', '$']) }
        };
        let count = self.added.iter().filter(begins).count();
        format!("{changes}, {} added", counted(count, if is_keyed { "keyword" } else { "card" }))
    }
}
