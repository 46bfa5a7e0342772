//! Facts about real files. Set `TYNDALL_DATA` to the folder that holds them; skipped without it.

#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stderr)]

use std::path::PathBuf;

use glam::{DVec3, UVec3};
use tyndall::volume::{
    Format, Grid, RawLayout, ReadOptions, ScalarType, Space, Volume, read, read_header,
};

/// The path of a data file, or nothing (with a notice) if there is no data on this machine.
fn data(name: &str) -> Option<PathBuf> {
    let Some(folder) = std::env::var_os("TYNDALL_DATA") else {
        eprintln!("skipped: TYNDALL_DATA is not set ({name})");
        return None;
    };
    Some(PathBuf::from(folder).join(name))
}

fn load(path: PathBuf, options: &ReadOptions) -> Volume {
    read(&path, options, &mut |_, _| {}).unwrap_or_else(|e| panic!("{e}"))
}

fn load_plain(path: PathBuf) -> Volume {
    load(path, &ReadOptions::default())
}

fn range(volume: &Volume) -> (f64, f64) {
    (0..volume.voxels.len())
        .map(|i| volume.value(i))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| {
            (lo.min(v), hi.max(v))
        })
}

struct Fact {
    file: &'static str,
    scalar_type: ScalarType,
    dims: [u32; 3],
    spacing: [f64; 3],
    range: (f64, f64),
}

const fn fact(
    file: &'static str,
    scalar_type: ScalarType,
    dims: [u32; 3],
    spacing: [f64; 3],
    range: (f64, f64),
) -> Fact {
    Fact {
        file,
        scalar_type,
        dims,
        spacing,
        range,
    }
}

const FACTS: [Fact; 16] = [
    fact(
        "ct/cranium_256x256x108_i16.mha",
        ScalarType::I16,
        [256, 256, 108],
        [0.95703, 0.95703, 1.5],
        (-1024.0, 2986.0),
    ),
    fact(
        "ct/bonsai_256x256x256_u8.vti",
        ScalarType::U8,
        [256, 256, 256],
        [1.0, 1.0, 1.0],
        (0.0, 255.0),
    ),
    fact(
        "ct/aneurism_256x256x256_u8.vti",
        ScalarType::U8,
        [256, 256, 256],
        [1.0, 1.0, 1.0],
        (0.0, 255.0),
    ),
    fact(
        "simulation/isabel_windspeed_125x125x25_f64_t02.vti",
        ScalarType::F64,
        [125, 125, 25],
        [4.008_032_128_6, 4.008_032_128_6, 4.040_816_326_6],
        (0.0, 68.245_5),
    ),
    fact(
        "simulation/isabel_windspeed_125x125x25_f64_t45.vti",
        ScalarType::F64,
        [125, 125, 25],
        [4.008_032_128_6, 4.008_032_128_6, 4.040_816_326_6],
        (0.0, 62.601_9),
    ),
    fact(
        "simulation/hydrogen_64x64x64_f32.vti",
        ScalarType::F32,
        [64, 64, 64],
        [1.0, 1.0, 1.0],
        (0.0, 1.0),
    ),
    fact(
        "ct/head_cta_avm_337x319x154_u8.nii.gz",
        ScalarType::U8,
        [337, 319, 154],
        [0.5469, 0.5469, 1.0],
        (0.0, 563.2),
    ),
    fact(
        "ct/stent_128x128x256_f32.nrrd",
        ScalarType::F32,
        [128, 128, 256],
        [1.0, 1.0, 1.0],
        (0.0, 1.0),
    ),
    fact(
        "mri/head_t1_160x232x160_u8.nii.gz",
        ScalarType::U8,
        [160, 232, 160],
        [1.0, 0.89844, 0.89844],
        (0.0, 512.0),
    ),
    fact(
        "mri/colin27_t1_181x217x181_u8.nii.gz",
        ScalarType::U8,
        [181, 217, 181],
        [1.0, 1.0, 1.0],
        (0.0, 254.0),
    ),
    fact(
        "mri/stroke_t2_124x160x140_u8.nii.gz",
        ScalarType::U8,
        [124, 160, 140],
        [1.0, 1.0, 1.0],
        (0.0, 503.969),
    ),
    fact(
        "mri/stroke_flair_124x160x140_u8.nrrd",
        ScalarType::U8,
        [124, 160, 140],
        [1.0, 1.0, 1.0],
        (0.0, 255.0),
    ),
    fact(
        "labels/colin27_aal_181x217x181_u8.nii.gz",
        ScalarType::U8,
        [181, 217, 181],
        [1.0, 1.0, 1.0],
        (0.0, 116.0),
    ),
    fact(
        "simulation/fuel_64x33x32_u8.nii.gz",
        ScalarType::U8,
        [64, 33, 32],
        [1.0, 1.0, 1.0],
        (0.0, 255.0),
    ),
    fact(
        "ultrasound/spine_phantom_147x106x104_u8.mha",
        ScalarType::U8,
        [147, 106, 104],
        [0.5, 0.5, 0.5],
        (0.0, 251.0),
    ),
    fact(
        "cloud/wdas_cloud_sixteenth_dense_126x86x154_f32.nrrd",
        ScalarType::F32,
        [126, 86, 154],
        [3.33333, 3.33333, 3.33333],
        (0.0, 1.0),
    ),
];

