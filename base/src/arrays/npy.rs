//! NumPy `.npy` files: arrays of numbers.
//!
//! Versions 1, 2 and 3; floats, complex numbers, integers and booleans (`f2` ... `f8`, `c8`, `c16`, `i1` ... `i8`, `u1` ... `u8`,
//! `b1`) in either byte order, C or FORTRAN order. Values come in C order (last index fastest). The counts of the header are checked
//! against the length of the file, and what its values take in memory against a limit.
//!
//! Source: NumPy documentation, numpy.lib.format, "NPY format".

use retune_linalg::Complex;

/// Values of an array, in C order.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Real numbers.
    Real(Vec<f64>),
    /// Complex numbers.
    Complex(Vec<Complex<f64>>),
}

/// An array.
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    /// Length of each dimension.
    pub shape: Vec<usize>,
    /// Values.
    pub values: Values,
}

impl Array {
    /// Bytes of its values in memory.
    pub(super) fn n_bytes(&self) -> usize {
        match &self.values {
            Values::Real(v) => size_of_val(v.as_slice()),
            Values::Complex(v) => size_of_val(v.as_slice()),
        }
    }
}

/// Why an `.npy` file cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NpyError {
    /// Not the format.
    #[error("this is not a .npy file of version 1, 2 or 3: {0}")]
    Header(&'static str),
    /// A type that is not read.
    #[error("values of type `{}`; read are integers, booleans, floats and complex numbers of up to 64 bits a part: `numpy.save(name, array.astype('f8'))`, or 'c16'", .0.escape_debug())]
    Type(String),
    /// Values that take more memory than there may be.
    #[error("its values take more than {} MiB in memory", .0 >> 20)]
    TooLarge(usize),
    /// Values missing.
    #[error("{found} bytes of values, the shape {shape:?} needs {needed}")]
    Length {
        /// Shape by the header.
        shape: Vec<usize>,
        /// Bytes that it needs; `usize::MAX` if more than an address can say.
        needed: usize,
        /// Bytes there are.
        found: usize,
    },
}

const MAGIC: &[u8] = b"\x93NUMPY";

/// Reads an array.
pub fn read(bytes: &[u8]) -> Result<Array, NpyError> {
    let rest = bytes.strip_prefix(MAGIC).ok_or(NpyError::Header("the magic bytes are missing"))?;
    let short = NpyError::Header("it ends within the header");
    let (length, rest) = match rest {
        [1, _, a, b, rest @ ..] => (usize::from(u16::from_le_bytes([*a, *b])), rest),
        [2 | 3, _, a, b, c, d, rest @ ..] => (u32::from_le_bytes([*a, *b, *c, *d]) as usize, rest),
        [_, _, _, _, ..] => return Err(NpyError::Header("unknown version")),
        _ => return Err(short),
    };
    let (header, data) = rest.split_at_checked(length).ok_or(short)?;
    let header = std::str::from_utf8(header).map_err(|_| NpyError::Header("its header is not text"))?;
    let after = |key: &str| {
        let text = header.split_once(key)?.1.trim_start().strip_prefix(':')?;
        Some(text.trim_start())
    };
    let missing = NpyError::Header("`descr`, `fortran_order` or `shape` is missing or odd");
    let descr = after("'descr'").ok_or(missing.clone())?;
    let Some((descr, _)) = descr.strip_prefix('\'').and_then(|t| t.split_once('\'')) else {
        // A list of fields.
        return Err(NpyError::Type(descr.split_once(']').map_or(descr, |(d, _)| d).chars().take(60).collect()));
    };
    let order = after("'fortran_order'").ok_or(missing.clone())?;
    let is_fortran = order.starts_with("True");
    let shape = after("'shape'").and_then(|t| t.strip_prefix('(')?.split_once(')')).map(|(s, _)| s);
    let shape: Option<Vec<usize>> = shape
        .ok_or(missing.clone())?
        .split(',')
        .map(str::trim)
        .filter(|s| !s.is_empty())
        .map(|s| s.parse().ok())
        .collect();
    let shape = shape.ok_or(missing)?;
    let (kind, is_big, width) = number_type(descr).ok_or_else(|| NpyError::Type(descr.to_owned()))?;
    let is_complex = kind == 'c';
    let per_value = if is_complex { 2 * width } else { width };
    let count = shape.iter().try_fold(1_usize, |n, d| n.checked_mul(*d));
    let needed = count.and_then(|n| n.checked_mul(per_value)).unwrap_or(usize::MAX);
    if data.len() < needed {
        return Err(NpyError::Length { shape, needed, found: data.len() });
    }
    let limit = super::mat::MOST_MEMORY.max(bytes.len().saturating_mul(4));
    if needed / width > limit / size_of::<f64>() {
        return Err(NpyError::TooLarge(limit));
    }
    let floats: Vec<f64> = data[..needed].chunks_exact(width).map(|b| number(b, kind, is_big)).collect();
    let values = if is_complex {
        let values = floats.chunks_exact(2).map(|v| Complex::new(v[0], v[1])).collect();
        Values::Complex(if is_fortran { to_c_order(&shape, values) } else { values })
    } else {
        Values::Real(if is_fortran { to_c_order(&shape, floats) } else { floats })
    };
    Ok(Array { shape, values })
}

