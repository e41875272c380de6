//! Punch files of Nastran and OptiStruct: real eigenvectors at grid points.
//!
//! ```text
//! $EIGENVECTOR
//! $REAL OUTPUT
//! $EIGENVALUE =  0.4824560E+05  MODE =     1
//!          1       G      0.000000E+00      0.000000E+00      2.280130E-01
//! -CONT-                  0.000000E+00     -2.203100E+00      0.000000E+00
//! ```
//!
//! Columns 73 to 80 of a line are its number. An eigenvalue is ω² in (rad/s)². The file has neither positions nor the axes in which a point
//! moves (the field CD of its GRID), which count as global; nor units. [`read`] gives datasets 55 of a universal file, so that all that is
//! said of those holds for these.

use super::uff::{DataAtNodes, Dataset, Entry, UniversalFile};
use std::f64::consts::TAU;

/// Why a punch file cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PunchError {
    /// Text that is not understood.
    #[error("line {line}: `{text}` where {expected} should stand")]
    Line {
        /// Line of the file, from 1.
        line: usize,
        /// The start of it.
        text: String,
        /// What should.
        expected: &'static str,
    },
    /// Output that is not a real eigenvector.
    #[error("line {line}: complex output; only real eigenvectors (`$REAL OUTPUT`) are read")]
    Complex {
        /// Line of the file, from 1.
        line: usize,
    },
    /// No mode.
    #[error(
        "the punch file holds no eigenvectors (`$EIGENVECTOR` with `$EIGENVALUE`); ask the solver for `DISPLACEMENT(PUNCH) = ALL`"
    )]
    NoModes,
}

/// Eigenvalues below this part of the largest are those of rigid-body motions.
const RIGID: f64 = 1e-8;

/// Whether bytes are a punch file: its first lines are comments that name a title or a result.
pub fn is_punch(bytes: &[u8]) -> bool {
    /// No head of a punch file is longer.
    const LOOK: usize = 8192;
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(LOOK)]).to_uppercase();
    let mut lines = head.lines().map(str::trim).filter(|l| !l.is_empty());
    let is_first = lines.clone().next().is_some_and(|l| l.starts_with('$'));
    is_first && lines.any(|l| l.starts_with("$EIGENV") || l.starts_with("$DISPLACEMENT") || l.starts_with("$TITLE"))
}

struct Mode {
    number: i64,
    eigenvalue: f64,
    entries: Vec<Entry>,
}

/// Reads the real eigenvectors of a punch file as datasets 55, and says what was left out.
///
/// # Errors
/// [`PunchError`] with the line.
pub fn read(bytes: &[u8]) -> Result<(UniversalFile, Vec<String>), PunchError> {
    let text = String::from_utf8_lossy(bytes);
    let mut modes: Vec<Mode> = Vec::new();
    // Whether the block is one of vectors, and whether it belongs to a mode.
    let (mut is_vector, mut is_mode, mut scalars) = (false, false, 0);
    for (line, full) in text.lines().enumerate().map(|(i, l)| (i + 1, l)) {
        const WIDTH: usize = 72;
        let own = full.char_indices().nth(WIDTH).map_or(full, |(at, _)| &full[..at]).trim_end();
        let wrong = |expected| {
            let text: String = own.trim().chars().filter(|c| !c.is_control()).take(60).collect();
            PunchError::Line { line, text, expected }
        };
        if let Some(head) = own.trim_start().strip_prefix('$') {
            let head = head.trim().to_uppercase();
            if head.starts_with("EIGENVALUE") {
                let mut fields = head.split('=').skip(1);
                let value = fields.next().and_then(|f| f.split_whitespace().next()?.parse::<f64>().ok());
                let eigenvalue = value.filter(|v| v.is_finite()).ok_or_else(|| wrong("`$EIGENVALUE = x  MODE = n`"))?;
                let number = fields.next().and_then(|f| f.split_whitespace().next()?.parse().ok());
                let number = number.unwrap_or(modes.len() as i64 + 1);
                is_mode = is_vector;
                if is_vector {
                    modes.push(Mode { number, eigenvalue, entries: Vec::new() });
                }
            } else if head.starts_with("EIGENVECTOR") || head.starts_with("DISPLACEMENT") {
                (is_vector, is_mode) = (true, false);
            } else if head.starts_with("REAL-IMAG") || head.starts_with("MAGNITUDE-PHASE") {
                if is_vector {
                    return Err(PunchError::Complex { line });
                }
            } else if !["TITLE", "SUBTITLE", "LABEL", "REAL OUTPUT", "SUBCASE", "POINT ID", "ANALYSIS"]
                .iter()
                .any(|known| head.starts_with(known))
            {
                (is_vector, is_mode) = (false, false);
            }
            continue;
        }
        let Some(mode) = modes.last_mut().filter(|_| is_mode && !own.trim().is_empty()) else { continue };
        let mut fields = own.split_whitespace();
        let first = fields.next().unwrap_or_default();
        let is_more = first == "-CONT-";
        let label =
            if is_more { None } else { Some(first.parse::<i64>().map_err(|_| wrong("the number of a grid point"))?) };
        if !is_more && fields.next() == Some("S") {
            // A scalar point has one value and no direction.
            scalars += 1;
            mode.entries.push(Entry { head: vec![-1], values: Vec::new() });
            continue;
        }
        let values = fields.map(str::parse).collect::<Result<Vec<f64>, _>>();
        let values = values.ok().filter(|v| (1..=3).contains(&v.len())).ok_or_else(|| wrong("up to three numbers"))?;
        match (label, mode.entries.last_mut()) {
            (Some(label), _) => mode.entries.push(Entry { head: vec![label], values }),
            (None, Some(entry)) if entry.values.len() <= 3 => {
                entry.values.resize(3, 0.0);
                entry.values.extend(values);
            }
            (None, _) => return Err(wrong("the first record of a point")),
        }
    }
    for mode in &mut modes {
        mode.entries.retain(|e| e.head[0] >= 0);
        mode.entries.iter_mut().for_each(|e| e.values.resize(6, 0.0));
    }
    modes.retain(|m| !m.entries.is_empty());
    let largest = modes.iter().map(|m| m.eigenvalue).fold(0.0, f64::max);
    let before = modes.len();
    modes.retain(|m| m.eigenvalue > RIGID * largest);
    let mut notes = Vec::new();
    if modes.len() < before {
        notes.push(format!("{} rigid-body modes were left out", before - modes.len()));
    }
    if scalars > 0 {
        notes.push("scalar points were left out".to_string());
    }
    if modes.is_empty() {
        return Err(PunchError::NoModes);
    }
    notes.push("a punch file has no displacement systems: directions count as along global axes".to_string());
    let datasets = modes.into_iter().map(|m| Dataset::DataAtNodes(dataset(m))).collect();
    Ok((UniversalFile { datasets }, notes))
}

