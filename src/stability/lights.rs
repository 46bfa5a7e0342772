//! Extremes of lights and view.

use glam::{DVec3, Vec3};

use super::Extreme;
use super::scenes::{IRRADIANCE, along, changed};
use crate::scene::{Falloff, Light, Projection};

pub(super) fn extremes() -> Vec<Extreme> {
    let mut list = Vec::new();
    // The even cube is lit along the view; these are the other ways.
    for (name, direction) in [
        ("light against the view", -DVec3::Y),
        ("light across the view", DVec3::X),
        ("light almost along the view", DVec3::new(1e-7, 1.0, 0.0)),
        ("light of length 1e-20", DVec3::new(0.0, 1e-20, 0.0)),
    ] {
        list.push(changed(name, 0.5, |e| {
            e.scene.lights = vec![along(direction)];
            e.front_lit = direction.y > 0.0;
        }));
    }
    list.extend(points());
    for factor in [1e-6, 1e6] {
        let name = format!("irradiance times {factor:e}");
        list.push(changed(&name, 0.5, |e| {
            e.irradiance *= factor;
            e.scene.lights = vec![Light::Directional {
                direction: DVec3::Y,
                irradiance: Vec3::splat(IRRADIANCE * factor as f32),
            }];
        }));
    }
    list.push(changed("camera in the medium", 0.5, |e| {
        e.scene.camera.eye = DVec3::new(0.3, 0.1, -0.2);
        e.scene.camera.target = DVec3::new(0.3, 3.0, 0.4);
        e.scene.camera.projection = Projection::Perspective { vfov_deg: 120.0 };
        (e.tau, e.front_lit) = (None, false);
    }));
    list.push(changed("camera on a corner of the volume", 0.5, |e| {
        e.scene.camera.eye = DVec3::splat(-4.0);
        e.scene.camera.target = DVec3::ZERO;
        e.scene.camera.projection = Projection::Perspective { vfov_deg: 179.0 };
        (e.tau, e.front_lit) = (None, false);
    }));
    list
}

/// Point lights in the volume, on a voxel, on its edge, and far away.
fn points() -> Vec<Extreme> {
    let point = |position, intensity: f64, falloff| {
        vec![Light::Point {
            position,
            intensity: Vec3::splat(intensity as f32),
            falloff,
        }]
    };
    let mut list = Vec::new();
    for (name, position) in [
        ("point light in the volume", DVec3::new(3.2, 0.1, 0.3)),
        ("point light on a voxel's centre", DVec3::new(3.5, 0.5, 0.5)),
        (
            "point light on the volume's face",
            DVec3::new(4.0, 0.0, 0.0),
        ),
    ] {
        list.push(changed(name, 0.5, |e| {
            // View rays pass at x <= 2: 1.2 from the light at least. What others scatter there comes from
            // the light's near surroundings: in diffusion its fluence falls as 3 sigma_t I / d.
            e.irradiance = 1.0 / 1.2_f64.powi(2) * (1.0 + 3.0 * 0.5 * 1.2);
            e.scene.lights = point(position, 1.0, Falloff::InverseSquare);
            e.front_lit = false;
        }));
    }
    list.push(changed("point light in the volume, no falloff", 0.5, |e| {
        e.scene.lights = point(DVec3::new(0.5, 0.5, 0.5), IRRADIANCE.into(), Falloff::None);
        e.front_lit = false;
    }));
    list.push(changed("point light 1e9 away", 0.5, |e| {
        let intensity = f64::from(IRRADIANCE) * 1e18;
        let place = DVec3::new(0.0, -1e9, 0.0);
        e.scene.lights = point(place, intensity, Falloff::InverseSquare);
    }));
    list
}
