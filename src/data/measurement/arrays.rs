//! Arrays without names or units: NumPy files, and the variables of MATLAB files.

use super::{FrfOptions, MeasurementError};
use crate::data::convert::{ConvertError, Question, UnitSystem, UnitsFrom};
use crate::data::{Channel, FrfSet, mat, npy};
use crate::linalg::Complex;

/// What the variables of a MATLAB file are.
pub(super) enum Variables {
    /// A vector of frequencies and a matrix of functions.
    Functions(Vec<npy::Array>),
    /// A frequency in Hz and a shape.
    Mode(f64, Vec<Complex<f64>>),
}

/// Recognises functions (one real vector of frequencies in Hz, one complex array (lines x responses) or (lines x references
/// x responses)) or one mode (one number, its frequency in Hz, and one vector, its shape). Also returns the names of the two.
pub(super) fn variables(list: &[(String, mat::Value)]) -> Result<(Variables, [String; 2]), MeasurementError> {
    let mut arrays: Vec<(&String, npy::Array)> = Vec::new();
    for (name, value) in list {
        if let mat::Value::Real { dims, values } = value {
            arrays.push((name, by_rows(dims, values, npy::Values::Real)));
        } else if let mat::Value::Complex { dims, values } = value {
            arrays.push((name, by_rows(dims, values, npy::Values::Complex)));
        }
    }
    let names: Vec<&str> = list.iter().map(|(n, _)| n.as_str()).collect();
    let wrong = || {
        MeasurementError::Arrays(format!(
            "the MATLAB file has the variables {}; needed are a real vector of frequencies in Hz with a complex array (lines x \
             responses) or (lines x references x responses), or one frequency in Hz with a vector that is its shape",
            if names.is_empty() { "(none)".to_string() } else { names.join(", ") }
        ))
    };
    let (first, second) = match &arrays[..] {
        [(a, x), (b, y)] if x.n_values() <= y.n_values() => ((*a, x), (*b, y)),
        [(a, x), (b, y)] => ((*b, y), (*a, x)),
        _ => return Err(wrong()),
    };
    let pair = [first.0.clone(), second.0.clone()];
    let npy::Values::Real(frequencies) = &first.1.values else { return Err(wrong()) };
    let is_vector = |a: &npy::Array| a.shape.iter().filter(|n| **n != 1).count() <= 1;
    if frequencies.len() == 1 && is_vector(second.1) && second.1.n_values() > 1 {
        let shape = match &second.1.values {
            npy::Values::Real(v) => v.iter().map(|x| Complex::new(*x, 0.0)).collect(),
            npy::Values::Complex(v) => v.clone(),
        };
        return Ok((Variables::Mode(frequencies[0], shape), pair));
    }
    if !is_vector(first.1) || !matches!(second.1.values, npy::Values::Complex(_)) {
        return Err(wrong());
    }
    let flat = npy::Array { shape: vec![frequencies.len()], values: npy::Values::Real(frequencies.clone()) };
    Ok((Variables::Functions(vec![flat, second.1.clone()]), pair))
}

/// MATLAB's order, first index fastest, turned to rows.
fn by_rows<T: Copy>(dims: &[usize], values: &[T], wrap: fn(Vec<T>) -> npy::Values) -> npy::Array {
    let n = values.len();
    let mut out = Vec::with_capacity(n);
    for k in 0..n {
        // The index with the last dimension fastest, as an offset with the first fastest.
        let (mut rest, mut at) = (k, 0);
        for (d, size) in dims.iter().enumerate().rev() {
            at += rest % size * dims[..d].iter().product::<usize>();
            rest /= size;
        }
        out.push(values[at]);
    }
    npy::Array { shape: dims.to_vec(), values: wrap(out) }
}

