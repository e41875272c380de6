//! The probability that any of several dependent events happens, by importance sampling.

use super::statistics::Gaussian;

/// Draws between two looks at the standard error.
const BATCH: usize = 32;

/// Most draws.
const MOST: usize = 512;

/// Relative standard error that is enough.
const ENOUGH: f64 = 0.1;

/// P(∪ A_e) from the probabilities of the events and draws in which a given one happens.
///
/// ```text
/// P = B E[1/N],   B = Σ p_e,   e drawn with p_e/B,   noise drawn given A_e,   N = number of events that happen in it
/// ```
///
/// * `probabilities` - p_e of each event, not all zero
/// * `level` - a number of the data at hand, from which the draws are seeded: tests share no draws, so that the error of one p-value
///   is not that of all; a single-precision copy of it counts, so that rounding changes nothing
/// * `draw` - draws the noise given the event of an index
/// * `count` - counts the events that happen in each of some draws, 1 or more; many draws at once cost less
///
/// Unbiased, whatever the dependence; its variance is at most P (B - P)/n, so it is exact where one event implies all others
/// and nearly so where P is small. Draws go on until the standard error is a tenth of P, 512 at most.
///
/// # Source
/// D. Q. Naiman, C. E. Priebe, Computing scan statistic p values using importance sampling, J. Comput. Graph. Statist. 10 (2001)
/// 296-328; A. B. Owen, Y. Maximov, M. Chertkov, Importance sampling the union of rare events with an application to power
/// systems analysis, Electron. J. Statist. 13 (2019) 231-254.
pub(super) fn union_probability<D>(
    probabilities: &[f64],
    level: f64,
    mut draw: impl FnMut(usize, &mut Gaussian) -> D,
    mut count: impl FnMut(&[(usize, D)]) -> Vec<usize>,
) -> f64 {
    let cumulative: Vec<f64> = probabilities
        .iter()
        .scan(0.0, |sum, p| {
            *sum += p;
            Some(*sum)
        })
        .collect();
    let bound = cumulative.last().copied().unwrap_or(0.0);
    let mut gaussian = Gaussian::new(u64::from((level as f32).to_bits()));
    let (mut sum, mut squares, mut draws) = (0.0, 0.0, 0);
    while draws < MOST {
        let batch: Vec<(usize, D)> = (0..BATCH)
            .map(|_| {
                let u = gaussian.uniform() * bound;
                let e = cumulative.partition_point(|c| *c < u).min(probabilities.len() - 1);
                (e, draw(e, &mut gaussian))
            })
            .collect();
        for happened in count(&batch) {
            let share = 1.0 / happened as f64;
            (sum, squares) = (sum + share, squares + share * share);
        }
        draws += BATCH;
        let n = draws as f64;
        let mean = sum / n;
        if ((squares / n - mean * mean) / n).max(0.0).sqrt() <= ENOUGH * mean {
            break;
        }
    }
    (bound * sum / draws as f64).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Draws that are counts.
    fn counted(batch: &[(usize, usize)]) -> Vec<usize> {
        batch.iter().map(|d| d.1).collect()
    }

    /// Fifty events that are one: the union has the probability of each.
    #[test]
    fn one_event_under_many_names_counts_once() {
        assert!((union_probability(&[0.02; 50], 1.0, |_, _| 50, counted) - 0.02).abs() < 1e-12);
    }

    /// Independent events: P = 1 - Π (1 - p), within three standard errors of a tenth.
    #[test]
    fn independent_events_have_the_product_of_their_complements() {
        for (n, p) in [(5, 0.01), (40, 0.02), (200, 0.03), (3, 0.4)] {
            let found = union_probability(
                &vec![p; n],
                1.0,
                |e, g| (0..n).filter(|&k| k == e || g.uniform() < p).count(),
                counted,
            );
            let exact = 1.0 - (1.0_f64 - p).powi(i32::try_from(n).unwrap());
            assert!((found / exact - 1.0).abs() < 0.3, "{n} {p}: {found} {exact}");
        }
    }

    /// Over many data the error of the draws is not a bias: their mean is P within three standard errors.
    #[test]
    fn data_do_not_share_their_draws() {
        let (n, p, tests) = (8, 0.1, 400);
        let exact = 1.0 - (1.0_f64 - p).powi(8);
        let found: Vec<f64> = (0..tests)
            .map(|test| {
                let count = |e: usize, g: &mut Gaussian| (0..n).filter(|&k| k == e || g.uniform() < p).count();
                union_probability(&vec![p; n], 2.0 + f64::from(test) * 1e-3, count, counted)
            })
            .collect();
        let mean = found.iter().sum::<f64>() / f64::from(tests);
        // A tenth each, at most.
        let limit = 3.0 * 0.1 * exact / f64::from(tests).sqrt();
        assert!((mean - exact).abs() < limit, "{mean} for {exact}, limit {limit}");
    }
}
