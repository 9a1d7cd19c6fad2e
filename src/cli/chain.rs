//! From traced light to raw files and a picture: exposure, sensor, development, and what is said of them.

use photosite::develop::colour_matrix::{CameraColour, camera_colour};
use photosite::develop::{DevelopSettings, Picture8, develop};
use photosite::film::Film;
use photosite::image::{Estimate, Planes};
use photosite::io::capture::{Capture, ExposureTime};
use photosite::raw::RawImage;
use photosite::scene::Scene;
use photosite::sensor::{Exposure, NoiseKey, Stages, auto_exposure, expose};
use photosite::units::Electrons;
use photosite::{Invalid, Result};

use super::report::{ExposureReport, SensorReport};

/// The steps after light transport, with what they need of the capture.
pub(super) struct Chain<'a> {
    capture: &'a Capture,
    colour: Option<CameraColour>,
}

/// An exposure and its frames.
pub(super) struct Exposed {
    pub(super) exposure: Exposure,
    /// Mean electrons with the variance that light transport leaves, e⁻ and e⁻².
    pub(super) electrons: Estimate,
    /// At least one; each with noise of its own.
    pub(super) frames: Vec<RawImage>,
}

impl<'a> Chain<'a> {
    /// The white balance is that of the scene's own light through the lens.
    pub(super) fn new(capture: &'a Capture, scene: &Scene) -> Result<Self> {
        let mut responses = capture.sensor.responses();
        for (_, response) in &mut responses {
            *response = response.product(&capture.lens.transmittance);
        }
        let colour = camera_colour(&responses, scene.light_spectrum());
        Ok(Self { capture, colour: colour.map_err(|invalid| capture.source.error(invalid.within("sensor")))? })
    }

    /// Electron rates (e⁻/s) of the sensor's channels.
    pub(super) fn rates(&self, film: &Film) -> Estimate {
        film.estimate(self.capture.sensor.cfa.channels().iter().map(String::as_str))
    }

    /// Exposes to electron rates.
    pub(super) fn expose(&self, rates: &Estimate) -> Result<Exposed> {
        let Capture { sensor, lens, render, source, .. } = self.capture;
        let in_exposure = |invalid: Invalid| source.error(invalid.within("exposure"));
        let exposure = self.exposure(rates).map_err(in_exposure)?;
        let electrons = rates.clone().scaled(exposure.time.0);
        let frame = |frame| {
            let key = NoiseKey { seed: render.seed, frame: u64::from(frame) };
            let mut raw = expose(&electrons.mean, sensor, &exposure, Stages::ALL, key).map_err(in_exposure)?;
            raw.metadata.f_number = Some(lens.f_number);
            raw.metadata.focal_length_m = Some(lens.focal_length_m);
            raw.metadata.colour_matrix_d65 = self.colour.map(|c| c.matrix_d65);
            raw.metadata.colour_matrix_a = self.colour.map(|c| c.matrix_a);
            raw.metadata.as_shot_neutral = self.colour.map(|c| c.neutral);
            Ok(raw)
        };
        let frames = (0..self.capture.exposure.frames).map(frame).collect::<Result<_>>()?;
        Ok(Exposed { exposure, electrons, frames })
    }

    /// Develops for display.
    pub(super) fn develop(&self, raw: &RawImage) -> Result<Picture8> {
        develop(raw, &DevelopSettings::default()).map_err(|invalid| self.capture.source.error(invalid))
    }

    /// The exposure that the capture asks for, its time found from the light where it is automatic.
    fn exposure(&self, rates: &Estimate) -> Result<Exposure, Invalid> {
        let Capture { sensor, exposure: wanted, .. } = self.capture;
        let time = match wanted.time {
            ExposureTime::Fixed(time) => time,
            ExposureTime::Auto(target) => auto_exposure(&rates.mean, sensor, wanted.gain, wanted.temperature, target)?,
        };
        Ok(Exposure { time, gain: wanted.gain, temperature: wanted.temperature })
    }

    /// Ratio of the root-mean-square Monte Carlo noise to that of the sensor, over each pixel's own channel. Pixels that
    /// saturate do not count: no noise shows there. `None` where there is not enough light for an exposure.
    pub(super) fn noise_ratio(&self, rates: &Estimate) -> Option<f64> {
        let exposure = self.exposure(rates).ok()?;
        let sensor = &self.capture.sensor;
        let (width, time) = (rates.mean.width(), exposure.time.0);
        let saturation = sensor.saturation_capacity(&exposure).0;
        let (mut of_light, mut of_sensor) = (0.0, 0.0);
        for pixel in 0..width * rates.mean.height() {
            let channel = sensor.cfa.channel_at(pixel % width, pixel / width);
            let at = |planes: &Planes| f64::from(planes.channels()[channel].data[pixel]);
            let mean = at(&rates.mean) * time;
            if mean < saturation {
                of_light += at(&rates.variance) * time * time;
                of_sensor += sensor.noise_variance(Electrons(mean), &exposure);
            }
        }
        (of_sensor > 0.0).then(|| (of_light / of_sensor).sqrt())
    }

    pub(super) fn exposure_report(&self, exposed: &Exposed) -> ExposureReport {
        let Exposure { time, gain, temperature } = exposed.exposure;
        ExposureReport {
            time_s: time.0,
            auto: matches!(self.capture.exposure.time, ExposureTime::Auto(_)),
            gain_db: gain.0,
            temperature_c: temperature.0,
            frames: self.capture.exposure.frames,
        }
    }

    pub(super) fn sensor_report(&self, exposed: &Exposed) -> SensorReport {
        let sensor = &self.capture.sensor;
        let raw = &exposed.frames[0];
        SensorReport {
            name: sensor.name.clone(),
            resolution_px: sensor.resolution,
            pixel_pitch_um: sensor.pixel_pitch_m.map(|m| (m * 1e9).round() / 1e3),
            channels: sensor.cfa.channels().to_vec(),
            bits: raw.bits,
            black_level_dn: raw.black_level_dn,
            white_level_dn: raw.white_level_dn,
            system_gain_dn_per_e: sensor.converter.system_gain(exposed.exposure.gain),
            saturation_capacity_e: sensor.saturation_capacity(&exposed.exposure).0,
            read_noise_e: sensor.noise.read.0,
            as_shot_neutral: raw.metadata.as_shot_neutral,
            colour_matrix_d65: raw.metadata.colour_matrix_d65,
        }
    }
}
