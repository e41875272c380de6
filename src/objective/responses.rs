//! Frequency responses of a model at the lines and channels of a test, from K, M and C: over all vectors of the structure, or line by line.

use super::answers::{Functions, Line};
use super::common_error::CommonError;
use super::prediction::Prediction;
use super::starting_point::starting_point;
use crate::correlation::{CorrelationError, fitted_channel, observation_matrix, random_variance};
use crate::data::{Channel, DampingError, FrfFit, TestData};
use crate::linalg::{Complex, DMatrix, DynamicStiffness, EntrySlopes, LinalgError, ShiftedPencil, Superposition};
use crate::model::{ParametricModel, System};
use crate::once::Once;
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
    /// What the damping of each mode does to ln H of each value, in standard deviations, value by value.
    of_damping: Vec<Complex<f64>>,
    /// The same as an error that logarithms of amplitudes have in common, and one that real and imaginary parts in turns have.
    common: [Once<Option<CommonError>>; 2],
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

/// Values below this share of the root mean square of their function in their band get the standard deviation of that level: at an
/// antiresonance a relative one would ask for what no sensor delivers.
const FLOOR: f64 = 0.05;

impl FrfRows {
    /// `None` where the test has no functions, or does not use them.
    pub(super) fn new(model: &dyn ParametricModel, test: &TestData) -> Result<Option<Self>, CorrelationError> {
        let (Some(set), Some(fit)) = (&test.frfs, &test.frf_fit) else { return Ok(None) };
        let FrfFit { relative_sd, loss_factor, .. } = fit;
        let lines: Vec<usize> = (0..set.n_lines()).filter(|&l| fit.uses(set.frequencies_hz[l])).collect();
        if lines.is_empty() {
            let text = "no line of the frequency response functions lies in `bands`";
            return Err(CorrelationError::Model(text.to_string()));
        }
        let (responses, references) = (rows_of(model, test, &set.responses)?, rows_of(model, test, &set.references)?);
        // Where the model cannot move it has no amplitude to compare.
        let moving = |rows: &DMatrix<f64>| (0..rows.nrows()).filter(|&i| rows.row(i).amax() > 0.0).collect::<Vec<_>>();
        let (moving_responses, moving_references) = (moving(&responses), moving(&references));
        let band_of = |hz: f64| fit.bands_hz.iter().position(|[low, high]| (*low..=*high).contains(&hz)).unwrap_or(0);
        let n_bands = fit.bands_hz.len().max(1);
        let damping = fit.damping_error.as_deref();
        let n_errors = damping.map_or(0, DampingError::n_modes);
        let (mut values, mut of_damping) = (Vec::new(), Vec::new());
        for &reference in &moving_references {
            for &response in &moving_responses {
                let mut squares = vec![(0.0, 0_usize); n_bands];
                for (l, &hz) in set.frequencies_hz.iter().enumerate().filter(|(_, hz)| fit.is_in_bands(**hz)) {
                    let square = set.at(l, reference, response).norm_sqr();
                    if square.is_finite() {
                        let of_band = &mut squares[band_of(hz)];
                        *of_band = (of_band.0 + square, of_band.1 + 1);
                    }
                }
                let levels: Vec<f64> = squares.iter().map(|&(sum, count)| (sum / count.max(1) as f64).sqrt()).collect();
                for (line, &l) in lines.iter().enumerate() {
                    let measured = set.at(l, reference, response);
                    let size = measured.norm();
                    if !(size.is_finite() && size > 0.0) {
                        continue;
                    }
                    let hz = set.frequencies_hz[l];
                    let random = size * random_variance(set, set.index(l, reference, response)).sqrt();
                    // What coherence does not vouch for tells nothing.
                    if !random.is_finite() {
                        continue;
                    }
                    let error = |mode: usize| damping.map(|d| d.of_value(hz, (reference, response), measured, mode));
                    let errors: Vec<Complex<f64>> = (0..n_errors).filter_map(error).collect();
                    // What is not linear in an error is the value's own.
                    let beyond = 0.5 * size * errors.iter().map(Complex::norm_sqr).sum::<f64>();
                    let of_value = relative_sd * size.max(FLOOR * levels[band_of(hz)]);
                    let sd = of_value.hypot(random).hypot(beyond);
                    of_damping.extend(errors);
                    values.push(FrfValue { line, reference, response, measured, relative_sd: sd / size, sd });
                }
            }
        }
        Ok(Some(Self {
            of_damping,
            common: [Once::new(), Once::new()],
            responses,
            references,
            order: set.quantity.order(),
            lines_hz: lines.iter().map(|&l| set.frequencies_hz[l]).collect(),
            values,
            loss_factor: loss_factor.unwrap_or(0.0),
        }))
    }

