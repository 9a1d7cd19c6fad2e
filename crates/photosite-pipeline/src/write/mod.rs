//! The folder of a render: its files, checkpoints, and what decides their bytes.

pub(crate) mod checkpoint;
pub(crate) mod file_names;
pub(crate) mod output_folder;
pub(crate) mod provenance;
pub(crate) mod throttle;
