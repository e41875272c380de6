//! `retune export --into`

use super::import::AnyDeck;
use crate::args::Export;
use crate::output::{Failure, print, shown};
use crate::{DONE, WRONG_INPUT, files, writing};
use retune::deck::Source;
use retune_exchange::{export, export_keywords};
use std::path::{Path, PathBuf};

/// Writes a model back into the deck that it was imported from.
pub(crate) fn run(args: &Export, into: &Path) -> Result<u8, Failure> {
    let (model, ..) = files::model(&args.model, None)?;
    let deck = AnyDeck::read(into)?;
    let sources = deck.sources();
    if let Some(latin) = sources.iter().find(|s| s.is_latin()) {
        let text = format!(
            "{}: it is not UTF-8 but perhaps Latin-1; save it as UTF-8, so that every byte can be kept",
            latin.name()
        );
        return Err(Failure::text(text));
    }
    let places = places(sources, &args.output)?;
    for place in &places {
        writing::check_output(place, args.overwrite.force)?;
    }
    let exported = match &deck {
        AnyDeck::Cards(deck) => export(deck, &model),
        AnyDeck::Keywords(deck) => export_keywords(deck, &model),
    };
    let exported =
        exported.map_err(|e| Failure::lines(&e.to_string().lines().map(str::to_string).collect::<Vec<_>>()))?;
    for line in &exported.changes {
        print(&format!("{line}\n"));
    }
    let mut written = true;
    for (place, text) in places.iter().zip(&exported.files) {
        written &= writing::write(place, text);
    }
    print(&format!(
        "{}; written: {}\n",
        exported.summary(),
        places.iter().map(|p| shown(p)).collect::<Vec<_>>().join(", ")
    ));
    if exported.rounding > 0.0 {
        print(&format!("the fields hold the values to {:.1e}\n", exported.rounding));
    }
    Ok(if written { DONE } else { WRONG_INPUT })
}

/// Where the files of a deck go: the first to the output, those that it includes beside it as they stand beside the first.
fn places(sources: &[Source], output: &Path) -> Result<Vec<PathBuf>, Failure> {
    let folder = |p: &Path| p.parent().map_or_else(PathBuf::new, Path::to_path_buf);
    let (from, to) = (folder(sources[0].path()), folder(output));
    let mut places = vec![output.to_path_buf()];
    for source in &sources[1..] {
        let Ok(relative) = source.path().strip_prefix(&from) else {
            let text = format!(
                "{} does not lie beside the deck: its place beside {} is not known",
                source.name(),
                shown(output)
            );
            return Err(Failure::text(text));
        };
        places.push(to.join(relative));
    }
    Ok(places)
}
