//! Other spellings of units: plurals, full words, and what programs write for revolutions a minute.

/// Whole units, without regard to case, and what they are called here. A number a minute, `1/min`, counts turns: no angle is given a minute.
const WHOLE: &[(&str, &str)] = &[
    ("rpm", "rpm"),
    ("r/min", "rpm"),
    ("rev/min", "rpm"),
    ("revs/min", "rpm"),
    ("1/min", "rpm"),
    ("u/min", "rpm"),
    ("min^-1", "rpm"),
    ("min-1", "rpm"),
    ("min−1", "rpm"),
    ("cpm", "rpm"),
    ("cycles/min", "rpm"),
    ("cps", "Hz"),
    ("cycles/s", "Hz"),
    ("cycle/s", "Hz"),
    ("cycles/sec", "Hz"),
];

/// Words of a unit, without regard to case. Only what has one meaning stands here.
#[rustfmt::skip]
const WORDS: &[(&str, &str)] = &[
    ("meter", "m"), ("meters", "m"), ("metre", "m"), ("metres", "m"), ("millimeter", "mm"), ("millimeters", "mm"), ("millimetre", "mm"),
    ("millimetres", "mm"), ("micron", "um"), ("microns", "um"), ("inch", "in"), ("inches", "in"), ("foot", "ft"), ("feet", "ft"),
    ("mils", "mil"), ("thou", "mil"), ("kilogram", "kg"), ("kilograms", "kg"), ("gram", "g"), ("grams", "g"), ("tonne", "t"),
    ("tonnes", "t"), ("slugs", "slug"), ("lbms", "lbm"), ("ounce", "oz"), ("ounces", "oz"), ("sec", "s"), ("secs", "s"), ("second", "s"),
    ("seconds", "s"), ("msec", "ms"), ("minute", "min"), ("minutes", "min"), ("hour", "h"), ("hours", "h"), ("hr", "h"), ("hrs", "h"),
    ("hertz", "Hz"), ("newton", "N"), ("newtons", "N"), ("kips", "kip"), ("pascal", "Pa"), ("degree", "deg"), ("degrees", "deg"),
    ("degs", "deg"), ("radian", "rad"), ("radians", "rad"), ("rads", "rad"), ("revs", "rev"), ("percent", "%"),
];

/// Words that may mean several units, and these, for a question.
const AMBIGUOUS: &[(&str, &str)] = &[
    ("lbs", "`lb` (mass) or `lbf` (force)"),
    ("pound", "`lb` (mass) or `lbf` (force)"),
    ("pounds", "`lb` (mass) or `lbf` (force)"),
    ("kgs", "`kg` or `kg s`"),
    ("gm", "`g` or `g m`"),
    ("gms", "`g` or `g m s`"),
    ("ton", "`t` (1000 kg)"),
    ("tons", "`t` (1000 kg)"),
    ("kp", "`kgf` or `kPa`"),
];

fn find(list: &'static [(&str, &str)], name: &str) -> Option<&'static str> {
    list.iter().find(|(spelling, _)| spelling.eq_ignore_ascii_case(name)).map(|(_, unit)| *unit)
}

/// What a whole unit that is spelt in another way is called here; `None` for the name itself.
pub(super) fn of_whole(text: &str) -> Option<&'static str> {
    find(WHOLE, text).filter(|unit| *unit != text)
}

/// The unit of a word.
pub(super) fn of_word(word: &str) -> Option<&'static str> {
    find(WORDS, word)
}

/// The units that a word may mean.
pub(super) fn ambiguous(word: &str) -> Option<&'static str> {
    find(AMBIGUOUS, word)
}

#[cfg(test)]
mod tests {
    use super::super::{Scalar, Unit};

    #[test]
    fn plurals_and_words_are_the_unit_that_they_name() {
        for (spelling, unit) in [
            ("mils", "mil"),
            ("inches", "in"),
            ("Inch", "in"),
            ("kgf", "9.80665 N"),
            ("sec", "s"),
            ("m/sec2", "m/s2"),
            ("Newtons", "N"),
            ("degrees", "deg"),
        ] {
            let expected = Scalar::parse(&if unit.starts_with('9') { unit.to_string() } else { format!("1 {unit}") });
            let (given, expected) = (Unit::parse(spelling).unwrap(), expected.unwrap().terms()[0].clone());
            assert!((given.factor / expected.factor - 1.0).abs() < 1e-15, "{spelling}");
            assert_eq!(Some(given.dimension), expected.dimension, "{spelling}");
        }
    }

    #[test]
    fn revolutions_a_minute_are_a_frequency_however_written() {
        for text in
            ["600 rpm", "600 RPM", "600 r/min", "600 1/min", "600 rev/min", "600 U/min", "600 min⁻¹", "600 min^-1"]
        {
            let hz = Scalar::parse(text).unwrap().constant_in("Hz").unwrap_or_else(|e| panic!("{text}: {e}"));
            assert!((hz - 10.0).abs() < 1e-12, "{text}: {hz}");
        }
        // A rate is still not a frequency.
        assert!(Scalar::parse("600 1/s").unwrap().constant_in("Hz").is_err());
    }

    #[test]
    fn what_may_be_several_units_is_asked() {
        for (word, meant) in
            [("lbs", "`lb` (mass) or `lbf` (force)"), ("gm", "`g` or `g m`"), ("tons", "`t` (1000 kg)")]
        {
            let error = Unit::parse(word).unwrap_err().to_string();
            assert_eq!(error, format!("unknown unit `{word}`; did you mean {meant}?"));
        }
    }

    #[test]
    fn numbers_in_other_characters_have_their_value() {
        for (text, value) in [("５ mm", 5e-3), ("−60 cm", -0.6), ("2 m −３ m", -1.0)] {
            assert!((Scalar::parse(text).unwrap().constant_in("m").unwrap() - value).abs() < 1e-15, "{text}");
        }
        let error = Scalar::parse("\u{2013}60 cm").unwrap_err().to_string();
        assert!(error.ends_with("`–` (U+2013) is not a minus sign; write `-`"), "{error}");
    }
}