    /// What the damping of modes does to the logarithms of all amplitudes alike.
    pub(super) fn common_of_log(&self) -> Option<&CommonError> {
        let find = || self.common_error(1, |v, error, _| error.re / v.relative_sd);
        self.common[0].get_or_find(find).as_ref()
    }

    /// The same to real and imaginary parts in turns.
    pub(super) fn common_of_parts(&self) -> Option<&CommonError> {
        let part = |v: &FrfValue, error: Complex<f64>, part: usize| {
            let moved = error * v.measured / v.sd;
            if part == 0 { moved.re } else { moved.im }
        };
        self.common[1].get_or_find(|| self.common_error(2, part)).as_ref()
    }

    /// * `rows` - of a value
    fn common_error(&self, rows: usize, of: impl Fn(&FrfValue, Complex<f64>, usize) -> f64) -> Option<CommonError> {
        let n_errors = self.of_damping.len() / self.values.len().max(1);
        let row = |i: usize, m: usize| {
            let value = i / rows;
            of(&self.values[value], self.of_damping[value * n_errors + m], i % rows)
        };
        CommonError::new(&DMatrix::from_fn(rows * self.values.len(), n_errors, row))
    }

    /// "frf 12 -> p3 at 17.250 Hz" by index.
    pub(super) fn name(&self, test: &TestData, value: usize) -> String {
        let v = &self.values[value];
        let names = test.frfs.as_ref().map(|s| (&s.references[v.reference].name, &s.responses[v.response].name));
        let (from, to) = names.map_or(("", ""), |(a, b)| (a.as_str(), b.as_str()));
        format!("frf {from} -> {to} at {:.3} Hz", self.lines_hz[v.line])
    }

