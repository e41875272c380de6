//! Every reader on a small file of its format, on damaged copies of it, and on files of other programs where they are.

#[path = "../../base/src/arrays/mutate.rs"]
mod mutate;

use super::*;
use crate::arrays::{npy, npz};
use crate::element::Dof;

/// Row, column, value of all entries, counted from 1, a triangle with its image.
fn full(matrix: &Matrix) -> Vec<(u32, u32, f64)> {
    matrix.full().iter().map(|e| (e.row + 1, e.column + 1, e.value)).collect()
}

/// K of two springs in a row: 2 -1; -1 1.
const CHAIN: [(u32, u32, f64); 4] = [(1, 1, 2.0), (2, 1, -1.0), (1, 2, -1.0), (2, 2, 1.0)];

const MARKET: &str =
    "%%MatrixMarket matrix coordinate real symmetric\n% two springs\n2 2 3\n1 1 2.0\n2 1 -1\n2 2 1e0\n";
const MARKET_ARRAY: &str = "%%MatrixMarket matrix array real symmetric\n2 2\n2\n-1\n1\n";
const STI: &str = "1 1  2.0000000000000e+00\n1 2  -1.0000000000000e+00\n2 2  1.0000000000000e+00\n";
const ABAQUS: &str = "** ASSEMBLED STIFFNESS MATRIX\n1,1, 1,1,  2.000000000000000e+00\n2,1, 1,1, -1.0\n2,1, 2,1, 1.0\n";
const ELEMENTS: &str = "** ELEMENT NUMBER 1 STEP NUMBER 1 INCREMENT NUMBER 1 ELEMENT TYPE SPRINGA\n*USER ELEMENT, NODES=2, LINEAR\n** ELEMENT NODES\n** 1, 2\n1\n*MATRIX, TYPE=STIFFNESS\n1.0,\n-1.0, 1.0\n*MATRIX, TYPE=MASS\n 0.5\n 0, 0.5\n** ELEMENT NUMBER 2 STEP NUMBER 1\n*USER ELEMENT, NODES=1, LINEAR\n** ELEMENT NODES\n** 1\n1\n*MATRIX, TYPE=STIFFNESS\n1.0\n";
const HARWELL: &str = "Two springs                                                             KEY     \n             4             1             1             2             0\nRSA                        2             2             3             0\n(3I4)           (3I4)           (2E20.12)           \n   1   3   4\n   1   2   2\n  2.000000000000E+00 -1.000000000000E+00\n  1.000000000000E+00\n";
const DMIG: &str = "$ two springs\nDMIG    KAAX           0       6       2       0                       2\nDMIG*   KAAX                           1               1\n*                      1               1 2.000000000D+00\nDMIG*   KAAX                           2               1\n*                      1               1-1.000000000D+00\n*                      2               1 1.000000000D+00\nGRID           1             0.5      0.      0.\nGRID,2,,1.5,,\n";
const DMIG_SHORT: &str = "DMIG    KAAX           0       6       2       0                       2\nDMIG    KAAX           1       1               1       12.\n+              2       1-1.\nDMIG,KAAX,2,1,,2,1,1.+0\n";
const OP4_DENSE: &str = "       2       2       6       2K       1P,3E23.16\n       1       1       2\n 2.0000000000000000E+00-1.0000000000000000E+00\n       2       1       2\n-1.0000000000000000E+00 1.0000000000000000E+00\n       3       1       1\n 1.0000000000000000E+00\n";
const OP4_SPARSE: &str = "       2       2       6       2K       1P,3E23.16\n       1       0       5\n  327681\n 2.0000000000000000E+00-1.0000000000000000E+00\n       2       0       5\n  327681\n-1.0000000000000000E+00 1.0000000000000000E+00\n       3       1       1\n 1.0000000000000000E+00\n";

fn small_files() -> Vec<(&'static str, &'static str, Vec<u8>)> {
    let text = |name, reader, text: &str| (name, reader, text.as_bytes().to_vec());
    let chain = read("k.mtx", MARKET.as_bytes()).unwrap().matrices.remove(0);
    let written = |format| write("k", std::slice::from_ref(&chain), &[], format).unwrap().remove(0).1;
    let dense = npy::Array { shape: vec![2, 2], values: npy::Values::Real(vec![2.0, -1.0, -1.0, 1.0]) };
    vec![
        text("k.mtx", "matrix-market", MARKET),
        text("k.mtx", "matrix-market", MARKET_ARRAY),
        text("job.sti", "indexed-lines", STI),
        text("job_STIF2.mtx", "abaqus-matrix", ABAQUS),
        text("job.inp", "abaqus-element-matrices", ELEMENTS),
        text("k.rsa", "harwell-boeing", HARWELL),
        text("k.pch", "bulk-data", DMIG),
        text("k.bdf", "bulk-data", DMIG_SHORT),
        text("k.op4", "output4", OP4_DENSE),
        text("k.op4", "output4", OP4_SPARSE),
        ("k.op4", "output4", written(MatrixFormat::Output4)),
        ("k.op4", "output4", written(MatrixFormat::Output4Binary)),
        ("k.npz", "numpy", written(MatrixFormat::Npz)),
        ("k.npy", "numpy", npy::write(&dense)),
        ("k.npz", "numpy", npz::write(&[("K", npy::write(&dense))])),
    ]
}

