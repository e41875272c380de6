//! A large model with changes, on few coordinates: what a diagnosis fits in its place.
//!
//! ```text
//! q ≈ V y + W z,    K_r(θ, s) = [V W]ᵀ (K(θ) + Σ_e B_eᵀ Δk_e(θ, s) B_e) [V W],    M_r and C_r alike
//! ```
//!
//! V is the basis of a [`ReducedModel`]: rigid motions, modes and their derivatives, within the bounds of the parameters. W are static shapes
//! X⁻¹ F, X = K + aM, under the forces F that the change can exert: the range of its matrices where its elements touch few dofs, else what they
//! exert on the modes. So a change of any size is represented exactly in statics, and its resonances through V. Coordinates that a change brings
//! (a body on a spring) are coordinates here too.

mod at_one_point;
mod forces;
mod seen;
mod sum;
mod symmetry;

use self::forces::{FEW_ROWS, NEGLIGIBLE};
use self::sum::{Motion, Projection, Sum, Summed, add, of_system, rigid};
use self::symmetry::Forms;
use super::affine::Affine;
use super::assembly::{AffineMass, AffinePart, Basis, add_basis, symmetrise};
use super::change::{Change, OnRows};
use super::character::ModeCharacter;
use super::dependence::{Monomial, Terms, hold, interior_point};
use super::dof_map::DofMap;
use super::entry::Entry;
use super::mass_properties::MassProperties;
use super::parameter::{Parameter, ParameterSet};
use super::reduced::{Asked, ReducedModel, ReducedOptions};
use super::system::System;
use super::{ElementMatrices, Model, ModelError, ParametricModel, PointMotion, Targets};
use crate::element::Dof;
use crate::linalg::sparse::{PencilFactor, SparsePlan, SparseSym};
use crate::linalg::{DMatrix, symmetric_eigen, tall_take, tall_tr_mul};
use crate::modal::ModalError;
use crate::once::Once;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

/// Of the energy of a static shape, what V and the shapes before leave below this part is rounding: they hold it.
const ROUNDING: f64 = 1e-12;

/// The matrices of one term of a model.
#[derive(Debug)]
struct Term {
    stiffness: Option<SparseSym>,
    mass: Option<SparseSym>,
    damping: Option<SparseSym>,
}

/// What all stand-ins of one model share.
#[derive(Debug)]
struct Common {
    model: Arc<Model>,
    /// The θ at which it is made: the estimates, and the values that are held.
    theta: Vec<f64>,
    /// V, (n_dof x n_basis), orthonormal in X.
    basis: DMatrix<f64>,
    /// In the order of [`AffinePart::bases`].
    terms: Vec<Term>,
    /// M of what is not a polynomial, at θ.
    frozen_mass: Option<SparseSym>,
    /// Rᵀ M R of the rigid motions in the terms of `affine`.
    masses: AffineMass,
    affine: AffinePart,
    factor: Arc<PencilFactor>,
    shift: f64,
    /// Coordinates of the rigid motions, (n_basis x 6), and how many of the first coordinates they take.
    motions: DMatrix<f64>,
    n_rigid: usize,
    /// The rigid vectors of the basis as sums of the six motions, (6 x n_rigid).
    rigid_parts: DMatrix<f64>,
    is_damped: bool,
    symmetry: Once<Forms>,
}

/// A change, and where its sizes stand behind the parameters of the model.
#[derive(Debug, Clone)]
struct Placed {
    change: Arc<Change>,
    first_size: usize,
    /// Scales of its new coordinates, and where those begin among all new ones.
    scales: Vec<f64>,
    first_new: usize,
}

/// Elements of a change whose matrices are not polynomials, on the coordinates.
#[derive(Debug, Clone)]
struct General {
    /// Number of the change, and those of the elements in it.
    change: usize,
    parts: Vec<usize>,
    /// Rows and new coordinates that they hang on, ascending, and how these move with the coordinates.
    rows: Vec<usize>,
    motion: Motion,
}

