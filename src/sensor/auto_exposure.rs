//! Automatic exposure: the time that a picture needs, and the gain where that time is too long.

use crate::Invalid;
use crate::image::Planes;
use crate::units::{Decibels, Electrons, Seconds};

use super::{Exposure, SensorModel, charge_generation};

/// What automatic exposure aims at, and how far it may go.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AutoExposure {
    /// What is measured.
    pub metering: Metering,
    /// Longest time; `None` for any.
    pub max_time: Option<Seconds>,
    /// Largest gain, analogue and digital together, that makes up for a time at its limit (automatic gain control);
    /// `None` leaves the gain as it is.
    pub max_gain: Option<Decibels>,
}

/// What automatic exposure measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Metering {
    /// The bright parts of a picture just stay below saturation.
    Highlights {
        /// Part of the pixels, 0–1, that may lie above the level.
        brighter_part: f64,
        /// Where the brightest of the others shall lie, as a part of the saturation capacity, 0–1.
        level: f64,
    },
    /// The mean of a picture, saturated pixels included, is this part of the saturation capacity, above 0 and below 1.
    Mean(f64),
}

impl Default for Metering {
    /// One pixel in 200 may be brighter than 85 % of saturation, so that lamps in the picture do not decide.
    fn default() -> Self {
        Self::Highlights { brighter_part: 0.005, level: 0.85 }
    }
}

/// The exposure of a picture of mean electrons (e⁻, a plane for each of the sensor's channels) that are collected within the
/// time `collected`: for electron rates, one second. All but its time and, with automatic gain control, its gains are
/// those of `wanted`.
///
/// Metering finds the time x that each electron of saturation capacity shall take, s/e⁻, such that with the rates r_i of
/// the mosaic and the dark current I(T)
///
/// (r + I)·x = level for the quantile r of the highlights, or mean(min((r_i + I)·x, 1)) = level
///
/// The time is then t = x·q_sat with the saturation capacity q_sat. Where that is longer than its limit, it ends there, and
/// gains rise until q_sat = t/x, the analogue one first. A picture that is too dark for any time is refused.
pub fn auto_exposure(
    electrons: &Planes,
    collected: Seconds,
    sensor: &SensorModel,
    wanted: &Exposure,
    target: AutoExposure,
) -> Result<Exposure, Invalid> {
    if sensor.logarithmic.is_some() {
        let message = format!("sensor {} is logarithmic and saturates at no time in particular", sensor.name);
        return Err(Invalid::new("auto", message).help("write the time over which its pixels average, time_s = 0.01"));
    }
    let dark = sensor.noise.dark_current(wanted.temperature);
    let mosaic = charge_generation::collect(electrons, &sensor.cfa)?.electrons;
    let per_capacity = match target.metering {
        Metering::Highlights { brighter_part, level } => level / (brightest(mosaic, brighter_part, collected)? + dark),
        Metering::Mean(level) => time_of_mean(&mosaic, collected, dark, level)?,
    };
    let time = per_capacity * sensor.saturation_capacity(wanted).0;
    // Pixels that scan see the next line after one line time.
    let line_time = sensor.shutter.scans().then(|| sensor.shutter.row_time());
    let limits = [target.max_time, line_time].into_iter().flatten();
    let Some(limit) = limits.filter(|limit| limit.0 < time).min_by(|a, b| a.0.total_cmp(&b.0)) else {
        return Ok(Exposure { time: Seconds(time), ..*wanted });
    };
    let limited = Exposure { time: limit, ..*wanted };
    let Some(max_gain) = target.max_gain else { return Ok(limited) };
    let [gain, digital_gain] = sensor.gains_for_capacity(Electrons(limit.0 / per_capacity), wanted.window.binning);
    let [_, most] = sensor.converter.gain_range;
    // Never below where it started: lower gains would not help a picture that is too dark.
    let gain = Decibels(gain.0.max(wanted.gain.0).min(max_gain.0.min(most.0)));
    let digital_gain = Decibels(digital_gain.0.max(wanted.digital_gain.0).min((max_gain.0 - gain.0).max(0.0)));
    Ok(Exposure { gain, digital_gain, ..limited })
}

/// The rate that so many pixels exceed, e⁻/s.
fn brightest(mut mosaic: Vec<f32>, brighter_part: f64, collected: Seconds) -> Result<f64, Invalid> {
    let bright = ((1.0 - brighter_part).clamp(0.0, 1.0) * mosaic.len() as f64) as usize;
    let bright = bright.min(mosaic.len().saturating_sub(1));
    let brightest =
        if mosaic.is_empty() { 0.0 } else { f64::from(*mosaic.select_nth_unstable_by(bright, f32::total_cmp).1) };
    let rate = brightest / collected.0;
    if rate.is_finite() && rate > 0.0 {
        return Ok(rate);
    }
    Err(no_time(format!("no time suits a picture whose bright pixels receive {rate} electrons per second")))
}

/// The x at which mean(min((r_i + I)·x, 1)) is the level.
fn time_of_mean(mosaic: &[f32], collected: Seconds, dark: f64, level: f64) -> Result<f64, Invalid> {
    // The mean is made of straight pieces that get flatter, so that Newton's method climbs from 0 to the root without
    // passing it, and ends after as many steps as there are pieces; a few do in practice.
    const STEPS: usize = 100;
    let all: f64 = mosaic.iter().map(|&electrons| f64::from(electrons)).sum();
    if all == 0.0 {
        return Err(no_time("no time suits a picture without any light".to_owned()));
    }
    let mut x = 0.0;
    for _ in 0..STEPS {
        let (mut saturated, mut slope) = (0usize, 0.0);
        for &electrons in mosaic {
            let rate = f64::from(electrons) / collected.0 + dark;
            if rate * x < 1.0 { slope += rate } else { saturated += 1 }
        }
        let missing = level * mosaic.len() as f64 - saturated as f64;
        let next = missing / slope;
        if !(next.is_finite() && next > 0.0) {
            let message = format!("no time brings the mean of this picture to {level} of saturation");
            return Err(no_time(message));
        }
        if next <= x {
            break;
        }
        x = next;
    }
    Ok(x)
}

fn no_time(message: String) -> Invalid {
    Invalid::new("auto", message).help("write an exposure time, time_s = 0.01, or light the scene")
}
