//! Lines and numbers of text files.

/// The lines of some bytes, with their numbers from 1; bytes that are not UTF-8 become replacement characters.
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    /// Number of the line that was given last.
    pub(super) number: usize,
}

impl<'a> Lines<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes, number: 0 }
    }

    /// The next line, without its end.
    pub(super) fn next(&mut self) -> Option<&'a str> {
        if self.rest.is_empty() {
            return None;
        }
        let end = self.rest.iter().position(|b| *b == b'\n').unwrap_or(self.rest.len());
        let line = &self.rest[..end];
        self.rest = &self.rest[(end + 1).min(self.rest.len())..];
        self.number += 1;
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        // What is not text is cut off where it begins: no format here has it.
        Some(
            std::str::from_utf8(line)
                .unwrap_or_else(|e| std::str::from_utf8(&line[..e.valid_up_to()]).unwrap_or_default()),
        )
    }

    /// The bytes after the lines that were given.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.rest
    }
}

/// A finite number as C, Fortran (`1.5D+03`) and Nastran (`1.5+3`) write it.
pub(super) fn number(text: &str) -> Option<f64> {
    let text = text.trim();
    let starts_well = text.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.'));
    if !starts_well || text.len() > 60 {
        return None;
    }
    if let Ok(value) = text.parse::<f64>() {
        return Some(value).filter(|v| v.is_finite());
    }
    let mut plain = text.replace(['d', 'D'], "e");
    if !plain.contains(['e', 'E'])
        && let Some(at) = plain.char_indices().skip(1).find(|(_, c)| matches!(c, '+' | '-')).map(|(i, _)| i)
    {
        plain.insert(at, 'e');
    }
    plain.parse::<f64>().ok().filter(|v| v.is_finite())
}

/// A piece of a line by columns, from 0; shorter or none where the line ends.
pub(super) fn columns(line: &str, from: usize, to: usize) -> &str {
    let from = from.min(line.len());
    line.get(from..to.min(line.len()).max(from)).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_every_dialect_are_read() {
        for (text, value) in [("1.5", 1.5), (" -2.5D+03 ", -2500.0), ("1.5+3", 1500.0), (".25-2", 0.0025), ("7", 7.0)] {
            assert_eq!(number(text), Some(value), "{text}");
        }
        for text in ["", "nan", "inf", "1e999", "x", "+", "1.5+-3", "infinity"] {
            assert_eq!(number(text), None, "{text}");
        }
    }

    #[test]
    fn lines_end_as_on_every_system() {
        let mut lines = Lines::new(b"a\r\nb\n\nc\xff d");
        let all: Vec<&str> = std::iter::from_fn(|| lines.next()).collect();
        assert_eq!((all, lines.number), (vec!["a", "b", "", "c"], 4));
    }
}
