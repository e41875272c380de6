//! Writing a report: the page, its data, single figures, files for ParaView; and where everything came from.

use crate::output::{Failure, keep, print, shown};
use crate::{ledger, writing};
use retune::catalogue::counted;
use retune_report::data::{FileRecord, Named, ReportData};
use retune_report::text::printable;
use retune_report::{figures, html, json, paraview};
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
        self.page.into_iter().chain(self.json).try_for_each(|path| writing::check_output(path, self.force))
    }

    /// Writes everything asked for, and says what was written.
    pub(crate) fn write(&self, data: &ReportData) -> Result<Vec<String>, Failure> {
        let mut written = Vec::new();
        if let Some(path) = self.page
            && writing::write(path, &html(data)?)
        {
            written.push(shown(path));
        }
        if let Some(path) = self.json
            && writing::write(path, &json(data)?)
        {
            written.push(shown(path));
        }
        if let Some(folder) = self.svg {
            let list: Vec<_> = figures(data).into_iter().map(|f| (format!("{}.svg", f.name), f.svg)).collect();
            written.extend(into_folder(folder, &list, self.force));
        }
        if let Some(folder) = self.vtk {
            let list: Vec<_> = paraview(data)?.into_iter().map(|f| (f.name, f.content)).collect();
            written.extend(into_folder(folder, &list, self.force));
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

fn into_folder(folder: &Path, list: &[(String, String)], force: bool) -> Option<String> {
    if let Err(e) = std::fs::create_dir_all(folder) {
        keep(Failure::text(format!("cannot make {}: {e}", shown(folder))));
        return None;
    }
    let one = |(name, text): &(String, String)| {
        let path = folder.join(name);
        writing::check_output(&path, force).map_err(keep).is_ok() && writing::write(&path, text)
    };
    let n = list.iter().filter(|entry| one(entry)).count();
    (n > 0).then(|| format!("{} in {}", counted(n, "file"), shown(folder)))
}

/// Records the files, the command, the seed and the versions in a report.
///
/// * `read` - the files and folders that the command names, with their roles; what they led to besides is recorded too
pub(crate) fn provenance(data: &mut ReportData, read: &[(&str, &Path)], seed: Option<u64>) {
    let mut left = ledger::everything_read();
    let mut record = |role: &str, path: &Path, sha256: String| {
        data.meta.files.push(FileRecord { role: role.into(), path: shown(path), sha256 });
    };
    for (role, named) in read {
        // A folder stands for its files.
        let (own, others): (Vec<_>, Vec<_>) = left.into_iter().partition(|(path, _)| path.starts_with(named));
        left = others;
        for (path, sha256) in own {
            record(role, &path, sha256);
        }
    }
    for (path, sha256) in left {
        record("read besides", &path, sha256);
    }
    data.meta.commands.push(command());
    data.meta.versions.push(Named::new("report schema", data.schema.to_string()));
    if let Some(seed) = seed {
        data.meta.seeds.push(Named::new("all random numbers", seed.to_string()));
    }
}

/// The command line as a shell would read it again.
fn command() -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,@%+".contains(c);
    let quoted = |word: &std::ffi::OsString| {
        let word = printable(&word.to_string_lossy());
        if !word.is_empty() && word.chars().all(plain) { word } else { format!("'{}'", word.replace('\'', "'\\''")) }
    };
    let words = crate::args::given().iter().map(quoted);
    std::iter::once("retune".to_string()).chain(words).collect::<Vec<_>>().join(" ")
}
