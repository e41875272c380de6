//! Supports that give: dofs held by springs of a compliance, condensed.

use super::connection::{Connection, motion_in_axes, place};
use super::constraint::Elimination;
use super::dependence::{central_difference, element_matrices};
use super::dof_map::{Combination, DofMap};
use super::placed_element::{Compliance, PlacedElement};
use super::placed_matrices::PlacedMatrices;
use super::value::Value;
use super::{ElementMatrices, ModelError};
use crate::element::Dof;
use crate::linalg::{DMatrix, DVector, SymMatrix};

/// What the compliances of supports add to the matrices of the rigid supports.
///
/// The held dofs s stand on springs of compliance C, and follow the others statically:
///
/// ```text
/// u_s = t q,    t = -(I + C K_ss)⁻¹ C K_sq
/// ΔK = K_qs t,    ΔM = M_qs t + tᵀ M_sq + tᵀ M_ss t,    and ΔC as ΔM
/// ```
///
/// C = 0 adds nothing. The inertia of s is in M but not in t: exact in statics, and an error of the order of ω² M_ss/K_ss.
#[derive(Debug, Clone)]
pub(super) struct ElasticSupports {
    compliances: Vec<Value>,
    /// Elements that s moves, with their motion u_e = B_s s, (6 nodes) x (n_s), in their axes.
    elements: Vec<(usize, DMatrix<f64>)>,
    /// Those of them, and superelements, that a change has made others, by index.
    altered: Vec<(usize, PlacedElement)>,
    /// What a change brings where s moves, with its connection and its motion with s.
    brought: Vec<(PlacedElement, Connection, DMatrix<f64>)>,
    /// Superelements that s moves.
    bodies: Vec<Body>,
    /// Per dof of every node, its part of s.
    nodes: Vec<Combination>,
    /// The rows that those elements touch, with the unit matrix.
    connection: Connection,
    /// Indices in θ.
    parameters: Vec<usize>,
}

impl ElasticSupports {
    /// None where no support gives.
    ///
    /// * `released` - the constraints with dof 6 `n_nodes` + i for the held dof of the i-th compliance
    pub(super) fn new(
        compliances: Vec<Compliance>,
        released: &Elimination,
        n_nodes: usize,
        elements: &[PlacedElement],
        connections: &[Connection],
        dofs: &DofMap,
    ) -> Option<Self> {
        let (n_s, first) = (compliances.len(), 6 * n_nodes);
        let of_springs = |dof: usize| -> Combination {
            released.express(dof).into_iter().filter(|t| t.0 >= first).map(|(d, f)| (d - first, f)).collect()
        };
        let nodes: Vec<Combination> = (0..first).map(of_springs).collect();
        let motion = |e: &PlacedElement| motion_in_axes(e, n_s, |node, dof| &nodes[6 * node + dof as usize], |s| s);
        let moved: Vec<(usize, DMatrix<f64>)> = elements
            .iter()
            .enumerate()
            .filter(|(_, e)| e.nodes.iter().any(|n| (6 * n..6 * n + 6).any(|dof| !nodes[dof].is_empty())))
            .map(|(i, e)| (i, motion(e)))
            .collect();
        let bodies: Vec<Body> =
            elements.iter().enumerate().filter_map(|(i, e)| Body::new(i, e.matrices.as_ref()?, &nodes, dofs)).collect();
        if moved.is_empty() && bodies.is_empty() {
            return None;
        }
        let mut rows: Vec<usize> = moved.iter().flat_map(|(e, _)| connections[*e].rows.iter().copied()).collect();
        rows.extend(bodies.iter().flat_map(Body::rows));
        rows.sort_unstable();
        rows.dedup();
        let compliances: Vec<Value> = compliances.into_iter().map(|c| c.value).collect();
        let all = moved.iter().map(|m| m.0).chain(bodies.iter().map(|b| b.element));
        let of_elements = all.flat_map(|e| elements[e].expressions());
        let mut parameters: Vec<usize> = compliances.iter().chain(of_elements).flat_map(Value::parameters).collect();
        parameters.sort_unstable();
        parameters.dedup();
        let (altered, brought) = (Vec::new(), Vec::new());
        let connection = Connection::unit(rows);
        Some(Self { compliances, elements: moved, altered, brought, bodies, nodes, connection, parameters })
    }

