//! Where a model and a test disagree, on a terminal: one line each for the short answer, a table each for the long one.

use super::{Align, Cell, Style, Table, Tone, number, paragraph, printable, wrap};
use retune::correlation::{
    CloseModes, CriteriaProfile, Identifiability, Judgement, Localization, Misfit, SingleChange, SingleChanges, odds,
};
use retune::update::{ChannelAgreement, Functions, ModelFunctions, Orthogonality, Places, Sensitivities, SensorReport};
use std::fmt::Write as _;

/// Probability below which something stands out of the noise.
pub const SIGNIFICANCE: f64 = 0.01;
/// Rows of a ranked table.
const ROWS: usize = 10;
/// Widest matrix that is printed whole.
const WIDEST: usize = 12;

/// Words under a word at the left, wrapped to the width: `places      left_wing.2 stands out`.
pub fn line(out: &mut String, head: &str, text: &str, style: &Style) {
    const HEAD: usize = 12;
    for (i, part) in wrap(&printable(text), style.width.saturating_sub(HEAD)).iter().enumerate() {
        let head = if i == 0 { head } else { "" };
        let _ = writeln!(out, "{}{part}", style.paint(Tone::Strong, &format!("{head:<HEAD$}")));
    }
}

fn title(out: &mut String, text: &str, style: &Style) {
    let _ = writeln!(out, "\n{}", style.paint(Tone::Strong, text));
}

/// Text on lines of the width.
pub fn wrapped(out: &mut String, text: &str, style: &Style) {
    *out += &paragraph(&printable(text), "", style.width);
}

fn optional(value: Option<f64>) -> Cell {
    value.map_or_else(|| "–".into(), |v| format!("{v:.3}").into())
}

/// A misfit as a cell: chi-squared over its number of data, 1 when noise explains it.
pub fn ratio(m: &Misfit) -> String {
    if m.n_data == 0 {
        return "–".into();
    }
    let value = m.chi_squared / m.n_data as f64;
    if value < 100.0 { format!("{value:.1}") } else { format!("{value:.0}") }
}

/// Close modes that are mixtures, in one line for each group; nothing where there are none.
pub fn mixed_lines(out: &mut String, mixed: &[CloseModes], frequencies_hz: &[f64], style: &Style) {
    for group in mixed {
        let mut modes = group.experimental.clone();
        modes.sort_unstable();
        let names: Vec<String> = modes.iter().map(|m| (m + 1).to_string()).collect();
        let (last, others) = names.split_last().map_or(("", &[][..]), |(l, o)| (l.as_str(), o));
        let hz = || modes.iter().map(|&m| frequencies_hz[m]);
        let (low, high) = (hz().fold(f64::INFINITY, f64::min), hz().fold(0.0, f64::max));
        let text = format!(
            "modes {} and {last}, within {:.1} %, agree as a space (MAC with it {:.3} or more) and not one by one ({:.2}): imperfections mix such \
             shapes; `space` at these modes of the test file compares them so",
            others.join(", "),
            200.0 * (high - low) / (high + low),
            group.lowest_subspace_mac,
            group.lowest_mac,
        );
        line(out, "mixed", &text, style);
    }
}

/// The sensors in one line.
pub fn sensors_line(out: &mut String, report: &SensorReport, style: &Style) {
    let mut worst: Vec<_> = report.sensors.iter().filter(|s| s.misfit.p_value < SIGNIFICANCE).collect();
    worst.sort_by(|a, b| b.misfit.chi_squared.total_cmp(&a.misfit.chi_squared));
    let n = report.sensors.len();
    let mut text = if worst.is_empty() {
        format!("none of the {n} reads more than noise explains")
    } else {
        let names: Vec<String> = worst
            .iter()
            .take(3)
            .map(|s| format!("{} (COMAC {})", s.sensor, s.comac.map_or_else(|| "–".to_string(), |c| format!("{c:.2}"))))
            .collect();
        format!("{} of {n} read more than noise explains; most: {}", worst.len(), names.join(", "))
    };
    if let Some(last) = report.turns.last() {
        let names: Vec<&str> = report.turns.iter().map(|t| report.sensors[t.sensor].sensor.as_str()).collect();
        let (before, after) = (report.mean_mac, last.mean_mac);
        text +=
            &format!("; turned over, {} would raise the mean MAC from {before:.2} to {after:.2}", names.join(" and "));
    }
    line(out, "sensors", &text, style);
}

