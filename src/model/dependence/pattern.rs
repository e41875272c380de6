//! The dependence of many elements: what one of a section has, the others are looked at for first.
//!
//! Of a mesh every element of a section has the same powers of the same parameters, with other matrices. Where those of one are known, as many
//! points as it has terms tell those of another, and one more whether it has no others:
//!
//! ```text
//! A_k = Σ_i W_ki A(θ_i),    W = V⁻¹,    V_ik = c_k(θ_i)
//! ```

use super::powers::{cleaned, weighted};
use super::samples::Samples;
use super::{Monomial, Terms, affine, dependence, search};
use crate::linalg::DMatrix;
use crate::model::ModelError;
use crate::model::each::of_each;
use crate::model::parameter::ParameterSet;
use crate::model::placed_element::PlacedElement;
use std::collections::HashMap;
use std::sync::Arc;

/// How often those whose own pattern is another are looked at together; those left then are looked at one by one.
const MOST_ROUNDS: usize = 4;
/// Points at which this is the largest part that rounding grows by tell the terms; others do not.
const MOST_GROWTH: f64 = 1e4;

/// What the elements of a section have in common.
enum Pattern {
    Terms(Points),
    /// Matrices that are affine in the parameters.
    Affine,
    /// Matrices that are no polynomial of the parameters.
    General,
}

/// Monomials, and points that tell their matrices.
struct Points {
    monomials: Vec<Monomial>,
    /// Values of the parameters used at each point.
    values: Vec<Vec<f64>>,
    /// W, (monomials x points).
    weights: DMatrix<f64>,
}

/// How the matrices of elements depend on θ; `None` for those that are no polynomials.
///
/// * `these` - which of them, ascending
///
/// # Errors
/// As [`dependence`], of the first.
pub(in crate::model) fn dependences<R: Send>(
    elements: &[PlacedElement],
    these: &[usize],
    parameters: &ParameterSet,
    of: impl Fn(usize, Option<Terms>) -> R + Sync + Send,
) -> Result<Vec<R>, ModelError> {
    let mut found: Vec<Option<R>> = elements.iter().map(|_| None).collect();
    let mut left: Vec<usize> = these.to_vec();
    for _ in 0..MOST_ROUNDS {
        let sections = sections(elements, &left);
        let first: Vec<usize> = sections.iter().map(|s| s[0]).collect();
        let searched = of_each(&first, |&e| {
            let mut samples = Samples::new(&elements[e], parameters)?;
            let terms = search(&mut samples);
            let is_affine = |terms: &Terms| terms.iter().all(|(m, _)| matches!(m.powers[..], [] | [(_, 1)]));
            let pattern = match &terms {
                Some(terms) if is_affine(terms) => Some(Pattern::Affine),
                Some(terms) => Points::new(terms, &samples).map(Pattern::Terms),
                None => Some(Pattern::General),
            };
            Ok::<_, ModelError>((pattern, of(e, terms)))
        });
        let mut tried = Vec::new();
        let mut next = Vec::new();
        for (section, searched) in sections.iter().zip(searched) {
            let (pattern, result) = searched?;
            found[section[0]] = Some(result);
            match pattern {
                Some(pattern) => tried.push((pattern, &section[1..])),
                None => next.extend(&section[1..]),
            }
        }
        let tasks: Vec<(&Pattern, usize)> =
            tried.iter().flat_map(|(pattern, section)| section.iter().map(move |&e| (pattern, e))).collect();
        let by_pattern = of_each(&tasks, |&(pattern, e)| {
            let terms = match pattern {
                Pattern::General => Some(None),
                Pattern::Affine => affine(&mut Samples::new(&elements[e], parameters)?).map(Some),
                Pattern::Terms(points) => points.terms(&elements[e], parameters)?.map(Some),
            };
            Ok::<_, ModelError>(terms.map(|terms| of(e, terms)))
        });
        for ((_, e), result) in tasks.iter().zip(by_pattern) {
            match result? {
                Some(result) => found[*e] = Some(result),
                None => next.push(*e),
            }
        }
        next.sort_unstable();
        left = next;
    }
    let one_by_one = of_each(&left, |&e| Ok::<_, ModelError>(of(e, dependence(&elements[e], parameters)?)));
    for (e, result) in left.iter().zip(one_by_one) {
        found[*e] = Some(result?);
    }
    Ok(found.into_iter().flatten().collect())
}

