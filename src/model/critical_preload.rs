//! The preload at which a structure buckles, and how it is told.

use super::value::quantity;

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
    let motions = if n == 1 { "1 motion".to_string() } else { format!("{n} motions") };
    let (stated, borne) = (quantity(*value, unit), quantity(factor * value, unit));
    if *factor < 1e-6 {
        return format!(
            "the structure has a motion that nothing but its preload resists, and the preload drives it on (`{property}` of element `{element}` is {stated}): support that motion, or balance the compression by tension beside it"
        );
    }
    format!(
        "the structure buckles under its preload: `{property}` of element `{element}` is {stated}, and it bears {borne}, {factor:.4} of that (the stiffness is negative in {motions}); lower the compression, or stiffen the structure"
    )
}
