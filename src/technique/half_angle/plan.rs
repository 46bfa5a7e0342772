//! What `half_angle` does for a scene.

use glam::{UVec2, UVec3};

use super::frustum::frusta;
use super::sweep::{Lens, Sweep};
use super::{NAME, layout};
use crate::gpu::{Format, Limits, Specialization, StageLayout};
use crate::scene::{HalfAngleParams, Light, Lighting, Scene, SurfaceShading, TransportColor};
use crate::technique::albedo_volume::AlbedoPlan;
use crate::technique::medium::MediumPlan;
use crate::technique::{
    Input, Inputs, Omission, Plan, PlanError, ResourceKind, ResourcePlan, StagePlan, lights, seen,
    target,
};

/// Stage names of the technique.
pub mod stage {
    /// All slices: `shade_slice` and `propagate` in turn.
    pub const SWEEP: &str = "half_angle.sweep";
    /// A slice as the viewer sees it, the volume read through the device's filter.
    pub const SHADE_SLICE: &str = "half_angle.shade_slice";
    /// The same by loads of 8-bit texels.
    pub const SHADE_SLICE_R8: &str = "half_angle.shade_slice_r8";
    /// The same by loads of 16-bit texels.
    pub const SHADE_SLICE_R16: &str = "half_angle.shade_slice_r16";
    /// The same by loads of float texels.
    pub const SHADE_SLICE_R32F: &str = "half_angle.shade_slice_r32f";
    /// Light on its way through a slice, the volume read through the device's filter.
    pub const PROPAGATE: &str = "half_angle.propagate";
    /// The same by loads of 8-bit texels.
    pub const PROPAGATE_R8: &str = "half_angle.propagate_r8";
    /// The same by loads of 16-bit texels.
    pub const PROPAGATE_R16: &str = "half_angle.propagate_r16";
    /// The same by loads of float texels.
    pub const PROPAGATE_R32F: &str = "half_angle.propagate_r32f";
    /// What a sweep gathered joins the image.
    pub const COMPOSE: &str = "half_angle.compose";
    /// Transfer of the phase function and transport colours.
    pub const UPLOAD_TABLES: &str = "half_angle.upload_tables";
    /// Transfer of the albedo volume.
    pub const UPLOAD_ALBEDO: &str = "half_angle.upload_albedo";
    /// Copy of the image to the host.
    pub const READ_BACK: &str = "half_angle.read_back";
}

/// Constants of `half_angle.propagate`, in the order of their ids.
pub const PROPAGATE_CONSTANTS: [Specialization; 11] = [
    Specialization::new(0, "SKIP_EMPTY"),
    Specialization::new(1, "MASKED"),
    Specialization::new(2, "CLIP_BOX"),
    Specialization::new(3, "CLIP_PLANE"),
    Specialization::new(4, "POINT_LIGHTS"),
    Specialization::new(5, "INDIRECT"),
    Specialization::new(6, "ISOTROPIC"),
    Specialization::new(7, "ALBEDO_VOLUME"),
    Specialization::new(8, "TRANSPORT_TABLE"),
    Specialization::new(9, "QUADS"),
    Specialization::new(10, "ROWS"),
];

/// Constants of `half_angle.shade_slice`, in the order of their ids.
pub const SHADE_CONSTANTS: [Specialization; 16] = [
    PROPAGATE_CONSTANTS[0],
    PROPAGATE_CONSTANTS[1],
    PROPAGATE_CONSTANTS[2],
    PROPAGATE_CONSTANTS[3],
    PROPAGATE_CONSTANTS[4],
    PROPAGATE_CONSTANTS[5],
    PROPAGATE_CONSTANTS[6],
    PROPAGATE_CONSTANTS[7],
    PROPAGATE_CONSTANTS[8],
    Specialization::new(9, "LIT"),
    Specialization::new(10, "EMISSION"),
    Specialization::new(11, "PARTS"),
    Specialization::new(12, "PHASE_TABLE"),
    Specialization::new(13, "SURFACE"),
    Specialization::new(14, "SHADE"),
    Specialization::new(15, "ROWS"),
];

/// On software drivers, which load what all invocations share for each of them.
const ROWS: u32 = 4;

/// Most slices of a sweep: rays along them have two samples in three slices, in as many rounds of three loops and
/// for each row, and a shader's rounds end at 65,535.
const MAX_SLICES: u32 = 8_000;

