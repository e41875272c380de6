//! What is known of a deck while its keywords are read, and how entries of the model file are written.

use super::elastic::Material;
use super::kinds::Kind;
use super::scopes::{At, Gathered, own};
use super::tied::Tied;
use crate::imported::{ImportOptions, KeyedBound, KeyedOrigins};
use crate::listed::round_above;
use crate::names::{Taken, heading, slug};
use crate::patches;
use crate::report::ImportReport;
use crate::system::Quantity;
use crate::text::{computed, exact, with_unit};
use crate::writer::{Block, Writer};
use retune::deck::{DeckError, Keyword, KeywordDeck};
use std::cell::RefCell;
use std::collections::{BTreeMap, HashMap, HashSet};

pub(super) use crate::imported::Solver;

/// Properties with their values as text.
pub(super) type Values = Vec<(String, String)>;

pub(super) struct Importer<'a> {
    pub deck: &'a KeywordDeck,
    pub options: ImportOptions,
    pub all: Gathered,
    pub report: ImportReport,
    pub out: Writer,
    pub materials: BTreeMap<String, Material>,
    /// Displacement axes of nodes, where they are not global.
    pub transforms: HashMap<At, [[f64; 3]; 3]>,
    /// Nodes that a TIE moved.
    pub moved: HashMap<At, [f64; 3]>,
    pub frames: HashMap<(usize, u32), String>,
    pub node_frames: HashMap<At, String>,
    pub frame_names: Taken,
    pub link_names: Taken,
    pub section_names: Taken,
    pub element_names: Taken,
    /// Beginnings of names of nodes, by instance.
    pub prefixes: Vec<String>,
    /// The section of each element, by instance: a keyword and one, or zero.
    pub sectioned: Vec<Vec<u32>>,
    /// Where the elements of the model file that an element became stand in their group: group, first, number.
    pub written: HashMap<At, [u32; 3]>,
    pub sections: HashMap<(usize, String), String>,
    /// Groups in the order in which they were made: name, members, whether it is of a section with stiffness.
    pub groups: Vec<(String, Vec<String>, bool)>,
    pub ties: Vec<Tied>,
    pub tied: HashMap<At, bool>,
    /// Nodes in the middle of shells of eight nodes, and above which number those of an instance stand.
    middles: HashSet<String>,
    above: HashMap<u32, u64>,
    pub origins: KeyedOrigins,
    /// The keyword of the masses or springs that are being written.
    pub point: Option<usize>,
    /// Items of the section that is being written.
    bounds: RefCell<Vec<KeyedBound>>,
}

impl<'a> Importer<'a> {
    pub(super) fn new(deck: &'a KeywordDeck, options: ImportOptions, all: Gathered) -> Self {
        let report = ImportReport {
            entry: "keyword",
            files: deck.sources().len(),
            read: all.read.clone(),
            left_out: all.left_out.clone(),
            ..ImportReport::default()
        };
        let mut taken = Taken::default();
        let prefixes = all.instances.iter().enumerate().map(|(i, instance)| {
            let word = || slug(&instance.name).unwrap_or_else(|| format!("i{i}"));
            if i == 0 { String::new() } else { format!("{}_", taken.unique(&word())) }
        });
        let prefixes: Vec<String> = prefixes.collect();
        let sectioned = (0..all.instances.len()).map(|i| vec![0; all.body(i as u32).elements.len()]).collect();
        Self {
            deck,
            options,
            report,
            out: Writer::new(),
            materials: BTreeMap::new(),
            transforms: HashMap::new(),
            moved: HashMap::new(),
            frames: HashMap::new(),
            node_frames: HashMap::new(),
            frame_names: Taken::default(),
            link_names: Taken::default(),
            section_names: Taken::default(),
            element_names: Taken::default(),
            prefixes,
            sectioned,
            written: HashMap::new(),
            sections: HashMap::new(),
            groups: Vec::new(),
            ties: Vec::new(),
            tied: HashMap::new(),
            middles: HashSet::new(),
            above: HashMap::new(),
            origins: KeyedOrigins::default(),
            point: None,
            bounds: RefCell::default(),
            all,
        }
    }

    // Numbers with units.

