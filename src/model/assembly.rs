//! Assembly: from placed elements to K(θ), M(θ), C(θ) on the independent dofs.
//!
//! Elements whose matrices are affine in θ (found by evaluation, so that a user's own element needs to declare nothing)
//! are assembled once, as K0 + Σ θ_j K_j in sparse lists; the others are evaluated at every θ.

use super::constraint::Elimination;
use super::dof_map::DofMap;
use super::mass_properties::add_rigid_mass;
use super::parameter::ParameterSet;
use super::place::PlacedElement;
use super::system::{SparseSystem, System};
use super::value::Value;
use super::{ElementMatrices, ModelError};
use crate::element::{Dof, ElementInput};
use crate::linalg::sparse::SparseSym;
use crate::linalg::{DMatrix, SymMatrix};

/// One entry of a basis matrix: lower triangle, row ≥ column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// Row.
    pub row: usize,
    /// Column.
    pub column: usize,
    /// Its value per unit of the parameter (or, in the constant part, its value).
    pub value: f64,
}

/// Sparse K, M, C of one basis matrix.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Basis {
    /// Entries of K.
    pub stiffness: Vec<Entry>,
    /// Entries of M.
    pub mass: Vec<Entry>,
    /// Entries of C.
    pub damping: Vec<Entry>,
}

/// The affine part of a model: K(θ) = K0 + Σ θ_j K_j, and so for M and C.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AffinePart {
    /// K0, M0, C0.
    pub constant: Basis,
    /// K_j, M_j, C_j for each parameter of θ.
    pub parameters: Vec<Basis>,
}

/// How an element's dofs follow from the rows: u_e = B q\[rows\].
#[derive(Debug, Clone)]
pub(super) struct Connection {
    pub(super) rows: Vec<usize>,
    pub(super) b: DMatrix<f64>,
}

impl Connection {
    pub(super) fn new(element: &PlacedElement, dofs: &DofMap) -> Self {
        let n = 6 * element.nodes.len();
        let mut rows: Vec<usize> = element
            .nodes
            .iter()
            .flat_map(|&node| Dof::ALL.into_iter().flat_map(move |d| dofs.express(node, d).iter().map(|t| t.0)))
            .collect();
        rows.sort_unstable();
        rows.dedup();
        let mut b = DMatrix::zeros(n, rows.len());
        for (k, &node) in element.nodes.iter().enumerate() {
            for i in 0..6 {
                for global in 0..3 {
                    let direction = element.axes[i % 3][global];
                    let dof = Dof::ALL[global + 3 * (i / 3)];
                    for &(row, factor) in dofs.express(node, dof) {
                        let column = rows.partition_point(|r| *r < row);
                        b[(6 * k + i, column)] += direction * factor;
                    }
                }
            }
        }
        Self { rows, b }
    }

    /// Bᵀ a B on the rows of this element.
    fn reduce(&self, a: &SymMatrix) -> DMatrix<f64> {
        self.b.transpose() * a.to_dense() * &self.b
    }
}

/// The matrices of one element at θ, in its axes.
pub(super) fn element_matrices(element: &PlacedElement, theta: &[f64]) -> Result<ElementMatrices, ModelError> {
    let values = element.values_at(theta);
    let input = ElementInput { points: &element.points, values: &values };
    let wrap = |source| ModelError::Element { element: element.name.clone(), path: element.path.clone(), source };
    let scaled = |mut a: SymMatrix, factor: &Option<Value>| {
        if let Some(f) = factor {
            a.scale(f.at(theta));
        }
        a
    };
    let stiffness = scaled(element.kind.stiffness(&input).map_err(wrap)?, &element.stiffness_factor);
    let mass = scaled(element.kind.mass(&input).map_err(wrap)?, &element.mass_factor);
    let weighed_mass = element.kind.weighed_mass(&input).map_err(wrap)?.map(|m| scaled(m, &element.mass_factor));
    let mut damping = element.kind.damping(&input).map_err(wrap)?;
    for (factor, matrix) in [(&element.stiffness_damping, &stiffness), (&element.mass_damping, &mass)] {
        if let Some(factor) = factor.as_ref().map(|f| f.at(theta)) {
            damping = damping.combine(matrix, |c, a| c + factor * a);
        }
    }
    Ok(ElementMatrices { stiffness, mass, weighed_mass, damping })
}

