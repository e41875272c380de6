//! `retune modes`

use crate::args::Modes;
use crate::output::{Failure, print, style, warn};
use crate::{DONE, files};
use retune::modal::SolveOptions;
use retune::model::{ParametricModel, solve_modes};
use retune::update::name_modes;
use retune_report::answer;
use retune_report::text::{Align, Table, hertz};

pub(crate) fn run(args: &Modes) -> Result<u8, Failure> {
    args.answer.check()?;
    let (model, warnings, text) = files::model(&args.model.path, args.model.configuration())?;
    warn(&args.model.path, &text, &warnings);
    let theta = model.parameters().nominal();
    let options = SolveOptions { n_elastic: usize::from(args.number), shift: None };
    let modes = solve_modes(&model, &theta, options)?;
    let named = name_modes(&model, &theta, &modes)?;
    if args.answer.needs_json() {
        args.answer.give(&answer::modes(&named));
    }
    if !args.answer.json {
        let mut table = Table::new([
            ("mode", Align::Right),
            ("Hz", Align::Right),
            ("name", Align::Left),
            ("torsion energy", Align::Right),
        ]);
        for (i, m) in named.iter().enumerate() {
            let torsion = m.torsion.filter(|_| i >= modes.n_rigid);
            table.row([
                (i + 1).to_string().into(),
                hertz(m.frequency_hz, 4).into(),
                m.label.as_str().into(),
                torsion.map_or_else(String::new, |t| format!("{:.0} %", 100.0 * t)).into(),
            ]);
        }
        print(&table.render(&style(&std::io::stdout())));
    }
    Ok(DONE)
}
