//! `retune export`

use super::{export_deck, export_matrices};
use crate::args::Export;
use crate::output::Failure;

pub(crate) fn run(args: &Export) -> Result<u8, Failure> {
    match &args.into {
        Some(deck) => export_deck::run(args, deck),
        None => export_matrices::run(args),
    }
}
