//! Tyndall renders volumetric data with advanced illumination on Vulkan.
//!
//! Data flows one way: a [`scene::Scene`] (volume, medium, lights, camera) is turned by a technique
//! into a plan (pure data: stages, resources, bytes), the plan into Vulkan resources, the resources
//! into recorded stages, and those into a linear radiance image that [`output`] tone-maps and writes.
//!
//! | technique | paper | stages | folder |
//! |---|---|---|---|
//! | `ray_march` | Max 1995; Levoy 1988 | `march`, `read_back` | `technique/ray_march` |
//! | `single_scatter` | Max 1995 | `light_cache`, `march`, `read_back` | `technique/single_scatter` |
//! | `ambient_occlusion` | Schlegel 2011 | `march`, `read_back` | `technique/ambient_occlusion` |
//! | `ambient_scattering` | Ament 2013 | `preintegrate`, `upload_tables`, `radiance_cache`, `gather`, `march`, `read_back` | `technique/ambient_scattering` |
//! | `half_angle` | Kniss 2003 | `upload_tables`, `sweep` (`shade_slice`, `propagate`), `compose`, `read_back` | `technique/half_angle` |
//! | `path_trace` | Woodcock 1965; Novák 2014 | `upload_leaves`, `trace`, `read_back` | `technique/path_trace` |
//! | (shared) | Crow 1984; Schlegel 2011 | `extinction`, `scan` (on GPUs `scan_subgroup`, `scan_segments`), `ambient_extinction`, `occlusion` | `technique/summed_area` |
//! | (shared by all) | | `upload_volume`, `upload_table`, `cell_min_max`, `cell_occupancy`, `cell_distance` | `technique/medium` |
//!
//! `unsafe` code and raw Vulkan stay inside [`gpu`].

pub mod cli;
pub mod gpu;
pub mod output;
pub mod scene;
pub mod shaders;
pub mod stability;
pub mod study;
pub mod technique;
pub mod volume;
