//! `retune identify`

use super::measured::{
    band, by_model, findings_json, findings_text, has_fault, held_modes, place, read, shape_functions, wrapped,
};
use crate::args::{Identify, Method};
use crate::output::{Failure, print, print_json, shown, style, warn};
use crate::{DONE, SHORT, files, writing};
use retune::catalogue::counted;
use retune::data::{FrfSet, Measurements, ModalSet, Origin, SpectrumKind, TestData, TestMode, write_test};
use retune::identify::health::{
    HealthOptions, check_damping, check_identification, check_shapes, check_test, reversed_time_finding,
};
use retune::identify::{
    Identification, IdentifyOptions, PeakOptions, SpectrumPeak, add_repeatability, circle_modes, cmif, complexity,
    identify, peak_modes, quadrature_modes, remove_exponential_window, sensors, spectrum_peaks, test_modes,
};
use retune::model::Model;
use retune::report::text::{Align, Cell, Style, Table, Tone, hertz};
use retune::units::Scalar;
use serde_json::{Value, json};
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
        writing::check_output(output, args.force)?;
    }
    let found = read(&args.files, &args.measurement)?;
    if found.frfs.is_none() && !found.spectra.is_empty() {
        return peaks(args, &found);
    }
    if let (None, Some(modes)) = (&found.frfs, &found.modes) {
        return take_over(args, &found, modes);
    }
    let turned = shape_functions(&found)?;
    let frfs = turned.as_ref();
    let options = IdentifyOptions {
        band_hz: band(args.band.as_deref())?,
        max_order: usize::from(args.order),
        ..IdentifyOptions::default()
    };
    let identification = identify(frfs, &options)?;
    let n_suspension = usize::from(args.suspension);
    let origin = origin(args, &found);
    let mut modes = match args.method {
        Method::Plscf => test_modes(&identification.modes, &origin),
        Method::Circle => circle_modes(frfs, 0, &identification.modes, &origin)?,
        Method::Quadrature => quadrature_modes(frfs, 0, &identification.modes, &origin)?,
    };
    let window = take_out_window(args, &found, &mut modes)?;
    let mut test = None;
    if args.output.is_some() || args.model.is_some() {
        let sensors = sensors(frfs, found.geometry.as_ref(), None)?;
        test = Some(TestData { sensors, modes: modes.clone(), ..test_data(args, &found, String::new()) });
    }
    let model =
        args.model.as_deref().zip(test.as_mut()).map(|(path, test)| placed(args, path, test, &found)).transpose()?;
    let mut findings = Vec::new();
    if args.no_health {
        // What was left out, and why there is nothing, is no question of health.
        for finding in check_identification(frfs, &identification) {
            warning!("{}", finding.text);
        }
    } else {
        let options = HealthOptions { n_suspension, has_model: model.is_some() };
        findings = check_test(frfs, Some(&identification), found.geometry.as_ref(), options)?;
        findings.extend(found.is_time_reversed.then(reversed_time_finding));
        if let (Some(model), Some(test)) = (&model, &test) {
            findings.extend(by_model(model, test, n_suspension)?);
        }
        findings.sort_by_key(|f| std::cmp::Reverse(f.level));
    }
    if args.json {
        print_json(&json!({
            "method": word(args.method),
            "modes": modes.iter().zip(&identification.modes).map(|(t, m)| json!({
                "frequency_hz": t.frequency_hz.value, "frequency_sd": t.frequency_hz.sd,
                "damping": t.damping_ratio.map(|z| z.value), "damping_sd": t.damping_ratio.map(|z| z.sd),
                "mpc": m.complexity.mpc, "mean_phase_deviation_deg": m.complexity.mean_phase_deviation_deg,
                "sd_inflation": m.sd_inflation, "orders": m.n_orders,
            })).collect::<Vec<_>>(),
            "responses": frfs.responses.iter().map(|c| c.name.clone()).collect::<Vec<_>>(),
            "references": frfs.references.iter().map(|c| c.name.clone()).collect::<Vec<_>>(),
            "lines": frfs.n_lines(),
            "is_synthetic": found.is_synthetic,
            "exponential_window_per_s": window,
            "pieces": identification.segments.iter().map(piece_json).collect::<Vec<_>>(),
            "findings": findings_json(&findings),
        }));
    } else {
        let style = style(&std::io::stdout());
        let mut out = head(frfs, &found);
        out += &table(&modes, &identification, n_suspension, &style);
        out += &diagram(frfs, &identification)?;
        if !args.no_health {
            out += "\n";
            out += &findings_text(&findings, &style);
        }
        print(&out);
    }
    if let (Some(output), Some(mut test)) = (&args.output, test) {
        test.modes.drain(..n_suspension.min(test.modes.len()));
        add_repeatability(&mut test.modes, args.repeatability / 100.0);
        test.description = format!(
            "Identified by {} from {}, {:.4} to {:.4} Hz, {}, {}; complex shapes, largest entry 1. \
             Standard deviations are those of the lines and {} % of a frequency, ten times that of a shape, for what a repeated \
             test would change.{}",
            word(args.method),
            counted(frfs.n_lines(), "line"),
            frfs.frequencies_hz.first().copied().unwrap_or(0.0),
            frfs.frequencies_hz.last().copied().unwrap_or(0.0),
            counted(frfs.responses.len(), "response"),
            counted(frfs.references.len(), "reference"),
            args.repeatability,
            window.map_or_else(String::new, |w| format!(
                " The damping of an exponential window of {w} 1/s is taken out."
            )),
        );
        write(output, &test, args.json);
    }
    Ok(if has_fault(&findings) || modes.is_empty() { SHORT } else { DONE })
}

