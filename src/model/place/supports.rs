//! How much supports give.

use super::Placer;
use crate::catalogue::did_you_mean;
use crate::element::Dof;
use crate::model::elastic_support::Compliance;
use crate::model::value::Value;
use crate::yaml::{Problem, child};

impl Placer<'_> {
    /// One entry a held dof; what several entries say of it is in series.
    pub(super) fn supports(&mut self) {
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
                let unit = if dof.is_rotation() { "rad/(N m)" } else { "m/N" };
                let Some(affine) = self.affine(scalar, unit, &path) else { continue };
                let parameters = self.parameters;
                let range = |i: usize| parameters.get(i).bounds.unwrap_or([parameters.get(i).value; 2]);
                if affine.range(&range)[0] < 0.0 {
                    self.error(path, "a compliance must not be negative, anywhere within the bounds of its parameters");
                    continue;
                }
                let holds = support.fixed.as_ref().is_none_or(|all| all.iter().any(|d| Dof::from(*d) == dof));
                if !holds && support.fixed.as_ref().is_some_and(|all| !all.is_empty()) {
                    let why =
                        format_args!("the support does not hold `{direction}`: add it to `fixed`, or leave this out");
                    self.problems.push(Problem::error(path, why));
                    continue;
                }
                for node in support.node.iter().chain(support.nodes.iter().flatten()) {
                    // A node that is not there is said where supports hold.
                    let Some(node) = self.geometry.node(node) else { continue };
                    let dof = 6 * node + dof as usize;
                    match self.compliances.iter_mut().find(|c| c.dof == dof) {
                        Some(known) => known.value.addends.push(affine.clone()),
                        None => self.compliances.push(Compliance { dof, value: Value::of(affine.clone()) }),
                    }
                }
            }
        }
    }
}