    /// The same supports where a change makes elements others, or brings some; `None` where it does so only elsewhere.
    ///
    /// * `altered` - by index, as they are then
    /// * `brought` - with its connection
    /// * `node` - of the model, for one of what is brought
    pub(super) fn with<'a>(
        &self,
        altered: impl Iterator<Item = (usize, PlacedElement)>,
        brought: impl Iterator<Item = (&'a PlacedElement, &'a Connection)>,
        node: impl Fn(usize) -> Option<usize>,
    ) -> Option<Self> {
        let is_moved = |e: usize| self.moves(e) || self.bodies.iter().any(|b| b.element == e);
        let altered: Vec<_> = altered.filter(|(e, _)| is_moved(*e)).collect();
        let of = |(element, connection): (&PlacedElement, &Connection)| {
            let terms = |own: usize, dof: Dof| node(own).map_or(&[][..], |n| &self.nodes[6 * n + dof as usize][..]);
            let b = motion_in_axes(element, self.compliances.len(), terms, |s| s);
            (b.amax() > 0.0).then(|| (element.clone(), connection.clone(), b))
        };
        let brought: Vec<_> = brought.filter_map(of).collect();
        if altered.is_empty() && brought.is_empty() {
            return None;
        }
        let mut rows = self.connection.rows.clone();
        rows.extend(brought.iter().flat_map(|(_, connection, _)| &connection.rows));
        rows.sort_unstable();
        rows.dedup();
        let elements = altered.iter().map(|a| &a.1).chain(brought.iter().map(|b| &b.0));
        let mut parameters = self.parameters.clone();
        parameters.extend(elements.flat_map(PlacedElement::expressions).flat_map(Value::parameters));
        parameters.sort_unstable();
        parameters.dedup();
        Some(Self { altered, brought, connection: Connection::unit(rows), parameters, ..self.clone() })
    }

    /// An element as it is here.
    fn element<'a>(&'a self, e: usize, elements: &'a [PlacedElement]) -> &'a PlacedElement {
        self.altered.iter().find(|a| a.0 == e).map_or(&elements[e], |a| &a.1)
    }

    /// How their matrices lie in the rows.
    pub(super) fn connection(&self) -> &Connection {
        &self.connection
    }

    /// Whether anything of it depends on parameter `j`.
    pub(super) fn depends_on(&self, j: usize) -> bool {
        self.parameters.contains(&j)
    }

    /// ΔK, ΔM and ΔC on the rows of [`Self::connection`].
    pub(super) fn matrices(
        &self,
        elements: &[PlacedElement],
        connections: &[Connection],
        theta: &[f64],
    ) -> Result<ElementMatrices, ModelError> {
        let [k, m, c] = self.blocks(elements, connections, theta)?;
        let t = self.followers(&k, theta);
        let condensed = |block: &Block| {
            let coupled = block.between.transpose() * &t;
            symmetric_part(&(&coupled + coupled.transpose() + t.transpose() * &block.own * &t))
        };
        Ok(ElementMatrices {
            stiffness: symmetric_part(&(k.between.transpose() * &t)),
            mass: condensed(&m),
            weighed_mass: None,
            damping: condensed(&c),
        })
    }

    /// ∂/∂θ_j of [`Self::matrices`], by those of the elements and of the compliances:
    ///
    /// ```text
    /// t' = -(I + C K_ss)⁻¹ (C' (K_sq + K_ss t) + C (K_sq' + K_ss' t))
    /// ```
    ///
    /// * `step` - for the differences of the elements' matrices
    pub(super) fn slopes(
        &self,
        elements: &[PlacedElement],
        connections: &[Connection],
        theta: &[f64],
        j: usize,
        step: f64,
    ) -> Result<ElementMatrices, ModelError> {
        let at = |s: f64| {
            let mut theta = theta.to_vec();
            theta[j] += s * step;
            theta
        };
        let blocks = |s: f64| self.blocks(elements, connections, &at(s));
        let now = blocks(0.0)?;
        let of_model = self.elements.iter().map(|m| m.0).chain(self.bodies.iter().map(|b| b.element));
        let mut all = of_model.map(|e| self.element(e, elements)).chain(self.brought.iter().map(|b| &b.0));
        let slopes = if all.any(|e| e.depends_on(j)) {
            central_difference(blocks, step, |a, b, width| {
                std::array::from_fn(|i| Block {
                    own: (&a[i].own - &b[i].own) / width,
                    between: (&a[i].between - &b[i].between) / width,
                })
            })?
        } else {
            [(); 3].map(|()| self.no_block())
        };
        let (k, k_slope) = (&now[0], &slopes[0]);
        let (above, below) = (self.compliances_at(&at(1.0)), self.compliances_at(&at(-1.0)));
        let c_slope = (above - below) / (2.0 * step);
        let t = self.followers(k, theta);
        let c = self.compliances_at(theta);
        let by_compliance = c_slope * (&k.between + &k.own * &t);
        let by_stiffness = &c * (&k_slope.between + &k_slope.own * &t);
        let t_slope = solve(&c, k, &-(by_compliance + by_stiffness));
        let condensed = |block: &Block, slope: &Block| {
            let coupled = slope.between.transpose() * &t + block.between.transpose() * &t_slope;
            let own = t.transpose() * &block.own * &t_slope;
            let squared = &own + own.transpose() + t.transpose() * &slope.own * &t;
            symmetric_part(&(&coupled + coupled.transpose() + squared))
        };
        Ok(ElementMatrices {
            stiffness: symmetric_part(&(k_slope.between.transpose() * &t + k.between.transpose() * &t_slope)),
            mass: condensed(&now[1], &slopes[1]),
            weighed_mass: None,
            damping: condensed(&now[2], &slopes[2]),
        })
    }

    /// What the giving supports add to the motion of a node: (row, factor) of each of its dofs; `None` where they do not
    /// move it.
    pub(super) fn node_motion(
        &self,
        node: usize,
        elements: &[PlacedElement],
        connections: &[Connection],
        theta: &[f64],
    ) -> Result<Option<[Combination; 6]>, ModelError> {
        let own = &self.nodes[6 * node..6 * node + 6];
        if own.iter().all(Vec::is_empty) {
            return Ok(None);
        }
        let [k, ..] = self.blocks(elements, connections, theta)?;
        let t = self.followers(&k, theta);
        let on_rows = |combination: &Combination| {
            let at = |column: usize| combination.iter().map(|&(s, factor)| factor * t[(s, column)]).sum();
            let all = self.connection.rows.iter().enumerate().map(|(column, &row)| (row, at(column)));
            all.filter(|(_, factor)| *factor != 0.0).collect()
        };
        Ok(Some(Dof::ALL.map(|dof| on_rows(&own[dof as usize]))))
    }

    /// The motion of an element with the giving supports, u_e = B q\[rows\], in its axes; `None` where they do not move it.
    pub(super) fn element_motion(
        &self,
        element: usize,
        elements: &[PlacedElement],
        connections: &[Connection],
        theta: &[f64],
    ) -> Result<Option<Connection>, ModelError> {
        let Some((_, b_s)) = self.elements.iter().find(|(e, _)| *e == element) else { return Ok(None) };
        let [k, ..] = self.blocks(elements, connections, theta)?;
        let mut b = b_s * self.followers(&k, theta);
        let held = &connections[element];
        for (row, own) in held.rows.iter().zip(held.b().column_iter()) {
            let mut column = b.column_mut(place(&self.connection.rows, *row));
            column += own;
        }
        Ok(Some(Connection::of(self.connection.rows.clone(), &b)))
    }

    /// Whether the giving supports move an element.
    pub(super) fn moves(&self, element: usize) -> bool {
        self.elements.iter().any(|(e, _)| *e == element)
    }

    /// t = -(I + C K_ss)⁻¹ C K_sq.
    fn followers(&self, k: &Block, theta: &[f64]) -> DMatrix<f64> {
        let c = self.compliances_at(theta);
        let forced = -&c * &k.between;
        solve(&c, k, &forced)
    }

    fn compliances_at(&self, theta: &[f64]) -> DMatrix<f64> {
        let c = self.compliances.iter().map(|c| c.at(theta));
        DMatrix::from_diagonal(&DVector::from_iterator(self.compliances.len(), c))
    }

    fn no_block(&self) -> Block {
        let (n_s, n_q) = (self.compliances.len(), self.connection.rows.len());
        Block { own: DMatrix::zeros(n_s, n_s), between: DMatrix::zeros(n_s, n_q) }
    }

    /// K, M and C between the held dofs, and between them and the rows.
    fn blocks(
        &self,
        elements: &[PlacedElement],
        connections: &[Connection],
        theta: &[f64],
    ) -> Result<[Block; 3], ModelError> {
        let mut blocks = [(); 3].map(|()| self.no_block());
        let of_model = self.elements.iter().map(|(e, b_s)| (self.element(*e, elements), &connections[*e], b_s));
        let brought = self.brought.iter().map(|(element, connection, b_s)| (element, connection, b_s));
        for (element, connection, b_s) in of_model.chain(brought) {
            let b = connection.b();
            let matrices = element_matrices(element, theta)?;
            for (block, matrix) in blocks.iter_mut().zip([&matrices.stiffness, &matrices.mass, &matrices.damping]) {
                if matrix.is_zero() {
                    continue;
                }
                let force = b_s.transpose() * matrix.to_dense();
                block.own += &force * b_s;
                let between = force * &b;
                for (j, row) in connection.rows.iter().enumerate() {
                    let mut column = block.between.column_mut(place(&self.connection.rows, *row));
                    column += between.column(j);
                }
            }
        }
        for body in &self.bodies {
            body.add(self.element(body.element, elements), theta, &self.connection.rows, &mut blocks);
        }
        Ok(blocks)
    }
}

