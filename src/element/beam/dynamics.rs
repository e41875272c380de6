//! Natural frequencies of chains of beam elements against closed forms and published numbers.

use super::statics::{chain, part};
use crate::linalg::{DMatrix, lowest_modes};
use std::f64::consts::PI;

type Given = Vec<(&'static str, f64)>;

/// A uniform chain of `n` elements over length `l`, the dofs of `fixed` left out: angular frequencies, rad/s.
///
/// * `active` - dofs of each node that take part, the others held
/// * `fixed` - (node, dof) that are held too
/// * `tip` - mass and rotary inertia at the last node
fn omega(
    n: usize,
    l: f64,
    given: &Given,
    active: &[usize],
    fixed: &[(usize, usize)],
    tip: [f64; 2],
    count: usize,
) -> Vec<f64> {
    let (k, mut m) = chain(&vec![l / n as f64; n], |_| given.clone());
    for d in 0..3 {
        m[(6 * n + d, 6 * n + d)] += tip[0];
        m[(6 * n + 3 + d, 6 * n + 3 + d)] += tip[1];
    }
    let keep: Vec<usize> = (0..6 * (n + 1))
        .filter(|i| active.contains(&(i % 6)) && !fixed.iter().any(|(node, dof)| 6 * node + dof == *i))
        .collect();
    let (k, m): (DMatrix<f64>, DMatrix<f64>) = (part(&k, &keep), part(&m, &keep));
    // A shift of the order of the lowest elastic eigenvalue.
    let shift = 1e-2 * given.iter().find(|(name, _)| *name == "EIz" || *name == "EIy").map_or(1.0, |(_, ei)| *ei);
    let pairs = lowest_modes(&k, &m, count, shift).unwrap();
    pairs.values.iter().map(|lambda| lambda.max(0.0).sqrt()).collect()
}

/// Root of `f` between `low` and `high`, by bisection.
fn root(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let sign = f(low).signum();
    assert!(sign != f(high).signum(), "no sign change");
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if f(middle).signum() == sign { low = middle } else { high = middle }
    }
    low
}

/// The planes: displacement and rotation dofs, and the properties with a name per plane.
struct PlaneNames {
    dofs: [usize; 2],
    ei: &'static str,
    compliance: &'static str,
    rotary: &'static str,
}

const IN_PLANE: [PlaneNames; 2] = [
    PlaneNames { dofs: [1, 5], ei: "EIz", compliance: "shear_compliance_y", rotary: "rotary_inertia_z" },
    PlaneNames { dofs: [2, 4], ei: "EIy", compliance: "shear_compliance_z", rotary: "rotary_inertia_y" },
];

const EI: f64 = 900.0;
const MU: f64 = 0.7;
const L: f64 = 1.3;

fn bernoulli(plane: &PlaneNames) -> Given {
    vec![(plane.ei, EI), ("mass_per_length", MU)]
}

/// β² √(EI/μL⁴).
fn beam_omega(beta: f64) -> f64 {
    beta * beta * (EI / (MU * L.powi(4))).sqrt()
}

/// The first three frequencies with `n` elements are above the exact ones, and the relative error falls with the power
/// `rate` of the element length from 16 to 32 elements.
fn check_rate(exact: [f64; 3], rate: f64, computed: impl Fn(usize) -> Vec<f64>) {
    let errors = |n: usize| -> Vec<f64> { computed(n).iter().zip(exact).map(|(w, exact)| w / exact - 1.0).collect() };
    let (coarse, fine) = (errors(16), errors(32));
    for mode in 0..3 {
        let measured = (coarse[mode] / fine[mode]).log2();
        // The lowest mode of 32 cubic elements is off by 8e-9, of which rounding in K (n⁴ epsilon) is a few per cent.
        assert!((measured - rate).abs() < 0.1, "mode {mode}: rate {measured}, errors {} {}", coarse[mode], fine[mode]);
        assert!(fine[mode] > 0.0 && fine[mode] < 1e-3, "mode {mode}: {}", fine[mode]);
    }
}

