//! Modes of a test that are one space: close ones whose shapes are mixtures, as the test file or a hypothesis says.
//!
//! Their partners in the model are found by the shapes as they are, then turned to the measured ones as [modes that are nearly
//! double](super::close_modes) are: Φ -> Φ Q. The frequencies stay, and so do their slopes, which are those of the modes before they are turned.

use super::close_modes::{Measured, seen, turn, turn_by};
use crate::data::TestData;
use crate::linalg::DMatrix;
use crate::modal::{ModeDerivative, Modes};

/// Partners of the modes of a space, and Q, by which they have been turned.
#[derive(Debug, Clone)]
pub(super) struct Turn {
    /// Elastic modes of the model.
    pub(super) cluster: Vec<usize>,
    pub(super) q: DMatrix<f64>,
}

impl Turn {
    /// The angle between two of its modes, rad, from 0 to π/2; none where one is not of it.
    pub(super) fn angle(&self, a: usize, b: usize) -> Option<f64> {
        let place = |mode| self.cluster.iter().position(|&k| k == mode);
        let (a, b) = (place(a)?, place(b)?);
        Some(self.q[(b, a)].abs().atan2(self.q[(a, a)].abs()))
    }

    /// Modes with the shapes of this cluster as they were.
    pub(super) fn undone(&self, modes: &Modes) -> Modes {
        let mut out = modes.clone();
        turn_by(&mut out, &self.cluster, &self.q.transpose());
        out
    }

    /// Derivatives of its modes as turned, from those of the modes before, in the order of the cluster.
    pub(super) fn derivatives(&self, before: &[ModeDerivative]) -> Vec<ModeDerivative> {
        let turned = |k: usize| {
            let mut shape = &before[0].shape * self.q[(0, k)];
            before.iter().enumerate().skip(1).for_each(|(a, d)| shape += &d.shape * self.q[(a, k)]);
            ModeDerivative { lambda: before[k].lambda.clone(), shape }
        };
        (0..before.len()).map(turned).collect()
    }
}

/// The spaces of a test: modes with shapes that have one name there.
pub(super) fn spaces(test: &TestData) -> Vec<Vec<usize>> {
    let mut named: Vec<(&str, Vec<usize>)> = Vec::new();
    for (m, mode) in test.modes.iter().enumerate().filter(|(_, m)| m.shape.is_some() && !m.standing.is_aside()) {
        let Some(name) = mode.space.as_deref() else { continue };
        match named.iter_mut().find(|(known, _)| *known == name) {
            Some((_, own)) => own.push(m),
            None => named.push((name, vec![m])),
        }
    }
    named.into_iter().map(|(_, own)| own).filter(|own| own.len() > 1).collect()
}

/// Turns the partners of a space to its measured shapes; `None` where the sensors do not tell how they stand.
///
/// * `partners` - elastic modes, ascending
/// * `at_sensors` - elastic shapes at the sensors, (n_sensor x n_elastic)
/// * `space` - the test shapes of the space
pub(super) fn turn_space(
    modes: &mut Modes,
    partners: Vec<usize>,
    at_sensors: &DMatrix<f64>,
    space: Measured<'_>,
) -> Option<Turn> {
    let cluster = seen(vec![partners], at_sensors).pop()?;
    let q = turn(modes, &cluster, at_sensors, space)?;
    Some(Turn { cluster, q })
}

#[cfg(test)]
mod tests {
    use crate::data::TestData;
    use crate::linalg::DVector;
    use crate::model::{Model, ParametricModel, Registry, load};
    use crate::objective::mast::{MAST, OPEN, sensors};
    use crate::objective::{Comparison, LeastSquares, Objective, Scaling, difference};
    use crate::update::{TwinOptions, assess, twin_modes};

    const ANGLE: f64 = 0.3;

    /// A mast that is a little stiffer in one plane: pairs of modes 2 % apart.
    fn mast() -> Model {
        let bar = "shape: {rectangle: {width: 50 mm, height: 51 mm}}";
        let text = MAST.replace("shape: {tube: {diameter: 50 mm, wall: 3 mm}}", bar);
        assert!(text.contains(bar));
        load(&text, &Registry::builtin()).unwrap().0
    }

    /// Four modes, the pairs turned by an angle; of one space each where that is said.
    fn test(model: &Model, noise: f64, seed: u64, are_spaces: bool) -> TestData {
        let options = TwinOptions {
            n_modes: 4,
            frequency_noise: 0.1 * noise,
            shape_noise: noise,
            seed,
            faults: vec!["modes-mixed@mode 1+mode 2, mode 3+mode 4=0.02".parse().unwrap()],
            ..TwinOptions::default()
        };
        let mut test = twin_modes(model, &model.parameters().nominal(), &sensors(), &options, "made up").unwrap();
        for (k, mode) in test.modes.iter_mut().enumerate() {
            mode.label = None;
            mode.frequency_hz.sd = 0.003 * mode.frequency_hz.value;
            mode.shape_sd = mode.shape.as_ref().map(|s| s.map(|_| 0.02));
            mode.space = are_spaces.then(|| format!("pair {}", k / 2));
        }
        test
    }

