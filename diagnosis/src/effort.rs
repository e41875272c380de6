//! How much a diagnosis tries: how many hypotheses are fitted, from how many starts, with how many steps.
//!
//! Halved and doubled, eighteen of these numbers together left every answer but for a fault (`docs/laboratory/diagnosis.md`, by
//! `benches/diagnosis_constants.py`). Times depend on them.

use serde::Serialize;

/// Declares the fields with their defaults.
macro_rules! effort {
    ($($(#[$doc:meta])* $field:ident: $default:literal,)*) => {
        /// How much a diagnosis tries.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
        pub struct Effort {
            $($(#[$doc])* pub(crate) $field: usize,)*
        }

        impl Default for Effort {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }

        impl Effort {
            /// All numbers times a factor, at least one each: half finds the same in most cases and takes half of the time.
            #[must_use]
            pub fn times(self, factor: f64) -> Self {
                Self { $($field: scaled(self.$field, factor),)* }
            }
        }
    };
}

fn scaled(number: usize, factor: f64) -> usize {
    (number as f64 * factor.max(0.0)).round().max(1.0) as usize
}

effort! {
    /// Effects that are fitted in full, at most, before one of each further kind with half the best score; half of them beside another hypothesis.
    best: 12,
    /// Effects that are fitted with a few steps where the best full fits leave more than noise.
    short_fits: 200,
    /// Faults of every kind that are fitted then.
    faults_of_a_kind: 4,
    /// Members of a kind of faults that are all fitted then.
    few_of_a_kind: 16,
    /// Faults that are fitted at first.
    best_faults: 4,
    /// Rounds of looking around the best effect.
    rounds: 3,
    /// Rounds of looking between the places of a mesh.
    finer_rounds: 8,
    /// Kinds of effects of which the best is looked about there.
    finer_kinds: 6,
    /// Hypotheses whose base is a start of a change of every part.
    spread_from: 3,
    /// Hypotheses that are fitted once more from other basins.
    polished: 3,
    /// Kinds of which the best is.
    polished_kinds: 6,
    /// Effects of every kind that are fitted where none leaves noise.
    of_every_kind: 2,
    /// Effects like the best, or around it, that are fitted with a few steps.
    near: 60,
    /// Starts of a full fit, after a look at all.
    starts: 4,
    /// First steps of a short fit; twice as many for an effect of two sizes, as the two below.
    short_first_steps: 2,
    /// From how many starts.
    short_starts: 2,
    /// Further steps, for the better half.
    short_further_steps: 4,
    /// Times that the base moves to a lower basin.
    moves: 2,
    /// Hypotheses whose base may lead to one; half as many points of the box.
    ways: 24,
    /// Rounds of re-weighting.
    robust_rounds: 4,
    /// Channels whose fits without them are kept.
    suspects: 4,
    /// Steps of a fit without a channel: enough to rank them.
    robust_steps: 8,
    /// Starts in the box beside the estimates.
    box_starts: 5,
    /// Candidates that a stage on top of another evaluates anew.
    anew: 80,
    /// And of every kind.
    anew_of_a_kind: 3,
    /// Factors of a property in a change of every part: a finer mesh is taken by its members.
    spread_parts: 60,
    /// Starts of its fit.
    spread_starts: 3,
    /// Steps after which the best goes on.
    spread_steps: 8,
    /// Columns of the screening that are paired: the best of them.
    pair_columns: 3000,
    /// Pairs that are fitted with a few steps.
    pair_short_fits: 40,
    /// In how many of them one effect may be.
    pairs_of_one: 6,
    /// Pairs that are fitted in full.
    pair_full_fits: 6,
    /// First steps of a pair.
    pair_first_steps: 3,
    /// Further steps, for the better half.
    pair_further_steps: 5,
    /// From how many starts.
    pair_starts: 2,
    /// Hypotheses of the base that are tried in the place of the first of a pair.
    rivals: 8,
    /// Times that the first is exchanged.
    exchanges: 2,
    /// Wider places around the best that are fitted in full.
    around: 9,
    /// Effects that are tried in all axes.
    with_all_axes: 12,
    /// Hypotheses of a chain, at most.
    chain: 5,
    /// Rounds of fitting the base with the number of a fault, then the number with the base.
    number_rounds: 4,
    /// Tied hypotheses that are checked for what they leave.
    checked: 3,
    /// Steps after which the best starts of a full fit are chosen.
    first_steps: 4,
    /// Hypotheses that a next measurement is to tell apart.
    compared: 5,
    /// Nodes at which one is sought: of more, every k-th.
    next_nodes: 600,
}
