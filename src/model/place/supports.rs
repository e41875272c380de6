//! How much supports give.

use super::Placer;
use crate::catalogue::did_you_mean;
use crate::element::Dof;
use crate::model::placed_element::Compliance;
use crate::model::value::Value;
use crate::yaml::{Problem, child};
use std::collections::HashSet;

impl Placer<'_> {
    /// One entry a held dof; what several entries say of it is in series.
    pub(super) fn supports(&mut self) {
        let held = self.held();
        for (name, support) in &self.spec.supports {
            let path = child("supports", name);
            for (direction, scalar) in &support.compliance {
                let path = format!("{path}.compliance.{direction}");
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
                if !support.holds(dof) && support.fixed.as_ref().is_some_and(|all| !all.is_empty()) {
                    let why =
                        format_args!("the support does not hold `{direction}`: add it to `fixed`, or leave this out");
                    self.error(path, why);
                    continue;
                }
                let mut loose = None;
                for name in support.nodes() {
                    // A node that is not there is said where supports hold.
                    let Some(node) = self.geometry.node(name) else { continue };
                    let dof = 6 * node + dof as usize;
                    match self.compliances.iter_mut().find(|c| c.dof == dof) {
                        Some(known) => known.value.addends.push(affine.clone()),
                        None => self.compliances.push(Compliance { dof, value: Value::of(affine.clone()) }),
                    }
                    if !held.contains(&dof) {
                        loose.get_or_insert(name);
                    }
                }
                if let Some(node) = loose {
                    let why = format_args!(
                        "no support holds `{node}.{direction}`, so that its compliance changes nothing: leave out `fixed: []`, or name the direction there"
                    );
                    self.problems.push(Problem::warning(path, why));
                }
            }
        }
    }

    /// The dofs that supports hold, 6 n + i of node n.
    fn held(&self) -> HashSet<usize> {
        let of = |(node, dof): (&String, Dof)| Some(6 * self.geometry.node(node)? + dof as usize);
        let all = self.spec.supports.values().flat_map(|support| {
            let held = Dof::ALL.into_iter().filter(|dof| support.holds(*dof));
            held.flat_map(|dof| support.nodes().map(move |node| (node, dof)))
        });
        all.filter_map(of).collect()
    }
}
