//! `retune check --against`

use crate::args::Check;
use crate::output::{Failure, print, shown, style};
use crate::{DONE, SHORT, ledger};
use retune::model::Model;
use retune_exchange::{Agreement, MassAgreement, compare_results, read_results};
use retune_report::text::{Align, Table, Tone, number};
use serde_json::json;
use std::fmt::Write as _;

/// Bytes of one file of results, at most.
const LARGEST: u64 = 1 << 31;
/// Shapes that agree have at least this MAC.
const MAC: f64 = 0.9999;

pub(super) fn run(args: &Check, model: &Model) -> Result<u8, Failure> {
    let mut all = Vec::new();
    for path in &args.against {
        let bytes =
            ledger::read(path, LARGEST).map_err(|e| Failure::text(format!("cannot read {}: {e}", shown(path))))?;
        let results = read_results(&bytes).map_err(|e| Failure::text(format!("{}: {e}", shown(path))))?;
        let agreement = compare_results(model, &results, usize::from(args.number))?;
        if !args.answer.json {
            print(&describe(&format!("{} ({})", shown(path), results.kind), &agreement));
        }
        all.push((path, agreement));
    }
    let holds = all.iter().all(|(_, a)| a.holds(args.tolerance, MAC));
    if args.answer.needs_json() {
        args.answer.give(&json!({
            "ok": holds,
            "against": all.iter().map(|(path, a)| json!({
                "file": path,
                "rigid_body_modes": {"solver": a.n_rigid.0, "model": a.n_rigid.1},
                "mass": a.mass.as_ref().map(|m| json!({
                    "reference": m.reference, "solver": m.solver, "model": m.model, "largest_relative_difference": m.worst,
                })),
                "modes": a.modes.iter().map(|m| json!({
                    "mode": m.number, "solver_hz": m.solver_hz, "model_hz": m.model_hz, "relative": m.relative(), "mac": m.mac,
                })).collect::<Vec<_>>(),
                "notes": a.notes,
            })).collect::<Vec<_>>(),
        }));
    } else {
        let style = style(&std::io::stdout());
        let (verdict, tone) = if holds { ("the same model", Tone::Good) } else { ("not the same model", Tone::Bad) };
        let limits = format!("frequencies within {}, MAC from {MAC}, masses within 1e-5", number(args.tolerance));
        print(&format!("{}: {limits}\n", style.paint(tone, verdict)));
    }
    Ok(if holds { DONE } else { SHORT })
}

fn describe(title: &str, a: &Agreement) -> String {
    let mut out = format!("{title}\n");
    if let Some(mass) = &a.mass {
        masses(mass, &mut out);
    }
    if let (Some(solver), model) = a.n_rigid {
        let _ = writeln!(out, "rigid-body modes: {solver} of the solver, {model} of the model");
    }
    if !a.modes.is_empty() {
        let columns = [
            ("mode", Align::Right),
            ("solver Hz", Align::Right),
            ("model Hz", Align::Right),
            ("model/solver - 1", Align::Right),
            ("1 - MAC", Align::Right),
        ];
        let mut table = Table::new(columns);
        for m in &a.modes {
            table.row([
                m.number.to_string().into(),
                format!("{:.6}", m.solver_hz).into(),
                format!("{:.6}", m.model_hz).into(),
                format!("{:+.1e}", m.relative()).into(),
                m.mac.map_or_else(String::new, |v| format!("{:.1e}", (1.0 - v).max(0.0))).into(),
            ]);
        }
        out.push_str(&table.render(&style(&std::io::stdout())));
    }
    for note in &a.notes {
        let _ = writeln!(out, "note: {note}");
    }
    out.push('\n');
    out
}

/// Mass, centre of gravity from the reference, and inertia about it, in the units of the deck.
fn masses(m: &MassAgreement, out: &mut String) {
    let point = if m.reference == 0 { "the origin".to_string() } else { format!("GRID {}", m.reference) };
    let _ =
        writeln!(out, "masses about {point}, in the units of the deck (largest relative difference {:.1e})", m.worst);
    let both = |i: usize, j: usize, per: f64| [m.solver[i][j] / per, m.model[i][j] / per];
    let mass = [m.solver[0][0], m.model[0][0]];
    let centre = |i: usize, j: usize, sign: f64| [sign * m.solver[i][j] / mass[0], sign * m.model[i][j] / mass[1]];
    let rows = [
        ("mass", mass),
        ("cg x", centre(1, 5, 1.0)),
        ("cg y", centre(2, 3, 1.0)),
        ("cg z", centre(0, 4, 1.0)),
        ("Ixx", both(3, 3, 1.0)),
        ("Iyy", both(4, 4, 1.0)),
        ("Izz", both(5, 5, 1.0)),
        ("Ixy", both(3, 4, -1.0)),
        ("Ixz", both(3, 5, -1.0)),
        ("Iyz", both(4, 5, -1.0)),
    ];
    for (name, [solver, model]) in rows {
        let _ = writeln!(out, "  {name:<5} {solver:>14.6e} solver {model:>16.6e} model");
    }
}
