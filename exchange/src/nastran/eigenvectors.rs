//! DRESP1 of type DISP with a mode: components of eigenvectors, as EIGRL or EIGR normalises them.

use super::asked::{At, Component};
use super::importer::Importer;
use crate::system::Quantity;
use retune::deck::{Card, CardId, Deck, DeckError};

/// How the solver scales its eigenvectors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Norm {
    /// Unit generalised mass, the default.
    Mass,
    /// One at the largest component of the analysis set.
    Largest(CardId),
    /// One at a component of a grid.
    Point(At),
}

/// What a DRESP1 of type DISP with a mode asks for: every component of every grid; none without a mode.
pub(super) fn components(card: &Card<'_>) -> Result<Option<(u32, Vec<At>)>, DeckError> {
    let Some(mode) = card.optional_id(8, "ATTB")? else { return Ok(None) };
    let flags = card.components(7, "ATTA")?;
    let grids = card.ids_from(9, "ATT1")?;
    let of = |grid: u32| (0..6).filter(|c| flags[*c]).map(move |component| At { grid, component });
    Ok(Some((mode, grids.into_iter().flat_map(of).collect())))
}

/// The normalisation that holds: of the method that case control chooses, or of the only one.
pub(super) fn norm(deck: &Deck, subcase: Option<u32>) -> Result<Norm, DeckError> {
    let methods: Vec<CardId> = deck.cards().filter(|id| matches!(deck.name(*id), "EIGRL" | "EIGR")).collect();
    let case = deck.case_control();
    let later = || case.subcases.iter().find_map(|s| case.value("METHOD", Some(s.id)));
    let chosen = case.value("METHOD", subcase).or_else(later).and_then(|v| v.parse::<u32>().ok());
    let mut found = match methods.as_slice() {
        [only] => Some(*only),
        _ => None,
    };
    for id in &methods {
        if Some(deck.card(*id).id_at(2, "SID")?) == chosen {
            found = Some(*id);
        }
    }
    let Some(id) = found else { return Ok(Norm::Mass) };
    let card = deck.card(id);
    let is_lanczos = card.name() == "EIGRL";
    let stated = |n: usize| card.text(n).to_uppercase().strip_prefix("NORM=").map(str::to_string);
    let word = if is_lanczos { card.text(9) } else { card.text(10) }.to_uppercase();
    let word = (9..=card.len()).find_map(stated).unwrap_or(word);
    match word.as_str() {
        "" | "MASS" => Ok(Norm::Mass),
        "MAX" => Ok(Norm::Largest(id)),
        "POINT" if !is_lanczos => {
            let flags = card.components(12, "C")?;
            match (0..6).filter(|c| flags[*c]).collect::<Vec<_>>().as_slice() {
                [component] => Ok(Norm::Point(At { grid: card.id_at(11, "G")?, component: *component })),
                _ => Err(card.error(Some((12, "C")), "a point has one component")),
            }
        }
        _ if word.starts_with("NORM=") || word.contains('=') => Ok(Norm::Mass),
        other => {
            let shown: String = other.chars().take(16).collect();
            let field = if is_lanczos { 9 } else { 10 };
            Err(card.error(
                Some((field, "NORM")),
                format_args!("`{shown}` where MASS, MAX{} is expected", if is_lanczos { "" } else { " or POINT" }),
            ))
        }
    }
}

impl Importer<'_> {
    /// A component of an eigenvector in SI, or why it is none of a test.
    ///
    /// ```text
    /// φ_SI = φ_deck/√m for displacements, φ_deck/(√m l) for rotations,   m, l = the deck's units of mass and length
    /// ```
    pub(super) fn eigenvector(
        &self,
        norm: Norm,
        (mode, at, relative_to): (u32, At, Option<At>),
        (value, half): (f64, f64),
    ) -> Result<Component, String> {
        let length = self.options.system.factor(Quantity::Length);
        let scale = |at: At| if at.component < 3 { 1.0 } else { 1.0 / length };
        let (relative_to, factor) = match (relative_to, norm) {
            (Some(r), _) => (Some(r), scale(at) / scale(r)),
            (None, Norm::Point(p)) if p == at => {
                return Err("it is one by itself: eigenvectors are scaled to it".to_string());
            }
            (None, Norm::Point(p)) => (Some(p), scale(at) / scale(p)),
            (None, Norm::Mass) => (None, scale(at) / self.options.system.factor(Quantity::Mass).sqrt()),
            (None, Norm::Largest(id)) => {
                return Err(format!(
                    "eigenvectors are scaled to their largest component ({} {}, NORM MAX), which is another one after a change; NORM MASS, or a ratio of two components (DRESP2), can be a target",
                    self.deck.name(id),
                    self.deck.card(id).text(2)
                ));
            }
        };
        for own in std::iter::once(at).chain(relative_to) {
            if self.known_grid(own.grid).is_none() {
                return Err(format!("there is no GRID {}", own.grid));
            }
        }
        Ok(Component { mode, at, relative_to, value: value * factor, half: half * factor })
    }
}
