//! What hangs on nothing after a part of a structure was taken away.

use super::spec::{ModelSpec, NodeSpec, SpringSpec};
use std::collections::{HashMap, HashSet};

/// Takes out masses, springs, links and constraints of nodes that were connected to a beam, a bar, an element or a support in
/// `before` and no longer are; whether a mass was among them.
///
/// A structure without such parts, a chain of masses and springs, is left as it is.
pub(super) fn drop_loose(spec: &mut ModelSpec, before: &ModelSpec) -> bool {
    let (then, now) = (attached(before), attached(spec));
    let loose: HashSet<String> = then.difference(&now).cloned().collect();
    if loose.is_empty() {
        return false;
    }
    let is_loose = |n: &String| loose.contains(n);
    let hangs = |s: &SpringSpec| s.node.iter().chain(s.nodes.iter().flatten()).any(is_loose);
    spec.springs.retain(|_, s| !hangs(s));
    spec.bushings.retain(|_, s| !hangs(s));
    spec.constraints.retain(|_, c| !c.terms.iter().any(|t| is_loose(&t.node)));
    spec.weighted_links.retain(|_, link| !link.nodes().any(is_loose));
    spec.ties.retain(|_, tie| {
        tie.nodes.retain(|n| !is_loose(n));
        !tie.nodes.is_empty()
    });
    spec.rigid_links.retain(|_, link| {
        link.slaves.retain(|s| !is_loose(s));
        !is_loose(&link.master) && !link.slaves.is_empty()
    });
    let mut had_mass = false;
    // Members that stay keep their order and get new numbers.
    let mut numbers: HashMap<String, Vec<Option<usize>>> = HashMap::new();
    spec.masses.retain(|name, mass| {
        if let Some(nodes) = &mut mass.nodes {
            let mut next = 0;
            let kept: Vec<Option<usize>> = nodes
                .iter()
                .map(|n| {
                    (!is_loose(n)).then(|| {
                        next += 1;
                        next
                    })
                })
                .collect();
            had_mass |= next < nodes.len();
            nodes.retain(|n| !is_loose(n));
            numbers.insert(name.clone(), kept);
            return next > 0;
        }
        let gone = mass.node.as_ref().is_some_and(is_loose);
        had_mass |= gone;
        if gone {
            numbers.insert(name.clone(), Vec::new());
        }
        !gone
    });
    spec.forget(|n| {
        let Some((entry, kept)) = numbers.iter().find(|(e, _)| n == *e || member_number(n, e).is_some()) else {
            return Some(n.to_string());
        };
        match member_number(n, entry) {
            Some(k) => kept.get(k.wrapping_sub(1)).copied().flatten().map(|k| format!("{entry}.{k}")),
            None => kept.iter().any(Option::is_some).then(|| n.to_string()),
        }
    });
    had_mass
}

/// The number k of `entry.k`.
pub(super) fn member_number(name: &str, entry: &str) -> Option<usize> {
    name.strip_prefix(entry)?.strip_prefix('.')?.parse().ok()
}

/// Nodes that are connected to a beam, a bar, an element or a support.
fn attached(spec: &ModelSpec) -> HashSet<String> {
    let mut out: HashSet<String> = HashSet::new();
    let mut links: Vec<Vec<&String>> = Vec::new();
    for member in spec.beams.values().chain(spec.bars.values()) {
        out.extend(member.nodes.iter().flatten().cloned());
        out.extend(member.pairs.iter().flatten().flatten().cloned());
        out.extend(member.chain.iter().flatten().cloned());
    }
    out.extend(spec.elements.values().flat_map(|e| e.nodes.iter().cloned()));
    out.extend(on_superelements(spec));
    out.extend(on_mesh(spec));
    for s in spec.supports.values() {
        out.extend(s.nodes().cloned());
    }
    out.extend(spec.ties.values().flat_map(|t| t.nodes.iter().cloned()));
    links.extend(spec.springs.values().chain(spec.bushings.values()).map(|s| s.nodes.iter().flatten().collect()));
    links.extend(spec.rigid_links.values().map(|l| std::iter::once(&l.master).chain(&l.slaves).collect()));
    links.extend(spec.weighted_links.values().map(|l| l.nodes().collect()));
    links.extend(spec.constraints.values().map(|c| c.terms.iter().map(|t| &t.node).collect()));
    // Springs to ground hold nothing that has no stiffness of its own.
    let mut links_of: HashMap<&String, Vec<usize>> = HashMap::new();
    for (i, link) in links.iter().enumerate() {
        for n in link {
            links_of.entry(n).or_default().push(i);
        }
    }
    let mut reached: Vec<String> = out.iter().cloned().collect();
    while let Some(node) = reached.pop() {
        for i in links_of.remove(&node).unwrap_or_default() {
            for n in std::mem::take(&mut links[i]) {
                if out.insert(n.clone()) {
                    reached.push(n.clone());
                }
            }
        }
    }
    out
}

/// What the file names of the nodes of a mesh: those of its own rules, and every name that is not a node of the file.
fn on_mesh(spec: &ModelSpec) -> Vec<String> {
    if spec.mesh.is_none() {
        return Vec::new();
    }
    let of_masses = spec.masses.values().flat_map(|m| m.node.iter().chain(m.nodes.iter().flatten()));
    let springs = spec.springs.values().chain(spec.bushings.values());
    let of_springs = springs.flat_map(|s| s.node.iter().chain(s.nodes.iter().flatten()));
    let of_links = spec.rigid_links.values().flat_map(|l| std::iter::once(&l.master).chain(&l.slaves));
    let of_weights = spec.weighted_links.values().flat_map(super::spec::WeightedLinkSpec::nodes);
    let of_constraints = spec.constraints.values().flat_map(|c| c.terms.iter().map(|t| &t.node));
    let all = of_masses.chain(of_springs).chain(of_links).chain(of_weights).chain(of_constraints);
    let is_of_mesh = |name: &&String| match spec.nodes.get(*name) {
        Some(NodeSpec::Rule(rule)) => rule.mesh.is_some() || rule.nearest.is_some(),
        Some(NodeSpec::At(_)) => false,
        None => true,
    };
    all.filter(is_of_mesh).cloned().collect()
}

/// Nodes of superelements that the file names, and those that are, or may be, attached to them.
fn on_superelements(spec: &ModelSpec) -> Vec<String> {
    let is_own = |node: &&String| {
        let of = |name: &String| node.strip_prefix(name.as_str()).is_some_and(|rest| rest.starts_with('.'));
        spec.superelements.keys().any(of)
    };
    let springs = spec.springs.values().chain(spec.bushings.values());
    let named = springs.flat_map(|s| s.node.iter().chain(s.nodes.iter().flatten()));
    let named = named.chain(spec.masses.values().flat_map(|m| m.node.iter().chain(m.nodes.iter().flatten())));
    let named = named.chain(spec.rigid_links.values().flat_map(|l| std::iter::once(&l.master).chain(&l.slaves)));
    let named = named.chain(spec.constraints.values().flat_map(|c| c.terms.iter().map(|t| &t.node)));
    let mut out: Vec<String> = named.filter(is_own).cloned().collect();
    for entry in spec.superelements.values() {
        out.extend(entry.attach.keys().cloned());
        if entry.attach_within.is_some() {
            out.extend(spec.nodes.keys().cloned());
        }
    }
    out
}
