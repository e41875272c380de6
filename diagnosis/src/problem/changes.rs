//! Changes of large models that have been placed.

use retune::model::Change;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// A configuration of the file and the id of a candidate.
pub(crate) type Key = (Option<String>, String);

/// Changes of large models; `None` for one that is not made of elements.
#[derive(Debug, Default)]
pub(crate) struct Changes {
    known: Mutex<HashMap<Key, Option<Arc<Change>>>>,
}

impl Changes {
    /// Whether a candidate has been placed.
    pub(crate) fn has(&self, key: &Key) -> bool {
        self.known.lock().unwrap_or_else(PoisonError::into_inner).contains_key(key)
    }

    /// The change of a candidate that has been placed.
    pub(crate) fn get(&self, key: &Key) -> Option<Arc<Change>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner).get(key).cloned().flatten()
    }

    /// Takes over what has been placed.
    pub(crate) fn extend(&self, found: impl Iterator<Item = (Key, Option<Arc<Change>>)>) {
        self.known.lock().unwrap_or_else(PoisonError::into_inner).extend(found);
    }
}
