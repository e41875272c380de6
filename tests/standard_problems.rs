//! Standard problems of shells and solids beside their published answers, on meshes in files: R. H. MacNeal, R. L. Harder, A proposed standard
//! set of problems to test finite element accuracy, Finite Elem. Anal. Des. 1 (1985) 3-20; F. Abbassian, D. J. Dawswell, N. C. Knowles, Free
//! Vibration Benchmarks, NAFEMS 1987. `docs/laboratory/elements.md` has the table; `--nocapture` prints it.

use retune::element::Dof;
use retune::linalg::{DMatrix, DVector};
use retune::modal::SolveOptions;
use retune::model::{Model, ParametricModel, Registry, load_in, solve_modes};
use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt::Write;

type Point = [f64; 3];

/// A block of cells as an MSH file of version 2.2, in m: nodes at the corners of cells, numbered from one, along k first.
struct Grid {
    cells: [usize; 3],
    points: Vec<Point>,
}

impl Grid {
    /// * `at` - the place of fractions along the three directions
    fn new(cells: [usize; 3], at: impl Fn(Point) -> Point) -> Self {
        let mut points = Vec::new();
        let fraction = |i: usize, n: usize| if n == 0 { 0.0 } else { i as f64 / n as f64 };
        for i in 0..=cells[0] {
            for j in 0..=cells[1] {
                for k in 0..=cells[2] {
                    points.push(at([fraction(i, cells[0]), fraction(j, cells[1]), fraction(k, cells[2])]));
                }
            }
        }
        Self { cells, points }
    }

    fn id(&self, [i, j, k]: [usize; 3]) -> usize {
        1 + (i * (self.cells[1] + 1) + j) * (self.cells[2] + 1) + k
    }

    /// Names of the nodes for which something holds of their indices.
    fn nodes(&self, holds: impl Fn([usize; 3]) -> bool) -> String {
        let [a, b, c] = self.cells;
        let all = (0..=a).flat_map(|i| (0..=b).flat_map(move |j| (0..=c).map(move |k| [i, j, k])));
        let names: Vec<String> = all.filter(|at| holds(*at)).map(|at| format!("n{}", self.id(at))).collect();
        names.join(", ")
    }

    /// Surfaces of quadrilaterals, or of two triangles each, where there are no cells along k; volumes else.
    fn msh(&self, triangles: bool) -> String {
        let mut text = format!("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n", self.points.len());
        for (i, [x, y, z]) in self.points.iter().enumerate() {
            writeln!(text, "{} {x} {y} {z}", i + 1).unwrap();
        }
        let mut lines = Vec::new();
        for i in 0..self.cells[0] {
            for j in 0..self.cells[1] {
                let corner = |a: usize, b: usize, c: usize| self.id([i + a, j + b, c]).to_string();
                let square = |c: usize| [corner(0, 0, c), corner(1, 0, c), corner(1, 1, c), corner(0, 1, c)];
                if self.cells[2] > 0 {
                    for k in 0..self.cells[2] {
                        lines.push(format!("5 2 1 1 {} {}", square(k).join(" "), square(k + 1).join(" ")));
                    }
                } else if triangles {
                    let [a, b, c, d] = square(0);
                    // Diagonals in turn, so that no direction is favoured.
                    let pair =
                        if (i + j) % 2 == 0 { [[&a, &b, &c], [&a, &c, &d]] } else { [[&a, &b, &d], [&b, &c, &d]] };
                    lines.extend(pair.map(|[p, q, r]| format!("2 2 1 1 {p} {q} {r}")));
                } else {
                    lines.push(format!("3 2 1 1 {}", square(0).join(" ")));
                }
            }
        }
        writeln!(text, "$EndNodes\n$Elements\n{}", lines.len()).unwrap();
        for (i, line) in lines.iter().enumerate() {
            writeln!(text, "{} {line}", i + 1).unwrap();
        }
        text + "$EndElements\n"
    }

    fn model(&self, triangles: bool, section: &str, kind: &str, supports: &str) -> Model {
        let text = format!(
            "retune: 1\nname: standard problem\nmesh: {{file: m.msh, units: m, parts: {{all: {{section: s{kind}}}}}}}\nsections: {{s: {{{section}}}}}\nsupports:\n{supports}"
        );
        let msh = self.msh(triangles);
        let loaded = load_in(&text, None, &Registry::builtin(), &mut |_| Ok(msh.clone().into_bytes()));
        loaded.unwrap_or_else(|p| panic!("{p:#?}")).0
    }
}

