//! Samples of other programs, round trips of random files, and hostile input.

use super::*;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use retune_linalg::Complex;

/// The sample files (format fixtures of ladisk/pyuff, MIT), when they are on this machine.
fn samples() -> Vec<(String, Vec<u8>)> {
    let Some(folder) = crate::data::shared_data("uff_samples") else { return Vec::new() };
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    paths.sort();
    paths
        .into_iter()
        .map(|p| (p.file_name().unwrap().to_string_lossy().into_owned(), std::fs::read(&p).unwrap()))
        .filter(|(name, _)| name != "SOURCE.md" && !name.starts_with("LICENSE"))
        .collect()
}

fn sample(name: &str) -> Option<UniversalFile> {
    let (_, bytes) = samples().into_iter().find(|(n, _)| n.starts_with(name))?;
    Some(read(&bytes).unwrap().0)
}

fn function(file: &UniversalFile) -> &Function {
    let found = file.datasets.iter().find_map(|d| match d {
        Dataset::Function(f) => Some(f),
        _ => None,
    });
    found.expect("a dataset 58")
}

#[test]
fn every_sample_is_read_or_explained_and_comes_back_after_writing() {
    for (name, bytes) in samples() {
        match read(&bytes) {
            Ok((file, notes)) => {
                let numbers: Vec<_> = file.datasets.iter().map(Dataset::number).collect();
                println!("{name}: {numbers:?}");
                for note in &notes {
                    println!("    {note}");
                }
                assert!(notes.iter().all(|n| n.level < Level::Error), "{name}");
                let (written, _) = write(&file).unwrap();
                let (again, _) = read(&written).unwrap();
                assert_eq!(file, again, "{name}");
            }
            Err(error) => {
                println!("{name}: {error}");
                // Three files are lists of complex numbers as Python prints them.
                assert!(name.starts_with("meas_point"), "{name}");
            }
        }
    }
}

/// Numbers printed by pyuff 2.5.8 for the same files.
#[test]
fn samples_have_the_values_that_pyuff_reads() {
    let Some(file) = sample("Sample_UFF58b_bin") else { return };
    let f = function(&file);
    let Ordinate::Real(y) = &f.ordinate else { panic!("real") };
    assert_eq!((f.function_type, y.len(), f.axes[1].units.as_str()), (1, 79292, "Pa"));
    assert_eq!((y[0], y[1], y[79291]), (-0.014755260199308395, -0.017295705154538155, -0.004314688965678215));
    assert_eq!(f.points()[79291], 1.2098855108);
    assert_eq!(f.response, Entity { name: "Mic 01".into(), node: 0, direction: 1 });

    let file = sample("binary8byte").unwrap();
    let f = function(&file);
    let Ordinate::Real(y) = &f.ordinate else { panic!("real") };
    assert_eq!(
        (f.precision, y.len(), f.response.node, f.response.name.as_str()),
        (Precision::Double, 250, 1, "sine 5 Hz")
    );
    assert_eq!((y[1], y[249]), (0.30901697278022766, 0.3090193569660187));

    let file = sample("sample_dataset58_psd").unwrap();
    let f = function(&file);
    let y = f.ordinate.to_complex();
    assert_eq!((f.function_type, y.len(), f.axes[1].units.as_str()), (9, 3201, "g²/Hz"));
    assert_eq!((f.points()[3200], y[3200]), (3200.0, Complex::new(2.634827e-10, 0.0)));

    let file = sample("non_ascii_header").unwrap();
    let f = function(&file);
    assert_eq!((f.function_type, f.axes[1].units.as_str()), (4, "(1/N)*(m/s²)"));
    assert_eq!(f.ordinate.to_complex()[5], Complex::new(3.75037, 2.93363));

    let file = sample("time-history").unwrap();
    let f = function(&file);
    assert_eq!((f.ordinate.len(), f.axes[1].units.as_str()), (13, "m/s²"));
    assert_eq!(f.ordinate.to_complex()[12].re, -5.84096);

    let file = sample("uff55 sample_test record10").unwrap();
    let Dataset::DataAtNodes(d) = &file.datasets[0] else { panic!("55") };
    assert_eq!(d.reals[..4], [-0.1111111, 41.11111, 4111.111, -3111.111]);
    assert_eq!(d.entries[1], Entry { head: vec![60101], values: vec![0.0, 0.0, 0.0, 0.0, -0.04111111, -0.01111111] });

    let file = sample("heat_engine").unwrap();
    let Dataset::Units(u) = &file.datasets[1] else { panic!("164") };
    assert_eq!((u.code, u.length, u.temperature_mode, u.temperature_offset), (5, 1000.0, 2, 273.15));
    let Dataset::AnalysisData(a) = &file.datasets[4] else { panic!("2414") };
    assert_eq!((a.entries.len(), a.entries[6].values[0]), (10, 24.9976));

    let file = sample("TestLab").unwrap();
    let Dataset::TraceLine(t) = &file.datasets[4] else { panic!("82") };
    assert_eq!((t.name.as_str(), &t.nodes[..]), ("Massif", &[2, 5, 6, 3, 4, 1, 2, 3, 0][..]));
    let Dataset::CoordinateSystems(c) = &file.datasets[2] else { panic!("18") };
    assert_eq!((c.len(), c[35].number, c[0].points[1]), (36, 36, [-3.4, -0.95, -8.74228e-8]));
}

