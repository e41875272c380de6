//! Values of the command line with the range that they must lie in.
//!
//! A quantity is written as in a file: with its unit or in SI. So a share is `0.5 %` or 0.005, a length `5 mm` or 0.005, a time `5 min` or 300.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use retune::catalogue::Choice;
use retune::correlation::PairBy;
use retune::units::Scalar;
use retune::update::HowToPair;
use std::str::FromStr;
use std::time::Duration;

/// A word of one of the library's lists of alternatives.
pub(super) fn choice<T: Choice>() -> impl TypedValueParser<Value = T> {
    let words = T::ALL.iter().map(|(_, word, about)| PossibleValue::new(*word).help(*about));
    PossibleValuesParser::new(words).try_map(|word| T::parse(&word))
}

/// The rule that pairs modes; none is that of the most probable pairs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rule(pub(crate) Option<PairBy>);

/// A rule of pairing by its word.
pub(super) fn rule() -> impl TypedValueParser<Value = Rule> {
    let help = |(word, about): (&'static str, &'static str)| PossibleValue::new(word).help(about);
    let others = PairBy::ALL.iter().map(|(_, word, about)| (*word, *about));
    let words = std::iter::once(HowToPair::PROBABLE).chain(others).map(help);
    PossibleValuesParser::new(words).try_map(|word| HowToPair::by_word(&word).map(Rule))
}

/// A whole number, zero or above.
pub(super) fn whole<T: FromStr>(text: &str) -> Result<T, String> {
    text.trim().parse().map_err(|_| "a whole number, 0 or above, is expected".to_string())
}

/// A number of things, from one number to another.
pub(super) fn count(low: u16, high: u16) -> impl Fn(&str) -> Result<u16, String> + Clone {
    move |text| {
        let value = text.trim().parse::<u16>().ok().filter(|n| (low..=high).contains(n));
        value.ok_or_else(|| match high {
            u16::MAX => format!("a whole number, {low} or above, is expected"),
            _ => format!("a whole number from {low} to {high} is expected"),
        })
    }
}

fn number(text: &str) -> Result<f64, String> {
    text.trim().parse().map_err(|_| "a number is expected".to_string())
}

/// A quantity in SI.
///
/// * `unit` - an SI unit of its dimension; `1` of a share
/// * `range` - where it must lie, in words, with an example
fn quantity(text: &str, unit: &str, is_in: impl Fn(f64) -> bool, range: &str) -> Result<f64, String> {
    let value = Scalar::parse(text).and_then(|scalar| scalar.constant_in(unit));
    within(value.map_err(|e| format!("{e}; it must be {range}"))?, is_in, range)
}

fn within(value: f64, is_in: impl Fn(f64) -> bool, range: &str) -> Result<f64, String> {
    if value.is_finite() && is_in(value) { Ok(value) } else { Err(format!("it must be {range}")) }
}

/// A MAC.
pub(super) fn mac(text: &str) -> Result<f64, String> {
    quantity(text, "1", |v| (0.0..=1.0).contains(&v), "from 0 to 1, as a MAC is: 0.9 or `90 %`, and not 90")
}

/// Zero or above.
pub(super) fn not_negative(text: &str) -> Result<f64, String> {
    within(number(text)?, |v| v >= 0.0, "zero or above, and finite")
}

/// Above zero.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    within(number(text)?, |v| v > 0.0, "above zero, and finite")
}

/// A frequency, Hz.
pub(super) fn hertz(text: &str) -> Result<f64, String> {
    quantity(text, "Hz", |v| v >= 0.0, "zero or above, and finite: a frequency in Hz")
}

/// A share of something, with the words that gave it.
#[derive(Debug, Clone)]
pub(crate) struct Share {
    /// As it was written, for what a file says of itself.
    pub(crate) text: String,
    /// Its value: 0.005 for `0.5 %`.
    pub(crate) value: f64,
}

/// A share, from nothing to all.
pub(super) fn share(text: &str) -> Result<Share, String> {
    let value = quantity(text, "1", |v| (0.0..=1.0).contains(&v), "a share from 0 to 1: `0.5 %` or 0.005")?;
    Ok(Share { text: text.trim().to_string(), value })
}

/// A share above zero.
pub(super) fn positive_share(text: &str) -> Result<f64, String> {
    quantity(text, "1", |v| v > 0.0 && v <= 1.0, "a share above zero, up to 1: `0.5 %` or 0.005")
}

