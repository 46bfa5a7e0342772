//! One technique, one name; one word a stage: folders, shaders, labels and READMEs agree.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};

use tyndall::gpu::shader;
use tyndall::shaders::{sources, stale};
use tyndall::technique;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn folders(path: &Path) -> Vec<String> {
    let mut names: Vec<_> = fs::read_dir(path)
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.is_dir())
        .map(|p| p.file_name().unwrap().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

/// Every stage that has a name anywhere in the program.
fn stages() -> Vec<&'static str> {
    use technique::{
        ambient_occlusion::stage as o, ambient_scattering::stage as b,
        ambient_scattering::table::stage as t, half_angle::stage as h, medium::stage as m,
        path_trace::stage as p, ray_march::stage as r, single_scatter::stage as s,
        summed_area::stage as a,
    };
    vec![
        t::PREINTEGRATE,
        t::PREINTEGRATE_PLAIN,
        b::UPLOAD_TABLES,
        b::RADIANCE_CACHE,
        b::GATHER,
        b::MARCH,
        b::MARCH_R8,
        b::MARCH_R16,
        b::MARCH_R32F,
        b::UPLOAD_ALBEDO,
        b::READ_BACK,
        h::SWEEP,
        h::SHADE_SLICE,
        h::SHADE_SLICE_R8,
        h::SHADE_SLICE_R16,
        h::SHADE_SLICE_R32F,
        h::PROPAGATE,
        h::PROPAGATE_R8,
        h::PROPAGATE_R16,
        h::PROPAGATE_R32F,
        h::COMPOSE,
        h::UPLOAD_TABLES,
        h::UPLOAD_ALBEDO,
        h::READ_BACK,
        m::UPLOAD_VOLUME,
        m::UPLOAD_MASK,
        m::UPLOAD_TABLE,
        m::CELL_MIN_MAX,
        m::CELL_OCCUPANCY,
        m::CELL_DISTANCE,
        r::MARCH,
        r::MARCH_R8,
        r::MARCH_R16,
        r::MARCH_R32F,
        r::READ_BACK,
        p::TRACE,
        p::TRACE_R8,
        p::TRACE_R16,
        p::TRACE_R32F,
        p::UPLOAD_LEAVES,
        p::READ_BACK,
        s::LIGHT_CACHE,
        s::LIGHT_CACHE_R8,
        s::LIGHT_CACHE_R16,
        s::LIGHT_CACHE_R32F,
        s::MARCH,
        s::MARCH_R8,
        s::MARCH_R16,
        s::MARCH_R32F,
        s::UPLOAD_ALBEDO,
        s::READ_BACK,
        a::EXTINCTION,
        a::EXTINCTION_R8,
        a::EXTINCTION_R16,
        a::EXTINCTION_R32F,
        a::SCAN,
        a::SCAN_SUBGROUP,
        a::SCAN_SEGMENTS,
        a::AMBIENT_EXTINCTION,
        a::OCCLUSION,
        o::MARCH,
        o::MARCH_R8,
        o::MARCH_R16,
        o::MARCH_R32F,
        o::UPLOAD_ALBEDO,
        o::READ_BACK,
    ]
}

#[test]
fn a_technique_has_one_name_in_every_tree() {
    let mut expected: Vec<_> = technique::NAMES.iter().map(|n| (*n).to_owned()).collect();
    expected.extend(["medium".to_owned(), "summed_area".to_owned()]);
    expected.sort();
    assert_eq!(folders(&root().join("src/technique")), expected);
    assert_eq!(folders(&root().join("spirv")), expected);
    let glsl: Vec<_> = folders(&root().join("glsl"))
        .into_iter()
        .filter(|n| n != "shared")
        .collect();
    assert_eq!(glsl, expected);
    for name in &expected {
        assert!(
            root()
                .join(format!("src/technique/{name}/README.md"))
                .is_file(),
            "{name}"
        );
    }
    for name in technique::NAMES {
        assert!(
            root().join(format!("tests/goldens/{name}")).is_dir(),
            "goldens of {name}"
        );
    }
}

#[test]
fn every_shader_is_registered_under_its_path_and_named_like_its_stage() {
    let mut registered: Vec<_> = shader::ALL
        .iter()
        .map(|s| s.name.replace('.', "/"))
        .collect();
    registered.sort();
    assert_eq!(registered, sources(&root()).unwrap());
    for shader in shader::ALL {
        assert!(
            stages().contains(&shader.name),
            "{} is no stage",
            shader.name
        );
    }
}

#[test]
fn every_stage_has_a_heading_in_its_readme() {
    for stage in stages() {
        let folder = stage.split('.').next().unwrap();
        let readme =
            fs::read_to_string(root().join(format!("src/technique/{folder}/README.md"))).unwrap();
        assert!(
            readme.contains(&format!("### {stage}\n")),
            "{stage} has no heading in {folder}/README.md"
        );
    }
}

#[test]
fn every_module_is_fresh() {
    let stale = stale(&root()).unwrap();
    assert!(
        stale.is_empty(),
        "{}\nrun: cargo run --features shader-compiler -- compile-shaders",
        stale.join("\n")
    );
}

#[cfg(feature = "shader-compiler")]
#[test]
fn every_module_is_what_its_source_compiles_to() {
    let differing = tyndall::shaders::recompiled_differs(&root()).unwrap();
    assert!(differing.is_empty(), "{}", differing.join(", "));
}

#[test]
fn shaders_are_short_and_begin_with_their_header() {
    for name in sources(&root()).unwrap() {
        let source = fs::read_to_string(root().join(format!("glsl/{name}.comp"))).unwrap();
        let header: Vec<_> = source.lines().take_while(|l| l.starts_with("//")).collect();
        let text = header.join(" ");
        assert!(
            header.len() >= 3,
            "{name}: a header says what, over which domain, and who dispatches"
        );
        assert!(
            text.contains("Domain:") && text.contains("ispatched by"),
            "{name}"
        );
        assert!(
            source.lines().count() < 250,
            "{name}: {} lines",
            source.lines().count()
        );
    }
}

#[test]
fn unsafe_code_and_raw_vulkan_stay_in_gpu() {
    fn walk(folder: &Path, check: &mut dyn FnMut(&Path, &str)) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(&path, check);
            } else if path.extension().is_some_and(|e| e == "rs") {
                check(&path, &fs::read_to_string(&path).unwrap());
            }
        }
    }
    walk(&root().join("src"), &mut |path, text| {
        if !path.starts_with(root().join("src/gpu")) {
            assert!(!text.contains("unsafe {"), "{}", path.display());
            assert!(!text.contains("use ash"), "{}", path.display());
        }
        assert!(
            !text.contains("ALL_COMMANDS)") && !text.contains("::ALL_COMMANDS"),
            "{}",
            path.display()
        );
    });
}
