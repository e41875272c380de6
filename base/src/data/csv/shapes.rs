//! Shapes in one table: points down, modes across.
//!
//! ```text
//! point,x_in,y_in,z_in,direction,bending 7.93 Hz,twist 16.1 Hz,twist 16.1 Hz:im
//! 1,15,18,0,+z,-0.0326,0.0512,0.001
//! ```
//!
//! * `point` (also `node`, `sensor`) names the point; several rows of one point are several directions.
//! * Coordinates are columns that begin with `x`, `y`, `z`, alone or followed by `_`, a blank or a bracket; a last word `m`, `mm`, `cm`,
//!   `in` or `ft` states their unit. All three or none may be there, or two: the third is 0 then.
//! * `direction` is `+x`, `-x` ... `-z`; without the column it must be stated.
//! * A column whose name holds a number before `Hz` (or `kHz`, `rad/s`, `rpm`) is a mode of that frequency, written with the decimal
//!   mark of the table; the rest of the name is its label. `:im` at the end marks imaginary parts, `:re` may mark real ones. A blank cell was not measured.

use super::header::{is_mode, mode_name};
use super::{CsvError, Row, Sheet};
use crate::catalogue::counted;
use crate::data::convert::{ConvertError, Question, UnitSystem, UnitsFrom};
use crate::data::{ModalSet, ModeRecord, Point, ShapeChannel};
use crate::dof::Dof;
use retune_linalg::{Complex, DVector};
use std::collections::BTreeMap;

/// What a table of shapes holds.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeTable {
    /// The modes.
    pub modes: ModalSet,
    /// Positions of the points; none when the table has no coordinates.
    pub points: Vec<Point>,
}

/// A column of a mode.
struct ModeColumn {
    column: usize,
    label: String,
    hz: f64,
    is_imaginary: bool,
}

/// Whether a column names points.
pub(in crate::data) fn is_point(name: &str) -> bool {
    matches!(name.trim().to_lowercase().as_str(), "point" | "node" | "sensor")
}

/// Axis and unit of length of a column of coordinates: `x`, `y_in`, `z (mm)`, `x left mm`.
pub(in crate::data) fn coordinate(name: &str) -> Option<(usize, Option<f64>)> {
    let lower = name.trim().to_lowercase();
    let axis = ["x", "y", "z"].iter().position(|a| lower.starts_with(a))?;
    if lower.len() > 1 && !lower[1..].starts_with(['_', ' ', '(', '[', '/']) {
        return None;
    }
    let unit = match lower.rsplit(['_', ' ', '(', '[', '/']).next().map(|u| u.trim_end_matches([')', ']'])) {
        Some("m") => Some(1.0),
        Some("cm") => Some(0.01),
        Some("mm") => Some(1e-3),
        Some("in") => Some(0.0254),
        Some("ft") => Some(0.3048),
        _ => None,
    };
    Some((axis, unit))
}

fn ask(option: &'static str, text: &str, answers: &[&str]) -> CsvError {
    let answers = answers.iter().map(|a| (*a).to_string()).collect();
    ConvertError::Questions(vec![Question { option, text: text.to_string(), answers }]).into()
}

/// Columns of coordinates, with the SI value of one unit in each.
struct Places([Option<(usize, f64)>; 3]);

impl Places {
    /// Finds them; one of three may be missing.
    fn of(sheet: &Sheet<'_>, units: &UnitsFrom, notes: &mut Vec<String>) -> Result<Option<Self>, CsvError> {
        let mut places: [Option<(usize, Option<f64>)>; 3] = [None; 3];
        for (column, name) in sheet.names.iter().enumerate().filter(|(_, n)| !is_mode(n)) {
            if let Some((axis, unit)) = coordinate(name) {
                places[axis] = Some((column, unit));
            }
        }
        if places.iter().flatten().count() < 2 {
            return Ok(None);
        }
        if let Some(axis) = places.iter().position(Option::is_none) {
            notes.push(format!("no column for {}: it is 0 for all points", ["x", "y", "z"][axis]));
        }
        let mut scaled = [None; 3];
        for (own, place) in scaled.iter_mut().zip(places) {
            let Some((column, unit)) = place else { continue };
            let stated = unit.or(match units {
                UnitsFrom::System(system) => Some(system.length),
                _ => None,
            });
            let Some(scale) = stated else {
                return Err(ask("geometry-units", "the unit of the coordinates is not stated", &UnitSystem::NAMES));
            };
            *own = Some((column, scale));
        }
        Ok(Some(Self(scaled)))
    }

