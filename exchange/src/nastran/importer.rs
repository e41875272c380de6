//! The pass over the cards of a deck.

use super::design::Design;
pub(super) use super::names::node;
use super::names::{property_name, worth_keeping};
use super::{CardRule, Treatment, rule};
use crate::coord::{Coord, GLOBAL_COORD};
use crate::imported::{Bound, ImportOptions, Imported, Origins, Plane, head, mesh_name};
use crate::names::{Taken, heading, slug};
use crate::report::ImportReport;
use crate::system::Quantity;
use crate::text::{clean, exact, list, map, quoted};
use crate::writer::{Block, Writer};
use retune::catalogue::did_you_mean;
use retune::deck::{CardId, Deck, DeckError};
use retune::model::Registry;
use std::collections::{BTreeMap, HashMap, HashSet};

/// Numbers that must be found: one space of numbers per kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Space {
    Grid,
    Coordinates,
    /// One space for each family of properties, by the name of one of it: elements of different kinds may have properties of one number.
    Property(&'static str),
    Material,
    PointMass,
}

impl Space {
    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "GRID" => Space::Grid,
            "CORD2R" | "CORD2C" | "CORD2S" => Space::Coordinates,
            "MAT1" | "MAT2" | "MAT3" | "MAT8" | "MAT9" | "MAT10" | "MAT11" | "MATHP" => Space::Material,
            "PMASS" => Space::PointMass,
            "PBAR" | "PBARL" | "PBRSECT" => Space::Property("PBAR"),
            "PBEAM" | "PBEAML" | "PBCOMP" | "PBMSECT" => Space::Property("PBEAM"),
            "PSHELL" | "PCOMP" | "PCOMPG" => Space::Property("PSHELL"),
            _ if name.starts_with('P') => match rule(name) {
                Some(CardRule { name, treatment: Treatment::Used(_) | Treatment::Refused(_), .. }) => {
                    Space::Property(name)
                }
                _ => return None,
            },
            _ => return None,
        })
    }

    /// The space of the properties of a card.
    pub(super) fn of_property(name: &str) -> Option<Self> {
        Self::of(name).filter(|space| matches!(space, Space::Property(_)))
    }

    /// Whether elements and properties refer to its cards, so that one to which none refers means nothing.
    fn is_referred_to(self) -> bool {
        matches!(self, Space::Property(_) | Space::Material)
    }
}

/// A grid point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Grid {
    /// Basic coordinates, in the deck's unit.
    pub position: [f64; 3],
    /// Coordinate system of its displacements.
    pub cd: u32,
}

/// One entry with its values, and where they come from.
#[derive(Debug, Clone, Default)]
pub(super) struct Values {
    pub items: Vec<(String, String)>,
    pub bounds: Vec<Bound>,
    /// Of a bar.
    pub plane: Option<Box<Plane>>,
}

const OVERFULL: &str = "a line of it has more than eight fields of data between commas; go on in a continuation, a line that begins with a comma";

/// Errors of one deck that are told at once.
const MOST_ERRORS: usize = 20;

pub(super) struct Importer<'a> {
    pub deck: &'a Deck,
    pub options: ImportOptions,
    pub report: ImportReport,
    pub out: Writer,
    pub origins: Origins,
    pub design: Design,
    /// Mass of the deck's fields times this is that of its system of units.
    pub wtmass: f64,
    /// Whether masses are coupled (`PARAM,COUPMASS`) and not lumped.
    pub coupled: bool,
    /// Sets of SPC and of MPC that hold.
    pub spc: HashSet<u32>,
    pub mpc: HashSet<u32>,
    pub coords: HashMap<u32, Coord>,
    pub frames: HashMap<u32, String>,
    pub names: Taken,
    pub params: HashMap<String, String>,
    /// GRDSET, BAROR, BEAMOR.
    pub defaults: HashMap<&'a str, CardId>,
    pub index: HashMap<(Space, u32), CardId>,
    pub grids: HashMap<u32, Grid>,
    pub sections: HashMap<(u32, &'static str), String>,
    pub groups: BTreeMap<usize, (String, Vec<String>)>,
    pub group_at: HashMap<String, usize>,
    pub pending: Vec<String>,
    pub heading: Option<String>,
    /// Names of properties that a preprocessor wrote.
    pub named: HashMap<u32, String>,
    pub elements: HashMap<u32, CardId>,
    /// Scalar points, and whether their node is written.
    pub scalars: BTreeMap<u32, bool>,
    /// Nodes in the middle of edges without a grid that are written already.
    pub(super) middles: HashSet<String>,
    /// Above which number nodes in the middle of shells of eight grids stand, once there is one.
    pub(super) above: Option<u64>,
    /// Nodes whose displacements have axes of their own, by frame.
    pub turned: BTreeMap<String, Vec<String>>,
}

