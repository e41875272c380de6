//! The batch kernel against closed forms, the reference path and itself.

use super::dispatch::Level;
use super::*;

#[path = "../../../benches/grillage/mod.rs"]
mod grillage;

fn entries(terms: &[grillage::Term]) -> Vec<AffineEntry> {
    terms.iter().map(|&(row, col, parameter, coefficient)| AffineEntry { row, col, parameter, coefficient }).collect()
}

fn pencil_of(data: &grillage::Grillage) -> AffinePencil {
    AffinePencil {
        n: data.n,
        n_parameters: data.bounds.len(),
        stiffness: entries(&data.stiffness),
        mass: entries(&data.mass),
    }
}

fn mirror_of(data: &grillage::Grillage) -> Mirror {
    Mirror { permutation: data.mirror.0.clone(), signs: data.mirror.1.clone() }
}

/// The grillage, whole or in halves, with 9 modes.
fn wing_model(wing: usize, halves: bool) -> (BatchModel, grillage::Grillage) {
    wing_modes(wing, halves, 9)
}

fn wing_modes(wing: usize, halves: bool, n_modes: usize) -> (BatchModel, grillage::Grillage) {
    let data = grillage::grillage(wing);
    let options = BatchOptions {
        n_modes,
        rigid: DMatrix::from_fn(data.n, 3, |i, j| data.rigid[j][i]),
        mirror: halves.then(|| mirror_of(&data)),
        sensors: None,
        references: None,
        shapes: true,
    };
    (BatchModel::new(pencil_of(&data), &grillage::nominal(&data), options).unwrap(), data)
}

fn slices(thetas: &[Vec<f64>]) -> Vec<&[f64]> {
    thetas.iter().map(Vec::as_slice).collect()
}

/// Free or clamped chain of equal masses; parameter 0 is the stiffness, parameter 1 the mass.
fn chain(n: usize, clamped: bool) -> AffinePencil {
    let mut stiffness = Vec::new();
    let mut add = |row, col, coefficient| stiffness.push(AffineEntry { row, col, parameter: Some(0), coefficient });
    for i in 0..n {
        if i > 0 {
            add(i - 1, i - 1, 1.0);
            add(i, i - 1, -1.0);
            add(i, i, 1.0);
        }
    }
    if clamped {
        add(0, 0, 1.0);
        add(n - 1, n - 1, 1.0);
    }
    let mass = (0..n).map(|i| AffineEntry { row: i, col: i, parameter: Some(1), coefficient: 1.0 }).collect();
    AffinePencil { n, n_parameters: 2, stiffness, mass }
}

fn options(n_modes: usize, n: usize, free: bool) -> BatchOptions {
    let rigid = if free { DMatrix::from_element(n, 1, 1.0) } else { DMatrix::zeros(n, 0) };
    BatchOptions { n_modes, rigid, mirror: None, sensors: None, references: None, shapes: true }
}

/// ω_j² = 4 k/m sin²(j π / 2n) free, 4 k/m sin²(j π / 2(n+1)) clamped. Blevins, Formulas for Natural Frequency, 1979,
/// table 6-2. The inverse problem has an error of a few ε times λ_last / λ_first relative to the last value.
#[test]
fn chains_have_their_closed_form() {
    for n in [3, 8, 33] {
        for clamped in [false, true] {
            for scale in [1e-9, 1.0, 1e12] {
                let n_modes = 5.min(n - 1);
                let nominal = [scale, 1.0];
                let model = BatchModel::new(chain(n, clamped), &nominal, options(n_modes, n, !clamped)).unwrap();
                let mut workspace = Workspace::new(&model, 1);
                let modes = model.solve(&[&[scale, 2.0]], &mut workspace).unwrap();
                assert_eq!(modes.outcome(0), &Outcome::Batch);
                let size = if clamped { n + 1 } else { n } as f64;
                for (j, lambda) in modes.values(0).iter().enumerate() {
                    let exact = 2.0 * scale * ((j + 1) as f64 * std::f64::consts::PI / (2.0 * size)).sin().powi(2);
                    assert!((lambda / exact - 1.0).abs() < 1e-12, "{n} {clamped} {scale} {j}: {lambda} {exact}");
                }
            }
        }
    }
}

