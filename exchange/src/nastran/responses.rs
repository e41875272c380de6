//! Responses of SOL 200: what DRESP1, DRESP2 with DEQATN, DCONSTR and DESOBJ ask for, as targets of the model and as a test file.
//!
//! An interval of a constraint becomes a target with its half as tolerance (masses, centre of gravity) or as standard deviation
//! (frequencies, components of eigenvectors). An objective Σ w ((r - c)/c)² becomes one residual a term: r of c, with the standard deviation c/√w. What is of another
//! form is left out by name. A frequency with both has the value of its goal and the smaller deviation.

use super::asked::{Asked, At};
use super::eigenvectors::{self, Norm};
use super::importer::Importer;
use crate::system::Quantity as Q;
use crate::text::{computed, with_unit};
use crate::writer::Block;
use retune::deck::{Card, CardId, Deck, DeckError};
use std::collections::{BTreeMap, HashMap};
use std::f64::consts::TAU;

/// What a response measures.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Response {
    /// Frequency of a mode of the solver, Hz.
    Frequency(u32),
    /// ω² of a mode of the solver, (rad/s)².
    Eigenvalue(u32),
    /// Mass in the deck's unit of mass.
    Mass,
    /// Coordinate of the centre of gravity from the reference point.
    Centre(usize),
    /// Moment of inertia about the reference point.
    Inertia(usize),
    /// Component of the eigenvector of a mode of the solver, as it is normalised, or relative to another component.
    Shape(u32, At, Option<At>),
}

/// One target: response, value, half-width.
type Target = (Response, f64, f64);

