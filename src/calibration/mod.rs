//! What calibration needs beside a picture: [`truth`], what is really there at each pixel.
//!
//! In: a [`Scene`](crate::scene::Scene), a [`Camera`](crate::optics::Camera). Out: planes of positions, normals,
//! identities, motion. Files are left to [`io`](crate::io).

pub mod truth;
