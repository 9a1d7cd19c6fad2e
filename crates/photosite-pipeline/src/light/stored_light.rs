//! Light that was read, with the sensor that it falls on now: exposed, told of, and written into folders.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use glam::DAffine3;

use super::light_file::LightFile;
use super::stored_facts::StoredFacts;
use crate::camera::capture_camera::camera_of;
use crate::camera::lens_corrections::KnownCorrections;
use crate::expose::chain::{Chain, CollectedElectrons, Optics, SensorColours, SensorSettings};
use crate::expose::frame_series::{Carried, FrameSeries};
use crate::expose::sensor_card::SensorCard;
use crate::monitor::{Event, Monitor};
use crate::prepare::memory_needs::Needs;
use crate::render::image_report::{Taken, report_of};
use crate::render::results::{Frames, Results};
use crate::write::output_folder::OutputFolder;
use photosite_capture::report::{ExposureReport, LensReport, LightReport, Report, Timings, TracedReport};
use photosite_capture::{StoredCapture, relative_path};
use photosite_core::Result;
use photosite_core::image::{Estimate, Planes};
use photosite_core::memory;
use photosite_core::spectrum::{Spectrum, illuminant};
use photosite_core::units::{Decibels, Seconds};
use photosite_core::warnings::Warnings;
use photosite_sensor::{Exposure, SensorModel, electron_rates};
use photosite_transport::integrator::WavelengthChoice;
use photosite_transport::optics::{Camera, Focus, LensDescription};

/// Sensor that light falls on which was read, with all that is found of it once.
pub(crate) struct StoredLight {
    pub(crate) facts: StoredFacts,
    white: Spectrum,
    optics: Optics,
    colours: Arc<SensorColours>,
    placed: Option<(LensDescription, Camera)>,
    corrections: Arc<KnownCorrections>,
    /// Gains that automatic exposure found when this light was exposed before.
    known_gains: Option<[Decibels; 2]>,
    /// Warnings about keys that its sensor was made of.
    sensor_warnings: Vec<String>,
    /// All warnings but those about its exposure: of the keys of its sensor, and others.
    pub(crate) warnings: Vec<String>,
}

impl StoredLight {
    /// Finds the facts about a sensor; `earlier` is the one before, whose colours are kept where the sensor is the
    /// same.
    pub(crate) fn new(facts: StoredFacts, earlier: Option<&Self>) -> Result<Self> {
        let StoredFacts { capture, recorded, gains, calibration, traced, .. } = &facts;
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
        let colours = match earlier.filter(|earlier| earlier.facts.capture.sensor == capture.sensor) {
            Some(earlier) => Arc::clone(&earlier.colours),
            None => {
                Arc::new(SensorColours::find(SensorSettings::from(capture), &optics, &white, calibration.as_ref())?)
            }
        };
        warnings.extend(colours.warning.clone());
        // What is asked for again as it was takes what automatic exposure found then, to the last bit.
        let same = recorded.as_ref().is_some_and(|r| {
            let with_serial = SensorModel { serial: capture.sensor.serial, ..r.sensor.clone() };
            with_serial == capture.sensor && r.exposure.is_like(&capture.exposure)
        });
        let known_gains = gains.filter(|_| same);
        let (corrections, none) = (Arc::default(), Vec::new());
        let mut ready =
            Self { facts, white, optics, colours, placed, corrections, known_gains, sensor_warnings, warnings: none };
        let has_targets = ready.facts.traced.targets.as_ref().is_some_and(|targets| !targets.is_empty());
        warnings.extend(ready.chain().image_warnings(has_targets));
        if has_targets && ready.facts.grid.is_some_and(|before| before != ready.chain().image_grid()) {
            warnings.push(
                "the points of targets are brought to the pixels of this image; points_visible is false of all that the \
                 rendered one did not show"
                    .to_owned(),
            );
        }
        let StoredFacts { capture, recorded, traced, .. } = &ready.facts;
        if let Some(recorded) = recorded.as_ref().filter(|r| r.sensor.pixel_pitch_m != capture.sensor.pixel_pitch_m) {
            warnings.push(other_pitch(&recorded.sensor, &capture.sensor));
        }
        if recorded.as_ref().is_some_and(|r| traced_for_other_filters(traced, &r.sensor, &capture.sensor)) {
            warnings.push(
                "the light of each pixel was traced for its own filter (render.wavelengths = \"own-filter\"); with other \
                 filters the image is right on average, but noisier"
                    .to_owned(),
            );
        }
        ready.warnings = warnings;
        ready.warnings = ready.warnings_and(&[]);
        Ok(ready)
    }

    /// Warnings about the light and these others, each once.
    pub(crate) fn warnings_and(&self, more: &[String]) -> Vec<String> {
        let mut all = Warnings::default();
        self.warnings.iter().chain(more).for_each(|warning| all.once(warning));
        all.into_messages()
    }

