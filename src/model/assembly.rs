//! Assembly: from placed elements to K(θ), M(θ), C(θ) on the independent dofs.
//!
//! Elements whose matrices are polynomials of θ (found by evaluation, see [`super::dependence`]) are assembled once, as
//! K0 + Σ θ_j K_j + Σ c_k(θ) K_k in sparse lists with products c_k of powers; the others are evaluated at every θ.

use super::ElementMatrices;
use super::constraint::Elimination;
use super::dependence::{Dependence, Monomial, element_matrices, interior_point, step};
use super::dof_map::DofMap;
use super::entry::{Entry, merge};
use super::geometry::Geometry;
use super::mass_properties::add_rigid_mass;
use super::parameter::ParameterSet;
use super::placed_element::PlacedElement;
use super::polynomial::Polynomial;
use super::system::{SparseSystem, System};
use super::value::Value;
use crate::element::Dof;
use crate::linalg::sparse::SparseSym;
use crate::linalg::{DMatrix, SymMatrix};
use std::collections::BTreeMap;

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

/// The affine part of a model, and that which is so in products of parameters, and so for M and C:
///
/// ```text
/// K(θ) = K0 + Σ_j θ_j K_j + Σ_k c_k(θ) K_k,    c_k(θ) = Π (θ_j - b_j)^p
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AffinePart {
    /// K0, M0, C0.
    pub constant: Basis,
    /// K_j, M_j, C_j for each parameter of θ.
    pub parameters: Vec<Basis>,
    /// Products, each with its K_k, M_k, C_k, in the order of their powers.
    pub products: Vec<(Monomial, Basis)>,
    /// b, for each parameter of θ.
    pub origin: Vec<f64>,
}

impl AffinePart {
    /// Every basis.
    pub fn bases(&self) -> impl Iterator<Item = &Basis> {
        std::iter::once(&self.constant).chain(&self.parameters).chain(self.products.iter().map(|p| &p.1))
    }

    /// Every basis with its factor at θ.
    pub fn at(&self, theta: &[f64]) -> impl Iterator<Item = (&Basis, f64)> {
        let products = self.products.iter().map(|(monomial, basis)| (basis, monomial.at(theta, &self.origin)));
        std::iter::once((&self.constant, 1.0)).chain(self.parameters.iter().zip(theta.iter().copied())).chain(products)
    }

    /// The bases that depend on θ_j, each with the derivative of its factor.
    pub fn derivative(&self, theta: &[f64], j: usize) -> impl Iterator<Item = (&Basis, f64)> {
        let products =
            self.products.iter().map(move |(monomial, basis)| (basis, monomial.derivative(theta, &self.origin, j)));
        std::iter::once((&self.parameters[j], 1.0)).chain(products.filter(|p| p.1 != 0.0))
    }
}

/// Rᵀ M R of the six rigid motions about the origin (6 x 6), in the terms of [`AffinePart`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AffineMass {
    /// Constant part first, then one per parameter.
    pub linear: Vec<SymMatrix>,
    /// One per product.
    pub products: Vec<SymMatrix>,
}

impl AffineMass {
    /// Their sum at θ.
    ///
    /// * `of` - what they are the terms of
    pub(super) fn at(&self, of: &AffinePart, theta: &[f64]) -> SymMatrix {
        let mut rigid = SymMatrix::zeros(6);
        let masses = self.linear.iter().chain(&self.products);
        masses.zip(of.at(theta)).for_each(|(mass, (_, factor))| rigid.add_scaled(factor, mass));
        rigid
    }
}

/// How an element's dofs follow from the rows: u_e = B q\[rows\].
#[derive(Debug, Clone)]
pub(super) struct Connection {
    pub(super) rows: Vec<usize>,
    pub(super) b: DMatrix<f64>,
}

