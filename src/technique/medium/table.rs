//! The transfer function as a table over the volume's data range.

use std::borrow::Cow;

use crate::gpu::Limits;
use crate::scene::transfer_function::GradientAxis;
use crate::scene::{Scene, TransferFunction};

/// Most entries along values.
const MOST: u32 = 16384;

/// Size and data range of the transfer function's table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Table {
    /// Number of entries, at least 2.
    pub entries: u32,
    /// Data value of the first entry.
    pub min: f64,
    /// Data value of the last entry, > `min`.
    pub max: f64,
    /// The other axis of the table beside it, where gradients decide too; this one then holds the most that any
    /// gradient makes of a value.
    pub gradients: Option<GradientAxis>,
}

impl Table {
    /// Covers the data range with as many entries as the function's narrowest segment needs.
    #[must_use]
    pub fn choose(scene: &Scene, limits: &Limits) -> Self {
        let (min, mut max) = (scene.statistics.min, scene.statistics.max);
        if max <= min {
            // A constant volume: any range that starts at its value.
            max = min + min.abs().max(1.0);
        }
        let gradients = scene.medium.transfer_function.gradient_axis();
        let most = limits.max_image_1d.min(MOST) - 1;
        let entries = scene.medium.transfer_function.entries_needed(min, max);
        let entries = u32::try_from(entries).unwrap_or(u32::MAX).clamp(2, most);
        Self {
            entries,
            min,
            max,
            gradients,
        }
    }

    /// `(r, g, b, sigma_t)` for every entry.
    #[must_use]
    pub fn bake(&self, scene: &Scene) -> Vec<[f32; 4]> {
        let entries = self.entries as usize;
        self.function(scene)
            .bake(self.min, self.max, entries, scene.medium.density_scale)
    }

    /// The same for every value, fastest, and gradient, if gradients decide too.
    #[must_use]
    pub fn bake_gradients(&self, scene: &Scene) -> Option<Vec<[f32; 4]>> {
        let (range, entries) = ((self.min, self.max), self.entries as usize);
        let density_scale = scene.medium.density_scale;
        let function = self.function(scene);
        let bake = |axis| function.bake_gradients(range, entries, axis, density_scale);
        self.gradients.map(bake)
    }

    /// The function with nothing in it that falls between entries over values and gradients.
    fn function<'a>(&self, scene: &'a Scene) -> Cow<'a, TransferFunction> {
        let function = &scene.medium.transfer_function;
        let step = (self.max - self.min) / f64::from(self.entries - 1);
        match self.gradients {
            Some(axis) => Cow::Owned(function.widened(step, axis)),
            None => Cow::Borrowed(function),
        }
    }

    /// `entries + 1` running counts: element i counts entries below i with extinction.
    #[must_use]
    pub fn occupied_before(baked: &[[f32; 4]]) -> Vec<u32> {
        let mut count = 0;
        std::iter::once(0)
            .chain(baked.iter().map(|entry| {
                count += u32::from(entry[3] > 0.0);
                count
            }))
            .collect()
    }

    /// Whether an interval of data values exists that the function leaves empty: two neighbouring
    /// entries without extinction.
    #[must_use]
    pub fn has_empty_range(baked: &[[f32; 4]]) -> bool {
        baked.windows(2).any(|w| w[0][3] <= 0.0 && w[1][3] <= 0.0)
    }
}
