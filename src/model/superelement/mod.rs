//! From the files that a superelement names to its matrices, in SI and in its own axes.

mod files;
mod free;
mod rounding;
mod solver;
mod terms;
mod units;

use super::exported::{Exported, ExportedDof, ExportedMatrices, ExportedNode, Loaded};
use super::geometry::{GLOBAL, axes_of_frames};
use super::spec::{MatrixSpec, ModelSpec, Named, SuperelementSpec};
use crate::catalogue::{counted, did_you_mean};
use crate::matrices::{Contents, DofRow, Label, Matrix, Symmetric};
use crate::yaml::{Problem, Severity, child};
use files::Files;
use solver::Runs;
pub use solver::{SOLVER_FOLDER, SolverRun};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::io;
use std::sync::Arc;
use units::Units;

/// Reads the files of all superelements of a model; entries that say the same of their matrices share them.
///
/// * `read` - the bytes of a file by its path in the model file
///
/// Returns what was wrong, warnings among it.
pub(super) fn read_files(spec: &mut ModelSpec, read: &mut dyn FnMut(&str) -> io::Result<Vec<u8>>) -> Vec<Problem> {
    let mut problems = Vec::new();
    let mut files = Files::new(read);
    let axes = axes_of_frames(spec);
    let mut known: Vec<(SuperelementSpec, Arc<Exported>)> = Vec::new();
    let names: Vec<String> = spec.superelements.keys().cloned().collect();
    for name in names {
        let path = child("superelements", &name);
        let source = source(&spec.superelements[&name]);
        let same = known.iter().find(|(s, _)| *s == source).map(|(_, e)| e.clone());
        let exported = same.or_else(|| {
            let mut reading = Reading { spec, axes: &axes, files: &mut files, path: &path, problems: &mut problems };
            let entry = match &source.solver {
                Some(solver) => reading.of_solver(&name, &source, solver)?,
                None => source.clone(),
            };
            reading.superelement(&entry).map(Arc::new)
        });
        if let Some(exported) = exported {
            known.push((source, exported.clone()));
            spec.superelements[&name].loaded = Loaded(Some(exported));
        }
    }
    problems
}

/// The runs of the programs that the superelements of a model ask for, each once.
///
/// * `read` - as for [`read_files`]
pub(super) fn solver_runs(
    spec: &ModelSpec,
    read: &mut dyn FnMut(&str) -> io::Result<Vec<u8>>,
) -> Result<Vec<SolverRun>, Vec<Problem>> {
    let (mut problems, mut files, axes) = (Vec::new(), Files::new(read), axes_of_frames(spec));
    let mut out: Vec<SolverRun> = Vec::new();
    for (name, entry) in &spec.superelements {
        let path = child("superelements", name);
        let mut reading = Reading { spec, axes: &axes, files: &mut files, path: &path, problems: &mut problems };
        let Some(solver) = &entry.solver else { continue };
        for run in reading.runs(name, entry, solver).iter().flat_map(Runs::all) {
            if out.iter().all(|known| known.process != run.process) {
                out.push(run.clone());
            }
        }
    }
    if problems.is_empty() { Ok(out) } else { Err(problems) }
}

/// What an entry says of its matrices, without its place.
fn source(entry: &SuperelementSpec) -> SuperelementSpec {
    SuperelementSpec {
        frame: None,
        mirror: None,
        attach: Named::new(),
        attach_within: None,
        effect_nodes: None,
        loaded: Loaded::default(),
        ..entry.clone()
    }
}

/// Whether two entries say the same of their matrices.
pub(super) fn have_same_source(a: &SuperelementSpec, b: &SuperelementSpec) -> bool {
    source(a) == source(b)
}

/// One superelement that is being read.
struct Reading<'a, 'b> {
    spec: &'a ModelSpec,
    axes: &'a BTreeMap<String, [[f64; 3]; 3]>,
    files: &'a mut Files<'b>,
    path: &'a str,
    problems: &'a mut Vec<Problem>,
}

fn is_unplaced(row: &DofRow, positions: &Positions) -> bool {
    row.label.dof.is_some() && row.position.is_none() && !positions.contains_key(&row.label.node)
}