impl Importer<'_> {
    /// Writes targets into the model, and gives the frequencies and components of eigenvectors that are asked for.
    pub(super) fn responses(&mut self) -> Result<Asked, DeckError> {
        let deck = self.deck;
        let mut first: HashMap<u32, CardId> = HashMap::new();
        let mut second: HashMap<u32, CardId> = HashMap::new();
        let mut equations: HashMap<u32, CardId> = HashMap::new();
        let mut limits: Vec<CardId> = Vec::new();
        let mut sums: HashMap<u32, Vec<u32>> = HashMap::new();
        for id in deck.cards() {
            let number = || deck.card(id).id_at(2, "ID");
            match deck.name(id) {
                "DRESP1" => drop(first.insert(number()?, id)),
                "DRESP2" => drop(second.insert(number()?, id)),
                "DEQATN" => drop(equations.insert(number()?, id)),
                "DCONSTR" => limits.push(id),
                "DCONADD" => sums.entry(number()?).or_default().extend(deck.card(id).ids_from(3, "DC")?),
                _ => {}
            }
        }
        if first.is_empty() && second.is_empty() {
            return Ok(Asked::default());
        }
        let case = deck.case_control();
        let command =
            |words: [&str; 2]| words.iter().find_map(|w| case.value(w, self.options.subcase)?.parse::<u32>().ok());
        let (set, objective) = (command(["DESSUB", "DESGLB"]), command(["DESOBJ", "DESOBJ"]));
        let mut chosen: Vec<u32> = set.into_iter().collect();
        chosen.extend(set.and_then(|s| sums.get(&s)).into_iter().flatten());
        let meanings = |id: u32| -> Result<Vec<Response>, DeckError> {
            if let Some(card) = first.get(&id) {
                return simple(&deck.card(*card));
            }
            let Some(card) = second.get(&id) else { return Ok(Vec::new()) };
            let (arguments, text) = equation(&deck.card(*card), &equations, deck)?;
            Ok(ratio(&arguments, &text, &first, deck)?.into_iter().collect())
        };
        let meaning = |id: u32| -> Result<Option<Response>, DeckError> {
            Ok(match meanings(id)?.as_slice() {
                [only] => Some(*only),
                _ => None,
            })
        };
        let mut targets: Vec<Target> = Vec::new();
        let mut left: BTreeMap<CardId, String> = BTreeMap::new();
        for id in limits {
            let card = deck.card(id);
            if !chosen.contains(&card.id_at(2, "DCID")?) {
                continue;
            }
            let response = card.id_at(3, "RID")?;
            let (low, high) = (card.optional_real(4, "LALLOW")?, card.optional_real(5, "UALLOW")?);
            match (meaning(response)?, low, high) {
                (Some(Response::Eigenvalue(mode)), Some(low), Some(high)) if (0.0..=high).contains(&low) => {
                    let [low, high] = [low, high].map(|l| l.sqrt() / TAU);
                    targets.push((Response::Frequency(mode), 0.5 * (low + high), 0.5 * (high - low)));
                }
                (Some(Response::Eigenvalue(_)), ..) => drop(left.insert(id, format!("DCONSTR on response {response}"))),
                (_, Some(low), Some(high)) if low <= high => {
                    let all = meanings(response)?;
                    if all.is_empty() {
                        left.insert(id, format!("DCONSTR on response {response}"));
                    }
                    targets.extend(all.into_iter().map(|r| (r, 0.5 * (low + high), 0.5 * (high - low))));
                }
                _ => drop(left.insert(id, format!("DCONSTR on response {response}"))),
            }
        }
        let mut goals: Vec<Target> = Vec::new();
        if let Some(id) = objective {
            match second.get(&id) {
                Some(card) => {
                    let (arguments, text) = equation(&deck.card(*card), &equations, deck)?;
                    for term in terms(&text) {
                        let known = square(&term).and_then(|(w, name, c)| {
                            let at = arguments.names.iter().position(|n| *n == name)?;
                            Some((w, arguments.ids.get(at)?.1, c))
                        });
                        match known {
                            Some((w, response, c)) if w > 0.0 && c != 0.0 => match meaning(response)? {
                                // ω² changes by twice the share of ω.
                                Some(Response::Eigenvalue(mode)) if c > 0.0 => {
                                    let hz = c.sqrt() / TAU;
                                    goals.push((Response::Frequency(mode), hz, 0.5 * hz / w.sqrt()));
                                }
                                Some(r) => goals.push((r, c, c.abs() / w.sqrt())),
                                None => drop(left.insert(*card, format!("term `{term}` of objective {id}"))),
                            },
                            _ => drop(left.insert(*card, format!("term `{term}` of objective {id}"))),
                        }
                    }
                }
                None => self
                    .report
                    .note(format!("objective {id} is not a sum of squares of a DRESP2; the update minimises its own")),
            }
        }
        for what in left.into_values() {
            self.report.note(format!("{what} is left out: no target of an update has its form"));
        }
        self.write_targets(&targets, &goals);
        let mut asked = Asked::default();
        let norm = eigenvectors::norm(deck, self.options.subcase)?;
        // A goal is the value; an interval beside it says how sharply.
        for &(response, value, half) in targets.iter().chain(&goals) {
            match response {
                Response::Frequency(mode) => {
                    let sharpest = asked.frequencies.get(&mode).map_or(half, |known| known.1.min(half));
                    asked.frequencies.insert(mode, (value, sharpest));
                }
                Response::Shape(mode, at, relative_to) => {
                    self.ask_for_component(&mut asked, norm, (mode, at, relative_to), (value, half));
                }
                _ => {}
            }
        }
        Ok(asked)
    }

    fn ask_for_component(
        &mut self,
        asked: &mut Asked,
        norm: Norm,
        what: (u32, At, Option<At>),
        (value, half): (f64, f64),
    ) {
        let own = self.eigenvector(norm, what, (value, half));
        let own = own.and_then(|c| if half > 0.0 { Ok(c) } else { Err("its interval has no width".to_string()) });
        let component = match own {
            Ok(component) => component,
            Err(why) => {
                let (mode, at, _) = what;
                let text = format!(
                    "component {} of grid {} in the eigenvector of mode {mode} is not a target: {why}",
                    at.component + 1,
                    at.grid
                );
                self.report.note(text);
                return;
            }
        };
        for at in std::iter::once(component.at).chain(component.relative_to) {
            if let Some(grid) = self.known_grid(at.grid).copied() {
                asked.axes.insert(at.grid, self.displacement_axes(&grid));
            }
        }
        let is_same = |c: &super::asked::Component| {
            (c.mode, c.at, c.relative_to) == (component.mode, component.at, component.relative_to)
        };
        match asked.components.iter_mut().find(|c| is_same(c)) {
            // A goal is the value; an interval beside it says how sharply.
            Some(known) => (known.value, known.half) = (component.value, known.half.min(component.half)),
            None => asked.components.push(component),
        }
    }

    fn write_targets(&mut self, targets: &[Target], goals: &[Target]) {
        let reference =
            self.params.get("GRDPNT").and_then(|v| v.parse().ok()).and_then(|id| self.known_grid(id).copied());
        let at = reference.map_or([0.0; 3], |g| g.position);
        let mut cg = Vec::new();
        let mut mass = None;
        for &(response, value, half) in targets.iter().chain(goals) {
            let show = |v: f64, q: Q| with_unit(&computed(v), self.unit(q));
            let of = |v: f64, q: Q, half: f64| format!("{{value: {}, tolerance: {}}}", show(v, q), show(half, q));
            match response {
                Response::Mass if mass.is_none() => mass = Some(of(value * self.wtmass, Q::Mass, half * self.wtmass)),
                Response::Centre(i) => {
                    let name = ["x", "y", "z"][i];
                    if !cg.iter().any(|c: &String| c.starts_with(name)) {
                        cg.push(format!("{name}: {}", of(value + at[i], Q::Length, half)));
                    }
                }
                Response::Inertia(_) => {
                    self.report.note("moments of inertia about the reference point are not targets: those of a model are about its centre of gravity");
                }
                _ => {}
            }
        }
        if let Some(mass) = mass {
            self.out.entry(Block::Targets, "total_mass", &mass, "");
        }
        if !cg.is_empty() {
            self.out.entry(Block::Targets, "cg", &format!("{{{}}}", cg.join(", ")), "");
        }
    }
}

