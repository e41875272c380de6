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

mod at;
mod factored;

pub use self::at::ChangeAt;
pub(super) use self::factored::OnRows;

use self::at::PartAt;
use self::factored::Factored;
use super::connection::{Connection, motion_in_axes, place as place_of};
use super::constraint::{Elimination, eliminate};
use super::dependence::{Terms, central_difference, dependence, element_matrices};
use super::dof_map::{Combination, rigid_motion};
use super::elastic_support::ElasticSupports;
use super::mass_properties::add_rigid_mass;
use super::parameter::{Parameter, ParameterSet};
use super::place::{Placed, place};
use super::placed_element::{Compliance, PlacedElement};
use super::registry::Registry;
use super::spec::ModelSpec;
use super::value::{Affine, Value};
use super::{ElementMatrices, Model, ModelError, ParametricModel};
use crate::element::Dof;
use crate::linalg::{DMatrix, SymMatrix};
use crate::yaml::Severity;
use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex, PoisonError};

/// A file with many changes, placed.
#[derive(Debug)]
pub struct Additions {
    model: Arc<Model>,
    placed: Placed,
    elimination: Elimination,
    /// Index in θ of a parameter.
    index_of: HashMap<String, usize>,
    /// Elements that depend on a parameter of a change, by its index.
    users: HashMap<usize, Vec<usize>>,
    /// Elements of the model by name.
    known: HashMap<String, usize>,
    /// Paths of what is wrong in the file.
    refused: Vec<String>,
    /// Matrices of superelements and terms, by the index of their element in the model, as they are asked for.
    on_rows: Mutex<HashMap<usize, Arc<OnRows>>>,
}

impl Additions {
    /// Places a file that is the model's with more entries and parameters, the parameters last.
    pub fn new(model: &Arc<Model>, longer: &ModelSpec, registry: &Registry) -> Self {
        let mut problems = Vec::new();
        let placed = place(longer, registry, &mut problems);
        let elimination = eliminate(longer, &placed.geometry, Elimination::default(), &[], &placed.rows, &mut problems);
        let n = model.parameters().len();
        let mut users: HashMap<usize, Vec<usize>> = HashMap::new();
        for (e, element) in placed.elements.iter().enumerate() {
            let mut of: Vec<usize> = element.expressions().flat_map(Value::parameters).filter(|&p| p >= n).collect();
            of.sort_unstable();
            of.dedup();
            for p in of {
                users.entry(p).or_default().push(e);
            }
        }
        let index_of = placed.parameters.names().enumerate().map(|(i, name)| (name.to_string(), i)).collect();
        let known = model.elements().iter().enumerate().map(|(i, e)| (e.name.clone(), i)).collect();
        let wrong = problems.into_iter().filter(|p| p.severity == Severity::Error);
        let refused = wrong.map(|p| p.path).collect();
        let (model, on_rows) = (model.clone(), Mutex::default());
        Self { model, placed, elimination, index_of, users, known, refused, on_rows }
    }

    /// The matrices of an element of the model that stands for a superelement or a term of one.
    fn on_rows(&self, element: usize) -> Option<Arc<OnRows>> {
        let matrices = self.model.elements()[element].matrices.as_ref()?;
        let mut known = self.on_rows.lock().unwrap_or_else(PoisonError::into_inner);
        let new = || Arc::new(OnRows::new(matrices, self.model.dof_map(), &self.model.geometry().positions));
        Some(known.entry(element).or_insert_with(new).clone())
    }

