//! What a comparison answers.

use super::findings;
use crate::text::agreement::SIGNIFICANCE;
use retune::correlation::{CriteriaProfile, Identifiability, SensorRemoval};
use retune::data::{Origin, TestData};
use retune::update::{Agreement, AssessedPair, AssessedReading, Assessment, Sensitivities, SensorReport, UnpairedMode};
use serde_json::{Value, json};

/// `retune compare --json` with one test.
pub fn comparison(parts: &Agreement, profile: Option<&CriteriaProfile>) -> Value {
    let (test, a) = (&parts.test, &parts.assessment);
    let judged = profile.zip(parts.judgement.as_ref());
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
        "pairs": a.pairs.iter().map(pair).collect::<Vec<_>>(),
        "unpaired_test": a.unpaired_test.iter().map(unpaired).collect::<Vec<_>>(),
        "mac": assessment_mac(a, test),
        "unpaired_model": a.unpaired_model.iter().map(unpaired).collect::<Vec<_>>(),
        "static_readings": readings(a),
        "functions_of_fit": functions(a),
        "swapped": swapped,
        "cost": a.cost,
        "paper_cost": a.paper_cost,
        "chi_squared": a.misfit.chi_squared,
        "n_data": a.misfit.n_data,
        "p_value": a.misfit.p_value,
        "misfit": a.misfit.to_string(),
        "origins": data_origins(test),
        "modes": modes,
        "close_modes": parts.mixed.iter().map(|g| json!({
            "test_modes": g.experimental.iter().map(|m| m + 1).collect::<Vec<_>>(),
            "model_modes": g.analytical.iter().map(|m| m + 1).collect::<Vec<_>>(),
            "lowest_mac": g.lowest_mac, "lowest_mac_with_space": g.lowest_subspace_mac,
        })).collect::<Vec<_>>(),
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
            "stands_out": p.by_element.stands_out(SIGNIFICANCE),
        })),
        "parameters": or_why(&parts.parameters, parameter_information),
        "functions": parts.functions,
        "profile": judged.map(|(p, j)| json!({
            "name": p.name, "source": p.source, "verified": p.verified,
            "passed": j.passed, "probability": j.probability, "checks": j.checks,
        })),
        "coarse_mesh": parts.coarse_mesh.iter().map(|c| json!({
            "test_mode": c.test_mode + 1, "relative": c.relative, "deviations": c.deviations, "part": c.part,
        })).collect::<Vec<_>>(),
        "suspect_sensors": findings(&parts.suspects),
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
pub fn parameter_information(s: &Sensitivities) -> Value {
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

/// One pair.
pub fn pair(p: &AssessedPair) -> Value {
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

/// A mode without a partner.
pub fn unpaired(u: &UnpairedMode) -> Value {
    json!({
        "mode": u.mode + 1,
        "frequency_hz": u.frequency_hz,
        "label": u.label,
        "best_mac": u.best.map(|b| b.1),
        "foreign_probability": u.foreign,
        "reason": u.reason,
    })
}

/// Readings of static tests beside those of the model.
pub fn readings(a: &Assessment) -> Value {
    let one = |r: &AssessedReading| {
        let unit = if r.is_angle { "rad" } else { "m" };
        json!({"test": r.test, "sensor": r.sensor, "unit": unit, "measured": r.measured, "sd": r.sd, "model": r.model})
    };
    a.readings.iter().map(one).collect()
}

/// What the functions of a fit say.
pub fn functions(a: &Assessment) -> Value {
    a.functions.map_or(Value::Null, |f| json!({"values": f.n_values, "chi_squared": f.chi_squared}))
}

/// The MAC matrix with what its rows and columns are.
pub fn assessment_mac(a: &Assessment, test: &TestData) -> Value {
    let rows: Vec<Vec<f64>> = a.mac.row_iter().map(|r| r.iter().copied().collect()).collect();
    json!({
        "model_hz": a.model_modes.iter().map(|m| m.frequency_hz).collect::<Vec<_>>(),
        "test_hz": test.modes.iter().map(|m| m.frequency_hz.value).collect::<Vec<_>>(),
        "values": rows,
    })
}

/// Which of the data are measured and which synthetic, in words.
pub fn data_origins(test: &TestData) -> Vec<String> {
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
