//! From a program and its template to the entry that its matrices make: what is run, at which values, and what is read of it.
//!
//! With n powers of a parameter the matrices at n + 1 of its values tell the parts that go with each power; the first value of every parameter is
//! that of the superelement's own matrices. One run more, with all parameters away from these values at once, checks that the parts add up:
//!
//! ```text
//! runs = 1 + Σ_parameters n + 1
//! ```

use super::Reading;
use crate::catalogue::{counted, did_you_mean};
use crate::matrices::{MARKER, Process};
use crate::model::spec::{
    CheckSpec, DependenceSpec, ExportSpec, KnownSolver, MatrixSpec, Named, ParameterSpec, SolverSpec, SuperelementSpec,
    TermSpec, WritesSpec, WrittenSpec,
};
use crate::units::{Scalar, Unit, four_digits};
use std::sync::Arc;
use std::time::Duration;

/// Folder beside the model file that keeps what programs have written.
pub const SOLVER_FOLDER: &str = ".retune-solver";
/// More runs than these are not a few.
const MOST_RUNS: usize = 40;
/// After this a run is stopped.
const TIME_LIMIT: Duration = Duration::from_secs(3600);
/// Where between the first and the last value of every parameter the run stands that checks: at no value of the others.
const CHECKED_AT: f64 = 0.382;

/// A run of a program that a superelement asks for.
#[derive(Debug, Clone, PartialEq)]
pub struct SolverRun {
    /// The superelement.
    pub superelement: String,
    /// Parameters by name, SI.
    pub values: Vec<(String, f64)>,
    /// The same as a sentence has them, in the units of the template.
    pub told: String,
    /// What is run.
    pub process: Process,
}

impl SolverRun {
    /// Folder in which its files are kept, relative to that of the model file.
    pub fn folder(&self) -> String {
        format!("{SOLVER_FOLDER}/{}", self.process.key())
    }
}

/// A parameter of a program.
struct Dependence<'a> {
    name: &'a str,
    powers: Vec<u32>,
    /// One more than powers.
    values: Vec<f64>,
}

/// What a parameter is run for.
struct OfParameter {
    name: String,
    powers: Vec<u32>,
    /// Values other than that of the superelement's own matrices.
    others: Vec<(f64, SolverRun)>,
}

/// All runs of a superelement: its own, those of every parameter, and the one that checks.
pub(super) struct Runs {
    own: SolverRun,
    of_parameters: Vec<OfParameter>,
    check: Option<SolverRun>,
    written: WrittenSpec,
}

impl Runs {
    pub(super) fn all(&self) -> impl Iterator<Item = &SolverRun> {
        let others = self.of_parameters.iter().flat_map(|p| p.others.iter().map(|(_, run)| run));
        std::iter::once(&self.own).chain(others).chain(&self.check)
    }
}

impl Reading<'_, '_> {
    /// The entry that an entry with a program means, once all of its runs are there.
    pub(super) fn of_solver(
        &mut self,
        name: &str,
        entry: &SuperelementSpec,
        solver: &SolverSpec,
    ) -> Option<SuperelementSpec> {
        let runs = self.runs(name, entry, solver)?;
        let missing = runs.all().filter(|run| self.files.bytes(&format!("{}/{MARKER}", run.folder())).is_err()).count();
        if missing > 0 {
            let (n, command) = (runs.all().count(), runs.own.process.command().join(" "));
            self.error(
                "solver",
                format_args!(
                    "{missing} of {} of `{command}` are missing: `retune prepare MODEL` makes them",
                    counted(n, "run")
                ),
            );
            return None;
        }
        let in_folder = |run: &SolverRun, file: &Option<MatrixSpec>| {
            file.clone().map(|m| MatrixSpec { file: format!("{}/{}", run.folder(), m.file), ..m })
        };
        let table = |given: &Option<String>, written: &Option<String>| {
            given.clone().or_else(|| written.as_ref().map(|f| format!("{}/{f}", runs.own.folder())))
        };
        let WrittenSpec { k, m, c, dofs, nodes } = &runs.written;
        let mut terms = Named::new();
        for OfParameter { name: parameter, powers, others } in &runs.of_parameters {
            let first = runs.own.values.iter().find(|v| v.0 == *parameter).map(|v| Scalar::constant(v.1));
            let exports = others.iter().map(|(value, run)| ExportSpec {
                at: Scalar::constant(*value),
                k: in_folder(run, k),
                m: in_folder(run, m),
                c: in_folder(run, c),
            });
            let term =
                TermSpec { powers: powers.clone(), at: first, exports: exports.collect(), ..TermSpec::default() };
            terms.insert(parameter.clone(), term);
        }
        let checks = runs.check.iter().map(|run| CheckSpec {
            at: run.values.iter().map(|(n, v)| (n.clone(), Scalar::constant(*v))).collect(),
            k: in_folder(run, k),
            m: in_folder(run, m),
            c: in_folder(run, c),
        });
        Some(SuperelementSpec {
            k: in_folder(&runs.own, k),
            m: in_folder(&runs.own, m),
            c: in_folder(&runs.own, c),
            dofs: table(&entry.dofs, dofs),
            nodes: table(&entry.nodes, nodes),
            terms,
            checks: checks.collect(),
            solver: None,
            ..entry.clone()
        })
    }