impl Connection {
    pub(super) fn new(element: &PlacedElement, dofs: &DofMap) -> Self {
        let mut rows: Vec<usize> = element
            .nodes
            .iter()
            .flat_map(|&node| Dof::ALL.into_iter().flat_map(move |d| dofs.express(node, d).iter().map(|t| t.0)))
            .collect();
        rows.sort_unstable();
        rows.dedup();
        let b = motion_in_axes(element, rows.len(), |node, dof| dofs.express(node, dof), |row| place(&rows, row));
        Self { rows, b }
    }

    /// Some rows themselves.
    pub(super) fn unit(rows: Vec<usize>) -> Self {
        let b = DMatrix::identity(rows.len(), rows.len());
        Self { rows, b }
    }

    /// The lower triangle of a symmetric matrix on the rows, the mean of what rounding has made two.
    fn entries<'a>(&'a self, reduced: &'a DMatrix<f64>) -> impl Iterator<Item = Entry> + 'a {
        let lower = self
            .rows
            .iter()
            .enumerate()
            .flat_map(|(i, &row)| self.rows[..=i].iter().enumerate().map(move |(j, &column)| (i, row, j, column)));
        lower.map(|(i, row, j, column)| {
            let value = 0.5 * (reduced[(i, j)] + reduced[(j, i)]);
            Entry { row, column, value }
        })
    }

    /// Bᵀ a B on the rows of this element.
    fn reduce(&self, a: &SymMatrix) -> DMatrix<f64> {
        self.b.transpose() * a.to_dense() * &self.b
    }
}

/// How the dofs of an element follow from some coordinates, (6 nodes x coordinates), in its axes.
///
/// * `terms` - a dof of a node as a sum of coordinates: (coordinate, factor)
/// * `column` - where a coordinate stands
pub(super) fn motion_in_axes<'a>(
    element: &PlacedElement,
    n_columns: usize,
    terms: impl Fn(usize, Dof) -> &'a [(usize, f64)],
    column: impl Fn(usize) -> usize,
) -> DMatrix<f64> {
    let mut b = DMatrix::zeros(6 * element.nodes.len(), n_columns);
    for (k, &node) in element.nodes.iter().enumerate() {
        let arm = element.arm(k);
        for i in 0..6 {
            for global in 0..3 {
                let direction = element.axes[i % 3][global];
                for &(coordinate, factor) in terms(node, Dof::ALL[global + 3 * (i / 3)]) {
                    b[(6 * k + i, column(coordinate))] += direction * factor;
                }
                // The end of an arm r moves by u + θ × r.
                for (turn, lever) in turns(global, arm).into_iter().filter(|t| i < 3 && t.1 != 0.0) {
                    for &(coordinate, factor) in terms(node, turn) {
                        b[(6 * k + i, column(coordinate))] += direction * lever * factor;
                    }
                }
            }
        }
    }
    b
}

/// The rotations that move the end of an arm along a global axis, with their levers: (θ × r) of that axis.
fn turns(axis: usize, arm: [f64; 3]) -> [(Dof, f64); 2] {
    let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
    [(Dof::ALL[3 + next], arm[last]), (Dof::ALL[3 + last], -arm[next])]
}

/// Where a row stands among sorted ones.
pub(super) fn place(rows: &[usize], row: usize) -> usize {
    rows.partition_point(|r| *r < row)
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
        if let Some(matrices) = &element.matrices {
            matrices.touch(&mut touched);
            continue;
        }
        let parts: Vec<ElementMatrices> = match dependence {
            Dependence::Affine(..) | Dependence::Polynomial(..) => dependence.parts().into_iter().cloned().collect(),
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
                            let levers = turns(global, element.arm(k)).into_iter().filter(|t| i < 3 && t.1 != 0.0);
                            levers.for_each(|(turn, _)| touched[6 * node + turn as usize] = true);
                        }
                    }
                }
            }
        }
    }
    touched
}

/// Numbers the independent dofs that any element acts on, in the order of nodes and dofs.
pub(super) fn number(geometry: &Geometry, touched: &[bool], elimination: &Elimination) -> DofMap {
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
    let coordinates = (0..geometry.names.len()).filter(|&n| geometry.is_coordinate(n)).collect();
    DofMap::new(geometry.names.clone(), geometry.positions.clone(), rows, full)
        .with_coordinates(coordinates)
        .with_other_names(geometry.other_names().clone())
}

