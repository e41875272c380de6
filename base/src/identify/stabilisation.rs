//! The stabilisation diagram and the choice of physical poles from it.
//!
//! A physical pole comes back at every model order that is high enough; a pole that fits noise does not. So poles of
//! successive orders are linked one to one into columns, nearest first, and a column is taken for a mode when
//!
//! 1. it has members at `min_presence` of the orders since it first appeared (gaps of up to two orders do not end it),
//! 2. at least `min_members` of them, and at least a quarter of all orders, and
//! 3. half of its members are stable in frequency and participation against their predecessor, and
//! 4. the damping changes from one order to the next by at most `scatter` times its tolerance, in the median: damping of
//!    a weak mode in noise wanders, but that of a pole which fits noise does so by its own size.
//!
//! The rules look at nothing but the diagram; what the poles explain of the data is judged afterwards by the fit.
//!
//! Source: R. Allemang, D. Brown, A complete review of the complex mode indicator function and stabilisation methods,
//! Handbook of Experimental Structural Dynamics, 2022; H. Van der Auweraer, B. Peeters, Discriminating physical poles
//! from mathematical poles in high order systems: use and automation of the stabilization diagram, IMTC 2004.

use super::plscf::Pole;
use retune_linalg::Complex;

/// What counts as the same pole at the next order, and which columns count as modes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stability {
    /// Largest relative change of frequency between orders.
    pub frequency: f64,
    /// Largest relative change of damping ratio between orders.
    pub damping: f64,
    /// Smallest MAC of participation vectors between orders (several references only).
    pub participation: f64,
    /// Largest damping ratio of a mode.
    pub max_damping: f64,
    /// Median change of damping within a mode's column, in units of `damping`.
    pub scatter: f64,
    /// Least share of orders, since its first, at which a mode's pole appears.
    pub min_presence: f64,
    /// Least number of orders at which a mode's pole appears.
    pub min_members: usize,
}

impl Default for Stability {
    /// 1 % frequency, 5 % damping, 0.95 participation: the customary tolerances of the diagram; damping up to 20 %,
    /// scatter 4 (20 %), presence 0.7, three members.
    fn default() -> Self {
        Self {
            frequency: 0.01,
            damping: 0.05,
            participation: 0.95,
            max_damping: 0.2,
            scatter: 4.0,
            min_presence: 0.7,
            min_members: 3,
        }
    }
}

/// A pole in the diagram with its marks.
#[derive(Debug, Clone, PartialEq)]
pub struct DiagramPole {
    /// Degree of the polynomial.
    pub order: usize,
    /// Pole and participation.
    pub pole: Pole,
    /// Frequency within tolerance of its predecessor in the column.
    pub is_frequency_stable: bool,
    /// Damping too.
    pub is_damping_stable: bool,
    /// Participation too (true for one reference).
    pub is_participation_stable: bool,
    /// Column it belongs to.
    pub column: usize,
}

impl DiagramPole {
    /// All three marks.
    pub fn is_stable(&self) -> bool {
        self.is_frequency_stable && self.is_damping_stable && self.is_participation_stable
    }
}

/// Poles over orders, and the columns chosen as modes.
#[derive(Debug, Clone, PartialEq)]
pub struct StabilisationDiagram {
    /// Model orders (degrees of the matrix polynomial; each has `order * n_inputs` poles).
    pub orders: Vec<usize>,
    /// All poles in the stable half-plane and the band, by order, then frequency.
    pub poles: Vec<DiagramPole>,
    /// Columns chosen as modes, by frequency.
    pub chosen: Vec<usize>,
}

struct Column {
    latest: usize,
    latest_order: usize,
    first_order: usize,
    members: Vec<usize>,
}

