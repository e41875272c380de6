//! What goes to the terminal.

use retune::catalogue::counted;
use retune::data::TestData;
use retune::update::{Assessment, ModeAgreement, Remark};
use retune::yaml::{Problem, Severity};
use retune_diagnosis::BasePairs;
use retune_report::text::agreement::{ratio, wrapped};
use retune_report::text::{Align, Cell, Style, Table, Tone, hertz, printable};
use std::fmt::Write as _;
use std::io::{IsTerminal, Write as _};
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A failure that is ready to print.
#[derive(Debug)]
pub(crate) struct Failure {
    text: String,
}

impl Failure {
    /// One line.
    pub(crate) fn text(text: impl AsRef<str>) -> Self {
        Self { text: format!("retune: {}", shortened(&printable(text.as_ref()), LONGEST_FAILURE)) }
    }

    /// Several lines, each shortened by itself.
    pub(crate) fn lines(lines: &[String]) -> Self {
        let lines: Vec<String> = lines.iter().map(|line| shortened(&printable(line), LONGEST)).collect();
        Self { text: format!("retune: {}", lines.join("\n        ")) }
    }

    /// Problems of a file, each with the line it stands in.
    pub(crate) fn problems(path: &Path, source: &str, problems: &[Problem]) -> Self {
        Self { text: render_problems(path, source, problems) }
    }

    /// The same, with a way out of it on a last line.
    pub(crate) fn with_hint(mut self, hint: impl AsRef<str>) -> Self {
        self.text =
            format!("{}\nhint: {}", self.text.trim_end(), shortened(&printable(hint.as_ref()), LONGEST_FAILURE));
        self
    }

    /// With a hint where there is one.
    pub(crate) fn with_hint_of(self, hint: Option<String>) -> Self {
        match hint {
            Some(hint) => self.with_hint(hint),
            None => self,
        }
    }

    /// Prints it to standard error.
    pub(crate) fn print(&self) {
        tell(self.text.trim_end());
    }
}

impl<E: std::error::Error> From<E> for Failure {
    fn from(error: E) -> Self {
        let mut text = error.to_string();
        let mut source = error.source();
        while let Some(cause) = source {
            // A transparent variant repeats its cause word for word.
            if !text.ends_with(&cause.to_string()) {
                let _ = write!(text, ": {cause}");
            }
            source = cause.source();
        }
        Self::text(text)
    }
}

/// Characters of a problem of a file, at most.
pub(crate) const LONGEST: usize = 600;
/// Errors of a file that are shown, and warnings: who has mended these sees the others.
const SHOWN: usize = 20;
/// Characters of a failure, at most: it may list what has to be stated.
const LONGEST_FAILURE: usize = 2400;

/// A text cut after so many characters.
pub(crate) fn shortened(text: &str, longest: usize) -> String {
    match text.char_indices().nth(longest) {
        Some((end, _)) => format!("{} …", &text[..end]),
        None => text.to_string(),
    }
}

/// A path as it is shown: what could move the cursor is escaped.
pub(crate) fn shown(path: &Path) -> String {
    printable(&path.display().to_string())
}

/// Problems as `file:line:column: error: path: message`, each followed by its line with a caret.
pub(crate) fn render_problems(path: &Path, source: &str, problems: &[Problem]) -> String {
    let style = style(&std::io::stderr());
    let mut out = String::new();
    let mut problems: Vec<&Problem> = problems.iter().collect();
    problems.sort_by_key(|p| (std::cmp::Reverse(p.severity), p.location));
    let shown_of = |s: Severity| problems.iter().filter(move |p| p.severity == s).take(SHOWN);
    for p in shown_of(Severity::Error).chain(shown_of(Severity::Warning)) {
        let tone = if p.severity == Severity::Error { Tone::Bad } else { Tone::Warning };
        // A file that is something else altogether is quoted whole.
        let text = shortened(&printable(&p.render(&path.display().to_string())), LONGEST);
        let word = if p.severity == Severity::Error { "error:" } else { "warning:" };
        let _ = writeln!(out, "{}", text.replacen(word, &style.paint(tone, word), 1));
        let line = p.location.and_then(|at| source.lines().nth(at.line - 1).map(|l| (at, l)));
        if let Some((at, line)) = line.filter(|(_, l)| !l.trim().is_empty()) {
            let number = format!("{:>5} | ", at.line);
            let (shown, column) = around(&line.replace('\t', " "), at.column - 1);
            let before: String = shown.chars().take(column).collect();
            let _ = writeln!(out, "{}{}", style.paint(Tone::Dim, &number), printable(&shown));
            let indent = number.len() + printable(&before).chars().count();
            let _ = writeln!(out, "{}{}", " ".repeat(indent), style.paint(tone, "^"));
        }
    }
    let count = |s: Severity| problems.iter().filter(|p| p.severity == s).count();
    let (errors, warnings) = (count(Severity::Error), count(Severity::Warning));
    let left_out = errors.saturating_sub(SHOWN) + warnings.saturating_sub(SHOWN);
    if left_out > 0 {
        let _ = writeln!(out, "... and {left_out} more");
    }
    if errors > 0 {
        let _ = writeln!(out, "{}", totals(errors, warnings));
    }
    out
}

