//! Frequencies that an optimisation asks for, as a test file.

use crate::deck::Deck;
use crate::exchange::writer::computed;
use std::collections::BTreeMap;

/// Frequencies that are asked for: value and half-width, Hz, by the number of the solver's mode.
pub(super) type Frequencies = BTreeMap<u32, (f64, f64)>;

/// A test file with the frequencies that are asked for, in the order of the modes; none where there are none.
///
/// * `n_free` - motions of the model without frequency, which the solver counts as its first modes
pub(super) fn test(deck: &Deck, modes: &Frequencies, n_free: u32) -> Option<String> {
    if modes.is_empty() {
        return None;
    }
    let file = deck.sources()[0].path().file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let file = crate::exchange::writer::clean(&file).replace(['"', '\\'], "");
    let mut text = format!(
        "# Frequencies that the optimisation of {file} asks for: goals of its objective, and the middles of its intervals with half of their width.\n\
         retune_test: 1\nname: \"targets of {file}\"\nsources:\n  deck: {{kind: measured, text: \"as DRESP1, DCONSTR and DESOBJ of {file} ask for; the deck does not say who measured them\"}}\nmodes:\n"
    );
    for (mode, (value, half)) in modes {
        // Modes of a test are paired with elastic ones.
        let partner =
            mode.checked_sub(n_free).filter(|n| *n > 0).map_or_else(String::new, |n| format!("pair_with: {n}, "));
        text.push_str(&format!(
            "  - {{frequency: {} Hz, frequency_sd: {} Hz, {partner}source: deck}}\n",
            computed(*value),
            computed(*half)
        ));
    }
    Some(text)
}