/// Turns a deck into the text of a model file.
///
/// # Errors
/// Every card that cannot be read, twenty at most, each with file, line, card, field and what was expected.
pub fn import(deck: &Deck, options: ImportOptions) -> Result<Imported, Vec<DeckError>> {
    let mut importer = Importer::new(deck, options).map_err(|e| vec![e])?;
    let errors = importer.read_all();
    if !errors.is_empty() {
        return Err(errors);
    }
    let asked = importer.responses().map_err(|e| vec![e])?;
    let mut imported = importer.finish();
    if !(asked.frequencies.is_empty() && asked.components.is_empty()) {
        // The solver counts motions without frequency as modes.
        let model = imported.load(&Registry::builtin()).ok().map(|(model, ..)| model);
        imported.test = super::asked::test(deck, &asked, model.as_ref(), &mut imported.report);
    }
    Ok(imported)
}

impl<'a> Importer<'a> {
    fn new(deck: &'a Deck, options: ImportOptions) -> Result<Self, DeckError> {
        let mut importer = Self {
            deck,
            options,
            report: ImportReport { entry: "card", files: deck.sources().len(), ..ImportReport::default() },
            out: Writer::new(),
            origins: Origins::default(),
            design: Design::default(),
            wtmass: 1.0,
            coupled: false,
            spc: HashSet::new(),
            mpc: HashSet::new(),
            coords: HashMap::from([(0, GLOBAL_COORD)]),
            frames: HashMap::new(),
            names: Taken::default(),
            params: HashMap::new(),
            defaults: HashMap::new(),
            index: HashMap::new(),
            grids: HashMap::new(),
            sections: HashMap::new(),
            groups: BTreeMap::new(),
            group_at: HashMap::new(),
            pending: Vec::new(),
            heading: None,
            named: HashMap::new(),
            elements: HashMap::new(),
            scalars: BTreeMap::new(),
            middles: HashSet::new(),
            above: None,
            turned: BTreeMap::new(),
        };
        importer.look_ahead()?;
        Ok(importer)
    }

    /// What later cards refer to: numbers, coordinate systems, grids, parameters of the solver, sets, design variables.
    fn look_ahead(&mut self) -> Result<(), DeckError> {
        let deck = self.deck;
        let mut grids = Vec::new();
        for id in deck.cards() {
            let name = deck.name(id);
            match name {
                "PARAM" => {
                    let card = deck.card(id);
                    self.params.insert(card.text(2).to_uppercase(), card.text(3).to_string());
                    match card.text(2).to_uppercase().as_str() {
                        "WTMASS" => self.wtmass = card.real(3, "V1")?,
                        "COUPMASS" => self.coupled = card.integer_or(3, "V1", -1)? > 0,
                        _ => {}
                    }
                }
                "GRDSET" | "BAROR" | "BEAMOR" => {
                    self.defaults.insert(name, id);
                }
                "CORD1R" | "CORD1C" | "CORD1S" => {
                    let card = deck.card(id);
                    for first in [2, 6] {
                        if let Some(cid) = card.optional_id(first, "CID")? {
                            self.claim(Space::Coordinates, cid, id, first)?;
                        }
                    }
                }
                "SPOINT" | "CELAS3" | "CELAS4" | "CMASS3" | "CMASS4" => self.expect_scalar_points(&deck.card(id))?,
                "PELAS" => {
                    let card = deck.card(id);
                    for first in [2, 6] {
                        if let Some(pid) = card.optional_id(first, "PID")? {
                            self.claim(Space::Property("PELAS"), pid, id, first)?;
                        }
                    }
                }
                "PMASS" => {
                    let card = deck.card(id);
                    for first in [2, 4, 6, 8] {
                        if let Some(pid) = card.optional_id(first, "PID")? {
                            self.claim(Space::PointMass, pid, id, first)?;
                        }
                    }
                }
                _ => {
                    if let Some(space) = Space::of(name) {
                        let card = deck.card(id);
                        if card.is_overfull() {
                            return Err(card.error(None, OVERFULL));
                        }
                        let number = card.id_at(2, "ID")?;
                        self.claim(space, number, id, 2)?;
                        if space == Space::Grid {
                            grids.push(number);
                        }
                    }
                }
            }
        }
        if !(self.wtmass > 0.0 && self.wtmass.is_finite()) {
            return Err(DeckError {
                file: deck.sources()[0].name().to_string(),
                line: 0,
                card: "PARAM WTMASS".into(),
                field: None,
                message: "it must be above zero".into(),
            });
        }
        self.origins.wtmass = self.wtmass;
        for file in deck.not_found() {
            self.report.note(format!(
                "INCLUDE `{}` of executive control is not there; it says nothing of the structure",
                clean(file)
            ));
        }
        self.check_scalar_points()?;
        for id in grids {
            self.grid_at(id, 0)?;
        }
        self.choose_sets()?;
        self.design = Design::read(deck)?;
        let mut names: Vec<(u32, String)> = Vec::new();
        for comment in deck.comments() {
            let text = deck.comment(comment);
            let lower = text.get(..text.len().min(64)).unwrap_or_default().to_lowercase();
            if !["femap", "hmname prop", "for region :"].iter().any(|mark| lower.contains(mark)) {
                continue;
            }
            // The property that stands right behind it.
            let following = deck
                .cards()
                .skip(comment.before as usize)
                .take(400)
                .find(|c| Space::of_property(deck.name(*c)).is_some());
            if let Some(pid) = following.and_then(|c| deck.card(c).id_at(2, "PID").ok()) {
                names.extend(property_name(text, pid).map(|n| (pid, n)));
            }
        }
        self.named.extend(names);
        Ok(())
    }

