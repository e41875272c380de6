//! Bulk data of Nastran: matrices on `DMIG` cards (KAAX, MAAX and the like, of EXTSEOUT and DMIG(PUNCH)), positions on `GRID` cards.
//!
//! ```text
//! DMIG    KAAX           0       6       2       0                      15      head: form 6 symmetric, type 2 double
//! DMIG*   KAAX                         101               1                      column: grid point, component
//! *                    101               1 1.556000000D+02                      row: grid point, component, value
//! ```
//!
//! Cards in fields of 8 or 16 columns or separated by commas. Component 0 is a scalar point: a modal coordinate. Of a symmetric matrix either
//! triangle is given. Positions and directions of `GRID` cards in other coordinate systems (CORD2R, CORD2C, CORD2S) are turned into the basic one.
//!
//! Source: MSC.Nastran Quick Reference Guide, DMIG, GRID, EXTSEOUT.

use super::coordinate_systems::{self, BASIC, Kind, Systems};
use super::matrix::{Numbered, dof};
use super::text::{Lines, columns, number};
use super::{Contents, Entry, File, Label, Matrix, MatrixError, MatrixReader};
use std::collections::HashMap;
use std::fmt::Write as _;

/// DMIG and GRID.
#[derive(Debug, Clone, Copy)]
pub struct BulkData;

const FORMAT: &str = "bulk data";

impl MatrixReader for BulkData {
    fn name(&self) -> &'static str {
        "bulk-data"
    }

    fn summary(&self) -> &'static str {
        "Bulk data of Nastran (.pch, .bdf, .dat): DMIG matrices with their dofs (KAAX, MAAX, KAA, ...), positions of GRID cards."
    }

    fn recognises(&self, file: &File<'_>) -> bool {
        let is_deck = matches!(file.extension().as_str(), "bdf" | "dat" | "pch" | "nas" | "asm");
        let begins = |line: &str| {
            let upper = line.to_uppercase();
            ["DMIG", "GRID"]
                .iter()
                .any(|card| upper.strip_prefix(card).is_some_and(|r| r.starts_with([' ', ',', '*', '\t'])))
        };
        let head = file.head();
        head.lines().any(begins)
            || is_deck && head.lines().any(|l| l.starts_with('$') || l.to_uppercase().starts_with("BEGIN"))
    }

    fn read(&self, file: &File<'_>) -> Result<Contents, MatrixError> {
        let mut lines = Lines::new(file.bytes);
        let mut cards = Cards { lines: &mut lines, waiting: None };
        let mut contents = Contents::default();
        let mut growing: Vec<Growing> = Vec::new();
        let mut index: HashMap<String, usize> = HashMap::new();
        let (mut systems, mut grids) = (Systems::default(), Vec::new());
        while let Some(card) = cards.next() {
            match card.name.as_str() {
                "DMIG" => dmig(&card, &mut growing, &mut index)?,
                "GRID" => grids.push(Grid::of(&card)?),
                "CORD2R" | "CORD2C" | "CORD2S" => system(&card, &mut systems)?,
                _ => {}
            }
        }
        let mut unknown = 0;
        for grid in grids {
            unknown += usize::from(grid.place(&systems, &mut contents).is_none());
        }
        if unknown > 0 {
            contents.notes.push(format!(
                "{unknown} GRID cards refer to a coordinate system that no CORD2R, CORD2C or CORD2S card of the file gives; they are left out"
            ));
        }
        for g in growing {
            g.finish(&mut contents)?;
        }
        if contents.matrices.is_empty() && contents.positions.is_empty() {
            if let Some(note) = contents.notes.first() {
                return Err(MatrixError::broken(FORMAT, note));
            }
            return Err(MatrixError::broken(FORMAT, "it has no DMIG card with entries and no GRID card"));
        }
        Ok(contents)
    }
}

/// A card with its fields, the name not among them.
struct Card {
    name: String,
    fields: Vec<String>,
    line: usize,
    text: String,
}

impl Card {
    fn field(&self, i: usize) -> &str {
        self.fields.get(i).map_or("", |f| f.trim())
    }

    fn wrong(&self, expected: &'static str) -> MatrixError {
        MatrixError::line(FORMAT, self.line, &self.text, expected)
    }

    fn whole(&self, i: usize) -> Option<i64> {
        self.field(i).parse().ok()
    }
}

