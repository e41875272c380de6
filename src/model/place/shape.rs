//! What a cross-section gives an element: its sizes read and checked, then its properties.

use super::Placer;
use crate::catalogue::did_you_mean;
use crate::model::geometry::constant;
use crate::model::laminate::{Ply, Strip, strip};
use crate::model::open_section::{FlangedSizes, ISizes, Profile, angle, both_ends, channel, i_section, tee};
use crate::model::spec::{LaminateSpec, PlySpec, ShapeSpec};
use crate::units::Scalar;
use crate::yaml::{Problem, child};
use std::f64::consts::PI;

/// What a cross-section gives.
#[derive(Debug, Default)]
pub(super) struct Shaped {
    /// Names and values, SI.
    pub(super) properties: Vec<(&'static str, f64)>,
    /// How far its principal axes are turned about x from the axes that it is described in, rad.
    pub(super) turn: f64,
}

/// Plies of a laminate, at most.
const MOST_PLIES: usize = 10_000;

impl Placer<'_> {
    /// The properties that a cross-section gives; none where it is wrong, which is said.
    pub(super) fn shape(&mut self, shape: &ShapeSpec, path: &str) -> Shaped {
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
            Some(laminate) => self.laminate(laminate, &child(path, "laminate")),
            None => shaped,
        };
        let Some(shaped) = shaped.filter(|_| self.problems.len() == before) else { return Shaped::default() };
        let numbers = shaped.properties.iter().map(|p| p.1);
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
        Some(Shaped { properties: vec![("A", area), ("Iy", iy), ("Iz", iz), ("J", j)], turn: 0.0 })
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

    fn laminate(&mut self, s: &LaminateSpec, path: &str) -> Option<Shaped> {
        let before = self.problems.len();
        let width = self.size(&s.width, &child(path, "width"));
        if s.plies.is_empty() || s.plies.len() > MOST_PLIES {
            self.error(child(path, "plies"), format_args!("a laminate has between 1 and {MOST_PLIES} plies"));
            return None;
        }
        let mut materials: Vec<(&str, Ply)> = Vec::new();
        for (name, m) in &s.materials {
            let path = child(&child(path, "materials"), name);
            let at = |key: &str| child(&path, key);
            let [e1, e2, g12] = [(&m.e1, "E1"), (&m.e2, "E2"), (&m.g12, "G12")]
                .map(|(modulus, key)| self.above_zero(modulus, "Pa", &at(key)));
            let nu12 = constant(&m.nu12, "1", &at("nu12"), self.problems);
            let density = constant(&m.density, "kg/m3", &at("density"), self.problems);
            if density < 0.0 {
                self.error(at("density"), format_args!("`{}` must be zero or above", m.density.text()));
            }
            if e1 > 0.0 && e2 > 0.0 && nu12 * nu12 >= e1 / e2 {
                self.error(
                    at("nu12"),
                    format_args!(
                        "`{}` is too large: nu12² must be below E1/E2, or the material gives energy",
                        m.nu12.text()
                    ),
                );
            }
            materials.push((name, Ply { e1, e2, g12, nu12, density, angle: 0.0, thickness: 0.0 }));
        }
        let mut plies = Vec::with_capacity(s.plies.len());
        for (i, ply) in s.plies.iter().enumerate() {
            plies.extend(self.ply(ply, &materials, &format!("{path}.plies[{i}]")));
        }
        if self.problems.len() > before {
            return None;
        }
        strip(width, &plies).map(Shaped::from).map_err(|why| self.error(path, why)).ok()
    }

    fn ply(&mut self, ply: &PlySpec, materials: &[(&str, Ply)], path: &str) -> Option<Ply> {
        let thickness = self.size(&ply.thickness, &child(path, "thickness"));
        let angle = constant(&ply.angle, "rad", &child(path, "angle"), self.problems);
        if angle.abs() > PI {
            let text = ply.angle.text();
            self.error(
                child(path, "angle"),
                format_args!("`{text}` is {:.0} degrees, and fibres lie within half a turn; a number alone is in radians, so write `{text} deg` if degrees are meant", angle.to_degrees()),
            );
        }
        let material = match (&ply.material, materials) {
            (Some(name), _) => {
                let found = materials.iter().find(|m| m.0 == name);
                if found.is_none() {
                    let suggestion = did_you_mean(name, materials.iter().map(|m| m.0));
                    self.error(child(path, "material"), format_args!("there is no material `{name}`{suggestion}"));
                }
                found
            }
            (None, [only]) => Some(only),
            (None, _) => {
                let text = "the laminate has several materials or none; name that of the ply by `material`";
                self.problems.push(Problem::error(path, text));
                None
            }
        };
        material.map(|m| Ply { angle, thickness, ..m.1 })
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
        Self { properties, turn: p.turn }
    }
}

impl From<Strip> for Shaped {
    fn from(s: Strip) -> Self {
        let mut properties = vec![
            ("EA", s.ea),
            ("EIy", s.eiy),
            ("EIz", s.eiz),
            ("GJ", s.gj),
            ("mass_per_length", s.mass_per_length),
            ("polar_inertia_per_length", s.polar_inertia_per_length),
        ];
        let rigidity = (s.eiy * s.gj).sqrt();
        if s.bend_twist_y.abs() > 1e-12 * rigidity {
            properties.push(("bend_twist_y", s.bend_twist_y));
        }
        if s.mass_offset_z.abs() > 1e-12 * (s.eiy / s.ea).sqrt() {
            properties.push(("mass_offset_z", s.mass_offset_z));
        }
        Self { properties, turn: 0.0 }
    }
}
