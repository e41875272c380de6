//! Close and double modes: comparison of the spaces that shapes span.
//!
//! Modes of nearly equal frequency are not defined one by one: any rotation in their common plane fits the test nearly
//! as well. Their plane is defined, and principal angles compare planes.

use super::mac::unit_scale;
use super::{ModeList, PairedModes, ShapeScalar};
use crate::linalg::{DMatrix, LinalgError, thin_svd};

/// Relative singular value below which directions of a span are rounding noise.
const RANK_TOLERANCE: f64 = 1e-10;

/// Principal angles between the spans of two sets of shapes, ascending, rad.
///
/// ```text
/// cos θ_k = σ_k(Q_aᴴ Q_x)   small angles from   sin θ_k = σ(Q_x - Q_a Q_aᴴ Q_x)
/// ```
///
/// * `phi_a`, `phi_x` - shapes at the same sensors, any scaling, any number of columns, (n_sensor x n)
///
/// As many angles as the smaller rank. All zero: one span lies in the other. Sensors that a shape of either set lacks
/// (NaN) are left out for all. Independent of the basis: rotated or mixed double modes give the same angles.
///
/// # Panics
/// If the row counts differ.
///
/// # Source
/// A. Björck, G. H. Golub, Numerical methods for computing angles between linear subspaces, Mathematics of Computation 27
/// (1973) 579-594.
pub fn principal_angles<T: ShapeScalar>(phi_a: &DMatrix<T>, phi_x: &DMatrix<T>) -> Result<Vec<f64>, LinalgError> {
    assert_eq!(phi_a.nrows(), phi_x.nrows(), "shapes at the same sensors");
    let is_complete =
        |i: usize| phi_a.row(i).iter().all(|v| v.is_measured()) && phi_x.row(i).iter().all(|v| v.is_measured());
    let rows: Vec<usize> = (0..phi_a.nrows()).filter(|&i| is_complete(i)).collect();
    let q_a = orthonormal_basis(&embed(phi_a, &rows))?;
    let q_x = orthonormal_basis(&embed(phi_x, &rows))?;
    let (q_a, q_x) = if q_a.ncols() < q_x.ncols() { (q_x, q_a) } else { (q_a, q_x) };
    if q_x.ncols() == 0 {
        return Ok(Vec::new());
    }
    let cross = q_a.transpose() * &q_x;
    let cosines = thin_svd(&cross)?.values;
    let sines = thin_svd(&(&q_x - &q_a * cross))?.values; // descending: the largest belongs to the largest angle
    let n = q_x.ncols();
    let angle = |k: usize| {
        let (cosine, sine) = (cosines[k], sines[n - 1 - k]);
        if sine < std::f64::consts::FRAC_1_SQRT_2 { sine.asin() } else { cosine.min(1.0).acos() }
    };
    // The real picture of a complex space has every angle twice.
    Ok((0..n).step_by(2).map(angle).collect())
}

/// Rows `rows` of [Re -Im; Im Re]: the real picture of a complex matrix; spans and angles carry over, each twice.
fn embed<T: ShapeScalar>(phi: &DMatrix<T>, rows: &[usize]) -> DMatrix<f64> {
    let (n, columns) = (rows.len(), phi.ncols());
    DMatrix::from_fn(2 * n, 2 * columns, |i, j| {
        let value = phi[(rows[i % n.max(1)], j % columns.max(1))];
        match (i < n, j < columns) {
            (true, true) | (false, false) => value.real(),
            (true, false) => -value.imaginary(),
            (false, true) => value.imaginary(),
        }
    })
}

/// An orthonormal basis of the span of columns of unit length.
fn orthonormal_basis(a: &DMatrix<f64>) -> Result<DMatrix<f64>, LinalgError> {
    let mut unit = a.clone();
    for mut column in unit.column_iter_mut() {
        column.scale_mut(unit_scale(column.iter().copied()));
        let norm = column.norm();
        if norm > 0.0 {
            column.unscale_mut(norm);
        }
    }
    let svd = thin_svd(&unit)?;
    Ok(svd.left.columns(0, svd.rank(RANK_TOLERANCE)).into_owned())
}

