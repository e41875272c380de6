//! The sparse path against closed forms and against the dense path.

use super::*;
use crate::{DMatrix, LinalgError, lowest_modes};
use std::f64::consts::PI;
use std::sync::Arc;

fn none(n: usize) -> DMatrix<f64> {
    DMatrix::zeros(n, 0)
}

/// A chain of n unit masses and springs, free or held at its ends.
fn chain(n: usize, is_free: bool) -> (SparseSym, SparseSym) {
    let springs = (0..n - 1).flat_map(|i| [(i, i, 1.0), (i + 1, i + 1, 1.0), (i + 1, i, -1.0)]);
    let ends = [(0, 0, 1.0), (n - 1, n - 1, 1.0)].into_iter().take(if is_free { 0 } else { 2 });
    (SparseSym::from_triplets(n, springs.chain(ends)), SparseSym::from_triplets(n, (0..n).map(|i| (i, i, 1.0))))
}

/// A membrane: p x q unit masses on a square net of springs with a held frame. Its λ are sums of those of two chains,
/// λ = 4 sin²(iπ/2(p+1)) + 4 sin²(jπ/2(q+1)), double where p = q.
fn membrane(p: usize, q: usize) -> (SparseSym, SparseSym, Vec<f64>) {
    let at = |i: usize, j: usize| i * q + j;
    let mut k = Vec::new();
    for i in 0..p {
        for j in 0..q {
            k.push((at(i, j), at(i, j), 4.0));
            if i + 1 < p {
                k.push((at(i + 1, j), at(i, j), -1.0));
            }
            if j + 1 < q {
                k.push((at(i, j + 1), at(i, j), -1.0));
            }
        }
    }
    let wave = |i: usize, n: usize| 4.0 * (i as f64 * PI / (2.0 * (n as f64 + 1.0))).sin().powi(2);
    let mut exact: Vec<f64> = (1..=p).flat_map(|i| (1..=q).map(move |j| wave(i, p) + wave(j, q))).collect();
    exact.sort_by(f64::total_cmp);
    let n = p * q;
    (SparseSym::from_triplets(n, k.into_iter()), SparseSym::from_triplets(n, (0..n).map(|i| (i, i, 1.0))), exact)
}

/// What rounding may do: the factor errs by a few ε ‖K‖ in λ, the iteration by its tolerance squared over a gap.
fn close(value: f64, exact: f64, shift: f64, norm: f64) -> bool {
    (value - exact).abs() < 1e-11 * (exact + shift) + 100.0 * f64::EPSILON * norm
}

#[test]
fn a_free_chain_has_its_closed_form_and_its_rigid_mode_stays_out() {
    let n = 900;
    let (k, m) = chain(n, true);
    let plan = SparsePlan::new(&k, &m, &(0..n).collect::<Vec<_>>()).unwrap();
    let rigid = DMatrix::from_element(n, 1, 1.0 / (n as f64).sqrt());
    let options = SparseOptions { n_modes: 12, ..SparseOptions::default() };
    let modes = lowest_sparse_modes(&plan, &k, &m, &rigid, None, &options).unwrap();
    assert_eq!(modes.values.len(), 12);
    for j in 0..12 {
        let exact = 4.0 * ((j + 1) as f64 * PI / (2.0 * n as f64)).sin().powi(2);
        assert!(close(modes.values[j], exact, modes.shift, 4.0), "{j}: {} {exact}", modes.values[j]);
    }
    let (sigma, below) = modes.count.unwrap();
    assert!(below >= 13 && sigma > modes.values[11]);
    assert!((modes.vectors.transpose() * &rigid).amax() < 1e-13);
    assert!((modes.vectors.transpose() * m.mul(&modes.vectors) - DMatrix::identity(12, 12)).amax() < 1e-11);
    assert!(backward_error(&k, &m, &modes.values, &modes.vectors) < 1e-13);
}

