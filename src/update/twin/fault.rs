//! Faults of the measurement in a twin.

use super::TwinError;
use crate::correlation::{observation_matrix_at, sensor_position};
use crate::data::{
    Channel, FrfFit, FrfQuantity, FrfSet, Measured, Origin, Sensor, Standing, TestData, TestMode, corrected_functions,
};
use crate::fault::{At, Bench, Faults, Number, PlacedFault, SingleTest};
use crate::linalg::{Complex, DMatrix, DVector};
use crate::model::ParametricModel;
use std::str::FromStr;

/// A fault of the measurement in a twin, as `sensor-sign@p11` or `sensor-gain@p5=1.5`: an id as a diagnosis has it, and its number.
///
/// A factor is a plain number; an angle is in degrees; a sensor that scatters has so many times the noise of the others.
#[derive(Debug, Clone, PartialEq)]
pub struct TwinFault {
    id: String,
    number: Option<f64>,
}

impl TwinFault {
    /// A fault without a number.
    pub fn new(id: &str) -> Self {
        Self { id: id.to_string(), number: None }
    }

    /// The same with a number.
    #[must_use]
    pub fn with(self, number: f64) -> Self {
        Self { number: Some(number), ..self }
    }

    /// Its place in a test, and its number, SI.
    pub(super) fn placed(&self, bench: &Bench<'_>) -> Result<(PlacedFault, f64), TwinError> {
        let wrong = |problem| TwinError::Fault { text: self.to_string(), problem };
        let placed = PlacedFault::of_id(&self.id, &Faults::builtin(), bench)?;
        let expected = match placed.number() {
            Number::None | Number::Silence => {
                return if self.number.is_none() { Ok((placed, 1.0)) } else { Err(wrong("it has no number")) };
            }
            Number::Factor { .. } | Number::Frequency { .. } => "it needs a factor: `=1.5` behind it",
            Number::Angle { .. } => "it needs an angle in degrees: `=10` behind it",
            Number::Mixture => "it needs the coupling of the modes, over λ: `=0.005` behind it",
            Number::Scatter => "it needs a factor on the noise: `=5` behind it",
        };
        let number = self.number.ok_or_else(|| wrong(expected))?;
        let is_right = match placed.number() {
            Number::Factor { .. } => number != 0.0,
            Number::Angle { .. } | Number::Mixture => true,
            _ => number > 0.0,
        };
        if !(number.is_finite() && is_right) {
            return Err(wrong(expected));
        }
        let is_angle = matches!(placed.number(), Number::Angle { .. });
        Ok((placed, if is_angle { number.to_radians() } else { number }))
    }
}

impl std::fmt::Display for TwinFault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.id)?;
        self.number.map_or(Ok(()), |number| write!(f, "={number}"))
    }
}

impl FromStr for TwinFault {
    type Err = TwinError;

    fn from_str(text: &str) -> Result<Self, TwinError> {
        let text = text.trim();
        let Some((id, number)) = text.rsplit_once('=') else { return Ok(Self::new(text)) };
        let problem = "behind `=` stands a number";
        let number = number.trim().parse().map_err(|_| TwinError::Fault { text: text.to_string(), problem })?;
        Ok(Self::new(id.trim()).with(number))
    }
}

/// The faults of a twin at their places, with their numbers.
pub(super) struct Inflicted {
    faults: Vec<(PlacedFault, f64)>,
    texts: Vec<TwinFault>,
}

impl Inflicted {
    /// * `frequencies_hz` - of the modes that are listed
    pub(super) fn new(
        model: &dyn ParametricModel,
        sensors: &[Sensor],
        faults: &[TwinFault],
        frequencies_hz: &[f64],
    ) -> Result<Self, TwinError> {
        let texts = faults.to_vec();
        if faults.is_empty() {
            return Ok(Self { faults: Vec::new(), texts });
        }
        let draft = draft(sensors, frequencies_hz);
        let tests = SingleTest::new(&draft);
        let positions = sensors.iter().map(|s| sensor_position(model, s)).collect::<Result<Vec<_>, _>>()?;
        let dofs = model.dof_map();
        let all = dofs.node_names().iter().cloned().zip(dofs.positions().iter().copied());
        // Nodes of a mesh within a member are not places for a hand.
        let nodes = all.filter(|(name, _)| !name.contains('/')).collect();
        let bench = Bench { tests: &tests, positions: Some(positions), nodes };
        let faults = texts.iter().map(|f| f.placed(&bench)).collect::<Result<Vec<_>, _>>()?;
        Ok(Self { faults, texts })
    }

    /// What the sensors read, with every fault of theirs, (n_sensor x n_dof).
    pub(super) fn observe(
        &self,
        model: &dyn ParametricModel,
        theta: &[f64],
        sensors: &[Sensor],
    ) -> Result<DMatrix<f64>, TwinError> {
        let in_truth = |now: Vec<Sensor>, (fault, number): &(PlacedFault, f64)| fault.sensors_in_truth(&now, *number);
        let mounted = self.faults.iter().fold(sensors.to_vec(), in_truth);
        let mut rows = observation_matrix_at(model, &mounted, theta)?;
        for (fault, number) in &self.faults {
            for mut column in rows.column_iter_mut() {
                let mut readings: Vec<Complex<f64>> = column.iter().map(|v| Complex::new(*v, 0.0)).collect();
                fault.put_into_readings(&mut readings, *number);
                // What is taken out of a test as unknown is zero in a twin.
                let value = |z: &Complex<f64>| if z.re.is_nan() { 0.0 } else { z.re };
                column.iter_mut().zip(&readings).for_each(|(v, z)| *v = value(z));
            }
        }
        Ok(rows)
    }

