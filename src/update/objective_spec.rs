//! The objective block: terms and their weights, loss, regularisation, inequality constraints.

use crate::catalogue::did_you_mean;
use crate::linalg::DVector;
use crate::model::ParametricModel;
use crate::objective::{Choice, Comparison, LeastSquares, Loss, Residual, Residuals, Scaling, Wall};
use crate::units::{Scalar, Unit};
use crate::yaml::{self, Problem, child};
use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What a least-squares update minimises, as a file states it.
///
/// ```yaml
/// terms: {frequency: 1, shape: 0.25, damping: 1}   # factors of the squared residuals; all that the test has when absent
/// loss: {huber: 2}                                 # squares, {huber: k}, {student-t: degrees of freedom}
/// regularization: evidence                         # none, evidence, l-curve, {weight: 0.1}
/// limits:
///   - {expression: m1 + 2*m4_9, at_most: 2.5 kg}
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectiveSpec {
    /// Terms of `retune list residuals` with a factor of their squared residuals; priors and targets are always there.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub terms: IndexMap<String, f64>,
    /// The loss of the terms that compare with data.
    #[serde(default)]
    pub loss: Loss,
    /// A pull of all free parameters towards their estimates.
    #[serde(default)]
    pub regularization: Regularization,
    /// Inequalities between parameters.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub limits: Vec<LimitSpec>,
    /// What `terms` may name. One of a user's own that is not built in takes part where no terms are stated, too.
    #[serde(skip)]
    pub residuals: Residuals,
}

/// A pull w/2 |x - x0|² towards the estimates x0, x in shares of the intervals, and how its weight is found.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(try_from = "Choice", into = "Choice")]
pub enum Regularization {
    /// None.
    #[default]
    None,
    /// Of this weight: a prior standard deviation of 1/√w of each interval.
    Weight(f64),
    /// The weight that makes the data most probable.
    Evidence,
    /// The weight at the corner of the L-curve.
    LCurve,
}

impl TryFrom<Choice> for Regularization {
    type Error = String;

    fn try_from(c: Choice) -> Result<Self, String> {
        match (c.word.as_str(), c.number) {
            ("none", None) => Ok(Regularization::None),
            ("weight", Some(w)) => Ok(Regularization::Weight(w)),
            ("evidence", None) => Ok(Regularization::Evidence),
            ("l-curve", None) => Ok(Regularization::LCurve),
            _ => {
                let words = ["none", "weight", "evidence", "l-curve"];
                Err(c.refused("`none`, `{weight: w}`, `evidence`, `l-curve`", &words))
            }
        }
    }
}

impl From<Regularization> for Choice {
    fn from(r: Regularization) -> Self {
        match r {
            Regularization::None => Choice::new("none", None),
            Regularization::Weight(w) => Choice::new("weight", Some(w)),
            Regularization::Evidence => Choice::new("evidence", None),
            Regularization::LCurve => Choice::new("l-curve", None),
        }
    }
}

/// An inequality: at_least <= expression <= at_most.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LimitSpec {
    /// A sum of parameters with factors.
    pub expression: Scalar,
    /// Its largest value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_most: Option<Scalar>,
    /// Its smallest value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_least: Option<Scalar>,
}

impl ObjectiveSpec {
    /// Reads the text of an objective file; all problems at once, with their places.
    ///
    /// # Errors
    /// YAML that is not well formed; a term that does not exist; a number that is not above zero.
    pub fn read(text: &str) -> Result<Self, Vec<Problem>> {
        Self::read_with(text, Residuals::builtin())
    }

