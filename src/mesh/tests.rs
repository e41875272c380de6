//! Files of every kind that is read, and files that are none.

use super::{Mesh, MeshNode, MeshSet, Shape, read, write_gmsh};

/// A square of two triangles and a quadrilateral beside it, with its left edge and a corner.
const SQUARES: &str = "$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
3
0 4 \"corner\"
1 1 \"root edge\"
2 2 \"skin\"
$EndPhysicalNames
$Entities
1 1 2 0
7 2 1 0 1 4
1 0 0 0 0 1 0 1 1 2 3 4
1 0 0 0 1 1 0 1 2 0
2 1 0 0 2 1 0 2 2 9 0
$EndEntities
$Nodes
2 6 1 12
1 1 0 2
1
4
0 0 0
0 1 0
2 1 1 4
2
3
11
12
1 0 0 0.5 0.5
1 1 0 0.5 0.5
2 0 0 0.5 0.5
2 1 0 0.5 0.5
$EndNodes
$Elements
4 5 1 9
0 7 15 1
9 12
1 1 1 1
1 1 4
2 1 2 2
2 1 2 3
3 1 3 4
2 2 3 1
5 2 11 12 3
$EndElements
";

fn check(mesh: &Mesh) {
    assert_eq!(mesh.nodes.len(), 6);
    assert_eq!(mesh.nodes[mesh.node(12).unwrap()].at, [2.0, 1.0, 0.0]);
    let of = |name: &str| -> (Vec<u64>, Vec<u64>) {
        let set = mesh.set(name).unwrap_or_else(|| panic!("no {name}"));
        let cells = set.cells.iter().map(|&c| mesh.cells[c].id).collect();
        (cells, mesh.nodes_of_set(set).iter().map(|&n| mesh.nodes[n].id).collect())
    };
    assert_eq!(of("corner"), (vec![9], vec![12]));
    assert_eq!(of("root edge"), (vec![1], vec![1, 4]));
    assert_eq!(of("skin"), (vec![2, 3, 5], vec![1, 2, 3, 4, 11, 12]));
    assert_eq!(of("surface_9"), (vec![5], vec![2, 11, 12, 3]));
    let shapes: Vec<Shape> = mesh.cells.iter().map(|c| c.shape).collect();
    assert_eq!(shapes[2..], [Shape::Triangle3, Shape::Triangle3, Shape::Quadrilateral4]);
}

/// The text with its numbers as bytes: fours for integers, eights for sizes and coordinates.
fn binary(widths: &str) -> Vec<u8> {
    let mut out = Vec::new();
    let mut in_numbers = false;
    let mut kinds = widths.chars();
    for line in SQUARES.lines() {
        if line.starts_with('$') {
            if in_numbers && line.starts_with("$End") {
                out.push(b'\n');
            }
            in_numbers = matches!(line, "$Entities" | "$Nodes" | "$Elements");
            out.extend(line.bytes().chain([b'\n']));
        } else if line == "4.1 0 8" {
            out.extend(b"4.1 1 8\n\x01\0\0\0\n");
        } else if in_numbers {
            for word in line.split_whitespace() {
                match kinds.next().unwrap() {
                    'i' => out.extend(word.parse::<i32>().unwrap().to_le_bytes()),
                    's' => out.extend(word.parse::<u64>().unwrap().to_le_bytes()),
                    _ => out.extend(word.parse::<f64>().unwrap().to_le_bytes()),
                }
            }
        } else {
            out.extend(line.bytes().chain([b'\n']));
        }
    }
    assert_eq!(kinds.next(), None);
    out
}

#[test]
fn gmsh_4_1_is_read_as_text_and_as_bytes() {
    check(&read(SQUARES.as_bytes()).unwrap());
    let entities = ["ssss", "idddsi", "iddddddsisii", "iddddddsis", "iddddddsiis"].concat();
    let nodes = ["ssss", "iiis", "ss", "dddddd", "iiis", "ssss", &"ddddd".repeat(4)].concat();
    // A parametric node of a surface has two coordinates more.
    let text = binary(
        &[entities, nodes, ["ssss", "iiis", "ss", "iiis", "sss", "iiis", "ssssssss", "iiis", "sssss"].concat()]
            .concat(),
    );
    check(&read(&text).unwrap());
}

