//! The poly-reference least-squares complex-frequency estimator (pLSCF, "PolyMAX"): poles over a range of model orders.
//!
//! ```text
//! H_o(ω) = B_o(z) A(z)⁻¹,   A(z) = Σ A_k z^k (n_inputs x n_inputs),   z = exp(i (ω - ω_s) Δt),   real coefficients
//! ```
//!
//! The linearised error H_o A - B_o is quadratic in the coefficients, and eliminating every B_o leaves small normal
//! equations for A alone; all their blocks are sums Σ_l w_l (·) z_l^(j-k), so one table of moments serves every order.
//! A_0 = I is imposed: the poles that only fit noise then fall outside the stable half-plane, where they are dropped.
//!
//! Sources: P. Guillaume, P. Verboven, S. Vanlanduit, H. Van der Auweraer, B. Peeters, A poly-reference implementation
//! of the least-squares complex frequency-domain estimator, Proc. IMAC XXI, 2003; B. Cauberghe, P. Guillaume,
//! P. Verboven, S. Vanlanduit, E. Parloo, On the influence of the parameter constraint on the stability of the poles
//! and the discrimination capabilities of the stabilisation diagrams, Mech. Syst. Signal Process. 19, 2005.

use super::IdentifyError;
use super::band::Band;
use rayon::prelude::*;
use retune_linalg::{Complex, DMatrix, general_eigenpairs};
use std::f64::consts::PI;

/// Share of the half circle left free at each end of the band, where the mirrored spectrum of a polynomial with real
/// coefficients is not the one measured.
const MARGIN: f64 = 0.05;

/// One pole of one model order.
#[derive(Debug, Clone, PartialEq)]
pub struct Pole {
    /// λ = -ζω + iω√(1-ζ²), rad/s.
    pub value: Complex<f64>,
    /// Modal participation at the inputs, largest entry 1.
    pub participation: Vec<Complex<f64>>,
}

impl Pole {
    /// |λ|/2π, Hz.
    pub fn frequency_hz(&self) -> f64 {
        self.value.norm() / std::f64::consts::TAU
    }

    /// -Re λ/|λ|.
    pub fn damping_ratio(&self) -> f64 {
        -self.value.re / self.value.norm()
    }
}

/// Sums over lines: Σ w z^d, Σ w H z^d, Σ w H_i* H_j z^d, for d = 0 .. n and the negative d by conjugation.
struct Moments {
    /// Per output: Re Σ w z^d (even in d).
    r: Vec<Vec<f64>>,
    /// Per output and input: Σ w Re(H) cos, Σ w Im(H) sin for each d.
    s: Vec<Vec<(f64, f64)>>,
    /// Summed over outputs, per (i, j): the same two sums for H_i* H_j.
    t: Vec<Vec<(f64, f64)>>,
    /// Whether all outputs share `r[0]`.
    r_is_common: bool,
}

/// Poles inside the band and the stable half-plane for every model order in `orders` (degrees of A(z), ascending).
pub(super) fn poles_by_order(band: &Band, orders: &[usize]) -> Result<Vec<Vec<Pole>>, IdentifyError> {
    let Some(&n_max) = orders.last() else { return Ok(Vec::new()) };
    let needed = 2 * (n_max + 1);
    if band.n_lines() < needed {
        return Err(IdentifyError::TooFewLines { found: band.n_lines(), needed });
    }
    let (first, last) = (band.omega[0], band.omega[band.n_lines() - 1]);
    let width = (last - first) / (1.0 - 2.0 * MARGIN);
    let axis = Axis { shift: (first - MARGIN * width).max(0.0), step: 0.0 };
    let axis = Axis { step: PI / (last + MARGIN * width - axis.shift), ..axis };
    let moments = Moments::new(band, &axis, n_max);
    let found: Vec<Result<Vec<Pole>, IdentifyError>> =
        orders.par_iter().map(|&n| poles_of_order(band, &moments, &axis, n)).collect();
    found.into_iter().collect()
}

/// z = exp(i (ω - shift) step).
struct Axis {
    shift: f64,
    step: f64,
}

impl Moments {
    fn new(band: &Band, axis: &Axis, n: usize) -> Self {
        let (n_l, n_i, n_o) = (band.n_lines(), band.n_inputs(), band.n_outputs());
        // Rows: cos(d φ_l) and sin(d φ_l).
        let phase: Vec<f64> = band.omega.iter().map(|w| (w - axis.shift) * axis.step).collect();
        let cos = DMatrix::from_fn(n + 1, n_l, |d, l| (d as f64 * phase[l]).cos());
        let sin = DMatrix::from_fn(n + 1, n_l, |d, l| (d as f64 * phase[l]).sin());
        let weights: Vec<Vec<f64>> = (0..n_o)
            .map(|o| {
                let level = 1.0 / band.roughness[o].max(f64::MIN_POSITIVE).powi(2);
                (0..n_l)
                    .map(|l| {
                        let v: f64 = (0..n_i).filter_map(|i| band.variance_of(o, i)).map(|v| v[l]).sum();
                        if v > 0.0 { n_i as f64 / v } else { level }
                    })
                    .collect()
            })
            .collect();
        let r_is_common = band.variance.is_none();
        let r = (0..if r_is_common { 1 } else { n_o })
            .map(|o| {
                let w = retune_linalg::DVector::from_fn(n_l, |l, _| if r_is_common { 1.0 } else { weights[o][l] });
                (&cos * w).as_slice().to_vec()
            })
            .collect();
        // Without line weights an output is scaled as a whole, so that R is the same for all.
        let scale = |o: usize, l: usize| if r_is_common { weights[o][l].sqrt() } else { weights[o][l] };
        let mut re = DMatrix::zeros(n_l, n_o * n_i);
        let mut im = DMatrix::zeros(n_l, n_o * n_i);
        for o in 0..n_o {
            for i in 0..n_i {
                for (l, h) in band.function(o, i).iter().enumerate() {
                    (re[(l, o * n_i + i)], im[(l, o * n_i + i)]) = (h.re * scale(o, l), h.im * scale(o, l));
                }
            }
        }
        let pairs = |a: &DMatrix<f64>, b: &DMatrix<f64>| -> Vec<Vec<(f64, f64)>> {
            let (c, s) = (&cos * a, &sin * b);
            (0..a.ncols()).map(|k| (0..=n).map(|d| (c[(d, k)], s[(d, k)])).collect()).collect()
        };
        let s = pairs(&re, &im);
        let mut product_re = DMatrix::zeros(n_l, n_i * n_i);
        let mut product_im = DMatrix::zeros(n_l, n_i * n_i);
        for o in 0..n_o {
            for i in 0..n_i {
                for j in 0..n_i {
                    let (a, b) = (band.function(o, i), band.function(o, j));
                    for l in 0..n_l {
                        let x = a[l].conj() * b[l] * weights[o][l];
                        product_re[(l, i * n_i + j)] += x.re;
                        product_im[(l, i * n_i + j)] += x.im;
                    }
                }
            }
        }
        Self { r, s, t: pairs(&product_re, &product_im), r_is_common }
    }
}

