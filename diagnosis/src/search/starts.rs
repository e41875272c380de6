//! Where the fit of an effect may start.

use crate::screen::effects::{Score, Screened};
use crate::screen::stage::Stage;
use retune::effect::{Candidate, NewParameter};
use retune::linalg::DVector;

/// Sizes of a start, as multiples of the typical one.
const LADDER: [f64; 4] = [0.1, 0.4, 1.0, 3.0];

/// Further ones where the bounds reach a hundred times as far: what gives or holds may do so from hardly to altogether.
const FAR: [f64; 2] = [12.0, 60.0];

/// Where a fit of an effect may start, in groups: for every base, sizes of a ladder; where sizes reach far, for every size the bases.
pub(crate) fn starts(stage: &Stage, score: &Score, bases: &[DVector<f64>]) -> Vec<Vec<DVector<f64>>> {
    let screened = &stage.screened[score.index];
    let candidate = &screened.candidate;
    let join = |x: &DVector<f64>, values: &[f64]| {
        let sizes = candidate.parameters.iter().zip(values).map(|(p, v)| p.in_box(*v));
        DVector::from_iterator(x.len() + values.len(), x.iter().copied().chain(sizes))
    };
    let sizes = start_sizes(candidate, screened, Some(score));
    if candidate.parameters.iter().all(NewParameter::spans_decades) {
        return sizes.iter().map(|v| bases.iter().map(|x| join(x, v)).collect()).collect();
    }
    bases.iter().map(|x| sizes.iter().map(|v| join(x, v)).collect()).collect()
}

/// A body on a spring has two sizes, and a basin for every mode that it may be tuned to.
pub(crate) fn effort(candidate: &Candidate) -> usize {
    if candidate.parameters.iter().any(|p| !p.grid.is_empty()) { 2 } else { 1 }
}

/// Sizes at which a refit of a candidate may start: as the screening says first, then a ladder around the typical size, and
/// the grid where there is one.
pub(crate) fn start_sizes(candidate: &Candidate, screened: &Screened, score: Option<&Score>) -> Vec<Vec<f64>> {
    let p = &candidate.parameters;
    let clamp = |v: Vec<f64>| -> Vec<f64> { v.iter().zip(p).map(|(v, p)| v.clamp(p.bounds[0], p.bounds[1])).collect() };
    let mut out = Vec::new();
    if let Some(score) = score {
        let at = &screened.columns[score.column].values;
        let scaled = at.iter().zip(p).map(|(v, p)| {
            if p.grid.is_empty() && p.typical != p.neutral { p.neutral + score.factor * (v - p.neutral) } else { *v }
        });
        out.push(clamp(scaled.collect()));
    }
    let gridded = p.iter().find(|p| !p.grid.is_empty());
    let far = if p.iter().all(NewParameter::spans_decades) { &FAR[..] } else { &[] };
    for factor in LADDER.iter().chain(far).copied() {
        let at = |t: f64| p.iter().map(|p| p.neutral + t * (p.typical - p.neutral)).collect::<Vec<f64>>();
        match gridded {
            Some(gridded) => {
                // The grid belongs to the typical size: a body of twice the mass keeps its frequency on twice the spring.
                let springs: Vec<usize> = (0..p.len()).filter(|&k| !p[k].grid.is_empty()).collect();
                let tuned = |i: usize, rigid: Option<usize>| {
                    let size = |(k, typical): (usize, f64)| match p[k].grid.get(i) {
                        Some(_) if rigid == Some(k) => p[k].bounds[1],
                        Some(value) => factor * value,
                        None => typical,
                    };
                    clamp(at(factor).into_iter().enumerate().map(size).collect())
                };
                for i in 0..gridded.grid.len() {
                    out.push(tuned(i, None));
                    // On springs in several directions it may give in some of them.
                    if springs.len() > 1 {
                        out.extend(springs.iter().map(|&k| tuned(i, Some(k))));
                    }
                }
            }
            None => {
                out.push(clamp(at(factor)));
                if !p.iter().any(NewParameter::one_sided) {
                    out.push(clamp(at(-factor)));
                }
            }
        }
    }
    out
}
