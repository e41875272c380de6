//! Identified modes as a test file holds them: sensors from channels, modes with standard deviations.

use super::IdentifyError;
use super::circle::circle_fit;
use super::complexity::real_shape;
use super::mode::IdentifiedMode;
use super::quadrature::{QuadratureForm, quadrature_shapes};
use super::spectrum::SpectrumPeak;
use crate::data::{FrfQuantity, FrfSet, Geometry, Measured, Origin, Place, Sensor, Standing, TestMode};
use retune_linalg::{Complex, DVector};

/// A circle that misses its points by more than this share of its radius is no single mode.
const WORST_CIRCLE: f64 = 0.1;

/// Sensors of the responses of a set, in their order: named as the channels, with the axis where a name is not unique.
///
/// Each stands on a "node" of its channel's name until a mapping finds its place in a model, at the position of its point
/// where the geometry knows it.
///
/// * `direction` - for channels that do not know theirs
///
/// # Errors
/// [`IdentifyError::NoDirection`] for a channel without direction.
pub fn sensors(
    frfs: &FrfSet,
    geometry: Option<&Geometry>,
    direction: Option<[f64; 3]>,
) -> Result<Vec<Sensor>, IdentifyError> {
    let is_unique = |name: &str| frfs.responses.iter().filter(|c| c.name == name).count() == 1;
    let mut taken: Vec<String> = Vec::new();
    let mut out = Vec::with_capacity(frfs.responses.len());
    for channel in &frfs.responses {
        let direction = channel
            .direction
            .or(direction)
            .ok_or_else(|| IdentifyError::NoDirection { channel: channel.name.clone() })?;
        let mut name = channel.name.clone();
        if !is_unique(&name) {
            let axis = (0..3).max_by(|a, b| direction[*a].abs().total_cmp(&direction[*b].abs())).unwrap_or(2);
            name = format!("{name}.{}", ["x", "y", "z"][axis]);
        }
        let base = name.clone();
        let mut count = 1;
        while taken.contains(&name) {
            count += 1;
            name = format!("{base}.{count}");
        }
        taken.push(name.clone());
        let position = geometry.and_then(|g| g.point(&channel.name)).map(|p| p.position_m);
        let place = Place::Node { node: channel.name.clone(), position };
        out.push(Sensor { name, place, direction, offset: None, is_rotation: false, mass: None });
    }
    Ok(out)
}

/// Modes of [`identify`](super::identify) with complex shapes at [`sensors`] and their standard deviations.
pub fn test_modes(modes: &[IdentifiedMode], origin: &Origin) -> Vec<TestMode> {
    let mode = |m: &IdentifiedMode| {
        let shape = m.shape.map(|v| if v.is_finite() { v } else { Complex::new(f64::NAN, f64::NAN) });
        // An entry that was not measured has no use for its standard deviation; a file needs a number there.
        let sd = m.shape_sd.map(|s| if s.is_finite() && s > 0.0 { s } else { 1.0 });
        TestMode {
            label: None,
            frequency_hz: m.frequency_hz,
            damping_ratio: Some(m.damping_ratio),
            origin: origin.clone(),
            shape: Some(shape),
            shape_sd: Some(sd),
            shape_origin: Some(origin.clone()),
            components: Vec::new(),
            standing: Standing::Open,
            space: None,
        }
    };
    modes.iter().map(mode).collect()
}

/// What a repeated test would change, as a share of every frequency.
pub const REPEATABILITY: f64 = 1e-3;
/// Of the largest entry of a shape against that of a frequency: the calibration of a channel is good to a percent.
const OF_SHAPES: f64 = 10.0;

