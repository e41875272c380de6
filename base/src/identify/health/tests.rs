//! Injected faults are found; healthy tests stay quiet.

use super::*;
use crate::data::{FrfQuantity, FrfSet};
use crate::identify::tests::synthetic::{TrueMode, add_noise, lines, normal_pair, synthesise};
use crate::identify::tests::wing::{data_folder, read_csv, wing_frfs};
use crate::identify::{IdentifyOptions, identify};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use retune_linalg::{Complex, DMatrix, DVector};

fn has(findings: &[Finding], code: &str, subject: &str) -> bool {
    findings.iter().any(|f| f.code == code && f.subject == subject)
}

fn only_info(findings: &[Finding]) -> bool {
    findings.iter().all(|f| f.level == Level::Info)
}

/// A plate-like grid: (columns x rows) sensors along z, six smooth modes of bending and torsion of a free wing.
fn grid(columns: usize, rows: usize) -> (Vec<SensorGeometry>, DMatrix<f64>) {
    let mut sensors = Vec::new();
    let mut data = Vec::new();
    for i in 0..columns {
        for j in 0..rows {
            let (x, y) = (i as f64 / (columns - 1) as f64, 0.15 * j as f64 / (rows - 1) as f64);
            let position = [x, y + 0.2 * x, 0.0];
            sensors.push(SensorGeometry {
                name: format!("s{}", sensors.len() + 1),
                position,
                direction: [0.0, 0.0, 1.0],
            });
            let (pi, eta) = (std::f64::consts::PI, (y - 0.075) / 0.15);
            data.push([
                x * x * (3.0 - x),
                (1.5 * pi * x).sin() - 1.2 * x,
                eta * (0.5 * pi * x).sin() + 0.05 * x,
                (2.5 * pi * x).sin() - 0.3 * x,
                eta * (1.5 * pi * x).sin(),
                (pi * x).cos() - 0.2 * eta,
            ]);
        }
    }
    let shapes = DMatrix::from_fn(data.len(), 6, |k, m| data[k][m]);
    (sensors, shapes)
}

fn noisy(shapes: &DMatrix<f64>, eps: f64, seed: u64) -> DMatrix<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let rms = (shapes.norm_squared() / shapes.len() as f64).sqrt();
    shapes.map(|x| x + eps * rms * normal_pair(&mut rng).re)
}

#[test]
fn a_healthy_grid_stays_quiet() {
    let (sensors, shapes) = grid(9, 3);
    let mut alarms = 0;
    for seed in 0..100 {
        let eps = [0.0, 0.01, 0.03, 0.1][seed as usize % 4];
        let found = check_geometry(&sensors, &noisy(&shapes, eps, seed)).unwrap();
        if !only_info(&found) {
            alarms += 1;
            eprintln!("{eps} {seed}: {:?}", found.iter().filter(|f| f.level > Level::Info).collect::<Vec<_>>());
        }
    }
    eprintln!("false alarms {alarms} of 100");
    assert!(alarms <= 2);
}

#[test]
fn sign_swap_and_gain_are_found_by_smoothness() {
    let (sensors, shapes) = grid(9, 3);
    let (mut count, mut found) = ([0; 3], [0; 3]);
    let mut wrong = 0;
    for k in 0..27 {
        let clean = noisy(&shapes, 0.02, 500 + k as u64);
        let mut flipped = clean.clone();
        flipped.row_mut(k).neg_mut();
        let mut swapped = clean.clone();
        let other = (k + 10) % 27;
        swapped.swap_rows(k, other);
        let mut scaled = clean.clone();
        scaled.row_mut(k).scale_mut(10.0);
        let pair = format!("s{} / s{}", k.min(other) + 1, k.max(other) + 1);
        let cases = [
            ("sensor-sign", format!("s{}", k + 1), flipped),
            ("sensor-swap", pair, swapped),
            ("sensor-gain", format!("s{}", k + 1), scaled),
        ];
        for (c, (code, subject, data)) in cases.into_iter().enumerate() {
            let findings = check_geometry(&sensors, &data).unwrap();
            count[c] += 1;
            found[c] += usize::from(has(&findings, code, &subject));
            if !has(&findings, code, &subject) {
                eprintln!(
                    "{code} {subject}: {:?}",
                    findings.iter().map(|f| (f.code, &f.subject, &f.evidence)).collect::<Vec<_>>()
                );
            }
            wrong +=
                findings.iter().filter(|f| f.level > Level::Info && !(f.code == code && f.subject == subject)).count();
        }
    }
    eprintln!("found {found:?} of {count:?}, wrong {wrong}");
    assert!(found[0] >= 24 && found[1] >= 24 && found[2] >= 24 && wrong <= 6);
}