/// A damping ratio.
pub(super) fn damping(text: &str) -> Result<f64, String> {
    quantity(text, "1", |v| v > 0.0 && v < 1.0, "a damping ratio above 0 and below 1: `1 %` or 0.01")
}

/// What a repeated test changes of a frequency: above some per cent it is not the same structure.
pub(super) fn repeatability(text: &str) -> Result<f64, String> {
    quantity(text, "1", |v| (0.0..=0.05).contains(&v), "a share of a frequency from 0 to 5 %: `0.1 %` or 0.001")
}

/// A relative error of frequencies.
pub(super) fn tolerance(text: &str) -> Result<f64, String> {
    let range = "a relative error of frequencies from 1e-9 to 0.1: `0.01 %` or 1e-4";
    quantity(text, "1", |v| (1e-9..=0.1).contains(&v), range)
}

/// A length, m.
pub(super) fn length(text: &str) -> Result<f64, String> {
    quantity(text, "m", |v| v >= 0.0, "a length, zero or above: `5 mm` or 0.005")
}

/// A time that a search may take.
pub(super) fn time(text: &str) -> Result<Duration, String> {
    let seconds = quantity(text, "s", |v| v > 0.0, "a time above zero: `60 s`, `5 min`")?;
    let longest = "it is longer than a clock counts";
    Duration::try_from_secs_f64(seconds).ok().filter(|t| !t.is_zero()).ok_or_else(|| longest.to_string())
}

/// A system of units by its word.
pub(super) fn system(text: &str) -> Result<&'static retune_exchange::System, String> {
    use retune_exchange::{SYSTEMS, system_by_name};
    system_by_name(text).ok_or_else(|| {
        let words = SYSTEMS.iter().map(|s| s.name);
        let suggestion = retune::catalogue::did_you_mean(text, words.clone());
        format!("it is one of {}{suggestion}", words.collect::<Vec<_>>().join(", "))
    })
}

#[cfg(test)]
mod tests {
    use super::{
        damping, hertz, length, mac, not_negative, positive, positive_share, repeatability, share, time, tolerance,
    };

    #[test]
    fn what_is_no_number_or_out_of_range_is_refused() {
        let share = |text: &str| share(text).map(|s| s.value);
        let time = |text: &str| time(text).map(|t| t.as_secs_f64());
        type Parse<'a> = &'a dyn Fn(&str) -> Result<f64, String>;
        let all: [Parse<'_>; 11] = [
            &mac,
            &not_negative,
            &positive,
            &hertz,
            &share,
            &positive_share,
            &damping,
            &repeatability,
            &tolerance,
            &length,
            &time,
        ];
        for text in ["NaN", "inf", "-inf", "-1", "", "x", "1e999"] {
            for (i, parse) in all.iter().enumerate() {
                assert!(parse(text).is_err(), "{i}: {text}");
            }
        }
        assert_eq!((mac("1"), mac("0.9"), mac("90 %")), (Ok(1.0), Ok(0.9), Ok(0.9)));
        assert!(mac("90").is_err_and(|e| e.contains("from 0 to 1")));
        assert_eq!((not_negative("0"), positive("1e-9"), tolerance("1e-4")), (Ok(0.0), Ok(1e-9), Ok(1e-4)));
        assert!(
            positive("0").is_err()
                && tolerance("0.2").is_err()
                && damping("1").is_err()
                && positive_share("0").is_err()
        );
    }

    /// With the unit or in SI, as in a file; what would be ten per cent of a frequency is refused.
    #[test]
    fn a_quantity_is_written_as_in_a_file() {
        for text in ["0.5 %", "0.5%", "0.005", " 5e-3 "] {
            let read = share(text).unwrap();
            assert!((read.value - 0.005).abs() < 1e-17, "{text}");
            assert_eq!(read.text, text.trim());
        }
        assert!(share("2").is_err_and(|e| e.contains('%')) && share("5 mm").is_err());
        assert_eq!((repeatability("0.1 %"), damping("1 %")), (Ok(0.001), Ok(0.01)));
        assert!(repeatability("0.1").is_err_and(|e| e.contains("0.1 %")));
        assert_eq!((length("5 mm"), length("0.005")), (Ok(0.005), Ok(0.005)));
        assert_eq!((hertz("3"), hertz("0.003 kHz"), time("5min").map(|t| t.as_secs())), (Ok(3.0), Ok(3.0), Ok(300)));
        assert!(length("5 Hz").is_err() && time("0 s").is_err() && hertz("3 s").is_err());
    }
}
