//! `retune twin`

use super::measured::{band, parameter_value};
use crate::args::Twin;
use crate::output::{Failure, print, print_json, shown, warn};
use crate::{DONE, files, writing};
use retune::catalogue::counted;
use retune::catalogue::did_you_mean;
use retune::correlation::sensor_position;
use retune::data::convert::{frf_file, geometry_file};
use retune::data::uff::{self, Dataset, Storage, UniversalFile};
use retune::data::{FrfQuantity, FrfSet, Geometry, Point, Sensor, csv, write_test};
use retune::model::{Model, ParametricModel};
use retune::update::{
    TwinFault, TwinFrfOptions, TwinOptions, TwinStory, driving_sensor, node_sensors, twin_frfs, twin_modes,
};
use retune::yaml::SourceMap;
use retune_report::answer;
use std::path::Path;

pub(crate) fn run(args: &Twin) -> Result<u8, Failure> {
    for output in args.output.iter().chain(&args.frf) {
        writing::check_output(output, args.overwrite.force)?;
    }
    if args.output.is_none() && args.frf.is_none() {
        return Err(Failure::text(
            "nothing to write: give `-o TEST.yaml` for modes, `--frf FILE.unv` for functions, or both",
        ));
    }
    let (mut model, warnings, text) = files::model(&args.model.path, args.model.configuration())?;
    warn(&args.model.path, &text, &warnings);
    if let Some(patch) = &args.patch {
        model = patched(&model, patch)?;
    }
    let theta = theta(&model, &args.set)?;
    let sensors = match &args.sensors {
        Some(path) => {
            let (test, warnings, text) = files::test(path)?;
            warn(path, &text, &warnings);
            test.sensors
        }
        None => node_sensors(&model),
    };
    let options = TwinOptions {
        n_modes: usize::from(args.modes),
        band_hz: band(args.band.as_deref())?,
        frequency_noise: args.noise_frequency.value,
        damping: args.damping,
        damping_noise: args.noise_damping.value,
        shape_noise: args.noise_shape.value,
        faults: args.fault.iter().map(|f| f.parse()).collect::<Result<Vec<TwinFault>, _>>()?,
        seed: args.random.seed,
    };
    let name = |path: &Path| path.file_name().map(|f| f.to_string_lossy().into_owned()).unwrap_or_default();
    let (file, patch) = (name(&args.model.path), args.patch.as_deref().map(name));
    let story = TwinStory {
        model: &model.spec().name,
        file: &file,
        patch: patch.as_deref(),
        set: &args.set,
        faults: &args.fault,
        noise_frequency: &args.noise_frequency.text,
        noise_shape: &args.noise_shape.text,
        seed: args.random.seed,
    };
    let source = story.text();
    let mut summary = Vec::new();
    let mut n_modes = None;
    if let Some(output) = &args.output {
        let mut test = twin_modes(&model, &theta, &sensors, &options, &source)?;
        story.sign(&mut test, args.model.configuration());
        n_modes = Some(test.modes.len());
        if writing::write(output, &write_test(&test)) {
            summary.push(format!(
                "written: {} ({} at {})",
                shown(output),
                counted(test.modes.len(), "synthetic mode"),
                counted(sensors.len(), "sensor")
            ));
        }
    }
    let mut n_functions = None;
    if let Some(output) = &args.frf {
        let set = functions(args, &model, &theta, &sensors, &options)?;
        n_functions = Some(set.references.len() * set.responses.len());
        write_functions(output, &set, &model, &sensors, &source)?;
        summary.push(format!(
            "written: {} ({} of {})",
            output.display(),
            counted(set.references.len() * set.responses.len(), "synthetic function"),
            counted(set.n_lines(), "line")
        ));
    }
    if args.print.json {
        print_json(&answer::twin(n_modes, n_functions, sensors.len(), args.random.seed, &source));
    } else {
        print(&format!("{}\n", summary.join("\n")));
    }
    Ok(DONE)
}

