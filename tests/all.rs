//! The tests of the whole way through the library, in one program: linking it once takes a twelfth of linking each.
//!
//! `cargo test --test all published::` runs those of one file. Two files stand alone: `no_allocation`, which counts in an allocator of its own,
//! and `architecture`, which also runs without the library.

mod abaqus;
#[path = "bff/main.rs"]
mod bff;
#[path = "correlation/main.rs"]
mod correlation;
mod damped;
mod deck_folders;
mod decks;
mod design;
mod errors;
mod examples;
mod formats;
mod laminates;
mod live;
mod matrices;
mod matrices_peer;
mod measured;
mod mesh_peers;
mod meshes;
mod pairing;
mod properties;
mod published;
mod solver;
mod sparse;
mod standard_problems;
mod ties;
mod uff_peer;
mod verification;
