//! Pairing of analytical with experimental modes: an optimal assignment with gates, never a greedy choice.
//!
//! A pair is allowed when its MAC, its frequency ratio and its symmetry families pass their gates; among all one-to-one
//! pairings of allowed pairs the one with the largest total MAC is taken. What remains unpaired is listed with its best
//! candidate, order inversions are listed as swaps. Two close modes may be rotated in their common plane: no pairing is
//! right then, and [`super::assess_close_modes`] compares the planes instead.

use super::{ShapeScalar, assignment::assign, mac_matrix, weighted_mac_matrix};
use crate::linalg::DMatrix;

/// What is known of a set of modes besides their shapes. An empty slice means "not known for any mode".
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ModeList<'a> {
    /// Natural frequencies, Hz, in any order; NaN when not known (then the frequency gate is open).
    pub frequencies_hz: &'a [f64],
    /// Names such as "S1B", for [`PairBy::Label`].
    pub labels: &'a [Option<String>],
    /// Symmetry classes such as "symmetric" and "antisymmetric"; `None` is compatible with every class.
    pub families: &'a [Option<String>],
}

impl ModeList<'_> {
    fn label(&self, i: usize) -> Option<&str> {
        self.labels.get(i).and_then(Option::as_deref)
    }

    fn family(&self, i: usize) -> Option<&str> {
        self.families.get(i).and_then(Option::as_deref)
    }

    fn frequency(&self, i: usize) -> f64 {
        self.frequencies_hz.get(i).copied().unwrap_or(f64::NAN)
    }

    /// Modes by ascending frequency, unknown ones last, ties in file order.
    fn by_frequency(&self, count: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by(|&i, &j| self.frequency(i).total_cmp(&self.frequency(j)));
        order
    }
}

/// The rule that pairs modes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PairBy {
    /// Optimal assignment on MAC, with the gates.
    #[default]
    Mac,
    /// The same on MAC times how near the frequencies are: one within an octave, exp(-2 o²) with o octaves beyond it; where shapes
    /// hardly differ, by the frequencies alone. For fits, which open the gates: few sensors see two modes alike, 10 Hz are not 80 Hz,
    /// and the noise of the shapes must not pair 6.6 with 6.7 Hz crosswise.
    NearMac,
    /// The k-th lowest analytical with the k-th lowest experimental mode; inside each family when families are gated, and
    /// modes of unknown family with what is left.
    /// The MAC and frequency gates only flag. Finds a perfect fit of a wrong model when two modes have swapped.
    Order,
    /// Equal labels, the first of equal ones. The MAC and frequency gates only flag.
    Label,
}

crate::catalogue::choice! { PairBy, "rule of pairing";
    Mac "mac" "Optimal assignment on MAC alone",
    NearMac "near-mac" "On MAC times how near the frequencies are, beyond an octave",
    Order "order" "By order of frequency, within symmetry classes where labels tell them",
    Label "label" "By equal labels of test and model modes",
}

/// Rule and gates of a pairing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairingOptions {
    /// The rule.
    pub by: PairBy,
    /// Smallest MAC of an allowed pair; a pair of MAC zero is never allowed by [`PairBy::Mac`] and [`PairBy::NearMac`].
    pub min_mac: f64,
    /// g of the relative frequency window: f_a/f_x within [1/(1+g), 1+g]; infinite for no gate.
    pub frequency_window: f64,
    /// Whether modes of two different known families may not be paired; otherwise such a pair is flagged.
    pub same_family_only: bool,
}

impl Default for PairingOptions {
    /// By MAC, at least 0.3, frequencies within a factor of 1.5, families kept apart.
    ///
    /// 0.3 lets a bad but unmistakable partner be seen and judged; criteria profiles decide whether it is good enough.
    fn default() -> Self {
        Self { by: PairBy::Mac, min_mac: 0.3, frequency_window: 0.5, same_family_only: true }
    }
}

/// What is settled about a measured mode before the rule pairs the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Plan {
    /// Nothing: the rule pairs it.
    #[default]
    Free,
    /// It has no partner.
    Aside,
    /// Its partner is this mode of the model.
    Fixed(usize),
    /// Its partner is the mode of this number, by frequency from 0, among those of its family that no rule has taken: a mode without a
    /// shape beside others with shapes, or one whose place in the order is known.
    Ranked(usize),
}

/// What is odd about a pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PairFlag {
    /// The MAC is below the gate.
    LowMac,
    /// The frequencies are outside the window.
    FarFrequency,
    /// The modes belong to different symmetry families.
    DifferentFamily,
    /// Another mode on either side has a MAC within 0.1 of this one: close modes or spatial aliasing.
    Ambiguous,
}

