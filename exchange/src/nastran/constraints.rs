//! Supports and multipoint constraints.

use super::importer::{Grid, Importer, node};
use super::{CardRule, left_out, read, refused, used};
use crate::motions;
use crate::system::Quantity;
use crate::writer::Block;
use retune::deck::{Card, DeckError};
use retune::element::Dof;
use std::collections::{HashMap, HashSet};

pub(super) const CARDS: &[CardRule] = &[
    read("SPC", "supports", spc),
    read("SPC1", "supports", spc1),
    used("SPCADD", "supports"),
    read("MPC", "constraints", mpc),
    used("MPCADD", "constraints"),
    left_out("SUPORT", "reference of rigid-body modes: those are found by geometry"),
    left_out("SUPORT1", "reference of rigid-body modes: those are found by geometry"),
    left_out("SPCOFF", "exceptions to AUTOSPC"),
    left_out("SPCOFF1", "exceptions to AUTOSPC"),
    refused("SPCR", "enforced motion in nonlinear solutions is not read"),
    refused("MPCAX", "axisymmetric constraints are not read"),
];

impl Importer<'_> {
    /// Which sets of SPC and MPC the subcase chooses, sums of sets resolved.
    pub(super) fn choose_sets(&mut self) -> Result<(), DeckError> {
        let deck = self.deck;
        let case = deck.case_control();
        let has_case = !case.subcases.is_empty() || !case.above.commands.is_empty();
        if let Some(id) = self.options.subcase {
            if !case.subcases.iter().any(|s| s.id == id) {
                let known: Vec<String> = case.subcases.iter().map(|s| s.id.to_string()).collect();
                let known = if known.is_empty() { "none".to_string() } else { known.join(", ") };
                let message = format!("there is no subcase {id} (there are: {known})");
                let file = deck.sources()[0].name().to_string();
                return Err(DeckError { file, line: 0, card: "SUBCASE".into(), field: None, message });
            }
        } else if case.subcases.len() > 1 {
            let differ = |word: &str| {
                let all: HashSet<Option<&str>> = case.subcases.iter().map(|s| case.value(word, Some(s.id))).collect();
                all.len() > 1
            };
            if differ("SPC") || differ("MPC") {
                let ids: Vec<String> = case.subcases.iter().map(|s| s.id.to_string()).collect();
                self.report.note(format!(
                    "subcases {} have different constraints; those of {} are read, another is `--subcase N`",
                    ids.join(", "),
                    ids[0]
                ));
            }
        }
        for (word, sum, members) in [("SPC", "SPCADD", ["SPC", "SPC1"]), ("MPC", "MPCADD", ["MPC", "MPC"])] {
            let mut sums: HashMap<u32, Vec<u32>> = HashMap::new();
            let mut present: HashSet<u32> = HashSet::new();
            for id in deck.cards() {
                let name = deck.name(id);
                if name == sum {
                    let card = deck.card(id);
                    sums.entry(card.id_at(2, "SID")?).or_default().extend(card.ids_from(3, "S")?);
                } else if members.contains(&name) {
                    present.insert(deck.card(id).id_at(2, "SID")?);
                }
            }
            let chosen = case.value(word, self.options.subcase).and_then(|v| v.trim().parse::<u32>().ok());
            let mut set = HashSet::new();
            if let Some(id) = chosen {
                let mut open = vec![id];
                while let Some(id) = open.pop() {
                    if set.insert(id) {
                        open.extend(sums.get(&id).into_iter().flatten());
                    }
                }
                if !present.iter().any(|p| set.contains(p)) {
                    self.report.note(format!("case control chooses {word} {id}, and the deck has no such set"));
                }
            } else if !present.is_empty() {
                let mut ids: Vec<u32> = present.into_iter().collect();
                ids.sort_unstable();
                let ids: Vec<String> = ids.iter().map(u32::to_string).collect();
                let why =
                    if has_case { "no subcase chooses them" } else { "the deck has no case control that chooses them" };
                self.report.note(format!("sets {} of {word} are left out: {why}", ids.join(", ")));
            }
            if word == "SPC" {
                self.spc = set;
            } else {
                self.mpc = set;
            }
        }
        Ok(())
    }

    /// Holds components of nodes.
    pub(super) fn hold(&mut self, name: &str, nodes: &[(String, Grid)], flags: [bool; 6]) {
        let all = flags.iter().all(|f| *f);
        // Components along global axes, all three of a kind, or else rows of their own.
        let plain: Vec<&String> =
            nodes.iter().filter(|(_, g)| motions::is_whole(flags) || self.is_global(g)).map(|n| &n.0).collect();
        if !plain.is_empty() {
            let nodes = if plain.len() == 1 {
                format!("node: {}", plain[0])
            } else {
                format!("nodes: {}", crate::text::list(&plain))
            };
            let fixed = if all { String::new() } else { format!(", fixed: {}", motions::dofs(flags)) };
            let name = self.names.unique(name);
            self.entry(Block::Supports, &name, &format!("{{{nodes}{fixed}}}"), "");
        }
        let turned: Vec<(String, Grid)> = nodes.iter().filter(|(n, _)| !plain.contains(&n)).cloned().collect();
        for (node, grid) in turned {
            for component in (0..6).filter(|c| flags[*c]) {
                let terms =
                    self.component(&grid, component).into_iter().map(|(dof, f)| (node.clone(), dof, f)).collect();
                self.constraint(&format!("{name}_{node}_{}", component + 1), terms);
            }
        }
    }

    /// Writes Σ factor · dof = 0.
    pub(super) fn constraint(&mut self, name: &str, terms: Vec<(String, Dof, f64)>) {
        let metre = self.options.system.factor(Quantity::Length);
        let value = motions::constraint(terms, metre);
        let name = self.names.unique(name);
        self.entry(Block::Constraints, &name, &value, "");
    }
}

