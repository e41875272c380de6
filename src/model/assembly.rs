//! Assembly: from placed elements to K(θ), M(θ), C(θ) on the independent dofs.
//!
//! Elements whose matrices are polynomials of θ (found by evaluation, see [`super::dependence`]) are assembled once, as
//! K0 + Σ θ_j K_j + Σ c_k(θ) K_k in sparse lists with products c_k of powers; the others are evaluated at every θ.

use super::ElementMatrices;
use super::acting::{Acting, Term};
use super::connection::{Connection, turns};
use super::constraint::Elimination;
use super::dependence::Monomial;
use super::dof_map::DofMap;
use super::each::of_each;
use super::entry::{Entry, merge};
use super::geometry::Geometry;
use super::mass_properties::add_rigid_mass;
use super::placed_element::PlacedElement;
use super::polynomial::Polynomial;
use super::system::{SparseSystem, System};
use super::value::Value;
use crate::element::Dof;
use crate::linalg::sparse::SparseSym;
use crate::linalg::{DMatrix, SymMatrix};
use std::collections::BTreeMap;
use std::sync::Arc;

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
/// K(θ) = K0 + Σ_j θ_j K_j + Σ_k c_k(θ) K_k,    c_k(θ) = Π θ_j^p
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AffinePart {
    /// K0, M0, C0.
    pub constant: Basis,
    /// K_j, M_j, C_j for each parameter of θ.
    pub parameters: Vec<Basis>,
    /// Products, each with its K_k, M_k, C_k, in the order of their powers.
    pub products: Vec<(Monomial, Basis)>,
}

impl AffinePart {
    /// Every basis.
    pub fn bases(&self) -> impl Iterator<Item = &Basis> {
        std::iter::once(&self.constant).chain(&self.parameters).chain(self.products.iter().map(|p| &p.1))
    }

    /// Every basis with its factor at θ.
    pub fn at(&self, theta: &[f64]) -> impl Iterator<Item = (&Basis, f64)> {
        let products = self.products.iter().map(|(monomial, basis)| (basis, monomial.at(theta)));
        std::iter::once((&self.constant, 1.0)).chain(self.parameters.iter().zip(theta.iter().copied())).chain(products)
    }

