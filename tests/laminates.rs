//! Laminates of decks: PCOMP, PCOMPG and COMPOSITE sections of shells, in and back.
//!
//! Truth: Navier's closed forms of laminated plates (Jones, Mechanics of Composite Materials 1999, chapter 5), pyNastran's rigidities,
//! CalculiX on the same mesh. What is not installed is skipped with a message.

use retune::deck::{Deck, KeywordDeck};
use retune::modal::SolveOptions;
use retune::model::{Model, ParametricModel, Registry, load, solve_modes};
use retune_exchange::{
    ExportError, Exported, ImportOptions, Imported, Solver, compare_results, export, export_keywords, import,
    import_keywords, read_results, system_by_name,
};
use serde_json::Value;
use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

fn options(solver: Solver) -> ImportOptions {
    ImportOptions { system: system_by_name("si").unwrap(), subcase: None, parameter_per_property: false, solver }
}

fn deck_of(text: &str) -> Deck {
    Deck::read(Path::new("deck.bdf"), &mut |_| Ok(text.as_bytes().to_vec())).unwrap()
}

fn keywords_of(text: &str) -> KeywordDeck {
    KeywordDeck::read(Path::new("deck.inp"), &mut |_| Ok(text.as_bytes().to_vec())).unwrap()
}

fn imported(text: &str) -> Imported {
    if text.starts_with('*') {
        import_keywords(&keywords_of(text), options(Solver::Abaqus)).unwrap_or_else(|e| panic!("{}\n{text}", e[0]))
    } else {
        import(&deck_of(text), options(Solver::default())).unwrap_or_else(|e| panic!("{}\n{text}", e[0]))
    }
}

fn model_of(text: &str) -> Model {
    load(text, &Registry::builtin()).unwrap_or_else(|p| panic!("{}\n{text}", p[0].message)).0
}

fn model(text: &str) -> Model {
    model_of(&imported(text).text)
}

fn at(model: &Model, theta: &[f64], n: usize) -> Vec<f64> {
    let modes = solve_modes(model, theta, SolveOptions { n_elastic: n, shift: None }).unwrap();
    modes.elastic().map(|i| modes.frequency_hz(i)).collect()
}

fn frequencies(model: &Model, n: usize) -> Vec<f64> {
    at(model, &model.parameters().nominal(), n)
}

#[track_caller]
fn near(a: f64, b: f64, part: f64) {
    assert!((a / b - 1.0).abs() < part, "{a} is not {b} within {part:e}");
}

#[track_caller]
fn all_near(a: &[f64], b: &[f64], part: f64) {
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(b) {
        near(*a, *b, part);
    }
}

/// A property of the first element of a model.
fn value(model: &Model, name: &str) -> f64 {
    let e = &model.elements()[0];
    let i = e.kind.properties().iter().position(|p| p.name == name).unwrap();
    e.values[i].as_ref().map_or(0.0, |v| v.at(&model.parameters().nominal()))
}

const CARBON: &str = "MAT8,1,1.3+11,9.+9,.3,5.+9,5.+9,3.+9,1600.\n";

/// A plate of `n` by `n` shells of property 1, 0.4 m by 0.3 m; lines beside; `edge` are the components held on edges along y and along x.
fn plate(property: &str, n: usize, edge: [&str; 2], element: &str) -> String {
    let mut deck = format!("CEND\nSPC=1\nBEGIN BULK\n{CARBON}{property}");
    for i in 0..=n {
        for j in 0..=n {
            let a = 1 + i * (n + 1) + j;
            let (x, y) = (0.4 * i as f64 / n as f64, 0.3 * j as f64 / n as f64);
            let _ = writeln!(deck, "GRID,{a},,{x:.9},{y:.9},0.");
            if i == 0 || i == n {
                let _ = writeln!(deck, "SPC1,1,{},{a}", edge[0]);
            }
            if j == 0 || j == n {
                let _ = writeln!(deck, "SPC1,1,{},{a}", edge[1]);
            }
            if i < n && j < n {
                let _ = writeln!(deck, "CQUAD4,{a},1,{a},{},{},{}{element}", a + n + 1, a + n + 2, a + 1);
            }
        }
    }
    deck + "ENDDATA\n"
}

/// The plate clamped along one side.
fn clamped(property: &str, element: &str) -> String {
    let free = plate(property, 4, ["", ""], element);
    let kept: Vec<&str> = free.lines().filter(|l| !l.starts_with("SPC1")).collect();
    (kept.join("\n") + "\n").replace("ENDDATA\n", "SPC1,1,123456,1,THRU,5\nENDDATA\n")
}

