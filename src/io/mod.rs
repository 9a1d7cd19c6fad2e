//! The files: capture files, scenes, pictures. With [`raw`](crate::raw) the only modules that read or write any.

pub mod capture;
pub mod cleanup;
mod complete;
pub mod developed;
pub mod electrons;
mod environment;
pub mod exr;
pub mod film_file;
pub mod finished_dataset;
pub mod gltf;
mod icc;
mod ies;
pub mod image_sets;
mod json;
pub mod light_rows;
pub mod linear_picture;
pub mod lock;
mod mesh;
pub mod mitsuba;
pub mod noise_maps;
mod npy;
pub mod obj;
pub mod output;
mod picture;
pub mod picture_file;
pub mod picture_rows;
pub mod plain_png;
pub mod raw_exr;
pub mod raw_file;
pub mod spectral_exr;
mod suggest;
mod tangents;
pub mod target_file;
pub mod truth;
pub mod unfinished;
mod warnings;

pub use complete::complete;

/// Tells the user of triangles that were left out.
fn zero_area_message(count: usize) -> String {
    match count {
        1 => "1 triangle of zero area is left out".to_owned(),
        _ => format!("{count} triangles of zero area are left out"),
    }
}
