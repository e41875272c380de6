//! Programs that compute the matrices of superelements: what is run, what comes of it, and what is said where that fails.
#![cfg(unix)]

use retune::modal::SolveOptions;
use retune::model::{Model, Registry, SOLVER_FOLDER, SolverRun, load_in, solve_modes, solver_runs};
use retune::yaml::Problem;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Two masses on springs k₁ = E t and k₂ = 40 N/m² t + 8 N/m⁴ t³, the stiffnesses of `writes`: as shell, so that it runs everywhere.
const PROGRAM: &str = r#"# E in kPa, t in mm
awk -v E={{E:kPa}} -v t={{t:mm}} 'BEGIN {
  E = 1000 * E; t = t / 1000
  one = ONE; two = 4e6 * t + 8e12 * t * t * t
  printf "%%%%MatrixMarket matrix coordinate real symmetric\n2 2 3\n1 1 %.17g\n2 1 %.17g\n2 2 %.17g\n", one + two, -two, two
}' > K.mtx
printf '%s\n' '%%MatrixMarket matrix coordinate real symmetric' '2 2 2' '1 1 2.0' '2 2 0.5' > M.mtx
printf '%s\n' node,dof,x,y,z 1,ux,0,0,0 2,ux,1,0,0 > dofs.csv
echo computed
"#;

const MODEL: &str = "
retune: 1
name: masses of a program
parameters: {E: {value: 3 kPa, bounds: [2 kPa, 5 kPa]}, t: {value: 1.4 mm, bounds: [1 mm, 3 mm]}}
superelements:
  s:
    solver:
      run: sh {file}
      template: job.sh.tpl
      writes: {k: K.mtx, m: M.mtx, dofs: dofs.csv}
      parameters: {t: {powers: [1, 3]}}
";

fn folder(name: &str, program: &str) -> tempfile::TempDir {
    let folder = tempfile::Builder::new().prefix(name).tempdir().unwrap();
    fs::write(folder.path().join("job.sh.tpl"), program).unwrap();
    folder
}

fn runs(folder: &Path, text: &str) -> Result<Vec<SolverRun>, Vec<Problem>> {
    solver_runs(text, &mut |file| fs::read(folder.join(file)))
}

fn load(folder: &Path, text: &str) -> Result<(Model, Vec<Problem>), Vec<Problem>> {
    let read = &mut |file: &str| fs::read(folder.join(file));
    load_in(text, None, &Registry::builtin(), read).map(|(model, warnings, _)| (model, warnings))
}

fn prepare(folder: &Path, text: &str) {
    for run in runs(folder, text).unwrap() {
        run.process.run(&folder.join(SOLVER_FOLDER), &|| false).unwrap();
    }
}

fn frequencies(model: &Model, theta: &[f64], n: usize) -> Vec<f64> {
    let found = solve_modes(model, theta, SolveOptions { n_elastic: n, shift: None }).unwrap();
    found.elastic().map(|i| found.frequency_hz(i)).collect()
}

/// Of the two masses, from the quadratic equation.
fn of_masses(one: f64, two: f64) -> [f64; 2] {
    let (m1, m2) = (2.0, 0.5);
    let (b, c) = ((one + two) / m1 + two / m2, one * two / (m1 * m2));
    let root = (b * b - 4.0 * c).sqrt();
    [0.5 * (b - root), 0.5 * (b + root)].map(|l| l.sqrt() / std::f64::consts::TAU)
}

