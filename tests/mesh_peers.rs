//! Wings, a panel and a box of shells and solids beside CalculiX on the same nodes: its shells are of eight nodes, ours of four, four of them for one.
//!
//! Needs `ccx` in the path; without it every test says so and stops. `--nocapture` prints the table of `docs/laboratory/elements.md`. Frequencies agree within 0.5 %,
//! or within what both still change by from one mesh to one twice as fine: formulations differ, and only their limit is one.

use retune::deck::KeywordDeck;
use retune::model::{Model, Registry};
use retune_exchange::{
    Agreement, ImportOptions, Solver, compare_results, import_keywords, read_results, system_by_name,
};
use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

type Point = [f64; 3];

fn has_ccx() -> bool {
    let found = Command::new("ccx").arg("-v").output().is_ok();
    if !found {
        eprintln!("skipped: CalculiX (`ccx`) is not installed");
    }
    found
}

/// A deck in the making: nodes at one place are one node.
#[derive(Default)]
struct Deck {
    nodes: Vec<Point>,
    at: HashMap<[i64; 3], usize>,
    elements: String,
    /// What stands for them in CalculiX, where that is other.
    quadratic: String,
    /// Nodes in the middles of quadratic shells, which these have not.
    middles: Vec<usize>,
    count: usize,
    rest: String,
}

impl Deck {
    /// The node at a place, numbered from one; `apart` makes one that is not joined to others there.
    fn node(&mut self, p: Point, apart: usize) -> usize {
        let mut key = p.map(|v| (v * 1e7).round() as i64);
        key[0] += 1_000_000_000_000 * apart as i64;
        *self.at.entry(key).or_insert_with(|| {
            self.nodes.push(p);
            self.nodes.len()
        })
    }

    /// A surface of n x m shells of eight nodes for CalculiX, and of 2n x 2m of four on the same nodes, and in the middles, for us. Returns its nodes.
    fn sheet(
        &mut self,
        set: &str,
        [n, m]: [usize; 2],
        apart: usize,
        at: impl Fn(f64, f64) -> Point,
    ) -> Vec<Vec<usize>> {
        let (n, m) = (2 * n, 2 * m);
        let grid: Vec<Vec<usize>> = (0..=n)
            .map(|i| (0..=m).map(|j| self.node(at(i as f64 / n as f64, j as f64 / m as f64), apart)).collect())
            .collect();
        let _ = writeln!(self.elements, "*ELEMENT, TYPE=S4, ELSET={set}");
        let _ = writeln!(self.quadratic, "*ELEMENT, TYPE=S8R, ELSET={set}");
        for i in 0..n {
            for j in 0..m {
                self.count += 1;
                let [a, b, c, d] = [grid[i][j], grid[i + 1][j], grid[i + 1][j + 1], grid[i][j + 1]];
                let _ = writeln!(self.elements, "{}, {a}, {b}, {c}, {d}", self.count);
                if i % 2 == 0 && j % 2 == 0 {
                    let at = [[0, 0], [2, 0], [2, 2], [0, 2], [1, 0], [2, 1], [1, 2], [0, 1]];
                    let ids = at.map(|[p, q]| grid[i + p][j + q].to_string()).join(", ");
                    let _ = writeln!(self.quadratic, "{}, {ids}", self.count);
                }
            }
        }
        for i in (1..n).step_by(2) {
            self.middles.extend((1..m).step_by(2).map(|j| grid[i][j]));
        }
        grid
    }

