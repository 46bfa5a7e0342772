//! What `ray_march` does for a scene.

use glam::UVec3;

use super::{NAME, layout};
use crate::gpu::{Limits, Specialization, StageLayout};
use crate::scene::{RayMarchParams, Scene};
use crate::technique::medium::MediumPlan;
use crate::technique::{
    Input, Inputs, Omission, Plan, PlanError, StagePlan, Tiles, lights, target,
};

/// Stage names of the technique.
pub mod stage {
    /// The radiance of every pixel, the volume read through the device's filter.
    pub const MARCH: &str = "ray_march.march";
    /// The same by loads of 8-bit texels.
    pub const MARCH_R8: &str = "ray_march.march_r8";
    /// The same by loads of 16-bit texels.
    pub const MARCH_R16: &str = "ray_march.march_r16";
    /// The same by loads of float texels.
    pub const MARCH_R32F: &str = "ray_march.march_r32f";
    /// Copy of the image to the host.
    pub const READ_BACK: &str = "ray_march.read_back";
}

/// Constants of `ray_march.march`, in the order of their ids.
pub const CONSTANTS: [Specialization; 10] = {
    [
        Specialization::new(0, "SKIP_EMPTY"),
        Specialization::new(1, "SHADE"),
        Specialization::new(2, "SPECULAR"),
        Specialization::new(3, "MASKED"),
        Specialization::new(4, "CLIP_BOX"),
        Specialization::new(5, "CLIP_PLANE"),
        Specialization::new(6, "LIGHT_COUNT"),
        Specialization::new(7, "POINT_LIGHTS"),
        Specialization::new(8, "SPREAD"),
        Specialization::new(9, "BLOCK"),
    ]
};

/// Loop rounds an invocation: lavapipe silently stops a shader after 65,535 in all loops together.
const MAX_ROUNDS: f64 = 60_000.0;

/// Pure data: everything decided for one scene.
#[derive(Clone, Debug, PartialEq)]
pub struct RayMarchPlan {
    /// The medium's part.
    pub medium: MediumPlan,
    /// Constants of `ray_march.march`.
    pub specialization: Vec<Specialization>,
    /// Image width and height.
    pub image: [u32; 2],
    /// How the image is marched.
    pub tiles: Tiles,
    omitted: Vec<Omission>,
}

/// Plans the technique for a scene.
///
/// # Errors
/// The scene exceeds a limit of the device or the shader.
pub fn plan(
    scene: &Scene,
    params: &RayMarchParams,
    limits: &Limits,
) -> Result<RayMarchPlan, PlanError> {
    let image = &scene.image;
    target::check(image, limits)?;
    let (lights, points) = lights::count(scene, NAME)?;
    let samples_per_ray = longest_ray(scene, params)?;
    let tiles = Tiles::new(image, samples_per_ray as f64, limits);
    Ok(RayMarchPlan {
        medium: MediumPlan::new(scene, no_skipping(params), limits)?,
        specialization: Vec::new(),
        image: [image.width, image.height],
        tiles,
        omitted: Vec::new(),
    }
    .specialise(scene, params, (lights, points), limits))
}

/// Why no cells are wanted, if they are not.
fn no_skipping(params: &RayMarchParams) -> Option<&'static str> {
    (!params.empty_space_skipping).then_some("empty_space_skipping is off")
}

/// Samples in a row between two looks at the cells: lit, longer, because they share gradients.
const fn block(lit: bool) -> u32 {
    if lit { 8 } else { 4 }
}

/// Samples on the longest possible ray.
fn longest_ray(scene: &Scene, params: &RayMarchParams) -> Result<u64, PlanError> {
    let samples = (scene.volume.grid.diagonal() / layout::step_length(scene, params)).ceil();
    // A look at the cells leaps a sample at least, or ends with a block of four; lit, blocks begin at
    // multiples of four, and each has at most four gradients.
    let rounds = if params.shading.is_some() { 2.25 } else { 1.0 };
    if samples * rounds > MAX_ROUNDS {
        return Err(PlanError::Limit {
            what: "technique.ray_march.step".to_owned(),
            found: format!("{samples} samples on the longest ray"),
            limit: format!("a ray takes at most {}", (MAX_ROUNDS / rounds).floor()),
            fix: format!(
                "raise the step to at least {:.4}",
                params.step * samples * rounds / MAX_ROUNDS
            ),
        });
    }
    Ok(samples as u64)
}

impl RayMarchPlan {
    /// Decides the constants, and with them what is compiled in; notes what is not.
    fn specialise(
        mut self,
        scene: &Scene,
        params: &RayMarchParams,
        (lights, points): (u32, bool),
        limits: &Limits,
    ) -> Self {
        let shade = params.shading.is_some();
        let lit = if shade { lights } else { 0 };
        let points = lit > 0 && points;
        let specular = lit > 0 && params.shading.is_some_and(|s| s.specular > 0.0);
        let values = [
            u32::from(self.medium.cells.is_some()),
            u32::from(shade),
            u32::from(specular),
            u32::from(self.medium.masked),
            u32::from(scene.clip.bounds.is_some()),
            u32::from(scene.clip.plane.is_some()),
            lit,
            u32::from(points),
            limits.worker_threads,
            block(shade),
        ];
        self.specialization = self.medium.with_constants(&CONSTANTS, &values);
        let mut omit = |what, left_out: bool, why: &str| {
            if left_out {
                self.omitted.push(Omission {
                    what,
                    why: why.to_owned(),
                });
            }
        };
        omit(
            "gradient",
            !shade,
            "shading is off: the colour is source radiance",
        );
        omit(
            "specular",
            shade && lit > 0 && !specular,
            "shading.specular is 0",
        );
        omit(
            "lights",
            shade && lit == 0,
            "the scene has no directional or point light",
        );
        omit(
            "lights",
            !shade && lights > 0,
            "shading is off: no light is looked at",
        );
        omit(
            "clip box",
            scene.clip.bounds.is_none(),
            "the scene has none",
        );
        omit(
            "clip plane",
            scene.clip.plane.is_none(),
            "the scene has none",
        );
        omit(
            "phase function",
            true,
            "emission-absorption does not scatter",
        );
        self
    }

    /// The stage that marches: the one that reads the volume as the medium holds it.
    #[must_use]
    pub fn march(&self) -> StageLayout {
        layout::march_for(&self.medium)
    }

    /// The plan as shown to the user.
    #[must_use]
    pub fn summary(&self, scene: &Scene) -> Plan {
        let mut depends = vec![
            Input::Volume,
            Input::TransferFunction,
            Input::Camera,
            Input::Clip,
            Input::Image,
            Input::Parameters,
        ];
        if scene.technique.uses_lights() {
            depends.push(Input::Light);
        }
        let pixels = UVec3::new(self.image[0], self.image[1], 1);
        let mut stages = self.medium.stages();
        stages.push(StagePlan {
            name: self.march().shader.name,
            depends_on: Inputs::of(&depends),
            domain: pixels,
            dispatches: self.tiles.bands() * self.tiles.sub_samples,
            specialization: self.specialization.clone(),
        });
        stages.push(StagePlan {
            name: stage::READ_BACK,
            depends_on: Inputs::of(&depends),
            domain: pixels,
            dispatches: 1,
            specialization: Vec::new(),
        });
        let mut resources = self.medium.resources();
        resources.extend(target::resources(self.image));
        let mut omitted = self.medium.omitted();
        omitted.extend(self.omitted.iter().cloned());
        Plan {
            technique: NAME,
            stages,
            resources,
            omitted,
        }
    }
}
