//! Rigid and interpolating elements.

use super::importer::{Grid, Importer};
use super::{CardRule, read, refused};
use crate::motions;
use crate::text::{exact, list};
use crate::writer::Block;
use retune::deck::{Card, DeckError};
use retune::element::Dof;
use retune::linalg::DMatrix;
use retune::linalg::vector3::{minus, unit};
use retune::model::rigid_motion;

pub(super) const CARDS: &[CardRule] = &[
    read("RBE2", "rigid links", rbe2),
    read("RBE3", "weighted links", rbe3),
    read("RBAR", "rigid links", rbar),
    read("RBE1", "rigid links", rbe1),
    refused("RBE2GS", "rigid elements that search their grids are not read; give an RBE2"),
    read("RBAR1", "rigid links", rbar1),
    read("RROD", "rigid links", rrod),
    refused("RTRPLT", "rigid triangles are not read; give an RBE1"),
    refused("RSPLINE", "splines of displacements are not read; give an RBE3"),
    refused("RSSCON", "connectors of shells and solids are not read; give an RBE3"),
    refused("RJOINT", "rigid joints are not read; give an RBE2 with the components that are held"),
];

/// A node with its grid, and some of its components.
type Component = ((String, Grid), [bool; 6]);

const ALL: [bool; 6] = [true; 6];

impl Importer<'_> {
    /// Slaves that follow a master in some components of their own axes.
    fn link(&mut self, name: &str, (master, lead): &(String, Grid), slaves: &[(String, Grid)], flags: [bool; 6]) {
        // Three components of a kind are the same in any axes.
        let (plain, turned): (Vec<_>, Vec<_>) =
            slaves.iter().cloned().partition(|(_, g)| motions::is_whole(flags) || self.is_global(g));
        if !plain.is_empty() {
            let nodes: Vec<&String> = plain.iter().map(|s| &s.0).collect();
            let dofs = if flags == ALL { String::new() } else { format!(", dofs: {}", motions::dofs(flags)) };
            let name = self.names.unique(name);
            self.entry(Block::RigidLinks, &name, &format!("{{master: {master}, slaves: {}{dofs}}}", list(&nodes)), "");
        }
        for (slave, grid) in turned {
            let placed = self.placed(&grid);
            for component in (0..6).filter(|c| flags[*c]) {
                let terms = motions::follows((&slave, &placed), (master, lead.position), component);
                self.constraint(&format!("{name}_{slave}_{}", component + 1), terms);
            }
        }
    }
}

fn rbe2(importer: &mut Importer<'_>, card: &Card<'_>) -> Result<(), DeckError> {
    let eid = card.id_at(2, "EID")?;
    let master = importer.grid(card, 3, "GN")?;
    let flags = card.components(4, "CM")?;
    let mut end = card.len();
    // The last field may be a coefficient of thermal expansion.
    if end >= 5 && card.text(end).contains('.') {
        card.real(end, "ALPHA")?;
        end -= 1;
    }
    let mut slaves = Vec::new();
    let ids = card.ids_from(5, "GM").or_else(|e| if end < card.len() { ids_until(card, 5, end) } else { Err(e) })?;
    for id in ids {
        slaves.push(importer.grid_of(card, 5, "GM", id)?);
    }
    if slaves.is_empty() || !flags.iter().any(|f| *f) {
        return Err(card.error(Some((5, "GM")), "it needs components and grids that follow"));
    }
    importer.link(&format!("rbe2_{eid}"), &master, &slaves, flags);
    Ok(())
}

fn ids_until(card: &Card<'_>, first: usize, last: usize) -> Result<Vec<u32>, DeckError> {
    let mut ids = Vec::new();
    for n in first..=last {
        ids.extend(card.optional_id(n, "GM")?);
    }
    Ok(ids)
}

/// One grid with components after the other, from a field on to a word.
fn pairs(
    importer: &Importer<'_>,
    card: &Card<'_>,
    (mut n, last): (usize, usize),
    name: &'static str,
) -> Result<Vec<Component>, DeckError> {
    let mut out = Vec::new();
    while n <= last {
        if card.is_blank(n) {
            n += 1;
            continue;
        }
        let grid = importer.grid(card, n, name)?;
        out.push((grid, card.components(n + 1, "C")?));
        n += 2;
    }
    Ok(out)
}

