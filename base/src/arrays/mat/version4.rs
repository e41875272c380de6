//! Files of version 4: matrices one after the other, each behind a header of five integers.
//!
//! ```text
//! type = 1000 M + 100 O + 10 P + T   machine, 0, type of numbers, kind (numbers, text, sparse)
//! rows, columns, imagf, namlen       imagf 1: imaginary parts follow; the name ends with a NUL
//! ```

use super::matrix::Budget;
use super::{MatError, Value, Workspace};
use retune_linalg::Complex;

const HEADER: usize = 20;
/// Longer names there are not.
const LONGEST_NAME: usize = 256;

struct Header {
    machine: u32,
    precision: u32,
    kind: u32,
    rows: usize,
    columns: usize,
    is_complex: bool,
    name: usize,
    is_big: bool,
}

/// The header of a matrix in the byte order that makes sense of it.
fn header(bytes: &[u8]) -> Option<Header> {
    let integer = |at: usize, is_big: bool| {
        let b: [u8; 4] = bytes.get(4 * at..4 * at + 4)?.try_into().ok()?;
        Some(if is_big { u32::from_be_bytes(b) } else { u32::from_le_bytes(b) })
    };
    [false, true].into_iter().find_map(|is_big| {
        let code = integer(0, is_big)?;
        let [machine, zero, precision, kind] = [code / 1000, code / 100 % 10, code / 10 % 10, code % 10];
        let (imaginary, name) = (integer(3, is_big)?, integer(4, is_big)? as usize);
        let is_sound = machine <= 4 && zero == 0 && precision <= 5 && kind <= 2 && imaginary <= 1;
        // The machine of the code is that of the bytes.
        let is_own = machine > 1 || (machine == 1) == is_big;
        (is_sound && is_own && (1..=LONGEST_NAME).contains(&name)).then_some(Header {
            machine,
            precision,
            kind,
            rows: integer(1, is_big)? as usize,
            columns: integer(2, is_big)? as usize,
            is_complex: imaginary == 1,
            name,
            is_big,
        })
    })
}

/// The name of a matrix, without its NUL.
fn name<'a>(bytes: &'a [u8], h: &Header) -> Option<&'a str> {
    let name = bytes.get(HEADER..HEADER + h.name)?;
    let name = std::str::from_utf8(name.strip_suffix(&[0]).unwrap_or(name)).ok()?;
    let is_name = name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    is_name.then_some(name)
}

/// Whether a file begins with a matrix of version 4: a sound header and behind it a name of MATLAB.
pub(super) fn is_version4(bytes: &[u8]) -> bool {
    header(bytes).is_some_and(|h| name(bytes, &h).is_some())
}

/// Reads the matrices of a file.
pub(super) fn read(bytes: &[u8], budget: &Budget) -> Result<Workspace, MatError> {
    let mut found = Workspace::default();
    let mut rest = bytes;
    while !rest.is_empty() {
        let malformed = |name: &str, why| MatError::Malformed { name: name.to_owned(), why };
        let last = found.variables.last().map_or("", |v: &(String, Value)| &v.0);
        let h = header(rest).ok_or_else(|| malformed(last, "what follows it is not a matrix"))?;
        let name = name(rest, &h).ok_or_else(|| malformed(last, "the name of what follows it is none"))?.to_owned();
        let machine = [None, None, Some("VAX"), Some("VAX"), Some("Cray")][h.machine as usize];
        if let Some(machine) = machine {
            return Err(MatError::Machine { name, machine });
        }
        let width = [8, 4, 4, 2, 2, 1][h.precision as usize];
        let count = h.rows.checked_mul(h.columns).ok_or_else(|| malformed(&name, "its dimensions are too large"))?;
        let parts = if h.is_complex { 2 } else { 1 };
        let size = count.checked_mul(width * parts).ok_or_else(|| malformed(&name, "its dimensions are too large"))?;
        let data = rest.get(HEADER + h.name..).and_then(|r| r.get(..size));
        let data = data.ok_or(MatError::Truncated { what: "the values of a matrix" })?;
        budget.take(count * parts, 2 * size_of::<f64>())?;
        let numbers: Vec<f64> = data.chunks_exact(width).map(|b| number(b, h.precision, h.is_big)).collect();
        let dims = vec![h.rows, h.columns];
        let value = match (h.kind, h.is_complex) {
            (0, false) => Value::Real { dims, values: numbers },
            (0, true) => {
                let (re, im) = numbers.split_at(count);
                let values = re.iter().zip(im).map(|(re, im)| Complex::new(*re, *im)).collect();
                Value::Complex { dims, values }
            }
            (1, _) => {
                budget.take(h.rows, size_of::<String>() + size_of::<f64>())?;
                let character = |v: &f64| char::from_u32(*v as u32).unwrap_or(char::REPLACEMENT_CHARACTER);
                let row = |r: usize| numbers[..count].iter().skip(r).step_by(h.rows).map(character).collect::<String>();
                Value::Text((0..h.rows).map(row).collect::<Vec<_>>().join("\n"))
            }
            _ => Value::Other,
        };
        found.variables.push((name, value));
        rest = &rest[HEADER + h.name + size..];
    }
    Ok(found)
}

