//! Stiffnesses and dashpots of a six-direction joint, shared by `ground_spring` and `bushing`.

use super::{Domain, ElementError, ElementInput, Property};
use crate::linalg::SymMatrix;

const fn stiffness(name: &'static str, unit: &'static str, description: &'static str) -> Property {
    Property::new(name, unit, Domain::NonNegative, description)
}

/// The twelve properties: `k_ux` ... `k_rz`, then `c_ux` ... `c_rz`.
pub(crate) const JOINT: [Property; 12] = [
    stiffness("k_ux", "N/m", "stiffness along x"),
    stiffness("k_uy", "N/m", "stiffness along y"),
    stiffness("k_uz", "N/m", "stiffness along z"),
    stiffness("k_rx", "N m/rad", "rotational stiffness about x"),
    stiffness("k_ry", "N m/rad", "rotational stiffness about y"),
    stiffness("k_rz", "N m/rad", "rotational stiffness about z"),
    stiffness("c_ux", "N s/m", "dashpot along x"),
    stiffness("c_uy", "N s/m", "dashpot along y"),
    stiffness("c_uz", "N s/m", "dashpot along z"),
    stiffness("c_rx", "N m s/rad", "rotational dashpot about x"),
    stiffness("c_ry", "N m s/rad", "rotational dashpot about y"),
    stiffness("c_rz", "N m s/rad", "rotational dashpot about z"),
];

/// Which half of [`JOINT`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Half {
    Stiffness,
    Damping,
}

/// `Σ k_d s_d s_dᵀ`: the matrix of six uncoupled springs (or dashpots) whose elongations are `stretch[d] · q`.
///
/// Refuses a joint of which nothing is given: it would be silently absent.
pub(crate) fn joint_matrix(
    input: &ElementInput<'_>,
    stretch: &[Vec<f64>; 6],
    half: Half,
) -> Result<SymMatrix, ElementError> {
    let values = &input.values[..JOINT.len()];
    if values.iter().all(Option::is_none) {
        return Err(ElementError::Missing {
            name: "k_ux",
            why: "give at least one of `k_ux` ... `k_rz` or `c_ux` ... `c_rz`, zero if it is to be updated from zero",
        });
    }
    let first = if half == Half::Stiffness { 0 } else { 6 };
    let mut matrix = SymMatrix::zeros(6 * input.points.len());
    for (value, direction) in values[first..first + 6].iter().zip(stretch) {
        matrix.add_outer(value.unwrap_or(0.0), direction);
    }
    Ok(matrix)
}
