//! Degrees of freedom of a node.

use std::fmt;

/// One degree of freedom of a node: a displacement or a rotation (right-handed) along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Dof {
    Ux,
    Uy,
    Uz,
    Rx,
    Ry,
    Rz,
}

impl Dof {
    /// All six, in the order of every element matrix.
    pub const ALL: [Dof; 6] = [Dof::Ux, Dof::Uy, Dof::Uz, Dof::Rx, Dof::Ry, Dof::Rz];

    /// The name in YAML: `ux` ... `rz`.
    pub fn name(self) -> &'static str {
        ["ux", "uy", "uz", "rx", "ry", "rz"][self as usize]
    }

    /// From its name in YAML.
    pub fn from_name(name: &str) -> Option<Dof> {
        Self::ALL.into_iter().find(|d| d.name() == name)
    }

    /// Whether it is a rotation.
    pub fn is_rotation(self) -> bool {
        self as usize >= 3
    }

    /// SI unit of a compliance along or about it.
    pub fn compliance_unit(self) -> &'static str {
        if self.is_rotation() { "rad/(N m)" } else { "m/N" }
    }

    /// Axis of the displacement or rotation: 0, 1, 2.
    pub fn axis(self) -> usize {
        self as usize % 3
    }
}

impl fmt::Display for Dof {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
