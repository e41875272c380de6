//! MATLAB files of version 5 (`save -v6`, `-v7`) and 4 (`-v4`): the named variables of a workspace.
//!
//! Read: numeric arrays (all integer and floating types, complex, logical), text, cells, structures, sparse matrices;
//! either byte order; compressed or not. Function handles, objects and tables come as [`Value::Other`]. Values come in
//! MATLAB's order, first index fastest. Files of version 7.3 are HDF5 and are refused with the remedy.
//!
//! An own reader, because the crates there are either print to the terminal and leave out structures and text without
//! a word, or bind a C library. Counts are checked against the bytes there are before anything is stored, nesting is
//! limited, and all that unfolds or widens comes out of one budget of memory.
//!
//! Source: The MathWorks, MAT-File Format, R2023b, chapters "Level 5 MAT-Files" and "Level 4 MAT-Files".

mod matrix;
mod version4;

pub use matrix::Value;

use matrix::{Budget, Bytes};

/// Why a MATLAB file cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MatError {
    /// Not the format.
    #[error("this is not a MATLAB file of version 4 or 5")]
    NotMat,
    /// HDF5.
    #[error(
        "this is a MATLAB file of version 7.3 or another HDF5 file, which is not read; in MATLAB load it and save it with `save(name, '-v7')`"
    )]
    Version73,
    /// Floating-point numbers of machines of the past.
    #[error("variable `{name}` has the numbers of a {machine}, which are not read; save it again in a MATLAB of today")]
    Machine {
        /// The variable.
        name: String,
        /// The machine.
        machine: &'static str,
    },
    /// Bytes missing.
    #[error("the file ends within {what}")]
    Truncated {
        /// Part of the file.
        what: &'static str,
    },
    /// A part that contradicts itself.
    #[error("variable `{}`: {why}", name.escape_debug())]
    Malformed {
        /// The variable, as far as known.
        name: String,
        /// What is wrong.
        why: &'static str,
    },
    /// A compressed variable that cannot be unfolded.
    #[error("a compressed variable is damaged")]
    Compressed,
    /// Values that take more memory than there may be.
    #[error("its values take more than {} MiB in memory; save the variables that are needed alone, or in several files", limit >> 20)]
    TooLarge {
        /// The limit, bytes.
        limit: usize,
    },
}

/// What a file holds.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Workspace {
    /// Names and values, in their order.
    pub variables: Vec<(String, Value)>,
    /// What was odd.
    pub notes: Vec<String>,
}

/// Unfolded and widened, the values of a file may take this much memory, or four times the file where that is more.
pub(crate) const MOST_MEMORY: usize = 512 << 20;
/// No compression unfolds beyond this ratio (deflate, 258 bytes for two bits).
pub(crate) const MOST_RATIO: usize = 1032;

const MI_MATRIX: u32 = 14;
const MI_COMPRESSED: u32 = 15;
const HEADER: usize = 128;

/// Byte order of a file of version 5.
fn is_big(bytes: &[u8]) -> Option<bool> {
    match bytes.get(126..HEADER)? {
        b"IM" => Some(false),
        b"MI" => Some(true),
        _ => None,
    }
}

fn is_hdf5(bytes: &[u8]) -> bool {
    const SIGNATURE: &[u8] = b"\x89HDF\r\n\x1a\n";
    // The superblock stands at the beginning, or behind a block of 512 bytes that is the user's.
    bytes.starts_with(SIGNATURE)
        || bytes.get(512..).is_some_and(|b| b.starts_with(SIGNATURE))
        || bytes.starts_with(b"MATLAB 7.3")
}

/// Whether a file is one of MATLAB, of any version, by its first bytes.
pub fn is_mat(bytes: &[u8]) -> bool {
    bytes.starts_with(b"MATLAB")
        || is_hdf5(bytes)
        || (is_big(bytes).is_some() && matches!(&bytes[124..126], [0, 1] | [1, 0]))
        || version4::is_version4(bytes)
}

