//! Binary output: tables LAMA (eigenvalues), OGPWG (masses) and OUG (eigenvectors), words of 32 or 64 bits, either order of bytes.
//!
//! ```text
//! record      length, bytes, length again (Fortran)
//! words       integers and reals of one width; of a name in long words each half stands in a word of its own
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
        (Some(first), _, Some(last)) => is_eight(first) && first == last,
        _ => false,
    }
}

struct Records<'a> {
    bytes: &'a [u8],
    at: usize,
    is_big: bool,
    /// Bytes of a word.
    width: usize,
}

impl<'a> Records<'a> {
    fn wrong<T>(&self, message: &str) -> Result<T, ResultsError> {
        Err(ResultsError::Byte { at: self.at, message: message.to_string() })
    }

    /// The length of a record, which has four bytes whatever the width of words.
    fn length(&self, b: &[u8]) -> i32 {
        let b = [b[0], b[1], b[2], b[3]];
        if self.is_big { i32::from_be_bytes(b) } else { i32::from_le_bytes(b) }
    }

    /// A whole number: the word at place `i`.
    fn word(&self, b: &[u8], i: usize) -> i64 {
        let at = i * self.width;
        match (b.get(at..at + self.width), self.is_big) {
            (Some(&[a, b, c, d, e, f, g, h]), true) => i64::from_be_bytes([a, b, c, d, e, f, g, h]),
            (Some(&[a, b, c, d, e, f, g, h]), false) => i64::from_le_bytes([a, b, c, d, e, f, g, h]),
            (Some(short), _) => i64::from(self.length(short)),
            (None, _) => 0,
        }
    }

    /// A real number: the word at place `i`.
    fn real(&self, b: &[u8], i: usize) -> f64 {
        let bits = self.word(b, i);
        if self.width == 8 { f64::from_bits(bits as u64) } else { f64::from(f32::from_bits(bits as u32)) }
    }

    /// Letters, four in a word.
    fn text(&self, b: &[u8]) -> String {
        let words = b.chunks(self.width).flat_map(|w| &w[..w.len().min(4)]);
        words.map(|c| char::from(*c)).collect::<String>().trim().to_string()
    }

    /// The next record; `None` at the end of the file.
    fn next(&mut self) -> Result<Option<&'a [u8]>, ResultsError> {
        if self.at == self.bytes.len() {
            return Ok(None);
        }
        let Some(head) = self.bytes.get(self.at..self.at + 4) else {
            return self.wrong("the file breaks off in a record");
        };
        let length = usize::try_from(self.length(head)).ok();
        let Some(length) = length.filter(|n| self.bytes.len() >= 8 && *n <= self.bytes.len() - 8) else {
            return self.wrong("a record is longer than the file");
        };
        let (start, end) = (self.at + 4, self.at + 4 + length);
        match self.bytes.get(end..end + 4) {
            Some(tail) if self.length(tail) as usize == length => {}
            _ => return self.wrong("the length behind a record is not that before it"),
        }
        self.at = end + 4;
        Ok(Some(&self.bytes[start..end]))
    }

    /// A key: a record of one word.
    fn key(&mut self) -> Result<Option<i64>, ResultsError> {
        match self.next()? {
            None => Ok(None),
            Some(b) if b.len() == self.width => Ok(Some(self.word(b, 0))),
            Some(_) => self.wrong("a key of one word is expected"),
        }
    }

    /// The record that a key announces.
    fn data(&mut self, key: i64) -> Result<&'a [u8], ResultsError> {
        let length = usize::try_from(key).ok().and_then(|n| n.checked_mul(self.width));
        match self.next()? {
            Some(b) if Some(b.len()) == length => Ok(b),
            _ => self.wrong("a record has another length than its key says"),
        }
    }
}

