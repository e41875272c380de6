//! Texts of files: where they came from, and what became of that of a model.

use crate::error::Wrong;
use crate::own::Elements;
use retune::data::read_file;
use retune::hash::sha256;
use retune::model::{Model, doubts, load_in};
use retune::yaml::Problem;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Files above this size are not YAML that a person wrote.
const LARGEST: u64 = 16 << 20;
/// Files of matrices of 10⁶ dofs have gigabytes.
const LARGEST_MATRICES: u64 = 8 << 30;

/// A model and where it came from.
#[derive(Debug)]
pub(crate) struct Source {
    pub(crate) text: String,
    pub(crate) home: Home,
    pub(crate) configuration: Option<String>,
    pub(crate) elements: Elements,
    pub(crate) model: Arc<Model>,
    pub(crate) warnings: Vec<Problem>,
}

/// Where a text came from.
#[derive(Debug, Clone, Default)]
pub(crate) struct Home {
    /// The file, if it came from one.
    pub(crate) path: Option<PathBuf>,
    /// Where the files are that it names.
    pub(crate) folder: PathBuf,
    /// Of the bytes of the file.
    pub(crate) sha256: Option<String>,
}

impl Home {
    pub(crate) fn file(path: PathBuf, sha256: String) -> Self {
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        Self { path: Some(path), folder, sha256: Some(sha256) }
    }

    /// Of a text that has been edited.
    pub(crate) fn edited(&self) -> Self {
        Self { sha256: None, ..self.clone() }
    }

    pub(crate) fn name(&self) -> Option<String> {
        self.path.as_ref().map(|p| p.display().to_string())
    }
}

/// The text of a file, and the hash of its bytes.
pub(crate) fn read(path: &Path) -> Result<(String, String), Wrong> {
    let wrong = |e: &dyn std::fmt::Display| Wrong::Problems {
        file: Some(path.display().to_string()),
        problems: vec![Problem::error("", format!("cannot read it: {e}"))],
    };
    let bytes = read_file(path, LARGEST).map_err(|e| wrong(&e))?;
    let sha256 = sha256(&bytes);
    Ok((retune::yaml::text_of(bytes).map_err(|e| wrong(&e))?, sha256))
}

impl Source {
    pub(crate) fn new(
        text: String,
        home: Home,
        configuration: Option<String>,
        elements: Elements,
    ) -> Result<Self, Wrong> {
        let mut open = |name: &str| read_file(&home.folder.join(name), LARGEST_MATRICES);
        let (model, mut warnings, map) = load_in(&text, configuration.as_deref(), &elements.registry(), &mut open)
            .map_err(|problems| Wrong::problems(home.name().as_deref(), problems))?;
        warnings.extend(map.place(doubts(&model)));
        Ok(Self { text, home, configuration, elements, model: Arc::new(model), warnings })
    }

    /// The same file in another configuration.
    pub(crate) fn configured(&self, name: &str) -> Result<Self, Wrong> {
        Self::new(self.text.clone(), self.home.clone(), Some(name.to_string()), self.elements.clone())
    }

    /// Another text in its place.
    pub(crate) fn edited(&self, text: String) -> Result<Self, Wrong> {
        Self::new(text, self.home.edited(), self.configuration.clone(), self.elements.clone())
    }

    /// The name of the file, or what stands in its place.
    pub(crate) fn file_name(&self) -> String {
        let name = self.home.path.as_deref().and_then(Path::file_name);
        name.map_or_else(|| "a text".to_string(), |n| n.to_string_lossy().into_owned())
    }
}
