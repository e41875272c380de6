//! A link that the model has as rigid and that gives.

use super::edit::{Edit, PatchError};
use super::end_flexibility::flexible_end;
use super::location::{Location, LocationKind};
use super::patch::{Builder, Patch, entry};
use super::structure::{Joint, Structure};
use super::{About, Effect};
use crate::element::Dof;
use crate::model::spec::RigidLinkSpec;

#[doc = "A rigid link, or the attachment of a member to it, that gives in one direction."]
#[derive(Debug, Clone, Copy)]
pub struct LinkFlexibility;

impl Effect for LinkFlexibility {
    fn name(&self) -> &'static str {
        "link-flexibility"
    }

    fn about(&self) -> About {
        About {
            summary: "A rigid link, or the attachment of a member to it, that gives in one direction.",
            signature: "Relative motion across the link: the member's root turns or moves against the body, in modes \
                    that load it.",
            formulation: "The end of the member at the link is joined to it by a spring of compliance c along or about \
                    one of the member's axes, condensed exactly; c = 0 leaves it. Where a member goes on over the node \
                    that the link carries, or several members meet there, the link itself gives: `rigid_links: {...: {master: m, \
                    slaves: [n], dofs: [], compliance: {ry: c}}}`, along or about global axes at that node, u = -c/(1 + c K_uu) K_uq q. \
                    A link that carries a mass alone gives \
                    nothing by that: a mass on a flexible bracket needs a node of its own, on a spring.",
            confusable: &[
                "root-flexibility",
                "joint-flexibility",
                "bending-stiffness-change",
                "torsion-stiffness-change",
            ],
            references: &[
                "H. Ahmadian, J. E. Mottershead, M. I. Friswell, Joint modelling for finite element model updating, IMAC XIV, 1996",
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        let mut all = structure.end_places(Joint::Link, &Dof::ALL);
        all.extend(structure.shared_links());
        all
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        if at.kind != LocationKind::Node {
            return flexible_end(self.name(), structure, at, |_| 0.0);
        }
        let unknown = || PatchError::unknown_place(self.name(), &at.to_string(), &[]);
        let dof = Dof::from_name(at.direction()).ok_or_else(unknown)?;
        let soft = 1.0 / structure.generalised_stiffness(dof);
        let mut b = Builder::new(self.name(), at);
        let about = format!("compliance of the link that carries {} in {dof}", at.place());
        let c = b.parameter("compliance", dof.compliance_unit(), 0.05 * soft, [0.0, 50.0 * soft], &about);
        for (i, slave) in at.names.iter().enumerate() {
            let master = structure.leader_of(slave, dof).ok_or_else(unknown)?.to_string();
            let suffix = if at.names.len() > 1 { format!(".{}", i + 1) } else { String::new() };
            let name = format!("{}{suffix}", b.stem());
            let (slaves, compliance) = (vec![slave.clone()], entry(at.direction(), &c));
            b.edit(Edit::AddRigidLink {
                name,
                entry: RigidLinkSpec { master, slaves, dofs: Some(Vec::new()), compliance },
            });
        }
        Ok(b.finish())
    }
}
