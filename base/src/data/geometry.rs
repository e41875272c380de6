//! Geometry of a test: points, their axes, and lines that make a picture of them.

/// A measurement point.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Its name: the label of the node in a universal file.
    pub name: String,
    /// Position in global axes, m.
    pub position_m: [f64; 3],
    /// The axes of its displacements: unit vectors x, y, z in global axes.
    pub axes: [[f64; 3]; 3],
}

impl Point {
    /// Global axes.
    pub const GLOBAL: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
}

/// A polyline through points.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Line {
    /// Its name.
    pub name: String,
    /// Indices into [`Geometry::points`].
    pub points: Vec<usize>,
}

/// Geometry of a test.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Geometry {
    /// Points, each name once.
    pub points: Vec<Point>,
    /// Lines.
    pub lines: Vec<Line>,
}

impl Geometry {
    /// The point of a name.
    pub fn point(&self, name: &str) -> Option<&Point> {
        self.points.iter().find(|p| p.name == name)
    }
}