/// The mass of one element at θ as scales see it, in its axes: [`ElementMatrices::weighed`] without the other matrices.
pub(super) fn weighed_mass(element: &PlacedElement, theta: &[f64]) -> Result<SymMatrix, ModelError> {
    let values = element.values_at(theta);
    let input = ElementInput { points: &element.points, values: &values };
    let mass = element.kind.weighed_mass(&input).and_then(|m| m.map_or_else(|| element.kind.mass(&input), Ok));
    let wrap = |source| ModelError::Element { element: element.name.clone(), path: element.path.clone(), source };
    let mut mass = mass.map_err(wrap)?;
    if let Some(f) = &element.mass_factor {
        mass.scale(f.at(theta));
    }
    Ok(mass)
}

/// An element's matrices as functions of θ.
pub(super) enum Dependence {
    /// Constant part, and one part per parameter it depends on.
    Affine(ElementMatrices, Vec<(usize, ElementMatrices)>),
    /// Anything else.
    General,
}

/// Finds out by evaluation whether an element's matrices are affine in θ.
///
/// They are measured at a base point and with each parameter moved alone, and the affine function through these values
/// is checked with all parameters moved together, to 1e-11 of the largest entry.
pub(super) fn dependence(element: &PlacedElement, parameters: &ParameterSet) -> Result<Dependence, ModelError> {
    let base = interior_point(parameters);
    let mut used: Vec<usize> = element.expressions().flat_map(Value::parameters).collect();
    used.sort_unstable();
    used.dedup();
    let at_base = element_matrices(element, &base)?;
    if used.is_empty() {
        return Ok(Dependence::Affine(at_base, Vec::new()));
    }
    let steps: Vec<f64> = used.iter().map(|&p| step(parameters, p, base[p])).collect();
    let moved = |fractions: &dyn Fn(usize) -> f64| {
        let mut theta = base.clone();
        for (k, &p) in used.iter().enumerate() {
            theta[p] += fractions(k) * steps[k];
        }
        element_matrices(element, &theta)
    };
    let mut slopes = Vec::new();
    for k in 0..used.len() {
        let Ok(m) = moved(&|i| f64::from(u8::from(i == k))) else { return Ok(Dependence::General) };
        slopes.push(m.combine(&at_base, |moved, base| clean(moved - base, moved.abs() + base.abs()) / steps[k]));
    }
    for fractions in [[0.37, 0.71, 0.53], [0.83, 0.29, 0.61]] {
        let Ok(actual) = moved(&|k| fractions[k % 3]) else { return Ok(Dependence::General) };
        let mut predicted = at_base.clone();
        for (k, slope) in slopes.iter().enumerate() {
            let factor = fractions[k % 3] * steps[k];
            predicted = predicted.combine(slope, |p, s| p + factor * s);
        }
        if !actual.is_close(&predicted, 1e-11) {
            return Ok(Dependence::General);
        }
    }
    let mut constant = at_base.clone();
    for (k, slope) in slopes.iter().enumerate() {
        constant = constant.combine(slope, |c, s| clean(c - base[used[k]] * s, c.abs()));
    }
    Ok(Dependence::Affine(constant, used.into_iter().zip(slopes).collect()))
}

/// A difference that is rounding noise of its terms is zero.
fn clean(difference: f64, size: f64) -> f64 {
    if difference.abs() <= 1e-13 * size { 0.0 } else { difference }
}

/// The estimates, moved into their bounds.
pub(super) fn interior_point(parameters: &ParameterSet) -> Vec<f64> {
    parameters.iter().map(|p| p.bounds.map_or(p.value, |[l, u]| p.value.max(l).min(u))).collect()
}

/// How far a parameter is moved from a value: to its farther bound, else by half its value, else by one.
fn step(parameters: &ParameterSet, index: usize, value: f64) -> f64 {
    match parameters.get(index).bounds {
        Some([lower, upper]) if upper - value >= value - lower => upper - value,
        Some([lower, _]) => lower - value,
        None if value != 0.0 => 0.5 * value,
        None => 1.0,
    }
}

