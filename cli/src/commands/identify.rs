//! `retune identify`

use super::measured::{band, findings_text, has_fault, read, wrapped};
use crate::args::Identify;
use crate::output::{Failure, print, print_json, remarks, shown, style, warn};
use crate::page::{Outputs, announce, provenance};
use crate::{DONE, SHORT, files, writing};
use retune::catalogue::{Choice, counted};
use retune::data::{FrfSet, Measurements, TestData, TestMode, write_test};
use retune::identify::{
    Identification, IdentifyOptions, PeakOptions, REPEATABILITY, SpectrumPeak, cmif, complexity, spectrum_peaks,
};
use retune::units::Scalar;
use retune::update::{About, Identified, IdentifySettings, Method, Way, Window, identify_test};
use retune_report::text::{Align, Cell, Style, Table, Tone, hertz};
use retune_report::{answer, of_identification};
use std::fmt::Write as _;
use std::path::Path;

/// Phase collinearity below which a shape is called complex.
const COMPLEX: f64 = 0.9;
/// Inflation of standard deviations above which the remainder is called coloured.
const COLOURED: f64 = 3.0;
/// Most peaks of a spectrum that the table shows.
const PEAKS_SHOWN: usize = 30;

pub(crate) fn run(args: &Identify) -> Result<u8, Failure> {
    if let Some(output) = &args.output {
        writing::check_output(output, args.overwrite.force)?;
    }
    let outputs = Outputs { page: args.report.as_ref(), force: args.overwrite.force, ..Outputs::default() };
    outputs.check()?;
    let found = read(&args.files, &args.measurement)?;
    let is_held = found.frfs.is_none() && found.spectra.is_empty() && found.modes.is_some();
    if is_held && (args.band.is_some() || args.method != Method::Plscf || args.repeatability.is_some()) {
        return Err(Failure::text(
            "`--band`, `--method` and `--repeatability` identify modes from functions; these files hold modes, which are taken over as they are (`defaults: {frequency_sd: 0.3 %}` in the test file says how far to trust them)",
        ));
    }
    let settings = IdentifySettings {
        options: IdentifyOptions {
            band_hz: band(args.band.as_deref())?,
            max_order: usize::from(args.order),
            ..IdentifyOptions::default()
        },
        method: args.method,
        peak_height_db: args.peak_height,
        n_suspension: usize::from(args.suspension),
        window: match args.exponential_window.as_deref().map(window_rate).transpose()? {
            None => Window::Stated,
            Some(None) => Window::None,
            Some(Some(rate)) => Window::Rate(rate),
        },
        repeatability: args.repeatability.unwrap_or(REPEATABILITY),
        checks_health: !args.no_health,
    };
    let is_spectrum = found.frfs.is_none() && !found.spectra.is_empty();
    let model = args.model.as_deref().filter(|_| !is_spectrum).map(|path| {
        let (model, warnings, text) = files::model(path, args.configuration.as_deref())?;
        warn(path, &text, &warnings);
        Ok::<_, Failure>(model)
    });
    let model = model.transpose()?;
    let identified = identify_test(&found, &about(args), model.as_ref(), &settings)?;
    remarks(None, &identified.remarks);
    if args.print.json {
        print_json(&answer::identified(&identified));
    } else {
        let style = style(&std::io::stdout());
        let mut out = match &identified.way {
            Way::Functions { frfs, identification, .. } => {
                head(frfs, &found)
                    + &table(&identified.modes, identification, settings.n_suspension, &style)
                    + &diagram(frfs, identification)?
            }
            Way::Held { channels } => held(&identified, channels.len(), &style),
            Way::Peaks(all) => peaks(all, &style),
        };
        if !args.no_health && !is_spectrum {
            out += "\n";
            out += &findings_text(&identified.findings, &style);
        }
        print(&out);
    }
    if let Some(output) = &args.output {
        if let Way::Peaks(all) = &identified.way
            && all.len() != 1
        {
            return Err(Failure::text(format!("{} spectra: write a test file of one at a time", all.len())));
        }
        if let Some(lacks) = identified.test_lacks {
            return Err(lacks.into());
        }
        write(output, &identified.test, args);
    }
    if args.report.is_some() {
        let Some(mut data) = of_identification(&identified)? else {
            return Err(Failure::text(
                "--report shows how modes come from functions with a force; these files have none",
            ));
        };
        data.meta.warnings.extend(identified.remarks.iter().map(|r| r.text().to_string()));
        let read: Vec<(&str, &Path)> = args.files.iter().map(|path| ("measurement", path.as_path())).collect();
        provenance(&mut data, &read, None);
        let written = outputs.write(&data)?;
        if !args.print.json {
            announce(&written);
        }
    }
    let is_short = has_fault(&identified.findings) || (identified.modes.is_empty() && !is_spectrum && !is_held);
    Ok(if is_short { SHORT } else { DONE })
}