/// A large model on few coordinates, with changes.
#[derive(Debug, Clone)]
pub struct StandIn {
    common: Arc<Common>,
    parameters: ParameterSet,
    changes: Vec<Placed>,
    /// W, (n_dof x n_extra).
    extra: Arc<DMatrix<f64>>,
    /// Coordinates of changes that are not combinations of dofs.
    n_new: usize,
    affine: AffinePart,
    /// Rᵀ M R of the rigid motions in the terms of `affine`, and the parts of changes that are not in it: (change, part).
    rigid_mass: AffineMass,
    not_in_rigid_mass: Vec<(usize, usize)>,
    general: Vec<General>,
    /// Whether the model or a change has dashpots.
    is_damped: bool,
    dofs: DofMap,
    symmetry: Once<Forms>,
}

impl StandIn {
    /// Of a model as it is, reduced as `options` say.
    ///
    /// * `like` - what stands in for a model that is nearly this one: its coordinates are taken where they serve
    /// * `held` - values of parameters, by name, near which it is to be right; it is for all values of the others
    /// * `loads` - to which it shall answer beside its modes, (n_dof x any number)
    ///
    /// # Errors
    /// Those of a solution of the model.
    pub fn reduced(
        model: &Arc<Model>,
        options: ReducedOptions,
        like: Option<&Self>,
        held: &[(String, f64)],
        loads: Option<&DMatrix<f64>>,
    ) -> Result<Self, ModelError> {
        let known = like.map(|like| like.on_rows_of(model));
        let mut theta = interior_point(model.parameters());
        hold(model.parameters(), held, &mut theta);
        // What is not a polynomial is frozen for the basis, and stands beside it as a change.
        let frozen = match model.affine() {
            Some(_) => None,
            None => Some(model.frozen_at(&theta)?),
        };
        let solved = frozen.as_ref().unwrap_or(model);
        let reduced = ReducedModel::near(solved, options, &Asked { known: known.as_ref(), held, loads })?;
        let mut affine = reduced.affine().cloned().ok_or(ModelError::NotPolynomial)?;
        let full = solved.affine().ok_or(ModelError::NotPolynomial)?;
        let n = model.dof_map().n_dof();
        let matrix = |list: &[Entry]| {
            let entries = list.iter().map(Entry::triplet);
            (!list.is_empty()).then(|| SparseSym::from_triplets(n, entries))
        };
        let term =
            |b: &Basis| Term { stiffness: matrix(&b.stiffness), mass: matrix(&b.mass), damping: matrix(&b.damping) };
        let mut terms: Vec<Term> = full.bases().map(term).collect();
        let is_damped = terms.iter().any(|t| t.damping.is_some());
        let mut frozen_mass = None;
        if frozen.is_some() {
            frozen_mass = terms.pop().and_then(|t| t.mass);
            affine.products.pop();
        }
        let shift = reduced.shift();
        let mut basis = reduced.basis().clone();
        let (n_rigid, motions, rigid_parts) = rigid(model, &basis, &reduced.dof_map().rigid_motions());
        // Rigid to the last digit, so that a change that strains some motions leaves the others free.
        let exact = model.dof_map().rigid_motions() * &rigid_parts;
        basis.columns_mut(0, n_rigid).copy_from(&exact);
        let dofs = DofMap::of_coordinates(reduced.basis().ncols(), &motions);
        let common = Common {
            model: model.clone(),
            theta,
            basis,
            is_damped,
            terms,
            frozen_mass,
            masses: model.affine_mass_part().clone(),
            affine: affine.clone(),
            factor: reduced.factor().clone(),
            shift,
            n_rigid,
            rigid_parts,
            motions,
            symmetry: Once::new(),
        };
        let bare = Self {
            common: Arc::new(common),
            parameters: model.parameters().clone(),
            changes: Vec::new(),
            extra: Arc::new(DMatrix::zeros(n, 0)),
            n_new: 0,
            affine,
            rigid_mass: model.affine_mass_part().clone(),
            not_in_rigid_mass: Vec::new(),
            general: Vec::new(),
            is_damped,
            dofs,
            symmetry: Once::new(),
        };
        if frozen.is_none() {
            return Ok(bare);
        }
        bare.with(&Arc::new(Change::of_general(model)), &[], &[])
    }

    /// Whether the static shapes of its last change are those of all forces that it can exert: exact in statics at any size.
    pub fn is_exact_in_statics(&self) -> bool {
        self.changes.last().is_none_or(|placed| placed.change.rows().len() <= FEW_ROWS)
    }

    /// The model that it stands for, without the changes.
    pub fn model(&self) -> &Arc<Model> {
        &self.common.model
    }

    /// a of X = K + aM, in which the basis is orthonormal.
    pub fn shift(&self) -> f64 {
        self.common.shift
    }

