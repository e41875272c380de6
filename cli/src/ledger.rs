//! What this call has read and what it will write: nothing is written over what was read, nothing is written twice, and a page
//! states the hash of the bytes that were read.

use crate::output::{Failure, shown};
use retune::data::{MeasurementError, MeasurementOptions, Measurements, read_file, read_measurements_by};
use retune::hash::sha256;
use retune::identify::forward_in_time;
use std::fs::Metadata;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A file, whatever it is called.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Identity {
    /// Where the system numbers its files.
    #[cfg(unix)]
    Inode(u64, u64),
    /// A file that is not there yet, or whose system does not number them: its path without links, in small letters, because there are
    /// disks that do not tell them from capitals.
    Path(String),
}

impl Identity {
    /// Of a file or of its place; none of a pipe, a device, a folder.
    pub(crate) fn of(resolved: &Path, meta: Option<&Metadata>) -> Option<Self> {
        if meta.is_some_and(|m| !m.is_file()) {
            return None;
        }
        #[cfg(unix)]
        if let Some(meta) = meta {
            use std::os::unix::fs::MetadataExt;
            return Some(Self::Inode(meta.dev(), meta.ino()));
        }
        let path = resolved.canonicalize().unwrap_or_else(|_| resolved.to_path_buf());
        Some(Self::Path(path.as_os_str().to_string_lossy().to_lowercase()))
    }
}

/// What may be done to a file that is there already.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Right {
    /// Nothing.
    New,
    /// Overwrite it, unless it was read: `--force`.
    Overwrite,
    /// Overwrite it though it was read: that is what the verb is for.
    Edit,
}

#[derive(Debug)]
struct ReadFile {
    path: PathBuf,
    identity: Option<Identity>,
    sha256: String,
    /// What came from a pipe comes once.
    stream: Option<Arc<[u8]>>,
}

#[derive(Debug, Clone)]
struct Claim {
    path: PathBuf,
    /// Without links.
    resolved: PathBuf,
    identity: Identity,
    /// Whether the file may be one that was read: an edit.
    is_edit: bool,
    /// Whether a file that has this name may go.
    replaces: bool,
}

#[derive(Debug, Default)]
struct Ledger {
    read: Vec<ReadFile>,
    claims: Vec<Claim>,
}

static LEDGER: Mutex<Ledger> = Mutex::new(Ledger { read: Vec::new(), claims: Vec::new() });

fn ledger() -> MutexGuard<'static, Ledger> {
    LEDGER.lock().unwrap_or_else(PoisonError::into_inner)
}

fn refused(text: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, text)
}

/// The bytes of a file, entered with their hash.
///
/// # Errors
/// As [`read_file`]; a file that shall be written; one that has changed since it was read before.
pub(crate) fn read(path: &Path, largest: u64) -> io::Result<Vec<u8>> {
    let known = ledger().read.iter().find(|r| r.path == path).and_then(|r| r.stream.clone());
    if let Some(bytes) = known {
        return within(bytes.to_vec(), largest);
    }
    let meta = std::fs::metadata(path)?;
    let identity = Identity::of(path, Some(&meta));
    let is_file = meta.is_file();
    let bytes = read_file(path, if is_file { largest } else { u64::MAX })?;
    let sha256 = sha256(&bytes);
    let mut ledger = ledger();
    let claim = ledger.claims.iter().find(|c| !c.is_edit && Some(&c.identity) == identity.as_ref());
    if let Some(claim) = claim {
        let text = format!("the output {} would be written over it; write to another file", shown(&claim.path));
        return Err(refused(text));
    }
    if let Some(before) = ledger.read.iter().find(|r| r.path == path) {
        return if before.sha256 == sha256 {
            Ok(bytes)
        } else {
            Err(refused("it was changed while it was in use; start again".to_string()))
        };
    }
    let stream = (!is_file).then(|| Arc::from(bytes.as_slice()));
    ledger.read.push(ReadFile { path: path.to_path_buf(), identity, sha256, stream });
    within(bytes, largest)
}

/// The bytes, if they are not too many.
fn within(bytes: Vec<u8>, largest: u64) -> io::Result<Vec<u8>> {
    if bytes.len() as u64 > largest {
        let text = format!("it gave {} bytes, more than the {largest} that are read", bytes.len());
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, text));
    }
    Ok(bytes)
}

/// [`retune::data::read_measurements`] with all that it reads entered, the functions for exp(+iωt), notes on standard error.
pub(crate) fn measurements(
    files: &[PathBuf],
    geometry: Option<&Path>,
    options: &MeasurementOptions,
) -> Result<Measurements, MeasurementError> {
    let mut found = read_measurements_by(&mut read, files, geometry, options)?;
    for (path, note) in &found.notes {
        let place = if path.as_os_str().is_empty() { String::new() } else { format!("{}: ", path.display()) };
        note!("{place}{note}");
    }
    if forward_in_time(&mut found) {
        warning!("the functions are written for exp(-iωt): the imaginary parts of all of them are reversed");
    }
    Ok(found)
}

/// Enters a file that shall be written.
///
/// # Errors
/// It was read, unless this is an edit of it; another output has it.
pub(crate) fn claim(path: &Path, resolved: &Path, identity: Identity, right: Right) -> Result<(), Failure> {
    let is_edit = right == Right::Edit;
    let mut ledger = ledger();
    if let Some(r) = ledger.read.iter().find(|r| !is_edit && r.identity.as_ref() == Some(&identity)) {
        return Err(Failure::text(format!(
            "{} would be overwritten, and this command reads it{}; write to another file",
            shown(path),
            if r.path == path { String::new() } else { format!(" as {}", shown(&r.path)) }
        )));
    }
    if let Some(c) = ledger.claims.iter().find(|c| c.identity == identity) {
        let how = if c.resolved == resolved { "" } else { " on a disk that does not tell capitals from small letters" };
        let (one, other) = (shown(&c.path), shown(path));
        return Err(Failure::text(format!(
            "two outputs go to one file{how}: {one} and {other}; give each a name of its own"
        )));
    }
    ledger.claims.push(Claim {
        path: path.to_path_buf(),
        resolved: resolved.to_path_buf(),
        identity,
        is_edit,
        replaces: right != Right::New,
    });
    Ok(())
}

/// Whether a path has been entered as an output, and then whether it may take the place of a file.
pub(crate) fn claimed(path: &Path) -> Option<bool> {
    ledger().claims.iter().find(|c| c.path == path).map(|c| c.replaces)
}

/// Paths and hashes of everything that was read, in the order of reading.
pub(crate) fn everything_read() -> Vec<(PathBuf, String)> {
    ledger().read.iter().map(|r| (r.path.clone(), r.sha256.clone())).collect()
}
