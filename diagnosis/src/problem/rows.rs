//! The rows of the least-squares problem of a scene, and their derivatives.

use super::prior::Prior;
use super::scene::Scene;
use super::work::Counters;
use retune::linalg::{DMatrix, DVector};
use retune::model::{ParametricModel, Targets};
use retune::objective::residual::{
    Damping, Frequency, FrfLog, MassPropertyResidual, Shape, ShapeComponents, StaticAngle, StaticDeflection,
    TargetResidual,
};
use retune::objective::{
    BatchPath, Comparison, EvalError, LeastSquares, Linearization, Objective, Prediction, Residual, Scaling,
};
use std::sync::Arc;

/// The rows of the problem.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rows {
    pub(crate) n_modes: usize,
    pub(crate) n_sensors: usize,
    /// Rows of measured data; targets and priors follow.
    pub(crate) measured: usize,
    pub(crate) targets: usize,
    pub(crate) priors: usize,
    pub(crate) has_shapes: bool,
}

impl Rows {
    pub(crate) fn len(self) -> usize {
        self.measured + self.targets + self.priors
    }

    /// Row of a shape entry.
    pub(crate) fn shape(self, mode: usize, sensor: usize) -> usize {
        self.n_modes + mode * self.n_sensors + sensor
    }
}

/// The objective Φ.
#[derive(Debug)]
pub(crate) struct Posed<'a> {
    pub(crate) parts: Vec<Part<'a>>,
    priors: Vec<Prior>,
    pub(crate) weight: f64,
    pub(crate) rows: Rows,
    pub(crate) statics: Vec<StaticRow>,
    work: &'a Counters,
}

/// The row of a static reading.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct StaticRow {
    pub(crate) row: usize,
    /// `static deflection at tip in bending`, of several tests with the name of its own.
    pub(crate) name: String,
}

/// The rows of one test.
#[derive(Debug)]
pub(crate) struct Part<'a> {
    pub(crate) comparison: &'a Comparison<'a>,
    data: LeastSquares<'a>,
    /// The same by the batched kernel, where a fit goes through it, with the weight of its measured rows.
    fast: Option<LeastSquares<'a>>,
    /// Where each of its rows stands among all.
    rows: Vec<usize>,
    pub(crate) first_mode: usize,
    pub(crate) sensors: &'a [usize],
}

