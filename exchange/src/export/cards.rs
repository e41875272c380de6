//! Wishes of elements for their fields become changes of fields, and copies of cards where elements disagree.

use super::Work;
use crate::imported::ElementOrigin;
use crate::system::Quantity as Q;
use retune::deck::{CardId, Changes, Deck};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::Path;

/// New values of one card, by field.
type Fields = Vec<(usize, &'static str, f64)>;

/// Values of an element by property.
type Named = Vec<(String, f64)>;

/// Whether a property can be written anew as a whole: PBAR and PBEAM by their rigidities, whatever shape gave them.
pub(super) fn can_rewrite(deck: &Deck, origin: &ElementOrigin, unbound: &[&str]) -> bool {
    let property = origin.property.map(|p| deck.name(p).to_string());
    let is_member = matches!(property.as_deref(), Some("PBAR" | "PBARL" | "PBEAM" | "PBEAML"));
    const HELD: [&str; 11] = [
        "A",
        "Iy",
        "Iz",
        "J",
        "added_mass_per_length",
        "kappa_y",
        "kappa_z",
        "shear_compliance_y",
        "shear_compliance_z",
        "E",
        "G",
    ];
    is_member && unbound.iter().all(|u| HELD.contains(u))
}

impl Work<'_> {
    /// Writes all wishes.
    pub(super) fn write(&mut self) {
        let wanted = std::mem::take(&mut self.wanted);
        // Card -> element -> its new fields.
        let mut by_card: BTreeMap<CardId, BTreeMap<String, Fields>> = BTreeMap::new();
        let mut is_changed: BTreeSet<CardId> = BTreeSet::new();
        for ((card, field), (name, wishes)) in wanted {
            for wish in wishes {
                if wish.is_new {
                    is_changed.insert(card);
                }
                by_card.entry(card).or_default().entry(wish.element).or_default().push((field, name, wish.value));
            }
        }
        let rewritten = std::mem::take(&mut self.rewritten);
        // Elements of a card that are not in the list want nothing else than it has.
        let mut groups: BTreeMap<CardId, Vec<(Fields, Vec<String>)>> = BTreeMap::new();
        for (card, elements) in by_card.into_iter().filter(|(c, _)| is_changed.contains(c)) {
            let mut classes: Vec<(Fields, Vec<String>)> = Vec::new();
            for (element, fields) in elements.into_iter().filter(|(e, _)| !rewritten.iter().any(|r| r.0 == *e)) {
                let same = |a: &Fields| {
                    a.len() == fields.len() && a.iter().zip(&fields).all(|(x, y)| x.0 == y.0 && near(x.2, y.2))
                };
                match classes.iter_mut().find(|c| same(&c.0)) {
                    Some(class) => class.1.push(element),
                    None => classes.push((fields, vec![element])),
                }
            }
            groups.insert(card, classes);
        }
        let mut moved: HashMap<String, Moves> = HashMap::new();
        for (card, mut classes) in groups {
            // Those that want what the card has keep it; else the largest class.
            let keeps = |c: &(Fields, Vec<String>)| c.0.iter().all(|(f, n, v)| near(self.has(card, *f, n), *v));
            classes.sort_by_key(|c| (!keeps(c), std::cmp::Reverse(c.1.len())));
            // Elements that are written anew keep their card as it is.
            let is_shared = rewritten.iter().any(|(e, _)| self.uses(e, card));
            for (i, (fields, elements)) in classes.into_iter().enumerate() {
                let changed: Fields = fields.into_iter().filter(|(f, n, v)| !near(self.has(card, *f, n), *v)).collect();
                if changed.is_empty() {
                    continue;
                }
                let is_own =
                    elements.len() == 1 && self.origins.elements.get(&elements[0]).and_then(|o| o.card) == Some(card);
                if (i == 0 && !is_shared) || is_own {
                    for (field, name, value) in changed {
                        self.put((card, field, name), value);
                    }
                    continue;
                }
                if elements.iter().any(|e| self.origins.elements.get(e).and_then(|o| o.card) == Some(card)) {
                    let names: Vec<&str> = changed.iter().map(|c| c.1).collect();
                    self.refuse(format!(
                        "{}: it shares its card with parts that want another {}",
                        elements.join(", "),
                        names.join(", ")
                    ));
                    continue;
                }
                let Some(number) = self.copy(card, &changed) else { continue };
                for element in elements {
                    moved.entry(element).or_default().insert(card, number);
                }
            }
        }
        self.refer(&moved);
        // Elements that want one section share its card.
        let mut sections: Vec<(Named, Vec<String>)> = Vec::new();
        for (element, values) in rewritten {
            let property = self.origins.elements.get(&element).and_then(|o| o.property);
            let same = |(own, users): &(Named, Vec<String>)| {
                let first = self.origins.elements.get(&users[0]).and_then(|o| o.property);
                first == property
                    && own.len() == values.len()
                    && own.iter().zip(&values).all(|(a, b)| a.0 == b.0 && near(a.1, b.1))
            };
            match sections.iter_mut().find(|s| same(s)) {
                Some(section) => section.1.push(element),
                None => sections.push((values, vec![element])),
            }
        }
        for (values, elements) in sections {
            self.rewrite(&elements, &values);
        }
    }

    /// The number in a field; none where the field holds the number of a coordinate system instead of an angle.
    fn has(&self, card: CardId, field: usize, name: &'static str) -> f64 {
        let read = self.deck.card(card);
        let is_other = name == "THETA" && !read.is_blank(field) && !read.text(field).contains('.');
        if is_other { f64::NAN } else { read.real_or(field, name, 0.0).unwrap_or(f64::NAN) }
    }

    fn uses(&self, element: &str, card: CardId) -> bool {
        let Some(origin) = self.origins.elements.get(element) else { return false };
        let section = origin.section.as_ref().and_then(|s| self.origins.sections.get(s));
        origin.property == Some(card)
            || origin.bounds.iter().chain(section.into_iter().flatten()).any(|b| b.card == card)
    }

    /// A copy of a card with a new number and new values, added; the number.
    fn copy(&mut self, card: CardId, fields: &Fields) -> Option<u32> {
        let number = self.number();
        let lines = self.copied(card, number, fields, &[])?;
        let read = self.deck.card(card);
        self.told.push(format!("added: {} {number}, a copy of {} {}", read.name(), read.name(), read.text(2)));
        self.changes.add(lines);
        Some(number)
    }

    /// Lines of a copy: the text of the card with a new number, values and materials by field.
    fn copied(
        &mut self,
        card: CardId,
        number: u32,
        fields: &Fields,
        materials: &[(usize, u32)],
    ) -> Option<Vec<String>> {
        let text = self.deck.text_of(card);
        let own = Deck::read(Path::new("copy"), &mut |_| Ok(text.clone().into_bytes()));
        let Ok(own) = own else { return None };
        let id = own.cards().next()?;
        let mut changes = Changes::default();
        let mut done = changes.integer(&own, (id, 2, "ID"), number);
        for &(field, material) in materials {
            done = done.and_then(|()| changes.integer(&own, (id, field, "MID"), material));
        }
        for &(field, name, value) in fields {
            match changes.real(&own, (id, field, name), value) {
                Ok(text) => self.rounded(value, &text),
                Err(e) => done = Err(e),
            }
        }
        if let Err(e) = done {
            self.refuse(self.deck.error(card, e.field, e.message).to_string());
            return None;
        }
        Some(changes.apply(&own, "").remove(0).lines().map(str::to_string).collect())
    }

    /// Elements refer to copies: a property that was copied, or a copy of a property because its material was.
    fn refer(&mut self, moved: &HashMap<String, Moves>) {
        // Property, copy of the property, its fields of materials that were copied -> elements.
        type Chain = (CardId, Option<u32>, Vec<(usize, u32)>);
        let mut chains: BTreeMap<Chain, Vec<String>> = BTreeMap::new();
        let mut names: Vec<String> = moved.keys().cloned().collect();
        names.sort();
        for element in names {
            let Some(property) = self.origins.elements.get(&element).and_then(|o| o.property) else {
                self.refuse(format!("{element}: its card is shared with elements that want another value, and it has no property to change"));
                continue;
            };
            let to = &moved[&element];
            let own = to.get(&property).copied();
            let copied = to.iter().filter(|(card, _)| **card != property);
            let fields =
                copied.flat_map(|(card, n)| self.fields_of_material(property, *card).into_iter().map(|f| (f, *n)));
            let materials = fields.collect();
            chains.entry((property, own, materials)).or_default().push(element);
        }
        let mut all: BTreeMap<CardId, usize> = BTreeMap::new();
        let mut properties: Vec<CardId> = self.origins.elements.values().filter_map(|o| o.property).collect();
        properties.sort_unstable();
        for property in properties {
            *all.entry(property).or_default() += 1;
        }
        for ((property, own, materials), elements) in chains {
            let target = match own {
                Some(number) if materials.is_empty() => Some(number),
                Some(_) => {
                    self.refuse(format!("{}: property and material of some of its elements change at once; give them a property of their own in the deck", self.deck.error(property, None, "it")));
                    continue;
                }
                None if materials.is_empty() => None,
                // All elements of the property: it refers to the new material itself.
                None if all.get(&property) == Some(&elements.len()) => {
                    for (field, material) in materials {
                        match self.changes.integer(self.deck, (property, field, "MID"), material) {
                            Ok(()) => {
                                let read = self.deck.card(property);
                                let (file, line) = read.place();
                                let (name, id, old) = (read.name(), read.text(2), read.text(field));
                                let which = match (name, field) {
                                    ("PSHELL", 3) => "MID1",
                                    ("PSHELL", 5) => "MID2",
                                    ("PSHELL", 7) => "MID3",
                                    ("PSHELL", _) => "MID4",
                                    _ => "MID",
                                };
                                self.told.push(format!("{file}:{line}: {name} {id}, {which}: {old} -> {material}"));
                            }
                            Err(e) => self.refuse(e.to_string()),
                        }
                    }
                    None
                }
                None => {
                    let number = self.number();
                    let Some(lines) = self.copied(property, number, &Vec::new(), &materials) else { continue };
                    self.changes.add(lines);
                    let shown: Vec<String> = materials.iter().map(|m| m.1.to_string()).collect();
                    self.told.push(format!(
                        "added: {} {number}, a copy with material {}",
                        self.deck.name(property),
                        shown.join(", ")
                    ));
                    Some(number)
                }
            };
            if let Some(number) = target {
                self.point(&elements, number);
            }
        }
    }

    /// The fields of a property that name a material.
    fn fields_of_material(&self, property: CardId, material: CardId) -> Vec<usize> {
        let read = self.deck.card(property);
        let mid = self.deck.card(material).text(2).to_string();
        let all: Vec<usize> = match read.name() {
            "PSHELL" => vec![3, 5, 7, 12],
            "PCOMP" => (10..=read.len()).step_by(4).collect(),
            "PCOMPG" => (11..=read.len()).step_by(8).collect(),
            _ => return vec![3],
        };
        all.into_iter().filter(|f| read.text(*f) == mid).collect()
    }

    /// Writes the number of a property onto elements.
    fn point(&mut self, elements: &[String], number: u32) {
        for element in elements {
            let Some(card) = self.origins.elements.get(element).and_then(|o| o.card) else { continue };
            match self.changes.integer(self.deck, (card, 3, "PID"), number) {
                Ok(()) => {
                    let (file, line) = self.deck.card(card).place();
                    self.told.push(format!("{file}:{line}: {element}, PID: -> {number}"));
                }
                Err(e) => self.refuse(e.to_string()),
            }
        }
    }

    /// A property of a member written anew: PBAR for bars, PBEAM for beams, and a material where E or G changed.
    fn rewrite(&mut self, elements: &[String], values: &[(String, f64)]) {
        let element = &elements[0];
        let Some(origin) = self.origins.elements.get(element) else { return };
        let (Some(property), Some(card)) = (origin.property, origin.card) else { return };
        let value = |name: &str| values.iter().find(|v| v.0 == name).map(|v| v.1);
        let unit = |q: Q| self.system.factor(q);
        let (area, i1, i2, j) = (value("A"), value("Iz"), value("Iy"), value("J"));
        let numbers = [
            area.unwrap_or(0.0) / unit(Q::Area),
            i1.unwrap_or(0.0) / unit(Q::SecondMoment),
            i2.unwrap_or(0.0) / unit(Q::SecondMoment),
            j.unwrap_or(0.0) / unit(Q::SecondMoment),
            value("added_mass_per_length").unwrap_or(0.0) / (unit(Q::MassPerLength) * self.origins.wtmass),
        ];
        let (e, nu) = (value("E").unwrap_or(0.0), value("nu"));
        let g = value("G").or(nu.map(|nu| e / (2.0 * (1.0 + nu)))).unwrap_or(0.0);
        // The shear factor of the deck is 1/(c G A).
        let factor = |kappa: Option<f64>, compliance: Option<f64>| match (kappa, compliance) {
            (Some(k), _) => Some(k),
            (None, Some(c)) if c > 0.0 => Some(1.0 / (c * g * area.unwrap_or(0.0))),
            _ => None,
        };
        let shear = [
            factor(value("kappa_y"), value("shear_compliance_y")),
            factor(value("kappa_z"), value("shear_compliance_z")),
        ];
        let material_of = self.deck.card(property).text(3).to_string();
        let section = origin.section.as_ref().and_then(|s| self.origins.sections.get(s));
        let held = |name: &str| section.into_iter().flatten().find(|b| b.property == name);
        let modulus = |name: &str, v: f64| {
            held(name)
                .is_none_or(|b| near(self.deck.card(b.card).real_or(b.field, b.name, 0.0).unwrap_or(0.0), v / b.factor))
        };
        if !(modulus("E", e) && (held("G").is_none() || modulus("G", g))) {
            self.refuse(format!("{element}: E or G changes together with its section; give it a property and a material of its own in the deck"));
            return;
        }
        let number = self.number();
        let is_beam = self.deck.name(card) == "CBEAM";
        let mut fields: Vec<String> = vec![number.to_string(), material_of];
        let real = |work: &mut Self, v: f64| {
            let text = retune::deck::real_in(v, 16);
            work.rounded(v, &text);
            text
        };
        let [a, i1, i2, j, nsm] = numbers;
        let lines = if is_beam {
            fields.extend([a, i1, i2, 0.0, j, nsm].map(|v| real(self, v)));
            fields.extend(std::iter::repeat_n(String::new(), 8));
            // Without a factor the solver takes one; zero means no shear flexibility.
            for k in shear {
                fields.push(real(self, k.unwrap_or(0.0)));
            }
            added_card("PBEAM", &fields)
        } else {
            fields.extend([a, i1, i2, j, nsm].map(|v| real(self, v)));
            fields.extend(std::iter::repeat_n(String::new(), 9));
            for k in shear {
                fields.push(k.map_or_else(String::new, |k| real(self, k)));
            }
            added_card("PBAR", &fields)
        };
        self.told.push(format!(
            "added: {} {number} for {}",
            if is_beam { "PBEAM" } else { "PBAR" },
            elements.join(", ")
        ));
        self.changes.add(lines);
        self.point(elements, number);
    }
}

/// Copies to which an element moves, by the card that was copied.
type Moves = BTreeMap<CardId, u32>;

/// Values of a model file that were computed have twelve digits.
fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-11 * a.abs().max(b.abs())
}

/// A card in large field: four fields of sixteen columns a line.
pub(super) fn added_card(name: &str, fields: &[String]) -> Vec<String> {
    let used = fields.iter().rposition(|f| !f.is_empty()).map_or(0, |i| i + 1);
    let mut lines = Vec::new();
    for (i, four) in fields[..used].chunks(4).enumerate() {
        let head = if i == 0 { format!("{name}*") } else { "*".to_string() };
        let line = four.iter().fold(format!("{head:<8}"), |line, field| format!("{line}{field:<16}"));
        lines.push(line.trim_end().to_string());
    }
    lines
}
