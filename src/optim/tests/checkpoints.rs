//! Killing a run at a random moment and resuming it gives the same bits.

use std::path::PathBuf;

use super::problems::{self, noise};
use super::*;

/// A file name of its own for each test, removed with the value.
struct TemporaryFile(PathBuf);

impl TemporaryFile {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("retune-{}-{test}.checkpoint", std::process::id()));
        let _ = std::fs::remove_file(&path);
        Self(path)
    }
}

impl Drop for TemporaryFile {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

fn run_with(method: &OptimizerSpec, budget: u64, seed: u64, checkpoint: Checkpoint) -> Result<Optimum, OptimError> {
    let problem = problems::two_minima();
    let mut run = Run::new(&problem).seed(seed).budget(budget).checkpoint(checkpoint);
    method.minimize(&problem.start, &mut run)
}

#[test]
fn a_run_killed_anywhere_resumes_to_the_same_bits() {
    let file = TemporaryFile::new("killed");
    for method in methods() {
        let _ = std::fs::remove_file(&file.0);
        let whole = run_with(&method, 3000, 1, Checkpoint::create(&file.0).unwrap()).unwrap();
        let journal = std::fs::read(&file.0).unwrap();
        let used = journal.iter().rposition(|b| *b != 0).unwrap() + 1;
        for kill in 0..8 {
            // a kill leaves the beginning of the journal, torn anywhere, and perhaps reserved zeros
            let torn = 44 + (noise(kill).abs() * (used - 44) as f64) as usize;
            let mut left = journal[..torn].to_vec();
            left.resize(torn + 1000 * (kill % 2), 0);
            std::fs::write(&file.0, left).unwrap();
            let resumed = run_with(&method, 3000, 1, Checkpoint::resume(&file.0).unwrap()).unwrap();
            assert_eq!(resumed, whole, "{}, torn at byte {torn}", method.name());
            let again = std::fs::read(&file.0).unwrap();
            assert_eq!(again[..used], journal[..used], "{}, torn at byte {torn}", method.name());
        }
    }
}

#[test]
fn recorded_answers_are_not_asked_again() {
    let file = TemporaryFile::new("recorded");
    let method = OptimizerSpec::by_name("levenberg-marquardt").unwrap();
    let whole = run_with(&method, 3000, 1, Checkpoint::create(&file.0).unwrap()).unwrap();
    let problem = problems::two_minima();
    let mut run = Run::new(&problem).seed(1).budget(3000).checkpoint(Checkpoint::resume(&file.0).unwrap());
    assert_eq!(method.minimize(&problem.start, &mut run).unwrap(), whole);
    // only the first point, to see that the objective is the same
    assert_eq!(problem.asked.load(Ordering::Relaxed), 1);
}

#[test]
fn a_run_may_be_continued_with_a_larger_budget() {
    let file = TemporaryFile::new("larger");
    let method = OptimizerSpec::by_name("nelder-mead").unwrap();
    let short = run_with(&method, 50, 1, Checkpoint::create(&file.0).unwrap()).unwrap();
    assert_eq!(short.termination, Termination::BudgetSpent);
    let continued = run_with(&method, 3000, 1, Checkpoint::resume(&file.0).unwrap()).unwrap();
    let problem = problems::two_minima();
    assert_eq!(continued, method.minimize(&problem.start, &mut Run::new(&problem)).unwrap());
}

#[test]
fn a_cancelled_run_resumes_to_the_same_bits() {
    let file = TemporaryFile::new("cancelled");
    let method = OptimizerSpec::by_name("differential-evolution").unwrap();
    let problem = problems::two_minima();
    let whole = method.minimize(&problem.start, &mut Run::new(&problem)).unwrap();

    let flag = Arc::new(AtomicBool::new(false));
    let mut stop_soon = |p: &Progress<'_>| flag.store(p.evaluations > 500, Ordering::Relaxed);
    let mut run = Run::new(&problem).cancel(Arc::clone(&flag)).observer(&mut stop_soon);
    run = run.checkpoint(Checkpoint::create(&file.0).unwrap());
    assert_eq!(method.minimize(&problem.start, &mut run).unwrap().termination, Termination::Cancelled);
    drop(run);

    let mut run = Run::new(&problem).checkpoint(Checkpoint::resume(&file.0).unwrap());
    assert_eq!(method.minimize(&problem.start, &mut run).unwrap(), whole);
}

#[test]
fn another_run_is_refused_with_the_difference() {
    let file = TemporaryFile::new("other");
    let method = OptimizerSpec::by_name("nelder-mead").unwrap();
    run_with(&method, 300, 1, Checkpoint::create(&file.0).unwrap()).unwrap();
    let resume = || Checkpoint::resume(&file.0).unwrap();

    let seed = run_with(&method, 300, 2, resume()).unwrap_err().to_string();
    assert!(seed.contains("its seed is 1, not 2"), "{seed}");

    let optimizer = run_with(&OptimizerSpec::by_name("differential-evolution").unwrap(), 300, 1, resume());
    let optimizer = optimizer.unwrap_err().to_string();
    assert!(optimizer.contains("it has answers at other points than the ones this run asks for"), "{optimizer}");

    let rosenbrock = problems::rosenbrock();
    let mut run = Run::new(&rosenbrock).seed(1).checkpoint(resume());
    let model = method.minimize(&problems::two_minima().start, &mut run).unwrap_err().to_string();
    assert!(model.contains("its number of residuals is 4, not 2"), "{model}");

    let shifted = Cost { n: 2, cost: |_: &DVector<f64>| 1.0 };
    let four = FourResiduals(shifted);
    let mut run = Run::new(&four).seed(1).checkpoint(resume());
    let objective = method.minimize(&problems::two_minima().start, &mut run).unwrap_err().to_string();
    assert!(objective.contains("the cost of its first point is") && objective.contains("now 1"), "{objective}");
}

/// An objective that differs by nothing but its values.
struct FourResiduals<O>(O);

impl<O: Objective> Objective for FourResiduals<O> {
    fn n_parameters(&self) -> usize {
        self.0.n_parameters()
    }

