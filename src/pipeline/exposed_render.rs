//! A sensor that stored light has fallen on, to be read out into memory or into a folder.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use glam::DAffine3;

use super::camera::camera_of;
use super::carried::Carried;
use super::chain::{Chain, Exposed, Optics, SensorColours, Settings};
use super::lens_corrections::KnownCorrections;
use super::monitor::{Event, Monitor};
use super::needs::Needs;
use super::output_folder::OutputFolder;
use super::results::{Frames, SeriesState, write_results};
use super::shot::Shot;
use super::stored::Stored;
use super::stored_light::StoredLight;
use crate::Result;
use crate::capture::{StoredCapture, relative_path};
use crate::develop::DevelopSettings;
use crate::image::{Estimate, Planes};
use crate::integrator::WavelengthChoice;
use crate::optics::{Camera, Focus, LensDescription};
use crate::raw::RawImage;
use crate::report::{LensReport, LightReport, Report, SCHEMA_VERSION, Timings, TracedReport};
use crate::sensor::{Exposure, NoiseMap, SensorModel, electron_rates};
use crate::spectrum::{Spectrum, illuminant};
use crate::units::{Decibels, Seconds};
use photosite_core::memory;
use photosite_core::warnings::Warnings;

/// A sensor that stored light has fallen on.
#[derive(Clone)]
pub struct ExposedRender {
    sensor: ReadySensor,
    exposed: Exposed,
    /// About all of it.
    warnings: Vec<String>,
    input: PathBuf,
    overrides: Vec<String>,
    timings: Timings,
}

/// A sensor with all that is found of it once.
#[derive(Clone)]
struct ReadySensor {
    stored: Stored,
    white: Spectrum,
    optics: Optics,
    colours: SensorColours,
    placed: Option<(LensDescription, Camera)>,
    corrections: Arc<KnownCorrections>,
    /// What automatic exposure found when this was exposed before.
    known_gains: Option<[Decibels; 2]>,
    /// About keys that its sensor was made of.
    sensor_warnings: Vec<String>,
    /// Those and all others but about its exposure.
    warnings: Vec<String>,
}

impl ExposedRender {
    /// Light that was read from `input` within `load_s` seconds, and changed by overrides.
    pub(super) fn new(
        stored: Stored,
        light: StoredLight,
        (input, overrides): (PathBuf, Vec<String>),
        load_s: f64,
    ) -> Result<Self> {
        let start = Instant::now();
        let sensor = ReadySensor::new(stored)?;
        if let Some(left) = memory::left() {
            let needs = Needs::new(Settings::from(&sensor.stored.capture));
            needs.check(left, needs.exposing())?;
        }
        let (exposed, more) = sensor.expose(light)?;
        let mut warnings = Warnings::default();
        let said = sensor.warnings.iter().chain(&more).chain(&exposed.warnings);
        said.for_each(|warning| warnings.once(warning));
        let warnings = warnings.into_messages();
        let timings = Timings { load_s, expose_s: start.elapsed().as_secs_f64(), ..Timings::default() };
        Ok(Self { sensor, exposed, warnings, input, overrides, timings })
    }

    /// Warnings about the light, the sensor and the exposure, each once.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// How its raw images are developed.
    pub fn develop_settings(&self) -> &DevelopSettings {
        &self.sensor.stored.capture.develop
    }

    /// The noise maps that its capture asks for.
    pub fn noise_maps(&self) -> &[NoiseMap] {
        &self.sensor.stored.capture.output.noise.maps
    }

    /// Reads out the frame of that number, after one that has left charge in the sensor, with these noise maps.
    ///
    /// # Errors
    ///
    /// Light of a series that cannot be read.
    pub fn read_out(&self, frame: u32, before: &Carried, maps: &[NoiseMap]) -> Result<Shot> {
        let own_light = (frame as usize).checked_sub(1).and_then(|earlier| self.sensor.stored.later.get(earlier));
        let own = own_light.map(|path| self.sensor.expose(self.sensor.read(path)?)).transpose()?;
        let exposed = own.as_ref().map_or(&self.exposed, |(exposed, _)| exposed);
        let mut carried = before.clone();
        let (raw, noise_maps, exposure) = self.sensor.chain().read_out_next(exposed, frame, maps, &mut carried)?;
        let electrons = Arc::clone(&exposed.electrons);
        Ok(Shot { raw, exposure, electrons, noise_maps, carried, warnings: Vec::new() })
    }

    /// What a report says of a shot in memory: there are no files.
    ///
    /// # Errors
    ///
    /// Values of the capture that cannot be written.
    pub fn report(&self, shot: &Shot, frame: u32) -> Result<Report> {
        let report = self.sensor.report((&shot.exposure, &shot.raw, &[]), frame, Path::new("."))?;
        let input = self.input.display().to_string();
        Ok(Report { input, overrides: self.overrides.clone(), warnings: self.warnings.clone(), ..report })
    }

