//! What an identification answers.

use retune::identify::health::Finding;
use retune::identify::{Segment, SpectrumPeak, complexity};
use retune::update::{Identified, Way};
use serde_json::{Value, json};

/// `retune identify --json`.
pub fn identified(found: &Identified) -> Value {
    match &found.way {
        Way::Functions { frfs, identification, method, window } => json!({
            "method": method.name(),
            "modes": found.modes.iter().zip(&identification.modes).map(|(t, m)| json!({
                "frequency_hz": t.frequency_hz.value, "frequency_sd": t.frequency_hz.sd,
                "damping": t.damping_ratio.map(|z| z.value), "damping_sd": t.damping_ratio.map(|z| z.sd),
                "mpc": m.complexity.mpc, "mean_phase_deviation_deg": m.complexity.mean_phase_deviation_deg,
                "sd_inflation": m.sd_inflation, "orders": m.n_orders,
            })).collect::<Vec<_>>(),
            "responses": frfs.responses.iter().map(|c| c.name.clone()).collect::<Vec<_>>(),
            "references": frfs.references.iter().map(|c| c.name.clone()).collect::<Vec<_>>(),
            "lines": frfs.n_lines(),
            "is_synthetic": found.is_synthetic,
            "exponential_window_per_s": window,
            "pieces": identification.segments.iter().map(piece).collect::<Vec<_>>(),
            "findings": findings(&found.findings),
        }),
        Way::Held { channels } => json!({
            "method": "as in the file",
            "modes": found.modes.iter().map(|t| json!({
                "frequency_hz": t.frequency_hz.value, "damping": t.damping_ratio.map(|z| z.value), "label": t.label,
                "mpc": t.shape.as_ref().map(|s| complexity(s).mpc),
            })).collect::<Vec<_>>(),
            "responses": channels,
            "is_synthetic": found.is_synthetic,
            "findings": findings(&found.findings),
        }),
        Way::Peaks(all) => {
            let one = |p: &SpectrumPeak| {
                json!({
                    "frequency_hz": p.frequency_hz, "frequency_sd": p.frequency_sd, "height_db": p.height_db,
                    "damping_at_most": p.damping_ratio,
                })
            };
            let spectrum = |(name, list): &(String, Vec<SpectrumPeak>)| json!({"name": name, "peaks": list.iter().map(one).collect::<Vec<_>>()});
            json!({"method": "peaks", "spectra": all.iter().map(spectrum).collect::<Vec<_>>()})
        }
    }
}

fn piece(s: &Segment) -> Value {
    json!({
        "from_hz": s.core_hz.0, "to_hz": s.core_hz.1, "is_converged": s.is_converged,
        "poles": s.diagrams.iter().map(|d| d.poles.len()).sum::<usize>(),
        "stable_columns": s.diagrams.iter().map(|d| d.chosen.len()).sum::<usize>(),
        "discarded": s.discarded.iter().map(|d| json!({
            "frequency_hz": d.frequency_hz, "damping": d.damping_ratio, "reason": d.reason,
        })).collect::<Vec<_>>(),
    })
}

/// Findings for programs.
pub fn findings(findings: &[Finding]) -> Value {
    let one = |f: &Finding| {
        let evidence: serde_json::Map<String, Value> =
            f.evidence.iter().map(|(name, value)| ((*name).to_string(), json!(value))).collect();
        json!({
            "level": f.level.word(), "code": f.code, "subject": f.subject, "evidence": evidence, "text": f.text, "remedy": f.remedy,
        })
    };
    findings.iter().map(one).collect()
}