/// An analytical mode and its experimental partner.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ModePair {
    /// Index of the analytical mode.
    pub analytical: usize,
    /// Index of the experimental mode.
    pub experimental: usize,
    /// Their MAC.
    pub mac: f64,
    /// (f_a - f_x)/f_x: plus means that the model is too high. NaN when a frequency is unknown.
    pub frequency_error: f64,
    /// What is odd about it, in the order of the enum.
    pub flags: Vec<PairFlag>,
}

/// A mode without a partner.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Unpaired {
    /// Its index in its own set.
    pub index: usize,
    /// The mode of the other set with the largest MAC, paired or not, and that MAC.
    pub best: Option<(usize, f64)>,
}

/// Result of a pairing.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct PairedModes {
    /// Pairs, by ascending experimental frequency.
    pub pairs: Vec<ModePair>,
    /// Analytical modes without a partner, by index.
    pub unpaired_analytical: Vec<Unpaired>,
    /// Experimental modes without a partner, by index.
    pub unpaired_experimental: Vec<Unpaired>,
    /// Pairs of `pairs` (by position) whose frequency order is opposite in model and test.
    pub swapped: Vec<(usize, usize)>,
}

/// Another mode this close in MAC makes a pair ambiguous.
const AMBIGUITY: f64 = 0.1;

/// Weight of frequency closeness against MAC: breaks exact ties only, since MAC has about 1e-15 of rounding noise.
pub(super) const TIE_BREAK: f64 = 1e-9;

/// How near two frequencies are, in (0, 1], for [`PairBy::NearMac`]; one where they are not known.
pub(super) fn nearness(low: f64, high: f64) -> f64 {
    let beyond = (high / low).log2() - 1.0;
    // Far is still better than none.
    if beyond > 0.0 { (-2.0 * beyond * beyond).exp().max(1e-6) } else { 1.0 }
}

/// MAC that shapes may cost together for [`PairBy::NearMac`] to follow the frequencies: noise of a few percent of the largest entry moves
/// the MAC of two nearly equal shapes by as much.
const SAME_SHAPE: f64 = 0.01;

/// Exchanges the partners of pairs whose order of frequencies is opposite in model and test, where that costs less than
/// [`SAME_SHAPE`]: such shapes do not tell which is which.
///
/// * `pairs` - (analytical, experimental), by ascending experimental frequency
/// * `analytical` - frequencies
/// * `weight` - of a pair; zero where it is not allowed
pub(super) fn uncross(
    pairs: &mut [(usize, usize)],
    analytical: impl Fn(usize) -> f64,
    weight: impl Fn(usize, usize) -> f64,
) {
    // Every exchange leaves fewer pairs in opposite order, so there is an end.
    let mut is_done = false;
    while !is_done {
        is_done = true;
        for p in 1..pairs.len() {
            for q in 0..p {
                let ((a, x), (b, y)) = (pairs[q], pairs[p]);
                let crosswise = (weight(b, x), weight(a, y));
                let is_allowed = crosswise.0 > 0.0 && crosswise.1 > 0.0;
                if is_allowed
                    && analytical(a) > analytical(b)
                    && crosswise.0 + crosswise.1 > weight(a, x) + weight(b, y) - SAME_SHAPE
                {
                    (pairs[q].0, pairs[p].0) = (b, a);
                    is_done = false;
                }
            }
        }
    }
}

/// Pairs analytical with experimental modes.
///
/// ```text
/// max Σ MAC[i, j(i)]   over one-to-one pairings with
///     MAC[i,j] ≥ min_mac,   max(f_a, f_x) ≤ (1 + g) min(f_a, f_x),   same family
/// ```
///
/// * `mac` - modal assurance criterion or any other likeness in [0, 1], (n_a x n_x), finite; see [`mac_matrix`]
/// * `analytical`, `experimental` - frequencies, labels and families of the n_a and n_x modes
///
/// The result does not depend on the order of the modes, unless two modes tie in MAC and in frequency.
/// With [`PairBy::Order`] and [`PairBy::Label`] a doubtful pair is kept and flagged; by MAC it is not made.
///
/// # Source
/// Assignment: see the module `assignment`. Gates and ordering: common practice, e.g. R. J. Allemang, The modal
/// assurance criterion: twenty years of use and abuse, Sound and Vibration, August 2003.
pub fn pair_modes(
    mac: &DMatrix<f64>,
    analytical: &ModeList<'_>,
    experimental: &ModeList<'_>,
    options: &PairingOptions,
) -> PairedModes {
    pair_planned_modes(mac, analytical, experimental, options, &[])
}