/// The one word that a file of text holds: of type `|S3` or `<U3`, without dimensions; `None` of any other file.
pub fn read_word(bytes: &[u8]) -> Option<String> {
    let rest = bytes.strip_prefix(MAGIC)?;
    let (length, rest) = match rest {
        [1, _, a, b, rest @ ..] => (usize::from(u16::from_le_bytes([*a, *b])), rest),
        [2 | 3, _, a, b, c, d, rest @ ..] => (u32::from_le_bytes([*a, *b, *c, *d]) as usize, rest),
        _ => return None,
    };
    let (header, data) = rest.split_at_checked(length)?;
    let header = std::str::from_utf8(header).ok()?;
    let (_, descr) = header.split_once("'descr'")?;
    let (descr, _) = descr.trim_start().strip_prefix(':')?.trim_start().strip_prefix('\'')?.split_once('\'')?;
    let is_scalar = header.split_once("'shape'")?.1.trim_start().strip_prefix(':')?.trim_start().starts_with("()");
    let letters: Vec<u32> = match descr.as_bytes() {
        _ if !is_scalar => return None,
        [b'|', b'S', ..] => data.iter().map(|b| u32::from(*b)).collect(),
        [b'<', b'U', ..] => data.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect(),
        [b'>', b'U', ..] => data.chunks_exact(4).map(|b| u32::from_be_bytes([b[0], b[1], b[2], b[3]])).collect(),
        _ => return None,
    };
    letters.into_iter().take_while(|c| *c != 0).take(64).map(char::from_u32).collect()
}

/// Kind (`f`, `c`, `i`, `u`, `b`), byte order and bytes of each part of a type such as `<f8`, `>c16`, `|u1`.
fn number_type(descr: &str) -> Option<(char, bool, usize)> {
    let (order, rest) = match descr.as_bytes() {
        [b'<' | b'|' | b'=', ..] => (false, &descr[1..]),
        [b'>' | b'!', ..] => (true, &descr[1..]),
        _ => (false, descr),
    };
    let kind = rest.chars().next()?;
    let bytes: usize = rest.get(1..)?.parse().ok()?;
    let width = if kind == 'c' { bytes / 2 } else { bytes };
    let is_known = match kind {
        'f' => matches!(bytes, 2 | 4 | 8),
        'c' => matches!(bytes, 8 | 16),
        'i' | 'u' => matches!(bytes, 1 | 2 | 4 | 8),
        'b' => bytes == 1,
        _ => false,
    };
    is_known.then_some((kind, order, width))
}

