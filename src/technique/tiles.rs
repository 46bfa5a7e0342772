//! Images marched in tiles of 8 x 8 pixels, and the dispatches that do it (`glsl/shared/tiles.glsl`).

use bytemuck::{Pod, Zeroable, bytes_of};
use glam::UVec3;

use crate::gpu::{
    Access, Binding, ComputePipeline, Device, GpuError, Image, Limits, Recorder, StageTime,
};
use crate::scene::ImageSettings;

/// Pixels along the edge of a tile.
const TILE: u32 = 8;

/// Invocations a tile, one a pixel.
const INVOCATIONS: u32 = TILE * TILE;

/// Tiles a dispatch: Vulkan guarantees 65,535 workgroups along x.
const MAX_TILES: u64 = 32_768;

/// Samples a submission: a desktop GPU that takes 1e9 a second stays responsive, and a software
/// driver answers every few seconds.
pub(super) const MAX_SAMPLES: u64 = 1 << 28;

/// How an image is marched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tiles {
    /// Tiles of the image.
    pub count: u32,
    /// Tiles a submission, so that none runs long.
    pub per_submission: u32,
    /// Sub-samples a pixel, one dispatch each.
    pub sub_samples: u32,
    /// Streams that the shader deals tiles out to.
    pub spread: u32,
}

/// Push constants of a march, or their beginning.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented in glsl/shared/tiles.glsl")]
pub struct TilePush {
    pub first_tile: u32,
    pub tile_count: u32,
    pub sub_sample: u32,
}

impl Tiles {
    /// Tiles of an image whose rays take up to `samples` samples a dispatch.
    #[must_use]
    pub(super) fn new(image: &ImageSettings, samples: f64, limits: &Limits) -> Self {
        let count = image.width.div_ceil(TILE) * image.height.div_ceil(TILE);
        let per_tile = samples.max(1.0) * f64::from(INVOCATIONS);
        let per_submission = (MAX_SAMPLES as f64 / per_tile) as u64;
        let per_submission = per_submission.clamp(1, MAX_TILES.min(u64::from(count)));
        Self {
            count,
            per_submission: u32::try_from(per_submission).unwrap_or(1),
            sub_samples: image.samples_per_axis * image.samples_per_axis,
            spread: limits.worker_threads,
        }
    }

    /// Submissions for each sub-sample.
    #[must_use]
    pub const fn bands(&self) -> u32 {
        self.count.div_ceil(self.per_submission)
    }

    /// `groups` rounded up to whole streams, as the shader deals them out.
    pub(super) const fn whole_streams(&self, groups: u32) -> u32 {
        groups.div_ceil(self.spread) * self.spread
    }

    /// Marches the whole image into `radiance`: one dispatch a band of tiles, sub-sample and range of `ranges`, each
    /// a submission; `push` adds the range's part to the push constants, `progress(done, total)` counts submissions.
    pub(super) fn record<P: Pod>(
        &self,
        device: &Device,
        (pipeline, binding): (&ComputePipeline, &Binding),
        radiance: &Image,
        (ranges, push): (u32, impl Fn(TilePush, u32) -> P),
        progress: &mut dyn FnMut(u64, u64),
    ) -> Result<StageTime, GpuError> {
        let name = pipeline.name();
        let total = self.bands() * self.sub_samples * ranges;
        let mut seconds = 0.0;
        for index in 0..total {
            let first_tile = index / (self.sub_samples * ranges) * self.per_submission;
            let tile_count = self.per_submission.min(self.count - first_tile);
            let tiles = TilePush {
                first_tile,
                tile_count,
                sub_sample: index / ranges % self.sub_samples,
            };
            let push = push(tiles, index % ranges);
            let mut recorder = Recorder::new(device)?;
            // RAW and WAW: sub-samples and ranges add to what the ones before wrote.
            recorder.image_barrier(radiance, Access::ComputeWrite, Access::ComputeReadWrite);
            recorder.compute_stage(name, |r| {
                let groups = self.whole_streams(tile_count);
                let domain = UVec3::new(groups * INVOCATIONS, 1, 1);
                r.dispatch(pipeline, binding, bytes_of(&push), domain);
            });
            seconds += recorder.submit()?.iter().map(|t| t.seconds).sum::<f64>();
            progress(u64::from(index) + 1, u64::from(total));
        }
        Ok(StageTime {
            name: name.to_owned(),
            seconds,
        })
    }
}
