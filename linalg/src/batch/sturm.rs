//! The largest eigenvalues of symmetric tridiagonal matrices: Sturm counts, then a bracketed secant.
//!
//! ```text
//! p_0 = 1,   p_1 = x - d_0,   p_{i+1} = (x - d_i) p_i - e_{i-1}² p_{i-1}
//! number of sign changes in p_0 ... p_m = number of eigenvalues of T above x
//! ```
//!
//! The recurrence has no division; every eight rows the two running terms are brought back to a moderate size by an
//! exact power of two, whose count is kept. p_m also serves as the function whose root the secant looks for, so one
//! evaluation gives both the count (the proof) and the value (the speed).
//!
//! Sources: W. Barth, R. S. Martin, J. H. Wilkinson, Calculation of the eigenvalues of a symmetric tridiagonal matrix
//! by the method of bisection, Numer. Math. 9, 1967; N. Anderson, Å. Björck, A new high order method of regula falsi
//! type, BIT 13, 1973.

use super::lane::{Counter, Lane, Mask};

/// A symmetric tridiagonal matrix of size m, scaled so that no eigenvalue is above one.
#[derive(Clone, Copy)]
pub(super) struct Tridiagonal<'a, L> {
    /// Diagonal.
    pub(super) d: &'a [L],
    /// Off-diagonal, never exactly zero; the last entry does not belong to the matrix.
    pub(super) e: &'a [L],
    /// Squares of the off-diagonal.
    pub(super) e2: &'a [L],
}

/// What the recurrence says at one x.
#[derive(Clone, Copy)]
pub(super) struct Evaluation<L> {
    /// Number of eigenvalues above x.
    pub(super) count: Counter,
    /// p_m(x) up to the factor `RESCALE^exponent`.
    pub(super) value: L,
    /// Exponent of that factor.
    pub(super) exponent: L,
}

/// Two to the power 300: eight rows move the terms by less than this, and its square is finite.
const RESCALE: f64 = 2.037_035_976_334_486e90;

/// Evaluates the recurrence at all `points`, into `out`.
#[inline(always)]
pub(super) fn evaluate<L: Lane>(t: Tridiagonal<'_, L>, points: &[L], out: &mut [Evaluation<L>]) {
    // Tiles of nearly equal width; a width known at compile time keeps the loops over it free of branches.
    let mut at = 0;
    while at < points.len() {
        let left = points.len() - at;
        let width = left.div_ceil(left.div_ceil(WIDEST));
        let (x, evaluations) = (&points[at..at + width], &mut out[at..at + width]);
        match width {
            1 => abreast::<L, 1>(t, x, evaluations),
            2 => abreast::<L, 2>(t, x, evaluations),
            3 => abreast::<L, 3>(t, x, evaluations),
            4 => abreast::<L, 4>(t, x, evaluations),
            5 => abreast::<L, 5>(t, x, evaluations),
            _ => abreast::<L, WIDEST>(t, x, evaluations),
        }
        at += width;
    }
}

/// Most points that are evaluated side by side, to hide the latency of the recurrence.
const WIDEST: usize = 6;

/// Evaluates the recurrence at A points side by side.
#[inline(always)]
fn abreast<L: Lane, const A: usize>(t: Tridiagonal<'_, L>, points: &[L], out: &mut [Evaluation<L>]) {
    let m = t.d.len();
    let mut x = [L::splat(0.0); A];
    x.copy_from_slice(points);
    let mut count = [Counter::ZERO; A];
    // p_{i-1} and p_i change places every row: the new term overwrites the older one.
    let mut terms = [[L::splat(1.0); A]; 2];
    let mut exponent = [L::splat(0.0); A];
    for a in 0..A {
        terms[1][a] = x[a] - t.d[0];
        terms[1][a].count_sign_change(terms[0][a], &mut count[a]);
    }
    let mut i = 1;
    while i < m {
        let stop = (i + 8).min(m);
        while i < stop {
            let (d, e2) = (t.d[i], t.e2[i - 1]);
            for a in 0..A {
                let (p, before) = (terms[i % 2][a], terms[(i + 1) % 2][a]);
                let next = (x[a] - d).mul_add(p, -(e2 * before));
                next.count_sign_change(p, &mut count[a]);
                terms[(i + 1) % 2][a] = next;
            }
            i += 1;
        }
        let mut extreme = Mask::splat(false);
        for a in 0..A {
            let size = terms[0][a].abs().max(terms[1][a].abs());
            extreme = extreme.or(size.lt(L::splat(1.0 / RESCALE))).or(L::splat(RESCALE).lt(size));
        }
        if extreme.any() {
            rescale(&mut terms, &mut exponent);
        }
    }
    for (a, out) in out.iter_mut().enumerate() {
        *out = Evaluation { count: count[a], value: terms[m % 2][a], exponent: exponent[a] };
    }
}

