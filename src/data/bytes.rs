//! Bytes of files, within bounds.

use std::io::Read;
use std::path::Path;

/// Most bytes of what is no regular file, whose end nobody knows: 256 MiB.
const ENDLESS: u64 = 256 << 20;

/// The bytes of a file; of a pipe or a device too, which may never end.
///
/// * `most` - most bytes that are read
///
/// # Errors
/// What the operating system says, or that the file is larger, in words.
pub fn read_bytes(path: &Path, most: u64) -> Result<Vec<u8>, String> {
    let file = std::fs::File::open(path).map_err(|e| e.to_string())?;
    let meta = file.metadata().map_err(|e| e.to_string())?;
    if meta.is_dir() {
        return Err("it is a folder".to_string());
    }
    if meta.is_file() && meta.len() > most {
        return Err(format!("it has {} bytes, more than the {most} that are read", meta.len()));
    }
    let most = if meta.is_file() { most } else { most.min(ENDLESS) };
    let mut bytes = Vec::new();
    file.take(most + 1).read_to_end(&mut bytes).map_err(|e| e.to_string())?;
    if bytes.len() as u64 > most {
        return Err(format!("it has more than the {most} bytes that are read"));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_too_long_or_never_ends_is_refused() {
        let own = std::env::current_exe().unwrap();
        assert!(read_bytes(&own, 10).unwrap_err().contains("more than the 10"));
        assert!(read_bytes(&std::env::temp_dir(), 10).is_err());
        let zeros = Path::new("/dev/zero");
        if zeros.exists() {
            assert_eq!(read_bytes(zeros, 1000).unwrap_err(), "it has more than the 1000 bytes that are read");
        }
    }
}
