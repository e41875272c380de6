//! `retune report`

use crate::args::Report;
use crate::output::{Failure, print, warn};
use crate::{DONE, files};
use retune::correlation::{PairBy, PairingOptions};
use retune::data::TestData;
use retune::model::{Model, ParametricModel};
use retune::objective::Comparison;
use retune::report::data::{FileRecord, ReportData};
use retune::report::{Case, figures, html, json, of_comparison, paraview, steps};
use retune::update::{Assessment, assess};
use std::path::Path;

pub(crate) fn run(args: &Report) -> Result<u8, Failure> {
    for output in args.output.iter().chain(&args.json) {
        files::check_output(output, args.force)?;
    }
    let (test, test_warnings, test_text) = files::test(&args.test)?;
    let configuration = test.configuration.as_deref();
    let (model, warnings, text) = files::tested_model(&args.model, None, (&test, &args.test, &test_text))?;
    warn(&args.model, &text, &warnings);
    warn(&args.test, &test_text, &test_warnings);
    let assessment = compare(&model, &test)?;
    let mut data = of_comparison(Case { model: &model, test: &test, assessment: &assessment })?;
    if !args.history.is_empty() {
        let mut versions: Vec<(String, Assessment)> = Vec::new();
        for path in &args.history {
            let (earlier, ..) = files::model(path, configuration)?;
            versions.push((name(path), compare(&earlier, &test)?));
        }
        versions.push((name(&args.model), assessment));
        let list: Vec<(&str, &Assessment)> = versions.iter().map(|(n, a)| (n.as_str(), a)).collect();
        data.steps = Some(steps(&list, &test));
    }
    let record = |role: &str, path: &Path| FileRecord {
        role: role.into(),
        path: path.display().to_string(),
        sha256: String::new(),
    };
    data.meta.files = vec![record("model", &args.model), record("test", &args.test)];
    data.meta.commands = vec![std::env::args().collect::<Vec<_>>().join(" ")];
    data.meta.warnings = warnings.iter().chain(&test_warnings).map(|p| p.message.clone()).collect();
    write(args, &data)?;
    Ok(DONE)
}

fn write(args: &Report, data: &ReportData) -> Result<(), Failure> {
    if let Some(path) = &args.output {
        files::write(path, &html(data)?)?;
        print(&format!("written: {}\n", path.display()));
    }
    if let Some(path) = &args.json {
        files::write(path, &json(data)?)?;
        print(&format!("written: {}\n", path.display()));
    }
    if let Some(folder) = &args.svg {
        let list: Vec<(String, String)> =
            figures(data).into_iter().map(|f| (format!("{}.svg", f.name), f.svg)).collect();
        folder_of(folder, &list, args.force)?;
    }
    if let Some(folder) = &args.vtk {
        let list: Vec<(String, String)> = paraview(data)?.into_iter().map(|f| (f.name, f.content)).collect();
        folder_of(folder, &list, args.force)?;
    }
    Ok(())
}

fn folder_of(folder: &Path, list: &[(String, String)], force: bool) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|e| Failure::text(format!("cannot make {}: {e}", folder.display())))?;
    for (name, _) in list {
        files::check_output(&folder.join(name), force)?;
    }
    for (name, text) in list {
        files::write(&folder.join(name), text)?;
    }
    print(&format!("written: {} files in {}\n", list.len(), folder.display()));
    Ok(())
}

fn compare(model: &Model, test: &TestData) -> Result<Assessment, Failure> {
    let has_shapes = test.modes.iter().any(|m| m.shape.is_some());
    let by = if has_shapes { PairBy::Mac } else { PairBy::Order };
    let comparison = Comparison::new(model, test, PairingOptions { by, ..PairingOptions::default() })?;
    Ok(assess(&comparison, &model.parameters().nominal())?)
}

fn name(path: &Path) -> String {
    path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned())
}
