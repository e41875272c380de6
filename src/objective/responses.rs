//! Frequency responses of a model at the lines and channels of a test, directly from K, M and C.

use super::residual::Point;
use crate::correlation::{CorrelationError, observation_matrix};
use crate::data::{Channel, FrfFit, Place, Sensor, TestData};
use crate::linalg::{Complex, DMatrix};
use crate::model::ParametricModel;
use std::f64::consts::TAU;

/// The measured values that a fit uses, and the rows of their channels.
#[derive(Debug, Clone)]
pub(super) struct FrfRows {
    /// Rows of the responses, (n_responses x n_dof).
    responses: DMatrix<f64>,
    /// Rows of the references, (n_references x n_dof).
    references: DMatrix<f64>,
    /// Time derivatives from displacement.
    order: i32,
    /// Lines with values, Hz.
    lines_hz: Vec<f64>,
    /// For each value: line, reference, response, measured, its standard deviation.
    pub(super) values: Vec<FrfValue>,
    loss_factor: f64,
}

/// One measured value.
#[derive(Debug, Clone, Copy)]
pub(super) struct FrfValue {
    line: usize,
    reference: usize,
    response: usize,
    /// The measured value, SI.
    pub(super) measured: Complex<f64>,
    /// Standard deviation relative to the value.
    pub(super) relative_sd: f64,
    /// Standard deviation of real and imaginary part.
    pub(super) sd: f64,
}

/// Values below this share of the root mean square of their function get the standard deviation of that level: at an
/// antiresonance a relative one would ask for what no sensor delivers.
const FLOOR: f64 = 0.05;

/// The sensor of a channel: by name in the test, else on the node of that name along the channel's direction.
fn sensor(test: &TestData, channel: &Channel) -> Result<Sensor, CorrelationError> {
    if let Some(s) = test.sensors.iter().find(|s| s.name == channel.name) {
        return Ok(Sensor { direction: channel.direction.unwrap_or(s.direction), ..s.clone() });
    }
    let direction = channel.direction.ok_or_else(|| {
        CorrelationError::Model(format!(
            "the channel `{}` of the frequency response functions has no direction, and the test has no sensor of that name",
            channel.name
        ))
    })?;
    let place = Place::Node { node: channel.name.clone(), position: None };
    Ok(Sensor { name: channel.name.clone(), place, offset: None, direction, is_rotation: false, mass: None })
}

impl FrfRows {
    /// `None` where the test has no functions, or does not use them.
    pub(super) fn new(model: &dyn ParametricModel, test: &TestData) -> Result<Option<Self>, CorrelationError> {
        let (Some(set), Some(FrfFit { bands_hz, relative_sd, loss_factor, .. })) = (&test.frfs, &test.frf_fit) else {
            return Ok(None);
        };
        let rows = |channels: &[Channel]| {
            let sensors = channels.iter().map(|c| sensor(test, c)).collect::<Result<Vec<_>, _>>()?;
            observation_matrix(model, &sensors)
        };
        let is_used = |f: f64| f > 0.0 && (bands_hz.is_empty() || bands_hz.iter().any(|[l, h]| (*l..=*h).contains(&f)));
        let lines: Vec<usize> = (0..set.n_lines()).filter(|&l| is_used(set.frequencies_hz[l])).collect();
        if lines.is_empty() {
            return Err(CorrelationError::Model(
                "no line of the frequency response functions lies in `bands`".to_string(),
            ));
        }
        let mut values = Vec::new();
        for reference in 0..set.references.len() {
            for response in 0..set.responses.len() {
                let function: Vec<Complex<f64>> = lines.iter().map(|&l| set.at(l, reference, response)).collect();
                let known: Vec<f64> = function.iter().map(Complex::norm_sqr).filter(|v| v.is_finite()).collect();
                let level = (known.iter().sum::<f64>() / known.len().max(1) as f64).sqrt();
                for (line, measured) in function.into_iter().enumerate() {
                    let size = measured.norm();
                    if !(size.is_finite() && size > 0.0) {
                        continue;
                    }
                    let sd = relative_sd * size.max(FLOOR * level);
                    values.push(FrfValue { line, reference, response, measured, relative_sd: sd / size, sd });
                }
            }
        }
        Ok(Some(Self {
            responses: rows(&set.responses)?,
            references: rows(&set.references)?,
            order: set.quantity.order(),
            lines_hz: lines.iter().map(|&l| set.frequencies_hz[l]).collect(),
            values,
            loss_factor: *loss_factor,
        }))
    }

