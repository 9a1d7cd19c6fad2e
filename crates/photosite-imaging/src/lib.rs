//! Imaging: from electrons to digital numbers, raw files and pictures, and what can be measured in them.
//!
//! [`raw`] holds digital numbers and reads and writes them as DNG, TIFF, PGM and NPY; [`sensor`] makes them of light;
//! [`develop`] makes pictures of them; [`measure`], [`validation`] and [`characterisation`] take figures from pictures
//! and raw images; [`synthetic_noise`] adds noise to any picture. Scenes and rays are left to others.

#![forbid(unsafe_code)]

pub mod characterisation;
pub mod develop;
pub mod measure;
pub mod raw;
pub mod sensor;
pub mod synthetic_noise;
pub mod validation;
