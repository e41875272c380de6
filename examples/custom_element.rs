//! An element of your own: a bar whose section shrinks linearly from `A1` at its first node to `A2` at its second.
//!
//! ```text
//!    1 o===-----.....2o ---> x       k = E (A1 - A2) / (L ln(A1/A2)),  exact for a static load
//! ```
//!
//! `conformance::check` holds it to what every element must satisfy. Run it: `cargo run --example custom_element`.

use retune::element::{Axes, Dof, Domain, Element, ElementError, ElementInput, Property, Sample, conformance};
use retune::linalg::SymMatrix;
use retune::model::{ParametricModel, Registry, load};

#[derive(Debug)]
pub(crate) struct TaperedBar;

impl Element for TaperedBar {
    fn name(&self) -> &'static str {
        "tapered_bar"
    }
    fn summary(&self) -> &'static str {
        "A bar whose cross-section changes linearly along its length."
    }
    fn theory(&self) -> &'static str {
        "k = E (A1 - A2) / (L ln(A1/A2)); no mass."
    }
    fn nodes(&self) -> &'static [&'static [Dof]] {
        &[&[Dof::Ux, Dof::Uy, Dof::Uz], &[Dof::Ux, Dof::Uy, Dof::Uz]]
    }
    fn properties(&self) -> &'static [Property] {
        const {
            &[
                Property::new("E", "Pa", Domain::Positive, "Young's modulus"),
                Property::new("A1", "m2", Domain::Positive, "cross-section area at the first node"),
                Property::new("A2", "m2", Domain::Positive, "cross-section area at the second node"),
            ]
        }
    }
    fn axes(&self) -> Axes {
        Axes::AlongNodes
    }
    fn stiffness(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        input.check(self)?;
        let [e, a1, a2] = [0, 1, 2].map(|i| input.values[i].unwrap_or(1.0));
        let mean = if (a1 / a2 - 1.0).abs() < 1e-6 { 0.5 * (a1 + a2) } else { (a1 - a2) / (a1 / a2).ln() };
        let mut stretch = [0.0; 12];
        (stretch[0], stretch[6]) = (-1.0, 1.0);
        let mut k = SymMatrix::zeros(12);
        k.add_outer(e * mean / input.length(), &stretch);
        Ok(k)
    }
    fn mass(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        input.check(self)?;
        Ok(SymMatrix::zeros(12))
    }
    fn samples(&self) -> Vec<Sample> {
        let given = vec![("E", 70e9), ("A1", 4e-4), ("A2", 1e-4)];
        vec![Sample { points: vec![[0.0; 3], [0.5, 0.0, 0.0]], given, mass: 0.0, free: true }]
    }
}

const MODEL: &str = "
retune: 1
name: a lump on a tapered strut
active_dofs: [ux]
nodes: {wall: [0, 0, 0], end: [0.5 m, 0, 0]}
elements:
  strut: {type: tapered_bar, nodes: [wall, end], properties: {E: 70 GPa, A1: 4 cm2, A2: 1 cm2}}
masses: {lump: {node: end, mass: 2 kg}}
supports: {clamp: {node: wall}}
";

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    conformance::check(&TaperedBar).map_err(|breaches| format!("{breaches:?}"))?;
    let (model, ..) =
        load(MODEL, &Registry::builtin().with(&TaperedBar)).map_err(|problems| format!("{problems:?}"))?;
    let system = model.assemble(&[])?;
    println!("stiffness {:.6e} N/m; by hand {:.6e} N/m", system.stiffness[(0, 0)], 140e9 * 3e-4 / 4f64.ln());
    Ok(())
}
