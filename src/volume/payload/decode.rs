//! From the file's bytes to the typed array.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::str::FromStr;

use bytemuck::Pod;

use super::vtk::{OpenError, Opened};
use super::{Payload, Size, Vtk, text};
use crate::volume::VolumeError;
use crate::volume::read::Progress;

/// Bytes decoded between two progress reports.
const CHUNK: usize = 4 << 20;
/// First allocation for data whose decoded size is only claimed.
const FIRST_RESERVE: usize = 16 << 20;

impl Payload {
    pub(super) fn read_raw<T: Pod>(
        &self,
        mut file: File,
        size: Size,
        progress: Progress<'_>,
    ) -> Result<Vec<T>, VolumeError> {
        let skip = i64::try_from(size.skip).unwrap_or(i64::MAX);
        file.seek(SeekFrom::Current(skip))
            .map_err(|e| VolumeError::io(&self.path, "read", e))?;
        // The file is as long as it claims: one allocation of the exact size.
        self.collect(&mut file, size, size.voxels, 0, progress)
    }

    pub(super) fn read_compressed<T: Pod>(
        &self,
        mut decoder: impl Read,
        size: Size,
        progress: Progress<'_>,
    ) -> Result<Vec<T>, VolumeError> {
        let mut scratch = vec![0; CHUNK.min(usize::try_from(size.skip).unwrap_or(CHUNK))];
        let mut done = 0;
        while done < size.skip {
            let n = scratch
                .len()
                .min(usize::try_from(size.skip - done).unwrap_or(CHUNK));
            self.fill(&mut decoder, &mut scratch[..n], size, done)?;
            done += n as u64;
            progress(done, size.skip + size.wanted);
        }
        let first = FIRST_RESERVE / size_of::<T>();
        let voxels = self.collect(&mut decoder, size, first, size.skip, progress)?;
        // One byte more makes the decoder check the checksum if the stream ends here.
        match io::copy(&mut decoder.take(1), &mut io::sink()) {
            Ok(_) => Ok(voxels),
            Err(e) => Err(self.stream_error(e, size, size.skip + size.wanted)),
        }
    }

    pub(super) fn read_vtk<T: Pod + FromStr>(
        &self,
        vtk: Vtk,
        file: File,
        size: Size,
        progress: Progress<'_>,
    ) -> Result<Vec<T>, VolumeError> {
        let reader = BufReader::with_capacity(1 << 16, file.take(vtk.bytes));
        match vtk.open(reader, size.wanted) {
            Ok(Opened::Text(text)) => self.read_text(text, size, progress),
            Ok(Opened::Bytes(bytes)) => self.read_compressed(bytes, size, progress),
            Err(OpenError::Io(e)) => Err(self.stream_error(e, size, 0)),
            Err(OpenError::Contradiction(found)) => Err(self.error(found, &self.claim(size))),
        }
    }

    /// Reads the wanted voxels; `reserve` is the first allocation, in voxels, and `before` the
    /// decoded bytes already passed over.
    fn collect<T: Pod>(
        &self,
        reader: &mut impl Read,
        size: Size,
        reserve: usize,
        before: u64,
        progress: Progress<'_>,
    ) -> Result<Vec<T>, VolumeError> {
        let mut voxels = Vec::<T>::new();
        self.reserve(&mut voxels, reserve.min(size.voxels), size)?;
        let mut done = before;
        while voxels.len() < size.voxels {
            let at = voxels.len();
            let n = (CHUNK / size_of::<T>()).min(size.voxels - at);
            self.grow(&mut voxels, n, size)?;
            voxels.resize(at + n, T::zeroed());
            let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut voxels[at..]);
            self.fill(reader, bytes, size, done)?;
            if self.big_endian != cfg!(target_endian = "big") {
                swap_bytes(bytes, size_of::<T>());
            }
            done += bytes.len() as u64;
            progress(done, before + size.wanted);
        }
        Ok(voxels)
    }

    pub(super) fn read_text<T: Pod + FromStr>(
        &self,
        mut reader: impl BufRead,
        size: Size,
        progress: Progress<'_>,
    ) -> Result<Vec<T>, VolumeError> {
        let mut token = Vec::new();
        for _ in 0..self.skip_voxels {
            text::next_number::<f64>(&mut reader, &mut token)
                .map_err(|e| self.text_error(e, size, 0))?;
        }
        let mut voxels = Vec::<T>::new();
        while voxels.len() < size.voxels {
            let n = (CHUNK / size_of::<T>()).min(size.voxels - voxels.len());
            self.grow(&mut voxels, n, size)?;
            for _ in 0..n {
                let value = text::next_number(&mut reader, &mut token)
                    .map_err(|e| self.text_error(e, size, voxels.len()))?;
                voxels.push(value);
            }
            progress((voxels.len() * size_of::<T>()) as u64, size.wanted);
        }
        Ok(voxels)
    }

    /// Makes room for `n` more voxels, doubling up to the wanted size.
    fn grow<T>(&self, voxels: &mut Vec<T>, n: usize, size: Size) -> Result<(), VolumeError> {
        let needed = voxels.len() + n;
        if needed <= voxels.capacity() {
            return Ok(());
        }
        let capacity = needed
            .max(voxels.capacity().saturating_mul(2))
            .min(size.voxels);
        self.reserve(voxels, capacity - voxels.len(), size)
    }

    fn reserve<T>(&self, voxels: &mut Vec<T>, n: usize, size: Size) -> Result<(), VolumeError> {
        voxels
            .try_reserve_exact(n)
            .map_err(|_| VolumeError::OutOfMemory {
                path: self.path.clone(),
                bytes: size.wanted,
            })
    }

    /// Fills `buf`; `done` bytes were decoded before.
    fn fill(
        &self,
        reader: &mut impl Read,
        buf: &mut [u8],
        size: Size,
        done: u64,
    ) -> Result<(), VolumeError> {
        let mut filled = 0;
        while filled < buf.len() {
            match reader.read(&mut buf[filled..]) {
                Ok(0) => {
                    let found = format!(
                        "{} data that ends after {} decoded bytes",
                        self.encoding.name(),
                        done + filled as u64
                    );
                    return Err(self.error(found, &self.claim(size)));
                }
                Ok(n) => filled += n,
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) => return Err(self.stream_error(e, size, done + filled as u64)),
            }
        }
        Ok(())
    }
}

/// Reverses the bytes of every `width`-byte element.
fn swap_bytes(bytes: &mut [u8], width: usize) {
    fn swap<const N: usize>(bytes: &mut [u8]) {
        for element in bytes.as_chunks_mut::<N>().0 {
            element.reverse();
        }
    }
    match width {
        2 => swap::<2>(bytes),
        4 => swap::<4>(bytes),
        8 => swap::<8>(bytes),
        _ => {}
    }
}
