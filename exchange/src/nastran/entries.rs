//! What every family asks of the import: cards by number, numbers with units, entries of the model file.

use super::importer::{Grid, Importer, Space, Values, node};
use crate::imported::{Bound, ElementOrigin};
use crate::names::slug;
use crate::system::Quantity;
use crate::text::{computed, exact, map, with_unit};
use crate::writer::Block;
use retune::deck::{Card, DeckError};

impl<'a> Importer<'a> {
    /// A grid point that a field names.
    pub(super) fn grid(&self, card: &Card<'_>, field: usize, name: &'static str) -> Result<(String, Grid), DeckError> {
        let id = card.id_at(field, name)?;
        self.grid_of(card, field, name, id)
    }

    /// A grid point by its number.
    pub(super) fn grid_of(
        &self,
        card: &Card<'_>,
        field: usize,
        name: &'static str,
        id: u32,
    ) -> Result<(String, Grid), DeckError> {
        let found = self
            .grids
            .get(&id)
            .ok_or_else(|| card.error(Some((field, name)), format_args!("there is no GRID {id}")))?;
        Ok((node(id), *found))
    }

    pub(super) fn known_grid(&self, id: u32) -> Option<&Grid> {
        self.grids.get(&id)
    }

    pub(super) fn add_grid(&mut self, id: u32, grid: Grid) {
        self.grids.insert(id, grid);
    }