/// Five runs give the matrices of all values in the bounds, with exact powers: to the digits that a run has.
#[test]
fn a_few_runs_give_the_matrices_of_every_value() {
    let folder = folder("solver", &PROGRAM.replace("ONE", "E"));
    let folder = folder.path();
    let wanted = runs(folder, MODEL).unwrap();
    let told: Vec<&str> = wanted.iter().map(|r| r.told.as_str()).collect();
    assert_eq!(
        told,
        [
            "E = 2.000 kPa, t = 1.000 mm",
            "E = 5.000 kPa, t = 1.000 mm",
            "E = 2.000 kPa, t = 2.000 mm",
            "E = 2.000 kPa, t = 3.000 mm",
            "E = 3.146 kPa, t = 1.764 mm"
        ]
    );
    // Before they ran the model says how they are made.
    let problems = load(folder, MODEL).unwrap_err();
    assert!(problems.len() == 1 && problems[0].path == "superelements.s.solver", "{problems:?}");
    assert!(
        problems[0].message.contains("5 of 5 runs of `sh job.sh`") && problems[0].message.contains("retune prepare")
    );

    prepare(folder, MODEL);
    let (model, warnings) = load(folder, MODEL).unwrap();
    assert!(warnings.iter().all(|w| !w.message.contains("terms")), "{warnings:?}");
    for [e, t] in [[2e3, 1e-3], [4.1e3, 2.6e-3], [5e3, 3e-3], [1e3, 4e-3]] {
        let expected = of_masses(e, 4e6 * t + 8e12 * t * t * t);
        for (found, expected) in frequencies(&model, &[e, t], 2).iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 1e-10, "E {e}, t {t}: {found} for {expected}");
        }
    }
    // What the program said is kept, and nothing else is left.
    let kept: Vec<_> = fs::read_dir(folder.join(SOLVER_FOLDER)).unwrap().map(|e| e.unwrap().path()).collect();
    assert_eq!(kept.len(), 5);
    assert!(kept.iter().all(|k| fs::read_to_string(k.join("log.txt")).unwrap() == "computed\n"));
    // Another program is another run.
    fs::write(folder.join("job.sh.tpl"), PROGRAM.replace("ONE", "2 * E")).unwrap();
    assert!(load(folder, MODEL).is_err());
}

/// Matrices that go with a product of parameters are not a sum of terms: the run that checks says by how much.
#[test]
fn terms_that_do_not_add_up_are_told() {
    let folder = folder("product", &PROGRAM.replace("ONE", "E * t * 1000"));
    prepare(folder.path(), MODEL);
    let (_, warnings) = load(folder.path(), MODEL).unwrap();
    let told = warnings.iter().find(|w| w.message.contains("the terms do not add up")).expect("a warning");
    // Change of k₁ at the point of the check: 3.146 · 1.764 - 2 = 3.5495 kN/m; of the terms: 1.146 + 2 · 0.764 = 2.674 kN/m. Beside it
    // stands the change of k₂, 4e6 · 0.764e-3 + 8e12 (1.764³ - 1) 1e-9 = 38 968 N/m, three times in the Frobenius norm of K.
    let (off, one, two) = (3549.5_f64 - 2674.0, 3549.5_f64, 38_967.6_f64);
    let expected = 100.0 * off / ((one + two).powi(2) + 3.0 * two.powi(2)).sqrt();
    assert!(told.path.ends_with("checks[0].k") && told.message.contains(&format!("{expected:.2} %")), "{told:?}");
}

#[test]
fn what_is_wrong_is_said_in_its_place() {
    let said = |program: &str, text: &str| {
        let folder = folder("wrong", program);
        let problems = runs(folder.path(), text).unwrap_err();
        assert_eq!(problems.len(), 1, "{problems:?}");
        format!("{}: {}", problems[0].path, problems[0].message)
    };
    let program = PROGRAM.replace("ONE", "E");
    let cases = [
        (
            said(&program.replace("{{t:mm}}", "{{tt:mm}}"), MODEL),
            "line 2: `{{tt}}` is not a parameter of the model; did you mean `t`?",
        ),
        (said(&program.replace("{{t:mm}}", "{{t}}"), MODEL), "say in which unit the program reads `t`: `{{t:MPa}}`"),
        (said(&program.replace("{{t:mm}}", "{{t:kg}}"), MODEL), "`kg` is not a unit of `t`"),
        (said(&program, &MODEL.replace("job.sh.tpl", "jab.tpl")), "`jab.tpl` cannot be read"),
        (said(&program, &MODEL.replace(", bounds: [1 mm, 3 mm]", "")), "`t` has no bounds"),
        (
            said(&program, &MODEL.replace("{powers: [1, 3]}", "{values: [1 mm]}")),
            "1 power needs 2 values, and 1 are given",
        ),
        (said(&program, &MODEL.replace("    solver:", "    k: K.mtx\n    solver:")), "`k` is what `solver` computes"),
        (
            said(&program, &MODEL.replace("{k: K.mtx, m: M.mtx, dofs: dofs.csv}", "{dofs: d.csv}")),
            "must write a stiffness matrix",
        ),
        (said(&program, &MODEL.replace("      parameters: {t", "      parameters: {Et: {}, t")), "has no `{{Et}}`"),
        (
            said(&program, &MODEL.replace("      parameters:", "      files: [../mesh.inc]\n      parameters:")),
            "must stand in the folder",
        ),
    ];
    for (said, expected) in cases {
        assert!(said.starts_with("superelements.s.") && said.contains(expected), "{said}");
    }
}

