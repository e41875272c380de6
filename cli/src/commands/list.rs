//! `retune list`

use crate::args::{List, ListOf};
use crate::lists::{lists, members};
use crate::output::{Failure, print, print_json, reference_style};
use crate::{DONE, markdown};
use retune_report::text::{Align, Table};
use serde_json::json;

pub(crate) fn run(args: &List) -> Result<u8, Failure> {
    if let (true, Some(of)) = (args.markdown, args.of) {
        args.to.hand_over(&markdown::page(of)?)?;
        return Ok(DONE);
    }
    let rows = args.of.map_or_else(|| Ok(lists()), members)?;
    if args.json {
        let members: Vec<_> = rows.iter().map(|(name, summary)| json!({"name": name, "summary": summary})).collect();
        match &args.to.output {
            Some(_) => args.to.hand_over(&format!("{:#}\n", json!({ "members": members })))?,
            None => print_json(&json!({ "members": members })),
        }
        return Ok(DONE);
    }
    let mut table = Table::new([("name", Align::Left), ("what it is", Align::Left)]);
    for (name, summary) in &rows {
        table.row([name.as_str().into(), summary.as_str().into()]);
    }
    if args.to.output.is_some() {
        args.to.hand_over(&table.render(&retune_report::text::Style { width: 10_000, ..Default::default() }))?;
        return Ok(DONE);
    }
    print(&table.render(&reference_style()));
    match args.of {
        Some(ListOf::Matrices | ListOf::Units | ListOf::ExitCodes) => {}
        None => print("\n`retune list NAME` shows one\n"),
        Some(ListOf::Verbs) => print("\n`retune VERB --help` tells more\n"),
        Some(_) => print("\n`retune explain NAME` tells more\n"),
    }
    Ok(DONE)
}