#[test]
fn files_are_as_their_sources_say() {
    for fact in FACTS {
        let Some(path) = data(fact.file) else { return };
        let volume = load_plain(path);
        assert_eq!(
            volume.grid.dims,
            UVec3::from_array(fact.dims),
            "{}",
            fact.file
        );
        assert_eq!(
            volume.voxels.scalar_type(),
            fact.scalar_type,
            "{}",
            fact.file
        );
        let spacing = DVec3::from_array(fact.spacing);
        let off = volume.grid.spacing().distance(spacing);
        assert!(off < 2e-5, "{}: {}", fact.file, volume.grid.spacing());
        let (lo, hi) = range(&volume);
        let tolerance = 1e-3 * fact.range.1;
        let ok = (lo - fact.range.0).abs() < tolerance && (hi - fact.range.1).abs() < tolerance;
        assert!(ok, "{}: {lo} to {hi}", fact.file);
    }
}

#[test]
fn a_headerless_gzip_file_is_read_with_its_layout() {
    let Some(path) = data("ct/engine_256x256x128_u8.raw.gz") else {
        return;
    };
    let options = ReadOptions {
        raw: Some(RawLayout {
            dims: [256, 256, 128],
            scalar_type: ScalarType::U8,
            spacing: [1.0; 3],
            big_endian: false,
            skip_bytes: 0,
        }),
        time: 0,
    };
    assert_eq!(range(&load(path, &options)), (0.0, 255.0));
}

#[test]
fn the_offset_and_orientation_of_an_ultrasound_volume_become_ras() {
    let Some(path) = data("ultrasound/spine_phantom_147x106x104_u8.mha") else {
        return;
    };
    let header = read_header(&path, &ReadOptions::default()).unwrap();
    assert_eq!(header.grid.space, Space::PatientRas);
    let origin = header.grid.world_from_index.translation;
    assert_eq!(origin, DVec3::new(74.5217, -165.573, 29.072));
}

#[test]
fn time_series_give_each_step() {
    let Some(path) = data("timeseries/perfusion_mri_64x64x24x25_f32.nii.gz") else {
        return;
    };
    let header = read_header(&path, &ReadOptions::default()).unwrap();
    assert_eq!((header.time_steps, header.format), (25, Format::Nifti));
    let mut all = (f64::INFINITY, f64::NEG_INFINITY);
    for time in 0..25 {
        let (lo, hi) = range(&load(path.clone(), &ReadOptions { raw: None, time }));
        all = (all.0.min(lo), all.1.max(hi));
    }
    assert!(all.0 == 0.0 && (all.1 - 2839.0).abs() < 1.0, "{all:?}");
}

#[test]
fn viscous_fingers_are_a_numbered_series() {
    let Some(pattern) = data("timeseries/viscous_fingers_64x64x64_f32_t{}.vti") else {
        return;
    };
    let mut all = (f64::INFINITY, f64::NEG_INFINITY);
    for (time, number) in (0..).zip(["010", "030", "050", "070", "090"]) {
        let options = ReadOptions { raw: None, time };
        let header = read_header(&pattern, &options).unwrap();
        assert_eq!((header.time_steps, header.format), (5, Format::Vti));
        assert_eq!(header.grid.dims, UVec3::splat(64));
        let volume = load(pattern.clone(), &options);
        let name = format!("viscous_fingers_64x64x64_f32_t{number}.vti");
        assert_eq!(volume.name, name);
        let (lo, hi) = range(&volume);
        all = (all.0.min(lo), all.1.max(hi));
    }
    assert!(all.0 == 0.0 && (all.1 - 124.457).abs() < 1e-3, "{all:?}");
    // Two steps of a hurricane whose numbers are far apart.
    let Some(pattern) = data("simulation/isabel_windspeed_125x125x25_f64_t{}.vti") else {
        return;
    };
    let header = read_header(&pattern, &ReadOptions::default()).unwrap();
    assert_eq!(header.time_steps, 2);
}

