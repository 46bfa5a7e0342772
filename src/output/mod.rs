//! From linear radiance to files.
