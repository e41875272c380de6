//! From a model file to a [`Model`].

mod beside;
mod frozen;
mod refused;
mod ridden;
mod rigid_mass;

use self::refused::{lacks, only_scalar_on_coordinates};
use super::acting::Acting;
use super::affine::Affine;
use super::assembly::{
    AffineMass, AffinePart, add_basis, add_element, affine_part, number, sparse_system, symmetrise, touched,
};
use super::character::{ModeCharacter, mirror_rows};
use super::connection::Connection;
use super::constraint::{Elimination, eliminate};
use super::critical_preload::CriticalPreload;
use super::dependence::{central_difference, element_matrices, interior_point};
use super::dof_map::DofMap;
use super::each::of_each;
use super::elastic_support::ElasticSupports;
use super::geometry::{Geometry, Vector, minus, plus};
use super::inside::stretch;
use super::mass_properties::MassProperties;
use super::moving::EndMotion;
use super::parameter::ParameterSet;
use super::place::{Placed, left_out_of_effects, place};
use super::placed_element::PlacedElement;
use super::registry::Registry;
use super::spec::{FORMAT, ModelSpec};
use super::system::{SparseSystem, System};
use super::targets::{Targets, targets};
use super::{ElementMatrices, MOST_DENSE_DOFS, ModelError, ParametricModel, PointMotion};
use crate::element::{Dof, ElementInput};
use crate::linalg::DMatrix;
use crate::once::Once;
use crate::yaml::{Problem, Severity, child, version_problem};
use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;

/// A model built from a file.
#[derive(Debug, Clone)]
pub struct Model {
    spec: ModelSpec,
    registry: Registry,
    geometry: Geometry,
    parameters: ParameterSet,
    elements: Vec<PlacedElement>,
    sets: BTreeMap<String, Vec<usize>>,
    dofs: DofMap,
    connections: Vec<Connection>,
    elastic_supports: Option<ElasticSupports>,
    affine: AffinePart,
    rigid_mass: AffineMass,
    /// The terms of its elements; empty where they are very many.
    acting: Arc<[Arc<Acting>]>,
    /// Elements whose matrices are not polynomials of θ.
    general: Vec<usize>,
    damped: bool,
    targets: Targets,
    mirror: Option<Vec<(usize, f64)>>,
    sites: Vec<usize>,
    mesh_parts: Vec<String>,
    patches: Vec<String>,
    n_named: usize,
    modal_damping: Option<Affine>,
    /// How nodes move that parameters move, or what carries them.
    moved: BTreeMap<usize, EndMotion>,
    /// See [`Model::first_straining_lambda`].
    pub(super) first_straining: Once<Option<f64>>,
}

impl Model {
    /// See [`Model::new_beside`].
    fn make(mut spec: ModelSpec, from: (&Registry, Option<&Self>)) -> Result<(Self, Vec<Problem>), Vec<Problem>> {
        let mut problems = Vec::new();
        super::mesh_file::name_nodes(&mut spec);
        problems.extend(version_problem("retune", spec.retune.into(), FORMAT));
        if spec.nodes.is_empty() && spec.superelements.is_empty() && spec.mesh.is_none() {
            problems.push(Problem::error("nodes", "a model needs nodes, or a mesh or superelements that have some"));
        }
        super::mesh_file::check(&spec, &mut problems);
        super::superelement::check(&spec, &mut problems);
        super::configuration::check(&spec, &mut problems);
        let mut placed = place(&spec, from.0, &mut problems);
        let targets = targets(&spec, &mut problems);
        let elimination = eliminate(&spec, &placed.geometry, Elimination::default(), &[], &placed.rows, &mut problems);
        only_scalar_on_coordinates(&spec, &placed, &mut problems);
        // What is wrong in a section is found once for every element of it.
        let mut said = HashSet::new();
        problems.retain(|p| said.insert((p.path.clone(), p.message.clone())));
        if problems.iter().all(|p| p.severity == Severity::Warning) && placed.elements.is_empty() {
            problems.push(Problem::error("", "the model has nodes but no beams, bars, springs or masses"));
        }
        if problems.iter().all(|p| p.severity == Severity::Warning) {
            lacks(&spec, &placed, &elimination, &mut problems);
        }
        if problems.iter().any(|p| p.severity == Severity::Error) {
            return Err(problems);
        }
        if !spec.preloads.is_empty() {
            let before = Self::build(spec.clone(), from, placed.clone(), targets, &elimination, &mut Vec::new());
            if let Ok(model) = before {
                model.preload_statically(&mut placed, &mut problems);
            }
            if problems.iter().any(|p| p.severity == Severity::Error) {
                return Err(problems);
            }
        }
        let built = Self::build(spec, from, placed, targets, &elimination, &mut problems);
        match built.and_then(|m| Ok((m.moves_wrongly()?, m))) {
            Ok((None, model)) => Ok((model, problems)),
            Ok((Some(problem), _)) => {
                problems.push(problem);
                Err(problems)
            }
            Err(e) => {
                let path = match &e {
                    ModelError::Element { path, .. } => path.clone(),
                    _ => String::new(),
                };
                problems.push(Problem::error(path, e));
                Err(problems)
            }
        }
    }

