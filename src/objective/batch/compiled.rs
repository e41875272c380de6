//! A model and a test, compiled for the batched kernel.

use super::super::close_modes::{clusters, seen, turning};
use super::super::comparison::Comparison;
use super::super::prediction::{Prediction, PredictionDerivative};
use super::super::scaling::Scaling;
use super::affine::{Products, pencil};
use super::{CostOf, Linearized};
use crate::correlation::{ModePair, PartnerSearch, UNSEEN, hide_unseen};
use crate::linalg::batch::{
    BATCH, BatchError, BatchModel, BatchModes, BatchOptions, Mirror, Outcome, Workspace, detect_mirror,
};
use crate::linalg::{DMatrix, DVector, PencilSlopes, SymMatrix};
use crate::model::{MassProperties, family, symmetry_index};
use std::sync::{Mutex, PoisonError};

/// Above this number of dofs of one family of shapes the reference path is no slower than the dense kernel, for many points at a time.
const MOST_DOFS: usize = 150;
/// The same where single points are asked for, with derivatives: eight lanes of matrices of more rows than these leave the cache.
const MOST_DOFS_ALONE: usize = 80;

/// A comparison, compiled for batches.
#[derive(Debug)]
pub(super) struct Compiled {
    model: BatchModel,
    n_sensors: usize,
    /// Rows of the sensors and of what is followed.
    n_read: usize,
    /// Whether the kernel gives the products of shapes with those of the test, and the shapes themselves.
    has_products: bool,
    has_shapes: bool,
    /// Whether the dofs come behind those rows in the observed shapes, to find families or derivatives from them.
    pub(super) has_dofs: bool,
    /// Derivatives of the modes, where they are wanted.
    slopes: Option<Slopes>,
    tests: Vec<TestShape>,
    /// Test modes as the search for partners knows them: frequencies, family codes.
    frequencies: Vec<f64>,
    families: Vec<u8>,
    /// Products of parameters that K and M depend on beside the free parameters themselves.
    products: Products,
    rigid: Option<RigidMass>,
    pool: Mutex<Vec<Bench>>,
}

/// What derivatives need beside the modes.
#[derive(Debug)]
struct Slopes {
    pencil: PencilSlopes,
    /// The observation matrix by its entries: sensor, dof, value.
    sensors: Vec<(usize, usize, f64)>,
}

/// Mass of rigid motion, affine in the free parameters and products: few of its entries depend on one.
#[derive(Debug)]
struct RigidMass {
    constant: SymMatrix,
    /// (entry of the lower triangle, factor, coefficient).
    terms: Vec<(usize, usize, f64)>,
}

impl RigidMass {
    fn new<'a>(constant: SymMatrix, masses: impl Iterator<Item = &'a SymMatrix>) -> Self {
        let mut terms = Vec::new();
        for (factor, mass) in masses.enumerate() {
            let entries = mass.lower().iter().enumerate().filter(|(_, value)| **value != 0.0);
            terms.extend(entries.map(|(entry, value)| (entry, factor, *value)));
        }
        Self { constant, terms }
    }

    fn at(&self, factors: &[f64], out: &mut SymMatrix) {
        out.copy_from(&self.constant);
        let lower = out.lower_mut();
        for &(entry, factor, value) in &self.terms {
            lower[entry] += factors[factor] * value;
        }
    }
}

/// A measured shape at the sensors.
#[derive(Debug)]
struct TestShape {
    /// Zero where it was not measured.
    values: Vec<f64>,
    /// One where it was measured, zero elsewhere; nothing if it was measured everywhere.
    mask: Option<Vec<f64>>,
    norm: f64,
    /// 1/|shape|²; zero where nothing was measured.
    over_square: f64,
}

