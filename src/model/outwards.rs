//! The way outwards over neighbours: shortest paths from a few of many points.
//!
//! # Source
//! E. W. Dijkstra, A note on two problems in connexion with graphs, Numerische Mathematik 1, 1959.

use super::geometry::{Vector, dot, minus};
use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashSet};

/// Points by the length of the shortest path from the nearest seed, each once with that seed. Of two as far, that of the first seed comes first.
pub(crate) struct Outwards<P, N> {
    /// Where a point is.
    place: P,
    /// The neighbours of a point.
    neighbours: N,
    open: BinaryHeap<Reached>,
    known: HashSet<usize>,
}

impl<P, N, I> Outwards<P, N>
where
    P: Fn(usize) -> Vector,
    N: Fn(usize) -> I,
    I: IntoIterator<Item = usize>,
{
    pub(crate) fn new(seeds: &[usize], place: P, neighbours: N) -> Self {
        let open = seeds.iter().enumerate().map(|(seed, &at)| Reached { distance: 0.0, at, seed }).collect();
        Self { place, neighbours, open, known: HashSet::new() }
    }
}

impl<P, N, I> Iterator for Outwards<P, N>
where
    P: Fn(usize) -> Vector,
    N: Fn(usize) -> I,
    I: IntoIterator<Item = usize>,
{
    type Item = Reached;

    fn next(&mut self) -> Option<Reached> {
        loop {
            let reached = self.open.pop()?;
            let Reached { distance, at, seed } = reached;
            if !self.known.insert(at) {
                continue;
            }
            let here = (self.place)(at);
            for next in (self.neighbours)(at) {
                if !self.known.contains(&next) {
                    let step = minus((self.place)(next), here);
                    self.open.push(Reached { distance: distance + dot(step, step).sqrt(), at: next, seed });
                }
            }
            return Some(reached);
        }
    }
}

/// A point that was reached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Reached {
    /// Length of the path to it.
    pub(crate) distance: f64,
    /// The point.
    pub(crate) at: usize,
    /// The seed from which the path comes, as a place in their list.
    pub(crate) seed: usize,
}

impl Eq for Reached {}

impl Ord for Reached {
    fn cmp(&self, other: &Self) -> Ordering {
        // The heap gives the largest first: that is the nearest.
        other.distance.total_cmp(&self.distance).then(other.seed.cmp(&self.seed)).then(other.at.cmp(&self.at))
    }
}

impl PartialOrd for Reached {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On a ring of six edges of a cube two seeds share the rest; the point between them goes to the first.
    #[test]
    fn points_go_to_the_nearest_seed_over_neighbours() {
        let at = |i: usize| {
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]][i]
        };
        let out: Vec<Reached> = Outwards::new(&[0, 2], at, |i| [(i + 1) % 6, (i + 5) % 6]).collect();
        let found: Vec<[usize; 3]> = out.iter().map(|r| [r.at, r.seed, r.distance as usize]).collect();
        assert_eq!(found, [[0, 0, 0], [2, 1, 0], [1, 0, 1], [5, 0, 1], [3, 1, 1], [4, 0, 2]]);
    }
}
