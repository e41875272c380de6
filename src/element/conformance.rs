//! What every element must satisfy, as a function: [`check`] runs over [`super::ELEMENTS`] in our tests, and over an
//! element of your own in yours.
//!
//! ```
//! use retune::element::{by_name, conformance};
//! let bar = by_name("bar").unwrap();
//! assert_eq!(conformance::check(bar), Ok(()));
//! ```
//!
//! The rules are physics, not style: energy that is never negative, no energy in a rigid motion and in nothing else, the
//! right mass and the kinetic energy of a rigid body, matrices that follow the units that the properties declare. What
//! they cannot know is whether EI/L³ has its 12: that is the element's own closed-form test. Symmetry needs no rule,
//! [`SymMatrix`] has only one triangle; rotation into global axes exists once, in `model`, and is tested there: what
//! an element contributes to frame invariance is its null space under rigid motion.

use super::{Domain, Element, ElementError, ElementInput, Property, Sample};
use crate::linalg::{DMatrix, SymMatrix, SymmetricEigen, symmetric_eigen};
use std::fmt;

/// A rule that an element breaks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Breach {
    /// The rule, in a few words.
    pub rule: &'static str,
    /// Where and by how much.
    pub detail: String,
}

impl fmt::Display for Breach {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.rule, self.detail)
    }
}

/// Entries of a matrix formed by a few dozen operations per entry, relative to the size of the row and column.
const ROUNDING: f64 = 1e-12;

/// Runs every rule over the declaration and over each of [`Element::samples`]; the error lists all breaches.
///
/// * *declaration*: names, units, dofs and samples are well formed; the samples together give every property
/// * *shape*: K, M, C are (6 nodes) x (6 nodes), finite, and zero at dofs the element does not touch
/// * *definiteness*: K, M, C are positive semidefinite
/// * *rigid motion*: K and C vanish under it; K vanishes under nothing else (when the sample lacks nothing); a grounded
///   sample resists every touched dof that has stiffness
/// * *mass*: the total mass is the sample's, in every touched direction, and the rigid-body matrix is one of a real body
/// * *units*: in other units of length, mass and time the matrices are the same quantities
/// * *properties*: each one changes K, M or C in some sample
/// * *refusals*: NaN, infinity and a number outside a property's domain, and a wrong count of nodes or values
/// * *strains*: none in a rigid motion; of an element without rotations they store no more energy than the stiffness; the mass that goes with them
///   is the sample's
/// * *interpolation*: a rigid motion of the nodes is the same rigid motion along the element, and at any point of a surface or a volume
pub fn check(element: &dyn Element) -> Result<(), Vec<Breach>> {
    let mut report = Report(Vec::new());
    declaration(element, &mut report);
    let mut alive = vec![false; element.properties().len()];
    for (number, sample) in element.samples().iter().enumerate() {
        if let Err(error) = one_sample(element, sample, &mut alive, &mut report) {
            report.add("samples", format!("sample {number} has no matrices: {error}"));
        }
    }
    for (property, alive) in element.properties().iter().zip(alive) {
        report.unless(alive, "properties", || format!("`{}` changes nothing in any sample", property.name));
    }
    if report.0.is_empty() { Ok(()) } else { Err(report.0) }
}

/// The breaches found so far.
struct Report(Vec<Breach>);

impl Report {
    fn add(&mut self, rule: &'static str, detail: String) {
        self.0.push(Breach { rule, detail });
    }

    fn unless(&mut self, holds: bool, rule: &'static str, detail: impl FnOnce() -> String) {
        if !holds {
            self.add(rule, detail());
        }
    }
}

/// K, M and C of one input.
struct Matrices([SymMatrix; 3]);

const MATRIX_NAMES: [&str; 3] = ["stiffness", "mass", "damping"];

impl Matrices {
    fn of(element: &dyn Element, input: &ElementInput<'_>) -> Result<Self, ElementError> {
        Ok(Self([element.stiffness(input)?, element.mass(input)?, element.damping(input)?]))
    }

    fn dense(&self) -> [DMatrix<f64>; 3] {
        [self.0[0].to_dense(), self.0[1].to_dense(), self.0[2].to_dense()]
    }
}

