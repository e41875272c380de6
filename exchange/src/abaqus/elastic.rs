//! Density and elastic constants of a material.

use retune::deck::{DeckError, Keyword};

/// Elastic constants, as a deck gives them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Elastic {
    Isotropic {
        e: f64,
        nu: f64,
    },
    /// Along three axes: E1 E2 E3, ν12 ν13 ν23, G12 G13 G23.
    Orthotropic {
        e: [f64; 3],
        nu: [f64; 3],
        g: [f64; 3],
    },
    /// Of a sheet: E1 E2, ν12, G12 G13 G23.
    Lamina {
        e: [f64; 2],
        nu: f64,
        g: [f64; 3],
    },
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Material {
    pub density: Option<f64>,
    pub elastic: Option<Elastic>,
    /// The keywords that give them.
    pub density_at: Option<usize>,
    pub elastic_at: Option<usize>,
}

impl Material {
    /// E and nu of a material that must be isotropic.
    pub(super) fn isotropic(self, k: &Keyword<'_>) -> Result<[f64; 2], DeckError> {
        match self.elastic {
            Some(Elastic::Isotropic { e, nu }) => Ok([e, nu]),
            Some(_) => Err(k.error("beams and trusses of directed materials are not read; give isotropic ones")),
            None => Err(k.error("its material has no *ELASTIC")),
        }
    }
}

impl Elastic {
    pub(super) fn is_isotropic(&self) -> bool {
        matches!(self, Elastic::Isotropic { .. })
    }
}
