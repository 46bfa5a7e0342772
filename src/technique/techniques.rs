//! All techniques in one enum: what the renderer asks of each. A new technique adds an arm to each
//! function here.

use super::ambient_occlusion::{self, AmbientOcclusion, AmbientOcclusionPlan};
use super::ambient_scattering::{self, AmbientScattering, AmbientScatteringPlan};
use super::half_angle::{self, HalfAngle, HalfAnglePlan};
use super::medium::{Medium, MediumPlan};
use super::path_trace::{self, PathTrace, PathTracePlan};
use super::ray_march::{self, RayMarch, RayMarchPlan};
use super::single_scatter::{self, SingleScatter, SingleScatterPlan};
use super::target::Target;
use super::{Inputs, Knobs, Plan, PlanError};
use crate::gpu::{Device, GpuError, Limits, StageTime};
use crate::scene::{
    AmbientOcclusionParams, AmbientScatteringParams, HalfAngleParams, PathTraceParams,
    RayMarchParams, Scene, SingleScatterParams, TechniqueParams,
};

/// Names of all techniques, as in scene files and on the command line.
pub const NAMES: &[&str] = &[
    ray_march::NAME,
    single_scatter::NAME,
    ambient_occlusion::NAME,
    ambient_scattering::NAME,
    half_angle::NAME,
    path_trace::NAME,
];

/// What each technique trades speed for accuracy with, for `tyndall study`.
pub const KNOBS: &[Knobs] = &[
    ray_march::KNOBS,
    single_scatter::KNOBS,
    ambient_occlusion::KNOBS,
    ambient_scattering::KNOBS,
    half_angle::KNOBS,
    path_trace::KNOBS,
];

/// What a technique is going to do for a scene: pure data.
#[derive(Clone, Debug, PartialEq)]
pub enum TechniquePlan {
    /// Emission-absorption and gradient shading.
    RayMarch(RayMarchPlan, RayMarchParams),
    /// The unbiased reference.
    PathTrace(PathTracePlan, PathTraceParams),
    /// Single scattering with shadows.
    SingleScatter(SingleScatterPlan, SingleScatterParams),
    /// Light from all around, dimmed by what is near.
    AmbientOcclusion(AmbientOcclusionPlan, AmbientOcclusionParams),
    /// Multiple scattering near every sample, from a table.
    AmbientScattering(Box<AmbientScatteringPlan>, AmbientScatteringParams),
    /// Light propagated slice by slice, half way between light and view.
    HalfAngle(Box<HalfAnglePlan>, HalfAngleParams),
}

/// A technique on the device.
pub enum Technique {
    /// Emission-absorption and gradient shading.
    RayMarch(Box<RayMarch>, RayMarchParams),
    /// The unbiased reference.
    PathTrace(Box<PathTrace>, PathTraceParams),
    /// Single scattering with shadows.
    SingleScatter(Box<SingleScatter>, SingleScatterParams),
    /// Light from all around, dimmed by what is near.
    AmbientOcclusion(Box<AmbientOcclusion>, AmbientOcclusionParams),
    /// Multiple scattering near every sample, from a table.
    AmbientScattering(Box<AmbientScattering>, AmbientScatteringParams),
    /// Light propagated slice by slice, half way between light and view.
    HalfAngle(Box<HalfAngle>, HalfAngleParams),
}

impl TechniquePlan {
    /// Plans the scene's technique.
    ///
    /// # Errors
    /// The scene exceeds a limit of the device or of a shader.
    pub fn new(scene: &Scene, limits: &Limits) -> Result<Self, PlanError> {
        match &scene.technique {
            TechniqueParams::RayMarch(params) => {
                ray_march::plan(scene, params, limits).map(|plan| Self::RayMarch(plan, *params))
            }
            TechniqueParams::PathTrace(params) => {
                path_trace::plan(scene, params, limits).map(|plan| Self::PathTrace(plan, *params))
            }
            TechniqueParams::SingleScatter(params) => single_scatter::plan(scene, params, limits)
                .map(|plan| Self::SingleScatter(plan, *params)),
            TechniqueParams::AmbientOcclusion(params) => {
                ambient_occlusion::plan(scene, params, limits)
                    .map(|plan| Self::AmbientOcclusion(plan, *params))
            }
            TechniqueParams::AmbientScattering(params) => {
                ambient_scattering::plan(scene, params, limits)
                    .map(|plan| Self::AmbientScattering(Box::new(plan), *params))
            }
            TechniqueParams::HalfAngle(params) => half_angle::plan(scene, params, limits)
                .map(|plan| Self::HalfAngle(Box::new(plan), params.clone())),
        }
    }

