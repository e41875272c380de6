//! Modes of a structure with dashpots, from those without.
//!
//! ```text
//! (s² I + s C + Λ) q = 0,   C = Φᵀ C Φ,   Λ = diag ω²,   ψ = Φ q,   q_i = 1 of mode i
//! f = |s|/2π,   ζ = -Re s/|s|
//! ```
//!
//! Damping that does not couple modes (Rayleigh's, a ratio for all) leaves them what they are. Dashpots at a few places couple them: frequencies and the
//! real part of the shapes, turned by the phase that makes them as real as can be, change with the square of the coupling, which two modes some tens
//! of per cent apart feel from a few per cent of damping on. Φ has the modes that a prediction has.
//!
//! The pair (s, q) is found by Newton's method from the undamped mode; its derivatives follow from the same bordered matrix,
//!
//! ```text
//! | T(s)  T'(s) q | | q' |     | -(s² M' + s C' + K') q |
//! | e_iᵀ     0    | | s' |  =  |           0            |,    T = s² I + s C + Λ,
//! ```
//!
//! with K', M' and C' on Φ, and in C' what the part of ∂φ_i that Φ lacks makes of ΦᵀCΦ; that of the other modes, times their share q_j, is left out.
//! What Φ lacks of a shape's derivative is that of the undamped one.
//!
//! # Source
//! S. Adhikari, Rates of change of eigenvalues and eigenvectors in damped dynamic system, AIAA Journal 37(11), 1999; M. I. Friswell, J. E. Mottershead,
//! Finite Element Model Updating in Structural Dynamics, 1995.

use super::real_shapes::phase;
use crate::linalg::{Complex, DMatrix, DVector};
use crate::modal::Modes;
use crate::model::Matrices;
use std::f64::consts::TAU;

/// Coupling q_j² below which a mode is what it is without dashpots: frequencies differ by about as much.
const COUPLED: f64 = 1e-8;
/// Newton's steps, at most, and their relative size at the end.
const STEPS: usize = 30;
const SMALL: f64 = 1e-13;
/// Two modes whose pairs agree so far have come to the same one.
const SAME: f64 = 1e-6;

/// The modes that dashpots couple.
#[derive(Debug, Clone)]
pub(crate) struct Damped {
    /// Modes without dashpots, rigid ones first, before any is turned to a test, (n_dof x n_modes), and their ω².
    shapes: DMatrix<f64>,
    lambda: Vec<f64>,
    /// CΦ and ΦᵀCΦ.
    c_shapes: DMatrix<f64>,
    damping: DMatrix<f64>,
    /// Of the modes that are coupled.
    pairs: Vec<Option<Pair>>,
    n_rigid: usize,
}

/// s and q.
#[derive(Debug, Clone)]
struct Pair {
    s: Complex<f64>,
    q: DVector<Complex<f64>>,
}

/// Derivatives of a coupled mode.
pub(super) struct DampedSlopes {
    /// ∂s/∂θ_j.
    s: Vec<Complex<f64>>,
    /// ∂q/∂θ_j less what it is of a mode of unit modal mass without dashpots, one column a parameter.
    beyond: DMatrix<Complex<f64>>,
    /// How ψ grows by itself, as φ_i keeps its unit modal mass and q_i its one at every θ.
    growth: Vec<Complex<f64>>,
}

impl Damped {
    /// `None` where there are no dashpots, or where they damp every mode by itself.
    pub(crate) fn new(matrices: &Matrices, modes: &Modes) -> Option<Self> {
        let c_shapes = matrices.damping_times(&modes.shapes)?;
        let damping = modes.shapes.tr_mul(&c_shapes);
        let lambda: Vec<f64> = modes.lambda.iter().copied().collect();
        let (shapes, pairs, n_rigid) = (DMatrix::zeros(0, 0), Vec::new(), modes.n_rigid);
        let mut damped = Self { shapes, lambda, c_shapes, damping, pairs, n_rigid };
        let count = damped.lambda.len();
        damped.pairs = (0..count).map(|mode| damped.pair(mode)).collect();
        // Where two have come to one, each stays what it is.
        let same = |a: &Pair, b: &Pair| (a.s - b.s).norm() < SAME * a.s.norm();
        let doubles: Vec<usize> = (0..count)
            .filter(|&i| {
                let of = |k: usize| damped.pairs[k].as_ref();
                of(i).is_some_and(|own| (0..count).any(|k| k != i && of(k).is_some_and(|other| same(own, other))))
            })
            .collect();
        for i in doubles {
            damped.pairs[i] = None;
        }
        if damped.pairs.iter().all(Option::is_none) {
            return None;
        }
        damped.shapes = modes.shapes.clone();
        Some(damped)
    }