/// Adds to the standard deviations what a repeated test would change.
///
/// ```text
/// sd_f² + (r f)²,    sd_φ² + (10 r max|φ|)²
/// ```
/// Those of an identification say how well the lines of one run determine the modes of that run, often to some 10⁻⁵: far better than a structure keeps them
/// from day to day, and than any model can be asked to meet.
///
/// * `share` - r, such as [`REPEATABILITY`]
pub fn add_repeatability(modes: &mut [TestMode], share: f64) {
    for mode in modes {
        let f = &mut mode.frequency_hz;
        f.sd = f.sd.hypot(share * f.value);
        let largest = mode.shape.iter().flatten().filter(|v| v.is_finite()).map(|v| v.norm()).fold(0.0, f64::max);
        if let Some(sd) = &mut mode.shape_sd {
            sd.iter_mut().for_each(|s| *s = s.hypot(OF_SHAPES * share * largest));
        }
    }
}

/// The same frequencies and damping ratios with shapes by quadrature picking at one reference.
///
/// The standard deviation of a shape is 2 % of its largest entry: what the method bends a noise-free shape of the kind it
/// is used for (Gupta et al., equation (3), on the BFF wing: 1.9 %).
///
/// # Errors
/// Those of [`quadrature_shapes`].
pub fn quadrature_modes(
    frfs: &FrfSet,
    reference: usize,
    modes: &[IdentifiedMode],
    origin: &Origin,
) -> Result<Vec<TestMode>, IdentifyError> {
    let f: Vec<f64> = modes.iter().map(|m| m.frequency_hz.value).collect();
    let zeta: Vec<f64> = modes.iter().map(|m| m.damping_ratio.value).collect();
    let form = match frfs.quantity {
        FrfQuantity::Accelerance => QuadratureForm::Accelerance,
        FrfQuantity::Receptance | FrfQuantity::Mobility => QuadratureForm::Receptance,
    };
    let picked = quadrature_shapes(frfs, reference, &f, &zeta, form)?;
    let mut out = test_modes(modes, origin);
    for (k, mode) in out.iter_mut().enumerate() {
        let column = picked.shapes.column(k);
        let largest = column
            .iter()
            .copied()
            .filter(|v| v.is_finite())
            .fold(0.0_f64, |a, v| if v.abs() > a.abs() { v } else { a });
        let scale = if largest == 0.0 { 1.0 } else { largest };
        mode.shape = Some(DVector::from_fn(column.len(), |i, _| Complex::new(column[i] / scale, 0.0)));
        mode.shape_sd = Some(DVector::from_element(column.len(), 0.02));
    }
    Ok(out)
}

/// Modes by a circle in every function about each pole: frequencies and damping ratios are weighted means over the
/// responses, their standard deviations the larger of the scatter of the mean and the mean's own.
///
/// ```text
/// f = Σ f_o/s_o² / Σ 1/s_o²       over circles whose points lie within 10 % of the radius
/// ```
/// A mode without such a circle keeps the numbers of its pole. The shape holds the modal constants; responses without
/// circle are NaN.
///
/// # Errors
/// A set whose lengths disagree.
pub fn circle_modes(
    frfs: &FrfSet,
    reference: usize,
    modes: &[IdentifiedMode],
    origin: &Origin,
) -> Result<Vec<TestMode>, IdentifyError> {
    super::layout::check_layout(frfs)?;
    let mut out = test_modes(modes, origin);
    for (mode, identified) in out.iter_mut().zip(modes) {
        let (f, zeta) = (identified.frequency_hz.value, identified.damping_ratio.value);
        // One and a half half-power widths to each side: 113 degrees of the circle each.
        let band = (f * (1.0 - 1.5 * zeta), f * (1.0 + 1.5 * zeta));
        let fits: Vec<_> = (0..frfs.responses.len())
            .map(|o| circle_fit(frfs, reference, o, band).ok().filter(|c| c.misfit < WORST_CIRCLE))
            .collect();
        let good: Vec<_> = fits.iter().flatten().collect();
        if good.is_empty() {
            continue;
        }
        mode.frequency_hz = mean(&good.iter().map(|c| (c.frequency_hz, c.frequency_sd)).collect::<Vec<_>>());
        mode.damping_ratio = Some(mean(&good.iter().map(|c| (c.damping_ratio, c.damping_sd)).collect::<Vec<_>>()));
        let nan = Complex::new(f64::NAN, f64::NAN);
        let constants = DVector::from_iterator(fits.len(), fits.iter().map(|c| c.map_or(nan, |c| c.modal_constant)));
        let largest = constants
            .iter()
            .filter(|v| v.is_finite())
            .fold(Complex::new(0.0, 0.0), |a: Complex<f64>, v| if v.norm() > a.norm() { *v } else { a });
        let misfit = good.iter().map(|c| c.misfit).fold(0.0, f64::max);
        mode.shape = Some(constants.map(|v| v / largest));
        mode.shape_sd = Some(DVector::from_element(fits.len(), misfit.max(1e-3)));
    }
    Ok(out)
}

