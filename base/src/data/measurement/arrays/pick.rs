//! Which variables belong together, by names and sizes.

use super::names::{Says, says};
use super::roles::{Axis, Role, Roles, find};
use super::{MeasurementError, Variable};
use crate::data::convert::{ConvertError, Question};
use crate::data::npy;
use std::borrow::Cow;

/// Functions: indices of variables, and the axis of each kind among the axes that are longer than one.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Functions {
    pub(super) frequency: usize,
    pub(super) values: usize,
    pub(super) coherence: Option<usize>,
    pub(super) lines: usize,
    pub(super) responses: Option<usize>,
    pub(super) references: Option<usize>,
    /// Three components at each of the responses, which are points then.
    pub(super) components: Option<usize>,
    /// What was assumed of the axes.
    pub(super) notes: Vec<String>,
}

/// Where frequencies of modes come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Source {
    Frequencies(usize),
    Eigenvalues(usize),
}

impl Source {
    pub(super) fn variable(self) -> usize {
        match self {
            Self::Frequencies(i) | Self::Eigenvalues(i) => i,
        }
    }
}

/// Modes: indices of variables, and the axes of the shapes among those that are longer than one.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Modes {
    pub(super) source: Source,
    pub(super) shapes: usize,
    pub(super) damping: Option<usize>,
    pub(super) points: Option<usize>,
    /// None for one mode.
    pub(super) mode_axis: Option<usize>,
    pub(super) point_axis: usize,
    pub(super) component_axis: Option<usize>,
    pub(super) notes: Vec<String>,
}

/// What was recognised.
#[derive(Debug, Default)]
pub(super) struct Pick {
    pub(super) functions: Option<Functions>,
    pub(super) modes: Option<Modes>,
}

impl Pick {
    pub(super) fn new(list: &[Cow<'_, Variable>], roles: &Roles) -> Result<Self, MeasurementError> {
        let picker = Picker { list, roles, says: list.iter().map(|v| says(&v.name)).collect() };
        let modes = picker.modes()?;
        let functions = picker.functions(modes.as_ref())?;
        Ok(Self { functions, modes })
    }
}

struct Picker<'a> {
    list: &'a [Cow<'a, Variable>],
    roles: &'a Roles,
    says: Vec<Says>,
}

fn unusable(variable: &Variable, why: String) -> MeasurementError {
    ConvertError::Unusable { what: format!("variable {}", variable.label()), why }.into()
}

/// The one of several; none is none.
fn only<T>(mut list: Vec<T>, role: &str, name: impl Fn(&T) -> String) -> Result<Option<T>, MeasurementError> {
    if list.len() > 1 {
        let mut answers: Vec<String> = list.iter().map(name).collect();
        answers.dedup();
        answers.truncate(8);
        let text = format!("several variables may be the {role}");
        return Err(ConvertError::Questions(vec![Question { option: "variables", text, answers }]).into());
    }
    Ok(list.pop())
}