#[test]
fn few_sensors_are_not_judged() {
    let (sensors, shapes) = grid(9, 3);
    let found = check_geometry(&sensors[..6], &shapes.rows(0, 6).into_owned()).unwrap();
    assert!(found.iter().any(|f| f.code == "sign-not-decidable"));
    assert!(only_info(&found));
}

#[test]
fn rigid_body_motion_shows_sign_gain_swap_and_axis() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let sensors: Vec<SensorGeometry> = (0..18)
        .map(|k| {
            let p = [normal_pair(&mut rng).re, normal_pair(&mut rng).re, 0.3 * normal_pair(&mut rng).re];
            SensorGeometry { name: format!("s{}", k + 1), position: p, direction: axes[k % 3] }
        })
        .collect();
    let motion = DMatrix::from_fn(6, 6, |_, _| normal_pair(&mut rng).re);
    let read = |k: usize, d: [f64; 3]| {
        let p = sensors[k].position;
        let row = [d[0], d[1], d[2], p[1] * d[2] - p[2] * d[1], p[2] * d[0] - p[0] * d[2], p[0] * d[1] - p[1] * d[0]];
        (0..6).map(|m| (0..6).map(|c| row[c] * motion[(c, m)]).sum::<f64>()).collect::<Vec<_>>()
    };
    let shapes = DMatrix::from_fn(18, 6, |k, m| read(k, sensors[k].direction)[m]);
    let mut alarms = 0;
    for seed in 0..50 {
        alarms += usize::from(!only_info(&check_rigid_body(&sensors, &noisy(&shapes, 0.03, seed)).unwrap()));
    }
    assert!(alarms <= 1, "{alarms} false alarms of 50");
    let mut data = noisy(&shapes, 0.03, 99);
    data.row_mut(4).neg_mut();
    assert!(has(&check_rigid_body(&sensors, &data).unwrap(), "sensor-sign", "s5"));
    let mut data = noisy(&shapes, 0.03, 99);
    data.swap_rows(2, 11);
    assert!(has(&check_rigid_body(&sensors, &data).unwrap(), "sensor-swap", "s3 / s12"));
    let mut data = noisy(&shapes, 0.03, 99);
    data.row_mut(7).scale_mut(9.81);
    assert!(has(&check_rigid_body(&sensors, &data).unwrap(), "sensor-gain", "s8"));
    let mut data = noisy(&shapes, 0.03, 99);
    for (m, x) in read(9, [0.0, 1.0, 0.0]).into_iter().enumerate() {
        data[(9, m)] = x;
    }
    assert!(
        has(&check_rigid_body(&sensors, &data).unwrap(), "sensor-axis", "s10"),
        "{:?}",
        check_rigid_body(&sensors, &data)
    );
}

/// Four modes of a string of eight points; references at the given points.
fn string_test(references: &[usize], noise: f64, seed: u64) -> FrfSet {
    let modes: Vec<TrueMode> = [(12.0, 0.01), (24.0, 0.012), (37.0, 0.008), (51.0, 0.01)]
        .iter()
        .enumerate()
        .map(|(k, &(f, z))| {
            let phi = super::super::tests::synthetic::string_shape(k + 1, 8);
            TrueMode::real(f, z, &phi, &references.iter().map(|&p| phi[p]).collect::<Vec<_>>())
        })
        .collect();
    let mut frfs = synthesise(&modes, FrfQuantity::Accelerance, &lines(0.0, 64.0, 1025));
    for (i, &p) in references.iter().enumerate() {
        frfs.references[i].name = format!("p{}", p + 1);
    }
    add_noise(&mut frfs, noise, seed);
    frfs
}

fn scale(frfs: &mut FrfSet, reference: Option<usize>, response: usize, factor: f64) {
    for l in 0..frfs.n_lines() {
        for i in 0..frfs.references.len() {
            if reference.is_none_or(|r| r == i) {
                let at = frfs.index(l, i, response);
                frfs.h[at] *= factor;
            }
        }
    }
}

#[test]
fn healthy_functions_stay_quiet() {
    for seed in 0..5 {
        let frfs = string_test(&[1, 5], [0.0, 0.01, 0.03, 0.05, 0.1][seed as usize], seed);
        let findings = check_functions(&frfs).unwrap();
        assert!(findings.is_empty(), "{findings:?}");
        let findings = check_modes(&frfs, &identify(&frfs, &IdentifyOptions::default()).unwrap());
        assert!(only_info(&findings), "{findings:?}");
    }
}

