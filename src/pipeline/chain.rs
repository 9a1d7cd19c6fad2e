//! From traced light to raw files and a picture: exposure, sensor, development, and warnings about them.

use std::sync::Arc;

use rayon::prelude::*;

use crate::capture::{Capture, CaptureSource, ExposureSettings, ExposureTime, OutputSettings, StoredCapture};
use crate::develop::camera_colour::{CameraColour, neutral};
use crate::develop::merge::Merged;
use crate::develop::{DevelopSettings, EncodedPicture, Resampling, SensorCalibration, develop, develop_merged};
use crate::image::{Estimate, Planes};
use crate::integrator::WavelengthChoice;
use crate::io::developed::PictureFormat;
use crate::raw::RawImage;
use crate::scene::Scene;
use crate::sensor::{
    Exposure, LeftCharge, Metering, Neighbours, NoiseKey, NoiseMap, NoiseMaps, RegionOfInterest, SensorModel,
    auto_exposure, expose_after, noise_ratio, samples_needed, smoothed_mean,
};
use crate::spectrum::{Spectrum, illuminant};
use crate::units::{Decibels, Seconds};
use crate::{Error, Invalid, Result};

use super::lens_corrections::{LensSeen, SeenLens, read_out_grid};
use crate::report::{ExposureReport, ImageReport, NoiseReport, PixelGridReport, SensorReport};
use photosite_core::image_grid::ImageGrid;

/// What the chain needs of a capture.
#[derive(Clone, Copy)]
pub(super) struct Settings<'a> {
    pub(super) sensor: &'a SensorModel,
    pub(super) exposure: &'a ExposureSettings,
    pub(super) output: &'a OutputSettings,
    pub(super) develop: &'a DevelopSettings,
    /// Seed of sensor noise.
    pub(super) seed: u64,
    /// Pixels that know of light as well as a pixel does.
    pub(super) neighbours: Neighbours,
    pub(super) source: &'a CaptureSource,
}

impl<'a> From<&'a Capture> for Settings<'a> {
    fn from(capture: &'a Capture) -> Self {
        let Capture { sensor, exposure, output, develop, render, source, .. } = capture;
        let neighbours = match render.wavelengths {
            WavelengthChoice::AllFilters => Neighbours::All,
            WavelengthChoice::OwnFilter => Neighbours::OfTheSameChannel,
        };
        Self { sensor, exposure, output, develop, seed: render.seed, neighbours, source }
    }
}

impl<'a> From<&'a StoredCapture> for Settings<'a> {
    fn from(capture: &'a StoredCapture) -> Self {
        let StoredCapture { sensor, exposure, output, develop, seed, source, .. } = capture;
        // Nothing is traced.
        let neighbours = Neighbours::All;
        Self { sensor, exposure, output, develop, seed: *seed, neighbours, source }
    }
}

/// The lens that light has passed, as far as raw files describe it.
#[derive(Clone)]
pub(super) struct Optics {
    pub(super) f_number: Option<f64>,
    pub(super) focal_length_m: Option<f64>,
    pub(super) transmittance: Spectrum,
}

/// What is found of a sensor's colours once, for all of its exposures to one light.
#[derive(Clone)]
pub(super) struct SensorColours {
    /// `None` for sensors without colours.
    camera: Option<CameraColour>,
    calibration: Option<SensorCalibration>,
    /// Where the white balance is not that of the light.
    pub(super) warning: Option<String>,
}

/// The steps after light transport.
#[derive(Clone, Copy)]
pub(super) struct Chain<'a> {
    pub(super) settings: Settings<'a>,
    optics: &'a Optics,
    colours: &'a SensorColours,
    /// What raw files say of falloff and distortion comes from these.
    lens: Option<SeenLens<'a, 'a>>,
}

/// What the sensor counts on average during an exposure.
#[derive(Clone)]
pub(super) struct Exposed {
    pub(super) exposure: Exposure,
    /// Mean electrons with the variance that light transport leaves, e⁻ and (e⁻)².
    pub(super) electrons: Arc<Estimate>,
    /// Warnings about the exposure.
    pub(super) warnings: Vec<String>,
}

/// The spectrum of all light of a scene, the largest value 1; 0 everywhere in the dark. Only the colour of the light
/// counts; its level could leave the range of numbers.
pub(super) fn scene_light(capture: &Capture, scene: &Scene) -> Result<Spectrum> {
    let light = scene.light_spectrum();
    if light.iter().any(|(_, value)| !value.is_finite()) {
        let invalid = Invalid::new("scene", "its size or its lights are too large to compute with");
        let help = "compare the geometry's unit with meters_per_unit, and look for a light of too many zeros";
        return Err(capture.source.error(invalid.help(help)));
    }
    let brightest = f64::from(light.max());
    Ok(if brightest > 0.0 { light.scale(1.0 / brightest) } else { light.clone() })
}

