//! Long numeric arrays as compact text.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error as _};
use std::borrow::Cow;

const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// Base64 with padding of a byte string.
///
/// # Source
/// S. Josefsson, The Base16, Base32, and Base64 data encodings, RFC 4648, 2006, section 4.
pub(crate) fn base64(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let word = chunk.iter().fold(0_u32, |w, &b| (w << 8) | u32::from(b)) << (8 * (3 - chunk.len()));
        for place in 0..4 {
            let symbol = if place <= chunk.len() { ALPHABET[(word >> (18 - 6 * place)) as usize & 63] } else { b'=' };
            text.push(char::from(symbol));
        }
    }
    text
}

/// The bytes behind a base64 text, or why it is none.
pub(crate) fn from_base64(text: &str) -> Result<Vec<u8>, String> {
    let digits = text.as_bytes();
    if !digits.len().is_multiple_of(4) {
        return Err(format!("base64 text of {} characters; it must be a multiple of 4", digits.len()));
    }
    let padding = digits.iter().rev().take(2).take_while(|&&d| d == b'=').count();
    let mut bytes = Vec::with_capacity(digits.len() / 4 * 3);
    for quad in digits[..digits.len() - padding].chunks(4) {
        let mut word = 0_u32;
        for &digit in quad {
            let value = match digit {
                b'A'..=b'Z' => digit - b'A',
                b'a'..=b'z' => digit - b'a' + 26,
                b'0'..=b'9' => digit - b'0' + 52,
                b'+' => 62,
                b'/' => 63,
                _ => return Err(format!("`{}` is not a base64 digit", char::from(digit).escape_default())),
            };
            word = (word << 6) | u32::from(value);
        }
        word <<= 6 * (4 - quad.len());
        bytes.extend_from_slice(&word.to_be_bytes()[1..quad.len()]);
    }
    Ok(bytes)
}

/// Numbers that are base64 text in JSON.
macro_rules! packed {
    ($(#[$about:meta])* $name:ident, $number:ty, $n_bytes:literal, $word:literal, $text:literal) => {
        $(#[$about])*
        #[derive(Debug, Clone, PartialEq, Default)]
        pub struct $name(pub Vec<$number>);

        impl $name {
            /// How many.
            pub fn len(&self) -> usize {
                self.0.len()
            }

            /// Whether there is none.
            pub fn is_empty(&self) -> bool {
                self.0.is_empty()
            }
        }

        impl Serialize for $name {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                let bytes: Vec<u8> = self.0.iter().flat_map(|v| v.to_le_bytes()).collect();
                serializer.serialize_str(&base64(&bytes))
            }
        }

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let bytes = from_base64(&String::deserialize(deserializer)?).map_err(D::Error::custom)?;
                let (words, rest) = bytes.as_chunks::<$n_bytes>();
                if !rest.is_empty() {
                    let n = bytes.len();
                    return Err(D::Error::custom(format!("{n} bytes; {} take {} each", $word, $n_bytes)));
                }
                Ok(Self(words.iter().map(|w| <$number>::from_le_bytes(*w)).collect()))
            }
        }

        impl JsonSchema for $name {
            fn schema_name() -> Cow<'static, str> {
                stringify!($name).into()
            }

            fn json_schema(_: &mut SchemaGenerator) -> Schema {
                json_schema!({"type": "string", "description": $text})
            }
        }
    };
}

packed! {
    /// Single-precision numbers; in JSON the base64 text of their little-endian bytes. NaN means missing.
    Floats, f32, 4, "floats", "Base64 text of little-endian 32-bit floats; NaN means missing."
}

packed! {
    /// Double-precision numbers; in JSON the base64 text of their little-endian bytes. NaN means missing.
    Doubles, f64, 8, "doubles", "Base64 text of little-endian 64-bit floats; NaN means missing."
}

impl Floats {
    /// The numbers in single precision.
    pub fn from_f64(values: impl IntoIterator<Item = f64>) -> Self {
        Self(values.into_iter().map(|v| v as f32).collect())
    }
}

/// Three numbers a node, rounded: for pictures of large meshes.
///
/// In JSON `{step, data}`, with `data` the base64 text of little-endian 16-bit differences,
///
/// ```text
/// value_i = step k_i,    k_i = k_(i-3) + d_i,    |k| <= 2047,    k = -32768 where it is missing
/// ```
///
/// so that what changes little from node to node packs well. The rounding is at most 1/4094 of the largest value: a tenth of a pixel.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Levels(pub Vec<f32>);

#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Levels", description = "Three numbers a node, rounded to multiples of a step.")]
struct CodedLevels {
    /// The step.
    step: f64,
    /// Base64 text of little-endian 16-bit differences of multiples from node to node; a multiple of -32768 is missing.
    data: String,
}

const LARGEST_LEVEL: f64 = 2047.0;

impl Levels {
    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl JsonSchema for Levels {
    fn schema_name() -> Cow<'static, str> {
        CodedLevels::schema_name()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        CodedLevels::json_schema(generator)
    }
}

