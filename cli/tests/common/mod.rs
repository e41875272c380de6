//! What several tests of the command share.

use std::path::Path;
use std::process::{Command, Stdio};

/// Runs the command in a folder with words that blanks part: exit code, standard output, standard error.
pub(crate) fn run(folder: &Path, line: &str) -> (i32, String, String) {
    let done = Command::new(env!("CARGO_BIN_EXE_retune"))
        .current_dir(folder)
        .args(line.split_whitespace())
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (done.status.code().unwrap_or(-1), text(done.stdout), text(done.stderr))
}