/// A long line about one of its columns, and where that column then stands.
fn around(line: &str, column: usize) -> (String, usize) {
    const WIDTH: usize = 110;
    const BEFORE: usize = 40;
    let n = line.chars().count();
    if n <= WIDTH {
        return (line.to_string(), column);
    }
    let from = column.min(n).saturating_sub(BEFORE);
    let cut: String = line.chars().skip(from).take(WIDTH).collect();
    let (left, right) = (if from > 0 { "…" } else { "" }, if from + WIDTH < n { "…" } else { "" });
    (format!("{left}{cut}{right}"), column - from + usize::from(from > 0))
}

/// "2 errors, 1 warning"
pub(crate) fn totals(errors: usize, warnings: usize) -> String {
    format!("{}, {}", counted(errors, "error"), counted(warnings, "warning"))
}

/// Prints warnings of a file to standard error.
pub(crate) fn warn(path: &Path, source: &str, problems: &[Problem]) {
    if !problems.is_empty() {
        tell(render_problems(path, source, problems).trim_end());
    }
}

/// Prints lines to standard error; where nobody reads them any more nothing happens.
pub(crate) fn tell(lines: &str) {
    let _ = writeln!(std::io::stderr(), "{lines}");
}

/// Prints a note, as `format!` makes it, to standard error.
macro_rules! note {
    ($($text:tt)*) => { $crate::output::tell_of("note", format!($($text)*)) };
}

/// Prints a warning, as `format!` makes it, to standard error.
macro_rules! warning {
    ($($text:tt)*) => { $crate::output::tell_of("warning", format!($($text)*)) };
}

/// Prints `note: ...` or `warning: ...` to standard error, one line that holds no control characters.
pub(crate) fn tell_of(word: &str, text: impl AsRef<str>) {
    tell(&format!("{word}: {}", shortened(&printable(text.as_ref()), LONGEST_FAILURE)));
}

/// How to write to a stream.
pub(crate) fn style(stream: &impl IsTerminal) -> Style {
    let no_color = std::env::var("NO_COLOR").ok();
    let term = std::env::var("TERM").ok();
    let width = std::env::var("COLUMNS").ok().and_then(|c| c.parse().ok());
    Style::detect(stream.is_terminal(), no_color.as_deref(), term.as_deref(), width)
}

/// Like [`style`] for standard output, for reference texts: a line too long wraps, and no word is cut.
pub(crate) fn reference_style() -> Style {
    Style { width: 10_000, ..style(&std::io::stdout()) }
}

/// What became of standard output, and of outputs that could not be written.
#[derive(Default)]
struct Lost {
    /// Nobody reads standard output any more, or it cannot be written.
    is_closed: bool,
    failures: Vec<Failure>,
}

static LOST: Mutex<Lost> = Mutex::new(Lost { is_closed: false, failures: Vec::new() });

fn lost() -> MutexGuard<'static, Lost> {
    LOST.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Keeps a failure until the end, so that it takes nothing else along.
pub(crate) fn keep(failure: Failure) {
    lost().failures.push(failure);
}

/// Tells the failures that were kept; whether there are any.
pub(crate) fn tell_kept() -> bool {
    let failures = std::mem::take(&mut lost().failures);
    failures.iter().for_each(Failure::print);
    !failures.is_empty()
}

