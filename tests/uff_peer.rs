//! Universal files exchanged with pyuff (ladisk/pyuff, MIT), an independent reader and writer in Python, and arrays
//! with numpy.
//!
//! Needs `python3` (or what `RETUNE_PYTHON` names) with pyuff and numpy; without them the tests are skipped with a
//! message, unless `RETUNE_PEERS=1` demands them.

use retune::data::npy;
use retune::data::uff::{
    Abscissa, AnalysisData, Axis, ByteOrder, CoordinateSystem, DataAtNodes, Dataset, Element, Entity, Entry,
    FloatFormat, Function, Header, Node, Ordinate, Part, PartSystem, Precision, Stamp, Storage, TraceLine, Units,
    UniversalFile, read, write,
};
use retune::linalg::Complex;
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn python(arguments: &[&str]) -> std::io::Result<Output> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/peers/pyuff_roundtrip.py");
    let program = std::env::var("RETUNE_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    Command::new(program).arg(script).args(arguments).output()
}

/// Whether pyuff can be asked.
fn peer_is_there() -> bool {
    let answer = python(&["probe"]);
    if answer.as_ref().is_ok_and(|o| o.status.success()) {
        return true;
    }
    assert!(std::env::var("RETUNE_PEERS").as_deref() != Ok("1"), "RETUNE_PEERS=1, but pyuff does not run: {answer:?}");
    eprintln!("skipped: python3 with pyuff and numpy is not there");
    false
}

fn run(arguments: &[&str]) {
    let output = python(arguments).unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(output.status.success(), "{}{}", text(&output.stdout), text(&output.stderr));
    print!("{}", text(&output.stdout));
}

fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&path).unwrap();
    path
}

/// A dataset with the keys of pyuff.
fn as_pyuff(dataset: &Dataset) -> Value {
    let mut set = match dataset {
        Dataset::Nodes15(nodes) | Dataset::Nodes2411(nodes) => nodes_as_pyuff(nodes),
        Dataset::Elements(elements) => {
            let row = |e: &Element| {
                [vec![e.label, e.descriptor, e.physical_table, e.material_table, e.color], e.nodes.clone()].concat()
            };
            let mut rows: Vec<Vec<i64>> = elements.iter().map(row).collect();
            rows.sort();
            json!({ "elements": rows })
        }
        Dataset::TraceLine(t) => json!({ "trace_num": t.number, "color": t.color, "id": t.name, "nodes": t.nodes }),
        Dataset::CoordinateSystems(systems) => json!({
            "cs_num": systems.iter().map(|s| s.number).collect::<Vec<_>>(),
            "cs_type": systems.iter().map(|s| s.kind).collect::<Vec<_>>(),
            "ref_cs_num": systems.iter().map(|s| s.reference).collect::<Vec<_>>(),
            "color": systems.iter().map(|s| s.color).collect::<Vec<_>>(),
            "method": systems.iter().map(|s| s.method).collect::<Vec<_>>(),
            "cs_name": systems.iter().map(|s| s.name.clone()).collect::<Vec<_>>(),
            "ref_o": systems.iter().map(|s| s.points[0]).collect::<Vec<_>>(),
            "x_point": systems.iter().map(|s| s.points[1]).collect::<Vec<_>>(),
            "xz_point": systems.iter().map(|s| s.points[2]).collect::<Vec<_>>(),
        }),
        Dataset::Part(part) => json!({
            "Part_UID": part.uid,
            "Part_Name": part.name,
            "CS_sys_labels": part.systems.iter().map(|s| s.label).collect::<Vec<_>>(),
            "CS_types": part.systems.iter().map(|s| s.kind).collect::<Vec<_>>(),
            "CS_colors": part.systems.iter().map(|s| s.color).collect::<Vec<_>>(),
            "CS_names": part.systems.iter().map(|s| s.name.clone()).collect::<Vec<_>>(),
            "CS_matrices": part.systems.iter().map(|s| s.rows).collect::<Vec<_>>(),
        }),
        Dataset::Header(h) => json!({
            "model_name": h.model_name, "description": h.description, "db_app": h.database_program,
            "date_db_created": h.created.date, "time_db_created": h.created.time, "date_db_saved": h.saved.date,
            "time_db_saved": h.saved.time, "program": h.program, "date_file_written": h.written.date,
            "time_file_written": h.written.time,
        }),
        Dataset::Units(u) => json!({
            "units_code": u.code, "units_description": u.description, "temp_mode": u.temperature_mode,
            "length": u.length, "force": u.force, "temp": u.temperature, "temp_offset": u.temperature_offset,
        }),
        Dataset::DataAtNodes(d) => shape_as_pyuff(d),
        Dataset::AnalysisData(d) => json!({
            "analysis_dataset_label": d.label, "analysis_dataset_name": d.name, "dataset_location": d.location,
            "id1": d.ids[0], "model_type": d.model_type, "analysis_type": d.analysis_type,
            "data_characteristic": d.characteristic, "result_type": d.result_type, "data_type": d.data_type,
            "number_of_data_values_for_the_data_component": d.values_per_component,
            "frequency": d.reals[1], "frequency_number": d.integers[7], "load_set": d.integers[4],
            "node_nums": d.entries.iter().map(|e| e.head[0]).collect::<Vec<_>>(),
            "x": component(&d.entries, 0, true), "y": component(&d.entries, 1, true),
            "z": component(&d.entries, 2, true),
        }),
        Dataset::Function(f) => function_as_pyuff(f),
        // pyuff does not know these.
        Dataset::Qualifiers(_) | Dataset::Unknown { .. } => json!({}),
    };
    set["type"] = json!(dataset.number());
    set
}

