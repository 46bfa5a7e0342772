//! How far an image is from a reference, by the measures that papers and reviewers use.
//!
//! | measure | of | module |
//! |---|---|---|
//! | RMSE, relative MSE, bias, largest difference | the values themselves | [`errors()`] |
//! | PSNR | the values themselves | [`psnr()`] |
//! | SSIM | display values | [`ssim()`] |
//! | LDR-FLIP | display values | [`flip::ldr_flip`] |
//! | HDR-FLIP | radiance | [`flip::hdr_flip`] |
//! | z-score | radiance with variances | [`z_score()`] |
//!
//! [`compare_images`] and [`compare_displays`] take all that two images allow.

mod check;
mod compare;
mod errors;
mod filter;
pub mod flip;
mod psnr;
mod ssim;
mod z_score;

pub use check::{CompareError, Side};
pub use compare::{
    CompareOptions, Comparison, Estimate, HdrFlip, Pooled, Shown, compare_displays, compare_images,
};
pub use errors::{Errors, LargestDifference, RELATIVE_EPSILON, Values, errors};
pub use psnr::psnr;
pub use ssim::ssim;
pub use z_score::{Exact, LargestZ, ZScore, probability_among, z_score};

use check::Size;