    fn position(&self, sheet: &Sheet<'_>, row: &Row<'_>) -> Result<[f64; 3], CsvError> {
        let mut position_m = [0.0; 3];
        for (value, place) in position_m.iter_mut().zip(self.0) {
            if let Some((column, scale)) = place {
                *value = sheet.finite(row, column)? * scale;
            }
        }
        Ok(position_m)
    }
}

/// Points by name; the last row of several counts, as the last of several nodes of one label does.
#[derive(Default)]
struct PointList {
    points: Vec<Point>,
    index: BTreeMap<String, usize>,
    moved: Vec<String>,
}

impl PointList {
    fn put(&mut self, name: &str, position_m: [f64; 3], row: &Row<'_>) {
        if let Some(&at) = self.index.get(name) {
            if self.points[at].position_m != position_m {
                self.moved.push(in_line(name, row));
            }
            self.points[at].position_m = position_m;
            return;
        }
        self.index.insert(name.to_string(), self.points.len());
        self.points.push(Point { name: name.to_string(), position_m, axes: Point::GLOBAL });
    }
}

/// Reads a table of points, `point,x,y,z`, and says what was taken for granted.
///
/// * `units` - unit of the coordinates where the names of their columns state none
///
/// # Errors
/// Cells that are not numbers; [`ConvertError::Questions`] for a unit that is not stated.
pub fn read_points(bytes: &[u8], units: &UnitsFrom) -> Result<(Vec<Point>, Vec<String>), CsvError> {
    let sheet = Sheet::read(bytes)?;
    let name = point_column(&sheet)?;
    let mut notes = Vec::new();
    let Some(places) = Places::of(&sheet, units, &mut notes)? else {
        sheet.column("x")?;
        return Ok((Vec::new(), notes));
    };
    let mut list = PointList::default();
    let mut repeated: Vec<String> = Vec::new();
    for row in &sheet.rows {
        let point = row.cells[name].as_ref();
        if list.index.contains_key(point) {
            repeated.push(in_line(point, row));
        }
        list.put(&row.cells[name], places.position(&sheet, row)?, row);
    }
    notes.extend(told(&repeated, "point", "whose name was there before"));
    Ok((list.points, notes))
}

/// Rows that were there before, by name.
fn told(repeated: &[String], what: &str, how: &str) -> Option<String> {
    const SHOWN: usize = 4;
    let shown = repeated[..repeated.len().min(SHOWN)].join(", ");
    let more = if repeated.len() > SHOWN { format!(" and {} more", repeated.len() - SHOWN) } else { String::new() };
    let counted = counted(repeated.len(), what);
    (!repeated.is_empty()).then(|| format!("{counted} {how}: {shown}{more}; the last one counts"))
}

/// A name and where it stands.
fn in_line(name: &str, row: &Row<'_>) -> String {
    format!("`{}` in line {}", name.escape_debug(), row.line)
}

fn point_column(sheet: &Sheet<'_>) -> Result<usize, CsvError> {
    sheet.names.iter().position(|n| is_point(n)).map_or_else(|| sheet.column("point"), Ok)
}

fn is_direction(name: &str) -> bool {
    matches!(name.trim().to_lowercase().as_str(), "direction" | "dir")
}

fn direction_of(text: &str) -> Option<[f64; 3]> {
    let (sign, axis) = match text.as_bytes() {
        [b'-', rest @ ..] => (-1.0, rest),
        [b'+', rest @ ..] | rest => (1.0, rest),
    };
    let at = [b"x", b"y", b"z"].iter().position(|a| a.eq_ignore_ascii_case(axis))?;
    let mut d = [0.0; 3];
    d[at] = sign;
    Some(d)
}

