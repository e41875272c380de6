//! Problems with known minima.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::linalg::{DMatrix, DVector};
use crate::objective::{EvalError, Objective};

type Residuals = Box<dyn Fn(&DVector<f64>) -> DVector<f64> + Send + Sync>;

/// A sum of squares with a known minimum over the unit box.
pub(super) struct Problem {
    pub(super) name: &'static str,
    n: usize,
    m: usize,
    residuals: Residuals,
    pub(super) start: DVector<f64>,
    pub(super) minimum: f64,
    /// Costs asked for, single ones for differences of `linearize` not counted.
    pub(super) asked: AtomicU64,
}

impl Problem {
    fn new(
        name: &'static str,
        start: &[f64],
        minimum: f64,
        residuals: impl Fn(&DVector<f64>) -> DVector<f64> + Send + Sync + 'static,
    ) -> Self {
        let start = DVector::from_row_slice(start);
        let m = residuals(&start).len();
        Self { name, n: start.len(), m, residuals: Box::new(residuals), start, minimum, asked: AtomicU64::new(0) }
    }
}

impl Objective for Problem {
    fn n_parameters(&self) -> usize {
        self.n
    }

    fn n_residuals(&self) -> usize {
        self.m
    }

    fn residuals(&self, x: &DVector<f64>) -> Result<DVector<f64>, EvalError> {
        let r = (self.residuals)(x);
        if r.iter().all(|v| v.is_finite()) { Ok(r) } else { Err(EvalError::NotFinite { name: self.name.into() }) }
    }

    fn cost(&self, x: &DVector<f64>) -> Result<f64, EvalError> {
        self.asked.fetch_add(1, Ordering::Relaxed);
        Ok(0.5 * self.residuals(x)?.norm_squared())
    }
}

/// A fixed number in (-1, 1) that looks random.
pub(super) fn noise(i: usize) -> f64 {
    ((i as f64 * 12.9898).sin() * 43758.5453).fract()
}

fn random_matrix(n: usize, seed: usize) -> DMatrix<f64> {
    DMatrix::from_fn(n, n, |i, j| noise(seed + i * n + j) + f64::from(u8::from(i == j)) * 2.0)
}

/// r = (A (x - x*), 1): the minimum is ½ at x*.
pub(super) fn linear() -> Problem {
    let optimum = DVector::from_row_slice(&[0.3, 0.6, 0.45, 0.8]);
    let a = random_matrix(4, 10);
    Problem::new("linear least squares", &[0.9, 0.1, 0.9, 0.1], 0.5, move |x| (&a * (x - &optimum)).push(1.0))
}

/// r = (10 (v - u²), 1 - u), u and v = 4 x - 2: the minimum is 0 at u = v = 1.
pub(super) fn rosenbrock() -> Problem {
    Problem::new("Rosenbrock", &[0.2, 0.75], 0.0, |x| {
        let (u, v) = (4.0 * x[0] - 2.0, 4.0 * x[1] - 2.0);
        DVector::from_row_slice(&[10.0 * (v - u * u), 1.0 - u])
    })
}

/// r = A (x - x*) + s with Aᵀs = g, and g pointing outwards where x* lies on a bound: the minimum is ½ |s|² at x*.
pub(super) fn active_bounds() -> Problem {
    let optimum = DVector::from_row_slice(&[0.0, 0.4, 1.0, 0.7, 0.0]);
    let g = DVector::from_row_slice(&[0.5, 0.0, -0.3, 0.0, 0.2]);
    let a = random_matrix(5, 90);
    let s = a.transpose().lu().solve(&g).expect("regular");
    let minimum = 0.5 * s.norm_squared();
    Problem::new("active bounds", &[0.5; 5], minimum, move |x| &a * (x - &optimum) + &s)
}

/// Two parameters that act only by their sum, and one without influence: the minimum is ½ on a plane.
pub(super) fn rank_deficient() -> Problem {
    Problem::new("rank deficient", &[0.1, 0.9, 0.2, 0.5], 0.5, |x| {
        let sum = x[0] + x[1] - 0.8;
        DVector::from_row_slice(&[3.0 * sum + x[2] - 0.5, sum - 2.0 * (x[2] - 0.5), 1.0])
    })
}

/// Rosenbrock's problem with a region that cannot be evaluated between the start and the minimum.
pub(super) fn infeasible_region() -> Problem {
    Problem::new("infeasible region", &[0.35, 0.9], 0.0, |x| {
        let (u, v) = (4.0 * x[0] - 2.0, 4.0 * x[1] - 2.0);
        let hole = (u - 0.5).powi(2) + (v + 0.2).powi(2) < 0.1;
        DVector::from_row_slice(&[10.0 * (v - u * u), if hole { f64::NAN } else { 1.0 - u }])
    })
}

/// r = (u² - 1, (u - 1)/5, v, 0.3), u = 4 x - 2: the minimum at u = 1 is 0.045; another near u = -0.95 is higher.
pub(super) fn two_minima() -> Problem {
    Problem::new("two minima", &[0.2, 0.9], 0.045, |x| {
        let u = 4.0 * x[0] - 2.0;
        DVector::from_row_slice(&[u * u - 1.0, 0.2 * (u - 1.0), x[1] - 0.4, 0.3])
    })
}

pub(super) fn all() -> Vec<Problem> {
    vec![linear(), rosenbrock(), active_bounds(), rank_deficient(), infeasible_region(), two_minima()]
}

/// A cost that is not a sum of squares.
pub(super) struct Cost<F> {
    pub(super) n: usize,
    pub(super) cost: F,
}

impl<F: Fn(&DVector<f64>) -> f64 + Send + Sync> Objective for Cost<F> {
    fn n_parameters(&self) -> usize {
        self.n
    }

    fn n_residuals(&self) -> usize {
        0
    }

    fn residuals(&self, _x: &DVector<f64>) -> Result<DVector<f64>, EvalError> {
        Ok(DVector::zeros(0))
    }

    fn cost(&self, x: &DVector<f64>) -> Result<f64, EvalError> {
        Ok((self.cost)(x))
    }
}

/// A norm of correlated errors, squares, absolute values and a one-sided penalty, most bounds active: the shape of a cost
/// of frequencies, mode shapes and mass properties.
pub(super) fn kinked(n: usize) -> impl Objective {
    let a = DMatrix::from_fn(6, n, |i, j| noise(i * n + j) / (1.0 + i as f64));
    let b = DMatrix::from_fn(40, n, |i, j| 0.3 * noise(1000 + i * n + j));
    let c = DVector::from_fn(n, |j, _| 0.5 + noise(5000 + j));
    let cost = move |x: &DVector<f64>| {
        let d = x - &c;
        let squares = 0.5 * (&b * &d).norm_squared();
        (&a * &d).norm() + squares + 0.3 * (d.sum() - 0.4).abs() + 0.2 * (x[0] + 2.0 * x[1] - 1.3).max(0.0)
    };
    Cost { n, cost }
}
