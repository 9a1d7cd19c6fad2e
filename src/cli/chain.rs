//! From traced light to raw files and a picture: exposure, sensor, development, and what is said of them.

use photosite::develop::colour_matrix::{CameraColour, camera_colour};
use photosite::develop::{DevelopSettings, Picture8, develop};
use photosite::film::Film;
use photosite::image::{Estimate, Planes};
use photosite::io::capture::{Capture, ExposureSettings, ExposureTime};
use photosite::raw::RawImage;
use photosite::scene::Scene;
use photosite::sensor::{Exposure, NoiseKey, auto_exposure, expose};
use photosite::spectrum::illuminant;
use photosite::units::Electrons;
use photosite::{Error, Invalid, Result};

use super::report::{ExposureReport, SensorReport};

/// The steps after light transport, with what they need of the capture.
pub(super) struct Chain<'a> {
    capture: &'a Capture,
    colour: Option<CameraColour>,
}

/// What the sensor counts on average during an exposure.
pub(super) struct Exposed {
    pub(super) exposure: Exposure,
    /// Mean electrons with the variance that light transport leaves, e⁻ and (e⁻)².
    pub(super) electrons: Estimate,
}

impl<'a> Chain<'a> {
    /// The white balance is that of the scene's own light through the lens. Where a channel does not see that light, as
    /// in the dark, it is that of daylight, with a warning.
    pub(super) fn new(capture: &'a Capture, scene: &Scene, warnings: &mut Vec<String>) -> Result<Self> {
        let light = scene.light_spectrum();
        if light.iter().any(|(_, value)| !value.is_finite()) {
            let invalid = Invalid::new("scene", "its size or its lights are too large to compute with");
            let help = "compare the geometry's unit with meters_per_unit, and look for a light of too many zeros";
            return Err(capture.source.error(invalid.help(help)));
        }
        // Only the colour of the light counts; its level could leave the range of numbers.
        let brightest = f64::from(light.max());
        let light = if brightest > 0.0 { light.scale(1.0 / brightest) } else { light.clone() };
        let mut responses = capture.sensor.responses();
        for (_, response) in &mut responses {
            *response = response.product(&capture.lens.transmittance);
        }
        let colour = camera_colour(&responses, &light).or_else(|invalid| {
            let colour = camera_colour(&responses, illuminant::d65())?;
            if brightest > 0.0 {
                warnings.push(format!("{}, so the white balance is that of D65", invalid.message));
            }
            Ok(colour)
        });
        let in_sensor = |invalid: Invalid| capture.source.error(invalid.within("sensor"));
        Ok(Self { capture, colour: colour.map_err(in_sensor)? })
    }

    /// Electron rates (e⁻/s) of the sensor's channels.
    pub(super) fn rates(&self, film: &Film) -> Estimate {
        film.estimate(self.capture.sensor.cfa.channels().iter().map(String::as_str))
    }

    /// Collects light at these electron rates.
    pub(super) fn expose(&self, rates: &Estimate) -> Result<Exposed> {
        let exposure = self.exposure(rates).map_err(|invalid| self.in_exposure(invalid))?;
        Ok(Exposed { exposure, electrons: rates.clone().scaled(exposure.time.0) })
    }

    /// Reads the sensor out; each frame has noise of its own.
    pub(super) fn read_out(&self, exposed: &Exposed, frame: u32) -> Result<RawImage> {
        let Capture { sensor, lens, render, exposure: ExposureSettings { stages, .. }, .. } = self.capture;
        let Exposed { exposure, electrons } = exposed;
        let key = NoiseKey { seed: render.seed, frame: u64::from(frame) };
        let mut raw = expose(&electrons.mean, sensor, exposure, *stages, key).map_err(|e| self.in_exposure(e))?;
        raw.metadata.f_number = Some(lens.f_number);
        raw.metadata.focal_length_m = Some(lens.focal_length_m);
        raw.metadata.colour_matrix_d65 = self.colour.map(|c| c.matrix_d65.to_vec());
        raw.metadata.colour_matrix_a = self.colour.map(|c| c.matrix_a.to_vec());
        raw.metadata.as_shot_neutral = self.colour.map(|c| c.neutral.to_vec());
        Ok(raw)
    }

    fn in_exposure(&self, invalid: Invalid) -> Error {
        self.capture.source.error(invalid.within("exposure"))
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
        let ExposureSettings { gain, temperature, frame_interval, .. } = *wanted;
        let exposure = Exposure { time, gain, temperature, frame_interval };
        // The time of an automatic exposure is known only now.
        exposure.validate(sensor)?;
        Ok(exposure)
    }

    /// Ratio of the root-mean-square Monte Carlo noise to that of the sensor, over each pixel's own channel. Pixels that
    /// saturate do not count: no noise shows there. `None` where there is not enough light for an exposure, and after a
    /// single sample, which tells nothing of noise.
    pub(super) fn noise_ratio(&self, film: &Film) -> Option<f64> {
        if film.samples() < 2 {
            return None;
        }
        let rates = self.rates(film);
        let exposure = self.exposure(&rates).ok()?;
        let sensor = &self.capture.sensor;
        let (width, time) = (rates.mean.width(), exposure.time.0);
        let samples = sensor.cfa.samples_per_pixel();
        let row_length = width * samples;
        let saturation = sensor.saturation_capacity(&exposure).0;
        let (mut of_light, mut of_sensor) = (0.0, 0.0);
        for i in 0..row_length * rates.mean.height() {
            let channel = sensor.cfa.channel_at(i % row_length, i / row_length);
            let at = |planes: &Planes| f64::from(planes.channels()[channel].data[i / samples]);
            let mean = at(&rates.mean) * time;
            if mean < saturation {
                of_light += at(&rates.variance) * time * time;
                of_sensor += sensor.noise_variance(Electrons(mean), &exposure);
            }
        }
        (of_sensor > 0.0).then(|| (of_light / of_sensor).sqrt())
    }

    pub(super) fn exposure_report(&self, exposed: &Exposed) -> ExposureReport {
        let Exposure { time, gain, temperature, .. } = exposed.exposure;
        ExposureReport {
            time_s: time.0,
            auto: matches!(self.capture.exposure.time, ExposureTime::Auto(_)),
            gain_db: gain.0,
            temperature_c: temperature.0,
            frames: self.capture.exposure.frames,
        }
    }

    pub(super) fn sensor_report(&self, exposed: &Exposed, raw: &RawImage) -> SensorReport {
        let sensor = &self.capture.sensor;
        SensorReport {
            name: sensor.name.clone(),
            resolution_px: sensor.resolution,
            pixel_pitch_um: sensor.pixel_pitch_m.map(|m| (m * 1e9).round() / 1e3),
            channels: sensor.cfa.channels().to_vec(),
            bits: raw.bits,
            black_level_dn: raw.black_level_dn.mean(),
            white_level_dn: raw.white_level_dn,
            system_gain_dn_per_e: sensor.converter.system_gain(exposed.exposure.gain),
            saturation_capacity_e: sensor.saturation_capacity(&exposed.exposure).0,
            read_noise_e: sensor.noise.read.0,
            as_shot_neutral: raw.metadata.as_shot_neutral.clone(),
            colour_matrix_d65: raw.metadata.colour_matrix_d65.clone(),
        }
    }
}
