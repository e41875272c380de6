//! Frequency response functions in tables.

use super::{CsvError, Sheet};
use crate::data::convert::{ConvertError, Question, ratio_unit};
use crate::data::uff::{Abscissa, Axis, Entity, Function, Ordinate, Precision, Storage};
use crate::data::{Channel, FrfQuantity, FrfSet};
use crate::linalg::Complex;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// What a table may leave open.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CsvFrfOptions {
    /// The unit of all functions, such as `m/s2/N`; it must not contradict a row of units.
    pub unit: Option<String>,
    /// The reference of columns that name none.
    pub reference: Option<Channel>,
}

/// The name of a point that has none.
const UNNAMED_REFERENCE: &str = "force";

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    Re,
    Im,
    Coherence,
}

/// `12.+z` to name and direction.
fn channel(text: &str) -> Channel {
    let split = text.rsplit_once('.').and_then(|(name, direction)| {
        let sign = if direction.starts_with('-') { -1.0 } else { 1.0 };
        let axis = ["x", "y", "z"].iter().position(|a| *a == direction.trim_start_matches(['+', '-']))?;
        let mut vector = [0.0; 3];
        vector[axis] = sign;
        Some(Channel { name: name.to_owned(), direction: Some(vector) })
    });
    split.unwrap_or_else(|| Channel { name: text.to_owned(), direction: None })
}

/// Distinct channels in the order of their first appearance.
#[derive(Default)]
struct Channels<'a> {
    list: Vec<Channel>,
    index: BTreeMap<&'a str, usize>,
}

impl<'a> Channels<'a> {
    fn index_of(&mut self, text: &'a str, make: impl FnOnce() -> Channel) -> usize {
        *self.index.entry(text).or_insert_with(|| {
            self.list.push(make());
            self.list.len() - 1
        })
    }
}

/// Reads a table of frequency response functions in the layout of this module.
///
/// # Errors
/// [`CsvError`] with line and column; [`ConvertError::Questions`] inside it if the unit is not stated.
pub fn read_frfs(bytes: &[u8], options: &CsvFrfOptions) -> Result<FrfSet, CsvError> {
    let mut sheet = Sheet::read(bytes)?;
    let frequency = sheet.column("frequency_hz")?;
    let has_units = sheet.rows.first().is_some_and(|r| sheet.parse(&r.cells[frequency]).is_none());
    let units = if has_units { Some(sheet.rows.remove(0)) } else { None };
    if let Some(row) = &units
        && row.cells[frequency] != "Hz"
    {
        return Err(CsvError::Cell {
            line: row.line,
            column: frequency + 1,
            name: "frequency_hz".to_owned(),
            text: row.cells[frequency].to_string(),
            expected: "`Hz` (row of units) or a number",
        });
    }
    let (mut references, mut responses) = (Channels::default(), Channels::default());
    let mut columns = Vec::new();
    for (i, name) in sheet.names.iter().enumerate().filter(|(i, _)| *i != frequency) {
        let wrong = || CsvError::ColumnName {
            name: name.to_string(),
            expected: "its name must end with `:re`, `:im` or `:coh`",
        };
        let (pair, part) = name.rsplit_once(':').ok_or_else(wrong)?;
        let part = match part {
            "re" => Part::Re,
            "im" => Part::Im,
            "coh" => Part::Coherence,
            _ => return Err(wrong()),
        };
        let (response, reference) = pair.split_once('/').map_or((pair, None), |(a, b)| (a, Some(b)));
        let unnamed = || Channel { name: UNNAMED_REFERENCE.to_owned(), direction: None };
        let a = match reference {
            Some(text) => references.index_of(text, || channel(text)),
            None => references.index_of("", || options.reference.clone().unwrap_or_else(unnamed)),
        };
        columns.push((i, part, a, responses.index_of(response, || channel(response))));
    }
    let (quantity, scales) = scales(&sheet, units.as_ref(), &columns, options)?;
    let mut set = FrfSet {
        quantity,
        frequencies_hz: Vec::with_capacity(sheet.rows.len()),
        references: references.list,
        responses: responses.list,
        h: Vec::new(),
        coherence: None,
        n_averages: None,
    };
    let cells_per_line = set.references.len() * set.responses.len();
    if cells_per_line > 64 * columns.len() {
        let (references, responses) = (set.references.len(), set.responses.len());
        return Err(ConvertError::TooSparse { measured: columns.len() / 2, references, responses }.into());
    }
    let has_coherence = columns.iter().any(|(_, part, ..)| *part == Part::Coherence);
    let mut coherence = Vec::new();
    for (line, row) in sheet.rows.iter().enumerate() {
        let f = sheet.number(row, frequency)?;
        if !f.is_finite() || set.frequencies_hz.last().is_some_and(|last| f <= *last) {
            return Err(CsvError::Cell {
                line: row.line,
                column: frequency + 1,
                name: "frequency_hz".to_owned(),
                text: row.cells[frequency].to_string(),
                expected: "a frequency above the one before",
            });
        }
        set.frequencies_hz.push(f);
        set.h.resize(set.h.len() + cells_per_line, Complex::new(f64::NAN, f64::NAN));
        if has_coherence {
            coherence.resize(set.h.len(), f64::NAN);
        }
        for ((i, part, a, b), scale) in columns.iter().zip(&scales) {
            // An empty cell is a value that was not measured.
            let value = if row.cells[*i].is_empty() { f64::NAN } else { sheet.number(row, *i)? };
            let cell = set.index(line, *a, *b);
            match part {
                Part::Re => set.h[cell].re = value * scale,
                Part::Im => set.h[cell].im = value * scale,
                Part::Coherence => coherence[cell] = value,
            }
        }
    }
    set.coherence = has_coherence.then_some(coherence);
    Ok(set)
}

