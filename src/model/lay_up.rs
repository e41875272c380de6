//! Plies whose numbers are functions of θ.

use super::affine::Affine;
use super::laminate::{Ply, Strip, strip};
use super::plate::{PLATE, plate};
use std::sync::{Arc, Mutex, PoisonError};

/// Elastic constants of a ply as functions of θ.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Constants {
    /// E, nu.
    Isotropic([Affine; 2]),
    /// E1, E2, G12, nu12, G13, G23.
    Orthotropic([Affine; 6]),
}

/// A ply as functions of θ.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PlyOf {
    pub(super) constants: Constants,
    /// Density, angle, thickness.
    pub(super) sizes: [Affine; 3],
}

impl PlyOf {
    fn numbers(&self) -> impl Iterator<Item = &Affine> {
        let constants = match &self.constants {
            Constants::Isotropic(c) => &c[..],
            Constants::Orthotropic(c) => &c[..],
        };
        constants.iter().chain(&self.sizes)
    }

    fn map(&self, of: impl Fn(&Affine) -> Affine) -> Self {
        let constants = match &self.constants {
            Constants::Isotropic(c) => Constants::Isotropic(c.each_ref().map(&of)),
            Constants::Orthotropic(c) => Constants::Orthotropic(c.each_ref().map(&of)),
        };
        Self { constants, sizes: self.sizes.each_ref().map(&of) }
    }

    /// The ply at θ.
    pub(super) fn at(&self, theta: &[f64]) -> Ply {
        let [density, angle, thickness] = self.sizes.each_ref().map(|a| a.at(theta));
        let [e1, e2, g12, nu12, g13, g23] = match &self.constants {
            Constants::Isotropic(c) => {
                let [e, nu] = c.each_ref().map(|a| a.at(theta));
                let g = e / (2.0 * (1.0 + nu));
                [e, e, g, nu, g, g]
            }
            Constants::Orthotropic(c) => c.each_ref().map(|a| a.at(theta)),
        };
        Ply { e1, e2, g12, nu12, g13, g23, density, angle, thickness }
    }
}

/// Names of what a strip has, as properties of a beam, in the order in which a lay-up gives it.
pub(super) const STRIP: [&str; 8] =
    ["EA", "EIy", "EIz", "GJ", "mass_per_length", "polar_inertia_per_length", "bend_twist_y", "mass_offset_z"];

/// Plies from the side of small z.
#[derive(Debug)]
pub struct LayUp {
    /// The width of a strip; none of a plate.
    width: Option<Affine>,
    plies: Vec<PlyOf>,
    /// Parameters that move any of them, sorted.
    parameters: Vec<usize>,
    /// Their values at the last point, and what the plies were there: all elements of a section ask the same.
    last: Mutex<Option<(Vec<f64>, Vec<f64>)>>,
}

impl PartialEq for LayUp {
    fn eq(&self, other: &Self) -> bool {
        self.width == other.width && self.plies == other.plies
    }
}

impl LayUp {
    /// * `width` - of a strip; none of a plate
    pub(super) fn new(width: Option<Affine>, plies: Vec<PlyOf>) -> Self {
        let all = plies.iter().flat_map(PlyOf::numbers).chain(&width);
        let mut parameters: Vec<usize> = all.flat_map(|a| a.terms.iter().map(|t| t.0)).collect();
        parameters.sort_unstable();
        parameters.dedup();
        Self { width, plies, parameters, last: Mutex::new(None) }
    }

    /// Names of what it gives.
    pub(super) fn names(&self) -> &'static [&'static str] {
        if self.width.is_some() { &STRIP } else { &PLATE }
    }

    pub(super) fn is_constant(&self) -> bool {
        self.parameters.is_empty()
    }

    /// What it gives at θ, in the order of [`Self::names`].
    ///
    /// # Errors
    /// Plies that are no strip.
    pub(super) fn found(&self, theta: &[f64]) -> Result<Vec<f64>, String> {
        let plies: Vec<Ply> = self.plies.iter().map(|p| p.at(theta)).collect();
        let Some(width) = &self.width else { return Ok(plate(&plies).to_vec()) };
        let s: Strip = strip(width.at(theta), &plies)?;
        let rest = [s.mass_per_length, s.polar_inertia_per_length, s.bend_twist_y, s.mass_offset_z];
        Ok([[s.ea, s.eiy, s.eiz, s.gj], rest].concat())
    }

    /// One of the numbers; NaN where the plies are no strip at θ.
    fn at(&self, theta: &[f64], which: usize) -> f64 {
        let own: Vec<f64> = self.parameters.iter().map(|&p| theta[p]).collect();
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        match last.as_ref() {
            Some((at, known)) if *at == own => known[which],
            _ => {
                let found = self.found(theta).unwrap_or_else(|_| vec![f64::NAN; self.names().len()]);
                let value = found[which];
                *last = Some((own, found));
                value
            }
        }
    }
}

/// One number of a lay-up.
#[derive(Debug, Clone, PartialEq)]
pub struct Rigidity {
    lay_up: Arc<LayUp>,
    /// Place in [`LayUp::names`].
    which: usize,
}

impl Rigidity {
    pub(super) fn new(lay_up: Arc<LayUp>, which: usize) -> Self {
        Self { lay_up, which }
    }

    /// Its value at θ.
    pub fn at(&self, theta: &[f64]) -> f64 {
        self.lay_up.at(theta, self.which)
    }

    /// Indices in θ that it depends on.
    pub fn parameters(&self) -> impl Iterator<Item = usize> + '_ {
        self.lay_up.parameters.iter().copied()
    }

    /// With other parameters, or with their values in their places.
    pub(super) fn with_parameters(&self, of: &dyn Fn(usize) -> Result<usize, f64>) -> Self {
        if self.lay_up.parameters.iter().all(|&p| of(p) == Ok(p)) {
            return self.clone();
        }
        let changed = |a: &Affine| a.with_parameters(of);
        let plies = self.lay_up.plies.iter().map(|ply| ply.map(changed)).collect();
        Self { lay_up: Arc::new(LayUp::new(self.lay_up.width.as_ref().map(changed), plies)), which: self.which }
    }
}
