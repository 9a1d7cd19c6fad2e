//! Colour: RGB spaces, chromatic adaptation, and differences between colours.
//!
//! Colours are three numbers in double precision. XYZ is relative, Y = 1 for white. RGB is linear or encoded as each
//! function says, white at 1. Hues are in degrees. Spectra become XYZ in [`spectrum::cie`](crate::spectrum::cie).
//! `tests/judges/colours.py` checks all of it against the colour-science package.

pub mod adaptation;
pub mod cielab;
pub mod difference;
pub mod hue;
mod space;
pub mod temperature;
mod transfer;

pub use space::ColourSpace;
pub use transfer::Transfer;
