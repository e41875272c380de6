//! The matrices of an element as a polynomial of the parameters, found from nothing.
//!
//! ```text
//! A(θ) = A(r) + Σ_groups (Σ_k L_k(θ) A(θ_k) - A(r)),    L_k: products of Lagrange's polynomials, sorted by powers of θ
//! ```
//!
//! r is a point at which no parameter is zero. Along each parameter the lowest degree that predicts the next node is its own; parameters
//! between which a mixed difference is seen are a group, whose grid has one node more along each than its degree there. Powers count from
//! zero: E t and E t³ of a plate are two terms, of E - E₀ and t - t₀ they would be seven.
//!
//! Nodes are multiples of the value, since a polynomial is the same one outside the bounds and its powers are found to more digits there; where the element
//! does not exist at them, or is another function, they are within the bounds. The whole is checked within the bounds with all parameters
//! moved together.

use super::samples::{AGREEMENT, ALL_CHECKS, Samples, is_close, sizes};
use super::{Monomial, Terms};
use crate::linalg::SymMatrix;
use crate::model::ElementMatrices;

/// Most points of a grid: two parameters to the third power with two that are linear, or six that are linear.
const MOST_SAMPLES: usize = 64;
/// Highest power of one parameter.
const MOST_POWER: usize = 3;
/// A term that is nowhere more than this part of the size of its dofs is rounding of the sums that it is found by.
const NOTHING: f64 = 2e-12;

/// Nodes along one parameter, the first at r; the last checks the highest degree.
type Nodes = [f64; MOST_POWER + 2];

/// Σ c_k(θ) A_k, if it is that.
pub(super) fn polynomial(samples: &mut Samples<'_>) -> Option<Terms> {
    let multiples = samples.beside_zero().into_iter().map(|r| [1.0, 0.5, 1.5, 2.0, 1.25].map(|m| m * r)).collect();
    let pairs = samples.base.iter().zip(&samples.steps);
    let within = pairs.map(|(base, step)| [0.5, 1.0, 0.25, 0.75, 0.375].map(|part| base + part * step)).collect();
    [multiples, within].into_iter().find_map(|nodes: Vec<Nodes>| {
        let terms = through(samples, &nodes)?;
        samples.agree(&terms, ALL_CHECKS)?.then_some(terms)
    })
}

/// Parameters that act together, and the grid through which their polynomial goes.
struct Group {
    /// Places in [`Samples::used`], and the degree in each.
    of: Vec<(usize, usize)>,
    /// Places in [`Samples::known`] of the points of the grid.
    places: Vec<usize>,
}

/// The polynomial through the nodes.
fn through(samples: &mut Samples<'_>, nodes: &[Nodes]) -> Option<Terms> {
    let at_r = at(samples, nodes, &[])?;
    let degrees = (0..nodes.len()).map(|k| degree(samples, nodes, k)).collect::<Option<Vec<_>>>()?;
    let mut grids = Vec::new();
    for of in groups(samples, nodes, &degrees)? {
        let of: Vec<(usize, usize)> = of.into_iter().map(|k| (k, degrees[k])).collect();
        let size =
            of.iter().try_fold(1_usize, |size, (_, d)| size.checked_mul(d + 1)).filter(|n| *n <= MOST_SAMPLES)?;
        let place = |k: usize| {
            let moved: Vec<(usize, usize)> = digits(&of, k).zip(&of).map(|(digit, (k, _))| (*k, digit)).collect();
            at(samples, nodes, &moved)
        };
        let places = (0..size).map(place).collect::<Option<_>>()?;
        grids.push(Group { of, places });
    }
    let mut constant = samples.known[at_r].clone();
    let mut terms = Vec::new();
    for group in &grids {
        for (monomial, matrices) in group.terms(samples, nodes) {
            if monomial.powers.is_empty() {
                let own = matrices.combine(&samples.known[at_r], |a, b| a - b);
                constant = constant.combine(&own, |c, d| c + d);
            } else {
                terms.push((monomial, matrices));
            }
        }
    }
    terms.insert(0, (Monomial::default(), constant));
    Some(cleaned(terms, samples))
}

