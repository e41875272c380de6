//! `retune matrices`

use crate::args::Matrices;
use crate::output::{Failure, print, shown};
use crate::{DONE, files};
use retune::catalogue::counted;
use retune::matrices::{
    Contents, DofRow, File, Inspection, Matrix, RIGID, SymmetryError, inspect, read, reader_of, suspected_length,
};
use retune_report::text::number;
use serde_json::{Value, json};
use std::collections::{HashMap, HashSet};
use std::fmt::Write as _;
use std::path::PathBuf;

/// A file and what it holds.
struct Read {
    path: PathBuf,
    format: &'static str,
    contents: Contents,
}

/// A matrix with what is known of it.
struct Seen<'a> {
    file: &'a Read,
    matrix: &'a Matrix,
    dofs: Vec<DofRow>,
    found: Inspection,
}

pub(crate) fn run(args: &Matrices) -> Result<u8, Failure> {
    args.answer.check()?;
    let mut all = Vec::new();
    for path in args.files.iter().chain(&args.dofs).chain(&args.nodes) {
        let fail = |e: &dyn std::fmt::Display| Failure::text(format!("{}: {e}", shown(path)));
        let bytes = files::matrices(path).map_err(|e| fail(&e))?;
        let name = path.to_string_lossy().into_owned();
        let format = reader_of(&File { name: &name, bytes: &bytes }).map_err(|e| fail(&e))?.name();
        all.push(Read { path: path.clone(), format, contents: read(&name, &bytes).map_err(|e| fail(&e))? });
    }
    let mut positions: HashMap<&str, [f64; 3]> = HashMap::new();
    for file in &all {
        positions.extend(file.contents.positions.iter().map(|(n, p)| (n.as_str(), *p)));
        let of_dofs = file.contents.dofs.iter().filter_map(|r| Some((r.label.node.as_str(), r.position?)));
        positions.extend(of_dofs);
    }
    let turned: HashSet<&str> = all.iter().flat_map(|f| &f.contents.axes).map(|(n, _)| n.as_str()).collect();
    let table: &[DofRow] = all.iter().rev().map(|f| &f.contents.dofs[..]).find(|d| !d.is_empty()).unwrap_or(&[]);
    let dofs_of = |matrix: &Matrix| -> Vec<DofRow> {
        let placed = |row: &DofRow| DofRow {
            // Directions of its own are a frame of its own: rigid motions are not looked at.
            frame: row.frame.clone().or_else(|| turned.contains(row.label.node.as_str()).then(String::new)),
            position: row.position.or_else(|| positions.get(row.label.node.as_str()).copied()),
            label: row.label.clone(),
        };
        if matrix.rows.is_empty() {
            return table.iter().map(placed).collect();
        }
        let of = |label: &retune::matrices::Label| DofRow { label: label.clone(), position: None, frame: None };
        matrix.rows.iter().map(of).map(|r| placed(&r)).collect()
    };
    let mut seen = Vec::new();
    for file in &all {
        for matrix in &file.contents.matrices {
            let dofs = dofs_of(matrix);
            let found = inspect(matrix, &dofs);
            seen.push(Seen { file, matrix, dofs, found });
        }
    }
    let unit = unit(&seen);
    if args.answer.needs_json() {
        args.answer.give(&json!({
            "files": all.iter().map(file_json).collect::<Vec<_>>(),
            "matrices": seen.iter().map(matrix_json).collect::<Vec<_>>(),
            "suspected_unit_of_length": unit,
        }));
    }
    if args.answer.json {
        return Ok(DONE);
    }
    let mut out = String::new();
    for file in &all {
        let Contents { matrices, dofs, positions, notes, .. } = &file.contents;
        let mut holds = Vec::new();
        for (n, word) in [(matrices.len(), "matrix"), (dofs.len(), "dof"), (positions.len(), "position")] {
            if n > 0 {
                holds.push(if word == "matrix" && n > 1 { format!("{n} matrices") } else { counted(n, word) });
            }
        }
        let _ = writeln!(out, "{} ({}): {}", shown(&file.path), file.format, holds.join(", "));
        for note in notes {
            let _ = writeln!(out, "  note: {note}");
        }
        for s in seen.iter().filter(|s| std::ptr::eq(s.file, file)) {
            describe(s, &mut out);
        }
    }
    match unit {
        Some(unit) => {
            let _ = writeln!(
                out,
                "lengths are in {unit}, if this is metal: waves would run through it about as fast as they do"
            );
        }
        None if seen.iter().any(|s| s.found.rigid.is_some()) => {
            let _ = writeln!(
                out,
                "no unit of length is suspected: it would need a stiffness, a mass and positions that fit a metal"
            );
        }
        None => {
            let _ = writeln!(
                out,
                "without a table of dofs and positions nothing is known of rigid-body modes and units (--dofs, --nodes)"
            );
        }
    }
    print(&out);
    Ok(DONE)
}

