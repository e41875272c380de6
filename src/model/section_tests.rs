//! Sections that are not the same to both sides, as beams: statics by closed forms, mass, and what is refused.

use super::{Model, ParametricModel, Registry, load};
use crate::element::Dof;
use crate::linalg::DVector;

const LENGTH: f64 = 2.0;
const E: f64 = 210e9;
const G: f64 = 80e9;

/// A cantilever along x of a section; `held` are dofs of its tip that do not move.
fn text(section: &str, held: &str) -> String {
    let tip = if held.is_empty() { String::new() } else { format!("  tip: {{node: b, fixed: [{held}]}}\n") };
    format!(
        "retune: 1\nname: cantilever\nnodes:\n  a: [0, 0, 0]\n  b: [{LENGTH}, 0, 0]\nsections:\n  s: {section}\n\
         beams:\n  beam: {{nodes: [a, b], section: s, subdivide: 3}}\nsupports:\n  root: {{node: a}}\n{tip}"
    )
}

fn built(section: &str, held: &str) -> Model {
    let text = text(section, held);
    load(&text, &Registry::builtin()).unwrap_or_else(|p| panic!("{p:?}\n{text}")).0
}

fn steel(shape: &str) -> String {
    format!("{{E: {E}, G: {G}, density: 7850, shape: {{{shape}}}}}")
}

/// Motions of the tip under forces and moments on it: ux uy uz rx ry rz.
fn deflected(model: &Model, loads: &[(Dof, f64)]) -> [f64; 6] {
    let dofs = model.dof_map();
    let tip = dofs.node("b").unwrap();
    let mut force = DVector::zeros(dofs.n_dof());
    for (dof, f) in loads {
        force[dofs.express(tip, *dof)[0].0] += f;
    }
    let q = model.assemble(&[]).unwrap().stiffness.lu().solve(&force).unwrap();
    std::array::from_fn(|d| dofs.express(tip, Dof::ALL[d]).iter().map(|(row, factor)| factor * q[*row]).sum())
}

#[track_caller]
fn near(own: f64, exact: f64) {
    assert!((own / exact - 1.0).abs() < 1e-9, "{own} beside {exact}");
}

/// A force along one leg of an angle bends it along both: [v; w] = L³/3E [Iz Iyz; Iyz Iy]⁻¹ F, with moments about the axes of the legs
/// from two rectangles. The axes of its element are the principal ones, whatever direction is stated.
#[test]
fn an_angle_bends_along_both_legs() {
    let (b, h, t) = (80e-3, 120e-3, 8e-3);
    let parts = [[0.5 * t, 0.5 * h, t, h], [0.5 * (t + b), 0.5 * t, b - t, t]];
    let area: f64 = parts.iter().map(|p| p[2] * p[3]).sum();
    let mean = |k: usize| parts.iter().map(|p| p[2] * p[3] * p[k]).sum::<f64>() / area;
    let (y, z) = (mean(0), mean(1));
    let sum = |of: &dyn Fn(&[f64; 4]) -> f64| parts.iter().map(|p| p[2] * p[3] * of(p)).sum::<f64>();
    let iy = sum(&|p| p[3] * p[3] / 12.0 + (p[1] - z).powi(2));
    let iz = sum(&|p| p[2] * p[2] / 12.0 + (p[0] - y).powi(2));
    let iyz = sum(&|p| (p[0] - y) * (p[1] - z));
    assert!(iyz < -0.3 * iz);
    let shape = steel("angle: {width: 80 mm, height: 120 mm, thickness: 8 mm}");
    let model = built(&shape, "rx");
    let compliance = LENGTH.powi(3) / (3.0 * E) / (iy * iz - iyz * iyz);
    let up = deflected(&model, &[(Dof::Uz, 1.0)]);
    near(up[2], compliance * iz);
    near(up[1], -compliance * iyz);
    let aside = deflected(&model, &[(Dof::Uy, 1.0)]);
    near(aside[1], compliance * iy);
    near(aside[2], -compliance * iyz);
    near(deflected(&model, &[(Dof::Ux, 1.0)])[0], LENGTH / (E * area));
    // Laid with the leg along z pointing along -y: the same angle turned by a quarter.
    let laid = text(&shape, "rx").replace("section: s", "section: s, orientation: [0, -1, 0]");
    let laid = load(&laid, &Registry::builtin()).unwrap().0;
    let turned = deflected(&laid, &[(Dof::Uy, -1.0)]);
    near(-turned[1], up[2]);
    near(turned[2], up[1]);
    // Its element says where the principal axes are.
    let axes = model.elements()[0].axes;
    let alpha = 0.5 * (2.0 * iyz / (iz - iy)).atan();
    near(axes[1][1], alpha.cos());
    near(axes[1][2], alpha.sin());
    near(axes[2][2], alpha.cos());
}

