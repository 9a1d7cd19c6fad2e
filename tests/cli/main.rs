//! The command as a user runs it: the built binary, real files, what it prints and what it leaves behind.

mod bad_captures;
mod bad_geometry;
mod bad_sensors;
mod bad_usage;
mod bracket;
mod develop;
mod documents;
mod emva1288;
mod export_mitsuba;
mod expose;
mod folder;
mod frames;
mod geometry_alone;
mod gltf;
mod gltf_features;
mod info;
mod interruption;
mod lens;
mod limits;
mod motion;
mod noise;
mod outputs;
mod report;
mod room;
mod same_bytes;
mod seeds;
