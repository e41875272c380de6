//! Worked examples that others have published, with their numbers: reports, textbooks' models and the tests of other codes.
//!
//! No table of FRAC or of the enhanced COMAC with its input could be found; these stand against hand-computed cases and, FRAC,
//! against `sdynpy` on the same numbers (`src/correlation/`).

use retune::correlation::{comac, frac, mac_matrix, signatures, weighted_mac_matrix};
use retune::data::{Channel, FrfQuantity, FrfSet};
use retune::element::Dof;
use retune::linalg::{Complex, DMatrix, DVector, lowest_modes};
use retune::modal::SolveOptions;
use retune::modal::reduction::{Reduction, guyan, irs, selection, serep};
use retune::model::{Model, ParametricModel, Registry, load, solve_modes};
use std::f64::consts::TAU;

/// Dofs theta_m, theta_c, theta_s, theta_sb, x_s, x_n of a ball-screw drive in six modes of one model and six of another: reports
/// "Co-MAC" of a public repository (`comac_mode_extraction.md`, `comac_corrected_report.md`), five digits.
#[rustfmt::skip]
const SCREW_A: [f64; 36] = [
    577.47,    -45.000,  871.95,     123.73,   -0.73050, -3.1859,
    598.39,    -34.415, -309.57,    -621.79,   15.360,   74.209,
    601.09,    -26.738, -508.42,     749.76, -124.27,  -672.37,
    601.61,    -27.162, -550.49,    1119.1,   624.55,  2087.7,
    4.4415e-3,  1.3330,   8.4478e-2,  -0.13429, 3.2621,  -0.86556,
    0.10061,    1.4585,   6.3072e-3, 0.016992, -0.55609,  0.14890,
];
#[rustfmt::skip]
const SCREW_B: [f64; 36] = [
    3.3494,  829.10,     648.65,      14.552,   -52.250,     -0.13224,
    3.2595,  518.25,    -627.40,     -18.510,   429.91,       8.2709,
    3.1199,  322.36,    -501.87,     -10.903, -1117.4,     -213.70,
    0.92705,  96.329,   -153.95,      -3.3614, -389.92,    2545.9,
    0.24222,  -1.0809e-2,  9.3125e-2, -3.6229,   -8.8830e-3, -1.9189e-4,
    1.5678,   -7.7436e-3, -4.4371e-4,  0.10483,   1.3133e-3,  3.4816e-5,
];

fn assert_near(values: impl IntoIterator<Item = f64>, published: &[f64], tolerance: f64) {
    let values: Vec<f64> = values.into_iter().collect();
    assert_eq!(values.len(), published.len());
    for (value, published) in values.iter().zip(published) {
        assert!((value - published).abs() <= tolerance, "{value} against {published}");
    }
}

/// Their pairs 1-2, 2-1, 3-3, 4-5, 5-4, 6-6; COMAC by moduli to six digits from five-digit shapes.
#[test]
fn comac_of_a_ball_screw_drive() {
    let a = DMatrix::from_row_slice(6, 6, &SCREW_A);
    let b = DMatrix::from_row_slice(6, 6, &SCREW_B).select_columns(&[1, 0, 2, 4, 3, 5]);
    let values = comac(&a, &b).into_iter().flatten();
    assert_near(values, &[0.894724, 0.831276, 0.752878, 0.782228, 0.848225, 0.902601], 5e-5);
}

/// The same shapes with rotations times a length: MAC to four digits.
#[test]
fn mac_of_a_ball_screw_drive() {
    let scaled = |values: &[f64]| {
        let mut shapes = DMatrix::from_row_slice(6, 6, values);
        shapes.rows_mut(0, 4).scale_mut(1.591549430919e-4);
        shapes
    };
    let mac = mac_matrix(&scaled(&SCREW_A), &scaled(&SCREW_B));
    #[rustfmt::skip]
    let published = [
        0.2184, 0.5201, 0.0557, 0.0001, 0.1580, 0.1674,
        0.6930, 0.0070, 0.1081, 0.4264, 0.0005, 0.0000,
        0.0085, 0.0517, 0.8162, 0.1641, 0.1221, 0.1513,
        0.0002, 0.0105, 0.0778, 0.2438, 0.4809, 0.3757,
        0.0002, 0.0031, 0.2307, 0.9796, 0.0023, 0.0009,
        0.0003, 0.0031, 0.2049, 0.8463, 0.0014, 0.1298,
    ];
    assert_near(mac.transpose().iter().copied(), &published, 7e-5);
}

