//! `retune merge`

use super::benchmark::{LARGEST_SHARD, give};
use crate::args::Merge;
use crate::files;
use crate::output::{Failure, shown};
use retune::diagnosis::benchmark::{Shard, merge};

pub(crate) fn run(args: &Merge) -> Result<u8, Failure> {
    args.answer.check()?;
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