    fn build(
        spec: ModelSpec,
        (registry, beside): (&Registry, Option<&Self>),
        placed: Placed,
        targets: Targets,
        elimination: &Elimination,
        problems: &mut Vec<Problem>,
    ) -> Result<Self, ModelError> {
        let Placed {
            geometry,
            parameters,
            elements,
            sets,
            compliances,
            rows,
            sites,
            mesh_parts,
            patches,
            n_named,
            modal_damping,
            moved,
        } = placed;
        let acting = Acting::of_all(&elements, &parameters, beside)?;
        let touched = touched(&elements, &acting, geometry.names.len());
        let dofs = number(&geometry, &touched, elimination);
        if dofs.n_dof() == 0 {
            problems.push(Problem::warning("", "every dof is supported or inactive: nothing can move"));
        }
        let connections: Vec<Connection> = elements.iter().map(|e| Connection::new(e, &dofs)).collect();
        let elastic_supports = if compliances.is_empty() {
            None
        } else {
            let (n, keeping) = (geometry.names.len(), Elimination::keeping(6 * geometry.names.len()));
            // What is wrong in the file is known already.
            let released = eliminate(&spec, &geometry, keeping, &compliances, &rows, &mut Vec::new());
            ElasticSupports::new(compliances, &released, n, &elements, &connections, &dofs)
        };
        let (affine, rigid_mass) =
            affine_part(&elements, &acting, &connections, &dofs, &geometry.positions, parameters.len());
        let general: Vec<usize> = (0..elements.len()).filter(|&i| acting[i].terms.is_none()).collect();
        let base = interior_point(&parameters);
        let mut damped = affine.bases().any(|b| !b.damping.is_empty());
        for &e in &general {
            let proportional = elements[e].stiffness_damping.is_some() || elements[e].mass_damping.is_some();
            damped |= proportional || !element_matrices(&elements[e], &base)?.damping.is_zero();
        }
        let reflection = mirror_rows(&geometry, &dofs);
        let difference = reflection.as_ref().and_then(|r| r.difference.as_ref());
        problems.extend(difference.map(|text| Problem::warning("symmetry", text)));
        let mirror = match reflection.map(|r| r.rows).transpose() {
            Ok(rows) => rows,
            Err(which) => {
                problems.push(Problem::warning("symmetry", format!("{which}; modes get no symmetry names")));
                None
            }
        };
        Ok(Self {
            spec,
            registry: registry.clone(),
            geometry,
            parameters,
            elements,
            sets,
            dofs,
            connections,
            elastic_supports,
            affine,
            rigid_mass,
            acting: Acting::kept(acting),
            general,
            damped,
            targets,
            mirror,
            sites,
            mesh_parts,
            patches,
            n_named,
            modal_damping,
            moved,
            first_straining: Once::new(),
        })
    }

    /// The file it was built from.
    pub fn spec(&self) -> &ModelSpec {
        &self.spec
    }

    /// The element types that it was built from: what is made of its file later is built from the same.
    pub fn registry(&self) -> &Registry {
        &self.registry
    }

    /// Places of nodes and frames.
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// Its elements.
    pub fn elements(&self) -> &[PlacedElement] {
        &self.elements
    }

