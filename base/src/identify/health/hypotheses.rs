//! Which single fault would make a set of shapes fit a prior best?
//!
//! The prior says that the entries of a shape, in the order of the sensors, have a small quadratic form J = Σ_m φ_mᵀ B φ_m:
//! B measures roughness over the structure, or the distance from rigid-body motion. A fault is an edit of the entries, and
//!
//! ```text
//! ln L(edit) = max_λ [ -N/2 ln J_λ(edited) - M/2 ln det_λ + M ln |s| ],     N = M · rank B
//! ```
//! (the last term for an entry scaled by s; an entry dropped pays the width of a broad prior) compares it with no fault. Under the prior a likelihood ratio above c has a
//! probability of at most 1/c, so with H edits tried, one is accepted at ln LR > ln(H/α). Shapes of one structure are not
//! independent draws; ln LR is halved for that ([`TEMPER`]), and α is 1 %.

use retune_linalg::DMatrix;

/// Factor of the log-likelihood ratio, for shapes that depend on each other.
const TEMPER: f64 = 0.5;

/// Chance of a false alarm in one search under the prior.
const ALPHA: f64 = 0.01;

/// An edit of the entries that undoes a fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Edit {
    /// Entry k of every shape changes sign.
    Flip(usize),
    /// Entries of two sensors change places.
    Swap(usize, usize),
    /// Entry k of every shape is multiplied by a factor.
    Scale(usize, f64),
    /// Entry k carries no information.
    Drop(usize),
}

/// The prior at one noise level.
pub(super) struct Prior {
    /// B, (n x n), symmetric, positive semidefinite.
    pub(super) b: DMatrix<f64>,
    /// ln det of the covariance behind it.
    pub(super) ln_det: f64,
    /// Rank of B.
    pub(super) rank: usize,
}

/// Evidence by which an edit of other sensors may fall short of the best one and still be named beside it: tempered odds of 20.
const RIVAL: f64 = 1.5;

impl Edit {
    /// The sensors that it touches.
    pub(super) fn touches(self) -> Vec<usize> {
        match self {
            Edit::Flip(k) | Edit::Scale(k, _) | Edit::Drop(k) => vec![k],
            Edit::Swap(k, l) => vec![k, l],
        }
    }
}

/// An accepted edit with its tempered log-likelihood ratio.
#[derive(Debug, Clone)]
pub(super) struct Accepted {
    pub(super) edit: Edit,
    pub(super) evidence: f64,
    /// What has to be exceeded.
    pub(super) threshold: f64,
    /// Edits of other sensors that are nearly as likely, best first.
    pub(super) rivals: Vec<Edit>,
}

/// Accepts the best edit, applies it, and goes on, up to a quarter of the sensors. Returns the edits, and for each sensor whether
/// a wrong sign of it would have been seen.
pub(super) fn search(priors: &[Prior], shapes: &DMatrix<f64>) -> (Vec<Accepted>, Vec<bool>) {
    let n = shapes.nrows();
    let mut phi = shapes.clone();
    for mut column in phi.column_iter_mut() {
        let norm = column.norm();
        if norm > 0.0 {
            column /= norm;
        }
    }
    let threshold = ((3 * n + n * n.saturating_sub(1) / 2) as f64 / ALPHA).ln();
    let mut accepted: Vec<Accepted> = Vec::new();
    while accepted.len() < n.div_ceil(4) {
        let ranked = ranked(priors, &phi);
        let Some(&(edit, evidence)) = ranked.first() else { break };
        if evidence <= threshold {
            break;
        }
        let own = edit.touches();
        let mut rivals: Vec<Edit> = Vec::new();
        for (other, _) in ranked.iter().take_while(|(_, e)| *e > evidence - RIVAL) {
            let touched = other.touches();
            if touched.iter().all(|k| !own.contains(k)) && rivals.iter().all(|r| r.touches() != touched) {
                rivals.push(*other);
            }
        }
        accepted.push(Accepted { edit, evidence, threshold, rivals });
        apply(priors, &mut phi, edit);
    }
    let now = likelihood(priors, &phi);
    let is_visible = (0..n)
        .map(|k| {
            let mut flipped = phi.clone();
            flipped.row_mut(k).neg_mut();
            TEMPER * (now - likelihood(priors, &flipped)) > threshold
        })
        .collect();
    (accepted, is_visible)
}

fn energy(prior: &Prior, phi: &DMatrix<f64>) -> f64 {
    (&prior.b * phi).component_mul(phi).sum()
}

