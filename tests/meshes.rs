//! Plates and bars of shells and solids, the whole way from a model file to frequencies, beside closed forms.

use retune::linalg::DMatrix;
use retune::modal::{SolveOptions, solve};
use retune::model::{Model, ParametricModel, Registry, load, solve_modes};
use std::f64::consts::{PI, TAU};
use std::fmt::Write;

fn build(text: &str) -> Model {
    match load(text, &Registry::builtin()) {
        Ok((model, ..)) => model,
        Err(problems) => panic!("{problems:#?}"),
    }
}

/// Elastic frequencies, Hz.
fn frequencies(model: &Model, n: usize) -> Vec<f64> {
    let system = model.assemble(&model.parameters().nominal()).unwrap();
    let options = SolveOptions { n_elastic: n, shift: None };
    let modes = solve(&system.stiffness, &system.mass, &model.dof_map().rigid_motions(), options).unwrap();
    modes.elastic().map(|i| modes.frequency_hz(i)).collect()
}

/// A rectangle of nx x ny cells in the x-y plane as a model file: nodes `n_I_J`, elements from `cell`.
fn plate(
    [a, b]: [f64; 2],
    [nx, ny]: [usize; 2],
    section: &str,
    cell: impl Fn(usize, usize) -> Vec<Vec<[usize; 2]>>,
) -> String {
    let mut text = String::from("retune: 1\nname: plate\nnodes:\n");
    for i in 0..=nx {
        for j in 0..=ny {
            // Nodes inside are moved a little, so that no element is a rectangle.
            let inside = i > 0 && i < nx && j > 0 && j < ny;
            let shift = |s: f64| if inside { 0.15 * (3.1 * (i * 7 + j * 3) as f64 + s).sin() } else { 0.0 };
            let x = a * (i as f64 + shift(0.0)) / nx as f64;
            let y = b * (j as f64 + shift(1.0)) / ny as f64;
            writeln!(text, "  n_{i}_{j}: [{x}, {y}, 0]").unwrap();
        }
    }
    writeln!(text, "sections:\n  skin: {{{section}}}\nelements:").unwrap();
    for i in 0..nx {
        for j in 0..ny {
            for (k, nodes) in cell(i, j).into_iter().enumerate() {
                let names: Vec<String> = nodes.iter().map(|[i, j]| format!("n_{i}_{j}")).collect();
                let kind = format!("shell{}", nodes.len());
                let names = names.join(", ");
                writeln!(text, "  e_{i}_{j}_{k}: {{type: {kind}, nodes: [{names}], section: skin}}").unwrap();
            }
        }
    }
    text
}

fn quad(i: usize, j: usize) -> Vec<Vec<[usize; 2]>> {
    vec![vec![[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]]]
}

fn triangles(i: usize, j: usize) -> Vec<Vec<[usize; 2]>> {
    vec![vec![[i, j], [i + 1, j], [i + 1, j + 1]], vec![[i, j], [i + 1, j + 1], [i, j + 1]]]
}

/// Edges that hold deflection and the rotation along them, and the corner that holds the plane.
fn simply_supported([nx, ny]: [usize; 2]) -> String {
    let ends: Vec<String> = (0..=ny).flat_map(|j| [format!("n_0_{j}"), format!("n_{nx}_{j}")]).collect();
    let sides: Vec<String> = (0..=nx).flat_map(|i| [format!("n_{i}_0"), format!("n_{i}_{ny}")]).collect();
    format!(
        "supports:\n  ends: {{nodes: [{}], fixed: [uz, rx]}}\n  sides: {{nodes: [{}], fixed: [uz, ry]}}\n  plane: {{nodes: \
         [n_0_0, n_0_{ny}], fixed: [ux, uy]}}\n",
        ends.join(", "),
        sides.join(", ")
    )
}

