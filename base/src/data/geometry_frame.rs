//! Where the axes of a test geometry lie in those of the model.

use super::yaml::DirectionSpec;
use super::{FrfSet, Geometry, ModalSet};
use crate::units::Scalar;
use crate::yaml;
use retune_linalg::vector3::cross;
use serde::Deserialize;

/// A rigid frame: origin and axes of a geometry in global axes of the model.
///
/// ```text
/// p_model = origin + R p_geometry,   d_model = R d_geometry,   R = [x y z], orthonormal, right-handed
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GeometryFrame {
    /// Position of the geometry's origin in the model, m.
    pub origin_m: [f64; 3],
    /// The geometry's axes x, y, z as unit vectors in the model.
    pub axes: [[f64; 3]; 3],
}

/// As it is written: `{origin: [1 m, 0 m, 0 m], x: -y, z: +z}`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct FrameSpec {
    #[serde(default)]
    origin: Option<[Scalar; 3]>,
    x: Option<DirectionSpec>,
    y: Option<DirectionSpec>,
    z: Option<DirectionSpec>,
}

impl GeometryFrame {
    /// Reads `{origin: [..], x: .., y: ..}`: two of the three axes, each an axis of the model with a sign or a vector. The first
    /// of the two is kept, the other is turned to a right angle with it, and the third completes a right-handed frame.
    ///
    /// # Errors
    /// What is wrong, in a sentence.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (spec, _) = yaml::read::<FrameSpec>(text)
            .map_err(|problems| problems.iter().map(|p| p.message.clone()).collect::<Vec<_>>().join("; "))?;
        let mut origin_m = [0.0; 3];
        for (value, scalar) in origin_m.iter_mut().zip(spec.origin.iter().flatten()) {
            *value = scalar.constant_in("m").map_err(|e| format!("origin: {e}"))?;
        }
        let given: Vec<(usize, [f64; 3])> =
            [spec.x, spec.y, spec.z].iter().enumerate().filter_map(|(i, d)| Some((i, d.as_ref()?.0))).collect();
        let [(i, a), (j, b)] = given[..] else {
            return Err(format!("give two of the axes x, y, z of the geometry, not {}", given.len()));
        };
        let along: f64 = a.iter().zip(&b).map(|(p, q)| p * q).sum();
        let rest: [f64; 3] = std::array::from_fn(|k| b[k] - along * a[k]);
        let length = rest.iter().map(|v| v * v).sum::<f64>().sqrt();
        // Axes that are drawn at right angles are given to a few digits.
        if length < 0.5 {
            return Err("the two axes are nearly parallel".to_string());
        }
        let b = rest.map(|v| v / length);
        let third = 3 - i - j;
        let mut axes = [[0.0; 3]; 3];
        (axes[i], axes[j]) = (a, b);
        // x y z, y z x and z x y are right-handed.
        axes[third] = if (i + 1) % 3 == j { cross(a, b) } else { cross(b, a) };
        Ok(Self { origin_m, axes })
    }

    /// A direction of the geometry in the model's axes.
    pub fn direction(&self, d: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| (0..3).map(|j| d[j] * self.axes[j][i]).sum())
    }

    /// A position of the geometry in the model, m.
    pub fn position(&self, p: [f64; 3]) -> [f64; 3] {
        let turned = self.direction(p);
        std::array::from_fn(|i| self.origin_m[i] + turned[i])
    }

    /// Moves the points of a geometry into the model.
    pub fn place(&self, geometry: &mut Geometry) {
        for point in &mut geometry.points {
            point.position_m = self.position(point.position_m);
            point.axes = point.axes.map(|a| self.direction(a));
        }
    }

    /// Turns the channels of functions.
    pub fn turn_functions(&self, set: &mut FrfSet) {
        for channel in set.references.iter_mut().chain(&mut set.responses) {
            channel.direction = channel.direction.map(|d| self.direction(d));
        }
    }

    /// Turns the channels of modes.
    pub fn turn_modes(&self, modes: &mut ModalSet) {
        for channel in &mut modes.channels {
            channel.direction = self.direction(channel.direction);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_axes_and_an_origin_make_a_right_handed_frame() {
        let f = GeometryFrame::parse("{origin: [1 m, 200 cm, 0 m], x: -y, z: +z}").unwrap();
        assert_eq!(f.axes, [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
        assert_eq!(f.position([1.0, 2.0, 3.0]), [3.0, 1.0, 3.0]);
        let f = GeometryFrame::parse("{y: [3, -4, 0], z: +z}").unwrap();
        assert_eq!(f.axes[1], [0.6, -0.8, 0.0]);
        let det: f64 = (0..3).map(|k| cross(f.axes[0], f.axes[1])[k] * f.axes[2][k]).sum();
        assert!((det - 1.0).abs() < 1e-15);
    }

    #[test]
    fn a_frame_that_is_none_is_explained() {
        for (text, word) in [
            ("{x: +x}", "two of the axes"),
            ("{x: +x, y: +y, z: +z}", "not 3"),
            ("{x: +x, y: -x}", "parallel"),
            ("{x: +x, q: 1}", "q"),
            ("{x: up, y: +y}", "up"),
            ("{origin: [1 kg, 0 m, 0 m], x: +x, y: +y}", "origin"),
            ("[", ""),
        ] {
            let error = GeometryFrame::parse(text).unwrap_err();
            assert!(error.contains(word) && !error.is_empty(), "{text}: {error}");
        }
    }
}