    /// A volume of bricks of twenty nodes.
    fn volume(&mut self, set: &str, n: [usize; 3], at: impl Fn(Point) -> Point) {
        const EDGES: [[usize; 2]; 12] =
            [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];
        const CORNERS: [[usize; 3]; 8] =
            [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
        let _ = writeln!(self.elements, "*ELEMENT, TYPE=C3D20, ELSET={set}");
        for i in 0..n[0] {
            for j in 0..n[1] {
                for k in 0..n[2] {
                    let first = [i, j, k];
                    let corner =
                        CORNERS.map(|c| -> Point { std::array::from_fn(|d| (first[d] + c[d]) as f64 / n[d] as f64) });
                    let middle =
                        EDGES.map(|[a, b]| -> Point { std::array::from_fn(|d| 0.5 * (corner[a][d] + corner[b][d])) });
                    let ids: Vec<String> =
                        corner.iter().chain(&middle).map(|p| self.node(at(*p), 0).to_string()).collect();
                    self.count += 1;
                    let _ =
                        writeln!(self.elements, "{}, {},\n{}", self.count, ids[..10].join(", "), ids[10..].join(", "));
                }
            }
        }
    }

    /// Nodes for which something holds, as a set.
    fn set(&mut self, name: &str, holds: impl Fn(Point) -> bool) {
        let _ = writeln!(self.rest, "*NSET, NSET={name}");
        let is_there = |i: usize| self.quadratic.is_empty() || !self.middles.contains(&i);
        for (i, _) in self.nodes.iter().enumerate().filter(|(i, p)| is_there(i + 1) && holds(**p)) {
            let _ = writeln!(self.rest, "{},", i + 1);
        }
    }

    /// The decks of CalculiX and of this program.
    fn texts(&self, sections: &str, boundary: &str) -> [String; 2] {
        let quadratic = if self.quadratic.is_empty() { &self.elements } else { &self.quadratic };
        [quadratic, &self.elements].map(|elements| {
            let mut text = "*HEADING\na peer\n*NODE, NSET=ALL\n".to_string();
            let is_ours = std::ptr::eq(elements, &raw const self.elements);
            for (i, [x, y, z]) in self.nodes.iter().enumerate() {
                if is_ours || !self.middles.contains(&(i + 1)) {
                    let _ = writeln!(text, "{}, {x}, {y}, {z}", i + 1);
                }
            }
            let step = "*STEP\n*FREQUENCY\n10\n*NODE FILE, OUTPUT=2D\nU\n*END STEP\n";
            format!("{text}{elements}{}{sections}{boundary}{step}", self.rest)
        })
    }
}

const ALLOY: &str = "*MATERIAL, NAME=alloy\n*ELASTIC\n70.e9, 0.33\n*DENSITY\n2700.\n";

/// The imported model, and how it agrees with CalculiX on its deck of the same nodes.
fn against([theirs, ours]: &[String; 2], most: usize) -> (Model, Agreement) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("job.inp"), theirs).unwrap();
    let run = Command::new("ccx").arg("job").current_dir(folder.path()).output().unwrap();
    let said = || String::from_utf8_lossy(&run.stdout).into_owned();
    let deck = KeywordDeck::read(Path::new("job.inp"), &mut |_| Ok(ours.as_bytes().to_vec())).unwrap();
    let options = ImportOptions {
        system: system_by_name("si").unwrap(),
        subcase: None,
        parameter_per_property: false,
        solver: Solver::CalculiX,
    };
    let imported = import_keywords(&deck, options).unwrap_or_else(|e| panic!("{}", e[0]));
    let model = imported.load(&Registry::builtin()).unwrap_or_else(|p| panic!("{}", p[0].message)).0;
    let bytes = std::fs::read(folder.path().join("job.frd")).unwrap_or_else(|e| panic!("{e}\n{}", said()));
    let results = read_results(&bytes).unwrap_or_else(|e| panic!("{e}\n{}", said()));
    let agreement = compare_results(&model, &results, most).unwrap();
    (model, agreement)
}

/// Six frequencies on a mesh and on one twice as fine: equal within 0.5 %, or within what both codes change by between the meshes; equal shapes.
fn six_are_equal(name: &str, deck: impl Fn(usize) -> [String; 2]) {
    let [coarse, fine] = [2, 4].map(|n| against(&deck(n), 6).1);
    assert!(coarse.modes.len() >= 6 && fine.modes.len() >= 6, "{name}: {:?}", fine.notes);
    for (c, f) in coarse.modes.iter().zip(&fine.modes).take(6) {
        let change = (c.solver_hz / f.solver_hz - 1.0).abs() + (c.model_hz / f.model_hz - 1.0).abs();
        let mac = f.mac.unwrap();
        println!(
            "| {name}, mode {} | {:.4} | {:.4} | {:.4} | {:.5} | {:.4} |",
            f.number,
            f.solver_hz,
            f.model_hz,
            f.model_hz / f.solver_hz,
            mac,
            change
        );
        assert!(f.relative().abs() < 0.005_f64.max(change), "{name} {}: {} {}", f.number, f.solver_hz, f.model_hz);
        assert!(mac > 0.999, "{name} {}: {mac}", f.number);
    }
}

/// Planform of the wing: semi-span 1.2 m, chord 0.4 to 0.2 m, swept by 0.35 m.
fn planform(s: f64, t: f64) -> Point {
    let (y, chord) = (1.2 * s, 0.4 - 0.2 * s);
    [0.35 * s + chord * t, y, 0.0]
}

/// A swept, tapered wing of one sheet of 6 mm.
#[test]
fn a_plate_wing_of_shells() {
    if !has_ccx() {
        return;
    }
    six_are_equal("wing, shells", |n| {
        let mut deck = Deck::default();
        let _ = deck.sheet("skin", [8 * n, 3 * n], 0, planform);
        deck.set("root", |p| p[1] < 1e-9);
        deck.texts(&format!("{ALLOY}*SHELL SECTION, ELSET=skin, MATERIAL=alloy\n0.006\n"), "*BOUNDARY\nroot, 1, 6\n")
    });
}