fn rbe3(importer: &mut Importer<'_>, card: &Card<'_>) -> Result<(), DeckError> {
    let eid = card.id_at(2, "EID")?;
    let (node, reference) = importer.grid(card, 4, "REFGRID")?;
    let flags = card.components(5, "REFC")?;
    let mut sets: Vec<String> = Vec::new();
    let mut at = 6;
    let last = card.len();
    while at <= last {
        let text = card.text(at).to_uppercase();
        if text.is_empty() {
            at += 1;
            continue;
        }
        if text == "UM" || text == "ALPHA" {
            // Which dofs are eliminated changes nothing of the motion.
            break;
        }
        let weight = card.real(at, "WT")?;
        let components = card.components(at + 1, "C")?;
        at += 2;
        let mut nodes = Vec::new();
        while at <= last
            && !card.text(at).contains('.')
            && !matches!(card.text(at).to_uppercase().as_str(), "UM" | "ALPHA")
        {
            if !card.is_blank(at) {
                let (name, grid) = importer.grid(card, at, "G")?;
                let is_whole = |first: usize| {
                    components[first] == components[first + 1] && components[first] == components[first + 2]
                };
                let is_plain = importer.is_global(&grid) || (is_whole(0) && is_whole(3));
                if !is_plain {
                    return Err(card.error(
                        Some((at, "G")),
                        "some components of a grid in axes of its own are not read; give 123 or 123456",
                    ));
                }
                nodes.push(name);
            }
            at += 1;
        }
        if weight == 0.0 || nodes.is_empty() {
            continue;
        }
        if weight < 0.0 {
            return Err(card.error(Some((at, "WT")), "a negative weight is not read"));
        }
        let weight = if weight == 1.0 { String::new() } else { format!(", weight: {}", exact(weight)) };
        let dofs = if components == [true, true, true, false, false, false] {
            String::new()
        } else {
            format!(", dofs: {}", motions::dofs(components))
        };
        sets.push(format!("{{nodes: {}{weight}{dofs}}}", list(&nodes)));
    }
    if sets.is_empty() {
        return Err(card.error(Some((6, "WT1")), "it follows no grids"));
    }
    if !importer.is_global(&reference) && flags != ALL && flags != [true, true, true, false, false, false] {
        return Err(card.error(
            Some((5, "REFC")),
            "some components of a grid in axes of its own are not read; give 123 or 123456",
        ));
    }
    let dofs = if flags == ALL { String::new() } else { format!(", dofs: {}", motions::dofs(flags)) };
    let name = importer.names.unique(&format!("rbe3_{eid}"));
    importer.entry(Block::WeightedLinks, &name, &format!("{{node: {node}{dofs}, of: {}}}", list(&sets)), "");
    Ok(())
}

fn rbar(importer: &mut Importer<'_>, card: &Card<'_>) -> Result<(), DeckError> {
    let eid = card.id_at(2, "EID")?;
    let (a, b) = (importer.grid(card, 3, "GA")?, importer.grid(card, 4, "GB")?);
    let (cna, cnb) = (card.components(5, "CNA")?, card.components(6, "CNB")?);
    let (mut cma, mut cmb) = (card.components(7, "CMA")?, card.components(8, "CMB")?);
    if cma == [false; 6] && cmb == [false; 6] {
        // What leads not, follows.
        (cma, cmb) = (cna.map(|f| !f), cnb.map(|f| !f));
    }
    let name = format!("rbar_{eid}");
    match (cna == ALL, cnb == ALL) {
        (true, false) if cnb == [false; 6] => importer.link(&name, &a, &[b], cmb),
        (false, true) if cna == [false; 6] => importer.link(&name, &b, &[a], cma),
        _ => {
            let lead = vec![(a.clone(), cna), (b.clone(), cnb)];
            return general(importer, card, &name, &lead, &[(a, cma), (b, cmb)]);
        }
    }
    Ok(())
}

/// RBAR1: the components CB of the second grid follow all six of the first.
fn rbar1(importer: &mut Importer<'_>, card: &Card<'_>) -> Result<(), DeckError> {
    let eid = card.id_at(2, "EID")?;
    let (a, b) = (importer.grid(card, 3, "GA")?, importer.grid(card, 4, "GB")?);
    let flags = if card.is_blank(5) { ALL } else { card.components(5, "CB")? };
    importer.link(&format!("rbar1_{eid}"), &a, &[b], flags);
    Ok(())
}

