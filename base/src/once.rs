//! Values that are found when they are first asked for. The only place that names [`OnceLock`].

use std::sync::OnceLock;

/// A value that is found when it is first asked for, and kept.
///
/// Threads that ask at the same time each find it, and the first to end is the one that counts: nobody waits. A [`OnceLock`] alone lets one find it
/// while the others wait, and a worker of a pool that finds it by parallel work may meanwhile be given other work of the pool that asks for the same
/// value: it waits for itself, for ever. What is kept here must therefore be the same whoever finds it.
#[derive(Debug, Clone)]
pub struct Once<T>(OnceLock<T>);

impl<T> Default for Once<T> {
    fn default() -> Self {
        Self(OnceLock::new())
    }
}

impl<T> Once<T> {
    /// Not found yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// The value, if somebody has asked for it before.
    pub fn get(&self) -> Option<&T> {
        self.0.get()
    }

    /// The value, found now if nobody has asked for it before.
    pub fn get_or_find(&self, find: impl FnOnce() -> T) -> &T {
        if let Some(known) = self.0.get() {
            return known;
        }
        let found = find();
        self.0.get_or_init(|| found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;
    use std::sync::Arc;
    use std::sync::mpsc;
    use std::time::Duration;

    /// Each of the workers, while it finds the value by work that all workers share, is given another question for the same value.
    #[test]
    fn workers_that_share_the_finding_do_not_wait_for_themselves() {
        let (tell, told) = mpsc::channel();
        std::thread::spawn(move || {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
            let once = Arc::new(Once::new());
            let ask = |_| {
                *once.get_or_find(|| {
                    let parts = (0..64_usize).into_par_iter().with_max_len(1);
                    parts.map(|i| (0..20_000).fold(i, |a, b| std::hint::black_box(a ^ b)) & 1).count()
                })
            };
            let answers: Vec<usize> =
                pool.install(|| (0..256_usize).into_par_iter().with_max_len(1).map(ask).collect());
            let _ = tell.send(answers);
        });
        let answers = told.recv_timeout(Duration::from_secs(60)).expect("nobody waits for ever");
        assert_eq!(answers, vec![64; 256]);
    }

    #[test]
    fn a_value_is_found_once_and_kept() {
        let once = Once::new();
        assert_eq!(once.get(), None);
        assert_eq!(*once.get_or_find(|| 3), 3);
        assert_eq!(*once.get_or_find(|| unreachable!()), 3);
        assert_eq!(once.get(), Some(&3));
    }
}
