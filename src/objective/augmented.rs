//! An objective with terms on the parameters themselves: a pull towards a point, walls of linear inequalities.

use super::{EvalError, Linearization, Objective, PathCounts, Walls};
use crate::linalg::{DMatrix, DVector};
use std::fmt;

/// A linear inequality of the parameters, scaled so that the expression spans one over the box.
///
/// ```text
/// slope · u <= limit,   u = (θ - lower)/(upper - lower):  u = x,  u = (e^(dx) - 1)/(e^d - 1) in the logarithm, d = ln(upper/lower)
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Wall {
    /// Coefficients of u.
    pub slope: DVector<f64>,
    /// The largest value.
    pub limit: f64,
    /// [`Scaling::decades`](super::Scaling::decades) of x.
    pub decades: Vec<Option<f64>>,
}

impl Wall {
    /// t = (slope · u - limit)/0.001.
    fn excess(&self, x: &DVector<f64>) -> f64 {
        let share = |(&x, decades): (&f64, &Option<f64>)| decades.map_or(x, |d| (x * d).exp_m1() / d.exp_m1());
        let u = DVector::from_iterator(x.len(), x.iter().zip(&self.decades).map(share));
        (self.slope.dot(&u) - self.limit) / WIDTH
    }

    /// ∂t/∂x.
    fn gradient(&self, x: &DVector<f64>) -> DVector<f64> {
        let slope = |k: usize| self.decades[k].map_or(1.0, |d| d * (x[k] * d).exp() / d.exp_m1());
        DVector::from_fn(x.len(), |k, _| self.slope[k] * slope(k) / WIDTH)
    }
}

/// An objective with a pull towards x0 of a given weight, and walls.
///
/// ```text
/// r = [ r_inner;  √w (x - x0);  ln(1 + exp((a·x - b)/0.001)) ]
/// cost = cost_inner + w/2 |x - x0|² + ½ Σ wall²
/// ```
///
/// A wall costs nothing a hundredth of its span inside, and half a standard deviation and more on its edge: a soft limit,
/// as the targets of mass properties have.
pub struct Augmented<'a> {
    inner: &'a dyn Objective,
    weight: f64,
    centre: DVector<f64>,
    walls: Vec<Wall>,
}

impl fmt::Debug for Augmented<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Augmented").field("weight", &self.weight).field("walls", &self.walls).finish_non_exhaustive()
    }
}

/// Width of a wall, as a share of the span of its expression.
const WIDTH: f64 = 1e-3;

impl<'a> Augmented<'a> {
    /// `inner` with a pull of `weight` towards `centre`, (n), and walls.
    pub fn new(inner: &'a dyn Objective, weight: f64, centre: DVector<f64>, walls: Vec<Wall>) -> Self {
        Self { inner, weight, centre, walls }
    }

    fn n_ridge(&self) -> usize {
        if self.weight > 0.0 { self.centre.len() } else { 0 }
    }

    fn rows(&self, x: &DVector<f64>) -> DVector<f64> {
        let ridge = (0..self.n_ridge()).map(|j| self.weight.sqrt() * (x[j] - self.centre[j]));
        let walls = self.walls.iter().map(|w| {
            let t = w.excess(x);
            t.max(0.0) + (-t.abs()).exp().ln_1p()
        });
        DVector::from_iterator(self.n_ridge() + self.walls.len(), ridge.chain(walls))
    }
}

