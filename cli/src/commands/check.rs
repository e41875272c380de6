//! `retune check`

use crate::args::Check;
use crate::output::{Failure, print, problems_json, render_problems, style, tell, totals};
use crate::{DONE, WRONG_INPUT, files};
use retune::catalogue::counted;
use retune::element::{Axes, Dof};
use retune::model::{MassProperties, Model, ParametricModel, PlacedElement, Soundness, lint};
use retune::yaml::Severity;
use retune_report::text::{Tone, number, printable};
use serde_json::json;
use std::fmt::Write as _;

pub(crate) fn run(args: &Check) -> Result<u8, Failure> {
    args.answer.check()?;
    let text = files::read(&args.model.path)?;
    if let Some(answer) = super::check_others::answer(args, &text) {
        return answer;
    }
    let (model, warnings, map) = match files::load(&args.model.path, &text, args.model.configuration()) {
        Ok(loaded) => loaded,
        Err(problems) if args.answer.json => {
            args.answer.give(&json!({
                "ok": false,
                "errors": problems_json(&problems, Severity::Error),
                "warnings": problems_json(&problems, Severity::Warning),
                "mass_kg": null, "mass_by_axis_kg": null, "cg_m": null, "inertia_kg_m2": null, "n_dof": null, "n_rigid_body_modes": null, "axes": null,
            }));
            return Ok(WRONG_INPUT);
        }
        Err(problems) => return Err(Failure::problems(&args.model.path, &text, &problems)),
    };
    let sound = lint(&model)?;
    let mut problems = warnings;
    problems.extend(map.place(sound.warnings.clone()));
    problems.extend(map.place(sound.errors.clone()));
    let theta = model.parameters().nominal();
    let mass = model.mass_properties(&theta)?;
    let by_axis = if mass.is_none() { Some(model.rigid_mass(&theta)?) } else { None };
    let by_axis = by_axis.map(|rigid| [0, 1, 2].map(|i| rigid.get(i, i)));
    let ok = sound.errors.is_empty();
    if !args.against.is_empty() {
        // Grids that nothing holds are the solver's too.
        if !ok {
            let wrong: Vec<_> = problems.iter().filter(|p| p.severity == Severity::Error).cloned().collect();
            tell(&format!("{}\n", render_problems(&args.model.path, &text, &wrong).trim_end()));
        }
        return super::against::run(args, &model);
    }
    if args.answer.needs_json() {
        args.answer.give(&json!({
            "ok": ok,
            "errors": problems_json(&problems, Severity::Error),
            "warnings": problems_json(&problems, Severity::Warning),
            "mass_kg": mass.map(|m| m.mass),
            "mass_by_axis_kg": by_axis,
            "cg_m": mass.map(|m| m.cg),
            "inertia_kg_m2": mass.map(|m| m.inertia),
            "n_dof": model.dof_map().n_dof(),
            "n_rigid_body_modes": sound.n_rigid_body_modes,
            "n_mechanisms": sound.n_mechanisms,
            "buckling_factor": sound.buckling_factor,
            "mesh_errors": sound.mesh_errors.iter().map(|e| json!({
                "elastic_mode": e.mode + 1 - sound.n_rigid_body_modes,
                "relative": e.relative,
                "part": e.part,
            })).collect::<Vec<_>>(),
            "free_edges": sound.free_edges.iter().map(|f| json!({
                "part": f.part,
                "n_edges": f.n_edges,
                "n_lines": f.n_lines,
                "length_m": f.length,
                "n_tied": f.n_tied,
            })).collect::<Vec<_>>(),
            "axes": axes(&model).map(|e| json!({
                "element": e.name,
                "x": e.axes[0],
                "y": e.axes[1],
                "z": e.axes[2],
                "is_default": e.orientation.is_none(),
            })).collect::<Vec<_>>(),
        }));
    }
    if !args.answer.json {
        print(&describe(&model, mass.as_ref(), by_axis, &sound));
        if !problems.is_empty() {
            tell(&format!("\n{}", render_problems(&args.model.path, &text, &problems).trim_end()));
        }
        let n_warnings = problems.iter().filter(|p| p.severity == Severity::Warning).count();
        let style = style(&std::io::stdout());
        let (verdict, tone) = match (sound.errors.len(), n_warnings) {
            (0, 0) => ("sound", Tone::Good),
            (0, _) => ("usable, with doubts", Tone::Warning),
            _ => ("not usable", Tone::Bad),
        };
        print(&format!("\n{}: {}\n", style.paint(tone, verdict), totals(sound.errors.len(), n_warnings)));
    }
    Ok(if ok { DONE } else { WRONG_INPUT })
}

