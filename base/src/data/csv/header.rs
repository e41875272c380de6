//! What the names of columns say.

use super::CsvError;
use super::sheet::{decimal, is_of_thousands};
use crate::data::Channel;
use crate::units::FrequencyUnit;
use std::f64::consts::TAU;

/// What a column of a function holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Part {
    Re,
    Im,
    Coherence,
    Amplitude,
    /// With radians in one of its unit, where the name says it.
    Phase(Option<f64>),
}

/// The name of a column of a function, taken apart.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PartName<'a> {
    /// `<response>/<reference>`; empty in a table of one function.
    pub(super) pair: &'a str,
    pub(super) part: Part,
    /// The unit in brackets at the end.
    pub(super) unit: Option<&'a str>,
}

/// A name without the unit in brackets at its end, and that unit.
fn without_unit(name: &str) -> (&str, Option<&str>) {
    let name = name.trim();
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some((head, unit)) = name.strip_suffix(close).and_then(|n| n.rsplit_once(open)) {
            return (head.trim_end(), Some(unit.trim()));
        }
    }
    (name, None)
}

/// Radians in one of a unit of angles.
pub(super) fn radians(unit: &str) -> Option<f64> {
    match unit.trim().to_lowercase().as_str() {
        "rad" | "radian" | "radians" => Some(1.0),
        "deg" | "degree" | "degrees" | "°" => Some(TAU / 360.0),
        _ => None,
    }
}

fn part_of(word: &str) -> Option<Part> {
    let word = word.trim().to_lowercase();
    Some(match word.as_str() {
        "re" | "real" | "real part" => Part::Re,
        "im" | "imag" | "imaginary" | "imaginary part" => Part::Im,
        "coh" | "coherence" => Part::Coherence,
        "amp" | "ampl" | "amplitude" | "mag" | "magnitude" | "abs" | "modulus" => Part::Amplitude,
        "phase" | "angle" | "phi" => Part::Phase(None),
        "phase_deg" | "phase deg" | "angle_deg" => Part::Phase(radians("deg")),
        "phase_rad" | "phase rad" | "angle_rad" => Part::Phase(radians("rad")),
        _ => return None,
    })
}

/// `12.+z/1.+z:re`, `tip phase [deg]`, `tip_real`, or the part alone, in a table of one function.
pub(super) fn part_name(name: &str) -> Option<PartName<'_>> {
    let (body, unit) = without_unit(name);
    let phase_unit = unit.and_then(radians);
    let found = |pair: &'_ str, part: Part| match part {
        Part::Phase(None) => (pair.len(), Part::Phase(phase_unit)),
        part => (pair.len(), part),
    };
    let split = match body.rsplit_once(':') {
        Some((pair, word)) => part_of(word).map(|part| found(pair, part)),
        None => part_of(body).map(|part| found("", part)).or_else(|| {
            // The part may be of two words, `phase_deg`, `real part`.
            let mut cuts = body.char_indices().filter(|(_, c)| matches!(c, ' ' | '_')).map(|(at, _)| at);
            cuts.find_map(|at| Some(found(&body[..at], part_of(&body[at + 1..])?)))
        }),
    };
    let (length, part) = split?;
    Some(PartName { pair: body[..length].trim_end_matches([' ', '_']), part, unit })
}

/// `12.+z`, `12+z`, `12.z` to name and direction.
pub(super) fn channel(text: &str) -> Channel {
    let plain = || Channel { name: text.to_owned(), direction: None };
    let Some(letter) = text.chars().last() else { return plain() };
    let Some(axis) = ['x', 'y', 'z'].iter().position(|a| *a == letter.to_ascii_lowercase()) else { return plain() };
    let body = &text[..text.len() - letter.len_utf8()];
    let (body, sign) = match (body.strip_suffix('-'), body.strip_suffix('+')) {
        (Some(body), _) => (body, Some(-1.0)),
        (_, Some(body)) => (body, Some(1.0)),
        _ => (body, None),
    };
    let name = match (body.strip_suffix(['.', ':', '_', ' ']), sign) {
        // Without a sign the letter may belong to the name; a point before it says that it does not.
        (Some(name), None) if body.ends_with('.') => name,
        (_, None) => return plain(),
        (name, Some(_)) => name.unwrap_or(body),
    };
    if name.is_empty() {
        return plain();
    }
    let mut direction = [0.0; 3];
    direction[axis] = sign.unwrap_or(1.0);
    Channel { name: name.to_owned(), direction: Some(direction) }
}