/// A force through the centroid of a channel twists it about its shear centre, e away: rx = F e L/GJ, and moves the centroid with that.
#[test]
fn a_channel_twists_about_its_shear_centre() {
    let (b, h, tw, tf) = (80e-3, 200e-3, 6e-3, 11e-3);
    let model = built(&steel("channel: {width: 80 mm, height: 200 mm, web: 6 mm, flange: 11 mm}"), "");
    let area: f64 = 2.0 * b * tf + (h - 2.0 * tf) * tw;
    let centroid = (b * b * tf + 0.5 * (h - 2.0 * tf) * tw * tw) / area;
    let (bm, hm) = (b - 0.5 * tw, h - tf);
    let e = centroid - 0.5 * tw + 3.0 * bm * bm * tf / (hm * tw + 6.0 * bm * tf);
    let iy = (b * h.powi(3) - (b - tw) * (h - 2.0 * tf).powi(3)) / 12.0;
    let turned = deflected(&model, &[(Dof::Rx, 1.0)]);
    let gj = LENGTH / turned[3];
    assert!((gj / (G * 7.88e-8) - 1.0).abs() < 2e-3, "{gj}");
    let up = deflected(&model, &[(Dof::Uz, 1.0)]);
    near(up[3], e * LENGTH / gj);
    near(up[2], LENGTH.powi(3) / (3.0 * E * iy) + e * up[3]);
    // A pull through the centroid only stretches.
    let pulled = deflected(&model, &[(Dof::Ux, 1.0)]);
    near(pulled[0], LENGTH / (E * area));
    assert!(pulled[1..].iter().all(|v| v.abs() < 1e-9 * pulled[0]), "{pulled:?}");
    // With the torque that takes the force into the shear centre it does not twist.
    let through = deflected(&model, &[(Dof::Uz, 1.0), (Dof::Rx, -e)]);
    assert!(through[3].abs() < 1e-9 * up[3], "{through:?}");
}

/// An I of two flanges and a tee: their mass is on the node line, and a force along y twists them about a shear centre above or below it.
#[test]
fn an_uneven_i_and_a_tee_twist_under_a_force_along_y() {
    for (shape, above) in [
        (
            "i: {height: 200 mm, width: 120 mm, web: 6 mm, flange: 12 mm, bottom_width: 60 mm, bottom_flange: 8 mm}",
            true,
        ),
        (
            "i: {height: 200 mm, width: 60 mm, web: 6 mm, flange: 8 mm, bottom_width: 120 mm, bottom_flange: 12 mm}",
            false,
        ),
        ("tee: {height: 100 mm, width: 100 mm, web: 6 mm, flange: 9 mm, fillet: 8 mm}", true),
    ] {
        let model = built(&steel(shape), "");
        let aside = deflected(&model, &[(Dof::Uy, 1.0)]);
        // From the shear centre at (0, z) the force along y at (0, 0) has the torque +z.
        assert_eq!(aside[3] > 0.0, above, "{shape}: {aside:?}");
        let mass = model.mass_properties(&[]).unwrap().unwrap();
        assert!(mass.cg[1].abs() < 1e-12 && mass.cg[2].abs() < 1e-12, "{mass:?}");
        let up = deflected(&model, &[(Dof::Uz, 1.0)]);
        assert!(up[3].abs() < 1e-9 * aside[3].abs());
    }
    let even = built(&steel("i: {height: 200 mm, width: 100 mm, web: 5.6 mm, flange: 8.5 mm, fillet: 12 mm}"), "");
    let mass = even.mass_properties(&[]).unwrap().unwrap();
    assert!((mass.mass / (7850.0 * 28.48e-4 * LENGTH) - 1.0).abs() < 5e-4, "{}", mass.mass);
    let up = deflected(&even, &[(Dof::Uz, 1.0)]);
    assert!((up[2] / (LENGTH.powi(3) / (3.0 * E * 1943e-8)) - 1.0).abs() < 5e-4);
}

