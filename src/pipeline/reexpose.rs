//! New exposures, sensors and noise from stored light.

use std::path::{Path, PathBuf};
use std::time::Instant;

use glam::DAffine3;

use super::camera::camera_of;
use super::chain::{Chain, Exposed, Optics, SensorColours, Settings};
use super::file_names::PART;
use super::monitor::{Event, Monitor};
use super::needs::Needs;
use super::output_folder::OutputFolder;
use super::results::{Carried, Frames, write_results};
use super::stored_light::StoredLight;
use crate::capture::{ExposureSettings, ExposureTime, StoredCapture, StoredReport, relative_path};
use crate::develop::SensorCalibration;
use crate::image::{Estimate, Planes};
use crate::integrator::WavelengthChoice;
use crate::io::linear_picture::{PictureLight, read_picture_light};
use crate::optics::{Camera, Focus, LensDescription};
use crate::report::{LensReport, LightReport, REPORT, Report, SCHEMA_VERSION, Timings, TracedReport};
use crate::sensor::{Exposure, PictureUnit, SensorModel, electron_rates, picture_electrons};
use crate::spectrum::illuminant;
use crate::units::{Decibels, Seconds};
use crate::{Error, Invalid, Result};
use photosite_core::{Remedy, Sandbox, memory};

/// Light that was traced before, with what is known of it, to be exposed again.
pub struct StoredRender {
    input: PathBuf,
    overrides: Vec<String>,
    stored: Stored,
    load_s: f64,
}

impl StoredRender {
    /// Reads a folder that a render has filled, or an EXR file from there: electrons serve any exposure with the sensor
    /// that they were counted for; irradiance serves any sensor. `overrides` change keys of its capture, `key=value`.
    /// Files that either names must lie in the sandbox.
    pub fn read(sandbox: &Sandbox, input: &Path, overrides: &[String]) -> Result<Self> {
        let start = Instant::now();
        let stored = Stored::read(sandbox, input, overrides)?;
        let load_s = start.elapsed().as_secs_f64();
        Ok(Self { input: input.to_owned(), overrides: overrides.to_vec(), stored, load_s })
    }

    /// Reads a picture of another program, whose numbers are light on the sensor as `scale` says. `overrides` change keys
    /// of a capture of defaults.
    pub fn of_picture(sandbox: &Sandbox, input: &Path, scale: &PictureScale, overrides: &[String]) -> Result<Self> {
        let start = Instant::now();
        let stored = Stored::of_picture(sandbox, input, scale, overrides)?;
        let load_s = start.elapsed().as_secs_f64();
        Ok(Self { input: input.to_owned(), overrides: overrides.to_vec(), stored, load_s })
    }

    /// Exposes and develops it into a folder, the report last, which is returned.
    pub fn expose_into(self, folder: &mut OutputFolder, monitor: &dyn Monitor) -> Result<Report> {
        let Self { input, overrides, stored, load_s } = self;
        let timings = Timings { load_s, ..Timings::default() };
        expose_into(stored, (&input, &overrides), folder, monitor, timings)
    }
}