    /// Number of nodes that have names: those of the file, then those of superelements; the inner ones of subdivided members come after.
    pub fn n_named_nodes(&self) -> usize {
        self.n_named
    }

    /// What effects leave out of superelements, a sentence each.
    pub fn left_out_of_effects(&self) -> Vec<String> {
        left_out_of_effects(&self.spec)
    }

    /// Whether effects are looked for at a node: one of the file that is not an inner one of a large mesh, or one of those chosen of a mesh or a superelement.
    pub fn is_site(&self, node: usize) -> bool {
        self.sites.binary_search(&node).is_ok()
    }

    /// The set of the mesh that consists of just these nodes.
    pub(crate) fn mesh_set_of(&self, nodes: &[usize]) -> Option<&str> {
        super::mesh_file::set_of(&self.spec, &self.geometry, nodes)
    }

    /// Whether joints are looked for at a node: one with a name, and of a mesh one at which effects are looked for.
    pub(crate) fn can_be_a_joint(&self, node: usize) -> bool {
        node < self.n_named && (self.spec.mesh.is_none() || self.is_site(node))
    }

    /// Names of the sets of a mesh that are not parts of it and have elements.
    pub(crate) fn mesh_sets(&self) -> impl Iterator<Item = &String> {
        let mesh = self.spec.mesh.as_ref().and_then(|m| Some((m, m.loaded.0.as_ref()?)));
        let all = mesh.into_iter().flat_map(|(spec, loaded)| loaded.mesh.sets.iter().map(move |s| (spec, &s.name)));
        all.filter(|(spec, name)| !spec.parts.contains_key(*name) && self.sets.contains_key(*name))
            .map(|(_, name)| name)
    }

    /// Names of the parts of a mesh: of one that was read, or groups of shells and solids where the file lists many.
    pub(crate) fn mesh_parts(&self) -> &[String] {
        &self.mesh_parts
    }

    /// Where the file has a part of a mesh.
    pub(super) fn path_of_part(&self, name: &str) -> String {
        let is_of_mesh = self.spec.mesh.as_ref().is_some_and(|m| m.parts.contains_key(name));
        child(if is_of_mesh { "mesh.parts" } else { "groups" }, name)
    }

    /// Names of the patches into which parts of a mesh are cut for effects.
    pub fn patches(&self) -> &[String] {
        &self.patches
    }

    /// Indices of the elements of a name: an element, a chain, a mass or a group, or a stretch of a subdivided element,
    /// `spar/0.25..0.5`.
    pub fn element_set(&self, name: &str) -> Option<&[usize]> {
        self.sets.get(name).map(Vec::as_slice).or_else(|| stretch(&self.sets, &self.elements, name))
    }

    /// The names of [`Self::element_set`].
    pub fn element_set_names(&self) -> impl Iterator<Item = &str> {
        self.sets.keys().map(String::as_str)
    }

    /// Matrices of one element at θ, in its axes.
    pub fn element_matrices(&self, element: usize, theta: &[f64]) -> Result<ElementMatrices, ModelError> {
        element_matrices(&self.elements[element], theta)
    }

    /// Displacements of one element, in its axes, for given rows q.
    pub fn element_displacements(&self, element: usize, q: &[f64]) -> Vec<f64> {
        let c = &self.connections[element];
        let of = |dof: usize| c.terms(dof).iter().map(|&(j, value)| value * q[c.rows[j as usize]]).sum();
        (0..c.n_dof()).map(of).collect()
    }

    /// How the dofs of one element follow from the rows of K: u_e = B q\[rows\], (6 nodes) x (rows), in its axes.
    pub fn element_motion(&self, element: usize) -> &Connection {
        &self.connections[element]
    }

    /// Whether the matrices of an element are not polynomials of θ, and so not in the affine part.
    pub(super) fn is_general(&self, element: usize) -> bool {
        self.general.binary_search(&element).is_ok()
    }

    pub(super) fn acting(&self) -> &[Arc<Acting>] {
        &self.acting
    }

    pub(super) fn elements_and_connections(&self) -> (&[PlacedElement], &[Connection]) {
        (&self.elements, &self.connections)
    }

