//! Modes as foreign files hold them: shapes at points and dofs, without sensors and uncertainties.

use super::test::usable_scale;
use super::{Geometry, Measured, Origin, Place, Sensor, Standing, TestMode};
use crate::dof::Dof;
use retune_linalg::{Complex, DVector};

/// One row of the shapes.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeChannel {
    /// Name of the point: the label of the node in a universal file.
    pub point: String,
    /// Displacement or rotation, in the axes of the point.
    pub dof: Dof,
    /// Its axis as a unit vector in global axes.
    pub direction: [f64; 3],
}

/// A mode.
#[derive(Debug, Clone, PartialEq)]
pub struct ModeRecord {
    /// Name or description.
    pub label: Option<String>,
    /// Natural frequency, Hz; of a complex mode the modulus of its eigenvalue over 2π.
    pub frequency_hz: f64,
    /// Damping ratio as the file states it, 1; a pole that grows has a negative one.
    pub damping_ratio: Option<f64>,
    /// Shape at the channels, displacements in m and rotations in rad for one scale; NaN where nothing was measured.
    pub shape: DVector<Complex<f64>>,
    /// Modal mass φᵀMφ, kg m², for the scale of `shape`.
    pub modal_mass: Option<f64>,
    /// Modal A φᵀ(2λM + C)φ, kg m²/s, for the scale of `shape`.
    pub modal_a: Option<Complex<f64>>,
    /// Modal B -λ times modal A for a viscously damped mode, kg m²/s², for the scale of `shape`.
    pub modal_b: Option<Complex<f64>>,
}

impl ModeRecord {
    /// A mode of which only frequency and shape are known.
    pub fn new(label: Option<String>, frequency_hz: f64, shape: DVector<Complex<f64>>) -> Self {
        let (damping_ratio, modal_mass, modal_a, modal_b) = (None, None, None, None);
        Self { label, frequency_hz, damping_ratio, shape, modal_mass, modal_a, modal_b }
    }
}

/// Modes at common channels.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ModalSet {
    /// Rows of every shape.
    pub channels: Vec<ShapeChannel>,
    /// Modes by ascending frequency.
    pub modes: Vec<ModeRecord>,
}

/// Standard deviations for numbers that come without: each relative, a shape's to its largest entry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelativeSd {
    /// Of the frequency.
    pub frequency: f64,
    /// Of the damping ratio.
    pub damping: f64,
    /// Of the shape.
    pub shape: f64,
}

impl ModalSet {
    /// A sensor on the node of its point for each channel, named as the point, `12.ux` where that is not unique.
    pub fn sensors(&self) -> Vec<Sensor> {
        let is_single = |point: &str| self.channels.iter().filter(|c| c.point == point).count() == 1;
        let sensor = |c: &ShapeChannel| Sensor {
            name: if is_single(&c.point) { c.point.clone() } else { format!("{}.{}", c.point, c.dof) },
            place: Place::Node { node: c.point.clone(), position: None },
            direction: c.direction,
            offset: None,
            is_rotation: c.dof.is_rotation(),
            mass: None,
        };
        self.channels.iter().map(sensor).collect()
    }

    /// The same sensors at the positions of their points.
    pub fn placed_sensors(&self, geometry: Option<&Geometry>) -> Vec<Sensor> {
        let mut sensors = self.sensors();
        for (sensor, channel) in sensors.iter_mut().zip(&self.channels) {
            let own = geometry.and_then(|g| g.point(&channel.point)).map(|p| p.position_m);
            if let Place::Node { position, .. } = &mut sensor.place {
                *position = own;
            }
        }
        sensors
    }

    /// The modes as a test file holds them, at [`ModalSet::sensors`], with standard deviations that are marked as
    /// defaults. A damping ratio that no vibrating mode of a passive structure has, below 0 or from 1 on, is left out, and so is a shape
    /// without an entry other than zero.
    pub fn test_modes(&self, origin: &Origin, sd: RelativeSd) -> Vec<TestMode> {
        let measured = |value: f64, relative: f64| Measured { value, sd: relative * value.abs(), sd_is_default: true };
        let mode = |m: &ModeRecord| {
            let largest = m.shape.iter().map(|v| v.norm()).filter(|v| v.is_finite()).fold(0.0, f64::max);
            let mut shape = m.shape.clone();
            let mut shape_sd = DVector::from_element(shape.len(), sd.shape * largest);
            usable_scale(&mut shape, &mut shape_sd);
            let has_shape = largest > 0.0;
            TestMode {
                label: m.label.clone(),
                frequency_hz: measured(m.frequency_hz, sd.frequency),
                damping_ratio: m.damping_ratio.filter(|z| (0.0..1.0).contains(z)).map(|z| measured(z, sd.damping)),
                origin: origin.clone(),
                shape: has_shape.then_some(shape),
                shape_sd: has_shape.then_some(shape_sd),
                shape_origin: has_shape.then(|| origin.clone()),
                components: Vec::new(),
                standing: Standing::Open,
                space: None,
            }
        };
        self.modes.iter().map(mode).collect()
    }

    /// Channels and modes of a test whose sensors stand on nodes and measure along global axes; the damping ratio and
    /// frequency are the measured values.
    ///
    /// # Errors
    /// The name of the first sensor that does not.
    pub fn from_test(sensors: &[Sensor], modes: &[TestMode]) -> Result<Self, String> {
        let mut channels = Vec::with_capacity(sensors.len());
        let mut signs = Vec::with_capacity(sensors.len());
        for sensor in sensors {
            let Place::Node { node, .. } = &sensor.place else { return Err(sensor.name.clone()) };
            let axis = (0..3).find(|i| sensor.direction[*i].abs() > 1.0 - 1e-12).ok_or_else(|| sensor.name.clone())?;
            let dof = Dof::ALL[axis + if sensor.is_rotation { 3 } else { 0 }];
            signs.push(sensor.direction[axis].signum());
            let direction = super::Point::GLOBAL[axis];
            channels.push(ShapeChannel { point: node.clone(), dof, direction });
        }
        let record = |m: &TestMode| ModeRecord {
            label: m.label.clone(),
            frequency_hz: m.frequency_hz.value,
            damping_ratio: m.damping_ratio.map(|z| z.value),
            shape: match &m.shape {
                Some(shape) => DVector::from_fn(shape.len(), |i, _| shape[i] * signs[i]),
                None => DVector::from_element(channels.len(), Complex::new(f64::NAN, 0.0)),
            },
            modal_mass: None,
            modal_a: None,
            modal_b: None,
        };
        let modes = modes.iter().map(record).collect();
        Ok(Self { channels, modes })
    }
}
