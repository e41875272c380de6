//! How far a complex shape is from a real one, and real normal modes from complex ones.
//!
//! Entries that are NaN (a sensor that did not measure) are left out everywhere.

use super::IdentifyError;
use retune_linalg::{Complex, DMatrix, DVector, general_eigenpairs};

/// Measures of the complexity of a shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Complexity {
    /// Modal phase collinearity in [0, 1]: 1 for a shape whose entries lie on one line through the origin.
    pub mpc: f64,
    /// Mean phase: angle of that line, rad, in (-π/2, π/2].
    pub mean_phase: f64,
    /// Mean phase deviation from the line, weighted by modulus, degrees, in [0, 45].
    pub mean_phase_deviation_deg: f64,
    /// Norm across the line over norm along it, in [0, 1].
    pub imaginary_ratio: f64,
}

/// Complexity of a shape.
///
/// ```text
/// S = Σ [Re² , Re Im; Re Im, Im²],  eigenvalues λ1 >= λ2:   MPC = ((λ1-λ2)/(λ1+λ2))²,   ratio = √(λ2/λ1)
/// ```
/// A zero shape has MPC 0 and ratio 1. Sources: R. S. Pappa, K. B. Elliott, A. Schenk, Consistent-mode indicator for
/// the eigensystem realization algorithm, J. Guid. Control Dyn. 16, 1993 (MPC); E. Reynders, J. Houbrechts,
/// G. De Roeck, Fully automated (operational) modal analysis, Mech. Syst. Signal Process. 29, 2012 (mean phase deviation).
pub fn complexity(shape: &DVector<Complex<f64>>) -> Complexity {
    let (phase, major, minor) = principal_axis(shape);
    let total = major + minor;
    if total <= 0.0 {
        return Complexity { mpc: 0.0, mean_phase: 0.0, mean_phase_deviation_deg: 45.0, imaginary_ratio: 1.0 };
    }
    let turn = Complex::from_polar(1.0, -phase);
    let (mut deviation, mut weight) = (0.0, 0.0);
    for x in shape.iter().filter(|x| x.is_finite() && x.norm() > 0.0) {
        let y = x * turn;
        deviation += x.norm() * y.im.abs().atan2(y.re.abs());
        weight += x.norm();
    }
    Complexity {
        mpc: ((major - minor) / total).powi(2),
        mean_phase: phase,
        mean_phase_deviation_deg: (deviation / weight).to_degrees(),
        imaginary_ratio: (minor / major).max(0.0).sqrt(),
    }
}

/// Angle of the least-squares line through the entries and the sums of squares along and across it.
fn principal_axis(shape: &DVector<Complex<f64>>) -> (f64, f64, f64) {
    let (mut power, mut square) = (0.0, Complex::new(0.0, 0.0));
    for x in shape.iter().filter(|x| x.is_finite()) {
        power += x.norm_sqr();
        square += x * x;
    }
    // Σ Re(x e^-iφ)² = (power + Re(square e^-2iφ))/2 is largest at φ = arg(square)/2.
    (0.5 * square.arg(), 0.5 * (power + square.norm()), 0.5 * (power - square.norm()))
}

/// The real shape nearest to a complex one: turned by the phase that makes its real part largest, imaginary part dropped.
///
/// ```text
/// φ_n = Re(ψ e^-iθ),   θ = ½ arg Σ ψ_o²
/// ```
/// The sign makes the entry of largest modulus positive. Exact for proportional damping.
pub fn real_shape(shape: &DVector<Complex<f64>>) -> DVector<f64> {
    let turn = Complex::from_polar(1.0, -principal_axis(shape).0);
    let real = shape.map(|x| (x * turn).re);
    let largest =
        real.iter().copied().filter(|x| x.is_finite()).fold(0.0, |a: f64, x| if x.abs() > a.abs() { x } else { a });
    if largest < 0.0 { -real } else { real }
}

