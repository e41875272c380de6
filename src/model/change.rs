//! What entries that are added to a file change in the matrices of its model, element by element.
//!
//! ```text
//! K(θ, s) = K(θ) + Σ_e B_eᵀ (k_e(θ, s) - k_e(θ)) B_e,    M and C alike
//! ```
//!
//! over the elements that depend on the sizes s of the change or that it brings: an override, a mass, a spring, a body on a spring, a support
//! that gives. Nothing of it grows with the model, once the longer file is placed: [`Additions`] places many changes at once, each with
//! parameters of its own, and takes each out as if the others were not there. Other factors on the matrices of a superelement, or of a term of
//! one, are changes too, as large as those matrices.

mod additions;
mod altered;
mod at;
mod factored;
mod scaled;

pub use self::additions::Additions;
pub use self::at::ChangeAt;
pub(super) use self::factored::OnRows;

use self::altered::Altered;
use self::at::PartAt;
use self::factored::Factored;
use super::connection::Connection;
use super::dependence::{Terms, central_difference, dependence, dependences, element_matrices, weighed_mass};
use super::dof_map::rigid_motion;
use super::elastic_support::ElasticSupports;
use super::geometry::minus;
use super::mass_properties::add_rigid_mass;
use super::moving::EndMotion;
use super::parameter::{Parameter, ParameterSet};
use super::placed_element::PlacedElement;
use super::{ElementMatrices, Model, ModelError, ParametricModel};
use crate::element::Dof;
use crate::linalg::{DMatrix, SymMatrix};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Elements whose terms are found together: those of a shell take some 30 kB.
const AT_ONCE: usize = 1024;

/// A change of the matrices of a model, with sizes of its own.
#[derive(Debug, Clone)]
pub struct Change {
    model: Arc<Model>,
    parts: Vec<Part>,
    /// Where the coordinates that it brings stand, m, and what they are.
    new: Vec<([f64; 3], Dof)>,
    n_sizes: usize,
    /// Nodes of the model that it moves.
    moved: BTreeMap<usize, EndMotion>,
}

/// A part of a change.
#[derive(Debug, Clone)]
enum Part {
    /// An element that it brings, and where its ends are, global, m.
    Brought { connection: Box<Connection>, element: Box<PlacedElement>, ends: Box<[[f64; 3]]> },
    /// An element of the model, by index, as if the change brought it.
    Taken(usize),
    /// An element of the model, by index, that it alters.
    Altered { before: usize, after: Altered },
    /// The supports, as they are with it or, with the sign -1, without it.
    Supports { supports: Arc<ElasticSupports>, sign: f64 },
    /// A superelement, or a term of one.
    Factored(Box<Factored>),
}

impl Part {
    fn supports(supports: ElasticSupports, sign: f64) -> Self {
        Part::Supports { supports: Arc::new(supports), sign }
    }

    /// Takes supports away.
    fn without(supports: &ElasticSupports) -> Self {
        Self::supports(supports.clone(), -1.0)
    }
}

impl Change {
    /// Everything of a model that is not a polynomial of its parameters, as if the change brought it.
    pub(super) fn of_general(model: &Arc<Model>) -> Self {
        let supports = model.elastic_supports().map(|s| Part::supports(s.clone(), 1.0));
        let general = (0..model.elements().len()).filter(|&e| model.is_general(e));
        let parts = general.map(Part::Taken).chain(supports).collect();
        Self { model: model.clone(), parts, new: Vec::new(), n_sizes: 0, moved: BTreeMap::new() }
    }

    /// Number of its elements.
    pub fn len(&self) -> usize {
        self.parts.len()
    }

    /// Whether it changes nothing.
    pub fn is_empty(&self) -> bool {
        self.parts.is_empty()
    }

