//! The best places of a mesh with their true shape: element by element, whether it belongs to them.
//!
//! A patch is about round. With Δr_e(p) what the effect at element e alone does to the residual, on top of what has been found, δ the size of that and
//! everything that a refit absorbs projected out, an element that is taken in or left out changes the residual by
//!
//! ```text
//! Δr_e'(δ)   outside,      Δr_e'(-δ/κ)   inside,      κ = Σ G_e · dr/dδ / |dr/dδ|²,  G_e = dr/dp at e,  over those inside
//! ```
//!
//! (κ = 1 + δ where sizes are factors, for there a size is one of what is left). The elements along the edge that lower
//!
//! ```text
//! |r'|² + 2 s ln μ        s sides along the edge, μ^s shapes with as many
//! ```
//!
//! most are taken one after the other; the best few shapes on the way are fitted, and the best of these is where the next look begins.

use super::finer_mesh::{has_a_mesh, of_each_kind};
use super::step::{Step, is_worth_more};
use crate::error::DiagnosisError;
use crate::problem::fit::{evaluate, project};
use crate::screen::effects::{Score, is_small};
use crate::screen::stage::Stage;
use crate::search::board::Board;
use crate::search::hypothesis::{Refit, Tried};
use crate::search::run::{Job, run};
use crate::thresholds::SMALL_STEP;
use retune::effect::{Candidate, LN_OF_A_SIDE, Neighbourhood, Structure};
use retune::linalg::{DMatrix, DVector};
use std::collections::BTreeMap;

/// Sizes at which an edge is looked at, as multiples of the one that was found: a smaller field that is changed more has another edge.
const SIZES: [f64; 4] = [1.0, 1.25, 1.6, 0.7];
/// Shapes on the way that are fitted, as shares of the elements that would change sides.
const ON_THE_WAY: [usize; 3] = [1, 2, 4];

pub(super) const STEP: Step = Step { name: "the shape of the best places", when: is_worth_growing, take };

/// Beside another hypothesis too, where the best leaves more than noise: there a place that is nearly right calls for a third thing.
fn is_worth_growing(board: &Board<'_>) -> Result<bool, DiagnosisError> {
    let is_beside = || Ok::<_, DiagnosisError>(board.few && board.is_poor() && !board.leaves_noise()?);
    Ok(has_a_mesh(board) && (is_worth_more(board)? || is_beside()?))
}

/// Grows the best places of each of the best few kinds; what cannot be looked at stays as it is.
#[expect(clippy::unnecessary_wraps, reason = "as the other steps")]
fn take(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let stage = board.stage;
    let kinds = if board.few { stage.effort().of_every_kind } else { stage.effort().polished };
    let structures = stage.structures();
    for (place, _) in of_each_kind(board, kinds) {
        for start in of_each_size(board, &structures, place.effect.name()) {
            let mut best = start;
            for _ in 0..stage.effort().finer_rounds {
                let Ok(found) = grown(stage, &structures, &best, board.ln_base) else { break };
                let better = found.into_iter().filter(|r| r.ln_bayes > best.ln_bayes);
                let Some(better) = better.max_by(|a, b| a.ln_bayes.total_cmp(&b.ln_bayes)) else { break };
                board.add(vec![better.clone()]);
                best = better;
            }
        }
    }
    Ok(())
}

/// The best place of an effect of each size, up to a factor of two, the best first: a wide field that is hardly changed and a small one that is changed
/// much stand in basins of their own.
fn of_each_size(board: &Board<'_>, structures: &[Structure<'_>], effect: &str) -> Vec<Refit> {
    let size = |r: &Refit| match &r.tried {
        Tried::Effect(c) if c.effect.name() == effect && c.parameters.len() == 1 => match c.location.names.as_slice() {
            [name] => structures.iter().find_map(|s| s.shape(name)).map(|elements| elements.len()),
            _ => None,
        },
        _ => None,
    };
    let mut best: BTreeMap<u32, &Refit> = BTreeMap::new();
    for r in &board.found.hypotheses {
        let Some(size) = size(r) else { continue };
        let known = best.entry(size.ilog2()).or_insert(r);
        if r.ln_bayes > known.ln_bayes {
            *known = r;
        }
    }
    let mut best: Vec<&Refit> = best.into_values().collect();
    best.sort_by(|a, b| b.ln_bayes.total_cmp(&a.ln_bayes));
    let most = if board.stage.scene.is_huge() { 1 } else { board.stage.effort().of_every_kind };
    best.into_iter().take(most).cloned().collect()
}

