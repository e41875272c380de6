//! NumPy `.npy` files: arrays of real and complex floats.
//!
//! Versions 1, 2 and 3; `f4`, `f8`, `c8`, `c16` in either byte order, C or FORTRAN order. Values come in C order (last
//! index fastest). The counts of the header are checked against the length of the file.
//!
//! Source: NumPy documentation, numpy.lib.format, "NPY format".

use crate::linalg::Complex;

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
    /// Number of values.
    pub(super) fn n_values(&self) -> usize {
        match &self.values {
            Values::Real(v) => v.len(),
            Values::Complex(v) => v.len(),
        }
    }
}

/// Why an `.npy` file cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NpyError {
    /// Not the format.
    #[error("this is no .npy file of version 1, 2 or 3: {0}")]
    Header(&'static str),
    /// A type that is not read.
    #[error("values of type `{0}`; read are <f4, <f8, <c8, <c16 and their big-endian forms >f4, ...")]
    Type(String),
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
    let descr = after("'descr'").and_then(|t| t.strip_prefix('\'')?.split_once('\'')).map(|(d, _)| d);
    let descr = descr.ok_or(missing.clone())?;
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
    let (is_big, width, is_complex) = match descr {
        "<f4" | ">f4" => (descr.starts_with('>'), 4, false),
        "<f8" | ">f8" => (descr.starts_with('>'), 8, false),
        "<c8" | ">c8" => (descr.starts_with('>'), 4, true),
        "<c16" | ">c16" => (descr.starts_with('>'), 8, true),
        other => return Err(NpyError::Type(other.to_owned())),
    };
    let per_value = if is_complex { 2 * width } else { width };
    let count = shape.iter().try_fold(1_usize, |n, d| n.checked_mul(*d));
    let needed = count.and_then(|n| n.checked_mul(per_value)).unwrap_or(usize::MAX);
    if data.len() < needed {
        return Err(NpyError::Length { shape, needed, found: data.len() });
    }
    let floats: Vec<f64> = data[..needed].chunks_exact(width).map(|b| float(b, is_big)).collect();
    let values = if is_complex {
        let values = floats.chunks_exact(2).map(|v| Complex::new(v[0], v[1])).collect();
        Values::Complex(if is_fortran { to_c_order(&shape, values) } else { values })
    } else {
        Values::Real(if is_fortran { to_c_order(&shape, floats) } else { floats })
    };
    Ok(Array { shape, values })
}

fn float(bytes: &[u8], is_big: bool) -> f64 {
    let join = |acc: u64, b: &u8| (acc << 8) | u64::from(*b);
    let bits = if is_big { bytes.iter().fold(0, join) } else { bytes.iter().rev().fold(0, join) };
    if bytes.len() == 4 { f64::from(f32::from_bits(bits as u32)) } else { f64::from_bits(bits) }
}

/// Values whose first index runs fastest, to those whose last one does.
fn to_c_order<T: Copy>(shape: &[usize], values: Vec<T>) -> Vec<T> {
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
    let mut header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({}), }}", shape.concat());
    // Data begin at a multiple of 64 bytes, after the magic, version and length (10 bytes) and a line end.
    let padding = 63 - (header.len() + 10) % 64;
    header.extend(std::iter::repeat_n(' ', padding));
    header.push('\n');
    let mut bytes = MAGIC.to_vec();
    bytes.extend([1, 0]);
    let length = u16::try_from(header.len()).expect("the shape is short");
    bytes.extend(length.to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(floats.iter().flat_map(|v| v.to_le_bytes()));
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
        use rand::{Rng, RngExt, SeedableRng};
        let seed: Vec<u8> =
            write(&Array { shape: vec![2, 3], values: Values::Real(vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]) });
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(7);
        let mut read_at_all = 0;
        for _ in 0..5_000 {
            let mut bytes = seed.clone();
            for _ in 0..rng.random_range(1..4) {
                let at = rng.random_range(0..bytes.len());
                match rng.random_range(0..3) {
                    0 => bytes[at] = rng.next_u32() as u8,
                    1 => bytes[at] = b"\t,;\n.0-9'()"[rng.random_range(0..11)],
                    _ => bytes.truncate(at + 1),
                }
            }
            read_at_all += u32::from(read(&bytes).is_ok());
        }
        assert!(read_at_all > 0);
    }
}
