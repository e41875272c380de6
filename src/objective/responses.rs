//! Frequency responses of a model at the lines and channels of a test, directly from K, M and C.

use super::residual::Point;
use crate::correlation::{CorrelationError, fitted_channel, observation_matrix};
use crate::data::{Channel, FrfFit, TestData};
use crate::linalg::{Complex, DMatrix, DynamicStiffness, ShiftedPencil};
use crate::model::{ParametricModel, System};
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

impl FrfRows {
    /// `None` where the test has no functions, or does not use them.
    pub(super) fn new(model: &dyn ParametricModel, test: &TestData) -> Result<Option<Self>, CorrelationError> {
        let (Some(set), Some(fit)) = (&test.frfs, &test.frf_fit) else { return Ok(None) };
        let FrfFit { relative_sd, loss_factor, .. } = fit;
        let rows = |channels: &[Channel]| {
            let sensors = channels.iter().map(|c| fitted_channel(c, test)).collect::<Result<Vec<_>, _>>()?;
            observation_matrix(model, &sensors)
        };
        let lines: Vec<usize> = (0..set.n_lines()).filter(|&l| fit.uses(set.frequencies_hz[l])).collect();
        if lines.is_empty() {
            return Err(CorrelationError::Model(
                "no line of the frequency response functions lies in `bands`".to_string(),
            ));
        }
        let (responses, references) = (rows(&set.responses)?, rows(&set.references)?);
        // Where the model cannot move it has no amplitude to compare.
        let moving = |rows: &DMatrix<f64>| (0..rows.nrows()).filter(|&i| rows.row(i).amax() > 0.0).collect::<Vec<_>>();
        let (moving_responses, moving_references) = (moving(&responses), moving(&references));
        let mut values = Vec::new();
        for &reference in &moving_references {
            for &response in &moving_responses {
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
            responses,
            references,
            order: set.quantity.order(),
            lines_hz: lines.iter().map(|&l| set.frequencies_hz[l]).collect(),
            values,
            loss_factor: loss_factor.unwrap_or(0.0),
        }))
    }

    /// "frf 12 -> p3 at 17.250 Hz" by index.
    pub(super) fn name(&self, test: &TestData, value: usize) -> String {
        let v = &self.values[value];
        let names = test.frfs.as_ref().map(|s| (&s.references[v.reference].name, &s.responses[v.response].name));
        let (from, to) = names.map_or(("", ""), |(a, b)| (a.as_str(), b.as_str()));
        format!("frf {from} -> {to} at {:.3} Hz", self.lines_hz[v.line])
    }

    /// The model's values, found once for a prediction.
    pub(super) fn values_of<'p>(&self, at: &Point<'p>) -> &'p [Complex<f64>] {
        at.prediction.responses.get_or_init(|| self.evaluate(at, None).0)
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
        let derivatives: Vec<Option<Entries>> = free
            .iter()
            .map(|&j| at.comparison.model().assemble_derivative(at.theta, j).ok().map(|d| Entries::of(&d)))
            .collect();
        let Some(mut sweep) = self.sweep(&system, !free.is_empty()) else { return (h, slopes) };
        let mut of_line: Vec<Vec<usize>> = vec![Vec::new(); self.lines_hz.len()];
        self.values.iter().enumerate().for_each(|(v, value)| of_line[value.line].push(v));
        for (line, f) in self.lines_hz.iter().enumerate() {
            let omega = TAU * f;
            let power = Complex::new(0.0, omega).powi(self.order);
            let Some((x, y)) = sweep.line(omega, self.loss_factor) else { continue };
            for &v in &of_line[line] {
                let value = &self.values[v];
                let own = self.responses.row(value.response);
                let sum: Complex<f64> = own.iter().zip(x.column(value.reference).iter()).map(|(s, x)| x * *s).sum();
                h[v] = power * sum;
            }
            for (j, d) in derivatives.iter().enumerate() {
                let Some(d) = d else { continue };
                let force = d.times(&x, omega, self.loss_factor);
                for &v in &of_line[line] {
                    let value = &self.values[v];
                    slopes[(v, j)] = -power * y.column(value.response).dot(&force.column(value.reference));
                }
            }
        }
        (h, slopes)
    }

    /// What all lines share. Derivatives alone need the responses.
    fn sweep(&self, system: &System, with_derivatives: bool) -> Option<Sweep> {
        let responses =
            |rows: &DMatrix<f64>| if with_derivatives { rows.transpose() } else { DMatrix::zeros(rows.ncols(), 0) };
        let (references, responses) = (self.references.transpose(), responses(&self.responses));
        // In the middle of the band rounding is the same at both its ends.
        let shift = TAU * TAU * self.lines_hz[0] * self.lines_hz[self.lines_hz.len() - 1];
        let pencil = || ShiftedPencil::new(&system.stiffness, &system.mass, shift).ok();
        let may_share = system.damping.is_none() && self.lines_hz.len() >= FEWEST_LINES;
        if let Some(pencil) = may_share.then(pencil).flatten() {
            let (references, responses) = (pencil.vectors.tr_mul(&references), pencil.vectors.tr_mul(&responses));
            return Some(Sweep::Decomposed { pencil, references, responses });
        }
        let stiffness = DynamicStiffness::new(&system.stiffness, &system.mass, system.damping.as_ref()).ok()?;
        Some(Sweep::Factored { stiffness, references, responses })
    }
}

