//! The text of a model file, block by block, with the comments of the deck.

use std::fmt::Write as _;

/// Blocks of a model file, in the order in which they are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::exchange) enum Block {
    Parameters,
    Frames,
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
    Supports,
    Constraints,
    Groups,
    Targets,
    Imported,
}

const BLOCKS: [&str; 18] = [
    "parameters",
    "frames",
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
    "supports",
    "constraints",
    "groups",
    "targets",
    "imported",
];

/// A line longer than this is broken.
const WIDTH: usize = 140;

#[derive(Debug, Clone)]
pub(in crate::exchange) struct Writer {
    blocks: [String; 18],
    /// Number of entries of each block.
    counts: [usize; 18],
    /// Comments that stand above the next entry of a block.
    pending: [Vec<String>; 18],
}

impl Writer {
    pub(in crate::exchange) fn new() -> Self {
        Self { blocks: Default::default(), counts: [0; 18], pending: Default::default() }
    }

    /// A comment above the next entry of a block.
    pub(in crate::exchange) fn comment(&mut self, block: Block, text: &str) {
        self.pending[block as usize].push(text.to_string());
    }

    /// `name: value`, with a remark behind it.
    pub(in crate::exchange) fn entry(&mut self, block: Block, name: &str, value: &str, remark: &str) {
        let i = block as usize;
        for comment in std::mem::take(&mut self.pending[i]) {
            let _ = writeln!(self.blocks[i], "  # {}", clean(&comment));
        }
        let _ = write!(self.blocks[i], "  {name}: {value}");
        if !remark.is_empty() {
            let _ = write!(self.blocks[i], " # {}", clean(remark));
        }
        self.blocks[i].push('\n');
        self.counts[i] += 1;
    }

    /// A parameter that multiplies the stiffness of a group, free between a half and two.
    pub(in crate::exchange) fn factor_on_stiffness(&mut self, group: &str) {
        let parameter = format!("{group}_stiffness");
        let value = format!("{{value: 1, bounds: [0.5, 2], description: factor on the stiffness of {group}}}");
        self.entry(Block::Parameters, &parameter, &value, "");
        self.entry(Block::Overrides, group, &format!("{{stiffness: {parameter}}}"), "");
    }

    pub(in crate::exchange) fn is_empty(&self, block: Block) -> bool {
        self.counts[block as usize] == 0
    }

    /// The whole file below its head.
    pub(in crate::exchange) fn finish(&self, head: &str) -> String {
        let size = self.blocks.iter().map(String::len).sum::<usize>();
        let mut out = String::with_capacity(size + head.len() + 512);
        out.push_str(head);
        for (name, block) in BLOCKS.iter().zip(&self.blocks).filter(|(_, b)| !b.is_empty()) {
            let _ = write!(out, "\n{name}:\n{block}");
        }
        out
    }
}

/// A comment on one line, without control characters.
pub(in crate::exchange) fn clean(text: &str) -> String {
    let text: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    text.trim().to_string()
}

/// The value itself in as few digits as give it back.
pub(in crate::exchange) fn exact(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        "0".to_string()
    } else if (1e-4..1e9).contains(&size) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

/// A value that was computed, to twelve digits.
pub(in crate::exchange) fn computed(value: f64) -> String {
    exact(rounded(value))
}

/// A value to twelve significant digits.
pub(in crate::exchange) fn rounded(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}

/// A number with a unit.
pub(in crate::exchange) fn with_unit(number: &str, unit: &str) -> String {
    if unit.is_empty() { number.to_string() } else { format!("{number} {unit}") }
}

/// A flow list, broken into lines where it is long.
pub(in crate::exchange) fn list<T: AsRef<str>>(items: &[T]) -> String {
    let total: usize = items.iter().map(|i| i.as_ref().len() + 2).sum();
    if total < WIDTH - 20 {
        return format!("[{}]", items.iter().map(AsRef::as_ref).collect::<Vec<_>>().join(", "));
    }
    let mut out = String::with_capacity(total + total / 20);
    out.push('[');
    let mut column = WIDTH;
    for item in items {
        let item = item.as_ref();
        if column + item.len() + 2 > WIDTH {
            out.push_str("\n    ");
            column = 4;
        }
        out.push_str(item);
        out.push_str(", ");
        column += item.len() + 2;
    }
    let kept = out.trim_end_matches([',', ' ']).len();
    out.truncate(kept);
    out.push(']');
    out
}

/// A flow map.
pub(in crate::exchange) fn map<K: AsRef<str>, V: AsRef<str>>(items: &[(K, V)]) -> String {
    let parts: Vec<String> = items.iter().map(|(k, v)| format!("{}: {}", k.as_ref(), v.as_ref())).collect();
    format!("{{{}}}", parts.join(", "))
}

/// Three directions.
pub(in crate::exchange) fn direction(v: [f64; 3]) -> String {
    let shown = v.map(|c| computed(if c.abs() < 1e-15 { 0.0 } else { c }));
    format!("[{}]", shown.join(", "))
}

/// The entry of a frame: its origin as text and its axes, kept to the last bit.
pub(in crate::exchange) fn frame(origin: impl std::fmt::Display, axes: [[f64; 3]; 3]) -> String {
    let whole = |v: [f64; 3]| {
        if v.iter().all(|c| *c == 0.0 || c.abs() == 1.0) {
            direction(v)
        } else {
            format!("[{}]", v.map(exact).join(", "))
        }
    };
    format!("{{origin: {origin}, x: {}, xy: {}}}", whole(axes[0]), whole(axes[1]))
}
