//! Numbers and text in fixed columns, as FORTRAN wrote them and as people's programs imitate it.
//!
//! Reading prefers the columns of the standard and falls back on blanks when the columns do not make sense; numbers may
//! run together, carry `D` exponents, or lack the `E` before a three-digit exponent. Writing keeps every digit that fits
//! between the columns, and says when one did not.

/// A number in any FORTRAN spelling, `1.5`, `1.5E+03`, `1.5D+03`, `1.5+103`, `NaN`, and with the decimal comma of programs that write in the language of
/// their computer: nothing else separates numbers by commas here.
pub(super) fn parse_float(token: &str) -> Option<f64> {
    let token = token.trim();
    if let Ok(value) = token.parse::<f64>() {
        return Some(value);
    }
    if token.len() > 40 || !token.is_ascii() {
        return None;
    }
    if let Some((whole, rest)) = token.split_once(',') {
        let is_decimal = rest.starts_with(|c: char| c.is_ascii_digit()) && !token.contains('.') && !rest.contains(',');
        return if is_decimal { parse_float(&format!("{whole}.{rest}")) } else { None };
    }
    if let Some(at) = token.find(['d', 'D']) {
        let mut spelled = token.to_owned();
        spelled.replace_range(at..=at, "E");
        return spelled.parse().ok();
    }
    // FORTRAN drops the letter when the exponent has three digits.
    let sign = token.char_indices().skip(1).find(|(_, c)| matches!(c, '+' | '-')).map(|(at, _)| at)?;
    let (mantissa, exponent) = token.split_at(sign);
    let is_exponent = exponent.len() == 4 && exponent[1..].bytes().all(|b| b.is_ascii_digit());
    if mantissa.contains('.') && is_exponent { format!("{mantissa}E{exponent}").parse().ok() } else { None }
}

/// An integer, also when written as `3.` or `3.0`.
pub(super) fn parse_int(token: &str) -> Option<i64> {
    let token = token.trim();
    token.parse::<i64>().ok().or_else(|| {
        let value = parse_float(token)?;
        // Integers up to 2^53 are exact in f64.
        (value.fract() == 0.0 && value.abs() < 9.0e15).then_some(value as i64)
    })
}

/// Whether a token stands for a number that did not fit or did not exist.
fn is_overflow(token: &str) -> bool {
    token.bytes().all(|b| b == b'*') || token.contains('#')
}

/// The text from character `start`, `width` characters long, or what there is of it.
pub(super) fn column(line: &str, start: usize, width: usize) -> &str {
    if line.is_ascii() {
        let start = start.min(line.len());
        return &line[start..(start + width).min(line.len())];
    }
    let mut bounds = line.char_indices().map(|(at, _)| at).chain([line.len()]);
    let Some(from) = bounds.nth(start) else { return "" };
    let to = if width == 0 { from } else { bounds.nth(width - 1).unwrap_or(line.len()) };
    &line[from..to]
}

/// A record of numbers only.
pub(super) struct NumericRecord<'a> {
    /// One token per field; empty where the field is blank or absent.
    pub(super) fields: Vec<&'a str>,
    /// Whether the columns made no sense and the record was read by its blanks.
    pub(super) by_blanks: bool,
}

impl NumericRecord<'_> {
    /// Field `i` as an integer; blank means zero, as in FORTRAN.
    pub(super) fn int(&self, i: usize) -> i64 {
        self.fields.get(i).and_then(|t| parse_int(t)).unwrap_or(0)
    }

    /// Field `i` as a real number; blank means zero, as in FORTRAN.
    pub(super) fn float(&self, i: usize) -> f64 {
        self.fields.get(i).and_then(|t| parse_float(t)).unwrap_or(0.0)
    }

    /// Whether field `i` holds something.
    pub(super) fn has(&self, i: usize) -> bool {
        self.fields.get(i).is_some_and(|t| !t.is_empty())
    }
}

/// Splits a record of numbers: by columns, or by blanks when the columns cut numbers apart.
pub(super) fn numeric_record<'a>(line: &'a str, widths: &[usize]) -> Option<NumericRecord<'a>> {
    let mut start = 0;
    let fixed: Vec<&str> = widths
        .iter()
        .map(|width| {
            let field = column(line, start, *width).trim();
            start += width;
            field
        })
        .collect();
    let is_number = |t: &&str| parse_float(t).is_some();
    let fixed_is_sound = fixed.iter().all(|t| t.is_empty() || is_number(t));
    let tokens: Vec<&str> = line.split_whitespace().take(widths.len() + 1).collect();
    let same = fixed_is_sound && fixed.iter().filter(|t| !t.is_empty()).eq(tokens.iter());
    if same {
        return Some(NumericRecord { fields: fixed, by_blanks: false });
    }
    let tokens_are_numbers = tokens.iter().all(is_number);
    if tokens_are_numbers && tokens.len() == widths.len() {
        return Some(NumericRecord { fields: tokens, by_blanks: true });
    }
    if fixed_is_sound {
        return Some(NumericRecord { fields: fixed, by_blanks: false });
    }
    tokens_are_numbers.then_some(NumericRecord { fields: tokens, by_blanks: true })
}

