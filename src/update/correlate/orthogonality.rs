//! Auto- and cross-orthogonality in the model's mass, reduced to the sensors of the test.

use super::{paired_shapes, pairs_with_shapes};
use crate::correlation::{CorrelationError, auto_orthogonality, cross_orthogonality};
use crate::linalg::{DMatrix, thin_svd};
use crate::modal::reduction::{Reduction, dynamic_reduction, guyan, guyan_and_irs, irs, serep_transformation};
use crate::model::System;
use crate::objective::Comparison;
use crate::update::Assessment;
use std::borrow::Cow;

/// How the mass is reduced to the sensors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum MassReduction {
    /// The first that exists: none where the sensors see every dof, else the one of static, improved and SEREP in which
    /// the model's own modes are most nearly orthogonal; SEREP only where the others do not exist, since its own modes
    /// are orthogonal by construction.
    #[default]
    Auto,
    /// None: the sensors see every dof, M at the sensors is S⁺ᵀ M S⁺.
    Full,
    /// Static (Guyan).
    Guyan,
    /// Improved reduced system.
    Irs,
    /// Dynamic, at the mean of the ω² of the paired modes.
    Dynamic,
    /// System equivalent reduction expansion process, with the paired modes and the rigid-body modes.
    Serep,
}

crate::catalogue::choice! { MassReduction, "reduction of the mass";
    Auto "auto" "The best that exists for these sensors",
    Full "full" "None: the sensors see every dof",
    Guyan "guyan" "Static",
    Irs "irs" "Improved reduced system",
    Dynamic "dynamic" "Dynamic, at the mean of the paired modes",
    Serep "serep" "Exact in the paired modes",
}

impl MassReduction {
    /// Its name in the field.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "automatic",
            Self::Full => "none (the sensors see every dof)",
            Self::Guyan => "Guyan",
            Self::Irs => "IRS",
            Self::Dynamic => "dynamic",
            Self::Serep => "SEREP",
        }
    }
}

/// Orthogonality of the paired shapes.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Orthogonality {
    /// The reduction that was used.
    pub reduction: MassReduction,
    /// Indices of the test modes: the order of rows and columns below.
    pub test_modes: Vec<usize>,
    /// Sensors that a shape lacks, left out.
    pub left_out: Vec<String>,
    /// Model against test, each scaled to unit modal mass and to a positive diagonal, row by row.
    pub cross: Vec<Vec<f64>>,
    /// Test against test.
    pub auto: Vec<Vec<f64>>,
    /// Largest modulus off the diagonal among the model's own modes: what the reduction itself costs.
    pub own_error: f64,
    /// Indices of the sensors that are in the mass.
    #[serde(skip)]
    pub sensors: Vec<usize>,
    /// The mass at these sensors.
    #[serde(skip)]
    pub mass: DMatrix<f64>,
}

impl Orthogonality {
    /// Largest modulus of the cross-orthogonality off the diagonal.
    pub fn cross_off_diagonal(&self) -> f64 {
        off_diagonal(&self.cross)
    }

    /// Largest modulus of the auto-orthogonality off the diagonal.
    pub fn auto_off_diagonal(&self) -> f64 {
        off_diagonal(&self.auto)
    }

    /// Diagonal entry of a test mode's pair.
    pub fn of_pair(&self, test_mode: usize) -> Option<f64> {
        self.test_modes.iter().position(|m| *m == test_mode).map(|k| self.cross[k][k])
    }
}

fn off_diagonal(rows: &[Vec<f64>]) -> f64 {
    let entries = rows.iter().enumerate().flat_map(|(i, r)| r.iter().enumerate().map(move |(j, v)| (i != j, v.abs())));
    entries.filter(|(is_off, _)| *is_off).map(|(_, v)| v).fold(0.0, f64::max)
}

/// Orthogonality of the paired shapes in the mass of the model at the sensors.
///
/// ```text
/// XOR = Φ_aᵀ M_s Φ_x,   AOR = Φ_xᵀ M_s Φ_x     columns scaled to unit modal mass,   M_s = Tᵀ M T
/// ```
///
/// `Ok(None)` when fewer than one pair has a shape. Sensors that any of these shapes lacks are left out.
///
/// Errors: the reduction asked for does not exist for this model and these sensors; it says why.
pub fn orthogonality(
    comparison: &Comparison<'_>,
    a: &Assessment,
    reduction: MassReduction,
) -> Result<Option<Orthogonality>, CorrelationError> {
    let pairs = pairs_with_shapes(a);
    if pairs.is_empty() {
        return Ok(None);
    }
    let (model, test) = paired_shapes(comparison, a, &pairs);
    let kept: Vec<usize> = (0..test.nrows()).filter(|&i| test.row(i).iter().all(|v| !v.is_nan())).collect();
    let names = &comparison.test().sensors;
    let left_out = (0..test.nrows()).filter(|i| !kept.contains(i)).map(|i| names[i].name.clone()).collect();
    let (model, mut test) = (model.select_rows(&kept), test.select_rows(&kept));
    let basis = Basis { comparison, a, kept: &kept, own: &model };
    let (reduction, mass) = match reduction {
        MassReduction::Auto => basis.best()?,
        fixed => (fixed, basis.mass(fixed)?),
    };
    let own_error = basis.own_error(&mass)?;
    let cross = cross_orthogonality(&model, &mass, &test)?;
    for j in 0..pairs.len() {
        if cross[(j, j)] < 0.0 {
            test.column_mut(j).neg_mut();
        }
    }
    let rows = |m: DMatrix<f64>| m.row_iter().map(|r| r.iter().copied().collect()).collect::<Vec<Vec<f64>>>();
    Ok(Some(Orthogonality {
        reduction,
        test_modes: pairs.iter().map(|p| p.test_mode).collect(),
        left_out,
        cross: rows(cross_orthogonality(&model, &mass, &test)?),
        auto: rows(auto_orthogonality(&test, &mass)?),
        own_error,
        sensors: kept,
        mass,
    }))
}

