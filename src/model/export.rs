//! The matrices of a model for other programs, whole or reduced to some nodes.

use super::solver::Matrices;
use super::{MOST_DENSE_DOFS, ModelError, ParametricModel};
use crate::element::Dof;
use crate::linalg::DMatrix;
use crate::linalg::sparse::SparseSym;
use crate::matrices::{DofRow, Entry, Label, Matrix, Symmetric};
use crate::modal::reduction::{ReductionError, guyan, selection, serep, serep_transformation};
use crate::modal::{SolveOptions, craig_bampton, craig_bampton_sparse};

/// How a model is reduced to nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExportReduction {
    /// Static (Guyan).
    Guyan,
    /// By so many elastic modes, and the rigid-body modes, which it keeps exactly.
    Serep(usize),
    /// Static modes of the nodes and so many modes with them held.
    CraigBampton(usize),
}

/// Matrices of a model and what their rows are.
#[derive(Debug, Clone, PartialEq)]
pub struct MatrixExport {
    /// K, M and, where there are dashpots, C: one triangle each.
    pub matrices: Vec<Matrix>,
    /// The dofs of their rows.
    pub dofs: Vec<DofRow>,
    /// R of the dofs that follow from them, u = R q; none where all dofs are rows.
    pub recovery: Option<Matrix>,
    /// What the rows of R are.
    pub recovered: Vec<DofRow>,
}

/// Why matrices cannot be exported.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The model has no matrices.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// It cannot be reduced so.
    #[error(transparent)]
    Reduction(#[from] ReductionError),
    /// None of the nodes moves.
    #[error(
        "none of the nodes has a dof of its own: they are supported, or follow others by rigid links; name other nodes"
    )]
    NothingStays,
}

/// K, M and C of a model at θ, in SI and global axes, on its independent dofs.
///
/// Dofs of nodes that follow from others (rigid links, constraints) are given by a matrix of recovery. Reduced, the rows are the dofs of
/// `nodes`, then modal coordinates `q1`, `q2`, ...; all other nodes are recovered.
///
/// * `reduced` - the nodes that stay, and how
///
/// # Errors
/// [`ExportError`].
pub fn export_matrices(
    model: &dyn ParametricModel,
    theta: &[f64],
    reduced: Option<(&[usize], ExportReduction)>,
) -> Result<MatrixExport, ExportError> {
    match reduced {
        None => whole(model, theta),
        Some((nodes, how)) => on_nodes(model, theta, nodes, how),
    }
}

fn whole(model: &dyn ParametricModel, theta: &[f64]) -> Result<MatrixExport, ExportError> {
    let system = model.assemble_sparse(theta)?;
    let map = model.dof_map();
    let dofs: Vec<DofRow> = map.rows().iter().map(|&(node, dof)| row(model, node, dof)).collect();
    let labels: Vec<Label> = dofs.iter().map(|d| d.label.clone()).collect();
    let of = |name: &str, a: &SparseSym| {
        let entry = |(row, column, value): (usize, usize, f64)| Entry { row: row as u32, column: column as u32, value };
        let lower = a.entries().filter(|e| e.2 != 0.0).map(entry).collect();
        Symmetric { n: a.n(), lower, asymmetry: 0.0 }.matrix(name, labels.clone())
    };
    let mut matrices = vec![of("K", &system.stiffness), of("M", &system.mass)];
    matrices.extend(system.damping.as_ref().map(|c| of("C", c)));
    // A dof that is a row of its own needs no recovery.
    let follows = |node: usize, dof: Dof| !matches!(map.express(node, dof), [(r, f)] if map.rows()[*r] == (node, dof) && *f == 1.0);
    let (recovery, recovered) = recovery(model, &labels, follows, <[(usize, f64)]>::to_vec);
    Ok(MatrixExport { matrices, dofs, recovery, recovered })
}

