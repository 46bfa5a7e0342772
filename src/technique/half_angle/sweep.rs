//! The geometry of a sweep: slices across an axis half way between light and view, and what each covers of the
//! image and of the light buffer. Positions are world units relative to the volume's centre.

use glam::{DVec2, DVec3, IVec2, UVec2, UVec3};

use super::frustum::{LightFrustum, Place};
use crate::scene::{Projection, Scene};
use crate::technique::nodes::kept;

/// Texels or pixels around what is computed to be covered: rounding leaves none out.
const MARGIN: f64 = 1.0;

/// Of the slice axis to each ray of light, the least cosine: more oblique rays cross too few slices.
const LEAST_COSINE: f64 = 0.25;

/// Texels or pixels from `low` on, below `high`; none where `high` is not above `low`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rect {
    /// The first.
    pub low: IVec2,
    /// Beyond the last.
    pub high: IVec2,
}

impl Rect {
    const NONE: Self = Self {
        low: IVec2::ZERO,
        high: IVec2::ZERO,
    };

    /// Whether nothing is in it.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.low.x >= self.high.x || self.low.y >= self.high.y
    }

    /// Width and height.
    #[must_use]
    pub fn size(&self) -> UVec2 {
        (self.high - self.low).max(IVec2::ZERO).as_uvec2()
    }

    fn whole(size: UVec2) -> Self {
        Self {
            low: IVec2::ZERO,
            high: size.as_ivec2(),
        }
    }

    /// Around points, within `size`.
    fn around(points: impl Iterator<Item = DVec2>, size: UVec2) -> Self {
        let (low, high) = points.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| {
            (low.min(p), high.max(p))
        });
        // Far outside numbers would not fit 32 bits.
        let limit = size.as_dvec2();
        let low = (low - MARGIN).floor().clamp(DVec2::ZERO, limit);
        let high = (high + MARGIN).ceil().clamp(DVec2::ZERO, limit);
        Self {
            low: low.as_ivec2(),
            high: high.as_ivec2(),
        }
    }

    fn union(self, other: Self) -> Self {
        if self.is_empty() {
            return other;
        }
        if other.is_empty() {
            return self;
        }
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }
}

/// One pass through the volume, for one light or a part of its light.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// What reaches the volume; none: no light is propagated.
    pub light: Option<LightFrustum>,
    /// Unit vector across the slices, away from the light.
    pub axis: DVec3,
    /// Position of the first slice's near face along the axis.
    pub first: f64,
    /// Thickness of a slice, world units.
    pub thickness: f64,
    /// Slices.
    pub slices: u32,
    /// Whether the viewer at the middle of the volume sees the first slice first.
    pub front_to_back: bool,
    corners: [DVec3; 8],
}

/// A slice: the slab between two planes, and what is computed of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slice {
    /// Its faces along the axis; the outermost two lie at infinity, so that rounding cuts off no corner.
    pub faces: [f32; 2],
    /// Pixels that see it.
    pub pixels: Rect,
    /// Texels of the light buffer that light passes through it or passed through the one before: the others
    /// are the same in both buffers.
    pub texels: Rect,
}

impl Sweep {
    /// Slices no thicker than `thickness` through what is kept of the volume, for light of `frustum`.
    #[must_use]
    pub fn new(scene: &Scene, frustum: Option<LightFrustum>, thickness: f64) -> Self {
        let corners = corners(scene);
        let to_eye = to_eye(scene, &corners);
        let axis = frustum
            .as_ref()
            .map_or(-to_eye, |light| slice_axis(light, to_eye));
        let along = corners.map(|x| x.dot(axis));
        let low = along.into_iter().fold(f64::INFINITY, f64::min);
        let high = along.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let slices = ((high - low) / thickness - 1e-6).ceil().max(1.0);
        Self {
            light: frustum,
            axis,
            first: low,
            thickness: (high - low) / slices,
            slices: slices.min(f64::from(u32::MAX)) as u32,
            front_to_back: axis.dot(to_eye) <= 0.0,
            corners,
        }
    }

    /// Every slice in order.
    pub fn schedule<'a>(&'a self, lens: &'a Lens) -> impl Iterator<Item = Slice> + 'a {
        let mut before = Rect::NONE;
        (0..self.slices).map(move |index| {
            let outline = self.outline(index);
            let now = self.texels(&outline);
            let texels = before.union(now);
            before = now;
            Slice {
                faces: [self.face(index) as f32, self.face(index + 1) as f32],
                pixels: lens.pixels(&outline),
                texels,
            }
        })
    }

    /// Position along the axis; outermost faces lie at infinity.
    pub(super) fn face(&self, index: u32) -> f64 {
        match index {
            0 => f64::NEG_INFINITY,
            i if i >= self.slices => f64::INFINITY,
            i => self.first + f64::from(i) * self.thickness,
        }
    }

