//! The one way in which a file is written: whole or not at all, through links, with the permissions that it had, and never over a
//! file of this call.

use crate::interrupt::Temporary;
use crate::ledger::{self, Identity, Right};
use crate::output::{Failure, keep, print, shown};
use std::fs::{Metadata, OpenOptions};
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};

/// Links that lead to links, at most.
const LINKS: usize = 40;

/// What an output's name leads to.
enum Target {
    /// A file, or the place of one that is not there yet.
    File { path: PathBuf, meta: Option<Metadata> },
    /// A pipe or a device that takes bytes: `/dev/null`, `>(gzip)`.
    Stream,
    /// The standard output under a name.
    StandardOutput,
}

/// Refuses an output that exists, that is read or written by this call under any name, or that cannot be written, before any work is
/// done.
pub(crate) fn check_output(path: &Path, force: bool) -> Result<(), Failure> {
    check_room(path, force, 4096)
}

/// Like [`check_output`], for an output of this many bytes: a full disk too is reported before the work starts.
pub(crate) fn check_room(path: &Path, force: bool, bytes: usize) -> Result<(), Failure> {
    let Target::File { path: resolved, meta } = target(path).map_err(|e| unwritable(path, &e))? else { return Ok(()) };
    enter(path, &resolved, meta.as_ref(), if force { Right::Overwrite } else { Right::New })?;
    if meta.is_some() && !force {
        return Err(Failure::text(format!("{} exists; give --force to overwrite it", shown(path))));
    }
    let probe = || {
        let mut probe = Temporary::new(folder(&resolved))?;
        probe.file()?.write_all(&vec![b'\n'; bytes])?;
        probe.file()?.sync_all()
    };
    probe().map_err(|e| unwritable(path, &e.to_string()))
}

/// Whether an output's name leads to a file that is there already.
pub(crate) fn is_there(path: &Path) -> bool {
    matches!(target(path), Ok(Target::File { meta: Some(_), .. }))
}

/// Enters a file of which nobody but the library writes: a checkpoint.
pub(crate) fn reserve(path: &Path) -> Result<(), Failure> {
    match target(path).map_err(|e| unwritable(path, &e))? {
        Target::File { path: resolved, meta } => enter(path, &resolved, meta.as_ref(), Right::Overwrite),
        _ => Err(unwritable(path, "it is not a regular file")),
    }
}

/// Writes a file that was read anew.
pub(crate) fn edit(path: &Path, text: &str) -> Result<(), Failure> {
    match target(path).map_err(|e| unwritable(path, &e))? {
        Target::File { path: resolved, meta } => enter(path, &resolved, meta.as_ref(), Right::Edit)?,
        _ => return Err(unwritable(path, "it is not a regular file that could be edited; give `-o FILE`")),
    }
    try_to_write(path, text.as_bytes()).map_err(|e| unwritable(path, &e))
}

/// Writes an output whole or not at all. Where that fails the work is not lost for the others: the failure is kept, told at the end,
/// and the answer is `false`.
#[must_use]
pub(crate) fn write(path: &Path, text: &str) -> bool {
    write_bytes(path, text.as_bytes())
}

/// [`write()`] of what is not text.
#[must_use]
pub(crate) fn write_bytes(path: &Path, bytes: &[u8]) -> bool {
    let written = try_to_write(path, bytes).map_err(|e| unwritable(path, &e));
    match written {
        Ok(()) => true,
        Err(failure) => {
            keep(failure);
            false
        }
    }
}

fn unwritable(path: &Path, why: &str) -> Failure {
    Failure::text(format!("cannot write {}: {why}", shown(path)))
}

fn enter(path: &Path, resolved: &Path, meta: Option<&Metadata>, right: Right) -> Result<(), Failure> {
    if meta.is_some_and(|m| m.permissions().readonly()) {
        return Err(unwritable(path, "the file is write-protected"));
    }
    match Identity::of(resolved, meta) {
        Some(identity) => ledger::claim(path, resolved, identity, right),
        None => Ok(()),
    }
}

