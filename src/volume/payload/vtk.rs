//! Arrays of VTK's XML files: text, or bytes behind a header, in base64 or not, in zlib blocks or not.
//!
//! The header of plain bytes is their number. Of zlib blocks it is: number of blocks, bytes of a
//! decoded block, bytes of the last one (0: a whole one), and the bytes that each takes in the file.

use std::io::{self, BufRead, BufReader, Read};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::bufread::ZlibDecoder;

use super::decoder::DEFLATE_RATIO;

/// Base64 decoded at a time, in characters.
const BASE64_CHUNK: usize = 1 << 16;

/// How and where an array is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::volume) struct Vtk {
    /// How.
    pub layout: VtkLayout,
    /// Bytes of the file that it takes at most.
    pub bytes: u64,
}

/// How an array is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::volume) enum VtkLayout {
    /// Numbers between white space.
    Text,
    /// Bytes behind a header.
    Bytes {
        /// Header and data are base64, which may pad between them.
        base64: bool,
        /// The data is zlib blocks.
        zlib: bool,
        /// The header's words have 8 bytes, not 4.
        wide: bool,
        /// The header's words are in big-endian order.
        big_endian: bool,
    },
}

/// An array, ready to be read.
pub(super) enum Opened<R> {
    /// Numbers.
    Text(R),
    /// The decoded bytes of the voxels.
    Bytes(Box<dyn Read>),
}

/// Why the array's header cannot be used.
pub(super) enum OpenError {
    /// It ends early, or the operating system refused.
    Io(io::Error),
    /// What it says is not what was expected.
    Contradiction(String),
}

impl From<io::Error> for OpenError {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

impl Vtk {
    pub(super) fn name(self) -> &'static str {
        match self.layout {
            VtkLayout::Text => "text",
            VtkLayout::Bytes { zlib: true, .. } => "zlib",
            VtkLayout::Bytes { base64: true, .. } => "base64",
            VtkLayout::Bytes { .. } => "raw",
        }
    }

    /// Whether `there` bytes of the file can hold `voxels` numbers or `needed` bytes, and what there is.
    pub(super) fn check_length(self, there: u64, voxels: u64, needed: u64) -> (bool, String) {
        let there = there.min(self.bytes);
        let VtkLayout::Bytes { base64, zlib, .. } = self.layout else {
            let found = format!("{there} bytes of text");
            return (there.div_ceil(2) >= voxels, found);
        };
        let bytes = if base64 { there / 4 * 3 + 3 } else { there };
        let most = match zlib {
            true => bytes.saturating_mul(DEFLATE_RATIO),
            false => bytes,
        };
        let name = self.name();
        let found = format!(
            "{there} bytes of {name} data, which decode to at most {most} bytes (truncated file?)"
        );
        (most >= needed, found)
    }

    /// Reads the header, which must promise `wanted` bytes. `file` ends where the array must.
    pub(super) fn open<R: BufRead + 'static>(
        self,
        file: R,
        wanted: u64,
    ) -> Result<Opened<R>, OpenError> {
        let VtkLayout::Bytes {
            base64,
            zlib,
            wide,
            big_endian,
        } = self.layout
        else {
            return Ok(Opened::Text(file));
        };
        let mut bytes: Box<dyn BufRead> = match base64 {
            true => Box::new(BufReader::new(Base64::new(file))),
            false => Box::new(file),
        };
        if zlib {
            let blocks = Blocks::open(bytes, wanted, wide, big_endian)?;
            return Ok(Opened::Bytes(Box::new(blocks)));
        }
        let promised = word(&mut bytes, wide, big_endian)?;
        if promised != wanted {
            let found = format!("an array of {promised} bytes");
            return Err(OpenError::Contradiction(found));
        }
        Ok(Opened::Bytes(Box::new(bytes.take(wanted))))
    }
}

/// One word of a header.
fn word(reader: &mut impl Read, wide: bool, big_endian: bool) -> io::Result<u64> {
    let mut bytes = [0; 8];
    let bytes = &mut bytes[..if wide { 8 } else { 4 }];
    reader.read_exact(bytes)?;
    if big_endian {
        bytes.reverse();
    }
    Ok(bytes.iter().rev().fold(0, |n, b| n << 8 | u64::from(*b)))
}

fn corrupt(why: &'static str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, why)
}

/// Zlib blocks, decoded one after the other.
struct Blocks {
    // Bytes in the file of the blocks to come.
    sizes: std::vec::IntoIter<u64>,
    // Decoded bytes of a block, and of all blocks that are left.
    block: u64,
    left: u64,
    state: State,
}

