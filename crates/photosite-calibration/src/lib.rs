//! What cameras are calibrated with and against: [`targets`], flat patterns whose points are known, which can be
//! printed and photographed; [`truth`], what is really there at each pixel; [`camera_files`], by which other tools know
//! a camera; [`dataset`], which varies a capture from frame to frame; and [`layouts`], in which other tools read what
//! came of that.
//!
//! In: the sizes of a target; a [`Scene`](photosite_transport::scene::Scene), a
//! [`Camera`](photosite_transport::optics::Camera). Out: drawings and meshes; planes of positions, normals, identities,
//! motion. Files are left to `photosite`.

#![forbid(unsafe_code)]

pub mod camera_files;
pub mod dataset;
pub mod layouts;
pub mod targets;
pub mod truth;
