//! Names of channels in the headers of tables, whatever characters they have.
//!
//! In a name, what has a meaning in a header and what ends a line is written `\\x2f`, with the two hexadecimal digits of its code.

use super::header;
use crate::data::Channel;
use std::fmt::Write as _;

/// `12.+z` to name and direction.
pub(super) fn channel(text: &str) -> Channel {
    let found = header::channel(text);
    Channel { name: plain(&found.name), ..found }
}

/// Response and reference of the name of a column: at the `/` between them. Where names hold others that are not escaped, it is the one
/// behind a direction; `None` where that does not tell.
pub(super) fn ends(pair: &str) -> Option<(&str, Option<&str>)> {
    let at: Vec<usize> = pair.match_indices('/').map(|(i, _)| i).collect();
    let split = |i: usize| (&pair[..i], Some(&pair[i + 1..]));
    match at.as_slice() {
        [] => Some((pair, None)),
        [one] => Some(split(*one)),
        _ => {
            let mut behind = at.iter().filter(|i| channel(&pair[..**i]).direction.is_some());
            behind.next().filter(|_| behind.next().is_none()).map(|i| split(*i))
        }
    }
}

/// Name and direction as they stand in a table; a name that ends like a direction does not read as one.
pub(super) fn label(c: &Channel) -> String {
    let name = escaped(&c.name);
    let text = Channel { name: name.clone(), direction: c.direction }.label();
    match text.char_indices().last() {
        Some((at, last)) if text == name && header::channel(&text).direction.is_some() => {
            format!("{}\\x{:02x}", &text[..at], u32::from(last))
        }
        _ => text,
    }
}

fn escaped(name: &str) -> String {
    let n = name.chars().count();
    let mut out = String::with_capacity(name.len());
    for (i, c) in name.chars().enumerate() {
        let is_edge = i == 0 || i + 1 == n;
        let has_meaning =
            matches!(c, '/' | ',' | ';' | ':' | '"' | '\\' | '[' | ']' | '(' | ')') || c.is_ascii_control();
        if has_meaning || (is_edge && c == ' ') {
            let _ = write!(out, "\\x{:02x}", u32::from(c));
        } else {
            out.push(c);
        }
    }
    out
}

/// The name behind [`escaped`].
fn plain(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find("\\x") {
        let code = rest.get(at + 2..at + 4).and_then(|hex| u8::from_str_radix(hex, 16).ok()).filter(u8::is_ascii);
        out.push_str(&rest[..at]);
        match code {
            Some(code) => out.push(char::from(code)),
            None => out.push_str(&rest[at..at + 2]),
        }
        rest = &rest[at + if code.is_some() { 4 } else { 2 }..];
    }
    out + rest
}