/// M-orthogonality and residuals of the modes of a test, and of two thirds of a spectrum.
#[test]
fn grillages_agree_with_the_reference_path() {
    for (wing, halves, n_modes) in
        [(2, true, 9), (5, true, 9), (5, false, 9), (8, true, 9), (2, true, 16), (5, false, 30)]
    {
        let (model, data) = wing_modes(wing, halves, n_modes);
        let thetas = grillage::candidates(&data, 24, 7);
        let mut workspace = Workspace::new(&model, 24);
        let modes = model.solve(&slices(&thetas), &mut workspace).unwrap();
        assert_eq!(modes.n_redone(), 0);
        for (c, theta) in thetas.iter().enumerate() {
            let (values, shapes) = model.reference(theta).unwrap();
            let (k, m) = model.pencil().assemble(theta);
            for j in 0..n_modes {
                let lambda = modes.values(c)[j];
                assert!((lambda / values[j] - 1.0).abs() < 2e-9, "{wing} {c} {j}: {lambda} {}", values[j]);
                let phi = DMatrix::from_column_slice(data.n, 1, modes.shape(c, j));
                let residual = (&k * &phi - &m * &phi * lambda).abs().max();
                assert!(residual < 1e-13 * k.abs().max() * phi.abs().max());
                for other in 0..=j {
                    let psi = DMatrix::from_column_slice(data.n, 1, modes.shape(c, other));
                    let gram = (psi.transpose() * &m * &phi)[(0, 0)];
                    let exact = if j == other { 1.0 } else { 0.0 };
                    assert!((gram - exact).abs() < 1e-13, "{wing} {c} {j} {other} {gram}");
                }
                // Alone in its neighbourhood: the same shape as the reference path, up to the sign.
                let gap = |i: usize| (values[i] / values[j] - 1.0).abs();
                if (0..n_modes).all(|i| i == j || gap(i) > 1e-2) && j + 1 < n_modes {
                    let m_phi = &m * &phi;
                    assert!((shapes.column(j).dot(&m_phi.column(0)).abs() - 1.0).abs() < 1e-10);
                }
            }
        }
    }
}

#[test]
fn rigid_motions_are_orthogonal_to_every_shape() {
    let (model, data) = wing_model(5, true);
    let thetas = grillage::candidates(&data, 8, 3);
    let mut workspace = Workspace::new(&model, 8);
    let modes = model.solve(&slices(&thetas), &mut workspace).unwrap();
    for (c, theta) in thetas.iter().enumerate() {
        let (_, m) = model.pencil().assemble(theta);
        for j in 0..9 {
            let phi = DMatrix::from_column_slice(data.n, 1, modes.shape(c, j));
            for rigid in &data.rigid {
                let r = DMatrix::from_column_slice(data.n, 1, rigid);
                let norm = (r.transpose() * &m * &r)[(0, 0)].sqrt();
                assert!((r.transpose() * &m * &phi)[(0, 0)].abs() < 1e-12 * norm);
            }
        }
    }
}

/// The bits of a candidate depend neither on its companions, nor on its lane, nor on the size of the call.
#[test]
fn a_candidate_does_not_notice_its_companions() {
    let (model, data) = wing_model(5, true);
    let mut thetas = grillage::candidates(&data, 19, 11);
    // A companion that converges differently, and two that have no solution at all.
    thetas[3][EI_OUTER] = 1e-4;
    thetas[5][EI_OUTER] = -1.0;
    thetas[6][EI_OUTER] = f64::NAN;
    let mut workspace = Workspace::new(&model, 32);
    let together = model.solve(&slices(&thetas), &mut workspace).unwrap().clone();
    let mut alone = Workspace::new(&model, 1);
    let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    for (c, theta) in thetas.iter().enumerate() {
        let single = model.solve(&[theta], &mut alone).unwrap();
        assert_eq!(single.outcome(0), together.outcome(c));
        assert_eq!(bits(single.values(0)), bits(together.values(c)), "{c}");
        for j in 0..9 {
            assert_eq!(bits(single.shape(0, j)), bits(together.shape(c, j)), "{c} {j}");
        }
    }
    assert!(matches!(together.outcome(5), Outcome::NotSolvable { cause: Cause::Stiffness, .. }));
    assert!(matches!(together.outcome(6), Outcome::NotSolvable { .. }));
    assert!(together.values(6).iter().all(|v| v.is_nan()));
}

const EI_OUTER: usize = 1;

