//! What the data can tell of the 19 parameters: ranks of the exact sensitivities.

use super::*;
use retune::linalg::{DVector, thin_svd};
use retune::objective::Comparison;

/// Singular values below this share of the largest count as zero.
const THRESHOLD: f64 = 1e-4;

fn singular_values(a: &DMatrix<f64>) -> Vec<f64> {
    thin_svd(a).unwrap().values.iter().copied().collect()
}

fn rank(values: &[f64]) -> usize {
    values.iter().filter(|v| **v > THRESHOLD * values[0]).count()
}

fn stack(blocks: &[&DMatrix<f64>]) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(blocks.iter().map(|b| b.nrows()).sum(), blocks[0].ncols());
    let mut first = 0;
    for block in blocks {
        all.rows_mut(first, block.nrows()).copy_from(*block);
        first += block.nrows();
    }
    all
}

/// B15: relative sensitivities per full interval at the paper's optimum have rank 6 with frequencies, 9 with mass, centre
/// of gravity and pitch inertia, 15 with all shapes; the four missing directions are exact.
#[test]
fn ranks() {
    let model = model("bff_updated.yaml");
    let test = gvt();
    let theta = model.parameters().nominal();
    let width: Vec<f64> = model.parameters().iter().map(|p| p.bounds.map(|[l, u]| u - l).unwrap()).collect();
    let n = theta.len();
    let comparison = Comparison::new(&model, &test, BY_ORDER).unwrap();
    let prediction = comparison.predict(&theta).unwrap();
    let derivative = comparison.differentiate(&theta, &prediction, &(0..n).collect::<Vec<_>>()).unwrap();

    let mut frequencies = DMatrix::zeros(6, n);
    let mut shapes = DMatrix::zeros(6 * 34, n);
    for mode in 0..6 {
        let (df, d_phi) = derivative.modes[mode].as_ref().unwrap();
        let phi: DVector<f64> = prediction.at_sensors.column(mode).into_owned();
        let peak = phi.rows(0, 18).iamax();
        for j in 0..n {
            frequencies[(mode, j)] = df[j] * width[j] / prediction.frequencies_hz[mode];
            // of the shape with its largest entry held at one
            let slope = (d_phi.column(j) - &phi * (d_phi[(peak, j)] / phi[peak])) * (width[j] / phi[peak]);
            shapes.view_mut((34 * mode, j), (34, 1)).copy_from(&slope);
        }
    }
    // Mass, first moment and inertia about the origin are linear in θ, so any difference of them is exact.
    let linear = |theta: &[f64]| {
        let p = model.mass_properties(theta).unwrap().unwrap();
        [p.mass, p.mass * p.cg[0], p.moment_about(1, [0.0; 3])]
    };
    let base = linear(&theta);
    let cg = base[1] / base[0];
    let pitch = base[2] - base[0] * cg * cg;
    let mut mass = DMatrix::zeros(3, n);
    for j in 0..n {
        let mut shifted = theta.clone();
        shifted[j] += width[j];
        let d: Vec<f64> = linear(&shifted).iter().zip(base).map(|(a, b)| a - b).collect();
        let d_cg = (d[1] - cg * d[0]) / base[0];
        mass[(0, j)] = d[0] / base[0];
        mass[(1, j)] = d_cg / cg;
        // ∂(I - m c²) = ∂I - c² ∂m - 2 m c ∂c
        mass[(2, j)] = (d[2] - cg * cg * d[0] - 2.0 * base[0] * cg * d_cg) / pitch;
    }
    let six = singular_values(&frequencies);
    let nine = singular_values(&stack(&[&frequencies, &mass]));
    let all = singular_values(&stack(&[&frequencies, &mass, &shapes]));
    eprintln!("frequencies {six:.3?}\nwith mass {nine:.3?}\nwith shapes {all:.3?}");
    assert_eq!((rank(&six), rank(&nine), rank(&all)), (6, 9, 15));
    assert!(all[15..].iter().all(|v| *v < 1e-10 * all[0]), "the missing directions are exact: {all:?}");
    for (own, expected) in six.iter().zip([2.20, 1.69, 0.67, 0.19, 0.097, 0.056]) {
        assert_relative(*own, expected, 0.03, "singular value, against the printed digits of the reference");
    }
}