/// (I + C K_ss)⁻¹ a. K_ss is positive semidefinite and C not negative, so that it is regular.
fn solve(c: &DMatrix<f64>, k: &Block, a: &DMatrix<f64>) -> DMatrix<f64> {
    let held = DMatrix::identity(c.nrows(), c.nrows()) + c * &k.own;
    held.lu().solve(a).unwrap_or_else(|| DMatrix::zeros(a.nrows(), a.ncols()))
}

fn symmetric_part(a: &DMatrix<f64>) -> SymMatrix {
    let lower: Vec<f64> = (0..a.nrows()).flat_map(|i| (0..=i).map(move |j| 0.5 * (a[(i, j)] + a[(j, i)]))).collect();
    SymMatrix::from_lower(a.nrows(), &lower)
}

/// A superelement, or a term of one, that the held dofs move: the entries of its matrices that they touch.
#[derive(Debug, Clone)]
struct Body {
    element: usize,
    /// Per dof of it, its part of s and its rows.
    held: Vec<Combination>,
    rows: Vec<Combination>,
    /// Of K, M and C.
    entries: [Vec<crate::matrices::Entry>; 3],
}

impl Body {
    fn new(element: usize, matrices: &PlacedMatrices, nodes: &[Combination], dofs: &DofMap) -> Option<Self> {
        let held: Vec<Combination> = matrices
            .dofs
            .iter()
            .map(|d| d.parts().flat_map(|(i, a)| nodes[i].iter().map(move |&(s, f)| (s, a * f))).collect())
            .collect();
        if held.iter().all(Vec::is_empty) {
            return None;
        }
        let touches =
            |e: &&crate::matrices::Entry| !held[e.row as usize].is_empty() || !held[e.column as usize].is_empty();
        let entries = [&matrices.k, &matrices.m, &matrices.c]
            .map(|a| a.iter().flat_map(|a| &a.lower).filter(touches).copied().collect());
        Some(Self { element, rows: matrices.follows(dofs).all().to_vec(), held, entries })
    }