/// The same of one layer of bricks of twenty nodes: one formulation, to the printed digits.
#[test]
fn a_plate_wing_of_solids() {
    if !has_ccx() {
        return;
    }
    let mut deck = Deck::default();
    deck.volume("skin", [5, 12, 1], |[t, s, u]| {
        let [x, y, _] = planform(s, t);
        [x, y, 0.006 * (u - 0.5)]
    });
    deck.set("root", |p| p[1] < 1e-9);
    let text = deck.texts(&format!("{ALLOY}*SOLID SECTION, ELSET=skin, MATERIAL=alloy\n"), "*BOUNDARY\nroot, 1, 3\n");
    let (_, found) = against(&text, 6);
    assert_eq!(found.modes.len(), 6, "{:?}", found.notes);
    for m in &found.modes {
        println!(
            "| wing, solids, mode {} | {:.4} | {:.4} | {:.6} |",
            m.number,
            m.solver_hz,
            m.model_hz,
            m.model_hz / m.solver_hz
        );
        assert!(m.relative().abs() < 1e-4 && m.mac.unwrap() > 0.9999, "{}: {} {}", m.number, m.solver_hz, m.model_hz);
    }
}

/// The wing of a sheet of carbon whose fibres run at 12 degrees from the span.
#[test]
fn a_wing_of_fibres_at_twelve_degrees() {
    if !has_ccx() {
        return;
    }
    six_are_equal("wing, fibres at 12 degrees", |n| {
        let mut deck = Deck::default();
        let _ = deck.sheet("skin", [8 * n, 3 * n], 0, planform);
        deck.set("root", |p| p[1] < 1e-9);
        let (s, c) = 12.0_f64.to_radians().sin_cos();
        let sections = format!(
            "*MATERIAL, NAME=ply\n*ELASTIC, TYPE=ENGINEERING CONSTANTS\n130.e9, 9.e9, 9.e9, 0.3, 0.3, 0.3, 5.e9, 5.e9,\n3.e9\n*DENSITY\n1550.\n\
             *ORIENTATION, NAME=twelve\n{s}, {c}, 0., {}, {s}, 0.\n\
             *SHELL SECTION, ELSET=skin, MATERIAL=ply, ORIENTATION=twelve\n0.006\n",
            -c
        );
        deck.texts(&sections, "*BOUNDARY\nroot, 1, 6\n")
    });
}

/// A panel of 0.9 x 0.6 m with three blades of 40 mm, clamped along its short edges.
#[test]
fn a_stiffened_panel() {
    if !has_ccx() {
        return;
    }
    six_are_equal("stiffened panel", |n| {
        let mut deck = Deck::default();
        let _ = deck.sheet("skin", [8 * n, 8 * n], 0, |s, t| [0.9 * s, 0.6 * t, 0.0]);
        for k in 1..4 {
            let y = 0.15 * f64::from(k);
            let _ = deck.sheet("blades", [8 * n, n], 0, move |s, t| [0.9 * s, y, 0.04 * t]);
        }
        deck.set("ends", |p| p[0] < 1e-9 || p[0] > 0.9 - 1e-9);
        let sections = format!(
            "{ALLOY}*SHELL SECTION, ELSET=skin, MATERIAL=alloy\n0.003\n*SHELL SECTION, ELSET=blades, MATERIAL=alloy\n0.004\n"
        );
        deck.texts(&sections, "*BOUNDARY\nends, 1, 6\n")
    });
}

/// An open box of 0.4 x 0.3 x 0.2 m on its clamped floor, with a lid that ten bolts hold to its walls.
#[test]
fn a_bolted_box() {
    if !has_ccx() {
        return;
    }
    six_are_equal("bolted box", |n| {
        let mut deck = Deck::default();
        let (a, b, h) = (0.4, 0.3, 0.2);
        let cells = [4 * n, 3 * n, 2 * n];
        for y in [0.0, b] {
            let _ = deck.sheet("walls", [cells[0], cells[2]], 0, move |s, t| [a * s, y, h * t]);
        }
        for x in [0.0, a] {
            let _ = deck.sheet("walls", [cells[1], cells[2]], 0, move |s, t| [x, b * s, h * t]);
        }
        let lid = deck.sheet("lid", [cells[0], cells[1]], 1, |s, t| [a * s, b * t, h]);
        // Four corners, and three more along each long edge.
        for i in [0, 2, 4, 6, 8] {
            for j in [0, 2 * cells[1]] {
                let of_lid = lid[i * n][j];
                let wall = deck.node(deck.nodes[of_lid - 1], 0);
                for dof in 1..=3 {
                    let _ = writeln!(deck.rest, "*EQUATION\n2\n{of_lid}, {dof}, 1., {wall}, {dof}, -1.");
                }
            }
        }
        deck.set("floor", |p| p[2] < 1e-9);
        let sections = format!(
            "{ALLOY}*SHELL SECTION, ELSET=walls, MATERIAL=alloy\n0.002\n*SHELL SECTION, ELSET=lid, MATERIAL=alloy\n0.003\n"
        );
        deck.texts(&sections, "*BOUNDARY\nfloor, 1, 6\n")
    });
}
