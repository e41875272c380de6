//! What a terminal prints: aligned tables, bars, a cost history in one line. Pure functions from data to text; the
//! command line decides where it goes.
//!
//! Colour is decoration: every state has a sign and a word, so that text without colour says the same. Names come from
//! files and may hold control characters; they are replaced before they reach a terminal.

pub mod agreement;
mod findings;
mod summary;

pub use findings::{FILES, diagnosis, steps};
pub use summary::summary;

use retune::catalogue::counted;
use unicode_width::{UnicodeWidthChar, UnicodeWidthStr};

/// How to write: with colour or not, and how wide.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Style {
    /// Whether escape sequences for colour are written.
    pub color: bool,
    /// Columns of the terminal.
    pub width: usize,
}

impl Default for Style {
    /// No colour, 100 columns: what goes into a file.
    fn default() -> Self {
        Self { color: false, width: 100 }
    }
}

impl Style {
    /// The style for an output.
    ///
    /// * `is_terminal` - whether the output is a terminal: never colour otherwise
    /// * `no_color` - value of the environment variable `NO_COLOR`: anything but empty switches colour off
    /// * `term` - value of `TERM`: `dumb` switches colour off
    /// * `width` - columns, when known; at least 40, 100 when not known
    ///
    /// # Source
    /// NO_COLOR, an informal standard, <https://no-color.org>.
    pub fn detect(is_terminal: bool, no_color: Option<&str>, term: Option<&str>, width: Option<usize>) -> Self {
        let color = is_terminal && no_color.is_none_or(str::is_empty) && term != Some("dumb");
        Self { color, width: width.unwrap_or(100).max(40) }
    }

    /// `text` in the tone, when colour is on.
    pub fn paint(&self, tone: Tone, text: &str) -> String {
        let code = match tone {
            Tone::Plain => "",
            Tone::Strong => "1",
            Tone::Dim => "2",
            Tone::Good => "32",
            Tone::Warning => "33",
            Tone::Bad => "31",
        };
        if self.color && !code.is_empty() && !text.is_empty() {
            format!("\u{1b}[{code}m{text}\u{1b}[0m")
        } else {
            text.into()
        }
    }
}

/// How a piece of text is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Tone {
    /// As it is.
    #[default]
    Plain,
    /// Important.
    Strong,
    /// Beside the point.
    Dim,
    /// As it should be; the text itself must say so too.
    Good,
    /// To look at; the text itself must say so too.
    Warning,
    /// Wrong; the text itself must say so too.
    Bad,
}

/// Where text stands in its column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    /// Words.
    Left,
    /// Numbers.
    Right,
}

/// A cell of a table.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Cell {
    text: String,
    tone: Tone,
}

impl Cell {
    /// Text in a tone.
    pub fn new(text: impl AsRef<str>, tone: Tone) -> Self {
        Self { text: printable(text.as_ref()), tone }
    }
}

/// A probability with as many digits as it deserves, never a rounded 0 or 1.
pub fn chance(p: f64) -> String {
    match p {
        p if !p.is_finite() => "–".into(),
        p if p < 0.001 => "< 0.1 %".into(),
        p if p < 1.0 && p > 0.999 => "> 99.9 %".into(),
        p => format!("{:.1} %", 100.0 * p),
    }
}

impl<T: AsRef<str>> From<T> for Cell {
    fn from(text: T) -> Self {
        Self::new(text, Tone::Plain)
    }
}

/// A table with aligned columns, no wider than its style allows.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Table {
    heads: Vec<(String, Option<Align>)>,
    rows: Vec<Vec<Cell>>,
    wraps_last: bool,
}

/// No column of words is cut below this.
const NARROWEST: usize = 6;
/// No column that wraps is made narrower than this.
const WRAPPED: usize = 24;
const GAP: usize = 2;

