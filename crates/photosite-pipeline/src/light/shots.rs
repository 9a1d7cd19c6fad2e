//! Shots of light: the frames of its series, one after the other, or one of them.

use super::Light;
use crate::expose::frame_series::{Frame, FrameSeries};
use crate::expose::shot::Shot;
use photosite_core::image::Estimate;
use photosite_core::{Error, Invalid, Result};
use photosite_sensor::NoiseMap;
use std::sync::Arc;

/// Shots of light, one after the other: the frames that a render writes into its folder. They end with the times of a
/// bracket, and with the light of a series that was stored.
pub struct Shots<'a> {
    light: &'a Light,
    series: FrameSeries<'a>,
}

impl Light {
    /// Shots from the first frame on, with these noise maps.
    pub fn shots<'a>(&'a self, maps: &'a [NoiseMap]) -> Shots<'a> {
        Shots { light: self, series: FrameSeries::new(self.chain(), maps, Default::default()) }
    }

    /// The frame of that number, with these noise maps. Where it depends on those before it (image lag, gain control),
    /// they are read out, too, unless they have light that is not there, which a warning says.
    ///
    /// # Errors
    ///
    /// A number that the series does not have; an exposure that the sensor cannot make, or for which there is too
    /// little light; that it takes more memory than there is; light of a series that cannot be read.
    pub fn frame(&self, number: u32, maps: &[NoiseMap]) -> Result<Shot> {
        let mut shots = self.shots(&[]);
        let depends = number > 0 && shots.series.hands_on();
        let is_alone = self.only_frame().is_some();
        if depends && !is_alone {
            for _ in 0..number {
                shots.next().ok_or_else(|| self.no_frame(number))??;
            }
        }
        (shots.series.number, shots.series.maps) = (number, maps);
        let mut shot = shots.next().ok_or_else(|| self.no_frame(number))??;
        if depends && is_alone {
            let message = "earlier frames, whose light is not traced here, leave charge in this sensor or set its gain: \
                           image lag and exposure.gain_control are left out";
            shot.warnings.push(message.to_owned());
        }
        Ok(shot)
    }

    /// A shot as it was taken, with other noise maps.
    ///
    /// # Errors
    ///
    /// Errors of [`frame`](Self::frame).
    pub fn again(&self, shot: &Shot, maps: &[NoiseMap]) -> Result<Shot> {
        let series = FrameSeries::new(self.chain(), maps, (shot.frame, shot.before.clone()));
        Shots { light: self, series }.next().ok_or_else(|| self.no_frame(shot.frame))?
    }

    /// Error of a number that the series does not have.
    pub fn no_frame(&self, number: u32) -> Error {
        let (what, count) = match &self.settings().exposure.bracket {
            Some(bracket) => ("the bracket", bracket.len()),
            None => ("the series", self.own_lights().unwrap_or(0) as usize),
        };
        let invalid = Invalid::new("exposure", format!("{what} has {count} frames, and there is no frame {number}"));
        self.settings().source.error(invalid.help(format!("ask for one of 0 to {}", count.saturating_sub(1))))
    }
}

impl Shots<'_> {
    /// The next shot, if there is one.
    fn take(&mut self) -> Result<Option<Shot>> {
        let Self { light, series } = self;
        let lights = light.own_lights();
        if lights.is_some_and(|lights| series.number >= lights) {
            return Ok(None);
        }
        if lights.is_some() || series.light.is_none() {
            // The light before it is not needed any more.
            series.light = None;
            series.see(light.expose_for(series.number)?)?;
        }
        let before = series.carried.clone();
        let Some(Frame { number, raw, maps, exposure, device }) = series.next().transpose()? else { return Ok(None) };
        let Some(seen) = &series.light else { return Ok(None) };
        let electrons = if exposure.time == seen.exposure.time {
            Arc::clone(&seen.electrons)
        } else {
            Arc::new(Estimate::clone(&seen.electrons).scaled(exposure.time.0 / seen.exposure.time.0))
        };
        let (frame, noise_maps, mut warnings) = (number, maps, seen.warnings.clone());
        let device = device.and_then(|device| device.map_err(|warning| warnings.push(warning)).ok());
        Ok(Some(Shot { frame, raw, exposure, electrons, noise_maps, device, warnings, before }))
    }
}

impl Iterator for Shots<'_> {
    type Item = Result<Shot>;

    fn next(&mut self) -> Option<Self::Item> {
        self.take().transpose()
    }
}
