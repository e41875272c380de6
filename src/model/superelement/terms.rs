//! Parts of a superelement's matrices that go with parameters, given alone or as differences of whole exports.

use super::units::Units;
use super::{Dofs, Reading};
use crate::matrices::{Entry, Symmetric};
use crate::model::exported::{ExportedMatrices, ExportedTerm};
use crate::model::geometry::unknown;
use crate::model::spec::{ExportSpec, MatrixSpec, SuperelementSpec, TermSpec};
use crate::units::Scalar;
use crate::yaml::{Problem, child};
use std::sync::Arc;

/// Highest power of a parameter.
const MOST_POWER: u32 = 6;
/// A third export that is farther from the power law than this part of the difference is said.
const AFFINE: f64 = 1e-6;

/// K, M, C of files, none where none is named.
struct Matrices([Option<Arc<Symmetric>>; 3]);

impl Reading<'_, '_> {
    pub(super) fn terms(
        &mut self,
        entry: &SuperelementSpec,
        dofs: &Dofs,
        units: &Units,
        base: &ExportedMatrices,
    ) -> Option<Vec<ExportedTerm>> {
        let mut terms = Vec::new();
        for (name, term) in &entry.terms {
            terms.push(self.term(name, term, dofs, units, base)?);
        }
        Some(terms)
    }

    fn term(
        &mut self,
        name: &str,
        term: &TermSpec,
        dofs: &Dofs,
        units: &Units,
        base: &ExportedMatrices,
    ) -> Option<ExportedTerm> {
        let key = format!("terms.{name}");
        let parameter = term.parameter.as_deref().unwrap_or(name);
        if !self.spec.parameters.contains_key(parameter) {
            let path = child(self.path, &key);
            let mut problem = unknown(&path, "parameter", parameter, self.spec.parameters.keys());
            if term.parameter.is_none() {
                problem.message.push_str("; a term of another name says `parameter: NAME`");
            }
            self.problems.push(problem);
            return None;
        }
        let power = term.power.unwrap_or(1);
        if !(1..=MOST_POWER).contains(&power) {
            self.error(&format!("{key}.power"), format_args!("a power must be 1 to {MOST_POWER}"));
            return None;
        }
        let at = match &term.at {
            Some(at) => Some(self.value_of(at, parameter, &format!("{key}.at"))?),
            None => None,
        };
        if term.exports.is_empty() {
            let Matrices([k, m, c]) = self.three(&key, [&term.k, &term.m, &term.c], dofs, units)?;
            if k.is_none() && m.is_none() && c.is_none() {
                self.error(&key, "a term needs a matrix `k`, `m` or `c`, or `exports`");
                return None;
            }
            if term.included && at.is_none() {
                self.error(&key, "`included` needs the value that the matrices are of: `at: 70 GPa`");
                return None;
            }
            if at == Some(0.0) {
                self.error(&format!("{key}.at"), "at zero a part that goes with the parameter is zero");
                return None;
            }
            let matrices = ExportedMatrices { k, m, c };
            let (name, parameter) = (name.to_string(), parameter.to_string());
            return Some(ExportedTerm {
                name,
                parameter,
                reference: at.unwrap_or(1.0),
                power,
                is_included: term.included,
                matrices,
            });
        }
        if term.k.is_some() || term.m.is_some() || term.c.is_some() || term.included {
            self.error(
                &key,
                "`exports` are whole matrices; `k`, `m`, `c` and `included` of a part do not go with them",
            );
            return None;
        }
        let Some(at) = at else {
            self.error(
                &key,
                "with `exports` the term needs the value that the matrices of the superelement are of: `at: 2 mm`",
            );
            return None;
        };
        let part = self.difference(&key, parameter, (at, power), &term.exports, dofs, units, base)?;
        let (name, parameter) = (name.to_string(), parameter.to_string());
        // At zero the superelement has nothing of the part: it counts from there.
        let reference = if at == 0.0 { 1.0 } else { at };
        Some(ExportedTerm { name, parameter, reference, power, is_included: at != 0.0, matrices: part })
    }

    /// A value of a parameter in SI.
    fn value_of(&mut self, value: &Scalar, parameter: &str, key: &str) -> Option<f64> {
        let dimension = |s: &Scalar| s.terms().iter().find_map(|t| t.dimension);
        let own = self.spec.parameters.get(parameter).and_then(|p| dimension(&p.value));
        let sum: f64 = value.terms().iter().map(|t| t.factor).sum();
        if value.parameters().next().is_some() {
            self.error(key, "a value must be a number");
            return None;
        }
        if let (Some(a), Some(b)) = (dimension(value), own)
            && a != b
        {
            self.error(key, format_args!("`{}` is in another unit than the parameter `{parameter}`", value.text()));
            return None;
        }
        sum.is_finite().then_some(sum)
    }

    fn three(&mut self, key: &str, files: [&Option<MatrixSpec>; 3], dofs: &Dofs, units: &Units) -> Option<Matrices> {
        let scales = [units.stiffness(), units.mass(), units.damping()];
        let mut out = [None, None, None];
        for (((slot, file), scale), letter) in out.iter_mut().zip(files).zip(scales).zip(["k", "m", "c"]) {
            let Some(file) = file else { continue };
            let key = format!("{key}.{letter}");
            let picked = self.pick(&key, file)?;
            *slot = Some(self.in_si(&picked, &key, dofs, scale).ok()?);
        }
        Some(Matrices(out))
    }