fn number(bytes: &[u8], kind: char, is_big: bool) -> f64 {
    let join = |acc: u64, b: &u8| (acc << 8) | u64::from(*b);
    let bits = if is_big { bytes.iter().fold(0, join) } else { bytes.iter().rev().fold(0, join) };
    match (kind, bytes.len()) {
        ('f', 2) => half(bits as u16),
        ('f' | 'c', 4) => f64::from(f32::from_bits(bits as u32)),
        ('f' | 'c', _) => f64::from_bits(bits),
        ('i', 1) => f64::from(bits as u8 as i8),
        ('i', 2) => f64::from(bits as u16 as i16),
        ('i', 4) => f64::from(bits as u32 as i32),
        ('i', _) => bits as i64 as f64,
        _ => bits as f64,
    }
}

/// A number of half precision: 1 sign, 5 exponent, 10 mantissa.
fn half(bits: u16) -> f64 {
    let mantissa = f64::from(bits & 0x3ff);
    let size = match (bits >> 10) & 0x1f {
        0 => mantissa * 2.0_f64.powi(-24),
        31 if mantissa == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        exponent => (1024.0 + mantissa) * 2.0_f64.powi(i32::from(exponent) - 25),
    };
    if bits >> 15 == 0 { size } else { -size }
}

/// Values whose first index runs fastest, to those whose last one does.
pub(crate) fn to_c_order<T: Copy>(shape: &[usize], values: Vec<T>) -> Vec<T> {
    if shape.len() < 2 {
        return values;
    }
    let mut index = vec![0; shape.len()];
    let mut strides = vec![1; shape.len()];
    for d in 1..shape.len() {
        strides[d] = strides[d - 1] * shape[d - 1];
    }
    let mut sorted = Vec::with_capacity(values.len());
    for _ in 0..values.len() {
        sorted.push(values[index.iter().zip(&strides).map(|(i, s)| i * s).sum::<usize>()]);
        for d in (0..shape.len()).rev() {
            index[d] += 1;
            if index[d] < shape[d] {
                break;
            }
            index[d] = 0;
        }
    }
    sorted
}

/// Writes an array as `<f8` or `<c16`, version 1, C order; every bit is kept.
///
/// # Panics
/// If the shape does not fit the number of values, or has more than some thousands of dimensions.
pub fn write(array: &Array) -> Vec<u8> {
    let (descr, floats): (_, Vec<f64>) = match &array.values {
        Values::Real(v) => ("<f8", v.clone()),
        Values::Complex(v) => ("<c16", v.iter().flat_map(|z| [z.re, z.im]).collect()),
    };
    let per_value = if descr == "<c16" { 2 } else { 1 };
    assert_eq!(array.shape.iter().product::<usize>() * per_value, floats.len(), "shape and values");
    let shape: Vec<String> = array.shape.iter().map(|d| format!("{d},")).collect();
    let mut bytes = header(descr, &shape.concat());
    bytes.extend(floats.iter().flat_map(|v| v.to_le_bytes()));
    bytes
}

/// What stands before the values of an array of version 1; `shape` is `2,3,`.
fn header(descr: &str, shape: &str) -> Vec<u8> {
    let mut header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({shape}), }}");
    // Data begin at a multiple of 64 bytes, after the magic, version and length (10 bytes) and a line end.
    let padding = 63 - (header.len() + 10) % 64;
    header.extend(std::iter::repeat_n(' ', padding));
    header.push('\n');
    let mut bytes = MAGIC.to_vec();
    bytes.extend([1, 0]);
    let length = u16::try_from(header.len()).expect("the shape is short");
    bytes.extend(length.to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes
}

/// Writes whole numbers as `<i8`, one dimension.
pub fn write_integers(values: &[i64]) -> Vec<u8> {
    let mut bytes = header("<i8", &format!("{},", values.len()));
    bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    bytes
}