/// R. D. Blevins, Formulas for Natural Frequency and Mode Shape, 1979, table 8-1: cos β cosh β = -1 (cantilever), = +1
/// (free-free), sin β = 0 (pinned). Fourth order: the error of the Hermite element with consistent mass is (βh/L)⁴/1440.
#[test]
fn blevins_cantilever_free_and_pinned_beams_converge_with_the_fourth_power() {
    for plane in &IN_PLANE {
        let given = bernoulli(plane);
        let [v, r] = plane.dofs;
        let ends = |f: fn(f64) -> f64, brackets: [f64; 3]| brackets.map(|b| beam_omega(root(f, b - 0.5, b + 0.5)));
        let cantilever = ends(|b| b.cos() + 1.0 / b.cosh(), [1.875, 4.694, 7.855]);
        check_rate(cantilever, 4.0, |n| omega(n, L, &given, &plane.dofs, &[(0, v), (0, r)], [0.0; 2], 3));
        let free = ends(|b| b.cos() - 1.0 / b.cosh(), [4.730, 7.853, 10.996]);
        check_rate(free, 4.0, |n| omega(n, L, &given, &plane.dofs, &[], [0.0; 2], 5)[2..].to_vec());
        let pinned = [1.0, 2.0, 3.0].map(|j| beam_omega(j * PI));
        check_rate(pinned, 4.0, |n| omega(n, L, &given, &plane.dofs, &[(0, v), (n, v)], [0.0; 2], 3));
    }
}

/// The leading error of the pinned chain is (jπ/n)⁴/1440 in frequency. P. Tong, T. H. H. Pian, L. L. Bucciarelli, Mode
/// shapes and frequencies by finite element method using consistent and lumped masses, Computers & Structures 1 (1971).
#[test]
fn the_error_of_a_pinned_chain_is_its_predicted_one() {
    let n = 8;
    let given = bernoulli(&IN_PLANE[0]);
    let computed = omega(n, L, &given, &[1, 5], &[(0, 1), (n, 1)], [0.0; 2], 2);
    for (j, w) in computed.iter().enumerate() {
        let beta = (j + 1) as f64 * PI;
        let error = w / beam_omega(beta) - 1.0;
        let predicted = (beta / n as f64).powi(4) / 1440.0;
        assert!((error / predicted - 1.0).abs() < 0.05, "mode {j}: {error} against {predicted}");
    }
}

/// Cantilever with a tip mass of α times the beam: 1 + cos cosh - α β (sin cosh - cos sinh) = 0, from Blevins, chapter 8.
#[test]
fn blevins_cantilever_with_tip_mass() {
    let alpha = 0.6;
    let f = |b: f64| 1.0 + b.cos() * b.cosh() - alpha * b * (b.sin() * b.cosh() - b.cos() * b.sinh());
    let plane = &IN_PLANE[1];
    let exact = [(0.5, 1.8), (3.2, 4.6), (6.5, 7.8)].map(|(a, b)| beam_omega(root(f, a, b)));
    let [v, r] = plane.dofs;
    check_rate(exact, 4.0, |n| {
        omega(n, L, &bernoulli(plane), &plane.dofs, &[(0, v), (0, r)], [alpha * MU * L, 0.0], 3)
    });
}

/// Cantilever whose root is held by a rotational spring k: k (1 + cos cosh) + EI β/L (cos sinh - sin cosh) = 0. K. R. Chun,
/// Free vibration of a beam with one end spring-hinged and the other free, J. Appl. Mech. 39 (1972) 1154-1155. The spring
/// is the compliance of the first element's end.
#[test]
fn chun_cantilever_on_a_rotational_spring() {
    let k = 2.0 * EI / L;
    let f = |b: f64| 2.0 * (1.0 + b.cos() * b.cosh()) + b * (b.cos() * b.sinh() - b.sin() * b.cosh());
    let exact = [(0.5, 1.8), (3.2, 4.6), (6.5, 7.8)].map(|(a, b)| beam_omega(root(f, a, b)));
    for (plane, joint) in IN_PLANE.iter().zip(["end1_compliance_rz", "end1_compliance_ry"]) {
        check_rate(exact, 4.0, |n| {
            let given = bernoulli(plane);
            let root_joint = |e: usize| [given.clone(), vec![(joint, if e == 0 { 1.0 / k } else { 0.0 })]].concat();
            let (stiffness, mass) = chain(&vec![L / n as f64; n], root_joint);
            let keep: Vec<usize> = (6..6 * (n + 1)).filter(|i| plane.dofs.contains(&(i % 6))).collect();
            let pairs = lowest_modes(&part(&stiffness, &keep), &part(&mass, &keep), 3, 10.0).unwrap();
            pairs.values.iter().map(|lambda| lambda.sqrt()).collect()
        });
    }
}