    /// The change that some parameters bring; `None` where the file refuses one of its entries, or it changes more than elements and how
    /// much supports give.
    ///
    /// * `parameters` - their names, in the order of the sizes
    /// * `entries` - names of everything that the change adds
    /// * `typical` - sizes of an order that is expected
    pub fn change(&self, parameters: &[&str], entries: &[&str], typical: &[f64]) -> Option<Change> {
        if self.refused.iter().any(|path| entries.iter().any(|name| path.contains(name))) {
            return None;
        }
        let n = self.model.parameters().len();
        let own: Vec<usize> = parameters.iter().map(|p| self.index_of.get(*p).copied()).collect::<Option<_>>()?;
        // A parameter of another change stands at its neutral value.
        let alone = |value: &Value| {
            value.with_parameters(&|p| match own.iter().position(|o| *o == p) {
                Some(k) => Ok(n + k),
                None if p < n => Ok(p),
                None => Err(self.placed.parameters.get(p).value),
            })
        };
        let mut touched: Vec<usize> = own.iter().filter_map(|p| self.users.get(p)).flatten().copied().collect();
        touched.sort_unstable();
        touched.dedup();
        let mut new = NewCoordinates { additions: self, found: BTreeMap::new() };
        let mut parts: Vec<Part> = Vec::new();
        for e in touched {
            let mut element = self.placed.elements[e].clone();
            for value in Arc::make_mut(&mut element.values).iter_mut().flatten() {
                *value = alone(value);
            }
            for factor in [
                &mut element.stiffness_factor,
                &mut element.mass_factor,
                &mut element.stiffness_damping,
                &mut element.mass_damping,
            ] {
                *factor = factor.as_ref().map(alone);
            }
            let before = self.known.get(&element.name).copied();
            if element.matrices.is_some() {
                // A change brings no superelement.
                let before = before?;
                parts.push(Part::Factored(Factored::new(element, before, self.on_rows(before)?)));
                continue;
            }
            let connection = match before {
                Some(e) => self.model.element_motion(e).clone(),
                None => new.connection(&element)?,
            };
            let ends = element.ends(&self.placed.geometry.positions);
            parts.push(Part::Element { connection, element: Box::new(element), before, ends });
        }
        parts.extend(self.supports(&own, &alone, &parts)?);
        let dof_of = |(&d, &coordinate): (&usize, &usize)| {
            (coordinate, (self.placed.geometry.positions[d / 6], Dof::ALL[d % 6]))
        };
        let mut stand: Vec<_> = new.found.iter().map(dof_of).collect();
        stand.sort_by_key(|s| s.0);
        let new = stand.into_iter().map(|s| s.1).collect();
        let change = Change { model: self.model.clone(), parts, new, n_sizes: own.len() };
        change.without_idle_coordinates(typical)
    }

    /// Supports that give with the change, as they are with and without it; nothing where it does not change what they do.
    ///
    /// * `parts` - its elements
    fn supports(&self, own: &[usize], alone: &dyn Fn(&Value) -> Value, parts: &[Part]) -> Option<Vec<Part>> {
        let with_parts = |supports: &ElasticSupports| {
            let altered = parts.iter().filter_map(|part| match part {
                Part::Element { element, before: Some(e), .. } => Some((*e, &**element)),
                Part::Factored(part) => Some((part.before, &*part.after)),
                Part::Element { .. } | Part::Supports { .. } => None,
            });
            let brought = parts.iter().filter_map(|part| match part {
                Part::Element { connection, element, before: None, .. } => Some((&**element, connection)),
                _ => None,
            });
            supports.with(altered, brought, |n| self.model.geometry().node(&self.placed.geometry.names[n]))
        };
        let before = self.model.elastic_supports();
        let is_own = |c: &&Compliance| c.value.parameters().any(|p| own.contains(&p));
        if !self.placed.compliances.iter().any(|c| is_own(&c)) {
            let after = before.and_then(with_parts);
            let before = before.filter(|_| after.is_some());
            return Some(after.map(|s| Part::supports(s, 1.0)).into_iter().chain(before.map(Part::without)).collect());
        }
        let geometry = self.model.geometry();
        // Compliances of dofs that only other changes make give are zero.
        let moved = |c: &Compliance| {
            let node = geometry.node(&self.placed.geometry.names[c.dof / 6])?;
            Some(Compliance { dof: 6 * node + c.dof % 6, value: alone(&c.value) })
        };
        // What only other changes make give does not give here.
        let gives = |c: &Compliance| c.value.parameters().next().is_some() || c.value.at(&[]) != 0.0;
        let all: Vec<Compliance> = self.placed.compliances.iter().map(moved).collect::<Option<_>>()?;
        let compliances: Vec<Compliance> = all.into_iter().filter(gives).collect();
        let n_nodes = geometry.names.len();
        // A node of another change may have shifted rows of superelements.
        if !self.placed.rows.is_empty() && self.placed.geometry.names.len() != n_nodes {
            return None;
        }
        let keeping = Elimination::keeping(6 * n_nodes);
        let rows = &self.placed.rows;
        let released = eliminate(self.model.spec(), geometry, keeping, &compliances, rows, &mut Vec::new());
        let (elements, connections) = self.model.elements_and_connections();
        let after = ElasticSupports::new(compliances, &released, n_nodes, elements, connections, self.model.dof_map())?;
        let after = with_parts(&after).unwrap_or(after);
        Some([Part::supports(after, 1.0)].into_iter().chain(before.map(Part::without)).collect())
    }
}