    /// What the program of an entry is run for.
    pub(super) fn runs(&mut self, name: &str, entry: &SuperelementSpec, solver: &SolverSpec) -> Option<Runs> {
        let given = [
            ("k", entry.k.is_some()),
            ("m", entry.m.is_some()),
            ("c", entry.c.is_some()),
            ("terms", !entry.terms.is_empty()),
            ("checks", !entry.checks.is_empty()),
        ];
        if let Some((key, _)) = given.iter().find(|(_, given)| *given) {
            self.error(key, format_args!("`{key}` is what `solver` computes: give one of the two"));
            return None;
        }
        let template = self.template(solver)?;
        let file = file_name(solver.template.strip_suffix(".tpl").unwrap_or(&solver.template)).to_string();
        let job = file.rsplit_once('.').map_or(file.as_str(), |(stem, _)| stem).to_string();
        let others = self.other_files(solver, &file)?;
        let command: Vec<String> =
            solver.run.words().iter().map(|w| w.replace("{job}", &job).replace("{file}", &file)).collect();
        if command.is_empty() {
            self.error("solver.run", "a program is expected, such as `ccx -i {job}`");
            return None;
        }
        let written = written(&solver.writes, &job, &file);
        if written.k.is_none() && written.m.is_none() {
            self.error("solver.writes", "the program must write a stiffness matrix `k` or a mass matrix `m`");
            return None;
        }
        let time_limit = self.time_limit(solver)?;
        let outputs: Vec<String> = [&written.k, &written.m, &written.c]
            .into_iter()
            .filter_map(|m| m.as_ref().map(|m| m.file.clone()))
            .chain([&written.dofs, &written.nodes].into_iter().flatten().cloned())
            .collect();
        let dependences = self.dependences(solver, &template)?;
        let make = |values: Vec<(String, f64)>| SolverRun {
            superelement: name.to_string(),
            told: template.told(&values),
            process: Process::new(
                command.clone(),
                std::iter::once((file.clone(), template.filled(&values).into_bytes().into()))
                    .chain(others.iter().cloned())
                    .collect(),
                outputs.clone(),
                time_limit,
            ),
            values,
        };
        let first: Vec<(String, f64)> = dependences.iter().map(|d| (d.name.to_string(), d.values[0])).collect();
        let with = |i: usize, value: f64| {
            let mut values = first.clone();
            values[i].1 = value;
            make(values)
        };
        let of_parameters = dependences.iter().enumerate().map(|(i, d)| {
            let others = d.values[1..].iter().map(|&v| (v, with(i, v))).collect();
            OfParameter { name: d.name.to_string(), powers: d.powers.clone(), others }
        });
        let between = |d: &Dependence<'_>| {
            let (low, high) = (d.values[0], d.values[d.values.len() - 1]);
            (d.name.to_string(), low + CHECKED_AT * (high - low))
        };
        let check = (!dependences.is_empty()).then(|| make(dependences.iter().map(between).collect()));
        let runs = Runs { own: make(first.clone()), of_parameters: of_parameters.collect(), check, written };
        let n = runs.all().count();
        if n > MOST_RUNS {
            self.error(
                "solver.parameters",
                format_args!("{n} runs are needed, and at most {MOST_RUNS} are made: give fewer parameters or powers"),
            );
            return None;
        }
        Some(runs)
    }

    fn template(&mut self, solver: &SolverSpec) -> Option<Template> {
        let read = self.files.bytes(&solver.template);
        let text =
            read.map_err(|e| e.to_string()).and_then(|bytes| String::from_utf8(bytes).map_err(|e| e.to_string()));
        let text = match text {
            Ok(text) => text,
            Err(why) => {
                self.error("solver.template", format_args!("`{}` cannot be read: {why}", solver.template));
                return None;
            }
        };
        let mut out = Template::default();
        let mut rest = text.as_str();
        let mut line = 1;
        while let Some(at) = rest.find("{{") {
            let (before, behind) = rest.split_at(at);
            line += before.matches('\n').count();
            out.pieces.push(Piece::Text(before.to_string()));
            let slot = behind[2..].find("}}").map(|end| &behind[2..2 + end]).filter(|slot| !slot.contains(['\n', '{']));
            let Some(slot) = slot else {
                out.pieces.push(Piece::Text("{{".into()));
                rest = &behind[2..];
                continue;
            };
            rest = &behind[slot.len() + 4..];
            let (name, unit) = slot.split_once(':').map_or((slot.trim(), None), |(n, u)| (n.trim(), Some(u.trim())));
            match slot_of(&self.spec.parameters, name, unit) {
                Ok(factor) => {
                    let unit = unit.unwrap_or_default().to_string();
                    out.pieces.push(Piece::Parameter { name: name.to_string(), factor, unit });
                }
                Err(why) => {
                    self.error("solver.template", format_args!("`{}`, line {line}: {why}", solver.template));
                    return None;
                }
            }
        }
        out.pieces.push(Piece::Text(rest.to_string()));
        Some(out)
    }

    fn other_files(&mut self, solver: &SolverSpec, input: &str) -> Option<Vec<(String, Arc<[u8]>)>> {
        let mut out = Vec::new();
        for (i, file) in solver.files.iter().enumerate() {
            let key = format!("solver.files[{i}]");
            let is_inside =
                !file.starts_with('/') && file.split(['/', '\\']).all(|part| part != ".." && !part.contains(':'));
            if !is_inside || file == input {
                self.error(
                    &key,
                    format_args!(
                        "`{file}` must stand in the folder of the model file or below, beside the input file `{input}`"
                    ),
                );
                return None;
            }
            match self.files.bytes(file) {
                Ok(bytes) => out.push((file.clone(), bytes.into())),
                Err(why) => {
                    self.error(&key, format_args!("`{file}` cannot be read: {why}"));
                    return None;
                }
            }
        }
        Some(out)
    }

    fn time_limit(&mut self, solver: &SolverSpec) -> Option<Duration> {
        let Some(limit) = &solver.time_limit else { return Some(TIME_LIMIT) };
        let seconds = limit.constant_in("s").map_err(|e| e.to_string());
        let duration = seconds.and_then(|s| Duration::try_from_secs_f64(s).map_err(|e| e.to_string()));
        match duration {
            Ok(duration) if !duration.is_zero() => Some(duration),
            Ok(_) => {
                self.error("solver.time_limit", "a time above zero is expected, such as `10 min`");
                None
            }
            Err(why) => {
                self.error("solver.time_limit", why);
                None
            }
        }
    }

    fn dependences<'t>(&mut self, solver: &SolverSpec, template: &'t Template) -> Option<Vec<Dependence<'t>>> {
        let names = template.parameters();
        if let Some(stray) = solver.parameters.keys().find(|name| !names.contains(&name.as_str())) {
            let suggestion = did_you_mean(stray, names.iter().copied());
            self.error(
                &format!("solver.parameters.{stray}"),
                format_args!("`{}` has no `{{{{{stray}}}}}`{suggestion}", solver.template),
            );
            return None;
        }
        let none = DependenceSpec::default();
        let mut out = Vec::new();
        for name in names {
            let said = solver.parameters.get(name).unwrap_or(&none);
            let key = format!("solver.parameters.{name}");
            let powers = if said.powers.is_empty() { vec![1] } else { said.powers.clone() };
            let values = match self.values(name, said, powers.len() + 1) {
                Ok(values) => values,
                Err(why) => {
                    self.error(&key, why);
                    return None;
                }
            };
            out.push(Dependence { name, powers, values });
        }
        Some(out)
    }

    /// Where the program runs.
    fn values(&self, name: &str, said: &DependenceSpec, n: usize) -> Result<Vec<f64>, String> {
        let parameter = &self.spec.parameters[name];
        let values: Vec<f64> = if said.values.is_empty() {
            let Some([low, high]) = &parameter.bounds else {
                return Err(format!("`{name}` has no bounds: give the values to run at, `values: [60 GPa, 80 GPa]`"));
            };
            let (low, high) = (number(low)?, number(high)?);
            (0..n).map(|k| low + (high - low) * k as f64 / (n - 1) as f64).collect()
        } else {
            said.values.iter().map(number).collect::<Result<_, _>>()?
        };
        if values.len() != n {
            return Err(format!("{} needs {n} values, and {} are given", counted(n - 1, "power"), values.len()));
        }
        match (0..n).find(|&i| !values[i].is_finite() || values[..i].contains(&values[i])) {
            Some(_) => Err("the values must be finite and differ".into()),
            None => Ok(values),
        }
    }
}