    fn n_residuals(&self) -> usize {
        4
    }

    fn residuals(&self, x: &DVector<f64>) -> Result<DVector<f64>, EvalError> {
        self.0.residuals(x)
    }

    fn cost(&self, x: &DVector<f64>) -> Result<f64, EvalError> {
        self.0.cost(x)
    }
}

#[test]
fn unusable_files_are_reported_before_the_work_starts() {
    let file = TemporaryFile::new("unusable");
    let missing = file.0.join("folder/that/is/missing");
    let error = Checkpoint::create(&missing).unwrap_err().to_string();
    assert!(error.starts_with("cannot create the checkpoint `"), "{error}");
    assert!(Checkpoint::resume(&missing).unwrap_err().to_string().starts_with("cannot read the checkpoint `"));

    std::fs::write(&file.0, "retune: 1").unwrap();
    assert!(Checkpoint::create(&file.0).unwrap_err().to_string().contains("exists; resume it, or remove it"));
    let error = Checkpoint::resume(&file.0).unwrap_err().to_string();
    assert!(error.contains("it does not begin with `retune checkpoint 1`"), "{error}");
}

#[test]
fn a_full_disk_is_reported_before_the_work_starts() {
    if !std::path::Path::new("/dev/full").exists() {
        eprintln!("skipped: there is no /dev/full");
        return;
    }
    // a device that reads as zeros and takes no byte: as an empty file on a full disk would
    let problem = problems::linear();
    let file = std::fs::OpenOptions::new().read(true).write(true).open("/dev/full").unwrap();
    let mut run = Run::new(&problem).budget(100).checkpoint(Checkpoint::on("/dev/full".as_ref(), file));
    let error = NelderMead::default().minimize(&problem.start, &mut run).unwrap_err().to_string();
    assert!(error.starts_with("cannot write the checkpoint `/dev/full`"), "{error}");
    assert_eq!(problem.asked.load(Ordering::Relaxed), 0);
}

#[test]
fn any_bytes_after_the_head_are_survived() {
    let file = TemporaryFile::new("garbage");
    let method = OptimizerSpec::by_name("nelder-mead").unwrap();
    let whole = run_with(&method, 300, 1, Checkpoint::create(&file.0).unwrap()).unwrap();
    let journal = std::fs::read(&file.0).unwrap();
    for case in 0..50 {
        let mut bytes = journal[..44].to_vec();
        bytes.extend((0..400).map(|i| (noise(1000 * case + i) * 300.0) as i64 as u8));
        std::fs::write(&file.0, bytes).unwrap();
        assert_eq!(run_with(&method, 300, 1, Checkpoint::resume(&file.0).unwrap()).unwrap(), whole);
    }
}
