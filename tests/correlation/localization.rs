//! A stiffness loss of 20 % in one member is found wherever the test can see it; a right model shows nothing.
//!
//! Tests are synthetic: 1 % of shape noise (of the largest entry), 0.2 % of frequency noise.

use super::*;
use retune::objective::{Comparison, starting_point};
use retune::update::{Places, PlacesOptions, assess, member_stiffnesses, places};

const NOISE: (f64, f64) = (0.002, 0.01);
const SEEDS: u64 = 10;

/// The model with a member at 80 % of its stiffness; `None` where it has no modulus that an override may scale.
fn damaged(base: &Model, member: &str) -> Option<Model> {
    ["{E: 0.8, G: 0.8}", "{EIy: 0.8, GJ: 0.8}", "{EIy: 0.8}", "{E: 0.8}"].iter().find_map(|scale| {
        let spec = base.spec().overlaid(&format!("overrides: {{{member}: {{scale: {scale}}}}}")).ok()?;
        Some(Model::new(spec, &Registry::builtin()).ok()?.0)
    })
}

fn localized(base: &Model, test: &TestData, relative_error: f64) -> Places {
    let comparison = Comparison::new(base, test, OPEN).unwrap();
    let a = assess(&comparison, &starting_point(base)).unwrap();
    places(base, &comparison, &a, PlacesOptions { relative_error }).unwrap()
}

/// Of ten seeds: in how many the member is first or second, in how many anything stands out.
fn tally(base: &Model, truth: &Model, member: &str, sensors: &[Sensor], n_modes: usize, error: f64) -> (usize, usize) {
    let mut count = (0, 0);
    for seed in 0..SEEDS {
        let found = localized(base, &twin(truth, sensors, n_modes, NOISE, seed), error).by_element;
        count.0 += usize::from(found.places.iter().position(|p| p.name == member).is_some_and(|rank| rank < 2));
        count.1 += usize::from(found.stands_out(0.01));
    }
    count
}

/// Runs one structure: every member in turn, and none.
fn structure(file: &str, n_modes: usize, errors: &[f64], must_all_be_seen: bool) {
    let base = model(file);
    let sensors = sensors(file, &base);
    let members = member_stiffnesses(&base, &starting_point(&base)).unwrap();
    for &error in errors {
        let silent = (0..SEEDS).filter(|&s| {
            !localized(&base, &twin(&base, &sensors, n_modes, NOISE, s), error).by_element.stands_out(0.01)
        });
        let silent = silent.count();
        eprintln!("{file} ({} dofs), expansion for {error}: silent in {silent} of 10 without an error", n_dof(&base));
        assert!(silent >= 9, "{file}: silent in {silent} of 10");
        for member in members.iter().map(|m| m.name.as_str()) {
            let Some(truth) = damaged(&base, member) else { continue };
            let (hits, seen) = tally(&base, &truth, member, &sensors, n_modes, error);
            eprintln!("  {member}: first or second in {hits}, stands out in {seen}");
            // What these sensors and modes do not show cannot be placed.
            let is_visible = must_all_be_seen || seen >= 8;
            assert!(!is_visible || (hits >= 8 && seen >= 8), "{file} {member}: {hits} hits, stands out in {seen}");
        }
    }
}

#[test]
fn every_wing_member_of_the_flagship() {
    structure("bff_truth.yaml", 6, &[PlacesOptions::default().relative_error], true);
}

#[test]
fn every_member_of_the_frame() {
    structure("frame.yaml", 6, &[PlacesOptions::default().relative_error], true);
}

/// The weight of the expansion follows from the relative error it is set to show; a factor of three up or down does as
/// well on structures that it was not derived from, one of them with close modes and members that no mode strains.
#[test]
fn the_derived_weight_serves_other_structures_and_is_not_sharp() {
    if !slow() {
        eprintln!("skipped: RETUNE_SLOW=1 runs other structures and weights");
        return structure("bff.yaml", 6, &[0.1], true);
    }
    for file in ["bff.yaml", "two_storey_frame.yaml", "cantilever.yaml"] {
        structure(file, 6, &[0.03, 0.1, 0.3], true);
    }
    structure("garteur.yaml", 9, &[0.1], false);
}

/// A single change is estimated with its size: -20 % within three standard deviations and what the linearisation leaves,
/// a tenth of the change.
#[test]
fn the_size_of_the_loss_is_told() {
    let base = model("frame.yaml");
    let sensors = sensors("frame.yaml", &base);
    let truth = damaged(&base, "girder.2").unwrap();
    let found = localized(&base, &twin(&truth, &sensors, 6, NOISE, 4), 0.1);
    let best = &found.changes_by_element.changes[0];
    assert_eq!(best.name, "girder.2");
    assert!((best.change + 0.2).abs() < 3.0 * best.sd + 0.02, "{best:?}");
    assert!(best.share > 0.5 && found.changes_by_element.p_family < 1e-6, "{best:?}");
}
