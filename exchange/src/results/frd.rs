//! Results of CalculiX for its postprocessor (.frd), as text: eigenvalues and displacements of modes.

use super::{ResultMode, ResultsError, SolverResults};
use std::collections::BTreeMap;

/// Whether bytes are a file of results.
pub(super) fn is_frd(bytes: &[u8]) -> bool {
    bytes.starts_with(b"    1C")
}

/// What a record of nodes holds.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Block {
    None,
    /// Displacements of the mode that was named last.
    Displacements,
    Other,
}

pub(super) fn read(text: &str) -> Result<SolverResults, ResultsError> {
    let mut out = SolverResults { kind: "frd", ..SolverResults::default() };
    let mut block = Block::None;
    // Generalised stiffness and mass of the mode that follows.
    let (mut stiffness, mut mass): (Option<f64>, f64) = (None, 1.0);
    let mut is_mode = false;
    let mut width = 10;
    for (i, line) in text.lines().enumerate() {
        let wrong = |message: &str| ResultsError::Line { line: i + 1, message: message.to_string() };
        let value = |key: &str| line.trim_start().strip_prefix(key).map(|rest| rest.trim().parse::<f64>().ok());
        if let Some(found) = value("1PGM") {
            mass = found
                .filter(|m| *m > 0.0)
                .ok_or_else(|| wrong("a generalised mass above zero is expected behind 1PGM"))?;
        } else if let Some(found) = value("1PGK") {
            stiffness = Some(found.filter(|k| k.is_finite()).ok_or_else(|| wrong("a number is expected behind 1PGK"))?);
        } else if line.trim_start().starts_with("100CL") {
            is_mode = line.contains("MODAL");
            block = Block::None;
            width = match line.trim_end().chars().last() {
                Some('0') => 5,
                Some('1') => 10,
                _ => {
                    return Err(wrong(
                        "binary records are not read; let CalculiX write text (NODE FILE without BINARY)",
                    ));
                }
            };
        } else if line.starts_with(" -4") {
            block = if is_mode && line.get(5..).is_some_and(|l| l.starts_with("DISP ")) {
                Block::Displacements
            } else {
                Block::Other
            };
            if block == Block::Displacements {
                let eigenvalue = stiffness.ok_or_else(|| wrong("a mode without its eigenvalue (1PGK)"))? / mass;
                let number = out.modes.len() as i64 + 1;
                out.modes.push(ResultMode { number, eigenvalue, shape: BTreeMap::new() });
            }
        } else if line.starts_with(" -3") {
            block = Block::None;
        } else if line.starts_with(" -1") && block == Block::Displacements {
            let field = |from: usize, to: usize| line.get(from..to).map(str::trim);
            let node = field(3, 3 + width).and_then(|f| f.parse::<u32>().ok());
            let node = node.ok_or_else(|| wrong("the number of a node is expected"))?;
            let mut shape = [0.0; 6];
            for (k, slot) in shape.iter_mut().enumerate().take(3) {
                let at = 3 + width + 12 * k;
                let number = field(at, at + 12).and_then(|f| f.parse::<f64>().ok()).filter(|v| v.is_finite());
                *slot = number.ok_or_else(|| wrong("three displacements of a node are expected"))?;
            }
            if let Some(mode) = out.modes.last_mut() {
                mode.shape.insert(node, shape);
            }
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// SYNTHETIC: the layout of CalculiX 2.20, numbers of nobody.
    const MODES: &str = "    1C
    1UUSER
    2C                             2                                     1
 -1         1 0.00000E+00 0.00000E+00 0.00000E+00
 -1         2 1.00000E+00 0.00000E+00 0.00000E+00
 -3
    1PSTEP                         1           1           1
    1PGM                2.000000E+00
    1PGK                3.200000E+03
    1PMODE                         1
  100CL  101 6.36620E+00           2                     2    1MODAL      1
 -4  DISP        4    1
 -5  D1          1    2    1    0
 -1         1 0.00000E+00 0.00000E+00 0.00000E+00
 -1         2-1.00000E-01 2.50000E+00-3.00000E+02
 -3
 -4  STRESS      6    1
 -1         1 9.00000E+00 9.00000E+00 9.00000E+00
 -3
 9999
";

    #[test]
    fn modes_have_their_eigenvalue_and_displacements() {
        assert!(is_frd(MODES.as_bytes()));
        let out = read(MODES).unwrap();
        assert_eq!(out.modes.len(), 1);
        assert_eq!(out.modes[0].eigenvalue, 1600.0);
        assert_eq!(out.modes[0].shape[&2], [-0.1, 2.5, -300.0, 0.0, 0.0, 0.0]);
        let cut = MODES.replace(" 2.50000E+00-3.00000E+02", " 2.50000E+00");
        assert!(matches!(read(&cut), Err(ResultsError::Line { line: 15, .. })), "{:?}", read(&cut));
        let binary = MODES.replace("1MODAL      1", "1MODAL      2");
        assert!(read(&binary).unwrap_err().to_string().contains("binary records are not read"));
    }

    #[test]
    fn mutated_files_end() {
        crate::mutate::all(&[MODES.as_bytes().to_vec()], 4000, |b| read(&String::from_utf8_lossy(b)).is_ok());
    }
}
