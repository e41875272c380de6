//! BOUNDARY, of the model and of the steps up to the one that is read.

use super::importer::{Importer, Solver, word};
use super::scopes::At;
use crate::motions;
use crate::text::list;
use crate::writer::Block;
use retune::catalogue::did_you_mean;
use retune::deck::{DataLine, DeckError, Keyword};

/// Named types and the dofs that they hold, as digits.
const TYPES: &[(&str, &str)] = &[
    ("ENCASTRE", "123456"),
    ("PINNED", "123"),
    ("XSYMM", "156"),
    ("YSYMM", "246"),
    ("ZSYMM", "345"),
    ("XASYMM", "234"),
    ("YASYMM", "135"),
    ("ZASYMM", "126"),
];

/// Nodes held in some dofs.
struct Hold {
    name: String,
    nodes: Vec<At>,
    flags: [bool; 6],
}

impl Importer<'_> {
    /// The step that is read, from 0, where the deck has it: the one that was asked for, else the first with frequencies, else the first.
    pub(super) fn chosen_step(&self) -> Option<usize> {
        let steps = &self.all.steps;
        let has_frequencies = |i: &usize| steps[*i].iter().any(|k| self.deck.keyword(*k).name() == "FREQUENCY");
        let asked = self.options.subcase.map(|number| (number as usize).wrapping_sub(1));
        asked.or_else(|| (0..steps.len()).find(has_frequencies)).or(Some(0)).filter(|i| *i < steps.len())
    }
}

/// The step whose boundary holds, from 0; nothing where the deck has no steps.
fn chosen(importer: &mut Importer<'_>) -> Result<Option<usize>, DeckError> {
    let steps = &importer.all.steps;
    let has = |i: usize, name: &str| steps[i].iter().any(|k| importer.deck.keyword(*k).name() == name);
    let chosen = importer.chosen_step();
    if let Some(number) = importer.options.subcase {
        if chosen.is_none() {
            let file = importer.deck.sources()[0].name().to_string();
            let message = format!("there is no step {number}: the deck has {}", steps.len());
            return Err(DeckError { file, line: 0, card: "*STEP".into(), field: None, message });
        }
        return Ok(chosen);
    }
    let frequency: Vec<usize> = (0..steps.len()).filter(|i| has(*i, "FREQUENCY")).collect();
    let is_other = frequency.iter().skip(1).any(|i| has(*i, "BOUNDARY"));
    let first = frequency.first().copied();
    if is_other && let Some(first) = first {
        let text = format!("steps differ in their boundary; that of step {} is read, another is `--step N`", first + 1);
        importer.report.note(text);
    }
    if first.is_none() && !importer.all.steps.is_empty() {
        importer.report.note("no step asks for frequencies (FREQUENCY): the boundary of the first step is read");
    }
    Ok(chosen)
}

/// Writes the supports.
pub(super) fn write(importer: &mut Importer<'_>) -> Result<(), DeckError> {
    let chosen = chosen(importer)?;
    let mut keywords = importer.all.boundary.clone();
    let mut is_preloaded = false;
    for i in 0..=chosen.unwrap_or(0) {
        let (Some(last), Some(step)) = (chosen, importer.all.steps.get(i)) else { break };
        let head = importer.deck.keyword(step[0]);
        let is_perturbation = head.parameter("PERTURBATION").is_some();
        let is_nonlinear = head.parameter("NLGEOM").is_some_and(|v| !v.eq_ignore_ascii_case("NO"));
        is_preloaded |= match importer.options.solver {
            Solver::Abaqus => i < last && is_nonlinear,
            Solver::CalculiX => i == last && i > 0 && is_perturbation,
        };
        // What a perturbation holds, it holds alone.
        if i < last && is_perturbation {
            continue;
        }
        for index in step {
            let k = importer.deck.keyword(*index);
            if k.name() != "BOUNDARY" {
                continue;
            }
            if k.label("OP").is_some_and(|op| op == "NEW") {
                // The first of a step takes away what was there.
                keywords.retain(|known| step.contains(known));
            }
            keywords.push(*index);
        }
    }
    if is_preloaded {
        importer.report.approximate("the stress stiffening of the steps before the frequencies is left out");
    }
    let mut holds = Vec::new();
    for index in keywords {
        let k = importer.deck.keyword(index);
        read(importer, &k, &mut holds)?;
    }
    for hold in holds {
        importer.hold(&hold);
    }
    Ok(())
}