/// Their MAC weighted with the mass. The report prints no mass; the sums of squares that it prints give this diagonal.
#[test]
fn mass_weighted_mac_of_a_ball_screw_drive() {
    let (a, b) = (DMatrix::from_row_slice(6, 6, &SCREW_A), DMatrix::from_row_slice(6, 6, &SCREW_B));
    let inverse = [1.111111e6, 8.474576e5, 1.650165e6, 6.666667e6, 13.19261, 2.469136];
    let mass = DMatrix::from_diagonal(&DVector::from_iterator(6, inverse.iter().map(|v| 1.0 / v)));
    #[rustfmt::skip]
    let published = [
        0.0048, 0.8513, 0.0916, 0.0000, 0.0275, 0.0249,
        0.9030, 0.0043, 0.0003, 0.0923, 0.0000, 0.0001,
        0.0000, 0.1253, 0.8211, 0.0000, 0.0318, 0.0218,
        0.0001, 0.0157, 0.0771, 0.0022, 0.7998, 0.1051,
        0.0860, 0.0001, 0.0012, 0.8450, 0.0028, 0.0649,
        0.0061, 0.0034, 0.0087, 0.0604, 0.1381, 0.7833,
    ];
    let mac = weighted_mac_matrix(&a, &b, &mass);
    assert_near(mac.transpose().iter().copied(), &published, 7e-5);
}

/// A set with one reference from functions of (line, response).
fn functions(lines: usize, responses: usize, h: impl Fn(usize, usize) -> f64) -> FrfSet {
    let channel = |s: usize| Channel { name: format!("p{s}"), direction: None };
    FrfSet {
        quantity: FrfQuantity::Receptance,
        frequencies_hz: (0..lines).map(|l| 1.0 + l as f64).collect(),
        references: vec![channel(0)],
        responses: (0..responses).map(channel).collect(),
        h: (0..lines).flat_map(|l| (0..responses).map(move |s| (l, s))).map(|(l, s)| Complex::from(h(l, s))).collect(),
        coherence: None,
        n_averages: None,
    }
}

/// `FRFComparisons.jl`, its tests of CSAC and CSF (after E. Dascotte, J. Strobbe, Updating finite element models using FRF
/// correlation functions, 1999): equal signals give 1, a sine against a cosine of 629 samples less than 5e-6. Once as responses
/// of one line, and once as lines of one response, where the formula is that of FRAC.
#[test]
fn csac_and_csf_of_a_sine_and_a_cosine() {
    let n = 629;
    let (x, y) = (|k: usize| (0.01 * k as f64).cos(), |k: usize| (0.01 * k as f64).sin());
    let (cosines, sines) = (functions(1, n, |_, s| x(s)), functions(1, n, |_, s| y(s)));
    let line = |a: &FrfSet, b: &FrfSet| {
        let line = &signatures(a, b).unwrap()[0];
        [line.shape.unwrap(), line.scale.unwrap()]
    };
    assert_near(line(&cosines, &cosines), &[1.0, 1.0], 1e-14);
    assert_near(line(&sines, &sines), &[1.0, 1.0], 1e-14);
    let [csac, csf] = line(&cosines, &sines);
    assert!(csac < 5e-6 && csf < 5e-6 && csf > 0.0, "{csac} {csf}");
    let (cosine, sine) = (functions(n, 1, |l, _| x(l)), functions(n, 1, |l, _| y(l)));
    assert_near(frac(&cosine, &sine).unwrap().iter().flatten().copied(), &[csac], 1e-18);
}