/// A dof of a name that the table has already, under a name of its own, `3#2.ux`: CalculiX gives the other face of a shell the node's number.
fn again_of(row: &DofRow, known: &HashMap<Label, usize>) -> DofRow {
    let named = |k: usize| Label { node: format!("{}#{k}", row.label.node), dof: row.label.dof };
    // As many names as the table has rows are enough.
    let label = (2..known.len() + 3).map(named).find(|label| !known.contains_key(label));
    DofRow { label: label.unwrap_or_else(|| row.label.clone()), ..row.clone() }
}

/// A dof of an inner node as a coordinate of its own, `1280.ux`.
fn coordinate(row: &DofRow) -> DofRow {
    let node = row.label.dof.map_or_else(|| row.label.node.clone(), |dof| format!("{}.{}", row.label.node, dof.name()));
    DofRow { label: Label { node, dof: None }, position: None, frame: None }
}

/// The dofs of a superelement, and where each stands.
struct Dofs {
    labels: Vec<Label>,
    index: HashMap<Label, usize>,
    /// Factor from SI to the files: u of the file = factor · u.
    to_file: Vec<f64>,
}

impl Reading<'_, '_> {
    fn error(&mut self, key: &str, message: impl std::fmt::Display) {
        let path = if key.is_empty() { self.path.to_string() } else { child(self.path, key) };
        self.problems.push(Problem::error(path, message));
    }

    fn superelement(&mut self, entry: &SuperelementSpec) -> Option<Exported> {
        let units = Units::of(entry.units.as_ref(), &child(self.path, "units"), self.problems)?;
        if entry.k.is_none() && entry.m.is_none() {
            self.error("", "a superelement needs a stiffness matrix `k` or a mass matrix `m`: `k: wing_K.mtx`");
            return None;
        }
        let base = [("k", &entry.k), ("m", &entry.m), ("c", &entry.c)];
        let preload = entry.preload.as_ref().map(|p| p.k.clone());
        let base: Vec<(&str, Option<&MatrixSpec>)> =
            base.into_iter().map(|(k, m)| (k, m.as_ref())).chain([("preload.k", preload.as_ref())]).collect();
        // Everything is read before anything is judged, so that all files that are missing are said at once.
        let picked: Vec<Option<Option<Picked>>> =
            base.iter().map(|(key, m)| m.map_or(Some(None), |m| self.pick(key, m).map(Some))).collect();
        let table = self.table(entry, &base, picked.iter().flatten().flatten());
        let picked: Vec<Option<Picked>> = picked.into_iter().collect::<Option<_>>()?;
        let (rows, positions) = table?;
        let (dofs, exported_nodes, exported_dofs) = self.dofs(&rows, &positions, &units, entry.inner)?;
        let keys = ["k", "m", "c", "preload.k"];
        let scales = [units.stiffness(), units.mass(), units.damping(), units.stiffness()];
        let mut all = Vec::new();
        for ((picked, key), scale) in picked.into_iter().zip(keys).zip(scales) {
            all.push(picked.map(|p| self.in_si(&p, key, &dofs, scale)).transpose().ok()?);
        }
        let [k, m, c, preload] = <[Option<Arc<Symmetric>>; 4]>::try_from(all).ok()?;
        let is_modal: Vec<bool> = exported_dofs.iter().map(|d| d.dof.is_none()).collect();
        let clean = |k: &Arc<Symmetric>, m: &Arc<Symmetric>| rounding::without_rounding(k, m, &is_modal).map(Arc::new);
        let k = k.as_ref().zip(m.as_ref()).and_then(|(k, m)| clean(k, m)).or(k);
        let k = if entry.free { Some(self.freed(k.as_deref(), &exported_dofs, &exported_nodes)?) } else { k };
        let base = ExportedMatrices { k, m, c };
        let terms = self.terms(entry, &dofs, &units, &base)?;
        self.checks(entry, &dofs, &units, &base, &terms)?;
        let mut exported =
            Exported { nodes: exported_nodes, dofs: exported_dofs, base, preload, terms, recovered: Vec::new() };
        if let Some(recovery) = &entry.recovery {
            self.recovery(recovery, &dofs, &units, &mut exported)?;
        }
        Some(exported)
    }