fn declaration(element: &dyn Element, report: &mut Report) {
    let rule = "declaration";
    let snake = |name: &str| !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    report.unless(snake(element.name()) && element.name() == element.name().to_lowercase(), rule, || {
        format!("the name `{}` is not snake_case", element.name())
    });
    report.unless(!element.summary().is_empty(), rule, || "no summary".into());
    report.unless(!element.theory().is_empty(), rule, || "no theory".into());
    report.unless(!element.nodes().is_empty(), rule, || "no nodes".into());
    for (node, dofs) in element.nodes().iter().enumerate() {
        report.unless(dofs.is_sorted_by(|a, b| a < b), rule, || {
            format!("dofs of node {node} are not in order, once each")
        });
    }
    let samples = element.samples();
    report.unless(!samples.is_empty(), rule, || "no samples: there is nothing to check".into());
    for (i, property) in element.properties().iter().enumerate() {
        let name = property.name;
        report.unless(snake(name), rule, || format!("the property name `{name}` is not made of letters, digits and _"));
        report.unless(element.properties()[..i].iter().all(|p| p.name != name), rule, || {
            format!("the property `{name}` is declared twice")
        });
        report.unless(!property.description.is_empty(), rule, || format!("the property `{name}` has no description"));
        report.unless(dimension(property.unit).is_some(), rule, || {
            format!("the unit `{}` of `{name}` is not made of kg m s N Pa rad", property.unit)
        });
        report.unless(samples.iter().any(|s| s.given.iter().any(|(n, _)| *n == name)), rule, || {
            format!("no sample gives `{name}`")
        });
    }
}

fn one_sample(
    element: &dyn Element,
    sample: &Sample,
    alive: &mut [bool],
    report: &mut Report,
) -> Result<(), ElementError> {
    let values = sample.values(element.properties())?;
    let input = ElementInput { points: &sample.points, values: &values };
    let matrices = Matrices::of(element, &input)?;
    if !shape(element, &matrices, report) {
        return Ok(());
    }
    let dense = matrices.dense();
    let rigid = rigid_modes(&sample.points);
    definiteness(&dense, report);
    rigid_motion(element, sample, &input, &dense, &rigid, report);
    let weighed = element.weighed_mass(&input)?.map_or_else(|| dense[1].clone(), |m| m.to_dense());
    rigid_body(element, sample, &(rigid.transpose() * weighed * &rigid), report);
    units(element, &input, &dense, report)?;
    for (i, alive) in alive.iter_mut().enumerate() {
        *alive |= matters(element, &input, i, &dense);
    }
    refusals(element, &input, report);
    nearest(element, &input, &rigid, report)?;
    strains(element, sample, &input, &rigid, report)?;
    interpolation(element, &input, &rigid, report)
}

/// [`Element::strain_field`], where there is one.
fn strains(
    element: &dyn Element,
    sample: &Sample,
    input: &ElementInput<'_>,
    rigid: &DMatrix<f64>,
    report: &mut Report,
) -> Result<(), ElementError> {
    let Some(field) = element.strain_field(input)? else { return Ok(()) };
    let rule = "strains";
    let n = rigid.nrows();
    let mut k = DMatrix::<f64>::zeros(n, n);
    for p in &field.points {
        let rows = DMatrix::from_fn(6, n, |i, j| p.rows[i][j]);
        let d = DMatrix::from_fn(6, 6, |i, j| field.rigidity[i][j]);
        let moved = &rows * rigid;
        report.unless(moved.amax() <= 1e-9 * rows.amax() * rigid.amax(), rule, || {
            format!("a rigid motion strains a point by {:e}", moved.amax())
        });
        k += rows.tr_mul(&(d * &rows)) * p.weight;
    }
    let translation = rigid.column(0);
    let mass = translation.dot(&(field.mass.to_dense() * translation));
    report.unless((mass - sample.mass).abs() <= 1e-9 * sample.mass, rule, || {
        format!("the mass that goes with them is {mass}, not {}", sample.mass)
    });
    // What the strains do not see is never negative; a preload is not strain. Rotations may count otherwise in energies than in strains.
    let turns = element.nodes().iter().any(|n| n.iter().any(|d| d.is_rotation()));
    if !turns && !sample.given.iter().any(|(name, _)| element.preloads().contains(name)) {
        let rest = element.stiffness(input)?.to_dense() - &k;
        let scale = rest.amax().max(k.amax());
        let lowest = symmetric_eigen(&rest).map_or(f64::NAN, |e| e.values.min());
        report.unless(lowest >= -1e-8 * scale, rule, || {
            format!("they store more energy than the stiffness, by {lowest:e}")
        });
    }
    Ok(())
}