/// What the name of a column of frequencies says.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FrequencyName {
    /// The unit, where it is in the name.
    pub(super) unit: Option<FrequencyUnit>,
}

/// Whether a column holds frequencies; with the unit that its name states.
///
/// `frequency_hz`, `Frequency [rad/s]`, `f / Hz`, `omega`, `freq`.
pub(super) fn frequency_column(name: &str) -> Option<FrequencyName> {
    const WORDS: [&str; 10] = ["frequencies", "frequency", "frequenz", "freq.", "freq", "frq", "omega", "f", "w", "ω"];
    let lower = name.trim().to_lowercase();
    let rest = WORDS.iter().find_map(|word| {
        let rest = lower.strip_prefix(word)?;
        rest.chars().next().is_none_or(|c| matches!(c, ' ' | '_' | '/' | '[' | '(' | ',')).then_some(rest)
    })?;
    let unit = rest.trim_matches([' ', '_', '/', '[', ']', '(', ')', ',']);
    if unit.is_empty() {
        return Some(FrequencyName { unit: None });
    }
    let spelled = match unit {
        "rad_s" | "rads" | "rad_per_s" => "rad/s",
        "deg_s" => "deg/s",
        other => other,
    };
    // Lower case makes a millihertz of a megahertz, which nobody means here.
    let unit = FrequencyUnit::of_label(spelled).filter(|_| spelled != "mhz")?;
    Some(FrequencyName { unit: Some(unit) })
}

/// The name of a column that is a mode.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ModeName {
    pub(super) hz: f64,
    pub(super) label: String,
    pub(super) is_imaginary: bool,
}

/// Whether the name of a column holds a frequency: a number before a unit of one.
pub(in crate::data) fn is_mode(name: &str) -> bool {
    mode_name(name, None).is_some()
}

