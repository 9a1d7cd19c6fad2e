//! Tracing of light: with checkpoints, in strips, in parts that are merged.

pub(crate) mod completed_rows;
pub(crate) mod parts;
pub(crate) mod trace_job;
pub(crate) mod traced_light;
