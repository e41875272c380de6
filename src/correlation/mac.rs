//! Modal assurance criterion and modal scale factor.
//!
//! An entry that is NaN says "this sensor did not measure in this mode": the pair is then compared on the sensors that
//! both shapes have. All inner products are Hermitian, so a common phase of a complex shape changes nothing.

use crate::linalg::{Complex, DMatrix};
use nalgebra::ComplexField;

/// Number type of a mode shape: `f64` or `Complex<f64>`.
pub trait ShapeScalar: ComplexField<RealField = f64> + Copy {
    /// Whether the entry was measured: NaN or infinity stands for "no".
    fn is_measured(self) -> bool {
        self.is_finite()
    }

    /// Largest magnitude of the parts.
    fn size(self) -> f64 {
        self.real().abs().max(self.imaginary().abs())
    }
}
impl ShapeScalar for f64 {}
impl ShapeScalar for Complex<f64> {}

/// The power of two that brings the largest of some values to between 1 and 2, so that their squares neither overflow nor vanish; a
/// power of two, because it changes no digit. 1 for values that are all zero.
pub(crate) fn unit_scale<T: ShapeScalar>(values: impl IntoIterator<Item = T>) -> f64 {
    const EXPONENT: u64 = 0x7ff;
    let largest = values.into_iter().filter(|v| v.is_measured()).map(ShapeScalar::size).fold(0.0, f64::max);
    if largest == 0.0 {
        return 1.0;
    }
    // Biased exponents e and 2046 - e are those of 2^k and 2^-k; subnormal numbers come as near as they can.
    let exponent = (largest.to_bits() >> 52) & EXPONENT;
    f64::from_bits((EXPONENT - 1 - exponent.clamp(1, EXPONENT - 2)) << 52)
}

/// Columns scaled by [`unit_scale`]; entries that were not measured stay as they are.
fn unit_columns<T: ShapeScalar>(phi: &DMatrix<T>) -> DMatrix<T> {
    let mut scaled = phi.clone();
    for mut column in scaled.column_iter_mut() {
        let scale = unit_scale(column.iter().copied());
        column.apply(|v| *v = v.scale(scale));
    }
    scaled
}

/// Real shapes as complex ones, to compare a real model with a complex test.
pub fn to_complex(shapes: &DMatrix<f64>) -> DMatrix<Complex<f64>> {
    shapes.map(Complex::from)
}

/// Modal assurance criterion between analytical and experimental mode shapes.
///
/// ```text
///                 |φ_a[i]ᴴ φ_x[j]|²
/// MAC[i,j] = ───────────────────────────────────
///            (φ_a[i]ᴴ φ_a[i]) (φ_x[j]ᴴ φ_x[j])
///
/// (n_a x n_x)   from   (n_sensor x n_a), (n_sensor x n_x)
/// ```
///
/// * `phi_a` - analytical shapes at the sensors, any scaling
/// * `phi_x` - experimental shapes at the sensors, any scaling; NaN where a sensor did not measure
///
/// Unitless, in [0, 1]; unchanged by scaling, sign or phase of any column. Sums run over the sensors where both shapes
/// are measured. A zero column, or a pair without a common sensor, gives zero, never NaN.
///
/// What it can tell: that two shapes are parallel *at these sensors*. What it cannot: whether the sensors can tell the
/// modes apart (see [`auto_mac`]), whether scale or mass agree, or anything about small entries: sensors with large
/// motion dominate.
///
/// # Panics
/// If the row counts differ: both sets must be at the same sensors.
///
/// # Source
/// R. J. Allemang, D. L. Brown, A correlation coefficient for modal vector analysis, Proc. 1st IMAC, 1982.
pub fn mac_matrix<T: ShapeScalar>(phi_a: &DMatrix<T>, phi_x: &DMatrix<T>) -> DMatrix<f64> {
    let same_sensors = phi_a.nrows() == phi_x.nrows();
    assert!(same_sensors, "shapes at {} and at {} sensors", phi_a.nrows(), phi_x.nrows());
    let (phi_a, phi_x) = (&unit_columns(phi_a), &unit_columns(phi_x));
    let complete = phi_a.iter().chain(phi_x.iter()).all(|v| v.is_measured());
    if complete {
        let squared_norms = |phi: &DMatrix<T>| phi.column_iter().map(|c| c.norm_squared()).collect::<Vec<_>>();
        let (norms_a, norms_x) = (squared_norms(phi_a), squared_norms(phi_x));
        return DMatrix::from_fn(phi_a.ncols(), phi_x.ncols(), |i, j| {
            assurance(phi_a.column(i).dotc(&phi_x.column(j)), norms_a[i], norms_x[j])
        });
    }
    DMatrix::from_fn(phi_a.ncols(), phi_x.ncols(), |i, j| {
        let mut cross = T::zero();
        let (mut norm_a, mut norm_x) = (0.0, 0.0);
        for (&a, &x) in phi_a.column(i).iter().zip(phi_x.column(j).iter()) {
            if a.is_measured() && x.is_measured() {
                cross += a.conjugate() * x;
                norm_a += a.modulus_squared();
                norm_x += x.modulus_squared();
            }
        }
        assurance(cross, norm_a, norm_x)
    })
}