fn text() -> impl Strategy<Value = String> {
    "[A-Za-z0-9²µ°()/:.-][A-Za-z0-9²µ°()/ :.-]{0,17}".prop_map(|s| s.trim().to_owned())
}

fn name() -> impl Strategy<Value = String> {
    "[A-Za-z][A-Za-z0-9²]{0,9}"
}

fn label() -> impl Strategy<Value = i64> {
    -99_999_999..10_000_000_000_i64
}

/// A number with so many significant digits.
fn decimal(digits: u32) -> impl Strategy<Value = f64> {
    (-10_i64.pow(digits) + 1..10_i64.pow(digits), -30..30_i32)
        .prop_map(|(mantissa, exponent)| format!("{mantissa}E{exponent}").parse().unwrap())
}

/// Any finite number.
fn finite() -> impl Strategy<Value = f64> {
    any::<u64>().prop_map(f64::from_bits).prop_filter("finite", |v| v.is_finite())
}

fn single() -> impl Strategy<Value = f64> {
    any::<u32>().prop_map(f32::from_bits).prop_filter("finite", |v| v.is_finite()).prop_map(f64::from)
}

fn node(x: impl Strategy<Value = f64>) -> impl Strategy<Value = Node> {
    let position = prop::collection::vec(x, 3).prop_map(|v| [v[0], v[1], v[2]]);
    (label(), label(), label(), 0..20_i64, position).prop_map(
        |(label, definition_cs, displacement_cs, color, position)| Node {
            label,
            definition_cs,
            displacement_cs,
            color,
            position,
        },
    )
}

fn axis() -> impl Strategy<Value = Axis> {
    (0..99_i64, -3..4_i64, name(), name()).prop_map(|(data_type, e, label, units)| Axis {
        data_type,
        length_exponent: e,
        force_exponent: -e,
        temperature_exponent: 0,
        label,
        units,
    })
}

fn entity() -> impl Strategy<Value = Entity> {
    (name(), label(), -6..7_i64).prop_map(|(name, node, direction)| Entity { name, node, direction })
}

/// Functions in every combination of storage, precision, spacing and kind of ordinate, with numbers that their
/// columns or bytes hold exactly.
fn function_strategy() -> impl Strategy<Value = Function> {
    (0..3_usize, any::<bool>(), any::<bool>(), any::<bool>()).prop_flat_map(|(storage, double, even, complex)| {
        let storage = [
            Storage::Ascii,
            Storage::Binary { order: ByteOrder::Little, format: FloatFormat::Ieee },
            Storage::Binary { order: ByteOrder::Big, format: FloatFormat::Ieee },
        ][storage];
        let ordinate = match (storage, double) {
            (Storage::Ascii, true) => decimal(13).boxed(),
            (Storage::Ascii, false) => decimal(6).boxed(),
            (_, true) => finite().boxed(),
            (_, false) => single().boxed(),
        };
        let abscissa = if storage == Storage::Ascii { decimal(6).boxed() } else { ordinate.clone() };
        let precision = if double { Precision::Double } else { Precision::Single };
        let points = prop::collection::vec((abscissa, ordinate.clone(), ordinate), 1..20);
        let ids = prop::array::uniform5(text());
        let axes = prop::array::uniform4(axis());
        let head = (0..40_i64, 0..100_i64, 0..100_i64, 0..9_i64, decimal(6), decimal(6));
        (ids, axes, head, entity(), entity(), points).prop_map(move |(ids, axes, head, response, reference, points)| {
            let (function_type, function_id, version, load_case, start, step) = head;
            Function {
                ids,
                function_type,
                function_id,
                version,
                load_case,
                response,
                reference,
                precision,
                abscissa: if even {
                    Abscissa::Even { start, step }
                } else {
                    Abscissa::Uneven(points.iter().map(|p| p.0).collect())
                },
                ordinate: if complex {
                    Ordinate::Complex(points.iter().map(|p| Complex::new(p.1, p.2)).collect())
                } else {
                    Ordinate::Real(points.iter().map(|p| p.1).collect())
                },
                z_value: step,
                axes,
                storage,
            }
        })
    })
}

