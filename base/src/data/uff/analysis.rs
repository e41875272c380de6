//! Datasets 55 and 2414: shapes and other results.

use super::cursor::{Cursor, Fault, is_label};
use super::note::Level;
use super::sink::Sink;

/// Values at one node, or for dataset 2414 at one element.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Label of the node or element, then the further integers of its record (dataset 2414, locations 2, 3, 5).
    pub head: Vec<i64>,
    /// Its values; complex ones as real and imaginary part in turn.
    pub values: Vec<f64>,
}

/// Dataset 55: data at nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct DataAtNodes {
    /// ID lines 1-5, without the blanks around them.
    pub ids: [String; 5],
    /// 0 unknown, 1 structural, 2 heat transfer, 3 fluid flow.
    pub model_type: i64,
    /// 0 unknown, 1 static, 2 normal mode, 3 complex mode of first order, 4 transient, 5 frequency response, 6
    /// buckling, 7 complex mode of second order.
    pub analysis_type: i64,
    /// 1 scalar, 2 three translations, 3 three translations and three rotations, ...
    pub characteristic: i64,
    /// 8 displacement, 11 velocity, 12 acceleration, ...
    pub specific_type: i64,
    /// 2 real, 5 complex.
    pub data_type: i64,
    /// Data values per node; a complex one counts once.
    pub values_per_node: i64,
    /// Integers of the analysis type: load case, mode number, ...
    pub integers: Vec<i64>,
    /// Reals of the analysis type; normal mode: frequency in Hz, modal mass, viscous and hysteretic damping ratio;
    /// complex mode: eigenvalue in rad/s, modal A, modal B, real and imaginary part each.
    pub reals: Vec<f64>,
    /// Values.
    pub entries: Vec<Entry>,
}

fn numbers_per_value(data_type: i64) -> usize {
    if matches!(data_type, 5 | 6) { 2 } else { 1 }
}

pub(super) fn read_55(cursor: &mut Cursor<'_, '_>) -> Result<DataAtNodes, Fault> {
    let ids = cursor.ids();
    let d = cursor.numbers(&[10; 6], "the definition of the data (record 6)")?;
    let values_per_node = d.int(5);
    let width = usize::try_from(values_per_node).unwrap_or(0).saturating_mul(numbers_per_value(d.int(4)));
    if width == 0 {
        return Err(cursor.fault(format!("{values_per_node} data values per node")));
    }
    if !matches!(d.int(4), 2 | 4 | 5 | 6) {
        cursor.note(Level::Warning, format!("data type {}", d.int(4)), "read as real");
    }
    let head = cursor.numbers(&[10; 8], "the numbers of parameters (record 7)")?;
    let n_integers = usize::try_from(head.int(0)).unwrap_or(0);
    let n_reals = usize::try_from(head.int(1)).unwrap_or(0);
    let mut integers: Vec<i64> = (2..8.min(2 + n_integers)).map(|i| head.int(i)).collect();
    if n_integers > 6 {
        integers.extend(cursor.ints(n_integers - 6)?);
    }
    let mut reals = Vec::new();
    cursor.floats(n_reals, &[13; 6], is_label, &mut reals)?;
    if reals.len() < n_reals {
        let seen = format!("{n_reals} real parameters announced, {} present", reals.len());
        cursor.note(Level::Warning, seen, "those present were read");
    }
    let (entries, data_type) = read_entries(cursor, &[10], d.int(4), |_| Some(width))?;
    Ok(DataAtNodes {
        ids,
        model_type: d.int(0),
        analysis_type: d.int(1),
        characteristic: d.int(2),
        specific_type: d.int(3),
        data_type,
        values_per_node,
        integers,
        reals,
        entries,
    })
}

/// Reads labels and their values in turn; `width` tells the number of reals after a head.
///
/// Gives the type of the data too: where every label has half of the reals that complex values need, they are real.
fn read_entries(
    cursor: &mut Cursor<'_, '_>,
    columns: &[usize],
    data_type: i64,
    width: impl Fn(&[i64]) -> Option<usize>,
) -> Result<(Vec<Entry>, i64), Fault> {
    let mut entries = Vec::new();
    let mut halves: Vec<i64> = Vec::new();
    // One integer alone on a line is the next label, unless a single value per node may look the same.
    let stop: fn(&str) -> bool = if columns.len() == 1 { is_label } else { super::cursor::never };
    while let Some(text) = cursor.filled_record() {
        let n = cursor.split(&text, columns, "a label")?;
        let head: Vec<i64> = (0..columns.len()).map(|i| n.int(i)).collect();
        let Some(count) = width(&head) else {
            return Err(cursor.fault(format!("a head {head:?} that announces no values")));
        };
        let mut values = Vec::new();
        cursor.floats(count, &[13; 6], stop, &mut values)?;
        if numbers_per_value(data_type) == 2 && 2 * values.len() == count {
            halves.push(head[0]);
        } else if values.len() < count {
            let seen = format!("{} of {count} values at label {}", values.len(), head[0]);
            cursor.note(Level::Warning, seen, "the values present were kept");
        }
        entries.push(Entry { head, values });
    }
    if halves.is_empty() || halves.len() < entries.len() {
        for label in halves {
            let seen = format!("half of the reals of complex values at label {label}");
            cursor.note(Level::Warning, seen, "the values present were kept");
        }
        return Ok((entries, data_type));
    }
    let seen = format!("data type {data_type} (complex), and half as many reals as that needs at every label");
    cursor.note(Level::Warning, seen, "read as real");
    // 5 and 6 are complex of single and double precision, 2 and 4 real.
    Ok((entries, if data_type == 6 { 4 } else { 2 }))
}