/// A square membrane has double modes; the wanted number may cut through a pair.
#[test]
fn double_modes_come_in_pairs() {
    let (k, m, exact) = membrane(31, 31);
    let plan = SparsePlan::new(&k, &m, &(0..k.n()).collect::<Vec<_>>()).unwrap();
    for n_modes in [0, 1, 2, 3, 30, 150] {
        let options = SparseOptions { n_modes, ..SparseOptions::default() };
        let modes = lowest_sparse_modes(&plan, &k, &m, &none(k.n()), None, &options).unwrap();
        assert_eq!(modes.values.len(), n_modes);
        for j in 0..n_modes {
            assert!(
                close(modes.values[j], exact[j], modes.shift, 8.0),
                "{n_modes} {j}: {} {}",
                modes.values[j],
                exact[j]
            );
        }
        let (sigma, below) = modes.count.unwrap();
        assert_eq!(below, exact.iter().filter(|e| **e < sigma).count());
        let gram = modes.vectors.transpose() * m.mul(&modes.vectors);
        assert!((gram - DMatrix::identity(n_modes, n_modes)).amax() < 1e-10);
    }
}

/// A block that starts orthogonal to half of the modes: the count notices, and a second search finds them.
#[test]
fn modes_that_the_start_is_blind_to_are_not_missed() {
    // Two chains that do not touch: from a start on the first one, nothing ever moves on the second.
    let n = 400;
    let (a, _) = chain(n, false);
    let both = a.entries().chain(a.entries().map(|(i, j, v)| (i + n, j + n, 1.1 * v)).collect::<Vec<_>>());
    let both: Vec<_> = both.collect();
    let k = SparseSym::from_triplets(2 * n, both.into_iter());
    let m = SparseSym::from_triplets(2 * n, (0..2 * n).map(|i| (i, i, 1.0)));
    let plan = SparsePlan::new(&k, &m, &(0..2 * n).collect::<Vec<_>>()).unwrap();
    let start = DMatrix::from_fn(2 * n, 8, |i, j| if i < n { ((i * (j + 3)) as f64).sin() } else { 0.0 });
    let first = 4.0 * (PI / (2.0 * (n as f64 + 1.0))).sin().powi(2);
    let options = SparseOptions { n_modes: 8, shift: Some(first), ..SparseOptions::default() };
    let modes = lowest_sparse_modes(&plan, &k, &m, &none(2 * n), Some(&start), &options).unwrap();
    let mut exact: Vec<f64> = (1..=8)
        .flat_map(|i| [1.0, 1.1].map(|f| f * 4.0 * (f64::from(i) * PI / (2.0 * (n as f64 + 1.0))).sin().powi(2)))
        .collect();
    exact.sort_by(f64::total_cmp);
    for j in 0..8 {
        assert!(close(modes.values[j], exact[j], first, 4.4), "{j}: {} {}", modes.values[j], exact[j]);
    }
    let uncounted = SparseOptions { count: false, ..options };
    let blind = lowest_sparse_modes(&plan, &k, &m, &none(2 * n), Some(&start), &uncounted).unwrap();
    assert!(blind.values[1] > exact[1] * 1.05, "without the count they are missed: the test can fail");
}

/// Massless dofs, several dofs a node, and fewer modes than asked for.
#[test]
fn massless_dofs_have_no_mode() {
    let n = 60;
    let (k, _) = chain(n, false);
    let massive = 20;
    let m = SparseSym::from_triplets(n, (0..massive).map(|i| (3 * i, 3 * i, 1.0 + 0.01 * i as f64)));
    let plan = SparsePlan::new(&k, &m, &(0..n).map(|i| i / 3).collect::<Vec<_>>()).unwrap();
    for n_modes in [5, 40] {
        let options = SparseOptions { n_modes, ..SparseOptions::default() };
        let modes = lowest_sparse_modes(&plan, &k, &m, &none(n), None, &options).unwrap();
        let dense = lowest_modes(&k.to_dense(), &m.to_dense(), n_modes, modes.values[0]).unwrap();
        assert_eq!(modes.values.len(), dense.values.len());
        assert_eq!(modes.values.len(), n_modes.min(massive));
        for j in 0..modes.values.len() {
            let (ours, theirs) = (modes.values[j], dense.values[j]);
            assert!((ours / theirs - 1.0).abs() < 1e-10, "{n_modes} {j}: {ours} {theirs}");
        }
    }
}