#[test]
fn every_format_gives_the_same_chain() {
    for (name, reader, bytes) in small_files() {
        let file = File { name, bytes: &bytes };
        assert_eq!(reader_of(&file).unwrap().name(), reader, "{}", String::from_utf8_lossy(&bytes));
        let contents = read(name, &bytes).unwrap_or_else(|e| panic!("{reader}: {e}"));
        assert_eq!(full(&contents.matrices[0]), CHAIN, "{reader}");
        assert!(contents.matrices[0].symmetric(false).is_ok(), "{reader}");
    }
}

#[test]
fn labels_positions_and_second_matrices_come_with_them() {
    let label = |node: &str| Label { node: node.to_string(), dof: Some(Dof::Ux) };
    let dmig = read("k.pch", DMIG.as_bytes()).unwrap();
    assert_eq!(dmig.matrices[0].rows, [label("1"), label("2")]);
    assert_eq!(dmig.positions, [("1".to_string(), [0.5, 0.0, 0.0]), ("2".to_string(), [1.5, 0.0, 0.0])]);
    let elements = read("job.inp", ELEMENTS.as_bytes()).unwrap();
    assert_eq!(elements.matrices.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(), ["stiffness", "mass"]);
    assert_eq!(full(&elements.matrices[1]), [(1, 1, 0.5), (2, 2, 0.5)]);
    let abaqus = read("j.mtx", ABAQUS.as_bytes()).unwrap();
    assert_eq!(abaqus.matrices[0].rows, [label("1"), label("2")]);
    let dofs = read("job.dof", b"7.1\n7.2\n12.3\n").unwrap().dofs;
    assert_eq!(dofs.iter().map(|d| d.label.to_string()).collect::<Vec<_>>(), ["7.ux", "7.uy", "12.uz"]);
    let mapping =
        read("k.mapping", b"   Matrix Eqn     Node    DOF\n    2    1   UY\n    1    1   UX\n    3   4   ROTZ\n")
            .unwrap();
    assert_eq!(mapping.dofs.iter().map(|d| d.label.to_string()).collect::<Vec<_>>(), ["1.ux", "1.uy", "4.rz"]);
    let nodes = read("a.inp", b"*HEADING\n beam\n*NODE, NSET=N\n1, 0., 1.5, 2\n2,1\n*ELEMENT\n1,1,2\n").unwrap();
    assert_eq!(nodes.positions[0], ("1".to_string(), [0.0, 1.5, 2.0]));
    let table = read("t.csv", b"node;dof;x;y;z;frame\ntip;ux;1;2;3;\ntip;6;1;2;3;f\nq1;modal;;;;\n").unwrap().dofs;
    assert_eq!(table[1].label, Label { node: "tip".into(), dof: Some(Dof::Rz) });
    assert_eq!((table[1].frame.as_deref(), table[2].label.dof, table[2].position), (Some("f"), None, None));
    // A scalar point is a modal coordinate.
    let scalar =
        DMIG_SHORT.replace("       2       1-1.", "       2       0-1.").replace("KAAX,2,1,,2,1", "KAAX,2,0,,2,0");
    assert_eq!(read("k.bdf", scalar.as_bytes()).unwrap().matrices[0].rows[1].dof, None);
}

