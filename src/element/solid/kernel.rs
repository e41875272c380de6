//! Stiffness and mass of an isoparametric solid.

use super::super::{ElementError, PointWithin};
use super::material::{Elasticity, elasticity, mass_of, preload};
use super::{At, Enrichment, Family, Input};
use crate::linalg::SymMatrix;

/// Three vectors as rows.
type Three = [[f64; 3]; 3];

fn determinant(j: &Three) -> f64 {
    j[0][0] * (j[1][1] * j[2][2] - j[1][2] * j[2][1]) - j[0][1] * (j[1][0] * j[2][2] - j[1][2] * j[2][0])
        + j[0][2] * (j[1][0] * j[2][1] - j[1][1] * j[2][0])
}

/// The inverse of a matrix of this determinant.
fn inverse(j: &Three, det: f64) -> Three {
    let minor = |a: usize, b: usize, c: usize, d: usize| j[a][b] * j[c][d] - j[a][d] * j[c][b];
    let adjugate = [
        [minor(1, 1, 2, 2), -minor(0, 1, 2, 2), minor(0, 1, 1, 2)],
        [-minor(1, 0, 2, 2), minor(0, 0, 2, 2), -minor(0, 0, 1, 2)],
        [minor(1, 0, 2, 1), -minor(0, 0, 2, 1), minor(0, 0, 1, 1)],
    ];
    adjugate.map(|row| row.map(|v| v / det))
}

/// J_ij = ∂x_j/∂ξ_i.
fn jacobian(at: &At, points: &[[f64; 3]]) -> Three {
    let mut j = [[0.0; 3]; 3];
    for (d, p) in at.d.iter().zip(points) {
        for a in 0..3 {
            for b in 0..3 {
                j[a][b] += d[a] * p[b];
            }
        }
    }
    j
}

/// The determinant of the Jacobian at a point, refused where it is not positive: the element is turned inside out there, or flat.
fn volume_ratio(j: &Three) -> Result<f64, ElementError> {
    let det = determinant(j);
    // A flat element has rounding to either side of zero.
    let size: f64 = j.iter().map(|row| row.iter().map(|v| v * v).sum::<f64>().sqrt()).product();
    if det > 1e-12 * size && det.is_finite() { Ok(det) } else { Err(ElementError::Inverted) }
}

/// ∂N/∂x of every function, and the element of volume.
fn gradients(at: &At, points: &[[f64; 3]]) -> Result<(Vec<[f64; 3]>, f64), ElementError> {
    let j = jacobian(at, points);
    let det = volume_ratio(&j)?;
    let inverse = inverse(&j, det);
    Ok((at.d.iter().map(|d| turned(&inverse, d)).collect(), det * at.weight))
}

/// J⁻¹ ∂N/∂ξ.
fn turned(inverse: &Three, d: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| (0..3).map(|k| inverse[i][k] * d[k]).sum())
}

/// Rows of B for the displacement `axis` of a function with gradient g: strains xx yy zz xy yz zx.
pub(super) fn strain(g: &[f64; 3], axis: usize) -> [f64; 6] {
    let [x, y, z] = *g;
    match axis {
        0 => [x, 0.0, 0.0, y, 0.0, z],
        1 => [0.0, y, 0.0, x, z, 0.0],
        _ => [0.0, 0.0, z, 0.0, y, x],
    }
}

/// Adds w Bᵀ D B over functions i ≥ j, three displacements each, into a full matrix of `size` rows, lower triangle.
fn add_energy(k: &mut [f64], size: usize, gradients: &[[f64; 3]], d: &Elasticity, w: f64) {
    let columns: Vec<[f64; 6]> = gradients.iter().flat_map(|g| (0..3).map(move |axis| strain(g, axis))).collect();
    for (i, row) in columns.iter().enumerate() {
        let stress: [f64; 6] = std::array::from_fn(|a| w * (0..6).map(|b| d[a][b] * row[b]).sum::<f64>());
        for (j, column) in columns.iter().enumerate().take(i + 1) {
            k[i * size + j] += (0..6).map(|a| stress[a] * column[a]).sum::<f64>();
        }
    }
}

