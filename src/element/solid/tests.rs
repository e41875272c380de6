//! Patch tests and closed forms of solids.

use super::super::{Element, ElementInput};
use super::dual::Dual;
use super::{Hex8, Hex8Reduced, Hex20, Hex20Reduced, Pyramid5, Pyramid13, Tet4, Tet10, Wedge6, Wedge15, values};
use crate::linalg::DVector;

/// N_i(x_j) = δ_ij, Σ N = 1 and Σ N_i x_i = x: what a shape function has to be.
pub(super) fn functions_belong_to_nodes(shape: fn([Dual; 3]) -> Vec<Dual>, nodes: &[[f64; 3]]) {
    for (j, node) in nodes.iter().enumerate() {
        for (i, n) in values(shape, *node).into_iter().enumerate() {
            let expected = if i == j { 1.0 } else { 0.0 };
            assert!((n - expected).abs() < 1e-11, "N_{i} at node {j}: {n}");
        }
    }
    let inside = [0.11, 0.23, 0.31];
    let n = values(shape, inside);
    assert!((n.iter().sum::<f64>() - 1.0).abs() < 1e-14);
    for axis in 0..3 {
        let x: f64 = n.iter().zip(nodes).map(|(n, p)| n * p[axis]).sum();
        assert!((x - inside[axis]).abs() < 1e-14);
    }
}

const SOLIDS: [&dyn Element; 10] =
    [&Hex8, &Hex8Reduced, &Hex20, &Hex20Reduced, &Pyramid5, &Pyramid13, &Tet4, &Tet10, &Wedge6, &Wedge15];

/// Corners of a distorted element, edges straight with their nodes in the middle: the sample, its corners moved.
fn distorted(element: &dyn Element) -> Vec<[f64; 3]> {
    let mut points = element.samples()[0].points.clone();
    let corners = match points.len() {
        4 | 10 => 4,
        5 | 13 => 5,
        6 | 15 => 6,
        _ => 8,
    };
    let before = points.clone();
    for (i, p) in points.iter_mut().enumerate().take(corners).skip(1) {
        for (axis, x) in p.iter_mut().enumerate() {
            *x += 0.012 * (1.7 * (i * 3 + axis) as f64).sin();
        }
    }
    // A node in the middle of two corners stays there.
    for k in corners..points.len() {
        let is_middle =
            |i: usize, j: usize| (0..3).all(|a| (before[k][a] - 0.5 * (before[i][a] + before[j][a])).abs() < 1e-12);
        let ends = (0..corners).flat_map(|i| (0..i).map(move |j| (i, j))).find(|&(i, j)| is_middle(i, j));
        let (i, j) = ends.unwrap();
        points[k] = std::array::from_fn(|a| 0.5 * (points[i][a] + points[j][a]));
    }
    points
}

fn displaced(points: &[[f64; 3]], field: impl Fn(&[f64; 3]) -> [f64; 3]) -> DVector<f64> {
    let mut u = DVector::zeros(6 * points.len());
    for (k, p) in points.iter().enumerate() {
        field(p).into_iter().enumerate().for_each(|(axis, v)| u[6 * k + axis] = v);
    }
    u
}

/// A linear displacement of the nodes stores ½ ε D ε V, exactly, on a distorted element: Irons' patch test of one element, which with
/// forces in equilibrium is that of any patch.
#[test]
fn constant_strain_is_exact_on_distorted_elements() {
    let (e, nu) = (70e9, 0.33);
    let slope = [[1.0e-3, 2.0e-4, -3.0e-4], [4.0e-4, -7.0e-4, 6.0e-4], [-2.0e-4, 5.0e-4, 9.0e-4]];
    let field = |p: &[f64; 3]| std::array::from_fn(|i| (0..3).map(|j| slope[i][j] * p[j]).sum());
    let (lambda, shear) = (e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)));
    let trace = slope[0][0] + slope[1][1] + slope[2][2];
    let squares: f64 = (0..9).map(|k| (0.5 * (slope[k / 3][k % 3] + slope[k % 3][k / 3])).powi(2)).sum();
    let density = 0.5 * lambda * trace * trace + shear * squares;
    for element in SOLIDS {
        let points = distorted(element);
        let values = sample_values(element, &[("E", e), ("nu", nu), ("density", 1.0)]);
        let input = ElementInput { points: &points, values: &values };
        let (k, m) = (element.stiffness(&input).unwrap().to_dense(), element.mass(&input).unwrap().to_dense());
        let volume: f64 = (0..points.len())
            .flat_map(|i| (0..points.len()).map(move |j| (i, j)))
            .map(|(i, j)| m[(6 * i, 6 * j)])
            .sum();
        let u = displaced(&points, field);
        let energy = 0.5 * u.dot(&(&k * &u));
        assert!(
            (energy / (density * volume) - 1.0).abs() < 1e-11,
            "{}: {energy:e} {:e}",
            element.name(),
            density * volume
        );
        // Forces on nodes are those of a constant stress: they do not depend on what the enrichment does.
        let second = displaced(&points, |p| [p[1] * 1e-3, p[0] * 1e-3, 0.0]);
        assert!(((&k * &u).dot(&second) - u.dot(&(&k * &second))).abs() < 1e-9 * energy);
    }
}

