//! Craig-Bampton reduction: static modes of the boundary and modes with the boundary held.

use super::reduction::ReductionError;
use super::solve::{SolveOptions, solve};
use super::sparse::solve_sparse;
use retune_linalg::DMatrix;
use retune_linalg::sparse::{SparsePlan, SparseSym, solve_shifted};

/// T of u = T \[u_b; q\], (n x (n_b + n_modes)).
///
/// ```text
/// u_b = u_b,    u_i = -K_ii⁻¹ K_ib u_b + Φ q,    K_ii Φ = M_ii Φ Λ,  Φᵀ M_ii Φ = I
/// ```
///
/// Rigid motions are kept exactly; a free structure needs a boundary that holds it.
///
/// * `boundary` - rows that stay, in their order
/// * `n_modes` - at most as many as there are other rows
///
/// # Errors
/// A row that is not there, or is defined twice; an inside that moves with the boundary held.
///
/// Source: R. R. Craig, M. C. C. Bampton, Coupling of substructures for dynamic analyses, AIAA Journal 6, 1968.
pub fn craig_bampton(
    k: &DMatrix<f64>,
    m: &DMatrix<f64>,
    boundary: &[usize],
    n_modes: usize,
) -> Result<DMatrix<f64>, ReductionError> {
    let n = k.nrows();
    let mut is_boundary = vec![false; n];
    for &row in boundary {
        match is_boundary.get_mut(row) {
            Some(known) if !*known => *known = true,
            _ => return Err(ReductionError::NoSuchDof { dof: row, n_dof: n }),
        }
    }
    let inside: Vec<usize> = (0..n).filter(|&i| !is_boundary[i]).collect();
    let n_modes = n_modes.min(inside.len());
    let mut t = DMatrix::zeros(n, boundary.len() + n_modes);
    for (j, &row) in boundary.iter().enumerate() {
        t[(row, j)] = 1.0;
    }
    if inside.is_empty() {
        return Ok(t);
    }
    let block = |a: &DMatrix<f64>, rows: &[usize], columns: &[usize]| {
        DMatrix::from_fn(rows.len(), columns.len(), |i, j| a[(rows[i], columns[j])])
    };
    let (k_ii, m_ii) = (block(k, &inside, &inside), block(m, &inside, &inside));
    let held = nalgebra::Cholesky::new(k_ii.clone()).ok_or(ReductionError::Singular { frequency_hz: 0.0 })?;
    let smallest =
        (0..inside.len()).map(|i| held.l_dirty()[(i, i)].powi(2) / k_ii[(i, i)]).fold(f64::INFINITY, f64::min);
    // A pivot at the level of rounding: the factor exists by chance.
    if smallest < 1e-13 {
        return Err(ReductionError::Singular { frequency_hz: 0.0 });
    }
    let follows = held.solve(&block(k, &inside, boundary));
    for (i, &row) in inside.iter().enumerate() {
        for j in 0..boundary.len() {
            t[(row, j)] = -follows[(i, j)];
        }
    }
    if n_modes > 0 {
        let options = SolveOptions { n_elastic: n_modes, shift: None };
        let held = solve(&k_ii, &m_ii, &DMatrix::zeros(inside.len(), 6), options);
        let modes = held.map_err(|_| ReductionError::Singular { frequency_hz: 0.0 })?;
        for (i, &row) in inside.iter().enumerate() {
            for j in 0..n_modes.min(modes.len()) {
                t[(row, boundary.len() + j)] = modes.shapes[(i, j)];
            }
        }
        // Of an inside with few masses there are fewer modes.
        t = t.columns(0, boundary.len() + n_modes.min(modes.len())).into_owned();
    }
    Ok(t)
}

