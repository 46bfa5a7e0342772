//! Scenes at the extremes, and what theory says of their images: where a technique stops being
//! trustworthy.
//!
//! [`extremes`] lists the scenes, [`subjects`] the techniques as they are put to them, [`examine`]
//! renders one and compares. `tests/stability.rs` asserts what `tyndall study --extremes` prints.

mod expect;
mod half_space;
mod lights;
mod media;
mod places;
mod scenes;

pub use expect::{Model, model};

use glam::Vec3;
use serde::Serialize;

use crate::gpu::Device;
use crate::scene::{
    AmbientOcclusionParams, AmbientScatteringParams, HalfAngleParams, Light, LightCache, Lighting,
    PathTraceParams, RayMarchParams, Scene, SingleScatterParams, TechniqueParams,
};
use crate::technique::{RenderError, Renderer};

/// A scene at an extreme.
#[derive(Clone, Debug)]
pub struct Extreme {
    /// What is extreme.
    pub name: String,
    /// The scene; its technique is to be replaced.
    pub scene: Scene,
    /// Optical depth along every pixel's ray, where it is one number.
    pub tau: Option<f64>,
    /// Largest sum of the lights' irradiance and of pi times the environment's radiance where there is
    /// medium, scattered light of the medium itself left out.
    pub irradiance: f64,
    /// Voxels (of the smallest spacing) between samples, where the extreme is about it.
    pub step: Option<f64>,
    /// Whether all light falls along the view, so that it enters the medium where the view does.
    pub front_lit: bool,
}

/// A technique and how it is put to an extreme.
#[derive(Clone, Debug)]
pub struct Subject {
    /// Its name in the table.
    pub name: &'static str,
    /// Its parameters; the extreme may replace the step.
    pub params: TechniqueParams,
}

/// A limit that theory gives, and what was found.
#[derive(Clone, Debug, Serialize)]
pub struct Limit {
    /// Which limit.
    pub name: &'static str,
    /// Mean radiance of the image.
    pub found: f64,
    /// What it should be.
    pub expected: f64,
    /// Largest difference that is no error: of discretisation, chance and of the limit itself.
    pub tolerance: f64,
}

/// What was found.
///
/// [`Finding::mean`] of one subject may be compared with that of another of the same [`Model`].
#[derive(Clone, Debug, Serialize)]
pub struct Finding {
    /// The extreme's name.
    pub extreme: String,
    /// The subject's name.
    pub subject: &'static str,
    /// Pixels with a value that is infinite or not a number.
    pub non_finite: usize,
    /// Smallest value of any channel.
    pub smallest: f32,
    /// Largest value of any colour channel, less five standard errors where there is chance in it.
    pub brightest: f64,
    /// No pixel can be brighter.
    pub bound: f64,
    /// Mean of the first channel, and its standard error.
    pub mean: [f64; 2],
    /// What the technique sets out to compute.
    #[serde(skip)]
    pub model: Model,
    /// Mean of `1 - transmittance` and what it should be, where that is known.
    pub alpha: Option<[f64; 2]>,
    /// The limit that holds here, if any.
    pub limit: Option<Limit>,
}

/// Every extreme, one scene each.
#[must_use]
pub fn extremes() -> Vec<Extreme> {
    [media::extremes(), lights::extremes(), places::extremes()].concat()
}

/// Every technique, in each mode that goes through different shader code.
#[must_use]
pub fn subjects() -> Vec<Subject> {
    let march = RayMarchParams {
        early_termination: 1.0,
        ..RayMarchParams::default()
    };
    let scatter = |cache| {
        TechniqueParams::SingleScatter(SingleScatterParams {
            early_termination: 1.0,
            cache,
            ..SingleScatterParams::default()
        })
    };
    let trace = PathTraceParams {
        samples: 64,
        seed: 1,
        ..PathTraceParams::default()
    };
    let ambient = AmbientScatteringParams {
        early_termination: 1.0,
        ..AmbientScatteringParams::default()
    };
    let half_angle = |lighting| {
        TechniqueParams::HalfAngle(HalfAngleParams {
            early_termination: 1.0,
            lighting,
            ..HalfAngleParams::default()
        })
    };
    let subject = |name, params| Subject { name, params };
    vec![
        subject(
            "ray_march, unlit",
            TechniqueParams::RayMarch(RayMarchParams {
                shading: None,
                ..march
            }),
        ),
        subject("ray_march, shaded", TechniqueParams::RayMarch(march)),
        subject("single_scatter", scatter(LightCache::Half)),
        subject("single_scatter, uncached", scatter(LightCache::None)),
        subject(
            "ambient_scattering",
            TechniqueParams::AmbientScattering(ambient),
        ),
        subject(
            "ambient_occlusion",
            TechniqueParams::AmbientOcclusion(AmbientOcclusionParams {
                early_termination: 1.0,
                ..AmbientOcclusionParams::default()
            }),
        ),
        subject("half_angle", half_angle(Lighting::Indirect)),
        subject("half_angle, direct", half_angle(Lighting::Direct)),
        subject("half_angle, unlit", half_angle(Lighting::None)),
        subject("half_angle, surface", half_angle(Lighting::Surface)),
        subject(
            "path_trace, once",
            TechniqueParams::PathTrace(PathTraceParams {
                max_scatter: Some(1),
                ..trace
            }),
        ),
        subject("path_trace", TechniqueParams::PathTrace(trace)),
    ]
}

