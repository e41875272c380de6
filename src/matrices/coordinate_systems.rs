//! Coordinate systems of bulk data: CORD2R, CORD2C, CORD2S, each given by three points in another.
//!
//! Source: MSC.Nastran Quick Reference Guide, CORD2R, CORD2C, CORD2S, GRID.

use crate::linalg::vector3::{Vector3, cross, dot, minus, unit};
use std::collections::HashMap;

/// Directions of axes as rows.
pub(super) type Axes = [Vector3; 3];

pub(super) const BASIC: Axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// What its coordinates are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Rectangular,
    /// r, θ in degrees, z.
    Cylindrical,
    /// r, θ from z, φ about z, in degrees.
    Spherical,
}

/// A card: its reference system, and the origin, a point on z and a point in the x-z plane there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Card {
    pub(super) kind: Kind,
    pub(super) reference: i64,
    pub(super) points: [Vector3; 3],
}

/// A system in the basic one.
#[derive(Debug, Clone, Copy)]
struct System {
    kind: Kind,
    origin: Vector3,
    axes: Axes,
}

/// All systems of a deck.
#[derive(Debug, Default)]
pub(super) struct Systems {
    cards: HashMap<i64, Card>,
}

impl Systems {
    pub(super) fn add(&mut self, number: i64, card: Card) {
        self.cards.insert(number, card);
    }

    /// A system by its number; `None` where it, or one that it refers to, is not there, or is none.
    fn system(&self, number: i64) -> Option<System> {
        let mut chain = Vec::new();
        let mut next = number;
        while next != 0 {
            let card = self.cards.get(&next)?;
            // A chain that is longer than the deck has systems is a circle.
            if chain.len() >= self.cards.len() {
                return None;
            }
            chain.push(card);
            next = card.reference;
        }
        let mut system = System { kind: Kind::Rectangular, origin: [0.0; 3], axes: BASIC };
        for card in chain.into_iter().rev() {
            let [origin, on_z, in_xz] = card.points.map(|p| system.place(p));
            let z = unit(minus(on_z, origin))?;
            let y = unit(cross(z, minus(in_xz, origin)))?;
            system = System { kind: card.kind, origin, axes: [cross(y, z), y, z] };
        }
        Some(system)
    }

    /// A place in the basic system.
    pub(super) fn place(&self, number: i64, at: Vector3) -> Option<Vector3> {
        Some(self.system(number)?.place(at))
    }

    /// The directions of displacements at a place of the basic system.
    pub(super) fn axes(&self, number: i64, at: Vector3) -> Option<Axes> {
        let System { kind, origin, axes } = self.system(number)?;
        if kind == Kind::Rectangular {
            return Some(axes);
        }
        let from = minus(at, origin);
        let [x, y, z] = axes.map(|a| dot(a, from));
        // On the axis r points along x.
        let angle = if x.hypot(y) > 0.0 { y.atan2(x) } else { 0.0 };
        let (s, c) = angle.sin_cos();
        let radial = combine(axes, [c, s, 0.0]);
        let around = combine(axes, [-s, c, 0.0]);
        if kind == Kind::Cylindrical {
            return Some([radial, around, axes[2]]);
        }
        let (t, d) = x.hypot(y).atan2(z).sin_cos();
        let out = |radially: f64, along: f64| std::array::from_fn(|i| radially * radial[i] + along * axes[2][i]);
        Some([out(t, d), out(d, -t), around])
    }
}

impl System {
    fn place(&self, [a, b, c]: Vector3) -> Vector3 {
        let local = match self.kind {
            Kind::Rectangular => [a, b, c],
            Kind::Cylindrical => {
                let (sin, cos) = b.to_radians().sin_cos();
                [a * cos, a * sin, c]
            }
            Kind::Spherical => {
                let ((t, d), (s, k)) = (b.to_radians().sin_cos(), c.to_radians().sin_cos());
                [a * t * k, a * t * s, a * d]
            }
        };
        let from = combine(self.axes, local);
        std::array::from_fn(|i| self.origin[i] + from[i])
    }
}

fn combine(axes: Axes, [a, b, c]: Vector3) -> Vector3 {
    std::array::from_fn(|i| a * axes[0][i] + b * axes[1][i] + c * axes[2][i])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn systems_stand_in_each_other() {
        let mut systems = Systems::default();
        // Turned about z by 90 degrees at x = 1; a cylinder in it, moved along its y.
        let turned = [[1.0, 0.0, 0.0], [1.0, 0.0, 1.0], [1.0, 1.0, 0.0]];
        systems.add(5, Card { kind: Kind::Rectangular, reference: 0, points: turned });
        let cylinder = [[0.0, 2.0, 0.0], [0.0, 2.0, 1.0], [1.0, 2.0, 0.0]];
        systems.add(7, Card { kind: Kind::Cylindrical, reference: 5, points: cylinder });
        systems
            .add(8, Card { kind: Kind::Spherical, reference: 0, points: [[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]] });
        let near = |a: Option<Vector3>, b: Vector3| a.unwrap().iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-15);
        assert!(near(systems.place(5, [1.0, 2.0, 3.0]), [-1.0, 1.0, 3.0]));
        assert!(near(systems.place(7, [0.5, 90.0, 0.0]), [-1.5, 0.0, 0.0]));
        let axes = systems.axes(7, [-1.5, 0.0, 0.0]).unwrap();
        assert!(near(Some(axes[0]), [-1.0, 0.0, 0.0]) && near(Some(axes[1]), [0.0, -1.0, 0.0]), "{axes:?}");
        assert!(near(systems.place(8, [2.0, 90.0, 90.0]), [0.0, 2.0, 0.0]));
        let axes = systems.axes(8, [0.0, 2.0, 0.0]).unwrap();
        assert!(near(Some(axes[0]), [0.0, 1.0, 0.0]) && near(Some(axes[1]), [0.0, 0.0, -1.0]), "{axes:?}");
        systems.add(9, Card { kind: Kind::Rectangular, reference: 10, points: turned });
        systems.add(10, Card { kind: Kind::Rectangular, reference: 9, points: turned });
        assert!(systems.place(9, [0.0; 3]).is_none() && systems.place(11, [0.0; 3]).is_none());
    }
}
