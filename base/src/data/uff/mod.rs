//! Universal files (UFF, UNV): the exchange format of vibration tests.
//!
//! A universal file is a list of datasets, each between two lines that read `    -1`, the first followed by the number
//! of the dataset. [`read`] understands what programs really write, keeps every dataset, and says in [`Note`]s what was
//! odd and what it assumed; a dataset that cannot be read becomes [`Dataset::Unknown`] with a note of level
//! [`Level::Error`] and does not lose the others. [`write()`] writes every dataset. What a file means in SI (frequency
//! responses, geometry, modes) is the affair of [`super::convert`].
//!
//! | dataset | content | fields kept |
//! |---|---|---|
//! | 15, 2411 | nodes | label, definition and displacement system, color, position |
//! | 2412 | elements | label, kind, tables, color, beam record, nodes |
//! | 82 | trace line | number, color, name, nodes (0 lifts the pen) |
//! | 18, 2420 | coordinate systems | numbers, kind, color, name, points or matrix |
//! | 1858 | qualifiers of functions | all records |
//! | 151, 164 | header, units | names, programs, dates; code and factors (SI value = value / factor) |
//! | 55, 2414 | shapes, analysis data | all parameters, values at nodes (2414: on elements too), real or complex |
//! | 58, 58b | functions | all eleven records; text or binary, either byte order, IEEE, DEC VMS or IBM 370 floats |
//! | others | | their lines |
//!
//! Exactness: integers and text come back as they were. Text columns hold 6 (13 columns), 13 (20 columns) or 17 digits
//! (25 columns) by the standard; the writer keeps more where they fit, and a note counts the numbers that were rounded.
//! Binary doubles keep every bit. Text keeps its characters; blanks around a line of text are not kept.
//!
//! Oddities that are survived: numbers that run together or stand outside their columns, labels too long for them, `D`
//! exponents, exponents without letter, stars, text that is not UTF-8, unknown types of functions, line ends of any
//! system, wrong or missing byte counts of binary data, line ends after binary data, a missing end mark, a truncated
//! last record, records filled with zeros or blanks.
//!
//! Start reading at [`UniversalFile`] and [`Dataset`].
//!
//! Sources: Structural Dynamics Research Laboratory, University of Cincinnati, Universal File Formats for Modal Analysis
//! Testing (the texts of SDRC I-DEAS for datasets 15, 18, 55, 58, 82, 151, 164, 2411, 2412, 2414, 2420, and of the
//! laboratory for 58b). Behaviour compared with pyuff 2.5.8 (ladisk/pyuff, MIT).

mod analysis;
mod cursor;
mod d58;
mod elements;
mod fields;
mod float_formats;
mod function;
mod header;
mod layout;
mod nodes;
mod note;
mod qualifiers;
mod scan;
mod sink;
mod systems;
#[cfg(test)]
mod tests;

pub use analysis::{AnalysisData, DataAtNodes, Entry};
pub use elements::{Element, TraceLine};
pub use float_formats::FloatFormat;
pub use function::{Abscissa, Axis, ByteOrder, Entity, Function, Ordinate, Precision, Storage};
pub use header::{Header, Stamp, Units};
pub use nodes::Node;
pub use note::{Level, Note};
pub use qualifiers::Qualifiers;
pub use systems::{CoordinateSystem, Part, PartSystem};

use cursor::{Cursor, Fault};
use note::Notes;
use scan::{Block, Scanner};
use sink::Sink;

/// One dataset.
#[derive(Debug, Clone, PartialEq)]
pub enum Dataset {
    /// 15: nodes, single precision.
    Nodes15(Vec<Node>),
    /// 2411: nodes, double precision.
    Nodes2411(Vec<Node>),
    /// 2412: elements.
    Elements(Vec<Element>),
    /// 82: a trace line.
    TraceLine(TraceLine),
    /// 18: coordinate systems by points.
    CoordinateSystems(Vec<CoordinateSystem>),
    /// 2420: coordinate systems by matrices.
    Part(Part),
    /// 151: header.
    Header(Header),
    /// 164: units.
    Units(Units),
    /// 55: data at nodes.
    DataAtNodes(DataAtNodes),
    /// 2414: analysis data.
    AnalysisData(AnalysisData),
    /// 58: function at nodal DOF.
    Function(Box<Function>),
    /// 1858: qualifiers of functions.
    Qualifiers(Box<Qualifiers>),
    /// Any other dataset, or one that could not be read.
    Unknown {
        /// Its number.
        number: i64,
        /// Its lines.
        lines: Vec<String>,
    },
}

impl Dataset {
    /// Its number.
    pub fn number(&self) -> i64 {
        match self {
            Dataset::Nodes15(_) => 15,
            Dataset::Nodes2411(_) => 2411,
            Dataset::Elements(_) => 2412,
            Dataset::TraceLine(_) => 82,
            Dataset::CoordinateSystems(_) => 18,
            Dataset::Part(_) => 2420,
            Dataset::Header(_) => 151,
            Dataset::Units(_) => 164,
            Dataset::DataAtNodes(_) => 55,
            Dataset::AnalysisData(_) => 2414,
            Dataset::Function(_) => 58,
            Dataset::Qualifiers(_) => 1858,
            Dataset::Unknown { number, .. } => *number,
        }
    }
}

