//! Poles, diagrams and modes of an identification, and the shapes at the sensors.

use super::super::data::{
    DataItem, Diagram, Floats, Identification, IdentifiedMode, Level, Meta, Modes, Named, Rejected, ReportData, Sensor,
    Structure, TestMode, Verdict,
};
use retune::catalogue::{Choice, counted};
use retune::data::{FrfQuantity, FrfSet, Place, TestData};
use retune::identify::health::Level as Severity;
use retune::identify::{DiagramPole, IdentifyError, Segment, StabilisationDiagram, cmif, complexity};
use retune::update::{Identified, Way};

/// Lines of the indicator function on the page.
const MOST_LINES: usize = 4000;
/// Singular values that are shown.
const MOST_VALUES: usize = 6;
/// Phase collinearity below which a shape is called complex.
const COMPLEX: f64 = 0.9;
/// Inflation of standard deviations above which the remainder is called coloured.
const COLOURED: f64 = 3.0;

/// The report of an identification from frequency responses; `None` of one that has no poles: of held modes and of peaks of spectra.
///
/// # Errors
/// The functions have no indicator function.
pub fn of_identification(found: &Identified) -> Result<Option<ReportData>, IdentifyError> {
    let Way::Functions { frfs, identification, method, .. } = &found.way else { return Ok(None) };
    let indicator = cmif(frfs)?;
    let step = indicator.frequencies_hz.len().div_ceil(MOST_LINES).max(1);
    let curve = |k: usize| Floats::from_f64(indicator.values.column(k).iter().step_by(step).copied());
    let unit = match frfs.quantity {
        FrfQuantity::Receptance => "m/N",
        FrfQuantity::Mobility => "(m/s)/N",
        FrfQuantity::Accelerance => "(m/s²)/N",
    };
    let shown = Identification {
        method: method.word().into(),
        unit: unit.into(),
        frequency_hz: Floats::from_f64(indicator.frequencies_hz.iter().step_by(step).copied()),
        cmif: (0..indicator.values.ncols().min(MOST_VALUES)).map(curve).collect(),
        diagrams: identification.segments.iter().flat_map(diagrams).collect(),
        modes: identified_modes(found, &identification.modes),
    };
    let structure = sensors_alone(&found.test);
    let modes = Modes { test: test_modes(&found.test), ..Modes::default() };
    Ok(Some(ReportData {
        meta: meta(found, frfs, shown.diagrams.iter().map(|d| d.hz.len()).sum()),
        structure,
        modes,
        identification: Some(shown),
        ..ReportData::default()
    }))
}

fn identified_modes(found: &Identified, all: &[retune::identify::IdentifiedMode]) -> Vec<IdentifiedMode> {
    let mode = |(t, m): (&retune::data::TestMode, &retune::identify::IdentifiedMode)| {
        let mpc = t.shape.as_ref().map_or(m.complexity, complexity).mpc;
        let remarks = [
            (mpc < COMPLEX, "complex shape"),
            (m.sd_inflation > COLOURED, "the fit leaves more than noise"),
            (m.n_orders == 0, "in no stable column, found in what the others leave"),
        ];
        let said: Vec<&str> = remarks.iter().filter(|r| r.0).map(|r| r.1).collect();
        IdentifiedMode {
            hz: t.frequency_hz.value,
            hz_sd: t.frequency_hz.sd,
            damping: t.damping_ratio.map(|d| d.value),
            damping_sd: t.damping_ratio.map(|d| d.sd),
            mpc: mpc.is_finite().then_some(mpc),
            orders: m.n_orders,
            remark: said.join("; "),
        }
    };
    found.modes.iter().zip(all).map(mode).collect()
}

fn diagrams(segment: &Segment) -> Vec<Diagram> {
    let (from, to) = segment.core_hz;
    let name = format!("{from:.2} to {to:.2} Hz");
    let mut out: Vec<Diagram> = segment
        .diagrams
        .iter()
        .enumerate()
        .map(|(k, d)| diagram(d, if k == 0 { name.clone() } else { format!("{name}, remainder") }))
        .collect();
    let rejected = |d: &retune::identify::Discarded| Rejected {
        hz: d.frequency_hz,
        damping: d.damping_ratio,
        reason: d.reason.to_string(),
    };
    if let Some(first) = out.first_mut() {
        first.discarded = segment.discarded.iter().map(rejected).collect();
    }
    out
}

