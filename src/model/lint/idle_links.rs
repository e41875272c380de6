//! Links that give and carry masses alone: the compliance of a link follows its load statically, so that a mass on it stays where it is.

use crate::model::compile::Model;
use crate::yaml::{Problem, child};
use std::collections::BTreeSet;

/// A word for every link with a compliance that carries nothing which resists deformation.
pub(super) fn idle_links(model: &Model, theta: &[f64]) -> Vec<Problem> {
    let links = &model.spec().rigid_links;
    let resists = |carried: &BTreeSet<&str>| {
        let is_carried = |n: &usize| carried.contains(model.geometry().names[*n].as_str());
        model.elements().iter().enumerate().filter(|(_, e)| e.joined().iter().any(is_carried)).any(|(i, e)| {
            e.joined().len() > 1 || model.element_matrices(i, theta).is_ok_and(|m| !m.stiffness.is_zero())
        })
    };
    let mut found = Vec::new();
    for (name, link) in links.iter().filter(|(_, link)| !link.compliance.is_empty()) {
        let mut carried: BTreeSet<&str> = link.slaves.iter().map(String::as_str).collect();
        loop {
            let further: Vec<&str> = links
                .values()
                .filter(|l| carried.contains(l.master.as_str()))
                .flat_map(|l| l.slaves.iter().map(String::as_str))
                .filter(|slave| !carried.contains(slave))
                .collect();
            if further.is_empty() {
                break;
            }
            carried.extend(further);
        }
        if !resists(&carried) {
            found.push(Problem::warning(
                child(&child("rigid_links", name), "compliance"),
                "the link carries nothing that resists deformation, so that its compliance changes nothing: give the mass a node of its own, on a spring \
                 between the two",
            ));
        }
    }
    found
}