/// Dofs of nodes that the model does not have.
struct NewCoordinates<'a> {
    additions: &'a Additions,
    /// (6 node + dof of the longer file) -> coordinate.
    found: BTreeMap<usize, usize>,
}

impl NewCoordinates<'_> {
    /// How an element that the model does not have hangs on its rows and on new coordinates; `None` if it is on nothing.
    fn connection(&mut self, element: &PlacedElement) -> Option<Connection> {
        let nodes: BTreeMap<usize, [Combination; 6]> =
            element.nodes.iter().map(|&n| (n, Dof::ALL.map(|dof| self.terms(n, dof)))).collect();
        let of = |node: usize, dof: Dof| &nodes[&node][dof as usize][..];
        let mut rows: Vec<usize> = nodes.values().flatten().flatten().map(|t| t.0).collect();
        rows.sort_unstable();
        rows.dedup();
        let b = motion_in_axes(element, rows.len(), of, |row| place_of(&rows, row));
        Some(Connection::of(rows, &b))
    }

    /// A dof of a node of the longer file in rows of the model, and in new coordinates behind them.
    fn terms(&mut self, node: usize, dof: Dof) -> Combination {
        let Additions { model, placed, elimination, .. } = self.additions;
        let dofs = model.dof_map();
        let on_model = |node: usize| model.geometry().node(&placed.geometry.names[node]);
        if let Some(known) = on_model(node) {
            return dofs.express(known, dof).to_vec();
        }
        let mut sum: BTreeMap<usize, f64> = BTreeMap::new();
        for (d, factor) in elimination.express(6 * node + dof as usize) {
            match on_model(d / 6) {
                Some(known) => {
                    let terms = dofs.express(known, Dof::ALL[d % 6]);
                    for &(row, f) in terms {
                        *sum.entry(row).or_default() += factor * f;
                    }
                }
                None => {
                    let next = self.found.len();
                    let coordinate = *self.found.entry(d).or_insert(next);
                    *sum.entry(dofs.n_dof() + coordinate).or_default() += factor;
                }
            }
        }
        sum.into_iter().collect()
    }
}

/// A change of the matrices of a model, with sizes of its own.
#[derive(Debug, Clone)]
pub struct Change {
    model: Arc<Model>,
    parts: Vec<Part>,
    /// Where the coordinates that it brings stand, m, and what they are.
    new: Vec<([f64; 3], Dof)>,
    n_sizes: usize,
}

