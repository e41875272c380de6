//! Shapes in one table: points down, modes across.
//!
//! ```text
//! point,x_in,y_in,z_in,direction,bending 7.93 Hz,twist 16.1 Hz,twist 16.1 Hz:im
//! 1,15,18,0,+z,-0.0326,0.0512,0.001
//! ```
//!
//! * `point` names the point; several rows of one point are several directions.
//! * Coordinates are columns that begin with `x`, `y`, `z`, alone or followed by `_` or a blank; a last word `m`, `mm`, `cm`, `in`
//!   or `ft` states their unit. All three or none may be there, or two: the third is 0 then.
//! * `direction` is `+x`, `-x` ... `-z`; without the column it must be stated.
//! * A column whose name holds a number before `Hz` is a mode of that frequency; the rest of the name is its label. `:im` at the
//!   end marks imaginary parts, `:re` may mark real ones. A blank cell was not measured.

use super::{CsvError, Sheet};
use crate::data::convert::{ConvertError, Question, UnitSystem, UnitsFrom};
use crate::data::{ModalSet, ModeRecord, Point, ShapeChannel};
use crate::element::Dof;
use crate::linalg::{Complex, DVector};

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

/// The frequency in the name of a column: the number before `Hz`, with the label that is left.
pub(in crate::data) fn frequency_of(name: &[u8]) -> Option<f64> {
    std::str::from_utf8(name).ok().and_then(mode_name).map(|m| m.0)
}

/// Frequency, label, and whether it is an imaginary part.
fn mode_name(name: &str) -> Option<(f64, String, bool)> {
    let (body, is_imaginary) = match name.rsplit_once(':') {
        Some((body, "im")) => (body, true),
        Some((body, "re")) => (body, false),
        _ => (name, false),
    };
    let head = body.trim_end().strip_suffix("Hz").or_else(|| body.trim_end().strip_suffix("hz"))?.trim_end();
    let number = &head[head.trim_end_matches(|c: char| c.is_ascii_digit() || c == '.').len()..];
    let hz = number.parse::<f64>().ok().filter(|f| f.is_finite() && *f > 0.0)?;
    let label = head[..head.len() - number.len()].trim_end_matches(['_', ' ', '-']).trim().to_string();
    Some((hz, label, is_imaginary))
}

/// Axis and unit of length of a column of coordinates.
fn coordinate(name: &str) -> Option<(usize, Option<f64>)> {
    let axis = ["x", "y", "z"].iter().position(|a| name.starts_with(a))?;
    if name.len() > 1 && !name[1..].starts_with(['_', ' ']) {
        return None;
    }
    let unit = match name.rsplit(['_', ' ']).next() {
        Some("m") => Some(1.0),
        Some("cm") => Some(0.01),
        Some("mm") => Some(1e-3),
        Some("in") => Some(0.0254),
        Some("ft") => Some(0.3048),
        _ => None,
    };
    Some((axis, unit))
}

