//! How much ordinary scatter there is, and how large the best score of a whole catalogue would be by chance.
//!
//! Under "nothing is missing" the projected residual is r' = (I - QQᵀ) n, n ~ N(0, s2 I). So its null distribution needs no
//! evaluation of the model: draws of n, projected, give that of any statistic of r'.
//!
//! * scatter: the median over channels (sensors; frequencies are one channel) of the mean square of what lies outside base
//!   and catalogue, over its median in the draws, at least 1. A median is not moved by one faulty channel. Where it is too large and
//!   the whole residual is even over modes, sensors and kinds of data, as noise is and physics is not, the mean square of that, which
//!   scatters less.
//! * whiteness: the correlation of neighbouring sensors in the same part. Noise has none; physics outside the catalogue has.
//!   Only white scatter counts as noise: otherwise s2 stays 1 and the misfit stays unexplained.
//! * alarm: the probability that the best score over all candidates and faults is as large as observed.

use super::effects::Directions;
use super::traces::Trace;
use crate::problem::evidence::degrees_of_freedom;
use crate::problem::fit::{Fit, mac, project};
use crate::problem::scene::Scene;
use crate::thresholds::{DRAWS, EVEN, EXCESS};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use retune::fault::Tests;
use retune::linalg::{DMatrix, DVector, thin_svd};
use retune::optim::Draw;
use std::collections::BTreeSet;

/// Share of the largest singular value from which directions are spanned.
const SPANNED: f64 = 1e-8;

/// Unit noise on the noisy rows, the same for the same draw.
fn noise(noisy: &[bool], seed: u64, draw: usize) -> DVector<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(draw as u64);
    DVector::from_fn(noisy.len(), |i, _| if noisy[i] { rng.normal() } else { 0.0 })
}

/// P(statistic >= observed) with the observed one among the draws: never zero.
pub(crate) fn p_value(draws: &[f64], observed: f64) -> f64 {
    (1 + draws.iter().filter(|&&v| v >= observed).count()) as f64 / (1 + draws.len()) as f64
}

/// What the scatter looks like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scatter {
    /// s2, at least 1.
    pub(crate) s2: f64,
    /// Probability of as much correlation between neighbouring sensors, if it were noise.
    pub(crate) whiteness_p: f64,
}

/// Estimates the scatter, from what lies outside the span of base and catalogue where it is not even.
///
/// The catalogue's columns at their typical sizes span almost everything; directions in which it moves the residual by
/// less than one standard deviation are left out, and never more than half of the degrees of freedom are spanned.
pub(crate) fn scatter(scene: &Scene, fit: &Fit, q: &DMatrix<f64>, directions: &Directions, seed: u64) -> Scatter {
    let none = Scatter { s2: 1.0, whiteness_p: 1.0 };
    let mut noisy = fit.noisy_rows();
    let channels = channels(fit, &noisy);
    if scene.has_functions() {
        // They are no channel here: without them the greater part of the work falls away.
        let of_channels: BTreeSet<usize> = channels.iter().flatten().copied().collect();
        noisy.iter_mut().enumerate().for_each(|(row, is)| *is &= of_channels.contains(&row));
    }
    let told: Vec<usize> = (0..noisy.len()).filter(|&row| noisy[row]).collect();
    let on_told = |a: &DMatrix<f64>| a.select_rows(&told);
    let dof = told.len().saturating_sub(q.ncols());
    if dof < 10 {
        return none;
    }
    let mut span = on_told(q);
    if directions.unit.ncols() > 0 {
        let mut scaled = on_told(&directions.unit);
        for (mut c, l) in scaled.column_iter_mut().zip(&directions.length) {
            c *= l.min(20.0);
        }
        let Ok(svd) = thin_svd(&scaled) else { return none };
        let rank = svd.values.iter().take_while(|v| **v > 1.0).count().min(dof / 2);
        let first = span.ncols();
        span = span.resize_horizontally(first + rank, 0.0);
        span.columns_mut(first, rank).copy_from(&svd.left.columns(0, rank));
    }
    // On these rows alone the directions need not be orthonormal.
    let Ok(parts) = thin_svd(&span) else { return none };
    let basis = parts.left.columns(0, parts.rank(SPANNED));
    let mut span = DMatrix::zeros(fit.r.len(), basis.ncols());
    told.iter().enumerate().for_each(|(i, &row)| span.row_mut(row).copy_from(&basis.row(i)));
    let neighbours = neighbours(scene);
    let observed = project(&span, &fit.r);
    let draws: Vec<(f64, f64)> = (0..DRAWS)
        .into_par_iter()
        .map(|d| {
            let n = project(&span, &noise(&noisy, seed, d));
            (median_square(&n, &channels), correlation(fit, &n, &neighbours))
        })
        .collect();
    let mut medians: Vec<f64> = draws.iter().map(|d| d.0).collect();
    medians.sort_by(f64::total_cmp);
    let (centre, median) = (medians[DRAWS / 2], median_square(&observed, &channels));
    // Inside the scatter of the estimate itself there is no reason to inflate.
    let excess = p_value(&medians, median) < EXCESS;
    let ratio = if excess && evenness(fit, q, seed) > EVEN {
        fit.r.rows(0, fit.rows.measured).norm_squared() / degrees_of_freedom(fit, q).max(1.0)
    } else if centre > 0.0 {
        median / centre
    } else {
        1.0
    };
    let correlations: Vec<f64> = draws.iter().map(|d| d.1).collect();
    let whiteness_p = p_value(&correlations, correlation(fit, &observed, &neighbours));
    let s2 = if excess && whiteness_p > 0.01 { ratio.max(1.0) } else { 1.0 };
    Scatter { s2, whiteness_p }
}

