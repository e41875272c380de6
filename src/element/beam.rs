//! The `beam` element. Sketch, axes, equations, limits and sources: `beam.md`, the documentation of [`Beam`].

#[cfg(test)]
mod dynamics;
#[cfg(test)]
mod joints;
#[cfg(test)]
mod rigid_ends;
mod section;
#[cfg(test)]
mod statics;

use super::{Axes, Dof, Element, ElementError, ElementInput, Lack, Property, Sample, StrainParts, value};
use crate::linalg::SymMatrix;
use section::{PROPERTIES, Plane, Section};

#[doc = include_str!("beam.md")]
#[derive(Debug, Clone, Copy)]
pub struct Beam;

/// A generalised displacement as a combination of the twelve dofs.
type Row = [f64; 12];

/// The two bending planes: the displacement along y turns with +rz, that along z with -ry.
const PLANES: [Plane; 2] =
    [Plane { displacement: 1, rotation: 5, slope: 1.0 }, Plane { displacement: 2, rotation: 4, slope: -1.0 }];

/// Abscissae on [0, 1] and weights of the four-point Gauss rule, exact to degree seven: the mass needs six.
/// M. Abramowitz, I. A. Stegun, Handbook of Mathematical Functions, 1964, table 25.4.
const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// `a + s b`.
fn plus(mut a: Row, s: f64, b: &Row) -> Row {
    for (a, b) in a.iter_mut().zip(b) {
        *a += s * b;
    }
    a
}

/// From dofs of the elastic axis to dofs of the nodes: `u_e = u + θ × (x, y, z)`, rigid arms at both ends, x of them along the beam
/// where its end is rigid.
fn on_nodes(mut row: Row, section: &Section) -> Row {
    let [y, z] = section.shear_centre;
    for (first, x) in [(0, section.rigid[0]), (6, -section.rigid[1])] {
        let (u, v, w) = (row[first], row[first + 1], row[first + 2]);
        row[first + 3] += y * w - z * v;
        row[first + 4] += z * u;
        row[first + 5] -= y * u;
        if x != 0.0 {
            row[first + 4] -= x * w;
            row[first + 5] += x * v;
        }
    }
    row
}

/// The stretch of the neutral axis, from dofs of the elastic axis: `u + ry dz - rz dy`, second end minus first.
fn stretch(section: &Section) -> Row {
    let [dy, dz] = section.neutral_axis;
    plus(plus(difference(0), dz, &difference(4)), -dy, &difference(5))
}

/// The difference of dof `d` between the ends, second minus first.
fn difference(d: usize) -> Row {
    let mut row = [0.0; 12];
    (row[d], row[6 + d]) = (-1.0, 1.0);
    row
}

/// Shape functions of one plane: displacement and slope at `xi` from (v1, θ1, v2, θ2).
///
/// Cubic displacement with the constant shear strain that equilibrium implies; Hermite's for `phi` = 0.
/// Source: Z. Friedman, J. B. Kosmatka, An improved two-node Timoshenko beam finite element, Computers & Structures 47
/// (1993) 473-481.
#[rustfmt::skip]
fn shape(xi: f64, length: f64, phi: f64) -> ([f64; 4], [f64; 4]) {
    let (x, x2, x3) = (xi, xi * xi, xi * xi * xi);
    let d = 1.0 + phi;
    let displacement = [
        (1.0 - 3.0 * x2 + 2.0 * x3 + phi * (1.0 - x)) / d,
        (x - 2.0 * x2 + x3 + 0.5 * phi * (x - x2)) * length / d,
        (3.0 * x2 - 2.0 * x3 + phi * x) / d,
        (x3 - x2 + 0.5 * phi * (x2 - x)) * length / d,
    ];
    let slope = [
        6.0 * (x2 - x) / (length * d),
        (1.0 - 4.0 * x + 3.0 * x2 + phi * (1.0 - x)) / d,
        6.0 * (x - x2) / (length * d),
        (3.0 * x2 - 2.0 * x + phi * x) / d,
    ];
    (displacement, slope)
}

