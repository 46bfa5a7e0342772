//! What `path_trace` does for a scene.

use glam::{UVec2, UVec3};

use super::{NAME, environment, layout, leaves};
use crate::gpu::{Format, Limits, Specialization, StageLayout};
use crate::scene::{LatLongMap, Light, PathTraceParams, Scene};
use crate::technique::albedo_volume::AlbedoPlan;
use crate::technique::medium::{MediumPlan, Table};
use crate::technique::{
    Input, Inputs, Omission, Plan, PlanError, ResourceKind, ResourcePlan, StagePlan, lights, target,
};

/// Stage names of the technique.
pub mod stage {
    /// Paths of light, some collisions further, the volume read through the device's filter.
    pub const TRACE: &str = "path_trace.trace";
    /// The same by loads of 8-bit texels.
    pub const TRACE_R8: &str = "path_trace.trace_r8";
    /// The same by loads of 16-bit texels.
    pub const TRACE_R16: &str = "path_trace.trace_r16";
    /// The same by loads of float texels.
    pub const TRACE_R32F: &str = "path_trace.trace_r32f";
    /// Transfer of the leaves' bounds to the device.
    pub const UPLOAD_LEAVES: &str = "path_trace.upload_leaves";
    /// Transfer of the environment map, and of the table by which it is looked for.
    pub const UPLOAD_ENVIRONMENT: &str = "path_trace.upload_environment";
    /// Transfer of the albedo volume.
    pub const UPLOAD_ALBEDO: &str = "path_trace.upload_albedo";
    /// Copy of the image to the host.
    pub const READ_BACK: &str = "path_trace.read_back";
}

/// Constants of `path_trace.trace`, in the order of their ids.
pub const CONSTANTS: [Specialization; 12] = {
    [
        Specialization::new(0, "MASKED"),
        Specialization::new(1, "CLIP_BOX"),
        Specialization::new(2, "CLIP_PLANE"),
        Specialization::new(3, "LIGHT_COUNT"),
        Specialization::new(4, "POINT_LIGHTS"),
        Specialization::new(5, "MAX_SCATTER"),
        Specialization::new(6, "SPREAD"),
        Specialization::new(7, "CELL"),
        Specialization::new(8, "STRAIGHT"),
        Specialization::new(9, "SOURCES"),
        Specialization::new(10, "ENVIRONMENT_MAP"),
        Specialization::new(11, "ALBEDO_VOLUME"),
    ]
};

/// Pixels along the edge of a tile; 64 invocations walk for one.
const TILE: u32 = 8;

/// Scattering events a submission: some tenths of a second on a software driver, milliseconds on a GPU.
const MAX_EVENTS: u64 = 1 << 21;

/// Vectors of four words that a walker takes.
pub(super) const WALKER_LAYERS: u32 = 7;

/// Pure data: everything decided for one scene.
#[derive(Clone, Debug, PartialEq)]
pub struct PathTracePlan {
    /// The medium's part.
    pub medium: MediumPlan,
    /// Constants of `path_trace.trace`.
    pub specialization: Vec<Specialization>,
    /// Image width and height.
    pub image: [u32; 2],
    /// Workgroups of a dispatch: tiles of 8 x 8 pixels, in whole streams.
    pub groups: u32,
    /// Scattering events of a pixel in one dispatch, at most.
    pub rounds: u32,
    /// Cells along each axis that carry bounds of the extinction; none: the volume is one leaf.
    pub leaves: Option<UVec3>,
    /// Texels of the environment map and cells of its table; one each without a map.
    pub maps: (UVec2, UVec2),
    pub(super) albedo: AlbedoPlan,
    omitted: Vec<Omission>,
}

