//! Reads and writes dataset 58, function at nodal DOF, as text and as binary (58b).

use super::cursor::{Cursor, Fault, never};
use super::fields::{column, parse_float, parse_int};
use super::layout::{Layout, RECORD_7};
use super::note::{Level, quote};
use super::scan::{Block, binary_fields};
use super::sink::Sink;
use super::{Abscissa, Axis, ByteOrder, Entity, FloatFormat, Function, Ordinate, Precision, Storage, float_formats};
use crate::catalogue::counted;
use retune_linalg::Complex;

pub(super) fn read(block: &Block<'_>, cursor: &mut Cursor<'_, '_>) -> Result<Function, Fault> {
    let ids = cursor.ids();
    let dof = read_dof(cursor)?;
    let form = cursor.numbers(&RECORD_7, "the form of the data (record 7)")?;
    let Some(layout) = Layout::of(form.int(0), form.int(2)) else {
        return Err(cursor.fault(format!("ordinate data type {}, known are 2, 4, 5 and 6", form.int(0))));
    };
    if !(0..=1).contains(&form.int(2)) {
        cursor.note(Level::Warning, format!("abscissa spacing {}", form.int(2)), "read as even");
    }
    let mut axes = [Axis::of(0), Axis::of(0), Axis::of(0), Axis::of(0)];
    for axis in &mut axes {
        *axis = read_axis(cursor)?;
    }
    let announced = usize::try_from(form.int(1)).unwrap_or(0);
    let (numbers, storage) = match block.payload {
        Some(payload) => read_binary(&block.id_line, payload, layout, announced, cursor),
        None => (read_text(layout, announced, block.text.len(), cursor)?, Storage::Ascii),
    };
    let points = numbers.len() / layout.per_point();
    if points != announced {
        let seen = format!("{} announced, {points} present", counted(announced, "point"));
        cursor.note(Level::Warning, seen, "the points present were read");
    }
    let chunks = || numbers.chunks_exact(layout.per_point());
    let skip = usize::from(!layout.is_even);
    let abscissa = if layout.is_even {
        Abscissa::Even { start: form.float(3), step: form.float(4) }
    } else {
        Abscissa::Uneven(chunks().map(|c| c[0]).collect())
    };
    let ordinate = if layout.is_complex {
        Ordinate::Complex(chunks().map(|c| Complex::new(c[skip], c[skip + 1])).collect())
    } else {
        Ordinate::Real(chunks().map(|c| c[skip]).collect())
    };
    let z_value = form.float(5);
    let Dofs { function_type, function_id, version, load_case, response, reference } = dof;
    let precision = layout.precision;
    Ok(Function {
        ids,
        function_type,
        function_id,
        version,
        load_case,
        response,
        reference,
        precision,
        abscissa,
        ordinate,
        z_value,
        axes,
        storage,
    })
}

fn read_text(layout: Layout, announced: usize, bytes: usize, cursor: &mut Cursor<'_, '_>) -> Result<Vec<f64>, Fault> {
    // A number takes at least two bytes, so that a false count cannot ask for more memory than the file has.
    let count = if announced == 0 { usize::MAX } else { announced.saturating_mul(layout.per_point()) };
    let mut numbers = Vec::with_capacity(count.min(bytes / 2));
    cursor.floats(count, layout.widths(), never, &mut numbers)?;
    Ok(numbers)
}