fn describe(model: &Model, mass: Option<&MassProperties>, by_axis: Option<[f64; 3]>, sound: &Soundness) -> String {
    let mut out = String::new();
    let spec = model.spec();
    let parameters = model.parameters();
    let _ = writeln!(out, "{}", printable(&spec.name));
    let _ = writeln!(
        out,
        "  {}, {}, {}, {} ({} with bounds)",
        counted(model.geometry().names.len(), "node"),
        counted(model.elements().len(), "element"),
        counted(model.dof_map().n_dof(), "dof"),
        counted(parameters.len(), "parameter"),
        parameters.free().len()
    );
    let mechanisms = match sound.n_mechanisms {
        0 => String::new(),
        n => format!(", {n} mechanisms"),
    };
    let _ = writeln!(out, "  {} rigid-body modes{mechanisms}", sound.n_rigid_body_modes);
    if let Some(mesh) = &spec.mesh {
        let of = |name: &String| counted(model.element_set(name).map_or(0, <[usize]>::len), "element");
        let parts: Vec<String> = mesh.parts.keys().map(|name| format!("`{}` {}", printable(name), of(name))).collect();
        let _ = writeln!(out, "  mesh     {}: {}", printable(&mesh.file), parts.join(", "));
        let patches = model.patches().len();
        if patches > 0 {
            let _ = writeln!(out, "           {} for effects", counted(patches, "patch"));
        }
    }
    for (i, f) in sound.free_edges.iter().enumerate() {
        let head = if i == 0 { "edges" } else { "" };
        let tied = if f.n_tied > 0 { format!(", {} of them tied", f.n_tied) } else { String::new() };
        let lines = counted(f.n_lines, "line");
        let many = match f.n_edges {
            0 => "no free edges: others join it all around, or its skin is closed".to_string(),
            n => format!("{} in {lines}, {} m{tied}", counted(n, "free edge"), number(f.length)),
        };
        let _ = writeln!(out, "  {head:<8} `{}` {many}", printable(&f.part));
    }
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
    if let Some(by_axis) = by_axis {
        let [x, y, z] = by_axis.map(number);
        let _ = writeln!(
            out,
            "  mass     {x} kg along x, {y} kg along y, {z} kg along z: it differs by axis, so that it has no centre of gravity"
        );
    }
    if !sound.mesh_errors.is_empty() {
        let each: Vec<String> = sound.mesh_errors.iter().map(|e| format!("{:+.2} %", 100.0 * e.relative)).collect();
        let _ = writeln!(out, "  errors   of the first frequencies by the mesh, estimated: {}", each.join(", "));
    }
    if let Some(factor) = sound.buckling_factor {
        let _ = writeln!(out, "  preload  it buckles at {} times its preload", number(factor));
    }
    describe_axes(model, &mut out);
    out
}

/// Elements whose section has a direction.
fn axes(model: &Model) -> impl Iterator<Item = &PlacedElement> {
    let bends = |e: &PlacedElement| e.kind.nodes().iter().flat_map(|n| n.iter()).any(|d| *d == Dof::Ry);
    model.elements().iter().filter(move |e| e.kind.axes() == Axes::AlongNodes && bends(e))
}

/// How the sections of the members lie: members of one direction on one line.
fn describe_axes(model: &Model, out: &mut String) {
    const LINES: usize = 12;
    let mut lines: Vec<(String, Vec<&str>)> = Vec::new();
    for e in axes(model) {
        let entry = e.path.split_once('.').map_or(e.path.as_str(), |(_, name)| name);
        let how = if e.orientation.is_some() { "stated" } else { "default" };
        let turned = if e.turn == 0.0 {
            String::new()
        } else {
            format!(", turned by {:.1} degrees to principal axes", e.turn.to_degrees())
        };
        let text = format!("z of the section {} ({how}{turned}), y {}", direction(e.axes[2]), direction(e.axes[1]));
        match lines.iter_mut().find(|l| l.0 == text) {
            Some((_, names)) if names.contains(&entry) => {}
            Some((_, names)) => names.push(entry),
            None => lines.push((text, vec![entry])),
        }
        if lines.len() > LINES {
            break;
        }
    }
    for (i, (text, names)) in lines.iter().take(LINES).enumerate() {
        let more = if names.len() > 4 { format!(" and {} more", names.len() - 4) } else { String::new() };
        let head = if i == 0 { "axes" } else { "" };
        let _ = writeln!(out, "  {head:<8} {text}: {}{more}", names[..names.len().min(4)].join(", "));
    }
    if lines.len() > LINES {
        let _ = writeln!(out, "           and more, all of them in --json");
    }
}

/// `+z`, or the components of a direction that is along no global axis.
fn direction(v: [f64; 3]) -> String {
    for (c, axis) in v.into_iter().zip(["x", "y", "z"]) {
        if c.abs() > 1.0 - 1e-9 {
            return format!("{}{axis}", if c > 0.0 { '+' } else { '-' });
        }
    }
    let [x, y, z] = v.map(|c| format!("{:.3}", if c.abs() < 5e-4 { 0.0 } else { c }));
    format!("[{x}, {y}, {z}]")
}
