//! Numbers as Nastran writes them.

/// A real number: `1.`, `-.5`, `2.1E+11`, `2.1D11`, `2.1+11`; it has a decimal point. `None` for anything else.
pub fn parse_real(text: &str) -> Option<f64> {
    let text = text.trim();
    if !text.contains('.') {
        return None;
    }
    number(text)
}

/// A number with or without a point.
pub(super) fn number(text: &str) -> Option<f64> {
    let text = text.trim();
    // A blank may stand before the exponent: `1.04 +7`.
    if let Some((mantissa, exponent)) = text.split_once(char::is_whitespace) {
        let exponent = exponent.trim_start();
        let is_exponent = exponent.starts_with(['e', 'E', 'd', 'D', '+', '-'])
            && mantissa.ends_with(|c: char| c.is_ascii_digit() || c == '.');
        return if is_exponent { number(&format!("{mantissa}{exponent}")) } else { None };
    }
    let bytes = text.as_bytes();
    if bytes.is_empty() || bytes.len() > 40 || !bytes.iter().all(|b| b"0123456789+-.eEdD".contains(b)) {
        return None;
    }
    // The exponent begins at a letter, or at a sign behind the first character.
    let at = bytes.iter().enumerate().position(|(i, b)| b"eEdD".contains(b) || (i > 0 && b"+-".contains(b)));
    let value: f64 = match at {
        None => text.parse().ok()?,
        Some(at) => {
            let (mantissa, rest) = text.split_at(at);
            let exponent = rest.trim_start_matches(['e', 'E', 'd', 'D']);
            let exponent: i32 = exponent.parse().ok()?;
            format!("{mantissa}e{exponent}").parse().ok()?
        }
    };
    value.is_finite().then_some(value)
}

/// A real number in at most `width` characters with as many digits as fit: `6.66e+6` is `6.66+6`, `1200.5` stays.
///
/// The text always holds a point, and reads back as the nearest number that so many characters can hold.
pub fn real_in(value: f64, width: usize) -> String {
    if value == 0.0 {
        return "0.0".to_string();
    }
    let mut best: Option<(f64, usize, String)> = None;
    let mut consider = |text: String| {
        if text.len() > width {
            return;
        }
        let Some(read) = parse_real(&text) else { return };
        let error = (read - value).abs();
        let key = (error, text.len());
        if best.as_ref().is_none_or(|b| key.0 < b.0 || (key.0 == b.0 && key.1 < b.1)) {
            best = Some((error, text.len(), text));
        }
    };
    let shown = value.abs().log10();
    for digits in 0..=17 {
        if (-6.0..17.0).contains(&shown) {
            let mut text = format!("{value:.digits$}");
            if text.contains('.') {
                let cut = text.trim_end_matches('0').len();
                text.truncate(cut);
            } else {
                text.push('.');
            }
            // A leading zero takes a place that a digit could have.
            let bare = text.strip_prefix("0.").map(|t| format!(".{t}"));
            let bare = bare.or_else(|| text.strip_prefix("-0.").map(|t| format!("-.{t}")));
            if let Some(bare) = bare.filter(|b| b.len() > 1 && b != "-.") {
                consider(bare);
            }
            consider(text);
        }
        let text = format!("{value:.digits$e}");
        if let Some((mantissa, exponent)) = text.split_once('e') {
            let mut mantissa = mantissa.to_string();
            if mantissa.contains('.') {
                let cut = mantissa.trim_end_matches('0').len();
                mantissa.truncate(cut);
            } else {
                mantissa.push('.');
            }
            let sign = if exponent.starts_with('-') { "" } else { "+" };
            consider(format!("{mantissa}{sign}{exponent}"));
        }
    }
    best.map_or_else(|| format!("{value:e}"), |b| b.2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_as_nastran_writes_them() {
        for (text, value) in [
            ("1.", 1.0),
            (".5", 0.5),
            ("-.5+2", -50.0),
            ("6.660e+6", 6.66e6),
            ("1.D-3", 1e-3),
            ("1.+6", 1e6),
            ("2.1-11", 2.1e-11),
            ("+1.5E+3", 1500.0),
        ] {
            assert_eq!(parse_real(text), Some(value), "{text}");
        }
        for text in ["", "1", "1.2.3", "abc", "1.0E", "1.0E400", "--1.", "1.0+-3", "nan", "."] {
            assert_eq!(parse_real(text), None, "{text}");
        }
        assert_eq!(number("7"), Some(7.0));
    }

    #[test]
    fn eight_characters_hold_as_many_digits_as_they_can() {
        for (value, text) in [
            (2592711.1, "2592711."),
            (0.0447968, ".0447968"),
            (6.66e6, "6.66+6"),
            (-1.23456789e-7, "-1.235-7"),
            (1.0, "1."),
            (0.1, ".1"),
            (-0.83333333, "-.833333"),
            (123456789.0, "1.2346+8"),
        ] {
            assert_eq!(real_in(value, 8), text);
        }
        assert_eq!(real_in(std::f64::consts::PI, 16), "3.14159265358979");
        // Nothing that fits is further from the value than one unit of the last digit shown, for any size.
        for i in -300..300 {
            let value = 1.2345678912 * 10f64.powi(i);
            for (width, part) in [(8, 2e-2), (16, 1e-8)] {
                let text = real_in(value, width);
                assert!(text.len() <= width && (parse_real(&text).unwrap() / value - 1.0).abs() < part, "{text}");
            }
        }
    }
}
