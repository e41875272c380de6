//! The predictions made last.

use super::{EvalError, Prediction};
use crate::model::MOST_DENSE_DOFS;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

/// Predictions by θ, the oldest first; as many as there are threads that may be searching, one of a large model.
///
/// A prediction depends on θ alone, so nothing but time depends on what is remembered.
#[derive(Debug)]
pub(super) struct Recent {
    kept: Mutex<VecDeque<(Vec<u64>, Arc<Prediction>)>>,
    most: usize,
}

impl Recent {
    pub(super) fn new(n_dof: usize) -> Self {
        let most = if n_dof > MOST_DENSE_DOFS { 1 } else { rayon::current_num_threads() };
        Self { kept: Mutex::default(), most }
    }

    /// The prediction at θ, made if it is not among the last ones.
    pub(super) fn get_or_make(
        &self,
        theta: &[f64],
        make: impl FnOnce() -> Result<Prediction, EvalError>,
    ) -> Result<Arc<Prediction>, EvalError> {
        let key: Vec<u64> = theta.iter().map(|v| v.to_bits()).collect();
        let lock = || self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, found)) = lock().iter().find(|(k, _)| *k == key) {
            return Ok(found.clone());
        }
        let made = Arc::new(make()?);
        let mut kept = lock();
        if kept.len() >= self.most {
            kept.pop_front();
        }
        kept.push_back((key, made.clone()));
        Ok(made)
    }
}