/// Along the longest side, slices are no thicker at a spacing of 1: light also bends at the volume's edges,
/// whatever the voxels.
const LEAST_SLICES: f64 = 64.0;

/// Invocations a submission: a desktop GPU stays responsive, a software driver answers every few seconds.
pub(super) const MAX_INVOCATIONS: u64 = 1 << 27;

/// A mean free path is at most this share of the volume's size.
const LARGEST_FREE_PATH: f64 = 1.0 / 16.0;

/// Pure data: everything decided for one scene.
#[derive(Clone, Debug, PartialEq)]
pub struct HalfAnglePlan {
    /// The medium's part.
    pub medium: MediumPlan,
    /// One for each light, or part of a light's buffer, at least one; the first has depth and emission.
    pub sweeps: Vec<Sweep>,
    /// The camera.
    pub lens: Lens,
    /// Whether each sweep is for the light of its number, without shadows.
    pub unshadowed: bool,
    /// Texels of both light buffers; 1 x 1 where no light is propagated.
    pub buffer: UVec2,
    /// Mean free path of what is seen, world units, at most a sixteenth of the volume.
    pub free_path: f64,
    /// Variance, along each axis across the light, of scattered light's spread per world unit of way.
    pub spread: f64,
    /// Rows of the phase table; 1 without one.
    pub phase_rows: u32,
    /// Entries of the transport colours; 1 where the albedo decides.
    pub transport_entries: u32,
    /// Pixels or texels, one under another, that an invocation goes through.
    pub rows: u32,
    /// Constants of `half_angle.shade_slice`.
    pub shade_constants: Vec<Specialization>,
    /// Constants of `half_angle.propagate`.
    pub propagate_constants: Vec<Specialization>,
    pub(super) albedo: AlbedoPlan,
    /// Image width and height.
    pub image: [u32; 2],
    /// Sub-samples a pixel, each with sweeps of its own.
    pub sub_samples: u32,
    omitted: Vec<Omission>,
}

/// Plans the technique for a scene.
///
/// # Errors
/// The scene exceeds a limit of the device or the shader.
pub fn plan(
    scene: &Scene,
    params: &HalfAngleParams,
    limits: &Limits,
) -> Result<HalfAnglePlan, PlanError> {
    let image = &scene.image;
    target::check(image, limits)?;
    let (lights, points) = lights::count(scene, NAME)?;
    let no_skipping = (!params.empty_space_skipping).then_some("empty_space_skipping is off");
    let medium = MediumPlan::new(scene, no_skipping, limits)?;
    let shadowed = matches!(params.lighting, Lighting::Direct | Lighting::Indirect) && lights > 0;
    let sweeps = sweeps(scene, params, (shadowed, lights))?;
    let buffer = buffer(&sweeps, limits)?;
    let free_path = free_path(scene);
    let tan = (0.5 * params.blur_angle_deg).to_radians().tan();
    let albedo = AlbedoPlan::new(scene);
    let indirect = shadowed && params.lighting == Lighting::Indirect;
    let by_table = indirect && params.transport_color != TransportColor::Auto;
    let emits = match params.lighting {
        Lighting::None => true,
        Lighting::Surface => false,
        _ => scene.medium.emission > 0.0,
    };
    let shared = [
        medium.cells.is_some(),
        medium.masked,
        scene.clip.bounds.is_some(),
        scene.clip.plane.is_some(),
        points,
        indirect,
        scene.medium.phase_g == 0.0,
        albedo.is_there && shadowed,
        by_table,
    ]
    .map(u32::from);
    let own = [
        shadowed,
        emits,
        sweeps
            .iter()
            .any(|s| s.light.as_ref().is_some_and(|l| l.is_part)),
        shadowed && params.phase_table.is_some(),
        shadowed && params.surface == SurfaceShading::Gradient,
        params.lighting == Lighting::Surface,
    ]
    .map(u32::from);
    let rows = if limits.prefers_loads { ROWS } else { 1 };
    let shade = [&shared[..], &own[..], &[rows]].concat();
    let propagate = [&shared[..], &[params.blur_samples / 4, rows]].concat();
    let phase_rows = params.phase_table.as_ref().map_or(1, |t| t.len() as u32);
    Ok(HalfAnglePlan {
        rows,
        shade_constants: medium.with_constants(&SHADE_CONSTANTS, &shade),
        propagate_constants: medium.with_constants(&PROPAGATE_CONSTANTS, &propagate),
        sweeps,
        lens: Lens::new(scene),
        unshadowed: params.lighting == Lighting::Surface,
        buffer,
        free_path,
        // Of a disc of the radius `d tan(theta / 2)` [Kniss2003, Eq. 9], every `d` of a mean free path.
        spread: 0.25 * tan * tan * free_path,
        phase_rows,
        transport_entries: if by_table { medium.table.entries } else { 1 },
        albedo,
        image: [image.width, image.height],
        sub_samples: image.samples_per_axis * image.samples_per_axis,
        omitted: omitted(scene, params, &medium, (lights, points, shadowed)),
        medium,
    })
}

