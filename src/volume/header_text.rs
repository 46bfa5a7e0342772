//! Text headers: bounded lines and typed fields.

use std::collections::BTreeMap;
use std::io::{BufRead, Read};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use super::VolumeError;

/// Longest text header read; a binary file without line ends fails here at once.
const HEADER_LIMIT: u64 = 1 << 20;

/// Reads a header line by line and never beyond [`HEADER_LIMIT`].
pub(super) struct HeaderLines<'a, R> {
    path: &'a Path,
    reader: R,
    position: u64,
}

impl<'a, R: BufRead> HeaderLines<'a, R> {
    /// Lines of `reader`, which stands at the file's first byte.
    pub(super) fn new(path: &'a Path, reader: R) -> Self {
        Self {
            path,
            reader,
            position: 0,
        }
    }

    /// The next line without its line end (LF or CRLF), or nothing at the end of the file.
    pub(super) fn next_line(&mut self) -> Result<Option<String>, VolumeError> {
        let left = HEADER_LIMIT - self.position;
        let mut line = Vec::new();
        let n = self
            .reader
            .by_ref()
            .take(left)
            .read_until(b'\n', &mut line)
            .map_err(|e| VolumeError::io(self.path, "read", e))?;
        self.position += n as u64;
        if self.position >= HEADER_LIMIT {
            return Err(VolumeError::field(
                self.path,
                "header",
                "more than 1 MiB without an end of the header",
                "a text header that ends within 1 MiB",
            ));
        }
        if n == 0 {
            return Ok(None);
        }
        while matches!(line.last(), Some(b'\n' | b'\r')) {
            line.pop();
        }
        Ok(Some(String::from_utf8_lossy(&line).into_owned()))
    }

    /// Bytes read so far: where the payload of an attached header begins.
    pub(super) fn position(&self) -> u64 {
        self.position
    }
}

/// The fields of a text header, by name.
#[derive(Debug)]
pub(super) struct Fields {
    path: PathBuf,
    values: BTreeMap<String, String>,
}

impl Fields {
    /// No fields yet.
    pub(super) fn new(path: &Path) -> Self {
        Self {
            path: path.to_owned(),
            values: BTreeMap::new(),
        }
    }

    /// The file the header is in.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Adds a field; a second value for one name is an error, since nobody can tell which is meant.
    pub(super) fn insert(&mut self, key: &str, value: &str) -> Result<(), VolumeError> {
        let value = value.trim();
        match self.values.insert(key.to_owned(), value.to_owned()) {
            Some(old) if old != value => {
                let found = format!("both {} and {}", shown(&old), shown(value));
                Err(VolumeError::field(&self.path, key, found, "one value"))
            }
            _ => Ok(()),
        }
    }

    /// The value of a field.
    pub(super) fn text(&self, key: &str) -> Option<&str> {
        self.values.get(key).map(String::as_str)
    }

    /// An error that blames `key` and quotes its value.
    pub(super) fn error(&self, key: &str, expected: impl Into<String>) -> VolumeError {
        let found = self.text(key).map_or_else(|| "no such field".into(), shown);
        VolumeError::field(&self.path, key, found, expected)
    }

    /// The value of a field that must be there.
    pub(super) fn require(&self, key: &str, expected: &str) -> Result<&str, VolumeError> {
        self.text(key).ok_or_else(|| self.error(key, expected))
    }

    /// The value of a field as one `T`.
    pub(super) fn parse<T: FromStr>(
        &self,
        key: &str,
        expected: &str,
    ) -> Result<Option<T>, VolumeError> {
        self.text(key)
            .map(|v| v.parse().map_err(|_| self.error(key, expected)))
            .transpose()
    }

    /// The value of a field as whitespace-separated numbers, as many as there are.
    pub(super) fn list<T: FromStr>(
        &self,
        key: &str,
        expected: &str,
    ) -> Result<Option<Vec<T>>, VolumeError> {
        let Some(text) = self.text(key) else {
            return Ok(None);
        };
        let parsed: Result<Vec<T>, _> = text.split_whitespace().map(str::parse).collect();
        parsed.map(Some).map_err(|_| self.error(key, expected))
    }

    /// The value of a field as exactly `N` numbers.
    pub(super) fn array<T: FromStr, const N: usize>(
        &self,
        key: &str,
        expected: &str,
    ) -> Result<Option<[T; N]>, VolumeError> {
        self.list(key, expected)?
            .map(|v| v.try_into().map_err(|_| self.error(key, expected)))
            .transpose()
    }
}

/// A header value as it appears in a message: quoted, escaped, at most 80 characters.
pub(super) fn shown(value: &str) -> String {
    let mut text: String = value.chars().take(80).collect();
    if text.len() < value.len() {
        text.push('…');
    }
    format!("{text:?}")
}
