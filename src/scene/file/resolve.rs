//! From a checked specification to a scene with nothing left open.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use glam::{DVec3, UVec3, Vec3};

use super::spec::{ColorSpace, Endian, EnvironmentSpec, ExposureSpec, LightSpec, RawSpec};
use super::spec_medium::{AlbedoVolumeSpec, OctaveSpec, PrimitiveSpec};
use super::{SceneError, SceneFile};
use crate::scene::framing::{self, Direction, Wish};
use crate::scene::transfer_function::{Primitive, Quantity, automatic, read_file};
use crate::scene::{
    Camera, Clip, ControlPoint, Exposure, ImageSettings, LatLongMap, Light, Medium, Octave,
    Perturbation, Plane, Projection, Scene, TransferFunction, linear_from_srgb,
};
use crate::volume::procedural::Procedural;
use crate::volume::{self, ColorVolume, RawLayout, ReadOptions, Statistics, Volume};

/// Called with phase, amount done and amount in all.
pub type Progress<'a> = &'a mut dyn FnMut(&str, u64, u64);

/// Default resolution of procedural volumes.
const RESOLUTION: u32 = 128;

impl SceneFile {
    /// Reads or evaluates the volume and chooses whatever the file leaves open.
    ///
    /// # Errors
    /// The volume or transfer function cannot be read.
    pub fn resolve(&self, progress: Progress<'_>) -> Result<Scene, SceneError> {
        let volume = self.volume(self.time(), progress)?;
        let statistics = Statistics::of(&volume);
        self.resolve_with(Arc::new(volume), Arc::new(statistics))
    }

    /// As [`SceneFile::resolve`], around a volume that is already in memory.
    ///
    /// # Errors
    /// The transfer function cannot be read.
    pub fn resolve_with(
        &self,
        volume: Arc<Volume>,
        statistics: Arc<Statistics>,
    ) -> Result<Scene, SceneError> {
        self.resolve_framed(volume, statistics, None)
    }

    /// An automatic camera shows what `framed` makes visible; without it, what the scene does.
    pub(super) fn resolve_framed(
        &self,
        volume: Arc<Volume>,
        statistics: Arc<Statistics>,
        framed: Option<&TransferFunction>,
    ) -> Result<Scene, SceneError> {
        let medium = self.medium(&volume, &statistics)?;
        let image = self.image();
        let clip = self.clip();
        let framed = framed.unwrap_or(&medium.transfer_function);
        let camera = self.camera(&volume, framed, &clip, &image);
        let lights = match &self.spec.lights {
            Some(list) => self.lights(list)?,
            None => framing::lights(&camera),
        };
        let mut scene = Scene {
            volume,
            statistics,
            medium,
            lights,
            camera,
            clip,
            image,
            technique: self.technique(),
        };
        self.coarsen(&mut scene);
        Ok(scene)
    }

    /// Reads time step `time`, or evaluates the formula.
    pub(super) fn volume(&self, time: u32, progress: Progress<'_>) -> Result<Volume, SceneError> {
        let v = &self.spec.volume;
        if let Some(field) = &v.height_field {
            progress("reading", 0, 1);
            return self.height_field(field);
        }
        let Some(file) = &v.file else {
            progress("evaluating", 0, 1);
            let (name, resolution) = v
                .procedural
                .as_ref()
                .map_or((Procedural::Supernova, None), |p| (p.name, p.resolution));
            return Ok(name.volume(resolution.unwrap_or(RESOLUTION)));
        };
        let path = self.folder.join(file);
        let options = ReadOptions {
            raw: v.raw.as_ref().map(raw_layout),
            time,
        };
        Ok(volume::read(&path, &options, &mut |done, total| {
            progress("reading", done, total)
        })?)
    }

    fn medium(&self, volume: &Volume, statistics: &Statistics) -> Result<Medium, SceneError> {
        let m = &self.spec.medium;
        let albedo_volume = match &m.albedo_volume {
            Some(spec) => Some(self.colors(spec, volume)?),
            None => self.height_field_colors(volume)?.map(Arc::new),
        };
        let default_albedo = if albedo_volume.is_some() { 1.0 } else { 0.9 };
        Ok(Medium {
            transfer_function: self.transfer_function(volume, statistics)?,
            perturbation: self.perturbation(self.time()),
            density_scale: m.density_scale.unwrap_or(1.0),
            albedo: m.albedo.unwrap_or(default_albedo),
            albedo_volume,
            emission: m.emission.unwrap_or(0.0),
            phase_g: m.phase.g.unwrap_or(0.0),
        })
    }

