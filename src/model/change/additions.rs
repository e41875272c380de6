//! Many changes of one file, placed at once, and each of them alone.

use super::altered::Altered;
use super::factored::{Factored, OnRows};
use super::{Change, Part};
use crate::element::Dof;
use crate::model::connection::{Connection, motion_in_axes, place as place_of};
use crate::model::constraint::{Elimination, eliminate};
use crate::model::dof_map::Combination;
use crate::model::elastic_support::ElasticSupports;
use crate::model::moving::EndMotion;
use crate::model::place::{Placed, place, riding};
use crate::model::placed_element::{Compliance, PlacedElement};
use crate::model::registry::Registry;
use crate::model::spec::ModelSpec;
use crate::model::value::{Affine, Value};
use crate::model::{Model, ParametricModel};
use crate::yaml::Severity;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::{Arc, Mutex, PoisonError};

/// A file with many changes, placed.
#[derive(Debug)]
pub struct Additions {
    model: Arc<Model>,
    placed: Placed,
    elimination: Elimination,
    /// Index in θ of a parameter.
    index_of: HashMap<String, usize>,
    /// Elements that depend on a parameter of a change, by its index.
    users: HashMap<usize, Vec<usize>>,
    /// Nodes of the model by those of the longer file.
    nodes: Vec<Option<usize>>,
    /// Nodes of the model whose dofs ride with them, should a change move them.
    riding: HashSet<usize>,
    /// Elements of the model by name.
    known: HashMap<String, usize>,
    /// Paths of what is wrong in the file.
    refused: Vec<String>,
    /// Matrices of superelements and terms, by the index of their element in the model, as they are asked for.
    on_rows: Mutex<HashMap<usize, Arc<OnRows>>>,
}

impl Additions {
    /// Places a file that is the model's with more entries and parameters, the parameters last.
    pub fn new(model: &Arc<Model>, longer: &ModelSpec, registry: &Registry) -> Self {
        let mut problems = Vec::new();
        let placed = place(longer, registry, &mut problems);
        let elimination = eliminate(longer, &placed.geometry, Elimination::default(), &[], &placed.rows, &mut problems);
        let n = model.parameters().len();
        let mut users: HashMap<usize, Vec<usize>> = HashMap::new();
        for (e, element) in placed.elements.iter().enumerate() {
            let mut of: Vec<usize> = element.expressions().flat_map(Value::parameters).filter(|&p| p >= n).collect();
            of.sort_unstable();
            of.dedup();
            for p in of {
                users.entry(p).or_default().push(e);
            }
        }
        let index_of = placed.parameters.names().enumerate().map(|(i, name)| (name.to_string(), i)).collect();
        let known = model.elements().iter().enumerate().map(|(i, e)| (e.name.clone(), i)).collect();
        let nodes = placed.geometry.names.iter().map(|name| model.geometry().node(name)).collect();
        let wrong = problems.into_iter().filter(|p| p.severity == Severity::Error);
        let refused = wrong.map(|p| p.path).collect();
        let moves = !placed.moved.is_empty();
        let riding = if moves { riding(model.spec(), model.geometry(), model.elements()) } else { HashSet::new() };
        let (model, on_rows) = (model.clone(), Mutex::default());
        Self { model, placed, elimination, index_of, users, nodes, riding, known, refused, on_rows }
    }

    /// The matrices of an element of the model that stands for a superelement or a term of one.
    fn on_rows(&self, element: usize) -> Option<Arc<OnRows>> {
        let matrices = self.model.elements()[element].matrices.as_ref()?;
        let mut known = self.on_rows.lock().unwrap_or_else(PoisonError::into_inner);
        let new = || Arc::new(OnRows::new(matrices, self.model.dof_map(), &self.model.geometry().positions));
        Some(known.entry(element).or_insert_with(new).clone())
    }

