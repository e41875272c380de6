//! Writes the test file of the flagship, `models/bff_gvt.yaml`:
//!
//! ```text
//! cargo run -p retune-tools --bin make_bff_gvt > models/bff_gvt.yaml
//! ```
//!
//! Frequencies and damping are those measured on the aircraft; the mode shapes, never published as numbers, are those of
//! the virtual aircraft of `models/bff_truth.yaml`. The test-suite runs this generator and compares.

use retune::correlation::observation_matrix;
use retune::data::{Place, Sensor};
use retune::modal::{SolveOptions, solve};
use retune::model::{Model, ParametricModel, Registry, load};

/// Frequency in Hz and damping in % of the six modes: Table 2 of the paper.
const TABLE_2: [(&str, &str, &str); 6] = [
    ("Sym 1st Bending", "5.67", "1.55"),
    ("Anti 1st Bending", "8.37", "1.06"),
    ("Sym 1st Torsion", "18.34", "2.06"),
    ("Anti 1st Torsion", "19.82", "2.33"),
    ("Sym 2nd Bending", "23.17", "2.85"),
    ("Anti 2nd Bending", "28.60", "2.55"),
];

/// Points ahead of the spar (leading edge) and behind it (trailing edge), m.
const LEADING: f64 = -0.1016;
const TRAILING: f64 = 0.0635;

/// Points in a row of the grid, in the order of the sensors: body, right wing, left wing, body.
const ROWS: [usize; 6] = [4, 7, 7, 7, 7, 2];

const HEAD: &str = "\
# Ground vibration test of the Body Freedom Flutter (BFF) flying wing: six modes, 34 points.
#
# MEASURED: frequencies and damping, Table 2 of the paper. SYNTHETIC: all mode shapes; the measured ones were never
# published as numbers. They are those of the virtual aircraft of bff_truth.yaml, whose frequencies are the measured ones
# within 1e-6 Hz, without noise. The largest entry among p1 to p18 of each shape is 1.
#
# Written by tools/src/bin/make_bff_gvt.rs; edit that.
retune_test: 1
name: BFF ground vibration test
description: >
  Measured frequencies and damping with synthetic shapes, as if accelerometers at 34 points had measured the virtual
  aircraft of bff_truth.yaml. p12 is the point of excitation.

sources:
  table_2:
    kind: measured
    text: >
      A. Gupta, C. P. Moreno, H. Pfifer, G. J. Balas, Updating a Finite Element Based Structural Model of a Small Flexible
      Aircraft, AIAA 2015, Table 2: free-free test on soft suspension, shaker at point 12
  virtual_gvt:
    kind: synthetic
    text: mass-normalised modes 4 to 9 of bff_truth.yaml at the sensors, rescaled; no noise

defaults:
  # Tables 2 and 6 of the paper give the same modes from two extractions; they differ by up to 0.7 %, by 0.3 % on average.
  frequency_sd: 0.5 %
  damping_sd: 10 %
  # The quadrature correction of the paper bends a noise-free shape by up to 1.9 % (1 - MAC = 3.5e-4).
  shape_sd: 2 %

# Vertical accelerometers on two rows, 101.6 mm ahead of the spar and 63.5 mm behind it, at four of the five wing nodes
# and in the middle of three elements; six points on the body. Point 12 is the excitation and point 15 lies on the right
# trailing edge, as in the paper; the rest of the grid is this project's choice.
";

/// The text of the test file.
pub(crate) fn gvt_file(truth: &Model) -> String {
    let sensors = sensors(truth);
    let places: Vec<String> = sensors.iter().map(|s| format!("  {}\n", line(s))).collect();
    let modes: Vec<String> =
        TABLE_2.iter().zip(shapes(truth, &sensors)).map(|(row, shape)| mode(row, &shape)).collect();
    format!("{HEAD}sensors:\n{}\nmodes:\n{}", places.concat(), modes.concat())
}

/// A mode as YAML, its shape in the rows of the grid.
fn mode((label, frequency, damping): &(&str, &str, &str), shape: &[f64]) -> String {
    let mut values = shape.iter();
    let rows = ROWS.map(|n| {
        let row: Vec<String> = values.by_ref().take(n).map(|v| format!("{v:.10}")).collect();
        format!("        {}", row.join(", "))
    });
    format!(
        "  - label: {label}
    frequency: {frequency} Hz
    damping: {damping} %
    source: table_2
    shape:
      source: virtual_gvt
      real: [
{}]
",
        rows.join(",\n")
    )
}