/// Every sensor, and which of them spoil the MAC.
pub fn sensors_table(out: &mut String, report: &SensorReport, style: &Style) {
    title(out, "Sensors", style);
    let mut table = Table::new([
        ("sensor", Align::Left),
        ("COMAC", Align::Right),
        ("scaled", Align::Right),
        ("enhanced", Align::Right),
        ("chi2/n", Align::Right),
        ("noise alone gives this in", Align::Left),
    ]);
    for s in &report.sensors {
        let tone = if s.misfit.p_value < SIGNIFICANCE { Tone::Warning } else { Tone::Plain };
        table.row([
            s.sensor.as_str().into(),
            optional(s.comac),
            optional(s.scaled_comac),
            optional(s.enhanced_comac),
            ratio(&s.misfit).into(),
            Cell::new(odds(s.misfit.p_value), tone),
        ]);
    }
    out.push_str(&table.render(style));
    let mut text = "COMAC and scaled COMAC: 1 is perfect; enhanced COMAC: 0 is perfect. ".to_string();
    if report.removals.is_empty() {
        text += &format!("No sensor spoils the MAC (mean {:.3}).", report.mean_mac);
    } else {
        text += &format!("The mean MAC of {:.3} rises", report.mean_mac);
        for r in &report.removals {
            text += &format!(" to {:.3} without {},", r.mean_mac, report.sensors[r.sensor].sensor);
        }
        text.pop();
        text += "; a sensor or the model at its place is wrong where it jumps.";
    }
    wrapped(out, &text, style);
}

/// Orthogonality in one line.
pub fn orthogonality_line(out: &mut String, o: &Orthogonality, style: &Style) {
    let diagonal = (0..o.cross.len()).map(|k| o.cross[k][k].abs());
    let (low, high) = diagonal.fold((f64::INFINITY, 0.0_f64), |(l, h), v| (l.min(v), h.max(v)));
    let text = format!(
        "cross-orthogonality {low:.2} to {high:.2}, off the diagonal up to {:.2}; the test's own {:.2} (mass reduction: {})",
        o.cross_off_diagonal(),
        o.auto_off_diagonal(),
        o.reduction.name(),
    );
    line(out, "mass", &text, style);
}

/// Both matrices.
pub fn orthogonality_tables(out: &mut String, o: &Orthogonality, style: &Style) {
    title(out, "Orthogonality", style);
    let left_out = if o.left_out.is_empty() {
        String::new()
    } else {
        format!("; without {}, not measured in all", o.left_out.join(", "))
    };
    wrapped(
        out,
        &format!(
            "mass reduction: {}{left_out}; the model's own modes are orthogonal to {:.3} in it",
            o.reduction.name(),
            o.own_error
        ),
        style,
    );
    let n = o.test_modes.len();
    for (name, rows) in [("model against test (rows model)", &o.cross), ("test against itself", &o.auto)] {
        if n > WIDEST {
            let largest = rows
                .iter()
                .enumerate()
                .flat_map(|(i, r)| r.iter().enumerate().map(move |(j, v)| (i, j, *v)))
                .filter(|(i, j, _)| i != j)
                .max_by(|a, b| a.2.abs().total_cmp(&b.2.abs()));
            if let Some((i, j, v)) = largest {
                let _ = writeln!(
                    out,
                    "{name}: largest off the diagonal {v:.3}, modes {} and {}; all in --json",
                    o.test_modes[i] + 1,
                    o.test_modes[j] + 1
                );
            }
            continue;
        }
        let heads: Vec<String> = o.test_modes.iter().map(|m| (m + 1).to_string()).collect();
        let columns = std::iter::once((name, Align::Right)).chain(heads.iter().map(|h| (h.as_str(), Align::Right)));
        let mut table = Table::new(columns);
        for (i, row) in rows.iter().enumerate() {
            let cells = row.iter().enumerate().map(|(j, v)| {
                let tone = if i != j && v.abs() > 0.1 { Tone::Warning } else { Tone::Plain };
                Cell::new(format!("{v:.2}"), tone)
            });
            table.row(std::iter::once(heads[i].as_str().into()).chain(cells));
        }
        out.push_str(&table.render(style));
    }
}

