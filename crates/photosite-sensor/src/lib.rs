//! The image sensor: what becomes of the photo-electrons of an exposure until they are digital numbers.
//!
//! In: the mean photo-electrons of every pixel (e⁻, noise-free, one plane per channel), a [`SensorModel`], an
//! [`Exposure`]. Out: a [`RawImage`](photosite_raw::RawImage) of digital numbers. [`expose()`] is the list of stages, each
//! of which has a file of its own in `stages/`; names and symbols are those of
//! [Emva1288](photosite_core::references#emva1288).
//!
//! Exposure control is beside that list: [`auto_exposure()`] finds time and gains, [`SensorModel::gains_for_iso`] the
//! gains of a speed, [`SensorModel::linearisation`] the way back from nonlinear numbers.
//!
//! Light is left to the renderer, which needs [`SensorModel::responses`] from here; files are left to
//! [`raw`](photosite_raw), colour to `photosite-develop`.

#![forbid(unsafe_code)]

mod band_light;
mod chain;
mod exposure;
mod image_electrons;
mod model;
mod prediction;
pub mod presets;
mod signal;
mod stages;

pub use chain::packed;

pub use band_light::{BandRates, electron_rates};
pub use chain::{ExposedFrame, NoiseMaps, expose, expose_after, expose_with_maps};
pub use exposure::{
    AutoExposed, AutoExposure, Binning, BinningMethod, Exposure, GainControl, Linearisation, Metering,
    RegionOfInterest, TimeLimit, auto_exposure,
};
pub use image_electrons::{ImageElectrons, ImageUnit, image_electrons, without_negative};
pub use model::{
    AdcDescription, Architecture, BlackLevelByGain, Ccd, CcdArchitecture, CcdDescription, CellShapeName,
    ChannelDescription, ChargeDescription, Companding, CompandingCurve, CompandingDescription, Converter, Converters,
    Counting, CountingMode, CurveFile, DarkCurrentLaw, DarkCurrentLawName, DefectFile, DefectivePixels, Defects,
    DefectsDescription, DualGain, DualGainDescription, FORMATS, FilterDescription, FixedPattern, Flicker,
    FlickerDescription, FlickerOrder, Format, FrameGrabber, FrameGrabberDescription, GainStepDescription, ImageLag,
    ImageLagDescription, Kernel, Logarithmic, LowPass, MaskedPixels, MeasuredPattern, Noise, NoiseDescription,
    Obstacle, Overscan, PatternFile, PixelDefect, ReadOutNoise, ReadOutNoiseByGain, Reset, ResetDescription, RowOrder,
    SensorDescription, SensorFiles, SensorKind, SensorModel, Shutter, ShutterDescription, ShutterKind,
    SignalInterpolation, Spad, SpadDescription, SpectrumSource, TelegraphDescription, TelegraphSignal, UncommonFacts,
    Use, Video, VideoCurve, VideoDescription, keys,
};
pub use prediction::{GainLine, LightNoise, Neighbours, NoiseAtGain, samples_needed, sensor_noise, smoothed_mean};
pub use signal::effects::{MapUnit, NoiseMap, Stage, Stages};
pub use signal::noise_key::NoiseKey;
pub use stages::image_lag::LeftCharge;
