//! Several tests, each with the model in the configuration in which it was measured.

use super::super::build::{Case, assess_for_report, assess_paired, sentence, structure_of};
use super::super::data::{Live, ReportData, Structure};
use super::{NotLive, live, live_with};
use retune::data::TestData;
use retune::model::{Model, ParametricModel};
use retune::update::HowToPair;
use retune_diagnosis::{HypothesisResult, Learned};

/// Up to this many dofs a page is made live unasked: what that costs grows with them, and is some tenths of a second there.
const LIVE_UNASKED: usize = 400;
/// Bytes by which a page may grow unasked.
const LIGHT: usize = 1_000_000;

/// A model in the configuration of a test, and the test.
pub type Tested<'a> = (&'a Model, &'a TestData);

/// [`live`] of the test of a case and of others, one after the other, each with its reason where the page cannot compute it.
///
/// * `others` - further tests, each with the model in its configuration; the parameters are those of the case
pub fn live_tests<'a>(
    case: Case<'a>,
    others: &'a [Tested<'a>],
    how: &'a HowToPair,
    first: Option<&'a Model>,
    hypotheses: &'a [HypothesisResult],
) -> impl Iterator<Item = Result<Live, NotLive>> + 'a {
    let named = |mut live: Live, test: &TestData| {
        live.test_name.clone_from(&test.name);
        live.configuration.clone_from(&test.configuration);
        live
    };
    let beside = move |&(model, test): &Tested<'_>| {
        let same = model.parameters().names().eq(case.model.parameters().names());
        let theta = if same { case.assessment.theta.clone() } else { model.parameters().nominal() };
        let assessment = assess_paired(model, &theta, test, how)?;
        let found = live_with(Case { model, test, assessment: &assessment }, how, first, (case.model, hypotheses))?;
        Ok(Live { structure: Some(drawn(structure_of(model, &theta, test)?)), ..named(found, test) })
    };
    let own = move || Ok(named(live(case, how, first, hypotheses)?, case.test));
    std::iter::once_with(own).chain(others.iter().map(beside))
}

/// What the page draws of a structure that moves; what its elements are made of stands in the structure of the report.
fn drawn(mut structure: Structure) -> Structure {
    structure.property_sets.clear();
    for e in &mut structure.elements {
        e.properties.clear();
        e.parameters.clear();
        e.property_set = None;
        e.z_axis = None;
    }
    structure
}

/// Fills [`ReportData::live`] with [`live_tests`] as a page has them unasked: of models that are small, as many as stay light, where nothing
/// hinders. Where there are none, [`Meta::not_live`](super::super::data::Meta::not_live) says why.
pub fn add_live(
    data: &mut ReportData,
    case: Case<'_>,
    others: &[Tested<'_>],
    how: &HowToPair,
    first: Option<&Model>,
    hypotheses: &[HypothesisResult],
) {
    let n_dof = case.model.dof_map().n_dof();
    if n_dof > LIVE_UNASKED {
        data.meta.not_live = Some(format!(
            "It has {n_dof} dofs, and a page computes unasked with at most {LIVE_UNASKED}; `retune report --live` asks for it."
        ));
        return;
    }
    let few = others.iter().take_while(|(model, _)| model.dof_map().n_dof() <= LIVE_UNASKED).count();
    let mut room = LIGHT;
    for found in live_tests(case, &others[..few], how, first, hypotheses) {
        let size = |live: &Live| serde_json::to_string(live).map_or(usize::MAX, |text| text.len());
        match found.map(|live| (room.checked_sub(size(&live)), live)) {
            Ok((Some(left), live)) => {
                room = left;
                data.live.push(live);
            }
            Ok((None, _)) => {
                let why =
                    "It would make this page heavier by more than a megabyte; `retune report --live` asks for it.";
                data.meta.not_live = Some(why.into());
                break;
            }
            Err(why) => data.meta.not_live = Some(sentence(&why.to_string())),
        }
    }
    if !data.live.is_empty() {
        data.meta.not_live = None;
    }
}

/// [`add_live`] of what learning has found: the last model against the corrected tests of its configuration, the sliders marked
/// where the first model was.
///
/// * `cases` - the tests as they were given, each with the model in its configuration
pub fn add_live_of_learning(data: &mut ReportData, cases: &[Tested<'_>], learned: &Learned) {
    let (Some(last), Some(&(before, given))) = (learned.steps.last(), cases.first()) else { return };
    let corrected = |k: usize, test| learned.tests.get(k).unwrap_or(test);
    let test = corrected(0, given);
    let Ok(assessment) = assess_for_report(&last.model, &last.theta, test) else { return };
    let others: Vec<Tested<'_>> = cases
        .iter()
        .enumerate()
        .skip(1)
        .filter(|(_, (_, t))| t.configuration == given.configuration)
        .map(|(k, (_, t))| (&last.model, corrected(k, t)))
        .collect();
    let case = Case { model: &last.model, test, assessment: &assessment };
    add_live(data, case, &others, &HowToPair::default(), Some(before), &last.diagnosis.hypotheses);
}
