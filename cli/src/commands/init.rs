//! `retune init`

use super::import::{AnyDeck, choices};
use crate::args::{Init, InitOf};
use crate::output::{Failure, print, shown};
use crate::{DONE, WRONG_INPUT, files, schemas, writing};
use retune::data::{Sensor, write_test};
use retune::model::{Model, ParametricModel, Registry, load_in};
use retune::update::{TwinOptions, TwinStory, node_sensors, twin_modes};
use retune_exchange::{ImportOptions, MeshFile, SYSTEMS, Solver, System};
use std::path::{Path, PathBuf};

const OBJECTIVE: &str = include_str!("../templates/objective.yaml");

/// Model and test of a structure.
fn templates(of: InitOf) -> [&'static str; 2] {
    match of {
        InitOf::Beam => [include_str!("../templates/beam.yaml"), include_str!("../templates/beam_test.yaml")],
        InitOf::Frame => [include_str!("../templates/frame.yaml"), include_str!("../templates/frame_test.yaml")],
        InitOf::Aircraft => {
            [include_str!("../templates/aircraft.yaml"), include_str!("../templates/aircraft_test.yaml")]
        }
    }
}

/// What is written.
struct Project {
    model: String,
    test: Option<String>,
    mesh: Option<MeshFile>,
    has_parameters: bool,
}

pub(crate) fn run(args: &Init) -> Result<u8, Failure> {
    let folder = &args.output;
    let is_here = folder == Path::new(".");
    let at = |name: &str| if is_here { PathBuf::from(name) } else { folder.join(name) };
    let schema_files = schemas::ALL.map(|(of, name)| (at(&format!("schemas/{name}")), of));
    // What is there stays, whatever it is, and nothing is written beside it.
    let named = ["model.yaml", "test.yaml", "objective.yaml"].map(at);
    let there = |path: &PathBuf| std::fs::symlink_metadata(path).is_ok();
    if let Some(path) = named.iter().chain(schema_files.iter().map(|(path, _)| path)).find(|path| there(path)) {
        return Err(Failure::text(format!(
            "{} is there already, and `init` overwrites nothing: give another folder by `-o FOLDER`",
            shown(path)
        )));
    }
    let (project, report) = match (&args.deck, args.structure) {
        (Some(deck), _) => match of_deck(deck, args.units)? {
            Ok(found) => found,
            Err(choices) => {
                print(&choices);
                return Ok(WRONG_INPUT);
            }
        },
        (None, structure) => {
            let [model, test] = templates(structure.unwrap_or(InitOf::Beam)).map(str::to_string);
            (Project { model, test: Some(test), mesh: None, has_parameters: true }, String::new())
        }
    };
    let mut outputs = vec![(at("model.yaml"), project.model)];
    outputs.extend(project.test.map(|test| (at("test.yaml"), test)));
    let has_test = outputs.len() == 2;
    outputs.push((at("objective.yaml"), OBJECTIVE.to_string()));
    outputs.extend(project.mesh.map(|mesh| (at(&mesh.name), mesh.text)));
    outputs.extend(schema_files.into_iter().map(|(path, of)| (path, format!("{:#}\n", schemas::schema(of)))));
    std::fs::create_dir_all(at("schemas"))
        .map_err(|e| Failure::text(format!("cannot make the folder {}: {e}", shown(folder))))?;
    for (path, text) in &outputs {
        writing::check_room(path, false, text.len())?;
    }
    let mut out = report;
    for (path, text) in &outputs {
        if writing::write(path, text) && path.extension().is_some_and(|e| e == "yaml" || e == "msh") {
            out += &format!("written: {}\n", shown(path));
        }
    }
    out += &format!("written: {} (for editors; every file names its own)\n\nNext:\n", shown(&at("schemas")));
    if !is_here {
        out += &format!("  cd {}\n", shown(folder));
    }
    out += "  retune check model.yaml\n  retune modes model.yaml\n";
    if has_test {
        out += "  retune compare model.yaml test.yaml\n";
        if project.has_parameters {
            out += "  retune update model.yaml test.yaml -o updated.yaml --report update.html\n";
            out += "  retune diagnose updated.yaml test.yaml\n";
        }
    }
    print(&out);
    Ok(DONE)
}

/// What a deck becomes, and what was read of it; or the choice of units, where none was made.
fn of_deck(path: &Path, units: Option<&'static System>) -> Result<Result<(Project, String), String>, Failure> {
    let deck = AnyDeck::read(path)?;
    let options =
        |system| ImportOptions { system, subcase: None, parameter_per_property: true, solver: Solver::Abaqus };
    let Some(system) = units else { return Ok(Err(choices(&deck.import(options(&SYSTEMS[0]))?)?)) };
    let imported = deck.import(options(system))?;
    let file = path.file_name().map(|f| f.to_string_lossy().into_owned()).unwrap_or_default();
    let text = format!(
        "# yaml-language-server: $schema=schemas/model.schema.json\n\
         #\n\
         # Made of the deck {file}. Every property has a parameter: a factor on the stiffness of its elements, within bounds that an\n\
         # update keeps to. `retune export updated.yaml --into {file} -o updated.bdf` writes what was learnt back.\n{}",
        imported.text
    );
    let model = match load_in(&text, None, &Registry::builtin(), &mut |file| imported.file(file)) {
        Ok((model, ..)) => model,
        Err(problems) => return Err(Failure::problems(path, &text, &problems)),
    };
    if text.len() as u64 > files::LARGEST {
        return Err(Failure::text(format!(
            "{}: its model file would be larger than 16 MiB, more than other verbs read: give a coarser mesh",
            shown(path)
        )));
    }
    let has_parameters = !model.parameters().free().is_empty();
    let test = test_of(&model)?;
    Ok(Ok((Project { model: text, test, mesh: imported.mesh, has_parameters }, format!("{}\n", imported.report))))
}

/// Sensors of the test of a deck, at most: enough to tell its lowest modes apart, and few enough to read.
const SENSORS: usize = 24;
/// Modes of it, at most.
const MODES: usize = 6;

/// A synthetic test of a model; none where it has no node that moves, or no mode.
fn test_of(model: &Model) -> Result<Option<String>, Failure> {
    let all = node_sensors(model);
    // Not every third one, which would read one direction alone.
    let every = all.len().div_ceil(SENSORS).max(1);
    let every = if every.is_multiple_of(3) { every + 1 } else { every };
    let sensors: Vec<Sensor> = all.into_iter().step_by(every).collect();
    let options = TwinOptions {
        n_modes: MODES,
        frequency_noise: 0.002,
        shape_noise: 0.01,
        damping: Some(0.01),
        seed: 1,
        ..TwinOptions::default()
    };
    let story = TwinStory {
        model: &model.spec().name,
        file: "model.yaml",
        patch: None,
        set: &[],
        faults: &[],
        noise_frequency: "0.2 %",
        noise_shape: "1 %",
        seed: 1,
    };
    if sensors.is_empty() {
        return Ok(None);
    }
    let mut test = twin_modes(model, &model.parameters().nominal(), &sensors, &options, &story.text())?;
    if test.modes.is_empty() {
        return Ok(None);
    }
    story.sign(&mut test, None);
    Ok(Some(format!(
        "# yaml-language-server: $schema=schemas/test.schema.json\n\
         #\n\
         # A SYNTHETIC test, so that every command can be tried at once: the model's own modes with noise of 0.2 % in frequencies and\n\
         # 1 % in shapes. Replace it by a test of your own: `retune identify run1.unv run2.unv --model model.yaml -o test.yaml`.\n{}",
        write_test(&test)
    )))
}