/// The 34 sensors, p1 to p34.
fn sensors(truth: &Model) -> Vec<Sensor> {
    let body = |x: f64, y: f64| Place::Node { node: "n1".to_string(), position: Some([x, y, 0.0]) };
    let mut places = vec![body(0.15, 0.0), body(0.8, 0.0), body(0.4, 0.19), body(0.72, 0.19)];
    for (wing, nodes) in
        [("right_wing", ["n9", "n10", "n11", "n12", "n13"]), ("left_wing", ["n4", "n5", "n6", "n7", "n8"])]
    {
        for offset in [LEADING, TRAILING] {
            places.push(at_node(truth, nodes[0], offset));
            for element in 2..=4 {
                places.push(at_middle(
                    truth,
                    format!("{wing}.{element}"),
                    [nodes[element - 1], nodes[element]],
                    offset,
                ));
                places.push(at_node(truth, nodes[element], offset));
            }
        }
    }
    places.extend([body(0.4, -0.19), body(0.72, -0.19)]);
    let sensor = |(i, place): (usize, Place)| Sensor {
        name: format!("p{}", i + 1),
        place,
        direction: [0.0, 0.0, 1.0],
        offset: None,
        is_rotation: false,
        mass: None,
    };
    places.into_iter().enumerate().map(sensor).collect()
}

/// The position of a node, by its name.
fn position(model: &Model, node: &str) -> [f64; 3] {
    let geometry = model.geometry();
    geometry.positions[geometry.node(node).expect("a node of the BFF model")]
}

fn at_node(model: &Model, node: &str, offset: f64) -> Place {
    let [x, y, z] = position(model, node);
    Place::Node { node: node.to_string(), position: Some([x + offset, y, z]) }
}

fn at_middle(model: &Model, element: String, nodes: [&str; 2], offset: f64) -> Place {
    let [a, b] = nodes.map(|n| position(model, n));
    let [x, y, z] = [0, 1, 2].map(|i| 0.5 * (a[i] + b[i]));
    Place::Element { element, fraction: 0.5, position: Some([x + offset, y, z]) }
}

/// A sensor as a line of YAML.
fn line(sensor: &Sensor) -> String {
    let (place, position) = match &sensor.place {
        Place::Node { node, position } => (format!("node: {node}"), position),
        Place::Element { element, fraction, position } => {
            (format!("element: {element}, fraction: {fraction}"), position)
        }
    };
    let [x, y, _] = position.expect("every sensor has a position");
    // Ten decimals of a metre: what the shapes below need to agree with the model to their last digit.
    format!("{}: {{{place}, position: [{} m, {} m, 0 m], direction: +z}}", sensor.name, decimal(x), decimal(y))
}

/// At most ten decimals, without trailing zeros.
fn decimal(value: f64) -> String {
    let text = format!("{value:.10}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_string() } else { text.to_string() }
}

/// Shapes of the six modes after the three on the suspension, each with +1 at its largest entry among p1 to p18.
///
/// Left and right nearly tie, so the largest of all 34 would depend on rounding in a symmetric model.
fn shapes(truth: &Model, sensors: &[Sensor]) -> Vec<Vec<f64>> {
    let system = truth.assemble(&truth.parameters().nominal()).expect("the virtual aircraft has matrices");
    let motions = truth.dof_map().rigid_motions();
    let modes = solve(&system.stiffness, &system.mass, &motions, SolveOptions { n_elastic: 9, shift: None })
        .expect("the virtual aircraft has modes");
    let at_sensors = observation_matrix(truth, sensors).expect("every sensor is on the aircraft") * &modes.shapes;
    (3..9)
        .map(|mode| {
            let column = at_sensors.column(mode);
            let largest = (0..18).max_by(|&a, &b| column[a].abs().total_cmp(&column[b].abs())).expect("18 sensors");
            column.iter().map(|v| v / column[largest]).collect()
        })
        .collect()
}

fn main() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../models/bff_truth.yaml");
    let text = std::fs::read_to_string(path).expect("models/bff_truth.yaml is readable");
    let (truth, _, _) = load(&text, &Registry::builtin()).expect("models/bff_truth.yaml is sound");
    print!("{}", gvt_file(&truth));
}
