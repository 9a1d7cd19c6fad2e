//! Chain from traced light to raw files and an image: exposure, sensor, development, and warnings about them.

use std::sync::Arc;

use rayon::prelude::*;

use photosite_capture::{Capture, CaptureSource, ExposureSettings, ExposureTime, OutputSettings, StoredCapture};
use photosite_core::image::{Estimate, Planes};
use photosite_core::spectrum::{Spectrum, illuminant};
use photosite_core::units::{Decibels, Seconds};
use photosite_core::{Error, Invalid, Result};
use photosite_develop::camera_colour::{CameraColour, neutral};
use photosite_develop::merge::Merged;
use photosite_develop::{DevelopSettings, EncodedImage, Resampling, SensorCalibration, develop, develop_merged};
use photosite_files::formats::PNG;
use photosite_raw::RawImage;
use photosite_sensor::{
    ExposedFrame, Exposure, LeftCharge, LightNoise, Metering, Neighbours, NoiseKey, NoiseMap, NoiseMaps,
    RegionOfInterest, SensorModel, auto_exposure, expose_after, samples_needed, sensor_noise, smoothed_mean,
};
use photosite_transport::integrator::WavelengthChoice;
use photosite_transport::scene::Scene;

use crate::camera::lens_corrections::{LensSeen, SeenLens};
use crate::expose::sensor_card::SensorCard;
use photosite_capture::report::{ExposureReport, ImageReport, NoiseReport, PixelGridReport, SensorReport};
use photosite_core::image_grid::ImageGrid;

/// Settings of a sensor that light falls on: exposure, output and development.
#[derive(Clone, Copy)]
pub struct SensorSettings<'a> {
    /// The sensor.
    pub sensor: &'a SensorModel,
    /// Settings of the exposure.
    pub exposure: &'a ExposureSettings,
    /// Settings of the files to write.
    pub output: &'a OutputSettings,
    /// Settings of development.
    pub develop: &'a DevelopSettings,
    /// Seed of sensor noise.
    pub seed: u64,
    /// Neighbouring pixels whose noise from light transport that of a pixel is taken to be like.
    pub(crate) neighbours: Neighbours,
    /// The capture, for errors that show up later.
    pub source: &'a CaptureSource,
}

impl<'a> From<&'a Capture> for SensorSettings<'a> {
    fn from(capture: &'a Capture) -> Self {
        let (sensor, exposure, output, develop, render, source) = (
            capture.sensor(),
            capture.exposure(),
            capture.output(),
            capture.develop(),
            capture.render(),
            capture.source(),
        );
        let neighbours = match render.wavelengths {
            WavelengthChoice::AllFilters => Neighbours::All,
            WavelengthChoice::OwnFilter => Neighbours::OfTheSameChannel,
        };
        Self { sensor, exposure, output, develop, seed: render.seed, neighbours, source }
    }
}

impl<'a> From<&'a StoredCapture> for SensorSettings<'a> {
    fn from(capture: &'a StoredCapture) -> Self {
        let StoredCapture { sensor, exposure, output, develop, seed, source, .. } = capture;
        // Nothing is traced.
        let neighbours = Neighbours::All;
        Self { sensor, exposure, output, develop, seed: *seed, neighbours, source }
    }
}

/// The lens that light has passed, as far as raw files describe it.
#[derive(Clone)]
pub(crate) struct Optics {
    pub(crate) f_number: Option<f64>,
    pub(crate) focal_length_m: Option<f64>,
    pub(crate) transmittance: Spectrum,
}

/// Colours of a sensor under one light, found once for all exposures.
#[derive(Clone)]
pub(crate) struct SensorColours {
    /// Colour calibration of the sensor; `None` for sensors without colours.
    camera: Option<CameraColour>,
    calibration: Option<SensorCalibration>,
    /// Warning where the white balance is not that of the light.
    pub(crate) warning: Option<String>,
}

