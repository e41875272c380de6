//! Model and modes for ParaView: one `.vtu` file a mode and a `.pvd` file that lists them by frequency.
//!
//! # Source
//! Kitware, VTK file formats, XML formats: unstructured grid, inline base64 data with a 32-bit length in front.

use super::data::encoding_base64 as base64;
use super::data::{Carrier, Floats, ReportData, ReportError, Structure};
use super::html::push_markup;
use std::fmt::Write as _;

/// A file to be written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VtkFile {
    /// Its name, with ending.
    pub name: String,
    /// Its text.
    pub content: String,
}

/// Files of the model, of its modes and of the test's modes; in ParaView, open `model_modes.pvd` and `test_modes.pvd`
/// and use the filter "Warp By Vector" on `displacement` (`displacement_imag` for complex shapes). "Time" is the
/// frequency in Hz.
///
/// Fields of the report that live on elements, nodes or sensors come along as cell and point data.
///
/// # Errors
/// [`ReportError`] when the parts do not fit together, see [`ReportData::validate`].
pub fn paraview(data: &ReportData) -> Result<Vec<VtkFile>, ReportError> {
    data.validate()?;
    let Some(s) = &data.structure else { return Ok(Vec::new()) };
    let mut files = vec![VtkFile { name: "model.vtu".into(), content: grid(s, None) }];
    let mut listed = Vec::new();
    for (i, m) in data.modes.model.iter().enumerate().filter(|(_, m)| !m.displacement.is_empty()) {
        let name = format!("model_mode_{:03}.vtu", i + 1);
        files.push(VtkFile {
            name: name.clone(),
            content: grid(s, Some((&m.displacement, m.displacement_imag.as_ref()))),
        });
        listed.push((m.frequency_hz, name));
    }
    if !listed.is_empty() {
        files.push(collection("model_modes.pvd", &listed));
    }
    listed = Vec::new();
    for (i, m) in data.modes.test.iter().enumerate() {
        let Some(shape) = &m.at_sensors else { continue };
        let name = format!("test_mode_{:03}.vtu", i + 1);
        files.push(VtkFile { name: name.clone(), content: sensors(s, shape, m.at_sensors_imag.as_ref()) });
        listed.push((m.frequency_hz, name));
    }
    if !listed.is_empty() {
        files.push(collection("test_modes.pvd", &listed));
    }
    Ok(files)
}

fn collection(name: &str, files: &[(f64, String)]) -> VtkFile {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n<Collection>\n",
    );
    for (hz, file) in files {
        let _ = writeln!(text, "<DataSet timestep=\"{hz}\" part=\"0\" file=\"{file}\"/>");
    }
    text.push_str("</Collection>\n</VTKFile>\n");
    VtkFile { name: name.into(), content: text }
}

/// One data array; its name is text from the user.
fn array(out: &mut String, kind: &str, name: &str, components: usize, bytes: &[u8]) {
    let _ = write!(out, "<DataArray type=\"{kind}\" Name=\"");
    push_markup(out, name);
    let _ = write!(out, "\" NumberOfComponents=\"{components}\" format=\"binary\">");
    let mut all = Vec::with_capacity(bytes.len() + 4);
    all.extend_from_slice(&u32::try_from(bytes.len()).unwrap_or(u32::MAX).to_le_bytes());
    all.extend_from_slice(bytes);
    out.push_str(&base64(&all));
    out.push_str("</DataArray>\n");
}

fn f32s(values: impl IntoIterator<Item = f32>) -> Vec<u8> {
    values.into_iter().flat_map(f32::to_le_bytes).collect()
}

fn i32s(values: impl IntoIterator<Item = usize>) -> Vec<u8> {
    values.into_iter().flat_map(|v| (v as i32).to_le_bytes()).collect()
}

/// Cell type of VTK by the number of nodes: vertex, line, triangle, quadrilateral, polygon.
fn cell_type(nodes: usize) -> u8 {
    match nodes {
        0 | 1 => 1,
        2 => 3,
        3 => 5,
        4 => 9,
        _ => 7,
    }
}

fn mesh(points: impl Iterator<Item = [f64; 3]>, cells: &[&[usize]], point_data: &str, cell_data: &str) -> String {
    let points: Vec<u8> = points.flatten().flat_map(f64::to_le_bytes).collect();
    let mut out = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n",
    );
    let _ =
        writeln!(out, "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<Points>", points.len() / 24, cells.len());
    array(&mut out, "Float64", "points", 3, &points);
    out.push_str("</Points>\n<Cells>\n");
    array(&mut out, "Int32", "connectivity", 1, &i32s(cells.iter().flat_map(|c| c.iter().copied())));
    let offsets = cells.iter().scan(0, |sum, c| {
        *sum += c.len();
        Some(*sum)
    });
    array(&mut out, "Int32", "offsets", 1, &i32s(offsets));
    array(&mut out, "UInt8", "types", 1, &cells.iter().map(|c| cell_type(c.len())).collect::<Vec<_>>());
    out.push_str("</Cells>\n<PointData>\n");
    out.push_str(point_data);
    out.push_str("</PointData>\n<CellData>\n");
    out.push_str(cell_data);
    out.push_str("</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
    out
}

