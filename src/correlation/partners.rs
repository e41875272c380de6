//! Pairing for the thousands of candidates of a search: the rules of [`super::pair_modes`] and nothing beside the partners.
//!
//! Nothing is allocated after the first candidate. Families are small numbers here, 0 for an unknown one.

use super::assignment::Assigner;
use super::pairing::{PairBy, PairingOptions, Plan, TIE_BREAK, add_planned, nearness, uncross};

/// The measured side of many pairings, and their memory.
#[derive(Debug)]
pub(crate) struct PartnerSearch {
    options: PairingOptions,
    frequencies: Vec<f64>,
    families: Vec<u8>,
    plans: Vec<Plan>,
    has_plans: bool,
    /// 0, 1, 2 ...: the modes of the model come by ascending frequency.
    ascending: Vec<usize>,
    /// Place of every test mode in `order`.
    rank: Vec<usize>,
    /// Test modes by ascending frequency.
    order: Vec<usize>,
    /// Cost of each pair, (n_test x n_model), row by row.
    cost: Vec<f64>,
    /// The cheapest model mode of each test mode.
    cheapest: Vec<usize>,
    taken: Vec<bool>,
    assigner: Assigner,
}

impl PartnerSearch {
    /// For test modes with these frequencies (Hz) and families; `None` for pairing by label, which needs labels.
    ///
    /// * `plans` - what is settled about the test modes; empty where nothing is
    pub(crate) fn new(frequencies: &[f64], families: &[u8], options: PairingOptions, plans: &[Plan]) -> Option<Self> {
        if options.by == PairBy::Label {
            return None;
        }
        let mut order: Vec<usize> = (0..frequencies.len()).collect();
        order.sort_by(|&i, &j| frequencies[i].total_cmp(&frequencies[j]));
        let mut rank = vec![0; order.len()];
        order.iter().enumerate().for_each(|(k, &j)| rank[j] = k);
        let plans: Vec<Plan> = (0..frequencies.len()).map(|j| plans.get(j).copied().unwrap_or_default()).collect();
        Some(Self {
            options,
            has_plans: plans.iter().any(|p| *p != Plan::Free),
            plans,
            ascending: Vec::new(),
            rank,
            frequencies: frequencies.to_vec(),
            families: families.to_vec(),
            order,
            cost: Vec::new(),
            cheapest: Vec::new(),
            taken: Vec::new(),
            assigner: Assigner::default(),
        })
    }