/// ω² = π⁴/m [D11 (p/a)⁴ + 2 (D12 + 2 D66)(p q/a b)² + D22 (q/b)⁴]: A. W. Leissa, Vibration of Plates, NASA SP-160, 1969.
fn navier([d11, d12, d22, d66]: [f64; 4], mass: f64, [a, b]: [f64; 2], n: usize) -> Vec<f64> {
    let mut all: Vec<f64> = (1..8)
        .flat_map(|p| (1..8).map(move |q| (f64::from(p) / a, f64::from(q) / b)))
        .map(|(x, y)| d11 * x.powi(4) + 2.0 * (d12 + 2.0 * d66) * (x * y).powi(2) + d22 * y.powi(4))
        .map(|d| PI * PI * (d / mass).sqrt() / TAU)
        .collect();
    all.sort_by(f64::total_cmp);
    all.truncate(n);
    all
}

/// Frequencies of a mesh, of one twice as fine, and what both say of none at all: f + (f - f_coarse)/3 where the error is of second order.
fn refined(text: impl Fn([usize; 2]) -> String, [nx, ny]: [usize; 2], modes: usize) -> [Vec<f64>; 3] {
    let of = |n: [usize; 2]| frequencies(&build(&(text(n) + &simply_supported(n))), modes);
    let (coarse, fine) = (of([nx, ny]), of([2 * nx, 2 * ny]));
    let limit = fine.iter().zip(&coarse).map(|(f, c)| f + (f - c) / 3.0).collect();
    [coarse, fine, limit]
}

fn worst(found: &[f64], exact: &[f64]) -> f64 {
    found.iter().zip(exact).map(|(f, e)| (f / e - 1.0).abs()).fold(0.0, f64::max)
}

/// The error of elements with linear rotations and consistent mass is (k h)²/8 in ω for waves of number k along the mesh: 3.5 % where six
/// make half a wave, more on irregular meshes; it falls with the second power of h.
#[test]
fn a_simply_supported_plate() {
    let ([a, b], t) = ([1.0, 0.8], 4e-3);
    let (e, nu, rho) = (70e9, 0.3, 2700.0);
    let d = e * t * t * t / (12.0 * (1.0 - nu * nu));
    let exact = navier([d, nu * d, d, 0.5 * (1.0 - nu) * d], rho * t, [a, b], 4);
    let section = format!("E: {e}, nu: {nu}, density: {rho}, thickness: {t}");
    type Cell = fn(usize, usize) -> Vec<Vec<[usize; 2]>>;
    for (name, cell) in [("shell4", quad as Cell), ("shell3", triangles as Cell)] {
        let [coarse, fine, limit] = refined(|n| plate([a, b], n, &section, cell), [6, 5], 4);
        let errors = [worst(&coarse, &exact), worst(&fine, &exact), worst(&limit, &exact)];
        assert!(errors[1] < 0.35 * errors[0] && errors[2] < 0.015, "{name}: {errors:?}");
    }
}

/// The first direction of the material runs along y, by `angle`.
#[test]
fn an_orthotropic_plate_whose_material_is_turned() {
    let ([a, b], t) = ([0.6, 0.5], 2e-3);
    let (e1, e2, nu12, g, rho): (f64, f64, f64, f64, f64) = (130e9, 9e9, 0.3, 5e9, 1600.0);
    let i = t * t * t / 12.0 / (1.0 - nu12 * nu12 * e2 / e1);
    let along_y = [e2 * i, nu12 * e2 * i, e1 * i, g * t * t * t / 12.0];
    let exact = navier(along_y, rho * t, [a, b], 3);
    let section = format!(
        "E1: {e1}, E2: {e2}, nu12: {nu12}, G12: {g}, G13: {g}, G23: 3e9, angle: 90 deg, density: {rho}, thickness: {t}"
    );
    let [_, fine, limit] = refined(|n| plate([a, b], n, &section, quad), [9, 5], 3);
    assert!(worst(&limit, &exact) < 0.015, "{fine:?} {limit:?} {exact:?}");
    // Turned by nothing, the plate would be another one.
    let along_x = navier([along_y[2], along_y[1], along_y[0], along_y[3]], rho * t, [a, b], 3);
    assert!(worst(&along_x, &exact) > 0.1);
}