/// Reads the variables of a file, in their order.
///
/// # Errors
/// [`MatError`]: another format, parts that contradict each other, values that take too much memory.
pub fn read(bytes: &[u8]) -> Result<Workspace, MatError> {
    if is_hdf5(bytes) {
        return Err(MatError::Version73);
    }
    let budget = Budget::new(MOST_MEMORY.max(bytes.len().saturating_mul(4)));
    if version4::is_version4(bytes) {
        return version4::read(bytes, &budget);
    }
    let is_big = is_big(bytes).ok_or(MatError::NotMat)?;
    let mut found = Workspace::default();
    let mut input = Bytes::new(&bytes[HEADER..], is_big, &budget);
    while !input.is_empty() {
        let variable = match input.peek("a variable")? {
            MI_COMPRESSED => {
                let (_, data) = input.element("a variable", true)?;
                let limit = budget.left().min(data.len().saturating_mul(MOST_RATIO));
                let unfolded = unfold(data, limit)
                    .ok_or(MatError::Compressed)?
                    .ok_or(MatError::TooLarge { limit: MOST_MEMORY })?;
                budget.take(unfolded.len(), 1)?;
                let variable = matrix::array(&mut Bytes::new(&unfolded, is_big, &budget), 0, &mut found.notes)?;
                budget.give(unfolded.len());
                variable
            }
            // Other elements at this level hold nothing of the workspace.
            _ => matrix::array(&mut input, 0, &mut found.notes)?,
        };
        found.variables.extend(variable);
    }
    // The workspace of objects has no name.
    found.variables.retain(|(name, _)| !name.is_empty());
    Ok(found)
}

