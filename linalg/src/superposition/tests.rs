//! Superposition beside dense solutions of Z, and its derivatives beside differences.

use super::{EntrySlopes, Superposition};
use crate::{Complex, DMatrix, ShiftedPencil};
use proptest::prelude::*;
use std::f64::consts::TAU;

/// K, M and C.
type Matrices = [DMatrix<f64>; 3];

/// Two chains of masses side by side, equal where `twin`, the last masses of each zero, free or held.
#[derive(Debug)]
struct Chains {
    stiffness: Vec<f64>,
    twin: bool,
    is_free: bool,
    rayleigh: [f64; 2],
    dashpots: Vec<(usize, f64)>,
}

impl Chains {
    fn matrices(&self) -> Matrices {
        let half = self.stiffness.len();
        let n = 2 * half;
        let (mut k, mut m) = (DMatrix::zeros(n, n), DMatrix::identity(n, n));
        for chain in 0..2 {
            for i in 0..half {
                let s = self.stiffness[i] * if chain == 1 && !self.twin { 1.3 } else { 1.0 };
                let at = chain * half + i;
                if i > 0 {
                    k[(at, at)] += s;
                    k[(at - 1, at - 1)] += s;
                    k[(at, at - 1)] -= s;
                    k[(at - 1, at)] -= s;
                } else if !self.is_free {
                    k[(at, at)] += s;
                }
            }
            m[(chain * half + half - 1, chain * half + half - 1)] = 0.0;
            m[(chain * half + half - 2, chain * half + half - 2)] = 0.0;
        }
        let mut c = &m * self.rayleigh[0] + &k * self.rayleigh[1];
        for &(at, value) in &self.dashpots {
            let (i, j) = (at % n, (at + half) % n);
            c[(i, i)] += value;
            c[(j, j)] += value;
            c[(i, j)] -= value;
            c[(j, i)] -= value;
        }
        [k, m, c]
    }
}

fn rows(n: usize) -> [DMatrix<f64>; 2] {
    let of = |count: usize, seed: usize| {
        DMatrix::from_fn(count, n, |i, j| if (i * 7 + j * 3 + seed).is_multiple_of(4) { 1.0 + i as f64 } else { 0.0 })
    };
    [of(3, 0), of(2, 1)]
}

const LINES: [f64; 6] = [0.0, 0.03, 0.11, 0.17, 0.23, 0.31];

fn dense([k, m, c]: &Matrices, loss_factor: f64, hz: f64) -> DMatrix<Complex<f64>> {
    let omega = TAU * hz;
    let z = DMatrix::from_fn(k.nrows(), k.nrows(), |i, j| {
        Complex::new(k[(i, j)] - omega * omega * m[(i, j)], loss_factor * k[(i, j)] + omega * c[(i, j)])
    });
    z.lu().try_inverse().expect("regular")
}

