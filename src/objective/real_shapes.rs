//! Measured shapes as real numbers.

use crate::data::TestData;
use crate::linalg::{Complex, DMatrix, DVector};

/// e^{iα} that makes a shape as real as can be, with the sign that leaves a real one as it is; of what was measured of it.
///
/// -α is half the phase of Σ ψ_k²: it maximises the sum of squares of the real parts.
pub(super) fn phase(shape: &DVector<Complex<f64>>) -> Complex<f64> {
    let square: Complex<f64> = shape.iter().filter(|v| !v.re.is_nan()).map(|v| v * v).sum();
    if square.norm() > 0.0 { Complex::from_polar(1.0, -0.5 * square.arg()) } else { Complex::new(1.0, 0.0) }
}

/// Complex test shapes turned by the phase that makes them as real as can be, half that of Σ ψ_k², then their real parts.
pub fn real_shapes(test: &TestData) -> DMatrix<f64> {
    let n = test.sensors.len();
    let mut shapes = DMatrix::from_element(n, test.modes.len(), f64::NAN);
    for (j, mode) in test.modes.iter().enumerate() {
        let Some(shape) = &mode.shape else { continue };
        let is_real = shape.iter().all(|v| v.im == 0.0 || v.im.is_nan());
        let turn = if is_real { Complex::new(1.0, 0.0) } else { phase(shape) };
        for i in 0..n {
            shapes[(i, j)] = (shape[i] * turn).re;
        }
    }
    shapes
}
