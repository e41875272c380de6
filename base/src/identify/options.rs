//! What an identification is asked for, and what it puts aside.

use super::poles::ResidualTerms;
use super::scan::LEAST_CONTRIBUTION;
use super::stabilisation::Stability;

/// How lines are weighted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Weighting {
    /// By the variance that the coherence implies, where the set has coherences; else equally.
    #[default]
    Coherence,
    /// All lines of a channel alike.
    Equal,
}

/// Into which pieces the band is cut; each is identified on its own with the others' modes as residual terms.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Segments {
    /// Octaves from the top of the band, as long as each has at least 128 lines: every piece then has its own noise level
    /// and a model order that fits it, and a strong mode at 700 Hz does not hide a weak one at 13 Hz.
    #[default]
    Octaves,
    /// The band in one piece.
    Whole,
    /// Cuts at these frequencies, Hz.
    At(Vec<f64>),
}

/// Settings of [`identify`](super::identify).
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifyOptions {
    /// Limits of the band, Hz; all lines when absent.
    pub band_hz: Option<(f64, f64)>,
    /// Pieces of the band.
    pub segments: Segments,
    /// Poles of the highest model order of each piece, conjugates counted: at least twice the modes in it, four times is good.
    pub max_order: usize,
    /// The rules of the stabilisation diagram.
    pub stability: Stability,
    /// Terms for modes outside each piece; chosen by an information criterion when absent.
    pub residual_terms: Option<ResidualTerms>,
    /// Weights of the lines.
    pub weighting: Weighting,
    /// Least share of the power at its own resonance that a mode without a stable column stands for, 0 to 1.
    pub least_contribution: f64,
}

impl Default for IdentifyOptions {
    fn default() -> Self {
        Self {
            band_hz: None,
            segments: Segments::default(),
            max_order: 40,
            stability: Stability::default(),
            residual_terms: None,
            weighting: Weighting::default(),
            least_contribution: LEAST_CONTRIBUTION,
        }
    }
}

/// A stable column that is not a mode after all.
#[derive(Debug, Clone, PartialEq)]
pub struct Discarded {
    /// Where, Hz.
    pub frequency_hz: f64,
    /// Damping ratio.
    pub damping_ratio: f64,
    /// Why.
    pub reason: &'static str,
}