    /// The change that some parameters bring; `None` where the file refuses one of its entries, or it changes more than elements and how
    /// much supports give.
    ///
    /// * `parameters` - their names, in the order of the sizes
    /// * `entries` - names of everything that the change adds
    /// * `typical` - sizes of an order that is expected
    pub fn change(&self, parameters: &[&str], entries: &[&str], typical: &[f64]) -> Option<Change> {
        let is_added = |path: &str| entries.iter().any(|name| is_of(path, name));
        if self.refused.iter().any(|path| is_added(path)) {
            return None;
        }
        let n = self.model.parameters().len();
        let own: Vec<usize> = parameters.iter().map(|p| self.index_of.get(*p).copied()).collect::<Option<_>>()?;
        // A parameter of another change stands at its neutral value.
        let alone = |value: &Value| {
            value.with_parameters(&|p| match own.iter().position(|o| *o == p) {
                Some(k) => Ok(n + k),
                None if p < n => Ok(p),
                None => Err(self.placed.parameters.get(p).value),
            })
        };
        let mut touched: Vec<usize> = own.iter().filter_map(|p| self.users.get(p)).flatten().copied().collect();
        touched.sort_unstable();
        touched.dedup();
        let mut new = NewCoordinates { additions: self, found: BTreeMap::new() };
        let mut parts: Vec<Part> = Vec::new();
        for e in touched {
            // What another change brings may hang on a node that this one moves.
            let before = self.known.get(&self.placed.elements[e].name).copied();
            if before.is_none() && !is_added(&self.placed.elements[e].path) {
                continue;
            }
            let mut element = self.placed.elements[e].clone();
            for value in Arc::make_mut(&mut element.values).iter_mut().flatten() {
                *value = alone(value);
            }
            for factor in [
                &mut element.stiffness_factor,
                &mut element.mass_factor,
                &mut element.stiffness_damping,
                &mut element.mass_damping,
            ] {
                *factor = factor.as_ref().map(alone);
            }
            element.moving = element.moving.as_ref().and_then(|m| m.map(alone)).map(|m| {
                // As in the model with this change alone: links of others hold no node.
                Arc::new(m.riding(|k| Some(self.riding.contains(&self.nodes[element.nodes[k]]?))))
            });
            if element.matrices.is_some() {
                // A change brings no superelement.
                let before = before?;
                parts.push(Part::Factored(Box::new(Factored::new(element, before, self.on_rows(before)?))));
                continue;
            }
            parts.push(match before {
                Some(before) => {
                    // Nodes of other changes may stand before them in the longer file.
                    element.nodes = element.nodes.iter().map(|&n| self.nodes[n]).collect::<Option<_>>()?;
                    let last = parts.iter().rev().find_map(|part| match part {
                        Part::Altered { after, .. } => Some(after),
                        _ => None,
                    });
                    Part::Altered { before, after: Altered::new(element, &self.model.elements()[before], last) }
                }
                None => {
                    let (connection, ends) = (new.connection(&element)?, element.ends(&self.placed.geometry.positions));
                    Part::Brought { connection: Box::new(connection), element: Box::new(element), ends: ends.into() }
                }
            });
        }
        parts.extend(self.supports(&own, &alone, &parts)?);
        let dof_of = |(&d, &coordinate): (&usize, &usize)| {
            (coordinate, (self.placed.geometry.positions[d / 6], Dof::ALL[d % 6]))
        };
        let mut stand: Vec<_> = new.found.iter().map(dof_of).collect();
        stand.sort_by_key(|s| s.0);
        let new = stand.into_iter().map(|s| s.1).collect();
        parts.shrink_to_fit();
        let moved =
            self.placed.moved.iter().filter(|(_, motion)| motion.depends_on(&own)).filter_map(|(&n, motion)| {
                let node = self.nodes[n]?;
                Some((node, EndMotion { rides: self.riding.contains(&node), ..motion.map(alone) }))
            });
        let moved = moved.collect();
        let change = Change { model: self.model.clone(), parts, new, n_sizes: own.len(), moved };
        change.without_idle_coordinates(typical)
    }

