//! Functions of universal files to frequency response functions.

use super::ConvertError;
use super::ends::{COHERENCE, EXCITATION_FORCE, End, FREQUENCY, FRF, Naming, REACTION_FORCE, quantity_of};
use super::frame::PlacedNode;
use super::frequency::{AxisNotes, hertz, points_hz};
use super::geometry::placed_nodes;
use super::grid::{GridOf, check, common};
use super::options::{Duplicates, FrfOptions};
use super::spectra::spectrum;
use super::units::{Question, UnitSystem, UnitsFrom, agreed, force_unit, note, ratio_unit, response_unit, units_at};
use crate::catalogue::{Choice, counted};
use crate::data::uff::{Dataset, Function, Level, Note, Ordinate, UniversalFile};
use crate::data::{Channel, FrfQuantity, FrfSet, Point, Spectrum};
use retune_linalg::Complex;
use std::collections::{BTreeMap, BTreeSet};

/// What universal files hold in functions.
#[derive(Debug, Clone, PartialEq)]
pub struct FrfImport {
    /// Frequency response functions, with their coherences.
    pub frfs: FrfSet,
    /// Auto, cross and other spectra.
    pub spectra: Vec<Spectrum>,
    /// What was assumed.
    pub notes: Vec<Note>,
}

fn title(f: &Function, naming: Naming) -> String {
    format!("{} / {}", End::of(&f.response, naming).title(), End::of(&f.reference, naming).title())
}

/// A function with what it means.
struct Measured<'a> {
    function: &'a Function,
    response: End,
    reference: End,
    /// SI value of one.
    scale: f64,
    /// Hz in one of its abscissa.
    hertz: f64,
}

