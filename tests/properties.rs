//! What holds for every admissible structure: random three-dimensional frames of beams in random orientations, bushings
//! with their own axes, masses with offset and inertia, rigid links.
//!
//! A structure is drawn from a tape of numbers, so that proptest can shrink it, and written as a model file: the whole
//! way from YAML to modes is under test.

use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, Vector3};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;
use retune::linalg::{symmetric_eigen, thin_svd};
use retune::modal::{Modes, SolveOptions, solve};
use retune::model::{Model, ParametricModel, Registry, System, load};
use std::fmt::Write as _;

/// Numbers in [0, 1) that decide everything about a structure.
struct Tape<'a> {
    numbers: &'a [f64],
    next: usize,
}

impl Tape<'_> {
    fn unit(&mut self) -> f64 {
        self.next += 1;
        self.numbers[(self.next - 1) % self.numbers.len()]
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Evenly spread over decades.
    fn decades(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }

    fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }

    fn direction(&mut self) -> Vector3<f64> {
        let (z, angle) = (self.between(-1.0, 1.0), self.between(0.0, std::f64::consts::TAU));
        let r = (1.0 - z * z).sqrt();
        Vector3::new(r * angle.cos(), r * angle.sin(), z)
    }

    fn rotation(&mut self) -> Rotation3<f64> {
        let axis = nalgebra::Unit::new_normalize(self.direction());
        Rotation3::from_axis_angle(&axis, self.between(0.0, std::f64::consts::PI))
    }
}

/// A unit vector across `along`.
fn across(along: Vector3<f64>, wish: Vector3<f64>) -> Vector3<f64> {
    let first = along.cross(&wish);
    if first.norm() > 0.1 { first.normalize() } else { along.cross(&Vector3::ith(along.iamin(), 1.0)).normalize() }
}

#[derive(Debug, Clone)]
struct Beam {
    nodes: [usize; 2],
    orientation: Vector3<f64>,
    /// E, G, A, Iy, Iz, J, mass per length, polar inertia per length.
    section: [f64; 8],
}

#[derive(Debug, Clone)]
struct Bushing {
    nodes: [usize; 2],
    axes: Rotation3<f64>,
    k: [f64; 6],
}

#[derive(Debug, Clone)]
struct Mass {
    node: usize,
    axes: Rotation3<f64>,
    kg: f64,
    inertia: [f64; 3],
    offset: Vector3<f64>,
}

/// A free structure.
#[derive(Debug, Clone)]
struct Structure {
    nodes: Vec<Vector3<f64>>,
    beams: Vec<Beam>,
    bushings: Vec<Bushing>,
    masses: Vec<Mass>,
    /// (master, slave)
    links: Vec<(usize, usize)>,
}

impl Structure {
    fn draw(n_nodes: usize, numbers: &[f64]) -> Self {
        let mut t = Tape { numbers, next: 0 };
        let mut s = Self {
            nodes: vec![Vector3::zeros()],
            beams: Vec::new(),
            bushings: Vec::new(),
            masses: Vec::new(),
            links: Vec::new(),
        };
        // A tree of beams and, now and then, bushings or rigid links; then some loops.
        for node in 1..n_nodes {
            let parent = t.below(node);
            let step = t.direction() * t.between(0.3, 1.0);
            s.nodes.push(s.nodes[parent] + step);
            let kind = if node == 1 { 0 } else { t.below(5) };
            match kind {
                3 => {
                    let k = [0, 1, 2, 3, 4, 5].map(|d| t.decades(1e3, 1e5) * if d < 3 { 10.0 } else { 1.0 });
                    s.bushings.push(Bushing { nodes: [parent, node], axes: t.rotation(), k });
                    s.lump(node, &mut t);
                }
                4 => {
                    s.links.push((parent, node));
                    s.lump(node, &mut t);
                }
                _ => s.beam([parent, node], &mut t),
            }
        }
        for _ in 0..t.below(3) {
            let (a, b) = (t.below(n_nodes), t.below(n_nodes));
            if a != b && (s.nodes[a] - s.nodes[b]).norm() > 0.2 {
                s.beam([a, b], &mut t);
            }
        }
        let node = t.below(n_nodes);
        s.lump(node, &mut t);
        s
    }

