//! What the name of a variable says of its values.

/// What a variable holds, by its name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Says {
    /// Frequencies, in the unit that the name states or its letter stands for: Hz in one of it.
    Frequency(f64),
    /// Shapes of modes.
    Shapes,
    /// Damping ratios, as numbers of this size.
    Damping(f64),
    /// Frequency response functions.
    Functions,
    /// Ordinary coherences.
    Coherence,
    /// Eigenvalues: poles, or squares of angular frequencies.
    Eigenvalues,
    /// Names of points.
    Points,
    /// None of these.
    Nothing,
}

const TAU: f64 = std::f64::consts::TAU;

/// Words that make of a frequency or shape something else: a limit, a count, a name.
#[rustfmt::skip]
const OTHERWISE: &[&str] = &[
    "no", "num", "number", "count", "idx", "index", "id", "ids", "name", "names", "order", "size", "len", "length", "type", "unit",
    "units", "std", "sd", "sigma", "err", "error", "unc", "var", "cov", "min", "max", "range", "band", "step", "delta", "res",
    "resolution", "samp", "sample", "samples", "sampling", "sampled", "rate", "nyquist", "cut", "cutoff", "lim", "limit", "limits",
    "start", "stop", "end", "span", "center", "centre", "guess", "mass", "stiffness", "scale", "mac",
];
/// Words of which the rest of a word may consist, after `freq`: `freqmax` is a limit.
const LIMITS: &[&str] = &["max", "min", "samp", "range", "band", "step", "res", "lim"];

/// The words of a name, in lower case: `psiExp_m` is psi, exp, m; `modeshape2` is modeshape, 2.
fn words(name: &str) -> Vec<String> {
    let letters: Vec<char> = name.chars().collect();
    let mut words: Vec<String> = vec![String::new()];
    for (i, c) in letters.iter().enumerate() {
        if !c.is_alphanumeric() {
            words.push(String::new());
            continue;
        }
        let before = i.checked_sub(1).map(|j| letters[j]);
        let next = letters.get(i + 1);
        let is_new = before.is_some_and(|b| {
            b.is_alphabetic() != c.is_alphabetic()
                || (b.is_lowercase() && c.is_uppercase())
                || (b.is_uppercase() && c.is_uppercase() && next.is_some_and(|n| n.is_lowercase()))
        });
        if is_new {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut() {
            word.extend(c.to_lowercase());
        }
    }
    words.retain(|w| !w.is_empty());
    words
}

/// What a name says; of a field of a structure, `modes.freq`, the field first, then what it is in.
pub(super) fn says(name: &str) -> Says {
    let (own, outer) = name.rsplit_once('.').map_or((name, None), |(outer, own)| (own, Some(outer)));
    match (says_alone(own), outer) {
        // `freq.values`, `frf.data`
        (Says::Nothing, Some(outer))
            if matches!(own.to_lowercase().as_str(), "value" | "values" | "data" | "y" | "val") =>
        {
            says(outer)
        }
        (said, _) => said,
    }
}

fn says_alone(name: &str) -> Says {
    let words = words(name);
    let is = |list: &[&str]| words.iter().any(|w| list.contains(&w.as_str()));
    let holds = |list: &[&str]| words.iter().any(|w| list.iter().any(|part| w.contains(part)));
    let is_count = words.len() > 1 && matches!(words[0].as_str(), "n" | "d");
    if is(OTHERWISE) || is_count || words == ["f", "s"] {
        return Says::Nothing;
    }
    if holds(&["damp"]) || is(&["zeta", "zetas", "xi", "ksi", "dr"]) {
        return Says::Damping(if is(&["percent", "pct", "perc"]) { 0.01 } else { 1.0 });
    }
    if holds(&["coh"]) {
        return Says::Coherence;
    }
    let is_response = holds(&["resp", "accelerance", "mobility", "receptance", "inertance", "frf"]);
    if is_response || is(&["h", "tf", "function", "functions", "transfer"]) {
        return Says::Functions;
    }
    if holds(&["shape", "eigenvec", "eigvec", "evec"]) {
        return Says::Shapes;
    }
    if let Some(hertz) = frequency(&words) {
        return Says::Frequency(hertz);
    }
    let begins = |list: &[&str]| words.iter().any(|w| list.iter().any(|part| w.starts_with(part)));
    if begins(&["phi", "psi"]) || is(&["mode", "modes", "eigenmode", "eigenmodes"]) {
        return Says::Shapes;
    }
    if holds(&["eigenval", "eigval"]) || is(&["lambda", "lambdas", "pole", "poles", "eig", "eigs"]) {
        return Says::Eigenvalues;
    }
    if is(&["node", "nodes", "point", "points", "sensor", "sensors"]) {
        return Says::Points;
    }
    Says::Nothing
}

/// Hz in one of the unit of a name that says frequency.
fn frequency(words: &[String]) -> Option<f64> {
    let is = |list: &[&str]| words.iter().any(|w| list.contains(&w.as_str()));
    // A single letter counts at the beginning or end: `f_exp`, `test_f`.
    let ends = [words.first()?, words.last()?];
    let is_letter = |list: &[&str]| ends.iter().any(|w| list.contains(&w.as_str()));
    let is_spelled = words.iter().any(|w| {
        let rest = w.split_once("freq").or_else(|| w.split_once("frq")).map(|(_, rest)| rest);
        rest.is_some_and(|rest| !LIMITS.iter().any(|l| rest.starts_with(l)))
    });
    let is_angular = words.iter().any(|w| w.starts_with("omega"))
        || is(&["ang", "angular", "circ", "circular", "pulsation"])
        || is_letter(&["om", "w", "wn", "wr", "wd"]);
    let is_named = is_spelled || is_angular || is_letter(&["f", "fn", "fr", "fd", "fi", "fhz", "hz", "khz"]);
    let is_rate = is(&["rpm", "cpm"]);
    if !is_named && !is_rate {
        return None;
    }
    // `f_kHz` comes apart before its capital.
    let is_kilo = is(&["khz"]) || words.windows(2).any(|w| w[0] == "k" && w[1] == "hz");
    Some(if is_kilo {
        1e3
    } else if is(&["hz", "fhz"]) {
        1.0
    } else if is_rate {
        1.0 / 60.0
    } else if is(&["deg", "degs", "degps"]) {
        1.0 / 360.0
    } else if is_angular || is(&["rad", "rads", "radps", "radsec"]) {
        1.0 / TAU
    } else {
        1.0
    })
}

/// How two real arrays make a complex one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Parts {
    /// Real and imaginary part.
    Cartesian,
    /// Amplitude and phase, in the unit that the name states.
    Polar(Option<PhaseUnit>),
}

