//! OUTPUT4 as Fortran records.

use super::{Contents, FORMAT, Growing, Head, MatrixError};

/// How a file writes its numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Words {
    is_big_endian: bool,
    /// Bytes of a word: 4, or 8 where integers are long and every number is a double.
    width: usize,
}

impl Words {
    /// By the length of the first record, which is the head of a matrix.
    pub(super) fn of(bytes: &[u8]) -> Option<Self> {
        let first: [u8; 4] = bytes.get(..4)?.try_into().ok()?;
        [false, true].into_iter().find_map(|is_big_endian| {
            let length = if is_big_endian { u32::from_be_bytes(first) } else { u32::from_le_bytes(first) };
            let width = match length {
                24 => 4,
                48 => 8,
                _ => return None,
            };
            let words = Self { is_big_endian, width };
            let end = 4 + length as usize;
            let closes = bytes.get(end..end + 4).is_some_and(|b| b == first);
            (closes && words.head(&bytes[4..end]).is_some()).then_some(words)
        })
    }

    fn join(self, bytes: &[u8]) -> u64 {
        let join = |acc: u64, b: &u8| (acc << 8) | u64::from(*b);
        if self.is_big_endian { bytes.iter().fold(0, join) } else { bytes.iter().rev().fold(0, join) }
    }

    /// A whole number of one word.
    fn whole(self, bytes: &[u8]) -> i64 {
        let bits = self.join(bytes);
        if self.width == 4 { i64::from(bits as u32 as i32) } else { bits as i64 }
    }

    fn head(self, record: &[u8]) -> Option<Head> {
        let word = |i: usize| self.whole(&record[i * self.width..(i + 1) * self.width]);
        let letters: String = record[4 * self.width..].iter().map(|b| char::from(*b)).collect();
        // Of a name in long words each half may stand in a word of its own.
        let name: String = letters.split_whitespace().collect();
        Head::new(word(0), word(1), word(3), name.trim_end_matches('\0'), 0)
    }
}

/// The next record: its bytes, and what is left.
fn record(words: Words, bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let length = words.join(bytes.get(..4)?) as usize;
    let end = length.checked_add(4)?;
    let inside = bytes.get(4..end)?;
    let closing = bytes.get(end..end.checked_add(4)?)?;
    (words.join(closing) as usize == length).then_some((inside, &bytes[end + 4..]))
}

pub(super) fn read(words: &Words, bytes: &[u8], contents: &mut Contents) -> Result<(), MatrixError> {
    let mut rest = bytes;
    while !rest.is_empty() {
        let broken =
            |what: &str| MatrixError::broken(FORMAT, format_args!("{what} at byte {}", bytes.len() - rest.len()));
        let (first, after) = record(*words, rest).ok_or_else(|| broken("a record is cut off"))?;
        let head = (first.len() == 6 * words.width).then(|| words.head(first)).flatten();
        let head = head.ok_or_else(|| broken("no head of a matrix"))?;
        rest = after;
        let mut growing = Growing::new(&head);
        loop {
            let broken = |what: &str| {
                MatrixError::broken(
                    FORMAT,
                    format_args!("matrix `{}`: {what} at byte {}", head.name, bytes.len() - rest.len()),
                )
            };
            let (column, after) = record(*words, rest).ok_or_else(|| broken("a record is cut off"))?;
            let mut numbers = column.chunks_exact(words.width).map(|w| words.whole(w));
            let (Some(place), Some(row), Some(_)) = (numbers.next(), numbers.next(), numbers.next()) else {
                return Err(broken("a record without a column"));
            };
            let (Ok(place), Ok(row)) = (usize::try_from(place - 1), usize::try_from(row)) else {
                return Err(broken("a column or a row that is not counted from 1"));
            };
            rest = after;
            if place >= head.n_columns {
                break;
            }
            let data = &column[3 * words.width..];
            let put = if row > 0 {
                values(*words, &head, &mut growing, place, row - 1, data)
            } else {
                strings(*words, &head, &mut growing, place, data)
            };
            put.ok_or_else(|| broken("numbers that leave the matrix, or are not finite,"))?;
        }
        growing.finish(contents);
    }
    Ok(())
}

/// Bytes of one number.
fn width(words: Words, head: &Head) -> usize {
    if head.kind.is_double { 8 } else { words.width }
}

fn values(words: Words, head: &Head, growing: &mut Growing, column: usize, row: usize, data: &[u8]) -> Option<()> {
    for (k, bytes) in data.chunks_exact(width(words, head)).enumerate() {
        let bits = words.join(bytes);
        let value = if bytes.len() == 8 { f64::from_bits(bits) } else { f64::from(f32::from_bits(bits as u32)) };
        growing.put(column, row, k, Some(value).filter(|v| v.is_finite())?)?;
    }
    Some(())
}

fn strings(words: Words, head: &Head, growing: &mut Growing, column: usize, mut data: &[u8]) -> Option<()> {
    while !data.is_empty() {
        let word = |i: usize| data.get(i * words.width..(i + 1) * words.width).map(|w| words.whole(w));
        let (length, row, own) = if head.is_big {
            (word(0)? - 1, word(1)?, 2)
        } else {
            let both = word(0)?;
            (both / 65_536 - 1, both % 65_536, 1)
        };
        let (length, row) = (usize::try_from(length).ok()?, usize::try_from(row - 1).ok()?);
        let from = own * words.width;
        let to = from.checked_add(length.checked_mul(words.width)?)?;
        values(words, head, growing, column, row, data.get(from..to)?)?;
        data = &data[to..];
    }
    Some(())
}