/// Faces of elements of first order, outwards.
fn faces(element: &dyn Element) -> &'static [&'static [usize]] {
    match element.nodes().len() {
        4 => &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]],
        5 => &[&[0, 3, 2, 1], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]],
        6 => &[&[0, 2, 1], &[3, 4, 5], &[0, 1, 4, 3], &[1, 2, 5, 4], &[2, 0, 3, 5]],
        _ => &[&[0, 3, 2, 1], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]],
    }
}

/// ∫ N_i n dS over a face: a third of the area at each corner of a triangle, the bilinear functions on a quadrilateral.
fn shares(face: &[usize], points: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let cross =
        |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|i| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3]);
    let sum =
        |weights: &[f64]| [0, 1, 2].map(|a| face.iter().zip(weights).map(|(&i, w)| w * points[i][a]).sum::<f64>());
    if face.len() == 3 {
        let normal = cross(sum(&[-1.0, 1.0, 0.0]), sum(&[-1.0, 0.0, 1.0]));
        return vec![normal.map(|v| v / 6.0); 3];
    }
    const AT: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let mut out = vec![[0.0; 3]; 4];
    for [x, y] in AT.map(|p| p.map(|v| v / 3.0_f64.sqrt())) {
        let n = AT.map(|[a, b]| 0.25 * (1.0 + a * x) * (1.0 + b * y));
        let along = sum(&AT.map(|[a, b]| 0.25 * a * (1.0 + b * y)));
        let normal = cross(along, sum(&AT.map(|[a, b]| 0.25 * b * (1.0 + a * x))));
        out.iter_mut().zip(n).for_each(|(out, n)| (0..3).for_each(|a| out[a] += n * normal[a]));
    }
    out
}

/// A linear displacement leaves at the nodes the forces of a constant stress on the faces. These are the same from either side of a face, so that elements
/// of any types side by side pass the patch test.
#[test]
fn constant_stress_leaves_the_forces_of_its_faces() {
    let (e, nu) = (70e9, 0.33);
    let slope = [[1.0e-3, 2.0e-4, -3.0e-4], [4.0e-4, -7.0e-4, 6.0e-4], [-2.0e-4, 5.0e-4, 9.0e-4]];
    let (lambda, shear) = (e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)));
    let trace = slope[0][0] + slope[1][1] + slope[2][2];
    let stress = |i: usize, j: usize| shear * (slope[i][j] + slope[j][i]) + if i == j { lambda * trace } else { 0.0 };
    for element in SOLIDS.into_iter().filter(|e| e.nodes().len() <= 8) {
        let points = distorted(element);
        let values = sample_values(element, &[("E", e), ("nu", nu)]);
        let k = element.stiffness(&ElementInput { points: &points, values: &values }).unwrap().to_dense();
        let found = k * displaced(&points, |p| std::array::from_fn(|i| (0..3).map(|j| slope[i][j] * p[j]).sum()));
        let mut expected = DVector::zeros(6 * points.len());
        for face in faces(element) {
            for (&node, share) in face.iter().zip(shares(face, &points)) {
                for i in 0..3 {
                    expected[6 * node + i] += (0..3).map(|j| stress(i, j) * share[j]).sum::<f64>();
                }
            }
        }
        let error = (&found - &expected).amax() / expected.amax();
        assert!(error < 1e-11, "{}: {error:e}", element.name());
    }
}

