//! Calibration of cameras and data sets: [`targets`], flat patterns whose points are known, which can be printed and
//! photographed; [`truth`], ground truth of each pixel; [`camera_files`], which describe a camera to other tools, and
//! [`calibration_files`], in which these describe one to photosite;
//! [`dataset`], which varies a capture from frame to frame; and [`layouts`], in which other tools read finished data
//! sets.
//!
//! In: the sizes of a target; a [`Scene`](photosite_transport::scene::Scene), a
//! [`Camera`](photosite_transport::optics::Camera). Out: drawings and meshes; planes of positions, normals, identities,
//! motion. Files are left to `photosite`.

#![forbid(unsafe_code)]

pub mod calibration_files;
pub mod camera_files;
pub mod dataset;
pub mod layouts;
pub mod targets;
pub mod truth;
