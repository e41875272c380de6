use super::*;
use proptest::prelude::*;

fn names(n: usize) -> Vec<String> {
    (1..=n).map(|i| format!("p{i}")).collect()
}

/// Three masses on a rigid body seen through total mass and first moment (places 0, 1, 3), one parameter of its own and
/// one without effect: null space of the three is (2, -3, 1), so the combinations are p1 - 2 p3 and p2 + 3 p3, or any
/// two of that plane.
#[test]
fn parameters_that_act_through_fewer_numbers_are_grouped() {
    #[rustfmt::skip]
    let jacobian = DMatrix::from_row_slice(4, 5, &[
        1.0, 1.0, 1.0, 0.0, 0.0,
        0.0, 1.0, 3.0, 0.0, 0.0,
        0.5, 0.0, -1.0, 2.0, 0.0,
        0.0, 0.0, 0.0, 1.0, 0.0,
    ]);
    let found = identifiability(&jacobian, &names(5), None, 1e-4).unwrap();
    assert_eq!((found.rank, found.structural_rank), (3, 3));
    assert_eq!(found.identifiable, [3]);
    assert_eq!(found.groups.len(), 2);
    assert_eq!(found.groups[0].parameters, [0, 1, 2]);
    assert_eq!(found.groups[1].parameters, [4]);
    let null = nalgebra::dvector![2.0, -3.0, 1.0];
    assert_eq!(found.groups[0].combinations.nrows(), 2);
    assert!((&found.groups[0].combinations * null).abs().max() < 1e-13);
    assert_eq!(found.groups[1].combinations.nrows(), 0);
    let text = found.to_string();
    assert!(text.starts_with("the data determine 3 of 5 combinations of parameters"), "{text}");
    assert!(text.contains("these 3 parameters act only through 2 numbers: p1, p2, p3"), "{text}");
    assert!(text.ends_with("p5 has no effect"), "{text}");
}

/// Only Ix1 + 2 Ix4_9 is seen; the intervals are 0.2 and 0.01 wide, so the column of x ratio is 0.2 : 0.02.
#[test]
fn combinations_are_given_in_the_parameters_own_units() {
    let jacobian = DMatrix::from_row_slice(2, 2, &[0.2, 0.02, -0.4, -0.04]);
    let names = ["Ix1".to_owned(), "Ix4_9".to_owned()];
    let found = identifiability(&jacobian, &names, Some(&[0.2, 0.01]), 1e-4).unwrap();
    assert_eq!(found.combinations_in_words(&found.groups[0]), ["Ix1 + 2 Ix4_9"]);
    assert_eq!(
        found.to_string(),
        "the data determine 1 of 2 combinations of parameters\nthese 2 parameters act only through one number: Ix1, Ix4_9\n  Ix1 + 2 Ix4_9"
    );
}

/// The centre body of the BFF aircraft: masses and inertias on a rigid body act through its mass, first moment, pitch and
/// roll inertia alone. Places (x, z) from the published model (github.com/abhineet-gupta/BFF_FEM), fuselage bars as one
/// line from node 3 to node 2; a wing parameter stands beside them.
#[test]
fn eight_centre_body_parameters_act_through_four_numbers() {
    let names = ["mu_fuselage", "m1", "m2", "m3", "m4_9", "Iz1", "Ix1", "Ix4_9", "EI"].map(str::to_owned);
    let (z, x4) = ([0.5908, 0.8054, 0.2511, 0.5392], 0.3686);
    let body = |m: f64, z: f64, x: f64| [m, m * z, m * z * z, m * x * x];
    let line = [0.5543, 0.5543 * 0.52825, (0.8054f64.powi(3) - 0.2511f64.powi(3)) / 3.0, 0.0];
    let columns = [
        line,
        body(1.0, z[0], 0.0),
        body(1.0, z[1], 0.0),
        body(1.0, z[2], 0.0),
        body(2.0, z[3], x4),
        [0.0, 0.0, 0.0, 1.0],
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 2.0, 0.0],
    ];
    let widths = [1.1, 2.25, 0.6, 0.6, 0.2, 1.0, 0.2, 0.01, 70.0];
    let seen = DMatrix::from_fn(12, 5, |i, j| (1.3 * (i + 1) as f64 + 0.7 * ((i + 2) * (j + 1)) as f64).sin());
    let jacobian = DMatrix::from_fn(12, 9, |i, j| {
        let effect = columns.get(j).map_or(seen[(i, 4)], |c| (0..4).map(|k| seen[(i, k)] * c[k]).sum());
        effect * if j < 8 { widths[j] } else { 1.0 }
    });
    let found = identifiability(&jacobian, &names, Some(&widths), 1e-6).unwrap();
    assert_eq!((found.rank, found.identifiable.as_slice()), (5, [8].as_slice()));
    assert_eq!(found.groups.len(), 1);
    assert_eq!((found.groups[0].parameters.len(), found.groups[0].combinations.nrows()), (8, 4));
    let text = found.to_string();
    assert!(
        text.contains("these 8 parameters act only through 4 numbers: mu_fuselage, m1, m2, m3, m4_9, Iz1, Ix1"),
        "{text}"
    );
    // Each combination is one of the four numbers' span: it vanishes with them.
    let through = DMatrix::from_fn(4, 8, |k, j| columns[j][k]);
    let stacked =
        DMatrix::from_fn(8, 8, |i, j| if i < 4 { through[(i, j)] } else { found.groups[0].combinations[(i - 4, j)] });
    // Coefficients below a thousandth are dropped for reading; beyond that the rank stays four.
    let unit = DMatrix::from_fn(8, 8, |i, j| stacked[(i, j)] * widths[j]);
    assert_eq!(thin_svd(&unit).unwrap().rank(2e-3), 4, "{text}");
}

