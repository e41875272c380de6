//! Fields of a line: small, large and free format.

/// How wide a field may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Width {
    /// Eight columns.
    Small,
    /// Sixteen columns.
    Large,
    /// Between commas: as wide as eight characters, or sixteen on a line with `*`.
    Free(usize),
}

impl Width {
    /// Characters that fit.
    pub fn characters(self) -> usize {
        match self {
            Width::Small => 8,
            Width::Large => 16,
            Width::Free(n) => n,
        }
    }
}

/// How the fields of a line are told apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Small,
    Large,
    Free { large: bool },
}

impl Kind {
    pub(super) fn of(line: &str) -> Self {
        let data = line.split('$').next().unwrap_or_default();
        let comma = data.bytes().take(10).position(|b| b == b',');
        let first = match comma {
            Some(at) => &data[..at],
            None => data.get(..8).unwrap_or(data),
        };
        match (comma, first.contains('*')) {
            (Some(_), large) => Kind::Free { large },
            (None, true) => Kind::Large,
            (None, false) => Kind::Small,
        }
    }
}

/// One field in its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Field<'a> {
    /// Its text, trimmed.
    pub text: &'a str,
    /// Index of the file.
    pub file: u32,
    /// Line of the file, from 1.
    pub line: u32,
    /// Its bytes in the file, blanks of a fixed field included; where the line is shorter, an empty range at its end.
    pub start: usize,
    /// End of its bytes.
    pub end: usize,
    /// Columns between the end of the line and where the field would begin.
    pub gap: usize,
    /// How wide it may be.
    pub width: Width,
    /// Whether a tab stands in it or before it: the columns are then not its bytes.
    pub tabbed: bool,
}

/// The data fields of one line, that of the name first; `start` is the byte of the line in its file. Whether something stands behind the name
/// of the continuation, where no field is.
pub(super) fn split<'a>(text: &'a str, (file, line, start): (u32, u32, usize), out: &mut Vec<Field<'a>>) -> bool {
    let kind = Kind::of(text);
    let data = text.split('$').next().unwrap_or_default();
    match kind {
        Kind::Free { large } => free(data, (file, line, start), large, out),
        Kind::Small => {
            fixed(data, (file, line, start), Width::Small, 8, out);
            false
        }
        Kind::Large => {
            fixed(data, (file, line, start), Width::Large, 4, out);
            false
        }
    }
}

fn free<'a>(data: &'a str, (file, line, start): (u32, u32, usize), large: bool, out: &mut Vec<Field<'a>>) -> bool {
    let (most, width) = if large { (4, Width::Free(16)) } else { (8, Width::Free(8)) };
    let mut at = 0;
    let mut n = 0;
    for part in data.split(',') {
        // Behind the data stands the name of the continuation.
        if n > most {
            break;
        }
        let end = start + at + part.len();
        out.push(Field { text: part.trim(), file, line, start: start + at, end, gap: 0, width, tabbed: false });
        at += part.len() + 1;
        n += 1;
    }
    let end = start + data.trim_end().len();
    // A field that is not written needs its commas.
    let mut gap = 0;
    while n <= most {
        gap += 1;
        out.push(Field { text: "", file, line, start: end, end, gap, width, tabbed: false });
        n += 1;
    }
    data.split(',').skip(most + 2).any(|part| !part.trim().is_empty())
}

fn fixed<'a>(
    data: &'a str,
    (file, line, start): (u32, u32, usize),
    width: Width,
    most: usize,
    out: &mut Vec<Field<'a>>,
) {
    let tabbed = data.contains('\t');
    // Column at which each byte stands, for lines with tabs or letters beyond ASCII.
    let columns = |from: usize, to: usize| -> (usize, usize) {
        if data.is_ascii() && !tabbed {
            return (from.min(data.len()), to.min(data.len()));
        }
        let (mut column, mut first, mut last) = (0, data.len(), data.len());
        for (i, c) in data.char_indices() {
            if column >= from && first == data.len() {
                first = i;
            }
            if column >= to {
                last = i;
                break;
            }
            column = if c == '\t' { (column / 8 + 1) * 8 } else { column + 1 };
        }
        (first.min(last), last)
    };
    let step = width.characters();
    for n in 0..=most {
        let (from, to) = if n == 0 { (0, 8) } else { (8 + (n - 1) * step, 8 + n * step) };
        let (first, last) = columns(from, to);
        let gap = if first == data.len() && !tabbed { from.saturating_sub(data.chars().count()) } else { 0 };
        let text = data.get(first..last).unwrap_or_default().trim();
        out.push(Field { text, file, line, start: start + first, end: start + last, gap, width, tabbed });
    }
}
