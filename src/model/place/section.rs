//! Property values of elements: sections, domains.

use super::Placer;
use crate::catalogue::did_you_mean;
use crate::element::{Domain, Element};
use crate::model::spec::{SectionSpec, SectionValue};
use crate::model::value::{Affine, Value};
use crate::units::plain;
use crate::yaml::{Problem, child};

impl Placer<'_> {
    /// Property values of a type from sets of them, the later ones first.
    pub(super) fn values(&mut self, kind: &'static dyn Element, sets: &[(&SectionSpec, String)]) -> Vec<Option<Value>> {
        self.shaped_values(kind, sets).0
    }

    /// [`Self::values`], and how far a cross-section among them turns the axes of an element, rad.
    ///
    /// What a set states counts before what its cross-section gives, and of two sets with a cross-section the first one's counts, all of it.
    pub(super) fn shaped_values(
        &mut self,
        kind: &'static dyn Element,
        sets: &[(&SectionSpec, String)],
    ) -> (Vec<Option<Value>>, f64) {
        let properties = kind.properties();
        let mut values: Vec<Option<Value>> = vec![None; properties.len()];
        let mut turn: Option<f64> = None;
        for (set, path) in sets {
            let mut shape = None;
            for (name, value) in *set {
                let path = child(path, name);
                match value {
                    SectionValue::Shape(given) if name == "shape" => shape = Some((given, path)),
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
            let Some((shape, path)) = shape else { continue };
            let shaped = self.shape(kind, shape, &path);
            if turn.is_some() {
                continue;
            }
            turn = Some(shaped.turn);
            for (property, v) in shaped.properties {
                if let Some(i) = properties.iter().position(|p| p.name == property) {
                    values[i].get_or_insert(v);
                }
            }
        }
        (values, turn.unwrap_or(0.0))
    }

    /// Checks a property at the estimates (an error) and over the bounds (a warning).
    pub(super) fn domain(&mut self, affine: &Affine, domain: Domain, name: &str, unit: &str, path: &str) {
        let parameters = self.parameters;
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
        let now = affine.at_values(|i| parameters.get(i).value);
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
}
