//! Rows of the observation matrix where they depend on θ: sensors that a support moves that gives, on nodes that parameters move, and inside elements.

use super::Comparison;
use crate::correlation::observation_matrix_at;
use crate::data::{Place, Sensor};
use crate::linalg::DMatrix;
use crate::objective::EvalError;
use crate::objective::prediction::Prediction;
use std::borrow::Cow;

impl Comparison<'_> {
    /// The observation matrix at θ.
    pub(crate) fn sensors_at(&self, theta: &[f64]) -> Result<Cow<'_, DMatrix<f64>>, EvalError> {
        if self.varying.is_empty() {
            return Ok(Cow::Borrowed(&self.sensors));
        }
        let mut sensors = self.sensors.clone();
        let rows = self.rows_of(&self.varying, theta)?;
        self.varying.iter().zip(rows.row_iter()).for_each(|(&i, row)| sensors.set_row(i, &row));
        Ok(Cow::Owned(sensors))
    }

    /// The rows of some sensors at θ.
    fn rows_of(&self, sensors: &[usize], theta: &[f64]) -> Result<DMatrix<f64>, EvalError> {
        let sensors: Vec<Sensor> = sensors.iter().map(|&i| self.test.sensors[i].clone()).collect();
        let rows = observation_matrix_at(self.model, &sensors, theta);
        rows.map_err(|e| EvalError::Unsolvable { reason: e.to_string() })
    }

    /// The observation matrix of a prediction.
    pub(in crate::objective) fn sensors_of<'b>(&'b self, prediction: &'b Prediction) -> &'b DMatrix<f64> {
        prediction.sensors.as_ref().unwrap_or(&self.sensors)
    }

    /// Derivatives of the whole matrix, by differences; none where it does not depend on θ.
    pub(in crate::objective) fn slopes_of_sensors(
        &self,
        theta: &[f64],
        free: &[usize],
    ) -> Result<Vec<DMatrix<f64>>, EvalError> {
        if self.varying.is_empty() {
            return Ok(Vec::new());
        }
        let whole = |rows: DMatrix<f64>| {
            let mut all = DMatrix::zeros(self.sensors.nrows(), self.sensors.ncols());
            self.varying.iter().zip(rows.row_iter()).for_each(|(&i, row)| all.set_row(i, &row));
            all
        };
        Ok(self.slopes_of_rows(theta, free)?.into_iter().map(whole).collect())
    }

    /// Derivatives of the rows that depend on θ, by differences inside the bounds: smooth functions, and a step of 1e-6 of the interval.
    pub(super) fn slopes_of_rows(&self, theta: &[f64], free: &[usize]) -> Result<Vec<DMatrix<f64>>, EvalError> {
        let slope = |&j: &usize| {
            let nodes_move = self.model.has_nodes_moved_by(j);
            let is_moved = |&k: &usize| match &self.test.sensors[self.varying[k]].place {
                Place::Node { .. } => nodes_move,
                Place::Element { element, fraction, .. } => self.model.has_point_moved_by(element, *fraction, j),
            };
            let moved: Vec<usize> = (0..self.varying.len()).filter(is_moved).collect();
            let mut slopes = DMatrix::zeros(self.varying.len(), self.sensors.ncols());
            if moved.is_empty() {
                return Ok(slopes);
            }
            let p = self.model.parameters().get(j);
            let [lower, upper] = p.bounds.unwrap_or([theta[j] - p.value.abs(), theta[j] + p.value.abs()]);
            let step = 1e-6 * (upper - lower).max(f64::MIN_POSITIVE);
            let sensors: Vec<usize> = moved.iter().map(|&k| self.varying[k]).collect();
            let at = |value: f64| {
                let mut other = theta.to_vec();
                other[j] = value;
                self.rows_of(&sensors, &other)
            };
            let (below, above) = ((theta[j] - step).max(lower), (theta[j] + step).min(upper));
            let own = (at(above)? - at(below)?) / (above - below);
            moved.iter().zip(own.row_iter()).for_each(|(&k, row)| slopes.set_row(k, &row));
            Ok(slopes)
        };
        free.iter().map(slope).collect()
    }
}
