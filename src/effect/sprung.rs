//! A body on a spring at a node, in translation or in rotation: what `sprung-mass`, `sprung-inertia` and `flexible-mount` share.

use super::edit::{Edit, NewParameter, PatchError, scalar};
use super::location::Location;
use super::patch::{Builder, Patch, body_at, entry, round};
use super::structure::Structure;
use crate::element::Dof;
use crate::model::ParametricModel;
use crate::model::spec::{DofName, Named, NodeRule, NodeSpec, RigidLinkSpec, SpringSpec};
use crate::units::Scalar;
use std::f64::consts::TAU;

/// Nodes that move along or about these axes; nodes of one rigid body turn alike, and the first stands for all.
pub(super) fn store_locations(structure: &Structure<'_>, dofs: &[Dof]) -> Vec<Location> {
    if structure.total_mass() <= 0.0 || structure.extent() <= 0.0 {
        return Vec::new();
    }
    let mut all = Vec::new();
    for &dof in dofs {
        let motion = |n: usize| structure.model().dof_map().express(n, dof);
        let first = |n: usize| !dof.is_rotation() || (0..n).all(|other| motion(other) != motion(n));
        let nodes = structure.nodes(|n| structure.node_moves(n, dof) && first(n));
        all.extend(nodes.into_iter().map(|at| at.along(dof.name())));
    }
    all
}

/// A node, a spring, a body and, in translation, a link for the other directions.
pub(super) fn store_patch(effect: &str, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
    let unknown = || PatchError::unknown_place(effect, &at.to_string(), &[]);
    let dof = Dof::from_name(at.direction()).ok_or_else(unknown)?;
    let rotation = dof.is_rotation();
    let mut b = Builder::new(effect, at);
    let arm = if rotation { 0.05 * structure.extent() } else { 1.0 };
    let typical = 0.02 * structure.total_mass() * arm * arm;
    let place = at.place();
    let (quantity, unit) = if rotation { ("inertia", "kg m2") } else { ("mass", "kg") };
    let about = format!("{quantity} on a spring at {place}");
    let m = b.parameter(quantity, unit, typical, [0.0, 25.0 * typical], &about);
    let about = format!("stiffness of the spring at {place}; any value is neutral while the {quantity} is zero");
    let stores = on_springs(&mut b, structure, &at.names, (&[dof], typical, |_| about.clone()));
    let mut body = body_at(&stores);
    if rotation {
        let axis = &dof.name()[1..];
        body.inertia = entry(&format!("{axis}{axis}"), &m);
    } else {
        body.mass = Some(scalar(&m));
    }
    let name = b.stem().to_string();
    b.edit(Edit::AddMass { name, entry: body });
    Ok(b.finish())
}

/// Nodes of their own beside hosts, each on a spring of one stiffness in a direction, or in each of several, and in translation on a link for the
/// others. A stiffness is a parameter, and its grid tunes the body to every mode.
///
/// * `spring` - its directions, the mass or inertia of the body, and what its stiffness is, along one of several
pub(super) fn on_springs(
    b: &mut Builder,
    structure: &Structure<'_>,
    hosts: &[String],
    (dofs, body, about): (&[Dof], f64, impl Fn(&str) -> String),
) -> Vec<String> {
    let stiffness = |omega2: f64| round(body * omega2);
    let k0 = stiffness(structure.omega2());
    let rotation = dofs.iter().any(|dof| dof.is_rotation());
    let mut k = Named::new();
    for dof in dofs {
        let (of, along) = match dofs {
            [_] => (String::new(), String::new()),
            _ => (format!("_{dof}"), format!(" along {}", &dof.name()[1..])),
        };
        let name = b.add(NewParameter {
            name: format!("{}.stiffness{of}", b.stem()),
            unit: if rotation { "N m/rad" } else { "N/m" }.to_string(),
            neutral: k0,
            typical: k0,
            bounds: [round(1e-4 * k0), round(1e4 * k0)],
            grid: squares_of_modes(structure).into_iter().map(stiffness).collect(),
            description: about(&along),
        });
        k.extend(entry(dof.name(), &name));
    }
    let suffix = |i: usize| if hosts.len() > 1 { format!(".{}", i + 1) } else { String::new() };
    let mut stores = Vec::new();
    for (i, host) in hosts.iter().enumerate() {
        let store = format!("{}.store{}", b.stem(), suffix(i));
        let zero = || Scalar::constant(0.0);
        let rule = NodeRule { from: Some(host.clone()), offset: Some([zero(), zero(), zero()]), ..NodeRule::default() };
        b.edit(Edit::AddNode { name: store.clone(), entry: NodeSpec::Rule(rule) });
        let nodes = Some([host.clone(), store.clone()]);
        let name = format!("{}.spring{}", b.stem(), suffix(i));
        b.edit(Edit::AddSpring { name, entry: SpringSpec { nodes, k: k.clone(), ..SpringSpec::default() } });
        // Beside the spring's directions the body follows the host, and turns with it.
        let all = [DofName::Ux, DofName::Uy, DofName::Uz, DofName::Rx, DofName::Ry, DofName::Rz];
        let follows: Vec<DofName> = all
            .into_iter()
            .filter(|d| !rotation && !dofs.contains(&Dof::from(*d)) && active(structure, Dof::from(*d)))
            .collect();
        if !follows.is_empty() {
            let name = format!("{}.link{}", b.stem(), suffix(i));
            let entry = RigidLinkSpec {
                master: host.clone(),
                slaves: vec![store.clone()],
                dofs: Some(follows),
                compliance: Named::default(),
            };
            b.edit(Edit::AddRigidLink { name, entry });
        }
        stores.push(store);
    }
    stores
}

/// Where modes lie, as ω²: those of the tests, or some about the lowest of the model.
fn squares_of_modes(structure: &Structure<'_>) -> Vec<f64> {
    let known = &structure.context().frequencies_hz;
    if known.is_empty() {
        [0.25, 1.0, 4.0, 16.0, 64.0].map(|f| f * structure.omega2()).to_vec()
    } else {
        known.iter().filter(|f| **f > 0.0).map(|f| (TAU * f).powi(2)).collect()
    }
}

/// Whether a dof exists in the model.
fn active(structure: &Structure<'_>, dof: Dof) -> bool {
    structure.model().spec().active_dofs.as_ref().is_none_or(|a| a.iter().any(|d| Dof::from(*d) == dof))
}
