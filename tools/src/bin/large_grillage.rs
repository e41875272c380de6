//! A free grillage of any size as a model file: N x N crossings, the beams between them divided into PARTS elements.
//!
//! ```text
//! cargo run --release -p retune-tools --bin large_grillage -- 30 20 > target/grillage.yaml      # 10^5 dofs
//! cargo run --release -p retune-cli -- modes target/grillage.yaml -n 20
//! ```
//!
//! Three dofs a node, so 3 N² + 6 N (N - 1) (PARTS - 1) dofs. With `sensors` as a third argument a test file with sensors on all
//! crossings of every fifth beam comes out, for `retune twin --sensors`.
#![allow(missing_docs, clippy::print_stdout)]

use std::fmt::Write as _;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (n, parts): (usize, usize) = match arguments.as_slice() {
        [n, parts] => (n.parse()?, parts.parse()?),
        [n, _, what] if what == "sensors" => {
            print!("{}", sensors(n.parse()?)?);
            return Ok(());
        }
        _ => return Err("usage: large_grillage N PARTS [sensors]".into()),
    };
    let mut text = String::from(HEAD);
    for (i, j) in (0..n * n).map(|k| (k / n, k % n)) {
        writeln!(text, "  n{i}_{j}: [{:.2} m, {:.2} m, 0 m]", 0.3 * i as f64, 0.25 * j as f64)?;
    }
    text += "beams:\n";
    for k in 0..n {
        let across: Vec<String> = (0..n).map(|j| format!("n{k}_{j}")).collect();
        let along: Vec<String> = (0..n).map(|i| format!("n{i}_{k}")).collect();
        writeln!(text, "  y{k}: {{chain: [{}], section: across, subdivide: {parts}}}", across.join(", "))?;
        writeln!(text, "  x{k}: {{chain: [{}], section: along, subdivide: {parts}}}", along.join(", "))?;
    }
    print!("{text}");
    Ok(())
}

fn sensors(n: usize) -> Result<String, std::fmt::Error> {
    let mut text = String::from(
        "retune_test: 1\nname: sensors of a grillage\nsources: {places: {kind: synthetic, text: places of sensors without readings}}\nsensors:\n",
    );
    for (i, j) in (0..n).step_by(5).flat_map(|i| (0..n).step_by(5).map(move |j| (i, j))) {
        writeln!(text, "  s{i}_{j}: {{node: n{i}_{j}, direction: +z}}")?;
    }
    Ok(text)
}

const HEAD: &str = "\
retune: 1
name: free grillage
active_dofs: [uz, rx, ry]
parameters:
  E_along: {value: 70 GPa, bounds: [50 GPa, 90 GPa]}
  E_across: {value: 70 GPa, bounds: [50 GPa, 90 GPa]}
  rho: {value: 2700 kg/m3, bounds: [2000 kg/m3, 3500 kg/m3]}
sections:
  along: {E: E_along, G: 26 GPa, density: rho, shape: {rectangle: {width: 20 mm, height: 12 mm}}}
  across: {E: E_across, G: 26 GPa, density: rho, shape: {rectangle: {width: 20 mm, height: 12 mm}}}
nodes:
";
