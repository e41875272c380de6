//! `retune._core`: the library, for the Python package `retune` that stands over it.
//!
//! Thin and private: it converts arguments, runs the workflows of the library with the GIL released, and keeps their results; names,
//! defaults and documentation for users are in `python/retune`. Start reading at `running`, then `verbs`.

// PyO3 hands arguments over by value.
#![allow(clippy::needless_pass_by_value)]

mod answers;
mod arrays;
mod error;
mod external;
mod model;
mod objective;
mod own;
mod page;
mod running;
mod source;
mod test;
mod tested;
mod verbs;

use pyo3::prelude::*;

#[pymodule]
mod _core {
    use super::{Bound, PyModule, PyModuleMethods, PyResult};

    #[pymodule_export]
    use super::answers::{Compared, Diagnosed, Identified, Learned, Sampled, Twin, Updated};
    #[pymodule_export]
    use super::external::External;
    #[pymodule_export]
    use super::model::Model;
    #[pymodule_export]
    use super::objective::{Objective, Search};
    #[pymodule_export]
    use super::own::{OwnEffect, OwnElement, OwnFault, OwnOptimizer, OwnResidual, Run};
    #[pymodule_export]
    use super::test::{Frfs, Test};
    #[pymodule_export]
    use super::verbs::{
        compare::compare,
        diagnose::{diagnose, learn},
        identify::{identify, read_frfs},
        pretest::pretest,
        report::report,
        twin::twin,
        update::{sample, update},
    };
    #[pymodule_export]
    use super::{catalogue, command, yaml_of_json};

    #[pymodule_init]
    fn init(m: &Bound<'_, PyModule>) -> PyResult<()> {
        m.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}

/// Performs a command line in this process, and gives the exit code.
///
/// * `program` - the words that start this program once more
#[pyfunction]
fn command(py: Python<'_>, program: Vec<std::ffi::OsString>, words: Vec<std::ffi::OsString>) -> u8 {
    py.detach(|| retune_cli::command(program, words))
}

/// JSON text as block YAML, the format of model and test files.
#[pyfunction]
fn yaml_of_json(text: &str) -> PyResult<String> {
    let value: serde_json::Value = serde_json::from_str(text).map_err(|e| error::Wrong::text(e.to_string()))?;
    Ok(retune::yaml::write(&value))
}

/// Names of what there is in an open list: `elements`, `effects`, `faults`, `optimizers`, `residuals`.
#[pyfunction]
fn catalogue(list: &str) -> PyResult<Vec<&'static str>> {
    use retune::effect::{Effect, Effects};
    use retune::fault::{FAULTS, Fault};
    Ok(match list {
        "elements" => retune::model::Registry::builtin().elements().map(retune::element::Element::name).collect(),
        "effects" => Effects::builtin().iter().map(Effect::name).collect(),
        "faults" => FAULTS.iter().map(|f| Fault::name(*f)).collect(),
        "optimizers" => retune::optim::OPTIMIZERS.iter().map(|o| o.name).collect(),
        "residuals" => retune::objective::RESIDUALS.iter().map(|r| r.name()).collect(),
        _ => return Err(error::Wrong::text(format!("there is no list `{list}`")).into()),
    })
}
