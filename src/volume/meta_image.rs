//! meta_image
