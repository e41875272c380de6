//! What was learnt, back into a deck of keywords.
//!
//! As with cards the deck is imported once more and each element of the updated model is held against its own. A value goes into the item of
//! the data line that it was read from. Sections that share a material and no longer agree get one of their own, a copy with a new name. The
//! deck that comes of it is imported a third time, and every value has to be that of the model: what follows from an item in another way
//! than the model has it (a rotary inertia, an offset in thicknesses) is found there, and refused by name.

use super::held;
use super::{ExportError, Exported};
use crate::abaqus::import_keywords;
use crate::imported::{ImportOptions, Imported, KeyedBound, KeyedOrigins, Solver};
use crate::system::{Quantity as Q, System, system_by_name};
use retune::deck::{DeckError, Keyword, KeywordChanges, KeywordDeck, keyword_real};
use retune::model::{Model, ParametricModel, PlacedElement, Registry};
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::path::{Path, PathBuf};

/// A comment above what is added.
const HEADING: &str = "** --- added by retune ---";

/// Relative difference that a value of the written deck may have.
const SAME: f64 = 1e-10;

/// Where an item stands: keyword, data line, item.
type Place = (usize, usize, usize);

/// Writes the values of an updated model into the deck of Abaqus or CalculiX that it was imported from.
///
/// # Errors
/// A model of another origin; changes that no item can hold, all of them by name.
pub fn export_keywords(deck: &KeywordDeck, updated: &Model) -> Result<Exported, ExportError> {
    let spec = updated.spec();
    let imported = spec.imported.as_ref().ok_or(ExportError::NotImported)?;
    let refused = |text: String| ExportError::Refused(vec![text]);
    let system = system_by_name(&imported.units)
        .ok_or_else(|| refused(format!("imported.units: `{}` is not a system of units", imported.units)))?;
    let solver = match imported.format.as_str() {
        "abaqus" => Solver::Abaqus,
        "calculix" => Solver::CalculiX,
        other => {
            return Err(refused(format!(
                "imported.format: the model was imported from a deck of `{other}`, and this is one of Abaqus or CalculiX"
            )));
        }
    };
    let options = ImportOptions::again(imported, system, solver);
    let (base, before) = model_of(deck, options)?;
    let mut work = Work {
        deck,
        system,
        origins: &before.origins.keyed,
        changes: KeywordChanges::default(),
        told: Vec::new(),
        added: Vec::new(),
        refused: held::structure(base.spec(), spec),
        next: before.origins.keyed.largest,
    };
    work.nodes(&base, updated);
    let wishes = work.wishes(&base, updated);
    work.write(&wishes);
    work.add(&base, updated);
    if !work.refused.is_empty() {
        return Err(ExportError::Refused(work.refused));
    }
    let files = work.changes.apply(deck);
    let rounding = verify(deck, &files, options, updated)?;
    Ok(Exported { files, changes: work.told, added: work.added, rounding })
}

fn model_of(deck: &KeywordDeck, options: ImportOptions) -> Result<(Model, Imported), ExportError> {
    let imported = import_keywords(deck, options).map_err(|e| ExportError::Deck(e[0].clone()))?;
    match imported.load(&Registry::builtin()) {
        Ok((model, ..)) => Ok((model, imported)),
        Err(problems) => Err(ExportError::Model(problems.first().map_or_else(String::new, |p| p.message.clone()))),
    }
}