fn spc(importer: &mut Importer<'_>, card: &Card<'_>) -> Result<(), DeckError> {
    let sid = card.id_at(2, "SID")?;
    let (mut all, mut scalars) = (Vec::new(), Vec::new());
    for first in [3, 6] {
        if card.is_blank(first) {
            continue;
        }
        let id = card.id_at(first, "G")?;
        if importer.is_scalar_point(id) {
            scalars.push(id);
            continue;
        }
        let grid = importer.grid_of(card, first, "G", id)?;
        let flags = card.components(first + 1, "C")?;
        if card.real_or(first + 2, "D", 0.0)? != 0.0 {
            importer.report.note("enforced displacements of SPC are supports at rest: modes do not know them");
        }
        all.push((grid, flags));
    }
    if importer.spc.contains(&sid) {
        for (grid, flags) in all {
            importer.hold(&format!("spc_{sid}"), &[grid], flags);
        }
        for id in scalars {
            importer.hold_scalar_point(&format!("spc_{sid}"), id);
        }
    }
    Ok(())
}

fn spc1(importer: &mut Importer<'_>, card: &Card<'_>) -> Result<(), DeckError> {
    let sid = card.id_at(2, "SID")?;
    let flags = card.components(3, "C")?;
    let ids = card.ids_from(4, "G")?;
    if !importer.spc.contains(&sid) {
        return Ok(());
    }
    // Of a range those that exist count.
    let is_range = (4..=card.len()).any(|n| card.text(n).eq_ignore_ascii_case("THRU"));
    let mut nodes = Vec::new();
    for id in ids {
        match importer.known_grid(id).copied() {
            Some(grid) => nodes.push((node(id), grid)),
            None if importer.is_scalar_point(id) => importer.hold_scalar_point(&format!("spc1_{sid}"), id),
            None if is_range => {}
            None => return Err(card.error(Some((4, "G")), format_args!("there is no GRID {id}"))),
        }
    }
    if !nodes.is_empty() && flags.iter().any(|f| *f) {
        importer.hold(&format!("spc1_{sid}"), &nodes, flags);
    }
    Ok(())
}

fn mpc(importer: &mut Importer<'_>, card: &Card<'_>) -> Result<(), DeckError> {
    let sid = card.id_at(2, "SID")?;
    let mut terms: Vec<(String, Dof, f64)> = Vec::new();
    let mut field = 3;
    while field <= card.len() {
        if !card.is_blank(field) {
            let Some(end) = importer.end(card, (field, Some(field + 1)), "G")? else {
                return Err(card.error(Some((field, "G")), "a grid or a scalar point is expected"));
            };
            let factor = card.real(field + 2, "A")?;
            terms.extend(end.terms.iter().map(|(dof, f)| (end.node.clone(), *dof, f * factor)));
        }
        // Two terms a line: the first of a line begins at its third field, of later lines too.
        field += if (field - 3) % 8 == 0 { 3 } else { 5 };
    }
    if importer.mpc.contains(&sid) && !terms.is_empty() {
        importer.constraint(&format!("mpc_{sid}"), terms);
    }
    Ok(())
}
