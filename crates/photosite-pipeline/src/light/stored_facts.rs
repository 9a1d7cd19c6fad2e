//! Facts about stored light: the capture that it was rendered for, and the one that it is exposed for now.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::light_file::LightFile;
use crate::camera::capture_camera::in_u32;
use crate::expose::light_reuse::{same_cells, same_times};
use crate::write::file_names::PART;
use photosite_capture::report::{LightReport, PixelGridReport, REPORT, Report, TracedReport};
use photosite_capture::{ExposureTime, StoredCapture, StoredReport};
use photosite_core::image::{Estimate, Planes};
use photosite_core::image_grid::ImageGrid;
use photosite_core::spectrum::illuminant;
use photosite_core::units::{Decibels, Seconds};
use photosite_core::{Error, Invalid, Result};
use photosite_core::{Remedy, Sandbox};
use photosite_develop::SensorCalibration;
use photosite_sensor::{ImageUnit, SensorModel, image_electrons};

/// Scale of an image of another program: the light on the sensor that its pixel values stand for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageScale {
    /// Quantity that the pixel values count.
    pub unit: ImageUnit,
    /// Quantity for a pixel value of 1; of files of integers, for white.
    pub one: f64,
    /// Whether codes are in proportion to light, whatever the file says of them.
    pub is_linear: bool,
}

/// Facts about stored light, without the light: the capture as it shall be, and as it was.
#[derive(Clone)]
pub(crate) struct StoredFacts {
    /// The folder or file of the light, or what stands for it in messages.
    pub(crate) input: PathBuf,
    /// Changes to keys of the capture, `key=value`.
    pub(crate) overrides: Vec<String>,
    /// Seconds that reading the light took.
    pub(crate) load_s: f64,
    pub(crate) capture: StoredCapture,
    /// Files of the light of all images but the first, where each image of a series has light of its own.
    pub(crate) later: Vec<PathBuf>,
    /// The capture as it was rendered, where that is known.
    pub(crate) recorded: Option<StoredCapture>,
    /// Analogue and digital gain that the light was exposed with.
    pub(crate) gains: Option<[Decibels; 2]>,
    /// Colour calibration that was found for its sensor.
    pub(crate) calibration: Option<SensorCalibration>,
    /// Report of the light.
    pub(crate) traced: TracedReport,
    /// Pixels of ground truth and points; `None` where nothing was traced.
    pub(crate) grid: Option<ImageGrid>,
}

impl StoredFacts {
    pub(crate) fn read(sandbox: &Sandbox, input: &Path, overrides: &[String]) -> Result<(Self, LightFile)> {
        let (folder, file) =
            if input.is_dir() { (input, None) } else { (input.parent().unwrap_or(Path::new("")), Some(input)) };
        let path = folder.join(REPORT);
        if file.is_none() && !path.exists() {
            let invalid = Invalid::new("", format!("has no {REPORT}, so nothing tells how it was rendered"));
            let help = if folder.join(PART).exists() {
                "it is a part of a render: photosite merge makes an image of all parts"
            } else {
                "give a folder that photosite render filled, or an electrons.exr or irradiance.exr"
            };
            return Err(invalid.help(help).in_file(input));
        }
        let stored = match file {
            None => Some(StoredReport::read(&path)?),
            // A file counts as part of the render if the report lists it.
            Some(file) => StoredReport::read(&path).ok().filter(|stored| lists(&stored.report, file)),
        };
        let Some(stored) = stored else {
            let light = LightFile::read(input)?;
            return Ok((Self::of_light(sandbox, input, &light, overrides)?, light));
        };
        let mut recorded = StoredCapture::of_report(sandbox, &path, &stored, &[])?;
        let capture = StoredCapture::of_report(sandbox, &path, &stored, overrides)?;
        let report = stored.report;
        let moves = moves(&report.traced);
        check_light_of(&recorded, &capture, moves)?;
        let numbered = moves && recorded.exposure.frames > 1;
        let same_response = recorded.sensor.responses() == capture.sensor.responses();
        let file = match file {
            Some(file) if numbered => return Err(one_of_a_series(file)),
            Some(file) => file.to_owned(),
            None => light_file(folder, numbered, same_response)?,
        };
        let light = LightFile::read(&file)?;
        let later = if numbered { 1..capture.exposure.frames } else { 1..1 };
        let later = later.map(|number| with_number(&file, number)).collect();
        if let (LightFile::Electrons { .. }, false) = (&light, same_response) {
            return Err(no_irradiance(folder));
        }
        light.check(&capture)?;
        // Earlier versions had points on the pixels of the sensor.
        let grid = report.pixel_grid.as_ref().map(PixelGridReport::grid);
        let grid = grid.unwrap_or_else(|| in_u32(recorded.sensor.resolution).into());
        let gains = [report.exposure.gain_db, report.exposure.digital_gain_db].map(Decibels);
        recorded.sensor_warnings = report.sensor.warnings;
        let stored = Self {
            input: input.to_owned(),
            overrides: overrides.to_vec(),
            load_s: 0.0,
            capture,
            later,
            recorded: Some(recorded),
            gains: Some(gains),
            calibration: report.sensor.calibration,
            traced: report.traced,
            grid: Some(grid),
        };
        Ok((stored, light))
    }