fn on_nodes(
    model: &dyn ParametricModel,
    theta: &[f64],
    nodes: &[usize],
    how: ExportReduction,
) -> Result<MatrixExport, ExportError> {
    let map = model.dof_map();
    let rows: Vec<usize> = (0..map.n_dof()).filter(|&r| nodes.contains(&map.rows()[r].0)).collect();
    if rows.is_empty() {
        return Err(ExportError::NothingStays);
    }
    let (matrices, t) = if map.n_dof() <= MOST_DENSE_DOFS {
        let system = model.assemble(theta)?;
        let (k, m) = (&system.stiffness, &system.mass);
        let s = selection(map.n_dof(), &rows)?;
        let t = match how {
            ExportReduction::Guyan => guyan(k, m, &s)?.transformation,
            ExportReduction::Serep(n_elastic) => serep(k, m, &s, &shapes(model, theta, n_elastic)?)?.transformation,
            ExportReduction::CraigBampton(n_modes) => craig_bampton(k, m, &rows, n_modes)?,
        };
        (Matrices::Dense(system), t)
    } else {
        let system = model.assemble_sparse(theta)?;
        let (k, m) = (&system.stiffness, &system.mass);
        let nodes_of: Vec<usize> = map.rows().iter().map(|r| r.0).collect();
        let t = match how {
            ExportReduction::Guyan => craig_bampton_sparse(k, m, &nodes_of, &rows, 0)?,
            ExportReduction::Serep(n_elastic) => {
                let shapes = shapes(model, theta, n_elastic)?;
                serep_transformation(&shapes, &shapes.select_rows(&rows))?
            }
            ExportReduction::CraigBampton(n_modes) => craig_bampton_sparse(k, m, &nodes_of, &rows, n_modes)?,
        };
        (Matrices::Sparse(system), t)
    };
    let mut dofs: Vec<DofRow> = rows.iter().map(|&r| row(model, map.rows()[r].0, map.rows()[r].1)).collect();
    let modal = |q: usize| Label { node: format!("q{q}"), dof: None };
    dofs.extend((1..=t.ncols() - rows.len()).map(|q| DofRow { label: modal(q), position: None, frame: None }));
    let labels: Vec<Label> = dofs.iter().map(|d| d.label.clone()).collect();
    let of = |name: &str, a_t: &DMatrix<f64>| {
        let reduced = t.transpose() * a_t;
        let mut lower = Vec::new();
        for j in 0..reduced.ncols() {
            for i in j..reduced.nrows() {
                let value = 0.5 * (reduced[(i, j)] + reduced[(j, i)]);
                if value != 0.0 {
                    lower.push(Entry { row: i as u32, column: j as u32, value });
                }
            }
        }
        Symmetric { n: reduced.nrows(), lower, asymmetry: 0.0 }.matrix(name, labels.clone())
    };
    let damping = matrices.damping_times(&t);
    let mut matrices = vec![of("K", &matrices.stiffness_times(&t)), of("M", &matrices.mass_times(&t))];
    matrices.extend(damping.as_ref().map(|c_t| of("C", c_t)));
    let stays = |node: usize, dof: Dof| rows.iter().any(|&r| map.rows()[r] == (node, dof));
    let (recovery, recovered) = recovery(
        model,
        &labels,
        |node, dof| !stays(node, dof),
        |terms| {
            let sum = |j: usize| terms.iter().map(|&(r, f)| f * t[(r, j)]).sum::<f64>();
            (0..t.ncols()).map(|j| (j, sum(j))).filter(|t| t.1 != 0.0).collect()
        },
    );
    Ok(MatrixExport { matrices, dofs, recovery, recovered })
}

fn shapes(model: &dyn ParametricModel, theta: &[f64], n_elastic: usize) -> Result<DMatrix<f64>, ModelError> {
    Ok(super::solve_modes(model, theta, SolveOptions { n_elastic, shift: None })?.shapes)
}

fn row(model: &dyn ParametricModel, node: usize, dof: Dof) -> DofRow {
    let map = model.dof_map();
    let name = map.node_names()[node].clone();
    if map.is_coordinate(node) {
        return DofRow { label: Label { node: name, dof: None }, position: None, frame: None };
    }
    DofRow { label: Label { node: name, dof: Some(dof) }, position: Some(map.positions()[node]), frame: None }
}

/// R and its rows: the dofs of nodes that move and follow.
///
/// * `terms` - a dof by the rows of the export, from its terms on the rows of the model
fn recovery(
    model: &dyn ParametricModel,
    labels: &[Label],
    follows: impl Fn(usize, Dof) -> bool,
    terms: impl Fn(&[(usize, f64)]) -> Vec<(usize, f64)>,
) -> (Option<Matrix>, Vec<DofRow>) {
    let map = model.dof_map();
    let mut matrix =
        Matrix { name: "R".to_string(), n_columns: labels.len(), columns: labels.to_vec(), ..Matrix::default() };
    let mut recovered = Vec::new();
    for node in (0..map.n_nodes()).filter(|&n| !map.is_coordinate(n)) {
        for dof in Dof::ALL {
            let express = map.express(node, dof);
            if express.is_empty() || !follows(node, dof) {
                continue;
            }
            for (column, value) in terms(express) {
                matrix.entries.push(Entry { row: recovered.len() as u32, column: column as u32, value });
            }
            recovered.push(row(model, node, dof));
        }
    }
    matrix.n_rows = recovered.len();
    matrix.rows = recovered.iter().map(|r: &DofRow| r.label.clone()).collect();
    ((!recovered.is_empty()).then_some(matrix), recovered)
}
