//! Why a file of matrices cannot be read.

/// Why a file of matrices cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MatrixError {
    /// No format that is known.
    #[error(
        "this is not a format of matrices that is read (`retune list matrices` names them); a table of dofs is a CSV file with the header `node,dof,x,y,z`"
    )]
    Unknown,
    /// A line that is not understood.
    #[error("{format}, line {line}: `{text}` stands where {expected} should")]
    Line {
        /// The format.
        format: &'static str,
        /// Line of the file, from 1.
        line: usize,
        /// The start of it.
        text: String,
        /// What should stand there.
        expected: &'static str,
    },
    /// A file that contradicts itself, or ends too soon.
    #[error("{format}: {why}")]
    Broken {
        /// The format.
        format: &'static str,
        /// What is wrong.
        why: String,
    },
}

impl MatrixError {
    /// A file that contradicts itself.
    pub(super) fn broken(format: &'static str, why: impl std::fmt::Display) -> Self {
        Self::Broken { format, why: why.to_string() }
    }

    /// A line that is not understood.
    pub(super) fn line(format: &'static str, line: usize, text: &str, expected: &'static str) -> Self {
        let text = text.trim().chars().filter(|c| !c.is_control()).take(60).collect();
        Self::Line { format, line, text, expected }
    }
}