/// Functions of a real array of frequencies and a complex array of values.
pub(super) fn functions(arrays: &[npy::Array], options: &FrfOptions) -> Result<FrfSet, MeasurementError> {
    let wrong = |text: String| MeasurementError::Arrays(text);
    let mut frequencies = None;
    let mut functions = None;
    for array in arrays {
        match (&array.values, array.shape.as_slice()) {
            (npy::Values::Real(f), [_]) if frequencies.is_none() => frequencies = Some(f),
            (npy::Values::Complex(h), [lines, responses]) if functions.is_none() => {
                functions = Some((h, *lines, 1, *responses));
            }
            (npy::Values::Complex(h), [lines, references, responses]) if functions.is_none() => {
                functions = Some((h, *lines, *references, *responses));
            }
            (_, shape) => {
                return Err(wrong(format!(
                    "an array of shape {shape:?} does not fit; needed are one real (lines) in Hz and one complex (lines x responses) or (lines x references x responses)"
                )));
            }
        }
    }
    let frequencies_hz: Vec<f64> =
        frequencies.ok_or_else(|| wrong("the real array of frequencies in Hz is missing".to_string()))?.clone();
    let (h, lines, n_references, n_responses) =
        functions.ok_or_else(|| wrong("the complex array of functions is missing".to_string()))?;
    if lines != frequencies_hz.len() {
        return Err(wrong(format!("{} frequencies for {lines} lines of functions", frequencies_hz.len())));
    }
    if let Some(line) = (1..lines).find(|&l| frequencies_hz[l].is_nan() || frequencies_hz[l] <= frequencies_hz[l - 1]) {
        return Err(ConvertError::NotAscending { function: "frequencies".to_string(), line }.into());
    }
    let mut questions = Vec::new();
    let UnitsFrom::System(system) = &options.units else {
        questions.push(Question {
            option: "units",
            text: "an array has no units".to_string(),
            answers: UnitSystem::NAMES.map(String::from).to_vec(),
        });
        return Err(ConvertError::Questions(questions).into());
    };
    let Some(quantity) = options.quantity else {
        questions.push(Question {
            option: "quantity",
            text: "an array does not say what was measured".to_string(),
            answers: ["receptance", "mobility", "accelerance"].map(String::from).to_vec(),
        });
        return Err(ConvertError::Questions(questions).into());
    };
    let scale = system.response(quantity) / system.force;
    let channels = |prefix: &str, n: usize| {
        (0..n).map(|k| Channel { name: format!("{prefix}{}", k + 1), direction: None }).collect::<Vec<_>>()
    };
    Ok(FrfSet {
        quantity,
        frequencies_hz,
        references: channels("force", n_references),
        responses: channels("p", n_responses),
        h: h.iter().map(|v| v * scale).collect(),
        coherence: None,
        n_averages: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variables_of_matlab_are_functions_or_a_mode() {
        let f = ("f".to_string(), mat::Value::Real { dims: vec![2, 1], values: vec![1.0, 2.0] });
        let h = (0..6).map(|k| Complex::new(f64::from(k), 1.0)).collect();
        let h = ("H".to_string(), mat::Value::Complex { dims: vec![2, 3], values: h });
        let (Variables::Functions(list), names) = variables(&[h, f.clone()]).unwrap() else { panic!() };
        assert_eq!(names, ["f", "H"]);
        let npy::Values::Complex(rows) = &list[1].values else { panic!() };
        // Columns (0 1), (2 3), (4 5) of MATLAB: rows 0 2 4 and 1 3 5.
        assert_eq!(rows.iter().map(|v| v.re).collect::<Vec<_>>(), [0.0, 2.0, 4.0, 1.0, 3.0, 5.0]);
        let one = ("freq".to_string(), mat::Value::Real { dims: vec![1, 1], values: vec![7.5] });
        let (Variables::Mode(hz, shape), _) = variables(&[f.clone(), one]).unwrap() else { panic!() };
        assert_eq!((hz, shape.len()), (7.5, 2));
        let text = variables(&[f]).err().unwrap().to_string();
        assert!(text.contains("variables f;"), "{text}");
    }
}
