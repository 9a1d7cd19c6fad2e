//! Raw pictures: the mosaic of digital numbers that leaves the sensor, with what a developer needs to know about it.
//!
//! In: digital numbers from [`sensor`](crate::sensor). Out: files (DNG, TIFF, PGM, NPY). Development to RGB is left to
//! [`develop`](crate::develop).

mod cfa;
mod dng;
mod npy;
mod pgm;
mod rational;
mod read;
mod thumbnail;
mod tiff;

pub use cfa::Cfa;
pub use dng::write_dng;
pub use npy::{read_npy, write_npy};
pub use pgm::{read_pgm, write_pgm};
pub use read::{read_dng, read_tiff};
pub use tiff::write_tiff;

/// A mosaic of digital numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct RawImage {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// width × height digital numbers, row by row from the top-left pixel.
    pub data: Vec<u16>,
    /// Which channel each pixel belongs to.
    pub cfa: Cfa,
    /// Bits of the converter, 8–16.
    pub bits: u32,
    /// Digital number of no light, DN.
    pub black_level_dn: u16,
    /// Smallest digital number at which a pixel counts as saturated, DN.
    pub white_level_dn: u16,
    /// How it was taken.
    pub metadata: RawMetadata,
}

impl RawImage {
    /// Digital numbers of which a file says nothing but that they go up to `maximum`: those of a monochrome sensor.
    fn bare(width: usize, height: usize, data: Vec<u16>, maximum: u16) -> Self {
        let (cfa, metadata) = (Cfa::mono(), RawMetadata::default());
        let bits = (u16::BITS - maximum.leading_zeros()).max(8);
        Self { width, height, data, cfa, bits, black_level_dn: 0, white_level_dn: maximum, metadata }
    }
}

/// How a raw picture was taken, and what its colours mean.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RawMetadata {
    /// Sensor preset or name.
    pub camera_model: String,
    /// Exposure time, s.
    pub exposure_time_s: f64,
    /// f-number, where there is a lens.
    pub f_number: Option<f64>,
    /// Focal length, m.
    pub focal_length_m: Option<f64>,
    /// XYZ → camera for colours under D65, rows per channel in the order of the CFA's channels; `None` for monochrome.
    pub colour_matrix_d65: Option<[[f64; 3]; 3]>,
    /// The same for colours under CIE illuminant A, where it is known.
    pub colour_matrix_a: Option<[[f64; 3]; 3]>,
    /// The camera's response to the scene's white, the largest component 1; `None` for monochrome.
    pub as_shot_neutral: Option<[f64; 3]>,
    /// Per channel (S, O): variance of the normalised signal x in 0–1 is S·x + O (DNG NoiseProfile).
    pub noise_profile: Vec<[f64; 2]>,
}