/// Stiffness, (6 nodes) x (6 nodes), zero at rotations.
///
/// Errors: a material that is not complete or stores no energy; an element that is inverted or flat at a point of the rule.
pub(super) fn stiffness(family: &Family, input: &Input<'_>) -> Result<SymMatrix, ElementError> {
    let n = input.points.len();
    let Some(d) = elasticity(input)? else {
        for at in &family.stiffness {
            volume_ratio(&jacobian(at, input.points))?;
        }
        let mut out = SymMatrix::zeros(6 * n);
        add_preload(&mut out, family, input)?;
        return Ok(out);
    };
    let (mut k, size) = enriched(family, input.points, &d)?;
    condense(&mut k, size, 3 * n)?;
    let mut out = SymMatrix::zeros(6 * n);
    for i in 0..3 * n {
        for j in 0..=i {
            out.add(6 * (i / 3) + i % 3, 6 * (j / 3) + j % 3, k[i * size + j]);
        }
    }
    add_preload(&mut out, family, input)?;
    Ok(out)
}

/// The stiffness of displacements, three a node, and of incompatible modes behind them, lower triangle by rows; and its rows.
pub(super) fn enriched(
    family: &Family,
    points: &[[f64; 3]],
    d: &Elasticity,
) -> Result<(Vec<f64>, usize), ElementError> {
    let extra = if family.enrichment == Enrichment::IncompatibleModes { 3 } else { 0 };
    let size = 3 * (points.len() + extra);
    let mut k = vec![0.0; size * size];
    if family.enrichment == Enrichment::Hourglass {
        let (gradients, volume) = mean_gradients(family, points)?;
        add_energy(&mut k, size, &gradients, d, volume);
        add_hourglass(&mut k, size, points, (&gradients, volume), d);
        return Ok((k, size));
    }
    let middle = middle(family, points)?;
    for at in &family.stiffness {
        let (gradients, w) = enriched_gradients(at, points, middle.as_ref())?;
        add_energy(&mut k, size, &gradients, d, w);
    }
    Ok((k, size))
}

/// ∂N/∂x in the mean over the element, and its volume, both exact by the points of the mass. Those of the centre differ on distorted elements, where
/// their forces are not those of a constant stress.
pub(super) fn mean_gradients(family: &Family, points: &[[f64; 3]]) -> Result<(Vec<[f64; 3]>, f64), ElementError> {
    let (mut mean, mut volume) = (vec![[0.0; 3]; points.len()], 0.0);
    for at in &family.mass {
        let (gradients, w) = gradients(at, points)?;
        volume += w;
        for (mean, g) in mean.iter_mut().zip(gradients) {
            (0..3).for_each(|axis| mean[axis] += w * g[axis]);
        }
    }
    mean.iter_mut().flatten().for_each(|v| *v /= volume);
    Ok((mean, volume))
}

/// ∂N/∂x of every function and, behind them, of every incompatible mode, and the element of volume.
///
/// * `middle` - of [`middle`]
pub(super) fn enriched_gradients(
    at: &At,
    points: &[[f64; 3]],
    middle: Option<&Middle>,
) -> Result<(Vec<[f64; 3]>, f64), ElementError> {
    let (mut gradients, w) = gradients(at, points)?;
    if let Some((inverse, det)) = middle {
        // ∂(1 - ξ²)/∂x with the Jacobian of the centre, so that constant strains do no work on them.
        let ratio = det * at.weight / w;
        for axis in 0..3 {
            let mut slope = [0.0; 3];
            slope[axis] = -2.0 * at.xi[axis] * ratio;
            gradients.push(turned(inverse, &slope));
        }
    }
    Ok((gradients, w))
}

/// Adds the geometric stiffness ∫ ∇uᵀ σ ∇u dV of each displacement, at the points of the mass.
fn add_preload(k: &mut SymMatrix, family: &Family, input: &Input<'_>) -> Result<(), ElementError> {
    let Some(stress) = preload(input) else { return Ok(()) };
    for at in &family.mass {
        let (gradients, w) = gradients(at, input.points)?;
        for (i, g) in gradients.iter().enumerate() {
            let force: [f64; 3] = std::array::from_fn(|a| w * (0..3).map(|b| stress[a][b] * g[b]).sum::<f64>());
            for (j, other) in gradients.iter().enumerate().take(i + 1) {
                let both: f64 = (0..3).map(|a| force[a] * other[a]).sum();
                (0..3).for_each(|axis| k.add(6 * i + axis, 6 * j + axis, both));
            }
        }
    }
    Ok(())
}

/// J⁻¹ and det J in the centre.
pub(super) type Middle = (Three, f64);

/// Those of a hexahedron with incompatible modes; `None` of every other element.
pub(super) fn middle(family: &Family, points: &[[f64; 3]]) -> Result<Option<Middle>, ElementError> {
    if family.enrichment != Enrichment::IncompatibleModes {
        return Ok(None);
    }
    let at = At::new(super::hex8::shape, [0.0; 3], 8.0);
    let j = jacobian(&at, points);
    let det = volume_ratio(&j)?;
    Ok(Some((inverse(&j, det), det)))
}