/// Fused multiply-add changes the rounding, not more; wider registers change nothing.
#[test]
fn instruction_sets_agree() {
    for (wing, whole) in [(5, true), (2, false), (5, false)] {
        let (model, data) = wing_model(wing, whole);
        let thetas = grillage::candidates(&data, 16, 5);
        let with = |level| {
            let mut workspace = Workspace::with_level(&model, 16, level);
            model.solve(&slices(&thetas), &mut workspace).unwrap().clone()
        };
        let all: Vec<(Level, BatchModes)> = dispatch::levels().map(|l| (l, with(l))).collect();
        let (_, baseline) = all.last().unwrap();
        for (level, modes) in &all {
            for c in 0..16 {
                for (a, b) in modes.values(c).iter().zip(baseline.values(c)) {
                    assert!((a / b - 1.0).abs() < 2e-9, "{level:?}");
                }
                if *level == Level::Baseline {
                    continue;
                }
                let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
                assert_eq!(bits(modes.values(c)), bits(all[0].1.values(c)), "{level:?}");
                for j in 0..modes.values(c).len() {
                    assert_eq!(bits(modes.shape(c, j)), bits(all[0].1.shape(c, j)), "{level:?}");
                }
            }
        }
    }
}

/// Two uncoupled equal chains: every eigenvalue is double. The shapes must still be orthonormal, the count right.
#[test]
fn double_modes_are_found_twice() {
    let n = 12;
    let one = chain(n, true);
    let twice = |entries: &[AffineEntry]| {
        let shifted = entries.iter().map(|e| AffineEntry { row: e.row + n, col: e.col + n, ..*e });
        entries.iter().copied().chain(shifted).collect::<Vec<_>>()
    };
    let pencil = AffinePencil { n: 2 * n, n_parameters: 2, stiffness: twice(&one.stiffness), mass: twice(&one.mass) };
    let model = BatchModel::new(pencil, &[1.0, 1.0], options(6, 2 * n, false)).unwrap();
    let mut workspace = Workspace::new(&model, 1);
    let modes = model.solve(&[&[3.0, 1.0]], &mut workspace).unwrap();
    assert_eq!(modes.outcome(0), &Outcome::Batch);
    for j in 0..6 {
        let exact = 12.0 * ((j / 2 + 1) as f64 * std::f64::consts::PI / (2.0 * (n + 1) as f64)).sin().powi(2);
        assert!((modes.values(0)[j] / exact - 1.0).abs() < 1e-12);
        for i in 0..=j {
            let dot: f64 = modes.shape(0, i).iter().zip(modes.shape(0, j)).map(|(a, b)| a * b).sum();
            assert!((dot - if i == j { 1.0 } else { 0.0 }).abs() < 1e-12, "{i} {j} {dot}");
        }
    }
}

/// The same with a mirror that exchanges the chains: each half holds every value once.
#[test]
fn halves_with_equal_values_are_merged() {
    let n = 12;
    let one = chain(n, true);
    let twice = |entries: &[AffineEntry]| {
        let shifted = entries.iter().map(|e| AffineEntry { row: e.row + n, col: e.col + n, ..*e });
        entries.iter().copied().chain(shifted).collect::<Vec<_>>()
    };
    let pencil = AffinePencil { n: 2 * n, n_parameters: 2, stiffness: twice(&one.stiffness), mass: twice(&one.mass) };
    let mirror = Mirror { permutation: (0..2 * n).map(|i| (i + n) % (2 * n)).collect(), signs: vec![1.0; 2 * n] };
    assert_eq!(detect_mirror(&pencil, &mirror), Ok(true));
    // An odd number of modes cuts a pair: either partner is right.
    let options = BatchOptions { mirror: Some(mirror), ..options(5, 2 * n, false) };
    let model = BatchModel::new(pencil, &[1.0, 1.0], options).unwrap();
    let mut workspace = Workspace::new(&model, 1);
    let modes = model.solve(&[&[1.0, 1.0]], &mut workspace).unwrap();
    assert_eq!(modes.outcome(0), &Outcome::Batch);
    for j in 0..5 {
        let exact = 4.0 * ((j / 2 + 1) as f64 * std::f64::consts::PI / (2.0 * (n + 1) as f64)).sin().powi(2);
        assert!((modes.values(0)[j] / exact - 1.0).abs() < 1e-12);
    }
}