/// Half as many reals as complex values need at every node are real values.
#[test]
fn real_values_that_are_announced_as_complex_are_read_as_real() {
    let entries =
        (1..4).map(|node| Entry { head: vec![node], values: vec![0.1, 0.2, f64::from(node as u8)] }).collect();
    let data = DataAtNodes {
        ids: std::array::from_fn(|_| "mode".to_string()),
        model_type: 1,
        analysis_type: 2,
        characteristic: 2,
        specific_type: 8,
        data_type: 5,
        values_per_node: 3,
        integers: vec![0, 1],
        reals: vec![12.0, 1.0, 0.0, 0.0],
        entries,
    };
    let (text, _) = write(&UniversalFile { datasets: vec![Dataset::DataAtNodes(data.clone())] }).unwrap();
    let (file, notes) = read(&text).unwrap();
    assert_eq!(file.datasets, [Dataset::DataAtNodes(DataAtNodes { data_type: 2, ..data.clone() })]);
    assert!(notes.iter().any(|n| n.to_string().contains("read as real")), "{notes:?}");
    // A single node that is cut short is no sign of that.
    let mut cut = data;
    for entry in &mut cut.entries {
        entry.values.resize(6, 0.5);
    }
    cut.entries[1].values.truncate(3);
    let (text, _) = write(&UniversalFile { datasets: vec![Dataset::DataAtNodes(cut.clone())] }).unwrap();
    let (file, notes) = read(&text).unwrap();
    assert_eq!(file.datasets, [Dataset::DataAtNodes(cut)]);
    assert!(notes.iter().any(|n| n.to_string().contains("label 2")), "{notes:?}");
}

fn shape_strategy() -> impl Strategy<Value = Dataset> {
    (1..7_usize, any::<bool>(), prop::array::uniform5(text()), 0..13_usize, 1..11_usize).prop_flat_map(
        |(n, complex, ids, n_reals, n_integers)| {
            let width = if complex { 2 * n } else { n };
            let entry = (0..99_999_i64, prop::collection::vec(decimal(6), width))
                .prop_map(|(label, values)| Entry { head: vec![label], values });
            let parts = (
                prop::collection::vec(entry, 0..5),
                prop::collection::vec(decimal(6), n_reals),
                prop::collection::vec(0..99_i64, n_integers),
            );
            parts.prop_map(move |(entries, reals, integers)| {
                Dataset::DataAtNodes(DataAtNodes {
                    ids: ids.clone(),
                    model_type: 1,
                    analysis_type: 3,
                    characteristic: 2,
                    specific_type: 8,
                    data_type: if complex { 5 } else { 2 },
                    values_per_node: n as i64,
                    integers,
                    reals,
                    entries,
                })
            })
        },
    )
}

fn analysis_strategy() -> impl Strategy<Value = Dataset> {
    let entry = (0..99_999_i64, prop::collection::vec(decimal(6), 6))
        .prop_map(|(label, values)| Entry { head: vec![label], values });
    let parts = (prop::collection::vec(entry, 0..5), prop::collection::vec(decimal(6), 12), text(), label());
    parts.prop_map(|(entries, reals, name, label)| {
        Dataset::AnalysisData(AnalysisData {
            label,
            name,
            location: 1,
            ids: std::array::from_fn(|i| format!("line {i}")),
            model_type: 1,
            analysis_type: 2,
            characteristic: 2,
            result_type: 8,
            data_type: 5,
            values_per_component: 3,
            integers: vec![1, 2, 3, 4, 5, 6, 7, 8, 9, 10],
            reals: std::array::from_fn(|i| reals[i]),
            entries,
        })
    })
}

