//! Physical effects: hypotheses of what a model lacks, each written as a small edit of the model file.
//!
//! An [`Effect`] knows where on the user's own structure it could act ([`Effect::locations`]) and which entries of the
//! file would put it there ([`Effect::patch`]). The new parameters have a neutral value, at which K, M and C are those of
//! the unchanged model, so that a hypothesis and its base are nested models. [`candidates`] places the whole catalogue.
//!
//! ```text
//! for candidate in candidates(&model, &Effects::builtin(), &Context::default()) {
//!     let patched = candidate.build(&model, &registry)?;      // the model with the effect at its neutral value
//!     let theta = patched.typical();                          // the same with the effect at its typical size
//! }
//! ```
//!
//! Damping enters as viscous C (dashpots, and in proportion to K or M of any part). Hysteretic damping, a complex K, is not
//! part of a model; its equivalent at one frequency is `stiffness-damping`, and modal damping belongs to the FRF synthesis.
//!
//! To add an effect: a file with a unit struct and `impl Effect`, `mod` and a line in [`EFFECTS`]. [`conformance::check`] holds
//! every effect to the contract on every model. An effect of your own crate is passed by [`Effects::with`]. Reading order:
//! `patch` (the edits), `structure` (what an effect may ask of a model), then any effect; `text` edits files.

mod absent_mass;
mod absent_member;
mod air_mass;
mod asymmetry;
mod axial_preload;
mod bend_twist_coupling;
mod bending_stiffness_change;
mod candidate;
pub mod conformance;
mod connection;
mod cut;
mod dashpot_change;
mod distributed_mass;
mod eccentric_mass;
mod edit;
mod end_flexibility;
mod fibre_angle;
mod flexible_mount;
mod flow;
mod ground_dashpot;
mod ground_spring;
mod joint_flexibility;
mod link_flexibility;
mod location;
mod lost_bond;
mod mass_change;
mod mass_damping;
mod mass_lumping;
mod mass_offset;
mod member_eccentricity;
mod membrane_preload;
mod node_position;
mod patch;
mod point_mass;
mod point_rotary_inertia;
mod rigid_end;
mod rigid_link;
mod root_flexibility;
mod section_rotary_inertia;
mod self_weight;
mod sensor_mass;
mod shear_flexibility;
mod softening;
mod sprung;
mod sprung_inertia;
mod sprung_mass;
mod stiffness_change;
mod stiffness_damping;
mod structure;
mod taper;
#[cfg(test)]
mod tests;
mod text;
mod thickness_change;
mod timoshenko;
mod torsion_stiffness_change;
mod turned_section;

pub use candidate::{
    Candidate, Configured, Patched, candidates, candidates_at_place, candidates_in, candidates_on_wider_places,
};
pub use edit::{Edit, NewParameter, PatchError};
pub use location::{BASE, Location, LocationKind};
pub use patch::Patch;
pub use structure::{Context, LN_OF_A_SIDE, Neighbourhood, Part, PartKind, Rigidity, SensorLoad, Structure};
pub use text::{Undone, move_files, set_parameter_values, undo};

use crate::catalogue::{catalogue, did_you_mean};
use crate::model::Model;
use crate::yaml::Problem;

catalogue! {
    /// Every built-in effect, in alphabetical order.
    EFFECTS: dyn Effect;
    absent_mass::AbsentMass,
    absent_member::AbsentMember,
    air_mass::AirMass,
    asymmetry::Asymmetry,
    axial_preload::AxialPreload,
    bend_twist_coupling::BendTwistCoupling,
    bending_stiffness_change::BendingStiffnessChange,
    connection::Connection,
    cut::Cut,
    dashpot_change::DashpotChange,
    distributed_mass::DistributedMass,
    eccentric_mass::EccentricMass,
    fibre_angle::FibreAngle,
    flexible_mount::FlexibleMount,
    ground_dashpot::GroundDashpot,
    ground_spring::GroundSpring,
    joint_flexibility::JointFlexibility,
    link_flexibility::LinkFlexibility,
    lost_bond::LostBond,
    mass_change::MassChange,
    mass_damping::MassDamping,
    mass_lumping::MassLumping,
    mass_offset::MassOffset,
    member_eccentricity::MemberEccentricity,
    membrane_preload::MembranePreload,
    node_position::NodePosition,
    point_mass::PointMass,
    point_rotary_inertia::PointRotaryInertia,
    rigid_end::RigidEnd,
    rigid_link::RigidLink,
    root_flexibility::RootFlexibility,
    section_rotary_inertia::SectionRotaryInertia,
    self_weight::SelfWeight,
    sensor_mass::SensorMass,
    shear_flexibility::ShearFlexibility,
    softening::Softening,
    sprung_inertia::SprungInertia,
    sprung_mass::SprungMass,
    stiffness_change::StiffnessChange,
    stiffness_damping::StiffnessDamping,
    taper::Taper,
    thickness_change::ThicknessChange,
    timoshenko::Timoshenko,
    torsion_stiffness_change::TorsionStiffnessChange,
    turned_section::TurnedSection,
}