    /// Factor on the noise of a sensor.
    pub(super) fn noise(&self, sensor: usize) -> f64 {
        let own = |(fault, number): &(PlacedFault, f64)| {
            (fault.number() == Number::Scatter && fault.is_of_channel(sensor)).then_some(*number)
        };
        self.faults.iter().filter_map(own).product()
    }

    /// Whether a sensor reads nothing but noise.
    pub(super) fn is_silent(&self, sensor: usize) -> bool {
        self.faults.iter().any(|(fault, _)| fault.number() == Number::Silence && fault.is_of_channel(sensor))
    }

    /// The sensor where a force acts that is stated at another.
    pub(super) fn acts_at(&self, stated: usize) -> usize {
        let found = self.faults.iter().find_map(|(fault, _)| match fault.at {
            At::Reference { sensor, reference, .. } if reference == stated => Some(sensor),
            _ => None,
        });
        found.unwrap_or(stated)
    }

    /// Mixes shapes of close modes by turning them, as a coupling κ λ between two modes does that leaves them at these frequencies:
    ///
    /// ```text
    /// φ_a' = φ_a cos θ + φ_b sin θ,   φ_b' = φ_b cos θ - φ_a sin θ,   sin 2θ = κ f/|f_b - f_a|, at most 1
    /// ```
    ///
    /// of unit modal mass, for neighbours one after the other.
    ///
    /// * `shapes` - at the sensors, as columns
    /// * `listed` - the column of every mode of the list, and its frequency, Hz
    pub(super) fn mix(&self, shapes: &mut DMatrix<f64>, listed: &[usize], frequencies_hz: &[f64]) {
        for (fault, coupling) in &self.faults {
            let At::Spaces { spaces, .. } = &fault.at else { continue };
            for pair in spaces.iter().flat_map(|s| s.windows(2)) {
                let [f, g] = [pair[0], pair[1]].map(|m| frequencies_hz[m]);
                let sin_2 = 0.5 * coupling * (f + g) / (g - f).abs();
                let (sin, cos) = (0.5 * sin_2.clamp(-1.0, 1.0).asin()).sin_cos();
                let [a, b] = [pair[0], pair[1]].map(|m| shapes.column(listed[m]).into_owned());
                shapes.set_column(listed[pair[0]], &(&a * cos + &b * sin));
                shapes.set_column(listed[pair[1]], &(b * cos - a * sin));
            }
        }
    }

    /// Puts faults of the list of modes into it.
    ///
    /// # Errors
    /// A mode that is not listed.
    pub(super) fn put_into_list(&self, modes: &mut [TestMode]) -> Result<(), TwinError> {
        for ((fault, number), text) in self.faults.iter().zip(&self.texts) {
            let own = fault.at.modes();
            if own.iter().any(|m| *m >= modes.len()) {
                let problem = "the twin has not so many modes";
                return Err(TwinError::Fault { text: text.to_string(), problem });
            }
            if !own.is_empty() && fault.number() != Number::Mixture {
                fault.fault.modes(&fault.at, fault.number().inverse(*number), modes);
            }
        }
        Ok(())
    }

    /// Puts faults of the functions alone into them.
    pub(super) fn put_into_functions(&self, set: &mut FrfSet, sensors: &[Sensor]) {
        let stated = TestData { sensors: sensors.to_vec(), ..TestData::default() };
        for (fault, number) in self.faults.iter().filter(|(f, _)| matches!(f.at, At::Response { .. })) {
            let corrections = fault.fault.functions(&fault.at, fault.number().inverse(*number), &stated);
            *set = corrected_functions(set.clone(), sensors, &corrections);
        }
    }
}

/// A test that has everything of which a fault could be: every sensor, these modes, and functions of a force at every sensor.
fn draft(sensors: &[Sensor], frequencies_hz: &[f64]) -> TestData {
    let channels: Vec<Channel> =
        sensors.iter().map(|s| Channel { name: s.name.clone(), direction: Some(s.direction) }).collect();
    let mode = |&value: &f64| TestMode {
        frequency_hz: Measured { value, sd: 0.0, sd_is_default: true },
        shape: Some(DVector::from_element(sensors.len(), Complex::new(1.0, 0.0))),
        label: None,
        damping_ratio: None,
        origin: Origin::Synthetic(String::new()),
        shape_sd: None,
        shape_origin: None,
        components: Vec::new(),
        standing: Standing::Open,
        space: None,
    };
    let set = FrfSet {
        quantity: FrfQuantity::Accelerance,
        frequencies_hz: Vec::new(),
        references: channels.clone(),
        responses: channels,
        h: Vec::new(),
        coherence: None,
        n_averages: None,
    };
    TestData {
        sensors: sensors.to_vec(),
        modes: frequencies_hz.iter().map(mode).collect(),
        frfs: Some(set),
        frf_fit: Some(FrfFit::default()),
        ..TestData::default()
    }
}
