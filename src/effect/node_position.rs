//! A node that stands elsewhere than the file says.

use super::edit::{Edit, PatchError, scalar};
use super::location::Location;
use super::patch::{Builder, Patch, times};
use super::structure::{Frame, Structure};
use super::{About, Effect};
use crate::model::AXES;
use crate::model::spec::NodeOffsetSpec;
use crate::units::Scalar;
use std::collections::{BTreeMap, HashSet};

/// How far it may be moved, as a share of the shortest member at it.
const MOST: f64 = 0.4;
/// What is worth a look: of the size of the structure, and of what is possible at most.
const USUAL: f64 = 0.02;
const SMALL: f64 = 0.25;

#[doc = "A node that stands elsewhere than the file says: a support, a joint, a tip or a mass that was measured or typed wrongly; a member that is longer or more swept."]
#[derive(Debug, Clone, Copy)]
pub struct NodePosition;

/// What is moved at a location: nodes with their shares of the size, those of a mirror image with the sign of the axis; and how far at most, m.
struct Moved {
    shares: BTreeMap<usize, f64>,
    room: f64,
}

impl Effect for NodePosition {
    fn name(&self) -> &'static str {
        "node-position"
    }

    fn about(&self) -> About {
        About {
            summary: "A node that stands elsewhere than the file says: a support, a joint, a tip or a mass that was measured \
                    or typed wrongly; a member that is longer or more swept.",
            signature: "Modes that bend the members at the node move with the cube of their lengths; a longer tip lowers all of them, \
                    a moved support or mass raises some and lowers others.",
            formulation: "The node and what lies inside of its straight members moves along one axis, the members stay \
                    straight: their length and direction change, and with them K and M. Zero leaves it.",
            confusable: &["stiffness-change", "point-mass", "distributed-mass", "root-flexibility"],
            references: &[
                "J. E. Mottershead, M. I. Friswell, G. H. T. Ng, J. A. Brandon, Geometric parameters for finite element model updating of joints and constraints, Mech. Syst. Signal Process. 10, 1996",
                "H. Ahmadian, G. M. L. Gladwell, F. Ismail, Parameter selection strategies in finite element model updating, J. Vibration and Acoustics 119, 1997",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        if structure.is_wider() || structure.total_mass() <= 0.0 {
            return Vec::new();
        }
        let frame = Frame::of(structure);
        let along = |axis: usize| {
            let nodes = structure.nodes(|n| frame.moved(n, axis).is_some());
            nodes.into_iter().map(move |at| at.along(AXES[axis]))
        };
        (0..3).flat_map(along).filter(|at| moved(structure, &frame, at).is_some()).collect()
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let unknown = || PatchError::unknown_place(self.name(), &at.to_string(), &[]);
        let frame = Frame::of(structure);
        let Moved { shares, room } = moved(structure, &frame, at).ok_or_else(unknown)?;
        let axis = AXES.iter().position(|a| *a == at.direction()).ok_or_else(unknown)?;
        let mut b = Builder::new(self.name(), at);
        let most = MOST * room;
        let typical = (USUAL * structure.extent()).min(SMALL * most);
        let about = format!("how far {} stands from its place in the file, along {}", at.place(), at.direction());
        let d = b.parameter("offset", "m", typical, [-most, most], &about);
        let those: Vec<(usize, f64)> = shares.into_iter().collect();
        for (name, &(node, share)) in b.named(&those) {
            let mut offset = [(); 3].map(|()| Scalar::constant(0.0));
            offset[axis] = scalar(&times(share, &d));
            let entry = NodeOffsetSpec { node: structure.node_name(node).to_string(), offset };
            b.edit(Edit::AddNodeOffset { name, entry });
        }
        Ok(b.finish())
    }
}

/// What is moved at a location; `None` where something moves with it that should not.
fn moved(structure: &Structure<'_>, frame: &Frame<'_>, at: &Location) -> Option<Moved> {
    let axis = AXES.iter().position(|a| *a == at.direction())?;
    let nodes: Vec<usize> =
        at.names.iter().map(|name| structure.model().geometry().node(name)).collect::<Option<_>>()?;
    // On the plane of symmetry nothing moves across it without taking the symmetry away.
    let (mut shares, mut room) = (BTreeMap::new(), f64::INFINITY);
    for (k, &node) in nodes.iter().enumerate() {
        let (own, own_room) = frame.moved(node, axis)?;
        let sign = if k > 0 && structure.mirrors(axis) { -1.0 } else { 1.0 };
        for (n, share) in own {
            *shares.entry(n).or_default() += sign * share;
        }
        room = room.min(own_room);
    }
    shares.retain(|_, share| *share != 0.0);
    let own: HashSet<usize> = shares.keys().copied().collect();
    let all = shares.clone();
    shares.retain(|n, _| {
        let others: BTreeMap<usize, f64> = all.iter().filter(|o| o.0 != n).map(|(n, s)| (*n, *s)).collect();
        !frame.follows(*n, &others)
    });
    let leads = nodes.first().is_some_and(|first| shares.contains_key(first));
    (leads && frame.stands_alone(&all, &own)).then_some(Moved { shares, room })
}