/// The memory of one thread.
#[derive(Debug)]
pub(super) struct Bench {
    workspace: Workspace,
    theta: Vec<f64>,
    /// The free parameters of the candidates, and their products.
    factors: [Vec<f64>; BATCH],
    prediction: Prediction,
    residuals: DVector<f64>,
    search: PartnerSearch,
    partners: Vec<(usize, usize)>,
    families: Vec<u8>,
    norms: Vec<f64>,
    likeness: DMatrix<f64>,
    rigid: SymMatrix,
    turned: Vec<(usize, Vec<f64>)>,
}

/// The shapes of one candidate: rows of the sensors, of what is followed, and of the dofs.
#[derive(Clone, Copy)]
struct Shapes<'a> {
    modes: &'a BatchModes,
    lane: usize,
    /// Those that have been turned to the test: the mode, and its shape.
    turned: &'a [(usize, Vec<f64>)],
}

impl<'a> Shapes<'a> {
    fn of(&self, mode: usize) -> &'a [f64] {
        match self.turned.iter().find(|(m, _)| *m == mode) {
            Some((_, shape)) => shape,
            None => self.modes.shape(self.lane, mode),
        }
    }
}

/// What the kernel has seen at a point.
struct Seen<'a> {
    prediction: &'a Prediction,
    theta: &'a [f64],
    /// What K and M are affine in.
    factors: &'a [f64],
    lambda: &'a [f64],
    shapes: Shapes<'a>,
    /// Room for residuals.
    residuals: &'a mut DVector<f64>,
}

/// A number for a symmetry family.
fn code(family: Option<&str>) -> u8 {
    match family {
        None => 0,
        Some("symmetric") => 1,
        Some("antisymmetric") => 2,
        Some(_) => 3,
    }
}

