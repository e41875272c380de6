//! `retune check`

use crate::args::Check;
use crate::output::{Failure, print, print_json, render_problems, style, tell, totals};
use crate::{DONE, WRONG_INPUT, files};
use retune::model::{MassProperties, ParametricModel, Registry, Soundness, lint, load_configuration};
use retune::report::text::number;
use retune::yaml::{Problem, Severity};
use serde_json::json;
use std::fmt::Write as _;

pub(crate) fn run(args: &Check) -> Result<u8, Failure> {
    let text = files::read(&args.model)?;
    let (model, warnings, map) = match load_configuration(&text, args.configuration.as_deref(), &Registry::builtin()) {
        Ok(loaded) => loaded,
        Err(problems) if args.json => {
            print_json(&json!({
                "ok": false,
                "errors": list(&problems, Severity::Error),
                "warnings": list(&problems, Severity::Warning),
                "mass_kg": null, "cg_m": null, "inertia_kg_m2": null, "n_dof": null, "n_rigid_body_modes": null,
            }));
            return Ok(WRONG_INPUT);
        }
        Err(problems) => return Err(Failure::problems(&args.model, &text, &problems)),
    };
    let sound = lint(&model)?;
    let mut problems = warnings;
    problems.extend(map.place(sound.warnings.clone()));
    problems.extend(map.place(sound.errors.clone()));
    let mass = model.mass_properties(&model.parameters().nominal())?;
    let ok = sound.errors.is_empty();
    if args.json {
        print_json(&json!({
            "ok": ok,
            "errors": list(&problems, Severity::Error),
            "warnings": list(&problems, Severity::Warning),
            "mass_kg": mass.map(|m| m.mass),
            "cg_m": mass.map(|m| m.cg),
            "inertia_kg_m2": mass.map(|m| m.inertia),
            "n_dof": model.dof_map().n_dof(),
            "n_rigid_body_modes": sound.n_rigid_body_modes,
            "n_mechanisms": sound.n_mechanisms,
        }));
    } else {
        print(&describe(&model, mass.as_ref(), &sound));
        if !problems.is_empty() {
            tell(&format!("\n{}", render_problems(&args.model, &text, &problems).trim_end()));
        }
        let n_warnings = problems.iter().filter(|p| p.severity == Severity::Warning).count();
        let style = style(&std::io::stdout());
        let verdict = if ok { "sound" } else { "not usable" };
        let tone = if ok { retune::report::text::Tone::Good } else { retune::report::text::Tone::Bad };
        print(&format!("\n{}: {}\n", style.paint(tone, verdict), totals(sound.errors.len(), n_warnings)));
    }
    Ok(if ok { DONE } else { WRONG_INPUT })
}

fn list(problems: &[Problem], severity: Severity) -> Vec<serde_json::Value> {
    problems
        .iter()
        .filter(|p| p.severity == severity)
        .map(|p| {
            json!({
                "path": p.path,
                "line": p.location.map(|l| l.line),
                "column": p.location.map(|l| l.column),
                "message": p.message,
            })
        })
        .collect()
}

fn describe(model: &retune::model::Model, mass: Option<&MassProperties>, sound: &Soundness) -> String {
    let mut out = String::new();
    let spec = model.spec();
    let parameters = model.parameters();
    let _ = writeln!(out, "{}", spec.name);
    let _ = writeln!(
        out,
        "  {} nodes, {} elements, {} dofs, {} parameters ({} with bounds)",
        model.geometry().names.len(),
        model.elements().len(),
        model.dof_map().n_dof(),
        parameters.len(),
        parameters.free().len()
    );
    let mechanisms = match sound.n_mechanisms {
        0 => String::new(),
        n => format!(", {n} mechanisms"),
    };
    let _ = writeln!(out, "  {} rigid-body modes{mechanisms}", sound.n_rigid_body_modes);
    if let Some(m) = mass {
        let _ = writeln!(out, "  mass     {} kg", number(m.mass));
        let [x, y, z] = m.cg.map(|c| number(if c.abs() < 1e-12 { 0.0 } else { c }));
        let _ = writeln!(out, "  cg       {x}, {y}, {z} m");
        let i = m.inertia;
        let _ = writeln!(
            out,
            "  inertia  xx {}, yy {}, zz {} kg m2 about the cg",
            number(i[0][0]),
            number(i[1][1]),
            number(i[2][2])
        );
    }
    out
}
