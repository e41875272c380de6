//! Files that were read, each once.

use crate::matrices::{self, Contents};
use std::collections::HashMap;
use std::io;
use std::sync::Arc;

/// How the bytes of a file come, by its path in the model file.
type Read<'a> = dyn FnMut(&str) -> io::Result<Vec<u8>> + 'a;

/// Files by their paths.
pub(super) struct Files<'a> {
    read: &'a mut Read<'a>,
    known: HashMap<String, Result<Arc<Contents>, String>>,
}

impl<'a> Files<'a> {
    pub(super) fn new(read: &'a mut Read<'a>) -> Self {
        Self { read, known: HashMap::new() }
    }

    /// The bytes of a file.
    pub(super) fn bytes(&mut self, file: &str) -> io::Result<Vec<u8>> {
        (self.read)(file)
    }

    /// What a file holds, or why that is not known.
    pub(super) fn contents(&mut self, file: &str) -> Result<Arc<Contents>, String> {
        if let Some(known) = self.known.get(file) {
            return known.clone();
        }
        let read = (self.read)(file).map_err(|e| format!("it cannot be read: {e}"));
        let contents = read.and_then(|bytes| matrices::read(file, &bytes).map_err(|e| e.to_string())).map(Arc::new);
        self.known.insert(file.to_string(), contents.clone());
        contents
    }
}
