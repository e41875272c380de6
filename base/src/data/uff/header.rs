//! Datasets 151 and 164: header and units.

use super::cursor::{Cursor, Fault, never};
use super::fields::{column, parse_int};
use super::note::{Level, quote};
use super::sink::Sink;

/// A date, a time and what follows them in the record.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Stamp {
    /// Columns 1-10, usually DD-MMM-YY.
    pub date: String,
    /// Columns 11-20, usually HH:MM:SS.
    pub time: String,
    /// The rest of the record; in the first stamp two versions and the type of the file, ten columns each.
    pub rest: String,
}

/// Dataset 151: where the file comes from.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Header {
    /// Name of the model file.
    pub model_name: String,
    /// Description.
    pub description: String,
    /// Program that created the database.
    pub database_program: String,
    /// When the database was created.
    pub created: Stamp,
    /// When the database was saved last.
    pub saved: Stamp,
    /// Program that wrote the file.
    pub program: String,
    /// When the file was written.
    pub written: Stamp,
}

pub(super) fn read_151(cursor: &mut Cursor<'_, '_>) -> Header {
    let stamp = |cursor: &mut Cursor<'_, '_>| {
        let text = cursor.record().unwrap_or_default();
        let text = text.trim_end();
        let rest = column(text, 20, usize::MAX - 20).to_owned();
        Stamp { date: column(text, 0, 10).trim().to_owned(), time: column(text, 10, 10).trim().to_owned(), rest }
    };
    Header {
        model_name: cursor.text(),
        description: cursor.text(),
        database_program: cursor.text(),
        created: stamp(cursor),
        saved: stamp(cursor),
        program: cursor.text(),
        written: stamp(cursor),
    }
}

pub(super) fn write_151(header: &Header, sink: &mut Sink) {
    sink.begin(151);
    let stamp = |s: &Stamp, sink: &mut Sink| {
        sink.field(&s.date, 10);
        sink.field(&s.time, 10);
        sink.raw(s.rest.trim_end());
        sink.end_record();
    };
    sink.text(&header.model_name);
    sink.text(&header.description);
    sink.text(&header.database_program);
    stamp(&header.created, sink);
    stamp(&header.saved, sink);
    sink.text(&header.program);
    stamp(&header.written, sink);
    sink.end();
}

/// Dataset 164: units.
///
/// ```text
/// SI value = value of the file / factor
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Units {
    /// 1 SI, 2 BG (foot, lbf), 3 MG (m, kgf), 4 BA (foot, poundal), 5 MM (mm, mN), 6 CM (cm, cN), 7 IN (inch, lbf),
    /// 8 GM (mm, kgf), 9 user defined, 10 MN (mm, N).
    pub code: i64,
    /// Description, for people.
    pub description: String,
    /// 1 absolute, 2 relative.
    pub temperature_mode: i64,
    /// Units of length in a metre.
    pub length: f64,
    /// Units of force in a newton.
    pub force: f64,
    /// Units of temperature in a kelvin.
    pub temperature: f64,
    /// Offset of temperature.
    pub temperature_offset: f64,
}

pub(super) fn read_164(cursor: &mut Cursor<'_, '_>) -> Result<Units, Fault> {
    let Some(text) = cursor.record() else { return Err(cursor.fault("the dataset is empty")) };
    let Some(code) = parse_int(column(&text, 0, 10)) else {
        return Err(cursor.fault(format!("{} where the units code should stand", quote(&text))));
    };
    let mode = column(&text, 30, 10).trim();
    let temperature_mode = parse_int(mode).unwrap_or(0);
    if !mode.is_empty() && parse_int(mode).is_none() {
        cursor.note(Level::Info, format!("temperature mode {}", quote(mode)), "it counts as 0");
    }
    let description = column(&text, 10, 20).trim().to_owned();
    let mut f = Vec::new();
    cursor.floats(4, &[25; 3], never, &mut f)?;
    if f.len() < 2 {
        return Err(cursor.fault("fewer than two unit factors"));
    }
    if f.len() < 4 {
        cursor.note(Level::Info, format!("{} of 4 unit factors", f.len()), "those of temperature count as 1 and 0");
    }
    Ok(Units {
        code,
        description,
        temperature_mode,
        length: f[0],
        force: f[1],
        temperature: f.get(2).copied().unwrap_or(1.0),
        temperature_offset: f.get(3).copied().unwrap_or(0.0),
    })
}

pub(super) fn write_164(units: &Units, sink: &mut Sink) {
    sink.begin(164);
    sink.ints(&[(units.code, 10)]);
    sink.field(&units.description, 20);
    sink.ints(&[(units.temperature_mode, 10)]);
    sink.end_record();
    for value in [units.length, units.force, units.temperature] {
        sink.double(value, 17);
    }
    sink.end_record();
    sink.double(units.temperature_offset, 17);
    sink.end_record();
    sink.end();
}
