//! The stages in order, for one batch of candidates.

use super::assemble;
use super::cholesky;
use super::inverse_iteration::{self, Factors};
use super::lane::{ABREAST, Counter, LANES, Lane, Mask};
use super::plan::Block;
use super::sturm::{self, Bracket, Evaluation, Tridiagonal};
use super::tridiagonal::{self, Reflectors};
use super::values::{self, Squared};

/// Modes that may be computed beyond the wanted ones, per block: the count stops at a gap, not in a cluster.
const MARGIN: usize = 2;
/// Ratio of two neighbours in θ below which there is a gap between them.
const GAP: f64 = 1.0 - 1.0 / 1024.0;
/// Octaves of θ, from its largest value down, in which the counts are taken at fixed points.
const OCTAVES: usize = 15;
/// Point below which an eigenvalue is rounding noise of the largest one: 2⁻⁴⁰.
const NOISE: f64 = 9.094947017729282e-13;
/// The fixed points: one above all, the octaves, the noise level, and one below zero that proves M ≥ 0.
const GRID: usize = OCTAVES + 3;

/// What the kernel needs to know of a model.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    pub(super) blocks: Vec<Block>,
    pub(super) n_modes: usize,
    pub(super) n_parameters: usize,
    pub(super) n_rows: usize,
    /// Reference shapes row by row (n_rows x references), if products with them are wanted.
    pub(super) references: Option<Vec<f64>>,
    /// Whether the shapes themselves are wanted.
    pub(super) with_shapes: bool,
    /// a, rad²/s²; zero where the inverse of K alone is accurate enough.
    pub(super) shift: f64,
    /// Factor that the masses carry inside the kernel.
    pub(super) mass_scale: f64,
    /// Fixed start values of the iterations, in ±[0.5, 1].
    pub(super) start: Vec<f64>,
}

impl Plan {
    /// Columns of the shape matrices of every block.
    pub(super) fn width(&self) -> usize {
        self.n_modes + MARGIN
    }

    /// Numbers that come out for every shape beside itself: its products with the references, and its square.
    pub(super) fn n_products(&self) -> usize {
        self.references.as_ref().map_or(0, |r| r.len() / self.n_rows.max(1) + 1)
    }
}

/// Why a lane has no result of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Lapse {
    /// K without its rigid motions, or K + a M, is not positive definite, or not finite.
    Stiffness,
    /// M is not positive semidefinite.
    Mass,
    /// Too few modes above the noise, or too many in one cluster.
    Count,
    /// An eigenpair does not pass the residual test.
    Residual,
}

/// The memory of one block.
pub(super) struct BlockBuffers<L> {
    l: Vec<L>,
    mass: Vec<L>,
    w: Vec<L>,
    gram: Vec<L>,
    c: Vec<L>,
    beta: Vec<L>,
    d: Vec<L>,
    e: Vec<L>,
    e2: Vec<L>,
    vectors: [Vec<L>; 4],
    z: Vec<L>,
    old: Vec<L>,
    factors: [Vec<L>; 4],
    grid: Vec<Evaluation<L>>,
    theta: Vec<L>,
    /// Places of these modes among those of all blocks.
    rank: Vec<Counter>,
    count: Counter,
    pub(super) observed: Vec<L>,
    pub(super) products: Vec<L>,
}

/// The memory of one batch; nothing is allocated after its creation.
pub(super) struct Buffers<L> {
    /// θ of the candidates, one per lane.
    pub(super) parameters: Vec<L>,
    pub(super) blocks: Vec<BlockBuffers<L>>,
    points: Vec<L>,
    proposals: Vec<L>,
    evaluations: Vec<Evaluation<L>>,
    brackets: Vec<Bracket<L>>,
    /// Largest row sum of the tridiagonal matrices.
    bound: L,
    /// The point above which the counted modes lie.
    cut: L,
    /// Per lane: the wanted modes as (λ, block, column), ascending; only the first n_modes count.
    pub(super) chosen: Vec<Vec<(f64, usize, usize)>>,
    /// Per lane: why it has no result.
    pub(super) lapses: [Option<Lapse>; LANES],
}

