//! Element matrices of Abaqus (`*ELEMENT MATRIX OUTPUT, OUTPUT FILE=USER DEFINED` or in the data file), assembled here into one matrix a kind.
//!
//! ```text
//! ** ELEMENT NUMBER 1 STEP NUMBER 1 INCREMENT NUMBER 1
//! *USER ELEMENT, NODES=2, LINEAR
//! ** ELEMENT NODES
//! **  1, 2
//!  1,2,3                dofs of the first node, then `k, dofs` from node k on
//! *MATRIX, TYPE=STIFFNESS
//!  lower triangle by rows, at most four numbers a line
//! *MATRIX, TYPE=MASS
//! ```
//!
//! Source: Dassault Systèmes, Abaqus Analysis User's Guide, "Element matrix output", and Keywords Guide, *USER ELEMENT, *MATRIX.

use super::matrix::{Numbered, dof};
use super::text::{Lines, number};
use super::{Contents, File, Label, Matrix, MatrixError, MatrixReader};

/// ELEMENT MATRIX OUTPUT of Abaqus.
#[derive(Debug, Clone, Copy)]
pub struct ElementMatrixOutput;

const FORMAT: &str = "element matrices of Abaqus";
/// No element has more nodes; a head that says so is damaged.
const MOST_NODES: usize = 10_000;

impl MatrixReader for ElementMatrixOutput {
    fn name(&self) -> &'static str {
        "abaqus-element-matrices"
    }

    fn summary(&self) -> &'static str {
        "Element matrices of Abaqus (*ELEMENT MATRIX OUTPUT, as user elements), assembled by their nodes: `stiffness` and `mass`."
    }

    fn recognises(&self, file: &File<'_>) -> bool {
        file.head().lines().any(|l| l.to_lowercase().starts_with("*user element"))
    }

    fn read(&self, file: &File<'_>) -> Result<Contents, MatrixError> {
        let mut reader =
            Reading { labels: Numbered::default(), kinds: Vec::new(), nodes: Vec::new(), dofs: Vec::new(), n_nodes: 0 };
        let mut lines = Lines::new(file.bytes);
        let mut state = State::Other;
        while let Some(line) = lines.next() {
            let text = line.trim();
            let lower = text.to_lowercase();
            if lower.is_empty() {
                continue;
            }
            if lower.starts_with("*user element") {
                reader.close(&state, lines.number)?;
                let n = keyword(&lower, "nodes").and_then(|v| v.parse().ok()).filter(|n| (1..=MOST_NODES).contains(n));
                reader.n_nodes =
                    n.ok_or_else(|| MatrixError::line(FORMAT, lines.number, text, "`*USER ELEMENT, NODES=n`"))?;
                (reader.nodes, reader.dofs) = (Vec::new(), Vec::new());
                state = State::Dofs;
            } else if lower.starts_with("** element nodes") {
                state = State::Nodes;
            } else if lower.starts_with("**") {
                if matches!(state, State::Nodes) {
                    let found: Vec<&str> =
                        text.trim_start_matches('*').split(',').map(str::trim).filter(|w| !w.is_empty()).collect();
                    if found.iter().all(|w| w.bytes().all(|b| b.is_ascii_digit())) {
                        reader.nodes.extend(found.into_iter().map(str::to_string));
                    }
                    if reader.nodes.len() >= reader.n_nodes {
                        state = State::Dofs;
                    }
                }
            } else if lower.starts_with("*matrix") {
                reader.close(&state, lines.number)?;
                let kind = keyword(&lower, "type").unwrap_or_default();
                state = State::Values(kind, Vec::new());
            } else if lower.starts_with('*') {
                reader.close(&state, lines.number)?;
                state = State::Other;
            } else {
                reader.data(&mut state, text, lines.number)?;
            }
        }
        reader.close(&state, lines.number)?;
        let n = reader.labels.labels.len();
        let labels = reader.labels.labels;
        let mut contents = Contents::default();
        for (name, entries) in reader.kinds {
            let mut matrix = Matrix {
                name,
                n_rows: n,
                n_columns: n,
                is_one_triangle: true,
                rows: labels.clone(),
                ..Matrix::default()
            };
            for (row, column, value) in entries {
                matrix.push(row, column, value);
            }
            contents.matrices.push(matrix);
        }
        if contents.matrices.is_empty() {
            return Err(MatrixError::broken(FORMAT, "no matrix stands under its elements"));
        }
        Ok(contents)
    }
}

