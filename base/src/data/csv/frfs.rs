//! Frequency response functions in tables.

use super::header::{Part, frequency_column, part_name, radians};
use super::names::{channel, ends, label};
use super::{CsvError, Row, Sheet};
use crate::catalogue::Choice;
use crate::data::convert::{ConvertError, Duplicates, Question, is_too_sparse, ratio_unit};
use crate::data::uff::{Abscissa, Axis, Entity, Function, Ordinate, Precision, Storage};
use crate::data::{Channel, FrfQuantity, FrfSet};
use crate::units::FrequencyUnit;
use retune_linalg::Complex;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// What a table may leave open.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CsvFrfOptions {
    /// The unit of all functions, such as `m/s2/N`; it must not contradict a row of units.
    pub unit: Option<String>,
    /// The reference of columns that name none.
    pub reference: Option<Channel>,
    /// What the functions are; it must not contradict their unit.
    pub quantity: Option<FrfQuantity>,
    /// The unit of frequencies; it counts before what the table says.
    pub frequency_unit: Option<FrequencyUnit>,
    /// What to do with several columns of one function.
    pub duplicates: Duplicates,
}

/// The name of a point that has none.
const UNNAMED_REFERENCE: &str = "force";
/// The name of the response in a table of one function.
const UNNAMED_RESPONSE: &str = "response";

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

/// A column of a function.
struct Column<'a> {
    at: usize,
    part: Part,
    /// Unit in brackets.
    unit: Option<&'a str>,
    reference: usize,
    response: usize,
}

/// Where the frequencies stand, and Hz in one of them.
struct Frequencies {
    column: usize,
    hertz: f64,
}

/// Reads a table of frequency response functions in the layout of this module, and says what was taken for granted.
///
/// # Errors
/// [`CsvError`] with line and column; [`ConvertError::Questions`] inside it if a unit is not stated or a function is there twice,
/// [`ConvertError::Contradiction`] if an option says another quantity than the units.
pub fn read_frfs(bytes: &[u8], options: &CsvFrfOptions) -> Result<(FrfSet, Vec<String>), CsvError> {
    let mut notes = Vec::new();
    let mut sheet = Sheet::read(bytes)?;
    let column = match sheet.names.iter().position(|n| frequency_column(n).is_some()) {
        Some(column) => column,
        None => sheet.column("frequency_hz")?,
    };
    let has_units = sheet.rows.first().is_some_and(|r| sheet.parse(&r.cells[column]).is_none());
    let units = if has_units { Some(sheet.rows.remove(0)) } else { None };
    let hertz = hertz(&sheet, column, units.as_ref(), options, &mut notes)?;
    let frequency = Frequencies { column, hertz };
    let (mut references, mut responses) = (Channels::default(), Channels::default());
    let mut columns: Vec<Column<'_>> = Vec::new();
    for (at, name) in sheet.names.iter().enumerate().filter(|(i, _)| *i != column) {
        let found = part_name(name).ok_or_else(|| CsvError::ColumnName {
            name: name.to_string(),
            expected: "its name must end with `:re`, `:im`, `:amp`, `:phase_deg`, `:phase_rad` or `:coh`",
        })?;
        let (response, reference) = ends(found.pair).ok_or_else(|| CsvError::ColumnName {
            name: name.to_string(),
            expected: "which `/` stands between response and reference? write those in names as `\\x2f`",
        })?;
        let unnamed = |name: &str| Channel { name: name.to_owned(), direction: None };
        let a = match reference {
            Some(text) => references.index_of(text, || channel(text)),
            None => references.index_of("", || options.reference.clone().unwrap_or_else(|| unnamed(UNNAMED_REFERENCE))),
        };
        let make = || if response.is_empty() { unnamed(UNNAMED_RESPONSE) } else { channel(response) };
        let b = responses.index_of(response, make);
        let unit = found.unit.filter(|_| !matches!(found.part, Part::Phase(_)));
        columns.push(Column { at, part: found.part, unit, reference: a, response: b });
    }
    settle_repeated(&sheet, &mut columns, options)?;
    check_partners(&sheet, &columns)?;
    let (quantity, scales) = scales(&sheet, units.as_ref(), &columns, options)?;
    if let Some(wanted) = options.quantity.filter(|q| *q != quantity) {
        return Err(ConvertError::Contradiction {
            option: "quantity",
            wanted: wanted.word().to_owned(),
            said: format!("{} by its units", quantity.word()),
            remedy: "leave the option out, or correct the units in the table".to_owned(),
        }
        .into());
    }
    let mut set = FrfSet {
        quantity,
        frequencies_hz: Vec::with_capacity(sheet.rows.len()),
        references: references.list,
        responses: responses.list,
        h: Vec::new(),
        coherence: None,
        n_averages: None,
    };
    fill(&mut set, &sheet, &frequency, &columns, &scales)?;
    Ok((set, notes))
}

