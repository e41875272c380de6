//! Modes that are so close that only the space which they span together is determined.
//!
//! A mast of round section bends in any plane at one frequency: its model has a double mode, whose two shapes are a choice of the
//! solver, and its test has two modes in planes that small imperfections chose. Compared shape by shape they disagree; compared
//! as spaces they agree. So the model's shapes are turned inside each such space to those of the test:
//!
//! ```text
//! B = argmin |T - Φ B|,   B = U S Vᵀ (columns of unit length),   Φ -> Φ Q with Q = U Vᵀ, completed to an orthogonal matrix
//! ```
//!
//! for the test shapes T that Φ, the shapes of the space at the sensors, explains best; from there by plane rotations to the least
//! Σ |W(c φ - t)|², c the free scale of each shape and W the reciprocals of the standard deviations, so that a fit is stationary in
//! the angles. Shapes stay mass-normalised, frequencies as they are. Of a fit, the angles are free numbers as the scales of the
//! shapes are.
//!
//! # Source
//! P. H. Schönemann, A generalized solution of the orthogonal Procrustes problem, Psychometrika 31, 1966; for modes: M. I.
//! Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995, section 4.5.

use crate::correlation::mac_matrix;
use crate::linalg::{DMatrix, DVector};
use crate::modal::Modes;

/// Relative difference of the frequencies of neighbouring modes of one symmetry below which their shapes are turned to the test:
/// the imperfections of a structure, wall thickness and straightness of a tube, move frequencies by as much.
const CLOSE: f64 = 0.005;
/// The same for any two modes: one frequency but for rounding.
pub(super) const DOUBLE: f64 = 1e-6;
/// How far beside the measured band, as a factor, a mode may lie whose shape is turned: none beyond an octave is a partner.
const OCTAVE: f64 = 2.0;
/// A shape that is smaller at the sensors than this share of the others of its cluster is not turned, nor is a space whose shapes at the
/// sensors are parallel but for this: the test does not tell by what angle.
const SEEN: f64 = 1e-3;
/// Rounds of plane rotations, and the angle, rad, below which nothing is turned any more.
const ROUNDS: usize = 30;
const STILL: f64 = 1e-12;
/// Most that a plane is turned at once, rad.
const MOST_TURN: f64 = 0.3;
/// Share of a test shape that a space must explain for its modes to be turned to it.
const EXPLAINED: f64 = 0.5;

/// Which modes are close enough, in a test.
#[derive(Debug, Clone, Copy)]
pub(super) struct Closeness {
    gap: f64,
    band_hz: [f64; 2],
}

impl Closeness {
    /// For a test with modes at these frequencies, with shapes or without.
    pub(super) fn new(frequencies_hz: &[f64], has_shapes: bool) -> Self {
        let lowest = frequencies_hz.iter().copied().fold(f64::INFINITY, f64::min);
        let highest = frequencies_hz.iter().copied().fold(0.0, f64::max);
        let gap = if has_shapes { CLOSE } else { DOUBLE };
        Self { gap, band_hz: [lowest / OCTAVE, highest * OCTAVE] }
    }

    /// Whether two neighbouring modes are one cluster.
    ///
    /// * `is_alike` - whether they have the same symmetry, or none that is known
    pub(super) fn joins(&self, lower: f64, upper: f64, is_alike: impl Fn() -> bool) -> bool {
        let gap = upper - lower;
        let [from, to] = self.band_hz;
        lower >= from && upper <= to && (gap < DOUBLE * upper || (gap < self.gap * upper && is_alike()))
    }
}

/// Runs of neighbouring elastic modes that are so close, by index among the elastic modes.
pub(super) fn clusters(
    frequencies_hz: &[f64],
    closeness: Closeness,
    is_alike: impl Fn(usize, usize) -> bool,
) -> Vec<Vec<usize>> {
    let mut out: Vec<Vec<usize>> = Vec::new();
    for i in 1..frequencies_hz.len() {
        let gap = closeness.joins(frequencies_hz[i - 1], frequencies_hz[i], || is_alike(i - 1, i));
        match out.last_mut().filter(|c| c.last() == Some(&(i - 1))) {
            Some(cluster) if gap => cluster.push(i),
            _ if gap => out.push(vec![i - 1, i]),
            _ => {}
        }
    }
    out
}