/// Renders an extreme by a technique and compares the image with what theory says.
///
/// # Errors
/// The scene does not fit the device, the driver refuses, or validation has a message.
pub fn examine(
    device: &Device,
    extreme: &Extreme,
    subject: &Subject,
) -> Result<Finding, RenderError> {
    let mut scene = extreme.scene.clone();
    scene.technique = with_step(subject.params.clone(), extreme.step);
    if model(&scene.technique) == Model::OccludedEnvironment {
        // Nothing else lights it.
        let radiance = Vec3::splat(expect::environment(extreme) as f32);
        scene.lights = vec![Light::Environment { radiance }];
    }
    let mut renderer = Renderer::new(device, scene.clone())?;
    let (image, _) = renderer.render(&mut |_, _, _| {})?;
    let variance = renderer.variance()?;
    let error = |i: usize, c: usize| match &variance {
        Some(v) => f64::from(v[i][c]).sqrt(),
        None => 0.0,
    };
    let values = image.pixels.iter().flatten().copied();
    let brightest = image.pixels.iter().enumerate().flat_map(|(i, p)| {
        let sure = move |c: usize| f64::from(p[c]) - 5.0 * error(i, c);
        (0..3).map(sure)
    });
    let n = image.pixels.len() as f64;
    let mean = |c: usize| image.pixels.iter().map(|p| f64::from(p[c])).sum::<f64>() / n;
    let squares: f64 = (0..image.pixels.len()).map(|i| error(i, 0).powi(2)).sum();
    let found = expect::Found {
        radiance: mean(0),
        error: squares.sqrt() / n,
    };
    Ok(Finding {
        extreme: extreme.name.clone(),
        subject: subject.name,
        non_finite: image.non_finite(),
        smallest: values.fold(f32::INFINITY, f32::min),
        brightest: brightest.fold(0.0, f64::max),
        bound: expect::bound(extreme, &scene.technique),
        mean: [found.radiance, found.error],
        model: model(&scene.technique),
        alpha: extreme.tau.map(|tau| [mean(3), -(-tau).exp_m1()]),
        limit: expect::limit(extreme, &scene.technique, found),
    })
}

/// The parameters with the extreme's step, where the technique has one.
fn with_step(mut params: TechniqueParams, step: Option<f64>) -> TechniqueParams {
    if let Some(step) = step {
        match &mut params {
            TechniqueParams::RayMarch(p) => p.step = step,
            TechniqueParams::SingleScatter(p) => (p.step, p.shadow_step) = (step, step),
            TechniqueParams::AmbientOcclusion(p) => p.step = step,
            TechniqueParams::AmbientScattering(p) => p.step = step,
            TechniqueParams::HalfAngle(p) => p.slice_spacing = step,
            TechniqueParams::PathTrace(_) => {}
        }
    }
    params
}

impl Finding {
    /// What is wrong with the image, in words; empty if nothing is.
    #[must_use]
    pub fn complaints(&self) -> Vec<String> {
        let mut list = Vec::new();
        if self.non_finite > 0 {
            list.push(format!("{} pixels are not finite", self.non_finite));
        }
        if self.smallest < 0.0 {
            list.push(format!("a value is {:e}", self.smallest));
        }
        // Rounding of sums, and of a product of many steps.
        if self.brightest > self.bound * (1.0 + 1e-4) {
            list.push(format!("{:e} is above {:e}", self.brightest, self.bound));
        }
        if let Some([found, expected]) = self.alpha
            && (found - expected).abs() > 2e-4 * expected
        {
            list.push(format!("alpha is {found:e}, expected {expected:e}"));
        }
        if let Some(l) = &self.limit
            && (l.found - l.expected).abs() > l.tolerance
        {
            list.push(format!(
                "{}: {:e}, expected {:e} +- {:e}",
                l.name, l.found, l.expected, l.tolerance
            ));
        }
        list
    }
}