/// The same where something is settled about some of the measured modes.
///
/// * `plans` - of every measured mode; empty where nothing is settled
pub fn pair_planned_modes(
    mac: &DMatrix<f64>,
    analytical: &ModeList<'_>,
    experimental: &ModeList<'_>,
    options: &PairingOptions,
    plans: &[Plan],
) -> PairedModes {
    pair_alike_modes(mac, mac, analytical, experimental, options, plans)
}

/// The same where more than the shapes at the sensors tells which mode is which.
///
/// * `likeness` - what the rules by MAC go by in its place, in [0, 1], (n_a x n_x), finite
pub fn pair_alike_modes(
    mac: &DMatrix<f64>,
    likeness: &DMatrix<f64>,
    analytical: &ModeList<'_>,
    experimental: &ModeList<'_>,
    options: &PairingOptions,
    plans: &[Plan],
) -> PairedModes {
    let (n_a, n_x) = mac.shape();
    let judge = Judge { mac, likeness, analytical, experimental, options, plans };
    let mut partners = match options.by {
        PairBy::Mac | PairBy::NearMac => judge.by_mac(),
        PairBy::Order => judge.by_order(),
        PairBy::Label => judge.by_label(),
    };
    let rank = rank_of(&experimental.by_frequency(n_x));
    partners.sort_by_key(|&(_, j)| rank[j]);
    if options.by == PairBy::NearMac {
        uncross(&mut partners, |i| analytical.frequency(i), |i, j| judge.weight(i, j));
    }
    if plans.iter().any(|p| *p != Plan::Free) {
        let order = analytical.by_frequency(n_a);
        let mut taken = vec![false; n_a];
        for p in &partners {
            taken[p.0] = true;
        }
        let is_same = |i: usize, j: usize| !options.same_family_only || judge.is_same_family(i, j);
        add_planned(plans, &order, &mut taken, is_same, &mut partners);
        partners.sort_by_key(|&(_, j)| rank[j]);
    }
    let pairs: Vec<ModePair> = partners.iter().map(|&(i, j)| judge.pair(i, j)).collect();

    let unpaired = |count: usize, is_paired: &dyn Fn(usize) -> bool, values: &dyn Fn(usize) -> Vec<f64>| {
        (0..count)
            .filter(|&k| !is_paired(k))
            .map(|index| Unpaired { index, best: largest(&values(index)) })
            .collect::<Vec<_>>()
    };
    PairedModes {
        unpaired_analytical: unpaired(n_a, &|i| partners.iter().any(|p| p.0 == i), &|i| {
            mac.row(i).iter().copied().collect()
        }),
        unpaired_experimental: unpaired(n_x, &|j| partners.iter().any(|p| p.1 == j), &|j| {
            mac.column(j).iter().copied().collect()
        }),
        swapped: inversions(&pairs, analytical, experimental),
        pairs,
    }
}

/// Adds what the plans say to the pairs of the rule.
///
/// * `order` - modes of the model by ascending frequency
/// * `taken` - those that the rule has paired; those of plans are added
/// * `is_same_family` - (mode of the model, measured mode)
pub(super) fn add_planned(
    plans: &[Plan],
    order: &[usize],
    taken: &mut [bool],
    is_same_family: impl Fn(usize, usize) -> bool,
    pairs: &mut Vec<(usize, usize)>,
) {
    for (j, plan) in plans.iter().enumerate() {
        if let Plan::Fixed(i) = *plan
            && i < taken.len()
        {
            taken[i] = true;
            pairs.push((i, j));
        }
    }
    // Ranks count what the rule has left, so those that are handed out here stay in the count.
    let by_rule = pairs.len();
    for (j, plan) in plans.iter().enumerate() {
        let Plan::Ranked(rank) = *plan else { continue };
        let is_left = |i: usize| pairs[..by_rule].iter().all(|p| p.0 != i) && is_same_family(i, j);
        let mut left = order.iter().copied().filter(|&i| is_left(i)).skip(rank);
        if let Some(i) = left.find(|&i| !taken[i]) {
            taken[i] = true;
            pairs.push((i, j));
        }
    }
}

