//! How symmetric motions of a stand-in are.

use super::StandIn;
use crate::linalg::{DMatrix, DVector, tall_tr_mul};
use crate::model::ParametricModel;

/// The forms on coordinates whose ratio is the correlation of a motion with its mirror image.
#[derive(Debug, Clone)]
pub(super) struct Forms {
    /// BᵀPB, P the reflection of the rows.
    reflected: DMatrix<f64>,
    /// BᵀB.
    own: DMatrix<f64>,
}

impl StandIn {
    /// The correlation of a motion with its mirror image, as [`crate::model::symmetry_index`] of the rows of the model, without coordinates that changes
    /// bring; `None` where the model has no plane of symmetry.
    ///
    /// ```text
    /// yᵀ Bᵀ P B y / yᵀ Bᵀ B y,    B = [V W]
    /// ```
    pub fn symmetry_index(&self, y: impl Fn(usize) -> f64) -> Option<f64> {
        let mirror = self.common.model.mirror()?;
        let forms = self.symmetry.get_or_find(|| self.forms(mirror));
        let y = DVector::from_fn(forms.own.nrows(), |i, _| y(i));
        let own = y.dot(&(&forms.own * &y));
        Some(if own > 0.0 { y.dot(&(&forms.reflected * &y)) / own } else { 0.0 })
    }

    /// Those of the basis are found once for all stand-ins of a model.
    fn forms(&self, mirror: &[(usize, f64)]) -> Forms {
        let (v, w) = (&self.common.basis, &*self.extra);
        let reflect =
            |b: &DMatrix<f64>| DMatrix::from_fn(b.nrows(), b.ncols(), |i, c| mirror[i].1 * b[(mirror[i].0, c)]);
        let of_basis = self
            .common
            .symmetry
            .get_or_find(|| Forms { reflected: tall_tr_mul(&reflect(v), v), own: tall_tr_mul(v, v) });
        let (m, k) = (v.ncols(), w.ncols());
        let mut forms = Forms {
            reflected: of_basis.reflected.clone().resize(m + k, m + k, 0.0),
            own: of_basis.own.clone().resize(m + k, m + k, 0.0),
        };
        if k > 0 {
            let reflected = reflect(w);
            for (all, by) in [(&mut forms.reflected, &reflected), (&mut forms.own, w)] {
                let across = tall_tr_mul(by, v);
                all.view_mut((m, 0), (k, m)).copy_from(&across);
                all.view_mut((0, m), (m, k)).copy_from(&across.transpose());
                all.view_mut((m, m), (k, k)).copy_from(&tall_tr_mul(by, w));
            }
        }
        forms
    }
}
