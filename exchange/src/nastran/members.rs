//! Line elements: bars, beams, rods.

use super::importer::{Grid, Importer, Values};
use super::{CardRule, read, refused, used};
use crate::imported::Plane;
use crate::text::direction;
use crate::writer::Block;
use retune::deck::{Card, DeckError};
use retune::element::Dof;
use retune::linalg::vector3::{cross, dot, minus, plus, unit};

pub(super) const CARDS: &[CardRule] = &[
    read("CBAR", "beams", bar).up_to(17),
    read("CBEAM", "beams", bar).up_to(19),
    read("CROD", "beams", rod).up_to(5),
    read("CTUBE", "beams", rod).up_to(5),
    read("CONROD", "beams", conrod).up_to(9),
    used("BAROR", "beams"),
    used("BEAMOR", "beams"),
    refused("CBEND", "curved beams are not read; give chains of CBEAM"),
    refused("CBEAM3", "three-noded beams are not read; give chains of CBEAM"),
];

/// What a member of two grids says beside its property.
struct Member {
    nodes: [String; 2],
    grids: [Grid; 2],
    /// Arms from the grids to the ends, basic coordinates.
    arms: [[f64; 3]; 2],
    /// From end to end.
    along: [f64; 3],
}

impl Member {
    fn new(importer: &Importer<'_>, card: &Card<'_>, [a, b]: [usize; 2]) -> Result<Self, DeckError> {
        let (first, ga) = importer.grid(card, a, "GA")?;
        let (second, gb) = importer.grid(card, b, "GB")?;
        Ok(Self {
            nodes: [first, second],
            grids: [ga, gb],
            arms: [[0.0; 3]; 2],
            along: minus(gb.position, ga.position),
        })
    }

    fn check_length(&self, card: &Card<'_>) -> Result<[f64; 3], DeckError> {
        unit(self.along).ok_or_else(|| card.error(None, "its ends are at the same place, so it has no length"))
    }

    fn values(&self) -> Values {
        let nodes = format!("[{}]", self.nodes.join(", "));
        Values { items: vec![("nodes".to_string(), nodes)], ..Values::default() }
    }
}

/// A vector in the axes of the displacements of a grid, in basic coordinates.
fn from_grid(importer: &Importer<'_>, grid: &Grid, v: [f64; 3]) -> [f64; 3] {
    let axes = importer.displacement_axes(grid);
    (0..3).fold([0.0; 3], |sum, i| plus(sum, v[i], axes[i]))
}

/// CBAR and CBEAM: the same fields but for the last line.
fn bar<'a>(importer: &mut Importer<'a>, card: &Card<'a>) -> Result<(), DeckError> {
    let is_beam = card.name() == "CBEAM";
    let (allowed, default): (&[&str], _) =
        if is_beam { (&["PBEAM", "PBEAML", "PBCOMP"], "BEAMOR") } else { (&["PBAR", "PBARL"], "BAROR") };
    let default = importer.default_of(default);
    let own_or = |n: usize| if card.is_blank(n) { default.as_ref().unwrap_or(card) } else { card };
    let property = importer.property(own_or(3), 3, allowed)?;
    let mut member = Member::new(importer, card, [4, 5])?;
    // OFFT of three letters, or for CBEAM the number BIT of p-elements.
    let offt = own_or(9).text(9).to_uppercase();
    let is_offt = offt.len() == 3 && offt.chars().all(|c| "GBEO".contains(c));
    // Old decks say 1 for a vector and 2 for a grid, which the fields before say themselves.
    let is_old = !is_beam && matches!(offt.as_str(), "0" | "1" | "2");
    if !(offt.is_empty() || is_offt || is_old) {
        return Err(card.error(Some((9, "OFFT")), "three letters of G, B, E, O are expected; p-elements are not read"));
    }
    let letter = |i: usize| offt.chars().nth(i).unwrap_or('G');
    // Offsets in the axes of the element are those before offsets.
    let toward = from_orientation(importer, card, own_or(6), &member, letter(0))?;
    for (k, first) in [(0, 12), (1, 15)] {
        let offset = card.vector(first, "W")?;
        if offset == [0.0; 3] {
            continue;
        }
        member.arms[k] = match letter(1 + k) {
            'E' | 'O' => {
                let x = member.check_length(card)?;
                let axes = element_axes(card, x, toward)?;
                (0..3).fold([0.0; 3], |sum, i| plus(sum, offset[i], axes[i]))
            }
            _ => from_grid(importer, &member.grids[k], offset),
        };
    }
    member.along = plus(plus(member.along, 1.0, member.arms[1]), -1.0, member.arms[0]);
    let x = member.check_length(card)?;
    let mut axes = element_axes(card, x, toward)?;
    let of_vector = if letter(0) == 'B' { retune::model::GLOBAL } else { importer.displacement_axes(&member.grids[0]) };
    let turns_offsets = (1..3).any(|i| matches!(letter(i), 'E' | 'O')) && member.arms != [[0.0; 3]; 2];
    let plane = Plane { axes, of_vector, turns_offsets };
    let section = super::sections::section(importer, &property, is_beam)?;
    if section.turn != 0.0 {
        let (sin, cos) = section.turn.sin_cos();
        let y = plus(axes[1].map(|v| v * cos), sin, axes[2]);
        axes = [x, y, cross(x, y)];
    }
    let mut values = member.values();
    values.plane = Some(Box::new(plane));
    values.items.push(("section".into(), section.name.clone()));
    values.items.push(("orientation".into(), direction(axes[2])));
    if member.arms != [[0.0; 3]; 2] {
        let both = member.arms.map(|v| importer.lengths(v)).join(", ");
        values.items.push(("offsets".into(), format!("[{both}]")));
    }
    let mut releases = Vec::new();
    for (end, field, name) in [(1, 10, "PA"), (2, 11, "PB")] {
        let flags = card.components(field, name)?;
        let mut released = Vec::new();
        for (dof, _) in Dof::ALL.into_iter().zip(flags).filter(|f| f.1) {
            if section.turn != 0.0 && !matches!(dof, Dof::Ux | Dof::Rx) {
                return Err(card.error(
                    Some((field, name)),
                    "pin flags of a section with I12 are not in its principal axes; they are not read",
                ));
            }
            released.push(dof.name());
        }
        if !released.is_empty() {
            releases.push((format!("end{end}"), format!("[{}]", released.join(", "))));
        }
    }
    if !releases.is_empty() {
        values.items.push(("releases".into(), crate::text::map(&releases)));
    }
    if is_beam && (!card.is_blank(18) || !card.is_blank(19)) {
        importer.report.approximate("warping of CBEAM (SA, SB) is left out");
    }
    importer.element(Block::Beams, card, values, Some(&property), Some(&section.name)).map(|_| ())
}

