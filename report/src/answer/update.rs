//! What an update and a sampling answer.

use super::{assessment_mac, findings, functions, pair, readings, unpaired};
use retune::data::TestData;
use retune::model::ParametricModel;
use retune::update::{
    Alternative, Assessment, Inseparable, Marginal, ParameterChange, ParameterUncertainty, Peak, ReducedSearch,
    Sampled, Uncertainty, Update, marginals,
};
use serde_json::{Map, Value, json};

/// `retune update --json`.
///
/// * `tests` - the tests of the fit, in their order
pub fn updated(u: &Update, tests: &[&TestData]) -> Value {
    let assessed = std::iter::once(&u.after).chain(u.further.iter().map(|f| &f.after));
    let one = |(k, (t, after)): (usize, (&&TestData, &Assessment))| {
        json!({
            "name": t.name,
            "configuration": t.configuration,
            "pairs": after.pairs.iter().map(pair).collect::<Vec<_>>(),
            "unpaired_test": after.unpaired_test.iter().map(unpaired).collect::<Vec<_>>(),
            "mac": assessment_mac(after, t),
            "static_readings": readings(after),
            "functions_of_fit": functions(after),
            "suspect_sensors": findings(&u.suspects[k]),
            "sensors_left_out": u.left_out[k],
            "chi_squared": after.misfit.chi_squared,
            "n_data": after.misfit.n_data,
        })
    };
    json!({
        "cost_before": u.cost_before,
        "cost_after": u.optimum.cost,
        "evaluations": u.optimum.evaluations + u.optimum.linearizations,
        "termination": u.optimum.termination.text(),
        "parameters": listed(&u.parameters, &u.uncertainty),
        "alternatives": u.alternatives.iter().map(alternative).collect::<Vec<_>>(),
        "unidentifiable": u.uncertainty.inseparable.iter().map(inseparable).collect::<Vec<_>>(),
        "rank": u.uncertainty.rank,
        "remarks": u.uncertainty.remarks,
        "uncertainty_evaluations": u.uncertainty.evaluations,
        "regularization_weight": u.regularization,
        "reduced": u.reduced.as_ref().map(reduced),
        "tests": tests.iter().zip(assessed).enumerate().map(one).collect::<Vec<_>>(),
        "pairs": u.after.pairs.iter().map(pair).collect::<Vec<_>>(),
        "unpaired_test": u.after.unpaired_test.iter().map(unpaired).collect::<Vec<_>>(),
        "mac": tests.first().map(|t| assessment_mac(&u.after, t)),
        "chi_squared": u.after.misfit.chi_squared,
        "n_data": u.after.misfit.n_data,
        "costs_by_batch_kernel": u.optimum.paths.batch,
        "costs_by_reference_path": u.optimum.paths.reference,
        "warnings": u.optimum.warnings,
    })
}

/// What reduced models had to do with a result.
pub fn reduced(r: &ReducedSearch) -> Value {
    json!({
        "dofs": r.dofs.iter().map(|d| d.1).collect::<Vec<_>>(),
        "dofs_of_model": r.dofs.iter().map(|d| d.0).collect::<Vec<_>>(),
        "samples": r.n_samples,
        "accuracy": r.accuracy,
        "evaluations": r.evaluations,
        "cost": r.costs[0],
        "cost_of_model": r.costs[1],
    })
}

fn alternative(a: &Alternative) -> Value {
    json!({"cost": a.cost, "starts": a.n_starts, "parameters": listed(&a.parameters, &a.uncertainty)})
}

fn listed(parameters: &[ParameterChange], c: &Uncertainty) -> Value {
    let one = |p: &ParameterChange| {
        let mut entry = json!({
            "name": p.name, "unit": p.unit, "before": p.before, "after": p.after,
            "lower": p.lower, "upper": p.upper, "at_bound": p.at_bound,
        });
        let place = c.parameters.iter().position(|k| k.name == p.name);
        if let (Some(i), Some(entry)) = (place, entry.as_object_mut()) {
            entry.extend(known(&c.parameters[i]));
            entry.insert("correlations".to_string(), correlations_of(c, i));
        }
        entry
    };
    parameters.iter().map(one).collect()
}

fn known(p: &ParameterUncertainty) -> Map<String, Value> {
    let held = p
        .held
        .map(|h| json!({"bound": if h.is_upper { "upper" } else { "lower" }, "would_be": h.would_be, "gain": h.gain}));
    let entries = [
        ("sd", json!(p.sd)),
        ("why_no_sd", json!(p.why_no_sd())),
        ("interval", json!(p.interval)),
        ("interval_ends_at_bound", json!(p.ends_at_bound)),
        ("interval_method", json!(p.method.word())),
        ("determined", json!(!p.is_undetermined())),
        ("held", json!(held)),
    ];
    entries.into_iter().map(|(k, v)| (k.to_string(), v)).collect()
}

/// Correlations with the other parameters; null where one of the two has no standard deviation.
fn correlations_of(c: &Uncertainty, i: usize) -> Value {
    let others = (0..c.parameters.len()).filter(|&j| j != i);
    let known = |j: usize| Some(c.correlations[(i, j)]).filter(|rho| rho.is_finite());
    Value::Object(others.map(|j| (c.parameters[j].name.clone(), json!(known(j)))).collect())
}

fn inseparable(g: &Inseparable) -> Value {
    json!({"parameters": g.parameters, "numbers": g.n_numbers, "combinations": g.combinations, "shared": g.shared})
}

/// `retune sample --json`.
///
/// * `model` - that of the first test
pub fn sampled(sampled: &Sampled, model: &dyn ParametricModel) -> Value {
    let found = &sampled.posterior;
    let all = marginals(found, model);
    let one = |(j, m): (usize, &Marginal)| {
        let others = (0..all.len()).filter(|&k| k != j).map(|k| (all[k].name.clone(), json!(m.correlations[k])));
        let [low, _, median, _, high] = m.quantiles;
        json!({
            "name": m.name, "unit": m.unit, "mean": m.mean, "sd": m.sd, "interval": [low, high], "median": median,
            "correlations": Value::Object(others.collect()),
        })
    };
    json!({
        "parameters": all.iter().enumerate().map(one).collect::<Vec<_>>(),
        "samples": found.samples.len(),
        "log_evidence": found.log_evidence,
        "log_evidence_se": found.log_evidence_se,
        "stages": found.n_stages,
        "evaluations": found.evaluations,
        "acceptance": found.acceptance,
        "peaks": sampled.peaks.iter().map(|p| peak(p, &all)).collect::<Vec<_>>(),
        "reduced": sampled.reduced.as_ref().map(reduced),
        "chi_squared": sampled.misfit.chi_squared,
        "n_data": sampled.misfit.n_data,
        "p_value": sampled.misfit.p_value,
        "lowest_cost": found.costs.iter().copied().fold(f64::INFINITY, f64::min),
    })
}

fn peak(p: &Peak, all: &[Marginal]) -> Value {
    let one = |(k, m): (usize, &Marginal)| json!({"name": m.name, "unit": m.unit, "mean": p.mean[k], "sd": p.sd[k]});
    json!({"share": p.share, "parameters": all.iter().enumerate().map(one).collect::<Vec<_>>()})
}
