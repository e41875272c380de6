//! From the text of a file to a model.

use super::compile::Model;
use super::registry::Registry;
use super::spec::ModelSpec;
use crate::yaml::{self, Problem, Severity, SourceMap};

/// Reads and builds a model from the text of a file, with the warnings found on the way.
///
/// Errors: every problem of the file, each with its place; warnings among them.
pub fn load(text: &str, registry: &Registry) -> Result<(Model, Vec<Problem>, SourceMap), Vec<Problem>> {
    load_configuration(text, None, registry)
}

/// Reads and builds one configuration of the model of a file; the base model when `configuration` is absent.
///
/// Errors: as [`load`]; an unknown configuration, or one that takes away what is not there.
pub fn load_configuration(
    text: &str,
    configuration: Option<&str>,
    registry: &Registry,
) -> Result<(Model, Vec<Problem>, SourceMap), Vec<Problem>> {
    let (mut spec, map) = yaml::read::<ModelSpec>(text).map_err(|problems| {
        yaml::mistaken(text, problems, "retune_test", "this is a test file; a model file begins with `retune: 1`")
    })?;
    if let Some(name) = configuration {
        spec = spec.configured(name).map_err(|p| map.place(vec![p]))?;
    }
    match Model::new(spec, registry) {
        Ok((model, warnings)) => {
            // Supports on one side are what a configuration is for; that they end the symmetry is no surprise.
            let is_new = |p: &Problem| configuration.is_none() || p.path != "symmetry" || p.severity == Severity::Error;
            Ok((model, map.place(warnings.into_iter().filter(is_new).collect()), map))
        }
        Err(problems) => Err(map.place(problems)),
    }
}
