//! Binary output: tables LAMA (eigenvalues), OGPWG (masses) and OUG (eigenvectors), words of 32 bits, either order of bytes.
//!
//! ```text
//! record      length, bytes, length again (Fortran)
//! table       name; subtables -1, -2, ...; each: its number, the key 1 with one word, then keys n with n words; the key 0 ends it
//! ```

use super::{ResultMass, ResultMode, ResultsError, SolverResults};
use std::collections::BTreeMap;

/// Whether bytes are binary output: the first record is a word.
pub(super) fn is_op2(bytes: &[u8]) -> bool {
    let word = |at: usize| bytes.get(at..at + 4).map(|b| [b[0], b[1], b[2], b[3]]);
    let is_four = |b: [u8; 4]| b == [4, 0, 0, 0] || b == [0, 0, 0, 4];
    let is_eight = |b: [u8; 4]| b == [8, 0, 0, 0] || b == [0, 0, 0, 8];
    match (word(0), word(8), word(12)) {
        (Some(first), Some(last), _) if is_four(first) && first == last => true,
        // Words of 64 bits: told apart to be refused.
        (Some(first), _, Some(last)) => is_eight(first) && first == last,
        _ => false,
    }
}

struct Records<'a> {
    bytes: &'a [u8],
    at: usize,
    is_big: bool,
}

impl<'a> Records<'a> {
    fn wrong<T>(&self, message: &str) -> Result<T, ResultsError> {
        Err(ResultsError::Byte { at: self.at, message: message.to_string() })
    }

    fn word(&self, b: &[u8]) -> i32 {
        let b = [b[0], b[1], b[2], b[3]];
        if self.is_big { i32::from_be_bytes(b) } else { i32::from_le_bytes(b) }
    }

    fn real(&self, b: &[u8]) -> f64 {
        f64::from(f32::from_bits(self.word(b) as u32))
    }

    /// The next record; `None` at the end of the file.
    fn next(&mut self) -> Result<Option<&'a [u8]>, ResultsError> {
        if self.at == self.bytes.len() {
            return Ok(None);
        }
        let Some(head) = self.bytes.get(self.at..self.at + 4) else {
            return self.wrong("the file breaks off in a record");
        };
        let length = usize::try_from(self.word(head)).ok();
        let Some(length) = length.filter(|n| self.bytes.len() >= 8 && *n <= self.bytes.len() - 8) else {
            return self.wrong("a record is longer than the file");
        };
        let (start, end) = (self.at + 4, self.at + 4 + length);
        match self.bytes.get(end..end + 4) {
            Some(tail) if self.word(tail) as usize == length => {}
            _ => return self.wrong("the length behind a record is not that before it"),
        }
        self.at = end + 4;
        Ok(Some(&self.bytes[start..end]))
    }

    /// A key: a record of one word.
    fn key(&mut self) -> Result<Option<i32>, ResultsError> {
        match self.next()? {
            None => Ok(None),
            Some(b) if b.len() == 4 => Ok(Some(self.word(b))),
            Some(b) if b.len() == 8 => self.wrong("words of 64 bits are not read; write the file in single precision"),
            Some(_) => self.wrong("a key of one word is expected"),
        }
    }

    /// The record that a key announces.
    fn data(&mut self, key: i32) -> Result<&'a [u8], ResultsError> {
        match self.next()? {
            Some(b) if b.len() == 4 * usize::try_from(key).unwrap_or(usize::MAX) => Ok(b),
            _ => self.wrong("a record has another length than its key says"),
        }
    }
}

pub(super) fn read(bytes: &[u8]) -> Result<SolverResults, ResultsError> {
    let mut records = Records { bytes, at: 0, is_big: bytes[3] == 4 || bytes[3] == 8 };
    let mut out = SolverResults { kind: "op2", ..SolverResults::default() };
    let mut modes: BTreeMap<i64, ResultMode> = BTreeMap::new();
    let mut key = records.key()?;
    // A date, a word of identification and a label stand above, where the file has a header.
    if key == Some(3) {
        records.data(3)?;
        for _ in 0..2 {
            if let Some(k) = records.key()?.filter(|k| *k > 0) {
                records.data(k)?;
            }
        }
        for _ in 0..2 {
            if records.key()?.is_some_and(|k| k > 0) {
                return records.wrong("the header ends with the keys -1 and 0");
            }
        }
        key = records.key()?;
    }
    while let Some(k) = key {
        if k == 0 {
            key = records.key()?;
            continue;
        }
        if k != 2 {
            return records.wrong("the name of a table, two words, is expected");
        }
        let name = String::from_utf8_lossy(records.data(2)?).trim().to_string();
        if records.key()? != Some(-1) {
            return records.wrong("the key -1 is expected behind the name of a table");
        }
        match records.key()? {
            Some(k) if k > 0 => drop(records.data(k)?),
            _ => return records.wrong("the trailer of a table is expected"),
        }
        table(&mut records, &name, &mut out, &mut modes)?;
        key = records.key()?;
    }
    out.modes = modes.into_values().collect();
    Ok(out)
}

