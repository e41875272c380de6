//! Universal files and the test data of this crate, in both directions, in SI.
//!
//! | from universal files | to universal files |
//! |---|---|
//! | [`frfs`]: functions to an [`FrfSet`](crate::data::FrfSet), coherences and spectra | [`frf_file`] |
//! | [`geometry`]: nodes, coordinate systems, trace lines, elements to a [`Geometry`](crate::data::Geometry) | [`geometry_file`] |
//! | [`modes`]: datasets 55 and 2414 to a [`ModalSet`](crate::data::ModalSet) | [`modes_file`] |
//!
//! Nothing is guessed: what a file does not say comes back as [`ConvertError::Questions`], each with the option that
//! answers it. What was assumed with good reason comes back as notes.
//!
//! Start reading at [`FrfOptions`].

mod ends;
mod frame;
mod frequency;
mod frf_file;
mod frfs;
mod geometry;
mod grid;
mod modes;
mod neighbours;
mod options;
mod spectra;
mod units;

pub use frame::LocalAxes;
pub use frf_file::frf_file;
pub use frfs::{FrfImport, frfs};
pub(in crate::data) use frfs::{is_too_sparse, spectra};
pub use geometry::{geometry, geometry_file};
pub use modes::{modes, modes_file};
pub use options::{Duplicates, FrfOptions};
pub use units::{Question, UnitSystem, UnitsFrom, force_unit, ratio_unit, response_unit};

/// Why foreign data do not become ours, or ours foreign.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ConvertError {
    /// The user must say what the file does not.
    #[error("the file leaves questions open: {}", questions(.0, ""))]
    Questions(Vec<Question>),
    /// The file holds none of what was asked for.
    #[error("no {what}; the file holds {found}")]
    Nothing {
        /// What was asked for.
        what: &'static str,
        /// What there is.
        found: String,
    },
    /// Two functions have no frequency line in common.
    #[error("`{first}` and `{second}` have no frequency line in common; read them as separate sets")]
    NoCommonLines {
        /// The one.
        first: String,
        /// The other.
        second: String,
    },
    /// Frequencies that do not ascend or are not finite.
    #[error("`{function}` has frequencies that do not ascend at line {line}")]
    NotAscending {
        /// The function.
        function: String,
        /// Number of the line, from 0.
        line: usize,
    },
    /// A matrix of functions that is almost empty.
    #[error(
        "{measured} functions at {references} references and {responses} responses fill too little of the matrix; read them as separate sets"
    )]
    TooSparse {
        /// Functions measured.
        measured: usize,
        /// References.
        references: usize,
        /// Responses.
        responses: usize,
    },
    /// A direction that a universal file cannot say.
    #[error("`{name}` does not measure along an axis; a universal file knows only the axes of a node")]
    NotAlongAnAxis {
        /// The channel.
        name: String,
    },
    /// An option says another thing than the file.
    #[error("the option `{option}` says {wanted}, but the file says {said}; {remedy}")]
    Contradiction {
        /// The option.
        option: &'static str,
        /// What it says.
        wanted: String,
        /// What the file says.
        said: String,
        /// What to do.
        remedy: String,
    },
    /// Something of a file of values is wrong.
    #[error("{what}: {why}")]
    Unusable {
        /// The thing.
        what: String,
        /// What is wrong with it.
        why: String,
    },
}

fn questions(list: &[Question], lead: &str) -> String {
    let text: Vec<String> =
        list.iter().map(|q| format!("{} (option `{lead}{}`: {})", q.text, q.option, q.answers.join(" | "))).collect();
    text.join("; ")
}

impl ConvertError {
    /// As the error reads where the answers are options of a command: `--units`.
    pub fn on_command_line(&self) -> String {
        match self {
            Self::Questions(list) => format!("the file leaves questions open: {}", questions(list, "--")),
            other => other.to_string(),
        }
    }
}