/// Imports what was written and holds it against the model: the largest relative difference of a value.
fn verify(deck: &KeywordDeck, files: &[String], options: ImportOptions, updated: &Model) -> Result<f64, ExportError> {
    let texts: HashMap<PathBuf, &String> = deck.sources().iter().map(|s| s.path().to_path_buf()).zip(files).collect();
    let mut read = |path: &Path| match texts.get(path) {
        Some(text) => Ok(text.as_bytes().to_vec()),
        None => std::fs::read(path),
    };
    let written = KeywordDeck::read(deck.sources()[0].path(), &mut read).map_err(ExportError::Deck)?;
    let (model, _) = model_of(&written, options)?;
    let (theta, theta0) = (updated.parameters().nominal(), model.parameters().nominal());
    let all: HashMap<&str, &PlacedElement> = model.elements().iter().map(|e| (e.name.as_str(), e)).collect();
    let (mut refused, mut largest, mut n_known) = (Vec::new(), 0.0_f64, 0);
    for new in updated.elements() {
        let Some(old) = all.get(new.name.as_str()) else { continue };
        n_known += 1;
        let Ok(wanted) = all_wanted((&model, old), (updated, new), [&theta0, &theta]) else { continue };
        let mut differ: Vec<String> = Vec::new();
        for (name, has, wants) in wanted {
            let (has, wants) = (has.unwrap_or(0.0), wants.unwrap_or(0.0));
            let apart = (has - wants).abs() / has.abs().max(wants.abs()).max(f64::MIN_POSITIVE);
            if apart > SAME {
                differ.push(format!("`{name}`"));
            } else {
                largest = largest.max(apart);
            }
        }
        if !differ.is_empty() && refused.len() < 20 {
            refused.push(format!(
                "{}: {} has no item in the deck that holds it by itself; nothing was written",
                new.path,
                differ.join(", ")
            ));
        }
    }
    // What was added has other names there.
    let (there, here) = (model.elements().len() - n_known, updated.elements().len() - n_known);
    if refused.is_empty() && there < here {
        refused.push(format!("{here} elements were added to the model, and the deck holds {there} of them"));
    }
    if refused.is_empty() { Ok(largest) } else { Err(ExportError::Refused(refused)) }
}

/// A value of an element by its name or the path of its ply's number: as the deck gives it, and as it should be.
type Values = Vec<(String, Option<f64>, Option<f64>)>;

/// Every value of an element; of one of plies their numbers in place of what they give.
fn all_wanted(
    (base, old): (&Model, &PlacedElement),
    (updated, new): (&Model, &PlacedElement),
    [theta0, theta]: [&[f64]; 2],
) -> Result<Values, String> {
    let plies = held::plies((base, old), (updated, new))?;
    let named = held::wanted(old, new, theta0, theta)
        .into_iter()
        .map(|(i, has, wants)| (old.kind.properties()[i].name.to_string(), has, wants));
    let mut all: Values = named.filter(|w| plies.is_none() || !held::is_of_plies(&w.0)).collect();
    let numbers = plies.into_iter().flatten();
    all.extend(numbers.map(|(name, has, wants)| (name, Some(has), Some(wants))));
    Ok(all)
}

/// What one element wants of an item: the keyword that uses it, the value in the deck's unit, whether that is another one than it has.
struct Wish {
    user: usize,
    value: f64,
    is_new: bool,
}

/// Values of items by the keyword whose elements want them; none where these disagree.
type ByUser = BTreeMap<usize, Option<BTreeMap<Place, f64>>>;

type Wishes = BTreeMap<Place, Vec<Wish>>;

struct Work<'a> {
    deck: &'a KeywordDeck,
    system: &'static System,
    origins: &'a KeyedOrigins,
    changes: KeywordChanges,
    told: Vec<String>,
    added: Vec<String>,
    refused: Vec<String>,
    /// The largest number of an element.
    next: u32,
}

impl<'a> Work<'a> {
    fn refuse(&mut self, what: String) {
        if !self.refused.contains(&what) {
            self.refused.push(what);
        }
    }

    fn nodes(&mut self, base: &Model, updated: &Model) {
        let size = base.geometry().size();
        for (name, old) in base.geometry().names.iter().zip(&base.geometry().positions) {
            match updated.geometry().node(name).map(|n| updated.geometry().positions[n]) {
                None => self.refuse(format!("nodes.{name}: it was taken out, and export does not delete from a deck")),
                Some(new) if (0..3).any(|k| (new[k] - old[k]).abs() > 1e-10 * size) => {
                    self.refuse(format!("nodes.{name}: it moved, and nodes of a mesh are not moved; edit the deck"));
                }
                Some(_) => {}
            }
        }
    }