fn dataset() -> impl Strategy<Value = Dataset> {
    let nodes_15 = prop::collection::vec(node(decimal(6)), 0..9).prop_map(Dataset::Nodes15);
    let nodes_2411 = prop::collection::vec(node(finite()), 0..9).prop_map(Dataset::Nodes2411);
    let trace = (label(), text(), prop::collection::vec(1..9999_i64, 0..30))
        .prop_map(|(number, name, nodes)| Dataset::TraceLine(TraceLine { number, color: 3, name, nodes }));
    let element =
        (label(), 11..30_i64, prop::collection::vec(label(), 1..21)).prop_map(|(label, descriptor, nodes)| {
            let beam = matches!(descriptor, 11 | 21..=24).then_some([1, 2, 3]);
            Element { label, descriptor, physical_table: 1, material_table: 2, color: 7, beam, nodes }
        });
    let elements = prop::collection::vec(element, 0..6).prop_map(Dataset::Elements);
    let system = (label(), text(), prop::collection::vec(decimal(6), 9)).prop_map(|(number, name, p)| {
        let points = std::array::from_fn(|i| std::array::from_fn(|j| p[3 * i + j]));
        CoordinateSystem { number, kind: 0, reference: 0, color: 1, method: 1, name, points }
    });
    let systems = prop::collection::vec(system, 0..5).prop_map(Dataset::CoordinateSystems);
    let part_system = (label(), text(), prop::collection::vec(finite(), 12)).prop_map(|(label, name, m)| PartSystem {
        label,
        kind: 1,
        color: 2,
        name,
        rows: std::array::from_fn(|i| std::array::from_fn(|j| m[3 * i + j])),
    });
    let part = (label(), text(), prop::collection::vec(part_system, 0..4))
        .prop_map(|(uid, name, systems)| Dataset::Part(Part { uid, name, systems }));
    let units =
        (1..11_i64, text(), finite(), finite(), finite(), finite()).prop_map(|(code, description, a, b, c, d)| {
            Dataset::Units(Units {
                code,
                description,
                temperature_mode: 1,
                length: a,
                force: b,
                temperature: c,
                temperature_offset: d,
            })
        });
    let stamp = || {
        let date = ("[0-9]{2}-[A-Z][a-z]{2}-[0-9]{2}", "[0-9]{2}:[0-9]{2}:[0-9]{2}");
        (date, "[ 0-9]{0,30}").prop_map(|((date, time), rest)| Stamp { date, time, rest: rest.trim_end().to_owned() })
    };
    let header = (text(), text(), text(), stamp(), stamp(), text(), stamp()).prop_map(|h| {
        let (model_name, description, database_program, created, saved, program, written) = h;
        Dataset::Header(Header { model_name, description, database_program, created, saved, program, written })
    });
    let reals = || prop::collection::vec(decimal(8), 5);
    let numbers = prop::collection::vec(0..99_i64, 18);
    let qualifiers = (numbers, reals(), reals(), reals(), text()).prop_map(|(n, z, user, levels, remark)| {
        let five = |v: Vec<f64>| std::array::from_fn(|i| v[i]);
        Dataset::Qualifiers(Box::new(Qualifiers {
            set: std::array::from_fn(|i| n[i]),
            form: std::array::from_fn(|i| n[6 + i]),
            z: five(z),
            user: five(user),
            levels: five(levels),
            directions: "NONE  NONE".to_owned(),
            remark,
        }))
    });
    let unknown = (3000..4000_i64, prop::collection::vec("[ -~]{0,40}x", 0..5))
        .prop_map(|(number, lines)| Dataset::Unknown { number, lines });
    prop_oneof![
        nodes_15,
        nodes_2411,
        trace,
        elements,
        systems,
        part,
        units,
        header,
        unknown,
        qualifiers,
        shape_strategy(),
        analysis_strategy(),
        function_strategy().prop_map(Dataset::from),
        function_strategy().prop_map(Dataset::from),
    ]
}