/// A physical effect that a model may lack: stateless; where it could act, and how it is written.
pub trait Effect: std::fmt::Debug + Send + Sync {
    /// Its name, `kebab-case`: "point-mass".
    fn name(&self) -> &'static str;

    /// What it is, its trace in the data, how it is modelled, what it is confused with, sources.
    fn about(&self) -> About;

    /// Where on a structure it could act, in file order, symmetric partners together before each alone; only places
    /// where its typical size changes K, M or C.
    fn locations(&self, structure: &Structure<'_>) -> Vec<Location>;

    /// What it belongs to: where one structure was tested in several configurations, the supports and the rig differ.
    fn belongs_to(&self) -> Belongs {
        Belongs::Structure
    }

    /// Whether it acts where the sensors of a test stand.
    fn needs_sensors(&self) -> bool {
        false
    }

    /// Whether it damps, and changes neither K nor M: then damping ratios alone tell of it, too.
    fn damps(&self) -> bool {
        false
    }

    /// Names of the effects at the same place that it becomes at a limit of its sizes. Where one of them is more
    /// probable, it is not a hypothesis of its own. Two that name each other say one thing, and the more probable stands.
    fn becomes(&self) -> &'static [&'static str] {
        &[]
    }

    /// The name of the effect at the same place that says more plainly what it is at such sizes, where there is one: half of a member is not absent.
    ///
    /// * `intervals` - of its sizes, SI
    fn plainly(&self, _intervals: &[[f64; 2]]) -> Option<&'static str> {
        None
    }

    /// The edits that put it at one of its locations, at its neutral value.
    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError>;
}

/// What an effect belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Belongs {
    /// The structure: it is there in every configuration.
    Structure,
    /// A support: it is there where the support is.
    Support,
    /// The rig of a test: suspension, transducers.
    Rig,
}

/// What is known of an effect, for `explain`, reports and the reference page.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct About {
    /// One or two sentences: what it is.
    pub summary: &'static str,
    /// Its trace in the data: which modes move and which do not.
    pub signature: &'static str,
    /// The equation, the parameters and their neutral values.
    pub formulation: &'static str,
    /// Names of effects of the catalogue that look alike, and why in `signature`.
    pub confusable: &'static [&'static str],
    /// Author, title, year.
    pub references: &'static [&'static str],
}

/// The effects to try: the built-in ones and a user's own.
///
/// ```
/// use retune::effect::Effects;
/// assert!(Effects::builtin().find("point-mass").is_some());
/// ```
#[derive(Debug, Clone)]
pub struct Effects {
    effects: Vec<&'static dyn Effect>,
}

impl Effects {
    /// The built-in ones.
    pub fn builtin() -> Self {
        Self { effects: EFFECTS.to_vec() }
    }

    /// None; to be filled by [`Self::with`].
    pub fn none() -> Self {
        Self { effects: Vec::new() }
    }

    /// With one more; an effect of the same name replaces the built-in one.
    #[must_use]
    pub fn with(mut self, effect: &'static dyn Effect) -> Self {
        self.effects.retain(|e| e.name() != effect.name());
        self.effects.push(effect);
        self
    }