    /// The first so many coordinates are rigid-body motions.
    pub fn n_rigid(&self) -> usize {
        self.common.n_rigid
    }

    /// The elimination order of the model.
    pub fn plan(&self) -> &SparsePlan {
        self.common.factor.plan()
    }

    /// What the rows of another model move by with its coordinates; nothing of rows that its own model does not have.
    fn on_rows_of(&self, model: &Model) -> DMatrix<f64> {
        let (own, other) = (self.common.model.dof_map(), model.dof_map());
        let known: HashMap<(&str, Dof), usize> = own
            .rows()
            .iter()
            .enumerate()
            .map(|(i, &(node, dof))| ((own.node_names()[node].as_str(), dof), i))
            .collect();
        let row = |&(node, dof): &(usize, Dof)| known.get(&(other.node_names()[node].as_str(), dof)).copied();
        let rows: Vec<Option<usize>> = other.rows().iter().map(row).collect();
        let count = self.common.basis.ncols() + self.extra.ncols();
        DMatrix::from_fn(rows.len(), count, |i, c| rows[i].map_or(0.0, |row| self.entry(row, c)))
    }

    /// With one more change, whose sizes follow the parameters.
    ///
    /// * `sizes` - the parameters that the change brings
    /// * `typical` - sizes of an order that is expected
    ///
    /// # Errors
    /// An element of the change has no matrices at these sizes.
    pub fn with(&self, change: &Arc<Change>, sizes: &[Parameter], typical: &[f64]) -> Result<Self, ModelError> {
        let (forces, scales) = self.forces(&change.at(&self.common.theta, typical)?);
        // W across V and the shapes that are there, orthonormal in X: X W = F.
        let mut shapes = self.common.factor.solve(&forces);
        let whole = (0..forces.ncols()).map(|j| shapes.column(j).dot(&forces.column(j))).fold(0.0, f64::max);
        for known in [&self.common.basis, &*self.extra] {
            tall_take(&mut shapes, known, &tall_tr_mul(known, &forces));
        }
        let gram = tall_tr_mul(&shapes, &forces);
        let gram = (&gram + gram.transpose()) * 0.5;
        let largest = gram.diagonal().amax();
        let eigen = symmetric_eigen(&gram).map_err(ModalError::from)?;
        // More directions than the model has would depend on each other.
        let room = self.extra.nrows().saturating_sub(self.common.basis.ncols() + self.extra.ncols());
        let least = (NEGLIGIBLE * largest).max(ROUNDING * whole);
        let mut kept: Vec<usize> = (0..eigen.values.len()).filter(|&k| eigen.values[k] > least).collect();
        kept.sort_by(|&a, &b| eigen.values[b].total_cmp(&eigen.values[a]));
        kept.truncate(room);
        kept.sort_unstable();
        let mut turned = eigen.vectors.select_columns(&kept);
        turned.column_iter_mut().zip(&kept).for_each(|(mut c, &k)| c /= eigen.values[k].sqrt());
        let first = self.extra.ncols();
        let mut extra = (*self.extra).clone().resize_horizontally(first + kept.len(), 0.0);
        extra.columns_mut(first, kept.len()).copy_from(&(shapes * turned));
        let mut out = self.clone();
        out.parameters = ParameterSet::new(self.parameters.iter().cloned().chain(sizes.iter().cloned()).collect());
        let m = self.common.basis.ncols();
        let size = m + extra.ncols() + self.n_new + change.n_new();
        out.extra = Arc::new(extra);
        out.symmetry = Once::new();
        out.n_new = self.n_new + change.n_new();
        let first_size = self.parameters.len() - self.common.model.parameters().len();
        out.changes.push(Placed { change: change.clone(), first_size, scales, first_new: self.n_new });
        let mut rigid = DMatrix::zeros(size, 6);
        rigid.rows_mut(0, m).copy_from(&self.common.motions);
        out.dofs = DofMap::of_coordinates(size, &rigid);
        out.project();
        Ok(out)
    }

