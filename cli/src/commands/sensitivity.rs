//! `retune sensitivity`

use crate::args::Sensitivity as Arguments;
use crate::output::{Failure, print, style, warn};
use crate::{DONE, files};
use retune::correlation::{observation_rows, read_rows};
use retune::data::TestData;
use retune::linalg::DMatrix;
use retune::modal::{SolveOptions, solve};
use retune::model::{MOST_DENSE_DOFS, Matrices, ModalSolver, Model, ParametricModel};
use retune::objective::starting_point;
use retune::update::{
    FrfSensitivity, MASS_ROWS, Sensitivities, SensitivityOptions, frf_sensitivities, sensitivities, spread_sensors,
};
use retune_report::answer;
use retune_report::text::{Align, Cell, Style, Table, Tone, agreement, number, printable};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::PathBuf;

/// Of a model without dense matrices, how many times the modes in the band functions are made of.
const BEYOND: usize = 4;
/// Lines of the functions, over the band of the modes.
const LINES: usize = 201;

pub(crate) fn run(args: &Arguments) -> Result<u8, Failure> {
    args.answer.check()?;
    let cases = cases(args)?;
    let n_modes = usize::from(args.modes);
    let (mut texts, mut values) = (Vec::new(), Vec::new());
    for (model, test) in &cases {
        let found = sensitivities(model, test, SensitivityOptions { n_modes })?;
        let functions = functions(model, test, &found, args.damping)?;
        if args.answer.needs_json() {
            values.push(as_json(&found, &functions));
        }
        let head = if cases.len() > 1 {
            format!(
                "test   {}

",
                printable(&test.name)
            )
        } else {
            String::new()
        };
        texts.push(head + &as_text(&found, &functions, &style(&std::io::stdout())));
    }
    if args.answer.needs_json() {
        match values.as_slice() {
            [value] => args.answer.give(value),
            _ => args.answer.give(&json!({ "tests": values })),
        }
    }
    if !args.answer.json {
        print(&texts.join(
            "
",
        ));
    }
    Ok(DONE)
}

/// The model with each test, in the configuration that it names; without a test, with a sensor at every node.
fn cases(args: &Arguments) -> Result<Vec<(Model, TestData)>, Failure> {
    let (path, configuration) = (&args.model.path, args.model.configuration());
    if args.tests.is_empty() {
        let (model, warnings, text) = files::model(path, configuration)?;
        warn(path, &text, &warnings);
        let sensors = spread_sensors(&model).0;
        return Ok(vec![(model, TestData { sensors, ..TestData::default() })]);
    }
    let one = |(i, test_path): (usize, &PathBuf)| {
        let (mut test, mut warnings, text) = files::test(test_path)?;
        let (model, model_warnings, model_text) =
            files::tested_model(path, configuration, (&mut test, test_path, &text))?;
        warnings.extend(files::check_sensors(&model, &test, test_path, &text)?);
        if i == 0 {
            warn(path, &model_text, &model_warnings);
        }
        warn(test_path, &text, &warnings);
        Ok((model, test))
    };
    args.tests.iter().enumerate().map(one).collect()
}

/// Functions from the liveliest sensor to all, from half the first to 1.1 times the last frequency.
fn functions(model: &Model, test: &TestData, found: &Sensitivities, damping: f64) -> Result<FrfSensitivity, Failure> {
    let theta = starting_point(model);
    let n_dof = model.dof_map().n_dof();
    let (matrices, modes) = if n_dof <= MOST_DENSE_DOFS {
        let system = model.assemble(&theta)?;
        let options = SolveOptions { n_elastic: n_dof, shift: None };
        let modes = solve(&system.stiffness, &system.mass, &model.dof_map().rigid_motions(), options)?;
        (Matrices::Dense(system), modes)
    } else {
        let count = BEYOND * found.modes.len();
        ModalSolver::new(model, &theta, count)?.solve(model, &theta, count)?
    };
    let responses = read_rows(&observation_rows(model, &test.sensors)?, &modes.shapes);
    let frequencies: Vec<f64> = found.modes.iter().map(|m| m.frequency_hz).collect();
    let (first, last) = match (frequencies.first(), frequencies.last()) {
        (Some(first), Some(last)) if responses.nrows() > 0 => (0.5 * first, 1.1 * last),
        _ => return Ok(FrfSensitivity { frequencies_hz: Vec::new(), relative: vec![Vec::new(); found.names.len()] }),
    };
    let at = responses.columns(modes.n_rigid, found.modes.len().min(modes.len() - modes.n_rigid));
    let size = |i: usize| at.row(i).iter().map(|v| v.abs()).fold(f64::INFINITY, f64::min);
    let liveliest = (0..at.nrows()).max_by(|&a, &b| size(a).total_cmp(&size(b)).then(b.cmp(&a))).unwrap_or(0);
    let reference = DMatrix::from_rows(&[responses.row(liveliest)]);
    let lines: Vec<f64> = (0..LINES).map(|l| first + (last - first) * l as f64 / (LINES - 1) as f64).collect();
    Ok(frf_sensitivities(model, (&matrices, &modes), (&responses, &reference), &lines, damping)?)
}

