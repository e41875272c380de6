//! What people look at: tables for a terminal.

pub mod text;
