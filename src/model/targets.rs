//! Mass properties that an update has to respect.

use super::geometry::constant;
use super::spec::{ModelSpec, TargetSpec};
use crate::yaml::{Problem, child};

/// A mass property that an update has to respect, in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// Value.
    pub value: f64,
    /// Half-width of the accepted range.
    pub tolerance: f64,
}

/// The mass properties that an update has to respect.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Targets {
    /// Total mass, kg.
    pub mass: Option<Target>,
    /// Centre of gravity along each axis, m.
    pub cg: [Option<Target>; 3],
    /// Moment of inertia about each axis through the centre of gravity, kg m².
    pub inertia: [Option<Target>; 3],
}

/// The targets of a model file.
pub(super) fn targets(spec: &ModelSpec, problems: &mut Vec<Problem>) -> Targets {
    let mut out = Targets::default();
    let Some(t) = &spec.targets else { return out };
    let read = |t: &TargetSpec, unit: &str, path: &str, problems: &mut Vec<Problem>| {
        let value = constant(&t.value, unit, &child(path, "value"), problems);
        let tolerance = constant(&t.tolerance, unit, &child(path, "tolerance"), problems);
        if tolerance <= 0.0 {
            problems.push(Problem::error(child(path, "tolerance"), "a tolerance must be above zero"));
        }
        Some(Target { value, tolerance })
    };
    if let Some(t) = &t.total_mass {
        out.mass = read(t, "kg", "targets.total_mass", problems);
    }
    for (list, slots, words, unit, path) in [
        (&t.cg, &mut out.cg, ["x", "y", "z"], "m", "targets.cg"),
        (&t.inertia, &mut out.inertia, ["xx", "yy", "zz"], "kg m2", "targets.inertia"),
    ] {
        for (axis, t) in list {
            let path = child(path, axis);
            match words.iter().position(|w| w == axis) {
                Some(i) => slots[i] = read(t, unit, &path, problems),
                None => problems.push(Problem::error(
                    path,
                    format_args!("unknown axis `{axis}`, expected `{}`, `{}` or `{}`", words[0], words[1], words[2]),
                )),
            }
        }
    }
    out
}
