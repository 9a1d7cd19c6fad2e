//! Automatic exposure: the time that an image needs, the gain where that time is too long, and what is to be said
//! where both end.

use photosite_core::Invalid;
use photosite_core::image::Planes;
use photosite_core::units::{Decibels, Electrons, Seconds};

use crate::signal::charge_generation;
use crate::{Exposure, SensorModel};

/// Automatic exposure: its aim and its limits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AutoExposure {
    /// Metering: the brightness that is measured and the level that it shall have.
    pub metering: Metering,
    /// Exposure compensation, EV: 1 doubles the exposure time that metering finds.
    pub compensation_ev: f64,
    /// Longest time; `None` for any.
    pub max_time: Option<Seconds>,
    /// Largest gain, analogue and digital together, that makes up for a time at its limit (automatic gain control);
    /// `None` leaves the gain as it is.
    pub max_gain: Option<Decibels>,
}

/// Metering of automatic exposure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Metering {
    /// The bright parts of an image just stay below saturation.
    Highlights {
        /// Part of the pixels, 0–1, that may lie above the level.
        brighter_part: f64,
        /// Level of the brightest of the other pixels, as a part of the saturation capacity, 0–1.
        level: f64,
    },
    /// The mean of an image, saturated pixels included, is this part of the saturation capacity, above 0 and below 1.
    Mean(f64),
}

impl Default for Metering {
    /// One pixel in 200 may be brighter than 85 % of saturation, so that light sources in the image do not decide.
    fn default() -> Self {
        Self::Highlights { brighter_part: 0.005, level: 0.85 }
    }
}

/// Times that automatic exposure finds beyond these, s, are worth a warning: hardly a shutter is as short, and a scene
/// whose images take longer is most likely darker than meant.
const USUAL_TIMES_S: [f64; 2] = [1e-6, 10.0];

/// Result of automatic exposure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AutoExposed {
    /// The exposure.
    pub exposure: Exposure,
    /// Limit that ended the exposure time before the image reached the wanted brightness; `None` where none did.
    pub limit: Option<TimeLimit>,
    /// Part of the brightness aimed at, up to 1, that gains bring the image to at that end.
    pub brightness: f64,
}

/// Limit of the time of an automatic exposure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeLimit {
    /// [`AutoExposure::max_time`].
    Longest,
    /// The time from one line to the next of pixels that scan.
    Line,
}

impl AutoExposed {
    /// Warning about a limit that was reached or a time that is hardly meant, with advice. Keys are those of the
    /// capture file.
    pub fn warning(&self) -> Option<String> {
        let Exposure { time: Seconds(time_s), gain, digital_gain, .. } = self.exposure;
        let key = match self.limit {
            Some(TimeLimit::Longest) => "exposure.max_time_s",
            Some(TimeLimit::Line) => "sensor.shutter.row_time_us",
            None => {
                let [short_s, long_s] = USUAL_TIMES_S;
                return if time_s > long_s {
                    let help = "light the scene more, open the lens (lens.f_number), or write exposure.max_time_s, beyond which the \
                                gain rises";
                    Some(format!("automatic exposure takes {time_s:.3} s because there is little light: {help}"))
                } else if time_s < short_s {
                    let help = "check the levels of the lights, or close the lens (lens.f_number)";
                    Some(format!("automatic exposure takes {time_s:.3e} s, shorter than shutters are: {help}"))
                } else {
                    None
                };
            }
        };
        let gain_db = gain.0 + digital_gain.0;
        let reached = format!(
            "automatic exposure has reached its longest time, {time_s} s ({key}), at a gain of {gain_db:.2} dB"
        );
        // Rounding of gains aside, this is all.
        if self.brightness > 1.0 - 1e-6 {
            return Some(format!(
                "{reached}, which makes up for the rest with more noise: light the scene more, or raise {key}"
            ));
        }
        let remedy = match self.limit {
            Some(TimeLimit::Longest) => format!("write {key} = {}", up_to_digits(time_s / self.brightness)),
            Some(TimeLimit::Line) | None => format!("raise {key}"),
        };
        Some(format!(
            "{reached}, and the image is {:.1} EV darker than it should be: {remedy}, or raise exposure.max_gain_db or a \
             gain that is stated, light the scene more, or open the lens (lens.f_number)",
            -self.brightness.log2()
        ))
    }
}

/// A number that is no smaller, with two digits.
fn up_to_digits(number: f64) -> f64 {
    let step = 10f64.powf(number.log10().floor() - 1.0);
    let steps = (number / step).ceil();
    if step < 1.0 { steps / (1.0 / step).round() } else { steps * step.round() }
}