impl<'a> Posed<'a> {
    /// Frequencies of all tests, shapes where a test has them, mass properties, static deflections and angles, amplitudes of
    /// frequency responses where the test says that a fit uses them, and damping ratios if the model is damped; then targets
    /// and priors.
    pub(crate) fn new(scene: &'a Scene, comparisons: &'a [Comparison<'a>], priors: Vec<Prior>, weight: f64) -> Self {
        let (n_modes, n_sensors) = (scene.test.modes.len(), scene.test.sensors.len());
        let has_shapes = comparisons.iter().any(Comparison::has_shapes);
        let mut measured = n_modes + if has_shapes { n_modes * n_sensors } else { 0 };
        // Targets belong to the parameters and not to a test: they count once.
        let owner = scene.cases.iter().position(|c| c.model.targets() != Targets::default());
        let mut targets = 0;
        let mut parts = Vec::with_capacity(comparisons.len());
        let mut statics = Vec::new();
        for (k, (comparison, case)) in comparisons.iter().zip(&scene.cases).enumerate() {
            let own_shapes = comparison.has_shapes();
            let mut terms: Vec<&dyn Residual> = vec![&Frequency];
            if own_shapes {
                terms.push(&Shape);
            }
            let mut further: Vec<&dyn Residual> =
                vec![&MassPropertyResidual, &StaticDeflection, &StaticAngle, &FrfLog, &ShapeComponents];
            if scene.is_damped {
                further.push(&Damping);
            }
            let mut first = measured + MassPropertyResidual.len(comparison);
            for term in [&StaticDeflection as &dyn Residual, &StaticAngle] {
                let of = if comparisons.len() > 1 { format!(" of {}", case.test.name) } else { String::new() };
                let own = (0..term.len(comparison))
                    .map(|i| StaticRow { row: first + i, name: term.row_name(comparison, i) + &of });
                statics.extend(own);
                first += term.len(comparison);
            }
            let n_further: usize = further.iter().map(|t| t.len(comparison)).sum();
            terms.extend(further);
            let mut rows: Vec<usize> = case.modes().collect();
            if own_shapes {
                let shape = |m: usize| case.sensors.iter().map(move |s| n_modes + m * n_sensors + s);
                rows.extend(case.modes().flat_map(shape));
            }
            rows.extend(measured..measured + n_further);
            measured += n_further;
            if owner == Some(k) {
                terms.push(&TargetResidual);
                targets = TargetResidual.len(comparison);
            }
            let data = LeastSquares::with_terms(comparison, terms);
            parts.push(Part {
                comparison,
                data,
                fast: None,
                rows,
                first_mode: case.first_mode,
                sensors: &case.sensors,
            });
        }
        if let Some(owner) = owner {
            parts[owner].rows.extend(measured..measured + targets);
        }
        let rows = Rows { n_modes, n_sensors, measured, targets, priors: priors.len(), has_shapes };
        Self { parts, priors, weight, rows, statics, work: &scene.work }
    }

    /// With costs and linearizations by the batched kernel where it takes the model: the same numbers but for rounding.
    ///
    /// * `kernels` - one a test
    pub(crate) fn through(mut self, kernels: &[Arc<BatchPath>]) -> Self {
        let square = self.weight * self.weight;
        let factor = |name: &str| Some(if name == TargetResidual.name() { 1.0 } else { square });
        for (part, kernel) in self.parts.iter_mut().zip(kernels) {
            let terms = part.data.terms().to_vec();
            let fast = LeastSquares::with_terms(part.comparison, terms).with_weights(factor);
            part.fast = Some(fast.through(kernel.clone()));
        }
        self
    }

    /// Residuals of all tests in the order of the rows.
    fn gather(
        &self,
        of: impl Fn(usize, &Part<'a>) -> Result<DVector<f64>, EvalError>,
    ) -> Result<DVector<f64>, EvalError> {
        let mut all = DVector::zeros(self.rows.measured + self.rows.targets);
        for (k, part) in self.parts.iter().enumerate() {
            let own = of(k, part)?;
            part.rows.iter().zip(own.iter()).for_each(|(&i, v)| all[i] = *v);
        }
        Ok(all)
    }

    pub(crate) fn scaling(&self) -> &Scaling {
        self.parts[0].data.scaling()
    }

    /// Whether costs go through the batched kernel.
    fn is_fast(&self) -> bool {
        self.parts.iter().all(|p| p.fast.is_some())
    }

    /// ½ Σ ρ² of the rows of the priors.
    fn cost_of_priors(&self, x: &DVector<f64>) -> f64 {
        0.5 * self.priors.iter().zip(x).map(|(prior, &x)| prior.row(x).0.powi(2)).sum::<f64>()
    }

    fn extend(&self, data: &DVector<f64>, x: &DVector<f64>) -> DVector<f64> {
        let n = data.len();
        DVector::from_fn(self.rows.len(), |i, _| {
            if i < self.rows.measured {
                data[i] * self.weight
            } else if i < n {
                data[i]
            } else {
                self.priors[i - n].row(x[i - n]).0
            }
        })
    }

    /// Weighted rows of data and targets at θ, priors zero.
    pub(crate) fn data_rows(&self, theta: &[f64]) -> Result<DVector<f64>, EvalError> {
        let predictions = self.parts.iter().map(|p| p.comparison.predict(theta)).collect::<Result<Vec<_>, _>>()?;
        self.rows_of(theta, &predictions)
    }

    /// The same of predictions that are known, one a test.
    pub(crate) fn rows_of(
        &self,
        theta: &[f64],
        predictions: &[impl std::ops::Deref<Target = Prediction>],
    ) -> Result<DVector<f64>, EvalError> {
        let own = |k: usize, p: &Part<'a>| Ok(p.data.residuals_of(theta, &predictions[k]));
        let mut r = self.gather(own)?.resize_vertically(self.rows.len(), 0.0);
        r.rows_mut(0, self.rows.measured).scale_mut(self.weight);
        if r.iter().all(|v| v.is_finite()) { Ok(r) } else { Err(EvalError::NotFinite { name: "data".into() }) }
    }
}

impl Objective for Posed<'_> {
    fn n_parameters(&self) -> usize {
        self.priors.len()
    }

    fn n_residuals(&self) -> usize {
        self.rows.len()
    }

    fn residuals(&self, x: &DVector<f64>) -> Result<DVector<f64>, EvalError> {
        self.work.evaluation();
        Ok(self.extend(&self.gather(|_, p| p.data.residuals(x))?, x))
    }

    fn linearize(&self, x: &DVector<f64>) -> Result<Linearization, EvalError> {
        self.work.linearization();
        let n = self.rows.measured + self.rows.targets;
        let mut residuals = DVector::zeros(self.rows.len());
        let mut jacobian = DMatrix::zeros(self.rows.len(), x.len());
        for part in &self.parts {
            let own = part.fast.as_ref().unwrap_or(&part.data).linearize(x)?;
            for (k, &i) in part.rows.iter().enumerate() {
                let weight = if part.fast.is_none() && i < self.rows.measured { self.weight } else { 1.0 };
                residuals[i] = own.residuals[k] * weight;
                jacobian.row_mut(i).iter_mut().zip(own.jacobian.row(k).iter()).for_each(|(j, v)| *j = v * weight);
            }
        }
        for (j, prior) in self.priors.iter().enumerate() {
            (residuals[n + j], jacobian[(n + j, j)]) = prior.row(x[j]);
        }
        Ok(Linearization { residuals, jacobian })
    }

    fn cost(&self, x: &DVector<f64>) -> Result<f64, EvalError> {
        if !self.is_fast() {
            return Ok(0.5 * self.residuals(x)?.norm_squared());
        }
        self.work.evaluation();
        let data =
            self.parts.iter().filter_map(|p| p.fast.as_ref()).map(|fast| fast.cost(x)).sum::<Result<f64, _>>()?;
        Ok(data + self.cost_of_priors(x))
    }

    fn costs(&self, points: &[DVector<f64>], out: &mut [f64]) {
        if !self.is_fast() {
            points.iter().zip(out).for_each(|(x, cost)| *cost = self.cost(x).unwrap_or(f64::INFINITY));
            return;
        }
        self.work.costs(points.len());
        out.iter_mut().zip(points).for_each(|(cost, x)| *cost = self.cost_of_priors(x));
        let mut own = vec![0.0; points.len()];
        for fast in self.parts.iter().filter_map(|p| p.fast.as_ref()) {
            fast.costs(points, &mut own);
            out.iter_mut().zip(&own).for_each(|(sum, c)| *sum += c);
        }
    }
}