/// Weighted mean of (value, sd).
fn mean(list: &[(f64, f64)]) -> Measured {
    let weight = |s: f64| 1.0 / (s * s).max(f64::MIN_POSITIVE);
    let total: f64 = list.iter().map(|v| weight(v.1)).sum();
    let value = list.iter().map(|v| v.0 * weight(v.1)).sum::<f64>() / total;
    let own = total.sqrt().recip();
    let scatter = list.iter().map(|v| weight(v.1) * (v.0 - value).powi(2)).sum::<f64>() / total;
    let n = list.len() as f64;
    let of_mean = if n > 1.0 { (scatter / (n - 1.0)).sqrt() } else { own };
    Measured { value, sd: own.max(of_mean).max(1e-9 * value.abs()), sd_is_default: false }
}

/// Peaks of a spectrum as modes without shape.
pub fn peak_modes(peaks: &[SpectrumPeak], origin: &Origin) -> Vec<TestMode> {
    let mode = |p: &SpectrumPeak| TestMode {
        label: None,
        frequency_hz: Measured { value: p.frequency_hz, sd: p.frequency_sd, sd_is_default: false },
        damping_ratio: None,
        origin: origin.clone(),
        shape: None,
        shape_sd: None,
        shape_origin: None,
        components: Vec::new(),
        standing: Standing::Open,
        space: None,
    };
    peaks.iter().map(mode).collect()
}

/// Real shape of a test mode, largest entry 1; NaN where not measured.
pub fn normal_shape(mode: &TestMode) -> Option<DVector<f64>> {
    let shape = real_shape(mode.shape.as_ref()?);
    let largest =
        shape.iter().copied().filter(|v| v.is_finite()).fold(0.0_f64, |a, v| if v.abs() > a.abs() { v } else { a });
    (largest != 0.0).then(|| shape / largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_repeated_test_changes_is_added_in_squares() {
        let origin = Origin::Synthetic(String::new());
        let f = Measured { value: 50.0, sd: 0.04, sd_is_default: false };
        let shape =
            DVector::from_vec(vec![Complex::new(0.0, 2.0), Complex::new(0.5, 0.0), Complex::new(f64::NAN, 0.0)]);
        let mut modes = [TestMode {
            label: None,
            frequency_hz: f,
            damping_ratio: None,
            origin: origin.clone(),
            shape: Some(shape),
            shape_sd: Some(DVector::from_vec(vec![0.015, 0.0, 1.0])),
            shape_origin: None,
            components: Vec::new(),
            standing: Standing::Open,
            space: None,
        }];
        add_repeatability(&mut modes, 0.6e-3);
        assert!((modes[0].frequency_hz.sd - 0.05).abs() < 1e-15);
        let sd = modes[0].shape_sd.as_ref().unwrap();
        assert!((sd[0] - 0.015_f64.hypot(0.012)).abs() < 1e-15 && (sd[1] - 0.012).abs() < 1e-15);
        add_repeatability(&mut modes, 0.0);
        assert!((modes[0].frequency_hz.sd - 0.05).abs() < 1e-15);
    }
}
