//! Problems with known minima, for every method.

use super::*;
use crate::linalg::DMatrix;
use crate::objective::{EvalError, Objective};

/// A cost given as a function of x.
struct Cost<F>(usize, F);
impl<F: Fn(&DVector<f64>) -> f64 + Send + Sync> Objective for Cost<F> {
    fn n_parameters(&self) -> usize {
        self.0
    }
    fn n_residuals(&self) -> usize {
        1
    }
    fn residuals(&self, x: &DVector<f64>) -> Result<DVector<f64>, EvalError> {
        Ok(DVector::from_element(1, (2.0 * (self.1)(x)).sqrt()))
    }
    fn cost(&self, x: &DVector<f64>) -> Result<f64, EvalError> {
        Ok((self.1)(x))
    }
}

/// A fixed number in (-1, 1) that looks random.
fn noise(i: usize) -> f64 {
    ((i as f64 * 12.9898).sin() * 43758.5453).fract()
}

/// A norm of correlated errors plus absolute values, many bounds active: the shape of the flagship's cost.
fn kinked(n: usize) -> impl Objective {
    let a = DMatrix::from_fn(6, n, |i, j| noise(i * n + j) / (1.0 + i as f64));
    let b = DMatrix::from_fn(40, n, |i, j| 0.3 * noise(1000 + i * n + j));
    let c = DVector::from_fn(n, |j, _| 0.5 + noise(5000 + j));
    Cost(n, move |x: &DVector<f64>| {
        let d = x - &c;
        let e = &a * &d;
        let s = &b * &d;
        e.norm() + 0.5 * s.norm_squared() + 0.3 * (d.sum() - 0.4).abs() + 0.2 * (x[0] + 2.0 * x[1] - 1.3).max(0.0)
    })
}

#[test]
fn scratch() {
    for n in [4, 10, 20] {
        let f = kinked(n);
        let start = DVector::from_element(n, 0.5);
        for seed in 0..2 {
            for generations in [60, 120, 400] {
                let mut run = Run::new(&f).seed(seed);
                let a = DifferentialEvolution { generations: Some(generations), ..Default::default() }
                    .minimize(&start, &mut run)
                    .unwrap();
                let b = NelderMead { size: 0.01, ..Default::default() }.minimize(&a.x, &mut run).unwrap();
                let active = b.x.iter().filter(|v| **v == 0.0 || **v == 1.0).count();
                let h = |eps: f64| {
                    b.history
                        .iter()
                        .find(|h| {
                            h.cost
                                < [0.0, 0.628585232168, 0.66591479056, 0.8786811683]
                                    [[4, 10, 20].iter().position(|k| *k == n).unwrap() + 1]
                                    * (1.0 + eps)
                        })
                        .map(|h| h.evaluations - a.evaluations)
                };
                eprintln!(
                    "n {n} de {:.12} {} {:?} nm {:.12} {} {:?}| active {active} | {:?} {:?} {:?}",
                    a.cost,
                    a.evaluations,
                    a.termination,
                    b.cost,
                    b.evaluations,
                    b.termination,
                    h(1e-4),
                    h(1e-6),
                    h(1e-8)
                );
            }
        }
    }
}
