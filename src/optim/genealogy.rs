//! Who descends from whom in a population that is resampled again and again, and what that says of the error of its evidence.

/// Stages over which members of one ancestor are taken to depend on each other.
const MEMORY: usize = 4;

/// The stages of a population: the deviations of its weights from their mean, and the parents of the members that followed.
///
/// ```text
/// ln Z = Σ_k ln mean(w_k),   δ_k = w_k/mean(w_k) - 1
/// var ln Z = Σ_k Σ_l cov(mean δ_k, mean δ_l),   |k - l| <= 4:
///            (1/n²) Σ_a (Σ_{i from a} δ_k,i) (Σ_{j from a} δ_l,j)      over the ancestors a four stages before the earlier
/// ```
///
/// Members of one parent are alike after a few Metropolis steps, and so are their weights: n of them tell less than n independent
/// ones. Families of different ancestors are independent, so their sums scatter as the error does.
///
/// # Source
/// A. Lee, N. Whiteley, Variance estimation in the particle filter, Biometrika 105, 2018; J. Olsson, R. Douc, Numerically stable online
/// estimation of variance in particle filters, Bernoulli 25, 2019.
#[derive(Debug, Default)]
pub(super) struct Genealogy {
    deviations: Vec<Vec<f64>>,
    parents: Vec<Vec<usize>>,
}

impl Genealogy {
    /// Adds a stage: δ of its members, and for each member of the next the one that it was copied from.
    pub(super) fn add(&mut self, deviations: Vec<f64>, parents: Vec<usize>) {
        self.deviations.push(deviations);
        self.parents.push(parents);
    }

    /// The variance of ln Z.
    pub(super) fn variance(&self) -> f64 {
        let n_stages = self.deviations.len();
        let mut sum = 0.0;
        for k in 0..n_stages {
            let root = k.saturating_sub(MEMORY);
            let own = self.families(k, root);
            for l in k..n_stages.min(k + MEMORY + 1) {
                let later = self.families(l, root);
                let n = (self.deviations[k].len() * self.deviations[l].len()) as f64;
                let covariance = own.iter().zip(&later).map(|(a, b)| a * b).sum::<f64>() / n;
                sum += if l == k { covariance } else { 2.0 * covariance };
            }
        }
        sum.max(0.0)
    }

    /// Σ δ of the members of a stage by their ancestor at an earlier one.
    fn families(&self, stage: usize, root: usize) -> Vec<f64> {
        let mut sums = vec![0.0; self.deviations[root].len()];
        for (i, deviation) in self.deviations[stage].iter().enumerate() {
            let ancestor = self.parents[root..stage].iter().rev().fold(i, |member, parents| parents[member]);
            sums[ancestor] += deviation;
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four members of two stages: alone at the first, where each counts; two families of two at the second.
    #[test]
    fn families_count_as_one() {
        let mut g = Genealogy::default();
        g.add(vec![1.0, -1.0, 0.5, -0.5], vec![0, 0, 2, 2]);
        assert_eq!(g.variance(), 2.5 / 16.0);
        g.add(vec![1.0, 1.0, -1.0, -1.0], vec![0, 1, 2, 3]);
        // (2² + 2²)/16 beside it, and twice the covariance (1·2 - 0.5·2)/16.
        assert!((g.variance() - (2.5 + 8.0 + 2.0) / 16.0).abs() < 1e-15);
    }
}
