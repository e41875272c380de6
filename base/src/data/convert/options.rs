//! Answers to what universal files may leave open.

use super::frame::LocalAxes;
use super::units::UnitsFrom;
use crate::data::FrfQuantity;
use crate::units::FrequencyUnit;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What to do with several functions of one reference and response.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Duplicates {
    /// Ask.
    #[default]
    Ask,
    /// Keep the first.
    First,
    /// Keep the last.
    Last,
}

crate::catalogue::choice! { Duplicates, "rule";
    Ask "ask" "None counts: it is asked",
    First "first" "The first",
    Last "last" "The last",
}

/// Answers to what files may leave open.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FrfOptions {
    /// Where units come from.
    pub units: UnitsFrom,
    /// The quantity of functions that do not say theirs, and the one to read when there are several. It overrules what all functions
    /// say only beside [`UnitsFrom::System`], because the unit of another quantity says nothing of this one.
    pub quantity: Option<FrfQuantity>,
    /// The unit of frequencies; it counts before what the files say.
    pub frequency_unit: Option<FrequencyUnit>,
    /// Whether rows or columns of dataset 2420 are axes; by the program that wrote the file when absent.
    pub local_axes: Option<LocalAxes>,
    /// What to do with repeated functions.
    pub duplicates: Duplicates,
}