/// Torsion of a clamped shaft: ω = (2j-1)π/2L √(GJ/χ), and stretching of a clamped bar: √(EA/μ); the linear element
/// converges with the square of its length.
#[test]
fn blevins_torsion_and_stretching() {
    let given = vec![("GJ", 700.0), ("EA", 4e6), ("mass_per_length", MU), ("polar_inertia_per_length", 3e-4)];
    for (dof, speed) in [(3, (700.0_f64 / 3e-4).sqrt()), (0, (4e6 / MU).sqrt())] {
        let exact = [1.0, 3.0, 5.0].map(|j| j * PI / (2.0 * L) * speed);
        let errors = |n: usize| -> Vec<f64> {
            omega(n, L, &given, &[dof], &[(0, dof)], [0.0; 2], 3).iter().zip(exact).map(|(w, x)| w / x - 1.0).collect()
        };
        let (coarse, fine) = (errors(32), errors(64));
        for mode in 0..3 {
            let predicted = ((2 * mode + 1) as f64 * PI / 2.0 / 64.0).powi(2) / 24.0;
            assert!((fine[mode] / predicted - 1.0).abs() < 0.01, "{} against {predicted}", fine[mode]);
            assert!(((coarse[mode] / fine[mode]).log2() - 2.0).abs() < 0.01);
        }
    }
}

/// Pinned beam under tension: ω² = (EI k⁴ + P k²)/μ, k = jπ/L. Blevins, chapter 8.
#[test]
fn blevins_pinned_beam_under_tension() {
    for (plane, p) in IN_PLANE.iter().zip([2e4, -3e3]) {
        let given = [bernoulli(plane), vec![("axial_force", p)]].concat();
        let v = plane.dofs[0];
        let exact = [1.0, 2.0, 3.0].map(|j: f64| {
            let k2 = (j * PI / L).powi(2);
            ((EI * k2 * k2 + p * k2) / MU).sqrt()
        });
        let computed = omega(32, L, &given, &plane.dofs, &[(0, v), (32, v)], [0.0; 2], 3);
        for (j, (w, exact)) in computed.iter().zip(exact).enumerate() {
            // (kh)⁴/720 of each term's size: in compression they subtract.
            let k2 = ((j + 1) as f64 * PI / L).powi(2);
            let sizes = (EI * k2 * k2 + f64::abs(p) * k2) / (MU * exact * exact);
            let bound = ((j + 1) as f64 * PI / 32.0).powi(4) / 720.0 * sizes;
            assert!((w / exact - 1.0).abs() < bound, "{w} against {exact}");
        }
    }
}

/// Pinned Timoshenko beam: deflection sin kx, rotation cos kx, so ω² is the lower root of
/// |GAk² - μω², GAk; GAk, EIk² + GA - ρIω²| = 0. S. M. Han, H. Benaroya, T. Wei, Dynamics of transversely vibrating beams
/// using four engineering theories, J. Sound Vib. 225 (1999) 935-988.
#[test]
fn han_benaroya_wei_pinned_timoshenko_beam() {
    for plane in &IN_PLANE {
        let (ga, rotary) = (2.5e4, 6e-3);
        let given = [bernoulli(plane), vec![(plane.compliance, 1.0 / ga), (plane.rotary, rotary)]].concat();
        let exact = [1.0, 2.0, 3.0].map(|j: f64| {
            let k = j * PI / L;
            let (a, b) = (MU * rotary, MU * (EI * k * k + ga) + rotary * ga * k * k);
            let c = ga * EI * k.powi(4);
            // The lower root of a λ² - b λ + c, without cancellation.
            (2.0 * c / (b + (b * b - 4.0 * a * c).sqrt())).sqrt()
        });
        let v = plane.dofs[0];
        let ends = |n| vec![(0, v), (n, v)];
        check_rate(exact, 2.0, |n| omega(4 * n, L, &given, &plane.dofs, &ends(4 * n), [0.0; 2], 3));
        // Far below the Euler-Bernoulli frequencies, so the agreement is that of the theory.
        assert!(exact[2] < 0.7 * beam_omega(3.0 * PI));
    }
}

