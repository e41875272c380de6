//! The clamped cruise-missile wing: 18 measured accelerances.

use super::super::{IdentifyOptions, identify};
use crate::data::{Channel, FrfQuantity, FrfSet};
use retune_linalg::Complex;
use std::path::PathBuf;

/// The folder of real data, by the environment or beside the project; tests skip with a message when it is absent.
pub(in crate::identify) fn data_folder(name: &str) -> Option<PathBuf> {
    let root = std::env::var_os("RETUNE_DATA")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"), PathBuf::from);
    let folder = root.join(name);
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("skipped: no folder {}; set RETUNE_DATA", folder.display());
    None
}

/// Rows of numbers of a CSV file, header left out.
pub(in crate::identify) fn read_csv(path: &std::path::Path) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(path).unwrap();
    text.lines().skip(1).map(|l| l.split(',').map(|x| x.trim().parse().unwrap_or(f64::NAN)).collect()).collect()
}

pub(in crate::identify) fn wing_frfs() -> Option<FrfSet> {
    let folder = data_folder("cruise_missile_wing")?.join("frf_csv");
    let columns: Vec<Vec<Vec<f64>>> = (0..18).map(|k| read_csv(&folder.join(format!("measurement_{k}.csv")))).collect();
    let frequencies_hz: Vec<f64> = columns[0].iter().map(|r| r[0]).collect();
    let n = frequencies_hz.len();
    let h = (0..n).flat_map(|l| columns.iter().map(move |c| Complex::new(c[l][1], c[l][2]))).collect();
    let point = |k: usize| Channel { name: format!("{}", k + 1), direction: Some([0.0, 0.0, 1.0]) };
    Some(FrfSet {
        quantity: FrfQuantity::Accelerance,
        frequencies_hz,
        references: vec![point(0)],
        responses: (0..18).map(point).collect(),
        h,
        coherence: None,
        n_averages: None,
    })
}

/// Nine modes in the band of the published analysis. The published frequencies are lines of the analyser, 0.3125 Hz apart (13.4
/// stands for 13.438, the line below the peak at 13.57), so an identified one lies within a line of them. Narrower bands
/// leave one or two weak resonances more; without settings there are nine, eight of them in stable columns.
#[test]
fn nine_modes_of_the_wing_are_found() {
    let Some(frfs) = wing_frfs() else { return };
    let published = [13.4, 51.9, 125.0, 167.8, 228.1, 328.5, 362.2, 496.3, 681.9];
    for band_hz in [None, Some((5.0, 700.0)), Some((5.0, 750.0))] {
        let found = identify(&frfs, &IdentifyOptions { band_hz, ..IdentifyOptions::default() }).unwrap();
        let f: Vec<f64> = found.modes.iter().map(|m| m.frequency_hz.value).collect();
        eprintln!("{band_hz:?}: {f:.2?}");
        let spacing = frfs.frequencies_hz[1] - frfs.frequencies_hz[0];
        for p in published {
            let line = (p / spacing).round() * spacing;
            assert!((line - p).abs() < 0.05 + 1e-6, "{p} Hz is not a line");
            assert!(f.iter().any(|x| (x - line).abs() < spacing), "{p} Hz not among {f:.2?} in {band_hz:?}");
        }
        let stable = found.modes.iter().filter(|m| m.n_orders > 0).count();
        // The mode at 496 Hz and the resonance at 657 Hz have no stable column; that at 741 Hz has one where the band ends at 750.
        let (columns, modes) = match band_hz {
            None => (8, 9),
            Some((_, 700.0)) => (8, 10),
            _ => (9, 11),
        };
        assert!(stable == columns && f.len() <= modes, "{stable} of {f:.2?}");
    }
}