/// Cards put together from their lines.
struct Cards<'a, 'b> {
    lines: &'a mut Lines<'b>,
    waiting: Option<(usize, &'b str)>,
}

/// Fields of a line beside its first, and whether the line is in wide fields.
fn split(line: &str) -> (String, Vec<String>, bool) {
    let line = line.split('$').next().unwrap_or_default();
    if line.contains(',') {
        let mut words = line.split(',').map(|w| w.trim().to_string());
        let name = words.next().unwrap_or_default();
        let is_wide = name.ends_with('*');
        let mut fields: Vec<String> = words.collect();
        fields.resize(if is_wide { 4 } else { 8 }, String::new());
        return (name, fields, is_wide);
    }
    let line: String = if line.contains('\t') { line.replace('\t', "        ") } else { line.to_string() };
    let name = columns(&line, 0, 8).trim().to_string();
    let is_wide = name.contains('*');
    let (n, width) = if is_wide { (4, 16) } else { (8, 8) };
    let fields = (0..n).map(|k| columns(&line, 8 + k * width, 8 + (k + 1) * width).trim().to_string()).collect();
    (name, fields, is_wide)
}

impl Cards<'_, '_> {
    fn line(&mut self) -> Option<(usize, String)> {
        if let Some((number, line)) = self.waiting.take() {
            return Some((number, line.to_string()));
        }
        self.lines.next().map(|l| (self.lines.number, l.to_string()))
    }

    fn next(&mut self) -> Option<Card> {
        let (line, text) = loop {
            let (number, line) = self.line()?;
            if !line.trim().is_empty() && !line.trim_start().starts_with('$') && line.is_ascii() {
                break (number, line);
            }
        };
        let (name, mut fields, _) = split(&text);
        // Lines that go on begin with `*`, `+`, or a blank first field.
        while let Some(next) = self.lines.next() {
            if next.trim_start().starts_with('$') || next.trim().is_empty() {
                continue;
            }
            let goes_on = next.is_ascii() && next.starts_with(['*', '+', ' ', ',', '\t']);
            if !goes_on {
                self.waiting = Some((self.lines.number, next));
                break;
            }
            fields.extend(split(next).1);
        }
        let name = name.trim_end_matches('*').trim().to_uppercase();
        Some(Card { name, fields, line, text })
    }
}

/// What a DMIG matrix is: of square ones rows and columns are the same dofs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    Square,
    Symmetric,
    Rectangular,
}

/// A DMIG matrix that is being read.
struct Growing {
    name: String,
    form: Form,
    is_complex: bool,
    rows: Numbered,
    columns: Numbered,
    /// Row, column, value.
    entries: Vec<(usize, usize, f64)>,
    has_imaginary: bool,
    n_columns: usize,
}

fn label(point: &str, component: &str) -> Option<Label> {
    let is_number = !point.is_empty() && point.len() < 19 && point.bytes().all(|b| b.is_ascii_digit());
    let direction = match component {
        "" | "0" => None,
        other => Some(dof(other).filter(|_| other.len() == 1)?),
    };
    is_number.then(|| Label { node: point.to_string(), dof: direction })
}

fn dmig(card: &Card, growing: &mut Vec<Growing>, index: &mut HashMap<String, usize>) -> Result<(), MatrixError> {
    let name = card.field(0).to_string();
    if name.is_empty() || name.eq_ignore_ascii_case("UACCEL") {
        return Ok(());
    }
    if card.field(1) == "0" && !index.contains_key(&name) {
        let form = card.whole(2).filter(|f| [1, 2, 6, 9].contains(f));
        let kind = card.whole(3).filter(|k| (1..=4).contains(k));
        let (Some(form), Some(kind)) = (form, kind) else {
            return Err(card.wrong("`DMIG name 0 form type` with a form of 1, 2, 6 or 9 and a type of 1 to 4"));
        };
        index.insert(name.clone(), growing.len());
        growing.push(Growing {
            name,
            form: match form {
                6 => Form::Symmetric,
                1 => Form::Square,
                _ => Form::Rectangular,
            },
            is_complex: kind > 2,
            rows: Numbered::default(),
            columns: Numbered::default(),
            entries: Vec::new(),
            has_imaginary: false,
            n_columns: card.whole(7).and_then(|n| usize::try_from(n).ok()).filter(|n| *n < 1 << 31).unwrap_or(0),
        });
        return Ok(());
    }
    let Some(g) = index.get(&name).map(|&i| &mut growing[i]) else {
        return Err(card.wrong("the head `DMIG name 0 form type` of this matrix before its columns"));
    };
    let column = label(card.field(1), card.field(2)).ok_or_else(|| card.wrong("a column: grid point and component"))?;
    let column = if g.form == Form::Rectangular { g.columns.index(column) } else { g.rows.index(column) };
    // Rows stand in the second half of the first line, and four fields each from then on.
    for k in (4..card.fields.len()).step_by(4) {
        if [0, 1, 2, 3].iter().all(|i| card.field(k + i).is_empty()) {
            continue;
        }
        let row = label(card.field(k), card.field(k + 1));
        let value = number(card.field(k + 2));
        let (Some(row), Some(value)) = (row, value) else {
            return Err(card.wrong("rows of this column: grid point, component, value"));
        };
        g.has_imaginary |= g.is_complex && number(card.field(k + 3)).is_some_and(|v| v != 0.0);
        let row = g.rows.index(row);
        g.entries.push((row, column, value));
    }
    Ok(())
}

