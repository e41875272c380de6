//! `retune import`

use crate::args::{Import, ParametersOf};
use crate::output::{Failure, print, shown};
use crate::{DONE, WRONG_INPUT, files, ledger, writing};
use retune::deck::{Deck, DeckError, KeywordDeck, Source, is_keyword_deck};
use retune::effect::move_files;
use retune::modal::SolveOptions;
use retune::model::{Model, ParametricModel, Registry, solve_modes};
use retune::yaml::Problem;
use retune_exchange::{ImportOptions, Imported, Quantity, SYSTEMS, import, import_keywords};
use retune_report::text::number;
use std::fmt::Write as _;
use std::path::Path;

/// Bytes of one file of a deck, at most.
const LARGEST: u64 = 1 << 30;

/// A deck of either kind.
pub(super) enum AnyDeck {
    Cards(Deck),
    Keywords(KeywordDeck),
}

impl AnyDeck {
    /// Reads a deck with everything that it includes; its name or its beginning says of which kind it is.
    pub(super) fn read(path: &Path) -> Result<Self, Failure> {
        let failed = |e: DeckError| Failure::text(e.to_string());
        let mut first = Some(ledger::read(path, LARGEST));
        // A deck that is called `.inp` is one of keywords whatever stands first in it: then the line at fault is named.
        let is_called = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("inp"));
        let is_keywords = is_called || matches!(&first, Some(Ok(bytes)) if is_keyword_deck(bytes));
        let mut read = |p: &Path| first.take().unwrap_or_else(|| ledger::read(p, LARGEST));
        Ok(if is_keywords {
            Self::Keywords(KeywordDeck::read(path, &mut read).map_err(failed)?)
        } else {
            Self::Cards(Deck::read(path, &mut read).map_err(failed)?)
        })
    }

    /// Its files, the one that was named first.
    pub(super) fn sources(&self) -> &[Source] {
        match self {
            Self::Cards(deck) => deck.sources(),
            Self::Keywords(deck) => deck.sources(),
        }
    }

    pub(super) fn import(&self, options: ImportOptions) -> Result<Imported, Failure> {
        match self {
            Self::Cards(deck) => import(deck, options),
            Self::Keywords(deck) => import_keywords(deck, options),
        }
        .map_err(|e| failed(&e))
    }
}

/// Errors of a deck, one a line.
fn failed(errors: &[DeckError]) -> Failure {
    let lines: Vec<String> = errors.iter().map(ToString::to_string).collect();
    Failure::lines(&lines)
}