/// All wanted modes in one family: the halves have no fixed share.
#[test]
fn one_half_may_hold_all_modes() {
    let (whole, data) = wing_model(5, false);
    let mut pencil = pencil_of(&data);
    // Springs between left and right wing nodes that resist antisymmetric motion only; no longer free in roll.
    for node in 4..9 {
        for (dof, partner) in [(0, -1.0), (1, 1.0), (2, -1.0)] {
            let (left, right) = (3 * node + dof, 3 * (node + 5) + dof);
            for (row, col, sign) in [(left, left, 1.0), (right, right, 1.0), (right, left, partner)] {
                pencil.stiffness.push(AffineEntry { row, col, parameter: None, coefficient: 1e7 * sign });
            }
        }
    }
    for node in 0..4 {
        let (row, col) = (3 * node + 1, 3 * node + 1);
        pencil.stiffness.push(AffineEntry { row, col, parameter: None, coefficient: 1e7 });
    }
    let options = BatchOptions {
        n_modes: 5,
        rigid: DMatrix::from_fn(data.n, 2, |i, j| data.rigid[2 * j][i]),
        mirror: Some(mirror_of(&data)),
        sensors: None,
        references: None,
        shapes: true,
    };
    let model = BatchModel::new(pencil, &grillage::nominal(&data), options).unwrap();
    assert_eq!(whole.n_modes(), 9);
    let thetas = grillage::candidates(&data, 8, 2);
    let mut workspace = Workspace::new(&model, 8);
    let modes = model.solve(&slices(&thetas), &mut workspace).unwrap();
    assert_eq!(modes.n_redone(), 0);
    for (c, theta) in thetas.iter().enumerate() {
        let (values, _) = model.reference(theta).unwrap();
        for j in 0..5 {
            let lambda = modes.values(c)[j];
            assert!((lambda / values[j] - 1.0).abs() < 2e-9, "{c} {j}: {lambda} {}", values[j]);
            let shape = modes.shape(c, j);
            let largest = shape.iter().fold(0.0_f64, |a, x| a.max(x.abs()));
            assert!((4..9).all(|node| (shape[3 * node] - shape[3 * (node + 5)]).abs() < 1e-6 * largest));
        }
    }
}

#[test]
fn massless_dofs_need_no_special_case() {
    let n = 10;
    let mut pencil = chain(n, true);
    pencil.mass.retain(|e| e.row % 2 == 0);
    let model = BatchModel::new(pencil, &[1.0, 1.0], options(4, n, false)).unwrap();
    let mut workspace = Workspace::new(&model, 1);
    let modes = model.solve(&[&[2.0, 1.0]], &mut workspace).unwrap();
    assert_eq!(modes.outcome(0), &Outcome::Batch);
    let (values, _) = model.reference(&[2.0, 1.0]).unwrap();
    for (a, b) in modes.values(0).iter().zip(&values) {
        assert!((a / b - 1.0).abs() < 1e-12);
    }
}

#[test]
fn a_negative_mass_is_refused() {
    let n = 6;
    let mut pencil = chain(n, false);
    pencil.n_parameters = 3;
    pencil.mass.push(AffineEntry { row: 2, col: 2, parameter: Some(2), coefficient: 1.0 });
    let model = BatchModel::new(pencil, &[1.0, 1.0, 0.0], options(2, n, true)).unwrap();
    let mut workspace = Workspace::new(&model, 2);
    let modes = model.solve(&[&[1.0, 1.0, -1.5], &[1.0, 1.0, -1.0]], &mut workspace).unwrap();
    assert!(matches!(modes.outcome(0), Outcome::NotSolvable { cause: Cause::Mass, reason: None }));
    assert_eq!(modes.outcome(1), &Outcome::Batch);
}

#[test]
fn sensors_see_the_full_shapes() {
    let (full, data) = wing_model(5, true);
    let sensors = DMatrix::from_fn(4, data.n, |s, d| match (s, d) {
        (0, 24) | (1, 39) => 1.0,
        (2, 24) | (3, 12) => 0.5,
        (2, 25) | (3, 41) => -0.25,
        _ => 0.0,
    });
    let options = BatchOptions {
        n_modes: 9,
        rigid: DMatrix::from_fn(data.n, 3, |i, j| data.rigid[j][i]),
        mirror: Some(mirror_of(&data)),
        sensors: Some(sensors.clone()),
        references: None,
        shapes: true,
    };
    let model = BatchModel::new(pencil_of(&data), &grillage::nominal(&data), options).unwrap();
    let thetas = grillage::candidates(&data, 3, 1);
    let (mut w1, mut w2) = (Workspace::new(&full, 3), Workspace::new(&model, 3));
    let (a, b) = (full.solve(&slices(&thetas), &mut w1).unwrap(), model.solve(&slices(&thetas), &mut w2).unwrap());
    for c in 0..3 {
        for j in 0..9 {
            let seen = &sensors * DMatrix::from_column_slice(data.n, 1, a.shape(c, j));
            for s in 0..4 {
                assert!((seen[s] - b.shape(c, j)[s]).abs() < 1e-13);
            }
        }
    }
    assert_eq!(model.solve(&slices(&thetas), &mut w1).err(), Some(BatchError::ForeignWorkspace));
}

