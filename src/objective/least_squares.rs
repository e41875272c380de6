//! Weighted least squares: cost = ½ Σ r², a list of residual terms.

use super::batch::BatchPath;
use super::comparison::Comparison;
use super::prediction::{Prediction, PredictionDerivative};
use super::residual::{
    Damping, Frequency, FrfLog, MassPropertyResidual, Point, Prior, RESIDUALS, Residual, Shape, ShapeComponents,
    StaticAngle, StaticDeflection, TargetResidual,
};
use super::scaling::Scaling;
use super::{EvalError, Linearization, Loss, Objective, PathCounts, Walls};
use crate::linalg::{DMatrix, DVector};
use std::sync::Arc;

/// Weighted least squares over a list of terms.
#[derive(Debug)]
pub struct LeastSquares<'a> {
    comparison: &'a Comparison<'a>,
    scaling: Scaling,
    terms: Vec<&'a dyn Residual>,
    /// Factor of the squared residuals of each term.
    weights: Vec<f64>,
    /// Of the terms that compare with data.
    loss: Loss,
    batch: Arc<BatchPath>,
}

impl<'a> LeastSquares<'a> {
    /// Frequencies, shapes where the test has them, measured mass properties, targets and priors; then components of shapes of
    /// known scale, damping ratios where model and test have them, static deflections and angles, and amplitudes of frequency responses where the test says how they
    /// enter a fit.
    pub fn new(comparison: &'a Comparison<'a>) -> Self {
        let mut terms: Vec<&dyn Residual> = vec![&Frequency];
        if comparison.has_shapes() {
            terms.push(&Shape);
        }
        terms.extend([&MassPropertyResidual as &dyn Residual, &TargetResidual, &Prior]);
        let further: [&dyn Residual; 5] = [&ShapeComponents, &Damping, &StaticDeflection, &StaticAngle, &FrfLog];
        terms.extend(further.into_iter().filter(|r| !r.is_empty(comparison)));
        Self::with_terms(comparison, terms)
    }

    /// With a list of terms of one's own.
    pub fn with_terms(comparison: &'a Comparison<'a>, terms: Vec<&'a dyn Residual>) -> Self {
        let weights = vec![1.0; terms.len()];
        let scaling = Scaling::new(comparison.model());
        Self { comparison, scaling, terms, weights, loss: Loss::Squares, batch: Arc::default() }
    }

    /// With another map between x and θ, such as that [of a search](Scaling::for_search).
    #[must_use]
    pub fn with_scaling(mut self, scaling: Scaling) -> Self {
        self.scaling = scaling;
        self
    }

    /// With a loss for the terms that compare with data; priors and targets keep their squares.
    #[must_use]
    pub fn with_loss(mut self, loss: Loss) -> Self {
        self.loss = loss;
        self
    }

    /// By a way to the batched kernel that others of the same model, test and scaling may share; where it [gives derivatives](BatchPath::with_derivatives),
    /// costs and linearizations of single points come from the kernel too, equal to those of the reference path but for rounding.
    #[must_use]
    pub fn through(mut self, batch: Arc<BatchPath>) -> Self {
        self.batch = batch;
        self
    }

    /// With factors of the terms' shares of the cost: 1 leaves a term as its standard deviations say. Terms that are not
    /// named keep theirs.
    #[must_use]
    pub fn with_weights(mut self, weight: impl Fn(&str) -> Option<f64>) -> Self {
        for (term, own) in self.terms.iter().zip(&mut self.weights) {
            *own = weight(term.name()).unwrap_or(*own);
        }
        self
    }

    /// With one more term.
    #[must_use]
    pub fn with_term(mut self, term: &'a dyn Residual) -> Self {
        self.terms.push(term);
        self.weights.push(1.0);
        self
    }