/// The steps after light transport.
#[derive(Clone, Copy)]
pub(crate) struct Chain<'a> {
    pub(crate) settings: SensorSettings<'a>,
    pub(super) optics: &'a Optics,
    colours: &'a SensorColours,
    /// Lens from which raw files state falloff and distortion.
    lens: Option<SeenLens<'a, 'a>>,
    /// Card that exposes and develops what it has; `None` for the processor.
    card: Option<&'a SensorCard>,
}

/// Raw image that was read out.
pub(crate) struct ReadOut {
    pub(crate) raw: RawImage,
    pub(crate) maps: NoiseMaps,
    /// Name of the card that has exposed, or the warning that the processor has; `None` without a card.
    pub(crate) device: Option<Result<String, String>>,
}

/// Mean electrons that the sensor collects during an exposure.
#[derive(Clone)]
pub(crate) struct CollectedElectrons {
    pub(crate) exposure: Exposure,
    /// Mean electrons with the variance that light transport leaves, e⁻ and (e⁻)².
    pub(crate) electrons: Arc<Estimate>,
    /// Warnings about the exposure.
    pub(crate) warnings: Vec<String>,
}

/// The spectrum of all light of a scene, the largest value 1; 0 everywhere in the dark. Only the colour of the light
/// counts; its level could leave the range of numbers.
pub(crate) fn scene_light(capture: &Capture, scene: &Scene) -> Result<Spectrum> {
    let light = scene.light_spectrum();
    if light.iter().any(|(_, value)| !value.is_finite()) {
        let invalid = Invalid::new("scene", "its size or its lights are too large to compute with");
        let help = "compare the geometry's unit with meters_per_unit, and look for a light of too many zeros";
        return Err(capture.source().error(invalid.help(help)));
    }
    let brightest = f64::from(light.max());
    Ok(if brightest > 0.0 { light.scale(1.0 / brightest) } else { light.clone() })
}

impl SensorColours {
    /// Finds the colours of a sensor. The white balance is that of `light` through the lens. Where a channel does not
    /// see that light, as in the dark, it is that of daylight, with a warning. `stored` is what an earlier run has
    /// found of its sensor.
    pub(crate) fn find(
        settings: SensorSettings<'_>,
        optics: &Optics,
        light: &Spectrum,
        stored: Option<&SensorCalibration>,
    ) -> Result<Self> {
        let mut responses = settings.sensor.responses();
        for (_, response) in &mut responses {
            *response = response.product(&optics.transmittance);
        }
        let in_sensor = |invalid: Invalid| settings.source.error(invalid.within("sensor"));
        let calibration = SensorCalibration::of(&responses, stored).map_err(in_sensor)?;
        let Some(found) = &calibration else { return Ok(Self { camera: None, calibration: None, warning: None }) };
        let mut warning = None;
        let white = neutral(&responses, light).or_else(|invalid| {
            let white = neutral(&responses, illuminant::d65())?;
            if light.max() > 0.0 {
                warning = Some(format!("{}, so the white balance is that of D65", invalid.message));
            }
            Ok(white)
        });
        let camera = CameraColour { calibrations: found.lights().to_vec(), neutral: white.map_err(in_sensor)? };
        Ok(Self { camera: Some(camera), calibration, warning })
    }
}

impl<'a> Chain<'a> {
    /// Chain of the steps after light transport. With a lens, raw files hold its falloff and distortion.
    pub(crate) fn new(
        settings: SensorSettings<'a>,
        optics: &'a Optics,
        colours: &'a SensorColours,
        lens: Option<SeenLens<'a, 'a>>,
    ) -> Self {
        Self { settings, optics, colours, lens, card: None }
    }

    /// The chain with a card that exposes and develops.
    pub(crate) fn on(self, card: Option<&'a SensorCard>) -> Self {
        Self { card, ..self }
    }