fn nodes_as_pyuff(nodes: &[Node]) -> Value {
    json!({
        "node_nums": nodes.iter().map(|n| n.label).collect::<Vec<_>>(),
        "def_cs": nodes.iter().map(|n| n.definition_cs).collect::<Vec<_>>(),
        "disp_cs": nodes.iter().map(|n| n.displacement_cs).collect::<Vec<_>>(),
        "color": nodes.iter().map(|n| n.color).collect::<Vec<_>>(),
        "x": nodes.iter().map(|n| n.position[0]).collect::<Vec<_>>(),
        "y": nodes.iter().map(|n| n.position[1]).collect::<Vec<_>>(),
        "z": nodes.iter().map(|n| n.position[2]).collect::<Vec<_>>(),
    })
}

/// One component at all nodes.
fn component(entries: &[Entry], i: usize, is_complex: bool) -> Value {
    let part = |offset: usize, per: usize| entries.iter().map(|e| e.values[per * i + offset]).collect::<Vec<_>>();
    if is_complex { json!({ "re": part(0, 2), "im": part(1, 2) }) } else { json!(part(0, 1)) }
}

fn shape_as_pyuff(d: &DataAtNodes) -> Value {
    let mut set = Map::new();
    for (i, id) in d.ids.iter().enumerate() {
        set.insert(format!("id{}", i + 1), json!(id));
    }
    let pair = |i: usize| json!({ "re": d.reals[i], "im": d.reals[i + 1] });
    for (key, value) in [
        ("model_type", json!(d.model_type)),
        ("analysis_type", json!(d.analysis_type)),
        ("data_ch", json!(d.characteristic)),
        ("spec_data_type", json!(d.specific_type)),
        ("load_case", json!(d.integers[0])),
        ("mode_n", json!(d.integers[1])),
        ("node_nums", json!(d.entries.iter().map(|e| e.head[0]).collect::<Vec<_>>())),
    ] {
        set.insert(key.to_owned(), value);
    }
    let parameters = match d.analysis_type {
        2 => vec![
            ("freq", json!(d.reals[0])),
            ("modal_m", json!(d.reals[1])),
            ("modal_damp_vis", json!(d.reals[2])),
            ("modal_damp_his", json!(d.reals[3])),
        ],
        _ => vec![("eig", pair(0)), ("modal_a", pair(2)), ("modal_b", pair(4))],
    };
    set.extend(parameters.into_iter().map(|(key, value)| (key.to_owned(), value)));
    for i in 0..usize::try_from(d.values_per_node).unwrap() {
        set.insert(format!("r{}", i + 1), component(&d.entries, i, d.data_type == 5));
    }
    Value::Object(set)
}

