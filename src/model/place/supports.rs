//! How much supports and rigid links give.

use super::Placer;
use crate::catalogue::did_you_mean;
use crate::element::Dof;
use crate::model::placed_element::{Compliance, Holder};
use crate::model::spec::Named;
use crate::model::value::Value;
use crate::units::Scalar;
use crate::yaml::{Problem, child};
use std::collections::HashSet;

impl Placer<'_> {
    /// One entry a held dof, of supports and of rigid links; what several entries say of it is in series.
    pub(super) fn supports(&mut self) {
        let spec = self.spec;
        let held =
            self.held(spec.supports.values().map(|s| (s.nodes().collect(), Box::new(|d| s.holds(d)) as Holds<'_>)));
        for (name, support) in &spec.supports {
            let of = Giving {
                path: child("supports", name),
                compliance: &support.compliance,
                nodes: support.nodes().collect(),
                is_own: support.fixed.as_ref().is_none_or(|all| !all.is_empty()),
                holder: Holder::Support,
            };
            self.gives(&of, |dof| support.holds(dof), &held);
        }
        let held = self.held(
            spec.rigid_links.values().map(|l| (l.slaves.iter().collect(), Box::new(|d| l.holds(d)) as Holds<'_>)),
        );
        for (name, link) in &spec.rigid_links {
            let of = Giving {
                path: child("rigid_links", name),
                compliance: &link.compliance,
                nodes: link.slaves.iter().collect(),
                is_own: link.dofs.as_ref().is_none_or(|all| !all.is_empty()),
                holder: Holder::Link,
            };
            self.gives(&of, |dof| link.holds(dof), &held);
        }
    }

    /// The compliances of one entry.
    ///
    /// * `holds` - whether it holds a dof itself
    /// * `held` - the dofs that any entry of its kind holds
    fn gives(&mut self, of: &Giving<'_>, holds: impl Fn(Dof) -> bool, held: &HashSet<usize>) {
        let [entry, verb, key] = match of.holder {
            Holder::Support => ["support", "holds", "fixed"],
            Holder::Link => ["link", "carries", "dofs"],
        };
        for (direction, scalar) in of.compliance {
            let path = format!("{}.compliance.{direction}", of.path);
            let Some(dof) = Dof::from_name(direction) else {
                let suggestion = did_you_mean(direction, Dof::ALL.iter().map(|d| d.name()));
                let expected = "expected `ux`, `uy`, `uz`, `rx`, `ry` or `rz`";
                self.error(path, format_args!("unknown direction `{direction}`, {expected}{suggestion}"));
                continue;
            };
            let Some(affine) = self.affine(scalar, dof.compliance_unit(), &path) else { continue };
            if affine.range(&|i| self.parameters.get(i).range())[0] < 0.0 {
                self.error(path, "a compliance must not be negative, anywhere within the bounds of its parameters");
                continue;
            }
            if !holds(dof) && of.is_own {
                let why = format_args!(
                    "the {entry} does not {} `{direction}`: add it to `{key}`, or leave this out",
                    &verb[..verb.len() - 1]
                );
                self.error(path, why);
                continue;
            }
            let mut loose = None;
            for name in &of.nodes {
                // A node that is not there is said where supports and links hold.
                let Some(node) = self.geometry.node(name) else { continue };
                let dof = 6 * node + dof as usize;
                match self.compliances.iter_mut().find(|c| (c.holder, c.dof) == (of.holder, dof)) {
                    Some(known) => known.value.addends.push(affine.clone()),
                    None => {
                        self.compliances.push(Compliance { holder: of.holder, dof, value: Value::of(affine.clone()) })
                    }
                }
                if !held.contains(&dof) {
                    loose.get_or_insert(*name);
                }
            }
            if let Some(node) = loose {
                let why = format_args!(
                    "no {entry} {verb} `{node}.{direction}`, so that its compliance changes nothing: leave out `{key}: []`, or name the direction there"
                );
                self.problems.push(Problem::warning(path, why));
            }
        }
    }

    /// The dofs that entries hold, 6 n + i of node n.
    fn held<'a>(&self, entries: impl Iterator<Item = (Vec<&'a String>, Holds<'a>)>) -> HashSet<usize> {
        let of = |(node, dof): (&String, Dof)| Some(6 * self.geometry.node(node)? + dof as usize);
        let all = entries.flat_map(|(nodes, holds)| {
            let held: Vec<Dof> = Dof::ALL.into_iter().filter(|dof| holds(*dof)).collect();
            held.into_iter().flat_map(move |dof| nodes.clone().into_iter().map(move |node| (node, dof)))
        });
        all.filter_map(of).collect()
    }
}

/// Whether an entry holds a dof of its nodes.
type Holds<'a> = Box<dyn Fn(Dof) -> bool + 'a>;

/// An entry that may give.
struct Giving<'a> {
    path: String,
    compliance: &'a Named<Scalar>,
    nodes: Vec<&'a String>,
    /// Whether it holds anything itself.
    is_own: bool,
    holder: Holder,
}
