//! Row order with a small envelope: reverse Cuthill-McKee.
//!
//! Source: A. George, J. W. Liu, Computer Solution of Large Sparse Positive Definite Systems, 1981, sections 4.3-4.4.

use std::collections::BTreeSet;

/// The order in which the vertices of a graph are numbered: `order[new] = old`.
///
/// * `neighbours` - per vertex the others it is coupled to
pub(super) fn reverse_cuthill_mckee(neighbours: &[BTreeSet<usize>]) -> Vec<usize> {
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