/// Re Σ x z^d from Σ Re(x) cos(|d|φ) and Σ Im(x) sin(|d|φ).
fn moment(table: &[(f64, f64)], d: isize) -> f64 {
    let (c, s) = table[d.unsigned_abs()];
    if d >= 0 { c - s } else { c + s }
}

fn poles_of_order(band: &Band, m: &Moments, axis: &Axis, n: usize) -> Result<Vec<Pole>, IdentifyError> {
    let n_i = band.n_inputs();
    let size = n_i * (n + 1);
    let block = |k: usize| (k / n_i, k % n_i);
    // M = Σ_o (T_o - S_oᵀ R_o⁻¹ S_o)
    let mut normal = DMatrix::from_fn(size, size, |a, b| {
        let ((k, i), (l, j)) = (block(a), block(b));
        moment(&m.t[i * n_i + j], l as isize - k as isize)
    });
    let factor = |o: usize| {
        let r = &m.r[o];
        // The ridge keeps Cholesky alive where the lines leave part of the circle empty; 1e-12 is rounding level here.
        DMatrix::from_fn(n + 1, n + 1, |k, l| r[k.abs_diff(l)] + if k == l { 1e-12 * r[0] } else { 0.0 }).cholesky()
    };
    let singular = || IdentifyError::Singular { what: "normal equations of the matrix fraction" };
    let common = if m.r_is_common { Some(factor(0).ok_or_else(singular)?) } else { None };
    for o in 0..band.n_outputs() {
        let own;
        let cholesky = if let Some(c) = &common {
            c
        } else {
            own = factor(o).ok_or_else(singular)?;
            &own
        };
        let s = DMatrix::from_fn(n + 1, size, |k, b| {
            let (l, j) = block(b);
            moment(&m.s[o * n_i + j], l as isize - k as isize)
        });
        let u = cholesky.l_dirty().solve_lower_triangular(&s).ok_or_else(singular)?;
        normal.gemm_tr(-1.0, &u, &u, 1.0);
    }
    // A_0 = I: M_rr α_r = -M_r0.
    let rest = size - n_i;
    let mut m_rr = normal.view((n_i, n_i), (rest, rest)).into_owned();
    let ridge = 1e-14 * m_rr.diagonal().amax();
    for k in 0..rest {
        m_rr[(k, k)] += ridge;
    }
    let rhs = -normal.view((n_i, 0), (rest, n_i)).into_owned();
    let alpha = match m_rr.clone().cholesky() {
        Some(c) => c.solve(&rhs),
        None => m_rr.lu().solve(&rhs).ok_or_else(singular)?,
    };
    // uᵀ A(z) = 0 with y = 1/z: yⁿ u + Σ_k y^(n-k) A_kᵀ u = 0, a companion matrix of A_kᵀ.
    let companion = DMatrix::from_fn(rest, rest, |a, b| {
        if a < n_i {
            -alpha[(b, a)]
        } else if a - n_i == b {
            1.0
        } else {
            0.0
        }
    });
    let pairs = general_eigenpairs(&companion)?;
    let (low, high) = (band.omega[0], band.omega[band.n_lines() - 1]);
    let mut poles = Vec::new();
    for (j, y) in pairs.values.iter().enumerate() {
        if y.norm() < 1e-9 || y.im == 0.0 {
            continue;
        }
        let value = -y.ln() / axis.step + Complex::new(0.0, axis.shift);
        // One of each conjugate pair on the shifted axis; unstable poles fit noise.
        if value.im <= axis.shift || value.re >= 0.0 || value.norm() < low || value.norm() > high {
            continue;
        }
        let tail = pairs.vectors.view((rest - n_i, j), (n_i, 1));
        let pivot = tail.iter().copied().max_by(|a, b| a.norm().total_cmp(&b.norm())).unwrap_or_default();
        if pivot.norm() > 0.0 {
            poles.push(Pole { value, participation: tail.iter().map(|x| x / pivot).collect() });
        }
    }
    poles.sort_by(|a, b| a.value.norm().total_cmp(&b.value.norm()));
    Ok(poles)
}
