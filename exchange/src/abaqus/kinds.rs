//! Types of elements: what each becomes, its faces, and which are refused.

use crate::patches;

/// What a type of element is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Family {
    Solid,
    Shell,
    Beam,
    Truss,
    Mass,
    RotaryInertia,
    /// Dofs that it joins: one to ground, two of two nodes, or the line between two nodes.
    Spring(Joined),
    /// Two nodes, joined as a section of its own says.
    Connector,
    Dashpot(Joined),
    /// Faces of a rigid body: nodes without stiffness and mass.
    Rigid,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Joined {
    Ground,
    Dofs,
    Line,
}

/// A type of element.
#[derive(Debug)]
pub(super) struct Kind {
    pub name: &'static str,
    pub family: Family,
    pub nodes: usize,
    /// The elements of retune that it becomes: type, and indices of its nodes.
    pub becomes: &'static [(&'static str, &'static [usize])],
    /// Whether its functions are linear, so that Abaqus lumps its mass.
    pub is_first_order: bool,
    /// How retune's formulation differs; nothing where it does not.
    pub differs: &'static str,
}

const ALL: [usize; 20] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19];

const fn first(n: usize) -> &'static [usize] {
    ALL.split_at(n).0
}

const fn kind(
    name: &'static str,
    family: Family,
    nodes: usize,
    becomes: &'static [(&'static str, &'static [usize])],
    is_first_order: bool,
    differs: &'static str,
) -> Kind {
    Kind { name, family, nodes, becomes, is_first_order, differs }
}

const REDUCED: &str =
    "C3D8R have one point and 0.005 G against hourglassing (hex8_reduced): on coarse meshes per cents from Abaqus";
const WEDGE6: &str = "C3D6 have six points and the solvers' two: stiffer on coarse meshes";
const WEDGE15: &str = "C3D15 have 21 points and the solvers' nine: equal as the mesh gets finer";
const HEX8I: &str = "C3D8I have another set of incompatible modes: the solvers' on parallelepipeds, per mille apart on distorted elements";
const HEX8: &str = "C3D8 are hex8 with incompatible modes, softer in bending than the solver's on coarse meshes";
const HYBRID: &str =
    "hybrid elements are those of displacements alone: stiffer where the material is nearly incompressible";
const MODIFIED: &str = "C3D10M are tet10: another formulation, the same as the mesh gets finer";
const SHELL: &str = "shells are retune's MITC shells: equal to the solver's as the mesh gets finer, not to the digits";
const BEAM31: &str =
    "B31 are exact beams with the shear factors of Abaqus: the solver's of one point are equal as the mesh gets finer";
const BEAM32: &str = "B32 are two exact beams each: equal as the mesh gets finer";

const HALVES: &[(&str, &[usize])] = &[("beam", &[0, 1]), ("beam", &[1, 2])];
const BAR_HALVES: &[(&str, &[usize])] = &[("bar", &[0, 1]), ("bar", &[1, 2])];
const H8: &[(&str, &[usize])] = &[("hex8", first(8))];
const H8R: &[(&str, &[usize])] = &[("hex8_reduced", first(8))];
const H20: &[(&str, &[usize])] = &[("hex20", first(20))];
const H20R: &[(&str, &[usize])] = &[("hex20_reduced", first(20))];
const T4: &[(&str, &[usize])] = &[("tet4", first(4))];
const T10: &[(&str, &[usize])] = &[("tet10", first(10))];
const W6: &[(&str, &[usize])] = &[("wedge6", first(6))];
const W15: &[(&str, &[usize])] = &[("wedge15", first(15))];
const Q4: &[(&str, &[usize])] = &[("shell4", first(4))];
const S3: &[(&str, &[usize])] = &[("shell3", first(3))];
const B2: &[(&str, &[usize])] = &[("beam", first(2))];
const BAR: &[(&str, &[usize])] = &[("bar", first(2))];

