//! Several objectives of the same parameters as one: several tests of one structure.

use super::{EvalError, Linearization, Objective, PathCounts, Walls};
use crate::linalg::{DMatrix, DVector};
use std::fmt;

/// The sum of objectives over the same x.
///
/// ```text
/// r = [r_1; r_2; ...],   J = [J_1; J_2; ...],   cost = cost_1 + cost_2 + ...
/// ```
///
/// Each part is the comparison of the structure in one configuration (its supports, its masses) with one test; what
/// belongs to the parameters and not to a test (priors, targets of mass properties) must stand in one part only.
pub struct Stacked<'a> {
    parts: Vec<Box<dyn Objective + 'a>>,
}

impl fmt::Debug for Stacked<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Stacked").field("n_parts", &self.parts.len()).finish()
    }
}

impl<'a> Stacked<'a> {
    /// The sum of `parts`; `None` without any, or when they differ in the number of parameters.
    pub fn new(parts: Vec<Box<dyn Objective + 'a>>) -> Option<Self> {
        let n = parts.first()?.n_parameters();
        parts.iter().all(|p| p.n_parameters() == n).then_some(Self { parts })
    }

    /// The sum of parts that are known to fit together.
    ///
    /// # Panics
    /// Without a part.
    pub(crate) fn of(parts: Vec<Box<dyn Objective + 'a>>) -> Self {
        assert!(!parts.is_empty(), "a sum of nothing");
        Self { parts }
    }

    /// Its parts.
    pub fn parts(&self) -> impl Iterator<Item = &(dyn Objective + 'a)> {
        self.parts.iter().map(|p| &**p)
    }
}

impl Objective for Stacked<'_> {
    fn n_parameters(&self) -> usize {
        self.parts[0].n_parameters()
    }

    fn n_residuals(&self) -> usize {
        self.parts.iter().map(|p| p.n_residuals()).sum()
    }

    fn residuals(&self, x: &DVector<f64>) -> Result<DVector<f64>, EvalError> {
        let mut r = DVector::zeros(self.n_residuals());
        let mut row = 0;
        for part in &self.parts {
            let own = part.residuals(x)?;
            r.rows_mut(row, own.len()).copy_from(&own);
            row += own.len();
        }
        Ok(r)
    }

    fn linearize(&self, x: &DVector<f64>) -> Result<Linearization, EvalError> {
        let (n_rows, n) = (self.n_residuals(), self.n_parameters());
        let (mut residuals, mut jacobian) = (DVector::zeros(n_rows), DMatrix::zeros(n_rows, n));
        let mut row = 0;
        for part in &self.parts {
            let own = part.linearize(x)?;
            let len = own.residuals.len();
            residuals.rows_mut(row, len).copy_from(&own.residuals);
            jacobian.rows_mut(row, len).copy_from(&own.jacobian);
            row += len;
        }
        Ok(Linearization { residuals, jacobian })
    }

    fn cost(&self, x: &DVector<f64>) -> Result<f64, EvalError> {
        self.parts.iter().map(|p| p.cost(x)).sum()
    }

    fn costs(&self, points: &[DVector<f64>], out: &mut [f64]) {
        if let [part] = self.parts.as_slice() {
            return part.costs(points, out);
        }
        let mut own = vec![0.0; points.len()];
        out.fill(0.0);
        for part in &self.parts {
            part.costs(points, &mut own);
            out.iter_mut().zip(&own).for_each(|(sum, c)| *sum += c);
        }
    }

    fn confirm(&self, x: &DVector<f64>, cost: f64) -> f64 {
        if let [part] = self.parts.as_slice() {
            return part.confirm(x, cost);
        }
        // Which part is wrong does not matter: each is asked for its own cost again.
        let mut sum = 0.0;
        let mut is_confirmed = true;
        for part in &self.parts {
            let mut own = [0.0];
            part.costs(std::slice::from_ref(x), &mut own);
            let confirmed = part.confirm(x, own[0]);
            is_confirmed &= confirmed.to_bits() == own[0].to_bits();
            sum += confirmed;
        }
        if is_confirmed { cost } else { sum }
    }

    fn path_counts(&self) -> PathCounts {
        self.parts.iter().map(|p| p.path_counts()).fold(PathCounts::default(), |sum, own| PathCounts {
            batch: sum.batch + own.batch,
            reference: sum.reference + own.reference,
        })
    }

    fn walls(&self) -> Walls {
        let mut walls = Walls::default();
        let mut row = 0;
        for part in &self.parts {
            walls.extend(part.walls().after(row));
            row += part.n_residuals();
        }
        walls
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// r = (a x - b).
    struct Line(f64, f64);

    impl Objective for Line {
        fn n_parameters(&self) -> usize {
            1
        }
        fn n_residuals(&self) -> usize {
            1
        }
        fn residuals(&self, x: &DVector<f64>) -> Result<DVector<f64>, EvalError> {
            Ok(DVector::from_element(1, self.0 * x[0] - self.1))
        }
    }

    #[test]
    fn costs_add_and_rows_stack() {
        let both = Stacked::new(vec![Box::new(Line(1.0, 0.5)), Box::new(Line(2.0, 0.0))]).unwrap();
        let x = DVector::from_element(1, 0.25);
        assert_eq!(both.residuals(&x).unwrap().as_slice(), [-0.25, 0.5]);
        assert_eq!(both.cost(&x).unwrap(), 0.5 * (0.0625 + 0.25));
        let mut costs = [0.0; 2];
        both.costs(&[x.clone(), DVector::zeros(1)], &mut costs);
        assert_eq!(costs, [0.15625, 0.125]);
        let l = both.linearize(&x).unwrap();
        assert!((l.jacobian - DMatrix::from_column_slice(2, 1, &[1.0, 2.0])).amax() < 1e-9);
        assert!(Stacked::new(Vec::new()).is_none());
    }
}