    /// A matrix of a file, as it stands there.
    fn pick(&mut self, key: &str, wanted: &MatrixSpec) -> Option<Picked> {
        let contents = self.contents(key, &wanted.file)?;
        let names: Vec<&str> = contents.matrices.iter().map(|m| m.name.as_str()).collect();
        let found = match &wanted.matrix {
            Some(name) => contents.matrices.iter().position(|m| m.name == *name),
            None if names.len() == 1 => Some(0),
            None => None,
        };
        let Some(place) = found else {
            let file = &wanted.file;
            let list = names.iter().take(12).map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ");
            let message = match &wanted.matrix {
                _ if names.is_empty() => format!("`{file}` holds no matrix"),
                Some(name) => {
                    let suggestion = did_you_mean(name, names.iter().copied());
                    format!("`{file}` holds no matrix `{name}`; it holds {list}{suggestion}")
                }
                None => format!("`{file}` holds {list}; say which: `{{file: {file}, matrix: {}}}`", names[0]),
            };
            self.error(key, message);
            return None;
        };
        Some(Picked { contents, place, is_triangle: wanted.triangle })
    }

    fn contents(&mut self, key: &str, file: &str) -> Option<Arc<Contents>> {
        match self.files.contents(file) {
            Ok(contents) => Some(contents),
            Err(why) => {
                self.error(key, format_args!("`{file}`: {why}"));
                None
            }
        }
    }

