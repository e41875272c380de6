//! Greedy removal or turning of sensors: which of them spoil a pair, or all pairs together.

use super::ShapeScalar;
use super::mac::unit_scale;
use crate::linalg::DMatrix;

/// One step of the removal, or of turning over.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct SensorRemoval {
    /// The sensor that was taken away or turned over, a row of the shapes.
    pub sensor: usize,
    /// Mean MAC of the pairs with this and all steps before it.
    pub mean_mac: f64,
    /// MAC of each pair then.
    pub mac: Vec<f64>,
}

/// The sensors whose removal raises the mean MAC of the pairs most, one after the other.
///
/// ```text
/// at each step:  sensor = argmax_i  mean_r MAC(φ_a[r], φ_x[r])  without the rows removed so far and without i
/// ```
///
/// * `phi_a`, `phi_x` - paired shapes, (n_sensor x n_pairs); one column each to judge one pair; NaN where not measured
/// * `n_removed` - how many sensors to take away at most
///
/// Stops earlier when no removal raises the mean, or when two sensors would be left.
///
/// Removal always flatters: noise alone lets the MAC rise a little with each sensor. What tells is a jump in the first
/// steps. It cannot say whether the sensor or the model at that place is wrong.
///
/// # Panics
/// If the shapes of the matrices differ.
///
/// # Source
/// The MACCo of M. Brughmans, J. Leuridan, K. Blauwkamp, The application of FEM-EMA correlation and validation techniques
/// on a body-in-white, Proc. 11th IMAC, 1993.
pub fn spoiling_sensors<T: ShapeScalar>(
    phi_a: &DMatrix<T>,
    phi_x: &DMatrix<T>,
    n_removed: usize,
) -> Vec<SensorRemoval> {
    greedy(phi_a, phi_x, 0.0, n_removed, 0.0)
}

/// The sensors whose turning over raises the mean MAC of the pairs most, one after the other, as [`spoiling_sensors`].
///
/// * `least` - gain in the mean MAC of each step; a model that is wrong lets a MAC rise a little with the sign of any entry near a node
///
/// # Panics
/// If the shapes of the matrices differ.
pub fn turned_sensors<T: ShapeScalar>(phi_a: &DMatrix<T>, phi_x: &DMatrix<T>, least: f64) -> Vec<SensorRemoval> {
    greedy(phi_a, phi_x, -1.0, phi_a.nrows(), least)
}

/// Steps that raise the mean MAC most, each by more than `least`.
///
/// * `changed` - the weight of a sensor that is changed, as of [`macs`]
fn greedy<T: ShapeScalar>(
    phi_a: &DMatrix<T>,
    phi_x: &DMatrix<T>,
    changed: f64,
    most: usize,
    least: f64,
) -> Vec<SensorRemoval> {
    assert_eq!(phi_a.shape(), phi_x.shape(), "paired shapes at the same sensors");
    let mut weights = vec![1.0; phi_a.nrows()];
    let mut mean_mac = mean(&macs(phi_a, phi_x, &weights));
    let mut steps = Vec::new();
    while steps.len() < most && weights.iter().filter(|w| **w != 0.0).count() > 2 {
        let mut best: Option<(usize, f64, Vec<f64>)> = None;
        for sensor in (0..weights.len()).filter(|&i| weights[i] > 0.0).collect::<Vec<_>>() {
            weights[sensor] = changed;
            let with = macs(phi_a, phi_x, &weights);
            weights[sensor] = 1.0;
            let value = mean(&with);
            if best.as_ref().is_none_or(|(_, b, _)| value > *b) {
                best = Some((sensor, value, with));
            }
        }
        let Some((sensor, value, mac)) = best.filter(|(_, value, _)| *value > mean_mac + least) else { break };
        mean_mac = value;
        weights[sensor] = changed;
        steps.push(SensorRemoval { sensor, mean_mac, mac });
    }
    steps
}

/// MAC of each pair with weights of the sensors: 1 as measured, -1 turned over, 0 without it.
fn macs<T: ShapeScalar>(phi_a: &DMatrix<T>, phi_x: &DMatrix<T>, weights: &[f64]) -> Vec<f64> {
    (0..phi_a.ncols())
        .map(|r| {
            let (mut cross, mut norm_a, mut norm_x) = (T::zero(), 0.0, 0.0);
            let scale = |phi: &DMatrix<T>| unit_scale(phi.column(r).iter().copied());
            let (scale_a, scale_x) = (scale(phi_a), scale(phi_x));
            for (i, &w) in weights.iter().enumerate().filter(|(_, w)| **w != 0.0) {
                let (a, x) = (phi_a[(i, r)], phi_x[(i, r)]);
                if a.is_measured() && x.is_measured() {
                    let (a, x) = (a.scale(scale_a), x.scale(scale_x));
                    cross += (a.conjugate() * x).scale(w);
                    norm_a += a.modulus_squared();
                    norm_x += x.modulus_squared();
                }
            }
            let is_moving = norm_a > 0.0 && norm_x > 0.0;
            if is_moving { (cross.modulus() / norm_a.sqrt() / norm_x.sqrt()).powi(2).min(1.0) } else { 0.0 }
        })
        .collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reversed_and_the_dead_sensor_are_found_and_then_nothing() {
        let a = DMatrix::from_fn(12, 3, |i, j| (0.25 * (i + 1) as f64 * (j + 1) as f64).sin());
        let mut x = a.clone();
        x.row_mut(7).neg_mut();
        x.row_mut(2).fill(0.0);
        let removals = spoiling_sensors(&a, &x, 5);
        let sensors: Vec<usize> = removals.iter().take(2).map(|r| r.sensor).collect();
        assert_eq!(sensors, [7, 2]);
        assert!(removals[1].mac.iter().all(|m| (m - 1.0).abs() < 1e-14));
        assert!(removals.iter().skip(2).all(|r| r.mean_mac - removals[1].mean_mac < 1e-14));
    }

    #[test]
    fn turned_sensors_are_found_and_no_other() {
        let a = DMatrix::from_fn(12, 3, |i, j| (0.25 * (i + 1) as f64 * (j + 1) as f64).sin());
        let mut x = a.map(|v| v + 0.01);
        assert!(turned_sensors(&a, &x, 0.01).is_empty());
        x.row_mut(7).neg_mut();
        x.row_mut(10).neg_mut();
        let mut found: Vec<usize> = turned_sensors(&a, &x, 0.01).iter().map(|r| r.sensor).collect();
        found.sort_unstable();
        assert_eq!(found, [7, 10]);
    }

    #[test]
    fn one_pair_alone_and_no_sensors() {
        let a = DMatrix::from_column_slice(4, 1, &[1.0, 1.0, 1.0, 1.0]);
        let x = DMatrix::from_column_slice(4, 1, &[1.0, 1.0, -1.0, 1.0]);
        assert_eq!(spoiling_sensors(&a, &x, 1)[0], SensorRemoval { sensor: 2, mean_mac: 1.0, mac: vec![1.0] });
        assert!(spoiling_sensors(&DMatrix::<f64>::zeros(0, 0), &DMatrix::zeros(0, 0), 3).is_empty());
    }
}
