//! What the planning of a test answers.

use retune::correlation::SensorChoice;
use retune::update::Pretest;
use serde_json::{Value, json};

/// `retune pretest --json`.
///
/// * `choices` - ways to choose sensors that are asked for: names and choices, see [`Pretest::choices`]
pub fn pretest(plan: &Pretest, choices: &[(&str, &SensorChoice)]) -> Value {
    let name = |c: usize| plan.candidates[c].name.as_str();
    let choice = |c: &SensorChoice| {
        json!({
            "sensors": c.kept.iter().map(|&i| name(i)).collect::<Vec<_>>(),
            "steps": c.steps.iter().map(|(i, v)| json!([name(*i), v])).collect::<Vec<_>>(),
            "largest_off_diagonal": c.largest_off_diagonal,
            "ln_det_information": c.ln_det_information.is_finite().then_some(c.ln_det_information),
        })
    };
    let chosen: serde_json::Map<String, Value> =
        choices.iter().map(|(method, c)| (method.replace(' ', "_"), choice(c))).collect();
    json!({
        "modes": plan.modes.iter().map(|m| json!({
            "frequency_hz": m.mode.frequency_hz, "label": m.mode.label, "effective_mass": m.effective_mass,
            "liveliest": m.liveliest.map(|(c, s)| json!({"at": name(c), "share": s})),
        })).collect::<Vec<_>>(),
        "candidates": plan.candidates.iter().map(|c| c.name.as_str()).collect::<Vec<_>>(),
        "nodes": {"looked_at": plan.nodes[0], "moving": plan.nodes[1]},
        "sensors": chosen,
        "given": plan.given.map(|(off, n)| json!({"sensors": n, "largest_off_diagonal": off})),
        "exciters": plan.exciters.iter().map(|(modes, points)| json!({
            "modes": modes,
            "places": points.iter().map(|p| json!({
                "at": name(p.candidate), "optimum": p.optimum, "smallest": p.smallest,
                "displacement": p.displacement, "acceleration": p.acceleration,
            })).collect::<Vec<_>>(),
        })).collect::<Vec<_>>(),
        "next": plan.next.iter().map(|g| json!({
            "at": name(g.candidate), "nats": g.nats,
            "sd_ratio": plan.parameters.iter().zip(&g.sd_ratio).map(|(p, r)| (p.clone(), json!(r))).collect::<serde_json::Map<_, _>>(),
        })).collect::<Vec<_>>(),
    })
}