pub(crate) fn run(args: &Import) -> Result<u8, Failure> {
    for output in args.output.iter().chain(&args.test) {
        writing::check_output(output, args.overwrite.force)?;
    }
    if files::kind(&args.deck).is_some() {
        return Err(Failure::text(format!("{} is a file of retune already, and no deck", shown(&args.deck))));
    }
    let deck = AnyDeck::read(&args.deck)?;
    let options = |system| ImportOptions {
        system,
        subcase: args.subcase,
        parameter_per_property: args.parameters == Some(ParametersOf::Properties),
        solver: args.solver,
    };
    let Some(system) = args.units else {
        let imported = deck.import(options(&SYSTEMS[0]))?;
        print(&choices(&imported)?);
        return Ok(WRONG_INPUT);
    };
    let imported = deck.import(options(system))?;
    print(&imported.report.to_string());
    let Some(output) = &args.output else {
        return Err(Failure::text("nothing to write: give `-o MODEL.yaml`"));
    };
    let mut text = imported.text.clone();
    if let Some(mesh) = &imported.mesh {
        // Each model has a mesh of its own: a deck that changes is imported once more, and models of the old one stay what they are.
        let name = format!("{}_mesh.msh", output.file_stem().unwrap_or_default().to_string_lossy());
        text = move_files(&text, &|file| (file == mesh.name).then(|| name.clone()))?;
        let path = output.with_file_name(&name);
        if !is_the_same(&path, &mesh.text) {
            writing::check_room(&path, args.overwrite.force, mesh.text.len())?;
            if writing::write(&path, &mesh.text) {
                print(&format!("written     {}\n", shown(&path)));
            }
        }
    }
    if writing::write(output, &text) {
        print(&format!("written     {}\n", shown(output)));
    }
    match (&args.test, &imported.test) {
        (Some(path), Some(test)) => {
            if writing::write(path, test) {
                print(&format!("written     {}\n", shown(path)));
            }
        }
        (Some(path), None) => {
            return Err(Failure::text(format!(
                "{}: not written, because the deck asks for no frequencies (DRESP1 FREQ)",
                shown(path)
            )));
        }
        (None, Some(_)) => {
            print("notes       the deck asks for frequencies: `--test FILE` writes them as a test file\n");
        }
        (None, None) => {}
    }
    if text.len() as u64 > files::LARGEST {
        print("notes       the model file is larger than 16 MiB, more than other verbs read: give a coarser mesh\n");
        return Ok(DONE);
    }
    // The model is whole, or the import has a fault: said with the line of the file.
    match imported.load(&Registry::builtin()) {
        Ok(_) => Ok(DONE),
        Err(problems) => {
            let problems: Vec<Problem> = problems.into_iter().map(|p| with_card(&deck, &imported, p)).collect();
            Err(Failure::problems(output, &text, &problems))
        }
    }
}

/// A problem of the model file with the card that it comes from.
fn with_card(deck: &AnyDeck, imported: &Imported, mut problem: Problem) -> Problem {
    if let (AnyDeck::Cards(cards), Some(id)) = (deck, imported.card_of(&problem.path)) {
        let at = cards.error(id, None, "");
        problem.message.push_str(&format!(" (of {} at {}:{})", at.card, at.file, at.line));
    }
    problem
}

/// Whether a file holds a text already, as it does when a deck is imported once more.
fn is_the_same(path: &Path, text: &str) -> bool {
    std::fs::metadata(path).is_ok_and(|m| m.is_file() && m.len() == text.len() as u64)
        && std::fs::read(path).is_ok_and(|bytes| bytes == text.as_bytes())
}

/// What the deck would be in every system of units.
pub(super) fn choices(imported: &Imported) -> Result<String, Failure> {
    let model = match imported.load(&Registry::builtin()) {
        Ok((model, ..)) => model,
        Err(problems) => return Err(Failure::problems(Path::new("model.yaml"), &imported.text, &problems)),
    };
    let theta = model.parameters().nominal();
    let mass = model.mass_properties(&theta)?.map_or(0.0, |m| m.mass);
    let size = model.geometry().size();
    let mut out = String::from("A deck does not say its units, and they are not guessed. It is\n\n");
    let _ = writeln!(out, "  --units     mass                 size                 units");
    for system in SYSTEMS {
        let (m, l) = (system.factor(Quantity::Mass), system.factor(Quantity::Length));
        let mass = format!("{} kg", number(mass * m));
        let size = format!("{} m", number(size * l));
        let _ = writeln!(out, "  {:<11} {mass:<20} {size:<20} {}", system.name, system.summary);
    }
    let _ = match first_frequency(&model) {
        Some(f) => {
            writeln!(out, "\nThe first elastic mode is at {} Hz in each of them, if the units are coherent.", number(f))
        }
        None => writeln!(out, "\nThe first elastic mode is not computed."),
    };
    out.push_str("Give the one that the structure has.\n");
    Ok(out)
}

fn first_frequency(model: &Model) -> Option<f64> {
    let theta = model.parameters().nominal();
    let modes = solve_modes(model, &theta, SolveOptions { n_elastic: 1, shift: None }).ok()?;
    (modes.len() > modes.n_rigid).then(|| modes.frequency_hz(modes.n_rigid))
}
