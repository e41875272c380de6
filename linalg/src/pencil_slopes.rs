//! Derivatives of the modes of a small affine pencil, from the terms of its matrices.
//!
//! ```text
//! ∂λ = φᵀ (∂K - λ ∂M) φ,    (K - λM) z = (∂λ M - ∂K + λ ∂M) φ,    ∂φ = z - (φᵀ M z + ½ φᵀ ∂M φ) φ
//! ```
//!
//! One row and column of K - λM are struck out, which leaves a regular matrix with the same envelope; it is factored as LDLᵀ without pivots, the
//! solution is refined once, and the residual, in the struck row too, says whether it is one.
//!
//! Of c modes with (nearly) equal λ as many rows S are struck out. What they span together has a derivative across it: with the solution z₀ that is
//! zero in S and the solutions N of the other rows that are unit vectors in S,
//!
//! ```text
//! F := F - M Φ ΦᵀF,    z = z₀ - N (ΦᵀMN)⁻¹ ΦᵀM z₀
//! ```
//!
//! Sources: R. B. Nelson, Simplified calculation of eigenvector derivatives, AIAA Journal 14(9), 1976; A. George, J. W. Liu, Computer Solution of
//! Large Sparse Positive Definite Systems, 1981, chapter 4.

use crate::batch::{AffineEntry, AffinePencil};
use crate::envelope::{Envelope, reverse_cuthill_mckee};
use crate::{DMatrix, DVector};
use std::collections::{BTreeMap, BTreeSet};

/// Largest residual over the sum of its terms with which a derivative is taken.
const RESIDUAL: f64 = 1e-8;

/// A term of one matrix: where it is stored, and what multiplies it.
#[derive(Debug, Clone, Copy)]
struct Term {
    at: usize,
    parameter: Option<usize>,
    coefficient: f64,
}

/// An entry of the derivatives of both matrices with respect to one parameter, in the order of the elimination.
#[derive(Debug, Clone, Copy)]
struct Slope {
    row: usize,
    column: usize,
    stiffness: f64,
    mass: f64,
}

/// An affine pencil, compiled for derivatives of its modes.
#[derive(Debug, Clone)]
pub struct PencilSlopes {
    envelope: Envelope,
    /// `order[new] = old`.
    order: Vec<usize>,
    stiffness: Vec<Term>,
    mass: Vec<Term>,
    /// Of every parameter.
    slopes: Vec<Vec<Slope>>,
}

/// The pencil at one θ.
#[derive(Debug)]
pub struct SlopesAt<'a> {
    of: &'a PencilSlopes,
    stiffness: Vec<f64>,
    mass: Vec<f64>,
}

impl PencilSlopes {
    /// Compiles a pencil.
    pub fn new(pencil: &AffinePencil) -> Self {
        let n = pencil.n;
        let mut neighbours = vec![BTreeSet::new(); n];
        for e in pencil.stiffness.iter().chain(&pencil.mass).filter(|e| e.row != e.col) {
            neighbours[e.row].insert(e.col);
            neighbours[e.col].insert(e.row);
        }
        let order = reverse_cuthill_mckee(&neighbours);
        let mut new = vec![0; n];
        order.iter().enumerate().for_each(|(at, &old)| new[old] = at);
        let place = |e: &AffineEntry| (new[e.row].max(new[e.col]), new[e.row].min(new[e.col]));
        let mut first: Vec<usize> = (0..n).collect();
        for (row, column) in pencil.stiffness.iter().chain(&pencil.mass).map(place) {
            first[row] = first[row].min(column);
        }
        let envelope = Envelope::new(first);
        let term = |e: &AffineEntry| {
            let (row, column) = place(e);
            Term { at: envelope.at(row, column), parameter: e.parameter, coefficient: e.coefficient }
        };
        let mut slopes: Vec<BTreeMap<(usize, usize), [f64; 2]>> = vec![BTreeMap::new(); pencil.n_parameters];
        for (k, entries) in [&pencil.stiffness, &pencil.mass].into_iter().enumerate() {
            for e in entries {
                if let Some(p) = e.parameter {
                    slopes[p].entry(place(e)).or_default()[k] += e.coefficient;
                }
            }
        }
        let slope =
            |((row, column), [stiffness, mass]): ((usize, usize), [f64; 2])| Slope { row, column, stiffness, mass };
        Self {
            stiffness: pencil.stiffness.iter().map(term).collect(),
            mass: pencil.mass.iter().map(term).collect(),
            slopes: slopes.into_iter().map(|s| s.into_iter().map(slope).collect()).collect(),
            envelope,
            order,
        }
    }

