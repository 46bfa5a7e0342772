//! What theory says of an extreme's image.

use std::f64::consts::PI;

use super::scenes::COLOR;
use super::{Extreme, Limit, half_space};
use crate::scene::{Lighting, Shading, TechniqueParams};
use crate::technique::phase_hg;

/// What a technique sets out to compute.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Model {
    /// Emission and absorption: the colour is source radiance, or is lit at each sample.
    EmissionAbsorption(Option<Shading>),
    /// Light that is scattered once.
    SingleScattering,
    /// Light of an environment, dimmed by what is near and scattered once.
    OccludedEnvironment,
    /// Light that is scattered any number of times.
    MultipleScattering,
    /// The same, nearly: light scattered about a sample, and on its way there.
    AmbientScattering,
    /// Light scattered once, and before that forward on its way.
    ForwardScattering,
}

/// The model of a technique.
#[must_use]
pub const fn model(technique: &TechniqueParams) -> Model {
    match technique {
        TechniqueParams::RayMarch(p) => Model::EmissionAbsorption(p.shading),
        TechniqueParams::PathTrace(p) => match p.max_scatter {
            Some(1) => Model::SingleScattering,
            _ => Model::MultipleScattering,
        },
        TechniqueParams::SingleScatter(_) => Model::SingleScattering,
        TechniqueParams::AmbientOcclusion(_) => Model::OccludedEnvironment,
        TechniqueParams::AmbientScattering(_) => Model::AmbientScattering,
        TechniqueParams::HalfAngle(p) => match p.lighting {
            Lighting::None => Model::EmissionAbsorption(None),
            Lighting::Surface => Model::EmissionAbsorption(Some(SURFACE)),
            Lighting::Direct => Model::SingleScattering,
            Lighting::Indirect => Model::ForwardScattering,
        },
    }
}

/// Fluence in a half space that scatters everything, far below the surface, over the irradiance of light
/// that falls straight in: 4 K(1), with the escape function K(1) = sqrt(3) H(1) / 4 = 1.26 where scattering
/// is even and hardly another where it is not. No finite body of that medium lit from one side has more.
const LARGEST_FLUENCE: f64 = 5.2;

/// How `half_angle` shades surfaces at its default parameters.
const SURFACE: Shading = Shading {
    ambient: 1.0,
    diffuse: 0.9,
    specular: 0.2,
    shininess: 20.0,
    merge_opacity: 0.0,
};

/// Mean radiance and its standard error.
#[derive(Clone, Copy)]
pub(super) struct Found {
    pub(super) radiance: f64,
    pub(super) error: f64,
}

/// Radiance of an environment that shines as much as the extreme's lights, for what only environments light.
pub(super) fn environment(extreme: &Extreme) -> f64 {
    extreme.irradiance / PI
}

/// Largest radiance that a pixel can have.
pub(super) fn bound(extreme: &Extreme, technique: &TechniqueParams) -> f64 {
    let m = &extreme.scene.medium;
    let colors = m.transfer_function.points.iter();
    let color = f64::from(colors.map(|p| p.color.max_element()).fold(0.0, f32::max));
    let largest_phase = phase_hg(m.phase_g.signum(), m.phase_g);
    let scattered = m.albedo * color * largest_phase * extreme.irradiance;
    match model(technique) {
        Model::EmissionAbsorption(None) => color,
        Model::EmissionAbsorption(Some(s)) => {
            let reflected = f64::from(s.diffuse) * color + f64::from(s.specular);
            extreme.irradiance / PI * (reflected + f64::from(s.ambient) * color)
        }
        // What was scattered on its way is never more than the light has lost.
        Model::SingleScattering | Model::ForwardScattering => scattered,
        Model::OccludedEnvironment => m.albedo * color * environment(extreme),
        Model::MultipleScattering | Model::AmbientScattering => LARGEST_FLUENCE * scattered,
    }
}

/// The limit that theory gives of the first channel's mean, if it gives any.
pub(super) fn limit(extreme: &Extreme, technique: &TechniqueParams, found: Found) -> Option<Limit> {
    let m = &extreme.scene.medium;
    let limit = |name, expected: f64, relative: f64| {
        // 1e-4: single precision, summed over some hundred samples.
        let tolerance = 5.0 * found.error + (1e-4 + relative) * expected;
        Some(Limit {
            name,
            found: found.radiance,
            expected,
            tolerance,
        })
    };
    let model = model(technique);
    let emits = matches!(model, Model::EmissionAbsorption(_));
    if m.albedo == 0.0 && !emits {
        return limit("no scattering", 0.0, 0.0);
    }
    let tau = extreme.tau?;
    if tau == 0.0 {
        return limit("empty", 0.0, 0.0);
    }
    let points = &m.transfer_function.points;
    let color = f64::from(points.first().map_or(COLOR, |p| p.color).x);
    if model == Model::EmissionAbsorption(None) {
        return limit("slab", color * -(-tau).exp_m1(), 0.0);
    }
    if model == Model::OccludedEnvironment {
        // The radius is at most a few times as deep as the view; half floats end 2^-11 below 1.
        let undimmed = m.albedo * color * environment(extreme) * -(-tau).exp_m1();
        return (tau < 2e-3)
            .then(|| limit("thin", undimmed, 10.0 * tau + 1.0 / 2048.0))
            .flatten();
    }
    if emits || !extreme.front_lit {
        return None;
    }
    let albedo = m.albedo * color;
    let backward = phase_hg(-1.0, m.phase_g);
    let once = albedo * backward * extreme.irradiance * -(-2.0 * tau).exp_m1() / 2.0;
    match model {
        Model::SingleScattering => limit("scattered once", once, 0.0),
        // The second scattering is smaller by the depth, and by how much more there is across the view.
        _ if tau < 2e-3 && m.phase_g == 0.0 => limit("thin", once, 10.0 * tau),
        Model::MultipleScattering if tau > 500.0 && m.phase_g == 0.0 => {
            let h = half_space::h(1.0, albedo);
            let reflected = albedo * extreme.irradiance / (8.0 * PI) * h * h;
            limit("opaque", reflected, 0.0)
        }
        _ => None,
    }
}
