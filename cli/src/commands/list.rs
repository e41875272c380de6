//! `retune list`

use crate::DONE;
use crate::args::{List, ListOf};
use crate::output::{Failure, print, print_json, reference_style};
use retune::correlation::{BUILTIN_PROFILES, parse_profiles};
use retune::effect::{EFFECTS, Effect};
use retune::element::{ELEMENTS, Element};
use retune::fault::{FAULTS, Fault};
use retune::matrices::{MATRIX_READERS, MatrixReader};
use retune::objective::{RESIDUALS, Residual};
use retune::optim::OPTIMIZERS;
use retune::report::text::{Align, Table};
use serde_json::json;

pub(crate) fn run(args: &List) -> Result<u8, Failure> {
    let profiles = parse_profiles(BUILTIN_PROFILES)?;
    let rows: Vec<(&str, &str)> = match args.of {
        ListOf::Elements => ELEMENTS.iter().map(|e| (Element::name(*e), e.summary())).collect(),
        ListOf::Residuals => RESIDUALS.iter().map(|r| (Residual::name(*r), r.summary())).collect(),
        ListOf::Effects => EFFECTS.iter().map(|e| (Effect::name(*e), e.about().summary)).collect(),
        ListOf::Faults => FAULTS.iter().map(|f| (Fault::name(*f), f.about().summary)).collect(),
        ListOf::Profiles => profiles.iter().map(|p| (p.name.as_str(), p.source.as_str())).collect(),
        ListOf::Matrices => MATRIX_READERS.iter().map(|r| (MatrixReader::name(*r), r.summary())).collect(),
        ListOf::Optimizers => OPTIMIZERS.iter().map(|o| (o.name, o.summary)).collect(),
    };
    if args.json {
        let members: Vec<_> = rows.iter().map(|(name, summary)| json!({"name": name, "summary": summary})).collect();
        print_json(&json!({ "members": members }));
    } else {
        let mut table = Table::new([("name", Align::Left), ("what it is", Align::Left)]);
        for (name, summary) in rows {
            table.row([name.into(), summary.into()]);
        }
        print(&table.render(&reference_style()));
        if args.of != ListOf::Matrices {
            print("\n`retune explain NAME` tells more\n");
        }
    }
    Ok(DONE)
}