/// |cross|²/(norm_a norm_x) in [0, 1]; 0 when a norm is zero. The norms divide one at a time: no overflow, no underflow.
fn assurance<T: ShapeScalar>(cross: T, norm_a: f64, norm_x: f64) -> f64 {
    let is_usable = |norm: f64| norm > 0.0 && norm.is_finite();
    if is_usable(norm_a) && is_usable(norm_x) {
        let cosine = cross.modulus() / norm_a.sqrt() / norm_x.sqrt();
        (cosine * cosine).min(1.0)
    } else {
        0.0
    }
}

/// A mode whose shape at the sensors is smaller than this share of the largest is not seen by any: what they show of it is rounding.
pub const UNSEEN: f64 = 1e-6;

/// Sets the shapes at the sensors to zero of modes that no sensor sees: torsion of a beam with its sensors on the axis. Rounding has a
/// direction, that of a mode beside it, and would be a partner of whatever that mode is a partner of.
///
/// * `at_sensors` - (n_sensors x n_modes) of mass-normalised modes
pub fn hide_unseen(at_sensors: &mut DMatrix<f64>) {
    let largest = at_sensors.column_iter().map(|c| c.norm_squared()).fold(0.0, f64::max);
    let least = UNSEEN * UNSEEN * largest;
    at_sensors.column_iter_mut().filter(|c| c.norm_squared() < least).for_each(|mut c| c.fill(0.0));
}

/// MAC of a set of shapes with itself, (n x n) with ones on the diagonal.
///
/// Large values off the diagonal say that the sensors cannot tell the two modes apart (spatial aliasing): no test at
/// these sensors can pair them by shape. Zero columns have a zero on the diagonal.
///
/// # Source
/// D. J. Ewins, Modal Testing: Theory, Practice and Application, 2nd edition 2000, section 6.3 (auto-MAC).
pub fn auto_mac<T: ShapeScalar>(phi: &DMatrix<T>) -> DMatrix<f64> {
    mac_matrix(phi, phi)
}