    /// The items of an element, and the keyword that uses them.
    fn bounds_of(&self, element: &PlacedElement) -> Option<(usize, &'a [KeyedBound])> {
        if let Some(section) = element.section.as_ref().and_then(|s| self.origins.sections.get(s)) {
            return Some((section.0, &section.1));
        }
        let keyword = *self.origins.points.get(&element.name)?;
        self.origins.of_points.get(&keyword).map(|b| (keyword, &b[..]))
    }

    fn wishes(&mut self, base: &Model, updated: &Model) -> Wishes {
        let (theta0, theta) = (base.parameters().nominal(), updated.parameters().nominal());
        let now: HashMap<&str, &PlacedElement> = updated.elements().iter().map(|e| (e.name.as_str(), e)).collect();
        let mut wishes = Wishes::new();
        for old in base.elements() {
            let Some(new) = now.get(old.name.as_str()) else {
                self.refuse(format!(
                    "{}: it was taken out or divided, and export does not delete from a deck",
                    old.path
                ));
                continue;
            };
            if let Some(why) = held::is_other(base, updated, old, new, false) {
                self.refuse(why);
                continue;
            }
            if held::is_damped(new) {
                self.refuse(format!("{}: damping of an element has no item in the deck", new.path));
                continue;
            }
            let wanted = match all_wanted((base, old), (updated, new), [&theta0, &theta]) {
                Ok(wanted) => wanted,
                Err(why) => {
                    self.refuse(why);
                    continue;
                }
            };
            let Some((user, bounds)) = self.bounds_of(old) else { continue };
            for bound in bounds {
                let found = wanted.iter().find(|w| w.0 == bound.property);
                let Some(&(_, has, wants)) = found else { continue };
                let is_new = !held::is_same(has, wants);
                let value = if is_new { wants } else { has }.unwrap_or(0.0) / bound.factor;
                wishes.entry(bound.place).or_default().push(Wish { user, value, is_new });
            }
        }
        wishes
    }

    /// Writes what is wished into items, and materials anew where their sections no longer agree.
    fn write(&mut self, wishes: &Wishes) {
        let changed: BTreeSet<usize> = wishes.iter().filter(|w| w.1.iter().any(|w| w.is_new)).map(|w| w.0.0).collect();
        let material_of: HashMap<usize, &String> =
            self.origins.materials.iter().flat_map(|(name, keys)| keys.iter().map(move |k| (*k, name))).collect();
        let mut written: HashSet<&String> = HashSet::new();
        for keyword in changed {
            match material_of.get(&keyword).copied() {
                None => {
                    let values = values_of(wishes, |k| k == keyword);
                    let Some(values) = self.one(&values, keyword) else { continue };
                    self.put(&values);
                }
                Some(material) if written.insert(material) => self.material(wishes, material),
                Some(_) => {}
            }
        }
    }

    /// What all users of a keyword agree on.
    fn one(&mut self, all: &ByUser, keyword: usize) -> Option<BTreeMap<Place, f64>> {
        let first = all.values().next()?;
        let agree = first.as_ref().filter(|first| {
            all.values().flatten().count() == all.len() && all.values().flatten().all(|v| is_one(v, first))
        });
        if agree.is_none() {
            let (file, line) = self.deck.keyword(keyword).place();
            self.refuse(format!(
                "*{} at {file}:{line}: its elements no longer have one value; give those that changed a set and a section of their own in the deck, and import it again",
                self.deck.keyword(keyword).name()
            ));
        }
        agree.cloned()
    }

    fn put(&mut self, values: &BTreeMap<Place, f64>) {
        for (&(keyword, line, item), &value) in values {
            let k = self.deck.keyword(keyword);
            let Some(data) = k.line(line) else { continue };
            let old = data.text(item).to_string();
            if data.real_or(item, "value", 0.0).is_ok_and(|v| held::is_same(Some(v), Some(value))) {
                continue;
            }
            let place = data.error(None, "");
            match self.changes.real(&data, (item, "value"), value) {
                Ok(()) => self.told.push(format!(
                    "{}:{}: *{}, item {}: {old} -> {}",
                    place.file,
                    place.line,
                    k.name(),
                    item + 1,
                    keyword_real(value)
                )),
                Err(e) => self.refuse(e.to_string()),
            }
        }
    }