    /// Warnings about what images and raw files do not show of the lens, and what images do not hold. `has_targets` is
    /// whether the report says where points of targets appear.
    pub(crate) fn image_warnings(&self, has_targets: bool) -> Vec<String> {
        let SensorSettings { sensor, output, exposure, develop, .. } = self.settings;
        let seen = self.lens.map(|lens| LensSeen::knowing(lens, sensor, &exposure.region, exposure.stages));
        let mut warnings = seen.map_or_else(Vec::new, |seen| seen.warnings(develop, output, has_targets));
        if !output.image {
            return warnings;
        }
        if !develop.colour_model.is_shown() {
            let model = develop.colour_model.name();
            warnings.push(format!(
                "image.png holds colours and no {model}; photosite develop raw.dng -o picture.tiff writes that, with the same \
                 develop.colour_model"
            ));
        }
        let unused = PNG.unused_keys(develop);
        warnings.extend(unused.into_iter().map(|key| format!("develop.{key} does not affect image.png")));
        warnings
    }

    /// Report of the camera of the developed image, where the lens is known.
    pub(crate) fn image_report(&self) -> Option<ImageReport> {
        let SensorSettings { sensor, exposure, develop, output, .. } = self.settings;
        let lens = self.lens.filter(|_| output.image);
        lens.map(|lens| LensSeen::knowing(lens, sensor, &exposure.region, exposure.stages).image_report(develop))
    }

    /// The pixels of the image that is delivered, which ground truth and points have.
    pub(crate) fn image_grid(&self) -> ImageGrid {
        let SensorSettings { sensor, exposure, develop, output, .. } = self.settings;
        let ExposureSettings { region, stages, .. } = exposure;
        match self.lens {
            Some(lens) => LensSeen::knowing(lens, sensor, region, *stages).image_grid(output.image.then_some(develop)),
            None => sensor.read_out_grid(region, *stages),
        }
    }

    /// Place of the delivered image's pixels on the sensor, for a report, where the lens is known.
    pub(crate) fn grid_report(&self) -> Option<PixelGridReport> {
        let SensorSettings { sensor, exposure, develop, output, .. } = self.settings;
        let seen = LensSeen::knowing(self.lens?, sensor, &exposure.region, exposure.stages);
        Some(seen.grid_report(output.image.then_some(develop)))
    }

    /// Resampling from the grid of the whole sensor to that of the ideal image; `None` where the grid stays.
    pub(super) fn ideal_resampling(&self) -> Option<Resampling> {
        let SensorSettings { sensor, exposure, develop, .. } = self.settings;
        LensSeen::knowing(self.lens?, sensor, &RegionOfInterest::WHOLE, exposure.stages).resampling(develop)
    }

    /// Names of the sensor's channels, of which films and stored rows have the electron rates (e⁻/s).
    pub(crate) fn channels(&self) -> impl Iterator<Item = &'a str> + Clone + use<'a> {
        self.settings.sensor.cfa.channels().iter().map(String::as_str)
    }

    /// Exposes to light that frees these electrons within the time `collected`; electron rates are those of one second.
    /// `known` stands in for what an automatic exposure would find.
    pub(crate) fn expose(
        &self,
        light: impl Into<Arc<Estimate>>,
        collected: Seconds,
        known: Option<Exposure>,
    ) -> Result<CollectedElectrons> {
        let light = light.into();
        let found = self.exposure(&light.mean, collected);
        let warning = found.as_ref().ok().and_then(|(_, warning)| warning.clone());
        let exposure = known.map_or_else(|| found.map(|(exposure, _)| exposure), Ok);
        // The time of an automatic exposure is known only now.
        let exposure = exposure.and_then(|exposure| exposure.validate(self.settings.sensor).map(|()| exposure));
        let exposure = exposure.map_err(|invalid| self.in_exposure(invalid))?;
        let electrons = if exposure.time == collected {
            light
        } else {
            // What nothing else needs is changed in place.
            Arc::new(Arc::unwrap_or_clone(light).scaled(exposure.time.0 / collected.0))
        };
        let warning = warning.or_else(|| self.saturation_warning(&electrons.mean, &exposure));
        let clipped = self.settings.sensor.clipped_blacks(&exposure, self.settings.exposure.stages);
        let beyond = self.settings.sensor.gain_beyond_steps(&exposure);
        let warnings = warning.into_iter().chain(clipped).chain(beyond).collect();
        Ok(CollectedElectrons { exposure, electrons, warnings })
    }