/// Prints text to standard output. One who has read enough may close a pipe; what cannot be written for another reason is a failure
/// that is told at the end. Neither keeps the verb from its work: files are written all the same.
pub(crate) fn print(text: &str) {
    let mut lost = lost();
    if lost.is_closed {
        return;
    }
    let mut out = std::io::stdout().lock();
    if let Err(e) = out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        lost.is_closed = true;
        if e.kind() != std::io::ErrorKind::BrokenPipe {
            lost.failures.push(Failure::text(format!("cannot write to the standard output: {e}")));
        }
    }
}

/// Prints JSON to standard output.
pub(crate) fn print_json(value: &serde_json::Value) {
    print(&format!("{value:#}\n"));
}

/// The pairs of a comparison, the static readings, and what is left unpaired or swapped.
///
/// * `agreement` - how each pair stands against noise, for one more column
pub(crate) fn pairs(a: &Assessment, agreement: Option<&[ModeAgreement]>, style: &Style) -> String {
    let has_labels = a.pairs.iter().any(|p| p.test_label.is_some());
    let mut columns = vec![("#", Align::Right)];
    if has_labels {
        columns.push(("test mode", Align::Left));
    }
    columns.extend([
        ("test Hz", Align::Right),
        ("model Hz", Align::Right),
        ("error", Align::Right),
        ("MAC", Align::Right),
    ]);
    if agreement.is_some() {
        columns.push(("chi2/n", Align::Right));
    }
    // Where all are sure, a line says so.
    let is_sure = a.pairs.iter().all(|p| p.probability.is_some_and(|v| v > SURE));
    let is_inferred = !is_sure && a.pairs.iter().any(|p| p.probability.is_some());
    if is_inferred {
        columns.push(("P", Align::Right));
    }
    columns.extend([("model mode", Align::Left), ("", Align::Left)]);
    let mut table = Table::new(columns);
    for (k, p) in a.pairs.iter().enumerate() {
        let mut row: Vec<Cell> = vec![(p.test_mode + 1).to_string().into()];
        if has_labels {
            row.push(p.test_label.as_deref().unwrap_or("–").into());
        }
        let error_tone = if p.error_percent.abs() > 5.0 { Tone::Warning } else { Tone::Plain };
        let mac = p.mac.map_or_else(|| "–".to_string(), |m| format!("{m:.3}"));
        let mac_tone = if p.mac.is_some_and(|m| m < 0.9) { Tone::Warning } else { Tone::Plain };
        row.extend([
            hertz(p.test_hz, 3).into(),
            hertz(p.model_hz, 3).into(),
            Cell::new(format!("{:+.2} %", p.error_percent), error_tone),
            Cell::new(mac, mac_tone),
        ]);
        if let Some(m) = agreement.and_then(|a| a.get(k)) {
            row.push(ratio(&m.misfit).into());
        }
        if is_inferred {
            let tone = if p.probability.is_some_and(|v| v < 0.9) { Tone::Warning } else { Tone::Plain };
            row.push(Cell::new(p.probability.map_or_else(|| "–".to_string(), probability), tone));
        }
        // A name that says nothing new takes no room.
        let name = if p.test_label.as_ref() == Some(&p.model_label) { "same" } else { &p.model_label };
        row.extend([name.into(), Cell::new(flags(p), Tone::Warning)]);
        table.row(row);
    }
    let mut out = if a.pairs.is_empty() { String::new() } else { table.render(style) };
    if is_sure && !a.pairs.is_empty() {
        let _ = writeln!(out, "each of these pairs has a probability above {SURE}");
    }
    for doubt in a.pairs.iter().filter_map(retune::update::AssessedPair::doubt) {
        wrapped(&mut out, &doubt, style);
    }
    out += &readings(a, style);
    for u in &a.unpaired_test {
        let label = u.label.as_deref().map(|l| format!(" ({l})")).unwrap_or_default();
        let why = u.reason.as_deref().map(|r| format!(": {r}")).unwrap_or_default();
        let text = format!("no partner: test mode {} at {:.3} Hz{label}{why}", u.mode + 1, u.frequency_hz);
        wrapped(&mut out, &text, style);
    }
    for u in &a.unpaired_model {
        let _ = writeln!(
            out,
            "not in the test: model mode {} at {:.3} Hz ({})",
            u.mode + 1,
            u.frequency_hz,
            u.label.as_deref().unwrap_or("no name")
        );
    }
    if !a.swapped.is_empty() {
        let mut order: Vec<_> = a.pairs.iter().collect();
        order.sort_by(|x, y| x.model_hz.total_cmp(&y.model_hz));
        let order: Vec<String> = order.iter().map(|p| (p.test_mode + 1).to_string()).collect();
        let _ = writeln!(out, "swapped: in the model the test modes come in the order {}", order.join(" "));
    }
    out
}

