//! Where included files come from. This crate never touches the disk: the case hands it a reader.

use flate2::Compression;
use flate2::read::GzDecoder;
use flate2::write::GzEncoder;
use std::collections::BTreeMap;
use std::io::{self, Read, Write};

/// Gives the contents of files that dictionaries include.
pub trait Files {
    /// The bytes of `path`; gzip is recognised by the caller.
    ///
    /// # Errors
    /// What the file system says; `NotFound` is what `#includeIfPresent` accepts.
    fn load(&mut self, path: &str) -> io::Result<Vec<u8>>;
    /// What `<case>` and `$FOAM_CASE` stand for, in the same form as [`crate::Source::path`].
    fn case_root(&self) -> String {
        String::new()
    }
    /// A variable of the environment: what `$name` stands for when no entry has that name.
    fn variable(&self, _name: &str) -> Option<String> {
        None
    }
}

/// No file can be included.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoFiles;
impl Files for NoFiles {
    fn load(&mut self, _: &str) -> io::Result<Vec<u8>> {
        Err(io::ErrorKind::NotFound.into())
    }
}

/// Files by name, for tests and generated cases.
#[derive(Clone, Debug, Default)]
pub struct MemoryFiles(pub BTreeMap<String, Vec<u8>>);
impl Files for MemoryFiles {
    fn load(&mut self, path: &str) -> io::Result<Vec<u8>> {
        self.0.get(path).cloned().ok_or_else(|| io::ErrorKind::NotFound.into())
    }
}

/// The contents of a file that may be gzipped; judged by its first bytes, not its name.
///
/// # Errors
/// A damaged archive.
pub fn decompress(bytes: Vec<u8>) -> io::Result<Vec<u8>> {
    if !bytes.starts_with(&[0x1f, 0x8b]) {
        return Ok(bytes);
    }
    let mut out = Vec::new();
    GzDecoder::new(bytes.as_slice()).read_to_end(&mut out)?;
    Ok(out)
}

/// Gzips, fast rather than small.
///
/// # Errors
/// None in practice: writing to memory does not fail.
pub fn compress(bytes: &[u8]) -> io::Result<Vec<u8>> {
    let mut out = GzEncoder::new(Vec::new(), Compression::fast());
    out.write_all(bytes)?;
    out.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gzip_is_recognised_and_plain_text_left_alone() {
        let text = b"a 1;".repeat(100);
        let packed = compress(&text).unwrap();
        assert!(packed.len() < text.len());
        assert_eq!(decompress(packed).unwrap(), text);
        assert_eq!(decompress(text.clone()).unwrap(), text);
        assert!(decompress(vec![0x1f, 0x8b, 0]).is_err());
    }
}