/// Plans the technique for a scene.
///
/// # Errors
/// The scene exceeds a limit of the device or the shader.
pub fn plan(
    scene: &Scene,
    params: &PathTraceParams,
    limits: &Limits,
) -> Result<PathTracePlan, PlanError> {
    let image = &scene.image;
    target::check(image, limits)?;
    let (lights, points) = lights::count(scene, NAME)?;
    let map = environment_map(scene, limits)?;
    let albedo = AlbedoPlan::new(scene);
    let tiles = image.width.div_ceil(TILE) * image.height.div_ceil(TILE);
    let spread = limits.worker_threads;
    let pixels = u64::from(image.width) * u64::from(image.height);
    let medium = MediumPlan::new(
        scene,
        Some("its leaves bound the extinction instead"),
        limits,
    )?;
    let one_leaf = is_one_leaf(scene, &medium.table);
    let plain = medium.table.gradients.is_none() && medium.varied == 0 && !medium.height_field;
    let straight = plain && is_straight(&medium.table.bake(scene));
    let dims = scene.volume.grid.dims;
    let values = [
        u32::from(medium.masked),
        u32::from(scene.clip.bounds.is_some()),
        u32::from(scene.clip.plane.is_some()),
        lights,
        u32::from(points),
        params.max_scatter.unwrap_or(0),
        spread,
        if one_leaf { 0 } else { leaves::cell_edge(dims) },
        u32::from(straight),
        lights + u32::from(map.is_some()),
        u32::from(map.is_some()),
        u32::from(albedo.is_there),
    ];
    let mut omitted = Vec::new();
    let mut omit = |what, left_out: bool, why: &str| {
        if left_out {
            let why = why.to_owned();
            omitted.push(Omission { what, why });
        }
    };
    let none = "the scene has none";
    omit("clip box", scene.clip.bounds.is_none(), none);
    omit("clip plane", scene.clip.plane.is_none(), none);
    omit(
        "leaves",
        one_leaf,
        "the medium is even or thin, its bounds hold everywhere",
    );
    omit(
        "transfer function's table",
        straight,
        "it is a straight line of one colour over the data's range",
    );
    omit(
        "shadow rays",
        lights == 0 && map.is_none(),
        "the scene has no directional or point light and no environment map",
    );
    omit("environment map", map.is_none(), none);
    omit("albedo volume", !albedo.is_there, none);
    Ok(PathTracePlan {
        specialization: medium.with_constants(&CONSTANTS, &values),
        medium,
        image: [image.width, image.height],
        groups: tiles.div_ceil(spread) * spread,
        rounds: u32::try_from((MAX_EVENTS / pixels).clamp(16, 4096)).unwrap_or(16),
        leaves: (!one_leaf).then(|| leaves::cells_along(dims)),
        maps: environment::extents(map),
        albedo,
        omitted,
    })
}

/// The scene's environment map, if it has one.
fn environment_map<'a>(
    scene: &'a Scene,
    limits: &Limits,
) -> Result<Option<&'a LatLongMap>, PlanError> {
    let maps = scene.lights.iter().filter_map(|l| match l {
        Light::EnvironmentMap { map, .. } => Some(&**map),
        _ => None,
    });
    let maps: Vec<_> = maps.collect();
    if maps.len() > 1 {
        return Err(PlanError::Limit {
            what: "lights".to_owned(),
            found: format!("{} environment maps", maps.len()),
            limit: format!("{NAME} takes 1"),
            fix: "add their pictures up in one".to_owned(),
        });
    }
    let Some(map) = maps.first() else {
        return Ok(None);
    };
    if map.width.max(map.height) > limits.max_image_2d {
        return Err(PlanError::Limit {
            what: format!("environment map `{}`", map.name),
            found: format!("{} x {} texels", map.width, map.height),
            limit: format!("the device takes {} along an axis", limits.max_image_2d),
            fix: "scale the picture down".to_owned(),
        });
    }
    Ok(Some(map))
}

/// Whether bounds for parts of the volume could not make flights longer: it is even, or thin.
fn is_one_leaf(scene: &Scene, table: &Table) -> bool {
    let bounds = leaves::bounds(scene, table);
    let even = bounds.max - bounds.min <= 1e-3 * bounds.max;
    even || f64::from(bounds.max) * scene.volume.grid.diagonal() <= 1.0
}

/// Whether the table holds one colour and extinctions on a straight line, to rounding.
fn is_straight(baked: &[[f32; 4]]) -> bool {
    let (first, last) = (baked[0], baked[baked.len() - 1]);
    let slope = (last[3] - first[3]) / (baked.len() - 1) as f32;
    let room = 1e-5 * first[3].max(last[3]);
    baked.iter().enumerate().all(|(i, e)| {
        let line = slope.mul_add(i as f32, first[3]);
        e[..3] == first[..3] && (e[3] - line).abs() <= room
    })
}

