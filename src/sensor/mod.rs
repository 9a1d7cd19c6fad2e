//! The image sensor: what becomes of the photo-electrons of an exposure until they are digital numbers.
//!
//! In: the mean photo-electrons of every pixel (e⁻, noise-free, one plane per channel), a [`SensorModel`], an
//! [`Exposure`]. Out: a [`RawImage`](crate::raw::RawImage) of digital numbers. [`expose()`] is the list of stages, each
//! of which has a file of its own; names and symbols are those of [Emva1288](crate::references#emva1288).
//!
//! Light is left to the renderer, which needs [`SensorModel::responses`] from here; files are left to
//! [`raw`](crate::raw), colour to [`develop`](crate::develop).

mod auto_exposure;
mod charge_generation;
mod charge_plane;
mod converter;
mod dark_current;
mod dark_offset;
mod description;
mod expose;
mod exposure;
mod fixed_pattern;
mod full_well;
mod model;
mod noise_key;
mod noise_model;
mod photo_response;
pub mod presets;
mod read_noise;
mod shot_noise;
mod stage;

pub use auto_exposure::{AutoExposure, auto_exposure};
pub use description::{
    AdcDescription, ChannelDescription, ChargeDescription, CurveFile, FilterDescription, NoiseDescription,
    SensorDescription, SensorKind, SpectrumSource,
};
pub use expose::expose;
pub use exposure::Exposure;
pub use model::{Converter, FixedPattern, Noise, SensorModel};
pub use noise_key::NoiseKey;
pub use stage::{Stage, Stages};