    /// Pairs (model mode, test mode), by ascending frequency of the test mode, overwriting `out`.
    ///
    /// * `frequencies`, `families` - of the model modes, frequencies ascending
    /// * `mac` - MAC of all model modes with test mode j, in [0, 1]
    pub(crate) fn find<'a>(
        &mut self,
        frequencies: &[f64],
        families: &[u8],
        mac: impl Fn(usize) -> &'a [f64],
        out: &mut Vec<(usize, usize)>,
    ) {
        out.clear();
        match self.options.by {
            PairBy::Mac | PairBy::NearMac => self.by_mac(frequencies, families, mac, out),
            PairBy::Order | PairBy::Label => self.by_order(frequencies.len(), families, out),
        }
        if self.has_plans {
            self.add_planned(families, out);
        }
    }

    /// Whether the families let a pair be made by MAC.
    pub(crate) fn is_same_family(&self, family: u8, test_mode: usize) -> bool {
        let other = self.families[test_mode];
        !self.options.same_family_only || family == 0 || other == 0 || family == other
    }

    /// What is settled.
    fn add_planned(&mut self, families: &[u8], out: &mut Vec<(usize, usize)>) {
        let n_model = families.len();
        self.taken.clear();
        self.taken.resize(n_model, false);
        for p in &*out {
            self.taken[p.0] = true;
        }
        self.ascending.clear();
        self.ascending.extend(0..n_model);
        let (own, gated) = (&self.families, self.options.same_family_only);
        let is_same = |i: usize, j: usize| !gated || families[i] == 0 || own[j] == 0 || families[i] == own[j];
        add_planned(&self.plans, &self.ascending, &mut self.taken, is_same, out);
        let rank = &self.rank;
        out.sort_unstable_by_key(|&(_, j)| rank[j]);
    }

    fn by_mac<'a>(
        &mut self,
        frequencies: &[f64],
        families: &[u8],
        mac: impl Fn(usize) -> &'a [f64],
        out: &mut Vec<(usize, usize)>,
    ) {
        let (n_model, n_test) = (frequencies.len(), self.frequencies.len());
        let PairingOptions { by, min_mac, frequency_window: window, same_family_only } = self.options;
        self.cost.clear();
        self.cost.resize(n_test * n_model, 0.0);
        self.cheapest.clear();
        self.taken.clear();
        self.taken.resize(n_model, false);
        // Where every test mode prefers another model mode, these are the best pairs; else an assignment decides.
        let mut contested = false;
        for (j, costs) in self.cost.chunks_exact_mut(n_model.max(1)).enumerate() {
            if self.plans[j] != Plan::Free {
                costs.fill(0.0);
                self.cheapest.push(n_model);
                continue;
            }
            let (measured, own) = (self.frequencies[j], self.families[j]);
            for (((cost, &value), &hz), &family) in costs.iter_mut().zip(mac(j)).zip(frequencies).zip(families) {
                let (low, high) = (hz.min(measured), hz.max(measured));
                let is_near = window == f64::INFINITY || low.is_nan() || high <= (1.0 + window) * low;
                let is_same = !same_family_only || family == 0 || own == 0 || family == own;
                let allowed = value > 0.0 && value >= min_mac && is_near && is_same;
                let ratio = low / high;
                let closeness = if low > 0.0 { ratio } else { 0.0 };
                let dear = -value - TIE_BREAK * closeness;
                *cost = if allowed { dear } else { 0.0 };
            }
            if by == PairBy::NearMac {
                for ((cost, &value), &hz) in costs.iter_mut().zip(mac(j)).zip(frequencies) {
                    if *cost < 0.0 {
                        *cost += value * (1.0 - nearness(hz.min(measured), hz.max(measured)));
                    }
                }
            }
            if self.has_plans {
                for plan in &self.plans {
                    if let Plan::Fixed(i) = *plan
                        && i < n_model
                    {
                        costs[i] = 0.0;
                    }
                }
            }
            let (mut cheapest, mut least) = (n_model, 0.0);
            for (i, &cost) in costs.iter().enumerate() {
                if cost < least {
                    (cheapest, least) = (i, cost);
                }
            }
            if cheapest < n_model {
                contested |= std::mem::replace(&mut self.taken[cheapest], true);
            }
            self.cheapest.push(cheapest);
        }
        if contested {
            let cost = &self.cost;
            self.cheapest.fill(n_model);
            if n_model > n_test {
                let chosen = self.assigner.assign(n_test, n_model, |j, i| cost[j * n_model + i]);
                self.cheapest.copy_from_slice(chosen);
            } else {
                for (i, &j) in self.assigner.assign(n_model, n_test, |i, j| cost[j * n_model + i]).iter().enumerate() {
                    self.cheapest[j] = i;
                }
            }
        }
        for &j in &self.order {
            let i = self.cheapest[j];
            if i < n_model && self.cost[j * n_model + i] < 0.0 {
                out.push((i, j));
            }
        }
        if by == PairBy::NearMac {
            uncross(out, |i| frequencies[i], |i, j| -self.cost[j * n_model + i]);
        }
    }

    /// The k-th model mode with the k-th test mode, within each family where families are gated; modes of unknown family
    /// with what is left.
    fn by_order(&mut self, n_model: usize, families: &[u8], out: &mut Vec<(usize, usize)>) {
        self.taken.clear();
        self.taken.resize(n_model, false);
        self.cheapest.clear();
        self.cheapest.resize(self.frequencies.len(), n_model);
        for plan in &self.plans {
            if let Plan::Fixed(i) = *plan
                && i < n_model
            {
                self.taken[i] = true;
            }
        }
        let gated = self.options.same_family_only;
        for is_known in [true, false] {
            for &j in &self.order {
                let own = self.families[j];
                let fits = |i: usize| {
                    let is_same = families[i] == own;
                    if is_known {
                        gated && own != 0 && is_same
                    } else {
                        !gated || own == 0 || families[i] == 0 || is_same
                    }
                };
                if self.cheapest[j] == n_model
                    && self.plans[j] == Plan::Free
                    && let Some(i) = (0..n_model).find(|&i| !self.taken[i] && fits(i))
                {
                    self.taken[i] = true;
                    self.cheapest[j] = i;
                }
            }
        }
        out.extend(self.order.iter().map(|&j| (self.cheapest[j], j)).filter(|p| p.0 < n_model));
    }
}