impl PathTracePlan {
    /// The stage that walks: the one that reads the volume as the medium holds it.
    #[must_use]
    pub fn trace(&self) -> StageLayout {
        layout::trace_for(&self.medium)
    }

    /// The plan as shown to the user.
    #[must_use]
    pub fn summary(&self, _scene: &Scene) -> Plan {
        let pixels = UVec3::new(self.image[0], self.image[1], 1);
        let mut stages = self.medium.stages();
        if let Some(cells) = self.leaves {
            stages.push(StagePlan {
                name: stage::UPLOAD_LEAVES,
                depends_on: Inputs::of(&[Input::Volume, Input::TransferFunction]),
                domain: cells,
                dispatches: 1,
                specialization: Vec::new(),
            });
        }
        stages.extend(self.uploads());
        stages.push(StagePlan {
            name: self.trace().shader.name,
            depends_on: Inputs::of(&Input::ALL),
            domain: pixels,
            // At least: as many follow as the longest paths need.
            dispatches: 1,
            specialization: self.specialization.clone(),
        });
        stages.push(StagePlan {
            name: stage::READ_BACK,
            depends_on: Inputs::of(&Input::ALL),
            domain: pixels,
            dispatches: 1,
            specialization: Vec::new(),
        });
        let mut resources = self.medium.resources();
        resources.extend(target::resources(self.image));
        let texels = u64::from(self.image[0]) * u64::from(self.image[1]);
        let image = |name, extent: UVec3, format, bytes| ResourcePlan {
            name,
            kind: ResourceKind::Image,
            extent,
            format,
            bytes,
            shrink: "lower image.width and image.height",
        };
        let walkers = UVec3::new(self.image[0], self.image[1], WALKER_LAYERS);
        let (float, word) = (Format::R32G32B32A32_SFLOAT, Format::R32G32B32A32_UINT);
        let layers = u64::from(WALKER_LAYERS);
        let cells = self.leaves.unwrap_or(UVec3::ONE);
        resources.push(ResourcePlan {
            name: "leaves",
            kind: ResourceKind::Auxiliary,
            extent: cells,
            format: Format::R32G32_UINT,
            bytes: 8 * cells.as_u64vec3().element_product(),
            shrink: "use a smaller volume",
        });
        resources.extend(self.pictures());
        resources.extend([
            image("moments", pixels, float, 16 * texels),
            image("walkers", walkers, word, 16 * layers * texels),
            image("counters", UVec3::new(2, 1, 1), Format::R32_UINT, 8),
            image(
                "counters_read_back",
                UVec3::new(8, 1, 1),
                Format::UNDEFINED,
                8,
            ),
        ]);
        let mut omitted = self.medium.omitted();
        omitted.extend(self.omitted.iter().cloned());
        Plan {
            technique: NAME,
            stages,
            resources,
            omitted,
        }
    }

    /// Transfers of what the scene brings beside its volume.
    fn uploads(&self) -> Vec<StagePlan> {
        let stage = |name, input, domain| StagePlan {
            name,
            depends_on: Inputs::of(&[input]),
            domain,
            dispatches: 1,
            specialization: Vec::new(),
        };
        let mut stages = Vec::new();
        if self.maps.0 != UVec2::ONE {
            let texels = self.maps.0.extend(1);
            stages.push(stage(stage::UPLOAD_ENVIRONMENT, Input::Light, texels));
        }
        stages.extend(self.albedo.stage(stage::UPLOAD_ALBEDO));
        stages
    }

    /// Images of the environment map, its table and the albedo volume; of one texel where there is none.
    fn pictures(&self) -> [ResourcePlan; 3] {
        let resource = |name, extent: UVec3, format, texel_bytes, shrink| ResourcePlan {
            name,
            kind: ResourceKind::Auxiliary,
            extent,
            format,
            bytes: texel_bytes * extent.as_u64vec3().element_product(),
            shrink,
        };
        let float = Format::R32G32B32A32_SFLOAT;
        let (map, table) = (self.maps.0.extend(1), self.maps.1.extend(1));
        let smaller = "scale the picture down";
        [
            resource("environment_map", map, float, 16, smaller),
            resource("environment_alias", table, float, 16, smaller),
            self.albedo.resource(),
        ]
    }
}