/// Elements of one type with the same properties, in their order; each on its own where its properties are those of no other.
fn sections(elements: &[PlacedElement], of: &[usize]) -> Vec<Vec<usize>> {
    let mut out: Vec<Vec<usize>> = Vec::new();
    let mut known: HashMap<(usize, &str, bool), Vec<usize>> = HashMap::new();
    for &e in of {
        let element = &elements[e];
        let factors = |e: &PlacedElement| {
            [&e.stiffness_factor, &e.mass_factor, &e.stiffness_damping, &e.mass_damping].map(Clone::clone)
        };
        let key = (Arc::as_ptr(&element.values) as usize, element.kind.name(), element.moving.is_some());
        let alike = known.entry(key).or_default();
        match alike.iter().find(|&&s| factors(&elements[out[s][0]]) == factors(element)) {
            Some(&section) => out[section].push(e),
            None => {
                alike.push(out.len());
                out.push(vec![e]);
            }
        }
    }
    out
}

impl Points {
    /// Of the points that were looked at, those that tell the terms with the least rounding; `None` where none do.
    fn new(terms: &Terms, samples: &Samples<'_>) -> Option<Self> {
        let monomials: Vec<Monomial> = terms.iter().map(|t| t.0.clone()).collect();
        let values = samples.points();
        let at = |values: &Vec<f64>| monomials.iter().map(|m| m.at(&samples.point(values))).collect::<Vec<_>>();
        let all: Vec<Vec<f64>> = values.iter().map(at).collect();
        let scale: Vec<f64> =
            (0..monomials.len()).map(|k| all.iter().map(|a| a[k].abs()).fold(0.0, f64::max)).collect();
        let mut rows: Vec<Vec<f64>> =
            all.iter().map(|a| a.iter().zip(&scale).map(|(a, s)| a / s.max(f64::MIN_POSITIVE)).collect()).collect();
        let mut chosen = Vec::new();
        for _ in 0..monomials.len() {
            let norm = |row: &Vec<f64>| row.iter().map(|v| v * v).sum::<f64>();
            let largest = (0..rows.len()).reduce(|a, b| if norm(&rows[b]) > norm(&rows[a]) { b } else { a })?;
            // The base is looked at in any case.
            let best = if chosen.is_empty() { 0 } else { largest };
            let length = norm(&rows[best]).sqrt();
            if length == 0.0 {
                return None;
            }
            let along: Vec<f64> = rows[best].iter().map(|v| v / length).collect();
            for row in &mut rows {
                let part: f64 = row.iter().zip(&along).map(|(a, b)| a * b).sum();
                row.iter_mut().zip(&along).for_each(|(a, b)| *a -= part * b);
            }
            rows[best].fill(0.0);
            chosen.push(best);
        }
        let v = DMatrix::from_fn(chosen.len(), chosen.len(), |i, k| all[chosen[i]][k]);
        let weights = v.try_inverse()?;
        let growth = (0..weights.nrows()).map(|k| weights.row(k).iter().map(|w| w.abs()).sum::<f64>() * scale[k]);
        let is_told = growth.fold(0.0, f64::max) <= MOST_GROWTH;
        is_told.then(|| Self { monomials, values: chosen.iter().map(|&i| values[i].clone()).collect(), weights })
    }

    /// The terms of another element; `None` where it has others.
    fn terms(&self, element: &PlacedElement, parameters: &ParameterSet) -> Result<Option<Terms>, ModelError> {
        let mut samples = Samples::new(element, parameters)?;
        let Some(places) = self.values.iter().map(|v| samples.at(v)).collect::<Option<Vec<_>>>() else {
            return Ok(None);
        };
        let row = |k: usize| self.weights.row(k).iter().copied().collect::<Vec<f64>>();
        let term = |(k, monomial): (usize, &Monomial)| (monomial.clone(), weighted(&samples, &places, &row(k)));
        let terms = cleaned(self.monomials.iter().enumerate().map(term).collect(), &samples);
        Ok(samples.agree(&terms, 1).unwrap_or(false).then_some(terms))
    }
}