    /// The model's values, found once for a prediction.
    pub(super) fn values_of<'p>(
        &self,
        model: &dyn ParametricModel,
        theta: &[f64],
        prediction: &'p Prediction,
    ) -> &'p [Complex<f64>] {
        prediction.responses.get_or_find(|| self.evaluate(model, theta, prediction, None).0)
    }

    /// The values at each line: number, response, reference.
    fn at_line(&self) -> Vec<Vec<[usize; 3]>> {
        let mut at_line = vec![Vec::new(); self.lines_hz.len()];
        for (i, v) in self.values.iter().enumerate() {
            at_line[v.line].push([i, v.response, v.reference]);
        }
        at_line
    }

    /// The model's values, and how it moves at every line; `None` where Z has no inverse.
    pub(super) fn answering(
        &self,
        model: &dyn ParametricModel,
        theta: &[f64],
        prediction: &Prediction,
    ) -> Option<Functions> {
        let system = prediction.system().ok()?;
        let loss_factor = loss_factor(model, theta, self.loss_factor);
        let lines = Lines { system: &system, hz: &self.lines_hz, loss_factor };
        let (n, rows) = (system.stiffness.nrows(), [&self.responses, &self.references]);
        let [n_responses, n_references] = rows.map(DMatrix::nrows);
        let right = DMatrix::from_fn(n, n_responses + n_references, |i, j| {
            if j < n_responses { self.responses[(j, i)] } else { self.references[(j - n_responses, i)] }
        });
        let mut motions = rows.map(|rows| DMatrix::zeros(n, 2 * rows.nrows() * self.lines_hz.len()));
        let mut is_solved = true;
        lines
            .sweep(&mut lines.stiffness(), &right, |line, x| {
                let Some(x) = x else {
                    is_solved = false;
                    return;
                };
                for (of, (first, count)) in motions.iter_mut().zip([(0, n_responses), (n_responses, n_references)]) {
                    for j in 0..count {
                        let at = 2 * (line * count + j);
                        for (i, v) in x.column(first + j).iter().enumerate() {
                            (of[(i, at)], of[(i, at + 1)]) = (v.re, v.im);
                        }
                    }
                }
            })
            .ok()?;
        let line = |hz: &f64| Line {
            omega: TAU * hz,
            strained: Complex::new(1.0, loss_factor),
            power: power(*hz, self.order),
        };
        is_solved.then(|| Functions {
            lines: self.lines_hz.iter().map(line).collect(),
            motions,
            values: self.values_of(model, theta, prediction).to_vec(),
            at_line: self.at_line(),
        })
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
        model: &dyn ParametricModel,
        theta: &[f64],
        prediction: &Prediction,
        free: Option<&[usize]>,
    ) -> (Vec<Complex<f64>>, DMatrix<Complex<f64>>) {
        let nan = Complex::new(f64::NAN, f64::NAN);
        let mut h = vec![nan; self.values.len()];
        let free = free.unwrap_or(&[]);
        let mut slopes = DMatrix::from_element(self.values.len(), free.len(), nan);
        // `Comparison::new` refuses a model without dense matrices.
        let Ok(system) = prediction.system() else { return (h, slopes) };
        let loss_factor = loss_factor(model, theta, self.loss_factor);
        let own = model.modal_damping();
        let derivatives: Vec<Option<EntrySlopes>> = free
            .iter()
            .map(|&j| {
                let of_loss_factor = own.map_or(0.0, |ratio| 2.0 * ratio.slope(j));
                model.assemble_derivative(theta, j).ok().map(|d| entry_slopes(&d, of_loss_factor))
            })
            .collect();
        let lines = Lines { system: &system, hz: &self.lines_hz, loss_factor };
        let rows = [&self.responses, &self.references];
        let known = prediction.modes.basis.as_deref();
        let take = |at: &FrfValue, all: &[Complex<f64>]| {
            let of_line = at.line * self.references.nrows() + at.reference;
            power(self.lines_hz[at.line], self.order) * all[of_line * self.responses.nrows() + at.response]
        };
        let mut stiffness = lines.stiffness();
        let found = superposed(&lines, &stiffness, rows, known, |all| {
            h.iter_mut().zip(&self.values).for_each(|(h, v)| *h = take(v, all.responses()));
            for (mut column, d) in slopes.column_iter_mut().zip(&derivatives) {
                let Some(d) = d else { continue };
                let own = all.derivative(d);
                column.iter_mut().zip(&self.values).for_each(|(slope, v)| *slope = take(v, &own));
            }
        });
        if found.is_some() {
            return (h, slopes);
        }
        let at_line = self.at_line();
        // Z is symmetric: one factorisation gives Z⁻¹ B and, for derivatives, Z⁻¹ Sᵀ.
        let n_references = self.references.nrows();
        let n_responses = if free.is_empty() { 0 } else { self.responses.nrows() };
        let right = DMatrix::from_fn(self.references.ncols(), n_references + n_responses, |i, j| {
            if j < n_references { self.references[(j, i)] } else { self.responses[(j - n_references, i)] }
        });
        let mut force = Vec::new();
        let swept = lines.sweep(&mut stiffness, &right, |line, x| {
            let Some(x) = x else { return };
            let omega = TAU * self.lines_hz[line];
            let power = power(self.lines_hz[line], self.order);
            for &[v, response, reference] in &at_line[line] {
                let own = self.responses.row(response);
                let sum: Complex<f64> = own.iter().zip(x.column(reference).iter()).map(|(s, x)| x * *s).sum();
                h[v] = power * sum;
            }
            for (j, d) in derivatives.iter().enumerate() {
                let Some(d) = d else { continue };
                forces(d, x, n_references, (omega, loss_factor), &mut force);
                // ∂Z = i η' K of the ratio of every mode.
                let strained = (d.loss_factor != 0.0).then(|| strained(&system.stiffness, x, n_references));
                for &[v, response, reference] in &at_line[line] {
                    let y = x.column(n_references + response);
                    let own = force.iter().skip(reference).step_by(n_references);
                    let mut sum: Complex<f64> = d.rows.iter().zip(own).map(|(&i, f)| y[i] * f).sum();
                    if let Some(strained) = &strained {
                        let all: Complex<f64> =
                            y.iter().zip(strained.column(reference).iter()).map(|(y, f)| y * f).sum();
                        sum += Complex::new(0.0, d.loss_factor) * all;
                    }
                    slopes[(v, j)] = -power * sum;
                }
            }
        });
        if swept.is_err() {
            h.fill(nan);
            slopes.fill(nan);
        }
        (h, slopes)
    }
}

/// (iω)^order.
fn power(hz: f64, order: i32) -> Complex<f64> {
    Complex::new(0.0, TAU * hz).powi(order)
}

/// A structure at the lines of a test.
struct Lines<'a> {
    system: &'a System,
    hz: &'a [f64],
    loss_factor: f64,
}

