//! What parameters that cannot be told apart have in common: products, mass, moments.

use crate::correlation::{CoupledGroup, Identifiability};
use crate::linalg::{DMatrix, DVector};
use crate::model::{MassProperties, ParametricModel};
use crate::objective::Scaling;

/// Parameters that data of this kind cannot tell apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Inseparable {
    /// Their names.
    pub parameters: Vec<String>,
    /// Through how many numbers they act; 0 when they have no effect at all.
    pub n_numbers: usize,
    /// The numbers, at this point: combinations such as `Ix1 + 2 Ix4_9`, products such as `E · Iy`.
    pub combinations: Vec<String>,
    /// Physical quantities that stay the same along everything that the data cannot see: these are determined.
    pub shared: Vec<String>,
}

/// Largest relative change along an unseen direction of a quantity that counts as unchanged. The quantities are
/// differentiated by differences, with relative errors of about 1e-9.
const UNCHANGED: f64 = 1e-5;

/// The sets of parameters that cannot be told apart at θ.
pub(super) fn inseparable(
    model: &dyn ParametricModel,
    theta: &[f64],
    scaling: &Scaling,
    seen: &Identifiability,
) -> Vec<Inseparable> {
    let gradients = mass_gradients(model, theta, scaling);
    let one = |group: &CoupledGroup| {
        let null = seen.null_space.select_rows(&group.parameters);
        let shared = gradients.iter().filter(|(_, gradient)| {
            let own = gradient.select_rows(&group.parameters);
            own.norm() > 1e-9 * gradient.norm() && own.norm() > 0.0 && null.tr_mul(&own).norm() < UNCHANGED * own.norm()
        });
        let in_words = seen.combinations_in_words(group);
        let combinations = (0..group.combinations.nrows())
            .map(|r| product_in_words(model, theta, scaling, seen, group, r).unwrap_or_else(|| in_words[r].clone()))
            .collect();
        Inseparable {
            parameters: group.parameters.iter().map(|&i| seen.names[i].clone()).collect(),
            n_numbers: group.combinations.nrows(),
            combinations,
            shared: shared.map(|(name, _)| name.clone()).collect(),
        }
    };
    seen.groups.iter().map(one).collect()
}

/// Gradients over x of total mass, first moments and moments of inertia about the origin: sums over the structure, so
/// that parameters of one place stay together.
fn mass_gradients(model: &dyn ParametricModel, theta: &[f64], scaling: &Scaling) -> Vec<(String, DVector<f64>)> {
    let axes = ["x", "y", "z"];
    let values = |p: &MassProperties| {
        let mut v = vec![("total mass".to_string(), p.mass)];
        v.extend((0..3).map(|i| (format!("first moment of mass along {}", axes[i]), p.mass * p.cg[i])));
        v.extend(
            (0..3).map(|i| (format!("moment of inertia about the {} axis", axes[i]), p.moment_about(i, [0.0; 3]))),
        );
        v
    };
    let n = scaling.len();
    let mut out: Vec<(String, DVector<f64>)> = Vec::new();
    for (column, (&j, width)) in scaling.free().iter().zip(scaling.slopes(theta)).enumerate() {
        let shifted = |sign: f64| {
            let mut theta = theta.to_vec();
            theta[j] += sign * 1e-6 * width;
            model.mass_properties(&theta).ok().flatten().map(|p| values(&p))
        };
        let (Some(above), Some(below)) = (shifted(1.0), shifted(-1.0)) else { return Vec::new() };
        if out.is_empty() {
            out = above.iter().map(|(name, _)| (name.clone(), DVector::zeros(n))).collect();
        }
        for (k, ((_, a), (_, b))) in above.iter().zip(&below).enumerate() {
            out[k].1[column] = (a - b) / 2e-6;
        }
    }
    out
}

/// A combination whose parts are equal relative changes may be a product: `E · Iy`, `b · h^3`, `m / L`. It is one if the
/// matrices stay as they are when two of its members change a good deal and the product does not.
fn product_in_words(
    model: &dyn ParametricModel,
    theta: &[f64],
    scaling: &Scaling,
    seen: &Identifiability,
    group: &CoupledGroup,
    row: usize,
) -> Option<String> {
    let value = |k: usize| theta[scaling.free()[group.parameters[k]]];
    let parts: Vec<(usize, f64)> = (0..group.parameters.len())
        .filter(|&k| group.combinations[(row, k)] != 0.0)
        .map(|k| (k, group.combinations[(row, k)] * value(k)))
        .collect();
    let least = parts.iter().map(|(_, v)| v.abs()).fold(f64::INFINITY, f64::min);
    if parts.len() < 2 || least == 0.0 {
        return None;
    }
    let sign = parts[0].1.signum();
    let powers: Vec<i32> = parts
        .iter()
        .map(|(_, part)| sign * part / least)
        .map(|p| ((p - p.round()).abs() < 1e-3 && p.abs() < 4.5).then_some(p.round() as i32))
        .collect::<Option<_>>()?;
    let mut moved = theta.to_vec();
    moved[scaling.free()[group.parameters[parts[0].0]]] *= 1.1;
    moved[scaling.free()[group.parameters[parts[1].0]]] *= 1.1f64.powf(-f64::from(powers[0]) / f64::from(powers[1]));
    let (before, after) = (model.assemble(theta).ok()?, model.assemble(&moved).ok()?);
    let same = |a: &DMatrix<f64>, b: &DMatrix<f64>| (a - b).amax() < 1e-9 * a.amax();
    if !same(&before.stiffness, &after.stiffness) || !same(&before.mass, &after.mass) {
        return None;
    }
    let mut text = String::new();
    for ((k, _), power) in parts.iter().zip(powers) {
        text += match (text.is_empty(), power < 0) {
            (true, _) => "",
            (false, false) => " · ",
            (false, true) => " / ",
        };
        text += &seen.names[group.parameters[*k]];
        if power.abs() > 1 {
            text += &format!("^{}", power.abs());
        }
    }
    Some(text)
}