#[cfg(test)]
mod tests {
    use super::super::{ModeList, pair_planned_modes};
    use super::*;
    use crate::linalg::DMatrix;
    use proptest::prelude::*;

    proptest! {
        /// Whatever the MAC, the families and the gates: the partners of `pair_modes`.
        #[test]
        fn partners_are_those_of_the_reported_pairing(
            n_model in 1_usize..9,
            n_test in 1_usize..7,
            values in prop::collection::vec(0.0_f64..1.0, 64),
            model_families in prop::collection::vec(0_u8..3, 9),
            test_families in prop::collection::vec(0_u8..3, 7),
            gates in (0.0_f64..0.6, 0_usize..3, any::<bool>(), 0_usize..3),
            plans in prop::collection::vec(0_usize..12, 7),
        ) {
            let (min_mac, window, same_family_only, by) = gates;
            let options = PairingOptions {
                by: [PairBy::Order, PairBy::Mac, PairBy::NearMac][by],
                min_mac,
                frequency_window: [0.2, 0.5, f64::INFINITY][window],
                same_family_only,
            };
            let model: Vec<f64> = (0..n_model).map(|i| 2.0 + (i * i) as f64).collect();
            let test: Vec<f64> = (0..n_test).map(|j| 6.1 + ((5 * j) % 7) as f64).collect();
            let mac = DMatrix::from_fn(n_model, n_test, |i, j| if (i + j) % 5 == 4 { 0.0 } else { values[i * 7 + j] });
            let names = |codes: &[u8]| -> Vec<Option<String>> {
                codes.iter().map(|c| [None, Some("a".to_string()), Some("b".to_string())][*c as usize].clone()).collect()
            };
            let (a, x) = (names(&model_families[..n_model]), names(&test_families[..n_test]));
            // At most one mode is fixed to each.
            let plans: Vec<Plan> = (0..n_test)
                .map(|j| match plans[j] {
                    0 => Plan::Aside,
                    1 if j < n_model => Plan::Fixed(j),
                    2 => Plan::Ranked(j % 3),
                    _ => Plan::Free,
                })
                .collect();
            let paired = pair_planned_modes(
                &mac,
                &ModeList { frequencies_hz: &model, labels: &[], families: &a },
                &ModeList { frequencies_hz: &test, labels: &[], families: &x },
                &options,
                &plans,
            );
            let expected: Vec<(usize, usize)> = paired.pairs.iter().map(|p| (p.analytical, p.experimental)).collect();
            let mut search = PartnerSearch::new(&test, &test_families[..n_test], options, &plans).expect("not by label");
            let mut found = Vec::new();
            for _ in 0..2 {
                search.find(&model, &model_families[..n_model], |j| &mac.as_slice()[j * n_model..][..n_model], &mut found);
                prop_assert_eq!(&found, &expected);
            }
        }
    }
}
