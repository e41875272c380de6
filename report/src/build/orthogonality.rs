//! Orthogonality in the model's mass, in the report's terms.

use super::super::data::{Comparison, LabelledMatrix};
use super::{Case, test_label};
use retune::catalogue::{Choice, counted};
use retune::update::Orthogonality;

/// Orthogonality of the paired shapes as two matrices and a sentence.
pub(super) fn add_orthogonality(c: &mut Comparison, found: &Orthogonality, case: Case<'_>) {
    let Case { test, assessment, .. } = case;
    let of_test = |&i: &usize| format!("{} {:.2}", test_label(test, i), test.modes[i].frequency_hz.value);
    let partner = |&i: &usize| {
        let pair = assessment.pairs.iter().find(|p| p.test_mode == i);
        pair.map_or_else(String::new, |p| format!("{} {:.2}", p.model_label, p.model_hz))
    };
    let tests: Vec<String> = found.test_modes.iter().map(of_test).collect();
    let matrix = |title: &str, row_axis: &str, rows: Vec<String>, values: &[Vec<f64>]| LabelledMatrix {
        title: title.into(),
        row_axis: row_axis.into(),
        column_axis: "test".into(),
        rows,
        columns: tests.clone(),
        values: values.to_vec(),
    };
    let models: Vec<String> = found.test_modes.iter().map(partner).collect();
    c.cross_orthogonality = Some(matrix("Cross-orthogonality", "model", models, &found.cross));
    c.auto_orthogonality = Some(matrix("Orthogonality of the test", "test", tests.clone(), &found.auto));
    let left_out = match found.left_out.len() {
        0 => String::new(),
        n => format!(" {} that some shape lacks are left out.", counted(n, "sensor")),
    };
    c.orthogonality_note = format!(
        "Mass of the model at {}, reduction: {}; among the model's own shapes it leaves {:.3} off the diagonal.{left_out}",
        counted(found.sensors.len(), "sensor"),
        found.reduction.word(),
        found.own_error
    );
}