/// MAC of every shape with a subspace: the share of its squared length that lies in the span.
///
/// ```text
/// S2MAC[j] = φ_x[j]ᴴ P φ_x[j] / φ_x[j]ᴴ φ_x[j]     P: projector on the span of φ_a
/// ```
///
/// * `span` - shapes of a group of close modes, (n_sensor x n)
/// * `shapes` - shapes to judge, (n_sensor x m)
///
/// In [0, 1], equal to the MAC for a span of one shape, never less than the largest MAC with a shape of the span. A large
/// span contains everything: with as many shapes as sensors it is always 1.
///
/// # Panics
/// If the row counts differ.
///
/// # Source
/// W. D'Ambrogio, A. Fregolent, Higher-order MAC for the correlation of close and multiple modes, Mechanical Systems and
/// Signal Processing 17 (2003) 599-610.
pub fn subspace_mac<T: ShapeScalar>(span: &DMatrix<T>, shapes: &DMatrix<T>) -> Result<Vec<f64>, LinalgError> {
    (0..shapes.ncols())
        .map(|j| {
            let angles = principal_angles(span, &shapes.columns(j, 1).into_owned())?;
            Ok(angles.first().map_or(0.0, |angle| angle.cos().powi(2)))
        })
        .collect()
}

/// A group of close modes and how well their spans agree.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct CloseModes {
    /// Analytical modes of the group.
    pub analytical: Vec<usize>,
    /// Their experimental partners, in the same order.
    pub experimental: Vec<usize>,
    /// Smallest MAC of the pairs, one by one.
    pub lowest_mac: f64,
    /// Principal angles between the spans, ascending, rad.
    pub angles: Vec<f64>,
    /// Smallest share of an experimental shape in the analytical span; see [`subspace_mac`].
    pub lowest_subspace_mac: f64,
}

