//! An element of your own: two nodes joined by a shear panel's edge, that is, a spring across the line between them.
//!
//! ```text
//!    1 o-------------------o 2 ---> x      k (v2 - v1 - L (θ1 + θ2)/2)²/2,  v = uy, θ = rz
//! ```
//!
//! The average rotation is taken off, so that turning the pair as a rigid body costs nothing. Run it with
//! `cargo run --example custom_element`.

use retune::element::{Axes, Dof, Domain, Element, ElementError, ElementInput, Property, Sample, conformance};
use retune::linalg::SymMatrix;
use retune::modal::{SolveOptions, solve};
use retune::model::{ParametricModel, Registry, load};

#[derive(Debug)]
pub(crate) struct ShearLink;

impl Element for ShearLink {
    fn name(&self) -> &'static str {
        "shear_link"
    }
    fn summary(&self) -> &'static str {
        "A spring against sliding of two nodes across the line between them."
    }
    fn theory(&self) -> &'static str {
        "U = k/2 (v2 - v1 - L (θ1 + θ2)/2)², along y of the element; no mass."
    }
    fn nodes(&self) -> &'static [&'static [Dof]] {
        &[&[Dof::Uy, Dof::Rz], &[Dof::Uy, Dof::Rz]]
    }
    fn properties(&self) -> &'static [Property] {
        const { &[Property::new("k", "N/m", Domain::NonNegative, "stiffness against sliding")] }
    }
    fn axes(&self) -> Axes {
        Axes::AlongNodes
    }
    fn stiffness(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        input.check(self)?;
        let mut slide = [0.0; 12];
        (slide[1], slide[7]) = (-1.0, 1.0);
        (slide[5], slide[11]) = (-0.5 * input.length(), -0.5 * input.length());
        let mut k = SymMatrix::zeros(12);
        k.add_outer(input.values[0].unwrap_or(0.0), &slide);
        Ok(k)
    }
    fn mass(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        input.check(self)?;
        Ok(SymMatrix::zeros(12))
    }
    fn samples(&self) -> Vec<Sample> {
        vec![Sample { points: vec![[0.0; 3], [0.5, 0.0, 0.0]], given: vec![("k", 2e4)], mass: 0.0, free: true }]
    }
}

const MODEL: &str = "
retune: 1
name: a lump on a shear link
active_dofs: [uy]
nodes: {wall: [0, 0, 0], lump: [0.5 m, 0, 0]}
elements:
  link: {type: shear_link, nodes: [wall, lump], properties: {k: 8 kN/m}}
masses: {lump_mass: {node: lump, mass: 2 kg}}
supports: {clamp: {node: wall}}
";

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    conformance::check(&ShearLink).map_err(|breaches| format!("{breaches:?}"))?;
    let (model, ..) = load(MODEL, &Registry::builtin().with(&ShearLink)).map_err(|problems| format!("{problems:?}"))?;
    let system = model.assemble(&[])?;
    let options = SolveOptions { n_elastic: 1, shift: None };
    let modes = solve(&system.stiffness, &system.mass, &model.dof_map().rigid_motions(), options)?;
    println!("{:.4} Hz; by hand {:.4} Hz", modes.frequency_hz(0), (8e3_f64 / 2.0).sqrt() / std::f64::consts::TAU);
    Ok(())
}