    /// The plan as shown to the user.
    #[must_use]
    pub fn summary(&self, scene: &Scene) -> Plan {
        match self {
            Self::RayMarch(plan, _) => plan.summary(scene),
            Self::PathTrace(plan, _) => plan.summary(scene),
            Self::SingleScatter(plan, _) => plan.summary(scene),
            Self::AmbientOcclusion(plan, _) => plan.summary(scene),
            Self::AmbientScattering(plan, _) => plan.summary(scene),
            Self::HalfAngle(plan, _) => plan.summary(scene),
        }
    }

    /// The medium's part.
    #[must_use]
    pub const fn medium(&self) -> &MediumPlan {
        match self {
            Self::RayMarch(plan, _) => &plan.medium,
            Self::PathTrace(plan, _) => &plan.medium,
            Self::SingleScatter(plan, _) => &plan.medium,
            Self::AmbientOcclusion(plan, _) => &plan.medium,
            Self::AmbientScattering(plan, _) => &plan.medium,
            Self::HalfAngle(plan, _) => &plan.medium,
        }
    }

    /// The stage that writes the image.
    #[must_use]
    pub fn image_stage(&self) -> &'static str {
        match self {
            Self::RayMarch(plan, _) => plan.march().shader.name,
            Self::PathTrace(plan, _) => plan.trace().shader.name,
            Self::SingleScatter(plan, _) => plan.march().shader.name,
            Self::AmbientOcclusion(plan, _) => plan.march().shader.name,
            Self::AmbientScattering(plan, _) => plan.march().shader.name,
            Self::HalfAngle(..) => half_angle::stage::SWEEP,
        }
    }

    /// The stage that copies the image to the host.
    #[must_use]
    pub const fn read_back_stage(&self) -> &'static str {
        match self {
            Self::RayMarch(..) => ray_march::stage::READ_BACK,
            Self::PathTrace(..) => path_trace::stage::READ_BACK,
            Self::SingleScatter(..) => single_scatter::stage::READ_BACK,
            Self::AmbientOcclusion(..) => ambient_occlusion::stage::READ_BACK,
            Self::AmbientScattering(..) => ambient_scattering::stage::READ_BACK,
            Self::HalfAngle(..) => half_angle::stage::READ_BACK,
        }
    }

    /// Creates what the plan asks for, or takes over from `old` what still fits.
    ///
    /// # Errors
    /// The driver's refusal or no memory.
    pub fn create(
        &self,
        device: &Device,
        medium: &Medium,
        target: &Target,
        old: Option<Technique>,
    ) -> Result<Technique, GpuError> {
        match self {
            Self::RayMarch(plan, params) => {
                let old = match old {
                    Some(Technique::RayMarch(old, _)) => Some(*old),
                    _ => None,
                };
                RayMarch::new(device, plan, medium, target, old)
                    .map(|technique| Technique::RayMarch(Box::new(technique), *params))
            }
            Self::PathTrace(plan, params) => {
                let old = match old {
                    Some(Technique::PathTrace(old, _)) => Some(*old),
                    _ => None,
                };
                PathTrace::new(device, plan, medium, target, old)
                    .map(|technique| Technique::PathTrace(Box::new(technique), *params))
            }
            Self::SingleScatter(plan, params) => {
                let old = match old {
                    Some(Technique::SingleScatter(old, _)) => Some(*old),
                    _ => None,
                };
                SingleScatter::new(device, plan, medium, target, old)
                    .map(|technique| Technique::SingleScatter(Box::new(technique), *params))
            }
            Self::AmbientOcclusion(plan, params) => {
                let old = match old {
                    Some(Technique::AmbientOcclusion(old, _)) => Some(*old),
                    _ => None,
                };
                AmbientOcclusion::new(device, plan, medium, target, old)
                    .map(|technique| Technique::AmbientOcclusion(Box::new(technique), *params))
            }
            Self::AmbientScattering(plan, params) => {
                let old = match old {
                    Some(Technique::AmbientScattering(old, _)) => Some(*old),
                    _ => None,
                };
                AmbientScattering::new(device, plan, medium, target, old)
                    .map(|technique| Technique::AmbientScattering(Box::new(technique), *params))
            }
            Self::HalfAngle(plan, params) => {
                let old = match old {
                    Some(Technique::HalfAngle(old, _)) => Some(*old),
                    _ => None,
                };
                HalfAngle::new(device, plan, medium, target, old)
                    .map(|technique| Technique::HalfAngle(Box::new(technique), params.clone()))
            }
        }
    }
}