/// A, B, D of plies in 0 and 90 degrees, from the lower side: classical theory, by hand.
fn cross_ply(plies: &[(f64, bool)]) -> [[f64; 4]; 3] {
    let (e1, e2, nu, g): (f64, f64, f64, f64) = (130e9, 9e9, 0.3, 5e9);
    let rest = 1.0 - nu * nu * e2 / e1;
    let (along, across, both) = (e1 / rest, e2 / rest, nu * e2 / rest);
    let mut z = -0.5 * plies.iter().map(|p| p.0).sum::<f64>();
    let mut out = [[0.0; 4]; 3];
    for (t, is_turned) in plies {
        let (q11, q22) = if *is_turned { (across, along) } else { (along, across) };
        for (power, sums) in out.iter_mut().enumerate() {
            let k = power as i32 + 1;
            let moment = ((z + t).powi(k) - z.powi(k)) / f64::from(k);
            for (sum, q) in sums.iter_mut().zip([q11, both, q22, g]) {
                *sum += q * moment;
            }
        }
        z += t;
    }
    out
}

/// Simply supported plates of cross-plies, symmetric and not, vibrate as Navier's solution says:
/// ρ h ω² = T33 - [T13 T23] [T11 T12; T12 T22]⁻¹ [T13; T23] (Jones, 5.86 and 5.103).
#[test]
fn plates_of_cross_plies_vibrate_as_naviers() {
    let (a, b, t) = (0.4_f64, 0.3_f64, 0.5e-3_f64);
    let cases = [
        (
            "PCOMP,1,,,,,,,,\n,1,5.-4,0.,,1,5.-4,90.\n,1,5.-4,90.,,1,5.-4,0.\n",
            vec![(t, false), (t, true), (t, true), (t, false)],
        ),
        ("PCOMP,1,,,,,,,SYM\n,1,5.-4,0.,,,,90.\n", vec![(t, false), (t, true), (t, true), (t, false)]),
        ("PCOMP,1\n,1,.001,0.,,1,.001,90.\n", vec![(2.0 * t, false), (2.0 * t, true)]),
        ("PCOMPG,1\n,7,1,.001,0.\n,8,1,5.-4,90.\n,9,1,5.-4,90.\n", vec![(2.0 * t, false), (t, true), (t, true)]),
    ];
    for (card, plies) in cases {
        let [aa, bb, dd] = cross_ply(&plies);
        let mass = 1600.0 * plies.iter().map(|p| p.0).sum::<f64>();
        let mut exact: Vec<f64> = Vec::new();
        for m in 1..5 {
            for n in 1..5 {
                let (p, q) = (PI * f64::from(m) / a, PI * f64::from(n) / b);
                let [t11, t12, t22] =
                    [aa[0] * p * p + aa[3] * q * q, (aa[1] + aa[3]) * p * q, aa[2] * q * q + aa[3] * p * p];
                let t13 = -bb[0] * p.powi(3) - (bb[1] + 2.0 * bb[3]) * p * q * q;
                let t23 = -bb[2] * q.powi(3) - (bb[1] + 2.0 * bb[3]) * p * p * q;
                let t33 = dd[0] * p.powi(4) + 2.0 * (dd[1] + 2.0 * dd[3]) * p * p * q * q + dd[2] * q.powi(4);
                let softer = (t22 * t13 * t13 - 2.0 * t12 * t13 * t23 + t11 * t23 * t23) / (t11 * t22 - t12 * t12);
                exact.push(((t33 - softer) / mass).sqrt() / TAU);
            }
        }
        exact.sort_by(f64::total_cmp);
        // w and the displacement along an edge are none there, the one across it is free.
        let found = frequencies(&model(&plate(card, 12, ["23", "13"], "")), 3);
        for (f, e) in found.iter().zip(&exact) {
            // Bilinear elements err by (π h/L)²/12 in the mean of two directions: 6e-3 of the first, four times that of the next; shear takes 1e-3.
            near(*f, *e, 0.025);
        }
        near(found[0], exact[0], 0.01);
    }
}

