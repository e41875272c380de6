//! `retune compare`

use crate::args::{Compare, Pairing};
use crate::output::{Failure, pairs, print, print_json, style, warn};
use crate::{DONE, files};
use retune::correlation::{PairBy, PairingOptions};
use retune::data::{Origin, TestData};
use retune::model::ParametricModel;
use retune::objective::Comparison;
use retune::update::{AssessedPair, AssessedReading, Assessment, UnpairedMode, assess};
use serde_json::{Value, json};
use std::path::Path;

pub(crate) fn run(args: &Compare) -> Result<u8, Failure> {
    let all = args.tests.iter().map(|path| one(args, path)).collect::<Result<Vec<_>, _>>()?;
    match all.as_slice() {
        [Shown::Json(value)] => print_json(value),
        _ if args.json => {
            let values: Vec<&Value> =
                all.iter().filter_map(|s| if let Shown::Json(v) = s { Some(v) } else { None }).collect();
            print_json(&json!({ "tests": values }));
        }
        _ => {
            let texts: Vec<&str> =
                all.iter().filter_map(|s| if let Shown::Text(t) = s { Some(t.as_str()) } else { None }).collect();
            print(&texts.join("\n"));
        }
    }
    Ok(DONE)
}

enum Shown {
    Json(Value),
    Text(String),
}

/// The comparison with one test.
fn one(args: &Compare, path: &Path) -> Result<Shown, Failure> {
    let (test, mut test_warnings, test_text) = files::test(path)?;
    let (model, model_warnings, model_text) =
        files::tested_model(&args.model, args.configuration.as_deref(), (&test, path, &test_text))?;
    test_warnings.extend(files::check_sensors(&model, &test, path, &test_text)?);
    warn(&args.model, &model_text, &model_warnings);
    warn(path, &test_text, &test_warnings);
    for (word, value) in [("--min-mac", args.min_mac), ("--frequency-window", args.frequency_window)] {
        if value.is_nan() || value < 0.0 {
            return Err(Failure::text(format!("{word} is {value}; it must be zero or above")));
        }
    }
    let by = match args.pairing {
        Pairing::Mac if test.modes.iter().any(|m| m.shape.is_some()) => PairBy::Mac,
        _ => PairBy::Order,
    };
    let options =
        PairingOptions { by, min_mac: args.min_mac, frequency_window: args.frequency_window, same_family_only: true };
    let comparison = Comparison::new(&model, &test, options)?;
    let a = assess(&comparison, &model.parameters().nominal())?;
    if args.json {
        Ok(Shown::Json(json!({
            "test": test.name,
            "pairs": a.pairs.iter().map(pair_json).collect::<Vec<_>>(),
            "unpaired_test": a.unpaired_test.iter().map(unpaired_json).collect::<Vec<_>>(),
            "unpaired_model": a.unpaired_model.iter().map(unpaired_json).collect::<Vec<_>>(),
            "static_readings": readings_json(&a),
            "cost": a.cost,
            "paper_cost": a.paper_cost,
            "chi_squared": a.misfit.chi_squared,
            "n_data": a.misfit.n_data,
            "p_value": a.misfit.p_value,
            "origins": origins(&test),
        })))
    } else {
        let style = style(&std::io::stdout());
        let mut out = format!("model  {}\ntest   {}\n", model.spec().name, test.name);
        out += &format!("data   {}\n\n", origins(&test).join("; "));
        out += &pairs(&a, &style);
        out += &summary(&a);
        Ok(Shown::Text(out))
    }
}

/// The last lines of a comparison.
pub(crate) fn summary(a: &Assessment) -> String {
    format!(
        "\nerror is (model - test)/test: plus means that the model is too high\n{}\ncost of MAC and frequencies (Gupta et al. 2015, equation (4) / 2n): {:.4}\n",
        a.misfit, a.paper_cost
    )
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
    })
}

pub(crate) fn unpaired_json(u: &UnpairedMode) -> Value {
    json!({"mode": u.mode + 1, "frequency_hz": u.frequency_hz, "label": u.label, "best_mac": u.best.map(|b| b.1)})
}

pub(crate) fn readings_json(a: &Assessment) -> Value {
    let one = |r: &AssessedReading| {
        let unit = if r.is_angle { "rad" } else { "m" };
        json!({"test": r.test, "sensor": r.sensor, "unit": unit, "measured": r.measured, "sd": r.sd, "model": r.model})
    };
    a.readings.iter().map(one).collect()
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
    out
}