/// Unit of a phase.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PhaseUnit {
    Degrees,
    Radians,
}

const CARTESIAN: &[(&str, &str)] = &[("real", "imag"), ("real", "imaginary"), ("re", "im"), ("r", "i")];
const AMPLITUDES: &[&str] = &["abs", "amplitude", "amp", "ampl", "magnitude", "mag", "modulus"];
const PHASES: &[&str] = &["phase", "ph", "angle", "ang", "arg"];

/// What two names that are those of parts of one complex array say: what is left of them, and which parts they are. `H` of `Hre` and `Him`, of
/// `H_real` and `H_imag`, of `H_abs` and `H_phase_deg`.
pub(super) fn stem(first: &str, second: &str) -> Option<(String, Parts)> {
    let cartesian = CARTESIAN.iter().map(|pair| (*pair, second, Parts::Cartesian));
    let (bare, unit) = without_unit(second);
    let polar = AMPLITUDES
        .iter()
        .flat_map(|a| PHASES.iter().map(move |p| (*a, *p)))
        .map(|pair| (pair, bare, Parts::Polar(unit)));
    cartesian.chain(polar).find_map(|((of_first, of_second), second, parts)| {
        let [a, b] = [first, second].map(str::to_lowercase);
        let ending = || {
            a.strip_suffix(of_first)
                .filter(|stem| b.strip_suffix(of_second) == Some(*stem))
                .map(|s| first.get(..s.len()))
        };
        let beginning = || {
            a.strip_prefix(of_first)
                .filter(|stem| b.strip_prefix(of_second) == Some(*stem))
                .map(|_| first.get(of_first.len()..))
        };
        let stem = ending().or_else(beginning)??.trim_matches(['_', '.', ' ']);
        Some((if stem.is_empty() { format!("{first} + {second}") } else { stem.to_string() }, parts))
    })
}

/// A name without the unit of a phase at its end.
fn without_unit(name: &str) -> (&str, Option<PhaseUnit>) {
    let lower = name.to_lowercase();
    let units = [
        ("degrees", PhaseUnit::Degrees),
        ("deg", PhaseUnit::Degrees),
        ("radians", PhaseUnit::Radians),
        ("rad", PhaseUnit::Radians),
    ];
    units
        .iter()
        .find_map(|(word, unit)| {
            let length = lower.strip_suffix(word)?.len();
            Some((name.get(..length)?.trim_end_matches(['_', '.', ' ']), Some(*unit)))
        })
        .unwrap_or((name, None))
}

/// Which parts two variables are that the user puts together: amplitude and phase where their names say so, else real and imaginary part.
pub(super) fn parts_of(first: &str, second: &str) -> Parts {
    let (bare, unit) = without_unit(second);
    let says = |name: &str, list: &[&str]| {
        words(name).iter().any(|w| list.contains(&w.as_str()))
            || list.iter().any(|part| part.len() > 2 && name.to_lowercase().ends_with(part))
    };
    if says(first, AMPLITUDES) && says(bare, PHASES) { Parts::Polar(unit) } else { Parts::Cartesian }
}