/// Places in one line.
pub fn places_line(out: &mut String, places: &Places, style: &Style) {
    let l = &places.by_element;
    let text = match (l.stands_out(SIGNIFICANCE), l.places.as_slice()) {
        (true, [first, rest @ ..]) => {
            let second = rest.first().filter(|p| p.p_value < SIGNIFICANCE);
            let second = second.map_or_else(String::new, |p| format!(", then {}", p.name));
            let member = places.by_group.places.first().filter(|g| g.name != first.name);
            let member = member.map_or_else(String::new, |g| format!("; of whole members {} has most", g.name));
            format!(
                "most of it sits in {}{second}{member}; noise alone gives this in {}. {}",
                first.name,
                odds(l.p_family),
                alone(&places.changes_by_element),
            )
        }
        _ => format!("nothing stands out: noise alone gives the largest in {}", odds(l.p_family)),
    };
    line(out, "places", &text, style);
}

/// What one change could do.
fn alone(changes: &SingleChanges) -> String {
    changes.changes.first().map_or_else(String::new, |c| {
        let share = format!("{:.0} %", 100.0 * c.share);
        let name = &c.name;
        match (c.share >= 0.5, c.is_limited, c.change < 0.0) {
            (true, false, _) => {
                format!("{name} with {:+.0} % of stiffness alone explains {share} of it", 100.0 * c.change)
            }
            (true, true, true) => format!("{name} without any stiffness would explain {share} of it"),
            (true, true, false) => format!("{name} with twice its stiffness would explain {share} of it"),
            (false, ..) => format!("No single stiffness explains it: the best, {name}, {share}"),
        }
    })
}

/// The change of one stiffness: `-20 ± 3 %`, or where that would be more than all of it.
fn change(c: &SingleChange) -> String {
    match (c.is_limited, c.change < 0.0) {
        (false, _) => format!("{:+.0} ± {:.0} %", 100.0 * c.change, 100.0 * c.sd),
        (true, true) => "all of it gone".to_string(),
        (true, false) => "above +100 %".to_string(),
    }
}

/// Elements and groups, ranked.
pub fn places_tables(out: &mut String, places: &Places, style: &Style) {
    title(out, "Places", style);
    for (what, l, changes) in [
        ("element", &places.by_element, &places.changes_by_element),
        ("group", &places.by_group, &places.changes_by_group),
    ] {
        if l.stands_out(SIGNIFICANCE) {
            let _ = writeln!(out, "by {what}: noise alone gives the highest in {}", odds(l.p_family));
        } else {
            let _ =
                writeln!(out, "by {what}: nothing stands out; noise alone gives the highest in {}", odds(l.p_family));
        }
        ranked(out, what, l, changes, style);
    }
    wrapped(
        out,
        "error: root of the energy of the residual over the strain energy there, about the relative error of the stiffness. \
         over noise: that energy over what noise alone gives. alone: the change of this stiffness that by itself explains \
         most, and its share of chi-squared, by a linear estimate that is not followed beyond -100 % and +100 %; modes closer than 5 % are \
         left out of that. Mass errors look alike.",
        style,
    );
    let head = "share of strain energy, by group and pair (test mode)";
    let numbers: Vec<String> = places.test_modes.iter().take(WIDEST).map(|m| (m + 1).to_string()).collect();
    let columns = std::iter::once((head, Align::Left)).chain(numbers.iter().map(|n| (n.as_str(), Align::Right)));
    let mut table = Table::new(columns);
    for (name, shares) in places.strain_energy.iter().take(2 * ROWS) {
        let cells = shares.iter().take(WIDEST).map(|s| Cell::from(format!("{:.0} %", 100.0 * s)));
        table.row(std::iter::once(name.as_str().into()).chain(cells));
    }
    out.push_str(&table.render(style));
}

