//! A node that stands elsewhere than the file says.

use super::edit::{Edit, PatchError, scalar};
use super::location::{ALONE, Location};
use super::patch::{Builder, Patch, times};
use super::structure::{ALONG, Frame, Structure};
use super::{About, Effect};
use crate::model::spec::NodeOffsetSpec;
use crate::model::{AXES, Vector, dot, plus};
use crate::units::Scalar;
use std::collections::{BTreeMap, HashSet};

/// How far it may be moved, as a share of the shortest member at it.
const MOST: f64 = 0.4;
/// A place that is farther off than this part of the size of the structure would be seen in any drawing.
const SEEN: f64 = 0.1;
/// What is worth a look: of the size of the structure, and of what is possible at most.
const USUAL: f64 = 0.02;
const SMALL: f64 = 0.25;

#[doc = "A node that stands elsewhere than the file says: a support, a joint, a tip or a mass that was measured or typed wrongly; a member that is longer or more swept."]
#[derive(Debug, Clone, Copy)]
pub struct NodePosition;

/// What is moved at a location: how far nodes go, global, for a size of one; and how large that may be, m.
struct Moved {
    steps: BTreeMap<usize, Vector>,
    room: f64,
    /// These nodes and those that follow.
    nodes: HashSet<usize>,
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
                    straight: their length and direction change, and with them K and M; in the direction `x_alone` what lies inside keeps \
                    its distance from the other end. What stands inside of a straight member moves along it. Zero leaves it.",
            confusable: &["stiffness-change", "point-mass", "distributed-mass", "root-flexibility"],
            references: &[
                "J. E. Mottershead, M. I. Friswell, G. H. T. Ng, J. A. Brandon, Geometric parameters for finite element model updating of joints and constraints, Mech. Syst. Signal Process. 10, 1996",
                "H. Ahmadian, G. M. L. Gladwell, F. Ismail, Parameter selection strategies in finite element model updating, J. Vibration and Acoustics 119, 1997",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        if structure.total_mass() <= 0.0 {
            return Vec::new();
        }
        let frame = Frame::of(structure);
        let along = |direction: &'static str| {
            let nodes = structure.nodes_of_file(|n| frame.moved(n, direction).is_some());
            nodes.into_iter().map(move |at| at.along(direction))
        };
        let directions = if structure.is_wider() { ALONE.to_vec() } else { [&AXES[..], &[ALONG]].concat() };
        let all = directions.into_iter().flat_map(along);
        let all: Vec<(Location, Moved)> =
            all.filter_map(|at| Some((at.clone(), moved(structure, &frame, &at)?))).collect();
        if all.is_empty() {
            return Vec::new();
        }
        let fixed = structure.model().fixed_places();
        all.into_iter().filter(|(_, m)| m.nodes.is_disjoint(&fixed)).map(|(at, _)| at).collect()
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let unknown = || PatchError::unknown_place(self.name(), &at.to_string(), &[]);
        let frame = Frame::of(structure);
        let Moved { steps, room, .. } = moved(structure, &frame, at).ok_or_else(unknown)?;
        let mut b = Builder::new(self.name(), at);
        let most = (MOST * room).min(SEEN * structure.extent());
        let typical = (USUAL * structure.extent()).min(SMALL * most);
        let way = match at.direction() {
            ALONG => "along its member".to_string(),
            axis => match ALONE.iter().position(|alone| *alone == axis) {
                Some(i) => format!("along {}, without the nodes inside of its members", AXES[i]),
                None => format!("along {axis}"),
            },
        };
        let about = format!("how far {} stands from its place in the file, {way}", at.place());
        let d = b.parameter("offset", "m", typical, [-most, most], &about);
        let those: Vec<(usize, Vector)> = steps.into_iter().collect();
        for (name, &(node, step)) in b.named(&those) {
            let of =
                |v: f64| if v == 0.0 { Scalar::constant(0.0) } else { scalar(&times((1e9 * v).round() / 1e9, &d)) };
            let entry = NodeOffsetSpec { node: structure.node_name(node).to_string(), offset: step.map(of) };
            b.edit(Edit::AddNodeOffset { name, entry });
        }
        Ok(b.finish())
    }
}

/// What is moved at a location; `None` where something moves with it that should not.
fn moved(structure: &Structure<'_>, frame: &Frame<'_>, at: &Location) -> Option<Moved> {
    let node = |name: &String| structure.model().geometry().node(name);
    let (all, room) = frame.moved(node(at.names.first()?)?, at.direction())?;
    let mut all = all;
    if at.names.len() > 1 {
        // What both carry, between them, goes with both.
        for (n, step) in frame.mirrored(&all)? {
            let own = all.entry(n).or_default();
            *own = plus(*own, 1.0, step);
        }
    }
    all.retain(|_, step| dot(*step, *step) > 0.0);
    let own: HashSet<usize> = all.keys().copied().collect();
    let mut steps = all.clone();
    steps.retain(|n, _| {
        let others: BTreeMap<usize, Vector> = all.iter().filter(|o| o.0 != n).map(|(n, s)| (*n, *s)).collect();
        !frame.follows(*n, &others)
    });
    let leads = at.names.iter().filter_map(node).any(|n| steps.contains_key(&n));
    (leads && frame.stands_alone(&all, &own)).then_some(Moved { steps, room, nodes: own })
}
