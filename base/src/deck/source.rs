//! Files of a deck, and how an INCLUDE finds its own.

use std::path::{Path, PathBuf};

/// One file.
#[derive(Debug, Clone)]
pub struct Source {
    path: PathBuf,
    name: String,
    text: String,
    is_latin: bool,
}

/// One INCLUDE statement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Include {
    /// Index of the file in which it stands.
    pub file: u32,
    /// Line of it, from 1.
    pub line: u32,
    /// Index of the file that it includes.
    pub target: u32,
}

impl Source {
    pub(super) fn new(path: &Path, bytes: Vec<u8>) -> Self {
        let (text, is_latin) = match String::from_utf8(bytes) {
            Ok(text) => (text, false),
            // Decks of old machines are Latin-1: every byte is a letter.
            Err(e) => (e.as_bytes().iter().map(|b| char::from(*b)).collect(), true),
        };
        Self { path: path.to_path_buf(), name: path.display().to_string(), text, is_latin }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its path for messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Whether its bytes are not UTF-8 and were read as Latin-1.
    pub fn is_latin(&self) -> bool {
        self.is_latin
    }
}

/// The file that `given` means in a deck: beside the file that names it, else beside the first one; letters in any case; of a path of
/// another machine the name alone.
pub(super) fn find(given: &str, beside: &Path, first: &Path) -> Option<PathBuf> {
    let given = given.replace('\\', "/");
    let name = given.rsplit('/').next().unwrap_or(&given).to_string();
    let is_drive = given.as_bytes().get(1) == Some(&b':');
    let folder = |p: &Path| p.parent().map_or_else(PathBuf::new, Path::to_path_buf);
    let roots = [folder(beside), folder(first)];
    let whole = roots.iter().filter(|_| !is_drive).find_map(|root| exists(root, &given));
    whole.or_else(|| roots.iter().find_map(|root| exists(root, &name)))
}

/// A path below a folder, letters in any case.
fn exists(root: &Path, relative: &str) -> Option<PathBuf> {
    let exact = root.join(relative);
    if exact.is_file() {
        return Some(exact);
    }
    let mut at = if relative.starts_with('/') { PathBuf::from("/") } else { root.to_path_buf() };
    for part in relative.split('/').filter(|p| !p.is_empty() && *p != ".") {
        if part == ".." || at.join(part).exists() {
            at.push(part);
            continue;
        }
        let folder = if at.as_os_str().is_empty() { Path::new(".") } else { &at };
        let mut fitting: Vec<_> = std::fs::read_dir(folder)
            .ok()?
            .filter_map(|e| e.ok().map(|e| e.file_name()))
            .filter(|n| n.to_string_lossy().eq_ignore_ascii_case(part))
            .collect();
        fitting.sort();
        at.push(fitting.first()?);
    }
    at.is_file().then_some(at)
}
