//! Names of what may be wrong with a sensor: those of the faults that a diagnosis tries are the same.

/// A sensor along another axis than the file says.
pub const SENSOR_AXIS: &str = "sensor-axis";
/// A sensor that reads nothing but noise.
pub const SENSOR_DEAD: &str = "sensor-dead";
/// A sensor with a wrong gain.
pub const SENSOR_GAIN: &str = "sensor-gain";
/// A sensor with far more noise than the others.
pub const SENSOR_NOISY: &str = "sensor-noisy";
/// A sensor that is turned over.
pub const SENSOR_SIGN: &str = "sensor-sign";
/// Two sensors, one in the place of the other.
pub const SENSOR_SWAP: &str = "sensor-swap";