fn expose_into(
    stored: Stored,
    (input, overrides): (&Path, &[String]),
    folder: &mut OutputFolder,
    monitor: &dyn Monitor,
    mut timings: Timings,
) -> Result<Report> {
    let Stored { capture, light, later, recorded, gains, calibration, traced } = stored;
    let start = Instant::now();
    let mut warnings = capture.warnings.clone();
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
    let settings = Settings::from(&capture);
    let colours = SensorColours::find(settings, &optics, &white, calibration.as_ref(), &mut warnings)?;
    let chain = Chain::new(settings, &optics, &colours, placed.as_ref().map(|(lens, camera)| (lens, camera)));
    warnings.extend(chain.picture_warnings());
    if let Some(recorded) = recorded.as_ref().filter(|r| r.sensor.pixel_pitch_m != capture.sensor.pixel_pitch_m) {
        warnings.push(other_pitch(&recorded.sensor, &capture.sensor));
    }
    if recorded.as_ref().is_some_and(|r| traced_for_other_filters(&traced, &r.sensor, &capture.sensor)) {
        warnings.push(
            "the light of each pixel was traced for its own filter (render.wavelengths = \"own-filter\"); with other filters \
             the picture is right on average, but noisier"
                .to_owned(),
        );
    }
    // What is asked for again as it was takes what automatic exposure found then, to the last bit.
    let same = recorded.is_some_and(|r| {
        let specimen = SensorModel { serial: capture.sensor.serial, ..r.sensor };
        specimen == capture.sensor && r.exposure.is_like(&capture.exposure)
    });
    let known_gains = gains.filter(|_| same);
    let expose = |light: StoredLight| -> Result<(Exposed, Vec<String>)> {
        match light {
            StoredLight::Electrons { electrons, collected } => {
                let at = capture.exposure.at(collected);
                let known = known_gains.map(|[gain, digital_gain]| Exposure { gain, digital_gain, ..at });
                Ok((chain.expose(electrons, collected, known)?, Vec::new()))
            }
            StoredLight::Irradiance { path, bands } => {
                let rates =
                    electron_rates(&bands, &capture.sensor, &white).map_err(|invalid| invalid.in_file(&path))?;
                let variance = Planes::zeros::<&str>(bands.width(), bands.height(), []);
                drop(bands);
                let light = Estimate { mean: rates.rates, variance };
                Ok((chain.expose(light, Seconds(1.0), None)?, rates.warnings))
            }
        }
    };
    if let Some(left) = memory::left() {
        let needs = Needs::new(settings);
        needs.check(left, needs.exposing())?;
    }
    let (exposed, more) = expose(light)?;
    let mut exposure = exposed.exposure;
    warnings.extend(more);
    warnings.extend(exposed.warning.clone());
    warnings.iter().for_each(|warning| monitor.report(Event::Warning(warning)));
    timings.expose_s = start.elapsed().as_secs_f64();
    let of = 1 + later.len() as u32;
    let frames = if of > 1 { Frames::One { number: 0, of } } else { Frames::All(capture.exposure.frames) };
    let mut carried = Carried::default();
    let first = write_results(monitor, &chain, exposed, frames, folder, &mut timings, &mut carried, |_, _| Ok(()))?;
    for (number, path) in (1..).zip(&later) {
        let start = Instant::now();
        let light = StoredLight::read(path)?;
        light.check(&capture)?;
        let (exposed, _) = expose(light)?;
        exposure = exposed.exposure;
        timings.expose_s += start.elapsed().as_secs_f64();
        let frames = Frames::One { number, of };
        write_results(monitor, &chain, exposed, frames, folder, &mut timings, &mut carried, |_, _| Ok(()))?;
    }

    let report = Report {
        schema_version: SCHEMA_VERSION,
        photosite_version: env!("CARGO_PKG_VERSION").to_owned(),
        input: relative_path(input, folder.path()),
        overrides: overrides.to_vec(),
        capture: capture.to_json(folder.path())?,
        fingerprint: None,
        seed: capture.seed,
        traced,
        sensor: chain.sensor_report(&exposure, &first),
        image: chain.image_report(),
        exposure: chain.exposure_report(&exposure, &carried.gains),
        files: folder.files(),
        sums: folder.sums().clone(),
        warnings,
        timings: Some(timings),
    };
    folder.write_report(&report)?;
    Ok(report)
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

/// What the numbers of a picture of another program are on the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureScale {
    /// What they count.
    pub unit: PictureUnit,
    /// How much of it a number of 1 is; of files of whole numbers, white.
    pub one: f64,
    /// Whether codes are in proportion to light, whatever the file says of them.
    pub is_linear: bool,
}