impl<L: Lane> Buffers<L> {
    pub(super) fn new(plan: &Plan) -> Self {
        let zero = L::splat(0.0);
        let nothing = Evaluation { count: Counter::ZERO, value: zero, exponent: zero };
        let width = plan.width();
        let most = plan.blocks.iter().map(|b| b.m).max().unwrap_or(0);
        let blocks = plan
            .blocks
            .iter()
            .map(|b| {
                let vector = |length: usize| vec![zero; length];
                BlockBuffers {
                    l: vector(b.envelope.len()),
                    mass: vector(b.envelope.len()),
                    w: vector(b.m * b.r),
                    gram: vector(b.r * (b.r + 1) / 2),
                    c: vector(b.m * b.m),
                    beta: vector(b.m),
                    d: vector(b.m),
                    e: vector(b.m),
                    e2: vector(b.m),
                    vectors: std::array::from_fn(|_| vector(most)),
                    z: vector((b.m + b.r) * width),
                    old: vector(b.m * width),
                    factors: std::array::from_fn(|_| vector(b.m * ABREAST)),
                    grid: vec![nothing; GRID],
                    theta: vector(width),
                    rank: vec![Counter::ZERO; width],
                    count: Counter::ZERO,
                    observed: vector(if plan.with_shapes { plan.n_rows * width } else { 0 }),
                    products: vector(plan.n_products() * width),
                }
            })
            .collect::<Vec<_>>();
        Self {
            parameters: vec![zero; plan.n_parameters],
            points: vec![zero; GRID.max(width)],
            proposals: vec![zero; width],
            evaluations: vec![nothing; GRID.max(width)],
            brackets: Vec::with_capacity(width),
            bound: zero,
            cut: zero,
            chosen: (0..LANES).map(|_| Vec::with_capacity(width * blocks.len())).collect(),
            lapses: [None; LANES],
            blocks,
        }
    }

    /// Notes the lapse of the lanes outside `good` that have none yet; gives the lanes without any.
    #[inline(always)]
    fn note(&mut self, good: Mask, lapse: Lapse) -> Mask {
        for (l, slot) in self.lapses.iter_mut().enumerate() {
            if good.0[l] == 0 && slot.is_none() {
                *slot = Some(lapse);
            }
        }
        Mask(std::array::from_fn(|l| u64::from(self.lapses[l].is_none()).wrapping_neg()))
    }
}

/// Solves one or two batches whose parameters stand in `parameters`; the results stand in `chosen`, `observed`, `lapses`.
#[inline(always)]
pub(super) fn solve_batches<L: Lane>(plan: &Plan, batches: &mut [Buffers<L>]) {
    for buffers in &mut *batches {
        prepare(plan, buffers);
    }
    all_values(plan, batches);
    for buffers in batches {
        if plan.blocks.iter().all(|b| prefers_all(plan, b.m)) {
            count_by_values(plan, buffers);
        } else {
            count_by_octaves(plan, buffers);
        }
        for index in 0..buffers.blocks.len() {
            let passed = eigenpairs(plan, index, buffers);
            buffers.note(passed, Lapse::Residual);
        }
        choose_modes(plan, buffers);
    }
}

/// Tridiagonal matrices.
#[inline(always)]
fn prepare<L: Lane>(plan: &Plan, buffers: &mut Buffers<L>) {
    buffers.lapses = [None; LANES];
    let (mut stiff, mut massive) = (Mask::splat(true), Mask::splat(true));
    for (block, b) in plan.blocks.iter().zip(&mut buffers.blocks) {
        let (k_good, m_good) = reduce(block, plan.shift / plan.mass_scale, b, &buffers.parameters);
        stiff = stiff.and(k_good);
        massive = massive.and(m_good);
    }
    buffers.note(stiff, Lapse::Stiffness);
    buffers.note(massive, Lapse::Mass);
    let finite = scale(buffers);
    buffers.note(finite, Lapse::Stiffness);
}

