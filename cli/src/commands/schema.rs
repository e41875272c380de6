//! `retune schema`

use crate::DONE;
use crate::args::{Schema, SchemaOf};
use crate::output::{Failure, print_json};

pub(crate) fn run(args: &Schema) -> Result<u8, Failure> {
    print_json(&match args.of {
        SchemaOf::Model => retune::model::schema(),
        SchemaOf::Test => retune::data::schema(),
    });
    Ok(DONE)
}