/// What is read: the capture as it shall be, and the light for it.
struct Stored {
    capture: StoredCapture,
    light: StoredLight,
    /// Where each picture of a series has light of its own: the files of those after the first.
    later: Vec<PathBuf>,
    /// The capture as it was rendered, where that is known.
    recorded: Option<StoredCapture>,
    /// The analogue and the digital gain that it was exposed with.
    gains: Option<[Decibels; 2]>,
    /// What was found of its sensor.
    calibration: Option<SensorCalibration>,
    /// What the report says of the light.
    traced: TracedReport,
}

impl Stored {
    fn read(sandbox: &Sandbox, input: &Path, overrides: &[String]) -> Result<Self> {
        let (folder, file) =
            if input.is_dir() { (input, None) } else { (input.parent().unwrap_or(Path::new("")), Some(input)) };
        let path = folder.join(REPORT);
        if file.is_none() && !path.exists() {
            let invalid = Invalid::new("", format!("holds no {REPORT}, so nothing tells how it was rendered"));
            let help = if folder.join(PART).exists() {
                "it is a part of a render: photosite merge makes a picture of all parts"
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
            let light = StoredLight::read(input)?;
            let capture = StoredCapture::of_picture(sandbox, input, light.resolution(), overrides)?;
            light.check(&capture)?;
            let (later, traced) = (Vec::new(), TracedReport::default());
            return Ok(Self { capture, light, later, recorded: None, gains: None, calibration: None, traced });
        };
        let recorded = StoredCapture::of_report(sandbox, &path, &stored, &[])?;
        let capture = StoredCapture::of_report(sandbox, &path, &stored, overrides)?;
        let report = stored.report;
        let moves = report.traced.camera.as_ref().is_some_and(|camera| camera.motion.is_some());
        same_times([&recorded, &capture].map(|c| (&c.sensor, &c.exposure)), moves)
            .map_err(|invalid| capture.source.error(invalid))?;
        same_cells(&recorded.sensor, &capture.sensor).map_err(|invalid| capture.source.error(invalid))?;
        let numbered = moves && recorded.exposure.frames > 1;
        let same_response = recorded.sensor.responses() == capture.sensor.responses();
        let file = match file {
            Some(file) if numbered => return Err(one_of_a_series(file)),
            Some(file) => file.to_owned(),
            None => light_file(folder, numbered, same_response)?,
        };
        let light = StoredLight::read(&file)?;
        let later = if numbered { 1..capture.exposure.frames } else { 1..1 };
        let later = later.map(|number| with_number(&file, number)).collect();
        if let (StoredLight::Electrons { .. }, false) = (&light, same_response) {
            return Err(no_irradiance(folder));
        }
        light.check(&capture)?;
        let gains = [report.exposure.gain_db, report.exposure.digital_gain_db].map(Decibels);
        Ok(Self {
            capture,
            light,
            later,
            recorded: Some(recorded),
            gains: Some(gains),
            calibration: report.sensor.calibration,
            traced: report.traced,
        })
    }
}

impl Stored {
    fn of_picture(sandbox: &Sandbox, input: &Path, scale: &PictureScale, overrides: &[String]) -> Result<Self> {
        if StoredLight::read(input).is_ok() {
            let invalid = Invalid::new("", "is stored light, and says itself what it holds");
            return Err(invalid.help("expose it without a unit").in_file(input));
        }
        let PictureLight { planes, assumed } = read_picture_light(input, scale.is_linear)?;
        let resolution = [planes.width(), planes.height()];
        let mut capture = StoredCapture::of_picture(sandbox, input, resolution, overrides)?;
        let found = picture_electrons(&planes, &capture.sensor, scale.unit, scale.one);
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
        let light = StoredLight::Electrons { electrons: Estimate { mean: found.electrons, variance }, collected };
        light.check(&capture)?;
        capture.warnings.push(format!("{assumed}; 1 is {}", in_words(scale)));
        capture.warnings.extend(found.warnings);
        let daylight = illuminant::d65();
        let scene_light = match scale.unit {
            PictureUnit::Lux => Some(LightReport::new(&daylight.scale(1.0 / f64::from(daylight.max())))),
            PictureUnit::Electrons | PictureUnit::FullWell | PictureUnit::Irradiance { .. } => None,
        };
        let traced = TracedReport { scene_light, ..TracedReport::default() };
        let later = Vec::new();
        Ok(Self { capture, light, later, recorded: None, gains: None, calibration: None, traced })
    }
}

/// What a number of 1 is.
fn in_words(scale: &PictureScale) -> String {
    let one = scale.one;
    match scale.unit {
        PictureUnit::Electrons => format!("{one} mean photo-electrons of a pixel in the exposure"),
        PictureUnit::FullWell => format!("{one} of the full well in the exposure"),
        PictureUnit::Lux => format!("{one} lx of D65 on the sensor, colours upsampled to spectra"),
        PictureUnit::Irradiance { wavelength_nm } => format!("{one} W/m² on the sensor at {wavelength_nm} nm"),
    }
}

/// Refuses times at which other light would have been seen. Where nothing moves, light is a rate, and every time and
/// row time is exact; what a moving camera saw is known for the rendered ones alone. A scanning sensor sees all lines
/// from one row in any case.
pub(super) fn same_times(
    recorded_and_wanted: [(&SensorModel, &ExposureSettings); 2],
    moves: bool,
) -> Result<(), Invalid> {
    let [was, is] = recorded_and_wanted.map(|(sensor, exposure)| (sensor.shutter, exposure));
    if was.0.scans() != is.0.scans() || moves && was.0 != is.0 {
        let message = "the rows of this sensor see light at other times than those of the rendered one";
        return Err(
            Invalid::new("sensor.shutter", message).help("keep its shutter as it was rendered, or render again")
        );
    }
    let help = "leave it as it was rendered, or render again";
    if moves && (was.1.time, was.1.frame_interval) != (is.1.time, is.1.frame_interval) {
        let key = if was.1.time == is.1.time { "exposure.frame_interval_s" } else { "exposure.time_s" };
        let message = "the camera moves, and what it sees at other times is not stored";
        return Err(Invalid::new(key, message).help(help));
    }
    if moves && is.1.bracket.is_some() {
        let message = "the camera moves, and the pictures of a bracket would differ";
        return Err(Invalid::new("exposure", message).help("remove the bracket"));
    }
    if moves && is.1.frames > was.1.frames {
        let message = format!("the camera moves, and the light of {} pictures is stored", was.1.frames);
        return Err(Invalid::new("exposure.frames", message).help("ask for as many or fewer, or render again"));
    }
    Ok(())
}

/// Refuses cells that would have collected light at other places, or where none was traced.
pub(super) fn same_cells(recorded: &SensorModel, sensor: &SensorModel) -> Result<(), Invalid> {
    let help = "keep it as it was rendered, or render again";
    if recorded.cells.shape != sensor.cells.shape {
        let message = "cells of this shape collect light at other places than those of the rendered sensor";
        return Err(Invalid::new("sensor.cells", message).help(help));
    }
    let [was, is] = [recorded, sensor].map(|sensor| sensor.cells.image_circle);
    let is_wider = was.is_some_and(|was| is.is_none_or(|is| is.radii_px.cmpgt(was.radii_px).any()));
    if is_wider {
        let message = "the picture was rendered for a smaller circle, and no light was traced beyond";
        return Err(Invalid::new("sensor.image_circle_mm", message).help(help));
    }
    Ok(())
}

/// `electrons-0000.exr` → `electrons-0007.exr`.
fn with_number(first: &Path, number: u32) -> PathBuf {
    let name = first.file_name().unwrap_or_default().to_string_lossy();
    first.with_file_name(name.replace("-0000", &format!("-{number:04}")))
}

fn one_of_a_series(file: &Path) -> Error {
    let invalid = Invalid::new("", "is one of a series of pictures, each of which has light of its own");
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
        let invalid = Invalid::new("", "holds no stored light: neither electrons.exr nor irradiance.exr");
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
