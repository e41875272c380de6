use super::*;
use proptest::prelude::*;

fn names(words: &[&str]) -> Vec<Option<String>> {
    words.iter().map(|w| Some((*w).to_owned())).collect()
}

fn frequencies(f: &[f64]) -> ModeList<'_> {
    ModeList { frequencies_hz: f, ..ModeList::default() }
}

fn indices(paired: &PairedModes) -> Vec<(usize, usize)> {
    paired.pairs.iter().map(|p| (p.analytical, p.experimental)).collect()
}

/// Greedy would take the 0.9 and leave 0.1 for the other mode; the optimum is 0.85 + 0.8.
#[test]
fn the_assignment_is_optimal_and_not_greedy() {
    let mac = DMatrix::from_row_slice(2, 2, &[0.9, 0.85, 0.8, 0.1]);
    let f = [10.0, 10.5];
    let paired = pair_modes(&mac, &frequencies(&f), &frequencies(&f), &PairingOptions::default());
    assert_eq!(indices(&paired), [(1, 0), (0, 1)]);
    assert_eq!(paired.swapped, [(0, 1)]);
    assert!(paired.pairs[0].flags.contains(&PairFlag::Ambiguous));
    assert!((paired.pairs[0].frequency_error - 0.05).abs() < 1e-15);
}

#[test]
fn gates_leave_modes_unpaired_and_say_which_came_closest() {
    let mac = DMatrix::from_row_slice(3, 2, &[0.95, 0.0, 0.02, 0.2, 0.0, 0.9]);
    let paired =
        pair_modes(&mac, &frequencies(&[5.0, 8.0, 30.0]), &frequencies(&[5.1, 8.2]), &PairingOptions::default());
    assert_eq!(indices(&paired), [(0, 0)]);
    assert_eq!(paired.unpaired_experimental, [Unpaired { index: 1, best: Some((2, 0.9)) }]);
    assert_eq!(paired.unpaired_analytical.iter().map(|u| u.index).collect::<Vec<_>>(), [1, 2]);
}

#[test]
fn an_infinite_window_and_an_unknown_frequency_open_the_gate() {
    let mac = DMatrix::from_element(1, 1, 0.9);
    let wide = PairingOptions { frequency_window: f64::INFINITY, ..PairingOptions::default() };
    assert_eq!(pair_modes(&mac, &frequencies(&[0.0]), &frequencies(&[7.0]), &wide).pairs.len(), 1);
    let options = PairingOptions::default();
    assert_eq!(pair_modes(&mac, &frequencies(&[0.0]), &frequencies(&[7.0]), &options).pairs.len(), 0);
    assert_eq!(pair_modes(&mac, &frequencies(&[]), &frequencies(&[7.0]), &options).pairs.len(), 1);
}

#[test]
fn families_are_kept_apart_or_flagged() {
    let mac = DMatrix::from_row_slice(2, 2, &[0.4, 0.9, 0.9, 0.4]);
    let (f, classes) = ([10.0, 11.0], names(&["symmetric", "antisymmetric"]));
    let modes = ModeList { frequencies_hz: &f, labels: &[], families: &classes };
    let gated = pair_modes(&mac, &modes, &modes, &PairingOptions::default());
    assert_eq!(indices(&gated), [(0, 0), (1, 1)]);
    let free = PairingOptions { same_family_only: false, ..PairingOptions::default() };
    let flagged = pair_modes(&mac, &modes, &modes, &free);
    assert_eq!(indices(&flagged), [(1, 0), (0, 1)]);
    assert_eq!(flagged.pairs[0].flags, [PairFlag::DifferentFamily]);
}

