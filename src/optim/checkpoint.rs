use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::CheckpointError;
use crate::linalg::{DMatrix, DVector};
use crate::objective::{EvalError, Linearization, PathCounts};

/// The journal of a run: every answer the objective has given, in order.
///
/// A method is a function of its settings, the seed and the answers it gets. So an interrupted run is continued by
/// starting the same method again and giving it the recorded answers, at no cost, until they are used up; from there
/// on it evaluates. That restores every method exactly, built in or a user's own, nested or not, with no state that
/// could be saved wrongly, and it allows a larger budget than before.
///
/// ```text
/// file   = "retune checkpoint 1\\n", seed, n_parameters, n_residuals, record*, zeros
/// record = kind (1 costs, 2 linearizations), number of points, length and hash of the points, answers, hash of the record
/// costs  = one each, then how many came by the batched kernel and how many by the reference path
/// ```
///
/// All numbers are 64-bit little-endian words, floating-point ones by their bits. Records are appended, and a torn last
/// record is dropped, so a kill at any moment leaves a usable file. Space for the whole budget of costs is written before
/// the work starts, so that a full disk is reported then.
#[derive(Debug)]
pub struct Checkpoint {
    path: PathBuf,
    file: File,
    /// What was read, from `position` on not yet replayed; empty when a run starts afresh.
    recorded: Vec<u8>,
    position: usize,
    begun: bool,
    n_residuals: u64,
    pending: Vec<u8>,
    flushed: Instant,
}

/// What two runs must share for one to continue the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Fingerprint {
    pub(super) seed: u64,
    pub(super) n_parameters: u64,
    pub(super) n_residuals: u64,
}

const MAGIC: &[u8; 20] = b"retune checkpoint 1\n";
const HEAD: usize = MAGIC.len() + 3 * WORD;
const WORD: usize = 8;
const COSTS: u64 = 1;
const LINEARIZATIONS: u64 = 2;
/// Written at least this often, so that a kill loses little: the wall clock decides when, never what.
const INTERVAL: Duration = Duration::from_secs(1);
const PENDING_LIMIT: usize = 1 << 16;
/// Space claimed for costs before the work starts, at most.
const RESERVE_LIMIT: u64 = 64 << 20;

impl Checkpoint {
    /// A new checkpoint file; it is refused if the file exists.
    pub fn create(path: impl AsRef<Path>) -> Result<Self, CheckpointError> {
        let path = path.as_ref();
        let file = OpenOptions::new().read(true).write(true).create_new(true).open(path).map_err(|source| {
            if source.kind() == io::ErrorKind::AlreadyExists {
                CheckpointError::Exists { path: path.to_owned() }
            } else {
                CheckpointError::File { action: "create", path: path.to_owned(), source }
            }
        })?;
        Ok(Self::new(path, file, Vec::new()))
    }

    /// The checkpoint that an interrupted run has left.
    pub fn resume(path: impl AsRef<Path>) -> Result<Self, CheckpointError> {
        let path = path.as_ref();
        let failed = |source| CheckpointError::File { action: "read", path: path.to_owned(), source };
        let mut file = OpenOptions::new().read(true).write(true).open(path).map_err(failed)?;
        let mut recorded = Vec::new();
        file.read_to_end(&mut recorded).map_err(failed)?;
        if !recorded.is_empty() && (recorded.len() < HEAD || !recorded.starts_with(MAGIC)) {
            let reason = format!("it does not begin with `{}`", String::from_utf8_lossy(MAGIC).trim_end());
            return Err(CheckpointError::Format { path: path.to_owned(), reason });
        }
        Ok(Self::new(path, file, recorded))
    }

    /// A new checkpoint on an open file.
    #[cfg(test)]
    pub(super) fn on(path: &Path, file: File) -> Self {
        Self::new(path, file, Vec::new())
    }

    fn new(path: &Path, file: File, recorded: Vec<u8>) -> Self {
        Self {
            path: path.to_owned(),
            file,
            recorded,
            position: 0,
            begun: false,
            n_residuals: 0,
            pending: Vec::new(),
            flushed: Instant::now(),
        }
    }