/// Above this a probability is not told to more digits.
const SURE: f64 = 0.999;

/// A probability in a column.
fn probability(p: f64) -> String {
    if p > SURE { format!(">{SURE}") } else { format!("{p:.3}") }
}

/// Columns of a MAC matrix side by side.
const MAC_COLUMNS: usize = 12;
/// Rows of a MAC matrix, at most.
const MAC_ROWS: usize = 24;

/// The MAC of every measured shape with the modes of the model.
pub(crate) fn mac_matrix(a: &Assessment, test: &TestData, style: &Style) -> String {
    let partner = |j: usize| a.pairs.iter().find(|p| p.test_mode == j).map(|p| p.model_mode);
    let hz: Vec<f64> = a.model_modes.iter().map(|m| m.frequency_hz).collect();
    matrix(&hz, test, &|i, j| a.mac[(i, j)], &partner, style)
}

/// The pairs and the MAC of a diagnosis, at its fitted base, and the pairs with what it names.
pub(crate) fn base_pairs(pairs: &BasePairs, with: Option<&BasePairs>, test: &TestData, style: &Style) -> String {
    if pairs.modes.is_empty() {
        return String::new();
    }
    let mut heads = vec![
        ("#", Align::Right),
        ("test Hz", Align::Right),
        ("model Hz", Align::Right),
        ("MAC", Align::Right),
        ("P", Align::Right),
    ];
    if with.is_some() {
        heads.extend([("with it Hz", Align::Right), ("MAC", Align::Right)]);
    }
    heads.push(("", Align::Left));
    let mut table = Table::new(heads);
    let number = |v: Option<f64>| v.map_or_else(|| "–".to_string(), |v| format!("{v:.3}"));
    let hz_of = |pairs: &BasePairs, k: usize| {
        let partner = pairs.modes.get(k).and_then(|m| m.model_mode);
        partner.and_then(|a| pairs.model_hz.get(a - 1).copied())
    };
    for (k, m) in pairs.modes.iter().enumerate() {
        let state = match m.model_mode {
            None => "no partner",
            Some(_) if m.by_user => "by `pair_with`",
            Some(_) => "",
        };
        let mut row: Vec<Cell> = vec![
            (k + 1).to_string().into(),
            format!("{:.3}", m.test_hz).into(),
            number(hz_of(pairs, k)).into(),
            number(m.mac).into(),
            m.probability.map_or_else(|| "–".to_string(), probability).into(),
        ];
        if let Some(with) = with {
            row.push(number(hz_of(with, k)).into());
            row.push(number(with.modes.get(k).and_then(|m| m.mac)).into());
        }
        row.push(Cell::new(state, Tone::Warning));
        table.row(row);
    }
    let mut out = String::new();
    let then = if with.is_some() { "; with it: with what is named" } else { "" };
    let caption = format!("pairs of the fitted model with {}; P: that the two are one mode{then}", pairs.test);
    wrapped(&mut out, &caption, style);
    out += &table.render(style);
    for (k, m) in pairs.modes.iter().enumerate() {
        if let Some(reason) = &m.reason {
            wrapped(&mut out, &format!("no partner: test mode {} at {:.3} Hz: {reason}", k + 1, m.test_hz), style);
        }
    }
    let partner = |j: usize| pairs.modes.get(j).and_then(|m| m.model_mode).map(|a| a - 1);
    out + &matrix(&pairs.model_hz, test, &|i, j| pairs.mac[i][j], &partner, style)
}

