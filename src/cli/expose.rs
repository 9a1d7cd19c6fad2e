//! `photosite expose`: new exposures, sensors and noise from stored light.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use glam::DAffine3;
use photosite::image::Estimate;
use photosite::io::capture::{StoredCapture, StoredReport};
use photosite::optics::{Camera, Focus, LensDescription, PixelGrid};
use photosite::sensor::{SensorModel, electron_rates};
use photosite::spectrum::{Spectrum, illuminant};
use photosite::units::Seconds;
use photosite::{Error, Invalid, Result};
use serde::Deserialize;
use serde_json::{Map, Value};

use super::chain::{Chain, Optics};
use super::output_folder::{OutputFolder, REPORT};
use super::report::{LightReport, Report, Timings, TracedReport};
use super::results::write_results;
use super::run_args::RunArgs;
use super::stored_light::StoredLight;
use super::{print_json, rounded};

/// Expose stored light again: another time, gain, temperature, seed or sensor.
///
/// INPUT is a folder that `photosite render` filled, or an EXR file from there. Electrons serve any exposure with the
/// sensor that they were counted for; irradiance serves any sensor.
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
    let Stored { capture, light, recorded, report, .. } = stored;
    let mut timings = Timings { load_s: start.elapsed().as_secs_f64(), ..Timings::default() };
    let folder = output.clone().unwrap_or_else(|| default_folder(&args.input));
    refuse_own_folder(&folder, &args.input)?;
    let mut folder = OutputFolder::claim(&folder, *force)?;

    let start = Instant::now();
    let mut warnings = Vec::new();
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
    let mut chain = Chain::new((&capture).into(), optics, &white, &mut warnings)?;
    if let Some((lens, camera)) = &placed {
        chain = chain.with_lens(lens, camera, &mut warnings);
    }
    if let Some(recorded) = recorded.as_ref().filter(|r| r.sensor.pixel_pitch_m != capture.sensor.pixel_pitch_m) {
        warnings.push(other_pitch(&recorded.sensor, &capture.sensor));
    }
    let exposed = match light {
        StoredLight::Electrons { electrons, collected } => {
            // What is asked for again as it was takes the time that automatic exposure found then, to the last bit.
            let same = recorded.is_some_and(|r| r.sensor == capture.sensor && r.exposure.is_like(&capture.exposure));
            chain.expose(electrons, collected, same.then_some(collected))?
        }
        StoredLight::Irradiance { path, bands } => {
            let rates = electron_rates(&bands, &capture.sensor, &white).map_err(|invalid| invalid.in_file(&path))?;
            warnings.extend(rates.warnings);
            let variance = photosite::image::Planes::zeros::<&str>(bands.width(), bands.height(), []);
            drop(bands);
            chain.expose(Estimate { mean: rates.rates, variance }, Seconds(1.0), None)?
        }
    };
    if !quiet {
        warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
    }
    timings.expose_s = start.elapsed().as_secs_f64();
    let first = write_results(&chain, &exposed, &mut folder, &mut timings, |_| Ok(()))?;

    let report = Report {
        photosite_version: env!("CARGO_PKG_VERSION"),
        input: args.input.display().to_string(),
        overrides,
        capture: capture.to_json(folder.path())?,
        seed: capture.seed,
        traced: report,
        sensor: chain.sensor_report(&exposed, &first),
        exposure: chain.exposure_report(&exposed),
        files: folder.files(),
        warnings,
        timings,
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
    let sensor = &recorded.sensor;
    let resolution = sensor.resolution.map(|n| u32::try_from(n).expect("resolutions are checked when they are read"));
    let grid = PixelGrid { resolution, pitch_m: sensor.pixel_pitch_m };
    // Where the camera stands makes no difference to what its lens does.
    let camera = Camera::new(&lens, &grid, DAffine3::IDENTITY, f64::NAN).ok()?;
    Some((lens, camera))
}

/// What is read: the capture as it shall be, and the light for it.
struct Stored {
    capture: StoredCapture,
    light: StoredLight,
    /// The capture as it was rendered, where that is known.
    recorded: Option<StoredCapture>,
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
            let help = "give a folder that photosite render filled, or an electrons.exr or irradiance.exr";
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
            return Ok(Self { capture, light, recorded: None, report: Map::new() });
        };
        let recorded = StoredCapture::of_report(&path, &report, &[])?;
        let capture = StoredCapture::of_report(&path, &report, overrides)?;
        let same_response = recorded.sensor.responses() == capture.sensor.responses();
        let light = match file {
            Some(file) => StoredLight::read(file)?,
            None => StoredLight::read(&light_file(folder, same_response)?)?,
        };
        if let (StoredLight::Electrons { .. }, false) = (&light, same_response) {
            return Err(no_irradiance(folder));
        }
        light.check(&capture)?;
        let report = report.values.into_iter().filter(|(key, _)| TracedReport::KEYS.contains(&key.as_str())).collect();
        Ok(Self { capture, light, recorded: Some(recorded), report })
    }
}

/// The file in a folder that serves: electrons where they are counted for the sensor, else irradiance.
fn light_file(folder: &Path, same_response: bool) -> Result<PathBuf> {
    let [electrons, irradiance] = ["electrons.exr", "irradiance.exr"].map(|name| folder.join(name));
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