/// The value of `name=value` in a keyword line, in small letters.
fn keyword(lower: &str, name: &str) -> Option<String> {
    lower.split(',').find_map(|part| {
        let (key, value) = part.split_once('=')?;
        (key.trim() == name).then(|| value.trim().to_string())
    })
}

enum State {
    Other,
    Nodes,
    Dofs,
    Values(String, Vec<f64>),
}

/// Row, column, value.
type Triplet = (usize, usize, f64);

struct Reading {
    labels: Numbered,
    /// Matrices by name.
    kinds: Vec<(String, Vec<Triplet>)>,
    /// Of the element that is being read.
    nodes: Vec<String>,
    /// First node that has them, from 0, and dofs.
    dofs: Vec<(usize, Vec<String>)>,
    n_nodes: usize,
}

impl Reading {
    fn data(&mut self, state: &mut State, text: &str, line: usize) -> Result<(), MatrixError> {
        let words: Vec<&str> = text.split(',').map(str::trim).filter(|w| !w.is_empty()).collect();
        match state {
            State::Dofs | State::Nodes => {
                // The first line has the dofs of the first node; each other one begins with the number of a node.
                let (from, dofs) = match self.dofs.len() {
                    0 => (0, words.as_slice()),
                    _ => {
                        let from = words.first().and_then(|w| w.parse::<usize>().ok()).and_then(|k| k.checked_sub(1));
                        let from = from.filter(|k| *k < self.n_nodes);
                        (from.ok_or_else(|| MatrixError::line(FORMAT, line, text, "`node, dofs`"))?, &words[1..])
                    }
                };
                self.dofs.push((from, dofs.iter().map(|w| (*w).to_string()).collect()));
                *state = State::Dofs;
            }
            State::Values(_, values) => {
                for word in words {
                    values.push(
                        number(word).ok_or_else(|| MatrixError::line(FORMAT, line, text, "numbers of a matrix"))?,
                    );
                }
            }
            State::Other => {}
        }
        Ok(())
    }

    /// Assembles what was read under `*MATRIX`.
    fn close(&mut self, state: &State, line: usize) -> Result<(), MatrixError> {
        let State::Values(kind, values) = state else { return Ok(()) };
        if self.nodes.len() != self.n_nodes {
            return Err(MatrixError::broken(
                FORMAT,
                format_args!(
                    "the element before line {line} has {} nodes and lists {} under `** ELEMENT NODES`",
                    self.n_nodes,
                    self.nodes.len()
                ),
            ));
        }
        let mut places = Vec::new();
        for (k, node) in self.nodes.iter().enumerate() {
            let own = self.dofs.iter().rev().find(|(from, _)| *from <= k).map_or(&[][..], |d| &d.1);
            for word in own {
                let dof = dof(word);
                let node = if dof.is_some() { node.clone() } else { format!("{node}.{word}") };
                places.push(self.labels.index(Label { node, dof }));
            }
        }
        let n = places.len();
        if values.len() != n * (n + 1) / 2 {
            return Err(MatrixError::broken(
                FORMAT,
                format_args!(
                    "the matrix before line {line} has {} numbers, and the lower triangle of {n} dofs has {}",
                    values.len(),
                    n * (n + 1) / 2
                ),
            ));
        }
        let name = if kind.is_empty() { "stiffness" } else { kind };
        let at = self.kinds.iter().position(|k| k.0 == name).unwrap_or_else(|| {
            self.kinds.push((name.to_string(), Vec::new()));
            self.kinds.len() - 1
        });
        let mut next = values.iter();
        for i in 0..n {
            for (j, value) in (0..=i).zip(next.by_ref()) {
                if *value != 0.0 {
                    let (row, column) = (places[i].max(places[j]), places[i].min(places[j]));
                    self.kinds[at].1.push((row, column, *value));
                }
            }
        }
        Ok(())
    }
}
