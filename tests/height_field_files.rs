//! Height fields from files: pictures and volume files, what scene files say of them, and what is refused.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::fs::File;
use std::path::Path;

use glam::{DVec2, DVec3, UVec3};
use image::{GrayImage, ImageBuffer, Luma, Rgb, RgbImage};
use tempfile::{TempDir, tempdir};
use tiff::encoder::{TiffEncoder, colortype};
use tiff::tags::Tag;
use tyndall::scene::Scene;
use tyndall::scene::file::{Override, SceneError, SceneFile};
use tyndall::volume::{HeightMap, ReadOptions, Volume};

/// A folder with maps of 6 x 4: heights of 8 and 16 bits and in a volume file, and colours.
fn folder() -> TempDir {
    let folder = tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    // Bright at the upper left.
    GrayImage::from_fn(6, 4, |x, y| Luma([if (x, y) == (0, 0) { 255 } else { 51 }]))
        .save(at("grey8.png"))
        .unwrap();
    ImageBuffer::<Luma<u16>, _>::from_fn(6, 4, |x, _| Luma([(x * 13_107) as u16]))
        .save(at("grey16.png"))
        .unwrap();
    RgbImage::from_fn(6, 4, |_, y| Rgb([if y == 0 { 255 } else { 0 }, 188, 0]))
        .save(at("colors.png"))
        .unwrap();
    RgbImage::new(5, 4).save(at("narrow.png")).unwrap();
    let header = "NRRD0004\ntype: float\ndimension: 3\nsizes: 6 4 1\nspacings: 30 30 1\nendian: little\n\
                  encoding: raw\n\n";
    let write = |name: &str, value: fn(usize) -> f32| {
        let mut bytes = header.as_bytes().to_vec();
        bytes.extend((0..24).flat_map(|i| value(i).to_le_bytes()));
        std::fs::write(at(name), bytes).unwrap();
    };
    write("metres.nrrd", |i| 100.0 + i as f32);
    write("hole.nrrd", |i| if i == 9 { f32::NAN } else { 1.0 });
    std::fs::write(at("broken.png"), b"\x89PNG\r\n\x1a\nnot really").unwrap();
    std::fs::write(at("broken.tif"), b"II*\0\xff\xff\xff\xffnot really").unwrap();
    survey(&at("survey.tif"), None);
    survey(&at("gaps.tif"), Some("-3"));
    degrees(&at("degrees.tif"), true);
    degrees(&at("nowhere.tif"), false);
    let mut plain = TiffEncoder::new(File::create(at("plain.tif")).unwrap()).unwrap();
    let levels: Vec<u16> = (0..24).map(|i| i * 2849).collect();
    plain
        .write_image::<colortype::Gray16>(6, 4, &levels)
        .unwrap();
    let turned = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 6 4 1\nspace dimension: 3\nendian: little\n\
                  space directions: (-1,0,0) (0,2,0) (0,0,1)\nencoding: raw\n\n";
    let mut bytes = turned.as_bytes().to_vec();
    bytes.extend(0..24);
    std::fs::write(at("turned.nrrd"), &bytes).unwrap();
    let text = turned.replace("(-1,0,0) (0,2,0)", "(1,1,0) (-1,1,0)");
    let mut bytes = text.into_bytes();
    bytes.extend(0..24);
    std::fs::write(at("aslant.nrrd"), &bytes).unwrap();
    let mut colors = TiffEncoder::new(File::create(at("colors.tif")).unwrap()).unwrap();
    colors
        .write_image::<colortype::RGB8>(2, 2, &[0; 12])
        .unwrap();
    folder
}

/// 6 x 4 heights from -3 up, a row further from the upper edge 100 more, in columns 30 x 20 apart.
fn survey(path: &Path, missing: Option<&str>) {
    let heights: Vec<i16> = (0..24).map(|i| i % 6 + 100 * (i / 6) - 3).collect();
    let mut encoder = TiffEncoder::new(File::create(path).unwrap()).unwrap();
    let mut image = encoder.new_image::<colortype::GrayI16>(6, 4).unwrap();
    let tags = image.encoder();
    tags.write_tag(Tag::ModelPixelScaleTag, &[30.0, 20.0, 0.0][..])
        .unwrap();
    if let Some(missing) = missing {
        tags.write_tag(Tag::GdalNodata, missing).unwrap();
    }
    image.write_data(&heights).unwrap();
}