/// Eliminates the rows from `kept` on, last first: K_ij -= K_ia K_ja / K_aa.
fn condense(k: &mut [f64], size: usize, kept: usize) -> Result<(), ElementError> {
    for a in (kept..size).rev() {
        let pivot = k[a * size + a];
        // A combination of incompatible modes always strains an element that is not flat.
        if pivot <= 0.0 || !pivot.is_finite() {
            return Err(ElementError::Inverted);
        }
        for i in 0..a {
            let factor = k[a * size + i] / pivot;
            for j in 0..=i {
                k[i * size + j] -= factor * k[a * size + j];
            }
        }
    }
    Ok(())
}

/// The patterns of displacements of eight nodes that a point in the centre takes for nothing: ηζ, ζξ, ξη, ξηζ.
const HOURGLASS: [[f64; 8]; 4] = [
    [1.0, 1.0, -1.0, -1.0, -1.0, -1.0, 1.0, 1.0],
    [1.0, -1.0, -1.0, 1.0, -1.0, 1.0, 1.0, -1.0],
    [1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0, 1.0, 1.0, -1.0, 1.0, -1.0],
];

/// Stiffness against hourglass patterns, as a share of the shear modulus: what Abaqus documents as its default for solids.
const HOURGLASS_SHARE: f64 = 0.005;

/// Adds the stiffness against each of the four patterns h, orthogonal to linear fields:
///
/// ```text
/// γ = h - Σ_axis (h·x_axis) ∂N/∂x_axis,    q = γᵀu/√8,    Q = ½ κ G V Σ_i |∂N_i/∂x|² q        κ = 0.005, G: the mean shear modulus
/// ```
///
/// # Source
/// D. P. Flanagan, T. Belytschko, A uniform strain hexahedron and quadrilateral with orthogonal hourglass control, Int. J. Numer.
/// Meth. Engng 17 (1981) 679-706, stiffness form.
///
/// * `g`, `volume` - of [`mean_gradients`]
pub(super) fn add_hourglass(
    k: &mut [f64],
    size: usize,
    points: &[[f64; 3]],
    (g, volume): (&[[f64; 3]], f64),
    d: &Elasticity,
) {
    let modulus = (d[3][3] + d[4][4] + d[5][5]) / 3.0;
    let squares: f64 = g.iter().flatten().map(|v| v * v).sum();
    // γᵀ/√8 on both sides of ½.
    let factor = HOURGLASS_SHARE * modulus * volume * squares / 16.0;
    for h in &HOURGLASS {
        let along: [f64; 3] = std::array::from_fn(|axis| h.iter().zip(points).map(|(h, p)| h * p[axis]).sum());
        let gamma: [f64; 8] = std::array::from_fn(|i| h[i] - (0..3).map(|axis| along[axis] * g[i][axis]).sum::<f64>());
        for axis in 0..3 {
            for i in 0..8 {
                for j in 0..=i {
                    k[(3 * i + axis) * size + 3 * j + axis] += factor * gamma[i] * gamma[j];
                }
            }
        }
    }
}

/// Mass, (6 nodes) x (6 nodes), zero at rotations: (1 - s) ∫ ρ N_i N_j dV + s × the lumped one, ∫ ρ N_i dV of first order, which keeps the
/// centre of gravity on any shape, and of second order, where that is negative at corners, the diagonal scaled to the whole mass.
///
/// # Source
/// Sums of rows: O. C. Zienkiewicz, R. L. Taylor, The Finite Element Method, volume 1, section on lumped mass.
/// Diagonal scaling: E. Hinton, T. Rock, O. C. Zienkiewicz, A note on mass lumping and related processes in the finite element
/// method, Earthquake Engng Struct. Dyn. 4 (1976) 245-249.
pub(super) fn mass(family: &Family, input: &Input<'_>) -> Result<SymMatrix, ElementError> {
    let n = input.points.len();
    // A material that could not be is refused by the mass too, so that an element is whole or not at all.
    elasticity(input)?;
    let (density, lumping) = mass_of(input);
    let (consistent, total) = consistent(family, input.points, density)?;
    let at = |i: usize, j: usize| consistent[i.max(j) * n + i.min(j)];
    let trace: f64 = (0..n).map(|i| at(i, i)).sum();
    // Functions of first order are nowhere negative, and so are their integrals.
    let lumped = |i: usize| match n {
        ..=8 => (0..n).map(|j| at(i, j)).sum(),
        _ if trace > 0.0 => at(i, i) * total / trace,
        _ => 0.0,
    };
    let mut out = SymMatrix::zeros(6 * n);
    for i in 0..n {
        for j in 0..=i {
            let mut m = (1.0 - lumping) * consistent[i * n + j];
            if i == j {
                m += lumping * lumped(i);
            }
            for axis in 0..3 {
                out.add(6 * i + axis, 6 * j + axis, m);
            }
        }
    }
    Ok(out)
}

