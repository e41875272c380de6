//! The places of the nodes of a file, by their rules.
//!
//! A coordinate may name parameters, and rules carry them on: the mirror image of a node that moves moves, and so does what stands between two.

use super::{Frame, Geometry, Place, Vector, between, constant, on_superelement, still, unknown};
use crate::model::affine::Affine;
use crate::model::known::Known;
use crate::model::spec::{ModelSpec, NodeRule, NodeSpec, OneOrThree};
use crate::units::Scalar;
use crate::yaml::{Problem, child};
use std::collections::{BTreeMap, HashSet};

/// Where every node of a file stands, in its order; `None` for one without a place.
///
/// * `lines` - a point and a direction each
pub(super) fn places(
    spec: &ModelSpec,
    lines: &BTreeMap<&str, (Vector, Vector)>,
    geometry: &Geometry,
    known: &Known<'_>,
    problems: &mut Vec<Problem>,
) -> Vec<Option<Place>> {
    for (own, entry) in &spec.node_offsets {
        let path = child(&child("node_offsets", own), "node");
        match spec.nodes.get(&entry.node) {
            None => problems.push(unknown(&path, "node", &entry.node, spec.nodes.keys())),
            Some(NodeSpec::Rule(r)) if r.coordinate.is_some() || r.mesh.is_some() || r.nearest.is_some() => {
                let text = format_args!("node `{}` is a coordinate or one of the mesh: it stays", entry.node);
                problems.push(Problem::error(path, text));
            }
            Some(_) => {}
        }
    }
    let resolver = Resolver { spec, lines, geometry, known };
    let mut placed = BTreeMap::new();
    spec.nodes.keys().map(|name| resolver.place(name, &mut placed, problems)).collect()
}

struct Resolver<'a> {
    spec: &'a ModelSpec,
    lines: &'a BTreeMap<&'a str, (Vector, Vector)>,
    geometry: &'a Geometry,
    known: &'a Known<'a>,
}

