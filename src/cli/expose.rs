//! `photosite expose`: new exposures, sensors and noise from stored light.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use glam::DAffine3;
use photosite::develop::SensorCalibration;
use photosite::image::Estimate;
use photosite::integrator::WavelengthChoice;
use photosite::io::capture::{REPORT, StoredCapture, StoredReport, relative_path};
use photosite::optics::{Camera, Focus, LensDescription};
use photosite::sensor::{Exposure, SensorModel, electron_rates};
use photosite::spectrum::{Spectrum, illuminant};
use photosite::units::{Decibels, Seconds};
use photosite::{Error, Invalid, Result};
use serde::Deserialize;
use serde_json::{Map, Value};

use super::chain::{Chain, Exposed, Optics};
use super::output_folder::{OutputFolder, PART};
use super::render::camera_of;
use super::report::{LightReport, Report, Timings, TracedReport};
use super::results::{Frames, write_results};
use super::run_args::RunArgs;
use super::stored_light::StoredLight;
use super::{print_json, rounded};

/// Expose stored light again: another time, gain, temperature, seed or sensor.
///
/// INPUT is a folder that `photosite render` filled, or an EXR file from there. Electrons serve any exposure with the
/// sensor that they were counted for; irradiance serves any sensor. Light that a moving camera saw is that of its
/// exposure time and shutter, which stay as they were rendered.
#[derive(Args)]
pub(super) struct ExposeArgs {
    /// A folder with capture.json, or a file electrons.exr or irradiance.exr.
    input: PathBuf,
    #[command(flatten)]
    common: RunArgs,
}

pub(super) fn run(args: &ExposeArgs) -> Result<()> {
    let RunArgs { output, quiet, json, force, .. } = &args.common;
    args.common.start_threads()?;
    let start = Instant::now();
    let overrides = args.common.overrides();
    let stored = Stored::read(&args.input, &overrides)?;
    let Stored { capture, light, later, recorded, gains, calibration, report } = stored;
    let mut timings = Timings { load_s: start.elapsed().as_secs_f64(), ..Timings::default() };
    let folder = output.clone().unwrap_or_else(|| default_folder(&args.input));
    refuse_own_folder(&folder, &args.input)?;
    let mut folder = OutputFolder::claim(&folder, *force)?;

    let start = Instant::now();
    let mut warnings = capture.warnings.clone();
    let white = match scene_light(&report) {
        Some(light) => light,
        None => {
            warnings.push("nothing tells what light the scene has, so the white balance is that of D65".to_owned());
            illuminant::d65().clone()
        }
    };
    let lens = |key: &str| report.get("lens").and_then(|lens| lens[key].as_f64());
    let optics = Optics {
        f_number: lens("f_number"),
        focal_length_m: lens("focal_length_mm").map(|mm| mm / 1e3),
        transmittance: capture.lens.transmittance.clone(),
    };
    let placed = recorded.as_ref().and_then(|recorded| placed_lens(recorded, &report));
    let mut chain = Chain::new((&capture).into(), optics, &white, calibration.as_ref(), &mut warnings)?;
    if let Some((lens, camera)) = &placed {
        chain = chain.with_lens(lens, camera, &mut warnings);
    }
    if let Some(recorded) = recorded.as_ref().filter(|r| r.sensor.pixel_pitch_m != capture.sensor.pixel_pitch_m) {
        warnings.push(other_pitch(&recorded.sensor, &capture.sensor));
    }
    if recorded.as_ref().is_some_and(|r| traced_for_other_filters(&report, &r.sensor, &capture.sensor)) {
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
                let variance = photosite::image::Planes::zeros::<&str>(bands.width(), bands.height(), []);
                drop(bands);
                let light = Estimate { mean: rates.rates, variance };
                Ok((chain.expose(light, Seconds(1.0), None)?, rates.warnings))
            }
        }
    };
    let (exposed, more) = expose(light)?;
    let mut exposure = exposed.exposure;
    warnings.extend(more);
    warnings.extend(exposed.warning.clone());
    if !quiet {
        warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
    }
    timings.expose_s = start.elapsed().as_secs_f64();
    let of = 1 + later.len() as u32;
    let frames = if of > 1 { Frames::One { number: 0, of } } else { Frames::All(capture.exposure.frames) };
    let mut left = None;
    let first = write_results(&chain, exposed, frames, &mut folder, &mut timings, &mut left, |_, _| Ok(()))?;
    for (number, path) in (1..).zip(&later) {
        let start = Instant::now();
        let light = StoredLight::read(path)?;
        light.check(&capture)?;
        let (exposed, _) = expose(light)?;
        exposure = exposed.exposure;
        timings.expose_s += start.elapsed().as_secs_f64();
        let frames = Frames::One { number, of };
        write_results(&chain, exposed, frames, &mut folder, &mut timings, &mut left, |_, _| Ok(()))?;
    }

    let report = Report {
        photosite_version: env!("CARGO_PKG_VERSION"),
        input: relative_path(&args.input, folder.path()),
        overrides,
        capture: capture.to_json(folder.path())?,
        seed: capture.seed,
        traced: report,
        sensor: chain.sensor_report(&exposure, &first),
        image: chain.image_report(),
        exposure: chain.exposure_report(&exposure),
        files: folder.files(),
        warnings,
        timings: Some(timings),
    };
    folder.write_report(&report)?;
    if *json {
        return print_json(&report);
    }
    if !quiet {
        let time_ms = rounded(report.exposure.time_s * 1e3, 4);
        eprintln!(
            "exposed for {time_ms} ms; wrote {}, {REPORT} to {}",
            report.files.join(", "),
            folder.path().display()
        );
    }
    Ok(())
}