    /// Writes the head, or checks the one that was read; does nothing from the second call on.
    pub(super) fn begin(&mut self, run: &Fingerprint, budget: Option<u64>) -> Result<(), CheckpointError> {
        if self.begun {
            return Ok(());
        }
        self.begun = true;
        self.n_residuals = run.n_residuals;
        if self.recorded.is_empty() {
            self.pending.extend_from_slice(MAGIC);
            for word in [run.seed, run.n_parameters, run.n_residuals] {
                self.pending.extend_from_slice(&word.to_le_bytes());
            }
            self.reserve(budget.unwrap_or(0))?;
            return self.flush();
        }
        let head: Vec<u64> = (0..3).map(|i| word(&self.recorded[MAGIC.len()..], i)).collect();
        let found = Fingerprint { seed: head[0], n_parameters: head[1], n_residuals: head[2] };
        for (name, found, expected) in [
            ("seed", found.seed, run.seed),
            ("number of parameters", found.n_parameters, run.n_parameters),
            ("number of residuals", found.n_residuals, run.n_residuals),
        ] {
            if found != expected {
                return Err(self.other_run(format!("its {name} is {found}, not {expected}")));
            }
        }
        self.position = HEAD;
        Ok(())
    }

    /// The recorded costs of the first of these points, how many, and by which path; nothing if all records are used up.
    pub(super) fn next_costs(
        &mut self,
        points: &[DVector<f64>],
        out: &mut [f64],
    ) -> Result<Option<(usize, PathCounts)>, CheckpointError> {
        let Some(record) = self.next_record()? else { return Ok(None) };
        let n = record.n_points;
        // a budget may have cut the recorded batch short, so it can be the beginning of this one
        if record.kind != COSTS || n > points.len() || record.points != hash_points(&points[..n]) {
            return Err(self.other_points());
        }
        for (i, cost) in out.iter_mut().take(n).enumerate() {
            *cost = f64::from_bits(word(&self.recorded[record.answers.clone()], i));
        }
        let answers = &self.recorded[record.answers.clone()];
        let count = |i: usize| if answers.len() > (n + i) * WORD { word(answers, n + i) } else { 0 };
        let paths = PathCounts { batch: count(0), reference: count(1) };
        self.position = record.end;
        Ok(Some((n, paths)))
    }

    /// The recorded linearizations of these points; nothing if all records are used up.
    pub(super) fn next_linearizations(
        &mut self,
        points: &[DVector<f64>],
    ) -> Result<Option<Vec<Result<Linearization, EvalError>>>, CheckpointError> {
        let Some(record) = self.next_record()? else { return Ok(None) };
        if record.kind != LINEARIZATIONS || record.points != hash_points(points) {
            return Err(self.other_points());
        }
        let mut words = self.recorded[record.answers.clone()].chunks_exact(WORD).map(|w| word(w, 0));
        let mut next = || words.next().unwrap_or(0);
        let mut results = Vec::with_capacity(points.len());
        for x in points {
            let n_residuals = next();
            if n_residuals != self.n_residuals {
                results.push(Err(EvalError::Unsolvable { reason: "it could not be linearized".into() }));
                continue;
            }
            let n_residuals = n_residuals as usize;
            let residuals = DVector::from_fn(n_residuals, |_, _| f64::from_bits(next()));
            let jacobian = DMatrix::from_fn(n_residuals, x.len(), |_, _| f64::from_bits(next()));
            results.push(Ok(Linearization { residuals, jacobian }));
        }
        self.position = record.end;
        Ok(Some(results))
    }

    /// Records the costs of points.
    pub(super) fn append_costs(
        &mut self,
        points: &[DVector<f64>],
        costs: &[f64],
        paths: PathCounts,
    ) -> Result<(), CheckpointError> {
        self.append(COSTS, points, |out| {
            for cost in costs {
                push(out, cost.to_bits());
            }
            push(out, paths.batch);
            push(out, paths.reference);
        })
    }

    /// Records residuals and Jacobians.
    pub(super) fn append_linearizations(
        &mut self,
        points: &[DVector<f64>],
        results: &[Result<Linearization, EvalError>],
    ) -> Result<(), CheckpointError> {
        self.append(LINEARIZATIONS, points, |out| {
            for result in results {
                match result {
                    Ok(Linearization { residuals, jacobian }) => {
                        push(out, residuals.len() as u64);
                        residuals.iter().chain(jacobian.iter()).for_each(|v| push(out, v.to_bits()));
                    }
                    Err(_) => push(out, FAILED),
                }
            }
        })
    }

    fn append(
        &mut self,
        kind: u64,
        points: &[DVector<f64>],
        answers: impl FnOnce(&mut Vec<u8>),
    ) -> Result<(), CheckpointError> {
        let start = self.pending.len();
        for head in [kind, points.len() as u64, 0, hash_points(points)] {
            push(&mut self.pending, head);
        }
        answers(&mut self.pending);
        let length = (self.pending.len() - start) as u64 / WORD as u64 - 4;
        self.pending[start + 2 * WORD..start + 3 * WORD].copy_from_slice(&length.to_le_bytes());
        let check = hash_bytes(&self.pending[start..]);
        push(&mut self.pending, check);
        if self.pending.len() >= PENDING_LIMIT || self.flushed.elapsed() >= INTERVAL {
            self.flush()?;
        }
        Ok(())
    }