proptest! {
    #[test]
    fn what_is_written_is_read_back_equal(datasets in prop::collection::vec(dataset(), 1..6)) {
        let file = UniversalFile { datasets };
        let (bytes, lost) = write(&file).unwrap();
        prop_assert!(lost.is_empty(), "{:?}", lost);
        let (again, notes) = read(&bytes).unwrap();
        prop_assert!(notes.is_empty(), "{:?}", notes);
        prop_assert_eq!(&file, &again);
        // With the line ends of another system.
        if file.datasets.iter().all(|d| !matches!(d, Dataset::Function(f) if f.storage != Storage::Ascii)) {
            let crlf = String::from_utf8(bytes).unwrap().replace('\n', "\r\n");
            prop_assert_eq!(file, read(crlf.as_bytes()).unwrap().0);
        }
    }

    /// Numbers with too many digits are rounded once and then stay.
    #[test]
    fn rounding_happens_once(values in prop::collection::vec((finite(), finite()), 1..20), double in any::<bool>()) {
        let mut f = plain_function(values.len());
        f.precision = if double { Precision::Double } else { Precision::Single };
        f.abscissa = Abscissa::Uneven(values.iter().map(|v| v.0).collect());
        f.ordinate = Ordinate::Real(values.iter().map(|v| v.1).collect());
        let write_read = |f: &Function| {
            let (bytes, notes) = write(&UniversalFile { datasets: vec![Dataset::from(f.clone())] }).unwrap();
            (function(&read(&bytes).unwrap().0).clone(), notes)
        };
        let (once, _) = write_read(&f);
        let (twice, notes) = write_read(&once);
        prop_assert!(notes.is_empty(), "{:?}", notes);
        prop_assert_eq!(&once, &twice);
        let (Ordinate::Real(a), Ordinate::Real(b)) = (&f.ordinate, &once.ordinate) else { panic!("real") };
        // 12 or 19 characters, less sign, point and an exponent of up to five, leave 6 or 13 digits.
        let bound = if double { 0.5e-11 } else { 0.5e-4 };
        for (a, b) in a.iter().zip(b) {
            prop_assert!((a - b).abs() <= bound * a.abs(), "{} {}", a, b);
        }
    }
}

fn plain_function(n: usize) -> Function {
    let end = |node| Entity { name: "NONE".into(), node, direction: 3 };
    Function {
        ids: std::array::from_fn(|_| "NONE".into()),
        function_type: 4,
        function_id: 0,
        version: 0,
        load_case: 0,
        response: end(2),
        reference: end(1),
        precision: Precision::Double,
        abscissa: Abscissa::Even { start: 0.0, step: 0.5 },
        ordinate: Ordinate::Complex((0..n).map(|i| Complex::new(i as f64, -1.0)).collect()),
        z_value: 0.0,
        axes: [Axis::of(18), Axis::of(12), Axis::of(13), Axis::of(0)],
        storage: Storage::Ascii,
    }
}

fn written(datasets: Vec<Dataset>) -> Vec<u8> {
    write(&UniversalFile { datasets }).unwrap().0
}

#[test]
fn a_truncated_record_keeps_the_whole_points() {
    let mut bytes = written(vec![Dataset::from(plain_function(9))]);
    bytes.truncate(bytes.len() - 40);
    let (file, notes) = read(&bytes).unwrap();
    assert_eq!(function(&file).ordinate.len(), 8);
    assert_eq!(notes.len(), 2, "{notes:?}");
}

#[test]
fn a_bad_dataset_does_not_lose_the_others() {
    let mut file = vec![Dataset::from(plain_function(3)); 3];
    file.insert(1, Dataset::Unknown { number: 58, lines: vec!["nothing".into(); 13] });
    let (read_back, notes) = read(&written(file.clone())).unwrap();
    assert_eq!(read_back.datasets, file);
    assert_eq!(notes.iter().filter(|n| n.level == Level::Error).count(), 1);
    assert_eq!(notes[0].dataset, Some(58));
}

#[test]
fn binary_data_survive_wrong_byte_counts_and_line_ends() {
    let mut f = plain_function(50);
    f.storage = Storage::Binary { order: ByteOrder::Big, format: FloatFormat::Ieee };
    let good = written(vec![Dataset::from(f.clone()), Dataset::Header(Header::default())]);
    let announced = b"         800";
    let at = good.windows(12).position(|w| w == announced).unwrap();
    let mut wrong = good.clone();
    wrong[at..at + 12].copy_from_slice(b"        1234");
    let (file, notes) = read(&wrong).unwrap();
    assert_eq!((function(&file), file.datasets.len(), notes.len()), (&f, 2, 1));
    // A line end between the values and the end mark, as some programs write.
    let end = good.windows(6).skip(7).position(|w| w == b"    -1").unwrap() + 7;
    let mut with_line_end = good.clone();
    with_line_end.splice(end..end, *b"\r\n");
    let (file, _) = read(&with_line_end).unwrap();
    assert_eq!((function(&file), file.datasets.len()), (&f, 2));
}