/// A MAC matrix, rows modes of the model up to the last that matters, pairs marked.
fn matrix(
    model_hz: &[f64],
    test: &TestData,
    mac: &dyn Fn(usize, usize) -> f64,
    partner: &dyn Fn(usize) -> Option<usize>,
    style: &Style,
) -> String {
    let shaped: Vec<usize> = (0..test.modes.len()).filter(|&j| test.modes[j].shape.is_some()).collect();
    if shaped.is_empty() || model_hz.is_empty() {
        return String::new();
    }
    let highest = test.modes.iter().map(|m| m.frequency_hz.value).fold(0.0, f64::max);
    let last = shaped.iter().filter_map(|&j| partner(j)).max().unwrap_or(0);
    let near = model_hz.iter().filter(|f| **f <= 1.2 * highest).count();
    let rows = near.max(last + 1).max(1).min(model_hz.len());
    let shown = rows.min(MAC_ROWS.max(last + 1));
    let mut out = String::new();
    for block in shaped.chunks(MAC_COLUMNS) {
        let heads: Vec<String> = block.iter().map(|&j| format!("{}", j + 1)).collect();
        let mut columns = vec![("MAC", Align::Right), ("model Hz", Align::Right)];
        columns.extend(heads.iter().map(|h| (h.as_str(), Align::Right)));
        let mut table = Table::new(columns);
        for i in 0..shown {
            let mut row: Vec<Cell> = vec![(i + 1).to_string().into(), format!("{:.3}", model_hz[i]).into()];
            row.extend(block.iter().map(|&j| {
                let tone = if partner(j) == Some(i) { Tone::Good } else { Tone::Plain };
                Cell::new(format!("{:.2}", mac(i, j)), tone)
            }));
            table.row(row);
        }
        out += "\n";
        out += &table.render(style);
    }
    if shown < rows {
        let _ = writeln!(out, "{} higher modes of the model are in --json", rows - shown);
    }
    out
}

/// Readings of static tests beside those of the model.
fn readings(a: &Assessment, style: &Style) -> String {
    if a.readings.is_empty() {
        return functions(a);
    }
    let mut table = Table::new([
        ("static test", Align::Left),
        ("sensor", Align::Left),
        ("test", Align::Right),
        ("model", Align::Right),
        ("unit", Align::Left),
        ("error", Align::Right),
    ]);
    for r in &a.readings {
        let (unit, factor) = if r.is_angle { ("deg", 180.0 / std::f64::consts::PI) } else { ("mm", 1e3) };
        let number = |v: f64| retune_report::text::number(factor * v);
        let tone = if (r.model - r.measured).abs() > 3.0 * r.sd { Tone::Warning } else { Tone::Plain };
        table.row([
            r.test.as_str().into(),
            r.sensor.as_str().into(),
            number(r.measured).into(),
            number(r.model).into(),
            unit.into(),
            Cell::new(format!("{:+.2} %", 100.0 * (r.model / r.measured - 1.0)), tone),
        ]);
    }
    table.render(style) + &functions(a)
}

/// What the functions of the test say, in a line.
fn functions(a: &Assessment) -> String {
    a.functions.map_or_else(String::new, |f| {
        let rms = (f.chi_squared / f.n_values as f64).sqrt();
        let (n, rms) = (f.n_values, retune_report::text::number(rms));
        format!("functions: {n} amplitudes, {rms} standard deviations off (root mean square)\n")
    })
}

fn flags(p: &retune::update::AssessedPair) -> String {
    use retune::correlation::PairFlag;
    let by_user = p.by_user.then_some("by `pair_with`");
    let words = p.flags.iter().map(|f| match f {
        PairFlag::LowMac => "low MAC",
        PairFlag::FarFrequency => "far apart",
        PairFlag::DifferentFamily => "different symmetry!",
        PairFlag::Ambiguous => "ambiguous",
    });
    by_user.into_iter().chain(words).collect::<Vec<&str>>().join(", ")
}

/// Tells remarks, with the file that they are about.
pub(crate) fn remarks(about: Option<&Path>, remarks: &[Remark]) {
    let place = about.map_or_else(String::new, |path| format!("{}: ", path.display()));
    for remark in remarks {
        match remark {
            Remark::Note(text) => note!("{text}"),
            Remark::Warning(text) => warning!("{place}{text}"),
        }
    }
}

/// Problems of one severity as JSON.
pub(crate) fn problems_json(problems: &[Problem], severity: Severity) -> Vec<serde_json::Value> {
    problems
        .iter()
        .filter(|p| p.severity == severity)
        .map(|p| {
            serde_json::json!({
                "path": p.path,
                "line": p.location.map(|l| l.line),
                "column": p.location.map(|l| l.column),
                "message": p.message,
            })
        })
        .collect()
}