    /// Hands everything recorded so far to the operating system.
    pub(super) fn flush(&mut self) -> Result<(), CheckpointError> {
        if !self.pending.is_empty() {
            let written = self.file.write_all(&self.pending).map_err(|source| self.failed("write", source));
            // a second attempt would write the beginning twice
            self.pending.clear();
            written?;
        }
        self.flushed = Instant::now();
        Ok(())
    }

    /// Fills the file with zeros for a budget of costs and goes back to its beginning.
    fn reserve(&mut self, budget: u64) -> Result<(), CheckpointError> {
        // a batch of one point takes eight words; batches of many take one word a point
        let length = budget.saturating_mul(8 * WORD as u64).saturating_add(HEAD as u64).min(RESERVE_LIMIT);
        io::copy(&mut io::repeat(0).take(length), &mut self.file)
            .and_then(|_| self.file.sync_all())
            .and_then(|()| self.file.seek(SeekFrom::Start(0)))
            .map_err(|source| self.failed("write", source))?;
        Ok(())
    }

    /// The record at the present position; at the end of the usable ones, prepares the file for appending.
    fn next_record(&mut self) -> Result<Option<Record>, CheckpointError> {
        if self.recorded.is_empty() {
            return Ok(None);
        }
        if let Some(record) = Record::read(&self.recorded, self.position) {
            return Ok(Some(record));
        }
        self.file
            .set_len(self.position as u64)
            .and_then(|()| self.file.seek(SeekFrom::Start(self.position as u64)))
            .map_err(|source| self.failed("write", source))?;
        self.recorded = Vec::new();
        Ok(None)
    }

    /// The error for an objective that answers otherwise than the recorded one.
    pub(super) fn other_objective(&self, recorded: f64, found: f64) -> CheckpointError {
        self.other_run(format!("the cost of its first point is {recorded}, now {found}"))
    }

    fn other_points(&self) -> CheckpointError {
        self.other_run("it has answers at other points than the ones this run asks for".into())
    }

    fn other_run(&self, difference: String) -> CheckpointError {
        CheckpointError::OtherRun { path: self.path.clone(), difference }
    }

    fn failed(&self, action: &'static str, source: io::Error) -> CheckpointError {
        CheckpointError::File { action, path: self.path.clone(), source }
    }
}

impl Drop for Checkpoint {
    fn drop(&mut self) {
        // the run ends with an error already, or has been concluded and flushed
        let _ = self.flush();
    }
}

/// Stands for the number of residuals where there are none.
const FAILED: u64 = u64::MAX;

/// Where a record's parts lie.
struct Record {
    kind: u64,
    n_points: usize,
    points: u64,
    answers: std::ops::Range<usize>,
    end: usize,
}

impl Record {
    /// The record at `position`, if it is whole.
    fn read(bytes: &[u8], position: usize) -> Option<Self> {
        let bytes_left = bytes.get(position..)?;
        let n_words = bytes_left.len() / WORD;
        if n_words < 5 {
            return None;
        }
        let [kind, n_points, length, points] = [0, 1, 2, 3].map(|i| word(bytes_left, i));
        let whole = length <= (n_words - 5) as u64 && n_points <= length && matches!(kind, COSTS | LINEARIZATIONS);
        if !whole {
            return None;
        }
        let body = (4 + length as usize) * WORD;
        let intact = word(&bytes_left[body..], 0) == hash_bytes(&bytes_left[..body]);
        intact.then(|| Self {
            kind,
            n_points: n_points as usize,
            points,
            answers: position + 4 * WORD..position + body,
            end: position + body + WORD,
        })
    }
}

fn push(out: &mut Vec<u8>, word: u64) {
    out.extend_from_slice(&word.to_le_bytes());
}

fn word(bytes: &[u8], i: usize) -> u64 {
    let mut word = [0; WORD];
    word.copy_from_slice(&bytes[i * WORD..(i + 1) * WORD]);
    u64::from_le_bytes(word)
}

/// The FNV-1a hash, a word at a time (Fowler, Noll and Vo, 1991): finds torn records and changed runs, no attacker.
fn hash(words: impl Iterator<Item = u64>) -> u64 {
    words.fold(0xcbf2_9ce4_8422_2325, |h, word| {
        let h = (h ^ word).wrapping_mul(0x0000_0100_0000_01b3);
        h ^ (h >> 29)
    })
}

fn hash_points(points: &[DVector<f64>]) -> u64 {
    hash(points.iter().flat_map(|x| x.iter().map(|v| v.to_bits())))
}

fn hash_bytes(bytes: &[u8]) -> u64 {
    hash(bytes.chunks_exact(WORD).map(|w| word(w, 0)))
}
