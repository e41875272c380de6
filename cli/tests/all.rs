//! The tests of the command, in one program: linking it once takes a twelfth of linking each.
//!
//! `cargo test -p retune-cli --test all documents::` runs those of one file.

mod batch;
mod cli;
mod common;
mod correlation;
mod decks;
mod documents;
mod init;
mod measured;
mod outputs;
mod readers;
mod report;
mod shards;
