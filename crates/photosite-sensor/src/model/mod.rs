//! A sensor as its file states it, and the same checked and in SI units: a file for each group of keys.
//!
//! In: a [`SensorDescription`] and a way to find the spectra that it names. Out: a [`SensorModel`] whose numbers can be
//! relied on. Reading files is left to the caller.

mod architecture;
mod black_level;
mod ccd;
mod cells;
mod charge;
mod checks;
mod companding;
mod converter;
mod crosstalk;
mod defective_pixels;
mod defects;
mod description;
mod effects;
mod fixed_pattern;
mod flicker;
mod format;
mod frame_grabber;
mod gain_steps;
mod image_lag;
mod kind;
mod layers;
mod logarithmic;
mod masked_pixels;
mod measured_pattern;
mod noise;
mod pattern_keys;
mod pixels;
mod reset_noise;
mod sensor_files;
mod sensor_model;
mod shutter;
mod spad;
mod spectrum_source;
mod telegraph;
#[cfg(test)]
mod tests;
mod uncommon;
mod video;

pub use architecture::Architecture;
pub use black_level::BlackLevelByGain;
pub use ccd::{Ccd, CcdArchitecture, CcdDescription, Overscan};
pub use cells::CellShapeName;
pub use charge::ChargeDescription;
pub use companding::{Companding, CompandingCurve, CompandingDescription};
pub use converter::{AdcDescription, Converter, Converters, DualGain, DualGainDescription};
pub use crosstalk::Kernel;
pub use defective_pixels::{DefectivePixels, PixelDefect};
pub use defects::{DefectFile, Defects, DefectsDescription};
pub use description::{ChannelDescription, FilterDescription, SensorDescription};
pub use fixed_pattern::FixedPattern;
pub use flicker::{Flicker, FlickerDescription, FlickerOrder};
pub use format::{FORMATS, Format};
pub use frame_grabber::{FrameGrabber, FrameGrabberDescription, SignalInterpolation};
pub use gain_steps::{GainStepDescription, ReadOutNoise, ReadOutNoiseByGain};
pub use image_lag::{ImageLag, ImageLagDescription};
pub use kind::SensorKind;
pub use logarithmic::Logarithmic;
pub use masked_pixels::MaskedPixels;
pub use measured_pattern::{MeasuredPattern, PatternFile};
pub use noise::{DarkCurrentLaw, DarkCurrentLawName, Noise, NoiseDescription};
pub use reset_noise::{Reset, ResetDescription};
pub use sensor_files::SensorFiles;
pub use sensor_model::SensorModel;
pub use shutter::{RowOrder, Shutter, ShutterDescription, ShutterKind};
pub use spad::{Counting, CountingMode, Spad, SpadDescription};
pub use spectrum_source::{CurveFile, SpectrumSource};
pub use telegraph::{TelegraphDescription, TelegraphSignal};
pub use uncommon::{Obstacle, UncommonFacts, Use};
pub use video::{LowPass, Video, VideoCurve, VideoDescription};

/// Builders of the tables of a sensor file.
pub mod keys {
    pub use super::ccd::CcdKeys;
    pub use super::charge::ChargeKeys;
    pub use super::companding::CompandingKeys;
    pub use super::converter::{AdcKeys, DualGainKeys};
    pub use super::defects::DefectsKeys;
    pub use super::description::{ChannelKeys, FilterKeys, SensorKeys};
    pub use super::flicker::FlickerKeys;
    pub use super::frame_grabber::FrameGrabberKeys;
    pub use super::gain_steps::GainStepKeys;
    pub use super::image_lag::ImageLagKeys;
    pub use super::noise::NoiseKeys;
    pub use super::reset_noise::ResetKeys;
    pub use super::shutter::ShutterKeys;
    pub use super::spad::SpadKeys;
    pub use super::spectrum_source::{CurveKeys, SpectrumValue};
    pub use super::telegraph::TelegraphKeys;
    pub use super::video::VideoKeys;
}