    pub(super) fn unit(&self, quantity: Quantity) -> &'static str {
        self.options.system.unit(quantity)
    }

    /// A number of the deck with its unit.
    pub(super) fn with(&self, value: f64, quantity: Quantity) -> String {
        with_unit(&exact(value), self.unit(quantity))
    }

    /// A number that was computed, with its unit.
    pub(super) fn computed(&self, value: f64, quantity: Quantity) -> String {
        with_unit(&computed(value), self.unit(quantity))
    }

    /// That a property of the section or the point that is being written comes from an item: keyword, data line, item.
    pub(super) fn bind(&self, property: &str, place: (usize, usize, usize), quantity: Quantity) {
        self.bind_by(property.to_string(), place, self.options.system.factor(quantity));
    }

    fn bind_by(&self, property: String, place: (usize, usize, usize), factor: f64) {
        let bound = KeyedBound { property, place, factor };
        let mut all = self.bounds.borrow_mut();
        // Elements of one keyword say the same.
        if !all.contains(&bound) {
            all.push(bound);
        }
    }

    /// The same of an entry of an inertia, with the sign that the deck's convention gives it.
    pub(super) fn bind_inertia(&self, axes: &str, place: (usize, usize, usize), sign: f64) {
        self.bind_by(format!("inertia_{axes}"), place, sign * self.options.system.factor(Quantity::Inertia));
    }

    /// Does something of which what is bound stands below a path.
    pub(super) fn below<T>(&self, path: &str, make: impl FnOnce() -> T) -> T {
        let before = self.bounds.take();
        let out = make();
        let mut own = self.bounds.take();
        for bound in &mut own {
            bound.property = format!("{path}.{}", bound.property);
        }
        self.bounds.replace([before, own].concat());
        out
    }

    /// What was bound since the last time.
    pub(super) fn bound(&self) -> Vec<KeyedBound> {
        self.bounds.take()
    }

    pub(super) fn lengths(&self, v: [f64; 3]) -> String {
        format!("[{}]", v.map(|x| self.computed(x, Quantity::Length)).join(", "))
    }

    // Nodes and elements.

    pub(super) fn kind(&self, at: At) -> &'static Kind {
        self.all.body(at.instance).elements[at.index as usize].kind
    }

    pub(super) fn nodes_of(&self, at: At) -> Vec<At> {
        let body = self.all.body(at.instance);
        let nodes = body.nodes_of(&body.elements[at.index as usize]);
        nodes.iter().map(|n| own(*n, at.instance)).collect()
    }

    pub(super) fn node_name(&self, at: At) -> String {
        let id = self.all.body(at.instance).nodes[at.index as usize].0;
        format!("{}n{id}", self.prefixes[at.instance as usize])
    }

    /// The node in the middle of a shell of eight nodes, which the deck has not: called as the others, above the largest of them.
    pub(super) fn middle(&mut self, at: At, place: [f64; 3]) -> String {
        let instance = self.nodes_of(at)[0].instance;
        let nodes = &self.all.body(instance).nodes;
        let largest = || nodes.iter().map(|n| n.0).max().unwrap_or(0);
        let above = *self.above.entry(instance).or_insert_with(|| round_above(largest().into()).unwrap_or_default());
        let mut number = above + u64::from(self.id_of(at));
        let name = |number: u64| format!("{}n{number}", self.prefixes[instance as usize]);
        while !self.middles.insert(name(number)) {
            number += 1;
        }
        let name = name(number);
        let value = self.lengths(place);
        self.out.node(&name, &value, Some(place), patches::CENTRE);
        name
    }

    /// Number of an element.
    pub(super) fn id_of(&self, at: At) -> u32 {
        self.all.body(at.instance).elements[at.index as usize].id
    }

    pub(super) fn node_names(&self, at: At) -> Vec<String> {
        self.nodes_of(at).into_iter().map(|n| self.node_name(n)).collect()
    }

    pub(super) fn position(&self, at: At) -> [f64; 3] {
        if let Some(p) = self.moved.get(&at) {
            return *p;
        }
        let own = self.all.body(at.instance).nodes[at.index as usize].1;
        let instance = &self.all.instances[at.instance as usize];
        if instance.is_moved() { instance.place(own) } else { own }
    }

    pub(super) fn points(&self, at: At) -> Vec<[f64; 3]> {
        self.nodes_of(at).into_iter().map(|n| self.position(n)).collect()
    }

    pub(super) fn centre(&self, at: At) -> [f64; 3] {
        let points = self.points(at);
        std::array::from_fn(|i| points.iter().map(|p| p[i]).sum::<f64>() / points.len() as f64)
    }

    /// An error at an element.
    pub(super) fn at_element(&self, at: At, message: &str) -> DeckError {
        let e = &self.all.body(at.instance).elements[at.index as usize];
        self.deck.keyword(e.keyword as usize).error(format_args!("element {}: {message}", e.id))
    }

    // Entries.

    /// Writes an entry.
    pub(super) fn entry(&mut self, block: Block, name: &str, value: &str) {
        self.out.entry(block, name, value, "");
    }

    /// Writes one of the elements that an element becomes, into the group of its section.
    pub(super) fn element(&mut self, block: Block, at: At, part: usize, value: &str) {
        let name = self.new_element(at, part);
        self.out.entry(block, &name, value, "");
    }

    /// Writes an entry of `elements`.
    ///
    /// * `items` - its type, its nodes, and what else it has
    pub(super) fn listed(&mut self, at: At, part: usize, items: &[(String, String)]) {
        let name = self.new_element(at, part);
        self.out.element(Block::Elements, &name, items);
    }

    /// The name of an element, which joins the group of its section.
    fn new_element(&mut self, at: At, part: usize) -> String {
        let e = &self.all.body(at.instance).elements[at.index as usize];
        let plain = format!("{}{}_{}", self.prefixes[at.instance as usize], e.kind.name.to_lowercase(), e.id);
        let plain = if e.kind.becomes.len() > 1 { format!("{plain}_{}", part + 1) } else { plain };
        let name = self.element_names.unique(&plain);
        if let Some(k) = self.point {
            self.origins.points.insert(name.clone(), k);
        }
        let own = self.groups.len().saturating_sub(1) as u32;
        if let Some(group) = self.groups.last_mut() {
            self.written.entry(at).or_insert([own, group.1.len() as u32, 0])[2] += 1;
            group.1.push(name.clone());
        }
        name
    }

    /// Says how an element of retune differs.
    pub(super) fn differs(&mut self, kind: &Kind) {
        if !kind.differs.is_empty() {
            self.report.approximate(kind.differs);
        }
    }

    /// The section of a keyword for a kind of element, made when it is first asked for.
    pub(super) fn section(
        &mut self,
        k: &Keyword<'_>,
        variant: &str,
        make: impl FnOnce(&mut Self) -> Result<Values, DeckError>,
    ) -> Result<String, DeckError> {
        if let Some(name) = self.sections.get(&(k.index(), variant.to_string())) {
            return Ok(name.clone());
        }
        self.bound();
        let values = make(self)?;
        let label = k.label("ELSET").unwrap_or_default();
        let name = self.section_names.unique(&section_word(k, &label));
        self.out.entry(Block::Sections, &name, &crate::text::map(&values), "");
        self.sections.insert((k.index(), variant.to_string()), name.clone());
        self.origins.sections.insert(name.clone(), (k.index(), self.bound()));
        Ok(name)
    }

    /// Names of what an element became; none before its section was read.
    pub(super) fn names_of(&self, at: At) -> Vec<String> {
        let Some([group, first, count]) = self.written.get(&at).map(|w| w.map(|v| v as usize)) else {
            return Vec::new();
        };
        self.groups[group].1[first..first + count].to_vec()
    }

    // Ties.

    pub(super) fn is_tied(&self, node: At) -> bool {
        self.tied.contains_key(&node)
    }

    pub(super) fn tied(&mut self, tied: Tied) {
        self.tied.insert(tied.slave, tied.turns);
        self.ties.push(tied);
    }

    /// The dofs of a node that a tie leads.
    pub(super) fn tied_dofs(&self, node: At) -> [bool; 6] {
        match self.tied.get(&node) {
            None => [false; 6],
            Some(turns) => [true, true, true, *turns, *turns, *turns],
        }
    }
}

/// A word for a name of the deck; that of the kind where there is none.
pub(super) fn word(name: &str, kind: &str) -> String {
    let name = name.rsplit('.').next().unwrap_or(name);
    match slug(name) {
        Some(word) if !name.starts_with('_') => word,
        _ if name.is_empty() => kind.to_string(),
        _ => {
            let letters: String = name.chars().filter(char::is_ascii_alphanumeric).take(40).collect();
            if letters.is_empty() { kind.to_string() } else { format!("{kind}_{}", letters.to_lowercase()) }
        }
    }
}

/// A name for a section: what CAE wrote above it, or its set.
pub(super) fn section_word(k: &Keyword<'_>, label: &str) -> String {
    let above = k.comments().filter_map(|c| c.strip_prefix("Section:")).last();
    let above = above.map(|c| c.split("  Profile:").next().unwrap_or(c)).and_then(|c| slug(heading(c)));
    above.unwrap_or_else(|| word(label, "section"))
}
