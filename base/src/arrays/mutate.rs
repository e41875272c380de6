//! Readers against damaged files: what a reader of any format must survive. Readers of other packages have this file too, by its path, so that it
//! names nothing of this one.

use rand::{Rng, RngExt, SeedableRng};

/// Gives mutated copies of good files to a reader, which may refuse them but not panic, hang or ask for much memory; some must
/// still be read, or the mutations say nothing.
///
/// * `rounds` - copies; forty times as many with `RETUNE_SLOW=1`
/// * `read` - whether it takes the bytes
pub(crate) fn all(seeds: &[Vec<u8>], rounds: u32, read: impl Fn(&[u8]) -> bool) {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    let mut read_at_all = 0;
    for seed in seeds {
        assert!(read(seed), "the file itself must be readable");
    }
    let times = if std::env::var("RETUNE_SLOW").is_ok_and(|v| v == "1") { 40 } else { 1 };
    for _ in 0..times * rounds {
        let mut bytes = seeds[rng.random_range(0..seeds.len())].clone();
        for _ in 0..rng.random_range(1..4) {
            let at = rng.random_range(0..bytes.len());
            match rng.random_range(0..8) {
                0..3 => bytes[at] = rng.next_u32() as u8,
                3..6 => bytes[at] = b"\t,;\n.0-9'()"[rng.random_range(0..11)],
                6 => bytes.truncate(at + 1),
                _ => {
                    let end = rng.random_range(at..=bytes.len().min(at + 16));
                    bytes.drain(at..end);
                    if bytes.is_empty() {
                        bytes.push(0);
                    }
                }
            }
        }
        read_at_all += u32::from(read(&bytes));
    }
    assert!(read_at_all > 0);
}