/// Displacements under forces at nodes: names, directions and sizes.
fn deflections(model: &Model, forces: &[(String, Dof, f64)]) -> impl Fn(&str, Dof) -> f64 + use<> {
    let system = model.assemble(&model.parameters().nominal()).unwrap();
    let mut load = DVector::zeros(system.stiffness.nrows());
    for (node, dof, force) in forces {
        for &(row, factor) in model.dof_map().express(model.dof_map().node(node).unwrap(), *dof) {
            load[row] += force * factor;
        }
    }
    let u = DMatrix::cholesky(system.stiffness).unwrap().solve(&load);
    let dofs = model.dof_map().clone();
    move |node, dof| dofs.express(dofs.node(node).unwrap(), dof).iter().map(|&(row, f)| f * u[row]).sum()
}

fn told(problem: &str, found: f64, published: f64) -> f64 {
    println!("| {problem} | {published} | {found:.5} | {:.3} |", found / published);
    found / published
}

fn held(name: &str, nodes: &str, dofs: &str) -> String {
    if dofs.is_empty() {
        format!("  {name}: {{nodes: [{nodes}]}}\n")
    } else {
        format!("  {name}: {{nodes: [{nodes}], fixed: [{dofs}]}}\n")
    }
}

/// A quarter ring, clamped at one end: in the plane 0.08734, across it 0.5022. The published mesh of six has
/// trapezoids.
#[test]
fn the_curved_beam() {
    let ratios = |n: usize| {
        let grid = Grid::new([6 * n, n, 0], |[s, t, _]| {
            let (r, a) = (4.12 + 0.2 * t, FRAC_PI_2 * s);
            [r * a.sin(), r * a.cos(), 0.0]
        });
        let root = held("root", &grid.nodes(|[i, ..]| i == 0), "");
        let model = grid.model(false, "E: 1e7, nu: 0.25, thickness: 0.1", "", &root);
        let tips: Vec<String> = (0..=n).map(|j| format!("n{}", grid.id([6 * n, j, 0]))).collect();
        let tip = |dof: Dof| {
            let share = |j: usize| if j == 0 || j == n { 0.5 / n as f64 } else { 1.0 / n as f64 };
            let forces: Vec<_> = tips.iter().enumerate().map(|(j, t)| (t.clone(), dof, share(j))).collect();
            let u = deflections(&model, &forces);
            0.5 * (u(&tips[0], dof) + u(&tips[n], dof))
        };
        let mesh = format!("{} x {n}", 6 * n);
        [
            told(&format!("curved beam, shell4, {mesh}, force in the plane"), tip(Dof::Ux), 0.08734),
            told(&format!("curved beam, shell4, {mesh}, force across it"), tip(Dof::Uz), 0.5022),
        ]
    };
    let [coarse, middle, fine] = [1, 2, 4].map(ratios);
    assert!(
        coarse[0] < middle[0] && middle[0] < fine[0] && (0.95..1.01).contains(&fine[0]),
        "{coarse:?} {middle:?} {fine:?}"
    );
    assert!((coarse[1] - 1.0).abs() < 0.1 && (fine[1] - 1.0).abs() < 0.03, "{coarse:?} {fine:?}");
}

/// A strip that turns by 90 degrees over its length: 0.005424 and 0.001754. Every element is warped.
#[test]
fn the_twisted_beam() {
    for (name, triangles, n, within_share) in
        [("shell4", false, 1, 0.01), ("shell3", true, 1, 0.08), ("shell3", true, 2, 0.03)]
    {
        let grid = Grid::new([12 * n, 2 * n, 0], |[s, t, _]| {
            let (w, a) = (1.1 * (t - 0.5), FRAC_PI_2 * s);
            [12.0 * s, w * a.cos(), w * a.sin()]
        });
        let root = held("root", &grid.nodes(|[i, ..]| i == 0), "");
        let model = grid.model(triangles, "E: 29e6, nu: 0.22, thickness: 0.32", "", &root);
        let tips: Vec<String> = (0..=2 * n).map(|j| format!("n{}", grid.id([12 * n, j, 0]))).collect();
        let tip = |dof: Dof| {
            let share = |j: usize| if j == 0 || j == 2 * n { 0.25 / n as f64 } else { 0.5 / n as f64 };
            let forces: Vec<_> = tips.iter().enumerate().map(|(j, t)| (t.clone(), dof, share(j))).collect();
            deflections(&model, &forces)(&tips[n], dof)
        };
        // At the tip the strip stands along z.
        let mesh = format!("{name}, {} x {}", 12 * n, 2 * n);
        let within = told(&format!("twisted beam, {mesh}, force in the plane of the tip"), tip(Dof::Uz), 0.005_424);
        let across = told(&format!("twisted beam, {mesh}, force across it"), tip(Dof::Uy), 0.001_754);
        let worst = (within - 1.0).abs().max((across - 1.0).abs());
        assert!(worst < within_share, "{mesh}: {within} {across}");
    }
}