fn ranked(out: &mut String, what: &str, l: &Localization, changes: &SingleChanges, style: &Style) {
    let mut table = Table::new([
        (what, Align::Left),
        ("error", Align::Right),
        ("over noise", Align::Right),
        ("noise gives it in", Align::Left),
        ("alone", Align::Right),
        ("explains", Align::Right),
    ]);
    for p in l.places.iter().take(ROWS) {
        let single = changes.changes.iter().find(|c| c.name == p.name);
        let over = if p.noise_mean > 0.0 { number(p.energy / p.noise_mean) } else { "–".into() };
        let tone = if p.p_value < SIGNIFICANCE { Tone::Warning } else { Tone::Plain };
        table.row([
            p.name.as_str().into(),
            format!("{:.1} %", 100.0 * p.relative_energy.max(0.0).sqrt()).into(),
            over.into(),
            Cell::new(odds(p.p_value), tone),
            single.map_or_else(|| "–".into(), |c| change(c).into()),
            single.map_or_else(|| "–".into(), |c| format!("{:.0} %", 100.0 * c.share).into()),
        ]);
    }
    out.push_str(&table.render(style));
    if l.places.len() > ROWS {
        let _ = writeln!(out, "and {} more in --json", l.places.len() - ROWS);
    }
}

/// Parameters in one line.
pub fn parameters_line(out: &mut String, s: &Sensitivities, style: &Style) {
    let Some(seen) = &s.identifiability else { return };
    let mut text = format!("the test determines {} of {} combinations of parameters", seen.rank, seen.names.len());
    if s.weighed.is_some() {
        text += ", not how heavy all is; with the total mass known";
    }
    text += &in_short(s.weighed.as_ref().unwrap_or(seen), s.weighed.is_some());
    line(out, "parameters", &text, style);
}

/// Groups in a sentence that has begun.
fn in_short(i: &Identifiability, weighed: bool) -> String {
    if weighed && i.groups.is_empty() {
        return " all are seen".to_string();
    }
    let mut text = String::new();
    for (k, group) in i.groups.iter().enumerate() {
        text += if weighed && k == 0 { " " } else { "; " };
        let names: Vec<&str> = group.parameters.iter().map(|&p| i.names[p].as_str()).collect();
        text += &match (names.len(), group.combinations.nrows()) {
            (1, 0) => format!("{} has no effect", names[0]),
            (_, 0) => format!("{} have no effect", names.join(", ")),
            (n, 1) => format!("{n} act only through one number: {}", names.join(", ")),
            (n, k) => format!("{n} act only through {k} numbers: {}", names.join(", ")),
        };
    }
    text
}

/// What the test tells of every parameter.
pub fn parameters_table(out: &mut String, s: &Sensitivities, style: &Style) {
    let Some(seen) = &s.identifiability else { return };
    title(out, "Parameters", style);
    let i = s.weighed.as_ref().unwrap_or(seen);
    let mut table = Table::new([
        ("parameter", Align::Left),
        ("value", Align::Right),
        ("sd, others known", Align::Right),
        ("sd, others free", Align::Right),
        ("unit", Align::Left),
        ("", Align::Left),
    ]);
    for p in &s.information {
        let width = p.bounds.1 - p.bounds.0;
        let note = match p.sd {
            None if p.sd_alone.is_none() => Cell::new("no effect", Tone::Warning),
            None => Cell::new("not by itself", Tone::Warning),
            // A uniform density over the interval has width/√12.
            Some(sd) if sd > width / 12.0_f64.sqrt() => Cell::new("the bounds say more", Tone::Warning),
            Some(_) => Cell::default(),
        };
        let sd = |v: Option<f64>| v.map_or_else(|| "–".to_string(), number);
        table.row([
            p.name.as_str().into(),
            number(p.value).into(),
            sd(p.sd_alone).into(),
            sd(p.sd).into(),
            p.unit.as_str().into(),
            note,
        ]);
    }
    out.push_str(&table.render(style));
    if s.weighed.is_some() {
        let text = format!(
            "the data determine {} of {} combinations of parameters, not how heavy all is: frequencies and shapes stay as they are when \
             all stiffness and mass grow together. With the total mass known (to 0.5 % in the table above):",
            seen.rank,
            seen.names.len()
        );
        wrapped(out, &text, style);
    }
    for text in i.to_string().lines() {
        if text.starts_with("  ") {
            let _ = writeln!(out, "{}", printable(text));
        } else {
            wrapped(out, text, style);
        }
    }
    for group in &s.collinear {
        let names: Vec<&str> = group.parameters.iter().map(|&p| s.names[p].as_str()).collect();
        wrapped(
            out,
            &format!("nearly the same effect on this test (cosine at least {:.3}): {}", group.cosine, names.join(", ")),
            style,
        );
    }
}