fn direction_of(text: &str) -> Option<[f64; 3]> {
    let (sign, axis) = match text.as_bytes() {
        [b'-', rest @ ..] => (-1.0, rest),
        [b'+', rest @ ..] | rest => (1.0, rest),
    };
    let at = [b"x", b"y", b"z"].iter().position(|a| a.as_slice() == axis)?;
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
/// Cells that are no numbers; [`ConvertError::Questions`] for a unit or direction that is not stated.
pub fn read_shapes(
    bytes: &[u8],
    units: &UnitsFrom,
    direction: Option<[f64; 3]>,
) -> Result<(ShapeTable, Vec<String>), CsvError> {
    let sheet = Sheet::read(bytes)?;
    let point = sheet.column("point")?;
    let (mut modes, mut places, mut notes) = (Vec::new(), [None; 3], Vec::new());
    for (column, name) in sheet.names.iter().enumerate() {
        if let Some((hz, label, is_imaginary)) = mode_name(name) {
            modes.push(ModeColumn { column, label, hz, is_imaginary });
        } else if let Some((axis, unit)) = coordinate(name) {
            places[axis] = Some((column, unit));
        } else if !matches!(name.as_ref(), "point" | "direction") {
            notes.push(format!("column `{name}` is neither a coordinate nor a mode, and is left out"));
        }
    }
    let directions = sheet.names.iter().position(|n| n == "direction");
    let ask = |option, text: &str, answers: &[&str]| {
        let answers = answers.iter().map(|a| (*a).to_string()).collect();
        CsvError::from(ConvertError::Questions(vec![Question { option, text: text.to_string(), answers }]))
    };
    if directions.is_none() && direction.is_none() {
        return Err(ask("direction", "the direction of the shapes is not stated", &["+x", "+y", "+z"]));
    }
    let is_placed = places.iter().flatten().count() >= 2;
    if is_placed && let Some(axis) = places.iter().position(Option::is_none) {
        notes.push(format!("no column for {}: it is 0 for all points", ["x", "y", "z"][axis]));
    }
    let mut scale = [0.0; 3];
    for (axis, place) in places.iter().enumerate().filter(|_| is_placed) {
        let stated = place.and_then(|(_, unit)| unit).or(match units {
            UnitsFrom::System(system) => Some(system.length),
            _ => None,
        });
        scale[axis] = match (place, stated) {
            (Some(_), Some(scale)) => scale,
            (Some(_), None) => {
                return Err(ask("geometry-units", "the unit of the coordinates is not stated", &UnitSystem::NAMES));
            }
            (None, _) => 0.0,
        };
    }
    let (mut channels, mut points): (Vec<ShapeChannel>, Vec<Point>) = (Vec::new(), Vec::new());
    for row in &sheet.rows {
        let name = row.cells[point].to_string();
        let own = match directions {
            None => direction,
            Some(column) => Some(direction_of(&row.cells[column]).ok_or_else(|| CsvError::Cell {
                line: row.line,
                column: column + 1,
                name: "direction".to_string(),
                text: row.cells[column].to_string(),
                expected: "`+x`, `-x` ... `-z`",
            })?),
        };
        let own = own.unwrap_or([0.0, 0.0, 1.0]);
        let axis = (0..3).max_by(|a, b| own[*a].abs().total_cmp(&own[*b].abs())).unwrap_or(2);
        channels.push(ShapeChannel { point: name.clone(), dof: Dof::ALL[axis], direction: own });
        if is_placed && !points.iter().any(|p| p.name == name) {
            let mut position_m = [0.0; 3];
            for (axis, place) in places.iter().enumerate() {
                if let Some((column, _)) = place {
                    position_m[axis] = sheet.number(row, *column)? * scale[axis];
                }
            }
            points.push(Point { name, position_m, axes: Point::GLOBAL });
        }
    }
    let mut records: Vec<ModeRecord> = Vec::new();
    for mode in modes.iter().filter(|m| !m.is_imaginary) {
        let imaginary = modes.iter().find(|m| m.is_imaginary && m.hz == mode.hz && m.label == mode.label);
        let cell = |row, column: usize| {
            let row: &super::Row<'_> = row;
            if row.cells[column].is_empty() { Ok(f64::NAN) } else { sheet.number(row, column) }
        };
        let shape = sheet
            .rows
            .iter()
            .map(|row| Ok(Complex::new(cell(row, mode.column)?, imaginary.map_or(Ok(0.0), |m| cell(row, m.column))?)))
            .collect::<Result<Vec<_>, CsvError>>()?;
        let label = (!mode.label.is_empty()).then(|| mode.label.clone());
        records.push(ModeRecord::new(label, mode.hz, DVector::from_vec(shape)));
    }
    records.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    Ok((ShapeTable { modes: ModalSet { channels, modes: records }, points }, notes))
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
    fn names_of_columns_that_are_no_modes() {
        for name in ["Hz", "frequency_hz", "-Hz", "é7 Hz!", "x", "0 Hz", "Hz:im"] {
            assert!(mode_name(name).is_none(), "{name}");
        }
        assert_eq!(mode_name("é7.5 Hz"), Some((7.5, "é".to_string(), false)));
    }
}