/// A part of a change.
#[derive(Debug, Clone)]
enum Part {
    /// An element that it brings, or that it alters: that of the model, by index; and where its ends are, global, m.
    Element { connection: Connection, element: Box<PlacedElement>, before: Option<usize>, ends: Vec<[f64; 3]> },
    /// The supports, as they are with it or, with the sign -1, without it.
    Supports { supports: Arc<ElasticSupports>, sign: f64 },
    /// A superelement, or a term of one.
    Factored(Factored),
}

impl Part {
    fn supports(supports: ElasticSupports, sign: f64) -> Self {
        Part::Supports { supports: Arc::new(supports), sign }
    }

    /// Takes supports away.
    fn without(supports: &ElasticSupports) -> Self {
        Self::supports(supports.clone(), -1.0)
    }

    /// How its dofs follow from rows and new coordinates; `None` of matrices that are on the rows themselves.
    fn connection(&self) -> Option<&Connection> {
        match self {
            Part::Element { connection, .. } => Some(connection),
            Part::Supports { supports, .. } => Some(supports.connection()),
            Part::Factored(_) => None,
        }
    }

    fn rows(&self) -> &[usize] {
        match self {
            Part::Factored(part) => part.of.rows(),
            _ => self.connection().map_or(&[], |c| &c.rows),
        }
    }
}

impl Change {
    /// Everything of a model that is not a polynomial of its parameters, as if the change brought it.
    pub(super) fn of_general(model: &Arc<Model>) -> Self {
        let (elements, connections) = model.elements_and_connections();
        let part = |e: usize| Part::Element {
            connection: connections[e].clone(),
            element: Box::new(elements[e].clone()),
            before: None,
            ends: elements[e].ends(&model.geometry().positions),
        };
        let supports = model.elastic_supports().map(|s| Part::supports(s.clone(), 1.0));
        let parts = (0..elements.len()).filter(|&e| model.is_general(e)).map(part).chain(supports).collect();
        Self { model: model.clone(), parts, new: Vec::new(), n_sizes: 0 }
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
            Part::Element { before, .. } => *before,
            Part::Factored(part) => Some(part.before),
            Part::Supports { .. } => None,
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

    /// Rows of the model that it touches, then its new coordinates.
    pub(super) fn rows(&self) -> Vec<usize> {
        let mut rows: Vec<usize> = self.parts.iter().flat_map(|p| p.rows().iter().copied()).collect();
        rows.sort_unstable();
        rows.dedup();
        rows
    }

    /// How the dofs of one of its elements follow from rows and new coordinates, u_e = B q\[rows\]; `None` of a superelement.
    pub(super) fn motion(&self, part: usize) -> Option<&Connection> {
        self.parts[part].connection()
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
            Ok(match &self.parts[k] {
                Part::Factored(part) => PartAt::Factored { part, factors: part.at(&self.model, &point) },
                Part::Element { connection, .. } => {
                    PartAt::Element { connection, own: self.matrices(k, theta, sizes)? }
                }
                Part::Supports { supports, .. } => {
                    PartAt::Element { connection: supports.connection(), own: self.matrices(k, theta, sizes)? }
                }
            })
        };
        let parts = (0..self.len()).map(at).collect::<Result<_, ModelError>>()?;
        Ok(ChangeAt::new(self.rows(), self.model.dof_map().n_dof(), parts))
    }