    fn beam(&mut self, nodes: [usize; 2], t: &mut Tape<'_>) {
        let along = (self.nodes[nodes[1]] - self.nodes[nodes[0]]).normalize();
        // A thin-walled or solid section of some centimetres: radii of gyration of 3 to 30 mm.
        let (area, r1, r2) = (t.decades(1e-4, 1e-3), t.decades(3e-3, 3e-2), t.decades(3e-3, 3e-2));
        let (iy, iz) = (area * r1 * r1, area * r2 * r2);
        let rho = t.between(1500.0, 8000.0);
        let section = [
            t.between(30e9, 210e9),
            t.between(5e9, 80e9),
            area,
            iy,
            iz,
            t.between(0.1, 1.0) * (iy + iz),
            rho * area,
            rho * (iy + iz),
        ];
        let wish = t.direction();
        self.beams.push(Beam { nodes, orientation: across(along, wish), section });
    }

    fn lump(&mut self, node: usize, t: &mut Tape<'_>) {
        let mass = t.decades(0.05, 5.0);
        // Moments of a box of masses: the largest is below the sum of the others.
        let [a, b, c] = [0; 3].map(|_| mass * t.decades(1e-4, 1e-2));
        let offset = t.direction() * t.between(0.0, 0.2);
        self.masses.push(Mass { node, axes: t.rotation(), kg: mass, inertia: [b + c, a + c, a + b], offset });
    }

    fn moved(&self, rotation: &Rotation3<f64>, by: Vector3<f64>) -> Self {
        let mut s = self.clone();
        s.nodes.iter_mut().for_each(|p| *p = rotation * *p + by);
        s.beams.iter_mut().for_each(|b| b.orientation = rotation * b.orientation);
        s.bushings.iter_mut().for_each(|b| b.axes = rotation * b.axes);
        s.masses.iter_mut().for_each(|m| m.axes = rotation * m.axes);
        s
    }

    /// The model file, its entries turned by `turn` places and backwards; `rest` stands behind it.
    fn yaml(&self, turn: usize, rest: &str) -> String {
        let vector = |v: &Vector3<f64>| format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z);
        let mut text = "retune: 1\nname: a random frame\n".to_string();
        let mut frames = String::new();
        let mut frame = |name: &str, axes: &Rotation3<f64>| {
            let (x, y) = (axes * Vector3::x(), axes * Vector3::y());
            let _ = writeln!(frames, "  {name}: {{x: {}, xy: {}}}", vector(&x), vector(&y));
        };
        let mut room = |name: &str, mut lines: Vec<String>| {
            if !lines.is_empty() {
                let by = turn % lines.len();
                lines.rotate_left(by);
                if turn > 0 {
                    lines.reverse();
                }
                let _ = writeln!(text, "{name}:\n{}", lines.join("\n"));
            }
        };
        room("nodes", self.nodes.iter().enumerate().map(|(i, p)| format!("  n{i}: {}", vector(p))).collect());
        let beams = self.beams.iter().enumerate().map(|(i, b)| {
            let [e, g, a, iy, iz, j, m, p] = b.section;
            format!(
                "  b{i}: {{nodes: [n{}, n{}], orientation: {}, properties: {{E: {e:?}, G: {g:?}, A: {a:?}, Iy: {iy:?}, Iz: {iz:?}, J: {j:?}, mass_per_length: {m:?}, polar_inertia_per_length: {p:?}}}}}",
                b.nodes[0], b.nodes[1], vector(&b.orientation)
            )
        });
        room("beams", beams.collect());
        let mut bushings = Vec::new();
        for (i, b) in self.bushings.iter().enumerate() {
            frame(&format!("bushing{i}"), &b.axes);
            let k: Vec<String> =
                ["ux", "uy", "uz", "rx", "ry", "rz"].iter().zip(b.k).map(|(d, k)| format!("{d}: {k:?}")).collect();
            let [a, c] = b.nodes;
            bushings.push(format!("  s{i}: {{nodes: [n{a}, n{c}], frame: bushing{i}, k: {{{}}}}}", k.join(", ")));
        }
        room("bushings", bushings);
        let mut masses = Vec::new();
        for (i, m) in self.masses.iter().enumerate() {
            frame(&format!("lump{i}"), &m.axes);
            let [xx, yy, zz] = m.inertia;
            masses.push(format!(
                "  m{i}: {{node: n{}, frame: lump{i}, mass: {:?}, inertia: {{xx: {xx:?}, yy: {yy:?}, zz: {zz:?}}}, offset: {}}}",
                m.node, m.kg, vector(&m.offset)
            ));
        }
        room("masses", masses);
        let links =
            self.links.iter().enumerate().map(|(i, (m, s))| format!("  l{i}: {{master: n{m}, slaves: [n{s}]}}"));
        room("rigid_links", links.collect());
        text + "frames:\n" + &frames + rest
    }

    fn total_mass(&self) -> f64 {
        let beams = self.beams.iter().map(|b| b.section[6] * (self.nodes[b.nodes[1]] - self.nodes[b.nodes[0]]).norm());
        beams.sum::<f64>() + self.masses.iter().map(|m| m.kg).sum::<f64>()
    }
}

