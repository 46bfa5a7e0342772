//! The equations written naively on the CPU in f64.
