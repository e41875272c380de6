//! Parts of a superelement's matrices that go with parameters, given alone or as differences of whole exports.

use super::units::Units;
use super::{Dofs, Reading};
use crate::catalogue::did_you_mean;
use crate::linalg::DMatrix;
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
        let powers = self.powers(term, &key)?;
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
                is_included: term.included,
                parts: vec![(powers[0], matrices)],
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
        let parts = self.differences(&key, parameter, (at, &powers), &term.exports, dofs, units, base)?;
        let (name, parameter) = (name.to_string(), parameter.to_string());
        // At zero the superelement has nothing of the part: it counts from there.
        let reference = if at == 0.0 { 1.0 } else { at };
        Some(ExportedTerm { name, parameter, reference, is_included: at != 0.0, parts })
    }

    fn powers(&mut self, term: &TermSpec, key: &str) -> Option<Vec<u32>> {
        let powers = if term.powers.is_empty() { vec![term.power.unwrap_or(1)] } else { term.powers.clone() };
        let wrong = if term.power.is_some() && !term.powers.is_empty() {
            Some(("powers", "`power` and `powers` say the same: give one".to_string()))
        } else if powers.len() > 1 && term.exports.is_empty() {
            Some(("powers", "several powers are told apart by whole matrices at other values: give `exports`, or a term for each power".to_string()))
        } else if powers.iter().any(|p| !(1..=MOST_POWER).contains(p)) {
            let key = if term.powers.is_empty() { "power" } else { "powers" };
            Some((key, format!("a power must be 1 to {MOST_POWER}")))
        } else if powers.iter().enumerate().any(|(i, p)| powers[..i].contains(p)) {
            Some(("powers", "a power stands here twice".to_string()))
        } else if !term.exports.is_empty() && term.exports.len() < powers.len() {
            let (n, found) = (powers.len(), term.exports.len());
            Some(("exports", format!("{n} powers need {n} exports at other values, and {found} are given")))
        } else {
            None
        };
        match wrong {
            Some((own, message)) => {
                self.error(&format!("{key}.{own}"), message);
                None
            }
            None => Some(powers),
        }
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

    /// The parts that go with powers p of the parameter, as they are in the matrices of the superelement:
    ///
    /// ```text
    /// A_b - A_a = Σ_p (b^p - a^p) A_p / a^p     for each export b, A_a those of the superelement
    /// ```
    /// solved for the parts A_p by as many exports as there are powers; those beyond check.
    #[expect(clippy::too_many_arguments, reason = "all of one term")]
    fn differences(
        &mut self,
        key: &str,
        parameter: &str,
        (at, powers): (f64, &[u32]),
        exports: &[ExportSpec],
        dofs: &Dofs,
        units: &Units,
        base: &ExportedMatrices,
    ) -> Option<Vec<(u32, ExportedMatrices)>> {
        let mut values = Vec::new();
        let mut changes: Vec<[Option<Symmetric>; 3]> = Vec::new();
        for (i, export) in exports.iter().enumerate() {
            let key = format!("{key}.exports[{i}]");
            let value = self.value_of(&export.at, parameter, &format!("{key}.at"))?;
            let is_new = value != at && !values.contains(&value);
            if !is_new && i < powers.len() {
                let message =
                    "the matrices of another value are needed than those of the superelement and of other exports";
                self.error(&format!("{key}.at"), message);
                return None;
            }
            let Matrices(whole) = self.three(&key, [&export.k, &export.m, &export.c], dofs, units)?;
            values.push(value);
            changes.push(changed(&whole, base, dofs.labels.len()));
        }
        // Powers of the ratio to the largest value, so that the equations keep their digits.
        let scale = values.iter().fold(at.abs(), |a, b| a.max(b.abs()));
        let law = |value: f64, p: u32| (value / scale).powi(p as i32) - (at / scale).powi(p as i32);
        let n = powers.len();
        let laws = DMatrix::from_fn(n, n, |i, j| law(values[i], powers[j]));
        let Some(inverse) = laws.try_inverse().filter(|a| a.iter().all(|v| v.is_finite())) else {
            self.error(
                &format!("{key}.exports"),
                format_args!("the values of `{parameter}` do not tell the powers apart: give others"),
            );
            return None;
        };
        let mut parts: Vec<[Option<Symmetric>; 3]> = vec![[None, None, None]; n];
        for letter in 0..3 {
            if changes[..n].iter().all(|c| c[letter].is_none()) {
                continue;
            }
            for (j, part) in parts.iter_mut().enumerate() {
                let mut total = Symmetric { n: dofs.labels.len(), ..Symmetric::default() };
                for (i, change) in changes[..n].iter().enumerate() {
                    if let Some(change) = &change[letter] {
                        total = sum(&total, 1.0, change, inverse[(j, i)]);
                    }
                }
                part[letter] = Some(total);
            }
        }
        for (i, (change, value)) in changes.iter().zip(&values).enumerate().skip(n) {
            let factors: Vec<f64> = powers.iter().map(|p| law(*value, *p)).collect();
            let place = format!("{key}.exports[{i}]");
            let powers: Vec<String> = powers.iter().map(u32::to_string).collect();
            let words = if n == 1 { "power" } else { "powers" };
            let told = format!("they do not go with the {words} {} of `{parameter}`", powers.join(", "));
            let parts: Vec<_> = parts.iter().map(|[k, m, c]| [k.as_ref(), m.as_ref(), c.as_ref()]).collect();
            self.tell_if_off(&place, &told, change, &parts, &factors);
        }
        if parts.iter().flatten().all(Option::is_none) {
            self.error(key, "an export needs a matrix `k`, `m` or `c`");
            return None;
        }
        // From powers of the ratio to the largest value to those of the ratio to the superelement's own.
        let of = |(p, part): (&u32, [Option<Symmetric>; 3])| {
            let own = if at == 0.0 { 1.0 / scale } else { at / scale };
            let factor = own.powi(*p as i32);
            let [k, m, c] = part.map(|a| {
                a.map(|mut a| {
                    a.lower.iter_mut().for_each(|e| e.value *= factor);
                    Arc::new(a)
                })
            });
            (*p, ExportedMatrices { k, m, c })
        };
        Some(powers.iter().zip(parts).map(of).collect())
    }

    /// A warning for each matrix whose change is farther from the sum of parts than rounding.
    fn tell_if_off(
        &mut self,
        key: &str,
        told: &str,
        change: &[Option<Symmetric>; 3],
        parts: &[[Option<&Symmetric>; 3]],
        factors: &[f64],
    ) {
        for (letter, name) in ["k", "m", "c"].into_iter().enumerate() {
            let Some(change) = &change[letter] else { continue };
            let mut off = change.clone();
            for (part, factor) in parts.iter().zip(factors) {
                if let Some(part) = part[letter] {
                    off = sum(&off, 1.0, part, -factor);
                }
            }
            let off = norm(&off) / norm(change).max(f64::MIN_POSITIVE);
            if off > AFFINE {
                self.problems.push(Problem::warning(
                    child(self.path, &format!("{key}.{name}")),
                    format_args!(
                        "{told}: this export is {} % of its change away from what the others predict",
                        percent(off)
                    ),
                ));
            }
        }
    }

    /// Compares whole matrices at values of several parameters with the sum of the terms.
    pub(super) fn checks(
        &mut self,
        entry: &SuperelementSpec,
        dofs: &Dofs,
        units: &Units,
        base: &ExportedMatrices,
        terms: &[ExportedTerm],
    ) -> Option<()> {
        for (i, check) in entry.checks.iter().enumerate() {
            let key = format!("checks[{i}]");
            let stray = check.at.keys().find(|name| terms.iter().all(|t| t.parameter != **name));
            if let Some(name) = stray {
                let names = terms.iter().map(|t| t.parameter.as_str());
                let suggestion = did_you_mean(name, names);
                self.error(&format!("{key}.at.{name}"), format_args!("no term goes with `{name}`{suggestion}"));
                return None;
            }
            let (mut parts, mut factors) = (Vec::new(), Vec::new());
            for term in terms {
                let Some(value) = check.at.get(&term.parameter) else {
                    self.error(
                        &format!("{key}.at"),
                        format_args!("the value of `{}` is missing, which a term goes with", term.parameter),
                    );
                    return None;
                };
                let value = self.value_of(value, &term.parameter, &format!("{key}.at.{}", term.parameter))?;
                for (power, ExportedMatrices { k, m, c }) in &term.parts {
                    let included = if term.is_included { 1.0 } else { 0.0 };
                    factors.push((value / term.reference).powi(*power as i32) - included);
                    parts.push([k.as_deref(), m.as_deref(), c.as_deref()]);
                }
            }
            let Matrices(whole) = self.three(&key, [&check.k, &check.m, &check.c], dofs, units)?;
            let change = changed(&whole, base, dofs.labels.len());
            self.tell_if_off(&key, "the terms do not add up", &change, &parts, &factors);
        }
        Some(())
    }
}

/// Whole matrices less those of the superelement, where they are given.
fn changed(whole: &[Option<Arc<Symmetric>>; 3], base: &ExportedMatrices, n: usize) -> [Option<Symmetric>; 3] {
    let empty = Symmetric { n, ..Symmetric::default() };
    let less = |i: usize, own: &Option<Arc<Symmetric>>| {
        whole[i].as_ref().map(|w| sum(w, 1.0, own.as_deref().unwrap_or(&empty), -1.0))
    };
    [less(0, &base.k), less(1, &base.m), less(2, &base.c)]
}

/// A share in per cent with two digits.
fn percent(share: f64) -> String {
    let value = 100.0 * share;
    if value < 0.01 { format!("{value:.1e}") } else { format!("{value:.2}") }
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
