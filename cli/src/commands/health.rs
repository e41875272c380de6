//! `retune health`

use super::measured::{band, findings_json, findings_text, functions, has_fault, read};
use crate::args::Health;
use crate::output::{Failure, print, print_json, style};
use crate::{DONE, SHORT};
use retune::identify::health::{check_test, compare_runs};
use retune::identify::{IdentifyOptions, identify};
use serde_json::json;

pub(crate) fn run(args: &Health) -> Result<u8, Failure> {
    let found = read(&args.files, &args.measurement)?;
    let frfs = functions(&found)?;
    let options = IdentifyOptions { band_hz: band(args.band.as_deref())?, ..IdentifyOptions::default() };
    let identification = identify(frfs, &options)?;
    let n_suspension = usize::from(args.suspension);
    let mut findings = check_test(frfs, Some(&identification), found.geometry.as_ref(), n_suspension)?;
    if !args.against.is_empty() {
        let other = read(&args.against, &args.measurement)?;
        let other = functions(&other)?;
        let names: Vec<String> = frfs.responses.iter().map(|c| c.name.clone()).collect();
        if other.responses.iter().map(|c| &c.name).ne(&names) {
            return Err(Failure::text("the runs have different responses; they cannot be compared"));
        }
        let second = identify(other, &options)?;
        findings.extend(compare_runs(&identification.modes, &second.modes, &names));
        findings.sort_by_key(|f| std::cmp::Reverse(f.level));
    }
    if args.json {
        print_json(&json!({"ok": !has_fault(&findings), "findings": findings_json(&findings)}));
    } else {
        print(&findings_text(&findings, &style(&std::io::stdout())));
    }
    Ok(if has_fault(&findings) { SHORT } else { DONE })
}
