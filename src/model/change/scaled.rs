//! What a change does to the matrices of an element by factors alone: the matrices themselves are asked for once.
//!
//! ```text
//! Δk = Σ_k Δc_k(θ, s) k_0,    k_0: K, M and C of the element without factors
//! ```

use crate::linalg::SymMatrix;
use crate::model::ElementMatrices;
use crate::model::assembly::{Kind, matrix_uses};
use crate::model::dependence::{Monomial, Terms};
use crate::model::placed_element::PlacedElement;
use crate::model::polynomial::Polynomial;
use std::collections::BTreeMap;

/// Factors: which matrix of an element, to which of the model, how much.
pub(super) type Factors = Vec<(Kind, Kind, Polynomial)>;

/// The change of every factor.
pub(super) fn change_of_factors(after: &PlacedElement, before: &PlacedElement) -> Factors {
    let mut out = matrix_uses(after);
    for (of, to, polynomial) in matrix_uses(before) {
        let less = polynomial.scaled(-1.0);
        match out.iter_mut().find(|u| (u.0, u.1) == (of, to)) {
            Some(found) => found.2 = found.2.clone().plus(&less),
            None => out.push((of, to, less)),
        }
    }
    out.retain(|(.., polynomial)| polynomial.terms().next().is_some());
    out
}

/// Whether an element is of the same type and stands where it stood before: it differs in values and factors at most.
pub(super) fn stands_as(after: &PlacedElement, before: &PlacedElement) -> bool {
    let shape = |e: &PlacedElement| (e.kind.name(), e.axes, e.turn);
    shape(after) == shape(before)
        && (&after.nodes, &after.arms, &after.points) == (&before.nodes, &before.arms, &before.points)
        && after.moving == before.moving
}

/// An element without factors.
pub(super) fn bare(element: &PlacedElement) -> PlacedElement {
    let mut bare = element.clone();
    for factor in
        [&mut bare.stiffness_factor, &mut bare.mass_factor, &mut bare.stiffness_damping, &mut bare.mass_damping]
    {
        *factor = None;
    }
    bare
}

/// The terms of matrices with these factors, from those of the matrices without.
pub(super) fn times(factors: &Factors, of: &[(&Monomial, &ElementMatrices)]) -> Terms {
    let mut out: BTreeMap<Monomial, ElementMatrices> = BTreeMap::new();
    for (from, to, polynomial) in factors {
        for (monomial, factor) in polynomial.terms() {
            for (own, matrices) in of {
                let product = monomial.times(own);
                let into = out.entry(product).or_insert_with(|| nothing_like(matrices));
                add(into, *to, factor, *from, matrices);
            }
        }
    }
    out.into_iter().collect()
}

/// Matrices with these factors at one point.
pub(super) fn at(factors: &Factors, point: &[f64], bare: &ElementMatrices) -> ElementMatrices {
    let mut out = nothing_like(bare);
    for (from, to, polynomial) in factors {
        let factor = polynomial.terms().map(|(m, f)| f * m.at(point)).sum();
        add(&mut out, *to, factor, *from, bare);
    }
    out
}

fn nothing_like(matrices: &ElementMatrices) -> ElementMatrices {
    let n = matrices.stiffness.n();
    let weighed_mass = matrices.weighed_mass.as_ref().map(|_| SymMatrix::zeros(n));
    ElementMatrices { weighed_mass, ..ElementMatrices::zeros(n) }
}

fn add(into: &mut ElementMatrices, to: Kind, factor: f64, from: Kind, of: &ElementMatrices) {
    let matrix = match from {
        Kind::Stiffness => &of.stiffness,
        Kind::Mass => &of.mass,
        Kind::Damping => &of.damping,
    };
    match to {
        Kind::Stiffness => into.stiffness.add_scaled(factor, matrix),
        Kind::Mass => into.mass.add_scaled(factor, matrix),
        Kind::Damping => into.damping.add_scaled(factor, matrix),
    }
    if let (Kind::Mass, Some(sum), Some(weighed)) = (to, &mut into.weighed_mass, &of.weighed_mass) {
        sum.add_scaled(factor, weighed);
    }
}