/// Sizes, finite numbers, zeros at untouched dofs; without them nothing else is worth asking.
fn shape(element: &dyn Element, matrices: &Matrices, report: &mut Report) -> bool {
    let n = 6 * element.nodes().len();
    let touched = touched(element);
    let before = report.0.len();
    for (name, matrix) in MATRIX_NAMES.iter().zip(&matrices.0) {
        if matrix.n() != n {
            report.add("shape", format!("{name} has {} rows, not {n}", matrix.n()));
            continue;
        }
        for i in 0..n {
            let row = || (0..n).map(|j| matrix.get(i, j));
            report.unless(row().all(f64::is_finite), "shape", || format!("{name} is not finite in row {i}"));
            report.unless(touched[i] || row().all(|x| x == 0.0), "shape", || {
                format!("{name} is not zero in row {i}, a dof that the element does not declare")
            });
        }
    }
    report.0.len() == before
}

fn touched(element: &dyn Element) -> Vec<bool> {
    let mut touched = vec![false; 6 * element.nodes().len()];
    for (node, dofs) in element.nodes().iter().enumerate() {
        for dof in *dofs {
            touched[6 * node + *dof as usize] = true;
        }
    }
    touched
}

/// Rigid motions of the nodes as columns, three translations and three rotations about the first node: (6 nodes) x 6.
fn rigid_modes(points: &[[f64; 3]]) -> DMatrix<f64> {
    let mut r = DMatrix::zeros(6 * points.len(), 6);
    for (node, [x, y, z]) in points.iter().enumerate() {
        for d in 0..6 {
            r[(6 * node + d, d)] = 1.0;
        }
        // θ × p
        for (d, rotation, arm) in [(0, 4, *z), (0, 5, -y), (1, 3, -z), (1, 5, *x), (2, 3, *y), (2, 4, -x)] {
            r[(6 * node + d, rotation)] = arm;
        }
    }
    r
}

/// Eigenvalues of a matrix scaled to unit diagonal, its dofs without any entry left out: how many are positive, and
/// the lowest. A count of positive ones is a rank: below 1e-9 is rounding, and elements of which two mechanisms differ
/// more than that after scaling are not samples.
fn spectrum(a: &DMatrix<f64>) -> (usize, f64) {
    let kept: Vec<usize> = (0..a.nrows()).filter(|&i| a[(i, i)] > 0.0).collect();
    if kept.is_empty() {
        return (0, 0.0);
    }
    let scaled = DMatrix::from_fn(kept.len(), kept.len(), |i, j| {
        let (i, j) = (kept[i], kept[j]);
        a[(i, j)] / (a[(i, i)] * a[(j, j)]).sqrt()
    });
    let Ok(SymmetricEigen { values, .. }) = symmetric_eigen(&scaled) else { return (0, f64::NAN) };
    (values.iter().filter(|v| **v > 1e-9).count(), values.min())
}

fn definiteness(dense: &[DMatrix<f64>; 3], report: &mut Report) {
    for (name, a) in MATRIX_NAMES.iter().zip(dense) {
        let lowest = spectrum(a).1;
        report.unless(lowest > -ROUNDING, "definiteness", || {
            format!("{name} scaled to unit diagonal has the eigenvalue {lowest:.2e}: negative energy")
        });
        let stray = (0..a.nrows()).find(|&i| a[(i, i)] <= 0.0 && a.row(i).iter().any(|x| *x != 0.0));
        report.unless(stray.is_none(), "definiteness", || {
            format!("{name} has entries in row {} but no positive diagonal", stray.unwrap_or_default())
        });
    }
}