    /// A material: in its place where its sections agree, else copies for those that differ from the most.
    fn material(&mut self, wishes: &Wishes, material: &str) {
        let keywords = self.origins.materials[material].clone();
        let users = values_of(wishes, |k| keywords.contains(&k));
        let mut classes: Vec<(BTreeMap<Place, f64>, Vec<usize>)> = Vec::new();
        for (user, values) in users {
            let Some(values) = values else {
                self.one(&BTreeMap::from([(user, None)]), user);
                continue;
            };
            match classes.iter_mut().find(|c| is_one(&c.0, &values)) {
                Some(class) => {
                    class.0.extend(values);
                    class.1.push(user);
                }
                None => classes.push((values, vec![user])),
            }
        }
        // Those that want what the deck has keep it, else the most.
        let keeps = |values: &BTreeMap<Place, f64>| {
            values.iter().all(|(&(k, line, item), v)| {
                let data = self.deck.keyword(k).line(line);
                data.and_then(|d| d.real_or(item, "value", 0.0).ok())
                    .is_some_and(|has| held::is_same(Some(has), Some(*v)))
            })
        };
        classes.sort_by_key(|c| (!keeps(&c.0), std::cmp::Reverse(c.1.len())));
        for (i, (values, users)) in classes.into_iter().enumerate() {
            if i == 0 {
                self.put(&values);
            } else {
                self.copy(material, &keywords, &values, &users, i);
            }
        }
    }

    fn copy(&mut self, material: &str, keywords: &[usize], values: &BTreeMap<Place, f64>, users: &[usize], i: usize) {
        let plain = material.trim_matches('"');
        let mut number = i;
        let mut name = format!("{plain}_R{number}");
        while self.origins.materials.contains_key(&name)
            || self.added.iter().any(|a| a.contains(&format!("NAME={name}")))
        {
            number += 1;
            name = format!("{plain}_R{number}");
        }
        let name = if material.starts_with('"') { format!("\"{name}\"") } else { name };
        let mut lines = vec![HEADING.to_string(), format!("*MATERIAL, NAME={name}")];
        for &k in keywords.iter().filter(|k| self.deck.keyword(**k).name() != "MATERIAL") {
            let k = self.deck.keyword(k);
            if k.parameter("INPUT").is_some() {
                let text = format!("material {material}: its *{} stands in a file of data; it is not copied", k.name());
                self.refuse(text);
                return;
            }
            lines.extend(own_lines(&k, values));
        }
        let Some(first) = keywords.iter().min().map(|k| self.deck.keyword(*k)) else { return };
        self.changes.add_above(&first, &lines);
        self.added.extend(lines);
        self.told.push(format!("added: *MATERIAL {name}, a copy of {material} for {} sections", users.len()));
        for &user in users {
            let k = self.deck.keyword(user);
            if let Err(e) = self.refer(&k, material, &name) {
                self.refuse(e.to_string());
            }
            let (file, line) = k.place();
            self.told.push(format!("{file}:{line}: *{}, MATERIAL: {material} -> {name}", k.name()));
        }
    }

    /// Names another material on a section; on each of its plies that has the old one.
    fn refer(&mut self, k: &Keyword<'_>, old: &str, new: &str) -> Result<(), DeckError> {
        if k.parameter("COMPOSITE").is_none() {
            return self.changes.parameter(self.deck, k, "MATERIAL", new);
        }
        let plies = k.lines().filter(|line| retune::deck::label(line.text(2)) == old);
        plies.into_iter().try_for_each(|line| self.changes.item(&line, (2, "material"), new.to_string()))
    }

