//! PBEAM: sections at stations along the element.

use retune::deck::{Card, DeckError};

/// A PBEAM: the mean of its stations.
pub(super) struct Beam {
    /// A, I1, I2, I12, J, NSM.
    pub numbers: [f64; 6],
    pub fields: [Option<(usize, &'static str)>; 6],
    pub shear: [f64; 2],
    pub shear_fields: [Option<(usize, &'static str)>; 2],
    pub nsi: f64,
    pub neutral: [f64; 2],
    pub nsm_at: [f64; 2],
    pub is_tapered: bool,
}

const NAMES: [&str; 6] = ["A", "I1", "I2", "I12", "J", "NSM"];

/// Stations of one PBEAM, at most.
const MOST: usize = 11;

/// The line of a card that begins at a field.
fn word(card: &Card<'_>, n: usize) -> Option<bool> {
    match card.text(n).to_uppercase().as_str() {
        "YES" => Some(true),
        "YESA" | "NO" => Some(false),
        _ => None,
    }
}

pub(super) fn read(card: &Card<'_>) -> Result<Beam, DeckError> {
    let mut first = [0.0; 6];
    for (i, name) in NAMES.into_iter().enumerate() {
        first[i] = card.real_or(4 + i, name, 0.0)?;
    }
    // Behind the first line stand the points of stress of end A, unless stations begin at once.
    let mut at = if word(card, 10).is_some() { 10 } else { 18 };
    let mut stations: Vec<(f64, [Option<f64>; 6])> = Vec::new();
    while let Some(has_stress) = word(card, at) {
        if stations.len() >= MOST {
            return Err(card.error(Some((at, "SO")), format_args!("a PBEAM has at most {MOST} stations")));
        }
        let x = card.real(at + 1, "X/XB")?;
        if !(x > 0.0 && x <= 1.0) {
            return Err(card.error(Some((at + 1, "X/XB")), "a station lies above 0 and at most at 1"));
        }
        let mut own = [None; 6];
        for (i, name) in NAMES.into_iter().enumerate() {
            own[i] = card.optional_real(at + 2 + i, name)?;
        }
        stations.push((x, own));
        at += if has_stress { 16 } else { 8 };
    }
    let factor = |n: usize, name| card.real_or(n, name, 1.0);
    let shear = [factor(at, "K1")?, factor(at + 1, "K2")?];
    let (nsi_a, nsi_b) = (card.real_or(at + 4, "NSI(A)", 0.0)?, card.optional_real(at + 5, "NSI(B)")?);
    let pair = |n: usize, name: &'static str| -> Result<[f64; 2], DeckError> {
        let a = [card.real_or(n, name, 0.0)?, card.real_or(n + 1, name, 0.0)?];
        let b = [card.real_or(n + 2, name, a[0])?, card.real_or(n + 3, name, a[1])?];
        Ok([0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])])
    };
    let (nsm_at, neutral) = (pair(at + 8, "M1(A)")?, pair(at + 12, "N1(A)")?);
    stations.sort_by(|a, b| a.0.total_cmp(&b.0));
    // End B is as end A where it says nothing; between them what is absent is interpolated.
    let last = match stations.last() {
        Some((x, own)) if *x == 1.0 => std::array::from_fn(|i| own[i].unwrap_or(first[i])),
        _ => first,
    };
    let mut points = vec![(0.0, first)];
    for (x, own) in stations.iter().filter(|s| s.0 < 1.0) {
        points.push((*x, std::array::from_fn(|i| own[i].unwrap_or(first[i] + x * (last[i] - first[i])))));
    }
    points.push((1.0, last));
    let is_tapered = points.iter().any(|p| p.1 != first);
    let mean =
        std::array::from_fn(|i| points.windows(2).map(|w| 0.5 * (w[1].0 - w[0].0) * (w[0].1[i] + w[1].1[i])).sum());
    let fields = if is_tapered { [None; 6] } else { std::array::from_fn(|i| Some((4 + i, NAMES[i]))) };
    Ok(Beam {
        numbers: if is_tapered { mean } else { first },
        fields,
        shear,
        shear_fields: [Some((at, "K1")), Some((at + 1, "K2"))],
        nsi: 0.5 * (nsi_a + nsi_b.unwrap_or(nsi_a)),
        neutral,
        nsm_at,
        is_tapered,
    })
}