    /// Tells where most of an image whose exposure is stated is saturated, and where one that was metered is in more
    /// than glints. A bracket is meant to be, in part.
    fn saturation_warning(&self, electrons: &Planes, exposure: &Exposure) -> Option<String> {
        let SensorSettings { sensor, exposure: wanted, .. } = self.settings;
        if wanted.bracket.is_some() {
            return None;
        }
        let capacity = sensor.pixel_saturation(exposure).0 as f32;
        let values = || electrons.channels().par_iter().flat_map(|channel| &channel.data).filter(|value| **value > 0.0);
        let part = values().filter(|value| **value >= capacity).count() as f64 / values().count().max(1) as f64;
        let percent = part * 100.0;
        match wanted.time {
            ExposureTime::Fixed(_) => (part > 0.5).then(|| {
                let percent = percent.floor();
                format!(
                    "{percent} % of the image is saturated: shorten exposure.time_s or leave it out, or raise lens.f_number"
                )
            }),
            // Who lengthens the time means it.
            ExposureTime::Auto(auto) if auto.compensation_ev > 0.0 => None,
            ExposureTime::Auto(auto) => match auto.metering {
                Metering::Highlights { brighter_part, .. } => (part > 0.001).then(|| format!(
                    "{percent:.1} % of the image is saturated, which automatic exposure allows the brightest {} %, such \
                     as lamps: write exposure.auto_brighter_part = 0 where bright objects are as small",
                    brighter_part * 100.0
                )),
                Metering::Mean(_) => (part > 0.02).then(|| format!(
                    "{percent:.1} % of the image is saturated, as automatic exposure meters its mean: lower \
                     exposure.auto_mean, or write exposure.auto_brighter_part = 0 in its place for bright objects"
                )),
            },
        }
    }

    /// Reads the sensor out; each frame has noise of its own.
    pub(crate) fn read_out(&self, exposed: &CollectedElectrons, frame: u32) -> Result<RawImage> {
        self.read_out_with_maps(exposed, exposed.exposure.gain, frame, &[], &mut None).map(|read| read.raw)
    }

    /// Reads out at an analogue gain, with maps of the effects that are asked for. `left` is the charge that the frame
    /// before has left in the sensor, and then the charge that this one leaves.
    pub(crate) fn read_out_with_maps(
        &self,
        exposed: &CollectedElectrons,
        gain: Decibels,
        frame: u32,
        maps: &[NoiseMap],
        left: &mut Option<LeftCharge>,
    ) -> Result<ReadOut> {
        let SensorSettings { sensor, exposure: ExposureSettings { stages, .. }, seed, .. } = self.settings;
        let CollectedElectrons { exposure, electrons, .. } = exposed;
        let exposure = &Exposure { gain, ..*exposure };
        let key = NoiseKey { seed, frame: u64::from(frame) };
        let on_card = self.card.map(|card| card.expose((electrons, maps), sensor, exposure, *stages, key));
        let device = on_card.as_ref().zip(self.card).map(|(raw, card)| match raw {
            Ok(_) => Ok(card.name()),
            Err(lacking) => Err(format!("the processor exposes: {lacking}")),
        });
        let shot = match on_card.and_then(Result::ok) {
            Some(raw) => NoiseMaps::none(sensor, exposure, &raw).map(|maps| ExposedFrame { raw, maps, left: None }),
            None => expose_after(&electrons.mean, sensor, exposure, *stages, key, maps, left.as_ref()),
        };
        let shot = shot.map_err(|e| self.in_exposure(e))?;
        *left = shot.left;
        let (mut raw, maps) = (shot.raw, shot.maps);
        raw.metadata.f_number = self.optics.f_number;
        raw.metadata.focal_length_m = self.optics.focal_length_m;
        if let Some(colour) = &self.colours.camera {
            colour.write_to(&mut raw.metadata);
        }
        raw.metadata.baseline_exposure_ev = self.settings.output.dng_baseline_exposure_ev;
        if let Some(lens @ (_, _, known)) = self.lens {
            LensSeen::knowing(lens, sensor, &exposure.region, *stages).write_to(&mut raw.metadata, known);
        }
        Ok(ReadOut { raw, maps, device })
    }