/// Reads the frequency response functions, coherences and spectra of universal files.
///
/// * `files` - files that share labels of nodes; each with its own units
///
/// ```text
/// H_SI = H_file (unit of the response) / (unit of the force)
/// ```
///
/// Functions are grouped by point and direction of reference and response, sorted by label; the frequency lines are
/// those that all have. Directions are turned into global axes by the nodes' displacement systems where the files
/// define the nodes, and count as global otherwise. A pair that was not measured is NaN.
///
/// # Errors
/// [`ConvertError::Questions`] lists everything the user must state; others as they say.
pub fn frfs(files: &[&UniversalFile], options: &FrfOptions) -> Result<FrfImport, ConvertError> {
    let mut notes = Vec::new();
    let functions: Vec<(&UniversalFile, usize, &Function)> = files
        .iter()
        .flat_map(|file| {
            file.datasets.iter().enumerate().filter_map(|(i, d)| match d {
                Dataset::Function(f) => Some((*file, i, f.as_ref())),
                _ => None,
            })
        })
        .collect();
    let mut questions: Vec<Question> = Vec::new();
    let mut ask = |question: Question| {
        if !questions.contains(&question) {
            questions.push(question);
        }
    };
    let of_type = |t: i64| functions.iter().filter(move |(.., f)| f.function_type == t);

    let naming = Naming::of(functions.iter().map(|(.., f)| *f).filter(|f| matches!(f.function_type, FRF | COHERENCE)));
    if naming == Naming::ComponentAndNumber {
        let seen = "one number under several names of components";
        notes.push(note(Level::Info, 58, seen, "points are called by both, `component.number`"));
    }
    let mut stated: Vec<(&UniversalFile, usize, &Function, Option<FrfQuantity>)> =
        of_type(FRF).map(|(file, i, f)| (*file, *i, *f, stated_quantity(f))).collect();
    let kinds: BTreeSet<i32> = stated.iter().filter_map(|(.., q)| q.map(FrfQuantity::order)).collect();
    if let (Some(wanted), Some((.., f, Some(own)))) = (options.quantity, stated.first())
        && stated.iter().all(|(.., q)| q.is_some_and(|q| q != wanted))
    {
        if !matches!(options.units, UnitsFrom::System(_)) {
            return Err(ConvertError::Contradiction {
                option: "quantity",
                wanted: wanted.word().to_owned(),
                said: format!("{} (data type {}{})", own.word(), f.axes[1].data_type, labelled(&f.axes[1].units)),
                remedy: format!(
                    "leave the option out, or, where the file is wrong, state the units too: `--units SI --quantity {}`",
                    wanted.word()
                ),
            });
        }
        let seen = format!("functions that say they are {}", kinds_in_words(&kinds));
        notes.push(note(Level::Warning, 58, seen, format!("they are read as {}, as the options say", wanted.word())));
        for s in &mut stated {
            s.3 = None;
        }
    }
    if options.quantity.is_none() && (kinds.len() > 1 || stated.iter().any(|(.., q)| q.is_none())) {
        let text = if kinds.len() > 1 {
            "the functions are of several quantities"
        } else {
            "functions do not say their quantity"
        };
        ask(Question {
            option: "quantity",
            text: text.to_owned(),
            answers: FrfQuantity::ALL.iter().map(|(_, word, _)| (*word).to_string()).collect(),
        });
    }
    let quantity =
        options.quantity.or_else(|| stated.iter().find_map(|(.., q)| *q)).unwrap_or(FrfQuantity::Accelerance);

    let mut axis_notes = AxisNotes::default();
    let mut overruled: BTreeSet<(String, String)> = BTreeSet::new();
    let (mut left_out, mut rotations) = (0, 0);
    let mut measured: BTreeMap<(End, End), Measured<'_>> = BTreeMap::new();
    for (file, i, f, own) in stated {
        if own.is_some_and(|q| q != quantity) {
            left_out += 1;
            continue;
        }
        if f.response.direction.abs() > 3 || f.reference.direction.abs() > 3 {
            rotations += 1;
            continue;
        }
        let system = units_at(file, i).and_then(UnitSystem::from_dataset);
        if let (Some(own), UnitsFrom::System(wanted)) = (&system, &options.units)
            && !is_same_system(own, wanted)
        {
            overruled.insert((own.name.clone(), wanted.name.clone()));
        }
        let scale = match scale_of(f, quantity, system.as_ref(), &options.units) {
            Ok(scale) => scale,
            Err(question) => {
                ask(question);
                f64::NAN
            }
        };
        let hertz = hertz(&f.axes[0], options.frequency_unit.as_ref(), &mut axis_notes).unwrap_or_else(|question| {
            ask(question);
            1.0
        });
        let (response, reference) = (End::of(&f.response, naming), End::of(&f.reference, naming));
        let key = (reference.clone(), response.clone());
        if measured.contains_key(&key) {
            match options.duplicates {
                Duplicates::Ask => ask(Question {
                    option: "duplicates",
                    text: format!("`{}` is there more than once", title(f, naming)),
                    answers: vec!["first".to_owned(), "last".to_owned()],
                }),
                Duplicates::First => continue,
                Duplicates::Last => {}
            }
        }
        measured.insert(key, Measured { function: f, response, reference, scale, hertz });
    }
    for (count, seen) in [(left_out, "functions of another quantity"), (rotations, "functions of rotations or moments")]
    {
        if count > 0 {
            notes.push(note(Level::Warning, 58, format!("{count} {seen}"), "they were left out"));
        }
    }
    for (own, wanted) in overruled {
        notes.push(note(
            Level::Warning,
            164,
            format!("units of {own}"),
            format!("the option says {wanted}, and counts"),
        ));
    }
    if measured.is_empty() {
        return Err(ConvertError::Nothing {
            what: "frequency response functions (dataset 58, type 4)",
            found: held(&functions.iter().map(|(.., f)| f.function_type).collect::<Vec<_>>()),
        });
    }
    if !questions.is_empty() {
        return Err(ConvertError::Questions(questions));
    }

    let axes = placed_nodes(files, options.local_axes, &mut notes);
    if axes.is_empty() {
        notes.push(note(Level::Info, 58, "no nodes in the files", "directions count as along global axes"));
    }
    let channel = |end: &End| channel_of(end, &axes);

    let mut set = assemble(&measured, quantity, (&channel, naming), &mut notes)?;
    let coherences: Vec<&Function> = of_type(COHERENCE).map(|(.., f)| *f).collect();
    add_coherences(&mut set, &coherences, (options, naming), &mut axis_notes, &mut notes)?;
    let mut spectra = Vec::new();
    for (file, i, f) in &functions {
        match spectrum(file, *i, f, options, &channel, &mut axis_notes) {
            Some(Ok(spectrum)) => spectra.push(spectrum),
            Some(Err(question)) => notes.push(note(Level::Warning, 58, question.text, "the spectrum was left out")),
            None => {}
        }
    }
    notes.extend(axis_notes.each().map(|(seen, assumed)| note(Level::Info, 58, seen, assumed)));
    Ok(FrfImport { frfs: set.frfs, spectra, notes })
}

fn is_same_system(a: &UnitSystem, b: &UnitSystem) -> bool {
    const AGREE: f64 = 1e-3;
    (a.length / b.length - 1.0).abs() < AGREE && (a.force / b.force - 1.0).abs() < AGREE
}

fn kinds_in_words(orders: &BTreeSet<i32>) -> String {
    let members = FrfQuantity::ALL.iter().filter(|(q, ..)| orders.contains(&q.order()));
    let list: Vec<&str> = members.map(|(_, word, _)| *word).collect();
    list.join(" and ")
}

fn labelled(units: &str) -> String {
    if matches!(units, "" | "NONE") { String::new() } else { format!(", label `{units}`") }
}