impl Growing {
    fn finish(self, contents: &mut Contents) -> Result<(), MatrixError> {
        if self.has_imaginary {
            contents.notes.push(format!("`{}` is complex and is left out: matrices of a model are real", self.name));
            return Ok(());
        }
        if self.form != Form::Rectangular {
            return self.square(contents);
        }
        let mut matrix = Matrix {
            name: self.name,
            n_rows: self.rows.labels.len(),
            n_columns: self.columns.labels.len().max(self.n_columns),
            rows: self.rows.labels,
            columns: self.columns.labels,
            ..Matrix::default()
        };
        for (row, column, value) in self.entries {
            matrix.push(row, column, value);
        }
        contents.matrices.push(matrix);
        Ok(())
    }

    /// In the order of points and components.
    fn square(self, contents: &mut Contents) -> Result<(), MatrixError> {
        let labels = self.rows.labels;
        let mut order: Vec<usize> = (0..labels.len()).collect();
        order.sort_by_key(|&i| (labels[i].node.parse::<u64>().unwrap_or(u64::MAX), labels[i].dof));
        let mut place = vec![0; labels.len()];
        order.iter().enumerate().for_each(|(to, &from)| place[from] = to);
        let mut matrix = Matrix {
            name: self.name,
            n_rows: labels.len(),
            n_columns: labels.len(),
            rows: order.iter().map(|&i| labels[i].clone()).collect(),
            ..Matrix::default()
        };
        let mut seen: HashMap<(usize, usize), f64> = HashMap::new();
        for (row, column, value) in self.entries {
            let (row, column) = (place[row], place[column]);
            if self.form == Form::Symmetric {
                // Both halves may be given, with the same numbers.
                let key = (row.max(column), row.min(column));
                if let Some(before) = seen.insert(key, value) {
                    if before != value {
                        let (a, b) = (&matrix.rows[row], &matrix.rows[column]);
                        return Err(MatrixError::broken(
                            FORMAT,
                            format_args!(
                                "`{}` is symmetric (form 6) and has two values between {a} and {b}",
                                matrix.name
                            ),
                        ));
                    }
                    continue;
                }
            }
            matrix.push(row, column, value);
        }
        matrix.is_one_triangle = self.form == Form::Symmetric;
        contents.matrices.push(matrix);
        Ok(())
    }
}

/// A GRID card.
struct Grid {
    name: String,
    system: i64,
    at: [f64; 3],
    /// System of its displacements.
    output: i64,
}

impl Grid {
    fn of(card: &Card) -> Result<Self, MatrixError> {
        let number = |i: usize| if card.field(i).is_empty() { Some(0.0) } else { number(card.field(i)) };
        let system = |i: usize| if card.field(i).is_empty() { Some(0) } else { card.whole(i) };
        let (Some(point), Some(x), Some(y), Some(z)) = (label(card.field(0), "0"), number(2), number(3), number(4))
        else {
            return Err(card.wrong("`GRID point system x y z system`"));
        };
        let (Some(own), Some(output)) = (system(1), system(5)) else {
            return Err(card.wrong("`GRID point system x y z system`"));
        };
        // A fluid point has a pressure and no directions.
        Ok(Self { name: point.node, system: own, at: [x, y, z], output: output.max(0) })
    }

