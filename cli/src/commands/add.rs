//! `retune add` and `retune undo`

use crate::args::{Add, Undo};
use crate::output::{Failure, print, warn};
use crate::{DONE, files};
use retune::diagnosis::{FAULTS, sensor_loads};
use retune::effect::{Context, Effects, PatchError, Structure, undo};
use std::path::Path;

pub(crate) fn run(args: &Add) -> Result<u8, Failure> {
    let (model, warnings, text) = files::model(&args.model, None)?;
    warn(&args.model, &text, &warnings);
    let mut context = Context::default();
    if let Some(path) = &args.test {
        let (mut test, warnings, test_text) = files::test(path)?;
        let (tested, ..) = files::tested_model(&args.model, None, (&mut test, path, &test_text))?;
        files::check_sensors(&tested, &test, path, &test_text)?;
        warn(path, &test_text, &warnings);
        context.sensors = sensor_loads(&tested, &test.sensors)?;
    }
    let structure = Structure::new(&model, &context);
    let candidate = Effects::builtin().candidate(&structure, &args.effect).map_err(|e| refused(&args.effect, e))?;
    if args.dry_run {
        print(&candidate.patch.to_yaml());
        return Ok(DONE);
    }
    let edited = candidate.patch.add_to_text(&text, &candidate.id(), &args.because)?;
    let output = output(&args.model, args.output.as_deref(), args.force)?;
    files::write(output, &edited)?;
    print(&format!("{}: {} added at its neutral value\n", output.display(), candidate.id()));
    Ok(DONE)
}

/// Why an effect cannot be added, and what to do instead.
fn refused(effect: &str, error: PatchError) -> Failure {
    let name = effect.split('@').next().unwrap_or_default();
    match error {
        PatchError::UnknownEffect { .. } if FAULTS.iter().any(|f| f.name == name) => Failure::text(format!(
            "`{name}` is a fault of the measurement and no effect of the structure: mend it in the test file (`retune explain {name}`)"
        )),
        PatchError::NoSensors { .. } => Failure::text(format!("{error} by `--test TEST`")),
        _ => error.into(),
    }
}

/// The model file, or another one, which must not exist yet or may be overwritten.
fn output<'a>(model: &'a Path, other: Option<&'a Path>, force: bool) -> Result<&'a Path, Failure> {
    let Some(other) = other else { return Ok(model) };
    files::check_output(other, force || other == model)?;
    Ok(other)
}

pub(crate) fn run_undo(args: &Undo) -> Result<u8, Failure> {
    let text = files::read(&args.model)?;
    let undone = undo(&text)?;
    let output = output(&args.model, args.output.as_deref(), args.force)?;
    files::write(output, &undone.text)?;
    print(&format!("{}: {} taken out\n", output.display(), undone.entry.add));
    for path in undone.missing {
        eprintln!("warning: `{path}` was gone already");
    }
    Ok(DONE)
}
