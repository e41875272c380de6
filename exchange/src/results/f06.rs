//! Printed output: the tables of real eigenvalues, of eigenvectors, and of the grid point weight generator.

use super::{ResultMass, ResultMode, ResultsError, SolverResults};
use retune::deck::parse_real;
use std::collections::BTreeMap;

const EIGENVALUES: &str = "REALEIGENVALUES";
const VECTOR: &str = "REALEIGENVECTORNO.";
const WEIGHT: &str = "OUTPUTFROMGRIDPOINTWEIGHTGENERATOR";

/// Whether a text is printed output.
pub(super) fn is_f06(bytes: &[u8]) -> bool {
    let text = String::from_utf8_lossy(bytes);
    let mut heads = text.lines().map(squeezed);
    heads.any(|l| l.contains(EIGENVALUES) || l.contains(WEIGHT) || l.contains(VECTOR))
}

/// A heading without the blanks that spread it.
pub(super) fn squeezed(line: &str) -> String {
    // Headings are letters with blanks between; a line of numbers is none.
    if line.len() > 250 || !line.chars().any(|c| c.is_ascii_uppercase()) {
        return String::new();
    }
    line.chars().filter(|c| !c.is_whitespace()).collect()
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Table {
    None,
    Eigenvalues,
    Vector(i64),
    /// Rows of the mass matrix that were read.
    Mass(usize),
}

pub(super) fn read(text: &str) -> Result<SolverResults, ResultsError> {
    let mut out = SolverResults { kind: "f06", ..SolverResults::default() };
    let mut modes: BTreeMap<i64, ResultMode> = BTreeMap::new();
    let mut table = Table::None;
    let mut reference = 0;
    let mut rigid = [[0.0; 6]; 6];
    // Eigenvalues of a second subcase or of a buckling load begin again at one.
    let (mut last, mut is_second) = (0, false);
    for (i, line) in text.lines().enumerate() {
        let wrong = |message: &str| ResultsError::Line { line: i + 1, message: message.to_string() };
        let head = squeezed(line);
        if head.contains(WEIGHT) {
            table = if out.mass.is_none() { Table::Mass(0) } else { Table::None };
            continue;
        }
        if head.ends_with(EIGENVALUES) || head.contains(&format!("{EIGENVALUES}(")) {
            table = Table::Eigenvalues;
            continue;
        }
        if let Some(at) = head.find(VECTOR) {
            let number =
                head[at + VECTOR.len()..].parse().map_err(|_| wrong("the number of a mode is expected behind NO."))?;
            table = Table::Vector(number);
            continue;
        }
        if head.contains("JOBCREATED") || head.contains("PAGE") {
            if !matches!(table, Table::Eigenvalues) {
                table = Table::None;
            }
            continue;
        }
        match table {
            Table::None => {}
            Table::Mass(row) => {
                if let Some(at) = head.find("REFERENCEPOINT=") {
                    reference = head[at + 15..].parse().unwrap_or(0);
                } else if line.matches('*').count() == 2 && row < 6 {
                    let inside = line.split('*').nth(1).unwrap_or_default();
                    let values: Option<Vec<f64>> = inside.split_whitespace().map(parse_real).collect();
                    let values = values
                        .filter(|v| v.len() == 6)
                        .ok_or_else(|| wrong("six numbers of the mass matrix are expected"))?;
                    rigid[row].copy_from_slice(&values);
                    table = Table::Mass(row + 1);
                    if row == 5 {
                        out.mass = Some(ResultMass { reference, rigid });
                        table = Table::None;
                    }
                }
            }
            Table::Eigenvalues => {
                let words: Vec<&str> = line.split_whitespace().collect();
                let [number, order, value, ..] = words[..] else { continue };
                let (Ok(number), Ok(_)) = (number.parse::<i64>(), order.parse::<i64>()) else {
                    continue;
                };
                // Another table of numbers, whose heading is not known, ends this one.
                // An asterisk marks a negative value.
                let value = parse_real(value.trim_end_matches('*'));
                // The rows of a table of eigenvalues have at most five numbers behind the two.
                let Some(eigenvalue) = value.filter(|_| (5..=7).contains(&words.len())) else {
                    table = Table::None;
                    continue;
                };
                is_second |= number <= last;
                last = number;
                if !is_second {
                    modes.entry(number).or_insert(ResultMode { number, eigenvalue, shape: BTreeMap::new() });
                }
            }
            Table::Vector(mode) => {
                let words: Vec<&str> = line.split_whitespace().collect();
                if words.len() != 8 || words[1] != "G" {
                    continue;
                }
                let Ok(grid) = words[0].parse::<u32>() else { continue };
                let values: Option<Vec<f64>> = words[2..].iter().map(|w| parse_real(w)).collect();
                let values = values.ok_or_else(|| wrong("six numbers of a grid are expected"))?;
                if let Some(mode) = modes.get_mut(&mode) {
                    mode.shape.entry(grid).or_insert(std::array::from_fn(|k| values[k]));
                }
            }
        }
    }
    if is_second {
        out.notes.push("a second table of eigenvalues was left out".to_string());
    }
    out.modes = modes.into_values().collect();
    Ok(out)
}
