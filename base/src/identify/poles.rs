//! Poles and participation, the part of the modal model that is not linear, and the number of its residual terms.

use super::plscf::Pole;
use retune_linalg::{Complex, DVector};

/// Number of terms of the two series for modes outside the band.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ResidualTerms {
    /// Powers -2, -3, ... of iω: modes below the band; 1 is the mass line alone.
    pub lower: usize,
    /// Powers 0, 1, ... of iω: modes above the band; 1 is the compliance alone.
    pub upper: usize,
}

/// Poles and participation: the part of the model that is not linear.
#[derive(Debug, Clone)]
pub(super) struct Poles {
    /// λ, rad/s.
    pub(super) values: Vec<Complex<f64>>,
    /// Participation per mode; the entry `pivot` is 1 and fixed.
    pub(super) participation: Vec<Vec<Complex<f64>>>,
    pub(super) pivots: Vec<usize>,
    /// The first so many are free; the others belong to neighbouring pieces of the band and stay.
    pub(super) n_free: usize,
}

impl Poles {
    pub(super) fn new<'a>(free: impl Iterator<Item = &'a Pole>, fixed: &'a [Pole]) -> Self {
        let mut out = Self { values: Vec::new(), participation: Vec::new(), pivots: Vec::new(), n_free: 0 };
        for p in free {
            out.push(p);
        }
        out.n_free = out.len();
        for p in fixed {
            out.push(p);
        }
        out
    }

    fn push(&mut self, p: &Pole) {
        let l = &p.participation;
        let pivot = (0..l.len()).max_by(|&a, &b| l[a].norm().total_cmp(&l[b].norm())).unwrap_or(0);
        self.values.push(p.value);
        self.participation.push(l.iter().map(|x| x / l[pivot]).collect());
        self.pivots.push(pivot);
    }

    pub(super) fn n_free(&self) -> usize {
        self.n_free
    }

    pub(super) fn len(&self) -> usize {
        self.values.len()
    }

    /// The complex unknowns: each pole, and each participation that is not a pivot: (mode, input or none).
    pub(super) fn unknowns(&self) -> Vec<(usize, Option<usize>)> {
        let mut q = Vec::new();
        for r in 0..self.n_free {
            q.push((r, None));
            q.extend((0..self.participation[r].len()).filter(|&i| i != self.pivots[r]).map(|i| (r, Some(i))));
        }
        q
    }

    /// One step. A pole stays in the stable half-plane (its damping falls to a tenth at most) and near where it was found
    /// (`start`): a weak candidate must not wander off to help a strong one.
    pub(super) fn moved(&self, step: &DVector<f64>, omega_ref: f64, start: &Self, line_spacing: f64) -> Self {
        let mut out = self.clone();
        for (k, (r, input)) in self.unknowns().into_iter().enumerate() {
            let d = Complex::new(step[2 * k], step[2 * k + 1]);
            match input {
                None => {
                    let mut next = self.values[r] + d * omega_ref;
                    next.re = next.re.min(0.1 * self.values[r].re);
                    let limit = f64::max(4.0 * start.values[r].re.abs(), 8.0 * line_spacing);
                    let away = next - start.values[r];
                    if away.norm() > limit {
                        next = start.values[r] + away * (limit / away.norm());
                        next.re = next.re.min(0.1 * self.values[r].re);
                    }
                    out.values[r] = next;
                }
                Some(i) => out.participation[r][i] += d,
            }
        }
        out
    }
}