/// A number without parameters, SI.
fn number(scalar: &Scalar) -> Result<f64, String> {
    match scalar.parameters().next() {
        Some(_) => Err(format!("`{}` must be a number", scalar.text())),
        None => Ok(scalar.terms().iter().map(|t| t.factor).sum()),
    }
}

/// The SI value of the unit in which a parameter stands in a template.
fn slot_of(parameters: &Named<ParameterSpec>, name: &str, unit: Option<&str>) -> Result<f64, String> {
    let Some(parameter) = parameters.get(name) else {
        let suggestion = did_you_mean(name, parameters.keys().map(String::as_str));
        return Err(format!("`{{{{{name}}}}}` is not a parameter of the model{suggestion}"));
    };
    let dimension = parameter.value.terms().iter().find_map(|t| t.dimension);
    match (unit, dimension) {
        (None, None) => Ok(1.0),
        (None, Some(_)) => Err(format!("say in which unit the program reads `{name}`: `{{{{{name}:MPa}}}}`")),
        (Some(text), own) => {
            let unit = Unit::parse(text).map_err(|e| e.to_string())?;
            if own.is_some_and(|own| own != unit.dimension) {
                return Err(format!("`{text}` is not a unit of `{name}`, which is `{}`", parameter.value.text()));
            }
            Ok(unit.factor)
        }
    }
}

