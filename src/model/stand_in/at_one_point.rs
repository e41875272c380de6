//! A stand-in at one θ: its lowest modes there instead of a basis for all θ.

use super::{Common, StandIn, Term};
use crate::linalg::DMatrix;
use crate::linalg::SymMatrix;
use crate::linalg::sparse::PencilFactor;
use crate::modal::{self, ModalError, SolveOptions};
use crate::model::assembly::{AffineMass, AffinePart, Basis};
use crate::model::dof_map::DofMap;
use crate::model::entry::{Entry, lower_entries};
use crate::model::{ModelError, ParametricModel};
use crate::once::Once;
use std::sync::Arc;

impl StandIn {
    /// The same for changes of any size at one θ, on fewer coordinates: its lowest modes there, in which K and M are diagonal, and the static shapes of
    /// whatever is added. Its matrices do not follow the parameters of the model.
    ///
    /// `None` where it has changes with sizes of their own, or other rigid-body modes at this θ than at the others.
    ///
    /// * `n_elastic` - how many elastic modes are kept
    ///
    /// # Errors
    /// Those of a solution of the model.
    pub fn at_one_point(&self, theta: &[f64], n_elastic: usize) -> Result<Option<Self>, ModelError> {
        let common = &*self.common;
        let model = &common.model;
        if self.parameters.len() != model.parameters().len() || self.n_new > 0 {
            return Ok(None);
        }
        let system = self.assemble(theta)?;
        let options = SolveOptions { n_elastic, shift: Some(common.shift) };
        let modes = modal::solve(&system.stiffness, &system.mass, &self.dofs.rigid_motions(), options)?;
        let n_rigid = common.n_rigid;
        if modes.n_rigid != n_rigid {
            return Ok(None);
        }
        // Of unit length in X = K + aM.
        let squares: Vec<f64> = modes.lambda.iter().map(|lambda| (lambda + common.shift).recip()).collect();
        let mut y = modes.shapes;
        y.column_iter_mut().zip(&squares).for_each(|(mut column, square)| column *= square.sqrt());
        let kept = y.ncols();
        let turn = y.view((0, 0), (n_rigid, n_rigid)).into_owned();
        let Some(back) = turn.clone().try_inverse() else { return Ok(None) };
        let rigid_parts = &common.rigid_parts * turn;
        let mut motions = DMatrix::zeros(kept, 6);
        motions.rows_mut(0, n_rigid).copy_from(&(back * common.motions.rows(0, n_rigid)));
        let mut basis = self.expanded(&y);
        basis.columns_mut(0, n_rigid).copy_from(&(model.dof_map().rigid_motions() * &rigid_parts));
        let diagonal = |of: &dyn Fn(usize) -> f64| -> Vec<Entry> {
            (0..kept).map(|k| Entry::new(k, k, of(k))).filter(|e| e.value != 0.0).collect()
        };
        let damping = system.damping.as_ref().map_or_else(Vec::new, |c| lower_entries(&y.tr_mul(&(c * &y))));
        let of_parameters = model.parameters().len();
        let affine = AffinePart {
            constant: Basis {
                stiffness: diagonal(&|k| modes.lambda[k] * squares[k]),
                mass: diagonal(&|k| squares[k]),
                damping,
            },
            parameters: vec![Basis::default(); of_parameters],
            products: Vec::new(),
        };
        let masses = AffineMass {
            linear: std::iter::once(model.rigid_mass(theta)?)
                .chain(std::iter::repeat_n(SymMatrix::zeros(6), of_parameters))
                .collect(),
            products: Vec::new(),
        };
        let full = model.assemble_sparse(theta)?;
        let factor = PencilFactor::new(common.factor.plan().clone(), &full.stiffness, &full.mass, common.shift)
            .map_err(ModalError::from)?;
        let whole = Term { stiffness: Some(full.stiffness), mass: Some(full.mass), damping: full.damping };
        let none = || Term { stiffness: None, mass: None, damping: None };
        let dofs = DofMap::of_coordinates(kept, &motions);
        let at_one_point = Common {
            model: model.clone(),
            theta: theta.to_vec(),
            basis,
            terms: std::iter::once(whole).chain((0..of_parameters).map(|_| none())).collect(),
            frozen_mass: None,
            masses: masses.clone(),
            affine: affine.clone(),
            factor: Arc::new(factor),
            shift: common.shift,
            motions,
            n_rigid,
            rigid_parts,
            is_damped: self.is_damped,
            symmetry: Once::new(),
        };
        Ok(Some(Self {
            common: Arc::new(at_one_point),
            parameters: self.parameters.clone(),
            changes: Vec::new(),
            extra: Arc::new(DMatrix::zeros(model.dof_map().n_dof(), 0)),
            n_new: 0,
            affine,
            rigid_mass: masses,
            not_in_rigid_mass: Vec::new(),
            general: Vec::new(),
            is_damped: self.is_damped,
            dofs,
            symmetry: Once::new(),
        }))
    }
}
