//! The file's tags without the data between them.
//!
//! Appended bytes are no XML, and inline data may be gigabytes: so only the tags are kept, at most
//! [`LIMIT`] bytes of them, with the places of what stood between.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use roxmltree::{Document, Node};

use crate::volume::VolumeError;
use crate::volume::source::open_regular;

/// Most bytes of tags.
const LIMIT: usize = 1 << 20;

/// Tags and the places of the data.
pub(super) struct Markup {
    text: String,
    // Where the data of every `DataArray` begins and ends in the file, in the order of their tags.
    arrays: Vec<(u64, u64)>,
    /// Where the appended data begins, if there is any.
    pub(super) appended: Option<u64>,
    /// Bytes of the file.
    pub(super) len: u64,
}

impl Markup {
    /// Reads a file's tags up to its appended data or its end.
    pub(super) fn read(path: &Path) -> Result<Self, VolumeError> {
        let (file, len) = open_regular(path)?;
        let mut scanner = Scanner {
            path,
            reader: BufReader::with_capacity(1 << 16, file),
            position: 0,
        };
        let mut markup = Self {
            text: String::new(),
            arrays: Vec::new(),
            appended: None,
            len,
        };
        // The array whose data is being passed over.
        let mut open = None;
        loop {
            let (_, found) = scanner.skip_to(b'<', markup.text.is_empty())?;
            let data_end = scanner.position;
            if let Some(index) = open.take() {
                let place: Option<&mut (u64, u64)> = markup.arrays.get_mut(index);
                if let Some(place) = place {
                    place.1 = data_end;
                }
            }
            if !found {
                return Ok(markup);
            }
            let tag = scanner.tag()?;
            let Some(tag) = tag else { continue };
            markup.text += &tag;
            if markup.text.len() > LIMIT {
                let found = "more than 1 MiB of tags";
                let expected = "tags that take at most 1 MiB";
                return Err(VolumeError::field(path, "XML", found, expected));
            }
            let here = scanner.position;
            if is_tag(&tag, "<DataArray") {
                if !tag.ends_with("/>") {
                    open = Some(markup.arrays.len());
                }
                markup.arrays.push((here, here));
            } else if is_tag(&tag, "<AppendedData") && !tag.ends_with("/>") {
                let (_, found) = scanner.skip_to(b'_', true)?;
                if !found {
                    let expected = "an underscore before the data";
                    return Err(VolumeError::field(path, "AppendedData", "none", expected));
                }
                markup.appended = Some(scanner.position + 1);
                markup.text += "</AppendedData></VTKFile>";
                return Ok(markup);
            }
        }
    }

    /// The tags as a document.
    pub(super) fn parse(&self, path: &Path) -> Result<Document<'_>, VolumeError> {
        // Without document type definitions, whose entities can grow without bounds.
        Document::parse(&self.text).map_err(|e| {
            let found: String = e.to_string().chars().take(120).collect();
            VolumeError::field(path, "XML", found, "well-formed tags")
        })
    }

    /// Where the inline data of a `DataArray` begins and ends in the file.
    pub(super) fn inline(&self, array: Node<'_, '_>) -> Option<(u64, u64)> {
        let all = array.document().descendants();
        let mut all = all.filter(|n| n.has_tag_name("DataArray"));
        self.arrays.get(all.position(|n| n == array)?).copied()
    }
}

/// Whether a tag is of the element whose start is `name`, as `<DataArray`.
fn is_tag(tag: &str, name: &str) -> bool {
    let rest = tag.strip_prefix(name);
    rest.is_some_and(|r| r.starts_with(|c: char| c == '>' || c == '/' || c.is_ascii_whitespace()))
}

struct Scanner<'a> {
    path: &'a Path,
    reader: BufReader<File>,
    position: u64,
}

impl Scanner<'_> {
    /// Passes over everything before the next `byte`; says whether there is one. `only_space`
    /// refuses anything but white space (and a byte order mark) before it.
    fn skip_to(&mut self, byte: u8, only_space: bool) -> Result<(u64, bool), VolumeError> {
        let start = self.position;
        loop {
            let buffer = self
                .reader
                .fill_buf()
                .map_err(|e| VolumeError::io(self.path, "read", e))?;
            let at = buffer.iter().position(|b| *b == byte);
            let passed = &buffer[..at.unwrap_or(buffer.len())];
            let odd = |b: &&u8| !b.is_ascii_whitespace() && !b"\xef\xbb\xbf".contains(b);
            if let Some(odd) = passed.iter().find(odd).filter(|_| only_space) {
                let found = format!("the byte {:?}", char::from(*odd));
                let expected = format!("{:?}", char::from(byte));
                return Err(VolumeError::field(self.path, "XML", found, expected));
            }
            let (n, end) = (passed.len(), buffer.is_empty());
            self.reader.consume(n);
            self.position += n as u64;
            if at.is_some() || end {
                return Ok((self.position - start, at.is_some()));
            }
        }
    }

    /// The tag that begins here; nothing for comments and other text that is passed over. A tag that
    /// the file's end cuts short is given as it is.
    fn tag(&mut self) -> Result<Option<String>, VolumeError> {
        let mut tag = Vec::new();
        let mut quote = None;
        loop {
            let buffer = self
                .reader
                .fill_buf()
                .map_err(|e| VolumeError::io(self.path, "read", e))?;
            let Some(&byte) = buffer.first() else { break };
            self.reader.consume(1);
            self.position += 1;
            tag.push(byte);
            if tag.len() > LIMIT {
                let found = "a tag of more than 1 MiB";
                return Err(VolumeError::field(self.path, "XML", found, "short tags"));
            }
            if tag.starts_with(b"<!--") || tag.starts_with(b"<![") {
                if tag.ends_with(b"-->") || tag.ends_with(b"]]>") {
                    return Ok(None);
                }
                continue;
            }
            match (byte, quote) {
                (b'>', None) => break,
                (b'"' | b'\'', None) => quote = Some(byte),
                (b, Some(q)) if b == q => quote = None,
                _ => {}
            }
        }
        Ok(Some(String::from_utf8_lossy(&tag).into_owned()))
    }
}