/// One sweep for each light; for the parts of one that are in different directions from within the volume, one each;
/// without shadows, slices across the view.
fn sweeps(
    scene: &Scene,
    params: &HalfAngleParams,
    (shadowed, lights): (bool, u32),
) -> Result<Vec<Sweep>, PlanError> {
    let grid = &scene.volume.grid;
    let longest = (grid.spacing() * grid.dims.as_dvec3()).max_element();
    let unit = grid.spacing().min_element().min(longest / LEAST_SLICES);
    let thickness = params.slice_spacing * unit;
    let lamps = scene.lights.iter().filter(|l| is_lamp(l));
    let list: Vec<_> = if shadowed {
        (0..)
            .zip(lamps)
            .flat_map(|(i, light)| frusta(scene, light, i, params.light_buffer))
            .map(|frustum| Sweep::new(scene, Some(frustum), thickness))
            .collect()
    } else {
        let count = match params.lighting {
            Lighting::Surface => lights.max(1),
            _ => 1,
        };
        vec![Sweep::new(scene, None, thickness); count as usize]
    };
    let most = list.iter().map(|s| s.slices).max().unwrap_or(0);
    if most > MAX_SLICES {
        let spacing = params.slice_spacing * f64::from(most) / f64::from(MAX_SLICES);
        return Err(PlanError::Limit {
            what: "technique.half_angle.slice_spacing".to_owned(),
            found: format!("{most} slices"),
            limit: format!("a sweep has at most {MAX_SLICES}"),
            fix: format!("raise the spacing to at least {spacing:.4}"),
        });
    }
    Ok(list)
}

const fn is_lamp(light: &Light) -> bool {
    matches!(light, Light::Directional { .. } | Light::Point { .. })
}

/// The largest light buffer of all sweeps.
fn buffer(sweeps: &[Sweep], limits: &Limits) -> Result<UVec2, PlanError> {
    let sizes = sweeps.iter().filter_map(|s| s.light.as_ref());
    let size = sizes.fold(UVec2::ONE, |size, light| size.max(light.texels));
    if size.max_element() <= limits.max_image_2d {
        return Ok(size);
    }
    Err(PlanError::Limit {
        what: "technique.half_angle.light_buffer".to_owned(),
        found: format!("{} x {} texels", size.x, size.y),
        limit: format!(
            "the device's images reach {} along an axis",
            limits.max_image_2d
        ),
        fix: "lower it".to_owned(),
    })
}

/// Mean free path of what is seen, within the volume's size.
fn free_path(scene: &Scene) -> f64 {
    let grid = &scene.volume.grid;
    let size = grid.spacing() * grid.dims.as_dvec3();
    let largest = LARGEST_FREE_PATH * size.element_product().cbrt();
    seen::free_path(scene).min(largest)
}

/// What the scene cannot show, and why.
fn omitted(
    scene: &Scene,
    params: &HalfAngleParams,
    medium: &MediumPlan,
    (lights, points, shadowed): (u32, bool, bool),
) -> Vec<Omission> {
    let mut list = medium.omitted();
    let mut omit = |what, left_out: bool, why: &str| {
        if left_out {
            let why = why.to_owned();
            list.push(Omission { what, why });
        }
    };
    let none = "the scene has none";
    omit("clip box", scene.clip.bounds.is_none(), none);
    omit("clip plane", scene.clip.plane.is_none(), none);
    let no_light = "the scene has no directional or point light";
    let unlit = match params.lighting {
        Lighting::None => "lighting is none: the colour is source radiance",
        Lighting::Surface => "lighting is surface: no shadows",
        _ => no_light,
    };
    omit("propagate", !shadowed, unlit);
    let direct = params.lighting == Lighting::Direct;
    omit("indirect light", shadowed && direct, "lighting is direct");
    omit("point lights", lights > 0 && !points, none);
    omit(
        "phase table",
        params.phase_table.is_none(),
        "g stands for it",
    );
    let even = scene.medium.phase_g == 0.0 && params.phase_table.is_none();
    omit("phase function", even, "g is 0");
    let no_surface = params.surface == SurfaceShading::None;
    omit("surfaces", shadowed && no_surface, "surface is none");
    omit("emission", scene.medium.emission <= 0.0, "its factor is 0");
    let no_colors = scene.medium.albedo_volume.is_none();
    omit("albedo volume", no_colors, none);
    omit(
        "environment lights",
        params.lighting != Lighting::Surface && scene.lights.iter().any(|l| !is_lamp(l)),
        "half_angle has none: the image lacks their light, path_trace shows it",
    );
    list
}

