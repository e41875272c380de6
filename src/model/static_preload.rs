//! Preloads of elements from static loads: the geometric stiffness of gravity, of spin and of forces.
//!
//! ```text
//! K u = f(gravity, spin, forces)       preload of each element = its mean force, force by width or stress under u, times `factor`
//! ```
//!
//! A structure that spins also has -Ω² M⊥ beside its stiffness, M⊥ the mass along directions across the axis: the load follows the motion.
//! u is that of the structure without preload (first order), at the estimates of the parameters.
//!
//! # Source
//! R. D. Cook, D. S. Malkus, M. E. Plesha, R. J. Witt, Concepts and Applications of Finite Element Analysis, 4th ed. (2002), chapter 18; for spin,
//! W. Carnegie, Vibrations of rotating cantilever blading, J. Mech. Engng Sci. 1 (1959) 235-240.

use super::compile::Model;
use super::dependence::{interior_point, weighed_mass};
use super::geometry::{GLOBAL, Vector, constant, dot, minus, unit, unknown, vector};
use super::place::{Placed, parameters};
use super::placed_element::PlacedElement;
use super::placed_matrices::{PlacedDof, PlacedMatrices};
use super::solver::plan;
use super::spec::{ModelSpec, SpinSpec, StaticPreloadSpec};
use super::value::{Affine, Value};
use super::{ModelError, ParametricModel};
use crate::element::{Dof, ElementInput};
use crate::linalg::sparse::solve_shifted;
use crate::linalg::{DMatrix, SymMatrix};
use crate::matrices::{Entry, Symmetric};
use crate::units::Scalar;
use crate::yaml::{Problem, child};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::Arc;

/// A spin, in numbers.
struct Spin {
    /// rad/s
    speed: f64,
    axis: Vector,
    through: Vector,
}

impl Spin {
    fn read(spec: &SpinSpec, path: &str, problems: &mut Vec<Problem>) -> Option<Self> {
        let speed = constant(&spec.speed, "Hz", &child(path, "speed"), problems);
        let Some(axis) = unit(spec.axis) else {
            let text = "it must be a direction: three finite numbers, not all zero";
            problems.push(Problem::error(child(path, "axis"), text));
            return None;
        };
        let through = match &spec.through {
            Some(at) => vector(at, "m", &child(path, "through"), problems),
            None => [0.0; 3],
        };
        through.iter().all(|v| v.is_finite()).then_some(Self { speed: TAU * speed, axis, through })
    }

    /// What is across the axis of a vector.
    fn across(&self, v: Vector) -> Vector {
        let along = dot(v, self.axis);
        std::array::from_fn(|i| v[i] - along * self.axis[i])
    }
}

/// A load in numbers.
struct Load {
    path: String,
    gravity: Vector,
    spin: Option<Spin>,
    /// Node, force and moment.
    forces: Vec<(usize, [f64; 6])>,
    factor: Affine,
}