/// What a DRESP1 measures, as far as targets can be that.
fn simple(card: &Card<'_>) -> Result<Vec<Response>, DeckError> {
    let one = |r: Option<Response>| r.into_iter().collect();
    Ok(match card.text(4).to_uppercase().as_str() {
        "EIGN" => one(card.optional_id(7, "ATTA")?.map(Response::Eigenvalue)),
        "FREQ" => one(card.optional_id(7, "ATTA")?.map(Response::Frequency)),
        "WEIGHT" => one(match (card.integer_or(7, "ROW", 3)?, card.integer_or(8, "COL", 3)?) {
            (1, 1) | (2, 2) | (3, 3) => Some(Response::Mass),
            (i @ 4..=6, j) if i == j => Some(Response::Inertia(i as usize - 4)),
            _ => None,
        }),
        "DISP" => match eigenvectors::components(card)? {
            Some((mode, all)) => all.into_iter().map(|at| Response::Shape(mode, at, None)).collect(),
            None => Vec::new(),
        },
        _ => Vec::new(),
    })
}

/// Names and responses of an equation.
#[derive(Debug, Default)]
struct Arguments {
    names: Vec<String>,
    /// Kind and number, in the order of the card.
    ids: Vec<(String, u32)>,
}

/// The arguments of a DRESP2 and the right side of its equation, without blanks, in capitals.
fn equation(card: &Card<'_>, equations: &HashMap<u32, CardId>, deck: &Deck) -> Result<(Arguments, String), DeckError> {
    let number = card.id_at(4, "EQID")?;
    let found = equations.get(&number);
    let found = found.ok_or_else(|| card.error(Some((4, "EQID")), format_args!("there is no DEQATN {number}")))?;
    let equation = super::equations::equation_of(deck, *found);
    let mut out = Arguments { names: equation.arguments, ids: Vec::new() };
    let mut kind = String::new();
    for n in 10..=card.len() {
        let text = card.text(n).to_uppercase();
        match text.parse::<u32>() {
            Ok(id) => out.ids.push((kind.clone(), id)),
            Err(_) if !text.is_empty() => kind = text,
            Err(_) => {}
        }
    }
    Ok((out, equation.text))
}