/// The roof on two diaphragms under its weight, 90 by area: 0.3024 down in the middle of the free edge. A quarter of n x n elements.
#[test]
fn the_scordelis_lo_roof() {
    let ratio = |n: usize, triangles: bool| {
        let forty = 40.0 * PI / 180.0;
        let grid = Grid::new([n, n, 0], |[s, t, _]| {
            let a = forty * t;
            [25.0 * s, 25.0 * a.sin(), 25.0 * a.cos()]
        });
        // x = 0 is the middle, t = 0 the crown.
        let supports = held("diaphragm", &grid.nodes(|[i, ..]| i == n), "uy, uz")
            + &held("middle", &grid.nodes(|[i, ..]| i == 0), "ux, ry, rz")
            + &held("crown", &grid.nodes(|[_, j, _]| j == 0), "uy, rx, rz");
        let model = grid.model(triangles, "E: 4.32e8, nu: 0, thickness: 0.25", "", &supports);
        // The weight of each cell at its corners.
        let cell = 90.0 * (25.0 / n as f64) * (25.0 * forty / n as f64) / 4.0;
        let mut forces = Vec::new();
        for i in 0..=n {
            for j in 0..=n {
                let share = |k: usize| if k == 0 || k == n { 1.0 } else { 2.0 };
                forces.push((format!("n{}", grid.id([i, j, 0])), Dof::Uz, -cell * share(i) * share(j)));
            }
        }
        -deflections(&model, &forces)(&format!("n{}", grid.id([0, n, 0])), Dof::Uz)
    };
    for n in [4, 8] {
        let quads = told(&format!("Scordelis-Lo roof, shell4, {n} x {n}"), ratio(n, false), 0.3024);
        let triangles = told(&format!("Scordelis-Lo roof, shell3, {n} x {n}"), ratio(n, true), 0.3024);
        assert!((quads - 1.0).abs() < 0.06, "{n}: {quads}");
        assert!((0.6..1.1).contains(&triangles), "{n}: {triangles}");
    }
}

/// The hemisphere with a hole of 18 degrees under two pairs of forces: 0.0940 along them. A quarter of n x n elements. It bends almost without
/// stretching, which flat elements with drilling rotations follow on fine meshes only.
#[test]
fn the_hemisphere() {
    let ratio = |n: usize, triangles: bool| {
        let grid = Grid::new([n, n, 0], |[s, t, _]| {
            let (azimuth, up) = (FRAC_PI_2 * s, 72.0 * PI / 180.0 * t);
            [10.0 * azimuth.cos() * up.cos(), 10.0 * azimuth.sin() * up.cos(), 10.0 * up.sin()]
        });
        let supports = held("along_x", &grid.nodes(|[i, ..]| i == 0), "uy, rx, rz")
            + &held("along_y", &grid.nodes(|[i, ..]| i == n), "ux, ry, rz")
            + &held("up", &grid.nodes(|at| at == [0, 0, 0]), "uz");
        let model = grid.model(triangles, "E: 6.825e7, nu: 0.3, thickness: 0.04", "", &supports);
        let (a, b) = (format!("n{}", grid.id([0, 0, 0])), format!("n{}", grid.id([n, 0, 0])));
        let u = deflections(&model, &[(a.clone(), Dof::Ux, 1.0), (b, Dof::Uy, -1.0)]);
        u(&a, Dof::Ux)
    };
    let [coarse, fine] = [8, 16].map(|n| {
        let of = |name: &str, triangles| told(&format!("hemisphere, {name}, {n} x {n}"), ratio(n, triangles), 0.0940);
        [of("shell4", false), of("shell3", true)]
    });
    assert!((0..2).all(|k| coarse[k] < fine[k] && fine[k] < 1.02), "{coarse:?} {fine:?}");
    assert!(fine[0] > 0.95 && fine[1] > 0.8, "{fine:?}");
}

