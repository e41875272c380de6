//! Property values of elements: sections, cross-sections, domains.

use super::Placer;
use crate::catalogue::did_you_mean;
use crate::element::{Domain, Element};
use crate::model::geometry::constant;
use crate::model::spec::{SectionSpec, SectionValue, ShapeSpec};
use crate::model::value::{Affine, Value};
use crate::units::Scalar;
use crate::units::plain;
use crate::yaml::{Problem, child};

impl Placer<'_> {
    /// Property values of a type from sets of them, the later ones first.
    pub(super) fn values(&mut self, kind: &'static dyn Element, sets: &[(&SectionSpec, String)]) -> Vec<Option<Value>> {
        let properties = kind.properties();
        let mut values: Vec<Option<Value>> = vec![None; properties.len()];
        for (set, path) in sets {
            for (name, value) in *set {
                let path = child(path, name);
                match value {
                    SectionValue::Shape(shape) if name == "shape" => {
                        for (property, v) in self.shape(shape, &path) {
                            if let Some(i) = properties.iter().position(|p| p.name == property) {
                                values[i].get_or_insert(Value::constant(v));
                            }
                        }
                    }
                    SectionValue::Shape(_) => self.error(path, "a cross-section stands under the key `shape`"),
                    SectionValue::Scalar(_) if name == "shape" => {
                        self.error(
                            path,
                            "expected a cross-section such as `{rectangle: {width: 20 mm, height: 5 mm}}`",
                        );
                    }
                    SectionValue::Scalar(scalar) => {
                        let Some(i) = properties.iter().position(|p| p.name == name) else {
                            let suggestion = did_you_mean(name, properties.iter().map(|p| p.name));
                            self.error(
                                path,
                                format_args!(
                                    "a {} has no property `{name}`{suggestion} (see `retune explain {}`)",
                                    kind.name(),
                                    kind.name()
                                ),
                            );
                            continue;
                        };
                        if let Some(affine) = self.affine(scalar, properties[i].unit, &path) {
                            self.domain(&affine, properties[i].domain, properties[i].name, properties[i].unit, &path);
                            values[i].get_or_insert(Value::of(affine));
                        }
                    }
                }
            }
        }
        values
    }

    /// Checks a property at the estimates (an error) and over the bounds (a warning).
    pub(super) fn domain(&mut self, affine: &Affine, domain: Domain, name: &str, unit: &str, path: &str) {
        let parameters = self.parameters;
        let theta = parameters.nominal();
        let fits = |v: f64| match domain {
            Domain::Positive => v > 0.0,
            Domain::NonNegative | Domain::Compliance => v >= 0.0,
            Domain::Fraction => (0.0..=1.0).contains(&v),
            Domain::Any => true,
        };
        let must = match domain {
            Domain::Positive => "above zero",
            Domain::Fraction => "between 0 and 1",
            Domain::NonNegative | Domain::Compliance | Domain::Any => "zero or above",
        };
        let now = affine.at(&theta);
        if !fits(now) {
            self.error(path, format_args!("`{name}` is {} {unit}; it must be {must}", plain(now)));
            return;
        }
        let [low, _] = affine.range(&|i| parameters.get(i).range());
        if !fits(low) {
            self.problems.push(Problem::warning(
                path,
                format_args!(
                    "within the bounds of its parameters `{name}` can become {} {unit}; it must be {must}",
                    plain(low)
                ),
            ));
        }
    }

    pub(super) fn shape(&mut self, shape: &ShapeSpec, path: &str) -> Vec<(&'static str, f64)> {
        use std::f64::consts::PI;
        let given = [shape.rectangle.is_some(), shape.hollow.is_some(), shape.circle.is_some(), shape.tube.is_some()];
        if given.iter().filter(|g| **g).count() != 1 {
            self.error(path, "give exactly one of `rectangle`, `box`, `circle`, `tube`");
            return Vec::new();
        }
        let mut length = |s: &Scalar, key: &str| {
            let path = child(path, key);
            let v = constant(s, "m", &path, self.problems);
            if v <= 0.0 {
                self.problems.push(Problem::error(path, format_args!("`{}` must be above zero", s.text())));
            }
            v
        };
        let (area, iy, iz, j) = if let Some(s) = &shape.rectangle {
            let (b, h) = (length(&s.width, "rectangle.width"), length(&s.height, "rectangle.height"));
            // Torsion constant of a rectangle, error below 0.01 %: Roark's Formulas for Stress and Strain, table 10.7.
            let (long, short) = (b.max(h), b.min(h));
            let r = short / long;
            let j = long * short.powi(3) * (1.0 / 3.0 - 0.21 * r * (1.0 - r.powi(4) / 12.0));
            (b * h, b * h.powi(3) / 12.0, h * b.powi(3) / 12.0, j)
        } else if let Some(s) = &shape.hollow {
            let (b, h, t) =
                (length(&s.width, "box.width"), length(&s.height, "box.height"), length(&s.wall, "box.wall"));
            let (bi, hi) = (b - 2.0 * t, h - 2.0 * t);
            if bi < 0.0 || hi < 0.0 {
                self.problems.push(Problem::error(child(path, "box.wall"), "the walls are thicker than the box"));
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
                self.problems.push(Problem::error(child(path, "tube.wall"), "the wall is thicker than the tube"));
            }
            let i = PI * (d.powi(4) - inner.powi(4)) / 64.0;
            (PI * (d * d - inner * inner) / 4.0, i, i, 2.0 * i)
        } else {
            return Vec::new();
        };
        vec![("A", area), ("Iy", iy), ("Iz", iz), ("J", j)]
    }
}