/// The pair of shapes that agrees least, beside what noise does to it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct WorstShape {
    pub(crate) mode: usize,
    /// MAC of the pair.
    pub(crate) mac: f64,
    /// What noise leaves of it at least, in all but one of the draws.
    pub(crate) least: f64,
    /// P of a pair that agrees as little, among all, if it were noise.
    pub(crate) p_value: f64,
}

/// Compares the MAC of every pair with that of the fitted shape and the same shape with noise. None where no pair has shapes.
///
/// ```text
/// d_m = (1 - MAC_m)/mean of 1 - MAC_m over the draws,     statistic: the largest d_m of all modes
/// ```
///
/// * `weight` - the stated standard deviation over that of the noise
pub(crate) fn worst_shape(fit: &Fit, weight: f64, seed: u64) -> Option<WorstShape> {
    /// Entries of a shape below which its MAC is one whatever it is.
    const FEWEST: usize = 2;
    let shapes: Vec<(usize, Vec<[f64; 3]>)> = (0..fit.rows.n_modes)
        .filter(|_| fit.rows.has_shapes)
        .filter_map(|m| {
            let entry = |s: usize| [fit.shapes[(s, m)], fit.test_shapes[(s, m)], fit.inverse_sd[(s, m)]];
            let own: Vec<[f64; 3]> = (0..fit.rows.n_sensors).map(entry).filter(|e| e[2] > 0.0).collect();
            let is_seen = own.iter().any(|e| e[0] != 0.0) && own.iter().any(|e| e[1] != 0.0);
            (own.len() >= FEWEST && is_seen).then_some((m, own))
        })
        .collect();
    // The fitted shape in the scale of the test.
    let scaled = |own: &[[f64; 3]]| -> Vec<[f64; 2]> {
        let (cross, sum) = own
            .iter()
            .fold((0.0, 0.0), |(c, o), [model, test, w]| (c + model * test * w * w, o + model * model * w * w));
        own.iter().map(|[model, _, w]| [model * cross / sum, 1.0 / (w * weight)]).collect()
    };
    let expected: Vec<Vec<[f64; 2]>> = shapes.iter().map(|(_, own)| scaled(own)).collect();
    let draws: Vec<Vec<f64>> = (0..DRAWS)
        .into_par_iter()
        .map(|draw| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(draw as u64);
            let of =
                |shape: &Vec<[f64; 2]>| 1.0 - mac(shape.iter().map(|[value, sd]| (*value, value + sd * rng.normal())));
            expected.iter().map(of).collect()
        })
        .collect();
    let means: Vec<f64> = (0..shapes.len()).map(|k| draws.iter().map(|d| d[k]).sum::<f64>() / DRAWS as f64).collect();
    let largest = |d: &Vec<f64>| d.iter().zip(&means).map(|(d, mean)| d / mean).fold(0.0, f64::max);
    let mut by_chance: Vec<f64> = draws.iter().map(largest).collect();
    by_chance.sort_by(f64::total_cmp);
    let of_pair = |(k, (mode, own)): (usize, &(usize, Vec<[f64; 3]>))| {
        let mac = mac(own.iter().map(|[model, test, _]| (*model, *test)));
        ((1.0 - mac) / means[k], *mode, mac, means[k])
    };
    let (worst, mode, mac, mean) = shapes.iter().enumerate().map(of_pair).max_by(|a, b| a.0.total_cmp(&b.0))?;
    let least = (1.0 - mean * by_chance.get(DRAWS - 2)?).max(0.0);
    Some(WorstShape { mode, mac, least, p_value: p_value(&by_chance, worst) })
}