impl Lines<'_> {
    fn stiffness(&self) -> DynamicStiffness {
        DynamicStiffness::new(&self.system.stiffness, &self.system.mass, self.system.damping.as_ref())
    }

    /// Z⁻¹ of right-hand sides at every line, see [`DynamicStiffness::sweep`].
    fn sweep(
        &self,
        stiffness: &mut DynamicStiffness,
        right: &DMatrix<f64>,
        each: impl FnMut(usize, Option<&DMatrix<Complex<f64>>>),
    ) -> Result<(), LinalgError> {
        let omegas: Vec<f64> = self.hz.iter().map(|f| TAU * f).collect();
        stiffness.sweep(&omegas, self.loss_factor, right, each)
    }
}

/// Tells of the responses by superposition over all vectors; `None` where a solution line by line takes less, or where dashpots couple too much.
///
/// * `line_by_line` - what would be swept
/// * `rows` - of the responses and of the references
/// * `known` - the vectors, where modes were solved by them
fn superposed(
    lines: &Lines<'_>,
    line_by_line: &DynamicStiffness,
    rows: [&DMatrix<f64>; 2],
    known: Option<&ShiftedPencil>,
    tell: impl FnOnce(&Superposition<'_>),
) -> Option<()> {
    let System { stiffness, mass, damping } = lines.system;
    let (n, functions) = (stiffness.nrows(), rows[0].nrows() * rows[1].nrows());
    let by_vectors = Superposition::multiplications(n, lines.hz.len(), functions, known.is_some());
    if by_vectors > line_by_line.multiplications(lines.hz.len(), rows[1].nrows()) {
        return None;
    }
    let own;
    let basis = match known {
        Some(known) => known,
        None => {
            let middle = lines.hz.iter().filter(|f| **f > 0.0).map(|f| f.ln()).sum::<f64>() / lines.hz.len() as f64;
            own = ShiftedPencil::new(stiffness, mass, (TAU * middle.exp()).powi(2)).ok()?;
            &own
        }
    };
    tell(&Superposition::new(basis, (stiffness, mass, damping.as_ref()), rows, lines.hz, lines.loss_factor)?);
    Some(())
}

/// η of K (1 + i η): what is stated, and 2 ζ of the ratio that the model gives every mode. At the resonance of a mode that is this ratio; beside it, where
/// damping hardly matters, it differs by terms of the second order.
pub(crate) fn loss_factor(model: &dyn ParametricModel, theta: &[f64], stated: f64) -> f64 {
    stated + model.modal_damping().map_or(0.0, |zeta| 2.0 * zeta.at(theta))
}

/// K x for the first columns of x.
fn strained(stiffness: &DMatrix<f64>, x: &DMatrix<Complex<f64>>, columns: usize) -> DMatrix<Complex<f64>> {
    let part = |of: fn(&Complex<f64>) -> f64| stiffness * DMatrix::from_fn(x.nrows(), columns, |i, j| of(&x[(i, j)]));
    part(|v| v.re).zip_map(&part(|v| v.im), Complex::new)
}

/// Rows of channels, (n_channels x n_dof).
pub(super) fn rows_of(
    model: &dyn ParametricModel,
    test: &TestData,
    channels: &[Channel],
) -> Result<DMatrix<f64>, CorrelationError> {
    let sensors = channels.iter().map(|c| fitted_channel(c, test)).collect::<Result<Vec<_>, _>>()?;
    observation_matrix(model, &sensors)
}

/// A function of a model below this share of the strongest of its reference is zero but for rounding: 120 dB.
const SILENT: f64 = 1e-6;
/// Lines at which that is looked at.
const LOOKS: usize = 9;

/// Functions of a test, as reference and response, that a model leaves without amplitude: its force does not move that direction, whatever
/// the size. None where the test does not fit its functions.
pub(crate) fn silent_functions(
    model: &dyn ParametricModel,
    test: &TestData,
) -> Result<Vec<(usize, usize)>, CorrelationError> {
    let (Some(set), Some(fit)) = (&test.frfs, &test.frf_fit) else { return Ok(Vec::new()) };
    let fitted: Vec<f64> = set.frequencies_hz.iter().copied().filter(|&f| fit.uses(f) && f > 0.0).collect();
    let step = fitted.len().div_ceil(LOOKS).max(1);
    let lines: Vec<f64> = fitted.into_iter().step_by(step).collect();
    let (responses, references) = (rows_of(model, test, &set.responses)?, rows_of(model, test, &set.references)?);
    let wrong = |e: &dyn std::fmt::Display| CorrelationError::Model(e.to_string());
    let system = model.assemble(&starting_point(model)).map_err(|e| wrong(&e))?;
    let loss_factor = loss_factor(model, &starting_point(model), fit.loss_factor.unwrap_or(0.0));
    let h = direct_responses(&system, [&responses, &references], &lines, set.quantity.order(), loss_factor)
        .map_err(|e| wrong(&e))?;
    let (n_responses, n_references) = (set.responses.len(), set.references.len());
    let largest = |reference: usize, response: usize| {
        let at = |line: usize| h[(line * n_references + reference) * n_responses + response].norm();
        (0..lines.len()).map(at).filter(|v| v.is_finite()).fold(0.0, f64::max)
    };
    let mut silent = Vec::new();
    for reference in 0..n_references {
        let strongest = (0..n_responses).map(|r| largest(reference, r)).fold(0.0, f64::max);
        silent
            .extend((0..n_responses).filter(|&r| largest(reference, r) <= SILENT * strongest).map(|r| (reference, r)));
    }
    Ok(silent)
}

/// (iω)^order S Z⁻¹ B of every line, with S the rows of the responses and Bᵀ those of the references: the layout of `FrfSet`, NaN where Z
/// has no inverse.
///
/// ```text
/// Z = K (1 + i η) + i ω C - ω² M
/// ```
pub(crate) fn direct_responses(
    system: &System,
    [responses, references]: [&DMatrix<f64>; 2],
    lines_hz: &[f64],
    order: i32,
    loss_factor: f64,
) -> Result<Vec<Complex<f64>>, LinalgError> {
    let nan = Complex::new(f64::NAN, f64::NAN);
    let per_line = responses.nrows() * references.nrows();
    let mut h = vec![nan; lines_hz.len() * per_line];
    let lines = Lines { system, hz: lines_hz, loss_factor };
    let mut stiffness = lines.stiffness();
    let found = superposed(&lines, &stiffness, [responses, references], None, |all| {
        for (line, (to, from)) in h.chunks_mut(per_line).zip(all.responses().chunks(per_line)).enumerate() {
            let power = power(lines_hz[line], order);
            to.iter_mut().zip(from).for_each(|(to, from)| *to = power * from);
        }
    });
    if found.is_some() {
        return Ok(h);
    }
    lines.sweep(&mut stiffness, &references.transpose(), |line, x| {
        let Some(x) = x else { return };
        let power = power(lines_hz[line], order);
        let cells = h[line * per_line..][..per_line].chunks_mut(responses.nrows());
        for (cells, x) in cells.zip(x.column_iter()) {
            for (cell, row) in cells.iter_mut().zip(responses.row_iter()) {
                *cell = power * row.iter().zip(x.iter()).map(|(s, x)| x * *s).sum::<Complex<f64>>();
            }
        }
    })?;
    Ok(h)
}

/// The entries of ∂K, ∂C and ∂M that are not zero: a parameter touches few elements.
fn entry_slopes(d: &System, loss_factor: f64) -> EntrySlopes {
    let n = d.stiffness.nrows();
    let mut out = EntrySlopes { loss_factor, ..EntrySlopes::default() };
    for i in 0..n {
        let before = out.list.len();
        for j in 0..n {
            let values = [d.stiffness[(i, j)], d.damping.as_ref().map_or(0.0, |c| c[(i, j)]), d.mass[(i, j)]];
            if values != [0.0; 3] {
                out.list.push((out.rows.len(), j, values));
            }
        }
        if out.list.len() > before {
            out.rows.push(i);
        }
    }
    out
}

/// The rows of ∂Z x for the first columns of x, row by row.
fn forces(
    slopes: &EntrySlopes,
    x: &DMatrix<Complex<f64>>,
    columns: usize,
    (omega, loss_factor): (f64, f64),
    out: &mut Vec<Complex<f64>>,
) {
    out.clear();
    out.resize(slopes.rows.len() * columns, Complex::default());
    for &(row, j, [k, c, m]) in &slopes.list {
        let z = Complex::new(k - omega * omega * m, loss_factor * k + omega * c);
        for (column, sum) in out[row * columns..][..columns].iter_mut().enumerate() {
            *sum += z * x[(j, column)];
        }
    }
}
