//! Verbs and their options, as the command line itself declares them.

use super::{cell, generated_by, table};
use crate::args::Cli;
use clap::{Arg, Command, CommandFactory};

/// The page of all verbs.
pub(crate) fn verbs() -> String {
    let mut command = Cli::command();
    command.build();
    let mut out = generated_by("retune list verbs --markdown");
    out += "\n# The command line\n\n`retune VERB --help` says the same on the terminal. What the command promises about files, streams and \
            signals has a [page of its own](../command-line.md); its [exit codes](exit-codes.md) too.\n\n";
    let verbs: Vec<&Command> = command.get_subcommands().filter(|c| c.get_name() != "help").collect();
    out += &table(
        &["verb", "what it does"],
        verbs.iter().map(|verb| {
            let name = verb.get_name();
            vec![format!("[`{name}`](#{name})"), cell(&about(verb))]
        }),
    );
    for verb in verbs {
        out += &section(verb);
    }
    out
}

fn about(command: &Command) -> String {
    command.get_about().map(ToString::to_string).unwrap_or_default()
}

fn section(verb: &Command) -> String {
    let name = verb.get_name();
    let long = verb.get_long_about().map_or_else(|| about(verb), ToString::to_string);
    let positions: Vec<String> = verb.get_positionals().map(usage).collect();
    let mut out =
        format!("\n## {name}\n\n{}\n\n```text\nretune {name} {}", super::paragraph(&long), positions.join(" "));
    let is_shown = |a: &&Arg| !a.is_hide_set() && !matches!(a.get_id().as_str(), "help" | "version");
    let required: Vec<&Arg> = verb.get_opts().filter(|a| a.is_required_set()).collect();
    for option in required {
        out += &format!(" {}", spelling(option).trim_matches('`').replace("`, `", "|"));
    }
    out += " [OPTIONS]\n```\n\n";
    out += &table(
        &["argument", "what it is"],
        verb.get_arguments().filter(is_shown).map(|a| {
            let name = if a.is_positional() { format!("`{}`", usage(a)) } else { spelling(a) };
            vec![name, cell(&help(a))]
        }),
    );
    if let Some(after) = verb.get_after_help() {
        out += &format!("\n```text\n{}\n```\n", after.to_string().trim());
    }
    out
}

/// A positional argument, as usage shows it.
fn usage(a: &Arg) -> String {
    let name = value_names(a).unwrap_or_else(|| a.get_id().as_str().to_uppercase());
    let several = a.get_num_args().is_some_and(|n| n.max_values() > 1);
    let dots = if several { "..." } else { "" };
    if a.is_required_set() { format!("{name}{dots}") } else { format!("[{name}{dots}]") }
}

fn value_names(a: &Arg) -> Option<String> {
    a.get_value_names().map(|names| names.iter().map(ToString::to_string).collect::<Vec<_>>().join(" "))
}

fn spelling(a: &Arg) -> String {
    let value = if a.get_action().takes_values() {
        value_names(a).map_or(String::new(), |v| format!(" {v}"))
    } else {
        String::new()
    };
    let short = a.get_short().map(|s| format!("`-{s}`, ")).unwrap_or_default();
    format!("{short}`--{}{value}`", a.get_long().unwrap_or_default())
}

fn help(a: &Arg) -> String {
    let mut text = a.get_long_help().or_else(|| a.get_help()).map(ToString::to_string).unwrap_or_default();
    if !text.ends_with(['.', '?', '!']) && !text.is_empty() {
        text.push('.');
    }
    let values: Vec<String> = if a.get_action().takes_values() {
        a.get_possible_values().iter().filter(|v| !v.is_hide_set()).map(|v| format!("`{}`", v.get_name())).collect()
    } else {
        Vec::new()
    };
    if !values.is_empty() {
        text += &format!(" One of {}.", values.join(", "));
    }
    let defaults: Vec<String> = a.get_default_values().iter().map(|v| v.to_string_lossy().into_owned()).collect();
    if !defaults.is_empty() && a.get_action().takes_values() {
        text += &format!(" Default `{}`.", defaults.join(" "));
    }
    text
}