fn rigid_motion(
    element: &dyn Element,
    sample: &Sample,
    input: &ElementInput<'_>,
    dense: &[DMatrix<f64>; 3],
    rigid: &DMatrix<f64>,
    report: &mut Report,
) {
    let rule = "rigid motion";
    let [k, _, c] = dense;
    if sample.free {
        for (name, a) in [("stiffness", k), ("damping", c)] {
            let (force, size) = (a * rigid, a.abs() * rigid.abs());
            let worst = force.iter().zip(size.iter()).find(|(f, s)| f.abs() > ROUNDING * **s);
            report.unless(worst.is_none(), rule, || {
                format!("{name} resists it with {:.2e}", worst.map_or(0.0, |(f, _)| f.abs()))
            });
        }
    }
    if element.is_scalar() || !element.lacks(input).is_empty() || k.iter().all(|x| *x == 0.0) {
        return;
    }
    let touched = touched(element);
    let rows: Vec<usize> = (0..touched.len()).filter(|&i| touched[i]).collect();
    let reach = sample.points.iter().flatten().fold(0.0_f64, |a, x| a.max(x.abs()));
    let reach = if reach > 0.0 { reach } else { 1.0 };
    let seen = DMatrix::from_fn(rows.len(), 6, |i, j| {
        let unit = |d: usize| if d >= 3 { 1.0 / reach } else { 1.0 };
        rigid[(rows[i], j)] * unit(j) / unit(rows[i] % 6)
    });
    let modes = if sample.free { seen.rank(1e-9) } else { 0 };
    let (rank, _) = spectrum(k);
    // A preloaded element resists rotation, and still not translation: its rank lies between the two.
    let translations = seen.columns(0, 3).into_owned().rank(1e-9);
    let highest = rows.len() - modes;
    let lowest = if sample.free { highest } else { rows.len() - seen.rank(1e-9).max(translations) };
    report.unless((lowest..=highest).contains(&rank), rule, || {
        format!(
            "the stiffness has rank {rank} over {} dofs with {modes} rigid motions: it should be {highest}",
            rows.len()
        )
    });
}

/// The mass seen by rigid motions, Rᵀ M R (6 x 6) = [m I, -m [c]x; m [c]x, J], is that of a real body.
fn rigid_body(element: &dyn Element, sample: &Sample, b: &DMatrix<f64>, report: &mut Report) {
    let rule = "mass";
    if element.is_scalar() {
        return;
    }
    let all = touched(element);
    let moves: Vec<usize> = (0..3).filter(|&d| (d..all.len()).step_by(6).all(|i| all[i])).collect();
    let size = sample.mass.abs().max(f64::MIN_POSITIVE);
    for &d in &moves {
        for &e in &moves {
            let expected = if d == e { sample.mass } else { 0.0 };
            report.unless((b[(d, e)] - expected).abs() <= ROUNDING * size, rule, || {
                format!("translations {d} and {e} see {} kg, not {expected} kg", b[(d, e)])
            });
        }
    }
    if moves.len() < 3 || sample.mass == 0.0 {
        return;
    }
    // Centre of gravity from the coupling block: column of rotation j, row of translation i is m (e_j × c)_i.
    let [x, y, z] = [b[(1, 5)], b[(2, 3)], b[(0, 4)]].map(|s| s / sample.mass);
    let reach = (b[(3, 3)] + b[(4, 4)] + b[(5, 5)]).abs().sqrt() * sample.mass.sqrt();
    for (i, j, expected) in [(0, 5, -y), (1, 3, -z), (2, 4, -x), (0, 3, 0.0), (1, 4, 0.0), (2, 5, 0.0)] {
        report.unless((b[(i, j)] - sample.mass * expected).abs() <= ROUNDING * reach, rule, || {
            format!("the coupling of translation {i} and rotation {} is not that of a centre of gravity", j - 3)
        });
    }
    let about_cg = DMatrix::from_fn(3, 3, |i, j| {
        let c = [x, y, z];
        let square = if i == j { c.iter().map(|x| x * x).sum::<f64>() } else { 0.0 };
        b[(3 + i, 3 + j)] - sample.mass * (square - c[i] * c[j])
    });
    let lowest = about_cg.symmetric_eigenvalues().min();
    report.unless(lowest >= -ROUNDING * reach * reach / sample.mass, rule, || {
        format!("the inertia about the centre of gravity is negative: {lowest:.2e} kg m2")
    });
}