/// Ways to say one laminate: half of it; a card with numbers of plies; angles of the elements, of the plies or of both; coordinates.
#[test]
fn one_laminate_said_in_many_ways() {
    let plies = |a: [f64; 4]| {
        let ply = |t: f64| format!("1,5.-4,{t:.1},");
        format!("PCOMP,1\n,{},{}\n,{},{}\n", ply(a[0]), ply(a[1]), ply(a[2]), ply(a[3]))
    };
    let exact = frequencies(&model(&clamped(&plies([10.0, 55.0, 55.0, 10.0]), "")), 6);
    let ways = [
        (plies([0.0, 45.0, 45.0, 0.0]), ",10."),
        ("PCOMP,1,,,,,,,SYM\n,1,5.-4,10.,,1,5.-4,55.\n".to_string(), ""),
        ("PCOMP,1,-.001\n,1,5.-4,10.,,,,55.\n,,,55.,,,,10.\n".to_string(), ""),
        ("PCOMPG,1\n,1,1,5.-4,10.\n,2,1,.001,55.\n,3,1,5.-4,10.\n".to_string(), ""),
        // Turned by ten degrees about z.
        (format!("CORD2R,5,,0.,0.,0.,0.,0.,1.\n,.984807753,.173648178,0.\n{}", plies([0.0, 45.0, 45.0, 0.0])), ",5"),
    ];
    for (card, element) in ways {
        // Whitney's transverse shear is that of bending along two directions, so that it feels which: here 2e-5.
        all_near(&frequencies(&model(&clamped(&card, element)), 6), &exact, 1e-4);
    }
    // Faces of an isotropic material: MAT1 and the MAT8 and the MAT2 of its constants.
    let sandwich = |face: &str| {
        let card = format!("{face}PCOMP,1\n,2,4.-4,30.,,1,.002,20.\n,2,4.-4,30.\n");
        frequencies(&model(&clamped(&card, "")), 6)
    };
    let (e, nu) = (7e10, 0.3);
    let (q, g) = (e / (1.0 - nu * nu), e / (2.0 * (1.0 + nu)));
    let exact = sandwich("MAT1,2,7.+10,,.3,2700.\n");
    all_near(&sandwich(&format!("MAT8,2,7.+10,7.+10,.3,{g:.9e},{g:.9e},{g:.9e},2700.\n")), &exact, 1e-8);
    let sheet = format!("MAT2,2,{q:.9e},{:.9e},0.,{q:.9e},0.,{g:.9e},2700.\n", nu * q);
    all_near(&sandwich(&sheet), &exact, 1e-8);
}

/// Z0 puts the grids on the lower side: as ZOFFS does; NSM is mass; a membrane does not bend, a smeared laminate bends as one plate.
#[test]
fn a_laminate_stands_where_its_card_puts_it() {
    let card = |head: &str| format!("PCOMP,1{head}\n,1,5.-4,0.,,1,.001,90.\n");
    // On hinges: of a clamped plate an offset says nothing.
    let hinged = |card: &str, element: &str| frequencies(&model(&plate(card, 4, ["123", "123"], element)), 5);
    let below = hinged(&card(",0."), "");
    all_near(&hinged(&card(""), ",,7.5-4"), &below, 1e-9);
    all_near(&hinged(&card(",1.-4"), ",,-1.-4"), &below, 1e-9);
    let on_middle = hinged(&card(""), "");
    assert!((below[0] / on_middle[0] - 1.0).abs() > 1e-3, "{below:?} {on_middle:?}");
    let middle = frequencies(&model(&clamped(&card(""), "")), 5);
    // 1.5 mm of 1600 kg/m3, and once more the same.
    let heavier = frequencies(&model(&clamped(&card(",,2.4"), "")), 5);
    near(heavier[0] / middle[0], 0.5_f64.sqrt(), 1e-6);
    let smeared = model(&clamped(&card(",,,,,,,SMEAR").replace("PCOMP,1,,,,,,,,SMEAR", "PCOMP,1,,,,,,,SMEAR"), ""));
    let [a, _, _] = cross_ply(&[(5e-4, false), (1e-3, true)]);
    near(value(&smeared, "A11"), a[0], 1e-9);
    near(value(&smeared, "D11"), a[0] * 2.25e-6 / 12.0, 1e-9);
    assert_eq!(value(&smeared, "B11"), 0.0);
    near(value(&smeared, "areal_mass"), 2.4, 1e-9);
    let membrane = model(&clamped("PCOMP,1,,,,,,,MEM\n,1,5.-4,0.,,1,.001,90.\n", ""));
    near(value(&membrane, "A22"), a[2], 1e-9);
    near(value(&membrane, "D11"), a[0] * 2.25e-12 / 12.0, 1e-9);
}

