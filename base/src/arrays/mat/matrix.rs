//! The elements of a MATLAB file.

use super::{MI_COMPRESSED, MI_MATRIX, MatError};
use retune_linalg::Complex;
use std::cell::Cell;

/// A value of MATLAB; arrays with the first index fastest.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A real or logical array.
    Real {
        /// Length of each dimension.
        dims: Vec<usize>,
        /// Values.
        values: Vec<f64>,
    },
    /// A complex array.
    Complex {
        /// Length of each dimension.
        dims: Vec<usize>,
        /// Values.
        values: Vec<Complex<f64>>,
    },
    /// Text; the rows of a matrix of characters one after the other, separated by line ends.
    Text(String),
    /// A cell array.
    Cell {
        /// Length of each dimension.
        dims: Vec<usize>,
        /// Values.
        values: Vec<Value>,
    },
    /// An array of structures.
    Structure {
        /// Length of each dimension.
        dims: Vec<usize>,
        /// Name of each field and its value in each structure.
        fields: Vec<(String, Vec<Value>)>,
    },
    /// A sparse matrix.
    Sparse {
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        columns: usize,
        /// Row, column (from 0) and value of each entry, by columns.
        entries: Vec<(usize, usize, Complex<f64>)>,
    },
    /// Something else: a function handle, an object.
    Other,
}

/// What the values of a file may still take in memory: a file that unfolds and widens cannot ask for more.
#[derive(Debug)]
pub(super) struct Budget {
    limit: usize,
    left: Cell<usize>,
}

impl Budget {
    pub(super) fn new(limit: usize) -> Self {
        Self { limit, left: Cell::new(limit) }
    }

    /// Bytes that are left.
    pub(super) fn left(&self) -> usize {
        self.left.get()
    }

    /// Takes `count` values of `each` bytes, before they are stored.
    pub(super) fn take(&self, count: usize, each: usize) -> Result<(), MatError> {
        let left = count.checked_mul(each).and_then(|bytes| self.left.get().checked_sub(bytes));
        self.left.set(left.ok_or(MatError::TooLarge { limit: self.limit })?);
        Ok(())
    }

    /// Gives bytes back that are stored no longer.
    pub(super) fn give(&self, bytes: usize) {
        self.left.set(self.limit.min(self.left.get() + bytes));
    }
}

/// Bytes being read.
#[derive(Debug, Clone)]
pub(super) struct Bytes<'a> {
    rest: &'a [u8],
    is_big: bool,
    budget: &'a Budget,
}

impl<'a> Bytes<'a> {
    pub(super) fn new(rest: &'a [u8], is_big: bool, budget: &'a Budget) -> Self {
        Self { rest, is_big, budget }
    }