/// Which dofs of the nodes any element acts on, 6 per node.
pub(super) fn touched(
    elements: &[PlacedElement],
    dependences: &[Dependence],
    parameters: &ParameterSet,
    n_nodes: usize,
) -> Vec<bool> {
    let mut touched = vec![false; 6 * n_nodes];
    let base = interior_point(parameters);
    for (element, dependence) in elements.iter().zip(dependences) {
        let parts: Vec<ElementMatrices> = match dependence {
            Dependence::Affine(constant, slopes) => {
                std::iter::once(constant).chain(slopes.iter().map(|s| &s.1)).cloned().collect()
            }
            Dependence::General => {
                let mut all: Vec<f64> = base.clone();
                for (i, value) in all.iter_mut().enumerate() {
                    *value += 0.618 * step(parameters, i, *value);
                }
                [&base, &all].into_iter().filter_map(|theta| element_matrices(element, theta).ok()).collect()
            }
        };
        for (k, &node) in element.nodes.iter().enumerate() {
            for i in 0..6 {
                let acts = parts.iter().any(|m| {
                    [&m.stiffness, &m.mass, &m.damping]
                        .into_iter()
                        .any(|a| (0..a.n()).any(|j| a.get(6 * k + i, j) != 0.0))
                });
                if acts {
                    for global in 0..3 {
                        if element.axes[i % 3][global].abs() > 1e-12 {
                            touched[6 * node + 3 * (i / 3) + global] = true;
                        }
                    }
                }
            }
        }
    }
    touched
}

/// Numbers the independent dofs that any element acts on, in the order of nodes and dofs.
pub(super) fn number(names: &[String], positions: &[[f64; 3]], touched: &[bool], elimination: &Elimination) -> DofMap {
    let n = touched.len();
    let mut needed = vec![false; n];
    let full: Vec<_> = (0..n).map(|dof| elimination.express(dof)).collect();
    for dof in (0..n).filter(|d| touched[*d]) {
        for &(d, _) in &full[dof] {
            needed[d] = true;
        }
    }
    let mut row_of = vec![usize::MAX; n];
    let mut rows = Vec::new();
    for dof in (0..n).filter(|d| needed[*d]) {
        row_of[dof] = rows.len();
        rows.push((dof / 6, Dof::ALL[dof % 6]));
    }
    let full = full
        .into_iter()
        .map(|c| c.into_iter().filter(|t| needed[t.0]).map(|(d, f)| (row_of[d], f)).collect())
        .collect();
    DofMap::new(names.to_vec(), positions.to_vec(), rows, full)
}

/// The affine part of a model and the 6 x 6 masses of rigid motion, constant and per parameter.
pub(super) fn affine_part(
    elements: &[PlacedElement],
    dependences: &[Dependence],
    connections: &[Connection],
    positions: &[[f64; 3]],
    n_parameters: usize,
) -> (AffinePart, Vec<SymMatrix>) {
    let mut part = AffinePart { constant: Basis::default(), parameters: vec![Basis::default(); n_parameters] };
    let mut rigid = vec![SymMatrix::zeros(6); n_parameters + 1];
    for ((element, dependence), connection) in elements.iter().zip(dependences).zip(connections) {
        let Dependence::Affine(constant, slopes) = dependence else { continue };
        let at: Vec<[f64; 3]> = element.nodes.iter().map(|&n| positions[n]).collect();
        for (target, matrices) in std::iter::once((None, constant)).chain(slopes.iter().map(|s| (Some(s.0), &s.1))) {
            let basis = target.map_or(&mut part.constant, |p| &mut part.parameters[p]);
            for (list, matrix) in [
                (&mut basis.stiffness, &matrices.stiffness),
                (&mut basis.mass, &matrices.mass),
                (&mut basis.damping, &matrices.damping),
            ] {
                if matrix.is_zero() {
                    continue;
                }
                let reduced = connection.reduce(matrix);
                push(list, connection, &reduced);
            }
            add_rigid_mass(&mut rigid[target.map_or(0, |p| p + 1)], 1.0, matrices.weighed(), &element.axes, &at);
        }
    }
    for basis in std::iter::once(&mut part.constant).chain(&mut part.parameters) {
        for list in [&mut basis.stiffness, &mut basis.mass, &mut basis.damping] {
            merge(list);
        }
    }
    (part, rigid)
}

