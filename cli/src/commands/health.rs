//! `retune health`

use super::measured::{band, findings_text, has_fault, read, refuse_answers, shape_functions};
use crate::args::Health;
use crate::output::{Failure, print, remarks, style, warn};
use crate::{DONE, SHORT, files};
use retune::data::{FrfSet, Measurements, Origin, Sensor, TestData, TestMode};
use retune::identify::health::{
    Finding, HealthOptions, check_damping, check_shapes, check_test, compare_runs, reversed_time_finding,
};
use retune::identify::{IdentifyOptions, identify, sensors, test_modes};
use retune::update::{held_modes, place, points_of, sensors_by_model};
use retune_report::answer;
use serde_json::json;

pub(crate) fn run(args: &Health) -> Result<u8, Failure> {
    args.answer.check()?;
    let mut findings = findings(args)?;
    findings.sort_by_key(|f| std::cmp::Reverse(f.level));
    if args.answer.needs_json() {
        args.answer.give(&json!({"ok": !has_fault(&findings), "findings": answer::findings(&findings)}));
    }
    if !args.answer.json {
        print(&findings_text(&findings, &style(&std::io::stdout())));
    }
    Ok(if has_fault(&findings) { SHORT } else { DONE })
}

fn findings(args: &Health) -> Result<Vec<Finding>, Failure> {
    let options = HealthOptions { n_suspension: usize::from(args.suspension), has_model: args.model.is_some() };
    let two_runs = || Failure::text("--against compares functions of two runs; these files hold modes");
    if let [path] = &args.files[..]
        && files::is_test(path)
    {
        refuse_answers(path, &args.measurement)?;
        let (mut test, warnings, text) = files::test(path)?;
        warn(path, &text, &warnings);
        if !args.against.is_empty() {
            return Err(two_runs());
        }
        let mut findings = check_shapes(&test.sensors, &test.modes, options)?;
        if let Some(model_path) = &args.model {
            let (model, warnings, model_text) =
                files::tested_model(model_path, args.configuration.as_deref(), (&mut test, path, &text))?;
            warn(model_path, &model_text, &warnings);
            warn(path, &text, &files::check_sensors(&model, &test, path, &text)?);
            findings.extend(sensors_by_model(&model, &test, options.n_suspension)?);
        }
        return Ok(findings);
    }
    let found = read(&args.files, &args.measurement)?;
    if let (None, Some(modes)) = (&found.frfs, &found.modes) {
        if !args.against.is_empty() {
            return Err(two_runs());
        }
        let damping = check_damping(&modes.modes);
        let (sensors, modes) = held_modes(&found, modes, &Origin::Measured(String::new()));
        let mut findings = [damping, check_shapes(&sensors, &modes, options)?].concat();
        findings.extend(judged(args, sensors, modes, options)?);
        return Ok(findings);
    }
    let frfs = shape_functions(&found)?;
    of_functions(args, &found, &frfs, options)
}

/// What the model says of sensors that files of measurements hold.
fn judged(
    args: &Health,
    sensors: Vec<Sensor>,
    modes: Vec<TestMode>,
    options: HealthOptions,
) -> Result<Vec<Finding>, Failure> {
    let Some(path) = &args.model else { return Ok(Vec::new()) };
    let (model, warnings, text) = files::model(path, args.configuration.as_deref())?;
    warn(path, &text, &warnings);
    let mut test = TestData { sensors, modes, ..TestData::default() };
    if !points_of(&test).is_empty() {
        remarks(None, &place(&model, &mut test)?);
    }
    Ok(sensors_by_model(&model, &test, options.n_suspension)?)
}

fn of_functions(
    args: &Health,
    found: &Measurements,
    frfs: &FrfSet,
    health: HealthOptions,
) -> Result<Vec<Finding>, Failure> {
    let options = IdentifyOptions { band_hz: band(args.band.as_deref())?, ..IdentifyOptions::default() };
    let identification = identify(frfs, &options)?;
    let mut findings = check_test(frfs, Some(&identification), found.geometry.as_ref(), health)?;
    findings.extend(found.is_time_reversed.then(reversed_time_finding));
    if args.model.is_some() {
        let sensors = sensors(frfs, found.geometry.as_ref(), None)?;
        let modes = test_modes(&identification.modes, &Origin::Measured(String::new()));
        findings.extend(judged(args, sensors, modes, health)?);
    }
    if !args.against.is_empty() {
        let other = read(&args.against, &args.measurement)?;
        let other = shape_functions(&other)?;
        let names: Vec<String> = frfs.responses.iter().map(|c| c.name.clone()).collect();
        if other.responses.iter().map(|c| &c.name).ne(&names) {
            return Err(Failure::text("the runs have different responses; they cannot be compared"));
        }
        let second = identify(&other, &options)?;
        findings.extend(compare_runs(&identification.modes, &second.modes, &names));
    }
    Ok(findings)
}
