//! `retune health`

use super::measured::{band, findings_json, findings_text, functions, has_fault, held_modes, read, refuse_answers};
use crate::args::Health;
use crate::output::{Failure, print, print_json, style, warn};
use crate::{DONE, SHORT, files};
use retune::data::{FrfSet, Measurements, Origin};
use retune::identify::health::{Finding, check_shapes, check_test, compare_runs};
use retune::identify::{IdentifyOptions, identify};
use serde_json::json;

pub(crate) fn run(args: &Health) -> Result<u8, Failure> {
    let mut findings = findings(args)?;
    findings.sort_by_key(|f| std::cmp::Reverse(f.level));
    if args.json {
        print_json(&json!({"ok": !has_fault(&findings), "findings": findings_json(&findings)}));
    } else {
        print(&findings_text(&findings, &style(&std::io::stdout())));
    }
    Ok(if has_fault(&findings) { SHORT } else { DONE })
}

fn findings(args: &Health) -> Result<Vec<Finding>, Failure> {
    let n_suspension = usize::from(args.suspension);
    let two_runs = || Failure::text("--against compares functions of two runs; these files hold modes");
    if let [path] = &args.files[..]
        && files::is_test(path)
    {
        refuse_answers(path, &args.measurement)?;
        let (test, warnings, text) = files::test(path)?;
        warn(path, &text, &warnings);
        return if args.against.is_empty() {
            Ok(check_shapes(&test.sensors, &test.modes, n_suspension)?)
        } else {
            Err(two_runs())
        };
    }
    let found = read(&args.files, &args.measurement)?;
    if let (None, Some(modes)) = (&found.frfs, &found.modes) {
        let (sensors, modes) = held_modes(&found, modes, &Origin::Measured(String::new()));
        return if args.against.is_empty() {
            Ok(check_shapes(&sensors, &modes, n_suspension)?)
        } else {
            Err(two_runs())
        };
    }
    of_functions(args, &found, functions(&found)?)
}

fn of_functions(args: &Health, found: &Measurements, frfs: &FrfSet) -> Result<Vec<Finding>, Failure> {
    let options = IdentifyOptions { band_hz: band(args.band.as_deref())?, ..IdentifyOptions::default() };
    let identification = identify(frfs, &options)?;
    let mut findings = check_test(frfs, Some(&identification), found.geometry.as_ref(), usize::from(args.suspension))?;
    if !args.against.is_empty() {
        let other = read(&args.against, &args.measurement)?;
        let other = functions(&other)?;
        let names: Vec<String> = frfs.responses.iter().map(|c| c.name.clone()).collect();
        if other.responses.iter().map(|c| &c.name).ne(&names) {
            return Err(Failure::text("the runs have different responses; they cannot be compared"));
        }
        let second = identify(other, &options)?;
        findings.extend(compare_runs(&identification.modes, &second.modes, &names));
    }
    Ok(findings)
}