    fn place(self, systems: &Systems, contents: &mut Contents) -> Option<()> {
        let at = systems.place(self.system, self.at)?;
        let axes = systems.axes(self.output, at)?;
        if axes != BASIC {
            contents.axes.push((self.name.clone(), axes));
        }
        contents.positions.push((self.name, at));
        Some(())
    }
}

/// A coordinate system.
fn system(card: &Card, systems: &mut Systems) -> Result<(), MatrixError> {
    let at = |i: usize| if card.field(i).is_empty() { Some(0.0) } else { number(card.field(i)) };
    let all: Option<Vec<f64>> = (2..11).map(at).collect();
    let reference = if card.field(1).is_empty() { Some(0) } else { card.whole(1) };
    let (Some(number), Some(reference), Some(v)) = (card.whole(0), reference, all) else {
        return Err(card.wrong("a coordinate system: number, reference, and three points"));
    };
    let kind = match card.name.as_str() {
        "CORD2R" => Kind::Rectangular,
        "CORD2C" => Kind::Cylindrical,
        _ => Kind::Spherical,
    };
    let points = [[v[0], v[1], v[2]], [v[3], v[4], v[5]], [v[6], v[7], v[8]]];
    systems.add(number, coordinate_systems::Card { kind, reference, points });
    Ok(())
}

/// Writes matrices as DMIG cards in wide fields with their dofs, and the positions of the points as GRID cards.
///
/// Numbers have ten digits, as many as a field of 16 columns has room for. A label whose node is not a number gets one: its place among
/// the nodes from 1; `None` where a matrix has no labels.
pub(super) fn write(matrices: &[&Matrix], positions: &[(String, [f64; 3])]) -> Option<String> {
    let mut numbers: HashMap<&str, usize> = HashMap::new();
    let mut order: Vec<&str> = Vec::new();
    let labels = matrices.iter().flat_map(|m| m.rows.iter().chain(&m.columns)).map(|l| l.node.as_str());
    for node in positions.iter().map(|p| p.0.as_str()).chain(labels) {
        if !numbers.contains_key(node) {
            numbers.insert(node, order.len() + 1);
            order.push(node);
        }
    }
    if order.iter().all(|n| n.parse::<u32>().is_ok_and(|n| n > 0 && n < 100_000_000)) {
        for n in &order {
            numbers.insert(n, n.parse().unwrap_or(0));
        }
    }
    let mut out = String::from("$ matrices by retune\n");
    for (node, [x, y, z]) in positions {
        let _ = writeln!(
            out,
            "GRID*   {:16}{:16}{:>16}{:>16}\n*       {:>16}",
            numbers[node.as_str()],
            0,
            wide(*x),
            wide(*y),
            wide(*z)
        );
    }
    for matrix in matrices {
        if matrix.rows.len() != matrix.n_rows || matrix.n_rows != matrix.n_columns {
            return None;
        }
        let form = if matrix.is_one_triangle { 6 } else { 1 };
        let letters: String = matrix.name.chars().filter(char::is_ascii_alphanumeric).take(8).collect();
        let name = letters.to_uppercase();
        let _ = writeln!(out, "DMIG    {name:<8}{:8}{form:8}{:8}{:8}", 0, 2, 0);
        let mut all: Vec<Entry> = matrix.entries.clone();
        if matrix.is_one_triangle {
            for e in &mut all {
                (e.row, e.column) = (e.row.max(e.column), e.row.min(e.column));
            }
        }
        all.sort_by_key(|e| (e.column, e.row));
        for column in all.chunk_by(|a, b| a.column == b.column) {
            let place = |i: u32| {
                let label = &matrix.rows[i as usize];
                format!("{:16}{:16}", numbers[label.node.as_str()], label.dof.map_or(0, |d| d as usize + 1))
            };
            let _ = writeln!(out, "DMIG*   {name:<16}{}", place(column[0].column));
            for e in column {
                let _ = writeln!(out, "*       {}{:>16}", place(e.row), wide(e.value));
            }
        }
    }
    Some(out)
}

/// A number in 16 columns.
fn wide(value: f64) -> String {
    let text = format!("{value:.9E}");
    let (digits, exponent) = text.split_once('E').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{digits}D{sign}{:02}", exponent.abs())
}