    /// Other bytes of the same file.
    fn inside(&self, rest: &'a [u8]) -> Self {
        Self { rest, ..self.clone() }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    fn take(&mut self, n: usize, what: &'static str) -> Result<&'a [u8], MatError> {
        let (taken, rest) = self.rest.split_at_checked(n).ok_or(MatError::Truncated { what })?;
        self.rest = rest;
        Ok(taken)
    }

    fn join(&self, bytes: &[u8]) -> u64 {
        let join = |acc: u64, b: &u8| (acc << 8) | u64::from(*b);
        if self.is_big { bytes.iter().fold(0, join) } else { bytes.iter().rev().fold(0, join) }
    }

    /// Type of the next element.
    pub(super) fn peek(&self, what: &'static str) -> Result<u32, MatError> {
        self.clone().take(4, what).map(|tag| self.join(tag) as u32)
    }

    /// Type and data of the next element, with the bytes that fill it up to a multiple of eight; at the outermost level
    /// compressed elements are not filled up.
    pub(super) fn element(&mut self, what: &'static str, is_outermost: bool) -> Result<(u32, &'a [u8]), MatError> {
        let tag = self.take(4, what)?;
        let tag = self.join(tag) as u32;
        if tag >> 16 != 0 {
            let size = (tag >> 16) as usize;
            let data = self.take(4, what)?;
            let data = data.get(..size).ok_or(MatError::Truncated { what })?;
            return Ok((tag & 0xffff, data));
        }
        let size = self.take(4, what)?;
        let size = self.join(size) as usize;
        let data = self.take(size, what)?;
        if !(is_outermost && tag == MI_COMPRESSED) {
            let padding = size.next_multiple_of(8) - size;
            self.rest = self.rest.get(padding..).unwrap_or(&[]);
        }
        Ok((tag, data))
    }

    /// The numbers of an element of numeric type.
    fn numbers(&mut self, what: &'static str) -> Result<Option<Vec<f64>>, MatError> {
        let (kind, data) = self.element(what, false)?;
        let width = match kind {
            1 | 2 | 16 => 1,
            3 | 4 | 17 => 2,
            5..=7 | 18 => 4,
            9 | 12 | 13 => 8,
            _ => return Ok(None),
        };
        self.budget.take(data.len() / width, size_of::<f64>())?;
        let number = |bytes: &[u8]| {
            let b = self.join(bytes);
            match kind {
                1 => f64::from(b as u8 as i8),
                3 => f64::from(b as u16 as i16),
                5 => f64::from(b as u32 as i32),
                7 => f64::from(f32::from_bits(b as u32)),
                9 => f64::from_bits(b),
                12 => b as i64 as f64,
                _ => b as f64,
            }
        };
        Ok(Some(data.chunks_exact(width).map(number).collect()))
    }

    /// Non-negative integers of an element.
    fn counts(&mut self, what: &'static str) -> Result<Option<Vec<usize>>, MatError> {
        let Some(numbers) = self.numbers(what)? else { return Ok(None) };
        self.budget.take(numbers.len(), size_of::<usize>())?;
        Ok(numbers.iter().map(|v| (*v >= 0.0 && v.fract() == 0.0).then_some(*v as usize)).collect())
    }
}

/// Cells and structures nest at most so deep.
const DEEPEST: usize = 32;
/// A file that is wrong throughout is told so often.
const MOST_NOTES: usize = 20;

/// Reads the array that begins here, tag and all; `None` for an element that is none.
///
/// An array states its length twice: in its tag, and by the lengths of its parts. Where they differ the parts hold, with a
/// note; only of an array whose parts are not all understood is the tag trusted.
pub(super) fn array<'a>(
    input: &mut Bytes<'a>,
    depth: usize,
    notes: &mut Vec<String>,
) -> Result<Option<(String, Value)>, MatError> {
    const TAG: usize = 8;
    let head = |bytes: &[u8]| {
        let kind = input.join(bytes.get(..4)?) as u32;
        Some((kind, input.join(bytes.get(4..TAG)?) as usize))
    };
    let Some((MI_MATRIX, stated)) = head(input.rest) else {
        return input.element("an array", false).map(|_| None);
    };
    let begins_here =
        |bytes: &[u8]| bytes.is_empty() || head(bytes).is_some_and(|h| matches!(h.0, MI_MATRIX | MI_COMPRESSED));
    let all = &input.rest[TAG..];
    let body = &all[..stated.min(all.len())];
    let parse = |bytes: &'a [u8], notes: &mut Vec<String>| {
        let mut inner = input.inside(bytes);
        read(&mut inner, depth, notes).map(|found| (found, bytes.len() - inner.rest.len()))
    };
    let known = notes.len();
    let (found, used) = match parse(body, notes) {
        // Only here: a retry at every depth would double the work at each.
        Err(MatError::Truncated { .. }) if depth == 0 && body.len() < all.len() => {
            notes.truncate(known);
            parse(all, notes)?
        }
        other => other?,
    };
    let is_whole = !matches!(found.1, Value::Other) && stated != 0;
    let trusts_parts = stated > all.len()
        || used > stated
        || (is_whole && used < stated && begins_here(&all[used..]) && !begins_here(&all[stated..]));
    if trusts_parts && notes.len() < MOST_NOTES {
        let name =
            if found.0.is_empty() { "an array inside another".to_string() } else { format!("variable `{}`", found.0) };
        notes.push(format!("{name} states a length of {stated} bytes, its parts take {used}; the parts are taken"));
    }
    input.rest = &all[if trusts_parts { used } else { stated.next_multiple_of(TAG).min(all.len()) }..];
    Ok(Some(found))
}

