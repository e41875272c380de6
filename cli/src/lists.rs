//! The lists of the command: what `retune list` shows and the reference is made of.

use crate::EXIT_CODES;
use crate::args::{Cli, ListOf};
use crate::output::Failure;
use clap::{CommandFactory, ValueEnum};
use retune::correlation::{BUILTIN_PROFILES, parse_profiles};
use retune::effect::{EFFECTS, Effect};
use retune::element::{ELEMENTS, Element};
use retune::fault::{FAULTS, Fault};
use retune::matrices::{MATRIX_READERS, MatrixReader};
use retune::objective::{RESIDUALS, Residual};
use retune::optim::OPTIMIZERS;
use retune::units::units;

/// The word of a list at the command line.
pub(crate) fn word(of: ListOf) -> String {
    of.to_possible_value().map_or(String::new(), |v| v.get_name().to_string())
}

/// The lists, each with what it holds.
pub(crate) fn lists() -> Vec<(String, String)> {
    let about = |of: &ListOf| of.to_possible_value().and_then(|v| v.get_help().map(ToString::to_string));
    ListOf::value_variants().iter().map(|of| (word(*of), about(of).unwrap_or_default())).collect()
}

/// Names and summaries of a list.
pub(crate) fn members(of: ListOf) -> Result<Vec<(String, String)>, Failure> {
    let owned = |(name, summary): (&str, &str)| (name.to_string(), summary.to_string());
    Ok(match of {
        ListOf::Elements => ELEMENTS.iter().map(|e| (Element::name(*e), e.summary())).map(owned).collect(),
        ListOf::Residuals => RESIDUALS.iter().map(|r| (Residual::name(*r), r.summary())).map(owned).collect(),
        ListOf::Effects => EFFECTS.iter().map(|e| (Effect::name(*e), e.about().summary)).map(owned).collect(),
        ListOf::Faults => FAULTS.iter().map(|f| (Fault::name(*f), f.about().summary)).map(owned).collect(),
        ListOf::Profiles => parse_profiles(BUILTIN_PROFILES)?.into_iter().map(|p| (p.name, p.source)).collect(),
        ListOf::Matrices => MATRIX_READERS.iter().map(|r| (MatrixReader::name(*r), r.summary())).map(owned).collect(),
        ListOf::Optimizers => OPTIMIZERS.iter().map(|o| (o.name, o.summary)).map(owned).collect(),
        ListOf::Units => units()
            .map(|(name, factor, dimension)| (name.to_string(), format!("{} {dimension}", exact(factor))))
            .collect(),
        ListOf::ExitCodes => EXIT_CODES.iter().map(|(code, text)| (code.to_string(), (*text).to_string())).collect(),
        ListOf::Verbs => Cli::command()
            .get_subcommands()
            .map(|v| (v.get_name().to_string(), v.get_about().map(ToString::to_string).unwrap_or_default()))
            .collect(),
    })
}

/// A factor as short as it is exact, with a power of ten where that is shorter.
fn exact(factor: f64) -> String {
    if (1e-3..1e7).contains(&factor) { format!("{factor}") } else { format!("{factor:e}") }
}
