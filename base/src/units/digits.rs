//! Numbers in the characters that word processors and other scripts write.

use std::borrow::Cow;

/// The text with ASCII characters in numbers: full-width digits, points and signs (`５`, `．`, `－`), and the minus sign of typography (U+2212)
/// where a sign may stand: at the beginning, after a blank, and in an exponent; elsewhere it is part of a power of a unit, `s−2`.
pub fn ascii_numbers(text: &str) -> Cow<'_, str> {
    if text.is_ascii() {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        out.push(match c {
            '\u{ff10}'..='\u{ff19}' => char::from(b'0' + (c as u32 - 0xff10) as u8),
            '\u{ff0e}' => '.',
            '\u{ff0b}' => '+',
            '\u{2212}' | '\u{ff0d}' if is_sign_after(&out) => '-',
            _ => c,
        });
    }
    Cow::Owned(out)
}

/// Whether a minus after this text is a sign.
fn is_sign_after(before: &str) -> bool {
    let mut back = before.chars().rev();
    match back.next() {
        None => true,
        Some('e' | 'E') => back.next().is_some_and(|c| c.is_ascii_digit() || c == '.'),
        Some(c) => c.is_whitespace() || matches!(c, '+' | '*' | '/' | '(' | ',' | ';' | '['),
    }
}

/// What a text holds in place of a minus sign or a digit, as a clause for a message: dashes and other characters that look like them.
pub(super) fn look_alike(text: &str) -> Option<String> {
    let c = text
        .chars()
        .find(|c| matches!(c, '\u{2010}'..='\u{2015}' | '\u{ad}' | '\u{fe63}' | '\u{2212}' | '\u{ff0d}'))?;
    Some(format!("`{c}` (U+{:04X}) is not a minus sign; write `-`", c as u32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_in_other_characters() {
        for (text, expected) in [
            ("５ mm", "5 mm"),
            ("−60 cm", "-60 cm"),
            ("－１．５e−３", "-1.5e-3"),
            ("2*a −3*b", "2*a -3*b"),
            ("9.81 m s−2", "9.81 m s−2"),
            ("plain", "plain"),
        ] {
            assert_eq!(ascii_numbers(text), expected, "{text}");
        }
    }

    #[test]
    fn a_dash_is_named() {
        assert_eq!(look_alike("\u{2013}60 cm").as_deref(), Some("`–` (U+2013) is not a minus sign; write `-`"));
        assert_eq!(look_alike("-60 cm"), None);
    }
}