fn sample_values(element: &dyn Element, given: &[(&str, f64)]) -> Vec<Option<f64>> {
    element.properties().iter().map(|p| given.iter().find(|g| g.0 == p.name).map(|g| g.1)).collect()
}

/// Pure bending of one brick, u = κ (x y, -x²/2 - ν (y² - z²)/2, -ν y z): the incompatible modes carry it exactly, ½ E I κ² L; quadratic
/// elements do so too, and the trilinear brick without them would store 1.5 to 2 times as much.
#[test]
fn a_brick_bends() {
    let (e, nu, curvature) = (70e9, 0.3, 1e-2);
    let [l, h, w] = [0.2, 0.1, 0.08];
    for element in [&Hex8 as &dyn Element, &Hex20] {
        let natural: Vec<[f64; 3]> = unit_brick(element.nodes().len());
        let points: Vec<[f64; 3]> = natural.iter().map(|p| [l * p[0], h * (p[1] - 0.5), w * (p[2] - 0.5)]).collect();
        let origin = points[0];
        let relative: Vec<[f64; 3]> = points.iter().map(|p| std::array::from_fn(|i| p[i] - origin[i])).collect();
        let values = sample_values(element, &[("E", e), ("nu", nu), ("density", 1.0)]);
        let k = element.stiffness(&ElementInput { points: &relative, values: &values }).unwrap().to_dense();
        let field = |p: &[f64; 3]| {
            let [x, y, z] = [p[0], p[1], p[2]];
            let bent = [x * y, -0.5 * x * x - 0.5 * nu * (y * y - z * z), -nu * y * z];
            bent.map(|v| curvature * v)
        };
        let u = displaced(&points, field);
        let exact = 0.5 * e * (w * h.powi(3) / 12.0) * curvature * curvature * l;
        let energy = 0.5 * u.dot(&(&k * &u));
        assert!((energy / exact - 1.0).abs() < 1e-9, "{}: {}", element.name(), energy / exact);
    }
}

fn unit_brick(n: usize) -> Vec<[f64; 3]> {
    let corner = |i: usize| [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]][i % 4];
    let mut nodes: Vec<[f64; 3]> =
        (0..8).map(|i| [corner(i)[0], corner(i)[1], if i < 4 { 0.0 } else { 1.0 }]).collect();
    if n == 20 {
        for [a, b] in [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]] {
            nodes.push(std::array::from_fn(|i| 0.5 * (nodes[a][i] + nodes[b][i])));
        }
    }
    nodes
}

/// A mirror image and a flat element are refused by K and by M.
#[test]
fn inverted_and_flat_elements_are_refused() {
    for element in SOLIDS {
        let sample = &element.samples()[0];
        let values = sample.values(element.properties()).unwrap();
        for factor in [-1.0, 0.0] {
            let points: Vec<[f64; 3]> = sample.points.iter().map(|p| [p[0], p[1], factor * p[2]]).collect();
            let input = ElementInput { points: &points, values: &values };
            assert!(element.stiffness(&input).is_err() && element.mass(&input).is_err(), "{} {factor}", element.name());
        }
    }
}

/// Lumped or not, a distorted element of first order has its mass and its static moments: Σ m_i x_i = ∫ ρ x dV.
#[test]
fn lumping_keeps_the_centre_of_gravity_of_first_order_elements() {
    for element in SOLIDS.into_iter().filter(|e| e.nodes().len() <= 8) {
        let points = distorted(element);
        // Displacements of one direction, by one and by each coordinate: the mass and its moments.
        let moments = |lumping: f64| -> [f64; 4] {
            let values = sample_values(element, &[("E", 1.0), ("nu", 0.3), ("density", 2.0), ("lumping", lumping)]);
            let m = element.mass(&ElementInput { points: &points, values: &values }).unwrap().to_dense();
            let one = displaced(&points, |_| [1.0, 0.0, 0.0]);
            let by = |axis: usize| one.dot(&(&m * displaced(&points, |p| [p[axis], 0.0, 0.0])));
            [one.dot(&(&m * &one)), by(0), by(1), by(2)]
        };
        let (consistent, lumped) = (moments(0.0), moments(1.0));
        for (a, b) in lumped.into_iter().zip(consistent) {
            assert!((a - b).abs() < 1e-12 * consistent[0], "{}: {lumped:?} {consistent:?}", element.name());
        }
    }
}
