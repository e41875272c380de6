//! Axes, ticks and marks of a single figure, written by hand so that the file stays small and editable.

use super::super::html::push_markup;
use std::fmt::Write as _;

/// Ink of test, model and what was before; safe for colour-blind readers and on a grey printer.
pub(super) const TEST: &str = "#c24e00";
pub(super) const MODEL: &str = "#0b62a8";
pub(super) const BEFORE: &str = "#7b8794";
pub(super) const INK: &str = "#17202b";
pub(super) const SOFT: &str = "#566373";
pub(super) const GRID: &str = "#dfe4ea";

/// Millimetres on paper to user units: 10 units a millimetre.
const UNITS_PER_MM: f64 = 10.0;
/// Body text, 8 pt.
pub(super) const TEXT: f64 = 28.0;

/// A canvas in units of a tenth of a millimetre.
pub(super) struct Canvas {
    body: String,
    pub(super) width: f64,
    pub(super) height: f64,
}

impl Canvas {
    pub(super) fn new(width_mm: f64, height_mm: f64) -> Self {
        Self { body: String::new(), width: width_mm * UNITS_PER_MM, height: height_mm * UNITS_PER_MM }
    }

    pub(super) fn line(&mut self, from: [f64; 2], to: [f64; 2], ink: &str, width: f64, dash: &str) {
        let dash = if dash.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{dash}\"") };
        let _ = writeln!(
            self.body,
            "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"{ink}\" stroke-width=\"{width}\"{dash}/>",
            from[0], from[1], to[0], to[1]
        );
    }

    /// A line through points; a point that is not finite breaks it.
    pub(super) fn path(&mut self, points: impl IntoIterator<Item = [f64; 2]>, ink: &str, width: f64, dash: &str) {
        let mut d = String::new();
        let mut pen = 'M';
        for [x, y] in points {
            if x.is_finite() && y.is_finite() {
                let _ = write!(d, "{pen}{x:.1} {y:.1}");
                pen = 'L';
            } else {
                pen = 'M';
            }
        }
        if d.is_empty() {
            return;
        }
        let dash = if dash.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{dash}\"") };
        let _ = writeln!(
            self.body,
            "<path d=\"{d}\" fill=\"none\" stroke=\"{ink}\" stroke-width=\"{width}\" stroke-linejoin=\"round\"{dash}/>"
        );
    }

    pub(super) fn polygon(&mut self, points: &[[f64; 2]], fill: &str, opacity: f64) {
        let list = points.iter().fold(String::new(), |mut s, [x, y]| {
            let _ = write!(s, "{x:.1},{y:.1} ");
            s
        });
        let _ =
            writeln!(self.body, "<polygon points=\"{}\" fill=\"{fill}\" fill-opacity=\"{opacity}\"/>", list.trim_end());
    }

    pub(super) fn rect(&mut self, [x, y]: [f64; 2], [w, h]: [f64; 2], fill: &str, stroke: &str) {
        let _ = writeln!(
            self.body,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{w:.1}\" height=\"{h:.1}\" fill=\"{fill}\" stroke=\"{stroke}\" stroke-width=\"2\"/>"
        );
    }

    /// The outline of a rectangle.
    pub(super) fn frame(&mut self, [x, y]: [f64; 2], [w, h]: [f64; 2], ink: &str, width: f64) {
        let _ = writeln!(
            self.body,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{w:.1}\" height=\"{h:.1}\" fill=\"none\" stroke=\"{ink}\" stroke-width=\"{width}\"/>"
        );
    }

    pub(super) fn circle(&mut self, [x, y]: [f64; 2], r: f64, fill: &str, stroke: &str) {
        let _ = writeln!(
            self.body,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r}\" fill=\"{fill}\" stroke=\"{stroke}\" stroke-width=\"4\"/>"
        );
    }

    pub(super) fn diamond(&mut self, [x, y]: [f64; 2], r: f64, fill: &str) {
        self.polygon(&[[x, y - r], [x + r, y], [x, y + r], [x - r, y]], fill, 1.0);
    }

    /// Text at a point; `anchor` is `start`, `middle` or `end`; `turn` in degrees.
    pub(super) fn text(&mut self, [x, y]: [f64; 2], text: &str, size: f64, anchor: &str, ink: &str, turn: f64) {
        let turn = if turn == 0.0 { String::new() } else { format!(" transform=\"rotate({turn} {x:.1} {y:.1})\"") };
        let _ = write!(
            self.body,
            "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" text-anchor=\"{anchor}\" fill=\"{ink}\"{turn}>"
        );
        push_markup(&mut self.body, text);
        self.body.push_str("</text>\n");
    }

    /// Text with a white rim, readable over lines.
    pub(super) fn halo(&mut self, [x, y]: [f64; 2], text: &str, size: f64, ink: &str) {
        let _ = write!(
            self.body,
            "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" fill=\"{ink}\" stroke=\"#ffffff\" stroke-width=\"6\" \
             stroke-linejoin=\"round\" paint-order=\"stroke\">"
        );
        push_markup(&mut self.body, text);
        self.body.push_str("</text>\n");
    }

    /// The whole file.
    pub(super) fn finish(self, title: &str) -> String {
        let mut out = String::with_capacity(self.body.len() + 512);
        let _ = write!(
            out,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{:.1}mm\" height=\"{:.1}mm\" viewBox=\"0 0 {:.0} {:.0}\" \
             font-family=\"Helvetica, Arial, sans-serif\" role=\"img\">\n<title>",
            self.width / UNITS_PER_MM,
            self.height / UNITS_PER_MM,
            self.width,
            self.height
        );
        push_markup(&mut out, title);
        out.push_str("</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n");
        out.push_str(&self.body);
        out.push_str("</svg>\n");
        out
    }
}

