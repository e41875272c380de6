//! `retune export --into`

use super::import::read;
use crate::args::Export;
use crate::output::{Failure, print, shown};
use crate::{DONE, WRONG_INPUT, files, writing};
use retune::deck::Deck;
use retune::exchange::export;
use std::path::{Path, PathBuf};

/// Writes a model back into the deck that it was imported from.
pub(crate) fn run(args: &Export, into: &Path) -> Result<u8, Failure> {
    let (model, ..) = files::model(&args.model, None)?;
    let deck = read(into)?;
    if let Some(latin) = deck.sources().iter().find(|s| s.is_latin()) {
        let text = format!(
            "{}: it is no UTF-8 but perhaps Latin-1; save it as UTF-8, so that every byte can be kept",
            latin.name()
        );
        return Err(Failure::text(text));
    }
    let places = places(&deck, &args.output)?;
    for place in &places {
        writing::check_output(place, args.overwrite.force)?;
    }
    let exported = export(&deck, &model)
        .map_err(|e| Failure::lines(&e.to_string().lines().map(str::to_string).collect::<Vec<_>>()))?;
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
fn places(deck: &Deck, output: &Path) -> Result<Vec<PathBuf>, Failure> {
    let folder = |p: &Path| p.parent().map_or_else(PathBuf::new, Path::to_path_buf);
    let (from, to) = (folder(deck.sources()[0].path()), folder(output));
    let mut places = vec![output.to_path_buf()];
    for source in &deck.sources()[1..] {
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
