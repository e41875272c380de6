//! Points of surfaces and volumes: how a place on a mesh moves.

use super::compile::Model;
use super::geometry::{Vector, dot, minus, plus};
use super::{ModelError, ParametricModel, PointMotion};
use crate::element::{ElementInput, PointWithin};

impl Model {
    /// How the point of an element, a part of a mesh or a group moves that is nearest to a place; `None` where these are not surfaces or
    /// volumes.
    pub(super) fn point_within(&self, name: &str, place: Vector) -> Result<Option<PointMotion>, ModelError> {
        let Some(set) = self.element_set(name) else { return Ok(None) };
        let positions = &self.geometry().positions;
        let distance = |n: usize| {
            let d = minus(positions[n], place);
            dot(d, d).sqrt()
        };
        // No point of an element is nearer than its nearest node less its size.
        let mut near: Vec<(f64, f64, usize)> = Vec::with_capacity(set.len());
        for &e in set {
            let nodes = &self.elements()[e].nodes;
            if nodes.len() < 3 || self.elements()[e].matrices.is_some() {
                return Ok(None);
            }
            let d = nodes.iter().map(|&n| distance(n)).fold(f64::INFINITY, f64::min);
            let size = nodes.iter().map(|&n| minus(positions[n], positions[nodes[0]])).map(|v| dot(v, v).sqrt());
            near.push((d - size.fold(0.0, f64::max), d, e));
        }
        let most = near.iter().map(|n| n.1).fold(f64::INFINITY, f64::min);
        let mut best: Option<(f64, usize, PointWithin)> = None;
        for (_, _, e) in near.into_iter().filter(|n| n.0 <= most) {
            let Some(found) = self.nearest_of(e, place)? else { return Ok(None) };
            let at = self.to_global(e, found.at);
            let off = minus(at, place);
            let off = dot(off, off);
            if best.as_ref().is_none_or(|(least, ..)| off < *least) {
                best = Some((off, e, found));
            }
        }
        Ok(best.map(|(_, e, found)| self.motion_of(e, &found)))
    }

    fn nearest_of(&self, e: usize, place: Vector) -> Result<Option<PointWithin>, ModelError> {
        let element = &self.elements()[e];
        let values = element.values_at(&self.parameters().nominal());
        let input = ElementInput { points: &element.points, values: &values };
        let from = minus(place, element.ends(&self.geometry().positions)[0]);
        let local = element.axes.map(|axis| dot(axis, from));
        element.kind.nearest(&input, local).map_err(|source| ModelError::Element {
            element: element.name.clone(),
            path: element.path.clone(),
            source,
        })
    }

    fn to_global(&self, e: usize, local: Vector) -> Vector {
        let element = &self.elements()[e];
        let first = element.ends(&self.geometry().positions)[0];
        (0..3).fold(first, |sum, i| plus(sum, local[i], element.axes[i]))
    }

    fn motion_of(&self, e: usize, found: &PointWithin) -> PointMotion {
        let element = &self.elements()[e];
        let connection = self.element_motion(e);
        let (rows, b) = (&connection.rows, connection.b());
        let mut out: [Vec<(usize, f64)>; 6] = Default::default();
        for (j, &row) in rows.iter().enumerate() {
            let own: [f64; 6] =
                std::array::from_fn(|i| found.rows[i].iter().enumerate().map(|(k, w)| w * b[(k, j)]).sum());
            for (global, list) in out.iter_mut().enumerate() {
                let kind = 3 * (global / 3);
                let factor: f64 = (0..3).map(|i| element.axes[i][global % 3] * own[kind + i]).sum();
                if factor != 0.0 {
                    list.push((row, factor));
                }
            }
        }
        PointMotion { rows: out, position: self.to_global(e, found.at) }
    }
}