/// Exponents of (length, mass, time) in a unit such as `rad/(N m)`.
fn dimension(unit: &str) -> Option<[i32; 3]> {
    let (above, below) = unit.split_once('/').unwrap_or((unit, "1"));
    let mut total = [0; 3];
    for (part, sign) in [(above, 1), (below.trim_start_matches('(').trim_end_matches(')'), -1)] {
        for word in part.split_whitespace().filter(|w| *w != "1") {
            let symbol = word.trim_end_matches(|c: char| c.is_ascii_digit());
            let power = if symbol.len() == word.len() { 1 } else { word[symbol.len()..].parse::<i32>().ok()? };
            let base = match symbol {
                "rad" => [0, 0, 0],
                "m" => [1, 0, 0],
                "kg" => [0, 1, 0],
                "s" => [0, 0, 1],
                "N" => [1, 1, -2],
                "Pa" => [-1, 1, -2],
                _ => return None,
            };
            for (t, b) in total.iter_mut().zip(base) {
                *t += sign * power * b;
            }
        }
    }
    Some(total)
}

/// The same element in units 1/2 m, 1/8 kg, 4 s: energies, and with them every entry, scale as their units say.
///
/// Doubling E in another unit of time, halving the density in another unit of mass: the scaling laws of each property
/// follow from its unit.
fn units(
    element: &dyn Element,
    input: &ElementInput<'_>,
    dense: &[DMatrix<f64>; 3],
    report: &mut Report,
) -> Result<(), ElementError> {
    for scale in [[2.0, 1.0, 1.0], [1.0, 8.0, 1.0], [1.0, 1.0, 0.25], [2.0, 8.0, 0.25]] {
        let factor = |d: [i32; 3]| -> f64 { scale.iter().zip(d).map(|(s, p): (&f64, i32)| s.powi(p)).product() };
        let points: Vec<[f64; 3]> = input.points.iter().map(|p| p.map(|x| x * scale[0])).collect();
        let rescaled = |(property, value): (&Property, &Option<f64>)| {
            value.map(|v| v * factor(dimension(property.unit).unwrap_or_default()))
        };
        let values: Vec<_> = element.properties().iter().zip(input.values).map(rescaled).collect();
        let other = Matrices::of(element, &ElementInput { points: &points, values: &values })?.dense();
        for (which, power) in [0, 2, 1].into_iter().enumerate() {
            let (a, b) = (&dense[which], &other[which]);
            // Energy k q²/2, m v²/2 and c v²/2 per rate: (kg m² s⁻²) times s⁰, s², s¹.
            let energy = factor([2, 1, power - 2]);
            let per_dof = |i: usize| if i % 6 >= 3 { 1.0 } else { 1.0 / scale[0] };
            let worst = (0..a.len()).map(|l| (l / a.nrows(), l % a.nrows())).find(|&(i, j)| {
                let expected = a[(i, j)] * energy * per_dof(i) * per_dof(j);
                let size = (b[(i, i)] * b[(j, j)]).sqrt();
                (b[(i, j)] - expected).abs() > ROUNDING * size.max(expected.abs())
            });
            report.unless(worst.is_none(), "units", || {
                format!(
                    "{} does not scale with the declared units, entry {:?}, for units of length, mass, time {scale:?}",
                    MATRIX_NAMES[which],
                    worst.unwrap_or_default()
                )
            });
        }
    }
    Ok(())
}

/// Whether one per cent of a property changes a matrix by more than rounding.
fn matters(element: &dyn Element, input: &ElementInput<'_>, index: usize, dense: &[DMatrix<f64>; 3]) -> bool {
    let Some(value) = input.values[index] else { return false };
    let mut values = input.values.to_vec();
    values[index] = Some(value * 0.99);
    let Ok(other) = Matrices::of(element, &ElementInput { points: input.points, values: &values }) else {
        return false;
    };
    let other = other.dense();
    (0..3).any(|which| {
        let (a, b) = (&dense[which], &other[which]);
        (0..a.nrows()).any(|i| {
            (0..=i)
                .any(|j| (a[(i, j)] - b[(i, j)]).abs() > 1e-9 * (a[(i, i)] * a[(j, j)]).sqrt().max(f64::MIN_POSITIVE))
        })
    })
}