impl StabilisationDiagram {
    /// Links the poles of successive orders and chooses columns.
    pub fn build(orders: &[usize], poles: Vec<Vec<Pole>>, stability: &Stability) -> Self {
        let mut diagram = Self { orders: orders.to_vec(), poles: Vec::new(), chosen: Vec::new() };
        let mut columns: Vec<Column> = Vec::new();
        for (at, of_order) in poles.into_iter().enumerate() {
            let of_order: Vec<Pole> =
                of_order.into_iter().filter(|p| p.damping_ratio() <= stability.max_damping).collect();
            let mut links = Vec::new();
            for (p, pole) in of_order.iter().enumerate() {
                for (c, column) in columns.iter().enumerate() {
                    let distance = distance(pole, &diagram.poles[column.latest].pole);
                    if at - column.latest_order <= 3 && distance <= stability.frequency {
                        links.push((distance, p, c));
                    }
                }
            }
            links.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
            let mut partner: Vec<Option<usize>> = vec![None; of_order.len()];
            let mut taken = vec![false; columns.len()];
            for (_, p, c) in links {
                if partner[p].is_none() && !taken[c] {
                    (partner[p], taken[c]) = (Some(c), true);
                }
            }
            for (p, pole) in of_order.into_iter().enumerate() {
                let index = diagram.poles.len();
                let previous = partner[p].map(|c| &diagram.poles[columns[c].latest].pole);
                let change = |f: fn(&Pole) -> f64| previous.map_or(f64::INFINITY, |q| (f(&pole) / f(q) - 1.0).abs());
                let is_frequency_stable = change(Pole::frequency_hz) <= stability.frequency;
                let is_damping_stable = change(Pole::damping_ratio) <= stability.damping;
                let is_participation_stable =
                    previous.is_some_and(|q| mac(&pole.participation, &q.participation) >= stability.participation);
                let column = partner[p].unwrap_or(columns.len());
                diagram.poles.push(DiagramPole {
                    order: orders[at],
                    pole,
                    is_frequency_stable,
                    is_damping_stable,
                    is_participation_stable,
                    column,
                });
                if partner[p].is_none() {
                    columns.push(Column { latest: index, latest_order: at, first_order: at, members: Vec::new() });
                }
                let c = &mut columns[column];
                (c.latest, c.latest_order) = (index, at);
                c.members.push(index);
            }
        }
        let n_orders = orders.len();
        let mut chosen: Vec<usize> = (0..columns.len())
            .filter(|&c| {
                let Column { first_order, members, .. } = &columns[c];
                let is_steady = |p: &DiagramPole| p.is_frequency_stable && p.is_participation_stable;
                let stable = members.iter().filter(|&&m| is_steady(&diagram.poles[m])).count();
                let mut changes: Vec<f64> = members
                    .windows(2)
                    .map(|w| {
                        (diagram.poles[w[1]].pole.damping_ratio() / diagram.poles[w[0]].pole.damping_ratio()).ln().abs()
                    })
                    .collect();
                members.len() >= stability.min_members.max(n_orders.div_ceil(4))
                    && members.len() as f64 >= stability.min_presence * (n_orders - first_order) as f64
                    && 2 * stable >= members.len()
                    && super::band::median(&mut changes) <= stability.scatter * stability.damping
            })
            .collect();
        chosen.sort_by(|&a, &b| {
            let f = |c: usize| diagram.poles[columns[c].latest].pole.frequency_hz();
            f(a).total_cmp(&f(b))
        });
        diagram.chosen = chosen;
        diagram
    }

    /// Members of a column, by order.
    pub fn column(&self, column: usize) -> impl Iterator<Item = &DiagramPole> {
        self.poles.iter().filter(move |p| p.column == column)
    }

    /// The pole that stands for a column: of its upper half of orders, the one nearest to the median pole.
    pub fn representative(&self, column: usize) -> Option<&Pole> {
        let members: Vec<&Pole> = self.column(column).map(|p| &p.pole).collect();
        let upper = &members[members.len() / 2..];
        let middle = |f: fn(&Pole) -> f64| super::band::median(&mut upper.iter().map(|p| f(p)).collect::<Vec<_>>());
        let centre = Complex::new(middle(|p| p.value.re), middle(|p| p.value.im));
        upper.iter().copied().min_by(|a, b| (a.value - centre).norm().total_cmp(&(b.value - centre).norm()))
    }
}

/// |λ_a - λ_b| / |λ_b|, and infinitely far when the participations have nothing in common.
fn distance(a: &Pole, b: &Pole) -> f64 {
    // 0.5 separates two vectors of a pair of close modes, which are far from parallel, from one vector with noise.
    if mac(&a.participation, &b.participation) < 0.5 {
        return f64::INFINITY;
    }
    (a.value - b.value).norm() / b.value.norm()
}

/// |aᴴb|² / (aᴴa bᴴb); 0 for a zero vector.
pub(super) fn mac(a: &[Complex<f64>], b: &[Complex<f64>]) -> f64 {
    let dot = |x: &[Complex<f64>], y: &[Complex<f64>]| x.iter().zip(y).map(|(x, y)| x.conj() * y).sum::<Complex<f64>>();
    let scale = dot(a, a).re * dot(b, b).re;
    if scale > 0.0 { dot(a, b).norm_sqr() / scale } else { 0.0 }
}
