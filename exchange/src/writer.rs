//! The text of a model file, block by block, with the comments of the deck.

use super::listed::{Listed, MOST_LISTED, MeshFile, Remarks};
use super::text::{clean, map};
use std::fmt::Write as _;

/// Blocks of a model file, in the order in which they are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Block {
    Parameters,
    Frames,
    Mesh,
    Nodes,
    Sections,
    Beams,
    Bars,
    Springs,
    Bushings,
    Masses,
    Elements,
    Overrides,
    RigidLinks,
    WeightedLinks,
    Ties,
    Supports,
    Constraints,
    Groups,
    Targets,
    Imported,
}

const BLOCKS: [&str; 20] = [
    "parameters",
    "frames",
    "mesh",
    "nodes",
    "sections",
    "beams",
    "bars",
    "springs",
    "bushings",
    "masses",
    "elements",
    "overrides",
    "rigid_links",
    "weighted_links",
    "ties",
    "supports",
    "constraints",
    "groups",
    "targets",
    "imported",
];

#[derive(Debug, Clone)]
pub(crate) struct Writer {
    /// But for nodes, elements and groups.
    blocks: [String; 20],
    listed: Listed,
    /// Comments that stand above the next entry of a block.
    pending: [Vec<String>; 20],
}

impl Writer {
    pub(crate) fn new() -> Self {
        Self { blocks: Default::default(), listed: Listed::default(), pending: Default::default() }
    }

    /// A comment above the next entry of a block.
    pub(crate) fn comment(&mut self, block: Block, text: &str) {
        self.pending[block as usize].push(text.to_string());
    }

    /// `name: value` of a block that is not a list of nodes, elements or groups, with a remark behind it.
    pub(crate) fn entry(&mut self, block: Block, name: &str, value: &str, remark: &str) {
        let i = block as usize;
        debug_assert!(!matches!(block, Block::Mesh | Block::Nodes | Block::Elements | Block::Groups));
        for comment in std::mem::take(&mut self.pending[i]) {
            let _ = writeln!(self.blocks[i], "  # {}", clean(&comment));
        }
        let _ = write!(self.blocks[i], "  {name}: {value}");
        if !remark.is_empty() {
            let _ = write!(self.blocks[i], " # {}", clean(remark));
        }
        self.blocks[i].push('\n');
    }

    fn remarks(&mut self, block: Block, behind: &str) -> Remarks {
        Remarks { above: std::mem::take(&mut self.pending[block as usize]), behind: behind.to_string() }
    }

    /// A node.
    ///
    /// * `at` - where it is, in the unit of the deck; none of what is not a point of the structure
    pub(crate) fn node(&mut self, name: &str, value: &str, at: Option<[f64; 3]>, remark: &str) {
        let remarks = self.remarks(Block::Nodes, remark);
        self.listed.node(name, value, at, remarks);
    }

    /// An entry of a list of elements; those of the block `elements` with the type first, then the nodes.
    pub(crate) fn element(&mut self, block: Block, name: &str, items: &[(String, String)]) {
        if block == Block::Elements {
            let remarks = self.remarks(block, "");
            self.listed.element(name, items, remarks);
        } else {
            self.entry(block, name, &map(items), "");
        }
    }

    /// A group of elements.
    pub(crate) fn group(&mut self, name: &str, members: &[String]) {
        self.listed.group(name, members);
    }

    /// A parameter that multiplies the stiffness of a group, free between a half and two.
    pub(crate) fn factor_on_stiffness(&mut self, group: &str) {
        let parameter = format!("{group}_stiffness");
        let value = format!("{{value: 1, bounds: [0.5, 2], description: factor on the stiffness of {group}}}");
        self.entry(Block::Parameters, &parameter, &value, "");
        self.entry(Block::Overrides, group, &format!("{{stiffness: {parameter}}}"), "");
    }

    pub(crate) fn has_nodes(&self) -> bool {
        self.listed.has_nodes()
    }

    /// The whole file below its head, and the mesh that it refers to, if it does.
    ///
    /// * `file` - what a mesh is to be called
    /// * `unit` - of length, of the deck
    pub(crate) fn finish(mut self, head: &str, file: &str, unit: &str) -> (String, Option<MeshFile>) {
        let ([mesh, nodes, elements, groups], found) = self.listed.finish(file, unit, MOST_LISTED);
        for (block, text) in
            [(Block::Mesh, mesh), (Block::Nodes, nodes), (Block::Elements, elements), (Block::Groups, groups)]
        {
            self.blocks[block as usize] = text;
        }
        let size = self.blocks.iter().map(String::len).sum::<usize>();
        let mut out = String::with_capacity(size + head.len() + 512);
        out.push_str(head);
        for (name, block) in BLOCKS.iter().zip(&self.blocks).filter(|(_, b)| !b.is_empty()) {
            let _ = write!(out, "\n{name}:\n{block}");
        }
        (out, found)
    }
}