#[test]
fn gmsh_2_2_is_read_as_text_and_as_bytes() {
    let text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 5 \"skin\"\n$EndPhysicalNames\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$EndNodes\n$Elements\n3\n1 1 2 7 1 1 4\n2 2 2 5 1 1 2 3\n3 2 2 5 1 1 3 4\n$EndElements\n";
    let mesh = read(text.as_bytes()).unwrap();
    let mut bytes = b"$MeshFormat\n2.2 1 8\n\x01\0\0\0\n$EndMeshFormat\n$PhysicalNames\n1\n2 5 \"skin\"\n$EndPhysicalNames\n$Nodes\n4\n".to_vec();
    for (id, x, y) in [(1_i32, 0.0_f64, 0.0_f64), (2, 1.0, 0.0), (3, 1.0, 1.0), (4, 0.0, 1.0)] {
        bytes.extend(
            id.to_le_bytes().into_iter().chain(x.to_le_bytes()).chain(y.to_le_bytes()).chain(0f64.to_le_bytes()),
        );
    }
    bytes.extend(b"\n$EndNodes\n$Elements\n3\n");
    for number in [1_i32, 1, 2, 1, 7, 1, 1, 4, 2, 2, 2, 2, 5, 1, 1, 2, 3, 3, 5, 1, 1, 3, 4] {
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend(b"\n$EndElements\n");
    assert_eq!(read(&bytes).unwrap(), mesh);
    let skin = mesh.set("skin").unwrap();
    assert_eq!(skin.cells, [1, 2]);
    assert_eq!(mesh.set("line_7").unwrap().cells, [0]);
    assert_eq!(mesh.nodes_of(2), [0, 2, 3]);
}

/// The squares once more, as decks write them.
const KEYWORDS: &str = "*HEADING
squares
*NODE
1, 0., 0., 0.
4, 0., 1.
2, 1., 0.
3, 1., 1., 0.
11, 2., 0.
12, 2., 1.
*ELEMENT, TYPE=S3R, ELSET=skin
2, 1, 2, 3
3, 1, 3,
 4
*ELEMENT, TYPE=S4R, ELSET=quad
5, 2, 11, 12, 3
*ELEMENT, TYPE=MASS, ELSET=lump
7, 12
*ELSET, ELSET=SKIN
quad
*NSET, NSET=root edge, GENERATE
1, 4, 3
*NSET, NSET=corner
12
*SHELL SECTION, ELSET=skin, MATERIAL=none
0.1
";

#[test]
fn decks_are_meshes_with_their_sets() {
    let mesh = read(KEYWORDS.as_bytes()).unwrap();
    let of = |name: &str| -> (Vec<u64>, Vec<u64>) {
        let set = mesh.set(name).unwrap_or_else(|| panic!("no {name}"));
        let cells = set.cells.iter().map(|&c| mesh.cells[c].id).collect();
        (cells, mesh.nodes_of_set(set).iter().map(|&n| mesh.nodes[n].id).collect())
    };
    assert_eq!(of("SKIN"), (vec![2, 3, 5], vec![1, 2, 3, 4, 11, 12]));
    assert_eq!(of("QUAD"), (vec![5], vec![2, 11, 12, 3]));
    assert_eq!(of("ROOT EDGE"), (vec![1, 4], vec![1, 4]));
    assert_eq!(of("CORNER"), (vec![12], vec![12]));
    let bulk = "SOL 103\nCEND\nBEGIN BULK\nGRID,1,,0.,0.\nGRID,2,,1.\nGRID,3,,1.,1.\nGRID,4,,0.,1.\nGRID    11              2.\nGRID,12,,2.,1.\n\
                CTRIA3,2,9,1,2,3\nCTRIA3,3,9,1,3,4\nCQUAD4,5,9,2,11,12,3\nPSHELL,9,1,.1\nCBAR,6,4,1,2,0.,0.,1.\nCONM2,7,12,,3.\nENDDATA\n";
    let same = read(bulk.as_bytes()).unwrap();
    let skin = same.set("p9").unwrap();
    let cells = |m: &Mesh, set: &MeshSet| -> Vec<Vec<u64>> {
        set.cells.iter().map(|&c| m.nodes_of(c).iter().map(|&n| m.nodes[n].id).collect()).collect()
    };
    assert_eq!(cells(&same, skin), cells(&mesh, mesh.set("SKIN").unwrap()));
    assert_eq!(same.cells[same.set("p4").unwrap().cells[0]].shape, Shape::Line2);
    for (text, message) in [
        (KEYWORDS.replace("S4R", "S4Q9"), None),
        (KEYWORDS.replace("TYPE=S4R", "TYPE=Q4"), Some("line 14: *ELEMENT: no element of the type `Q4` is known")),
        (
            KEYWORDS.replace("5, 2, 11, 12, 3", "5, 2, 11, 12, 33"),
            Some("line 15: *ELEMENT, field 5 (node): there is no node 33"),
        ),
        (
            KEYWORDS.replace("*ELEMENT, TYPE=MASS", "*PART, NAME=a\n*PART, NAME=b\n*ELEMENT, TYPE=MASS"),
            Some("line 17: *PART: a deck of several parts is not a mesh"),
        ),
        (KEYWORDS.replace("\nquad", "\nquat"), Some("there is no set `quat` above")),
        (KEYWORDS.replace("*HEADING\nsquares", "*INCLUDE, INPUT=other.inp"), Some("other.inp")),
        (bulk.replace("GRID,12,", "GRID,12,3"), Some("grids in axes of their own are read by `retune import`")),
    ] {
        match (read(text.as_bytes()), message) {
            (Ok(_), None) => {}
            (Err(e), Some(message)) => assert!(e.to_string().contains(message), "{e}"),
            (found, message) => panic!("{found:?} {message:?}"),
        }
    }
}

/// Middles of edges are between the corners that the elements of the same name say.
#[test]
fn second_order_cells_have_the_order_of_the_elements() {
    use crate::element::by_name;
    // Corners at the points of a unit cell; a node in the middle of each edge of gmsh's own list.
    let cube = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [0, 0, 2], [2, 0, 2], [2, 2, 2], [0, 2, 2]];
    let hex = vec![[0, 1], [0, 3], [0, 4], [1, 2], [1, 5], [2, 3], [2, 6], [3, 7], [4, 5], [4, 7], [5, 6], [6, 7]];
    let wedge = vec![[0, 1], [0, 2], [0, 3], [1, 2], [1, 4], [2, 5], [3, 4], [3, 5], [4, 5]];
    let tet = vec![[0, 1], [1, 2], [2, 0], [3, 0], [2, 3], [1, 3]];
    let pyramid = vec![[0, 1], [0, 3], [0, 4], [1, 2], [1, 4], [2, 3], [2, 4], [3, 4]];
    let corner = |which: &[usize]| which.iter().map(|&k| cube[k]).collect::<Vec<_>>();
    for (kind, name, corners, edges) in [
        (17, "hex20", corner(&[0, 1, 2, 3, 4, 5, 6, 7]), hex),
        (18, "wedge15", corner(&[0, 1, 2, 4, 5, 6]), wedge),
        (11, "tet10", corner(&[0, 1, 3, 4]), tet),
        (19, "pyramid13", [corner(&[0, 1, 2, 3]), vec![[1, 1, 2]]].concat(), pyramid),
    ] {
        // Twice as large, so that middles are whole numbers as well.
        let points: Vec<[i32; 3]> = corners
            .iter()
            .copied()
            .map(|c| c.map(|x| 2 * x))
            .chain({
                let edges = edges.clone();
                let corners = corners.clone();
                edges.into_iter().map(move |e| std::array::from_fn(|i| corners[e[0]][i] + corners[e[1]][i]))
            })
            .collect();
        let n = points.len();
        let mut text = format!("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{n}\n");
        for (i, p) in points.iter().enumerate() {
            text += &format!("{} {} {} {}\n", i + 1, p[0], p[1], p[2]);
        }
        let list: Vec<String> = (1..=n).map(|i| i.to_string()).collect();
        text += &format!("$EndNodes\n$Elements\n1\n1 {kind} 2 1 1 {}\n$EndElements\n", list.join(" "));
        let mesh = read(text.as_bytes()).unwrap();
        let at: Vec<[f64; 3]> = mesh.nodes_of(0).iter().map(|&k| mesh.nodes[k].at).collect();
        let element = by_name(name).unwrap();
        let values: Vec<Option<f64>> = element
            .properties()
            .iter()
            .map(|p| [("E", 1.0), ("nu", 0.2), ("density", 1.0)].iter().find(|g| g.0 == p.name).map(|g| g.1))
            .collect();
        let input = crate::element::ElementInput { points: &at, values: &values };
        // Edges that cross would not have the volume of the cell, or none at all.
        let mass = element.mass(&input).unwrap();
        let total: f64 = (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).map(|(i, j)| mass.get(6 * i, 6 * j)).sum();
        let volume = match name {
            "hex20" => 64.0,
            "wedge15" => 32.0,
            "tet10" => 64.0 / 6.0,
            _ => 64.0 / 3.0,
        };
        assert!((total / volume - 1.0).abs() < 1e-9, "{name}: {total} {volume}");
    }
}