/// Which functions there are, in words: "2 time records (type 1)".
fn held(types: &[i64]) -> String {
    let kinds: BTreeSet<i64> = types.iter().copied().collect();
    let word = |kind: i64| match kind {
        1 => "time record",
        2 => "auto spectrum",
        3 => "cross spectrum",
        4 => "unusable frequency response function",
        6 => "coherence",
        9 => "power spectral density",
        12 => "spectrum",
        _ => "function",
    };
    let count = |kind: i64| types.iter().filter(|t| **t == kind).count();
    let list: Vec<String> = kinds.iter().map(|k| format!("{} (type {k})", counted(count(*k), word(*k)))).collect();
    if list.is_empty() { "no functions".to_string() } else { list.join(", ") }
}

/// The channel of an end: its direction in global axes, where the axes of its node are known.
fn channel_of(end: &End, nodes: &BTreeMap<i64, PlacedNode>) -> Channel {
    let local = nodes.get(&end.node).filter(|_| end.node != 0).map_or(Point::GLOBAL, |n| n.axes);
    let axis = end.direction.checked_abs().and_then(|d| usize::try_from(d - 1).ok()).filter(|i| *i < 3);
    let sign = if end.direction < 0 { -1.0 } else { 1.0 };
    Channel { name: end.name.clone(), direction: axis.map(|i| local[i].map(|x| sign * x)) }
}

/// The spectra of universal files that hold no frequency response function.
///
/// # Errors
/// A question where the unit of a frequency axis is not understood.
pub(in crate::data) fn spectra(
    files: &[&UniversalFile],
    options: &FrfOptions,
) -> Result<(Vec<Spectrum>, Vec<Note>), ConvertError> {
    let axes = placed_nodes(files, options.local_axes, &mut Vec::new());
    let channel = |end: &End| channel_of(end, &axes);
    let mut axis_notes = AxisNotes::default();
    let of = |(file, i, d): (&UniversalFile, usize, &Dataset)| match d {
        Dataset::Function(f) => spectrum(file, i, f, options, &channel, &mut axis_notes),
        _ => None,
    };
    let list = files
        .iter()
        .flat_map(|file| file.datasets.iter().enumerate().map(move |(i, d)| (*file, i, d)))
        .filter_map(of)
        .collect::<Result<Vec<_>, Question>>()
        .map_err(|q| ConvertError::Questions(vec![q]))?;
    Ok((list, axis_notes.each().map(|(seen, assumed)| note(Level::Info, 58, seen, assumed)).collect()))
}

/// The quantity that a function states by its data type or by the labels of its axes.
fn stated_quantity(f: &Function) -> Option<FrfQuantity> {
    let by_label =
        || ratio_unit(&f.axes[1].units).map(|(q, ..)| q).or_else(|| response_unit(&f.axes[1].units).map(|(q, _)| q));
    quantity_of(f.axes[1].data_type).or_else(by_label)
}

/// SI value of one unit of a function.
fn scale_of(
    f: &Function,
    quantity: FrfQuantity,
    system: Option<&UnitSystem>,
    from: &UnitsFrom,
) -> Result<f64, Question> {
    if let UnitsFrom::System(system) = from {
        return Ok(system.response(quantity) / system.force);
    }
    let ratio = ratio_unit(&f.axes[1].units).filter(|(q, ..)| *q == quantity);
    let alone = response_unit(&f.axes[1].units).filter(|(q, _)| *q == quantity).map(|(_, unit)| unit);
    let response_label = ratio.map(|(_, unit, _)| unit).or(alone);
    let force_label = ratio.map(|(.., unit)| unit).or_else(|| force_unit(&f.axes[2].units));
    let (response_stated, force_stated) = match from {
        UnitsFrom::Labels => (None, None),
        _ => (system.map(|s| s.response(quantity)), system.map(|s| s.force)),
    };
    // With an unknown denominator, dataset 164 cannot tell that it is a force.
    let is_force = matches!(f.axes[2].data_type, REACTION_FORCE | EXCITATION_FORCE) || force_label.is_some();
    let response = agreed(response_stated, response_label, "the responses")?;
    let force = agreed(if is_force { force_stated } else { None }, force_label, "the excitation")?;
    Ok(response / force)
}

/// A set being filled, with the place of each pair.
struct Filled {
    frfs: FrfSet,
    references: Vec<End>,
    responses: Vec<End>,
}