/// J. C. Slater, `vibrationtesting` 0.24, `test_serep`: M = 4 I, a chain of three, the lowest two modes at the first two dofs.
#[test]
fn serep_of_a_chain() {
    let m = DMatrix::identity(3, 3) * 4.0;
    let k = DMatrix::from_row_slice(3, 3, &[8.0, -4.0, 0.0, -4.0, 8.0, -4.0, 0.0, -4.0, 4.0]);
    let modes = lowest_modes(&k, &m, 2, 0.1).unwrap();
    let reduced = serep(&k, &m, &selection(3, &[0, 1]).unwrap(), &modes.vectors).unwrap();
    assert_near(reduced.mass.iter().copied(), &[16.98791841, -16.19566936, -16.19566936, 24.19566936], 5e-9);
    assert_near(reduced.stiffness.iter().copied(), &[20.98791841, -12.98791841, -12.98791841, 10.21983253], 5e-9);
    assert_near(modes.values.iter().map(|v| v.sqrt()), &[0.445042, 1.24698], 5e-6);
}

fn chain(diagonal: &[f64]) -> DMatrix<f64> {
    let n = diagonal.len();
    DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
        0 => diagonal[i],
        1 => -1.0,
        _ => 0.0,
    })
}

/// The static reductions of `ModelReduction.jl` (JuliaFEM; `test_guyan_reduction.jl`, `test_craig_bampton.jl`) and of
/// `mboct-fem-pkg` (`fem_cms_red_guyan_001`, `_002`).
#[test]
fn guyan_of_chains() {
    let unit = |k: &DMatrix<f64>, kept: &[usize]| {
        let n = k.nrows();
        guyan(k, &DMatrix::identity(n, n), &selection(n, kept).unwrap()).unwrap().stiffness
    };
    let free = unit(&chain(&[1.0, 2.0, 2.0, 2.0, 1.0]), &[0, 4]);
    assert_near(free.iter().copied(), &[0.25, -0.25, -0.25, 0.25], 1e-15);
    let third = 1.0 / 3.0;
    let held = unit(&chain(&[1.0, 2.0, 2.0, 2.0]), &[0, 3]);
    assert_near(held.iter().copied(), &[third, -third, -third, 4.0 * third], 1e-15);
    let free = unit(&chain(&[1.0, 2.0, 2.0, 1.0]), &[0, 3]);
    assert_near(free.iter().copied(), &[third, -third, -third, third], 1e-15);
    let m = DMatrix::from_diagonal(&DVector::from_row_slice(&[2.0, 2.0, 2.0, 1.0]));
    let end = guyan(&chain(&[2.0, 2.0, 2.0, 1.0]), &m, &selection(4, &[3]).unwrap()).unwrap();
    assert_near([end.stiffness[(0, 0)], end.mass[(0, 0)]], &[0.25, 2.75], 1e-14);
}

fn frequencies(k: &DMatrix<f64>, m: &DMatrix<f64>, count: usize) -> Vec<f64> {
    lowest_modes(k, m, count, 1.0).unwrap().values.iter().map(|v| v.abs().sqrt() / TAU).collect()
}

/// `welib` (NREL), `welib/FEM/tests/test_reduction.py`: one beam element of a tower of 100 m, kept at its top.
#[test]
fn guyan_of_a_tower() {
    let text = "
retune: 1
name: tower
active_dofs: [ux, ry]
nodes: {foot: [0, 0, 0], top: [0, 0, 100]}
sections: {tower: {EIy: 1868211939147.334, EIz: 1868211939147.334, mass_per_length: 8828.201296825122}}
beams: {tower: {nodes: [foot, top], section: tower}}
";
    let (model, ..) = load(text, &Registry::builtin()).unwrap();
    let system = model.assemble(&[]).unwrap();
    let top = guyan(&system.stiffness, &system.mass, &selection(4, &[2, 3]).unwrap()).unwrap();
    assert!((top.mass[(0, 0)] - 882820.12968).abs() < 1e-5, "{}", top.mass[(0, 0)]);
    // The foot follows the top as a rigid body: ux = u - 100 m times the angle about y.
    assert_near(top.transformation.row(0).iter().copied(), &[1.0, -100.0], 1e-9);
    let pinned = |a: &DMatrix<f64>| a.clone().remove_row(0).remove_column(0);
    let (k, m) = (pinned(&system.stiffness), pinned(&system.mass));
    let top = guyan(&k, &m, &selection(3, &[1, 2]).unwrap()).unwrap();
    let values = lowest_modes(&top.stiffness, &top.mass, 2, 1.0).unwrap().values;
    assert!(values[0].abs() < 1e-5 && (values[1].sqrt() / TAU - 5.304894).abs() < 5e-7, "{values}");
}

