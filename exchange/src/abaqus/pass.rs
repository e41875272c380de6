//! The pass over the keywords of a deck: from what stands in it to the text of a model file.

use super::gather::gather;
use super::importer::{Importer, Solver, section_word, word};
use super::kinds::Family;
use super::scopes::{At, Body};
use super::{connectors, links, materials, members, points, shells, solids, supports, ties};
use crate::imported::{ImportOptions, Imported, KeyedOrigins, Origins, head, mesh_name};
use crate::system::Quantity;
use crate::text::{clean, quoted};
use crate::writer::Block;
use retune::deck::{DeckError, Keyword, KeywordDeck};
use std::collections::HashSet;

/// Errors of one deck that are told at once.
const MOST_ERRORS: usize = 20;

/// Sections and points: keywords that give properties to the elements of a set.
const SECTIONS: &[&str] = &[
    "SOLIDSECTION",
    "SHELLSECTION",
    "SHELLGENERALSECTION",
    "BEAMSECTION",
    "BEAMGENERALSECTION",
    "MASS",
    "ROTARYINERTIA",
    "SPRING",
    "DASHPOT",
    "CONNECTORSECTION",
];

/// Turns a deck of Abaqus or CalculiX into the text of a model file.
///
/// # Errors
/// Every keyword that cannot be read, twenty at most, each with file, line, item and what was expected.
pub fn import_keywords(deck: &KeywordDeck, options: ImportOptions) -> Result<Imported, Vec<DeckError>> {
    let all = gather(deck, MOST_ERRORS)?;
    let mut importer = Importer::new(deck, options, all);
    importer.read_all()?;
    Ok(importer.finish())
}

impl<'a> Importer<'a> {
    fn read_all(&mut self) -> Result<(), Vec<DeckError>> {
        if self.all.instances.iter().all(|i| self.all.bodies[i.body].nodes.is_empty()) {
            let file = self.deck.sources()[0].name().to_string();
            let message = "the deck has no *NODE, or no instance of a part that has some".to_string();
            return Err(vec![DeckError { file, line: 0, card: String::new(), field: None, message }]);
        }
        let mut errors = Vec::new();
        let add = |errors: &mut Vec<DeckError>, found: Result<(), DeckError>| {
            errors.extend(found.err());
            if errors.len() >= MOST_ERRORS { Err(std::mem::take(errors)) } else { Ok(()) }
        };
        let materials: Vec<(String, Vec<usize>)> =
            self.all.materials.iter().map(|(n, k)| (n.clone(), k.clone())).collect();
        for (name, keywords) in materials {
            let found = materials::read(self, &keywords).map(|m| {
                self.materials.insert(name, m);
            });
            add(&mut errors, found)?;
        }
        for (instance, k) in self.keywords_of(|b| &b.constraints) {
            if k.name() == "TRANSFORM" {
                let found = self.transform(&k, instance);
                add(&mut errors, found)?;
            }
        }
        for (instance, k) in self.keywords_of(|b| &b.constraints) {
            if k.name() == "TIE" {
                let found = ties::tie(self, &k, instance);
                add(&mut errors, found)?;
            }
        }
        self.write_nodes();
        for (instance, k) in self.keywords_of(|b| &b.sections) {
            if SECTIONS.contains(&k.name()) {
                let found = self.elements_of(&k, instance);
                add(&mut errors, found)?;
            }
        }
        let found = self.all_have_sections();
        add(&mut errors, found)?;
        for (instance, k) in self.keywords_of(|b| &b.constraints) {
            let found = match k.name() {
                "COUPLING" => links::coupling(self, &k, instance),
                "KINEMATICCOUPLING" => links::kinematic(self, &k, instance),
                "DISTRIBUTINGCOUPLING" => links::distributing(self, &k, instance),
                "MPC" => links::mpc(self, &k, instance),
                "RIGIDBODY" => links::rigid_body(self, &k, instance),
                "EQUATION" => links::equation(self, &k, instance),
                _ => Ok(()),
            };
            add(&mut errors, found)?;
        }
        ties::write(self);
        let found = supports::write(self);
        add(&mut errors, found)?;
        if errors.is_empty() { Ok(()) } else { Err(errors) }
    }