/// One axis: its range and whether it counts decades.
#[derive(Clone, Copy)]
pub(super) struct Axis {
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) log: bool,
}

impl Axis {
    /// A linear axis over the finite values, with a little room; from zero when `zero`.
    pub(super) fn linear(values: impl IntoIterator<Item = f64>, zero: bool) -> Self {
        let (mut low, mut high) = ends(values.into_iter().filter(|v| v.is_finite()));
        if zero {
            low = low.min(0.0);
            high = high.max(0.0);
        }
        if high <= low {
            high = low + 1.0;
        }
        Self { low, high: high + 0.04 * (high - low), log: false }
    }

    /// A logarithmic axis over the positive values, at most nine decades down from the top.
    pub(super) fn log(values: impl IntoIterator<Item = f64>) -> Self {
        let (low, high) = ends(values.into_iter().filter(|v| v.is_finite() && *v > 0.0));
        let (low, high) = if low > 0.0 { (low.max(high * 1e-9), high) } else { (0.1, 1.0) };
        let high = if high <= low * 1.0001 { low * 10.0 } else { high };
        Self { low: low / 1.15, high: high * 1.15, log: true }
    }

    /// 0 at the low end, 1 at the high end.
    pub(super) fn place(&self, v: f64) -> f64 {
        if self.log {
            if v > 0.0 { (v / self.low).ln() / (self.high / self.low).ln() } else { f64::NAN }
        } else {
            (v - self.low) / (self.high - self.low)
        }
    }

    /// Round values inside the range, with their labels.
    pub(super) fn ticks(&self) -> Vec<(f64, String)> {
        if self.log {
            let (first, last) = (self.low.log10().ceil() as i32, self.high.log10().floor() as i32);
            let every = ((last - first) / 6 + 1).max(1) as usize;
            let mut ticks: Vec<_> = (first..=last).step_by(every).map(|d| (10f64.powi(d), power(d))).collect();
            if ticks.len() < 2 {
                let base = 10f64.powi(self.low.log10().floor() as i32);
                let parts = [1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 30.0, 50.0, 100.0].map(|m| m * base);
                ticks = parts.iter().filter(|v| **v >= self.low && **v <= self.high).map(|v| (*v, short(*v))).collect();
            }
            return ticks;
        }
        if (self.low, self.high) == (-180.0, 180.0) {
            return [-180, -90, 0, 90, 180].map(|d| (f64::from(d), d.to_string().replace('-', "−"))).to_vec();
        }
        let rough = (self.high - self.low) / 7.0;
        let size = 10f64.powf(rough.log10().floor());
        let step =
            [1.0, 2.0, 2.5, 5.0, 10.0].into_iter().map(|m| m * size).find(|s| *s >= rough).unwrap_or(10.0 * size);
        let first = (self.low / step - 1e-9).ceil() as i64;
        let last = (self.high / step + 1e-9).floor() as i64;
        let decimals =
            (-(step.log10() + 1e-9).floor()).max(0.0) as usize + usize::from((step / size - 2.5).abs() < 1e-6);
        (first..=last.min(first + 20))
            .map(|i| (i as f64 * step, format!("{:.decimals$}", i as f64 * step).replace('-', "−")))
            .collect()
    }
}

fn ends(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if low <= high { (low, high) } else { (0.0, 0.0) }
}

/// A decade as plain digits where they are few: raised digits are missing in some fonts.
fn power(d: i32) -> String {
    match d {
        0..=4 => 10_i32.pow(d.unsigned_abs()).to_string(),
        -4..=-1 => format!("{:.*}", d.unsigned_abs() as usize, 10f64.powi(d)),
        _ => format!("1e{d}").replace('-', "−"),
    }
}

