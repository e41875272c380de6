//! `retune compare`

use super::measured;
use crate::args::Compare;
use crate::output::{Failure, mac_matrix, pairs, print, style, warn};
use crate::{DONE, SHORT, files};
use retune::correlation::CriteriaProfile;
use retune::data::corrected_functions;
use retune::update::{
    Agreement, AgreementOptions, Assessment, HowToPair, UpdateError, agreement, coarse_mesh_text, load_profile,
};
use retune_report::answer;
use retune_report::text::{Style, agreement as words, printable};
use serde_json::{Value, json};
use std::path::Path;

pub(crate) fn run(args: &Compare) -> Result<u8, Failure> {
    args.answer.check()?;
    let how = args.pairing.how();
    if args.bands.windows(2).any(|w| w[0] >= w[1]) {
        return Err(Failure::text(format!("--bands {:?}: give ascending frequencies in Hz", args.bands)));
    }
    let profile = args.profile.as_deref().map(profile).transpose()?;
    let all =
        args.tests.paths.iter().map(|path| one(args, path, &how, profile.as_ref())).collect::<Result<Vec<_>, _>>()?;
    if args.answer.needs_json() {
        let mut values: Vec<&Value> = all.iter().map(|s| &s.json).collect();
        match values.as_slice() {
            [value] => args.answer.give(value),
            _ => args.answer.give(&json!({ "tests": std::mem::take(&mut values) })),
        }
    }
    if !args.answer.json {
        print(&all.iter().map(|s| s.text.as_str()).collect::<Vec<_>>().join("\n"));
    }
    Ok(if all.iter().all(|s| s.passed) { DONE } else { SHORT })
}

/// The comparison with one test, as it is asked for: JSON or text.
struct Shown {
    json: Value,
    text: String,
    passed: bool,
}

fn one(args: &Compare, path: &Path, how: &HowToPair, profile: Option<&CriteriaProfile>) -> Result<Shown, Failure> {
    let (mut test, mut test_warnings, test_text) = files::test(path)?;
    let (model, model_warnings, model_text) =
        files::tested_model(&args.model.path, args.model.configuration(), (&mut test, path, &test_text))?;
    test_warnings.extend(files::check_sensors(&model, &test, path, &test_text)?);
    let model = files::loaded(model, &test, args.loading.sensor_masses)?;
    warn(&args.model.path, &model_text, &model_warnings);
    warn(path, &test_text, &test_warnings);
    if test.has_nothing() {
        return Err(Failure::text(format!("{}: {}", path.display(), UpdateError::NoData)));
    }
    let own;
    let functions = if args.frf.is_empty() {
        None
    } else {
        let found = measured::read(&args.frf, &args.measurement)?;
        own = corrected_functions(measured::functions(&found)?.clone(), &test.sensors, &test.corrections);
        Some(&own)
    };
    let options = AgreementOptions {
        pairing: *how,
        reduction: args.reduction,
        places: args.localize || args.all,
        parameters: args.sensitivity || args.all,
        suspects: args.all,
        functions,
        band_edges_hz: &args.bands,
        profile,
    };
    let parts = agreement(&model, &test, &options)?;
    let passed = parts.judgement.as_ref().is_none_or(|j| j.passed);
    let json = if args.answer.needs_json() { answer::comparison(&parts, profile) } else { Value::Null };
    if args.answer.json {
        return Ok(Shown { json, text: String::new(), passed });
    }
    let (test, a) = (&parts.test, &parts.assessment);
    let style = style(&std::io::stdout());
    let mut out = format!("model  {}\ntest   {}\n", printable(&model.spec().name), printable(&test.name));
    out += &format!("data   {}\n\n", answer::data_origins(test).join("; "));
    out += &pairs(a, Some(&parts.modes), &style);
    out += &mac_matrix(a, test, &style);
    for text in summary(a).lines() {
        words::wrapped(&mut out, text, &style);
    }
    write_parts(&parts, &mut out, args, &style);
    if !parts.suspects.is_empty() {
        out += "\nsensors against the motions of the model\n";
        out += &measured::findings_text(&parts.suspects, &style);
    }
    if let Some((profile, judgement)) = profile.zip(parts.judgement.as_ref()) {
        words::judgement(&mut out, judgement, profile, &style);
    }
    Ok(Shown { json, text: out, passed })
}