impl Compiled {
    /// `None` if the kernel does not take the model.
    ///
    /// * `has_derivatives` - whether derivatives are wanted
    pub(super) fn new(
        comparison: &Comparison<'_>,
        scaling: &Scaling,
        needs_shapes: bool,
        has_derivatives: bool,
    ) -> Option<Self> {
        let model = comparison.model();
        let families: Vec<u8> = comparison.families().iter().map(|f| code(f.as_deref())).collect();
        PartnerSearch::new(comparison.frequencies(), &families, *comparison.pairing(), comparison.plans())?;
        let n = model.dof_map().n_dof();
        let most = if has_derivatives { MOST_DOFS_ALONE } else { MOST_DOFS };
        let most = |has_mirror: bool| if has_mirror { 2 * most } else { most };
        // Modes of one space are paired before they are turned, and again after that, and dashpots couple modes: the reference path does it.
        let is_for_reference =
            !comparison.varying_sensors().is_empty() || comparison.has_spaces() || comparison.has_dashpots();
        if n > most(model.mirror().is_some()) || is_for_reference {
            return None;
        }
        // In the middle of the bounds nothing vanishes by chance: no mass, no spring.
        let centre = comparison.predict(&scaling.centre()).ok()?;
        if centre.modes.n_mechanism > 0 {
            return None;
        }
        let pencil = pencil(comparison, scaling)?;
        let mirror = model
            .mirror()
            .map(|m| Mirror { permutation: m.iter().map(|p| p.0).collect(), signs: m.iter().map(|p| p.1).collect() });
        let halves = mirror.filter(|m| matches!(detect_mirror(&pencil, m), Ok(true)));
        if n > most(halves.is_some()) {
            return None;
        }
        let has_dofs = has_derivatives || (model.mirror().is_some() && halves.is_none());
        let n_sensors = comparison.sensors().nrows();
        let followed = comparison.followed();
        let n_read = n_sensors + followed.len();
        let sensors = DMatrix::from_fn(n_read + if has_dofs { n } else { 0 }, n, |i, j| {
            if i < n_sensors {
                comparison.sensors()[(i, j)]
            } else if i < n_read {
                followed.rows()[(i - n_sensors, j)]
            } else {
                f64::from(u8::from(i - n_read == j))
            }
        });
        let tests: Vec<TestShape> = comparison.shapes().column_iter().map(|c| TestShape::new(c.as_slice())).collect();
        // A shape with gaps is compared where it was measured: its partner's length depends on it.
        // Close modes are turned to the test, which products do not allow.
        let has_products = !has_dofs
            && centre.clusters.is_empty()
            && followed.len() == 0
            && tests.iter().all(|t| t.mask.is_none() || t.norm == 0.0);
        let options = BatchOptions {
            n_modes: centre.frequencies_hz.len(),
            rigid: centre.modes.shapes.columns(0, centre.modes.n_rigid).into_owned(),
            mirror: halves,
            sensors: Some(sensors),
            references: has_products.then(|| comparison.shapes().map(|v| if v.is_nan() { 0.0 } else { v })),
            shapes: needs_shapes || !has_products,
        };
        let slopes = has_derivatives.then(|| Slopes {
            pencil: PencilSlopes::new(&pencil),
            sensors: comparison
                .sensors()
                .column_iter()
                .enumerate()
                .flat_map(|(j, c)| c.iter().enumerate().map(|(i, v)| (i, j, *v)).collect::<Vec<_>>())
                .filter(|e| e.2 != 0.0)
                .collect(),
        });
        let products = Products::of(model.affine()?);
        let mut nominal = vec![0.0; pencil.n_parameters];
        products.fill(&scaling.centre(), scaling, &mut nominal);
        let batch = match BatchModel::new(pencil.clone(), &nominal, options.clone()) {
            // Masses that are small beside the others leave fewer modes above rounding than the reference path lists.
            Err(BatchError::TooManyModes { available, .. }) if available > 0 => {
                BatchModel::new(pencil, &nominal, BatchOptions { n_modes: available, ..options })
            }
            made => made,
        };
        let rigid = model.affine_mass().map(|masses| {
            let mut constant = masses.linear[0].clone();
            for (i, value) in scaling.base().iter().enumerate().filter(|(i, _)| !scaling.free().contains(i)) {
                constant.add_scaled(*value, &masses.linear[i + 1]);
            }
            let free = scaling.free().iter().map(|&i| &masses.linear[i + 1]);
            RigidMass::new(constant, free.chain(&masses.products))
        });
        Some(Self {
            model: batch.ok()?,
            n_sensors,
            n_read,
            has_products,
            has_shapes: needs_shapes || !has_products,
            has_dofs,
            slopes,
            tests,
            frequencies: comparison.frequencies().to_vec(),
            families,
            products,
            rigid,
            pool: Mutex::default(),
        })
    }

    /// A bench from the pool, or a new one.
    pub(super) fn bench(&self) -> Option<Bench> {
        self.pool.lock().unwrap_or_else(PoisonError::into_inner).pop()
    }

    pub(super) fn put_back(&self, bench: Option<Bench>) {
        self.pool.lock().unwrap_or_else(PoisonError::into_inner).extend(bench);
    }

    /// Empties the pool.
    pub(super) fn rest(&self) {
        self.pool.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }

    fn new_bench(&self, comparison: &Comparison<'_>, scaling: &Scaling) -> Option<Bench> {
        let n_modes = self.model.n_modes();
        Some(Bench {
            workspace: Workspace::new(&self.model, BATCH),
            theta: scaling.base().to_vec(),
            factors: std::array::from_fn(|_| vec![0.0; scaling.len() + self.products.len()]),
            prediction: Prediction::seen(
                vec![0.0; n_modes],
                DMatrix::zeros(self.n_sensors, n_modes),
                DMatrix::zeros(n_modes, self.tests.len()),
            ),
            residuals: DVector::zeros(0),
            search: PartnerSearch::new(&self.frequencies, &self.families, *comparison.pairing(), comparison.plans())?,
            partners: Vec::with_capacity(self.tests.len()),
            families: vec![0; n_modes],
            norms: vec![0.0; n_modes],
            likeness: DMatrix::zeros(n_modes, self.tests.len()),
            rigid: SymMatrix::zeros(6),
            turned: Vec::new(),
        })
    }