    /// How rows of the model, and behind them new coordinates of a change, move with the coordinates.
    fn motion(&self, placed: &Placed, rows: &[usize]) -> DMatrix<f64> {
        let n = self.common.basis.nrows();
        let first_new = self.common.basis.ncols() + self.extra.ncols() + placed.first_new;
        // A new coordinate counts from where the rigid motions take it.
        let rigid = |new: usize, c: usize| -> f64 {
            let motions = placed.change.rigid_motions(new);
            (0..6).map(|k| motions[k] * self.common.rigid_parts[(k, c)]).sum()
        };
        DMatrix::from_fn(rows.len(), self.dofs.n_dof(), |i, c| match rows[i].checked_sub(n) {
            Some(new) if c == first_new + new => placed.scales[new],
            Some(new) if c < self.common.n_rigid => rigid(new, c),
            None => self.entry(rows[i], c),
            _ => 0.0,
        })
    }

    /// How much a row of the model moves with a coordinate: an entry of \[V W 0\].
    fn entry(&self, row: usize, coordinate: usize) -> f64 {
        let m = self.common.basis.ncols();
        if coordinate < m {
            self.common.basis[(row, coordinate)]
        } else if coordinate < m + self.extra.ncols() {
            self.extra[(row, coordinate - m)]
        } else {
            0.0
        }
    }

    /// The matrices of a superelement on the coordinates.
    fn on_coordinates(&self, of: &OnRows) -> ElementMatrices {
        let rows = of.rows();
        let motion = DMatrix::from_fn(rows.len(), self.dofs.n_dof(), |i, c| self.entry(rows[i], c));
        of.on_basis(&motion, self.common.n_rigid)
    }

    /// Finds the terms of the model and of its changes on all coordinates.
    fn project(&mut self) {
        let size = self.dofs.n_dof();
        let own = self.common.model.parameters().len();
        let mut sum = Sum::new(size, self.parameters.len());
        let masses = &self.common.masses;
        let terms = self.common.affine.bases().zip(&self.common.terms);
        let mut grown = terms.zip(masses.linear.iter().chain(&masses.products));
        let mut next = |into: &mut Summed| {
            if let Some(((basis, term), rigid)) = grown.next() {
                into.matrices.iter_mut().zip(self.grown(basis, term)).for_each(|(a, b)| *a += b);
                into.rigid.add_scaled(1.0, rigid);
            }
        };
        next(&mut sum.constant);
        (0..own).for_each(|j| next(sum.parameter(j)));
        for (monomial, _) in &self.common.affine.products {
            next(sum.product(monomial));
        }
        let (mut general, mut not_in_rigid_mass) = (Vec::new(), Vec::new());
        for (k, placed) in self.changes.iter().enumerate() {
            let first = own + placed.first_size;
            let sizes = self.parameters.iter().skip(first).take(placed.change.n_sizes());
            let parameters = self.common.model.parameters().iter().chain(sizes).cloned().collect();
            let parameters = ParameterSet::new(parameters);
            let rows = placed.change.rows();
            let motion = Motion::new(self.motion(placed, &rows));
            let n_rigid = self.common.n_rigid;
            let mut parts = Vec::new();
            let mut found: BTreeMap<Monomial, Projection<'_>> = BTreeMap::new();
            let take = |part: usize, terms: Option<Terms>| {
                if terms.is_none() {
                    parts.push(part);
                }
                if terms.is_none() || placed.change.motion(part).is_none() {
                    not_in_rigid_mass.push((k, part));
                }
                let at = |j: usize| if j < own { j } else { j + placed.first_size };
                for (monomial, matrices) in terms.into_iter().flatten() {
                    let powers = monomial.powers.iter().map(|&(j, p)| (at(j), p)).collect();
                    let monomial = Monomial { powers };
                    // An element that parameters move has no terms.
                    placed.change.add_rigid_mass_of(part, &[], matrices.weighed(), &mut sum.term(&monomial).rigid);
                    match placed.change.motion(part) {
                        Some(connection) => {
                            let new = || Projection::new(&rows, &motion, n_rigid);
                            found.entry(monomial).or_insert_with(new).take(connection, &matrices);
                        }
                        // Matrices of a superelement are on the coordinates already.
                        None => add(sum.term(&monomial), &matrices),
                    }
                }
            };
            placed.change.each_terms(&parameters, |of| self.on_coordinates(of), take);
            for (monomial, projection) in found {
                projection.add_to(sum.term(&monomial).matrices.each_mut().map(Some));
            }
            if !parts.is_empty() {
                general.push(General { change: k, parts, rows, motion });
            }
        }
        (self.affine, self.rigid_mass) = sum.into_affine();
        (self.general, self.not_in_rigid_mass) = (general, not_in_rigid_mass);
        let damps = |g: &General| {
            let placed = &self.changes[g.change];
            let typical = vec![1.0; placed.change.n_sizes()];
            let of = |&part: &usize| placed.change.matrices(part, &self.common.theta, &typical);
            g.parts.iter().any(|part| of(part).is_ok_and(|m| !m.damping.is_zero()))
        };
        let has_dashpots = self.affine.bases().any(|b| !b.damping.is_empty());
        self.is_damped = self.common.is_damped || has_dashpots || self.general.iter().any(damps);
    }

