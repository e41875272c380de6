//! Any method, taken apart into questions and answers.

use std::error::Error;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

use super::{Evaluator, OptimError, Optimizer, Optimum, Run};
use crate::linalg::DVector;
use crate::objective::{EvalError, Linearization, Objective, Walls};

/// A search that asks for evaluations and is told their results, for engines that cannot be called.
///
/// ```
/// use retune::linalg::DVector;
/// use retune::optim::{Ask, AskTell, NelderMead, OptimError, Problem};
/// use std::sync::Arc;
///
/// let problem = Problem { n_parameters: 2, n_residuals: 0, seed: 1, budget: Some(2_000) };
/// let mut search = AskTell::new(Arc::new(NelderMead::default()), DVector::from_element(2, 0.9), problem);
/// let best = loop {
///     let costs: Vec<f64> = match search.ask()? {
///         // Here the points would go to another process, and their costs come back, in this order.
///         Ask::Costs(points) => points.iter().map(|x| (x[0] - 0.3).powi(2) + (x[1] - x[0]).powi(2)).collect(),
///         Ask::Linearizations(_) => unreachable!("this method asks for costs only"),
///         Ask::Done(optimum) => break optimum.clone(),
///     };
///     search.tell_costs(&costs)?;
/// };
/// assert!((best.x[1] - 0.3).abs() < 1e-4);
/// # Ok::<(), OptimError>(())
/// ```
///
/// The method runs unchanged on a thread of its own that sleeps while a question is open, so this works for every
/// [`Optimizer`], a user's own and nested ones included, and visits the same points as a [`Run`] with the same seed.
#[derive(Debug)]
pub struct AskTell {
    questions: Receiver<Question>,
    answers: Option<Sender<Answer>>,
    thread: Option<JoinHandle<Result<Optimum, OptimError>>>,
    open: Option<Question>,
    optimum: Option<Optimum>,
}

/// What a method must know of the objective, and its share of the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Problem {
    /// Length of x.
    pub n_parameters: usize,
    /// Length of the residuals; 0 if only costs can be told.
    pub n_residuals: usize,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Evaluations allowed, a linearization counted as one.
    pub budget: Option<u64>,
}

