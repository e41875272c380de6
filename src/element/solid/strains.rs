//! Strains within a solid, and the displacements that go with them.

use super::super::ElementError;
use super::super::strain_field::{StrainField, StrainPoint};
use super::kernel::{Middle, add_hourglass, consistent, enriched, enriched_gradients, mean_gradients, middle, strain};
use super::material::{self, elasticity, mass_of};
use super::{At, Enrichment, Family, Input, rules};
use crate::linalg::{DMatrix, SymMatrix};

/// The strains; `None` of a solid that is mass alone.
///
/// Errors: as of the stiffness.
pub(super) fn strain_field(family: &Family, input: &Input<'_>) -> Result<Option<StrainField>, ElementError> {
    let Some(rigidity) = elasticity(input)? else { return Ok(None) };
    let n = input.points.len();
    let added = match middle(family, input.points)? {
        Some(middle) => Some(Added { middle, amplitudes: amplitudes(family, input.points, &rigidity)? }),
        None => None,
    };
    let is_constant = family.stiffness.len() == 1;
    // The strains of quadratic bricks are the most accurate at two points a direction.
    let best: Vec<At>;
    let samples = if n == 20 {
        best = rules::cube(2).into_iter().map(|(xi, w)| At::new(family.shape, xi, w)).collect();
        &best
    } else {
        &family.stiffness
    };
    let is_one_rule = samples.len() == family.mass.len();
    let mut points = Vec::with_capacity(samples.len() + family.mass.len());
    if !is_one_rule {
        for at in samples {
            points.push(StrainPoint { weight: 0.0, is_sample: true, ..point(at, input.points, added.as_ref())? });
        }
    }
    for at in &family.mass {
        let own = point(at, input.points, added.as_ref())?;
        points.push(StrainPoint { is_sample: is_one_rule, ..own });
    }
    if is_constant {
        let rows = rows(&mean_gradients(family, input.points)?.0, n, None);
        for p in &mut points {
            p.rows.clone_from(&rows);
        }
    }
    let mass = mass(family, input, added.as_ref())?;
    let hourglass = hourglass(family, input.points, &rigidity)?;
    let order = if n > 8 { 2 } else { 1 };
    Ok(Some(StrainField { points, rigidity, plane: None, order, hourglass, mass }))
}

/// Incompatible modes: the Jacobian of the centre, and their amplitudes by the displacements.
struct Added {
    middle: Middle,
    amplitudes: DMatrix<f64>,
}

/// Amplitudes of the incompatible modes by the displacements, three each: -K_aa⁻¹ K_au.
fn amplitudes(family: &Family, points: &[[f64; 3]], d: &material::Elasticity) -> Result<DMatrix<f64>, ElementError> {
    let (k, size) = enriched(family, points, d)?;
    let kept = 3 * points.len();
    let at = |i: usize, j: usize| k[i.max(j) * size + i.min(j)];
    let own = DMatrix::from_fn(size - kept, size - kept, |i, j| at(kept + i, kept + j));
    let with = DMatrix::from_fn(size - kept, kept, |i, j| at(kept + i, j));
    Ok(-own.cholesky().ok_or(ElementError::Inverted)?.solve(&with))
}

/// The stiffness against hourglass patterns.
fn hourglass(
    family: &Family,
    points: &[[f64; 3]],
    d: &material::Elasticity,
) -> Result<Option<SymMatrix>, ElementError> {
    if family.enrichment != Enrichment::Hourglass {
        return Ok(None);
    }
    let size = 3 * points.len();
    let mut k = vec![0.0; size * size];
    let (gradients, volume) = mean_gradients(family, points)?;
    add_hourglass(&mut k, size, points, (&gradients, volume), d);
    let mut out = SymMatrix::zeros(2 * size);
    for i in 0..size {
        for j in 0..=i {
            out.add(6 * (i / 3) + i % 3, 6 * (j / 3) + j % 3, k[i * size + j]);
        }
    }
    Ok(Some(out))
}

fn point(at: &At, points: &[[f64; 3]], added: Option<&Added>) -> Result<StrainPoint, ElementError> {
    let n = points.len();
    let (gradients, weight) = enriched_gradients(at, points, added.map(|a| &a.middle))?;
    let rows = rows(&gradients, n, added);
    let place = |i: usize| at.n.iter().zip(points).map(|(n, p)| n * p[i]).sum();
    Ok(StrainPoint { at: std::array::from_fn(place), n: at.n.clone(), weight, is_sample: false, rows })
}

/// Strains by the dofs, from the gradients of the functions of `n` nodes and of incompatible modes behind them.
fn rows(gradients: &[[f64; 3]], n: usize, added: Option<&Added>) -> [Vec<f64>; 6] {
    let mut rows: [Vec<f64>; 6] = std::array::from_fn(|_| vec![0.0; 6 * n]);
    for (k, g) in gradients.iter().enumerate() {
        for axis in 0..3 {
            let strains = strain(g, axis);
            for (row, value) in rows.iter_mut().zip(strains).filter(|(_, v)| *v != 0.0) {
                if k < n {
                    row[6 * k + axis] += value;
                } else if let Some(added) = added {
                    let own = added.amplitudes.row(3 * (k - n) + axis);
                    own.iter().enumerate().for_each(|(j, a)| row[6 * (j / 3) + j % 3] += value * a);
                }
            }
        }
    }
    rows
}

/// ∫ ρ (N + b)ᵀ (N + b) dV, b = Σ (1 - ξ²) α the displacements of the incompatible modes.
fn mass(family: &Family, input: &Input<'_>, added: Option<&Added>) -> Result<SymMatrix, ElementError> {
    let n = input.points.len();
    let (density, _) = mass_of(input);
    let (consistent, _) = consistent(family, input.points, density)?;
    let mut out = SymMatrix::zeros(6 * n);
    for i in 0..n {
        for j in 0..=i {
            (0..3).for_each(|axis| out.add(6 * i + axis, 6 * j + axis, consistent[i * n + j]));
        }
    }
    let Some(added) = added else { return Ok(out) };
    for at in &family.mass {
        let (_, volume) = enriched_gradients(at, input.points, None)?;
        let w = density * volume;
        for axis in 0..3 {
            let b: Vec<f64> = (0..3 * n)
                .map(|j| (0..3).map(|m| (1.0 - at.xi[m] * at.xi[m]) * added.amplitudes[(3 * m + axis, j)]).sum())
                .collect();
            let own = |j: usize| if j % 3 == axis { at.n[j / 3] } else { 0.0 };
            for i in 0..3 * n {
                for j in 0..=i {
                    let both = own(i) * b[j] + b[i] * own(j) + b[i] * b[j];
                    out.add(6 * (i / 3) + i % 3, 6 * (j / 3) + j % 3, w * both);
                }
            }
        }
    }
    Ok(out)
}

/// The stresses that displacements leave in a solid, in the mean over it, Pa.
pub(super) fn preload_of(
    family: &Family,
    input: &Input<'_>,
    u: &[f64],
) -> Result<Vec<(&'static str, f64)>, ElementError> {
    let Some(field) = strain_field(family, input)? else { return Ok(Vec::new()) };
    Ok(material::PRELOADS.iter().copied().zip(field.mean_forces(u)).collect())
}