fn function_as_pyuff(f: &Function) -> Value {
    let data = match &f.ordinate {
        Ordinate::Real(v) => json!(v),
        Ordinate::Complex(v) => json!({
            "re": v.iter().map(|z| z.re).collect::<Vec<_>>(), "im": v.iter().map(|z| z.im).collect::<Vec<_>>()
        }),
    };
    json!({
        "id1": f.ids[0], "id5": f.ids[4], "func_type": f.function_type, "ver_num": f.version,
        "load_case_id": f.load_case, "rsp_ent_name": f.response.name, "rsp_node": f.response.node,
        "rsp_dir": f.response.direction, "ref_ent_name": f.reference.name, "ref_node": f.reference.node,
        "ref_dir": f.reference.direction, "x": f.points(), "data": data,
        "abscissa_spacing": i32::from(matches!(f.abscissa, Abscissa::Even { .. })),
        "binary": i32::from(f.storage != Storage::Ascii),
        "abscissa_spec_data_type": f.axes[0].data_type, "ordinate_spec_data_type": f.axes[1].data_type,
        "orddenom_spec_data_type": f.axes[2].data_type, "ordinate_axis_units_lab": f.axes[1].units,
    })
}

/// Files of ours with numbers that their columns hold.
fn our_files() -> Vec<(String, Vec<Dataset>)> {
    let node = |label, x| Node { label, definition_cs: 0, displacement_cs: 1, color: 8, position: [x, -0.5 * x, 1.25] };
    let nodes = vec![node(1, 0.25), node(2, -51.619), node(12_345_678, 1.0e-17)];
    let exact = vec![node(1, 1.0 / 3.0), node(2, -std::f64::consts::PI * 1.0e-9), node(3, 1.0e300)];
    let stamp = |time: &str| Stamp { date: "03-Jan-20".into(), time: time.into(), rest: String::new() };
    let header = Header {
        model_name: "wing".into(),
        description: "a test".into(),
        database_program: "retune".into(),
        created: Stamp { rest: "         1         2         0".into(), ..stamp("10:11:12") },
        saved: stamp("10:11:13"),
        program: "retune".into(),
        written: stamp("10:11:14"),
    };
    let units = Units {
        code: 9,
        description: "user defined".into(),
        temperature_mode: 2,
        length: 1.0 / 0.0254,
        force: 0.224_808_943_099_710_48,
        temperature: 1.8,
        temperature_offset: 459.67,
    };
    let element = |label, descriptor, nodes: Vec<i64>| Element {
        label,
        descriptor,
        physical_table: 1,
        material_table: 2,
        color: 7,
        beam: (descriptor == 11).then_some([0, 1, 1]),
        nodes,
    };
    let elements = vec![element(1, 44, vec![1, 2, 3, 4]), element(2, 11, vec![1, 2]), element(3, 91, vec![2, 3, 4])];
    let trace = TraceLine { number: 1, color: 3, name: "an outline".into(), nodes: (1..20).chain([0, 4, 5]).collect() };
    let system = CoordinateSystem {
        number: 4,
        kind: 0,
        reference: 0,
        color: 8,
        method: 1,
        name: "SYS4".into(),
        points: [[2.4, -0.95, 0.0], [1.4, -0.95, -8.74228e-8], [1.4, -0.95, -1.0]],
    };
    let rows = [[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0], [1.0 / 3.0, 2.0, 3.0]];
    let part_system = PartSystem { label: 1, kind: 1, color: 8, name: "CS1".into(), rows };
    let part = Part { uid: 1, name: "part".into(), systems: vec![part_system] };
    let mut files = vec![(
        "all.uff".to_owned(),
        vec![
            Dataset::Header(header),
            Dataset::Units(units),
            Dataset::CoordinateSystems(vec![system]),
            Dataset::Part(part),
            Dataset::Nodes15(nodes),
            Dataset::Nodes2411(exact),
            Dataset::Elements(elements),
            Dataset::TraceLine(trace),
            shape(2, false, 3),
            shape(2, false, 6),
            shape(3, true, 3),
            analysis(),
        ],
    )];
    let storages = [
        Storage::Ascii,
        Storage::Binary { order: ByteOrder::Little, format: FloatFormat::Ieee },
        Storage::Binary { order: ByteOrder::Big, format: FloatFormat::Ieee },
    ];
    for i in 0..24 {
        let (storage, precision) = (storages[i % 3], [Precision::Single, Precision::Double][i / 3 % 2]);
        let function = function(storage, precision, i / 6 % 2 == 0, i / 12 == 0);
        files.push((format!("function_{i:02}.uff"), vec![Dataset::from(function)]));
    }
    files
}