    #[test]
    fn mixed_shapes_agree_as_a_space() {
        let model = mast();
        let theta = model.parameters().nominal();
        let alone = test(&model, 0.0, 0, false);
        let comparison = Comparison::new(&model, &alone, OPEN).unwrap();
        let apart = comparison.predict(&theta).unwrap();
        assert!(apart.pairs.pairs.iter().all(|p| p.mac < 0.9), "{:?}", apart.pairs.pairs);
        let spaces = test(&model, 0.0, 0, true);
        let comparison = Comparison::new(&model, &spaces, OPEN).unwrap();
        let p = comparison.predict(&theta).unwrap();
        assert!(p.pairs.pairs.iter().all(|p| p.mac > 1.0 - 1e-9), "{:?}", p.pairs.pairs);
        // sin 2θ = κ f/Δf of the twin's own frequencies.
        let [f, g] = [p.frequencies_hz[0], p.frequencies_hz[1]];
        let angle = 0.5 * (0.02 * 0.5 * (f + g) / (g - f)).min(1.0).asin();
        assert!((p.mixture(0, 1).unwrap() - angle).abs() < 1e-6, "{angle}: {:?}", p.mixture(0, 1));
        assert!(angle > ANGLE && p.mixture(0, 2).is_none());
        assert_eq!(p.n_free_angles(|_| true), 2);
    }

    /// Parameters move frequencies, and the space of a pair; where the angles are the best ones the cost is stationary in them.
    #[test]
    fn derivatives_are_those_before_the_turn() {
        let model = mast();
        let test = test(&model, 0.02, 3, true);
        let comparison = Comparison::new(&model, &test, OPEN).unwrap();
        let objective = LeastSquares::new(&comparison);
        let x = DVector::from_row_slice(&[0.3, 0.7]);
        let exact = objective.linearize(&x).unwrap();
        let by_difference = difference(objective.n_residuals(), &x, |x| objective.residuals(x)).unwrap();
        // Frequencies row by row; of shapes the gradient of the cost, in which the angles have no part.
        let (a, b) = (exact.jacobian.rows(0, 4), by_difference.jacobian.rows(0, 4));
        assert!((a - b).amax() < 1e-4 * a.amax(), "{a} {b}");
        let gradient = |j: &crate::linalg::DMatrix<f64>| j.tr_mul(&exact.residuals);
        let (a, b) = (gradient(&exact.jacobian), gradient(&by_difference.jacobian));
        assert!((&a - &b).amax() < 1e-4 * a.amax(), "{a} {b}");
    }

    /// Of right models chi-squared has the mean of its number of data, from which the angles are taken.
    #[test]
    fn chi_squared_knows_the_angles_of_spaces() {
        let model = mast();
        let theta = model.parameters().nominal();
        let (tests, mut sum) = (200_u32, 0.0);
        for seed in 0..u64::from(tests) {
            let mut test = test(&model, 0.02, seed, true);
            test.modes.iter_mut().for_each(|m| m.frequency_hz.sd = 0.002 * m.frequency_hz.value);
            let comparison = Comparison::new(&model, &test, OPEN).unwrap();
            let misfit = assess(&comparison, &theta).unwrap().misfit;
            // Four frequencies, 32 readings of shapes, four scales, two angles.
            assert_eq!(misfit.n_data, 30);
            sum += misfit.chi_squared;
        }
        let (mean, limit) = (sum / f64::from(tests), 3.0 * (60.0 / f64::from(tests)).sqrt());
        assert!((mean - 30.0).abs() < limit, "{mean}, limit {limit}");
    }

    /// Points of a search take the reference path, and cost the same there.
    #[test]
    fn searches_see_spaces() {
        let model = mast();
        let test = test(&model, 0.02, 3, true);
        let comparison = Comparison::new(&model, &test, OPEN).unwrap();
        let objective = LeastSquares::new(&comparison);
        let x = DVector::from_row_slice(&[0.3, 0.7]);
        let mut costs = [0.0; 3];
        objective.costs(&[x.clone(), x.clone(), x.clone()], &mut costs);
        let cost = 0.5 * objective.residuals(&x).unwrap().norm_squared();
        assert!(costs.iter().all(|c| (c - cost).abs() < 1e-9 * cost), "{costs:?} {cost}");
        assert_eq!(objective.path_counts().batch, 0);
        assert_eq!(Scaling::new(&model).len(), 2);
    }
}