/// What the test file says of itself.
fn about(args: &Identify) -> About {
    let stem = args.files.first().and_then(|f| f.file_stem()).map(|s| s.to_string_lossy().into_owned());
    About {
        name: args.name.clone().or(stem).unwrap_or_else(|| "test".to_string()),
        sources: args.files.iter().filter_map(|f| Some(f.file_name()?.to_string_lossy().into_owned())).collect(),
        configuration: args.configuration.clone(),
    }
}

/// The rate of an exponential window: itself, or one over its time constant; `none` is none.
fn window_rate(text: &str) -> Result<Option<f64>, Failure> {
    if text.trim() == "none" {
        return Ok(None);
    }
    let wrong = |why: &dyn std::fmt::Display| {
        Failure::text(format!(
            "--exponential-window {text}: {why}; give a rate, `5 1/s`, a time constant, `0.2 s`, or `none`"
        ))
    };
    let value = Scalar::parse(text).map_err(|e| wrong(&e))?;
    // Hz and rpm count turns; an angle a second, rad/s, is the unit of the real part of a pole.
    if value.terms().iter().any(|t| t.turns == Some(1.0)) {
        return Err(wrong(&"it is a frequency, and the window has a rate of decay, exp(-σt)"));
    }
    let rate = match (value.constant_in("1/s"), value.constant_in("s")) {
        (Ok(_), Ok(_)) => return Err(wrong(&"it has no unit")),
        (Ok(rate), _) => rate,
        (_, Ok(constant)) => 1.0 / constant,
        (Err(e), _) => return Err(wrong(&e)),
    };
    if rate.is_finite() && rate > 0.0 { Ok(Some(rate)) } else { Err(wrong(&"it must be above zero")) }
}

/// Modes that the files themselves hold.
fn held(found: &Identified, n_sensors: usize, style: &Style) -> String {
    let mut table = Table::new([
        ("#", Align::Right),
        ("Hz", Align::Right),
        ("damping", Align::Right),
        ("MPC", Align::Right),
        ("label", Align::Left),
    ]);
    for (k, m) in found.modes.iter().enumerate() {
        let mpc = m.shape.as_ref().map_or(f64::NAN, |s| complexity(s).mpc);
        table.row([
            (k + 1).to_string().into(),
            hertz(m.frequency_hz.value, 4).into(),
            m.damping_ratio.map_or_else(|| "–".to_string(), |z| format!("{:.3} %", 100.0 * z.value)).into(),
            format!("{mpc:.3}").into(),
            retune_report::text::printable(m.label.as_deref().unwrap_or_default()).into(),
        ]);
    }
    let mut out = format!(
        "The files hold {} at {}{}, taken over as they are.\n\n",
        counted(found.modes.len(), "mode"),
        counted(n_sensors, "sensor"),
        if found.is_synthetic { " (synthetic)" } else { "" }
    );
    out += &table.render(style);
    out
}

/// Spectra alone: frequencies of their peaks.
fn peaks(all: &[(String, Vec<SpectrumPeak>)], style: &Style) -> String {
    let mut out = String::from("No force was measured: frequencies of the peaks, without shapes.\n\n");
    for (name, list) in all {
        let mut table = Table::new([
            ("#", Align::Right),
            ("Hz", Align::Right),
            ("± sd", Align::Right),
            ("over valleys", Align::Right),
            ("damping below", Align::Right),
        ]);
        let mut heights: Vec<f64> = list.iter().map(|p| p.height_db).collect();
        heights.sort_by(|a, b| b.total_cmp(a));
        let least = heights.get(PEAKS_SHOWN - 1).copied().unwrap_or(f64::NEG_INFINITY);
        for (k, p) in list.iter().enumerate().filter(|(_, p)| p.height_db >= least) {
            table.row([
                (k + 1).to_string().into(),
                format!("{:.3}", p.frequency_hz).into(),
                format!("{:.3}", p.frequency_sd).into(),
                format!("{:.1} dB", p.height_db).into(),
                p.damping_ratio.map_or_else(|| "–".to_string(), |z| format!("{:.2} %", 100.0 * z)).into(),
            ]);
        }
        let _ = writeln!(out, "spectrum {}", retune_report::text::printable(name));
        out += &if list.is_empty() { "no peak was found\n".to_string() } else { table.render(style) };
        if list.len() > PEAKS_SHOWN {
            let more = format!(
                "and {} lower ones; `--peak-height` or `--band` narrow the list, `--json` and `-o` hold all of it",
                list.len() - PEAKS_SHOWN
            );
            out += &wrapped(&more, "");
        }
    }
    out
}

fn write(path: &Path, test: &TestData, args: &Identify) {
    if !writing::write(path, &write_test(test)) || args.print.json {
        return;
    }
    let path = shown(path);
    print(&format!("\nwritten: {path}\n"));
    // Its sensors are points of the measurement, no nodes yet.
    if args.model.is_none() && test.sensors.iter().any(|s| s.place.position().is_some()) {
        print(&format!("next: `retune map MODEL {path} -o placed.yaml` places its sensors\n"));
    }
}

