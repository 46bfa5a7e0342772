//! The driver's compiled pipelines, kept on disk between runs.

use std::path::PathBuf;

use ash::vk;

use super::GpuError;
use super::error::Context;

/// A `VkPipelineCache` backed by a file named after the driver's cache UUID.
pub(super) struct PipelineCache {
    pub(super) raw: vk::PipelineCache,
    file: Option<PathBuf>,
}

impl PipelineCache {
    /// The user's cache folder.
    pub(super) fn default_folder() -> Option<PathBuf> {
        directories::ProjectDirs::from("", "", "tyndall").map(|d| d.cache_dir().to_owned())
    }

    /// Loads the cache of this driver. The driver checks the data's header and ignores foreign data.
    pub(super) fn new(
        device: &ash::Device,
        key: &str,
        folder: Option<PathBuf>,
    ) -> Result<Self, GpuError> {
        let file = folder.map(|f| f.join(format!("pipelines-{key}.bin")));
        let data = file
            .as_ref()
            .and_then(|f| std::fs::read(f).ok())
            .unwrap_or_default();
        let info = vk::PipelineCacheCreateInfo::default().initial_data(&data);
        // SAFETY: `data` lives until the call returns.
        let raw = unsafe { device.create_pipeline_cache(&info, None) }
            .context("vkCreatePipelineCache", "pipelines")?;
        Ok(Self { raw, file })
    }

    /// Writes the cache through a temporary file, so that parallel runs never see half of it.
    pub(super) fn save(&self, device: &ash::Device) {
        let Some(file) = &self.file else { return };
        // SAFETY: `raw` belongs to `device`.
        let Ok(data) = (unsafe { device.get_pipeline_cache_data(self.raw) }) else {
            return;
        };
        let temporary = file.with_extension(format!("{}.tmp", std::process::id()));
        let written = file
            .parent()
            .is_some_and(|folder| std::fs::create_dir_all(folder).is_ok())
            && std::fs::write(&temporary, data).is_ok()
            && std::fs::rename(&temporary, file).is_ok();
        if !written {
            let _ = std::fs::remove_file(&temporary);
        }
    }

    /// # Safety
    /// `device` made the cache and no call uses it any more.
    pub(super) unsafe fn destroy(self, device: &ash::Device) {
        // SAFETY: the caller's promise.
        unsafe { device.destroy_pipeline_cache(self.raw, None) };
    }
}