/// Follows links to what a name stands for, be it there or not.
fn target(path: &Path) -> Result<Target, String> {
    let mut at = path.to_path_buf();
    for _ in 0..LINKS {
        match std::fs::metadata(&at) {
            Ok(meta) if meta.is_file() && is_standard_output(path, &meta) => return Ok(Target::StandardOutput),
            Ok(meta) if meta.is_file() => {
                let path = at.canonicalize().map_err(|e| e.to_string())?;
                return Ok(Target::File { path, meta: Some(meta) });
            }
            Ok(meta) if meta.is_dir() => return Err("it is a folder, and a file is expected".to_string()),
            Ok(meta) if takes_bytes(&meta) => return Ok(Target::Stream),
            Ok(_) => return Err("it is not a regular file, a pipe or a character device".to_string()),
            Err(e) if e.kind() != ErrorKind::NotFound => return Err(e.to_string()),
            Err(_) => {}
        }
        let Some(name) = at.file_name().map(std::ffi::OsStr::to_os_string) else {
            return Err("the name of a file is expected".to_string());
        };
        let folder = folder(&at);
        // A link that leads to nothing is a name for the place it leads to.
        match std::fs::read_link(&at) {
            Ok(to) => at = folder.join(to),
            Err(_) => {
                let folder = folder.canonicalize().map_err(|e| match e.kind() {
                    ErrorKind::NotFound => format!("there is no folder {}", shown(folder)),
                    _ => e.to_string(),
                })?;
                return Ok(Target::File { path: folder.join(name), meta: None });
            }
        }
    }
    Err("its links lead round in a circle".to_string())
}

fn folder(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

#[cfg(unix)]
fn takes_bytes(meta: &Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    meta.file_type().is_char_device() || meta.file_type().is_fifo()
}

#[cfg(not(unix))]
fn takes_bytes(_: &Metadata) -> bool {
    false
}

/// Whether a name below `/dev` or `/proc` is that of the standard output: a file put in its place would not be seen by who reads it.
#[cfg(unix)]
fn is_standard_output(path: &Path, meta: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    let is_same = |own: Metadata| (own.dev(), own.ino()) == (meta.dev(), meta.ino());
    (path.starts_with("/dev") || path.starts_with("/proc")) && std::fs::metadata("/dev/stdout").is_ok_and(is_same)
}

#[cfg(not(unix))]
fn is_standard_output(_: &Path, _: &Metadata) -> bool {
    false
}

fn try_to_write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    let (resolved, meta) = match target(path)? {
        Target::File { path, meta } => (path, meta),
        Target::StandardOutput => {
            print(&String::from_utf8_lossy(bytes));
            return Ok(());
        }
        Target::Stream => {
            let mut stream = OpenOptions::new().write(true).open(path).map_err(|e| e.to_string())?;
            return match stream.write_all(bytes).and_then(|()| stream.flush()) {
                // Who reads a pipe may go when it has read enough.
                Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(e.to_string()),
                _ => Ok(()),
            };
        }
    };
    let replaces = ledger::claimed(path).unwrap_or(false);
    let mut temporary = Temporary::new(folder(&resolved)).map_err(|e| e.to_string())?;
    let fill = |temporary: &mut Temporary| {
        let file = temporary.file()?;
        file.write_all(bytes)?;
        if let Some(meta) = &meta {
            // The owner can be kept by few; the permissions by all.
            #[cfg(unix)]
            {
                use std::os::unix::fs::{MetadataExt, fchown};
                let own = file.metadata()?;
                if (own.uid(), own.gid()) != (meta.uid(), meta.gid()) {
                    let _ = fchown(&*file, Some(meta.uid()), Some(meta.gid()));
                }
            }
            file.set_permissions(meta.permissions())?;
        }
        file.sync_all()
    };
    fill(&mut temporary).map_err(|e| e.to_string())?;
    match temporary.rename(&resolved, replaces) {
        Err(e) if e.kind() == ErrorKind::AlreadyExists => {
            let mut name = resolved.file_name().unwrap_or_default().to_os_string();
            name.push(format!(".{}", std::process::id()));
            let beside = resolved.with_file_name(name);
            temporary.rename(&beside, false).map_err(|e| e.to_string())?;
            return Err(format!("somebody else has written it meanwhile; what belongs there is in {}", shown(&beside)));
        }
        done => done.map_err(|e| e.to_string())?,
    }
    // The name is safe when its folder is.
    if let Ok(folder) = std::fs::File::open(folder(&resolved)) {
        let _ = folder.sync_all();
    }
    Ok(())
}