impl Picker<'_> {
    /// The variable that the user names for a role.
    fn stated(&self, role: Role) -> Result<Option<usize>, MeasurementError> {
        self.roles.get(role).map(|n| find(self.list, &n.name)).transpose()
    }

    /// The variables of a role: the one that is named, else those whose names say so.
    fn candidates(&self, role: Role, fits: impl Fn(Says) -> bool) -> Result<Vec<usize>, MeasurementError> {
        let stated = self.stated(role)?;
        let is_stated = |i: usize| self.roles.list.iter().any(|n| n.role != role && n.name == self.list[i].name);
        Ok(match stated {
            Some(i) => vec![i],
            None => (0..self.list.len()).filter(|i| fits(self.says[*i]) && !is_stated(*i)).collect(),
        })
    }

    /// A real vector with a number for each of `n`, whose name says so or that the user names.
    fn beside(&self, role: Role, n: usize, fits: impl Fn(Says) -> bool) -> Result<Option<usize>, MeasurementError> {
        let stated = self.stated(role)?;
        let has_length = |i: &usize| self.list[*i].vector().is_some_and(|v| v.len() == n);
        if let Some(i) = stated.filter(|i| !has_length(i)) {
            return Err(unusable(&self.list[i], format!("it is not a real vector of {n} values")));
        }
        let found: Vec<usize> = self.candidates(role, fits)?.into_iter().filter(has_length).collect();
        // What stands beside is left out where it is not clear.
        Ok(Some(found).filter(|f| f.len() == 1).map(|f| f[0]))
    }

    fn hertz(&self, i: usize) -> Option<f64> {
        match self.says[i] {
            Says::Frequency(hertz) => Some(hertz),
            _ => None,
        }
    }

    fn modes(&self) -> Result<Option<Modes>, MeasurementError> {
        let stated_shapes = self.stated(Role::Shapes)?;
        let shapes = self.candidates(Role::Shapes, |s| s == Says::Shapes)?;
        let mut sources: Vec<Source> = match self.stated(Role::Eigenvalues)? {
            Some(i) => vec![Source::Eigenvalues(i)],
            None => self
                .candidates(Role::Frequency, |s| matches!(s, Says::Frequency(_)))?
                .into_iter()
                .map(Source::Frequencies)
                .collect(),
        };
        if sources.is_empty() {
            // Poles say that they are; real eigenvalues may be many things.
            let poles = self.candidates(Role::Eigenvalues, |s| s == Says::Eigenvalues)?;
            sources.extend(poles.into_iter().filter(|i| self.list[*i].is_complex()).map(Source::Eigenvalues));
        }
        let mut found = Vec::new();
        for source in &sources {
            for shape in &shapes {
                found.extend(self.modes_of(*source, *shape)?);
            }
        }
        if found.is_empty() {
            return match (stated_shapes, sources.first()) {
                (Some(i), Some(source)) => {
                    let other = &self.list[source.variable()];
                    Err(unusable(&self.list[i], format!("no axis of it has the length of {}", other.label())))
                }
                (Some(i), None) => Err(unusable(
                    &self.list[i],
                    "the frequencies of its modes are not named: `frequency=NAME` or `eigenvalues=NAME`".to_string(),
                )),
                _ => Ok(None),
            };
        }
        // The same frequencies may be there in Hz and in rad/s.
        if found.iter().any(|m| self.hertz(m.source.variable()) == Some(1.0)) {
            found.retain(|m| self.hertz(m.source.variable()) == Some(1.0));
        }
        let name = |m: &Modes| {
            format!("frequency={},shapes={}", self.list[m.source.variable()].name, self.list[m.shapes].name)
        };
        let Some(mut modes) = only(found, "modes", name)? else { return Ok(None) };
        let axes = self.list[modes.shapes].axes();
        let n_modes = modes.mode_axis.map_or(1, |a| axes[a]);
        modes.damping = self.beside(Role::Damping, n_modes, |s| matches!(s, Says::Damping(_)))?;
        modes.points = self.beside(Role::Points, axes[modes.point_axis], |s| s == Says::Points)?;
        Ok(Some(modes))
    }

    /// Modes of these two variables, if their sizes fit.
    fn modes_of(&self, source: Source, shapes: usize) -> Result<Option<Modes>, MeasurementError> {
        let from = &self.list[source.variable()];
        let n = match (source, &from.array.values) {
            (Source::Frequencies(_), _) => from.vector().map_or(0, <[f64]>::len),
            (Source::Eigenvalues(_), npy::Values::Real(v)) if from.axes().len() <= 1 => v.len(),
            (Source::Eigenvalues(_), npy::Values::Complex(v)) if from.axes().len() <= 1 => v.len(),
            _ => return Ok(None),
        };
        if n == 0 || source.variable() == shapes {
            return Ok(None);
        }
        let variable = &self.list[shapes];
        let axes = variable.axes();
        let stated = self.roles.get(Role::Shapes).map_or(&[][..], |s| &s.axes);
        let at = |axis: Axis| stated.iter().position(|a| *a == axis).filter(|_| stated.len() == axes.len());
        let mut modes = Modes {
            source,
            shapes,
            damping: None,
            points: None,
            mode_axis: None,
            point_axis: 0,
            component_axis: None,
            notes: Vec::new(),
        };
        let with: Vec<usize> = (0..axes.len()).filter(|a| axes[*a] == n).collect();
        match (axes.len(), n) {
            (1, 1) => {}
            (2, 1) if axes.contains(&3) => {
                // One mode with three components a point.
                let component = axes.iter().rposition(|n| *n == 3).unwrap_or(1);
                (modes.component_axis, modes.point_axis) = (Some(component), 1 - component);
            }
            (2, _) => {
                let mode_axis = match (at(Axis::Modes), at(Axis::Points), with.as_slice()) {
                    (Some(axis), ..) => axis,
                    (_, Some(axis), _) => 1 - axis,
                    (.., [axis]) => *axis,
                    (.., [_, axis]) => {
                        modes.notes.push(format!(
                            "`{}` has as many points as modes: its columns are taken for modes; `--variables shapes={}:modes-points` says otherwise",
                            variable.name.escape_debug(), variable.name.escape_debug()
                        ));
                        *axis
                    }
                    _ => return Ok(None),
                };
                if axes[mode_axis] != n {
                    return Ok(None);
                }
                (modes.mode_axis, modes.point_axis) = (Some(mode_axis), 1 - mode_axis);
            }
            (3, _) => {
                // A mode axis of the right length, another axis of three components.
                let fits = |mode: usize, component: usize| mode != component && axes[mode] == n && axes[component] == 3;
                let mut ways: Vec<(usize, usize)> =
                    (0..3).flat_map(|m| (0..3).map(move |c| (m, c))).filter(|(m, c)| fits(*m, *c)).collect();
                ways.retain(|(m, c)| {
                    [(Axis::Modes, *m), (Axis::Components, *c), (Axis::Points, 3 - m - c)]
                        .iter()
                        .all(|(axis, place)| at(*axis).is_none_or(|stated| stated == *place))
                });
                let is_one_mode_axis = ways.iter().all(|w| w.0 == ways[0].0);
                if ways.len() > 1 && is_one_mode_axis {
                    // The documented order.
                    ways.retain(|(m, c)| *c > 3 - m - c);
                    let name = variable.name.escape_debug();
                    modes.notes.push(format!(
                        "`{name}` has three points: its components x, y and z are taken to run along the later axis; `--variables shapes={name}:AXIS-AXIS-AXIS` of modes, points, components says otherwise"
                    ));
                } else if ways.len() > 1 {
                    let orders = ways.iter().map(|(m, c)| {
                        let word = |axis: usize| match axis {
                            a if a == *m => "modes",
                            a if a == *c => "components",
                            _ => "points",
                        };
                        let name = variable.name.escape_debug();
                        format!("shapes={name}:{}-{}-{}", word(0), word(1), word(2))
                    });
                    let text = format!(
                        "which axis of {} are the modes, and which the components x, y and z?",
                        variable.label()
                    );
                    let question = Question { option: "variables", text, answers: orders.collect() };
                    return Err(ConvertError::Questions(vec![question]).into());
                }
                let [(mode_axis, component), ..] = ways[..] else { return Ok(None) };
                modes.mode_axis = Some(mode_axis);
                modes.component_axis = Some(component);
                modes.point_axis = 3 - mode_axis - component;
            }
            _ => return Ok(None),
        }
        Ok(Some(modes))
    }

    fn functions(&self, modes: Option<&Modes>) -> Result<Option<Functions>, MeasurementError> {
        let stated = self.stated(Role::Functions)?;
        let values: Vec<usize> = match stated {
            Some(i) if !self.list[i].is_complex() => {
                let why = "functions are complex; name a real and an imaginary part as `functions=REAL+IMAGINARY`, an amplitude and a phase as \
                           `functions=AMPLITUDE+PHASE`";
                return Err(unusable(&self.list[i], why.to_string()));
            }
            Some(i) => vec![i],
            // The shapes and poles that are taken for modes are none.
            None => (0..self.list.len())
                .filter(|i| {
                    self.list[*i].is_complex()
                        && !matches!(self.says[*i], Says::Shapes | Says::Eigenvalues | Says::Damping(_))
                })
                .filter(|i| !self.roles.list.iter().any(|n| n.name == self.list[*i].name))
                .collect(),
        };
        let is_frequency = |s: Says| matches!(s, Says::Frequency(_));
        let mut frequencies = self.candidates(Role::Frequency, is_frequency)?;
        let fits = |f: &usize, h: &usize| {
            let n = self.list[*f].vector().map_or(0, <[f64]>::len);
            f != h && n > 1 && self.list[*h].axes().len() <= 3 && self.list[*h].axes().contains(&n)
        };
        let pairs = |frequencies: &[usize]| -> Vec<(usize, usize)> {
            let of = |f: &usize| values.iter().filter(|h| fits(f, h)).map(|h| (*f, *h)).collect::<Vec<_>>();
            frequencies.iter().flat_map(of).collect()
        };
        let mut found = pairs(&frequencies);
        if found.is_empty() && self.roles.get(Role::Frequency).is_none() && modes.is_none() {
            // A vector that ascends beside functions of its length can be nothing else; its unit is asked for.
            let ascends = |v: &[f64]| v.iter().all(|x| x.is_finite() && *x >= 0.0) && v.windows(2).all(|w| w[0] < w[1]);
            frequencies = (0..self.list.len())
                .filter(|i| self.says[*i] == Says::Nothing && self.list[*i].vector().is_some_and(ascends))
                .collect();
            found = pairs(&frequencies);
        }
        let keep = |found: &mut Vec<(usize, usize)>, holds: &dyn Fn(&(usize, usize)) -> bool| {
            if found.iter().any(holds) {
                found.retain(holds);
            }
        };
        if let Some(modes) = modes {
            keep(&mut found, &|p| p.0 != modes.source.variable());
        }
        keep(&mut found, &|p| self.says[p.1] == Says::Functions);
        keep(&mut found, &|p| self.list[p.1].axes().first() == self.list[p.0].vector().map(<[f64]>::len).as_ref());
        keep(&mut found, &|p| self.hertz(p.0) == Some(1.0));
        if found.is_empty() {
            return match (stated, frequencies.first()) {
                (Some(i), Some(f)) => {
                    Err(unusable(&self.list[i], format!("no axis of it has the length of {}", self.list[*f].label())))
                }
                (Some(i), None) => {
                    Err(unusable(&self.list[i], "its frequencies are not named: `frequency=NAME`".to_string()))
                }
                _ => Ok(None),
            };
        }
        let name = |p: &(usize, usize)| format!("frequency={},functions={}", self.list[p.0].name, self.list[p.1].name);
        let Some((frequency, values)) = only(found, "functions", name)? else { return Ok(None) };
        self.axes_of(frequency, values).map(Some)
    }

    /// Which axis of functions is which.
    fn axes_of(&self, frequency: usize, values: usize) -> Result<Functions, MeasurementError> {
        let variable = &self.list[values];
        let axes = variable.axes();
        let n = self.list[frequency].vector().map_or(0, <[f64]>::len);
        let stated = self.roles.get(Role::Functions).map_or(&[][..], |s| &s.axes);
        let mut notes = Vec::new();
        let wrong = |why: &str| unusable(variable, why.to_string());
        // Axes as stated: of all, or of those beside the lines.
        let with: Vec<usize> = (0..axes.len()).filter(|a| axes[*a] == n).collect();
        let lines = match stated.iter().position(|a| *a == Axis::Lines) {
            Some(at) if stated.len() == axes.len() => at,
            Some(_) => return Err(wrong("the axes that are stated are not as many as it has")),
            None => with[0],
        };
        if axes[lines] != n {
            return Err(wrong(&format!("its lines are not as many as the {n} frequencies")));
        }
        let name = variable.name.escape_debug();
        if with.len() > 1 && !stated.contains(&Axis::Lines) {
            notes.push(format!(
                "`{name}` has as many lines as channels: its lines are taken to run along axis {}; `--variables functions={name}:AXIS-AXIS` says otherwise",
                lines + 1
            ));
        }
        let rest: Vec<usize> = (0..axes.len()).filter(|a| *a != lines).collect();
        let named: Vec<Axis> = stated.iter().copied().filter(|a| *a != Axis::Lines).collect();
        let is_double = named.contains(&Axis::Responses) && named.contains(&Axis::Points);
        if named.contains(&Axis::Modes) || is_double || (!named.is_empty() && named.len() != rest.len()) {
            return Err(wrong(
                "its axes are `lines`, `responses` and `references`, or `lines`, `points` and `components`, each that is longer than one",
            ));
        }
        let components = named.iter().position(|a| *a == Axis::Components).map(|k| rest[k]);
        if let Some(axis) = components.filter(|a| axes[*a] != 3) {
            return Err(wrong(&format!(
                "its axis of components has length {}; components are three, along x, y and z",
                axes[axis]
            )));
        }
        let (responses, references) = match (rest.as_slice(), named.as_slice()) {
            ([], _) | ([_], [Axis::Components]) => (None, None),
            ([a], [Axis::References]) => (None, Some(*a)),
            ([a, b], [Axis::Components, other] | [other, Axis::Components]) => {
                let own = if named[0] == Axis::Components { *b } else { *a };
                if *other == Axis::References { (None, Some(own)) } else { (Some(own), None) }
            }
            ([a], _) => (Some(*a), None),
            ([a, b], [Axis::Responses | Axis::Points, _]) => (Some(*a), Some(*b)),
            ([a, b], [Axis::References, _]) => (Some(*b), Some(*a)),
            // The documented order of arrays of NumPy; MATLAB's own functions have the other.
            ([a, b], _) if !variable.is_matlab && lines == 0 => {
                notes.push(format!(
                    "`{name}` is taken for (lines x references x responses), {} references and {} responses; `--variables functions={name}:lines-responses-references` says otherwise",
                    axes[*a], axes[*b]
                ));
                (Some(*b), Some(*a))
            }
            _ => {
                let orders = if lines == 0 {
                    ["lines-responses-references", "lines-references-responses"]
                } else {
                    ["responses-references", "references-responses"]
                };
                let text = format!("which axis of {} are the responses, and which the references?", variable.label());
                let mut answers = orders.map(|o| format!("functions={name}:{o}")).to_vec();
                for (k, words) in [(0, "components-points"), (1, "points-components")] {
                    if axes[rest[k]] == 3 && rest.len() == 2 {
                        answers.push(format!("functions={name}:{}{words}", if lines == 0 { "lines-" } else { "" }));
                    }
                }
                return Err(ConvertError::Questions(vec![Question { option: "variables", text, answers }]).into());
            }
        };
        let coherence = self.candidates(Role::Coherence, |s| s == Says::Coherence)?;
        let is_beside = |i: &usize| !self.list[*i].is_complex() && self.list[*i].axes() == axes;
        let coherence = coherence.into_iter().find(is_beside);
        Ok(Functions { frequency, values, coherence, lines, responses, references, components, notes })
    }
}