/// Motion of the elastic axis at `xi`, rows ux uy uz rx ry rz, from its own twelve dofs.
fn elastic_axis(section: &Section, xi: f64) -> [Row; 6] {
    let mut rows = [[0.0; 12]; 6];
    for d in [0, 3] {
        (rows[d][d], rows[d][6 + d]) = (1.0 - xi, xi);
    }
    for (p, plane) in PLANES.iter().enumerate() {
        let (displacement, slope) = shape(xi, section.length, section.phi(p));
        let (v, r, s) = (plane.displacement, plane.rotation, plane.slope);
        for (k, (dof, sign)) in [(v, 1.0), (r, s), (6 + v, 1.0), (6 + r, s)].into_iter().enumerate() {
            rows[v][dof] = sign * displacement[k];
            rows[r][dof] = s * sign * slope[k];
        }
    }
    // It is the neutral axis whose displacement along x is linear.
    for (d, arm) in [(4, section.neutral_axis[1]), (5, -section.neutral_axis[0])] {
        if arm != 0.0 {
            let turn = rows[d];
            rows[0] = plus(rows[0], -arm, &turn);
            rows[0][d] += arm * (1.0 - xi);
            rows[0][6 + d] += arm * xi;
        }
    }
    rows
}

/// Motion at `xi` of the line at `[y, z]` from the elastic axis: `u + θ × (0, y, z)` and θ.
fn beside([ux, uy, uz, rx, ry, rz]: [Row; 6], [y, z]: [f64; 2]) -> [Row; 6] {
    [plus(plus(ux, z, &ry), -y, &rz), plus(uy, -z, &rx), plus(uz, y, &rx), rx, ry, rz]
}

/// Rows α = θ1 + θ2 - 2 (v2 - v1)/L and β = θ2 - θ1 of one plane, from the dofs of the elastic axis.
fn bending_modes(plane: &Plane, length: f64) -> (Row, Row) {
    let mut alpha = difference(plane.displacement).map(|x| -2.0 / length * x);
    (alpha[plane.rotation], alpha[6 + plane.rotation]) = (plane.slope, plane.slope);
    (alpha, difference(plane.rotation))
}

/// Elastic stiffness of the beam between its own ends.
fn rigid_ended_stiffness(section: &Section) -> SymMatrix {
    let l = section.length;
    let on_nodes = |row| on_nodes(row, section);
    let twist = on_nodes(difference(3));
    let mut k = SymMatrix::zeros(12);
    k.add_outer(section.ea / l, &on_nodes(stretch(section)));
    k.add_outer(section.gj / l, &twist);
    for (p, plane) in PLANES.iter().enumerate() {
        let ei = section.ei[p];
        let (alpha, beta) = bending_modes(plane, l);
        let (alpha, beta) = (on_nodes(alpha), on_nodes(beta));
        k.add_outer(ei / l, &beta);
        k.add_outer(3.0 * ei / (l * (1.0 + section.phi(p))), &alpha);
        // K/L (φ2-φ1)(r2-r1): half of K/L times the square of the sum less that of the difference.
        let coupling = 0.5 * section.bend_twist[p] / l;
        k.add_outer(coupling, &plus(twist, 1.0, &beta));
        k.add_outer(-coupling, &plus(twist, -1.0, &beta));
    }
    k
}