/// Types that are read.
pub(super) const KINDS: &[Kind] = &[
    kind("C3D4", Family::Solid, 4, T4, true, ""),
    kind("C3D4H", Family::Solid, 4, T4, true, HYBRID),
    kind("C3D5", Family::Solid, 5, &[("pyramid5", first(5))], true, ""),
    kind("C3D6", Family::Solid, 6, W6, true, WEDGE6),
    kind("C3D6H", Family::Solid, 6, W6, true, HYBRID),
    kind("C3D8", Family::Solid, 8, H8, true, HEX8),
    kind("C3D8I", Family::Solid, 8, H8, true, HEX8I),
    kind("C3D8R", Family::Solid, 8, H8R, true, REDUCED),
    kind("C3D8H", Family::Solid, 8, H8, true, HYBRID),
    kind("C3D8IH", Family::Solid, 8, H8, true, HYBRID),
    kind("C3D8RH", Family::Solid, 8, H8R, true, HYBRID),
    kind("C3D10", Family::Solid, 10, T10, false, ""),
    kind("C3D10H", Family::Solid, 10, T10, false, HYBRID),
    kind("C3D10M", Family::Solid, 10, T10, false, MODIFIED),
    kind("C3D10I", Family::Solid, 10, T10, false, MODIFIED),
    kind("C3D10HS", Family::Solid, 10, T10, false, HYBRID),
    kind("C3D15", Family::Solid, 15, W15, false, WEDGE15),
    kind("C3D20", Family::Solid, 20, H20, false, ""),
    kind("C3D20R", Family::Solid, 20, H20R, false, ""),
    kind("C3D20RI", Family::Solid, 20, H20R, false, ""),
    kind("C3D20H", Family::Solid, 20, H20, false, HYBRID),
    kind("C3D20RH", Family::Solid, 20, H20R, false, HYBRID),
    kind("S3", Family::Shell, 3, S3, true, SHELL),
    kind("S3R", Family::Shell, 3, S3, true, SHELL),
    kind("S3RS", Family::Shell, 3, S3, true, SHELL),
    kind("STRI3", Family::Shell, 3, S3, true, SHELL),
    kind("S4", Family::Shell, 4, Q4, true, SHELL),
    kind("S4R", Family::Shell, 4, Q4, true, SHELL),
    kind("S4R5", Family::Shell, 4, Q4, true, SHELL),
    kind("S4RS", Family::Shell, 4, Q4, true, SHELL),
    kind("S6", Family::Shell, 6, patches::TRIANGLE, false, patches::DIFFERS),
    kind("STRI65", Family::Shell, 6, patches::TRIANGLE, false, patches::DIFFERS),
    kind("S8", Family::Shell, 8, patches::QUADRILATERAL, false, patches::DIFFERS),
    kind("S8R", Family::Shell, 8, patches::QUADRILATERAL, false, patches::DIFFERS),
    kind("S8R5", Family::Shell, 8, patches::QUADRILATERAL, false, patches::DIFFERS),
    kind("B31", Family::Beam, 2, B2, true, BEAM31),
    kind("B31R", Family::Beam, 2, B2, true, BEAM31),
    kind("B31H", Family::Beam, 2, B2, true, BEAM31),
    kind("PIPE31", Family::Beam, 2, B2, true, BEAM31),
    kind("PIPE31H", Family::Beam, 2, B2, true, BEAM31),
    kind("B33", Family::Beam, 2, B2, false, ""),
    kind("B33H", Family::Beam, 2, B2, false, ""),
    kind("B32", Family::Beam, 3, HALVES, true, BEAM32),
    kind("B32R", Family::Beam, 3, HALVES, true, BEAM32),
    kind("B32H", Family::Beam, 3, HALVES, true, BEAM32),
    kind("PIPE32", Family::Beam, 3, HALVES, true, BEAM32),
    kind("T3D2", Family::Truss, 2, BAR, true, ""),
    kind("T3D2H", Family::Truss, 2, BAR, true, ""),
    kind(
        "T3D3",
        Family::Truss,
        3,
        BAR_HALVES,
        true,
        "T3D3 are two bars each, with a middle node that nothing holds sideways",
    ),
    kind("CONN3D2", Family::Connector, 2, &[], true, ""),
    kind("MASS", Family::Mass, 1, &[], true, ""),
    kind("ROTARYI", Family::RotaryInertia, 1, &[], true, ""),
    kind("SPRING1", Family::Spring(Joined::Ground), 1, &[], true, ""),
    kind("SPRING2", Family::Spring(Joined::Dofs), 2, &[], true, ""),
    kind("SPRINGA", Family::Spring(Joined::Line), 2, &[], true, ""),
    kind("DASHPOT1", Family::Dashpot(Joined::Ground), 1, &[], true, ""),
    kind("DASHPOT2", Family::Dashpot(Joined::Dofs), 2, &[], true, ""),
    kind("DASHPOTA", Family::Dashpot(Joined::Line), 2, &[], true, ""),
    kind("R3D3", Family::Rigid, 3, &[], true, ""),
    kind("R3D4", Family::Rigid, 4, &[], true, ""),
    kind("RB3D2", Family::Rigid, 2, &[], true, ""),
];