/// Root mean square over the lines.
fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

fn as_text(s: &Sensitivities, functions: &FrfSensitivity, style: &Style) -> String {
    let mut out = format!(
        "{}\n",
        style.paint(
            Tone::Strong,
            &format!(
                "Frequencies of the first {} elastic modes: change in % over the whole interval of each parameter",
                s.modes.len()
            )
        )
    );
    let heads: Vec<String> = s.modes.iter().map(|m| format!("{:.2} Hz", m.frequency_hz)).collect();
    let per_mode = |out: &mut String, cell: &dyn Fn(usize, usize) -> f64| {
        let columns =
            std::iter::once(("parameter", Align::Left)).chain(heads.iter().map(|h| (h.as_str(), Align::Right)));
        let mut table = Table::new(columns);
        for (k, name) in s.names.iter().enumerate() {
            let cells = (0..s.modes.len()).map(|m| {
                let value = cell(m, k);
                // No minus sign before a zero.
                let value = if value.abs() < 0.005 { 0.0 } else { value };
                if value.is_nan() { Cell::from("–") } else { format!("{value:.2}").into() }
            });
            table.row(std::iter::once(name.as_str().into()).chain(cells));
        }
        *out += &table.render(style);
    };
    per_mode(&mut out, &|m, k| 100.0 * s.frequency[(m, k)] * s.widths[k] / s.modes[m].frequency_hz);
    let _ = writeln!(
        out,
        "\n{}",
        style.paint(Tone::Strong, "Shapes: how far each turns over the whole interval, % of its length")
    );
    per_mode(&mut out, &|m, k| 100.0 * s.shape[(m, k)]);
    let _ = writeln!(out, "\n{}", style.paint(Tone::Strong, "Functions and mass: change over the whole interval"));
    let heads = [
        ("parameter", Align::Left),
        ("functions, % of rms", Align::Right),
        ("mass kg", Align::Right),
        ("cg x m", Align::Right),
        ("Ixx kg m2", Align::Right),
        ("Iyy kg m2", Align::Right),
        ("Izz kg m2", Align::Right),
        ("interval", Align::Right),
        ("unit", Align::Left),
    ];
    let with = |columns: &[usize]| {
        let mut table = Table::new(columns.iter().map(|&c| heads[c]));
        for (k, name) in s.names.iter().enumerate() {
            let mass = |row: usize| {
                if s.mass.nrows() == 0 { "–".to_string() } else { number(s.mass[(row, k)] * s.widths[k]) }
            };
            let cell = |column: usize| match column {
                0 => name.clone(),
                1 => number(100.0 * rms(&functions.relative[k])),
                2 => mass(0),
                3 => mass(1),
                4 => mass(4),
                5 => mass(5),
                6 => mass(6),
                7 => number(s.widths[k]),
                _ => s.units[k].clone(),
            };
            table.row(columns.iter().map(|&c| cell(c).as_str().into()));
        }
        table
    };
    let whole = with(&[0, 1, 2, 3, 4, 5, 6, 7, 8]);
    if whole.natural_width() <= style.width {
        out += &whole.render(style);
    } else {
        out += &with(&[0, 1, 2, 3, 7, 8]).render(style);
        out.push('\n');
        out += &with(&[0, 4, 5, 6]).render(style);
    }
    agreement::wrapped(
        &mut out,
        "linear at the estimates: a large number says that the change over the interval is not linear",
        style,
    );
    agreement::parameters_table(&mut out, s, style);
    out
}

fn as_json(s: &Sensitivities, functions: &FrfSensitivity) -> Value {
    let parameters: Vec<Value> = (0..s.names.len())
        .map(|k| {
            let modes: Vec<Value> = (0..s.modes.len())
                .map(|m| {
                    let shape = s.shape[(m, k)];
                    json!({
                        "hz_per_unit": s.frequency[(m, k)],
                        "percent_per_interval": 100.0 * s.frequency[(m, k)] * s.widths[k] / s.modes[m].frequency_hz,
                        "shape_percent_per_interval": shape.is_finite().then_some(100.0 * shape),
                    })
                })
                .collect();
            let mass: serde_json::Map<String, Value> = MASS_ROWS
                .iter()
                .take(s.mass.nrows())
                .enumerate()
                .map(|(row, name)| (name.replace(' ', "_"), json!(s.mass[(row, k)])))
                .collect();
            json!({
                "name": s.names[k], "unit": s.units[k], "interval": s.widths[k], "modes": modes,
                "mass_properties_per_unit": mass,
                "functions_percent_per_interval": functions.relative[k].iter().map(|v| 100.0 * v).collect::<Vec<_>>(),
            })
        })
        .collect();
    json!({
        "modes": s.modes.iter().map(|m| json!({"frequency_hz": m.frequency_hz, "label": m.label})).collect::<Vec<_>>(),
        "parameters": parameters,
        "function_lines_hz": functions.frequencies_hz,
        "test": answer::parameter_information(s),
    })
}
