//! Exact elimination of constraints: u = T q.
//!
//! Every dof of the full model is a combination of independent dofs. Supports, inactive dofs, rigid links and multipoint
//! constraints are rows of one homogeneous system A u = 0; each row is reduced by the rows before it and eliminates
//! one dof, the one it asks for where that is still free, else its largest. No penalty and no stiff beam is involved.

use super::dof_map::{Combination, rigid_motion};
use super::geometry::{Geometry, minus, unknown};
use super::placed_element::{Compliance, Holder};
use super::spec::{DofName, ModelSpec};
use crate::element::Dof;
use crate::yaml::{Problem, child};
use std::collections::{BTreeMap, HashMap};

/// The elimination in progress.
#[derive(Debug, Default)]
pub(super) struct Elimination {
    /// Eliminated dof -> combination of dofs of which some may have been eliminated since: [`Self::resolve`] looks further.
    expressions: HashMap<usize, Combination>,
    /// The first of the dofs that are eliminated only where nothing else can be.
    last_resort: Option<usize>,
}

/// What became of a constraint row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum RowOutcome {
    /// It eliminated this dof.
    Eliminated(usize),
    /// It follows from the rows before it.
    Redundant,
}

impl Elimination {
    /// One in which dofs from this one on stay as long as any other can be eliminated.
    pub(super) fn keeping(last_resort: usize) -> Self {
        Self { last_resort: Some(last_resort), ..Self::default() }
    }

    /// Holds a dof at zero.
    pub(super) fn fix(&mut self, dof: usize) -> RowOutcome {
        self.constrain(&[(dof, 1.0)])
    }

    /// Adds the row Σ factor · dof = 0; its first dof is eliminated if it can be.
    pub(super) fn constrain(&mut self, row: &[(usize, f64)]) -> RowOutcome {
        let scale = row.iter().map(|t| t.1.abs()).fold(0.0, f64::max);
        for (dof, _) in row {
            self.resolve(*dof);
        }
        let mut reduced: BTreeMap<usize, f64> = BTreeMap::new();
        for &(dof, factor) in row {
            self.add(&mut reduced, dof, factor);
        }
        // Coefficients that cancel up to rounding are zero.
        reduced.retain(|_, f| f.abs() > 1e-12 * scale);
        let wanted = row.first().map(|t| t.0).filter(|d| reduced.contains_key(d));
        let is_kept = |dof: usize| self.last_resort.is_some_and(|first| dof >= first);
        let largest = || {
            let rank = |(d, f): (&usize, &f64)| (!is_kept(*d), f.abs());
            let order = |a: (bool, f64), b: (bool, f64)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1));
            reduced.iter().max_by(|a, b| order(rank(*a), rank(*b))).map(|(d, _)| *d)
        };
        let Some(pivot) = wanted.or_else(largest) else { return RowOutcome::Redundant };
        let factor = reduced.remove(&pivot).unwrap_or(1.0);
        let expression: Combination = reduced.into_iter().map(|(d, f)| (d, -f / factor)).collect();
        self.expressions.insert(pivot, expression);
        RowOutcome::Eliminated(pivot)
    }

    /// Adds a resolved dof times a factor.
    fn add(&self, sum: &mut BTreeMap<usize, f64>, dof: usize, factor: f64) {
        match self.expressions.get(&dof) {
            None => *sum.entry(dof).or_default() += factor,
            Some(expression) => expression.iter().for_each(|&(d, f)| *sum.entry(d).or_default() += factor * f),
        }
    }

    /// Makes the expression of a dof one of dofs that are not eliminated, and so those that it goes through: the next one that asks
    /// finds them ready, so that a chain of links costs the same in any order.
    fn resolve(&mut self, dof: usize) {
        let mut waiting = vec![dof];
        while let Some(&dof) = waiting.last() {
            let Some(expression) = self.expressions.get(&dof) else {
                waiting.pop();
                continue;
            };
            let is_final =
                |d: &usize| self.expressions.get(d).is_none_or(|e| !e.iter().any(|t| self.is_eliminated(t.0)));
            let before = waiting.len();
            let open: Vec<usize> = expression.iter().map(|t| t.0).filter(|d| !is_final(d)).collect();
            waiting.extend(open);
            if waiting.len() > before {
                continue;
            }
            if expression.iter().any(|t| self.is_eliminated(t.0)) {
                let mut sum = BTreeMap::new();
                for &(d, f) in expression {
                    self.add(&mut sum, d, f);
                }
                self.expressions.insert(dof, sum.into_iter().filter(|(_, f)| *f != 0.0).collect());
            }
            waiting.pop();
        }
    }

    fn is_eliminated(&self, dof: usize) -> bool {
        self.expressions.contains_key(&dof)
    }

    /// Resolves all expressions, so that [`Self::express`] is final.
    fn finish(&mut self) {
        let mut all: Vec<usize> = self.expressions.keys().copied().collect();
        all.sort_unstable();
        for dof in all {
            self.resolve(dof);
        }
    }

    /// A dof as a combination of dofs that are not eliminated, once [`Self::finish`] is done.
    pub(super) fn express(&self, dof: usize) -> Combination {
        self.expressions.get(&dof).cloned().unwrap_or_else(|| vec![(dof, 1.0)])
    }
}

