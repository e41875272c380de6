//! Reports for tests of the page: a flying wing, a large grid, hostile names, and reports with parts missing.

mod large;
pub(crate) mod learned;
pub(crate) mod wing;

use super::data::{Meta, Named, ReportData, Verdict};
use super::{figures, html, json, paraview};
use std::path::PathBuf;

/// Where the pages are written, for the tests in a browser.
fn folder() -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../target"), PathBuf::from);
    target.join("report_fixture")
}

fn model_only() -> ReportData {
    let mut data = wing::report();
    let structure = data.structure.as_mut().unwrap();
    structure.sensors.clear();
    structure.exciters.clear();
    structure.trace_lines.clear();
    structure.fields.retain(|f| f.on == super::data::Carrier::Elements && f.name.starts_with("strain"));
    data.modes.test.clear();
    for mode in &mut data.modes.model {
        mode.at_sensors = None;
    }
    let meta = Meta {
        title: "Flying wing, the model alone".into(),
        versions: vec![Named::new("retune", "0.1.0")],
        ..Meta::default()
    };
    ReportData { structure: data.structure, modes: data.modes, meta, ..ReportData::default() }
}

fn model_and_test() -> ReportData {
    let mut data = wing::report();
    let comparison = data.comparison.as_mut().unwrap();
    comparison.pairs_before.clear();
    comparison.mac_before = None;
    comparison.comac_before = None;
    data.meta.verdict = Some(Verdict {
        sentence: "The model does not explain the test: 5 of 6 modes miss the criteria.".into(),
        number: "1 of 6".into(),
        number_label: "modes that meet the criteria".into(),
        level: super::data::Level::Bad,
    });
    ReportData { update: None, steps: None, diagnosis: None, frfs: None, ..data }
}

/// The wing with markup and very long words for names.
fn hostile() -> ReportData {
    let attack = "<img src=x onerror=\"window.hacked=1\"><b>bold</b></script><script>window.hacked=1</script>";
    let long = "a_very_long_name_without_any_place_to_break_it_that_somebody_generated_from_another_program";
    let mut data = wing::report();
    data.meta.title = format!("{attack} {long}");
    data.meta.subtitle = format!("javascript:window.hacked=1 {attack}");
    data.meta.verdict.as_mut().unwrap().sentence = format!("{attack} {long}");
    let structure = data.structure.as_mut().unwrap();
    for node in &mut structure.nodes {
        node.name = format!("{attack}{}", node.name);
    }
    for element in &mut structure.elements {
        element.name = format!("{long}{}", element.name);
        element.group = attack.into();
    }
    structure.sensors[3].name = format!("<a href='javascript:window.hacked=1'>{long}</a>");
    for field in &mut structure.fields {
        field.name = format!("{attack}{}", field.name);
    }
    data.modes.test[0].label = attack.into();
    let comparison = data.comparison.as_mut().unwrap();
    comparison.pairs[0].label = attack.into();
    comparison.pairs[1].label = long.into();
    for matrix in [&mut comparison.mac, &mut comparison.mac_before].into_iter().flatten() {
        matrix.rows[0] = attack.into();
        matrix.columns[1] = long.into();
    }
    for channel in &mut data.frfs.as_mut().unwrap().channels {
        channel.response = format!("{attack}{}", channel.response);
    }
    let update = data.update.as_mut().unwrap();
    update.parameters[0].name = attack.into();
    update.parameters[1].name = long.into();
    update.histories[0].name = attack.into();
    let steps = data.steps.as_mut().unwrap();
    steps.steps[1].name = attack.into();
    steps.steps[2].name = long.into();
    let diagnosis = data.diagnosis.as_mut().unwrap();
    diagnosis.hypotheses[0].kind = attack.into();
    diagnosis.hypotheses[1].place.text = long.into();
    diagnosis.hypotheses[0].patch = attack.into();
    data
}

#[test]
fn fixture_pages_are_written() {
    let folder = folder();
    std::fs::create_dir_all(&folder).unwrap();
    let reports = vec![
        ("wing", wing::report()),
        ("model_only", model_only()),
        ("model_and_test", model_and_test()),
        ("hostile", hostile()),
        ("large", large::report()),
        ("mesh", large::mesh()),
        ("channels", large::channels()),
        ("learned", learned::report()),
        ("empty", ReportData::default()),
    ];
    for (name, data) in reports {
        let page = html(&data).unwrap();
        assert!(page.len() < 12_000_000, "{name}: {} bytes", page.len());
        std::fs::write(folder.join(format!("{name}.html")), page).unwrap();
    }
    std::fs::write(folder.join("wing.json"), json(&wing::report()).unwrap()).unwrap();
    let text = super::text::summary(&wing::report(), &super::text::Style::default());
    std::fs::write(folder.join("wing.txt"), text).unwrap();
    for figure in figures(&wing::report()) {
        std::fs::write(folder.join(format!("{}.svg", figure.name)), figure.svg).unwrap();
    }
    for file in paraview(&wing::report()).unwrap() {
        std::fs::write(folder.join(file.name), file.content).unwrap();
    }
}