/// World box around the voxel centres with a positive value.
fn positive_box(volume: &Volume) -> (DVec3, DVec3) {
    let mut bounds = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for_each_voxel(&volume.grid, |at, world| {
        if volume.value(at) > 0.0 {
            bounds = (bounds.0.min(world), bounds.1.max(world));
        }
    });
    bounds
}

fn for_each_voxel(grid: &Grid, mut f: impl FnMut(usize, DVec3)) {
    for z in 0..grid.dims.z {
        for y in 0..grid.dims.y {
            for x in 0..grid.dims.x {
                let i = UVec3::new(x, y, z);
                let world = grid.world_from_index.transform_point3(i.as_dvec3());
                f(grid.linear_index(i), world);
            }
        }
    }
}

/// The part of `mask`'s positive voxels at whose world position `image` is below `limit`.
fn dark_part(image: &Volume, mask: &Volume, limit: f64) -> f64 {
    let index_from_world = image.grid.world_from_index.inverse();
    let (mut dark, mut count) = (0u32, 0u32);
    for_each_voxel(&mask.grid, |at, world| {
        if mask.value(at) > 0.0 {
            let value = image.sample_index(index_from_world.transform_point3(world));
            dark += u32::from(value < limit);
            count += 1;
        }
    });
    f64::from(dark) / f64::from(count)
}

#[test]
fn an_lps_mask_lies_on_its_ras_scan() {
    let (Some(head), Some(mask)) = (
        data("mri/head_t1_160x232x160_u8.nii.gz"),
        data("labels/head_t1_brain_mask_160x232x160_u8.nrrd"),
    ) else {
        return;
    };
    let (head, mask) = (load_plain(head), load_plain(mask));
    assert_eq!(mask.grid.space, Space::PatientRas);
    let (head_lo, head_hi) = head.grid.world_bounds();
    let (mask_lo, mask_hi) = mask.grid.world_bounds();
    assert!(head_lo.distance(mask_lo) < 0.01 && head_hi.distance(mask_hi) < 0.01);
    let (lo, hi) = positive_box(&mask);
    assert!(lo.cmpge(head_lo).all() && hi.cmple(head_hi).all());
    assert!(
        (hi - lo).min_element() > 80.0,
        "a brain measures {}",
        hi - lo
    );

    // Next to none of the brain is as dark as bone or air, which a mask mirrored along an axis
    // covers: so the match is no accident of the common box. (Left and right are too alike; x is
    // turned together with y.)
    let on_brain = dark_part(&head, &mask, 60.0);
    for axis in 1..3 {
        let mut mirrored = mask.clone();
        let map = &mut mirrored.grid.world_from_index;
        let column = map.matrix3.col(axis);
        map.translation += column * f64::from(mask.grid.dims[axis] - 1);
        *map.matrix3.col_mut(axis) = -column;
        let on_mirrored = dark_part(&head, &mirrored, 60.0);
        assert!(on_brain < 0.5 * on_mirrored, "{on_brain} and {on_mirrored}");
    }
}

#[test]
fn two_oblique_scans_of_one_head_coincide() {
    let (Some(t2), Some(flair)) = (
        data("mri/stroke_t2_124x160x140_u8.nii.gz"),
        data("mri/stroke_flair_124x160x140_u8.nrrd"),
    ) else {
        return;
    };
    let (t2, flair) = (load_plain(t2), load_plain(flair));
    for (a, b) in t2.grid.corners().into_iter().zip(flair.grid.corners()) {
        assert!(a.distance(b) < 0.01, "{a} and {b}");
    }
    let n = t2.voxels.len();
    let same = (0..n)
        .filter(|i| (t2.value(*i) > 0.0) == (flair.value(*i) > 0.0))
        .count();
    assert!(same as f64 > 0.95 * n as f64, "{same} of {n}");
}

#[test]
fn the_large_bunny_has_its_grid() {
    let Some(path) = data("ct/bunny_512x512x361_i16be.nrrd") else {
        return;
    };
    let header = read_header(&path, &ReadOptions::default()).unwrap();
    assert_eq!(header.grid.dims, UVec3::new(512, 512, 361));
    assert_eq!(header.scalar_type, ScalarType::I16);
    let spacing = DVec3::new(0.337_891, 0.337_891, 0.5);
    assert_eq!(header.grid.spacing(), spacing);
}

#[test]

fn the_large_bunny_has_its_range() {
    let Some(path) = data("ct/bunny_512x512x361_i16be.nrrd") else {
        return;
    };
    assert_eq!(range(&load_plain(path)), (-2000.0, 4095.0));
}