    /// K and M at θ.
    ///
    /// # Panics
    /// If `theta` is too short.
    pub fn at(&self, theta: &[f64]) -> SlopesAt<'_> {
        let fill = |terms: &[Term]| {
            let mut values = vec![0.0; self.envelope.len()];
            for t in terms {
                values[t.at] += t.coefficient * t.parameter.map_or(1.0, |p| theta[p]);
            }
            values
        };
        SlopesAt { of: self, stiffness: fill(&self.stiffness), mass: fill(&self.mass) }
    }
}

impl SlopesAt<'_> {
    /// ∂λ and ∂φ of a mode along some directions; `None` where a mode that is not given has its λ, or the factors do not serve.
    ///
    /// * `cluster` - φ with φᵀ M φ = 1, then those of the modes whose λ are equal or nearly so, in any basis of the space that they span,
    ///   (n) each; ∂φ is across them all
    /// * `directions` - of θ, (`n_parameters` x any number)
    ///
    /// # Panics
    /// If sizes differ, or there is no mode.
    pub fn mode(
        &self,
        lambda: f64,
        cluster: &[&[f64]],
        directions: &DMatrix<f64>,
    ) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let PencilSlopes { envelope, order, slopes, .. } = self.of;
        let (n, count) = (envelope.rows(), directions.ncols());
        assert!(cluster.iter().all(|s| s.len() == n) && directions.nrows() == slopes.len(), "sizes of a mode");
        if count == 0 {
            return Some((DVector::zeros(0), DMatrix::zeros(n, 0)));
        }
        let in_order = |shape: &&[f64]| -> Vec<f64> { order.iter().map(|&old| shape[old]).collect() };
        let shapes: Vec<Vec<f64>> = cluster.iter().map(in_order).collect();
        let momenta: Vec<Vec<f64>> = shapes.iter().map(|phi| times(envelope, &self.mass, phi, 1)).collect();
        let (phi, m_phi) = (&shapes[0], &momenta[0]);
        // (∂K - λ ∂M) φ of every parameter that any direction moves, row by row, and φᵀ ∂M φ.
        let mut forces = vec![0.0; n * count];
        let mut growth = vec![0.0; count];
        let mut own = vec![0.0; n];
        for (slopes, along) in slopes.iter().zip(directions.row_iter()).filter(|(_, along)| along.amax() > 0.0) {
            own.fill(0.0);
            let mut grown = 0.0;
            for s in slopes {
                let value = s.stiffness - lambda * s.mass;
                own[s.row] += value * phi[s.column];
                if s.row == s.column {
                    grown += s.mass * phi[s.row] * phi[s.row];
                } else {
                    own[s.column] += value * phi[s.row];
                    grown += 2.0 * s.mass * phi[s.row] * phi[s.column];
                }
            }
            for (j, &factor) in along.iter().enumerate().filter(|(_, f)| **f != 0.0) {
                forces[j..].iter_mut().step_by(count).zip(&own).for_each(|(f, v)| *f += factor * v);
                growth[j] += factor * grown;
            }
        }
        let mut slopes = vec![0.0; count];
        forces.chunks_exact(count).zip(phi).for_each(|(f, &phi)| add(&mut slopes, phi, f));
        for (force, m) in forces.chunks_exact_mut(count).zip(m_phi) {
            force.iter_mut().zip(&slopes).for_each(|(f, slope)| *f = slope * m - *f);
        }
        for (phi, m_phi) in shapes.iter().zip(&momenta).skip(1) {
            let along = products(phi, &forces, count);
            take(&mut forces, m_phi, &along);
        }
        let z = self.solve_beside(lambda, (&shapes, &momenta), &forces, count)?;
        let mut along: Vec<f64> = growth.iter().map(|g| 0.5 * g).collect();
        z.chunks_exact(count).zip(m_phi).for_each(|(z, &m)| add(&mut along, m, z));
        let mut shapes = DMatrix::zeros(n, count);
        for ((z, &phi), &old) in z.chunks_exact(count).zip(phi).zip(order) {
            for (j, (z, along)) in z.iter().zip(&along).enumerate() {
                shapes[(old, j)] = z - along * phi;
            }
        }
        Some((DVector::from_vec(slopes), shapes))
    }

    /// As many rows as there are shapes, in which these are largest and most unlike each other, dofs in comparable units.
    fn rows_that_tell(&self, shapes: &[Vec<f64>]) -> Vec<usize> {
        let envelope = &self.of.envelope;
        let unit = |i: usize| self.stiffness[envelope.at(i, i)].max(0.0).sqrt();
        let mut left: Vec<DVector<f64>> =
            (0..envelope.rows()).map(|i| DVector::from_fn(shapes.len(), |k, _| shapes[k][i] * unit(i))).collect();
        let mut found = Vec::with_capacity(shapes.len());
        for _ in shapes {
            let norm = |i: usize| left[i].norm_squared();
            let best = (0..left.len()).fold(0, |best, i| if norm(i) > norm(best) { i } else { best });
            found.push(best);
            let size = left[best].norm();
            let along = if size > 0.0 { &left[best] / size } else { left[best].clone() };
            for row in &mut left {
                *row -= &along * along.dot(row);
            }
        }
        found
    }

    /// Z with (K - λM) Z = F, both row by row: of one mode with a zero in one row, of several across them.
    fn solve_beside(
        &self,
        lambda: f64,
        (shapes, momenta): (&[Vec<f64>], &[Vec<f64>]),
        forces: &[f64],
        count: usize,
    ) -> Option<Vec<f64>> {
        let envelope = &self.of.envelope;
        let n = envelope.rows();
        let shifted: Vec<f64> = self.stiffness.iter().zip(&self.mass).map(|(k, m)| k - lambda * m).collect();
        let fixed = self.rows_that_tell(shapes);
        let mut factor = shifted.clone();
        for &fixed in &fixed {
            factor[envelope.row(fixed)].fill(0.0);
            for i in (fixed + 1..n).filter(|&i| envelope.first[i] <= fixed) {
                factor[envelope.at(i, fixed)] = 0.0;
            }
            factor[envelope.at(fixed, fixed)] = self.stiffness[envelope.at(fixed, fixed)].max(f64::MIN_POSITIVE);
        }
        factor_in_place(envelope, &mut factor);
        let strike = |x: &mut [f64], count: usize| {
            for &fixed in &fixed {
                x[fixed * count..(fixed + 1) * count].fill(0.0);
            }
        };
        let residual = |z: &[f64]| -> Vec<f64> {
            let product = times(envelope, &shifted, z, count);
            forces.iter().zip(product).map(|(f, p)| f - p).collect()
        };
        let mut z = vec![0.0; forces.len()];
        let mut left = forces.to_vec();
        for round in 0..2 {
            if round > 0 {
                left = residual(&z);
            }
            strike(&mut left, count);
            solve(envelope, &factor, &mut left, count);
            z.iter_mut().zip(&left).for_each(|(z, l)| *z += l);
        }
        if fixed.len() > 1 {
            // The solutions of the other rows without forces, unit vectors in the struck ones.
            let size = fixed.len();
            let mut units = vec![0.0; n * size];
            fixed.iter().enumerate().for_each(|(k, &fixed)| units[fixed * size + k] = 1.0);
            let mut free: Vec<f64> = times(envelope, &shifted, &units, size).iter().map(|v| -v).collect();
            strike(&mut free, size);
            solve(envelope, &factor, &mut free, size);
            free.iter_mut().zip(&units).for_each(|(f, u)| *f += u);
            let on = |x: &[f64], count: usize| {
                let rows: Vec<f64> = momenta.iter().flat_map(|m| products(m, x, count)).collect();
                DMatrix::from_row_slice(size, count, &rows)
            };
            let moved = on(&free, size).lu().solve(&on(&z, count))?;
            for (z, free) in z.chunks_exact_mut(count).zip(free.chunks_exact(size)) {
                free.iter()
                    .enumerate()
                    .for_each(|(k, f)| z.iter_mut().enumerate().for_each(|(j, z)| *z -= f * moved[(k, j)]));
            }
        }
        // At a double λ the matrix is singular still, and the struck row is not satisfied by itself.
        let sizes: Vec<f64> = shifted.iter().map(|v| v.abs()).collect();
        let terms = times(envelope, &sizes, &z.iter().map(|v| v.abs()).collect::<Vec<_>>(), count);
        let size = largest(&terms) + largest(forces);
        // Written so that NaN is refused.
        (largest(&residual(&z)) <= RESIDUAL * size && size.is_finite()).then_some(z)
    }
}

