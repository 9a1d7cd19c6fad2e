//! `photosite expose`: new exposures, sensors and noise from stored light, and from images of other programs.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::arguments::positive;
use super::log::say;
use super::print::{print_json, rounded};
use super::run_args::{OutcomeArgs, RunArgs};
use photosite_capture::FileKind;
use photosite_capture::report::REPORT;
use photosite_core::sandbox::trust;
use photosite_core::{Error, Result, Sandbox};
use photosite_pipeline::{DeviceChoice, ImageScale, Light, OutputFolder};
use photosite_sensor::ImageUnit;

const EXAMPLES: &str = "\
Examples:
  photosite expose out --set exposure.iso=3200 -o dark
  photosite expose photo.exr --unit lux --one 100 --set exposure.time_s=0.01";

/// Expose stored light again, with any exposure or sensor.
///
/// INPUT is a folder that `photosite render` filled, or an EXR file from such a folder. Electrons serve any
/// exposure with the sensor that they were counted for; irradiance serves any sensor. Light seen by a moving camera
/// keeps the exposure time and shutter that it was rendered with.
///
/// With --unit, INPUT is an image by any program (EXR, HDR, TIFF, PNG, JPEG, PGM, PPM or NPY), which becomes as large
/// as the sensor. Its pixel values are taken as light on the sensor, where --one says how much a value of 1 is;
/// integers are first divided by white, and codes are decoded as the file says, or else as sRGB. Electrons and full
/// wells are those of the exposure; R, G and B are those of the sensor's channels of that name; lux is for colours,
/// which become spectra under D65.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct ExposeArgs {
    /// A folder with capture.json, a file electrons.exr or irradiance.exr, or with --unit any image.
    input: PathBuf,
    #[command(flatten)]
    common: RunArgs,
    /// Unit of the values of an image on the sensor.
    #[arg(long, value_enum)]
    unit: Option<Unit>,
    /// Amount of the unit that a value of 1 is, or white where the file has whole numbers.
    #[arg(long, value_name = "X", requires = "unit", default_value_t = 1.0, allow_negative_numbers = true, value_parser = positive)]
    one: f64,
    /// Wavelength of an irradiance.
    #[arg(long, value_name = "NM", requires = "unit", required_if_eq("unit", "irradiance"))]
    wavelength_nm: Option<f64>,
    /// The codes of the image are proportional to light, whatever its file says of them.
    #[arg(long, requires = "unit")]
    linear: bool,
    /// Device that exposes and develops: cpu; gpu, the first graphics card; gpu:1 or gpu:NAME, one of `photosite
    /// devices`; auto, a graphics card where there is one. What a card lacks of a sensor, the processor does.
    #[arg(long, value_name = "DEVICE", default_value = "cpu")]
    device: DeviceChoice,
    #[command(flatten)]
    outcome: OutcomeArgs,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Unit {
    /// Mean photo-electrons of a pixel in the exposure.
    Electrons,
    /// Parts of the full well in the exposure.
    FullWell,
    /// Illuminance, lx: linear sRGB as multiples of D65.
    Lux,
    /// Irradiance at one wavelength, W/m².
    Irradiance,
}

impl ExposeArgs {
    /// Unit and scale of an image's values, where stated.
    fn scale(&self) -> Result<Option<ImageScale>> {
        let Some(unit) = self.unit else { return Ok(None) };
        let unit = match (unit, self.wavelength_nm) {
            (Unit::Irradiance, Some(wavelength_nm)) => ImageUnit::Irradiance { wavelength_nm },
            (Unit::Electrons, None) => ImageUnit::Electrons,
            (Unit::FullWell, None) => ImageUnit::FullWell,
            (Unit::Lux, None) => ImageUnit::Lux,
            (Unit::Electrons | Unit::FullWell | Unit::Lux | Unit::Irradiance, _) => {
                return Err(Error::Usage {
                    message: "--wavelength-nm goes with --unit irradiance alone".to_owned(),
                    help: Some("remove it, or the other unit".into()),
                });
            }
        };
        Ok(Some(ImageScale { unit, one: self.one, is_linear: self.linear }))
    }
}

pub(super) fn run(args: &ExposeArgs, sandbox: &Sandbox) -> Result<()> {
    let OutcomeArgs { force, quiet, json } = &args.outcome;
    let overrides = args.common.overrides();
    let light = match args.scale()? {
        None => {
            // Images are told what they lack.
            let images = [FileKind::Light, FileKind::PixelValues, FileKind::Image];
            FileKind::expect(&args.input, &images, "a folder of a render or stored light (.exr)")?;
            Light::read(sandbox, &args.input, &overrides)?
        }
        Some(_) if args.input.is_dir() => {
            return Err(Error::Usage {
                message: format!(
                    "{} is a folder of stored light, whose files state what they contain",
                    args.input.display()
                ),
                help: Some("remove --unit, or give an image".into()),
            });
        }
        Some(scale) => Light::of_image(sandbox, &args.input, &scale, &overrides)?,
    };
    let light = light.on_card(args.device.sensor_card(&args.outcome.monitor())?);
    let folder = args.common.output.clone().unwrap_or_else(|| default_folder(&args.input));
    trust(&folder);
    refuse_own_folder(&folder, &args.input)?;
    let mut folder = OutputFolder::claim(&folder, *force)?;
    let report = light.write_into(&mut folder, &args.outcome.monitor())?;
    if *json {
        return print_json(&report);
    }
    if !quiet {
        let time_ms = rounded(report.exposure.time_s * 1e3, 4);
        say!("exposed for {time_ms} ms; wrote {}, {REPORT} to {}", report.files.join(", "), folder.path().display());
    }
    Ok(())
}

/// Default output folder: `cornell-box` → `cornell-box-exposed`, `cornell-box/electrons.exr` → `electrons-exposed`.
fn default_folder(input: &Path) -> PathBuf {
    // A folder may be given as `.` or `..`.
    let whole = input.canonicalize();
    let name = if input.is_dir() { whole.as_deref().unwrap_or(input).file_name() } else { input.file_stem() };
    PathBuf::from(format!("{}-exposed", name.unwrap_or_default().to_string_lossy()))
}

/// Refuses the folder of the light as output, since results would replace it.
fn refuse_own_folder(output: &Path, input: &Path) -> Result<()> {
    let folder = if input.is_dir() { Some(input) } else { input.parent() };
    let folder = folder.map(|folder| if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
    let (Ok(output), Some(Ok(folder))) = (output.canonicalize(), folder.map(Path::canonicalize)) else { return Ok(()) };
    if output != folder || !folder.join(REPORT).exists() {
        return Ok(());
    }
    Err(Error::Usage {
        message: format!("the results would take the place of the light in {}", folder.display()),
        help: Some("choose another folder with -o".into()),
    })
}