/// Normal modes of the undamped structure behind a set of complex modes.
#[derive(Debug, Clone, PartialEq)]
pub struct NormalModes {
    /// Undamped natural frequencies, Hz, ascending.
    pub frequencies_hz: Vec<f64>,
    /// Real shapes at the sensors (sensors x modes), largest entry 1.
    pub shapes: DMatrix<f64>,
}

/// Normal modes from complex modes by way of M⁻¹K, for damping that is not proportional.
///
/// In the m-dimensional subspace that the m shapes span best (singular vectors of [Re Ψ, Im Ψ]) the complex modes are a
/// complete solution of q̈ + M⁻¹C q̇ + M⁻¹K q = 0, so
///
/// ```text
/// [M⁻¹K  M⁻¹C] = -[ΨΛ²  Ψ*Λ*²] [Ψ Ψ*; ΨΛ Ψ*Λ*]⁻¹,     M⁻¹K φ = ω² φ
/// ```
/// Unlike [`real_shape`] it uses the phases: where damping couples close modes it takes the coupling out again. It needs
/// at least as many sensors as modes, scatters more with noise, and knows nothing of modes outside the set.
///
/// * `shapes` - complex shapes (sensors x modes), any scale, finite
/// * `poles` - λ of each, rad/s
///
/// # Errors
/// Fewer sensors than modes, shapes that are (nearly) dependent, or an M⁻¹K with complex or negative eigenvalues.
///
/// # Source
/// S. R. Ibrahim, Computation of normal modes from identified complex modes, AIAA J. 21, 1983.
pub fn normal_modes(shapes: &DMatrix<Complex<f64>>, poles: &[Complex<f64>]) -> Result<NormalModes, IdentifyError> {
    let (n, m) = shapes.shape();
    if poles.len() != m {
        return Err(IdentifyError::Length { what: "the list of poles", expected: m, found: poles.len() });
    }
    let singular = || IdentifyError::Singular { what: "complex shapes in their subspace" };
    if n < m || m == 0 || shapes.iter().any(|x| !x.is_finite()) || poles.iter().any(|x| !x.is_finite()) {
        return Err(singular());
    }
    // Every shape turned to its own phase and scaled, so that no mode outweighs another in the subspace.
    let mut turned = shapes.clone();
    for mut column in turned.column_iter_mut() {
        let (phase, major, minor) = principal_axis(&column.clone_owned());
        let scale = (major + minor).sqrt();
        if scale.is_nan() || scale <= 0.0 {
            return Err(singular());
        }
        column *= Complex::from_polar(1.0 / scale, -phase);
    }
    let stacked = DMatrix::from_fn(n, 2 * m, |i, j| if j < m { turned[(i, j)].re } else { turned[(i, j - m)].im });
    let svd = stacked.try_svd(true, false, f64::EPSILON, 10_000).ok_or_else(singular)?;
    let mut rank: Vec<usize> = (0..svd.singular_values.len()).collect();
    rank.sort_by(|&a, &b| svd.singular_values[b].total_cmp(&svd.singular_values[a]));
    let u = svd.u.as_ref().ok_or_else(singular)?;
    let t = DMatrix::from_fn(n, m, |i, j| u[(i, rank[j])]);
    let psi = t.map(|x| Complex::new(x, 0.0)).tr_mul(&turned);
    let scale = poles.iter().map(|p| p.norm()).sum::<f64>() / m as f64;
    let lambda: Vec<Complex<f64>> = poles.iter().map(|p| p / scale).collect();
    // Real form: rows [Re ψ, Im ψ; Re ψλ, Im ψλ] and right-hand side -[Re ψλ², Im ψλ²].
    let part = |i: usize, j: usize, power: i32| {
        let x = psi[(i, j % m)] * lambda[j % m].powi(power);
        if j < m { x.re } else { x.im }
    };
    let state = DMatrix::from_fn(2 * m, 2 * m, |i, j| if i < m { part(i, j, 0) } else { part(i - m, j, 1) });
    let acceleration = DMatrix::from_fn(m, 2 * m, |i, j| -part(i, j, 2));
    let solved = state.transpose().lu().solve(&acceleration.transpose()).ok_or_else(singular)?.transpose();
    let pairs = general_eigenpairs(&solved.columns(0, m).into_owned())?;
    let mut order: Vec<usize> = (0..m).collect();
    order.sort_by(|&a, &b| pairs.values[a].re.total_cmp(&pairs.values[b].re));
    if pairs.values.iter().any(|v| v.re.is_nan() || v.re <= 0.0 || v.im.abs() > 1e-6 * v.re) {
        return Err(singular());
    }
    let mut out = DMatrix::zeros(n, m);
    for (j, &k) in order.iter().enumerate() {
        let shape = t.map(|x| Complex::new(x, 0.0)) * pairs.vectors.column(k);
        let real = real_shape(&shape);
        let largest = real.amax();
        out.set_column(j, &(real / largest.max(f64::MIN_POSITIVE)));
    }
    let frequencies_hz = order.iter().map(|&k| pairs.values[k].re.sqrt() * scale / std::f64::consts::TAU).collect();
    Ok(NormalModes { frequencies_hz, shapes: out })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_real_shape_is_perfectly_collinear() {
        let shape = DVector::from_vec([1.0, -2.0, 0.5].map(|x| Complex::from_polar(1.0, 0.7) * x).to_vec());
        let c = complexity(&shape);
        assert!((c.mpc - 1.0).abs() < 1e-14 && (c.mean_phase - 0.7).abs() < 1e-14);
        assert!(c.mean_phase_deviation_deg < 1e-6 && c.imaginary_ratio < 1e-7);
        let real = real_shape(&shape);
        assert!((real - DVector::from_vec(vec![-1.0, 2.0, -0.5])).amax() < 1e-14);
    }

    #[test]
    fn a_travelling_wave_has_no_collinearity() {
        let shape = DVector::from_fn(4, |k, _| Complex::from_polar(1.0, k as f64 * std::f64::consts::FRAC_PI_2));
        let c = complexity(&shape);
        assert!(c.mpc < 1e-14 && (c.imaginary_ratio - 1.0).abs() < 1e-14);
    }

    /// Two close modes coupled by a dashpot on one mass: the complex modes of the exact state matrix give back the
    /// undamped frequencies and shapes.
    #[test]
    fn normal_modes_of_a_non_proportionally_damped_chain_are_recovered() {
        let k = DMatrix::from_row_slice(2, 2, &[1.05, -0.05, -0.05, 1.1]);
        let c = DMatrix::from_row_slice(2, 2, &[0.06, 0.0, 0.0, 0.004]);
        let mut a = DMatrix::zeros(4, 4);
        a.view_mut((0, 2), (2, 2)).copy_from(&DMatrix::identity(2, 2));
        a.view_mut((2, 0), (2, 2)).copy_from(&-&k);
        a.view_mut((2, 2), (2, 2)).copy_from(&-&c);
        let pairs = general_eigenpairs(&a).unwrap();
        let upper: Vec<usize> = (0..4).filter(|&j| pairs.values[j].im > 0.0).collect();
        let shapes = DMatrix::from_fn(2, 2, |i, j| pairs.vectors[(i, upper[j])]);
        let poles: Vec<_> = upper.iter().map(|&j| pairs.values[j]).collect();
        let modes = normal_modes(&shapes, &poles).unwrap();
        let exact = k.symmetric_eigen();
        let mut omega2: Vec<f64> = exact.eigenvalues.iter().copied().collect();
        omega2.sort_by(f64::total_cmp);
        for j in 0..2 {
            let f = omega2[j].sqrt() / std::f64::consts::TAU;
            assert!((modes.frequencies_hz[j] - f).abs() < 1e-12 * f);
            let shape = modes.shapes.column(j).into_owned();
            let image = DMatrix::from_row_slice(2, 2, &[1.05, -0.05, -0.05, 1.1]) * &shape - &shape * omega2[j];
            assert!(image.amax() < 1e-11);
        }
        // The rotated shape alone is visibly wrong here: that is what the method is for.
        assert!(complexity(&shapes.column(0).into_owned()).mpc < 0.999);
    }
}