fn file_name(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

/// The files that a program writes, by name.
fn written(writes: &WritesSpec, job: &str, file: &str) -> WrittenSpec {
    let matrix = |ending: &str| Some(MatrixSpec { file: format!("{job}{ending}"), ..MatrixSpec::default() });
    match writes {
        WritesSpec::Known(KnownSolver::Calculix) => WrittenSpec {
            k: matrix(".sti"),
            m: matrix(".mas"),
            c: None,
            dofs: Some(format!("{job}.dof")),
            nodes: Some(file.to_string()),
        },
        WritesSpec::Files(files) => {
            let named = |name: &String| name.replace("{job}", job).replace("{file}", file);
            let of = |m: &Option<MatrixSpec>| m.clone().map(|m| MatrixSpec { file: named(&m.file), ..m });
            WrittenSpec {
                k: of(&files.k),
                m: of(&files.m),
                c: of(&files.c),
                dofs: files.dofs.as_ref().map(named),
                nodes: files.nodes.as_ref().map(named),
            }
        }
    }
}

/// An input file with slots.
#[derive(Debug, Default)]
struct Template {
    pieces: Vec<Piece>,
}

#[derive(Debug)]
enum Piece {
    Text(String),
    Parameter { name: String, factor: f64, unit: String },
}

impl Template {
    /// The parameters, each once, in the order of the file.
    fn parameters(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for piece in &self.pieces {
            if let Piece::Parameter { name, .. } = piece
                && !names.contains(&name.as_str())
            {
                names.push(name);
            }
        }
        names
    }

    /// Values as a sentence has them.
    fn told(&self, values: &[(String, f64)]) -> String {
        let one = |(name, value): &(String, f64)| {
            let slot = self.pieces.iter().find_map(|p| match p {
                Piece::Parameter { name: own, factor, unit } if own == name => Some((factor, unit)),
                _ => None,
            });
            let (factor, unit) = slot.map_or((1.0, ""), |(f, u)| (*f, u));
            format!("{name} = {} {unit}", four_digits(value / factor)).trim_end().to_string()
        };
        values.iter().map(one).collect::<Vec<_>>().join(", ")
    }

    fn filled(&self, values: &[(String, f64)]) -> String {
        let mut out = String::new();
        for piece in &self.pieces {
            match piece {
                Piece::Text(text) => out.push_str(text),
                Piece::Parameter { name, factor, .. } => {
                    let value = values.iter().find(|v| v.0 == *name).map_or(f64::NAN, |v| v.1);
                    out.push_str(&digits(value / factor));
                }
            }
        }
        out
    }
}

/// Thirteen digits, in at most twenty characters, which is what CalculiX reads: `7.0e4`.
fn digits(value: f64) -> String {
    let text = format!("{value:.12e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let mantissa = mantissa.trim_end_matches('0');
    let point = if mantissa.ends_with('.') { "0" } else { "" };
    format!("{mantissa}{point}e{exponent}")
}

#[cfg(test)]
mod tests {
    use super::digits;

    #[test]
    fn numbers_in_templates_are_short_enough_for_fixed_fields() {
        assert_eq!([digits(7e4), digits(-0.5), digits(0.0)], ["7.0e4", "-5.0e-1", "0.0e0"]);
        let longest = digits(-f64::MIN_POSITIVE / 3.0 * 2.0);
        assert!(longest.len() <= 20 && digits(1.0 / 3.0) == "3.333333333333e-1", "{longest}");
    }
}
