//! A swept free-free grillage like a flutter demonstrator: a stiff body, two wings, three dofs (uz, rx, ry) a node.
//!
//! Plain data, so that tests, benchmarks and the peer's script can share it. K and M are affine in 20 bounded parameters
//! that act on both wings alike, so the model is symmetric about y = 0. Body beams are a thousand times stiffer
//! than the wing.

// Included by tests, benchmarks and examples, where it is never public.
#![allow(unreachable_pub)]

/// One term: row, column (lower triangle), parameter or constant, coefficient.
pub type Term = (usize, usize, Option<usize>, f64);

/// The model.
#[derive(Debug, Clone)]
pub struct Grillage {
    /// Number of dofs.
    pub n: usize,
    /// Terms of K.
    pub stiffness: Vec<Term>,
    /// Terms of M.
    pub mass: Vec<Term>,
    /// Heave, roll and pitch at every dof.
    pub rigid: [Vec<f64>; 3],
    /// Partner of every dof in the mirror y -> -y, and its sign.
    pub mirror: (Vec<usize>, Vec<f64>),
    /// Bounds of the parameters.
    pub bounds: Vec<(f64, f64)>,
}

const N_PARAMETERS: usize = 20;
const EI: [usize; 2] = [0, 1];
const GJ: [usize; 2] = [2, 3];
const EI_BODY: usize = 4;
const GJ_BODY: usize = 5;
const MASS_PER_LENGTH: usize = 6;
const INERTIA_PER_LENGTH: usize = 7;
const BODY_MASS: usize = 8;
const BODY_INERTIA: usize = 9;
/// Five groups of wing nodes: point mass, then pitch inertia.
const POINT_MASS: usize = 10;
const POINT_INERTIA: usize = 15;

/// Four body nodes and `wing` nodes a side: n = 3 (4 + 2 wing).
pub fn grillage(wing: usize) -> Grillage {
    let body = 4;
    let mut nodes: Vec<[f64; 2]> = (0..body).map(|i| [0.3 * i as f64, 0.0]).collect();
    for side in [1.0, -1.0] {
        nodes.extend((1..=wing).map(|i| {
            let y = 1.5 * i as f64 / wing as f64;
            [0.3 + 0.4 * y, side * y]
        }));
    }
    let n = 3 * nodes.len();
    let (mut stiffness, mut mass) = (Vec::new(), Vec::new());
    for i in 1..body {
        let ends = [i - 1, i];
        beam(&nodes, ends, (Some(EI_BODY), 7e4), (Some(GJ_BODY), 5e4), &mut stiffness);
        inertia(&nodes, ends, (None, 2.0), (None, 0.02), &mut mass);
    }
    for i in 0..body {
        mass.push((3 * i, 3 * i, Some(BODY_MASS), 1.0));
        mass.push((3 * i + 1, 3 * i + 1, Some(BODY_INERTIA), 0.02));
        mass.push((3 * i + 2, 3 * i + 2, Some(BODY_INERTIA), 0.02));
    }
    for side in 0..2 {
        for i in 0..wing {
            let here = body + side * wing + i;
            let ends = [if i == 0 { 1 } else { here - 1 }, here];
            let half = usize::from(2 * i >= wing);
            beam(&nodes, ends, (Some(EI[half]), 70.0), (Some(GJ[half]), 50.0), &mut stiffness);
            inertia(&nodes, ends, (Some(MASS_PER_LENGTH), 1.0), (Some(INERTIA_PER_LENGTH), 2e-3), &mut mass);
            let group = 5 * i / wing;
            mass.push((3 * here, 3 * here, Some(POINT_MASS + group), 1.0));
            mass.push((3 * here + 2, 3 * here + 2, Some(POINT_INERTIA + group), 1.0));
        }
    }
    let rigid = [
        (0..n).map(|d| if d % 3 == 0 { 1.0 } else { 0.0 }).collect(),
        (0..n).map(|d| [nodes[d / 3][1], 1.0, 0.0][d % 3]).collect(),
        (0..n).map(|d| [-nodes[d / 3][0], 0.0, 1.0][d % 3]).collect(),
    ];
    let partner = |node: usize| match node {
        i if i < body => i,
        i if i < body + wing => i + wing,
        i => i - wing,
    };
    let mirror =
        ((0..n).map(|d| 3 * partner(d / 3) + d % 3).collect(), (0..n).map(|d| [1.0, -1.0, 1.0][d % 3]).collect());
    let per_node = 5.0 / wing as f64;
    let mut bounds = vec![(0.6, 1.6); N_PARAMETERS];
    bounds[POINT_MASS..POINT_INERTIA].fill((0.0, 0.2 * per_node));
    bounds[POINT_INERTIA..].fill((0.0, 2e-3 * per_node));
    Grillage { n, stiffness, mass, rigid, mirror, bounds }
}