/// Timoshenko cantilever by its frequency equation. T. C. Huang, The effect of rotatory inertia and of shear deformation
/// on the frequency and normal mode equations of uniform beams, J. Appl. Mech. 28 (1961) 579-584, clamped-free
/// beam, valid for b² r² s² < 1:
///
/// ```text
/// 2 + [b²(r²-s²)² + 2] cosh(bα) cos(bβ) - b (r²+s²)/√(1 - b²r²s²) sinh(bα) sin(bβ) = 0
/// α, β = √½ √( ∓(r²+s²) + √((r²-s²)² + 4/b²) ),   b² = μL⁴ω²/EI,  r² = ρI/(μL²),  s² = EI/(κGA L²)
/// ```
#[test]
fn huang_timoshenko_cantilever() {
    let (ga, rotary) = (2e4, 6e-3);
    let (r2, s2) = (rotary / (MU * L * L), EI / (ga * L * L));
    let f = |b: f64| {
        let inner = ((r2 - s2).powi(2) + 4.0 / (b * b)).sqrt();
        let alpha = (0.5 * (inner - (r2 + s2))).sqrt();
        let beta = (0.5 * (inner + (r2 + s2))).sqrt();
        2.0 + (b * b * (r2 - s2).powi(2) + 2.0) * (b * alpha).cosh() * (b * beta).cos()
            - b * (r2 + s2) / (1.0 - b * b * r2 * s2).sqrt() * (b * alpha).sinh() * (b * beta).sin()
    };
    // Sign changes below the cut-off b r s = 1.
    let mut roots = Vec::new();
    let top = 0.999 / (r2 * s2).sqrt();
    let steps = 4000;
    for i in 1..steps {
        let (a, b) = (top * f64::from(i) / f64::from(steps), top * f64::from(i + 1) / f64::from(steps));
        if f(a).signum() != f(b).signum() {
            roots.push(root(f, a, b) * (EI / (MU * L.powi(4))).sqrt());
        }
    }
    let plane = &IN_PLANE[0];
    let given = [bernoulli(plane), vec![(plane.compliance, 1.0 / ga), (plane.rotary, rotary)]].concat();
    let fe = |n| omega(n, L, &given, &plane.dofs, &[(0, 1), (0, 5)], [0.0; 2], 3);
    let (coarse, fine) = (fe(32), fe(64));
    for mode in 0..3 {
        let richardson = (4.0 * fine[mode] - coarse[mode]) / 3.0;
        assert!((fine[mode] / roots[mode] - 1.0).abs() < 2e-3, "{} against {}", fine[mode], roots[mode]);
        assert!((richardson / roots[mode] - 1.0).abs() < 2e-6, "{richardson} against {}", roots[mode]);
    }
    assert!(fine[2] < 0.8 * beam_omega(7.8547574));
}

/// The Goland wing: bending and torsion coupled by a mass axis 0.18 m behind the elastic axis. J. R. Banerjee, Explicit
/// frequency equation and mode shapes of a cantilever beam coupled in bending and torsion, J. Sound Vib. 224 (1999)
/// 267-281: EI 9.75e6 N m², GJ 9.88e5 N m², 35.75 kg/m, 8.65 kg m about the elastic axis, 6 m; 49.6, 97.0, 248.9, 355.6
/// and 451.5 rad/s as printed.
#[test]
fn banerjee_goland_wing() {
    let (mu, offset, about_elastic_axis) = (35.75, 0.18, 8.65);
    let wing = |plane_offset: &'static str, ei: &'static str, sign: f64| {
        vec![
            (ei, 9.75e6),
            ("GJ", 9.88e5),
            ("mass_per_length", mu),
            ("polar_inertia_per_length", about_elastic_axis - mu * offset * offset),
            (plane_offset, sign * offset),
        ]
    };
    let fixed = |dofs: &[usize]| dofs.iter().map(|d| (0, *d)).collect::<Vec<_>>();
    for (name, ei, dofs) in [("mass_offset_y", "EIy", [2, 4, 3]), ("mass_offset_z", "EIz", [1, 5, 3])] {
        for sign in [1.0, -1.0] {
            let fe = |n| omega(n, 6.0, &wing(name, ei, sign), &dofs, &fixed(&dofs), [0.0; 2], 5);
            let (coarse, fine) = (fe(20), fe(40));
            for (j, printed) in [49.6, 97.0, 248.9, 355.6, 451.5].into_iter().enumerate() {
                // The linear twist converges with the square: extrapolated, and held to half the last printed digit.
                let w = (4.0 * fine[j] - coarse[j]) / 3.0;
                assert!((w - printed).abs() < 0.05, "{w} against {printed}");
            }
        }
    }
}

/// The same wing described from the mass axis, with the elastic axis offset the other way, has the same frequencies.
#[test]
fn an_offset_of_the_elastic_axis_is_the_opposite_offset_of_the_mass_axis() {
    let common = vec![("EA", 1e9), ("EIy", 9.75e6), ("EIz", 4e7), ("GJ", 9.88e5), ("mass_per_length", 35.75)];
    let common = [common, vec![("polar_inertia_per_length", 7.5)]].concat();
    let all: Vec<usize> = (0..6).collect();
    let fixed: Vec<_> = (0..6).map(|d| (0, d)).collect();
    let at = |more: Given| omega(10, 6.0, &[common.clone(), more].concat(), &all, &fixed, [0.0; 2], 6);
    let mass = at(vec![("mass_offset_y", 0.18), ("mass_offset_z", 0.05)]);
    let elastic = at(vec![("shear_centre_y", -0.18), ("shear_centre_z", -0.05)]);
    for (a, b) in mass.iter().zip(elastic) {
        assert!((a / b - 1.0).abs() < 1e-10, "{a} against {b}");
    }
}
