//! A model that was updated and is still wrong: find the missing physics, add it, watch the error fall.
//!
//! ```text
//! cargo run --release --example hidden_effect
//! ```
//!
//! The first story is the flying wing of Gupta, Moreno, Pfifer and Balas. Its ground vibration test has measured frequencies
//! and synthetic shapes: the shapes come from a virtual aircraft with something in it that the model lacks, which is told at the end. The second is
//! the clamped wing of a cruise missile, all measured; it needs the data folder (see `RETUNE_DATA` in CONTRIBUTING.md).

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use retune::data::convert::{FrfOptions, UnitSystem, UnitsFrom};
use retune::data::{MeasurementOptions, Origin, Place, TestData, read_measurements, read_test};
use retune::identify::{IdentifyOptions, identify, sensors, test_modes};
use retune::model::{ParametricModel, Registry, load};
use retune::optim::Draw;
use retune_diagnosis::{Learned, Settings, learn};
use retune_report::text::{Align, Style, Table, number};
use retune_report::{html, of_learning};
use std::error::Error;
use std::path::{Path, PathBuf};

/// Seed of the noise of the synthetic shapes.
const SEED: u64 = 7;

/// Smallest standard deviations of the second story: of frequencies, and of shapes against their largest entry.
const FREQUENCY_FLOOR: f64 = 0.01;
const SHAPE_FLOOR: f64 = 0.03;

fn main() -> Result<(), Box<dyn Error>> {
    flying_wing()?;
    cruise_missile_wing()
}

fn flying_wing() -> Result<(), Box<dyn Error>> {
    println!("1. The flying wing: updated by its authors, and still wrong\n");
    let test = with_noise(parse("bff_gvt.yaml", |t| read_test(t).map(|(test, _)| test))?);
    let model = parse("bff_updated.yaml", |t| load(t, &Registry::builtin()).map(|(model, ..)| model))?;
    println!(
        "   Frequencies are MEASURED (Table 2 of the paper); mode shapes at 34 points are SYNTHETIC, with the noise that the file states.\n"
    );
    let learned = learn(&model, &test, &Settings::default(), true, 4)?;
    falling(&learned);
    let (Some(first), Some(last)) = (learned.steps.first(), learned.steps.last()) else { return Ok(()) };

    println!("   What a fit without the effect would have taught\n");
    let mut table = Table::new([
        ("parameter", Align::Left),
        ("without", Align::Right),
        ("", Align::Left),
        ("with", Align::Right),
        ("", Align::Left),
    ]);
    let at_bound = |i: usize, theta: &[f64]| first.model.parameters().get(i).at_bound(theta[i]);
    for (i, p) in first.model.parameters().iter().enumerate().filter(|(_, p)| p.bounds.is_some()) {
        let word = |theta: &[f64]| if at_bound(i, theta) { "on its bound" } else { "" };
        let show = |v: f64| format!("{} {}", number(p.display(v)), p.unit);
        if (first.theta[i] / last.theta[i] - 1.0).abs() > 0.05 || at_bound(i, &first.theta) {
            table.row(vec![
                p.name.as_str().into(),
                show(first.theta[i]).as_str().into(),
                word(&first.theta).into(),
                show(last.theta[i]).as_str().into(),
                word(&last.theta).into(),
            ]);
        }
    }
    print_table(&table);

    what_was_hidden(&learned)?;
    let mut data = of_learning(&[(&model, &test)], &learned)?;
    data.meta.title = "Body Freedom Flutter aircraft: the physics that the updated model misses".into();
    data.meta.commands.push("cargo run --release --example hidden_effect".into());
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/hidden_effect.html");
    std::fs::create_dir_all(page.with_file_name(""))?;
    std::fs::write(&page, html(&data)?)?;
    println!("   the same as a page with pictures: {}\n", page.display());
    Ok(())
}

/// The test with the noise in its shapes that it states: those in the file are exact, as no measured shape is.
fn with_noise(mut test: TestData) -> TestData {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    for mode in &mut test.modes {
        let (Some(shape), Some(sd)) = (&mut mode.shape, &mode.shape_sd) else { continue };
        for (v, sd) in shape.iter_mut().zip(sd.iter()) {
            v.re += sd * rng.normal();
        }
    }
    test
}

/// What the virtual aircraft has and the updated model lacks, as its file says it, and what was found.
fn what_was_hidden(learned: &Learned) -> Result<(), Box<dyn Error>> {
    let truth = parse("bff_truth.yaml", |t| load(t, &Registry::builtin()).map(|(model, ..)| model))?;
    let spec = truth.spec();
    let mut table = Table::new([("hidden in the virtual aircraft", Align::Left), ("truth", Align::Right)]);
    for (name, mass) in &spec.masses {
        let aft = mass.offset.as_ref().map(|o| o[0].constant_in("m")).transpose()?;
        let own = mass.mass.as_ref().and_then(|m| m.constant_in("kg").ok()).filter(|_| name.ends_with("_extra"));
        if let Some(kg) = own {
            table.row(vec![name.replace('_', " ").as_str().into(), format!("{} g", number(1e3 * kg)).as_str().into()]);
        } else if let Some(aft) = aft.filter(|a| *a != 0.0) {
            let what = format!("centres of gravity of the {} behind the spar", name.replace('_', " "));
            table.row(vec![what.as_str().into(), format!("{} mm", number(1e3 * aft)).as_str().into()]);
        }
    }
    for (name, change) in &spec.overrides {
        if let Some(factor) = change.scale.get("E").map(|s| s.constant_in("1")).transpose()? {
            let what = format!("stiffness of the {}", name.replace('_', " "));
            table.row(vec![what.as_str().into(), format!("{:+.0} %", 100.0 * (factor - 1.0)).as_str().into()]);
        }
    }
    println!("   At the end: what was hidden, and what was found\n");
    print_table(&table);
    let mut table = Table::new([("found", Align::Left), ("value", Align::Right), ("90 % interval", Align::Right)]);
    for s in learned.steps.iter().rev().find(|s| !s.sizes.is_empty()).into_iter().flat_map(|s| &s.sizes) {
        let [low, high] = s.interval.map(number);
        let unit = if s.unit == "1" { String::new() } else { format!(" {}", s.unit) };
        table.row(vec![
            s.parameter.as_str().into(),
            format!("{}{unit}", number(s.value)).as_str().into(),
            format!("{low} to {high}").as_str().into(),
        ]);
    }
    print_table(&table);
    println!(
        "   Several changes of one kind are found as one of their mean size: one offset for bodies that have two, one asymmetry for a softer"
    );
    println!(
        "   wing with extra grams on it. What stands for the rest of such a difference is tied with others above.\n"
    );
    Ok(())
}

