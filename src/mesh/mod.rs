//! Meshes of files: nodes, cells and named sets, whatever stands on them.
//!
//! Numbers in the unit of the file, and shapes by their corners; what is made of a cell is the business of `model`. A [`MeshReader`] takes
//! the bytes of one file and gives a [`Mesh`]; [`MESH_READERS`] lists them, [`read`] finds the one of a file.
//!
//! To add a format: a file here with a unit struct and `impl MeshReader`, `mod` and a line in [`MESH_READERS`].

mod abaqus;
mod cell;
mod cursor;
mod gmsh;
mod gmsh_text;
pub mod nastran;
#[cfg(test)]
mod tests;

pub use cell::{Cell, Mesh, MeshNode, MeshSet, Shape};
pub use cursor::MeshError;
pub use gmsh_text::write_gmsh;

use crate::catalogue::catalogue;

catalogue! {
    /// Every format of meshes; the first that recognises a file reads it.
    MESH_READERS: dyn MeshReader;
    gmsh::Gmsh,
    abaqus::Abaqus,
    nastran::Nastran,
}

/// A format: stateless.
pub trait MeshReader: std::fmt::Debug + Send + Sync {
    /// Its name, `kebab-case`.
    fn name(&self) -> &'static str;

    /// One sentence: what it is and which program writes it.
    fn summary(&self) -> &'static str;

    /// Whether a file is of this format, by its first bytes.
    fn recognises(&self, bytes: &[u8]) -> bool;

    /// Reads a file that it recognises.
    ///
    /// # Errors
    /// [`MeshError`]: where, what stands there, and what was expected.
    fn read(&self, bytes: &[u8]) -> Result<Mesh, MeshError>;
}

/// Reads a mesh in whatever format it is.
///
/// # Errors
/// [`MeshError`].
pub fn read(bytes: &[u8]) -> Result<Mesh, MeshError> {
    let Some(reader) = MESH_READERS.iter().find(|r| r.recognises(bytes)) else {
        let known: Vec<&str> = MESH_READERS.iter().map(|r| r.name()).collect();
        let message =
            format!("it is not a mesh of a format that is read ({}); `retune import` reads decks", known.join(", "));
        return Err(MeshError { place: String::new(), message });
    };
    reader.read(bytes)
}
