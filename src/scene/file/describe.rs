//! A resolved scene as JSON, for metadata and `--json`.

use glam::Vec3;
use serde_json::{Value, json};

use crate::scene::transfer_function::{Primitive, Quantity};
use crate::scene::{
    ControlPoint, Exposure, Light, Octave, Perturbation, Projection, Radius, Scene,
    TechniqueParams, TransportColor,
};

/// Every setting of a resolved scene.
#[must_use]
pub fn describe(scene: &Scene) -> Value {
    let (v, m, c, i) = (&scene.volume, &scene.medium, &scene.camera, &scene.image);
    let tf = &m.transfer_function;
    let points = match tf.quantity {
        _ if tf.has_gradients() => "primitives",
        Quantity::Opacity => "points",
        Quantity::Extinction => "extinction",
    };
    let rows: Vec<_> = if tf.has_gradients() {
        tf.primitives.iter().map(primitive).collect()
    } else {
        let row = |p: &ControlPoint| json!([p.value, p.color.x, p.color.y, p.color.z, p.opacity]);
        tf.points.iter().map(row).collect()
    };
    let projection = match c.projection {
        Projection::Perspective { vfov_deg } => json!({ "vfov_deg": vfov_deg }),
        Projection::Orthographic { height } => json!({ "orthographic_height": height }),
    };
    json!({
        "volume": {
            "name": v.name,
            "dims": v.grid.dims.to_array(),
            "type": v.voxels.scalar_type(),
            "spacing": v.grid.spacing().to_array(),
            "world_from_index": v.grid.world_from_index.to_cols_array(),
            "space": v.grid.space,
            "unit": v.spatial_unit,
            "slope": v.rescale.slope,
            "intercept": v.rescale.intercept,
            "height_field": v.height_field.as_ref().map(|f| {
                let layer = v.grid.spacing().z;
                json!({
                    "bottom": f.bottom * layer,
                    "top": f.top * layer,
                    "ramp": f.ramp * layer,
                    "level": f.level,
                })
            }),
            "range": [scene.statistics.min, scene.statistics.max],
        },
        "transfer_function": {
            "name": tf.name,
            "color_space": "linear",
            "opacity_unit_distance": tf.opacity_unit_distance,
            points: rows,
        },
        "medium": {
            "density_scale": m.density_scale,
            "albedo": m.albedo,
            "albedo_volume": m.albedo_volume.as_ref().map(|c| &c.name),
            "perturbation": m.perturbation.as_ref().map(perturbation),
            "emission": m.emission,
            "phase": { "g": m.phase_g },
        },
        "lights": scene.lights.iter().map(light).collect::<Vec<_>>(),
        "camera": {
            "eye": c.eye.to_array(),
            "target": c.target.to_array(),
            "up": c.up.to_array(),
            "projection": projection,
        },
        "clip": {
            "box": scene.clip.bounds.map(|(lo, hi)| json!({ "min": lo.to_array(), "max": hi.to_array() })),
            "plane": scene.clip.plane.map(|p| {
                json!({ "point": p.point.to_array(), "normal": p.normal.to_array() })
            }),
        },
        "image": {
            "width": i.width,
            "height": i.height,
            "samples_per_axis": i.samples_per_axis,
            "background": rgb(i.background),
            "exposure": match i.exposure {
                Exposure::Auto => json!("auto"),
                Exposure::Stops(stops) => json!(stops),
            },
            "tone_map": i.tone_map,
        },
        "technique": technique(&scene.technique),
    })
}

fn perturbation(p: &Perturbation) -> Value {
    let octave = |o: &Octave| {
        json!({
            "frequency": o.frequency,
            "displacement": o.displacement,
            "opacity": o.opacity,
            "color": rgb(o.color),
            "offset": o.offset.to_array(),
            "velocity": o.velocity.to_array(),
        })
    };
    json!({
        "seed": p.seed,
        "time": p.time,
        "octaves": p.octaves.iter().map(octave).collect::<Vec<_>>(),
    })
}

