//! Finished settings, one JSON line each: what a study that was interrupted does not do again.

use std::collections::BTreeMap;
use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::PathBuf;

use super::{Record, StudyError};

/// The records of a file that grows by a line with each.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    records: BTreeMap<String, Record>,
    /// Whether the file ends within a line, as an interrupted program leaves it.
    is_torn: bool,
}

impl Journal {
    /// Reads the file, if there is one; lines that are no records do not count. `fresh` forgets all.
    ///
    /// # Errors
    /// It is there but cannot be read, or not be emptied.
    pub fn open(path: PathBuf, fresh: bool) -> Result<Self, StudyError> {
        if fresh {
            return match fs::remove_file(&path) {
                Err(e) if e.kind() != io::ErrorKind::NotFound => Err(failed(path, "remove")(e)),
                _ => Ok(Self::new(path, b"")),
            };
        }
        match fs::read(&path) {
            Ok(bytes) => Ok(Self::new(path, &bytes)),
            Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(Self::new(path, b"")),
            Err(e) => Err(failed(path, "read")(e)),
        }
    }

    fn new(path: PathBuf, bytes: &[u8]) -> Self {
        let lines = bytes.split(|b| *b == b'\n');
        let records = lines.filter_map(|line| serde_json::from_slice::<Record>(line).ok());
        Self {
            path,
            records: records.map(|r| (r.key.clone(), r)).collect(),
            is_torn: bytes.last().is_some_and(|b| *b != b'\n'),
        }
    }

    /// The record filed under `key`.
    #[must_use]
    pub fn get(&self, key: &str) -> Option<&Record> {
        self.records.get(key)
    }

    /// Number of records.
    #[must_use]
    pub fn len(&self) -> usize {
        self.records.len()
    }

    /// Whether there is no record.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.records.is_empty()
    }

    /// Adds a record to the file, and from then on to what is known.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn push(&mut self, record: Record) -> Result<(), StudyError> {
        let mut line = if self.is_torn {
            vec![b'\n']
        } else {
            Vec::new()
        };
        let written = serde_json::to_writer(&mut line, &record)
            .map_err(io::Error::from)
            .and_then(|()| {
                line.push(b'\n');
                let mut options = OpenOptions::new();
                let mut file = options.create(true).append(true).open(&self.path)?;
                // One call, so that two programs that share the file do not mix their lines.
                file.write_all(&line)
            });
        written.map_err(failed(self.path.clone(), "write"))?;
        self.is_torn = false;
        self.records.insert(record.key.clone(), record);
        Ok(())
    }
}

fn failed(path: PathBuf, action: &'static str) -> impl FnOnce(io::Error) -> StudyError {
    move |source| StudyError::Io {
        path,
        action,
        source,
    }
}