/// Pairs (by position) whose frequency order is opposite in model and test.
fn inversions(pairs: &[ModePair], analytical: &ModeList<'_>, experimental: &ModeList<'_>) -> Vec<(usize, usize)> {
    let mut swapped = Vec::new();
    for (p, first) in pairs.iter().enumerate() {
        for (q, second) in pairs.iter().enumerate().skip(p + 1) {
            let in_model = analytical.frequency(second.analytical) - analytical.frequency(first.analytical);
            let in_test = experimental.frequency(second.experimental) - experimental.frequency(first.experimental);
            if in_model * in_test < 0.0 {
                swapped.push((p, q));
            }
        }
    }
    swapped
}

/// Position of every index in an order.
fn rank_of(order: &[usize]) -> Vec<usize> {
    let mut rank = vec![0; order.len()];
    for (position, &index) in order.iter().enumerate() {
        rank[index] = position;
    }
    rank
}

/// The first index of the largest value, with the value.
fn largest(values: &[f64]) -> Option<(usize, f64)> {
    let mut best: Option<(usize, f64)> = None;
    for (k, &v) in values.iter().enumerate() {
        if !v.is_nan() && best.is_none_or(|(_, b)| v > b) {
            best = Some((k, v));
        }
    }
    best
}

struct Judge<'a> {
    mac: &'a DMatrix<f64>,
    likeness: &'a DMatrix<f64>,
    analytical: &'a ModeList<'a>,
    experimental: &'a ModeList<'a>,
    options: &'a PairingOptions,
    plans: &'a [Plan],
}

impl Judge<'_> {
    /// Whether the rule pairs a measured mode.
    fn is_free(&self, j: usize) -> bool {
        self.plans.get(j).is_none_or(|p| *p == Plan::Free)
    }

    /// Whether a mode of the model is left to the rule.
    fn is_open(&self, i: usize) -> bool {
        !self.plans.contains(&Plan::Fixed(i))
    }

    fn is_near(&self, i: usize, j: usize) -> bool {
        let (f_a, f_x) = (self.analytical.frequency(i), self.experimental.frequency(j));
        let window = self.options.frequency_window;
        let is_open = f_a.is_nan() || f_x.is_nan() || window == f64::INFINITY;
        is_open || f_a.max(f_x) <= (1.0 + window) * f_a.min(f_x)
    }

    fn is_same_family(&self, i: usize, j: usize) -> bool {
        match (self.analytical.family(i), self.experimental.family(j)) {
            (Some(a), Some(x)) => a == x,
            _ => true,
        }
    }

    fn is_allowed(&self, i: usize, j: usize) -> bool {
        let mac = self.likeness[(i, j)];
        self.is_free(j)
            && self.is_open(i)
            && mac > 0.0
            && mac >= self.options.min_mac
            && self.is_near(i, j)
            && (self.is_same_family(i, j) || !self.options.same_family_only)
    }

    /// min f/max f in [0, 1]; 0 when unknown.
    fn closeness(&self, i: usize, j: usize) -> f64 {
        let (f_a, f_x) = (self.analytical.frequency(i), self.experimental.frequency(j));
        if f_a > 0.0 && f_x > 0.0 { f_a.min(f_x) / f_a.max(f_x) } else { 0.0 }
    }

    /// What a pair is worth; zero where it is not allowed.
    fn weight(&self, i: usize, j: usize) -> f64 {
        if !self.is_allowed(i, j) {
            return 0.0;
        }
        let near = match self.options.by {
            PairBy::NearMac => {
                let (f_a, f_x) = (self.analytical.frequency(i), self.experimental.frequency(j));
                nearness(f_a.min(f_x), f_a.max(f_x))
            }
            _ => 1.0,
        };
        self.likeness[(i, j)] * near + TIE_BREAK * self.closeness(i, j)
    }

    fn by_mac(&self) -> Vec<(usize, usize)> {
        let cost = DMatrix::from_fn(self.mac.nrows(), self.mac.ncols(), |i, j| -self.weight(i, j));
        let chosen = assign(&cost).into_iter().enumerate();
        chosen.filter_map(|(i, j)| j.map(|j| (i, j))).filter(|&(i, j)| self.is_allowed(i, j)).collect()
    }

    /// Test modes of a known family first, each with the next model mode of its family; then what is left of them and of
    /// those of unknown family with the next model mode that could be the same.
    fn by_order(&self) -> Vec<(usize, usize)> {
        let rows = self.analytical.by_frequency(self.mac.nrows());
        let columns = self.experimental.by_frequency(self.mac.ncols());
        let gated = self.options.same_family_only;
        let mut is_taken = vec![false; rows.len()];
        let mut partner = vec![None; columns.len()];
        for is_known in [true, false] {
            for &j in &columns {
                let own = self.experimental.family(j);
                let fits = |i: usize| {
                    if is_known {
                        gated && own.is_some() && self.analytical.family(i) == own
                    } else {
                        !gated || self.is_same_family(i, j)
                    }
                };
                if partner[j].is_none()
                    && self.is_free(j)
                    && let Some(i) = rows.iter().copied().find(|&i| !is_taken[i] && self.is_open(i) && fits(i))
                {
                    is_taken[i] = true;
                    partner[j] = Some(i);
                }
            }
        }
        columns.into_iter().filter_map(|j| partner[j].map(|i| (i, j))).collect()
    }

    fn by_label(&self) -> Vec<(usize, usize)> {
        let mut taken = vec![false; self.mac.nrows()];
        let mut pairs = Vec::new();
        for j in 0..self.mac.ncols() {
            let Some(label) = self.experimental.label(j) else { continue };
            let is_partner = |i: &usize| !taken[*i] && self.is_open(*i) && self.analytical.label(*i) == Some(label);
            let partner = (0..self.mac.nrows()).find(|i| self.is_free(j) && is_partner(i));
            if let Some(i) = partner {
                taken[i] = true;
                pairs.push((i, j));
            }
        }
        pairs
    }

    fn pair(&self, i: usize, j: usize) -> ModePair {
        let mac = self.mac[(i, j)];
        let (n_a, n_x) = self.mac.shape();
        let has_rival = (0..n_a).any(|k| k != i && self.mac[(k, j)] > mac - AMBIGUITY)
            || (0..n_x).any(|k| k != j && self.mac[(i, k)] > mac - AMBIGUITY);
        let flags = [
            (PairFlag::LowMac, mac < self.options.min_mac),
            (PairFlag::FarFrequency, !self.is_near(i, j)),
            (PairFlag::DifferentFamily, !self.is_same_family(i, j)),
            (PairFlag::Ambiguous, has_rival),
        ];
        let f_x = self.experimental.frequency(j);
        ModePair {
            analytical: i,
            experimental: j,
            mac,
            frequency_error: (self.analytical.frequency(i) - f_x) / f_x,
            flags: flags.into_iter().filter_map(|(flag, raised)| raised.then_some(flag)).collect(),
        }
    }
}