    pub(super) fn elastic_supports(&self) -> Option<&ElasticSupports> {
        self.elastic_supports.as_ref()
    }

    pub(super) fn affine_part(&self) -> &AffinePart {
        &self.affine
    }

    /// What supports that give add to the matrices, were these the elements.
    pub(super) fn support_matrices(
        &self,
        elements: &[PlacedElement],
        theta: &[f64],
    ) -> Result<Option<(&Connection, ElementMatrices)>, ModelError> {
        let of = |s: &'_ ElasticSupports| s.matrices(elements, &self.connections, theta);
        self.elastic_supports.as_ref().map(|s| Ok((s.connection(), of(s)?))).transpose()
    }

    fn is_polynomial(&self) -> bool {
        self.general.is_empty() && self.elastic_supports.is_none()
    }

    fn check_dense(&self) -> Result<(), ModelError> {
        let n_dof = self.dofs.n_dof();
        if n_dof > MOST_DENSE_DOFS { Err(ModelError::TooLarge { n_dof, most: MOST_DENSE_DOFS }) } else { Ok(()) }
    }

    /// The matrices of everything that is not a polynomial.
    fn general_matrices(
        &self,
        theta: &[f64],
    ) -> impl Iterator<Item = Result<(&Connection, ElementMatrices), ModelError>> {
        let of_element = |&e: &usize| Ok((&self.connections[e], element_matrices(&self.elements[e], theta)?));
        self.general.iter().map(of_element).chain(self.support_matrices(&self.elements, theta).transpose())
    }

    /// ∂/∂θ_j of the matrices of everything that is not a polynomial and depends on the parameter, by differences.
    fn general_slopes(&self, theta: &[f64], j: usize) -> Result<Vec<(&Connection, ElementMatrices)>, ModelError> {
        let step = self.parameters.difference_step(theta, j);
        let slope = |&e: &usize| -> Result<_, ModelError> {
            let at = |s: f64| {
                let mut theta = theta.to_vec();
                theta[j] += s * step;
                element_matrices(&self.elements[e], &theta)
            };
            let slope = central_difference(at, step, |a, b, width| a.combine(&b, |a, b| (a - b) / width))?;
            Ok((&self.connections[e], slope))
        };
        let moved: Vec<usize> = self.general.iter().copied().filter(|&e| self.elements[e].depends_on(j)).collect();
        let mut slopes = of_each(&moved, slope).into_iter().collect::<Result<Vec<_>, _>>()?;
        if let Some(s) = self.elastic_supports.as_ref().filter(|s| s.depends_on(j)) {
            slopes.push((s.connection(), s.slopes(&self.elements, &self.connections, theta, j, step)?));
        }
        Ok(slopes)
    }

    /// The part of a subdivided element at a fraction of its length, and the fraction of the part: all parts are equal in length.
    fn part_at(&self, element: &str, fraction: f64) -> Option<(usize, f64)> {
        let has_points = |parts: &&[usize]| parts.first().is_some_and(|&e| !self.elements[e].nodes.is_empty());
        let parts = self.element_set(element).filter(has_points)?;
        let at = fraction * parts.len() as f64;
        let part = (at.floor() as usize).min(parts.len() - 1);
        Some((parts[part], at - part as f64))
    }

    fn interpolate(&self, element: usize, fraction: f64, theta: &[f64]) -> Result<PointMotion, ModelError> {
        let e = &self.elements[element];
        let values = e.values_at(theta);
        let failed = |source| ModelError::Element { element: e.name.clone(), path: e.path.clone(), source };
        let stand = e.stand(theta).map_err(failed)?;
        let input = ElementInput { points: &stand.points, values: &values };
        let shape = stand.of_dofs(&e.kind.interpolate(&input, fraction).map_err(failed)?);
        let supports = self.elastic_supports.as_ref();
        let giving =
            supports.map(|s| s.element_motion(element, &self.elements, &self.connections, theta)).transpose()?;
        let giving = giving.flatten();
        let c = giving.as_ref().unwrap_or(&self.connections[element]);
        let b = c.b();
        let mut rows: [Vec<(usize, f64)>; 6] = Default::default();
        for (global, list) in rows.iter_mut().enumerate() {
            for (j, &row) in c.rows.iter().enumerate() {
                // Global component = Σ local component times direction cosine.
                let factor: f64 = (0..3)
                    .map(|local| {
                        let i = local + 3 * (global / 3);
                        let along: f64 = (0..b.nrows()).map(|k| shape[i][k] * b[(k, j)]).sum();
                        stand.axes[local][global % 3] * along
                    })
                    .sum();
                if factor != 0.0 {
                    list.push((row, factor));
                }
            }
        }
        let ends = e.tips_at(&self.geometry.positions, theta);
        let (first, last) = (ends[0], ends[ends.len() - 1]);
        Ok(PointMotion { rows, position: plus(first, fraction, minus(last, first)) })
    }
}