/// Assembly, and the block as one symmetric matrix in tridiagonal form; the masks tell the lanes where K + a M and
/// Rᵀ M R are positive definite.
///
/// * `shift` - a over the scale of the masses
#[inline(always)]
fn reduce<L: Lane>(block: &Block, shift: f64, b: &mut BlockBuffers<L>, parameters: &[L]) -> (Mask, Mask) {
    assemble::evaluate(&block.stiffness, parameters, &mut b.l);
    assemble::evaluate(&block.mass, parameters, &mut b.mass);
    assemble::evaluate(&block.mass_rigid, parameters, &mut b.w);
    assemble::evaluate(&block.rigid_gram, parameters, &mut b.gram);
    let massive = assemble::rigid_factor(block.r, &mut b.w, &mut b.gram);
    assemble::free_mass(&block.envelope, block.r, &b.mass, &b.w, &mut b.c);
    if shift > 0.0 {
        cholesky::add(&block.envelope, shift, &b.c, &mut b.l);
    }
    let stiff = cholesky::factor(&block.envelope, &mut b.l);
    cholesky::reduce(&block.envelope, &b.l, &mut b.c);
    let [v, w, next, p] = &mut b.vectors;
    let mut reflectors = Reflectors { c: &mut b.c, beta: &mut b.beta, d: &mut b.d, e: &mut b.e, v, w, next, p };
    tridiagonal::tridiagonalise(block.m, &mut reflectors);
    (stiff, massive)
}

/// Divides all tridiagonal matrices by their largest row sum; gives the lanes where it is a number.
#[inline(always)]
fn scale<L: Lane>(buffers: &mut Buffers<L>) -> Mask {
    let (zero, one) = (L::splat(0.0), L::splat(1.0));
    let mut bound = zero;
    let mut sum = zero;
    for b in &buffers.blocks {
        let mut left = zero;
        for (&d, &e) in b.d.iter().zip(&b.e) {
            bound = (d.abs() + left + e.abs()).max(bound);
            sum = sum + d.abs() + e.abs();
            left = e.abs();
        }
    }
    // `max` skips NaN, the sum does not.
    let finite = sum.lt(L::splat(f64::MAX)).and(L::splat(f64::MIN_POSITIVE).lt(bound));
    let bound = L::select(finite, bound, one);
    let factor = one / bound;
    // An off-diagonal entry of this size changes no eigenvalue by more than rounding; exact zeros would stop the
    // recurrence of the Sturm count.
    let least = L::splat(f64::EPSILON / 16.0);
    for b in &mut buffers.blocks {
        for ((d, e), e2) in b.d.iter_mut().zip(&mut b.e).zip(&mut b.e2) {
            *d = L::select(finite, *d * factor, zero);
            let scaled = *e * factor;
            *e = L::select(least.lt(scaled.abs()), scaled, least);
            *e2 = *e * *e;
        }
    }
    buffers.bound = bound;
    finite
}

/// Counts the eigenvalues of all blocks above a point in a gap between those that QL has found, behind the n_modes-th of them: the modes
/// to be computed, with the proof that none is missed.
#[inline(always)]
fn count_by_values<L: Lane>(plan: &Plan, buffers: &mut Buffers<L>) {
    let wanted = plan.n_modes;
    let noise = L::splat(NOISE);
    let mut last = nth_value(&buffers.blocks, wanted);
    let mut next = nth_value(&buffers.blocks, wanted + 1).max(noise);
    for surplus in 1..=MARGIN {
        let joined = (L::splat(GAP) * last).lt(next);
        if !joined.any() {
            break;
        }
        last = L::select(joined, next, last);
        next = L::select(joined, nth_value(&buffers.blocks, wanted + surplus + 1).max(noise), next);
    }
    let mut alive = buffers.note(noise.lt(last), Lapse::Count);
    let cut = (last.max(noise) * next).sqrt();
    let (mut nonnegative, mut total) = (Mask::splat(true), Counter::ZERO);
    for b in &mut buffers.blocks {
        let t = Tridiagonal { d: &b.d, e: &b.e, e2: &b.e2 };
        sturm::evaluate(t, &[cut, -noise], &mut b.grid[..2]);
        nonnegative = nonnegative.and(b.grid[1].count.above(b.d.len() - 1));
        total = total.plus(b.grid[0].count);
    }
    alive = buffers.note(nonnegative, Lapse::Mass).and(alive);
    let fits = total.above(wanted - 1).and(total.above(wanted + MARGIN).not());
    alive = buffers.note(fits, Lapse::Count).and(alive);
    for b in &mut buffers.blocks {
        b.count = Counter::select(alive, b.grid[0].count, Counter::ZERO);
    }
    buffers.cut = cut;
}