    /// What one of its elements, or its supports, add to K, M and C in their axes; zero matrices of no dof of a superelement.
    ///
    /// * `theta` - the parameters of the model
    pub(super) fn matrices(&self, part: usize, theta: &[f64], sizes: &[f64]) -> Result<ElementMatrices, ModelError> {
        let all = [theta, sizes].concat();
        let (elements, connections) = self.model.elements_and_connections();
        match &self.parts[part] {
            Part::Element { element, before, .. } => {
                let after = element_matrices(element, &all)?;
                let Some(e) = before else { return Ok(after) };
                Ok(after.combine(&element_matrices(&elements[*e], theta)?, |a, b| a - b))
            }
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
        let none = |_: &OnRows| ElementMatrices::zeros(0);
        (0..self.len()).all(|part| self.terms(part, &all, none).is_some())
    }

    /// What one of its elements adds, as terms that are summed with the powers of the parameters of the model, with the sizes behind them; `None`
    /// where it is not a polynomial.
    ///
    /// * `all` - the parameters of the model, then those that the change brings
    /// * `on_coordinates` - the matrices of a superelement on the coordinates that are wanted
    pub(super) fn terms(
        &self,
        part: usize,
        all: &ParameterSet,
        on_coordinates: impl Fn(&OnRows) -> ElementMatrices,
    ) -> Option<Terms> {
        let (element, before) = match &self.parts[part] {
            Part::Element { element, before, .. } => (element, before),
            Part::Supports { .. } => return None,
            Part::Factored(part) => return Some(part.terms(&self.model, &on_coordinates(&part.of))),
        };
        let own = self.model.parameters();
        let mut out = dependence(element, all).ok()??;
        if let Some(e) = before {
            let before = dependence(&self.model.elements()[*e], own).ok()??;
            out.extend(before.into_iter().map(|(monomial, a)| (monomial, a.combine(&a, |a, _| -a))));
        }
        Some(out)
    }

    /// Whether one of its elements depends on a parameter of the model or, behind those, on a size.
    pub fn depends_on(&self, part: usize, j: usize) -> bool {
        match &self.parts[part] {
            Part::Element { element, before, .. } => {
                element.depends_on(j) || before.is_some_and(|e| self.model.elements()[e].depends_on(j))
            }
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
            Part::Element { .. } => self.add_rigid_mass_of(part, &self.matrices(part, theta, sizes)?, rigid),
            Part::Factored(of) => of.add_rigid_mass(rigid, &self.model, &[theta, sizes].concat()),
            Part::Supports { .. } => {}
        }
        Ok(())
    }

    /// Adds Rᵀ m R of the six rigid motions for matrices of one of its elements.
    pub(super) fn add_rigid_mass_of(&self, part: usize, matrices: &ElementMatrices, rigid: &mut SymMatrix) {
        let Part::Element { element, before, ends, .. } = &self.parts[part] else { return };
        let (elements, geometry) = (self.model.elements(), self.model.geometry());
        // The mass of a coordinate is none of the structure.
        let is_body = before.is_none_or(|e| !elements[e].nodes.iter().any(|n| geometry.is_coordinate(*n)));
        if is_body {
            add_rigid_mass(rigid, 1.0, matrices.weighed(), &element.axes, ends);
        }
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
            // Supports and superelements stand on rows of the model.
            let Part::Element { connection, .. } = part else { continue };
            let (rows, b) = (&connection.rows, connection.b());
            let kept: Vec<usize> = (0..rows.len()).filter(|&j| rows[j] < n || used[rows[j] - n]).collect();
            let row = |&j: &usize| if rows[j] < n { rows[j] } else { n + place[rows[j] - n] };
            *connection = Connection::of(kept.iter().map(row).collect(), &b.select_columns(&kept));
        }
        let kept = used.iter().zip(std::mem::take(&mut self.new)).filter(|(used, _)| **used);
        self.new = kept.map(|(_, at)| at).collect();
        Some(self)
    }
}

impl Value {
    /// With other parameters, or with their values in their places.
    fn with_parameters(&self, of: &dyn Fn(usize) -> Result<usize, f64>) -> Self {
        let changed = |affine: &Affine| affine.with_parameters(of);
        let is = |affine: &Affine, value: f64| affine.terms.is_empty() && affine.constant == value;
        // Factors of one and addends of zero are those of other changes.
        Self {
            factors: self.factors.iter().map(changed).filter(|a| !is(a, 1.0)).collect(),
            addends: self.addends.iter().map(changed).filter(|a| !is(a, 0.0)).collect(),
            rigidity: self.rigidity.as_ref().map(|r| r.with_parameters(of)),
        }
    }
}