/// The affine part of a model and its masses of rigid motion.
///
/// * `origin` - the base of [`super::dependence::dependence`], for each parameter
pub(super) fn affine_part(
    elements: &[PlacedElement],
    dependences: &[Dependence],
    connections: &[Connection],
    dofs: &DofMap,
    positions: &[[f64; 3]],
    origin: Vec<f64>,
) -> (AffinePart, AffineMass) {
    let mut linear: Vec<Part> = vec![(Basis::default(), SymMatrix::zeros(6)); origin.len() + 1];
    let mut products: BTreeMap<Monomial, Part> = BTreeMap::new();
    for ((element, dependence), connection) in elements.iter().zip(dependences).zip(connections) {
        let at = element.ends(positions);
        // The mass of a coordinate is none of the structure.
        let is_body = !element.nodes.iter().any(|n| dofs.is_coordinate(*n));
        let add = |(basis, rigid): &mut (Basis, SymMatrix), matrices: &ElementMatrices| {
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
            if is_body {
                add_rigid_mass(rigid, 1.0, matrices.weighed(), &element.axes, &at);
            }
        };
        if element.matrices.is_some() {
            continue;
        }
        match dependence {
            Dependence::Affine(constant, slopes) => {
                add(&mut linear[0], constant);
                for (p, slope) in slopes {
                    add(&mut linear[p + 1], slope);
                }
            }
            Dependence::Polynomial(constant, terms) => {
                add(&mut linear[0], constant);
                for (monomial, matrices) in terms {
                    let empty = || (Basis::default(), SymMatrix::zeros(6));
                    add(products.entry(monomial.clone()).or_insert_with(empty), matrices);
                }
            }
            Dependence::General => {}
        }
    }
    for element in elements.iter().filter(|e| e.matrices.is_some()) {
        add_matrices(element, dofs, positions, &origin, &mut linear, &mut products);
    }
    let merged = |mut basis: Basis| {
        for list in [&mut basis.stiffness, &mut basis.mass, &mut basis.damping] {
            merge(list);
        }
        basis
    };
    let mut part = AffinePart { origin, ..AffinePart::default() };
    let mut mass = AffineMass::default();
    for (place, (basis, rigid)) in linear.into_iter().enumerate() {
        let basis = merged(basis);
        if place == 0 {
            part.constant = basis;
        } else {
            part.parameters.push(basis);
        }
        mass.linear.push(rigid);
    }
    for (monomial, (basis, rigid)) in products {
        part.products.push((monomial, merged(basis)));
        mass.products.push(rigid);
    }
    (part, mass)
}

/// A basis and its 6 x 6 mass matrix of rigid motions.
type Part = (Basis, SymMatrix);

/// Adds the matrices of a superelement, or of a term of one, to the parts of their powers, as [`matrix_uses`] says.
fn add_matrices(
    element: &PlacedElement,
    dofs: &DofMap,
    positions: &[[f64; 3]],
    origin: &[f64],
    linear: &mut [Part],
    products: &mut BTreeMap<Monomial, Part>,
) {
    let Some(matrices) = &element.matrices else { return };
    let follows = matrices.follows(dofs);
    let uses = matrix_uses(element, origin);
    for (of, matrix) in [(Kind::Stiffness, &matrices.k), (Kind::Mass, &matrices.m), (Kind::Damping, &matrices.c)] {
        let Some(matrix) = matrix else { continue };
        let mut entries = follows.reduce(matrix);
        merge(&mut entries);
        let rigid = (of == Kind::Mass).then(|| matrices.rigid(matrix, positions));
        for (_, kind, polynomial) in uses.iter().filter(|u| u.0 == of) {
            let kind = *kind;
            let add = |part: &mut Part, factor: f64| {
                if factor == 0.0 {
                    return;
                }
                let list = match kind {
                    Kind::Stiffness => &mut part.0.stiffness,
                    Kind::Mass => &mut part.0.mass,
                    Kind::Damping => &mut part.0.damping,
                };
                list.extend(entries.iter().map(|e| Entry { value: factor * e.value, ..*e }));
                if let Some(rigid) = rigid.as_ref().filter(|_| kind == Kind::Mass) {
                    part.1.add_scaled(factor, rigid);
                }
            };
            if let Some((constant, slopes)) = polynomial.slopes(origin) {
                add(&mut linear[0], constant);
                for (j, slope) in slopes {
                    add(&mut linear[j + 1], slope);
                }
                continue;
            }
            for (monomial, factor) in polynomial.terms() {
                if monomial.powers.is_empty() {
                    add(&mut linear[0], factor);
                } else {
                    add(
                        products.entry(monomial.clone()).or_insert_with(|| (Basis::default(), SymMatrix::zeros(6))),
                        factor,
                    );
                }
            }
        }
    }
}