/// The modes of each cluster that the sensors see, where these are two at least.
///
/// * `at_sensors` - elastic shapes at the sensors, (n_sensor x n_elastic)
pub(super) fn seen(clusters: Vec<Vec<usize>>, at_sensors: &DMatrix<f64>) -> Vec<Vec<usize>> {
    let one = |mut cluster: Vec<usize>| {
        let length = |&k: &usize| at_sensors.column(k).norm();
        let least = SEEN * cluster.iter().map(length).fold(0.0, f64::max);
        cluster.retain(|k| length(k) > least);
        cluster
    };
    clusters.into_iter().map(one).filter(|c| c.len() > 1).collect()
}

/// Turns the shapes of a cluster to those of the test.
///
/// * `at_sensors` - elastic shapes at the sensors, (n_sensor x n_elastic)
/// * `tests` - to which of them they are turned
///
/// Returns Q; `None` where they are left as they are.
pub(super) fn turn(
    modes: &mut Modes,
    cluster: &[usize],
    at_sensors: &DMatrix<f64>,
    tests: Measured<'_>,
) -> Option<DMatrix<f64>> {
    let q = turning(at_sensors, cluster, tests)?;
    turn_by(modes, cluster, &q);
    Some(q)
}

/// Φ -> Φ Q of a cluster.
pub(super) fn turn_by(modes: &mut Modes, cluster: &[usize], q: &DMatrix<f64>) {
    let columns: Vec<usize> = cluster.iter().map(|k| modes.n_rigid + k).collect();
    let turned = modes.shapes.select_columns(&columns) * q;
    columns.iter().zip(turned.column_iter()).for_each(|(&column, shape)| modes.shapes.set_column(column, &shape));
}

/// Test shapes to which others are turned.
#[derive(Debug, Clone, Copy)]
pub(super) struct Measured<'a> {
    /// Real shapes, NaN where not measured, (n_sensor x n_tests).
    pub(super) shapes: &'a DMatrix<f64>,
    /// Reciprocals of their standard deviations, of the same shape.
    pub(super) weights: &'a DMatrix<f64>,
    /// The columns that count; none for all.
    pub(super) only: Option<&'a [usize]>,
}