    /// The facts with changes, `key=value`, that this light still serves; `None` where other light of the render has to
    /// be read for them.
    pub(crate) fn with(&self, light: &LightFile, changes: &[String]) -> Result<Option<Self>> {
        let capture = self.capture.with(changes)?;
        let sees_the_same = capture.sensor.responses() == self.capture.sensor.responses();
        if matches!(light, LightFile::Electrons { .. }) && !sees_the_same {
            return Ok(None);
        }
        if let Some(recorded) = &self.recorded {
            check_light_of(recorded, &capture, moves(&self.traced))?;
        }
        light.check(&capture)?;
        let overrides = [&self.overrides[..], changes].concat();
        Ok(Some(Self { capture, overrides, ..self.clone() }))
    }

    /// Whether the light tells what a sensor sees: as the one that it was traced for, or by irradiance that is stored,
    /// too.
    pub(crate) fn tells_of(&self, light: &LightFile, sensor: &SensorModel) -> bool {
        let own = &self.capture.sensor;
        let has_irradiance = || {
            let names = ["irradiance.exr", "irradiance-0000.exr"];
            self.input.is_dir() && names.iter().any(|name| self.input.join(name).exists())
        };
        match light {
            LightFile::Irradiance { .. } => true,
            LightFile::Electrons { .. } => {
                own.cfa.channels() == sensor.cfa.channels() && own.responses() == sensor.responses() || has_irradiance()
            }
        }
    }

    /// Facts about light of which nothing else is known.
    pub(crate) fn of_light(sandbox: &Sandbox, input: &Path, light: &LightFile, overrides: &[String]) -> Result<Self> {
        let capture = StoredCapture::of_image(sandbox, input, light.resolution(), overrides)?;
        light.check(&capture)?;
        Ok(Self::alone(input, overrides, capture))
    }

    /// Facts about light of which nothing is known but the capture.
    fn alone(input: &Path, overrides: &[String], capture: StoredCapture) -> Self {
        Self {
            input: input.to_owned(),
            overrides: overrides.to_vec(),
            load_s: 0.0,
            capture,
            later: Vec::new(),
            recorded: None,
            gains: None,
            calibration: None,
            traced: TracedReport::default(),
            grid: None,
        }
    }