type Column = (usize, Part, usize, usize);

/// The quantity of all functions and the SI value of one unit in each column.
fn scales(
    sheet: &Sheet<'_>,
    units: Option<&super::Row<'_>>,
    columns: &[Column],
    options: &CsvFrfOptions,
) -> Result<(FrfQuantity, Vec<f64>), CsvError> {
    let mut quantity = None;
    let mut scales = Vec::with_capacity(columns.len());
    for (i, part, ..) in columns {
        if *part == Part::Coherence {
            scales.push(1.0);
            continue;
        }
        let own = units.map(|r| r.cells[*i].as_ref()).filter(|u| !u.is_empty());
        let label = match (own, options.unit.as_deref()) {
            (Some(own), Some(stated)) if ratio_unit(own) != ratio_unit(stated) => {
                return Err(ask(format!(
                    "column `{}` has the unit `{own}`, the option says `{stated}`",
                    sheet.names[*i]
                )));
            }
            (Some(label), _) | (None, Some(label)) => label,
            (None, None) => return Err(ask("the table does not state the unit of its functions".to_owned())),
        };
        let Some((q, response, force)) = ratio_unit(label) else {
            return Err(ask(format!("`{label}` is not understood as a unit of response over force")));
        };
        if quantity.is_some_and(|known| known != q) {
            return Err(CsvError::ColumnName {
                name: sheet.names[*i].to_string(),
                expected: "all functions of a table must be of one quantity",
            });
        }
        quantity = Some(q);
        scales.push(response / force);
    }
    match quantity {
        Some(q) => Ok((q, scales)),
        None => Err(ConvertError::Nothing { what: "columns `:re` and `:im`", found: sheet.names.join(", ") }.into()),
    }
}

fn ask(text: String) -> CsvError {
    let answers = ["m/s2/N", "m/s/N", "m/N", "g/N", "g/lbf", "mm/s2/N"].map(String::from).to_vec();
    ConvertError::Questions(vec![Question { option: "unit", text, answers }]).into()
}

/// Writes functions as a table in the layout of this module, in SI; every bit comes back.
///
/// A direction that is not along a global axis is left out, as the layout cannot say it.
pub fn write_frfs(set: &FrfSet) -> String {
    let unit = ["m/N", "m/s/N", "m/s2/N"][set.quantity.order() as usize];
    let pairs: Vec<(usize, usize)> = (0..set.references.len())
        .flat_map(|a| (0..set.responses.len()).map(move |b| (a, b)))
        .filter(|(a, b)| (0..set.n_lines()).any(|line| !set.at(line, *a, *b).re.is_nan()))
        .collect();
    let mut names = String::from("frequency_hz");
    let mut units = String::from("Hz");
    for (a, b) in &pairs {
        let pair = format!("{}/{}", set.responses[*b].label(), set.references[*a].label()).replace([',', '"'], "_");
        let _ = write!(names, ",{pair}:re,{pair}:im");
        let _ = write!(units, ",{unit},{unit}");
        if set.coherence.is_some() {
            let _ = write!(names, ",{pair}:coh");
            units.push_str(",1");
        }
    }
    let mut text = format!("{names}\n{units}\n");
    let cell = |value: f64| if value.is_nan() { String::new() } else { format!("{value:?}") };
    for line in 0..set.n_lines() {
        let _ = write!(text, "{:?}", set.frequencies_hz[line]);
        for (a, b) in &pairs {
            let h = set.at(line, *a, *b);
            let _ = write!(text, ",{},{}", cell(h.re), cell(h.im));
            if let Some(coherence) = &set.coherence {
                let _ = write!(text, ",{}", cell(coherence[set.index(line, *a, *b)]));
            }
        }
        text.push('\n');
    }
    text
}

/// Names of the columns of a table with one measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Columns<'a> {
    /// Frequency, Hz.
    pub frequency: &'a str,
    /// Real part.
    pub re: &'a str,
    /// Imaginary part.
    pub im: &'a str,
}