    /// The rows between which and the held dofs it has entries.
    fn rows(&self) -> impl Iterator<Item = usize> + '_ {
        let dofs = self.entries.iter().flatten().flat_map(|e| [e.row, e.column]);
        dofs.flat_map(|d| self.rows[d as usize].iter().map(|t| t.0))
    }

    fn add(&self, element: &PlacedElement, theta: &[f64], rows: &[usize], blocks: &mut [Block; 3]) {
        let at = |v: &Option<Value>, absent: f64| v.as_ref().map_or(absent, |v| v.at(theta));
        let (stiffness, mass) = (at(&element.stiffness_factor, 1.0), at(&element.mass_factor, 1.0));
        let damping = element.matrices.as_ref().map_or(0.0, |m| at(&m.damping_factor, 1.0));
        let uses = [
            (0, 0, stiffness),
            (1, 1, mass),
            (2, 2, damping),
            (0, 2, stiffness * at(&element.stiffness_damping, 0.0)),
            (1, 2, mass * at(&element.mass_damping, 0.0)),
        ];
        for (from, to, factor) in uses.into_iter().filter(|u| u.2 != 0.0) {
            let block = &mut blocks[to];
            for e in &self.entries[from] {
                let (i, j, value) = (e.row as usize, e.column as usize, factor * e.value);
                let pairs = [(i, j), (j, i)];
                for &(a, b) in &pairs[..if i == j { 1 } else { 2 }] {
                    for &(s, f) in &self.held[a] {
                        self.held[b].iter().for_each(|&(t, g)| block.own[(s, t)] += value * f * g);
                        self.rows[b].iter().for_each(|&(r, g)| block.between[(s, place(rows, r))] += value * f * g);
                    }
                }
            }
        }
    }
}

/// A matrix between the held dofs (n_s x n_s), and between them and the rows (n_s x n_q).
struct Block {
    own: DMatrix<f64>,
    between: DMatrix<f64>,
}