impl Table {
    /// A table with these columns.
    pub fn new<'a>(columns: impl IntoIterator<Item = (&'a str, Align)>) -> Self {
        let heads = columns.into_iter().map(|(head, align)| (head.into(), Some(align))).collect();
        Self { heads, rows: Vec::new(), wraps_last: false }
    }

    /// Lets the last column take several lines instead of being cut: for names that somebody will type.
    #[must_use]
    pub fn wrapping_last(mut self) -> Self {
        self.wraps_last = true;
        self
    }

    /// Columns that the table needs when nothing is cut.
    pub fn natural_width(&self) -> usize {
        (0..self.heads.len()).map(|k| self.widest(k)).sum::<usize>() + GAP * self.heads.len().saturating_sub(1)
    }

    fn widest(&self, k: usize) -> usize {
        self.rows.iter().map(|r| r[k].text.width()).chain([self.heads[k].0.width()]).max().unwrap_or(0)
    }

    /// Adds a row; cells beyond the columns are left out, missing ones are empty.
    pub fn row(&mut self, cells: impl IntoIterator<Item = Cell>) -> &mut Self {
        let mut row: Vec<Cell> = cells.into_iter().take(self.heads.len()).collect();
        row.resize(self.heads.len(), Cell::default());
        self.rows.push(row);
        self
    }

    /// The table as lines, each ended by a line feed, nothing after the last column.
    ///
    /// When the columns need more than the style's width, the widest columns of words are cut with an ellipsis, or the
    /// last one is wrapped after [`Self::wrapping_last`]; numbers are never cut.
    pub fn render(&self, style: &Style) -> String {
        let n = self.heads.len();
        let left = |k: usize| self.heads[k].1 != Some(Align::Right);
        let mut widths: Vec<usize> = (0..n).map(|k| self.widest(k)).collect();
        let wrapped = self.wraps_last.then_some(n.saturating_sub(1));
        let narrowest = |k: usize| if wrapped == Some(k) { WRAPPED } else { NARROWEST };
        while widths.iter().sum::<usize>() + GAP * n.saturating_sub(1) > style.width {
            let can = |k: &usize| left(*k) && widths[*k] > narrowest(*k);
            // The column that wraps gives way first: it loses nothing.
            let first = wrapped.filter(can);
            let Some(k) = first.or_else(|| (0..n).filter(can).max_by_key(|k| (widths[*k], n - *k))) else { break };
            widths[k] -= 1;
        }
        let line = |cells: &[Cell]| {
            let mut out = String::new();
            for (k, cell) in cells.iter().enumerate() {
                let text = shorten(&cell.text, widths[k]);
                let pad = " ".repeat(widths[k].saturating_sub(text.width()));
                let painted = style.paint(cell.tone, &text);
                if k > 0 {
                    out.push_str(&" ".repeat(GAP));
                }
                if left(k) {
                    out.push_str(&painted);
                    out.push_str(&pad);
                } else {
                    out.push_str(&pad);
                    out.push_str(&painted);
                }
            }
            out.truncate(out.trim_end_matches(' ').len());
            out.push('\n');
            out
        };
        let heads: Vec<Cell> = self.heads.iter().map(|(h, _)| Cell::new(h, Tone::Dim)).collect();
        let mut out = line(&heads);
        for row in &self.rows {
            let Some(k) = wrapped.filter(|&k| row[k].text.width() > widths[k]) else {
                out.push_str(&line(row));
                continue;
            };
            let mut cells = row.clone();
            for part in broken(&row[k].text, widths[k]) {
                cells[k] = Cell { text: part, tone: row[k].tone };
                out.push_str(&line(&cells));
                cells.fill(Cell::default());
            }
        }
        out
    }
}

/// Text on lines of at most `width` columns, broken after blanks and after the signs that join the parts of a name;
/// continued lines stand two columns in. Nothing is lost but blanks.
pub fn broken(text: &str, width: usize) -> Vec<String> {
    let mut lines = Vec::new();
    let mut line = String::new();
    let width = width.max(4);
    let mut rest = text;
    while !rest.is_empty() {
        let end = rest.find([' ', '+', '@', ',', '/', ';']).map_or(rest.len(), |i| i + 1);
        let (piece, after) = rest.split_at(end);
        rest = after;
        if line.width() + piece.trim_end().width() > width && !line.trim().is_empty() {
            lines.push(line.trim_end().to_string());
            line = "  ".into();
        }
        // A piece longer than a line is broken anywhere.
        for c in piece.chars() {
            if line.width() + c.width().unwrap_or(0) > width && c != ' ' {
                lines.push(std::mem::replace(&mut line, "  ".into()).trim_end().to_string());
            }
            line.push(c);
        }
    }
    if !line.trim().is_empty() {
        lines.push(line.trim_end().to_string());
    }
    lines
}