/// The plan is reused with other values, and the last modes as a start change nothing but the number of steps.
#[test]
fn a_warm_start_gives_the_same_modes_in_fewer_steps() {
    let (k, m, _) = membrane(70, 43);
    let n = k.n();
    let plan = SparsePlan::new(&k, &m, &(0..n).collect::<Vec<_>>()).unwrap();
    let options = SparseOptions { n_modes: 20, ..SparseOptions::default() };
    let before = lowest_sparse_modes(&plan, &k, &m, &none(n), None, &options).unwrap();
    let changed = SparseSym::from_triplets(
        n,
        k.entries().map(|(i, j, v)| (i, j, if i == j && i % 7 == 0 { v * 1.0001 } else { v })),
    );
    assert!(plan.covers(&changed));
    let options = SparseOptions { shift: Some(before.shift), ..options };
    let cold = lowest_sparse_modes(&plan, &changed, &m, &none(n), None, &options).unwrap();
    let warm = lowest_sparse_modes(&plan, &changed, &m, &none(n), Some(&before.vectors), &options).unwrap();
    let again = lowest_sparse_modes(&plan, &changed, &m, &none(n), Some(&before.vectors), &options).unwrap();
    assert_eq!(warm.values, again.values, "same input, same bits");
    for j in 0..20 {
        assert!((cold.values[j] / warm.values[j] - 1.0).abs() < 1e-11);
        assert!((before.values[j] / warm.values[j] - 1.0).abs() > 1e-7, "the candidates differ");
    }
    assert!(warm.block_solves < cold.block_solves, "{} {}", warm.block_solves, cold.block_solves);
}

#[test]
fn wrong_matrices_are_refused() {
    let (k, m) = chain(5, true);
    let plan = SparsePlan::new(&k, &m, &[0, 1, 2, 3, 4]).unwrap();
    let options = SparseOptions { n_modes: 2, ..SparseOptions::default() };
    let nan =
        SparseSym::from_triplets(5, k.entries().map(|(i, j, v)| (i, j, if (i, j) == (3, 2) { f64::NAN } else { v })));
    let e = lowest_sparse_modes(&plan, &nan, &m, &none(5), None, &options).unwrap_err();
    assert_eq!(e, LinalgError::NotFinite { matrix: "stiffness", row: 3 });
    let empty =
        SparseSym::from_triplets(5, k.entries().map(|(i, j, v)| (i, j, if i == 4 || j == 4 { 0.0 } else { v })));
    let light = SparseSym::from_triplets(5, (0..4).map(|i| (i, i, 1.0)));
    let e = lowest_sparse_modes(&plan, &empty, &light, &none(5), None, &options).unwrap_err();
    assert!(matches!(e, LinalgError::NotPositiveDefinite { row: 4, .. }), "{e}");
    let soft = SparseSym::from_triplets(5, k.entries().map(|(i, j, v)| (i, j, -v)));
    let shifted = SparseOptions { shift: Some(0.1), ..options };
    assert!(lowest_sparse_modes(&plan, &soft, &m, &none(5), None, &shifted).is_err());
}

