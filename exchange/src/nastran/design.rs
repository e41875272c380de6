//! Design variables of SOL 200: DESVAR, DLINK, DVPREL1, DVMREL1, DVCREL1 as parameters of the model.

use super::{CardRule, left_out, refused, used};
use crate::names::slug;
use crate::text::{computed, with_unit};
use retune::deck::{Card, CardId, Deck, DeckError};
use retune::units::Unit;
use std::collections::{BTreeMap, HashMap, HashSet};

pub(super) const CARDS: &[CardRule] = &[
    used("DESVAR", "parameters"),
    used("DLINK", "parameters"),
    used("DVPREL1", "parameters"),
    used("DVMREL1", "parameters"),
    used("DVCREL1", "parameters"),
    left_out("DDVAL", "discrete values of design variables"),
    left_out("DOPTPRM", "how the optimiser works"),
    left_out("DSCREEN", "how the optimiser works"),
    left_out("MODTRAK", "how the optimiser works"),
    used("DRESP1", "targets"),
    used("DRESP2", "targets"),
    refused("DRESP3", "responses of external programs are not read"),
    used("DEQATN", "targets"),
    used("DCONSTR", "targets"),
    used("DCONADD", "targets"),
    used("DTABLE", "constants of equations"),
    used("DVPREL2", "parameters"),
    used("DVMREL2", "parameters"),
    used("DVCREL2", "parameters"),
    left_out("DVGRID", "shapes as design variables: the deck's own grids hold"),
    left_out("DVSHAP", "shapes as design variables: the deck's own grids hold"),
    left_out("DVBSHAP", "shapes as design variables: the deck's own grids hold"),
    left_out("TOPVAR", "topology: the deck's own values hold"),
    left_out("DVTREL1", "topology: the deck's own values hold"),
    left_out("DMNCON", "how the optimiser works"),
    left_out("DMRLAW", "topology: the deck's own values hold"),
];

/// A design variable.
#[derive(Debug, Clone)]
pub(super) struct Variable {
    pub card: CardId,
    pub id: u32,
    pub name: String,
    pub label: String,
    pub value: f64,
    pub bounds: Option<[f64; 2]>,
}

/// A field as C0 + Σ c_i x_i.
#[derive(Debug, Clone, Default)]
pub(super) struct Relation {
    constant: f64,
    pub terms: Vec<(usize, f64)>,
}

/// The design model of a deck.
#[derive(Debug, Clone, Default)]
pub(super) struct Design {
    pub variables: Vec<Variable>,
    pub relations: HashMap<(CardId, usize), Relation>,
    pub used: std::cell::RefCell<HashSet<(CardId, usize)>>,
    pub places: BTreeMap<(CardId, usize), CardId>,
    /// Relations to fields that are not properties of an element: offsets, coordinates.
    pub left: BTreeMap<String, usize>,
}

/// Number of the field that a name means on a card.
fn field_of(card: &str, name: &str) -> Option<usize> {
    let name = name.to_uppercase();
    let name = name.strip_suffix("(A)").unwrap_or(&name);
    // A number counts the fields with those of continuations, ten a line.
    if let Ok(n) = name.parse::<usize>() {
        let (line, column) = (n.checked_sub(1)? / 10, (n - 1) % 10 + 1);
        let field = 8 * line + column;
        return ((2..=9).contains(&column) && is_known(card, field)).then_some(field);
    }
    if let Some((what, ply)) = of_ply(name) {
        // Plies of PCOMP have four fields each, of PCOMPG a line.
        let (first, stride) = match card {
            "PCOMP" => (11, 4),
            "PCOMPG" => (12, 8),
            _ => return list_of(card).iter().find(|l| l.0 == name).map(|l| l.1),
        };
        return Some(first + stride * (ply - 1) + what);
    }
    list_of(card).iter().find(|l| l.0 == name).map(|l| l.1)
}

/// `T3` is the thickness of the third ply (0), `THETA3` its angle (1).
fn of_ply(name: &str) -> Option<(usize, usize)> {
    let (what, number) = match name.strip_prefix("THETA") {
        Some(number) => (1, number),
        None => (0, name.strip_prefix('T')?),
    };
    number.parse().ok().filter(|n| (1..=10_000).contains(n)).map(|n| (what, n))
}