fn head(frfs: &FrfSet, found: &Measurements) -> String {
    let what = frfs.quantity.word();
    let f = &frfs.frequencies_hz;
    format!(
        "{what}{}: {} x {}\n{} from {:.3} to {:.3} Hz{}\n\n",
        if found.is_synthetic { " (synthetic)" } else { "" },
        counted(frfs.responses.len(), "response"),
        counted(frfs.references.len(), "reference"),
        counted(f.len(), "line"),
        f.first().copied().unwrap_or(0.0),
        f.last().copied().unwrap_or(0.0),
        if frfs.coherence.is_some() { ", weighted by coherence" } else { "" },
    )
}

fn table(modes: &[TestMode], identification: &Identification, n_suspension: usize, style: &Style) -> String {
    let mut table = Table::new([
        ("#", Align::Right),
        ("Hz", Align::Right),
        ("± sd", Align::Right),
        ("damping", Align::Right),
        ("± sd", Align::Right),
        ("MPC", Align::Right),
        ("phase spread", Align::Right),
        ("orders", Align::Right),
    ]);
    // What is said of some modes stands below: beside the numbers it would not fit on a terminal.
    let mut remarks: Vec<(String, Vec<usize>)> = Vec::new();
    for (k, (t, m)) in modes.iter().zip(&identification.modes).enumerate() {
        let c = t.shape.as_ref().map_or(m.complexity, complexity);
        let mut remark = |applies: bool, text: &str| {
            if applies {
                match remarks.iter_mut().find(|(known, _)| known == text) {
                    Some((_, list)) => list.push(k + 1),
                    None => remarks.push((text.to_string(), vec![k + 1])),
                }
            }
        };
        remark(k < n_suspension, "on the suspension");
        remark(c.mpc < COMPLEX, "complex shape: MPC below 0.9");
        remark(
            m.sd_inflation > COLOURED,
            "the fit leaves more than noise; the standard deviations are three times as large for it",
        );
        remark(m.n_orders == 0, "weak: in no stable column, found in what the others leave");
        let damping = |v: Option<f64>| v.map_or_else(|| "–".to_string(), |z| format!("{:.3} %", 100.0 * z));
        table.row([
            (k + 1).to_string().into(),
            hertz(t.frequency_hz.value, 4).into(),
            format!("{:.1e}", t.frequency_hz.sd).into(),
            damping(t.damping_ratio.map(|z| z.value)).into(),
            damping(t.damping_ratio.map(|z| z.sd)).into(),
            Cell::new(format!("{:.3}", c.mpc), if c.mpc < COMPLEX { Tone::Warning } else { Tone::Plain }),
            format!("{:.1}°", c.mean_phase_deviation_deg).into(),
            m.n_orders.to_string().into(),
        ]);
    }
    if modes.is_empty() {
        return "no mode was found\n".to_string();
    }
    let mut out = table.render(style);
    for (text, list) in remarks {
        let list: Vec<String> = list.iter().map(ToString::to_string).collect();
        out += &wrapped(&format!("{}: {text}", list.join(", ")), "    ");
    }
    out
}

/// What the indicator function and the stabilisation diagrams show, in a few lines.
fn diagram(frfs: &FrfSet, identification: &Identification) -> Result<String, Failure> {
    let mut out = String::from("\n");
    let indicator = cmif(frfs)?;
    let limits = (
        identification.segments.first().map_or(0.0, |s| s.core_hz.0),
        identification.segments.last().map_or(f64::INFINITY, |s| s.core_hz.1),
    );
    for k in 0..indicator.values.ncols().min(2) {
        let column: Vec<f64> = indicator.values.column(k).iter().copied().collect();
        let list = spectrum_peaks(&indicator.frequencies_hz, &column, &PeakOptions::resonances(limits))?;
        let shown: Vec<String> = list.iter().take(20).map(|p| format!("{:.1}", p.frequency_hz)).collect();
        let more =
            if list.len() > shown.len() { format!(" and {} more", list.len() - shown.len()) } else { String::new() };
        let text = format!("CMIF {}: {}, {}{more}", k + 1, counted(list.len(), "peak"), shown.join(" "));
        out += &wrapped(&text, "    ");
    }
    for s in &identification.segments {
        let poles: usize = s.diagrams.iter().map(|d| d.poles.len()).sum();
        let chosen: usize = s.diagrams.iter().map(|d| d.chosen.len()).sum();
        let orders = s.diagrams.iter().map(|d| d.orders.last().copied().unwrap_or(0)).max().unwrap_or(0);
        let _ = writeln!(
            out,
            "{:.2} to {:.2} Hz: {} up to order {orders}, {}, {} discarded{}",
            s.core_hz.0,
            s.core_hz.1,
            counted(poles, "pole"),
            counted(chosen, "stable column"),
            s.discarded.len(),
            if s.is_converged { "" } else { ", the fit did not converge" }
        );
        for d in s.discarded.iter().take(5) {
            let text = format!("    {:.2} Hz, {:.2} %: {}", d.frequency_hz, 100.0 * d.damping_ratio, d.reason);
            out += &wrapped(&text, "        ");
        }
    }
    Ok(out)
}
