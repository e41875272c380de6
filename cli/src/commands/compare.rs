//! `retune compare`

use super::measured;
use crate::args::Compare;
use crate::output::{Failure, mac_matrix, mac_matrix_json, pairs, print, print_json, style, warn};
use crate::{DONE, SHORT, files};
use retune::correlation::{CriteriaProfile, Identifiability, Judgement, SensorRemoval};
use retune::data::{Origin, TestData, corrected_functions};
use retune::model::{Model, ParametricModel};
use retune::objective::Comparison;
use retune::report::text::{Style, agreement};
use retune::update::{
    AssessedPair, AssessedReading, Assessment, Functions, FunctionsOptions, HowToPair, MassReduction, ModeAgreement,
    Orthogonality, Places, PlacesOptions, Sensitivities, SensitivityOptions, SensorReport, UnpairedMode, UpdateError,
    assess, compare_functions, compared, judge, load_profile, mode_agreement, orthogonality, paired_test, places,
    sensitivities, sensor_agreement,
};
use serde_json::{Value, json};
use std::path::Path;

/// Sensors that MACCO takes away.
const REMOVED: usize = 5;
/// Above this number of dofs the places and the parameters take seconds and wait to be asked for.
pub(super) const LARGE: usize = 600;

pub(crate) fn run(args: &Compare) -> Result<u8, Failure> {
    let how = args.pairing.how();
    if args.bands.windows(2).any(|w| w[0] >= w[1]) {
        return Err(Failure::text(format!("--bands {:?}: give ascending frequencies in Hz", args.bands)));
    }
    let profile = args.profile.as_deref().map(profile).transpose()?;
    let all = args.tests.iter().map(|path| one(args, path, &how, profile.as_ref())).collect::<Result<Vec<_>, _>>()?;
    if args.json {
        let mut values: Vec<&Value> = all.iter().map(|s| &s.json).collect();
        match values.as_slice() {
            [value] => print_json(value),
            _ => print_json(&json!({ "tests": std::mem::take(&mut values) })),
        }
    } else {
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
        files::tested_model(&args.model, args.configuration.as_deref(), (&mut test, path, &test_text))?;
    test_warnings.extend(files::check_sensors(&model, &test, path, &test_text)?);
    let model = files::loaded(model, &test, args.loading.sensor_masses)?;
    warn(&args.model, &model_text, &model_warnings);
    warn(path, &test_text, &test_warnings);
    if test.has_nothing() {
        return Err(Failure::text(format!("{}: {}", path.display(), UpdateError::NoData)));
    }
    let test = paired_test(&model, None, &test, how)?;
    let comparison = compared(&model, &test, how)?;
    let a = assess(&comparison, &model.parameters().nominal())?;
    let parts = Parts::of(args, &model, &comparison, &a)?;
    let is_asked = args.all || model.dof_map().n_dof() <= LARGE;
    let theta = model.parameters().nominal();
    let suspects = if is_asked { measured::suspects(&model, &theta, &test)? } else { Vec::new() };
    let judgement = profile.map(|p| judge(&comparison, &a, parts.orthogonality.as_ref().ok(), p));
    let passed = judgement.as_ref().is_none_or(|j| j.passed);
    if args.json {
        let mut json = as_json(&test, &a, &parts, profile.zip(judgement.as_ref()));
        json["suspect_sensors"] = measured::findings_json(&suspects);
        return Ok(Shown { json, text: String::new(), passed });
    }
    let style = style(&std::io::stdout());
    let mut out = format!("model  {}\ntest   {}\n", model.spec().name, test.name);
    out += &format!("data   {}\n\n", origins(&test).join("; "));
    out += &pairs(&a, Some(&parts.modes), &style);
    out += &mac_matrix(&a, &test, &style);
    for text in summary(&a).lines() {
        agreement::wrapped(&mut out, text, &style);
    }
    parts.write(&mut out, args, &style);
    if !suspects.is_empty() {
        out += "\nsensors against the motions of the model\n";
        out += &measured::findings_text(&suspects, &style);
    }
    if let Some((profile, judgement)) = profile.zip(judgement.as_ref()) {
        agreement::judgement(&mut out, judgement, profile, &style);
    }
    Ok(Shown { json: Value::Null, text: out, passed })
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
struct Parts {
    modes: Vec<ModeAgreement>,
    sensors: Result<SensorReport, String>,
    orthogonality: Result<Orthogonality, String>,
    places: Result<Places, String>,
    parameters: Result<Sensitivities, String>,
    functions: Option<Functions>,
}

impl Parts {
    fn of(args: &Compare, model: &Model, comparison: &Comparison<'_>, a: &Assessment) -> Result<Self, Failure> {
        const NO_SHAPES: &str = "no measured shape is paired with a mode of the model";
        let reduction = MassReduction::from(args.reduction);
        let orthogonality = match orthogonality(comparison, a, reduction) {
            // A reduction that was asked for and does not exist is a wrong question.
            Err(e) if reduction != MassReduction::Auto => return Err(e.into()),
            Err(e) => Err(e.to_string()),
            Ok(found) => found.ok_or_else(|| NO_SHAPES.to_string()),
        };
        let test = comparison.test();
        let n_dof = model.dof_map().n_dof();
        let waits = |asked: bool, flag: &str| {
            let is_large = n_dof > LARGE && !asked && !args.all;
            is_large.then(|| format!("{n_dof} dofs take a while: ask with {flag}"))
        };
        let places = match waits(args.localize, "--localize") {
            Some(why) => Err(why),
            None => places(model, comparison, a, PlacesOptions::default()).map_err(|e| e.to_string()),
        };
        let options = SensitivityOptions { n_modes: test.modes.len().max(1) };
        let parameters = match waits(args.sensitivity, "--sensitivity") {
            Some(why) => Err(why),
            None => sensitivities(model, test, options).map_err(|e| e.to_string()),
        };
        let functions = functions(args, comparison, a)?;
        Ok(Self {
            modes: mode_agreement(comparison, a)?,
            sensors: sensor_agreement(comparison, a, REMOVED)?.ok_or_else(|| NO_SHAPES.to_string()),
            orthogonality,
            places,
            parameters,
            functions,
        })
    }

    fn write(&self, out: &mut String, args: &Compare, style: &Style) {
        out.push('\n');
        let mut failed: Vec<(&str, &String)> = Vec::new();
        match &self.sensors {
            Ok(s) => agreement::sensors_line(out, s, style),
            Err(why) => failed.push(("sensors", why)),
        }
        match &self.orthogonality {
            Ok(o) => agreement::orthogonality_line(out, o, style),
            Err(why) => failed.push(("mass", why)),
        }
        match &self.places {
            Ok(p) => agreement::places_line(out, p, style),
            Err(why) => failed.push(("places", why)),
        }
        match &self.parameters {
            Ok(s) => agreement::parameters_line(out, s, style),
            Err(why) => failed.push(("parameters", why)),
        }
        if let Some(f) = &self.functions {
            agreement::functions_line(out, f, style);
        }
        for (word, why) in failed {
            agreement::line(out, word, why, style);
        }
        let asked = |flag: bool| flag || args.all;
        if let (true, Ok(s)) = (asked(args.sensors), &self.sensors) {
            agreement::sensors_table(out, s, style);
        }
        if let (true, Ok(o)) = (asked(args.orthogonality), &self.orthogonality) {
            agreement::orthogonality_tables(out, o, style);
        }
        if let (true, Ok(p)) = (asked(args.localize), &self.places) {
            agreement::places_tables(out, p, style);
        }
        if let Some(f) = &self.functions {
            agreement::functions_tables(out, f, args.all, style);
        }
        if let (true, Ok(s)) = (asked(args.sensitivity), &self.parameters) {
            agreement::parameters_table(out, s, style);
        }
        let asks = args.sensors || args.orthogonality || args.localize || args.sensitivity || args.all;
        if !asks && args.profile.is_none() {
            let more = "more: --sensors --orthogonality --localize --sensitivity, or --all; --profile judges";
            out.push('\n');
            agreement::wrapped(out, more, style);
        }
    }
}

/// The measured functions, those that the test file names or those of `--frf`, beside the model's.
fn functions(args: &Compare, comparison: &Comparison<'_>, a: &Assessment) -> Result<Option<Functions>, Failure> {
    let test = comparison.test();
    let corrected;
    let (set, mut options) = if !args.frf.is_empty() {
        let found = measured::read(&args.frf, &args.measurement)?;
        corrected = corrected_functions(measured::functions(&found)?.clone(), &test.sensors, &test.corrections);
        (&corrected, FunctionsOptions::default())
    } else if let (Some(set), Some(fit)) = (&test.frfs, &test.frf_fit) {
        (set, FunctionsOptions::of_fit(fit))
    } else if args.bands.is_empty() {
        return Ok(None);
    } else {
        return Err(Failure::text("--bands: there are no functions; give their files by `--frf`, or in the test"));
    };
    if !args.bands.is_empty() {
        options.bands_hz = args.bands.windows(2).map(|e| [e[0], e[1]]).collect();
    }
    Ok(Some(compare_functions(comparison, a, set, &options)?))
}

/// The last lines of a comparison.
pub(crate) fn summary(a: &Assessment) -> String {
    let mut out = format!("\nerror is (model - test)/test: plus means that the model is too high\n{}\n", a.misfit);
    if !(a.pairs.is_empty() && a.unpaired_test.is_empty()) {
        out += &format!("cost of MAC and frequencies (Gupta et al. 2015, equation (4) / 2n): {:.4}\n", a.paper_cost);
    }
    out
}

fn as_json(test: &TestData, a: &Assessment, parts: &Parts, judged: Option<(&CriteriaProfile, &Judgement)>) -> Value {
    let modes: Vec<Value> = parts
        .modes
        .iter()
        .map(|m| {
            json!({"test_mode": m.test_mode + 1, "frequency_residual": m.frequency_residual, "shape": m.shape, "misfit": m.misfit})
        })
        .collect();
    let swapped: Vec<Value> =
        a.swapped.iter().map(|&(p, q)| json!([a.pairs[p].test_mode + 1, a.pairs[q].test_mode + 1])).collect();
    json!({
        "pairs": a.pairs.iter().map(pair_json).collect::<Vec<_>>(),
        "unpaired_test": a.unpaired_test.iter().map(unpaired_json).collect::<Vec<_>>(),
        "mac": mac_matrix_json(a, test),
        "unpaired_model": a.unpaired_model.iter().map(unpaired_json).collect::<Vec<_>>(),
        "static_readings": readings_json(a),
        "functions_of_fit": functions_json(a),
        "swapped": swapped,
        "cost": a.cost,
        "paper_cost": a.paper_cost,
        "chi_squared": a.misfit.chi_squared,
        "n_data": a.misfit.n_data,
        "p_value": a.misfit.p_value,
        "misfit": a.misfit.to_string(),
        "origins": origins(test),
        "modes": modes,
        "sensors": or_why(&parts.sensors, sensors_json),
        "orthogonality": or_why(&parts.orthogonality, |o| json!({
            "reduction": o.reduction,
            "test_modes": o.test_modes.iter().map(|m| m + 1).collect::<Vec<_>>(),
            "left_out": o.left_out,
            "cross": o.cross,
            "auto": o.auto,
            "own_error": o.own_error,
        })),
        "localization": or_why(&parts.places, |p| json!({
            "by_element": p.by_element,
            "by_group": p.by_group,
            "changes_by_element": p.changes_by_element,
            "changes_by_group": p.changes_by_group,
            "strain_energy": p.strain_energy.iter().map(|(name, shares)| json!({"group": name, "shares": shares})).collect::<Vec<_>>(),
            "test_modes": p.test_modes.iter().map(|m| m + 1).collect::<Vec<_>>(),
            "stands_out": p.by_element.stands_out(agreement::SIGNIFICANCE),
        })),
        "parameters": or_why(&parts.parameters, parameters_json),
        "functions": parts.functions,
        "profile": judged.map(|(p, j)| json!({
            "name": p.name, "source": p.source, "verified": p.verified,
            "passed": j.passed, "probability": j.probability, "checks": j.checks,
        })),
    })
}

/// A part, or `{"none": why}`.
fn or_why<T>(part: &Result<T, String>, write: impl Fn(&T) -> Value) -> Value {
    match part {
        Ok(found) => write(found),
        Err(why) => json!({ "none": why }),
    }
}

fn sensors_json(s: &SensorReport) -> Value {
    let steps = |list: &[SensorRemoval]| -> Vec<Value> {
        list.iter()
            .map(|r| json!({"sensor": s.sensors[r.sensor].sensor, "mean_mac": r.mean_mac, "mac": r.mac}))
            .collect()
    };
    json!({"sensors": s.sensors, "mean_mac": s.mean_mac, "removals": steps(&s.removals), "turned_over": steps(&s.turns)})
}

/// What a test tells of the parameters.
pub(crate) fn parameters_json(s: &Sensitivities) -> Value {
    json!({
        "information": s.information,
        "identifiability": s.identifiability.as_ref().map(identifiability_json),
        "with_mass_known": s.weighed.as_ref().map(identifiability_json),
        "collinear": s.collinear.iter().map(|g| json!({
            "parameters": g.parameters.iter().map(|&p| s.names[p].as_str()).collect::<Vec<_>>(), "cosine": g.cosine,
        })).collect::<Vec<_>>(),
    })
}

fn identifiability_json(i: &Identifiability) -> Value {
    let groups: Vec<Value> = i
        .groups
        .iter()
        .map(|g| {
            let names: Vec<&str> = g.parameters.iter().map(|&p| i.names[p].as_str()).collect();
            json!({"parameters": names, "acts_through": i.combinations_in_words(g)})
        })
        .collect();
    json!({
        "rank": i.rank,
        "n_parameters": i.names.len(),
        "singular_values": i.singular_values.as_slice(),
        "groups": groups,
        "by_themselves": i.identifiable.iter().map(|&p| i.names[p].as_str()).collect::<Vec<_>>(),
        "text": i.to_string(),
    })
}

pub(crate) fn pair_json(p: &AssessedPair) -> Value {
    json!({
        "test_hz": p.test_hz,
        "model_hz": p.model_hz,
        "error_percent": p.error_percent,
        "mac": p.mac,
        "test_mode": p.test_mode + 1,
        "model_mode": p.model_mode + 1,
        "test_label": p.test_label,
        "model_label": p.model_label,
        "probability": p.probability,
        "by_user": p.by_user,
        "flags": p.flags,
    })
}

pub(crate) fn unpaired_json(u: &UnpairedMode) -> Value {
    json!({
        "mode": u.mode + 1,
        "frequency_hz": u.frequency_hz,
        "label": u.label,
        "best_mac": u.best.map(|b| b.1),
        "foreign_probability": u.foreign,
        "reason": u.reason,
    })
}

pub(crate) fn readings_json(a: &Assessment) -> Value {
    let one = |r: &AssessedReading| {
        let unit = if r.is_angle { "rad" } else { "m" };
        json!({"test": r.test, "sensor": r.sensor, "unit": unit, "measured": r.measured, "sd": r.sd, "model": r.model})
    };
    a.readings.iter().map(one).collect()
}

pub(crate) fn functions_json(a: &Assessment) -> Value {
    a.functions.map_or(Value::Null, |f| json!({"values": f.n_values, "chi_squared": f.chi_squared}))
}

/// Which of the data are measured and which synthetic, in words.
pub(crate) fn origins(test: &TestData) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    let mut add = |what: &str, origin: &Origin| {
        let text = format!("{what} {}", origin.word());
        if !out.contains(&text) {
            out.push(text);
        }
    };
    for mode in &test.modes {
        add("frequencies", &mode.origin);
    }
    for mode in &test.modes {
        if let Some(origin) = &mode.shape_origin {
            add("shapes", origin);
        }
    }
    for t in &test.static_tests {
        add("static readings", &t.origin);
    }
    for p in &test.mass_properties {
        add("mass properties", &p.origin);
    }
    if let Some(fit) = &test.frf_fit {
        out.push(format!("functions of {}", fit.files.join(", ")));
    }
    out
}