impl From<Function> for Dataset {
    fn from(function: Function) -> Self {
        Dataset::Function(Box::new(function))
    }
}

/// The datasets of a universal file, in their order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct UniversalFile {
    /// The datasets.
    pub datasets: Vec<Dataset>,
}

/// Why a universal file cannot be read or written.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum UffError {
    /// Nothing between two delimiters.
    #[error("no dataset in {bytes} bytes; a universal file has lines that read `    -1` before and after each dataset")]
    NoDataset {
        /// Length of the file.
        bytes: usize,
    },
    /// An integer with too many digits.
    #[error("dataset {dataset}: the integer {value} does not fit in {columns} columns; renumber it")]
    TooWide {
        /// Number of the dataset.
        dataset: i64,
        /// The integer.
        value: i64,
        /// Columns of its field.
        columns: usize,
    },
}

/// Reads a universal file.
///
/// * `bytes` - the whole file
///
/// Returns the datasets and what was odd, at most a thousand notes. Memory is proportional to the length of the file,
/// whatever its counts say; time too.
///
/// # Errors
/// [`UffError::NoDataset`] only.
pub fn read(bytes: &[u8]) -> Result<(UniversalFile, Vec<Note>), UffError> {
    let mut notes = Notes::default();
    let mut datasets = Vec::new();
    let mut scanner = Scanner::new(bytes);
    while let Some(block) = scanner.next_block(&mut notes) {
        datasets.push(read_block(&block, &mut notes));
    }
    if datasets.is_empty() {
        return Err(UffError::NoDataset { bytes: bytes.len() });
    }
    Ok((UniversalFile { datasets }, notes.finish()))
}

fn read_block(block: &Block<'_>, notes: &mut Notes) -> Dataset {
    let mut cursor = Cursor::new(block.text, block.first_line, block.number, notes);
    match read_known(block, &mut cursor) {
        Some(Ok(dataset)) => dataset,
        Some(Err(Fault { line, seen })) => {
            let lost =
                if block.payload.is_some() { "its text is kept, its binary values are not" } else { "kept as text" };
            notes.push(Level::Error, line, Some(block.number), seen, format!("the dataset was not read, {lost}"));
            unknown(block)
        }
        None => unknown(block),
    }
}

fn read_known(block: &Block<'_>, cursor: &mut Cursor<'_, '_>) -> Option<Result<Dataset, Fault>> {
    Some(match block.number {
        15 => Ok(Dataset::Nodes15(nodes::read_15(cursor))),
        2411 => nodes::read_2411(cursor).map(Dataset::Nodes2411),
        2412 => elements::read_2412(cursor).map(Dataset::Elements),
        82 => elements::read_82(cursor).map(Dataset::TraceLine),
        18 => systems::read_18(cursor).map(Dataset::CoordinateSystems),
        2420 => systems::read_2420(cursor).map(Dataset::Part),
        151 => Ok(Dataset::Header(header::read_151(cursor))),
        164 => header::read_164(cursor).map(Dataset::Units),
        55 => analysis::read_55(cursor).map(Dataset::DataAtNodes),
        2414 => analysis::read_2414(cursor).map(Dataset::AnalysisData),
        58 => d58::read(block, cursor).map(Dataset::from),
        1858 => qualifiers::read_1858(cursor).map(|q| Dataset::Qualifiers(Box::new(q))),
        _ => return None,
    })
}

fn unknown(block: &Block<'_>) -> Dataset {
    let mut lines = scan::Lines::new(block.text, block.first_line);
    let lines = std::iter::from_fn(|| lines.next_line().map(|l| scan::decode(l).0.into_owned())).collect();
    Dataset::Unknown { number: block.number, lines }
}

/// Writes a universal file.
///
/// Returns its bytes and what was lost, usually nothing; see the module for exactness.
///
/// # Errors
/// [`UffError::TooWide`] for a label that has no room in its columns.
pub fn write(file: &UniversalFile) -> Result<(Vec<u8>, Vec<Note>), UffError> {
    let mut sink = Sink::default();
    for dataset in &file.datasets {
        match dataset {
            Dataset::Nodes15(v) => nodes::write_15(v, &mut sink),
            Dataset::Nodes2411(v) => nodes::write_2411(v, &mut sink),
            Dataset::Elements(v) => elements::write_2412(v, &mut sink),
            Dataset::TraceLine(v) => elements::write_82(v, &mut sink),
            Dataset::CoordinateSystems(v) => systems::write_18(v, &mut sink),
            Dataset::Part(v) => systems::write_2420(v, &mut sink),
            Dataset::Header(v) => header::write_151(v, &mut sink),
            Dataset::Units(v) => header::write_164(v, &mut sink),
            Dataset::DataAtNodes(v) => analysis::write_55(v, &mut sink),
            Dataset::AnalysisData(v) => analysis::write_2414(v, &mut sink),
            Dataset::Function(v) => d58::write(v, &mut sink),
            Dataset::Qualifiers(v) => qualifiers::write_1858(v, &mut sink),
            Dataset::Unknown { number, lines } => {
                sink.begin(*number);
                for line in lines {
                    if scan::delimiter(line.as_bytes()).is_some() {
                        sink.note(Level::Warning, "a line that would end the dataset", "it was left out");
                        continue;
                    }
                    sink.raw(line);
                    sink.end_record();
                }
                sink.end();
            }
        }
    }
    sink.finish()
}