    /// Supports that give with the change, as they are with and without it; nothing where it does not change what they do.
    ///
    /// * `parts` - its elements
    fn supports(&self, own: &[usize], alone: &dyn Fn(&Value) -> Value, parts: &[Part]) -> Option<Vec<Part>> {
        let with_parts = |supports: &ElasticSupports| {
            let altered = parts.iter().filter_map(|part| match part {
                Part::Altered { before, after } => Some((*before, after.element(&self.model.elements()[*before]))),
                Part::Factored(part) => Some((part.before, (*part.after).clone())),
                _ => None,
            });
            let brought = parts.iter().filter_map(|part| match part {
                Part::Brought { connection, element, .. } => Some((&**element, &**connection)),
                _ => None,
            });
            supports.with(altered, brought, |n| self.nodes[n])
        };
        let before = self.model.elastic_supports();
        let is_own = |c: &&Compliance| c.value.parameters().any(|p| own.contains(&p));
        if !self.placed.compliances.iter().any(|c| is_own(&c)) {
            let after = before.and_then(with_parts);
            let before = before.filter(|_| after.is_some());
            return Some(after.map(|s| Part::supports(s, 1.0)).into_iter().chain(before.map(Part::without)).collect());
        }
        let geometry = self.model.geometry();
        // Compliances of dofs that only other changes make give are zero.
        let moved = |c: &Compliance| {
            let node = self.nodes[c.dof / 6]?;
            Some(Compliance { holder: c.holder, dof: 6 * node + c.dof % 6, value: alone(&c.value) })
        };
        // What only other changes make give does not give here.
        let gives = |c: &Compliance| c.value.parameters().next().is_some() || c.value.at(&[]) != 0.0;
        let all: Vec<Compliance> = self.placed.compliances.iter().map(moved).collect::<Option<_>>()?;
        let compliances: Vec<Compliance> = all.into_iter().filter(gives).collect();
        let n_nodes = geometry.names.len();
        // A node of another change may have shifted rows of superelements.
        if !self.placed.rows.is_empty() && self.placed.geometry.names.len() != n_nodes {
            return None;
        }
        let keeping = Elimination::keeping(6 * n_nodes);
        let rows = &self.placed.rows;
        let released = eliminate(self.model.spec(), geometry, keeping, &compliances, rows, &mut Vec::new());
        let (elements, connections) = self.model.elements_and_connections();
        let after = ElasticSupports::new(compliances, &released, n_nodes, elements, connections, self.model.dof_map())?;
        let after = with_parts(&after).unwrap_or(after);
        Some([Part::supports(after, 1.0)].into_iter().chain(before.map(Part::without)).collect())
    }
}

/// Whether a path leads to an entry or into it: `masses.tip` and `beams.a.nodes[2]`, and not `masses.tip2`.
fn is_of(path: &str, entry: &str) -> bool {
    let ends = |at: usize| path[at + entry.len()..].chars().next().is_none_or(|c| c == '.' || c == '[');
    path.match_indices(entry).any(|(at, _)| path[..at].ends_with('.') && ends(at))
}

/// Dofs of nodes that the model does not have.
struct NewCoordinates<'a> {
    additions: &'a Additions,
    /// (6 node + dof of the longer file) -> coordinate.
    found: BTreeMap<usize, usize>,
}

impl NewCoordinates<'_> {
    /// How an element that the model does not have hangs on its rows and on new coordinates; `None` if it is on nothing.
    fn connection(&mut self, element: &PlacedElement) -> Option<Connection> {
        let nodes: BTreeMap<usize, [Combination; 6]> =
            element.nodes.iter().map(|&n| (n, Dof::ALL.map(|dof| self.terms(n, dof)))).collect();
        let of = |node: usize, dof: Dof| &nodes[&node][dof as usize][..];
        let mut rows: Vec<usize> = nodes.values().flatten().flatten().map(|t| t.0).collect();
        rows.sort_unstable();
        rows.dedup();
        let b = motion_in_axes(element, rows.len(), of, |row| place_of(&rows, row));
        Some(Connection::of(rows, &b))
    }

    /// A dof of a node of the longer file in rows of the model, and in new coordinates behind them.
    fn terms(&mut self, node: usize, dof: Dof) -> Combination {
        let Additions { model, elimination, nodes, .. } = self.additions;
        let dofs = model.dof_map();
        let on_model = |node: usize| nodes[node];
        if let Some(known) = on_model(node) {
            return dofs.express(known, dof).to_vec();
        }
        let mut sum: BTreeMap<usize, f64> = BTreeMap::new();
        for (d, factor) in elimination.express(6 * node + dof as usize) {
            match on_model(d / 6) {
                Some(known) => {
                    let terms = dofs.express(known, Dof::ALL[d % 6]);
                    for &(row, f) in terms {
                        *sum.entry(row).or_default() += factor * f;
                    }
                }
                None => {
                    let next = self.found.len();
                    let coordinate = *self.found.entry(d).or_insert(next);
                    *sum.entry(dofs.n_dof() + coordinate).or_default() += factor;
                }
            }
        }
        sum.into_iter().collect()
    }
}

impl Value {
    /// With other parameters, or with their values in their places.
    fn with_parameters(&self, of: &dyn Fn(usize) -> Result<usize, f64>) -> Self {
        let changed = |affine: &Affine| affine.with_parameters(of);
        let is = |affine: &Affine, value: f64| affine.terms.is_empty() && affine.constant == value;
        // Factors of one and addends of zero are those of other changes.
        Self {
            factors: self.factors.iter().map(changed).filter(|a| !is(a, 1.0)).collect(),
            addends: self.addends.iter().map(changed).filter(|a| !is(a, 0.0)).collect(),
            rigidity: self.rigidity.as_ref().map(|r| r.with_parameters(of)),
        }
    }
}