fn describe(s: &Seen<'_>, out: &mut String) {
    let (m, found) = (s.matrix, &s.found);
    let filled = 100.0 * found.n_entries as f64 / (m.n_rows as f64 * m.n_columns as f64).max(1.0);
    let _ = writeln!(
        out,
        "  {}: {} x {}, {} ({} %)",
        m.name,
        m.n_rows,
        m.n_columns,
        entries(found.n_entries),
        number(filled)
    );
    match &found.symmetry {
        Ok(off) if *off > 0.0 => {
            let _ = writeln!(out, "    symmetric up to {off:.1e} of its largest entry");
        }
        Ok(_) => {
            let _ = writeln!(out, "    symmetric{}", if m.is_one_triangle { ", one triangle stored" } else { "" });
        }
        // Its size says that it is rectangular.
        Err(SymmetryError::NotSquare { .. }) => {}
        Err(e) => {
            let _ = writeln!(out, "    {e}");
        }
    }
    if let Some([negative, zero]) = found.inertia {
        let what = match (negative, zero) {
            (0, 0) => "positive definite".to_string(),
            (0, n) => format!("positive semidefinite: {n} eigenvalues are zero"),
            (n, z) => format!("indefinite: {n} eigenvalues are negative, {z} zero"),
        };
        let _ = writeln!(out, "    {what}");
    }
    if let Some(rigid) = found.rigid {
        let free = rigid.iter().filter(|r| **r < RIGID).count();
        if free > 0 {
            let _ = writeln!(out, "    {free} of 6 rigid-body motions cost nothing: a stiffness");
        } else if let Some(mass) = is_mass(found) {
            let _ = writeln!(out, "    a mass: {} in every direction, in its own unit", number(mass));
        } else {
            let _ = writeln!(out, "    no rigid-body motion is free in it");
        }
    }
    if !found.empty_rows.is_empty() {
        let name = |&i: &usize| s.dofs.get(i).map_or_else(|| format!("row {}", i + 1), |d| d.label.to_string());
        let names: Vec<String> = found.empty_rows.iter().take(4).map(name).collect();
        let more = if found.empty_rows.len() > 4 { ", ..." } else { "" };
        let _ =
            writeln!(out, "    {} without entries: {}{more}", counted(found.empty_rows.len(), "row"), names.join(", "));
    }
}

fn entries(n: usize) -> String {
    counted(n, "entry")
}

/// The mass that all three translations have, if they have one.
fn is_mass(found: &Inspection) -> Option<f64> {
    let t = found.translations?;
    let mean = t.iter().sum::<f64>() / 3.0;
    (mean > 0.0 && t.iter().all(|m| (m - mean).abs() < 1e-3 * mean)).then_some(mean)
}

/// The unit of length that a stiffness and a mass of one size suggest.
fn unit(seen: &[Seen<'_>]) -> Option<&'static str> {
    let is_stiffness = |s: &&Seen<'_>| s.found.rigid.is_some_and(|r| r.iter().any(|r| *r < RIGID));
    let mass = seen.iter().find(|s| is_mass(&s.found).is_some())?;
    let others = || seen.iter().filter(|s| s.matrix.n_rows == mass.matrix.n_rows && !std::ptr::eq(*s, mass));
    // Of a supported structure no rigid-body motion is free: then the one other matrix counts.
    let stiffness = others().find(is_stiffness).or_else(|| others().next().filter(|_| others().count() == 1))?;
    let (k, m) = (stiffness.matrix.symmetric(false).ok()?, mass.matrix.symmetric(false).ok()?);
    suspected_length(&k, &m, &mass.dofs)
}

fn file_json(file: &Read) -> Value {
    json!({
        "file": file.path.to_string_lossy(),
        "format": file.format,
        "n_matrices": file.contents.matrices.len(),
        "n_dofs": file.contents.dofs.len(),
        "n_positions": file.contents.positions.len(),
        "notes": file.contents.notes,
    })
}

fn matrix_json(s: &Seen<'_>) -> Value {
    json!({
        "file": s.file.path.to_string_lossy(),
        "name": s.matrix.name,
        "n_rows": s.matrix.n_rows,
        "n_columns": s.matrix.n_columns,
        "n_entries": s.found.n_entries,
        "is_symmetric": s.found.symmetry.is_ok(),
        "asymmetry": s.found.symmetry.as_ref().ok(),
        "n_negative": s.found.inertia.map(|i| i[0]),
        "n_zero": s.found.inertia.map(|i| i[1]),
        "rigid_residual": s.found.rigid,
        "translations": s.found.translations,
        "empty_rows": s.found.empty_rows.iter().map(|i| i + 1).collect::<Vec<_>>(),
    })
}