struct Basis<'a> {
    comparison: &'a Comparison<'a>,
    a: &'a Assessment,
    kept: &'a [usize],
    own: &'a DMatrix<f64>,
}

impl Basis<'_> {
    fn own_error(&self, mass: &DMatrix<f64>) -> Result<f64, CorrelationError> {
        let own = auto_orthogonality(self.own, mass)?;
        let off = (0..own.nrows()).flat_map(|i| (0..i).map(move |j| (i, j))).map(|at| own[at].abs());
        Ok(off.fold(0.0, f64::max))
    }

    fn system(&self) -> Result<Cow<'_, System>, CorrelationError> {
        self.a.prediction.system().map_err(|e| CorrelationError::Model(e.to_string()))
    }

    /// Rows of the sensors that are in the mass.
    fn sensors(&self) -> DMatrix<f64> {
        self.comparison.sensors().select_rows(self.kept)
    }

    /// See [`MassReduction::Auto`].
    fn best(&self) -> Result<(MassReduction, DMatrix<f64>), CorrelationError> {
        if let Ok(mass) = self.mass(MassReduction::Full) {
            return Ok((MassReduction::Full, mass));
        }
        let mut best: Option<(f64, MassReduction, DMatrix<f64>)> = None;
        let s = self.sensors();
        // Without dense matrices, of a large model, SEREP is left, which needs the modes alone.
        if let Ok(system) = self.system()
            && let Ok((fixed, improved)) = guyan_and_irs(&system.stiffness, &system.mass, &s, 1)
        {
            for (reduction, reduced) in [(MassReduction::Guyan, Ok(fixed)), (MassReduction::Irs, improved)] {
                if let Ok(Reduction { mass, .. }) = reduced
                    && let Ok(error) = self.own_error(&mass)
                    && best.as_ref().is_none_or(|(least, ..)| error < *least)
                {
                    best = Some((error, reduction, mass));
                }
            }
        }
        match best {
            Some((_, reduction, mass)) => Ok((reduction, mass)),
            None => Ok((MassReduction::Serep, self.mass(MassReduction::Serep)?)),
        }
    }

    fn mass(&self, reduction: MassReduction) -> Result<DMatrix<f64>, CorrelationError> {
        /// Relative singular value below which the sensors miss a direction: expansion would multiply noise by more.
        const SEEN: f64 = 1e-3;
        let p = &self.a.prediction;
        let dense = || self.system();
        let s = self.sensors();
        let failed = |reason: String| CorrelationError::Reduction { method: reduction.name(), reason };
        let reduced = match reduction {
            MassReduction::Auto => return self.best().map(|(_, mass)| mass),
            MassReduction::Full if s.nrows() < s.ncols() => {
                return Err(failed(format!("{} sensors do not see all {} dofs", s.nrows(), s.ncols())));
            }
            MassReduction::Full => {
                // Columns in comparable units: rotations weigh as the displacements of the modes do.
                let scale: Vec<f64> = p.modes.shapes.row_iter().map(|r| r.norm().max(f64::MIN_POSITIVE)).collect();
                let scaled = DMatrix::from_fn(s.nrows(), s.ncols(), |i, j| s[(i, j)] * scale[j]);
                let svd = thin_svd(&scaled)?;
                if svd.rank(SEEN) < s.ncols() {
                    return Err(failed(format!("{} sensors do not see all {} dofs", s.nrows(), s.ncols())));
                }
                let mut inverse = svd.pseudo_inverse(SEEN);
                for (mut row, scale) in inverse.row_iter_mut().zip(&scale) {
                    row *= *scale;
                }
                return Ok(inverse.tr_mul(&(&dense()?.mass * &inverse)));
            }
            MassReduction::Guyan => {
                let system = dense()?;
                guyan(&system.stiffness, &system.mass, &s)
            }
            MassReduction::Irs => {
                let system = dense()?;
                irs(&system.stiffness, &system.mass, &s, 1)
            }
            MassReduction::Dynamic => {
                let pairs = pairs_with_shapes(self.a);
                let squares = pairs.iter().map(|p| (std::f64::consts::TAU * p.model_hz).powi(2));
                let system = dense()?;
                dynamic_reduction(&system.stiffness, &system.mass, &s, squares.sum::<f64>() / pairs.len() as f64)
            }
            MassReduction::Serep => {
                let rigid = 0..p.modes.n_rigid;
                let elastic = pairs_with_shapes(self.a).into_iter().map(|q| p.modes.n_rigid + q.model_mode);
                let with_rigid: Vec<usize> = rigid.chain(elastic.clone()).collect();
                // Sensors along one direction cannot tell all rigid-body modes apart; the elastic ones do without.
                let by = |modes: &[usize]| {
                    let phi = p.modes.shapes.select_columns(modes);
                    serep_transformation(&phi, &(&s * &phi))
                };
                let t = by(&with_rigid).or_else(|_| by(&elastic.collect::<Vec<_>>()));
                return t.map(|t| t.tr_mul(&p.matrices.mass_times(&t))).map_err(|e| failed(e.to_string()));
            }
        };
        reduced.map(|r| r.mass).map_err(|e| failed(e.to_string()))
    }
}