/// The acceptance report of the Python code `femtools` (`docs/ACCEPTANCE.md`, case 17): a cantilever of ten Euler-Bernoulli
/// elements, its translations kept at 0.3, 0.6 and 1 m. Mean relative error of the six lowest modes: Guyan 1.35e-2, IRS
/// 3.78e-4; the smallest excess of Guyan 1.05e-2 Hz. Its model here is a file of ours.
#[test]
fn guyan_and_irs_of_a_cantilever() {
    let text = "
retune: 1
name: cantilever
active_dofs: [uy, uz, ry, rz]
nodes: {root: [0, 0, 0], third: [300 mm, 0, 0], two_thirds: [600 mm, 0, 0], tip: [1, 0, 0]}
sections: {bar: {EIy: 2.1e3 N m2, EIz: 9.45e3 N m2, mass_per_length: 4.71 kg/m}}
beams:
  inner: {nodes: [root, third], section: bar, subdivide: 3}
  middle: {nodes: [third, two_thirds], section: bar, subdivide: 3}
  outer: {nodes: [two_thirds, tip], section: bar, subdivide: 4}
supports: {clamp: {node: root}}
";
    // E = 210 GPa, 20 x 30 mm: E b h³/12.
    let (b, h, e) = (0.02_f64, 0.03_f64, 210e9);
    let text = text
        .replace("2.1e3 N m2", &format!("{:.17e}", e * h * b.powi(3) / 12.0))
        .replace("9.45e3 N m2", &format!("{:.17e}", e * b * h.powi(3) / 12.0));
    let (model, ..) = load(&text, &Registry::builtin()).unwrap();
    let system = model.assemble(&[]).unwrap();
    let (k, m) = (&system.stiffness, &system.mass);
    let dofs = model.dof_map();
    let kept: Vec<usize> = (0..dofs.n_dof())
        .filter(|&row| {
            let (node, dof) = dofs.rows()[row];
            let x = dofs.positions()[node][0];
            [Dof::Uy, Dof::Uz].contains(&dof) && [0.3, 0.6, 1.0].iter().any(|at| (x - at).abs() < 1e-9)
        })
        .collect();
    assert_eq!((kept.len(), dofs.n_dof()), (6, 40));
    let s = selection(dofs.n_dof(), &kept).unwrap();
    let exact = frequencies(k, m, 6);
    let of = |r: Reduction| frequencies(&r.stiffness, &r.mass, 6);
    let mean = |f: &[f64]| f.iter().zip(&exact).map(|(f, e)| (f / e - 1.0).abs()).sum::<f64>() / 6.0;
    let (by_guyan, by_irs) = (of(guyan(k, m, &s).unwrap()), of(irs(k, m, &s, 1).unwrap()));
    assert!((mean(&by_guyan) - 1.35e-2).abs() < 5e-5, "{}", mean(&by_guyan));
    assert!((mean(&by_irs) - 3.78e-4).abs() < 5e-7, "{}", mean(&by_irs));
    let excess = by_guyan.iter().zip(&exact).map(|(g, e)| g - e).fold(f64::INFINITY, f64::min);
    assert!((excess - 1.05e-2).abs() < 5e-5, "{excess}");
}

