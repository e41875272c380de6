//! Verbs of decks of other programs.

use super::{Overwrite, values};
use clap::{Args, ValueEnum};
use retune::catalogue::Choice;
use retune_exchange::{Solver, System};
use std::path::PathBuf;

/// What gets a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ParametersOf {
    /// Every property: a factor on the stiffness of its elements, between a half and two.
    Properties,
}

/// Turn a deck of Nastran, Abaqus or CalculiX into a model file: members, masses, springs, links and sections, with the names and comments of
/// the deck.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune import wing.bdf --units in-lbf-s -o wing.yaml
  retune import wing.bdf --units mm-t-s --parameters properties -o wing.yaml
  retune import bridge.inp --units si -o bridge.yaml
  retune check wing.yaml --against wing.f06

Without --units the deck is read, and what each choice would mean is printed: a deck does not say its units. INCLUDE is followed. Design
variables of SOL 200 become parameters. Cards and keywords that the model cannot hold are refused by name
and place.")]
pub(crate) struct Import {
    /// The deck of Nastran (`.bdf`, `.dat`, `.nas`), or of Abaqus or CalculiX (`.inp`).
    pub(crate) deck: PathBuf,
    /// Where to write the model file.
    #[arg(short, long)]
    pub(crate) output: Option<PathBuf>,
    /// Where to write the frequencies that an optimisation of the deck (SOL 200) asks for, as a test file.
    #[arg(long, value_name = "FILE")]
    pub(crate) test: Option<PathBuf>,
    /// Units of the numbers of the deck: `si`, `mm-t-s`, `in-lbf-s`, `ft-lbf-s`.
    #[arg(long, value_name = "SYSTEM", value_parser = values::system)]
    pub(crate) units: Option<&'static System>,
    /// The subcase whose constraints hold; the first when absent. Of Abaqus and CalculiX the step; the first with frequencies when absent.
    #[arg(long, value_name = "N", visible_alias = "step", value_parser = values::whole::<u32>)]
    pub(crate) subcase: Option<u32>,
    /// Whose deck an `.inp` is, `abaqus` or `calculix`: masses of first-order elements are lumped in Abaqus, consistent in CalculiX.
    #[arg(long, value_name = "SOLVER", default_value = Solver::Abaqus.word(), value_parser = values::choice::<Solver>())]
    pub(crate) solver: Solver,
    /// What gets a parameter beside the design variables of the deck.
    #[arg(long, value_enum, value_name = "WHAT")]
    pub(crate) parameters: Option<ParametersOf>,
    #[command(flatten)]
    pub(crate) overwrite: Overwrite,
}
