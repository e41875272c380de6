//! `retune schema`

use crate::args::{Schema, SchemaOf};
use crate::output::{Failure, print_json};
use crate::{DONE, markdown, schemas};

pub(crate) fn run(args: &Schema) -> Result<u8, Failure> {
    let schema = schemas::schema(args.of);
    if args.markdown {
        let (word, title, introduction) = about(args.of);
        args.to.hand_over(&markdown::keys(&schema, word, title, introduction))?;
    } else if args.to.output.is_some() {
        args.to.hand_over(&format!("{schema:#}\n"))?;
    } else {
        print_json(&schema);
    }
    Ok(DONE)
}

/// Word, title and introduction of the page of a file format.
fn about(of: SchemaOf) -> (&'static str, &'static str, &'static str) {
    match of {
        SchemaOf::Model => (
            "model",
            "Keys of a model file",
            "Every key of a model file. [The model file](../guide/model-file.md) explains them with examples. A *quantity* is a number in SI, a \
             number with a [unit](units.md) (`56 GPa`), or a sum of parameters with factors (`0.5 kg + 2*m_tip`). *By name* means a map from \
             names, which are yours, to entries; `NAME` stands for such a name.",
        ),
        SchemaOf::Test => (
            "test",
            "Keys of a test file",
            "Every key of a test file. [Test data](../test-data.md) tells how one is made from measurements. A *quantity* is a number in SI or \
             with a [unit](units.md). *By name* means a map from names, which are yours, to entries; `NAME` stands for such a name.",
        ),
        SchemaOf::Objective => (
            "objective",
            "Keys of an objective file",
            "What `retune update --objective` and `retune sample --objective` minimise. The terms are those of the [residuals](residuals.md).",
        ),
        SchemaOf::Profiles => (
            "profiles",
            "Keys of a profile file",
            "A list of criteria profiles for `retune compare --profile FILE.yaml:NAME`. The built-in ones are [examples](profiles.md).",
        ),
        SchemaOf::Patch => (
            "patch",
            "Keys of a patch",
            "A patch is a partial model file that `retune twin --patch` lays over a model: maps are merged key by key, anything else is \
             replaced. Its keys are those of a [model file](model-file.md).",
        ),
        SchemaOf::Optimizer => (
            "optimizer",
            "Settings of optimisers",
            "`retune update --optimizer` takes a name (`nelder-mead`), a name with settings (`{nelder-mead: {size: 0.02}}`), or a list \
             (`[de, nm]`). [Optimisers](optimizers.md) tells what the methods do.",
        ),
    }
}