fn read_binary(
    id_line: &str,
    payload: &[u8],
    layout: Layout,
    announced: usize,
    cursor: &mut Cursor<'_, '_>,
) -> (Vec<f64>, Storage) {
    let [order, format, records, _] = binary_fields(id_line).map(|f| f.unwrap_or(0));
    let order = match order {
        1 => ByteOrder::Little,
        2 => ByteOrder::Big,
        other => {
            cursor.note(Level::Warning, format!("byte ordering {other}"), "read as little endian (1)");
            ByteOrder::Little
        }
    };
    let format = match format {
        1 => FloatFormat::DecVms,
        2 => FloatFormat::Ieee,
        3 => FloatFormat::Ibm370,
        other => {
            cursor.note(Level::Warning, format!("floating-point format {other}"), "read as IEEE 754 (2)");
            FloatFormat::Ieee
        }
    };
    if records != 11 {
        cursor.note(Level::Info, format!("{records} text records announced"), "11 were read");
    }
    let sizes = layout.bytes_per_point();
    let exact = sizes.iter().find(|s| s.checked_mul(announced) == Some(payload.len()));
    let size = *exact.unwrap_or(&sizes[0]);
    let is_short_abscissa = size == 4 + 8 * layout.ordinates_per_point() && layout.precision == Precision::Double;
    let width = if layout.precision == Precision::Single { 4 } else { 8 };
    let most = if announced == 0 { usize::MAX } else { announced };
    let mut numbers = Vec::with_capacity(payload.len() / width + 1);
    for point in payload.chunks_exact(size).take(most) {
        let mut rest = point;
        if is_short_abscissa {
            numbers.push(float_formats::read_single(&rest[..4], order, format));
            rest = &rest[4..];
        }
        numbers.extend(rest.chunks_exact(width).map(|bytes| {
            if width == 4 {
                float_formats::read_single(bytes, order, format)
            } else {
                float_formats::read_double(bytes, order, format)
            }
        }));
    }
    (numbers, Storage::Binary { order, format })
}

struct Dofs {
    function_type: i64,
    function_id: i64,
    version: i64,
    load_case: i64,
    response: Entity,
    reference: Entity,
}

/// Record 6, by columns or, where names or labels are too long for them, by blanks.
fn read_dof(cursor: &mut Cursor<'_, '_>) -> Result<Dofs, Fault> {
    let Some(text) = cursor.record() else { return Err(cursor.fault("the dataset ends before record 6")) };
    let int = |start, width| {
        let field = column(&text, start, width);
        if field.trim().is_empty() { Some(0) } else { parse_int(field) }
    };
    let entity = |start: usize| {
        let name = column(&text, start + 1, 10).trim().to_owned();
        let (node, direction) = (int(start + 11, 10)?, int(start + 21, 4)?);
        // A number that is cut by the column and does not end with it belongs to a record written without columns.
        let is_cut = |at: usize, width| {
            let pair = column(&text, at - 1, 2);
            let touches = pair.chars().count() == 2 && pair.chars().all(|c| c.is_ascii_digit());
            touches && column(&text, at, width).ends_with(' ')
        };
        (!is_cut(start + 11, 10) && !is_cut(start + 21, 4)).then_some(Entity { name, node, direction })
    };
    let by_columns = || {
        Some(Dofs {
            function_type: int(0, 5)?,
            function_id: int(5, 10)?,
            version: int(15, 5)?,
            load_case: int(20, 10)?,
            response: entity(30)?,
            reference: entity(55)?,
        })
    };
    if let Some(dofs) = by_columns() {
        return Ok(dofs);
    }
    let dofs = dofs_by_blanks(&text);
    match dofs {
        Some(dofs) => {
            cursor.note(Level::Warning, "record 6 is not in its columns", "it was read by the blanks");
            Ok(dofs)
        }
        None => Err(cursor.fault(format!("{} where the dofs (record 6) should stand", quote(&text)))),
    }
}

fn dofs_by_blanks(text: &str) -> Option<Dofs> {
    let tokens: Vec<&str> = text.split_whitespace().collect();
    let int = |i: usize| tokens.get(i).and_then(|t| parse_int(t));
    let (function_type, function_id, version, load_case) = (int(0)?, int(1)?, int(2)?, int(3)?);
    // name... node direction name... node direction: a direction lies in -6..6 and follows a node.
    let pair = |i: usize| Some((int(i)?, int(i + 1).filter(|d| (-6..=6).contains(d))?));
    let first = (4..tokens.len()).find(|i| pair(*i).is_some())?;
    let (node, direction) = pair(first)?;
    let response = Entity { name: tokens[4..first].join(" "), node, direction };
    let second = (first + 2..tokens.len()).find(|i| pair(*i).is_some());
    let reference = match second {
        Some(at) => {
            let (node, direction) = pair(at)?;
            Entity { name: tokens[first + 2..at].join(" "), node, direction }
        }
        None => Entity { name: tokens[first + 2..].join(" "), node: 0, direction: 0 },
    };
    Some(Dofs { function_type, function_id, version, load_case, response, reference })
}

