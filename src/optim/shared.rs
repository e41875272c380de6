//! Evaluations that several processes share through a folder.

use crate::once::Once;
use std::error::Error;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::{Evaluator, Threads};
use crate::hash::Hash;
use crate::linalg::DVector;
use crate::objective::{EvalError, Linearization, Objective};

type Failed = Box<dyn Error + Send + Sync>;

/// An [`Evaluator`] for processes that all perform the same search, each a part of every batch: a generation of a sampler on several machines.
///
/// ```text
/// batch = piece 1 | piece 2 | ... | piece N       process i evaluates piece i and writes its costs into the folder,
///                                                 reads the other pieces there, and goes on with all costs
/// ```
///
/// As equal points have equal costs, every process takes the same way through the search and ends with the same bits as one that is alone. A piece
/// is a file named by the hash of its points, of the version and of costs of the objective: one that is there is not evaluated again, so a process
/// that was killed is started again and catches up. Nobody waits for long for a process that is not there: its pieces are evaluated by those
/// that are.
///
/// Shares costs; linearizations are evaluated by every process itself.
#[derive(Debug)]
pub struct Shared {
    folder: PathBuf,
    index: usize,
    of: usize,
    patience: Duration,
    /// Of the objective.
    fingerprint: Once<String>,
}

/// Points whose costs tell one objective from another.
const PROBES: usize = 8;
/// How often a process looks whether a piece is there.
const LOOK: Duration = Duration::from_millis(5);
/// How long a process waits for a piece at least.
const LEAST_PATIENCE: Duration = Duration::from_secs(2);
/// A process waits for a piece so many times as long as its own took.
const PATIENCE: u32 = 5;

impl Shared {
    /// A part of all evaluations, counted from 1; the folder is one that all processes see.
    ///
    /// # Errors
    /// Not 1 <= index <= of; a folder that cannot be made.
    pub fn new(folder: &Path, index: usize, of: usize) -> Result<Self, Failed> {
        if !(1..=of).contains(&index) {
            return Err(format!("shard {index}/{of}: the shards of {of} are 1/{of} ... {of}/{of}").into());
        }
        std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        let (folder, fingerprint) = (folder.to_path_buf(), Once::new());
        Ok(Self { folder, index, of, patience: LEAST_PATIENCE, fingerprint })
    }

    /// The same that waits for a piece at least so long.
    #[must_use]
    pub fn patient(self, patience: Duration) -> Self {
        Self { patience, ..self }
    }

    /// What tells this objective from any other one: the version, and its costs at the first points.
    fn fingerprint(&self, objective: &dyn Objective, points: &[DVector<f64>]) -> &str {
        self.fingerprint.get_or_find(|| {
            let probes = &points[..points.len().min(PROBES)];
            let mut costs = vec![f64::INFINITY; probes.len()];
            objective.costs(probes, &mut costs);
            let mut hash = Hash::new();
            hash.add(env!("CARGO_PKG_VERSION").as_bytes());
            hash.add(&(objective.n_residuals() as u64).to_le_bytes());
            probes.iter().flat_map(|x| x.iter()).chain(&costs).for_each(|v| hash.add(&v.to_bits().to_le_bytes()));
            hash.digits()
        })
    }

    fn path(&self, fingerprint: &str, points: &[DVector<f64>]) -> PathBuf {
        let mut hash = Hash::new();
        hash.add(fingerprint.as_bytes());
        points.iter().flat_map(|x| x.iter()).for_each(|v| hash.add(&v.to_bits().to_le_bytes()));
        self.folder.join(hash.digits() + ".costs")
    }

    /// Costs that another process has written, if they are there.
    fn read(path: &Path, out: &mut [f64]) -> bool {
        let Ok(bytes) = std::fs::read(path) else { return false };
        let (numbers, rest) = bytes.as_chunks::<8>();
        if numbers.len() != out.len() || !rest.is_empty() {
            return false;
        }
        out.iter_mut().zip(numbers).for_each(|(v, b)| *v = f64::from_le_bytes(*b));
        true
    }

    /// Whole or not at all; two that write the same piece write the same.
    fn write(&self, path: &Path, costs: &[f64]) -> std::io::Result<()> {
        let mut file = tempfile::Builder::new().prefix(".part-").tempfile_in(&self.folder)?;
        let bytes: Vec<u8> = costs.iter().flat_map(|v| v.to_le_bytes()).collect();
        file.write_all(&bytes)?;
        file.persist(path).map(|_| ()).map_err(|e| e.error)
    }
}

