//! Spectra: functions of wavelength from 300 to 1100 nm, the wavelengths a path carries, and the data that ship with
//! the program.
//!
//! A [`Spectrum`] is the one representation at rest: a table with a step of 1 nm. Along a path, a [`SampledSpectrum`]
//! holds its values at the four [`Wavelengths`] of that path. Colours become spectra in [`upsampling`], named data come
//! from [`library`], standard light from [`illuminant`], the observer from [`cie`].

pub mod cie;
pub mod csv;
pub mod dispersion;
mod flat;
pub mod illuminant;
mod importance;
pub mod library;
mod planck;
pub mod rgb;
mod sampled;
mod table;
pub mod upsampling;
mod wavelength_sampler;
mod wavelengths;

pub use csv::{CsvError, SpectralTable};
pub use dispersion::Dispersion;
pub use flat::{SpectrumId, SpectrumTable};
pub use importance::importance;
pub use sampled::SampledSpectrum;
pub use table::{Outside, Spectrum};
pub use wavelength_sampler::WavelengthSampler;
pub use wavelengths::Wavelengths;

/// Shortest wavelength of the program, nm: below it glass and air absorb, and silicon sensors see nothing.
pub const LAMBDA_MIN_NM: f32 = 300.0;
/// Longest wavelength of the program, nm: above it silicon is transparent.
pub const LAMBDA_MAX_NM: f32 = 1100.0;
/// Entries of a spectral table: every nanometre from [`LAMBDA_MIN_NM`] to [`LAMBDA_MAX_NM`].
pub const TABLE_LEN: usize = 801;
/// Number of wavelengths that a path carries.
pub const LANES: usize = 4;
