//! Development: from a raw image to RGB, one file a step.
//!
//! In: a [`RawImage`](photosite_raw::RawImage) and [`DevelopSettings`]. Out: linear planes of a colour space (white is 1),
//! or an image of 8 or 16 bits. [`develop_linear`] reads as the list of the steps. By default there is no noise
//! filter, no sharpening and no tone curve but the transfer function: what the image shows is what the sensor
//! recorded.
//!
//! | step | file |
//! |---|---|
//! | what the file does not say | `description.rs` |
//! | opcodes of DNG files, such as gains against lens falloff: of stored, linear and demosaicked values | `opcodes.rs` |
//! | linear numbers | `linearisation.rs` |
//! | black level | `black_level.rs` |
//! | defective pixels | `defects.rs` |
//! | white balance | `white_balance.rs` |
//! | demosaicking | `demosaic/`, one file a method |
//! | highlights | `highlights.rs`; clipping comes before demosaicking, so that edges are not coloured |
//! | noise | `noise_filter/`, one file a filter |
//! | filters given as numbers | `convolution.rs` |
//! | distortion, square pixels, resizing | `resampling.rs`, `resize.rs`; after demosaicking, since a mosaic cannot be moved |
//! | colour matrix, colour space, exposure | `colour.rs` |
//! | tone | `tone/`, one file a curve |
//! | grey and other colour models, thresholding | `colour_model.rs`, `threshold.rs` |
//! | encoding, sharpening, dithering | `encode.rs`, `sharpening.rs` |
//!
//! [`develop_image`] takes the steps from the noise filter on with an image that is light already. What the keys of
//! [`DevelopSettings`] are is said in `settings.rs` and `choices.rs`, what they refuse in `checks.rs`.
//!
//! [`mod@merge`] makes one signal of several exposures, and [`develop_merged`] an image of that.
//!
//! [`with_layout`] turns a mosaic into one that more developers know. [`camera_colour`] computes what a raw file says
//! about its colours from the sensor's spectral responses, and [`SensorCalibration`] keeps it. Files are left to
//! [`raw`](photosite_raw) and `photosite`.

#![forbid(unsafe_code)]

mod black_level;
pub mod camera_colour;
mod checks;
mod choices;
mod colour;
mod colour_matrix;
mod colour_model;
mod convolution;
mod defects;
mod demosaic;
mod description;
mod develop;
mod encode;
mod highlights;
mod ideal_observer;
mod layout;
mod linearisation;
mod memory;
pub mod merge;
mod neighbours;
mod noise_filter;
mod opcodes;
pub mod packed;
mod remap;
mod resampling;
mod resize;
mod sensor_calibration;
mod settings;
mod sharpening;
mod threshold;
mod tone;
mod white_balance;
mod window;

pub use choices::{
    ColourModel, Defects, Demosaic, Highlights, NoiseFilter, ResizeFilter, Thresholding, ToneCurve, WhiteBalance,
};
pub use colour_model::in_model;
pub use description::{RawDescription, RawKeys};
pub use develop::{Development, develop, develop_image, develop_linear, develop_merged};
pub use encode::{Codes, EncodedImage, Encoding, encode};
pub use ideal_observer::ideal;
pub use layout::{RawLayout, with_layout};
pub use memory::{bytes_of_resized, bytes_per_pixel};
pub use remap::remap;
pub use resampling::Resampling;
pub use sensor_calibration::SensorCalibration;
pub use settings::{DevelopKeys, DevelopSettings};