    fn claim(&mut self, space: Space, number: u32, card: CardId, field: usize) -> Result<(), DeckError> {
        self.origins.largest = self.origins.largest.max(number);
        if let Some(first) = self.index.insert((space, number), card) {
            let (one, other) = (self.deck.card(first), self.deck.card(card));
            // Grids and coordinate systems may stand twice if they are the same.
            let is_same =
                one.name() == other.name() && (1..=one.len().max(other.len())).all(|n| one.text(n) == other.text(n));
            if !(is_same && matches!(space, Space::Grid | Space::Coordinates)) {
                let (file, line) = one.place();
                let text = format!("the number {number} is already used at {file}:{line}, {}", one.name());
                return Err(other.error(Some((field, "ID")), text));
            }
        }
        Ok(())
    }

    fn read_all(&mut self) -> Vec<DeckError> {
        let deck = self.deck;
        let mut errors = Vec::new();
        let mut next_comment = 0;
        let mut last = "";
        let mut unknown: BTreeMap<&str, (CardId, usize)> = BTreeMap::new();
        for (i, id) in deck.cards().enumerate() {
            let comments = deck.comments();
            let mut has_comment = false;
            while next_comment < comments.len() && comments[next_comment].before as usize <= i {
                let text = deck.comment(&comments[next_comment]);
                if worth_keeping(text) {
                    self.pending.push(clean(text));
                    self.heading = slug(heading(text));
                    has_comment = true;
                }
                next_comment += 1;
            }
            let name = deck.name(id);
            if name != last && !has_comment {
                self.heading = None;
            }
            last = name;
            let Some(rule) = rule(name) else {
                unknown.entry(name).or_insert((id, 0)).1 += 1;
                continue;
            };
            let card = deck.card(id);
            let counts = |list: &mut BTreeMap<String, (usize, &'static str)>, what| {
                list.entry(name.to_string()).or_insert((0, what)).0 += 1;
            };
            if card.is_overfull() && matches!(rule.treatment, Treatment::Read(..) | Treatment::Used(_)) {
                errors.push(card.error(None, OVERFULL));
                continue;
            }
            if let Some(last) = rule.last.filter(|last| card.len() > *last) {
                let beyond = (last + 1..=card.len()).find(|n| !card.is_blank(*n)).unwrap_or(last + 1);
                let text = clean(card.text(beyond));
                let message = format!(
                    "`{text}` stands in field {beyond}, and {name} ends with field {last}; a second element has a card of its own"
                );
                errors.push(card.error(None, message));
                continue;
            }
            match rule.treatment {
                Treatment::Read(becomes, reader) => {
                    counts(&mut self.report.read, becomes);
                    // What is wrong in a property is found once for every element of it.
                    if let Some(e) = (reader.0)(self, &card).err().filter(|e| !errors.contains(e)) {
                        errors.push(e);
                    }
                }
                Treatment::Used(gives) => counts(&mut self.report.read, gives),
                Treatment::LeftOut(why) => {
                    counts(&mut self.report.left_out, why);
                    if matches!(name, "ASET" | "ASET1" | "OMIT" | "OMIT1") {
                        self.report.note(format!(
                            "the solver reduces its model ({name}): frequencies of the reduction lie above those of the whole model that is imported"
                        ));
                    }
                    self.pending.clear();
                }
                // What needs it is refused itself.
                Treatment::Refused(_) if Space::of(name).is_some_and(Space::is_referred_to) => {
                    counts(&mut self.report.left_out, "no element that is read has it");
                }
                Treatment::Refused(why) => errors.push(card.error(None, why)),
            }
            if errors.len() >= MOST_ERRORS {
                break;
            }
        }
        for (name, (first, count)) in unknown {
            let known = super::CARDS.iter().copied().flatten().map(|r| r.name);
            let suggestion = did_you_mean(name, known);
            let more = if count > 1 { format!(" ({count} of them)") } else { String::new() };
            errors.push(deck.error(first, None, format_args!("no card of this name is known{more}{suggestion}")));
        }
        if errors.is_empty() && !self.out.has_nodes() {
            let file = deck.sources()[0].name().to_string();
            let message = "the deck has no GRID".to_string();
            errors.push(DeckError { file, line: 0, card: String::new(), field: None, message });
        }
        errors
    }