#[test]
fn a_run_that_fails_says_why_and_leaves_no_matrices() {
    let text = "retune: 1\nname: m\nsuperelements: {s: {solver: {run: sh job.sh, template: job.sh, writes: {k: K.mtx, dofs: d.csv}, time_limit: 0.2 s}}}\n";
    for (program, expected) in [
        ("echo first; echo no licence >&2; exit 3\n", "exit status: 3"),
        ("echo wrote nothing\n", "did not write `K.mtx`"),
        ("echo slow; sleep 20\n", "was stopped after 0.2 s, its time limit"),
    ] {
        let folder = folder("failing", program);
        fs::rename(folder.path().join("job.sh.tpl"), folder.path().join("job.sh")).unwrap();
        let run = runs(folder.path(), text).unwrap().remove(0);
        let kept = folder.path().join(SOLVER_FOLDER);
        let said = run.process.run(&kept, &|| false).unwrap_err().to_string();
        let last =
            program.lines().next().unwrap().split(['o', ';']).next().map(|_| ["no licence", "wrote nothing", "slow"]);
        assert!(said.contains(expected) && last.unwrap().iter().any(|l| said.contains(l)), "{said}");
        assert!(!run.process.is_there(&kept));
        // The log is where the message says it is.
        let log = said.split_once('(').unwrap().1.split_once(" has all").unwrap().0;
        assert!(Path::new(log).is_file(), "{log}");
    }
    let missing = text.replace("run: sh job.sh", "run: no-such-solver");
    let folder = folder("missing", "");
    fs::rename(folder.path().join("job.sh.tpl"), folder.path().join("job.sh")).unwrap();
    let run = runs(folder.path(), &missing).unwrap().remove(0);
    let said = run.process.run(&folder.path().join(SOLVER_FOLDER), &|| false).unwrap_err().to_string();
    assert!(said.contains("`no-such-solver` cannot be run"), "{said}");
    // A user who stops it leaves nothing behind.
    let slow = folder.path().join("job.sh");
    fs::write(slow, "sleep 20\n").unwrap();
    let run = runs(folder.path(), text).unwrap().remove(0);
    let kept = folder.path().join("stopped");
    assert!(run.process.run(&kept, &|| true).unwrap_err().to_string().starts_with("stopped"));
    assert_eq!(fs::read_dir(kept).unwrap().count(), 0);
}

/// CalculiX and OpenSees: from runs at two values of each parameter, the frequencies that they themselves have at others.
#[test]
fn programs_of_others_have_their_own_frequencies_between_the_runs() {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/peers/solver.py");
    let python = std::env::var_os("RETUNE_PYTHON").unwrap_or_else(|| "python3".into());
    for name in ["ccx", "opensees"] {
        let there = Command::new(&python).arg(&script).args(["probe", name]).output();
        if !there.is_ok_and(|o| o.status.success()) {
            eprintln!("skipped: {name} is not here (RETUNE_PYTHON, RETUNE_CCX)");
            continue;
        }
        let folder = tempfile::Builder::new().prefix(name).tempdir().unwrap();
        let made = Command::new(&python).arg(&script).args(["make", name]).arg(folder.path()).output().unwrap();
        assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
        let text = fs::read_to_string(folder.path().join("model.yaml")).unwrap();
        prepare(folder.path(), &text);
        let (model, warnings) = load(folder.path(), &text).unwrap();
        assert!(warnings.iter().all(|w| !w.message.contains("do not")), "{warnings:?}");
        let expected: serde_json::Value =
            serde_json::from_str(&fs::read_to_string(folder.path().join("expected.json")).unwrap()).unwrap();
        let numbers =
            |key: &str| -> Vec<f64> { expected[key].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect() };
        let (theta, expected) = (numbers("theta"), numbers("frequencies"));
        let found = frequencies(&model, &theta, expected.len());
        let off = found.iter().zip(&expected).map(|(f, e)| (f / e - 1.0).abs()).fold(0.0, f64::max);
        eprintln!("{name}: {} modes, largest relative difference {off:.1e}", found.len());
        assert!(off < 1e-8, "{found:?} for {expected:?}");
    }
}