/// Whether a field can follow variables.
fn is_known(card: &str, field: usize) -> bool {
    let is_of_ply = match card {
        "PCOMP" => field >= 10 && matches!((field - 10) % 4, 1 | 2),
        "PCOMPG" => field >= 10 && matches!((field - 10) % 8, 2 | 3),
        _ => false,
    };
    is_of_ply || list_of(card).iter().any(|l| l.1 == field)
}

/// Names of fields of a card that can follow variables.
fn list_of(card: &str) -> &'static [(&'static str, usize)] {
    match card {
        "PBEAM" => &[("A", 4), ("I1", 5), ("IZ", 5), ("I2", 6), ("IY", 6), ("I12", 7), ("J", 8), ("NSM", 9)],
        "PBAR" => &[("A", 4), ("I1", 5), ("I2", 6), ("J", 7), ("NSM", 8), ("K1", 18), ("K2", 19), ("I12", 20)],
        "PROD" => &[("A", 4), ("J", 5), ("NSM", 7)],
        "PSHELL" => &[("T", 4), ("12I/T**3", 6), ("TS/T", 8), ("NSM", 9)],
        "PBUSH" => &[("K1", 4), ("K2", 5), ("K3", 6), ("K4", 7), ("K5", 8), ("K6", 9)],
        "PELAS" => &[("K1", 3), ("K", 3), ("K2", 7)],
        "MAT1" => &[("E", 3), ("G", 4), ("NU", 5), ("RHO", 6)],
        "MAT8" => &[("E1", 3), ("E2", 4), ("NU12", 5), ("G12", 6), ("G1Z", 7), ("G2Z", 8), ("RHO", 9)],
        "CONM2" => &[
            ("M", 5),
            ("X1", 6),
            ("X2", 7),
            ("X3", 8),
            ("I11", 10),
            ("I21", 11),
            ("I22", 12),
            ("I31", 13),
            ("I32", 14),
            ("I33", 15),
        ],
        "CONM1" => &[
            ("M11", 5),
            ("M21", 6),
            ("M22", 7),
            ("M31", 8),
            ("M32", 9),
            ("M33", 10),
            ("M41", 11),
            ("M42", 12),
            ("M43", 13),
            ("M44", 14),
            ("M51", 15),
            ("M52", 16),
            ("M53", 17),
            ("M54", 18),
            ("M55", 19),
            ("M61", 20),
            ("M62", 21),
            ("M63", 22),
            ("M64", 23),
            ("M65", 24),
            ("M66", 25),
        ],
        "PMASS" | "CMASS2" => &[("M", 3)],
        "CELAS2" => &[("K", 3)],
        "CONROD" => &[("A", 6), ("J", 7), ("NSM", 9)],
        "PSHEAR" => &[("T", 4), ("NSM", 5)],
        "PCOMP" | "PCOMPG" => &[("Z0", 3), ("NSM", 4)],
        _ => &[],
    }
}

