//! Writing OUTPUT4.

use super::super::Matrix;
use std::fmt::Write as _;

/// How a file is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::matrices) enum Layout {
    /// Text with 17 digits, sparse, BIGMAT.
    Text,
    /// Little-endian records, sparse, BIGMAT.
    Binary,
}

/// Runs of rows without a gap, of one column.
fn runs(column: &[super::super::Entry]) -> impl Iterator<Item = &[super::super::Entry]> {
    column.chunk_by(|a, b| a.row + 1 == b.row)
}

/// A name of eight letters, as Nastran has them.
fn short(name: &str) -> String {
    let letters: String = name.chars().filter(char::is_ascii_alphanumeric).take(8).collect();
    letters.to_uppercase()
}

/// Writes matrices in double precision with all their entries, a triangle with its mirror image; every number reads back to the same bits.
pub(in crate::matrices) fn write(matrices: &[&Matrix], layout: Layout) -> Vec<u8> {
    let mut out = Vec::new();
    for matrix in matrices {
        match layout {
            Layout::Text => out.extend(text(matrix).into_bytes()),
            Layout::Binary => binary(matrix, &mut out),
        }
    }
    out
}

/// 1 square, 2 rectangular, 6 symmetric.
fn form(matrix: &Matrix) -> i32 {
    match (matrix.is_one_triangle, matrix.n_rows == matrix.n_columns) {
        (true, _) => 6,
        (false, true) => 1,
        (false, false) => 2,
    }
}

fn text(matrix: &Matrix) -> String {
    const PER_LINE: usize = 3;
    let mut out = format!(
        "{:8}{:8}{:8}{:8}{:<8}1P,3E24.16\n",
        matrix.n_columns,
        -(matrix.n_rows as i64),
        form(matrix),
        2,
        short(&matrix.name)
    );
    let all = matrix.full();
    for column in all.chunk_by(|a, b| a.column == b.column) {
        let words: usize = runs(column).map(|run| 2 + 2 * run.len()).sum();
        let _ = writeln!(out, "{:8}{:8}{words:8}", column[0].column + 1, 0);
        for run in runs(column) {
            let _ = writeln!(out, "{:8}{:8}", 2 * run.len() + 1, run[0].row + 1);
            for line in run.chunks(PER_LINE) {
                for e in line {
                    out.push_str(&fortran(e.value));
                }
                out.push('\n');
            }
        }
    }
    let _ = writeln!(out, "{:8}{:8}{:8}\n{}", matrix.n_columns + 1, 1, 1, fortran(1.0));
    out
}

/// `1P,E24.16`: 17 digits, from which every double comes back.
fn fortran(value: f64) -> String {
    let text = format!("{value:.16E}");
    let (digits, exponent) = text.split_once('E').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let sign = if exponent < 0 { '-' } else { '+' };
    // Three digits of an exponent take the place of the letter, as in Fortran.
    let exponent = exponent.abs();
    let tail = if exponent > 99 { format!("{sign}{exponent:03}") } else { format!("E{sign}{exponent:02}") };
    format!("{:>24}", format!("{digits}{tail}"))
}

fn binary(matrix: &Matrix, out: &mut Vec<u8>) {
    let mut record = |words: &[u8]| {
        let length = (words.len() as u32).to_le_bytes();
        out.extend(length);
        out.extend(words);
        out.extend(length);
    };
    let ints = |values: &[i32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let mut head = ints(&[matrix.n_columns as i32, -(matrix.n_rows as i32), form(matrix), 2]);
    head.extend(format!("{:<8}", short(&matrix.name)).into_bytes());
    record(&head);
    let all = matrix.full();
    for column in all.chunk_by(|a, b| a.column == b.column) {
        let words: usize = runs(column).map(|run| 2 + 2 * run.len()).sum();
        let mut bytes = ints(&[column[0].column as i32 + 1, 0, words as i32]);
        for run in runs(column) {
            bytes.extend(ints(&[2 * run.len() as i32 + 1, run[0].row as i32 + 1]));
            bytes.extend(run.iter().flat_map(|e| e.value.to_le_bytes()));
        }
        record(&bytes);
    }
    let mut last = ints(&[matrix.n_columns as i32 + 1, 1, 2]);
    last.extend(1.0_f64.to_le_bytes());
    record(&last);
}
