//! The way of a deck through the command: import, proof, update by hand, export, import once more.

use crate::common::run;
use std::f64::consts::TAU;
use std::fs;

const DECK: &str = "\
SOL 103
CEND
TITLE = a cantilever with a tip mass
SPC = 1
BEGIN BULK
INCLUDE 'bars.dat'
$ tip mass
CONM2   3       2               2.
SPC1    1       123456  1
ENDDATA
";
const BARS: &str = "\
MAT1    1       2.+11   8.+10
GRID    1               0.      0.      0.
GRID    2               1.      0.      0.
CBAR    5       7       1       2       0.      0.      1.
PBAR    7       1       1.-3    4.-8    9.-8    1.-7
";

/// A page of printed output with f = √(3EI/(m L³))/2π in both planes; SYNTHETIC, by the closed form.
fn page(i1: f64) -> String {
    let lambda = |i: f64| 3.0 * 2e11 * i / 2.0;
    let row = |n: i32, i: f64| {
        let (l, w) = (lambda(i), lambda(i).sqrt());
        format!(
            "{n:>9}{n:>10}        {l:.6E}        {w:.6E}        {:.6E}        1.000000E+00        {l:.6E}\n",
            w / TAU
        )
    };
    format!(
        "1    PAGE 1\n          R E A L   E I G E N V A L U E S\n   MODE    EXTRACTION      EIGENVALUE\n{}{}",
        row(1, i1),
        row(2, 9e-8)
    )
}

#[test]
fn a_deck_goes_in_is_proved_and_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("wing.bdf"), DECK).unwrap();
    fs::write(at("BARS.DAT"), BARS).unwrap();
    fs::write(at("wing.f06"), page(4e-8)).unwrap();
    // Units are not guessed.
    let (code, out, _) = run(folder.path(), "import wing.bdf -o wing.yaml");
    assert!(code == 2 && out.contains("in-lbf-s") && out.contains("are not guessed"), "{out}");
    assert!(!at("wing.yaml").exists());
    let (code, out, err) = run(folder.path(), "import wing.bdf --units si -o wing.yaml");
    assert!(code == 0 && out.contains("1 CBAR"), "{out}{err}");
    let (code, out, err) = run(folder.path(), "check wing.yaml --against wing.f06");
    assert!(code == 0 && out.contains("the same model"), "{out}{err}");
    let text = fs::read_to_string(at("wing.yaml")).unwrap();
    assert!(text.contains("# tip mass") && text.contains("conm2_3: {node: n2, mass: 2 kg}"), "{text}");
    fs::write(at("updated.yaml"), text.replace("Iz: 4e-8 m4", "Iz: 5e-8 m4")).unwrap();
    let (code, out, _) = run(folder.path(), "check updated.yaml --against wing.f06");
    assert!(code == 1 && out.contains("not the same model"), "{out}");
    fs::create_dir(at("new")).unwrap();
    let (code, out, err) = run(folder.path(), "export updated.yaml --into wing.bdf -o new/wing.bdf");
    assert!(code == 0 && out.contains("I1: 4.-8 -> 5.-8"), "{out}{err}");
    assert_eq!(fs::read_to_string(at("new/wing.bdf")).unwrap(), DECK);
    assert_eq!(fs::read_to_string(at("new/BARS.DAT")).unwrap(), BARS.replace("4.-8", "5.-8"));
    fs::write(at("new/wing.f06"), page(5e-8)).unwrap();
    assert_eq!(run(folder.path(), "import new/wing.bdf --units si -o new/wing.yaml").0, 0);
    let (code, out, err) = run(folder.path(), "check new/wing.yaml --against new/wing.f06");
    assert!(code == 0, "{out}{err}");
}

#[test]
fn a_card_that_cannot_be_read_is_named_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("wing.bdf"), DECK).unwrap();
    fs::write(at("bars.dat"), format!("{BARS}CBEND   9       7       1       2\nCBAAR   8\n")).unwrap();
    let (code, _, err) = run(folder.path(), "import wing.bdf --units si -o wing.yaml");
    assert!(
        code == 2 && err.contains("bars.dat:6: CBEND 9: curved beams") && err.contains("did you mean `CBAR`?"),
        "{err}"
    );
    assert!(!at("wing.yaml").exists());
}