fn log_likelihood(prior: &Prior, energy: f64, m: usize) -> f64 {
    // Shapes are never known better than 1e-4: below that J is rounding or coincidence.
    let n = (m * prior.rank) as f64;
    -0.5 * n * energy.max(1e-8 * m as f64 * prior.b.trace() / prior.b.nrows() as f64).ln()
        - 0.5 * m as f64 * prior.ln_det
}

fn likelihood(priors: &[Prior], phi: &DMatrix<f64>) -> f64 {
    priors.iter().map(|p| log_likelihood(p, energy(p, phi), phi.ncols())).fold(f64::NEG_INFINITY, f64::max)
}

/// All edits with their tempered evidence, best first.
fn ranked(priors: &[Prior], phi: &DMatrix<f64>) -> Vec<(Edit, f64)> {
    let (n, m) = phi.shape();
    let mut ranked: Vec<(Edit, f64)> = Vec::new();
    let mut note = |at: usize, edit: Edit, value: f64| {
        if at == ranked.len() {
            ranked.push((edit, value));
        } else if value > ranked[at].1 {
            ranked[at] = (edit, value);
        }
    };
    for p in priors {
        let b_phi = &p.b * phi;
        let j = b_phi.component_mul(phi).sum();
        let value = |energy: f64| log_likelihood(p, energy, m);
        let mut at = 0;
        for k in 0..n {
            let bkk = p.b[(k, k)].max(f64::MIN_POSITIVE);
            let cross = b_phi.row(k).dot(&phi.row(k));
            let own = phi.row(k).norm_squared();
            let scaled = |s: f64| j + 2.0 * (s - 1.0) * cross + (s - 1.0).powi(2) * own * bkk;
            note(at, Edit::Flip(k), value(scaled(-1.0)));
            let s = if own > 0.0 { 1.0 - cross / (own * bkk) } else { 1.0 };
            // A factor below 1.3 is within what positions and curvature can do.
            let is_gain = s.abs() > 1e-3 && !(1.0 / 1.3..1.3).contains(&s.abs());
            let gain = value(scaled(s)) + m as f64 * s.abs().max(1e-3).ln() - 0.5 * ((m * p.rank) as f64).ln();
            note(at + 1, Edit::Scale(k, s), if is_gain { gain } else { f64::NEG_INFINITY });
            let dropped = j - b_phi.row(k).norm_squared() / bkk;
            // An entry that may be anything has the density of a broad prior: as wide as the entries are, against the
            // scatter that the prior gives it.
            let scatter = (dropped.max(f64::MIN_POSITIVE) / ((m * p.rank) as f64 * bkk)).sqrt();
            let width = (own / m as f64).max(1.0 / n as f64).sqrt();
            let occam = (width / scatter).ln().max(0.5 * ((m * p.rank) as f64).ln());
            note(at + 2, Edit::Drop(k), value(dropped) - m as f64 * occam);
            at += 3;
        }
        for k in 0..n {
            for l in 0..k {
                let d = phi.row(l) - phi.row(k);
                let change = 2.0 * d.dot(&(b_phi.row(k) - b_phi.row(l)))
                    + d.norm_squared() * (p.b[(k, k)] + p.b[(l, l)] - 2.0 * p.b[(k, l)]);
                note(at, Edit::Swap(k, l), value(j + change));
                at += 1;
            }
        }
    }
    let now = likelihood(priors, phi);
    let mut ranked: Vec<(Edit, f64)> = ranked.into_iter().map(|(e, v)| (e, TEMPER * (v - now))).collect();
    ranked.sort_by(|a, b| b.1.total_cmp(&a.1));
    ranked
}

fn apply(priors: &[Prior], phi: &mut DMatrix<f64>, edit: Edit) {
    match edit {
        Edit::Flip(k) => phi.row_mut(k).neg_mut(),
        Edit::Swap(k, l) => phi.swap_rows(k, l),
        Edit::Scale(k, s) => phi.row_mut(k).scale_mut(s),
        Edit::Drop(k) => {
            // The entry that the others predict, at the likeliest noise level.
            let level = priors.iter().max_by(|a, b| {
                let l = |p: &Prior| log_likelihood(p, energy(p, phi), phi.ncols());
                l(a).total_cmp(&l(b))
            });
            if let Some(p) = level {
                let predicted = phi.row(k) - (&p.b * &*phi).row(k) / p.b[(k, k)].max(f64::MIN_POSITIVE);
                phi.row_mut(k).copy_from(&predicted);
            }
        }
    }
}