    /// The noise as time step `step` shows it.
    pub(super) fn perturbation(&self, step: u32) -> Option<Perturbation> {
        let p = self.spec.medium.perturbation.as_ref()?;
        Some(Perturbation {
            seed: p.seed.unwrap_or(0),
            octaves: p.octaves.iter().map(octave).collect(),
            time: p.time.unwrap_or(0.0) + f64::from(step),
        })
    }

    fn colors(
        &self,
        spec: &AlbedoVolumeSpec,
        volume: &Volume,
    ) -> Result<Arc<ColorVolume>, SceneError> {
        let path = self.folder.join(&spec.file);
        let colors = volume::read_color(&path, spec.raw.as_ref().map(raw_layout))?;
        check_colors(&path, &colors, volume)?;
        Ok(Arc::new(colors))
    }

    fn lights(&self, list: &[LightSpec]) -> Result<Vec<Light>, SceneError> {
        let mut maps: HashMap<&str, Arc<LatLongMap>> = HashMap::new();
        let mut lights = Vec::new();
        for spec in list {
            let file = spec.environment.as_ref().and_then(|e| e.file.as_deref());
            if let (Some(e), Some(file)) = (&spec.environment, file) {
                let map = match maps.get(file) {
                    Some(map) => map.clone(),
                    None => Arc::new(LatLongMap::read(&self.folder.join(file))?),
                };
                maps.insert(file, map.clone());
                lights.push(environment_map(e, map));
            } else {
                lights.extend(light(spec));
            }
        }
        Ok(lights)
    }

    fn transfer_function(
        &self,
        volume: &Volume,
        statistics: &Statistics,
    ) -> Result<TransferFunction, SceneError> {
        let t = &self.spec.transfer_function;
        let srgb = t.color_space != Some(ColorSpace::Linear);
        let mut function = if let Some(preset) = t.preset {
            preset.transfer_function(&volume.grid, statistics)
        } else if let Some(file) = &t.file {
            read_file(&self.folder.join(Path::new(file)), &volume.grid, statistics)?
        } else if let Some(points) = t.points.as_ref().or(t.extinction.as_ref()) {
            TransferFunction {
                name: "inline".to_owned(),
                quantity: if t.points.is_some() {
                    Quantity::Opacity
                } else {
                    Quantity::Extinction
                },
                points: points.iter().map(|row| control_point(row, srgb)).collect(),
                primitives: Vec::new(),
                opacity_unit_distance: 1.0,
            }
        } else if let Some(shapes) = &t.primitives {
            TransferFunction {
                name: "inline, over values and gradients".to_owned(),
                quantity: Quantity::Opacity,
                points: Vec::new(),
                primitives: shapes.iter().map(|p| primitive(p, srgb)).collect(),
                opacity_unit_distance: 1.0,
            }
        } else {
            automatic(volume, statistics)
        };
        if let Some(distance) = t.opacity_unit_distance {
            function.opacity_unit_distance = distance;
        }
        Ok(function)
    }

    fn camera(
        &self,
        volume: &Volume,
        transfer_function: &TransferFunction,
        clip: &Clip,
        image: &ImageSettings,
    ) -> Camera {
        let c = &self.spec.camera;
        let projection = c.orthographic_height.map_or(
            Projection::Perspective {
                vfov_deg: c.vfov_deg.unwrap_or(framing::VFOV_DEG),
            },
            |height| Projection::Orthographic { height },
        );
        let looking = |eye: DVec3, target: DVec3| Camera {
            eye,
            target,
            up: c.up.map(DVec3::from).unwrap_or_else(|| {
                let vertical = framing::parallel(target - eye, DVec3::Z);
                if vertical { DVec3::Y } else { DVec3::Z }
            }),
            projection,
        };
        if let (Some(eye), Some(target)) = (c.eye, c.target) {
            return looking(eye.into(), target.into());
        }
        let outline = framing::visible_outline(volume, transfer_function, clip);
        if let Some(eye) = c.eye {
            return looking(eye.into(), framing::centre(&outline));
        }
        let direction = Direction::new(volume.grid.space, c.azimuth_deg, c.elevation_deg);
        let wish = Wish {
            target: c.target.map(DVec3::from),
            up: c.up.map_or(direction.up, DVec3::from),
            projection,
            direction,
            aspect: f64::from(image.width) / f64::from(image.height),
            zoom: c.zoom.unwrap_or(1.0),
        };
        framing::frame(&outline, &wish)
    }