/// Terms without what is rounding in them, and without those of which nothing is left then.
pub(super) fn cleaned(mut terms: Terms, samples: &Samples<'_>) -> Terms {
    let r = samples.point(&samples.beside_zero());
    let size = |of: fn(&ElementMatrices) -> &SymMatrix| {
        let mut size = Vec::new();
        samples.known.iter().for_each(|m| sizes(of(m), &mut size));
        size
    };
    let clean = |term: &mut SymMatrix, size: &[f64], factor: f64| {
        let places = (0..size.len()).flat_map(|i| (0..=i).map(move |j| (i, j)));
        for ((i, j), value) in places.zip(term.lower_mut()) {
            if (*value * factor).abs() <= NOTHING * (size[i] * size[j]).sqrt() {
                *value = 0.0;
            }
        }
    };
    let [stiffness, mass, damping, weighed] =
        [size(|m| &m.stiffness), size(|m| &m.mass), size(|m| &m.damping), size(ElementMatrices::weighed)];
    for (monomial, matrices) in &mut terms {
        let factor = monomial.at(&r);
        clean(&mut matrices.stiffness, &stiffness, factor);
        clean(&mut matrices.mass, &mass, factor);
        clean(&mut matrices.damping, &damping, factor);
        if let Some(own) = &mut matrices.weighed_mass {
            clean(own, &weighed, factor);
        }
    }
    terms.retain(|(_, matrices)| !matrices.is_zero());
    terms
}

/// The place of the matrices with some parameters at nodes of theirs, the others at r.
fn at(samples: &mut Samples<'_>, nodes: &[Nodes], moved: &[(usize, usize)]) -> Option<usize> {
    let mut values: Vec<f64> = nodes.iter().map(|n| n[0]).collect();
    for &(k, node) in moved {
        values[k] = nodes[k][node];
    }
    samples.at(&values)
}

/// The lowest degree along a parameter whose polynomial goes through the next node.
fn degree(samples: &mut Samples<'_>, nodes: &[Nodes], k: usize) -> Option<usize> {
    let mut places = vec![at(samples, nodes, &[])?];
    for degree in 0..=MOST_POWER {
        let next = at(samples, nodes, &[(k, degree + 1)])?;
        let predicted = weighted(samples, &places, &lagrange(&nodes[k][..=degree], nodes[k][degree + 1]));
        if is_close(&samples.known[next], &predicted, AGREEMENT) {
            return Some(degree);
        }
        places.push(next);
    }
    None
}

/// Groups of parameters, as places in [`Samples::used`], between which no mixed difference is seen; `None` where one is larger than any grid.
fn groups(samples: &mut Samples<'_>, nodes: &[Nodes], degrees: &[usize]) -> Option<Vec<Vec<usize>>> {
    let n = nodes.len();
    let mut group: Vec<usize> = (0..n).collect();
    for i in 1..n {
        let all: Vec<usize> = (0..i).collect();
        let mut partners = Vec::new();
        partners_of(samples, nodes, i, &all, &mut partners)?;
        for j in partners {
            let (from, to) = (group[i], group[j]);
            group.iter_mut().filter(|g| **g == from).for_each(|g| *g = to);
        }
        let own = (0..=i).filter(|&k| group[k] == group[i]);
        own.map(|k| degrees[k] + 1).try_fold(1_usize, usize::checked_mul).filter(|size| *size <= MOST_SAMPLES)?;
    }
    let members = |g: usize| (0..n).filter(|&k| group[k] == g).collect::<Vec<_>>();
    Some((0..n).map(members).filter(|m| !m.is_empty()).collect())
}