#[test]
fn an_uneven_single_abscissa_beside_binary_doubles_is_recognised() {
    let mut f = plain_function(2);
    f.storage = Storage::Binary { order: ByteOrder::Little, format: FloatFormat::Ieee };
    f.abscissa = Abscissa::Uneven(vec![0.5, 1.5]);
    f.ordinate = Ordinate::Real(vec![0.1, 0.2]);
    let full = written(vec![Dataset::from(f.clone())]);
    let head = full.len() - 32 - 7;
    let mut bytes = full[..head].to_vec();
    for (x, y) in [(0.5_f32, 0.1_f64), (1.5, 0.2)] {
        bytes.extend_from_slice(&x.to_le_bytes());
        bytes.extend_from_slice(&y.to_le_bytes());
    }
    bytes.extend_from_slice(b"    -1\n");
    assert_eq!(function(&read(&bytes).unwrap().0), &f);
}

#[test]
fn labels_too_long_for_their_columns_are_read_by_blanks() {
    let text = "    -1\n    15\n123456789012         0         0         1  1.0E+00  2.0E+00  3.0E+00\n    -1\n";
    let (file, notes) = read(text.as_bytes()).unwrap();
    let Dataset::Nodes15(nodes) = &file.datasets[0] else { panic!("15") };
    assert_eq!((nodes[0].label, nodes[0].position), (123_456_789_012, [1.0, 2.0, 3.0]));
    assert_eq!(notes.len(), 1);
    let too_wide = UniversalFile { datasets: file.datasets };
    assert_eq!(
        write(&too_wide).unwrap_err().to_string(),
        "dataset 15: the integer 123456789012 does not fit in 10 columns; renumber it"
    );

    let mut f = plain_function(1);
    f.response.name = "WING_LEFT_OUTER".into();
    let line = "    4         0    0         0 WING_LEFT_OUTER         2   3 NONE               1   3";
    let (bytes, notes) = write(&UniversalFile { datasets: vec![Dataset::from(f.clone())] }).unwrap();
    assert_eq!(notes.len(), 1);
    let text = String::from_utf8(bytes).unwrap();
    let cut = text.lines().nth(7).unwrap().to_owned();
    let (file, _) = read(text.replace(&cut, line).as_bytes()).unwrap();
    assert_eq!(function(&file), &f);
}

#[test]
fn false_counts_do_not_ask_for_memory() {
    let mut f = plain_function(2);
    f.storage = Storage::Binary { order: ByteOrder::Little, format: FloatFormat::Ieee };
    for storage in [Storage::Ascii, f.storage] {
        f.storage = storage;
        let bytes = written(vec![Dataset::from(f.clone())]);
        let text = bytes.windows(10).position(|w| w == b"         2").unwrap();
        let mut bytes = bytes;
        // The count of record 7 follows the ordinate data type.
        let at = bytes.windows(20).position(|w| w == b"         6         2").unwrap() + 10;
        bytes[at..at + 10].copy_from_slice(b"2000000000");
        assert!(text > 0);
        let (file, _) = read(&bytes).unwrap();
        assert_eq!(function(&file).ordinate.len(), 2);
    }
    let text =
        b"    -1\n  2412\n         1        44         1         1         1 999999999\n         1         2\n    -1\n";
    let (file, notes) = read(text).unwrap();
    assert_eq!((file.datasets.len(), notes.len()), (1, 1));
}