/// Brings both terms of the lanes that need it back to a moderate size.
#[cold]
#[inline(never)]
fn rescale<L: Lane, const A: usize>([p, before]: &mut [[L; A]; 2], exponent: &mut [L; A]) {
    let (up, down, one, zero) = (L::splat(RESCALE), L::splat(1.0 / RESCALE), L::splat(1.0), L::splat(0.0));
    for a in 0..A {
        let size = p[a].abs().max(before[a].abs());
        let (small, large) = (size.lt(down), up.lt(size));
        let factor = L::select(small, up, L::select(large, down, one));
        p[a] = p[a] * factor;
        before[a] = before[a] * factor;
        exponent[a] = exponent[a] + L::select(small, -one, L::select(large, one, zero));
    }
}

/// The bracket of one eigenvalue: count(low) > index >= count(high).
#[derive(Clone, Copy)]
pub(super) struct Bracket<L> {
    pub(super) low: L,
    pub(super) high: L,
    pub(super) at_low: Evaluation<L>,
    pub(super) at_high: Evaluation<L>,
    /// The last estimate of the eigenvalue.
    last: L,
    /// +1 when the last point became `low`, -1 when it became `high`.
    side: L,
    /// Lanes that need no more work.
    done: Mask,
}

impl<L: Lane> Bracket<L> {
    /// The bracket of eigenvalue `index` (0 is the largest) among evaluated `points`, in descending order.
    ///
    /// The first point must be above all eigenvalues and the last one below eigenvalue `index`.
    #[inline(always)]
    pub(super) fn among(index: usize, points: &[L], evaluations: &[Evaluation<L>], wanted: Mask) -> Self {
        let end = points.len() - 1;
        let mut b = Self {
            low: points[end],
            high: points[0],
            at_low: evaluations[end],
            at_high: evaluations[0],
            last: points[0],
            side: L::splat(0.0),
            done: wanted.not(),
        };
        let mut found = Mask::splat(false);
        for (&x, &at) in points[1..].iter().zip(&evaluations[1..]) {
            // Descending points: the first one with a count above the index is `low`, the one before it `high`.
            let above = at.count.above(index);
            let first = above.and(found.not());
            b.low = L::select(first, x, b.low);
            b.at_low = choose(first, at, b.at_low);
            found = found.or(above);
            b.high = L::select(found, b.high, x);
            b.at_high = choose(found, b.at_high, at);
        }
        b
    }