/// Reads a table of shapes, and says what was taken for granted.
///
/// * `units` - unit of the coordinates where the names of their columns state none
/// * `direction` - of the shapes, in a table without the column
///
/// # Errors
/// Cells that are not numbers; [`ConvertError::Questions`] for a unit or direction that is not stated.
pub fn read_shapes(
    bytes: &[u8],
    units: &UnitsFrom,
    direction: Option<[f64; 3]>,
) -> Result<(ShapeTable, Vec<String>), CsvError> {
    let sheet = Sheet::read(bytes)?;
    let point = point_column(&sheet)?;
    let mut notes = Vec::new();
    let mut modes: Vec<ModeColumn> = Vec::new();
    for (column, name) in sheet.names.iter().enumerate() {
        if let Some(mode) = mode_name(name, sheet.decimal_comma) {
            let super::header::ModeName { hz, label, is_imaginary } = mode?;
            let is_same = |m: &ModeColumn| (m.hz, &m.label, m.is_imaginary) == (hz, &label, is_imaginary);
            if let Some(before) = modes.iter().position(is_same) {
                notes.push(format!("the column `{name}` is there more than once; the last one counts"));
                modes.remove(before);
            }
            modes.push(ModeColumn { column, label, hz, is_imaginary });
        } else if coordinate(name).is_none() && !is_point(name) && !is_direction(name) {
            notes.push(format!("column `{name}` is neither a coordinate nor a mode, and is left out"));
        }
    }
    if let Some(lost) = modes
        .iter()
        .find(|m| m.is_imaginary && !modes.iter().any(|r| !r.is_imaginary && r.hz == m.hz && r.label == m.label))
    {
        let name = sheet.names[lost.column].to_string();
        return Err(CsvError::ColumnName { name, expected: "the column of its real part is missing" });
    }
    let directions = sheet.names.iter().position(|n| is_direction(n));
    if directions.is_none() && direction.is_none() {
        return Err(ask("direction", "the direction of the shapes is not stated", &["+x", "+y", "+z"]));
    }
    let places = Places::of(&sheet, units, &mut notes)?;
    let mut channels: Vec<ShapeChannel> = Vec::new();
    let mut list = PointList::default();
    // The row of each channel, and the channels by point and direction.
    let mut rows: Vec<&Row<'_>> = Vec::new();
    let mut index: BTreeMap<(&str, [u64; 3]), usize> = BTreeMap::new();
    let mut repeated: Vec<String> = Vec::new();
    for row in &sheet.rows {
        let name = row.cells[point].as_ref();
        let own = match directions {
            None => direction,
            Some(column) => Some(direction_of(&row.cells[column]).ok_or_else(|| CsvError::Cell {
                line: row.line,
                column: column + 1,
                name: sheet.names[column].to_string(),
                text: row.cells[column].to_string(),
                expected: "`+x`, `-x` ... `-z`",
            })?),
        };
        let own = own.unwrap_or([0.0, 0.0, 1.0]);
        if let Some(places) = &places {
            list.put(name, places.position(&sheet, row)?, row);
        }
        if let Some(&before) = index.get(&(name, own.map(f64::to_bits))) {
            repeated.push(in_line(name, row));
            rows[before] = row;
            continue;
        }
        index.insert((name, own.map(f64::to_bits)), rows.len());
        let axis = (0..3).max_by(|a, b| own[*a].abs().total_cmp(&own[*b].abs())).unwrap_or(2);
        channels.push(ShapeChannel { point: name.to_string(), dof: Dof::ALL[axis], direction: own });
        rows.push(row);
    }
    notes.extend(told(&repeated, "row", "whose point and direction were there before"));
    notes.extend(told(&list.moved, "row", "whose point was there before at another place"));
    let mut records: Vec<ModeRecord> = Vec::new();
    for mode in modes.iter().filter(|m| !m.is_imaginary) {
        let imaginary = modes.iter().find(|m| m.is_imaginary && m.hz == mode.hz && m.label == mode.label);
        let cell = |row: &Row<'_>, column: usize| {
            if row.cells[column].is_empty() { Ok(f64::NAN) } else { sheet.number(row, column) }
        };
        let shape = rows
            .iter()
            .copied()
            .map(|row| Ok(Complex::new(cell(row, mode.column)?, imaginary.map_or(Ok(0.0), |m| cell(row, m.column))?)))
            .collect::<Result<Vec<_>, CsvError>>()?;
        let label = (!mode.label.is_empty()).then(|| mode.label.clone());
        records.push(ModeRecord::new(label, mode.hz, DVector::from_vec(shape)));
    }
    records.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    Ok((ShapeTable { modes: ModalSet { channels, modes: records }, points: list.points }, notes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_of_shapes_is_read_with_its_units() {
        let text = b"point,x_left_in,y_mm,direction,first bending 7.9 Hz,twist_16.25Hz,twist_16.25Hz:im,who\n\
                     1,10,20,+z,1,0.5,0.1,a\n2,0,0,-x,,-1,0,b\n";
        let (table, notes) = read_shapes(text, &UnitsFrom::File, None).unwrap();
        assert_eq!(table.points[0].position_m, [0.254, 0.02, 0.0]);
        assert_eq!(notes.len(), 2, "{notes:?}");
        let modes = &table.modes.modes;
        assert_eq!((modes[0].frequency_hz, modes[0].label.as_deref()), (7.9, Some("first bending")));
        assert_eq!((modes[1].label.as_deref(), modes[1].shape[0]), (Some("twist"), Complex::new(0.5, 0.1)));
        assert!(modes[0].shape[1].re.is_nan());
        assert_eq!(table.modes.channels[1].direction, [-1.0, 0.0, 0.0]);
    }

    #[test]
    fn what_is_not_stated_is_asked_for() {
        let text = b"point,x,y,z,1 Hz\n1,1,2,3,4\n";
        let error = |units, direction| read_shapes(text, units, direction).unwrap_err().to_string();
        let z = Some([0.0, 0.0, 1.0]);
        assert!(error(&UnitsFrom::File, None).contains("direction"));
        assert!(error(&UnitsFrom::File, z).contains("geometry-units"));
        let mm = UnitsFrom::System(UnitSystem::from_name("mm-N-s").unwrap());
        assert_eq!(read_shapes(text, &mm, z).unwrap().0.points[0].position_m, [0.001, 0.002, 0.003]);
        let bad = read_shapes(b"point,direction,1 Hz\n1,up,4\n", &mm, None).unwrap_err().to_string();
        assert!(bad.contains("line 2, column 2 (`direction`): `up`"), "{bad}");
    }

    #[test]
    fn a_decimal_comma_in_the_header_is_one_and_other_units_are_converted() {
        let text =
            b"Node;X (mm);y_mm;z_mm;bending 7,9 Hz;second 49,1 Hz;third 0,5 kHz\n1;0;0;0;0;0;1\n2;100;0;0;0,1;-0,4;1\n";
        let z = Some([0.0, 0.0, 1.0]);
        let (table, notes) = read_shapes(text, &UnitsFrom::File, z).unwrap();
        let hz: Vec<f64> = table.modes.modes.iter().map(|m| m.frequency_hz).collect();
        assert_eq!((hz, notes.len()), (vec![7.9, 49.1, 500.0], 0));
        assert_eq!(table.points[1].position_m, [0.1, 0.0, 0.0]);
        // The cells have points, the header a comma: thousands or decimals?
        let error = read_shapes(b"point;bending 7,9 Hz\n1;0.5\n", &UnitsFrom::File, z).unwrap_err().to_string();
        assert!(error.contains("`bending 7,9 Hz`"), "{error}");
        let quoted = read_shapes(b"point,\"bending 7,9 Hz\"\n1,\"0,5\"\n", &UnitsFrom::File, z).unwrap().0;
        assert_eq!((quoted.modes.modes[0].frequency_hz, quoted.modes.modes[0].shape[0].re), (7.9, 0.5));
    }

    #[test]
    fn what_is_there_twice_is_told_and_the_last_one_counts() {
        let si = UnitsFrom::System(UnitSystem::from_name("SI").unwrap());
        let (points, notes) = read_points(b"point,x,y,z\n1,0,0,0\n2,5,0,0\n1,1,0,0\n", &si).unwrap();
        assert_eq!((points.len(), points[0].position_m), (2, [1.0, 0.0, 0.0]));
        assert_eq!(notes, ["1 point whose name was there before: `1` in line 4; the last one counts"]);
        let text = b"point,x,y,z,direction,1 Hz,1 Hz\n1,0,0,0,+z,1,2\n1,0,0,0,+x,3,4\n1,0,1,0,+z,5,6\n";
        let (table, notes) = read_shapes(text, &si, None).unwrap();
        assert_eq!(notes.len(), 3, "{notes:?}");
        assert!(notes[1].starts_with("1 row whose point and direction were there before: `1` in line 4"), "{notes:?}");
        assert_eq!(table.points[0].position_m, [0.0, 1.0, 0.0]);
        let shape = &table.modes.modes[0].shape;
        assert_eq!((shape.len(), shape[0].re, shape[1].re), (2, 6.0, 4.0));
        assert!(read_points(b"point,x,y,z\n1,nan,0,0\n", &si).is_err());
        assert!(read_points(b"point,x\n1,0\n", &si).unwrap().0.is_empty());
    }

    #[test]
    fn mutated_tables_do_no_harm() {
        use rand::{Rng, RngExt, SeedableRng};
        let seed = "sep=;\npoint;x_mm;y_mm;direction;bending 7,9 Hz;twist 1,6e1 Hz:re;twist 1,6e1 Hz:im;\n1;0;0,5;+z;1,5;2;0;\n1;0;0;-x;1;2;3;\n";
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let mut read = 0;
        for _ in 0..6_000 {
            let mut bytes = seed.as_bytes().to_vec();
            for _ in 0..rng.random_range(1..4) {
                let at = rng.random_range(0..bytes.len());
                match rng.random_range(0..3) {
                    0 => bytes[at] = rng.next_u32() as u8,
                    1 => bytes[at] = b"\t,;\n.0-9'()"[rng.random_range(0..11)],
                    _ => bytes.truncate(at + 1),
                }
            }
            let si = UnitsFrom::System(UnitSystem::from_name("SI").unwrap());
            read += u32::from(read_shapes(&bytes, &si, Some([0.0, 0.0, 1.0])).is_ok());
            let _ = read_points(&bytes, &si);
        }
        assert!(read > 0);
    }
}
