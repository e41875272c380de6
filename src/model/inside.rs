//! Points and stretches inside an element of the file that is subdivided, by shares of its length: `spar/0.4` is the node at four tenths of `spar`,
//! `spar/0.4..0.5` what lies from there to the middle. A finer subdivision has them too. Counted from 1, `spar/4` is the fourth of the parts and the
//! node behind it.

use super::placed_element::PlacedElement;
use std::collections::BTreeMap;

/// A share counts as that of a node where it is so near to it, in lengths of the parts: names have a few digits.
const NEAR: f64 = 0.05;

/// `spar/0.4`, the node behind so many of the parts of an element.
pub(super) fn point_name(element: &str, part: u32, parts: u32) -> String {
    format!("{element}/{}", share(part, parts))
}

/// `spar/4`, as the node is called by who counts the parts.
pub(super) fn counted_name(element: &str, part: u32) -> String {
    format!("{element}/{part}")
}

/// `spar/0.4..0.5`, from behind `first` of the parts to behind `last` of them.
pub(crate) fn stretch_name(element: &str, [first, last]: [u32; 2], parts: u32) -> String {
    format!("{element}/{}..{}", share(first, parts), share(last, parts))
}

fn share(part: u32, parts: u32) -> String {
    let digits = if parts <= 1000 { 4 } else { 6 };
    let text = format!("{:.digits$}", f64::from(part) / f64::from(parts));
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
}

/// The elements of a stretch, in order, or the one that is counted; `None` for any other name, and for a stretch that does not begin and end at nodes.
///
/// * `sets` - name -> indices of elements, in ascending order
pub(super) fn stretch<'a>(
    sets: &'a BTreeMap<String, Vec<usize>>,
    elements: &[PlacedElement],
    name: &str,
) -> Option<&'a [usize]> {
    let (element, range) = name.rsplit_once('/')?;
    let parts = sets.get(element)?;
    let is_part = |e: usize| elements[e].name.strip_prefix(element).is_some_and(|rest| rest.starts_with('/'));
    if parts.len() < 2 || !parts.iter().all(|&e| is_part(e)) {
        return None;
    }
    let Some((first, last)) = range.split_once("..") else {
        let counted = range.parse::<usize>().ok()?.checked_sub(1)?;
        return parts.get(counted..=counted);
    };
    let node = |text: &str| {
        let at = text.parse::<f64>().ok()? * parts.len() as f64;
        let nearest = at.round();
        ((at - nearest).abs() < NEAR && (0.0..=parts.len() as f64).contains(&nearest)).then_some(nearest as usize)
    };
    let (first, last) = (node(first)?, node(last)?);
    (first < last).then(|| &parts[first..last])
}

/// What is wrong with a name that looks like a stretch of one of the elements.
pub(super) fn why_none(sets: &BTreeMap<String, Vec<usize>>, name: &str) -> Option<String> {
    let (element, range) = name.rsplit_once('/')?;
    range.split_once("..")?;
    let parts = sets.get(element)?.len() as u32;
    Some(if parts < 2 {
        format!("`{element}` is not subdivided, so nothing inside of it has a name")
    } else {
        let shares: Vec<String> = (0..=parts.min(4)).map(|k| share(k, parts)).collect();
        format!("a stretch of `{element}` begins and ends at its nodes, at {}, ...", shares.join(", "))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Registry, load};

    #[test]
    fn names_stay_where_they_are_in_a_finer_mesh() {
        assert_eq!(point_name("spar", 1, 3), "spar/0.3333");
        assert_eq!(point_name("spar", 3, 9), "spar/0.3333");
        assert_eq!(stretch_name("spar", [0, 2], 4), "spar/0..0.5");
        for parts in [4, 12, 60] {
            let text = format!(
                "retune: 1\nname: spar\nsections: {{s: {{E: 1, G: 1, A: 1, Iy: 1, Iz: 1, J: 1, mass_per_length: 1}}}}\n\
                 nodes: {{a: [0, 0, 0], b: [1, 0, 0]}}\n\
                 beams: {{spar: {{nodes: [a, b], section: s, subdivide: {parts}}}}}\n\
                 masses: {{m: {{node: spar/0.25, mass: 1}}}}\n\
                 overrides: {{soft: {{of: [spar/0.25..0.5], stiffness: 0.5}}}}\n\
                 supports: {{c: {{node: a}}}}\n"
            );
            let model = load(&text, &Registry::default()).unwrap().0;
            let node = model.geometry().node("spar/0.25").unwrap();
            assert_eq!(model.geometry().positions[node], [0.25, 0.0, 0.0]);
            assert_eq!(model.element_set("spar/0.25..0.5").unwrap().len(), parts / 4);
            assert_eq!(model.element_set("spar/2").unwrap(), &model.element_set("spar").unwrap()[1..2]);
            assert_eq!(model.geometry().positions[model.geometry().node("spar/1").unwrap()][0], 1.0 / parts as f64);
            assert!(["spar/0", "spar/61", "spar/0.3", "spar/a..b"].iter().all(|n| model.element_set(n).is_none()));
            let soft: Vec<&str> =
                model.elements().iter().filter(|e| e.stiffness_factor.is_some()).map(|e| e.name.as_str()).collect();
            assert_eq!(soft.len(), parts / 4);
            assert!(soft[0].starts_with("spar/0.25.."), "{soft:?}");
        }
    }

    #[test]
    fn a_stretch_between_nodes_is_refused_with_a_reason() {
        for (parts, expected) in
            [(", subdivide: 4", "begins and ends at its nodes, at 0, 0.25, 0.5"), ("", "is not subdivided")]
        {
            let text = format!(
                "retune: 1\nname: spar\nsections: {{s: {{E: 1, G: 1, A: 1, Iy: 1, Iz: 1, J: 1, mass_per_length: 1}}}}\n\
                 nodes: {{a: [0, 0, 0], b: [1, 0, 0]}}\n\
                 beams: {{spar: {{nodes: [a, b], section: s{parts}}}}}\n\
                 overrides: {{soft: {{of: [spar/0.3..0.5], stiffness: 0.5}}}}\n\
                 supports: {{c: {{node: a}}}}\n"
            );
            let problems = load(&text, &Registry::default()).unwrap_err();
            let told: Vec<&str> = problems.iter().map(|p| p.message.as_str()).collect();
            assert!(told.iter().any(|m| m.contains(expected)), "{told:?}");
        }
    }
}
