//! `retune merge`

use super::batch::{self, Done};
use super::benchmark::{LARGEST_SHARD, give};
use crate::DONE;
use crate::args::Merge;
use crate::files;
use crate::output::{Failure, shown};
use retune_diagnosis::benchmark::{Shard, merge};

pub(crate) fn run(args: &Merge) -> Result<u8, Failure> {
    args.answer.check()?;
    if let Some(results) = results(args)? {
        batch::give(args.answer.output.as_deref(), results);
        return Ok(DONE);
    }
    let mut shards = Vec::with_capacity(args.files.len());
    for path in &args.files {
        let text = files::read_at_most(path, LARGEST_SHARD)?;
        let shard = Shard::read(&text).map_err(|why| Failure::text(format!("{}: {why}", shown(path))))?;
        shards.push((shown(path), shard));
    }
    // Who asks for cases by name is told of each.
    let cases = args.cases || shards.iter().any(|(_, shard)| shard.has_diagnoses());
    give(&args.answer, &merge(shards)?, cases)
}

/// The results of a batch, if the first file is one.
fn results(args: &Merge) -> Result<Option<Vec<Done>>, Failure> {
    if batch::read(&args.files[0]).is_none() {
        return Ok(None);
    }
    if args.cases {
        return Err(Failure::text("--cases: these are results of a batch, which has no cases"));
    }
    let one = |path: &std::path::PathBuf| {
        let text = files::read_at_most(path, LARGEST_SHARD)?;
        let done = Done::from_line(&text)
            .filter(|done| path.file_stem().is_some_and(|stem| stem.to_string_lossy() == done.key));
        done.ok_or_else(|| Failure::text(format!("{}: it is not a result of `retune batch`", shown(path))))
    };
    args.files.iter().map(one).collect::<Result<Vec<_>, _>>().map(Some)
}