/// [`craig_bampton`] for sparse matrices. Without modes it is the static reduction of Guyan.
///
/// * `node` - which rows belong together, as of one node, for the elimination order (n)
///
/// # Errors
/// As [`craig_bampton`].
pub fn craig_bampton_sparse(
    k: &SparseSym,
    m: &SparseSym,
    node: &[usize],
    boundary: &[usize],
    n_modes: usize,
) -> Result<DMatrix<f64>, ReductionError> {
    let n = k.n();
    let singular = ReductionError::Singular { frequency_hz: 0.0 };
    let mut boundary_at = vec![None; n];
    for (j, &row) in boundary.iter().enumerate() {
        match boundary_at.get_mut(row) {
            Some(known) if known.is_none() => *known = Some(j),
            _ => return Err(ReductionError::NoSuchDof { dof: row, n_dof: n }),
        }
    }
    let inside: Vec<usize> = (0..n).filter(|&i| boundary_at[i].is_none()).collect();
    let mut t = DMatrix::zeros(n, boundary.len());
    for (j, &row) in boundary.iter().enumerate() {
        t[(row, j)] = 1.0;
    }
    if inside.is_empty() {
        return Ok(t);
    }
    let mut inside_at = vec![None; n];
    inside.iter().enumerate().for_each(|(i, &row)| inside_at[row] = Some(i));
    let block = |a: &SparseSym| {
        let entries = a.entries().filter_map(|(i, j, value)| Some((inside_at[i]?, inside_at[j]?, value)));
        SparseSym::from_triplets(inside.len(), entries)
    };
    let (k_ii, m_ii) = (block(k), block(m));
    let node: Vec<usize> = inside.iter().map(|&i| node[i]).collect();
    let plan = SparsePlan::new(&k_ii, &m_ii, &node)?;
    // What moves with the boundary held has a mode near zero, though rounding may let K_ii have a factor.
    let options = SolveOptions { n_elastic: n_modes.clamp(1, inside.len()), shift: None };
    let held = solve_sparse(&plan, &k_ii, &m_ii, &DMatrix::zeros(inside.len(), 6), options, None);
    let modes = match held {
        Ok((modes, _)) if modes.n_mechanism == 0 => Some(modes),
        // Without masses inside there are no modes to look at.
        Err(super::ModalError::NoMass) if n_modes == 0 => None,
        _ => return Err(singular),
    };
    // K_ib of the boundary at a unit displacement each.
    let mut forces = DMatrix::zeros(inside.len(), boundary.len());
    for (i, j, value) in k.entries() {
        for (a, b) in [(i, j), (j, i)] {
            if let (Some(row), Some(column)) = (inside_at[a], boundary_at[b]) {
                forces[(row, column)] += value;
            }
        }
    }
    let follows = solve_shifted(&plan, &k_ii, &m_ii, 0.0, &forces).map_err(|_| singular)?;
    let n_modes = modes.as_ref().map_or(0, |modes| n_modes.min(modes.len()));
    let mut t = t.resize_horizontally(boundary.len() + n_modes, 0.0);
    for (i, &row) in inside.iter().enumerate() {
        for j in 0..boundary.len() {
            t[(row, j)] = -follows[(i, j)];
        }
        for (j, modes) in (0..n_modes).zip(std::iter::repeat(modes.as_ref()).flatten()) {
            t[(row, boundary.len() + j)] = modes.shapes[(i, j)];
        }
    }
    Ok(t)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A free lattice of masses on springs, reduced to two of its corners, by dense and by sparse matrices.
    #[test]
    fn sparse_is_dense() {
        let (side, n) = (14, 14 * 14);
        let mut k = DMatrix::zeros(n, n);
        for at in 0..n {
            for (next, is_there) in [(at + 1, (at + 1) % side != 0), (at + side, at + side < n)] {
                let s = 1.0 + (at % 5) as f64;
                for (a, b, sign) in [(at, at, 1.0), (next, next, 1.0), (at, next, -1.0), (next, at, -1.0)] {
                    if is_there {
                        k[(a, b)] += sign * s;
                    }
                }
            }
        }
        let m = DMatrix::from_diagonal(&nalgebra::DVector::from_fn(n, |i, _| 1.0 + (i % 3) as f64));
        let (sparse_k, sparse_m) = (SparseSym::from_dense(&k), SparseSym::from_dense(&m));
        let nodes: Vec<usize> = (0..n).collect();
        let reduced = |t: &DMatrix<f64>, a: &DMatrix<f64>| t.transpose() * a * t;
        for n_modes in [0, 5] {
            let dense = craig_bampton(&k, &m, &[n - 1, 0], n_modes).unwrap();
            let sparse = craig_bampton_sparse(&sparse_k, &sparse_m, &nodes, &[n - 1, 0], n_modes).unwrap();
            assert_eq!(dense.shape(), sparse.shape());
            for a in [&k, &m] {
                // Modes may have another sign.
                let (dense, sparse) = (reduced(&dense, a), reduced(&sparse, a));
                assert!((dense.abs() - sparse.abs()).amax() < 1e-9 * dense.amax(), "{dense} {sparse}");
            }
        }
        assert!(craig_bampton_sparse(&sparse_k, &sparse_m, &nodes, &[], 1).is_err());
        assert!(craig_bampton_sparse(&sparse_k, &sparse_m, &nodes, &[0, 0], 1).is_err());
    }

    /// A free chain of five masses: with all modes of the inside the spectrum is that of the chain, and rigid motions are kept with any.
    #[test]
    fn with_all_modes_nothing_is_lost() {
        let n = 5;
        let mut k = DMatrix::zeros(n, n);
        for i in 0..n - 1 {
            let s = 1.0 + i as f64;
            for (a, b, sign) in [(i, i, 1.0), (i + 1, i + 1, 1.0), (i, i + 1, -1.0), (i + 1, i, -1.0)] {
                k[(a, b)] += sign * s;
            }
        }
        let m = DMatrix::from_diagonal(&nalgebra::dvector![1.0, 2.0, 1.0, 0.5, 1.0]);
        let spectrum = |k: &DMatrix<f64>, m: &DMatrix<f64>| {
            let inverse = nalgebra::Cholesky::new(m.clone()).unwrap().l().try_inverse().unwrap();
            let mut all: Vec<f64> =
                (&inverse * k * inverse.transpose()).symmetric_eigenvalues().iter().copied().collect();
            all.sort_by(f64::total_cmp);
            all
        };
        let t = craig_bampton(&k, &m, &[4, 0], 9).unwrap();
        assert_eq!(t.shape(), (5, 5));
        let (exact, reduced) = (spectrum(&k, &m), spectrum(&(t.transpose() * &k * &t), &(t.transpose() * &m * &t)));
        assert!(exact.iter().zip(&reduced).all(|(a, b)| (a - b).abs() < 1e-12), "{exact:?} {reduced:?}");
        let t = craig_bampton(&k, &m, &[4, 0], 1).unwrap();
        let rigid = t.column(0) + t.column(1);
        assert!(rigid.iter().all(|u| (u - 1.0).abs() < 1e-14));
        assert!(craig_bampton(&k, &m, &[], 1).is_err() && craig_bampton(&k, &m, &[0, 0], 1).is_err());
    }
}