    pub(crate) fn chain(&self) -> Chain<'_> {
        let lens = self.placed.as_ref().map(|(lens, camera)| (lens, camera, &*self.corrections));
        Chain::new(SensorSettings::from(&self.facts.capture), &self.optics, &self.colours, lens)
    }

    /// Report of an image, but for its files; paths are relative to a folder.
    pub(crate) fn report(&self, taken: &Taken<'_>, warnings: Vec<String>, folder: &Path) -> Result<Report> {
        let chain = self.chain();
        let StoredFacts { capture, input, overrides, traced, grid, .. } = &self.facts;
        let mut traced = traced.clone();
        if let Some(before) = grid {
            let now = chain.image_grid();
            traced.targets.iter_mut().flatten().for_each(|target| target.move_points(before, &now));
        }
        let report = report_of(&chain, traced, taken, &self.sensor_warnings, capture.to_json(folder)?);
        Ok(Report { input: input.display().to_string(), overrides: overrides.clone(), warnings, ..report })
    }

    /// Number of frames that have light of their own; `None` where all see the same.
    pub(crate) fn own_lights(&self) -> Option<u32> {
        Some(1 + self.facts.later.len() as u32).filter(|lights| *lights > 1)
    }

    /// Light of the frame of that number, where it has light of its own and is not the first.
    pub(crate) fn own_light(&self, number: u32) -> Result<Option<LightFile>> {
        let own = (number as usize).checked_sub(1).and_then(|earlier| self.facts.later.get(earlier));
        let read = |path: &PathBuf| {
            let light = LightFile::read(path)?;
            light.check(&self.facts.capture).map(|()| light)
        };
        own.map(read).transpose()
    }

    /// Exposes to the light of a frame.
    pub(crate) fn expose(&self, light: LightFile) -> Result<CollectedElectrons> {
        let (capture, chain) = (&self.facts.capture, self.chain());
        match light {
            LightFile::Electrons { electrons, collected } => {
                let at = capture.exposure.at(collected);
                let known = self.known_gains.map(|[gain, digital_gain]| Exposure { gain, digital_gain, ..at });
                chain.expose(electrons, collected, known)
            }
            LightFile::Irradiance { path, bands } => {
                let rates =
                    electron_rates(&bands, &capture.sensor, &self.white).map_err(|invalid| invalid.in_file(&path))?;
                let variance = Planes::zeros::<&str>(bands.width(), bands.height(), []);
                drop(bands);
                let exposed = chain.expose(Estimate { mean: rates.rates, variance }, Seconds(1.0), None)?;
                Ok(CollectedElectrons { warnings: [rates.warnings, exposed.warnings].concat(), ..exposed })
            }
        }
    }

    /// Refuses an exposure that takes more memory than there is.
    pub(crate) fn check_memory(&self) -> Result<()> {
        let Some(left) = memory::left() else { return Ok(()) };
        let needs = Needs::new(SensorSettings::from(&self.facts.capture));
        needs.check(left, needs.exposing())
    }

    /// Reads out and develops into a folder as many frames as the capture asks for, or one that comes after others, the
    /// report last, which is returned. A card exposes and develops what it has.
    pub(crate) fn write_into(
        &self,
        light: LightFile,
        one: Option<(u32, Carried)>,
        folder: &mut OutputFolder,
        (monitor, card): (&dyn Monitor, Option<&SensorCard>),
    ) -> Result<Report> {
        let start = Instant::now();
        self.check_memory()?;
        let chain = self.chain().on(card);
        let frames = match (&one, self.own_lights()) {
            (Some((number, _)), _) => Frames::One { number: *number, of: 1 },
            (None, Some(of)) => Frames::One { number: 0, of },
            (None, None) => Frames::All(self.facts.capture.exposure.frames),
        };
        let own = self.own_light(frames.first())?;
        let exposed = self.expose(own.unwrap_or(light))?;
        let mut warnings = self.warnings_and(&exposed.warnings);
        warnings.iter().for_each(|warning| monitor.report(Event::Warning(warning)));
        let mut timings = Timings { load_s: self.facts.load_s, ..Timings::default() };
        timings.expose_s = start.elapsed().as_secs_f64();
        let mut exposure = exposed.exposure;
        let maps = &self.facts.capture.output.noise.maps;
        let series = FrameSeries::new(chain, maps, one.unwrap_or_default());
        let mut results = Results { series, folder, timings: &mut timings, monitor, device: None };
        let first = results.write(exposed, frames, |_, _| Ok(()))?;
        if let Frames::One { number: 0, of } = frames {
            for number in 1..of {
                let start = Instant::now();
                let Some(light) = self.own_light(number)? else { break };
                let exposed = self.expose(light)?;
                exposure = exposed.exposure;
                results.timings.expose_s += start.elapsed().as_secs_f64();
                results.write(exposed, Frames::One { number, of }, |_, _| Ok(()))?;
            }
        }
        let gains = results.series.gains.clone();
        let device = results.device.take().and_then(|device| device.map_err(|warning| warnings.push(warning)).ok());
        let taken = Taken { exposure: &exposure, raw: &first, gains: &gains, frame: frames.first() };
        let report = self.report(&taken, warnings, folder.path())?;
        let report = Report {
            input: relative_path(&self.facts.input, folder.path()),
            files: folder.files(),
            sums: folder.sums().clone(),
            timings: Some(timings),
            exposure: ExposureReport { device, ..report.exposure },
            ..report
        };
        folder.write_report(&report)?;
        Ok(report)
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
    camera.makes_image().then_some((lens, camera))
}

/// Whether light is that of pixels whose paths have the wavelengths of their own filters, which are others now.
fn traced_for_other_filters(traced: &TracedReport, recorded: &SensorModel, sensor: &SensorModel) -> bool {
    let own_filter = WavelengthChoice::OwnFilter;
    let for_own = traced.render.as_ref().is_some_and(|render| render.wavelengths == own_filter);
    let same_filters = || recorded.cfa == sensor.cfa && recorded.responses() == sensor.responses();
    for_own && recorded.cfa.is_mosaic() && !same_filters()
}

fn other_pitch(recorded: &SensorModel, sensor: &SensorModel) -> String {
    let um = |sensor: &SensorModel| sensor.pixel_pitch_m.map(|m| ((m * 1e9).round() / 1e3).to_string()).join(" × ");
    format!(
        "the light was traced for pixels of {} µm; those of {} µm see the same image, as behind a lens whose focal length \
         grows with them, at the same f-number",
        um(recorded),
        um(sensor)
    )
}
