//! Reading a file whole, with a bound: nothing that a user names can fill the memory.

use std::fs::File;
use std::io::{Error, ErrorKind, Read as _, Result};
use std::path::Path;

/// Bytes that are read of what has no length of its own (a pipe, a device) before it counts as endless: 256 MiB.
const STREAM: u64 = 256 << 20;

/// The bytes of a file.
///
/// * `largest` - bytes of a regular file, at most; of a pipe or a device 256 MiB, where that is less
///
/// # Errors
/// What the operating system says; a folder; a file, a pipe or a device that holds more, with the limit in the message; a memory too small.
pub fn read_file(path: &Path, largest: u64) -> Result<Vec<u8>> {
    let mut file = File::open(path)?;
    let meta = file.metadata()?;
    if meta.is_dir() {
        return Err(Error::new(ErrorKind::IsADirectory, "it is a folder, and a file is expected"));
    }
    // The files of /proc have no length either.
    let has_length = meta.is_file() && meta.len() > 0;
    let limit = if has_length { largest } else { largest.min(STREAM) };
    if meta.len() > limit {
        let text = format!("it has {} bytes, more than the {limit} that are read", meta.len());
        return Err(Error::new(ErrorKind::FileTooLarge, text));
    }
    let mut bytes = Vec::new();
    if has_length {
        bytes.try_reserve_exact(meta.len() as usize + 1).map_err(|_| ErrorKind::OutOfMemory)?;
    }
    (&mut file).take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        let text = format!("it goes on after {limit} bytes, and no more are read");
        return Err(Error::new(ErrorKind::FileTooLarge, text));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::read_file;
    use std::path::Path;

    #[test]
    fn a_file_is_read_up_to_the_limit_and_refused_above_it() {
        let path = std::env::temp_dir().join(format!("retune-bounded-{}", std::process::id()));
        std::fs::write(&path, [7; 100]).unwrap();
        assert_eq!(read_file(&path, 100).unwrap(), [7; 100]);
        let e = read_file(&path, 99).unwrap_err().to_string();
        assert!(e.contains("100 bytes") && e.contains("99"), "{e}");
        std::fs::remove_file(&path).unwrap();
    }

    #[test]
    fn folders_and_endless_devices_are_refused() {
        let e = read_file(&std::env::temp_dir(), 100).unwrap_err().to_string();
        assert!(e.contains("folder"), "{e}");
        if cfg!(unix) {
            let e = read_file(Path::new("/dev/zero"), 1 << 16).unwrap_err().to_string();
            assert!(e.contains("65536"), "{e}");
        }
    }
}
