//! Elements whose nodes stand where parameters say.
//!
//! The dofs of a model stay those at the estimates; what moves is in the matrices. An element is asked for them where it stands at θ, and they are
//! brought back to the axes and the ends that it has at the estimates:
//!
//! ```text
//! K(θ) = Bᵀ K_θ B,    u_θ = R_θ R_0ᵀ u + R_θ ((R_0ᵀ φ) × b),    φ_θ = R_θ R_0ᵀ φ
//! ```
//!
//! R are its axes (rows), u and φ the displacement and the rotation of an end, b the rigid arm from the point that the dofs stand for to where the end
//! is. That point is the node at the estimates, so that rigid motions do not depend on θ. A node that is held, constrained or without rotations has no
//! such arm: its dofs ride with it, and b is what has been added to the arm of a rigid link at most. Rigid motions then depend on θ, and a structure that
//! has some refuses it.

use super::PointMotion;
use super::affine::Affine;
use super::geometry::{GLOBAL, Rotation, Vector, axes_along, cross, dot, minus, plus, turned};
use super::rounding::clean;
use super::value::Value;
use crate::element::{Axes, ElementError};
use crate::linalg::{DMatrix, SymMatrix};
use std::borrow::Cow;

/// How one end moves.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct EndMotion {
    /// How far its node moves, global, m.
    pub(super) own: [Value; 3],
    /// How far the node moves that carries it by rigid links: itself, where none does.
    pub(super) root: [Value; 3],
    /// Whether the dofs are those of the carrying node where it stands; else they stay those of the point at the estimates, which a rigid arm joins to
    /// it, so that rigid motions of the structure do not depend on θ.
    pub(super) rides: bool,
}

impl EndMotion {
    /// The same with other expressions.
    pub(super) fn map(&self, of: impl Fn(&Value) -> Value) -> Self {
        let all = |v: &[Value; 3]| [0, 1, 2].map(|i| of(&v[i]));
        Self { own: all(&self.own), root: all(&self.root), rides: self.rides }
    }

    /// Whether it depends on some parameters.
    pub(super) fn depends_on(&self, parameters: &[usize]) -> bool {
        self.own.iter().chain(&self.root).flat_map(Value::parameters).any(|p| parameters.contains(&p))
    }

    /// How far the point moves that its dofs stand for, and how far the end lies beside that point then, global, m.
    pub(super) fn at(&self, theta: &[f64]) -> [Vector; 2] {
        let own = at(&self.own, theta);
        if !self.rides {
            return [[0.0; 3], own];
        }
        let root = at(&self.root, theta);
        [root, minus(own, root)]
    }
}

/// How the ends of an element move.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Moving {
    /// By end.
    ends: Vec<EndMotion>,
    /// The direction near its z axis, where its x axis follows its nodes.
    near: Vector,
}

/// Three expressions.
pub(super) fn expressions(of: [Affine; 3]) -> [Value; 3] {
    of.map(Value::of)
}

impl Moving {
    pub(super) fn new(ends: Vec<EndMotion>, near: Vector) -> Self {
        Self { ends, near }
    }

    pub(super) fn expressions(&self) -> impl Iterator<Item = &Value> {
        self.ends.iter().flat_map(|end| end.own.iter().chain(&end.root))
    }

    /// The same with other expressions; `None` where nothing moves then.
    pub(super) fn map(&self, of: impl Fn(&Value) -> Value) -> Option<Self> {
        let mapped = Self { ends: self.ends.iter().map(|e| e.map(&of)).collect(), near: self.near };
        let stays = |v: &Value| v.parameters().next().is_none() && v.at(&[]) == 0.0;
        let moves = !mapped.expressions().all(stays);
        moves.then_some(mapped)
    }

    /// With other answers to what rides.
    ///
    /// * `rides` - of each end; `None` where it stays as it is
    pub(super) fn riding(mut self, rides: impl Fn(usize) -> Option<bool>) -> Self {
        for (k, end) in self.ends.iter_mut().enumerate() {
            end.rides = rides(k).unwrap_or(end.rides);
        }
        self
    }

    /// Moves ends to where they are.
    pub(super) fn step(&self, ends: &mut [Vector], theta: &[f64]) {
        for (place, end) in ends.iter_mut().zip(&self.ends) {
            *place = plus(*place, 1.0, at(&end.own, theta));
        }
    }

    /// Moves the points that the dofs stand for.
    pub(super) fn carry(&self, ends: &mut [Vector], theta: &[f64]) {
        for (place, end) in ends.iter_mut().zip(&self.ends) {
            *place = plus(*place, 1.0, end.at(theta)[0]);
        }
    }
}

