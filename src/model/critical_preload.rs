//! The preload at which a structure buckles, and how it is told.

use super::value::quantity;
use crate::catalogue::counted;

/// The preload at which a structure buckles.
#[derive(Debug, Clone, PartialEq)]
pub struct CriticalPreload {
    /// How many times its preload it bears: below 1 it has buckled.
    pub factor: f64,
    /// Element with the largest compression.
    pub element: String,
    /// Path of its entry in the file, or of its section.
    pub path: String,
    /// Property that is the preload.
    pub property: &'static str,
    /// Its value, SI, compression negative.
    pub value: f64,
    /// Unit of it.
    pub unit: &'static str,
}

/// "the structure buckles under its preload: ..."
pub(super) fn buckled(critical: &CriticalPreload, n: usize) -> String {
    let CriticalPreload { factor, element, property, value, unit, .. } = critical;
    let motions = counted(n, "motion");
    let (stated, borne) = (quantity(*value, unit), quantity(factor * value, unit));
    if *factor < 1e-6 {
        return format!(
            "nothing holds the structure against a motion that its preload drives on, such as the rotation of a free column under compression (`{property}` of element `{element}` is {stated}): support that motion, or balance the compression by tension beside it"
        );
    }
    format!(
        "the structure buckles under its preload: `{property}` of element `{element}` is {stated}, and it bears {borne}, {factor:.4} of that (the stiffness is negative in {motions}); lower the compression, or stiffen the structure"
    )
}
