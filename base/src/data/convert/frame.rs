//! Coordinate systems of datasets 18 and 2420.
//!
//! ```text
//! 18      x from the origin to the second point, z in the plane of the third, y = z × x
//! 2420    global = row 1 · x + row 2 · y + row 3 · z + row 4
//! ```
//!
//! The text of dataset 2420 does not say whether rows or columns of its matrix are the axes. Rows are what SDynPy (Sandia National
//! Laboratories) takes them for; LMS and Simcenter Test.Lab write columns: the same test in local and in global axes agrees with
//! columns alone, and so do the normals of surfaces in their files. [`LocalAxes`] states it; [`super::neighbours`] weighs it by the
//! geometry. Angles of cylindrical and spherical coordinates are in degrees.

use crate::data::Point;
use crate::data::uff::{CoordinateSystem, Dataset, PartSystem, UniversalFile};
use retune_linalg::vector3::{cross, dot, minus, unit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Which of the matrices of dataset 2420 are axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LocalAxes {
    /// Rows.
    Rows,
    /// Columns.
    Columns,
}

crate::catalogue::choice! { LocalAxes, "part of a matrix";
    Rows "rows" "Rows",
    Columns "columns" "Columns, as LMS and Simcenter Test.Lab write them",
}

impl LocalAxes {
    pub(super) fn other(self) -> Self {
        match self {
            Self::Rows => Self::Columns,
            Self::Columns => Self::Rows,
        }
    }
}

/// Which reading a file calls for, and why.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Reading {
    pub(super) axes: LocalAxes,
    pub(super) why: Why,
}

/// Why a reading was taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Why {
    /// The user says so.
    Option,
    /// The program that wrote the file is known.
    Program,
    /// Nothing says anything.
    Default,
}

/// How the matrices of a file are read.
pub(super) fn reading(file: &UniversalFile, option: Option<LocalAxes>) -> Reading {
    /// Programs that write rows.
    const ROWS: [&str; 2] = ["retune", "OpenModal"];
    if let Some(axes) = option {
        return Reading { axes, why: Why::Option };
    }
    for dataset in &file.datasets {
        let Dataset::Header(header) = dataset else { continue };
        let texts = [&header.program, &header.database_program, &header.description, &header.model_name];
        let is_testlab = texts.iter().any(|t| {
            let plain: String = t.chars().filter(char::is_ascii_alphanumeric).collect();
            plain.to_ascii_lowercase().contains("testlab")
        });
        if is_testlab {
            return Reading { axes: LocalAxes::Columns, why: Why::Program };
        }
        if ROWS.contains(&header.program.as_str()) {
            return Reading { axes: LocalAxes::Rows, why: Why::Program };
        }
    }
    Reading { axes: LocalAxes::Rows, why: Why::Default }
}

pub(super) type Vector = [f64; 3];

/// A coordinate system in global axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    /// 0 Cartesian, 1 cylindrical (r, θ in degrees, z), 2 spherical (r, θ from the z axis, φ, in degrees).
    kind: i64,
    origin: Vector,
    /// Unit vectors.
    pub(super) axes: [Vector; 3],
}

impl Frame {
    pub(super) const GLOBAL: Frame = Frame { kind: 0, origin: [0.0; 3], axes: Point::GLOBAL };

    /// Global position of coordinates in this frame.
    pub(super) fn position(&self, p: Vector) -> Vector {
        let local = match self.kind {
            1 => {
                let (s, c) = p[1].to_radians().sin_cos();
                [p[0] * c, p[0] * s, p[2]]
            }
            2 => {
                let ((s, c), (sp, cp)) = (p[1].to_radians().sin_cos(), p[2].to_radians().sin_cos());
                [p[0] * s * cp, p[0] * s * sp, p[0] * c]
            }
            _ => p,
        };
        self.point(local)
    }

    fn point(&self, local: Vector) -> Vector {
        std::array::from_fn(|i| self.origin[i] + (0..3).map(|j| local[j] * self.axes[j][i]).sum::<f64>())
    }

    /// The directions of the displacements of a node at a global position, as unit vectors in global axes.
    pub(super) fn axes_at(&self, position: Vector) -> [Vector; 3] {
        let from_origin = minus(position, self.origin);
        let local: Vector = std::array::from_fn(|j| dot(from_origin, self.axes[j]));
        let radius = local[0].hypot(local[1]);
        let (c, s) = if radius > 0.0 { (local[0] / radius, local[1] / radius) } else { (1.0, 0.0) };
        let to_global = |v: Vector| -> Vector { std::array::from_fn(|i| (0..3).map(|j| v[j] * self.axes[j][i]).sum()) };
        match self.kind {
            1 => [to_global([c, s, 0.0]), to_global([-s, c, 0.0]), to_global([0.0, 0.0, 1.0])],
            2 => {
                let r = radius.hypot(local[2]);
                let (st, ct) = if r > 0.0 { (radius / r, local[2] / r) } else { (0.0, 1.0) };
                [to_global([st * c, st * s, ct]), to_global([ct * c, ct * s, -st]), to_global([-s, c, 0.0])]
            }
            _ => self.axes,
        }
    }