fn read(importer: &mut Importer<'_>, k: &Keyword<'_>, holds: &mut Vec<Hold>) -> Result<(), DeckError> {
    if let Some(p) = ["SUBMODEL", "USER"].into_iter().find(|p| k.parameter(p).is_some()) {
        return Err(k.error(format_args!("a boundary by {p} is not in the deck")));
    }
    // CAE writes the name of a condition above it: `Name: Ends Type: Symmetry/Antisymmetry/Encastre`.
    let named = k.comments().filter_map(|c| c.strip_prefix("Name:")).last();
    let named = named.map(|c| c.split(" Type:").next().unwrap_or(c).trim().to_string());
    let first = holds.len();
    for line in k.lines().filter(|l| !l.is_empty()) {
        let text = line.text(0);
        let nodes = importer.all.nodes(0, text).map_err(|m| line.error(Some((0, "nodes")), m))?;
        let (flags, has_others) = dofs(&line)?;
        if has_others {
            importer.report.note("BOUNDARY of temperatures, pressures and warping is left out");
        }
        if line.real_or(3, "magnitude", 0.0).unwrap_or(0.0) != 0.0 {
            importer.report.note("enforced motions of BOUNDARY are supports at rest: modes do not know them");
        }
        if flags == [false; 6] {
            continue;
        }
        // Lines of one set are one support.
        match holds[first..].iter_mut().find(|h| h.nodes == nodes) {
            Some(hold) => (0..6).for_each(|i| hold.flags[i] |= flags[i]),
            None => {
                let name = named.clone().unwrap_or_else(|| retune::deck::label(text));
                let name = word(&name, "boundary");
                holds.push(Hold { name, nodes, flags });
            }
        }
    }
    Ok(())
}

/// The dofs that a line holds, and whether it names others than displacements and rotations.
fn dofs(line: &DataLine<'_>) -> Result<([bool; 6], bool), DeckError> {
    let mut flags = [false; 6];
    let text = retune::deck::label(line.text(1));
    if text.starts_with(|c: char| c.is_ascii_alphabetic()) {
        let Some((_, held)) = TYPES.iter().find(|t| t.0 == text) else {
            let suggestion = did_you_mean(&text, TYPES.iter().map(|t| t.0));
            return Err(line.error(Some((1, "type")), format_args!("`{text}` is not a type of boundary{suggestion}")));
        };
        for digit in held.bytes() {
            flags[usize::from(digit - b'1')] = true;
        }
        return Ok((flags, false));
    }
    let first = line.id(1, "first dof")? as usize;
    let last = if line.text(2).is_empty() { first } else { line.id(2, "last dof")? as usize };
    if last < first {
        return Err(line.error(Some((2, "last dof")), "it must not be below the first"));
    }
    for dof in first..=last.min(6) {
        flags[dof - 1] = true;
    }
    Ok((flags, last > 6))
}

impl Importer<'_> {
    fn hold(&mut self, hold: &Hold) {
        let mut plain: Vec<(At, [bool; 6])> = Vec::new();
        let mut turned = Vec::new();
        for node in &hold.nodes {
            let mut flags = hold.flags;
            let tied = self.tied_dofs(*node);
            if (0..6).any(|c| flags[c] && tied[c]) {
                (0..6).for_each(|c| flags[c] &= !tied[c]);
                self.report.note("supports of nodes that follow a TIE are left out, as the solver does");
            }
            if flags == [false; 6] {
                continue;
            }
            if motions::is_whole(flags) || self.placed(*node).is_global() {
                plain.push((*node, flags));
            } else {
                turned.push((*node, flags));
            }
        }
        while let Some(flags) = plain.first().map(|p| p.1) {
            let (now, later): (Vec<_>, Vec<_>) = plain.into_iter().partition(|p| p.1 == flags);
            plain = later;
            let names: Vec<String> = now.iter().map(|p| self.node_name(p.0)).collect();
            let nodes =
                if names.len() == 1 { format!("node: {}", names[0]) } else { format!("nodes: {}", list(&names)) };
            let fixed = if flags == [true; 6] { String::new() } else { format!(", fixed: {}", motions::dofs(flags)) };
            let name = self.link_names.unique(&hold.name);
            self.entry(Block::Supports, &name, &format!("{{{nodes}{fixed}}}"));
        }
        for (node, flags) in turned {
            let (name, placed) = (self.node_name(node), self.placed(node));
            for component in (0..6).filter(|c| flags[*c]) {
                let terms = placed.component(component).into_iter().map(|(d, f)| (name.clone(), d, f)).collect();
                self.constraint(&format!("{}_{name}_{}", hold.name, component + 1), terms);
            }
        }
    }
}
