//! Values that know the lines they stand in, and how they become Rust types.

pub(crate) mod nodes;
pub(crate) mod numbers;
pub(crate) mod overrides;
pub(crate) mod reader;
pub(crate) mod source;
pub(crate) mod text_file;
