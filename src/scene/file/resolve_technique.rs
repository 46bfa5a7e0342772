//! From what a scene file says of techniques to their parameters.

use std::sync::Arc;

use super::SceneFile;
use super::spec_technique::{RadiusSpec, ShadingSpec, TechniqueName, TransportSpec};
use crate::scene::{
    AmbientOcclusionParams, AmbientScatteringParams, HalfAngleParams, PathTraceParams, Radius,
    RayMarchParams, Shading, SingleScatterParams, TechniqueParams, TransportColor,
};

/// Samples a pixel where another goal ends the work.
const MAX_SAMPLES: u32 = 1 << 20;

impl SceneFile {
    /// The technique and its parameters.
    #[must_use]
    pub fn technique(&self) -> TechniqueParams {
        match self.spec.technique.name {
            None | Some(TechniqueName::RayMarch) => TechniqueParams::RayMarch(self.ray_march()),
            Some(TechniqueName::PathTrace) => TechniqueParams::PathTrace(self.path_trace()),
            Some(TechniqueName::SingleScatter) => {
                TechniqueParams::SingleScatter(self.single_scatter())
            }
            Some(TechniqueName::AmbientOcclusion) => {
                TechniqueParams::AmbientOcclusion(self.ambient_occlusion())
            }
            Some(TechniqueName::AmbientScattering) => {
                TechniqueParams::AmbientScattering(self.ambient_scattering())
            }
            Some(TechniqueName::HalfAngle) => TechniqueParams::HalfAngle(self.half_angle()),
        }
    }

    fn single_scatter(&self) -> SingleScatterParams {
        let s = &self.spec.technique.single_scatter;
        let d = SingleScatterParams::default();
        SingleScatterParams {
            step: s.step.unwrap_or(d.step),
            shadow_step: s.shadow_step.unwrap_or(d.shadow_step),
            cache: s.cache.unwrap_or(d.cache),
            early_termination: s.early_termination.unwrap_or(d.early_termination),
            empty_space_skipping: s.empty_space_skipping.unwrap_or(d.empty_space_skipping),
        }
    }

    fn ambient_occlusion(&self) -> AmbientOcclusionParams {
        let s = &self.spec.technique.ambient_occlusion;
        let d = AmbientOcclusionParams::default();
        AmbientOcclusionParams {
            step: s.step.unwrap_or(d.step),
            radius: s.radius.map_or(d.radius, radius),
            early_termination: s.early_termination.unwrap_or(d.early_termination),
            empty_space_skipping: s.empty_space_skipping.unwrap_or(d.empty_space_skipping),
        }
    }

    fn ambient_scattering(&self) -> AmbientScatteringParams {
        let s = &self.spec.technique.ambient_scattering;
        let d = AmbientScatteringParams::default();
        AmbientScatteringParams {
            step: s.step.unwrap_or(d.step),
            radius: s.radius.map_or(d.radius, radius),
            tube: s.tube.unwrap_or(d.tube),
            gather: s.gather.unwrap_or(d.gather),
            cache: s.cache.unwrap_or(d.cache),
            specular: s.specular.unwrap_or(d.specular),
            shininess: s.shininess.unwrap_or(d.shininess),
            occlusion_radius: s.occlusion_radius.map_or(d.occlusion_radius, radius),
            early_termination: s.early_termination.unwrap_or(d.early_termination),
            empty_space_skipping: s.empty_space_skipping.unwrap_or(d.empty_space_skipping),
        }
    }

    fn half_angle(&self) -> HalfAngleParams {
        let (s, d) = (&self.spec.technique.half_angle, HalfAngleParams::default());
        HalfAngleParams {
            slice_spacing: s.slice_spacing.unwrap_or(d.slice_spacing),
            light_buffer: s.light_buffer.or(d.light_buffer),
            lighting: s.lighting.unwrap_or(d.lighting),
            transport_color: s
                .transport_color
                .as_ref()
                .map_or(d.transport_color, transport_color),
            blur_angle_deg: s.blur_angle_deg.unwrap_or(d.blur_angle_deg),
            blur_samples: s.blur_samples.unwrap_or(d.blur_samples),
            phase_table: s.phase_table.as_deref().map(Arc::from),
            surface: s.surface.unwrap_or(d.surface),
            surface_gradient: s.surface_gradient.unwrap_or(d.surface_gradient),
            specular: s.specular.unwrap_or(d.specular),
            shininess: s.shininess.unwrap_or(d.shininess),
            early_termination: s.early_termination.unwrap_or(d.early_termination),
            empty_space_skipping: s.empty_space_skipping.unwrap_or(d.empty_space_skipping),
        }
    }

    fn path_trace(&self) -> PathTraceParams {
        let (p, d) = (&self.spec.technique.path_trace, PathTraceParams::default());
        PathTraceParams {
            samples: match (p.samples, p.seconds, p.target_error) {
                (Some(samples), ..) => samples,
                (None, None, None) => d.samples,
                _ => MAX_SAMPLES,
            },
            seconds: p.seconds,
            target_error: p.target_error,
            max_scatter: p.max_scatter,
            seed: p.seed.unwrap_or(d.seed),
        }
    }

    fn ray_march(&self) -> RayMarchParams {
        let (r, d) = (&self.spec.technique.ray_march, RayMarchParams::default());
        RayMarchParams {
            step: r.step.unwrap_or(d.step),
            shading: match r.shading {
                None | Some(ShadingSpec::Switch(true)) => d.shading,
                Some(ShadingSpec::Switch(false)) => None,
                Some(ShadingSpec::Factors(f)) => {
                    let s = Shading::default();
                    Some(Shading {
                        ambient: f.ambient.unwrap_or(s.ambient),
                        diffuse: f.diffuse.unwrap_or(s.diffuse),
                        specular: f.specular.unwrap_or(s.specular),
                        shininess: f.shininess.unwrap_or(s.shininess),
                        merge_opacity: f.merge_opacity.unwrap_or(s.merge_opacity),
                    })
                }
            },
            early_termination: r.early_termination.unwrap_or(d.early_termination),
            empty_space_skipping: r.empty_space_skipping.unwrap_or(d.empty_space_skipping),
        }
    }
}

fn transport_color(spec: &TransportSpec) -> TransportColor {
    match spec {
        TransportSpec::Word(_) => TransportColor::Auto,
        TransportSpec::Color([r, g, b]) => TransportColor::Points(Arc::new([[0.0, *r, *g, *b]])),
        TransportSpec::Points(rows) => TransportColor::Points(Arc::from(rows.as_slice())),
    }
}

const fn radius(spec: RadiusSpec) -> Radius {
    match spec {
        RadiusSpec::Word(_) => Radius::Auto,
        RadiusSpec::Voxels(voxels) => Radius::Voxels(voxels),
        RadiusSpec::World(length) => Radius::World(length.world),
    }
}