    /// The bases that depend on θ_j, each with the derivative of its factor.
    pub fn derivative(&self, theta: &[f64], j: usize) -> impl Iterator<Item = (&Basis, f64)> {
        let products = self.products.iter().map(move |(monomial, basis)| (basis, monomial.derivative(theta, j)));
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

    /// Whether it depends on parameter `j`.
    ///
    /// * `of` - what they are the terms of
    pub(super) fn depends_on(&self, of: &AffinePart, j: usize) -> bool {
        let is_there = |mass: &SymMatrix| mass.lower().iter().any(|v| *v != 0.0);
        let mut products = of.products.iter().zip(&self.products);
        self.linear.get(j + 1).is_some_and(is_there)
            || products.any(|((c, _), mass)| c.powers.iter().any(|p| p.0 == j) && is_there(mass))
    }
}

/// Which dofs of the nodes any element acts on, 6 per node.
pub(super) fn touched(elements: &[PlacedElement], acting: &[Arc<Acting>], n_nodes: usize) -> Vec<bool> {
    let mut touched = vec![false; 6 * n_nodes];
    for (element, acting) in elements.iter().zip(acting) {
        if let Some(matrices) = &element.matrices {
            matrices.touch(&mut touched);
            continue;
        }
        for &dof in &acting.dofs {
            let (k, i) = (usize::from(dof) / 6, usize::from(dof) % 6);
            let node = element.nodes[k];
            for global in 0..3 {
                if element.axes[i % 3][global].abs() > 1e-12 {
                    touched[6 * node + 3 * (i / 3) + global] = true;
                    let levers = turns(global, element.arm(k)).into_iter().filter(|t| i < 3 && t.1 != 0.0);
                    levers.for_each(|(turn, _)| touched[6 * node + turn as usize] = true);
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

/// Elements whose matrices are reduced at once before they are added in their order.
const AT_ONCE: usize = 4096;

/// The affine part of a model and its masses of rigid motion.
///
/// * `n_parameters` - length of θ
pub(super) fn affine_part(
    elements: &[PlacedElement],
    acting: &[Arc<Acting>],
    connections: &[Connection],
    dofs: &DofMap,
    positions: &[[f64; 3]],
    n_parameters: usize,
) -> (AffinePart, AffineMass) {
    let mut parts = Parts { linear: vec![Part::default(); n_parameters + 1], products: BTreeMap::new() };
    let all: Vec<usize> = (0..elements.len()).filter(|&e| elements[e].matrices.is_none()).collect();
    let reduced = |&e: &usize| {
        let (element, acting, connection) = (&elements[e], &acting[e], &connections[e]);
        // The mass of a coordinate is none of the structure.
        let is_body = !element.nodes.iter().any(|n| dofs.is_coordinate(*n));
        let of_term = |term: &Term| {
            let on_rows = |a: &SymMatrix| {
                let reduced = connection.reduce_on(&acting.dofs, a);
                connection.entries(&reduced).filter(|e| e.value != 0.0).collect()
            };
            let lists = [0, 1, 2].map(|i| term.matrices[i].as_ref().map_or_else(Vec::new, on_rows));
            let weighed = term.weighed(&acting.dofs, connection.n_dof()).filter(|_| is_body);
            let mut rigid = SymMatrix::zeros(6);
            if let Some(mass) = weighed {
                add_rigid_mass(&mut rigid, 1.0, &mass, &element.axes, &element.ends(positions));
            }
            (lists, rigid)
        };
        acting.terms.iter().flatten().map(|term| (&term.monomial, of_term(term))).collect::<Vec<_>>()
    };
    for some in all.chunks(AT_ONCE) {
        for (monomial, (lists, rigid)) in of_each(some, reduced).into_iter().flatten() {
            parts.of(monomial).add(lists, &rigid);
        }
    }
    for element in elements.iter().filter(|e| e.matrices.is_some()) {
        add_matrices(element, dofs, positions, &mut parts);
    }
    let Parts { linear, products } = parts;
    let (mut part, mut mass) = (AffinePart::default(), AffineMass::default());
    for (place, of) in linear.into_iter().enumerate() {
        let (basis, rigid) = of.merged();
        if place == 0 {
            part.constant = basis;
        } else {
            part.parameters.push(basis);
        }
        mass.linear.push(rigid);
    }
    for (monomial, of) in products {
        let (basis, rigid) = of.merged();
        part.products.push((monomial, basis));
        mass.products.push(rigid);
    }
    (part, mass)
}

/// Entries that are collected before those of one place are summed.
const UNMERGED: usize = 1 << 20;

/// A basis and its 6 x 6 mass matrix of rigid motions.
#[derive(Clone)]
struct Part {
    basis: Basis,
    rigid: SymMatrix,
    /// Entries of K, M and C that are merged.
    merged: [usize; 3],
}

impl Default for Part {
    fn default() -> Self {
        Self { basis: Basis::default(), rigid: SymMatrix::zeros(6), merged: [0; 3] }
    }
}

impl Part {
    /// Adds the entries of an element, and its mass of rigid motions. Lists are merged whenever they have doubled: they stay as long as what
    /// is in them.
    fn add(&mut self, lists: [Vec<Entry>; 3], rigid: &SymMatrix) {
        for ((list, merged), new) in self.basis.lists().into_iter().zip(&mut self.merged).zip(lists) {
            list.extend(new);
            if list.len() > 2 * *merged + UNMERGED {
                merge(list);
                *merged = list.len();
            }
        }
        self.rigid.add_scaled(1.0, rigid);
    }

    fn merged(mut self) -> (Basis, SymMatrix) {
        for list in self.basis.lists() {
            merge(list);
            list.shrink_to_fit();
        }
        (self.basis, self.rigid)
    }
}

/// The parts of an [`AffinePart`] while they grow.
struct Parts {
    linear: Vec<Part>,
    products: BTreeMap<Monomial, Part>,
}

impl Parts {
    fn of(&mut self, monomial: &Monomial) -> &mut Part {
        match monomial.powers.as_slice() {
            [] => &mut self.linear[0],
            [(j, 1)] => &mut self.linear[j + 1],
            _ => self.products.entry(monomial.clone()).or_default(),
        }
    }
}

/// Adds the matrices of a superelement, or of a term of one, to the parts of their powers, as [`matrix_uses`] says.
fn add_matrices(element: &PlacedElement, dofs: &DofMap, positions: &[[f64; 3]], parts: &mut Parts) {
    let Some(matrices) = &element.matrices else { return };
    let follows = matrices.follows(dofs);
    let uses = matrix_uses(element);
    for (of, matrix) in [(Kind::Stiffness, &matrices.k), (Kind::Mass, &matrices.m), (Kind::Damping, &matrices.c)] {
        let Some(matrix) = matrix else { continue };
        let mut entries = follows.reduce(matrix);
        merge(&mut entries);
        let rigid = (of == Kind::Mass).then(|| matrices.rigid(matrix, positions));
        for (_, kind, polynomial) in uses.iter().filter(|u| u.0 == of) {
            let kind = *kind;
            for (monomial, factor) in polynomial.terms() {
                let part = parts.of(monomial);
                let list = match kind {
                    Kind::Stiffness => &mut part.basis.stiffness,
                    Kind::Mass => &mut part.basis.mass,
                    Kind::Damping => &mut part.basis.damping,
                };
                list.extend(entries.iter().map(|e| Entry { value: factor * e.value, ..*e }));
                if let Some(rigid) = rigid.as_ref().filter(|_| kind == Kind::Mass) {
                    part.rigid.add_scaled(factor, rigid);
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
pub(super) fn matrix_uses(element: &PlacedElement) -> Vec<(Kind, Kind, Polynomial)> {
    let of = |value: &Option<Value>| Polynomial::of(value.as_ref());
    let (stiffness, mass) = (of(&element.stiffness_factor), of(&element.mass_factor));
    let damping = of(&element.matrices.as_ref().and_then(|m| m.damping_factor.clone()));
    // Damping in proportion is zero where nothing is said.
    let proportional =
        |value: &Option<Value>, of: &Polynomial| value.as_ref().map(|v| Polynomial::of(Some(v)).times(of));
    let by_stiffness = proportional(&element.stiffness_damping, &stiffness);
    let by_mass = proportional(&element.mass_damping, &mass);
    let own =
        [(Kind::Stiffness, stiffness), (Kind::Mass, mass), (Kind::Damping, damping)].map(|(kind, p)| (kind, kind, p));
    let damped = [(Kind::Stiffness, by_stiffness), (Kind::Mass, by_mass)];
    let damped = damped.into_iter().filter_map(|(of, p)| Some((of, Kind::Damping, p?)));
    own.into_iter().chain(damped).collect()
}

impl Basis {
    fn lists(&mut self) -> [&mut Vec<Entry>; 3] {
        [&mut self.stiffness, &mut self.mass, &mut self.damping]
    }

    /// Adds one element's matrices, their zeros too, so that the pattern is that of any θ; but for a damping that is zero.
    pub(super) fn add(&mut self, connection: &Connection, matrices: &ElementMatrices) {
        let damping = (!matrices.damping.is_zero()).then_some(&matrices.damping);
        let of = [Some(&matrices.stiffness), Some(&matrices.mass), damping];
        for (list, a) in self.lists().into_iter().zip(of) {
            let Some(a) = a else { continue };
            list.extend(connection.entries(&connection.reduce(a)));
        }
    }
}

/// Adds `factor` times a basis to the lower triangles of a system.
pub(super) fn add_basis(system: &mut System, basis: &Basis, factor: f64) {
    for (matrix, list) in [(&mut system.stiffness, &basis.stiffness), (&mut system.mass, &basis.mass)] {
        for e in list {
            matrix[e.place()] += factor * e.value;
        }
    }
    if let Some(c) = &mut system.damping {
        for e in &basis.damping {
            c[e.place()] += factor * e.value;
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
            target[e.place()] += e.value;
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
    let matrix = |which: usize| {
        let of_bases = bases.iter().flat_map(|(basis, factor)| {
            let entries = [&basis.stiffness, &basis.mass, &basis.damping][which];
            entries.iter().map(Entry::triplet).map(move |(row, column, value)| (row, column, factor * value))
        });
        let of_elements = reduced.iter().flat_map(|(c, matrices)| c.entries(&matrices[which]).map(|e| e.triplet()));
        SparseSym::from_triplets(n, of_bases.chain(of_elements))
    };
    SparseSystem { stiffness: matrix(0), mass: matrix(1), damping: damped.then(|| matrix(2)) }
}