fn shape(analysis_type: i64, is_complex: bool, width: usize) -> Dataset {
    let n = if is_complex { 2 * width } else { width };
    let entry = |label: i64| Entry {
        head: vec![label],
        values: (0..n).map(|i| (i as f64 - 2.0) * 0.125 + label as f64).collect(),
    };
    Dataset::DataAtNodes(DataAtNodes {
        ids: ["a shape", "NONE", "NONE", "NONE", "NONE"].map(String::from),
        model_type: 1,
        analysis_type,
        characteristic: if width == 3 { 2 } else { 3 },
        specific_type: 8,
        data_type: if is_complex { 5 } else { 2 },
        values_per_node: width as i64,
        integers: vec![1, 4],
        reals: if is_complex { vec![-1.5, 100.25, 2.0, 3.0, 0.5, -4.0] } else { vec![18.25, 2.5, 0.0125, 0.0] },
        entries: vec![entry(1), entry(2), entry(30)],
    })
}

fn analysis() -> Dataset {
    Dataset::AnalysisData(AnalysisData {
        label: 1,
        name: "response".into(),
        location: 1,
        ids: ["NONE", "NONE", "NONE", "NONE", "NONE"].map(String::from),
        model_type: 1,
        analysis_type: 5,
        characteristic: 2,
        result_type: 8,
        data_type: 5,
        values_per_component: 3,
        integers: vec![1, 2, 3, 4, 5, 6, 7, 8, 9, 10],
        reals: [0.0, 12.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        entries: vec![
            Entry { head: vec![1], values: vec![1.0, -2.0, 0.25, 0.0, 3.5, -0.125] },
            Entry { head: vec![7], values: vec![0.5, 1.5, 2.5, 3.5, 4.5, 5.5] },
        ],
    })
}

fn function(storage: Storage, precision: Precision, is_even: bool, is_complex: bool) -> Function {
    const N: i32 = 23;
    // Text: the digits of the columns. Binary: every bit, also of numbers that look like an end mark in text.
    let value = |i: f64| match (storage, precision) {
        (Storage::Ascii, Precision::Single) => (i * 1234.0 - 7000.0) / 64.0,
        (Storage::Ascii, Precision::Double) => (i * 123_456_789.0 - 1.0e9) / 1.0e5,
        (_, Precision::Single) => f64::from(((i * 0.37).sin() * 1.0e-3) as f32),
        (_, Precision::Double) => (i * 0.37).sin() / 3.0,
    };
    let n = 0..N;
    let end = |name: &str, node| Entity { name: name.into(), node, direction: -3 };
    let mut axes = [18, 12, 13, 0].map(Axis::of);
    axes[1].units = "m/s^2".into();
    let x = n.clone().map(|i| 2.0 + 0.25 * f64::from(i) + 0.125 * f64::from(i % 2));
    Function {
        ids: ["a function", "NONE", "NONE", "NONE", "NONE"].map(String::from),
        function_type: if is_complex { 4 } else { 1 },
        function_id: 0,
        version: 2,
        load_case: 0,
        response: end("WING", 12),
        reference: end("NONE", 1),
        precision,
        abscissa: if is_even { Abscissa::Even { start: 2.0, step: 0.25 } } else { Abscissa::Uneven(x.collect()) },
        ordinate: if is_complex {
            Ordinate::Complex(n.map(|i| Complex::new(value(f64::from(i)), value(f64::from(i) + 0.5))).collect())
        } else {
            Ordinate::Real(n.map(|i| value(f64::from(i))).collect())
        },
        z_value: 0.0,
        axes,
        storage,
    }
}

#[test]
fn pyuff_reads_what_we_write() {
    if !peer_is_there() {
        return;
    }
    let folder = folder("uff_written");
    let mut expected = Map::new();
    for (name, datasets) in our_files() {
        expected.insert(name.clone(), datasets.iter().map(as_pyuff).collect());
        let (bytes, lost) = write(&UniversalFile { datasets }).unwrap();
        assert!(lost.is_empty(), "{name}: {lost:?}");
        std::fs::write(folder.join(name), bytes).unwrap();
    }
    std::fs::write(folder.join("written.json"), Value::Object(expected).to_string()).unwrap();
    let values = (0..6).map(|i| Complex::new(f64::from(i) / 3.0, -f64::from(i))).collect();
    let array = npy::Array { shape: vec![2, 3], values: npy::Values::Complex(values) };
    std::fs::write(folder.join("array.npy"), npy::write(&array)).unwrap();
    run(&["check", folder.to_str().unwrap()]);
}

/// Whether all that pyuff says of a set is what we read; numbers within the rounding of the JSON reader.
fn agrees(ours: &Value, theirs: &Value) -> bool {
    match (ours, theirs) {
        (Value::Array(a), Value::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(x, y)| agrees(x, y)),
        (Value::Object(a), Value::Object(b)) => b.iter().all(|(key, y)| a.get(key).is_some_and(|x| agrees(x, y))),
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
            (a - b).abs() <= f64::EPSILON * a.abs()
        }
        _ => ours == theirs,
    }
}