/// Functions in one line.
pub fn functions_line(out: &mut String, f: &Functions, style: &Style) {
    let mean = |values: Vec<f64>| values.iter().sum::<f64>() / values.len().max(1) as f64;
    let csac = mean(f.lines.iter().filter_map(|l| l.1).collect());
    let csf = mean(f.lines.iter().filter_map(|l| l.2).collect());
    let shift = f.shifts.first().filter(|s| s.ratio != 1.0).map_or_else(String::new, |s| {
        format!("; FDAC is best with the model's frequencies moved by {:+.1} %", 100.0 * (1.0 / s.ratio - 1.0))
    });
    let text = format!("{} of them: mean CSAC {csac:.2}, CSF {csf:.2}{shift}", f.channels.len());
    line(out, "functions", &text, style);
}

/// Functions by band, the worst of them (or all), and the shift of frequency.
pub fn functions_tables(out: &mut String, f: &Functions, all: bool, style: &Style) {
    title(out, "Functions", style);
    if !f.left_out.is_empty() {
        wrapped(out, &format!("without channels that no sensor of the test is: {}", f.left_out.join(", ")), style);
    }
    let mut table = Table::new([
        ("band Hz", Align::Right),
        ("CSAC", Align::Right),
        ("CSF", Align::Right),
        ("FRAC", Align::Right),
        ("amplitude dB", Align::Right),
        ("rms", Align::Right),
        ("phase deg", Align::Right),
        ("rms", Align::Right),
        ("chi2/n", Align::Right),
        ("modes", Align::Left),
    ]);
    for b in &f.bands {
        let short = |v: Option<f64>| v.map_or_else(|| "–".to_string(), |v| format!("{v:.2}"));
        table.row([
            format!("{:.1}-{:.1}", b.band_hz.0, b.band_hz.1).into(),
            short(b.csac).into(),
            short(b.csf).into(),
            short(b.frac).into(),
            format!("{:+.1}", b.amplitude_db).into(),
            format!("{:.1}", b.amplitude_rms_db).into(),
            format!("{:+.0}", b.phase_deg).into(),
            format!("{:.0}", b.phase_rms_deg).into(),
            ratio(&b.misfit).into(),
            b.modes.iter().map(|m| m.split(" (").next().unwrap_or(m)).collect::<Vec<_>>().join(", ").into(),
        ]);
    }
    out.push_str(&table.render(style));
    let mut by_frac: Vec<_> = f.channels.iter().filter_map(|c| c.frac.map(|v| (v, c))).collect();
    by_frac.sort_by(|a, b| a.0.total_cmp(&b.0));
    let median = by_frac.get(by_frac.len() / 2).map_or(f64::NAN, |m| m.0);
    wrapped(out, &format!("FRAC: median {median:.2}"), style);
    for (v, c) in by_frac.iter().filter(|(_, c)| c.is_driving_point) {
        let amplitude = c.amplitude.map_or_else(|| "–".to_string(), |a| format!("{a:.2}"));
        wrapped(out, &format!("driving point {}: FRAC {v:.2}, amplitude criterion {amplitude}", c.response), style);
    }
    for s in &f.shifts {
        let ridge: Vec<String> =
            s.ridge.iter().map(|(x, a, fdac)| format!("{x:.2} Hz at {a:.2} Hz ({fdac:.2})")).collect();
        wrapped(
            out,
            &format!(
                "FDAC from {}: the model's frequencies over the test's are {:.3} (FDAC {:.2}, {:.2} unshifted); test modes resemble the model's: {}",
                s.reference,
                s.ratio,
                s.fdac,
                s.fdac_unshifted,
                ridge.join(", ")
            ),
            style,
        );
    }
    out.push_str(&channels_table(f, all).render(style));
    let hidden = f.channels.len().saturating_sub(ROWS);
    if hidden > 0 && !all {
        wrapped(out, &format!("and {hidden} that agree better; all with --all"), style);
    }
    let source = match f.model {
        ModelFunctions::Superposed { n_modes, damping } => format!(
            "the model's functions are superposed from {n_modes} elastic modes; damping as measured, {:.2} % for the others",
            100.0 * damping
        ),
        ModelFunctions::Direct { is_damped, loss_factor } => {
            let own = if is_damped { "the model's own damping" } else { "no damping of its own" };
            let beside = if loss_factor > 0.0 {
                format!(", and a loss factor of {}", number(loss_factor))
            } else {
                String::new()
            };
            format!("the model's functions are found line by line, with {own}{beside}")
        }
    };
    wrapped(out, &source, style);
}