/// Thickness and modulus are parameters of which K and M are polynomials: the batched and the reduced paths see shells too.
#[test]
fn a_thickness_is_a_parameter() {
    let section = "E: E, nu: 0.3, density: 2700, thickness: t";
    let text = plate([0.5, 0.4], [3, 3], section, quad)
        + "parameters:\n  E: {value: 70 GPa, bounds: [60 GPa, 80 GPa]}\n  t: {value: 2 mm, bounds: [1.5 mm, 3 mm]}\n"
        + "supports:\n  edge: {nodes: [n_0_0, n_0_1, n_0_2, n_0_3]}\n";
    let model = build(&text);
    assert!(model.affine().is_some());
    let theta = [68e9, 2.3e-3];
    let step = |j: usize, s: f64| {
        let mut at = theta;
        at[j] *= 1.0 + s;
        model.assemble(&at).unwrap()
    };
    for j in 0..2 {
        let exact: DMatrix<f64> = model.assemble_derivative(&theta, j).unwrap().stiffness;
        let h = 1e-5;
        let by_difference = (step(j, h).stiffness - step(j, -h).stiffness) / (2.0 * h * theta[j]);
        assert!((&exact - &by_difference).amax() < 1e-7 * exact.amax());
    }
}

/// A bar of square section as solids, clamped at one end: nodes `n_I_J_K` at half steps where the element has nodes on its edges.
fn bar(kind: &str, cells: [usize; 3], size: [f64; 3], nodes_of: impl Fn([usize; 3]) -> Vec<Vec<[usize; 3]>>) -> String {
    let mut text = format!("retune: 1\nname: bar of {kind}\n");
    let mut used = std::collections::BTreeSet::new();
    let mut elements = String::new();
    let mut number = 0;
    for i in 0..cells[0] {
        for j in 0..cells[1] {
            for k in 0..cells[2] {
                for nodes in nodes_of([2 * i, 2 * j, 2 * k]) {
                    number += 1;
                    let names: Vec<String> = nodes.iter().map(|[i, j, k]| format!("n_{i}_{j}_{k}")).collect();
                    used.extend(nodes);
                    let names = names.join(", ");
                    writeln!(elements, "  e{number}: {{type: {kind}, nodes: [{names}], section: s}}").unwrap();
                }
            }
        }
    }
    text += "nodes:\n";
    let mut held = Vec::new();
    for node in &used {
        let [x, y, z] = std::array::from_fn::<f64, 3, _>(|a| size[a] * node[a] as f64 / (2 * cells[a]) as f64);
        let [i, j, k] = node;
        writeln!(text, "  n_{i}_{j}_{k}: [{x}, {y}, {z}]").unwrap();
        if *i == 0 {
            held.push(format!("n_{i}_{j}_{k}"));
        }
    }
    // Without Poisson's effect the clamped end is that of a beam.
    text += "sections:\n  s: {E: 70e9, nu: 0, density: 2700}\nelements:\n";
    text += &elements;
    text + &format!("supports:\n  clamp: {{nodes: [{}]}}\n", held.join(", "))
}

const CORNERS: [[usize; 3]; 8] =
    [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [0, 0, 2], [2, 0, 2], [2, 2, 2], [0, 2, 2]];

const HEX: [[usize; 2]; 12] =
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];
const WEDGE: [[usize; 2]; 9] = [[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3], [0, 3], [1, 4], [2, 5]];
const TET: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];
// Kuhn's six tetrahedra round the diagonal 0-6, and the two wedges across it.
const TETS: [[usize; 4]; 6] = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]];
const WEDGES: [[usize; 6]; 2] = [[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]];

fn plus(a: [usize; 3], b: [usize; 3]) -> [usize; 3] {
    std::array::from_fn(|i| a[i] + b[i])
}