/// Writes a word of ASCII letters as `|S`, without dimensions: [`read_word`] reads it.
pub fn write_word(word: &str) -> Vec<u8> {
    let mut bytes = header(&format!("|S{}", word.len()), "");
    bytes.extend(word.as_bytes());
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(header: &str, data: &[u8]) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend([1, 0]);
        bytes.extend(u16::try_from(header.len()).unwrap().to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(data);
        bytes
    }

    #[test]
    fn arrays_come_back_bit_for_bit() {
        let complex = (0..6).map(|i| Complex::new(f64::from(i) / 3.0, -f64::from(i))).collect();
        for array in [
            Array { shape: vec![2, 3], values: Values::Complex(complex) },
            Array { shape: vec![4], values: Values::Real(vec![0.1, -0.0, f64::INFINITY, 1.0e-310]) },
            Array { shape: vec![], values: Values::Real(vec![7.0]) },
            Array { shape: vec![0, 5], values: Values::Real(vec![]) },
        ] {
            let bytes = write(&array);
            let header_end = bytes.iter().position(|b| *b == b'\n').unwrap() + 1;
            assert_eq!(header_end % 64, 0);
            assert_eq!(read(&bytes).unwrap(), array);
        }
    }

    #[test]
    fn fortran_order_byte_order_and_single_precision_are_undone() {
        // numpy.save of numpy.asfortranarray([[1, 2, 3], [4, 5, 6]]) as >f4: columns first.
        let data: Vec<u8> = [1.0_f32, 4.0, 2.0, 5.0, 3.0, 6.0].iter().flat_map(|v| v.to_be_bytes()).collect();
        let header = "{'descr': '>f4', 'fortran_order': True, 'shape': (2, 3), }\n";
        let array = read(&file(header, &data)).unwrap();
        assert_eq!(array.values, Values::Real(vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]));
    }

    #[test]
    fn numbers_of_any_type_are_read() {
        for (descr, data, expected) in [
            ("<i4", &[254, 255, 255, 255, 1, 0, 0, 0][..], [-2.0, 1.0]),
            (">i2", &[255, 254, 0, 1], [-2.0, 1.0]),
            ("|i1", &[254, 1], [-2.0, 1.0]),
            ("<u2", &[254, 255, 1, 0], [65534.0, 1.0]),
            ("|b1", &[0, 1], [0.0, 1.0]),
            (">u8", &[0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 2], [256.0, 2.0]),
            ("<i8", &[255, 255, 255, 255, 255, 255, 255, 255, 3, 0, 0, 0, 0, 0, 0, 0], [-1.0, 3.0]),
            // 1.5 and the least number above zero.
            ("<f2", &[0, 0x3e, 1, 0], [1.5, 2.0_f64.powi(-24)]),
            (">f2", &[0xc0, 0, 0x7c, 0], [-2.0, f64::INFINITY]),
        ] {
            let header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': (2,), }}\n");
            assert_eq!(read(&file(&header, data)).unwrap().values, Values::Real(expected.to_vec()), "{descr}");
        }
        for descr in ["'<f16'", "'|O'", "'<U4'", "[('f', '<f8'), ('a', '<f8')]", "'\u{1b}x'"] {
            let header = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': (2,), }}\n");
            let said = read(&file(&header, &[0; 64])).unwrap_err().to_string();
            assert!(said.starts_with("values of type") && !said.contains('\u{1b}'), "{said}");
        }
    }

    #[test]
    fn false_headers_are_refused_without_asking_for_memory() {
        let huge = "{'descr': '<f8', 'fortran_order': False, 'shape': (4000000000, 4000000000, 4000000000), }\n";
        assert!(matches!(read(&file(huge, &[0; 8])), Err(NpyError::Length { needed: usize::MAX, .. })));
        let text = "{'descr': '<U4', 'fortran_order': False, 'shape': (1,), }\n";
        assert!(matches!(read(&file(text, &[0; 16])), Err(NpyError::Type(_))));
        for end in 0..20 {
            assert!(read(&file(huge, &[])[..end]).is_err());
        }
    }

    #[test]
    fn mutated_files_do_no_harm() {
        let seed = write(&Array { shape: vec![2, 3], values: Values::Real(vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]) });
        crate::arrays::mutate::all(&[seed], 5_000, |bytes| read(bytes).is_ok());
    }
}