#[test]
fn a_reversed_force_is_found() {
    let mut frfs = string_test(&[1], 0.02, 7);
    for h in &mut frfs.h {
        *h = -*h;
    }
    assert!(has(&check_functions(&frfs).unwrap(), "driving-point-reversed", "p2"));
    let found = identify(&frfs, &IdentifyOptions::default()).unwrap();
    assert!(has(&check_modes(&frfs, &found), "driving-point-reversed", "p2"));
    assert!(found.modes.iter().all(|m| m.mass_normalised.is_none()));
}

/// What a wrong phase, quantity or clock makes of a driving point is told from a reversed force; each by its own word, over noise of 0.5 to 5 %.
#[test]
fn causes_of_a_driving_point_are_told_apart() {
    let edit = |kind: usize, frfs: &mut FrfSet| {
        for l in 0..frfs.n_lines() {
            let s = Complex::new(0.0, std::f64::consts::TAU * frfs.frequencies_hz[l]);
            for o in 0..frfs.responses.len() {
                let at = frfs.index(l, 0, o);
                frfs.h[at] = match kind {
                    0 => -frfs.h[at],
                    1 => frfs.h[at].conj(),
                    2 if l > 0 => frfs.h[at] / s,
                    3 if l > 0 => frfs.h[at] / (s * s),
                    4 => frfs.h[at] * Complex::from_polar(1.0, -s.im * 4e-3),
                    _ => frfs.h[at],
                };
            }
        }
    };
    let expected = [
        "driving-point-reversed",
        "driving-point-conjugate",
        "driving-point-quantity",
        "driving-point-quantity",
        "driving-point-delay",
    ];
    let mut missed = Vec::new();
    for (kind, code) in expected.iter().enumerate() {
        for (seed, noise) in [0.005, 0.02, 0.05].into_iter().enumerate() {
            let mut frfs = string_test(&[1], noise, 70 + seed as u64);
            edit(kind, &mut frfs);
            let found = check_functions(&frfs).unwrap();
            let driving: Vec<&str> =
                found.iter().filter(|f| f.code.starts_with("driving-point")).map(|f| f.code).collect();
            if driving != [*code] {
                missed.push((kind, noise, found.clone()));
            }
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
    // The modes of a set that is not what it says name the same cause.
    let mut frfs = string_test(&[1], 0.01, 75);
    edit(2, &mut frfs);
    let modes = identify(&frfs, &IdentifyOptions::default()).unwrap();
    let all = check_test(&frfs, Some(&modes), None, HealthOptions::default()).unwrap();
    let driving: Vec<&str> = all.iter().filter(|f| f.code.starts_with("driving-point")).map(|f| f.code).collect();
    assert_eq!(driving, ["driving-point-quantity"], "{all:#?}");
}

#[test]
fn a_wrong_driving_point_is_found_with_the_right_one() {
    let mut frfs = string_test(&[1], 0.02, 8);
    frfs.references[0].name = "p6".to_owned();
    let found = check_modes(&frfs, &identify(&frfs, &IdentifyOptions::default()).unwrap());
    let finding = found.iter().find(|f| f.code == "driving-point-sign").unwrap();
    assert!(finding.text.contains("p2 (4 modes)"), "{}", finding.text);
    assert!(check_functions(&frfs).unwrap().iter().any(|f| f.code == "driving-point-not-passive"));
}

#[test]
fn a_missing_reciprocity_is_found() {
    let mut frfs = string_test(&[1, 5], 0.01, 9);
    scale(&mut frfs, Some(0), 5, -1.0);
    assert!(check_functions(&frfs).unwrap().iter().any(|f| f.code == "reciprocity-sign"));
    let mut frfs = string_test(&[1, 5], 0.01, 9);
    scale(&mut frfs, Some(1), 1, 1.5);
    let finding = check_functions(&frfs).unwrap().into_iter().find(|f| f.code == "reciprocity").unwrap();
    // |1.5 - 1| over the mean of 1.5 and 1.
    let number = |name: &str| finding.evidence.iter().find(|e| e.0 == name).unwrap().1;
    assert!((number("relative difference") - 0.4).abs() < 0.01, "{finding:?}");
    assert!((number("ratio") - 1.5).abs() < 0.02, "{finding:?}");
    assert!(finding.text.contains("40 % of their mean") && finding.text.contains("1.5"), "{}", finding.text);
}

#[test]
fn dead_and_noisy_channels_are_found() {
    let mut frfs = string_test(&[1], 0.01, 10);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for l in 0..frfs.n_lines() {
        let (dead, loud) = (frfs.index(l, 0, 3), frfs.index(l, 0, 6));
        frfs.h[dead] = normal_pair(&mut rng) * 1e-3;
        frfs.h[loud] += normal_pair(&mut rng) * 1.0;
    }
    let findings = check_modes(&frfs, &identify(&frfs, &IdentifyOptions::default()).unwrap());
    assert!(has(&findings, "sensor-dead", "p4"), "{findings:?}");
    assert!(has(&findings, "sensor-noisy", "p7"), "{findings:?}");
}

#[test]
fn mass_loading_and_drift_are_told_apart() {
    let first = identify(&string_test(&[1], 0.01, 11), &IdentifyOptions::default()).unwrap().modes;
    let names: Vec<String> = (0..8).map(|k| format!("p{}", k + 1)).collect();
    assert!(
        compare_runs(
            &first,
            &identify(&string_test(&[1], 0.01, 12), &IdentifyOptions::default()).unwrap().modes,
            &names
        )
        .is_empty()
    );
    let mut warm = first.clone();
    let mut loaded = first.clone();
    for m in &mut warm {
        m.frequency_hz.value *= 0.995;
    }
    for m in &mut loaded {
        let phi = m.mass_normalised.as_ref().unwrap().shape[2];
        m.frequency_hz.value *= 1.0 - 0.5 * 0.02 * phi * phi;
    }
    assert!(has(&compare_runs(&first, &warm, &names), "frequency-drift", "all modes"));
    let found = compare_runs(&first, &loaded, &names);
    assert!(has(&found, "mass-loading", "p3"), "{found:?}");
}

#[test]
fn a_stiff_suspension_is_a_finding() {
    assert!(check_suspension(&[0.39, 0.85], &[5.67, 8.37]).iter().all(|f| f.level == Level::Info));
    assert_eq!(check_suspension(&[1.5], &[5.67])[0].level, Level::Warning);
    assert!(check_suspension(&[0.5], &[5.67]).is_empty());
}

#[test]
fn one_mode_that_moved_between_two_runs_is_found() {
    let mut frfs = string_test(&[1], 0.01, 13);
    let shifted = {
        let mut modes = string_test(&[1], 0.01, 14);
        modes.frequencies_hz = modes.frequencies_hz.iter().map(|f| f * 0.96).collect();
        modes
    };
    // The second half of the channels was measured when the structure was 4 % softer.
    for l in 0..frfs.n_lines() {
        for o in 4..8 {
            let f = frfs.frequencies_hz[l];
            let k = shifted.frequencies_hz.partition_point(|x| *x < f).min(frfs.n_lines() - 1);
            let at = frfs.index(l, 0, o);
            frfs.h[at] = shifted.at(k, 0, o);
        }
    }
    let found = identify(&frfs, &IdentifyOptions::default()).unwrap();
    let findings = check_modes(&frfs, &found);
    assert!(findings.iter().any(|f| f.code == "split-mode"), "{findings:?}");
}

/// The wing's own driving point, point 1, cannot be one: see the notes beside the data.
#[test]
fn the_wing_was_not_driven_at_point_1() {
    let Some(frfs) = wing_frfs() else { return };
    let options = IdentifyOptions { band_hz: Some((5.0, 750.0)), ..IdentifyOptions::default() };
    let findings = check_modes(&frfs, &identify(&frfs, &options).unwrap());
    let finding = findings.iter().find(|f| f.code == "driving-point-sign").unwrap();
    assert_eq!((finding.subject.as_str(), finding.level), ("1", Level::Fault));
    assert!(check_functions(&frfs).unwrap().iter().any(|f| f.code == "driving-point-not-passive"));
}

/// Geri's point 10 reads nothing in three of four shapes.
#[test]
fn the_dead_point_of_a_flying_wing_is_found() {
    let Some(folder) = data_folder("maewing1_geri") else { return };
    let rows = read_csv(&folder.join("gvt_points_and_shapes.csv"));
    let inch = 0.0254;
    let sensors: Vec<SensorGeometry> = rows
        .iter()
        .map(|r| SensorGeometry {
            name: format!("{}", r[0]),
            position: [r[1] * inch, r[2] * inch, 0.0],
            direction: [0.0, 0.0, 1.0],
        })
        .collect();
    let shapes = DMatrix::from_fn(rows.len(), 4, |k, m| rows[k][3 + m]);
    let findings = check_geometry(&sensors, &shapes).unwrap();
    assert!(has(&findings, "sensor-dead", "10"));
    assert_eq!(findings.iter().filter(|f| f.code == "sensor-dead").count(), 1);
}

#[test]
fn hostile_shapes_do_not_panic() {
    let (sensors, shapes) = grid(4, 3);
    for value in [f64::NAN, f64::INFINITY, 0.0, 1e300] {
        let bad = shapes.map(|_| value);
        let _ = check_geometry(&sensors, &bad).unwrap();
        let _ = check_rigid_body(&sensors, &bad).unwrap();
    }
    let same: Vec<SensorGeometry> =
        sensors.iter().map(|s| SensorGeometry { position: [0.0; 3], ..s.clone() }).collect();
    let _ = check_geometry(&same, &shapes).unwrap();
    let _ = check_rigid_body(&same, &shapes).unwrap();
    assert!(check_geometry(&sensors[..3], &shapes).is_err());
}

/// Two planes of one shaft: the second mode is seen by other channels because it moves in another direction.
#[test]
fn modes_in_perpendicular_directions_are_no_split_mode() {
    let shape = |in_x: f64, in_y: f64| {
        let value = |i: usize| [in_x, in_y][i / 4] * (0.3 + i as f64 % 4.0);
        DVector::from_fn(8, |i, _| Complex::new(value(i), 0.0))
    };
    let (a, b) = (shape(1.0, 0.05), shape(-0.04, 1.0));
    let of = |hz: f64, shape| super::modes::Shape { hz, zeta: 0.01, shape };
    let modes = [of(40.0, &a), of(40.9, &b)];
    let along = |x: [f64; 3], y: [f64; 3]| (0..8).map(|i| Some([x, y][i / 4])).collect::<Vec<_>>();
    let perpendicular = along([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    assert!(super::modes::pairs(&modes, &perpendicular).is_empty());
    let parallel = along([1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]);
    assert_eq!(super::modes::pairs(&modes, &parallel)[0].code, "split-mode");
    assert_eq!(super::modes::pairs(&modes, &[None; 8])[0].code, "split-mode");
}

/// A channel whose cable was off in some modes is found, and a healthy one near a node is not.
#[test]
fn a_channel_that_reads_nothing_in_some_modes_is_found() {
    use crate::data::{Measured, Origin, Place, Standing, TestMode};
    let sensors: Vec<crate::data::Sensor> = (0..12)
        .map(|i| crate::data::Sensor {
            name: format!("p{i}"),
            place: Place::Node { node: format!("n{i}"), position: None },
            offset: None,
            direction: [0.0, 0.0, 1.0],
            is_rotation: false,
            mass: None,
        })
        .collect();
    let mode = |k: usize, origin: Origin| TestMode {
        label: None,
        frequency_hz: Measured { value: 10.0 * k as f64, sd: 0.1, sd_is_default: false },
        damping_ratio: None,
        origin: origin.clone(),
        shape: Some(DVector::from_fn(12, |i, _| {
            Complex::new((0.3 * k as f64 * (i + 1) as f64).sin() + 0.02 * ((7 * i + 3 * k) as f64).sin(), 0.0)
        })),
        shape_sd: Some(DVector::from_element(12, 0.02)),
        shape_origin: Some(origin),
        components: Vec::new(),
        standing: Standing::Open,
        space: None,
    };
    let all = |origin: &Origin| (1..5).map(|k| mode(k, origin.clone())).collect::<Vec<_>>();
    let measured = Origin::Measured("a test".into());
    let mut modes = all(&measured);
    assert!(check_silent(&sensors, &modes).is_empty());
    for m in [1, 3] {
        modes[m].shape.as_mut().unwrap()[5] = Complex::new(1e-5, 0.0);
    }
    let found = check_silent(&sensors, &modes);
    assert!(has(&found, "silent-in-modes", "p5") && found.len() == 1, "{found:?}");
    // Computed shapes are exactly zero where symmetry says so.
    let mut computed = all(&Origin::Synthetic("a model".into()));
    for m in [1, 3] {
        computed[m].shape.as_mut().unwrap()[5] = Complex::new(0.0, 0.0);
    }
    assert!(check_silent(&sensors, &computed).is_empty());
}