impl Resolver<'_> {
    /// The place of a node, found once: a node without one is complained of once. Those that its rule names come first, on a list of
    /// their own and not by recursion: a chain of rules may be as long as the file.
    fn place(
        &self,
        name: &str,
        placed: &mut BTreeMap<String, Option<Place>>,
        problems: &mut Vec<Problem>,
    ) -> Option<Place> {
        let mut open = vec![name];
        let mut is_open = HashSet::from([name]);
        while let Some(&current) = open.last() {
            let next = self.named(current).find(|n| !placed.contains_key(*n));
            match next.filter(|_| !placed.contains_key(current)) {
                Some(next) if is_open.contains(next) => {
                    let from = open.iter().position(|n| *n == next).unwrap_or(0);
                    let path = child("nodes", next);
                    let chain = shortened(&open[from..]);
                    problems
                        .push(Problem::error(path, format_args!("its place depends on itself: {chain} -> `{next}`")));
                    placed.insert(next.to_string(), None);
                }
                Some(next) => {
                    open.push(next);
                    is_open.insert(next);
                }
                None => {
                    if !placed.contains_key(current) {
                        let position = self.follow(current, placed, problems);
                        placed.insert(current.to_string(), position);
                    }
                    open.pop();
                    is_open.remove(current);
                }
            }
        }
        placed.get(name).cloned().flatten()
    }

    /// The nodes of the file that the rule of a node names.
    fn named(&self, name: &str) -> impl Iterator<Item = &str> {
        let rule = match self.spec.nodes.get(name) {
            Some(NodeSpec::Rule(rule)) => Some(rule).filter(|r| rules(r) == 1),
            _ => None,
        };
        let names = rule.into_iter().flat_map(|r| {
            let one = r.mirror.iter().chain(&r.from);
            one.chain(r.between.iter().flatten()).map(String::as_str)
        });
        names.filter(|n| self.spec.nodes.contains_key(*n))
    }

    /// A length that may name parameters, or its problem (then zero).
    fn length(&self, s: &Scalar, path: &str, problems: &mut Vec<Problem>) -> Affine {
        self.known.affine(s, "m", path, problems).unwrap_or_else(|| Affine::constant(0.0))
    }

    fn coordinates(&self, v: &[Scalar; 3], path: &str, problems: &mut Vec<Problem>) -> Place {
        [0, 1, 2].map(|i| self.length(&v[i], &format!("{path}[{i}]"), problems))
    }

    /// Follows the rule of a node, whose nodes have their places.
    fn follow(
        &self,
        name: &str,
        placed: &BTreeMap<String, Option<Place>>,
        problems: &mut Vec<Problem>,
    ) -> Option<Place> {
        let path = child("nodes", name);
        let mut position = match self.spec.nodes.get(name)? {
            NodeSpec::At(position) => self.coordinates(position, &path, problems),
            NodeSpec::Rule(rule) => {
                if rules(rule) != 1 {
                    problems.push(Problem::error(
                        &path,
                        "give exactly one of `line`, `frame`, `mirror`, `from`, `between`, `coordinate`, `mesh`, `nearest`, or a position `[x, y, z]`",
                    ));
                    return None;
                }
                let uses_at = rule.line.is_some() || rule.frame.is_some();
                for (given, word, owner) in [
                    (rule.at.is_some() && !uses_at, "at", "`line` or `frame`"),
                    (rule.offset.is_some() && rule.from.is_none(), "offset", "`from`"),
                    (rule.fraction.is_some() && rule.between.is_none(), "fraction", "`between`"),
                ] {
                    if given {
                        problems.push(Problem::error(child(&path, word), format_args!("`{word}` goes with {owner}")));
                    }
                }
                let other = |key: &str, other: &str, problems: &mut Vec<Problem>| {
                    if self.spec.nodes.contains_key(other) {
                        placed.get(other).cloned().flatten()
                    } else if let Some(place) = on_superelement(self.spec, self.geometry, other) {
                        Some(still(place))
                    } else {
                        problems.push(unknown(&child(&path, key), "node", other, self.spec.nodes.keys()));
                        None
                    }
                };
                match rule {
                    // What is wrong with these was said where the mesh was read.
                    r if r.mesh.is_some() || r.nearest.is_some() => {
                        let mesh = self.spec.mesh.as_ref()?.loaded.0.as_ref()?;
                        still(mesh.position_of(name)?)
                    }
                    r if r.line.is_some() => {
                        let line = r.line.as_deref().unwrap_or_default();
                        let Some((from, direction)) = self.lines.get(line) else {
                            if !self.spec.lines.contains_key(line) {
                                problems.push(unknown(&child(&path, "line"), "line", line, self.spec.lines.keys()));
                            }
                            return None;
                        };
                        let Some(OneOrThree::One(at)) = &r.at else {
                            problems.push(Problem::error(&path, "a node on a line needs its distance, `at: 0.4 m`"));
                            return None;
                        };
                        let at = self.length(at, &child(&path, "at"), problems);
                        [0, 1, 2].map(|i| Affine::constant(from[i]).plus(direction[i], &at))
                    }
                    r if r.frame.is_some() => {
                        let name = r.frame.as_deref().unwrap_or_default();
                        let Some(frame) = self.geometry.frames.get(name) else {
                            if !self.spec.frames.contains_key(name) {
                                problems.push(unknown(&child(&path, "frame"), "frame", name, self.spec.frames.keys()));
                            }
                            return None;
                        };
                        let Some(OneOrThree::Three(at)) = &r.at else {
                            problems
                                .push(Problem::error(&path, "a node in a frame needs its position, `at: [x, y, z]`"));
                            return None;
                        };
                        in_frame(frame, &self.coordinates(at, &child(&path, "at"), problems))
                    }
                    r if r.mirror.is_some() => {
                        let p = other("mirror", r.mirror.as_deref().unwrap_or_default(), problems)?;
                        let Some((axis, plane)) = self.geometry.mirror else {
                            problems.push(Problem::error(
                                child(&path, "mirror"),
                                "a mirrored node needs the plane: write `symmetry: {normal: y}` at the top of the file",
                            ));
                            return None;
                        };
                        let mut image = p;
                        image[axis] = Affine::constant(2.0 * plane).plus(-1.0, &image[axis]);
                        image
                    }
                    NodeRule { coordinate: Some(at), .. } => {
                        still(super::vector(at, "m", &child(&path, "coordinate"), problems))
                    }
                    r if r.from.is_some() => {
                        let p = other("from", r.from.as_deref().unwrap_or_default(), problems)?;
                        let Some(offset) = &r.offset else {
                            problems.push(Problem::error(&path, "a node beside another needs `offset: [x, y, z]`"));
                            return None;
                        };
                        let offset = self.coordinates(offset, &child(&path, "offset"), problems);
                        [0, 1, 2].map(|i| p[i].plus(1.0, &offset[i]))
                    }
                    r => {
                        let [first, second] = r.between.clone().unwrap_or_default();
                        let a = other("between[0]", &first, problems);
                        let b = other("between[1]", &second, problems);
                        let (a, b) = (a?, b?);
                        let f =
                            r.fraction.as_ref().map_or(0.5, |f| constant(f, "1", &child(&path, "fraction"), problems));
                        between(&a, &b, f)
                    }
                }
            }
        };
        for (own, entry) in self.spec.node_offsets.iter().filter(|o| o.1.node == name) {
            let path = child(&child("node_offsets", own), "offset");
            let offset = self.coordinates(&entry.offset, &path, problems);
            position = [0, 1, 2].map(|i| position[i].plus(1.0, &offset[i]));
        }
        Some(position)
    }
}

/// How many rules for its place an entry has.
fn rules(rule: &NodeRule) -> usize {
    let given = [
        rule.line.is_some(),
        rule.frame.is_some(),
        rule.mirror.is_some(),
        rule.from.is_some(),
        rule.between.is_some(),
        rule.coordinate.is_some(),
        rule.mesh.is_some(),
        rule.nearest.is_some(),
    ];
    given.into_iter().filter(|g| *g).count()
}

/// "`a` -> `b` -> ... -> `z`", at most a line of it.
fn shortened(names: &[&str]) -> String {
    const SHOWN: usize = 6;
    let quoted = |n: &&str| format!("`{n}`");
    if names.len() <= SHOWN {
        return names.iter().map(quoted).collect::<Vec<_>>().join(" -> ");
    }
    let (first, last) = (&names[..SHOWN / 2], &names[names.len() - SHOWN / 2..]);
    let join = |part: &[&str]| part.iter().map(quoted).collect::<Vec<_>>().join(" -> ");
    format!("{} -> ({} more) -> {}", join(first), names.len() - SHOWN, join(last))
}

/// A place of a frame in global coordinates.
fn in_frame(frame: &Frame, own: &Place) -> Place {
    [0, 1, 2].map(|i| (0..3).fold(Affine::constant(frame.origin[i]), |sum, k| sum.plus(frame.axes[k][i], &own[k])))
}