/// Derivatives of shapes without a factor of their own are those with one, across the modes that are known: with the factor of the matrices and with
/// that of a neighbour.
#[test]
fn systems_across_modes_need_no_factor_of_their_own() {
    let (k, m, _) = membrane(17, 11);
    let n = k.n();
    let plan = Arc::new(SparsePlan::new(&k, &m, &(0..n).collect::<Vec<_>>()).unwrap());
    let modes = lowest_sparse_modes(&plan, &k, &m, &none(n), None, &SparseOptions { n_modes: 9, ..Default::default() })
        .unwrap();
    let slope = SparseSym::from_triplets(n, (0..n).filter(|i| i % 7 == 0).map(|i| (i, i, 1.0 + (i % 5) as f64)));
    let (stiffer, _, _) = membrane(17, 11);
    let stiffer = SparseSym::from_triplets(
        n,
        stiffer.entries().map(|(i, j, v)| (i, j, v * if i % 2 == 0 || i != j { 1.3 } else { 1.5 })),
    );
    let forces = slope.mul(&modes.vectors);
    let across = |x: &DMatrix<f64>| x - &modes.vectors * modes.vectors.tr_mul(&m.mul(x));
    let mut expected = DMatrix::zeros(n, modes.values.len());
    for (j, lambda) in modes.values.iter().enumerate() {
        let phi = modes.vectors.column(j).into_owned();
        let m_phi = m.mul(&DMatrix::from_columns(std::slice::from_ref(&phi)));
        let force = forces.column(j) - m_phi.column(0) * phi.dot(&forces.column(j));
        let force = DMatrix::from_columns(&[force]);
        let phi = DMatrix::from_columns(&[phi]);
        let z = solve_beside_modes(&plan, &k, &m, *lambda, &phi, &force).unwrap().expect("a simple mode");
        expected.set_column(j, &across(&z).column(0));
    }
    let lambda: Vec<f64> = modes.values.iter().copied().collect();
    for preconditioner in [&k, &stiffer] {
        let factor = PencilFactor::new(plan.clone(), preconditioner, &m, modes.shift).unwrap();
        let (found, is_solved) = solve_across_modes(&factor, &k, &m, &modes.vectors, &lambda, &forces, 1e-11);
        // The next mode lies 3 % above the last: all get there.
        assert!(is_solved.iter().all(|s| *s), "{is_solved:?}");
        for j in 0..lambda.len() {
            let off = (found.column(j) - expected.column(j)).norm() / expected.column(j).norm();
            assert!(off < 1e-8, "mode {}: {off:.1e}", j + 1);
        }
        // Few digits where few are asked for.
        let (few, _) = solve_across_modes(&factor, &k, &m, &modes.vectors, &lambda, &forces, 1e-3);
        assert!((&few - &expected).norm() < 1e-2 * expected.norm());
    }
}

/// What lies beside a mode, or beside two, is the sum over all others; beside a double mode each of its halves moves as it does alone.
#[test]
fn systems_beside_modes_are_sums_over_the_others() {
    let (k, m, _) = membrane(13, 9);
    let n = k.n();
    let plan = SparsePlan::new(&k, &m, &(0..n).collect::<Vec<_>>()).unwrap();
    let (kd, md) = (k.to_dense(), m.to_dense());
    let scale = DMatrix::from_diagonal(&md.diagonal().map(|v| 1.0 / v.sqrt()));
    let all = (&scale * kd * &scale).symmetric_eigen();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| all.eigenvalues[a].total_cmp(&all.eigenvalues[b]));
    let shapes = (&scale * &all.eigenvectors).select_columns(&order);
    let lambda: Vec<f64> = order.iter().map(|&i| all.eigenvalues[i]).collect();
    let force = DMatrix::from_fn(n, 2, |i, j| if i % (5 + j) == 0 { 1.0 + (i % 4) as f64 } else { 0.0 });
    let beside = |first: usize, count: usize| {
        let mut along = shapes.tr_mul(&force);
        for (i, mut row) in along.row_iter_mut().enumerate() {
            row *= if (first..first + count).contains(&i) { 0.0 } else { 1.0 / (lambda[i] - lambda[first]) };
        }
        &shapes * along
    };
    for first in 0..5 {
        for count in 1..=2 {
            let these = shapes.columns(first, count).into_owned();
            let found = solve_beside_modes(&plan, &k, &m, lambda[first], &these, &force).unwrap().unwrap();
            let expected = beside(first, count);
            let off = (&found - &expected).norm() / expected.norm();
            assert!(off < 1e-9, "{count} from mode {first}: {off:.1e}");
        }
    }
    // One modulus of the whole structure moves none of its shapes: what it has beside them is rounding of what it has along them.
    let turned = DMatrix::from_fn(2, 2, |i, j| [[0.8, -0.6], [0.6, 0.8]][i][j]);
    let these = shapes.columns(1, 2) * turned;
    let whole = k.mul(&these.columns(0, 1).into_owned());
    let found = solve_beside_modes(&plan, &k, &m, lambda[1], &these, &whole).unwrap().unwrap();
    assert!(found.norm() < 1e-9 * these.norm(), "{:.1e}", found.norm());
    // Two equal structures side by side: their modes in any combination.
    let twice = |a: &SparseSym| {
        let both = a.entries().flat_map(|(i, j, v)| [(i, j, v), (n + i, n + j, v)]);
        SparseSym::from_triplets(2 * n, both)
    };
    let (kk, mm) = (twice(&k), twice(&m));
    let plan = SparsePlan::new(&kk, &mm, &(0..2 * n).collect::<Vec<_>>()).unwrap();
    let (s, c) = 0.6_f64.sin_cos();
    let side = |v: &DMatrix<f64>, a: f64, b: f64| {
        DMatrix::from_fn(2 * n, v.ncols(), |i, j| if i < n { a * v[(i, j)] } else { b * v[(i - n, j)] })
    };
    let phi = shapes.columns(0, 1).into_owned();
    let cluster = DMatrix::from_columns(&[side(&phi, c, s).column(0), side(&phi, -s, c).column(0)]);
    let found = solve_beside_modes(&plan, &kk, &mm, lambda[0], &cluster, &side(&force, c, s)).unwrap().unwrap();
    let expected = side(&beside(0, 1), c, s);
    assert!((found - &expected).norm() < 1e-9 * expected.norm());
    // One of the two is not a cluster.
    let half = cluster.columns(0, 1).into_owned();
    assert!(solve_beside_modes(&plan, &kk, &mm, lambda[0], &half, &side(&force, 1.0, 0.3)).unwrap().is_none());
}