    /// Keywords of all instances that stand in a list of their bodies.
    fn keywords_of(&self, list: impl Fn(&Body) -> &Vec<usize>) -> Vec<(u32, Keyword<'a>)> {
        let mut out = Vec::new();
        for i in 0..self.all.instances.len() as u32 {
            out.extend(list(self.all.body(i)).iter().map(|k| (i, self.deck.keyword(*k))));
        }
        out
    }

    fn write_nodes(&mut self) {
        for i in 0..self.all.instances.len() as u32 {
            let body = self.all.body(i);
            let is_moved = self.all.instances[i as usize].is_moved();
            let mut entries = Vec::with_capacity(body.nodes.len());
            for index in 0..body.nodes.len() as u32 {
                let at = At { instance: i, index };
                let p = self.position(at);
                let is_own = !is_moved && !self.moved.contains_key(&at);
                let value = if is_own {
                    format!("[{}]", p.map(|x| self.with(x, Quantity::Length)).join(", "))
                } else {
                    self.lengths(p)
                };
                entries.push((self.node_name(at), value, p));
            }
            for (name, value, at) in entries {
                self.out.node(&name, &value, Some(at), "");
            }
        }
    }

    /// The elements of a section's set, written with its properties.
    fn elements_of(&mut self, k: &Keyword<'_>, instance: u32) -> Result<(), DeckError> {
        let label = k.needs("ELSET")?;
        let elements = self.all.elements(instance, &label).map_err(|m| k.error(m))?;
        let mut all: Vec<At> = Vec::with_capacity(elements.len());
        for at in elements {
            let slot = &mut self.sectioned[at.instance as usize][at.index as usize];
            let own = k.index() as u32 + 1;
            if *slot == own {
                continue; // twice in its set
            }
            if *slot != 0 {
                let (file, line) = self.deck.keyword(*slot as usize - 1).place();
                let e = &self.all.body(at.instance).elements[at.index as usize];
                return Err(k.error(format_args!("element {} has a section already, at {file}:{line}", e.id)));
            }
            *slot = own;
            all.push(at);
        }
        let Some(first) = all.first().copied() else { return Err(k.error(format_args!("its set `{label}` is empty"))) };
        for at in &all {
            let (kind, expected) = (self.kind(*at), self.kind(first));
            if std::mem::discriminant(&kind.family) != std::mem::discriminant(&expected.family) {
                return Err(k.error(format_args!("its set has elements of {} and of {}", expected.name, kind.name)));
            }
        }
        let family = self.kind(first).family;
        self.begin_group(k, instance, &label, family);
        let is_point = matches!(k.name(), "MASS" | "ROTARYINERTIA" | "SPRING" | "DASHPOT" | "CONNECTORSECTION");
        self.point = is_point.then_some(k.index());
        self.bound();
        let written = match (k.name(), family) {
            ("SOLIDSECTION", Family::Solid) => solids::section(self, k, instance, &all),
            ("SOLIDSECTION", Family::Truss) => members::trusses(self, k, &all),
            ("SHELLSECTION" | "SHELLGENERALSECTION", Family::Shell) => shells::section(self, k, instance, &all),
            ("BEAMSECTION" | "BEAMGENERALSECTION", Family::Beam) => members::beams(self, k, instance, &all),
            ("MASS", Family::Mass) => points::masses(self, k, &all),
            ("ROTARYINERTIA", Family::RotaryInertia) => points::inertias(self, k, instance, &all),
            ("SPRING", Family::Spring(_)) | ("DASHPOT", Family::Dashpot(_)) => points::springs(self, k, instance, &all),
            ("CONNECTORSECTION", Family::Connector) => connectors::section(self, k, instance, &all),
            _ => {
                let kind = self.kind(first).name;
                Err(k.error(format_args!("its set has elements of the type {kind}, which it does not serve")))
            }
        };
        if is_point {
            let bounds = self.bound();
            self.origins.of_points.insert(k.index(), bounds);
        }
        self.point = None;
        written
    }

    fn all_have_sections(&self) -> Result<(), DeckError> {
        for (i, instance) in self.sectioned.iter().enumerate() {
            let body = self.all.body(i as u32);
            let bare = instance.iter().zip(&body.elements).filter(|(s, e)| **s == 0 && e.kind.family != Family::Rigid);
            let mut bare = bare.map(|b| b.1);
            if let Some(e) = bare.next() {
                let more = bare.count();
                let more = if more > 0 { format!(", and {more} more") } else { String::new() };
                let k = self.deck.keyword(e.keyword as usize);
                return Err(k.error(format_args!("element {}{more}: no section or property gives it a material", e.id)));
            }
        }
        Ok(())
    }

