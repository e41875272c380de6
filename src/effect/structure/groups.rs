//! Groups that the structure itself shows: members of one section, those of them between two neighbouring levels of nodes (the braces of a
//! storey), and those in one level (the beams of a floor, the columns of a face).
//!
//! So are springs and bars that the file makes alike.
//!
//! Nobody declares them, and what is wrong with one member because of how it was bought or built is wrong with its group.

use super::{Part, PartKind, Structure};
use crate::model::AXES;
use crate::model::spec::{MemberSpec, Named, SectionSpec};
use crate::units::Scalar;
use std::collections::BTreeMap;

/// Nodes of a level, at least.
const FEWEST_NODES: usize = 3;
/// Levels of an axis, at most: what has more is not a frame of storeys or bays.
const MOST_LEVELS: usize = 40;
/// Share of the nodes that stand in levels, at least.
const IN_LEVELS: f64 = 0.8;
/// Two coordinates are of one level where they differ by less than this share of the extent.
const FLAT: f64 = 1e-3;

/// What makes entries of the file alike.
#[derive(PartialEq)]
enum Alike<'s> {
    Springs(&'s Named<Scalar>),
    Bars(&'s SectionSpec),
}

impl Structure<'_> {
    /// Members of one section, in file order: all, then along every axis that has levels those between two and those in one. `brace.all`,
    /// `brace.z1-2`, `beam.z2`; levels are counted from the lowest.
    pub(super) fn list_groups(&self) -> Vec<Part> {
        let spec = self.model.spec();
        let mut of_section: BTreeMap<&str, Vec<&[usize]>> = BTreeMap::new();
        for (name, member) in spec.beams.iter().chain(&spec.bars) {
            let (Some(section), Some(elements)) = (&member.section, self.model.element_set(name)) else { continue };
            // However finely it is subdivided, an element of the file is one.
            let each = elements.chunk_by(|&a, &b| self.element_of_file(a) == self.element_of_file(b));
            of_section.entry(section).or_default().extend(each);
        }
        let levels: Vec<Vec<f64>> = (0..3).map(|axis| self.levels(axis)).collect();
        let mut groups = Vec::new();
        for (section, each) in of_section {
            let mut add =
                |name: &str, those: Vec<&[usize]>| groups.extend(self.group(format!("{section}.{name}"), &those));
            add("all", each.clone());
            for (axis, levels) in levels.iter().enumerate() {
                let places: Vec<_> = each.iter().map(|e| self.between(levels, axis, e)).collect();
                let at = |a: usize, b: usize| {
                    let there = each.iter().zip(&places).filter(|(_, place)| **place == Some((a, b)));
                    there.map(|(e, _)| *e).collect()
                };
                for k in 0..levels.len() {
                    add(&format!("{}{}", AXES[axis], k + 1), at(k, k));
                    add(&format!("{}{}-{}", AXES[axis], k + 1, k + 2), at(k, k + 1));
                }
            }
        }
        groups.extend(self.list_alike());
        groups
    }

    /// Springs, bushings and bars without a section that the file makes alike: the same stiffnesses, by the same parameters. Mounts of one type,
    /// the guys of a mast. Called by what begins all their names, `mount.all`, or by the first: `front_left.alike`.
    fn list_alike(&self) -> Vec<Part> {
        let spec = self.model.spec();
        let springs = spec.springs.iter().chain(&spec.bushings).filter(|(_, s)| !s.k.is_empty());
        let springs = springs.map(|(name, s)| (name, Alike::Springs(&s.k)));
        let has_none = |m: &MemberSpec| m.section.is_none() && m.chain.is_none() && m.pairs.is_none();
        let bars = spec.bars.iter().filter(|(_, m)| has_none(m)).map(|(name, m)| (name, Alike::Bars(&m.properties)));
        let mut kinds: Vec<(Alike<'_>, Vec<&str>)> = Vec::new();
        for (name, of) in springs.chain(bars) {
            match kinds.iter_mut().find(|(known, _)| *known == of) {
                Some((_, names)) => names.push(name),
                None => kinds.push((of, vec![name])),
            }
        }
        let group = |names: &Vec<&str>| {
            let each: Vec<&[usize]> = names.iter().filter_map(|n| self.model.element_set(n)).collect();
            let common = common_start(names).trim_end_matches(|c: char| !c.is_alphabetic());
            let name = if common.is_empty() { format!("{}.alike", names[0]) } else { format!("{common}.all") };
            self.group(name, &each)
        };
        kinds.iter().filter_map(|(_, names)| group(names)).collect()
    }

    /// A group of several elements of the file; none of fewer, and none where the file has such a name.
    fn group(&self, name: String, each: &[&[usize]]) -> Option<Part> {
        (each.len() > 1 && self.model.element_set(&name).is_none()).then(|| Part {
            name,
            kind: PartKind::Group,
            of: each.iter().map(|e| self.element_of_file(e[0]).to_string()).collect(),
            elements: each.concat(),
            partner: None,
            is_member: false,
        })
    }

    /// What a group is that the structure shows, in words: `brace.y1`, members of section brace in level 1 of y, ... `None` of a name of the file.
    pub fn shown(&self, name: &str) -> Option<String> {
        /// Members that are listed.
        const LISTED: usize = 8;
        let is_it = |p: &&Part| p.kind == PartKind::Group && p.name == name && self.model.element_set(name).is_none();
        let part = self.parts.iter().find(is_it)?;
        let (section, place) = name.rsplit_once('.').filter(|(s, _)| self.model.spec().sections.contains_key(*s))?;
        let levels = place.get(1..)?;
        let place = match levels.split_once('-') {
            _ if place == "all" => String::new(),
            Some((low, high)) => {
                format!(" between levels {low} and {high} of {}, counted from the lowest", &place[..1])
            }
            None => format!(" in level {levels} of {}, counted from the lowest", &place[..1]),
        };
        let listed = part.of.iter().take(LISTED).map(String::as_str).collect::<Vec<_>>().join(", ");
        let more = part.of.len().saturating_sub(LISTED);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        Some(format!("{name}, members of section {section}{place}: {listed}{more}"))
    }

    /// Coordinates along an axis at which most nodes of the file stand, several each; none where they do not.
    fn levels(&self, axis: usize) -> Vec<f64> {
        let mut at: Vec<f64> =
            self.model.geometry().positions[..self.model.spec().nodes.len()].iter().map(|p| p[axis]).collect();
        at.sort_by(f64::total_cmp);
        let flat = self.flat();
        let levels: Vec<&[f64]> =
            at.chunk_by(|a, b| b - a < flat).filter(|level| level.len() >= FEWEST_NODES).collect();
        let in_levels: usize = levels.iter().map(|level| level.len()).sum();
        let are_levels = (2..=MOST_LEVELS).contains(&levels.len()) && in_levels as f64 >= IN_LEVELS * at.len() as f64;
        if are_levels { levels.into_iter().map(|level| level[0]).collect() } else { Vec::new() }
    }

    /// The lowest and the highest level that an element of the file touches; none where one of its nodes is in none.
    fn between(&self, levels: &[f64], axis: usize, element: &[usize]) -> Option<(usize, usize)> {
        let (all, geometry) = (self.model.elements(), self.model.geometry());
        let nodes = element.iter().flat_map(|&e| &all[e].nodes).filter(|n| **n < self.model.spec().nodes.len());
        let of =
            |&node: &usize| levels.iter().position(|l| (geometry.positions[node][axis] - l).abs() < 2.0 * self.flat());
        let at = nodes.map(of).collect::<Option<Vec<usize>>>()?;
        Some((*at.iter().min()?, *at.iter().max()?))
    }

    fn flat(&self) -> f64 {
        FLAT * self.extent()
    }
}

/// What begins all these names.
fn common_start<'a>(names: &[&'a str]) -> &'a str {
    let Some(&first) = names.first() else { return "" };
    let differs = |other: &&str| {
        let at = first.char_indices().zip(other.chars()).find(|((_, a), b)| a != b);
        at.map_or(first.len().min(other.len()), |((i, _), _)| i)
    };
    &first[..names.iter().map(differs).min().unwrap_or(0)]
}