    /// The times of the bracket that is asked for, if one is.
    pub(crate) fn bracket(&self, exposed: &CollectedElectrons) -> Result<Option<Vec<Seconds>>> {
        let SensorSettings { sensor, exposure: wanted, .. } = self.settings;
        let Some(times) = wanted.bracket.as_ref().map(|bracket| bracket.times(exposed.exposure.time)) else {
            return Ok(None);
        };
        let valid = times.iter().try_for_each(|&time| Exposure { time, ..exposed.exposure }.validate(sensor));
        valid.map_err(|invalid| self.in_exposure(invalid)).map(|()| Some(times))
    }

    pub(crate) fn in_exposure(&self, invalid: Invalid) -> Error {
        self.settings.source.error(invalid.within("exposure"))
    }

    /// Develops a raw image for display with settings of development, and tells why a card does not.
    pub(crate) fn develop_with(
        &self,
        raw: &RawImage,
        settings: &DevelopSettings,
    ) -> Result<(EncodedImage, Option<String>)> {
        let warning = match self.card.map(|card| card.develop(raw, settings)) {
            Some(Ok(image)) => return Ok((image, None)),
            Some(Err(lacking)) => Some(format!("the processor develops: {lacking}")),
            None => None,
        };
        let developed = develop(raw, settings);
        developed.map(|image| (image, warning)).map_err(|invalid| self.settings.source.error(invalid.within("develop")))
    }

    /// Develops the light of a bracket to linear planes, whose pixels have the aspect that comes with them.
    pub(crate) fn develop_merged(&self, merged: Merged) -> Result<(Planes, f64)> {
        let developed = develop_merged(merged, self.settings.develop);
        developed
            .map(|(planes, development)| (planes, development.pixel_aspect))
            .map_err(|invalid| self.settings.source.error(invalid.within("develop")))
    }

    /// Exposure that the capture asks for, its time found from the light where it is automatic, with warnings.
    fn exposure(&self, light: &Planes, collected: Seconds) -> Result<(Exposure, Option<String>), Invalid> {
        let SensorSettings { sensor, exposure: wanted, .. } = self.settings;
        match wanted.time {
            ExposureTime::Fixed(time) => Ok((wanted.at(time), None)),
            // Any time serves to find the rest.
            ExposureTime::Auto(target) => auto_exposure(light, collected, sensor, &wanted.at(Seconds(1.0)), target)
                .map(|found| (found.exposure, found.warning())),
        }
    }

    /// Monte Carlo noise beside that of the sensor over an image of at least `samples` samples a pixel. `None` where
    /// there is not enough light for an exposure, and after a single sample, which gives no variance.
    pub(crate) fn light_noise(&self, rates: &Estimate, samples: u32) -> Option<LightNoise> {
        if samples < 2 {
            return None;
        }
        let (exposure, _) = self.exposure(&rates.mean, Seconds(1.0)).ok()?;
        Some(LightNoise::new(rates, self.settings.sensor, &exposure))
    }

    /// Number of samples of each pixel that bring that noise ratio down to `target`, estimated from rates of `counts`
    /// samples; `None` where there is not enough light for an exposure, and after a single sample.
    pub(crate) fn samples_needed(&self, rates: &Estimate, counts: &[u32], target: f64) -> Option<Vec<f32>> {
        let SensorSettings { sensor, neighbours, .. } = self.settings;
        let (exposure, _) = self.exposure(&smoothed_mean(rates, counts, sensor, neighbours), Seconds(1.0)).ok()?;
        Some(samples_needed(rates, counts, sensor, &exposure, target, neighbours))
    }