/// A float map a hundredth of a degree from column to column, its upper edge at 60 degrees north, one value missing.
fn degrees(path: &Path, tied: bool) {
    let heights: Vec<f32> = (0..24)
        .map(|i| if i == 8 { -9999.9 } else { 100.0 })
        .collect();
    let mut encoder = TiffEncoder::new(File::create(path).unwrap()).unwrap();
    let mut image = encoder.new_image::<colortype::Gray32Float>(6, 4).unwrap();
    let tags = image.encoder();
    tags.write_tag(Tag::ModelPixelScaleTag, &[0.01, 0.01, 0.0][..])
        .unwrap();
    tags.write_tag(Tag::GeoKeyDirectoryTag, &[1u16, 1, 0, 1, 1024, 0, 1, 2][..])
        .unwrap();
    tags.write_tag(Tag::GdalNodata, "-9999.9").unwrap();
    if tied {
        let tie = [0.0, 0.0, 0.0, 10.0, 60.0, 0.0];
        tags.write_tag(Tag::ModelTiepointTag, &tie[..]).unwrap();
    }
    image.write_data(&heights).unwrap();
}

fn resolve(folder: &Path, text: &str) -> Result<Scene, SceneError> {
    SceneFile::parse(text, "s.toml", folder.to_owned(), &[])?.resolve(&mut |_, _, _| {})
}

/// The surface's height in the world over a column.
fn height(v: &Volume, x: u32, y: u32) -> f64 {
    let field = v.height_field.as_ref().unwrap();
    let k = f64::from(field.heights[(x + v.grid.dims.x * y) as usize]);
    let at = DVec3::new(x.into(), y.into(), k);
    v.grid.world_from_index.transform_point3(at).z
}

fn near(a: f64, b: f64) {
    assert!((a - b).abs() < 1e-5 * (1.0 + b.abs()), "{a} {b}");
}

#[test]
fn pictures_are_maps_with_their_upper_edge_towards_y() {
    let folder = folder();
    let text = "volume.height_field = { file = 'grey8.png', size = [3, 2], height = 5, level = 0 }";
    let scene = resolve(folder.path(), text).unwrap();
    let v = &scene.volume;
    assert_eq!(v.stored_dims(), UVec3::new(6, 4, 1));
    near(height(v, 0, 3), 5.0);
    near(height(v, 0, 0), 1.0);
    // Data values are the map's own.
    near(v.value(18), 1.0);
    near(v.value(0), 0.2);
    let (low, high) = v.grid.world_bounds();
    near(low.x, -1.5);
    near(high.y, 1.0);
    // 1/64 of 3 below the lowest, and the highest.
    near(low.z, 1.0 - 3.0 / 64.0);
    assert!(high.z >= 5.0 && high.z < 5.1);
    let text = "volume.height_field = { file = 'grey16.png', level = 0 }";
    let scene = resolve(folder.path(), text).unwrap();
    // Two units along the longer side, a fifth of the width for white.
    near(height(&scene.volume, 5, 0), 0.4);
    near(height(&scene.volume, 1, 2), 0.08);
    near(scene.volume.grid.world_bounds().1.x, 1.0);
    assert_eq!(
        scene
            .medium
            .transfer_function
            .name
            .split(',')
            .next()
            .unwrap(),
        "automatic: terrain"
    );
}

#[test]
fn a_volume_file_of_one_slice_keeps_its_units() {
    let folder = folder();
    let text = "volume.height_field = { file = 'metres.nrrd', level = 0, scalars.file = 'grey16.png', \
                colors.file = 'colors.png' }";
    let scene = resolve(folder.path(), text).unwrap();
    near(height(&scene.volume, 3, 1), 109.0);
    near(scene.volume.grid.world_bounds().1.x, 90.0);
    near(scene.volume.value(5), 1.0);
    near(scene.statistics.max, 1.0);
    let colors = scene.medium.albedo_volume.as_ref().unwrap();
    // Pictures are sRGB: 188 is a half of white.
    let top = colors.color(18);
    assert!((top - DVec3::new(1.0, 0.5, 0.0)).length() < 0.01, "{top}");
    near(colors.color(17).x, 0.0);
    near(scene.medium.albedo, 1.0);
}

