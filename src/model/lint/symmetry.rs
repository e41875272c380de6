//! A plane of symmetry that the file states and the structure does not have.

use super::row_path;
use crate::linalg::sparse::SparseSym;
use crate::model::compile::Model;
use crate::model::dependence::interior_point;
use crate::model::{ModelError, ParametricModel};
use crate::yaml::Problem;
use std::collections::HashMap;

/// Relative difference of the two halves of stiffness or mass that is worth a remark: modes begin to lean to one side.
const UNEQUAL: f64 = 1e-3;

/// The largest difference between the halves.
pub(super) fn symmetry(model: &Model) -> Result<Vec<Problem>, ModelError> {
    let Some(mirror) = model.mirror() else { return Ok(Vec::new()) };
    let system = model.assemble_sparse(&interior_point(model.parameters()))?;
    let mut out = Vec::new();
    for (name, a) in [("stiffness", &system.stiffness), ("mass", &system.mass)] {
        if let Some((row, size)) = largest_difference(a, mirror).filter(|d| d.1 > UNEQUAL) {
            let dofs = model.dof_map();
            let mut problem = Problem::warning(
                "symmetry",
                format_args!(
                    "the {name} of the two halves differs by {}, most between `{}` and `{}`: modes will be neither symmetric nor antisymmetric to that extent",
                    percent(size),
                    dofs.row_name(row),
                    dofs.row_name(mirror[row].0)
                ),
            );
            if mirror[row].0 == row {
                problem = Problem::warning(
                    row_path(model, row),
                    format_args!(
                        "the {name} at `{}`, which stands in the plane of `symmetry`, couples with the two halves differently, by {}",
                        dofs.row_name(row),
                        percent(size)
                    ),
                );
            }
            out.push(problem);
        }
    }
    Ok(out)
}

fn percent(share: f64) -> String {
    if share < 0.1 { format!("{:.1} %", 100.0 * share) } else { format!("{:.0} %", 100.0 * share) }
}

/// The row of the largest |A - SAS|, S the reflection, and its size: of the diagonal entries at its row and column, of either half.
fn largest_difference(a: &SparseSym, mirror: &[(usize, f64)]) -> Option<(usize, f64)> {
    let entries: HashMap<(usize, usize), f64> = a.entries().map(|(i, j, v)| ((i, j), v)).collect();
    let of = |i: usize, j: usize| entries.get(&(i.max(j), i.min(j))).copied().unwrap_or(0.0);
    let size = |i: usize| a.diagonal(i).abs().max(a.diagonal(mirror[i].0).abs());
    let differences = entries.iter().map(|(&(i, j), v)| {
        let ((p, s), (q, t)) = (mirror[i], mirror[j]);
        let scale = (size(i) * size(j)).sqrt();
        (i.min(p), if scale > 0.0 { (v - s * t * of(p, q)).abs() / scale } else { 0.0 })
    });
    differences.max_by(|x, y| x.1.total_cmp(&y.1).then(y.0.cmp(&x.0)))
}
