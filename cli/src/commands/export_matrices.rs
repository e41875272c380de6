//! `retune export --matrices`

use crate::args::{Export, Reduction};
use crate::output::{Failure, print, shown, warn};
use crate::{DONE, WRONG_INPUT, files, writing};
use retune::catalogue::did_you_mean;
use retune::data::Place;
use retune::matrices::{MatrixFormat, write};
use retune::model::{ExportReduction, Model, ParametricModel, export_matrices};
use std::path::PathBuf;

pub(crate) fn run(args: &Export) -> Result<u8, Failure> {
    let (model, warnings, text) = files::model(&args.model, args.configuration.as_deref())?;
    warn(&args.model, &text, &warnings);
    let theta = model.parameters().nominal();
    let modes = usize::from(args.modes);
    let how = args.reduce.map(|how| match how {
        Reduction::Guyan => ExportReduction::Guyan,
        Reduction::Serep => ExportReduction::Serep(modes),
        Reduction::CraigBampton => ExportReduction::CraigBampton(modes),
    });
    let nodes = nodes(args, &model)?;
    let export = export_matrices(&model, &theta, how.map(|how| (nodes.as_slice(), how)))?;
    let stem = args.output.file_name().map(|n| n.to_string_lossy().into_owned());
    let Some(stem) = stem else { return Err(Failure::text("-o needs the first part of a file name, such as `wing`")) };
    let format = args.format;
    let mut all = write(&stem, &export.matrices, &export.dofs, format).map_err(Failure::text)?;
    if let Some(recovery) = &export.recovery {
        // Its columns and rows are of two tables.
        let format = if format == MatrixFormat::Npz { format } else { MatrixFormat::MatrixMarket };
        let own = write(&format!("{stem}_recovery"), std::slice::from_ref(recovery), &export.recovered, format);
        all.extend(own.map_err(Failure::text)?);
    }
    let folder = args.output.parent().map_or_else(PathBuf::new, PathBuf::from);
    for (name, _) in &all {
        writing::check_output(&folder.join(name), args.overwrite.force)?;
    }
    let mut is_whole = true;
    for (name, bytes) in &all {
        is_whole &= writing::write_bytes(&folder.join(name), bytes);
    }
    let names: Vec<String> = all.iter().map(|(name, _)| shown(&folder.join(name))).collect();
    print(&format!(
        "written: {}\n\nsuperelements:\n  part:{}\n",
        names.join(", "),
        entry(&stem, args, export.recovery.is_some(), export.matrices.len() > 2)
    ));
    Ok(if is_whole { DONE } else { WRONG_INPUT })
}

/// The entry of a model file that uses what was written.
fn entry(stem: &str, args: &Export, is_recovered: bool, is_damped: bool) -> String {
    let matrix = |name: &str| match args.format {
        MatrixFormat::MatrixMarket => format!("{stem}_{name}.mtx"),
        MatrixFormat::Npz => format!("{stem}_{name}.npz"),
        MatrixFormat::Output4 | MatrixFormat::Output4Binary => format!("{{file: {stem}.op4, matrix: {name}}}"),
        MatrixFormat::Dmig => format!("{{file: {stem}.pch, matrix: {name}}}"),
    };
    let mut out = format!("\n    k: {}\n    m: {}", matrix("K"), matrix("M"));
    if is_damped {
        out += &format!("\n    c: {}", matrix("C"));
    }
    if args.format != MatrixFormat::Dmig {
        out += &format!("\n    dofs: {stem}_dofs.csv");
    }
    if is_recovered {
        let extension = if args.format == MatrixFormat::Npz { "npz" } else { "mtx" };
        out += &format!("\n    recovery: {{matrix: {stem}_recovery_R.{extension}, dofs: {stem}_recovery_dofs.csv}}");
    }
    out
}

/// The nodes that stay.
fn nodes(args: &Export, model: &Model) -> Result<Vec<usize>, Failure> {
    let map = model.dof_map();
    let find = |name: &str| {
        map.node(name).ok_or_else(|| {
            let suggestion = did_you_mean(name, map.node_names().iter().map(String::as_str));
            Failure::text(format!("the model has no node `{name}`{suggestion}"))
        })
    };
    let mut nodes = Vec::new();
    for path in &args.test {
        let (test, warnings, text) = files::test(path)?;
        warn(path, &text, &warnings);
        let mut left_out = Vec::new();
        for sensor in &test.sensors {
            match &sensor.place {
                Place::Node { node, .. } => nodes.push(find(node)?),
                Place::Element { .. } => left_out.push(sensor.name.as_str()),
            }
        }
        if !left_out.is_empty() {
            note!("sensors that stand on elements are not nodes and are left out: {}", left_out.join(", "));
        }
    }
    for name in &args.at {
        nodes.push(find(name)?);
    }
    nodes.sort_unstable();
    nodes.dedup();
    if nodes.is_empty() && args.reduce.is_some() {
        return Err(Failure::text(
            "--reduce needs nodes that stay: `--at hub,tip`, or `--test test.yaml` for those of its sensors",
        ));
    }
    Ok(nodes)
}