/// A thick cylinder in plane strain under pressure, ν near ½: u(3) = 5.0399e-3, 5.0575e-3, 5.0602e-3. Linear bricks without more would stop
/// at a fortieth of it.
#[test]
fn the_thick_cylinder() {
    for (nu, published) in [(0.49, 5.0399e-3), (0.499, 5.0575e-3), (0.4999, 5.0602e-3)] {
        let radii = [3.0, 3.5, 4.2, 5.2, 6.75, 9.0];
        let ten = 10.0 * PI / 180.0;
        let grid = Grid::new([5, 1, 1], |[s, t, u]| {
            let (r, a) = (radii[(5.0 * s).round() as usize], ten * t);
            [r * a.cos(), r * a.sin(), u]
        });
        // The plane at ten degrees moves along itself: its nodes slide on a line through the axis.
        let mut text =
            held("plane", &grid.nodes(|_| true), "uz") + &held("level", &grid.nodes(|[_, j, _]| j == 0), "uy");
        text += "constraints:\n";
        for i in 0..=5 {
            for k in 0..=1 {
                let n = grid.id([i, 1, k]);
                let (s, c) = ten.sin_cos();
                writeln!(
                    text,
                    "  c{n}: {{terms: [{{node: n{n}, dof: uy, factor: {c}}}, {{node: n{n}, dof: ux, factor: {}}}]}}",
                    -s
                )
                .unwrap();
            }
        }
        let model = grid.model(false, &format!("E: 1000, nu: {nu}"), "", &text);
        // Pressure 1 on the inner face, a chord of 3 · 2 sin 5°.
        let force = 2.0 * 3.0 * (0.5 * ten).sin() / 4.0;
        let mut forces = Vec::new();
        let (s, c) = (0.5 * ten).sin_cos();
        for j in 0..=1 {
            for k in 0..=1 {
                let node = format!("n{}", grid.id([0, j, k]));
                forces.push((node.clone(), Dof::Ux, force * c));
                forces.push((node, Dof::Uy, force * s));
            }
        }
        let u = deflections(&model, &forces)(&format!("n{}", grid.id([0, 0, 0])), Dof::Ux);
        let ratio = told(&format!("thick cylinder, hex8, nu {nu}"), u, published);
        assert!((0.97..1.01).contains(&ratio), "{nu}: {ratio}");
    }
}

/// Elastic frequencies, Hz.
fn frequencies(model: &Model, n: usize) -> Vec<f64> {
    let found = solve_modes(model, &model.parameters().nominal(), SolveOptions { n_elastic: n, shift: None }).unwrap();
    found.elastic().map(|i| found.frequency_hz(i)).collect()
}

fn beside(problem: &str, found: &[f64], published: &[f64], within: f64) {
    for (i, (f, p)) in found.iter().zip(published).enumerate() {
        let ratio = told(&format!("{problem}, mode {}", i + 1), *f, *p);
        assert!((ratio - 1.0).abs() < within, "{problem}: {found:?} {published:?}");
    }
}

const STEEL: &str = "E: 200e9, nu: 0.3, density: 8000";

/// FV12, a free thin square plate, and FV16, the same held at one edge; 10 m and 50 mm thick. The published answers are those of series.
#[test]
fn nafems_thin_plates() {
    let section = format!("{STEEL}, thickness: 0.05");
    for (name, triangles, n, within) in [("shell4", false, 16, 0.02), ("shell3", true, 24, 0.03)] {
        let grid = Grid::new([n, n, 0], |[s, t, _]| [10.0 * s, 10.0 * t, 0.0]);
        // In its plane the free plate is held at three places, which strains nothing.
        let plane = held("a", &grid.nodes(|at| at == [0, 0, 0]), "ux, uy")
            + &held("b", &grid.nodes(|at| at == [n, 0, 0]), "uy");
        let free = grid.model(triangles, &section, "", &plane);
        beside(&format!("FV12, {name}"), &frequencies(&free, 6), &[1.622, 2.360, 2.922, 4.233, 4.233, 7.416], within);
        let root = held("root", &grid.nodes(|[i, ..]| i == 0), "");
        let held = grid.model(triangles, &section, "", &root);
        beside(&format!("FV16, {name}"), &frequencies(&held, 6), &[0.421, 1.029, 2.582, 3.306, 3.753, 6.555], within);
    }
}

/// FV32, a tapered membrane held at its wide end.
#[test]
fn nafems_tapered_membrane() {
    for (name, triangles) in [("shell4", false), ("shell3", true)] {
        let grid = Grid::new([32, 16, 0], |[s, t, _]| [10.0 * s, (5.0 - 4.0 * s) * (t - 0.5), 0.0]);
        let supports = held("root", &grid.nodes(|[i, ..]| i == 0), "")
            + &held("plane", &grid.nodes(|[i, ..]| i > 0), "uz, rx, ry");
        let model = grid.model(triangles, &format!("{STEEL}, thickness: 0.05"), "", &supports);
        let published = [44.623, 130.03, 162.70, 246.05, 379.90, 391.44];
        beside(&format!("FV32, {name}"), &frequencies(&model, 6), &published, 0.02);
    }
}

/// FV52, a thick square plate of solids on the edges of its lower face; the plane motions of the free plate come first and are left out.
#[test]
fn nafems_thick_plate_of_solids() {
    let (n, layers) = (12, 2);
    let grid = Grid::new([n, n, layers], |[s, t, u]| [10.0 * s, 10.0 * t, u - 0.5]);
    let on_edge = |[i, j, k]: [usize; 3]| k == 0 && (i == 0 || i == n || j == 0 || j == n);
    let supports = held("edge", &grid.nodes(on_edge), "uz");
    let model = grid.model(false, STEEL, "", &supports);
    let found = frequencies(&model, 7);
    beside("FV52, hex8", &found, &[45.897, 109.44, 109.44, 167.89, 193.59, 206.19, 206.19], 0.03);
}