/// `bending 7.93 Hz`, `twist_16,1Hz:im`, `49.8 rad/s`: frequency, label, and whether it is an imaginary part.
///
/// * `comma` - whether the table writes decimals with a comma, where that is known
///
/// An error where the number before the unit cannot be told: thousands, two marks, digits before it.
pub(super) fn mode_name(name: &str, comma: Option<bool>) -> Option<Result<ModeName, CsvError>> {
    let (body, is_imaginary) = match name.rsplit_once(':') {
        Some((body, "im")) => (body, true),
        Some((body, "re")) => (body, false),
        _ => (name, false),
    };
    let end = body.rfind(|c: char| c.is_ascii_digit())? + 1;
    let unit = FrequencyUnit::of_label(&body[end..])?;
    let head = &body[..end];
    let is_mark = |c: char| c.is_ascii_digit() || matches!(c, '.' | ',');
    let mut start = head.trim_end_matches(is_mark).len();
    // The digits may be an exponent, `1.5e3`.
    let before = head[..start].trim_end_matches(['+', '-']);
    if start - before.len() <= 1
        && let Some(mantissa) = before.strip_suffix(['e', 'E'])
        && mantissa.ends_with(is_mark)
    {
        start = mantissa.trim_end_matches(is_mark).len();
    }
    let (label, number) = head.split_at(start);
    // A header without decimals beside it speaks for itself, unless its mark may be one of thousands.
    let own = match comma {
        None if is_of_thousands(number, ',') => None,
        None => Some(number.contains(',')),
        known => known,
    };
    let after_word = label.ends_with(char::is_alphanumeric);
    let after_digit = |mark: char| label.strip_suffix(mark).is_some_and(|l| l.ends_with(|c: char| c.is_ascii_digit()));
    let is_torn = (number.starts_with(['.', ',']) && after_word)
        || ['\'', '’', '\u{a0}', '\u{202f}'].into_iter().any(after_digit);
    let hz = decimal(number, own).filter(|_| !is_torn).map(|f| f * unit.hertz);
    let Some(hz) = hz.filter(|f| f.is_finite()) else {
        return Some(Err(CsvError::ColumnName {
            name: name.to_owned(),
            expected: "the number before the unit must be written as the numbers of the table, without separators of thousands",
        }));
    };
    if hz <= 0.0 {
        return None;
    }
    let label = label.trim_end_matches(['_', ' ', '-', '=', '(', '[', '@', ':', '.', ',']).trim().to_string();
    Some(Ok(ModeName { hz, label, is_imaginary }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mode(name: &str, comma: Option<bool>) -> (f64, String, bool) {
        let m = mode_name(name, comma).unwrap().unwrap();
        (m.hz, m.label, m.is_imaginary)
    }

    #[test]
    fn names_of_columns_that_are_no_modes() {
        for name in ["Hz", "frequency_hz", "-Hz", "é7 Hz!", "x", "0 Hz", "Hz:im", "x_2", "7 m", "7 mm", "p1:re"] {
            assert!(mode_name(name, None).is_none(), "{name}");
        }
    }

    #[test]
    fn the_frequency_of_a_mode_is_read_with_the_decimal_mark_of_the_table() {
        assert_eq!(mode("é7.5 Hz", None), (7.5, "é".to_string(), false));
        assert_eq!(mode("bending 7,9 Hz", Some(true)), (7.9, "bending".to_string(), false));
        assert_eq!(mode("bending 7,9 Hz", None), (7.9, "bending".to_string(), false));
        assert_eq!(mode("7.9 Hz:im", Some(true)), (7.9, String::new(), true));
        assert_eq!(mode("mode 1 (1.5e3 Hz)", Some(false)), (1500.0, "mode 1".to_string(), false));
        assert_eq!(mode("2nd_49Hz", Some(false)), (49.0, "2nd".to_string(), false));
        assert_eq!(mode("twist-16.1 Hz", Some(false)), (16.1, "twist".to_string(), false));
        assert_eq!(mode("first .5 Hz", Some(false)).0, 0.5);
        assert_eq!(mode("0.5 kHz", Some(false)).0, 500.0);
        assert_eq!(mode("600 rpm", Some(false)).0, 10.0);
        assert!((mode("f1 = 12.5664 rad/s", Some(false)).0 - 2.0).abs() < 1e-5);
        for (name, comma) in [
            ("bending 7,9 Hz", Some(false)),
            ("1,234.5 Hz", None),
            ("1.234,5 Hz", Some(true)),
            ("1'250 Hz", Some(false)),
            ("1,2,3 Hz", None),
            ("1.250 Hz", Some(true)),
            ("1,250 Hz", None),
            ("mode,7.9 Hz", Some(false)),
            ("mode.7 Hz", None),
        ] {
            assert!(mode_name(name, comma).unwrap().is_err(), "{name}");
        }
    }

    #[test]
    fn columns_of_functions_say_their_part() {
        let part = |name| part_name(name).map(|p| (p.pair, p.part, p.unit));
        assert_eq!(part("12.+z/1.+z:re"), Some(("12.+z/1.+z", Part::Re, None)));
        assert_eq!(part("tip:phase_deg"), Some(("tip", Part::Phase(Some(TAU / 360.0)), None)));
        assert_eq!(part("tip phase [rad]"), Some(("tip", Part::Phase(Some(1.0)), Some("rad"))));
        assert_eq!(part("Amplitude (g/N)"), Some(("", Part::Amplitude, Some("g/N"))));
        assert_eq!(part("p_1_real"), Some(("p_1", Part::Re, None)));
        assert_eq!(part("p1 imaginary part"), Some(("p1", Part::Im, None)));
        for name in ["a", "p1", "a:b", "rereal", ""] {
            assert_eq!(part(name), None, "{name}");
        }
    }

    #[test]
    fn columns_of_frequencies_state_their_unit() {
        let unit = |name| frequency_column(name).map(|f| f.unit.map(|u| u.hertz));
        for name in ["frequency_hz", "Frequency [Hz]", "f/Hz", "Freq (Hz)", "frequency / Hz"] {
            assert_eq!(unit(name), Some(Some(1.0)), "{name}");
        }
        assert_eq!(unit("omega (rad/s)"), Some(Some(1.0 / TAU)));
        assert_eq!(unit("frequency_rad_s"), Some(Some(1.0 / TAU)));
        assert_eq!(unit("frequency_khz"), Some(Some(1e3)));
        assert_eq!((unit("frq"), unit("ω")), (Some(None), Some(None)));
        for name in ["first 5 Hz", "f1", "force", "frequency_m", "x", "f [MHz]", "wing"] {
            assert_eq!(unit(name), None, "{name}");
        }
    }

    #[test]
    fn channels_say_their_direction() {
        let direction = |text| channel(text).direction;
        for text in ["1.+z", "1+z", "1:+Z", "1_+z", "1.z"] {
            let found = channel(text);
            assert_eq!((found.name.as_str(), found.direction), ("1", Some([0.0, 0.0, 1.0])), "{text}");
        }
        assert_eq!(direction("tip.left.-x"), Some([-1.0, 0.0, 0.0]));
        for text in ["box", "1", "z", "+z", "fuselage x", ""] {
            assert_eq!(direction(text), None, "{text}");
        }
    }
}
