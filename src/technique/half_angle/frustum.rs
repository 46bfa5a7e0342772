//! What a light sees of the volume: the frustum that its buffer spans. Positions are world units relative to the
//! volume's centre.

use glam::{DVec2, DVec3, UVec2};

use super::sweep::corners;
use crate::scene::{Light, Scene};

/// Texels along the longer side where they are chosen: light bends at the volume's edges whatever the voxels,
/// and the paper's buffers had no more.
const AUTOMATIC: (f64, f64) = (64.0, 512.0);

/// A point light that sees all of the volume within this cosine of one direction has one frustum.
const WIDEST: f64 = 0.5;

/// Where light comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// Parallel light travels along the frustum's axis.
    Far,
    /// Light from a point.
    At(DVec3),
}

/// The light buffer's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct LightFrustum {
    /// Which of the scene's directional and point lights.
    pub light: u32,
    /// Where it is.
    pub place: Place,
    /// Unit vector that light travels along in the middle.
    pub axis: DVec3,
    /// Unit vectors along the buffer's rows and columns.
    pub across: [DVec3; 2],
    /// Lower corner of the buffer: along `across` in world units, from a point per unit distance along the axis.
    pub low: DVec2,
    /// Size of a texel, likewise.
    pub texel_size: f64,
    /// Texels along rows and columns.
    pub texels: UVec2,
    /// Whether the light also shines on parts of the volume outside of the frustum.
    pub is_part: bool,
}

/// The frusta through which a light shines on what is kept of the volume: one, or up to six faces of a cube about
/// a point light that is inside or close. `texels` along the longer side, if given.
#[must_use]
pub fn frusta(scene: &Scene, light: &Light, index: u32, texels: Option<u32>) -> Vec<LightFrustum> {
    let corners = corners(scene);
    match light {
        Light::Directional { direction, .. } => {
            let axis = direction.normalize_or(-DVec3::Z);
            vec![fitted(scene, (index, Place::Far, axis), &corners, texels)]
        }
        Light::Point { position, .. } => {
            let place = *position - scene.volume.grid.centre();
            let middle = corners.iter().sum::<DVec3>() / 8.0;
            let axis = (middle - place).normalize_or(-DVec3::Z);
            let is_narrow = corners
                .iter()
                .all(|x| (*x - place).normalize_or(-axis).dot(axis) >= WIDEST);
            if is_narrow {
                vec![fitted(
                    scene,
                    (index, Place::At(place), axis),
                    &corners,
                    texels,
                )]
            } else {
                faces(scene, index, place, &corners, texels)
            }
        }
        Light::Environment { .. } | Light::EnvironmentMap { .. } => Vec::new(),
    }
}

/// The buffer around all that the light sees of the corners.
fn fitted(
    scene: &Scene,
    (light, place, axis): (u32, Place, DVec3),
    corners: &[DVec3; 8],
    texels: Option<u32>,
) -> LightFrustum {
    let (u, v) = axis.any_orthonormal_pair();
    let mut frustum = LightFrustum {
        light,
        place,
        axis,
        across: [u, v],
        low: DVec2::ZERO,
        texel_size: 1.0,
        texels: UVec2::ONE,
        is_part: false,
    };
    let seen = corners.map(|x| frustum.project(x).unwrap_or(DVec2::ZERO));
    let low = seen.into_iter().fold(DVec2::INFINITY, DVec2::min);
    let high = seen.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max);
    frustum.low = low;
    let distance = match place {
        Place::Far => 1.0,
        Place::At(p) => (corners.iter().sum::<DVec3>() / 8.0 - p).dot(axis),
    };
    frustum.divide(high - low, voxel(scene) / distance, texels);
    frustum
}

/// Faces of a cube about a point light, those behind which the volume may lie.
fn faces(
    scene: &Scene,
    light: u32,
    place: DVec3,
    corners: &[DVec3; 8],
    texels: Option<u32>,
) -> Vec<LightFrustum> {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|a| [a, -a]);
    let farthest = corners
        .iter()
        .map(|x| x.distance(place))
        .fold(0.0, f64::max);
    let face = |axis: DVec3| {
        let (u, v) = axis.any_orthonormal_pair();
        // In front of the light, and above each side of the pyramid.
        let sides = [axis, axis + u, axis - u, axis + v, axis - v];
        let is_seen = |side: &DVec3| corners.iter().any(|x| (*x - place).dot(*side) > 0.0);
        let mut frustum = LightFrustum {
            light,
            place: Place::At(place),
            axis,
            across: [u, v],
            low: DVec2::NEG_ONE,
            texel_size: 1.0,
            texels: UVec2::ONE,
            is_part: true,
        };
        let half = 0.5 * farthest;
        frustum.divide(DVec2::splat(2.0), voxel(scene) / half, texels);
        sides.iter().all(is_seen).then_some(frustum)
    };
    axes.into_iter().flatten().filter_map(face).collect()
}

fn voxel(scene: &Scene) -> f64 {
    scene.volume.grid.spacing().min_element()
}

impl LightFrustum {
    /// Square texels over `extent`, each as large as a voxel seen, unless a number is given.
    fn divide(&mut self, extent: DVec2, voxel: f64, texels: Option<u32>) {
        let longer = extent.max_element().max(f64::MIN_POSITIVE);
        let count = texels.map_or_else(
            || (longer / voxel).ceil().clamp(AUTOMATIC.0, AUTOMATIC.1),
            f64::from,
        );
        self.texel_size = longer / count;
        let counts = (extent / self.texel_size - 1e-6).ceil();
        self.texels = counts.clamp(DVec2::ONE, DVec2::splat(count)).as_uvec2();
        // What a shorter side has too much lies evenly on both sides.
        self.low -= 0.5 * (self.texels.as_dvec2() * self.texel_size - extent);
    }

    /// A point on the axis by the volume, and its distance from a point light: what is computed about it in single
    /// precision stays precise however far away the light is.
    #[must_use]
    pub fn anchor(&self) -> (DVec3, f64) {
        match self.place {
            Place::Far => (DVec3::ZERO, 1.0),
            Place::At(place) => {
                let distance = (-place).dot(self.axis).max(0.0);
                (place + distance * self.axis, distance)
            }
        }
    }

    /// Coordinates along rows and columns; none behind a point light.
    fn project(&self, x: DVec3) -> Option<DVec2> {
        let [u, v] = self.across;
        match self.place {
            Place::Far => Some(DVec2::new(x.dot(u), x.dot(v))),
            Place::At(place) => {
                let from = x - place;
                let depth = from.dot(self.axis);
                (depth > 1e-6 * from.length()).then(|| DVec2::new(from.dot(u), from.dot(v)) / depth)
            }
        }
    }

    /// Place in the buffer, in texels from its lower corner.
    #[must_use]
    pub fn texel(&self, x: DVec3) -> Option<DVec2> {
        self.project(x).map(|p| (p - self.low) / self.texel_size)
    }

    /// Unit vectors along the rays of light at the corners.
    #[must_use]
    pub fn corner_rays(&self) -> [DVec3; 4] {
        let [u, v] = self.across;
        let extent = self.texels.as_dvec2() * self.texel_size;
        [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(x, y)| match self.place {
            Place::Far => self.axis,
            Place::At(_) => {
                let p = self.low + extent * DVec2::new(x, y);
                (self.axis + p.x * u + p.y * v).normalize()
            }
        })
    }
}
