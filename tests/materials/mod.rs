//! What tests of the medium's material share: that every technique sees it as the equations do.
#![allow(dead_code, unreachable_pub, reason = "each test binary uses a part")]
#![allow(clippy::unwrap_used)]

use glam::{DVec2, DVec4, UVec3, Vec3};
use tyndall::gpu::Device;
use tyndall::output::Image;
use tyndall::scene::transfer_function::{Primitive, Quantity};
use tyndall::scene::{
    AmbientOcclusionParams, AmbientScatteringParams, HalfAngleParams, Light, LightCache, Radius,
    RayMarchParams, Scene, SingleScatterParams, TechniqueParams, TransferFunction,
};
use tyndall::technique::medium::Table;
use tyndall::technique::path_trace::leaves;
use tyndall::technique::summed_area::{FieldKind, probe, reference};
use tyndall::technique::{Renderer, half_angle, ray_march, single_scatter};

use crate::common::{params, render, with};

/// Voxels between samples.
const STEP: f64 = 0.25;

/// A transfer function of shapes over values and gradients.
pub fn shapes(list: &[Primitive]) -> TransferFunction {
    TransferFunction {
        name: "test".to_owned(),
        quantity: Quantity::Opacity,
        points: Vec::new(),
        primitives: list.to_vec(),
        opacity_unit_distance: 1.0,
    }
}

fn marched() -> RayMarchParams {
    RayMarchParams {
        step: STEP,
        ..params()
    }
}

fn scattered() -> SingleScatterParams {
    SingleScatterParams {
        step: STEP,
        shadow_step: STEP,
        cache: LightCache::None,
        early_termination: 1.0,
        empty_space_skipping: true,
    }
}

/// The scene by all that march, at one step, and by slices; without an early end.
pub fn every_technique(s: &Scene) -> Vec<Scene> {
    [
        TechniqueParams::RayMarch(marched()),
        TechniqueParams::SingleScatter(scattered()),
        TechniqueParams::AmbientOcclusion(AmbientOcclusionParams {
            step: STEP,
            radius: Radius::Voxels(3.0),
            early_termination: 1.0,
            empty_space_skipping: true,
        }),
        TechniqueParams::AmbientScattering(AmbientScatteringParams {
            step: STEP,
            radius: Radius::Voxels(3.0),
            early_termination: 1.0,
            ..AmbientScatteringParams::default()
        }),
        TechniqueParams::HalfAngle(HalfAngleParams {
            early_termination: 1.0,
            ..HalfAngleParams::default()
        }),
    ]
    .map(|technique| Scene {
        technique,
        ..s.clone()
    })
    .to_vec()
}

/// Every technique's opacity, and the radiance of those that have closed equations, are those of the CPU.
pub fn assert_all_see_the_equations(device: &Device, s: &Scene) {
    let (width, height) = (s.image.width, s.image.height);
    let at = |i: u32| {
        let centre = DVec2::new((i % width).into(), (i / width).into()) + 0.5;
        centre / DVec2::new(width.into(), height.into())
    };
    let pixels = 0..width * height;
    let mut s = s.clone();
    s.lights.push(Light::Environment {
        radiance: Vec3::splat(0.1),
    });
    let marched = marched();
    let expected: Vec<_> = pixels
        .clone()
        .map(|i| ray_march::reference::march(&s, &marched, at(i)))
        .collect();
    let densest = expected.iter().map(|p| p.w).fold(0.0, f64::max);
    assert!(densest > 0.3 && densest < 0.9999, "{densest}");
    for s in every_technique(&s) {
        let image = render(device, &s);
        let name = s.technique.name();
        let mut seen = &expected;
        let sliced: Vec<DVec4>;
        let lit: Option<Vec<_>> = match &s.technique {
            TechniqueParams::RayMarch(_) => Some(expected.clone()),
            TechniqueParams::SingleScatter(p) => Some(
                pixels
                    .clone()
                    .map(|i| single_scatter::reference::march(&s, p, at(i)))
                    .collect(),
            ),
            TechniqueParams::HalfAngle(p) => {
                // Its samples lie in its slices.
                let plan = half_angle::plan(&s, p, &device.info().limits).unwrap();
                sliced = half_angle::reference::image(&s, p, &plan);
                seen = &sliced;
                Some(sliced.clone())
            }
            _ => None,
        };
        let mut brightest = 0.0_f64;
        let mut farthest = 0.0_f64;
        for (i, pixel) in image.pixels.iter().enumerate() {
            let alpha = (f64::from(pixel[3]) - seen[i].w).abs();
            // The table is linear between its entries.
            assert!(
                alpha < 3e-4,
                "{name}, pixel {i}: opacity differs by {alpha}"
            );
            if let Some(lit) = &lit {
                brightest = brightest.max(lit[i].x);
                farthest = farthest.max((f64::from(pixel[0]) - lit[i].x).abs());
            }
        }
        // Single scattering integrates over a sample what its equations take at the middle.
        assert!(
            farthest <= 1e-2 * brightest,
            "{name}: {farthest} of {brightest}"
        );
    }
}