fn assemble(
    measured: &BTreeMap<(End, End), Measured<'_>>,
    quantity: FrfQuantity,
    (channel, naming): (&dyn Fn(&End) -> Channel, Naming),
    notes: &mut Vec<Note>,
) -> Result<Filled, ConvertError> {
    let grid = |m: &Measured<'_>| GridOf { name: title(m.function, naming), points: points_hz(m.function, m.hertz) };
    let grids: Vec<GridOf> = measured.values().map(grid).collect();
    grids.iter().try_for_each(check)?;
    if measured.values().any(|m| m.function.axes[0].data_type != FREQUENCY) {
        let seen = "functions whose abscissa is not said to be frequency";
        notes.push(note(Level::Info, 58, seen, "it counts as one, in Hz where it has no unit"));
    }
    let (frequencies_hz, indices) = common(&grids)?;
    let most = grids.iter().map(|g| g.points.len()).max().unwrap_or(0);
    if frequencies_hz.len() < most {
        let seen = format!("functions with up to {most} lines, of which {} are common", frequencies_hz.len());
        notes.push(note(Level::Warning, 58, seen, "only the common lines were read"));
    }
    let distinct = |ends: BTreeSet<&End>| ends.into_iter().cloned().collect::<Vec<End>>();
    let references = distinct(measured.values().map(|m| &m.reference).collect());
    let responses = distinct(measured.values().map(|m| &m.response).collect());
    // Memory for pairs that were not measured stays within a small multiple of that for those that were.
    if is_too_sparse(measured.len(), references.len() * responses.len(), frequencies_hz.len()) {
        let (references, responses) = (references.len(), responses.len());
        return Err(ConvertError::TooSparse { measured: measured.len(), references, responses });
    }
    let cells = references.len() * responses.len() * frequencies_hz.len();
    let mut frfs = FrfSet {
        quantity,
        frequencies_hz,
        references: references.iter().map(channel).collect(),
        responses: responses.iter().map(channel).collect(),
        h: vec![Complex::new(f64::NAN, f64::NAN); cells],
        coherence: None,
        n_averages: None,
    };
    for (m, lines) in measured.values().zip(&indices) {
        let (Ok(a), Ok(b)) = (references.binary_search(&m.reference), responses.binary_search(&m.response)) else {
            continue;
        };
        let values = m.function.ordinate.to_complex();
        for (line, at) in lines.iter().enumerate() {
            let cell = frfs.index(line, a, b);
            frfs.h[cell] = values[*at] * m.scale;
        }
    }
    if measured.values().any(|m| matches!(m.function.ordinate, Ordinate::Real(_))) {
        notes.push(note(
            Level::Warning,
            58,
            "frequency response functions with real values",
            "their phase counts as 0",
        ));
    }
    Ok(Filled { frfs, references, responses })
}

/// Whether a matrix of pairs is so empty that holding it whole asks for memory out of proportion to what was measured.
pub(in crate::data) fn is_too_sparse(measured: usize, pairs: usize, lines: usize) -> bool {
    /// 512 MiB of values are held whatever their filling.
    const MOST: usize = 1 << 25;
    pairs > 64 * measured || (pairs > 4 * measured && pairs.saturating_mul(lines) > MOST)
}

fn add_coherences(
    set: &mut Filled,
    functions: &[&Function],
    (options, naming): (&FrfOptions, Naming),
    axis_notes: &mut AxisNotes,
    notes: &mut Vec<Note>,
) -> Result<(), ConvertError> {
    let mut lost = 0;
    for f in functions {
        let (response, reference) = (End::of(&f.response, naming), End::of(&f.reference, naming));
        let b = set.responses.binary_search(&response).ok();
        let a = match set.references.binary_search(&reference) {
            Ok(a) => Some(a),
            // Many analysers leave the reference of a coherence blank.
            Err(_) if set.references.len() == 1 && f.reference.node == 0 => Some(0),
            Err(_) => None,
        };
        let (Some(a), Some(b)) = (a, b) else {
            lost += 1;
            continue;
        };
        let hertz = hertz(&f.axes[0], options.frequency_unit.as_ref(), axis_notes)
            .map_err(|question| ConvertError::Questions(vec![question]))?;
        let own = GridOf { name: format!("coherence {}", title(f, naming)), points: points_hz(f, hertz) };
        check(&own)?;
        let ours = GridOf { name: "the functions".to_owned(), points: set.frfs.frequencies_hz.clone() };
        let Ok((lines, indices)) = common(&[ours, own]) else {
            lost += 1;
            continue;
        };
        let values = f.ordinate.to_complex();
        let n = set.frfs.h.len();
        for i in 0..lines.len() {
            let cell = set.frfs.index(indices[0][i], a, b);
            set.frfs.coherence.get_or_insert_with(|| vec![f64::NAN; n])[cell] = values[indices[1][i]].re;
        }
    }
    if lost > 0 {
        let seen = format!("{lost} coherences without their function");
        notes.push(note(Level::Warning, 58, seen, "they were left out"));
    }
    Ok(())
}

#[cfg(test)]
mod tests;