    fn finish(mut self) -> Imported {
        let groups = std::mem::take(&mut self.groups);
        if self.options.parameter_per_property {
            self.parameters_of_properties(&groups);
        }
        self.write_design();
        for (name, members) in groups.values().filter(|g| g.1.len() > 1 || g.0.starts_with('p')) {
            self.out.group(name, members);
        }
        let deck = self.deck;
        let file = deck.sources()[0].path().file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        let mut imported = vec![
            ("from", quoted(&file)),
            ("format", "nastran".to_string()),
            ("units", self.options.system.name.to_string()),
        ];
        if self.wtmass != 1.0 {
            imported.push(("wtmass", exact(self.wtmass)));
        }
        let turned: Vec<(String, String)> = self.turned.iter().map(|(f, nodes)| (f.clone(), list(nodes))).collect();
        if !turned.is_empty() {
            imported.push(("displacement_frames", map(&turned)));
        }
        imported.extend(self.options.subcase.map(|s| ("subcase", s.to_string())));
        if self.options.parameter_per_property {
            imported.push(("parameters", "properties".to_string()));
        }
        for (key, value) in imported {
            self.out.entry(Block::Imported, key, &value, "");
        }
        let title = deck.case_control().value("TITLE", self.options.subcase).unwrap_or(&file).to_string();
        let head = head(&self.report, &file, self.options.system, &title);
        self.report.notes.sort();
        let unit = self.unit(Quantity::Length);
        let (text, mesh) = self.out.finish(&head, &mesh_name(deck.sources()[0].path()), unit);
        Imported { text, report: self.report, mesh, test: None, origins: self.origins }
    }

    /// Parameters of the variables that any field follows.
    fn write_design(&mut self) {
        let used = self.design.used.borrow().clone();
        let mut named: HashSet<usize> = HashSet::new();
        for place in self.design.places.keys().filter(|p| used.contains(p)) {
            named.extend(self.design.relations[place].terms.iter().map(|t| t.0));
        }
        let left: Vec<String> = self
            .design
            .places
            .iter()
            .filter(|(place, _)| !used.contains(place))
            .map(|(_, id)| format!("{} {}", self.deck.name(*id), self.deck.card(*id).text(2)))
            .collect();
        if !left.is_empty() {
            let shown = left.iter().take(5).cloned().collect::<Vec<_>>().join(", ");
            let more = if left.len() > 5 { format!(" and {} more", left.len() - 5) } else { String::new() };
            self.report.note(format!("relations to fields that no element uses are left out: {shown}{more}"));
        }
        for (what, count) in self.design.left.clone() {
            self.report.note(format!(
                "{count} relations {what} are left out: no parameter can stand there; the card's own value holds"
            ));
        }
        for (i, v) in self.design.variables.clone().into_iter().enumerate() {
            if !named.contains(&i) {
                continue;
            }
            self.origins.variables.insert(v.name.clone(), v.card);
            let mut items = vec![("value", exact(v.value))];
            if let Some([low, high]) = v.bounds {
                items.push(("bounds", format!("[{}, {}]", exact(low), exact(high))));
            }
            items.push((
                "description",
                format!("\"DESVAR {} {}\"", v.id, crate::text::clean(&v.label).replace(['"', '\\'], "")),
            ));
            self.out.entry(Block::Parameters, &v.name, &map(&items), "");
        }
    }

    fn parameters_of_properties(&mut self, groups: &BTreeMap<usize, (String, Vec<String>)>) {
        for (name, _) in groups.values().filter(|g| self.group_at.contains_key(&format!("property {}", g.0))) {
            self.out.factor_on_stiffness(name);
        }
    }
}
