//! Exact elimination of constraints: u = T q.
//!
//! Every dof of the full model is a combination of independent dofs. Supports, inactive dofs, rigid links and multipoint
//! constraints are rows of one homogeneous system A u = 0; each row is reduced by the rows before it and eliminates
//! one dof, the one it asks for where that is still free, else its largest. No penalty and no stiff beam is involved.

use std::collections::BTreeMap;

/// Combination of dofs: (dof, factor), sorted by dof.
pub(super) type Combination = Vec<(usize, f64)>;

/// The elimination in progress.
#[derive(Debug, Default)]
pub(super) struct Elimination {
    /// Eliminated dof -> combination of dofs that are not eliminated.
    expressions: BTreeMap<usize, Combination>,
    /// Dof that is not eliminated -> eliminated dofs whose expressions name it.
    users: BTreeMap<usize, Vec<usize>>,
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
    /// Holds a dof at zero.
    pub(super) fn fix(&mut self, dof: usize) -> RowOutcome {
        self.constrain(&[(dof, 1.0)])
    }

    /// Adds the row Σ factor · dof = 0; its first dof is eliminated if it can be.
    pub(super) fn constrain(&mut self, row: &[(usize, f64)]) -> RowOutcome {
        let scale = row.iter().map(|t| t.1.abs()).fold(0.0, f64::max);
        let mut reduced: BTreeMap<usize, f64> = BTreeMap::new();
        for &(dof, factor) in row {
            match self.expressions.get(&dof) {
                None => *reduced.entry(dof).or_default() += factor,
                Some(expression) => {
                    for &(d, f) in expression {
                        *reduced.entry(d).or_default() += factor * f;
                    }
                }
            }
        }
        // Coefficients that cancel up to rounding are zero.
        reduced.retain(|_, f| f.abs() > 1e-12 * scale);
        let wanted = row.first().map(|t| t.0).filter(|d| reduced.contains_key(d));
        let largest = || reduced.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).map(|(d, _)| *d);
        let Some(pivot) = wanted.or_else(largest) else { return RowOutcome::Redundant };
        let factor = reduced.remove(&pivot).unwrap_or(1.0);
        let expression: Combination = reduced.into_iter().map(|(d, f)| (d, -f / factor)).collect();
        for user in self.users.remove(&pivot).unwrap_or_default() {
            self.substitute(user, pivot, &expression);
        }
        for (d, _) in &expression {
            self.users.entry(*d).or_default().push(pivot);
        }
        self.expressions.insert(pivot, expression);
        RowOutcome::Eliminated(pivot)
    }

    /// Replaces `pivot` by its expression inside the expression of `user`.
    fn substitute(&mut self, user: usize, pivot: usize, expression: &Combination) {
        let Some(old) = self.expressions.remove(&user) else { return };
        let mut sum: BTreeMap<usize, f64> = BTreeMap::new();
        for (d, f) in old {
            if d == pivot {
                for &(e, g) in expression {
                    *sum.entry(e).or_default() += f * g;
                    let users = self.users.entry(e).or_default();
                    if !users.contains(&user) {
                        users.push(user);
                    }
                }
            } else {
                *sum.entry(d).or_default() += f;
            }
        }
        self.expressions.insert(user, sum.into_iter().filter(|(_, f)| *f != 0.0).collect());
    }

    /// A dof as a combination of dofs that are not eliminated.
    pub(super) fn express(&self, dof: usize) -> Combination {
        self.expressions.get(&dof).cloned().unwrap_or_else(|| vec![(dof, 1.0)])
    }
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
            assert_eq!(e.express(0), [(3, 2.0), (4, -2.0)]);
            assert_eq!(e.express(1), [(3, 2.0), (4, -2.0)]);
        }
    }

    #[test]
    fn a_row_that_follows_from_others_is_redundant() {
        let mut e = Elimination::default();
        e.constrain(&[(0, 1.0), (1, -1.0)]);
        e.constrain(&[(1, 1.0), (2, -1.0)]);
        assert_eq!(e.constrain(&[(0, 1.0), (2, -1.0)]), RowOutcome::Redundant);
        // Its first dof is gone already: another is eliminated.
        assert_eq!(e.fix(0), RowOutcome::Eliminated(2));
        assert!(e.express(1).is_empty());
    }
}