impl Technique {
    /// Writes what the technique's shaders read of the scene beside view and medium.
    pub fn write_uniforms(&self, scene: &Scene, medium: &Medium) {
        match self {
            Self::RayMarch(technique, params) => technique.write_uniforms(scene, params, medium),
            Self::PathTrace(technique, _) => technique.write_uniforms(scene, medium),
            Self::SingleScatter(technique, params) => {
                technique.write_uniforms(scene, params, medium);
            }
            Self::AmbientOcclusion(technique, params) => {
                technique.write_uniforms(scene, params, medium);
            }
            // Its uniforms depend on its tables.
            Self::AmbientScattering(..) => {}
            // It writes them before each sweep.
            Self::HalfAngle(..) => {}
        }
    }

    /// Brings what the technique keeps on the device up to date; `changed` says what differs from the
    /// last frame; `progress(done, total)` counts pieces of work.
    ///
    /// # Errors
    /// The driver's refusal, no memory for staging, or a validation message.
    pub fn upload(
        &mut self,
        device: &Device,
        (scene, medium, target): (&Scene, &Medium, &Target),
        changed: Inputs,
        progress: &mut dyn FnMut(u64, u64),
    ) -> Result<Vec<StageTime>, GpuError> {
        match self {
            Self::RayMarch(..) => Ok(Vec::new()),
            Self::PathTrace(technique, _) => technique.upload(device, scene, medium, changed),
            Self::SingleScatter(technique, _) => {
                let mut times = technique.upload_albedo(device, scene)?;
                times.extend(single_scatter::record_light_cache(
                    device, technique, changed, progress,
                )?);
                Ok(times)
            }
            Self::AmbientOcclusion(technique, _) => {
                let mut times = technique.upload_albedo(device, scene)?;
                let of = (scene, medium, target);
                times.extend(ambient_occlusion::record_occlusion(
                    device, technique, of, changed, progress,
                )?);
                Ok(times)
            }
            Self::AmbientScattering(technique, params) => {
                let mut times = technique.upload(device, scene)?;
                technique.write_uniforms(scene, params, medium);
                let of = (scene, medium, target);
                times.extend(ambient_scattering::record_radiance_cache(
                    device, technique, of, changed, progress,
                )?);
                Ok(times)
            }
            Self::HalfAngle(technique, params) => {
                technique.prepare(scene, params, medium);
                technique.upload(device, scene, params)
            }
        }
    }

    /// Squared standard error of every pixel, RGB, where the technique estimates it; one sample
    /// tells nothing of it.
    ///
    /// # Errors
    /// The driver's refusal or no memory.
    pub fn variance(&self, device: &Device) -> Result<Option<Vec<[f32; 3]>>, GpuError> {
        match self {
            Self::RayMarch(..)
            | Self::SingleScatter(..)
            | Self::AmbientOcclusion(..)
            | Self::AmbientScattering(..)
            | Self::HalfAngle(..) => Ok(None),
            Self::PathTrace(technique, _) if technique.samples < 2 => Ok(None),
            Self::PathTrace(technique, _) => technique.variance(device).map(Some),
        }
    }

    /// Samples a pixel that the last image has, where there is chance in it.
    #[must_use]
    pub const fn samples(&self) -> Option<u32> {
        match self {
            Self::RayMarch(..)
            | Self::SingleScatter(..)
            | Self::AmbientOcclusion(..)
            | Self::AmbientScattering(..)
            | Self::HalfAngle(..) => None,
            Self::PathTrace(technique, _) => Some(technique.samples),
        }
    }

    /// Renders into the target; `progress(done, total)` counts pieces of work.
    ///
    /// # Errors
    /// The driver's refusal, a lost device, or a validation message.
    pub fn record(
        &mut self,
        device: &Device,
        progress: &mut dyn FnMut(u64, u64),
    ) -> Result<Vec<StageTime>, GpuError> {
        match self {
            Self::RayMarch(technique, _) => ray_march::record_march(device, technique, progress),
            Self::PathTrace(technique, params) => {
                path_trace::record_trace(device, technique, params, progress)
            }
            Self::SingleScatter(technique, _) => {
                single_scatter::record_march(device, technique, progress)
            }
            Self::AmbientOcclusion(technique, _) => {
                ambient_occlusion::record_march(device, technique, progress)
            }
            Self::AmbientScattering(technique, _) => {
                ambient_scattering::record_march(device, technique, progress)
            }
            Self::HalfAngle(technique, _) => half_angle::record_sweeps(device, technique, progress),
        }
    }
}