/// The letters and the numbers of the name of one function of many: `H`, 2, 1 of `H21`, `H_2_1`, `H2_1`; `FRF`, 3 of `FRF_3`.
pub(super) fn numbered(name: &str) -> Option<(String, Vec<usize>)> {
    let at = name.find(|c: char| c.is_ascii_digit())?;
    let (letters, rest) = name.split_at(at);
    let parts: Vec<&str> = rest.split(['_', ',', '.', ' ']).collect();
    let number = |text: &str| (!text.is_empty() && text.len() < 7).then(|| text.parse().ok()).flatten();
    let numbers: Vec<usize> = match parts.as_slice() {
        // Two digits are those of two channels; three may be anything.
        [one] if one.len() == 2 => one.chars().map(|c| c.to_digit(10).map(|d| d as usize)).collect::<Option<_>>()?,
        [one] if one.len() == 1 => vec![number(one)?],
        [one, other] => vec![number(one)?, number(other)?],
        _ => return None,
    };
    Some((letters.trim_end_matches(['_', '.', ' ']).to_string(), numbers)).filter(|(letters, _)| !letters.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_what_they_are() {
        for name in [
            "f",
            "freq",
            "freq2",
            "freqx",
            "freqExp",
            "test_frequency",
            "FN",
            "f_n",
            "natFreqs",
            "modes.freq",
            "FHz",
            "freq.values",
        ] {
            assert_eq!(says(name), Says::Frequency(1.0), "{name}");
        }
        for (name, hertz) in [
            ("omega", 1.0 / TAU),
            ("w", 1.0 / TAU),
            ("freq_rad", 1.0 / TAU),
            ("f_kHz", 1e3),
            ("freq_rpm", 1.0 / 60.0),
            ("omega_Hz", 1.0),
        ] {
            assert_eq!(says(name), Says::Frequency(hertz), "{name}");
        }
        for name in [
            "phi",
            "psiExp_m",
            "modeshape2",
            "modeShapes",
            "test_mode",
            "eigenvectors",
            "Phi_exp",
            "modes.shape",
            "mode",
        ] {
            assert_eq!(says(name), Says::Shapes, "{name}");
        }
        for name in ["H", "FRF", "frequency_response", "Hre", "data.H"] {
            let expected = if name == "Hre" { Says::Nothing } else { Says::Functions };
            assert_eq!(says(name), expected, "{name}");
        }
        for name in [
            "nrb",
            "selist",
            "U1",
            "a",
            "f_max",
            "freqmax",
            "n_modes",
            "fs",
            "f_s",
            "df",
            "freq_sd",
            "mode_names",
            "modal_mass",
            "x",
        ] {
            assert_eq!(says(name), Says::Nothing, "{name}");
        }
        assert_eq!((says("dampExp"), says("zeta_percent")), (Says::Damping(1.0), Says::Damping(0.01)));
        assert_eq!(
            (says("lambda"), says("poles"), says("nodes")),
            (Says::Eigenvalues, Says::Eigenvalues, Says::Points)
        );
    }

    #[test]
    fn parts_of_a_complex_array_are_paired() {
        use Parts::{Cartesian, Polar};
        for (first, second, expected, parts) in [
            ("Hre", "Him", "H", Cartesian),
            ("H_real", "H_imag", "H", Cartesian),
            ("re_H", "im_H", "H", Cartesian),
            ("Hr", "Hi", "H", Cartesian),
            ("real", "imag", "real + imag", Cartesian),
            ("FRF_abs", "FRF_phase", "FRF", Polar(None)),
            ("H_mag", "H_phase_deg", "H", Polar(Some(PhaseUnit::Degrees))),
            ("magH", "angH", "H", Polar(None)),
            ("H.amplitude", "H.phase_rad", "H", Polar(Some(PhaseUnit::Radians))),
        ] {
            assert_eq!(stem(first, second), Some((expected.to_string(), parts)), "{first}");
            assert_eq!(stem(second, first), None, "{first}");
        }
        assert_eq!((stem("Hre", "Gim"), stem("f", "H"), stem("H_abs", "G_phase")), (None, None, None));
        assert_eq!((parts_of("A_abs", "B_phase"), parts_of("A", "B")), (Polar(None), Cartesian));
    }

    #[test]
    fn numbers_of_one_function_of_many_are_read() {
        let of = |name: &str| numbered(name).map(|(letters, n)| format!("{letters} {n:?}"));
        for (name, expected) in [("H21", "H [2, 1]"), ("H_12_3", "H [12, 3]"), ("FRF_3", "FRF [3]"), ("h1", "h [1]")] {
            assert_eq!(of(name).as_deref(), Some(expected), "{name}");
        }
        for name in ["H", "H123", "12", "H1a", "H_1_2_3"] {
            assert_eq!(of(name), None, "{name}");
        }
    }
}