impl Load {
    fn read(
        name: &str,
        spec: &StaticPreloadSpec,
        placed: &Placed,
        file: &ModelSpec,
        problems: &mut Vec<Problem>,
    ) -> Option<Self> {
        let path = child("preloads", name);
        let before = problems.len();
        if spec.gravity.is_none() && spec.spin.is_none() && spec.forces.is_empty() {
            problems.push(Problem::error(&path, "it has no load: give `gravity`, `spin` or `forces`"));
        }
        let gravity = match &spec.gravity {
            Some(g) => vector(g, "m/s2", &child(&path, "gravity"), problems),
            None => [0.0; 3],
        };
        let spin = spec.spin.as_ref().and_then(|s| Spin::read(s, &child(&path, "spin"), problems));
        let mut forces = Vec::new();
        for (name, f) in &spec.forces {
            let path = format!("{path}.forces.{name}");
            if f.force.is_none() && f.moment.is_none() {
                problems.push(Problem::error(&path, "give its `force`, its `moment`, or both"));
            }
            if f.nodes.is_empty() {
                problems.push(Problem::error(child(&path, "nodes"), "a force needs the nodes on which it acts"));
            }
            let mut of = |v: &Option<[Scalar; 3]>, unit: &str, key: &str| match v {
                Some(v) => vector(v, unit, &child(&path, key), problems),
                None => [0.0; 3],
            };
            let (force, moment) = (of(&f.force, "N", "force"), of(&f.moment, "N m", "moment"));
            let share = 1.0 / f.nodes.len().max(1) as f64;
            for node in &f.nodes {
                match placed.geometry.node(node) {
                    Some(n) => {
                        let part = |i: usize| share * if i < 3 { force[i] } else { moment[i - 3] };
                        forces.push((n, std::array::from_fn(part)));
                    }
                    None => problems.push(unknown(&child(&path, "nodes"), "node", node, &placed.geometry.names)),
                }
            }
        }
        let factor = match &spec.factor {
            Some(scalar) => factor(scalar, file, placed, &child(&path, "factor"), problems),
            None => Some(Affine::constant(1.0)),
        };
        let factor = factor?;
        (problems.len() == before).then_some(Self { path, gravity, spin, forces, factor })
    }
}

/// A number, or a sum of parameters.
fn factor(
    scalar: &Scalar,
    file: &ModelSpec,
    placed: &Placed,
    path: &str,
    problems: &mut Vec<Problem>,
) -> Option<Affine> {
    // What is wrong with parameters is known already.
    let (_, dimensions) = parameters(file, &mut Vec::new());
    let (constant, named) = match scalar.affine_in("1", &|name| dimensions.get(name).copied()) {
        Ok(found) => found,
        Err(e) => {
            problems.push(Problem::error(path, e));
            return None;
        }
    };
    let mut terms = Vec::new();
    for (name, times) in named {
        let Some(i) = placed.parameters.index_of(&name) else {
            problems.push(unknown(path, "parameter", &name, file.parameters.keys()));
            return None;
        };
        terms.push((i, times));
    }
    Some(Affine { constant, terms })
}

impl Model {
    /// Puts the preloads of the static loads of the file into elements; this is the model without them.
    ///
    /// * `placed` - what it was built from
    pub(super) fn preload_statically(&self, placed: &mut Placed, problems: &mut Vec<Problem>) {
        for (name, entry) in &self.spec().preloads {
            let Some(load) = Load::read(name, entry, placed, self.spec(), problems) else { continue };
            match apply(self, &load) {
                Ok((values, softening)) => {
                    for (element, property, value) in values {
                        add(&mut placed.elements[element], property, value, &load.factor);
                    }
                    placed.elements.extend(softening);
                }
                Err(text) => problems.push(Problem::error(&load.path, text)),
            }
        }
    }
}

/// Adds a preload to a property of an element.
fn add(e: &mut PlacedElement, property: usize, value: f64, factor: &Affine) {
    let more = Affine {
        constant: factor.constant * value,
        terms: factor.terms.iter().map(|(i, f)| (*i, f * value)).collect(),
    };
    let values = Arc::make_mut(&mut e.values);
    match &mut values[property] {
        Some(known) => known.addends.push(more),
        none => *none = Some(Value::of(more)),
    }
}

/// Preloads as (element, property, value), and what softens a structure that spins.
type Found = (Vec<(usize, usize, f64)>, Option<PlacedElement>);