/// vᵀ X, row by row.
fn products(v: &[f64], x: &[f64], count: usize) -> Vec<f64> {
    let mut out = vec![0.0; count];
    x.chunks_exact(count).zip(v).for_each(|(x, &v)| add(&mut out, v, x));
    out
}

/// X := X - v a, row by row.
fn take(x: &mut [f64], v: &[f64], a: &[f64]) {
    x.chunks_exact_mut(a.len()).zip(v).for_each(|(x, &v)| add(x, -v, a));
}

/// The largest absolute value, infinite if one is NaN.
fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |a, v| {
        if v.abs() <= a {
            a
        } else if v.is_nan() {
            f64::INFINITY
        } else {
            v.abs()
        }
    })
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// y := y + a x.
fn add(y: &mut [f64], a: f64, x: &[f64]) {
    y.iter_mut().zip(x).for_each(|(y, x)| *y += a * x);
}

/// A X, row by row.
fn times(envelope: &Envelope, a: &[f64], x: &[f64], count: usize) -> Vec<f64> {
    let mut out = vec![0.0; x.len()];
    for i in 0..envelope.rows() {
        let first = envelope.first[i];
        let (diagonal, row) = a[envelope.row(i)].split_last().unwrap_or((&0.0, &[]));
        let own = &x[i * count..][..count];
        let (above, rest) = out.split_at_mut(i * count);
        let sum = &mut rest[..count];
        add(sum, *diagonal, own);
        for ((&v, x), out) in
            row.iter().zip(x[first * count..].chunks_exact(count)).zip(above[first * count..].chunks_exact_mut(count))
        {
            add(sum, v, x);
            add(out, v, own);
        }
    }
    out
}

