//! What a hypothesis leaves: is it noise?

use super::hypothesis::Refit;
use super::run::stage_with;
use crate::error::DiagnosisError;
use crate::problem::evidence::goodness_of_fit;
use crate::problem::fit::{Fit, project};
use crate::problem::scene::Scene;
use crate::screen::noise::whiteness;
use crate::screen::stage::Stage;
use crate::settings::Settings;
use crate::thresholds::EACH_REMAINDER;
use retune::fault::Tests;
use retune::linalg::DMatrix;

/// What the tests say of what remains.
pub(crate) struct Remainder {
    pub(crate) passes: bool,
    /// Whether all but the second screening pass.
    pub(crate) looks_like_noise: bool,
    /// Whether all modes have partners and the misfit is below the median of what noise gives.
    pub(crate) is_small: bool,
    pub(crate) p_value: f64,
    pub(crate) text: String,
}

impl Remainder {
    /// What is smaller than the stated noise needs no explanation, though a third effect may still be seen in it.
    pub(crate) fn needs_nothing_more(&self) -> bool {
        self.passes || self.is_small
    }
}

/// Whether a remainder looks like noise. Below the median of what noise alone gives, how neighbours go together says nothing:
/// what is smaller than the stated noise needs no explanation.
pub(crate) fn is_noise(fits: f64, white: f64, level: f64) -> bool {
    fits > 0.5 || (fits > level && white > level)
}

/// Screens again with a hypothesis in the base.
pub(crate) fn remains(base: &Stage, r: &Refit, settings: &Settings) -> Result<(Remainder, Stage), DiagnosisError> {
    let second = stage_with(base, r, settings)?;
    let fits = goodness_of_fit(&second.fit, &second.q);
    let white = whiteness(&second.scene, &second.fit, &second.q, settings.seed.wrapping_add(2));
    let looks_like_noise = is_noise(fits, white, EACH_REMAINDER) && second.fit.unpaired.is_empty();
    let passes = looks_like_noise && second.p_value > EACH_REMAINDER;
    // The smallest of three.
    let p_value =
        if second.fit.unpaired.is_empty() { (3.0 * fits.min(white).min(second.p_value)).min(1.0) } else { 0.0 };
    let text = if passes { String::new() } else { place_of(&second.scene, &second.fit, &second.q) };
    let is_small = fits > 0.5 && second.fit.unpaired.is_empty();
    Ok((Remainder { passes, looks_like_noise, is_small, p_value, text }, second))
}

/// The modes and sensors that carry the most of a projected residual.
pub(crate) fn place_of(scene: &Scene, fit: &Fit, q: &DMatrix<f64>) -> String {
    let r = project(q, &fit.r);
    let rows = fit.rows;
    let mut modes: Vec<(f64, usize)> = (0..rows.n_modes)
        .map(|m| (fit.mode_rows(m).iter().map(|&i| r[i] * r[i]).sum::<f64>() / fit.mode_rows(m).len() as f64, m))
        .collect();
    modes.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let words: Vec<String> = modes.iter().take(3).map(|(v, m)| format!("{} ({v:.1})", scene.mode(*m))).collect();
    let mut statics: Vec<(f64, &str)> = fit.statics.iter().map(|s| (r[s.row] * r[s.row], s.name.as_str())).collect();
    statics.sort_by(|a, b| b.0.total_cmp(&a.0));
    let words: Vec<String> =
        words.into_iter().chain(statics.iter().take(3).map(|(v, name)| format!("{name} ({v:.1})"))).collect();
    let mut out = format!("the residual (mean square) is largest in {}", words.join(", "));
    if rows.has_shapes {
        let mut sensors: Vec<(f64, usize)> = (0..rows.n_sensors)
            .map(|s| ((0..rows.n_modes).map(|m| r[rows.shape(m, s)].powi(2)).sum::<f64>() / rows.n_modes as f64, s))
            .collect();
        sensors.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let words: Vec<String> =
            sensors.iter().take(4).map(|(v, s)| format!("{} ({v:.1})", scene.test.sensors[*s].name)).collect();
        out += &format!(" and at the sensors {}", words.join(", "));
    }
    if !fit.unpaired.is_empty() {
        let modes: Vec<String> = fit.unpaired.iter().map(|&m| scene.mode(m)).collect();
        let verb = if modes.len() == 1 { "has" } else { "have" };
        out += &format!("; {} {verb} no partner in the model", modes.join(", "));
    }
    out
}