fn dataset(mode: Mode) -> DataAtNodes {
    DataAtNodes {
        ids: std::array::from_fn(|_| "NONE".to_owned()),
        model_type: 1,
        analysis_type: 2,
        characteristic: 3,
        specific_type: 8,
        data_type: 2,
        values_per_node: 6,
        integers: vec![0, mode.number],
        reals: vec![mode.eigenvalue.sqrt() / TAU, 0.0, 0.0, 0.0],
        entries: mode.entries,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(kind: &str) -> String {
        let mut text = String::from("$TITLE   = A BEAM\n$SUBTITLE=\n$LABEL   =\n");
        for (number, lambda, z) in [(1, 0.0, 1.0), (2, 3_947.841_760_435_743, 0.25), (3, 15_791.367_041_742_97, -0.5)] {
            text += &format!(
                "$EIGENVECTOR\n{kind}\n$SUBCASE ID =           1\n$EIGENVALUE = {lambda:.7E}  MODE = {number:5}\n"
            );
            for point in [1, 12] {
                let z = z * f64::from(point);
                text += &format!("{point:>10}       G {:>17.6E} {:>17.6E} {z:>17.6E}{:>8}\n", 0.0, 0.0, 7);
                text += &format!("-CONT-{:>30.6E} {:>17.6E} {:>17.6E}{:>8}\n", 0.0, 2.0 * z, 0.0, 8);
            }
        }
        text + "$SPCF\n$REAL OUTPUT\n         1       G      1.000000E+00      0.000000E+00      0.000000E+00\n"
    }

    #[test]
    fn eigenvectors_become_modes() {
        let text = file("$REAL OUTPUT");
        assert!(is_punch(text.as_bytes()) && !is_punch(b"    -1\n    55\n"));
        let (unv, notes) = read(text.as_bytes()).unwrap();
        assert_eq!((unv.datasets.len(), notes.len()), (2, 2));
        let Dataset::DataAtNodes(first) = &unv.datasets[0] else { panic!() };
        assert!((first.reals[0] - 10.0).abs() < 1e-5);
        assert_eq!(first.entries[1], Entry { head: vec![12], values: vec![0.0, 0.0, 3.0, 0.0, 6.0, 0.0] });
    }

    #[test]
    fn what_is_no_real_eigenvector_is_refused_with_its_line() {
        assert_eq!(read(file("$REAL-IMAGINARY OUTPUT").as_bytes()).unwrap_err(), PunchError::Complex { line: 5 });
        let bad = file("$REAL OUTPUT").replacen("       G", "       G x", 1);
        assert!(matches!(read(bad.as_bytes()), Err(PunchError::Line { line: 8, .. })));
        assert_eq!(read(b"$TITLE = A\n$SPCF\n 1 G 1. 2. 3.\n").unwrap_err(), PunchError::NoModes);
    }

    #[test]
    fn mutated_files_do_no_harm() {
        use rand::{Rng, RngExt, SeedableRng};
        let seed = file("$REAL OUTPUT").into_bytes();
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let mut read_at_all = 0;
        for _ in 0..5_000 {
            let mut bytes = seed.clone();
            for _ in 0..rng.random_range(1..4) {
                let at = rng.random_range(0..bytes.len());
                match rng.random_range(0..3) {
                    0 => bytes[at] = rng.next_u32() as u8,
                    1 => bytes[at] = b"$-=GS\n.0E 9"[rng.random_range(0..11)],
                    _ => bytes.truncate(at + 1),
                }
            }
            read_at_all += u32::from(read(&bytes).is_ok());
        }
        assert!(read_at_all > 0);
    }
}
