//! The element types that a model file may name: the built-in ones and a user's own.

use crate::element::{ELEMENTS, Element};

/// Element types by name.
///
/// ```
/// use retune::model::Registry;
/// let registry = Registry::builtin();
/// assert!(registry.find("beam").is_some());
/// ```
#[derive(Debug, Clone)]
pub struct Registry {
    elements: Vec<&'static dyn Element>,
}

impl Registry {
    /// The built-in types.
    pub fn builtin() -> Self {
        Self { elements: ELEMENTS.to_vec() }
    }

    /// With one more; a type of the same name replaces the built-in one.
    #[must_use]
    pub fn with(mut self, element: &'static dyn Element) -> Self {
        self.elements.retain(|e| e.name() != element.name());
        self.elements.push(element);
        self
    }

    /// The type of a name.
    pub fn find(&self, name: &str) -> Option<&'static dyn Element> {
        self.elements.iter().copied().find(|e| e.name() == name)
    }

    /// All of them.
    pub fn elements(&self) -> impl Iterator<Item = &'static dyn Element> + '_ {
        self.elements.iter().copied()
    }
}

impl Default for Registry {
    fn default() -> Self {
        Self::builtin()
    }
}
