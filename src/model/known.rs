//! What expressions of a file may name.

use super::affine::Affine;
use super::parameter::ParameterSet;
use super::spec::ModelSpec;
use crate::catalogue::did_you_mean;
use crate::units::{Dimension, Scalar, Unit};
use crate::yaml::Problem;
use std::collections::BTreeMap;

/// What an expression may name.
#[derive(Clone, Copy)]
pub(super) struct Known<'a> {
    pub(super) spec: &'a ModelSpec,
    pub(super) parameters: &'a ParameterSet,
    pub(super) dimensions: &'a BTreeMap<String, Dimension>,
}

impl Known<'_> {
    /// A scalar as a function of θ, in the unit of what it is for; `None` with its problem.
    pub(super) fn affine(
        &self,
        scalar: &Scalar,
        unit: &str,
        path: &str,
        problems: &mut Vec<Problem>,
    ) -> Option<Affine> {
        if let Some(word) = scalar.words_behind_numbers().find(|word| self.parameters.index_of(word).is_some()) {
            let text = scalar.text();
            problems.push(Problem::error(path, format_args!("`{word}` reads as a unit in `{text}`, and is a parameter as well; write the parameter first, `{word} * …`")));
            return None;
        }
        match scalar.affine_in(unit, &|name| self.dimensions.get(name).copied()) {
            Ok((constant, terms)) => {
                let mut affine = Affine { constant, terms: Vec::new() };
                for (name, factor) in terms {
                    if let Some(i) = self.parameters.index_of(&name) {
                        affine.terms.push((i, factor));
                    } else {
                        let mut problem = unknown(path, "parameter", &name, self.spec.parameters.keys());
                        if Unit::parse(&name).is_ok() {
                            let hint = format!("; a unit stands behind a number, `1 {name}`");
                            problem.message.push_str(&hint);
                        }
                        problems.push(problem);
                        return None;
                    }
                }
                Some(affine)
            }
            Err(e) => {
                problems.push(Problem::error(path, e));
                None
            }
        }
    }
}

/// "node `n6a` is not defined; did you mean `n6`?"
pub(super) fn unknown<'a>(path: &str, what: &str, name: &str, known: impl IntoIterator<Item = &'a String>) -> Problem {
    let suggestion = did_you_mean(name, known.into_iter().map(String::as_str));
    Problem::error(path, format_args!("{what} `{name}` is not defined{suggestion}"))
}