/// The bytes of a zlib stream: `None` if it is damaged, `Some(None)` if it unfolds beyond a limit.
#[expect(clippy::option_option, reason = "damaged and too large are two answers")]
fn unfold(data: &[u8], limit: usize) -> Option<Option<Vec<u8>>> {
    use miniz_oxide::inflate::{TINFLStatus, decompress_to_vec_zlib_with_limit};
    match decompress_to_vec_zlib_with_limit(data, limit) {
        Ok(bytes) => Some(Some(bytes)),
        Err(e) if e.status == TINFLStatus::HasMoreOutput => Some(None),
        Err(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, RngExt, SeedableRng};
    use retune_linalg::Complex;

    fn open(path: &str) -> Option<Vec<u8>> {
        let path = crate::arrays::shared_data(path)?;
        Some(std::fs::read(path).unwrap())
    }

    /// Values printed by scipy 1.17.1.
    #[test]
    fn real_files_have_the_values_that_scipy_reads() {
        let Some(bytes) = open("maewing1_geri/gvt_mode_shapes/fst.mat") else { return };
        let variables = read(&bytes).unwrap().variables;
        let Value::Real { dims, values } = &variables[1].1 else { panic!("real") };
        assert_eq!((variables[1].0.as_str(), dims.as_slice(), values.len()), ("modeshape2", &[28, 1][..], 28));
        assert_eq!((values[0], values[27]), (-0.051188020134289566, -0.10902515688043009));

        let bytes = open("cruise_missile_wing/mode_shapes/1stNaturalFreq18.mat").unwrap();
        let variables = read(&bytes).unwrap().variables;
        let Value::Complex { dims, values } = &variables[0].1 else { panic!("complex") };
        assert_eq!((variables[0].0.as_str(), dims.as_slice()), ("U1", &[18, 1][..]));
        assert_eq!(values[17], Complex::new(0.47000110015547586, 9.736232673257463e-15));

        // Mass in kg and others, as a structure.
        let bytes = open("bff_fem/AircraftData_v02.mat").unwrap();
        let variables = read(&bytes).unwrap().variables;
        let Value::Structure { fields, .. } = &variables[0].1 else { panic!("structure") };
        let names: Vec<&str> = fields.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["s", "c", "cg", "b", "mAC", "IB"]);
        assert_eq!(fields[4].1[0], Value::Real { dims: vec![1, 1], values: vec![5.439190332702895] });

        let bytes = open("cruise_missile_wing/fe_beam/WingBeamforMAC.mat").unwrap();
        let variables = read(&bytes).unwrap().variables;
        let find = |name: &str| &variables.iter().find(|(n, _)| n == name).unwrap().1;
        let Value::Sparse { rows, columns, entries } = find("K") else { panic!("K") };
        assert_eq!((*rows, *columns, entries.len()), (141, 141, 1627));
        let largest = entries.iter().fold(0.0_f64, |m, e| m.max(e.2.re));
        assert_eq!(largest, 747558757683.783);
        assert_eq!(find("filenameroot"), &Value::Text("WingBeamforMAC".into()));
        let Value::Structure { dims, fields } = find("element") else { panic!("element") };
        assert_eq!((dims.as_slice(), fields.len(), fields[0].1.len()), (&[1, 27][..], 7, 27));
    }

    fn element(kind: u32, data: &[u8]) -> Vec<u8> {
        let mut bytes = kind.to_be_bytes().to_vec();
        bytes.extend((data.len() as u32).to_be_bytes());
        bytes.extend(data);
        bytes.resize(bytes.len().next_multiple_of(8), 0);
        bytes
    }

    /// A big-endian file with a complex array of 16-bit integers, uncompressed.
    fn big_endian() -> Vec<u8> {
        let mut matrix = element(6, &[0, 0, 8, 10, 0, 0, 0, 0]);
        matrix.extend(element(5, &[0, 0, 0, 2, 0, 0, 0, 2]));
        // A small element: two bytes of name in the tag.
        matrix.extend([0, 2, 0, 1, b'a', b'b', 0, 0]);
        matrix.extend(element(3, &[0, 1, 0, 2, 0, 3, 0xff, 0xff]));
        matrix.extend(element(3, &[0, 0, 0, 0, 0, 0, 0, 5]));
        let mut file = vec![b' '; 124];
        file.extend([1, 0, b'M', b'I']);
        file.extend(element(14, &matrix));
        file
    }

    #[test]
    fn the_other_byte_order_and_small_elements_are_read() {
        let variables = read(&big_endian()).unwrap().variables;
        let values = [(1.0, 0.0), (2.0, 0.0), (3.0, 0.0), (-1.0, 5.0)].map(|(re, im)| Complex::new(re, im)).to_vec();
        assert_eq!(variables, [("ab".to_owned(), Value::Complex { dims: vec![2, 2], values })]);
    }

    #[test]
    fn hostile_files_are_refused() {
        assert_eq!(read(b"hello"), Err(MatError::NotMat));
        let mut bytes = big_endian();
        // 2^31 - 1 rows without values.
        let dims = bytes.windows(8).position(|w| w == [0, 0, 0, 2, 0, 0, 0, 2]).unwrap();
        bytes[dims..dims + 4].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff]);
        assert!(matches!(read(&bytes), Err(MatError::Malformed { .. })));
        let mut seeds = vec![big_endian()];
        for path in ["maewing1_geri/gvt_mode_shapes/fst.mat", "bff_fem/AircraftData_v02.mat"] {
            seeds.extend(open(path));
        }
        let unfold = |bytes: &[u8]| miniz_oxide::inflate::decompress_to_vec_zlib(&bytes[136..]).ok();
        // The compressed ones also as they are inside, for the checksum would stop every mutation.
        for inner in seeds.iter().filter_map(|s| unfold(s)).collect::<Vec<_>>() {
            seeds.push([&seeds[1][..128], &inner].concat());
        }
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let mut read_at_all = 0;
        for _ in 0..20_000 {
            let mut bytes = seeds[rng.random_range(0..seeds.len())].clone();
            for _ in 0..rng.random_range(1..5) {
                let at = rng.random_range(128..bytes.len());
                bytes[at] = rng.next_u32() as u8;
            }
            bytes.truncate(rng.random_range(bytes.len() / 2..=bytes.len()));
            read_at_all += u32::from(read(&bytes).is_ok());
        }
        assert!(read_at_all > 0);
    }
}