fn refusals(element: &dyn Element, input: &ElementInput<'_>, report: &mut Report) {
    let rule = "refusals";
    let refused = |points: &[[f64; 3]], values: &[Option<f64>]| {
        let input = ElementInput { points, values };
        element.stiffness(&input).is_err() && element.mass(&input).is_err()
    };
    for (i, property) in element.properties().iter().enumerate().filter(|(i, _)| input.values[*i].is_some()) {
        let outside: &[f64] = match property.domain {
            Domain::Positive => &[f64::NAN, f64::INFINITY, 0.0, -1.0],
            Domain::NonNegative => &[f64::NAN, f64::INFINITY, -1.0],
            Domain::Fraction => &[f64::NAN, 1.5, -0.5],
            Domain::Compliance => &[f64::NAN, -1.0],
            Domain::Any => &[f64::NAN, f64::INFINITY],
        };
        for &bad in outside {
            let mut values = input.values.to_vec();
            values[i] = Some(bad);
            report.unless(refused(input.points, &values), rule, || format!("`{}` = {bad} is accepted", property.name));
        }
    }
    let more = [input.values, &[None]].concat();
    report.unless(refused(input.points, &more), rule, || "one value too many is accepted".into());
    report.unless(refused(&[], input.values), rule, || "an element without nodes is accepted".into());
}

/// The nearest point of a surface or a volume: a rigid motion of the nodes is the same there; a node is nearest to itself.
fn nearest(
    element: &dyn Element,
    input: &ElementInput<'_>,
    rigid: &DMatrix<f64>,
    report: &mut Report,
) -> Result<(), ElementError> {
    let middle: [f64; 3] =
        std::array::from_fn(|i| input.points.iter().map(|p| p[i]).sum::<f64>() / input.points.len().max(1) as f64);
    for place in input.points.iter().copied().chain([middle]) {
        let Some(found) = element.nearest(input, place)? else { return Ok(()) };
        let there = rigid_modes(&[found.at]);
        let reach = input.points.iter().flatten().fold(0.0_f64, |a, x| a.max(x.abs()));
        let off = (0..3).map(|i| (found.at[i] - place[i]).abs()).fold(0.0, f64::max);
        // The middle of the nodes of a warped surface lies on it by its functions.
        report.unless(off <= 1e-8 * reach, "nearest", || format!("the point at {place:?} is found {off:.2e} m off"));
        for (i, row) in found.rows.iter().enumerate() {
            for j in 0..6 {
                let parts = row.iter().enumerate().map(|(k, r)| r * rigid[(k, j)]);
                let (sum, size) = parts.fold((0.0, 1.0_f64), |(s, a), x| (s + x, a + x.abs()));
                report.unless((sum - there[(i, j)]).abs() <= 1e-9 * size, "nearest", || {
                    format!("rigid motion {j} gives {sum} in dof {i}, not {}", there[(i, j)])
                });
            }
        }
    }
    Ok(())
}

/// N(ξ) R = R(ξ): rigid motion of the nodes is rigid motion along the element.
fn interpolation(
    element: &dyn Element,
    input: &ElementInput<'_>,
    rigid: &DMatrix<f64>,
    report: &mut Report,
) -> Result<(), ElementError> {
    let end = input.points.get(1).copied().unwrap_or_default();
    for xi in [0.0, 0.3, 0.5, 1.0] {
        let rows = element.interpolate(input, xi)?;
        let there = rigid_modes(&[end.map(|x| xi * x)]);
        for (i, row) in rows.iter().enumerate() {
            for j in 0..6 {
                let parts = (0..rigid.nrows().min(12)).map(|k| row[k] * rigid[(k, j)]);
                let (sum, size) = parts.fold((0.0, 1.0_f64), |(s, a), x| (s + x, a + x.abs()));
                report.unless((sum - there[(i, j)]).abs() <= ROUNDING * size, "interpolation", || {
                    format!("at {xi} rigid motion {j} gives {sum} in dof {i}, not {}", there[(i, j)])
                });
            }
        }
    }
    Ok(())
}