#[test]
fn nearly_parallel_columns_are_named() {
    let jacobian = DMatrix::from_row_slice(2, 4, &[1.0, 2.0, 0.0, 0.0, 0.01, 0.0, 1.0, 0.0]);
    let groups = collinear_groups(&jacobian, 0.95);
    assert_eq!(groups.len(), 1);
    assert_eq!(groups[0].parameters, [0, 1]);
    assert!((groups[0].cosine - 1.0 / 1.0001f64.sqrt()).abs() < 1e-15);
}

/// By hand: JᵀJ = [2 1; 1 2], inverse [2 -1; -1 2]/3.
#[test]
fn information_alone_and_among_others() {
    let jacobian = DMatrix::from_row_slice(3, 2, &[1.0, 1.0, 1.0, 0.0, 0.0, 1.0]);
    let found = information(&jacobian, None, 1e-8).unwrap();
    assert!((found[0].sd_alone - 0.5f64.sqrt()).abs() < 1e-15);
    assert!((found[0].sd.unwrap() - (2.0f64 / 3.0).sqrt()).abs() < 1e-15);
    assert!((found[0].share - 0.75).abs() < 1e-14);
    let correlation = correlations(&covariance(&jacobian, None, 1e-8).unwrap());
    assert!((correlation[(0, 1)] + 0.5).abs() < 1e-14 && correlation[(0, 0)] == 1.0);
}

#[test]
fn an_undetermined_parameter_has_no_sd_until_a_prior_gives_one() {
    let jacobian = DMatrix::from_row_slice(1, 3, &[1.0, 1.0, 0.0]);
    let free = information(&jacobian, None, 1e-8).unwrap();
    assert!(free.iter().all(|i| i.sd.is_none()) && free[2].sd_alone.is_infinite());
    // With priors of 1: (JᵀJ + I)⁻¹ = I - ccᵀ/3, c = (1, 1): variance 2/3.
    let held = information(&jacobian, Some(&[1.0, 1.0, 1.0]), 0.0).unwrap();
    assert!((held[0].sd.unwrap() - (2.0f64 / 3.0).sqrt()).abs() < 1e-15);
    assert!((held[2].sd.unwrap() - 1.0).abs() < 1e-15);
    assert!(information(&jacobian, Some(&[1.0]), 0.0).is_err());
    assert!(identifiability(&jacobian, &names(2), None, 1e-4).is_err());
}

proptest! {
    /// Any four independent rows over eight columns, next to six independent columns: rank 10 of 14, one group of 8 in 4.
    #[test]
    fn a_hidden_group_of_eight_in_four_is_found(values in prop::collection::vec(-1.0..1.0f64, 32 + 60 + 120)) {
        let through = DMatrix::from_row_slice(4, 8, &values[..32]);
        let seen = DMatrix::from_row_slice(20, 4, &values[32..112]);
        let own = DMatrix::from_row_slice(20, 5, &values[112..]);
        prop_assume!(thin_svd(&through).unwrap().values[3] > 0.3 && thin_svd(&seen).unwrap().values[3] > 0.3);
        let mut jacobian = DMatrix::zeros(20, 13);
        jacobian.columns_mut(0, 8).copy_from(&(seen * &through));
        jacobian.columns_mut(8, 5).copy_from(&own);
        prop_assume!(thin_svd(&jacobian).unwrap().values[8] > 0.05);
        let found = identifiability(&jacobian, &names(13), None, 1e-6).unwrap();
        prop_assert_eq!(found.rank, 9);
        prop_assert_eq!(found.groups.len(), 1);
        prop_assert_eq!(&found.groups[0].parameters, &(0..8).collect::<Vec<_>>());
        prop_assert_eq!(found.groups[0].combinations.nrows(), 4);
        prop_assert!((&found.groups[0].combinations * found.null_space.rows(0, 8)).abs().max() < 1e-10);
    }
}
