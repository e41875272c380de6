//! Answers to the loads of a test at one point, and what a small change of the structure makes of them.
//!
//! ```text
//! δH = -(iω)^p Yᵀ_s ΔZ Y_b,   Z Y = [Sᵀ Bᵀ] at every line,   ΔZ = ΔK (1 + iη) + iω ΔC - ω² ΔM
//! δ(s · u) = -λ · ΔK u,       K u = f,   K λ = s
//! ```
//!
//! Coordinates that a change brings are condensed at each line. So a change takes products of its own few rows.

use super::answers::{Answers, Functions, Parts};
use super::comparison::Comparison;
use super::prediction::Prediction;
use super::statics::Static;
use crate::linalg::{Complex, DMatrix};

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
        let has_statics = !comparison.test().static_tests.is_empty();
        let statics = if has_statics { Some(Static::new(comparison, prediction)?) } else { None };
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
        times: &dyn Fn(&DMatrix<f64>) -> Parts,
    ) -> Option<Answers> {
        let n_old = motion.nrows();
        let with_new = |x: DMatrix<f64>| x.resize_vertically(n_old + n_new, 0.0);
        let unit = DMatrix::from_fn(n_old + n_new, n_new, |i, j| f64::from(u8::from(i == n_old + j)));
        let brought = times(&unit);
        let Answers { mut responses, mut readings } = self.answers();
        responses.fill(Complex::default());
        readings.fill(0.0);
        if let Some(functions) = &self.functions {
            let [of_responses, of_references] = functions.motions.each_ref().map(|x| motion * x);
            let forces = times(&with_new(of_references));
            functions.add(&of_responses, n_new, (&forces, &brought), &mut responses)?;
        }
        if let Some(statics) = &self.statics {
            let [stiffness, ..] = times(&with_new(motion * &statics.moved));
            let [of_new, ..] = &brought;
            if let Some(mut force) = stiffness {
                if n_new > 0 {
                    let of_new = of_new.as_ref()?;
                    let inner = of_new.rows(n_old, n_new).into_owned();
                    force -= of_new * inner.lu().solve(&force.rows(n_old, n_new).into_owned())?;
                }
                statics.add(&(motion * &statics.reading), &force.rows(0, n_old).into_owned(), &mut readings);
            }
        }
        Some(Answers { responses, readings })
    }
}