#[test]
fn wrong_files_are_told_with_their_line() {
    for (name, text, words) in [
        ("k.mtx", MARKET.replace("2 1 -1", "2 3 -1"), "line 5: `2 3 -1` stands where"),
        ("k.mtx", MARKET.replace("2 2 3", "2 2 4"), "it has 3 entries and announces 4"),
        ("k.mtx", MARKET.replace(" real ", " complex "), "real"),
        ("k.mtx", MARKET.replace("-1\n", "nan\n"), "line 5"),
        ("k.op4", OP4_DENSE.replace("       2       1       2", "       2       2       2"), "within the matrix"),
        ("k.op4", OP4_DENSE.lines().take(3).collect::<Vec<_>>().join("\n"), "ends within the matrix `K`"),
        ("k.pch", DMIG.replace("-1.000000000D+00", "x1.000000000D+00"), "line 5"),
        ("k.pch", DMIG.replace("DMIG    KAAX           0", "DMIG    MAAX           0"), "before its columns"),
        ("k.rsa", HARWELL.replace("RSA", "CSA"), "complex"),
        ("t.csv", "node,dof,x,y,z\n1,ux,1,2\n".to_string(), "three coordinates"),
        ("t.csv", "node,dof,w\n1,ux,1\n".to_string(), "a column `node`"),
        ("a.inp", "*NODE\n1,a,2,3\n".to_string(), "line 2"),
        ("x.bin", "\u{1}\u{2}hello".to_string(), "not a format of matrices"),
    ] {
        let said = read(name, text.as_bytes()).unwrap_err().to_string();
        assert!(said.contains(words), "{name}: {said}");
    }
}

#[test]
fn mutated_files_do_no_harm() {
    for (name, reader, bytes) in small_files() {
        let of = MATRIX_READERS.iter().find(|r| r.name() == reader).unwrap();
        mutate::all(std::slice::from_ref(&bytes), 2_000, |bytes| {
            // Whoever recognises it, and its own reader whether it does or not.
            for matrix in read(name, bytes).into_iter().flat_map(|c| c.matrices) {
                inspect(&matrix, &[]);
            }
            of.read(&File { name, bytes }).is_ok()
        });
    }
    for (name, text) in [
        ("job.dof", "7.1\n7.2\n"),
        ("k.mapping", " Matrix Eqn Node DOF\n 1 1 UX\n 2 1 UY\n"),
        ("a.inp", "*NODE\n1,0,0,0\n2,1,0,0\n"),
        ("t.csv", "node,dof,x,y,z\n1,ux,1,2,3\n2,uy,1,2,4\n"),
    ] {
        mutate::all(&[text.as_bytes().to_vec()], 2_000, |bytes| read(name, bytes).is_ok());
    }
}

/// A head that announces 4 · 10⁹ rows costs no memory.
#[test]
fn sizes_that_no_file_has_are_refused_or_cost_nothing() {
    let huge = "%%MatrixMarket matrix coordinate real general\n4000000000 4000000000 1\n1 1 1.0\n";
    let matrix = read("k.mtx", huge.as_bytes()).unwrap().matrices.remove(0);
    assert_eq!(matrix.n_rows, 4_000_000_000);
    assert_eq!(inspect(&matrix, &[]).inertia, None);
    let huge = "%%MatrixMarket matrix coordinate real general\n5000000000 1 1\n1 1 1.0\n";
    assert!(read("k.mtx", huge.as_bytes()).is_err());
}

#[test]
fn a_stiffness_a_mass_and_a_unit_of_length_are_told_by_their_numbers() {
    // A free aluminium bar of a metre in mm, N, t: ten elements of 100 mm.
    let n = 11;
    let (ea_l, m_l) = (70_000.0 * 100.0 / 100.0, 2.7e-9 * 100.0 * 100.0);
    let (mut k, mut m) = (Vec::new(), Vec::new());
    for i in 0..n - 1 {
        for (a, b, sign) in [(i, i, 1.0), (i + 1, i + 1, 1.0), (i + 1, i, -1.0)] {
            k.push(Entry { row: a, column: b, value: sign * ea_l });
        }
        m.extend([i, i + 1].map(|j| Entry { row: j, column: j, value: 0.5 * m_l }));
    }
    let dof = |i: u32| DofRow {
        label: Label { node: i.to_string(), dof: Some(Dof::Ux) },
        position: Some([100.0 * f64::from(i), 0.0, 0.0]),
        frame: None,
    };
    let dofs: Vec<DofRow> = (0..n).map(dof).collect();
    let of = |entries: Vec<Entry>| Matrix {
        n_rows: n as usize,
        n_columns: n as usize,
        entries,
        is_one_triangle: true,
        ..Matrix::default()
    };
    let (k, m) = (of(k), of(m));
    let (of_k, of_m) = (inspect(&k, &dofs), inspect(&m, &dofs));
    assert_eq!((of_k.inertia, of_m.inertia), (Some([0, 1]), Some([0, 0])));
    assert!(of_k.rigid.unwrap()[0] < 1e-15 && of_m.rigid.unwrap()[0] > 0.9);
    assert!((of_m.translations.unwrap()[0] - 10.0 * m_l).abs() < 1e-18);
    let (k, m) = (k.symmetric(false).unwrap(), m.symmetric(false).unwrap());
    assert_eq!(suspected_length(&k, &m, &dofs), Some("mm"));
}
