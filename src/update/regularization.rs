//! The weight of a pull towards the estimates: given, by the evidence, or at the corner of the L-curve.

use super::{Regularization, UpdateError};
use crate::linalg::{DVector, thin_svd};
use crate::objective::{Augmented, Objective, Wall};
use crate::optim::{LevenbergMarquardt, Optimizer, Run};

/// The weight w of w/2 |x - x0|²; zero for none.
///
/// * `data` - the objective without it
/// * `centre` - x0
pub(super) fn weight(
    rule: Regularization,
    data: &dyn Objective,
    centre: &DVector<f64>,
    walls: &[Wall],
) -> Result<f64, UpdateError> {
    match rule {
        Regularization::None => Ok(0.0),
        Regularization::Weight(w) => Ok(w),
        Regularization::Evidence => by_evidence(data, centre, walls),
        Regularization::LCurve => at_corner(data, centre, walls),
    }
}

/// The minimum with a weight, from a start, by a local method.
fn fit(
    data: &dyn Objective,
    centre: &DVector<f64>,
    walls: &[Wall],
    weight: f64,
    start: &DVector<f64>,
) -> Result<DVector<f64>, UpdateError> {
    let objective = Augmented::new(data, weight, centre.clone(), walls.to_vec());
    Ok(LevenbergMarquardt::default().minimize(start, &mut Run::new(&objective))?.x)
}

/// Heaviest and lightest weight: a prior of a thirtieth of each interval, and one of a hundred intervals.
const RANGE: [f64; 2] = [1e-4, 1e3];

/// The weight that maximises the probability of the data, the parameters integrated out.
///
/// ```text
/// γ = Σ_k σ_k²/(σ_k² + w)      the number of combinations that the data determine, σ: singular values of J
/// w <- γ / |x - x0|²           repeated until it settles
/// ```
///
/// # Source
/// D. J. C. MacKay, Bayesian interpolation, Neural Computation 4, 1992.
fn by_evidence(data: &dyn Objective, centre: &DVector<f64>, walls: &[Wall]) -> Result<f64, UpdateError> {
    let mut weight = 1.0;
    let mut x = centre.clone();
    for _ in 0..20 {
        x = fit(data, centre, walls, weight, &x)?;
        let svd = thin_svd(&data.linearize(&x)?.jacobian).map_err(crate::correlation::CorrelationError::from)?;
        let determined: f64 = svd.values.iter().map(|s| s * s / (s * s + weight)).sum();
        let next = (determined / (&x - centre).norm_squared().max(1e-12)).clamp(RANGE[0], RANGE[1]);
        let change = (next / weight).ln().abs();
        weight = next;
        if change < 0.01 {
            break;
        }
    }
    Ok(weight)
}

/// The weight at the corner of the L-curve: the largest curvature of (ln |r|, ln |x - x0|) over a grid of weights.
///
/// # Source
/// P. C. Hansen, D. P. O'Leary, The use of the L-curve in the regularization of discrete ill-posed problems, SIAM Journal
/// on Scientific Computing 14, 1993.
fn at_corner(data: &dyn Objective, centre: &DVector<f64>, walls: &[Wall]) -> Result<f64, UpdateError> {
    const N: usize = 29;
    let step = (RANGE[1] / RANGE[0]).ln() / (N - 1) as f64;
    let weights: Vec<f64> = (0..N).map(|k| RANGE[1] * (-step * k as f64).exp()).collect();
    let mut x = centre.clone();
    let mut curve = Vec::with_capacity(N);
    for &weight in &weights {
        x = fit(data, centre, walls, weight, &x)?;
        let misfit = data.residuals(&x)?.norm().max(1e-150);
        curve.push((misfit.ln(), (&x - centre).norm().max(1e-150).ln()));
    }
    // Curvature (a'' b' - a' b'')/(a'² + b'²)^(3/2), clockwise from heavy to light weights, largest where the L bends.
    let curvature = |k: usize| {
        let first = |f: &dyn Fn(usize) -> f64| (f(k + 1) - f(k - 1)) / 2.0;
        let second = |f: &dyn Fn(usize) -> f64| f(k + 1) - 2.0 * f(k) + f(k - 1);
        let (misfit, size) = (|k: usize| curve[k].0, |k: usize| curve[k].1);
        let (a, b) = (first(&misfit), first(&size));
        let bend = second(&misfit) * b - a * second(&size);
        bend / (a * a + b * b).powf(1.5).max(1e-12)
    };
    let corner = (1..N - 1).max_by(|&a, &b| curvature(a).total_cmp(&curvature(b))).unwrap_or(N / 2);
    Ok(weights[corner])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::DMatrix;
    use crate::objective::EvalError;

    /// r = A x - b.
    struct Linear(DMatrix<f64>, DVector<f64>);

    impl Objective for Linear {
        fn n_parameters(&self) -> usize {
            self.0.ncols()
        }
        fn n_residuals(&self) -> usize {
            self.0.nrows()
        }
        fn residuals(&self, x: &DVector<f64>) -> Result<DVector<f64>, EvalError> {
            Ok(&self.0 * x - &self.1)
        }
    }

    /// Twelve combinations, six seen well and six drowned in noise, of parameters within about 0.1 of their estimates:
    /// the right weight is about 1/0.1², and a fit with it is nearer the truth than one without.
    #[test]
    fn both_rules_beat_no_regularisation_on_an_ill_posed_problem() {
        let noise = |i: usize| {
            let u = |k: usize| ((k as f64 * 12.9898 + 4.1).sin() * 43_758.545).fract().abs().max(1e-9);
            (-2.0 * u(2 * i).ln()).sqrt() * (std::f64::consts::TAU * u(2 * i + 1)).cos()
        };
        let n = 12;
        let centre = DVector::from_element(n, 0.5);
        let truth = DVector::from_fn(n, |j, _| 0.5 + 0.1 * noise(100 + j));
        let q = DMatrix::from_fn(n, n, |i, j| noise(1000 + 13 * i + 7 * j * j + j)).qr().q();
        let a = DMatrix::from_fn(n, n, |i, j| q[(i, j)] * if i < 6 { 200.0 } else { 0.5 });
        let b = &a * &truth + DVector::from_fn(n, |i, _| noise(500 + i));
        let data = Linear(a, b);
        let error = |w: f64| (fit(&data, &centre, &[], w, &centre).unwrap() - &truth).norm();
        let evidence = weight(Regularization::Evidence, &data, &centre, &[]).unwrap();
        let corner = weight(Regularization::LCurve, &data, &centre, &[]).unwrap();
        assert!((20.0..500.0).contains(&evidence), "{evidence}");
        for w in [evidence, corner] {
            assert!(error(w) < 0.5 * error(0.0), "weight {w}: {} against {}", error(w), error(0.0));
        }
    }
}
