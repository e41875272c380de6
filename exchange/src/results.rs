//! What a solver computed: mass properties, eigenvalues and shapes, from its own output files.
//!
//! Four forms of Nastran: the printed output (.f06), the binary output (.op2), the punch file (.pch), matrices (.op4); of Abaqus and CalculiX the printed
//! output (.dat), of CalculiX the results of nodes (.frd). Numbers are in the deck's own units, shapes along the displacement axes of
//! their grids, those of .frd along global axes.

mod dat;
mod f06;
mod frd;
mod op2;
mod op4;

use retune::data::punch;
use retune::data::uff::Dataset;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// One mode as a solver gives it.
#[derive(Debug, Clone, PartialEq)]
pub struct ResultMode {
    /// Its number.
    pub number: i64,
    /// ω², (rad/s)².
    pub eigenvalue: f64,
    /// Displacements and rotations by the number of the grid; empty where the file has none.
    pub shape: BTreeMap<u32, [f64; 6]>,
}

impl ResultMode {
    /// Its frequency, Hz; zero for a rigid-body mode.
    pub fn frequency_hz(&self) -> f64 {
        self.eigenvalue.max(0.0).sqrt() / TAU
    }
}

/// Mass of rigid motions about a point, in the deck's unit of mass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResultMass {
    /// The grid about which it is taken; the origin where it is zero.
    pub reference: u32,
    /// Six by six, translations first.
    pub rigid: [[f64; 6]; 6],
}

/// What a file holds.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SolverResults {
    /// What the file is: `f06`, `op2`, `op4`, `punch`, `dat`, `frd`.
    pub kind: &'static str,
    /// Mass properties.
    pub mass: Option<ResultMass>,
    /// Modes in the order of their eigenvalues.
    pub modes: Vec<ResultMode>,
    /// What was left out.
    pub notes: Vec<String>,
}

/// Why a file of results cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ResultsError {
    /// Another format.
    #[error(
        "it is none of the files that are known: printed output (.f06), binary output (.op2), matrices (.op4) and punch file (.pch) of Nastran, printed \
         output (.dat) of Abaqus and CalculiX, results (.frd) of CalculiX"
    )]
    Unknown,
    /// Nothing to compare with.
    #[error(
        "it holds no eigenvalues and no mass properties; a Nastran deck asks for them by METHOD and PARAM,GRDPNT, an Abaqus deck by FREQUENCY"
    )]
    Nothing,
    /// Text that is not understood.
    #[error("line {line}: {message}")]
    Line {
        /// From 1.
        line: usize,
        /// What was expected.
        message: String,
    },
    /// Binary records that do not fit.
    #[error("byte {at}: {message}")]
    Byte {
        /// From 0.
        at: usize,
        /// What was expected.
        message: String,
    },
    /// Matrices that have no modes.
    #[error("{0}")]
    Matrix(String),
    /// A punch file.
    #[error(transparent)]
    Punch(#[from] punch::PunchError),
}

/// Reads the output of a solver, whichever form it has.
///
/// # Errors
/// A file of another kind, one without modes and masses, one that breaks off.
pub fn read_results(bytes: &[u8]) -> Result<SolverResults, ResultsError> {
    let mut results = if op2::is_op2(bytes) {
        op2::read(bytes)?
    } else if op4::is_op4(bytes) {
        op4::read(bytes)?
    } else if f06::is_f06(bytes) {
        f06::read(&String::from_utf8_lossy(bytes))?
    } else if frd::is_frd(bytes) {
        frd::read(&String::from_utf8_lossy(bytes))?
    } else if dat::is_dat(bytes) {
        dat::read(&String::from_utf8_lossy(bytes))?
    } else if punch::is_punch(bytes) {
        from_punch(bytes)?
    } else {
        return Err(ResultsError::Unknown);
    };
    if results.modes.is_empty() && results.mass.is_none() {
        return Err(ResultsError::Nothing);
    }
    results.modes.sort_by(|a, b| a.eigenvalue.total_cmp(&b.eigenvalue));
    Ok(results)
}

fn from_punch(bytes: &[u8]) -> Result<SolverResults, ResultsError> {
    let (file, notes) = punch::read(bytes)?;
    let mut modes = Vec::new();
    for dataset in file.datasets {
        let Dataset::DataAtNodes(data) = dataset else { continue };
        let shape = data.entries.iter().filter_map(|e| {
            let grid = u32::try_from(*e.head.first()?).ok()?;
            Some((grid, std::array::from_fn(|i| e.values.get(i).copied().unwrap_or(0.0))))
        });
        let omega = data.reals.first().copied().unwrap_or(0.0) * TAU;
        let number = data.integers.get(1).copied().unwrap_or(0);
        modes.push(ResultMode { number, eigenvalue: omega * omega, shape: shape.collect() });
    }
    Ok(SolverResults { kind: "punch", mass: None, modes, notes })
}