    /// The costs of up to [`BATCH`] points; NaN where the kernel does not guarantee one.
    pub(super) fn evaluate(
        &self,
        bench: &mut Option<Bench>,
        problem: (&Comparison<'_>, &Scaling),
        points: &[DVector<f64>],
        out: &mut [f64],
        cost_of: CostOf<'_>,
    ) {
        out.fill(f64::NAN);
        self.predict(bench, problem, points, |lane, seen| {
            out[lane] = cost_of(seen.prediction, seen.theta, seen.residuals);
        });
    }

    /// What is made of the prediction at a point and its derivatives; `None` where the kernel does not guarantee them, or a paired mode is double.
    pub(super) fn linearize<T>(
        &self,
        bench: &mut Option<Bench>,
        problem: (&Comparison<'_>, &Scaling),
        x: &DVector<f64>,
        of: Linearized<'_, T>,
    ) -> Option<T> {
        let slopes = self.slopes.as_ref()?;
        let mut made = None;
        self.predict(bench, problem, std::slice::from_ref(x), |_, seen| {
            let p = seen.prediction;
            let at = slopes.pencil.at(seen.factors);
            let directions = self.products.directions(seen.theta, problem.1);
            let mut modes = vec![None; p.frequencies_hz.len()];
            for pair in &p.pairs.pairs {
                let (mode, f) = (pair.analytical, p.frequencies_hz[pair.analytical]);
                let lambda = seen.lambda[mode];
                let cluster = p.clusters.iter().find(|c| c.contains(&mode)).map_or(&[][..], Vec::as_slice);
                let all = std::iter::once(mode).chain(cluster.iter().copied().filter(|&k| k != mode));
                let shapes: Vec<&[f64]> = all.map(|k| &seen.shapes.of(k)[self.n_read..]).collect();
                let Some((d_lambda, d_shape)) = at.mode(lambda, &shapes, &directions) else { return };
                let mut at_sensors = DMatrix::zeros(self.n_sensors, directions.ncols());
                for (mut seen, d) in at_sensors.column_iter_mut().zip(d_shape.column_iter()) {
                    let (seen, d) = (seen.as_mut_slice(), d.as_slice());
                    slopes.sensors.iter().for_each(|&(sensor, dof, value)| seen[sensor] += value * d[dof]);
                }
                // f = √λ / 2π, so ∂f = ∂λ f / 2λ.
                modes[mode] = Some((d_lambda * (f / (2.0 * lambda)), at_sensors));
            }
            made = Some(of(p, &PredictionDerivative { modes }, seen.theta));
        });
        made
    }

    /// Predicts up to [`BATCH`] points; those that the kernel does not guarantee are left out.
    ///
    /// * `each` - gets the number of a point, and what is seen there
    fn predict(
        &self,
        bench: &mut Option<Bench>,
        (comparison, scaling): (&Comparison<'_>, &Scaling),
        points: &[DVector<f64>],
        mut each: impl FnMut(usize, Seen<'_>),
    ) {
        if bench.is_none() {
            *bench = self.new_bench(comparison, scaling);
        }
        let Some(bench) = bench else { return };
        for (factors, x) in bench.factors.iter_mut().zip(points) {
            scaling.overwrite(x, &mut bench.theta);
            self.products.fill(&bench.theta, scaling, factors);
        }
        let thetas: [&[f64]; BATCH] = std::array::from_fn(|l| bench.factors[l].as_slice());
        let closeness = comparison.closeness();
        let Ok(modes) = self.model.attempt(&thetas[..points.len()], &mut bench.workspace) else { return };
        for (lane, x) in points.iter().enumerate() {
            if modes.outcome(lane) != &Outcome::Batch {
                continue;
            }
            scaling.overwrite(x, &mut bench.theta);
            let p = &mut bench.prediction;
            p.mass_properties = match &self.rigid {
                Some(rigid) => {
                    rigid.at(&bench.factors[lane], &mut bench.rigid);
                    Some(MassProperties::from_rigid_mass(&bench.rigid))
                }
                None => match comparison.model().mass_properties(&bench.theta) {
                    Ok(properties) => properties,
                    Err(_) => continue,
                },
            };
            bench.turned.clear();
            let as_found = Shapes { modes, lane, turned: &[] };
            self.observe(comparison, as_found, p, &mut bench.families);
            let own = &bench.families;
            p.clusters = clusters(&p.frequencies_hz, closeness, |a, b| own[a] == own[b]);
            if comparison.has_shapes() && !p.clusters.is_empty() {
                // Where only products are known nothing can be turned: the reference path does it.
                if !self.has_shapes {
                    continue;
                }
                p.clusters = seen(std::mem::take(&mut p.clusters), &p.at_sensors);
                // A turned shape of two families has another, which without dofs is not known.
                if !self.has_dofs && p.clusters.iter().any(|c| c.iter().any(|&k| own[k] != own[c[0]])) {
                    continue;
                }
                for cluster in &p.clusters {
                    if let Some(q) = turning(&p.at_sensors, cluster, comparison.measured(None)) {
                        bench.turned.extend(turned(as_found, cluster, &q));
                    }
                }
                let shapes = Shapes { turned: &bench.turned, ..as_found };
                self.observe(comparison, shapes, p, &mut bench.families);
            }
            let shapes = Shapes { turned: &bench.turned, ..as_found };
            if self.has_shapes {
                hide_unseen(&mut p.at_sensors);
            }
            if self.has_products {
                self.correlate_products(&bench.families, &bench.search, (modes, lane), p);
            } else {
                self.correlate(&bench.families, &bench.search, p, &mut bench.norms);
            }
            let likeness = self.likeness(comparison, shapes, &p.mac, &mut bench.likeness);
            let (likeness, n) = (likeness.as_slice(), p.mac.nrows());
            bench.search.find(&p.frequencies_hz, &bench.families, |j| &likeness[j * n..][..n], &mut bench.partners);
            p.pairs.pairs.clear();
            p.pairs.pairs.extend(bench.partners.iter().map(|&(i, j)| ModePair {
                analytical: i,
                experimental: j,
                mac: p.mac[(i, j)],
                frequency_error: p.frequencies_hz[i] / self.frequencies[j] - 1.0,
                flags: Vec::new(),
            }));
            let (theta, factors) = (bench.theta.as_slice(), bench.factors[lane].as_slice());
            let lambda = modes.values(lane);
            each(lane, Seen { prediction: p, theta, factors, lambda, shapes, residuals: &mut bench.residuals });
        }
    }

    /// Frequencies, shapes at the sensors and families of one candidate.
    fn observe(&self, comparison: &Comparison<'_>, shapes: Shapes<'_>, p: &mut Prediction, families: &mut [u8]) {
        let Shapes { modes, lane, .. } = shapes;
        for (j, lambda) in modes.values(lane).iter().enumerate() {
            p.frequencies_hz[j] = lambda.sqrt() / std::f64::consts::TAU;
            let shape = shapes.of(j);
            if self.has_shapes {
                p.at_sensors.column_mut(j).copy_from_slice(&shape[..self.n_sensors]);
            }
            families[j] = match comparison.model().mirror() {
                Some(mirror) if self.has_dofs => code(family(symmetry_index(mirror, |row| shape[self.n_read + row]))),
                _ => [2, 0, 1][(modes.parity(lane, j) + 1) as usize],
            };
        }
    }

    /// What pairs are made by: the MAC, mixed with how far the modes continue those that are followed.
    fn likeness<'m>(
        &self,
        comparison: &Comparison<'_>,
        shapes: Shapes<'_>,
        mac: &'m DMatrix<f64>,
        own: &'m mut DMatrix<f64>,
    ) -> &'m DMatrix<f64> {
        let followed = comparison.followed();
        if followed.len() == 0 {
            return mac;
        }
        own.copy_from(mac);
        for i in 0..mac.nrows() {
            let shape = shapes.of(i);
            for k in 0..followed.len() {
                followed.mix(k, i, shape[self.n_sensors + k], own);
            }
        }
        own
    }

    /// MAC of the pairs that the families allow, zero for the others, from the products that the kernel has formed.
    fn correlate_products(
        &self,
        families: &[u8],
        search: &PartnerSearch,
        (modes, lane): (&BatchModes, usize),
        p: &mut Prediction,
    ) {
        let own = |i: usize| modes.products(lane, i).last().copied().unwrap_or(0.0);
        let least = UNSEEN * UNSEEN * (0..families.len()).map(own).fold(0.0, f64::max);
        for (i, &family) in families.iter().enumerate() {
            let Some((&own, products)) = modes.products(lane, i).split_last() else { continue };
            let over_own = if own > 0.0 && own >= least { 1.0 / own } else { 0.0 };
            for (j, (product, test)) in products.iter().zip(&self.tests).enumerate() {
                let is_compared = search.is_same_family(family, j);
                let mac = product * product * over_own * test.over_square;
                p.mac[(i, j)] = if is_compared { mac.min(1.0) } else { 0.0 };
            }
        }
    }

    /// The same from the shapes.
    fn correlate(&self, families: &[u8], search: &PartnerSearch, p: &mut Prediction, norms: &mut [f64]) {
        let n_modes = families.len();
        for i in 0..n_modes {
            let shape = &p.at_sensors.as_slice()[i * self.n_sensors..(i + 1) * self.n_sensors];
            norms[i] = dot(shape, shape).sqrt();
        }
        for (j, test) in self.tests.iter().enumerate() {
            for i in 0..n_modes {
                let shape = &p.at_sensors.as_slice()[i * self.n_sensors..(i + 1) * self.n_sensors];
                p.mac[(i, j)] = if test.norm > 0.0 && search.is_same_family(families[i], j) {
                    let norm = match &test.mask {
                        None => norms[i],
                        Some(mask) => shape.iter().zip(mask).map(|(v, m)| v * v * m).sum::<f64>().sqrt(),
                    };
                    let cosine = dot(shape, &test.values) / norm / test.norm;
                    if norm > 0.0 { (cosine * cosine).min(1.0) } else { 0.0 }
                } else {
                    0.0
                };
            }
        }
    }
}

impl TestShape {
    fn new(shape: &[f64]) -> Self {
        let values: Vec<f64> = shape.iter().map(|v| if v.is_nan() { 0.0 } else { *v }).collect();
        let complete = shape.iter().all(|v| !v.is_nan());
        let mask = (!complete).then(|| shape.iter().map(|v| f64::from(u8::from(!v.is_nan()))).collect());
        let norm = dot(&values, &values).sqrt();
        let over_square = if norm > 0.0 { 1.0 / (norm * norm) } else { 0.0 };
        Self { values, mask, norm, over_square }
    }
}

/// The shapes of a cluster, turned.
fn turned<'a>(
    shapes: Shapes<'a>,
    cluster: &'a [usize],
    q: &'a DMatrix<f64>,
) -> impl Iterator<Item = (usize, Vec<f64>)> {
    cluster.iter().zip(q.column_iter()).map(move |(&mode, q)| {
        let mut sum = vec![0.0; shapes.of(mode).len()];
        for (&k, factor) in cluster.iter().zip(q.iter()) {
            sum.iter_mut().zip(shapes.of(k)).for_each(|(s, v)| *s += factor * v);
        }
        (mode, sum)
    })
}

/// Sum of products, four at a time.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a4, b4) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = a4.remainder().iter().zip(b4.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a4.zip(b4) {
        for l in 0..4 {
            sums[l] += x[l] * y[l];
        }
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3]) + rest
}