/// RROD: the distance of two grids stays, n · (u_b - u_a) = 0; which of the components follows is the solver's own business.
fn rrod(importer: &mut Importer<'_>, card: &Card<'_>) -> Result<(), DeckError> {
    let eid = card.id_at(2, "EID")?;
    let (a, b) = (importer.grid(card, 3, "GA")?, importer.grid(card, 4, "GB")?);
    let Some(n) = unit(minus(b.1.position, a.1.position)) else {
        return Err(card.error(Some((4, "GB")), "both of its grids lie at one place"));
    };
    let mut terms = Vec::new();
    for (node, sign) in [(&b.0, 1.0), (&a.0, -1.0)] {
        let dofs = [Dof::Ux, Dof::Uy, Dof::Uz].into_iter().zip(n);
        terms.extend(dofs.filter(|(_, v)| *v != 0.0).map(|(dof, v)| (node.clone(), dof, sign * v)));
    }
    importer.constraint(&format!("rrod_{eid}"), terms);
    Ok(())
}

fn rbe1(importer: &mut Importer<'_>, card: &Card<'_>) -> Result<(), DeckError> {
    let eid = card.id_at(2, "EID")?;
    let um = (3..=card.len()).find(|n| card.text(*n).eq_ignore_ascii_case("UM"));
    let um = um.ok_or_else(|| card.error(None, "the word UM in front of the grids that follow is missing"))?;
    let end = (um..=card.len()).rfind(|n| !card.text(*n).contains('.')).unwrap_or(card.len());
    let lead = pairs(importer, card, (3, um - 1), "GN")?;
    let follow = pairs(importer, card, (um + 1, end), "GM")?;
    let name = format!("rbe1_{eid}");
    if lead.len() == 1 && lead[0].1 == ALL {
        for (i, (grid, flags)) in follow.iter().enumerate() {
            let name = if follow.len() == 1 { name.clone() } else { format!("{name}_{}", i + 1) };
            importer.link(&name, &lead[0].0, std::slice::from_ref(grid), *flags);
        }
        return Ok(());
    }
    general(importer, card, &name, &lead, &follow)
}

/// A rigid body whose motion six components of several grids lead: u_m = R_m R_n⁻¹ u_n.
fn general(
    importer: &mut Importer<'_>,
    card: &Card<'_>,
    name: &str,
    lead: &[Component],
    follow: &[Component],
) -> Result<(), DeckError> {
    let Some(((_, origin), _)) = lead.first() else {
        return Err(card.error(Some((3, "GN")), "no grid leads"));
    };
    // A length near that of the body makes the six equations well scaled.
    let origin = origin.position;
    let reach = lead.iter().flat_map(|((_, g), _)| minus(g.position, origin)).fold(0.0_f64, |a, x| a.max(x.abs()));
    let reach = if reach > 0.0 { reach } else { 1.0 };
    let row = |importer: &Importer<'_>, grid: &Grid, component: usize| -> [f64; 6] {
        let arm = minus(grid.position, origin).map(|x| x / reach);
        let parts = importer.component(grid, component);
        std::array::from_fn(|motion| parts.iter().map(|(dof, f)| f * rigid_motion(arm, motion)[*dof as usize]).sum())
    };
    let mut led: Vec<(&(String, Grid), usize)> = Vec::new();
    let mut rows: Vec<[f64; 6]> = Vec::new();
    for (grid, flags) in lead {
        for component in (0..6).filter(|c| flags[*c]) {
            led.push((grid, component));
            rows.push(row(importer, &grid.1, component));
        }
    }
    let independent = DMatrix::from_fn(rows.len(), 6, |i, j| rows[i][j]);
    let inverse = if rows.len() == 6 { independent.try_inverse() } else { None };
    let inverse = inverse.filter(|m| m.iter().all(|v| v.is_finite() && v.abs() < 1e9));
    let Some(inverse) = inverse else {
        return Err(card.error(
            Some((5, "CN")),
            "its independent components must be six that determine the motion of a rigid body",
        ));
    };
    for ((node, grid), flags) in follow {
        for component in (0..6).filter(|c| flags[*c]) {
            let own = row(importer, grid, component);
            // Rotations are counted times the length in these rows.
            let scale = |c: usize| if c >= 3 { reach } else { 1.0 };
            let mut terms: Vec<(String, Dof, f64)> =
                importer.component(grid, component).into_iter().map(|(dof, f)| (node.clone(), dof, f)).collect();
            for (k, (other, c)) in led.iter().enumerate() {
                let factor: f64 = (0..6).map(|i| own[i] * inverse[(i, k)]).sum();
                for (dof, f) in importer.component(&other.1, *c) {
                    terms.push((other.0.clone(), dof, -factor * f * scale(*c) / scale(component)));
                }
            }
            importer.constraint(&format!("{name}_{node}_{}", component + 1), terms);
        }
    }
    Ok(())
}