/// Takes the damping of an exponential window out of the modes; gives its rate, 1/s.
fn take_out_window(args: &Identify, found: &Measurements, modes: &mut [TestMode]) -> Result<Option<f64>, Failure> {
    let stated = args.exponential_window.as_deref().map(window_rate).transpose()?;
    let Some(rate) = stated.unwrap_or(found.exponential_window) else { return Ok(None) };
    let mut corrected = modes.to_vec();
    let lost = remove_exponential_window(&mut corrected, rate);
    if stated.is_none() {
        if !lost.is_empty() {
            warning!(
                "dataset 1858 states an exponential window with the damping factor {rate}; as a rate in 1/s it is more than the damping of {} of {} modes, so that nothing is taken out; state it with `--exponential-window`",
                lost.len(),
                modes.len()
            );
            return Ok(None);
        }
        note!(
            "dataset 1858 states an exponential window with the damping factor {rate}, taken as a rate in 1/s: its damping is taken out; `--exponential-window none` leaves it in"
        );
    }
    for hz in lost {
        warning!(
            "the mode at {hz:.3} Hz has no more damping than the window of {rate} 1/s adds: its damping ratio is left out"
        );
    }
    modes.clone_from_slice(&corrected);
    Ok(Some(rate))
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

/// Modes that the files themselves hold: shown, checked and written as they are.
fn take_over(args: &Identify, found: &Measurements, modes: &ModalSet) -> Result<u8, Failure> {
    if args.band.is_some() || args.method != Method::Plscf {
        return Err(Failure::text(
            "`--band` and `--method` identify modes from functions; these files hold modes, which are taken over as they are",
        ));
    }
    let damping = check_damping(&modes.modes);
    let (sensors, modes) = held_modes(found, modes, &origin(args, found));
    let n_suspension = usize::from(args.suspension);
    let description = "Modes as the file holds them; it states no standard deviations, so those are defaults.";
    let mut test =
        TestData { sensors: sensors.clone(), modes: modes.clone(), ..test_data(args, found, description.to_string()) };
    let model = args.model.as_deref().map(|path| placed(args, path, &mut test, found)).transpose()?;
    let mut findings = Vec::new();
    if !args.no_health {
        let options = HealthOptions { n_suspension, has_model: model.is_some() };
        findings = [damping, check_shapes(&sensors, &modes, options)?].concat();
        if let Some(model) = &model {
            findings.extend(by_model(model, &test, n_suspension)?);
            findings.sort_by_key(|f| std::cmp::Reverse(f.level));
        }
    }
    if args.json {
        print_json(&json!({
            "method": "as in the file",
            "modes": modes.iter().map(|t| json!({
                "frequency_hz": t.frequency_hz.value, "damping": t.damping_ratio.map(|z| z.value), "label": t.label,
                "mpc": t.shape.as_ref().map(|s| complexity(s).mpc),
            })).collect::<Vec<_>>(),
            "responses": sensors.iter().map(|s| s.name.clone()).collect::<Vec<_>>(),
            "is_synthetic": found.is_synthetic,
            "findings": findings_json(&findings),
        }));
    } else {
        let style = style(&std::io::stdout());
        let mut table = Table::new([
            ("#", Align::Right),
            ("Hz", Align::Right),
            ("damping", Align::Right),
            ("MPC", Align::Right),
            ("label", Align::Left),
        ]);
        for (k, m) in modes.iter().enumerate() {
            let mpc = m.shape.as_ref().map_or(f64::NAN, |s| complexity(s).mpc);
            table.row([
                (k + 1).to_string().into(),
                hertz(m.frequency_hz.value, 4).into(),
                m.damping_ratio.map_or_else(|| "–".to_string(), |z| format!("{:.3} %", 100.0 * z.value)).into(),
                format!("{mpc:.3}").into(),
                retune::report::text::printable(m.label.as_deref().unwrap_or_default()).into(),
            ]);
        }
        let mut out = format!(
            "The files hold {} at {}{}, taken over as they are.\n\n",
            counted(modes.len(), "mode"),
            counted(sensors.len(), "sensor"),
            if found.is_synthetic { " (synthetic)" } else { "" }
        );
        out += &table.render(&style);
        if !args.no_health {
            out += "\n";
            out += &findings_text(&findings, &style);
        }
        print(&out);
    }
    if let Some(output) = &args.output {
        test.modes.drain(..n_suspension.min(test.modes.len()));
        write(output, &test, args.json);
    }
    Ok(if has_fault(&findings) { SHORT } else { DONE })
}

/// Spectra alone: frequencies of their peaks.
fn peaks(args: &Identify, found: &Measurements) -> Result<u8, Failure> {
    let mut all: Vec<(String, Vec<SpectrumPeak>)> = Vec::new();
    for spectrum in &found.spectra {
        let f = &spectrum.frequencies_hz;
        let limits = (f.first().copied().unwrap_or(0.0), f.last().copied().unwrap_or(0.0));
        let limits = band(args.band.as_deref())?.unwrap_or(limits);
        // Of a power the root is an amplitude.
        let is_power = spectrum.kind != SpectrumKind::Linear;
        let amplitude: Vec<f64> =
            spectrum.values.iter().map(|v| if is_power { v.norm().sqrt() } else { v.norm() }).collect();
        let options = PeakOptions { min_height_db: args.peak_height, ..PeakOptions::resonances(limits) };
        let found = spectrum_peaks(f, &amplitude, &options)?;
        all.push((spectrum.response.name.clone(), found));
    }
    if args.json {
        let one = |p: &SpectrumPeak| json!({"frequency_hz": p.frequency_hz, "frequency_sd": p.frequency_sd, "height_db": p.height_db, "damping_at_most": p.damping_ratio});
        let spectra: Vec<Value> = all
            .iter()
            .map(|(name, list)| json!({"name": name, "peaks": list.iter().map(one).collect::<Vec<_>>()}))
            .collect();
        print_json(&json!({"method": "peaks", "spectra": spectra}));
    } else {
        let style = style(&std::io::stdout());
        let mut out = String::from("No force was measured: frequencies of the peaks, without shapes.\n\n");
        for (name, list) in &all {
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
            let _ = writeln!(out, "spectrum {}", retune::report::text::printable(name));
            out += &if list.is_empty() { "no peak was found\n".to_string() } else { table.render(&style) };
            if list.len() > PEAKS_SHOWN {
                let more = format!(
                    "and {} lower ones; `--peak-height` or `--band` narrow the list, `--json` and `-o` hold all of it",
                    list.len() - PEAKS_SHOWN
                );
                out += &wrapped(&more, "");
            }
        }
        print(&out);
    }
    if let Some(output) = &args.output {
        if all.len() != 1 {
            return Err(Failure::text(format!("{} spectra: write a test file of one at a time", all.len())));
        }
        let mut test = test_data(args, found, "Peaks of a response spectrum; no force was measured.".to_string());
        test.modes = peak_modes(&all[0].1, &origin(args, found));
        write(output, &test, args.json);
    }
    Ok(DONE)
}

fn test_data(args: &Identify, found: &Measurements, description: String) -> TestData {
    let stem = args.files.first().and_then(|f| f.file_stem()).map(|s| s.to_string_lossy().into_owned());
    let name = args.name.clone().or(stem).unwrap_or_else(|| "test".to_string());
    TestData {
        name: if found.is_synthetic && !name.to_lowercase().contains("synthetic") {
            format!("{name} (synthetic)")
        } else {
            name
        },
        description,
        configuration: args.configuration.clone(),
        sensors: Vec::new(),
        modes: Vec::new(),
        mass_properties: Vec::new(),
        static_tests: Vec::new(),
        frfs: None,
        frf_fit: None,
        corrections: Vec::new(),
    }
}

fn origin(args: &Identify, found: &Measurements) -> Origin {
    let is_held = found.frfs.is_none() && found.modes.is_some();
    let how = if is_held { "modes" } else { word(args.method) };
    let names: Vec<String> =
        args.files.iter().filter_map(|f| f.file_name()).map(|f| f.to_string_lossy().into_owned()).collect();
    let text = format!("{how} of {}", names.join(", "));
    if found.is_synthetic { Origin::Synthetic(text) } else { Origin::Measured(text) }
}

fn word(method: Method) -> &'static str {
    match method {
        Method::Plscf => "pLSCF and maximum likelihood",
        Method::Quadrature => "quadrature picking",
        Method::Circle => "circle fits",
    }
}

