//! Two hypotheses together.
//!
//! The first of two was chosen while the second was not there, and may have taken over what the second leaves. So each is sought again
//! with the other in its place:
//!
//! ```text
//! ln B(a, b) = ln B(a) + ln B(b | a) = ln B(b) + ln B(a | b)
//! ```
//!
//! All pairs that share one member with the best are compared; what cannot be told from a member beside the other is tied with it.

use super::board::merge;
use super::hypothesis::{Refit, Tried, without_between};
use super::nested::leave_out_wider;
use super::prior::Odds;
use super::run::{refit_begun, refit_these, stage_with};
use super::singles::refit;
use crate::error::DiagnosisError;
use crate::problem::evidence::ln_sum;
use crate::screen::stage::Stage;
use crate::settings::Settings;
use crate::thresholds::{LOWER, STRONG};
use retune::linalg::DVector;
use std::collections::BTreeMap;

/// Two hypotheses, what could stand in the place of each, and what was fitted with one of them.
pub(crate) struct Pair {
    /// The first on the base alone.
    pub(crate) first: Refit,
    /// With the first in the base.
    pub(crate) on_first: Stage,
    /// On top of the first, the most probable first: the second of the pair.
    pub(crate) seconds: Vec<Refit>,
    /// With the second in the base.
    pub(crate) on_second: Stage,
    /// On top of the second, the most probable first: the first of the pair.
    pub(crate) firsts: Vec<Refit>,
    /// ln of odds times Bayes factors of all pairs together.
    pub(crate) ln_all: f64,
    /// By id: the share of the pairs with it.
    shares: BTreeMap<String, f64>,
}

impl Pair {
    /// The one that explains as much alone: the other brings nothing strong beside it.
    pub(crate) fn alone(&self) -> Option<&Refit> {
        let brings = |more: &[Refit]| more.first().is_some_and(|r| r.ln_bayes > STRONG);
        match (brings(&self.firsts), brings(&self.seconds)) {
            (true, false) => Some(&self.first),
            (false, _) => self.seconds.first(),
            (true, true) => None,
        }
    }

    /// The share of the pairs with a hypothesis among all that were fitted.
    pub(crate) fn share(&self, id: &str) -> f64 {
        self.shares.get(id).copied().unwrap_or(0.0)
    }
}

