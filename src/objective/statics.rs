//! Static tests of a model: loads, displacements under them, and their derivatives.

use super::comparison::Comparison;
use super::point::Point;
use super::prediction::Prediction;
use super::static_loads::readings;
use crate::data::StaticReading;
use crate::linalg::DMatrix;

/// What the sensors read under the loads, in the order of the tests and their readings; NaN where K has no inverse.
///
/// ```text
/// K u = f,   reading = s · u
/// ```
pub fn static_readings(comparison: &Comparison<'_>, prediction: &Prediction) -> Vec<f64> {
    let n_readings = readings(comparison.test()).count();
    if n_readings == 0 {
        return Vec::new();
    }
    if let Some(known) = &prediction.readings {
        return known.clone();
    }
    let Ok(factor) = comparison.solver().factor(comparison.model(), &prediction.matrices) else {
        return vec![f64::NAN; n_readings];
    };
    let u = factor.solve(comparison.loads());
    let sensors = comparison.sensors_of(prediction);
    readings(comparison.test()).map(|(k, _, r)| sensors.row(r.sensor).tr_dot(&u.column(k))).collect()
}

/// What sensors read in static tests at one point, and how the structure moves.
#[derive(Debug)]
pub(super) struct Static {
    pub(super) readings: Vec<f64>,
    /// The test of each reading.
    of_test: Vec<usize>,
    /// u of every test, (n_dof x n_tests).
    pub(super) moved: DMatrix<f64>,
    /// λ of every reading, (n_dof x n_readings).
    pub(super) reading: DMatrix<f64>,
}

impl Static {
    /// `None` where K has no inverse.
    pub(super) fn new(comparison: &Comparison<'_>, prediction: &Prediction) -> Option<Self> {
        let factor = comparison.solver().factor(comparison.model(), &prediction.matrices).ok()?;
        let sensors = comparison.sensors_of(prediction);
        let (of_test, rows): (Vec<usize>, Vec<usize>) =
            readings(comparison.test()).map(|(k, _, r)| (k, r.sensor)).unzip();
        let moved = factor.solve(comparison.loads());
        let reading = factor.solve(&sensors.select_rows(&rows).transpose());
        let readings = static_readings(comparison, prediction);
        Some(Self { readings, of_test, moved, reading })
    }

    /// Adds -λ · f to readings.
    ///
    /// * `reading` - λ on the rows of a change
    /// * `forces` - of the change there under the motion of every test
    pub(super) fn add(&self, reading: &DMatrix<f64>, forces: &DMatrix<f64>, out: &mut [f64]) {
        for ((out, lambda), &k) in out.iter_mut().zip(reading.column_iter()).zip(&self.of_test) {
            *out -= lambda.dot(&forces.column(k));
        }
    }
}

/// Whether a reading belongs to a residual, by the kind of its sensor.
fn is_of(comparison: &Comparison<'_>, r: &StaticReading, rotation: bool) -> bool {
    comparison.test().sensors[r.sensor].is_rotation == rotation
}

/// Number of readings of a kind.
pub(super) fn count(comparison: &Comparison<'_>, rotation: bool) -> usize {
    readings(comparison.test()).filter(|(_, _, r)| is_of(comparison, r, rotation)).count()
}

/// "tip in bending"
pub(super) fn row_name(comparison: &Comparison<'_>, rotation: bool, row: usize) -> String {
    let found = readings(comparison.test()).filter(|(_, _, r)| is_of(comparison, r, rotation)).nth(row);
    found.map_or_else(String::new, |(_, t, r)| {
        let what = if rotation { "angle" } else { "deflection" };
        format!("static {what} at {} in {}", comparison.test().sensors[r.sensor].name, t.name)
    })
}

/// Residuals of a kind.
pub(super) fn evaluate(at: &Point<'_>, rotation: bool, out: &mut [f64]) {
    if out.is_empty() {
        return;
    }
    let model = static_readings(at.comparison, at.prediction);
    let own = readings(at.comparison.test()).zip(&model).filter(|((_, _, r), _)| is_of(at.comparison, r, rotation));
    for (o, ((_, _, r), value)) in out.iter_mut().zip(own) {
        *o = (value - r.measured.value) / r.measured.sd;
    }
}