/// Q of a cluster; `None` where no test shape says how its shapes stand.
///
/// A test shape says so where the cluster explains more of it than any other mode does, unless it is said to be of this space. Where the test has fewer
/// shapes than the cluster, each is that of the mode which it is most like, in their order.
///
/// * `at_sensors` - elastic shapes at the sensors, (n_sensor x n_elastic)
pub(super) fn turning(at_sensors: &DMatrix<f64>, cluster: &[usize], measured: Measured<'_>) -> Option<DMatrix<f64>> {
    let tests = measured.shapes;
    let seen = &at_sensors.select_columns(cluster);
    let counts = |j: &usize| measured.only.is_none_or(|only| only.contains(j));
    let mut found: Vec<(f64, usize, DVector<f64>)> = (0..tests.ncols())
        .filter(counts)
        .filter_map(|j| explain(seen, tests, j).map(|(share, b)| (share, j, b)))
        .collect();
    if measured.only.is_none() && !found.is_empty() {
        let mac = mac_matrix(at_sensors, tests);
        let is_of_another =
            |share: f64, j: usize| (0..mac.nrows()).any(|k| !cluster.contains(&k) && mac[(k, j)] > share);
        found.retain(|(share, j, _)| !is_of_another(*share, *j));
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    found.truncate(seen.ncols());
    if found.is_empty() {
        return None;
    }
    // The test lists its modes by frequency, so the lower one gets the lower frequency of the model.
    found.sort_by_key(|f| f.1);
    let columns: Vec<usize> = found.iter().map(|f| f.1).collect();
    let q = nearest_orthogonal(&DMatrix::from_columns(&found.into_iter().map(|f| f.2).collect::<Vec<_>>()))?;
    Some(in_places(&settled(seen, q, measured, &columns), columns.len()))
}

/// Q with its first columns, those of test shapes, in the places of the modes that they are most like: ascending places p that have the largest Σ q_pk².
fn in_places(q: &DMatrix<f64>, count: usize) -> DMatrix<f64> {
    let n = q.ncols();
    if count == n {
        return q.clone();
    }
    let mut best = vec![vec![f64::NEG_INFINITY; n + 1]; count + 1];
    best[0].fill(0.0);
    for k in 1..=count {
        for p in k..=n {
            best[k][p] = best[k][p - 1].max(best[k - 1][p - 1] + q[(p - 1, k - 1)].powi(2));
        }
    }
    let mut columns: Vec<Option<usize>> = vec![None; n];
    let (mut k, mut p) = (count, n);
    while k > 0 {
        if best[k][p] > best[k][p - 1] {
            columns[p - 1] = Some(k - 1);
            k -= 1;
        }
        p -= 1;
    }
    let mut rest = count..n;
    let columns: Vec<usize> = columns.into_iter().filter_map(|own| own.or_else(|| rest.next())).collect();
    q.select_columns(&columns)
}

/// Q turned on to where the shapes fit best, their scales free.
///
/// * `columns` - the test shape of each of the first columns of Q
fn settled(seen: &DMatrix<f64>, mut q: DMatrix<f64>, measured: Measured<'_>, columns: &[usize]) -> DMatrix<f64> {
    let products: Vec<Products> = columns.iter().map(|&j| Products::new(seen, measured, j)).collect();
    for _ in 0..ROUNDS {
        let mut largest: f64 = 0.0;
        for k in 0..products.len() {
            for l in k + 1..q.ncols() {
                let (a, b) = (q.column(k).into_owned(), q.column(l).into_owned());
                let own = products[k].slopes([&a, &b]);
                // The other is turned by the same angle: from b towards -a.
                let other = products.get(l).map_or([0.0; 2], |p| p.slopes([&b, &-&a]));
                let (slope, curvature) = (own[0] + other[0], own[1] + other[1]);
                let step = if curvature > 0.0 { -slope / curvature } else { -slope.signum() * MOST_TURN };
                let angle = if step.is_finite() { step.clamp(-MOST_TURN, MOST_TURN) } else { 0.0 };
                let (sin, cos) = angle.sin_cos();
                q.set_column(k, &(&a * cos + &b * sin));
                q.set_column(l, &(b * cos - a * sin));
                largest = largest.max(angle.abs());
            }
        }
        if largest < STILL {
            break;
        }
    }
    q
}

/// Weighted products of a test shape with the shapes of a cluster.
struct Products {
    /// Φᵀ W² t.
    cross: DVector<f64>,
    /// Φᵀ W² Φ.
    own: DMatrix<f64>,
}

impl Products {
    fn new(seen: &DMatrix<f64>, measured: Measured<'_>, test: usize) -> Self {
        let n = seen.ncols();
        let (mut cross, mut own) = (DVector::zeros(n), DMatrix::zeros(n, n));
        for i in (0..seen.nrows()).filter(|&i| !measured.shapes[(i, test)].is_nan()) {
            let w = measured.weights[(i, test)].powi(2);
            for a in 0..n {
                cross[a] += w * seen[(i, a)] * measured.shapes[(i, test)];
                for b in 0..n {
                    own[(a, b)] += w * seen[(i, a)] * seen[(i, b)];
                }
            }
        }
        Self { cross, own }
    }

    /// First and second derivative in θ, at zero, of what the best scale leaves of the test shape, less the shape itself:
    ///
    /// ```text
    /// f = -(x·v)²/(vᵀ G v),   v = a cos θ + b sin θ,   x = Φᵀ W² t,   G = Φᵀ W² Φ
    /// ```
    fn slopes(&self, [a, b]: [&DVector<f64>; 2]) -> [f64; 2] {
        let (n, dn) = (self.cross.dot(a), self.cross.dot(b));
        let ga = &self.own * a;
        let (d, ab, bb) = (a.dot(&ga), b.dot(&ga), b.dot(&(&self.own * b)));
        if d <= 0.0 {
            return [0.0; 2];
        }
        let (dd, ddd) = (2.0 * ab, 2.0 * (bb - d));
        let (top, dtop, ddtop) = (n * n, 2.0 * n * dn, 2.0 * (dn * dn - n * n));
        let slope = (dtop * d - top * dd) / (d * d);
        [-slope, -((ddtop * d - top * ddd) / (d * d) - 2.0 * dd * slope / d)]
    }
}

/// How much of a test shape the cluster explains, and by which combination of unit length.
fn explain(seen: &DMatrix<f64>, tests: &DMatrix<f64>, test: usize) -> Option<(f64, DVector<f64>)> {
    let measured: Vec<usize> = (0..tests.nrows()).filter(|&i| !tests[(i, test)].is_nan()).collect();
    if measured.len() < seen.ncols() {
        return None;
    }
    let phi = seen.select_rows(&measured);
    let t = DVector::from_iterator(measured.len(), measured.iter().map(|&i| tests[(i, test)]));
    let svd = phi.clone().svd(true, true);
    if svd.singular_values.min() < SEEN * svd.singular_values.max() {
        return None;
    }
    let b = svd.solve(&t, 0.0).ok()?;
    let share = (&phi * &b).norm_squared() / t.norm_squared();
    let length = b.norm();
    (share > EXPLAINED && length > 0.0).then(|| (share, b / length))
}

/// The orthogonal matrix whose first columns are nearest to those of `b`; `None` where these are parallel.
fn nearest_orthogonal(b: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = b.nrows();
    let svd = b.clone().svd(true, true);
    let (u, v) = (svd.u?, svd.v_t?);
    if svd.singular_values.min() < 1e-3 {
        return None;
    }
    let mut columns: Vec<DVector<f64>> = (u * v).column_iter().map(nalgebra::Matrix::into_owned).collect();
    for k in 0..n {
        if columns.len() == n {
            break;
        }
        let mut e = DVector::zeros(n);
        e[k] = 1.0;
        for _ in 0..2 {
            for c in &columns {
                e -= c * c.dot(&e);
            }
        }
        let length = e.norm();
        if length > 0.5 / (n as f64).sqrt() {
            columns.push(e / length);
        }
    }
    (columns.len() == n).then(|| DMatrix::from_columns(&columns))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::TestData;
    use crate::model::{ParametricModel, Registry, load};
    use crate::objective::batch::BatchPath;
    use crate::objective::mast::{MAST, OPEN, sensors};
    use crate::objective::{Comparison, LeastSquares, Objective, Scaling, difference};
    use crate::update::{TwinOptions, assess, twin_modes};
    use std::sync::Arc;

    /// The modes of the mast in planes that stand at some angles to its axes.
    fn test(angles: &[f64]) -> TestData {
        let model = load(MAST, &Registry::builtin()).unwrap().0;
        let sensors = sensors();
        let options = TwinOptions { n_modes: 2 * angles.len(), ..TwinOptions::default() };
        let mut test = twin_modes(&model, &model.parameters().nominal(), &sensors, &options, "made up").unwrap();
        for (k, angle) in angles.iter().enumerate() {
            let shape = |m: usize| test.modes[m].shape.clone().unwrap();
            let (a, b) = (shape(2 * k), shape(2 * k + 1));
            let (s, c) = angle.to_radians().sin_cos();
            test.modes[2 * k].shape = Some(a.zip_map(&b, |a, b| a * c - b * s));
            test.modes[2 * k + 1].shape = Some(a.zip_map(&b, |a, b| a * s + b * c));
        }
        for mode in &mut test.modes {
            mode.label = None;
            mode.frequency_hz.sd = 0.003 * mode.frequency_hz.value;
            mode.shape_sd = mode.shape.as_ref().map(|s| s.map(|_| 0.02));
        }
        test
    }

    /// Of two close modes a test has one, that of the higher: it stays there; and a test shape of another mode, of which the two explain more than half
    /// at so few sensors, turns neither.
    #[test]
    fn one_shape_of_two_stays_with_its_mode() {
        let at_sensors = DMatrix::from_row_slice(4, 3, &[1.0, 0.0, 0.5, 0.0, 1.0, 0.6, 0.3, 0.0, 0.5, 0.0, 0.2, -0.4]);
        let alien = at_sensors.column(2).into_owned();
        assert!(
            explain(&at_sensors.columns(0, 2).into_owned(), &DMatrix::from_columns(std::slice::from_ref(&alien)), 0)
                .is_some()
        );
        let upper = at_sensors.column(1) + at_sensors.column(0) * 0.02;
        let shapes = DMatrix::from_columns(&[upper, alien]);
        let weights = DMatrix::from_element(4, 2, 50.0);
        let measured = Measured { shapes: &shapes, weights: &weights, only: None };
        let q = turning(&at_sensors, &[0, 1], measured).unwrap();
        assert!((q.transpose() * &q - DMatrix::identity(2, 2)).amax() < 1e-12);
        let turned = at_sensors.columns(0, 2) * &q;
        assert!(mac_matrix(&turned, &shapes)[(1, 0)] > 1.0 - 1e-12 && q[(1, 1)].abs() > 0.99, "{q}");
    }

    #[test]
    fn double_modes_agree_with_a_test_in_any_plane() {
        let model = load(MAST, &Registry::builtin()).unwrap().0;
        let theta = model.parameters().nominal();
        for angles in [[0.0, 0.0, 0.0], [35.0, 50.0, 20.0], [90.0, -45.0, 170.0]] {
            let test = test(&angles);
            let comparison = Comparison::new(&model, &test, OPEN).unwrap();
            let p = comparison.predict(&theta).unwrap();
            assert_eq!(p.pairs.pairs.len(), 6);
            for pair in &p.pairs.pairs {
                assert!(pair.mac > 1.0 - 1e-10, "{angles:?}: {pair:?}");
            }
            let cost = LeastSquares::new(&comparison).cost(&Scaling::new(&model).x(&theta)).unwrap();
            assert!(cost < 1e-8, "{angles:?}: {cost}");
            let gram = p.modes.shapes.transpose() * comparison_mass(&p) * &p.modes.shapes;
            assert!((gram - DMatrix::identity(p.modes.len(), p.modes.len())).amax() < 1e-9);
        }
    }

    fn comparison_mass(p: &crate::objective::Prediction) -> DMatrix<f64> {
        p.system().unwrap().mass.clone()
    }

    /// Of right models chi-squared has the mean of its number of data, from which three angles are taken.
    #[test]
    fn chi_squared_knows_the_free_angles() {
        let model = load(MAST, &Registry::builtin()).unwrap().0;
        let theta = model.parameters().nominal();
        let sensors = test(&[0.0]).sensors;
        let (tests, mut sum) = (200_u32, 0.0);
        for seed in 0..u64::from(tests) {
            let noise = TwinOptions { frequency_noise: 0.003, shape_noise: 0.02, ..TwinOptions::default() };
            let options = TwinOptions { n_modes: 6, seed, ..noise };
            let test = twin_modes(&model, &theta, &sensors, &options, "made up").unwrap();
            let comparison = Comparison::new(&model, &test, OPEN).unwrap();
            let misfit = assess(&comparison, &theta).unwrap().misfit;
            // Six frequencies, 48 readings of shapes, six scales, three angles.
            assert_eq!(misfit.n_data, 45);
            sum += misfit.chi_squared;
        }
        // Three standard errors of the mean of chi-squared numbers.
        let (mean, limit) = (sum / f64::from(tests), 3.0 * (90.0 / f64::from(tests)).sqrt());
        assert!((mean - 45.0).abs() < limit, "{mean}, limit {limit}");
    }

    /// Parameters that keep the mast round move frequencies and the space of a pair, and no angle.
    #[test]
    fn residuals_of_double_modes_have_derivatives() {
        let model = load(MAST, &Registry::builtin()).unwrap().0;
        let test = test(&[35.0, 50.0, 20.0]);
        let comparison = Comparison::new(&model, &test, OPEN).unwrap();
        let objective = LeastSquares::new(&comparison);
        let x = DVector::from_row_slice(&[0.3, 0.7]);
        let exact = objective.linearize(&x).unwrap();
        let by_difference = difference(objective.n_residuals(), &x, |x| objective.residuals(x)).unwrap();
        for j in 0..2 {
            let (a, b) = (exact.jacobian.column(j), by_difference.jacobian.column(j));
            let error = (a - b).amax() / a.amax();
            assert!(error < 1e-4, "parameter {j}: {error:.1e}");
        }
    }

    /// The kernel turns shapes as the reference path does, for many points and for single ones with derivatives.
    #[test]
    fn double_modes_go_through_the_kernel() {
        let model = load(MAST, &Registry::builtin()).unwrap().0;
        let test = test(&[35.0, 50.0, 20.0]);
        let comparison = Comparison::new(&model, &test, OPEN).unwrap();
        let plain = LeastSquares::new(&comparison);
        let x = DVector::from_row_slice(&[0.3, 0.7]);
        let cost = 0.5 * plain.residuals(&x).unwrap().norm_squared();
        let searched = LeastSquares::new(&comparison);
        let mut costs = [0.0; 3];
        searched.costs(&[x.clone(), x.clone(), x.clone()], &mut costs);
        assert!(costs.iter().all(|c| (c - cost).abs() < 1e-9 * cost), "{costs:?} {cost}");
        assert_eq!((searched.path_counts().batch, searched.path_counts().reference), (3, 0));
        let alone = LeastSquares::new(&comparison).through(Arc::new(BatchPath::with_derivatives()));
        assert!((alone.cost(&x).unwrap() - cost).abs() < 1e-9 * cost);
        let (fast, exact) = (alone.linearize(&x).unwrap(), plain.linearize(&x).unwrap());
        assert!((fast.residuals - exact.residuals).amax() < 1e-7);
        assert!((fast.jacobian - &exact.jacobian).amax() < 1e-6 * exact.jacobian.amax());
        assert_eq!((alone.path_counts().batch, alone.path_counts().reference), (2, 0));
    }

    /// Shapes of the second pair at a frequency far below it: their partners lie beyond the band where modes are turned, and have
    /// derivatives all the same.
    #[test]
    fn double_modes_far_from_their_partners_have_derivatives() {
        let model = load(MAST, &Registry::builtin()).unwrap().0;
        let mut test = test(&[0.0, 0.0]);
        test.modes.drain(..2);
        test.modes.iter_mut().for_each(|m| m.frequency_hz.value /= 3.0);
        let comparison = Comparison::new(&model, &test, OPEN).unwrap();
        let x = DVector::from_row_slice(&[0.3, 0.7]);
        assert!(comparison.predict(&Scaling::new(&model).theta(&x)).unwrap().clusters.is_empty());
        let objective = LeastSquares::new(&comparison);
        let exact = objective.linearize(&x).unwrap();
        let by_difference = difference(objective.n_residuals(), &x, |x| objective.residuals(x)).unwrap();
        // The frequencies; the shapes of a double mode are any two of their space.
        let (a, b) = (exact.jacobian.rows(0, 2), by_difference.jacobian.rows(0, 2));
        assert!((a - b).amax() < 1e-4 * a.amax(), "{a} {b}");
        assert!(exact.jacobian.iter().all(|v| v.is_finite()));
    }

    #[test]
    fn modes_apart_are_left_as_they_are() {
        let closeness = Closeness::new(&[1.0, 3.0], true);
        assert!(clusters(&[1.0, 1.1, 1.2], closeness, |_, _| true).is_empty());
        assert_eq!(clusters(&[1.0, 1.001, 2.0, 3.0, 3.0, 3.0], closeness, |_, _| true), [vec![0, 1], vec![3, 4, 5]]);
        assert_eq!(clusters(&[1.0, 1.001, 2.0, 2.0], closeness, |_, _| false), [vec![2, 3]]);
        // Of frequencies alone only one frequency makes a cluster; far above the band none does.
        let closeness = Closeness::new(&[1.0, 3.0], false);
        assert_eq!(clusters(&[1.0, 1.001, 2.0, 2.0, 7.0, 7.0], closeness, |_, _| true), [vec![2, 3]]);
    }
}
