//! The strains within an element of a mesh, from which the error of the mesh is estimated and its preload is taken.

use crate::linalg::SymMatrix;

/// Strains at points of a shell or of a solid, as combinations of its dofs.
///
/// Of a shell the six strains are εxx εyy γxy of its mid-surface and κxx κyy κxy, in the axes of its plane; of a solid xx yy zz xy yz zx in the
/// axes of the element.
#[derive(Debug, Clone)]
pub struct StrainField {
    /// Where they are known.
    pub points: Vec<StrainPoint>,
    /// Forces and moments by width of a shell, or stresses of a solid, by the strains: the energy of a point is ½ εᵀ D ε by area or volume.
    pub rigidity: [[f64; 6]; 6],
    /// Axes x, y and normal of the plane of a shell, in the axes of the element; `None` of a solid.
    pub plane: Option<[[f64; 3]; 3]>,
    /// Order of the functions of the displacements, which is the order of the strains that a finer mesh would have.
    pub order: usize,
    /// The stiffness against motions that its strains do not see, (6 nodes) x (6 nodes), where it has one: hourglass patterns of reduced integration.
    pub hourglass: Option<SymMatrix>,
    /// The consistent mass with the displacements within the element that go with its strains and that the functions of its nodes do not have,
    /// (6 nodes) x (6 nodes).
    pub mass: SymMatrix,
}

/// A point of a [`StrainField`].
#[derive(Debug, Clone)]
pub struct StrainPoint {
    /// Where it is, in the axes of the element, relative to the first node, m.
    pub at: [f64; 3],
    /// The functions of the nodes there.
    pub n: Vec<f64>,
    /// Area or volume that it stands for; zero of a point at which strains are only sampled.
    pub weight: f64,
    /// Whether the strains there are sampled for a recovery: at such points they are the most accurate.
    pub is_sample: bool,
    /// Row i times the dofs of the element, six a node, is strain i.
    pub rows: [Vec<f64>; 6],
}

impl StrainPoint {
    /// The strains for displacements of the element.
    pub fn strains(&self, u: &[f64]) -> [f64; 6] {
        std::array::from_fn(|i| self.rows[i].iter().zip(u).map(|(row, u)| row * u).sum())
    }
}

impl StrainField {
    /// Forces or stresses in the mean over the element, for displacements of it.
    pub fn mean_forces(&self, u: &[f64]) -> [f64; 6] {
        let whole: f64 = self.points.iter().map(|p| p.weight).sum();
        let mut mean = [0.0; 6];
        for p in self.points.iter().filter(|p| p.weight > 0.0) {
            for (mean, strain) in mean.iter_mut().zip(p.strains(u)) {
                *mean += p.weight / whole * strain;
            }
        }
        self.rigidity.map(|row| row.iter().zip(&mean).map(|(d, e)| d * e).sum())
    }
}
