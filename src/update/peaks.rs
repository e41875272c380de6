//! Peaks of a posterior: sets of parameters with nothing probable between them.

use super::Controls;
use super::uncertainty::RISE_90;
use super::valley::{Valley, floor};
use crate::linalg::DVector;
use crate::model::ParametricModel;
use crate::objective::{Linearization, Objective, Scaling};
use crate::optim::Posterior;

/// One of several peaks.
#[derive(Debug, Clone, PartialEq)]
pub struct Peak {
    /// Its share of the samples.
    pub share: f64,
    /// Mean of each free parameter there, in the unit of its tables.
    pub mean: Vec<f64>,
    /// Standard deviation there.
    pub sd: Vec<f64>,
}

/// Samples from which ways down are gone.
const STARTS: usize = 12;

/// A peak with less of the samples is none.
const SMALLEST: f64 = 0.02;

/// Where a way down ended.
struct End {
    x: DVector<f64>,
    cost: f64,
    at: Linearization,
    /// The number of its peak.
    peak: usize,
}

impl End {
    /// Twice the cost at a point, by the residuals that are linear from here.
    fn height(&self, x: &DVector<f64>) -> f64 {
        (&self.at.residuals + &self.at.jacobian * (x - &self.x)).norm_squared()
    }
}

/// The peaks of a posterior by descending share; none where it has one.
///
/// From samples that lie far apart the cost is minimised; ends are one peak where they lie in one valley, of a depth of 2.7 in
/// chi-squared. A sample belongs to the peak whose linear model of the residuals puts it lowest.
pub(super) fn peaks(
    (model, scaling): (&dyn ParametricModel, &Scaling),
    objective: &dyn Objective,
    found: &Posterior,
) -> Vec<Peak> {
    let refine = |x: &DVector<f64>| floor(objective, x, Controls::default());
    let mut ends: Vec<End> = Vec::new();
    let mut n_peaks = 0;
    for start in far_apart(found) {
        let Some((x, cost)) = refine(start) else { continue };
        let Ok(at) = objective.linearize(&x) else { continue };
        let joins = |known: &End| {
            Valley { objective, limit: known.cost.max(cost) + RISE_90, refine: &refine }.joins(&known.x, &x)
        };
        let peak = ends.iter().find(|e| joins(e)).map_or(n_peaks, |e| e.peak);
        n_peaks = n_peaks.max(peak + 1);
        ends.push(End { x, cost, at, peak });
    }
    if n_peaks < 2 {
        return Vec::new();
    }
    let mut members: Vec<Vec<&DVector<f64>>> = vec![Vec::new(); n_peaks];
    for x in &found.samples {
        if let Some(end) = ends.iter().min_by(|a, b| a.height(x).total_cmp(&b.height(x))) {
            members[end.peak].push(x);
        }
    }
    let n = found.samples.len() as f64;
    members.retain(|m| m.len() as f64 >= SMALLEST * n);
    members.sort_by_key(|m| std::cmp::Reverse(m.len()));
    if members.len() < 2 {
        return Vec::new();
    }
    let shown = |k: usize, x: f64| model.parameters().get(scaling.free()[k]).display(scaling.value(k, x));
    let peak = |m: Vec<&DVector<f64>>| {
        let count = m.len() as f64;
        let moments = |k: usize| {
            let mean = m.iter().map(|x| shown(k, x[k])).sum::<f64>() / count;
            let square = m.iter().map(|x| (shown(k, x[k]) - mean).powi(2)).sum::<f64>() / count;
            (mean, square.sqrt())
        };
        let (mean, sd) = (0..scaling.len()).map(moments).unzip();
        Peak { share: count / n, mean, sd }
    };
    members.into_iter().map(peak).collect()
}

/// The most probable sample, then again and again the one that is farthest from all before, in standard deviations.
fn far_apart(found: &Posterior) -> Vec<&DVector<f64>> {
    let scale = found.covariance().diagonal().map(|v| if v > 0.0 { 1.0 / v.sqrt() } else { 0.0 });
    let distance = |a: &DVector<f64>, b: &DVector<f64>| (a - b).component_mul(&scale).norm_squared();
    let first = (0..found.samples.len()).min_by(|&a, &b| found.costs[a].total_cmp(&found.costs[b])).unwrap_or(0);
    let mut chosen = vec![&found.samples[first]];
    let mut nearest: Vec<f64> = found.samples.iter().map(|x| distance(x, chosen[0])).collect();
    while chosen.len() < STARTS.min(found.samples.len()) {
        let farthest =
            (0..nearest.len()).max_by(|&a, &b| nearest[a].total_cmp(&nearest[b]).then(b.cmp(&a))).unwrap_or(0);
        let next = &found.samples[farthest];
        nearest.iter_mut().zip(&found.samples).for_each(|(d, x)| *d = d.min(distance(x, next)));
        chosen.push(next);
    }
    chosen
}

#[cfg(test)]
mod tests {
    use crate::data::read_test;
    use crate::model::{Registry, load};
    use crate::optim::Tmcmc;
    use crate::update::{Sampled, Settings, TestCase, sample_posterior};

    const SPRINGS: &str = "
retune: 1
name: Two masses on springs
active_dofs: [uz]
parameters:
  k1: {value: 3000 N/m, bounds: [1000 N/m, 9000 N/m]}
  k2: {value: 900 N/m, bounds: [100 N/m, 3000 N/m]}
nodes: {a: [0, 0, 0], b: [1 m, 0, 0]}
springs: {g: {node: a, k: {uz: k1}}, ab: {nodes: [a, b], k: {uz: k2}}}
masses: {ma: {node: a, mass: 1 kg}, mb: {node: b, mass: 1 kg}}
";

    fn sample(model: &str) -> Sampled {
        let test = "
retune_test: 1
name: t
sources: {a: {kind: measured, text: an example}}
modes:
  - {frequency: 4.398934 Hz, frequency_sd: 0.5 %, source: a}
  - {frequency: 11.516560 Hz, frequency_sd: 0.5 %, source: a}
";
        let (model, test) = (load(model, &Registry::builtin()).unwrap().0, read_test(test).unwrap().0);
        let sampler = Tmcmc { n_samples: 800, seed: 3, ..Tmcmc::default() };
        sample_posterior(&[TestCase { model: &model, test: &test }], &Settings::default(), &sampler).unwrap()
    }

    /// k1 + 2 k2 and k1 k2 are seen, with the Jacobian |k1 - 2 k2|: 2000 N/m at (4000, 1000) and at (2000, 2000), so that the two peaks
    /// hold a half each.
    #[test]
    fn two_peaks_are_told_with_their_shares() {
        let found = sample(SPRINGS);
        let mut peaks = found.peaks;
        assert_eq!(peaks.len(), 2);
        peaks.sort_by(|a, b| b.mean[0].total_cmp(&a.mean[0]));
        for (peak, right) in peaks.iter().zip([[4000.0, 1000.0], [2000.0, 2000.0]]) {
            assert!((peak.share - 0.5).abs() < 0.15, "{peaks:?}");
            for k in 0..2 {
                assert!((peak.mean[k] - right[k]).abs() < peak.sd[k] && peak.sd[k] < 0.03 * right[k], "{peaks:?}");
            }
        }
        assert!(sample(&SPRINGS.replace("[1000 N/m, 9000 N/m]", "[3000 N/m, 9000 N/m]")).peaks.is_empty());
    }
}