/// Which of some parameters have a mixed difference with parameter i: all of them moved together tell whether any has, halves which.
fn partners_of(
    samples: &mut Samples<'_>,
    nodes: &[Nodes],
    i: usize,
    of: &[usize],
    found: &mut Vec<usize>,
) -> Option<()> {
    if found.len() > MOST_SAMPLES {
        return None;
    }
    let moved = |samples: &mut Samples<'_>, of: &[usize]| {
        at(samples, nodes, &of.iter().map(|&k| (k, 1)).collect::<Vec<(usize, usize)>>())
    };
    let with: Vec<usize> = of.iter().copied().chain([i]).collect();
    let (both, first, second) = (moved(samples, &with)?, moved(samples, of)?, moved(samples, &[i])?);
    let at_r = at(samples, nodes, &[])?;
    let apart = weighted(samples, &[first, second, at_r], &[1.0, 1.0, -1.0]);
    if is_close(&samples.known[both], &apart, AGREEMENT) {
        return Some(());
    }
    if of.len() == 1 {
        found.push(of[0]);
        return Some(());
    }
    let (left, right) = of.split_at(of.len() / 2);
    partners_of(samples, nodes, i, left, found)?;
    partners_of(samples, nodes, i, right, found)
}

/// The digits of a number with as many values for each as its degree and one: which node along each parameter, which power of each.
fn digits(of: &[(usize, usize)], k: usize) -> impl Iterator<Item = usize> + '_ {
    let mut left = k;
    of.iter().map(move |(_, degree)| {
        let digit = left % (degree + 1);
        left /= degree + 1;
        digit
    })
}

impl Group {
    fn terms(&self, samples: &Samples<'_>, nodes: &[Nodes]) -> Terms {
        let powers: Vec<_> = self.of.iter().map(|&(k, degree)| by_powers(&nodes[k][..=degree])).collect();
        let term = |m: usize| {
            let weight = |k: usize| {
                let pairs = digits(&self.of, m).zip(digits(&self.of, k)).enumerate();
                pairs.map(|(i, (power, node))| powers[i][node][power]).product()
            };
            let weights: Vec<f64> = (0..self.places.len()).map(weight).collect();
            let powers = digits(&self.of, m).zip(&self.of).filter(|(power, _)| *power > 0);
            let mut powers: Vec<(usize, i32)> =
                powers.map(|(power, (k, _))| (samples.used[*k], power as i32)).collect();
            powers.sort_unstable();
            (Monomial { powers }, weighted(samples, &self.places, &weights))
        };
        (0..self.places.len()).map(term).collect()
    }
}

/// Lagrange's polynomials of the nodes at t.
pub(super) fn lagrange(nodes: &[f64], t: f64) -> Vec<f64> {
    let of = |k: usize| {
        let others = nodes.iter().enumerate().filter(|(j, _)| *j != k);
        others.map(|(_, node)| (t - node) / (nodes[k] - node)).product()
    };
    (0..nodes.len()).map(of).collect()
}

/// The coefficients of the powers of t in Lagrange's polynomial of each node.
pub(super) fn by_powers(nodes: &[f64]) -> Vec<Vec<f64>> {
    let of = |k: usize| {
        let mut out = vec![1.0];
        for (_, node) in nodes.iter().enumerate().filter(|(j, _)| *j != k) {
            let width = nodes[k] - node;
            // out · (t - node) / width
            let mut next = vec![0.0; out.len() + 1];
            for (power, c) in out.iter().enumerate() {
                next[power] -= c * node / width;
                next[power + 1] += c / width;
            }
            out = next;
        }
        out
    };
    (0..nodes.len()).map(of).collect()
}

/// Σ w A over some of the samples.
pub(super) fn weighted(samples: &Samples<'_>, places: &[usize], weights: &[f64]) -> ElementMatrices {
    let known = |k: usize| &samples.known[places[k]];
    let of = |matrix: fn(&ElementMatrices) -> &SymMatrix| {
        let mut sum = SymMatrix::zeros(matrix(known(0)).n());
        for (k, w) in weights.iter().enumerate().filter(|(_, w)| **w != 0.0) {
            sum.add_scaled(*w, matrix(known(k)));
        }
        sum
    };
    let has_weighed = (0..places.len()).all(|k| known(k).weighed_mass.is_some());
    ElementMatrices {
        stiffness: of(|m| &m.stiffness),
        mass: of(|m| &m.mass),
        weighed_mass: has_weighed.then(|| of(ElementMatrices::weighed)),
        damping: of(|m| &m.damping),
    }
}
