//! What an element declares about its properties, and the values it is given.

use super::{Element, ElementError};

/// The values a property may take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Domain {
    /// Above zero.
    Positive,
    /// Zero or above.
    NonNegative,
    /// From zero to one.
    Fraction,
    /// Zero or above, infinity too: a compliance, which is then a release.
    Compliance,
    /// Any finite number.
    Any,
}

impl Domain {
    /// Whether `value` belongs to it.
    pub fn contains(self, value: f64) -> bool {
        match self {
            Domain::Positive => value.is_finite() && value > 0.0,
            Domain::NonNegative => value.is_finite() && value >= 0.0,
            Domain::Compliance => value >= 0.0,
            Domain::Fraction => (0.0..=1.0).contains(&value),
            Domain::Any => value.is_finite(),
        }
    }

    /// What a value must be, in words.
    pub fn expected(self) -> &'static str {
        match self {
            Domain::Positive => "a finite number above zero",
            Domain::NonNegative => "a finite number, zero or above",
            Domain::Fraction => "between 0 and 1",
            Domain::Compliance => "zero or above",
            Domain::Any => "a finite number",
        }
    }
}

/// One property of an element: a word in YAML, its unit and what it may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Property {
    /// The word in YAML. One that begins with `end1_` or `end2_` is of an end: of the elements of a member only the first or the last has
    /// it.
    pub name: &'static str,
    /// Its SI unit as text: words of `kg m s N Pa rad` with exponents, at most one slash (`"Pa"`, `"kg m2"`,
    /// `"rad/(N m)"`), or `"1"`. [`super::conformance`] holds the matrices to it.
    pub unit: &'static str,
    /// Admissible values.
    pub domain: Domain,
    /// One line for people.
    pub description: &'static str,
}

impl Property {
    /// A property; the four fields in order.
    pub const fn new(name: &'static str, unit: &'static str, domain: Domain, description: &'static str) -> Self {
        Self { name, unit, domain, description }
    }
}

/// What an element is built from: geometry in element axes and its property values.
#[derive(Debug, Clone, Copy)]
pub struct ElementInput<'a> {
    /// Position of each node in element axes, relative to the first node, m.
    pub points: &'a [[f64; 3]],
    /// Value of each property of [`Element::properties`], in that order and in SI; `None` where the file says nothing.
    pub values: &'a [Option<f64>],
}

impl ElementInput<'_> {
    /// Length between the first and the second node, m; zero for an element with one node.
    pub fn length(&self) -> f64 {
        let [x, y, z] = self.points.get(1).copied().unwrap_or_default();
        x.hypot(y).hypot(z)
    }

    /// Refuses a wrong number of nodes or values, a coordinate that is not finite and every value outside its property's [`Domain`]: after it, an
    /// element may index `points` and `values` by its own declaration.
    pub fn check(&self, element: &dyn Element) -> Result<(), ElementError> {
        let (nodes, properties) = (element.nodes(), element.properties());
        if self.points.len() != nodes.len() {
            return Err(ElementError::NodeCount { expected: nodes.len(), given: self.points.len() });
        }
        if self.values.len() != properties.len() {
            return Err(ElementError::ValueCount { expected: properties.len(), given: self.values.len() });
        }
        if let Some(i) = self.points.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
            return Err(ElementError::PointNotFinite { node: i + 1 });
        }
        let outside = properties.iter().zip(self.values).find_map(|(p, v)| match v {
            Some(value) if !p.domain.contains(*value) => {
                Some(ElementError::OutOfDomain { name: p.name, value: *value, expected: p.domain.expected() })
            }
            _ => None,
        });
        outside.map_or(Ok(()), Err)
    }

    /// The length, m, of an element that needs one.
    pub(crate) fn positive_length(&self) -> Result<f64, ElementError> {
        let length = self.length();
        // Below 1e-150 m the cube of the length is not a number a stiffness can be divided by.
        if length.is_finite() && length > 1e-150 { Ok(length) } else { Err(ElementError::ZeroLength) }
    }
}

/// A typical input of an element: geometry, some of its properties by name, and what is known of the result.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// Position of each node in element axes, relative to the first node, m.
    pub points: Vec<[f64; 3]>,
    /// Properties and their values, SI; the others are absent.
    pub given: Vec<(&'static str, f64)>,
    /// Total mass that the mass matrix must have, kg.
    pub mass: f64,
    /// Whether moving the element as a rigid body costs no energy; not so when it is grounded or preloaded.
    pub free: bool,
}

impl Sample {
    /// The values in the order of `properties`, as [`ElementInput::values`] wants them.
    pub fn values(&self, properties: &[Property]) -> Result<Vec<Option<f64>>, ElementError> {
        let mut values = vec![None; properties.len()];
        for &(name, value) in &self.given {
            let index = properties.iter().position(|p| p.name == name).ok_or(ElementError::UnknownProperty { name })?;
            values[index] = Some(value);
        }
        Ok(values)
    }
}

/// Index of the property `name`, for use in a constant: a misspelt name then does not compile.
///
/// ```
/// use retune::element::{Domain, Property, property_index};
/// const PROPERTIES: &[Property] = &[Property::new("mass", "kg", Domain::NonNegative, "mass")];
/// const MASS: usize = property_index(PROPERTIES, "mass");
/// ```
///
/// # Panics
/// If there is no such property: at compile time, when used as above.
pub const fn property_index(properties: &[Property], name: &str) -> usize {
    let mut i = 0;
    while i < properties.len() {
        if same(properties[i].name.as_bytes(), name.as_bytes()) {
            return i;
        }
        i += 1;
    }
    panic!("no property has this name")
}

/// Equality of strings in constants.
const fn same(a: &[u8], b: &[u8]) -> bool {
    if a.len() != b.len() {
        return false;
    }
    let mut i = 0;
    while i < a.len() {
        if a[i] != b[i] {
            return false;
        }
        i += 1;
    }
    true
}

/// `value!(input, E)`: the value of the property `E` of the caller's `PROPERTIES`, looked up when compiling.
macro_rules! value {
    ($input:expr, $name:ident) => {
        $input.values[const { $crate::element::property_index(PROPERTIES, stringify!($name)) }]
    };
}
pub(crate) use value;