impl Model {
    /// [`ParametricModel::node_at`], where changes move the node too.
    ///
    /// * `further` - what they add to its displacement, see [`EndMotion::at`]
    pub(super) fn node_moved(
        &self,
        node: usize,
        theta: &[f64],
        further: Option<[Vector; 2]>,
    ) -> Result<Option<PointMotion>, ModelError> {
        let supports = self.elastic_supports.as_ref();
        let giving = supports.map(|s| s.node_motion(node, &self.elements, &self.connections, theta)).transpose()?;
        let (giving, own) = (giving.flatten(), self.displaced(node, theta));
        if giving.is_none() && own.is_none() && further.is_none() {
            return Ok(None);
        }
        let all = |dof: Dof| {
            let more = giving.as_ref().map_or(&[][..], |g| &g[dof as usize]);
            [self.dofs.express(node, dof), more].concat()
        };
        let [own, further] = [own, further].map(|d| d.unwrap_or([[0.0; 3]; 2]));
        let displaced = [0, 1].map(|k| plus(own[k], 1.0, further[k]));
        Ok(Some(PointMotion::displaced(Dof::ALL.map(all), self.geometry.positions[node], displaced)))
    }

    /// How far parameters move a node; `None` where they do not.
    pub(super) fn displaced(&self, node: usize, theta: &[f64]) -> Option<[Vector; 2]> {
        self.moved.get(&node).map(|motion| motion.at(theta))
    }
}

impl ParametricModel for Model {
    fn parameters(&self) -> &ParameterSet {
        &self.parameters
    }

    fn dof_map(&self) -> &DofMap {
        &self.dofs
    }

    fn assemble(&self, theta: &[f64]) -> Result<System, ModelError> {
        self.check_dense()?;
        let mut system = System::zeros(self.dofs.n_dof(), self.damped);
        self.assemble_into(theta, &mut system)?;
        Ok(system)
    }

    fn assemble_into(&self, theta: &[f64], system: &mut System) -> Result<(), ModelError> {
        if theta.len() != self.parameters.len() {
            return Err(ModelError::WrongLength { expected: self.parameters.len(), given: theta.len() });
        }
        system.clear();
        for (basis, factor) in self.affine.at(theta) {
            add_basis(system, basis, factor);
        }
        for part in self.general_matrices(theta) {
            let (connection, matrices) = part?;
            add_element(system, connection, &matrices);
        }
        symmetrise(system);
        Ok(())
    }

    fn assemble_sparse(&self, theta: &[f64]) -> Result<SparseSystem, ModelError> {
        if theta.len() != self.parameters.len() {
            return Err(ModelError::WrongLength { expected: self.parameters.len(), given: theta.len() });
        }
        let of_element = |&e: &usize| Ok((&self.connections[e], element_matrices(&self.elements[e], theta)?));
        let general: Vec<Result<_, ModelError>> = of_each(&self.general, of_element);
        let supports = self.support_matrices(&self.elements, theta).transpose();
        let general = general.into_iter().chain(supports).collect::<Result<Vec<_>, _>>()?;
        Ok(sparse_system(self.dofs.n_dof(), self.damped, &self.affine.at(theta).collect::<Vec<_>>(), &general))
    }

    fn assemble_sparse_derivative(&self, theta: &[f64], j: usize) -> Result<SparseSystem, ModelError> {
        let general = self.general_slopes(theta, j)?;
        let bases: Vec<_> = self.affine.derivative(theta, j).collect();
        Ok(sparse_system(self.dofs.n_dof(), self.damped, &bases, &general))
    }