impl Design {
    pub(super) fn read(deck: &Deck) -> Result<Self, DeckError> {
        let mut design = Self::default();
        let mut by_id: HashMap<u32, usize> = HashMap::new();
        let mut taken: HashSet<String> = HashSet::new();
        let mut links = Vec::new();
        let mut wanted: HashMap<(&'static str, u32), Vec<CardId>> = HashMap::new();
        let mut equations: HashMap<u32, CardId> = HashMap::new();
        let mut constants: HashMap<String, f64> = HashMap::new();
        for id in deck.cards() {
            match deck.name(id) {
                "DESVAR" => {
                    let card = deck.card(id);
                    let number = card.id_at(2, "ID")?;
                    let label = card.text(3).to_string();
                    let mut name = slug(&label).unwrap_or_else(|| format!("x_{number}"));
                    if !taken.insert(name.clone()) {
                        name = format!("{name}_{number}");
                        taken.insert(name.clone());
                    }
                    let (value, low, high) =
                        (card.real(4, "XINIT")?, card.optional_real(5, "XLB")?, card.optional_real(6, "XUB")?);
                    let bounds = match (low, high) {
                        (None, None) => None,
                        (low, high) => Some([low.unwrap_or(-1e20), high.unwrap_or(1e20)]),
                    };
                    if let Some([low, high]) = bounds.filter(|[low, high]| !(*low <= value && value <= *high)) {
                        return Err(card.error(
                            Some((4, "XINIT")),
                            format_args!("{value} is not between the bounds {low} and {high}"),
                        ));
                    }
                    if by_id.insert(number, design.variables.len()).is_some() {
                        return Err(card.error(Some((2, "ID")), format_args!("DESVAR {number} is defined twice")));
                    }
                    design.variables.push(Variable { card: id, id: number, name, label, value, bounds });
                }
                "DLINK" => links.push(id),
                "DEQATN" => {
                    equations.insert(deck.card(id).id_at(2, "EQID")?, id);
                }
                "DTABLE" => {
                    let card = deck.card(id);
                    for n in (2..=card.len()).step_by(2).filter(|n| !card.is_blank(*n)) {
                        constants.insert(card.text(n).to_uppercase(), card.real(n + 1, "VALU")?);
                    }
                }
                "DVPREL1" | "DVMREL1" | "DVCREL1" | "DVPREL2" | "DVMREL2" | "DVCREL2" => {
                    let card = deck.card(id);
                    if let Some(kind) = known(card.text(3)) {
                        wanted.insert((kind, card.id_at(4, "ID")?), Vec::new());
                    }
                }
                _ => {}
            }
        }
        if design.variables.is_empty() {
            return Ok(design);
        }
        for id in deck.cards() {
            if let Some(kind) = known(deck.name(id)) {
                let number = deck.card(id).id_at(2, "ID")?;
                if let Some(list) = wanted.get_mut(&(kind, number)) {
                    list.push(id);
                }
            }
        }
        // A variable that follows others is written in these.
        let mut linked: HashMap<usize, Relation> = HashMap::new();
        for id in links {
            let card = deck.card(id);
            let find = |n: usize| -> Result<usize, DeckError> {
                let number = card.id_at(n, "DVID")?;
                by_id
                    .get(&number)
                    .copied()
                    .ok_or_else(|| card.error(Some((n, "DVID")), format_args!("there is no DESVAR {number}")))
            };
            let dependent = find(3)?;
            let (constant, factor) = (card.real_or(4, "C0", 0.0)?, card.real_or(5, "CMULT", 1.0)?);
            let mut terms = Vec::new();
            let mut n = 6;
            while n <= card.len() {
                if !card.is_blank(n) {
                    terms.push((find(n)?, factor * card.real(n + 1, "C")?));
                }
                n += 2;
            }
            linked.insert(dependent, Relation { constant, terms });
        }
        for id in deck.cards() {
            let name = deck.name(id);
            let expected = match name {
                "DVPREL1" | "DVPREL2" => "property",
                "DVMREL1" | "DVMREL2" => "material",
                "DVCREL1" | "DVCREL2" => "element",
                _ => continue,
            };
            let card = deck.card(id);
            let (kind, number) = (card.text(3).to_uppercase(), card.id_at(4, "ID")?);
            let field = known(&kind).and_then(|k| Some((k, field_of(&kind, card.text(5))?)));
            let Some((known_kind, field)) = field else {
                let what = format!("{name} to {} of {kind}", shown(card.text(5)));
                *design.left.entry(what).or_default() += 1;
                continue;
            };
            let targets = wanted.get(&(known_kind, number)).and_then(|t| t.first());
            let Some(&target) = targets else {
                return Err(card.error(Some((4, "ID")), format_args!("there is no {expected} {kind} {number}")));
            };
            let (constant, terms) =
                if name.ends_with('1') { weighted(&card)? } else { by_equation(deck, &card, &equations, &constants)? };
            let mut relation = Relation { constant, terms: Vec::new() };
            for (n, number, factor) in terms {
                let variable = by_id.get(&number).copied();
                let variable = variable
                    .ok_or_else(|| card.error(Some((n, "DVID")), format_args!("there is no DESVAR {number}")))?;
                match linked.get(&variable) {
                    Some(link) => {
                        relation.constant += factor * link.constant;
                        relation.terms.extend(link.terms.iter().map(|(v, c)| (*v, c * factor)));
                    }
                    None => relation.terms.push((variable, factor)),
                }
            }
            design.places.insert((target, field), id);
            design.relations.insert((target, field), relation);
        }
        Ok(design)
    }

    /// The expression of a field, if it follows variables.
    pub(super) fn expression(&self, card: CardId, field: usize, unit: &str, scale: f64) -> Option<String> {
        let relation = self.relations.get(&(card, field))?;
        self.used.borrow_mut().insert((card, field));
        let mut text = String::new();
        if relation.constant != 0.0 {
            text.push_str(&with_unit(&computed(relation.constant * scale), unit));
        }
        for (variable, factor) in &relation.terms {
            let factor = factor * scale;
            let size = with_unit(&computed(factor.abs()), unit);
            let sign = match (text.is_empty(), factor < 0.0) {
                (true, true) => "-",
                (true, false) => "",
                (false, true) => " - ",
                (false, false) => " + ",
            };
            let name = &self.variables[*variable].name;
            // A name that reads as a unit, such as t1, stands where no unit can.
            let product = match size.as_str() {
                "1" => name.clone(),
                _ if Unit::parse(name).is_ok() => format!("{name} * {size}"),
                _ => format!("{size} * {name}"),
            };
            text.push_str(&format!("{sign}{product}"));
        }
        Some(text)
    }
}

/// A constant, and field, number and factor of each variable.
type Weighted = (f64, Vec<(usize, u32, f64)>);

/// C0 and the variables with their factors, of DVPREL1 and its like.
fn weighted(card: &Card<'_>) -> Result<Weighted, DeckError> {
    let mut terms = Vec::new();
    for n in (10..=card.len()).step_by(2).filter(|n| !card.is_blank(*n)) {
        let factor = if card.text(n + 1).eq_ignore_ascii_case("PVAL") { 1.0 } else { card.real(n + 1, "COEF")? };
        terms.push((n, card.id_at(n, "DVID")?, factor));
    }
    Ok((card.real_or(8, "C0", 0.0)?, terms))
}

/// An argument of an equation: field and number of a variable, or a number.
enum Argument {
    Variable(usize, u32),
    Constant(f64),
}

/// The variables of DVPREL2 and its like, whose equation must be a sum of them.
fn by_equation(
    deck: &Deck,
    card: &Card<'_>,
    equations: &HashMap<u32, CardId>,
    constants: &HashMap<String, f64>,
) -> Result<Weighted, DeckError> {
    let number = card.id_at(8, "EQID")?;
    let at = Some((8, "EQID"));
    let found = equations.get(&number);
    let found = found.ok_or_else(|| card.error(at, format_args!("there is no DEQATN {number}")))?;
    let equation = super::equations::equation_of(deck, *found);
    let names = equation.arguments.clone();
    // DESVAR and DTABLE head their lists; the arguments stand in the order of the card.
    let mut arguments = Vec::new();
    let mut list = "";
    for n in 10..=card.len() {
        let text = card.text(n).to_uppercase();
        match (text.as_str(), list) {
            ("", _) => {}
            ("DESVAR", _) => list = "DESVAR",
            ("DTABLE", _) => list = "DTABLE",
            (_, "DESVAR") => arguments.push(Argument::Variable(n, card.id_at(n, "DVID")?)),
            (label, "DTABLE") => {
                let value = constants.get(label).copied();
                let value = value.ok_or_else(|| {
                    card.error(Some((n, "LABL")), format_args!("there is no constant {} in DTABLE", shown(label)))
                })?;
                arguments.push(Argument::Constant(value));
            }
            (other, _) => {
                let text = format!("`{}` where DESVAR or DTABLE is expected", shown(other));
                return Err(card.error(Some((n, "list")), text));
            }
        }
    }
    if arguments.len() != names.len() {
        let text = format!("DEQATN {number} has {} arguments, and the card gives {}", names.len(), arguments.len());
        return Err(card.error(at, text));
    }
    let (mut variables, mut order, mut given) = (Vec::new(), Vec::new(), Vec::new());
    for (name, argument) in names.into_iter().zip(arguments) {
        match argument {
            Argument::Variable(n, id) => {
                order.push(name);
                variables.push((n, id));
            }
            Argument::Constant(value) => given.push((name, value)),
        }
    }
    let found = super::equations::linear(&equation, &order, &given).map_err(|why| {
        let text =
            format!("DEQATN {number} is not a sum of its variables: {why}; a model has sums of parameters alone");
        card.error(at, text)
    })?;
    let terms = variables.into_iter().zip(found.factors).filter(|t| t.1 != 0.0);
    Ok((found.constant, terms.map(|((n, id), factor)| (n, id, factor)).collect()))
}

/// Kinds of cards that can follow a variable.
fn known(kind: &str) -> Option<&'static str> {
    const KINDS: [&str; 17] = [
        "PBEAM", "PBAR", "PROD", "PSHELL", "PSHEAR", "PCOMP", "PCOMPG", "PBUSH", "PELAS", "PMASS", "MAT1", "MAT8",
        "CONM2", "CONM1", "CMASS2", "CELAS2", "CONROD",
    ];
    KINDS.iter().find(|k| k.eq_ignore_ascii_case(kind)).copied()
}

fn shown(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).take(16).collect()
}