/// The model, with the sensors of the test at their places in it.
fn placed(args: &Identify, path: &Path, test: &mut TestData, found: &Measurements) -> Result<Model, Failure> {
    let (model, warnings, text) = files::model(path, args.configuration.as_deref())?;
    warn(path, &text, &warnings);
    if found.geometry.is_none() {
        return Err(Failure::text(
            "the positions of the points are not known, so they have no place in the model; give `--geometry FILE`",
        ));
    }
    place(&model, test);
    Ok(model)
}

fn write(path: &Path, test: &TestData, is_json: bool) {
    if writing::write(path, &write_test(test)) && !is_json {
        print(&format!("\nwritten: {}\n", shown(path)));
    }
}

fn head(frfs: &FrfSet, found: &Measurements) -> String {
    let what = match frfs.quantity {
        retune::data::FrfQuantity::Receptance => "receptance",
        retune::data::FrfQuantity::Mobility => "mobility",
        retune::data::FrfQuantity::Accelerance => "accelerance",
    };
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

fn piece_json(s: &retune::identify::Segment) -> Value {
    json!({
        "from_hz": s.core_hz.0, "to_hz": s.core_hz.1, "is_converged": s.is_converged,
        "poles": s.diagrams.iter().map(|d| d.poles.len()).sum::<usize>(),
        "stable_columns": s.diagrams.iter().map(|d| d.chosen.len()).sum::<usize>(),
        "discarded": s.discarded.iter().map(|d| json!({
            "frequency_hz": d.frequency_hz, "damping": d.damping_ratio, "reason": d.reason,
        })).collect::<Vec<_>>(),
    })
}