/// A gradient without an end is `null`.
fn primitive(p: &Primitive) -> Value {
    json!({
        "shape": p.shape,
        "value": p.value,
        "gradient": p.gradient,
        "color": rgb(p.color),
        "opacity": p.opacity,
    })
}

fn rgb(c: Vec3) -> [f32; 3] {
    c.to_array()
}

fn light(light: &Light) -> Value {
    match light {
        Light::Directional {
            direction,
            irradiance,
        } => json!({
            "directional": { "direction": direction.to_array(), "irradiance": rgb(*irradiance) }
        }),
        Light::Point {
            position,
            intensity,
            falloff,
        } => json!({
            "point": { "position": position.to_array(), "intensity": rgb(*intensity), "falloff": falloff }
        }),
        Light::Environment { radiance } => json!({ "environment": { "radiance": rgb(*radiance) } }),
        Light::EnvironmentMap {
            map,
            scale,
            up,
            rotation_deg,
        } => json!({
            "environment": {
                "file": map.name,
                "scale": rgb(*scale),
                "up": up.to_array(),
                "rotation_deg": rotation_deg,
            }
        }),
    }
}

fn radius(radius: Radius) -> Value {
    match radius {
        Radius::Auto => json!("auto"),
        Radius::Voxels(voxels) => json!(voxels),
        Radius::World(world) => json!({ "world": world }),
    }
}

fn technique(technique: &TechniqueParams) -> Value {
    match technique {
        TechniqueParams::RayMarch(p) => json!({
            "name": "ray_march",
            "ray_march": {
                "step": p.step,
                "shading": p.shading.map_or(json!(false), |s| json!({
                    "ambient": s.ambient,
                    "diffuse": s.diffuse,
                    "specular": s.specular,
                    "shininess": s.shininess,
                    "merge_opacity": s.merge_opacity,
                })),
                "early_termination": p.early_termination,
                "empty_space_skipping": p.empty_space_skipping,
            }
        }),
        TechniqueParams::PathTrace(p) => json!({
            "name": "path_trace",
            "path_trace": {
                "samples": p.samples,
                "seconds": p.seconds,
                "target_error": p.target_error,
                "max_scatter": p.max_scatter,
                "seed": p.seed,
            }
        }),
        TechniqueParams::SingleScatter(p) => json!({
            "name": "single_scatter",
            "single_scatter": {
                "step": p.step,
                "shadow_step": p.shadow_step,
                "cache": p.cache,
                "early_termination": p.early_termination,
                "empty_space_skipping": p.empty_space_skipping,
            }
        }),
        TechniqueParams::AmbientOcclusion(p) => json!({
            "name": "ambient_occlusion",
            "ambient_occlusion": {
                "step": p.step,
                "radius": radius(p.radius),
                "early_termination": p.early_termination,
                "empty_space_skipping": p.empty_space_skipping,
            }
        }),
        TechniqueParams::HalfAngle(p) => json!({
            "name": "half_angle",
            "half_angle": {
                "slice_spacing": p.slice_spacing,
                "light_buffer": p.light_buffer,
                "lighting": p.lighting,
                "transport_color": match &p.transport_color {
                    TransportColor::Auto => json!("auto"),
                    TransportColor::Points(rows) => json!(rows.as_ref()),
                },
                "blur_angle_deg": p.blur_angle_deg,
                "blur_samples": p.blur_samples,
                "phase_table": p.phase_table.as_deref(),
                "surface": p.surface,
                "surface_gradient": p.surface_gradient,
                "specular": p.specular,
                "shininess": p.shininess,
                "early_termination": p.early_termination,
                "empty_space_skipping": p.empty_space_skipping,
            }
        }),
        TechniqueParams::AmbientScattering(p) => json!({
            "name": "ambient_scattering",
            "ambient_scattering": {
                "step": p.step,
                "radius": radius(p.radius),
                "tube": p.tube,
                "gather": p.gather,
                "cache": p.cache,
                "specular": p.specular,
                "shininess": p.shininess,
                "occlusion_radius": radius(p.occlusion_radius),
                "early_termination": p.early_termination,
                "empty_space_skipping": p.empty_space_skipping,
            }
        }),
    }
}