fn table(
    records: &mut Records<'_>,
    name: &str,
    out: &mut SolverResults,
    modes: &mut BTreeMap<i64, ResultMode>,
) -> Result<(), ResultsError> {
    let is_wanted = ["OUG", "BOUG", "LAMA", "BLAMA", "CLAMA", "OGPWG", "OPHIG"].iter().any(|n| name.starts_with(n));
    let mut ident: Vec<u8> = Vec::new();
    let mut number = 0;
    let mut pending = records.key()?;
    loop {
        match pending {
            None => return records.wrong("the file breaks off in a table"),
            Some(0) => return Ok(()),
            Some(k) if k < 0 => {}
            Some(_) => return records.wrong("the number of a subtable is expected"),
        }
        if records.key()? != Some(1) {
            return records.wrong("the key 1 is expected in front of a subtable");
        }
        records.data(1)?;
        let mut data: Vec<u8> = Vec::new();
        pending = records.key()?;
        while let Some(k) = pending.filter(|k| *k > 0) {
            let part = records.data(k)?;
            if is_wanted {
                data.extend_from_slice(part);
            }
            pending = records.key()?;
        }
        number += 1;
        if data.is_empty() {
            continue;
        }
        // The first subtable names the table; then identification and data alternate.
        if number == 1 {
            continue;
        }
        if number % 2 == 0 {
            ident = data;
            continue;
        }
        let words = |b: &'_ [u8], i: usize| b.get(4 * i..4 * i + 4).map(<[u8]>::to_vec);
        if name.contains("LAMA") {
            for row in data.chunks_exact(28) {
                let (mode, eigenvalue) = (i64::from(records.word(row)), records.real(&row[8..12]));
                if eigenvalue.is_finite() {
                    modes
                        .entry(mode)
                        .or_insert(ResultMode { number: mode, eigenvalue, shape: BTreeMap::new() })
                        .eigenvalue = eigenvalue;
                }
            }
        } else if name.starts_with("OGPWG") {
            if data.len() >= 36 * 4 && out.mass.is_none() {
                let rigid = std::array::from_fn(|i| std::array::from_fn(|j| records.real(&data[4 * (6 * i + j)..])));
                let reference = words(&ident, 2).map_or(0, |w| u32::try_from(records.word(&w)).unwrap_or(0));
                out.mass = Some(ResultMass { reference, rigid });
            }
        } else {
            // Code of the approach (2: normal modes), of the table (7: eigenvectors), the mode, its eigenvalue, words of an entry.
            let at = |i: usize| words(&ident, i).map_or(0, |w| records.word(&w));
            let is_modes = matches!(at(0) / 10, 2) && at(1) % 1000 == 7;
            if !is_modes {
                continue;
            }
            if at(9) != 8 {
                out.notes.push(format!("complex or short entries of {name} were left out"));
                continue;
            }
            let mode = i64::from(at(4));
            let eigenvalue = words(&ident, 5).map_or(0.0, |w| records.real(&w));
            let entry = modes.entry(mode).or_insert(ResultMode { number: mode, eigenvalue, shape: BTreeMap::new() });
            for row in data.chunks_exact(32) {
                // Type 1 is a grid point.
                if records.word(&row[4..8]) != 1 {
                    continue;
                }
                let Ok(grid) = u32::try_from(records.word(row) / 10) else { continue };
                let shape: [f64; 6] = std::array::from_fn(|d| records.real(&row[8 + 4 * d..]));
                if shape.iter().all(|v| v.is_finite()) {
                    entry.shape.insert(grid, shape);
                }
            }
        }
    }
}