fn push(list: &mut Vec<Entry>, connection: &Connection, reduced: &DMatrix<f64>) {
    for (i, &row) in connection.rows.iter().enumerate() {
        for (j, &column) in connection.rows.iter().enumerate().take(i + 1) {
            let value = 0.5 * (reduced[(i, j)] + reduced[(j, i)]);
            if value != 0.0 {
                list.push(Entry { row, column, value });
            }
        }
    }
}

/// Sorts by place and sums entries of one place, in the order they came.
fn merge(list: &mut Vec<Entry>) {
    list.sort_by_key(|e| (e.row, e.column));
    list.dedup_by(|later, kept| {
        let same = later.row == kept.row && later.column == kept.column;
        if same {
            kept.value += later.value;
        }
        same
    });
}

/// Adds `factor` times a basis to the lower triangles of a system.
pub(super) fn add_basis(system: &mut System, basis: &Basis, factor: f64) {
    for (matrix, list) in [(&mut system.stiffness, &basis.stiffness), (&mut system.mass, &basis.mass)] {
        for e in list {
            matrix[(e.row, e.column)] += factor * e.value;
        }
    }
    if let Some(c) = &mut system.damping {
        for e in &basis.damping {
            c[(e.row, e.column)] += factor * e.value;
        }
    }
}

/// Adds one element's matrices to the lower triangles of a system.
pub(super) fn add_element(system: &mut System, connection: &Connection, matrices: &ElementMatrices) {
    let add = |target: &mut DMatrix<f64>, matrix: &SymMatrix| {
        if matrix.is_zero() {
            return;
        }
        let reduced = connection.reduce(matrix);
        for (i, &row) in connection.rows.iter().enumerate() {
            for (j, &column) in connection.rows.iter().enumerate().take(i + 1) {
                target[(row, column)] += 0.5 * (reduced[(i, j)] + reduced[(j, i)]);
            }
        }
    };
    add(&mut system.stiffness, &matrices.stiffness);
    add(&mut system.mass, &matrices.mass);
    if let Some(c) = &mut system.damping {
        add(c, &matrices.damping);
    }
}

/// Copies the lower triangles into the upper ones.
pub(super) fn symmetrise(system: &mut System) {
    for matrix in [Some(&mut system.stiffness), Some(&mut system.mass), system.damping.as_mut()].into_iter().flatten() {
        matrix.fill_upper_triangle_with_lower_triangle();
    }
}

/// The sparse matrices of factors times bases and of elements. Entries that happen to be zero are kept, so the pattern
/// does not depend on θ.
pub(super) fn sparse_system(
    n: usize,
    damped: bool,
    bases: &[(&Basis, f64)],
    elements: &[(&Connection, ElementMatrices)],
) -> SparseSystem {
    let reduced: Vec<_> =
        elements.iter().map(|(c, m)| (c, [&m.stiffness, &m.mass, &m.damping].map(|a| c.reduce(a)))).collect();
    let matrix = |which: usize, list: &dyn Fn(&Basis) -> usize| {
        let mut triplets: Vec<(usize, usize, f64)> = Vec::with_capacity(bases.iter().map(|b| list(b.0)).sum());
        for (basis, factor) in bases {
            let entries = [&basis.stiffness, &basis.mass, &basis.damping][which];
            triplets.extend(entries.iter().map(|e| (e.row, e.column, factor * e.value)));
        }
        for (c, matrices) in &reduced {
            let a = &matrices[which];
            for (i, &row) in c.rows.iter().enumerate() {
                for (j, &column) in c.rows.iter().enumerate().take(i + 1) {
                    triplets.push((row, column, 0.5 * (a[(i, j)] + a[(j, i)])));
                }
            }
        }
        SparseSym::from_triplets(n, triplets.iter().copied())
    };
    SparseSystem {
        stiffness: matrix(0, &|b| b.stiffness.len()),
        mass: matrix(1, &|b| b.mass.len()),
        damping: damped.then(|| matrix(2, &|b| b.damping.len())),
    }
}
