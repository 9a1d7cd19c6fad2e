//! A capture whose light is stored: what remains to be decided is the sensor, its exposure, and what is written.
//!
//! In: the report of a render (`capture.json`), whose `capture` holds all keys that were given, or nothing but the size
//! of the stored image; and overrides, `key=value`, whose paths are relative to where the command is given. Out: a
//! [`StoredCapture`]. The scene is neither read nor needed.

use std::path::Path;
use std::sync::Arc;

use serde_json::{Value, json};

use super::super::Capture;
use super::super::camera::calibration::Calibrated;
use super::super::camera::lens::describe_lens;
use super::super::camera::prescription::Prescribed;
use super::super::settings::develop;
use super::super::settings::exposure::{self, ExposureSettings};
use super::super::settings::output::{self, OutputSettings};
use super::super::settings::sensor::{anchor_files, read_sensor, sensor_model};
use super::super::tables::spectra::Finder;
use super::super::tables::{CameraTable, LensTable, SECTIONS};
use super::super::tree::overrides;
use super::super::tree::source::{CaptureSource, shown};
use super::relocate::keys_of;
use super::sections::refuse_unknown_sections;
use super::stored_report::StoredReport;
use photosite_core::Sandbox;
use photosite_core::warnings::Warnings;
use photosite_core::{Error, Invalid, Result};
use photosite_develop::DevelopSettings;
use photosite_sensor::SensorModel;
use photosite_transport::integrator::RenderSettings;
use photosite_transport::optics::{Focus, LensDescription};
use photosite_transport::scene::description::SceneDescription;

/// The part of a capture that stored light leaves open.
#[derive(Clone, Debug)]
pub struct StoredCapture {
    /// The sensor.
    pub sensor: SensorModel,
    /// Settings of the exposure.
    pub exposure: ExposureSettings,
    /// Settings of the files to write.
    pub output: OutputSettings,
    /// Settings of the development of the raw image.
    pub develop: DevelopSettings,
    /// Seed of sensor noise.
    pub seed: u64,
    /// The lens that the stored light has passed. What a glTF camera or autofocus decided of it is not known here.
    pub lens: LensDescription,
    /// Calibration of the camera, on the pixels that the image was taken with.
    calibrated: Option<Calibrated>,
    /// Warnings about keys that its sensor was made of, and which its values no longer show.
    pub sensor_warnings: Vec<String>,
    /// Warnings about the values of sensor and exposure.
    pub warnings: Vec<String>,
    /// Source of all values, for errors that show up later.
    pub source: CaptureSource,
}

impl StoredCapture {
    /// Stored capture of the report at `path`, with overrides, `key=value`, laid over it. Files that they name lie in a
    /// sandbox.
    pub fn of_report(sandbox: &Sandbox, path: &Path, report: &StoredReport, arguments: &[String]) -> Result<Self> {
        check(path, arguments)?;
        let mut source = report.source(path).within(sandbox);
        let calibrated = calibrated(&source)?;
        lay_over(&mut source, arguments)?;
        Self::assemble(source, calibrated)
    }

    /// Stored capture of an image of which nothing is known but its size, with overrides, `key=value`.
    pub fn of_image(sandbox: &Sandbox, path: &Path, resolution_px: [usize; 2], arguments: &[String]) -> Result<Self> {
        check(path, arguments)?;
        let mut source = CaptureSource::empty(path).within(sandbox);
        source.set_default("sensor", "resolution_px", &json!(resolution_px));
        lay_over(&mut source, arguments)?;
        Self::assemble(source, None)
    }

    /// The stored capture with more changes, `key=value`.
    ///
    /// # Errors
    ///
    /// A key that light transport has used; a value that cannot be used.
    pub fn with(&self, changes: &[String]) -> Result<Self> {
        Self::changed(&self.source, &self.sensor.name, self.calibrated.clone(), changes)
    }

    /// Lays changes over keys whose sensor is whole.
    fn changed(
        source: &CaptureSource,
        sensor_name: &str,
        calibrated: Option<Calibrated>,
        changes: &[String],
    ) -> Result<Self> {
        check(source.path(), changes)?;
        let mut source = source.clone();
        if let Some(mut sensor) = source.take_sensor() {
            // Its paths are relative to the current folder already, those of a report to its own.
            anchor_files(&mut sensor, &std::env::current_dir().unwrap_or_default());
            source.keep_sensor(sensor, sensor_name);
        }
        lay_over(&mut source, changes)?;
        Self::assemble(source, calibrated)
    }

    fn assemble(mut source: CaptureSource, calibrated: Option<Calibrated>) -> Result<Self> {
        refuse_unknown_sections(&source)?;
        // Region and binning, which would tell, may be others now.
        if let Some(area) = calibrated.as_ref().and_then(|calibrated| calibrated.area_px) {
            source.set_default("lens", "calibration_area_px", &json!(area));
        }
        let merged = read_sensor(&mut source, Path::new(""))?;
        let lens: LensTable = source.read("lens")?.unwrap_or_default();
        let render: RenderSettings = source.read("render")?.unwrap_or_default();
        let (exposure, output) =
            (source.read("exposure")?.unwrap_or_default(), source.read("output")?.unwrap_or_default());
        let finder = Finder::new(source.path().parent().unwrap_or(Path::new("")), source.sandbox(), Vec::new());
        let at = |table: &'static str| {
            let source = &source;
            move |invalid: Invalid| source.error(invalid.within(table))
        };
        let sensor = sensor_model(&merged, source.sandbox()).map_err(at("sensor"))?;
        // Warnings about the lens were given when light was traced.
        let mut given = Warnings::default();
        let prescribed = Prescribed::of(&finder, &lens, &mut given).map_err(at("lens"))?;
        let known = (prescribed, calibrated.as_ref());
        let lens = describe_lens(&finder, &lens, known, &sensor, None, Some(Focus::Infinity), &mut given);
        let lens = lens.map_err(at("lens"))?;
        let exposure = exposure::exposure(&exposure, &sensor).map_err(at("exposure"))?;
        let of_settings = sensor.warnings().into_iter().chain(exposure.warning());
        let warnings = source.displaced().iter().cloned().chain(of_settings).collect();
        render.validate().map_err(at("render"))?;
        Ok(Self {
            exposure,
            output: output::output(&output, &sensor).map_err(at("output"))?,
            develop: develop::checked(&source.read("develop")?.unwrap_or_default()).map_err(|e| source.error(e))?,
            seed: render.seed,
            sensor,
            lens,
            calibrated,
            sensor_warnings: merged.warnings,
            warnings,
            source: source.clone(),
        })
    }

    /// All keys as they now are, as in [`Capture::to_json`](super::super::Capture::to_json).
    pub fn to_json(&self, folder: &Path) -> Result<Value> {
        keys_of(&self.source, &self.sensor.name, Some(folder))
    }
}

