//! Matrices of OUTPUT4: the eigenvalues that a stiffness and a mass of one size have together.
//!
//! The file says nothing of grids, so that there are no shapes. Which set of dofs it is, the names say: KAA and MAA are those after constraints,
//! KGG and MGG those before.

use super::{ResultMode, ResultsError, SolverResults};
use retune::linalg::DMatrix;
use retune::matrices::{self, File, Matrix};
use retune::modal::{SolveOptions, solve};
use retune::model::MOST_DENSE_DOFS;
use std::collections::BTreeMap;

const NAME: &str = "results.op4";

/// Modes that are taken, at most.
const MODES: usize = 60;

/// Whether bytes are OUTPUT4.
pub(super) fn is_op4(bytes: &[u8]) -> bool {
    matrices::reader_of(&File { name: NAME, bytes }).is_ok_and(|r| r.name() == "output4")
}

fn wrong(message: impl Into<String>) -> ResultsError {
    ResultsError::Matrix(message.into())
}

pub(super) fn read(bytes: &[u8]) -> Result<SolverResults, ResultsError> {
    let contents = matrices::read(NAME, bytes).map_err(|e| wrong(e.to_string()))?;
    let find = |stiff: &Matrix| {
        let rest = stiff.name.strip_prefix(['K', 'k'])?;
        let is_mass = |m: &&Matrix| m.name.strip_prefix(['M', 'm']) == Some(rest) && m.n_rows == stiff.n_rows;
        contents.matrices.iter().find(is_mass)
    };
    let pair = contents.matrices.iter().find_map(|k| Some((k, find(k)?)));
    let Some((stiffness, mass)) = pair else {
        let names: Vec<&str> = contents.matrices.iter().map(|m| m.name.as_str()).collect();
        return Err(wrong(format!(
            "it holds {}; a stiffness and a mass of one set of dofs are expected, such as KAA and MAA",
            names.join(", ")
        )));
    };
    let n = stiffness.n_rows;
    if n > MOST_DENSE_DOFS {
        return Err(wrong(format!(
            "{} has {n} rows, and the eigenvalues of up to {MOST_DENSE_DOFS} are found here; give those of the solver",
            stiffness.name
        )));
    }
    let [k, m] = [stiffness, mass].map(|a| {
        let lower = a.symmetric(false).map_err(|e| wrong(format!("{}: {e}", a.name)))?;
        let mut full = DMatrix::zeros(n, n);
        for e in &lower.lower {
            full[(e.row as usize, e.column as usize)] = e.value;
            full[(e.column as usize, e.row as usize)] = e.value;
        }
        Ok::<_, ResultsError>(full)
    });
    let (k, m) = (k?, m?);
    // Dofs that nothing acts on are not there.
    let used: Vec<usize> = (0..n).filter(|&i| [&k, &m].iter().any(|a| a.column(i).iter().any(|v| *v != 0.0))).collect();
    let [k, m] = [k, m].map(|a| a.select_rows(&used).select_columns(&used));
    let options = SolveOptions { n_elastic: MODES.min(used.len()), shift: None };
    let modes = solve(&k, &m, &DMatrix::zeros(used.len(), 0), options)
        .map_err(|e| wrong(format!("{} and {}: {e}", stiffness.name, mass.name)))?;
    let each = modes.lambda.iter().enumerate();
    let modes = each.map(|(i, l)| ResultMode { number: i as i64 + 1, eigenvalue: *l, shape: BTreeMap::new() });
    let mut notes = contents.notes.clone();
    notes.push(format!("eigenvalues of {} and {}, {n} rows", stiffness.name, mass.name));
    Ok(SolverResults { kind: "op4", mass: None, modes: modes.collect(), notes })
}