/// Reads a table with one measurement as a function of a universal file, for [`frfs`](crate::data::convert::frfs).
///
/// * `response`, `reference` - nodes and directions, which such a table does not say
/// * `data_types` - specific data types of response and reference, as in dataset 58: 12 and 13 for acceleration over force
///
/// # Errors
/// [`CsvError`] with line and column.
pub fn function(
    bytes: &[u8],
    columns: Columns<'_>,
    response: Entity,
    reference: Entity,
    data_types: [i64; 2],
) -> Result<Function, CsvError> {
    const FRF: i64 = 4;
    const FREQUENCY: i64 = 18;
    let sheet = Sheet::read(bytes)?;
    let [f, re, im] = [columns.frequency, columns.re, columns.im].map(|name| sheet.column(name));
    let (f, re, im) = (f?, re?, im?);
    let mut x = Vec::with_capacity(sheet.rows.len());
    let mut h = Vec::with_capacity(sheet.rows.len());
    // A line whose cells are empty was not measured.
    for row in sheet.rows.iter().filter(|r| !(r.cells[re].is_empty() && r.cells[im].is_empty())) {
        x.push(sheet.number(row, f)?);
        h.push(Complex::new(sheet.number(row, re)?, sheet.number(row, im)?));
    }
    Ok(Function {
        ids: std::array::from_fn(|_| "NONE".to_owned()),
        function_type: FRF,
        function_id: 0,
        version: 0,
        load_case: 0,
        response,
        reference,
        precision: Precision::Double,
        abscissa: Abscissa::Uneven(x),
        ordinate: Ordinate::Complex(h),
        z_value: 0.0,
        axes: [Axis::of(FREQUENCY), Axis::of(data_types[0]), Axis::of(data_types[1]), Axis::of(0)],
        storage: Storage::Ascii,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set() -> FrfSet {
        let channel = |name: &str, direction| Channel { name: name.to_owned(), direction: Some(direction) };
        let n = 4;
        let mut set = FrfSet {
            quantity: FrfQuantity::Mobility,
            frequencies_hz: (0..n).map(|i| 0.1 + f64::from(i) / 3.0).collect(),
            references: vec![channel("1", [0.0, 0.0, 1.0]), channel("9", [0.0, -1.0, 0.0])],
            responses: vec![channel("1", [0.0, 0.0, 1.0]), channel("tip.left", [-1.0, 0.0, 0.0])],
            h: (0..16).map(|i| Complex::new(f64::from(i).sin() * 1.0e-7, 1.0 / f64::from(i + 1))).collect(),
            coherence: Some((0..16).map(|i| 1.0 - f64::from(i) / 31.0).collect()),
            n_averages: None,
        };
        let hole = set.index(2, 1, 1);
        set.h[hole] = Complex::new(5.0, 5.0);
        set
    }

    #[test]
    fn a_written_table_reads_back_bit_for_bit() {
        let text = write_frfs(&set());
        assert!(text.starts_with("frequency_hz,1.+z/1.+z:re,1.+z/1.+z:im,1.+z/1.+z:coh,tip.left.-x/1.+z:re,"));
        let back = read_frfs(text.as_bytes(), &CsvFrfOptions::default()).unwrap();
        assert_eq!(back, set());
        let semicolons = text.replace(',', ";").replace('.', ",").replace(",+", ".+").replace(",-", ".-");
        let semicolons = semicolons.replace("tip,left", "tip.left");
        assert_eq!(read_frfs(semicolons.as_bytes(), &CsvFrfOptions::default()).unwrap(), set());
    }

    #[test]
    fn units_are_converted_or_asked_for() {
        let text = b"frequency_hz,a:re,a:im\n1,2,3\n2,4,5\n";
        let error = read_frfs(text, &CsvFrfOptions::default()).unwrap_err();
        assert!(matches!(&error, CsvError::Convert(ConvertError::Questions(q)) if q[0].option == "unit"), "{error}");
        let options = CsvFrfOptions { unit: Some("g/N".into()), reference: None };
        let set = read_frfs(text, &options).unwrap();
        assert_eq!((set.quantity, set.h[1]), (FrfQuantity::Accelerance, Complex::new(4.0 * 9.80665, 5.0 * 9.80665)));
        assert_eq!(set.references[0].name, "force");
        let contradiction = b"frequency_hz,a:re,a:im\nHz,m/s2/N,m/s2/N\n1,2,3\n";
        assert!(read_frfs(contradiction, &options).is_err());
    }

    #[test]
    fn wrong_tables_are_refused_with_their_place() {
        let read = |text: &str| {
            let options = CsvFrfOptions { unit: Some("m/N".into()), reference: None };
            read_frfs(text.as_bytes(), &options).unwrap_err().to_string()
        };
        assert_eq!(
            read("frequency_hz,a:re,a:im\n1,2,3\n1,2,3\n"),
            "line 3, column 1 (`frequency_hz`): `1` where a frequency above the one before should stand"
        );
        assert_eq!(read("frequency_hz,a\n1,2\n"), "column `a`: its name must end with `:re`, `:im` or `:coh`");
        assert_eq!(
            read("frequency_hz,a:re,a:im\n1,2,3\n2,two,3\n"),
            "line 3, column 2 (`a:re`): `two` where a number should stand"
        );
    }

    #[test]
    fn mutated_files_do_no_harm() {
        let seed: Vec<u8> = write_frfs(&set()).replace("m/s/N", "g/N").into_bytes();
        let options = CsvFrfOptions { unit: Some("g/N".into()), reference: None };
        crate::data::mutate::all(&[seed], 5_000, |bytes| read_frfs(bytes, &options).is_ok());
    }
}