#[test]
fn pairing_by_order_keeps_to_the_families() {
    // Test S A S A; model in ascending order S A A S: plain order pairs the third and fourth wrongly.
    let (f_a, f_x) = ([5.0, 8.0, 18.0, 19.0], [5.1, 8.1, 18.2, 19.3]);
    let (c_a, c_x) = (names(&["S", "A", "A", "S"]), names(&["S", "A", "S", "A"]));
    let a = ModeList { frequencies_hz: &f_a, labels: &c_a, families: &c_a };
    let x = ModeList { frequencies_hz: &f_x, labels: &c_x, families: &c_x };
    let mac = DMatrix::zeros(4, 4);
    let by_order = PairingOptions { by: PairBy::Order, ..PairingOptions::default() };
    let paired = pair_modes(&mac, &a, &x, &by_order);
    assert_eq!(indices(&paired), [(0, 0), (1, 1), (3, 2), (2, 3)]);
    assert_eq!(paired.swapped, [(2, 3)]);
    assert_eq!(paired.pairs[0].flags, [PairFlag::LowMac, PairFlag::Ambiguous]);
    let plain = PairingOptions { same_family_only: false, ..by_order };
    let paired = pair_modes(&mac, &a, &x, &plain);
    assert_eq!(indices(&paired), [(0, 0), (1, 1), (2, 2), (3, 3)]);
    assert!(paired.pairs[2].flags.contains(&PairFlag::DifferentFamily));
}

#[test]
fn modes_of_unknown_family_are_paired_in_order_with_what_is_left() {
    let (f_a, f_x) = ([5.0, 8.0, 18.0, 19.0], [5.1, 8.1, 18.2]);
    let c_a = names(&["S", "A", "A", "S"]);
    let by_order = PairingOptions { by: PairBy::Order, ..PairingOptions::default() };
    let mac = DMatrix::zeros(4, 3);
    let pairs = |families: &[Option<String>]| {
        let a = ModeList { frequencies_hz: &f_a, labels: &[], families: &c_a };
        let x = ModeList { frequencies_hz: &f_x, labels: &[], families };
        indices(&pair_modes(&mac, &a, &x, &by_order))
    };
    assert_eq!(pairs(&[None, None, None]), [(0, 0), (1, 1), (2, 2)]);
    // The second is known to be the first antisymmetric one, whatever comes before it.
    assert_eq!(pairs(&[None, Some("A".to_string()), None]), [(0, 0), (1, 1), (2, 2)]);
    assert_eq!(pairs(&[None, Some("S".to_string()), None]), [(1, 0), (0, 1), (2, 2)]);
}

#[test]
fn pairing_by_label_takes_equal_names_once() {
    let (l_a, l_x) = (names(&["S1B", "S1T", "S1T"]), names(&["S1T", "A1B", "S1T", "S1T"]));
    let a = ModeList { labels: &l_a, ..ModeList::default() };
    let x = ModeList { labels: &l_x, ..ModeList::default() };
    let by_label = PairingOptions { by: PairBy::Label, ..PairingOptions::default() };
    let paired = pair_modes(&DMatrix::from_element(3, 4, 0.9), &a, &x, &by_label);
    assert_eq!(indices(&paired), [(1, 0), (2, 2)]);
    assert_eq!(paired.unpaired_experimental.iter().map(|u| u.index).collect::<Vec<_>>(), [1, 3]);
    assert!(paired.pairs[0].frequency_error.is_nan());
}

#[test]
fn tracked_modes_follow_a_crossing_and_a_lost_one_is_said_so() {
    let previous = DMatrix::from_row_slice(3, 3, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    let current = DMatrix::from_row_slice(3, 2, &[0.1, -1.0, 1.0, 0.1, 0.0, 0.1]);
    let tracked = track(&previous, &current, None, 0.5);
    assert_eq!(tracked.index, [Some(1), Some(0), None]);
    assert!(tracked.mac[0] > 0.95 && tracked.mac[2] == 0.0);
    assert_eq!(track(&previous, &current, Some(&DMatrix::identity(3, 3)), 0.5).index, tracked.index);
}

/// A permutation of 0..n from numbers.
fn permutation(keys: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..keys.len()).collect();
    order.sort_by(|&i, &j| keys[i].total_cmp(&keys[j]));
    order
}