/// A profile by its name, by its file, or by both: `file.yaml:NAME`.
fn profile(path: &Path) -> Result<CriteriaProfile, Failure> {
    let is_file = |path: &str| {
        let yaml = Path::new(path)
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("yaml") || e.eq_ignore_ascii_case("yml"));
        yaml || path.contains(std::path::MAIN_SEPARATOR)
    };
    let (file, name) = match path.to_str().map(|word| (word, word.rsplit_once(':'))) {
        Some((_, Some((file, name)))) if is_file(file) => (Some(Path::new(file)), Some(name)),
        Some((word, _)) if !is_file(word) => (None, Some(word)),
        _ => (Some(path), None),
    };
    let text = file.map(files::read).transpose()?;
    load_profile(text.as_deref(), name).map_err(|e| match file {
        Some(file) => Failure::text(format!("{}: {e}", file.display())),
        None => Failure::from(e),
    })
}

/// The long answers; where there is none, why.
fn write_parts(parts: &Agreement, out: &mut String, args: &Compare, style: &Style) {
    out.push('\n');
    let mut failed: Vec<(&str, &String)> = Vec::new();
    let frequencies_hz: Vec<f64> = parts.test.modes.iter().map(|m| m.frequency_hz.value).collect();
    words::mixed_lines(out, &parts.mixed, &frequencies_hz, style);
    match &parts.sensors {
        Ok(s) => words::sensors_line(out, s, style),
        Err(why) => failed.push(("sensors", why)),
    }
    match &parts.orthogonality {
        Ok(o) => words::orthogonality_line(out, o, style),
        Err(why) => failed.push(("mass", why)),
    }
    match &parts.places {
        Ok(p) => words::places_line(out, p, style),
        Err(why) => failed.push(("places", why)),
    }
    match &parts.parameters {
        Ok(s) => words::parameters_line(out, s, style),
        Err(why) => failed.push(("parameters", why)),
    }
    if let Some(f) = &parts.functions {
        words::functions_line(out, f, style);
    }
    if let Some(text) = coarse_mesh_text(&parts.coarse_mesh, parts.assessment.pairs.len()) {
        words::line(out, "mesh", &text, style);
    }
    for (word, why) in failed {
        words::line(out, word, why, style);
    }
    let asked = |flag: bool| flag || args.all;
    if let (true, Ok(s)) = (asked(args.sensors), &parts.sensors) {
        words::sensors_table(out, s, style);
    }
    if let (true, Ok(o)) = (asked(args.orthogonality), &parts.orthogonality) {
        words::orthogonality_tables(out, o, style);
    }
    if let (true, Ok(p)) = (asked(args.localize), &parts.places) {
        words::places_tables(out, p, style);
    }
    if let Some(f) = &parts.functions {
        words::functions_tables(out, f, args.all, style);
    }
    if let (true, Ok(s)) = (asked(args.sensitivity), &parts.parameters) {
        words::parameters_table(out, s, style);
    }
    let asks = args.sensors || args.orthogonality || args.localize || args.sensitivity || args.all;
    if !asks && args.profile.is_none() {
        let more = "more: --sensors --orthogonality --localize --sensitivity, or --all; --profile judges";
        out.push('\n');
        words::wrapped(out, more, style);
    }
}
/// The last lines of a comparison.
pub(crate) fn summary(a: &Assessment) -> String {
    let mut out = format!("\nerror is (model - test)/test: plus means that the model is too high\n{}\n", a.misfit);
    if !(a.pairs.is_empty() && a.unpaired_test.is_empty()) {
        out += &format!("cost of MAC and frequencies (Gupta et al. 2015, equation (4) / 2n): {:.4}\n", a.paper_cost);
    }
    out
}