/// A = L D Lᵀ in place: L below the diagonal, 1/D on it.
fn factor_in_place(envelope: &Envelope, a: &mut [f64]) {
    for i in 0..envelope.rows() {
        let first = envelope.first[i];
        let (above, row) = a.split_at_mut(envelope.start[i]);
        // Row i of L D, left to right; then of L.
        for j in first + 1..i {
            let begin = envelope.first[j].max(first);
            let other = &above[envelope.at(j, begin)..];
            row[j - first] -= dot(&row[begin - first..j - first], &other[..j - begin]);
        }
        let mut pivot = row[i - first];
        for j in first..i {
            let scaled = row[j - first] * above[envelope.at(j, j)];
            pivot -= scaled * row[j - first];
            row[j - first] = scaled;
        }
        row[i - first] = 1.0 / pivot;
    }
}

/// X := A⁻¹ X by the factors of A, row by row.
fn solve(envelope: &Envelope, factor: &[f64], x: &mut [f64], count: usize) {
    let n = envelope.rows();
    let rows = |i: usize| (envelope.first[i], factor[envelope.row(i)].split_last().unwrap_or((&1.0, &[])));
    for i in 0..n {
        let (first, (_, row)) = rows(i);
        let (above, own) = x.split_at_mut(i * count);
        for (l, x) in row.iter().zip(above[first * count..].chunks_exact(count)) {
            add(&mut own[..count], -l, x);
        }
    }
    for i in 0..n {
        let (_, (inverse, _)) = rows(i);
        x[i * count..][..count].iter_mut().for_each(|x| *x *= inverse);
    }
    for i in (0..n).rev() {
        let (first, (_, row)) = rows(i);
        let (above, own) = x.split_at_mut(i * count);
        for (l, x) in row.iter().zip(above[first * count..].chunks_exact_mut(count)) {
            add(x, -l, &own[..count]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lowest_modes;
    use proptest::prelude::*;

    /// A free chain of masses whose springs are parameters, with a brace between its ends.
    fn chain(n: usize) -> AffinePencil {
        let mut stiffness = Vec::new();
        let mut spring = |a: usize, b: usize, parameter: Option<usize>, coefficient: f64| {
            let mut add = |row: usize, col: usize, coefficient| {
                stiffness.push(AffineEntry { row, col, parameter, coefficient });
            };
            add(a, a, coefficient);
            add(b, b, coefficient);
            add(a.max(b), a.min(b), -coefficient);
        };
        (1..n).for_each(|i| spring(i - 1, i, Some(i % 3), 1.0));
        spring(0, n - 1, None, 0.3);
        let entry = |i: usize| AffineEntry { row: i, col: i, parameter: Some(3 + i % 2), coefficient: 1.0 };
        AffinePencil { n, n_parameters: 5, stiffness, mass: (0..n).map(entry).collect() }
    }

    proptest! {
        /// Along two directions, beside central differences of modes found by the dense path.
        #[test]
        fn derivatives_are_those_of_differences(
            n in 5_usize..24,
            theta in prop::collection::vec(0.5..2.0, 5),
            along in prop::collection::vec(-1.0..1.0, 10),
        ) {
            let pencil = chain(n);
            let directions = DMatrix::from_column_slice(5, 2, &along);
            let modes = |theta: &[f64]| {
                let (k, m) = pencil.assemble(theta);
                lowest_modes(&k, &m, 4, 0.1).unwrap()
            };
            let here = modes(&theta);
            let at = PencilSlopes::new(&pencil);
            let at = at.at(&theta);
            for mode in 1..4 {
                // Of nearly double modes differences of this step know nothing.
                let gap = (0..4).filter(|&k| k != mode).map(|k| (here.values[k] - here.values[mode]).abs()).fold(f64::INFINITY, f64::min);
                if gap < 0.02 * here.values[mode] || mode == 3 {
                    continue;
                }
                let phi = here.vectors.column(mode).into_owned();
                let (lambda, shapes) = at.mode(here.values[mode], &[phi.as_slice()], &directions).unwrap();
                for j in 0..2 {
                    let moved = |h: f64| {
                        let theta: Vec<f64> = (0..5).map(|p| theta[p] + h * directions[(p, j)]).collect();
                        let found = modes(&theta);
                        let own = found.vectors.column(mode).into_owned();
                        (found.values[mode], if own.dot(&phi) < 0.0 { -own } else { own })
                    };
                    let h = 1e-5;
                    let (above, below) = (moved(h), moved(-h));
                    let slope = (above.0 - below.0) / (2.0 * h);
                    let shape = (above.1 - below.1) / (2.0 * h);
                    prop_assert!((slope - lambda[j]).abs() < 1e-6 * here.values[mode].max(1.0));
                    prop_assert!((shape - shapes.column(j)).amax() < 1e-4 * (1.0 + shapes.amax()));
                }
            }
        }
    }

    /// Two like chains side by side, coupled by a parameter: beside the sum over all modes that are not of the pair, in any basis of its space.
    #[test]
    fn of_close_modes_the_part_across_them_is_found() {
        for apart in [0.0, 1e-9, 1e-3] {
            let one = chain(6);
            let beside = |e: &AffineEntry, factor: f64| AffineEntry {
                row: e.row + 6,
                col: e.col + 6,
                coefficient: e.coefficient * factor,
                ..*e
            };
            let both = |of: &[AffineEntry], factor: f64| -> Vec<AffineEntry> {
                of.iter().copied().chain(of.iter().map(|e| beside(e, factor))).collect()
            };
            let mut pencil = AffinePencil {
                n: 12,
                n_parameters: 6,
                stiffness: both(&one.stiffness, 1.0 + apart),
                mass: both(&one.mass, 1.0),
            };
            pencil.stiffness.push(AffineEntry { row: 8, col: 1, parameter: Some(5), coefficient: 0.7 });
            let theta = [0.8, 1.3, 1.0, 1.1, 0.7, 0.0];
            let directions =
                DMatrix::from_column_slice(6, 2, &[0.3, -0.2, 0.5, 0.1, 0.4, 1.0, 0.0, 0.6, 0.0, -0.5, 0.2, 0.3]);
            let (k, m) = pencil.assemble(&theta);
            let all = lowest_modes(&k, &m, 12, 0.1).unwrap();
            // The first pair of elastic modes, turned.
            let (s, c) = 0.6_f64.sin_cos();
            let pair = all.vectors.columns(2, 2) * DMatrix::from_row_slice(2, 2, &[c, -s, s, c]);
            let (phi, other) = (pair.column(0).into_owned(), pair.column(1).into_owned());
            let lambda = all.values[2];
            let slopes = PencilSlopes::new(&pencil);
            let (d_lambda, d_phi) =
                slopes.at(&theta).mode(lambda, &[phi.as_slice(), other.as_slice()], &directions).unwrap();
            for j in 0..2 {
                let moved: Vec<f64> = (0..6).map(|p| theta[p] + directions[(p, j)]).collect();
                let (k1, m1) = pencil.assemble(&moved);
                let (dk, dm) = (k1 - &k, m1 - &m);
                let force = &dk * &phi - &dm * &phi * lambda;
                assert!((d_lambda[j] - phi.dot(&force)).abs() < 1e-12);
                let mut sum = &phi * (-0.5 * phi.dot(&(&dm * &phi)));
                for i in (0..12).filter(|i| ![2, 3].contains(i)) {
                    let x = all.vectors.column(i);
                    sum -= x * (x.dot(&force) / (all.values[i] - lambda));
                }
                let error = (&sum - d_phi.column(j)).amax();
                assert!(error < 1e-9 * sum.amax(), "{apart}: {error:.1e}");
            }
        }
    }

    #[test]
    fn a_double_mode_has_none() {
        let entry = |i: usize, parameter| AffineEntry { row: i, col: i, parameter, coefficient: 1.0 };
        // Two equal oscillators, coupled by the parameter.
        let coupling = AffineEntry { row: 1, col: 0, parameter: Some(0), coefficient: 1.0 };
        let pencil = AffinePencil {
            n: 2,
            n_parameters: 1,
            stiffness: vec![entry(0, None), entry(1, None), coupling],
            mass: vec![entry(0, None), entry(1, None)],
        };
        let slopes = PencilSlopes::new(&pencil);
        assert!(slopes.at(&[0.0]).mode(1.0, &[&[1.0, 0.0]], &DMatrix::identity(1, 1)).is_none());
    }
}