/// The n-th largest eigenvalue (from one on) of all blocks, whose own are in order: where i of them come from one block and n - i from
/// the other, the smallest of all is that or less. Below zero where there are fewer.
#[inline(always)]
fn nth_value<L: Lane>(blocks: &[BlockBuffers<L>], n: usize) -> L {
    let of = |block: usize, k: usize| {
        let b = blocks.get(block)?;
        if k == 0 { Some(L::splat(f64::MAX)) } else { b.vectors[0][..b.d.len()].get(k - 1).copied() }
    };
    let mut best = L::splat(-1.0);
    for i in 0..=n {
        let Some(a) = of(0, i) else { break };
        let least = match of(1, n - i) {
            Some(b) => L::select(a.lt(b), a, b),
            None if blocks.len() == 1 && i == n => a,
            None => continue,
        };
        best = best.max(least);
    }
    best
}

/// Counts the eigenvalues of all blocks at the fixed points, and finds per lane a point above which there are at least
/// n_modes of them, and if a gap allows no more: the modes to be computed, with the proof that none is missed.
#[inline(always)]
fn count_by_octaves<L: Lane>(plan: &Plan, buffers: &mut Buffers<L>) {
    let wanted = plan.n_modes;
    for (g, x) in buffers.points[..GRID].iter_mut().enumerate() {
        *x = L::splat(match g {
            0 => 1.125,
            g if g <= OCTAVES => 0.5_f64.powi(g as i32),
            g if g == OCTAVES + 1 => NOISE,
            _ => -NOISE,
        });
    }
    let mut nonnegative = Mask::splat(true);
    for b in &mut buffers.blocks {
        let t = Tridiagonal { d: &b.d, e: &b.e, e2: &b.e2 };
        sturm::evaluate(t, &buffers.points[..GRID], &mut b.grid);
        nonnegative = nonnegative.and(b.grid[GRID - 1].count.above(b.d.len() - 1));
    }
    buffers.note(nonnegative, Lapse::Mass);
    let total =
        |g: usize, blocks: &[BlockBuffers<L>]| blocks.iter().fold(Counter::ZERO, |sum, b| sum.plus(b.grid[g].count));
    let mut low = buffers.points[OCTAVES + 1];
    let mut high = buffers.points[0];
    let mut at_low = total(OCTAVES + 1, &buffers.blocks);
    for b in &mut buffers.blocks {
        b.count = b.grid[OCTAVES + 1].count;
    }
    let mut found = Mask::splat(false);
    for g in 1..=OCTAVES + 1 {
        let sum = total(g, &buffers.blocks);
        let enough = sum.above(wanted - 1);
        let first = enough.and(found.not());
        low = L::select(first, buffers.points[g], low);
        at_low = Counter::select(first, sum, at_low);
        for b in &mut buffers.blocks {
            b.count = Counter::select(first, b.grid[g].count, b.count);
        }
        found = found.or(enough);
        high = L::select(found, high, buffers.points[g]);
    }
    let mut alive = buffers.note(found, Lapse::Count);
    // Halve the octave until the surplus is gone or, in a cluster, fits into the margin.
    for round in 0..48 {
        let surplus = at_low.above(if round < 4 { wanted } else { wanted + MARGIN });
        let open = surplus.and(alive);
        if !open.any() {
            break;
        }
        let middle = [(low * high).sqrt()];
        let mut sum = Counter::ZERO;
        for b in &mut buffers.blocks {
            let t = Tridiagonal { d: &b.d, e: &b.e, e2: &b.e2 };
            sturm::evaluate(t, &middle, &mut buffers.evaluations[..1]);
            // Kept here until the sum over the blocks is known.
            b.grid[0].count = buffers.evaluations[0].count;
            sum = sum.plus(b.grid[0].count);
        }
        let enough = sum.above(wanted - 1).and(open);
        low = L::select(enough, middle[0], low);
        at_low = Counter::select(enough, sum, at_low);
        for b in &mut buffers.blocks {
            b.count = Counter::select(enough, b.grid[0].count, b.count);
        }
        high = L::select(open.and(enough.not()), middle[0], high);
    }
    alive = buffers.note(at_low.above(wanted + MARGIN).not(), Lapse::Count).and(alive);
    for b in &mut buffers.blocks {
        b.grid[0].count = Counter::ZERO;
        b.count = Counter::select(alive, b.count, Counter::ZERO);
    }
    buffers.cut = low;
}