/// R2/R1 of the first moment and the mass, a coordinate of the centre of gravity; or of two components of one eigenvector.
fn ratio(
    arguments: &Arguments,
    text: &str,
    first: &HashMap<u32, CardId>,
    deck: &Deck,
) -> Result<Option<Response>, DeckError> {
    let Some((above, below)) = text.split_once('/') else { return Ok(None) };
    let card = |name: &str| {
        let at = arguments.names.iter().position(|n| n == name)?;
        arguments.ids.get(at).and_then(|i| first.get(&i.1)).map(|id| deck.card(*id))
    };
    let (Some(above), Some(below)) = (card(above), card(below)) else { return Ok(None) };
    if let ([Response::Shape(mode, at, _)], [Response::Shape(other, to, _)]) =
        (simple(&above)?.as_slice(), simple(&below)?.as_slice())
    {
        return Ok((mode == other && at != to).then_some(Response::Shape(*mode, *at, Some(*to))));
    }
    let entry = |card: &Card<'_>| -> Result<Option<(i64, i64)>, DeckError> {
        if !card.text(4).eq_ignore_ascii_case("WEIGHT") {
            return Ok(None);
        }
        Ok(Some((card.integer_or(7, "ROW", 3)?, card.integer_or(8, "COL", 3)?)))
    };
    Ok(match (entry(&above)?, entry(&below)?) {
        (Some((2, 6) | (6, 2)), Some((i, j))) if i == j && i <= 3 => Some(Response::Centre(0)),
        (Some((3, 4) | (4, 3)), Some((i, j))) if i == j && i <= 3 => Some(Response::Centre(1)),
        (Some((1, 5) | (5, 1)), Some((i, j))) if i == j && i <= 3 => Some(Response::Centre(2)),
        _ => None,
    })
}

/// The terms of a sum, outside of brackets.
fn terms(text: &str) -> Vec<String> {
    let (mut depth, mut out, mut last) = (0, vec![String::new()], ' ');
    for c in text.chars() {
        match c {
            '(' => depth += 1,
            ')' => depth -= 1,
            // The sign of an exponent is none of a term.
            '+' if depth == 0 && !matches!(last, 'E' | 'D' | '*' | '/') => {
                out.push(String::new());
                last = c;
                continue;
            }
            _ => {}
        }
        if let Some(term) = out.last_mut() {
            term.push(c);
        }
        last = c;
    }
    out.retain(|t| !t.is_empty());
    out
}

/// w ((NAME - c)/c)**2 as (w, NAME, c).
fn square(term: &str) -> Option<(f64, String, f64)> {
    let number = |t: &str| retune::deck::parse_real(t).or_else(|| t.parse::<f64>().ok()).filter(|v| v.is_finite());
    let body = term.strip_suffix("**2").or_else(|| term.strip_suffix("**2."))?;
    let open = body.find("((")?;
    let weight = match &body[..open] {
        "" => 1.0,
        w => number(w.strip_suffix('*')?)?,
    };
    let (inside, divisor) = body[open + 2..].strip_suffix(')')?.split_once(")/")?;
    let (name, c) = inside.split_once('-')?;
    let (c, divisor) = (number(c)?, number(divisor)?);
    ((c - divisor).abs() <= 1e-6 * c.abs()).then(|| (weight, name.to_string(), c))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_of_relative_errors_are_found_in_a_sum() {
        let text = "1.*((W-13.76)/13.76)**2+((IXX-9560.0)/9560.0)**2+100.0*((F1-7.9)/7.9)**2+F2*F1";
        let found: Vec<_> = terms(text).iter().map(|t| square(t)).collect();
        assert_eq!(found[0], Some((1.0, "W".to_string(), 13.76)));
        assert_eq!(found[2], Some((100.0, "F1".to_string(), 7.9)));
        assert_eq!((found.len(), &found[3]), (4, &None));
        assert_eq!(square("((X-1.0)/2.0)**2"), None);
    }
}