impl Serialize for Levels {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let peak = self.0.iter().map(|v| f64::from(v.abs())).filter(|v| v.is_finite()).fold(0.0, f64::max);
        let step = if peak > 0.0 { peak / LARGEST_LEVEL } else { 1.0 };
        let level = |v: f32| if v.is_finite() { (f64::from(v) / step).round() as i16 } else { i16::MIN };
        let mut last = [0_i16; 3];
        let bytes = self.0.iter().enumerate().flat_map(|(i, &v)| {
            let k = level(v);
            k.wrapping_sub(std::mem::replace(&mut last[i % 3], k)).to_le_bytes()
        });
        CodedLevels { step, data: base64(&bytes.collect::<Vec<u8>>()) }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Levels {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let coded = CodedLevels::deserialize(deserializer)?;
        let bytes = from_base64(&coded.data).map_err(D::Error::custom)?;
        let (words, rest) = bytes.as_chunks::<2>();
        if !rest.is_empty() {
            return Err(D::Error::custom(format!("{} bytes; levels take 2 each", bytes.len())));
        }
        let mut last = [0_i16; 3];
        let value = |(i, w): (usize, &[u8; 2])| {
            let k = last[i % 3].wrapping_add(i16::from_le_bytes(*w));
            last[i % 3] = k;
            if k == i16::MIN { f32::NAN } else { (coded.step * f64::from(k)) as f32 }
        };
        Ok(Self(words.iter().enumerate().map(value).collect()))
    }
}

/// A complex function of frequency, one value a line.
///
/// In JSON each value takes four bytes, so that several hundred channels of a thousand lines stay small: the base64
/// text of little-endian pairs (a, p) of `u16`,
///
/// ```text
/// |h| = exp(log_low + (a - 1) log_step)      a = 0: missing; the value zero is written as 1e-30 of the peak
/// arg h = p · 2π/65536
/// ```
///
/// The amplitude range of the curve is spread over 65,534 steps: the rounding is below 0.06 % of the amplitude for a
/// range of 30 decades and 0.005 degrees of phase, far below any measurement.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Spectrum(pub Vec<[f32; 2]>);

#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Spectrum", description = "A complex function of frequency, one value a line.")]
struct Coded {
    /// Logarithm of the smallest amplitude.
    log_low: f64,
    /// Logarithm of the ratio of two steps.
    log_step: f64,
    /// Base64 text of little-endian pairs (a, p) of 16 bits.
    data: String,
}

const STEPS: f64 = 65_534.0;
/// Amplitudes below this part of the peak are zero to any eye; it bounds the range that the steps must cover.
const FLOOR: f64 = 1e-30;

impl Spectrum {
    /// From real and imaginary parts.
    pub fn from_f64(values: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self(values.into_iter().map(|(re, im)| [re as f32, im as f32]).collect())
    }

    fn coded(&self) -> Coded {
        let polar: Vec<(f64, f64)> = self
            .0
            .iter()
            .map(|&[re, im]| (f64::from(re).hypot(f64::from(im)), f64::from(im).atan2(f64::from(re))))
            .collect();
        let peak = polar.iter().map(|p| p.0).filter(|a| a.is_finite()).fold(0.0, f64::max);
        let floor = if peak > 0.0 { peak * FLOOR } else { 1.0 };
        let logs = || polar.iter().filter(|p| p.0.is_finite()).map(|p| p.0.max(floor).ln());
        let (low, high) = logs().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        let low = if low.is_finite() { low } else { 0.0 };
        let step = if high > low { (high - low) / STEPS } else { 1.0 };
        let mut bytes = Vec::with_capacity(4 * polar.len());
        for (amplitude, phase) in polar {
            let a =
                if amplitude.is_finite() { 1 + ((amplitude.max(floor).ln() - low) / step).round() as u16 } else { 0 };
            let turn = (phase / std::f64::consts::TAU * 65_536.0).round();
            let p = if turn.is_finite() { turn.rem_euclid(65_536.0) as u16 } else { 0 };
            bytes.extend_from_slice(&a.to_le_bytes());
            bytes.extend_from_slice(&p.to_le_bytes());
        }
        Coded { log_low: low, log_step: step, data: base64(&bytes) }
    }
}

impl JsonSchema for Spectrum {
    fn schema_name() -> Cow<'static, str> {
        Coded::schema_name()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        Coded::json_schema(generator)
    }
}