fn read_axis(cursor: &mut Cursor<'_, '_>) -> Result<Axis, Fault> {
    let Some(text) = cursor.record() else { return Err(cursor.fault("the dataset ends before records 8 to 11")) };
    let mut unreadable = false;
    let mut int = |start, width| {
        let field = column(&text, start, width);
        let value = if field.trim().is_empty() { Some(0) } else { parse_int(field) };
        unreadable |= value.is_none() && parse_float(field).is_none();
        value.unwrap_or(0)
    };
    let axis = Axis {
        data_type: int(0, 10),
        length_exponent: int(10, 5),
        force_exponent: int(15, 5),
        temperature_exponent: int(20, 5),
        label: column(&text, 26, 20).trim().to_owned(),
        units: column(&text, 47, 20).trim().to_owned(),
    };
    if unreadable {
        cursor.note(Level::Warning, format!("axis record {}", quote(&text)), "unreadable numbers count as 0");
    }
    Ok(axis)
}

pub(super) fn write(function: &Function, sink: &mut Sink) {
    let layout = Layout {
        precision: function.precision,
        is_complex: matches!(function.ordinate, Ordinate::Complex(_)),
        is_even: matches!(function.abscissa, Abscissa::Even { .. }),
    };
    let n = match &function.abscissa {
        Abscissa::Even { .. } => function.ordinate.len(),
        Abscissa::Uneven(x) => function.ordinate.len().min(x.len()),
    };
    let numbers = interleave(function, n);
    let binary = match function.storage {
        Storage::Ascii => None,
        Storage::Binary { order, format } => {
            if format != FloatFormat::Ieee {
                sink.note(Level::Info, "values in DEC or IBM format", "they are written as IEEE 754");
            }
            Some(order)
        }
    };
    match binary {
        None => sink.begin(58),
        Some(order) => {
            let width = if layout.precision == Precision::Single { 4 } else { 8 };
            sink.begin_binary(58, order, numbers.len() * width);
        }
    }
    sink.texts(&function.ids);
    sink.ints(&[
        (function.function_type, 5),
        (function.function_id, 10),
        (function.version, 5),
        (function.load_case, 10),
    ]);
    for entity in [&function.response, &function.reference] {
        sink.name(&entity.name, 10);
        sink.ints(&[(entity.node, 10), (entity.direction, 4)]);
    }
    sink.end_record();
    sink.ints(&[(layout.ordinate_type(), 10), (n as i64, 10), (i64::from(layout.is_even), 10)]);
    let (start, step) = match function.abscissa {
        Abscissa::Even { start, step } => (start, step),
        Abscissa::Uneven(_) => (0.0, 0.0),
    };
    for value in [start, step, function.z_value] {
        sink.float(value, 13, 5);
    }
    sink.end_record();
    for axis in &function.axes {
        sink.ints(&[
            (axis.data_type, 10),
            (axis.length_exponent, 5),
            (axis.force_exponent, 5),
            (axis.temperature_exponent, 5),
        ]);
        sink.name(&axis.label, 20);
        sink.name(&axis.units, 20);
        sink.end_record();
    }
    match binary {
        None => sink.float_lines(&numbers, layout.widths()),
        Some(order) => sink.payload(&numbers, order, layout.precision),
    }
    sink.end();
}

fn interleave(function: &Function, n: usize) -> Vec<f64> {
    let mut numbers = Vec::with_capacity(3 * n);
    for i in 0..n {
        if let Abscissa::Uneven(x) = &function.abscissa {
            numbers.push(x[i]);
        }
        match &function.ordinate {
            Ordinate::Real(v) => numbers.push(v[i]),
            Ordinate::Complex(v) => numbers.extend([v[i].re, v[i].im]),
        }
    }
    numbers
}