const CARBON: &str = "materials: {ud: {E1: 129 GPa, E2: 9.4 GPa, G12: 5.16 GPa, nu12: 0.3, density: 1550 kg/m3}}";

fn laminate(width: &str, plies: &str) -> String {
    format!("{{shape: {{laminate: {{width: {width}, {CARBON}, plies: [{plies}]}}}}}}")
}

/// Under a moment at its tip a strip of plies at 30 degrees bends and twists as its compliances say: ry = 12 S11 M L/(b h³),
/// rx = -6 S16 M L/(b h³), but for its edges, 1.3 thickness/width of the twist.
#[test]
fn a_strip_bends_and_twists_by_its_plies() {
    let ply = "{angle: 30 deg, thickness: 0.5 mm}";
    let model = built(&laminate("0.5 m", &[ply; 4].join(", ")), "");
    let (s, c) = 30_f64.to_radians().sin_cos();
    let (a, b, d, n) = (1.0 / 129e9, 1.0 / 9.4e9, 1.0 / 5.16e9, 0.3 / 129e9);
    let s11 = c.powi(4) * a + (d - 2.0 * n) * s * s * c * c + s.powi(4) * b;
    let s16 = (2.0 * a + 2.0 * n - d) * s * c.powi(3) - (2.0 * b + 2.0 * n - d) * s.powi(3) * c;
    assert!(s16 < 0.0);
    let bend = LENGTH / (0.5 * 2e-3_f64.powi(3));
    let tip = deflected(&model, &[(Dof::Ry, 1.0)]);
    near(tip[4], 12.0 * s11 * bend);
    near(tip[3], -6.0 * s16 * bend);
    // A torque twists it by S66, and by what the edges give: some 0.63 · 2 mm / 500 mm of it.
    let twisted = deflected(&model, &[(Dof::Rx, 1.0)]);
    near(twisted[4], tip[3]);
    let s66 = 2.0 * (2.0 * a + 2.0 * b + 4.0 * n - d) * s * s * c * c + d * (s.powi(4) + c.powi(4));
    let edges = twisted[3] / (3.0 * s66 * bend) - 1.0;
    assert!((1e-4..5e-3).contains(&edges), "{edges}");
    let mass = model.mass_properties(&[]).unwrap().unwrap();
    near(mass.mass, 1550.0 * 0.5 * 2e-3 * LENGTH);
}

/// What a section states itself counts, before or behind its shape; of a shape beside one in the section, only that of the member.
#[test]
fn what_is_stated_counts_before_the_shape() {
    let tube = "shape: {tube: {diameter: 60 mm, wall: 3 mm}}";
    let twist = |section: &str| deflected(&built(section, ""), &[(Dof::Rx, 1.0)])[3];
    for section in [format!("{{E: {E}, G: {G}, {tube}, J: 2 cm4}}"), format!("{{E: {E}, G: {G}, J: 2 cm4, {tube}}}")] {
        near(twist(&section), LENGTH / (G * 2e-8));
    }
    let channel = steel("channel: {width: 80 mm, height: 200 mm, web: 6 mm, flange: 11 mm}");
    let both = text(&channel, "")
        .replace("section: s", "section: s, properties: {shape: {rectangle: {width: 1 cm, height: 1 cm}}}");
    let model = load(&both, &Registry::builtin()).unwrap().0;
    let up = deflected(&model, &[(Dof::Uz, 1.0)]);
    near(up[2], LENGTH.powi(3) / (3.0 * E * 1e-8 / 12.0));
    assert!(up[3].abs() < 1e-12 * up[2], "{up:?}");
}