    /// A term of the model on all coordinates: K, M, C.
    fn grown(&self, basis: &Basis, term: &Term) -> [DMatrix<f64>; 3] {
        let (v, w, size) = (&self.common.basis, &*self.extra, self.dofs.n_dof());
        let (m, n_rigid) = (v.ncols(), self.common.n_rigid);
        let of = |list: &[Entry], a: &Option<SparseSym>, strains: bool| {
            let mut out = DMatrix::zeros(size, size);
            for e in list {
                out[e.place()] = e.value;
            }
            let Some(a) = a else { return out };
            let aw = a.mul(w);
            let mut beside = tall_tr_mul(&aw, v);
            // A rigid motion that the term does not strain meets no force of a shape either.
            for j in (0..n_rigid)
                .filter(|&j| strains && !list.iter().map(Entry::place).any(|(row, column)| row == j || column == j))
            {
                beside.column_mut(j).fill(0.0);
            }
            out.view_mut((m, 0), (w.ncols(), m)).copy_from(&beside);
            out.view_mut((m, m), (w.ncols(), w.ncols())).copy_from(&tall_tr_mul(w, &aw));
            out
        };
        [
            of(&basis.stiffness, &term.stiffness, true),
            of(&basis.mass, &term.mass, false),
            of(&basis.damping, &term.damping, true),
        ]
    }

    /// Motions of the model from those of its coordinates, (n_dof x any number).
    pub fn expanded(&self, y: &DMatrix<f64>) -> DMatrix<f64> {
        let (m, extra) = (self.common.basis.ncols(), self.extra.ncols());
        &self.common.basis * y.rows(0, m) + &*self.extra * y.rows(m, extra)
    }

    /// M of the model at the θ at which this is made, without the changes, times motions of the coordinates, (n_dof x any number).
    pub fn mass_times(&self, y: &DMatrix<f64>) -> DMatrix<f64> {
        let x = self.expanded(y);
        let factors = self.common.affine.at(&self.common.theta).map(|(_, factor)| factor);
        let terms = self.common.terms.iter().map(|t| t.mass.as_ref()).zip(factors);
        let all = terms.chain([(self.common.frozen_mass.as_ref(), 1.0)]);
        let mut sum = DMatrix::zeros(x.nrows(), x.ncols());
        all.filter_map(|(mass, factor)| Some(mass?.mul(&x) * factor)).for_each(|part| sum += part);
        sum
    }

    /// Adds the matrices of elements that are not polynomials; `None` of those that have no part in it.
    fn add_general(
        &self,
        g: &General,
        system: &mut System,
        matrices: impl Fn(usize) -> Result<Option<ElementMatrices>, ModelError>,
    ) -> Result<(), ModelError> {
        let mut projection = Projection::new(&g.rows, &g.motion, self.common.n_rigid);
        for &part in &g.parts {
            // A superelement is a polynomial.
            let Some(connection) = self.changes[g.change].change.motion(part) else { continue };
            if let Some(matrices) = matrices(part)? {
                projection.take(connection, &matrices);
            }
        }
        projection.add_to(of_system(system));
        Ok(())
    }

    fn of_model<'a>(&self, theta: &'a [f64]) -> (&'a [f64], &'a [f64]) {
        theta.split_at(self.common.model.parameters().len())
    }

    fn check(&self, theta: &[f64]) -> Result<(), ModelError> {
        let expected = self.parameters.len();
        if theta.len() == expected { Ok(()) } else { Err(ModelError::WrongLength { expected, given: theta.len() }) }
    }
}

impl ParametricModel for StandIn {
    fn parameters(&self) -> &ParameterSet {
        &self.parameters
    }

    fn dof_map(&self) -> &DofMap {
        &self.dofs
    }