/// Three or four significant digits.
pub(super) fn short(v: f64) -> String {
    if !v.is_finite() {
        return "–".into();
    }
    let size = v.abs();
    let text = if size == 0.0 {
        "0".into()
    } else if !(1e-3..1e5).contains(&size) {
        format!("{v:.2e}")
    } else {
        let decimals = (2.0 - size.log10().floor()).max(0.0) as usize;
        let text = format!("{v:.decimals$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
    };
    text.replace('-', "−")
}

/// A rectangle with an x and a y axis.
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) width: f64,
    pub(super) height: f64,
    pub(super) x: Axis,
    pub(super) y: Axis,
}

impl Frame {
    /// The point of a pair of values.
    pub(super) fn at(&self, x: f64, y: f64) -> [f64; 2] {
        [self.left + self.width * self.x.place(x), self.top + self.height * (1.0 - self.y.place(y))]
    }

    /// Grid, ticks, titles; `x_ticks` false leaves the x axis to the frame below.
    pub(super) fn draw(&self, c: &mut Canvas, x_title: &str, y_title: &str, x_ticks: bool) {
        let (right, bottom) = (self.left + self.width, self.top + self.height);
        for (v, label) in self.x.ticks() {
            let [x, _] = self.at(v, self.y.low);
            c.line([x, self.top], [x, bottom], GRID, 1.5, "");
            if x_ticks {
                c.text([x, bottom + 34.0], &label, TEXT, "middle", INK, 0.0);
            }
        }
        for (v, label) in self.y.ticks() {
            let [_, y] = self.at(self.x.low, v);
            c.line([self.left, y], [right, y], GRID, 1.5, "");
            c.text([self.left - 10.0, y + 9.0], &label, TEXT, "end", INK, 0.0);
        }
        c.rect([self.left, self.top], [self.width, self.height], "none", SOFT);
        if x_ticks {
            c.text([self.left + self.width / 2.0, bottom + 72.0], x_title, TEXT, "middle", INK, 0.0);
        }
        c.text([30.0, self.top + self.height / 2.0], y_title, TEXT, "middle", INK, -90.0);
    }
}

/// Keys to the lines and marks, on one row.
pub(super) fn legend(c: &mut Canvas, [x, y]: [f64; 2], entries: &[(&str, &str, &str)]) {
    let mut at = x;
    for (text, ink, mark) in entries {
        match *mark {
            "circle" | "ring" => c.circle([at + 20.0, y - 9.0], 9.0, "none", ink),
            "dot" => c.circle([at + 20.0, y - 9.0], 9.0, ink, "none"),
            "diamond" => c.diamond([at + 20.0, y - 9.0], 12.0, ink),
            "box" => c.rect([at + 6.0, y - 22.0], [28.0, 24.0], ink, "none"),
            dash => c.line([at, y - 9.0], [at + 44.0, y - 9.0], ink, 6.0, dash),
        }
        c.text([at + 54.0, y], text, TEXT, "start", INK, 0.0);
        at += key_width(text);
    }
}

/// How far the next key stands from this one.
pub(super) fn key_width(text: &str) -> f64 {
    84.0 + 14.5 * text.chars().count() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let axis = Axis { low: 0.0, high: 29.7, log: false };
        let ticks: Vec<String> = axis.ticks().into_iter().map(|t| t.1).collect();
        assert_eq!(ticks, ["0", "5", "10", "15", "20", "25"]);
        let axis = Axis { low: -3.1, high: 2.2, log: false };
        assert!(axis.ticks().iter().any(|t| t.1 == "−2"));
        let axis = Axis { low: 2e-4, high: 3e2, log: true };
        let ticks: Vec<String> = axis.ticks().into_iter().map(|t| t.1).collect();
        assert_eq!(ticks, ["0.001", "0.01", "0.1", "1", "10", "100"]);
        assert!(Axis { low: 2.1, high: 8.0, log: true }.ticks().len() >= 2);
        assert_eq!(Axis { low: 0.0, high: 1.7, log: false }.ticks()[1].1, "0.25");
    }

    #[test]
    fn degenerate_ranges_stay_finite() {
        for axis in [
            Axis::linear([], true),
            Axis::linear([3.0], false),
            Axis::log([]),
            Axis::log([0.0, 2.0]),
            Axis::log([f64::NAN]),
        ] {
            assert!(axis.high > axis.low, "{} {}", axis.low, axis.high);
            assert!(axis.ticks().len() < 30);
            assert!(axis.place(axis.low).abs() < 1e-12);
        }
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(
            ["0", "41.2", "−0.05", "1.00e6", "2.10e−9", "19.8"],
            [0.0, 41.2, -0.05, 1e6, 2.1e-9, 19.82].map(short).each_ref().map(String::as_str)
        );
    }
}
