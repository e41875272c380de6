//! A model from its file, alone or beside another of which it has most.

use super::Model;
use crate::model::registry::Registry;
use crate::model::spec::ModelSpec;
use crate::yaml::Problem;

impl Model {
    /// Builds the model of a specification, with warnings.
    ///
    /// Errors: all problems found, warnings among them.
    pub fn new(spec: ModelSpec, registry: &Registry) -> Result<(Self, Vec<Problem>), Vec<Problem>> {
        Self::make(spec, (registry, None))
    }

    /// The same, equal to the bit but for rounding, in less time: how the matrices of elements depend on the parameters is taken from a model that has the
    /// same elements, with the same parameters before others.
    ///
    /// Errors: as [`Model::new`].
    pub fn new_beside(
        spec: ModelSpec,
        registry: &Registry,
        other: &Self,
    ) -> Result<(Self, Vec<Problem>), Vec<Problem>> {
        Self::make(spec, (registry, Some(other)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::{Context, Effects, candidates};
    use crate::model::{ParametricModel, load};

    /// With every effect at every place a model beside the one without it is the model from its file alone, and looks for few elements anew.
    #[test]
    fn a_model_beside_another_is_the_model_from_its_file() {
        let registry = Registry::builtin();
        let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/models/wing_on_spring.yaml")).unwrap();
        let base = load(&text, &registry).unwrap().0;
        let (mut all, mut shared) = (0, 0);
        for candidate in candidates(&base, &Effects::builtin(), &Context::default()) {
            let spec = candidate.patch.apply(base.spec()).unwrap();
            let alone = Model::new(spec.clone(), &registry).unwrap().0;
            let beside = Model::new_beside(spec, &registry, &base).unwrap().0;
            let mut theta = alone.parameters().nominal();
            for (value, size) in theta[base.parameters().len()..].iter_mut().zip(candidate.typical()) {
                *value = size;
            }
            let [a, b] = [&alone, &beside].map(|model| model.assemble(&theta).unwrap());
            assert!((&a.stiffness - &b.stiffness).amax() <= 1e-13 * a.stiffness.amax(), "{}", candidate.id());
            assert!((&a.mass - &b.mass).amax() <= 1e-13 * a.mass.amax(), "{}", candidate.id());
            all += beside.acting().len();
            let is_known =
                |own: &&std::sync::Arc<_>| base.acting().iter().any(|known| std::sync::Arc::ptr_eq(known, own));
            shared += beside.acting().iter().filter(is_known).count();
        }
        assert!(10 * shared > 7 * all, "{shared} of {all}");
    }
}