impl Evaluator for Shared {
    fn costs(
        &self,
        objective: &dyn Objective,
        points: &[DVector<f64>],
        out: &mut [f64],
        cancel: &AtomicBool,
    ) -> Result<(), Failed> {
        if points.is_empty() {
            return Ok(());
        }
        let fingerprint = self.fingerprint(objective, points).to_string();
        let size = points.len().div_ceil(self.of);
        let mut pieces: Vec<(&[DVector<f64>], &mut [f64])> = points.chunks(size).zip(out.chunks_mut(size)).collect();
        let n = pieces.len();
        // One's own first; then the others in turn, so that processes that lend a hand begin at different places.
        pieces.rotate_left((self.index - 1) % n);
        let mut own = Duration::ZERO;
        for (k, (points, out)) in pieces.into_iter().enumerate() {
            let path = self.path(&fingerprint, points);
            let is_own = k == 0 && self.index <= n;
            let begun = Instant::now();
            let mut is_there = Self::read(&path, out);
            while !is_there && !is_own && begun.elapsed() < self.patience.max(own * PATIENCE) {
                if cancel.load(Ordering::Relaxed) {
                    return Ok(());
                }
                std::thread::sleep(LOOK);
                is_there = Self::read(&path, out);
            }
            if !is_there {
                let begun = Instant::now();
                Threads.costs(objective, points, out, cancel)?;
                if cancel.load(Ordering::Relaxed) {
                    return Ok(());
                }
                own = own.max(begun.elapsed());
                self.write(&path, out).map_err(|e| format!("{}: {e}", path.display()))?;
            }
        }
        Ok(())
    }

    fn linearizations(
        &self,
        objective: &dyn Objective,
        points: &[DVector<f64>],
        cancel: &AtomicBool,
    ) -> Result<Vec<Result<Linearization, EvalError>>, Failed> {
        Threads.linearizations(objective, points, cancel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optim::Tmcmc;
    use std::sync::atomic::AtomicUsize;

    /// ½ |(x - ½)/0.1|², which counts the points that it is asked for.
    #[derive(Default)]
    struct Counted(AtomicUsize, f64);

    impl Objective for Counted {
        fn n_parameters(&self) -> usize {
            2
        }
        fn n_residuals(&self) -> usize {
            2
        }
        fn residuals(&self, x: &DVector<f64>) -> Result<DVector<f64>, EvalError> {
            self.0.fetch_add(1, Ordering::Relaxed);
            Ok(x.map(|v| (v - 0.5 + self.1) / 0.1))
        }
    }

    fn sampler() -> Tmcmc {
        Tmcmc { n_samples: 80, seed: 3, ..Tmcmc::default() }
    }

    #[test]
    fn three_shards_have_the_bits_of_one_run_and_share_its_work() {
        let alone = Counted::default();
        let expected = sampler().sample(&alone).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let counts: Vec<usize> = std::thread::scope(|scope| {
            let one = |index| {
                let folder = folder.path();
                scope.spawn(move || {
                    let objective = Counted::default();
                    let shared = Shared::new(folder, index, 3).unwrap().patient(Duration::from_secs(60));
                    let found = sampler().sample_by(&objective, &shared).unwrap();
                    (found, objective.0.into_inner())
                })
            };
            let all = [3, 1, 2].map(one);
            all.into_iter()
                .map(|thread| {
                    let (found, count) = thread.join().unwrap();
                    assert_eq!(found, expected);
                    count
                })
                .collect()
        });
        let whole = alone.0.into_inner();
        // A third each, one point more where a batch is not a multiple of three, and the probes.
        assert!(counts.iter().all(|&c| c < whole / 3 + whole / 20 + 8 + PROBES), "{counts:?} of {whole}");
        assert!(counts.iter().sum::<usize>() <= whole + 3 * PROBES, "{counts:?} of {whole}");
    }

    #[test]
    fn one_shard_of_four_ends_without_the_others_and_again_without_work() {
        let folder = tempfile::tempdir().unwrap();
        let run = || {
            let objective = Counted::default();
            let shared = Shared::new(folder.path(), 2, 4).unwrap().patient(Duration::ZERO);
            (sampler().sample_by(&objective, &shared).unwrap(), objective.0.into_inner())
        };
        let (first, _) = run();
        assert_eq!(first, sampler().sample(&Counted::default()).unwrap());
        let (again, count) = run();
        assert_eq!((again, count), (first, PROBES));
    }

    #[test]
    fn another_objective_takes_nothing_from_the_folder() {
        let folder = tempfile::tempdir().unwrap();
        let run = |objective: &Counted| {
            let shared = Shared::new(folder.path(), 1, 1).unwrap();
            sampler().sample_by(objective, &shared).unwrap()
        };
        let _ = run(&Counted::default());
        let moved = || Counted(AtomicUsize::new(0), 0.1);
        assert_eq!(run(&moved()), sampler().sample(&moved()).unwrap());
        // A piece that was cut short is evaluated again.
        for entry in std::fs::read_dir(folder.path()).unwrap() {
            std::fs::write(entry.unwrap().path(), b"half").unwrap();
        }
        assert_eq!(run(&moved()), sampler().sample(&moved()).unwrap());
        assert!(Shared::new(folder.path(), 4, 3).is_err());
    }
}