/// A mass on a spring in the manner of Abaqus; SYNTHETIC, f = √(k/m)/2π.
#[test]
fn a_deck_of_keywords_goes_in_and_is_proved() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(
        at("job.inp"),
        "*Heading\n a mass on a spring\n*Node\n1, 0., 0., 0.\n*Element, type=MASS, elset=m\n1, 1\n*Mass, elset=m\n2.,\n\
         *Element, type=SPRING1, elset=k\n2, 1\n*Spring, elset=k\n3\n800.\n** Name: guide Type: Displacement/Rotation\n*Boundary\n1, 1, 2\n1, 4, 6\n\
         *Step, perturbation\n*Frequency\n1,\n*Node file\nU\n*End step\n",
    )
    .unwrap();
    let lambda = 800.0 / 2.0_f64;
    fs::write(
        at("job.dat"),
        format!(
            "\n     E I G E N V A L U E   O U T P U T\n\n MODE NO    EIGENVALUE                       FREQUENCY\n\n      1   {lambda:.7E}   {:.7E}   {:.7E}   0.0000000E+00\n",
            lambda.sqrt(),
            lambda.sqrt() / TAU
        ),
    )
    .unwrap();
    let (code, out, err) = run(folder.path(), "import job.inp --units si -o job.yaml");
    assert!(code == 0 && out.contains("1 SPRING") && out.contains("1 NODE FILE"), "{out}{err}");
    let text = fs::read_to_string(at("job.yaml")).unwrap();
    assert!(
        text.contains("guide: {node: n1, fixed: [ux, uy, rx, ry, rz]}") && text.contains("format: abaqus"),
        "{text}"
    );
    let (code, out, err) = run(folder.path(), "check job.yaml --against job.dat");
    assert!(code == 0 && out.contains("the same model"), "{out}{err}");
    let (code, out, _) = run(folder.path(), "import job.inp -o other.yaml");
    assert!(code == 2 && out.contains("are not guessed"), "{out}");
    let (code, _, err) = run(folder.path(), "import job.inp --units si --step 2 -o other.yaml");
    assert!(code == 2 && err.contains("there is no step 2: the deck has 1"), "{err}");
    fs::write(at("stiffer.yaml"), text.replace("uz: 800 N/m", "uz: 900 N/m")).unwrap();
    let (code, out, err) = run(folder.path(), "export stiffer.yaml --into job.inp -o new.inp");
    assert!(code == 0 && out.contains("1 change; written: new.inp"), "{out}{err}");
    let deck = fs::read_to_string(at("job.inp")).unwrap();
    assert_eq!(fs::read_to_string(at("new.inp")).unwrap(), deck.replace("\n800.\n", "\n900.\n"));
}

/// A deck of many shells is a model file and a mesh of its name; another model of the deck has another mesh, and neither is written over.
#[test]
fn a_large_deck_has_a_mesh_for_each_model() {
    const N: usize = 45;
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let deck = |thickness: &str| {
        let mut text = format!("CEND\nSPC=1\nBEGIN BULK\nMAT1,1,7.+10,,.3,2700.\nPSHELL,5,1,{thickness},1,,1\n");
        for (j, i) in (0..=N).flat_map(|j| (0..=N).map(move |i| (j, i))) {
            text += &format!("GRID,{},,{:.1},{:.1}\n", 1 + i + j * (N + 1), 0.1 * i as f64, 0.1 * j as f64);
        }
        for (j, i) in (0..N).flat_map(|j| (0..N).map(move |i| (j, i))) {
            let a = 1 + i + j * (N + 1);
            text += &format!("CQUAD4,{},5,{a},{},{},{}\n", 1 + i + j * N, a + 1, a + N + 2, a + N + 1);
        }
        text + "SPC1,1,123456,1,THRU,46\nENDDATA\n"
    };
    fs::write(at("plate.bdf"), deck(".01")).unwrap();
    let (code, out, err) = run(folder.path(), "import plate.bdf --units si -o one.yaml");
    assert!(code == 0 && out.contains("one_mesh.msh") && out.contains("one.yaml"), "{out}{err}");
    assert!(fs::read_to_string(at("one.yaml")).unwrap().contains("file: \"one_mesh.msh\""));
    fs::write(at("plate.bdf"), deck(".02").replace("GRID,2116,,4.5,4.5", "GRID,2116,,4.6,4.5")).unwrap();
    assert_eq!(run(folder.path(), "import plate.bdf --units si -o two.yaml").0, 0);
    for (name, thickness) in [("one", "0.01 m"), ("two", "0.02 m")] {
        let (code, out, err) = run(folder.path(), &format!("check {name}.yaml"));
        assert!(code == 0 && out.contains(&format!("{name}_mesh.msh")), "{out}{err}");
        assert!(fs::read_to_string(at(&format!("{name}.yaml"))).unwrap().contains(thickness));
    }
    // The mesh of a model that is gone is not written over unasked.
    fs::remove_file(at("one.yaml")).unwrap();
    let (code, _, err) = run(folder.path(), "import plate.bdf --units si -o one.yaml");
    assert!(code == 2 && err.contains("one_mesh.msh exists; give --force"), "{err}");
    assert!(!at("one.yaml").exists());
    assert_eq!(run(folder.path(), "import plate.bdf --units si -o one.yaml --force").0, 0);
}