/// The sums of both kinds of boxes are those of the CPU.
pub fn assert_sums_are_the_naive_ones(device: &Device, s: &Scene) {
    for kind in [FieldKind::AmbientExtinction, FieldKind::Occlusion] {
        let (plan, texels, _) = probe(device, s, kind, 4.0).unwrap();
        let expected = reference::field(s, &plan);
        let largest = expected.iter().copied().fold(0.0, f64::max);
        for (found, expected) in texels.iter().zip(&expected) {
            // Half floats, and the table between its entries.
            assert!((f64::from(*found) - expected).abs() < 1e-3 * expected + 1e-3 * largest);
        }
    }
}

/// The image is the same with and without the cells that are skipped, of which there are some; gives that without.
pub fn assert_skipped_is_empty(device: &Device, s: &Scene) -> Image {
    let plan = Renderer::new(device, s.clone()).unwrap().plan().clone();
    assert!(plan.stages.iter().any(|s| s.name == "medium.cell_distance"));
    let [skipped, all] = [true, false].map(|skip| {
        let marched = with(s.clone(), |p| {
            (p.step, p.empty_space_skipping) = (0.5, skip);
        });
        render(device, &marched)
    });
    for (a, b) in skipped.pixels.iter().zip(&all.pixels) {
        // Blocks begin elsewhere, sums round differently.
        assert!(
            a.iter().zip(b).all(|(a, b)| (a - b).abs() < 2e-6),
            "{a:?} {b:?}"
        );
    }
    all
}

/// The extinction at every voxel lies within the bounds of its leaf; gives how many voxels have some and bounds of
/// use, and how many lie in empty leaves.
pub fn assert_leaves_bound(device: &Device, s: &Scene) -> [u32; 2] {
    let list = leaves::leaves(s, &Table::choose(s, &device.info().limits));
    let (dims, edge) = (s.volume.grid.dims, leaves::cell_edge(s.volume.grid.dims));
    let cells = leaves::cells_along(dims);
    let found = reference::cell_extinctions(s, UVec3::ONE, UVec3::ONE);
    let (mut within, mut empty) = (0, 0);
    for (i, sigma_t) in (0u32..).zip(found) {
        let voxel = UVec3::new(i % dims.x, i / dims.x % dims.y, i / (dims.x * dims.y));
        let cell = voxel / edge;
        let bounds = list[(cell.x + cells.x * (cell.y + cells.y * cell.z)) as usize];
        let [max, min] = bounds.map(|b| f64::from(f32::from_bits(b)));
        let is_bound = sigma_t <= max * (1.0 + 1e-4) && sigma_t >= min * (1.0 - 1e-4);
        assert!(is_bound, "{voxel}: {sigma_t} in {min} to {max}");
        within += u32::from(sigma_t > 0.0 && max < 10.0 * sigma_t);
        empty += u32::from(max < 1e-30);
    }
    [within, empty]
}