#[test]
fn a_survey_keeps_its_units_and_its_gaps() {
    let folder = folder();
    let text = "volume.height_field = { file = 'survey.tif', level = 0 }";
    let v = resolve(folder.path(), text).unwrap().volume;
    near(height(&v, 2, 3), -1.0);
    near(height(&v, 5, 0), 302.0);
    near(v.grid.world_bounds().1.x, 90.0);
    near(v.grid.world_bounds().1.y, 40.0);
    let text = "volume.height_field = { file = 'gaps.tif', level = 0 }";
    let message = resolve(folder.path(), text).expect_err("a gap").to_string();
    assert!(
        message.contains("gaps.tif: found a height of NaN at column 0, 3"),
        "{message}"
    );
}

#[test]
fn degrees_become_metres() {
    let folder = folder();
    let map = HeightMap::read(&folder.path().join("degrees.tif"), &ReadOptions::default()).unwrap();
    // A degree is 111.2 km of a meridian, and half of that, nearly, along the parallel of 59.98 degrees.
    let expected = 1111.95 * DVec2::new(59.98_f64.to_radians().cos(), 1.0);
    assert!((map.spacing.unwrap() - expected).length() < 0.1);
    // Rows upwards: the third of the second row from the top.
    let missing: Vec<_> = (0..24).filter(|i| map.voxels.get(*i).is_nan()).collect();
    assert_eq!(missing, [14]);
}

#[test]
fn a_picture_in_a_tiff_counts_from_0_to_1() {
    let folder = folder();
    let text = "volume.height_field = { file = 'plain.tif', level = 0 }";
    let v = resolve(folder.path(), text).unwrap().volume;
    near(v.value(5), 23.0 * 2849.0 / 65535.0);
    near(height(&v, 5, 0), 0.4 * 23.0 * 2849.0 / 65535.0);
    near(v.grid.world_bounds().1.x, 1.0);
}

#[test]
fn a_slice_lies_as_its_directions_say() {
    let folder = folder();
    let text = "volume.height_field = { file = 'turned.nrrd', level = 0 }";
    let v = resolve(folder.path(), text).unwrap().volume;
    near(height(&v, 0, 0), 5.0);
    near(height(&v, 5, 3), 18.0);
    let (low, high) = v.grid.world_bounds();
    near(high.y - low.y, 8.0);
}

#[test]
fn a_source_takes_the_place_of_another() {
    let set = |text: &str, key: &str| {
        SceneFile::parse(text, "s.toml", "".into(), &[Override::parse(key).unwrap()]).unwrap()
    };
    let formula = "volume.height_field.procedural.name = 'terrain'";
    let file = set(formula, "volume.height_field.file=x.png");
    let field = file.spec.volume.height_field.unwrap();
    assert!(field.procedural.is_none() && field.file.unwrap().ends_with("x.png"));
    assert!(
        set(formula, "volume.file=x.nrrd")
            .spec
            .volume
            .height_field
            .is_none()
    );
    let file = set(
        "volume.file = 'x.nrrd'",
        "volume.height_field.procedural.name=terrain",
    );
    assert!(file.spec.volume.file.is_none());
}

#[test]
fn a_real_survey_is_read() {
    let Ok(data) = std::env::var("TYNDALL_DATA") else {
        eprintln!("skipped: TYNDALL_DATA is not set");
        return;
    };
    let path = Path::new(&data).join("terrain/bigtujunga_1197x643_i16.tif");
    let file = SceneFile::for_volume_file(&path, &ReadOptions::default(), &[]).unwrap();
    let scene = file.resolve(&mut |_, _, _| {}).unwrap();
    assert_eq!(
        (scene.statistics.min, scene.statistics.max),
        (315.0, 2295.0)
    );
    near(scene.volume.grid.world_bounds().1.x, 0.5 * 1197.0 * 30.0);
}