    /// The rows of the table of dofs, and positions of nodes from wherever they are said.
    fn table<'p>(
        &mut self,
        entry: &SuperelementSpec,
        base: &[(&str, Option<&MatrixSpec>)],
        picked: impl Iterator<Item = &'p Picked> + Clone,
    ) -> Option<(Vec<DofRow>, Positions)> {
        let mut positions = Positions::new();
        let mut rows: Vec<DofRow> = Vec::new();
        for (key, file) in [("dofs", &entry.dofs), ("nodes", &entry.nodes)] {
            let Some(file) = file else { continue };
            let contents = self.contents(key, file)?;
            positions.extend(places_of(&contents));
            if key == "nodes" {
                positions
                    .extend(contents.dofs.iter().filter_map(|r| Some((r.label.node.clone(), (r.position?, None)))));
                continue;
            }
            let of_matrices = contents.matrices.iter().find(|m| !m.rows.is_empty()).map(|m| &m.rows);
            rows = if contents.dofs.is_empty() {
                of_matrices.map_or_else(Vec::new, |labels| labels.iter().map(unplaced).collect())
            } else {
                contents.dofs.clone()
            };
            if rows.is_empty() {
                self.error(key, format_args!("`{file}` holds no table of dofs"));
                return None;
            }
        }
        for p in picked.clone() {
            // What was said first holds.
            let mut own = places_of(&p.contents);
            own.extend(std::mem::take(&mut positions));
            positions = own;
        }
        if rows.is_empty() {
            // Where matrices say their dofs, those of all of them: a mass matrix may lack what has no mass.
            let mut seen: HashSet<&Label> = HashSet::new();
            let labels: Vec<&Label> = picked.flat_map(|p| &p.matrix().rows).filter(|l| seen.insert(*l)).collect();
            rows = labels.into_iter().map(unplaced).collect();
        }
        if rows.is_empty() {
            let files: Vec<String> = base.iter().filter_map(|b| Some(format!("`{}`", b.1?.file))).collect();
            self.error("", format_args!("the rows of {} have no names: give the table of dofs, `dofs: table.csv` with the columns node, dof, x, y, z", files.join(", ")));
            return None;
        }
        Some((rows, positions))
    }

    /// Nodes and dofs of the table, with their places.
    ///
    /// * `has_inner` - whether nodes without a position are inner ones
    fn dofs(
        &mut self,
        rows: &[DofRow],
        positions: &Positions,
        units: &Units,
        has_inner: bool,
    ) -> Option<(Dofs, Vec<ExportedNode>, Vec<ExportedDof>)> {
        let mut nodes: Vec<ExportedNode> = Vec::new();
        let mut node_of: HashMap<String, usize> = HashMap::new();
        let mut dofs = Dofs { labels: Vec::new(), index: HashMap::new(), to_file: Vec::new() };
        let mut out = Vec::new();
        for row in rows {
            let again = has_inner && dofs.index.contains_key(&row.label);
            let row = if again { &again_of(row, &dofs.index) } else { row };
            if dofs.index.insert(row.label.clone(), dofs.labels.len()).is_some() {
                self.error("dofs", format_args!("the table has `{}` twice", row.label));
                return None;
            }
            dofs.labels.push(row.label.clone());
            let row = if again || has_inner && is_unplaced(row, positions) { &coordinate(row) } else { row };
            dofs.to_file.push(units.to_file(row.label.dof));
            let (node, dof) = self.dof_of(row, positions, units, &mut nodes, &mut node_of)?;
            out.push(ExportedDof { node, ..dof });
        }
        Some((dofs, nodes, out))
    }

    /// A dof with its node, which is added where it is new.
    fn dof_of(
        &mut self,
        row: &DofRow,
        positions: &Positions,
        units: &Units,
        nodes: &mut Vec<ExportedNode>,
        node_of: &mut HashMap<String, usize>,
    ) -> Option<(usize, ExportedDof)> {
        let name = &row.label.node;
        let axis = match (&row.frame, row.label.dof) {
            (_, None) => [0.0; 3],
            (None, Some(dof)) => positions.get(name).and_then(|p| p.1).unwrap_or(GLOBAL)[dof.axis()],
            (Some(frame), Some(dof)) => {
                let Some(axes) = self.axes.get(frame) else {
                    let suggestion = did_you_mean(frame, self.axes.keys().map(String::as_str));
                    self.error("dofs", format_args!("the table names the frame `{frame}` at `{}`, which is not defined under `frames`{suggestion}", row.label));
                    return None;
                };
                axes[dof.axis()]
            }
        };
        if let Some(&node) = node_of.get(name) {
            if nodes[node].position.is_none() != row.label.dof.is_none() {
                self.error("dofs", format_args!("`{name}` is a node and a coordinate in one table"));
                return None;
            }
            return Some((node, ExportedDof { node, dof: row.label.dof, axis }));
        }
        let position = match row.label.dof {
            None => None,
            Some(_) => {
                let Some(at) = row.position.or_else(|| positions.get(name).map(|p| p.0)) else {
                    self.error("", format_args!("node `{name}` has no position: give the columns x, y, z in the table of dofs, or `nodes: FILE` (a CSV file with node, x, y, z, an input file with *NODE, a deck with GRID); say `inner: true` where it is an inner node of the other program"));
                    return None;
                };
                Some(at.map(|c| c * units.length))
            }
        };
        let node = nodes.len();
        node_of.insert(name.clone(), node);
        nodes.push(ExportedNode { name: name.clone(), position });
        Some((node, ExportedDof { node, dof: row.label.dof, axis }))
    }

    /// Where the rows, or the columns, of a matrix stand among the dofs.
    fn places(&mut self, key: &str, labels: &[Label], n: usize, dofs: &Dofs) -> Option<Vec<u32>> {
        if labels.is_empty() {
            if n != dofs.labels.len() {
                let table = counted(dofs.labels.len(), "row");
                self.error(key, format_args!("the matrix has {}, and the table of dofs {table}", counted(n, "row")));
                return None;
            }
            return Some((0..n as u32).collect());
        }
        let mut places = Vec::with_capacity(labels.len());
        for label in labels {
            let Some(&place) = dofs.index.get(label) else {
                self.error(key, format_args!("the matrix has a row `{label}` that is not in the table of dofs"));
                return None;
            };
            places.push(place as u32);
        }
        Some(places)
    }

    /// A matrix in SI, on the dofs of the table.
    ///
    /// * `scale` - SI value of the unit of its energy
    fn in_si(&mut self, picked: &Picked, key: &str, dofs: &Dofs, scale: f64) -> Result<Arc<Symmetric>, ()> {
        let matrix = picked.matrix();
        let places = self.places(key, &matrix.rows, matrix.n_rows, dofs).ok_or(())?;
        let symmetric = matrix.symmetric(picked.is_triangle).map_err(|e| self.error(key, e))?;
        let mut out = symmetric;
        out.n = dofs.labels.len();
        for e in &mut out.lower {
            let (row, column) = (places[e.row as usize], places[e.column as usize]);
            (e.row, e.column) = (row.max(column), row.min(column));
            e.value *= scale * (dofs.to_file[row as usize] * dofs.to_file[column as usize]);
        }
        if !places.is_sorted() {
            out.lower.sort_by_key(|e| (e.column, e.row));
        }
        if let Some(e) = out.lower.iter().find(|e| !e.value.is_finite()) {
            self.error(
                key,
                format_args!(
                    "the entry of `{}` and `{}` is not finite in SI",
                    dofs.labels[e.row as usize], dofs.labels[e.column as usize]
                ),
            );
            return Err(());
        }
        Ok(Arc::new(out))
    }

    /// The stiffness of a free part.
    fn freed(&mut self, k: Option<&Symmetric>, dofs: &[ExportedDof], nodes: &[ExportedNode]) -> Option<Arc<Symmetric>> {
        let freed = k.filter(|k| k.n <= free::MOST_DOFS).and_then(|k| free::freed(k, dofs, nodes));
        match freed {
            Some((k, change)) if change <= free::MOST_CHANGE => Some(Arc::new(k)),
            Some((_, change)) => {
                self.error("free", format_args!("it is held: entries would change by {change:.1e} of their scale, which is not rounding of numbers"));
                None
            }
            None => {
                self.error(
                    "free",
                    format_args!(
                        "it needs a stiffness without negative entries on its diagonal, of up to {} dofs",
                        free::MOST_DOFS
                    ),
                );
                None
            }
        }
    }

    fn recovery(
        &mut self,
        recovery: &super::spec::RecoverySpec,
        dofs: &Dofs,
        units: &Units,
        exported: &mut Exported,
    ) -> Option<()> {
        let picked = self.pick("recovery.matrix", &recovery.matrix)?;
        let contents = self.contents("recovery.dofs", &recovery.dofs)?;
        let positions = places_of(&contents);
        let matrix = picked.matrix();
        if matrix.n_rows != contents.dofs.len() {
            self.error(
                "recovery.matrix",
                format_args!(
                    "it has {}, and the table of dofs {}",
                    counted(matrix.n_rows, "row"),
                    counted(contents.dofs.len(), "row")
                ),
            );
            return None;
        }
        let columns = self.places("recovery.matrix", &matrix.columns, matrix.n_columns, dofs)?;
        let mut node_of: HashMap<String, usize> =
            exported.nodes.iter().enumerate().map(|(i, n)| (n.name.clone(), i)).collect();
        let known: HashSet<Label> = dofs.labels.iter().cloned().collect();
        let mut rows = Vec::new();
        for row in &contents.dofs {
            if row.label.dof.is_none() || known.contains(&row.label) {
                self.error(
                    "recovery.dofs",
                    format_args!("`{}` is a dof of the superelement itself, or no motion of a point", row.label),
                );
                return None;
            }
            let (_, dof) = self.dof_of(row, &positions, units, &mut exported.nodes, &mut node_of)?;
            rows.push((dof, Vec::new(), units.to_file(row.label.dof)));
        }
        for e in matrix.full() {
            let column = columns[e.column as usize] as usize;
            let row = &mut rows[e.row as usize];
            row.1.push((column, e.value * dofs.to_file[column] / row.2));
        }
        exported.recovered = rows.into_iter().map(|(dof, terms, _)| (dof, terms)).collect();
        Some(())
    }
}