    /// A card that a field names by its number.
    pub(super) fn find(&self, space: Space, id: u32) -> Option<Card<'a>> {
        self.index.get(&(space, id)).map(|c| self.deck.card(*c))
    }

    /// The property of an element.
    pub(super) fn property(&self, card: &Card<'_>, field: usize, allowed: &[&str]) -> Result<Card<'a>, DeckError> {
        // A field that is empty means the number of the element.
        let id = card.optional_id(field, "PID")?.map_or_else(|| card.id_at(2, "EID"), Ok)?;
        let at = Some((field, "PID"));
        let of_kind = allowed.iter().filter_map(|name| Space::of_property(name)).find_map(|space| self.find(space, id));
        // What is of the wrong kind is told as such.
        let any = || {
            let others = self.index.iter().filter(|(key, _)| key.1 == id && matches!(key.0, Space::Property(_)));
            others.map(|(_, card)| *card).min().map(|card| self.deck.card(card))
        };
        let property = of_kind.or_else(any);
        let property = property.ok_or_else(|| card.error(at, format_args!("there is no property {id}")))?;
        if !allowed.contains(&property.name()) {
            let (file, line) = property.place();
            let text = format!(
                "property {id} is a {} ({file}:{line}), and {} is expected",
                property.name(),
                allowed.join(" or ")
            );
            return Err(card.error(at, text));
        }
        Ok(property)
    }

    /// The material that a property names.
    pub(super) fn material(&self, card: &Card<'_>, field: usize, allowed: &[&str]) -> Result<Card<'a>, DeckError> {
        let id = card.id_at(field, "MID")?;
        let at = Some((field, "MID"));
        let found =
            self.find(Space::Material, id).ok_or_else(|| card.error(at, format_args!("there is no material {id}")))?;
        if !allowed.contains(&found.name()) {
            let text = format!("material {id} is a {}, and {} is expected", found.name(), allowed.join(" or "));
            return Err(card.error(at, text));
        }
        Ok(found)
    }

    /// Unit of a quantity.
    pub(super) fn unit(&self, quantity: Quantity) -> &'static str {
        self.options.system.unit(quantity)
    }

    /// A number of the deck with its unit, or the design variables that it follows.
    pub(super) fn scalar(
        &self,
        card: &Card<'_>,
        field: usize,
        value: f64,
        (quantity, scale): (Quantity, f64),
    ) -> String {
        let unit = self.unit(quantity);
        if let Some(text) = self.design.expression(card.id(), field, unit, scale) {
            return text;
        }
        let number = if scale == 1.0 { exact(value) } else { computed(value * scale) };
        with_unit(&number, unit)
    }

    /// Whether a field follows design variables.
    pub(super) fn is_designed(&self, card: &Card<'_>, field: usize) -> bool {
        self.design.relations.contains_key(&(card.id(), field))
    }

    /// A sum of fields with factors, with its unit; with the design variables that some of them follow.
    pub(super) fn sum(&self, parts: &[((&Card<'_>, usize), f64, f64)], quantity: Quantity) -> String {
        let unit = self.unit(quantity);
        let mut constant = 0.0;
        let mut terms = String::new();
        for ((card, field), value, scale) in parts {
            match self.design.expression(card.id(), *field, unit, *scale) {
                Some(text) if text.starts_with('-') => terms.push_str(&format!(" - {}", &text[1..])),
                Some(text) => terms.push_str(&format!(" + {text}")),
                None => constant += value * scale,
            }
        }
        with_unit(&computed(constant), unit) + &terms
    }

    /// A computed length, with its unit.
    pub(super) fn length(&self, value: f64) -> String {
        with_unit(&computed(value), self.unit(Quantity::Length))
    }

    /// A vector of lengths.
    pub(super) fn lengths(&self, v: [f64; 3]) -> String {
        format!("[{}]", v.map(|x| self.length(x)).join(", "))
    }

    /// Puts a field of a card under a property of an element.
    pub(super) fn put(
        &self,
        values: &mut Values,
        (key, property): (&str, &str),
        (card, field, name): (&Card<'_>, usize, &'static str),
        value: f64,
        (quantity, scale): (Quantity, f64),
    ) {
        values.items.push((key.to_string(), self.scalar(card, field, value, (quantity, scale))));
        let factor = self.options.system.factor(quantity) * scale;
        values.bounds.push(Bound { property: property.to_string(), card: card.id(), field, name, factor, shift: 0.0 });
    }

    /// Writes an entry below the comments that stand above its card.
    pub(super) fn entry(&mut self, block: Block, name: &str, value: &str, remark: &str) {
        self.comments(block);
        self.out.entry(block, name, value, remark);
    }

    /// Puts the comments of the deck above the next entry of a block.
    pub(super) fn comments(&mut self, block: Block) {
        for comment in std::mem::take(&mut self.pending) {
            self.out.comment(block, &comment);
        }
    }

    /// Writes an element with its number, which no other element may have, into the groups of its property and its heading.
    pub(super) fn element(
        &mut self,
        block: Block,
        card: &Card<'a>,
        values: Values,
        property: Option<&Card<'a>>,
        section: Option<&str>,
    ) -> Result<String, DeckError> {
        self.part(block, card, values, (property, section), None)
    }

    /// The same of one of several elements that a card becomes, counted from 0.
    pub(super) fn part(
        &mut self,
        block: Block,
        card: &Card<'a>,
        values: Values,
        (property, section): (Option<&Card<'a>>, Option<&str>),
        part: Option<usize>,
    ) -> Result<String, DeckError> {
        let eid = card.id_at(2, "EID")?;
        if let Some(first) = self.elements.insert(eid, card.id()).filter(|first| *first != card.id()) {
            let first = self.deck.card(first);
            let (file, line) = first.place();
            let text = format!("the number {eid} is already used at {file}:{line}, {}", first.name());
            return Err(card.error(Some((2, "EID")), text));
        }
        self.origins.largest = self.origins.largest.max(eid);
        let of = part.map_or_else(String::new, |part| format!("_{}", part + 1));
        let name = self.names.unique(&format!("{}_{eid}{of}", card.name().to_lowercase()));
        self.comments(block);
        self.out.element(block, &name, &values.items);
        if let Some(property) = property {
            let pid = property.id_at(2, "PID").unwrap_or(0);
            let group = self.property_group(property, pid);
            self.join(&group, true, &name);
        }
        if let Some(heading) = self.heading.clone() {
            self.join(&heading, false, &name);
        }
        let origin = ElementOrigin {
            card: Some(card.id()),
            property: property.map(Card::id),
            section: section.map(str::to_string),
            bounds: values.bounds,
            plane: values.plane,
        };
        self.origins.elements.insert(name.clone(), origin);
        Ok(name)
    }

    fn property_group(&self, property: &Card<'_>, pid: u32) -> String {
        let plain = format!("{}_{pid}", property.name().to_lowercase());
        self.named.get(&pid).and_then(|n| slug(n)).map_or(plain.clone(), |n| format!("{n}_{pid}"))
    }

    fn join(&mut self, group: &str, is_property: bool, element: &str) {
        let key = if is_property { format!("property {group}") } else { format!("heading {group}") };
        let at = match self.group_at.get(&key) {
            Some(at) => *at,
            None => {
                let at = self.groups.len();
                let name = self.names.unique(group);
                if is_property && name != group {
                    self.group_at.insert(format!("property {name}"), at);
                }
                self.groups.insert(at, (name, Vec::new()));
                self.group_at.insert(key, at);
                at
            }
        };
        if let Some(group) = self.groups.get_mut(&at) {
            group.1.push(element.to_string());
        }
    }

    /// The section of a property for a kind of element, made when it is first asked for.
    pub(super) fn section(
        &mut self,
        property: &Card<'a>,
        kind: &'static str,
        make: impl FnOnce(&mut Self) -> Result<Values, DeckError>,
    ) -> Result<String, DeckError> {
        let pid = property.id_at(2, "PID")?;
        if let Some(name) = self.sections.get(&(pid, kind)) {
            return Ok(name.clone());
        }
        let values = make(self)?;
        let plain = format!("{}_{pid}", property.name().to_lowercase());
        // One property may serve two kinds of elements.
        let is_second = self.sections.keys().any(|k| k.0 == pid);
        let name = if is_second { format!("{plain}_{kind}") } else { plain };
        let remark = self.named.get(&pid).cloned().unwrap_or_default();
        self.out.entry(Block::Sections, &name, &map(&values.items), &remark);
        self.origins.sections.insert(name.clone(), values.bounds);
        self.sections.insert((pid, kind), name.clone());
        Ok(name)
    }
}