fn write_entries(entries: &[Entry], sink: &mut Sink) {
    for entry in entries {
        sink.int_lines(&entry.head);
        sink.float_lines(&entry.values, &[13; 6]);
    }
}

pub(super) fn write_55(data: &DataAtNodes, sink: &mut Sink) {
    sink.begin(55);
    sink.texts(&data.ids);
    sink.int_lines(&[
        data.model_type,
        data.analysis_type,
        data.characteristic,
        data.specific_type,
        data.data_type,
        data.values_per_node,
    ]);
    let mut head = vec![data.integers.len() as i64, data.reals.len() as i64];
    head.extend(&data.integers);
    sink.int_lines(&head);
    sink.float_lines(&data.reals, &[13; 6]);
    write_entries(&data.entries, sink);
    sink.end();
}

/// Dataset 2414: analysis data.
#[derive(Debug, Clone, PartialEq)]
pub struct AnalysisData {
    /// Label of the dataset.
    pub label: i64,
    /// Its name.
    pub name: String,
    /// 1 at nodes, 2 on elements, 3 at nodes on elements, 5 at points.
    pub location: i64,
    /// ID lines 1-5, without the blanks around them.
    pub ids: [String; 5],
    /// 0 unknown, 1 structural, 2 heat transfer, 3 fluid flow.
    pub model_type: i64,
    /// As in dataset 55; 9 static, non-linear.
    pub analysis_type: i64,
    /// 1 scalar, 2 three translations, 3 three translations and three rotations, ...
    pub characteristic: i64,
    /// 8 displacement, 11 velocity, 12 acceleration, ...
    pub result_type: i64,
    /// 1 integer, 2 and 4 real, 5 and 6 complex, of single and double precision.
    pub data_type: i64,
    /// Data values per component; a complex one counts once.
    pub values_per_component: i64,
    /// Records 10 and 11: design set, iteration, solution set, boundary condition, load set, mode number, time step,
    /// frequency number; creation option, number retained.
    pub integers: Vec<i64>,
    /// Records 12 and 13: time, frequency, eigenvalue, modal mass, viscous and hysteretic damping; eigenvalue, modal A
    /// or mass, modal B or stiffness, real and imaginary part each.
    pub reals: [f64; 12],
    /// Values.
    pub entries: Vec<Entry>,
}

/// Least number of integers in records 10 and 11.
const INTEGERS_2414: usize = 10;

pub(super) fn read_2414(cursor: &mut Cursor<'_, '_>) -> Result<AnalysisData, Fault> {
    let label = cursor.numbers(&[10], "the label of the dataset")?.int(0);
    let name = cursor.text();
    let location = cursor.numbers(&[10], "the location of the data")?.int(0);
    let ids = cursor.ids();
    let d = cursor.numbers(&[10; 6], "the definition of the data (record 9)")?;
    let first = cursor.numbers(&[10; 8], "the integers of the analysis (record 10)")?;
    let second = cursor.numbers(&[10; 8], "the integers of the analysis (record 11)")?;
    let mut integers: Vec<i64> = (0..8).map(|i| first.int(i)).collect();
    integers.extend((0..second.filled().max(INTEGERS_2414 - 8)).map(|i| second.int(i)));
    let mut reals = [0.0; 12];
    for (half, record) in [(0, "record 12"), (6, "record 13")] {
        let n = cursor.numbers(&[13; 6], &format!("the reals of the analysis ({record})"))?;
        for i in 0..6 {
            reals[half + i] = n.float(i);
        }
    }
    let per_value = numbers_per_value(d.int(4));
    let width = move |values: i64| usize::try_from(values).ok()?.checked_mul(per_value).filter(|n| *n > 0);
    let per_component = d.int(5);
    let data_type = d.int(4);
    let (entries, data_type) = match location {
        1 => read_entries(cursor, &[10], data_type, |_| width(per_component))?,
        2 => read_entries(cursor, &[10; 2], data_type, |head| width(head[1]))?,
        3 | 5 => {
            let columns: &[usize] = if location == 3 { &[10; 4] } else { &[10; 5] };
            read_entries(cursor, columns, data_type, |head| {
                let locations = if head[1] == 1 { head[2] } else { 1 };
                width(head[3].checked_mul(locations)?)
            })?
        }
        other => return Err(cursor.fault(format!("data location {other}, known are 1, 2, 3 and 5"))),
    };
    Ok(AnalysisData {
        label,
        name,
        location,
        ids,
        model_type: d.int(0),
        analysis_type: d.int(1),
        characteristic: d.int(2),
        result_type: d.int(3),
        data_type,
        values_per_component: per_component,
        integers,
        reals,
        entries,
    })
}

pub(super) fn write_2414(data: &AnalysisData, sink: &mut Sink) {
    sink.begin(2414);
    sink.int_lines(&[data.label]);
    sink.text(&data.name);
    sink.int_lines(&[data.location]);
    sink.texts(&data.ids);
    sink.int_lines(&[
        data.model_type,
        data.analysis_type,
        data.characteristic,
        data.result_type,
        data.data_type,
        data.values_per_component,
    ]);
    let mut integers = data.integers.clone();
    integers.resize(integers.len().clamp(INTEGERS_2414, 16), 0);
    sink.int_lines(&integers);
    sink.float_lines(&data.reals, &[13; 6]);
    write_entries(&data.entries, sink);
    sink.end();
}