/// Hz in one unit of the frequencies: by the option, the name of their column, or the row of units.
fn hertz(
    sheet: &Sheet<'_>,
    column: usize,
    units: Option<&Row<'_>>,
    options: &CsvFrfOptions,
    notes: &mut Vec<String>,
) -> Result<f64, CsvError> {
    let name = &sheet.names[column];
    let by_name = frequency_column(name).and_then(|f| f.unit);
    let mut said = by_name;
    if let Some(row) = units {
        let text = row.cells[column].as_ref();
        let own = FrequencyUnit::of_label(text);
        let is_same = |a: &FrequencyUnit, b: &FrequencyUnit| (a.hertz / b.hertz - 1.0).abs() < 1e-9;
        let is_other = own.as_ref().zip(said.as_ref()).is_some_and(|(a, b)| !is_same(a, b));
        if !text.is_empty() && (own.is_none() || is_other) && options.frequency_unit.is_none() {
            return Err(CsvError::Cell {
                line: row.line,
                column: column + 1,
                name: name.to_string(),
                text: text.to_owned(),
                expected: if is_other {
                    "the unit of the name"
                } else {
                    "`Hz`, `kHz`, `rad/s`, `rpm` (row of units) or a number"
                },
            });
        }
        said = own.or(said);
    }
    match (&options.frequency_unit, said) {
        (Some(own), said) => {
            if let Some(said) = said.filter(|s| (s.hertz / own.hertz - 1.0).abs() > 1e-9) {
                notes.push(format!(
                    "the table says that its frequencies are in {}; the option says {}, and counts",
                    said.name, own.name
                ));
            }
            Ok(own.hertz)
        }
        (None, Some(said)) => {
            if said.hertz != 1.0 {
                notes.push(format!("frequencies in {} were converted to Hz", said.name));
            }
            Ok(said.hertz)
        }
        (None, None) => Err(ConvertError::Questions(vec![Question {
            option: "frequency-unit",
            text: format!("column `{name}` does not state the unit of its frequencies"),
            answers: FrequencyUnit::NAMES.map(String::from).to_vec(),
        }])
        .into()),
    }
}

/// What kind of part a column is; the two of a pair make a function.
fn kind(part: Part) -> usize {
    match part {
        Part::Re => 0,
        Part::Im => 1,
        Part::Amplitude => 2,
        Part::Phase(_) => 3,
        Part::Coherence => 4,
    }
}

/// Keeps one of several columns of one part of one function, as the option says.
fn settle_repeated(sheet: &Sheet<'_>, columns: &mut Vec<Column<'_>>, options: &CsvFrfOptions) -> Result<(), CsvError> {
    let key = |c: &Column<'_>| (c.reference, c.response, kind(c.part));
    let mut first: BTreeMap<(usize, usize, usize), usize> = BTreeMap::new();
    let mut drop = vec![false; columns.len()];
    for (k, column) in columns.iter().enumerate() {
        let Some(&before) = first.get(&key(column)) else {
            first.insert(key(column), k);
            continue;
        };
        match options.duplicates {
            Duplicates::Ask => {
                return Err(ConvertError::Questions(vec![Question {
                    option: "duplicates",
                    text: format!("the column `{}` is there more than once", sheet.names[column.at]),
                    answers: vec!["first".to_owned(), "last".to_owned()],
                }])
                .into());
            }
            Duplicates::First => drop[k] = true,
            Duplicates::Last => {
                drop[before] = true;
                first.insert(key(column), k);
            }
        }
    }
    let mut k = 0;
    columns.retain(|_| {
        k += 1;
        !drop[k - 1]
    });
    Ok(())
}

/// A real part needs its imaginary part, an amplitude its phase, and one function is given in one way.
fn check_partners(sheet: &Sheet<'_>, columns: &[Column<'_>]) -> Result<(), CsvError> {
    let mut parts: BTreeMap<(usize, usize), [Option<usize>; 5]> = BTreeMap::new();
    for c in columns {
        parts.entry((c.reference, c.response)).or_default()[kind(c.part)] = Some(c.at);
    }
    for own in parts.values() {
        let wrong = |at: Option<usize>, expected| {
            at.map_or(Ok(()), |at| Err(CsvError::ColumnName { name: sheet.names[at].to_string(), expected }))
        };
        match own {
            [Some(_), Some(_), None, None, _] | [None, None, Some(_), Some(_), _] | [None, None, None, None, _] => {}
            [re @ Some(_), None, ..] => wrong(*re, "the column of its imaginary part is missing")?,
            [None, im @ Some(_), ..] => wrong(*im, "the column of its real part is missing")?,
            [_, _, amplitude @ Some(_), None, _] => wrong(*amplitude, "the column of its phase is missing")?,
            [None, None, None, phase @ Some(_), _] => wrong(*phase, "the column of its amplitude is missing")?,
            [_, _, amplitude, phase, _] => {
                wrong(amplitude.or(*phase), "its real and imaginary part are there too; leave one of the two out")?;
            }
        }
    }
    Ok(())
}