#[test]
fn we_read_what_pyuff_writes() {
    if !peer_is_there() {
        return;
    }
    let folder = folder("uff_made");
    run(&["make", folder.to_str().unwrap()]);
    let array = npy::read(&std::fs::read(folder.join("array.npy")).unwrap()).unwrap();
    let thirds = (0..6_u8).map(|i| f64::from(f32::from(i) / 3.0)).collect();
    assert_eq!(array, npy::Array { shape: vec![2, 3], values: npy::Values::Real(thirds) });
    let made: Map<String, Value> =
        serde_json::from_str(&std::fs::read_to_string(folder.join("made.json")).unwrap()).unwrap();
    for (name, sets) in made {
        let (file, _) = read(&std::fs::read(folder.join(&name)).unwrap()).unwrap();
        let sets = sets.as_array().unwrap();
        assert_eq!(file.datasets.len(), sets.len(), "{name}");
        for (dataset, theirs) in file.datasets.iter().zip(sets) {
            let ours = as_pyuff(dataset);
            for (key, value) in theirs.as_object().unwrap() {
                // Keys of pyuff's own bookkeeping have no counterpart.
                if let Some(own) = ours.get(key) {
                    assert!(agrees(own, value), "{name}.{key}: ours {own}, theirs {value}");
                }
            }
        }
    }
}