/// Lines from which on a decomposition pays.
const FEWEST_LINES: usize = 8;

type ComplexMatrix = DMatrix<Complex<f64>>;

/// Z⁻¹ at many lines, on the rows of the references, B, and of the responses, Sᵀ.
enum Sweep {
    /// By a factorisation at every line.
    Factored { stiffness: DynamicStiffness, references: DMatrix<f64>, responses: DMatrix<f64> },
    /// By the complete basis X of the pencil (M, K + aM), in which Z of a structure without viscous damping is diagonal:
    ///
    /// ```text
    /// M x = θ (K + a M) x,   Xᵀ Z X = diag((1 + iη) - ((1 + iη) a + ω²) θ)
    /// ```
    Decomposed {
        pencil: ShiftedPencil,
        /// Xᵀ B.
        references: DMatrix<f64>,
        /// Xᵀ Sᵀ.
        responses: DMatrix<f64>,
    },
}

impl Sweep {
    /// Z⁻¹ B and Z⁻¹ Sᵀ: Z is symmetric, one factorisation serves both sides. None where it has no inverse.
    fn line(&mut self, omega: f64, loss_factor: f64) -> Option<(ComplexMatrix, ComplexMatrix)> {
        match self {
            Self::Factored { stiffness, references, responses } => {
                let n_references = references.ncols();
                let both = references.column_iter().chain(responses.column_iter());
                let mut b = ComplexMatrix::zeros(references.nrows(), n_references + responses.ncols());
                b.column_iter_mut().zip(both).for_each(|(mut b, own)| b.zip_apply(&own, |b, v| b.re = v));
                stiffness.solve(omega, loss_factor, &mut b).then(|| {
                    let y = b.columns(n_references, responses.ncols()).into_owned();
                    (b.columns(0, n_references).into_owned(), y)
                })
            }
            Self::Decomposed { pencil, references, responses } => {
                let stiff = Complex::new(1.0, loss_factor);
                let inverse = |t: &f64| (stiff - (stiff * pencil.shift + omega * omega) * *t).inv();
                let factors: Vec<Complex<f64>> = pencil.theta.iter().map(inverse).collect();
                let is_regular = factors.iter().all(|v| v.re.is_finite() && v.im.is_finite());
                let expand = |b: &DMatrix<f64>| {
                    let part = |of: fn(&Complex<f64>) -> f64| {
                        let scaled = DMatrix::from_fn(b.nrows(), b.ncols(), |i, j| of(&factors[i]) * b[(i, j)]);
                        &pencil.vectors * scaled
                    };
                    part(|v| v.re).zip_map(&part(|v| v.im), Complex::new)
                };
                is_regular.then(|| (expand(references), expand(responses)))
            }
        }
    }
}

/// The entries of ∂K, ∂M and ∂C that are not zero: a parameter touches few elements.
struct Entries(Vec<(usize, usize, [f64; 3])>);

impl Entries {
    fn of(d: &System) -> Self {
        let (n, mut out) = (d.stiffness.nrows(), Vec::new());
        for j in 0..n {
            for i in 0..n {
                let values = [d.stiffness[(i, j)], d.mass[(i, j)], d.damping.as_ref().map_or(0.0, |c| c[(i, j)])];
                if values != [0.0; 3] {
                    out.push((i, j, values));
                }
            }
        }
        Self(out)
    }

    /// ∂Z x.
    fn times(&self, x: &ComplexMatrix, omega: f64, loss_factor: f64) -> ComplexMatrix {
        let mut out = ComplexMatrix::zeros(x.nrows(), x.ncols());
        for &(i, j, [k, m, c]) in &self.0 {
            let z = Complex::new(k - omega * omega * m, loss_factor * k + omega * c);
            for column in 0..x.ncols() {
                out[(i, column)] += z * x[(j, column)];
            }
        }
        out
    }
}