impl SensorColours {
    /// The white balance is that of `light` through the lens. Where a channel does not see that light, as in the dark,
    /// it is that of daylight, with a warning. `stored` is what an earlier run has found of its sensor.
    pub(super) fn find(
        settings: Settings<'_>,
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
    /// The steps after light transport. With a lens, raw files hold its falloff and distortion.
    pub(super) fn new(
        settings: Settings<'a>,
        optics: &'a Optics,
        colours: &'a SensorColours,
        lens: Option<SeenLens<'a, 'a>>,
    ) -> Self {
        Self { settings, optics, colours, lens }
    }

    /// Warnings about what images and raw files do not show of the lens, and what images do not hold. `has_targets` is
    /// whether the report says where points of targets appear.
    pub(super) fn picture_warnings(&self, has_targets: bool) -> Vec<String> {
        let Settings { sensor, output, exposure, develop, .. } = self.settings;
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
        let unused = PictureFormat::Png.unused_keys(develop);
        warnings.extend(unused.into_iter().map(|key| format!("develop.{key} does not affect image.png")));
        warnings
    }

    /// What the developed picture is a picture of, where the lens is known.
    pub(super) fn image_report(&self) -> Option<ImageReport> {
        let Settings { sensor, exposure, develop, output, .. } = self.settings;
        let lens = self.lens.filter(|_| output.image);
        lens.map(|lens| LensSeen::knowing(lens, sensor, &exposure.region, exposure.stages).image_report(develop))
    }

    /// The pixels of the image that is delivered, which ground truth and points have.
    pub(super) fn image_grid(&self) -> ImageGrid {
        let Settings { sensor, exposure, develop, output, .. } = self.settings;
        let ExposureSettings { region, stages, .. } = exposure;
        match self.lens {
            Some(lens) => LensSeen::knowing(lens, sensor, region, *stages).image_grid(output.image.then_some(develop)),
            None => read_out_grid(sensor, region, *stages),
        }
    }

    /// Where these lie on the sensor, where the lens is known.
    pub(super) fn grid_report(&self) -> Option<PixelGridReport> {
        let Settings { sensor, exposure, develop, output, .. } = self.settings;
        let seen = LensSeen::knowing(self.lens?, sensor, &exposure.region, exposure.stages);
        Some(seen.grid_report(output.image.then_some(develop)))
    }

    /// How the grid of the whole sensor becomes that of the ideal picture, where it does not stay.
    pub(super) fn ideal_resampling(&self) -> Option<Resampling> {
        let Settings { sensor, exposure, develop, .. } = self.settings;
        LensSeen::knowing(self.lens?, sensor, &RegionOfInterest::WHOLE, exposure.stages).resampling(develop)
    }

    /// Names of the sensor's channels, of which films and stored rows have the electron rates (e⁻/s).
    pub(super) fn channels(&self) -> impl Iterator<Item = &'a str> + Clone + use<'a> {
        self.settings.sensor.cfa.channels().iter().map(String::as_str)
    }

    /// Exposes to light that frees these electrons within the time `collected`; electron rates are those of one second.
    /// `known` stands in for what an automatic exposure would find.
    pub(super) fn expose(
        &self,
        light: impl Into<Arc<Estimate>>,
        collected: Seconds,
        known: Option<Exposure>,
    ) -> Result<Exposed> {
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
        Ok(Exposed { exposure, electrons, warnings: warning.into_iter().chain(clipped).collect() })
    }

    /// Tells where most of a picture whose exposure is stated is saturated, and where one that was metered is in more
    /// than glints. A bracket is meant to be, in part.
    fn saturation_warning(&self, electrons: &Planes, exposure: &Exposure) -> Option<String> {
        let Settings { sensor, exposure: wanted, .. } = self.settings;
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
                    "{percent} % of the picture is saturated: shorten exposure.time_s or leave it out, or raise lens.f_number"
                )
            }),
            // Who lengthens the time means it.
            ExposureTime::Auto(auto) if auto.compensation_ev > 0.0 => None,
            ExposureTime::Auto(auto) => match auto.metering {
                Metering::Highlights { brighter_part, .. } => (part > 0.001).then(|| format!(
                    "{percent:.1} % of the picture is saturated, which automatic exposure allows the brightest {} %, such \
                     as lamps: write exposure.auto_brighter_part = 0 where bright objects are as small",
                    brighter_part * 100.0
                )),
                Metering::Mean(_) => (part > 0.02).then(|| format!(
                    "{percent:.1} % of the picture is saturated, as automatic exposure meters its mean: lower \
                     exposure.auto_mean, or write exposure.auto_brighter_part = 0 in its place for bright objects"
                )),
            },
        }
    }

    /// Reads the sensor out; each frame has noise of its own.
    pub(super) fn read_out(&self, exposed: &Exposed, frame: u32) -> Result<RawImage> {
        self.read_out_with_maps(exposed, exposed.exposure.gain, frame, &[], &mut None).map(|(raw, _)| raw)
    }

    /// Reads out at an analogue gain, with maps of what some effects did. `left` is the charge that the frame before has left in the sensor,
    /// and then what this one leaves.
    pub(super) fn read_out_with_maps(
        &self,
        exposed: &Exposed,
        gain: Decibels,
        frame: u32,
        maps: &[NoiseMap],
        left: &mut Option<LeftCharge>,
    ) -> Result<(RawImage, NoiseMaps)> {
        let Settings { sensor, exposure: ExposureSettings { stages, .. }, seed, .. } = self.settings;
        let Exposed { exposure, electrons, .. } = exposed;
        let exposure = &Exposure { gain, ..*exposure };
        let key = NoiseKey { seed, frame: u64::from(frame) };
        let shot = expose_after(&electrons.mean, sensor, exposure, *stages, key, maps, left.as_ref());
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
        Ok((raw, maps))
    }

    /// The times of the bracket that is asked for, if one is.
    pub(super) fn bracket(&self, exposed: &Exposed) -> Result<Option<Vec<Seconds>>> {
        let Settings { sensor, exposure: wanted, .. } = self.settings;
        let Some(times) = wanted.bracket.as_ref().map(|bracket| bracket.times(exposed.exposure.time)) else {
            return Ok(None);
        };
        let valid = times.iter().try_for_each(|&time| Exposure { time, ..exposed.exposure }.validate(sensor));
        valid.map_err(|invalid| self.in_exposure(invalid)).map(|()| Some(times))
    }

    pub(super) fn in_exposure(&self, invalid: Invalid) -> Error {
        self.settings.source.error(invalid.within("exposure"))
    }

    /// Develops for display.
    pub(super) fn develop(&self, raw: &RawImage) -> Result<EncodedPicture> {
        let developed = develop(raw, self.settings.develop);
        developed.map_err(|invalid| self.settings.source.error(invalid.within("develop")))
    }

    /// Develops the light of a bracket to linear planes, whose pixels have the aspect that comes with them.
    pub(super) fn develop_merged(&self, merged: Merged) -> Result<(Planes, f64)> {
        let developed = develop_merged(merged, self.settings.develop);
        developed
            .map(|(planes, development)| (planes, development.pixel_aspect))
            .map_err(|invalid| self.settings.source.error(invalid.within("develop")))
    }

    /// The exposure that the capture asks for, its time found from the light where it is automatic, and what is to be
    /// said of that.
    fn exposure(&self, light: &Planes, collected: Seconds) -> Result<(Exposure, Option<String>), Invalid> {
        let Settings { sensor, exposure: wanted, .. } = self.settings;
        match wanted.time {
            ExposureTime::Fixed(time) => Ok((wanted.at(time), None)),
            // Any time serves to find the rest.
            ExposureTime::Auto(target) => auto_exposure(light, collected, sensor, &wanted.at(Seconds(1.0)), target)
                .map(|found| (found.exposure, found.warning())),
        }
    }

    /// Ratio of Monte Carlo noise to that of the sensor over a picture of at least so many samples a pixel. `None`
    /// where there is not enough light for an exposure, and after a single sample, which gives no variance.
    pub(super) fn noise_ratio(&self, rates: &Estimate, samples: u32) -> Option<f64> {
        if samples < 2 {
            return None;
        }
        let (exposure, _) = self.exposure(&rates.mean, Seconds(1.0)).ok()?;
        noise_ratio(rates, self.settings.sensor, &exposure)
    }

    /// How many samples of each pixel bring that ratio down to `target` there, estimated from rates of so many samples;
    /// `None` as above.
    pub(super) fn samples_needed(&self, rates: &Estimate, counts: &[u32], target: f64) -> Option<Vec<f32>> {
        let Settings { sensor, neighbours, .. } = self.settings;
        let (exposure, _) = self.exposure(&smoothed_mean(rates, counts, sensor, neighbours), Seconds(1.0)).ok()?;
        Some(samples_needed(rates, counts, sensor, &exposure, target, neighbours))
    }

    /// What rates of so many samples have reached of a noise target; `pilot_paths` beside them have found how many it
    /// takes.
    pub(super) fn noise_report(&self, rates: &Estimate, counts: &[u32], target: f64, pilot_paths: u64) -> NoiseReport {
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

    /// `gains` are those that gain control has found.
    pub(super) fn exposure_report(&self, exposure: &Exposure, gains: &[Decibels]) -> ExposureReport {
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
            bracket_s: self
                .settings
                .exposure
                .bracket
                .as_ref()
                .map(|bracket| bracket.times(time).iter().map(|time| time.0).collect()),
        }
    }

    /// What a report says of the sensor, of whose keys there are these warnings.
    pub(super) fn sensor_report(&self, exposure: &Exposure, raw: &RawImage, warnings: &[String]) -> SensorReport {
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
