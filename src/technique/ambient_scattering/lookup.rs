//! The tables as shaders read them: for one g, and for the albedo of each colour channel.

use glam::DVec3;

use super::slab::Slab;
use super::table::Shipped;
use super::table::optics::unscattered;
use crate::scene::{Gather, Tube};

/// Entries of the table along the angle: evenly by the sine of half of it, which resolves the forward peak.
pub(super) const ANGLES: usize = 128;

/// Entries of both tables along the optical depth: evenly by `log2(1 + depth)`.
pub(super) const DEPTHS: usize = 192;

/// Largest optical depth of a radius or of a tube's step that is told from larger ones.
pub(super) const DEEPEST: f64 = 1023.0;

/// Everything that decides the tables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// Mean cosine of the phase function.
    pub g: f64,
    /// Albedo of red, green and blue.
    pub albedo: DVec3,
    /// How light is dimmed in a tube.
    pub tube: Tube,
    /// How light is gathered.
    pub gather: Gather,
}

/// What of the tables is one number a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scalars {
    /// Logarithm of what a tube's step transmits in vacuum: 0 but for the paper's own.
    pub vacuum: f64,
    /// Dimming of a channel over the mean of all, at an optical depth of 1.
    pub dimming_ratio: DVec3,
}

/// Rows of texels, RGBA 32-bit float.
pub(super) struct Lookup {
    /// `[DEPTHS][ANGLES]` radiance that a sphere sends out per unit of a front's irradiance; without what
    /// passes unscattered, where gathering takes that from elsewhere. The fourth channel is the mean of the
    /// channels of `tube`, of the same depth.
    pub scattered: Vec<[f32; 4]>,
    /// `[DEPTHS]` share of an optical depth that dims light in a tube; the fourth channel is 0.
    pub tube: Vec<[f32; 4]>,
    /// What is one number a channel.
    pub scalars: Scalars,
}

impl Lookup {
    /// Evaluates the tables.
    #[must_use]
    pub(super) fn new(shipped: &Shipped, key: &Key) -> Self {
        let channels = key.albedo.to_array();
        // Channels of one albedo share their table.
        let first = channels.map(|a| channels.iter().position(|b| *b == a).unwrap_or(0));
        let mut parts: Vec<Channel> = Vec::new();
        for (i, albedo) in channels.into_iter().enumerate() {
            let part = match parts.get(first[i]) {
                Some(same) if first[i] < i => same.clone(),
                _ => Channel::new(shipped, key, albedo),
            };
            parts.push(part);
        }
        let texel = |of: &dyn Fn(&Channel) -> f64| {
            let mut rgba = [0.0; 4];
            for (to, part) in rgba.iter_mut().zip(&parts) {
                *to = of(part) as f32;
            }
            rgba
        };
        let mean = |i: usize| parts.iter().map(|c| c.tube[i]).sum::<f64>() / parts.len() as f64;
        let mut scattered: Vec<_> = (0..ANGLES * DEPTHS)
            .map(|i| texel(&|c| c.scattered[i]))
            .collect();
        for (i, texel) in scattered.iter_mut().enumerate() {
            texel[3] = mean(i / ANGLES) as f32;
        }
        let one = depths().position(|d| d >= 1.0).unwrap_or(0);
        let ratio = |c: &Channel| c.tube[one] / mean(one).max(f64::MIN_POSITIVE);
        Self {
            scattered,
            tube: (0..DEPTHS).map(|i| texel(&|c| c.tube[i])).collect(),
            scalars: Scalars {
                vacuum: parts.first().map_or(0.0, |c| c.vacuum),
                dimming_ratio: DVec3::from_slice(&parts.iter().map(ratio).collect::<Vec<_>>()),
            },
        }
    }
}

/// The tables of one albedo.
#[derive(Clone)]
struct Channel {
    scattered: Vec<f64>,
    tube: Vec<f64>,
    vacuum: f64,
}

impl Channel {
    fn new(shipped: &Shipped, key: &Key, albedo: f64) -> Self {
        let slice = shipped.slice(key.g, albedo);
        let elsewhere = |theta, depth| match key.gather {
            Gather::Split => unscattered(theta, depth, key.g),
            Gather::Literal => 0.0,
        };
        let mut scattered = Vec::with_capacity(ANGLES * DEPTHS);
        for depth in depths() {
            for i in 0..ANGLES {
                let theta = 2.0 * (i as f64 / (ANGLES - 1) as f64).asin();
                let radiance = slice.radiance(theta, depth) - elsewhere(theta, depth);
                scattered.push(radiance.max(0.0));
            }
        }
        let vacuum = unscattered(0.0, 0.0, key.g).ln();
        let straight = |depth: f64| {
            // Of a step of two radii, whose optical depth is `depth`.
            let passed = slice.radiance(0.0, 0.5 * depth).ln() - vacuum;
            if depth > 0.0 { -passed / depth } else { 0.0 }
        };
        let slab = Slab::new(albedo, key.g);
        let tube = depths().map(|depth| match key.tube {
            Tube::Slab => slab.dimming(depth),
            Tube::Normalized | Tube::Literal => straight(depth.max(1e-2)),
        });
        Self {
            scattered,
            tube: tube.collect(),
            vacuum: if key.tube == Tube::Literal {
                vacuum
            } else {
                0.0
            },
        }
    }
}

/// The optical depth of every entry.
fn depths() -> impl Iterator<Item = f64> {
    let octaves = (1.0 + DEEPEST).log2();
    (0..DEPTHS).map(move |i| (octaves * i as f64 / (DEPTHS - 1) as f64).exp2() - 1.0)
}

/// One over the octaves that the tables span.
#[must_use]
pub(super) fn per_octave() -> f64 {
    1.0 / (1.0 + DEEPEST).log2()
}