fn patched(model: &Model, path: &Path) -> Result<Model, Failure> {
    let text = files::read(path)?;
    let spec = model.spec().overlaid(&text).map_err(|p| Failure::problems(path, &text, &p))?;
    let (model, _) = Model::new(spec, model.registry())
        .map_err(|p| Failure::problems(path, &text, &SourceMap::of(&text).place(p)))?;
    Ok(model)
}

/// The estimates, with the parameters of `--set`.
fn theta(model: &Model, set: &[String]) -> Result<Vec<f64>, Failure> {
    let parameters = model.parameters();
    let mut theta = parameters.nominal();
    for text in set {
        let (name, value) =
            text.split_once('=').ok_or_else(|| Failure::text(format!("--set {text}: expected `parameter=value`")))?;
        let index = parameters.index_of(name.trim()).ok_or_else(|| {
            let names = parameters.names().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ");
            let suggestion = did_you_mean(name, parameters.names());
            Failure::text(format!("--set: there is no parameter `{name}`{suggestion}; the model has {names}"))
        })?;
        theta[index] = parameter_value("--set", value, parameters.get(index))?;
    }
    Ok(theta)
}

fn functions(
    args: &Twin,
    model: &Model,
    theta: &[f64],
    sensors: &[Sensor],
    options: &TwinOptions,
) -> Result<FrfSet, Failure> {
    let Some((low, high)) = options.band_hz else {
        return Err(Failure::text("functions need a band: give `--band LOW HIGH`"));
    };
    let n = usize::from(args.lines);
    let exciters: Vec<String> = if args.exciter.is_empty() && !sensors.is_empty() {
        let best = sensors[driving_sensor(model, theta, sensors, (low, high))?].name.clone();
        note!("the force acts at {best}, where it drives the modes of the band best; `--exciter` chooses another");
        vec![best]
    } else {
        args.exciter.clone()
    };
    let frf = TwinFrfOptions {
        lines_hz: (0..n).map(|k| low + (high - low) * k as f64 / (n - 1) as f64).collect(),
        exciters,
        quantity: args.quantity.unwrap_or(FrfQuantity::Accelerance),
        force_noise: args.noise_force.value,
        response_noise: args.noise_response.value,
        n_averages: usize::from(args.averages),
    };
    Ok(twin_frfs(model, theta, sensors, options, &frf)?)
}

fn write_functions(path: &Path, set: &FrfSet, model: &Model, sensors: &[Sensor], story: &str) -> Result<bool, Failure> {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv")) {
        return Ok(writing::write(path, &format!("# SYNTHETIC: {story}\n{}", csv::write_frfs(set))));
    }
    let functions = frf_file(set, Storage::Ascii)
        .map_err(|e| Failure::text(format!("{e}; write a table instead: `--frf FILE.csv`")))?;
    // The points in the order of the functions' channels, so that both count labels alike.
    let mut geometry = Geometry::default();
    for name in set.references.iter().chain(&set.responses).map(|c| &c.name) {
        if geometry.point(name).is_none()
            && let Some(sensor) = sensors.iter().find(|s| s.name == *name)
        {
            let position_m = sensor_position(model, sensor)?;
            geometry.points.push(Point { name: name.clone(), position_m, axes: Point::GLOBAL });
        }
    }
    let mut datasets = geometry_file(&geometry).datasets;
    datasets.extend(functions.datasets.into_iter().map(|d| match d {
        Dataset::Function(mut f) => {
            f.ids[1] = "SYNTHETIC".to_string();
            // A line of the format holds 80 characters.
            f.ids[2] = story.chars().filter(char::is_ascii).take(80).collect();
            Dataset::Function(f)
        }
        other => other,
    }));
    let (bytes, notes) = uff::write(&UniversalFile { datasets })?;
    // Rounding in the last digit of a double is no news.
    for note in notes.iter().filter(|n| n.level > uff::Level::Info) {
        note!("{note}");
    }
    let text = String::from_utf8(bytes).map_err(|e| Failure::text(format!("universal file: {e}")))?;
    Ok(writing::write(path, &text))
}
