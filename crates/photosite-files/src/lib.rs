//! The files: capture files, scenes, images. With [`raw`](photosite_raw) the only modules that read or write any.

#![forbid(unsafe_code)]

pub mod checksum;
pub mod developable;
pub mod developed;
pub mod electrons;
pub mod exr;
pub mod file_sum;
pub mod film_file;
pub mod formats;
#[cfg(all(test, target_os = "linux"))]
mod full_disk_tests;
mod icc;
pub mod image_file;
pub mod image_notes;
pub mod image_rows;
pub mod image_sets;
pub mod light_rows;
pub mod linear_image;
pub mod lock;
mod lost_colours;
pub mod map_file;
pub mod noise_maps;
pub mod noisy_image;
pub mod npy;
pub mod plain_image;
pub mod plain_png;
pub mod pretty_json;
pub mod raw_exr;
pub mod raw_file;
pub mod spectral_exr;
pub mod stated_colours;
pub mod target_file;
pub mod truth;
pub mod unfinished;
