//! Catalogues: a page of each, and a section of each member.

use super::{cell, generated_by, paragraph, table};
use crate::args::ListOf;
use crate::lists::{members, word};
use crate::output::Failure;
use retune::correlation::{BUILTIN_PROFILES, parse_profiles};
use retune::effect::{EFFECTS, Effect};
use retune::element::{ELEMENTS, Element};
use retune::fault::{FAULTS, Fault};
use retune::objective::{RESIDUALS, Residual};
use retune::optim::{ABBREVIATIONS, OPTIMIZERS, full_name};

/// Title and introduction of the page of a catalogue.
fn introduction(of: ListOf) -> (&'static str, &'static str) {
    match of {
        ListOf::Elements => (
            "Elements",
            "Beams, bars, springs, bushings and masses have blocks of their own in a [model file](model-file.md); any element can stand under \
             `elements` with its `type`. Properties are the keys of `sections` and of `properties`.",
        ),
        ListOf::Residuals => (
            "Residuals",
            "Terms of the least-squares cost. An update takes all that the test has data for; `terms` of an \
             [objective file](objective-file.md) chooses and weighs them.",
        ),
        ListOf::Optimizers => (
            "Optimisers",
            "Methods of `retune update --optimizer`, by name, with settings, or as a list of methods that run one after another. \
             The [settings](optimizer-settings.md) have a page of their own.",
        ),
        ListOf::Effects => (
            "Effects",
            "Physics that a model may lack. `retune diagnose` tries each of them at every place of the structure where it has a meaning; \
             `retune add` puts one into the model file.",
        ),
        ListOf::Faults => (
            "Faults",
            "What may be wrong with a measurement. `retune diagnose` tries each of them on every sensor, mode or pair of sensors; \
             `retune twin --fault` puts one into a synthetic test.",
        ),
        ListOf::Profiles => (
            "Criteria profiles",
            "Pass marks by which `retune compare --profile` judges a model. Copy one into a file and edit it; the \
             [keys](profile-file.md) have a page of their own.",
        ),
        ListOf::Matrices => (
            "Formats of matrices",
            "Files that superelements, `retune matrices` and the tables of dofs are read from, recognised by content.",
        ),
        ListOf::Units => (
            "Units",
            "Numbers in files carry a unit or are in SI. A unit is a product of powers: `N m2`, `kg/m`, `N*m^2`, `N m/rad`, `kg/(m s)`. \
             Angles have no dimension, except that a frequency in `rad/s` is 1/2π of one in `Hz`. Full words and plurals are read too; \
             a word that could mean several units (`lbs`) is refused with the question.",
        ),
        ListOf::ExitCodes => ("Exit codes", "What the command returns to the shell."),
        ListOf::Verbs => ("The command line", ""),
    }
}

/// The page of a catalogue: its table, then every member that has more to tell.
pub(crate) fn page(of: ListOf) -> Result<String, Failure> {
    if of == ListOf::Verbs {
        return Ok(super::verbs());
    }
    let (title, text) = introduction(of);
    let mut out = generated_by(&format!("retune list {} --markdown", word(of)));
    out += &format!("\n# {title}\n\n{text}\n\n");
    let all = members(of)?;
    out += &match of {
        ListOf::Units => table(&["unit", "in SI"], all.iter().map(|(name, si)| vec![format!("`{name}`"), cell(si)])),
        ListOf::ExitCodes => table(&["code", "meaning"], all.iter().map(|(code, text)| vec![code.clone(), cell(text)])),
        _ => {
            let has_sections = all.iter().any(|(name, _)| member(name, 2).is_ok_and(|s| s.is_some()));
            table(
                &["name", "what it is"],
                all.iter().map(|(name, summary)| {
                    let name = if has_sections { format!("[`{name}`](#{name})") } else { format!("`{name}`") };
                    vec![name, cell(summary)]
                }),
            )
        }
    };
    for (name, _) in &all {
        if let Some(section) = member(name, 2)? {
            out += &format!("\n{section}");
        }
    }
    Ok(out)
}

/// The section of a member, under a heading of a level; `None` where nothing is called so, or where there is no more to tell.
pub(crate) fn member(name: &str, level: usize) -> Result<Option<String>, Failure> {
    let name = full_name(name);
    let heading = format!("{} {name}\n\n", "#".repeat(level));
    let sources = |all: &[&str]| {
        let items: Vec<String> = all.iter().map(|s| format!("* {}\n", paragraph(s))).collect();
        format!("Sources:\n\n{}", items.concat())
    };
    if let Some(element) = ELEMENTS.iter().find(|e| Element::name(**e) == name) {
        let properties = element.properties().iter().map(|p| {
            let unit = if p.unit == "1" { "–".to_string() } else { format!("`{}`", p.unit) };
            vec![format!("`{}`", p.name), unit, cell(p.description)]
        });
        let properties = table(&["property", "unit", "what it is"], properties);
        let text = format!("{}\n\n{}\n\n{properties}", paragraph(element.summary()), element.theory().trim_end());
        return Ok(Some(heading + &text));
    }
    if let Some(o) = OPTIMIZERS.iter().find(|o| o.name == name) {
        let short = ABBREVIATIONS.iter().find(|(_, full)| *full == name);
        let short = short.map_or(String::new(), |(short, _)| format!(" Abbreviated `{short}`."));
        let text = format!("{}.{short}\n\n{}\n\n{}", upper(o.summary), paragraph(o.theory), sources(o.sources));
        return Ok(Some(heading + &text));
    }
    if let Some(e) = EFFECTS.iter().find(|e| Effect::name(**e) == name) {
        let about = e.about();
        let confusable: Vec<String> = about.confusable.iter().map(|c| format!("`{c}`")).collect();
        let text = format!(
            "{}\n\n*Trace.* {}\n\n*Equation.* {}\n\n*Confused with* {}.\n\n{}",
            paragraph(about.summary),
            paragraph(about.signature),
            paragraph(about.formulation),
            confusable.join(", "),
            sources(about.references)
        );
        return Ok(Some(heading + &text));
    }
    if let Some(f) = FAULTS.iter().find(|f| Fault::name(**f) == name) {
        let about = f.about();
        let text = format!("{}\n\n*Trace.* {}\n", paragraph(about.summary), paragraph(about.signature));
        return Ok(Some(heading + &text));
    }
    if let Some(r) = RESIDUALS.iter().find(|r| Residual::name(**r) == name) {
        return Ok((level == 1).then(|| heading + &paragraph(r.summary()) + "\n"));
    }
    let profiles = parse_profiles(BUILTIN_PROFILES)?;
    let profile = profiles.iter().find(|p| p.name == name);
    Ok(profile.map(|p| heading + &format!("```yaml\n{}```\n", retune::yaml::write(&[p]))))
}

/// A sentence that begins with a capital letter.
fn upper(text: &str) -> String {
    let mut letters = paragraph(text).chars().collect::<Vec<_>>();
    if let Some(first) = letters.first_mut() {
        *first = first.to_ascii_uppercase();
    }
    letters.into_iter().collect()
}