/// Whether all eigenvalues by QL (about m² steps of the recurrence) cost less than the wanted ones by secants (about 10 m
/// steps each, and much beside). It depends on the model alone: candidates must not learn who their companions are.
fn prefers_all(plan: &Plan, m: usize) -> bool {
    m <= 3 * plan.n_modes.div_ceil(plan.blocks.len())
}

/// All eigenvalues of the blocks that prefer this, descending, on their first scratch vector; of both halves of a symmetric model, and of both
/// batches, side by side.
#[inline(always)]
fn all_values<L: Lane>(plan: &Plan, batches: &mut [Buffers<L>]) {
    fn scratch<L: Lane>(b: &mut BlockBuffers<L>, rows: usize) -> Squared<'_, L> {
        let t = Tridiagonal { d: &b.d, e: &b.e, e2: &b.e2 };
        let [d, e2, ..] = &mut b.vectors;
        let mut squared = Squared { d: &mut d[..rows], e2: &mut e2[..rows] };
        squared.take(t);
        squared
    }
    let rows = plan.blocks.iter().map(|b| b.m).max().unwrap_or(0);
    if plan.blocks.len() == 2 && prefers_all(plan, rows) {
        match batches {
            [one, two] => {
                if let ([a, b], [c, d]) = (&mut one.blocks[..], &mut two.blocks[..]) {
                    let all = &mut [scratch(a, rows), scratch(b, rows), scratch(c, rows), scratch(d, rows)];
                    values::all_eigenvalues(rows, all);
                }
            }
            [one] => {
                if let [a, b] = &mut one.blocks[..] {
                    values::all_eigenvalues(rows, &mut [scratch(a, rows), scratch(b, rows)]);
                }
            }
            _ => {}
        }
    } else {
        for (index, block) in plan.blocks.iter().enumerate().filter(|(_, b)| prefers_all(plan, b.m)) {
            match batches {
                [one, two] => {
                    let [a, b] = [one, two].map(|buffers| scratch(&mut buffers.blocks[index], block.m));
                    values::all_eigenvalues(block.m, &mut [a, b]);
                }
                [one] => values::all_eigenvalues(block.m, &mut [scratch(&mut one.blocks[index], block.m)]),
                _ => {}
            }
        }
    }
    for (index, block) in plan.blocks.iter().enumerate().filter(|(_, b)| prefers_all(plan, b.m)) {
        for buffers in &mut *batches {
            values::sort(&mut buffers.blocks[index].vectors[0][..block.m]);
        }
    }
}

