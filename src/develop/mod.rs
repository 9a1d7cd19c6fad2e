//! Development: from a raw mosaic to RGB, one file a step.
//!
//! In: a [`RawImage`](crate::raw::RawImage). Out: linear sRGB planes (white is 1), or an sRGB-encoded picture of 8 bits.
//! [`develop()`] lists the steps. There is no tone curve, no sharpening and no noise reduction: what the picture shows
//! is what the sensor recorded.
//!
//! [`colour_matrix`] computes what a raw file says about its colours from the sensor's spectral responses. Files are
//! left to [`raw`](crate::raw) and [`io`](crate::io).

mod black_level;
mod colour;
pub mod colour_matrix;
mod demosaic;
#[expect(clippy::module_inception, reason = "the step that all others are steps of")]
mod develop;
mod encode;
mod exposure;
mod white_balance;

pub use develop::{DevelopSettings, develop, develop_linear};
pub use encode::{Picture8, encode_srgb};
pub use white_balance::WhiteBalance;