/// Every wrong size, ply and mixture is refused where it stands, with what is wrong.
#[test]
fn what_is_no_section_is_refused() {
    let ply = |angle: &str| format!("{{angle: {angle}, thickness: 1 mm}}");
    let cases = [
        (
            steel("rectangle: {width: 1, height: 1}, tee: {height: 1, width: 1, web: 0.1, flange: 0.1}"),
            "give exactly one of",
        ),
        (steel("i: {height: 10 mm, width: 100 mm, web: 5 mm, flange: 8 mm}"), "shape.i: the flanges leave no web"),
        (
            steel("i: {height: 200 mm, width: -1 mm, web: 5 mm, flange: 8 mm}"),
            "shape.i.width: `-1 mm` must be above zero",
        ),
        (steel("i: {height: 200 mm, width: 100 mm, web: 5 mm, flange: 8 mm, fillet: -1 mm}"), "shape.i.fillet"),
        (steel("channel: {height: 200 mm, width: 80 kg, web: 5 mm, flange: 8 mm}"), "shape.channel.width"),
        (steel("channel: {height: 200 mm, width: 80 mm, web: 20 mm, flange: 8 mm}"), "no formula for the torsion"),
        (
            steel("angle: {width: 50 mm, height: 50 mm, thickness: 60 mm}"),
            "shape.angle: the legs are thicker than long",
        ),
        (
            steel("tee: {height: 50 mm, width: 50 mm, web: 5 mm, flange: 5 mm, fillet: 30 mm}"),
            "shape.tee: the fillets do not fit",
        ),
        (
            steel("i: {height: 1e200, width: 1e199, web: 1e198, flange: 1e198}"),
            "shape: its sizes or moduli are too large",
        ),
        (laminate("20 mm", &ply("0")).replace("129 GPa", "1e300 Pa"), "shape: its sizes or moduli are too large"),
        (laminate("20 mm", ""), "shape.laminate.plies: a laminate has between 1"),
        (laminate("20 mm", &ply("45")), "plies[0].angle: `45` is 2578 degrees"),
        (
            laminate("20 mm", "{angle: 0, thickness: 0}"),
            "plies[0].thickness: `thickness` is 0 m; it must be above zero",
        ),
        (laminate("20 mm", "{angle: 0, thickness: 1 mm, material: ux}"), "there is no material `ux`"),
        (laminate("20 mm", &[ply("30 deg"), ply("-30 deg")].join(", ")), "extension with twist"),
        (laminate("0.5 mm", &ply("0")), "thicker than wide"),
        (laminate("20 mm", &ply("0")).replace("nu12: 0.3", "nu12: 4"), "nu12: `4` is too large"),
        (laminate("20 mm", &ply("0")).replace("E2: 9.4 GPa", "E2: 0 Pa"), "E2: `E2` is 0 Pa; it must be above zero"),
        (laminate("20 mm", &ply("0")).replace("]}}}", "]}}, density: 1600}"), "density"),
        (
            laminate("20 mm", &ply("0")).replace("ud: {", "b: {E1: 1, E2: 1, G12: 1, nu12: 0, density: 1}, ud: {"),
            "several materials",
        ),
    ];
    for (section, what) in cases {
        let text = text(&section, "");
        let problems = load(&text, &Registry::builtin()).map(|_| ()).unwrap_err();
        let told: Vec<String> = problems.iter().map(|p| format!("{}: {}", p.path, p.message)).collect();
        assert!(told.iter().any(|t| t.contains(what)), "{what}: {told:?}\n{text}");
    }
}