    /// Pixel values that are light as `scale` says; `assumed` is what they were taken for.
    pub(crate) fn of_planes(
        sandbox: &Sandbox,
        input: &Path,
        planes: &Planes,
        scale: &ImageScale,
        assumed: Option<&str>,
        overrides: &[String],
    ) -> Result<(Self, LightFile)> {
        let resolution = [planes.width(), planes.height()];
        let mut capture = StoredCapture::of_image(sandbox, input, resolution, overrides)?;
        let found = image_electrons(planes, &capture.sensor, scale.unit, scale.one);
        let found = found.map_err(|invalid| match invalid.key.as_str() {
            "" => invalid.in_file(input),
            _ => Error::Usage { message: format!("{}: {}", invalid.key, invalid.message), help: invalid.help },
        })?;
        let collected = match (found.per_second, capture.exposure.time) {
            (true, _) => Seconds(1.0),
            (false, ExposureTime::Fixed(time)) => time,
            (false, ExposureTime::Auto(_)) => {
                let message = "is not given, and the electrons of an exposure do not depend on its time, so that it cannot \
                               be found automatically";
                let help = Remedy::Override("exposure.time_s=0.01".to_owned());
                return Err(Invalid::new("exposure.time_s", message).help(help).in_file(input));
            }
        };
        let variance = Planes::zeros::<&str>(resolution[0], resolution[1], []);
        let light =
            LightFile::Electrons { electrons: Arc::new(Estimate { mean: found.electrons, variance }), collected };
        light.check(&capture)?;
        // What the caller has said himself needs no warning.
        capture.warnings.extend(assumed.iter().map(|assumed| format!("{assumed}; 1 is {}", in_words(scale))));
        capture.warnings.extend(found.warnings);
        let mut facts = Self::alone(input, overrides, capture);
        if scale.unit == ImageUnit::Lux {
            let daylight = illuminant::d65();
            facts.traced.scene_light = Some(LightReport::new(&daylight.scale(1.0 / f64::from(daylight.max()))));
        }
        Ok((facts, light))
    }
}

/// Whether the camera has moved while light was traced.
fn moves(traced: &TracedReport) -> bool {
    traced.camera.as_ref().is_some_and(|camera| camera.motion.is_some())
}

/// Refuses a capture that sees other light than what was recorded.
fn check_light_of(recorded: &StoredCapture, capture: &StoredCapture, moves: bool) -> Result<()> {
    let at = |invalid: Invalid| capture.source.error(invalid);
    same_times([recorded, capture].map(|c| (&c.sensor, &c.exposure)), moves).map_err(at)?;
    same_cells(&recorded.sensor, &capture.sensor).map_err(at)
}

/// Scale of an image in words: the meaning of a pixel value of 1.
fn in_words(scale: &ImageScale) -> String {
    let one = scale.one;
    match scale.unit {
        ImageUnit::Electrons => format!("{one} mean photo-electrons of a pixel in the exposure"),
        ImageUnit::FullWell => format!("{one} of the full well in the exposure"),
        ImageUnit::Lux => format!("{one} lx of D65 on the sensor, colours upsampled to spectra"),
        ImageUnit::Irradiance { wavelength_nm } => format!("{one} W/m² on the sensor at {wavelength_nm} nm"),
    }
}

/// File name of the frame of that number: `electrons-0000.exr` → `electrons-0007.exr`.
fn with_number(first: &Path, number: u32) -> PathBuf {
    let name = first.file_name().unwrap_or_default().to_string_lossy();
    first.with_file_name(name.replace("-0000", &format!("-{number:04}")))
}

fn one_of_a_series(file: &Path) -> Error {
    let invalid = Invalid::new("", "is one of a series of images, each of which has light of its own");
    invalid.help("give the folder that it lies in").in_file(file)
}

/// The file in a folder that serves: electrons where they are counted for the sensor, else irradiance.
fn light_file(folder: &Path, numbered: bool, same_response: bool) -> Result<PathBuf> {
    let number = if numbered { "-0000" } else { "" };
    let [electrons, irradiance] = ["electrons", "irradiance"].map(|name| folder.join(format!("{name}{number}.exr")));
    if same_response && electrons.exists() {
        Ok(electrons)
    } else if irradiance.exists() {
        Ok(irradiance)
    } else if electrons.exists() {
        Err(no_irradiance(folder))
    } else {
        let invalid = Invalid::new("", "contains no stored light: neither electrons.exr nor irradiance.exr");
        Err(invalid.help("render with output.electrons = true or output.irradiance = true").in_file(folder))
    }
}

fn no_irradiance(folder: &Path) -> Error {
    let message = "electrons.exr counts what the rendered sensor sees, and this sensor sees light differently";
    let help = "expose irradiance.exr instead, which is written with output.irradiance=true";
    Invalid::new("", message).help(help).in_file(folder)
}

fn lists(report: &Report, file: &Path) -> bool {
    let name = file.file_name().map(|name| name.to_string_lossy());
    report.files.iter().any(|listed| Some(&**listed) == name.as_deref())
}