    /// Reads out and develops into a folder as many frames as the capture asks for, the report last, which is returned.
    pub fn write_into(self, folder: &mut OutputFolder, monitor: &dyn Monitor) -> Result<Report> {
        let of = 1 + self.sensor.stored.later.len() as u32;
        let all = Frames::All(self.sensor.stored.capture.exposure.frames);
        self.write_frames(if of > 1 { Frames::One { number: 0, of } } else { all }, folder, monitor)
    }

    /// Reads out the frame of that number alone, as [`write_into`](Self::write_into) does.
    pub fn write_frame_into(self, frame: u32, folder: &mut OutputFolder, monitor: &dyn Monitor) -> Result<Report> {
        self.write_frames(Frames::One { number: frame, of: 1 }, folder, monitor)
    }

    fn write_frames(self, frames: Frames, folder: &mut OutputFolder, monitor: &dyn Monitor) -> Result<Report> {
        let Self { sensor, exposed, warnings, input, overrides, mut timings } = self;
        warnings.iter().for_each(|warning| monitor.report(Event::Warning(warning)));
        let later = &sensor.stored.later;
        let chain = sensor.chain();
        let mut exposure = exposed.exposure;
        let mut state = SeriesState::default();
        let first = write_results(monitor, &chain, exposed, frames, folder, &mut timings, &mut state, |_, _| Ok(()))?;
        if let Frames::One { number: 0, of } = frames {
            for (number, path) in (1..of).zip(later) {
                let start = Instant::now();
                let (exposed, _) = sensor.expose(sensor.read(path)?)?;
                exposure = exposed.exposure;
                timings.expose_s += start.elapsed().as_secs_f64();
                let frames = Frames::One { number, of };
                write_results(monitor, &chain, exposed, frames, folder, &mut timings, &mut state, |_, _| Ok(()))?;
            }
        }
        let frame = match frames {
            Frames::One { number, of: 1 } => number,
            Frames::All(_) | Frames::One { .. } => 0,
        };
        let report = Report {
            input: relative_path(&input, folder.path()),
            overrides,
            files: folder.files(),
            sums: folder.sums().clone(),
            warnings,
            timings: Some(timings),
            ..sensor.report((&exposure, &first, &state.gains), frame, folder.path())?
        };
        folder.write_report(&report)?;
        Ok(report)
    }
}

impl ReadySensor {
    fn new(stored: Stored) -> Result<Self> {
        let Stored { capture, recorded, gains, calibration, traced, .. } = &stored;
        // A sensor that stays was made of the same keys.
        let stays = recorded.as_ref().filter(|recorded| recorded.sensor == capture.sensor);
        let before = stays.map_or(&[][..], |recorded| &recorded.sensor_warnings);
        let sensor_warnings = [before, &*capture.sensor_warnings].concat();
        let mut warnings = [&*traced.light_warnings, &*sensor_warnings, &*capture.warnings].concat();
        let white = match traced.scene_light.as_ref().and_then(LightReport::spectrum) {
            Some(light) => light,
            None => {
                warnings.push("nothing tells what light the scene has, so the white balance is that of D65".to_owned());
                illuminant::d65().clone()
            }
        };
        let lens = traced.lens.as_ref();
        let optics = Optics {
            f_number: lens.and_then(|lens| lens.f_number),
            focal_length_m: lens.and_then(|lens| lens.focal_length_mm).filter(|f| *f > 0.0).map(|f| f / 1e3),
            transmittance: capture.lens.transmittance.clone(),
        };
        let placed = recorded.as_ref().zip(lens).and_then(|(recorded, lens)| placed_lens(recorded, lens));
        let settings = Settings::from(capture);
        let colours = SensorColours::find(settings, &optics, &white, calibration.as_ref())?;
        warnings.extend(colours.warning.clone());
        // What is asked for again as it was takes what automatic exposure found then, to the last bit.
        let same = recorded.as_ref().is_some_and(|r| {
            let specimen = SensorModel { serial: capture.sensor.serial, ..r.sensor.clone() };
            specimen == capture.sensor && r.exposure.is_like(&capture.exposure)
        });
        let known_gains = gains.filter(|_| same);
        let corrections = Arc::default();
        let mut ready = Self {
            stored,
            white,
            optics,
            colours,
            placed,
            corrections,
            known_gains,
            sensor_warnings,
            warnings: Vec::new(),
        };
        let has_targets = ready.stored.traced.targets.as_ref().is_some_and(|targets| !targets.is_empty());
        warnings.extend(ready.chain().picture_warnings(has_targets));
        if has_targets && ready.stored.grid.is_some_and(|before| before != ready.chain().image_grid()) {
            warnings.push(
                "the points of targets are brought to the pixels of this image; points_visible is false of all that the \
                 rendered one did not show"
                    .to_owned(),
            );
        }
        let Stored { capture, recorded, traced, .. } = &ready.stored;
        if let Some(recorded) = recorded.as_ref().filter(|r| r.sensor.pixel_pitch_m != capture.sensor.pixel_pitch_m) {
            warnings.push(other_pitch(&recorded.sensor, &capture.sensor));
        }
        if recorded.as_ref().is_some_and(|r| traced_for_other_filters(traced, &r.sensor, &capture.sensor)) {
            warnings.push(
                "the light of each pixel was traced for its own filter (render.wavelengths = \"own-filter\"); with other \
                 filters the picture is right on average, but noisier"
                    .to_owned(),
            );
        }
        ready.warnings = warnings;
        Ok(ready)
    }