proptest! {
    #[test]
    fn pairing_does_not_depend_on_the_order_of_modes(
        values in prop::collection::vec(0.0..1.0f64, 20), f in prop::collection::vec(5.0..12.0f64, 9),
        rows in prop::collection::vec(0.0..1.0f64, 4), columns in prop::collection::vec(0.0..1.0f64, 5),
        by in prop::sample::select(vec![PairBy::Mac, PairBy::Order])
    ) {
        let mac = DMatrix::from_row_slice(4, 5, &values);
        let options = PairingOptions { by, ..PairingOptions::default() };
        let reference = pair_modes(&mac, &frequencies(&f[..4]), &frequencies(&f[4..]), &options);
        let (rows, columns) = (permutation(&rows), permutation(&columns));
        let shuffled = DMatrix::from_fn(4, 5, |i, j| mac[(rows[i], columns[j])]);
        let f_a: Vec<f64> = rows.iter().map(|&i| f[i]).collect();
        let f_x: Vec<f64> = columns.iter().map(|&j| f[4 + j]).collect();
        let paired = pair_modes(&shuffled, &frequencies(&f_a), &frequencies(&f_x), &options);
        let renamed: Vec<(usize, usize)> =
            indices(&paired).into_iter().map(|(i, j)| (rows[i], columns[j])).collect();
        prop_assert_eq!(renamed, indices(&reference));
        prop_assert_eq!(paired.swapped, reference.swapped);
        for pair in &reference.pairs {
            prop_assert!(by == PairBy::Order || (pair.mac >= 0.3 && !pair.flags.contains(&PairFlag::FarFrequency)));
        }
        prop_assert_eq!(reference.pairs.len() + reference.unpaired_analytical.len(), 4);
        prop_assert_eq!(reference.pairs.len() + reference.unpaired_experimental.len(), 5);
    }
}

/// Two modes that few sensors see alike: the one at the right frequency is taken, and what is far is still better than none.
#[test]
fn near_frequencies_are_preferred_beyond_an_octave() {
    let mac = DMatrix::from_row_slice(2, 1, &[0.35, 0.94]);
    let (model, test) = ([10.4, 82.0], [10.05]);
    let pair = |by: PairBy, rows: &[usize]| {
        let options = PairingOptions { by, min_mac: 0.0, frequency_window: f64::INFINITY, ..PairingOptions::default() };
        let frequencies: Vec<f64> = rows.iter().map(|&i| model[i]).collect();
        let a = ModeList { frequencies_hz: &frequencies, ..ModeList::default() };
        let x = ModeList { frequencies_hz: &test, ..ModeList::default() };
        pair_modes(&mac.select_rows(rows), &a, &x, &options)
            .pairs
            .iter()
            .map(|p| rows[p.analytical])
            .collect::<Vec<_>>()
    };
    assert_eq!(pair(PairBy::Mac, &[0, 1]), [1]);
    assert_eq!(pair(PairBy::NearMac, &[0, 1]), [0]);
    assert_eq!(pair(PairBy::NearMac, &[1]), [1]);
}

/// Two modes that the sensors see alike, as of a body on a spring that is tuned to its host: noise decides which MAC is a little larger,
/// the frequencies which mode is meant. Shapes that differ are still followed through a crossing.
#[test]
fn frequencies_decide_where_shapes_do_not() {
    let frequencies_hz = [6.6, 6.7];
    let pair = |by: PairBy, mac: [f64; 4]| {
        let options = PairingOptions { by, ..PairingOptions::default() };
        let mac = DMatrix::from_row_slice(2, 2, &mac);
        indices(&pair_modes(&mac, &frequencies(&frequencies_hz), &frequencies(&frequencies_hz), &options))
    };
    let (alike, different) = ([0.998, 0.999, 0.999, 0.998], [0.98, 0.999, 0.999, 0.98]);
    assert_eq!(pair(PairBy::Mac, alike), [(1, 0), (0, 1)]);
    assert_eq!(pair(PairBy::NearMac, alike), [(0, 0), (1, 1)]);
    assert_eq!(pair(PairBy::NearMac, different), [(1, 0), (0, 1)]);
}