fn middle(a: [usize; 3], b: [usize; 3]) -> [usize; 3] {
    std::array::from_fn(|i| usize::midpoint(a[i], b[i]))
}

fn with_edges(corners: Vec<[usize; 3]>, edges: &[[usize; 2]]) -> Vec<[usize; 3]> {
    let middles: Vec<[usize; 3]> = edges.iter().map(|&[i, j]| middle(corners[i], corners[j])).collect();
    [corners, middles].concat()
}

/// The first bending frequencies of a slender bar by every solid that does not lock: Euler and Bernoulli's cantilever, less what
/// shear and rotary inertia take from it: 0.1 % in the first mode, 0.7 % in the second of this bar.
#[test]
fn a_bar_of_solids_bends() {
    let (l, h): (f64, f64) = (1.0, 0.025);
    let exact = |root: f64| root.powi(2) / TAU * (70e9 * h * h / 12.0 / (2700.0 * l.powi(4))).sqrt();
    let hex = |at: [usize; 3]| CORNERS.map(|c| plus(at, c)).to_vec();
    let pick = |at: [usize; 3], which: &[usize]| which.iter().map(|&i| plus(at, CORNERS[i])).collect::<Vec<_>>();
    let texts = [
        bar("hex8", [20, 1, 1], [l, h, h], |at| vec![hex(at)]),
        bar("hex20", [8, 1, 1], [l, h, h], |at| vec![with_edges(hex(at), &HEX)]),
        bar("wedge15", [12, 1, 1], [l, h, h], |at| WEDGES.iter().map(|w| with_edges(pick(at, w), &WEDGE)).collect()),
        bar("tet10", [12, 1, 1], [l, h, h], |at| TETS.iter().map(|t| with_edges(pick(at, t), &TET)).collect()),
    ];
    for text in texts {
        let name = text.lines().nth(1).unwrap().to_string();
        let found = frequencies(&build(&text), 4);
        let beam = [exact(1.875_104_07), exact(1.875_104_07), exact(4.694_091_13), exact(4.694_091_13)];
        for (f, e) in found.iter().zip(beam) {
            assert!((f / e - 1.0).abs() < 0.015, "{name}: {found:?} {beam:?}");
        }
    }
}

/// Estimates and true errors of the first modes of a model, by mode.
fn effectivity(model: &Model, exact: &[f64]) -> Vec<[f64; 3]> {
    let theta = model.parameters().nominal();
    let options = SolveOptions { n_elastic: exact.len(), shift: None };
    let modes = solve_modes(model, &theta, options).unwrap();
    let which: Vec<usize> = modes.elastic().take(exact.len()).collect();
    let estimates = model.mesh_errors(&theta, &modes, &which).unwrap();
    let of = |((e, f), &m): ((&retune::model::MeshError, &f64), &usize)| {
        let error = modes.frequency_hz(m) / f - 1.0;
        [e.relative, error, e.relative / error]
    };
    estimates.iter().zip(exact).zip(&which).map(of).collect()
}

/// Whether all indices lie within bounds, the first and the last modes that count.
fn lie_within(name: &str, found: &[[f64; 3]], which: &[usize], [low, high]: [f64; 2]) {
    for &i in which {
        let [estimate, error, index] = found[i];
        assert!((low..high).contains(&index), "{name}, mode {i}: {estimate} estimated, {error} true");
    }
}