impl Objective for Augmented<'_> {
    fn n_parameters(&self) -> usize {
        self.inner.n_parameters()
    }

    fn n_residuals(&self) -> usize {
        self.inner.n_residuals() + self.n_ridge() + self.walls.len()
    }

    fn residuals(&self, x: &DVector<f64>) -> Result<DVector<f64>, EvalError> {
        let inner = self.inner.residuals(x)?;
        let n = inner.len();
        let mut r = inner.resize_vertically(self.n_residuals(), 0.0);
        r.rows_mut(n, self.n_residuals() - n).copy_from(&self.rows(x));
        Ok(r)
    }

    fn linearize(&self, x: &DVector<f64>) -> Result<Linearization, EvalError> {
        let inner = self.inner.linearize(x)?;
        let (n, total) = (inner.residuals.len(), self.n_residuals());
        let mut residuals = inner.residuals.resize_vertically(total, 0.0);
        let mut jacobian: DMatrix<f64> = inner.jacobian.resize_vertically(total, 0.0);
        residuals.rows_mut(n, total - n).copy_from(&self.rows(x));
        for j in 0..self.n_ridge() {
            jacobian[(n + j, j)] = self.weight.sqrt();
        }
        for (k, w) in self.walls.iter().enumerate() {
            let slope = 1.0 / (1.0 + (-w.excess(x)).exp());
            jacobian.set_row(n + self.n_ridge() + k, &(w.gradient(x).transpose() * slope));
        }
        Ok(Linearization { residuals, jacobian })
    }

    fn cost(&self, x: &DVector<f64>) -> Result<f64, EvalError> {
        Ok(self.inner.cost(x)? + 0.5 * self.rows(x).norm_squared())
    }

    fn costs(&self, points: &[DVector<f64>], out: &mut [f64]) {
        self.inner.costs(points, out);
        if self.n_ridge() + self.walls.len() > 0 {
            out.iter_mut().zip(points).for_each(|(c, x)| *c += 0.5 * self.rows(x).norm_squared());
        }
    }

    fn confirm(&self, x: &DVector<f64>, cost: f64) -> f64 {
        if self.n_ridge() + self.walls.len() == 0 {
            return self.inner.confirm(x, cost);
        }
        let own = 0.5 * self.rows(x).norm_squared();
        let (inner, confirmed) = (cost - own, self.inner.confirm(x, cost - own));
        if confirmed.to_bits() == inner.to_bits() { cost } else { confirmed + own }
    }

    fn path_counts(&self) -> PathCounts {
        self.inner.path_counts()
    }

    fn walls(&self) -> Walls {
        let mut walls = self.inner.walls();
        let first = self.inner.n_residuals() + self.n_ridge();
        walls.extend(Walls::new(first..first + self.walls.len(), None));
        walls
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objective::difference;

    struct Nothing;

    impl Objective for Nothing {
        fn n_parameters(&self) -> usize {
            2
        }
        fn n_residuals(&self) -> usize {
            0
        }
        fn residuals(&self, _: &DVector<f64>) -> Result<DVector<f64>, EvalError> {
            Ok(DVector::zeros(0))
        }
    }

    #[test]
    fn rows_and_derivatives_agree_with_the_formula() {
        let wall = Wall { slope: DVector::from_vec(vec![0.5, 0.5]), limit: 0.6, decades: vec![None; 2] };
        let o = Augmented::new(&Nothing, 4.0, DVector::from_vec(vec![0.5, 0.25]), vec![wall]);
        for (x, wall) in [([0.6, 0.6], std::f64::consts::LN_2), ([0.5, 0.5], 0.0), ([0.7, 0.7], 100.0)] {
            let x = DVector::from_row_slice(&x);
            let l = o.linearize(&x).unwrap();
            assert!((l.residuals[0] - 2.0 * (x[0] - 0.5)).abs() < 1e-15);
            assert!((l.residuals[2] - wall).abs() < 1e-9, "{}", l.residuals[2]);
            let by_difference = difference(3, &x, |x| o.residuals(x)).unwrap().jacobian;
            assert!((&l.jacobian - by_difference).amax() < 1e-4 * l.jacobian.amax());
            assert!((o.cost(&x).unwrap() - 0.5 * l.residuals.norm_squared()).abs() < 1e-12);
        }
    }

    /// θ of 1 to 1e4 in the logarithm: 0.9 θ/9999 + 0.1 x2 <= 0.6 has its edge where θ says so.
    #[test]
    fn a_wall_is_straight_in_the_parameter_and_not_in_its_logarithm() {
        let wall =
            Wall { slope: DVector::from_vec(vec![0.9, 0.1]), limit: 0.6, decades: vec![Some(1e4_f64.ln()), None] };
        let o = Augmented::new(&Nothing, 0.0, DVector::zeros(2), vec![wall]);
        let edge = DVector::from_vec(vec![(1.0 + 9999.0 * 0.55 / 0.9_f64).ln() / 1e4_f64.ln(), 0.5]);
        let l = o.linearize(&edge).unwrap();
        assert!((l.residuals[0] - std::f64::consts::LN_2).abs() < 1e-9, "{}", l.residuals[0]);
        let by_difference = difference(1, &edge, |x| o.residuals(x)).unwrap().jacobian;
        assert!((&l.jacobian - by_difference).amax() < 1e-4 * l.jacobian.amax());
    }
}