/// P of the correlation of neighbouring sensors in a projected residual.
pub(crate) fn whiteness(scene: &Scene, fit: &Fit, q: &DMatrix<f64>, seed: u64) -> f64 {
    let noisy = fit.noisy_rows();
    let neighbours = neighbours(scene);
    if neighbours.is_empty() || !fit.rows.has_shapes {
        return 1.0;
    }
    let draws: Vec<f64> = (0..DRAWS)
        .into_par_iter()
        .map(|d| correlation(fit, &project(q, &noise(&noisy, seed, d)), &neighbours))
        .collect();
    p_value(&draws, correlation(fit, &project(q, &fit.r), &neighbours))
}

/// P of as uneven a projected residual: larger noise than stated is larger everywhere, physics shows in some modes or sensors more than
/// in others.
///
/// ```text
/// D = Σ_g n_g (m_g/m - 1)²     m_g the mean square of group g of n_g rows, m that of all
/// ```
///
/// The groups are the modes, the sensors with the frequencies as one more, and frequencies against shapes; the smallest of the three.
fn evenness(fit: &Fit, q: &DMatrix<f64>, seed: u64) -> f64 {
    let noisy = fit.noisy_rows();
    let modes: Vec<Vec<usize>> = (0..fit.rows.n_modes).map(|m| fit.mode_rows(m)).collect();
    let sensors = channels(fit, &noisy);
    let kinds = kinds(fit, &noisy).to_vec();
    let groups: Vec<Vec<Vec<usize>>> =
        [modes, sensors, kinds].into_iter().filter(|g| g.iter().filter(|rows| !rows.is_empty()).count() > 1).collect();
    let of = |r: &DVector<f64>| -> Vec<f64> { groups.iter().map(|g| dispersion(r, g)).collect() };
    let draws: Vec<Vec<f64>> = (0..DRAWS).into_par_iter().map(|d| of(&project(q, &noise(&noisy, seed, d)))).collect();
    let observed = of(&project(q, &fit.r));
    let each = observed.iter().enumerate().map(|(k, v)| {
        let draws: Vec<f64> = draws.iter().map(|d| d[k]).collect();
        p_value(&draws, *v)
    });
    let least = each.fold(1.0, f64::min);
    (least * groups.len() as f64).min(1.0)
}

/// Σ_g n_g (m_g/m - 1)².
fn dispersion(r: &DVector<f64>, groups: &[Vec<usize>]) -> f64 {
    let sums: Vec<f64> = groups.iter().map(|g| g.iter().map(|&i| r[i] * r[i]).sum()).collect();
    let rows: usize = groups.iter().map(Vec::len).sum();
    let mean = sums.iter().sum::<f64>() / rows as f64;
    if mean > 0.0 {
        let each = sums.iter().zip(groups).filter(|(_, g)| !g.is_empty());
        each.map(|(s, g)| g.len() as f64 * (s / (g.len() as f64 * mean) - 1.0).powi(2)).sum()
    } else {
        0.0
    }
}

/// Rows of the frequencies, of each sensor over all modes, and of the static readings, as far as there are any.
fn channels(fit: &Fit, noisy: &[bool]) -> Vec<Vec<usize>> {
    let [frequencies, shapes, statics] = kinds(fit, noisy);
    let of_sensor =
        |s: usize| shapes.iter().copied().filter(move |&i| (i - fit.rows.n_modes) % fit.rows.n_sensors == s);
    let sensors = (0..fit.rows.n_sensors).map(|s| of_sensor(s).collect());
    std::iter::once(frequencies).chain(sensors).chain([statics]).filter(|c: &Vec<usize>| !c.is_empty()).collect()
}

/// Rows of the frequencies, of the shapes, and of the static readings.
fn kinds(fit: &Fit, noisy: &[bool]) -> [Vec<usize>; 3] {
    let rows = fit.rows;
    let end = if rows.has_shapes { rows.shape(rows.n_modes, 0) } else { rows.n_modes };
    let shapes = (rows.n_modes..end).filter(|&i| noisy[i]).collect();
    [(0..rows.n_modes).collect(), shapes, fit.statics.iter().map(|s| s.row).collect()]
}

