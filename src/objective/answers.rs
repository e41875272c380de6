//! Answers to the loads of a test at one point.

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

/// Products of ΔK, ΔM and ΔC with some motions; `None` of one that does not change.
pub type Parts = [Option<DMatrix<f64>>; 3];

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

impl Functions {
    /// Adds δH.
    ///
    /// * `responses` - motions of the rows of the change under unit loads of the responses
    /// * `forces` - ΔK, ΔM and ΔC times those of references, and times units of the new coordinates
    pub(super) fn add(
        &self,
        responses: &DMatrix<f64>,
        n_new: usize,
        (forces, brought): (&Parts, &Parts),
        out: &mut [Complex<f64>],
    ) -> Option<()> {
        let n_old = responses.nrows();
        let of_line = 2 * self.lines.len().max(1);
        let [n_responses, n_references] = self.motions.each_ref().map(|x| x.ncols() / of_line);
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
