//! Units of files of matrices.

use crate::element::Dof;
use crate::model::spec::UnitsSpec;
use crate::units::Scalar;
use crate::yaml::{Problem, child};

/// SI values of the units of a superelement's files.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Units {
    pub(super) length: f64,
    force: f64,
    mass: f64,
    time: f64,
}

impl Units {
    /// Force and mass follow from each other, F = m l/t², where one of them is not said.
    pub(super) fn of(spec: Option<&UnitsSpec>, path: &str, problems: &mut Vec<Problem>) -> Option<Self> {
        let mut value = |key: &str, unit: Option<&String>, expected: &str| -> Result<Option<f64>, ()> {
            let Some(unit) = unit else { return Ok(None) };
            let read = Scalar::parse(&format!("1 {unit}")).and_then(|s| s.constant_in(expected));
            let why = match read {
                Ok(value) if value > 0.0 => return Ok(Some(value)),
                Ok(_) => "a unit must be above zero".to_string(),
                Err(e) => e.to_string(),
            };
            problems.push(Problem::error(child(path, key), why));
            Err(())
        };
        let spec = spec.cloned().unwrap_or_default();
        let length = value("length", spec.length.as_ref(), "m").ok()?.unwrap_or(1.0);
        let time = value("time", spec.time.as_ref(), "s").ok()?.unwrap_or(1.0);
        let force = value("force", spec.force.as_ref(), "N").ok()?;
        let mass = value("mass", spec.mass.as_ref(), "kg").ok()?;
        let acceleration = length / (time * time);
        let (force, mass) = match (force, mass) {
            (Some(force), Some(mass)) => (force, mass),
            (Some(force), None) => (force, force / acceleration),
            (None, Some(mass)) => (mass * acceleration, mass),
            (None, None) if spec.length.is_none() && spec.time.is_none() => (1.0, 1.0),
            (None, None) => {
                problems.push(Problem::error(
                    path,
                    "a unit of length does not tell the others: give `force` or `mass` too",
                ));
                return None;
            }
        };
        Some(Self { length, force, mass, time })
    }

    /// Value of a dof in the files for one in SI; coordinates and angles are the same.
    pub(super) fn to_file(self, dof: Option<Dof>) -> f64 {
        match dof {
            Some(dof) if !dof.is_rotation() => 1.0 / self.length,
            _ => 1.0,
        }
    }

    /// The unit of u K u.
    pub(super) fn stiffness(&self) -> f64 {
        self.force * self.length
    }

    /// The unit of u M u.
    pub(super) fn mass(&self) -> f64 {
        self.mass * self.length * self.length
    }

    /// The unit of u C u.
    pub(super) fn damping(&self) -> f64 {
        self.force * self.length * self.time
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(length: &str, force: Option<&str>, mass: Option<&str>) -> Units {
        let text = |t: &str| Some(t.to_string());
        let spec =
            UnitsSpec { length: text(length), force: force.and_then(text), mass: mass.and_then(text), time: None };
        Units::of(Some(&spec), "u", &mut Vec::new()).unwrap()
    }

    #[test]
    fn force_and_mass_follow_from_each_other() {
        let by_force = of("mm", Some("N"), None);
        assert!((by_force.mass - 1000.0).abs() < 1e-9, "{by_force:?}");
        let by_mass = of("mm", None, Some("t"));
        assert!((by_mass.force - 1.0).abs() < 1e-12, "{by_mass:?}");
        // N/mm is 1000 N/m.
        let k = by_force.stiffness() * by_force.to_file(Some(Dof::Ux)).powi(2);
        assert!((k - 1000.0).abs() < 1e-9, "{k}");
        let mut problems = Vec::new();
        let spec = UnitsSpec { length: Some("mm".into()), ..UnitsSpec::default() };
        assert!(Units::of(Some(&spec), "u", &mut problems).is_none() && problems.len() == 1);
        assert_eq!(Units::of(None, "u", &mut problems).unwrap().mass(), 1.0);
    }
}