    /// Corners of the part of the box that is in a slice.
    fn outline(&self, index: u32) -> Vec<DVec3> {
        let (low, high) = (self.face(index), self.face(index + 1));
        let along = self.corners.map(|x| x.dot(self.axis));
        let inside = (0..8).filter(|&i| (low..=high).contains(&along[i]));
        let mut list: Vec<_> = inside.map(|i| self.corners[i]).collect();
        for (a, bit) in (0..8_usize).flat_map(|a| [1, 2, 4].map(|bit| (a, bit))) {
            let b = a | bit;
            if a == b {
                continue;
            }
            for face in [low, high] {
                let t = (face - along[a]) / (along[b] - along[a]);
                if t > 0.0 && t < 1.0 {
                    list.push(self.corners[a].lerp(self.corners[b], t));
                }
            }
        }
        list
    }

    fn texels(&self, outline: &[DVec3]) -> Rect {
        let Some(light) = &self.light else {
            return Rect::NONE;
        };
        let texels: Option<Vec<_>> = outline.iter().map(|x| light.texel(*x)).collect();
        texels.map_or(Rect::whole(light.texels), |list| {
            Rect::around(list.into_iter(), light.texels)
        })
    }
}

/// Half way between light and view, or light and inverted view, away from the light `[Kniss2003, III.A]`; nearer
/// to the light's axis where its rays would cross the slices too obliquely otherwise.
fn slice_axis(light: &LightFrustum, to_eye: DVec3) -> DVec3 {
    let to_light = -light.axis;
    let near = if to_light.dot(to_eye) >= 0.0 {
        to_eye
    } else {
        -to_eye
    };
    let half = -(to_light + near).normalize_or(to_light);
    let rays = light.corner_rays();
    let mut axis = half;
    for step in 1..=8 {
        if rays.iter().all(|w| w.dot(axis) >= LEAST_COSINE) {
            break;
        }
        axis = half
            .lerp(light.axis, f64::from(step) / 8.0)
            .normalize_or(light.axis);
    }
    axis
}

/// Unit vector from the middle of what is kept towards the viewer.
fn to_eye(scene: &Scene, corners: &[DVec3; 8]) -> DVec3 {
    let (camera, frame) = (&scene.camera, scene.camera.frame());
    let middle = corners.iter().sum::<DVec3>() / 8.0;
    let eye = camera.eye - scene.volume.grid.centre() - middle;
    let radius = corners
        .iter()
        .map(|x| x.distance(middle))
        .fold(0.0, f64::max);
    let outside = eye.length() > radius;
    match camera.projection {
        Projection::Perspective { .. } if outside => eye.normalize_or(-frame.forward),
        _ => -frame.forward,
    }
}

/// Corners of a box around all that is kept of the volume.
pub(super) fn corners(scene: &Scene) -> [DVec3; 8] {
    let grid = &scene.volume.grid;
    let (low, high) = kept(scene);
    [0u32, 1, 2, 3, 4, 5, 6, 7].map(|i| {
        let upper = (UVec3::new(i, i >> 1, i >> 2) & 1).as_dvec3();
        grid.world_from_index
            .transform_point3(low + upper * (high - low))
            - grid.centre()
    })
}

/// The camera as a map to pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Lens {
    eye: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    perspective: bool,
    size: UVec2,
}

impl Lens {
    /// Of a scene's camera and image.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        let (camera, frame) = (&scene.camera, scene.camera.frame());
        let size = UVec2::new(scene.image.width, scene.image.height);
        let (half, perspective) = match camera.projection {
            Projection::Perspective { vfov_deg } => ((0.5 * vfov_deg).to_radians().tan(), true),
            Projection::Orthographic { height } => (0.5 * height, false),
        };
        let aspect = f64::from(size.x) / f64::from(size.y);
        Self {
            eye: camera.eye - scene.volume.grid.centre(),
            right: frame.right / (half * aspect),
            up: frame.up / half,
            forward: frame.forward,
            perspective,
            size,
        }
    }

    /// Pixels that may see what has these corners; all where it reaches behind the eye.
    fn pixels(&self, outline: &[DVec3]) -> Rect {
        let place = |x: &DVec3| {
            let from_eye = *x - self.eye;
            let depth = from_eye.dot(self.forward);
            let scale = if self.perspective { depth } else { 1.0 };
            // Nothing closer is seen as a corner reliably.
            let in_front = !self.perspective || depth > 1e-6 * from_eye.length();
            let ndc = DVec2::new(from_eye.dot(self.right), -from_eye.dot(self.up)) / scale;
            in_front.then(|| (0.5 + 0.5 * ndc) * self.size.as_dvec2())
        };
        let places: Option<Vec<_>> = outline.iter().map(place).collect();
        places.map_or(Rect::whole(self.size), |list| {
            Rect::around(list.into_iter(), self.size)
        })
    }
}

/// Whether the light is a point, for shaders.
pub(super) const fn is_point(light: &LightFrustum) -> bool {
    matches!(light.place, Place::At(_))
}
