//! Ctrl-C and the wish to end (SIGTERM): a verb that promises the best so far is stopped cleanly, any other one ends at once; no
//! temporary file stays in either case.

use crate::output::tell;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What a signal finds.
struct State {
    /// Files that are not yet what they shall become.
    temporary: BTreeSet<PathBuf>,
    /// Stops the search that runs.
    stop: Option<Arc<AtomicBool>>,
    /// What an end before that search means.
    before: Option<&'static str>,
}

static STATE: Mutex<State> = Mutex::new(State { temporary: BTreeSet::new(), stop: None, before: None });

fn state() -> MutexGuard<'static, State> {
    STATE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Listens from now on.
pub(crate) fn watch() {
    #[cfg(unix)]
    {
        use signal_hook::consts::{SIGINT, SIGTERM};
        // Where nobody can listen a signal ends the program, as usual.
        if let Ok(mut signals) = signal_hook::iterator::Signals::new([SIGINT, SIGTERM]) {
            std::thread::spawn(move || signals.forever().for_each(received));
        }
    }
    #[cfg(not(unix))]
    let _ = ctrlc::set_handler(|| received(2));
}

fn received(signal: i32) {
    let state = state();
    if let Some(flag) = &state.stop
        && !flag.swap(true, Ordering::SeqCst)
    {
        drop(state);
        tell("\nstopping; once more Ctrl-C ends at once");
        return;
    }
    // The lock stays: nothing new begins.
    for path in &state.temporary {
        let _ = std::fs::remove_file(path);
    }
    if let (Some(text), None) = (state.before, &state.stop) {
        tell(&format!("\n{text}"));
    }
    #[cfg(unix)]
    let _ = signal_hook::low_level::emulate_default_handler(signal);
    std::process::exit(128 + signal);
}

/// States what it means when the verb is stopped before it can be by [`stop_flag`].
pub(crate) fn before_search(text: &'static str) {
    state().before = Some(text);
}

/// A flag that the first signal sets; the second one ends the program.
pub(crate) fn stop_flag() -> Arc<AtomicBool> {
    let flag = Arc::new(AtomicBool::new(false));
    state().stop = Some(Arc::clone(&flag));
    flag
}

/// Whether a search was stopped.
pub(crate) fn was_stopped() -> bool {
    state().stop.as_ref().is_some_and(|flag| flag.load(Ordering::SeqCst))
}

/// A temporary file in a folder, created as a new one and gone when dropped or when a signal ends the program.
#[derive(Debug)]
pub(crate) struct Temporary {
    path: PathBuf,
    /// The file; none after it became what it shall be.
    file: Option<tempfile::NamedTempFile>,
}

impl Temporary {
    /// A new file; with the permissions that the system gives to new files.
    pub(crate) fn new(folder: &Path) -> std::io::Result<Self> {
        // While the lock is held no signal can come between the file and its record.
        let mut state = state();
        let mut builder = tempfile::Builder::new();
        builder.prefix(".retune-").suffix(".part");
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let file = builder.tempfile_in(folder)?;
        let path = file.path().to_path_buf();
        state.temporary.insert(path.clone());
        Ok(Self { path, file: Some(file) })
    }

    /// The open file.
    pub(crate) fn file(&mut self) -> std::io::Result<&mut std::fs::File> {
        self.file.as_mut().map(tempfile::NamedTempFile::as_file_mut).ok_or_else(|| std::io::ErrorKind::NotFound.into())
    }

    /// Gives it its name, in place of the file that has it, or only where none has.
    pub(crate) fn rename(&mut self, to: &Path, replace: bool) -> std::io::Result<()> {
        let Some(file) = self.file.take() else { return Err(std::io::ErrorKind::NotFound.into()) };
        let renamed = if replace { file.persist(to) } else { file.persist_noclobber(to) };
        // Not every disk can rename only where nothing is.
        let renamed = renamed.or_else(|e| if to.exists() { Err(e) } else { e.file.persist(to) });
        renamed.map(drop).map_err(|e| {
            self.file = Some(e.file);
            e.error
        })
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        drop(self.file.take());
        state().temporary.remove(&self.path);
    }
}