    /// The pair of a mode, if others couple with it and it oscillates.
    fn pair(&self, mode: usize) -> Option<Pair> {
        let (lambda, n) = (self.lambda[mode], self.lambda.len());
        if mode < self.n_rigid || lambda <= 0.0 {
            return None;
        }
        let coupling = |j: usize| {
            let gap = self.lambda[j] - lambda;
            lambda * self.damping[(j, mode)].powi(2) / (gap * gap + lambda * self.damping[(mode, mode)].powi(2))
        };
        if (0..n).filter(|&j| j != mode).map(coupling).fold(0.0, f64::max) < COUPLED {
            return None;
        }
        let half = 0.5 * self.damping[(mode, mode)];
        if half * half >= lambda {
            return None;
        }
        let mut s = Complex::new(-half, (lambda - half * half).sqrt());
        let mut q = DVector::from_fn(n, |j, _| Complex::new(f64::from(u8::from(j == mode)), 0.0));
        for _ in 0..STEPS {
            let force = -(self.dynamic(s) * &q);
            let step = self.bordered(s, &q, mode).lu().solve(&force.insert_row(n, Complex::default()))?;
            q += step.rows(0, n);
            s += step[n];
            if step[n].norm() < SMALL * s.norm() && step.rows(0, n).norm() < SMALL * q.norm() {
                break;
            }
        }
        let left = (self.dynamic(s) * &q).norm();
        let oscillates = s.re.is_finite() && s.im > 0.0;
        // What belongs more to another mode has wandered.
        let is_own = q.iter().all(|v| v.norm() < 2.0);
        (oscillates && is_own && left < 1e-8 * s.norm_sqr() * q.norm()).then_some(Pair { s, q })
    }

    /// T(s).
    fn dynamic(&self, s: Complex<f64>) -> DMatrix<Complex<f64>> {
        let mut t = self.damping.map(|c| s * c);
        for (k, lambda) in self.lambda.iter().enumerate() {
            t[(k, k)] += s * s + lambda;
        }
        t
    }

    /// The matrix of Newton's steps and of derivatives.
    fn bordered(&self, s: Complex<f64>, q: &DVector<Complex<f64>>, mode: usize) -> DMatrix<Complex<f64>> {
        let n = q.len();
        let mut all = self.dynamic(s).resize(n + 1, n + 1, Complex::default());
        let slope = self.damping.map(|c| Complex::new(c, 0.0)) * q + q * (2.0 * s);
        all.view_mut((0, n), (n, 1)).copy_from(&slope);
        all[(n, mode)] = Complex::new(1.0, 0.0);
        all
    }

    /// Leaves elastic modes what they are without dashpots: those that are turned to a test.
    pub(super) fn leave(&mut self, clusters: &[Vec<usize>]) {
        for k in clusters.iter().flatten() {
            self.pairs[self.n_rigid + k] = None;
        }
    }

    /// Puts the coupled modes among frequencies, Hz, and shapes at the sensors, (n_sensors x n_elastic).
    pub(crate) fn put(&self, sensors: &DMatrix<f64>, frequencies_hz: &mut [f64], at_sensors: &mut DMatrix<f64>) {
        let read = self.read(sensors);
        for (k, hz) in frequencies_hz.iter_mut().enumerate() {
            let Some(pair) = self.of(k) else { continue };
            *hz = pair.s.norm() / TAU;
            let z = &read * &pair.q;
            let turn = phase(&z);
            at_sensors.set_column(k, &z.map(|v| (v * turn).re));
        }
    }

    fn of(&self, elastic: usize) -> Option<&Pair> {
        self.pairs.get(self.n_rigid + elastic)?.as_ref()
    }

    /// -Re s/|s| of an elastic mode; `None` where it is φᵀCφ/2ω.
    pub(crate) fn ratio(&self, elastic: usize) -> Option<f64> {
        let s = self.of(elastic)?.s;
        Some(-s.re / s.norm())
    }

    /// Sensors times Φ.
    fn read(&self, sensors: &DMatrix<f64>) -> DMatrix<Complex<f64>> {
        (sensors * &self.shapes).map(|v| Complex::new(v, 0.0))
    }

