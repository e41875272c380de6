//! Weighted least squares: cost = ½ Σ r², a list of residual terms.

use super::batch::BatchPath;
use super::prediction::{Comparison, Prediction};
use super::residual::{Frequency, MassPropertyResidual, Point, Prior, RESIDUALS, Residual, Shape, TargetResidual};
use super::scaling::Scaling;
use super::{EvalError, Linearization, Objective, PathCounts, Walls};
use crate::linalg::{DMatrix, DVector};

/// Weighted least squares over a list of terms.
#[derive(Debug)]
pub struct LeastSquares<'a> {
    comparison: &'a Comparison<'a>,
    scaling: Scaling,
    terms: Vec<&'a dyn Residual>,
    batch: BatchPath,
}

impl<'a> LeastSquares<'a> {
    /// Frequencies, shapes where the test has them, measured mass properties, targets and priors.
    pub fn new(comparison: &'a Comparison<'a>) -> Self {
        let mut terms: Vec<&dyn Residual> = vec![&Frequency];
        if comparison.has_shapes() {
            terms.push(&Shape);
        }
        terms.extend([&MassPropertyResidual as &dyn Residual, &TargetResidual, &Prior]);
        Self::with_terms(comparison, terms)
    }

    /// With a list of terms of one's own.
    pub fn with_terms(comparison: &'a Comparison<'a>, terms: Vec<&'a dyn Residual>) -> Self {
        Self { comparison, scaling: Scaling::new(comparison.model()), terms, batch: BatchPath::default() }
    }

    /// The terms of their names; `None` for an unknown one.
    pub fn from_names(comparison: &'a Comparison<'a>, names: &[&str]) -> Option<Self> {
        let terms: Option<Vec<&dyn Residual>> =
            names.iter().map(|n| RESIDUALS.iter().copied().find(|r| r.name() == *n)).collect();
        Some(Self::with_terms(comparison, terms?))
    }

    /// The map between x and θ.
    pub fn scaling(&self) -> &Scaling {
        &self.scaling
    }

    /// Its terms.
    pub fn terms(&self) -> &[&'a dyn Residual] {
        &self.terms
    }

    /// Residuals of a prediction that is already known.
    pub fn residuals_of(&self, theta: &[f64], prediction: &Prediction) -> DVector<f64> {
        let mut r = DVector::zeros(self.n_residuals());
        self.fill(theta, prediction, &mut r);
        r
    }

    fn fill(&self, theta: &[f64], prediction: &Prediction, r: &mut DVector<f64>) {
        let point = Point { comparison: self.comparison, scaling: &self.scaling, theta, prediction };
        let mut start = 0;
        for term in &self.terms {
            let len = term.len(self.comparison);
            term.evaluate(&point, &mut r.as_mut_slice()[start..start + len]);
            start += len;
        }
    }

    fn finite(&self, r: &DVector<f64>) -> Result<(), EvalError> {
        let Some(bad) = r.iter().position(|v| !v.is_finite()) else { return Ok(()) };
        let mut start = 0;
        for term in &self.terms {
            let len = term.len(self.comparison);
            if bad < start + len {
                return Err(EvalError::NotFinite { name: term.row_name(self.comparison, bad - start) });
            }
            start += len;
        }
        Ok(())
    }
}

impl Objective for LeastSquares<'_> {
    fn n_parameters(&self) -> usize {
        self.scaling.len()
    }

    fn n_residuals(&self) -> usize {
        self.terms.iter().map(|t| t.len(self.comparison)).sum()
    }

    fn residuals(&self, x: &DVector<f64>) -> Result<DVector<f64>, EvalError> {
        let theta = self.scaling.theta(x);
        let prediction = self.comparison.predict(&theta)?;
        let r = self.residuals_of(&theta, &prediction);
        self.finite(&r)?;
        Ok(r)
    }

    fn linearize(&self, x: &DVector<f64>) -> Result<Linearization, EvalError> {
        let theta = self.scaling.theta(x);
        let prediction = self.comparison.predict(&theta)?;
        let derivative = self.comparison.differentiate(&theta, &prediction, self.scaling.free())?;
        let point =
            Point { comparison: self.comparison, scaling: &self.scaling, theta: &theta, prediction: &prediction };
        let residuals = self.residuals_of(&theta, &prediction);
        self.finite(&residuals)?;
        let n = self.scaling.len();
        let mut jacobian = DMatrix::zeros(residuals.len(), n);
        let mut start = 0;
        for term in &self.terms {
            let len = term.len(self.comparison);
            let mut block = DMatrix::zeros(len, n);
            term.differentiate(&point, &derivative, &mut block);
            jacobian.rows_mut(start, len).copy_from(&block);
            start += len;
        }
        for (mut column, width) in jacobian.column_iter_mut().zip(self.scaling.width()) {
            column *= *width;
        }
        Ok(Linearization { residuals, jacobian })
    }

    fn walls(&self) -> Walls {
        let mut start = 0;
        for term in &self.terms {
            let len = term.len(self.comparison);
            if term.is_wall() {
                return Walls { rows: start..start + len, slope: None };
            }
            start += len;
        }
        Walls::default()
    }

    fn costs(&self, points: &[DVector<f64>], out: &mut [f64]) {
        let reference = |x: &DVector<f64>| self.cost(x).unwrap_or(f64::INFINITY);
        if self.terms.iter().any(|t| t.needs_system()) {
            assert_eq!(points.len(), out.len(), "one cost a point");
            points.iter().zip(out).for_each(|(x, cost)| *cost = reference(x));
            return;
        }
        let n_residuals = self.n_residuals();
        let cost_of = |p: &Prediction, theta: &[f64], r: &mut DVector<f64>| {
            if r.len() != n_residuals {
                *r = DVector::zeros(n_residuals);
            }
            self.fill(theta, p, r);
            0.5 * r.norm_squared()
        };
        self.batch.costs((self.comparison, &self.scaling), points, out, &cost_of, reference);
    }

    fn confirm(&self, x: &DVector<f64>, cost: f64) -> f64 {
        self.batch.confirm(cost, || self.cost(x).unwrap_or(f64::INFINITY))
    }

    fn path_counts(&self) -> PathCounts {
        self.batch.counts()
    }
}