pub(super) fn read(bytes: &[u8]) -> Result<SolverResults, ResultsError> {
    let is_big = bytes[3] == 4 || bytes[3] == 8;
    let width = usize::from(bytes[0].max(bytes[3]));
    let mut records = Records { bytes, at: 0, is_big, width };
    let mut out = SolverResults { kind: "op2", ..SolverResults::default() };
    let mut modes: BTreeMap<i64, ResultMode> = BTreeMap::new();
    let mut key = records.key()?;
    // A date, a word of identification and labels stand above, where the file has a header.
    if key == Some(3) {
        records.data(3)?;
        while let Some(k) = records.key()?.filter(|k| *k > 0) {
            records.data(k)?;
        }
        if records.key()? != Some(0) {
            return records.wrong("the header ends with the keys -1 and 0");
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
        let name = records.data(2)?;
        let name = records.text(name);
        // Newer files say behind the name which version wrote the table.
        let mut behind = records.key()?;
        while let Some(k) = behind.filter(|k| *k > 0) {
            records.data(k)?;
            behind = records.key()?;
        }
        if behind != Some(-1) {
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
    let is_wanted = ["OUG", "BOUG", "LAMA", "BLAMA", "OGPWG", "OPHIG"].iter().any(|n| name.starts_with(n));
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
            // Records of a matrix are longer than their keys: by the row where a run of values begins.
            if is_wanted {
                data.extend_from_slice(records.data(k)?);
            } else if records.next()?.is_none() {
                return records.wrong("the file breaks off in a table");
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
        if name.contains("LAMA") {
            for row in data.chunks_exact(7 * records.width) {
                let (mode, eigenvalue) = (records.word(row, 0), records.real(row, 2));
                if eigenvalue.is_finite() {
                    modes
                        .entry(mode)
                        .or_insert(ResultMode { number: mode, eigenvalue, shape: BTreeMap::new() })
                        .eigenvalue = eigenvalue;
                }
            }
        } else if name.starts_with("OGPWG") {
            if data.len() >= 36 * records.width && out.mass.is_none() {
                let rigid = std::array::from_fn(|i| std::array::from_fn(|j| records.real(&data, 6 * i + j)));
                let reference = u32::try_from(records.word(&ident, 2)).unwrap_or(0);
                out.mass = Some(ResultMass { reference, rigid });
            }
        } else {
            // Code of the approach (2: normal modes), of the table (7: eigenvectors), the mode, its eigenvalue, words of an entry.
            let at = |i: usize| records.word(&ident, i);
            let is_modes = matches!(at(0) / 10, 2) && at(1) % 1000 == 7;
            if !is_modes {
                continue;
            }
            if at(9) != 8 {
                out.notes.push(format!("complex or short entries of {name} were left out"));
                continue;
            }
            let (mode, eigenvalue) = (at(4), records.real(&ident, 5));
            let entry = modes.entry(mode).or_insert(ResultMode { number: mode, eigenvalue, shape: BTreeMap::new() });
            for row in data.chunks_exact(8 * records.width) {
                // Type 1 is a grid point.
                if records.word(row, 1) != 1 {
                    continue;
                }
                let Ok(grid) = u32::try_from(records.word(row, 0) / 10) else { continue };
                let shape: [f64; 6] = std::array::from_fn(|d| records.real(row, 2 + d));
                if shape.iter().all(|v| v.is_finite()) {
                    entry.shape.insert(grid, shape);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A word of a file: letters, a whole number, a real one.
    enum Word {
        Letters(&'static str),
        Whole(i64),
        Real(f64),
    }
    use Word::{Letters, Real, Whole};

    struct File {
        bytes: Vec<u8>,
        is_big: bool,
        is_long: bool,
    }

    impl File {
        fn word(&self, w: &Word) -> Vec<u8> {
            let mut own = match w {
                Letters(l) => {
                    let width = if self.is_long { 8 } else { 4 };
                    return format!("{l:<width$}").into_bytes();
                }
                Whole(i) if self.is_long => i.to_le_bytes().to_vec(),
                Whole(i) => (*i as i32).to_le_bytes().to_vec(),
                Real(v) if self.is_long => v.to_le_bytes().to_vec(),
                Real(v) => (*v as f32).to_le_bytes().to_vec(),
            };
            if self.is_big {
                own.reverse();
            }
            own
        }

        fn record(&mut self, words: &[Word]) {
            let inside: Vec<u8> = words.iter().flat_map(|w| self.word(w)).collect();
            let length = inside.len() as u32;
            let length = if self.is_big { length.to_be_bytes() } else { length.to_le_bytes() };
            self.bytes.extend([&length[..], &inside, &length].concat());
        }

        fn key(&mut self, key: i64) {
            self.record(&[Whole(key)]);
        }

        fn data(&mut self, words: &[Word]) {
            self.key(words.len() as i64);
            self.record(words);
        }

        /// A table of subtables.
        fn table(&mut self, name: [&'static str; 2], subtables: &[Vec<Word>]) {
            self.data(&name.map(Letters));
            self.key(-1);
            self.data(&[Whole(101), Whole(0), Whole(0), Whole(0), Whole(0), Whole(0), Whole(0)]);
            for (i, words) in subtables.iter().enumerate() {
                self.key(-2 - i as i64);
                self.key(1);
                self.record(&[Whole(0)]);
                self.data(words);
            }
            self.key(-2 - subtables.len() as i64);
            self.key(1);
            self.record(&[Whole(0)]);
            self.key(0);
        }
    }

    /// A header with a version, a table whose name is followed by one, and a matrix, whose records are longer than their keys: what
    /// newer solvers write before the eigenvalues. Complex eigenvalues are none of real modes.
    #[test]
    fn what_newer_solvers_write_is_passed_over() {
        let mut file = File { bytes: Vec::new(), is_big: false, is_long: false };
        let version =
            |name: &'static str| [Letters("2021"), Letters("1"), Letters("0"), Letters(""), Letters(name), Letters("")];
        file.data(&[Whole(5), Whole(4), Whole(21)]);
        file.data(&[
            Letters("NAST"),
            Letters("RAN "),
            Letters("FORT"),
            Letters(" TAP"),
            Letters("E ID"),
            Letters(" COD"),
            Letters("E - "),
        ]);
        file.data(&[Letters("XXXX"), Letters("XXXX")]);
        file.data(&version(""));
        file.key(-1);
        file.key(0);
        // A matrix: its name, and a column of two values behind the row where they begin.
        file.data(&[Letters("KHH"), Letters("")]);
        file.data(&version("KHH"));
        file.key(-1);
        file.data(&(0..7).map(Whole).collect::<Vec<_>>());
        file.key(-2);
        file.key(1);
        file.record(&[Whole(0)]);
        file.data(&[Letters("KHH"), Letters("")]);
        file.key(-3);
        file.key(1);
        file.record(&[Whole(1)]);
        file.key(2);
        file.record(&[Whole(3), Real(1.5), Real(2.5)]);
        file.key(-4);
        file.key(1);
        file.record(&[Whole(0)]);
        file.key(0);
        let row =
            |n: i64, value: f64| vec![Whole(n), Whole(n), Real(value), Real(1.0), Real(0.0), Real(1.0), Real(value)];
        for (name, value) in [("LAMA", 400.5), ("CLAM", 7.0)] {
            let rest = if name == "CLAM" { "A" } else { "" };
            file.table([name, rest], &[vec![Letters(name), Letters(rest)], vec![Whole(20)], row(1, value)]);
        }
        file.key(0);
        let found = read(&file.bytes).unwrap();
        assert_eq!(found.modes.iter().map(|m| m.eigenvalue).collect::<Vec<_>>(), [400.5]);
    }

    /// Eigenvalues and a shape, in words of both widths and in both orders: the same numbers; cut off anywhere: an error and no panic.
    #[test]
    fn words_of_both_widths_and_orders_say_the_same() {
        for (is_long, is_big) in [(false, false), (false, true), (true, false), (true, true)] {
            let mut file = File { bytes: Vec::new(), is_big, is_long };
            let row = |n: i64, value: f64| {
                vec![Whole(n), Whole(n), Real(value), Real(value.sqrt()), Real(0.0), Real(1.0), Real(value)]
            };
            let values = row(1, 400.5).into_iter().chain(row(2, 1600.25)).collect();
            file.table(["LAMA", ""], &[vec![Letters("LAMA"), Letters("")], vec![Whole(20)], values]);
            let mut ident = vec![
                Whole(21),
                Whole(7),
                Whole(0),
                Whole(1),
                Whole(2),
                Real(1600.25),
                Whole(0),
                Whole(0),
                Whole(1),
                Whole(8),
            ];
            ident.extend((0..10).map(|_| Whole(0)));
            let shape: Vec<Word> =
                [Whole(35), Whole(1)].into_iter().chain([1.5, -2.0, 0.0, 0.25, 0.0, 8.0].map(Real)).collect();
            file.table(["OUGV", "1"], &[vec![Letters("OUGV"), Letters("1")], ident, shape]);
            file.key(0);
            assert!(is_op2(&file.bytes));
            let found = read(&file.bytes).unwrap();
            let eigenvalues: Vec<f64> = found.modes.iter().map(|m| m.eigenvalue).collect();
            assert_eq!(eigenvalues, [400.5, 1600.25], "{is_long} {is_big}");
            assert_eq!(found.modes[1].shape[&3], [1.5, -2.0, 0.0, 0.25, 0.0, 8.0]);
            for end in (16..file.bytes.len() - 20).step_by(7) {
                let _ = read(&file.bytes[..end]);
            }
        }
    }
}