    /// "frf 12 -> p3 at 17.250 Hz" by index.
    pub(super) fn name(&self, test: &TestData, value: usize) -> String {
        let v = &self.values[value];
        let names = test.frfs.as_ref().map(|s| (&s.references[v.reference].name, &s.responses[v.response].name));
        let (from, to) = names.map_or(("", ""), |(a, b)| (a.as_str(), b.as_str()));
        format!("frf {from} -> {to} at {:.3} Hz", self.lines_hz[v.line])
    }

    /// The model's values, and, if `free` is given, ∂H/∂θ_j as one column for each.
    ///
    /// ```text
    /// Z = K (1 + i η) + i ω C - ω² M,   H = (iω)^p S Z⁻¹ B,   ∂H = -(iω)^p (S Z⁻¹) ∂Z (Z⁻¹ B)
    /// ```
    ///
    /// Exact for any damping; NaN where Z has no inverse.
    pub(super) fn evaluate(
        &self,
        at: &Point<'_>,
        free: Option<&[usize]>,
    ) -> (Vec<Complex<f64>>, DMatrix<Complex<f64>>) {
        let nan = Complex::new(f64::NAN, f64::NAN);
        let mut h = vec![nan; self.values.len()];
        let free = free.unwrap_or(&[]);
        let mut slopes = DMatrix::from_element(self.values.len(), free.len(), nan);
        // `Comparison::new` refuses a model without dense matrices.
        let Ok(system) = at.prediction.system() else { return (h, slopes) };
        let derivatives: Vec<_> =
            free.iter().map(|&j| at.comparison.model().assemble_derivative(at.theta, j).ok()).collect();
        let complex = |m: &DMatrix<f64>| m.map(|v| Complex::new(v, 0.0));
        let (references, responses) = (complex(&self.references.transpose()), complex(&self.responses.transpose()));
        let n = system.stiffness.nrows();
        for (line, f) in self.lines_hz.iter().enumerate() {
            let omega = TAU * f;
            let stiff = Complex::new(1.0, self.loss_factor);
            let dynamic = |k: &DMatrix<f64>, m: &DMatrix<f64>, c: Option<&DMatrix<f64>>| {
                DMatrix::from_fn(n, n, |i, j| {
                    stiff * k[(i, j)] - omega * omega * m[(i, j)]
                        + Complex::new(0.0, omega * c.map_or(0.0, |c| c[(i, j)]))
                })
            };
            let z = dynamic(&system.stiffness, &system.mass, system.damping.as_ref()).lu();
            // Z is symmetric: the same factorisation serves both sides.
            let (Some(x), Some(y)) = (z.solve(&references), z.solve(&responses)) else { continue };
            let power = Complex::new(0.0, omega).powi(self.order);
            let of_line: Vec<usize> = (0..self.values.len()).filter(|&v| self.values[v].line == line).collect();
            for &v in &of_line {
                let value = &self.values[v];
                h[v] = power * responses.column(value.response).dot(&x.column(value.reference));
            }
            for (j, d) in derivatives.iter().enumerate() {
                let Some(d) = d else { continue };
                let force = dynamic(&d.stiffness, &d.mass, d.damping.as_ref()) * &x;
                for &v in &of_line {
                    let value = &self.values[v];
                    slopes[(v, j)] = -power * y.column(value.response).dot(&force.column(value.reference));
                }
            }
        }
        (h, slopes)
    }
}