    fn clip(&self) -> Clip {
        let c = &self.spec.clip;
        Clip {
            bounds: c.bounds.as_ref().map(|b| (b.min.into(), b.max.into())),
            plane: c.plane.as_ref().map(|p| Plane {
                point: p.point.into(),
                normal: p.normal.into(),
            }),
        }
    }

    /// The image's settings.
    #[must_use]
    pub fn image(&self) -> ImageSettings {
        let (i, d) = (&self.spec.image, ImageSettings::default());
        ImageSettings {
            width: i.width.unwrap_or(d.width),
            height: i.height.unwrap_or(d.height),
            samples_per_axis: i.samples_per_axis.unwrap_or(d.samples_per_axis),
            background: i.background.map_or(d.background, |c| c.0),
            exposure: match i.exposure {
                Some(ExposureSpec::Stops(stops)) => Exposure::Stops(stops),
                _ => Exposure::Auto,
            },
            tone_map: i.tone_map.unwrap_or(d.tone_map),
        }
    }
}

/// Refuses colours that are not one a voxel.
fn check_colors(path: &Path, colors: &ColorVolume, volume: &Volume) -> Result<(), SceneError> {
    if colors.dims == volume.stored_dims() {
        return Ok(());
    }
    let shown = |d: UVec3| format!("{} x {} x {} voxels", d.x, d.y, d.z);
    Err(SceneError::plain(format!(
        "{}: found {}, expected the {} of the volume `{}` that it colours",
        path.display(),
        shown(colors.dims),
        shown(volume.stored_dims()),
        volume.name
    )))
}

pub(super) fn raw_layout(r: &RawSpec) -> RawLayout {
    RawLayout {
        dims: r.dims,
        scalar_type: r.scalar_type,
        spacing: r.spacing.unwrap_or([1.0; 3]),
        big_endian: r.endian == Some(Endian::Big),
        skip_bytes: r.skip_bytes.unwrap_or(0),
    }
}

fn control_point([value, r, g, b, opacity]: &[f64; 5], srgb: bool) -> ControlPoint {
    ControlPoint {
        value: *value,
        color: linear([*r, *g, *b], srgb),
        opacity: *opacity,
    }
}

fn octave(spec: &OctaveSpec) -> Octave {
    Octave {
        frequency: spec.frequency,
        displacement: spec.displacement.unwrap_or(0.0),
        opacity: spec.opacity.unwrap_or(0.0),
        color: spec.color.map_or(Vec3::ZERO, |c| c.0),
        offset: spec.offset.map_or(DVec3::ZERO, DVec3::from),
        velocity: spec.velocity.map_or(DVec3::ZERO, DVec3::from),
    }
}

fn primitive(spec: &PrimitiveSpec, srgb: bool) -> Primitive {
    Primitive {
        shape: spec.shape,
        value: spec.value,
        gradient: spec.gradient.unwrap_or([0.0, f64::INFINITY]),
        color: linear(spec.color, srgb),
        opacity: spec.opacity,
    }
}

fn linear(color: [f64; 3], srgb: bool) -> Vec3 {
    let color = color.map(|c| c as f32);
    Vec3::from(if srgb {
        color.map(linear_from_srgb)
    } else {
        color
    })
}

fn light(spec: &LightSpec) -> Option<Light> {
    if let Some(d) = &spec.directional {
        Some(Light::Directional {
            direction: d.direction.into(),
            irradiance: d.irradiance.0,
        })
    } else if let Some(p) = &spec.point {
        Some(Light::Point {
            position: p.position.into(),
            intensity: p.intensity.0,
            falloff: p.falloff,
        })
    } else {
        let radiance = spec.environment.as_ref().and_then(|e| e.radiance);
        radiance.map(|radiance| Light::Environment {
            radiance: radiance.0,
        })
    }
}

fn environment_map(spec: &EnvironmentSpec, map: Arc<LatLongMap>) -> Light {
    Light::EnvironmentMap {
        map,
        scale: spec.scale.map_or(Vec3::ONE, |s| s.0),
        up: spec.up.map_or(DVec3::Z, DVec3::from).normalize(),
        rotation_deg: spec.rotation_deg.unwrap_or(0.0),
    }
}