/// Which matrix of a model, or of a superelement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Stiffness,
    Mass,
    Damping,
}

/// What the matrices of a superelement, or of a term of one, add: which of its matrices, to which of the model, with which factor.
///
/// ```text
/// K = c_K(θ) K_k,    M = c_M(θ) M_k,    C = c_C(θ) C_k + β(θ) c_K(θ) K_k + α(θ) c_M(θ) M_k
/// ```
pub(super) fn matrix_uses(element: &PlacedElement, origin: &[f64]) -> Vec<(Kind, Kind, Polynomial)> {
    let of = |value: &Option<Value>| Polynomial::of(value.as_ref(), origin);
    let (stiffness, mass) = (of(&element.stiffness_factor), of(&element.mass_factor));
    let damping = of(&element.matrices.as_ref().and_then(|m| m.damping_factor.clone()));
    // Damping in proportion is zero where nothing is said.
    let proportional =
        |value: &Option<Value>, of: &Polynomial| value.as_ref().map(|v| Polynomial::of(Some(v), origin).times(of));
    let by_stiffness = proportional(&element.stiffness_damping, &stiffness);
    let by_mass = proportional(&element.mass_damping, &mass);
    let own =
        [(Kind::Stiffness, stiffness), (Kind::Mass, mass), (Kind::Damping, damping)].map(|(kind, p)| (kind, kind, p));
    let damped = [(Kind::Stiffness, by_stiffness), (Kind::Mass, by_mass)];
    let damped = damped.into_iter().filter_map(|(of, p)| Some((of, Kind::Damping, p?)));
    own.into_iter().chain(damped).collect()
}

fn push(list: &mut Vec<Entry>, connection: &Connection, reduced: &DMatrix<f64>) {
    list.extend(connection.entries(reduced).filter(|e| e.value != 0.0));
}

impl Basis {
    /// Adds one element's matrices, their zeros too, so that the pattern is that of any θ; but for a damping that is zero.
    pub(super) fn add(&mut self, connection: &Connection, matrices: &ElementMatrices) {
        let damping = (!matrices.damping.is_zero()).then_some(&matrices.damping);
        let of = [Some(&matrices.stiffness), Some(&matrices.mass), damping];
        for (list, a) in [&mut self.stiffness, &mut self.mass, &mut self.damping].into_iter().zip(of) {
            let Some(a) = a else { continue };
            list.extend(connection.entries(&connection.reduce(a)));
        }
    }
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
        for e in connection.entries(&connection.reduce(matrix)) {
            target[(e.row, e.column)] += e.value;
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
            triplets.extend(c.entries(&matrices[which]).map(|e| (e.row, e.column, e.value)));
        }
        SparseSym::from_triplets(n, triplets.iter().copied())
    };
    SparseSystem {
        stiffness: matrix(0, &|b| b.stiffness.len()),
        mass: matrix(1, &|b| b.mass.len()),
        damping: damped.then(|| matrix(2, &|b| b.damping.len())),
    }
}
