//! NumPy `.npz` files: named arrays in a ZIP archive (`numpy.savez`, `numpy.savez_compressed`).
//!
//! Each entry `name.npy` is an array in the format of `npy`, stored or deflated; others are passed over. Sizes and
//! checksums are checked, and what the arrays take in memory against a limit.
//!
//! Source: NumPy documentation, numpy.lib.format; PKWARE, APPNOTE 6.3.10.

use super::mat::{MOST_MEMORY, MOST_RATIO};
use super::npy::{self, Array, NpyError};
use rawzip::{CompressionMethod, ZipArchive, ZipVerification};

/// Why an `.npz` file cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NpzError {
    /// Not the format, or damaged.
    #[error("this is not a sound ZIP archive: {0}")]
    Archive(String),
    /// A ZIP archive of something else.
    #[error("this is a ZIP archive without arrays of NumPy (`name.npy`), so no .npz file")]
    NoArrays,
    /// An entry that cannot be unfolded.
    #[error("its array `{}`: {why}", name.escape_debug())]
    Entry {
        /// Its name.
        name: String,
        /// Why.
        why: &'static str,
    },
    /// An array.
    #[error("its array `{}`: {source}", name.escape_debug())]
    Array {
        /// Its name.
        name: String,
        /// Why.
        source: NpyError,
    },
    /// Arrays that take more memory than there may be.
    #[error("its arrays take more than {} MiB in memory; save those that are needed alone", .0 >> 20)]
    TooLarge(usize),
}

/// Whether a file is a ZIP archive, by its first bytes.
pub fn is_zip(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(b"PK\x05\x06")
}

/// Reads the arrays of an archive, in the order of its directory.
///
/// # Errors
/// [`NpzError`].
pub fn read(bytes: &[u8]) -> Result<Vec<(String, Array)>, NpzError> {
    read_within(bytes, limit(bytes))
}

/// Reads an archive in which words stand beside arrays: the arrays, and the words, each by its name.
///
/// # Errors
/// [`NpzError`].
#[expect(clippy::type_complexity, reason = "two lists of named things")]
pub fn read_with_words(bytes: &[u8]) -> Result<(Vec<(String, Array)>, Vec<(String, String)>), NpzError> {
    let mut words = Vec::new();
    let arrays = unfold(bytes, limit(bytes), |name, data| {
        let word = npy::read_word(data);
        words.extend(word.iter().map(|w| (name.to_owned(), w.clone())));
        word.is_some()
    })?;
    Ok((arrays, words))
}

/// What the arrays of an archive may take in memory.
fn limit(bytes: &[u8]) -> usize {
    MOST_MEMORY.max(bytes.len().saturating_mul(4))
}

fn read_within(bytes: &[u8], limit: usize) -> Result<Vec<(String, Array)>, NpzError> {
    unfold(bytes, limit, |_, _| false)
}

/// * `taken` - whether an entry, by its name and its bytes, is not an array to be read
fn unfold(
    bytes: &[u8],
    limit: usize,
    mut taken: impl FnMut(&str, &[u8]) -> bool,
) -> Result<Vec<(String, Array)>, NpzError> {
    let broken = |e: rawzip::Error| NpzError::Archive(e.to_string());
    let mut left = limit;
    let archive = ZipArchive::from_slice(bytes).map_err(broken)?;
    let mut entries = archive.entries();
    let mut arrays = Vec::new();
    while let Some(entry) = entries.next_entry().map_err(broken)? {
        let path = String::from_utf8_lossy(entry.file_path().as_bytes()).into_owned();
        let Some(name) = path.strip_suffix(".npy").map(str::to_owned) else { continue };
        let wrong = |why| NpzError::Entry { name: name.clone(), why };
        let found = archive.get_entry(entry.wayfinder()).map_err(broken)?;
        let data = found.data();
        let unfolded;
        let data = match entry.compression_method() {
            CompressionMethod::STORE => data,
            CompressionMethod::DEFLATE => {
                let most = left.min(data.len().saturating_mul(MOST_RATIO).saturating_add(MOST_RATIO));
                unfolded =
                    miniz_oxide::inflate::decompress_to_vec_with_limit(data, most).map_err(|e| match e.status {
                        miniz_oxide::inflate::TINFLStatus::HasMoreOutput => NpzError::TooLarge(limit),
                        _ => wrong("its compressed bytes are damaged"),
                    })?;
                &unfolded[..]
            }
            _ => return Err(wrong("it is compressed by a method other than deflate, which NumPy does not write")),
        };
        let seen = ZipVerification { crc: rawzip::crc32(data), uncompressed_size: data.len() as u64 };
        found.claim_verifier().valid(seen).map_err(|_| wrong("its size or checksum is wrong: the file is damaged"))?;
        if taken(&name, data) {
            continue;
        }
        let array = npy::read(data).map_err(|source| NpzError::Array { name: name.clone(), source })?;
        left = left.checked_sub(array.n_bytes()).ok_or(NpzError::TooLarge(limit))?;
        arrays.push((name, array));
    }
    if arrays.is_empty() { Err(NpzError::NoArrays) } else { Ok(arrays) }
}

