//! Printed output of Abaqus and CalculiX (.dat): the table of eigenvalues, and of Abaqus the masses.

use super::f06::squeezed;
use super::{ResultMass, ResultMode, ResultsError, SolverResults};
use std::collections::BTreeMap;

const EIGENVALUES: &str = "EIGENVALUEOUTPUT";
const MASS: &str = "TOTALMASSOFMODEL";
const CENTRE: &str = "LOCATIONOFTHECENTEROFMASSOFTHEMODEL";
const MOMENTS: &str = "MOMENTSOFINERTIAABOUTTHEORIGIN";
const PRODUCTS: &str = "PRODUCTSOFINERTIAABOUTTHEORIGIN";

/// Whether a text is printed output of one of them.
pub(super) fn is_dat(bytes: &[u8]) -> bool {
    let text = String::from_utf8_lossy(bytes);
    let mut heads = text.lines().map(squeezed);
    heads.any(|l| l == EIGENVALUES || l == MASS)
}

/// All numbers of a line; nothing where a word is none.
fn numbers(line: &str) -> Option<Vec<f64>> {
    line.split_whitespace().map(|w| w.parse::<f64>().ok().filter(|v| v.is_finite())).collect()
}

pub(super) fn read(text: &str) -> Result<SolverResults, ResultsError> {
    let mut out = SolverResults { kind: "dat", ..SolverResults::default() };
    let mut modes: BTreeMap<i64, ResultMode> = BTreeMap::new();
    let (mut in_table, mut n_tables) = (false, 0);
    // Mass, centre, moments and products about the origin, in this order.
    let mut asked: Option<usize> = None;
    let mut given: [Vec<f64>; 4] = Default::default();
    for (i, line) in text.lines().enumerate() {
        let wrong = |message: &str| ResultsError::Line { line: i + 1, message: message.to_string() };
        let head = squeezed(line);
        if head == EIGENVALUES {
            (in_table, n_tables) = (true, n_tables + 1);
            continue;
        }
        if let Some(k) = [MASS, CENTRE, MOMENTS, PRODUCTS].iter().position(|h| *h == head) {
            asked = Some(k).filter(|k| given[*k].is_empty());
            continue;
        }
        if let Some(k) = asked {
            let Some(values) = numbers(line).filter(|v| !v.is_empty()) else { continue };
            if values.len() != if k == 0 { 1 } else { 3 } {
                return Err(wrong("one number of the mass, or three of the centre or of the inertia, are expected"));
            }
            given[k] = values;
            asked = None;
            continue;
        }
        if !in_table {
            continue;
        }
        match numbers(line) {
            Some(row) if row.len() >= 4 && row[0] >= 1.0 && row[0].fract() == 0.0 => {
                let number = row[0] as i64;
                if n_tables == 1 {
                    modes.entry(number).or_insert(ResultMode { number, eigenvalue: row[1], shape: BTreeMap::new() });
                }
            }
            Some(row) if row.is_empty() => {}
            Some(_) => {
                return Err(wrong(
                    "a row of eigenvalues has the number of the mode, the eigenvalue and the frequencies",
                ));
            }
            // Headings of the table stand above its rows; any other ends it.
            None => in_table &= ["MODENO", "REALPART", "(RAD/TIME)"].iter().any(|h| head.contains(h)),
        }
    }
    if n_tables > 1 {
        out.notes.push("eigenvalues of later steps were left out".to_string());
    }
    if let [mass, centre, moments, products] = &given
        && given.iter().all(|g| !g.is_empty())
    {
        let m = mass[0];
        let mut rigid = [[0.0; 6]; 6];
        for k in 0..3 {
            rigid[k][k] = m;
            rigid[3 + k][3 + k] = moments[k];
            let (a, b) = ((k + 1) % 3, (k + 2) % 3);
            // Displacements of the centre by rotations about the origin: θ × c.
            for (row, column, value) in [(k, 3 + a, m * centre[b]), (k, 3 + b, -m * centre[a])] {
                rigid[row][column] = value;
                rigid[column][row] = value;
            }
        }
        // The products are entries of the tensor, -∫ x y dm.
        for ((a, b), value) in [(3, 4), (3, 5), (4, 5)].into_iter().zip(products) {
            rigid[a][b] = *value;
            rigid[b][a] = *value;
        }
        out.mass = Some(ResultMass { reference: 0, rigid });
    }
    out.modes = modes.into_values().collect();
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// SYNTHETIC: the layout of both programs, numbers of nobody.
    const ABAQUS: &str = "
                    TOTAL MASS OF MODEL

                       2.000000    

                    LOCATION OF THE CENTER OF MASS OF THE MODEL

                      1.0   2.0   3.0

                    MOMENTS OF INERTIA ABOUT THE ORIGIN
                           I(XX)               I(YY)               I(ZZ)

                       26.   20.   10.

                    PRODUCTS OF INERTIA ABOUT THE ORIGIN
                           I(XY)               I(XZ)               I(YZ)

                       -4.   -6.   -12.

                              E I G E N V A L U E    O U T P U T

 MODE NO      EIGENVALUE              FREQUENCY         GENERALIZED MASS   COMPOSITE MODAL DAMPING
                             (RAD/TIME)   (CYCLES/TIME)

       1       4901.8         70.013         11.143         1.0000         0.0000
       2      1.10256E+05     332.05         52.847         1.0000         0.0000

          P A R T I C I P A T I O N   F A C T O R S
       1       4901.8         70.013         11.143         1.0000         0.0000
";

    /// A point mass at (1, 2, 3) has inertia of its place alone: m (r² I - r rᵀ).
    #[test]
    fn printed_masses_are_those_of_rigid_motions() {
        let out = read(ABAQUS).unwrap();
        assert!(is_dat(ABAQUS.as_bytes()));
        let rigid = out.mass.unwrap().rigid;
        let (m, c) = (2.0, [1.0, 2.0, 3.0]);
        for i in 0..3 {
            for j in 0..3 {
                let r2: f64 = c.iter().map(|v| v * v).sum();
                let expected = m * (if i == j { r2 } else { 0.0 } - c[i] * c[j]);
                assert_eq!(rigid[3 + i][3 + j], expected);
            }
        }
        assert_eq!((rigid[0][4], rigid[0][5], rigid[1][3]), (6.0, -4.0, -6.0));
        let numbers: Vec<f64> = out.modes.iter().map(|m| m.eigenvalue).collect();
        assert_eq!(numbers, [4901.8, 1.10256e5]);
    }

    #[test]
    fn a_row_that_breaks_off_is_an_error() {
        let text = ABAQUS.replace(
            "  2      1.10256E+05     332.05         52.847         1.0000         0.0000",
            "  2      1.10256E+05",
        );
        assert!(matches!(read(&text), Err(ResultsError::Line { line: 26, .. })), "{:?}", read(&text));
    }

    #[test]
    fn mutated_files_end() {
        crate::mutate::all(&[ABAQUS.as_bytes().to_vec()], 4000, |b| read(&String::from_utf8_lossy(b)).is_ok());
    }
}