fn apply(model: &Model, load: &Load) -> Result<Found, String> {
    if load.spin.is_some() && model.elements().iter().any(|e| e.matrices.as_ref().is_some_and(|m| m.m.is_some())) {
        return Err("how the mass of superelements is spread is not known: a spin has no load on them".into());
    }
    if model.elastic_supports().is_some() {
        return Err("supports that give hold this structure; for a static preload put `springs` in their places".into());
    }
    let theta = interior_point(model.parameters());
    let failed = |e: ModelError| e.to_string();
    let f = forces(model, load, &theta).map_err(failed)?;
    if f.amax() == 0.0 {
        return Err("the load acts on nothing that moves".into());
    }
    let system = model.assemble_sparse(&theta).map_err(failed)?;
    let (k, m) = (&system.stiffness, &system.mass);
    let plan = plan(model, &system).map_err(failed)?;
    let free =
        "the structure has no equilibrium under this load: it is free to move, or a mechanism; `supports` must hold it";
    let u = solve_shifted(&plan, k, m, 0.0, &f).map_err(|_| free.to_string())?;
    if !u.iter().all(|v| v.is_finite()) || (k.mul(&u) - &f).amax() > 1e-6 * f.amax() {
        return Err(free.into());
    }
    let mut values = Vec::new();
    for (i, e) in model.elements().iter().enumerate() {
        if e.matrices.is_some() || e.kind.preloads().is_empty() {
            continue;
        }
        let own = model.element_displacements(i, u.as_slice());
        let input = e.values_at(&theta);
        let factor = e.stiffness_factor.as_ref().map_or(1.0, |f| f.at(&theta));
        let found = e.kind.preload_of(&ElementInput { points: &e.points, values: &input }, &own);
        let found = found
            .map_err(|source| failed(ModelError::Element { element: e.name.clone(), path: e.path.clone(), source }))?;
        for (name, value) in found {
            let at = e.kind.properties().iter().position(|p| p.name == name);
            values.extend(at.filter(|_| value != 0.0).map(|p| (i, p, factor * value)));
        }
    }
    let softening = load.spin.as_ref().map(|spin| softening(model, spin, load, &theta)).transpose().map_err(failed)?;
    Ok((values, softening))
}

impl Model {
    /// What the masses of the structure bear on it under an acceleration of all of them, (n_dof x 1), N: those at supported nodes too, whose inertia
    /// loads their neighbours, so that it is more than M times the motion of the rows.
    ///
    /// # Errors
    /// An element without a mass at these parameters.
    pub(crate) fn weight(&self, acceleration: [f64; 3], theta: &[f64]) -> Result<DMatrix<f64>, ModelError> {
        let (path, factor) = (String::new(), Affine::constant(1.0));
        forces(self, &Load { path, gravity: acceleration, spin: None, forces: Vec::new(), factor }, theta)
    }
}

/// The load on the rows of the matrices, (n_dof x 1).
fn forces(model: &Model, load: &Load, theta: &[f64]) -> Result<DMatrix<f64>, ModelError> {
    let dofs = model.dof_map();
    let mut f = DMatrix::zeros(dofs.n_dof(), 1);
    // Element by element: inertia of supported nodes loads their neighbours too.
    for (i, e) in model.elements().iter().enumerate() {
        if let Some(matrices) = &e.matrices {
            let factor = e.mass_factor.as_ref().map_or(1.0, |f| f.at(theta));
            matrices.m.iter().for_each(|m| add_weight(&mut f, matrices, m, load.gravity.map(|g| factor * g), model));
            continue;
        }
        let mut own = vec![0.0; 6 * e.nodes.len()];
        if load.gravity.iter().any(|g| *g != 0.0) {
            add_inertia(&mut own, &weighed_mass(e, theta)?, |_| e.axes.map(|axis| dot(axis, load.gravity)));
        }
        if let Some(spin) = &load.spin {
            let at = e.ends(&model.geometry().positions);
            add_inertia(&mut own, &model.element_matrices(i, theta)?.mass, |k| {
                let away = spin.across(minus(at[k], spin.through)).map(|v| spin.speed * spin.speed * v);
                e.axes.map(|axis| dot(axis, away))
            });
        }
        let connection = model.element_motion(i);
        for (a, force) in own.into_iter().enumerate().filter(|(_, v)| *v != 0.0) {
            connection.terms(a).iter().for_each(|&(j, b)| f[(connection.rows[j as usize], 0)] += b * force);
        }
    }
    for (node, force) in &load.forces {
        for (dof, value) in Dof::ALL.into_iter().zip(force) {
            dofs.express(*node, dof).iter().for_each(|&(row, factor)| f[(row, 0)] += factor * value);
        }
    }
    Ok(f)
}