    fn assemble_derivative(&self, theta: &[f64], j: usize) -> Result<System, ModelError> {
        self.check_dense()?;
        let mut system = System::zeros(self.dofs.n_dof(), self.damped);
        for (basis, factor) in self.affine.derivative(theta, j) {
            add_basis(&mut system, basis, factor);
        }
        for (connection, slope) in self.general_slopes(theta, j)? {
            add_element(&mut system, connection, &slope);
        }
        symmetrise(&mut system);
        Ok(system)
    }

    fn mass_properties(&self, theta: &[f64]) -> Result<Option<MassProperties>, ModelError> {
        Ok(MassProperties::of_a_body(&self.rigid_mass(theta)?))
    }

    fn mass_properties_beside(&self, theta: &[f64], others: &[(usize, f64)]) -> Vec<Option<MassProperties>> {
        let of = |rigid: Option<_>| MassProperties::of_a_body(&rigid?);
        self.rigid_masses_beside(theta, others).into_iter().map(of).collect()
    }

    fn point(&self, element: &str, fraction: f64) -> Result<Option<PointMotion>, ModelError> {
        let theta = interior_point(&self.parameters);
        self.part_at(element, fraction).map(|(part, within)| self.interpolate(part, within, &theta)).transpose()
    }

    fn point_at(&self, element: &str, fraction: f64, theta: &[f64]) -> Result<Option<PointMotion>, ModelError> {
        let gives = |part: usize| self.elastic_supports.as_ref().is_some_and(|s| s.moves(part));
        let part = self.part_at(element, fraction).filter(|(part, _)| self.general.contains(part) || gives(*part));
        part.map(|(part, within)| self.interpolate(part, within, theta)).transpose()
    }

    fn has_point_moved_by(&self, element: &str, fraction: f64, j: usize) -> bool {
        self.elastic_supports.as_ref().is_some_and(|s| s.depends_on(j))
            || self.part_at(element, fraction).is_none_or(|(part, _)| self.elements[part].depends_on(j))
    }

    fn point_near(&self, element: &str, place: [f64; 3]) -> Result<Option<PointMotion>, ModelError> {
        self.point_within(element, place)
    }

    fn node_at(&self, node: usize, theta: &[f64]) -> Result<Option<PointMotion>, ModelError> {
        self.node_moved(node, theta, None)
    }

    fn has_nodes_moved_by(&self, j: usize) -> bool {
        self.elastic_supports.as_ref().is_some_and(|s| s.depends_on(j))
            || self.moved.values().any(|motion| motion.depends_on(&[j]))
    }

    fn element_names(&self) -> Vec<&str> {
        let has_points = |set: &&Vec<usize>| set.iter().all(|&e| self.elements[e].matrices.is_none());
        self.sets.iter().filter(|(_, set)| has_points(set)).map(|(name, _)| name.as_str()).collect()
    }

    fn modal_damping(&self) -> Option<&Affine> {
        self.modal_damping.as_ref()
    }

    fn critical_preload(&self, theta: &[f64]) -> Result<Option<CriticalPreload>, ModelError> {
        self.critical_preload_at(theta)
    }

    fn mirror(&self) -> Option<&[(usize, f64)]> {
        self.mirror.as_deref()
    }

    fn characters(
        &self,
        theta: &[f64],
        shapes: &DMatrix<f64>,
        n_rigid: usize,
    ) -> Result<Option<Vec<ModeCharacter>>, ModelError> {
        self.characters_at(theta, shapes, n_rigid).map(Some)
    }

    fn of_file(&self) -> Option<&Model> {
        Some(self)
    }

    fn targets(&self) -> Targets {
        self.targets
    }

    fn has_mass_of(&self, j: usize) -> bool {
        self.rigid_mass.depends_on(&self.affine, j) || self.general.iter().any(|&e| self.elements[e].depends_on(j))
    }

    fn affine_mass(&self) -> Option<&AffineMass> {
        self.is_polynomial().then_some(&self.rigid_mass)
    }

    fn affine(&self) -> Option<&AffinePart> {
        self.is_polynomial().then_some(&self.affine)
    }
}