/// Reads name and value from the inside of a matrix element.
fn read(input: &mut Bytes<'_>, depth: usize, notes: &mut Vec<String>) -> Result<(String, Value), MatError> {
    let malformed = |name: &str, why: &'static str| MatError::Malformed { name: name.to_owned(), why };
    if input.is_empty() {
        return Ok((String::new(), Value::Real { dims: vec![0, 0], values: Vec::new() }));
    }
    if depth > DEEPEST {
        return Err(malformed("", "cells and structures nested more than 32 deep"));
    }
    let (_, flags) = input.element("the flags of an array", false)?;
    let flags = flags.get(..4).ok_or(MatError::Truncated { what: "the flags of an array" })?;
    let flags = input.join(flags) as u32;
    let (class, is_complex) = (flags & 0xff, flags & 0x800 != 0);
    // Opaque objects have other parts.
    if matches!(class, 0 | 16..) {
        return Ok((String::new(), Value::Other));
    }
    let dims = input.counts("the dimensions of an array")?;
    let dims = dims.ok_or_else(|| malformed("", "its dimensions are not counts"))?;
    let (_, name) = input.element("the name of an array", false)?;
    let name: String = name.iter().map(|b| char::from(*b)).collect();
    let count = dims.iter().try_fold(1_usize, |n, d| n.checked_mul(*d));
    let count = count.ok_or_else(|| malformed(&name, "its dimensions are too large"))?;
    let value = match class {
        1 => {
            let values = children(input, count, &name, depth, notes)?;
            Value::Cell { dims, values }
        }
        2 => structure(input, dims, count, &name, depth, notes)?,
        4 => text(input, &dims, count, &name)?,
        5 => sparse(input, &dims, is_complex, &name)?,
        6..=15 => {
            let re = input.numbers("the values of an array")?.filter(|v| v.len() == count);
            let values = re.ok_or_else(|| malformed(&name, "its values do not fit its dimensions"))?;
            if is_complex {
                let im = input.numbers("the imaginary parts of an array")?.filter(|v| v.len() == count);
                let im = im.ok_or_else(|| malformed(&name, "its imaginary parts do not fit its dimensions"))?;
                input.budget.take(count, size_of::<Complex<f64>>())?;
                let values = values.iter().zip(im).map(|(re, im)| Complex::new(*re, im)).collect();
                Value::Complex { dims, values }
            } else {
                Value::Real { dims, values }
            }
        }
        _ => Value::Other,
    };
    Ok((name, value))
}

/// The arrays inside a cell array or structure.
fn children(
    input: &mut Bytes<'_>,
    count: usize,
    name: &str,
    depth: usize,
    notes: &mut Vec<String>,
) -> Result<Vec<Value>, MatError> {
    const LEAST_BYTES: usize = 8;
    if count > input.rest.len() / LEAST_BYTES {
        return Err(MatError::Malformed { name: name.to_owned(), why: "it announces more values than there are" });
    }
    // Twice: a structure sorts them by field.
    input.budget.take(count, 2 * size_of::<Value>())?;
    let mut values = Vec::with_capacity(count);
    for _ in 0..count {
        if input.is_empty() {
            return Err(MatError::Truncated { what: "a cell or field" });
        }
        let Some((_, value)) = array(input, depth + 1, notes)? else {
            return Err(MatError::Malformed { name: name.to_owned(), why: "a cell or field is not an array" });
        };
        values.push(value);
    }
    Ok(values)
}