    /// Writes masses and springs to ground that the deck has not.
    fn add(&mut self, base: &Model, updated: &Model) {
        let known: HashSet<&str> = base.elements().iter().map(|e| e.name.as_str()).collect();
        let theta = updated.parameters().nominal();
        // Lines by the keyword above which they stand.
        let mut blocks: BTreeMap<Option<usize>, Vec<String>> = BTreeMap::new();
        for element in updated.elements().iter().filter(|e| !known.contains(e.name.as_str())) {
            let values: BTreeMap<&str, f64> = element
                .kind
                .properties()
                .iter()
                .map(|p| p.name)
                .zip(element.values_at(&theta))
                .filter_map(|(name, v)| Some((name, v.filter(|v| *v != 0.0)?)))
                .collect();
            match self.lines_of(updated, element, &values) {
                Ok((above, lines)) => {
                    self.told.push(format!("added: {} for {}", lines.join("; "), element.name));
                    blocks.entry(above).or_default().extend(lines);
                }
                Err(why) => self.refuse(format!("{}: {why}", element.path)),
            }
        }
        for (above, lines) in blocks {
            let lines: Vec<String> = std::iter::once(HEADING.to_string()).chain(lines).collect();
            match above {
                Some(k) => self.changes.add_above(&self.deck.keyword(k), &lines),
                None => self.changes.add_last(self.deck, &lines),
            }
            self.added.extend(lines);
        }
    }

    fn lines_of(
        &mut self,
        updated: &Model,
        element: &PlacedElement,
        values: &BTreeMap<&str, f64>,
    ) -> Result<(Option<usize>, Vec<String>), String> {
        if element.axes != retune::model::GLOBAL && element.kind.name() != "spring" {
            return Err("what is added in axes of its own is not written; use global axes".to_string());
        }
        if element.stiffness_factor.is_some() || element.mass_factor.is_some() {
            return Err("a factor on what was added is not written; write it into its values".to_string());
        }
        let prefixes: &[&str] = match element.kind.name() {
            "point_mass" => &["mass", "inertia_"],
            "ground_spring" => &["k_"],
            "spring" => &["k"],
            kind => return Err(format!("an added {kind} has no keyword here")),
        };
        if let Some(other) = values.keys().find(|v| !prefixes.iter().any(|p| v.starts_with(p))) {
            return Err(format!("`{other}` of what is added has no keyword here"));
        }
        let mut labels = Vec::new();
        let mut above = None;
        for (i, node) in element.nodes.iter().enumerate() {
            let name = &updated.geometry().names[*node];
            let (instance, id) = self
                .origins
                .nodes
                .get(name)
                .cloned()
                .ok_or_else(|| format!("node `{name}` is not in the deck; put it on one that is"))?;
            let own = self.end_of(&instance)?;
            if i > 0 && own != above {
                return Err("it joins nodes of two instances, which has no keyword here".to_string());
            }
            above = own;
            labels.push(id.to_string());
        }
        let mut lines = Vec::new();
        let mut block = |work: &mut Self, kind: &str, keyword: &str, data: Vec<String>| {
            work.next += 1;
            let set = format!("RETUNE_{}", work.next);
            lines.push(format!("*ELEMENT, TYPE={kind}, ELSET={set}"));
            lines.push(format!("{}, {}", work.next, labels.join(", ")));
            lines.push(format!("*{keyword}, ELSET={set}"));
            lines.extend(data);
        };
        let factor = |q: Q| self.system.factor(q);
        let (mass, length) = (factor(Q::Mass), [factor(Q::Stiffness), factor(Q::RotationalStiffness)]);
        let inertia = factor(Q::Inertia);
        match element.kind.name() {
            "point_mass" => {
                if let Some(m) = values.get("mass") {
                    block(self, "MASS", "MASS", vec![keyword_real(m / mass)]);
                }
                let entry = |axes: &str, sign: f64| {
                    keyword_real(sign * values.get(format!("inertia_{axes}").as_str()).unwrap_or(&0.0) / inertia)
                };
                if values.keys().any(|v| v.starts_with("inertia_")) {
                    let data = [("xx", 1.0), ("yy", 1.0), ("zz", 1.0), ("xy", -1.0), ("xz", -1.0), ("yz", -1.0)];
                    block(self, "ROTARYI", "ROTARY INERTIA", vec![data.map(|(a, s)| entry(a, s)).join(", ")]);
                }
            }
            "spring" => {
                let k = values.get("k").copied().unwrap_or(0.0);
                block(self, "SPRINGA", "SPRING", vec![String::new(), keyword_real(k / length[0])]);
            }
            _ => {
                for (i, dof) in retune::element::Dof::ALL.into_iter().enumerate() {
                    if let Some(k) = values.get(format!("k_{dof}").as_str()) {
                        let data = vec![(i + 1).to_string(), keyword_real(k / length[usize::from(dof.is_rotation())])];
                        block(self, "SPRING1", "SPRING", data);
                    }
                }
            }
        }
        Ok((above, lines))
    }