enum State {
    Between(Box<dyn BufRead>),
    // With the decoded bytes that are still to come.
    Inside(ZlibDecoder<io::Take<Box<dyn BufRead>>>, u64),
    // After an error.
    Broken,
}

impl Blocks {
    fn open(
        mut bytes: Box<dyn BufRead>,
        wanted: u64,
        wide: bool,
        big_endian: bool,
    ) -> Result<Self, OpenError> {
        let mut next = || word(&mut bytes, wide, big_endian);
        let (count, block, last) = (next()?, next()?, next()?);
        let whole = if last == 0 {
            count
        } else {
            count.saturating_sub(1)
        };
        let promised = whole.checked_mul(block).and_then(|n| n.checked_add(last));
        if promised != Some(wanted) || last > block {
            return Err(OpenError::Contradiction(format!(
                "{count} blocks of {block} bytes, the last of {last}"
            )));
        }
        // No more than the file holds: reading ends where the file does.
        let mut sizes = Vec::new();
        for _ in 0..count {
            sizes.push(next()?);
        }
        Ok(Self {
            sizes: sizes.into_iter(),
            block,
            left: wanted,
            state: State::Between(bytes),
        })
    }

    /// Decodes a part of the block that the file stands in.
    fn step(&mut self, buf: &mut [u8]) -> io::Result<usize> {
        match std::mem::replace(&mut self.state, State::Broken) {
            State::Between(bytes) => {
                let Some(size) = self.sizes.next() else {
                    self.state = State::Between(bytes);
                    return Ok(0);
                };
                let inside = self.block.min(self.left);
                self.state = State::Inside(ZlibDecoder::new(bytes.take(size)), inside);
                self.step(buf)
            }
            State::Inside(mut decoder, 0) => {
                // One byte more makes the decoder check the checksum.
                if decoder.read(&mut [0])? > 0 {
                    return Err(corrupt("a block of more bytes than the header says"));
                }
                let mut rest = decoder.into_inner();
                io::copy(&mut rest, &mut io::sink())?;
                self.state = State::Between(rest.into_inner());
                self.step(buf)
            }
            State::Inside(mut decoder, inside) => {
                let most = buf.len().min(usize::try_from(inside).unwrap_or(usize::MAX));
                let n = decoder.read(&mut buf[..most])?;
                if n == 0 {
                    return Err(io::ErrorKind::UnexpectedEof.into());
                }
                self.left -= n as u64;
                self.state = State::Inside(decoder, inside - n as u64);
                Ok(n)
            }
            State::Broken => Err(corrupt("read on after an error")),
        }
    }
}

impl Read for Blocks {
    fn read(&mut self, buf: &mut [u8]) -> io::Result<usize> {
        if buf.is_empty() {
            return Ok(0);
        }
        self.step(buf)
    }
}

/// Decodes base64; white space is passed over, and padding may stand at the end of any four characters.
struct Base64<R> {
    text: R,
    // Decoded bytes, and how many of them are given.
    decoded: Vec<u8>,
    given: usize,
}

impl<R: BufRead> Base64<R> {
    fn new(text: R) -> Self {
        Self {
            text,
            decoded: Vec::new(),
            given: 0,
        }
    }

    /// Decodes the next characters; nothing at the end of the text.
    fn refill(&mut self) -> io::Result<()> {
        let mut characters = Vec::with_capacity(BASE64_CHUNK);
        let mut padded = false;
        while characters.len() < BASE64_CHUNK && !(padded && characters.len() % 4 == 0) {
            let buffer = self.text.fill_buf()?;
            let Some(&byte) = buffer.first() else { break };
            // Appended data ends at the next tag.
            if byte == b'<' {
                break;
            }
            self.text.consume(1);
            if !byte.is_ascii_whitespace() {
                characters.push(byte);
                padded |= byte == b'=';
            }
        }
        self.given = 0;
        self.decoded.clear();
        if characters.len() % 4 != 0 {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        STANDARD
            .decode_vec(&characters, &mut self.decoded)
            .map_err(|_| corrupt("characters that are no base64"))
    }
}

impl<R: BufRead> Read for Base64<R> {
    fn read(&mut self, buf: &mut [u8]) -> io::Result<usize> {
        if self.given == self.decoded.len() {
            self.refill()?;
        }
        let n = buf.len().min(self.decoded.len() - self.given);
        buf[..n].copy_from_slice(&self.decoded[self.given..self.given + n]);
        self.given += n;
        Ok(n)
    }
}