/// Cut, empty and wrong files are refused with the place.
/// Nodes, then cells and sets by their numbers.
type Told = (Vec<MeshNode>, Vec<(u64, Shape, Vec<u64>)>, Vec<(String, Vec<u64>)>);

fn told(mesh: &Mesh) -> Told {
    let nodes = |c: usize| mesh.nodes_of(c).iter().map(|&n| mesh.nodes[n].id).collect();
    let mut cells: Vec<_> = mesh.cells.iter().enumerate().map(|(i, c)| (c.id, c.shape, nodes(i))).collect();
    cells.sort();
    let mut sets: Vec<(String, Vec<u64>)> = Vec::new();
    for set in &mesh.sets {
        let mut ids: Vec<u64> = set.cells.iter().map(|&c| mesh.cells[c].id).collect();
        ids.sort_unstable();
        sets.push((set.name.clone(), ids));
    }
    sets.sort();
    (mesh.nodes.clone(), cells, sets)
}

#[test]
fn what_is_written_is_read_as_the_same_mesh() {
    let squares = read(SQUARES.as_bytes()).unwrap();
    assert_eq!(told(&read(write_gmsh(&squares).as_bytes()).unwrap()), told(&squares));
    // Every shape, in sets that share cells and have several dimensions, with numbers that no short decimal is.
    let shapes = [
        Shape::Point,
        Shape::Line2,
        Shape::Triangle3,
        Shape::Quadrilateral4,
        Shape::Tetrahedron4,
        Shape::Tetrahedron10,
        Shape::Hexahedron8,
        Shape::Hexahedron20,
        Shape::Wedge6,
        Shape::Wedge15,
        Shape::Pyramid5,
        Shape::Pyramid13,
    ];
    let mut mesh = Mesh::default();
    for id in 1..=20 {
        mesh.add_node(MeshNode { id: 3 * id, at: [1.0 / id as f64, -1e-7 * id as f64, 1e9 / 7.0] });
    }
    for (i, shape) in shapes.into_iter().enumerate() {
        mesh.add_cell(100 - i as u64, shape, (0..shape.n_nodes()).rev());
    }
    mesh.sets.push(MeshSet { name: "all of it".into(), cells: (0..shapes.len()).collect() });
    mesh.sets.push(MeshSet { name: "some".into(), cells: vec![1, 3, 5] });
    assert_eq!(told(&read(write_gmsh(&mesh).as_bytes()).unwrap()), told(&mesh));
    assert_eq!(told(&read(write_gmsh(&Mesh::default()).as_bytes()).unwrap()), told(&Mesh::default()));
}

#[test]
fn damaged_files_are_refused() {
    for end in (0..SQUARES.len() - 1).step_by(7) {
        let _ = read(&SQUARES.as_bytes()[..end]);
    }
    for (from, to, expected) in [
        ("4.1 0 8", "4.0 0 8", "version 4.0"),
        ("3 1 3 4\n", "3 1 3 99\n", "node 99"),
        ("2 6 1 12", "2 6 1 x", "`x`"),
        ("1 1 1 1\n1 1 4", "1 1 93 1\n1 1 4", "type 93"),
        ("2 1 1 4\n", "2 1 1 4000000000\n", "do not fit"),
        ("$Entities", "$Entity", "$EndEntity"),
        ("0 1 0\n", "0 nan 0\n", "finite"),
        ("$EndElements\n", "", "$EndElements"),
        ("2\n3\n11\n12", "2\n3\n11\n11", "is defined twice"),
    ] {
        let text = SQUARES.replacen(from, to, 1);
        assert_ne!(text, SQUARES);
        let error = read(text.as_bytes()).unwrap_err().to_string();
        assert!(error.contains(expected) && error.contains("line"), "{from}: {error}");
    }
    assert!(read(b"solid cube").unwrap_err().to_string().contains("gmsh"));
}