/// A number of a type by its digit: f64, f32, i32, i16, u16, u8.
fn number(bytes: &[u8], precision: u32, is_big: bool) -> f64 {
    let join = |acc: u64, b: &u8| (acc << 8) | u64::from(*b);
    let bits = if is_big { bytes.iter().fold(0, join) } else { bytes.iter().rev().fold(0, join) };
    match precision {
        0 => f64::from_bits(bits),
        1 => f64::from(f32::from_bits(bits as u32)),
        2 => f64::from(bits as u32 as i32),
        3 => f64::from(bits as u16 as i16),
        _ => bits as f64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix of version 4: code of the type, rows, columns, name, bytes of its numbers.
    fn matrix(code: u32, rows: u32, columns: u32, is_complex: bool, name: &str, data: &[u8]) -> Vec<u8> {
        let integer = |v: u32| if code >= 1000 { v.to_be_bytes() } else { v.to_le_bytes() };
        let mut bytes: Vec<u8> =
            [code, rows, columns, u32::from(is_complex), name.len() as u32 + 1].into_iter().flat_map(integer).collect();
        bytes.extend(name.as_bytes());
        bytes.push(0);
        bytes.extend(data);
        bytes
    }

    #[test]
    fn matrices_of_either_byte_order_and_of_text_are_read() {
        let floats = |v: &[f64]| v.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        let mut file = matrix(0, 2, 1, true, "H", &floats(&[1.0, 2.0, 3.0, 4.0]));
        file.extend(matrix(30, 1, 2, false, "k", &[255, 255, 2, 0]));
        // Rows "ab" and "cd", columns first.
        file.extend(matrix(51, 2, 2, false, "names", b"acbd"));
        assert!(super::super::is_mat(&file));
        let found = super::super::read(&file).unwrap().variables;
        let complex = vec![Complex::new(1.0, 3.0), Complex::new(2.0, 4.0)];
        assert_eq!(found[0], ("H".into(), Value::Complex { dims: vec![2, 1], values: complex }));
        assert_eq!(found[1], ("k".into(), Value::Real { dims: vec![1, 2], values: vec![-1.0, 2.0] }));
        assert_eq!(found[2], ("names".into(), Value::Text("ab\ncd".into())));
        let big = matrix(1010, 1, 1, false, "f", &7.5_f32.to_be_bytes());
        let value = Value::Real { dims: vec![1, 1], values: vec![7.5] };
        assert_eq!(super::super::read(&big).unwrap().variables, [("f".to_string(), value)]);
        let vax = matrix(2000, 1, 1, false, "f", &[0; 8]);
        assert!(super::super::read(&vax).unwrap_err().to_string().contains("VAX"));
        assert!(!super::super::is_mat(b"    -1\n   151\nsome text of a universal file"));
        file.truncate(file.len() - 3);
        assert_eq!(super::super::read(&file), Err(MatError::Truncated { what: "the values of a matrix" }));
    }

    #[test]
    fn counts_beyond_the_file_are_refused() {
        let file = matrix(0, u32::MAX, u32::MAX, false, "f", &[0; 16]);
        assert!(super::super::read(&file).is_err());
        // Rows of text that are empty take no bytes, but would take memory.
        let file = matrix(51, u32::MAX, 0, false, "t", &[]);
        assert!(matches!(super::super::read(&file), Err(MatError::TooLarge { .. })));
    }
}
