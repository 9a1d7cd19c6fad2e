//! The settings of one exposure.

use crate::Invalid;
use crate::units::{Celsius, Decibels, Seconds};

use super::{SensorModel, Shutter};

/// Beyond this, a single step of an 8-bit converter fills the range of numbers.
const MAX_DIGITAL_GAIN_DB: f64 = 48.0;

/// Settings of one exposure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposure {
    /// How long light and dark current are collected.
    pub time: Seconds,
    /// Analogue gain on top of the sensor's conversion gain.
    pub gain: Decibels,
    /// Gain of the numbers that leave the converter, 0 dB and more.
    pub digital_gain: Decibels,
    /// Temperature of the sensor.
    pub temperature: Celsius,
    /// Time from the start of one picture of a series to that of the next, where it is longer than it has to be.
    pub frame_interval: Option<Seconds>,
}

impl Exposure {
    /// Refuses what this sensor cannot do. Keys are those of the capture file's `[exposure]` table.
    pub fn validate(&self, sensor: &SensorModel) -> Result<(), Invalid> {
        if !(self.time.0.is_finite() && self.time.0 > 0.0) {
            return Err(Invalid::new("time_s", format!("must be above 0, got {}", self.time.0))
                .help("for example time_s = 0.01"));
        }
        let [low, high] = sensor.converter.gain_range;
        if !(low.0..=high.0).contains(&self.gain.0) {
            let message = format!("{} dB is not among the gains of sensor {}", self.gain.0, sensor.name);
            return Err(Invalid::new("gain_db", message).help(format!("write {} to {} dB", low.0, high.0)));
        }
        if !(0.0..=MAX_DIGITAL_GAIN_DB).contains(&self.digital_gain.0) {
            let message = format!("must lie from 0 to {MAX_DIGITAL_GAIN_DB}, got {}", self.digital_gain.0);
            return Err(Invalid::new("digital_gain_db", message).help("smaller numbers would never reach white"));
        }
        let dark = sensor.noise.dark_electrons(self.temperature, self.time);
        if !(self.temperature.0 > -crate::units::ZERO_CELSIUS && dark.0.is_finite()) {
            let message = format!("no sensor works at {} °C", self.temperature.0);
            return Err(Invalid::new("temperature_c", message).help("for example temperature_c = 25.0"));
        }
        if let Some(interval) = self.frame_interval
            && !(interval.0.is_finite() && interval.0 >= sensor.frame_interval(self.time, None).0)
        {
            let message = if interval.0 >= self.time.0 {
                let [rows, row_time_us] = [sensor.rows_read_out() as f64, sensor.shutter.row_time().0 * 1e6];
                format!("{} s is shorter than {rows} rows take, {row_time_us} µs each", interval.0)
            } else {
                format!("{} s is shorter than the exposure of {} s", interval.0, self.time.0)
            };
            return Err(Invalid::new("frame_interval_s", message).help("leave it out for one exposure after another"));
        }
        if let Shutter::Scanning { line_time } = sensor.shutter
            && self.time.0 > line_time.0
        {
            let message = format!(
                "{} s is longer than the {} s from one line to the next, which the same pixels see",
                self.time.0, line_time.0
            );
            return Err(Invalid::new("time_s", message).help("shorten it, or lengthen sensor.shutter.row_time_us"));
        }
        Ok(())
    }

    /// When the top row of a picture of a series is read out, counted from the start of the first.
    pub(super) fn read_out_time(&self, sensor: &SensorModel, frame: u64) -> Seconds {
        let interval = sensor.frame_interval(self.time, self.frame_interval);
        Seconds(interval.0 * frame as f64 + self.time.0)
    }
}