/// Beginnings of types that are refused, and why.
const REFUSED: &[(&str, &str)] = &[
    ("CPS", "plane elements are not read: a model of retune is a structure in space"),
    ("CPE", "plane elements are not read: a model of retune is a structure in space"),
    ("CPEG", "plane elements are not read: a model of retune is a structure in space"),
    ("CAX", "axisymmetric elements are not read: give the structure in space"),
    ("CGAX", "axisymmetric elements are not read: give the structure in space"),
    ("SAX", "axisymmetric elements are not read: give the structure in space"),
    ("MAX", "axisymmetric elements are not read: give the structure in space"),
    ("M3D", "membranes are not read; give shells (S4R, S3)"),
    ("SC", "continuum shells are not read; give solids or shells"),
    ("CSS", "continuum shells are not read; give solids or shells"),
    ("B21", "plane beams are not read; give B31"),
    ("B22", "plane beams are not read; give B32"),
    ("B23", "plane beams are not read; give B33"),
    ("B31OS", "beams that warp are not read; give B31"),
    ("B32OS", "beams that warp are not read; give B32"),
    ("B34", "beams of this type are not read; give B33"),
    ("T2D", "plane trusses are not read; give T3D2"),
    ("PIPE2", "plane pipes are not read; give PIPE31"),
    ("ELBOW", "elbows are not read; give PIPE31"),
    ("CONN2", "plane connectors are not read; give CONN3D2"),
    ("COH", "cohesive elements are not read; give a TIE"),
    ("GAP", "contact is not linear; give a SPRINGA for a gap that is closed"),
    ("DC", "elements of heat are not structure"),
    ("DS", "elements of heat are not structure"),
    ("D", "elements of fluid networks and heat are not structure"),
    ("AC", "fluids are not read"),
    ("F3D", "fluids are not read"),
    ("ITS", "contact is not linear"),
    ("JOINTC", "flexible joints are not read; give SPRING2"),
    ("LS", "line springs are not read"),
    ("SFM", "surface elements are not read"),
    ("U", "elements of the user have no matrices in the deck"),
    ("C3D27", "bricks of 27 nodes are not read; give C3D20"),
    ("CCL", "cylindrical elements are not read; give C3D20"),
    ("HEATCAP", "elements of heat are not structure"),
    ("S9R5", "shells of nine nodes are not read; give S4R"),
    ("R2D", "plane rigid elements are not read"),
];

/// The type of this name, in capitals; else why it is not read.
pub(super) fn find(name: &str) -> Result<&'static Kind, String> {
    // The numbering of groups in one type, as in `US4` of CalculiX, is the user's; thermal twins of solids are their structure.
    if let Some(found) = KINDS.iter().find(|k| k.name == name) {
        return Ok(found);
    }
    let longest = REFUSED.iter().filter(|r| name.starts_with(r.0)).max_by_key(|r| r.0.len());
    Err(match longest {
        Some((_, why)) => format!("elements of the type {name} are not read: {why}"),
        None => {
            let suggestion = retune::catalogue::did_you_mean(name, KINDS.iter().map(|k| k.name));
            format!("no element of the type `{name}` is known{suggestion}")
        }
    })
}