/// The lens as the report has it, so that raw files tell of its falloff and distortion as those of the render do.
/// `None` where the report does not say enough.
fn placed_lens(recorded: &StoredCapture, report: &Map<String, Value>) -> Option<(LensDescription, Camera)> {
    let said = report.get("lens")?;
    // `null` stands for infinity.
    let focus = said.get("focus_distance_m")?.as_f64().map_or(Focus::Infinity, Focus::Distance);
    let focal_length_m = said["focal_length_mm"].as_f64()? / 1e3;
    let lens = LensDescription { focus, focal_length_m, ..recorded.lens.clone() };
    // Where the camera stands makes no difference to what its lens does.
    let camera = camera_of(&lens, &recorded.sensor, DAffine3::IDENTITY, f64::NAN).ok()?;
    Some((lens, camera))
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
    /// What the report says of the light: [`TracedReport::KEYS`].
    report: Map<String, Value>,
}

impl Stored {
    fn read(input: &Path, overrides: &[String]) -> Result<Self> {
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
        let report = match file {
            None => Some(StoredReport::read(&path)?),
            // A file counts as part of the render if the report lists it.
            Some(file) => StoredReport::read(&path).ok().filter(|report| lists(report, file)),
        };
        let Some(report) = report else {
            let light = StoredLight::read(input)?;
            let capture = StoredCapture::of_picture(input, light.resolution(), overrides)?;
            light.check(&capture)?;
            let (later, report) = (Vec::new(), Map::new());
            return Ok(Self { capture, light, later, recorded: None, gains: None, calibration: None, report });
        };
        let recorded = StoredCapture::of_report(&path, &report, &[])?;
        let capture = StoredCapture::of_report(&path, &report, overrides)?;
        let moves = report.values.get("camera").is_some_and(|camera| !camera["motion"].is_null());
        same_times(&recorded, &capture, moves).map_err(|invalid| capture.source.error(invalid))?;
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
        let gain = |key: &str| report.values.get("exposure").and_then(|exposure| exposure[key].as_f64()).map(Decibels);
        let gains = gain("gain_db").zip(gain("digital_gain_db")).map(|(analogue, digital)| [analogue, digital]);
        let stored = report.values.get("sensor").and_then(|sensor| sensor.get("calibration"));
        let calibration = stored.and_then(|stored| SensorCalibration::deserialize(stored).ok());
        let report = report.values.into_iter().filter(|(key, _)| TracedReport::KEYS.contains(&key.as_str())).collect();
        Ok(Self { capture, light, later, recorded: Some(recorded), gains, calibration, report })
    }
}

/// Refuses times at which other light would have been seen. Where nothing moves, light is a rate, and every time and row
/// time is exact; what a moving camera saw is known for the rendered ones alone. A scanning sensor sees all lines from one
/// row in any case.
fn same_times(recorded: &StoredCapture, capture: &StoredCapture, moves: bool) -> Result<(), Invalid> {
    let [was, is] = [recorded, capture].map(|c| (c.sensor.shutter, &c.exposure));
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
    let help = "expose irradiance.exr instead, which photosite render writes with --set output.irradiance=true";
    Invalid::new("", message).help(help).in_file(folder)
}

fn lists(report: &StoredReport, file: &Path) -> bool {
    let name = file.file_name().map(|name| name.to_string_lossy());
    let files = report.values.get("files").and_then(Value::as_array);
    files.into_iter().flatten().any(|listed| listed.as_str() == name.as_deref())
}

/// The spectrum that counts as white, where the report tells it.
fn scene_light(report: &Map<String, Value>) -> Option<Spectrum> {
    LightReport::deserialize(report.get("scene_light")?).ok()?.spectrum()
}

/// Whether light is that of pixels whose paths have the wavelengths of their own filters, which are others now.
fn traced_for_other_filters(report: &Map<String, Value>, recorded: &SensorModel, sensor: &SensorModel) -> bool {
    let own_filter = WavelengthChoice::OwnFilter.name();
    let for_own = report.get("render").is_some_and(|render| render["wavelengths"] == own_filter);
    let same_filters = || recorded.cfa == sensor.cfa && recorded.responses() == sensor.responses();
    for_own && recorded.cfa.is_mosaic() && !same_filters()
}

fn other_pitch(recorded: &SensorModel, sensor: &SensorModel) -> String {
    let um = |sensor: &SensorModel| sensor.pixel_pitch_m.map(|m| rounded(m * 1e6, 6).to_string()).join(" × ");
    format!(
        "the light was traced for pixels of {} µm; those of {} µm see the same picture, as behind a lens whose focal length \
         grows with them, at the same f-number",
        um(recorded),
        um(sensor)
    )
}

/// `cornell-box` → `cornell-box-exposed`, `cornell-box/electrons.exr` → `electrons-exposed`.
fn default_folder(input: &Path) -> PathBuf {
    // A folder may be given as `.` or `..`.
    let whole = input.canonicalize();
    let name = if input.is_dir() { whole.as_deref().unwrap_or(input).file_name() } else { input.file_stem() };
    PathBuf::from(format!("{}-exposed", name.unwrap_or_default().to_string_lossy()))
}

/// Results in the folder of the light would take its place.
fn refuse_own_folder(output: &Path, input: &Path) -> Result<()> {
    let folder = if input.is_dir() { Some(input) } else { input.parent() };
    let folder = folder.map(|folder| if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
    let (Ok(output), Some(Ok(folder))) = (output.canonicalize(), folder.map(Path::canonicalize)) else { return Ok(()) };
    if output != folder || !folder.join(REPORT).exists() {
        return Ok(());
    }
    Err(Error::Usage {
        message: format!("the results would take the place of the light in {}", folder.display()),
        help: Some("choose another folder with -o".to_owned()),
    })
}
