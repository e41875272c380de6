//! The pages of results, and where everything came from.

use crate::error::Wrong;
use crate::source::{Home, Source};
use crate::test::TestSource;
use crate::tested::Given;
use retune_report::data::{FileRecord, Named, ReportData};
use retune_report::html;
use std::sync::Arc;

/// The call, the seed and the versions.
pub(crate) fn sign_call(data: &mut ReportData, call: &str, seed: Option<u64>) {
    data.meta.commands.push(call.to_string());
    data.meta.versions.push(Named::new("report schema", data.schema.to_string()));
    if let Some(seed) = seed {
        data.meta.seeds.push(Named::new("all random numbers", seed.to_string()));
    }
}

/// What a result was made of, for its page.
#[derive(Debug, Clone)]
pub(crate) struct Made {
    pub(crate) given: Given,
    pub(crate) tests: Vec<Arc<TestSource>>,
    /// The call, in Python.
    pub(crate) call: &'static str,
    pub(crate) seed: Option<u64>,
}

impl Made {
    /// Files with their hashes, the call, the seed and the versions.
    pub(crate) fn sign(&self, data: &mut ReportData) {
        let mut record = |role: &str, home: &Home| {
            if let (Some(path), Some(sha256)) = (home.name(), home.sha256.clone()) {
                data.meta.files.push(FileRecord { role: role.into(), path, sha256 });
            }
        };
        if let Given::File(source) = &self.given {
            record("model", &source.home);
        }
        self.tests.iter().for_each(|t| record("test", &t.home));
        sign_call(data, self.call, self.seed);
    }

    /// The file that was given.
    pub(crate) fn source(&self) -> Result<&Arc<Source>, Wrong> {
        match &self.given {
            Given::File(source) => Ok(source),
            Given::External(model) => Err(Wrong::text(format!("{} is not a model file", model.name))),
        }
    }

    /// The page.
    pub(crate) fn page(&self, mut data: ReportData) -> Result<String, Wrong> {
        self.sign(&mut data);
        Ok(html(&data)?)
    }
}