    fn of_points(s: &CoordinateSystem, reference: &Frame) -> Option<Frame> {
        let [origin, x_point, xz_point] = s.points.map(|p| reference.position(p));
        let x = unit(minus(x_point, origin))?;
        let in_xz = minus(xz_point, origin);
        let along = dot(in_xz, x);
        let z = unit(std::array::from_fn(|i| in_xz[i] - along * x[i]))?;
        Some(Frame { kind: s.kind, origin, axes: [x, cross(z, x), z] })
    }

    pub(super) fn of_matrix(s: &PartSystem, reading: LocalAxes) -> Option<Frame> {
        let [x, y, z, origin] = s.rows;
        let [x, y, z] = match reading {
            LocalAxes::Rows => [x, y, z],
            LocalAxes::Columns => std::array::from_fn(|i| [x[i], y[i], z[i]]),
        };
        let axes = [unit(x)?, unit(y)?, unit(z)?];
        // Single-precision matrices are orthogonal to about 1e-7.
        let is_orthogonal = [(0, 1), (0, 2), (1, 2)].iter().all(|(i, j)| dot(axes[*i], axes[*j]).abs() < 1.0e-4);
        is_orthogonal.then_some(Frame { kind: s.kind, origin, axes })
    }
}

/// The frames of files by their numbers; those that make no sense are missing.
pub(super) fn frames(files: &[&UniversalFile], option: Option<LocalAxes>) -> BTreeMap<i64, Frame> {
    let mut by_points: BTreeMap<i64, &CoordinateSystem> = BTreeMap::new();
    let mut found = BTreeMap::from([(0, Frame::GLOBAL)]);
    let datasets = files.iter().flat_map(|f| {
        let axes = reading(f, option).axes;
        f.datasets.iter().map(move |d| (axes, d))
    });
    for (axes, dataset) in datasets {
        match dataset {
            Dataset::CoordinateSystems(list) => by_points.extend(list.iter().map(|s| (s.number, s))),
            Dataset::Part(part) => {
                found.extend(part.systems.iter().filter_map(|s| Some((s.label, Frame::of_matrix(s, axes)?))));
            }
            _ => {}
        }
    }
    // A system may refer to another that comes later: walk from the known ones to those that refer to them.
    let mut referring: BTreeMap<i64, Vec<&CoordinateSystem>> = BTreeMap::new();
    for system in by_points.into_values() {
        referring.entry(system.reference).or_default().push(system);
    }
    let mut known: Vec<i64> = found.keys().copied().collect();
    while let Some(number) = known.pop() {
        let reference = found[&number];
        for system in referring.remove(&number).unwrap_or_default() {
            if let Some(frame) = Frame::of_points(system, &reference) {
                found.insert(system.number, frame);
                known.push(system.number);
            }
        }
    }
    found
}

/// A node in global axes, in the units of its file.
pub(super) struct PlacedNode {
    pub(super) position: [f64; 3],
    /// Axes of its displacements.
    pub(super) axes: [[f64; 3]; 3],
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: Vector, b: Vector) -> bool {
        (0..3).all(|i| (a[i] - b[i]).abs() < 1.0e-15)
    }

    #[test]
    fn a_cylindrical_frame_has_radial_and_tangential_directions() {
        let frame = Frame { kind: 1, ..Frame::GLOBAL };
        assert!(close(frame.position([2.0, 90.0, 1.0]), [0.0, 2.0, 1.0]));
        let axes = frame.axes_at([0.0, 2.0, 1.0]);
        assert!(close(axes[0], [0.0, 1.0, 0.0]) && close(axes[1], [-1.0, 0.0, 0.0]) && close(axes[2], [0.0, 0.0, 1.0]));
    }

    #[test]
    fn a_spherical_frame_is_right_handed_everywhere() {
        let frame = Frame { kind: 2, ..Frame::GLOBAL };
        let p = frame.position([3.0, 40.0, 70.0]);
        let [r, theta, phi] = frame.axes_at(p);
        assert!(close(p, r.map(|x| 3.0 * x)));
        assert!(close(cross(r, theta), phi));
    }

    #[test]
    fn systems_by_points_follow_their_reference_in_any_order_and_loops_end() {
        let system = |number, reference, origin: Vector| CoordinateSystem {
            number,
            kind: 0,
            reference,
            color: 0,
            method: 1,
            name: String::new(),
            // x along global -x and z along global -z, as in a file of LMS Test.Lab.
            points: [origin, minus(origin, [1.0, 0.0, 0.0]), minus(origin, [1.0, 0.0, 1.0])],
        };
        let list = vec![system(1, 2, [1.0, 0.0, 0.0]), system(2, 0, [5.0, 0.0, 0.0]), system(3, 3, [0.0; 3])];
        let file = UniversalFile { datasets: vec![Dataset::CoordinateSystems(list)] };
        let found = frames(&[&file], None);
        assert_eq!(found.len(), 3);
        assert!(close(found[&2].axes[0], [-1.0, 0.0, 0.0]) && close(found[&2].axes[1], [0.0, 1.0, 0.0]));
        assert!(close(found[&1].origin, [4.0, 0.0, 0.0]) && close(found[&1].axes[0], [1.0, 0.0, 0.0]));
    }
}