/// Products with references, formed in the lanes and on the reference path, are those of the shapes.
#[test]
fn products_are_those_of_the_shapes() {
    let (full, data) = wing_model(5, true);
    let references = DMatrix::from_fn(data.n, 5, |i, r| ((3 * i + 7 * r) as f64).sin());
    let options = BatchOptions {
        n_modes: 9,
        rigid: DMatrix::from_fn(data.n, 3, |i, j| data.rigid[j][i]),
        mirror: Some(mirror_of(&data)),
        sensors: None,
        references: Some(references.clone()),
        shapes: false,
    };
    let model = BatchModel::new(pencil_of(&data), &grillage::nominal(&data), options).unwrap();
    let thetas = grillage::candidates(&data, 11, 1);
    let (mut w1, mut w2) = (Workspace::new(&full, 11), Workspace::new(&model, 11));
    let a = full.solve(&slices(&thetas), &mut w1).unwrap();
    let mut b = model.solve(&slices(&thetas), &mut w2).unwrap().clone();
    model.solve_alone(&thetas[10], Cause::Residual, 10, &mut b);
    for c in 0..11 {
        for j in 0..9 {
            assert!(b.shape(c, j).is_empty() && a.products(c, j).is_empty());
            let shape = crate::DVector::from_column_slice(a.shape(c, j));
            let size = shape.norm() * references.norm();
            let products = b.products(c, j);
            assert_eq!(products.len(), 6);
            // A shape may have either sign on the two paths.
            let sign = (references.column(0).dot(&shape) * products[0]).signum();
            for r in 0..5 {
                let error = references.column(r).dot(&shape) - sign * products[r];
                assert!(error.abs() < if c == 10 { 1e-9 } else { 1e-13 } * size, "{c} {j} {r}: {error:e}");
            }
            assert!((products[5] / shape.norm_squared() - 1.0).abs() < 1e-9);
        }
    }
}

#[test]
fn an_asymmetric_model_has_no_mirror() {
    let data = grillage::grillage(3);
    let mut pencil = pencil_of(&data);
    assert_eq!(detect_mirror(&pencil, &mirror_of(&data)), Ok(true));
    pencil.mass.push(AffineEntry { row: 15, col: 15, parameter: Some(3), coefficient: 1e-6 });
    assert_eq!(detect_mirror(&pencil, &mirror_of(&data)), Ok(false));
    let options = BatchOptions { mirror: Some(mirror_of(&data)), ..options(3, data.n, false) };
    assert_eq!(BatchModel::new(pencil, &grillage::nominal(&data), options).err(), Some(BatchError::NotSymmetric));
    let mut broken = mirror_of(&data);
    broken.permutation.swap(15, 16);
    assert_eq!(detect_mirror(&pencil_of(&data), &broken), Err(BatchError::MirrorNotInvolution { dof: 15 }));
}

#[test]
fn wrong_input_is_refused_with_its_reason() {
    let new = |pencil, options| BatchModel::new(pencil, &[1.0, 1.0], options).err().map(|e| e.to_string()).unwrap();
    let entry = AffineEntry { row: 1, col: 2, parameter: None, coefficient: 1.0 };
    let with = |entry| {
        let mut pencil = chain(4, true);
        pencil.stiffness.push(entry);
        pencil
    };
    assert!(new(with(entry), options(2, 4, false)).contains("(1, 2) is outside the lower triangle"));
    let entry = AffineEntry { row: 2, parameter: Some(9), col: 1, ..entry };
    assert!(new(with(entry), options(2, 4, false)).contains("parameter 9"));
    let entry = AffineEntry { parameter: None, coefficient: f64::NAN, ..entry };
    assert!(new(with(entry), options(2, 4, false)).contains("not finite"));
    let large = AffinePencil { n: 1_000_000_000_000, ..chain(4, true) };
    assert!(new(large, options(2, 4, false)).contains("at most 1000"));
    assert!(new(chain(4, true), options(2, 4, true)).contains("not free of force"));
    assert!(new(chain(4, false), options(2, 4, false)).contains("without strain energy"));
    assert!(new(chain(4, false), options(4, 4, true)).contains("4 elastic modes are asked for"));
    let twice = BatchOptions { rigid: DMatrix::from_element(4, 2, 1.0), ..options(2, 4, true) };
    assert!(new(chain(4, false), twice).contains("only 1 of them are independent"));
    let model = BatchModel::new(chain(4, true), &[1.0, 1.0], options(2, 4, false)).unwrap();
    let mut workspace = Workspace::new(&model, 1);
    let error = model.solve(&[&[1.0]], &mut workspace).err().unwrap();
    assert_eq!(error.to_string(), "values of a candidate: 1 given, 2 expected");
}