/// The counted eigenpairs of one block, observed at the sensors; gives the lanes that pass the residual test.
#[inline(always)]
fn eigenpairs<L: Lane>(plan: &Plan, index: usize, buffers: &mut Buffers<L>) -> Mask {
    let (block, width) = (&plan.blocks[index], plan.width());
    let b = &mut buffers.blocks[index];
    let count = b.count.largest();
    if count == 0 {
        return Mask::splat(true);
    }
    let t = Tridiagonal { d: &b.d, e: &b.e, e2: &b.e2 };
    if prefers_all(plan, block.m) {
        b.theta[..count].copy_from_slice(&b.vectors[0][..count]);
    } else {
        buffers.brackets.clear();
        let last = OCTAVES + 1;
        for j in 0..count {
            buffers.points[0] = L::splat(1.125);
            buffers.brackets.push(Bracket::among(j, &buffers.points[..=last], &b.grid[..=last], b.count.above(j)));
        }
        let (points, evaluations) = (&mut buffers.proposals[..count], &mut buffers.evaluations[..count]);
        sturm::refine(t, &mut buffers.brackets, points, evaluations, &mut b.theta[..count]);
    }
    let [inverse, upper1, upper2, multiplier] = &mut b.factors;
    let mut factors = Factors { inverse, upper1, upper2, multiplier, old: &mut b.old };
    let theta = &mut b.theta[..count];
    let z = &mut b.z;
    let mut passed = inverse_iteration::eigenvectors(t, theta, b.count, &plan.start, z, width, &mut factors);
    // As many orthogonal eigenvectors above the cut as the Sturm count says: all of them are found.
    let cut = L::splat(1.0 - 1e-9) * buffers.cut;
    for (j, &value) in theta.iter().enumerate() {
        passed = passed.and(cut.lt(value).or(b.count.above(j).not()));
    }
    tridiagonal::back_transform(block.m, &b.c, &b.beta, z, width, count);
    cholesky::solve_transposed(&block.envelope, &b.l, z, width, count);
    assemble::add_rigid(block, &b.w, &b.gram, z, width, count);
    // ψᵀ (s M) ψ = θ with s the scale of the masses, and λ + a = s / θ.
    let (scale, shift) = (L::splat(plan.mass_scale), L::splat(plan.shift));
    for j in 0..count {
        let shifted = scale / (theta[j] * buffers.bound);
        theta[j] = shifted - shift;
        let factor = shifted.sqrt();
        for i in 0..block.m + block.r {
            z[i * width + j] = z[i * width + j] * factor;
        }
    }
    if plan.with_shapes {
        assemble::observe(&block.observation, z, width, count, &mut b.observed);
    }
    if let Some(products) = &block.products {
        assemble::project(products, z, width, count, &mut b.products);
    }
    passed
}

/// Merges the blocks: the n_modes lowest λ of every lane.
#[inline(always)]
fn choose_modes<L: Lane>(plan: &Plan, buffers: &mut Buffers<L>) {
    rank_modes(buffers);
    for lane in 0..LANES {
        let chosen = &mut buffers.chosen[lane];
        chosen.clear();
        if buffers.lapses[lane].is_some() {
            continue;
        }
        let count: u64 = buffers.blocks.iter().map(|b| b.count.0[lane]).sum();
        chosen.resize(count as usize, (f64::NAN, 0, 0));
        for (block, b) in buffers.blocks.iter().enumerate() {
            for (column, (theta, rank)) in b.theta.iter().zip(&b.rank).enumerate().take(b.count.0[lane] as usize) {
                if let Some(mode) = chosen.get_mut(rank.0[lane] as usize) {
                    *mode = (theta.array()[lane], block, column);
                }
            }
        }
        // Modes of one block that are equal to rounding may stand in any order.
        if !chosen.is_sorted_by(|a, b| a.0 <= b.0) {
            chosen.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        }
        // A value at rounding level is not an elastic mode.
        let noise = chosen.last().map_or(0.0, |c| NOISE * (plan.shift + c.0));
        let elastic = chosen.iter().all(|c| c.0.is_finite() && c.0 > noise);
        if !elastic || chosen.len() < plan.n_modes {
            buffers.lapses[lane] = Some(Lapse::Residual);
        }
    }
}

/// The place of every λ among those of all blocks: one of a block stands behind those before it, and behind those of the other block
/// that are smaller.
#[inline(always)]
fn rank_modes<L: Lane>(buffers: &mut Buffers<L>) {
    let (zero, one, above_all) = (L::splat(0.0), L::splat(1.0), L::splat(f64::INFINITY));
    for b in &mut buffers.blocks {
        for (j, (theta, rank)) in b.theta.iter_mut().zip(&mut b.rank).enumerate().take(b.count.largest()) {
            *theta = L::select(b.count.above(j), *theta, above_all);
            *rank = Counter([j as u64; LANES]);
        }
    }
    if let [a, b] = &mut buffers.blocks[..] {
        let (n_a, n_b) = (a.count.largest(), b.count.largest());
        for i in 0..n_a {
            for j in 0..n_b {
                let difference = b.theta[j] - a.theta[i];
                difference.count_sign_change(zero, &mut a.rank[i]);
                difference.count_sign_change(-one, &mut b.rank[j]);
            }
        }
    }
}