/// Faces of a type by their numbers, as indices of corners; those between are left out.
pub(super) fn face(kind: &Kind, number: usize) -> Option<&'static [usize]> {
    const HEX: [&[usize]; 6] =
        [&[0, 1, 2, 3], &[4, 7, 6, 5], &[0, 4, 5, 1], &[1, 5, 6, 2], &[2, 6, 7, 3], &[3, 7, 4, 0]];
    const TET: [&[usize]; 4] = [&[0, 1, 2], &[0, 3, 1], &[1, 3, 2], &[2, 3, 0]];
    const WEDGE: [&[usize]; 5] = [&[0, 1, 2], &[3, 5, 4], &[0, 3, 4, 1], &[1, 4, 5, 2], &[2, 5, 3, 0]];
    const PYRAMID: [&[usize]; 5] = [&[0, 1, 2, 3], &[0, 4, 1], &[1, 4, 2], &[2, 4, 3], &[3, 4, 0]];
    let of = |all: &'static [&'static [usize]]| all.get(number.checked_sub(1)?).copied();
    match (kind.family, kind.nodes) {
        (Family::Solid, 8 | 20) => of(&HEX),
        (Family::Solid, 4 | 10) => of(&TET),
        (Family::Solid, 6 | 15) => of(&WEDGE),
        (Family::Solid, 5) => of(&PYRAMID),
        (Family::Shell | Family::Rigid, 3 | 6) => (number <= 2).then_some(first(3)),
        (Family::Shell | Family::Rigid, 4 | 8) => (number <= 2).then_some(first(4)),
        _ => None,
    }
}

/// Middle nodes of the edges of a face of a quadratic type: of each edge from a corner to the next.
pub(super) fn middles(kind: &Kind, face: &[usize]) -> Vec<usize> {
    const HEX: [[usize; 3]; 12] = [
        [0, 1, 8],
        [1, 2, 9],
        [2, 3, 10],
        [3, 0, 11],
        [4, 5, 12],
        [5, 6, 13],
        [6, 7, 14],
        [7, 4, 15],
        [0, 4, 16],
        [1, 5, 17],
        [2, 6, 18],
        [3, 7, 19],
    ];
    const TET: [[usize; 3]; 6] = [[0, 1, 4], [1, 2, 5], [2, 0, 6], [0, 3, 7], [1, 3, 8], [2, 3, 9]];
    const WEDGE: [[usize; 3]; 9] =
        [[0, 1, 6], [1, 2, 7], [2, 0, 8], [3, 4, 9], [4, 5, 10], [5, 3, 11], [0, 3, 12], [1, 4, 13], [2, 5, 14]];
    const QUAD: [[usize; 3]; 4] = [[0, 1, 4], [1, 2, 5], [2, 3, 6], [3, 0, 7]];
    const TRIANGLE: [[usize; 3]; 3] = [[0, 1, 3], [1, 2, 4], [2, 0, 5]];
    let edges: &[[usize; 3]] = match (kind.family, kind.nodes) {
        (Family::Solid, 20) => &HEX,
        (Family::Solid, 10) => &TET,
        (Family::Solid, 15) => &WEDGE,
        (Family::Shell, 8) => &QUAD,
        (Family::Shell, 6) => &TRIANGLE,
        _ => return Vec::new(),
    };
    let count = if face.len() == 2 { 1 } else { face.len() };
    (0..count)
        .filter_map(|i| {
            let (a, b) = (face[i], face[(i + 1) % face.len()]);
            edges.iter().find(|e| (e[0] == a && e[1] == b) || (e[0] == b && e[1] == a)).map(|e| e[2])
        })
        .collect()
}

/// Number of faces of a type.
pub(super) fn n_faces(kind: &Kind) -> usize {
    (1..=6).take_while(|n| face(kind, *n).is_some()).count()
}
