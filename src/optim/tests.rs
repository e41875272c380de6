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

/// A norm of correlated errors plus absolute values, many bounds active: the shape of the flagship's cost.
fn kinked(n: usize) -> impl Objective {
    let a = DMatrix::from_fn(6, n, |i, j| ((i * n + j) as f64 * 1.37).sin() / (1.0 + i as f64));
    let b = DMatrix::from_fn(40, n, |i, j| 0.3 * ((i * n + j) as f64 * 0.73 + 1.0).cos() / (1.0 + 0.2 * i as f64));
    let c = DVector::from_fn(n, |j, _| 0.5 + 0.65 * (j as f64 * 2.1).sin());
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
        for seed in 0..3 {
            let mut run = Run::new(&f).seed(seed);
            let a = DifferentialEvolution::default().minimize(&start, &mut run).unwrap();
            let b = NelderMead { size: 0.01, ..Default::default() }.minimize(&a.x, &mut run).unwrap();
            let mut run = Run::new(&f).seed(seed);
            let c = NelderMead::default().minimize(&start, &mut run).unwrap();
            let de = DifferentialEvolution { strategy: Strategy::Classic, ..Default::default() }
                .minimize(&start, &mut run)
                .unwrap();
            let active = b.x.iter().filter(|v| **v == 0.0 || **v == 1.0).count();
            eprintln!(
                "n {n} de {:.12} {} {:?} nm {:.12} {} {:?} | nm alone {:.12} {} {:?} active {active} classic {:.6} {}",
                a.cost,
                a.evaluations,
                a.termination,
                b.cost,
                b.evaluations,
                b.termination,
                c.cost,
                c.evaluations,
                c.termination,
                de.cost,
                de.evaluations
            );
        }
    }
}