fn build(text: &str) -> Model {
    match load(text, &Registry::builtin()) {
        Ok((model, ..)) => model,
        Err(problems) => panic!("{problems:#?}\n{text}"),
    }
}

fn modes_of(model: &Model) -> (System, Modes) {
    let system = model.assemble(&[]).unwrap();
    let options = SolveOptions { n_elastic: 8, shift: None };
    let modes = solve(&system.stiffness, &system.mass, &model.dof_map().rigid_motions(), options).unwrap();
    (system, modes)
}

/// A matrix with unit diagonal: rounding in it is comparable over translations and rotations.
fn unit_diagonal(a: &DMatrix<f64>, by: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] / (by[(i, i)] * by[(j, j)]).sqrt())
}

/// Relative rounding of λ: entries of K carry some ε of the largest λ of the structure, and the solver, which shifts by
/// about the first elastic λ, some ε λ/λ_first.
fn rounding_of(system: &System, modes: &Modes, lambda: f64) -> f64 {
    let n = system.mass.nrows();
    let highest = (0..n).map(|i| system.stiffness[(i, i)] / system.mass[(i, i)]).fold(0.0, f64::max);
    1e2 * f64::EPSILON * (highest.max(lambda) / lambda + lambda / modes.lambda[modes.n_rigid])
}

