//! How a deck is to be read, and what becomes of it.

use super::listed::MeshFile;
use super::report::ImportReport;
use super::system::System;
use super::text::{clean, quoted};
use retune::catalogue::counted;
use retune::deck::CardId;
use retune::model::spec::ImportedSpec;
use retune::model::{Model, Registry, load_in};
use retune::yaml::{Problem, SourceMap};
use std::collections::{BTreeMap, HashMap};
use std::io;
use std::path::Path;

/// Whose deck of keywords it is: the same deck has lumped masses in Abaqus where CalculiX has consistent ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Solver {
    #[default]
    Abaqus,
    CalculiX,
}

retune::catalogue::choice! { Solver, "solver";
    Abaqus "abaqus" "Abaqus",
    CalculiX "calculix" "CalculiX",
}

/// How a deck is to be read.
#[derive(Debug, Clone, Copy)]
pub struct ImportOptions {
    /// The units of its numbers.
    pub system: &'static System,
    /// The subcase whose constraints hold, of a deck of keywords the step; the first (that of frequencies) when absent.
    pub subcase: Option<u32>,
    /// Whether every property gets a parameter, a factor on its stiffness between a half and two.
    pub parameter_per_property: bool,
    /// Of a deck of keywords: whose it is.
    pub solver: Solver,
}

impl ImportOptions {
    /// As a model was imported, by what its file says of that.
    pub(crate) fn again(imported: &ImportedSpec, system: &'static System, solver: Solver) -> Self {
        let parameter_per_property = imported.parameters.as_deref() == Some("properties");
        Self { system, subcase: imported.subcase, parameter_per_property, solver }
    }
}

/// A model file made of a deck.
#[derive(Debug, Clone)]
pub struct Imported {
    /// Its text.
    pub text: String,
    /// What was read, left out and approximated.
    pub report: ImportReport,
    /// The mesh of its shells and solids, where they are many; it is to stand beside the model file.
    pub mesh: Option<MeshFile>,
    /// A test file with the frequencies that an optimisation of the deck asks for, where there is one.
    pub test: Option<String>,
    pub(crate) origins: Origins,
}

impl Imported {
    /// The model, as [`retune::model::load`] reads it.
    ///
    /// # Errors
    /// Every problem of the text: a fault of the import.
    pub fn load(&self, registry: &Registry) -> Result<(Model, Vec<Problem>, SourceMap), Vec<Problem>> {
        load_in(&self.text, None, registry, &mut |file| self.file(file))
    }

    /// The card of a Nastran deck that an entry of the text was made of.
    ///
    /// * `path` - of the entry or of something in it: `masses.conm2_11`
    pub fn card_of(&self, path: &str) -> Option<CardId> {
        let name = path.split('.').nth(1)?;
        let element = self.origins.elements.get(name).and_then(|origin| origin.card);
        element.or_else(|| self.origins.grids.get(name).copied())
    }

    /// A file that the text names.
    ///
    /// # Errors
    /// Another file than the mesh.
    pub fn file(&self, name: &str) -> io::Result<Vec<u8>> {
        let mesh = self.mesh.as_ref().filter(|m| m.name == name);
        mesh.map(|m| m.text.clone().into_bytes()).ok_or_else(|| io::ErrorKind::NotFound.into())
    }
}

/// What the mesh of a deck is called, beside the model file.
pub(crate) fn mesh_name(deck: &Path) -> String {
    let stem = deck.file_stem().map_or_else(|| "deck".into(), |s| s.to_string_lossy());
    format!("{}_mesh.msh", clean(&stem))
}

/// A property of an element and the field that it comes from: SI = shift + factor · field.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Bound {
    /// The property of the element in retune.
    pub property: String,
    pub card: CardId,
    /// Zero where several fields give it, so that none can be written.
    pub field: usize,
    pub name: &'static str,
    pub factor: f64,
    pub shift: f64,
}

/// The first plane of a bar, as its card says it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Plane {
    /// Axes of the element before the principal axes of its section, global.
    pub axes: [[f64; 3]; 3],
    /// Axes in which the vector of the card stands.
    pub of_vector: [[f64; 3]; 3],
    /// Whether offsets stand in the axes of the element and turn with them.
    pub turns_offsets: bool,
}

/// Where an element comes from.
#[derive(Debug, Clone, Default)]
pub(crate) struct ElementOrigin {
    pub card: Option<CardId>,
    pub property: Option<CardId>,
    pub section: Option<String>,
    pub bounds: Vec<Bound>,
    pub plane: Option<Box<Plane>>,
}

/// A property of an element and the item of a deck of keywords that it comes from: SI = factor · item.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct KeyedBound {
    /// The property of the element in retune.
    pub property: String,
    /// Keyword, data line and item, each from 0.
    pub place: (usize, usize, usize),
    pub factor: f64,
}

/// Where entries of the model file come from in a deck of keywords.
#[derive(Debug, Clone, Default)]
pub(crate) struct KeyedOrigins {
    /// Of sections: the keyword, and the items.
    pub sections: HashMap<String, (usize, Vec<KeyedBound>)>,
    /// Of masses, inertias, springs: the keyword of each element.
    pub points: HashMap<String, usize>,
    /// The items of these keywords.
    pub of_points: HashMap<usize, Vec<KeyedBound>>,
    /// Keywords of materials, by name.
    pub materials: BTreeMap<String, Vec<usize>>,
    /// Nodes: instance and number.
    pub nodes: HashMap<String, (String, u32)>,
    /// The largest number of an element.
    pub largest: u32,
}

/// Where entries of the model file come from.
#[derive(Debug, Clone, Default)]
pub(crate) struct Origins {
    pub elements: HashMap<String, ElementOrigin>,
    pub sections: HashMap<String, Vec<Bound>>,
    pub grids: HashMap<String, CardId>,
    /// Cards of design variables, by parameter.
    pub variables: HashMap<String, CardId>,
    /// Mass in SI of one unit of the deck's mass fields over that of its system.
    pub wtmass: f64,
    /// The largest number of an element, a grid, a property, a material.
    pub largest: u32,
    pub keyed: KeyedOrigins,
}

/// What stands above all blocks of a model file.
pub(crate) fn head(report: &ImportReport, file: &str, system: &System, title: &str) -> String {
    let entries: usize = report.read.values().map(|r| r.0).sum();
    let mut head = format!(
        "# Made by `retune import {}` from {} in {}; units {}.\n",
        clean(file),
        counted(entries, report.entry),
        counted(report.files, "file"),
        system.name
    );
    for what in report.approximated.keys() {
        head.push_str(&format!("# Approximated: {}\n", clean(what)));
    }
    head.push_str(&format!("retune: 1\nname: {}\n", quoted(if title.trim().is_empty() { file } else { title })));
    head
}
