//! From the text of a file to a model.

use super::compile::Model;
use super::mesh_file;
use super::registry::Registry;
use super::spec::{FORMAT, ModelSpec};
use super::superelement::{self, SolverRun, read_files};
use crate::yaml::{self, Problem, Severity, SourceMap};
use std::io;

/// Reads and builds a model from the text of a file, with the warnings found on the way.
///
/// Errors: every problem of the file, each with its place; warnings among them.
pub fn load(text: &str, registry: &Registry) -> Result<(Model, Vec<Problem>, SourceMap), Vec<Problem>> {
    load_configuration(text, None, registry)
}

/// Reads and builds one configuration of the model of a file; the base model when `configuration` is absent.
///
/// Errors: as [`load`]; an unknown configuration, or one that takes away what is not there; superelements, whose files are read by
/// [`load_in`] alone.
pub fn load_configuration(
    text: &str,
    configuration: Option<&str>,
    registry: &Registry,
) -> Result<(Model, Vec<Problem>, SourceMap), Vec<Problem>> {
    let none = |file: &str| {
        let why = format!("no folder is known in which `{file}` may be");
        Err(io::Error::new(io::ErrorKind::NotFound, why))
    };
    load_in(text, configuration, registry, &mut { none })
}

/// The runs of the programs that the superelements of a model file ask for, each once.
///
/// * `read` - as for [`load_in`]
///
/// Errors: every problem of the file that hinders them, each with its place.
pub fn solver_runs(
    text: &str,
    read: &mut dyn FnMut(&str) -> io::Result<Vec<u8>>,
) -> Result<Vec<SolverRun>, Vec<Problem>> {
    let (spec, map) = model_of(text)?;
    superelement::solver_runs(&spec, read).map_err(|problems| map.place(problems))
}

fn model_of(text: &str) -> Result<(ModelSpec, SourceMap), Vec<Problem>> {
    yaml::read::<ModelSpec>(text).map_err(|problems| {
        let problems = yaml::outdated(text, problems, "retune", FORMAT);
        yaml::mistaken(text, problems, "retune_test", "this is a test file; a model file begins with `retune: 1`")
    })
}

/// Reads and builds one configuration of the model of a file, and reads the files that its superelements name.
///
/// * `read` - the bytes of a file by its path in the model file, which is relative to the folder of that file
///
/// Errors: as [`load_configuration`]; a file of matrices that is not there, or that does not fit.
pub fn load_in(
    text: &str,
    configuration: Option<&str>,
    registry: &Registry,
    read: &mut dyn FnMut(&str) -> io::Result<Vec<u8>>,
) -> Result<(Model, Vec<Problem>, SourceMap), Vec<Problem>> {
    let (mut spec, map) = model_of(text)?;
    if let Some(name) = configuration {
        spec = spec.configured(name).map_err(|p| map.place(vec![p]))?;
    }
    let mut of_files = read_files(&mut spec, read);
    of_files.extend(mesh_file::read_file(&mut spec, read));
    if of_files.iter().any(|p| p.severity == Severity::Error) {
        return Err(map.place(of_files));
    }
    match Model::new(spec, registry) {
        Ok((model, warnings)) => {
            // Supports on one side are what a configuration is for; that they end the symmetry is no surprise.
            let is_new = |p: &Problem| configuration.is_none() || p.path != "symmetry" || p.severity == Severity::Error;
            of_files.extend(warnings.into_iter().filter(is_new));
            Ok((model, map.place(of_files), map))
        }
        Err(problems) => {
            of_files.extend(problems);
            Err(map.place(of_files))
        }
    }
}