/// Their exact derivatives.
///
/// ```text
/// ∂reading = ∂s · u - λ · ∂K u,   K λ = s
/// ```
pub(super) fn differentiate(at: &Point<'_>, rotation: bool, out: &mut DMatrix<f64>) {
    out.fill(0.0);
    if out.nrows() == 0 {
        return;
    }
    let (model, matrices) = (at.comparison.model(), &at.prediction.matrices);
    let Ok(factor) = at.comparison.solver().factor(model, matrices) else { return };
    let u = factor.solve(at.comparison.loads());
    let sensors = at.comparison.sensors_of(at.prediction);
    let Ok(slopes) = at.comparison.slopes_of_sensors(at.theta, at.scaling.free()) else { return };
    let own: Vec<(usize, &StaticReading)> = readings(at.comparison.test())
        .filter(|(_, _, r)| is_of(at.comparison, r, rotation))
        .map(|(k, _, r)| (k, r))
        .collect();
    let rows: Vec<usize> = own.iter().map(|(_, r)| r.sensor).collect();
    let adjoints = factor.solve(&sensors.select_rows(&rows).transpose());
    for (column, &j) in at.scaling.free().iter().enumerate() {
        let Ok(d) = matrices.derivative(model, at.theta, j) else { continue };
        let force = d.stiffness_times(&u);
        for (row, (k, reading)) in own.iter().enumerate() {
            let moved = slopes.get(column).map_or(0.0, |s| s.row(reading.sensor).tr_dot(&u.column(*k)));
            out[(row, column)] = (moved - adjoints.column(row).dot(&force.column(*k))) / reading.measured.sd;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlation::PairingOptions;
    use crate::data::{TestData, read_test, write_test};
    use crate::model::{Model, ParametricModel, Registry, load};
    use crate::objective::{LeastSquares, Objective};

    const BEAM: &str = "
retune: 1
name: cantilever
parameters:
  GJ: {value: 20 N m2, bounds: [5 N m2, 80 N m2]}
  soft: {value: 0 rad/(N m), bounds: [0 rad/(N m), 1e-2 rad/(N m)]}
nodes: {a: [0, 0, 0], b: [2 m, 0, 0]}
beams:
  w: {nodes: [a, b], properties: {EA: 1e6 N, EIy: 50 N m2, EIz: 80 N m2, GJ: GJ, mass_per_length: 1 kg/m, polar_inertia_per_length: 0.01 kg m}, subdivide: 2}
supports: {wall: {node: a}}
";

    /// Loads at an arm of 0.3 m from the tip, given in three ways.
    fn test(at: &str) -> String {
        format!(
            "
retune_test: 1
name: bench
sources: {{bench: {{kind: measured, text: by hand}}}}
sensors:
  edge: {{{at}, direction: +z}}
  tip: {{node: b, direction: +z}}
  twist: {{node: b, direction: +x, rotation: true}}
static_tests:
  pull:
    source: bench
    loads: [{{sensor: edge, force: 7 N}}]
    readings: {{edge: {{value: 1 m, sd: 1 mm}}, tip: {{value: 1 m, sd: 1 mm}}, twist: {{value: 1 rad, sd: 1 mrad}}}}
"
        )
    }

    fn read(model: &Model, test: &TestData) -> Vec<f64> {
        let comparison = Comparison::new(model, test, PairingOptions::default()).unwrap();
        let prediction = comparison.predict(&model.parameters().nominal()).unwrap();
        static_readings(&comparison, &prediction)
    }

    /// w = F L³/3EI, φ = F a L/GJ; the edge moves by w + a φ. F = 7 N, L = 2 m, a = 0.3 m.
    #[test]
    fn a_load_beside_the_axis_twists() {
        let model = load(BEAM, &Registry::builtin()).unwrap().0;
        let (w, phi) = (7.0 * 8.0 / (3.0 * 50.0), 7.0 * 0.3 * 2.0 / 20.0);
        for at in [
            "node: b, offset: [0, 0.3 m, 0]",
            "node: b, position: [2 m, 0.3 m, 0]",
            "element: w/2, fraction: 1, offset: [0, 0.3 m, 0]",
            "element: w/2, fraction: 1, position: [2 m, 0.3 m, 0]",
        ] {
            let data = read_test(&test(at)).unwrap_or_else(|p| panic!("{p:?}")).0;
            let found = read(&model, &data);
            for (found, right) in found.iter().zip([w + 0.3 * phi, w, phi]) {
                assert!((found / right - 1.0).abs() < 1e-9, "{at}: {found} {right}");
            }
            // Written and read again the load stands where it stood.
            assert_eq!(read(&model, &read_test(&write_test(&data)).unwrap().0), found, "{at}");
        }
    }

    /// A sensor on the node of a support that gives reads what gives, with the right derivative.
    #[test]
    fn a_sensor_on_a_soft_support_moves() {
        let model = BEAM
            .replace("{node: a}}", "{node: a, compliance: {ry: soft}}}")
            .replace("soft: {value: 0", "soft: {value: 1e-3");
        let model = load(&model, &Registry::builtin()).unwrap_or_else(|p| panic!("{p:?}")).0;
        let text = test("node: b, offset: [0, 0.3 m, 0]")
            .replace("  tip: {node: b, direction: +z}", "  tip: {node: a, direction: +y, rotation: true}")
            .replace("tip: {value: 1 m, sd: 1 mm}", "tip: {value: 1 rad, sd: 1 mrad}");
        let data = read_test(&text).unwrap().0;
        // The moment F L turns the root by F L C, about -y for a pull along +z.
        let found = read(&model, &data)[1];
        assert!((found / (-7.0 * 2.0 * 1e-3) - 1.0).abs() < 1e-9, "{found}");
        let comparison = Comparison::new(&model, &data, PairingOptions::default()).unwrap();
        let objective = LeastSquares::new(&comparison);
        let x = objective.scaling().x(&model.parameters().nominal());
        let exact = objective.linearize(&x).unwrap().jacobian;
        let by_difference =
            crate::objective::difference(exact.nrows(), &x, |x| objective.residuals(x)).unwrap().jacobian;
        assert!((&exact - &by_difference).amax() < 1e-5 * exact.amax(), "{exact}{by_difference}");
    }
}
