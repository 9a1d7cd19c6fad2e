//! What calibration needs beside a picture: [`truth`], what is really there at each pixel; and
//! [`camera_files`], by which other tools know the camera.
//!
//! In: a [`Scene`](crate::scene::Scene), a [`Camera`](crate::optics::Camera). Out: planes of positions, normals,
//! identities, motion. Files are left to [`io`](crate::io).

pub mod camera_files;
pub mod truth;
