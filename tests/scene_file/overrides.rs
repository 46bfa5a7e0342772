//! `--set KEY=VALUE`.

use tyndall::scene::file::{Override, SceneFile};

use super::{EVERYTHING, set};

fn changed(one: &str) -> SceneFile {
    set(EVERYTHING, &[one]).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn overrides_set_any_key() {
    assert_eq!(changed("image.width=512").spec.image.width, Some(512));
    let scale = changed("medium.density_scale = 2")
        .spec
        .medium
        .density_scale;
    assert_eq!(scale, Some(2.0));
    for word in ["image.tone_map=reinhard", "image.tone_map='reinhard'"] {
        let map = changed(word).spec.image.tone_map.unwrap();
        assert_eq!(map.name(), "reinhard");
    }
    assert_eq!(
        changed("camera.eye.1=7").spec.camera.eye,
        Some([10.0, 7.0, 0.0])
    );
    let last = set("", &["image.width=1", "image.width=2"]).unwrap();
    assert_eq!(last.spec.image.width, Some(2));
}

#[test]
fn overrides_reach_lights_by_index() {
    let lights = |one: &str| changed(one).spec.lights.unwrap();
    let irradiance = lights("lights.0.directional.irradiance=[1, 1, 2]")[0]
        .directional
        .as_ref()
        .unwrap()
        .irradiance;
    assert_eq!(irradiance.0.to_array(), [1.0, 1.0, 2.0]);
    assert_eq!(lights("lights.3.environment.radiance=0.5").len(), 4);
    let whole = lights("lights.0={environment={radiance=2}}");
    assert!(whole[0].directional.is_none() && whole.len() == 3);
    let none = set("", &["lights.0.environment.radiance=2"]).unwrap();
    assert_eq!(none.spec.lights.unwrap().len(), 1);
}

#[test]
fn overriding_an_alternative_removes_its_siblings() {
    let light = &changed("lights.0.environment.radiance=1")
        .spec
        .lights
        .unwrap()[0];
    assert!(light.environment.is_some() && light.directional.is_none());
    let camera = changed("camera.zoom=2").spec.camera;
    assert!(camera.eye.is_none() && camera.target.is_some());
    let camera = changed("camera.orthographic_height=2").spec.camera;
    assert!(camera.vfov_deg.is_none());
    let volume = changed("volume.procedural.name=cloud").spec.volume;
    assert!(volume.file.is_none() && volume.raw.is_none() && volume.time.is_none());
    let tf = changed("transfer_function.preset=ct_bone")
        .spec
        .transfer_function;
    assert!(tf.preset.is_some() && tf.points.is_none() && tf.color_space.is_none());
    let switch = "technique.ray_march.shading = false";
    assert!(set(switch, &["technique.ray_march.shading.ambient=1"]).is_ok());
}

#[test]
fn errors_in_overrides_name_the_override() {
    for (one, rest) in [
        ("image.width=0", "image.width: found 0, expected"),
        (
            "image.widht=5",
            "image.widht: unknown key `widht`; did you mean `width`?",
        ),
        (
            "camera.eye=[1, 2",
            "camera.eye: found string \"[1, 2\", expected",
        ),
        (
            "lights.7.environment.radiance=1",
            "`lights` has 3 elements, expected an index from 0 to 3",
        ),
        ("lights.x=1", "`lights` has 3 elements"),
        ("image.width.x=3", "`width` is not a table"),
        (
            "clip.box.max=[-2, 5, 5]",
            "clip.box.max: found -2 on axis 0",
        ),
    ] {
        let message = set(EVERYTHING, &[one]).expect_err(one).to_string();
        assert!(
            message.starts_with(&format!("--set {one}: {rest}")),
            "{message}"
        );
    }
    for bad in ["image.width", "=3", "a..b=3", ".=1"] {
        let message = Override::parse(bad).expect_err(bad).to_string();
        let start = format!("--set {bad}: expected KEY=VALUE");
        assert!(message.starts_with(&start), "{message}");
    }
}