/// Frequencies, Hz, of the IASC-ASCE benchmark frame without damage and with damage patterns 1 to 6, each with 12 dofs, with 120, and with 120 and
/// the unsymmetrical mass: from K and M of the task group's own generator (`cal_model`, 2000 and 2001; repository
/// `xuyuanfang/Benchmark-ASCE`), four decimals.
#[rustfmt::skip]
const ASCE: [[[f64; 6]; 3]; 7] = [
    [[9.4109, 11.7913, 16.3829, 25.5449, 32.0063, 38.6634], [8.5879, 9.1806, 14.5796, 23.4522, 25.9459, 36.8130], [8.4688, 9.0474, 14.4036, 23.1872, 25.6286, 36.4409]],
    [[6.2406, 9.9089, 11.7312, 21.5311, 28.9176, 37.3743], [5.4680, 7.3725, 9.6909, 19.3148, 22.7691, 34.1756], [5.4153, 7.2846, 9.6058, 19.0575, 22.4690, 33.7267]],
    [[5.8241, 9.5074, 11.0144, 14.8875, 24.9077, 28.4127], [4.9647, 6.6848, 8.7029, 12.3404, 17.7871, 21.5625], [4.9028, 6.5897, 8.6031, 12.2592, 17.6519, 21.4389]],
    [[8.8900, 11.7913, 16.0050, 24.6028, 32.0063, 38.2384], [8.0930, 9.1805, 14.2041, 22.4741, 25.9457, 36.2721], [7.9947, 9.0474, 14.0102, 22.2495, 25.6279, 35.8148]],
    [[8.8899, 11.6575, 15.8885, 24.5990, 31.1419, 38.2317], [8.0916, 8.9526, 14.0411, 22.4499, 24.9877, 36.2481], [7.9935, 8.8124, 13.8509, 22.2240, 24.7177, 35.7764]],
    [[8.8899, 11.6575, 15.8885, 24.5990, 31.1419, 38.2317], [8.0423, 8.9526, 14.0411, 22.4229, 24.9874, 36.2401], [7.9453, 8.8124, 13.8509, 22.1959, 24.7175, 35.7696]],
    [[9.2650, 11.7913, 16.2702, 25.2445, 32.0063, 38.5286], [8.4550, 9.1806, 14.4708, 23.1488, 25.9458, 36.6513], [8.3418, 9.0474, 14.2897, 22.8969, 25.6283, 36.2514]],
];

/// `models/asce/frame.yaml` with each damage pattern laid over it, in each configuration: all frequencies to their last digit, so within half of it.
#[test]
fn the_asce_frame_has_the_frequencies_of_its_generator() {
    let read = |file: &str| std::fs::read_to_string(format!("{}/models/{file}", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let (undamaged, warnings, _) = load(&read("asce/frame.yaml"), &Registry::builtin()).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    for (pattern, variants) in ASCE.iter().enumerate() {
        let spec = match pattern {
            0 => undamaged.spec().clone(),
            _ => undamaged.spec().overlaid(&read(&format!("asce/pattern_{pattern}.yaml"))).unwrap(),
        };
        for (variant, reference) in ["rigid_floors", "", "unsymmetrical"].iter().zip(variants) {
            let spec = if variant.is_empty() { spec.clone() } else { spec.configured(variant).unwrap() };
            let (model, _) = Model::new(spec, &Registry::builtin()).unwrap();
            assert_eq!(model.dof_map().n_dof(), if *variant == "rigid_floors" { 12 } else { 120 });
            let modes =
                solve_modes(&model, &model.parameters().nominal(), SolveOptions { n_elastic: 6, shift: None }).unwrap();
            for (i, reference) in reference.iter().enumerate() {
                let f = modes.frequency_hz(i);
                assert!((f - reference).abs() <= 5.01e-5, "pattern {pattern}, {variant}: {f} against {reference}");
            }
        }
    }
}

/// The beam of the Pazy wing by C. Riso and C. E. S. Cesnik (`models/pazy.yaml`), whose own code has 4.191, 28.493, 83.065 Hz out of plane, 41.879 Hz
/// in torsion, 105.892 Hz in plane. Bending out of plane is within 1.4 %: our file leaves the couplings of the sections out, each below 1 %.
#[test]
fn the_pazy_wing_has_the_frequencies_of_its_authors() {
    let text = std::fs::read_to_string(format!("{}/models/pazy.yaml", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let (model, ..) = load(&text, &Registry::builtin()).unwrap();
    let modes = solve_modes(&model, &model.parameters().nominal(), SolveOptions { n_elastic: 5, shift: None }).unwrap();
    let theirs = [(4.191, 1e-3), (28.493, 6e-3), (41.879, 1e-4), (83.065, 1.4e-2), (105.892, 1e-3)];
    for (i, (published, tolerance)) in theirs.into_iter().enumerate() {
        let f = modes.frequency_hz(i);
        assert!((f / published - 1.0).abs() <= tolerance, "{f} against {published}");
    }
}
