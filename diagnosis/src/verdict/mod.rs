//! From what was found to an answer: probabilities, a verdict in words, warnings, and the next measurement.

pub(crate) mod decide;
pub(crate) mod next_measurement;
pub(crate) mod pairs;
pub(crate) mod posterior;
pub(crate) mod so_far;
pub(crate) mod warnings;
pub(crate) mod words;