    /// [`Self::read`] of a text that may name residual terms of a user's own.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_with(text: &str, residuals: Residuals) -> Result<Self, Vec<Problem>> {
        let (spec, map) = yaml::read::<Self>(text)?;
        let spec = Self { residuals, ..spec };
        let mut problems = Vec::new();
        for (name, weight) in &spec.terms {
            let path = child("terms", name);
            if spec.residuals.find(name).is_none() {
                let suggestion = did_you_mean(name, spec.residuals.iter().map(Residual::name));
                problems.push(Problem::error(&path, format_args!("`{name}` is not a residual term{suggestion}")));
            }
            if !(weight.is_finite() && *weight >= 0.0) {
                problems.push(Problem::error(path, format_args!("{weight}: a factor is a number, zero or above")));
            }
        }
        let mut above_zero = |path: &str, number: Option<f64>| {
            if let Some(v) = number.filter(|v| !(v.is_finite() && *v > 0.0)) {
                problems.push(Problem::error(path, format_args!("{v}: it must be above zero")));
            }
        };
        above_zero("loss", spec.loss.number());
        if let Regularization::Weight(w) = spec.regularization {
            above_zero("regularization", Some(w));
        }
        if problems.is_empty() { Ok(spec) } else { Err(map.place(problems)) }
    }

    /// The least-squares objective of one comparison; parameters' own terms only where `owns_parameters`.
    pub(super) fn least_squares<'a>(
        &self,
        comparison: &'a Comparison<'a>,
        scaling: &Scaling,
        owns_parameters: bool,
    ) -> LeastSquares<'a> {
        let mut objective = LeastSquares::new(comparison);
        if self.terms.is_empty() {
            for term in self.residuals.own() {
                objective = objective.with_term(term);
            }
        } else {
            let chosen = self
                .residuals
                .iter()
                .map(|r| r as &dyn Residual)
                .filter(|r| if r.is_data() { self.terms.contains_key(r.name()) } else { !r.is_empty(comparison) });
            objective = LeastSquares::with_terms(comparison, chosen.collect());
        }
        if !owns_parameters {
            objective = objective.without(|r| !r.is_data());
        }
        let objective = objective.with_scaling(scaling.clone());
        objective.with_weights(|name| self.terms.get(name).copied()).with_loss(self.loss)
    }

    /// The inequalities over the unit box.
    ///
    /// * `scaling` - from the box to the parameters of the model
    ///
    /// # Errors
    /// An expression that names an unknown parameter, has the wrong unit, or has no limit.
    pub fn walls(&self, model: &dyn ParametricModel, scaling: &Scaling) -> Result<Vec<Wall>, Vec<Problem>> {
        let (mut walls, mut problems) = (Vec::new(), Vec::new());
        for (i, limit) in self.limits.iter().enumerate() {
            match limit.walls(model, scaling) {
                Ok(own) => walls.extend(own),
                Err(text) => problems.push(Problem::error(format!("limits[{i}]"), text)),
            }
        }
        if problems.is_empty() { Ok(walls) } else { Err(problems) }
    }
}

impl LimitSpec {
    fn walls(&self, model: &dyn ParametricModel, scaling: &Scaling) -> Result<Vec<Wall>, String> {
        let parameters = model.parameters();
        let mut names = self.expression.parameters();
        if let Some(unknown) = names.find(|n| parameters.index_of(n).is_none()) {
            let suggestion = did_you_mean(unknown, parameters.names());
            return Err(format!("the model has no parameter `{unknown}`{suggestion}"));
        }
        let dimension = |name: &str| {
            let unit = &parameters.get(parameters.index_of(name)?).unit;
            Unit::parse(unit).ok().map(|u| u.dimension)
        };
        let first = self.expression.parameters().next().and_then(|n| parameters.index_of(n));
        let Some(first) = first else { return Err("the expression names no parameter".to_string()) };
        // The unit of the whole: that of the first parameter times that of its factor.
        let unit = parameters.get(first).unit.clone();
        let unit = if unit.is_empty() { "1".to_string() } else { unit };
        let (constant, terms) = self.expression.affine_in(&unit, &dimension).map_err(|e| e.to_string())?;
        let theta = scaling.theta(&DVector::zeros(scaling.len()));
        let mut base = constant;
        let mut slope: DVector<f64> = DVector::zeros(scaling.len());
        for (name, factor) in terms {
            let Some(i) = parameters.index_of(&name) else { continue };
            base += factor * theta[i];
            if let Some(k) = scaling.free().iter().position(|&f| f == i) {
                slope[k] += factor * scaling.width()[k];
            }
        }
        let span: f64 = slope.iter().map(|v| v.abs()).sum();
        if span == 0.0 {
            return Err("no free parameter stands in the expression".to_string());
        }
        let value = |s: &Scalar| s.constant_in(&unit).map_err(|e| e.to_string());
        let wall = |slope, limit| Wall { slope, limit, decades: scaling.decades().to_vec() };
        let mut walls = Vec::new();
        if let Some(most) = &self.at_most {
            walls.push(wall(&slope / span, (value(most)? - base) / span));
        }
        if let Some(least) = &self.at_least {
            walls.push(wall(-&slope / span, (base - value(least)?) / span));
        }
        if walls.is_empty() {
            return Err("give `at_most`, `at_least` or both".to_string());
        }
        Ok(walls)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlation::PairingOptions;
    use crate::linalg::DMatrix;
    use crate::model::{Registry, load};
    use crate::objective::{Point, PredictionDerivative};

    const MODEL: &str = "
retune: 1
name: two masses
active_dofs: [uz]
parameters: {a: {value: 100 g, bounds: [0 kg, 1 kg]}, b: {value: 1 kg, bounds: [0 kg, 3 kg]}, k: {value: 5 N/m}}
nodes: {p: [0, 0, 0], q: [1, 0, 0]}
springs: {s: {node: p, k: {uz: 100 N/m}}, t: {node: q, k: {uz: k}}}
masses: {m: {node: p, mass: a}, n: {node: q, mass: b}}
";

    #[test]
    fn the_block_reads_and_problems_have_places() {
        let spec = ObjectiveSpec::read(
            "terms: {frequency: 2}\nloss: {huber: 1.5}\nregularization: {weight: 0.1}\nlimits:\n  - {expression: a + 2*b, at_most: 4 kg}\n",
        )
        .unwrap();
        assert_eq!((spec.loss, spec.regularization), (Loss::Huber(1.5), Regularization::Weight(0.1)));
        assert_eq!(ObjectiveSpec::read("regularization: l-curve").unwrap().regularization, Regularization::LCurve);
        let problems = ObjectiveSpec::read("terms: {frequenzy: 1}\nloss: {student-t: -1}\n").unwrap_err();
        assert_eq!(problems.len(), 2);
        assert!(problems[0].message.contains("did you mean `frequency`"), "{}", problems[0].message);
        assert_eq!(problems[1].location.map(|l| l.line), Some(2));
        assert!(ObjectiveSpec::read("los: squares").is_err());
        let problems = ObjectiveSpec::read("loss: {hubber: 2}").unwrap_err();
        assert!(problems[0].message.contains("did you mean `huber`"), "{}", problems[0].message);
        assert_eq!(ObjectiveSpec::read(&yaml::write(&spec)).unwrap(), spec);
    }

    /// x = (a/1 kg, b/3 kg): a + 2 b = x1 + 6 x2 kg spans 7 kg.
    #[test]
    fn limits_become_walls_over_the_unit_box() {
        let (model, _, _) = load(MODEL, &Registry::builtin()).unwrap();
        let walls = |expression: &str, most: &str| {
            let expression = Scalar::parse(expression).unwrap();
            let limit = LimitSpec { expression, at_most: Some(Scalar::parse(most).unwrap()), at_least: None };
            ObjectiveSpec { limits: vec![limit], ..ObjectiveSpec::default() }.walls(&model, &Scaling::new(&model))
        };
        let found = walls("a + 2*b", "3500 g").unwrap();
        assert!((found[0].slope[0] - 1.0 / 7.0).abs() < 1e-15 && (found[0].slope[1] - 6.0 / 7.0).abs() < 1e-15);
        assert!((found[0].limit - 0.5).abs() < 1e-15);
        for (expression, most, text) in [
            ("a + c", "1 kg", "no parameter `c`"),
            ("a", "1 m", "m"),
            ("k", "1 N/m", "no free"),
            ("a + k", "1 kg", "k"),
        ] {
            let problems = walls(expression, most).unwrap_err();
            assert!(problems[0].message.contains(text), "{}", problems[0].message);
        }
    }

    fn frequency() -> &'static dyn Residual {
        Residuals::builtin().find("frequency").expect("it is built in")
    }