    fn begin_group(&mut self, k: &Keyword<'_>, instance: u32, label: &str, family: Family) {
        let own = section_word(k, label);
        let name = self.element_names.unique(&format!("{}{own}", self.prefixes[instance as usize]));
        let is_stiff = matches!(
            family,
            Family::Solid | Family::Shell | Family::Beam | Family::Truss | Family::Spring(_) | Family::Connector
        );
        self.groups.push((name, Vec::new(), is_stiff));
    }

    fn write_groups(&mut self) {
        for (name, members, _) in self.groups.iter().filter(|g| !g.1.is_empty()) {
            self.out.group(name, members);
        }
        for i in 0..self.all.instances.len() as u32 {
            let body = self.all.body(i);
            let named = body.elsets.iter().filter(|(name, set)| !set.is_internal && !name.starts_with('_'));
            let names: Vec<String> = named.map(|(name, _)| name.clone()).collect();
            for name in names {
                let mut seen = HashSet::new();
                let mut members: Vec<String> = Vec::new();
                for at in self.all.elements(i, &name).unwrap_or_default().into_iter().filter(|at| seen.insert(*at)) {
                    members.extend(self.names_of(at));
                }
                // The set of a section is the section's group already.
                let is_served = |g: &(String, Vec<String>, bool)| g.1 == members;
                if members.is_empty() || self.groups.iter().any(is_served) {
                    continue;
                }
                let own = format!("{}{}", self.prefixes[i as usize], word(&name, "set"));
                let own = self.element_names.unique(&own);
                self.out.group(&own, &members);
            }
        }
        if self.options.parameter_per_property {
            let stiff: Vec<String> =
                self.groups.iter().filter(|g| g.2 && !g.1.is_empty()).map(|g| g.0.clone()).collect();
            for name in stiff {
                self.out.factor_on_stiffness(&name);
            }
        }
    }

    /// Where what was written comes from.
    fn keyed_origins(&mut self) -> KeyedOrigins {
        let mut origins = std::mem::take(&mut self.origins);
        origins.materials = self.all.materials.clone();
        for (i, instance) in self.all.instances.iter().enumerate() {
            let body = self.all.body(i as u32);
            for index in 0..body.nodes.len() as u32 {
                let at = At { instance: i as u32, index };
                origins.nodes.insert(self.node_name(at), (instance.name.clone(), body.nodes[index as usize].0));
            }
            origins.largest = body.elements.iter().map(|e| e.id).fold(origins.largest, u32::max);
        }
        origins
    }

    fn finish(mut self) -> Imported {
        self.write_groups();
        let file =
            self.deck.sources()[0].path().file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        let format = match self.options.solver {
            Solver::Abaqus => "abaqus",
            Solver::CalculiX => "calculix",
        };
        let mut imported = vec![
            ("from", quoted(&file)),
            ("format", format.to_string()),
            ("units", self.options.system.name.to_string()),
        ];
        imported.extend(self.options.subcase.map(|s| ("subcase", s.to_string())));
        if self.options.parameter_per_property {
            imported.push(("parameters", "properties".to_string()));
        }
        for (key, value) in imported {
            self.out.entry(Block::Imported, key, &value, "");
        }
        if self.options.solver == Solver::Abaqus && self.report.read.contains_key("DENSITY") {
            self.report.note("masses of first-order elements are lumped, as those of Abaqus; CalculiX has consistent ones: `--solver calculix`");
        }
        let heading = self.all.heading.and_then(|k| self.deck.keyword(k).line(0));
        let title = heading.map(|l| clean(l.whole())).filter(|t| !t.is_empty()).unwrap_or_else(|| file.clone());
        self.report.notes.sort();
        let head = head(&self.report, &file, self.options.system, &title);
        let origins = Origins { keyed: self.keyed_origins(), ..Origins::default() };
        let unit = self.unit(Quantity::Length);
        let (text, mesh) = self.out.finish(&head, &mesh_name(self.deck.sources()[0].path()), unit);
        Imported { text, report: self.report, mesh, test: None, origins }
    }
}
