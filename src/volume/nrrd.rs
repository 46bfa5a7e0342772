//! nrrd
