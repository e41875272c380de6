//! `retune map`

use super::measured::{read, refuse_answers};
use crate::args::Map;
use crate::output::{Failure, print, print_json, shown, style, warn};
use crate::{DONE, SHORT, files, writing};
use retune::catalogue::counted;
use retune::correlation::{Mapping, MappingOptions, PlaceKind, map_points, place_sensors};
use retune::data::{Place, write_test};
use retune::update::points_of;
use retune_report::text::{Align, Cell, Style, Table, Tone, number};
use serde_json::json;
use std::fmt::Write as _;

/// Largest tolerance, as a share of the size of the structure: beyond, most points would be at some node.
const WIDEST: f64 = 0.1;

pub(crate) fn run(args: &Map) -> Result<u8, Failure> {
    if let Some(output) = &args.output {
        writing::check_output(output, args.overwrite.force)?;
    }
    let options = MappingOptions { tolerance: args.tolerance, reach: args.reach };
    let (points, mut test) = if files::is_test(&args.test) {
        refuse_answers(&args.test, &args.measurement)?;
        let (test, warnings, text) = files::test(&args.test)?;
        warn(&args.test, &text, &warnings);
        (points_of(&test), Some(test))
    } else {
        let found = read(std::slice::from_ref(&args.test), &args.measurement)?;
        let geometry = found.geometry.ok_or_else(|| {
            Failure::text(format!("{} has no geometry: no nodes (datasets 15, 2411), no points", args.test.display()))
        })?;
        (geometry.points.into_iter().map(|p| (p.name, p.position_m)).collect(), None)
    };
    if points.is_empty() {
        return Err(Failure::text(
            "no sensor of the test has a position; identify with `--geometry`, or write `position:`",
        ));
    }
    let configuration =
        args.model.configuration.clone().or_else(|| test.as_ref().and_then(|t| t.configuration.clone()));
    let (model, warnings, text) = files::model(&args.model.path, configuration.as_deref())?;
    warn(&args.model.path, &text, &warnings);
    let size = model.geometry().size();
    if args.tolerance > WIDEST * size {
        return Err(Failure::text(format!(
            "--tolerance takes points within {} m of a node for the node, and the whole structure is {} m long; a number without a unit is in metres: `5 mm`",
            number(args.tolerance),
            number(size)
        )));
    }
    let mapping = map_points(&model, &points, options);
    if args.print.json {
        print_json(&json_of(&mapping));
    } else {
        print(&text_of(&mapping, options.tolerance, &style(&std::io::stdout())));
    }
    if let Some(output) = &args.output {
        let Some(test) = &mut test else {
            return Err(Failure::text("a geometry has no modes to write; give a test file"));
        };
        place_sensors(test, &mapping);
        if writing::write(output, &write_test(test)) && !args.print.json {
            print(&format!("\nwritten: {}\n", shown(output)));
        }
    }
    Ok(if mapping.points_left.is_empty() { DONE } else { SHORT })
}

fn place(place: &Place) -> String {
    match place {
        Place::Node { node, .. } => node.clone(),
        Place::Element { element, fraction, .. } => format!("{element} at {fraction:.3}"),
    }
}

fn text_of(mapping: &Mapping, tolerance: f64, style: &Style) -> String {
    let mut table = Table::new([
        ("point", Align::Left),
        ("x m", Align::Right),
        ("y m", Align::Right),
        ("z m", Align::Right),
        ("kind", Align::Left),
        ("place", Align::Left),
        ("arm mm", Align::Right),
    ]);
    for p in &mapping.points {
        let is_arm = matches!(p.kind, PlaceKind::ArmFromNode | PlaceKind::ArmFromElement);
        table.row([
            p.name.as_str().into(),
            format!("{:.4}", p.position[0]).into(),
            format!("{:.4}", p.position[1]).into(),
            format!("{:.4}", p.position[2]).into(),
            Cell::new(p.kind.word(), if is_arm { Tone::Warning } else { Tone::Plain }),
            place(&p.place).into(),
            format!("{:.1}", 1e3 * p.distance).into(),
        ]);
    }
    let mut out = table.render(style);
    out.push('\n');
    for p in &mapping.points_left {
        let near =
            p.nearest.as_deref().map_or_else(String::new, |n| format!("; nearest: {n}, {:.1} mm", 1e3 * p.distance));
        let _ = writeln!(out, "no place: point {}{near}", p.name);
    }
    for n in &mapping.nodes_left {
        let near = n
            .nearest
            .as_deref()
            .map_or_else(String::new, |p| format!("; nearest: point {p}, {:.1} mm", 1e3 * n.distance));
        let _ = writeln!(out, "not measured: node {}{near}", n.name);
    }
    let count = |kind: PlaceKind| mapping.points.iter().filter(|p| p.kind == kind).count();
    let _ = writeln!(
        out,
        "{} within {:.1} mm of a node, {} of an element, {} by rigid arms up to {:.0} mm, {} without place; {} not measured",
        counted(count(PlaceKind::OnNode), "point"),
        1e3 * tolerance,
        count(PlaceKind::OnElement),
        count(PlaceKind::ArmFromNode) + count(PlaceKind::ArmFromElement),
        1e3 * mapping.reach,
        mapping.points_left.len(),
        counted(mapping.nodes_left.len(), "node")
    );
    out
}

fn json_of(mapping: &Mapping) -> serde_json::Value {
    let left = |list: &[retune::correlation::Leftover]| {
        list.iter().map(|l| json!({"name": l.name, "nearest": l.nearest, "distance_m": l.distance})).collect::<Vec<_>>()
    };
    json!({
        "points": mapping.points.iter().map(|p| {
            let (node, element, fraction) = match &p.place {
                Place::Node { node, .. } => (Some(node), None, None),
                Place::Element { element, fraction, .. } => (None, Some(element), Some(fraction)),
            };
            json!({
                "name": p.name, "position_m": p.position, "kind": p.kind.word(), "node": node, "element": element,
                "fraction": fraction, "distance_m": p.distance,
            })
        }).collect::<Vec<_>>(),
        "points_without_place": left(&mapping.points_left),
        "nodes_not_measured": left(&mapping.nodes_left),
        "reach_m": mapping.reach,
    })
}