    /// The keyword above which elements of an instance may be added: the end of its part, of a flat deck its first step.
    fn end_of(&self, instance: &str) -> Result<Option<usize>, String> {
        let label = |k: &Keyword<'_>, name: &str| k.label(name).unwrap_or_default();
        if instance.is_empty() {
            return Ok(self.deck.keywords().find(|k| matches!(k.name(), "STEP" | "ENDASSEMBLY")).map(|k| k.index()));
        }
        let part = self.deck.keywords().find(|k| k.name() == "INSTANCE" && label(k, "NAME") == instance);
        let part = part.map(|k| label(&k, "PART")).unwrap_or_default();
        let count = self.deck.keywords().filter(|k| k.name() == "INSTANCE" && label(k, "PART") == part).count();
        if count != 1 {
            return Err(format!("part {part} has {count} instances, and what is added to it would be in each"));
        }
        let mut below = self.deck.keywords().skip_while(|k| !(k.name() == "PART" && label(k, "NAME") == part));
        below
            .find(|k| k.name() == "ENDPART")
            .map(|k| Some(k.index()))
            .ok_or_else(|| format!("part {part} is not found"))
    }
}

/// The values of some keywords' items, by the keyword that uses them; none for one whose elements disagree.
fn values_of(wishes: &Wishes, of: impl Fn(usize) -> bool) -> ByUser {
    let mut out = ByUser::new();
    for (place, all) in wishes.iter().filter(|w| of(w.0.0)) {
        for wish in all {
            let user = out.entry(wish.user).or_insert_with(|| Some(BTreeMap::new()));
            let Some(values) = user else { continue };
            let known = *values.entry(*place).or_insert(wish.value);
            if !held::is_same(Some(known), Some(wish.value)) {
                *user = None;
            }
        }
    }
    out
}

/// Whether values at the same places are the same.
fn is_one(a: &BTreeMap<Place, f64>, b: &BTreeMap<Place, f64>) -> bool {
    a.iter().all(|(place, v)| b.get(place).is_none_or(|w| held::is_same(Some(*v), Some(*w))))
}

/// The lines of a keyword with other values in some of its items.
fn own_lines(k: &Keyword<'_>, values: &BTreeMap<Place, f64>) -> Vec<String> {
    let mut lines: Vec<String> = k.text().lines().map(str::to_string).collect();
    // Data lines stand at the end, comments between them counted as lines.
    let data: Vec<usize> = {
        let n_head = lines.len() - k.lines().filter(|l| !l.whole().is_empty()).count().min(lines.len());
        (n_head..lines.len()).collect()
    };
    for (i, line) in k.lines().enumerate() {
        let Some(&at) = data.get(i) else { continue };
        let has = |item: usize| line.real_or(item, "value", 0.0).ok();
        let items: Vec<String> = (0..line.len())
            .map(|item| match values.get(&(k.index(), i, item)) {
                Some(v) if !held::is_same(has(item), Some(*v)) => keyword_real(*v),
                _ => line.text(item).to_string(),
            })
            .collect();
        if values.keys().any(|p| p.0 == k.index() && p.1 == i) {
            lines[at] = items.join(", ");
        }
    }
    lines
}

/// For messages of decks that cannot be read again.
impl From<DeckError> for ExportError {
    fn from(e: DeckError) -> Self {
        Self::Deck(e)
    }
}