#[test]
fn what_is_no_laminate_is_refused() {
    for (card, message) in [
        ("PCOMP,1\n", "PCOMP 1, field 10 (MID): it has no plies"),
        ("PCOMP,1\n,7,.001,0.\n", "field 10 (MID): there is no material 7"),
        ("PCOMP,1\n,1,,0.\n", "field 11 (T): a real number is missing"),
        ("PCOMP,1\n,1,-.001,0.\n", "field 11 (T): the thickness must be above zero"),
        ("PCOMP,1\n,1,.001,x\n", "field 12 (THETA): `x` where a real number"),
        ("PCOMP,1,,,,,,,BEND\n,1,.001,0.\n", "field 9 (LAM): a laminate that bends and has no membrane is not read"),
        ("PCOMP,1,,,,,,,SMCORE\n,1,.001,0.\n", "field 9 (LAM): faces smeared about a core are not read"),
        ("PCOMP,1,,,,,,,SYMM\n,1,.001,0.\n", "field 9 (LAM): `SYMM` where SYM, MEM, BEND, SMEAR"),
        ("PCOMPG,1,,,,,,,SYM\n,1,1,.001,0.\n", "field 9 (LAM): `SYM` where"),
        ("MAT9,2,1.\nPCOMP,1\n,2,.001,0.\n", "material 2 is a MAT9, and MAT1, MAT2 or MAT8 is expected"),
    ] {
        let text = clamped(card, "");
        let found = import(&deck_of(&text), options(Solver::default())).unwrap_err()[0].to_string();
        assert!(found.contains(message), "{found}\n{message}");
    }
}

const DESIGNED: &str = "DESVAR,1,TSKIN,.5,.2,.9\nDESVAR,2,TURN,30.,0.,80.\nDESVAR,3,TCORE,1.,.5,2.\nDESVAR,4,STIFF,1.3,1.,1.6\n\
DVPREL1,1,PCOMP,1,T1,,,,\n,1,.001\nDVPREL1,2,PCOMP,1,17,,,,\n,3,.001\nDVPREL1,3,PCOMP,1,THETA1,,,5.,\n,2,1.\nDVMREL1,4,MAT8,1,E1,,,,\n,4,1.+11\n\
PCOMP,1,0.\n,1,.0005,35.,,2,.001,0.\n,1,.0005,-35.\nMAT1,2,7.+9,,.3,200.\n";

/// A deck with the values of some design variables in its fields.
fn fields(t1: f64, turn: f64, core: f64, stiff: f64) -> String {
    let plain = format!(
        "PCOMP,1,0.\n,1,{:.9},{:.9},,2,{:.9},0.\n,1,.0005,-35.\nMAT1,2,7.+9,,.3,200.\n",
        t1 * 1e-3,
        5.0 + turn,
        core * 1e-3
    );
    clamped(&plain, "").replace("1.3+11", &format!("{stiff:.9}+11"))
}

/// Thicknesses, an angle, a modulus of plies as functions of design variables, by names of fields and by their numbers; Z0 stays where the card has
/// it, so that the mid-surface moves with the thickness.
#[test]
fn plies_follow_design_variables() {
    let designed = model(&clamped(DESIGNED, ""));
    assert_eq!(designed.parameters().len(), 4);
    for theta in [[0.5, 30.0, 1.0, 1.3], [0.7, 55.0, 1.4, 1.1]] {
        let order: Vec<f64> = designed
            .parameters()
            .names()
            .map(|n| theta[["tskin", "turn", "tcore", "stiff"].iter().position(|k| k == &n).unwrap()])
            .collect();
        let [t1, turn, core, stiff] = theta;
        let expected = frequencies(&model(&fields(t1, turn, core, stiff)), 5);
        all_near(&at(&designed, &order, 5), &expected, 1e-9);
    }
    // What no ply has is told, not lost.
    let told = imported(&clamped(&DESIGNED.replace("PCOMP,1,T1", "PCOMP,1,T9"), "")).report.notes.join("\n");
    assert!(told.contains("relations to fields that no element uses are left out: DVPREL1 1"), "{told}");
}

/// Texts of a model file and what stands in their place.
type Edits<'a> = &'a [(&'a str, &'a str)];

