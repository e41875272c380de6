//! A comparison against a criteria profile.

use super::{Orthogonality, pairs_with_shapes, shape_sd, test_mode_name};
use crate::correlation::{
    CriteriaError, CriteriaProfile, Evidence, Judgement, PairEvidence, ProbabilityOf, find_profile, parse_profiles,
    probability_of_cross_orthogonality, probability_of_frequency, probability_of_mac,
};
use crate::objective::Comparison;
use crate::update::{AssessedPair, Assessment};

/// Samples behind the probability of a MAC or cross-orthogonality: a standard error of at most 0.011.
const SAMPLES: usize = 2000;

/// The profile that a user asks for: a name among the built-in ones, or the text of a file with profiles.
///
/// * `file` - text of the user's file; its only profile when `name` is `None`
///
/// Errors: the file is not a list of profiles, or the name is none of those there are.
pub fn load_profile(file: Option<&str>, name: Option<&str>) -> Result<CriteriaProfile, CriteriaError> {
    let own = file.map(parse_profiles).transpose()?.unwrap_or_default();
    match (name, own.as_slice()) {
        (Some(name), _) => find_profile(name, &own),
        (None, [only]) => Ok(only.clone()),
        (None, several) => Err(CriteriaError::Several {
            known: several.iter().map(|p| p.name.as_str()).collect::<Vec<_>>().join(", "),
        }),
    }
}

/// The probability that the cross-orthogonality of a pair reaches a mark, at the sensors and in the mass of `o`.
fn of_cross_orthogonality(
    comparison: &Comparison<'_>,
    a: &Assessment,
    p: &AssessedPair,
    o: &Orthogonality,
) -> ProbabilityOf {
    let at = |column: &[f64]| -> Vec<f64> { o.sensors.iter().map(|&i| column[i]).collect() };
    let model = at(a.prediction.at_sensors.column(p.model_mode).as_slice());
    let measured = at(comparison.shapes().column(p.test_mode).as_slice());
    let (sd, mass, seed) = (at(&shape_sd(comparison, p.test_mode)), o.mass.clone(), p.test_mode as u64);
    Box::new(move |mark| probability_of_cross_orthogonality(&model, &measured, &sd, &mass, mark, SAMPLES, seed))
}

/// Judges a comparison by a profile.
///
/// Every test mode is a target: one without a partner fails. The probability of passing takes the standard deviations of
/// measured frequencies and shapes; the model is taken as it is.
///
/// * `orthogonality` - from [`super::orthogonality`], when there is one
pub fn judge(
    comparison: &Comparison<'_>,
    a: &Assessment,
    orthogonality: Option<&Orthogonality>,
    profile: &CriteriaProfile,
) -> Judgement {
    let test = comparison.test();
    let pairs = a
        .pairs
        .iter()
        .map(|p| {
            let f = test.modes[p.test_mode].frequency_hz;
            let model_hz = p.model_hz;
            let mut evidence = PairEvidence {
                name: test_mode_name(comparison, p.test_mode),
                frequency_error: (p.model_hz - p.test_hz) / p.test_hz,
                mac: p.mac,
                cross_orthogonality_probability: orthogonality
                    .filter(|o| o.of_pair(p.test_mode).is_some())
                    .map(|o| of_cross_orthogonality(comparison, a, p, o)),
                cross_orthogonality: orthogonality.and_then(|o| o.of_pair(p.test_mode)).map(f64::abs),
                frequency_probability: Some(Box::new(move |tolerance| {
                    probability_of_frequency((model_hz, 0.0), (f.value, f.sd), tolerance)
                })),
                ..PairEvidence::default()
            };
            if p.mac.is_some() {
                let model: Vec<f64> = a.prediction.at_sensors.column(p.model_mode).iter().copied().collect();
                let measured: Vec<f64> = comparison.shapes().column(p.test_mode).iter().copied().collect();
                let (sd, seed) = (shape_sd(comparison, p.test_mode), p.test_mode as u64);
                evidence.mac_probability =
                    Some(Box::new(move |mark| probability_of_mac(&model, &measured, &sd, mark, SAMPLES, seed)));
            }
            evidence
        })
        .collect();
    let with_shapes = pairs_with_shapes(a);
    let off_pairs = with_shapes.iter().flat_map(|p| with_shapes.iter().map(move |q| (p.model_mode, q.test_mode)));
    let is_pair = |at: &(usize, usize)| with_shapes.iter().any(|p| (p.model_mode, p.test_mode) == *at);
    let mac_off_diagonal = off_pairs.filter(|at| !is_pair(at)).map(|at| a.mac[at]).reduce(f64::max);
    profile.judge(&Evidence {
        pairs,
        unpaired: a.unpaired_test.iter().map(|u| test_mode_name(comparison, u.mode)).collect(),
        mac_off_diagonal: if with_shapes.is_empty() { None } else { Some(mac_off_diagonal.unwrap_or(0.0)) },
        cross_orthogonality_off_diagonal: orthogonality.map(Orthogonality::cross_off_diagonal),
        auto_orthogonality_off_diagonal: orthogonality.map(Orthogonality::auto_off_diagonal),
    })
}
