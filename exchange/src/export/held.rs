//! An updated model held against the one that its deck gives: what is not a value and cannot be written, and what each value should be.

use retune::element::Property;
use retune::linalg::vector3::dot;
use retune::model::{Model, ModelSpec, ParametricModel, PlacedElement, Value, plied, spec::Named};

/// Values that differ by less are the same: the same text gives the same bits, and sums of products differ by rounding.
pub(super) const SAME: f64 = 1e-12;

/// Components of axes that differ by less are the same.
const SAME_AXES: f64 = 1e-9;

/// Whether two values are the same; none is zero.
pub(super) fn is_same(a: Option<f64>, b: Option<f64>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => (a - b).abs() <= SAME * a.abs().max(b.abs()),
        (Some(a), None) | (None, Some(a)) => a == 0.0,
        (None, None) => true,
    }
}

fn differences<T: PartialEq>(room: &str, base: &Named<T>, updated: &Named<T>, out: &mut Vec<String>) {
    for (name, entry) in base {
        match updated.get(name) {
            None => out.push(format!("{room}.{name}: it was taken out, and export does not delete from a deck")),
            Some(now) if now != entry => {
                out.push(format!("{room}.{name}: it changed, and no field holds that; edit the deck"));
            }
            Some(_) => {}
        }
    }
    for name in updated.keys().filter(|n| !base.contains_key(*n)) {
        out.push(format!("{room}.{name}: it was added, and export writes nothing for it; add it to the deck by hand"));
    }
}

/// Supports, links and constraints that are not as they were: each why.
pub(super) fn structure(base: &ModelSpec, updated: &ModelSpec) -> Vec<String> {
    let mut out = Vec::new();
    differences("supports", &base.supports, &updated.supports, &mut out);
    differences("rigid_links", &base.rigid_links, &updated.rigid_links, &mut out);
    differences("weighted_links", &base.weighted_links, &updated.weighted_links, &mut out);
    differences("ties", &base.ties, &updated.ties, &mut out);
    differences("constraints", &base.constraints, &updated.constraints, &mut out);
    if base.modal_damping != updated.modal_damping {
        out.push(
            "modal_damping: it changed, and export writes no damping of modes; add it to the deck by hand".to_string(),
        );
    }
    out
}

/// Why an element is another one, and not the same with other values.
///
/// * `is_turned` - whether it was [turned] about itself
pub(super) fn is_other(
    base: &Model,
    updated: &Model,
    old: &PlacedElement,
    new: &PlacedElement,
    is_turned: bool,
) -> Option<String> {
    let size = base.geometry().size();
    let nodes = |m: &Model, e: &PlacedElement| -> Vec<String> {
        e.nodes.iter().map(|n| m.geometry().names[*n].clone()).collect()
    };
    let apart = |a: &[[f64; 3]], b: &[[f64; 3]], by: f64| {
        a.iter().flatten().zip(b.iter().flatten()).any(|(a, b)| (a - b).abs() > by)
    };
    let differs = old.kind.name() != new.kind.name()
        || nodes(base, old) != nodes(updated, new)
        || (!is_turned && apart(&old.axes, &new.axes, SAME_AXES))
        || old.arms.len() != new.arms.len()
        || apart(&old.arms, &new.arms, 1e-10 * size);
    differs.then(|| format!("{}: its nodes, axes or offsets changed, and export writes values only", new.path))
}

/// By how much a beam was turned about its own axis, rad, if that alone is new of its axes.
pub(super) fn turned(old: &PlacedElement, new: &PlacedElement) -> Option<f64> {
    let ([x, y, z], [along, now, _]) = (&old.axes, &new.axes);
    let is_same = |a: &[f64; 3], b: &[f64; 3]| (0..3).all(|i| (a[i] - b[i]).abs() <= SAME_AXES);
    (old.kind.name() == "beam" && is_same(x, along) && !is_same(y, now)).then(|| dot(*now, *z).atan2(dot(*now, *y)))
}

/// Whether an element has damping of its own.
pub(super) fn is_damped(e: &PlacedElement) -> bool {
    e.stiffness_damping.is_some() || e.mass_damping.is_some()
}

/// The place of a property of an element, its value as the deck gives it, and the one that it should have.
pub(super) type Wanted = (usize, Option<f64>, Option<f64>);

