//! Auto-exposure: the time at which the bright parts of a picture just stay below saturation.

use crate::Invalid;
use crate::image::Planes;
use crate::units::{Celsius, Decibels, Seconds};

use super::{Exposure, SensorModel, charge_generation};

/// What auto-exposure aims at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AutoExposure {
    /// Part of the pixels, 0–1, that may lie above the level.
    pub brighter_part: f64,
    /// Where the brightest of the others shall lie, as a part of the saturation capacity, 0–1.
    pub level: f64,
}

impl Default for AutoExposure {
    /// One pixel in 200 may be brighter than 85 % of saturation, so that lamps in the picture do not decide.
    fn default() -> Self {
        Self { brighter_part: 0.005, level: 0.85 }
    }
}

/// Exposure time for a picture of mean electrons (e⁻, a plane for each of the sensor's channels) that are collected within
/// the time `collected`: for electron rates, one second.
///
/// t = level · saturation capacity / (r + I(T)), where r is the quantile of the mosaic's rates and I(T) the dark current.
/// A picture in which that quantile is black has no such time and is refused.
pub fn auto_exposure(
    electrons: &Planes,
    collected: Seconds,
    sensor: &SensorModel,
    gain: Decibels,
    temperature: Celsius,
    target: AutoExposure,
) -> Result<Seconds, Invalid> {
    let mut mosaic = charge_generation::collect(electrons, &sensor.cfa)?.electrons;
    let bright = ((1.0 - target.brighter_part).clamp(0.0, 1.0) * mosaic.len() as f64) as usize;
    let bright = bright.min(mosaic.len().saturating_sub(1));
    let brightest =
        if mosaic.is_empty() { 0.0 } else { f64::from(*mosaic.select_nth_unstable_by(bright, f32::total_cmp).1) };
    let rate = brightest / collected.0;
    if !(rate.is_finite() && rate > 0.0) {
        let message = format!("no time suits a picture whose bright pixels receive {rate} electrons per second");
        return Err(Invalid::new("auto", message).help("write an exposure time, time_s = 0.01, or light the scene"));
    }
    let any_time = Exposure { time: Seconds(1.0), gain, temperature, frame_interval: None };
    let capacity = sensor.saturation_capacity(&any_time);
    Ok(Seconds(target.level * capacity.0 / (rate + sensor.noise.dark_current(temperature))))
}