/// Positions and directions of a file.
fn places_of(contents: &Contents) -> Positions {
    let axes: HashMap<&str, Axes> = contents.axes.iter().map(|(n, a)| (n.as_str(), *a)).collect();
    let place = |(name, at): &(String, [f64; 3])| (name.clone(), (*at, axes.get(name.as_str()).copied()));
    contents.positions.iter().map(place).collect()
}

fn unplaced(label: &Label) -> DofRow {
    DofRow { label: label.clone(), position: None, frame: None }
}

/// Positions of nodes by name, in the units of the files, and the directions of their dofs where those are not global ones.
type Positions = HashMap<String, ([f64; 3], Option<Axes>)>;

/// Directions as rows.
type Axes = [[f64; 3]; 3];

/// One matrix of a file.
struct Picked {
    contents: Arc<Contents>,
    place: usize,
    is_triangle: bool,
}

impl Picked {
    fn matrix(&self) -> &Matrix {
        &self.contents.matrices[self.place]
    }
}

/// Whether the files of all superelements were read; if not, a problem for each.
pub(super) fn check(spec: &ModelSpec, problems: &mut Vec<Problem>) {
    for (name, entry) in &spec.superelements {
        let path = child("superelements", name);
        let is_said = problems.iter().any(|p| p.severity == Severity::Error && p.path.starts_with(&path));
        if entry.loaded.0.is_none() && !is_said {
            problems.push(Problem::error(
                path,
                "its files were not read: a model with superelements is loaded from its file, or by `load_in`",
            ));
        }
    }
}
