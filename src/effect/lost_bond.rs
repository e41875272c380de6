//! A stringer that is not attached between two of its nodes.

use super::edit::{Edit, PatchError, scalar};
use super::location::Location;
use super::patch::{Builder, Patch, round};
use super::structure::{Part, Structure, entries};
use super::torsion_stiffness_change::rigidity;
use super::{About, Effect};
use crate::element::Dof;
use crate::model::PlacedElement;
use crate::model::spec::{ElementSpec, Named, OverrideSpec, SectionSpec, SectionValue};
use crate::units::Scalar;
use std::sync::Arc;

/// Nearly all of a rigidity: what is left keeps the beam determined.
const NEARLY_ALL: f64 = 0.9999;
/// Of the torsional stiffness, what the beam that bridges the stretch keeps.
const LEAST_TWIST: f64 = 1e-6;

#[doc = "A stringer, a rib or a doubler on a skin that is not attached between two places: rivets, spots or adhesive that are missing or have failed."]
#[derive(Debug, Clone, Copy)]
pub struct LostBond;

impl Effect for LostBond {
    fn name(&self) -> &'static str {
        "lost-bond"
    }

    fn about(&self) -> About {
        About {
            summary: "A stringer, a rib or a doubler on a skin that is not attached between two places: rivets, spots or adhesive that \
                    are missing or have failed.",
            signature: "Modes that bend the skin between the two places fall, those that stretch the stringer as a whole stay: its force \
                    still passes from one end to the other.",
            formulation: "Of bending, stretch and mass of the beams on the stretch, 1 - p stays at their nodes, and p is that of one beam of the same section \
                    from the first node to the last; of their torsion 1 - q stays. p = q = 0 leaves it, p = 1 is a stretch that nothing holds inside.",
            confusable: &["stiffness-change", "bending-stiffness-change", "member-eccentricity"],
            references: &["E. F. Bruhn, Analysis and Design of Flight Vehicle Structures, 1973, chapter C7"],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        structure.places(|p| Stretch::of(structure, p).is_some())
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let unknown = || PatchError::unknown_place(self.name(), &at.to_string(), &[]);
        let parts = structure.parts_at(self.name(), at)?;
        let mut b = Builder::new(self.name(), at);
        let stretches: Vec<Stretch<'_>> =
            parts.iter().map(|p| Stretch::of(structure, p)).collect::<Option<_>>().ok_or_else(unknown)?;
        let about = format!("share of {} that no longer bends and stretches with the skin", at.place());
        let p = b.parameter("loss", "1", 0.5, [0.0, 1.0], &about);
        let about = format!("share of {} that no longer twists with the skin", at.place());
        let q = b.parameter("twist_loss", "1", 0.5, [0.0, 1.0], &about);
        for (name, stretch) in b.named(&stretches) {
            b.edit(Edit::AddElement { name: name.clone(), entry: stretch.bridge() });
            let (stiffness, mass) = (Some(scalar(&p)), Some(scalar(&p)));
            let entry = OverrideSpec { of: vec![name.clone()], stiffness, mass, ..OverrideSpec::default() };
            b.edit(Edit::AddOverride { name, entry });
        }
        let left = |of: &str| scalar(&format!("1 - {NEARLY_ALL}*{of}"));
        let words = &stretches[0].words;
        let mut scale = Named::new();
        for word in [words.area, words.bending[0], words.bending[1]] {
            scale.insert(word.to_string(), left(&p));
        }
        scale.insert(words.torsion.to_string(), left(&q));
        // By its area goes the mass that a density gives.
        let mass = (!stretches[0].has_density).then(|| scalar(&format!("1 - {p}")));
        b.change(".left", &entries(&parts), OverrideSpec { scale, mass, ..OverrideSpec::default() });
        Ok(b.finish())
    }
}

/// Beams of one section that lie end to end on something else.
struct Stretch<'a> {
    first: &'a PlacedElement,
    ends: [String; 2],
    properties: SectionSpec,
    words: Words,
    has_density: bool,
}

/// The properties that carry its rigidities.
struct Words {
    area: &'static str,
    bending: [&'static str; 2],
    torsion: &'static str,
}

impl Words {
    fn of(structure: &Structure<'_>, part: &Part) -> Option<Self> {
        let area = ["A", "EA"].into_iter().find(|name| structure.part_has(part, name))?;
        let of = |dof| rigidity(structure, part, dof);
        Some(Self { area, bending: [of(Dof::Ry)?, of(Dof::Rz)?], torsion: of(Dof::Rx)? })
    }
}

impl<'a> Stretch<'a> {
    /// `None` where a part is no such stretch.
    fn of(structure: &'a Structure<'_>, part: &Part) -> Option<Self> {
        let all = structure.model().elements();
        let path = structure.path(&part.elements).filter(|p| p.len() > 1)?;
        let first = &all[path[0]];
        let is_like = |e: &PlacedElement| {
            (Arc::ptr_eq(&e.values, &first.values) || e.values == first.values)
                && e.path == first.path
                && e.arms.is_empty()
                && e.turn == first.turn
        };
        let bends = |e: usize| structure.strains(e, Dof::Ry) || structure.strains(e, Dof::Rz);
        if !path.iter().all(|&e| is_like(&all[e]) && bends(e)) {
            return None;
        }
        let shared = |a: usize, b: usize| all[a].nodes.iter().copied().find(|n| all[b].nodes.contains(n));
        let inner: Vec<usize> = path.windows(2).map(|w| shared(w[0], w[1])).collect::<Option<_>>()?;
        // What is left of it would fall apart where nothing else is.
        if !inner.iter().all(|&n| structure.lies_on_a_skin(n)) {
            return None;
        }
        let other = |e: usize, node: usize| all[e].nodes.iter().copied().find(|n| *n != node);
        let mut ends = [other(path[0], inner[0])?, other(*path.last()?, *inner.last()?)?];
        if first.nodes.first() != Some(&ends[0]) {
            // In the direction of its first beam, so that its section lies the same way round.
            ends.reverse();
        }
        let spec = structure.model().spec();
        let own = first.path.strip_prefix("beams.").and_then(|name| spec.beams.get(name));
        let mut properties = own.map_or_else(SectionSpec::default, |m| m.properties.clone());
        if first.section.is_none() && properties.is_empty() {
            return None;
        }
        let words = Words::of(structure, part)?;
        let number = |value: f64| SectionValue::Scalar(Scalar::constant(value));
        let torsion = structure.property(path[0], words.torsion)?;
        // One long beam has its mass spread, and the twist stays where the skin is.
        properties.insert("lumping".to_string(), number(0.0));
        properties.insert(words.torsion.to_string(), number(round(LEAST_TWIST * torsion)));
        let has_density = structure.part_has(part, "density");
        let ends = ends.map(|n| structure.node_name(n).to_string());
        Some(Self { first, ends, properties, words, has_density })
    }

    /// One beam from end to end.
    fn bridge(&self) -> ElementSpec {
        ElementSpec {
            kind: self.first.kind.name().to_string(),
            nodes: self.ends.to_vec(),
            section: self.first.section.clone(),
            properties: self.properties.clone(),
            orientation: self.first.orientation,
            frame: None,
        }
    }
}
