//! From linear radiance to files.
//!
//! | format | holds | module |
//! |---|---|---|
//! | EXR | the radiance itself, 32-bit float, nothing lost | [`exr`] |
//! | PNG | what a display shows: exposed, tone-mapped, sRGB | [`png`] |
//! | JSON | settings, times, bytes, device | [`json`] |
//!
//! [`metrics`] says how far two images are apart.
//!
//! Every file goes through [`atomic`]: it is there whole, or it is not there.

pub mod atomic;
pub mod difference;
mod error;
pub mod exr;
mod image;
pub mod json;
pub mod metrics;
pub mod png;
pub mod tone_map;

pub use error::OutputError;
pub use image::{Display, Image, MAX_PIXELS, Variance};

use std::collections::BTreeMap;

/// What a picture says about itself: `scene`, `technique`, `device`, `driver` and their texts.
///
/// Keys are short lower-case ASCII words (the formats allow 1 to 79 bytes); values are any UTF-8.
pub type Metadata = BTreeMap<String, String>;

/// Name and version of this program as the files state it.
pub const SOFTWARE: &str = concat!("Tyndall ", env!("CARGO_PKG_VERSION"));