/// Adds M times an acceleration of the nodes.
///
/// * `of` - that of each node, in the axes of the element
fn add_inertia(own: &mut [f64], mass: &SymMatrix, of: impl Fn(usize) -> [f64; 3]) {
    for k in 0..mass.n() / 6 {
        for (axis, a) in of(k).into_iter().enumerate() {
            own.iter_mut().enumerate().for_each(|(i, f)| *f += mass.get(i, 6 * k + axis) * a);
        }
    }
}

/// Adds the weight of the matrices of another solver.
fn add_weight(f: &mut DMatrix<f64>, matrices: &PlacedMatrices, m: &Symmetric, gravity: Vector, model: &Model) {
    let follows = matrices.follows(model.dof_map());
    let field = |i: usize| {
        let d = &matrices.dofs[i];
        d.dof.filter(|dof| !dof.is_rotation()).map_or(0.0, |_| dot(d.axis, gravity))
    };
    let mut add = |to: usize, value: f64| {
        follows.all()[to].iter().for_each(|&(row, factor)| f[(row, 0)] += factor * value);
    };
    for e in &m.lower {
        let (r, c) = (e.row as usize, e.column as usize);
        add(r, e.value * field(c));
        if r != c {
            add(c, e.value * field(r));
        }
    }
}

/// -Ω² M⊥ of displacements, as a stiffness.
fn softening(model: &Model, spin: &Spin, load: &Load, theta: &[f64]) -> Result<PlacedElement, ModelError> {
    let mut sums: BTreeMap<(usize, usize), f64> = BTreeMap::new();
    for (i, e) in model.elements().iter().enumerate().filter(|(_, e)| e.matrices.is_none()) {
        let mass = model.element_matrices(i, theta)?.mass;
        // Directions across the axis of spin, in the axes of the element, by global axis.
        let across = GLOBAL.map(|global| {
            let v = spin.across(global);
            e.axes.map(|axis| dot(axis, v))
        });
        for (p, &a) in e.nodes.iter().enumerate() {
            for (q, &b) in e.nodes.iter().enumerate() {
                for (s, left) in across.iter().enumerate() {
                    for (t, right) in across.iter().enumerate() {
                        let (row, column) = (3 * a + s, 3 * b + t);
                        if row < column {
                            continue;
                        }
                        let both = |k: usize| left[k / 3] * mass.get(6 * p + k / 3, 6 * q + k % 3) * right[k % 3];
                        let value: f64 = (0..9).map(both).sum();
                        if value != 0.0 {
                            *sums.entry((row, column)).or_default() -= spin.speed * spin.speed * value;
                        }
                    }
                }
            }
        }
    }
    let mut used: Vec<usize> = sums.keys().flat_map(|(r, c)| [*r, *c]).collect();
    used.sort_unstable();
    used.dedup();
    let place = |dof: usize| used.binary_search(&dof).unwrap_or_default() as u32;
    let lower = sums.into_iter().filter(|(_, v)| *v != 0.0);
    let lower = lower.map(|((r, c), value)| Entry { row: place(r), column: place(c), value }).collect();
    let dof = |d: &usize| PlacedDof { node: d / 3, dof: Some(Dof::ALL[d % 3]), axis: GLOBAL[d % 3] };
    let dofs = Arc::new(used.iter().map(dof).collect::<Vec<_>>());
    let k = Arc::new(Symmetric { n: dofs.len(), lower, asymmetry: 0.0 });
    let matrices = PlacedMatrices { dofs, k: Some(k), m: None, c: None, damping_factor: None, is_preload: true };
    let factors = [Some(Value::of(load.factor.clone())), None];
    Ok(PlacedElement::of_matrices(child(&load.path, "spin"), &load.path, factors, matrices))
}