fn fill(
    set: &mut FrfSet,
    sheet: &Sheet<'_>,
    frequency: &Frequencies,
    columns: &[Column<'_>],
    scales: &[f64],
) -> Result<(), CsvError> {
    let cells_per_line = set.references.len() * set.responses.len();
    if is_too_sparse(columns.len(), cells_per_line, sheet.rows.len()) {
        let (references, responses) = (set.references.len(), set.responses.len());
        return Err(ConvertError::TooSparse { measured: columns.len() / 2, references, responses }.into());
    }
    let has_coherence = columns.iter().any(|c| c.part == Part::Coherence);
    let mut coherence = Vec::new();
    for (line, row) in sheet.rows.iter().enumerate() {
        let f = sheet.number(row, frequency.column)? * frequency.hertz;
        if !f.is_finite() || set.frequencies_hz.last().is_some_and(|last| f <= *last) {
            return Err(CsvError::Cell {
                line: row.line,
                column: frequency.column + 1,
                name: sheet.names[frequency.column].to_string(),
                text: row.cells[frequency.column].to_string(),
                expected: "a frequency above the one before",
            });
        }
        set.frequencies_hz.push(f);
        set.h.resize(set.h.len() + cells_per_line, Complex::new(f64::NAN, f64::NAN));
        if has_coherence {
            coherence.resize(set.h.len(), f64::NAN);
        }
        // Amplitude and phase stand as real and imaginary part until both are there.
        for (column, scale) in columns.iter().zip(scales) {
            // An empty cell is a value that was not measured.
            let value = if row.cells[column.at].is_empty() { f64::NAN } else { sheet.number(row, column.at)? };
            let cell = set.index(line, column.reference, column.response);
            match column.part {
                Part::Re | Part::Amplitude => set.h[cell].re = value * scale,
                Part::Im | Part::Phase(_) => set.h[cell].im = value * scale,
                Part::Coherence => coherence[cell] = value,
            }
        }
        for column in columns.iter().filter(|c| c.part == Part::Amplitude) {
            let cell = set.index(line, column.reference, column.response);
            let Complex { re: amplitude, im: phase } = set.h[cell];
            set.h[cell] = Complex::new(amplitude * phase.cos(), amplitude * phase.sin());
        }
    }
    set.coherence = has_coherence.then_some(coherence);
    Ok(())
}

/// The quantity of all functions and the SI value of one unit in each column.
fn scales(
    sheet: &Sheet<'_>,
    units: Option<&Row<'_>>,
    columns: &[Column<'_>],
    options: &CsvFrfOptions,
) -> Result<(FrfQuantity, Vec<f64>), CsvError> {
    let mut quantity = None;
    let mut scales = Vec::with_capacity(columns.len());
    for column in columns {
        let name = &sheet.names[column.at];
        let in_row = units.map(|r| r.cells[column.at].as_ref()).filter(|u| !u.is_empty());
        if column.part == Part::Coherence {
            scales.push(1.0);
            continue;
        }
        if let Part::Phase(by_name) = column.part {
            let scale = by_name.or(in_row.and_then(radians)).ok_or_else(|| CsvError::ColumnName {
                name: name.to_string(),
                expected: "the unit of a phase must be stated: `:phase_deg` or `:phase_rad`, or `deg` or `rad` in the row of units",
            })?;
            scales.push(scale);
            continue;
        }
        let own = in_row.or(column.unit);
        let label = match (own, options.unit.as_deref()) {
            (Some(own), Some(stated)) if ratio_unit(own) != ratio_unit(stated) => {
                return Err(ask(format!("column `{name}` has the unit `{own}`, the option says `{stated}`")));
            }
            (Some(label), _) | (None, Some(label)) => label,
            (None, None) => return Err(ask("the table does not state the unit of its functions".to_owned())),
        };
        let Some((q, response, force)) = ratio_unit(label) else {
            return Err(ask(format!("`{label}` is not understood as a unit of response over force")));
        };
        if quantity.is_some_and(|known| known != q) {
            return Err(CsvError::ColumnName {
                name: name.to_string(),
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
        let pair = format!("{}/{}", label(&set.responses[*b]), label(&set.references[*a]));
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
        let (back, notes) = read_frfs(text.as_bytes(), &CsvFrfOptions::default()).unwrap();
        assert_eq!(back, set());
        assert!(notes.is_empty(), "{notes:?}");
        let semicolons = text.replace(',', ";").replace('.', ",").replace(",+", ".+").replace(",-", ".-");
        let semicolons = semicolons.replace("tip,left", "tip.left");
        assert_eq!(read_frfs(semicolons.as_bytes(), &CsvFrfOptions::default()).unwrap().0, set());
    }

    #[test]
    fn names_of_any_kind_read_back_as_written() {
        let names = [
            "blade.1/1",
            "a,b;\"c\"",
            "two\nlines\r\t",
            " edge ",
            "back\\slash\\x2f",
            "left.x",
            "a.+z",
            "μ/é",
            "[g/N] re:im",
        ];
        for (i, name) in names.iter().enumerate() {
            for direction in [None, Some([0.0, 0.0, -1.0]), Some([0.6, 0.0, 0.8])] {
                let mut set = set();
                set.responses[1] = Channel { name: (*name).to_string(), direction };
                set.references[0] = Channel { name: names[(i + 1) % names.len()].to_string(), direction: None };
                let (back, _) = read_frfs(write_frfs(&set).as_bytes(), &CsvFrfOptions::default()).unwrap();
                let axis = direction.filter(|d| d[0] == 0.0);
                assert_eq!(back.responses[1], Channel { direction: axis, ..set.responses[1].clone() }, "{name:?}");
                assert_eq!((&back.references, &back.h[3]), (&set.references, &set.h[3]), "{name:?}");
            }
        }
        // Names that are not escaped, of inner nodes as people write them.
        let text = "frequency_hz,blade.1/1.+z/blade.1/2.-z:re,blade.1/1.+z/blade.1/2.-z:im\n1,2,3\n";
        let options = CsvFrfOptions { unit: Some("m/N".into()), ..CsvFrfOptions::default() };
        let (set, _) = read_frfs(text.as_bytes(), &options).unwrap();
        assert_eq!((set.responses[0].name.as_str(), set.references[0].name.as_str()), ("blade.1/1", "blade.1/2"));
        let error = read_frfs(b"frequency_hz,a/b/c:re,a/b/c:im\n1,2,3\n", &options).unwrap_err();
        assert!(error.to_string().contains("which `/` stands between"), "{error}");
    }

    #[test]
    fn units_are_converted_or_asked_for() {
        let text = b"frequency_hz,a:re,a:im\n1,2,3\n2,4,5\n";
        let error = read_frfs(text, &CsvFrfOptions::default()).unwrap_err();
        assert!(matches!(&error, CsvError::Convert(ConvertError::Questions(q)) if q[0].option == "unit"), "{error}");
        let options = CsvFrfOptions { unit: Some("g/N".into()), ..CsvFrfOptions::default() };
        let (set, _) = read_frfs(text, &options).unwrap();
        assert_eq!((set.quantity, set.h[1]), (FrfQuantity::Accelerance, Complex::new(4.0 * 9.80665, 5.0 * 9.80665)));
        assert_eq!(set.references[0].name, "force");
        let contradiction = b"frequency_hz,a:re,a:im\nHz,m/s2/N,m/s2/N\n1,2,3\n";
        assert!(read_frfs(contradiction, &options).is_err());
    }

    #[test]
    fn wrong_tables_are_refused_with_their_place() {
        let read = |text: &str| {
            let options = CsvFrfOptions { unit: Some("m/N".into()), ..CsvFrfOptions::default() };
            read_frfs(text.as_bytes(), &options).unwrap_err().to_string()
        };
        assert_eq!(
            read("frequency_hz,a:re,a:im\n1,2,3\n1,2,3\n"),
            "line 3, column 1 (`frequency_hz`): `1` where a frequency above the one before should stand"
        );
        assert_eq!(
            read("frequency_hz,a\n1,2\n"),
            "column `a`: its name must end with `:re`, `:im`, `:amp`, `:phase_deg`, `:phase_rad` or `:coh`"
        );
        assert_eq!(
            read("frequency_hz,a:re,a:im\n1,2,3\n2,two,3\n"),
            "line 3, column 2 (`a:re`): `two` where a number should stand"
        );
    }

    #[test]
    fn amplitude_and_phase_make_a_function() {
        let read = |text: &str| read_frfs(text.as_bytes(), &CsvFrfOptions::default()).map(|(set, _)| set);
        let set = read("frequency_hz,a.+z/a.+z:amp,a.+z/a.+z:phase_deg\nHz,mm/s2/N,\n1,2000,90\n2,1000,-180\n3,,5\n")
            .unwrap();
        assert!((set.at(0, 0, 0) - Complex::new(0.0, 2.0)).norm() < 1e-15);
        assert!((set.at(1, 0, 0) - Complex::new(-1.0, 0.0)).norm() < 1e-15);
        assert!(set.at(2, 0, 0).re.is_nan());
        let other = read("Frequency [Hz];Amplitude [m/s2/N];Phase [rad]\n1,5;2,0;1,5707963267948966\n").unwrap();
        assert!((other.at(0, 0, 0) - Complex::new(0.0, 2.0)).norm() < 1e-15);
        assert_eq!((other.frequencies_hz[0], other.responses[0].name.as_str()), (1.5, "response"));
        let row = read("f,p:amp,p:phase\nrad/s,m/N,deg\n6.283185307179586,1,180\n").unwrap();
        assert!((row.at(0, 0, 0).re + 1.0).abs() < 1e-15 && (row.frequencies_hz[0] - 1.0).abs() < 1e-15);
        for (text, why) in [
            ("frequency_hz,p:amp,p:phase\nHz,m/N,\n1,1,2\n", "unit of a phase must be stated"),
            ("frequency_hz,p:amp\nHz,m/N\n1,1\n", "phase is missing"),
            ("frequency_hz,p:re\nHz,m/N\n1,1\n", "imaginary part is missing"),
            ("frequency_hz,p:re,p:im,p:amp,p:phase_rad\nHz,m/N,m/N,m/N,rad\n1,1,1,1,1\n", "leave one of the two out"),
            ("frequency,p:re,p:im\n,m/N,m/N\n1,1,1\n", "frequency-unit"),
            ("frequency_hz,p:re,p:im\nrad/s,m/N,m/N\n1,1,1\n", "the unit of the name"),
            ("frequency_hz,p:re,p:im,p:re\nHz,m/N,m/N,m/N\n1,1,1,2\n", "duplicates"),
        ] {
            let error = read(text).unwrap_err().to_string();
            assert!(error.contains(why), "{text}: {error}");
        }
    }

    #[test]
    fn options_settle_what_is_there_twice_or_refuse_what_contradicts() {
        let text = b"frequency_hz,p:re,p:im,p:re\nHz,m/N,m/N,m/N\n1,1,1,2\n";
        let read = |options: CsvFrfOptions| read_frfs(text, &options);
        for (duplicates, value) in [(Duplicates::First, 1.0), (Duplicates::Last, 2.0)] {
            let (set, _) = read(CsvFrfOptions { duplicates, ..CsvFrfOptions::default() }).unwrap();
            assert_eq!(set.h[0].re, value);
        }
        let quantity = Some(FrfQuantity::Mobility);
        let error =
            read(CsvFrfOptions { quantity, duplicates: Duplicates::First, ..CsvFrfOptions::default() }).unwrap_err();
        assert_eq!(
            error.to_string(),
            "the option `quantity` says mobility, but the file says receptance by its units; leave the option out, or correct the units in the table"
        );
        let rad = FrequencyUnit::of_label("rad/s");
        let own = CsvFrfOptions { frequency_unit: rad, duplicates: Duplicates::First, ..CsvFrfOptions::default() };
        let (set, notes) = read(own).unwrap();
        assert!((set.frequencies_hz[0] * std::f64::consts::TAU - 1.0).abs() < 1e-15);
        assert!(notes[0].contains("the option says rad/s"), "{notes:?}");
    }

    #[test]
    fn mutated_files_do_no_harm() {
        let polar = "sep=;\nFrequency [rad/s];1+z/1+z phase [deg];1+z/1+z amp [g/N];2 coh;2 phase_rad;2 mag [g/N];\n1,5;2;3,5;0,9;1;2;\n";
        let wide: Vec<u8> = [0xff, 0xfe].into_iter().chain(polar.encode_utf16().flat_map(u16::to_le_bytes)).collect();
        let seeds = [write_frfs(&set()).replace("m/s/N", "g/N").into_bytes(), polar.as_bytes().to_vec(), wide];
        let options = CsvFrfOptions { unit: Some("g/N".into()), ..CsvFrfOptions::default() };
        for seed in seeds {
            crate::data::mutate::all(&[seed], 3_000, |bytes| read_frfs(bytes, &options).is_ok());
        }
    }
}
