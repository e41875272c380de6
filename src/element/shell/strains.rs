//! Strains within a shell, and the displacements that go with them.

use super::super::ElementError;
use super::super::strain_field::{StrainField, StrainPoint};
use super::Input;
use super::kernel::{Enhanced, Frame, plane_mass};
use super::material::{self, mass_of, offset};
use super::plane::{DOFS, Flat, Modes, Plane, Row};
use crate::linalg::DMatrix;

/// The strains; `None` of a shell that is mass alone.
///
/// Errors: as of the stiffness.
pub(super) fn strain_field(plane: &'static Plane, input: &Input<'_>) -> Result<Option<StrainField>, ElementError> {
    let frame = Frame::new(input.points)?;
    let flat = Flat { plane, at: &frame.at, height: &frame.height };
    let Some(section) = material::section(input, frame.material_angle)? else { return Ok(None) };
    let nodes = frame.at.len();
    let n = DOFS * nodes;
    let rigidity = section.whole();
    let rule = (plane.rules[1])();
    let membrane = plane.strains.unwrap_or(plane.membrane);
    // Strains of the dofs, and those that the membrane adds of itself.
    let mut at_points: Vec<([Row; 6], Option<Modes>)> = Vec::new();
    let mut enhanced = Enhanced::new(n);
    for &(xi, weight) in &rule {
        let at = flat.local(xi)?;
        let (stretch, bend) = (membrane(&flat, xi, &at), flat.bending(&at));
        let rows: [Row; 6] = std::array::from_fn(|i| if i < 3 { stretch[i] } else { bend[i - 3] });
        let modes = plane.modes.map(|modes| modes(&flat, xi, &at)).transpose()?;
        if let Some(modes) = &modes {
            enhanced.add(modes, &rows, &rigidity, weight * at.det);
        }
        at_points.push((rows, modes));
    }
    let added = plane.modes.map(|_| enhanced.amplitudes()).transpose()?;
    let carry = frame.carry(offset(input));
    let [per_area, ..] = mass_of(input)?;
    let mut mass = plane_mass(&flat, input, 0.0)?;
    let mut points = Vec::with_capacity(rule.len());
    for (&(xi, weight), (mut rows, modes)) in rule.iter().zip(at_points) {
        let at = flat.local(xi)?;
        if let (Some(modes), Some(added)) = (modes, &added) {
            for (row, modes) in rows.iter_mut().zip(modes) {
                (0..n).for_each(|j| row[j] += (0..4).map(|a| modes[a] * added[(a, j)]).sum::<f64>());
            }
        }
        let within = (plane.within)(&flat, xi, &at, added.as_ref())?;
        add_within(&mut mass, &within, &at.n[..nodes], per_area * weight * at.det);
        let carried = |row: &Row| -> Vec<f64> {
            let of = |k: usize, j: usize| (0..DOFS).map(|i| row[DOFS * k + i] * carry[i][j]).sum();
            (0..n).map(|d| of(d / DOFS, d % DOFS)).collect()
        };
        points.push(StrainPoint {
            at: std::array::from_fn(|i| at.n.iter().zip(input.points).map(|(n, p)| n * p[i]).sum()),
            n: at.n[..nodes].to_vec(),
            weight: weight * at.det,
            is_sample: true,
            rows: std::array::from_fn(|i| carried(&rows[i])),
        });
    }
    Ok(Some(StrainField {
        points,
        rigidity,
        plane: Some(frame.axes),
        order: 1,
        hourglass: None,
        mass: frame.to_nodes(&mass, offset(input)),
    }))
}

/// Adds w (Nᵀ b + bᵀ N + bᵀ b), b the displacements u, v, w within the element beside those N of its nodes.
fn add_within(m: &mut DMatrix<f64>, within: &[Row; 3], functions: &[f64], w: f64) {
    let n = DOFS * functions.len();
    for (d, b) in within.iter().enumerate() {
        for j in (0..n).filter(|&j| b[j] != 0.0) {
            for (k, f) in functions.iter().enumerate() {
                m[(DOFS * k + d, j)] += w * f * b[j];
                m[(j, DOFS * k + d)] += w * f * b[j];
            }
            for i in 0..n {
                m[(i, j)] += w * b[i] * b[j];
            }
        }
    }
}

/// The forces by width N11, N22, N12 along the material of a shell that displacements leave in it, N/m.
pub(super) fn preload_of(
    plane: &'static Plane,
    input: &Input<'_>,
    u: &[f64],
) -> Result<Vec<(&'static str, f64)>, ElementError> {
    let Some(field) = strain_field(plane, input)? else { return Ok(Vec::new()) };
    let [xx, yy, xy, ..] = field.mean_forces(u);
    let frame = Frame::new(input.points)?;
    let along = material::to_material([xx, yy, xy], input, frame.material_angle);
    Ok(material::PRELOADS.iter().copied().zip(along).collect())
}
