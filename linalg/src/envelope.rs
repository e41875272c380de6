//! The envelope of a sparse symmetric matrix, and a row order in which it is small: reverse Cuthill-McKee.
//!
//! Source: A. George, J. W. Liu, Computer Solution of Large Sparse Positive Definite Systems, 1981, sections 4.3-4.4.

// Inside kernels, see `batch`.
#![allow(clippy::inline_always)]

use std::collections::BTreeSet;

/// Which entries of the lower triangle are stored.
#[derive(Debug, Clone)]
pub(crate) struct Envelope {
    /// First stored column of every row.
    pub(crate) first: Vec<usize>,
    /// Where row i begins; one more entry than rows.
    pub(crate) start: Vec<usize>,
}

impl Envelope {
    /// The envelope with these first columns.
    pub(crate) fn new(first: Vec<usize>) -> Self {
        let mut start = Vec::with_capacity(first.len() + 1);
        let mut next = 0;
        for (i, &f) in first.iter().enumerate() {
            start.push(next);
            next += i - f + 1;
        }
        start.push(next);
        Self { first, start }
    }

    /// Number of rows.
    pub(crate) fn rows(&self) -> usize {
        self.first.len()
    }

    /// Number of stored entries.
    pub(crate) fn len(&self) -> usize {
        self.start[self.rows()]
    }

    /// Where entry (i, j), first[i] <= j <= i, is stored.
    #[inline(always)]
    pub(crate) fn at(&self, i: usize, j: usize) -> usize {
        self.start[i] + j - self.first[i]
    }

    /// The stored entries of row i.
    #[inline(always)]
    pub(crate) fn row(&self, i: usize) -> std::ops::Range<usize> {
        self.start[i]..self.start[i + 1]
    }
}

/// The order in which the vertices of a graph are numbered: `order[new] = old`.
///
/// * `neighbours` - per vertex the others it is coupled to
pub(crate) fn reverse_cuthill_mckee(neighbours: &[BTreeSet<usize>]) -> Vec<usize> {
    let n = neighbours.len();
    let mut placed = vec![false; n];
    let mut order = Vec::with_capacity(n);
    while let Some(any) = (0..n).filter(|&i| !placed[i]).min_by_key(|&i| (neighbours[i].len(), i)) {
        // A pseudo-peripheral start: walk to the far end until the depth no longer grows.
        let mut start = any;
        let mut depth = 0;
        loop {
            let levels = levels_from(start, neighbours, &placed);
            if levels.len() <= depth {
                break;
            }
            depth = levels.len();
            let Some(&far) = levels[depth - 1].iter().min_by_key(|&&i| (neighbours[i].len(), i)) else { break };
            start = far;
        }
        let begin = order.len();
        placed[start] = true;
        order.push(start);
        let mut at = begin;
        while at < order.len() {
            let mut next: Vec<usize> = neighbours[order[at]].iter().copied().filter(|&j| !placed[j]).collect();
            next.sort_by_key(|&j| (neighbours[j].len(), j));
            for j in next {
                placed[j] = true;
                order.push(j);
            }
            at += 1;
        }
    }
    order.reverse();
    order
}

fn levels_from(start: usize, neighbours: &[BTreeSet<usize>], placed: &[bool]) -> Vec<Vec<usize>> {
    let mut seen = placed.to_vec();
    seen[start] = true;
    let mut levels = vec![vec![start]];
    loop {
        let mut next = Vec::new();
        for &i in &levels[levels.len() - 1] {
            for &j in &neighbours[i] {
                if !seen[j] {
                    seen[j] = true;
                    next.push(j);
                }
            }
        }
        if next.is_empty() {
            return levels;
        }
        levels.push(next);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shuffled_chain_becomes_a_chain_again() {
        let n = 30;
        let label = |i: usize| (i * 7) % n;
        let mut neighbours = vec![BTreeSet::new(); n];
        for i in 1..n {
            neighbours[label(i)].insert(label(i - 1));
            neighbours[label(i - 1)].insert(label(i));
        }
        let order = reverse_cuthill_mckee(&neighbours);
        assert_eq!(order.iter().collect::<BTreeSet<_>>().len(), n);
        assert!(order.windows(2).all(|w| neighbours[w[0]].contains(&w[1])));
    }
}
