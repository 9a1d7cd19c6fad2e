//! Preparation of a capture before light is traced, and the memory that the work will take.

pub(crate) mod memory_needs;
pub(crate) mod prepared;
pub(crate) mod strips;
pub(crate) mod truth_views;