/// What [`push_floats`] met.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FloatLine {
    /// Numbers separated by blanks or standing in their columns.
    Clean,
    /// Numbers that ran together and were cut at the columns or at their signs.
    CutApart,
    /// Some were stars or other signs of overflow and are NaN now.
    NotNumbers,
    /// Something that is not a number; nothing was added.
    Bad,
}

/// Appends all real numbers of a line; `widths` are the columns of one line, repeated as often as needed.
pub(super) fn push_floats(line: &str, widths: &[usize], values: &mut Vec<f64>) -> FloatLine {
    let before = values.len();
    let mut outcome = FloatLine::Clean;
    let mut all = true;
    for token in line.split_ascii_whitespace() {
        if let Some(value) = parse_float(token) {
            values.push(value);
        } else if is_overflow(token) && token.len() <= widths.iter().copied().max().unwrap_or(0) {
            values.push(f64::NAN);
            outcome = FloatLine::NotNumbers;
        } else {
            all = false;
            break;
        }
    }
    if all {
        return outcome;
    }
    values.truncate(before);
    if push_by_columns(line, widths, values) || push_by_signs(line, values) {
        return FloatLine::CutApart;
    }
    values.truncate(before);
    FloatLine::Bad
}

fn push_by_columns(line: &str, widths: &[usize], values: &mut Vec<f64>) -> bool {
    let before = values.len();
    let line = line.trim_end();
    if !line.is_ascii() {
        return false;
    }
    let mut start = 0;
    for width in widths.iter().cycle() {
        if start >= line.len() {
            return true;
        }
        let Some(value) = parse_float(column(line, start, *width)) else { break };
        values.push(value);
        start += width;
    }
    values.truncate(before);
    false
}

fn push_by_signs(line: &str, values: &mut Vec<f64>) -> bool {
    let before = values.len();
    for token in line.split_ascii_whitespace() {
        let bytes = token.as_bytes();
        let mut start = 0;
        for at in 1..=bytes.len() {
            let is_cut = at == bytes.len()
                || (matches!(bytes[at], b'+' | b'-') && !matches!(bytes[at - 1], b'e' | b'E' | b'd' | b'D'));
            if is_cut {
                let Some(value) = token.get(start..at).and_then(parse_float) else {
                    values.truncate(before);
                    return false;
                };
                values.push(value);
                start = at;
            }
        }
    }
    true
}

/// A real number in a field of `width` characters, right-justified, with at least one blank in front.
///
/// Tried in this order: `digits` decimals in exponent form, the shortest text that reads back to the same bits, and as
/// many digits as fit. Returns the text and whether it reads back to the same bits.
pub(super) fn format_float(value: f64, width: usize, digits: usize) -> (String, bool) {
    let room = width - 1;
    let fits = |text: &String| text.len() <= room;
    let pad = |text: &str| format!("{text:>width$}");
    if !value.is_finite() {
        let text = if value.is_nan() { "NaN" } else { ["Inf", "-Inf"][usize::from(value < 0.0)] };
        return (pad(text), true);
    }
    let is_exact = |text: &String| text.parse::<f64>().is_ok_and(|v| v.to_bits() == value.to_bits());
    let standard = two_digit_exponent(&format!("{value:.digits$e}"));
    if fits(&standard) && is_exact(&standard) {
        return (pad(&standard), true);
    }
    let shortest = format!("{value:e}");
    let standard_shortest = two_digit_exponent(&shortest);
    let short_exponent = standard_shortest.replace("E+0", "E+").replace("E-0", "E-").replace("E+", "E");
    let mut candidates = vec![standard_shortest, short_exponent];
    // Where the debug format of Rust writes digits and a point, without exponent.
    let is_moderate = value == 0.0 || (1.0e-4..1.0e16).contains(&value.abs());
    if is_moderate {
        candidates.push(format!("{value:?}"));
    }
    if let Some(text) = candidates.iter().find(|t| fits(t) && is_exact(t)) {
        return (pad(text), true);
    }
    // The longest text of each form that fits; the nearer one wins, the exponent form on a tie.
    let longest = |make: &dyn Fn(usize) -> String| (1..=room).rev().map(make).find(|t| fits(t));
    let exponent_form = longest(&|d| two_digit_exponent(&format!("{value:.d$e}")));
    let fixed_form = is_moderate.then(|| longest(&|d| format!("{value:.d$}"))).flatten();
    let error = |t: &String| t.parse::<f64>().map_or(f64::INFINITY, |v| (v - value).abs());
    let best = [exponent_form, fixed_form].into_iter().flatten().min_by(|a, b| error(a).total_cmp(&error(b)));
    match best {
        Some(text) => (pad(&text), false),
        None => (pad("NaN"), false),
    }
}