/// Writes an archive of arrays, stored without compression: name and bytes of each `.npy` file.
///
/// # Panics
/// If a name is longer than 65 535 bytes.
pub fn write(entries: &[(&str, Vec<u8>)]) -> Vec<u8> {
    use std::io::Write as _;
    let mut bytes = Vec::new();
    let mut zip = rawzip::ZipArchiveWriter::new(&mut bytes);
    for (name, data) in entries {
        let mut entry = || {
            let path = format!("{name}.npy");
            let (mut entry, config) = zip.new_file(&path).compression_method(CompressionMethod::STORE).start()?;
            let mut writer = config.wrap(&mut entry);
            writer.write_all(data)?;
            let (_, descriptor) = writer.finish()?;
            entry.finish(descriptor)
        };
        entry().expect("memory takes every entry");
    }
    zip.finish().expect("memory takes a directory");
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arrays::npy::Values;
    use rawzip::ZipArchiveWriter;
    use std::io::Write as _;

    fn array(values: &[f64]) -> Array {
        Array { shape: vec![values.len()], values: Values::Real(values.to_vec()) }
    }

    /// An archive of entries: name, bytes, whether deflated.
    fn archive(entries: &[(&str, &[u8], bool)]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut zip = ZipArchiveWriter::new(&mut bytes);
        for (name, data, is_deflated) in entries {
            let method = if *is_deflated { CompressionMethod::DEFLATE } else { CompressionMethod::STORE };
            let (mut entry, config) = zip.new_file(name).compression_method(method).start().unwrap();
            let stored = if *is_deflated { miniz_oxide::deflate::compress_to_vec(data, 6) } else { data.to_vec() };
            entry.write_all(&stored).unwrap();
            let mut writer = config.wrap(std::io::sink());
            writer.write_all(data).unwrap();
            let (_, descriptor) = writer.finish().unwrap();
            entry.finish(descriptor).unwrap();
        }
        zip.finish().unwrap();
        bytes
    }

    #[test]
    fn stored_and_deflated_arrays_come_with_their_names() {
        let (f, h) = (array(&[1.0, 2.0]), array(&[0.5; 300]));
        let bytes =
            archive(&[("f.npy", &npy::write(&f), false), ("note.txt", b"x", false), ("h.npy", &npy::write(&h), true)]);
        assert!(is_zip(&bytes));
        assert_eq!(read(&bytes).unwrap(), [("f".to_string(), f), ("h".to_string(), h)]);
    }

    #[test]
    fn what_is_no_archive_of_arrays_is_refused() {
        assert_eq!(read(&archive(&[("a.xml", b"<a/>", true)])), Err(NpzError::NoArrays));
        assert!(matches!(read(b"PK\x03\x04 and no more"), Err(NpzError::Archive(_))));
        let mut bytes = archive(&[("f.npy", &npy::write(&array(&[1.0, 2.0])), false)]);
        let at = bytes.windows(6).position(|w| w == b"\x93NUMPY").unwrap();
        bytes[at + 130] ^= 1;
        assert!(read(&bytes).unwrap_err().to_string().contains("checksum"));
    }

    #[test]
    fn a_bomb_is_refused_without_its_memory() {
        let bytes = archive(&[("f.npy", &npy::write(&array(&vec![0.0; 200_000])), true)]);
        assert!(bytes.len() < 3_000 && read(&bytes).is_ok());
        assert_eq!(read_within(&bytes, 1 << 20), Err(NpzError::TooLarge(1 << 20)));
        // Arrays that fit one by one, not together.
        let part = npy::write(&array(&vec![0.0; 60_000]));
        let bytes = archive(&[("f.npy", &part, true), ("g.npy", &part, true), ("h.npy", &part, true)]);
        assert_eq!(read_within(&bytes, 1 << 20), Err(NpzError::TooLarge(1 << 20)));
    }

    #[test]
    fn mutated_files_do_no_harm() {
        let (f, h) = (npy::write(&array(&[1.0, 2.0])), npy::write(&array(&[0.5; 30])));
        let seeds = [archive(&[("f.npy", &f, false), ("h.npy", &h, true)]), archive(&[("f.npy", &f, true)])];
        crate::arrays::mutate::all(&seeds, 5_000, |bytes| read(bytes).is_ok());
    }
}