/// The stiffness in its natural modes, with what the ends and the axial force make of them; half of the bend-twist coupling to either.
fn strain_parts(section: &Section) -> StrainParts {
    let to_ends = ends(section);
    let l = section.length;
    let on_nodes = |row| from_nodes(row, section, to_ends.as_ref());
    let [mut axial, mut bending, mut torsion] = [(); 3].map(|()| SymMatrix::zeros(12));
    axial.add_outer(section.ea / l, &on_nodes(stretch(section)));
    let twist = on_nodes(difference(3));
    torsion.add_outer(section.gj / l, &twist);
    for (p, plane) in PLANES.iter().enumerate() {
        let ei = section.ei[p];
        let (alpha, beta) = bending_modes(plane, l);
        let (alpha, beta) = (on_nodes(alpha), on_nodes(beta));
        bending.add_outer(ei / l, &beta);
        bending.add_outer(3.0 * ei / (l * (1.0 + section.phi(p))), &alpha);
        let coupling = 0.25 * section.bend_twist[p] / l;
        for part in [&mut bending, &mut torsion] {
            part.add_outer(coupling, &plus(twist, 1.0, &beta));
            part.add_outer(-coupling, &plus(twist, -1.0, &beta));
        }
    }
    add_geometric(&mut bending, section, to_ends.as_ref());
    // What the springs at the ends hold: δ²/c, with δ = u - T u between a node and its end.
    for (i, t_row) in to_ends.iter().flatten().enumerate() {
        let compliance = section.end_compliance[i];
        if compliance > 0.0 {
            let mut opening = t_row.map(|t| -t);
            opening[i] += 1.0;
            let part = match i % 6 {
                0 => &mut axial,
                3 => &mut torsion,
                _ => &mut bending,
            };
            part.add_outer(1.0 / compliance, &opening);
        }
    }
    // A joint about an axis of any direction twists by the share that this has of the axis of the beam.
    for (end, hinge) in section.hinges.iter().enumerate() {
        let (Some(t), Some((compliance, axis))) = (&to_ends, hinge) else { continue };
        let mut opening = [0.0; 12];
        for (k, share) in axis.iter().enumerate() {
            let row = 6 * end + 3 + k;
            opening = plus(opening, -share, &t[row]);
            opening[row] += share;
        }
        let twist = axis[0] * axis[0];
        torsion.add_outer(twist / compliance, &opening);
        bending.add_outer((1.0 - twist) / compliance, &opening);
    }
    StrainParts { axial, bending, torsion }
}

/// The motion of the node line at a distance along x from a node, as of a rigid body.
fn rigid_arm(node: usize, x: f64) -> [Row; 6] {
    let mut rows: [Row; 6] = std::array::from_fn(|d| std::array::from_fn(|i| f64::from(u8::from(i == 6 * node + d))));
    (rows[1], rows[2]) = (plus(rows[1], x, &rows[5]), plus(rows[2], -x, &rows[4]));
    rows
}

/// Adds the geometric stiffness P ∫ (v'² + w'²) dx of the displacement between the ends.
fn add_geometric(k: &mut SymMatrix, section: &Section, to_ends: Option<&[Row; 12]>) {
    let (p_force, l) = (section.axial_force, section.length);
    if p_force == 0.0 {
        return;
    }
    for (p, plane) in PLANES.iter().enumerate() {
        let d = 1.0 + section.phi(p);
        let (alpha, beta) = bending_modes(plane, l);
        for (factor, row) in [(1.0 / l, difference(plane.displacement)), (l / 12.0, beta), (l / (20.0 * d * d), alpha)]
        {
            k.add_outer(p_force * factor, &from_nodes(row, section, to_ends));
        }
        // A rigid end has the slope of its node.
        for (node, length) in section.rigid.into_iter().enumerate().filter(|(_, length)| *length > 0.0) {
            let slope = rigid_arm(node, 0.0)[plane.rotation];
            k.add_outer(p_force * length, &through_joints(slope, to_ends));
        }
    }
}