    fn assemble(&self, theta: &[f64]) -> Result<System, ModelError> {
        let mut system = System::zeros(self.dofs.n_dof(), self.is_damped);
        self.assemble_into(theta, &mut system)?;
        Ok(system)
    }

    fn assemble_into(&self, theta: &[f64], system: &mut System) -> Result<(), ModelError> {
        self.check(theta)?;
        let (own, sizes) = self.of_model(theta);
        system.clear();
        for (basis, factor) in self.affine.at(theta) {
            add_basis(system, basis, factor);
        }
        for g in &self.general {
            let placed = &self.changes[g.change];
            let sizes = &sizes[placed.first_size..placed.first_size + placed.change.n_sizes()];
            self.add_general(g, system, |part| placed.change.matrices(part, own, sizes).map(Some))?;
        }
        symmetrise(system);
        Ok(())
    }

    fn assemble_derivative(&self, theta: &[f64], j: usize) -> Result<System, ModelError> {
        self.check(theta)?;
        let (own, sizes) = self.of_model(theta);
        let mut system = System::zeros(self.dofs.n_dof(), self.is_damped);
        for (basis, factor) in self.affine.derivative(theta, j) {
            add_basis(&mut system, basis, factor);
        }
        let step = self.parameters.difference_step(theta, j);
        for g in &self.general {
            let placed = &self.changes[g.change];
            let (first, count) = (placed.first_size, placed.change.n_sizes());
            let local = match j.checked_sub(own.len()) {
                None => j,
                Some(k) if (first..first + count).contains(&k) => own.len() + k - first,
                Some(_) => continue,
            };
            let sizes = &sizes[first..first + count];
            let slope = |part: usize| placed.change.slopes(part, own, sizes, local, step);
            let of = |part| placed.change.depends_on(part, local).then(|| slope(part)).transpose();
            self.add_general(g, &mut system, of)?;
        }
        symmetrise(&mut system);
        Ok(system)
    }

    fn mass_properties(&self, theta: &[f64]) -> Result<Option<MassProperties>, ModelError> {
        self.check(theta)?;
        let (own, sizes) = self.of_model(theta);
        let mut rigid = self.rigid_mass.at(&self.affine, theta);
        for &(change, part) in &self.not_in_rigid_mass {
            let placed = &self.changes[change];
            let sizes = &sizes[placed.first_size..placed.first_size + placed.change.n_sizes()];
            placed.change.add_rigid_mass_at(part, &mut rigid, own, sizes)?;
        }
        Ok(MassProperties::of_a_body(&rigid))
    }

    fn characters(
        &self,
        theta: &[f64],
        shapes: &DMatrix<f64>,
        n_rigid: usize,
    ) -> Result<Option<Vec<ModeCharacter>>, ModelError> {
        self.check(theta)?;
        self.common.model.characters(self.of_model(theta).0, &self.expanded(shapes), n_rigid)
    }

    fn point(&self, element: &str, fraction: f64) -> Result<Option<PointMotion>, ModelError> {
        self.common.model.point(element, fraction)
    }

    fn point_at(&self, element: &str, fraction: f64, theta: &[f64]) -> Result<Option<PointMotion>, ModelError> {
        self.common.model.point_at(element, fraction, self.of_model(theta).0)
    }

    fn point_near(&self, element: &str, place: [f64; 3]) -> Result<Option<PointMotion>, ModelError> {
        self.common.model.point_near(element, place)
    }

    fn node_at(&self, node: usize, theta: &[f64]) -> Result<Option<PointMotion>, ModelError> {
        self.node_on_rows(node, theta)
    }

    fn element_names(&self) -> Vec<&str> {
        self.common.model.element_names()
    }

    fn modal_damping(&self) -> Option<&Affine> {
        self.common.model.modal_damping()
    }

    fn stand_in(&self) -> Option<&StandIn> {
        Some(self)
    }

    fn targets(&self) -> Targets {
        self.common.model.targets()
    }

    fn has_mass_of(&self, j: usize) -> bool {
        !self.not_in_rigid_mass.is_empty() || self.rigid_mass.depends_on(&self.affine, j)
    }

    fn affine_mass(&self) -> Option<&AffineMass> {
        self.not_in_rigid_mass.is_empty().then_some(&self.rigid_mass)
    }

    fn affine(&self) -> Option<&AffinePart> {
        self.general.is_empty().then_some(&self.affine)
    }
}
