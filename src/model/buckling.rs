//! Loss of stability under preload.
//!
//! With s times all preloads the stiffness is K_E + s K_P. The critical factor is the least s > 0 at which it stops being positive; the
//! s for which it is positive form an interval, so that bisection on the inertia of a factorisation finds its end.

use super::ParametricModel;
use super::assembly::{Basis, sparse_system};
use super::compile::Model;
use super::connection::Connection;
use super::critical_preload::CriticalPreload;
use super::dependence::element_matrices;
use super::entry::Entry;
use super::placed_element::PlacedElement;
use super::solver::plan;
use super::system::SparseSystem;
use super::value::{Affine, Value};
use super::{ElementMatrices, ModelError};
use crate::linalg::sparse::{SparsePlan, SparseSym};
use crate::modal::unstable_directions;
use std::sync::Arc;

/// Largest factor that is looked for.
const FARTHEST: f64 = 1e3;
/// Halvings of the interval of the factor.
const HALVINGS: usize = 24;

impl Model {
    /// Whether some element states a preload.
    pub(super) fn is_preloaded(&self) -> bool {
        self.elements().iter().any(|e| preloads(e).next().is_some() || is_exported(e))
    }

    /// Whether the stiffness at θ is positive but for rigid motions and mechanisms.
    pub(super) fn is_stable(&self, theta: &[f64]) -> Result<bool, ModelError> {
        is_positive(self, &self.assemble_sparse(theta)?)
    }

    pub(super) fn critical_preload_at(&self, theta: &[f64]) -> Result<Option<CriticalPreload>, ModelError> {
        let Some((element, property, value, unit)) = self.largest_preload(theta) else { return Ok(None) };
        // Stiffness is linear in the factor, but for supports that give: two assemblies serve every trial.
        let ends = match self.elastic_supports() {
            Some(_) => None,
            None => Some([self.assemble_preloaded(theta, 0.0)?, self.assemble_preloaded(theta, 1.0)?]),
        };
        let plan = ends.as_ref().map(|[_, loaded]| plan(self, loaded)).transpose()?;
        let is_stable = |factor: f64| match (&ends, &plan) {
            (Some([bare, loaded]), Some(plan)) => {
                is_positive_by(plan, &between(&bare.stiffness, &loaded.stiffness, factor))
            }
            _ => is_positive(self, &self.assemble_preloaded(theta, factor)?),
        };
        if !is_stable(0.0)? {
            return Ok(None);
        }
        let (mut low, mut high) = (0.0, 1.0);
        while is_stable(high)? {
            (low, high) = (high, 2.0 * high);
            if high > FARTHEST {
                return Ok(None);
            }
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if is_stable(middle)? { low = middle } else { high = middle }
        }
        let path = element.section.as_ref().map_or(element.path.clone(), |s| crate::yaml::child("sections", s));
        Ok(Some(CriticalPreload { factor: high, element: element.name.clone(), path, property, value, unit }))
    }

    /// The largest compression, or where there is none the largest preload: its element, property, value, and unit.
    fn largest_preload(&self, theta: &[f64]) -> Option<(&PlacedElement, &'static str, f64, &'static str)> {
        let of_exported = || {
            let e = self.elements().iter().find(|e| is_exported(e))?;
            Some((e, "factor", e.stiffness_factor.as_ref().map_or(1.0, |f| f.at(theta)), ""))
        };
        let of = |e: &'_ PlacedElement| {
            let all = preloads(e).map(|i| (i, e.values[i].as_ref().map_or(0.0, |v| v.at(theta))));
            all.filter(|p| p.1 != 0.0).min_by(|a, b| a.1.total_cmp(&b.1))
        };
        let all = self.elements().iter().filter_map(|e| of(e).map(|(i, value)| (e, i, value)));
        let Some((e, i, value)) = all.min_by(|a, b| a.2.total_cmp(&b.2)) else { return of_exported() };
        let property = &e.kind.properties()[i];
        Some((e, property.name, value, property.unit))
    }

    /// The matrices at θ with all preloads times a factor.
    fn assemble_preloaded(&self, theta: &[f64], factor: f64) -> Result<SparseSystem, ModelError> {
        let scaled = |e: &PlacedElement| {
            let mut e = e.clone();
            for i in preloads(&e).collect::<Vec<_>>() {
                let value = e.values[i].as_ref().map_or(0.0, |v| v.at(theta));
                Arc::make_mut(&mut e.values)[i] =
                    Some(Value::of(Affine { constant: factor * value, terms: Vec::new() }));
            }
            e
        };
        let elements: Vec<PlacedElement> = self.elements().iter().map(scaled).collect();
        let mut all: Vec<(&Connection, ElementMatrices)> = Vec::new();
        for (i, (now, own)) in elements.iter().zip(self.elements()).enumerate() {
            let matrices = element_matrices(now, theta)?;
            if self.is_general(i) {
                all.push((self.element_motion(i), matrices));
            } else if preloads(own).next().is_some() {
                let change = matrices.combine(&element_matrices(own, theta)?, |a, b| a - b);
                all.push((self.element_motion(i), change));
            }
        }
        all.extend(self.support_matrices(&elements, theta)?);
        // Of an exported preload what is more than once.
        let mut more = Basis::default();
        for e in self.elements().iter().filter(|e| is_exported(e)) {
            let own = e.stiffness_factor.as_ref().map_or(1.0, |f| f.at(theta));
            let Some(matrices) = &e.matrices else { continue };
            let entries = matrices.k.iter().flat_map(|k| matrices.follows(self.dof_map()).reduce(k));
            more.stiffness.extend(entries.map(|e| Entry { value: (factor - 1.0) * own * e.value, ..e }));
        }
        let bases: Vec<_> = self.affine_part().at(theta).chain([(&more, 1.0)]).collect();
        Ok(sparse_system(self.dof_map().n_dof(), false, &bases, &all))
    }
}

/// Whether it is the stiffness of a preload that another solver has written.
fn is_exported(e: &PlacedElement) -> bool {
    e.matrices.as_ref().is_some_and(|m| m.is_preload)
}

/// Indices of the preloads among the properties of an element that are stated.
fn preloads(e: &PlacedElement) -> impl Iterator<Item = usize> + '_ {
    let names = e.kind.preloads();
    let properties = e.kind.properties().iter().enumerate();
    properties.filter(move |(i, p)| names.contains(&p.name) && e.values[*i].is_some()).map(|(i, _)| i)
}

/// (1 - s) A + s B.
fn between(a: &SparseSym, b: &SparseSym, s: f64) -> SparseSym {
    let of = |m: &'_ SparseSym, factor: f64| m.entries().map(move |(i, j, v)| (i, j, factor * v)).collect::<Vec<_>>();
    let all = [of(a, 1.0 - s), of(b, s)].concat();
    SparseSym::from_triplets(a.n(), all.iter().copied())
}

fn is_positive(model: &Model, system: &SparseSystem) -> Result<bool, ModelError> {
    is_positive_by(&plan(model, system)?, &system.stiffness)
}

fn is_positive_by(plan: &SparsePlan, stiffness: &SparseSym) -> Result<bool, ModelError> {
    let negative = unstable_directions(plan, stiffness).map_err(crate::modal::ModalError::from)?;
    Ok(negative == Some(0))
}
