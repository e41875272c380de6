//! Writing a report: the page, its data, single figures, files for ParaView; and where everything came from.

use crate::files;
use crate::output::{Failure, print};
use retune::report::data::{FileRecord, Named, ReportData};
use retune::report::{figures, html, json, paraview};
use sha2::{Digest, Sha256};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Where the parts of a report go.
#[derive(Debug, Default)]
pub(crate) struct Outputs<'a> {
    /// The page.
    pub(crate) page: Option<&'a PathBuf>,
    /// The data.
    pub(crate) json: Option<&'a PathBuf>,
    /// Folder of the figures.
    pub(crate) svg: Option<&'a PathBuf>,
    /// Folder of model and modes.
    pub(crate) vtk: Option<&'a PathBuf>,
    /// Whether existing files may be overwritten.
    pub(crate) force: bool,
}

impl Outputs<'_> {
    /// Refuses what exists or cannot be written, before any work is done.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        self.page.into_iter().chain(self.json).try_for_each(|path| files::check_output(path, self.force))
    }

    /// Writes everything asked for, and says what was written.
    pub(crate) fn write(&self, data: &ReportData) -> Result<Vec<String>, Failure> {
        let mut written = Vec::new();
        if let Some(path) = self.page {
            files::write(path, &html(data)?)?;
            written.push(path.display().to_string());
        }
        if let Some(path) = self.json {
            files::write(path, &json(data)?)?;
            written.push(path.display().to_string());
        }
        if let Some(folder) = self.svg {
            let list: Vec<_> = figures(data).into_iter().map(|f| (format!("{}.svg", f.name), f.svg)).collect();
            written.push(into_folder(folder, &list, self.force)?);
        }
        if let Some(folder) = self.vtk {
            let list: Vec<_> = paraview(data)?.into_iter().map(|f| (f.name, f.content)).collect();
            written.push(into_folder(folder, &list, self.force)?);
        }
        Ok(written)
    }
}

/// Prints what was written.
pub(crate) fn announce(written: &[String]) {
    for path in written {
        print(&format!("written: {path}\n"));
    }
}

fn into_folder(folder: &Path, list: &[(String, String)], force: bool) -> Result<String, Failure> {
    std::fs::create_dir_all(folder).map_err(|e| Failure::text(format!("cannot make {}: {e}", folder.display())))?;
    for (name, _) in list {
        files::check_output(&folder.join(name), force)?;
    }
    for (name, text) in list {
        files::write(&folder.join(name), text)?;
    }
    Ok(format!("{} files in {}", list.len(), folder.display()))
}

/// Records the files, the command, the seed and the versions in a report.
pub(crate) fn provenance(data: &mut ReportData, read: &[(&str, &Path)], seed: Option<u64>) -> Result<(), Failure> {
    for (role, path) in read {
        let bytes = std::fs::read(path).map_err(|e| Failure::text(format!("cannot read {}: {e}", path.display())))?;
        data.meta.files.push(FileRecord {
            role: (*role).into(),
            path: path.display().to_string(),
            sha256: hex(&Sha256::digest(&bytes)),
        });
    }
    data.meta.commands.push(command());
    data.meta.versions.push(Named::new("report schema", data.schema.to_string()));
    if let Some(seed) = seed {
        data.meta.seeds.push(Named::new("all random numbers", seed.to_string()));
    }
    Ok(())
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, b| {
        let _ = write!(text, "{b:02x}");
        text
    })
}

/// The command line as a shell would read it again.
fn command() -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,@%+".contains(c);
    let quoted = |word: String| {
        if !word.is_empty() && word.chars().all(plain) { word } else { format!("'{}'", word.replace('\'', "'\\''")) }
    };
    let words = std::env::args().skip(1).map(quoted);
    std::iter::once("retune".to_string()).chain(words).collect::<Vec<_>>().join(" ")
}
