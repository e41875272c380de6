//! Systems of units of decks: a deck has numbers and no units.

use retune::units::Unit;

/// What a number of a deck measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Quantity {
    Number,
    Length,
    Area,
    SecondMoment,
    Mass,
    MassPerLength,
    MassPerArea,
    Density,
    /// Mass times length.
    MassMoment,
    /// Mass times length squared.
    Inertia,
    Stress,
    Stiffness,
    RotationalStiffness,
    Damping,
    RotationalDamping,
    /// Mass times length squared by length.
    InertiaPerLength,
    /// Degrees in every system.
    Angle,
}

/// Every quantity, in the order of [`System::units`].
const QUANTITIES: usize = 17;

/// A coherent system of units, time in seconds.
#[derive(Debug, PartialEq)]
pub struct System {
    /// Its word: `in-lbf-s`.
    pub name: &'static str,
    /// One line: which units.
    pub summary: &'static str,
    /// Unit of each quantity in its order, as texts of a model file.
    pub units: [&'static str; QUANTITIES],
}

/// The systems that a deck can be said to be in.
pub const SYSTEMS: &[System] = &[
    System {
        name: "si",
        summary: "metre, newton, kilogram",
        units: [
            "",
            "m",
            "m2",
            "m4",
            "kg",
            "kg/m",
            "kg/m2",
            "kg/m3",
            "kg m",
            "kg m2",
            "Pa",
            "N/m",
            "N m/rad",
            "N s/m",
            "N m s/rad",
            "kg m",
            "deg",
        ],
    },
    System {
        name: "mm-t-s",
        summary: "millimetre, newton, tonne",
        units: [
            "",
            "mm",
            "mm2",
            "mm4",
            "t",
            "t/mm",
            "t/mm2",
            "t/mm3",
            "t mm",
            "t mm2",
            "MPa",
            "N/mm",
            "N mm/rad",
            "N s/mm",
            "N mm s/rad",
            "t mm",
            "deg",
        ],
    },
    System {
        name: "in-lbf-s",
        summary: "inch, pound-force, slinch (lbf s2/in; a deck in pounds of mass has WTMASS 0.00259)",
        units: [
            "",
            "in",
            "in2",
            "in4",
            "slinch",
            "slinch/in",
            "slinch/in2",
            "slinch/in3",
            "slinch in",
            "slinch in2",
            "psi",
            "lbf/in",
            "lbf in/rad",
            "lbf s/in",
            "lbf in s/rad",
            "slinch in",
            "deg",
        ],
    },
    System {
        name: "ft-lbf-s",
        summary: "foot, pound-force, slug (a deck in pounds of mass has WTMASS 0.0311)",
        units: [
            "",
            "ft",
            "ft2",
            "ft4",
            "slug",
            "slug/ft",
            "slug/ft2",
            "slug/ft3",
            "slug ft",
            "slug ft2",
            "lbf/ft2",
            "lbf/ft",
            "lbf ft/rad",
            "lbf s/ft",
            "lbf ft s/rad",
            "slug ft",
            "deg",
        ],
    },
];

/// The system of this name, in any case.
pub fn system_by_name(name: &str) -> Option<&'static System> {
    SYSTEMS.iter().find(|s| s.name.eq_ignore_ascii_case(name))
}

impl System {
    /// Unit of a quantity as text; empty for a number.
    pub fn unit(&self, quantity: Quantity) -> &'static str {
        self.units[quantity as usize]
    }

    /// Value in SI of one unit of it.
    pub fn factor(&self, quantity: Quantity) -> f64 {
        match self.unit(quantity) {
            "" => 1.0,
            text => Unit::parse(text).map_or(f64::NAN, |u| u.factor),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Quantity as Q;

    /// A system is coherent: force is mass times length by time squared, and every other unit is made of these.
    #[test]
    fn systems_are_coherent() {
        for s in SYSTEMS {
            let (l, m) = (s.factor(Q::Length), s.factor(Q::Mass));
            let expected = [
                1.0,
                l,
                l.powi(2),
                l.powi(4),
                m,
                m / l,
                m / l.powi(2),
                m / l.powi(3),
                m * l,
                m * l * l,
                m / l,
                m,
                m * l * l,
                m,
                m * l * l,
                m * l,
                1_f64.to_radians(),
            ];
            for (i, expected) in expected.into_iter().enumerate() {
                let unit = if s.units[i].is_empty() { 1.0 } else { Unit::parse(s.units[i]).unwrap().factor };
                assert!((unit / expected - 1.0).abs() < 1e-12, "{} {}", s.name, s.units[i]);
            }
            assert_eq!(system_by_name(&s.name.to_uppercase()), Some(s));
        }
    }
}
