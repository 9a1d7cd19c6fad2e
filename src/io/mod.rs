//! The files: capture files, scenes, pictures. With [`raw`](crate::raw) the only modules that read or write any.

pub mod checksum;
pub mod coded_png;
pub mod developable;
pub mod developed;
pub mod electrons;
pub mod exr;
pub mod file_sum;
pub mod film_file;
#[cfg(all(test, target_os = "linux"))]
mod full_disk_tests;
mod icc;
pub mod image_sets;
pub mod light_rows;
pub mod linear_picture;
pub mod lock;
pub mod map_file;
pub mod mitsuba;
pub mod noise_maps;
pub mod noise_series;
pub mod noisy_picture;
pub mod npy;
pub mod number_picture;
pub mod picture_file;
mod picture_format;
pub mod picture_notes;
pub mod picture_rows;
pub mod plain_png;
pub mod pretty_json;
pub mod raw_exr;
pub mod raw_file;
pub mod spectral_exr;
mod stated_colours;
pub mod target_file;
pub mod truth;
pub mod unfinished;

pub use photosite_core::{cleanup, output};
pub use photosite_scene_io::{ChangedMeshes, MeshChange, MissingNormals, complete, gltf, obj, ply, stl};