#[test]
fn the_level_follows_the_pixels() {
    let folder = folder();
    let scene = |more: &str| {
        let text = format!(
            "volume.height_field = {{ procedural = {{ name = 'terrain', resolution = 256 }} {more} }}\n\
             image = {{ width = 64, height = 64 }}"
        );
        resolve(folder.path(), &text).unwrap()
    };
    let columns = |s: &Scene| s.volume.grid.dims.x;
    assert_eq!(columns(&scene("")), 128);
    assert_eq!(columns(&scene(", level = 0")), 256);
    assert_eq!(columns(&scene(", level = 3")), 32);
    // As far as it goes.
    assert_eq!(columns(&scene(", level = 16")), 1);
    let close = "camera = { eye = [0, -0.9, 0.3], target = [0, 0, 0] }\n\
                 volume.height_field = { procedural = { name = 'terrain', resolution = 256 } }";
    assert_eq!(columns(&resolve(folder.path(), close).unwrap()), 256);
}

#[test]
fn what_is_wrong_is_named() {
    let folder = folder();
    let cases = [
        (
            "file = 'grey8.png', procedural = { name = 'terrain' }",
            "found beside `file`",
        ),
        ("size = [1, 1]", "expected one of file, procedural"),
        (
            "file = 'grey8.png', bottom = 0.5",
            "bottom: found 0.5, expected less than the 0 of `top`",
        ),
        ("file = 'grey8.png', ramp = 0", "ramp: found 0"),
        ("file = 'grey8.png', height = 0", "height: found 0"),
        ("file = 'grey8.png', size = [1, -1]", "size.1: found -1"),
        ("file = 'missing.png'", "missing.png: cannot open"),
        ("file = 'broken.png'", "broken.png: picture: found"),
        (
            "file = 'colors.png'",
            "expected grey values of 8 or 16 bits",
        ),
        (
            "file = 'hole.nrrd'",
            "hole.nrrd: found a height of NaN at column 3, 1",
        ),
        ("file = 'grey8.png', height = 1e300", "found a height of"),
        (
            "file = 'grey8.png', colors.file = 'narrow.png'",
            "found 5 x 4 pixels, expected the 6 x 4 of the map",
        ),
        (
            "file = 'grey8.png', scalars.file = 'hole.nrrd', colors.file = 'hole.nrrd'",
            "hole.nrrd: picture",
        ),
        ("file = 'broken.tif'", "broken.tif: TIFF: found"),
        (
            "file = 'colors.tif'",
            "expected grey values of 8, 16, 32 or 64 bits",
        ),
        (
            "file = 'nowhere.tif'",
            "nowhere.tif: TIFF: found None, expected a latitude",
        ),
        ("file = 'aslant.nrrd'", "aslant.nrrd: directions: found"),
        (
            "file = 'grey8.png', bottom = -1e300, top = 1e300",
            "expected lengths below 1e38",
        ),
        (
            "file = 'grey8.png', height = 1, size = [1e300, 1e300]",
            "expected lengths below 1e38",
        ),
        (
            "file = 'grey8.png', ramp = 1e-300",
            "raise `volume.height_field.ramp`",
        ),
        ("file = 'x.jpg'", "x.jpg"),
        ("procedural = { name = 'moon' }", "moon"),
        (
            "procedural = { name = 'terrain', resolution = 100000 }",
            "expected a number from 2 to 8192",
        ),
    ];
    for (keys, expected) in cases {
        let text = format!("volume.height_field = {{ {keys} }}");
        let message = resolve(folder.path(), &text).expect_err(keys).to_string();
        assert!(message.contains(expected), "{keys}\n{message}\n{expected}");
    }
}

#[test]
fn the_scenes_of_the_project_are_of_1024_columns() {
    for name in ["terrain", "cumulus_field"] {
        let path = format!("assets/scenes/{name}.toml");
        let mut file = SceneFile::load(Path::new(&path), &[]).unwrap();
        file.spec.volume.height_field.as_mut().unwrap().level = Some(0);
        let scene = file.resolve(&mut |_, _, _| {}).unwrap();
        assert_eq!(scene.volume.stored_dims(), UVec3::new(1024, 1024, 1));
    }
}