fn learnt(deck: &str, edits: Edits<'_>) -> Result<(Exported, Model), ExportError> {
    let mut text = imported(deck).text;
    for (from, to) in edits {
        assert!(text.contains(from), "`{from}` is not in\n{text}");
        text = text.replacen(from, to, 1);
    }
    let updated = model_of(&text);
    let out = if deck.starts_with('*') {
        export_keywords(&keywords_of(deck), &updated)
    } else {
        export(&deck_of(deck), &updated)
    };
    out.map(|e| (e, updated))
}

/// Plies that an update changed go back into their fields; a material that one of two laminates changed, into a copy of both cards.
#[test]
fn changed_plies_go_back_into_the_deck() {
    let card = "PCOMP   1       0.\n        1       .0005   35.             2       .001    0.\n        1       .0005   -35.\nMAT1,2,7.+9,,.3,200.\n";
    let deck = clamped(card, "");
    let cases: [(Edits<'_>, &[&str]); 5] = [
        (
            &[("angle: 35 deg, thickness: 0.0005 m", "angle: 0.7 rad, thickness: 0.6 mm")],
            &["        1       6.-4    40.10705"],
        ),
        (&[("E: 7e9 Pa", "E: 8e9 Pa")], &["MAT1,2,8.+9,,.3,200.\n"]),
        (&[("thickness: 0.001 m", "thickness: 0.002 m")], &["2       2.-3    0."]),
        (
            &[("imported:", "overrides: {pcomp_1: {stiffness: 1.1}}\nimported:")],
            &["MAT8,1,1.43+11,9.9+9,.3,5.5+9,5.5+9,3.3+9,1600."],
        ),
        (&[("imported:", "overrides: {cquad4_1: {stiffness: 1.1}}\nimported:")], &["CQUAD4,1,", "PCOMP   ", "1.43+11"]),
    ];
    for (edits, expected) in cases {
        let (out, updated) = learnt(&deck, edits).unwrap_or_else(|e| panic!("{edits:?}: {e}"));
        for part in expected {
            assert!(out.files[0].contains(part), "`{part}` is not in\n{}\n{}", out.changes.join("\n"), out.files[0]);
        }
        let again = frequencies(&model(&out.files[0]), 6);
        all_near(&again, &frequencies(&updated, 6), 1e-5_f64.max(10.0 * out.rounding));
    }
    // Design variables have their own cards.
    let (out, _) = learnt(&clamped(DESIGNED, ""), &[("turn: {value: 30", "turn: {value: 41")]).unwrap();
    assert!(out.files[0].contains("DESVAR,2,TURN,41.,0.,80.\n"), "{}", out.files[0]);
    // Rigidities of their own have no card.
    let refused = learnt(&deck, &[("imported:", "overrides: {pcomp_1: {set: {A11: 1e8 N/m}}}\nimported:")]);
    let refused = refused.map(|_| ()).unwrap_err().to_string();
    assert!(refused.contains("is not that of its plies"), "{refused}");
}

/// A laminate of Abaqus: one plate of plies on four shells, with what stands below the nodes.
fn abaqus(section: &str) -> String {
    let mut text = "*NODE, NSET=ALL\n".to_string();
    for i in 0..=4 {
        for j in 0..=4 {
            let _ = writeln!(text, "{}, {}, {}, 0.", 1 + 5 * i + j, 0.1 * f64::from(i), 0.075 * f64::from(j));
        }
    }
    text += "*ELEMENT, TYPE=S4R, ELSET=SKIN\n";
    for i in 0..4 {
        for j in 0..4 {
            let a = 1 + 5 * i + j;
            let _ = writeln!(text, "{a}, {a}, {}, {}, {}", a + 5, a + 6, a + 1);
        }
    }
    text + "*MATERIAL, NAME=CARBON\n*ELASTIC, TYPE=LAMINA\n130.E9, 9.E9, 0.3, 5.E9, 5.E9, 3.E9\n*DENSITY\n1600.\n\
        *MATERIAL, NAME=Foam\n*ELASTIC\n7.E9, 0.3\n*DENSITY\n200.\n"
        + section
        + "*BOUNDARY\n1, 1, 6\n2, 1, 6\n3, 1, 6\n4, 1, 6\n5, 1, 6\n*STEP\n*FREQUENCY\n6\n*END STEP\n"
}

const PLIES: &str = "*SHELL SECTION, ELSET=SKIN, COMPOSITE, OFFSET=SNEG\n5.E-4, 3, CARBON, 35.\n.001, 3, FOAM, 0.\n5.E-4, 3, CARBON, -35.\n";

/// The same plate from decks of both kinds; orientations of plies, of the section, of neither.
#[test]
fn composite_sections_are_the_same_laminate() {
    let card = "PCOMP,1,0.\n,1,.0005,35.,,2,.001,0.\n,1,.0005,-35.\nMAT1,2,7.+9,,.3,200.\n";
    let exact = frequencies(&model(&clamped(card, "")), 6);
    let turned = |name: &str, degrees: f64| {
        let (s, c) = f64::to_radians(degrees).sin_cos();
        format!("*ORIENTATION, NAME={name}\n{c:.12}, {s:.12}, 0., {:.12}, {c:.12}, 0.\n3, 0.\n", -s)
    };
    let along = turned("P35", 35.0)
        + &turned("M35", -35.0)
        + &PLIES.replace("CARBON, 35.", "CARBON, P35").replace("CARBON, -35.", "CARBON, M35");
    let section = turned("OFF", 20.0)
        + &PLIES
            .replace("COMPOSITE,", "COMPOSITE, ORIENTATION=OFF,")
            .replace("35.\n.001", "15.\n.001")
            .replace("-35.", "-55.");
    for text in [PLIES.to_string(), along, section] {
        all_near(&frequencies(&model(&abaqus(&text)), 6), &exact, 1e-4);
    }
    let half = "*SHELL SECTION, ELSET=SKIN, COMPOSITE, SYMMETRIC\n5.E-4, 3, CARBON, 35.\n.001, 3, FOAM, 0.\n";
    let whole =
        "*SHELL SECTION, ELSET=SKIN, COMPOSITE\n5.E-4, 3, CARBON, 35.\n.002, 3, FOAM, 0.\n5.E-4, 3, CARBON, 35.\n";
    let [half, whole] = [half, whole].map(|t| frequencies(&model(&abaqus(t)), 6));
    all_near(&half, &whole, 1e-9);
    let refused =
        import_keywords(&keywords_of(&abaqus(&PLIES.replace("FOAM, 0.", "FOAM, NONE"))), options(Solver::Abaqus));
    assert!(refused.unwrap_err()[0].to_string().contains("there is no orientation `NONE`"));
}

/// Thicknesses, angles and materials of plies go back into their items.
#[test]
fn changed_plies_go_back_into_their_items() {
    let deck = abaqus(PLIES);
    let cases: [(Edits<'_>, &[&str]); 3] = [
        (&[("angle: 35 deg", "angle: 40 deg")], &["5.E-4, 3, CARBON, 40"]),
        (&[("E: 7e9 Pa", "E: 8e9 Pa")], &["*ELASTIC\n8000000000., 0.3"]),
        (&[("imported:", "overrides: {skin: {stiffness: 1.1}}\nimported:")], &["143000000000."]),
    ];
    for (edits, expected) in cases {
        let (out, updated) = learnt(&deck, edits).unwrap_or_else(|e| panic!("{edits:?}: {e}"));
        for part in expected {
            assert!(out.files[0].contains(part), "`{part}` is not in\n{}", out.files[0]);
        }
        all_near(&frequencies(&model(&out.files[0]), 6), &frequencies(&updated, 6), 1e-9);
    }
    // Two laminates share a material, and one of them changes it.
    let both = abaqus(&format!(
        "*ELSET, ELSET=A\n1\n*ELSET, ELSET=B, GENERATE\n2, 24\n{}{}",
        PLIES.replace("SKIN", "A"),
        PLIES.replace("SKIN", "B")
    ));
    let both = both.replace("ELSET=SKIN\n", "\n").replace("*ELEMENT, TYPE=S4R, \n", "*ELEMENT, TYPE=S4R\n");
    let (out, updated) = learnt(&both, &[("imported:", "overrides: {s4r_1: {stiffness: 1.1}}\nimported:")]).unwrap();
    assert!(out.files[0].contains("5.E-4, 3, CARBON_R1, 35."), "{}", out.files[0]);
    all_near(&frequencies(&model(&out.files[0]), 6), &frequencies(&updated, 6), 1e-9);
}

/// pyNastran (PyPI, BSD) in a Python of its own; none where it is not installed.
fn pynastran(arguments: &[&str]) -> Option<Value> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/peers/pynastran.py");
    let python = std::env::var_os("RETUNE_PYTHON").unwrap_or_else(|| "python3".into());
    let run = |arguments: &[&str]| Command::new(&python).arg(&script).args(arguments).output();
    if !run(&["probe"]).is_ok_and(|o| o.status.success()) {
        assert!(std::env::var("RETUNE_PEERS").as_deref() != Ok("1"), "RETUNE_PEERS=1, and pyNastran is not there");
        eprintln!("skipped: python3 with pyNastran is not there (RETUNE_PYTHON)");
        return None;
    }
    let out = run(arguments).unwrap();
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    Some(serde_json::from_slice(&out.stdout).unwrap())
}

/// The rigidities, nodes, elements and mass that pyNastran reads in the same decks.
#[test]
fn pynastran_reads_the_same_laminates() {
    let folder = tempfile::tempdir().unwrap();
    for card in [
        "PCOMP,1\n,1,5.-4,0.,,1,5.-4,30.\n,1,.001,75.,,1,5.-4,-20.\n",
        "PCOMP,1,,,,,,,SYM\n,1,5.-4,0.,,1,5.-4,30.\n",
        "PCOMP,1,,1.5\n,1,5.-4,12.,,2,.002,0.\n,1,4.-4,-60.\nMAT1,2,7.+9,,.3,200.\n",
    ] {
        let text = clamped(card, "").replace("CEND", "SOL 103\nCEND");
        let path = folder.path().join("deck.bdf");
        std::fs::write(&path, &text).unwrap();
        let Some(peer) = pynastran(&["read", path.to_str().unwrap()]) else { return };
        let model = model(&text);
        let abd = &peer["laminates"]["1"];
        let own = |name: &str| value(&model, name);
        let size = [own("A11"), own("A11") * 1e-3, own("D11")];
        for (block, letter) in ["A", "B", "D"].into_iter().enumerate() {
            for (i, j, digits) in [(0, 0, "11"), (0, 1, "12"), (0, 2, "16"), (1, 1, "22"), (1, 2, "26"), (2, 2, "66")] {
                let (row, column) = ([0, 0, 3][block] + i, [0, 3, 3][block] + j);
                let theirs = abd[row][column].as_f64().unwrap();
                let ours = own(&format!("{letter}{digits}"));
                assert!((theirs - ours).abs() < 1e-9 * size[block], "{card} {letter}{digits}: {ours} {theirs}");
            }
        }
        let mass = model.mass_properties(&[]).unwrap().unwrap();
        near(mass.mass, peer["mass"].as_f64().unwrap(), 1e-9);
        assert_eq!(peer["elements"].as_array().unwrap().len(), model.elements().len());
        let nodes = peer["nodes"].as_object().unwrap();
        assert_eq!(nodes.len(), model.geometry().names.len());
        for (name, p) in model.geometry().names.iter().zip(&model.geometry().positions) {
            for (own, theirs) in p.iter().zip(nodes[&name[1..]].as_array().unwrap()) {
                assert!((own - theirs.as_f64().unwrap()).abs() < 1e-12, "{name}");
            }
        }
    }
}

/// CalculiX on the same mesh of eight-node shells, whose plies it expands into layers of bricks.
#[test]
fn calculix_finds_the_same_laminated_plate() {
    if Command::new("ccx").arg("-v").output().is_err() {
        eprintln!("skipped: CalculiX (`ccx`) is not installed");
        return;
    }
    let (n_x, n_y) = (12, 9);
    let id = |i: usize, j: usize| 1 + i + 100 * j;
    let mut elements = "*ELEMENT, TYPE=S8R, ELSET=SKIN\n".to_string();
    let mut used = std::collections::BTreeSet::new();
    for j in (0..2 * n_y).step_by(2) {
        for i in (0..2 * n_x).step_by(2) {
            let all = [[0, 0], [2, 0], [2, 2], [0, 2], [1, 0], [2, 1], [1, 2], [0, 1]].map(|p| [i + p[0], j + p[1]]);
            used.extend(all);
            let ids = all.map(|p| id(p[0], p[1]).to_string()).join(", ");
            let _ = writeln!(elements, "{}, {ids}", 1 + used.len());
        }
    }
    let (mut nodes, mut root) = ("*NODE, NSET=ALL\n".to_string(), "*NSET, NSET=ROOT\n".to_string());
    for p in &used {
        let _ =
            writeln!(nodes, "{}, {:.9}, {:.9}, 0.", id(p[0], p[1]), 0.4 * p[0] as f64 / 24.0, 0.3 * p[1] as f64 / 18.0);
        if p[0] == 0 {
            let _ = writeln!(root, "{},", id(p[0], p[1]));
        }
    }
    let orientation = |name: &str, degrees: f64| {
        let (s, c) = f64::to_radians(degrees).sin_cos();
        format!("*ORIENTATION, NAME={name}\n{c:.12}, {s:.12}, 0., {:.12}, {c:.12}, 0.\n", -s)
    };
    let text = format!(
        "{nodes}{elements}{root}{}{}{}*MATERIAL, NAME=CARBON\n*ELASTIC, TYPE=ENGINEERING CONSTANTS\n130.E9, 9.E9, 9.E9, 0.3, 0.3, 0.3, 5.E9, 5.E9,\n3.E9\n\
         *DENSITY\n1600.\n*SHELL SECTION, ELSET=SKIN, COMPOSITE\n.001, , CARBON, O0\n.001, , CARBON, O45\n.002, , CARBON, O90\n\
         *BOUNDARY\nROOT, 1, 6\n*STEP\n*FREQUENCY\n6\n*END STEP\n",
        orientation("O0", 0.0),
        orientation("O45", 45.0),
        orientation("O90", 90.0)
    );
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("job.inp"), &text).unwrap();
    let run = Command::new("ccx").arg("job").current_dir(folder.path()).output().unwrap();
    let dat = std::fs::read(folder.path().join("job.dat"))
        .unwrap_or_else(|e| panic!("{e}\n{}", String::from_utf8_lossy(&run.stdout)));
    let deck = import_keywords(&keywords_of(&text), options(Solver::CalculiX)).unwrap_or_else(|e| panic!("{}", e[0]));
    let found = compare_results(&model_of(&deck.text), &read_results(&dat).unwrap(), 6).unwrap();
    assert_eq!(found.modes.len(), 6);
    for m in &found.modes {
        assert!(m.relative().abs() < 0.01, "{}: {} {}", m.number, m.solver_hz, m.model_hz);
    }
}