/// A shape that an edge asks for.
struct Shape {
    name: String,
    /// Where its fit begins.
    x: DVector<f64>,
    /// What it leaves, and pays for its edge against that of the start, to first order.
    left: f64,
}

/// The same effect on shapes that its edge asks for.
fn grown(stage: &Stage, structures: &[Structure<'_>], r: &Refit, base: f64) -> Result<Vec<Refit>, DiagnosisError> {
    let Tried::Effect(candidate) = &r.tried else { return Ok(Vec::new()) };
    let ([parameter], [name]) = (candidate.parameters.as_slice(), candidate.location.names.as_slice()) else {
        return Ok(Vec::new());
    };
    let Some((structure, about)) = structures.iter().find_map(|s| Some((s, s.neighbourhood(name)?))) else {
        return Ok(Vec::new());
    };
    let elements: Vec<usize> = about.inside.iter().chain(&about.outside).copied().collect();
    let (inside, outside) = elements.split_at(about.inside.len());
    let [low, high] = parameter.bounds;
    let last = r.fit.x.len() - 1;
    let mut shapes: Vec<Shape> = Vec::new();
    // On a mesh of very many dofs the sensors are solved for anew at every size.
    let sizes = if stage.scene.is_huge() { &SIZES[..1] } else { &SIZES[..] };
    for &multiple in sizes {
        let size = (multiple * (parameter.at(r.fit.x[last]) - parameter.neutral))
            .clamp(low - parameter.neutral, high - parameter.neutral);
        let mut x = r.fit.x.clone();
        x[last] = parameter.in_box(parameter.neutral + size);
        let is_as_found = multiple == 1.0;
        let fit = if is_as_found { Ok(r.fit.clone()) } else { evaluate(&r.scene, x.clone(), stage.weight) };
        // A size at which a mode has no partner shows no edge.
        let Ok(fit) = fit else { continue };
        let here = stage.at(r.scene.clone(), fit)?;
        let each = |of: &[usize], change: f64| {
            let names: Vec<&str> = of.iter().map(|&e| structure.model().elements()[e].name.as_str()).collect();
            each_alone(&here, candidate, &names, change)
        };
        let small = SMALL_STEP * size;
        let own = here.fit.j.column(last) / (high - low);
        let sum = each(inside, small)?.into_iter().flatten().fold(DVector::zeros(r.fit.r.len()), |sum, s| sum + s);
        let share = sum.dot(&own) / (small * own.norm_squared());
        if !(share.is_finite() && share > 0.0) {
            continue;
        }
        let changes = [each(inside, -size / share)?, each(outside, size)?].concat();
        let changes: Vec<_> = changes.into_iter().map(|change| change.map(|delta| project(&here.q, &delta))).collect();
        let order = changing_sides(&about, &changes, here.residual.clone());
        for part in ON_THE_WAY.into_iter().filter(|part| order.len() >= *part) {
            let order = &order[..order.len().div_ceil(part)];
            let mut is_in: Vec<bool> = (0..elements.len()).map(|k| k < inside.len()).collect();
            for step in order {
                is_in[step.0] = !is_in[step.0];
            }
            let chosen: Vec<usize> = elements.iter().zip(is_in).filter(|(_, is_in)| *is_in).map(|(&e, _)| e).collect();
            let left = order.last().map_or(f64::INFINITY, |step| step.1);
            let is_new = |name: &String| shapes.iter().all(|known| known.name != *name);
            shapes.extend(structure.region_name(&chosen).filter(is_new).map(|name| Shape { name, x: x.clone(), left }));
        }
    }
    shapes.sort_by(|a, b| a.left.total_cmp(&b.left));
    shapes.truncate(stage.effort().starts);
    if shapes.is_empty() {
        return Ok(Vec::new());
    }
    let names: Vec<String> = shapes.iter().map(|shape| shape.name.clone()).collect();
    let wider = stage.on_wider(stage.between_candidates(structures, candidate, &names))?;
    let bases = [r.fit.x.rows(0, stage.fit.x.len()).into_owned()];
    let begun = |s: &Score| {
        let at = &wider.screened[s.index].candidate.location.names;
        shapes.iter().find(|shape| at.contains(&shape.name)).map(|shape| &shape.x)
    };
    let jobs: Vec<Job<'_>> = wider.effects.iter().filter_map(|s| Some(Job::Begun(s, &bases, begun(s)?))).collect();
    Ok(run(&wider, &jobs, base))
}

/// What an effect at each of these elements alone would do to the residual, to first order in the change of its matrices; none where it has no trace.
///
/// * `change` - of its parameter
fn each_alone(
    here: &Stage,
    candidate: &Candidate,
    elements: &[&str],
    change: f64,
) -> Result<Vec<Option<DVector<f64>>>, DiagnosisError> {
    let alone: Vec<String> = elements.iter().map(|name| format!("{name}~1")).collect();
    let mut placed = here.candidates_at(candidate, &alone);
    for p in placed.iter_mut().flat_map(|c| &mut c.parameters) {
        // The small step of a screening is this one.
        p.typical = p.neutral + change / SMALL_STEP;
    }
    let seen = here.on_wider(placed)?;
    let of = |(name, alone): (&&str, &String)| {
        let is_there = |c: &Candidate| matches!(c.location.names.as_slice(), [at] if at == alone || at == name);
        let screened = seen.screened.iter().find(|s| is_there(&s.candidate))?;
        screened.columns.iter().find(|c| is_small(&screened.candidate, &c.values)).map(|c| c.delta.clone())
    };
    Ok(elements.iter().zip(&alone).map(of).collect())
}

/// Elements that change sides, the one that gains most first, each with |r'|² + 2 s ln μ after it, s against the sides at the start;
/// only what touches the other side can.
///
/// * `changes` - of the projected residual by each, none where it has no trace
fn changing_sides(
    about: &Neighbourhood,
    changes: &[Option<DVector<f64>>],
    mut residual: DVector<f64>,
) -> Vec<(usize, f64)> {
    let mut is_in: Vec<bool> = (0..changes.len()).map(|k| k < about.inside.len()).collect();
    let mut order: Vec<(usize, f64)> = Vec::new();
    let known: Vec<usize> = (0..changes.len()).filter(|&k| changes[k].is_some()).collect();
    let columns: Vec<DVector<f64>> = changes.iter().flatten().cloned().collect();
    if columns.is_empty() {
        return order;
    }
    let columns = DMatrix::from_columns(&columns);
    let squared: Vec<f64> = columns.column_iter().map(|c| c.norm_squared()).collect();
    let mut left = residual.norm_squared();
    while order.len() < about.inside.len().max(2) {
        let along = columns.tr_mul(&residual);
        let is_open = |k: usize| {
            order.iter().all(|step| step.0 != k) && about.touching[k].iter().any(|&other| is_in[other] != is_in[k])
        };
        let n_inside = is_in.iter().filter(|is_in| **is_in).count();
        let may = |k: usize| is_open(k) && (!is_in[k] || n_inside > 2);
        let more_sides = |k: usize| {
            let others = about.touching[k].iter().filter(|&&other| is_in[other] != is_in[k]).count();
            about.touching[k].len() as f64 - 2.0 * others as f64
        };
        let gain = |c: usize, k: usize| -2.0 * along[c] - squared[c] - 2.0 * LN_OF_A_SIDE * more_sides(k);
        let gains = known.iter().enumerate().filter(|(_, k)| may(**k)).map(|(c, &k)| (gain(c, k), c, k));
        let Some((gain, column, k)) = gains.max_by(|a, b| a.0.total_cmp(&b.0)) else { break };
        if gain <= 0.0 {
            break;
        }
        residual += columns.column(column);
        is_in[k] = !is_in[k];
        left -= gain;
        order.push((k, left));
    }
    order
}