fn cruise_missile_wing() -> Result<(), Box<dyn Error>> {
    println!("2. A clamped wing, everything MEASURED\n");
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let folder = std::env::var_os("RETUNE_DATA").map_or(beside, PathBuf::from).join("cruise_missile_wing/frf_csv");
    if !folder.exists() {
        println!("   skipped: {} is not there; set RETUNE_DATA to the folder of the real data", folder.display());
        return Ok(());
    }
    let units = |name: &str| UnitSystem::from_name(name).map(UnitsFrom::System);
    let (Some(si), Some(inches)) = (units("SI"), units("in-lbf-s")) else { return Ok(()) };
    let options = MeasurementOptions {
        frf: FrfOptions { units: si, ..FrfOptions::default() },
        geometry_units: Some(inches),
        ..MeasurementOptions::default()
    };
    let found = read_measurements(&[folder], None, &options)?;
    let Some(frfs) = &found.frfs else { return Ok(()) };
    let band = IdentifyOptions { band_hz: Some((5.0, 350.0)), ..IdentifyOptions::default() };
    let mut modes = test_modes(&identify(frfs, &band)?.modes, &Origin::Measured("accelerances".to_string()));
    for mode in &mut modes {
        // How well tests of one structure repeat, not how well one run is read: the floors are this example's choice.
        mode.frequency_hz.sd = mode.frequency_hz.sd.max(FREQUENCY_FLOOR * mode.frequency_hz.value);
        if let (Some(shape), Some(sd)) = (&mode.shape, &mut mode.shape_sd) {
            let largest = shape.iter().filter(|v| v.re.is_finite()).map(|v| v.norm()).fold(0.0, f64::max);
            sd.iter_mut().for_each(|sd| *sd = sd.max(SHAPE_FLOOR * largest));
        }
    }
    let mut places = sensors(frfs, None, None)?;
    for s in &mut places {
        // Points are numbered as the nodes of the model.
        s.place = Place::Node { node: format!("n{}", s.name), position: None };
    }
    let test = TestData { name: "clamped wing".to_string(), sensors: places, modes, ..TestData::default() };
    println!("   {} modes between 5 and 350 Hz from {} accelerances\n", test.modes.len(), frfs.responses.len());
    let grid = parse("cruise_missile_wing.yaml", |t| load(t, &Registry::builtin()).map(|(model, ..)| model))?;
    falling(&learn(&grid, &test, &Settings::default(), true, 4)?);
    println!(
        "   Standard deviations are those of the identification alone. A beam grid of a real wing errs by far more:"
    );
    println!("   what is found says where it errs first, and the verdict says what it leaves.");
    Ok(())
}

/// The steps of a learning: what was added and how the error fell.
fn falling(learned: &Learned) {
    let mut table = Table::new([
        ("step", Align::Left),
        ("misfit", Align::Right),
        ("held out", Align::Right),
        ("verdict", Align::Left),
        ("then", Align::Left),
    ]);
    for (i, s) in learned.steps.iter().enumerate() {
        let then = match (&s.added, &s.corrected) {
            (Some(c), _) => format!("add {}", c.id()),
            (_, Some(fault)) => format!("correct {fault}"),
            _ => String::new(),
        };
        let name = if i == 0 { "as given, refitted".to_string() } else { format!("{i} added") };
        table.row(vec![
            name.as_str().into(),
            format!("{:.0}", s.misfit).as_str().into(),
            format!("{:.0}", s.held_out.iter().sum::<f64>()).as_str().into(),
            s.diagnosis.verdict.word().into(),
            then.as_str().into(),
        ]);
    }
    print_table(&table);
    if let (Some(first), Some(last)) = (learned.steps.first(), learned.steps.last()) {
        println!("   noise alone would leave about {:.0}", last.diagnosis.degrees_of_freedom);
        println!("   the last model: {}", last.diagnosis.sentence);
        let ties = learned.steps.iter().filter(|s| !s.tie.is_empty());
        for s in ties {
            if let Some(c) = &s.added {
                println!("   the data cannot tell {} from {}", c.id(), s.tie.join(", "));
            }
        }
        println!("   the error fell {:.0} times\n", first.misfit / last.misfit.max(f64::MIN_POSITIVE));
    }
}

fn parse<T>(name: &str, read: impl Fn(&str) -> Result<T, Vec<retune::yaml::Problem>>) -> Result<T, Box<dyn Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(name);
    let text = std::fs::read_to_string(&path)?;
    read(&text).map_err(|p| p.iter().map(|p| p.render(name)).collect::<Vec<_>>().join("\n").into())
}

fn print_table(table: &Table) {
    for line in table.render(&Style { color: false, width: 110 }).lines() {
        println!("   {line}");
    }
    println!();
}
