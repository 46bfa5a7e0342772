//! Light from all around, as a picture of the whole sphere.

use std::f64::consts::{PI, TAU};
use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind, Read, Seek};
use std::path::Path;

use glam::{DVec2, DVec3, IVec2, Vec3};
use image::codecs::hdr::HdrDecoder;
use image::{ImageDecoder, ImageError};

use crate::output::{MAX_PIXELS, OutputError, exr};

/// Radiance from every direction, linear RGB, in latitude and longitude.
///
/// In map space +y is up. The top row looks up, the bottom row down; from left to right a row turns from
/// -z over +x, +z (the middle) and -x back to -z: the direction `d` is found at
/// `u = atan2(d.x, -d.z) / 2 pi` (modulo 1), `v = acos(d.y) / pi`. Between texel centres radiance is
/// interpolated bilinearly, around the seam too.
#[derive(Debug)]
pub struct LatLongMap {
    /// The file's name.
    pub name: String,
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
    /// Finite radiance of at least 0, row by row from the top left.
    pub texels: Vec<[f32; 3]>,
}

/// Maps are compared by identity, not by texel.
impl PartialEq for LatLongMap {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self, other)
    }
}

/// An environment map that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum LatLongMapError {
    /// The OpenEXR reader refused it.
    #[error(transparent)]
    Exr(#[from] OutputError),
    /// Anything else.
    #[error("{path}: {message}")]
    Other {
        /// The file.
        path: String,
        /// What was found and what was expected.
        message: String,
    },
}

impl LatLongMap {
    /// Reads an OpenEXR (`.exr`) or Radiance (`.hdr`) picture.
    ///
    /// # Errors
    /// It cannot be read, is neither of the two, has no texels or too many, or a texel that is negative,
    /// infinite or not a number.
    pub fn read(path: &Path) -> Result<Self, LatLongMapError> {
        let error = |message: String| LatLongMapError::Other {
            path: path.display().to_string(),
            message,
        };
        let (file, magic) = open(path).map_err(error)?;
        let (width, height, texels) = match &magic {
            [0x76, 0x2f, 0x31, 0x01] => {
                let image = exr::read(path)?;
                let texels = image.pixels.iter().map(|[r, g, b, _]| [*r, *g, *b]);
                (image.width, image.height, texels.collect())
            }
            b"#?RA" | b"#?RG" => read_hdr(file).map_err(error)?,
            _ => {
                let message = "found neither an OpenEXR (.exr) nor a Radiance (.hdr) picture";
                return Err(error(message.to_owned()));
            }
        };
        let bad = |t: &[f32; 3]| t.iter().any(|c| !(c.is_finite() && *c >= 0.0));
        if let Some(at) = texels.iter().position(bad) {
            let (x, y) = (at % width as usize, at / width as usize);
            return Err(error(format!(
                "found {:?} at column {x}, row {y}, expected finite radiance of at least 0",
                texels[at]
            )));
        }
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        Ok(Self {
            name: name.into_owned(),
            width,
            height,
            texels,
        })
    }

    /// Radiance from the unit direction `d` in map space.
    #[must_use]
    pub fn radiance(&self, d: DVec3) -> DVec3 {
        let u = (d.x.atan2(-d.z) / TAU).rem_euclid(1.0);
        let v = d.y.clamp(-1.0, 1.0).acos() / PI;
        let at = DVec2::new(u * f64::from(self.width), v * f64::from(self.height)) - 0.5;
        let (low, f) = (at.floor().as_ivec2(), at - at.floor());
        let texel = |dx, dy| self.texel(low + IVec2::new(dx, dy)).as_dvec3();
        let top = texel(0, 0).lerp(texel(1, 0), f.x);
        top.lerp(texel(0, 1).lerp(texel(1, 1), f.x), f.y)
    }

    /// Mean over all directions.
    #[must_use]
    pub fn mean(&self) -> DVec3 {
        let mut sum = DVec3::ZERO;
        for (y, row) in self.texels.chunks(self.width as usize).enumerate() {
            let height = f64::from(self.height);
            let [top, bottom] = [0, 1].map(|i| (PI * (y + i) as f64 / height).cos());
            let row: DVec3 = row.iter().map(|t| DVec3::from(t.map(f64::from))).sum();
            sum += 0.5 * (top - bottom) / f64::from(self.width) * row;
        }
        sum
    }

    /// A texel; columns go round, rows end.
    fn texel(&self, at: IVec2) -> Vec3 {
        let x = at.x.rem_euclid(self.width as i32) as usize;
        let y = at.y.clamp(0, self.height as i32 - 1) as usize;
        self.texels[y * self.width as usize + x].into()
    }
}

/// The file and its first four bytes.
fn open(path: &Path) -> Result<(BufReader<File>, [u8; 4]), String> {
    let failed = |e: std::io::Error| format!("cannot be opened: {e}");
    if !std::fs::metadata(path).map_err(failed)?.is_file() {
        // A named pipe would block for ever.
        return Err("found no regular file".to_owned());
    }
    let mut file = BufReader::new(File::open(path).map_err(failed)?);
    let mut magic = [0; 4];
    match file.read_exact(&mut magic) {
        Err(e) if e.kind() == ErrorKind::UnexpectedEof => {}
        result => result.map_err(|e| format!("cannot be read: {e}"))?,
    }
    file.rewind().map_err(|e| format!("cannot be read: {e}"))?;
    Ok((file, magic))
}

type Texels = (u32, u32, Vec<[f32; 3]>);

fn read_hdr(file: impl BufRead) -> Result<Texels, String> {
    let broken = |e: ImageError| format!("cannot be read: {e}");
    let decoder = HdrDecoder::new(file).map_err(broken)?;
    let (width, height) = decoder.dimensions();
    let size = u64::from(width) * u64::from(height);
    if !(1..=MAX_PIXELS).contains(&size) {
        return Err(format!(
            "found {width} x {height} texels, expected 1 to {MAX_PIXELS} in all"
        ));
    }
    let mut bytes = vec![0; usize::try_from(decoder.total_bytes()).unwrap_or(0)];
    decoder.read_image(&mut bytes).map_err(broken)?;
    let texels = bytes.chunks_exact(12).map(bytemuck::pod_read_unaligned);
    Ok((width, height, texels.collect()))
}