    /// The frequencies once more, under a name of its own.
    #[derive(Debug)]
    struct Again;

    impl Residual for Again {
        fn name(&self) -> &'static str {
            "again"
        }
        fn summary(&self) -> &'static str {
            "natural frequencies, once more"
        }
        fn len(&self, comparison: &Comparison<'_>) -> usize {
            frequency().len(comparison)
        }
        fn row_name(&self, comparison: &Comparison<'_>, row: usize) -> String {
            frequency().row_name(comparison, row)
        }
        fn evaluate(&self, at: &Point<'_>, out: &mut [f64]) {
            frequency().evaluate(at, out);
        }
        fn differentiate(&self, at: &Point<'_>, derivative: &PredictionDerivative, out: &mut DMatrix<f64>) {
            frequency().differentiate(at, derivative, out);
        }
    }

    #[test]
    fn a_term_of_ones_own_stands_beside_the_others_or_where_it_is_named() {
        let own = || Residuals::builtin().with(&Again);
        let (model, _, _) = load(MODEL, &Registry::builtin()).unwrap();
        let test =
            "retune_test: 1\nname: t\nsources: {s: {kind: measured, text: t}}\nmodes: [{frequency: 2 Hz, source: s}]\n";
        let test = crate::data::read_test(test).unwrap().0;
        let comparison = Comparison::new(&model, &test, PairingOptions::default()).unwrap();
        let scaling = Scaling::new(&model);
        let names = |spec: &ObjectiveSpec| -> Vec<&str> {
            spec.least_squares(&comparison, &scaling, false).terms().iter().map(|t| t.name()).collect()
        };
        let beside = ObjectiveSpec { residuals: own(), ..ObjectiveSpec::default() };
        assert_eq!(names(&beside), [names(&ObjectiveSpec::default()), vec!["again"]].concat());
        assert_eq!(names(&ObjectiveSpec::read_with("terms: {again: 2}", own()).unwrap()), ["again"]);
        assert_eq!(names(&ObjectiveSpec::read_with("terms: {frequency: 2}", own()).unwrap()), ["frequency"]);
        let problems = ObjectiveSpec::read_with("terms: {agian: 2}", own()).unwrap_err();
        assert!(problems[0].message.contains("did you mean `again`"), "{}", problems[0].message);
        assert!(ObjectiveSpec::read("terms: {again: 2}").is_err());
    }
}
