//! Numbers of the command line with the range that they must lie in.

fn number(text: &str) -> Result<f64, String> {
    text.trim().parse().map_err(|_| "a number is expected".to_string())
}

fn in_range(text: &str, is_in: impl Fn(f64) -> bool, range: &str) -> Result<f64, String> {
    let value = number(text)?;
    if value.is_finite() && is_in(value) { Ok(value) } else { Err(format!("it must be {range}")) }
}

/// A MAC.
pub(super) fn mac(text: &str) -> Result<f64, String> {
    in_range(text, |v| (0.0..=1.0).contains(&v), "from 0 to 1, as a MAC is: 0.9 and not 90")
}

/// Zero or above.
pub(super) fn not_negative(text: &str) -> Result<f64, String> {
    in_range(text, |v| v >= 0.0, "zero or above, and finite")
}

/// Above zero.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    in_range(text, |v| v > 0.0, "above zero, and finite")
}

/// A percentage, from none to a hundred.
pub(super) fn percent(text: &str) -> Result<f64, String> {
    in_range(text.trim_end_matches('%'), |v| (0.0..100.0).contains(&v), "a percentage from 0 to below 100, such as 0.1")
}

/// A relative error of frequencies.
pub(super) fn tolerance(text: &str) -> Result<f64, String> {
    in_range(text, |v| (1e-9..=0.1).contains(&v), "from 1e-9 to 0.1, the relative error of frequencies")
}

/// A system of units by its word.
pub(super) fn system(text: &str) -> Result<&'static retune::exchange::System, String> {
    use retune::exchange::{SYSTEMS, system_by_name};
    system_by_name(text).ok_or_else(|| {
        let words = SYSTEMS.iter().map(|s| s.name);
        let suggestion = retune::catalogue::did_you_mean(text, words.clone());
        format!("it is one of {}{suggestion}", words.collect::<Vec<_>>().join(", "))
    })
}

#[cfg(test)]
mod tests {
    use super::{mac, not_negative, percent, positive, tolerance};

    #[test]
    fn what_is_no_number_or_out_of_range_is_refused() {
        let all = [mac, not_negative, positive, percent, tolerance];
        for text in ["NaN", "inf", "-inf", "-1", "", "x"] {
            assert!(all.iter().all(|parse| parse(text).is_err()), "{text}");
        }
        assert_eq!((mac("1"), mac("0.9"), percent("0.1 %")), (Ok(1.0), Ok(0.9), Ok(0.1)));
        assert!(mac("90").is_err_and(|e| e.contains("from 0 to 1")));
        assert!(percent("100").is_err() && positive("0").is_err() && tolerance("0.2").is_err());
        assert_eq!((not_negative("0"), positive("1e-9"), tolerance("1e-4")), (Ok(0.0), Ok(1e-9), Ok(1e-4)));
    }
}
