//! `retune add` and `retune undo`

use crate::args::{Add, Undo};
use crate::output::{Failure, print, shown, warn};
use crate::{DONE, files, writing};
use retune::effect::{Context, Effects, PatchError, Structure, undo};
use retune::fault::{FAULTS, Fault};
use retune_diagnosis::sensor_loads;
use retune_report::text::printable;
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
    if let Some(output) = write(&args.model, args.output.as_deref(), args.overwrite.force, &edited)? {
        print(&format!("{}: {} added at its neutral value\n", shown(output), candidate.id()));
    }
    Ok(DONE)
}

/// Why an effect cannot be added, and what to do instead.
fn refused(effect: &str, error: PatchError) -> Failure {
    let name = effect.split('@').next().unwrap_or_default();
    match error {
        PatchError::UnknownEffect { .. } if FAULTS.iter().any(|f| Fault::name(*f) == name) => Failure::text(format!(
            "`{name}` is a fault of the measurement and no effect of the structure: mend it in the test file (`retune explain {name}`)"
        )),
        PatchError::NoSensors { .. } => Failure::text(format!("{error} by `--test TEST`")),
        _ => error.into(),
    }
}

/// Writes the model file anew, or another one, which must not exist yet or may be overwritten; where it was written.
fn write<'a>(model: &'a Path, other: Option<&'a Path>, force: bool, text: &str) -> Result<Option<&'a Path>, Failure> {
    let is_model = |path: &Path| matches!((path.canonicalize(), model.canonicalize()), (Ok(a), Ok(b)) if a == b);
    match other.filter(|path| !is_model(path)) {
        None => {
            let path = other.unwrap_or(model);
            writing::edit(path, text)?;
            Ok(Some(path))
        }
        Some(path) => {
            writing::check_output(path, force)?;
            Ok(writing::write(path, &files::beside(text, model, path)?).then_some(path))
        }
    }
}

pub(crate) fn run_undo(args: &Undo) -> Result<u8, Failure> {
    let text = files::read(&args.model)?;
    let undone = undo(&text)?;
    if let Some(output) = write(&args.model, args.output.as_deref(), args.overwrite.force, &undone.text)? {
        print(&format!("{}: {} taken out\n", shown(output), printable(&undone.entry.add)));
    }
    for path in undone.missing {
        warning!("`{path}` was gone already");
    }
    Ok(DONE)
}