/// ∫ ρ N_i N_j dV, (nodes x nodes), lower triangle by rows, and the whole mass.
pub(super) fn consistent(family: &Family, points: &[[f64; 3]], density: f64) -> Result<(Vec<f64>, f64), ElementError> {
    let n = points.len();
    let mut consistent = vec![0.0; n * n];
    let mut total = 0.0;
    for at in &family.mass {
        let w = density * at.weight * volume_ratio(&jacobian(at, points))?;
        total += w;
        for i in 0..n {
            for j in 0..=i {
                consistent[i * n + j] += w * at.n[i] * at.n[j];
            }
        }
    }
    Ok((consistent, total))
}

/// Natural coordinates moved into the parent of an element: of a tetrahedron, a pyramid, a wedge or a cube, by its number of nodes.
fn within_parent(n: usize, xi: [f64; 3]) -> [f64; 3] {
    let in_simplex = |x: &mut [f64]| {
        for v in x.iter_mut() {
            *v = v.max(0.0);
        }
        let sum: f64 = x.iter().sum();
        if sum > 1.0 {
            for v in x.iter_mut() {
                *v /= sum;
            }
        }
    };
    let [mut x, mut y, mut z] = xi;
    match n {
        4 | 10 => {
            let mut all = [x, y, z];
            in_simplex(&mut all);
            return all;
        }
        6 | 15 => {
            let mut base = [x, y];
            in_simplex(&mut base);
            [x, y] = base;
            z = z.clamp(-1.0, 1.0);
        }
        5 | 13 => {
            z = z.clamp(0.0, 1.0 - 1e-9);
            let side = 1.0 - z;
            [x, y] = [x, y].map(|v| v.clamp(-side, side));
        }
        _ => return xi.map(|v| v.clamp(-1.0, 1.0)),
    }
    [x, y, z]
}

/// The point of the volume by the shape functions that is nearest to a place, along natural coordinates: displacements are those of the nodes,
/// the rotation is half the curl there.
pub(super) fn nearest(family: &Family, input: &Input<'_>, place: [f64; 3]) -> Result<PointWithin, ElementError> {
    let points = input.points;
    let n = points.len();
    let start = match n {
        4 | 10 | 5 | 13 => [0.25; 3],
        6 | 15 => [1.0 / 3.0, 1.0 / 3.0, 0.0],
        _ => [0.0; 3],
    };
    let start = if n == 5 || n == 13 { [0.0, 0.0, 0.25] } else { start };
    let where_is =
        |at: &At| -> [f64; 3] { std::array::from_fn(|i| at.n.iter().zip(points).map(|(w, p)| w * p[i]).sum()) };
    let mut at = At::new(family.shape, start, 1.0);
    for _ in 0..30 {
        let j = jacobian(&at, points);
        let inverse = inverse(&j, volume_ratio(&j)?);
        let here = where_is(&at);
        let miss: [f64; 3] = std::array::from_fn(|i| place[i] - here[i]);
        // x changes by Jᵀ times ξ.
        let next: [f64; 3] = std::array::from_fn(|i| at.xi[i] + (0..3).map(|k| inverse[k][i] * miss[k]).sum::<f64>());
        let next = within_parent(n, next);
        let step = (0..3).map(|i| (next[i] - at.xi[i]).abs()).fold(0.0, f64::max);
        at = At::new(family.shape, next, 1.0);
        if step < 1e-13 {
            break;
        }
    }
    let (gradients, _) = gradients(&at, points)?;
    let mut rows: [Vec<f64>; 6] = std::array::from_fn(|_| vec![0.0; 6 * n]);
    for (k, (w, g)) in at.n.iter().zip(&gradients).enumerate() {
        for d in 0..3 {
            rows[d][6 * k + d] = *w;
            // θ = ½ ∇ × u
            let (next, last) = ((d + 1) % 3, (d + 2) % 3);
            rows[3 + d][6 * k + last] += 0.5 * g[next];
            rows[3 + d][6 * k + next] -= 0.5 * g[last];
        }
    }
    Ok(PointWithin { at: where_is(&at), rows })
}
