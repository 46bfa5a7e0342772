//! What results are filed under: SHA-256 of everything that decides them.

use serde_json::{Value, json};

use super::reference::ReferenceGoal;
use crate::gpu::{DeviceInfo, shader};
use crate::scene::file::describe;
use crate::scene::{Light, Scene};
use crate::shaders::hash;
use crate::volume::Volume;

/// The voxels, their place and meaning; the volume's name does not count.
pub(super) fn of_volume(volume: &Volume) -> String {
    let voxels = hash(volume.voxels.bytes());
    match &volume.height_field {
        Some(field) => hash((voxels + &hash(bytemuck::cast_slice(&field.heights))).as_bytes()),
        None => voxels,
    }
}

/// What is seen: the scene without the technique, without names, and without what only says how the
/// image is shown or sampled.
pub(super) fn of_scene(scene: &Scene, volume: &str) -> String {
    let mut value = describe(scene);
    let leave_out = [
        ("", "technique"),
        ("/volume", "name"),
        ("/transfer_function", "name"),
        ("/image", "samples_per_axis"),
        ("/image", "exposure"),
        ("/image", "tone_map"),
    ];
    for (table, key) in leave_out {
        if let Some(table) = value.pointer_mut(table).and_then(Value::as_object_mut) {
            table.remove(key);
        }
    }
    let albedo = scene.medium.albedo_volume.as_ref();
    let maps = scene.lights.iter().filter_map(|l| match l {
        Light::EnvironmentMap { map, .. } => Some(hash(bytemuck::cast_slice(&map.texels))),
        _ => None,
    });
    of_value(&json!({
        "scene": value,
        "voxels": volume,
        "albedo": albedo.map(|a| hash(a.bytes())),
        "maps": maps.collect::<Vec<_>>(),
    }))
}

/// A reference of a scene.
pub(super) fn of_reference(scene_key: &str, goal: &ReferenceGoal, seed: u32) -> String {
    of_value(&json!({
        "scene": scene_key,
        "version": env!("CARGO_PKG_VERSION"),
        "shaders": shaders(&["medium.", "path_trace."]),
        "error": goal.error,
        "seconds": goal.seconds,
        "samples": goal.samples,
        "seed": seed,
    }))
}

/// A measurement of a scene that has its technique and settings.
pub(super) fn of_measurement(
    scene: &Scene,
    reference_key: &str,
    frames: u32,
    device: &DeviceInfo,
) -> String {
    let described = describe(scene);
    let technique = format!("{}.", scene.technique.name());
    of_value(&json!({
        "reference": reference_key,
        "technique": described["technique"],
        "image": described["image"],
        "frames": frames,
        "device": [&device.name, &device.driver, &device.cache_key],
        "shaders": shaders(&["medium.", &technique]),
    }))
}

/// Hashes of the modules whose names begin so.
fn shaders(prefixes: &[&str]) -> Value {
    let wanted = |s: &&shader::Shader| prefixes.iter().any(|p| s.name.starts_with(p));
    let list = shader::ALL.iter().filter(wanted);
    list.map(|s| json!([s.name, hash(s.spirv)])).collect()
}

fn of_value(value: &Value) -> String {
    // Keys of objects are sorted, so equal values have equal texts.
    hash(value.to_string().as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::file::{Override, SceneFile};

    fn key(overrides: &[&str]) -> String {
        let small = ["volume.procedural.resolution=8"];
        let overrides = small.iter().chain(overrides);
        let overrides: Result<Vec<_>, _> = overrides.map(|o| Override::parse(o)).collect();
        let file = overrides.and_then(|o| SceneFile::built_in(&o));
        let scene = file.and_then(|f| f.resolve(&mut |_, _, _| {}));
        scene.map_or_else(|e| e.to_string(), |s| of_scene(&s, &of_volume(&s.volume)))
    }

    #[test]
    fn a_scene_is_known_by_what_is_seen() {
        let plain = key(&[]);
        assert_eq!(plain.len(), 64, "{plain}");
        for same in ["technique.name=path_trace", "image.exposure=2"] {
            assert_eq!(key(&[same]), plain, "{same}");
        }
        for other in [
            "image.width=7",
            "medium.albedo=0.5",
            "camera.azimuth_deg=12",
        ] {
            assert_ne!(key(&[other]), plain, "{other}");
        }
        assert_ne!(key(&["volume.procedural.resolution=9"]), plain);
    }
}