    /// The part that goes with the parameter, as it is in the matrices of the superelement: a^p (A_b - A_a)/(b^p - a^p).
    #[expect(clippy::too_many_arguments, reason = "all of one term")]
    fn difference(
        &mut self,
        key: &str,
        parameter: &str,
        (at, power): (f64, u32),
        exports: &[ExportSpec],
        dofs: &Dofs,
        units: &Units,
        base: &ExportedMatrices,
    ) -> Option<ExportedMatrices> {
        let law = |value: f64| value.powi(power as i32) - at.powi(power as i32);
        let mut slope: Option<[Option<Symmetric>; 3]> = None;
        for (i, export) in exports.iter().enumerate() {
            let key = format!("{key}.exports[{i}]");
            let value = self.value_of(&export.at, parameter, &format!("{key}.at"))?;
            if law(value) == 0.0 || !law(value).is_finite() {
                self.error(
                    &format!("{key}.at"),
                    "the matrices of another value are needed than those of the superelement",
                );
                return None;
            }
            let Matrices(whole) = self.three(&key, [&export.k, &export.m, &export.c], dofs, units)?;
            let own = [&base.k, &base.m, &base.c];
            let mut change: [Option<Symmetric>; 3] = [None, None, None];
            for ((slot, whole), own) in change.iter_mut().zip(&whole).zip(own) {
                let empty = Symmetric { n: dofs.labels.len(), ..Symmetric::default() };
                *slot = whole
                    .as_ref()
                    .map(|w| sum(w, 1.0 / law(value), own.as_deref().unwrap_or(&empty), -1.0 / law(value)));
            }
            let Some(first) = &slope else {
                slope = Some(change);
                continue;
            };
            for (first, (now, letter)) in first.iter().zip(change.iter().zip(["k", "m", "c"])) {
                let (Some(first), Some(now)) = (first, now) else { continue };
                let off = norm(&sum(first, 1.0, now, -1.0)) / norm(now).max(f64::MIN_POSITIVE);
                if off > AFFINE {
                    self.problems.push(Problem::warning(
                        child(self.path, &format!("{key}.{letter}")),
                        format_args!(
                            "the matrices are not proportional to the power {power} of `{parameter}`: this export is {:.2} % of its change away from the line through the others",
                            100.0 * off
                        ),
                    ));
                }
            }
        }
        let reference = if at == 0.0 { 1.0 } else { at.powi(power as i32) };
        let [k, m, c] = slope?.map(|a| {
            a.map(|mut a| {
                a.lower.iter_mut().for_each(|e| e.value *= reference);
                Arc::new(a)
            })
        });
        if k.is_none() && m.is_none() && c.is_none() {
            self.error(key, "an export needs a matrix `k`, `m` or `c`");
            return None;
        }
        Some(ExportedMatrices { k, m, c })
    }
}

/// f a + g b; what cancels up to rounding is zero.
fn sum(a: &Symmetric, f: f64, b: &Symmetric, g: f64) -> Symmetric {
    const ROUNDING: f64 = 1e-15;
    let place = |e: &Entry| (e.column, e.row);
    let mut out = Symmetric { n: a.n, lower: Vec::with_capacity(a.lower.len().max(b.lower.len())), asymmetry: 0.0 };
    let (mut i, mut j) = (0, 0);
    while i < a.lower.len() || j < b.lower.len() {
        let (first, second) = (a.lower.get(i), b.lower.get(j));
        let takes_first = first.is_some_and(|x| second.is_none_or(|y| place(x) <= place(y)));
        let takes_second = second.is_some_and(|y| first.is_none_or(|x| place(y) <= place(x)));
        let x = first.filter(|_| takes_first).map_or(0.0, |e| f * e.value);
        let y = second.filter(|_| takes_second).map_or(0.0, |e| g * e.value);
        i += usize::from(takes_first);
        j += usize::from(takes_second);
        if let Some(at) = first.filter(|_| takes_first).or(second)
            && (x + y).abs() > ROUNDING * (x.abs() + y.abs())
        {
            out.lower.push(Entry { value: x + y, ..*at });
        }
    }
    out
}

/// Frobenius norm.
fn norm(a: &Symmetric) -> f64 {
    let square = |e: &Entry| e.value * e.value * if e.row == e.column { 1.0 } else { 2.0 };
    a.lower.iter().map(square).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrices_of_other_patterns_are_subtracted() {
        let of = |entries: &[(u32, u32, f64)]| Symmetric {
            n: 3,
            lower: entries.iter().map(|&(row, column, value)| Entry { row, column, value }).collect(),
            asymmetry: 0.0,
        };
        let a = of(&[(0, 0, 2.0), (2, 0, 1.0), (2, 2, 3.0)]);
        let b = of(&[(0, 0, 2.0), (1, 0, 5.0), (2, 2, 1.0)]);
        assert_eq!(sum(&a, 1.0, &b, -1.0), of(&[(1, 0, -5.0), (2, 0, 1.0), (2, 2, 2.0)]));
        assert!((norm(&of(&[(0, 0, 3.0), (1, 0, 2.0)])) - 17.0_f64.sqrt()).abs() < 1e-15);
    }
}
