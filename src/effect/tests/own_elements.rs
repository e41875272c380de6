//! Elements of a user's own stay with what is made of a model.

use crate::effect::{Context, Effects, Structure};
use crate::element::{Axes, Dof, Element, ElementError, ElementInput, Property, by_name};
use crate::linalg::SymMatrix;
use crate::model::{Registry, load};

/// A bar under a name of its own.
#[derive(Debug)]
struct Strut;

fn bar() -> &'static dyn Element {
    by_name("bar").expect("it is built in")
}

impl Element for Strut {
    fn name(&self) -> &'static str {
        "strut"
    }
    fn summary(&self) -> &'static str {
        bar().summary()
    }
    fn theory(&self) -> &'static str {
        bar().theory()
    }
    fn nodes(&self) -> &'static [&'static [Dof]] {
        bar().nodes()
    }
    fn properties(&self) -> &'static [Property] {
        bar().properties()
    }
    fn axes(&self) -> Axes {
        bar().axes()
    }
    fn stiffness(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        bar().stiffness(input)
    }
    fn mass(&self, input: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        bar().mass(input)
    }
}

/// What is made of the file of a model later, for an effect in one of its configurations, has the element types that it had.
#[test]
fn a_model_keeps_the_element_types_that_it_was_built_from() {
    let text = "
retune: 1
name: a lump on a strut
active_dofs: [ux]
nodes: {wall: [0, 0, 0], end: [0.5 m, 0, 0]}
elements: {strut: {type: strut, nodes: [wall, end], properties: {E: 70 GPa, A: 4 cm2, density: 2700 kg/m3}}}
supports: {clamp: {node: wall}}
configurations: {loaded: {masses: {lump: {node: end, mass: 2 kg}}}}
";
    assert!(load(text, &Registry::builtin()).is_err());
    let (model, ..) = load(text, &Registry::builtin().with(&Strut)).unwrap_or_else(|p| panic!("{p:?}"));
    assert!(model.registry().find("strut").is_some());
    let context = Context::default();
    let structure = Structure::new(&model, &context);
    let effects = Effects::builtin();
    for id in ["point-mass@end", "point-mass@loaded/end"] {
        let candidate = effects.candidate(&structure, id).unwrap_or_else(|e| panic!("{id}: {e}"));
        assert!(candidate.build(&model, model.registry()).is_ok(), "{id}");
    }
}
