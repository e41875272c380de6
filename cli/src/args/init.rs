//! Beginning a model, and what there is: schemas, catalogues, completions, manual pages.

use super::{Overwrite, values};
use crate::output::{Failure, print};
use crate::writing;
use clap::{Args, ValueEnum};
use retune_exchange::System;
use std::path::PathBuf;

/// What the structure is like.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum InitOf {
    /// A cantilever with a mass at its tip.
    Beam,
    /// A portal frame on footings that give.
    Frame,
    /// A small aircraft, free in the air.
    Aircraft,
}

/// Begin a project: a model, a test and an objective file, commented and ready to run, and schemas for editors.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune init beam
  retune init aircraft -o glider
  retune init --deck wing.bdf --units in-lbf-s -o wing

Writes model.yaml, test.yaml, objective.yaml and schemas/, and prints what to run next. Nothing is ever overwritten. The tests are synthetic
and say so.")]
pub(crate) struct Init {
    /// What the structure is like; of a deck everything is read from the deck.
    #[arg(value_enum, required_unless_present = "deck", conflicts_with = "deck", value_name = "STRUCTURE")]
    pub(crate) structure: Option<InitOf>,
    /// A deck of Nastran, Abaqus or CalculiX to begin with, as `retune import` reads it; every property gets a parameter.
    #[arg(long, value_name = "FILE")]
    pub(crate) deck: Option<PathBuf>,
    /// Units of the numbers of the deck: `si`, `mm-t-s`, `in-lbf-s`, `ft-lbf-s`; without it the choices are printed.
    #[arg(long, value_name = "SYSTEM", value_parser = values::system, requires = "deck")]
    pub(crate) units: Option<&'static System>,
    /// The folder to write to; it is made where it is not there.
    #[arg(short, long, value_name = "FOLDER", default_value = ".")]
    pub(crate) output: PathBuf,
}

/// Which kind of file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum SchemaOf {
    /// Model files.
    Model,
    /// Test files.
    Test,
    /// Objective files of `update` and `sample`.
    Objective,
    /// Files of criteria profiles of `compare`.
    Profiles,
    /// Optimisers and their settings, as `--optimizer` takes them.
    Optimizer,
    /// Partial model files of `twin --patch`.
    Patch,
}

/// Print the JSON Schema of a file format, for editors that complete and check YAML.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  retune schema model -o model.schema.json\n  retune schema test --markdown")]
pub(crate) struct Schema {
    /// Which file format.
    #[arg(value_enum, default_value_t = SchemaOf::Model)]
    pub(crate) of: SchemaOf,
    /// Write the keys as a page in Markdown.
    #[arg(long)]
    pub(crate) markdown: bool,
    #[command(flatten)]
    pub(crate) to: To,
}

/// Where a text goes.
#[derive(Debug, Args)]
pub(crate) struct To {
    /// Where to write it; standard output when absent.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Overwrite an existing output file.
    #[arg(long, requires = "output")]
    pub(crate) force: bool,
}

impl To {
    /// Writes a text where it is asked for: to the file, or to standard output.
    pub(crate) fn hand_over(&self, text: &str) -> Result<(), Failure> {
        let Some(path) = &self.output else {
            print(text);
            return Ok(());
        };
        writing::check_room(path, self.force, text.len())?;
        let _ = writing::write(path, text);
        Ok(())
    }
}

/// Which list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ListOf {
    /// Element types.
    Elements,
    /// Terms of the least-squares cost.
    Residuals,
    /// Optimisers.
    Optimizers,
    /// Physical effects that a diagnosis tries.
    Effects,
    /// Faults of a measurement that a diagnosis tries.
    Faults,
    /// Criteria profiles of `retune compare --profile`.
    Profiles,
    /// Formats of matrices of other solvers.
    Matrices,
    /// Units that numbers in files may carry.
    Units,
    /// Exit codes of the command.
    ExitCodes,
    /// Verbs of the command.
    Verbs,
}

/// List what there is: elements, residuals, optimisers, effects, faults, profiles, matrix formats, units, exit codes, verbs.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  retune list elements\n  retune list effects --markdown -o effects.md")]
pub(crate) struct List {
    /// Which list; the lists themselves when absent.
    #[arg(value_enum)]
    pub(crate) of: Option<ListOf>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
    /// Write a page in Markdown: the list, and all that `retune explain` tells of its members.
    #[arg(long, conflicts_with = "json", requires = "of")]
    pub(crate) markdown: bool,
    #[command(flatten)]
    pub(crate) to: To,
}

/// Explain a member of a list: equations, properties, sources.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  retune explain beam\n  retune explain lm --markdown")]
pub(crate) struct Explain {
    /// A name from `retune list`.
    pub(crate) name: String,
    /// Write it in Markdown.
    #[arg(long)]
    pub(crate) markdown: bool,
    #[command(flatten)]
    pub(crate) to: To,
}

/// Write completions for a shell.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  retune completions bash -o ~/.local/share/bash-completion/completions/retune")]
pub(crate) struct Completions {
    /// The shell.
    #[arg(value_enum)]
    pub(crate) shell: clap_complete::Shell,
    #[command(flatten)]
    pub(crate) to: To,
}

/// Write manual pages for `man`: retune.1, and one for each verb.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  retune manual -o ~/.local/share/man/man1")]
pub(crate) struct Manual {
    /// The folder to write to; it is made where it is not there.
    #[arg(short, long, value_name = "FOLDER")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) overwrite: Overwrite,
}