/// The dofs that exist in the model.
pub(super) fn active(spec: &ModelSpec) -> [bool; 6] {
    let mut active = [spec.active_dofs.is_none(); 6];
    for d in spec.active_dofs.iter().flatten() {
        active[*d as usize] = true;
    }
    active
}

/// All constraints of a file.
///
/// * `released` - held dofs of which the i-th is held to dof 6 `n_nodes` + i instead of zero
/// * `rows` - sums of dofs that are zero because superelements and ties say so
pub(super) fn eliminate(
    spec: &ModelSpec,
    geometry: &Geometry,
    mut elimination: Elimination,
    released: &[Compliance],
    rows: &[Vec<(usize, f64)>],
    problems: &mut Vec<Problem>,
) -> Elimination {
    let active = active(spec);
    for dof in (0..6 * geometry.names.len()).filter(|d| !active[d % 6] && !geometry.is_coordinate(d / 6)) {
        elimination.fix(dof);
    }
    for row in rows {
        elimination.constrain(row);
    }
    let all = [DofName::Ux, DofName::Uy, DofName::Uz, DofName::Rx, DofName::Ry, DofName::Rz];
    let find = |name: &str, path: &str, problems: &mut Vec<Problem>| {
        let found = geometry.node(name);
        if found.is_none() {
            problems.push(unknown(path, "node", name, &geometry.names));
        }
        found
    };
    // The extra dof by which a held one is known to give.
    let place: HashMap<(Holder, usize), usize> =
        released.iter().enumerate().map(|(i, c)| ((c.holder, c.dof), i)).collect();
    let gives = |holder: Holder, dof: usize| place.get(&(holder, dof)).map(|i| (6 * geometry.names.len() + i, -1.0));
    for (name, link) in spec.rigid_links.iter().filter(|(_, link)| !link.is_compliance_of_others()) {
        let path = child("rigid_links", name);
        let master = find(&link.master, &child(&path, "master"), problems);
        for (i, slave_name) in link.slaves.iter().enumerate() {
            let slave_path = format!("{path}.slaves[{i}]");
            let slave = find(slave_name, &slave_path, problems);
            let (Some(master), Some(slave)) = (master, slave) else { continue };
            if master == slave {
                problems.push(Problem::error(&slave_path, format_args!("node `{slave_name}` cannot follow itself")));
                continue;
            }
            let arm = minus(geometry.positions[slave], geometry.positions[master]);
            let mut redundant = true;
            for d in link.dofs.as_deref().unwrap_or(&all).iter().filter(|d| active[**d as usize]) {
                let d = *d as usize;
                let mut row = vec![(6 * slave + d, 1.0)];
                for motion in 0..6 {
                    let factor = rigid_motion(arm, motion)[d];
                    if factor != 0.0 {
                        row.push((6 * master + motion, -factor));
                    }
                }
                row.extend(gives(Holder::Link, 6 * slave + d));
                redundant &= elimination.constrain(&row) == RowOutcome::Redundant;
            }
            if redundant {
                problems.push(Problem::warning(
                    &slave_path,
                    format_args!("node `{slave_name}` follows already from other links; this one adds nothing"),
                ));
            }
        }
    }
    for (name, link) in &spec.weighted_links {
        let rows = super::weighted_link::rows((name, link), geometry, spec, problems);
        for row in rows.iter().filter(|row| active[row[0].0 % 6]) {
            elimination.constrain(row);
        }
    }
    for (name, constraint) in &spec.constraints {
        let path = child("constraints", name);
        let mut row = Vec::new();
        for (i, term) in constraint.terms.iter().enumerate() {
            if !term.factor.is_finite() || term.factor == 0.0 {
                problems.push(Problem::error(
                    format!("{path}.terms[{i}].factor"),
                    "a factor must be a finite number other than zero",
                ));
            } else if let Some(node) = find(&term.node, &format!("{path}.terms[{i}].node"), problems) {
                row.push((6 * node + term.dof as usize, term.factor));
            }
        }
        if row.is_empty() {
            problems.push(Problem::error(
                child(&path, "terms"),
                "a constraint needs at least one term `{node: n1, dof: uz, factor: 1}`",
            ));
        } else if row.len() == constraint.terms.len() && elimination.constrain(&row) == RowOutcome::Redundant {
            problems.push(Problem::warning(&path, "it follows already from other constraints; it adds nothing"));
        }
    }
    for (name, support) in &spec.supports {
        let path = child("supports", name);
        let nodes: Vec<(&String, String)> = match (&support.node, &support.nodes) {
            (Some(node), None) => vec![(node, child(&path, "node"))],
            (None, Some(nodes)) => nodes.iter().enumerate().map(|(i, n)| (n, format!("{path}.nodes[{i}]"))).collect(),
            _ => {
                problems.push(Problem::error(&path, "give `node` or `nodes`"));
                continue;
            }
        };
        for (node_name, node_path) in nodes {
            let Some(node) = find(node_name, &node_path, problems) else { continue };
            for d in support.fixed.as_deref().unwrap_or(&all) {
                let dof = 6 * node + Dof::from(*d) as usize;
                match gives(Holder::Support, dof) {
                    Some(more) => elimination.constrain(&[(dof, 1.0), more]),
                    None => elimination.fix(dof),
                };
            }
        }
    }
    elimination.finish();
    elimination
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_of_constraints_resolve_in_any_order() {
        // u0 = u1, u1 = 2 u2, and u2 = u3 - u4.
        let rows: [&[(usize, f64)]; 3] =
            [&[(0, 1.0), (1, -1.0)], &[(1, 1.0), (2, -2.0)], &[(2, 1.0), (3, -1.0), (4, 1.0)]];
        for order in [[0, 1, 2], [2, 1, 0], [1, 2, 0]] {
            let mut e = Elimination::default();
            for i in order {
                assert!(matches!(e.constrain(rows[i]), RowOutcome::Eliminated(_)));
            }
            e.finish();
            assert_eq!(e.express(0), [(3, 2.0), (4, -2.0)]);
            assert_eq!(e.express(1), [(3, 2.0), (4, -2.0)]);
        }
    }

    /// 60 000 links, each to the node that the next one takes away, in either order; eager substitution took the square of that.
    #[test]
    fn long_chains_cost_the_same_in_any_order() {
        let n = 60_000;
        let start = std::time::Instant::now();
        for backwards in [false, true] {
            let mut e = Elimination::default();
            for i in 0..n {
                let i = if backwards { n - 1 - i } else { i };
                assert_eq!(e.constrain(&[(i, 1.0), (i + 1, -1.0)]), RowOutcome::Eliminated(i));
            }
            e.finish();
            assert!((0..n).all(|i| e.express(i) == [(n, 1.0)]));
        }
        assert!(start.elapsed() < std::time::Duration::from_secs(20), "{:?}", start.elapsed());
    }

    #[test]
    fn a_row_that_follows_from_others_is_redundant() {
        let mut e = Elimination::default();
        e.constrain(&[(0, 1.0), (1, -1.0)]);
        e.constrain(&[(1, 1.0), (2, -1.0)]);
        assert_eq!(e.constrain(&[(0, 1.0), (2, -1.0)]), RowOutcome::Redundant);
        // Its first dof is gone already: another is eliminated.
        assert_eq!(e.fix(0), RowOutcome::Eliminated(2));
        e.finish();
        assert!(e.express(1).is_empty());
    }
}
