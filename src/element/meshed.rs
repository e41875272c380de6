//! What elements of meshes share: how one is declared, and how it reads its material.

use super::ElementError;

/// An element of a mesh: a unit struct and its [`super::Element`], from the `kernel` and the `material` beside it.
///
/// Name, number of nodes and dofs of each, summary, its text and the one of its kind, what the kernel integrates, samples, and what is its own.
macro_rules! meshed {
    (
        $vis:vis $type:ident, $name:literal, [$dofs:path; $nodes:literal], $summary:literal,
        [$text:literal, $common:literal], $integrated:expr, $samples:expr $(, $own:item)?
    ) => {
        #[doc = include_str!($text)]
        #[derive(Debug, Clone, Copy)]
        $vis struct $type;

        impl crate::element::Element for $type {
            fn name(&self) -> &'static str {
                $name
            }

            fn summary(&self) -> &'static str {
                $summary
            }

            fn theory(&self) -> &'static str {
                concat!(include_str!($text), "\n", include_str!($common))
            }

            fn nodes(&self) -> &'static [&'static [crate::element::Dof]] {
                &[$dofs; $nodes]
            }

            fn properties(&self) -> &'static [crate::element::Property] {
                super::material::PROPERTIES
            }

            fn preloads(&self) -> &'static [&'static str] {
                super::material::PRELOADS
            }

            fn axes(&self) -> crate::element::Axes {
                crate::element::Axes::Given
            }

            fn stiffness(
                &self,
                input: &crate::element::ElementInput<'_>,
            ) -> Result<crate::linalg::SymMatrix, crate::element::ElementError> {
                input.check(self)?;
                super::kernel::stiffness(&$integrated, input)
            }

            fn mass(
                &self,
                input: &crate::element::ElementInput<'_>,
            ) -> Result<crate::linalg::SymMatrix, crate::element::ElementError> {
                input.check(self)?;
                super::kernel::mass(&$integrated, input)
            }

            fn nearest(
                &self,
                input: &crate::element::ElementInput<'_>,
                place: [f64; 3],
            ) -> Result<Option<crate::element::PointWithin>, crate::element::ElementError> {
                input.check(self)?;
                super::kernel::nearest(&$integrated, input, place).map(Some)
            }

            fn strain_field(
                &self,
                input: &crate::element::ElementInput<'_>,
            ) -> Result<Option<crate::element::StrainField>, crate::element::ElementError> {
                input.check(self)?;
                super::strains::strain_field(&$integrated, input)
            }

            fn preload_of(
                &self,
                input: &crate::element::ElementInput<'_>,
                u: &[f64],
            ) -> Result<Vec<(&'static str, f64)>, crate::element::ElementError> {
                input.check(self)?;
                super::strains::preload_of(&$integrated, input, u)
            }

            fn lacks(&self, input: &crate::element::ElementInput<'_>) -> Vec<crate::element::Lack> {
                super::material::lacks(input)
            }

            fn samples(&self) -> Vec<crate::element::Sample> {
                $samples
            }

            $($own)?
        }
    };
}
pub(super) use meshed;

/// What an input says of stiffness.
pub(super) enum Given<const N: usize> {
    /// Nothing: the element is mass alone.
    Nothing,
    /// Young's modulus and Poisson's ratio.
    Isotropic([f64; 2]),
    /// All constants of an orthotropic material.
    Orthotropic([f64; N]),
}

/// The constants of a material: of one kind and complete, or none.
///
/// * `isotropic` - E and nu
/// * `why` - what an isotropic and an orthotropic material need
pub(super) fn given<const N: usize>(
    isotropic: [Option<f64>; 2],
    orthotropic: [(&'static str, Option<f64>); N],
    why: [&'static str; 2],
) -> Result<Given<N>, ElementError> {
    if let Some((second, _)) = orthotropic.iter().find(|(_, v)| v.is_some()) {
        let twice = ["E", "nu"].into_iter().zip(isotropic).find(|(_, v)| v.is_some());
        if let Some((first, _)) = twice {
            return Err(ElementError::Redundant { first, second });
        }
        let mut all = [0.0; N];
        for (slot, (name, value)) in all.iter_mut().zip(orthotropic) {
            *slot = value.ok_or(ElementError::Missing { name, why: why[1] })?;
        }
        return Ok(Given::Orthotropic(all));
    }
    match isotropic {
        [None, None] => Ok(Given::Nothing),
        [Some(_), None] => Err(ElementError::Missing { name: "nu", why: why[0] }),
        [None, Some(_)] => Err(ElementError::Missing { name: "E", why: why[0] }),
        [Some(_), Some(nu)] if !(nu > -1.0 && nu < 0.5) => {
            Err(ElementError::OutOfDomain { name: "nu", value: nu, expected: "above -1 and below 0.5" })
        }
        [Some(e), Some(nu)] => Ok(Given::Isotropic([e, nu])),
    }
}