/// Finds groups of paired modes with close frequencies and compares their spans.
///
/// Two pairs belong together when their frequencies differ by at most `relative_gap` in the model or in the test; groups
/// are what such links connect. A group with small angles and low MACs has no wrong mode, only rotated ones: compare the
/// plane and not the modes. Groups of one are not reported.
///
/// * `relative_gap` - |f₁ - f₂| / max(f₁, f₂) that counts as close, for example 0.02
///
/// # Panics
/// If the row counts differ or `paired` names modes beyond the columns.
pub fn assess_close_modes<T: ShapeScalar>(
    phi_a: &DMatrix<T>,
    analytical: &ModeList<'_>,
    phi_x: &DMatrix<T>,
    experimental: &ModeList<'_>,
    paired: &PairedModes,
    relative_gap: f64,
) -> Result<Vec<CloseModes>, LinalgError> {
    let is_close = |f: &[f64], i: usize, j: usize| match (f.get(i), f.get(j)) {
        (Some(a), Some(b)) => (a - b).abs() <= relative_gap * a.max(*b),
        _ => false,
    };
    let pairs = &paired.pairs;
    let mut group_of: Vec<usize> = (0..pairs.len()).collect();
    for p in 0..pairs.len() {
        for q in p + 1..pairs.len() {
            let is_linked = is_close(analytical.frequencies_hz, pairs[p].analytical, pairs[q].analytical)
                || is_close(experimental.frequencies_hz, pairs[p].experimental, pairs[q].experimental);
            if is_linked && group_of[p] != group_of[q] {
                let (low, high) = (group_of[p].min(group_of[q]), group_of[p].max(group_of[q]));
                group_of.iter_mut().filter(|g| **g == high).for_each(|g| *g = low);
            }
        }
    }
    let mut groups = Vec::new();
    for group in 0..pairs.len() {
        let members: Vec<_> = (0..pairs.len()).filter(|&p| group_of[p] == group).map(|p| &pairs[p]).collect();
        if members.len() < 2 {
            continue;
        }
        let analytical: Vec<usize> = members.iter().map(|p| p.analytical).collect();
        let experimental: Vec<usize> = members.iter().map(|p| p.experimental).collect();
        let (span_a, span_x) = (phi_a.select_columns(&analytical), phi_x.select_columns(&experimental));
        groups.push(CloseModes {
            lowest_mac: members.iter().map(|p| p.mac).fold(1.0, f64::min),
            angles: principal_angles(&span_a, &span_x)?,
            lowest_subspace_mac: subspace_mac(&span_a, &span_x)?.into_iter().fold(1.0, f64::min),
            analytical,
            experimental,
        });
    }
    Ok(groups)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlation::{PairingOptions, mac_matrix, pair_modes};
    use crate::linalg::Complex;

    /// The plane z = 0 against the plane through x tilted by 0.3 rad: angles 0 and 0.3.
    #[test]
    fn angles_between_two_planes() {
        let a = DMatrix::from_column_slice(3, 2, &[1.0, 2.0, 0.0, -1.0, 1.0, 0.0]);
        let x = DMatrix::from_column_slice(3, 2, &[1.0, 0.0, 0.0, 5.0, 0.3f64.cos(), 0.3f64.sin()]);
        let angles = principal_angles(&a, &x).unwrap();
        assert!(angles[0].abs() < 1e-15 && (angles[1] - 0.3).abs() < 1e-15);
        // Small angles keep their digits, though their cosine has lost them.
        let x = DMatrix::from_column_slice(3, 1, &[1.0, 0.0, 1e-9]);
        assert!((principal_angles(&a, &x).unwrap()[0] - 1e-9).abs() < 1e-20);
    }

    #[test]
    fn one_shape_gives_the_mac_also_when_complex() {
        let a = DMatrix::from_fn(5, 1, |i, _| Complex::new((i as f64).cos(), 0.2 * i as f64));
        let x = DMatrix::from_fn(5, 1, |i, _| Complex::new(0.3 * i as f64, (2.0 * i as f64).sin()));
        let angle = principal_angles(&a, &x).unwrap();
        assert_eq!(angle.len(), 1);
        assert!((angle[0].cos().powi(2) - mac_matrix(&a, &x)[(0, 0)]).abs() < 1e-14);
    }

    #[test]
    fn rotated_double_modes_agree_as_a_plane() {
        let a = DMatrix::from_fn(8, 3, |i, j| (0.4 * (i + 1) as f64 * (j + 1) as f64).sin());
        let (s, c) = 0.6f64.sin_cos();
        let mut x = a.clone();
        x.set_column(0, &(a.column(0) * c + a.column(1) * s));
        x.set_column(1, &(a.column(1) * c - a.column(0) * s));
        let (f_a, f_x) = ([10.0, 10.01, 20.0], [10.1, 10.11, 20.2]);
        let list_a = ModeList { frequencies_hz: &f_a, ..ModeList::default() };
        let list_x = ModeList { frequencies_hz: &f_x, ..ModeList::default() };
        let paired = pair_modes(&mac_matrix(&a, &x), &list_a, &list_x, &PairingOptions::default());
        let groups = assess_close_modes(&a, &list_a, &x, &list_x, &paired, 0.02).unwrap();
        assert_eq!(groups.len(), 1);
        assert!(groups[0].lowest_mac < 0.75 && groups[0].lowest_subspace_mac > 1.0 - 1e-12);
        assert!(groups[0].angles.iter().all(|t| *t < 1e-14));
    }

    #[test]
    fn nothing_in_common_and_nothing_at_all() {
        let zero = DMatrix::<f64>::zeros(3, 1);
        assert!(principal_angles(&zero, &zero).unwrap().is_empty());
        assert_eq!(subspace_mac(&zero, &DMatrix::from_element(3, 1, 1.0)).unwrap(), [0.0]);
        let nothing = DMatrix::from_element(3, 1, f64::NAN);
        assert!(principal_angles(&nothing, &zero).unwrap().is_empty());
    }
}