fn structure(
    input: &mut Bytes<'_>,
    dims: Vec<usize>,
    count: usize,
    name: &str,
    depth: usize,
    notes: &mut Vec<String>,
) -> Result<Value, MatError> {
    let malformed = |why| MatError::Malformed { name: name.to_owned(), why };
    let width = input.counts("the length of field names")?.and_then(|w| w.first().copied()).filter(|w| *w > 0);
    let width = width.ok_or_else(|| malformed("the length of its field names is missing"))?;
    let (_, names) = input.element("the field names", false)?;
    input.budget.take(names.len() / width, width + size_of::<(String, Vec<Value>)>())?;
    let names: Vec<String> = names
        .chunks_exact(width)
        .map(|n| n.iter().take_while(|b| **b != 0).map(|b| char::from(*b)).collect())
        .collect();
    let total = count.checked_mul(names.len()).ok_or_else(|| malformed("its dimensions are too large"))?;
    let values = children(input, total, name, depth, notes)?;
    let mut fields: Vec<(String, Vec<Value>)> = names.into_iter().map(|n| (n, Vec::new())).collect();
    let n_fields = fields.len();
    for (i, value) in values.into_iter().enumerate() {
        fields[i % n_fields].1.push(value);
    }
    Ok(Value::Structure { dims, fields })
}

fn text(input: &mut Bytes<'_>, dims: &[usize], count: usize, name: &str) -> Result<Value, MatError> {
    const UTF_8: u32 = 16;
    let malformed = |why| MatError::Malformed { name: name.to_owned(), why };
    let mut ahead = input.clone();
    let (kind, data) = ahead.element("text", false)?;
    input.budget.take(data.len(), 2 * size_of::<char>() + size_of::<u16>())?;
    let units: Vec<char> = if kind == UTF_8 {
        *input = ahead;
        String::from_utf8_lossy(data).chars().collect()
    } else {
        let codes = input.numbers("text")?.ok_or_else(|| malformed("its characters have an unknown type"))?;
        let codes: Vec<u16> = codes.iter().map(|c| *c as u16).collect();
        char::decode_utf16(codes).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
    };
    let rows = dims.first().copied().unwrap_or(0);
    if rows <= 1 || count == 0 || units.len() != count {
        return Ok(Value::Text(units.into_iter().collect()));
    }
    let columns = count / rows;
    let row = |r: usize| (0..columns).map(|c| units[c * rows + r]).collect::<String>();
    Ok(Value::Text((0..rows).map(row).collect::<Vec<_>>().join("\n")))
}

fn sparse(input: &mut Bytes<'_>, dims: &[usize], is_complex: bool, name: &str) -> Result<Value, MatError> {
    let malformed = |why| MatError::Malformed { name: name.to_owned(), why };
    let &[rows, columns] = dims else { return Err(malformed("a sparse array without two dimensions")) };
    let row_of = input.counts("the rows of a sparse matrix")?.ok_or_else(|| malformed("its rows are not counts"))?;
    let starts =
        input.counts("the columns of a sparse matrix")?.ok_or_else(|| malformed("its columns are not counts"))?;
    let re = input.numbers("the values of a sparse matrix")?.ok_or_else(|| malformed("its values are not numbers"))?;
    let im = if is_complex { input.numbers("the imaginary parts of a sparse matrix")? } else { None };
    let is_sound = columns.checked_add(1) == Some(starts.len())
        && starts.is_sorted()
        && starts.last().is_some_and(|n| *n <= re.len() && *n <= row_of.len())
        && row_of.iter().take(starts.last().copied().unwrap_or(0)).all(|r| *r < rows)
        && im.as_ref().is_none_or(|v| v.len() == re.len());
    if !is_sound {
        return Err(malformed("the parts of a sparse matrix do not fit each other"));
    }
    input.budget.take(re.len(), size_of::<(usize, usize, Complex<f64>)>())?;
    let mut entries = Vec::with_capacity(re.len());
    for (column, range) in starts.windows(2).enumerate() {
        for k in range[0]..range[1] {
            let value = Complex::new(re[k], im.as_ref().map_or(0.0, |v| v[k]));
            entries.push((row_of[k], column, value));
        }
    }
    Ok(Value::Sparse { rows, columns, entries })
}
