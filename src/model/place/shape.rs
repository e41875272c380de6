//! What a cross-section gives an element: its sizes read and checked, then its properties.

use super::Placer;
use crate::element::Element;
use crate::model::geometry::constant;
use crate::model::open_section::{FlangedSizes, ISizes, Profile, angle, both_ends, channel, i_section, tee};
use crate::model::spec::ShapeSpec;
use crate::model::value::Value;
use crate::units::Scalar;
use crate::yaml::child;
use std::f64::consts::PI;

/// What a cross-section gives.
#[derive(Debug, Default)]
pub(super) struct Shaped {
    /// Names and values, SI.
    pub(super) properties: Vec<(&'static str, Value)>,
    /// How far its principal axes are turned about x from the axes that it is described in, rad.
    pub(super) turn: f64,
}

impl Shaped {
    pub(super) fn constants(properties: impl IntoIterator<Item = (&'static str, f64)>) -> Self {
        Self { properties: properties.into_iter().map(|(name, v)| (name, Value::constant(v))).collect(), turn: 0.0 }
    }
}

impl Placer<'_> {
    /// The properties that a cross-section gives an element of a type; none where it is wrong, which is said.
    pub(super) fn shape(&mut self, kind: &'static dyn Element, shape: &ShapeSpec, path: &str) -> Shaped {
        let given = [
            shape.rectangle.is_some(),
            shape.hollow.is_some(),
            shape.circle.is_some(),
            shape.tube.is_some(),
            shape.i.is_some(),
            shape.channel.is_some(),
            shape.angle.is_some(),
            shape.tee.is_some(),
            shape.laminate.is_some(),
        ];
        if given.iter().filter(|g| **g).count() != 1 {
            self.error(
                path,
                "give exactly one of `rectangle`, `box`, `circle`, `tube`, `i`, `channel`, `angle`, `tee`, `laminate`",
            );
            return Shaped::default();
        }
        let before = self.problems.len();
        let shaped = self.closed(shape, path).or_else(|| self.open(shape, path));
        let shaped = match &shape.laminate {
            Some(laminate) => self.laminate(kind, laminate, &child(path, "laminate")),
            None => shaped,
        };
        let Some(shaped) = shaped.filter(|_| self.problems.len() == before) else { return Shaped::default() };
        let theta = self.parameters.nominal();
        let numbers = shaped.properties.iter().map(|p| p.1.at(&theta));
        if numbers.chain([shaped.turn]).any(|v| !v.is_finite()) {
            self.error(path, "its sizes or moduli are too large or too small to compute with");
            return Shaped::default();
        }
        shaped
    }

    /// A size, which must be above zero.
    fn size(&mut self, s: &Scalar, path: &str) -> f64 {
        self.above_zero(s, "m", path)
    }

    fn above_zero(&mut self, s: &Scalar, unit: &str, path: &str) -> f64 {
        let before = self.problems.len();
        let v = constant(s, unit, path, self.problems);
        if v <= 0.0 && self.problems.len() == before {
            self.error(path, format_args!("`{}` must be above zero", s.text()));
        }
        v
    }

    /// The radius of a fillet, 0 where there is none.
    fn fillet(&mut self, s: Option<&Scalar>, path: &str) -> f64 {
        let Some(s) = s else { return 0.0 };
        let path = child(path, "fillet");
        let v = constant(s, "m", &path, self.problems);
        if v < 0.0 {
            self.error(path, format_args!("`{}` must be zero or above", s.text()));
        }
        v
    }