/// Each property of an element: its place, its value as the deck gives it, and the one that it should have, with the factors on the whole
/// stiffness and mass in it.
pub(super) fn wanted(old: &PlacedElement, new: &PlacedElement, theta0: &[f64], theta: &[f64]) -> Vec<Wanted> {
    let factor = |v: &Option<Value>, at: &[f64]| v.as_ref().map_or(1.0, |v| v.at(at));
    let k = factor(&new.stiffness_factor, theta) / factor(&old.stiffness_factor, theta0);
    let m = factor(&new.mass_factor, theta) / factor(&old.mass_factor, theta0);
    let (before, after) = (old.values_at(theta0), new.values_at(theta));
    let each = old.kind.properties().iter().zip(before.into_iter().zip(after)).enumerate();
    each.map(|(i, (property, (b, a)))| (i, b, a.map(|v| v * scale(property, k, m)))).collect()
}

/// Factor of a property where the whole stiffness is multiplied by `k` and the whole mass by `m`: moduli and spring constants carry the
/// one, densities and masses the other.
fn scale(property: &Property, k: f64, m: f64) -> f64 {
    match property.name {
        "E" | "G" | "E1" | "E2" | "E3" | "G12" | "G13" | "G23" | "EA" | "EIy" | "EIz" | "GJ" | "k" => k,
        "density"
        | "mass"
        | "added_mass_per_length"
        | "mass_per_length"
        | "mass_per_area"
        | "areal_mass"
        | "areal_moment"
        | "areal_inertia" => m,
        "shear_compliance_y" | "shear_compliance_z" => 1.0 / k,
        name if name.starts_with("k_") || is_rigidity(name) => k,
        name if name.starts_with("inertia_") || name.starts_with("m_") => m,
        "polar_inertia_per_length" | "rotary_inertia_y" | "rotary_inertia_z" => m,
        _ => 1.0,
    }
}

/// Whether a property is a rigidity of plies, `A11` to `S44`.
fn is_rigidity(name: &str) -> bool {
    let mut letters = name.chars();
    letters.next().is_some_and(|c| "ABDS".contains(c)) && name.len() == 3 && letters.all(|c| c.is_ascii_digit())
}

/// Numbers of plies by their paths: as the deck gives them, and as they should be.
pub(super) type Plies = Vec<(String, f64, f64)>;

/// What the plies of an element should be: paths of numbers with their values as the deck gives them and as they should be; none where it has no
/// plies.
///
/// # Errors
/// Rigidities or masses that are not those of the plies.
pub(super) fn plies(
    (base, old): (&Model, &PlacedElement),
    (updated, new): (&Model, &PlacedElement),
) -> Result<Option<Plies>, String> {
    let section = |e: &PlacedElement| e.section.clone();
    let Some(before) = section(old).and_then(|s| plied(base, &s)) else { return Ok(None) };
    let other = || format!("{}: it has plies in the deck no more, and export writes values only", new.path);
    let after = section(new).and_then(|s| plied(updated, &s)).ok_or_else(other)?;
    if before.numbers.len() != after.numbers.len() || before.numbers.iter().zip(&after.numbers).any(|(a, b)| a.0 != b.0)
    {
        return Err(other());
    }
    let (theta0, theta) = (base.parameters().nominal(), updated.parameters().nominal());
    let factor = |v: &Option<Value>, at: &[f64]| v.as_ref().map_or(1.0, |v| v.at(at));
    let k = factor(&new.stiffness_factor, &theta) / factor(&old.stiffness_factor, &theta0);
    let m = factor(&new.mass_factor, &theta) / factor(&old.mass_factor, &theta0);
    let has = new.values_at(&theta);
    let value = |name: &str| new.kind.properties().iter().position(|p| p.name == name).and_then(|i| has[i]);
    let size = after.rigidities.iter().map(|r| r.1.abs()).fold(0.0, f64::max);
    for (name, own) in &after.rigidities {
        let has = value(name).unwrap_or(0.0);
        if (has - own).abs() > 1e-9 * own.abs().max(has.abs()) && (has - own).abs() > 1e-15 * size {
            return Err(format!("{}: `{name}` is not that of its plies, and the deck has plies alone", new.path));
        }
    }
    let scaled = |name: &str| match name.rsplit('.').next().unwrap_or(name) {
        "E" | "E1" | "E2" | "G12" | "G13" | "G23" => k,
        "density" => m,
        _ => 1.0,
    };
    let each = before.numbers.iter().zip(&after.numbers);
    Ok(Some(each.map(|(a, b)| (a.0.clone(), a.1, b.1 * scaled(&b.0))).collect()))
}

/// Whether a property follows from plies.
pub(super) fn is_of_plies(name: &str) -> bool {
    is_rigidity(name) || name.starts_with("areal_")
}