/// `1.5e-7` as `1.5E-07`, `1e3` as `1.0E+03`: a FORTRAN program reads digits without a point as hundred-thousandths.
fn two_digit_exponent(text: &str) -> String {
    let Some((mantissa, exponent)) = text.split_once('e') else { return text.to_owned() };
    let (sign, magnitude) = match exponent.strip_prefix('-') {
        Some(magnitude) => ('-', magnitude),
        None => ('+', exponent),
    };
    let point = if mantissa.contains('.') { "" } else { ".0" };
    format!("{mantissa}{point}E{sign}{magnitude:0>2}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fortran_spellings_are_numbers() {
        assert_eq!(parse_float("1.5D+03"), Some(1500.0));
        assert_eq!(parse_float("-1.5d-1"), Some(-0.15));
        assert_eq!(parse_float("1.25-103"), Some(1.25e-103));
        assert_eq!(parse_float("0.00000E+000"), Some(0.0));
        assert_eq!(parse_float("-.5"), Some(-0.5));
        assert_eq!(parse_float("-2,40513E+00"), Some(-2.40513));
        assert_eq!(parse_float(",5"), Some(0.5));
        assert!(["1,2,3", "1.0,5", "5,", "1,E3", ","].iter().all(|t| parse_float(t).is_none()));
        assert_eq!(parse_float("1.0-2.0"), None);
        assert_eq!(parse_int("3."), Some(3));
        assert_eq!(parse_int("3.5"), None);
    }

    #[test]
    fn numbers_that_run_together_are_cut_at_the_columns() {
        let mut values = Vec::new();
        let line = "-1.111111E-01 4.111111E+01 4.111111E+03-3.111111E+03";
        assert_eq!(push_floats(line, &[13; 6], &mut values), FloatLine::CutApart);
        assert_eq!(values, [-0.1111111, 41.11111, 4111.111, -3111.111]);
    }

    #[test]
    fn touching_numbers_without_a_sign_are_cut_at_the_columns() {
        let mut values = Vec::new();
        assert_eq!(push_floats("1.0000000E+002.0000000E+00", &[13; 6], &mut values), FloatLine::CutApart);
        assert_eq!(values, [1.0, 2.0]);
    }

    #[test]
    fn stars_are_nan_and_words_are_refused() {
        let mut values = Vec::new();
        assert_eq!(push_floats(" 1.0 *************", &[13; 6], &mut values), FloatLine::NotNumbers);
        assert!(values[1].is_nan());
        assert_eq!(push_floats(" 1.0 volts", &[13; 6], &mut values), FloatLine::Bad);
        assert_eq!(values.len(), 2);
    }

    #[test]
    fn integer_records_are_read_by_columns_and_by_blanks_when_an_id_is_too_long() {
        let r = numeric_record("1234567890123456789", &[10, 10]).unwrap();
        assert_eq!((r.int(0), r.int(1), r.by_blanks), (1_234_567_890, 123_456_789, false));
        let r = numeric_record("123456789012         7", &[10, 10]).unwrap();
        assert_eq!((r.int(0), r.int(1), r.by_blanks), (123_456_789_012, 7, true));
        let r = numeric_record("         1                   3", &[10, 10, 10]).unwrap();
        assert_eq!((r.int(0), r.int(1), r.int(2)), (1, 0, 3));
        assert!(numeric_record("abc def", &[10, 10]).is_none());
    }

    #[test]
    fn written_numbers_keep_a_blank_in_front_and_read_back() {
        for value in [0.0, -0.0, 1.0, -2.4, 0.3125, 1.0e-300, -9.99999e99, 4097.0, 0.1234567, f64::NAN] {
            let (text, exact) = format_float(value, 13, 5);
            assert!(text.starts_with(' ') && text.len() == 13 && exact, "{text}");
            let back = parse_float(&text).unwrap();
            assert!(back.to_bits() == value.to_bits() || value.is_nan());
        }
        let (text, exact) = format_float(-std::f64::consts::PI * 1.0e-200, 13, 5);
        assert!(!exact && text.len() == 13, "{text}");
        let (text, exact) = format_float(0.312_520_001_280_081_95, 13, 5);
        assert_eq!((text.as_str(), exact), (" 0.3125200013", false));
        let (_, exact) = format_float(-1.234_567_890_123_456_7e-300, 25, 16);
        assert!(exact, "every double fits a field of 25 characters");
    }

    #[test]
    fn columns_count_characters_not_bytes() {
        assert_eq!(column("g²/Hz    rest", 9, 4), "rest");
        assert_eq!(column("g²/Hz", 9, 4), "");
    }
}