/// What a search wants to know next.
#[derive(Debug)]
pub enum Ask<'a> {
    /// The costs of these points.
    Costs(&'a [DVector<f64>]),
    /// Residuals and Jacobians at these points.
    Linearizations(&'a [DVector<f64>]),
    /// Nothing: the search has ended.
    Done(&'a Optimum),
}

#[derive(Debug)]
enum Question {
    Costs(Vec<DVector<f64>>),
    Linearizations(Vec<DVector<f64>>),
}

type Linearizations = Vec<Result<Linearization, EvalError>>;

#[derive(Debug)]
enum Answer {
    Costs(Vec<f64>),
    Linearizations(Linearizations),
}

impl AskTell {
    /// Starts a search; it waits at its first question.
    pub fn new(optimizer: Arc<dyn Optimizer>, start: DVector<f64>, problem: Problem) -> Self {
        Self::with_walls(optimizer, start, problem, Walls::default())
    }

    /// Starts a search of an objective some of whose residuals stand for constraints.
    pub fn with_walls(optimizer: Arc<dyn Optimizer>, start: DVector<f64>, problem: Problem, walls: Walls) -> Self {
        let (ask, questions) = channel();
        let (answers, told) = channel();
        let thread = std::thread::spawn(move || {
            let elsewhere = Elsewhere { ask, told: Mutex::new(told), problem, walls };
            let mut run = Run::new(&elsewhere).seed(problem.seed).evaluator(&elsewhere);
            if let Some(budget) = problem.budget {
                run = run.budget(budget);
            }
            optimizer.minimize(&start, &mut run)
        });
        Self { questions, answers: Some(answers), thread: Some(thread), open: None, optimum: None }
    }

    /// The open question: the same one until it is answered.
    pub fn ask(&mut self) -> Result<Ask<'_>, OptimError> {
        if self.open.is_none() {
            self.open = self.questions.recv().ok();
        }
        if self.open.is_none()
            && let Some(thread) = self.thread.take()
        {
            self.optimum = Some(thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))?);
        }
        match (&self.open, &self.optimum) {
            (Some(Question::Costs(points)), _) => Ok(Ask::Costs(points)),
            (Some(Question::Linearizations(points)), _) => Ok(Ask::Linearizations(points)),
            (None, Some(optimum)) => Ok(Ask::Done(optimum)),
            (None, None) => Err(OptimError::Evaluator { source: "the search has failed before".into() }),
        }
    }

    /// Answers a question for costs; one that is not finite says that the point cannot be evaluated.
    pub fn tell_costs(&mut self, costs: &[f64]) -> Result<(), OptimError> {
        self.tell("costs", costs.len(), || Answer::Costs(costs.to_vec()))
    }

    /// Answers a question for linearizations.
    pub fn tell_linearizations(&mut self, linearizations: Linearizations) -> Result<(), OptimError> {
        self.tell("linearizations", linearizations.len(), || Answer::Linearizations(linearizations))
    }

    fn tell(&mut self, kind: &str, found: usize, answer: impl FnOnce() -> Answer) -> Result<(), OptimError> {
        let (asked, expected) = match &self.open {
            Some(Question::Costs(points)) => ("costs", points.len()),
            Some(Question::Linearizations(points)) => ("linearizations", points.len()),
            None => ("answers", 0),
        };
        if kind != asked || found != expected {
            return Err(OptimError::Answers { found, expected, kind: asked });
        }
        self.open = None;
        if let Some(answers) = &self.answers {
            // a thread that no longer listens has ended, and `ask` will say how
            let _ = answers.send(answer());
        }
        Ok(())
    }
}

impl Drop for AskTell {
    fn drop(&mut self) {
        // the waiting thread finds nobody to answer, and ends
        self.answers = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// An objective that is evaluated by whoever answers.
#[derive(Debug)]
struct Elsewhere {
    ask: Sender<Question>,
    told: Mutex<Receiver<Answer>>,
    problem: Problem,
    walls: Walls,
}

impl Elsewhere {
    fn answer(&self, question: Question) -> Result<Answer, Box<dyn Error + Send + Sync>> {
        self.ask.send(question)?;
        Ok(self.told.lock().unwrap_or_else(PoisonError::into_inner).recv()?)
    }
}

impl Objective for Elsewhere {
    fn n_parameters(&self) -> usize {
        self.problem.n_parameters
    }

    fn n_residuals(&self) -> usize {
        self.problem.n_residuals
    }

    fn walls(&self) -> Walls {
        self.walls.clone()
    }

    fn residuals(&self, _x: &DVector<f64>) -> Result<DVector<f64>, EvalError> {
        Err(EvalError::Unsolvable { reason: "it is evaluated elsewhere, through questions and answers".into() })
    }
}

impl Evaluator for Elsewhere {
    fn costs(
        &self,
        _objective: &dyn Objective,
        points: &[DVector<f64>],
        out: &mut [f64],
        _cancel: &AtomicBool,
    ) -> Result<(), Box<dyn Error + Send + Sync>> {
        match self.answer(Question::Costs(points.to_vec()))? {
            Answer::Costs(costs) => out.copy_from_slice(&costs),
            Answer::Linearizations(_) => return Err("linearizations were told for costs".into()),
        }
        Ok(())
    }

    fn linearizations(
        &self,
        _objective: &dyn Objective,
        points: &[DVector<f64>],
        _cancel: &AtomicBool,
    ) -> Result<Linearizations, Box<dyn Error + Send + Sync>> {
        match self.answer(Question::Linearizations(points.to_vec()))? {
            Answer::Linearizations(linearizations) => Ok(linearizations),
            Answer::Costs(_) => Err("costs were told for linearizations".into()),
        }
    }
}
