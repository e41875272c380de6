//! What K and M of a model are affine in: its free parameters, and products of them.

use super::super::comparison::Comparison;
use super::super::scaling::Scaling;
use crate::linalg::DMatrix;
use crate::linalg::batch::{AffineEntry, AffinePencil};
use crate::model::{AffinePart, Basis, Entry, Monomial};

/// Products of parameters.
#[derive(Debug)]
pub(super) struct Products {
    monomials: Vec<Monomial>,
}

impl Products {
    pub(super) fn of(affine: &AffinePart) -> Self {
        Self { monomials: affine.products.iter().map(|p| p.0.clone()).collect() }
    }

    /// Derivatives of what K and M are affine in by the free parameters, (factors x free).
    pub(super) fn directions(&self, theta: &[f64], scaling: &Scaling) -> DMatrix<f64> {
        let free = scaling.free();
        DMatrix::from_fn(free.len() + self.monomials.len(), free.len(), |i, j| match i.checked_sub(free.len()) {
            None => f64::from(u8::from(i == j)),
            Some(k) => self.monomials[k].derivative(theta, free[j]),
        })
    }

    /// What K and M are affine in: the free parameters, then the products.
    pub(super) fn fill(&self, theta: &[f64], scaling: &Scaling, out: &mut [f64]) {
        let products = self.monomials.iter().map(|p| p.at(theta));
        let values = scaling.free().iter().map(|&i| theta[i]).chain(products);
        out.iter_mut().zip(values).for_each(|(factor, value)| *factor = value);
    }

    /// Number of products.
    pub(super) fn len(&self) -> usize {
        self.monomials.len()
    }
}

/// K and M as functions of the factors; `None` if they are not affine in any.
pub(super) fn pencil(comparison: &Comparison<'_>, scaling: &Scaling) -> Option<AffinePencil> {
    let model = comparison.model();
    let affine = model.affine()?;
    let part = |of: fn(&Basis) -> &[Entry]| {
        let mut entries: Vec<AffineEntry> = Vec::new();
        let mut add = |basis: &Basis, parameter: Option<usize>, factor: f64| {
            entries.extend(of(basis).iter().map(Entry::triplet).map(|(row, col, value)| AffineEntry {
                row,
                col,
                parameter,
                coefficient: factor * value,
            }));
        };
        add(&affine.constant, None, 1.0);
        for (i, (basis, value)) in affine.parameters.iter().zip(scaling.base()).enumerate() {
            match scaling.free().iter().position(|&f| f == i) {
                Some(k) => add(basis, Some(k), 1.0),
                None => add(basis, None, *value),
            }
        }
        for (k, (_, basis)) in affine.products.iter().enumerate() {
            add(basis, Some(scaling.len() + k), 1.0);
        }
        entries
    };
    Some(AffinePencil {
        n: model.dof_map().n_dof(),
        n_parameters: scaling.len() + affine.products.len(),
        stiffness: part(|b| &b.stiffness),
        mass: part(|b| &b.mass),
    })
}