/// MAC in the inner product of a symmetric weight, usually the mass matrix reduced to the sensors.
///
/// ```text
///                 |φ_a[i]ᴴ W φ_x[j]|²
/// MAC[i,j] = ─────────────────────────────────────────   (n_a x n_x), W (n_sensor x n_sensor)
///            (φ_a[i]ᴴ W φ_a[i]) (φ_x[j]ᴴ W φ_x[j])
/// ```
///
/// * `weight` - symmetric, positive semidefinite, any unit
///
/// With W = M and all dofs the modes of one model give the identity exactly; the plain MAC need not. Missing entries
/// drop their row and column of W for that pair, which is right for a diagonal W and an approximation for a full one
/// (the missing mass is ignored, not condensed). Zero weighted norms give zero.
///
/// # Panics
/// If the row counts differ, or W is not square of that size.
///
/// # Source
/// R. J. Allemang, The modal assurance criterion: twenty years of use and abuse, Sound and Vibration, August 2003
/// (weighted modal assurance criterion, WMAC).
pub fn weighted_mac_matrix<T: ShapeScalar>(
    phi_a: &DMatrix<T>,
    phi_x: &DMatrix<T>,
    weight: &DMatrix<f64>,
) -> DMatrix<f64> {
    let n = phi_a.nrows();
    let fits = phi_x.nrows() == n && weight.shape() == (n, n);
    assert!(fits, "shapes at {n} and {} sensors, weight {:?}", phi_x.nrows(), weight.shape());
    let (phi_a, phi_x) = (&unit_columns(phi_a), &unit_columns(phi_x));
    let scale = unit_scale(weight.iter().copied());
    let weight = weight.map(|w| T::from_real(w * scale));
    if phi_a.iter().chain(phi_x.iter()).all(|v| v.is_measured()) {
        let weighted_norms = |phi: &DMatrix<T>, weighted: &DMatrix<T>| {
            (0..phi.ncols()).map(|k| phi.column(k).dotc(&weighted.column(k)).real()).collect::<Vec<_>>()
        };
        let (wa, wx) = (&weight * phi_a, &weight * phi_x);
        let (norms_a, norms_x) = (weighted_norms(phi_a, &wa), weighted_norms(phi_x, &wx));
        return DMatrix::from_fn(phi_a.ncols(), phi_x.ncols(), |i, j| {
            assurance(phi_a.column(i).dotc(&wx.column(j)), norms_a[i], norms_x[j])
        });
    }
    DMatrix::from_fn(phi_a.ncols(), phi_x.ncols(), |i, j| {
        let (a, x) = (phi_a.column(i), phi_x.column(j));
        let common = |v: T, k: usize| if a[k].is_measured() && x[k].is_measured() { v } else { T::zero() };
        let a = DMatrix::from_fn(n, 1, |k, _| common(a[k], k));
        let x = DMatrix::from_fn(n, 1, |k, _| common(x[k], k));
        let wx = &weight * &x;
        let norm_a = a.dotc(&(&weight * &a)).real();
        assurance(a.dotc(&wx), norm_a, x.dotc(&wx).real())
    })
}

/// Modal scale factor: the factor on the analytical shape that comes closest to the experimental one.
///
/// ```text
///        φ_aᴴ φ_x
/// MSF = ──────────   minimises ‖φ_x - MSF φ_a‖
///        φ_aᴴ φ_a
/// ```
///
/// * `phi_a`, `phi_x` - one column each of shapes at the same sensors, given as slices; NaN where not measured
///
/// Unit: that of φ_x over that of φ_a. Complex shapes give the phase too. Zero when φ_a is zero at the common sensors.
/// Swapping the arguments does not give the reciprocal unless the shapes are parallel: the product of both is the MAC.
///
/// # Panics
/// If the lengths differ.
///
/// # Source
/// R. J. Allemang, D. L. Brown, A correlation coefficient for modal vector analysis, Proc. 1st IMAC, 1982.
pub fn modal_scale_factor<T: ShapeScalar>(phi_a: &[T], phi_x: &[T]) -> T {
    assert_eq!(phi_a.len(), phi_x.len(), "shapes at the same sensors");
    let mut cross = T::zero();
    let mut norm_a = 0.0;
    let (scale_a, scale_x) = (unit_scale(phi_a.iter().copied()), unit_scale(phi_x.iter().copied()));
    for (&a, &x) in phi_a.iter().zip(phi_x) {
        if a.is_measured() && x.is_measured() {
            let a = a.scale(scale_a);
            cross += a.conjugate() * x.scale(scale_x);
            norm_a += a.modulus_squared();
        }
    }
    if norm_a > 0.0 { cross.unscale(norm_a).scale(scale_a).unscale(scale_x) } else { T::zero() }
}

#[cfg(test)]
pub(super) mod tests;
