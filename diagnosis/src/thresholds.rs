//! Levels, odds and limits on which a diagnosis decides, each with its source or its derivation, or with the word that it is perturbed:
//! `benches/diagnosis_constants.py` halves and doubles all of these together, and `docs/laboratory/diagnosis.md` has what that changes.
//!
//! How much is tried stands in [`effort`](super::effort); what depends on rounding alone, beside its use.

/// ln of the Bayes factor that is called strong. Source: R. E. Kass, A. E. Raftery, Bayes factors, 1995: 20 to 1.
pub(crate) const STRONG: f64 = 3.0;

/// Level of the test by which more is looked for: a fit leaves noise if noise alone gives as much with at least this probability. A search that
/// is begun in vain costs time alone.
pub(crate) const REMAINDER: f64 = 0.01;

/// Level of each of the three tests of a verdict (goodness of fit, neighbours, second screening): the smallest that [`DRAWS`] can show,
/// exceeded by noise in one of 300 right answers. A right answer that is refused costs the user the answer; what is named wrongly hardly ever
/// passes at this level either.
pub(crate) const EACH_REMAINDER: f64 = 0.001;

/// ln of the odds that a test misses a mode that its sensors see well, among those that it lists: one of twenty. Perturbed.
pub(crate) const LN_MISSED: f64 = -3.0;

/// Largest mass-normalised motion at a sensor of a mode that is seen well, as a share of the median of the modes that are paired: a force at
/// such a sensor makes a tenth of their response, its square. Perturbed.
pub(crate) const SEEN_WELL: f64 = 0.3;

/// Estimated relative error of a frequency of a stand-in: a tenth of what a good test can measure.
pub(crate) const STAND_IN_ERROR: f64 = 1e-4;

/// A prior without a stated standard deviation: this share of the interval, so that the bounds are two of them apart.
pub(crate) const WEAK_PRIOR: f64 = 0.5;

/// Of Φ, relative: a tenth of a unit of ln evidence is far below what any decision rests on, and Φ is below 10⁶.
pub(crate) const FIT_TOLERANCE: f64 = 1e-7;

/// A parameter nearer to its bound than this share of the interval sits on it: rounding of a projected step.
pub(crate) const ON_BOUND: f64 = 1e-6;

/// The small step of a difference, as a share of the typical size: about the cube root of rounding.
pub(crate) const SMALL_STEP: f64 = 0.01;

/// Relative change of a frequency, and 1 - MAC of a shape, below which slopes of another fit serve: they change as much as the modes do.
pub(crate) const NEAR: f64 = 0.05;

/// Below this length of the projected change of the residual, in standard deviations, a hypothesis has no trace in the data: of an effect at
/// its typical size, of a fault at its number. A tenth of a standard deviation gives 0.005 in ln B. Perturbed.
pub(crate) const VISIBLE: f64 = 0.1;

/// Two traces with a larger cosine can hardly be told apart: a trace of ten standard deviations differs by two. Perturbed.
pub(crate) const ALIKE: f64 = 0.98;

/// ln of the odds of a wider place against one of the file: one in twenty, so that the simpler stands where the data do not ask for more.
/// Perturbed.
pub(crate) const LN_WIDER: f64 = -3.0;

/// A channel stands out above so many times the median of the channels; of Gaussian noise over ten modes one in eighty does. Perturbed.
pub(crate) const STANDS_OUT: f64 = 1.5;

/// Fewest sensors among which one can stand out: with three, the median is one of its neighbours.
pub(crate) const FEWEST_CHANNELS: usize = 4;

/// Draws of the null distributions: p-values of 0.01 with a standard error of 0.003.
pub(crate) const DRAWS: usize = 1000;

/// Level of the test that scatter is even over modes and channels: the usual one. What fails it is taken at the stated noise.
pub(crate) const EVEN: f64 = 0.05;

/// Level of the test that scatter is larger than stated: the usual one.
pub(crate) const EXCESS: f64 = 0.05;

/// Below this score a fault is not worth a fit: two standard deviations, squared. Perturbed.
pub(crate) const FAINT: f64 = 4.0;

/// A basin is lower by this in Φ, one in ln evidence.
pub(crate) const LOWER: f64 = 1.0;

/// And by this share of what the best hypothesis brings: a basin that brings less is one more wrong one. Perturbed.
pub(crate) const LOWER_SHARE: f64 = 0.5;

/// Degrees of freedom that the other data must have where a frequency is taken out, but for rounding: one is tested.
pub(crate) const OTHERS_TELL: f64 = 0.9;

/// MAC above which a mode is one of the model, two sensors left out: two shapes that agree less are called different in practice. Perturbed.
pub(crate) const IS_A_MODE: f64 = 0.8;

/// Sensors that one fault can spoil: an exchange takes two.
pub(crate) const SPOILED: usize = 2;

/// Share of a shape that a change at a few dofs explains, above what as many random columns would: the parameters still move. Of a random shape
/// of 12 entries six columns explain as much once in a thousand. Perturbed.
pub(crate) const EXPLAINS: f64 = 0.9;

/// MAC of a mode that a change of many parts may make into this one: its sizes are a few. Perturbed.
pub(crate) const ALIKE_SHAPE: f64 = 0.8;

/// Rows that must be left where a shape is put together from columns: with fewer, anything is put together.
pub(crate) const LEFT_ROWS: usize = 4;

/// A change of many parts is tried at a few sizes, between which a frequency moves by less than this in its logarithm. Perturbed.
pub(crate) const NEAR_FREQUENCY: f64 = 0.4;

/// Noise that is larger than this many times the stated one is not an explanation: then the stated noise or the model is wrong. One standard
/// deviation of its prior.
pub(crate) const MOST_NOISE: f64 = 2.0;

/// The share of what noise does not explain that an addition has to take away where a change of many parts explains the test as well: then the
/// best of the catalogue may be the first of several, and only the end of the way tells. Of three equal causes the first takes a third.
pub(crate) const WORTH_A_TRY: f64 = 1.0 / 3.0;

/// τ of a change of every part: a prior that is even in ln τ, from what tolerances of manufacture scatter to what is hardly a model any more.
pub(crate) const SPREAD_SCALES: [f64; 3] = [0.05, 0.15, 0.45];

/// Bounds of its factors: beyond them a part is another part.
pub(crate) const SPREAD_FACTOR: [f64; 2] = [0.1, 4.0];

/// 90 % of a Gaussian lie within this many standard deviations.
pub(crate) const NINETY: f64 = 1.6449;

/// Above this the probability that nothing is missing is told beside what is named: one in twenty, as usual.
pub(crate) const DOUBT: f64 = 0.05;

/// Share of frequencies that are noted wrongly: with the shape of a mode of the model that is a fault of the measurement and no foreign mode.
/// Perturbed.
pub(crate) const MISREAD: f64 = 0.01;

/// What explains all modes leaves a misfit that noise exceeds in this share of tests, or more: the level of [`EACH_REMAINDER`].
pub(crate) const BY_CHANCE: f64 = 1e-3;
