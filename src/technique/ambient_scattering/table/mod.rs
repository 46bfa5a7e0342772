//! The preintegration table: radiance out of a unit sphere that a front of light crosses
//! `[Ament2013, Sec. 4.1]`.
//!
//! `L_o(theta, sigma_t, g)` is kept as a part in closed form and a smooth one,
//! `L_o = unscattered + albedo * (1 - exp(-2 sigma_t)) * C`; see [`optics`] and the technique's README.

pub mod build;
pub mod check;
mod collided;
mod entries;
pub mod equal_error;
mod error;
pub mod format;
pub mod grid;
pub mod layout;
pub mod optics;
pub mod pack;
pub mod record;
pub mod reference;
pub mod shipped;
mod slice;
pub mod state;
pub mod sums;

pub use collided::Collided;
pub use entries::Table;
pub use error::TableError;
pub use grid::{Axis, Grid};
pub use layout::stage;
pub use shipped::{Shipped, shipped};
pub use slice::Slice;
pub use sums::{Request, Sums};
