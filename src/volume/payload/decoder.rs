//! Decompression of a payload as one stream of bytes.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};

use bzip2::bufread::BzDecoder;
use flate2::bufread::{GzDecoder, ZlibDecoder};

use super::Encoding;

/// The most bytes that one bzip2 block can decode to: 900,000 bytes of run lengths, where 5 bytes
/// stand for a run of at most 4 + 255.
const BZIP2_BLOCK: u64 = 900_000 / 5 * 259;
/// Fewer bytes than any bzip2 block takes (its magic, checksum, symbol map and code tables).
const BZIP2_BLOCK_MIN: u64 = 20;
/// Deflate codes at most 258 bytes in 2 bits.
pub(super) const DEFLATE_RATIO: u64 = 1032;

/// The most bytes that `len` bytes of compressed data can possibly decode to.
pub(super) fn decoded_limit(encoding: Encoding, len: u64) -> u64 {
    match encoding {
        Encoding::Raw | Encoding::Text | Encoding::Vtk(_) => len,
        Encoding::Gzip | Encoding::Zlib => len.saturating_mul(DEFLATE_RATIO),
        Encoding::Bzip2 => len.div_ceil(BZIP2_BLOCK_MIN).saturating_mul(BZIP2_BLOCK),
    }
}

/// One compressed stream, of the kinds that may follow each other in a file.
enum Member {
    Gzip(GzDecoder<BufReader<File>>),
    Zlib(ZlibDecoder<BufReader<File>>),
    Bzip2(BzDecoder<BufReader<File>>),
}

/// Decodes concatenated streams (as `pigz` and `pbzip2` write them) as one.
///
/// Whatever follows the last stream is ignored. A stream that stops early gives
/// [`io::ErrorKind::UnexpectedEof`]; a damaged one, or one whose checksum is wrong, gives
/// [`io::ErrorKind::InvalidInput`] or [`io::ErrorKind::InvalidData`].
pub(super) struct Decoder {
    member: Option<Member>,
}

impl Decoder {
    /// Decodes `reader` from where it stands; nothing for an encoding that is not compressed.
    pub(super) fn new(encoding: Encoding, reader: BufReader<File>) -> Self {
        Self {
            member: Self::start(encoding, reader),
        }
    }

    fn start(encoding: Encoding, reader: BufReader<File>) -> Option<Member> {
        match encoding {
            Encoding::Gzip => Some(Member::Gzip(GzDecoder::new(reader))),
            Encoding::Zlib => Some(Member::Zlib(ZlibDecoder::new(reader))),
            Encoding::Bzip2 => Some(Member::Bzip2(BzDecoder::new(reader))),
            Encoding::Raw | Encoding::Text | Encoding::Vtk(_) => None,
        }
    }

    /// Goes on with the stream that follows the one just ended, if there is one.
    fn next_member(member: Member) -> io::Result<Option<Member>> {
        let (encoding, magic, mut reader): (_, &[u8], _) = match member {
            Member::Gzip(d) => (Encoding::Gzip, &[0x1f, 0x8b], d.into_inner()),
            Member::Bzip2(d) => (Encoding::Bzip2, b"BZh", d.into_inner()),
            // Nothing writes concatenated zlib streams.
            Member::Zlib(_) => return Ok(None),
        };
        let ahead = reader.fill_buf()?;
        // The magic may lie across the end of the buffer, hence the comparison of what there is.
        let known = ahead.len().min(magic.len());
        if known == 0 || ahead[..known] != magic[..known] {
            return Ok(None);
        }
        Ok(Self::start(encoding, reader))
    }
}

impl Read for Decoder {
    fn read(&mut self, buf: &mut [u8]) -> io::Result<usize> {
        if buf.is_empty() {
            return Ok(0);
        }
        // Ends: every further member takes bytes of the file.
        while let Some(member) = &mut self.member {
            let n = match member {
                Member::Gzip(d) => d.read(buf)?,
                Member::Zlib(d) => d.read(buf)?,
                Member::Bzip2(d) => d.read(buf)?,
            };
            if n > 0 {
                return Ok(n);
            }
            self.member = match self.member.take() {
                Some(done) => Self::next_member(done)?,
                None => None,
            };
        }
        Ok(0)
    }
}
