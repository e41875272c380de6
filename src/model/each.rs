//! A pass over many elements.

use rayon::prelude::*;

/// Elements from which on a pass over them goes over all threads: below, a search is on all of them already, and a pass costs less than asking them.
const MANY_ELEMENTS: usize = 512;

/// What each item gives, in their order.
pub(super) fn of_each<T: Sync, R: Send>(items: &[T], of: impl Fn(&T) -> R + Sync + Send) -> Vec<R> {
    if items.len() < MANY_ELEMENTS { items.iter().map(of).collect() } else { items.par_iter().map(of).collect() }
}