    /// The effect of a name.
    pub fn find(&self, name: &str) -> Option<&'static dyn Effect> {
        self.effects.iter().copied().find(|e| e.name() == name)
    }

    /// All of them, in order.
    pub fn iter(&self) -> impl Iterator<Item = &'static dyn Effect> + '_ {
        self.effects.iter().copied()
    }

    /// The candidate of an id such as `mass-offset@left_wing.y`, or `ground-spring@bench/n5.uz` in one configuration only.
    ///
    /// Errors: no effect of this name, or not at this place, with the nearest right word.
    pub fn candidate(&self, structure: &Structure<'_>, id: &str) -> Result<Candidate, PatchError> {
        let (name, place) = id.split_once('@').unwrap_or((id, ""));
        let Some(effect) = self.find(name) else {
            let suggestion = did_you_mean(name, self.iter().map(Effect::name));
            return Err(PatchError::UnknownEffect { name: name.to_string(), suggestion });
        };
        let configurations = &structure.model().spec().configurations;
        let known = |c: &str| configurations.contains_key(c) || (c == BASE && !configurations.is_empty());
        match place.split_once('/').filter(|(c, _)| known(c)) {
            Some((configuration, inner)) if configurations.contains_key(configuration) => {
                let refused = |p: Problem| PatchError::Refused(vec![p]);
                let spec = structure.model().spec().configured(configuration).map_err(refused)?;
                let (model, _) = Model::new(spec, structure.model().registry()).map_err(PatchError::Refused)?;
                let own_masses = configurations[configuration].masses.keys().cloned().collect();
                let context = Context { own_masses, ..structure.context().clone() };
                place_of(effect, &Structure::new(&model, &context), inner, Some(configuration))
            }
            Some((configuration, inner)) => place_of(effect, structure, inner, Some(configuration)),
            None => place_of(effect, structure, place, None).map_err(|e| match place.split_once('/') {
                Some((name, _)) if !configurations.is_empty() && matches!(e, PatchError::UnknownPlace { .. }) => {
                    let known = configurations.keys().map(String::as_str);
                    PatchError::UnknownConfiguration { name: name.to_string(), suggestion: did_you_mean(name, known) }
                }
                _ => e,
            }),
        }
    }
}

/// An effect at a place in words; between the places of a mesh only where it is none of them.
fn place_of(
    effect: &'static dyn Effect,
    structure: &Structure<'_>,
    place: &str,
    configuration: Option<&str>,
) -> Result<Candidate, PatchError> {
    let refused = match listed(effect, structure, place, configuration) {
        Err(refused @ PatchError::UnknownPlace { .. }) => refused,
        other => return other,
    };
    // `n81+n18.uz`: names, the last with a direction behind it.
    let without = place.rsplit_once('.').map_or(place, |(names, _)| names);
    let further: Vec<String> = place.split('+').chain(without.split('+')).map(str::to_string).collect();
    if !further.iter().any(|name| structure.has_place(name)) {
        return Err(refused);
    }
    let context = Context { further, ..structure.context().clone() };
    listed(effect, &Structure::new(structure.model(), &context), place, configuration).map_err(|_| refused)
}

/// An effect at a place that it lists.
fn listed(
    effect: &'static dyn Effect,
    structure: &Structure<'_>,
    place: &str,
    configuration: Option<&str>,
) -> Result<Candidate, PatchError> {
    let mut locations = effect.locations(structure);
    let wider = effect.locations(&structure.clone().on_wider_places());
    locations.extend(wider.into_iter().filter(|at| !locations.contains(at)).collect::<Vec<_>>());
    let Some(at) = locations.iter().find(|l| l.to_string() == place) else {
        if locations.is_empty() && effect.needs_sensors() && structure.context().sensors.is_empty() {
            return Err(PatchError::NoSensors { effect: effect.name().to_string() });
        }
        let places: Vec<String> = locations.iter().map(Location::to_string).collect();
        return Err(PatchError::unknown_place(effect.name(), place, &places));
    };
    let at = configuration.map_or_else(|| at.clone(), |c| at.clone().within(c));
    Candidate::new(effect, structure, &at)
}

impl Default for Effects {
    fn default() -> Self {
        Self::builtin()
    }
}
