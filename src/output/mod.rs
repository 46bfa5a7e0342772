//! From linear radiance to files.

/// temp
pub struct Image { /// w
 pub width: u32, /// h
 pub height: u32, /// p
 pub pixels: Vec<[f32;4]> }
