//! `retune explain`

use crate::args::{Explain, ListOf};
use crate::lists::members;
use crate::output::{Failure, print, reference_style};
use crate::{DONE, markdown};
use retune::catalogue::did_you_mean;
use retune::correlation::{BUILTIN_PROFILES, parse_profiles};
use retune::effect::{EFFECTS, Effect};
use retune::element::{ELEMENTS, Element};
use retune::fault::{FAULTS, Fault};
use retune::objective::{RESIDUALS, Residual};
use retune::optim::{ABBREVIATIONS, OPTIMIZERS, full_name};
use retune_report::text::{Align, Style, Table};

/// Members that are named, in a hint.
const RELATED: usize = 6;

/// What there is about a word that is not a name: the verb of that name, or members whose names or summaries have it.
fn related(word: &str) -> Result<Option<String>, Failure> {
    if members(ListOf::Verbs)?.iter().any(|(verb, _)| verb == word) {
        return Ok(Some(format!("`{word}` is a verb: `retune {word} --help` tells about it")));
    }
    let lower = word.to_lowercase();
    let stem = lower.strip_suffix("es").or_else(|| lower.strip_suffix('s')).unwrap_or(&lower);
    if stem.len() < 3 {
        return Ok(None);
    }
    let mut found = Vec::new();
    for of in [ListOf::Elements, ListOf::Effects, ListOf::Faults, ListOf::Residuals, ListOf::Optimizers] {
        let has = |(name, summary): &(String, String)| name.contains(stem) || summary.to_lowercase().contains(stem);
        found.extend(members(of)?.into_iter().filter(has).map(|(name, _)| format!("`{name}`")));
    }
    found.truncate(RELATED);
    Ok((!found.is_empty()).then(|| format!("about it are {}", found.join(", "))))
}

pub(crate) fn run(args: &Explain) -> Result<u8, Failure> {
    let name = full_name(&args.name);
    let profiles = parse_profiles(BUILTIN_PROFILES)?;
    if args.markdown
        && let Some(section) = markdown::member(name, 1)?
    {
        args.to.hand_over(&section)?;
        return Ok(DONE);
    }
    let style = if args.to.output.is_some() { Style { width: 10_000, ..Style::default() } } else { reference_style() };
    let mut out = String::new();
    let mut print = |text: &str| out.push_str(text);
    if let Some(element) = ELEMENTS.iter().find(|e| Element::name(**e) == name) {
        let mut table = Table::new([("property", Align::Left), ("unit", Align::Left), ("what it is", Align::Left)]);
        for p in element.properties() {
            table.row([p.name.into(), p.unit.into(), p.description.into()]);
        }
        let text = table.render(&style);
        print(&format!("{name}: {}\n\n{}\n\n{text}", element.summary(), element.theory().trim_end()));
    } else if let Some(o) = OPTIMIZERS.iter().find(|o| o.name == name) {
        print(&format!("{name}: {}\n\n{}\n\nSources\n", o.summary, o.theory));
        o.sources.iter().for_each(|s| print(&format!("  {s}\n")));
    } else if let Some(e) = EFFECTS.iter().find(|e| Effect::name(**e) == name) {
        let about = e.about();
        print(&format!(
            "{name}: {}\n\nTrace: {}\n\nEquation: {}\n\n",
            about.summary, about.signature, about.formulation
        ));
        print(&format!("Confused with: {}\n\nSources\n", about.confusable.join(", ")));
        about.references.iter().for_each(|s| print(&format!("  {s}\n")));
    } else if let Some(f) = FAULTS.iter().find(|f| Fault::name(**f) == name) {
        let about = f.about();
        print(&format!("{name}: {}\n\nTrace: {}\n", about.summary, about.signature));
    } else if let Some(profile) = profiles.iter().find(|p| p.name == name) {
        let text = retune::yaml::write(&[profile]);
        print(&format!(
            "# A criteria profile: copy it into a file, edit it, give the file to `retune compare --profile`.\n{text}"
        ));
    } else if let Some(r) = RESIDUALS.iter().find(|r| Residual::name(**r) == name) {
        print(&format!("{name}: {}\n", r.summary()));
    } else {
        let words = ELEMENTS
            .iter()
            .map(|e| Element::name(*e))
            .chain(EFFECTS.iter().map(|e| Effect::name(*e)))
            .chain(FAULTS.iter().map(|f| Fault::name(*f)))
            .chain(OPTIMIZERS.iter().map(|o| o.name))
            .chain(ABBREVIATIONS.iter().map(|(short, _)| *short))
            .chain(profiles.iter().map(|p| p.name.as_str()))
            .chain(RESIDUALS.iter().map(|r| Residual::name(*r)));
        return Err(Failure::text(format!(
            "nothing is called `{name}`{} (see `retune list`)",
            did_you_mean(name, words)
        ))
        .with_hint_of(related(name)?));
    }
    match &args.to.output {
        Some(_) => args.to.hand_over(&out)?,
        None => self::print(&out),
    }
    Ok(DONE)
}
