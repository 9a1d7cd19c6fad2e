//! The image sensor: what becomes of the photo-electrons of an exposure until they are digital numbers.
//!
//! In: the mean photo-electrons of every pixel (e⁻, noise-free, one plane per channel), a [`SensorModel`], an
//! [`Exposure`]. Out: a [`RawImage`](crate::raw::RawImage) of digital numbers. [`expose()`] is the list of stages, each
//! of which has a file of its own; names and symbols are those of [Emva1288](photosite_core::references#emva1288).
//!
//! Exposure control is beside that list: [`auto_exposure()`] finds time and gains, [`SensorModel::gains_for_iso`] the gains of a
//! speed, [`SensorModel::linearisation`] the way back from numbers that are bent on purpose.
//!
//! Light is left to the renderer, which needs [`SensorModel::responses`] from here; files are left to
//! [`raw`](crate::raw), colour to [`develop`](crate::develop).

mod amplifiers;
mod auto_exposure;
mod band_light;
mod binning;
mod brighter_fatter;
mod ccd;
mod charge_generation;
mod charge_plane;
mod companding;
mod converter;
mod crosstalk;
mod dark_current;
mod dark_offset;
mod dead_pixels;
mod defective_numbers;
mod description;
mod digital_gain;
mod dual_gain;
mod expose;
mod exposure;
mod fixed_pattern;
mod flicker;
mod format;
mod full_well;
mod image_lag;
mod iso;
mod layers;
mod light_noise;
mod line_noise;
mod linearisation;
mod logarithmic;
mod masked_pixels;
mod model;
mod noise_key;
mod noise_map;
mod noise_maps;
mod noise_model;
mod photo_response;
mod photon_counting;
pub mod presets;
mod read_noise;
mod reset_noise;
mod shot_noise;
mod shutter;
mod stage;
mod telegraph;

pub use auto_exposure::{AutoExposed, AutoExposure, Metering, TimeLimit, auto_exposure};
pub use band_light::{BandRates, electron_rates};
pub use binning::{Binning, BinningMethod};
pub use ccd::{Ccd, Overscan};
pub use companding::{Companding, CompandingCurve};
pub use crosstalk::Kernel;
pub use description::{
    AdcDescription, CcdArchitecture, CcdDescription, ChannelDescription, ChargeDescription, CompandingDescription,
    Converters, CountingMode, CurveFile, DarkCurrentLawName, DefectsDescription, DualGainDescription,
    FilterDescription, FlickerDescription, FlickerOrder, NoiseDescription, ResetDescription, RowOrder,
    SensorDescription, SensorKind, ShutterDescription, ShutterKind, SpadDescription, SpectrumSource,
    TelegraphDescription,
};
pub use dual_gain::DualGain;
pub use expose::{Exposed, expose, expose_after, expose_with_maps};
pub use exposure::{Exposure, Window};
pub use image_lag::{ImageLag, ImageLagDescription, LeftCharge};
pub use light_noise::{Neighbours, noise_ratio, samples_needed, smoothed_mean};
pub use linearisation::Linearisation;
pub use logarithmic::Logarithmic;
pub use masked_pixels::MaskedPixels;
pub use model::{
    Architecture, Converter, DarkCurrentLaw, Defects, FixedPattern, Flicker, Noise, ResetNoise, SensorModel, Telegraph,
};
pub use noise_key::NoiseKey;
pub use noise_map::{MapUnit, NoiseMap};
pub use noise_maps::NoiseMaps;
pub use photon_counting::{Counting, Spad};
pub use shutter::Shutter;
pub use stage::{Stage, Stages};