    /// The next point: the secant's where the eigenvalue is alone in the bracket, the middle otherwise.
    #[inline(always)]
    fn propose(&mut self, round: usize) -> L {
        let middle = (self.low * self.high).sqrt();
        let alone = self.at_low.count.is_one_above(self.at_high.count);
        let other_scale =
            self.at_low.exponent.lt(self.at_high.exponent).or(self.at_high.exponent.lt(self.at_low.exponent));
        let slope = self.at_low.value - self.at_high.value;
        let step = (self.high - self.low) * self.at_low.value / slope;
        let secant = self.low + step;
        let inside = self.low.lt(secant).and(secant.lt(self.high));
        // Every sixth round halves whatever the secant says: the bracket shrinks geometrically in the worst case too.
        let use_secant = alone.and(inside).and(other_scale.not()).and(Mask::splat(round % 6 != 5));
        let estimate = L::select(use_secant, secant, middle);
        // A point just beyond the estimate, seen from the end close by, makes the bracket collapse onto it.
        let (from_low, from_high) = (estimate - self.low, self.high - estimate);
        let close = L::splat(CLOSE) * estimate;
        let push = L::splat(0.4 * NARROW) * estimate;
        let up = use_secant.and(from_low.lt(close)).and(from_low.lt(from_high));
        let down = use_secant.and(from_high.lt(close)).and(from_high.lt(from_low));
        let x = L::select(up, estimate + push, L::select(down, estimate - push, estimate));
        self.last = L::select(self.done, self.last, estimate);
        self.done = self.done.or((self.high - self.low).lt(L::splat(NARROW) * self.high));
        x
    }

    /// Takes the evaluation at the proposed point into account.
    #[inline(always)]
    fn update(&mut self, index: usize, x: L, at: Evaluation<L>) {
        let up = at.count.above(index).and(self.done.not());
        let down = at.count.above(index).not().and(self.done.not());
        let (zero, one) = (L::splat(0.0), L::splat(1.0));
        // Anderson-Björck: an end that stays twice has its value scaled down, so that the secant leaves the other end.
        let same = L::select(up, one, -one) * self.side;
        let twice = zero.lt(same);
        let keep_high = damped::<L>(at.value, self.at_low.value);
        let keep_low = damped::<L>(at.value, self.at_high.value);
        self.at_high.value = L::select(up.and(twice), self.at_high.value * keep_high, self.at_high.value);
        self.at_low.value = L::select(down.and(twice), self.at_low.value * keep_low, self.at_low.value);
        self.low = L::select(up, x, self.low);
        self.at_low = choose(up, at, self.at_low);
        self.high = L::select(down, x, self.high);
        self.at_high = choose(down, at, self.at_high);
        self.side = L::select(up, one, L::select(down, -one, self.side));
    }
}

/// The factor 1 - new/old, or one half where it is not positive.
#[inline(always)]
fn damped<L: Lane>(new: L, old: L) -> L {
    let factor = L::splat(1.0) - new / old;
    L::select(L::splat(0.0).lt(factor), factor, L::splat(0.5))
}

/// Relative width of a bracket that is narrow enough: the secant's error inside it is about the square.
const NARROW: f64 = 1e-7;
/// Relative distance from an end at which the secant is taken to converge.
const CLOSE: f64 = 1e-3;
/// Rounds after which a bracket is taken as it is; the residual test decides about it.
const ROUNDS: usize = 120;

#[inline(always)]
fn choose<L: Lane>(mask: Mask, yes: Evaluation<L>, no: Evaluation<L>) -> Evaluation<L> {
    Evaluation {
        count: Counter::select(mask, yes.count, no.count),
        value: L::select(mask, yes.value, no.value),
        exponent: L::select(mask, yes.exponent, no.exponent),
    }
}

/// Narrows the brackets until each holds one eigenvalue to about 1e-9 of itself; writes the eigenvalues.
///
/// * `points`, `out` - scratch of one entry per bracket
#[inline(always)]
pub(super) fn refine<L: Lane>(
    t: Tridiagonal<'_, L>,
    brackets: &mut [Bracket<L>],
    points: &mut [L],
    out: &mut [Evaluation<L>],
    eigenvalues: &mut [L],
) {
    for round in 0..ROUNDS {
        let mut open = Mask::splat(false);
        for (bracket, x) in brackets.iter_mut().zip(points.iter_mut()) {
            *x = bracket.propose(round);
            open = open.or(bracket.done.not());
        }
        if !open.any() {
            break;
        }
        evaluate(t, points, out);
        for (index, bracket) in brackets.iter_mut().enumerate() {
            bracket.update(index, points[index], out[index]);
        }
    }
    for (bracket, value) in brackets.iter().zip(eigenvalues) {
        *value = bracket.last;
    }
}
