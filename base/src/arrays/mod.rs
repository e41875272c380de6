//! Named arrays in the files of NumPy and MATLAB, whatever they mean: measurements and matrices are both kept so.
//!
//! Each reader checks counts against the bytes there are before anything is stored, and what its values take in memory against
//! a limit.

pub mod mat;
#[cfg(test)]
pub(crate) mod mutate;
pub mod npy;
pub mod npz;

/// A folder of the real data that some tests use, if it is on this machine: in `RETUNE_DATA`, or beside the project.
#[cfg(test)]
pub(crate) fn shared_data(folder: &str) -> Option<std::path::PathBuf> {
    let beside = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    let root = std::env::var_os("RETUNE_DATA").map_or(beside, std::path::PathBuf::from);
    let path = root.join(folder);
    if path.exists() {
        return Some(path);
    }
    eprintln!("skipped: {} is not there; set RETUNE_DATA to the folder of the real data", path.display());
    None
}
