//! Shells of eight and six nodes as patches of flat shells on the same nodes: corners first, then the middles of the edges from the first on.

/// A patch: type and indices of nodes of each of its shells.
pub(super) type Patch = &'static [(&'static str, &'static [usize])];

/// Four triangles at the corners and a quadrilateral between the middles.
pub(super) const QUADRILATERAL: Patch = &[
    ("shell4", &[4, 5, 6, 7]),
    ("shell3", &[0, 4, 7]),
    ("shell3", &[1, 5, 4]),
    ("shell3", &[2, 6, 5]),
    ("shell3", &[3, 7, 6]),
];

/// Four triangles.
pub(super) const TRIANGLE: Patch =
    &[("shell3", &[0, 3, 5]), ("shell3", &[3, 1, 4]), ("shell3", &[5, 4, 2]), ("shell3", &[3, 4, 5])];

/// What that approximates, for reports.
pub(super) const DIFFERS: &str =
    "shells of eight and six nodes are a patch of flat shells on the same nodes: they need a finer mesh";
