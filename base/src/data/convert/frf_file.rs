//! Frequency response functions to a universal file.

use super::ConvertError;
use super::ends::{COHERENCE, EXCITATION_FORCE, FREQUENCY, FRF};
use super::geometry::{labels, si};
use crate::data::uff::{Abscissa, Axis, Dataset, Entity, Function, Ordinate, Precision, Storage, UniversalFile};
use crate::data::{Channel, FrfQuantity, FrfSet};
use retune_linalg::Complex;

fn data_type_of(quantity: FrfQuantity) -> i64 {
    match quantity {
        FrfQuantity::Receptance => 8,
        FrfQuantity::Mobility => 11,
        FrfQuantity::Accelerance => 12,
    }
}

/// The direction code along a global axis.
fn code(channel: &Channel) -> Result<i64, ConvertError> {
    let Some(direction) = channel.direction else { return Ok(0) };
    // Unit vectors that went through a rotation are exact to a few units of rounding.
    let axis = (0..3).find(|i| direction[*i].abs() > 1.0 - 1.0e-12);
    let axis = axis.ok_or_else(|| ConvertError::NotAlongAnAxis { name: channel.name.clone() })?;
    let code = axis as i64 + 1;
    Ok(if direction[axis] < 0.0 { -code } else { code })
}

/// Writes functions as datasets 164 and 58, in SI and double precision; coherences follow their functions.
///
/// Points whose names are numbers keep them as labels; others get free labels and their name as entity. With
/// [`Storage::Binary`] every bit is kept; an abscissa that start and step do not give exactly is written out.
///
/// # Errors
/// [`ConvertError::NotAlongAnAxis`] for a direction that is not along a global axis.
pub fn frf_file(set: &FrfSet, storage: Storage) -> Result<UniversalFile, ConvertError> {
    let labels = labels(set.references.iter().chain(&set.responses).map(|c| c.name.as_str()));
    let entity = |c: &Channel| -> Result<Entity, ConvertError> {
        let node = labels[c.name.as_str()];
        let name = if node.to_string() == c.name { "NONE".to_owned() } else { c.name.clone() };
        Ok(Entity { name, node, direction: code(c)? })
    };
    let x = &set.frequencies_hz;
    let start = x.first().copied().unwrap_or(0.0);
    let step = if x.len() > 1 { x[1] - x[0] } else { 1.0 };
    // Text columns hold six digits of start and step for certain.
    let is_short = |v: f64| format!("{v:.5e}").parse() == Ok(v);
    let is_even = is_short(start) && is_short(step) && x.iter().enumerate().all(|(i, f)| *f == start + i as f64 * step);
    let abscissa = if is_even { Abscissa::Even { start, step } } else { Abscissa::Uneven(x.clone()) };
    let mut datasets = vec![si()];
    for (a, reference) in set.references.iter().enumerate() {
        for (b, response) in set.responses.iter().enumerate() {
            let values: Vec<Complex<f64>> = (0..set.n_lines()).map(|line| set.at(line, a, b)).collect();
            if values.iter().all(|v| v.re.is_nan()) {
                continue;
            }
            let base = Function {
                ids: std::array::from_fn(|i| if i == 0 { "written by retune" } else { "NONE" }.to_owned()),
                function_type: FRF,
                function_id: 0,
                version: 0,
                load_case: 0,
                response: entity(response)?,
                reference: entity(reference)?,
                precision: Precision::Double,
                abscissa: abscissa.clone(),
                ordinate: Ordinate::Complex(values),
                z_value: 0.0,
                axes: [
                    Axis::of(FREQUENCY),
                    Axis::of(data_type_of(set.quantity)),
                    Axis::of(EXCITATION_FORCE),
                    Axis::of(0),
                ],
                storage,
            };
            if let Some(coherence) = &set.coherence {
                let values: Vec<f64> = (0..set.n_lines()).map(|line| coherence[set.index(line, a, b)]).collect();
                let mut f = base.clone();
                f.function_type = COHERENCE;
                f.ordinate = Ordinate::Real(values);
                f.axes = [Axis::of(FREQUENCY), Axis::of(0), Axis::of(0), Axis::of(0)];
                datasets.push(Dataset::from(base));
                datasets.push(Dataset::from(f));
            } else {
                datasets.push(Dataset::from(base));
            }
        }
    }
    Ok(UniversalFile { datasets })
}