/// The best pair that one or a few exchanges lead to; `None` where the second cannot stand alone.
///
/// * `refits` - of the base
/// * `first` - on the base
/// * `on_first`, `seconds` - the stage with it, and what was refitted there
pub(crate) fn pair(
    base: &Stage,
    refits: &[Refit],
    first: Refit,
    (on_first, seconds): (Stage, Vec<Refit>),
    odds: &Odds<'_>,
    settings: &Settings,
) -> Result<Option<Pair>, DiagnosisError> {
    let weight = |r: &Refit| odds.weight(r);
    let order = |list: &mut Vec<Refit>| list.sort_by(|a, b| weight(b).total_cmp(&weight(a)));
    let n = base.fit.x.len();
    let id = |r: &Refit| r.id(&base.scene);
    // Alone on the base: as it was fitted there, or from where the pair has brought the base.
    let alone = |r: &Refit| {
        let known = refits.iter().find(|known| id(known) == id(r)).cloned();
        let starts = [r.fit.x.rows(0, n).into_owned(), base.fit.x.clone()];
        known.or_else(|| refit_these(base, &[&r.tried], &starts).ok()?.pop())
    };
    let with = |r: &Refit| stage_with(base, r, settings);
    // Others each with the fit of it and what is on top of it here, where there is one.
    let on_top = |of: &Refit, stage: &Stage, others: &[(&Refit, Option<&Refit>)], starts: &[DVector<f64>]| {
        let mut found = refit(stage, true)?.hypotheses;
        // With one more in the base none leaves more than alone, and two leave the same in either order: one that seems to has ended in another basin.
        let is_there = |(other, joint): &(&Refit, Option<&Refit>)| {
            let reached = joint.map_or(other.fit.phi, |j| j.fit.phi) + LOWER;
            found.iter().any(|r| id(r) == id(other) && r.fit.phi <= reached)
        };
        // Where both were found, or where it was found alone with what the stage has in its base.
        let begun = |&(r, joint): &(&Refit, Option<&Refit>)| {
            let beside = stage.fit.x.len() - n;
            let all = match joint {
                Some(j) => {
                    let own = j.fit.x.len() - n - beside;
                    [j.fit.x.rows(0, n), j.fit.x.rows(n + own, beside), j.fit.x.rows(n, own)]
                }
                None => [r.fit.x.rows(0, n), stage.fit.x.rows(n, beside), r.fit.x.rows(n, r.fit.x.len() - n)],
            };
            let all: Vec<f64> = all.iter().flat_map(|part| part.iter().copied()).collect();
            matches!(r.tried, Tried::Effect(_)).then(|| DVector::from_vec(all))
        };
        let again: Vec<_> =
            others.iter().filter(|other| !is_there(other)).map(|other| (&other.0.tried, begun(other))).collect();
        merge(stage, &mut found, refit_begun(stage, &again, &[starts, std::slice::from_ref(&stage.fit.x)].concat())?);
        found.retain(|r| id(r) != id(of));
        leave_out_wider(stage, &mut found);
        order(&mut found);
        Ok::<_, DiagnosisError>(found)
    };
    let mut now = (first, on_first, seconds);
    order(&mut now.2);
    for exchange in 0..=base.effort().exchanges {
        if base.settings.until.is_over() {
            return Ok(None);
        }
        let (first, on_first, seconds) = now;
        let Some(second) = seconds.first().and_then(alone) else { return Ok(None) };
        let on_second = with(&second)?;
        let own = id(&first);
        let rivals = refits.iter().take(base.effort().rivals).filter(|r| id(r) != own && id(r) != id(&second));
        let others: Vec<_> = rivals.map(|r| (r, None)).chain([(&first, seconds.first())]).collect();
        // Where the two have brought the base and the one that was fitted last.
        let both = without_between(&seconds[0].fit.x, n, on_second.fit.x.len() - n);
        let firsts = on_top(&second, &on_second, &others, &[both])?;
        let better =
            firsts.first().filter(|best| exchange < base.effort().exchanges && id(best) != own).and_then(alone);
        let Some(better) = better else {
            let (ln_all, shares) = compare(&id, &weight, (&first, &seconds), (&second, &firsts));
            return Ok(Some(Pair { first, on_first, seconds, on_second, firsts, ln_all, shares }));
        };
        let on_better = with(&better)?;
        let seconds = on_top(&better, &on_better, &[(&second, firsts.first())], &[])?;
        now = (better, on_better, seconds);
    }
    Ok(None)
}

/// ln of odds times Bayes factors of all pairs, in either order, and the share of each hypothesis.
fn compare(
    id: &impl Fn(&Refit) -> String,
    weight: &impl Fn(&Refit) -> f64,
    (first, seconds): (&Refit, &[Refit]),
    (second, firsts): (&Refit, &[Refit]),
) -> (f64, BTreeMap<String, f64>) {
    let mut pairs: BTreeMap<[String; 2], f64> = BTreeMap::new();
    // The two themselves come in either order, and fits are not alike to the last unit of ln B: the lower order is raised to the other, for a pair
    // is to be compared with those of its own order.
    let common = |lower: &Refit, upper: &[Refit], other: &Refit| {
        upper.iter().find(|r| id(r) == id(other)).map(|r| weight(lower) + weight(r))
    };
    let [up, down] = match (common(first, seconds, second), common(second, firsts, first)) {
        (Some(a), Some(b)) => [(b - a).max(0.0), (a - b).max(0.0)],
        _ => [0.0; 2],
    };
    let of_first = seconds.iter().map(|r| (first, r, up));
    let all = of_first.chain(firsts.iter().map(|r| (second, r, down)));
    for (lower, upper, raised) in all {
        let mut ids = [id(lower), id(upper)];
        ids.sort();
        let ln = weight(lower) + weight(upper) + raised;
        pairs.entry(ids).and_modify(|known| *known = known.max(ln)).or_insert(ln);
    }
    let sum = ln_sum(&pairs.values().copied().collect::<Vec<_>>());
    let mut shares: BTreeMap<String, f64> = BTreeMap::new();
    for (ids, ln) in pairs {
        for id in ids {
            *shares.entry(id).or_default() += (ln - sum).exp();
        }
    }
    (std::f64::consts::LN_2 + sum, shares)
}