/// Words on lines of at most `width` columns; a longer word stands alone, cut.
pub fn wrap(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        let word = shorten(word, width);
        match lines.last_mut() {
            Some(line) if line.width() + 1 + word.width() <= width => {
                line.push(' ');
                line.push_str(&word);
            }
            _ => lines.push(word),
        }
    }
    lines
}

/// Words on lines of at most `width` columns, a longer word alone and whole. The blanks before the first word stay; lines after
/// the first begin with `indent`.
pub fn paragraph(text: &str, indent: &str, width: usize) -> String {
    let lead = text.len() - text.trim_start().len();
    let mut out = text[..lead].to_string();
    let mut column = lead;
    for (i, word) in text.split_whitespace().enumerate() {
        if i > 0 && column + 1 + word.width() > width {
            out.push('\n');
            out += indent;
            column = indent.width();
        } else if i > 0 {
            out.push(' ');
            column += 1;
        }
        out += word;
        column += word.width();
    }
    out.push('\n');
    out
}

/// Text with its control characters escaped as in Rust and JSON (`\\n`, `\\u{1b}`): they could move the cursor, recolour the terminal
/// or turn the direction of writing.
pub fn printable(text: &str) -> String {
    let hidden = |c: char| c.is_control() || matches!(c, '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if hidden(c) { out.extend(c.escape_default()) } else { out.push(c) }
    }
    out
}

/// At most `width` columns, cut with an ellipsis: of a sentence the end, of a name the middle, for names differ at their ends.
pub fn shorten(text: &str, width: usize) -> String {
    if text.width() <= width {
        return text.into();
    }
    if width > 6 && !text.contains(' ') {
        let end: Vec<char> = text.chars().rev().take((width - 1) / 2).collect();
        let end: String = end.into_iter().rev().collect();
        let begin: String = text.chars().take(width - 1 - end.chars().count()).collect();
        let both = format!("{begin}…{end}");
        if both.width() <= width {
            return both;
        }
    }
    let mut out = String::new();
    let mut used = 1;
    for c in text.chars() {
        used += c.width().unwrap_or(0);
        if used > width {
            break;
        }
        out.push(c);
    }
    if width > 0 {
        out.push('…');
    }
    out
}

const EIGHTHS: [char; 8] = ['▏', '▎', '▍', '▌', '▋', '▊', '▉', '█'];
const HEIGHTS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

/// A horizontal bar: `fraction` (0 to 1, clamped; NaN is empty) of `width` columns, in eighths of a column.
pub fn bar(fraction: f64, width: usize) -> String {
    let eighths = (fraction.clamp(0.0, 1.0) * (width * 8) as f64).round();
    let eighths = if eighths.is_finite() { eighths as usize } else { 0 };
    let mut out = "█".repeat(eighths / 8);
    if !eighths.is_multiple_of(8) {
        out.push(EIGHTHS[eighths % 8 - 1]);
    }
    out
}

/// A line of `width` bars of eight heights: each the mean of its share of the values. Values that are not finite leave
/// a gap.
pub fn sparkline(values: &[f64], width: usize) -> String {
    let n = values.len();
    let width = width.min(n);
    let means: Vec<f64> = (0..width)
        .map(|k| {
            let part = &values[k * n / width..(k + 1) * n / width];
            let known: Vec<f64> = part.iter().copied().filter(|v| v.is_finite()).collect();
            if known.is_empty() { f64::NAN } else { known.iter().sum::<f64>() / known.len() as f64 }
        })
        .collect();
    let (low, high) = means
        .iter()
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let place = |v: &f64| match v {
        v if !v.is_finite() => ' ',
        _ if high <= low => HEIGHTS[0],
        v => HEIGHTS[((v - low) / (high - low) * 7.0).round() as usize],
    };
    means.iter().map(place).collect()
}

