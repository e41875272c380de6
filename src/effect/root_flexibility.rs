//! A support that gives.

use super::edit::{Edit, PatchError};
use super::end_flexibility::flexible_end;
use super::location::{Location, LocationKind};
use super::patch::{Builder, Patch, entry, node_or_nodes, of_unit, round};
use super::structure::{Joint, Structure};
use super::{About, Belongs, Effect};
use crate::element::Dof;
use crate::model::spec::{Named, SupportSpec};

#[doc = "A clamp, bearing or root that the model has as rigid and that gives in one direction."]
#[derive(Debug, Clone, Copy)]
pub struct RootFlexibility;

impl Effect for RootFlexibility {
    fn name(&self) -> &'static str {
        "root-flexibility"
    }

    fn about(&self) -> About {
        About {
            summary: "A clamp, bearing or root that the model has as rigid and that gives in one direction.",
            signature: "Lowers all modes that load the support, the lowest most; shapes show a slope or a displacement \
                    at the root that the model lacks.",
            formulation: "The member's end is joined to the support by a spring of compliance c, condensed exactly: K' = \
                    K - c K e eᵀ K/(1 + c eᵀ K e), by `end1_compliance_ry` and so on in the member's axes; c = 0 \
                    leaves it, c of several L/EI is a hinge. Where a member goes on over the support, or several members meet \
                    there, the support itself stands on the spring: `supports: {...: {node: n, fixed: [], compliance: {uz: c}}}`, \
                    along global axes, u = -c/(1 + c K_uu) K_uq q. A footing that settles and rocks gives in all directions \
                    that are held, `column:foot.all_axes`, each by a compliance of its own; a swept root may hinge about an axis of the structure, `wing.1:root.about_x`. Of a mesh also a stretch of a support, `clamp~n81~12`, the \
                    twelve of its nodes that are nearest to n81, in all directions that it holds: a clamp that is open there.",
            confusable: &[
                "stiffness-change",
                "bending-stiffness-change",
                "torsion-stiffness-change",
                "point-rotary-inertia",
            ],
            references: &[
                "K. R. Chun, Free vibration of a beam with one end spring-hinged and the other free, J. Applied Mechanics 39, 1972",
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        let mut all = structure.end_places(Joint::Root, &Dof::ALL);
        all.extend(structure.shared_supports());
        all.extend(structure.supports_of_edges());
        all.extend(structure.stretches_of_edges());
        all
    }

    fn belongs_to(&self) -> Belongs {
        Belongs::Support
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        // What a support stands on has nothing to do with the member that ends there, which may be a short stub.
        let soft = |dof: Dof| 1.0 / structure.generalised_stiffness(dof);
        if at.kind == LocationKind::Group {
            return of_edge(self.name(), structure, at);
        }
        if at.kind != LocationKind::Node {
            return flexible_end(self.name(), structure, at, soft);
        }
        let mut b = Builder::new(self.name(), at);
        let dofs = structure.axes_at(at, &Dof::ALL, |n, dof| structure.is_shared_support(n, dof));
        if dofs.is_empty() {
            return Err(PatchError::unknown_place(self.name(), &at.to_string(), &[]));
        }
        let mut compliance = Named::new();
        for dof in &dofs {
            let soft = soft(*dof);
            let name = if dofs.len() > 1 { format!("compliance_{dof}") } else { "compliance".to_string() };
            let about = format!("compliance of the support at {} in {dof}", at.place());
            let c = b.parameter(&name, dof.compliance_unit(), 0.05 * soft, [0.0, 50.0 * soft], &about);
            compliance.extend(entry(dof.name(), &c));
        }
        let (node, nodes) = node_or_nodes(&at.names);
        let name = b.stem().to_string();
        let spring = SupportSpec { node, nodes, fixed: Some(Vec::new()), compliance };
        b.edit(Edit::AddSupport { name, entry: spring });
        Ok(b.finish())
    }
}

/// Compliance at which a stretch of a support holds nothing, against that of the whole structure.
const OPEN: f64 = 1e4;

/// A support of many nodes that gives at all of them alike: in one direction, or where the location has none in all that it holds, by one size.
fn of_edge(effect: &'static str, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
    let unknown = || PatchError::unknown_place(effect, &at.to_string(), &[]);
    let place = at.names.first().ok_or_else(unknown)?;
    let nodes = structure.nodes_of_support(place);
    let mut b = Builder::new(effect, at);
    // Each of n nodes bears an n-th of it.
    let soft = |dof: Dof| nodes.len() as f64 / structure.generalised_stiffness(dof);
    let compliance = match at.direction() {
        "" => {
            let about =
                format!("compliance of the {} nodes {place} of the support, 1: as soft as the structure", nodes.len());
            let p = b.parameter("share", "1", 0.05, [0.0, OPEN], &about);
            let dofs = structure.dofs_held_at(place).into_iter();
            dofs.flat_map(|dof| entry(dof.name(), &of_unit(round(soft(dof)), dof.compliance_unit(), &p))).collect()
        }
        direction => {
            let dof = Dof::from_name(direction).ok_or_else(unknown)?;
            let about =
                format!("compliance of each of the {} nodes of the support {} in {dof}", nodes.len(), at.place());
            let typical = 0.05 * soft(dof);
            let c = b.parameter("compliance", dof.compliance_unit(), typical, [0.0, 1000.0 * typical], &about);
            entry(direction, &c)
        }
    };
    let name = b.stem().to_string();
    let nodes = Some(structure.written_nodes(&nodes));
    let spring = SupportSpec { node: None, nodes, fixed: Some(Vec::new()), compliance };
    b.edit(Edit::AddSupport { name, entry: spring });
    Ok(b.finish())
}
