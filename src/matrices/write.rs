//! Matrices and their table of dofs as files that other programs read.

use super::output4::{self, Layout};
use super::{DofRow, Matrix, bulk_data, matrix_market, numpy, table};

/// Formats that matrices are written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MatrixFormat {
    /// Matrix Market, a file a matrix.
    MatrixMarket,
    /// A sparse matrix of SciPy, a file a matrix.
    Npz,
    /// OUTPUT4 of Nastran as text, one file.
    Output4,
    /// OUTPUT4 of Nastran as Fortran records, one file.
    Output4Binary,
    /// DMIG cards of Nastran with GRID cards, one file.
    Dmig,
}

crate::catalogue::choice! { MatrixFormat, "format";
    MatrixMarket "mtx" "Matrix Market, a file a matrix",
    Npz "npz" "Sparse matrices of SciPy, a file a matrix",
    Output4 "op4" "OUTPUT4 of Nastran as text",
    Output4Binary "op4-binary" "OUTPUT4 of Nastran, binary",
    Dmig "dmig" "DMIG and GRID cards of Nastran, with ten digits",
}

/// Writes matrices and their table of dofs: names of files that begin with a stem, and their bytes.
///
/// The table is `STEM_dofs.csv` in every format. Every number reads back to the same bits, but those of DMIG, which has ten digits.
/// Errors: a format with labels, and a matrix without them.
pub fn write(
    stem: &str,
    matrices: &[Matrix],
    dofs: &[DofRow],
    format: MatrixFormat,
) -> Result<Vec<(String, Vec<u8>)>, String> {
    let all: Vec<&Matrix> = matrices.iter().collect();
    let each = |extension: &str, bytes: &dyn Fn(&Matrix) -> Vec<u8>| {
        matrices.iter().map(|m| (format!("{stem}_{}.{extension}", m.name), bytes(m))).collect::<Vec<_>>()
    };
    let mut files = match format {
        MatrixFormat::MatrixMarket => each("mtx", &|m| matrix_market::write(m, &format!("{} by retune", m.name))),
        MatrixFormat::Npz => each("npz", &numpy::write),
        MatrixFormat::Output4 => vec![(format!("{stem}.op4"), output4::write(&all, Layout::Text))],
        MatrixFormat::Output4Binary => vec![(format!("{stem}.op4"), output4::write(&all, Layout::Binary))],
        MatrixFormat::Dmig => {
            let mut positions: Vec<(String, [f64; 3])> = Vec::new();
            for row in dofs {
                if let Some(position) = row.position.filter(|_| row.label.dof.is_some())
                    && positions.last().is_none_or(|last| last.0 != row.label.node)
                {
                    positions.push((row.label.node.clone(), position));
                }
            }
            let text = bulk_data::write(&all, &positions)
                .ok_or("DMIG cards need square matrices with labels of their dofs")?;
            vec![(format!("{stem}.pch"), text.into_bytes())]
        }
    };
    files.push((format!("{stem}_dofs.csv"), table::write(dofs).into_bytes()));
    Ok(files)
}
