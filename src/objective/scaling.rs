//! From the unit box of the optimisers to θ.

use crate::linalg::DVector;
use crate::modal::MatrixDerivative;
use crate::model::{ModelError, ParametricModel, System};

/// θ = base, with the free parameters at lower + x (upper - lower).
#[derive(Debug, Clone, PartialEq)]
pub struct Scaling {
    base: Vec<f64>,
    free: Vec<usize>,
    lower: Vec<f64>,
    width: Vec<f64>,
}

impl Scaling {
    /// The bounded parameters of a model are free, the others stay at their estimates.
    pub fn new(model: &dyn ParametricModel) -> Self {
        let parameters = model.parameters();
        let free = parameters.free();
        let bounds: Vec<[f64; 2]> = free.iter().filter_map(|&i| parameters.get(i).bounds).collect();
        Self {
            base: parameters.nominal(),
            free,
            lower: bounds.iter().map(|b| b[0]).collect(),
            width: bounds.iter().map(|b| b[1] - b[0]).collect(),
        }
    }

    /// Number of free parameters.
    pub fn len(&self) -> usize {
        self.free.len()
    }

    /// Whether no parameter is free.
    pub fn is_empty(&self) -> bool {
        self.free.is_empty()
    }

    /// Indices in θ of the free parameters.
    pub fn free(&self) -> &[usize] {
        &self.free
    }

    /// Upper minus lower bound of each free parameter.
    pub fn width(&self) -> &[f64] {
        &self.width
    }

    /// ∂K/∂θ_j, ∂M/∂θ_j and ∂C/∂θ_j of every free parameter; [`matrix_derivatives`] shows them to the modal kernels.
    pub fn derivatives(&self, model: &dyn ParametricModel, theta: &[f64]) -> Result<Vec<System>, ModelError> {
        self.free.iter().map(|&j| model.assemble_derivative(theta, j)).collect()
    }

    /// θ at x.
    pub fn theta(&self, x: &DVector<f64>) -> Vec<f64> {
        let mut theta = self.base.clone();
        self.overwrite(x, &mut theta);
        theta
    }

    /// θ at x, into a θ of this scaling.
    pub(super) fn overwrite(&self, x: &DVector<f64>, theta: &mut [f64]) {
        for (k, &i) in self.free.iter().enumerate() {
            theta[i] = self.lower[k] + x[k] * self.width[k];
        }
    }

    /// θ with the free parameters in the middle of their bounds.
    pub(super) fn centre(&self) -> Vec<f64> {
        self.theta(&DVector::from_element(self.len(), 0.5))
    }

    /// The constants, and any value of the free parameters.
    pub(super) fn base(&self) -> &[f64] {
        &self.base
    }

    /// x of a θ; outside the unit box where a value is outside its bounds.
    pub fn x(&self, theta: &[f64]) -> DVector<f64> {
        DVector::from_fn(self.free.len(), |k, _| (theta[self.free[k]] - self.lower[k]) / self.width[k])
    }
}

/// The stiffness and mass of derivatives, as the modal kernels take them.
pub fn matrix_derivatives(systems: &[System]) -> Vec<MatrixDerivative<'_>> {
    systems.iter().map(|s| MatrixDerivative { stiffness: &s.stiffness, mass: &s.mass }).collect()
}