/// The exposure of an image of mean electrons (e⁻, a plane for each of the sensor's channels) that are collected
/// within the time `collected`: for electron rates, one second. All but its time and, with automatic gain control, its
/// gains are those of `wanted`.
///
/// Metering finds the time x that each electron of saturation capacity shall take, s/e⁻, such that with the rates r_i
/// of the mosaic and the dark current I(T)
///
/// (r + I)·x = level for the quantile r of the highlights, or mean(min((r_i + I)·x, 1)) = level
///
/// Compensation of c EV makes x longer by a factor of 2^c. The time is then t = x·q_sat with the saturation capacity
/// q_sat. Where that is longer than its limit, it ends there, and gains rise until q_sat = t/x, the analogue one first.
/// An image that is too dark for any time is refused.
pub fn auto_exposure(
    electrons: &Planes,
    collected: Seconds,
    sensor: &SensorModel,
    wanted: &Exposure,
    target: AutoExposure,
) -> Result<AutoExposed, Invalid> {
    if sensor.logarithmic.is_some() {
        let message = format!("sensor {} is logarithmic and saturates at no time in particular", sensor.name);
        return Err(Invalid::new("auto", message).help("write the time over which its pixels average, time_s = 0.01"));
    }
    let dark = sensor.noise.dark_current(wanted.temperature);
    let mosaic = seen(electrons, sensor)?;
    let per_capacity = match target.metering {
        Metering::Highlights { brighter_part, level } => level / (brightest(mosaic, brighter_part, collected)? + dark),
        Metering::Mean(level) => time_of_mean(&mosaic, collected, dark, level)?,
    };
    let per_capacity = per_capacity * target.compensation_ev.exp2();
    let time = per_capacity * sensor.pixel_saturation(wanted).0;
    // Pixels that scan see the next line after one line time.
    let line_time = sensor.shutter.scans().then(|| sensor.shutter.row_time());
    let limits = [(target.max_time, TimeLimit::Longest), (line_time, TimeLimit::Line)];
    let limits = limits.into_iter().filter_map(|(limit, what)| limit.map(|limit| (limit, what)));
    let Some((limit, what)) = limits.filter(|(limit, _)| limit.0 < time).min_by(|(a, _), (b, _)| a.0.total_cmp(&b.0))
    else {
        return Ok(AutoExposed { exposure: Exposure { time: Seconds(time), ..*wanted }, limit: None, brightness: 1.0 });
    };
    let limited = |exposure: Exposure| {
        let brightness = limit.0 / per_capacity / sensor.pixel_saturation(&exposure).0;
        AutoExposed { exposure, limit: Some(what), brightness: brightness.min(1.0) }
    };
    let at_limit = Exposure { time: limit, ..*wanted };
    let Some(max_gain) = target.max_gain else { return Ok(limited(at_limit)) };
    let [gain, digital_gain] = sensor.gains_for_capacity(Electrons(limit.0 / per_capacity), wanted.region.binning);
    let [_, most] = sensor.converter.gain_range;
    // Never below where it started: lower gains would not help an image that is too dark.
    let gain = Decibels(gain.0.max(wanted.gain.0).min(max_gain.0.min(most.0)));
    let digital_gain = Decibels(digital_gain.0.max(wanted.digital_gain.0).min((max_gain.0 - gain.0).max(0.0)));
    Ok(limited(Exposure { gain, digital_gain, ..at_limit }))
}

/// The electrons of all pixels that see light.
fn seen(electrons: &Planes, sensor: &SensorModel) -> Result<Vec<f32>, Invalid> {
    let mosaic = charge_generation::collect(electrons, &sensor.cfa)?;
    if sensor.cells.image_circle.is_none() {
        return Ok(mosaic.electrons);
    }
    let place = |i: usize| [i % mosaic.width / mosaic.samples, i / mosaic.width];
    let lit = mosaic.electrons.iter().enumerate().filter(|&(i, _)| sensor.sees_light(place(i)));
    Ok(lit.map(|(_, &electrons)| electrons).collect())
}

/// Electron rate that this part of the pixels exceeds, e⁻/s.
fn brightest(mut mosaic: Vec<f32>, brighter_part: f64, collected: Seconds) -> Result<f64, Invalid> {
    let bright = ((1.0 - brighter_part).clamp(0.0, 1.0) * mosaic.len() as f64) as usize;
    let bright = bright.min(mosaic.len().saturating_sub(1));
    let brightest =
        if mosaic.is_empty() { 0.0 } else { f64::from(*mosaic.select_nth_unstable_by(bright, f32::total_cmp).1) };
    let rate = brightest / collected.0;
    if rate.is_finite() && rate > 0.0 {
        return Ok(rate);
    }
    Err(no_time(format!("no exposure time suits an image whose bright pixels receive {rate} electrons per second")))
}

/// The x at which mean(min((r_i + I)·x, 1)) is the level.
fn time_of_mean(mosaic: &[f32], collected: Seconds, dark: f64, level: f64) -> Result<f64, Invalid> {
    // The mean is made of straight pieces that get flatter, so that Newton's method climbs from 0 to the root without
    // passing it, and ends after as many steps as there are pieces; a few do in practice.
    const STEPS: usize = 100;
    let all: f64 = mosaic.iter().map(|&electrons| f64::from(electrons)).sum();
    if all == 0.0 {
        return Err(no_time("no exposure time suits an image without any light".to_owned()));
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
            let message = format!("no time brings the mean of this image to {level} of saturation");
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