fn median_square(r: &DVector<f64>, channels: &[Vec<usize>]) -> f64 {
    let mut means: Vec<f64> =
        channels.iter().map(|c| c.iter().map(|&i| r[i] * r[i]).sum::<f64>() / c.len() as f64).collect();
    means.sort_by(f64::total_cmp);
    means.get(means.len() / 2).copied().unwrap_or(0.0)
}

/// Pairs (sensor, nearest sensor of about the same direction).
fn neighbours(scene: &Scene) -> Vec<(usize, usize)> {
    let sensors = &scene.test.sensors;
    let Ok(at) = scene.sensor_positions() else { return Vec::new() };
    let parallel = |a: usize, b: usize| {
        let dot: f64 = (0..3).map(|k| sensors[a].direction[k] * sensors[b].direction[k]).sum();
        dot.abs() > 0.9 && sensors[a].is_rotation == sensors[b].is_rotation
    };
    let distance = |a: usize, b: usize| (0..3).map(|k| (at[a][k] - at[b][k]).powi(2)).sum::<f64>();
    let mut pairs: Vec<(usize, usize)> = (0..sensors.len())
        .filter_map(|s| {
            (0..sensors.len())
                .filter(|&o| o != s && parallel(s, o) && scene.are_together(s, o))
                .min_by(|&a, &b| distance(s, a).total_cmp(&distance(s, b)).then(a.cmp(&b)))
                .map(|o| (s.min(o), s.max(o)))
        })
        .collect();
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// Σ e_i e_j over neighbours and modes, over Σ e², positive for smooth fields.
fn correlation(fit: &Fit, r: &DVector<f64>, neighbours: &[(usize, usize)]) -> f64 {
    if !fit.rows.has_shapes {
        return 0.0;
    }
    let (mut cross, mut own) = (0.0, 0.0);
    for m in 0..fit.rows.n_modes {
        for &(a, b) in neighbours {
            let (x, y) = (r[fit.rows.shape(m, a)], r[fit.rows.shape(m, b)]);
            cross += x * y;
            own += 0.5 * (x * x + y * y);
        }
    }
    if own > 0.0 { cross / own } else { 0.0 }
}

/// The null distribution of the best score over all directions and faults.
pub(crate) fn best_scores(
    fit: &Fit,
    q: &DMatrix<f64>,
    directions: &Directions,
    traces: &[Trace],
    seed: u64,
) -> Vec<f64> {
    let noisy = fit.noisy_rows();
    let draw = |d: usize| project(q, &noise(&noisy, seed, d));
    let blocks: Vec<DMatrix<f64>> = (0..DRAWS / BLOCK)
        .into_par_iter()
        .map(|b| DMatrix::from_columns(&(b * BLOCK..(b + 1) * BLOCK).map(draw).collect::<Vec<_>>()))
        .collect();
    let mut best = vec![0.0_f64; DRAWS];
    let mut raise = |catalogue: &DMatrix<f64>, score: &(dyn Fn(usize, f64) -> f64 + Sync)| {
        best.par_chunks_mut(BLOCK).zip(&blocks).for_each(|(best, draws)| {
            let along = catalogue * draws;
            for (best, along) in best.iter_mut().zip(along.column_iter()) {
                *best = along.iter().enumerate().map(|(c, &v)| score(c, v)).fold(*best, f64::max);
            }
        });
    };
    raise(&directions.unit.transpose(), &|c, v| if directions.one_sided[c] && v > 0.0 { 0.0 } else { v * v });
    let (linear, others): (Vec<&Trace>, Vec<&Trace>) = traces.iter().partition(|t| t.direction().is_some());
    for some in linear.chunks(AT_ONCE) {
        let unit: Vec<&DVector<f64>> = some.iter().filter_map(|t| t.direction()).collect();
        let squares: Vec<f64> = unit.iter().map(|d| d.norm_squared()).collect();
        let catalogue = DMatrix::from_fn(unit.len(), noisy.len(), |i, j| unit[i][j]);
        raise(&catalogue, &|c, v| some[c].score_along(v, squares[c]));
    }
    best.par_chunks_mut(BLOCK).zip(&blocks).for_each(|(best, draws)| {
        for (best, r) in best.iter_mut().zip(draws.column_iter()) {
            let r = r.into_owned();
            *best = others.iter().map(|t| t.score(&r)).fold(*best, f64::max);
        }
    });
    best
}

/// Draws that share one product with the catalogue.
const BLOCK: usize = 50;
/// Traces of faults in one product: beside them a large test would need their memory once more.
const AT_ONCE: usize = 512;
