//! Answers to the loads of a test at one point, and what a small change of the structure makes of them.
//!
//! ```text
//! δH = -(iω)^p Yᵀ_s ΔZ Y_b,   Z Y = [Sᵀ Bᵀ] at every line,   ΔZ = ΔK (1 + iη) + iω ΔC - ω² ΔM
//! δ(s · u) = -λ · ΔK u,       K u = f,   K λ = s
//! ```
//!
//! Coordinates that a change brings are condensed at each line. So a change takes products of its own few rows.

use super::comparison::Comparison;
use super::prediction::Prediction;
use super::statics::Static;
use crate::linalg::{Complex, DMatrix};

/// What a test reads beside modes, at one point.
#[derive(Debug, Clone, Default)]
pub struct Answers {
    /// The model's values of the functions, in the order of their rows.
    pub responses: Vec<Complex<f64>>,
    /// What sensors read in static tests, in their order.
    pub readings: Vec<f64>,
}

/// A line of functions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    pub(super) omega: f64,
    /// 1 + iη.
    pub(super) strained: Complex<f64>,
    /// (iω)^p.
    pub(super) power: Complex<f64>,
}

/// Motions under unit loads at all lines: real and imaginary part of each side by side, loads side by side, then lines, (n_dof x any number).
pub(super) type Motions = DMatrix<f64>;

/// The functions of a test.
#[derive(Debug)]
pub(super) struct Functions {
    pub(super) lines: Vec<Line>,
    /// Of the responses and of the references.
    pub(super) motions: [Motions; 2],
    pub(super) values: Vec<Complex<f64>>,
    /// The values at each line: number, response, reference.
    pub(super) at_line: Vec<Vec<[usize; 3]>>,
}

/// The answers of a model, and how it moves under the loads and under unit loads at what reads them.
#[derive(Debug)]
pub struct Answering {
    functions: Option<Functions>,
    statics: Option<Static>,
}

impl Answering {
    /// Of a comparison at θ; `None` without static tests and functions, and where the model has no answer.
    pub fn new(comparison: &Comparison<'_>, theta: &[f64], prediction: &Prediction) -> Option<Self> {
        let functions = match comparison.responses() {
            Some(rows) => Some(rows.answering(comparison.model(), theta, prediction)?),
            None => None,
        };
        let statics = Static::new(comparison, prediction)?;
        (functions.is_some() || statics.is_some()).then_some(Self { functions, statics })
    }

    /// The answers as they are.
    pub fn answers(&self) -> Answers {
        Answers {
            responses: self.functions.as_ref().map_or_else(Vec::new, |f| f.values.clone()),
            readings: self.statics.as_ref().map_or_else(Vec::new, |s| s.readings.clone()),
        }
    }

    /// How much they move with a change, to first order; `None` where what it brings has no stiffness to condense it by.
    ///
    /// * `motion` - how the rows of the change move with the dofs of the model, new coordinates left out, (n_old x n_dof)
    /// * `n_new` - coordinates that it brings, which stand behind its rows
    /// * `times` - ΔK x, ΔM x and ΔC x of motions of its rows, (n_old + n_new x any number)
    pub fn moved(
        &self,
        motion: &DMatrix<f64>,
        n_new: usize,
        times: &dyn Fn(&DMatrix<f64>) -> [Option<DMatrix<f64>>; 3],
    ) -> Option<Answers> {
        let n_old = motion.nrows();
        let own = |x: &DMatrix<f64>| (motion * x).resize_vertically(n_old + n_new, 0.0);
        let unit = DMatrix::from_fn(n_old + n_new, n_new, |i, j| f64::from(u8::from(i == n_old + j)));
        let brought = times(&unit);
        let mut out = self.answers();
        if let Some(functions) = &self.functions {
            let [responses, references] = functions.motions.each_ref().map(|x| motion * x);
            let forces = times(&own(&functions.motions[1]));
            functions.add(&[responses, references], n_new, (&forces, &brought), &mut out.responses)?;
        }
        if let Some(statics) = &self.statics {
            let [stiffness, ..] = times(&own(&statics.moved));
            let [of_new, ..] = &brought;
            if let Some(mut force) = stiffness {
                if n_new > 0 {
                    let of_new = of_new.as_ref()?;
                    let inner = of_new.rows(n_old, n_new).into_owned();
                    force -= of_new * inner.lu().solve(&force.rows(n_old, n_new).into_owned())?;
                }
                statics.add(&(motion * &statics.reading), &force.rows(0, n_old).into_owned(), &mut out.readings);
            }
        }
        let before = self.answers();
        out.responses.iter_mut().zip(&before.responses).for_each(|(after, before)| *after -= before);
        out.readings.iter_mut().zip(&before.readings).for_each(|(after, before)| *after -= before);
        Some(out)
    }
}

impl Functions {
    /// Adds δH.
    ///
    /// * `own` - motions of the rows of the change under unit loads of responses and of references
    /// * `forces` - ΔK, ΔM and ΔC times those of references, and times units of the new coordinates
    fn add(
        &self,
        [responses, references]: &[DMatrix<f64>; 2],
        n_new: usize,
        (forces, brought): (&[Option<DMatrix<f64>>; 3], &[Option<DMatrix<f64>>; 3]),
        out: &mut [Complex<f64>],
    ) -> Option<()> {
        let n_old = references.nrows();
        let n_lines = self.lines.len();
        let [n_responses, n_references] = [responses, references].map(|x| x.ncols() / (2 * n_lines.max(1)));
        let mut force = DMatrix::<Complex<f64>>::zeros(n_old + n_new, n_references);
        for (l, line) in self.lines.iter().enumerate() {
            let factors = [line.strained, Complex::new(-line.omega * line.omega, 0.0), Complex::new(0.0, line.omega)];
            force.fill(Complex::default());
            for (factor, of) in factors.iter().zip(forces) {
                let Some(of) = of else { continue };
                for j in 0..n_references {
                    let [re, im] = [0, 1].map(|part| of.column(2 * (l * n_references + j) + part));
                    let all = re.iter().zip(im.iter());
                    force
                        .column_mut(j)
                        .iter_mut()
                        .zip(all)
                        .for_each(|(f, (re, im))| *f += factor * Complex::new(*re, *im));
                }
            }
            if n_new > 0 {
                let mut of_new = DMatrix::<Complex<f64>>::zeros(n_old + n_new, n_new);
                for (factor, of) in factors.iter().zip(brought) {
                    let Some(of) = of else { continue };
                    of_new.iter_mut().zip(of.iter()).for_each(|(z, v)| *z += factor * *v);
                }
                let answer =
                    of_new.rows(n_old, n_new).into_owned().lu().solve(&force.rows(n_old, n_new).into_owned())?;
                force -= of_new * answer;
            }
            for &[value, response, reference] in &self.at_line[l] {
                let [re, im] = [0, 1].map(|part| responses.column(2 * (l * n_responses + response) + part));
                let moving = re.iter().zip(im.iter()).map(|(re, im)| Complex::new(*re, *im));
                let sum: Complex<f64> = moving.zip(force.column(reference).iter()).map(|(y, f)| y * f).sum();
                out[value] -= line.power * sum;
            }
        }
        Some(())
    }
}