/// A free beam in bending of `n` elements with consistent mass, some elements stiffer than others by a part of `trial`.
fn free_beam(n: usize, trial: usize) -> (SparseSym, SparseSym) {
    let l: f64 = 1.0 / n as f64;
    let (mut k, mut m) = (Vec::new(), Vec::new());
    for e in 0..n {
        let stiffness = if e % 3 == 0 { 1.0 + 1e-9 * trial as f64 } else { 1.0 };
        let of_k = [
            [12.0, 6.0 * l, -12.0, 6.0 * l],
            [0.0, 4.0 * l * l, -6.0 * l, 2.0 * l * l],
            [0.0, 0.0, 12.0, -6.0 * l],
            [0.0, 0.0, 0.0, 4.0 * l * l],
        ];
        let of_m = [
            [156.0, 22.0 * l, 54.0, -13.0 * l],
            [0.0, 4.0 * l * l, 13.0 * l, -3.0 * l * l],
            [0.0, 0.0, 156.0, -22.0 * l],
            [0.0, 0.0, 0.0, 4.0 * l * l],
        ];
        for i in 0..4 {
            for j in i..4 {
                k.push((2 * e + j, 2 * e + i, of_k[i][j] * stiffness / l.powi(3)));
                m.push((2 * e + j, 2 * e + i, of_m[i][j] * l / 420.0));
            }
        }
    }
    let size = 2 * (n + 1);
    (SparseSym::from_triplets(size, k.into_iter()), SparseSym::from_triplets(size, m.into_iter()))
}

/// From the modes themselves the third or fourth block is a few vectors and rounding, whatever their number: modes are the same, and none comes of rounding.
#[test]
fn from_the_modes_themselves_nothing_but_the_modes_comes() {
    for trial in 0..300 {
        let (k, m) = free_beam(70, trial);
        let n = k.n();
        let rigid = DMatrix::from_fn(n, 2, |i, j| match (i % 2, j) {
            (0, 0) => 1.0,
            (0, _) => (i / 2) as f64 / 70.0 - 0.5,
            (_, 0) => 0.0,
            _ => 1.0,
        });
        let lengths: Vec<f64> = (0..2).map(|j| rigid.column(j).dot(&m.mul(&rigid).column(j)).sqrt()).collect();
        let rigid = DMatrix::from_fn(n, 2, |i, j| rigid[(i, j)] / lengths[j]);
        let plan = SparsePlan::new(&k, &m, &(0..n).collect::<Vec<_>>()).unwrap();
        let options = SparseOptions { n_modes: 8 + trial % 20, tolerance: 1e-8, ..SparseOptions::default() };
        let cold = lowest_sparse_modes(&plan, &k, &m, &rigid, None, &options).unwrap();
        let options = SparseOptions { shift: Some(cold.shift), ..options };
        let warm = lowest_sparse_modes(&plan, &k, &m, &rigid, Some(&cold.vectors), &options).unwrap();
        for (warm, cold) in warm.values.iter().zip(cold.values.iter()) {
            assert!((warm / cold - 1.0).abs() < 1e-9, "{trial}: {warm} {cold}");
        }
        assert!(warm.count.is_some(), "{trial}");
    }
}