/// The functions, those that agree worst first.
fn channels_table(f: &Functions, all: bool) -> Table {
    let mut table = Table::new([
        ("response", Align::Left),
        ("from", Align::Left),
        ("FRAC", Align::Right),
        ("amplitude dB", Align::Right),
        ("rms", Align::Right),
        ("chi2/n", Align::Right),
        ("", Align::Left),
    ]);
    let mut channels: Vec<&ChannelAgreement> = f.channels.iter().filter(|c| c.misfit.n_data > 0).collect();
    let of_noise = |c: &ChannelAgreement| c.misfit.chi_squared / c.misfit.n_data as f64;
    channels.sort_by(|a, b| of_noise(b).total_cmp(&of_noise(a)));
    for c in channels.iter().take(if all { usize::MAX } else { ROWS }) {
        table.row([
            c.response.as_str().into(),
            c.reference.as_str().into(),
            c.frac.map_or_else(|| "–".to_string(), |v| format!("{v:.2}")).into(),
            format!("{:+.1}", c.amplitude_db).into(),
            format!("{:.1}", c.amplitude_rms_db).into(),
            ratio(&c.misfit).into(),
            if c.is_driving_point { "driving point" } else { "" }.into(),
        ]);
    }
    table
}

/// The judgement of a profile.
pub fn judgement(out: &mut String, j: &Judgement, profile: &CriteriaProfile, style: &Style) {
    title(out, &format!("Profile {}", printable(&profile.name)), style);
    wrapped(out, &format!("{}{}", profile.source, if profile.verified { "" } else { " (not verified)" }), style);
    let mut table = Table::new([
        ("what", Align::Left),
        ("of", Align::Left),
        ("value", Align::Right),
        ("mark", Align::Right),
        ("", Align::Left),
        ("probability", Align::Right),
    ]);
    for c in &j.checks {
        let percent = c.what == "frequency error";
        let write = |v: f64| if percent { format!("{:.1} %", 100.0 * v) } else { format!("{v:.3}") };
        let verdict = if c.passed { Cell::new("✓ pass", Tone::Good) } else { Cell::new("✕ fail", Tone::Bad) };
        table.row([
            c.what.into(),
            c.subject.as_str().into(),
            c.value.map_or_else(|| "none".into(), |v| write(v).into()),
            if c.what == "paired" { "–".into() } else { write(c.limit).into() },
            verdict,
            c.probability.map_or_else(|| "–".into(), |p| format!("{p:.2}").into()),
        ]);
    }
    out.push_str(&table.render(style));
    let failed = j.checks.iter().filter(|c| !c.passed).count();
    let verdict = if j.passed {
        style.paint(Tone::Good, "✓ passes")
    } else if j.checks.is_empty() {
        style.paint(Tone::Bad, "✕ nothing to judge")
    } else {
        style.paint(Tone::Bad, &format!("✕ fails {failed} of {} checks", j.checks.len()))
    };
    let _ = writeln!(out, "{verdict}; given the noise of the test it passes with probability {:.2}", j.probability);
}
