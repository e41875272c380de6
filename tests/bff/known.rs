//! Numbers of the reference and of the paper that are checked without the reference file.
//!
//! Reference: two independent programs that agree to 1e-12; rounded here to the digits shown. Paper: A. Gupta, C. P.
//! Moreno, H. Pfifer, G. J. Balas, Updating a Finite Element Based Structural Model of a Small Flexible Aircraft, 2015.

/// Elastic frequencies 1 to 9 of the initial model, Table 4 literally, and the updated model, Hz (reference).
pub(crate) const FREQUENCIES_HZ: [(&str, [f64; 9]); 3] = [
    (
        "initial",
        [
            3.965312797464295,
            5.99978484034888,
            18.13400289337858,
            20.45505843957336,
            27.828374733217437,
            28.160624187596248,
            48.11303293290726,
            49.75308750059069,
            79.07327642335184,
        ],
    ),
    (
        "table4_literal",
        [
            3.8557729414057405,
            5.79290840488434,
            17.302381887100818,
            19.6564499471093,
            27.93430562417269,
            28.26230132930267,
            45.75399861097851,
            47.45378246147629,
            79.49948367243901,
        ],
    ),
    (
        "updated",
        [
            5.528508100689895,
            8.581946038469583,
            19.217265061021866,
            19.88458231088817,
            23.03715938907211,
            27.540629579722857,
            49.29693334028161,
            50.71825624740646,
            54.23847715098011,
        ],
    ),
];

/// Mass, centre of gravity aft of the nose, roll and pitch inertia about it, pitch inertia about node 1 (reference, SI).
pub(crate) const MASS_PROPERTIES: [(&str, [f64; 5]); 3] = [
    ("initial", [5.474783178644598, 0.6796259746677557, 3.253286778122915, 0.33437103637802285, 0.3775673700676994]),
    (
        "table4_literal",
        [5.817937178644598, 0.6853743132631389, 3.6074523897129844, 0.34375435304977264, 0.39579173279913055],
    ),
    ("updated", [5.384212718675804, 0.6246757538822143, 2.858214907951915, 0.335220816889131, 0.34139956011665973]),
];

/// Names of the first six elastic modes (reference).
pub(crate) const LABELS: [(&str, [&str; 6]); 3] = [
    ("initial", ["S1B", "A1B", "S2B", "A2B", "A1T", "S1T"]),
    ("table4_literal", ["S1B", "A1B", "S2B", "A2B", "A1T", "S1T"]),
    ("updated", ["S1B", "A1B", "S1T", "A1T", "S2B", "A2B"]),
];

/// Shares of torsion energy of the updated model's first six elastic modes (reference).
pub(crate) const TORSION_UPDATED: [f64; 6] = [
    0.0014582648449125537,
    0.00439949046152148,
    0.6727977591745676,
    0.9840512717136954,
    0.3219810970776935,
    0.012503072514570134,
];

/// Equation (4)/12 of the three cases on the virtual test, pairing by order (reference).
pub(crate) const COSTS: [(&str, f64); 3] =
    [("initial", 0.3644489063612734), ("table4_literal", 0.36638996097693227), ("updated", 0.05174559094796821)];

/// The suspension modes of the virtual truth, Hz (reference).
pub(crate) const SUSPENSION_HZ: [f64; 3] = [0.3875666471796507, 0.592597318875061, 0.8456329873786854];

/// Table 2 of the paper: measured frequencies, Hz, and damping ratios.
pub(crate) const TABLE_2_HZ: [f64; 6] = [5.67, 8.37, 18.34, 19.82, 23.17, 28.60];
pub(crate) const TABLE_2_ZETA: [f64; 6] = [0.0155, 0.0106, 0.0206, 0.0233, 0.0285, 0.0255];

/// Table 3 of the paper: frequencies of the initial model, Hz, and their MAC with the test.
pub(crate) const TABLE_3_HZ: [f64; 6] = [3.96, 6.00, 18.15, 20.47, 27.83, 28.16];
pub(crate) const TABLE_3_MAC: [f64; 6] = [0.74, 0.87, 0.52, 0.02, 0.06, 0.01];

/// Table 6 of the paper: frequencies of the updated model, Hz, and their MAC with the test.
pub(crate) const TABLE_6_HZ: [f64; 6] = [5.53, 8.58, 19.21, 19.88, 23.03, 27.54];
pub(crate) const TABLE_6_MAC: [f64; 6] = [0.83, 0.92, 0.84, 0.93, 0.93, 0.92];

/// The entry of a table of cases.
pub(crate) fn of<T: Copy>(table: &[(&str, T)], case: &str) -> T {
    table.iter().find(|(name, _)| *name == case).unwrap_or_else(|| panic!("no case {case}")).1
}