impl HalfAnglePlan {
    /// The stage that shades: the one that reads the volume as the medium holds it.
    #[must_use]
    pub fn shade(&self) -> StageLayout {
        layout::shade_for(&self.medium)
    }

    /// The stage that propagates, likewise.
    #[must_use]
    pub fn propagate(&self) -> StageLayout {
        layout::propagate_for(&self.medium)
    }

    /// Whether light is propagated through slices.
    #[must_use]
    pub fn is_shadowed(&self) -> bool {
        self.sweeps.iter().any(|s| s.light.is_some())
    }

    /// What the tables are made from.
    const TABLES: Inputs = Inputs::of(&[Input::TransferFunction, Input::Parameters]);

    fn own_stages(&self) -> Vec<StagePlan> {
        let pixels = UVec3::new(self.image[0], self.image[1], 1);
        let slices: u32 = self.sweeps.iter().map(|s| s.slices).sum();
        let stage = |name, depends_on, domain, dispatches| StagePlan {
            name,
            depends_on,
            domain,
            dispatches,
            specialization: Vec::new(),
        };
        let all = Inputs::of(&Input::ALL);
        let mut stages = Vec::new();
        let rows = self.phase_rows.max(self.transport_entries);
        if rows > 1 {
            let domain = UVec3::new(rows, 1, 1);
            stages.push(stage(stage::UPLOAD_TABLES, Self::TABLES, domain, 2));
        }
        let dispatches = slices.saturating_mul(self.sub_samples);
        stages.push(stage(stage::SWEEP, all, pixels, dispatches));
        let mut shade = stage(self.shade().shader.name, all, pixels, dispatches);
        shade.specialization.clone_from(&self.shade_constants);
        stages.push(shade);
        if self.is_shadowed() {
            let domain = self.buffer.extend(1);
            let mut propagate = stage(self.propagate().shader.name, all, domain, dispatches);
            propagate
                .specialization
                .clone_from(&self.propagate_constants);
            stages.push(propagate);
        }
        let composed = self.sweeps.len() as u32 * self.sub_samples;
        stages.push(stage(stage::COMPOSE, all, pixels, composed));
        stages.push(stage(stage::READ_BACK, all, pixels, 1));
        stages
    }

    /// The plan as shown to the user.
    #[must_use]
    pub fn summary(&self, _scene: &Scene) -> Plan {
        let mut stages = self.medium.stages();
        stages.extend(self.albedo.stage(stage::UPLOAD_ALBEDO));
        stages.extend(self.own_stages());
        let image = |name, kind, extent: UVec3, shrink| ResourcePlan {
            name,
            kind,
            extent,
            format: Format::R32G32B32A32_SFLOAT,
            bytes: 16 * extent.as_u64vec3().element_product(),
            shrink,
        };
        let pixels = UVec3::new(self.image[0], self.image[1], 1);
        let (kind, buffer) = (ResourceKind::Auxiliary, self.buffer.extend(1));
        let smaller = "lower technique.half_angle.light_buffer";
        let rows = |rows| UVec3::new(rows, 1, 1);
        let mut resources = self.medium.resources();
        resources.extend([
            image("light_buffer", kind, buffer, smaller),
            image("light_buffer_pong", kind, buffer, smaller),
            image(
                "eye_buffer",
                ResourceKind::Image,
                pixels,
                "lower image.width and image.height",
            ),
            image(
                "phase_table",
                kind,
                rows(self.phase_rows),
                "give fewer rows",
            ),
            image(
                "transport",
                kind,
                rows(self.transport_entries),
                "set transport_color = \"auto\"",
            ),
        ]);
        resources.push(self.albedo.resource());
        resources.extend(target::resources(self.image));
        Plan {
            technique: NAME,
            stages,
            resources,
            omitted: self.omitted.clone(),
        }
    }
}
