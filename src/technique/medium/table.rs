//! The transfer function as a table over the volume's data range.

use crate::scene::Scene;

/// Size and data range of the transfer function's table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Table {
    /// Number of entries, at least 2.
    pub entries: u32,
    /// Data value of the first entry.
    pub min: f64,
    /// Data value of the last entry, > `min`.
    pub max: f64,
}

impl Table {
    /// Covers the data range with as many entries as the function's narrowest segment needs.
    #[must_use]
    pub fn choose(scene: &Scene, max_entries: u32) -> Self {
        let (min, mut max) = (scene.statistics.min, scene.statistics.max);
        if max <= min {
            // A constant volume: any range that starts at its value.
            max = min + min.abs().max(1.0);
        }
        let entries = scene.medium.transfer_function.entries_needed(min, max);
        let entries = u32::try_from(entries)
            .unwrap_or(u32::MAX)
            .clamp(2, max_entries);
        Self { entries, min, max }
    }

    /// `(r, g, b, sigma_t)` for every entry.
    #[must_use]
    pub fn bake(&self, scene: &Scene) -> Vec<[f32; 4]> {
        scene.medium.transfer_function.bake(
            self.min,
            self.max,
            self.entries as usize,
            scene.medium.density_scale,
        )
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