impl Serialize for Spectrum {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.coded().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Spectrum {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let coded = Coded::deserialize(deserializer)?;
        let bytes = from_base64(&coded.data).map_err(D::Error::custom)?;
        let (words, rest) = bytes.as_chunks::<4>();
        if !rest.is_empty() {
            return Err(D::Error::custom(format!("{} bytes; a spectrum takes 4 a line", bytes.len())));
        }
        Ok(Self(
            words
                .iter()
                .map(|&[a0, a1, p0, p1]| {
                    let (a, p) = (u16::from_le_bytes([a0, a1]), u16::from_le_bytes([p0, p1]));
                    if a == 0 {
                        return [f32::NAN; 2];
                    }
                    let amplitude = (coded.log_low + f64::from(a - 1) * coded.log_step).exp();
                    let phase = f64::from(p) / 65_536.0 * std::f64::consts::TAU;
                    [(amplitude * phase.cos()) as f32, (amplitude * phase.sin()) as f32]
                })
                .collect(),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_vectors_of_rfc_4648_are_met() {
        for (plain, coded) in
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("foobar", "Zm9vYmFy")]
        {
            assert_eq!(base64(plain.as_bytes()), coded);
            assert_eq!(from_base64(coded).unwrap(), plain.as_bytes());
        }
    }

    #[test]
    fn text_that_is_no_base64_is_refused() {
        assert!(from_base64("abc").is_err());
        assert!(from_base64("ab-c").is_err());
        assert!(serde_json::from_str::<Floats>("\"Zg==\"").is_err());
        assert!(serde_json::from_str::<Spectrum>(r#"{"log_low":0,"log_step":1,"data":"Zg=="}"#).is_err());
    }

    #[test]
    fn floats_come_back_bit_for_bit() {
        let floats = Floats(vec![0.0, -1.5, f32::MAX, f32::MIN_POSITIVE, 1.0 / 3.0]);
        let text = serde_json::to_string(&floats).unwrap();
        assert_eq!(serde_json::from_str::<Floats>(&text).unwrap(), floats);
    }

    #[test]
    fn doubles_come_back_bit_for_bit() {
        let doubles = Doubles(vec![0.0, -1.5, f64::MAX, f64::MIN_POSITIVE, 1.0 / 3.0]);
        let text = serde_json::to_string(&doubles).unwrap();
        assert_eq!(serde_json::from_str::<Doubles>(&text).unwrap(), doubles);
        assert!(serde_json::from_str::<Doubles>("\"AACAPw==\"").is_err());
    }

    #[test]
    fn a_spectrum_keeps_zero_and_missing_values() {
        let spectrum = Spectrum(vec![[2.0, 0.0], [0.0, 0.0], [f32::NAN, 1.0], [0.0, -3.0]]);
        let back: Spectrum = serde_json::from_value(serde_json::to_value(&spectrum).unwrap()).unwrap();
        assert!((back.0[0][0] - 2.0).abs() < 2e-3 && back.0[0][1].abs() < 1e-3);
        assert!(back.0[1][0].abs() < 1e-25);
        assert!(back.0[2][0].is_nan());
        assert!(back.0[3][0].abs() < 1e-3 && (back.0[3][1] + 3.0).abs() < 3e-3);
        let empty: Spectrum = serde_json::from_value(serde_json::to_value(Spectrum::default()).unwrap()).unwrap();
        assert!(empty.0.is_empty());
    }

    #[test]
    fn levels_are_rounded_by_half_a_step_and_keep_what_is_missing() {
        let values: Vec<f32> =
            (0..600).map(|i| (0.37 * i as f32).sin() * if i % 3 == 0 { 2.0 } else { 0.01 }).collect();
        let levels = Levels(values.iter().copied().chain([f32::NAN, 0.5, f32::INFINITY, 1.0]).collect());
        let back: Levels = serde_json::from_value(serde_json::to_value(&levels).unwrap()).unwrap();
        assert_eq!(back.0.len(), 604);
        for (now, before) in back.0.iter().zip(&values) {
            assert!((now - before).abs() <= 2.0 / 4094.0 + 1e-6, "{before} became {now}");
        }
        assert!(back.0[600].is_nan() && back.0[602].is_nan() && (back.0[603] - 1.0).abs() < 5e-4);
        for none in [Levels::default(), Levels(vec![0.0; 3])] {
            assert_eq!(serde_json::from_value::<Levels>(serde_json::to_value(&none).unwrap()).unwrap(), none);
        }
        assert!(serde_json::from_str::<Levels>(r#"{"step":1,"data":"Zg=="}"#).is_err());
    }

    proptest! {
        #[test]
        fn any_bytes_survive_base64(bytes in proptest::collection::vec(any::<u8>(), 0..100)) {
            prop_assert_eq!(from_base64(&base64(&bytes)).unwrap(), bytes);
        }

        /// Six decades over 65,534 steps of ln: a step is 2.1e-4, so half a step is 1.06e-4 of the amplitude;
        /// half a phase step is 4.8e-5 rad; single precision adds 1e-7.
        #[test]
        fn a_spectrum_is_rounded_by_less_than_its_step(values in proptest::collection::vec((0.001_f64..1000.0, -3.1_f64..3.1), 1..50)) {
            let spectrum = Spectrum::from_f64(values.iter().map(|(a, p)| (a * p.cos(), a * p.sin())));
            let back: Spectrum = serde_json::from_value(serde_json::to_value(&spectrum).unwrap()).unwrap();
            for (now, before) in back.0.iter().zip(&spectrum.0) {
                let size = f64::from(before[0]).hypot(f64::from(before[1]));
                let gap = f64::from(now[0] - before[0]).hypot(f64::from(now[1] - before[1]));
                prop_assert!(gap < 1.6e-4 * size, "{before:?} became {now:?}");
            }
        }
    }
}
