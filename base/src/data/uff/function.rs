//! Dataset 58: function at nodal DOF.

use super::FloatFormat;
use retune_linalg::Complex;

/// Digits of the ordinate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// Four bytes in binary; 13 columns in text.
    Single,
    /// Eight bytes in binary; 20 columns in text.
    Double,
}

/// Byte order of a binary dataset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ByteOrder {
    /// Least significant byte first.
    Little,
    /// Most significant byte first.
    Big,
}

/// How the values are stored in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Storage {
    /// Text, dataset 58.
    Ascii,
    /// Binary, dataset 58b.
    Binary {
        /// Byte order.
        order: ByteOrder,
        /// Representation of numbers.
        format: FloatFormat,
    },
}

/// Points of the abscissa.
#[derive(Debug, Clone, PartialEq)]
pub enum Abscissa {
    /// `start + i step`; no values stored.
    Even {
        /// First value.
        start: f64,
        /// Distance of the values.
        step: f64,
    },
    /// One value for each point.
    Uneven(Vec<f64>),
}

/// Values of the function.
#[derive(Debug, Clone, PartialEq)]
pub enum Ordinate {
    /// Real values.
    Real(Vec<f64>),
    /// Complex values.
    Complex(Vec<Complex<f64>>),
}

impl Ordinate {
    /// Number of points.
    pub fn len(&self) -> usize {
        match self {
            Ordinate::Real(v) => v.len(),
            Ordinate::Complex(v) => v.len(),
        }
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The values as complex numbers.
    pub fn to_complex(&self) -> Vec<Complex<f64>> {
        match self {
            Ordinate::Real(v) => v.iter().map(|re| Complex::new(*re, 0.0)).collect(),
            Ordinate::Complex(v) => v.clone(),
        }
    }
}

/// One end of a function: record 6, fields 5-7 or 8-10.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entity {
    /// Name of the component or group, `NONE` if unused.
    pub name: String,
    /// Node.
    pub node: i64,
    /// 0 scalar, ±1 ±2 ±3 translations, ±4 ±5 ±6 rotations, in the node's displacement axes.
    pub direction: i64,
}

/// Characteristics of one axis: records 8-11.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Axis {
    /// Specific data type: 8 displacement, 11 velocity, 12 acceleration, 13 excitation force, 17 time, 18 frequency, ...
    pub data_type: i64,
    /// Exponent of length in the unit; used with data type 1 only.
    pub length_exponent: i64,
    /// Exponent of force in the unit; used with data type 1 only.
    pub force_exponent: i64,
    /// Exponent of temperature in the unit; used with data type 1 only.
    pub temperature_exponent: i64,
    /// Label of the axis, `NONE` if unused.
    pub label: String,
    /// Unit as text, `NONE` if unused; when given it takes precedence over any other statement of the unit.
    pub units: String,
}

impl Axis {
    /// An axis of a data type, without label.
    pub fn of(data_type: i64) -> Self {
        let none = || "NONE".to_owned();
        let (length_exponent, force_exponent, temperature_exponent) = (0, 0, 0);
        Self { data_type, length_exponent, force_exponent, temperature_exponent, label: none(), units: none() }
    }
}

/// A measured function.
#[derive(Debug, Clone, PartialEq)]
pub struct Function {
    /// ID lines 1-5, without the blanks around them: description, run, date and time, load case, free.
    pub ids: [String; 5],
    /// 1 time response, 2 auto spectrum, 3 cross spectrum, 4 frequency response function, 6 coherence, 9 power
    /// spectral density, ...; kept as it stands, known or not.
    pub function_type: i64,
    /// Function identification number.
    pub function_id: i64,
    /// Version or sequence number.
    pub version: i64,
    /// Load case; 0 for single point excitation.
    pub load_case: i64,
    /// Response.
    pub response: Entity,
    /// Reference.
    pub reference: Entity,
    /// Digits of the ordinate.
    pub precision: Precision,
    /// Points.
    pub abscissa: Abscissa,
    /// Values.
    pub ordinate: Ordinate,
    /// Value on the z axis, 0 if unused.
    pub z_value: f64,
    /// Abscissa, ordinate (numerator), ordinate denominator, z axis.
    pub axes: [Axis; 4],
    /// Text or binary.
    pub storage: Storage,
}

impl Function {
    /// The abscissa of each point.
    pub fn points(&self) -> Vec<f64> {
        match &self.abscissa {
            Abscissa::Even { start, step } => (0..self.ordinate.len()).map(|i| start + i as f64 * step).collect(),
            Abscissa::Uneven(values) => values.clone(),
        }
    }
}