fn structures() -> impl Strategy<Value = (Structure, Vec<f64>)> {
    (3usize..7, prop::collection::vec(0.0..1.0f64, 160)).prop_map(|(n, tape)| (Structure::draw(n, &tape), tape))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, rng_seed: proptest::test_runner::RngSeed::Fixed(20_261_122), failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("regressions"))), ..ProptestConfig::default() })]

    #[test]
    fn matrices_are_symmetric_and_definite_and_rigid_motion_is_free((s, _) in structures()) {
        let model = build(&s.yaml(0, ""));
        let (System { stiffness: k, mass: m, .. }, modes) = modes_of(&model);
        prop_assert_eq!(&k, &k.transpose());
        prop_assert_eq!(&m, &m.transpose());
        prop_assert!(unit_diagonal(&m, &m).cholesky().is_some(), "M is not positive definite");
        let eigen = symmetric_eigen(&unit_diagonal(&k, &k)).unwrap().values;
        // n roundings of entries of size one.
        let zero = 1e2 * k.nrows() as f64 * f64::EPSILON;
        prop_assert!(eigen.min() > -zero, "K has the eigenvalue {}", eigen.min());
        prop_assert_eq!(eigen.iter().filter(|v| **v < zero).count(), 6);
        let motions = model.dof_map().rigid_motions();
        let (residual, size) = (&k * &motions, k.abs() * motions.abs());
        prop_assert!(residual.abs().zip_fold(&size, 0.0f64, |w, r, s| w.max(r / s.max(f64::MIN_POSITIVE))) < 1e-11);
        prop_assert_eq!((modes.n_rigid, modes.n_mechanism), (6, 0));
        prop_assert!(modes.lambda.iter().take(6).all(|l| *l == 0.0));
        prop_assert!(modes.lambda.iter().skip(6).all(|l| *l > 0.0));
    }

    #[test]
    fn modes_satisfy_the_eigenproblem_and_are_mass_normalised((s, _) in structures()) {
        let (System { stiffness: k, mass: m, .. }, modes) = modes_of(&build(&s.yaml(0, "")));
        let gram = modes.shapes.transpose() * &m * &modes.shapes;
        prop_assert!((gram - DMatrix::identity(modes.len(), modes.len())).amax() < 1e-9);
        for (j, lambda) in modes.lambda.iter().enumerate() {
            let phi = modes.shapes.column(j);
            let residual = (&k * phi - &m * phi * *lambda).abs();
            let size = k.abs() * phi.abs() + m.abs() * phi.abs() * *lambda;
            prop_assert!(residual.norm() < 1e-9 * size.norm(), "mode {}: {}", j + 1, residual.norm() / size.norm());
        }
    }

    #[test]
    fn frequencies_do_not_depend_on_numbering((s, _) in structures(), turn in 1usize..9) {
        let (system, modes) = modes_of(&build(&s.yaml(0, "")));
        let (_, other) = modes_of(&build(&s.yaml(turn, "")));
        for (a, b) in modes.lambda.iter().zip(&other.lambda).skip(6) {
            prop_assert!((a - b).abs() <= rounding_of(&system, &modes, *a) * a, "{} and {}", a, b);
        }
    }

    #[test]
    fn a_moved_structure_is_the_same_structure((s, tape) in structures(), by in prop::array::uniform3(-5.0..5.0f64)) {
        let rotation = Tape { numbers: &tape, next: 97 }.rotation();
        let by = Vector3::from(by);
        let (here, there) = (build(&s.yaml(0, "")), build(&s.moved(&rotation, by).yaml(0, "")));
        let ((system, a), (_, b)) = (modes_of(&here), modes_of(&there));
        prop_assert_eq!((b.n_rigid, b.n_mechanism), (6, 0));
        for (one, other) in a.lambda.iter().zip(&b.lambda).skip(6) {
            prop_assert!((one - other).abs() <= rounding_of(&system, &a, *one) * one, "{} and {}", one, other);
        }
        let [p, q] = [&here, &there].map(|m| m.mass_properties(&[]).unwrap().unwrap());
        prop_assert!((p.mass - s.total_mass()).abs() < 1e-12 * p.mass);
        prop_assert!((p.mass - q.mass).abs() < 1e-12 * p.mass);
        let cg = rotation * Vector3::from(p.cg) + by;
        prop_assert!((cg - Vector3::from(q.cg)).norm() < 1e-12 * (1.0 + cg.norm()));
        let tensor = |i: [[f64; 3]; 3]| Matrix3::from_fn(|r, c| i[r][c]);
        let turned = rotation.matrix() * tensor(p.inertia) * rotation.matrix().transpose();
        // Steiner's terms cancel: rounding of m (distance from the origin)².
        let rounding = 1e-13 * (q.mass * (1.0 + cg.norm_squared()) + turned.amax());
        prop_assert!((turned - tensor(q.inertia)).amax() < 10.0 * rounding);
    }

    /// Supports, rigid links and multipoint constraints by elimination, against the full system with multipliers:
    ///
    /// [ K + a M  Aᵀ ] [ u ]   [ f ]
    /// [ A        0  ] [ λ ] = [ 0 ]
    ///
    /// The columns of T span the null space of A, and the reduced matrices are Tᵀ K T and Tᵀ M T: both to rounding. The
    /// solutions agree as far as the condition of the system with multipliers lets them. Its rows are scaled to a
    /// unit diagonal first: without that, stiffnesses of 10⁹ beside inertias of 10⁻³ cost it ten digits.
    #[test]
    fn elimination_equals_lagrange_multipliers((s, tape) in structures()) {
        let mut t = Tape { numbers: &tape, next: 61 };
        let n = s.nodes.len();
        let (held, tied) = (t.below(n), [t.below(n), t.below(n), t.below(n)]);
        let factors = [0; 3].map(|_| t.between(0.5, 2.0));
        let rest = format!(
            "supports:\n  pin: {{node: n{held}, fixed: [ux, uz, ry]}}\nconstraints:\n  tie: {{terms: [{{node: n{}, dof: ux, factor: {:?}}}, {{node: n{}, dof: uy, factor: {:?}}}, {{node: n{}, dof: rz, factor: {:?}}}]}}\n",
            tied[0], factors[0], tied[1], -factors[1], tied[2], factors[2]
        );
        let constrained = build(&s.yaml(0, &rest));
        let mut free = s.clone();
        free.links.clear();
        let full = build(&free.yaml(0, ""));
        prop_assert_eq!(full.dof_map().n_dof(), 6 * n);

        let mut rows: Vec<DVector<f64>> = Vec::new();
        let mut row = |terms: &[(usize, usize, f64)]| {
            let mut a = DVector::zeros(6 * n);
            for (node, dof, factor) in terms {
                a[6 * node + dof] += factor;
            }
            rows.push(a);
        };
        for d in [0, 2, 4] {
            row(&[(held, d, 1.0)]);
        }
        row(&[(tied[0], 0, factors[0]), (tied[1], 1, -factors[1]), (tied[2], 5, factors[2])]);
        for &(master, slave) in &s.links {
            let arm = s.nodes[slave] - s.nodes[master];
            for d in 0..3 {
                // u_slave = u_master + θ x arm
                let cross = (0..3).map(|axis| (master, 3 + axis, -Vector3::ith(axis, 1.0).cross(&arm)[d]));
                let terms: Vec<_> = [(slave, d, 1.0), (master, d, -1.0)].into_iter().chain(cross).collect();
                row(&terms);
                row(&[(slave, 3 + d, 1.0), (master, 3 + d, -1.0)]);
            }
        }
        let a = DMatrix::from_columns(&rows).transpose();
        let f = DVector::from_fn(6 * n, |_, _| t.between(-1.0, 1.0));
        let (big, small) = (full.assemble(&[]).unwrap(), constrained.assemble(&[]).unwrap());
        let dofs = constrained.dof_map();
        let mut transformation = DMatrix::zeros(6 * n, dofs.n_dof());
        for node in 0..n {
            for (d, dof) in retune::element::Dof::ALL.into_iter().enumerate() {
                dofs.express(node, dof).iter().for_each(|&(row, factor)| transformation[(6 * node + d, row)] = factor);
            }
        }
        let (t, size) = (&transformation, transformation.abs());
        let broken = (&a * t).zip_fold(&(a.abs() * &size), 0.0f64, |w, r, s| w.max(r.abs() / s.max(f64::MIN_POSITIVE)));
        prop_assert!(broken < 1e-12, "A T is {broken:e} of |A| |T|");
        let rank = thin_svd(&a.transpose()).unwrap().rank(1e-9);
        prop_assert_eq!((t.ncols(), thin_svd(t).unwrap().rank(1e-9)), (6 * n - rank, 6 * n - rank));
        for (whole, reduced) in [(&big.stiffness, &small.stiffness), (&big.mass, &small.mass)] {
            // An entry is a sum of products with direction cosines: rounding of the stiffest of its kind.
            let stiffest = |rotation: bool| {
                (0..6 * n).filter(|i| (i % 6 > 2) == rotation).map(|i| whole[(i, i)]).fold(0.0, f64::max).sqrt()
            };
            let scales = DVector::from_fn(6 * n, |i, _| stiffest(i % 6 > 2));
            let scales = size.tr_mul(&scales);
            let (exact, size) = (t.tr_mul(&(whole * t)), &scales * scales.transpose());
            let wrong = (exact - reduced).zip_fold(&size, 0.0f64, |w, r, s| w.max(r.abs() / s.max(f64::MIN_POSITIVE)));
            prop_assert!(wrong < 1e-12, "Tᵀ A T is wrong by {wrong:e} of its terms");
        }
        for shift in [1e3, 1e6] {
            let dynamic = &big.stiffness + &big.mass * shift;
            let scale = dynamic.diagonal().map(|d| 1.0 / d.sqrt());
            let (p, q) = (6 * n, a.nrows());
            let mut saddle = DMatrix::zeros(p + q, p + q);
            for j in 0..p {
                for i in 0..p {
                    saddle[(i, j)] = dynamic[(i, j)] * scale[i] * scale[j];
                }
            }
            for i in 0..q {
                let row = DVector::from_fn(p, |j, _| a[(i, j)] * scale[j]).normalize();
                for j in 0..p {
                    saddle[(p + i, j)] = row[j];
                    saddle[(j, p + i)] = row[j];
                }
            }
            let mut right = DVector::zeros(p + q);
            right.rows_mut(0, p).copy_from(&f.component_mul(&scale));
            // Rows of a redundant constraint have no multipliers of their own: the least solution.
            let redundant = q - rank;
            let svd = thin_svd(&saddle).unwrap();
            let kept = p + q - redundant;
            let (first, last) = (svd.values[0], svd.values[kept - 1]);
            let u = (svd.pseudo_inverse(0.5 * last / first) * &right).rows(0, p).into_owned();
            let reduced = &small.stiffness + &small.mass * shift;
            let q = reduced.cholesky().unwrap().solve(&t.tr_mul(&f));
            let v = (t * q).component_div(&scale);
            let (error, condition) = ((&u - &v).norm() / v.norm(), first / last);
            prop_assert!(error < 1e2 * f64::EPSILON * condition, "shift {shift}: {error:e} with condition {condition:e}");
            prop_assert!(condition < 1e11, "shift {shift}: nothing is compared with condition {condition:e}");
        }
    }
}
