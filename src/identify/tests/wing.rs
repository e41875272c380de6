//! The clamped cruise-missile wing: 18 measured accelerances.

use super::super::{IdentifyOptions, identify};
use crate::data::{Channel, FrfQuantity, FrfSet};
use crate::linalg::Complex;
use std::path::PathBuf;

/// The folder of real data, by the environment or beside the project; tests skip with a message when it is absent.
pub(in crate::identify) fn data_folder(name: &str) -> Option<PathBuf> {
    let root = std::env::var_os("RETUNE_DATA")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data"), PathBuf::from);
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
    let columns: Vec<Vec<Vec<f64>>> =
        (0..18).map(|k| read_csv(&folder.join(format!("measurement_{k}.csv")))).collect();
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

#[test]
fn nine_modes_of_the_wing_are_found() {
    let Some(frfs) = wing_frfs() else { return };
    for band in [None, Some((5.0, 750.0)), Some((5.0, 900.0))] {
    let t = std::time::Instant::now();
    let found = identify(&frfs, &IdentifyOptions { band_hz: band, max_order: std::env::var("MO").map_or(40, |x| x.parse().unwrap()), ..IdentifyOptions::default() }).unwrap();
    eprintln!("{:?} {:?}", band, t.elapsed());
    for m in &found.modes { eprintln!("  f {:.3} ±{:.4} z {:.5} ±{:.5} n {} mpc {:.3} infl {:.2}", m.frequency_hz.value, m.frequency_hz.sd, m.damping_ratio.value, m.damping_ratio.sd, m.n_orders, m.complexity.mpc, m.sd_inflation); }
    for seg in &found.segments {
    eprintln!("  seg {:?} terms {:?} disc {:?}", seg.core_hz, seg.residual_terms, seg.discarded);
    }
    }
}