/// The history of a cost on one line, by evaluations and with the cost on a logarithmic scale:
/// `0.3644 █▆▅▃▂▁▁ 0.0518  20504 evaluations`. Empty when there is no point.
///
/// * `evaluations` - evaluations so far, ascending
/// * `best` - best cost so far, one an entry of `evaluations`
pub fn cost_history(evaluations: &[u64], best: &[f64], width: usize) -> String {
    let points: Vec<(u64, f64)> =
        evaluations.iter().copied().zip(best.iter().copied()).filter(|p| p.1.is_finite()).collect();
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return String::new() };
    let (ends, tail) =
        (format!("{} ", number(first.1)), format!(" {}  {}", number(last.1), counted(last.0 as usize, "evaluation")));
    let room = width.saturating_sub(ends.width() + tail.width()).clamp(8, 60);
    let span = (last.0 - first.0.min(last.0)).max(1) as f64;
    // The best cost at evenly spaced evaluations: a long stage must look long.
    let values: Vec<f64> = (0..room)
        .map(|k| {
            let until = first.0 + (span * (k + 1) as f64 / room as f64).round() as u64;
            let at = points.partition_point(|p| p.0 <= until).max(1) - 1;
            points[at].1.max(f64::MIN_POSITIVE).ln()
        })
        .collect();
    format!("{ends}{}{tail}", sparkline(&values, room))
}

/// A frequency with these decimals, or where they would lose digits, two significant digits more than that.
pub fn hertz(value: f64, decimals: usize) -> String {
    let size = value.abs();
    let places = decimals as i32;
    if size == 0.0 || !value.is_finite() || size >= 10_f64.powi(3 - places) {
        return format!("{value:.decimals$}");
    }
    if size < 1e-4 {
        return format!("{value:.*e}", decimals + 1);
    }
    let digits = f64::from(places + 1) - size.log10().floor();
    format!("{value:.*}", digits as usize)
}

/// Four significant digits; powers of ten outside 1e-3 to 1e6.
pub fn number(value: f64) -> String {
    retune::units::four_digits(value)
}

/// Three significant digits, for estimates with their intervals.
pub fn brief(value: f64) -> String {
    let size = value.abs();
    if !value.is_finite() || size == 0.0 || !(1e-3..1e5).contains(&size) {
        return if size == 0.0 || !value.is_finite() { number(value) } else { format!("{value:.2e}") };
    }
    let decimals = (2.0 - size.log10().floor()).max(0.0) as usize;
    format!("{value:.decimals$}")
}