impl Capture {
    /// The stored capture with another f-number; all else stays.
    ///
    /// # Errors
    ///
    /// A number that no lens has.
    pub fn at_f_number(&self, f_number: f64) -> Result<Self> {
        let argument = format!("lens.f_number={f_number:?}");
        let mut changed = self.clone();
        overrides::set(&mut changed.source, &argument)?;
        changed.lens.f_number = f_number;
        let checked = changed.lens.validate().map_err(|invalid| invalid.within("lens"));
        checked.map_err(|invalid| changed.source.error(invalid))?;
        changed.origin.iter_mut().for_each(|origin| origin.overrides.push(argument.clone()));
        Ok(changed)
    }

    /// Stored capture of this one with changes, `key=value`, to what light leaves open once it is traced: sensor,
    /// exposure, development, output and the seed of the sensor's noise. The scene is not read again, nor is it in the
    /// result.
    ///
    /// # Errors
    ///
    /// A key that light transport has used; a value that cannot be used.
    pub fn for_traced_light(&self, changes: &[String]) -> Result<Self> {
        let changed = StoredCapture::changed(&self.source, &self.sensor.name, self.calibrated.clone(), changes)?;
        let StoredCapture {
            sensor,
            exposure,
            output,
            develop,
            seed,
            sensor_warnings,
            warnings,
            source,
            lens: _,
            calibrated,
        } = changed;
        // A sensor that stays was made of the same keys.
        let before = if sensor == self.sensor { &*self.sensor_warnings } else { &[] };
        let origin = self.origin.clone().map(|mut origin| {
            origin.overrides.extend_from_slice(changes);
            origin
        });
        Ok(Self {
            scene: Arc::new(SceneDescription { files: self.scene.files.clone(), ..SceneDescription::default() }),
            warnings: self.light_warnings(),
            sensor_warnings: [before, &*sensor_warnings].concat(),
            exposure_warnings: warnings,
            known_scene: None,
            models: self.models.clone(),
            calibrated,
            targets: self.targets.clone(),
            recording: self.recording.clone(),
            lens: self.lens.clone(),
            render: RenderSettings { seed, ..self.render.clone() },
            sensor,
            exposure,
            output,
            develop,
            source,
            origin,
            device: self.device.clone(),
            ..*self
        })
    }
}

/// Calibration of the camera on the pixels of the image that is stored, before anything of the exposure is changed.
fn calibrated(source: &CaptureSource) -> Result<Option<Calibrated>> {
    let lens: LensTable = source.read("lens")?.unwrap_or_default();
    if lens.calibration.is_none() {
        return Ok(None);
    }
    let camera: CameraTable = source.read("camera")?.unwrap_or_default();
    let merged = read_sensor(&mut source.clone(), Path::new(""))?;
    let finder = Finder::new(source.path().parent().unwrap_or(Path::new("")), source.sandbox(), Vec::new());
    let calibrated = || -> Result<_, Invalid> {
        let sensor = sensor_model(&merged, source.sandbox()).map_err(|invalid| invalid.within("sensor"))?;
        let exposure = source.read("exposure").map_err(|_| Invalid::new("exposure", "cannot be read"))?;
        let exposure = exposure::exposure(&exposure.unwrap_or_default(), &sensor).map_err(|e| e.within("exposure"))?;
        let read_out = sensor.read_out_grid(&exposure.region, exposure.stages);
        Calibrated::of(&finder, (&camera, &lens), &sensor, &read_out, &mut Warnings::default())
    };
    calibrated().map_err(|invalid| source.error(invalid))
}

fn lay_over(source: &mut CaptureSource, arguments: &[String]) -> Result<()> {
    arguments.iter().try_for_each(|argument| overrides::set(source, argument))
}

/// Refuses arguments that light transport has already used.
fn check(path: &Path, arguments: &[String]) -> Result<()> {
    for argument in arguments {
        let mut one = CaptureSource::empty(path);
        overrides::set(&mut one, argument)?;
        let is_open = ["sensor", "exposure", "develop", "output"].iter().any(|table| one.get(table).is_some())
            || one.get("render.seed").is_some();
        // An unknown table gets its own message later.
        let is_known = SECTIONS.iter().any(|section| one.get(section).is_some());
        if is_known && !is_open {
            return Err(Error::Override {
                argument: shown(argument),
                message: "the light has already been traced, and this can no longer change it".to_owned(),
                help: Some("set keys of sensor, exposure, develop or output, or render again".into()),
            });
        }
    }
    Ok(())
}