    /// The elements of the model that it alters, by index.
    pub fn altered(&self) -> impl Iterator<Item = usize> + '_ {
        self.parts.iter().filter_map(|part| match part {
            Part::Altered { before, .. } => Some(*before),
            Part::Factored(part) => Some(part.before),
            Part::Brought { .. } | Part::Taken(_) | Part::Supports { .. } => None,
        })
    }

    /// Number of coordinates that it brings; they stand behind the rows of the model.
    pub fn n_new(&self) -> usize {
        self.new.len()
    }

    /// What a new coordinate moves by in the six rigid motions about the origin.
    pub(super) fn rigid_motions(&self, new: usize) -> [f64; 6] {
        let (at, dof) = self.new[new];
        std::array::from_fn(|motion| rigid_motion(at, motion)[dof as usize])
    }

    /// Number of its sizes.
    pub fn n_sizes(&self) -> usize {
        self.n_sizes
    }

    /// The nodes of the model that it moves, by index.
    pub fn moved_nodes(&self) -> impl Iterator<Item = usize> + '_ {
        self.moved.keys().copied()
    }

    /// How far it moves a node: the point that its dofs stand for, and where the node lies beside that point, global, m; `None` where it does not.
    pub fn displacement(&self, node: usize, theta: &[f64], sizes: &[f64]) -> Option<[[f64; 3]; 2]> {
        let with = self.moved.get(&node)?.at(&[theta, sizes].concat());
        let without = self.model.displaced(node, theta).unwrap_or([[0.0; 3]; 2]);
        Some([0, 1].map(|k| minus(with[k], without[k])))
    }

    /// Rows of the model that it touches, then its new coordinates.
    pub(super) fn rows(&self) -> Vec<usize> {
        let mut rows: Vec<usize> = (0..self.len()).flat_map(|k| self.rows_of(k).iter().copied()).collect();
        rows.sort_unstable();
        rows.dedup();
        rows
    }

    /// How the dofs of one of its elements follow from rows and new coordinates, u_e = B q\[rows\]; `None` of a superelement.
    pub(super) fn motion(&self, part: usize) -> Option<&Connection> {
        match &self.parts[part] {
            Part::Brought { connection, .. } => Some(connection),
            Part::Taken(e) | Part::Altered { before: e, .. } => Some(self.model.element_motion(*e)),
            Part::Supports { supports, .. } => Some(supports.connection()),
            Part::Factored(_) => None,
        }
    }

    fn rows_of(&self, part: usize) -> &[usize] {
        match &self.parts[part] {
            Part::Factored(part) => part.of.rows(),
            _ => self.motion(part).map_or(&[], |c| &c.rows),
        }
    }

    /// The change at one point.
    ///
    /// * `theta` - the parameters of the model
    ///
    /// # Errors
    /// An element has no matrices there.
    pub fn at(&self, theta: &[f64], sizes: &[f64]) -> Result<ChangeAt<'_>, ModelError> {
        let point = [theta, sizes].concat();
        let at = |k: usize| {
            Ok(match (&self.parts[k], self.motion(k)) {
                (Part::Factored(part), _) => Some(PartAt::Factored { part, factors: part.at(&self.model, &point) }),
                (_, Some(connection)) => Some(PartAt::Element { connection, own: self.matrices(k, theta, sizes)? }),
                (_, None) => None,
            })
        };
        let parts = (0..self.len()).filter_map(|k| at(k).transpose()).collect::<Result<_, ModelError>>()?;
        Ok(ChangeAt::new(self.rows(), self.model.dof_map().n_dof(), parts))
    }

    /// What one of its elements, or its supports, add to K, M and C in their axes; zero matrices of no dof of a superelement.
    ///
    /// * `theta` - the parameters of the model
    pub(super) fn matrices(&self, part: usize, theta: &[f64], sizes: &[f64]) -> Result<ElementMatrices, ModelError> {
        let all = [theta, sizes].concat();
        let (elements, connections) = self.model.elements_and_connections();
        match &self.parts[part] {
            Part::Brought { element, .. } => Ok(element_matrices(element, &all)?),
            Part::Taken(e) => Ok(element_matrices(&elements[*e], theta)?),
            Part::Altered { before, after } => after.matrices(&elements[*before], &all, theta),
            Part::Supports { supports, sign } => {
                let of = supports.matrices(elements, connections, &all)?;
                Ok(of.combine(&of, |a, _| sign * a))
            }
            Part::Factored(_) => Ok(ElementMatrices::zeros(0)),
        }
    }

    /// Whether its matrices are polynomials of the parameters of the model and of its sizes.
    pub fn is_polynomial(&self, sizes: &[Parameter]) -> bool {
        let all = ParameterSet::new(self.model.parameters().iter().chain(sizes).cloned().collect());
        let mut are = true;
        self.each_terms(&all, |_| ElementMatrices::zeros(0), |_, terms| are &= terms.is_some());
        are
    }

    /// What each of its elements adds, as terms that are summed with the powers of the parameters of the model, with the sizes behind them; `None`
    /// where it is not a polynomial.
    ///
    /// * `all` - the parameters of the model, then those that the change brings
    /// * `on_coordinates` - the matrices of a superelement on the coordinates that are wanted
    /// * `take` - what is done with those of a part
    pub(super) fn each_terms(
        &self,
        all: &ParameterSet,
        on_coordinates: impl Fn(&OnRows) -> ElementMatrices,
        mut take: impl FnMut(usize, Option<Terms>),
    ) {
        let known = self.model.elements();
        for first in (0..self.len()).step_by(AT_ONCE) {
            let parts = &self.parts[first..self.len().min(first + AT_ONCE)];
            let asked = |part: &Part| match part {
                Part::Brought { element, .. } => vec![(**element).clone()],
                Part::Taken(e) => vec![known[*e].clone()],
                Part::Altered { before, after } => after.asked(&known[*before]),
                Part::Supports { .. } | Part::Factored(_) => Vec::new(),
            };
            let elements: Vec<PlacedElement> = parts.iter().flat_map(asked).collect();
            let one_by_one = |_| elements.iter().map(|e| dependence(e, all).ok().flatten()).collect();
            let these: Vec<usize> = (0..elements.len()).collect();
            let found = dependences(&elements, &these, all, |_, terms| terms).unwrap_or_else(one_by_one);
            let mut found = found.into_iter();
            let mut next = || found.next().flatten();
            for (k, part) in parts.iter().enumerate() {
                let terms = match part {
                    Part::Brought { .. } | Part::Taken(_) => next(),
                    Part::Altered { after, .. } => after.terms(&mut next),
                    Part::Supports { .. } => None,
                    Part::Factored(part) => Some(part.terms(&self.model, &on_coordinates(&part.of))),
                };
                take(first + k, terms);
            }
        }
    }

    /// Whether one of its elements depends on a parameter of the model or, behind those, on a size.
    pub fn depends_on(&self, part: usize, j: usize) -> bool {
        match &self.parts[part] {
            Part::Brought { element, .. } => element.depends_on(j),
            Part::Taken(e) => self.model.elements()[*e].depends_on(j),
            Part::Altered { before, after } => after.depends_on(j) || self.model.elements()[*before].depends_on(j),
            Part::Supports { supports, .. } => supports.depends_on(j),
            Part::Factored(part) => part.depends_on(&self.model, j),
        }
    }

    /// ∂/∂θ_j of [`Self::matrices`], by differences.
    ///
    /// * `j` - of the parameters of the model with the sizes behind them
    pub(super) fn slopes(
        &self,
        part: usize,
        theta: &[f64],
        sizes: &[f64],
        j: usize,
        step: f64,
    ) -> Result<ElementMatrices, ModelError> {
        let at = |s: f64| {
            let (mut theta, mut sizes) = (theta.to_vec(), sizes.to_vec());
            if j < theta.len() {
                theta[j] += s * step;
            } else {
                sizes[j - theta.len()] += s * step;
            }
            self.matrices(part, &theta, &sizes)
        };
        central_difference(at, step, |a, b, width| a.combine(&b, |a, b| (a - b) / width))
    }

    /// φᵀ ΔC φ of shapes on the rows of the model; coordinates that it brings, and superelements, damp nothing.
    ///
    /// * `shapes` - (n_dof x any number)
    ///
    /// # Errors
    /// An element has no matrices there.
    pub fn damping_of(&self, theta: &[f64], sizes: &[f64], shapes: &DMatrix<f64>) -> Result<Vec<f64>, ModelError> {
        let mut out = vec![0.0; shapes.ncols()];
        for k in 0..self.len() {
            let Some(connection) = self.motion(k) else { continue };
            let damping = self.matrices(k, theta, sizes)?.damping;
            if damping.is_zero() {
                continue;
            }
            let rows = &connection.rows;
            let of = |i: usize, j: usize| if rows[i] < shapes.nrows() { shapes[(rows[i], j)] } else { 0.0 };
            let local = connection.times(&DMatrix::from_fn(rows.len(), shapes.ncols(), of));
            let force = damping.to_dense() * &local;
            out.iter_mut().zip(local.column_iter().zip(force.column_iter())).for_each(|(o, (u, f))| *o += u.dot(&f));
        }
        Ok(out)
    }

    /// Rᵀ ΔM R of the six rigid motions about the origin, (6 x 6).
    pub fn rigid_mass(&self, theta: &[f64], sizes: &[f64]) -> Result<SymMatrix, ModelError> {
        let mut rigid = SymMatrix::zeros(6);
        (0..self.len()).try_for_each(|part| self.add_rigid_mass_at(part, &mut rigid, theta, sizes))?;
        Ok(rigid)
    }

    /// Adds what one part of it has of Rᵀ ΔM R at one point.
    pub(super) fn add_rigid_mass_at(
        &self,
        part: usize,
        rigid: &mut SymMatrix,
        theta: &[f64],
        sizes: &[f64],
    ) -> Result<(), ModelError> {
        match &self.parts[part] {
            Part::Brought { .. } | Part::Taken(_) | Part::Altered { .. } => {
                let all = [theta, sizes].concat();
                self.add_rigid_mass_of(part, &all, &self.weighed(part, theta, &all)?, rigid);
            }
            Part::Factored(of) => of.add_rigid_mass(rigid, &self.model, &[theta, sizes].concat()),
            Part::Supports { .. } => {}
        }
        Ok(())
    }

    /// What an element that it brings, takes or alters adds to the mass that a balance sees, in its axes.
    ///
    /// * `all` - the parameters of the model, `theta`, with the sizes behind them
    fn weighed(&self, part: usize, theta: &[f64], all: &[f64]) -> Result<SymMatrix, ModelError> {
        let elements = self.model.elements();
        match &self.parts[part] {
            Part::Brought { element, .. } => weighed_mass(element, all),
            Part::Taken(e) => weighed_mass(&elements[*e], theta),
            Part::Altered { before, after } => after.weighed(&elements[*before], all, theta),
            Part::Supports { .. } | Part::Factored(_) => Ok(SymMatrix::zeros(0)),
        }
    }

    /// Adds Rᵀ m R of the six rigid motions for the mass of one of its elements.
    ///
    /// * `all` - the parameters of the model with the sizes behind them
    /// * `mass` - the one that a balance sees
    pub(super) fn add_rigid_mass_of(&self, part: usize, all: &[f64], mass: &SymMatrix, rigid: &mut SymMatrix) {
        let (elements, geometry) = (self.model.elements(), self.model.geometry());
        let (element, mut ends) = match &self.parts[part] {
            Part::Brought { element, ends, .. } => (Cow::Borrowed(&**element), ends.to_vec()),
            Part::Taken(e) => (Cow::Borrowed(&elements[*e]), elements[*e].ends(&geometry.positions)),
            // The mass of a coordinate is none of the structure.
            Part::Altered { before, .. } if elements[*before].nodes.iter().any(|n| geometry.is_coordinate(*n)) => {
                return;
            }
            Part::Altered { before, after } => {
                let element = after.element(&elements[*before]);
                let ends = element.ends(&geometry.positions);
                (Cow::Owned(element), ends)
            }
            Part::Supports { .. } | Part::Factored(_) => return,
        };
        if let Some(moving) = &element.moving {
            moving.carry(&mut ends, all);
        }
        add_rigid_mass(rigid, 1.0, mass, &element.axes, &ends);
    }

    /// Without the coordinates that nothing holds and that nothing is heavy in.
    fn without_idle_coordinates(mut self, typical: &[f64]) -> Option<Self> {
        let n = self.model.dof_map().n_dof();
        if self.new.is_empty() {
            return Some(self);
        }
        let theta = super::dependence::interior_point(self.model.parameters());
        let mut used = vec![false; self.new.len()];
        for k in 0..self.parts.len() {
            let Some(connection) = self.motion(k) else { continue };
            let matrices = self.matrices(k, &theta, typical).ok()?;
            let b = connection.b();
            for (j, row) in connection.rows.iter().enumerate().filter(|(_, row)| **row >= n) {
                let motion = b.column(j);
                let acts = |a: &SymMatrix| (a.to_dense() * motion).amax() > 0.0;
                used[row - n] |= acts(&matrices.stiffness) || acts(&matrices.mass);
            }
        }
        let place: Vec<usize> = used
            .iter()
            .scan(0, |next, used| {
                *next += usize::from(*used);
                Some(*next - usize::from(*used))
            })
            .collect();
        for part in &mut self.parts {
            // All else stands on rows of the model.
            let Part::Brought { connection, .. } = part else { continue };
            let (rows, b) = (&connection.rows, connection.b());
            let kept: Vec<usize> = (0..rows.len()).filter(|&j| rows[j] < n || used[rows[j] - n]).collect();
            let row = |&j: &usize| if rows[j] < n { rows[j] } else { n + place[rows[j] - n] };
            **connection = Connection::of(kept.iter().map(row).collect(), &b.select_columns(&kept));
        }
        let kept = used.iter().zip(std::mem::take(&mut self.new)).filter(|(used, _)| **used);
        self.new = kept.map(|(_, at)| at).collect();
        Some(self)
    }
}