/// Whether the orientation is a grid.
fn is_third_point(card: &Card<'_>) -> bool {
    let text = card.text(6);
    !text.is_empty()
        && !text.contains('.')
        && text.parse::<u32>().is_ok_and(|g| g > 0)
        && card.is_blank(7)
        && card.is_blank(8)
}

/// The vector in the first plane of the element, in basic coordinates.
fn from_orientation(
    importer: &Importer<'_>,
    card: &Card<'_>,
    source: &Card<'_>,
    member: &Member,
    letter: char,
) -> Result<[f64; 3], DeckError> {
    if is_third_point(source) {
        let (_, third) = importer.grid(source, 6, "G0")?;
        return Ok(minus(third.position, member.grids[0].position));
    }
    let v = source.vector(6, "X1")?;
    if v == [0.0; 3] {
        return Err(card
            .error(Some((6, "X1")), "the direction of its first plane is missing: a vector X1, X2, X3 or a grid G0"));
    }
    Ok(if letter == 'B' { v } else { from_grid(importer, &member.grids[0], v) })
}

/// x along the element, y towards a vector in the first plane.
fn element_axes(card: &Card<'_>, x: [f64; 3], toward: [f64; 3]) -> Result<[[f64; 3]; 3], DeckError> {
    let near = unit(toward).unwrap_or_default();
    let y = plus(near, -dot(near, x), x);
    let y = unit(y).filter(|_| dot(y, y) > 1e-12);
    let y =
        y.ok_or_else(|| card.error(Some((6, "X1")), "the direction of its first plane is along the element itself"))?;
    Ok([x, y, cross(x, y)])
}

fn rod<'a>(importer: &mut Importer<'a>, card: &Card<'a>) -> Result<(), DeckError> {
    let allowed: &[&str] = if card.name() == "CTUBE" { &["PTUBE"] } else { &["PROD"] };
    let property = importer.property(card, 3, allowed)?;
    let member = Member::new(importer, card, [4, 5])?;
    member.check_length(card)?;
    let section = super::sections::rod(importer, &property)?;
    let mut values = member.values();
    values.items.push(("section".into(), section.clone()));
    importer.element(Block::Beams, card, values, Some(&property), Some(&section)).map(|_| ())
}

/// CONROD: grids, material and section on one card.
fn conrod<'a>(importer: &mut Importer<'a>, card: &Card<'a>) -> Result<(), DeckError> {
    let member = Member::new(importer, card, [3, 4])?;
    member.check_length(card)?;
    let mut values = member.values();
    let own = super::sections::rod_values(importer, card, [5, 6, 7, 9])?;
    let items = crate::text::map(&own.items);
    values.items.push(("properties".into(), items));
    values.bounds = own.bounds;
    importer.element(Block::Beams, card, values, None, None).map(|_| ())
}
