//! The CSV export of OpenModal: an index, one table for each measurement, and a geometry.
//!
//! | file | columns used |
//! |---|---|
//! | `measurements_index.csv` | `measurement_id`, `func_type`, `rsp_node`, `rsp_dir`, `ref_node`, `ref_dir`, `ordinate_spec_data_type`, `orddenom_spec_data_type`: as in dataset 58 |
//! | `measurement_<id>.csv` | `frq`, `amp_real`, `amp_imag` |
//! | `geometry_openmodal.csv` | `node_nums`, `x`, `y`, `z`, and the axes `lcs_x1` ... `lcs_z3` |
//!
//! `info_openmodal.csv` is not read: its unit factors are 1 whatever the units are, so that units must be stated.

use super::{Columns, CsvError, Row, Sheet, function};
use crate::data::uff::{Dataset, Entity, Header, Node, Part, PartSystem, UniversalFile};
use crate::data::{Open, Point, read_file};
use std::path::Path;

/// Tables larger than this are not read: 256 MiB.
const LARGEST: u64 = 256 << 20;

/// Reads an exported folder as a universal file without units, for [`frfs`](crate::data::convert::frfs) and
/// [`geometry`](crate::data::convert::geometry).
///
/// # Errors
/// [`CsvError::File`] for a missing table; others with line and column.
pub fn read(folder: &Path) -> Result<UniversalFile, CsvError> {
    read_by(&mut read_file, folder)
}

/// The file that lists the measurements of a folder.
const INDEX: &str = "measurements_index.csv";

/// As [`read`], with bytes got in a way of the caller's.
pub(crate) fn read_by(open: &mut Open<'_>, folder: &Path) -> Result<UniversalFile, CsvError> {
    let mut open = |path: &Path| -> Result<Vec<u8>, CsvError> {
        open(path, LARGEST).map_err(|e| CsvError::File { path: path.display().to_string(), reason: e.to_string() })
    };
    let mut datasets = Vec::new();
    let geometry = folder.join("geometry_openmodal.csv");
    if geometry.exists() {
        datasets.extend(nodes(&Sheet::read(&open(&geometry)?)?)?);
    }
    let index = open(&folder.join(INDEX)).map_err(|e| match e {
        CsvError::File { reason, .. } => CsvError::File {
            path: folder.display().to_string(),
            reason: format!("a folder of measurements is an export of OpenModal with a file `{INDEX}`: {reason}; name the files themselves otherwise"),
        },
        other => other,
    })?;
    let index = Sheet::read(&index)?;
    let names = [
        "measurement_id",
        "func_type",
        "rsp_node",
        "rsp_dir",
        "ref_node",
        "ref_dir",
        "ordinate_spec_data_type",
        "orddenom_spec_data_type",
    ];
    for row in &index.rows {
        let mut n = [0; 8];
        for (value, name) in n.iter_mut().zip(names) {
            *value = index.integer(row, index.column(name)?)?;
        }
        let [id, function_type, rsp_node, rsp_dir, ref_node, ref_dir, numerator, denominator] = n;
        let bytes = open(&folder.join(format!("measurement_{id}.csv")))?;
        let columns = Columns { frequency: "frq", re: "amp_real", im: "amp_imag" };
        let entity = |node, direction| Entity { name: "NONE".to_owned(), node, direction };
        let (response, reference) = (entity(rsp_node, rsp_dir), entity(ref_node, ref_dir));
        let mut function = function(&bytes, columns, response, reference, [numerator, denominator])?;
        function.function_type = function_type;
        function.function_id = id;
        datasets.push(Dataset::from(function));
    }
    Ok(UniversalFile { datasets })
}

fn nodes(sheet: &Sheet<'_>) -> Result<Vec<Dataset>, CsvError> {
    let triple = |row: &Row<'_>, names: [&str; 3]| -> Result<[f64; 3], CsvError> {
        let mut values = [0.0; 3];
        for (value, name) in values.iter_mut().zip(names) {
            *value = sheet.number(row, sheet.column(name)?)?;
        }
        Ok(values)
    };
    let mut nodes = Vec::new();
    let mut systems: Vec<PartSystem> = Vec::new();
    let x = sheet.column("x")?;
    // Rows without a place are those that nobody filled in.
    for row in sheet.rows.iter().filter(|r| !r.cells[x].is_empty()) {
        let mut rows = [[0.0; 3]; 4];
        for (axis, target) in ["x", "y", "z"].iter().zip(&mut rows) {
            let names = [1, 2, 3].map(|i| format!("lcs_{axis}{i}"));
            *target = triple(row, names.each_ref().map(String::as_str))?;
        }
        let displacement_cs = if rows[..3] == Point::GLOBAL {
            0
        } else {
            let label = systems.len() as i64 + 1;
            systems.push(PartSystem { label, kind: 0, color: 8, name: format!("CS{label}"), rows });
            label
        };
        nodes.push(Node {
            label: sheet.integer(row, sheet.column("node_nums")?)?,
            definition_cs: 0,
            displacement_cs,
            color: 8,
            position: triple(row, ["x", "y", "z"])?,
        });
    }
    // The name of the program says that rows are axes.
    let header = Header { program: "OpenModal".to_owned(), ..Header::default() };
    Ok(vec![
        Dataset::Header(header),
        Dataset::Part(Part { uid: 1, name: "OpenModal".to_owned(), systems }),
        Dataset::Nodes2411(nodes),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::FrfQuantity;
    use crate::data::convert::{ConvertError, FrfOptions, UnitSystem, UnitsFrom, frfs, geometry};
    use retune_linalg::Complex;

    /// The clamped wing of Wright State University (josephcslater/MAC_and_Modalupdating): 18 accelerances.
    #[test]
    fn the_cruise_missile_wing_is_read_once_its_units_are_stated() {
        let Some(folder) = crate::data::shared_data("cruise_missile_wing/frf_csv") else { return };
        let file = read(&folder).unwrap();
        assert!(matches!(frfs(&[&file], &FrfOptions::default()), Err(ConvertError::Questions(_))));
        let units = UnitsFrom::System(UnitSystem::from_name("SI").unwrap());
        let import = frfs(&[&file], &FrfOptions { units, ..FrfOptions::default() }).unwrap();
        let set = import.frfs;
        // 4097 lines, of which the last is empty in measurements 12 and 17.
        assert_eq!((set.quantity, set.n_lines()), (FrfQuantity::Accelerance, 4096));
        assert_eq!((set.references.len(), set.responses.len()), (1, 18));
        assert_eq!((set.responses[17].name.as_str(), set.responses[17].direction), ("18", Some([0.0, 0.0, 1.0])));
        // measurement_17.csv, second line of values.
        assert_eq!(set.frequencies_hz[1], 0.31252000128008195);
        assert_eq!(set.at(1, 0, 17), Complex::new(0.013806162435433523, -0.018278758473542614));
        let inches = UnitsFrom::System(UnitSystem::from_name("in-lbf-s").unwrap());
        let (geometry, _) = geometry(&[&file], &inches, None).unwrap();
        assert!((geometry.point("4").unwrap().position_m[1] - 12.0 * 0.0254).abs() < 1.0e-15);
    }
}