/// The middle of the bounds.
pub fn nominal(model: &Grillage) -> Vec<f64> {
    model.bounds.iter().map(|b| 0.5 * (b.0 + b.1)).collect()
}

/// Random candidates inside the bounds; some parameters stand exactly on a bound, as an optimiser puts them.
pub fn candidates(model: &Grillage, count: usize, seed: u64) -> Vec<Vec<f64>> {
    use rand::{RngExt, SeedableRng};
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let mut draw = |&(low, high): &(f64, f64)| {
        let t: f64 = rng.random::<f64>() * 1.2 - 0.1;
        low + (high - low) * t.clamp(0.0, 1.0)
    };
    (0..count).map(|_| model.bounds.iter().map(&mut draw).collect()).collect()
}

/// Adds `factor v vᵀ` scaled by a parameter, v given by (dof, value).
fn outer(v: &[(usize, f64)], parameter: Option<usize>, factor: f64, terms: &mut Vec<Term>) {
    for &(i, x) in v {
        for &(j, y) in v {
            if j <= i && x * y != 0.0 {
                terms.push((i, j, parameter, factor * x * y));
            }
        }
    }
}

/// Direction cosines and length.
fn axis(nodes: &[[f64; 2]], [a, b]: [usize; 2]) -> (f64, f64, f64) {
    let (dx, dy) = (nodes[b][0] - nodes[a][0], nodes[b][1] - nodes[a][1]);
    let length = dx.hypot(dy);
    (dx / length, dy / length, length)
}

/// Euler-Bernoulli bending and Saint-Venant torsion, as a sum of the squares of their strain modes.
fn beam(
    nodes: &[[f64; 2]],
    ends: [usize; 2],
    (ei_parameter, ei): (Option<usize>, f64),
    (gj_parameter, gj): (Option<usize>, f64),
    terms: &mut Vec<Term>,
) {
    let (c, s, l) = axis(nodes, ends);
    let [a, b] = ends.map(|node| 3 * node);
    // Slope along the beam: w' = s rx - c ry.
    let bend = [(a + 1, -s), (a + 2, c), (b + 1, s), (b + 2, -c)];
    outer(&bend, ei_parameter, ei / l, terms);
    let shear = [(a, 2.0 / l), (a + 1, s), (a + 2, -c), (b, -2.0 / l), (b + 1, s), (b + 2, -c)];
    outer(&shear, ei_parameter, 3.0 * ei / l, terms);
    let twist = [(a + 1, -c), (a + 2, -s), (b + 1, c), (b + 2, s)];
    outer(&twist, gj_parameter, gj / l, terms);
}

/// Consistent mass of the deflection (Hermite cubics) and of the twist (linear).
fn inertia(
    nodes: &[[f64; 2]],
    ends: [usize; 2],
    (mu_parameter, mu): (Option<usize>, f64),
    (j_parameter, j): (Option<usize>, f64),
    terms: &mut Vec<Term>,
) {
    let (c, s, l) = axis(nodes, ends);
    let [a, b] = ends.map(|node| 3 * node);
    // Four Gauss points: exact for the sixth-order integrand.
    let gauss = [(0.06943184420297371, 0.17392742256872692), (0.33000947820757187, 0.3260725774312731)];
    for (x, weight) in gauss.into_iter().flat_map(|(x, w)| [(x, w), (1.0 - x, w)]) {
        let (h1, h2) = (1.0 - 3.0 * x * x + 2.0 * x * x * x, l * (x - 2.0 * x * x + x * x * x));
        let (h3, h4) = (3.0 * x * x - 2.0 * x * x * x, l * (x * x * x - x * x));
        let w = [(a, h1), (a + 1, s * h2), (a + 2, -c * h2), (b, h3), (b + 1, s * h4), (b + 2, -c * h4)];
        outer(&w, mu_parameter, mu * l * weight, terms);
        let twist = [(a + 1, c * (1.0 - x)), (a + 2, s * (1.0 - x)), (b + 1, c * x), (b + 2, s * x)];
        outer(&twist, j_parameter, j * l * weight, terms);
    }
}
