use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// The draws that optimisers need, written out so that a path does not change when a random-number crate does.
pub trait Draw {
    /// Uniform in [0, 1), 53 random bits.
    fn unit(&mut self) -> f64;

    /// Uniform among 0, 1, ..., n - 1, by the high word of a product (bias below n/2⁶⁴).
    fn below(&mut self, n: usize) -> usize;

    /// Standard normal, by Box and Muller's transformation of two uniform numbers.
    fn normal(&mut self) -> f64;

    /// Standard Cauchy, by inversion.
    fn cauchy(&mut self) -> f64;

    /// A random order of the values, each order equally likely (Fisher and Yates).
    fn shuffle(&mut self, values: &mut [usize]);
}

impl Draw for ChaCha8Rng {
    fn unit(&mut self) -> f64 {
        const TWO_TO_MINUS_53: f64 = 1.0 / (1_u64 << 53) as f64;
        (self.next_u64() >> 11) as f64 * TWO_TO_MINUS_53
    }

    fn below(&mut self, n: usize) -> usize {
        ((u128::from(self.next_u64()) * n as u128) >> 64) as usize
    }

    fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.unit()).cos()
    }

    fn cauchy(&mut self) -> f64 {
        (std::f64::consts::PI * (self.unit() - 0.5)).tan()
    }

    fn shuffle(&mut self, values: &mut [usize]) {
        for i in (1..values.len()).rev() {
            values.swap(i, self.below(i + 1));
        }
    }
}

/// Points that fill the unit box: each parameter has one point in each of n equal slices.
///
/// # Source
/// M. D. McKay, R. J. Beckman, W. J. Conover, A comparison of three methods for selecting values of input variables in
/// the analysis of output from a computer code, Technometrics 21, 1979.
pub(crate) fn latin_hypercube(
    n_points: usize,
    n_parameters: usize,
    rng: &mut ChaCha8Rng,
) -> Vec<crate::linalg::DVector<f64>> {
    let mut points = vec![crate::linalg::DVector::zeros(n_parameters); n_points];
    let mut slices: Vec<usize> = (0..n_points).collect();
    for j in 0..n_parameters {
        rng.shuffle(&mut slices);
        for (point, &slice) in points.iter_mut().zip(&slices) {
            point[j] = (slice as f64 + rng.unit()) / n_points as f64;
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;

    #[test]
    fn draws_have_the_moments_of_their_distributions() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let n = 200_000_u32;
        let standard_error = f64::from(n).sqrt().recip();
        let mean = |draw: &mut dyn FnMut() -> f64| (0..n).map(|_| draw()).sum::<f64>() / f64::from(n);
        // five standard errors: a false alarm once in two million seeds
        assert!((mean(&mut || rng.unit()) - 0.5).abs() < 5.0 * standard_error * 0.289);
        assert!(mean(&mut || rng.normal()).abs() < 5.0 * standard_error);
        assert!((mean(&mut || rng.normal().powi(2)) - 1.0).abs() < 5.0 * standard_error * 1.415);
        // a Cauchy variable has no mean, but quartiles at -1 and 1
        assert!((mean(&mut || f64::from(rng.cauchy().abs() < 1.0)) - 0.5).abs() < 5.0 * standard_error * 0.5);
        assert!((mean(&mut || rng.below(7) as f64) - 3.0).abs() < 5.0 * standard_error * 2.0);
    }

    #[test]
    fn a_latin_hypercube_has_one_point_in_each_slice() {
        let points = latin_hypercube(10, 3, &mut ChaCha8Rng::seed_from_u64(1));
        for j in 0..3 {
            let mut slices: Vec<usize> = points.iter().map(|p| (p[j] * 10.0) as usize).collect();
            slices.sort_unstable();
            assert_eq!(slices, (0..10).collect::<Vec<_>>());
        }
    }
}