/// Estimate over true error of the first three modes of a simply supported plate on an irregular mesh of 4, 8 and 16 elements a side, the true one against Navier: 1.2 to 1.9
/// of quadrilaterals, 0.9 to 1.3 of triangles, at errors from 0.5 to 44 %.
#[test]
fn the_error_of_a_plates_mesh_is_known_without_a_finer_one() {
    let (e, nu, rho, t) = (70e9, 0.3, 2700.0, 4e-3);
    let d = e * t * t * t / (12.0 * (1.0 - nu * nu));
    let size = [1.0, 0.8];
    let exact = navier([d, nu * d, d, 0.5 * (1.0 - nu) * d], rho * t, size, 3);
    let section = format!("E: {e}, nu: {nu}, density: {rho}, thickness: {t}");
    type Cell = fn(usize, usize) -> Vec<Vec<[usize; 2]>>;
    for (name, cell) in [("shell4", quad as Cell), ("shell3", triangles as Cell)] {
        for n in [4, 8, 16] {
            let model = build(&(plate(size, [n, n], &section, cell) + &simply_supported([n, n])));
            lie_within(&format!("{name}, {n}"), &effectivity(&model, &exact), &[0, 1, 2], [0.8, 2.0]);
        }
    }
}

/// The same of a slender cantilever by Euler and Bernoulli, first and second mode, 4, 8 and 16 elements long and one across: 0.97 to 1.2 of bricks and of quadrilaterals in and
/// out of their plane, 0.46 to 1.1 of solids of second order, 0.5 to 2.4 of tetrahedra of it, 1.1 to 2.2 of triangles.
#[test]
fn the_error_of_a_bars_mesh_is_known_without_a_finer_one() {
    let (l, h): (f64, f64) = (1.0, 0.01);
    let root = |k: f64| k.powi(2) / TAU * (70e9 * h * h / 12.0 / (2700.0 * l.powi(4))).sqrt();
    let exact = [1.875_104_07, 1.875_104_07, 4.694_091_13, 4.694_091_13].map(root);
    let hex = |at: [usize; 3]| CORNERS.map(|c| plus(at, c)).to_vec();
    let pick = |at: [usize; 3], which: &[usize]| which.iter().map(|&i| plus(at, CORNERS[i])).collect::<Vec<_>>();
    for n in [4, 8, 16] {
        let size = [l, h, h];
        let of_wedges = |at| WEDGES.iter().map(|w| with_edges(pick(at, w), &WEDGE)).collect();
        let of_tetrahedra = |at| TETS.iter().map(|t| with_edges(pick(at, t), &TET)).collect();
        let all = [
            (bar("hex8", [n, 1, 1], size, |at| vec![hex(at)]), [0.9, 1.2]),
            (bar("hex20", [n, 1, 1], size, |at| vec![with_edges(hex(at), &HEX)]), [0.4, 1.2]),
            (bar("wedge15", [n, 1, 1], size, of_wedges), [0.4, 1.2]),
            (bar("tet10", [n, 1, 1], size, of_tetrahedra), [0.4, 2.5]),
        ];
        for (text, bounds) in all {
            let name = text.lines().nth(1).unwrap().to_string();
            lie_within(&format!("{name}, {n}"), &effectivity(&build(&text), &exact), &[0, 1, 2, 3], bounds);
        }
        // A strip that bends out of its plane first, and then in it.
        type Cell = fn(usize, usize) -> Vec<Vec<[usize; 2]>>;
        for (name, cell, bounds) in [("shell4", quad as Cell, [0.9, 1.2]), ("shell3", triangles as Cell, [0.9, 2.3])] {
            let text = plate([l, h], [n, 1], "E: 70e9, nu: 0, density: 2700, thickness: 0.01", cell)
                + "supports: {clamp: {nodes: [n_0_0, n_0_1]}}\n";
            lie_within(&format!("strip of {name}, {n}"), &effectivity(&build(&text), &exact), &[0, 2], bounds);
        }
    }
    // Elements that lock in bending, and reduced ones that have nothing but hourglass patterns against it, are called useless.
    for kind in ["tet4", "hex8_reduced"] {
        let of = |at: [usize; 3]| match kind {
            "tet4" => TETS.iter().map(|t| pick(at, t)).collect(),
            _ => vec![hex(at)],
        };
        let found = effectivity(&build(&bar(kind, [8, 1, 1], [l, h, h], of)), &exact);
        assert!(found[0][0] > 0.2, "{kind}: {found:?}");
    }
}
