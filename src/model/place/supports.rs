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
        let supports = spec.supports.iter().map(|(name, support)| Giving {
            path: child("supports", name),
            holder: Holder::Support,
            nodes: support.nodes().collect(),
            holds: Dof::ALL.into_iter().filter(|dof| support.holds(*dof)).collect(),
            compliance: &support.compliance,
        });
        let links = spec.rigid_links.iter().map(|(name, link)| Giving {
            path: child("rigid_links", name),
            holder: Holder::Link,
            nodes: link.slaves.iter().collect(),
            holds: Dof::ALL.into_iter().filter(|dof| link.holds(*dof)).collect(),
            compliance: &link.compliance,
        });
        let entries: Vec<Giving<'_>> = supports.chain(links).collect();
        if entries.iter().all(|entry| entry.compliance.is_empty()) {
            return;
        }
        let held = entries.iter().flat_map(|entry| {
            let nodes = entry.nodes.iter().filter_map(|name| self.geometry.node(name));
            nodes.flat_map(move |node| entry.holds.iter().map(move |&dof| (entry.holder, 6 * node + dof as usize)))
        });
        let held: HashSet<(Holder, usize)> = held.collect();
        for entry in &entries {
            self.gives(entry, &held);
        }
    }

    /// The compliances of one entry.
    ///
    /// * `held` - the dofs that any entry holds
    fn gives(&mut self, of: &Giving<'_>, held: &HashSet<(Holder, usize)>) {
        let [entry, holds, hold, key] = match of.holder {
            Holder::Support => ["support", "holds", "hold", "fixed"],
            Holder::Link => ["link", "carries", "carry", "dofs"],
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
            if !of.holds.contains(&dof) && !of.holds.is_empty() {
                let why =
                    format_args!("the {entry} does not {hold} `{direction}`: add it to `{key}`, or leave this out");
                self.error(path, why);
                continue;
            }
            let mut loose = None;
            for name in &of.nodes {
                // A node that is not there is said where supports and links hold.
                let Some(node) = self.geometry.node(name) else { continue };
                let dof = 6 * node + dof as usize;
                if let Some(known) = self.compliances.iter_mut().find(|c| (c.holder, c.dof) == (of.holder, dof)) {
                    known.value.addends.push(affine.clone());
                } else {
                    self.compliances.push(Compliance { holder: of.holder, dof, value: Value::of(affine.clone()) });
                }
                if !held.contains(&(of.holder, dof)) {
                    loose.get_or_insert(*name);
                }
            }
            if let Some(node) = loose {
                let why = format_args!(
                    "no {entry} {holds} `{node}.{direction}`, so that its compliance changes nothing: leave out `{key}: []`, or name the direction there"
                );
                self.problems.push(Problem::warning(path, why));
            }
        }
    }
}

/// An entry that may give.
struct Giving<'a> {
    path: String,
    holder: Holder,
    nodes: Vec<&'a String>,
    /// The dofs that it holds itself; none where it says how much others give.
    holds: Vec<Dof>,
    compliance: &'a Named<Scalar>,
}