fn diagram(d: &StabilisationDiagram, name: String) -> Diagram {
    // In the order in which the marks are looked for: what is stable in participation alone is new.
    let mark = |p: &DiagramPole| match (p.is_frequency_stable, p.is_damping_stable, p.is_participation_stable) {
        (false, ..) => 0,
        (true, false, _) => 1,
        (true, true, false) => 2,
        (true, true, true) => 3,
    };
    Diagram {
        name,
        hz: Floats::from_f64(d.poles.iter().map(|p| p.pole.frequency_hz())),
        damping: Floats::from_f64(d.poles.iter().map(|p| p.pole.damping_ratio())),
        order: d.poles.iter().map(|p| p.order).collect(),
        mark: d.poles.iter().map(mark).collect(),
        column: d.poles.iter().map(|p| p.column).collect(),
        chosen: d.chosen.clone(),
        discarded: Vec::new(),
    }
}

/// The sensors of a test without a model, where all of them know where they are.
fn sensors_alone(test: &TestData) -> Option<Structure> {
    let sensor = |s: &retune::data::Sensor| {
        let (name, position) = match &s.place {
            Place::Node { node, position } => (node, position),
            Place::Element { element, position, .. } => (element, position),
        };
        Some(Sensor {
            name: s.name.clone(),
            position: (*position)?,
            direction: s.direction,
            is_rotation: s.is_rotation,
            attached_to: name.clone(),
        })
    };
    let sensors = test.sensors.iter().map(sensor).collect::<Option<Vec<_>>>()?;
    (!sensors.is_empty()).then(|| Structure { up: Some(2), sensors, ..Structure::default() })
}

fn test_modes(test: &TestData) -> Vec<TestMode> {
    let mode = |(i, m): (usize, &retune::data::TestMode)| super::test_mode(m, super::test_label(test, i));
    test.modes.iter().enumerate().map(mode).collect()
}

fn meta(found: &Identified, frfs: &FrfSet, poles: usize) -> Meta {
    let n = found.modes.len();
    let range = match (found.modes.first(), found.modes.last()) {
        (Some(a), Some(b)) if n > 1 => {
            format!(" from {:.2} to {:.2} Hz", a.frequency_hz.value, b.frequency_hz.value)
        }
        (Some(a), _) => format!(" at {:.2} Hz", a.frequency_hz.value),
        _ => String::new(),
    };
    let sentence = if n == 0 {
        "No mode was found; the diagram shows why.".to_string()
    } else {
        format!("The functions hold {}{range}.", counted(n, "mode"))
    };
    let origin = if found.is_synthetic { "synthetic" } else { "measured" };
    let source = found.test.modes.first().map_or_else(String::new, |m| {
        let (retune::data::Origin::Measured(text) | retune::data::Origin::Synthetic(text)) = &m.origin;
        text.clone()
    });
    Meta {
        tests: vec![super::test_record(&found.test)],
        title: found.test.name.clone(),
        subtitle: format!(
            "identified from functions: {} by {} on {}",
            counted(frfs.responses.len(), "response"),
            counted(frfs.references.len(), "reference"),
            counted(frfs.n_lines(), "line")
        ),
        verdict: Some(Verdict {
            sentence,
            number: n.to_string(),
            number_label: format!("modes, chosen from {} of all orders", counted(poles, "pole")),
            level: if n == 0 { Level::Bad } else { Level::Neutral },
        }),
        versions: vec![Named::new("retune", env!("CARGO_PKG_VERSION"))],
        data_items: vec![DataItem { name: "frequency responses".into(), origin: origin.into(), source }],
        warnings: found
            .findings
            .iter()
            .filter(|f| f.level != Severity::Info)
            .map(|f| format!("{}. {}", f.text, f.remedy))
            .collect(),
        ..Meta::default()
    }
}
