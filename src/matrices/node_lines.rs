//! Positions of nodes in an input file of Abaqus or CalculiX: what stands under `*NODE`.

use super::text::{Lines, number};
use super::{Contents, File, MatrixError, MatrixReader};

/// `*NODE` of Abaqus and CalculiX.
#[derive(Debug, Clone, Copy)]
pub struct NodeLines;

const FORMAT: &str = "input file of Abaqus or CalculiX";

/// Whether a line is the keyword `*NODE` and no other that begins so.
fn is_node(line: &str) -> bool {
    let keyword: String = line.split(',').next().unwrap_or_default().split_whitespace().collect();
    keyword.eq_ignore_ascii_case("*node")
}

impl MatrixReader for NodeLines {
    fn name(&self) -> &'static str {
        "node-lines"
    }

    fn summary(&self) -> &'static str {
        "Positions of nodes from an input file of Abaqus or CalculiX (.inp): what stands under *NODE; everything else is passed over."
    }

    fn recognises(&self, file: &File<'_>) -> bool {
        let is_input = file.extension() == "inp";
        let lines = file.first_lines();
        is_input && lines.iter().any(|l| l.starts_with('*')) || lines.first().is_some_and(|l| is_node(l))
    }

    fn read(&self, file: &File<'_>) -> Result<Contents, MatrixError> {
        let mut lines = Lines::new(file.bytes);
        let (mut contents, mut inside, mut parts) = (Contents::default(), false, 0);
        while let Some(line) = lines.next() {
            let text = line.trim();
            if text.is_empty() || text.starts_with("**") {
                continue;
            }
            if text.starts_with('*') {
                inside = is_node(text);
                parts += usize::from(text.to_lowercase().starts_with("*part"));
                let asks_for_system = inside
                    && text.to_lowercase().replace(' ', "").contains("system=")
                    && !text.to_lowercase().replace(' ', "").contains("system=r");
                if asks_for_system {
                    return Err(MatrixError::line(FORMAT, lines.number, line, "*NODE in a rectangular system"));
                }
                continue;
            }
            if !inside {
                continue;
            }
            let words: Vec<&str> = text.split(',').map(str::trim).collect();
            let node = words.first().filter(|w| !w.is_empty() && w.bytes().all(|b| b.is_ascii_digit()));
            let at = |i: usize| match words.get(i) {
                None | Some(&"") => Some(0.0),
                Some(word) => number(word),
            };
            let (Some(node), Some(x), Some(y), Some(z)) = (node, at(1), at(2), at(3)) else {
                return Err(MatrixError::line(FORMAT, lines.number, line, "`node, x, y, z`"));
            };
            contents.positions.push(((*node).to_string(), [x, y, z]));
        }
        if parts > 1 {
            contents.notes.push("it has several parts, whose nodes may bear the same numbers".to_string());
        }
        if contents.positions.is_empty() {
            return Err(MatrixError::broken(FORMAT, "no nodes stand under `*NODE`"));
        }
        Ok(contents)
    }
}