/// The angle of one element, with THETA, with nothing and with an MCID in its field: the deck gives the model of it back, and no other line changes.
#[test]
fn angles_of_single_elements_go_back_into_the_deck() {
    let card = "PCOMP   1       0.\n        1       .0005   35.             2       .001    0.\n        1       .0005   -35.\nMAT1,2,7.+9,,.3,200.\nCORD2R,5,,0.,0.,0.,0.,0.,1.\n,1.,2.,0.\n";
    for element in ["", ",12.5", ",5"] {
        let deck = clamped(card, element);
        let before = imported(&deck).text;
        let edit = [("imported:", "overrides: {cquad4_6: {set: {angle: 0.31 rad}}}\nimported:")];
        let (out, updated) = learnt(&deck, &edit).unwrap_or_else(|e| panic!("{element}: {e}"));
        assert_eq!(out.changes.len(), 1, "{:?}", out.changes);
        let changed: Vec<_> = deck.lines().zip(out.files[0].lines()).filter(|(a, b)| a != b).collect();
        assert!(changed.len() == 1 && changed[0].0.starts_with("CQUAD4,6,"), "{changed:?}");
        let again = model(&out.files[0]);
        let text = imported(&out.files[0]).text;
        let line = text.lines().find(|l| l.contains("cquad4_6:")).unwrap();
        let angle: f64 = line.split("angle: ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
        // A field between commas has eight characters.
        assert!(out.rounding < 1e-6 && (angle - 0.31).abs() < PI * out.rounding + 1e-11, "{angle} of {}", out.files[0]);
        all_near(&frequencies(&again, 6), &frequencies(&updated, 6), 10.0 * out.rounding + 1e-9);
        // The angle is felt.
        let was = frequencies(&model_of(&before), 6);
        assert!(frequencies(&again, 6).iter().zip(&was).any(|(a, b)| (a / b - 1.0).abs() > 1e-5));
    }
    // Of a material without directions no field holds an angle.
    let plain = clamped("PSHELL,1,2,.002,2\nMAT1,2,7.+10,,.3,2700.\n", "");
    let found = learnt(&plain, &[("imported:", "overrides: {cquad4_6: {set: {angle: 0.31 rad}}}\nimported:")]);
    assert!(found.unwrap_err().to_string().contains("`angle` has no field"));
}