    /// Solid shapes, and those that enclose a cell.
    fn closed(&mut self, shape: &ShapeSpec, path: &str) -> Option<Shaped> {
        let mut length = |s: &Scalar, key: &str| self.size(s, &child(path, key));
        let (area, iy, iz, j) = if let Some(s) = &shape.rectangle {
            let (b, h) = (length(&s.width, "rectangle.width"), length(&s.height, "rectangle.height"));
            (b * h, b * h.powi(3) / 12.0, h * b.powi(3) / 12.0, both_ends(b, h))
        } else if let Some(s) = &shape.hollow {
            let (b, h, t) =
                (length(&s.width, "box.width"), length(&s.height, "box.height"), length(&s.wall, "box.wall"));
            let (bi, hi) = (b - 2.0 * t, h - 2.0 * t);
            if bi < 0.0 || hi < 0.0 {
                self.error(child(path, "box.wall"), "the walls are thicker than the box");
            }
            let j = 2.0 * t * (b - t).powi(2) * (h - t).powi(2) / (b + h - 2.0 * t);
            (b * h - bi * hi, (b * h.powi(3) - bi * hi.powi(3)) / 12.0, (h * b.powi(3) - hi * bi.powi(3)) / 12.0, j)
        } else if let Some(s) = &shape.circle {
            let d = length(&s.diameter, "circle.diameter");
            let i = PI * d.powi(4) / 64.0;
            (PI * d * d / 4.0, i, i, 2.0 * i)
        } else if let Some(s) = &shape.tube {
            let (d, t) = (length(&s.diameter, "tube.diameter"), length(&s.wall, "tube.wall"));
            let inner = d - 2.0 * t;
            if inner < 0.0 {
                self.error(child(path, "tube.wall"), "the wall is thicker than the tube");
            }
            let i = PI * (d.powi(4) - inner.powi(4)) / 64.0;
            (PI * (d * d - inner * inner) / 4.0, i, i, 2.0 * i)
        } else {
            return None;
        };
        Some(Shaped::constants([("A", area), ("Iy", iy), ("Iz", iz), ("J", j)]))
    }

    /// Shapes of walls that enclose no cell.
    fn open(&mut self, shape: &ShapeSpec, path: &str) -> Option<Shaped> {
        let before = self.problems.len();
        let (path, profile) = if let Some(s) = &shape.i {
            let path = child(path, "i");
            let at = |key: &str| child(&path, key);
            let [height, width, web, flange] =
                [(&s.height, "height"), (&s.width, "width"), (&s.web, "web"), (&s.flange, "flange")]
                    .map(|(size, key)| self.size(size, &at(key)));
            let bottom = [
                s.bottom_width.as_ref().map_or(width, |size| self.size(size, &at("bottom_width"))),
                s.bottom_flange.as_ref().map_or(flange, |size| self.size(size, &at("bottom_flange"))),
            ];
            let fillet = self.fillet(s.fillet.as_ref(), &path);
            let profile = i_section(ISizes { height, top: [width, flange], bottom, web, fillet });
            (path, profile)
        } else if let Some(s) = &shape.channel {
            let path = child(path, "channel");
            let sizes = self.flanged([&s.height, &s.width, &s.web, &s.flange], s.fillet.as_ref(), &path);
            (path, channel(sizes))
        } else if let Some(s) = &shape.tee {
            let path = child(path, "tee");
            let sizes = self.flanged([&s.height, &s.width, &s.web, &s.flange], s.fillet.as_ref(), &path);
            (path, tee(sizes))
        } else if let Some(s) = &shape.angle {
            let path = child(path, "angle");
            let [width, height, thickness] = [(&s.width, "width"), (&s.height, "height"), (&s.thickness, "thickness")]
                .map(|(size, key)| self.size(size, &child(&path, key)));
            let fillet = self.fillet(s.fillet.as_ref(), &path);
            (path, angle(width, height, thickness, fillet))
        } else {
            return None;
        };
        // Sizes that are wrong by themselves say nothing together.
        if self.problems.len() > before {
            return None;
        }
        profile.map(Shaped::from).map_err(|why| self.error(path, why)).ok()
    }

    fn flanged(&mut self, sizes: [&Scalar; 4], fillet: Option<&Scalar>, path: &str) -> FlangedSizes {
        let mut size = |i: usize, key: &str| self.size(sizes[i], &child(path, key));
        let (height, width, web, flange) = (size(0, "height"), size(1, "width"), size(2, "web"), size(3, "flange"));
        FlangedSizes { height, width, web, flange, fillet: self.fillet(fillet, path) }
    }
}

impl From<Profile> for Shaped {
    fn from(p: Profile) -> Self {
        let mut properties = vec![("A", p.area), ("Iy", p.iy), ("Iz", p.iz), ("J", p.j)];
        let size = p.area.sqrt();
        for (names, at) in
            [["shear_centre_y", "neutral_axis_y"], ["shear_centre_z", "neutral_axis_z"]].into_iter().zip(p.shear_centre)
        {
            // Where the shear centre is the centroid, up to rounding, there is nothing to say.
            if at.abs() > 1e-12 * size {
                properties.extend([(names[0], at), (names[1], 0.0)]);
            }
        }
        Self { turn: p.turn, ..Self::constants(properties) }
    }
}
