//! The best places of a mesh with their true shape: element by element, whether it belongs to them.
//!
//! A patch is about round. With G_e the slope of the residual for the effect at element e alone, δ the size that was found and everything that a
//! refit absorbs projected out, an element that is taken in or left out changes the residual by
//!
//! ```text
//! Δr' = δ G_e'      outside,        Δr' = -δ/κ G_e'      inside,        κ = Σ G_e · dr/dδ / |dr/dδ|²  over those inside
//! ```
//!
//! (κ = 1 + δ where sizes are factors, for there a slope is one of what is left). The elements along the edge that lower
//!
//! ```text
//! |r'|² + 2 s ln μ        s sides along the edge, μ^s shapes with as many
//! ```
//!
//! most are taken one after the other; the shapes on the way are fitted, and the best of them is where the next look begins.

use super::finer_mesh::{has_a_mesh, of_each_kind};
use super::step::{Step, is_worth_more};
use crate::error::DiagnosisError;
use crate::problem::fit::project;
use crate::screen::effects::is_small;
use crate::screen::stage::Stage;
use crate::search::board::Board;
use crate::search::hypothesis::{Refit, Tried};
use crate::search::run::{Job, run};
use retune::effect::{Candidate, LN_OF_A_SIDE, Neighbourhood};
use retune::linalg::{DMatrix, DVector};

/// Shapes on the way that are fitted, as shares of the elements that would change sides.
const ON_THE_WAY: [usize; 3] = [1, 2, 4];

pub(super) const STEP: Step = Step { name: "the shape of the best places", when: is_worth_growing, take };

/// Beside another hypothesis too, where the best leaves more than noise: there a place that is nearly right calls for a third thing.
fn is_worth_growing(board: &Board<'_>) -> Result<bool, DiagnosisError> {
    let is_beside = || Ok::<_, DiagnosisError>(board.few && board.is_poor() && !board.leaves_noise()?);
    Ok(has_a_mesh(board) && (is_worth_more(board)? || is_beside()?))
}

/// Grows the best place of each of the best few kinds.
fn take(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let effort = board.stage.effort();
    let kinds = if board.few { effort.of_every_kind } else { effort.finer_kinds };
    for (place, _) in of_each_kind(board, kinds) {
        let id = place.id();
        let Some(mut best) = board.found.hypotheses.iter().find(|r| r.id(&board.stage.scene) == id).cloned() else {
            continue;
        };
        for _ in 0..board.stage.effort().finer_rounds {
            let found = grown(board.stage, &best, board.ln_base)?;
            let better =
                found.iter().filter(|r| r.ln_bayes > best.ln_bayes).max_by(|a, b| a.ln_bayes.total_cmp(&b.ln_bayes));
            let Some(better) = better.cloned() else { break };
            board.add(vec![better.clone()]);
            best = better;
        }
    }
    Ok(())
}

/// The same effect on shapes that its edge asks for.
fn grown(stage: &Stage, r: &Refit, base: f64) -> Result<Vec<Refit>, DiagnosisError> {
    let Tried::Effect(candidate) = &r.tried else { return Ok(Vec::new()) };
    let ([parameter], [name]) = (candidate.parameters.as_slice(), candidate.location.names.as_slice()) else {
        return Ok(Vec::new());
    };
    let structures = stage.structures();
    let Some((structure, about)) = structures.iter().find_map(|s| Some((s, s.neighbourhood(name)?))) else {
        return Ok(Vec::new());
    };
    let elements: Vec<usize> = about.inside.iter().chain(&about.outside).copied().collect();
    let element_name = |e: usize| structure.model().elements()[e].name.clone();
    let alone: Vec<String> = elements.iter().map(|&e| format!("{}~1", element_name(e))).collect();
    let here = stage.at(r.scene.clone(), r.fit.clone())?;
    let beside = here.on_wider(here.candidates_at(candidate, &alone))?;
    let slope = |k: usize| {
        let is_there = |c: &Candidate| {
            c.location.names.len() == 1
                && (c.location.names[0] == alone[k] || c.location.names[0] == element_name(elements[k]))
        };
        let screened = beside.screened.iter().find(|s| is_there(&s.candidate))?;
        let column = screened.columns.iter().find(|c| is_small(&screened.candidate, &c.values))?;
        Some(&column.delta / (column.values[0] - screened.candidate.parameters[0].neutral))
    };
    let slopes: Vec<Option<DVector<f64>>> = (0..elements.len()).map(slope).collect();
    let size = r.estimates.first().map_or(0.0, |e| e.value) - parameter.neutral;
    let own = r.fit.j.column(r.fit.x.len() - 1) / (parameter.bounds[1] - parameter.bounds[0]);
    let inside = slopes[..about.inside.len()].iter().flatten();
    let sum = inside.fold(DVector::zeros(r.fit.r.len()), |sum, s| sum + s);
    let share = sum.dot(&own) / own.norm_squared();
    if !(share.is_finite() && share > 0.0) {
        return Ok(Vec::new());
    }
    let change = |(k, slope): (usize, &Option<DVector<f64>>)| {
        let factor = if k < about.inside.len() { -size / share } else { size };
        slope.as_ref().map(|s| project(&beside.q, &(s * factor)))
    };
    let changes: Vec<Option<DVector<f64>>> = slopes.iter().enumerate().map(change).collect();
    let order = changing_sides(&about, &changes, beside.residual.clone());
    let names: Vec<String> = ON_THE_WAY
        .iter()
        .filter(|part| order.len() >= **part)
        .filter_map(|part| {
            let mut is_in: Vec<bool> = (0..elements.len()).map(|k| k < about.inside.len()).collect();
            order[..order.len().div_ceil(*part)].iter().for_each(|&k| is_in[k] = !is_in[k]);
            let chosen: Vec<usize> = elements.iter().zip(is_in).filter(|(_, is_in)| *is_in).map(|(&e, _)| e).collect();
            structure.region_name(&chosen)
        })
        .collect();
    if names.is_empty() {
        return Ok(Vec::new());
    }
    let placed = stage.between_candidates(&structures, candidate, &names);
    let shapes = stage.on_wider(placed)?;
    let bases = [r.fit.x.rows(0, stage.fit.x.len()).into_owned()];
    let jobs: Vec<Job<'_>> = shapes.effects.iter().map(|s| Job::Begun(s, &bases, &r.fit.x)).collect();
    Ok(run(&shapes, &jobs, base))
}

/// Elements that change sides, the one that gains most first; only what touches the other side can.
///
/// * `changes` - of the projected residual by each, none where it has no trace
fn changing_sides(about: &Neighbourhood, changes: &[Option<DVector<f64>>], mut residual: DVector<f64>) -> Vec<usize> {
    let mut is_in: Vec<bool> = (0..changes.len()).map(|k| k < about.inside.len()).collect();
    let mut order = Vec::new();
    let known: Vec<usize> = (0..changes.len()).filter(|&k| changes[k].is_some()).collect();
    let columns: Vec<DVector<f64>> = changes.iter().flatten().cloned().collect();
    if columns.is_empty() {
        return order;
    }
    let columns = DMatrix::from_columns(&columns);
    let squared: Vec<f64> = columns.column_iter().map(|c| c.norm_squared()).collect();
    while order.len() < about.inside.len().max(2) {
        let along = columns.tr_mul(&residual);
        let is_open = |k: usize| !order.contains(&k) && about.touching[k].iter().any(|&other| is_in[other] != is_in[k]);
        let left = is_in.iter().filter(|is_in| **is_in).count();
        let may = |k: usize| is_open(k) && (!is_in[k] || left > 2);
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
        order.push(k);
    }
    order
}