    /// Without the terms for which `is_out` holds.
    #[must_use]
    pub fn without(mut self, is_out: impl Fn(&dyn Residual) -> bool) -> Self {
        let kept: Vec<usize> = (0..self.terms.len()).filter(|&k| !is_out(self.terms[k])).collect();
        self.weights = kept.iter().map(|&k| self.weights[k]).collect();
        self.terms = kept.iter().map(|&k| self.terms[k]).collect();
        self
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

    /// Residuals of a prediction that is already known, before weights and loss.
    pub fn residuals_of(&self, theta: &[f64], prediction: &Prediction) -> DVector<f64> {
        let mut r = DVector::zeros(self.n_residuals());
        self.fill(theta, prediction, &mut r);
        r
    }

    /// Where the residuals of a term stand; nowhere if it is none of the terms.
    pub fn rows_of(&self, name: &str) -> std::ops::Range<usize> {
        let lengths = self.terms.iter().map(|t| t.len(self.comparison));
        let mut start = 0;
        for (term, len) in self.terms.iter().zip(lengths) {
            if term.name() == name {
                return start..start + len;
            }
            start += len;
        }
        0..0
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

    /// Applies weights and loss to residuals and, if given, to the rows of their Jacobian.
    fn weigh(&self, r: &mut DVector<f64>, mut jacobian: Option<&mut DMatrix<f64>>) {
        let mut row = 0;
        for (term, weight) in self.terms.iter().zip(&self.weights) {
            let loss = if term.is_data() { self.loss } else { Loss::Squares };
            for i in row..row + term.len(self.comparison) {
                let (s, slope) = loss.transform(r[i]);
                r[i] = weight.sqrt() * s;
                if let Some(j) = &mut jacobian {
                    j.row_mut(i).scale_mut(weight.sqrt() * slope);
                }
            }
            row += term.len(self.comparison);
        }
    }

    /// Residuals and Jacobian of a prediction and its derivatives, after weights and loss.
    fn linearization(
        &self,
        theta: &[f64],
        prediction: &Prediction,
        derivative: &PredictionDerivative,
    ) -> Result<Linearization, EvalError> {
        let point = Point { comparison: self.comparison, scaling: &self.scaling, theta, prediction };
        let mut residuals = self.residuals_of(theta, prediction);
        self.finite(&residuals)?;
        let n = self.scaling.len();
        let mut jacobian = DMatrix::zeros(residuals.len(), n);
        let mut start = 0;
        for term in &self.terms {
            let len = term.len(self.comparison);
            if len > 0 {
                let mut block = DMatrix::zeros(len, n);
                term.differentiate(&point, derivative, &mut block);
                jacobian.rows_mut(start, len).copy_from(&block);
            }
            start += len;
        }
        for (mut column, slope) in jacobian.column_iter_mut().zip(self.scaling.slopes(theta)) {
            column *= slope;
        }
        if !self.is_plain() {
            self.weigh(&mut residuals, Some(&mut jacobian));
        }
        Ok(Linearization { residuals, jacobian })
    }

    /// Whether any term looks at more than what a batch sees.
    fn needs_system(&self) -> bool {
        self.terms.iter().any(|t| t.needs_system() && !t.is_empty(self.comparison))
    }

    /// Whether single points go through the kernel.
    fn is_fast(&self) -> bool {
        self.batch.has_derivatives() && !self.needs_system()
    }

    fn reference_cost(&self, x: &DVector<f64>) -> Result<f64, EvalError> {
        Ok(0.5 * self.residuals(x)?.norm_squared())
    }

    fn is_plain(&self) -> bool {
        self.loss == Loss::Squares && self.weights.iter().all(|w| *w == 1.0)
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
        let mut r = self.residuals_of(&theta, &prediction);
        self.finite(&r)?;
        if !self.is_plain() {
            self.weigh(&mut r, None);
        }
        Ok(r)
    }

    fn linearize(&self, x: &DVector<f64>) -> Result<Linearization, EvalError> {
        if self.is_fast() {
            let of = |p: &Prediction, d: &PredictionDerivative, theta: &[f64]| self.linearization(theta, p, d).ok();
            if let Some(found) = self.batch.linearize((self.comparison, &self.scaling), x, &of).flatten() {
                return Ok(found);
            }
        }
        let theta = self.scaling.theta(x);
        let prediction = self.comparison.predict(&theta)?;
        let derivative = self.comparison.differentiate(&theta, &prediction, self.scaling.free())?;
        self.linearization(&theta, &prediction, &derivative)
    }

    fn cost(&self, x: &DVector<f64>) -> Result<f64, EvalError> {
        if self.is_fast() {
            let mut cost = [0.0];
            self.costs(std::slice::from_ref(x), &mut cost);
            if cost[0].is_finite() {
                return Ok(cost[0]);
            }
        }
        self.reference_cost(x)
    }

    fn walls(&self) -> Walls {
        let mut start = 0;
        let mut walls = Walls::default();
        for (term, weight) in self.terms.iter().zip(&self.weights) {
            let len = term.len(self.comparison);
            // A weighted wall is none that t could be read back from.
            if term.is_wall() && *weight == 1.0 {
                walls.extend(Walls::new(start..start + len, None));
            }
            start += len;
        }
        walls
    }

    fn costs(&self, points: &[DVector<f64>], out: &mut [f64]) {
        let reference = |x: &DVector<f64>| self.reference_cost(x).unwrap_or(f64::INFINITY);
        if self.needs_system() {
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
            if !self.is_plain() {
                self.weigh(r, None);
            }
            0.5 * r.norm_squared()
        };
        self.batch.costs(
            (self.comparison, &self.scaling),
            points,
            out,
            (self.terms.iter().any(|t| t.needs_shapes()), &cost_of),
            reference,
        );
    }

    fn confirm(&self, x: &DVector<f64>, cost: f64) -> f64 {
        self.batch.confirm(cost, || self.reference_cost(x).unwrap_or(f64::INFINITY))
    }

    fn path_counts(&self) -> PathCounts {
        self.batch.counts()
    }
}