/// A fraction as a percentage with its sign.
pub fn percent(fraction: f64) -> String {
    if fraction.is_finite() { format!("{:+.1} %", 100.0 * fraction) } else { "–".into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn colour_needs_a_terminal_and_no_objection() {
        assert!(Style::detect(true, None, Some("xterm"), Some(80)).color);
        assert!(Style::detect(true, Some(""), None, None).color);
        assert!(!Style::detect(true, Some("1"), None, None).color);
        assert!(!Style::detect(false, None, None, None).color);
        assert!(!Style::detect(true, None, Some("dumb"), None).color);
        assert_eq!(Style::detect(false, None, None, Some(3)).width, 40);
    }

    #[test]
    fn columns_line_up_by_what_is_seen() {
        let mut table = Table::new([("mode", Align::Left), ("Hz", Align::Right), ("", Align::Left)]);
        table.row(["α 模態".into(), "5.67".into(), Cell::new("✓ pass", Tone::Good)]);
        table.row(["tip".into(), "28.60".into(), Cell::new("✕ fail", Tone::Bad)]);
        let plain = table.render(&Style::default());
        assert_eq!(plain, "mode       Hz\nα 模態   5.67  ✓ pass\ntip     28.60  ✕ fail\n");
        let coloured = table.render(&Style { color: true, width: 100 });
        assert!(coloured.contains("\u{1b}[32m✓ pass\u{1b}[0m"));
        let bare: String = strip(&coloured);
        assert_eq!(bare.lines().map(str::trim_end).collect::<Vec<_>>(), plain.lines().collect::<Vec<_>>());
    }

    fn strip(text: &str) -> String {
        let mut out = String::new();
        let mut skip = false;
        for c in text.chars() {
            match c {
                '\u{1b}' => skip = true,
                'm' if skip => skip = false,
                _ if skip => {}
                c => out.push(c),
            }
        }
        out
    }

    #[test]
    fn a_low_frequency_keeps_its_digits() {
        let four: Vec<String> = [16.450_41, 0.1, 0.051_234_567, 9.4321e-5, 0.0].iter().map(|f| hertz(*f, 4)).collect();
        assert_eq!(four, ["16.4504", "0.1000", "0.0512346", "9.43210e-5", "0.0000"]);
        let three: Vec<String> = [1_234.567_89, 1.0, 0.280_312_3].iter().map(|f| hertz(*f, 3)).collect();
        assert_eq!(three, ["1234.568", "1.000", "0.28031"]);
    }

    #[test]
    fn words_give_way_before_numbers() {
        let mut table = Table::new([("name", Align::Left), ("value", Align::Right)]);
        table.row(["a very long name that does not fit in forty columns".into(), "123456.789".into()]);
        let text = table.render(&Style { color: false, width: 40 });
        assert!(text.contains("…") && text.contains("123456.789"));
        assert!(text.lines().all(|l| l.width() <= 40));
    }

    #[test]
    fn a_name_to_be_typed_is_wrapped_and_never_cut() {
        let mut table = Table::new([("P", Align::Right), ("hypothesis", Align::Left)]).wrapping_last();
        let id = "mass-offset@left_wing_outboard_panel+right_wing_outboard_panel.y_lumps";
        table.row(["99.9 %".into(), id.into()]);
        let text = table.render(&Style { color: false, width: 40 });
        assert_eq!(text.lines().next(), Some("     P  hypothesis"));
        assert!(text.lines().all(|l| l.width() <= 40) && !text.contains('…'), "{text}");
        let joined: String = text.lines().skip(1).map(str::trim).collect();
        assert_eq!(joined, format!("99.9 %  {id}"));
        for width in 4..40 {
            let back: String = broken(id, width).iter().map(|l| l.trim_start()).collect();
            assert_eq!(back, id);
            assert!(broken(id, width).iter().all(|l| l.width() <= width), "{width}");
        }
    }

    #[test]
    fn chances_are_never_rounded_to_certainty() {
        assert_eq!(
            [chance(0.0), chance(1e-9), chance(0.5), chance(0.99999), chance(1.0)].join(" "),
            "< 0.1 % < 0.1 % 50.0 % > 99.9 % 100.0 %"
        );
    }

    #[test]
    fn control_characters_cannot_reach_the_terminal() {
        let cell = Cell::from("a\u{1b}[31mb\r\n\u{202e}c");
        assert!(!cell.text.contains(|c: char| c.is_control() || c == '\u{202e}'));
    }

    #[test]
    fn bars_and_sparklines() {
        assert_eq!(bar(0.5, 4), "██");
        assert_eq!(bar(0.5 + 1.0 / 64.0, 8), "████▏");
        assert_eq!((bar(f64::NAN, 4), bar(9.0, 3), bar(0.1, 0)), (String::new(), "███".into(), String::new()));
        assert_eq!(sparkline(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0], 8), "▁▂▃▄▅▆▇█");
        assert_eq!(sparkline(&[1.0, 1.0, f64::NAN], 3), "▁▁ ");
        assert_eq!(sparkline(&[], 9), "");
    }

    #[test]
    fn a_cost_history_reads_from_start_to_end() {
        let line = cost_history(&[0, 10, 1000], &[0.3644, 0.1, 0.0518], 80);
        assert!(line.starts_with("0.3644 ") && line.ends_with(" 0.05180  1000 evaluations"), "{line}");
        assert_eq!(cost_history(&[], &[], 80), "");
    }

    proptest! {
        #[test]
        fn no_line_is_wider_than_asked_unless_numbers_need_it(
            rows in proptest::collection::vec(("\\PC{0,60}", "\\PC{0,60}", -1e5_f64..1e5), 0..8),
            width in 40_usize..120,
        ) {
            let mut table = Table::new([("a", Align::Left), ("b", Align::Left), ("c", Align::Right)]);
            for (a, b, c) in &rows {
                table.row([a.into(), b.into(), number(*c).into()]);
            }
            let text = table.render(&Style { color: false, width });
            prop_assert_eq!(text.lines().count(), rows.len() + 1);
            prop_assert!(text.lines().all(|l| l.width() <= width + 1), "{text}");
        }

        #[test]
        fn any_values_make_a_sparkline(values in proptest::collection::vec(any::<f64>(), 0..200), width in 0_usize..90) {
            prop_assert_eq!(sparkline(&values, width).chars().count(), width.min(values.len()));
        }
    }
}