/// Condenses the springs at the ends, one after the other; returns the transformation from the nodes to the ends of
/// the beam (`None` where all compliances are zero: then the ends are the nodes, and `k` is untouched).
///
/// For the dof i with compliance c, f = 1 / (1/c + K_ii), which is finite for a hinge:
///
/// ```text
/// K'_ab = K_ab - f K_ai K_ib      K'_ib = K_ib (1 - f K_ii)      T = I - f e_i (row i of K)
/// ```
///
/// About an axis e of any direction, last: K' = K - f K e eᵀ K, T = I - f e eᵀ K, f = 1/(1/c + eᵀ K e).
fn condense_ends(k: &mut SymMatrix, section: &Section) -> Option<[Row; 12]> {
    let mut to_ends: Option<[Row; 12]> = None;
    let identity: [Row; 12] = std::array::from_fn(|d| std::array::from_fn(|i| f64::from(u8::from(i == d))));
    // What a hinge has left of a diagonal entry below this part of it is rounding, to either side of zero: that
    // direction is free already.
    let free: Row = std::array::from_fn(|i| 1e-13 * k.get(i, i));
    for (i, &compliance) in section.end_compliance.iter().enumerate() {
        let own = k.get(i, i);
        if compliance == 0.0 || own <= free[i] {
            continue;
        }
        // 1 - f K_ii without cancellation.
        let (f, remains) = (1.0 / (1.0 / compliance + own), 1.0 / (1.0 + compliance * own));
        let row: Row = std::array::from_fn(|j| k.get(i, j));
        let mut condensed = SymMatrix::zeros(12);
        for a in 0..12 {
            for b in 0..=a {
                let rest = if a == i || b == i { remains * k.get(a, b) } else { k.get(a, b) - f * row[a] * row[b] };
                condensed.add(a, b, rest);
            }
        }
        *k = condensed;
        let t = to_ends.get_or_insert(identity);
        for t_row in t.iter_mut() {
            let share = t_row[i];
            *t_row = plus(*t_row, -f * share, &row);
            t_row[i] = remains * share;
        }
    }
    for (end, &(compliance, axis)) in section.hinges.iter().enumerate().filter_map(|(end, h)| Some((end, h.as_ref()?)))
    {
        let about = |row: &Row| (0..3).map(|d| axis[d] * row[6 * end + 3 + d]).sum::<f64>();
        let row: Row = std::array::from_fn(|j| about(&std::array::from_fn(|i| k.get(i, j))));
        let (own, least) = (about(&row), (0..3).map(|d| axis[d] * axis[d] * free[6 * end + 3 + d]).sum::<f64>());
        if own <= least {
            continue;
        }
        let f = 1.0 / (1.0 / compliance + own);
        k.add_outer(-f, &row);
        for t_row in to_ends.get_or_insert(identity).iter_mut() {
            let share = about(t_row);
            *t_row = plus(*t_row, -f * share, &row);
        }
    }
    to_ends
}

/// From dofs of the elastic axis at the ends of the beam to dofs of the nodes: rigid arms, then flexible ends.
fn from_nodes(row: Row, section: &Section, to_ends: Option<&[Row; 12]>) -> Row {
    through_joints(on_nodes(row, section), to_ends)
}

/// From dofs of the nodes on the beam's side of the joints to those of the nodes.
fn through_joints(row: Row, to_ends: Option<&[Row; 12]>) -> Row {
    let Some(t) = to_ends else { return row };
    let mut out = [0.0; 12];
    for (x, t_row) in row.iter().zip(t) {
        out = plus(out, *x, t_row);
    }
    out
}

/// The transformation to the ends, computed only where a joint gives.
fn ends(section: &Section) -> Option<[Row; 12]> {
    let flexible = section.end_compliance.iter().any(|c| *c != 0.0) || section.hinges.iter().any(Option::is_some);
    flexible.then(|| condense_ends(&mut rigid_ended_stiffness(section), section)).flatten()
}

/// Kinetic energy of the section over the displacement that the stiffness implies; of the share that is lumped, half at each node.
fn section_mass(section: &Section) -> SymMatrix {
    let to_ends = ends(section);
    let [ey, ez] = section.shear_centre;
    let [my, mz] = section.mass_offset;
    let mut m = SymMatrix::zeros(12);
    let lumped: [f64; 6] = std::array::from_fn(|d| section.lumping[d] * section.inertia[d]);
    let consistent: [f64; 6] = std::array::from_fn(|d| (1.0 - section.lumping[d]) * section.inertia[d]);
    for node in [0, 1] {
        for (row, inertia) in beside(rigid_arm(node, 0.0), section.mass_offset).into_iter().zip(lumped) {
            if inertia != 0.0 {
                m.add_outer(0.5 * section.span() * inertia, &row);
            }
        }
    }
    for (xi, weight) in GAUSS {
        let mass_axis = beside(elastic_axis(section, xi), [my - ey, mz - ez]);
        for (row, inertia) in mass_axis.into_iter().zip(consistent) {
            if inertia != 0.0 {
                m.add_outer(weight * section.length * inertia, &from_nodes(row, section, to_ends.as_ref()));
            }
        }
    }
    // Rigid ends move with their nodes.
    for (node, length) in section.rigid.into_iter().enumerate().filter(|(_, length)| *length > 0.0) {
        let toward = if node == 0 { length } else { -length };
        for (xi, weight) in GAUSS {
            let mass_axis = beside(rigid_arm(node, xi * toward), section.mass_offset);
            for (row, inertia) in mass_axis.into_iter().zip(consistent).filter(|(_, inertia)| *inertia != 0.0) {
                m.add_outer(weight * length * inertia, &through_joints(row, to_ends.as_ref()));
            }
        }
    }
    m
}