/// Elements and rigid links with a shape; `kind` tells them apart: 0 elements, 1 rigid links.
fn grid(s: &Structure, shape: Option<(&Floats, Option<&Floats>)>) -> String {
    let links: Vec<[usize; 2]> = s.rigid_links.iter().flat_map(|l| l.slaves.iter().map(|k| [l.master, *k])).collect();
    let elements: Vec<&[usize]> = s.elements.iter().map(|e| e.nodes.as_slice()).filter(|n| !n.is_empty()).collect();
    let n_elements = elements.len();
    let cells: Vec<&[usize]> = elements.into_iter().chain(links.iter().map(<[usize; 2]>::as_slice)).collect();
    let mut point = String::new();
    if let Some((re, im)) = shape {
        array(&mut point, "Float32", "displacement", 3, &f32s(re.0.iter().copied()));
        if let Some(im) = im {
            array(&mut point, "Float32", "displacement_imag", 3, &f32s(im.0.iter().copied()));
        }
    }
    let mut cell = String::new();
    array(&mut cell, "Int32", "kind", 1, &i32s((0..cells.len()).map(|i| usize::from(i >= n_elements))));
    let mut groups: Vec<&str> = Vec::new();
    let group_of = s.elements.iter().filter(|e| !e.nodes.is_empty()).map(|e| {
        groups.iter().position(|g| *g == e.group).unwrap_or_else(|| {
            groups.push(&e.group);
            groups.len() - 1
        })
    });
    let numbers: Vec<usize> = group_of.collect();
    array(&mut cell, "Int32", "group", 1, &i32s(numbers.iter().copied().chain(links.iter().map(|_| groups.len()))));
    for field in &s.fields {
        match field.on {
            Carrier::Nodes => array(&mut point, "Float32", &field.name, 1, &f32s(field.values.0.iter().copied())),
            Carrier::Elements => {
                let own = s.elements.iter().zip(&field.values.0).filter(|(e, _)| !e.nodes.is_empty()).map(|(_, v)| *v);
                array(&mut cell, "Float32", &field.name, 1, &f32s(own.chain(links.iter().map(|_| f32::NAN))));
            }
            Carrier::Sensors => {}
        }
    }
    mesh(s.nodes.iter().map(|n| n.position), &cells, &point, &cell)
}

/// Sensors as points, trace lines as cells (every sensor a vertex where there are none).
fn sensors(s: &Structure, re: &Floats, im: Option<&Floats>) -> String {
    let segments: Vec<[usize; 2]> = s.trace_lines.iter().flat_map(|l| l.windows(2).map(|w| [w[0], w[1]])).collect();
    let vertices: Vec<[usize; 1]> = (0..s.sensors.len()).map(|i| [i]).collect();
    let cells: Vec<&[usize]> = if segments.is_empty() {
        vertices.iter().map(<[usize; 1]>::as_slice).collect()
    } else {
        segments.iter().map(<[usize; 2]>::as_slice).collect()
    };
    let vectors = |values: &Floats| {
        f32s(s.sensors.iter().zip(&values.0).flat_map(|(sensor, v)| {
            let v = if sensor.is_rotation || !v.is_finite() { 0.0 } else { *v };
            sensor.direction.map(|d| d as f32 * v)
        }))
    };
    let mut point = String::new();
    array(&mut point, "Float32", "displacement", 3, &vectors(re));
    if let Some(im) = im {
        array(&mut point, "Float32", "displacement_imag", 3, &vectors(im));
    }
    array(&mut point, "Float32", "reading", 1, &f32s(re.0.iter().copied()));
    for field in s.fields.iter().filter(|f| f.on == Carrier::Sensors) {
        array(&mut point, "Float32", &field.name, 1, &f32s(field.values.0.iter().copied()));
    }
    mesh(s.sensors.iter().map(|x| x.position), &cells, &point, "")
}

#[cfg(test)]
mod tests {
    use super::super::fixture::wing;
    use super::*;

    #[test]
    fn the_wing_gives_its_files() {
        let files = paraview(&wing::report()).unwrap();
        let names: Vec<&str> = files.iter().map(|f| f.name.as_str()).collect();
        assert_eq!(names.len(), 1 + 8 + 1 + 6 + 1);
        assert!(names.contains(&"model_modes.pvd") && names.contains(&"test_mode_006.vtu"));
        let model = &files[1].content;
        assert!(model.contains("NumberOfPoints=\"17\" NumberOfCells=\"24\""));
        assert!(model.contains("Name=\"localisation error\""));
        assert_eq!(files[9].content.matches("<DataSet").count(), 8);
        assert!(paraview(&ReportData::default()).unwrap().is_empty());
    }

    #[test]
    fn an_array_carries_its_length() {
        let mut out = String::new();
        array(&mut out, "Float32", "a<b", 1, &f32s([1.0]));
        // 4 (length) then 1.0f32: 04 00 00 00 00 00 80 3f
        assert!(out.contains(">BAAAAAAAgD8=<") && out.contains("a&lt;b"));
    }
}