/// Mutates a file: bytes changed, removed, repeated, pieces of other files, counts replaced.
fn mutate(seed: &[u8], other: &[u8], rng: &mut ChaCha8Rng) -> Vec<u8> {
    const WORDS: [&[u8]; 14] = [
        b"    -1\n",
        b"    -1\n    -1\n",
        b"    58b     2     3          11           8\n",
        b"    55 % 1 text\n",
        b"  1858\n",
        b"9999999999",
        b"-1",
        b"\r",
        b"*************",
        b"1.0D+400",
        b"\xff\xfe",
        b"         0",
        b"  2414\n",
        b"\n\n\n",
    ];
    let mut bytes = seed.to_vec();
    for _ in 0..rng.random_range(1..8) {
        if bytes.is_empty() {
            break;
        }
        let at = rng.random_range(0..bytes.len());
        match rng.random_range(0..6) {
            0 => bytes[at] = rng.next_u32() as u8,
            1 => bytes[at] ^= 1 << rng.random_range(0..8),
            2 => {
                let end = (at + rng.random_range(1..200)).min(bytes.len());
                bytes.drain(at..end);
            }
            3 => {
                let from = rng.random_range(0..other.len());
                let end = (from + rng.random_range(1..300)).min(other.len());
                bytes.splice(at..at, other[from..end].iter().copied());
            }
            4 => {
                let word = WORDS[rng.random_range(0..WORDS.len())];
                let end = (at + word.len()).min(bytes.len());
                bytes.splice(at..end, word.iter().copied());
            }
            _ => bytes.truncate(at),
        }
    }
    bytes
}

/// Small files with every dataset.
fn seeds() -> Vec<Vec<u8>> {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let strategy = prop::collection::vec(dataset(), 1..4);
    let random = (0..60).map(|_| written(strategy.new_tree(&mut runner).unwrap().current()));
    // The ends of the larger samples add nothing.
    let real = samples().into_iter().map(|(_, mut bytes)| {
        bytes.truncate(4000);
        bytes
    });
    random.chain(real).collect()
}

/// What a file means is found or refused, with whatever units.
fn make_sense_of(file: &UniversalFile) {
    use crate::data::convert::{self, Duplicates, FrfOptions, LocalAxes, UnitSystem, UnitsFrom};
    let options = FrfOptions {
        units: UnitSystem::from_name("SI").map_or(UnitsFrom::File, UnitsFrom::System),
        quantity: Some(crate::data::FrfQuantity::Accelerance),
        duplicates: Duplicates::Last,
        frequency_unit: crate::units::FrequencyUnit::of_label("Hz"),
        local_axes: None,
    };
    if let Ok(mut import) = convert::frfs(&[file], &options) {
        import.frfs.drop_empty_lines();
        crate::data::skew::combine_functions(&mut import.frfs);
        assert_eq!(
            import.frfs.h.len(),
            import.frfs.n_lines() * import.frfs.references.len() * import.frfs.responses.len()
        );
    }
    if let Ok((mut modes, _)) = convert::modes(&[file], &options) {
        crate::data::skew::combine_modes(&mut modes);
        assert!(modes.modes.iter().all(|m| m.shape.len() == modes.channels.len()));
    }
    let _ = convert::geometry(&[file], &options.units, Some(LocalAxes::Columns));
}

/// 20,000 mutated files; `RETUNE_FUZZ_CASES` sets another number.
#[test]
fn mutated_files_are_read_without_panic_and_come_back() {
    let runs: u64 = std::env::var("RETUNE_FUZZ_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(20_000);
    let seeds = seeds();
    let mut rng = ChaCha8Rng::seed_from_u64(2411);
    let (mut read_at_all, mut longest) = (0_u64, std::time::Duration::ZERO);
    for run in 0..runs {
        let seed = &seeds[rng.random_range(0..seeds.len())];
        let other = &seeds[rng.random_range(0..seeds.len())];
        let bytes = mutate(seed, other, &mut rng);
        let start = std::time::Instant::now();
        if let Ok((file, _)) = read(&bytes) {
            read_at_all += 1;
            make_sense_of(&file);
            // Whatever was understood can be written, and what was written is understood in the same way: rounding and
            // the blanks for line ends inside unread lines happen in the first two rounds, the third changes nothing.
            let round = |bytes: &[u8]| write(&read(bytes).unwrap_or_else(|e| panic!("run {run}: {e}")).0);
            // A label that is too wide for its columns is refused.
            let Ok((first, _)) = write(&file) else { continue };
            let Ok(second) = round(&first).and_then(|(bytes, _)| round(&bytes)) else { continue };
            assert_eq!(round(&second.0).unwrap().0, second.0, "run {run}");
        }
        longest = longest.max(start.elapsed());
    }
    println!("{runs} mutated files, {read_at_all} read, longest {longest:?}");
    assert!(longest < std::time::Duration::from_secs(5), "{longest:?}");
}
