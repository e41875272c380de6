//! What a model predicts of a test: modes at the sensors, pairs with the measured modes, mass properties.

use super::answers::Answers;
use super::damped::Damped;
use super::spaces::Turn;
use crate::correlation::{ModePair, PairedModes};
use crate::linalg::{Complex, DMatrix, DVector};
use crate::modal::Modes;
use crate::model::{MassProperties, Matrices, ModelError, System};
use crate::once::Once;
use std::borrow::Cow;

/// The prediction at one θ.
///
/// A batch of candidates fills only what can be seen at the sensors: there `matrices`, `modes` and `families` are empty, and
/// MAC is zero between different families. See [`super::Residual::needs_system`].
#[derive(Debug, Clone)]
pub struct Prediction {
    /// K, M, C.
    pub matrices: Matrices,
    /// Elastic modes follow the rigid ones.
    pub modes: Modes,
    /// Frequencies of the elastic modes, Hz.
    pub frequencies_hz: Vec<f64>,
    /// Elastic shapes at the sensors, (n_sensor x n_elastic).
    pub at_sensors: DMatrix<f64>,
    /// The observation matrix where it depends on θ.
    pub(super) sensors: Option<DMatrix<f64>>,
    /// Symmetry of each elastic mode.
    pub families: Vec<Option<String>>,
    /// Elastic modes so close that only the space of each run of them is determined; their shapes are those nearest the test.
    pub clusters: Vec<Vec<usize>>,
    /// Those of the clusters that the test says are one space, with what they were turned by.
    pub(super) turns: Vec<Turn>,
    /// MAC, rows elastic modes, columns test modes; zero where a test mode has no shape or is aside ([`super::Comparison::mac_of_all`]).
    pub mac: DMatrix<f64>,
    /// Pairs of elastic modes (analytical) with test modes (experimental).
    pub pairs: PairedModes,
    /// Mass properties, if the model knows them.
    pub mass_properties: Option<MassProperties>,
    /// What dashpots make of the modes, where they couple them: `frequencies_hz` and `at_sensors` are with them, `modes` without.
    pub(super) damped: Option<Damped>,
    /// Damping ratios by dashpots of the elastic modes, where they are not those of `matrices` and `modes`.
    pub(super) ratios: Option<Vec<f64>>,
    /// The model's values of the test's frequency responses, once they have been asked for.
    pub(super) responses: Once<Vec<Complex<f64>>>,
    /// What the sensors read in static tests, where it is known.
    pub(super) readings: Option<Vec<f64>>,
}

impl Prediction {
    /// The same modes at other frequencies and with other shapes at the sensors, as far as those tell: as in a batch.
    ///
    /// * `frequencies_hz`, `at_sensors`, `ratios` - of the elastic modes, ratios by dashpots alone
    /// * `answers` - to the loads of the test, where it has any
    #[must_use]
    pub fn moved(
        &self,
        frequencies_hz: Vec<f64>,
        at_sensors: DMatrix<f64>,
        ratios: Vec<f64>,
        mass_properties: Option<MassProperties>,
        answers: Option<Answers>,
    ) -> Self {
        let (clusters, pairs) = (self.clusters.clone(), self.pairs.clone());
        let seen = Self::seen(frequencies_hz, at_sensors, self.mac.clone());
        let moved = Self { clusters, pairs, mass_properties, ratios: Some(ratios), ..seen };
        let Some(Answers { responses, readings }) = answers else { return moved };
        moved.responses.get_or_find(|| responses);
        Self { readings: Some(readings), ..moved }
    }

    /// φᵀCφ/(2ω) of an elastic mode, or -Re s/|s| of one that dashpots couple; zero without dashpots.
    pub fn ratio_by_dashpots(&self, elastic: usize) -> f64 {
        let coupled = || self.damped.as_ref()?.ratio(elastic);
        let known = self.ratios.as_ref().map(|ratios| ratios[elastic]);
        known.or_else(coupled).unwrap_or_else(|| {
            let k = self.modes.n_rigid + elastic;
            let shape = self.modes.shapes.columns(k, 1).into_owned();
            let work = self.matrices.damping_times(&shape).map_or(0.0, |c| shape.dot(&c));
            work / (2.0 * self.modes.lambda[k].sqrt())
        })
    }

    /// Of what can be seen at the sensors, as in a batch: without matrices, modes, families and pairs.
    pub(super) fn seen(frequencies_hz: Vec<f64>, at_sensors: DMatrix<f64>, mac: DMatrix<f64>) -> Self {
        Self {
            matrices: Matrices::Dense(System::zeros(0, false)),
            modes: Modes {
                lambda: DVector::zeros(0),
                shapes: DMatrix::zeros(0, 0),
                n_rigid: 0,
                n_mechanism: 0,
                basis: None,
            },
            frequencies_hz,
            at_sensors,
            sensors: None,
            families: Vec::new(),
            clusters: Vec::new(),
            turns: Vec::new(),
            mac,
            pairs: PairedModes::default(),
            mass_properties: None,
            damped: None,
            ratios: None,
            responses: Once::new(),
            readings: None,
        }
    }

    /// K, M and C as dense matrices.
    ///
    /// # Errors
    /// [`ModelError::TooLarge`] for a model with more than [`crate::model::MOST_DENSE_DOFS`] dofs.
    pub fn system(&self) -> Result<Cow<'_, System>, ModelError> {
        self.matrices.dense()
    }

    /// The elastic mode paired with a test mode, and the pair's position.
    pub fn partner(&self, test_mode: usize) -> Option<usize> {
        self.pairs.pairs.iter().find(|p| p.experimental == test_mode).map(|p| p.analytical)
    }

    /// The angle by which the partners of two test modes of one [space](crate::data::TestMode::space) were turned to them, rad, from 0 to π/2.
    pub fn mixture(&self, a: usize, b: usize) -> Option<f64> {
        let (a, b) = (self.partner(a)?, self.partner(b)?);
        self.turns.iter().find_map(|turn| turn.angle(a, b))
    }

    /// Angles by which the model's shapes were turned to the measured ones: t(t - 1)/2 + t(m - t) for a cluster of m modes of which
    /// t have measured partners. The fit of the shapes has as many numbers more.
    ///
    /// * `has_shape` - whether a test mode has a shape
    pub(crate) fn n_free_angles(&self, has_shape: impl Fn(usize) -> bool) -> usize {
        let partners = |cluster: &[usize]| {
            let paired = |p: &&ModePair| cluster.contains(&p.analytical) && has_shape(p.experimental);
            self.pairs.pairs.iter().filter(paired).count()
        };
        self.clusters
            .iter()
            .map(|cluster| (cluster.len(), partners(cluster)))
            .map(|(m, t)| t * t.saturating_sub(1) / 2 + t * (m - t))
            .sum()
    }
}

/// Derivatives of a prediction with respect to the parameters `free`.
#[derive(Debug, Clone)]
pub struct PredictionDerivative {
    /// For each elastic mode that is needed: ∂f/∂θ_j in Hz, (n_free), and ∂(shape at sensors)/∂θ_j, (n_sensor x n_free).
    pub modes: Vec<Option<(DVector<f64>, DMatrix<f64>)>>,
}
