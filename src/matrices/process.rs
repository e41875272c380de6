//! A program that writes matrices, as a process: its input, where it runs, and what must be there when it ends.

use crate::hash::Hash;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// File in the folder of a run that says that it is complete.
pub const MARKER: &str = "complete.json";
/// File in the folder of a run that keeps what the program said.
const LOG: &str = "log.txt";
/// How often a process is looked at.
const LOOK: Duration = Duration::from_millis(20);
/// Lines of the log that an error shows.
const SHOWN: usize = 6;

/// A run of a program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Process {
    command: Vec<String>,
    files: Vec<(String, Arc<[u8]>)>,
    outputs: Vec<String>,
    time_limit: Duration,
    key: String,
}

/// Why a run left no matrices.
#[derive(Debug, thiserror::Error)]
pub enum ProcessError {
    /// The program is not there, or may not be run.
    #[error("`{program}` cannot be run: {source}")]
    NotRun {
        /// Its name.
        program: String,
        /// What the operating system says.
        source: io::Error,
    },
    /// It ended with an error.
    #[error("`{command}` ended with {status}; {log}")]
    Failed {
        /// The command.
        command: String,
        /// How.
        status: ExitStatus,
        /// Its last lines, and where all are.
        log: String,
    },
    /// It ended well and did not write what it should.
    #[error("`{command}` did not write `{file}`; {log}")]
    Missing {
        /// The command.
        command: String,
        /// The file.
        file: String,
        /// Its last lines, and where all are.
        log: String,
    },
    /// It took too long.
    #[error("`{command}` was stopped after {} s, its time limit; {log}", .limit.as_secs_f64())]
    TooLong {
        /// The command.
        command: String,
        /// The limit.
        limit: Duration,
        /// Its last lines, and where all are.
        log: String,
    },
    /// The user stopped it.
    #[error("stopped; what had been computed before is kept")]
    Stopped,
    /// A file could not be written or moved.
    #[error("{}: {source}", .path.display())]
    File {
        /// Its path.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
}

impl Process {
    /// * `command` - the program and its arguments
    /// * `files` - what it reads: paths relative to its folder, and bytes
    /// * `outputs` - files that it must have written
    /// * `time_limit` - after this it is stopped
    pub fn new(
        command: Vec<String>,
        files: Vec<(String, Arc<[u8]>)>,
        outputs: Vec<String>,
        time_limit: Duration,
    ) -> Self {
        let key = key(&command, &files, &outputs);
        Self { command, files, outputs, time_limit, key }
    }

    /// The program and its arguments.
    pub fn command(&self) -> &[String] {
        &self.command
    }

    /// A name that is that of no other run: SHA-256 of the command, of all files that it reads and of the names of those that it writes.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// Whether a complete run is there.
    ///
    /// * `folder` - where runs are kept, each in a folder with the name of its [key](Self::key)
    pub fn is_there(&self, folder: &Path) -> bool {
        folder.join(&self.key).join(MARKER).is_file()
    }

    /// Runs the program in a folder of its own and keeps what it wrote, its log too; returns how long it took.
    ///
    /// The folder appears under its name only once the run is complete. That of a run that failed ends in `.failed`.
    ///
    /// # Errors
    /// As [`ProcessError`] says.
    pub fn run(&self, folder: &Path, is_stopped: &dyn Fn() -> bool) -> Result<Duration, ProcessError> {
        let key = &self.key;
        let own = folder.join(format!("{key}.{}", std::process::id()));
        let result = self.run_in(&own, is_stopped);
        let kept = match &result {
            Ok(_) => folder.join(key),
            Err(ProcessError::Stopped) => {
                let _ = fs::remove_dir_all(&own);
                return result;
            }
            Err(_) => folder.join(format!("{key}.failed")),
        };
        // Of two that ran at once the last one stays: both wrote the same.
        let _ = fs::remove_dir_all(&kept);
        match fs::rename(&own, &kept) {
            Ok(()) => result,
            Err(source) => result.and(Err(ProcessError::File { path: kept, source })),
        }
    }

    fn run_in(&self, own: &Path, is_stopped: &dyn Fn() -> bool) -> Result<Duration, ProcessError> {
        let failed = |path: &Path| {
            let path = path.to_path_buf();
            move |source| ProcessError::File { path, source }
        };
        fs::create_dir_all(own).map_err(failed(own))?;
        for (name, bytes) in &self.files {
            let path = own.join(name);
            if let Some(parent) = path.parent() {
                fs::create_dir_all(parent).map_err(failed(parent))?;
            }
            fs::write(&path, bytes).map_err(failed(&path))?;
        }
        let log = own.join(LOG);
        let said = File::create(&log).map_err(failed(&log))?;
        let complaints = said.try_clone().map_err(failed(&log))?;
        let begun = Instant::now();
        let program = self.command.first().cloned().unwrap_or_default();
        let started = Command::new(&program)
            .args(self.command.iter().skip(1))
            .current_dir(own)
            .stdin(Stdio::null())
            .stdout(said)
            .stderr(complaints)
            .spawn();
        let mut child = started.map_err(|source| ProcessError::NotRun { program, source })?;
        let command = self.command.join(" ");
        let status = loop {
            match child.try_wait().map_err(failed(&log))? {
                Some(status) => break status,
                None if is_stopped() || begun.elapsed() > self.time_limit => {
                    let _ = child.kill();
                    let _ = child.wait();
                    if is_stopped() {
                        return Err(ProcessError::Stopped);
                    }
                    return Err(ProcessError::TooLong { command, limit: self.time_limit, log: last_lines(&log, own) });
                }
                None => std::thread::sleep(LOOK),
            }
        };
        // Ctrl-C reaches the program as well.
        if is_stopped() {
            return Err(ProcessError::Stopped);
        }
        if !status.success() {
            return Err(ProcessError::Failed { command, status, log: last_lines(&log, own) });
        }
        if let Some(file) = self.outputs.iter().find(|file| !own.join(file).is_file()) {
            return Err(ProcessError::Missing { command, file: file.clone(), log: last_lines(&log, own) });
        }
        let took = begun.elapsed();
        let content = serde_json::json!({"command": self.command, "seconds": took.as_secs_f64()});
        let marker = own.join(MARKER);
        fs::write(&marker, content.to_string() + "\n").map_err(failed(&marker))?;
        Ok(took)
    }
}

fn key(command: &[String], files: &[(String, Arc<[u8]>)], outputs: &[String]) -> String {
    let mut hash = Hash::new();
    let mut add = |bytes: &[u8]| {
        hash.add(&(bytes.len() as u64).to_le_bytes());
        hash.add(bytes);
    };
    for list in [command, outputs] {
        add(&(list.len() as u64).to_le_bytes());
        for text in list {
            add(text.as_bytes());
        }
    }
    for (name, bytes) in files {
        add(name.as_bytes());
        add(bytes);
    }
    let mut key = hash.digits();
    key.truncate(32);
    key
}

/// The last lines that a program said, and where the others will be.
fn last_lines(log: &Path, own: &Path) -> String {
    let text = fs::read(log).map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).unwrap_or_default();
    let lines: Vec<&str> = text.lines().filter(|l| !l.trim().is_empty()).collect();
    let kept = own.with_extension("failed").join(LOG);
    if lines.is_empty() {
        return format!("it said nothing ({})", kept.display());
    }
    let last = &lines[lines.len().saturating_sub(SHOWN)..];
    format!("its last lines ({} has all):\n    {}", kept.display(), last.join("\n    "))
}