    /// Derivatives of a coupled elastic mode with respect to parameters.
    ///
    /// * `slopes` - ∂K, ∂M and ∂C of each
    /// * `undamped` - ∂φ of the mode without dashpots, (n_dof x parameters)
    pub(super) fn differentiate(
        &self,
        elastic: usize,
        slopes: &[Matrices],
        undamped: &DMatrix<f64>,
    ) -> Option<DampedSlopes> {
        let (mode, Pair { s, q }) = (self.n_rigid + elastic, self.of(elastic)?);
        let n = q.len();
        let lu = self.bordered(*s, q, mode).lu();
        let lambda = self.lambda[mode];
        let mut out = DampedSlopes { s: Vec::new(), beyond: DMatrix::zeros(n, slopes.len()), growth: Vec::new() };
        let motion = [q.map(|v| v.re), q.map(|v| v.im)].map(|part| &self.shapes * part);
        let motion = DMatrix::from_columns(&motion);
        let own = self.shapes.columns(mode, 1).into_owned();
        for (j, slope) in slopes.iter().enumerate() {
            let complex = |x: DMatrix<f64>| -> DVector<Complex<f64>> {
                let x = self.shapes.tr_mul(&x);
                DVector::from_fn(n, |i, _| Complex::new(x[(i, 0)], x[(i, 1)]))
            };
            let mut force = complex(slope.stiffness_times(&motion)) + complex(slope.mass_times(&motion)) * (s * s);
            if let Some(c) = slope.damping_times(&motion) {
                force += complex(c) * *s;
            }
            // Without dashpots: φ_kᵀ(K' - λ M')φ_i/(λ_i - λ_k), and -½ φ_iᵀM'φ_i of itself, where q keeps its one.
            let weighed = slope.mass_times(&own);
            let [strained, heavy] = [slope.stiffness_times(&own), weighed].map(|x| self.shapes.tr_mul(&x));
            let part = |k: usize, lambda: f64| strained[(k, 0)] - lambda * heavy[(k, 0)];
            let growth = -0.5 * heavy[(mode, 0)];
            let gap = |k: usize| lambda - self.lambda[k];
            let within = DVector::from_fn(n, |k, _| if k == mode { growth } else { part(k, lambda) / gap(k) });
            // What the slopes of the other modes have of φ_i.
            let of_others = |k: usize| q[k] * (-part(k, self.lambda[k]) / gap(k));
            let others: Complex<f64> = (0..n).filter(|&k| k != mode).map(of_others).sum();
            out.growth.push(others + growth);
            let lacked = undamped.column(j) - &self.shapes * &within;
            let w = self.c_shapes.tr_mul(&lacked);
            for k in 0..n {
                force[k] += *s * w[k];
                force[mode] += *s * q[k] * w[k];
            }
            let solved = lu.solve(&(-force).insert_row(n, Complex::default()))?;
            for k in 0..n {
                out.beyond[(k, j)] = solved[k] - within[k];
            }
            out.s.push(solved[n]);
        }
        Some(out)
    }

    /// ∂f/∂θ_j, Hz, and ∂(shape at sensors)/∂θ_j of a coupled elastic mode, (n_sensors x parameters).
    ///
    /// * `sensors` - the observation matrix
    /// * `slopes` - ∂K, ∂M and ∂C of each parameter
    /// * `shape` - ∂φ of the mode without dashpots, (n_dof x parameters)
    /// * `undamped` - the same at the sensors
    pub(super) fn beside(
        &self,
        elastic: usize,
        sensors: &DMatrix<f64>,
        slopes: &[Matrices],
        (shape, undamped): (&DMatrix<f64>, &DMatrix<f64>),
    ) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let slopes = self.differentiate(elastic, slopes, shape)?;
        let at_sensors = self.slopes_at_sensors(elastic, sensors, &slopes, undamped)?;
        Some((self.frequency_slopes(elastic, &slopes)?, at_sensors))
    }

    /// ∂f/∂θ_j of a coupled elastic mode, Hz.
    fn frequency_slopes(&self, elastic: usize, slopes: &DampedSlopes) -> Option<DVector<f64>> {
        let s = self.of(elastic)?.s;
        Some(DVector::from_fn(slopes.s.len(), |j, _| (s.conj() * slopes.s[j]).re / (s.norm() * TAU)))
    }

    /// ∂ζ/∂θ_j of a coupled elastic mode.
    pub(super) fn ratio_slopes(&self, elastic: usize, slopes: &DampedSlopes) -> Option<Vec<f64>> {
        let s = self.of(elastic)?.s;
        let slope = |d: &Complex<f64>| -d.re / s.norm() + s.re * (s.conj() * d).re / s.norm().powi(3);
        Some(slopes.s.iter().map(slope).collect())
    }

    /// Derivatives of its real shape at the sensors.
    fn slopes_at_sensors(
        &self,
        elastic: usize,
        sensors: &DMatrix<f64>,
        slopes: &DampedSlopes,
        undamped: &DMatrix<f64>,
    ) -> Option<DMatrix<f64>> {
        let read = self.read(sensors);
        let z = &read * &self.of(elastic)?.q;
        let turn = phase(&z);
        let square: Complex<f64> = z.iter().map(|v| v * v).sum();
        let mut all = &read * &slopes.beyond + undamped.map(|v| Complex::new(v, 0.0));
        all.column_iter_mut()
            .zip(&slopes.growth)
            .for_each(|(mut column, growth)| column.axpy(*growth, &z, Complex::new(1.0, 0.0)));
        let mut out = DMatrix::zeros(undamped.nrows(), undamped.ncols());
        for (j, column) in all.column_iter().enumerate() {
            // α = -½ arg Σ z²
            let along: Complex<f64> = z.iter().zip(column.iter()).map(|(z, d)| z * d * 2.0).sum();
            let angle = if square.norm() > 0.0 { -0.5 * (along / square).im } else { 0.0 };
            let turned = |(z, d): (&Complex<f64>, &Complex<f64>)| ((d + Complex::new(0.0, angle) * z) * turn).re;
            out.column_mut(j).iter_mut().zip(z.iter().zip(column.iter()).map(turned)).for_each(|(o, v)| *o = v);
        }
        Some(out)
    }
}
