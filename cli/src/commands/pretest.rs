//! `retune pretest`

use crate::args::Pretest as Arguments;
use crate::output::{Failure, print, print_json, shown, style, warn};
use crate::{DONE, files, writing};
use retune::data::{Sensor, joined, write_test};
use retune::model::{Model, ParametricModel};
use retune::update::{Pretest, PretestOptions, TwinOptions, pretest, twin_modes};
use retune_report::answer;
use retune_report::text::{Align, Style, Table, Tone, hertz, number, wrap};
use std::fmt::Write as _;

/// Information that is rounding, nats.
const NOTHING: f64 = 1e-9;
/// Rows of a ranked table.
const ROWS: usize = 8;

pub(crate) fn run(args: &Arguments) -> Result<u8, Failure> {
    let (model, warnings, text) = files::model(&args.model.path, args.model.configuration())?;
    warn(&args.model.path, &text, &warnings);
    let mut tests = Vec::with_capacity(args.test.len());
    for path in &args.test {
        let (test, mut warnings, text) = files::test(path)?;
        warnings.extend(files::check_sensors(&model, &test, path, &text)?);
        warn(path, &text, &warnings);
        tests.push(test);
    }
    // A sensor that several tests have is one.
    let given = joined(&tests.iter().collect::<Vec<_>>()).test.sensors;
    let options = PretestOptions {
        n_modes: args.modes.map(usize::from),
        n_sensors: args.sensors.map(usize::from),
        shape_noise: args.noise_shape,
        frequency_noise: args.noise_frequency,
    };
    if let Some(output) = &args.output {
        writing::check_output(output, args.overwrite.force)?;
    }
    let plan = pretest(&model, &given, &options)?;
    if args.print.json {
        print_json(&answer::pretest(&plan, &plan.choices(args.by)));
    } else {
        print(&as_text(&plan, args, &style(&std::io::stdout())));
    }
    if let Some(output) = &args.output
        && writing::write(output, &planned(&plan, args, &model, given)?)
        && !args.print.json
    {
        print(&format!("\nwritten: {}\n", shown(output)));
    }
    Ok(DONE)
}

/// A test file with the sensors that are there and those that were chosen, and the modes that the model predicts at them.
fn planned(plan: &Pretest, args: &Arguments, model: &Model, given: Vec<Sensor>) -> Result<String, Failure> {
    // The first way is that of effective independence.
    let chosen = plan.choices(args.by);
    let mut sensors = given;
    for &candidate in chosen.first().map_or(&[][..], |(_, choice)| &choice.kept) {
        let sensor = &plan.candidates[candidate];
        if sensors.iter().all(|s| s.name != sensor.name) {
            sensors.push(sensor.clone());
        }
    }
    let options = TwinOptions { n_modes: plan.modes.len(), ..TwinOptions::default() };
    let file = args.model.path.file_name().map(|f| f.to_string_lossy().into_owned()).unwrap_or_default();
    let origin = format!("predicted by `retune pretest` from {} ({file}), not measured", model.spec().name);
    let mut test = twin_modes(model, &model.parameters().nominal(), &sensors, &options, &origin)?;
    test.name = format!("{} (planned)", model.spec().name);
    test.description = format!("SYNTHETIC: every number was {origin}");
    test.configuration.clone_from(&args.model.configuration);
    Ok(write_test(&test))
}

fn as_text(plan: &Pretest, args: &Arguments, style: &Style) -> String {
    let name = |c: usize| plan.candidates[c].name.as_str();
    let mut out = format!("{}\n", style.paint(Tone::Strong, "Target modes"));
    let is_held = plan.modes.iter().any(|m| m.effective_mass.iter().any(|v| *v > 1e-9));
    let mut columns = vec![("#", Align::Right), ("Hz", Align::Right), ("mode", Align::Left)];
    let directions = ["x", "y", "z", "about x", "about y", "about z"];
    if is_held {
        columns.extend(directions.map(|d| (d, Align::Right)));
    }
    columns.push(("most kinetic energy", Align::Left));
    let mut table = Table::new(columns);
    for (k, m) in plan.modes.iter().enumerate() {
        let mut row =
            vec![(k + 1).to_string().into(), hertz(m.mode.frequency_hz, 3).into(), m.mode.label.as_str().into()];
        if is_held {
            row.extend(m.effective_mass.iter().map(|v| format!("{:.0} %", 100.0 * v).into()));
        }
        row.push(m.liveliest.map_or_else(String::new, |(c, s)| format!("{} {:.0} %", name(c), 100.0 * s)).into());
        table.row(row);
    }
    out += &table.render(style);
    if is_held {
        out += "x ... about z: effective mass, as a share of the whole\n";
    }
    let _ = writeln!(out, "\n{}", style.paint(Tone::Strong, "Sensors"));
    let [looked_at, moving] = plan.nodes;
    if looked_at < moving {
        let _ = writeln!(out, "of {looked_at} nodes, spread evenly over the {moving} that move");
    }
    for (method, choice) in plan.choices(args.by) {
        let names: Vec<&str> = choice.kept.iter().map(|&c| name(c)).collect();
        let text = format!(
            "{method}: {} (largest MAC between two modes {:.2})",
            names.join(", "),
            choice.largest_off_diagonal
        );
        for line in wrap(&text, style.width) {
            out += &format!("{line}\n");
        }
    }
    if let Some((off, n)) = plan.given {
        let _ = writeln!(out, "the {n} sensors given: largest MAC between two modes {off:.2}");
    }
    let _ = writeln!(out, "\n{}", style.paint(Tone::Strong, "Exciter"));
    for (modes, points) in &plan.exciters {
        let best: Vec<String> = points
            .iter()
            .take(4)
            .filter(|p| p.smallest > 0.0)
            .map(|p| format!("{} ({:.0} %)", name(p.candidate), 100.0 * p.smallest))
            .collect();
        let text = if best.is_empty() {
            format!("{modes}: no place drives all of them")
        } else {
            format!("{modes}: {}", best.join(", "))
        };
        for line in wrap(&text, style.width) {
            out += &format!("{line}\n");
        }
    }
    out += "in brackets: motion there in the least driven mode, of its largest\n";
    if plan.next.is_empty() {
        out += "\nno parameter has bounds, so no sensor can tell anything of them\n";
        return out;
    }
    let beside = if plan.given.is_some() { "those given" } else { "those of effective independence" };
    if plan.next.iter().all(|g| g.nats < NOTHING) {
        let _ = writeln!(out, "\none more sensor beside {beside} would tell nothing more of the parameters");
        return out;
    }
    let _ = writeln!(out, "\n{}", style.paint(Tone::Strong, &format!("One more sensor beside {beside}")));
    let mut table = Table::new([
        ("at", Align::Left),
        ("tells, nats", Align::Right),
        ("most of", Align::Left),
        ("whose sd falls to", Align::Right),
    ]);
    for g in plan.next.iter().take(ROWS) {
        let best = (0..g.sd_ratio.len()).min_by(|&a, &b| g.sd_ratio[a].total_cmp(&g.sd_ratio[b]));
        table.row([
            name(g.candidate).into(),
            number(g.nats).into(),
            best.map_or("", |j| plan.parameters[j].as_str()).into(),
            best.map_or_else(String::new, |j| format!("{:.0} %", 100.0 * g.sd_ratio[j])).into(),
        ]);
    }
    out += &table.render(style);
    out
}