fn superposed<T>(
    [k, m, c]: &Matrices,
    loss_factor: f64,
    lines: &[f64],
    tell: impl FnOnce(&Superposition<'_>) -> T,
) -> T {
    let basis = ShiftedPencil::new(k, m, 0.4).unwrap();
    let [s, b] = rows(k.nrows());
    tell(&Superposition::new(&basis, (k, m, Some(c)), [&s, &b], lines, loss_factor).expect("few dashpots"))
}

fn chains() -> impl Strategy<Value = (Chains, f64)> {
    let stiffness = prop::collection::vec(0.5..2.0, 4..9);
    let dashpots = prop::collection::vec((0_usize..20, 0.01..1.0), 0..3);
    let rayleigh = (any::<bool>(), 0.01..0.2, 0.01..0.2).prop_map(|(on, a, b)| if on { [a, b] } else { [0.0, 0.0] });
    (stiffness, any::<bool>(), any::<bool>(), rayleigh, dashpots, 0.001..0.1).prop_map(
        |(stiffness, twin, is_free, rayleigh, dashpots, loss_factor)| {
            (Chains { stiffness, twin, is_free, rayleigh, dashpots }, loss_factor)
        },
    )
}

proptest! {
    /// Massless dofs, double modes, rigid bodies, damping in proportion and dashpots across.
    #[test]
    fn responses_are_those_of_the_dense_inverse((chains, loss_factor) in chains()) {
        let lines = &LINES[usize::from(chains.is_free)..];
        let matrices = chains.matrices();
        let [s, b] = rows(matrices[0].nrows());
        let found = superposed(&matrices, loss_factor, lines, |all| all.responses().to_vec());
        for (l, &hz) in lines.iter().enumerate() {
            let inverse = dense(&matrices, loss_factor, hz);
            let h = s.map(|v| Complex::new(v, 0.0)) * &inverse * b.transpose().map(|v| Complex::new(v, 0.0));
            for j in 0..b.nrows() {
                for i in 0..s.nrows() {
                    let own = found[(l * b.nrows() + j) * s.nrows() + i];
                    prop_assert!((own - h[(i, j)]).norm() <= 1e-9 * h.camax(), "{own} {}", h[(i, j)]);
                }
            }
        }
    }

    /// Of a spring, a mass, a dashpot and the loss factor, in the matrices that have them and in one step.
    #[test]
    fn derivatives_are_those_of_the_dense_inverse(
        (chains, loss_factor) in chains(),
        at in 0_usize..20,
        slopes in prop::array::uniform3(prop_oneof![Just(0.0), 0.1..1.0]),
        of_loss_factor in prop_oneof![Just(0.0), 0.1..1.0],
    ) {
        let lines = &LINES[usize::from(chains.is_free)..];
        let matrices = chains.matrices();
        let n = matrices[0].nrows();
        let (p, q) = (at % n, (at + 3) % n);
        // Rows p and q: ∂K = k (e_p - e_q)(e_p - e_q)ᵀ, and ∂C and ∂M alike.
        let [k, c, m] = slopes;
        let list = vec![
            (0, p, [k, c, m]),
            (0, q, [-k, -c, 0.5 * m]),
            (1, p, [-k, -c, 0.5 * m]),
            (1, q, [k, c, m]),
        ];
        let of = EntrySlopes { rows: vec![p, q], list, loss_factor: of_loss_factor };
        let found = superposed(&matrices, loss_factor, lines, |all| all.derivative(&of));
        let [s, b] = rows(n).map(|rows| rows.map(|v| Complex::new(v, 0.0)));
        for (l, &hz) in lines.iter().enumerate() {
            let omega = TAU * hz;
            let inverse = dense(&matrices, loss_factor, hz);
            let mut slope = matrices[0].map(|v| Complex::new(0.0, of_loss_factor * v));
            for &(row, j, [k, c, m]) in &of.list {
                slope[(of.rows[row], j)] +=
                    Complex::new(k - omega * omega * m, loss_factor * k + omega * c);
            }
            let exact = -(&s * &inverse * slope * &inverse * b.transpose());
            let size = exact.camax().max((&s * &inverse * b.transpose()).camax());
            for j in 0..b.nrows() {
                for i in 0..s.nrows() {
                    let own = found[(l * b.nrows() + j) * s.nrows() + i];
                    prop_assert!((own - exact[(i, j)]).norm() <= 1e-8 * size, "{own} {}", exact[(i, j)]);
                }
            }
        }
    }
}

#[test]
fn damping_of_the_whole_structure_that_is_not_in_proportion_is_refused() {
    let n = 60;
    let k = DMatrix::from_fn(n, n, |i, j| {
        if i == j {
            2.0
        } else if i.abs_diff(j) == 1 {
            -1.0
        } else {
            0.0
        }
    });
    let m = DMatrix::identity(n, n);
    let c = DMatrix::from_diagonal(&crate::DVector::from_fn(n, |i, _| 0.1 + (i % 7) as f64));
    let basis = ShiftedPencil::new(&k, &m, 0.4).unwrap();
    let [s, b] = rows(n);
    assert!(Superposition::new(&basis, (&k, &m, Some(&c)), [&s, &b], &LINES, 0.01).is_none());
}