/// Modes of a new model state that continue the modes of an earlier one.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Tracked {
    /// For every earlier mode the index of its continuation; `None` when it is lost (its MAC is below the gate).
    pub index: Vec<Option<usize>>,
    /// MAC of every earlier mode with its continuation; 0 when lost.
    pub mac: Vec<f64>,
}

/// Follows modes from one model state to the next, so that a pair keeps its partner through an update.
///
/// ```text
/// max Σ MAC[i, j(i)],   previous mode i -> current mode j(i),   MAC[i, j] ≥ min_mac
/// ```
///
/// * `previous`, `current` - shapes at the same dofs or sensors, (n x n_previous), (n x n_current)
/// * `mass` - mass matrix (n x n) for the mass-weighted MAC, which separates modes exactly when all dofs are given
/// * `min_mac` - below it a mode counts as lost; 0.5 in mass-weighted MAC is the usual gate
///
/// Frequencies play no part: modes may cross. Take smaller steps when modes are lost; two modes that veer exchange their
/// shapes gradually, and which of them continues which is a matter of the step.
///
/// # Panics
/// If the row counts differ.
///
/// # Source
/// M. S. Eldred, V. B. Venkayya, W. J. Anderson, Mode tracking issues in structural optimization, AIAA Journal 33
/// (1995) 1926-1933 (cross-orthogonality check); here with an optimal assignment.
pub fn track<T: ShapeScalar>(
    previous: &DMatrix<T>,
    current: &DMatrix<T>,
    mass: Option<&DMatrix<f64>>,
    min_mac: f64,
) -> Tracked {
    let mac = match mass {
        Some(m) => weighted_mac_matrix(previous, current, m),
        None => mac_matrix(previous, current),
    };
    let gate = |i: usize, j: usize| mac[(i, j)] > 0.0 && mac[(i, j)] >= min_mac;
    let cost = DMatrix::from_fn(mac.nrows(), mac.ncols(), |i, j| if gate(i, j) { -mac[(i, j)] } else { 0.0 });
    let index: Vec<Option<usize>> =
        assign(&cost).into_iter().enumerate().map(|(i, j)| j.filter(|&j| gate(i, j))).collect();
    let mac = index.iter().enumerate().map(|(i, j)| j.map_or(0.0, |j| mac[(i, j)])).collect();
    Tracked { index, mac }
}

#[cfg(test)]
mod tests;
