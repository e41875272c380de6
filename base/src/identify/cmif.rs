//! The complex mode indicator function: singular values of the FRF matrix, line by line.

use super::IdentifyError;
use super::gaps::gaps;
use super::layout::unit_of;
use crate::data::FrfSet;
use retune_linalg::DMatrix;

/// Singular values over frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct Cmif {
    /// Lines, Hz.
    pub frequencies_hz: Vec<f64>,
    /// Singular values in descending order (lines x min(references, responses)), in the unit of the FRF.
    pub values: DMatrix<f64>,
}

/// The complex mode indicator function.
///
/// ```text
/// H(ω) = U S Vᴴ  (responses x references):   CMIF_k(ω) = s_k(ω)
/// ```
/// A peak of the first value is a mode; a peak of the second at the same line is a second mode at that frequency, which
/// only a test with several references can show. Lines that a few functions lack are left out, and functions that lack many, responses
/// first.
///
/// # Errors
/// A set whose lengths disagree.
///
/// # Source
/// C. Y. Shih, Y. G. Tsuei, R. J. Allemang, D. L. Brown, Complex mode indication function and its applications to
/// spatial domain parameter estimation, Mech. Syst. Signal Process. 2, 1988.
pub fn cmif(frfs: &FrfSet) -> Result<Cmif, IdentifyError> {
    let all: Vec<usize> = (0..frfs.n_lines()).collect();
    let (_, lines) = gaps(frfs, &all)?;
    let unit = unit_of(frfs.h.iter().copied());
    let (n_ref, n_res) = (frfs.references.len(), frfs.responses.len());
    let is_full = |i: usize, o: usize| lines.iter().all(|&l| frfs.at(l, i, o).is_finite());
    let references: Vec<usize> = (0..n_ref).filter(|&i| (0..n_res).any(|o| is_full(i, o))).collect();
    let responses: Vec<usize> = (0..n_res).filter(|&o| references.iter().all(|&i| is_full(i, o))).collect();
    let rank = references.len().min(responses.len());
    if rank == 0 {
        return Err(IdentifyError::NoCompleteFunction { references: n_ref, responses: n_res });
    }
    let mut values = DMatrix::zeros(lines.len(), rank);
    for (row, &l) in lines.iter().enumerate() {
        let h =
            DMatrix::from_fn(responses.len(), references.len(), |o, i| frfs.at(l, references[i], responses[o]) / unit);
        // The Gram matrix of the smaller side: half of the digits are enough for an indicator, and it is real time.
        let gram = if references.len() <= responses.len() { h.ad_mul(&h) } else { &h * h.adjoint() };
        let mut s: Vec<f64> =
            if rank == 1 { vec![gram[(0, 0)].re] } else { gram.symmetric_eigenvalues().iter().copied().collect() };
        s.sort_by(|a, b| b.total_cmp(a));
        for (k, x) in s.into_iter().enumerate() {
            values[(row, k)] = x.max(0.0).sqrt() * unit;
        }
    }
    Ok(Cmif { frequencies_hz: lines.iter().map(|&l| frfs.frequencies_hz[l]).collect(), values })
}