    /// Variance of the sensor's noise at those rates, as a variance of rates; ∞ where it saturates. `None` where there is
    /// not enough light for an exposure.
    pub(crate) fn noise_variance(&self, rates: &Planes) -> Option<Planes> {
        let (exposure, _) = self.exposure(rates, Seconds(1.0)).ok()?;
        Some(sensor_noise(rates, self.settings.sensor, &exposure))
    }

    /// Report of the noise target that rates of `counts` samples have reached; `pilot_paths` more have found how many
    /// it takes.
    pub(crate) fn noise_report(&self, rates: &Estimate, counts: &[u32], target: f64, pilot_paths: u64) -> NoiseReport {
        let pixels = counts.len() as f64;
        let total: u64 = counts.iter().map(|&count| u64::from(count)).sum();
        // Where nothing is known, nothing is reached.
        let needed = self.samples_needed(rates, counts, target).unwrap_or_else(|| vec![f32::INFINITY; counts.len()]);
        let mut ratios: Vec<f64> =
            needed.iter().zip(counts).map(|(&n, &count)| target * (f64::from(n) / f64::from(count)).sqrt()).collect();
        let met = ratios.iter().filter(|&&ratio| ratio <= target).count();
        let place = (0.99 * pixels) as usize;
        let (_, high, _) = ratios.select_nth_unstable_by(place, f64::total_cmp);
        NoiseReport {
            target,
            samples_least: counts.iter().copied().min().unwrap_or(0),
            samples_mean: total as f64 / pixels,
            samples_most: counts.iter().copied().max().unwrap_or(0),
            pilot_samples_mean: pilot_paths as f64 / pixels,
            pixels_at_target: met as f64 / pixels,
            ratio_of_99_percent: high.is_finite().then_some(*high),
        }
    }

    /// Report of the exposure. `gains` are those that gain control has found.
    pub(crate) fn exposure_report(&self, exposure: &Exposure, gains: &[Decibels]) -> ExposureReport {
        let Exposure { time, gain, digital_gain, temperature, .. } = *exposure;
        ExposureReport {
            time_s: time.0,
            auto: matches!(self.settings.exposure.time, ExposureTime::Auto(_)),
            gain_db: gain.0,
            frame_gains_db: (!gains.is_empty()).then(|| gains.iter().map(|gain| gain.0).collect()),
            digital_gain_db: digital_gain.0,
            exposure_value: self.optics.f_number.map(|n| (n * n / time.0).log2()),
            iso: self.settings.sensor.iso(exposure),
            temperature_c: temperature.0,
            frames: self.settings.exposure.frames,
            frame: None,
            device: None,
            bracket_s: self
                .settings
                .exposure
                .bracket
                .as_ref()
                .map(|bracket| bracket.times(time).iter().map(|time| time.0).collect()),
        }
    }

    /// Report of the sensor, with warnings about its keys.
    pub(crate) fn sensor_report(&self, exposure: &Exposure, raw: &RawImage, warnings: &[String]) -> SensorReport {
        let sensor = self.settings.sensor;
        SensorReport {
            name: sensor.name.clone(),
            serial: sensor.serial,
            resolution_px: [raw.active().width, raw.active().height],
            pixel_pitch_um: raw.metadata.pixel_pitch_m.unwrap_or(sensor.pixel_pitch_m).map(|m| (m * 1e9).round() / 1e3),
            channels: sensor.cfa.channels().to_vec(),
            bits: raw.bits,
            black_level_dn: raw.black_level_dn.mean(),
            white_level_dn: raw.white_level_dn,
            linearisation_dn: raw.linearisation.clone(),
            system_gain_dn_per_e: sensor.system_gain(exposure),
            saturation_capacity_e: sensor.saturation_capacity(exposure).0,
            read_noise_e: sensor.read_noise(exposure).0,
            as_shot_neutral: raw.metadata.as_shot_neutral.clone(),
            colour_matrix_d65: raw.metadata.colour_matrix_d65().cloned(),
            calibration: self.colours.calibration.clone(),
            warnings: warnings.to_vec(),
        }
    }
}
