//! Folders of other people's decks of Nastran: each is read, or says by card and line why not.
//!
//! `RETUNE_DECKS` names a folder, such as `models` of pyNastran's repository (BSD); its decks are not part of this package. Without it the
//! tests skip with a message. `cargo test --test all deck_folders -- --nocapture` prints a line for every deck.

use retune::deck::Deck;
use retune::model::{ParametricModel, Registry};
use retune_exchange::{ImportOptions, Solver, import, system_by_name};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

fn folder() -> Option<PathBuf> {
    let folder = std::env::var_os("RETUNE_DECKS").map(PathBuf::from);
    if folder.is_none() {
        eprintln!("skipped: RETUNE_DECKS names no folder of decks");
    }
    folder
}

/// Files below a folder whose names and texts are those of whole decks, in order.
fn decks_of(folder: &Path, out: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            decks_of(&path, out);
            continue;
        }
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        if !matches!(extension.as_str(), "bdf" | "dat" | "nas" | "fem") {
            continue;
        }
        let text = std::fs::read(&path).unwrap();
        let text = String::from_utf8_lossy(&text).to_uppercase();
        // Pieces that others include have neither.
        if text.lines().any(|l| l.trim_start().starts_with("BEGIN") || l.trim() == "CEND") {
            out.push(path);
        }
    }
}

/// What became of a deck: the mass of its model in the units of the deck, or why there is none.
fn outcome(path: &Path) -> Result<f64, String> {
    let deck = Deck::read(path, &mut |p| std::fs::read(p)).map_err(|e| e.to_string())?;
    let options = ImportOptions {
        system: system_by_name("si").unwrap(),
        subcase: None,
        parameter_per_property: false,
        solver: Solver::default(),
    };
    let imported = import(&deck, options).map_err(|e| e[0].to_string())?;
    let (model, ..) = imported
        .load(&Registry::builtin())
        .unwrap_or_else(|p| panic!("{}: what was imported is not a model: {}", path.display(), p[0]));
    let theta = model.parameters().nominal();
    Ok(model.mass_properties(&theta).unwrap().map_or(0.0, |m| m.mass))
}

/// Masses that pyNastran finds, by deck; none of a deck that it does not read, nothing at all where it is not installed.
fn pynastran(paths: &[&Path]) -> Option<BTreeMap<String, Option<f64>>> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/peers/pynastran.py");
    let python = std::env::var_os("RETUNE_PYTHON").unwrap_or_else(|| "python3".into());
    let run = |arguments: &[&Path]| Command::new(&python).arg(&script).args(arguments).output();
    if !run(&[Path::new("probe")]).is_ok_and(|o| o.status.success()) {
        eprintln!("skipped: python3 with pyNastran is not there (RETUNE_PYTHON)");
        return None;
    }
    let out = run(&[&[Path::new("masses")], paths].concat()).unwrap();
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    Some(serde_json::from_slice(&out.stdout).unwrap())
}

/// No deck of a folder panics, hangs or becomes a file that is not a model; what is refused names a file and, but for empty ones, a line; masses are
/// those of pyNastran.
#[test]
fn every_deck_of_a_folder_is_read_or_says_why_not() {
    let Some(folder) = folder() else { return };
    let mut paths = Vec::new();
    decks_of(&folder, &mut paths);
    assert!(!paths.is_empty(), "{} has no decks", folder.display());
    let mut read: Vec<(&Path, f64)> = Vec::new();
    let mut slowest = (0.0, Path::new(""));
    for path in &paths {
        let start = Instant::now();
        let found = outcome(path);
        let seconds = start.elapsed().as_secs_f64();
        if seconds > slowest.0 {
            slowest = (seconds, path);
        }
        let shown = path.strip_prefix(&folder).unwrap_or(path).display();
        match found {
            Ok(mass) => {
                println!("read     {shown}: mass {mass:.6e}");
                read.push((path, mass));
            }
            Err(why) => {
                println!("refused  {shown}: {}", why.lines().next().unwrap_or_default());
                let places = why.split(':').filter(|part| part.trim().parse::<usize>().is_ok()).count();
                let is_whole = why.contains("the deck has no GRID") || why.contains("there are no bulk data in it");
                assert!(places > 0 || is_whole, "{shown}: {why}");
            }
        }
    }
    println!(
        "{} of {} decks became models; the slowest took {:.1} s: {}",
        read.len(),
        paths.len(),
        slowest.0,
        slowest.1.display()
    );
    let own: Vec<&Path> = read.iter().map(|r| r.0).collect();
    let Some(peer) = pynastran(&own) else { return };
    let (mut same, mut halves, mut other) = (0, 0, 0);
    for (path, mass) in &read {
        let Some(Some(theirs)) = peer.get(&path.display().to_string()) else { continue };
        if (mass - theirs).abs() <= 1e-6 * mass.abs().max(theirs.abs()) {
            same += 1;
        } else if (2.0 * mass - theirs).abs() <= 1e-6 * theirs.abs() {
            // It doubles half aeroplanes where AERO says that they are.
            halves += 1;
        } else {
            other += 1;
            println!(
                "mass     {}: {mass:.6e}, pyNastran {theirs:.6e}",
                path.strip_prefix(&folder).unwrap_or(path).display()
            );
        }
    }
    println!("masses of {same} decks are those of pyNastran, of {halves} the half, of {other} others");
    assert!(same > 9 * other, "{other} of {} masses differ", same + other);
}