impl Element for Beam {
    fn name(&self) -> &'static str {
        "beam"
    }

    fn summary(&self) -> &'static str {
        "A beam in space: bending in two planes, torsion, stretching; with offsets, shear, preload, flexible and rigid ends."
    }

    fn theory(&self) -> &'static str {
        include_str!("beam.md")
    }

    fn nodes(&self) -> &'static [&'static [Dof]] {
        &[&Dof::ALL, &Dof::ALL]
    }

    fn properties(&self) -> &'static [Property] {
        PROPERTIES
    }

    fn axes(&self) -> Axes {
        Axes::AlongNodes
    }

    fn stiffness(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        let section = Section::read(input)?;
        let mut k = rigid_ended_stiffness(&section);
        let to_ends = condense_ends(&mut k, &section);
        add_geometric(&mut k, &section, to_ends.as_ref());
        Ok(k)
    }

    fn mass(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        let mut section = Section::read(input)?;
        section.inertia[1] += section.air[0];
        section.inertia[2] += section.air[1];
        Ok(section_mass(&section))
    }

    fn weighed_mass(&self, input: &ElementInput<'_>) -> Result<Option<SymMatrix>, ElementError> {
        let in_fluid = value!(input, air_mass_y).is_some() || value!(input, air_mass_z).is_some();
        if in_fluid { Section::read(input).map(|section| Some(section_mass(&section))) } else { Ok(None) }
    }

    fn strain_parts(&self, input: &ElementInput<'_>) -> Result<Option<StrainParts>, ElementError> {
        Section::read(input).map(|section| Some(strain_parts(&section)))
    }

    fn mass_axis(&self, input: &ElementInput<'_>) -> [f64; 2] {
        [value!(input, mass_offset_y), value!(input, mass_offset_z)].map(|v| v.unwrap_or(0.0))
    }

    fn preloads(&self) -> &'static [&'static str] {
        &["axial_force"]
    }

    fn preload_of(&self, input: &ElementInput<'_>, u: &[f64]) -> Result<Vec<(&'static str, f64)>, ElementError> {
        let k = self.stiffness(input)?;
        let at = |i: usize| -> f64 { u.iter().enumerate().map(|(j, u)| k.get(i, j) * u).sum() };
        Ok(vec![("axial_force", 0.5 * (at(6) - at(0)))])
    }

    /// The shape functions themselves, on the node line; with flexible ends `xi` = 0 is the end of the beam, which the
    /// joint separates from the node.
    fn interpolate(&self, input: &ElementInput<'_>, xi: f64) -> Result<[[f64; 12]; 6], ElementError> {
        let section = Section::read(input)?;
        let to_ends = ends(&section);
        let at = xi * section.span();
        let (from, to) = (section.rigid[0], section.rigid[0] + section.length);
        if (at < from && from > 0.0) || (at > to && section.rigid[1] > 0.0) {
            let rows = if at < from { rigid_arm(0, at) } else { rigid_arm(1, at - section.span()) };
            return Ok(rows.map(|row| through_joints(row, to_ends.as_ref())));
        }
        let xi = if section.rigid == [0.0; 2] { xi } else { (at - from) / section.length };
        let node_line = beside(elastic_axis(&section, xi), section.shear_centre.map(|x| -x));
        Ok(node_line.map(|row| from_nodes(row, &section, to_ends.as_ref())))
    }

    fn lacks(&self, input: &ElementInput<'_>) -> Vec<Lack> {
        section::lacks(input)
    }

    fn samples(&self) -> Vec<Sample> {
        section::samples()
    }
}