impl PointMotion {
    /// The motion of a node by the rows of K, from that at the estimates.
    ///
    /// * `rows`, `position` - of the six dofs where the node is at the estimates
    /// * `carried`, `beside` - see [`EndMotion::at`]
    pub(super) fn displaced(
        mut rows: [Vec<(usize, f64)>; 6],
        position: Vector,
        [carried, beside]: [Vector; 2],
    ) -> PointMotion {
        for (turn, axis) in GLOBAL.iter().enumerate() {
            let turned = rows[3 + turn].clone();
            for (row, lever) in rows[..3].iter_mut().zip(cross(*axis, beside)).filter(|(_, lever)| *lever != 0.0) {
                row.extend(turned.iter().map(|&(row, factor)| (row, lever * factor)));
            }
        }
        PointMotion { rows, position: plus(plus(position, 1.0, carried), 1.0, beside) }
    }
}

fn at(v: &[Value; 3], theta: &[f64]) -> Vector {
    [0, 1, 2].map(|i| v[i].at(theta))
}

/// Where an element stands.
pub(super) struct Stand<'a> {
    /// Positions of its nodes in its axes, relative to the first, m.
    pub(super) points: Cow<'a, [[f64; 3]]>,
    /// Its axes.
    pub(super) axes: Rotation,
    /// B, (6 nodes x 6 nodes); `None` where it stands as at the estimates.
    back: Option<DMatrix<f64>>,
}

impl<'a> Stand<'a> {
    /// Of an element that does not move.
    pub(super) fn still(points: &'a [[f64; 3]], axes: Rotation) -> Self {
        Self { points: Cow::Borrowed(points), axes, back: None }
    }
}

impl Moving {
    /// Where an element stands at θ.
    ///
    /// * `kind` - how its axes follow from its nodes
    /// * `points` - positions of its nodes at the estimates, in its axes there, relative to the first, m
    /// * `turn` - of its section about x, rad
    ///
    /// # Errors
    /// It has no length there, or lies along the direction that its z axis is to be near.
    pub(super) fn stand(
        &self,
        kind: Axes,
        (points, from): (&[[f64; 3]], &Rotation),
        turn: f64,
        theta: &[f64],
    ) -> Result<Stand<'static>, ElementError> {
        let beside: Vec<Vector> = self.ends.iter().map(|end| end.at(theta)[1]).collect();
        let steps = self.ends.iter().map(|end| at(&end.own, theta));
        // Relative to the first end at the estimates, global.
        let to_global = |p: &Vector| (0..3).fold([0.0; 3], |sum, i| plus(sum, p[i], from[i]));
        let ends: Vec<Vector> = points.iter().zip(steps).map(|(p, step)| plus(to_global(p), 1.0, step)).collect();
        let axes = match kind {
            Axes::Given => *from,
            Axes::AlongNodes => {
                let along = minus(ends[1], ends[0]);
                if dot(along, along) == 0.0 {
                    return Err(ElementError::ZeroLength);
                }
                let axes = axes_along(along, self.near);
                let parallel = || ElementError::External("it lies along its `orientation`".to_string());
                turned(axes.ok_or_else(parallel)?, turn)
            }
        };
        let points = ends.iter().map(|p| axes.map(|axis| dot(axis, minus(*p, ends[0])))).collect();
        let n = ends.len();
        let mut back = DMatrix::zeros(6 * n, 6 * n);
        for (k, b) in beside.iter().enumerate() {
            for i in 0..3 {
                for j in 0..3 {
                    let cosine = clean(dot(axes[i], from[j]), 1.0);
                    back[(6 * k + i, 6 * k + j)] = cosine;
                    back[(6 * k + 3 + i, 6 * k + 3 + j)] = cosine;
                    // Axis j of the rotation, in global axes, times the arm.
                    back[(6 * k + i, 6 * k + 3 + j)] = clean(dot(axes[i], cross(from[j], *b)), dot(*b, *b).sqrt());
                }
            }
        }
        Ok(Stand { points: Cow::Owned(points), axes, back: Some(back) })
    }
}

impl Stand<'_> {
    /// A matrix of the element where it stands, in the axes and at the ends that it has at the estimates.
    pub(super) fn brought_back(&self, matrix: SymMatrix) -> SymMatrix {
        match &self.back {
            // What rounding has left where terms cancel would load motions that nothing strains.
            Some(b) => {
                let a = matrix.to_dense();
                let size = b.abs().transpose() * a.abs() * b.abs();
                SymMatrix::from_dense(&(b.transpose() * a * b).zip_map(&size, clean))
            }
            None => matrix,
        }
    }

    /// The motion of a point of it by its dofs: rows by dofs where it stands become rows by those at the estimates.
    pub(super) fn of_dofs(&self, rows: &[[f64; 12]; 6]) -> [[f64; 12]; 6] {
        let Some(b) = &self.back else { return *rows };
        let n = b.nrows().min(12);
        rows.map(|row| {
            let mut out = [0.0; 12];
            for (j, to) in out.iter_mut().enumerate().take(n) {
                *to = (0..n).map(|i| row[i] * b[(i, j)]).sum();
            }
            out
        })
    }
}
