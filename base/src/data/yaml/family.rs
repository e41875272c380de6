//! What the name of a mode says of its symmetry.

/// The symmetry that a label tells: `Sym 1st Bending`, `S1B`, `Anti 2nd Torsion`, `A2T`.
pub fn family_of_label(label: &str) -> Option<&'static str> {
    let lower = label.to_lowercase();
    let short = |letter: char| {
        let mut c = lower.chars();
        c.next() == Some(letter) && c.next().is_some_and(|d| d.is_ascii_digit()) && lower.chars().count() <= 4
    };
    let begins = |start: &str| lower.split(|c: char| !c.is_alphabetic()).any(|word| word.starts_with(start));
    if begins("anti") || begins("asym") || begins("unsym") || short('a') {
        Some("antisymmetric")
    } else if begins("sym") || short('s') {
        Some("symmetric")
    } else {
        None
    }
}