    fn chain(&self) -> Chain<'_> {
        let lens = self.placed.as_ref().map(|(lens, camera)| (lens, camera, &*self.corrections));
        Chain::new(Settings::from(&self.stored.capture), &self.optics, &self.colours, lens)
    }

    /// What a report says of a picture, but for its files; paths are relative to a folder.
    fn report(
        &self,
        (exposure, raw, gains): (&Exposure, &RawImage, &[Decibels]),
        frame: u32,
        folder: &Path,
    ) -> Result<Report> {
        let (capture, chain) = (&self.stored.capture, self.chain());
        let mut exposure_report = chain.exposure_report(exposure, gains);
        exposure_report.frame = (frame > 0).then_some(frame);
        let mut traced = self.stored.traced.clone();
        if let Some(before) = &self.stored.grid {
            let now = chain.image_grid();
            traced.targets.iter_mut().flatten().for_each(|target| target.move_points(before, &now));
        }
        Ok(Report {
            schema_version: SCHEMA_VERSION,
            photosite_version: env!("CARGO_PKG_VERSION").to_owned(),
            input: String::new(),
            overrides: Vec::new(),
            capture: capture.to_json(folder)?,
            fingerprint: None,
            seed: capture.seed,
            traced,
            sensor: chain.sensor_report(exposure, raw, &self.sensor_warnings),
            image: chain.image_report(),
            pixel_grid: chain.grid_report(),
            exposure: exposure_report,
            files: Vec::new(),
            sums: BTreeMap::new(),
            warnings: Vec::new(),
            timings: None,
        })
    }

    /// The light of a later picture of a series.
    fn read(&self, path: &Path) -> Result<StoredLight> {
        let light = StoredLight::read(path)?;
        light.check(&self.stored.capture)?;
        Ok(light)
    }

    /// Exposes to light, with warnings about it.
    fn expose(&self, light: StoredLight) -> Result<(Exposed, Vec<String>)> {
        let (capture, chain) = (&self.stored.capture, self.chain());
        match light {
            StoredLight::Electrons { electrons, collected } => {
                let at = capture.exposure.at(collected);
                let known = self.known_gains.map(|[gain, digital_gain]| Exposure { gain, digital_gain, ..at });
                Ok((chain.expose(electrons, collected, known)?, Vec::new()))
            }
            StoredLight::Irradiance { path, bands } => {
                let rates =
                    electron_rates(&bands, &capture.sensor, &self.white).map_err(|invalid| invalid.in_file(&path))?;
                let variance = Planes::zeros::<&str>(bands.width(), bands.height(), []);
                drop(bands);
                let light = Estimate { mean: rates.rates, variance };
                Ok((chain.expose(light, Seconds(1.0), None)?, rates.warnings))
            }
        }
    }
}

/// The lens as the report has it, so that raw files tell of its falloff and distortion as those of the render do.
/// `None` where the report does not say enough.
fn placed_lens(recorded: &StoredCapture, reported: &LensReport) -> Option<(LensDescription, Camera)> {
    let focus = match reported.focus_distance_m {
        Some(u) if u > 0.0 => Focus::Distance(u),
        Some(_) => Focus::ImageDistance(reported.image_distance_mm? / 1e3),
        None => Focus::Infinity,
    };
    let focal_length_m = reported.focal_length_mm? / 1e3;
    let lens = LensDescription { focus, focal_length_m, ..recorded.lens.clone() };
    // Where the camera stands makes no difference to what its lens does.
    let camera = camera_of(&lens, &recorded.sensor, DAffine3::IDENTITY, f64::NAN).ok()?;
    camera.makes_picture().then_some((lens, camera))
}

/// Whether light is that of pixels whose paths have the wavelengths of their own filters, which are others now.
fn traced_for_other_filters(traced: &TracedReport, recorded: &SensorModel, sensor: &SensorModel) -> bool {
    let own_filter = WavelengthChoice::OwnFilter.name();
    let for_own = traced.render.as_ref().is_some_and(|render| render.wavelengths == own_filter);
    let same_filters = || recorded.cfa == sensor.cfa && recorded.responses() == sensor.responses();
    for_own && recorded.cfa.is_mosaic() && !same_filters()
}

fn other_pitch(recorded: &SensorModel, sensor: &SensorModel) -> String {
    let um = |sensor: &SensorModel| sensor.pixel_pitch_m.map(|m| ((m * 1e9).round() / 1e3).to_string()).join(" × ");
    format!(
        "the light was traced for pixels of {} µm; those of {} µm see the same picture, as behind a lens whose focal length \
         grows with them, at the same f-number",
        um(recorded),
        um(sensor)
    )
}
